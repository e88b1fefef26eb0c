"""Responses as columns of a study: found once, kept, and found anew when their fields change; in study files too."""

from __future__ import annotations

import csv
from concurrent.futures import ProcessPoolExecutor

import attrs
import numpy as np
import pytest

import roughcontact as rc
from roughcontact.__main__ import main
from roughcontact.faces import describe_response
from scenes import ROUGH, make_problem
from unit_files import read_index, read_study


def conductance(conductivity=45.0):
    return rc.responses.create("conductance", conductivity=conductivity)


def build(seed):
    return make_problem(attrs.evolve(ROUGH, seed=seed), boundary="periodic")


def study(responses, **changes):
    return rc.Study(
        build, responses=responses, **{"pressure": [20e6, 50e6], "seed": range(2), "fields": True, **changes}
    )


@pytest.mark.slow
def test_they_are_those_of_the_solutions(tmp_path):
    first_yield = rc.responses.create("first-yield", yield_stress=1e9)
    result = study(["stiffness", conductance(), first_yield], seed=[0]).run(tmp_path)
    for record in result:
        solution = result.solution(record)
        stiffness = solution.stiffness()
        assert record.estimates["stiffness"] == rc.Estimate(stiffness.value, stiffness.uncertainty, "N/m")
        assert record.estimates["conductance"].value == solution.conductance(45.0).value
        assert record.estimates["first-yield force"].unit == "N"
        assert record.message == ""
    frame = result.to_pandas()
    assert list(frame["stiffness"]) == [record.estimates["stiffness"].value for record in result]
    assert frame.attrs["units"]["conductance_uncertainty"] == "W/K"
    result.to_csv(tmp_path / "table.csv")
    head = next(csv.reader((tmp_path / "table.csv").read_text(encoding="utf-8").splitlines()))
    assert "stiffness [N/m]" in head
    assert "first-yield force_uncertainty [N]" in head
    arrays = result.to_xarray()
    np.testing.assert_array_equal(arrays["stiffness"].values.ravel(), frame["stiffness"])
    assert arrays["conductance"].attrs["units"] == "W/K"
    assert "first-yield mean pressure" in str(result)
    axes = result.plot(y="stiffness")
    assert axes.get_ylabel().startswith("stiffness, ")


@pytest.mark.parametrize(
    ("name", "words"), [("stiffness", "normal stiffness"), ("leakage", "the slow flow of a liquid")]
)
def test_a_form_says_in_a_line_what_each_one_answers(name, words):
    assert describe_response(name).summary.startswith(words)


def test_they_are_kept_and_asked_again_when_they_change(tmp_path, monkeypatch):
    first = study(["stiffness", conductance()]).run(tmp_path)
    asked = []
    respond = rc.ContactSolution.response
    monkeypatch.setattr(
        rc.ContactSolution, "response", lambda self, one: asked.append(type(one).__name__) or respond(self, one)
    )
    again = study(["stiffness", conductance()]).run(tmp_path)
    assert again.records == first.records
    assert "Conductance" not in str(asked)
    changed = study(["stiffness", conductance(90.0)]).run(tmp_path)
    assert changed.computed == 0
    assert sum("onductance" in name for name in asked) == len(changed)
    for one, other in zip(changed, first, strict=True):
        assert one.estimates["conductance"].value == pytest.approx(2.0 * other.estimates["conductance"].value)
        assert one.estimates["stiffness"] == other.estimates["stiffness"]
    # What is not asked for is kept.
    assert study([]).run(tmp_path).records == changed.records


def test_records_without_answers_are_listed_as_before(tmp_path):
    plain = study([]).run(tmp_path)
    assert "answers" not in next(tmp_path.glob("*.json")).read_text(encoding="utf-8")
    answered = study("stiffness").run(tmp_path)
    assert answered.computed == 0
    listed = [read_index(path) for path in tmp_path.glob("*.json")]
    assert any(records[plain[0].key] == answered[0] for records in listed)


