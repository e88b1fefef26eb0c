"""Openings, nested grids and refinements of the default solver beside closed forms."""

from __future__ import annotations

import math

import attrs
import numpy as np
import pytest

import roughcontact as rc
from roughcontact._solve.problem.task import pressure_unit
from roughcontact._solve.solvers.conjugate.descent import ActiveState, Descent
from roughcontact._solve.solvers.conjugate.nested_iteration import PressureOnGrid
from roughcontact._solve.solvers.conjugate.preconditioner import Preconditioner, PunchWeights, _smaller
from roughcontact._solve.solvers.conjugate.refinement import (
    NearlyFull,
    OpeningPreconditioner,
    Openings,
    PressureRefinement,
)
from roughcontact._solve.solvers.driver import Work
from roughcontact._solve.solvers.grids import climb
from roughcontact._solve.solvers.passes import active_cells
from roughcontact._solve.solvers.projection import ApproachControl, LoadControl
from roughcontact.solving import make_task, starting_pressure
from roughcontact.typing import Load, Monitor

SIZE = (64.0, 96.0)


def wave(shape=(64, 48), boundary="periodic", hardness=None, surface=None):
    """Waves of the height 1 and the wave number 2 pi / 32 along both axes; E* = 1."""
    material = rc.Elastic(1.0, 0.0) if hardness is None else rc.ElasticPerfectlyPlastic(1.0, 0.0, hardness)
    surface = rc.WavySurface(1.0, 32.0) if surface is None else surface
    return rc.ContactProblem(rc.Body(surface, material), grid=rc.Grid(shape, SIZE), boundary=boundary, threads=1)


def task_of(given, fraction=0.9, **options):
    """The task of a part of the pressure that closes the wave."""
    task = make_task(given.plan, given.initial_gap, Load("pressure", fraction * closing_pressure(given)))
    return attrs.evolve(task, **options)


def closing_pressure(given):
    """The largest pressure that keeps a surface closed, by its spectrum: half of E* q for each of its waves."""
    (dx, dy), heights = given.plan.grid.spacing, -given.initial_gap
    qx, qy = np.fft.fftfreq(heights.shape[0], dx)[:, np.newaxis], np.fft.rfftfreq(heights.shape[1], dy)
    stiffness = 0.5 * 2.0 * np.pi * np.hypot(qx, qy)
    return float(-np.fft.irfft2(np.fft.rfft2(heights) * stiffness, heights.shape).min())


def test_a_wave_is_closed_by_half_of_its_stiffness_times_its_height():
    given = wave(surface=rc.WavySurface(1.0, 32.0))
    for part, closed in ((1.05, True), (0.95, False)):
        task = task_of(given, part)
        full = PressureOnGrid(given.convolution, task).close()
        unit = pressure_unit(given.plan)
        assert full.closing.mean() == pytest.approx(task.mean_pressure, rel=1e-12)
        lowest = full.closing.min() * unit / closing_pressure(given)
        assert lowest == pytest.approx(part - 1.0, abs=0.03)
        assert full.is_closed(task.pressure_limit) == closed
        assert not full.is_closed(np.array(0.5 * full.closing.max()))
        guess = PressureOnGrid(given.convolution, task).begin()
        assert guess.closed == closed
        assert guess.products == 1
    assert PressureOnGrid(given.convolution, attrs.evolve(task, mean_pressure=None, approach=0.1)).close() is None
    assert PressureOnGrid(wave(boundary="free").convolution, task).close() is None


@pytest.mark.parametrize("fraction", [0.9, 0.97])
def test_the_pressure_of_the_openings_is_that_of_the_solver(fraction):
    """From the exact gap one product gives the pressure; from none the descent finds both, in float32 and float64."""
    given = wave()
    task, unit = task_of(given, fraction), pressure_unit(given.plan)
    solution = given.solve(pressure=fraction * closing_pressure(given), tolerance=1e-9)
    exact, gap = solution.pressure / unit, np.where(solution.contact, 0.0, solution.gap) / given.plan.peak_to_valley
    full = PressureOnGrid(given.convolution, task).close()
    for start in (np.zeros_like(gap), gap):
        monitor = Monitor(task, 1e-7, 200)
        work = Work()
        openings = Openings(attrs.evolve(full, gap=start.astype(np.float32)), monitor, work)
        found = openings.solve(1e-7)
        np.testing.assert_allclose(found, exact, atol=2e-4 * exact.max())
        np.testing.assert_allclose(openings.gap, gap, atol=2e-4)
        assert openings.error <= 1e-6
        assert found.mean() == pytest.approx(task.mean_pressure, rel=1e-5)
        assert found.min() == 0.0
        near = attrs.evolve(full, gap=start.astype(np.float32))
        rough = Openings(near, Monitor(task, 1e-7, 200), Work()).approximate(1e-4)
        np.testing.assert_allclose(rough, exact, atol=5e-3 * exact.max())
        assert work.inverse <= 60
    # Without an iteration it is the pressure of the gap alone.
    known = attrs.evolve(full, gap=gap.astype(np.float32))
    np.testing.assert_allclose(
        Openings(known, Monitor(task, 1e-7, 0), Work()).approximate(1e-4), exact, atol=1e-3 * exact.max()
    )


