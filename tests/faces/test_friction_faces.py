"""Friction through the doors of those who do not script: the command line and its files."""

from __future__ import annotations

import contextlib
import csv
import html
import io
import json
import re
import runpy

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.__main__ import main

BODY = ["--young", "210GPa", "--counterbody-young", "210GPa"]
SLIDE = ["--friction", "0.3", "--slide"]
LOOP = ["--friction", "0.3", "--tangential", "0.2N", "-0.2N", "0.2N"]


@pytest.fixture(scope="module")
def ball(tmp_path_factory):
    grid = rc.Grid((32, 32), 100e-6)
    path = tmp_path_factory.mktemp("maps") / "ball.npz"
    np.savez(path, heights=rc.ParaboloidSurface(1e-3).heights(grid), size=grid.size)
    return path


@pytest.fixture(scope="module")
def problem(ball):
    steel = rc.Elastic(210e9, 0.3)
    return rc.ContactProblem(rc.Body(rc.read_surface(ball), steel), rc.Body(rc.FlatSurface(), steel))


@pytest.fixture(scope="module")
def path(problem):
    return problem.path(force=1.0, tangential_force=[(0.2, 0.0), (-0.2, 0.0), (0.2, 0.0)], friction=0.3)


def run(capsys, *arguments):
    try:
        status = main([str(argument) for argument in arguments])
    except SystemExit as ended:
        status = ended.code
    return status, capsys.readouterr()


def solve(capsys, ball, *arguments, load=("--force", "1N")):
    return run(capsys, "solve", ball, *load, *BODY, *arguments)


def test_prints_the_states_of_a_script_and_the_energy_of_the_loop(ball, capsys, path):
    status, printed = solve(capsys, ball, *LOOP)
    assert status == 0
    assert words_of(str(path)) in words_of(printed.out)
    assert f"energy lost       {path.dissipated}" in printed.out
    assert f"in the last loop  {path.dissipated_in_loop}" in printed.out
    # Masing: the loop after the first step loses what its two steps lose.
    _, back, there = (one.dissipated.value for one in path.numbers)
    found = json.loads(solve(capsys, ball, *LOOP, "--json")[1].out)
    assert found["loop"]["value"] == pytest.approx(back + there, rel=1e-12)
    stated = {name: getattr(path.dissipated, name) for name in ("value", "uncertainty", "unit")}
    assert found["dissipated"] == {**stated, "warnings": []}
    assert [state["displacement_x"]["value"] for state in found["states"]] == path.loop.displacement[1:, 0].tolist()
    assert {state["status"] for state in found["states"]} == {"CONVERGED"}


def test_prints_a_table_for_programs(ball, capsys, path):
    rows = list(csv.DictReader(io.StringIO(solve(capsys, ball, *LOOP, "--csv")[1].out)))
    assert [float(row["tangential_x [N]"]) for row in rows] == pytest.approx([0.2, -0.2, 0.2])
    assert [float(row["dissipated [J]"]) for row in rows] == [one.dissipated.value for one in path.numbers]


def test_a_path_that_is_open_has_no_loop(ball, capsys):
    found = json.loads(solve(capsys, ball, "--friction", "0.3", "--tangential", "0.1N", "0.2N", "--json")[1].out)
    assert found["loop"] is None
    closed = json.loads(solve(capsys, ball, "--friction", "0.3", "--tangential", "0.2N", "0N", "--json")[1].out)
    assert closed["loop"] == closed["dissipated"]


