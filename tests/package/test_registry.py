"""Both doors of the registries, tried from outside the package."""

from __future__ import annotations

import subprocess
import sys
import textwrap

import numpy as np
import pytest

import roughcontact as rc

Registry = type(rc.kernels)
PLUG_IN = '''
"""A kernel and an area estimator of somebody else."""

import numpy as np

import roughcontact as rc


class Winkler(rc.InfluenceKernel):
    """Independent springs under the cells: a foundation of thickness times its compliance."""

    def __init__(self, thickness=1e-6):
        self.thickness = thickness

    def coefficients(self, shape, spacing, compliance):
        values = np.zeros(shape)
        values[0, 0] = self.thickness * compliance
        return values

    def spectrum(self, qx, qy, spacing, compliance):
        return np.full((qx.shape[0], qy.shape[1]), self.thickness * compliance)


class PressureWeighted(rc.AreaEstimator):
    """(sum p)^2 / sum p^2: the area that carries the load evenly."""

    def estimate(self, solution):
        p = solution.pressure
        cells = p.sum() ** 2 / (p**2).sum()
        value = cells * solution.grid.cell_area
        return rc.Area(value, value / solution.grid.area, 0.0, "pressure-weighted")
'''


def plug_in():
    names = {"__name__": "somebody_elses"}
    exec(compile(PLUG_IN, "somebody_elses.py", "exec"), names)
    return names


def test_the_decorator_door():
    names = plug_in()
    rc.kernels.register("winkler")(names["Winkler"])
    rc.areas.register("pressure-weighted")(names["PressureWeighted"])
    assert "winkler" in rc.kernels
    surface = rc.ParaboloidSurface(1e-2)
    grid = rc.Grid((64, 64), 4e-5)
    material = rc.Elastic(1e9, 0.0)
    problem = rc.ContactProblem(rc.Body(surface, material), grid=grid, kernel="winkler")
    force = 1e-3
    solution = problem.solve(force=force, tolerance=1e-8)
    # On springs the pressure is E/t times the indentation: the load is that over the contact disc.
    deepest = np.sqrt(force * 1e-6 / (np.pi * 1e-2 * 1e9))
    # The approach counts from the highest cell centres, half a diagonal off the summit.
    assert solution.approach + grid.spacing[0] ** 2 / 4 / 1e-2 == pytest.approx(deepest, rel=1e-3)
    assert solution.area("cell-count").value == pytest.approx(2 * np.pi * 1e-2 * deepest, rel=5e-2)
    # A paraboloid of pressure: (sum p)^2 / sum p^2 is three quarters of its base.
    assert solution.area("pressure-weighted").value == pytest.approx(1.5 * np.pi * 1e-2 * deepest, rel=2e-2)
    periodic = rc.ContactProblem(
        rc.Body(surface, material), grid=grid, kernel=names["Winkler"](1e-6), boundary="periodic"
    ).solve(force=force, tolerance=1e-8)
    np.testing.assert_allclose(periodic.pressure, solution.pressure, atol=1e-6 * solution.pressure.max())


def test_the_entry_point_door(tmp_path):
    """A distribution as an installer lays it down: a module and its metadata on the path."""
    (tmp_path / "somebody_elses.py").write_text(PLUG_IN)
    metadata = tmp_path / "somebody_elses-1.0.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: somebody-elses\nVersion: 1.0\n")
    (metadata / "entry_points.txt").write_text(
        "[roughcontact.kernels]\nwinkler = somebody_elses:Winkler\nbroken = somebody_elses:Absent\n"
        "stray = somebody_elses:PressureWeighted\n"
        "[roughcontact.areas]\npressure-weighted = somebody_elses:PressureWeighted\n"
    )
    script = """
        import roughcontact as rc
        body = rc.Body(rc.ParaboloidSurface(1e-2), rc.Elastic(1e9, 0.0))
        problem = rc.ContactProblem(body, grid=rc.Grid((32, 32), 2e-4), kernel="winkler")
        print(problem.solve(force=1e-3).area("pressure-weighted").estimator, *rc.kernels)
        for name in ("broken", "stray"):
            try:
                rc.kernels[name]
            except rc.InputError as error:
                print(error)
    """
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(script)],
        capture_output=True,
        text=True,
        check=True,
        env={"PYTHONPATH": str(tmp_path)},
    )
    first, second, third = done.stdout.splitlines()
    estimator, *names = first.split()
    assert estimator == "pressure-weighted"
    # Other plug-ins may be installed beside it.
    assert {"broken", "fourier", "love", "winkler"} <= set(names)
    assert "'broken' is installed as somebody_elses:Absent, but cannot be loaded" in second
    assert "must be a class derived from InfluenceKernel, but got <class 'somebody_elses.PressureWeighted'>" in third


def test_what_ships_comes_through_entry_points():
    assert {"love", "fourier"} <= set(rc.kernels)
    assert {"direct", "dc-fft", "circular-fft"} <= set(rc.convolvers)
    assert {"polonsky-keer", "spectral-gradient"} <= set(rc.solvers)
    assert {"cell-count", "perimeter"} <= set(rc.areas)
    assert {"npz", "npy", "txt", "instrument"} <= set(rc.readers)
    assert rc.kernels["love"] is rc.Love


