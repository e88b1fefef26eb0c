"""What a file says is recomputed or compared before it is believed; keys know the programs; full disks lose nothing."""

from __future__ import annotations

import copy
import json
import subprocess
import sys
import textwrap

import attrs
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings

import roughcontact as rc
from damage import right_key, write_forged
from scenes import each_once, make_problem
from strategies import wild_problems
from systems import posix
from unit_files import read_archive

HARDNESS = np.linspace(2e9, 6e9, 120).reshape(12, 10)
SURFACE = rc.SelfAffineSurface(hurst=0.8, rms_height=1e-7, longest=1e-4, shortest=2e-5, seed=5)


def problem(hardness=HARDNESS):
    material = rc.ElasticPerfectlyPlastic(210e9, 0.3, hardness)
    return make_problem(SURFACE, material, grid=rc.Grid((12, 10), 1e-4), boundary="periodic")


@pytest.fixture(scope="module")
def content(tmp_path_factory):
    path = tmp_path_factory.mktemp("intact") / "solution.npz"
    problem().solve(force=2.0).save(path)
    return read_archive(path)


def scaled(*names, factor=7.0):
    def change(arrays, header):
        for name in names:
            arrays[name] = arrays[name] * factor

    return change


def times_seven(arrays, header):
    """The pressure and all that follows from it without a convolution."""
    scaled("pressure", "force", "mean_pressure", "maximum_pressure")(arrays, header)
    header["load"] = {"mapping": {"force": float(arrays["force"])}}
    header["pressure_limit"] = {"number": "inf"}


def stated(*place, value):
    def change(arrays, header):
        inner = header
        for key in place[:-1]:
            inner = inner[key]
        inner[place[-1]] = value

    return change


def element(name, value):
    def change(arrays, header):
        arrays[name] = arrays[name].copy()
        arrays[name][3, 4] = value
        arrays["gap"] = arrays["initial_gap"] + arrays["displacement"] - header["approach"]

    return change


def moved(arrays, header):
    """A pressure of the same force elsewhere."""
    arrays["pressure"] = np.roll(arrays["pressure"], 1, axis=0)


def nearer(arrays, header):
    header["approach"] *= 1.00001
    arrays["gap"] = arrays["initial_gap"] + arrays["displacement"] - header["approach"]


RESIDUALS = ("residuals", "mapping")
FORGERIES = {
    "pressure times seven": (times_seven, "contradicts its pressure and its problem"),
    "pressure times seven alone": (scaled("pressure"), "Its force is not that of its pressure"),
    "pressure elsewhere": (moved, "contradicts its pressure"),
    "displacement times seven": (scaled("displacement"), "Its gap is not the initial gap plus"),
    "a displacement": (element("displacement", 1e-7), "Its displacement contradicts"),
    "a gap before deformation": (element("initial_gap", 1e-8), "Its initial gap contradicts"),
    "an approach": (nearer, "Its approach contradicts"),
    "an approach alone": (stated("approach", value=1e-9), "Its gap is not the initial gap plus"),
    "not a number": (element("pressure", np.nan), "Its force is not|values are not finite"),
    "an infinite displacement": (element("displacement", np.inf), "values are not finite"),
    "a limit below the pressure": (stated("pressure_limit", value=1e6), "the pressure leaves its bounds"),
    "no limit": (stated("pressure_limit", value={"number": "inf"}), "Its pressure limit contradicts"),
    "negative iterations": (stated("iterations", value=-1), "is negative"),
    "a negative time": (stated("seconds", value=-1.0), "is negative"),
    "a time that is not a number": (stated("seconds", value={"number": "nan"}), "is negative"),
    "a contact modulus": (stated("modulus", value=1e9), "Its contact modulus contradicts"),
    "an edge shift": (stated("edge_shift", value=0.3), "Its edge shift contradicts"),
    "moduli": (stated("moduli", value=[[1e-6, 1e-5], [1e9, 1e10]]), "Its moduli contradicts"),
    "small residuals": (stated(*RESIDUALS, "complementarity", value=0.5), "Its complementarity contradicts"),
    "a negative residual": (stated(*RESIDUALS, "penetration", value=-1.0), "values are not finite"),
    "an infinite residual": (stated(*RESIDUALS, "load", value={"number": "inf"}), "values are not finite"),
    "another scale": (stated(*RESIDUALS, "scale", value=1.0), "Its scale contradicts"),
    "another boundary": (stated("boundary", value="free"), "contradicts its pressure"),
    "another load": (stated("load", "mapping", "force", value=2.00001), "Its error of the load contradicts"),
    "a status": (stated("status", value="RESCUED"), ""),
    "another size": (
        stated("grid", "mapping", "size", value=[2e-4, 1e-4]),
        "force is not|not a solution",
    ),
}


@each_once(
    {
        "suffix": ["npz", "nc"],
        "name": FORGERIES,
    }
)
def test_a_forgery_with_right_digests_and_key_is_refused(content, tmp_path, name, suffix):
    change, words = FORGERIES[name]
    arrays, header = {**content[0]}, copy.deepcopy(content[1])
    change(arrays, header)
    header["key"] = right_key(header)
    path = tmp_path / f"forged.{suffix}"
    write_forged(path, arrays, header)
    if words:
        with pytest.raises(rc.InputError, match=words) as caught:
            rc.ContactSolution.load(path)
        assert "\n" not in str(caught.value)
    else:
        # All of success are equal: how it was found cannot be seen on the fields.
        assert rc.ContactSolution.load(path).status.success


def test_what_needs_a_convolution_is_left_to_the_named_option(content, tmp_path):
    arrays, header = {**content[0]}, copy.deepcopy(content[1])
    element("displacement", 1e-7)(arrays, header)
    write_forged(tmp_path / "forged.npz", arrays, header)
    assert rc.ContactSolution.load(tmp_path / "forged.npz", verify=False).displacement[3, 4] == 1e-7


