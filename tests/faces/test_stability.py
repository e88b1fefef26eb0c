"""The stability report and its gallery."""

from __future__ import annotations

import sys
from pathlib import Path

import attrs
import numpy as np
import pytest

import roughcontact as rc
from roughcontact.__main__ import main
from roughcontact.results import Verdict
from scenes import make_problem, make_rough

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

import stability_gallery as gallery
from stability_gallery import make_cases

SKIPPED, PASS, ATTENTION, FAIL = Verdict
PAGE = Path(__file__).parents[2] / "docs" / "trust" / "stability.md"
STEEL = rc.Elastic(200e9, 0.3)
# Side of a cell, m.
CELL = 1e-6


def rough(n=64, *, cells=8.0, material=STEEL, slope=0.02, **options):
    waves = {"rms_slope": slope, "shortest": cells * CELL, "longest": n * CELL}
    return make_rough(n, n * CELL, material, **waves, **options)


def ball(n=64, **options):
    return make_problem(rc.ParaboloidSurface(1e-2), STEEL, grid=rc.Grid((n, n), 1e-3), **options)


@pytest.mark.parametrize("max_cells", [2**18, 2**10])
def test_each_part_of_the_work_is_told_before_it_begins(max_cells, monkeypatch):
    monkeypatch.setattr("roughcontact._work.reports.stability_checks.MAX_FLOAT64_CELLS", max_cells)
    told = []
    rc.stability(ball(), force=100.0, on_check=lambda name, fraction: told.append((name, fraction)))
    names, fractions = zip(*told, strict=True)
    assert names == (
        "the solve", "kernel and model", "float32 iterations", "coarser grid", "shifted grid", "tighter tolerance",
    )  # fmt: skip
    assert fractions[0] == 0.0
    assert list(fractions) == sorted(fractions)
    assert fractions[-1] < 1.0
    # A grid on which the solver in float64 would take too long is not solved by it.
    assert (fractions[3] == fractions[2]) is (max_cells < 64 * 64)
    with pytest.raises(rc.InputError, match="on_check= must be a function of 2 arguments, name, fraction"):
        rc.stability(ball(), force=100.0, on_check=len)


@pytest.mark.parametrize("load", [{"force": 100.0}, {"approach": 2.2e-6}, {"pressure": 1e8}])
def test_any_control(load):
    report = rc.stability(ball(), **load)
    assert report.verdict is PASS
    assert (report["load balance"].verdict is SKIPPED) == ("approach" in load)
    assert report["shifted grid: approach or load"].value < 1e-3
    assert report["edge contact"].value == 0.0


def test_a_report_is_a_table():
    text = str(rc.stability(ball(), force=100.0))
    lines = text.splitlines()
    assert lines[0].startswith("overall: pass (2")
    assert lines[2].split()[:2] == ["pass", "convergence"]
    assert max(map(len, lines)) <= 80


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_a_notebook_shows_the_worst_first(boundary):
    """It omits the rows in the middle of a long table, where a steep map has its only bad one."""
    report = rc.stability(rough(slope=0.4, boundary=boundary), pressure=5e8)
    page = report._repr_html_()
    assert " more</td>" in page
    shown = [row.partition("</td>")[0] for row in page.split("<tr><td>")[1:]]
    bad = [check.verdict for check in report.checks if check.verdict in (FAIL, ATTENTION)]
    assert bad
    assert shown[: len(bad)] == sorted(bad, reverse=True)
    assert "<td>slope</td>" in page


def test_noise_from_cell_to_cell_fails():
    heights = 1e-7 * np.random.default_rng(0).random((64, 64))
    problem = rc.ContactProblem(rc.Body(rc.HeightMap(heights, size=64e-6), STEEL))
    report = rc.stability(problem, pressure=1e6)
    assert report.verdict is FAIL
    for name in ("cells per wavelength", "coarser grid: area", "area: uncertainty"):
        assert report[name].verdict is FAIL
        assert "Refine the grid" in report[name].advice
    assert report["area: warnings"].verdict is ATTENTION
    assert "not known between its points" in report["shifted grid: area"].finding
    assert report["float32 iterations"].verdict is PASS


