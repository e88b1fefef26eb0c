"""What the contact does, asked for on the command line: an option for each registered response."""

from __future__ import annotations

import csv
import io
import json
import re
import types
from pathlib import Path

import attrs
import numpy as np
import pytest

import roughcontact as rc
from roughcontact.typing import Table
from scenes import read_problem

SIZE = (96e-6, 32e-6)
SHAPE = (48, 48)
LOADED = ["solve", "map.npz", "--boundary", "periodic", "--young", "210GPa"]


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """A rough map of cells 3 : 1 in the working folder."""
    monkeypatch.chdir(tmp_path)
    rough = rc.SelfAffineSurface(hurst=0.8, rms_height=50e-9, shortest=9e-6, longest=32e-6, seed=3)
    np.savez("map.npz", heights=rough.heights(rc.Grid(SHAPE, SIZE)), size=SIZE, periodic=True)


def solve(**load):
    return read_problem("map.npz").solve(**load)


def same(found, estimate):
    places = {} if estimate.sampling is None else {"sampling": pytest.approx(estimate.sampling, rel=1e-9)}
    return found == {
        **places,
        "value": pytest.approx(estimate.value, rel=1e-12),
        "uncertainty": pytest.approx(estimate.uncertainty, rel=1e-9),
        "unit": estimate.unit,
        "warnings": list(estimate.warnings),
    }


def test_the_object_has_the_answers_of_a_script(run):
    asked = ["--stiffness", "--conductance", "45,16", "film_resistance=1e-9", "--tangential-stiffness", "axis=1"]
    asked += ["--leakage", "viscosity=1mPa.s", "pressure_drop=1bar", "--first-yield", "1GPa", "friction=10%"]
    asked += ["--stress", "depths=0.5um,1um", "body=body", "--partial-slip", "tangential_force=1mN", "friction=0.3"]
    status, out, _ = run(*LOADED, "--force", "20mN", *asked, "--json")
    assert status in (0, 3)
    found = json.loads(out)["responses"]
    solution = solve(force=20e-3)
    assert same(found["stiffness"], solution.stiffness())
    assert same(found["conductance"], solution.conductance((45.0, 16.0), film_resistance=1e-9))
    assert same(found["tangential-stiffness"], solution.response(rc.responses.create("tangential-stiffness", axis=1)))
    assert same(found["leakage"], solution.leakage(viscosity=1e-3, pressure_drop=1e5))
    point = solution.first_yield(yield_stress=1e9, friction=0.1)
    assert same(found["first-yield"]["force"], point.force)
    assert same(found["first-yield"]["mean_pressure"], point.mean_pressure)
    stress = solution.stress([0.5e-6, 1e-6])
    assert same(found["stress"]["von_mises"], stress.maximum)
    assert same(found["stress"]["shear"], stress.maximum_shear)
    slip = solution.partial_slip(tangential_force=1e-3, friction=0.3)
    assert set(found["partial-slip"]) == {"displacement", "stick_area", "slip_area", "energy"}
    assert same(found["partial-slip"]["displacement"], slip.displacement)


def test_the_text_ends_with_what_a_script_prints(run):
    """Each warning is said once, and other places of the map after the answers that know of them."""
    status, out, _ = run(*LOADED, "--force", "20mN", "--stiffness", "--stress", "depths=300nm")
    assert status in (0, 3)
    solution = solve(force=20e-3)
    words = " ".join(out.split())
    stiffness = solution.stiffness()
    number, *_ = str(stiffness).split("; uncertain")
    assert f"stiffness {number} stress stress at 1 depth" in words
    stress = solution.stress([3e-7]).maximum
    number, *reasons = " ".join(str(stress).split()).split("; uncertain: ")
    assert number in words
    assert reasons == list(stress.warnings) != []
    for text in (*reasons, *stiffness.warnings, *solution.area().warnings):
        assert words.count(text) == 1
    assert words.endswith(
        f"other places stiffness +- {100 * stiffness.sampling / stiffness.value:.0f} % (standard deviation)"
    )
    assert max(map(len, out.splitlines())) <= 80


