"""The descent on whole fields of small grids: its passes beside their definitions, and its solutions beside lists'."""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import roughcontact as rc
from roughcontact._solve.solution import ContactConditions
from roughcontact._solve.solvers.conjugate.descent import Descent
from roughcontact._solve.solvers.conjugate.field_descent import FieldDescent, NumpyPasses
from roughcontact._solve.solvers.conjugate.preconditioner import ExtendedInverse, is_steep
from roughcontact._solve.solvers.driver import Work
from roughcontact.typing import LastStep
from scenes import act_as_on_large_grids, make_problem
from strategies import STRICT
from test_conjugate import SLOPE, YOUNG, rough


@attrs.frozen(eq=False)
class Fields:
    """A pressure within its bounds, and what the passes take with it."""

    pressure: np.ndarray
    gap: np.ndarray
    limit: np.ndarray | None
    load: float | None
    rng: np.random.Generator

    @property
    def bound(self):
        return np.full(self.pressure.shape, np.inf) if self.limit is None else self.limit * np.ones_like(self.pressure)

    @property
    def inside(self):
        return (self.pressure > 0.0) & (self.pressure < self.bound)

    @property
    def saturated(self):
        return self.pressure >= self.bound

    @property
    def passes(self):
        return NumpyPasses(self.limit, self.load)

    def noise(self, cells=True):
        """Noise in float32, zero on other cells."""
        return (self.rng.normal(size=self.pressure.size) * cells).astype(np.float32)


@st.composite
def fields(draw):
    """Pressures any part of which is zero or at a limit: there is none, one, one for each cell, or an infinite one."""
    rng = np.random.default_rng(draw(st.integers(0, 9999)))
    cells = draw(st.integers(2, 400))
    kind = draw(st.sampled_from(["none", "one", "each", "infinite in places"]))
    each = rng.uniform(0.5, 2.0, cells)
    if kind == "infinite in places":
        each[rng.random(cells) < 0.5] = np.inf
    limit = {"none": None, "one": np.array([0.8])}.get(kind, each)
    bound = np.full(cells, np.inf) if limit is None else limit * np.ones(cells)
    pressure = np.minimum(rng.uniform(0.0, 1.0, cells), bound)
    pressure[rng.random(cells) < draw(st.sampled_from([0.0, 0.5, 0.9, 1.0]))] = 0.0
    at_limit = (rng.random(cells) < draw(st.sampled_from([0.0, 0.3, 1.0]))) & np.isfinite(bound)
    pressure[at_limit] = bound[at_limit]
    gap = rng.normal(scale=0.3, size=cells).astype(np.float32)
    load = float(pressure.sum()) if draw(st.booleans()) else None
    return Fields(pressure, gap, limit, load, rng)


many = settings(max_examples=200)


@many
@given(fields())
def test_the_error_is_that_of_the_conditions_of_contact(case):
    assume(case.load is None or case.inside.any())
    height = case.rng.normal(size=case.gap.size)
    conditions = ContactConditions(height, case.bound, None if case.load is not None else 0.0)
    expected = conditions.measure(case.pressure, case.gap - height)
    level, error = case.passes.measure(case.pressure, case.gap)
    assert level == pytest.approx(expected.approach, rel=1e-5, abs=1e-6)
    found = max(expected.complementarity, expected.penetration) * expected.scale
    assert error == pytest.approx(found, rel=1e-5, abs=1e-6)


@many
@given(fields())
def test_active_are_cells_inside_and_those_whose_gap_draws_them_from_their_bound(case):
    residual, active, count = case.passes.release(case.pressure, case.gap)
    level = case.gap[case.inside].mean(dtype=float) if case.load is not None and case.inside.any() else 0.0
    drawn = np.where(case.saturated, case.gap > level, case.gap < level)
    clear = np.abs(case.gap - level) > 1e-6
    np.testing.assert_array_equal(active[clear], (case.inside | drawn)[clear])
    assert count == np.count_nonzero(active)
    mean = case.gap[active].mean(dtype=float) if case.load is not None and count else 0.0
    np.testing.assert_allclose(residual, np.where(active, mean - case.gap, 0.0), atol=1e-6)