def test_contact_at_a_free_border_is_found():
    grid = rc.Grid((64, 64), 1e-3)
    at_border = rc.ContactProblem(rc.Body(rc.ParaboloidSurface(1e-2, center=(5e-4, 0.0)), STEEL), grid=grid)
    check = rc.stability(at_border, force=100.0)["edge contact"]
    assert check.verdict is FAIL
    assert "enlarge the domain" in check.advice
    near_border = rc.ContactProblem(rc.Body(rc.ParaboloidSurface(1e-2, center=(3.9e-4, 0.0)), STEEL), grid=grid)
    assert rc.stability(near_border, force=20.0)["edge contact"].verdict is PASS


def test_heights_in_micrometres_are_too_steep():
    report = rc.stability(rough(slope=2.0), pressure=5e10)
    assert report["slope"].verdict is FAIL
    assert report["maximum pressure"].verdict is FAIL


class FourLogs(rc.InfluenceKernel):
    """Love's corner sum as published; it cancels far away."""

    def coefficients(self, shape, spacing, compliance):
        def corner(x, y):
            r = np.hypot(x, y)
            return x * np.log(y + r) + y * np.log(x + r)

        x, y = (np.arange(n) * step for n, step in zip(shape, spacing, strict=True))
        x, y = x[:, None], y[None, :]
        a, b = (0.5 * step for step in spacing)
        total = corner(x + a, y + b) + corner(x - a, y - b) - corner(x + a, y - b) - corner(x - a, y + b)
        return total * compliance / np.pi


class TwoBodies(rc.InfluenceKernel):
    """Coefficients of one body and the spectrum of another."""

    def coefficients(self, shape, spacing, compliance):
        return rc.Love().coefficients(shape, spacing, compliance)

    def spectrum(self, qx, qy, spacing, compliance):
        return 1.001 * rc.Love().spectrum(qx, qy, spacing, compliance)


def test_digits_lost_in_a_kernel_are_counted():
    cancels = rc.stability(ball(kernel=FourLogs()), force=100.0)
    assert cancels["kernel: digits lost"].value > 3.0
    assert cancels["kernel: digits lost"].verdict is ATTENTION
    assert "one form only" in cancels["kernel: two forms"].finding
    assert rc.stability(ball(), force=100.0)["kernel: digits lost"].value < 1.5


def test_two_forms_of_a_kernel_must_agree():
    assert rc.stability(ball(kernel=TwoBodies()), force=100.0)["kernel: two forms"].verdict is FAIL
    assert rc.stability(ball(), force=100.0)["kernel: two forms"].value < 1e-13
    fourier = rc.stability(rough(kernel="fourier"), pressure=1e9)
    assert "one form only" in fourier["kernel: two forms"].finding
    slender = rc.ContactProblem(
        rc.Body(rc.ParaboloidSurface(1e-2), STEEL), grid=rc.Grid((64, 64), (1e-3, 1e-2)), boundary="free"
    )
    assert "aspect" in rc.stability(slender, force=100.0)["kernel: two forms"].finding


@attrs.frozen
class Skewed(rc.Convolver):
    """A convolver with a relative error of 1e-6."""

    @property
    def boundaries(self):
        return rc.CircularFFT().boundaries

    def transform_shape(self, grid, boundary):
        return grid.shape

    def prepare(self, kernel, grid, boundary):
        plan = rc.CircularFFT().prepare(kernel, grid, boundary)
        return attrs.evolve(plan, symbol=(1 + 1e-6) * plan.symbol)


@pytest.mark.parametrize("boundary", ["periodic", "wrapped"])
def test_a_convolution_is_compared_with_plain_sums(boundary):
    assert rc.stability(rough(boundary=boundary), pressure=5e8)["convolution: digits lost"].verdict is PASS
    skewed = rc.stability(rough(boundary=boundary, convolver=Skewed()), pressure=5e8)
    assert skewed["convolution: digits lost"].verdict is FAIL
    assert skewed["convergence"].verdict is PASS


def test_a_skipped_check_says_why():
    limits = rc.ElasticPerfectlyPlastic(200e9, 0.3, np.full((33, 64), 1e9))
    heights = 1e-3 * rough().initial_gap[:33]
    capped = rc.ContactProblem(rc.Body(rc.HeightMap(heights, size=(33.0, 64.0)), limits), solver="spectral-gradient")
    report = rc.stability(capped, pressure=1e6)
    words = {
        "coarser grid: area": "even numbers",
        "shifted grid: area": "limit is an array",
        "float32 iterations": "does not work in float32",
    }
    for name, word in words.items():
        assert report[name].verdict is SKIPPED
        assert word in report[name].finding


