"""The inputs in the JSON of every command: in one form, and with all that a script needs to ask again."""

from __future__ import annotations

import json

import numpy as np
import pytest

import roughcontact as rc

GRID = rc.Grid((24, 24), 100e-6)
STEEL = rc.Elastic(210e9, 0.3)
BODY = ["ball.npz", "--young", "210GPa"]
PROBLEM = {
    "kernel": "rc.Love()",
    "convolver": "rc.DCFFT()",
    "solver": "rc.ProjectedConjugateGradient()",
    "tolerance": 1e-5,
    "body": {
        "surface": "<HeightMap 24 x 24 cells on 100 µm x 100 µm>",
        "material": "rc.Elastic(young=210e9, poisson=0.3)",
        "provenance": ["read from ball.npz: 24 x 24 cells on 100 µm x 100 µm"],
    },
    "counterbody": {"surface": "rc.FlatSurface()", "material": "rc.Rigid()"},
    "grid": {"shape": [24, 24], "size": {"value": [100e-6, 100e-6], "unit": "m"}},
    "boundary": "free",
}
FORCE = {"kind": "force", "value": 1.0, "unit": "N"}


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    np.savez("ball.npz", heights=rc.ParaboloidSurface(1e-3).heights(GRID), size=GRID.size)


@pytest.fixture
def ask(run):
    """Return the inputs in the JSON of a command."""

    def inputs(*arguments):
        status, out, _ = run(*arguments, "--json")
        assert status in (0, 3)
        return json.loads(out)["inputs"]

    return inputs


def test_a_solve(ask):
    assert ask("solve", *BODY, "--force", "1N") == {**PROBLEM, "load": FORCE}
    found = ask("solve", *BODY, "--force", "1N", "--conductance", "45", "--stiffness")
    assert set(found["responses"]) == {"conductance", "stiffness"}
    # The text makes the response again.
    made = eval(found["responses"]["conductance"], {"rc": rc})
    assert made == rc.responses.create("conductance", conductivity=45.0)


def test_stability(ask, run):
    assert ask("stability", *BODY, "--force", "1N") == {**PROBLEM, "load": FORCE}
    _, out, _ = run("stability", *BODY, "--force", "1N", "--json")
    found = json.loads(out)
    _, text, _ = run("stability", *BODY, "--force", "1N")
    assert text.startswith(f"overall: {found['verdict']} (")
    checks = {one["name"]: one for one in found["checks"]}
    assert checks["convergence"]["verdict"] == "pass"
    # JSON has no nan.
    assert all(one["value"] is None for one in checks.values() if one["verdict"] == "skipped")
    assert found["solution"]["force"] == {"value": pytest.approx(1.0, rel=1e-12), "unit": "N"}


def test_a_load_that_is_asked_for(ask):
    found = ask("solve", *BODY, "--solve-for", "area=10%", "estimator=cell-count")
    assert found["solve_for"]["answer"] == "rc.CellCount()"
    assert found["solve_for"]["value"] == pytest.approx(0.1 * GRID.area)
    assert found["solve_for"]["unit"] == "m2"
    assert found["load"]["kind"] == "pressure"


def test_a_law_on_the_terminal_and_in_its_file(ask):
    found = ask("law", *BODY, "--loads", "6MPa", "4MPa", "--mirror-borders", "--conductance", "45", "-o", "law.json")
    assert found["load"] == {"kind": "pressure", "value": [4e6, 6e6], "unit": "Pa"}
    assert found["boundary"] == "periodic"
    assert found["body"]["provenance"][-1] == "mirrored at its borders"
    assert set(found["responses"]) == {"stiffness", "conductance"}
    with open("law.json", encoding="utf-8") as file:
        assert json.load(file)["inputs"] == found


def test_a_cycle_with_adhesion(ask):
    law = ["--adhesion", "exponential", "work=50mJ/m2", "range=200nm"]
    found = ask("solve", *BODY, *law, "--cycle", "-300nm", "300nm", "--states", "3")
    assert found["adhesion"] == "rc.Exponential(work=0.05, range=200e-9)"
    assert found["load"] == {"kind": "approach", "value": pytest.approx([-300e-9, 0.0, 300e-9]), "unit": "m"}
    assert found["body"] == PROBLEM["body"]


