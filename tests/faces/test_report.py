"""The report of errors against run time."""

from __future__ import annotations

import csv
import itertools
import math
import re
from pathlib import Path

import attrs
import numpy as np
import pytest

import roughcontact as rc
from roughcontact import reference
from roughcontact.__main__ import main
from roughcontact.results import ErrorReport, ReportRow, Timing
from scenes import make_problem, rather_slow

PNG = b"\x89PNG"
ROOT = Path(__file__).parents[2]
MODULUS = 200e9 / (1 - 0.3**2)
STEEL = rc.Elastic(200e9, 0.3)
HERTZ = reference.hertz_sphere(1.0, 1e-3, MODULUS)


def ball(cells=128, **parts):
    return make_problem(rc.SphereSurface(1e-3), STEEL, grid=rc.Grid((cells, cells), 100e-6), **parts)


@pytest.fixture(scope="module")
def against_hertz():
    return rc.error_vs_time(
        ball(), force=1.0, reference=HERTZ, areas=("blend", "cell-count", "perimeter"), cells=(128, 32, 64), repeats=2
    )


@pytest.fixture(scope="module")
def against_refined():
    return rc.error_vs_time(ball(64), force=1.0, cells=(16, 32, 64), repeats=1)


def rows_by(report, estimator):
    return [row for row in report.rows if row.estimator == estimator]


def test_errors_fall_with_the_grid_against_the_closed_form(against_hertz):
    rows = rows_by(against_hertz, "cell-count")
    assert [row.shape for row in rows] == [(32, 32), (64, 64), (128, 128)]
    for coarse, fine in itertools.pairwise(rows):
        assert fine.error("area") < coarse.error("area")
        # The height of the summit is missed by the square of the cell, and all else follows.
        assert fine.error("p_max") < 0.3 * coarse.error("p_max")
        assert fine.error("approach") < 0.3 * coarse.error("approach")
    assert all(row.error("area") < 0.005 for row in rows_by(against_hertz, "blend"))


def test_rows_have_the_results_of_a_solve(against_hertz):
    solution = ball(64).solve(force=1.0)
    row = next(row for row in rows_by(against_hertz, "blend") if row.shape == (64, 64))
    area = solution.area()
    assert (row.area, row.area_uncertainty, row.approach) == (area.value, area.uncertainty, solution.approach)
    assert row.p_max == solution.pressure.max()
    assert row.area_error == pytest.approx(area.value / HERTZ.area - 1, abs=1e-15)
    assert (row.iterations, row.convolutions) == (solution.iterations, solution.convolutions)
    assert row.peak_bytes > solution.pressure.nbytes
    assert row.solver == "projected-cg"
    assert row.convolver == "dc-fft"


def test_the_area_is_timed_separately_and_added(against_hertz):
    for row in against_hertz.rows:
        assert row.cpu.minimum <= row.cpu.median <= row.cpu.maximum
        assert row.cpu.maximum >= row.solve_cpu.minimum + row.area_cpu.minimum
        assert row.cpu.minimum >= max(row.solve_cpu.minimum, row.area_cpu.minimum)


@pytest.mark.parametrize("quantity", ["area", "p_max", "approach"])
def test_no_row_is_better_than_the_front(against_hertz, quantity):
    front = against_hertz.front(quantity)
    assert front
    for one, other in itertools.pairwise(front):
        assert one.cost(quantity) <= other.cost(quantity)
        assert one.error(quantity) > other.error(quantity)
    for row in against_hertz.rows:
        # Whatever is not on the front is beaten, but for errors that count as equal.
        assert any(
            better.cost(quantity) <= row.cost(quantity) and 0.99 * better.error(quantity) <= row.error(quantity)
            for better in front
        )


def made_up(estimator, cells, error, cpu, **more):
    timing = Timing.of([cpu])
    parts = {"kernel": "love", "convolver": "dc-fft", "solver": "projected-cg", "tolerance": 1e-8, **more}
    shape = (cells, cells)
    return ReportRow(
        shape=shape, estimator=estimator, area=1.0, area_error=error, cpu=timing, solve_cpu=timing, **parts
    )