def test_odd_numbers_of_cells_are_doubled():
    halved, doubled = (rc.stability(ball(cells), force=100.0)["coarser grid: area"] for cells in (64, 63))
    assert doubled.verdict is PASS
    assert "on twice the cells a side, 4 times the relative change" in doubled.finding
    assert "twice" not in halved.finding
    # The change that half the cells make, to its order of magnitude.
    approach = [rc.stability(ball(cells), force=100.0)["coarser grid: approach or load"].value for cells in (64, 63)]
    assert 0.2 < approach[1] / approach[0] < 5


def test_an_odd_map_without_heights_between_its_points_is_not_doubled():
    heights = np.array(ball(33).body.surface.heights(ball(33).plan.grid))
    problem = rc.ContactProblem(rc.Body(rc.HeightMap(heights, 1.0), rc.Elastic(200e9, 0.3)))
    finding = rc.stability(problem, force=100.0)["coarser grid: area"]
    assert finding.verdict is SKIPPED
    assert "Doubling it needs heights between its points" in finding.finding


class FixedTolerance(rc.Solver):
    tolerance = 1e-8

    def solve(self, convolution, task):
        return rc.ProjectedConjugateGradient(self.tolerance).solve(convolution, task)


def test_a_solver_without_a_tolerance_to_set_skips_that_check():
    report = rc.stability(ball(32, solver=FixedTolerance()), force=100.0)
    assert report["tighter tolerance: area"].verdict is SKIPPED
    assert "FixedTolerance" in report["tighter tolerance: area"].finding
    assert report["coarser grid: area"].verdict is PASS


def test_heights_that_depend_on_the_domain_cannot_be_shifted_on_a_free_one():
    report = rc.stability(rough(boundary="free"), pressure=5e8)
    assert "depend on the size of the domain" in report["shifted grid: area"].finding


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: rc.stability("problem", pressure=1.0), "must be a ContactProblem"),
        (lambda: rc.stability(ball()), "exactly one"),
        (lambda: rc.stability(ball(), pressure=1.0, force=1.0), "exactly one"),
        (lambda: rc.stability(ball(), pressure=-1.0), "above 0"),
        (lambda: rc.stability(ball(16), force=100.0)["area"], "The check must be one of 'convergence'"),
    ],
)
def test_bad_input_gets_a_sentence(call, words):
    with pytest.raises(rc.InputError, match=words):
        call()


class TestGallery:
    @pytest.mark.slow
    def test_no_case_is_silently_wrong(self):
        """Each converges and is confirmed by plain sums, is refused in a sentence, or says that it did not converge."""
        found = gallery.stability_gallery()
        assert not [row for row in found.rows if row.verdict is FAIL]
        assert found.verdict is ATTENTION
        rows = {row.case: row for row in found.rows}
        assert len(rows) == len(make_cases()) >= 40
        assert rows["one infinite height"].status.startswith("refused: The height map must be finite everywhere")
        assert rows["E = 210 Pa, meant as GPa"].verdict is ATTENTION
        assert sum(row.verdict is ATTENTION for row in found.rows) == 2
        assert found.to_markdown().count("\n| ") == len(rows)
        assert max(map(len, str(found).splitlines())) <= 80
        shown = found._repr_html_().split("<tr><td>")
        assert all(f"<td>{ATTENTION}</td>" in row for row in shown[1:3])

    def test_a_false_claim_fails(self, monkeypatch):
        real = rc.ContactProblem.solve

        def solve(problem, **options):
            solution = real(problem, **options)
            return attrs.evolve(solution, pressure=np.roll(solution.pressure, 1, axis=0))

        monkeypatch.setattr(rc.ContactProblem, "solve", solve)
        monkeypatch.setattr(gallery, "make_cases", lambda: make_cases()[:1])
        assert gallery.stability_gallery().verdict is FAIL

    def test_the_script_prints_the_table(self, capsys, monkeypatch):
        monkeypatch.setattr(gallery, "make_cases", lambda: make_cases()[:2])
        monkeypatch.setattr(sys, "argv", ["stability_gallery.py"])
        assert gallery.main() == 0
        assert "overall: pass (2 pass)" in capsys.readouterr().out

    @pytest.mark.slow
    def test_the_page_shows_the_gallery_as_it_is(self):
        """Case, status and verdict of every row; the figures depend on the machine in their last digits."""

        def rows(text):
            cells = (line.strip("|").split("|") for line in text.splitlines() if line.startswith("|"))
            return [(row[0].strip(), row[1].strip(), row[-1].strip()) for row in cells if len(row) == 7]

        measured = rows(gallery.stability_gallery().to_markdown())
        heading, rule, *shown = rows(PAGE.read_text(encoding="utf-8").partition("## The gallery")[2])
        assert [heading, rule] == measured[:2]
        assert len(measured) == 2 + 45
        assert len(shown) > 7
        assert [row for row in measured if row in shown] == shown
        assert {row for row in measured if row[2] == "attention"} <= set(shown)


