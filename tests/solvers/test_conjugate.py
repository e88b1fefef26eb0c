"""The default solver: counts, controls, limits, windows, and agreement with the others."""

from __future__ import annotations

import tracemalloc

import attrs
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import roughcontact as rc
from extended_precision import violations
from roughcontact.solving import estimate_approach, make_task, solve_in_window
from roughcontact.typing import InverseConvolution, Load, Task
from scenes import each_once, make_rough, rather_slow
from strategies import STRICT, height_maps, moduli, problems, strict

YOUNG, SLOPE = 1.0, 0.1


def rough(n, *, hardness=None, cells=8, solver=STRICT, **parts):
    material = rc.Elastic(YOUNG, 0.0) if hardness is None else rc.ElasticPerfectlyPlastic(YOUNG, 0.0, hardness)
    waves = {"rms_slope": SLOPE, "shortest": float(cells), "longest": float(n), "rolloff": n / 8}
    return make_rough(n, float(n), material, solver=solver, **waves, **parts)


SIZES = rather_slow([64, 256, 1024], [64, 256])


@pytest.mark.parametrize("n", SIZES)
@each_once(
    {
        "boundary": ["free", "periodic", "wrapped"],
        "cells fraction": [(8, 0.01), (8, 0.05), (8, 0.2), (8, 1.0), (2, 0.2)],
    }
)
def test_iterations_hardly_grow_with_the_grid(n, boundary, cells, fraction):
    solution = rough(n, boundary=boundary, cells=cells).solve(pressure=fraction * SLOPE * YOUNG)
    assert solution.status is rc.Status.CONVERGED
    assert solution.iterations <= 25
    assert solution.convolutions <= 62


@pytest.mark.parametrize("n", SIZES)
@each_once(
    {
        "boundary": ["free", "periodic"],
        "fraction": [1e-6, 0.01, 0.2, 0.5, 0.9, 0.99, 1.0],
    }
)
def test_iterations_with_a_limit(n, boundary, fraction):
    hardness = 0.3 * YOUNG * SLOPE
    solution = rough(n, boundary=boundary, hardness=hardness).solve(pressure=fraction * hardness)
    assert solution.iterations <= 40
    assert solution.pressure.max() <= hardness
    assert solution.residuals.load <= 1e-12


@pytest.mark.slow
@pytest.mark.parametrize("part", [0.33, 0.67])
def test_a_million_cells_most_of_which_are_saturated(part):
    """Rounding of their load once unsaturated all of them, and the descent stalled."""
    solution = rough(1024, hardness=0.3 * YOUNG * SLOPE, seed=9).solve(pressure=part * 0.3 * YOUNG * SLOPE)
    assert solution.status is rc.Status.CONVERGED
    assert solution.iterations <= 25


@pytest.mark.usefixtures("on_fields_and_on_lists")
@each_once(
    {
        "boundary": ["free", "periodic", "wrapped"],
        "fraction": [0.02, 0.1, 0.2, 0.35, 0.5, 0.7, 0.85, 0.95, 0.995],
    }
)
def test_approach_and_load_find_one_solution(boundary, fraction):
    problem = rough(96, boundary=boundary)
    by_approach = problem.solve(approach=fraction * problem.initial_gap.mean())
    if not by_approach.contact.any():
        pytest.skip("this approach does not touch")
    assert by_approach.iterations <= 35
    by_load = problem.solve(pressure=by_approach.mean_pressure)
    np.testing.assert_allclose(by_load.pressure, by_approach.pressure, atol=1e-6 * by_load.pressure.max())
    assert by_load.approach == pytest.approx(by_approach.approach, rel=1e-6)


@pytest.mark.usefixtures("on_fields_and_on_lists")
@pytest.mark.parametrize("boundary", ["free", "periodic", "wrapped"])
def test_agrees_with_the_independent_solvers(boundary):
    fast = rough(96, boundary=boundary).solve(pressure=5e-3)
    for solver in ("polonsky-keer", "spectral-gradient"):
        other = rough(96, boundary=boundary, solver=strict(solver)).solve(pressure=5e-3)
        np.testing.assert_allclose(other.pressure, fast.pressure, atol=1e-6 * fast.pressure.max())