def test_several_loads_are_rows(run):
    loads = [0.02, 0.04]
    asked = ["--loads", "20mN", "40mN", "--stiffness", "--first-yield", "1GPa"]
    _, out, _ = run(*LOADED, *asked, "--csv")
    rows = list(csv.DictReader(io.StringIO(out)))
    for row, load in zip(rows, loads, strict=True):
        stiffness = solve(force=load).stiffness()
        assert float(row["stiffness [N/m]"]) == pytest.approx(stiffness.value, rel=1e-4)
        assert float(row["stiffness_uncertainty [N/m]"]) == pytest.approx(stiffness.uncertainty, rel=1e-2)
        assert float(row["first-yield force [N]"]) > 0.0
    _, out, _ = run(*LOADED, *asked)
    words = " ".join(out.split())
    assert "force, mN stiffness," in words
    assert "first-yield mean_pressure" in words
    assert re.search(r"other places stiffness \+- \d+ % at 20 mN, \+- \d+ % at 40 mN \(standard deviation\)", words)
    assert max(map(len, out.splitlines())) <= 80


def test_a_response_of_a_plug_in_has_its_option(run, monkeypatch):
    @attrs.frozen
    class OpenVolume(rc.Response):
        """Volume between the surfaces."""

        above: float = attrs.field(default=0.0, metadata={"unit": "m"})

        def respond(self, solution):
            volume = float(solution.gap[solution.gap > self.above].sum()) * solution.grid.cell_area
            return rc.Estimate(volume, 0.01 * volume, "m3")

    monkeypatch.setitem(rc.responses._classes, "open-volume", OpenVolume)
    _, out, _ = run(*LOADED, "--force", "20mN", "--open-volume", "above=10nm", "--json")
    found = json.loads(out)["responses"]["open-volume"]
    assert same(found, OpenVolume(10e-9).respond(solve(force=20e-3)))


def test_commas_separate_fields_too(run):
    fields = ["viscosity=1mPa.s", "pressure_drop=1bar"]
    printed = [run(*LOADED, "--force", "20mN", "--json", "--leakage", *form) for form in (fields, [",".join(fields)])]
    apart, joined = (json.loads(out)["responses"]["leakage"] for _, out, _ in printed)
    assert apart == joined


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        (["--leakage", "viscosity=1mPa.s,drop=1bar"], "--leakage: unknown field 'drop' (known: axis, viscosity,"),
        (["--stability"], "--stability: Without adhesion each state is stable"),
        (["--conductance"], "expected at least one argument"),
        (["--conductance", "film_resistance=1"], "--conductance: required field 'conductivity' is missing"),
        (["--first-yield", "1"], "--first-yield yield_stress: '1' has no unit (Pa, MPa or GPa?)"),
        (["--leakage", "viscosity=1mPas", "pressure_drop=1bar"], "is not a quantity in units of Pa s"),
        (["--leakage", "viscosity=1mPa.s", "pressure_drop=-1bar"], "The pressure drop must be"),
        (["--stress", "depth=1um"], "--stress: unknown field 'depth' (did you mean 'depths'?)"),
        (["--stiffness", "3"], "A field of --stiffness must be FIELD=VALUE, but got '3'."),
        (
            ["--first-yield", "1GPa", "--friction", "0.3", "--tangential", "1mN"],
            "is not for a contact with friction",
        ),
        (["--partial-slip", "tangential_force=1mN", "friction=0.3", "--friction", "0.3", "--slide"], "their own"),
    ],
)
def test_what_is_wrong_is_a_sentence(run, asked, words):
    status, out, err = run(*LOADED, "--force", "20mN", *asked)
    assert status == 2
    assert words in " ".join(err.split())
    assert out == ""


STICKY = ["--adhesion", "exponential", "work=50mJ/m2", "range=2um"]


