"""Steps of the solvers beside closed forms and dense algebra, on several tiles, odd and oblong grids."""

from __future__ import annotations

import math
from functools import partial

import attrs
import numpy as np
import pytest

import roughcontact as rc
from roughcontact._base import machine
from roughcontact._solve.convolvers import transforms
from roughcontact._solve.convolvers.transforms import multiply_waves
from roughcontact._solve.problem.task import pressure_unit
from roughcontact._solve.solvers.conjugate import solver as conjugate
from roughcontact._solve.solvers.conjugate.descent import Descent
from roughcontact._solve.solvers.conjugate.nested_iteration import _extent, find_window
from roughcontact._solve.solvers.conjugate.preconditioner import (
    CoarseCorrection,
    RigidCorrection,
    _BlockAverage,
    _gather_blocks,
    _spread_blocks,
    divide,
    half_space_inverse,
    multiply_active,
)
from roughcontact._solve.solvers.driver import Work
from roughcontact._solve.solvers.grids import _average, coarsen, interpolate
from roughcontact._solve.solvers.passes import ListedCells, MaskedCells, active_cells
from roughcontact._solve.solvers.projection import ApproachControl, LoadControl
from roughcontact._solve.solvers.spectral_gradient import _energy, _first_length
from roughcontact.solving import count_blocks, estimate_approach, make_task, project_to_load, rescale_to_load
from roughcontact.typing import InverseConvolution, Load, Task
from scenes import make_problem

FLAT = np.array([math.inf])


def problem(shape=(24, 20), size=(24.0, 30.0), boundary="periodic", surface=None, hardness=None, solver="auto"):
    material = rc.Elastic(1.0, 0.0) if hardness is None else rc.ElasticPerfectlyPlastic(1.0, 0.0, hardness)
    surface = rc.ParaboloidSurface(100.0) if surface is None else surface
    return make_problem(surface, material, grid=rc.Grid(shape, size), boundary=boundary, solver=solver, threads=1)


@pytest.mark.parametrize("share", [0.1, 0.7])
def test_vectors_on_the_active_cells_are_the_fields_there(share):
    """On three tiles, as lists of few cells and as fields of many."""
    n = 2 * 2**16 + 100
    field = np.random.default_rng(1).random(n).astype(np.float32)
    active = active_cells(field, lambda tile: field[tile] < share)
    mask = field < share
    assert isinstance(active, ListedCells if share < 0.4 else MaskedCells)
    assert active.count == mask.sum()
    np.testing.assert_array_equal(active.mask, mask)
    values = np.arange(n, dtype=np.float64)
    vector = active.gather(values)
    np.testing.assert_array_equal(active.scatter(vector), np.where(mask, values, 0.0))
    stored = -values
    active.store(stored, vector)
    np.testing.assert_array_equal(stored, np.where(mask, values, -values))
    np.testing.assert_array_equal(active.scatter(active.ones), mask)
    assert active.limits(FLAT) is FLAT
    np.testing.assert_array_equal(
        active.scatter(active.gather(field) * (active.limits(values) > 50)), field * mask * (values > 50)
    )


@pytest.mark.parametrize("factors", [(2, 2), (2, 1), (1, 2)])
@pytest.mark.parametrize("shape", [(13, 10), (4, 33)])
def test_fields_are_interpolated_by_tiles_as_whole(shape, factors, monkeypatch):
    values = np.random.default_rng(6).normal(size=shape)
    whole = interpolate(values, *factors)
    monkeypatch.setattr(machine, "_VALUES_PER_TILE", 3 * shape[1])
    np.testing.assert_array_equal(interpolate(values, *factors), whole)


@pytest.mark.parametrize("share", [0.02, 0.2, 0.7])
def test_rows_with_an_active_cell(share):
    rng = np.random.default_rng(2)
    marked = rng.random(60 * 9) < share * 0.5
    marked[0:9] = False
    active = active_cells(marked.astype(np.float32), lambda tile: marked[tile])
    rows = active.few_rows(9)
    filled = np.flatnonzero(marked.reshape(60, 9).any(axis=1))
    if share == 0.02:
        np.testing.assert_array_equal(rows, filled)
    else:
        assert rows is None


