"""Solutions and problems in files: nothing changes on the way, and damage is named."""

from __future__ import annotations

import inspect
import json
import re
import shutil
import subprocess
import sys
from importlib.metadata import distribution
from pathlib import Path

import attrs
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import roughcontact as rc
from strategies import problems
from unit_files import archive, describe, key_of, rebuild, registries

BODY = rc.Body(rc.ParaboloidSurface(1e-3), rc.ElasticPerfectlyPlastic(210e9, 0.3, 6e9))


def small(**parts):
    return rc.ContactProblem(BODY, grid=rc.Grid((12, 10), 1e-4), **parts)


def assert_equal(one, other):
    for field in attrs.fields(rc.ContactSolution):
        first, second = getattr(one, field.name), getattr(other, field.name)
        if isinstance(first, np.ndarray):
            np.testing.assert_array_equal(first, second)
        elif field.name != "origin":
            assert first == second, field.name


@pytest.mark.parametrize("suffix", [".npz", ".nc"])
@settings(max_examples=15, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(problems())
def test_a_solution_comes_back_bit_for_bit_and_can_be_solved_again(tmp_path, suffix, drawn):
    problem, mean = drawn
    solution = problem.solve(pressure=mean, throw=False)
    solution.save(tmp_path / f"solution{suffix}")
    loaded = rc.ContactSolution.load(tmp_path / f"solution{suffix}")
    assert_equal(solution, loaded)
    again = rc.ContactProblem(**loaded.origin.problem).solve(**loaded.origin.load, throw=False)
    np.testing.assert_array_equal(again.pressure, solution.pressure)


def test_a_limit_from_place_to_place_is_kept(tmp_path):
    hardness = np.linspace(1e9, 2e9, 120).reshape(12, 10)
    problem = attrs.evolve(small(), body=attrs.evolve(BODY, material=rc.ElasticPerfectlyPlastic(1e11, 0.3, hardness)))
    solution = problem.solve(force=2.0)
    solution.save(tmp_path / "solution.npz")
    np.testing.assert_array_equal(rc.ContactSolution.load(tmp_path / "solution.npz").pressure_limit, hardness)


def test_a_dataset_has_units_and_places():
    solution = small().solve(force=1.0)
    data = solution.to_xarray()
    assert data["pressure"].dims == ("x", "y")
    assert data["pressure"].attrs["units"] == "Pa"
    np.testing.assert_array_equal(data["x"], solution.grid.x[:, 0])
    assert float(data["force"]) == solution.force
    assert f"numpy {np.__version__}" in data.attrs["versions"]
    assert set(data.dims) == {"x", "y"}
    # What only a file needs is not in it.
    height_map = rc.HeightMap(np.random.default_rng(0).random((12, 10)) * 1e-7, size=(1.2e-4, 1e-4))
    names = rc.ContactProblem(rc.Body(height_map, rc.Elastic(210e9, 0.3))).solve(force=1.0).to_xarray().variables
    assert not [name for name in names if name == "header" or name.startswith("part_")]


@attrs.frozen
class Thermal(rc.Material):
    """Somebody else's material."""

    factor: float

    @property
    def compliance(self):
        return self.factor * 1e-11

    @property
    def pressure_limit(self):
        return np.inf


@attrs.frozen
class Raised(rc.Surface):
    """A wrapper around any surface."""

    inner: rc.Surface
    height: float = 0.0

    def heights(self, grid):
        return self.inner.heights(grid) + self.height


class Plain(rc.Material):
    """Not an attrs class: nobody knows which of its attributes are arguments."""

    def __init__(self, factor):
        self.factor = factor

    compliance = property(lambda self: self.factor * 1e-11)
    pressure_limit = np.inf


def of_one_s_own():
    body = rc.Body(Raised(rc.ParaboloidSurface(1e-3) + rc.WavySurface(1e-7, 2e-5), 1e-6), Thermal(2.0))
    return attrs.evolve(small(), body=body)


@pytest.mark.parametrize("suffix", [".npz", ".nc"])
def test_a_long_header_is_read(tmp_path, suffix):
    """In netCDF every array has dimensions, which have the shape of their arrays and take no room in the file."""
    heights = 1e-8 * np.random.default_rng(0).standard_normal((8, 8))
    surface = rc.HeightMap(heights, 1e-5, history=("cut from a larger map",) * 2000)
    solution = rc.ContactProblem(rc.Body(surface, rc.Elastic(200e9, 0.3))).solve(pressure=1e8)
    solution.save(tmp_path / f"long{suffix}")
    loaded = rc.ContactSolution.load(tmp_path / f"long{suffix}")
    np.testing.assert_array_equal(loaded.pressure, solution.pressure)


@pytest.mark.parametrize("suffix", [".npz", ".nc"])
def test_parts_that_nobody_registered_leave_the_fields_and_a_sentence(tmp_path, suffix):
    solution = of_one_s_own().solve(force=1.0)
    path = tmp_path / f"solution{suffix}"
    with pytest.warns(UserWarning, match="the surface test_storage:Raised must be registered"):
        solution.save(path)
    with pytest.raises(rc.InputError, match=r"cannot be verified.*Raised must be registered.*verify=False"):
        rc.ContactSolution.load(path)
    loaded = rc.ContactSolution.load(path, verify=False)
    assert_equal(solution, loaded)
    np.testing.assert_array_equal(loaded.gap, solution.gap)
    assert loaded.area() == solution.area()
    assert loaded.origin.load == {"force": 1.0}
    assert loaded.origin.missing == (
        "To solve it again, the surface test_storage:Raised must be registered, and the material test_storage:Thermal "
        "must be registered."
    )
    with pytest.raises(rc.InputError, match="the material test_storage:Thermal must be registered"):
        _ = loaded.origin.problem
    # Saved once more it keeps what it knows.
    with pytest.warns(UserWarning, match="must be registered"):
        loaded.save(path)
    assert rc.ContactSolution.load(path, verify=False).origin.missing == loaded.origin.missing


@pytest.fixture
def registered(monkeypatch):
    for registry, name, cls in ((rc.surfaces, "raised", Raised), (rc.materials, "thermal", Thermal)):
        monkeypatch.setattr(registry, "_classes", {**registry._classes})
        registry.register(name)(cls)


def test_a_class_may_be_registered_when_its_file_is_there(tmp_path, request):
    solution = of_one_s_own().solve(force=1.0)
    with pytest.warns(UserWarning, match="must be registered"):
        solution.save(tmp_path / "solution.npz")
    loaded = rc.ContactSolution.load(tmp_path / "solution.npz", verify=False)
    request.getfixturevalue("registered")
    assert loaded.origin.missing == ""
    again = rc.ContactProblem(**loaded.origin.problem).solve(**loaded.origin.load)
    np.testing.assert_array_equal(again.pressure, solution.pressure)


def test_registered_parts_of_one_s_own_are_first_class(tmp_path, registered):
    solution = of_one_s_own().solve(force=1.0)
    solution.save(tmp_path / "solution.npz")
    loaded = rc.ContactSolution.load(tmp_path / "solution.npz")
    assert loaded.origin.problem["body"] == of_one_s_own().body
    again = rc.ContactProblem(**loaded.origin.problem).solve(**loaded.origin.load)
    np.testing.assert_array_equal(again.pressure, solution.pressure)
    command = (
        f"import roughcontact as rc; s = rc.ContactSolution.load({str(tmp_path / 'solution.npz')!r}, verify=False); "
        "print(s.force, s.origin.missing)"
    )
    done = subprocess.run([sys.executable, "-c", command], capture_output=True, text=True, check=True, cwd=tmp_path)
    assert done.stdout == (
        f"{solution.force} To solve it again, the surface raised must be registered, and the material thermal must be "
        "registered.\n"
    )


def test_what_is_not_plain_data_is_kept_as_text(tmp_path):
    @attrs.frozen
    class Holding(rc.Material):
        what: object
        compliance, pressure_limit = 1e-11, np.inf

    for material in (Plain(2.0), Holding({1, 2}), Holding(lambda: 1), Holding({1: 2}), Holding(2j)):
        solution = attrs.evolve(small(), body=attrs.evolve(BODY, material=material)).solve(force=1.0)
        with pytest.warns(UserWarning, match="must be an attrs class whose fields are plain data"):
            solution.save(tmp_path / "solution.npz")
        loaded = rc.ContactSolution.load(tmp_path / "solution.npz", verify=False)
        np.testing.assert_array_equal(loaded.pressure, solution.pressure)
        assert "must be an attrs class whose fields are plain data" in loaded.origin.missing
        with pytest.raises(rc.InputError, match="is not known"):
            key_of(material)
    with pytest.raises(rc.InputError, match="numbers, texts, arrays or attrs classes"):
        describe(lambda: 1, {})


def test_a_file_names_no_private_module(tmp_path):
    heights = rc.HeightMap(np.random.default_rng(0).random((12, 10)) * 1e-7, (1e-4, 1e-4))
    surface = (rc.WavySurface(1e-7, 2e-5) + rc.PlacedMap(heights)) + rc.SphereSurface(1e-3)
    problem = rc.ContactProblem(
        rc.Body(surface, BODY.material),
        rc.Body(rc.FlatSurface(), rc.Elastic(1e11, 0.2)),
        grid=heights.grid,
        kernel=rc.Love(),
        convolver=rc.DCFFT(),
        solver=rc.ProjectedConjugateGradient(tolerance=1e-9),
    )
    solution = problem.solve(force=1.0)
    for name in ("solution.npz", "solution.nc"):
        solution.save(tmp_path / name)
        content = (tmp_path / name).read_bytes()
        assert b"roughcontact:HeightMap" in content
        assert not re.findall(rb"roughcontact[._]\w*", content.replace(b"roughcontact file", b""))


def test_every_part_that_ships_has_a_public_name():
    for registry in registries().values():
        for cls in subclasses(registry.base):
            if cls.__module__.partition(".")[0] == "roughcontact" and not cls.__name__.startswith("_"):
                public = getattr(rc, cls.__name__, None) is cls and cls.__name__ in rc.__all__
                assert registry.name_of(cls) or public or inspect.isabstract(cls), cls


def subclasses(base):
    return set() if base is object else {base}.union(*map(subclasses, base.__subclasses__())) - {base}


@pytest.mark.slow
def test_a_solution_is_read_after_a_tidy_up(tmp_path):
    """The package with its storeys renamed reads and solves the same, bit for bit."""
    solution = small(boundary="periodic").solve(force=1.0)
    solution.save(tmp_path / "solution.npz")
    renamed = tmp_path / "renamed"
    shutil.copytree(Path(rc.__file__).parent, renamed / "roughcontact", ignore=shutil.ignore_patterns("__pycache__"))
    storeys = ("_parts", "_solve")
    tidy = lambda text: re.sub(rf"\broughcontact\.({'|'.join(storeys)})\b", r"roughcontact.\1_tidy", text)  # noqa: E731
    for path in (renamed / "roughcontact").rglob("*.py"):
        path.write_text(tidy(path.read_text()))
    for storey in storeys:
        (renamed / "roughcontact" / storey).rename(renamed / "roughcontact" / f"{storey}_tidy")
    metadata = renamed / "roughcontact-0.1.0.dist-info"
    metadata.mkdir()
    for name in ("METADATA", "entry_points.txt"):
        (metadata / name).write_text(tidy(distribution("roughcontact").read_text(name)))
    script = (
        "import sys, numpy as np, roughcontact as rc\n"
        "loaded = rc.ContactSolution.load(sys.argv[1])\n"
        "again = rc.ContactProblem(**loaded.origin.problem).solve(**loaded.origin.load)\n"
        "assert 'roughcontact._solve_tidy.problem.body' in sys.modules\n"
        "assert 'roughcontact._solve' not in sys.modules\n"
        "assert (again.pressure == loaded.pressure).all()\n"
        "np.save(sys.argv[2], [loaded.pressure, loaded.displacement, loaded.initial_gap, loaded.gap])\n"
    )
    command = [sys.executable, "-c", script, str(tmp_path / "solution.npz"), str(tmp_path / "fields.npy")]
    subprocess.run(command, check=True, env={"PYTHONPATH": str(renamed)}, cwd=tmp_path)
    fields = [solution.pressure, solution.displacement, solution.initial_gap, solution.gap]
    np.testing.assert_array_equal(np.load(tmp_path / "fields.npy"), fields)


@pytest.mark.parametrize("suffix", [".npz", ".nc"])
def test_damage_is_named(tmp_path, suffix):
    path = tmp_path / f"solution{suffix}"
    small().solve(force=1.0).save(path)
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(rc.InputError, match="damaged"):
        rc.ContactSolution.load(path)
    path.write_bytes(b"something else")
    with pytest.raises(rc.InputError, match="damaged"):
        rc.ContactSolution.load(path)
    with pytest.raises(rc.InputError, match="There is no file"):
        rc.ContactSolution.load(tmp_path / f"other{suffix}")


def test_other_archives_and_endings_are_refused(tmp_path):
    archive.write_archive(tmp_path / "other.npz", {"a": np.ones(3)}, {"kind": "something"})
    with pytest.raises(rc.InputError, match="does not hold a solution"):
        rc.ContactSolution.load(tmp_path / "other.npz")
    with pytest.raises(rc.InputError, match=r"ending in \.html, \.json, \.nc, \.npz"):
        small().solve(force=1.0).save(tmp_path / "solution.dat")


def test_a_key_knows_the_content_and_nothing_else():
    assert key_of(small()) == key_of(small())
    assert key_of(small()) != key_of(small(boundary="periodic"))
    heights = np.random.default_rng(0).random((4, 4))
    keys = {key_of(rc.HeightMap(heights + shift, 1.0)) for shift in (0.0, 0.0, 1e-16 + 1e-12)}
    assert len(keys) == 2


@pytest.mark.slow
def test_a_key_is_the_same_in_another_process():
    command = (
        "import roughcontact as rc; from roughcontact._base.archive.plain import key_of; "
        "print(key_of(rc.SelfAffineSurface(hurst=0.8, rms_height=1e-7, longest=1e-4, shortest=1e-5)))"
    )
    keys = {
        subprocess.run([sys.executable, "-c", command], capture_output=True, text=True, check=True).stdout
        for _ in range(2)
    }
    assert len(keys) == 1


def test_a_description_is_plain_data():
    arrays = {}
    parts = small(solver=rc.ProjectedConjugateGradient(tolerance=1e-10)).parts
    described = describe(parts, arrays)
    again = {
        name: rebuild(json.loads(json.dumps(item)), arrays, (object,)) for name, item in described["mapping"].items()
    }
    assert again["solver"].tolerance == 1e-10
    assert key_of(again) == key_of(parts)


@pytest.mark.slow
@given(
    st.recursive(
        st.none() | st.booleans() | st.integers(-(10**30), 10**30) | st.floats() | st.text(),
        lambda inner: st.tuples(inner, inner) | st.dictionaries(st.text(), inner, max_size=3),
        max_leaves=20,
    )
)
def test_plain_data_comes_back_as_it_was(tmp_path_factory, value):
    described = describe(value, {})
    path = tmp_path_factory.getbasetemp() / "plain.npz"
    archive.write_archive(path, {}, {"value": described})
    assert repr(rebuild(archive.read_some(path)[1]["value"], {})) == repr(value)


def test_arrays_of_any_real_type_come_back(tmp_path):
    rng = np.random.default_rng(0)
    arrays = {
        "floats": rng.random((3, 4)),
        "fortran": np.asfortranarray(rng.random((3, 4))),
        "single": rng.random(5).astype(np.float32),
        "mask": rng.random((2, 2)) < 0.5,
        "counts": np.arange(5),
        "texts": np.array(["a", "bcd"]),
        "number": np.array(1.5),
        "empty": np.zeros((0, 3)),
    }
    archive.write_archive(tmp_path / "a.npz", arrays, {"one": 1})
    loaded, header = archive.read_archive(tmp_path / "a.npz")
    assert header == {"one": 1}
    for name, array in arrays.items():
        np.testing.assert_array_equal(loaded[name], array)
        assert loaded[name].dtype == array.dtype
    with pytest.raises(rc.InputError, match="only numbers and texts"):
        archive.write_archive(tmp_path / "b.npz", {"objects": np.array([{}])}, {})
    assert not (tmp_path / "b.npz").exists()


def test_a_sum_of_many_surfaces_is_one_level(tmp_path):
    waves = [rc.WavySurface(1e-9 * (1 + number), 2e-5) for number in range(200)]
    surface, nested = sum(waves, start=rc.ParaboloidSurface(1e-3)), rc.ParaboloidSurface(1e-3)
    for wave in waves:
        nested = type(surface)((nested, wave))
    grid = rc.Grid((12, 10), 1e-4)
    np.testing.assert_array_equal(surface.heights(grid), nested.heights(grid))
    rc.ContactProblem(rc.Body(surface, BODY.material), grid=grid).solve(force=1.0).save(tmp_path / "solution.npz")
    assert rc.ContactSolution.load(tmp_path / "solution.npz").origin.problem["body"].surface == surface


def test_what_could_not_be_read_is_not_written(tmp_path, registered):
    surface = rc.ParaboloidSurface(1e-3)
    for _ in range(80):
        surface = Raised(surface)
    solution = rc.ContactProblem(rc.Body(surface, BODY.material), grid=rc.Grid((12, 10), 1e-4)).solve(force=1.0)
    with pytest.raises(rc.InputError, match="cannot be kept in a file: its header has more than 150 levels"):
        solution.save(tmp_path / "solution.npz")
    assert not list(tmp_path.iterdir())


def test_a_field_is_read_under_its_former_name():
    """Placed maps in files of before have a `method`, which is their interpolation now."""
    placed = rc.PlacedMap(rc.HeightMap(np.eye(8), 1e-3), offset=(1e-4, 0.0), interpolation="cubic")
    arrays = {}
    described = describe(placed, arrays)
    described["fields"]["method"] = described["fields"].pop("interpolation")
    read = rebuild(described, arrays)
    assert (read.interpolation, read.offset) == ("cubic", (1e-4, 0.0))
    np.testing.assert_array_equal(read.source.values, np.eye(8))


class TestLoad:
    """`rc.load`, which reads whatever `save` wrote."""

    @pytest.mark.parametrize("name", ["one.npz", "one.nc"])
    def test_a_solution(self, tmp_path, name):
        solution = small().solve(force=1.0)
        solution.save(tmp_path / name)
        assert_equal(rc.load(tmp_path / name), solution)

    def test_a_path_and_a_state(self, tmp_path):
        path = small().path(force=1.0, tangential_force=[(0.1, 0.0)], friction=0.3)
        path.save(tmp_path / "path.npz")
        path[0].save(tmp_path / "state.npz")
        assert isinstance(rc.load(tmp_path / "path.npz"), rc.FrictionalPath)
        state = rc.load(tmp_path / "state.npz", verify=False)
        assert isinstance(state, rc.ContactSolution)
        np.testing.assert_array_equal(state.shear, path[0].shear)

    def test_a_sweep(self, tmp_path):
        sweep = small().sweep(force=[1.0, 0.5, 2.0])
        sweep.save(tmp_path / "sweep.npz")
        loaded = rc.load(tmp_path / "sweep.npz")
        assert isinstance(loaded, rc.results.Sweep)
        for one, other in zip(sweep, loaded, strict=True):
            assert_equal(other, one)
        # The problem is built and prepared once for all of them.
        assert loaded[0].origin.source is loaded[2].origin.source
        assert loaded[1].stiffness() == sweep[1].stiffness()

    def test_a_cycle(self, tmp_path):
        ball = rc.Body(rc.ParaboloidSurface(radius=1e-6), rc.Elastic(young=10e6, poisson=0.5))
        law = rc.Exponential(work="50mJ/m2", range="120nm")
        problem = rc.ContactProblem(ball, grid=rc.Grid((24, 24), 2e-6), adhesion=law)
        cycle = problem.cycle(approach=np.linspace(-0.3e-6, 0.1e-6, 4))
        cycle.save(tmp_path / "cycle.npz")
        for verify in (True, False):
            loaded = rc.load(tmp_path / "cycle.npz", verify=verify)
            assert str(loaded) == str(cycle)
            assert loaded.losses[1].tolist() == cycle.losses[1].tolist()
            assert loaded.pull_off == cycle.pull_off
        with pytest.raises(rc.InputError, match="does not hold a sweep"):
            rc.results.Sweep.load(tmp_path / "cycle.npz")

    def test_a_forged_state_of_a_sweep_is_refused(self, tmp_path):
        sweep = small().sweep(force=[1.0, 0.5])
        forged = attrs.evolve(sweep[1], pressure=1.01 * sweep[1].pressure)
        attrs.evolve(sweep, states=(sweep[0], forged)).save(tmp_path / "sweep.npz")
        with pytest.raises(rc.InputError, match="cannot be"):
            rc.load(tmp_path / "sweep.npz")
        assert len(rc.load(tmp_path / "sweep.npz", verify=False)) == 2

    def test_other_files_get_a_sentence(self, tmp_path):
        np.savez(tmp_path / "map.npz", heights=np.zeros((4, 4)), size=1e-6)
        (tmp_path / "text.txt").write_text("1 2\n3 4\n")
        for name in ("map.npz", "text.txt"):
            with pytest.raises(rc.InputError, match="holds no solution"):
                rc.load(tmp_path / name)
        with pytest.raises(rc.InputError, match="There is no file"):
            rc.load(tmp_path / "none.npz")
        with pytest.raises(rc.InputError, match="verify="):
            rc.load(tmp_path / "map.npz", verify="yes")