def report_of(*rows, error=0.0):
    reference = rc.results.KnownAnswer(area=1.0, area_error=error)
    return ErrorReport(rows=rows, reference=reference, nominal=2.0, description="made up", repeats=1)


LUCKY = [
    made_up("blend", 32, 0.001, 0.001),
    made_up("blend", 64, -0.02, 0.005),
    made_up("blend", 128, 0.004, 0.02),
    made_up("blend", 256, 0.001, 0.08),
    made_up("cell-count", 64, 0.3, 0.004),
    made_up("cell-count", 256, 0.074, 0.72),
    made_up("perimeter", 128, -0.1, 0.02),
    made_up("perimeter", 256, -0.003, 0.08),
    made_up("hertz", 256, math.nan, math.nan, failure="it fails"),
]


def test_advice_is_the_cheapest_case_that_is_accurate_not_by_chance():
    assert report_of(*LUCKY).advice(area=0.005) == (
        "For an area error of 0.5 %: 128 x 128 cells with blend, 0.02 s; "
        "cell-count needs more than 256 x 256 cells (error 7.4 % in 0.72 s); perimeter needs 256 x 256 cells (0.08 s)."
    )


def test_no_case_is_advised_whose_small_error_is_chance():
    """All grids may be right by chance, as the finest ones of an estimator with a large scatter."""
    wide = [attrs.evolve(made_up("blend", 24, 0.001, 0.001), area_uncertainty=0.097), LUCKY[2], LUCKY[3]]
    assert report_of(*wide).advice(area=0.005).startswith("For an area error of 0.5 %: 128 x 128 cells with blend")
    assert "24 x 24 cells" in report_of(*wide).advice(area=0.1)
    assert "no case is accurate enough; the nearest is 24 x 24 cells with blend (9.7 %," in report_of(wide[0]).advice()
    other = attrs.evolve(made_up("level-set", 128, 0.0003, 0.02), area_uncertainty=0.036)
    assert "level-set needs more than 128 x 128 cells (uncertainty 3.6 % in 0.02 s)" in report_of(*wide, other).advice()


def test_the_advice_of_a_wave_is_not_the_luckiest_grid():
    """Of waves of four cells 20 to 24 cells a side err by 0.1 to 1 %, at an uncertainty of 4 to 8 %."""
    wave = rc.Body(rc.WavySurface(0.5e-6, 12.5e-6), STEEL)
    problem = rc.ContactProblem(wave, grid=rc.Grid((96, 96), 50e-6), boundary="periodic")
    report = rc.error_vs_time(problem, pressure=1e9, cells=[24, 48, 96], areas=["blend"], repeats=1)
    assert report.rows[0].error("area") < 0.02
    assert report.rows[0].area_uncertainty > 0.02 * report.rows[0].area
    # On grids this small the clock does not tell which is cheaper.
    rows = [attrs.evolve(row, cpu=Timing.of([row.shape[0] / 1e4])) for row in report.rows]
    advice = attrs.evolve(report, rows=rows).advice(area=0.02)
    assert advice.startswith("For an area error of 2 %: 48 x 48 cells with blend")


def test_advice_states_what_is_not_resolved():
    report = report_of(*LUCKY, error=0.01)
    assert report.advice(area=0.005).startswith(
        "The reference area is known to 1 % only, which does not resolve 0.5 %. For an area error of 1 %: 128 x 128"
    )
    assert report_of(*LUCKY, error=2.0).advice().endswith("which does not resolve 0.5 %.")
    assert "128 x 128 cells with blend" in report.advice(area=0.01)
    nothing = report_of(*LUCKY[4:6])
    assert (
        "no case is accurate enough; the nearest is 256 x 256 cells with cell-count (7.4 %, 0.72 s)" in nothing.advice()
    )
    assert "there is no advice" in report_of(LUCKY[-1]).advice()