def test_writes_files_that_other_commands_read(ball, capsys, path, tmp_path):
    saved = tmp_path / "path.npz"
    picture = tmp_path / "loop.png"
    _, printed = solve(capsys, ball, *LOOP, "-o", saved, "-o", picture)
    assert "Written:" in printed.out
    assert picture.read_bytes()[:4] == b"\x89PNG"
    np.testing.assert_array_equal(rc.FrictionalPath.load(saved)[2].shear, path[2].shear)
    status, shown = run(capsys, "info", saved)
    assert status == 0
    assert shown.out.strip() in printed.out
    assert json.loads(run(capsys, "info", saved, "--json")[1].out)["dissipated"]["value"] == path.dissipated.value
    assert run(capsys, "plot", saved, "-o", tmp_path / "again.png")[0] == 0
    status, refused = run(capsys, "plot", saved, "-o", tmp_path / "again.png", "--panel", "pressure")
    assert status == 2
    assert "--panel is for maps and solutions" in refused.err
    state = tmp_path / "state.npz"
    path[0].save(state)
    assert "area that sticks" in run(capsys, "info", state)[1].out
    described = json.loads(run(capsys, "info", state, "--json")[1].out)
    assert described["dissipated"]["value"] == path[0].dissipated.value
    assert run(capsys, "plot", state, "-o", tmp_path / "state.png")[0] == 0
    with pytest.raises(rc.InputError, match="does not hold a solution"):
        rc.ContactSolution.load(saved)


def test_takes_laws_directions_displacements_and_normal_loads(ball, capsys, problem):
    law = ["--friction", "limited-coulomb", "coefficient=0.3", "strength=200MPa"]
    found = json.loads(solve(capsys, ball, *law, "--tangential", "10nm,-5nm", "--json")[1].out)
    expected = problem.path(force=1.0, displacement=[(10e-9, -5e-9)], friction=rc.LimitedCoulomb(0.3, 200e6))
    assert found["states"][0]["tangential_y"]["value"] == pytest.approx(expected.loop.force[1, 1], rel=1e-12)
    several = ["--friction", "30%", "--tangential", "0.1N", "0.2N", "--substeps", "2", "--json"]
    status, printed = solve(capsys, ball, *several, load=("--loads", "0.8N", "1N"))
    assert status == 3
    rows = json.loads(printed.out)["states"]
    assert [row["force"] for row in rows] == pytest.approx([0.8, 1.0], rel=1e-5)
    assert [row["increments"] for row in rows] == [2, 2]


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("--friction", "0.3"), "give --tangential or --slide too"),
        (("--substeps", "2"), "--substeps is for loads along the surface"),
        (("--tangential", "0.1N"), "--tangential needs a law by which the surfaces slip"),
        (("--friction", "0.3", "--tangential", "0.1N", "5nm"), "needs loads of one kind"),
        (("--friction", "0.3", "--tangential", "0.1"), "write it like 0.5N"),
        (("--friction", "glue", "--tangential", "0.1N"), "There is no friction law named 'glue'"),
        (("--friction", "-0.3", "--tangential", "0.1N"), "The coefficient of friction must be"),
        (("--friction", "0.3N", "--tangential", "0.1N"), "--friction: "),
        (
            ("--friction", "limited-coulomb", "--tangential", "0.1N"),
            "required field 'coefficient' is missing",
        ),
        (("--friction", "0.3", "--tangential", "0.3N"), "Give displacements to --tangential instead, or --slide."),
        (("--friction", "0.3", "--tangential", "0.1N", "--substeps", "0"), "--substeps must be a whole number"),
        (("--slide",), "--slide needs a law by which the surfaces slip"),
        ((*SLIDE, "45"), "write it like 30deg"),
        ((*SLIDE, "--tangential", "0.1N"), "not allowed with argument"),
        ((*SLIDE, "--substeps", "2"), "--substeps is for loads along the surface"),
        ((*SLIDE, "--report", "x.pdf"), "a file that ends in .html"),
        ((*SLIDE, "-o", "state.vti"), "must be a file that ends in .npz"),
        ((*SLIDE, "--friction", "5", "--counterbody-young", "21GPa"), "Friction times Dundurs' beta is"),
        ((*LOOP, "--first-yield", "yield_stress=1GPa"), "'first-yield' is not for a contact with friction"),
        ((*SLIDE, "--partial-slip", "tangential_force=0.1N", "friction=0.3"), "'partial-slip' is not for a contact"),
        ((*LOOP, "--refine"), "--refine is for loads without friction"),
        ((*LOOP, "--boundary", "wrapped"), "A wrapped boundary has no response to shear"),
        ((*LOOP, "--adhesion", "short-range", "work=50mJ/m2"), "Friction with adhesion is not known"),
        ((*LOOP, "-o", "path.vti"), "must be a file that ends in .npz"),
        ((*LOOP, "-o", "missing/path.npz"), "There is no folder 'missing'"),
        ((*LOOP, "--report", "missing/path.html"), "There is no folder 'missing'"),
        ((*LOOP, "--report", "path.pdf"), "a file that ends in .html"),
    ],
)
def test_refuses_in_a_sentence(ball, capsys, arguments, sentence):
    status, printed = solve(capsys, ball, *arguments)
    assert status == 2
    assert sentence in " ".join(printed.err.split())
    assert printed.out == ""


