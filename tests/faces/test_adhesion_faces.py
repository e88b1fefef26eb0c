"""Adhesion through the doors of those who do not script: command line, study files, figures, reports, the kit."""

from __future__ import annotations

import csv
import html
import json
import re
import runpy

import attrs
import numpy as np
import pytest

import roughcontact as rc
from roughcontact import testing as kit
from roughcontact.__main__ import main

LAW = ["--adhesion", "exponential", "work=50mJ/m2", "range=60nm"]
BODY = ["--young", "5MPa", "--poisson", "0.5"]


def write_ball(folder):
    grid = rc.Grid((32, 32), 8e-6)
    np.savez(folder / "ball.npz", heights=rc.ParaboloidSurface(2e-6).heights(grid), size=grid.size)
    return folder / "ball.npz"


@pytest.fixture(scope="module")
def ball(tmp_path_factory):
    return write_ball(tmp_path_factory.mktemp("maps"))


def run(capsys, *arguments):
    try:
        status = main([str(argument) for argument in arguments])
    except SystemExit as ended:
        status = ended.code
    return status, capsys.readouterr()


def make_problem(**options):
    body = rc.Body(rc.ParaboloidSurface(2e-6), rc.Elastic("5MPa", 0.5))
    return rc.ContactProblem(body, grid=rc.Grid((32, 32), 8e-6), adhesion=rc.Exponential("50mJ/m2", "200nm"), **options)


@pytest.fixture(scope="module")
def solution():
    return make_problem().solve(pressure=0.0)


class TestCommand:
    def test_solves_without_a_load_as_a_script_does(self, ball, capsys):
        _, printed = run(capsys, "solve", ball, "--force", "0N", *BODY, *LAW, "--json")
        found = json.loads(printed.out)
        heights = rc.read_surface(ball)
        problem = rc.ContactProblem(
            rc.Body(heights, rc.Elastic(5e6, 0.5)), adhesion=rc.Exponential(work=0.05, range=60e-9)
        )
        expected = problem.solve(force=0.0)
        assert found["area"]["value"] == expected.area().value
        assert found["attractive_area"]["value"] == expected.attractive_area().value
        assert found["force"]["value"] == 0.0
        assert 0.0 < found["residuals"]["tension"] < 1e-4

    def test_finds_pull_off(self, ball, capsys):
        law = ["--adhesion", "exponential", "work=50mJ/m2", "range=200nm"]
        _, printed = run(capsys, "solve", ball, "--force", "0N", *BODY, *law, "--pull-off")
        (line,) = (line for line in printed.out.splitlines() if line.startswith("pull-off"))
        assert "-" in line
        assert "nN +-" in line

    @pytest.mark.slow
    def test_pull_off_is_in_json_csv_and_the_report(self, ball, capsys, tmp_path):
        options = ["--force", "0N", *BODY, "--adhesion", "exponential", "work=50mJ/m2", "range=200nm", "--pull-off"]
        body = rc.Body(rc.read_surface(ball), rc.Elastic("5MPa", 0.5))
        expected = rc.ContactProblem(body, adhesion=rc.Exponential("50mJ/m2", "200nm")).pull_off()
        assert expected.uncertainty > 0.0
        report = tmp_path / "report.html"
        found = json.loads(run(capsys, "solve", ball, *options, "--json", "--report", report)[1].out)
        numbers = {name: getattr(expected, name) for name in ("value", "uncertainty", "unit")}
        assert found["responses"]["pull-off"] == {**numbers, "warnings": list(expected.warnings)}
        (row,) = csv.DictReader(run(capsys, "solve", ball, *options, "--csv")[1].out.splitlines())
        assert float(row["pull-off [N]"]) == expected.value
        assert float(row["pull-off_uncertainty [N]"]) == expected.uncertainty
        words = re.sub(r"<[^>]*>", " ", report.read_text(encoding="utf-8"))
        head, cell = rc.typing.Table({"pull-off": [expected]}).to_text().replace("+-", "±").split("\n")
        assert re.search(rf"load\s+{re.escape(head.strip())}\s", words)
        assert cell.strip() in words

    def test_pulls_at_several_loads_in_their_order(self, ball, capsys):
        _, printed = run(capsys, "solve", ball, "--loads", "20nN", "0nN", "-20nN", *BODY, *LAW, "--csv")
        rows = [line.split(",") for line in printed.out.splitlines()]
        force = [float(row[rows[0].index("force [N]")]) for row in rows[1:]]
        assert force == pytest.approx([20e-9, 0.0, -20e-9], abs=1e-15)

    @pytest.mark.parametrize(
        ("arguments", "sentence"),
        [
            (["--adhesion", "exponential", "work=50", "range=60nm"], "'50' has no unit (mJ/m2 or J/m2?)"),
            (
                ["--adhesion", "exponential", "work=50mJ/m2"],
                "exponential: required field 'range' is missing",
            ),
            (["--adhesion", "exponential", "work=50mJ/m2", "reach=1nm"], "unknown field 'reach' (known: work, range)"),
            (["--adhesion", "glue", "work=50mJ/m2"], "There is no interaction named 'glue'"),
            (["--pull-off"], "--pull-off is for surfaces that attract each other"),
            (["--states", "5"], "--states is for --cycle"),
        ],
    )
    def test_refuses_in_a_sentence(self, ball, capsys, arguments, sentence):
        status, printed = run(capsys, "solve", ball, "--force", "1nN", *BODY, *arguments)
        assert status == 2
        assert sentence in printed.err
        assert printed.out == ""