def test_errors_below_the_error_bound_count_as_equal():
    """The costlier case is more accurate by less than the reference resolves."""
    cheap, dear = made_up("blend", 64, 0.004, 0.01), made_up("blend", 128, 0.0001, 0.1)
    assert report_of(cheap, dear).front() == (cheap, dear)
    assert report_of(cheap, dear, error=0.005).front() == (cheap,)


def test_a_reference_solution_has_an_error_bound(against_refined):
    reference = against_refined.reference
    assert "128 x 128" in reference.source
    for quantity in ("area", "p_max", "approach"):
        off = abs(getattr(reference, quantity) - getattr(HERTZ, quantity))
        assert 0.0 < off <= 2.0 * getattr(reference, f"{quantity}_error")
    for row in against_refined.rows:
        assert ("area" in row.unresolved) == (row.error("area") < reference.relative_uncertainty("area"))
    assert any("area" in row.unresolved for row in rows_by(against_refined, "blend"))
    assert not any("area" in row.unresolved for row in rows_by(against_refined, "cell-count"))
    assert "not resolved" in str(against_refined)


def test_cases_that_fail_are_rows_that_say_why():
    capped = rc.Body(rc.SphereSurface(1e-3), rc.ElasticPerfectlyPlastic(200e9, 0.3, hardness=1.5e9))
    problem = rc.ContactProblem(capped, grid=rc.Grid((32, 32), 100e-6))
    report = rc.error_vs_time(
        problem,
        force=1.0,
        reference={"area": 7e-10},
        cells=(32,),
        solvers=("auto", "polonsky-keer", rc.SpectralGradient(max_iterations=2)),
        convolvers=("auto", "circular-fft"),
        repeats=1,
    )
    failures = {(row.convolver, row.solver.split("(")[0]): row.failure for row in report.rows}
    assert not failures["dc-fft", "projected-cg"]
    assert "no pressure limit" in failures["dc-fft", "polonsky-keer"]
    assert failures["dc-fft", "SpectralGradient"].startswith("not converged: the maximum number")
    assert "circular" in failures["circular-fft", "projected-cg"].lower()
    failed = [row for row in report.rows if row.failure]
    assert all(math.isnan(row.area) and math.isnan(row.cpu.median) for row in failed)
    assert "failed [1]" in str(report)
    assert not set(failed) & set(report.front())


def test_an_estimator_that_fails_fails_alone():
    class Sulky(rc.AreaEstimator):
        def estimate(self, solution):
            raise rc.InputError("Not today.")

    class Broken(rc.AreaEstimator):
        def estimate(self, solution):
            return 1 / 0

    areas = ("blend", Sulky(), Broken())
    report = rc.error_vs_time(ball(32), force=1.0, reference=HERTZ, cells=(32,), areas=areas, repeats=1)
    assert [row.failure for row in report.rows] == ["", "Not today.", "ZeroDivisionError: division by zero"]


def test_varying_parts_have_columns():
    report = rc.error_vs_time(
        ball(32),
        force=1.0,
        reference=HERTZ,
        cells=(32,),
        areas=("cell-count",),
        kernels=("love",),
        solvers=("projected-cg", "spectral-gradient"),
        tolerances=(1e-3, 1e-8),
        repeats=1,
    )
    assert [(row.solver, row.tolerance) for row in report.rows] == [
        (solver, tolerance) for solver in ("projected-cg", "spectral-gradient") for tolerance in (1e-3, 1e-8)
    ]
    single = {row.solver: row.float32_convolutions for row in report.rows}
    assert single["projected-cg"] > 0
    assert single["spectral-gradient"] == 0
    assert "tolerance" in str(report)
    loose, tight = report.rows[2:]
    assert loose.iterations < tight.iterations