class TestNames:
    def test_a_taken_name_is_refused(self):
        registry = Registry(object, "thing", "nobody.things", in_files=False)
        registry.register("one")(int)
        with pytest.raises(rc.InputError, match="taken already by builtins:int"):
            registry.register("one")(float)

    def test_a_shipped_name_is_refused(self):
        with pytest.raises(rc.InputError, match="taken already"):
            rc.kernels.register("love")(rc.FourierHalfSpace)

    def test_a_class_may_be_registered_again(self):
        registry = Registry(object, "thing", "nobody.things", in_files=False)
        assert registry.register("one")(int) is registry.register("one")(int)

    @pytest.mark.parametrize("name", ["", None, 3])
    def test_a_name_is_a_word(self, name):
        with pytest.raises(rc.InputError, match="non-empty string"):
            rc.kernels.register(name)

    def test_an_unknown_name_lists_the_known_ones(self):
        with pytest.raises(rc.InputError, match=r"There is no kernel named 'spring'.*Known: .*fourier.*love"):
            rc.kernels["spring"]

    def test_an_empty_registry_says_so(self):
        with pytest.raises(rc.InputError, match="Known: none"):
            Registry(object, "thing", "nobody.things", in_files=False)["one"]

    @pytest.mark.parametrize("wrong", [int, rc.Elastic, rc.Love(), "love"])
    def test_only_subclasses_of_the_base_are_registered(self, wrong):
        with pytest.raises(rc.InputError, match="must be a class derived from InfluenceKernel, but got"):
            rc.kernels.register("wrong")(wrong)
        assert "wrong" not in rc.kernels


class TestTable:
    """A registry looks like a mapping of names to classes."""

    def test_it_is_iterable_and_has_length_and_members(self):
        assert list(rc.solvers) == sorted(rc.solvers)
        assert len(rc.solvers) == len(list(rc.solvers)) >= 3
        assert "projected-cg" in rc.solvers
        assert "projected" not in rc.solvers
        assert rc.solvers["projected-cg"] is rc.ProjectedConjugateGradient
        assert rc.solvers.base is rc.Solver

    def test_its_repr_is_a_table(self):
        lines = repr(rc.materials).splitlines()
        assert lines[0] == f"material: {len(rc.materials)} subclasses of Material"
        *shown, typical = lines[1:]
        assert typical.startswith("typical ones: bearing_steel, ")
        rows = dict(line.split() for line in shown)
        assert list(rows) == list(rc.materials)
        assert rows["rigid"].endswith(":Rigid")

    def test_the_name_of_a_class_is_that_of_exactly_this_class(self):
        class Mine(rc.Love):
            pass

        assert rc.kernels.name_of(rc.Love) == "love"
        assert rc.kernels.name_of(Mine) is None
        assert rc.materials.name_of(rc.Love) is None
        registry = Registry(rc.InfluenceKernel, "thing", "nobody.things", in_files=False)
        registry.register("second")(Mine)
        registry.register("first")(Mine)
        assert registry.name_of(Mine) == "first"

    def test_a_class_that_needs_arguments_is_made_as_the_sentence_says(self):
        with pytest.raises(rc.InputError) as failed:
            rc.responses.create("first-yield")
        assert "roughcontact.responses.create('first-yield', yield_stress=...)" in str(failed.value)
        assert "._" not in str(failed.value)
        assert rc.responses.create("first-yield", yield_stress=1e9).yield_stress == 1e9
        with pytest.raises(rc.InputError, match=r"unexpected keyword argument 'drop'.*viscosity=\.\.\.") as failed:
            rc.responses.create("leakage", viscosity=1e-3, drop=1e5)
        assert "pressure_drop=...) makes one" in str(failed.value)

    def test_a_class_is_not_an_instance(self):
        with pytest.raises(rc.InputError, match="Pass an instance, not the class"):
            rc.kernels.resolve(rc.Love)
        assert rc.kernels.resolve("love") == rc.Love()


class TestTypicalMaterials:
    def test_they_are_attributes_that_are_completed(self):
        assert rc.materials.bearing_steel == rc.faces.TYPICAL["bearing steel"]
        assert rc.Body(rc.FlatSurface(), rc.materials.PTFE).material == rc.Body(rc.FlatSurface(), "PTFE").material
        named = [name for name in dir(rc.materials) if isinstance(getattr(rc.materials, name, None), rc.Material)]
        assert len(named) == len(rc.faces.TYPICAL)
        assert all(name.isidentifier() for name in named)

    def test_those_of_plug_ins_too(self, monkeypatch):
        added = {"1006-steel": rc.Elastic(2e11, 0.3), "bronze (CuSn8)": rc.Elastic(1e11, 0.3)}
        monkeypatch.setattr(rc.faces.TYPICAL, "_known", {**rc.faces.TYPICAL._known, **added})
        assert rc.materials.grade_1006_steel == added["1006-steel"]
        assert rc.materials.bronze_CuSn8 == added["bronze (CuSn8)"]

    def test_a_word_of_several_names_them(self):
        with pytest.raises(rc.InputError, match=r"Did you mean .*'bearing_steel', .*or 'structural_steel'") as caught:
            rc.materials.steel  # noqa: B018
        assert isinstance(caught.value, AttributeError)
        assert not hasattr(rc.materials, "steel")
        with pytest.raises(rc.InputError, match=r"Did you mean .*'bearing steel', .*or 'structural steel'"):
            rc.Body(rc.FlatSurface(), "steel")

    def test_the_registry_stays_one(self):
        assert "bearing steel" not in rc.materials
        assert not hasattr(rc.materials, "__wrapped__")
        assert not hasattr(rc.kernels, "bearing_steel")