@many
@given(fields())
def test_an_admitted_direction_is_the_nearest_of_sum_zero_that_no_released_cell_follows_across_its_bound(case):
    residual, active, count = case.passes.release(case.pressure, case.gap)
    assume(count)
    direction = case.noise(active)
    admitted, slope = case.passes.admit(direction, residual, active, case.pressure)
    low = active & (case.pressure <= 0.0)
    high = active & case.saturated
    assert not admitted[~active].any()
    assert admitted[low].min(initial=0.0) >= 0.0
    assert admitted[high].max(initial=0.0) <= 0.0
    assert slope == pytest.approx(float(residual.astype(float) @ admitted), rel=1e-5, abs=1e-5)
    if case.load is not None:
        assert abs(admitted.sum(dtype=float)) < 1e-6 * np.abs(direction).sum() + 1e-6
    # The same shift on all cells that move; those that stay would be moved across their bounds by it.
    moves = active & (admitted != 0.0)
    if case.load is not None and not moves.any():
        return
    shift = 0.0 if case.load is None else float((direction - admitted)[moves].mean(dtype=float))
    held = np.where(low, np.maximum(direction - shift, 0.0), direction - shift)
    held = np.where(high, np.minimum(held, 0.0), held)
    np.testing.assert_allclose(admitted, np.where(active, held, 0.0), atol=3e-6)


@many
@given(fields(), st.floats(0.01, 1.5))
def test_a_step_keeps_the_load_and_the_bounds(case, length):
    residual, active, count = case.passes.release(case.pressure, case.gap)
    assume(count)
    direction, _ = case.passes.admit(case.noise(active), residual, active, case.pressure)
    trial, step, clipped = case.passes.advance(case.pressure, direction, length, active)
    plain = case.pressure + np.float32(length) * direction
    assert clipped == bool(((plain < 0.0) | (plain > case.bound)).any())
    assert trial.min() >= 0.0
    assert (trial <= case.bound).all()
    np.testing.assert_array_equal(trial[~active], case.pressure[~active])
    np.testing.assert_array_equal(step, (trial - case.pressure).astype(np.float32))
    change = float(np.abs(plain - case.pressure).sum())
    if case.load is not None:
        assert abs(trial.sum() - case.load) <= 2e-5 * change + 1e-12
    moves = active & (trial > 0.0) & (trial < case.bound)
    shift = (plain - trial)[moves].mean() if case.load is not None and moves.any() else 0.0
    if moves.any() or case.load is None:
        # The pressure nearest to the step, of this load.
        np.testing.assert_allclose(trial[active], np.clip(plain - shift, 0.0, case.bound)[active], atol=1e-12)


@many
@given(fields(), st.floats(0.05, 4.0))
def test_the_other_passes_follow_their_formulas(case, part):
    active = case.rng.random(case.gap.size) < 0.6
    image, step, change = case.noise(), case.noise(), case.noise()
    residual = case.noise(active)
    factor = max(0.0, -float((image * active).astype(float) @ change) / 2.0)
    found, slope = case.passes.conjugate(image.copy(), residual, active, LastStep(step, change, 2.0))
    assert slope == pytest.approx(float(image.astype(float) @ residual), abs=1e-4)
    np.testing.assert_allclose(found, active * (image + factor * step), atol=1e-4)
    first, _ = case.passes.conjugate(image.copy(), residual, active, None)
    np.testing.assert_array_equal(first, image * active)
    slope, curvature = case.passes.slopes(image, step, change)
    assert slope == pytest.approx(float(image.astype(float) @ step), abs=1e-4)
    assert curvature == pytest.approx(float(step.astype(float) @ change), abs=1e-4)
    trial = np.minimum(case.rng.uniform(0.0, 1.0, case.gap.size), case.bound)
    moved, inside = case.passes.move(case.pressure, trial, part)
    plain = case.pressure + part * (trial - case.pressure)
    assert inside == bool(((plain >= 0.0) & (plain <= case.bound)).all())
    np.testing.assert_allclose(moved, np.clip(plain, 0.0, case.bound), atol=1e-15)
    gap = case.gap.copy()
    case.passes.add(gap, change.copy(), part)
    np.testing.assert_allclose(gap, case.gap + part * change, atol=1e-5)


class Identity:
    """A preconditioner that does nothing."""

    def apply(self, values):
        return values.copy()


