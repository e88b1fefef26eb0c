"""Areas and their uncertainties on long domains and cells, slender ellipses, tips and oblique strips."""

from __future__ import annotations

import itertools
import sys
from pathlib import Path

import numpy as np
import pytest

import roughcontact as rc
from scenes import rather_slow

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

import image_constants
import unkind_classes

from roughcontact.reference import hertz_elliptic

WARNING = ["tip-1", "tip-4", "slender", "strips-unkind"]
# Tips of few cells err by more than is stated.
HELD = [name for name in unkind_classes.CLASSES if name not in ("tip-1.5", "tip-4")]


@pytest.mark.parametrize("name", rather_slow(HELD, HELD[::4]))
def test_the_true_area_is_within_two_standard_deviations(name):
    ratios = []
    for case in itertools.islice(unkind_classes.CLASSES[name]("held-out"), 15):
        area = case.problem().solve(**case.load).area()
        ratios.append(abs(area.value - case.true["area"]) / area.uncertainty)
    assert sum(ratio <= 2.0 for ratio in ratios) >= 14, max(ratios)


def press_rough(shape, seed, load):
    surface = rc.SelfAffineSurface(
        hurst=(0.3, 0.8)[seed % 2], rms_slope=0.1, shortest=24.0 / 23.5, longest=4.0, seed=700 + seed
    )
    body = rc.Body(surface, rc.Elastic(1.0, 0.0))
    return rc.ContactProblem(body, grid=rc.Grid(shape, 8.0), boundary="periodic").solve(pressure=load).area()


@pytest.mark.slow
def test_rough_contacts_on_cells_three_times_as_long_as_wide_are_within_two():
    ratios = []
    for seed, load in enumerate(np.geomspace(1e-3, 1.5e-2, 6)):
        true = press_rough((192, 192), seed, load).value
        for cells in (24, 32, 48):
            for shape in ((cells, 3 * cells), (3 * cells, cells)):
                area = press_rough(shape, seed, load)
                ratios.append(abs(area.value - true) / area.uncertainty)
    assert np.mean(np.array(ratios) <= 2.0) >= 0.93, max(ratios)


@pytest.mark.slow
def test_the_uncertainty_of_rough_contacts_is_at_most_two_and_a_half_times_the_error():
    errors, stated = [], []
    for seed, load in enumerate(np.geomspace(1e-3, 2e-2, 10)):
        true = press_rough((192, 192), 60 + seed, load).value
        for cells in (32, 44, 64):
            area = press_rough((cells, cells), 60 + seed, load)
            errors.append(abs(area.value - true) / true)
            stated.append(area.uncertainty / true)
    assert np.median(stated) <= 2.5 * np.median(errors)
    assert np.mean(np.array(errors) <= 2.0 * np.array(stated)) >= 0.93


def test_the_uncertainty_of_paraboloids_is_at_most_three_times_the_error():
    errors, stated = [], []
    for name in ("long-domain", "long-cells", "slender", "tip-2"):
        for case in itertools.islice(unkind_classes.CLASSES[name]("held-out"), 8):
            area = case.problem().solve(**case.load).area()
            errors.append(abs(area.value / case.true["area"] - 1.0))
            stated.append(area.uncertainty / case.true["area"])
    assert np.median(stated) <= 3.0 * np.median(errors)
    assert max(errors) <= 1e-3


def test_perimeters_of_oblique_strips_are_within_two_and_no_large_error_goes_unwarned():
    ratios, unwarned = [], []
    for case in itertools.islice(unkind_classes.strips("held-out"), 18):
        length = case.problem().solve(**case.load).response("perimeter")
        error = abs(length.value - case.true["perimeter"])
        ratios.append(error / length.uncertainty)
        unwarned.append(0.0 if length.warnings else error / case.true["perimeter"])
    assert max(ratios) <= 2.0
    assert max(unwarned) <= 0.1


@pytest.mark.slow
def test_perimeters_of_light_contacts_with_a_lay_are_within_two():
    ratios = []
    for seed, angle in enumerate(np.repeat([0.0, 0.4, np.pi / 4], 4)):
        surface = rc.SelfAffineSurface(
            hurst=0.8, rms_slope=0.1, shortest=1.0, longest=6.0, seed=80 + seed, peklenik=5.0, lay=angle
        )
        body = rc.Body(surface, rc.Elastic(1.0, 0.0))
        true, coarse = (
            rc.ContactProblem(body, grid=rc.Grid((cells, cells), 12.0), boundary="periodic").solve(pressure=5e-4)
            for cells in (240, 60)
        )
        length = coarse.response("perimeter")
        ratios.append(abs(length.value - true.response("perimeter").value) / length.uncertainty)
    assert sum(ratio <= 2.0 for ratio in ratios) >= 10, max(ratios)


