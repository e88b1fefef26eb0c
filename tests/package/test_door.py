"""Every public call ends in a result or in one sentence: what stands behind the door, and what passes it."""

from __future__ import annotations

import copy
import datetime
import functools
import inspect
import math
import pickle
import traceback
import types
import typing
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

import attrs
import numpy as np
import pytest

import roughcontact as rc
from roughcontact import extrapolation, faces, reference, results, slabs, solving
from roughcontact import typing as types_of_rc
from roughcontact.errors import door
from scenes import make_problem

GRID = rc.Grid((8, 8), 1e-3)
WAVE = rc.WavySurface(1e-6, 1e-3)
STEEL = rc.Elastic(210e9, 0.3)
PUBLIC = {f"rc.{name}": getattr(rc, name) for name in rc.__all__}
for module in (faces, results, slabs, solving, types_of_rc):
    PUBLIC |= {f"{module.__name__}.{name}": getattr(module, name) for name in module.__all__}
for module in (reference, extrapolation):
    own = {k: v for k, v in vars(module).items() if getattr(v, "__module__", "").startswith(module.__name__)}
    PUBLIC |= {f"{module.__name__}.{name}": value for name, value in own.items() if name[0] != "_"}
# Aliases of array types are not ours.
PUBLIC = {name: value for name, value in PUBLIC.items() if getattr(value, "__module__", "").startswith("roughcontact")}


REGISTRIES = [value for value in PUBLIC.values() if isinstance(value, type(rc.kernels))]


problem = partial(make_problem, WAVE, STEEL, grid=GRID)


def is_guarded(function):
    return getattr(function, "__code__", None) in GUARDS


def sample(x: int) -> int:
    return x


GUARDS = {door.guarded(sample).__code__}


def functions_of(cls):
    """Return the functions that make up the public operations of a class and of its bases in this package."""
    for base in cls.__mro__:
        if not base.__module__.startswith("roughcontact"):
            continue
        for name, member in vars(base).items():
            if name.startswith("_") and name not in door._OPERATIONS:
                continue
            if getattr(member, "__isabstractmethod__", False):
                continue
            match member:
                case classmethod() | staticmethod():
                    yield name, member.__func__
                case property():
                    yield name, member.fget
                case functools.cached_property():
                    yield name, member.func
                case types.FunctionType():
                    yield name, member


@pytest.mark.parametrize("name", PUBLIC)
def test_every_public_call_stands_behind_the_door(name):
    value = PUBLIC[name]
    # A context manager only runs the user's own block.
    if inspect.isgeneratorfunction(inspect.unwrap(value)):
        return
    if inspect.isfunction(value):
        assert is_guarded(value), f"{name} lacks @guarded"
        return
    cls = value if isinstance(value, type) else type(value)
    if issubclass(cls, (BaseException, rc.Boundary, rc.Status)) or cls.__module__ == "roughcontact.errors":
        return
    for method, function in functions_of(cls):
        assert is_guarded(function), f"{name}.{method} is not guarded"


class Shifted(rc.WavySurface):
    """A user's class, made by the inherited constructor."""


class Failing(rc.Surface):
    def heights(self, grid):
        return {}["no such key"]


@attrs.frozen
class Step:
    height: float = attrs.field(validator=attrs.validators.gt(0.0))


@attrs.frozen
class Choice:
    of: int = attrs.field(validator=attrs.validators.in_([1, 2]))


class Stepped(rc.Surface):
    def heights(self, grid):
        return np.full(grid.shape, Step(-1.0).height)


class Wrong(rc.Surface):
    def heights(self):
        return np.zeros((8, 8))


class OutOfRange(rc.Surface):
    def heights(self, grid):
        return np.full(grid.shape, Choice(3).of)


class Nameless:
    def __repr__(self):
        raise RuntimeError("no name")


class Wordless(Exception):
    def __str__(self):
        raise RuntimeError("no words")


def solve(**options):
    return problem().solve(pressure=1e6, **options)


def of(surface):
    return rc.ContactProblem(rc.Body(surface, STEEL), grid=GRID)


