"""The report of errors against run time."""

from __future__ import annotations

import csv
import itertools
import math
import re
from pathlib import Path

import numpy as np
import pytest

import roughcontact as rc
from roughcontact import reference
from roughcontact.__main__ import main
from roughcontact.load import Load
from roughcontact.paper import printed
from roughcontact.report.truth import refined_truth

PNG = b"\x89PNG"
STUDIES = Path(__file__).parent.parent / "docs" / "studies"
MODULUS = 200e9 / (1 - 0.3**2)
STEEL = rc.Elastic(200e9, 0.3)
HERTZ = reference.hertz_sphere(1.0, 1e-3, MODULUS)


def ball(cells=128, **parts):
    return rc.ContactProblem(rc.Body(rc.SphereSurface(1e-3), STEEL), grid=rc.Grid((cells, cells), 100e-6), **parts)


@pytest.fixture(scope="module")
def against_hertz():
    return rc.error_vs_time(
        ball(), force=1.0, truth=HERTZ, areas=("blend", "cell-count", "perimeter"), cells=(128, 32, 64), repeats=2
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


def test_rows_tell_what_a_solve_of_ones_own_tells(against_hertz):
    solution = ball(64).solve(force=1.0)
    row = next(row for row in rows_by(against_hertz, "blend") if row.shape == (64, 64))
    area = solution.area()
    assert (row.area, row.area_uncertainty, row.approach) == (area.value, area.uncertainty, solution.approach)
    assert row.p_max == solution.pressure.max()
    assert row.area_error == pytest.approx(area.value / HERTZ.area - 1, abs=1e-15)
    assert (row.iterations, row.convolutions) == (solution.iterations, solution.convolutions)
    assert row.peak > solution.pressure.nbytes
    assert row.solver == "projected-cg"
    assert row.convolver == "dc-fft"


def test_the_area_is_timed_apart_and_added(against_hertz):
    for row in against_hertz.rows:
        assert row.cpu.low <= row.cpu.median <= row.cpu.high
        assert row.cpu.high >= row.solve_cpu.low + row.area_cpu.low
        assert row.cpu.low >= max(row.solve_cpu.low, row.area_cpu.low)


@pytest.mark.parametrize("quantity", ["area", "p_max", "approach"])
def test_the_front_is_one(against_hertz, quantity):
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
    timing = rc.Timing.of([cpu])
    parts = {"kernel": "love", "convolver": "dc-fft", "solver": "projected-cg", "tolerance": 1e-8, **more}
    shape = (cells, cells)
    return rc.ReportRow(
        shape=shape, estimator=estimator, area=1.0, area_error=error, cpu=timing, solve_cpu=timing, **parts
    )


def report_of(*rows, error=0.0):
    truth = rc.Truth(area=1.0, area_error=error)
    return rc.ErrorReport(rows=rows, truth=truth, nominal=2.0, scene="made up", repeats=1)


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


def test_advice_is_the_cheapest_that_is_enough_and_not_by_chance():
    assert report_of(*LUCKY).advice(area=0.005) == (
        "For 0.5 % of area: 128 x 128 cells with blend, 0.02 s; "
        "cell-count needs more than 256 x 256 cells (7.4 % there, 0.72 s); perimeter needs 256 x 256 cells (0.08 s)."
    )


def test_advice_knows_what_it_cannot_tell():
    report = report_of(*LUCKY, error=0.01)
    assert report.advice(area=0.005).startswith(
        "The true area is known to 1 % only, which cannot tell what reaches 0.5 %. For 1 % of area: 128 x 128 cells"
    )
    assert report_of(*LUCKY, error=2.0).advice().endswith("which cannot tell what reaches 0.5 %.")
    assert "128 x 128 cells with blend" in report.advice(area=0.01)
    nothing = report_of(*LUCKY[4:6])
    assert "nothing here is enough; the nearest is 256 x 256 cells with cell-count (7.4 %, 0.72 s)" in nothing.advice()
    assert "nothing to advise" in report_of(LUCKY[-1]).advice()


def test_errors_below_the_truths_own_do_not_decide():
    """The dearer case is nearer by less than anybody knows."""
    cheap, dear = made_up("blend", 64, 0.004, 0.01), made_up("blend", 128, 0.0001, 0.1)
    assert report_of(cheap, dear).front() == (cheap, dear)
    assert report_of(cheap, dear, error=0.005).front() == (cheap,)


def test_a_refined_truth_knows_its_own_error(against_refined):
    truth = against_refined.truth
    assert "128 x 128" in truth.source
    for quantity in ("area", "p_max", "approach"):
        off = abs(getattr(truth, quantity) - getattr(HERTZ, quantity))
        assert 0.0 < off <= 2.0 * getattr(truth, f"{quantity}_error")
    for row in against_refined.rows:
        assert ("area" in row.unresolved) == (row.error("area") < truth.blur("area"))
    assert any("area" in row.unresolved for row in rows_by(against_refined, "blend"))
    assert not any("area" in row.unresolved for row in rows_by(against_refined, "cell-count"))
    assert "not resolved" in str(against_refined)


@pytest.mark.parametrize("cells", [128, 256])
def test_a_refined_truth_is_within_its_own_error_where_the_grid_is_coarse(cells):
    wave = rc.Body(rc.WavySurface(0.5e-6, 12.5e-6), STEEL)
    problem = rc.ContactProblem(wave, grid=rc.Grid((cells, cells), 250e-6), boundary="periodic")
    truth = refined_truth(problem, Load(pressure=1e8, force=None, approach=None), (cells, cells), None)
    converged = {"area": printed.TRUE_AREA[100] / 100 * 250e-6**2, "p_max": 1e9 * printed.TRUE_P_MAX[100]}
    # The approach follows from 1024 x 1024 cells, whose summits are lower than the wave's by a known height.
    converged["approach"] = 6.365e-8
    for quantity, value in converged.items():
        assert abs(value - getattr(truth, quantity)) <= getattr(truth, f"{quantity}_error"), quantity


def test_a_given_approach_is_no_answer():
    truth = refined_truth(ball(32), Load(pressure=None, force=None, approach=2e-7), (32, 32), None)
    assert truth.quantities == ("area", "p_max")


def test_cases_that_fail_are_rows_that_say_so():
    capped = rc.Body(rc.SphereSurface(1e-3), rc.ElasticPerfectlyPlastic(200e9, 0.3, hardness=1.5e9))
    problem = rc.ContactProblem(capped, grid=rc.Grid((32, 32), 100e-6))
    report = rc.error_vs_time(
        problem,
        force=1.0,
        truth={"area": 7e-10},
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
    report = rc.error_vs_time(ball(32), force=1.0, truth=HERTZ, cells=(32,), areas=areas, repeats=1)
    assert [row.failure for row in report.rows] == ["", "Not today.", "ZeroDivisionError: division by zero"]


def test_parts_are_told_apart():
    report = rc.error_vs_time(
        ball(32),
        force=1.0,
        truth=HERTZ,
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
    single = {row.solver: row.single for row in report.rows}
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
        assert float(line["cpu_s_max"]) == row.cpu.high
        assert int(line["peak_bytes"]) == row.peak
        assert (line["pareto"] == "1") == (row in front)
    table = [line for line in against_hertz.to_markdown().splitlines() if line.startswith("|")]
    assert len(table) == 2 + len(against_hertz.rows)
    assert len({line.count("|") for line in table}) == 1
    cells = [cell.strip() for cell in table[2].strip("|").split("|")]
    assert cells[:2] == ["32 x 32", "blend"]
    error = float(cells[3].lstrip("* "))
    assert error == pytest.approx(100 * against_hertz.rows[0].area_error, rel=0.06)
    assert [path.name for path in tmp_path.iterdir()] == ["report.csv"]


def test_pictures(against_hertz, against_refined, tmp_path):
    made_up_ones = (report_of(*LUCKY), report_of(LUCKY[0]), report_of(LUCKY[-1]))
    for number, report in enumerate((against_hertz, against_refined, *made_up_ones)):
        path = tmp_path / f"{number}.png"
        report.draw(path)
        assert path.read_bytes()[:4] == PNG
    with pytest.raises(rc.InputError, match="ending of a picture"):
        against_hertz.draw(tmp_path / "report.hm")
    with pytest.raises(rc.InputError, match="no folder"):
        against_hertz.draw(tmp_path / "nowhere" / "report.png")
    assert len(list(tmp_path.iterdir())) == 5


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
        ({"force": 1.0, "repeats": 0}, "at least 1"),
        ({"force": 1.0, "truth": {"are": 1.0}}, "The truth must be"),
        ({"force": 1.0, "truth": {}}, "The truth must be"),
        ({"force": 1.0, "truth": 7.0}, "The truth must be"),
        ({"force": 1.0, "truth": {"area": -1.0}}, "The true area must be"),
        ({"force": 1.0, "truth": {"area_error": 1.0}}, "Nothing is known of the truth"),
        ({"force": 1.0, "between": "magic"}, "one of 'bilinear'"),
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
    with pytest.raises(rc.InputError, match="What is to be reported on"):
        rc.error_vs_time(HERTZ, force=1.0)


def rough_map(periodic):
    grid = rc.Grid((64, 48), (64e-6, 48e-6))
    heights = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=8e-6, longest=16e-6, seed=1).heights(grid)
    return rc.HeightMap(heights, size=grid.size, periodic=periodic)


def test_height_maps_go_on_as_the_user_says():
    problem = rc.ContactProblem(rc.Body(rough_map(False), STEEL))
    load = Load(pressure=5e8, force=None, approach=None)
    # Of what is linear between the points nothing finer is asked.
    assert "64 x 48" in refined_truth(problem, load, (32, 24), "bilinear").source
    placed = rc.Body(rc.PlacedMap(rough_map(False), method="bilinear"), STEEL)
    ridged = rc.ContactProblem(placed, grid=rc.Grid((30, 20), (30e-6, 20e-6)))
    assert "30 x 20" in refined_truth(ridged, load, (30, 20), None).source
    smooth = rc.ContactProblem(rc.Body(rough_map(True), STEEL), boundary="periodic")
    assert "128 x 96" in refined_truth(smooth, load, (64, 48), None).source
    report = rc.error_vs_time(problem, pressure=5e8, areas=("blend",), truth={"approach": 1e-6}, repeats=1)
    assert [row.shape for row in report.rows] == [(32, 24), (64, 48)]
    assert all("between='bilinear'" in row.failure for row in report.rows[:1])
    assert not report.rows[1].failure
    with pytest.raises(rc.InputError, match="does not tell"):
        report.advice()


def test_progress_is_told():
    seen = []
    rc.error_vs_time(
        ball(16), force=1.0, cells=(16, 32), repeats=1, on_case=lambda what, share: seen.append((what, share))
    )
    assert [what for what, _ in seen] == ["the reference", "16 x 16, projected-cg", "32 x 32, projected-cg"]
    assert [share for _, share in seen] == [0.0, 0.0, pytest.approx(0.2)]


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
    assert captured.out.startswith("64 µm x 48 µm, boundary free, pressure 500 MPa; love, dc-fft, tolerance 1e-06")
    assert "of area" in captured.out or "The true area is known to" in captured.out
    assert {path.name for path in out.iterdir()} == {"report.csv", "report.md", "report.png"}
    assert (out / "report.md").read_text(encoding="utf-8").count("| 64 x 48 |") == 4
    assert main(["report", str(tmp_path / "map.npz"), *options.split(), "--solvers", "magic", "-o", str(out)]) == 2
    assert "no solver named 'magic'" in capsys.readouterr().err


def test_the_study_runs_small(monkeypatch, tmp_path, capsys):
    monkeypatch.syspath_prepend(str(STUDIES))
    __import__("report_wavy").main((64, 128, 256), 256, 1, tmp_path)
    text = capsys.readouterr().out
    assert "| eq. 28, counts on 64 to 256, polonsky-keer |" in text
    assert "For 0.5 % of area: 256 x 256 cells with blend" in text
    assert (tmp_path / "report_wavy.png").stat().st_size > 10_000