class TestCycleOfTheCommand:
    LAW = ("--adhesion", "exponential", "work=50mJ/m2", "range=200nm")
    CYCLE = ("--cycle", "-300nm", "300nm", "--states", "5")

    @pytest.fixture(scope="class")
    @staticmethod
    def cycle():
        return make_problem().cycle(approach=np.linspace(-300e-9, 300e-9, 5))

    def test_prints_the_cycle_of_a_script_and_draws_it(self, ball, capsys, cycle, tmp_path):
        picture = tmp_path / "cycle.png"
        status, printed = run(capsys, "solve", ball, *self.CYCLE, *BODY, *self.LAW, "-o", picture)
        assert status == 0
        assert str(cycle) in printed.out
        assert picture.read_bytes()[:4] == b"\x89PNG"

    def test_prints_the_states_for_programs(self, ball, capsys, cycle, tmp_path):
        _, printed = run(capsys, "solve", ball, *self.CYCLE, *BODY, *self.LAW, "--csv")
        cycle.to_csv(tmp_path / "cycle.csv")
        expected = (tmp_path / "cycle.csv").read_text(encoding="utf-8")
        assert printed.out.splitlines() == expected.splitlines()
        _, printed = run(capsys, "solve", ball, *self.CYCLE, *BODY, *self.LAW, "--json")
        found = json.loads(printed.out)
        assert found["pull_off"]["value"] == cycle.pull_off.value
        assert found["dissipated"]["unit"] == "J"
        assert [state["force"] for state in found["states"]] == [*cycle.loading.force, *cycle.unloading.force]

    def test_ends_with_three_where_a_force_alone_is_doubtful(self, ball, capsys):
        short = ("--cycle", "0nm", "300nm", "--states", "2")
        status, printed = run(capsys, "solve", ball, *short, *BODY, *self.LAW)
        assert status == 3
        assert "continue it" in " ".join(printed.out.split())

    @pytest.mark.parametrize(
        ("arguments", "sentence"),
        [
            ((*CYCLE,), "--cycle is for surfaces that attract each other"),
            (("--cycle", "3nm", "-3nm", *LAW), "--cycle needs its lower approach first, but got 3 nm and -3 nm"),
            ((*CYCLE, *LAW, "--states", "1"), "The number of --states must be at least 2, but got 1"),
            ((*CYCLE, *LAW, "--pull-off"), "--pull-off is for single loads"),
            ((*CYCLE, *LAW, "-o", "cycle.nc"), "must be a file that ends in"),
            ((*CYCLE, "--adhesion", "exponential", "work=50mJ/m2", "range=1nm"), "A path cannot be followed"),
            ((*CYCLE, "--dry-run", "--adhesion", "exponential", "work=50mJ/m2", "range=1nm"), "cannot be followed"),
        ],
    )
    def test_refuses_in_a_sentence(self, ball, capsys, arguments, sentence):
        status, printed = run(capsys, "solve", ball, *BODY, *arguments)
        assert status == 2
        assert sentence in " ".join(printed.err.split())


def test_study_file(tmp_path):
    (tmp_path / "study.toml").write_text(
        """
[problems.sticky]
grid = {shape = [32, 32], size = ["8um", "8um"]}
body = {surface = {type = "paraboloid", radius = "2um"}, material = {type = "elastic", young = "5MPa", poisson = 0.5}}
adhesion = {type = "exponential", work = "50mJ/m2", range = "200nm"}

[study]
force = [0.0, 20e-9]
""",
        encoding="utf-8",
    )
    from unit_files import read_study

    result = read_study(tmp_path / "study.toml").run(tmp_path / "results")
    states = [result.solution(record) for record in result]
    assert [state.force for state in states] == pytest.approx([0.0, 20e-9], abs=1e-15)
    assert all(state.status.success for state in states)
    expected = make_problem().solve(force=0.0)
    assert states[0].area().value == expected.area().value