BAD_CALLS = {
    "an argument omitted": (lambda: rc.Grid((4, 4)), rc.InputError, "Grid(shape, size): missing"),
    "an argument too many": (lambda: rc.Grid((4, 4), 1.0, foo=2), rc.InputError, "'foo'"),
    "an argument of another type": (
        lambda: WAVE.heights(5),
        rc.InputError,
        "grid= of WavySurface.heights must be of type Grid",
    ),
    "a load without its name": (
        lambda: problem().solve(1e6),
        rc.InputError,
        "ContactProblem.solve takes what was given as 1000000.0 by name: write pressure=1000000.0, or force=",
    ),
    "a number of numpy": (lambda: rc.Elastic(np.float64(0.0), 0.3), rc.InputError, "but got 0.0."),
    "an item that is not there": (lambda: problem().sweep(pressure=[1e6])[9], IndexError, "whole number from 0 to 0"),
    "a path that is a number": (lambda: rc.read_surface(5), rc.InputError, "a str or a path"),
    "an executor that is a number": (
        lambda: rc.Study(problems=problem(), pressure=[1e6]).run("/tmp", executor=5),
        rc.InputError,
        "The executor must be",
    ),
    "a callback that is a number": (lambda: solve(on_step=5), rc.InputError, "on_step="),
    "a callback without arguments": (
        lambda: solve(on_step=lambda: None),
        rc.InputError,
        "a function of 1 argument, step",
    ),
    "a choice that is a number": (lambda: solve(throw=1), rc.InputError, "throw= must be True or False"),
    "a word that is none": (lambda: rc.Boundary("open"), rc.InputError, "'free'"),
    "a value without a name": (lambda: rc.Elastic(Nameless(), 0.3), rc.InputError, "a Nameless"),
    "a folder that cannot be": (
        lambda: rc.Study(problems=problem(), pressure=[1e6]).run(Path(__file__) / "x"),
        rc.RoughContactError,
        repr(str(Path(__file__) / "x")),
    ),
    "a plug-in part that fails": (
        lambda: of(Failing()),
        rc.UnexpectedError,
        "ContactProblem failed in Failing.heights",
    ),
    "a plug-in part of wrong signature": (lambda: of(Wrong()), rc.InputError, "Wrong.heights"),
    "a number that cannot divide": (
        lambda: rc.Exponential(0.05, 1e-9).scaled(0.0, 0.0),
        rc.InputError,
        "Exponential.scaled",
    ),
    "a number beyond float64": (lambda: rc.Exponential(0.05, 1e-9).scaled(10**400, 1.0), rc.InputError, "scaled"),
    "a plug-in part that attrs refuses": (
        lambda: of(Stepped()),
        rc.InputError,
        "ContactProblem failed in Stepped.heights: 'height' must be > 0.0",
    ),
    "a choice that attrs refuses": (lambda: of(OutOfRange()), rc.InputError, "'of' must be in [1, 2] (got 3)."),
    "what holds no numbers": (
        lambda: solving.GridLevel(object(), 1, 2),
        rc.InputError,
        "shape= of GridLevel must be of type",
    ),
    "a key that cannot be": (lambda: rc.kernels[[]], rc.InputError, "must be of type str"),
}


@pytest.mark.parametrize(("call", "kind", "words"), BAD_CALLS.values(), ids=BAD_CALLS)
def test_a_bad_call_is_answered_by_a_sentence(call, kind, words):
    with pytest.raises(kind) as caught:
        call()
    assert isinstance(caught.value, rc.RoughContactError)
    assert words in str(caught.value)
    assert str(caught.value).endswith(".")


@pytest.mark.parametrize(
    ("raised", "kind"),
    [
        (MemoryError(), rc.OutOfMemory),
        (OSError(28, "No space left on device", "x.npz"), rc.FileError),
        (ModuleNotFoundError("No module named 'pint'", name="pint"), rc.MissingPackage),
        (OverflowError("too large"), rc.UnexpectedError),
        (RecursionError("too deep"), rc.UnexpectedError),
        (Wordless(), rc.UnexpectedError),
    ],
)
def test_what_no_check_has_foreseen_is_translated_and_chained(monkeypatch, raised, kind):
    def fail(*_, **__):
        raise raised

    monkeypatch.setattr("roughcontact._solve.problem.run.certify", fail)
    with pytest.raises(kind, match=r"ContactProblem\.solve .*\.$") as caught:
        solve()
    assert caught.value.__cause__ is raised
    assert isinstance(raised, OSError) == isinstance(caught.value, OSError)


def frames_of(error):
    return [frame.f_code.co_filename for frame, _ in traceback.walk_tb(error.__traceback__)]


def test_a_traceback_shows_what_was_called_and_not_the_door(monkeypatch):
    def fail(*_, **__):
        return {}["no such key"]

    monkeypatch.setattr("roughcontact._solve.solvers.conjugate.refinement.PressureRefinement.run", fail)
    with pytest.raises(rc.UnexpectedError) as caught:
        solve()
    frames = frames_of(caught.value.__cause__)
    # Pytest's own frames stand between the call and this test; none of the package does.
    assert all(name == __file__ for name in frames_of(caught.value))
    assert frames[0].endswith("problem.py")
    assert frames[-1] == __file__
    assert door.__file__ not in frames
    with pytest.raises(rc.InputError) as refused:
        of(Stepped())
    assert door.__file__ not in frames_of(refused.value)