def test_responses_along_a_cycle(run):
    pytest.importorskip("matplotlib")
    law = rc.Exponential(work=50e-3, range=2e-6)
    body = rc.Body(rc.read_surface("map.npz"), rc.Elastic(210e9, 0.3))
    problem = rc.ContactProblem(body, boundary="periodic", adhesion=law)
    cycle = problem.cycle(approach=[-0.5e-6, 0.1e-6])
    arguments = [*LOADED, *STICKY, "--cycle", "-0.5um", "0.1um", "--states", "2"]
    _, out, _ = run(*arguments, "--stiffness", "--stability", "--json")
    found = json.loads(out)
    rows = found["states"]
    assert [row["branch"] for row in rows] == ["loading", "loading", "unloading", "unloading"]
    assert rows[1]["stiffness"] == rows[2]["stiffness"]
    assert rows[1]["stiffness"]["value"] == pytest.approx(cycle.loading[-1].stiffness().value, rel=1e-6)
    assert set(found["inputs"]["responses"]) == {"stiffness", "stability"}
    _, out, _ = run(*arguments, "--stiffness", "--csv")
    assert [float(row["stiffness [N/m]"]) for row in csv.DictReader(io.StringIO(out))] == pytest.approx(
        [row["stiffness"]["value"] for row in rows], rel=1e-9
    )
    _, out, _ = run(*arguments, "--stiffness", "--report", "r.html")
    assert re.search(r"branch +approach +stiffness, \w*N/m\n(?:(?:un)?loading .*\n){4}", out)
    assert "stiffness, " in words_of("r.html")


def test_states_without_an_answer_are_counted(run, monkeypatch):
    monkeypatch.setitem(rc.responses._classes, "pressed", Pressed)
    arguments = [*LOADED, *STICKY, "--cycle", "-0.5um", "0.1um", "--states", "2"]
    _, out, _ = run(*arguments, "--pressed")
    assert "pressed: 2 of 3 states have no answer: Nothing presses." in out
    _, out, _ = run(*arguments, "--pressed", "--json")
    found = json.loads(out)
    assert found["without_answer"] == {"pressed": "2 of 3 states have no answer: Nothing presses."}
    assert found["states"][0]["pressed"]["value"] is None


class Pressed(rc.Response):
    holds_with = frozenset({"tension", "shear"})

    def respond(self, solution):
        if solution.force < 0.0:
            raise rc.InputError("Nothing presses.")
        return rc.Estimate(1.0, 0.1, "m")


@pytest.mark.slow
def test_responses_along_a_path(run):
    pytest.importorskip("matplotlib")
    steel = rc.Body(rc.read_surface("map.npz"), rc.Elastic(210e9, 0.3))
    problem = rc.ContactProblem(steel, rc.Body(rc.FlatSurface(), rc.Elastic(210e9, 0.3)), boundary="periodic")
    path = problem.path(force=20e-3, tangential_force=[(3e-3, 0.0), (-3e-3, 0.0)], friction=0.3)
    arguments = [*LOADED, "--force", "20mN", "--counterbody-young", "210GPa", "--friction", "0.3"]
    moved = ["--tangential", "3mN", "-3mN"]
    _, out, _ = run(*arguments, *moved, "--stiffness", "--stress", "--json")
    found = json.loads(out)
    for row, state in zip(found["states"], path, strict=True):
        assert row["stiffness"]["value"] == pytest.approx(state.stiffness().value, rel=1e-6)
        # Under pressure and traction.
        assert row["stress von_mises"]["value"] == pytest.approx(state.stress().maximum.value, rel=1e-4)
    assert set(found["inputs"]["responses"]) == {"stiffness", "stress"}
    _, out, _ = run(*arguments, *moved, "--stiffness", "--report", "r.html")
    assert re.search(r"state +tangential_x .*stiffness, \w*N/m", out)
    assert "stiffness, " in words_of("r.html")
    _, out, _ = run(*arguments, *moved, "--stiffness", "--csv")
    assert "stiffness_uncertainty [N/m]" in out.splitlines()[0]
    _, out, _ = run(*arguments, "--slide", "--stiffness", "--json")
    assert json.loads(out)["responses"]["stiffness"]["unit"] == "N/m"


def test_the_numbers_of_the_area_have_the_estimator_that_is_named(run):
    _, out, _ = run(*LOADED, "--force", "20mN", "--patches", "estimator=cell-count", "--json")
    assert (
        json.loads(out)["responses"]["patches"]["value"]
        == solve(force=20e-3).response(rc.responses.create("patches", estimator="cell-count")).value
    )


def words_of(path):
    """Return the words of a page, without its tags."""
    return " ".join(re.sub("<[^>]*>", " ", Path(path).read_text(encoding="utf-8")).split())