@pytest.mark.parametrize("share", [0.2, 0.8])
@pytest.mark.parametrize(("shape", "padded", "blocks"), [((13, 18), (13, 18), (3, 5)), ((12, 9), (16, 27), (4, 6))])
def test_sums_over_blocks_and_their_spread(shape, padded, blocks, share):
    rng = np.random.default_rng(3)
    marked = rng.random(shape[0] * shape[1]) < share
    active = active_cells(marked.astype(np.float32), lambda tile: marked[tile])
    partition = divide(shape, padded, blocks)
    i, j = np.indices(shape)
    number = (i * blocks[0] // padded[0]) * blocks[1] + j * blocks[1] // padded[1]
    values = rng.normal(size=shape[0] * shape[1])
    sums = active.blocks(partition).sums(active.gather(values))
    expected = np.bincount(number.ravel(), weights=values * marked, minlength=blocks[0] * blocks[1])
    np.testing.assert_allclose(sums, expected.reshape(blocks), atol=1e-12)
    amounts = rng.normal(size=blocks)
    spread = active.scatter(active.ones * active.blocks(partition).spread(amounts))
    np.testing.assert_allclose(spread, amounts.ravel()[number.ravel()] * marked)


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("shape", [(6, 10), (8, 2)])
def test_blocks_are_interpolated_linearly_and_gathered_by_half_the_transpose(axis, shape):
    rng = np.random.default_rng(4)
    coarse = rng.normal(size=shape).astype(np.float32)
    fine = rng.normal(size=[n * (1 + (k == axis)) for k, n in enumerate(shape)]).astype(np.float32)
    spread = _spread_blocks(coarse, axis)
    n = shape[axis]
    place = (np.arange(2 * n) - 0.5) / 2.0
    before = np.floor(place).astype(int)
    part = (place - before).reshape(-1, *([1] * (1 - axis)))
    low, high = np.take(coarse, before % n, axis), np.take(coarse, (before + 1) % n, axis)
    np.testing.assert_allclose(spread, (1.0 - part) * low + part * high, rtol=1e-5, atol=1e-6)
    one, other = np.vdot(spread, fine), np.vdot(coarse, _gather_blocks(fine, axis))
    assert one == pytest.approx(2.0 * other, rel=1e-5)
    np.testing.assert_allclose(_gather_blocks(np.ones_like(fine), axis), 1.0)


def test_the_average_of_blocks_keeps_a_uniform_field_and_falls_for_short_waves():
    inverse = problem((30, 44)).convolution.inverse(np.float32)
    average = _BlockAverage.of(inverse)
    assert average.blocks == (15, 22)
    np.testing.assert_allclose(average.apply(np.ones((30, 44), dtype=np.float32)), 1.0, rtol=1e-5)
    for turns in (1, 3):
        wave = np.cos(2.0 * np.pi * turns * (np.arange(22) + 0.5) / 22) * np.ones((15, 1))
        symbol = (1.0 + (2.0 * np.pi * 0.7 * turns / 22) ** 2) ** -1.5
        field = _spread_blocks(_spread_blocks(wave.astype(np.float32), 1), 0)
        found = _gather_blocks(_gather_blocks(average.apply(field), 0), 1)
        back = _gather_blocks(_gather_blocks(field, 0), 1)
        again = _gather_blocks(_gather_blocks(_spread_blocks(_spread_blocks(back, 1), 0), 0), 1)
        np.testing.assert_allclose(found, symbol * again, atol=1e-5)


@pytest.mark.parametrize("shape", [(20, 33), (27, 16)])
def test_the_inverse_of_a_half_space_is_as_stiff_as_the_wave_number(shape):
    prepared = problem(shape).convolution
    inverse, spacing = prepared.inverse(np.float32), prepared.setup.grid.spacing
    found = half_space_inverse(inverse, spacing)
    mx, my = inverse.padded
    qx, qy = np.fft.fftfreq(mx, spacing[0])[:, np.newaxis], np.fft.rfftfreq(my, spacing[1])
    ratio = found.stiffness[1:, 1:] / np.hypot(qx, qy)[1:, 1:]
    np.testing.assert_allclose(ratio, ratio[0, 0], rtol=1e-5)
    assert found.stiffness[0, 1] == pytest.approx(inverse.stiffness[0, 1])
    assert found.stiffness[0, 0] == 0.0
    assert not found.exact


@pytest.mark.parametrize("large", [False, True])
@pytest.mark.parametrize("shape", [(12, 15), (9, 20)])
def test_waves_are_multiplied_by_their_symbol(shape, large, monkeypatch):
    """By columns and in three passes, on padded grids, and for a field in few rows."""
    monkeypatch.setattr(transforms, "_MIN_COLUMNWISE_WAVES", 1 if large else 10**9)
    rng, padded = np.random.default_rng(5), (20, 27)
    values = np.zeros(shape)
    values[[2, 7]] = rng.normal(size=(2, shape[1]))
    symbol = rng.random((20, 14))
    symbol[1:] = 0.5 * (symbol[1:] + symbol[:0:-1])
    field = np.zeros(padded)
    field[: shape[0], : shape[1]] = values
    expected = np.fft.irfft2(np.fft.rfft2(field) * symbol, padded)[: shape[0], : shape[1]]
    np.testing.assert_allclose(multiply_waves(values, symbol, padded), expected, atol=1e-12)
    inverse = InverseConvolution(symbol, padded)
    np.testing.assert_allclose(inverse.apply(values), expected, atol=1e-12)
    found = inverse.multiply(values, symbol, padded, np.array([2, 7]))
    np.testing.assert_allclose(found[[2, 7]], expected[[2, 7]], atol=1e-12)
    marked = (values != 0.0).ravel()
    active = active_cells(marked.astype(np.float32), lambda tile: marked[tile])
    vector = multiply_active(active, active.gather(values.ravel()), inverse, symbol, shape)
    np.testing.assert_allclose(active.scatter(vector), np.where(marked, expected.ravel(), 0.0), atol=1e-12)


@pytest.mark.parametrize("boundary", ["periodic", "free"])
@pytest.mark.parametrize("share", [0.15, 0.6])
def test_rigid_motion_is_solved_exactly(boundary, share):
    """A gap that two pressures cause, the weights and a uniform one, is answered by these pressures."""
    prepared = problem(boundary=boundary).convolution
    shape = prepared.setup.grid.shape
    rng = np.random.default_rng(6)
    marked = rng.random(shape[0] * shape[1]) < share
    active = active_cells(marked.astype(np.float32), lambda tile: marked[tile])
    weights = active.gather(rng.uniform(0.5, 2.0, marked.size))
    correction = RigidCorrection(prepared, active, weights)
    pressure = 2.0 * weights - 0.7 * active.ones
    residual = active.gather(prepared.apply(active.scatter(pressure).reshape(shape)).ravel())
    found = correction.apply(active, np.zeros_like(residual), residual, weights)
    np.testing.assert_allclose(found, pressure, rtol=1e-4, atol=1e-4)
    image = active.gather(rng.normal(size=marked.size))
    other = correction.apply(active, image, residual, weights)
    np.testing.assert_allclose(other - pressure, image - image.sum() / weights.sum() * weights, atol=1e-4)


def test_the_coarse_correction_solves_its_system_on_the_blocks():
    """Woodbury: (Q + diag w) on the blocks, dense; the few steps leave some per cent."""
    prepared = problem((64, 96), (64.0, 96.0)).convolution
    inverse = prepared.inverse(np.float32)
    i, j = np.indices((64, 96))
    marked = (np.hypot(i % 16 - 8, j % 16 - 8) < 4).ravel()
    active = active_cells(marked.astype(np.float32), lambda tile: marked[tile])
    weights = active.gather(inverse.apply(marked.astype(np.float32).reshape(64, 96)).ravel())
    correction = CoarseCorrection(inverse, (64, 96), active, weights)
    diagonal = active.blocks(divide((64, 96), inverse.padded, correction._diagonal.shape)).sums(weights)
    np.testing.assert_allclose(correction._diagonal, diagonal, rtol=1e-5)
    far = 1.0 / correction._approximate - correction._mean
    assert far[0, 0] == pytest.approx(0.0, abs=1e-5 * float(correction._mean))
    residual = active.gather(np.random.default_rng(7).normal(size=marked.size).astype(np.float32))
    right = active.blocks(divide((64, 96), inverse.padded, diagonal.shape)).sums(weights * residual)
    solution = correction._solve(right.astype(np.float32))
    image = np.fft.irfft2(np.fft.rfft2(solution) * far, right.shape) + diagonal * solution
    assert np.linalg.norm(image - right) < 0.1 * np.linalg.norm(right)
    spread = active.blocks(divide((64, 96), inverse.padded, diagonal.shape)).spread(solution)
    np.testing.assert_allclose(correction.apply(weights, residual), weights * spread, rtol=1e-4, atol=1e-5)


def test_blocks_resolve_the_long_waves():
    """The stiffness is the wave's number: blocks of so many cells hold the waves up to 1.5 times 3 means."""
    stiffness = np.arange(257.0)
    for mean in (0.5, 2.0, 8.0):
        blocks = count_blocks(stiffness, 512, mean)
        assert blocks >= min(4.5 * mean, 8)
        assert 512 / blocks <= 64
        if blocks > 8:
            assert stiffness[blocks // 4] < 4.5 * mean
    assert count_blocks(np.arange(6.0), 10, 1e-9) == 10
    assert count_blocks(np.arange(21.0), 40, 1e-9) == 10


class Diagonal:
    """Cells on springs of their own, without a preconditioner."""

    def __init__(self, compliance):
        self.compliance = compliance

    def apply(self, *arguments):
        if len(arguments) == 1:
            return arguments[0] * self.compliance.reshape(arguments[0].shape)
        return arguments[2].copy()

    def weights(self, active):
        return active.ones

    def levels(self, *_):
        return None


@pytest.mark.parametrize("kinds", [1, 2, 3])
def test_conjugate_gradients_end_after_as_many_steps_as_there_are_stiffnesses(kinds):
    """Where no bound is met: three kinds of springs take three steps, one more for the guessed length of the first."""
    shape = (2, 2**16 + 5)
    rng = np.random.default_rng(8)
    compliance = np.array([1.0, 1.4, 0.8])[rng.integers(kinds, size=shape[0] * shape[1])].astype(np.float32)
    height = rng.uniform(-1.1, -0.9, compliance.size)
    springs, work = Diagonal(compliance), Work()
    descent = Descent(partial(work.invert, springs), shape, springs, ApproachControl(), FLAT)
    pressure = np.full(compliance.size, 1.0)
    descent.start(pressure, (height + compliance * pressure).astype(np.float32))
    first = descent.find_error()
    for _ in range(kinds):
        assert descent.iterate()
    assert descent.find_error() < 1e-5 * first
    assert work.inverse == kinds
    np.testing.assert_allclose(descent.pressure, -height / compliance, rtol=1e-5)
    np.testing.assert_allclose(descent.stop(), 0.0, atol=1e-5)


@pytest.mark.parametrize("control", ["approach", "load"])
@pytest.mark.parametrize("limit", [math.inf, 0.9])
def test_the_energy_falls_with_every_step_and_the_pressure_stays_within_its_bounds(control, limit):
    """Any symmetric compliance above zero, dense, without a preconditioner, from a bad start."""
    shape = (6, 7)
    rng = np.random.default_rng(9)
    root = rng.normal(size=(42, 42))
    compliance = root @ root.T / 42 + 0.3 * np.eye(42)
    height = rng.normal(size=42)

    class Dense(Diagonal):
        def apply(self, *arguments):
            if len(arguments) == 1:
                return (compliance @ arguments[0].ravel()).reshape(shape).astype(arguments[0].dtype)
            return arguments[2].copy()

    springs = Dense(None)
    start = rng.uniform(0.0, 0.9, 42) * (rng.random(42) < 0.6)
    given = ApproachControl() if control == "approach" else LoadControl(float(start.sum()))
    descent = Descent(springs.apply, shape, springs, given, np.array([limit]))
    descent.start(start.copy(), (height + compliance @ start).astype(np.float32))
    energies, load = [], float(start.sum())
    for _ in range(300):
        pressure = descent.pressure
        assert pressure.min() >= 0.0
        assert pressure.max() <= limit
        if control == "load":
            assert pressure.sum() == pytest.approx(load, rel=1e-4)
        energies.append(0.5 * pressure @ compliance @ pressure + height @ pressure)
        if not descent.iterate() or descent.find_error() < 1e-6:
            break
    assert all(np.diff(energies) < 1e-6)
    assert len(energies) < 120
    gap = height + compliance @ descent.pressure
    level = 0.0 if control == "approach" else np.median(gap[(descent.pressure > 0.0) & (descent.pressure < limit)])
    elastic = (descent.pressure > 1e-6) & (descent.pressure < limit - 1e-6)
    np.testing.assert_allclose(gap[elastic], level, atol=1e-3)
    assert gap[descent.pressure < limit - 1e-6].min() > level - 1e-3
    assert gap[descent.pressure > 1e-6].max() < level + 1e-3
    assert descent.met_limit == (limit < math.inf)


@pytest.mark.parametrize(("factors", "shape"), [((2, 1), (14, 9)), ((1, 2), (9, 14)), ((2, 2), (300, 260))])
def test_values_between_coarse_cells_are_those_of_parabolas(factors, shape):
    """Beside the border parabolas across it; above 2^16 cells on several tiles."""
    coarse = [np.arange(n) - 0.3 * n for n in shape]
    fine = [(np.arange(f * n) + 0.5) / f - 0.5 - 0.3 * n for f, n in zip(factors, shape, strict=True)]

    def parabola(i, j):
        return 1.0 + 0.3 * i[:, np.newaxis] - 0.2 * i[:, np.newaxis] ** 2 + 0.1 * j + 0.05 * j**2

    found = interpolate(parabola(*coarse), *factors)
    expected = parabola(*fine)
    inner = tuple(slice(2, -2) for _ in range(2))
    np.testing.assert_allclose(found[inner], expected[inner], rtol=1e-9, atol=1e-9)
    moved = interpolate(np.roll(parabola(*coarse), (3, 5), (0, 1)), *factors)
    np.testing.assert_allclose(moved, np.roll(found, (3 * factors[0], 5 * factors[1]), (0, 1)), rtol=1e-12)


@pytest.mark.usefixtures("as_on_large_grids")
def test_coarse_cells_have_the_mean_of_their_fine_cells():
    rng = np.random.default_rng(10)
    values = rng.normal(size=(128, 66))
    for shape in ((64, 66), (128, 33), (64, 33)):
        blocks = values.reshape(shape[0], 128 // shape[0], shape[1], 66 // shape[1])
        np.testing.assert_allclose(_average(values, shape), blocks.mean(axis=(1, 3)))
    task = Task(initial_gap=values - values.min(), pressure_limit=np.array(math.inf), mean_pressure=0.1, approach=None)
    half, coarse = coarsen(rc.Grid((128, 66), (2.0, 3.0)), task)
    assert half == rc.Grid((64, 33), (2.0, 3.0))
    assert coarse.initial_gap.shape == (64, 33)
    assert coarse.mean_pressure == 0.1
    assert coarsen(rc.Grid((62, 33), 1.0), attrs.evolve(task, initial_gap=np.zeros((62, 33)))) is None
    assert coarsen(rc.Grid((64, 33), 1.0), attrs.evolve(task, initial_gap=np.zeros((64, 33))))[0].shape == (32, 33)


@pytest.mark.parametrize(
    ("marked", "count"), [((3, 5), 400), ((0, 1), 64), ((380, 399), 400), ((100, 171), 400), ((5, 35), 40)]
)
def test_a_window_holds_its_cells_in_multiples_of_32_around_their_middle(marked, count):
    found = _extent(np.array(marked), count)
    length = found.stop - found.start
    assert 0 <= found.start <= marked[0]
    assert marked[1] < found.stop <= count
    assert length % 32 == 0 or length == count
    assert length <= min(marked[1] - marked[0] + 3 + 31, count)
    if found.start > 0 and found.stop < count:
        # One cell at least on both sides, and not more on one than on the other.
        before, behind = marked[0] - found.start, found.stop - 1 - marked[1]
        assert min(before, behind) >= 1
        assert abs(before - behind) <= 1


def test_the_window_of_a_ball_holds_its_overlap():
    """Within the approach 1.02 a^2 / R the ball lies deeper than the plane; elsewhere nothing can touch."""
    ball = problem((256, 160), (256.0, 320.0), "free")
    force = 4.0 / 3.0 * 30.0**3 / 100.0
    task = _task(ball, force)
    scale = ball.plan.peak_to_valley
    approach, _ = estimate_approach(ball.convolution, task)
    assert approach * scale == pytest.approx(30.0**2 / 100.0, rel=0.03)
    window = find_window(ball.convolution, task, approach)
    touching = ball.initial_gap <= 30.0**2 / 100.0
    outside = touching.copy()
    outside[window.rows, window.columns] = False
    assert not outside.any()
    assert window.contains_contact(task.initial_gap, approach)
    assert not window.contains_contact(task.initial_gap, 1e3 * approach)
    inside = window.task(task)
    assert inside.mean_pressure * inside.initial_gap.size == pytest.approx(task.mean_pressure * task.initial_gap.size)
    spacing = window.convolution(ball.convolution).setup.grid.spacing
    assert spacing == pytest.approx(ball.plan.grid.spacing)
    field = np.arange(256.0 * 160).reshape(256, 160)
    embedded = window.embed(window.restrict(field), field.shape)
    assert np.count_nonzero(embedded) <= inside.initial_gap.size
    np.testing.assert_array_equal(embedded[window.rows, window.columns], field[window.rows, window.columns])
    assert find_window(problem((64, 64), 64.0).convolution, task, approach) is None
    assert find_window(ball.convolution, task, 1e3 * approach) is None


def _task(given, force):
    return make_task(given.plan, given.initial_gap, Load("force", force))


@pytest.mark.parametrize("sides", [(1.0, 1.0), (1.0, 2.0)])
def test_full_contact_of_a_wave_takes_half_of_its_stiffness_times_its_amplitude(sides):
    """p = E* q A / 2 for heights A cos q x: at that load, and the approach A of the mean gap."""
    shape = (32, 48)
    x = (np.arange(32) + 0.5) / 32
    heights = np.broadcast_to(0.05 * np.cos(2.0 * np.pi * x)[:, np.newaxis], shape)
    surface = rc.HeightMap(heights.copy(), size=sides, periodic=True)
    given = problem(shape, sides, "periodic", surface)
    task = attrs.evolve(_task(given, 1.0), approach=0.5, mean_pressure=None)
    closing, end = conjugate._final_load(given.convolution, task, beyond=False)
    expected = 0.5 * (2.0 * np.pi / sides[0]) * 0.05
    assert closing * pressure_unit(given.plan) == pytest.approx(expected, rel=0.01)
    assert end * given.plan.peak_to_valley == pytest.approx(0.5 * (0.1 * math.cos(np.pi / 32)), rel=1e-6)
    assert end == pytest.approx(0.5)


def test_loads_are_searched_next_to_full_contact_only():
    given = problem((32, 32), (32.0, 32.0), "periodic", rc.WavySurface(0.5, 32.0))
    task = _task(given, 1.0)
    full = float(task.initial_gap.mean())
    control = attrs.evolve(task, mean_pressure=None)
    cases = {0.4: False, 0.6: True, 0.999: True, 1.1: False}
    for fraction, expected in cases.items():
        assert (
            conjugate._can_search_loads(given.convolution, attrs.evolve(control, approach=fraction * full)) == expected
        )
    assert not conjugate._can_search_loads(given.convolution, task)
    limited = attrs.evolve(control, approach=1.1 * full, pressure_limit=np.array(1.0))
    assert conjugate._can_search_loads(given.convolution, limited)
    free = problem((32, 32), (32.0, 32.0), "free", rc.WavySurface(0.5, 32.0))
    assert not conjugate._can_search_loads(free.convolution, attrs.evolve(control, approach=0.6 * full))


@pytest.mark.parametrize("boundary", ["free", "wrapped"])
def test_the_first_step_and_the_energy_of_spectral_gradients(boundary):
    """The first step goes to the minimum of the energy along the gradient less its mean."""
    prepared = problem(boundary=boundary).convolution
    rng = np.random.default_rng(11)
    pressure, height = rng.random((2, *prepared.setup.grid.shape))
    displacement = prepared.apply(pressure)
    gradient = displacement + height
    length = _first_length(gradient, prepared)
    direction = gradient - gradient.mean()

    def energy(values):
        moved = prepared.apply(values)
        return _energy(values, moved, moved + height, prepared)

    def exact(values):
        return 0.5 * np.sum(values * prepared.apply(values)) + np.sum(values * height)

    assert energy(pressure) == pytest.approx(exact(pressure), rel=1e-9)
    steps = [exact(pressure - part * length * direction) for part in (0.9, 1.0, 1.1)]
    assert steps[1] < min(steps[0], steps[2])
    assert steps[0] == pytest.approx(steps[2], rel=1e-9)


@pytest.mark.parametrize("limit", [math.inf, 0.7])
def test_the_projection_to_a_mean_is_the_nearest_pressure(limit):
    """By bisection of the shift; one limit for all cells and one for each."""
    rng = np.random.default_rng(12)
    values = rng.normal(size=(20, 33))
    mean = 0.3
    for bound in (limit, np.full(values.shape, limit) * rng.uniform(0.9, 1.1, values.shape)):
        low, high = -50.0, 50.0
        for _ in range(200):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if np.clip(values - middle, 0.0, bound).mean() > mean else (low, middle)
        found = project_to_load(values, mean, bound)
        np.testing.assert_allclose(found, np.clip(values - low, 0.0, bound), atol=1e-12)
        assert found.mean() == pytest.approx(mean, rel=1e-14)


@pytest.mark.parametrize("level", [-1e9, -30.0, 30.0, 1e9])
@pytest.mark.parametrize("limit", [math.inf, 0.7])
def test_pressures_far_beyond_their_bounds_are_shifted_to_the_load(level, limit):
    """By the whole distance, however small the load is beside it."""
    values = level + np.random.default_rng(13).integers(0, 8, size=(20, 33)) / 64.0
    found = project_to_load(values, 1e-3, limit)
    assert found.mean() == pytest.approx(1e-3, rel=1e-9 if abs(level) < 1e6 else 1e-3)
    np.testing.assert_allclose(found, np.clip(values - (values.max() - found.max()), 0.0, limit), atol=1e-6)


def test_rescaling_moves_the_elastic_cells_alone():
    pressure = np.array([0.0, 0.5, 1.0, 0.25])
    np.testing.assert_allclose(rescale_to_load(pressure.copy(), 1.9, 1.0), [0.0, 0.6, 1.0, 0.3])
    np.testing.assert_allclose(rescale_to_load(pressure.copy(), 1.3, 1.0), [0.0, 0.2, 1.0, 0.1])
    # Nothing elastic is left: the load is reached by a shift of the cells in contact.
    np.testing.assert_allclose(rescale_to_load(np.array([0.0, 1.0, 1.0]), 1.5, 1.0), [0.0, 0.75, 0.75])
    np.testing.assert_allclose(rescale_to_load(np.array([0.0, 1.0, 1.0]), 2.5, 1.0), [0.5, 1.0, 1.0])


@pytest.mark.usefixtures("on_fields_and_on_lists")
@pytest.mark.parametrize("solver", ["auto", "polonsky-keer", "spectral-gradient"])
def test_the_cost_of_a_ball_by_each_solver(solver):
    """Hertz's pressure; and no more convolutions than a method of its kind needs."""
    given = problem((64, 40), (64.0, 60.0), "free", solver=solver)
    solution = given.solve(force=4.0 / 3.0 * 15.0**3 / 100.0)
    assert solution.status is rc.Status.CONVERGED
    assert solution.convolutions <= {"auto": 40, "polonsky-keer": 60, "spectral-gradient": 120}[solver]
    assert solution.approach == pytest.approx(2.25, rel=5e-3)
    inside = np.hypot(given.plan.grid.x, given.plan.grid.y) < 13.0
    hertz = 2.0 * 15.0 / (np.pi * 100.0) * np.sqrt(1.0 - (given.plan.grid.x**2 + given.plan.grid.y**2)[inside] / 225.0)
    np.testing.assert_allclose(solution.pressure[inside], hertz, rtol=0.02)