def test_a_refusal_leaves_a_message(tmp_path):
    wrapped = rc.ContactProblem(
        rc.Body(rc.ParaboloidSurface(1e-3), rc.Elastic(210e9, 0.3)), grid=rc.Grid((16, 16), 1e-4), boundary="wrapped"
    )
    result = rc.Study(wrapped, force=[1.0], responses=["stiffness", "mean-gap", "patches"]).run(tmp_path)
    assert "stiffness" not in result[0].estimates
    assert "The response 'stiffness'" in result[0].message
    assert result.failed == result.records
    assert result[0].estimates["mean-gap"].value > 0.0
    assert "1 without all areas and answers" in str(result)


@pytest.mark.parametrize(
    ("responses", "sentence"),
    [
        (["stiffness", rc.responses.create("stiffness")], "asked for twice"),
        ("stifness", "Did you mean 'stiffness'"),
        ("leakage", "viscosity="),
        (3, "registered name"),
        ([3], "registered name"),
    ],
)
def test_wrong_ones_get_a_sentence(responses, sentence):
    with pytest.raises(rc.InputError, match=sentence):
        study(responses)


def test_study_files_and_processes_give_the_same(tmp_path):
    text = """
[problems.ball]
grid = {shape = [24, 24], size = "100um"}
body = {surface = {type = "sphere", radius = "1mm"}, material = "bearing steel"}

[study]
force = ["0.5N", "1N"]
responses = ["stiffness", {type = "leakage", viscosity = "1mPa.s", pressure_drop = "1bar"}]
"""
    (tmp_path / "study.toml").write_text(text, encoding="utf-8")
    read = read_study(tmp_path / "study.toml")
    one = read.run(tmp_path / "one")
    with ProcessPoolExecutor(1) as executor:
        other = read.run(tmp_path / "other", executor=executor)
    assert [record.estimates for record in one] == [record.estimates for record in other]
    leakage = one.solution(one[1]).leakage(viscosity=1e-3, pressure_drop=1e5)
    assert one[1].estimates["leakage"].value == leakage.value
    wrong = text.replace('viscosity = "1mPa.s"', 'viscosity = "1m"')
    (tmp_path / "study.toml").write_text(wrong, encoding="utf-8")
    with pytest.raises(rc.InputError, match=r"study.responses\[1\].viscosity"):
        read_study(tmp_path / "study.toml")


def test_a_path_is_asked_at_its_end(tmp_path):
    steel = rc.Elastic(210e9, 0.3)
    bodies = [rc.Body(surface, steel) for surface in (rc.ParaboloidSurface(1e-3), rc.FlatSurface())]
    problem = rc.ContactProblem(*bodies, grid=rc.Grid((24, 24), 1e-4))
    sheared = rc.Study(
        problem, force=[1.0], tangential_force=[(0.1, 0.0)], friction=0.3, responses=["tangential-stiffness"]
    )
    result = sheared.run(tmp_path)
    expected = result.path(result[0])[-1].response("tangential-stiffness")
    assert result[0].estimates["tangential-stiffness"].value == expected.value
    assert sheared.run(tmp_path).records == result.records


@pytest.mark.slow
def test_a_warned_answer_makes_a_record_doubtful(tmp_path, capsys):
    (tmp_path / "study.toml").write_text("""
[problems.ball]
grid = {shape = [48, 40], size = "400 um"}
body = {surface = {type = "sphere", radius = "10 mm"}, material = {young = "5 MPa", poisson = 0.5}}
[study]
force = [1e-3, 2e-3]
responses = ["stiffness", {type = "first-yield", yield_stress = "200 kPa"}]
""")
    study = str(tmp_path / "study.toml")
    # Solved, and read from the disk.
    for _ in range(2):
        assert main(["run", study]) == 3
        assert "first yield force" in capsys.readouterr().out
    (tmp_path / "study.toml").write_text(
        (tmp_path / "study.toml")
        .read_text()
        .replace("first-yield", "mean-gap", 1)
        .replace(', yield_stress = "200 kPa"', "")
    )
    assert main(["run", study, "-o", str(tmp_path / "other")]) == 0