@pytest.mark.parametrize("place", [["--report", "r.html"], ["--quiet", "-o", "r.html"]])
@pytest.mark.usefixtures("no_pictures")
def test_a_report_has_the_answers(run, place):
    pytest.importorskip("matplotlib")
    asked = ["--stiffness", "--conductance", "45", "--leakage", "viscosity=1mPa.s", "pressure_drop=1bar"]
    status, _, err = run(*LOADED, "--force", "20mN", *asked, *place)
    assert status in (0, 3), err
    solution = solve(force=20e-3)
    page = words_of("r.html")
    assert "What the contact does" in page
    for found in (
        solution.stiffness(),
        solution.conductance(45.0),
        solution.leakage(viscosity=1e-3, pressure_drop=1e5),
    ):
        table = Table({"found": [found]})
        heading, ((cell,),) = table.to_cells()
        assert cell in page
        assert heading[0].partition(", ")[2] in page


@pytest.mark.slow
def test_a_report_of_several_loads_has_a_row_for_each(run):
    pytest.importorskip("matplotlib")
    run(*LOADED, "--loads", "20mN", "40mN", "--stiffness", "--report", "r.html")
    body = rc.Body(rc.read_surface("map.npz"), rc.Elastic(210e9, 0.3))
    sweep = rc.ContactProblem(body, boundary="periodic").sweep(force=[20e-3, 40e-3])
    page = words_of("r.html").partition("What the contact does")[2]
    _, cells = Table({"found": [solution.stiffness() for solution in sweep]}).to_cells()
    assert all(cell in page for (cell,) in cells)


@pytest.mark.usefixtures("no_pictures")
def test_a_report_has_the_load_that_was_searched(run):
    pytest.importorskip("matplotlib")
    run(
        "solve",
        "map.npz",
        "--boundary",
        "periodic",
        "--young",
        "210GPa",
        "--solve-for",
        "area=10%",
        "--report",
        "r.html",
    )
    assert "required-load force" in words_of("r.html")


class Halves(rc.Response):
    """Numbers of some contacts only."""

    def respond(self, solution):
        if solution.force > 30e-3:
            return "no number here"
        return types.SimpleNamespace(estimates={"low": rc.Estimate(1.5, 0.1, "m")})


@pytest.mark.slow
def test_answers_without_a_number_stay_beside_those_with_one(run, monkeypatch):
    pytest.importorskip("matplotlib")
    monkeypatch.setitem(rc.responses._classes, "halves", Halves)
    _, out, _ = run(*LOADED, "--loads", "20mN", "40mN", "--halves", "--report", "r.html")
    assert "no number here" in out
    assert "no number here" in words_of("r.html")
    _, out, _ = run(*LOADED, "--loads", "20mN", "40mN", "--halves", "--csv")
    low = [row["halves low [m]"] for row in csv.DictReader(io.StringIO(out))]
    assert low == ["1.5", "nan"]


@pytest.mark.usefixtures("no_pictures")
def test_a_response_without_an_answer_leaves_the_report(run):
    pytest.importorskip("matplotlib")
    status, out, err = run(*LOADED, "--force", "20mN", "--stability", "-o", "one.npz", "--report", "r.html")
    assert status == 2
    assert "--stability: Without adhesion" in err
    assert out == ""
    assert "Contact report" in words_of("r.html")
    assert rc.ContactSolution.load("one.npz").force == pytest.approx(20e-3)


def test_a_warned_answer_shows_in_the_exit_status(run):
    heights = rc.SphereSurface(10e-3).heights(rc.Grid((48, 40), (400e-6, 400e-6)))
    np.savez("ball.npz", heights=heights, size=(400e-6, 400e-6))
    solved = ["solve", "ball.npz", "--force", "1mN", "--young", "5MPa", "--poisson", "0.5"]
    assert run(*solved, "--stiffness")[0] == 0
    asked = ["--first-yield", "200kPa"]
    status, _, err = run(*solved, *asked)
    assert (status, err) == (3, "roughcontact: The solution is converged, but doubtful: see its warnings.\n")
    for output in (["--json"], ["--csv"], ["--quiet", "-o", "ball.json"]):
        assert run(*solved, *asked, *output)[0] == 3
    # An area that was asked for beside the default, on 40 cells.
    assert run(*solved, "--area", "hertz")[0] in (0, 3)
    along = ["--counterbody-young", "5MPa", "--counterbody-poisson", "0.5", "--friction", "0.5", "--slide"]
    assert run(*solved, *along)[0] == 0
    assert run(*solved, *along, "--stress", "depths=1um,2um")[0] == 3