@pytest.mark.parametrize("error", [KeyError("k"), AttributeError("no"), MemoryError()])
def test_what_fails_in_a_property_is_answered_by_a_sentence_that_names_it(monkeypatch, error):
    def fail(*_, **__):
        raise error

    solution = solve()
    monkeypatch.setattr("roughcontact._solve.solution.fields.find_patches", fail)
    with pytest.raises(rc.RoughContactError, match=r"ContactSolution\.patches"):
        _ = solution.patches
    assert not hasattr(solution, "no_such_attribute")


@pytest.mark.parametrize("raised", [ValueError("mine"), KeyboardInterrupt(), SystemExit(3), StopIteration()])
def test_what_a_callback_raises_reaches_the_user_as_it_is(raised):
    def stop(step):
        raise raised

    with pytest.raises(type(raised)) as caught:
        solve(on_step=stop)
    assert caught.value is raised


def test_a_call_from_a_callback_is_answered_by_a_sentence():
    def ask(step):
        WAVE.heights(5)

    with pytest.raises(rc.InputError, match=r"WavySurface\.heights"):
        solve(on_step=ask)


def test_every_thread_has_its_own_door():
    def ask(step):
        with ThreadPoolExecutor(1) as pool:
            pool.submit(WAVE.heights, 5).result()

    with pytest.raises(rc.InputError, match=r"WavySurface\.heights"):
        solve(on_step=ask)


def test_the_door_stays_closed_after_an_error():
    for _ in range(2):
        with pytest.raises(rc.InputError):
            WAVE.heights(5)


def test_guarded_classes_and_functions_stay_what_they_were():
    assert list(inspect.signature(rc.Grid).parameters) == ["shape", "size"]
    assert "problem" in inspect.signature(rc.extrapolate).parameters
    assert rc.extrapolate.__doc__
    assert rc.Grid.cells.__doc__ == "Number of cells."
    for value in (GRID, WAVE, rc.extrapolate, rc.match):
        assert pickle.loads(pickle.dumps(value)) == value
        assert copy.copy(value) == value
    assert Shifted(1e-6, 1e-3).heights(GRID).shape == (8, 8)
    assert not hasattr(problem(), "no_such_attribute")
    assert typing.get_type_hints(rc.Grid.matches)["other"] is rc.Grid


@pytest.mark.parametrize("ask", [lambda one, path: one.gradient("area"), lambda one, path: one.save(path)])
def test_a_warning_points_to_the_line_of_the_caller(ask, tmp_path):
    contact = rc.ContactProblem(rc.Body(Shifted(1e-6, 1e-3), STEEL), grid=GRID, boundary="periodic")
    solution = contact.solve(pressure=1e6)
    with pytest.warns(UserWarning, match="even its sign|must be registered") as caught:
        ask(solution, tmp_path / "x.npz")
    assert {one.filename for one in caught} == {__file__}


@pytest.mark.parametrize("registry", REGISTRIES, ids=lambda one: one.kind)
def test_what_a_registry_loads_stands_behind_the_door(registry):
    for name in registry:
        cls = registry[name]
        if cls.__module__.partition(".")[0] == "roughcontact":
            for method, function in functions_of(cls):
                assert is_guarded(function), f"{name}.{method} is not guarded"


def test_a_wrong_call_of_a_reader_or_a_writer_is_answered_by_a_sentence():
    for registry, method in ((rc.readers, "read"), (rc.writers, "write")):
        for name in registry:
            if registry[name].__module__.partition(".")[0] == "roughcontact":
                with pytest.raises(rc.RoughContactError):
                    getattr(registry.create(name), method)()


NONSENSE = {
    "a date": datetime.date(2020, 1, 1),
    "texts": np.full((2, 2), "5"),
    "numbers": np.zeros((3, 3, 3)),
    "a long text": "x" * 120_000,
    "long words": "very long " * 12_000,
    "none": None,
    "an object": object(),
    "a class": rc.Love,
    "not a number": math.nan,
}


def refusal_of(call, *args, **kwargs):
    """Return the sentence with which a call is refused; None if it is not."""
    try:
        call(*args, **kwargs)
    except rc.RoughContactError as error:
        return error
    return None


