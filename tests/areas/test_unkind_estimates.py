"""Maximum pressure and other numbers of contacts of unkind geometry, against closed forms."""

from __future__ import annotations

import itertools
import math
import sys
from pathlib import Path

import numpy as np
import pytest

from scenes import rather_slow

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

import contact_classes
import edged_classes
import quantity_classes
import unkind_classes

import roughcontact as rc
from roughcontact.reference import Westergaard, hertz_elliptic

ALL = unkind_classes.CLASSES


def test_the_maximum_of_blunt_tips_lies_on_a_ring_and_of_paraboloids_in_the_middle():
    assert unkind_classes.find_maximum(2.0) == pytest.approx(1.0)
    assert unkind_classes.find_maximum(4.0) == pytest.approx(math.sqrt(2.0) / 3.0)
    assert unkind_classes.find_maximum(1.5) == pytest.approx(2.0)


@pytest.mark.parametrize("part", [0.05, 0.3, 0.7])
def test_closed_forms_of_strips_hold_on_a_fine_grid(part):
    exact = Westergaard(0.01, 0.5, 1.0)
    pressure = part * exact.full_contact_pressure
    solution = unkind_classes.long_strip((512, 4), (1.0, 1.0), (2, 0)).solve(pressure=pressure)
    values = contact_classes.strip_values(exact, pressure)
    assert solution.pressure.max() == pytest.approx(values["p_max"], rel=1e-3)
    assert solution.approach == pytest.approx(values["approach"], rel=2e-3)
    assert solution.gap.mean() == pytest.approx(values["mean_gap"], rel=2e-3)
    assert contact_classes.strip_values(exact, exact.full_contact_pressure)["mean_gap"] == 0.0


def test_the_classes_of_unkind_geometry_are_judged_together(capsys, monkeypatch, tmp_path):
    few = {name: lambda split, cases=cases: itertools.islice(cases(split), 2) for name, cases in ALL.items()}
    monkeypatch.setattr(quantity_classes.area_classes, "UNKIND", few)
    quantity_classes.main(["approach", "--classes", "unkind", "--cache", str(tmp_path)])
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[:2] for line in lines[2:]] == [[name, "2"] for name in ALL]


@pytest.mark.parametrize(
    "name",
    rather_slow(
        ["long-domain", "long-cells", "slender", "tip-1.5", "tip-3", "tip-4", "strips-unkind", "holes-outside"],
        ["long-cells", "tip-3", "holes-outside"],
    ),
)
def test_the_true_maximum_pressure_is_within_two_standard_deviations(name):
    ratios = []
    for case in itertools.islice(ALL[name]("held-out"), 15):
        found = case.problem().solve(**case.load).peak_pressure()
        ratios.append(abs(found.value - case.true["p_max"]) / found.uncertainty)
    assert sum(ratio <= 2.0 for ratio in ratios) >= 14, max(ratios)


@pytest.mark.parametrize("power", rather_slow([1.25, 1.5, 1.75], [1.5]))
def test_the_true_approach_of_pointed_summits_is_within_two_standard_deviations(power):
    ratios = []
    for case in itertools.islice(unkind_classes.tip("held-out", power), 15):
        found = case.problem().solve(**case.load).response("approach")
        ratios.append(abs(found.value - case.true["approach"]) / found.uncertainty)
    assert sum(ratio <= 2.0 for ratio in ratios) >= 14, max(ratios)


@pytest.mark.parametrize("shape", [(96, 48), (48, 96)])
def test_a_ridge_as_wide_as_one_or_two_cells_is_no_sharp_edge(shape):
    """A wave along the grid, whose strips have half-widths of 0.6 to 1.1 cells."""
    along = (12, 0) if shape[0] > shape[1] else (0, 12)
    exact = Westergaard(0.01, 1.0 / 12.0, 1.0)
    for half in (0.6, 0.8, 1.1):
        pressure = exact.full_contact_pressure * math.sin(math.pi * half / 8.0) ** 2
        found = unkind_classes.long_strip(shape, (1.0, 1.0), along).solve(pressure=pressure).peak_pressure()
        true = contact_classes.strip_values(exact, pressure)["p_max"]
        assert not any("unbounded" in warning for warning in found.warnings)
        assert abs(found.value - true) <= 2.0 * found.uncertainty
        assert found.uncertainty < 0.5 * true