def test_the_error_of_openings_is_the_pull_or_the_pressure_on_open_cells():
    given = wave()
    full = PressureOnGrid(given.convolution, task_of(given)).close()
    openings = Openings(full, Monitor(task_of(given), 1e-6, 10), Work())
    pressure = np.full(full.closing.shape, 2.0)
    assert openings._measure(pressure) == 0.0
    pressure[3, 3] = -0.5
    assert openings._measure(pressure) == pytest.approx(0.25)
    openings.gap[5, 5], openings.gap[6, 6] = 1.0, 3.0
    pressure[6, 6] = 1.0
    assert openings._measure(pressure) == pytest.approx((2.0 + 3.0) / 4.0 / 2.0)
    bounded = openings._bound(pressure.copy())
    assert bounded[3, 3] == bounded[5, 5] == bounded[6, 6] == 0.0
    assert np.count_nonzero(bounded == 2.0) == pressure.size - 3


def test_the_openings_are_supported_by_a_quarter_of_their_stiffness():
    given = wave()
    inverse = given.convolution.inverse(np.float32)
    shape = (64, 48)
    marked = np.zeros(shape, dtype=bool)
    marked[10:16, 20:26] = True
    active = active_cells(marked.ravel().astype(np.float32), lambda tile: marked.ravel()[tile])
    work = Work()
    preconditioner = OpeningPreconditioner(inverse, shape, work)
    np.testing.assert_array_equal(preconditioner.weights(active), active.ones)
    mean = float(inverse.apply(marked.astype(np.float32))[marked].mean())
    assert preconditioner._support == pytest.approx(0.25 * mean, rel=1e-4)
    before = work.inverse
    preconditioner.apply(active, active.ones, active.ones)
    assert work.inverse == before + 1


@pytest.mark.usefixtures("as_on_large_grids")
@pytest.mark.parametrize("hardness", [None, 0.05])
def test_a_nested_start_is_near_the_solution_and_within_its_bounds(hardness):
    given = wave((128, 96), hardness=hardness)
    load = 0.5 * closing_pressure(given) if hardness is None else 0.02
    solution = given.solve(pressure=load)
    task, unit = make_task(given.plan, given.initial_gap, Load("pressure", load)), pressure_unit(given.plan)
    guess = climb(PressureOnGrid(given.convolution, task))
    assert [level.shape for level in guess.levels] == [(32, 48), (64, 48)]
    pressure = guess.pressure
    if guess.nearly_full is None:
        assert pressure.min() >= 0.0
        assert (pressure <= task.pressure_limit).all()
    else:
        assert hardness is None
        assert guess.nearly_full.gap.min() == 0.0 < guess.nearly_full.gap.max()
        pressure = pressure + guess.nearly_full.inverse.apply(guess.nearly_full.gap)
    assert pressure.shape == (128, 96)
    assert np.abs(pressure * unit - solution.pressure).mean() < 0.05 * load
    assert 0.0 < guess.products < 15.0
    assert guess.met_limit == (hardness is not None)


@pytest.mark.usefixtures("as_on_large_grids")
def test_open_cells_of_a_coarse_grid_stay_open_where_the_gap_does():
    """The pressure of a coarse grid is interpolated where it bears, or where the gap would be negative."""
    given = wave((128, 96))
    fine = task_of(given, 0.5)
    coarse_given = wave((64, 48))
    coarse = task_of(coarse_given, 0.5, mean_pressure=fine.mean_pressure)
    guess = PressureOnGrid(coarse_given.convolution, coarse).begin()
    pressure = np.zeros((64, 48))
    pressure[10:20, 10:20] = 1.0
    displacement = np.full((64, 48), 0.5, dtype=np.float32)
    displacement[30:40, 30:40] = -2.0
    guess = attrs.evolve(guess, pressure=pressure, displacement=displacement)
    found = PressureOnGrid(given.convolution, fine).refine(
        PressureOnGrid(coarse_given.convolution, coarse), guess, 2, 2
    )
    bearing = found.pressure > 0.0
    assert bearing[20:40, 20:40].all()
    outside = bearing.copy()
    outside[20:40, 20:40] = False
    assert not outside.any()
    np.testing.assert_allclose(found.pressure[24:36, 24:36], 1.0)
    assert found.nearly_full is None