@pytest.mark.parametrize("by_load", [False, True])
@pytest.mark.parametrize("limit", [None, 0.9])
def test_the_energy_falls_with_every_step_and_the_pressure_stays_within_its_bounds(by_load, limit):
    """Any symmetric compliance above zero, dense, without a preconditioner, from a bad start."""
    rng = np.random.default_rng(9)
    root = rng.normal(size=(42, 42))
    compliance = root @ root.T / 42 + 0.3 * np.eye(42)
    height = rng.normal(size=42)
    start = rng.uniform(0.0, 0.9, 42) * (rng.random(42) < 0.6)
    load = float(start.sum())

    def multiply(field):
        return (compliance @ field.ravel()).reshape(field.shape).astype(field.dtype)

    bounds = None if limit is None else np.array([limit])
    passes = NumpyPasses(bounds, load if by_load else None)
    descent = FieldDescent(multiply, Identity(), Work(), passes, (6, 7))
    descent.start(start.copy(), (height + compliance @ start).astype(np.float32))
    energies = []
    for _ in range(300):
        pressure = descent.pressure
        assert pressure.min() >= 0.0
        assert limit is None or pressure.max() <= limit
        if by_load:
            assert pressure.sum() == pytest.approx(load, rel=1e-4)
        energies.append(0.5 * pressure @ compliance @ pressure + height @ pressure)
        if descent.step() is not None or descent.measure()[0] < 1e-6:
            break
    assert all(np.diff(energies) < 1e-6)
    assert len(energies) < 150
    gap = height + compliance @ descent.pressure
    inside = (descent.pressure > 0.0) & (descent.pressure < (np.inf if limit is None else limit))
    level = np.median(gap[inside]) if by_load else 0.0
    assert np.abs(gap - level)[inside].max() < 1e-4
    assert (gap - level)[descent.pressure == 0.0].min() > -1e-4


def solve_on_lists(problem, **given):
    """Return the solution as it is found on large grids."""
    with pytest.MonkeyPatch.context() as patch:
        act_as_on_large_grids(patch)
        return problem.solve(**given)


def require_equal(problem, **given):
    """Solve on fields and on lists of cells; return both."""
    found = problem.solve(**given)
    lists = solve_on_lists(problem, **given)
    assert found.status.success
    assert found.residuals.error <= 2e-8
    np.testing.assert_allclose(found.pressure, lists.pressure, atol=2e-6 * lists.pressure.max())
    assert found.approach == pytest.approx(lists.approach, rel=1e-6)
    return found, lists


SHAPES = [(64, 64), (33, 47), (128, 16), (16, 128), (96, 101), (1, 300)]


@pytest.mark.slow
@settings(max_examples=60)
@given(
    st.sampled_from(SHAPES),
    st.sampled_from([1.0, 3.0, 1.0 / 3.0]),
    st.sampled_from(["free", "periodic", "wrapped", ("free", "periodic"), ("periodic", "free")]),
    st.sampled_from(["none", "uniform", "each"]),
    st.sampled_from([1e-4, 1e-2, 0.1, 0.3, 0.6]),
    st.booleans(),
    st.integers(0, 99),
)
def test_random_contacts_have_the_pressure_that_lists_find(shape, aspect, boundary, kind, fraction, by_load, seed):
    """From light to nearly full contact, or with saturated cells."""
    rng = np.random.default_rng(seed)
    waves = rc.SelfAffineSurface(hurst=0.8, rms_slope=SLOPE, shortest=6.0, longest=60.0, seed=seed)
    hardness = {"none": None, "uniform": 0.6 * SLOPE, "each": SLOPE * rng.uniform(0.3, 1.0, shape)}[kind]
    material = rc.Elastic(YOUNG, 0.0) if hardness is None else rc.ElasticPerfectlyPlastic(YOUNG, 0.0, hardness)
    grid = rc.Grid(shape, (float(shape[0]), aspect * shape[1]))
    problem = make_problem(waves, material, grid=grid, boundary=boundary, solver=STRICT)
    assume(problem.initial_gap.max() > 0.0)
    if by_load:
        require_equal(problem, pressure=fraction * (SLOPE * YOUNG if hardness is None else float(np.mean(hardness))))
    else:
        require_equal(problem, approach=fraction * float(problem.initial_gap.mean()))


@pytest.mark.parametrize("fraction", [0.8, 1.0, 1.4, 3.0])
@pytest.mark.parametrize("hardness", [None, 5.0 * SLOPE])
def test_near_and_beyond_full_contact_the_pressure_is_that_of_the_openings(fraction, hardness):
    found, _ = require_equal(rough(96, hardness=hardness), pressure=fraction * SLOPE * YOUNG)
    assert found.contact.all() == (fraction == 3.0)