def test_tables_can_be_read_back(against_hertz, tmp_path):
    path = tmp_path / "report.csv"
    against_hertz.to_csv(path)
    with path.open(newline="") as file:
        read = list(csv.DictReader(file))
    assert len(read) == len(against_hertz.rows)
    front = set(against_hertz.front())
    for line, row in zip(read, against_hertz.rows, strict=True):
        assert (int(line["nx"]), int(line["ny"])) == row.shape
        assert float(line["area_m2"]) == row.area
        assert float(line["approach_error"]) == row.approach_error
        assert float(line["cpu_s_max"]) == row.cpu.maximum
        assert int(line["peak_bytes"]) == row.peak_bytes
        assert (line["pareto"] == "1") == (row in front)
    table = [line for line in against_hertz.to_markdown().splitlines() if line.startswith("|")]
    assert len(table) == 2 + len(against_hertz.rows)
    assert len({line.count("|") for line in table}) == 1
    cells = [cell.strip() for cell in table[2].strip("|").split("|")]
    assert cells[:2] == ["32 x 32", "blend"]
    error = float(cells[3].lstrip("* "))
    assert error == pytest.approx(100 * against_hertz.rows[0].area_error, rel=0.06)
    assert [path.name for path in tmp_path.iterdir()] == ["report.csv"]


@pytest.mark.slow
def test_pictures(against_hertz, against_refined, tmp_path):
    # Two errors that differ by their rounding span no axis: matplotlib divides by zero.
    alike = [made_up("cell-count", 32, 0.11800599098700692, 0.1), made_up("hertz", 32, 0.11800599098700696, 0.1)]
    made_up_ones = (report_of(*LUCKY), report_of(LUCKY[0]), report_of(LUCKY[-1]), report_of(*alike))
    for number, report in enumerate((against_hertz, against_refined, *made_up_ones)):
        path = tmp_path / f"{number}.png"
        report.draw(path)
        assert path.read_bytes()[:4] == PNG
    with pytest.raises(rc.InputError, match="ending of a picture"):
        against_hertz.draw(tmp_path / "report.hm")
    with pytest.raises(rc.InputError, match="no folder"):
        against_hertz.draw(tmp_path / "nowhere" / "report.png")
    assert len(list(tmp_path.iterdir())) == 6


class FixedTolerance(rc.Solver):
    tolerance = 1e-8

    def solve(self, convolution, task):
        return rc.ProjectedConjugateGradient().solve(convolution, task)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({}, "exactly one"),
        ({"force": 1.0, "pressure": 1e6}, "exactly one"),
        ({"force": -1.0}, "above 0"),
        ({"force": 1.0, "areas": "blend"}, "must be a list of registered names"),
        ({"force": 1.0, "areas": ()}, "at least one"),
        ({"force": 1.0, "areas": ("blond",)}, "Did you mean 'blend'"),
        ({"force": 1.0, "solvers": ("polonsky",)}, "no solver named"),
        ({"force": 1.0, "kernels": (rc.Love,)}, "not the class"),
        ({"force": 1.0, "convolvers": 3}, "list of registered names"),
        ({"force": 1.0, "cells": 64}, "list of whole numbers"),
        ({"force": 1.0, "cells": (1,)}, "at least 2"),
        ({"force": 1.0, "tolerances": (0.0,)}, "above 0"),
        ({"force": 1.0, "tolerances": (1e-6,), "solvers": (FixedTolerance(),)}, "cannot be set"),
        ({"force": 1.0, "repeats": 0}, "at least 1"),
        ({"force": 1.0, "reference": {"are": 1.0}}, "The reference must be"),
        ({"force": 1.0, "reference": {}}, "The reference must be"),
        ({"force": 1.0, "reference": 7.0}, "The reference must be"),
        ({"force": 1.0, "reference": {"area": -1.0}}, "The reference area must be"),
        ({"force": 1.0, "reference": {"area_error": 1.0}}, "The reference is empty"),
        ({"force": 1.0, "interpolation": "magic"}, "one of 'bilinear'"),
    ],
)
def test_bad_input_is_a_sentence(arguments, words):
    with pytest.raises(rc.InputError, match=re.escape(words)):
        rc.error_vs_time(ball(16), **arguments)


def test_advice_needs_a_sensible_question(against_hertz):
    with pytest.raises(rc.InputError, match="allowed error of the area"):
        against_hertz.advice(area=0.0)
    with pytest.raises(rc.InputError, match="The quantity must be"):
        against_hertz.front("gap")
    with pytest.raises(rc.InputError, match="The problem must be"):
        rc.error_vs_time(HERTZ, force=1.0)


