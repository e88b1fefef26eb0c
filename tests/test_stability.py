"""The stability report, its gallery, and random problems of any magnitude."""

from __future__ import annotations

import math
from pathlib import Path

import attrs
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings

import roughcontact as rc
from independent import violations
from roughcontact.__main__ import main
from roughcontact.stability import gallery
from roughcontact.stability.moved import half_a_cell_aside
from roughcontact.stability.rules import RULES
from roughcontact.stability.scenes import scenes
from strategies import wild_problems

PASS, ATTENTION, FAIL, LEFT_OUT = rc.Verdict
PAGE = Path(__file__).parent.parent / "docs" / "stability.md"
STEEL = rc.Elastic(200e9, 0.3)


def rough(n=64, *, boundary="periodic", cells=8.0, material=STEEL, slope=0.02, **options):
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=slope, shortest=cells, longest=float(n), seed=0)
    return rc.ContactProblem(rc.Body(surface, material), grid=rc.Grid((n, n), float(n)), boundary=boundary, **options)


def ball(n=64, **options):
    return rc.ContactProblem(rc.Body(rc.ParaboloidSurface(1e-2), STEEL), grid=rc.Grid((n, n), 1e-3), **options)


def test_a_resolved_contact_passes_every_check():
    report = rc.stability(rough(128, cells=16.0), pressure=5e8)
    assert report.verdict is PASS
    left_out = {check.name for check in report.checks if check.verdict is LEFT_OUT}
    assert left_out == {"kernel: digits lost", "edge contact"}
    assert [check.name for check in report.checks] == list(RULES)
    assert report.solution.status is rc.Status.CONVERGED


@pytest.mark.parametrize("load", [{"force": 100.0}, {"approach": 2.2e-6}, {"pressure": 1e8}])
def test_any_control(load):
    report = rc.stability(ball(), **load)
    assert report.verdict is PASS
    assert (report["load balance"].verdict is LEFT_OUT) == ("approach" in load)
    assert report["half a cell aside: approach or load"].value < 1e-3
    assert report["edge contact"].value == 0.0


def test_a_report_is_a_table_for_a_person():
    text = str(rc.stability(ball(), force=100.0))
    lines = text.splitlines()
    assert lines[0].split() == ["verdict", "check", "value", "found;", "what", "to", "do"]
    assert lines[-1].startswith("overall: pass (2")
    assert max(map(len, lines)) <= 120


def test_noise_from_cell_to_cell_fails():
    heights = 1e-7 * np.random.default_rng(0).random((64, 64))
    problem = rc.ContactProblem(rc.Body(rc.HeightMap(heights, size=64e-6), STEEL))
    report = rc.stability(problem, pressure=1e6)
    assert report.verdict is FAIL
    for name in ("cells a wave", "half the cells: area", "area: uncertainty"):
        assert report[name].verdict is FAIL
        assert "Refine the grid" in report[name].advice
    assert report["area: doubts"].verdict is ATTENTION
    assert "not known between its points" in report["half a cell aside: area"].found
    assert report["float32 inside"].verdict is PASS


def test_a_contact_across_a_free_border_is_told():
    grid = rc.Grid((64, 64), 1e-3)
    at_border = rc.ContactProblem(rc.Body(rc.ParaboloidSurface(1e-2, center=(5e-4, 0.0)), STEEL), grid=grid)
    check = rc.stability(at_border, force=100.0)["edge contact"]
    assert check.verdict is FAIL
    assert "enlarge the domain" in check.advice
    near_border = rc.ContactProblem(rc.Body(rc.ParaboloidSurface(1e-2, center=(3.9e-4, 0.0)), STEEL), grid=grid)
    assert rc.stability(near_border, force=20.0)["edge contact"].verdict is ATTENTION


def test_heights_in_micrometres_are_too_steep():
    report = rc.stability(rough(slope=2.0), pressure=5e10)
    assert report["slope"].verdict is FAIL
    assert report["peak pressure"].verdict is FAIL


class FourLogs(rc.InfluenceKernel):
    """Love's corner sum as it is printed; it cancels far away."""

    def coefficients(self, shape, spacing, compliance):
        def corner(x, y):
            r = np.hypot(x, y)
            return x * np.log(y + r) + y * np.log(x + r)

        x, y = (np.arange(n) * step for n, step in zip(shape, spacing, strict=True))
        x, y = x[:, None], y[None, :]
        a, b = (0.5 * step for step in spacing)
        total = corner(x + a, y + b) + corner(x - a, y - b) - corner(x + a, y - b) - corner(x - a, y + b)
        return total * compliance / np.pi