def test_a_path_and_steady_sliding_also_from_their_files(ask):
    steel = ["--counterbody-young", "210GPa", "--friction", "0.3"]
    expected = {
        **PROBLEM,
        "counterbody": {"surface": "rc.FlatSurface()", "material": "rc.Elastic(young=210e9, poisson=0.3)"},
        "load": FORCE,
        "friction": "rc.Coulomb(coefficient=0.3)",
    }
    found = ask("solve", *BODY, "--force", "1N", *steel, "--tangential", "0.2N", "-0.2N", "-o", "path.npz")
    along = {"kind": "tangential_force", "value": [[0.2, 0.0], [-0.2, 0.0]], "unit": "N"}
    assert found == {**expected, "along": along}
    assert ask("info", "path.npz") == found
    several = ask("solve", *BODY, "--loads", "0.8N", "1N", *steel, "--tangential", "0.1N", "0.2N", "--substeps", "2")
    assert several["load"]["value"] == [0.8, 1.0]
    assert several["substeps"] == 2
    found = ask("solve", *BODY, "--force", "1N", *steel, "--slide", "90deg")
    direction = {"kind": "direction", "value": pytest.approx([0.0, 1.0], abs=1e-15), "unit": ""}
    assert found == {**expected, "along": direction}


STUDY = """
[problems.ball]
grid = {shape = [24, 24], size = ["100um", "100um"]}
body = {surface = {type = "sphere", radius = "1mm"}, material = {type = "elastic", young = "210GPa", poisson = 0.3}}
counterbody = {surface = {type = "flat"}, material = {type = "elastic", young = "210GPa", poisson = 0.3}}

[study]
force = ["1N", "2N"]
responses = ["stiffness"]
"""


def test_a_study(run, tmp_path):
    (tmp_path / "study.toml").write_text(STUDY, encoding="utf-8")
    status, out, _ = run("run", "study.toml", "--json")
    assert status == 0
    found = json.loads(out)
    inputs = found["inputs"]
    assert inputs["problems"]["ball"]["body"]["surface"] == "rc.SphereSurface(radius=1e-3)"
    assert inputs["problems"]["ball"]["grid"] == PROBLEM["grid"]
    assert inputs["load"] == {**FORCE, "value": [1.0, 2.0]}
    assert inputs["responses"] == {"stiffness": "rc.responses.create('stiffness')"}
    # The records have the columns and the units of the table.
    assert [record["load"] for record in found["records"]] == [1.0, 2.0]
    steel = rc.Body(rc.SphereSurface(1e-3), STEEL), rc.Body(rc.FlatSurface(), STEEL)
    solution = rc.ContactProblem(*steel, grid=GRID).solve(force=1.0)
    assert found["records"][0]["area blend"] == solution.area().value
    assert found["units"]["area blend"] == "m2"
    assert {record["seed"] for record in found["records"]} == {None}
    status, out, err = run("run", "study.toml", "--json", "--share", "1/1")
    assert json.loads(out)["records"] == found["records"]
    assert "Share 1/1" in err
    assert json.loads(run("run", "study.toml", "--json", "--share", "2/2")[1])["records"] == []
    assert run("run", "study.toml", "--json", "--dry-run")[0] == 2


@pytest.mark.slow
def test_a_report(ask, run):
    compare = ["--cells", "8", "12", "--repeats", "1"]
    assert ask("report", *BODY, "--force", "1N", *compare) == {**PROBLEM, "load": FORCE}
    _, out, _ = run("report", *BODY, "--force", "1N", *compare, "--json")
    found = json.loads(out)
    assert [(case["nx"], case["estimator"]) for case in found["cases"]] == [
        (8, "blend"), (8, "cell-count"), (12, "blend"), (12, "cell-count"),
    ]  # fmt: skip
    assert found["reference"]["area"]["unit"] == "m2"
    assert found["advice"].startswith("For an area error of 0.5 %")


def test_a_check(ask, run):
    assert ask("check", "elastic", "--with", "young=1e9", "poisson=0.3") == {
        "material": "rc.Elastic(young=1e9, poisson=0.3)"
    }
    _, out, _ = run("check", "love", "--json")
    found = json.loads(out)
    assert found["passed"] is True
    assert len(found["claims"]) == 27
    assert {one["claim"] for one in found["claims"] if one["verdict"] != "holds"} == {"takes texts with units"}