def script_of(page):
    """Return the script of a report."""
    return html.unescape(re.search(r"<h2>Run it again</h2>\s*<pre><code>(.*?)</code>", page, re.DOTALL)[1])


@pytest.mark.slow
def test_the_report_of_a_path_follows_it_again(ball, capsys, tmp_path):
    status, _ = solve(capsys, ball, *LOOP, "--report", str(tmp_path / "path.html"), "-o", str(tmp_path / "path.npz"))
    assert status == 0
    page = (tmp_path / "path.html").read_text(encoding="utf-8")
    path = rc.FrictionalPath.load(tmp_path / "path.npz")
    shown = re.search(r">Energy lost</th><td>([0-9.]+) nJ", page)
    assert float(shown[1]) == pytest.approx(1e9 * path.dissipated.value, rel=1e-3)
    assert page.count('<tr><th scope="row">') > len(path)
    script = script_of(page)
    assert "path.save" in script
    (tmp_path / "again.py").write_text(script.replace('"path.npz"', repr(str(tmp_path / "path.npz"))))
    again = runpy.run_path(str(tmp_path / "again.py"))["path"]
    assert np.array_equal(again[-1].shear, path[-1].shear)
    assert again.dissipated == path.dissipated


@pytest.mark.slow
@pytest.mark.parametrize(
    ("loads", "more"),
    [
        ({"force": 1.0, "displacement": [(20e-9, -10e-9)]}, {}),
        ({"force": [1.0, 0.5], "tangential_force": [(0.1, 0.0), (0.0, 0.1)]}, {"substeps": 2}),
    ],
)
def test_the_script_of_a_report_has_the_loads(tmp_path, loads, more):
    bodies = [rc.Body(surface, rc.Elastic(210e9, 0.3)) for surface in (rc.ParaboloidSurface(1e-3), rc.FlatSurface())]
    problem = rc.ContactProblem(*bodies, grid=rc.Grid((32, 30), 100e-6))
    path = problem.path(**loads, **more, friction=rc.LimitedCoulomb(0.3, 1e9))
    script = tmp_path / "again.py"
    script.write_text(script_of(path.to_html()))
    again = runpy.run_path(str(script))["path"]
    assert (again.increments, again.dissipated) == (path.increments, path.dissipated)
    assert np.array_equal(again[-1].shear, path[-1].shear)


@pytest.fixture(scope="module")
def sliding(problem):
    return problem.slide(force=1.0, friction=0.3, direction=120.0)


def words_of(text):
    return " ".join(text.split())


def without_time(text):
    """Return the words of a printed solution without its last line, the cost."""
    return words_of(text.strip().rpartition("\nwork")[0])


def test_sliding_is_that_of_a_script(ball, capsys, sliding):
    status, printed = solve(capsys, ball, *SLIDE, "120deg")
    assert status == 0
    assert without_time(printed.out) == without_time(str(sliding))
    found = json.loads(solve(capsys, ball, *SLIDE, "120deg", "--json")[1].out)
    assert found["tangential_force"] == {"value": list(sliding.tangential_force), "unit": "N"}
    assert np.hypot(*found["tangential_force"]["value"]) == pytest.approx(0.3)
    assert found["dissipated"]["value"] == sliding.dissipated.value == pytest.approx(0.3)
    assert found["area"]["value"] == sliding.area().value
    (row,) = csv.DictReader(io.StringIO(solve(capsys, ball, *SLIDE, "120deg", "--csv")[1].out))
    assert float(row["tangential_y [N]"]) == sliding.tangential_force[1]
    assert float(row["area_uncertainty [m2]"]) == sliding.area().uncertainty