def rough_map(periodic):
    grid = rc.Grid((64, 48), (64e-6, 48e-6))
    heights = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=8e-6, longest=16e-6, seed=1).heights(grid)
    return rc.HeightMap(heights, size=grid.size, periodic=periodic)


@pytest.mark.slow
def test_a_map_is_not_compared_with_itself(tmp_path):
    problem = rc.ContactProblem(rc.Body(rough_map(False), STEEL))
    options = {"pressure": 5e8, "interpolation": "bilinear", "repeats": 1}
    report = rc.error_vs_time(problem, **options)
    own = [row for row in report.rows if row.shape == (64, 48)]
    assert [row.estimator for row in own] == ["blend", "cell-count"]
    assert [row.of_reference for row in own] == [{"area", "p_max", "approach"}, {"p_max", "approach"}]
    assert not any(row.of_reference for row in report.rows if row not in own)
    assert own[0].area == pytest.approx(report.reference.area, rel=1e-5)
    assert math.isnan(own[0].area_error)
    assert own[1].area_error == pytest.approx(own[1].area / report.reference.area - 1)
    for quantity in ("area", "p_max", "approach"):
        assert own[0] not in report.front(quantity)
    # Only the coarser grid is advised; the clock does not tell which of grids this small is cheaper.
    rows = [attrs.evolve(row, cpu=Timing.of([row.shape[0] / 1e4])) for row in report.rows]
    advice = attrs.evolve(report, rows=rows).advice(area=1.0)
    assert "blend needs 32 x 24 cells" in advice or "32 x 24 cells with blend" in advice
    assert "64 x 48 cells" not in advice.split(". The errors")[0]
    assert advice.endswith("those of coarser grids, against the map solved on its own 64 x 48 cells (area by blend); "
                           "not of the measurement.")  # fmt: skip
    assert "| 64 x 48 | blend |" in report.to_markdown()
    assert str(report).count("reference  ") >= 3
    report.draw(tmp_path / "report.png")
    # With the grid of the map alone there is nothing to compare.
    alone = rc.error_vs_time(problem, **options, cells=(64,), areas=("blend",))
    assert alone.front() == ()
    assert alone.advice(area=1.0).startswith("No case but the reference itself was solved")
    alone.draw(tmp_path / "alone.png")
    # A surface that is known between its points has a finer reference, and every case is compared.
    smooth = rc.ContactProblem(rc.Body(rough_map(True), STEEL), boundary="periodic")
    assert not any(row.of_reference for row in rc.error_vs_time(smooth, pressure=5e8, repeats=1).rows)


def test_progress_is_reported():
    seen = []
    rc.error_vs_time(
        ball(16), force=1.0, cells=(16, 32), repeats=1, on_case=lambda case, done: seen.append((case, done))
    )
    assert [case for case, _ in seen] == ["the reference", "16 x 16, projected-cg", "32 x 32, projected-cg"]
    assert [done for _, done in seen] == [0.0, 0.0, pytest.approx(0.2)]


@pytest.mark.slow
def test_the_command_writes_table_picture_and_advice(tmp_path, capsys):
    surface = rough_map(False)
    np.savez(tmp_path / "map.npz", heights=surface.heights(surface.grid), size=surface.size)
    out = tmp_path / "out"
    options = "--pressure 500MPa --young 200GPa --cells 32 64 --areas blend cell-count --repeats 1 --tolerances 1e-6"
    more = "--solvers projected-cg polonsky-keer --kernels love -o".split()
    assert main(["report", str(tmp_path / "map.npz"), *options.split(), *more, str(out)]) == 0
    captured = capsys.readouterr()
    assert not captured.err
    # Nothing of the progress where it is not a terminal.
    said = " ".join(captured.out.split())
    assert "64 µm x 48 µm, boundary free, pressure 500 MPa; love, dc-fft, tolerance 1e-06" in said
    assert said.startswith(("For an area error of", "The reference area is known to"))
    assert {path.name for path in out.iterdir()} == {"report.csv", "report.md", "report.png"}
    assert (out / "report.md").read_text(encoding="utf-8").count("| 64 x 48 |") == 4
    assert main(["report", str(tmp_path / "map.npz"), *options.split(), "--solvers", "magic", "-o", str(out)]) == 2
    assert "no solver named 'magic'" in capsys.readouterr().err