def test_ridges_along_a_diagonal_are_as_long_as_on_a_finer_grid():
    """Their ends are narrower than a cell."""
    errors = []
    for seed in range(6):
        surface = rc.SelfAffineSurface(
            hurst=0.8, rms_slope=0.1, shortest=1.0, longest=6.0, seed=40 + seed, peklenik=5.0, lay=np.pi / 4
        )
        body = rc.Body(surface, rc.Elastic(1.0, 0.0))
        true, coarse = (
            rc.ContactProblem(body, grid=rc.Grid((cells, cells), 12.0), boundary="periodic")
            .solve(pressure=5e-4)
            .response("perimeter")
            for cells in (192, 48)
        )
        errors.append(coarse.value / true.value - 1.0)
    assert abs(np.mean(errors)) < 0.06, errors


@pytest.mark.parametrize("name", rather_slow(unkind_classes.CLASSES, WARNING))
def test_an_area_that_errs_by_more_than_a_tenth_warns(name):
    for case in unkind_classes.CLASSES[name]("tuned"):
        area = case.problem().solve(**case.load).area()
        assert area.warnings or abs(area.value / case.true["area"] - 1.0) < 0.1, case.label


def press_cut(shape, cell, seed, finer):
    size = (shape[0] * cell[0], shape[1] * cell[1])
    surface = rc.SelfAffineSurface(
        hurst=0.7, rms_slope=0.05, shortest=6.0 * max(cell), longest=0.8 * min(size), seed=90 + seed
    )
    body = rc.Body(surface, rc.Elastic(1.0, 0.0))
    grid = rc.Grid((finer * shape[0], finer * shape[1]), size)
    return rc.ContactProblem(body, grid=grid, boundary="free").solve(pressure=(1e-3, 4e-3, 1e-2)[seed % 3])


@pytest.mark.slow
@pytest.mark.parametrize("quantity", ["perimeter", "approach", "mean-gap"])
def test_rough_contacts_that_a_free_border_cuts_are_within_two(quantity, cut_contacts):
    ratios = []
    for coarse, fine in cut_contacts:
        found, true = coarse.response(quantity), fine.response(quantity)
        ratios.append(abs(found.value - true.value) / found.uncertainty)
    assert sum(ratio <= 2.0 for ratio in ratios) >= len(ratios) - 1, ratios


def test_maximum_pressure_is_unbounded_where_a_free_border_cuts_the_contact(cut_contacts):
    bounded = 0
    for coarse, fine in cut_contacts:
        peak = coarse.peak_pressure()
        if peak.uncertainty < peak.value:
            # Where the border is far below the maximum, that is the same on fine grids.
            assert fine.pressure.max() < 1.1 * peak.value
            bounded += 1
        else:
            assert peak.warnings
    assert 2 * bounded < len(cut_contacts)


@pytest.fixture(scope="module")
def cut_contacts():
    shapes = [((41, 41), (1.0, 1.0)), ((96, 24), (1.0, 1.0)), ((23, 71), (1.0, 1.0)), ((30, 44), (3.0, 1.0))]
    cases = [(shape, cell, seed) for seed in range(3) for shape, cell in shapes]
    return [tuple(press_cut(*case, finer) for finer in (1, 5)) for case in cases]


def test_approach_of_ellipses_on_long_cells():
    # The shift by uniform pressure on each cell goes with the curvature along each axis, times its own side squared.
    for turned in (False, True):
        radii, cell, shape = (1.2e4, 2e5), (3.0, 1.0), (17, 161)
        step = -1 if turned else 1
        size = (shape[0] * cell[0], shape[1] * cell[1])
        exact = hertz_elliptic(1.0, radii, 1.0)
        force = (9.0 / min(exact.semi_axes)) ** 3
        exact = hertz_elliptic(force, radii, 1.0)
        body = rc.Body(rc.ParaboloidSurface(radii[::step], center=(0.3, -0.2)), rc.Elastic(1.0, 0.0))
        solution = rc.ContactProblem(body, grid=rc.Grid(shape[::step], size[::step])).solve(force=force)
        found = solution.response("approach")
        assert abs(found.value - exact.approach) <= 2.0 * found.uncertainty
        assert found.uncertainty < 1e-3 * found.value


@pytest.mark.parametrize("case", list(image_constants.list_ellipses(4, 15)), ids=lambda case: str(case.boundary))
def test_areas_and_pressures_of_ellipses_beside_their_own_images_are_within_two(case):
    """Hertz's closed form of a single ellipse does not hold there: areas erred by up to 18 %, stated to 1e-6."""
    for error, std in image_constants.measure(case)[1:]:
        assert abs(error) <= 2.0 * std