@pytest.mark.usefixtures("as_on_large_grids")
def test_a_start_near_full_contact_has_the_gap_that_it_leaves():
    given = wave()
    task, unit = task_of(given, 0.97), pressure_unit(given.plan)
    solution = given.solve(pressure=0.97 * closing_pressure(given), tolerance=1e-8)
    start = PressureOnGrid(given.convolution, task).start_from(solution.pressure / unit)
    gap = np.where(solution.contact, 0.0, solution.gap) / given.plan.peak_to_valley
    np.testing.assert_allclose(start.nearly_full.gap, gap, atol=1e-4)
    assert start.products == 2
    light = PressureOnGrid(given.convolution, task_of(given, 0.3)).start_from(np.zeros((64, 48)))
    assert (light.nearly_full, light.products) == (None, 0.0)
    closed = PressureOnGrid(given.convolution, task_of(given, 1.2)).start_from(np.ones((64, 48)))
    assert closed.closed


@pytest.mark.usefixtures("on_fields_and_on_lists")
@pytest.mark.parametrize("boundary", ["periodic", "free"])
@pytest.mark.parametrize("given_load", [True, False])
def test_a_refinement_ends_where_the_conditions_hold(boundary, given_load):
    """Verified in float64; from a start of nothing, or of the solution, which takes one verification."""
    given = wave((48, 40), boundary)
    solution = given.solve(pressure=0.1 * closing_pressure(given), tolerance=1e-8)
    load = Load("pressure", solution.mean_pressure) if given_load else Load("approach", solution.approach)
    task = make_task(given.plan, given.initial_gap, load)
    monitor = Monitor(task, 1e-6, 300)
    refinement = PressureRefinement(given.convolution, task, monitor)
    pressure, violation, status = refinement.run(starting_pressure(task))
    assert status is rc.Status.CONVERGED
    assert violation.error <= 1e-6
    assert violation.approach * given.plan.peak_to_valley == pytest.approx(solution.approach, rel=1e-4)
    unit = pressure_unit(given.plan)
    np.testing.assert_allclose(pressure * unit, solution.pressure, atol=1e-3 * solution.pressure.max())
    level = refinement.level
    assert level.shape == (48, 40)
    assert level.double <= 6
    assert level.double + level.single + level.inverse <= 120
    assert not refinement.met_limit
    again = PressureRefinement(given.convolution, task, Monitor(task, 1e-5, 300))
    assert again.run(pressure.copy())[2] is rc.Status.CONVERGED
    assert (again.level.double, again.level.single, again.level.inverse) == (1, 0, 0)


def test_a_saturated_cell_that_overlaps_is_no_error_of_the_descent():
    """In any tile; an elastic cell that does is, and so is an open gap under a saturated one."""
    n = 2**16

    class Springs:
        def apply(self, *arguments):
            return arguments[-1]

        def weights(self, active):
            return active.ones

    springs = Springs()
    for place in (3, n + 5):
        for saturated, gap_there, expected in ((True, -0.5, 0.0), (False, -0.5, 0.5), (True, 0.25, 0.25)):
            pressure, gap = np.zeros(2 * n), np.full(2 * n, 1.0, dtype=np.float32)
            pressure[place], gap[place] = (2.0, gap_there) if saturated else (1.0, gap_there)
            for limit in (np.array([2.0]), np.full(2 * n, 2.0)):
                descent = Descent(springs.apply, (2, n), springs, ApproachControl(), limit)
                descent.start(pressure.copy(), gap.copy())
                active = active_cells(pressure, lambda tile, pressure=pressure: pressure[tile] > 0.0)
                descent._state = ActiveState(active, active.gather(pressure), active.ones)
                descent._active_gap = active.gather(gap)
                assert descent.find_error() == pytest.approx(expected)


def test_the_level_between_saturated_and_open_cells():
    """Without an elastic cell the level lies half-way between both, so that either can move."""

    class Springs:
        def apply(self, *arguments):
            return arguments[-1]

        def weights(self, active):
            return active.ones

    pressure = np.array([2.0, 2.0, 0.0, 0.0])
    gap = np.array([0.3, 0.1, 0.9, 1.4], dtype=np.float32)
    springs = Springs()
    descent = Descent(springs.apply, (2, 2), springs, LoadControl(4.0), np.array([2.0]))
    descent.start(pressure, gap)
    assert descent._find_level(np.zeros(2, dtype=bool), np.zeros(2)) == pytest.approx(0.6)
    assert LoadControl(1.0).level(gap, np.array([1.0, 3.0, 0.0, 0.0], dtype=np.float32)) == pytest.approx(0.15)
    assert LoadControl(1.0).level(gap, np.zeros(4, dtype=np.float32)) == 0.0
    assert ApproachControl().level(gap, gap) == ApproachControl().level_between(1.0, 2.0) == 0.0