@pytest.mark.slow
@pytest.mark.usefixtures("on_fields_and_on_lists")
def test_a_limit_may_differ_from_place_to_place():
    limits = np.where(np.arange(64)[:, None] < 32, 0.02, 0.06) * np.ones((64, 64))
    solution = rough(64, hardness=limits).solve(pressure=8e-3)
    assert (solution.pressure <= limits).all()
    assert solution.saturated[:32].any()
    assert solution.saturated[32:].any()
    assert np.array_equal(solution.saturated, solution.pressure >= limits)
    found = violations(rough(64, hardness=limits), {"pressure": 8e-3}, solution)
    assert found.holds, found


@attrs.frozen(eq=False)
class PartlySoft(rc.Material):
    """Elastic, with a pressure limit on the first rows only."""

    limits: np.ndarray
    compliance = 1.0 / YOUNG

    @property
    def pressure_limit(self):
        return self.limits


@pytest.mark.usefixtures("on_fields_and_on_lists")
@pytest.mark.parametrize("boundary", ["free", "periodic", "wrapped"])
@pytest.mark.parametrize("load", [0.008, 0.05])
def test_a_limit_may_be_infinite_in_places(boundary, load):
    limits = np.where(np.arange(64)[:, None] < 32, 0.02, np.inf) * np.ones((64, 64))
    solution = attrs.evolve(
        rough(64, boundary=boundary), body=rc.Body(rough(64).body.surface, PartlySoft(limits))
    ).solve(pressure=load)
    assert solution.status is rc.Status.CONVERGED
    assert solution.iterations <= 25
    assert solution.saturated[:32].any()
    assert solution.pressure[32:].max() > 0.02
    assert solution.residuals.error <= 2e-8


def test_a_limit_is_carried_as_an_array_of_one_entry_or_one_per_cell():
    gap = rough(64).initial_gap
    for limit, size in ((np.inf, 1), (0.02, 1), (np.full((1, 1), 0.02), 1), (np.full(gap.shape, 0.02), gap.size)):
        task = Task(initial_gap=gap, mean_pressure=0.005, pressure_limit=limit)
        assert isinstance(task.pressure_limit, np.ndarray)
        assert task.pressure_limit.size == size
        assert task.capped == np.isfinite(limit).any()
        assert np.broadcast_shapes(task.pressure_limit.shape, gap.shape) == gap.shape


@pytest.mark.usefixtures("on_fields_and_on_lists")
@pytest.mark.parametrize("boundary", ["free", "periodic", "wrapped"])
def test_one_limit_for_all_cells_is_that_limit_on_each_cell(boundary):
    one = rough(64, boundary=boundary, hardness=0.03).solve(pressure=8e-3)
    each = rough(64, boundary=boundary, hardness=np.full((64, 64), 0.03)).solve(pressure=8e-3)
    assert one.saturated.any()
    np.testing.assert_allclose(each.pressure, one.pressure, atol=1e-6 * one.pressure.max())


@pytest.mark.usefixtures("on_fields_and_on_lists")
@pytest.mark.parametrize("count", [1, 2, 5, 40])
def test_a_start_without_an_elastic_cell_is_left(count):
    """The wrong cells are saturated, and carry the load exactly."""
    hardness = 0.03
    problem = rough(64, hardness=hardness)
    start = np.zeros((64, 64))
    start.ravel()[np.argsort(problem.initial_gap, axis=None)[-count:]] = hardness
    solution = problem.solve(pressure=count * hardness / start.size, start=start)
    assert solution.status is rc.Status.CONVERGED


@pytest.mark.usefixtures("on_fields_and_on_lists")
@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_contacts_of_some_cells(boundary):
    """Conjugating cancels all of the direction but its rounding there."""
    problem = rough(64, boundary=boundary, cells=2)
    for pressure in np.geomspace(1e-9, 1e-5, 20):
        solution = problem.solve(pressure=pressure)
        assert solution.status is rc.Status.CONVERGED
        assert solution.iterations <= 15


@pytest.mark.usefixtures("on_fields_and_on_lists")
def test_the_maximum_load_of_an_uneven_limit_is_its_mean():
    limits = np.full((64, 64), 0.02)
    limits[:32] = 0.04
    problem = rough(64, hardness=limits)
    np.testing.assert_array_equal(problem.solve(pressure=0.03).pressure, limits)
    with pytest.raises(rc.InputError, match="at most 30 mPa"):
        problem.solve(pressure=0.031)


