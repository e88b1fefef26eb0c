"""Solutions and problems in files: nothing changes on the way, and damage is named."""

from __future__ import annotations

import json
import subprocess
import sys

import attrs
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings

import roughcontact as rc
from roughcontact import archive
from roughcontact.description import describe, key_of, rebuild
from strategies import problems

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
    np.testing.assert_array_equal(rc.ContactSolution.load(tmp_path / "solution.npz").limit, hardness)


def test_a_dataset_has_units_and_places():
    solution = small().solve(force=1.0)
    data = solution.to_xarray()
    assert data["pressure"].dims == ("x", "y")
    assert data["pressure"].attrs["units"] == "Pa"
    np.testing.assert_array_equal(data["x"], solution.grid.x[:, 0])
    assert float(data["force"]) == solution.force
    assert json.loads(data.attrs["header"])["versions"]["numpy"] == np.__version__


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


def test_plug_ins_are_kept_by_name_and_fields(tmp_path):
    problem = attrs.evolve(small(), body=attrs.evolve(BODY, material=Thermal(2.0)))
    problem.solve(force=1.0).save(tmp_path / "solution.npz")
    loaded = rc.ContactSolution.load(tmp_path / "solution.npz")
    assert loaded.origin.problem["body"].material == Thermal(2.0)
    command = f"import roughcontact as rc; rc.ContactSolution.load({str(tmp_path / 'solution.npz')!r})"
    done = subprocess.run([sys.executable, "-c", command], capture_output=True, text=True, check=False, cwd=tmp_path)
    assert "test_storage:Thermal is not installed here" in done.stderr


def test_what_cannot_be_kept_is_said(tmp_path):
    class Local(rc.Material):
        compliance, pressure_limit = 1e-11, np.inf

    problem = attrs.evolve(small(), body=attrs.evolve(BODY, material=Local()))
    solution = problem.solve(force=1.0)
    with pytest.raises(rc.InputError, match="top level of a module"):
        solution.save(tmp_path / "solution.npz")
    assert list(tmp_path.iterdir()) == []


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
    with pytest.raises(rc.InputError, match="holds no solution"):
        rc.ContactSolution.load(tmp_path / "other.npz")
    with pytest.raises(rc.InputError, match=r"ending in \.npz or \.nc"):
        small().solve(force=1.0).save(tmp_path / "solution.dat")


def test_a_key_knows_the_content_and_nothing_else():
    assert key_of(small()) == key_of(small())
    assert key_of(small()) != key_of(small(boundary="periodic"))
    heights = np.random.default_rng(0).random((4, 4))
    keys = {key_of(rc.HeightMap(heights + shift, 1.0)) for shift in (0.0, 0.0, 1e-16 + 1e-12)}
    assert len(keys) == 2


def test_a_key_is_the_same_in_another_process():
    command = (
        "import roughcontact as rc; from roughcontact.description import key_of; "
        "print(key_of(rc.SelfAffineSurface(hurst=0.8, rms_height=1e-7, longest=1e-4, shortest=1e-5)))"
    )
    keys = {
        subprocess.run([sys.executable, "-c", command], capture_output=True, text=True, check=True).stdout
        for _ in range(2)
    }
    assert len(keys) == 1


def test_a_description_is_plain_data():
    arrays = {}
    described = describe(small(solver=rc.ProjectedConjugateGradient(tolerance=1e-10)), arrays)
    again = rebuild(json.loads(json.dumps(described)), arrays)
    assert again.solver.tolerance == 1e-10
    assert key_of(again) == key_of(small(solver=rc.ProjectedConjugateGradient(tolerance=1e-10)))