def test_another_solution_under_this_key_is_refused(content, tmp_path):
    arrays, header = read_archive(save(problem(5e9).solve(force=2.0), tmp_path / "other.npz"))
    header["key"] = content[1]["key"]
    write_forged(tmp_path / "forged.npz", arrays, header)
    for verify in (True, False):
        with pytest.raises(rc.InputError, match="Its key is not that of its problem"):
            rc.ContactSolution.load(tmp_path / "forged.npz", verify=verify)


def save(solution, path):
    solution.save(path)
    return path


@settings(max_examples=30, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(wild_problems())
def test_every_solution_is_confirmed_when_it_is_loaded(tmp_path, drawn):
    wild, load = drawn
    try:
        solution = wild.solve(**load, throw=False)
    except rc.InputError:
        return
    rc.ContactSolution.load(save(solution, tmp_path / "solution.npz"))


def test_a_problem_confirms_its_own_solutions_only():
    solution = problem().solve(force=2.0)
    problem().verify(solution)
    for other in (
        problem(5e9),
        attrs.evolve(problem(), boundary="free"),
        attrs.evolve(problem(5e9), grid=rc.Grid((12, 12), 1e-4)),
    ):
        with pytest.raises(rc.InputError):
            other.verify(solution)


MATERIAL = """
    import attrs, numpy as np, roughcontact as rc

    FACTOR = {constant}

    def soften(value):
        return value * {helper}

    @attrs.frozen
    class Foam(rc.Material):
        pressure_limit = np.inf

        @property
        def compliance(self):
            return FACTOR * soften(1e-11) + {body}
"""


KEYS = """
    import importlib, json, pathlib, sys, types
    import roughcontact as rc
    from roughcontact._base.archive.plain import key_of

    source, texts = json.loads(sys.argv[1])
    for text in texts:
        pathlib.Path("foam.py").write_text(text)
        sys.modules.pop("foam", None)
        importlib.invalidate_caches()
        if source:
            import foam
        else:
            foam = sys.modules["foam"] = types.ModuleType("foam")
            exec(text, vars(foam))
        body = rc.Body(rc.ParaboloidSurface(1e-3), foam.Foam())
        print(key_of(rc.ContactProblem(body, grid=rc.Grid((4, 4), 1e-4)).parts))
"""


def keys_in_process(folder, *, seed, source, changes):
    """Return the keys of a problem with a class of a module, or without its source, in a process of its own."""
    texts = [MATERIAL.format(**{"constant": 1.0, "helper": 1.0, "body": 0.0, **change}) for change in changes]
    code = json.dumps([source, [textwrap.dedent(text) for text in texts]])
    environment = {"PYTHONPATH": str(folder), "PYTHONHASHSEED": seed, "PYTHONDONTWRITEBYTECODE": "1"}
    command = [sys.executable, "-c", textwrap.dedent(KEYS), code]
    return subprocess.run(
        command, env=environment, capture_output=True, text=True, check=True, cwd=folder
    ).stdout.split()


@pytest.mark.slow
def test_a_key_knows_the_source_of_a_class_without_a_distribution(tmp_path):
    changes = [{}, {"body": 22.0}, {"helper": 333.0}, {"constant": 4444.0}]
    keys = keys_in_process(tmp_path, seed="0", source=True, changes=changes)
    assert len(set(keys)) == 4
    assert keys_in_process(tmp_path, seed="1", source=True, changes=[{}]) == keys[:1]


@pytest.mark.slow
def test_what_has_no_source_is_another_class_each_time(tmp_path):
    """Nothing tells whether it has changed: no solution of an earlier process is taken for its."""
    keys = [keys_in_process(tmp_path, seed="0", source=False, changes=[{}, {}]) for _ in range(2)]
    assert len({*keys[0], *keys[1]}) == 4


LIMITED = """
    import resource, sys
    import roughcontact as rc

    body = rc.Body(rc.ParaboloidSurface(1e-3), rc.Elastic(210e9, 0.3))
    solution = rc.ContactProblem(body, grid=rc.Grid((32, 32), 1e-4)).solve(force=1.0)
    for limit in map(int, sys.argv[2:]):
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, resource.RLIM_INFINITY))
        try:
            solution.save(sys.argv[1])
        except rc.RoughContactError as error:
            print(type(error).__name__, error)
"""


@pytest.mark.slow
@posix
@pytest.mark.parametrize("suffix", ["npz", "nc"])
def test_a_full_disk_leaves_the_old_file_and_a_sentence(tmp_path, suffix):
    path = save(problem().solve(force=1.0), tmp_path / f"solution.{suffix}")
    before = path.read_bytes()
    limits = [0, 10, 5_000, 20_000, 32_000]
    command = [sys.executable, "-c", textwrap.dedent(LIMITED), str(path), *map(str, limits)]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    assert done.stdout.splitlines() == [f"NotWritten The file {str(path)!r} cannot be written: File too large."] * len(
        limits
    )
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]
    assert rc.ContactSolution.load(path).status.success


def run_study(folder):
    return rc.Study(problems=problem(), force=[1.0, 2.0], fields=True).run(folder)


def test_a_study_takes_no_solution_whose_residuals_are_wrong(tmp_path):
    first = run_study(tmp_path)
    for path in tmp_path.glob("*.npz"):
        arrays, header = read_archive(path)
        element("displacement", 1e-7)(arrays, header)
        write_forged(path, arrays, header)
    for index in tmp_path.glob("*.json"):
        index.unlink()
    again = run_study(tmp_path)
    assert again.computed == 2
    assert [one.force for one in again.records] == [one.force for one in first.records]