@pytest.mark.usefixtures("as_on_large_grids")
@each_once(
    {
        "kernel": ["love", "fourier"],
        "fraction": [0.4, 0.7, 1.0, 1.4],
    }
)
def test_near_full_contact_the_openings_give_the_same_pressure(kernel, fraction, monkeypatch):
    """They are sought on the two finest grids at least; without them the pressure is."""
    problem = rough(128, kernel=kernel)
    solution = problem.solve(pressure=fraction * SLOPE * YOUNG)
    assert solution.status is rc.Status.CONVERGED
    assert solution.levels[-1].single == 0
    monkeypatch.setattr("roughcontact._solve.solvers.conjugate.nested_iteration._NEARLY_FULL_FRACTION", 1.0)
    direct = problem.solve(pressure=fraction * SLOPE * YOUNG)
    assert direct.levels[-1].single > 0
    np.testing.assert_allclose(solution.pressure, direct.pressure, atol=1e-6 * direct.pressure.max())


@pytest.mark.parametrize("shape", [(64, 64), (63, 33), (5, 8), (1, 7)])
def test_coefficients_of_the_inverse_are_the_response_to_one_cell(shape):
    inverse = InverseConvolution(np.hypot(*np.ogrid[: shape[0], : shape[1] // 2 + 1]), shape)
    inverse.stiffness[shape[0] // 2 + 1 :] = inverse.stiffness[1 : (shape[0] + 1) // 2][::-1]
    unit = np.zeros(shape)
    unit[0, 0] = 1.0
    i, j = (np.arange(4) % n for n in shape)
    np.testing.assert_allclose(inverse.coefficients(3), inverse.apply(unit)[np.ix_(i, j)], atol=1e-13)


@pytest.mark.usefixtures("on_fields_and_on_lists")
def test_full_contact_takes_no_iteration():
    solution = rough(128).solve(pressure=3 * SLOPE * YOUNG)
    assert solution.contact.all()
    assert solution.iterations == 0
    assert solution.convolutions <= 5


@pytest.mark.usefixtures("on_fields_and_on_lists")
@pytest.mark.parametrize("control", ["pressure", "approach"])
def test_only_the_window_that_can_touch_is_solved(control):
    grid = rc.Grid((256, 256), 1e-3)
    ball = rc.ParaboloidSurface(1e-2, center=(2e-4, -1e-4))
    problem = rc.ContactProblem(rc.Body(ball, rc.Elastic(1e11, 0.3)), grid=grid, solver=STRICT)
    load = {"pressure": 1e6} if control == "pressure" else {"approach": 2e-7}
    solution = problem.solve(**load)
    assert max(np.prod(level.shape) for level in solution.levels) <= 64 * 64
    whole = attrs.evolve(problem, solver=strict("spectral-gradient")).solve(**load)
    np.testing.assert_allclose(solution.pressure, whole.pressure, atol=1e-6 * whole.pressure.max())
    assert solution.gap.min() > -1e-6 * solution.approach


def test_a_window_that_was_too_small_is_enlarged():
    ball = rc.ParaboloidSurface(1e-2)
    problem = rc.ContactProblem(rc.Body(ball, rc.Elastic(1e11, 0.3)), grid=rc.Grid((256, 256), 1e-3), solver=STRICT)
    task = make_task(problem.plan, problem.initial_gap, Load.of(pressure=1e8))
    sides = []

    def solve(convolution, inside):
        sides.append(inside.initial_gap.shape[0])
        return STRICT._solve_on_grid(convolution, inside)

    def estimate(convolution, task):
        return 0.05 * estimate_approach(convolution, task)[0], False

    found = solve_in_window(problem.convolution, task, solve, estimate)
    assert sides == sorted(sides)
    assert len(sides) >= 2
    assert sides[-1] < 256
    expected = problem.solve(pressure=1e8)
    pressure = found.outcome.pressure * (1e8 / task.mean_pressure)
    np.testing.assert_allclose(pressure, expected.pressure, atol=1e-6 * expected.pressure.max())
    assert found.approach * problem.plan.peak_to_valley == pytest.approx(expected.approach, rel=1e-6)


class CoefficientsOnly(rc.InfluenceKernel):
    """A kernel without a spectrum: stiffer than Love's far away, as a layer makes it."""

    def coefficients(self, shape, spacing, compliance):
        distance = np.hypot(np.arange(shape[0])[:, None] * spacing[0], np.arange(shape[1]) * spacing[1])
        return rc.Love().coefficients(shape, spacing, compliance) * (0.5 + 0.5 * np.exp(-distance / 20.0))


@pytest.mark.usefixtures("on_fields_and_on_lists")
@pytest.mark.parametrize("boundary", ["free", "wrapped"])
def test_each_kernel_has_its_own_preconditioner(boundary):
    problem = rough(128, boundary=boundary, kernel=CoefficientsOnly())
    solution = problem.solve(pressure=5e-3)
    assert solution.iterations <= 25
    other = attrs.evolve(problem, solver=strict("spectral-gradient")).solve(pressure=5e-3)
    np.testing.assert_allclose(solution.pressure, other.pressure, atol=1e-6 * other.pressure.max())


@pytest.mark.usefixtures("on_fields_and_on_lists")
@each_once(
    {
        "shape": [(101, 77), (251, 127), (2, 4096), (96, 100), (1, 300), (64, 33)],
        "boundary": ["free", "periodic"],
    }
)
def test_any_shape_of_grid(shape, boundary):
    heights = np.random.default_rng(0).standard_normal(shape)
    surface = rc.HeightMap(heights, size=(float(shape[0]), 1.5 * shape[1]))
    problem = rc.ContactProblem(rc.Body(surface, rc.Elastic(1.0, 0.0)), boundary=boundary)
    solution = problem.solve(pressure=0.05)
    assert solution.status.success
    assert solution.iterations <= 70


@pytest.mark.usefixtures("as_on_large_grids")
def test_a_start_skips_the_coarse_grids():
    problem = rough(128)
    cold = problem.solve(pressure=5e-3)
    warm = problem.solve(pressure=5.1e-3, start=cold.pressure)
    assert len(cold.levels) == 3
    assert len(warm.levels) == 1
    assert problem.solve(pressure=5e-3, start=cold.pressure).iterations <= 2


@pytest.mark.usefixtures("as_on_large_grids")
def test_a_start_near_full_contact_goes_on_by_the_openings():
    """The few openings are found by the inverse kernel; a descent for the pressure takes a convolution an iteration."""
    problem = rough(128)
    start = problem.solve(pressure=1.2 * SLOPE * YOUNG).pressure
    warm = problem.solve(pressure=1.15 * SLOPE * YOUNG, start=start)
    cold = problem.solve(pressure=1.15 * SLOPE * YOUNG)
    assert warm.contact.mean() > 0.9
    assert warm.levels[-1].single == 0
    assert warm.convolutions < cold.convolutions
    np.testing.assert_allclose(warm.pressure, cold.pressure, atol=1e-5 * cold.pressure.max())


@pytest.mark.usefixtures("on_fields_and_on_lists")
def test_a_start_beyond_full_contact_is_the_solution():
    problem = rough(64)
    full = problem.solve(pressure=6.0 * SLOPE * YOUNG)
    again = problem.solve(pressure=7.0 * SLOPE * YOUNG, start=full.pressure)
    assert again.contact.all()
    assert again.iterations == 0


@pytest.mark.usefixtures("as_on_large_grids")
def test_levels_and_steps_report_the_work():
    steps = []
    solution = rough(128).solve(pressure=5e-3, on_step=steps.append)
    assert [level.shape for level in solution.levels] == [(32, 32), (64, 64), (128, 128)]
    assert solution.levels[-1].iterations == solution.iterations == len(solution.errors) - 1
    assert solution.levels[-1].single >= solution.iterations
    assert {step.shape for step in steps} == {level.shape for level in solution.levels}
    assert steps[-1].error == solution.errors[-1] <= 1e-8


@pytest.mark.usefixtures("on_fields_and_on_lists")
@pytest.mark.parametrize("levels", [1, 2, 50])
@pytest.mark.parametrize("left", [1e-3, 2e-6, 1e-7])
def test_an_approach_next_to_full_contact_is_found_through_loads(left, levels, monkeypatch):
    """The load hardly changes the approach there; terraces and noise are the worst."""
    monkeypatch.setattr("roughcontact._solve.solvers.conjugate.solver._MAX_APPROACH_ITERATIONS", 5)
    heights = np.round(levels * np.random.default_rng(levels).standard_normal((50, 12)))
    surface = rc.HeightMap(heights, size=(50.0, 10.0), periodic=True)
    problem = rc.ContactProblem(rc.Body(surface, rc.Elastic(1.0, 0.0)), boundary="periodic", solver=STRICT)
    approach = (1.0 - left) * problem.initial_gap.mean()
    solution = problem.solve(approach=approach)
    assert solution.status is rc.Status.RESCUED
    assert solution.approach == pytest.approx(approach, rel=1e-15)
    by_load = problem.solve(pressure=solution.mean_pressure)
    assert by_load.approach == pytest.approx(approach, rel=1e-7)


@pytest.mark.parametrize(
    ("pressure", "boundary", "fields"), [(5e-3, "periodic", 13.5), (0.1, "periodic", 28), (5e-3, "free", 20)]
)
def test_memory(pressure, boundary, fields):
    """Peak beyond the input, in float32 arrays of the grid's size; the result itself counts two."""
    problem = rough(256, boundary=boundary)
    task = make_task(problem.plan, problem.initial_gap, Load("pressure", pressure))
    problem.plan.solver.solve(problem.convolution, task)
    tracemalloc.start()
    problem.plan.solver.solve(problem.convolution, task)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak <= fields * 4 * problem.plan.grid.cells


class TestSweep:
    @pytest.mark.usefixtures("on_fields_and_on_lists")
    @pytest.mark.parametrize("boundary", ["free", "periodic"])
    def test_is_monotone(self, boundary):
        sweep = rough(96, boundary=boundary).sweep(pressure=np.geomspace(1e-4, 0.05, 8))
        for column in (sweep.force, sweep.mean_pressure, sweep.approach, sweep.area, sweep.secant_stiffness):
            assert (np.diff(column) > 0).all()
        assert str(sweep).count("\n") == 8

    @pytest.mark.usefixtures("as_on_large_grids")
    def test_warm_starts_save_convolutions(self):
        problem = rough(96)
        approaches = np.linspace(0.3, 0.6, 6) * problem.initial_gap.mean()
        cold = sum(problem.solve(approach=a).convolutions for a in approaches)
        assert problem.sweep(approach=approaches).convolutions < 0.95 * cold

    @pytest.mark.slow
    @pytest.mark.usefixtures("on_fields_and_on_lists")
    @each_once(
        {
            "boundary": ["free", "periodic"],
            "hardness": [None, 0.3 * SLOPE * YOUNG],
        }
    )
    def test_agrees_with_solves_of_each_load(self, boundary, hardness):
        problem = rough(64, boundary=boundary, hardness=hardness, seed=3)
        highest = 0.2 if hardness is None else 0.25 * SLOPE
        loads = np.array([0.05, 1.0, 0.3, 0.31, 1.0, 0.02, 0.7]) * highest * YOUNG
        for load, solution in zip(loads, problem.sweep(pressure=loads).states, strict=True):
            cold = problem.solve(pressure=load)
            assert solution.mean_pressure == pytest.approx(load, rel=1e-12)
            assert solution.residuals.error <= 2e-8
            np.testing.assert_allclose(solution.pressure, cold.pressure, atol=1e-5 * cold.pressure.max())

    def test_the_order_of_the_loads_changes_no_bit(self):
        problem, loads = rough(64), np.geomspace(1e-4, 0.02, 6)
        order = [3, 0, 5, 1, 4, 2]
        one, other = problem.sweep(pressure=loads), problem.sweep(pressure=loads[order])
        for index, solution in zip(order, other.states, strict=True):
            np.testing.assert_array_equal(solution.pressure, one.states[index].pressure)

    @pytest.mark.slow
    @pytest.mark.parametrize(
        ("loads", "hardness"),
        [((0.003, 0.1), None), ((0.6, 1.3), None), ((0.003, 0.1), 0.3 * SLOPE * YOUNG)],
        ids=["light", "nearly full", "limited"],
    )
    def test_costs_less_than_its_loads(self, loads, hardness, as_on_large_grids):
        problem = rough(128, hardness=hardness, seed=7)
        loads = np.linspace(*loads, 10) * SLOPE * YOUNG
        cold = sum(problem.solve(pressure=load).convolutions for load in loads)
        assert problem.sweep(pressure=loads).convolutions < 0.93 * cold

    def test_stiffness_of_a_sphere(self):
        """Hertz: dF/d(approach) = 2 E* a."""
        body = rc.Body(rc.ParaboloidSurface(1e-2), rc.Elastic(1e11, 0.0))
        problem = rc.ContactProblem(body, grid=rc.Grid((128, 128), 1e-3))
        sweep = problem.sweep(force=np.linspace(9.0, 11.0, 5))
        radius = (0.75 * 10.0 * 1e-2 / 1e11) ** (1 / 3)
        assert sweep.secant_stiffness[2] == pytest.approx(2e11 * radius, rel=0.01)

    @pytest.mark.parametrize("fraction", [0.02, 0.1, 0.5, 0.9])
    def test_a_target_area_is_found(self, fraction):
        area = rough(96).solve_area(fraction).area()
        # On a coarse grid the area jumps from cell to cell.
        off = abs(area.fraction - fraction)
        assert off <= 2e-3 * fraction or off * area.value / area.fraction <= area.uncertainty

    @pytest.mark.parametrize(
        ("call", "words"),
        [
            (lambda p: p.sweep(), "exactly one list"),
            (lambda p: p.sweep(pressure=[]), "is empty"),
            (lambda p: p.sweep(pressure=[1e-3], force=[1.0]), "exactly one list"),
            (lambda p: p.sweep(pressure=[1e-3, -1.0]), "above 0"),
            (lambda p: p.solve_area(0.0), "above 0"),
            (lambda p: p.solve_area(1.0), "below 1"),
            (lambda p: p.solve_area(1e-6, "cell-count"), "No load gives an area"),
        ],
    )
    def test_bad_input_gets_a_sentence(self, call, words):
        with pytest.raises(rc.InputError, match=words):
            call(rough(64))


@pytest.mark.slow
@settings(max_examples=1000, suppress_health_check=list(HealthCheck))
@given(problems())
def test_a_thousand_random_loads(case):
    problem, mean = case
    solution = problem.solve(pressure=mean, throw=False)
    assert solution.status.success
    found = violations(problem, {"pressure": mean}, solution)
    assert found.holds, found


@pytest.mark.slow
@settings(max_examples=1000, suppress_health_check=list(HealthCheck))
@given(height_maps(), moduli, st.sampled_from(["free", "periodic", "wrapped"]), st.floats(1e-3, 0.999))
def test_a_thousand_random_approaches(surface, young, boundary, fraction):
    problem = rc.ContactProblem(rc.Body(surface, rc.Elastic(young, 0.3)), boundary=boundary)
    reach = problem.initial_gap.mean() if boundary == "periodic" else problem.initial_gap.max()
    solution = problem.solve(approach=fraction * reach, throw=False)
    assert solution.status.success
    found = violations(problem, {"approach": fraction * reach}, solution)
    assert found.holds, found


@pytest.mark.usefixtures("on_fields_and_on_lists")
@pytest.mark.parametrize(
    ("shape", "size", "seed"),
    [((16, 31), (1e-5, 5e-5), 2), ((16, 31), (1e-5, 5e-5), 36), ((8, 16), (1e-5, 8e-5), 25), ((36, 16), 1e-5, 29)],
)
def test_a_start_far_from_the_solution_does_not_keep_it_from_being_found(shape, size, seed):
    """A hundred million times the typical pressure, most of it on a few cells."""
    rng = np.random.default_rng(seed)
    surface = rc.HeightMap(1e-7 * rng.standard_normal(shape), np.broadcast_to(size, 2).tolist(), periodic=True)
    problem = rc.ContactProblem(rc.Body(surface, rc.Elastic(2e11, 0.3)), boundary="periodic")
    approach, start = 0.2 * problem.initial_gap.mean(), 1e8 * 0.1 * problem.plan.modulus * rng.random(shape) ** 8
    found, plain = problem.solve(approach=approach, start=start), problem.solve(approach=approach)
    assert found.status.success
    assert found.mean_pressure == pytest.approx(plain.mean_pressure, rel=1e-4)
    np.testing.assert_allclose(found.pressure, plain.pressure, atol=1e-4 * plain.pressure.max())
    # Its work is that of both.
    assert found.iterations > plain.iterations
    assert len(found.errors) >= found.iterations


@pytest.mark.usefixtures("on_fields_and_on_lists")
@pytest.mark.parametrize("seed", rather_slow([7, 48], [7]))
def test_an_approach_on_cells_500_times_as_long_as_wide_is_found(seed):
    heights = 1e-7 * np.random.default_rng(seed).standard_normal((8, 32))
    surface = rc.HeightMap(heights, (8e-6, 1.6e-2), periodic=True)
    problem = rc.ContactProblem(rc.Body(surface, rc.Elastic(2e11, 0.3)), boundary="periodic")
    approach = 0.63 * problem.initial_gap.mean()
    solution = problem.solve(approach=approach)
    assert solution.status is rc.Status.RESCUED
    assert solution.approach == pytest.approx(approach, rel=1e-12)
    other = attrs.evolve(problem, solver=rc.SpectralGradient(max_iterations=20_000)).solve(approach=approach)
    np.testing.assert_allclose(solution.pressure, other.pressure, atol=1e-3 * other.pressure.max())