@pytest.mark.parametrize(
    ("kind", "number", "answer", "smallest", "largest"),
    [
        # A ridge two cells wide, whose outer cells hardly touch; bells, that are no tips.
        ("ground", 1, "peak-pressure", 0.04, 0.4),
        ("balls", 7, "peak-pressure", 0.01, 0.05),
        ("balls", 3, "peak-pressure", 0.001, 0.06),
        # Wide ridges of one direction.
        ("lay", 2, "perimeter", 0.02, 0.06),
        ("rough", 6, "perimeter", 0.02, 0.07),
        # Patches that lie alike on the grid; contacts between the last cells and the border.
        ("double-wave", 1, "stiffness", 0.012, 0.03),
        ("double-wave", 9, "stiffness", 0.05, 0.1),
    ],
)
def test_smooth_contacts_are_within_two_standard_deviations_that_are_no_larger_than_it_takes(
    kind, number, answer, smallest, largest
):
    case = edged_classes.draw_case(kind, 301, number)
    found, finer = (case.solve(refinement).response(answer) for refinement in (1, 2))
    assert abs(found.value - finer.value) <= 2.0 * found.uncertainty
    assert smallest * found.value < found.uncertainty < largest * found.value
    assert bool(found.warnings) == (found.uncertainty > 0.07 * found.value)


def test_numbers_that_the_grid_determines_do_not_repeat_that_it_hardly_determines_the_area():
    solution = edged_classes.draw_case("lay", 7401, 2).solve()
    assert [text.rule for text in solution.area().warnings] == ["uncertainty"]
    for answer in ("approach", "mean-gap"):
        found = solution.response(answer)
        assert found.warnings == ()
        assert found.uncertainty < 0.02 * found.value


def test_the_stress_of_contacts_one_cell_wide_is_known_by_their_summits():
    """By their cells it erred by a tenth and more."""
    case = edged_classes.draw_case("double-wave", 303, 7)
    found, finer = (case.solve(refinement).stress().maximum_shear for refinement in (1, 2))
    assert abs(found.value - finer.value) <= 2.0 * found.uncertainty < 0.1 * found.value
    assert not any("depends on the grid" in text for text in found.warnings)


@pytest.mark.parametrize("across", [0, 1])
@pytest.mark.parametrize("sides", [(1.0, 1.0), (1.0, 3.0), (3.0, 1.0)])
def test_the_maximum_pressure_of_a_long_contact_of_one_to_three_cells_across(sides, across):
    random = np.random.default_rng((int(10 * sides[0] + sides[1]), across))
    for number in range(3):
        half = float(random.uniform(0.7, 1.6)) * sides[across]
        radii = [1e3 * half, 1e3 * half * float(random.uniform(900.0, 1200.0))]
        radii = radii if across == 0 else radii[::-1]
        force = (half / min(hertz_elliptic(1.0, radii, 1.0).semi_axes)) ** 3
        true = hertz_elliptic(force, radii, 1.0)
        cells = [9 + number] * 2
        cells[1 - across] += 2 * math.ceil(max(true.semi_axes) / sides[1 - across])
        grid = rc.Grid(cells, [n * side for n, side in zip(cells, sides, strict=True)])
        center = [float(random.uniform(-0.5, 0.5)) * side for side in sides]
        body = rc.Body(rc.ParaboloidSurface(radii, center), rc.Elastic(1.0, 0.0))
        found = rc.ContactProblem(body, grid=grid).solve(force=force).peak_pressure(uncertainty="model")
        # The highest cell errs by up to 29 %.
        assert abs(found.value / true.p_max - 1.0) < 0.015
        assert abs(found.value - true.p_max) < 2.0 * found.uncertainty < 0.05 * found.value
        assert found.warnings == ()