class TwoMinds(rc.InfluenceKernel):
    """A spectrum of another body than the coefficients'."""

    def coefficients(self, shape, spacing, compliance):
        return rc.Love().coefficients(shape, spacing, compliance)

    def spectrum(self, qx, qy, spacing, compliance):
        return 1.001 * rc.Love().spectrum(qx, qy, spacing, compliance)


def test_digits_lost_in_a_kernel_are_counted():
    cancels = rc.stability(ball(kernel=FourLogs()), force=100.0)
    assert cancels["kernel: digits lost"].value > 3.0
    assert cancels["kernel: digits lost"].verdict is ATTENTION
    assert "one form only" in cancels["kernel: two forms"].found
    assert rc.stability(ball(), force=100.0)["kernel: digits lost"].value < 1.5


def test_two_forms_of_a_kernel_must_agree():
    assert rc.stability(ball(kernel=TwoMinds()), force=100.0)["kernel: two forms"].verdict is FAIL
    assert rc.stability(ball(), force=100.0)["kernel: two forms"].value < 1e-13
    fourier = rc.stability(rough(kernel="fourier"), pressure=1e9)
    assert "one form only" in fourier["kernel: two forms"].found
    slender = rc.ContactProblem(
        rc.Body(rc.ParaboloidSurface(1e-2), STEEL), grid=rc.Grid((64, 64), (1e-3, 1e-2)), boundary="free"
    )
    assert "aspect" in rc.stability(slender, force=100.0)["kernel: two forms"].found


@attrs.frozen
class Skewed(rc.Convolver):
    """A convolver that is wrong by a millionth."""

    @property
    def boundaries(self):
        return rc.CircularFFT().boundaries

    def transform_shape(self, grid, boundary):
        return grid.shape

    def plan(self, kernel, grid, boundary):
        plan = rc.CircularFFT().plan(kernel, grid, boundary)
        return attrs.evolve(plan, symbol=(1 + 1e-6) * plan.symbol)


@pytest.mark.parametrize("boundary", ["periodic", "wrapped"])
def test_a_convolution_is_compared_with_plain_sums(boundary):
    assert rc.stability(rough(boundary=boundary), pressure=5e8)["convolution: digits lost"].verdict is PASS
    skewed = rc.stability(rough(boundary=boundary, convolver=Skewed()), pressure=5e8)
    assert skewed["convolution: digits lost"].verdict is FAIL
    assert skewed["convergence"].verdict is PASS


def test_what_is_not_converged_fails_and_is_not_asked_more():
    report = rc.stability(rough(solver=rc.SpectralGradient(max_iterations=1)), pressure=5e8)
    assert report.verdict is FAIL
    assert "maximum number of iterations" in report["convergence"].found
    assert {check.name for check in report.checks} == set(RULES)
    assert report["area: doubts"].verdict is LEFT_OUT
    assert math.isnan(report["slope"].value)


def test_what_cannot_be_done_says_why():
    limits = rc.ElasticPerfectlyPlastic(200e9, 0.3, np.full((33, 64), 1e9))
    heights = 1e-3 * rough().undeformed[:33]
    capped = rc.ContactProblem(rc.Body(rc.HeightMap(heights, size=(33.0, 64.0)), limits), solver="spectral-gradient")
    report = rc.stability(capped, pressure=1e6)
    words = {
        "half the cells: area": "even counts",
        "half a cell aside: area": "limit is an array",
        "float32 inside": "does not work in float32",
    }
    for name, word in words.items():
        assert report[name].verdict is LEFT_OUT
        assert word in report[name].found


def test_a_map_that_repeats_is_moved_by_half_a_cell():
    heights = rough().body.surface.heights(rough().plan.grid)
    for surface in (rc.HeightMap(heights, 64.0, periodic=True), rc.HeightMap(heights, 64.0)):
        problem = rc.ContactProblem(rc.Body(surface, STEEL), boundary="periodic")
        twice = half_a_cell_aside(half_a_cell_aside(problem))
        np.testing.assert_allclose(twice.body.surface.values, np.roll(heights, (1, 1), (0, 1)), atol=1e-13)
    tilted = rc.HeightMap(heights + np.arange(64)[:, None], 64.0)
    with pytest.raises(rc.InputError, match="not known between its points"):
        half_a_cell_aside(rc.ContactProblem(rc.Body(tilted, STEEL), boundary="periodic"))