@pytest.mark.parametrize("boundary", ["free", "periodic"])
@pytest.mark.parametrize("hardness", [None, 0.3 * SLOPE])
@pytest.mark.parametrize("factor", [0.3, 1.05, 2.0])
def test_a_start_from_another_load_leads_to_the_same_pressure(boundary, hardness, factor):
    problem = rough(64, boundary=boundary, hardness=hardness)
    load = 0.08 * SLOPE * YOUNG
    start = problem.solve(pressure=factor * load).pressure
    warm, _ = require_equal(problem, pressure=load, start=start)
    cold = problem.solve(pressure=load)
    np.testing.assert_allclose(warm.pressure, cold.pressure, atol=2e-6 * cold.pressure.max())


@pytest.fixture
def descents(monkeypatch):
    """The classes of the descents, in the order in which they start."""
    started = []
    for kind in (FieldDescent, Descent):
        plain = kind.start

        def start(self, *given, plain=plain):
            started.append(type(self))
            return plain(self, *given)

        monkeypatch.setattr(kind, "start", start)
    return started


def test_small_grids_are_solved_on_fields_and_large_ones_on_lists(descents):
    assert rough(128).solve(pressure=5e-3).status is rc.Status.CONVERGED
    assert set(descents) == {FieldDescent}
    descents.clear()
    # 256 x 128 cells are the largest small grid.
    waves = rc.SelfAffineSurface(hurst=0.8, rms_slope=SLOPE, shortest=8.0, longest=64.0)
    for shape, kind in (((256, 128), FieldDescent), ((258, 128), Descent)):
        grid = rc.Grid(shape, (256.0, 128.0))
        problem = make_problem(waves, rc.Elastic(YOUNG, 0.0), grid=grid, boundary="periodic", convolver="circular-fft")
        assert problem.solve(pressure=5e-3).status is rc.Status.CONVERGED
        assert descents[-1] is kind


@pytest.mark.parametrize("load", [{"pressure": 5e-3}, {"approach": 0.3}])
@pytest.mark.parametrize("hardness", [None, 0.03])
def test_a_descent_that_stalls_is_continued_on_lists_of_cells(load, hardness, descents, monkeypatch):
    problem = rough(64, hardness=hardness)
    plain = problem.solve(**load)
    assert set(descents) == {FieldDescent}
    descents.clear()
    monkeypatch.setattr(FieldDescent, "patience", 0)
    found = problem.solve(**load)
    assert descents[0] is FieldDescent
    assert set(descents[1:]) == {Descent}
    assert found.status is rc.Status.CONVERGED
    np.testing.assert_allclose(found.pressure, plain.pressure, atol=2e-6 * plain.pressure.max())


def test_after_a_stall_of_both_descents_another_method_continues(monkeypatch):
    monkeypatch.setattr(FieldDescent, "step", lambda self: rc.Status.STALLED)
    monkeypatch.setattr(Descent, "iterate", lambda self: False)
    solution = rough(64).solve(pressure=5e-3)
    assert solution.status is rc.Status.RESCUED
    assert solution.residuals.error <= 2e-8


def test_a_limit_that_steps_cross_but_the_solution_does_not_reach_takes_a_second_solve():
    free = rough(64).solve(pressure=5e-3)
    found = rough(64, hardness=1.001 * free.pressure.max()).solve(pressure=5e-3)
    np.testing.assert_array_equal(found.pressure, free.pressure)
    assert found.convolutions > 1.5 * free.convolutions
    far = rough(64, hardness=100.0 * free.pressure.max()).solve(pressure=5e-3)
    np.testing.assert_array_equal(far.pressure, free.pressure)
    assert far.convolutions == free.convolutions


class Plate(rc.InfluenceKernel):
    """A half-space under a plate, which is much stiffer for short waves."""

    def spectrum(self, qx, qy, spacing, compliance):
        q = np.hypot(qx, qy)
        return 2.0 * compliance / (np.where(q > 0.0, q, 1.0) * (1.0 + (4.0 * q) ** 3))


def test_a_steep_kernel_is_solved_on_lists_by_the_extended_inverse(descents, monkeypatch):
    updates = []
    plain = ExtendedInverse.update
    monkeypatch.setattr(ExtendedInverse, "update", lambda self, active: updates.append(1) or plain(self, active))
    problem = rough(64, kernel=Plate(), solver=rc.ProjectedConjugateGradient())
    assert is_steep(problem.convolution.inverse())
    solution = problem.solve(pressure=5e-3)
    assert solution.status is rc.Status.CONVERGED
    assert set(descents) == {Descent}
    assert updates