class TestCommand:
    def test_exit_status(self, tmp_path, capsys):
        grid = rc.Grid((64, 64), 1e-3)
        heights = rc.ParaboloidSurface(1e-2).heights(grid)
        np.savez(tmp_path / "ball.npz", heights=heights, size=grid.size)
        options = ["--young", "200GPa", "--force", "100N", "--area", "cell-count"]
        assert main(["stability", str(tmp_path / "ball.npz"), *options]) == 0
        text = capsys.readouterr().out
        assert "overall: pass" in text
        assert "[cell-count]" in text
        np.savez(tmp_path / "noise.npz", heights=1e-6 * np.random.default_rng(0).random((32, 32)), size=grid.size)
        assert main(["stability", str(tmp_path / "noise.npz"), *options]) == 1
        assert main(["stability", str(tmp_path / "none.npz"), *options]) == 2

    def test_scenes_of_a_study_file(self, tmp_path, capsys):
        (tmp_path / "scenes.toml").write_text(SCENES)
        scenes = str(tmp_path / "scenes.toml")
        assert main(["stability", scenes, "--problem", "ball", "--area", "cell-count"]) == 0
        text = capsys.readouterr().out
        assert text.count("overall: ") == 1
        assert "on twice the cells a side" in text
        assert "[cell-count]" in text
        # Waves of four cells fail, and the exit status is that of the worst.
        assert main(["stability", scenes, "--pressure", "1MPa"]) == 1
        text = capsys.readouterr().out
        assert [line for line in text.splitlines() if line.endswith("-1e+06")] == ["ball-1e+06", "waves-1e+06"]

    @pytest.mark.parametrize(
        ("options", "words"),
        [
            (["--young", "1GPa"], "--young is for height maps: a study file states its problems itself"),
            (["other.npz"], "A second file is for height maps"),
            (["--boundary", "periodic"], "--boundary is for height maps"),
            (["--problem", "walls"], "no problem of the study named 'walls'"),
        ],
    )
    def test_options_that_do_not_suit_a_study_file(self, tmp_path, capsys, options, words):
        (tmp_path / "scenes.toml").write_text(SCENES)
        assert main(["stability", str(tmp_path / "scenes.toml"), *options]) == 2
        assert words in capsys.readouterr().err

    def test_maps_still_need_material_and_load(self, tmp_path, capsys):
        assert main(["stability", str(tmp_path / "map.npz"), "--young", "1GPa"]) == 2
        assert "need --young, --material or --viscoelastic, and one of --pressure" in capsys.readouterr().err
        assert main(["stability", "map.npz", "--young", "1GPa", "--force", "1N", "--problem", "ball"]) == 2
        assert "--problem is for a study file" in capsys.readouterr().err


SCENES = """
[problems.ball]
grid = { shape = [65, 65], size = 600e-6 }
body.surface = { type = "sphere", radius = 5e-3 }
body.material = { type = "elastic", young = 210e9, poisson = 0.3 }

[problems.waves]
grid = { shape = [32, 32], size = 1e-4 }
boundary = "periodic"
body.surface = { type = "wavy", amplitude = 5e-7, wavelength = 12.5e-6 }
body.material = { type = "elastic", young = 210e9, poisson = 0.3 }

[study]
pressure = [100e6]
"""