def test_what_is_known_everywhere_is_moved_by_half_a_cell():
    grid = rc.Grid((32, 48), (1e-3, 2e-3))
    aside = np.array(grid.spacing) / 2
    flat = rc.PlacedMap(rc.HeightMap(np.eye(40), 4e-3), method="cubic")
    surface = rc.ParaboloidSurface(1e-2) + rc.WavySurface(1e-6, 1e-4) + flat
    moved = half_a_cell_aside(rc.ContactProblem(rc.Body(surface, STEEL), grid=grid)).body.surface.values
    x, y = grid.x - aside[0], grid.y - aside[1]
    wave = 1e-6 * (np.cos(2e4 * np.pi * x) + np.cos(2e4 * np.pi * y))
    there = attrs.evolve(flat, offset=tuple(aside)).heights(grid)
    bowl = -(x**2 + y**2) / 2e-2
    other = -((x + 2 * aside[0]) ** 2 + (y + 2 * aside[1]) ** 2) / 2e-2
    assert min(np.abs(moved - there - wave - each).max() for each in (bowl, other)) < 1e-15


def test_heights_that_hang_on_the_domain_cannot_be_moved_on_a_free_one():
    report = rc.stability(rough(boundary="free"), pressure=5e8)
    assert "hang on the size of the domain" in report["half a cell aside: area"].found


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: rc.stability("problem", pressure=1.0), "must be a ContactProblem"),
        (lambda: rc.stability(ball()), "exactly one"),
        (lambda: rc.stability(ball(), pressure=1.0, force=1.0), "exactly one"),
        (lambda: rc.stability(ball(), pressure=-1.0), "above 0"),
    ],
)
def test_bad_input_gets_a_sentence(call, words):
    with pytest.raises(rc.InputError, match=words):
        call()


def test_the_page_gives_the_thresholds_as_they_are():
    text = PAGE.read_text(encoding="utf-8")
    for name, rule in RULES.items():
        assert f"| {name} | {rule.good:g} | {rule.bearable:g} | {rule.reason} |" in text


class TestGallery:
    def test_no_scene_is_silently_wrong(self):
        """Converged and confirmed by plain sums, or refused in a sentence, or not converged and says so."""
        found = rc.stability_gallery()
        assert not [row for row in found.rows if row.verdict is FAIL]
        assert found.verdict is ATTENTION
        rows = {row.scene: row for row in found.rows}
        assert len(rows) == len(scenes()) >= 40
        assert rows["one NaN"].status.startswith("refused: The height map must be finite everywhere")
        assert rows["a modulus without its giga"].verdict is ATTENTION
        assert sum(row.verdict is ATTENTION for row in found.rows) == 2
        assert str(found).count("\n| ") == len(rows)

    def test_a_false_claim_fails(self, monkeypatch):
        real = rc.ContactProblem.solve

        def solve(problem, **options):
            solution = real(problem, **options)
            return attrs.evolve(solution, pressure=np.roll(solution.pressure, 1, axis=0))

        monkeypatch.setattr(rc.ContactProblem, "solve", solve)
        monkeypatch.setattr(gallery, "scenes", lambda: scenes()[:1])
        assert rc.stability_gallery().verdict is FAIL


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

    def test_gallery(self, capsys, monkeypatch):
        monkeypatch.setattr(gallery, "scenes", lambda: scenes()[:2])
        with pytest.raises(SystemExit) as ended:
            main(["stability", "--gallery"])
        assert ended.value.code == 0
        assert "overall: pass (2 pass)" in capsys.readouterr().out


def is_right_or_says_so(case):
    problem, load = case
    try:
        solution = problem.solve(**load, throw=False)
    except rc.InputError:
        return
    if solution.status.success:
        found = violations(problem, load, solution)
        assert found.holds(solution.status), found
    else:
        assert str(solution.status).startswith("not converged: ")
        with pytest.raises(rc.NotConverged):
            problem.solve(**load)


@given(wild_problems())
def test_random_problems_are_right_or_say_so(case):
    is_right_or_says_so(case)


@pytest.mark.slow
@settings(max_examples=1000, suppress_health_check=list(HealthCheck))
@given(wild_problems())
def test_a_thousand_random_problems_are_right_or_say_so(case):
    is_right_or_says_so(case)


def test_the_judge_of_random_problems_sees_what_is_wrong():
    problem = rc.ContactProblem(rc.Body(rc.HeightMap(np.random.default_rng(0).random((6, 7)), size=(6.0, 7.0)), STEEL))
    solution = problem.solve(pressure=1e9)
    assert violations(problem, {"pressure": 1e9}, solution).holds(solution.status)
    pressure = solution.pressure * (1.0 + 1e-6 * np.arange(6)[:, None])
    assert not violations(problem, {"pressure": 1e9}, attrs.evolve(solution, pressure=pressure)).holds(solution.status)
    assert not violations(problem, {"pressure": 1.001e9}, solution).holds(solution.status)