@pytest.mark.slow
def test_the_command_takes_the_scenes_of_a_study_file(tmp_path, capsys):
    (tmp_path / "scenes.toml").write_text(
        """
        [problems.wave]
        grid = { shape = [32, 32], size = 5e-5 }
        boundary = "periodic"
        body.surface = { type = "wavy", amplitude = 5e-7, wavelength = 12.5e-6 }
        body.material = { type = "elastic", young = 210e9, poisson = 0.3 }

        [problems."a/rough"]
        grid = { shape = [32, 32], size = 5e-5 }
        boundary = "periodic"
        body.surface = { type = "self-affine", hurst = 0.8, rms_slope = 0.1, shortest = 8e-6, longest = 5e-5 }
        body.material = { type = "elastic", young = 210e9, poisson = 0.3 }

        [study]
        pressure = [1e8]
        seeds = [1]
        """
    )
    options = "--cells 64 --repeats 1 --problem".split()
    # The wave has no seed to change.
    assert main(["report", str(tmp_path / "scenes.toml"), *options, "wave", "-o", str(tmp_path / "out")]) == 2
    text = (tmp_path / "scenes.toml").read_text().replace("seeds = [1]", "")
    (tmp_path / "scenes.toml").write_text(text)
    capsys.readouterr()
    assert main(["report", str(tmp_path / "scenes.toml"), *options[:-1], "-o", str(tmp_path / "out")]) == 0
    assert capsys.readouterr().out.count("pressure 100 MPa") == 2
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"wave-1e+08", "a_rough-1e+08"}
    assert main(["report", str(tmp_path / "scenes.toml"), *options, "wave", "-o", str(tmp_path / "one")]) == 0
    assert {path.name for path in (tmp_path / "one").iterdir()} == {"report.csv", "report.md", "report.png"}


@pytest.mark.slow
def test_the_study_runs_small(monkeypatch, tmp_path, capsys):
    monkeypatch.syspath_prepend(str(ROOT / "plugins" / "roughcontact-paper" / "src"))
    monkeypatch.syspath_prepend(str(ROOT / "docs" / "studies"))
    study = __import__("report_wavy")
    grids = (64, 128, 256), (256,), 1
    assert "eq. 28, counts on 64 to 256, polonsky-keer" in [row[0] for row in study.make_rows(*grids)]
    study.main(*grids, tmp_path)
    assert re.search(r"For an area error of 0.5 %: \d+ x \d+ cells with blend", capsys.readouterr().out)
    assert (tmp_path / "report_wavy.png").stat().st_size > 10_000


class RoundedRim(rc.Surface):
    """A flat disc whose rim is rounded: the pressure at the crease grows as the root of the cells."""

    is_smooth = True

    def heights(self, grid):
        return -np.maximum(grid.x**2 + grid.y**2 - 1.46e-4**2, 0.0) / 1e-3


@pytest.mark.parametrize("shape", rather_slow([(64, 64), (96, 96)], [(64, 64)]))
def test_a_maximum_that_grows_with_every_grid_has_no_bound(shape):
    problem = rc.ContactProblem(rc.Body(RoundedRim(), STEEL), grid=rc.Grid(shape, (1e-3, 1e-3)))
    report = rc.error_vs_time(problem, pressure=2e7, repeats=1)
    assert report.reference.p_max is None
    assert "the maximum pressure has no limit: it grows with every grid" in " ".join(str(report).split())
    round_ball = rc.ContactProblem(rc.Body(rc.SphereSurface(5e-3), STEEL), grid=rc.Grid(shape, 2e-4))
    ball = rc.error_vs_time(round_ball, force=1.0, repeats=1)
    assert ball.reference.p_max > 0.0
    assert "no limit" not in str(ball)
