"""A solution as plain data: complete, in the types of JSON, the same from Python, in files and on the command line."""

from __future__ import annotations

import json
import math

import attrs
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import roughcontact as rc
from scenes import make_problem

GRID = rc.Grid((16, 16), 100e-6)
STEEL = rc.Elastic(210e9, 0.3)
BALL = rc.SphereSurface(radius=1e-3)
WAVE = rc.WavySurface(amplitude=0.2e-6, wavelength=50e-6)


class Rubber(rc.Material):
    """A material of a script, without fields that its expression could show."""

    @property
    def compliance(self):
        return 1e-7

    @property
    def pressure_limit(self):
        return math.inf


def solve(surface=BALL, material=STEEL, *, load=None, grid=GRID, **settings):
    return make_problem(surface, material, grid=grid, **settings).solve(**(load or {"force": 1.0}))


SOLUTIONS = {
    "free": lambda: solve(),
    "periodic": lambda: solve(WAVE, load={"pressure": 100e6}, boundary="periodic"),
    "line": lambda: solve(WAVE, load={"pressure": 100e6}, boundary=("free", "periodic")),
    "approach": lambda: solve(load={"approach": 1e-7}),
    "plastic": lambda: solve(material=rc.ElasticPerfectlyPlastic(210e9, 0.3, 1e9)),
    "adhesion": lambda: solve(
        material=rc.Elastic(2e6, 0.49), load={"approach": 1e-7}, adhesion=rc.Exponential(work=0.05, range=200e-9)
    ),
    "accuracy": lambda: solve(load={"force": 1.0, "area_within": 0.5}),
    "plug-in": lambda: solve(material=Rubber(), load={"force": 1e-4}),
    "map": lambda: solve(rc.HeightMap(BALL.heights(GRID), GRID.size, history=("measured",)), grid=None),
}


def require_plain(value):
    """Fail at a type that JSON does not have; floats of numpy are floats, but print otherwise."""
    if type(value) is dict:
        assert all(type(name) is str for name in value)
        value = list(value.values())
    if type(value) is list:
        for item in value:
            require_plain(item)
        return
    assert type(value) in (str, int, float, bool, type(None)), repr(value)
    assert not isinstance(value, float) or math.isfinite(value)


@pytest.mark.parametrize("name", SOLUTIONS)
def test_a_solution_survives_json_and_has_every_part(name, tmp_path):
    solution = SOLUTIONS[name]()
    found = solution.to_dict()
    require_plain(found)
    assert json.loads(json.dumps(found, allow_nan=False)) == found
    solution.save(tmp_path / "contact.json")
    assert json.loads((tmp_path / "contact.json").read_text(encoding="utf-8")) == found
    area = solution.area()
    assert (found["area"]["value"], found["area"]["uncertainty"]) == (area.value, area.uncertainty)
    assert found["area"]["unit"] == "m2"
    assert found["area"]["warnings"] == list(area.warnings)
    assert found["force"] == {"value": solution.force, "unit": "N"}
    assert found["warnings"] == list(solution.warnings)
    assert found["residuals"]["load"] == solution.residuals.load
    assert found["status"] == "CONVERGED"
    assert found["versions"]["roughcontact"] == rc.__version__
    inputs = found["inputs"]
    assert inputs["grid"] == {"shape": [16, 16], "size": {"value": [1e-4, 1e-4], "unit": "m"}} or name == "accuracy"
    assert inputs["boundary"] == str(solution.boundary)
    ((kind, value),) = solution.origin.load.items()
    assert (inputs["load"]["kind"], inputs["load"]["value"]) == (kind, value)
    assert inputs["load"]["unit"] == {"force": "N", "pressure": "Pa", "approach": "m"}[kind]
    assert inputs["tolerance"] == solution.origin.source.plan.solver.tolerance
    # Parts are expressions that make them again.
    made = eval(inputs["solver"], {"rc": rc})
    assert made == solution.origin.source.plan.solver


def test_what_only_some_solutions_have():
    names = "free", "plastic", "adhesion", "accuracy", "plug-in", "map"
    found = {name: SOLUTIONS[name]().to_dict() for name in names}
    assert found["free"]["saturated_area"] is None
    assert found["plastic"]["saturated_area"]["unit"] == "m2"
    assert found["adhesion"]["attractive_area"]["value"] > 0.0
    assert "attractive_area" not in found["free"]
    assert found["adhesion"]["inputs"]["adhesion"] == "rc.Exponential(work=0.05, range=200e-9)"
    assert found["accuracy"]["accuracy"]["met"] is True
    assert "Rubber" in found["plug-in"]["inputs"]["body"]["material"]
    assert found["map"]["inputs"]["body"]["provenance"] == ["measured"]
    assert found["map"]["inputs"]["body"]["surface"].startswith("<HeightMap 16 x 16 cells")