@pytest.mark.slow
@pytest.mark.parametrize("registry", REGISTRIES, ids=lambda one: one.kind)
def test_nonsense_for_a_registered_class_is_answered_by_a_sentence(registry):
    """Each argument in turn; a class that takes it must refuse it before anything fails in it."""
    for name in registry:
        cls = registry[name]
        if cls.__module__.partition(".")[0] != "roughcontact" or registry.kind == "command":
            continue
        for argument in inspect.signature(cls).parameters:
            for value in NONSENSE.values():
                for make in (registry.create, lambda _, cls=cls, **fields: cls(**fields)):
                    error = refusal_of(make, name, **{argument: value})
                    assert not isinstance(error, rc.UnexpectedError), error
                    assert len(str(error)) < 900


@pytest.mark.parametrize("value", ["x" * 120_000, "very long " * 12_000], ids=["a word", "words"])
@pytest.mark.parametrize(
    "ask",
    [
        lambda value: rc.DCFFT().require(value, rc.Boundary.FREE),
        lambda value: rc.read_surface(value),
        lambda value: rc.writers.create("vti").write(problem().solve(pressure=1e6), Path(value)),
        lambda value: rc.kernels[value],
    ],
)
def test_a_sentence_quotes_no_more_than_it_needs(value, ask):
    with pytest.raises(rc.RoughContactError) as caught:
        ask(value)
    assert len(str(caught.value)) <= 4000
    assert value[:20] in str(caught.value)


def test_nonsense_that_changes_nothing_is_refused_too():
    heights = rc.HeightMap(1e-6 * np.eye(8), 1e-3, periodic=True)
    for surface in (heights, WAVE, heights + WAVE):
        with pytest.raises(rc.InputError, match=r"resampling method must be one of .* but got 'nope'"):
            surface.resample_to(GRID, interpolation="nope")
    solution = problem().solve(pressure=1e6)
    for value in ("5", ["5", "6"], -1.0, 0.0, [1e3, math.nan], datetime.date(2020, 1, 1), None):
        with pytest.raises(rc.InputError, match="wave number must be a number or an array of numbers above 0"):
            solution.effective_modulus(value)
    law = rc.interface_law(problem(boundary="periodic"), [1e5, 2e5, 4e5])
    for write in (law.to_abaqus, law.to_calculix):
        for value in (datetime.date(2020, 1, 1), "conductence", "", ["conductance"]):
            with pytest.raises(rc.InputError, match=r"conductance=|no column of the law named"):
                write("law.inp", conductance=value)
    assert not Path("law.inp").exists()


def test_an_argument_of_a_wrong_type_is_named_though_its_type_is_imported_for_annotations_alone(tmp_path):
    with pytest.raises(rc.InputError, match=r"path= of VtiWriter.write must be of type Path, but got 3"):
        rc.writers.create("vti").write(problem().solve(pressure=1e6), 3)


@pytest.mark.parametrize(
    ("ask", "words"),
    [
        (lambda: rc.panels.create("map").draw(None, None), r"subject= of MapPanel\.draw must be an object that has"),
        (lambda: rc.panels.create("pressure").draw(problem().solve(pressure=1e6), "5"), r"axes= of .* but got '5'"),
        (lambda: rc.Love().coefficients((8, 8), {1e-6: 2}, 1.0), r"spacing= of Love\.coefficients must be of type"),
        (lambda: rc.Love().coefficients((8, 8), (1e-6, 1e-6, 1e-6), 1.0), r"spacing= of Love\.coefficients must be"),
        (lambda: rc.Love().coefficients((8, 8), np.ones((2, 2)), 1.0), r"spacing= of Love\.coefficients must be"),
        (
            lambda: rc.FourierHalfSpace().spectrum(np.ones((8, 1)), np.ones((2, 2)), (1.0, 1.0), 1.0),
            r"must fit each other, but they are qx of shape \(8, 1\), qy of shape \(2, 2\)",
        ),
    ],
)
def test_an_argument_that_does_not_fit_is_named(ask, words):
    with pytest.raises(rc.InputError, match=words):
        ask()


@pytest.mark.parametrize(
    "call",
    [
        lambda: rc.Grid((8, 8)),
        lambda: rc.Grid((8, 8), 1.0, cells=8),
        lambda: problem().solve(1e6),
        lambda: rc.WavySurface(amplitude=1e-6, wavelength=1e-5).heights(8),
    ],
)
def test_a_wrong_call_is_a_type_error_and_an_input_error(call):
    with pytest.raises(TypeError) as met:
        call()
    assert type(met.value).__name__ == "WrongCall"
    assert isinstance(met.value, rc.InputError)