class TestFigures:
    def test_tension_is_drawn_outside_the_contact(self, solution):
        axes = solution.plot("tension")
        image = axes.images[0].get_array()
        drawn = ~np.ma.getmaskarray(np.ma.masked_invalid(image))
        assert np.count_nonzero(drawn) == np.count_nonzero(~solution.contact)
        plain = make_plain()
        with pytest.raises(rc.InputError, match="do not attract"):
            plain.plot("tension")

    def test_pressure_is_that_of_the_contact(self, solution):
        image = solution.plot("pressure").images[0].get_array()
        assert np.nanmin(np.ma.filled(image, np.nan)) > 0.0

    def test_cycle_shows_both_branches(self):
        cycle = make_problem().cycle(approach=np.linspace(-0.3e-6, 0.3e-6, 5))
        axes = cycle.plot()
        labels = {line.get_label(): line for line in axes.lines}
        assert {"loading", "unloading"} <= set(labels)
        assert list(axes.lines[-1].get_ydata()) == [0.0, 0.0]
        drawn = labels["unloading"].get_ydata()
        assert drawn / np.abs(drawn).max() == pytest.approx(
            cycle.unloading.force / np.abs(cycle.unloading.force).max(), rel=1e-6
        )
        assert "dissipated" in str(cycle)

    def test_jumps_are_marked(self):
        body = rc.Body(rc.ParaboloidSurface(6e-6), rc.Elastic("5MPa", 0.5))
        law = rc.Exponential("50mJ/m2", "30nm")
        problem = rc.ContactProblem(body, grid=rc.Grid((80, 80), 5e-6), adhesion=law)
        found = []
        cycle = problem.cycle(approach=np.linspace(-0.3e-6, 0.1e-6, 9), on_state=found.append)
        assert found == [*cycle.loading, *cycle.unloading[1:]]
        assert len(cycle.jumps) == sum(int(steps.sum()) for steps in cycle.jump_steps) == 2
        axes = cycle.plot()
        drawn = [line for line in axes.lines if line.get_linestyle() == ":"]
        assert len(drawn) == 2
        assert [line.get_label() for line in axes.lines[:3]] == ["loading", "unloading", "jump"]
        # A jump joins two states of its branch.
        loading, _, jump = (line.get_xydata() for line in axes.lines[:3])
        assert {tuple(end) for end in jump} <= {tuple(state) for state in loading}
        marked = [line for line in str(cycle).splitlines() if line.endswith("jump")]
        assert [line.split()[0] for line in marked] == ["loading", "unloading"]
        # The warning of the range, once and wrapped.
        assert str(cycle).count("cohesive length") == 1
        assert all(len(line) <= 80 for line in str(cycle).splitlines())
        assert "cohesive" not in repr(cycle)
        assert "<table>" in cycle._repr_html_()

    def test_coarse_steps_without_hysteresis_are_no_jumps(self):
        cycle = make_problem().cycle(approach=np.linspace(-0.6e-6, 0.6e-6, 4))
        assert cycle.jumps == ()
        assert abs(cycle.dissipated.value) < 1e-3 * np.abs(np.concatenate(cycle.losses)).max()

    def test_table_has_both_branches(self, tmp_path):
        cycle = make_problem().cycle(approach=[-0.3e-6, 0.0, 0.3e-6])
        frame = cycle.to_pandas()
        assert list(frame["branch"]) == ["loading"] * 3 + ["unloading"] * 3
        np.testing.assert_array_equal(frame["force"], [*cycle.loading.force, *cycle.unloading.force])
        assert frame["lost"].sum() == pytest.approx(cycle.dissipated.value)
        assert frame.attrs["units"]["lost"] == "J"


def make_plain():
    body = rc.Body(rc.ParaboloidSurface(2e-6), rc.Elastic("5MPa", 0.5))
    return rc.ContactProblem(body, grid=rc.Grid((32, 32), 8e-6)).solve(force=1e-8)


@pytest.mark.usefixtures("no_pictures")
def test_report_solves_it_again(solution, tmp_path, capsys):
    text = solution.to_html()
    start = text.index("import hashlib")
    script = text[start : text.index("</", start)].replace("&quot;", '"').replace("&#x27;", "'").replace("&gt;", ">")
    assert "rc.Exponential(" in script
    path = tmp_path / "again.py"
    path.write_text(script, encoding="utf-8")
    again = runpy.run_path(str(path))["solution"]
    assert np.array_equal(again.pressure, solution.pressure)
    assert np.array_equal(again.tension, solution.tension)


@pytest.mark.slow
def test_report_of_a_cycle_solves_it_again(tmp_path):
    cycle = make_problem().cycle(approach=np.linspace(-0.3e-6, 0.3e-6, 4))
    cycle.to_html(tmp_path / "cycle.html")
    page = (tmp_path / "cycle.html").read_text(encoding="utf-8")
    assert "Pull-off" in page
    assert page.count("<td>") > 3 * 8
    start = page.index("import roughcontact as rc")
    (tmp_path / "again.py").write_text(html.unescape(page[start : page.index("</", start)]))
    again = runpy.run_path(str(tmp_path / "again.py"))["cycle"]
    for one, other in zip((*again.loading, *again.unloading), (*cycle.loading, *cycle.unloading), strict=True):
        assert np.array_equal(one.pressure, other.pressure)