def test_sliding_is_along_x_where_no_angle_is_given_and_may_be_negative(ball, capsys):
    along = json.loads(solve(capsys, ball, *SLIDE, "--json")[1].out)["tangential_force"]["value"]
    assert along == pytest.approx([0.3, 0.0], abs=1e-15)
    x, y = json.loads(solve(capsys, ball, *SLIDE, "-30deg", "--json")[1].out)["tangential_force"]["value"]
    assert y / x == pytest.approx(-np.sqrt(1 / 3))


def test_sliding_writes_files_that_other_commands_read(ball, capsys, sliding, tmp_path):
    saved = tmp_path / "sliding.npz"
    picture = tmp_path / "sliding.png"
    status, printed = solve(capsys, ball, *SLIDE, "120deg", "-o", saved, "-o", picture, "-q")
    assert (status, printed.out) == (0, "")
    assert picture.read_bytes()[:4] == b"\x89PNG"
    np.testing.assert_array_equal(rc.ContactSolution.load(saved).shear, sliding.shear)
    assert without_time(run(capsys, "info", saved)[1].out) == without_time(str(sliding))


@pytest.mark.slow
def test_the_report_of_sliding_slides_again(ball, capsys, sliding, tmp_path):
    report = tmp_path / "sliding.html"
    solve(capsys, ball, *SLIDE, "120deg", "--report", report, "--stress", "depths=10um")
    page = report.read_text(encoding="utf-8")
    assert "stress von mises" in page
    assert "friction, which would" not in page
    assert "beta 0, gamma" in page
    script = script_of(page).replace("state.npz", str(tmp_path / "state.npz"))
    sliding.save(tmp_path / "state.npz")
    made = {}
    exec(script, made)
    np.testing.assert_array_equal(made["state"].shear, sliding.shear)
    assert "steady sliding" in sliding.to_html()


@pytest.mark.parametrize("way", [("--tangential", "0.1N"), ("--slide",)])
def test_a_dry_run_does_not_say_that_friction_is_omitted(ball, capsys, way):
    unlike = ("--counterbody-young", "3GPa", "--friction", "0.3", *way, "--dry-run")
    status, printed = solve(capsys, ball, *unlike)
    text = " ".join(printed.out.split())
    assert status == 0
    assert "omitted friction" not in text
    assert "friction Coulomb(coefficient=0.3)" in text
    assert "normal and tangential solves in turn" in text


def test_complete_unloading(ball, capsys, tmp_path):
    loads = ("--friction", "0.3", "--tangential", "0.1N", "0N", "--substeps", "2")
    report = tmp_path / "path.html"
    status, printed = solve(capsys, ball, *loads, "--json", "--report", report, load=("--loads", "1N", "0N"))
    assert status == 3
    state = json.loads(printed.out)["states"][-1]
    assert (state["force"], state["approach"], state["status"]) == (0.0, 0.0, "CONVERGED")
    assert "force=[1.0, 0.0]" in script_of(report.read_text(encoding="utf-8"))
    status, printed = solve(capsys, ball, *loads, load=("--loads", "0N", "1N"))
    assert status == 2
    assert "above 0" in printed.err


def test_sliding_is_for_one_load(ball, capsys):
    status, printed = solve(capsys, ball, *SLIDE, load=("--loads", "1N", "2N"))
    assert status == 2
    assert "--slide is for one load" in printed.err


def test_the_command_line_counts_the_increments_of_a_path(ball, capsys, monkeypatch):
    shown = []

    @contextlib.contextmanager
    def show(text, quiet=False):
        shown.append(text)
        yield lambda text, done=None: shown.append(text)

    monkeypatch.setattr("roughcontact._faces.cli.paths.show_progress", show)
    solve(capsys, ball, "--friction", "0.3", "--tangential", "0.1N", "-0.1N", "--substeps", "2", "--csv")
    steps = ("pressing", "step 1 of 2", "step 2 of 2")
    assert shown == ["pressing", *(f"{step}, increment 1 of 1" for step in steps)]


def test_replaces_no_map_that_is_read(ball, capsys):
    status, printed = solve(capsys, ball, *LOOP, "-o", ball)
    assert status == 2
    assert "is a height map that is read" in printed.err