def test_a_state_with_friction():
    steel = rc.Body(BALL, STEEL), rc.Body(rc.FlatSurface(), STEEL)
    path = rc.ContactProblem(*steel, grid=GRID).path(force=1.0, tangential_force=[(0.1, 0.0)], friction=0.3)
    found = path[0].to_dict()
    require_plain(found)
    assert found["tangential_force"] == {"value": list(path[0].tangential_force), "unit": "N"}
    assert found["dissipated"]["unit"] == "J"
    assert found["inputs"]["friction"] == "rc.Coulomb(coefficient=0.3)"
    assert found["inputs"]["along"] == {"kind": "tangential_force", "value": [0.1, 0.0], "unit": "N"}
    assert found["area"] == rc.ContactProblem(*steel, grid=GRID).solve(force=1.0).to_dict()["area"]
    slide = rc.ContactProblem(*steel, grid=GRID).slide(force=1.0, friction=0.3)
    require_plain(slide.to_dict())
    assert slide.to_dict()["inputs"]["along"]["kind"] == "direction"


def test_the_command_line_says_the_same(run, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    np.savez("ball.npz", heights=BALL.heights(GRID), size=GRID.size)
    status, out, _ = run(
        "solve", "ball.npz", "--young", "210GPa", "--force", "1N", "--json", "-o", "a.json", "-o", "a.npz"
    )
    assert status in (0, 3)
    printed = json.loads(out)
    with open("a.json", encoding="utf-8") as file:
        assert json.load(file) == printed
    problem = rc.ContactProblem(rc.Body(rc.read_surface("ball.npz"), STEEL))
    expected = {**problem.solve(force=1.0).to_dict(), "cost": None}
    assert {**printed, "cost": None} == expected
    # The file of the fields says it again, as does `info`.
    loaded = rc.load("a.npz").to_dict()
    assert loaded == printed
    assert json.loads(run("info", "a.npz", "--json")[1]) == loaded
    status, out, _ = run(
        "solve", "ball.npz", "--young", "210GPa", "--loads", "1N", "2N", "--stiffness", "-q", "-o", "b.json"
    )
    assert out == ""
    with open("b.json", encoding="utf-8") as file:
        both = json.load(file)["solutions"]
    assert [one["inputs"]["load"]["value"] for one in both] == [1.0, 2.0]
    assert both[1]["responses"]["stiffness"]["unit"] == "N/m"


def test_a_solution_that_did_not_converge_and_one_without_a_problem():
    problem = rc.ContactProblem(rc.Body(BALL, STEEL), grid=GRID, solver=rc.ProjectedConjugateGradient(max_iterations=1))
    failed = problem.solve(force=1.0, throw=False)
    found = failed.to_dict()
    require_plain(found)
    assert found["converged"] is False
    assert found["inputs"]["load"]["value"] == 1.0
    assert attrs.evolve(failed, origin=None).to_dict()["inputs"] is None
    # No area can be estimated from a pressure that is not finite.
    with np.errstate(invalid="ignore"):
        assert attrs.evolve(failed, pressure=np.where(failed.contact, np.inf, 0.0)).to_dict()["area"] is None


@settings(deadline=None, max_examples=20)
@given(
    force=st.floats(1e-6, 1e3),
    young=st.floats(1e5, 1e12),
    radius=st.floats(1e-4, 1.0),
    boundary=st.sampled_from(["free", "periodic", "wrapped"]),
)
def test_any_contact_is_plain_data(force, young, radius, boundary):
    body = rc.Body(rc.SphereSurface(radius=radius), rc.Elastic(young, 0.3))
    solution = rc.ContactProblem(body, grid=rc.Grid((8, 8), 1e-4), boundary=boundary).solve(force=force, throw=False)
    found = solution.to_dict()
    require_plain(found)
    assert json.loads(json.dumps(found, allow_nan=False)) == found
    assert eval(found["inputs"]["body"]["material"], {"rc": rc}).young == young