@pytest.mark.parametrize(
    "law",
    [
        rc.Exponential(0.05, 2e-9),
        rc.Dugdale(0.05, 1e7),
        rc.VanDerWaals(0.03, 3e-10),
        rc.ShortRange(0.05),
        rc.Exponential(np.linspace(0.02, 0.05, 12).reshape(3, 4), 2e-9),
    ],
    ids=str,
)
def test_laws_hold_what_is_claimed(law):
    kit.check(law).raise_for_failures()


class Rising(rc.Interaction):
    """A law whose slope is that of another one."""

    def tension(self, gap):
        return 1e6 * np.exp(-np.asarray(gap) / 1e-9)

    def slope(self, gap):
        return 1e15 * np.exp(-np.asarray(gap) / 1e-9)

    def energy(self, gap):
        return -1e-3 * np.exp(-np.asarray(gap) / 1e-9)


def test_the_kit_finds_a_wrong_slope():
    broken = [finding.claim for finding in kit.check(Rising()).failures]
    assert "slope is the derivative of the tension" in broken


class TestStiffness:
    def test_is_the_slope_of_the_force_over_the_approach(self, solution):
        found = solution.stiffness()
        # As the contact grows cell by cell, the slope on one grid oscillates about that of a finer one.
        fine = attrs.evolve(make_problem(), grid=rc.Grid((128, 128), 8e-6))
        step = 4e-8
        middle = fine.solve(pressure=0.0)
        above, below = (fine.solve(approach=middle.approach + change).force for change in (step, -step))
        assert found.value == pytest.approx((above - below) / (2.0 * step), rel=0.03)
        assert 0.0 < found.uncertainty < 0.1 * found.value

    def test_differs_from_that_of_the_contact_alone(self, solution):
        # The tension beside the contact falls as the bodies part: the contact alone would be stiffer.
        body = rc.Body(rc.ParaboloidSurface(2e-6), rc.Elastic("5MPa", 0.5))
        plain = rc.ContactProblem(body, grid=rc.Grid((32, 32), 8e-6))
        same_area = plain.solve_area(solution.area().fraction)
        assert solution.stiffness().value < 0.98 * same_area.stiffness().value


class TestPullOff:
    """The force of pull-off as an answer beside others: in studies, tables of loads, JSON."""

    STUDY = """
[problems.sticky]
grid = {shape = [33, 31], size = ["8 um", "9 um"]}
adhesion = {type = "exponential", work = "50 mJ/m2", range = "200 nm"}
body = {surface = {type = "paraboloid", radius = "2 um"}, material = {young = "5 MPa", poisson = 0.5}}

[study]
force = [1e-7, 0.0]
responses = ["pull-off", {type = "first-yield", yield_stress = "1 MPa"}]
"""

    def test_a_study_has_a_column(self, tmp_path, capsys):
        (tmp_path / "study.toml").write_text(self.STUDY)
        status, printed = run(capsys, "run", tmp_path / "study.toml", "--json")
        assert status in (0, 3)
        grid = rc.Grid((33, 31), (8e-6, 9e-6))
        expected = attrs.evolve(make_problem(), grid=grid).pull_off()
        for record in json.loads(printed.out)["records"]:
            assert record["pull-off"] == pytest.approx(expected.value, rel=1e-9)
            assert record["pull-off_uncertainty"] == pytest.approx(expected.uncertainty, rel=1e-9)

    def test_without_attraction_there_is_none(self, ball):
        problem = attrs.evolve(make_problem(), adhesion=None)
        with pytest.raises(rc.InputError, match="Without adhesion= nothing is pulled apart"):
            problem.solve(force=1e-7).response("pull-off")

    def test_first_yield_is_that_without_attraction_where_it_is_weak(self):
        weak = attrs.evolve(make_problem(), adhesion=rc.Exponential("10uJ/m2", "200nm"))
        bare = attrs.evolve(weak, adhesion=None).solve(force=1e-7).first_yield(yield_stress=1e6)
        # Also from a contact without a load, or under a tensile one.
        for force in (1e-7, 0.0, -1e-12):
            found = weak.solve(force=force).first_yield(yield_stress=1e6)
            assert found.force.value == pytest.approx(bare.force.value, rel=5e-3)

    def test_attraction_that_makes_a_body_yield_is_told(self):
        with pytest.raises(rc.InputError, match="The attraction alone makes the body yield"):
            make_problem().solve(force=1e-7).first_yield(yield_stress=1e3)