def test_weights_are_computed_again_after_many_changes_alone():
    given = wave((60, 70))
    inverse = given.convolution.inverse(np.float32)
    shape = (60, 70)
    work = Work()
    weights = PunchWeights(inverse, shape, work)
    marked = np.zeros(shape, dtype=bool)
    marked[10:40, 10:40] = True

    def update():
        flat = marked.ravel().copy()
        active = active_cells(flat.astype(np.float32), lambda tile: flat[tile])
        found = weights.update(active)
        exact = inverse.apply(marked.astype(np.float32)).ravel()
        np.testing.assert_allclose(active.scatter(found)[flat], np.maximum(exact[flat], 0.0), rtol=0.1, atol=0.02)
        return weights.renewed, work.inverse

    assert update() == (True, 1)
    marked[40, 10:40] = True
    assert update() == (False, 1)
    assert update() == (False, 1)
    # More than three hundredths of all cells at once.
    marked[45:52, 10:40] = True
    assert update() == (True, 2)
    few = active_cells(np.ones(100, dtype=np.float32), lambda tile: np.arange(100)[tile] < 30)
    many = active_cells(np.ones(100, dtype=np.float32), lambda tile: np.arange(100)[tile] < 90)
    assert (_smaller(few), _smaller(many)) == (30, pytest.approx(12.0))


@pytest.mark.parametrize("rigid", [False, True])
def test_the_preconditioner_is_symmetric_and_nearly_the_inverse(rigid):
    """On a contact of several discs: twice as near to the answer as the step of one length for all cells, or nearer."""
    given = wave((64, 48))
    shape = (64, 48)
    i, j = np.indices(shape)
    marked = (np.hypot(i % 16 - 8, j % 16 - 8) < 5).ravel()
    active = active_cells(marked.astype(np.float32), lambda tile: marked[tile])
    preconditioner = Preconditioner(given.convolution.inverse(np.float32), given.convolution, Work(), rigid=rigid)
    weights = preconditioner.weights(active)
    rng = np.random.default_rng(3)

    def inner(one, other):
        return float(np.sum(one.astype(float) * other.astype(float)))

    one, other = (active.gather(rng.normal(size=marked.size).astype(np.float32)) for _ in range(2))
    first, second = preconditioner.apply(active, weights, one), preconditioner.apply(active, weights, other)
    scale = math.sqrt(inner(first, first) * inner(other, other))
    assert abs(inner(first, other) - inner(one, second)) < 0.05 * scale
    assert inner(first, one) > 0.0
    if rigid:
        return
    # Smooth pressures: the preconditioned displacement is nearly the pressure that causes it, but for its mean.
    pressure = np.sqrt(np.maximum(1.0 - (np.hypot(i % 16 - 8, j % 16 - 8) / 5.0) ** 2, 0.0))
    caused = active.gather(given.convolution.apply(pressure).ravel().astype(np.float32))
    caused -= np.float32(inner(caused, weights) / weights.sum())
    answer, wanted = preconditioner.apply(active, weights, caused), active.gather(pressure.ravel())
    answer, wanted = (values - weights * (values.sum() / weights.sum()) for values in (answer, wanted))
    assert np.linalg.norm(answer - wanted) < 0.35 * np.linalg.norm(wanted)


@pytest.mark.slow
@pytest.mark.usefixtures("on_fields_and_on_lists")
@pytest.mark.parametrize("boundary", ["periodic", "free"])
def test_a_limit_that_shortens_steps_but_is_not_reached_changes_no_bit(boundary):
    """The steps pass the maximum pressure on their way: such contacts are solved again without the limit."""
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=8.0, longest=48.0, rolloff=48.0, seed=2)
    again = 0
    for load in (0.003, 0.01):
        free = wave((64, 48), boundary, surface=surface).solve(pressure=load)
        for factor in (1.0001, 1.02, 1.3):
            found = wave((64, 48), boundary, factor * free.pressure.max(), surface).solve(pressure=load)
            np.testing.assert_array_equal(found.pressure, free.pressure)
            again += found.convolutions > free.convolutions
    assert again


def test_nearly_full_contact_is_within_its_bounds():
    closing = np.array([[0.1, 0.5], [0.2, 0.0]])
    start = NearlyFull(None, closing, np.zeros((2, 2), dtype=np.float32))
    assert start.is_closed(np.array(0.5))
    assert not start.is_closed(np.array(0.49))
    assert not attrs.evolve(start, closing=closing - 1e-9).is_closed(np.array(math.inf))
    assert not start.is_closed(np.array([[1.0, 1.0], [0.1, 1.0]]))
