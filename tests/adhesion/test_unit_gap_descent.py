from __future__ import annotations

import math

import attrs
import numpy as np
import pytest

import roughcontact as rc
from roughcontact._solve.solution.attraction import AdhesiveConditions
from roughcontact._solve.solvers.adhesive import LinearisedGap, surface_stiffness
from roughcontact._solve.solvers.adhesive.gap_descent import GapOnGrid
from roughcontact.reference import MaugisDugdale
from roughcontact.typing import BoundInteraction, BoundKernel, Task
from scenes import each_once

TOLERANCE = 1e-5


def prepare(grid, boundary="periodic"):
    """Return the convolution with lengths in metres of which a cell has one, and E* = 1."""
    convolver = rc.DCFFT() if boundary == "free" else rc.CircularFFT()
    return convolver.prepare(BoundKernel(rc.Love()), grid, rc.Boundary(boundary))


def make_rough(shape=(64, 64), spacing=(1.0, 1.0), seed=1, slope=1.0):
    grid = rc.Grid(shape, (shape[0] * spacing[0], shape[1] * spacing[1]))
    shortest = 8.0 * max(spacing)
    surface = rc.SelfAffineSurface(
        hurst=0.8, rms_slope=slope, shortest=shortest, longest=max(min(grid.size) / 2, 2 * shortest), seed=seed
    )
    heights = surface.heights(grid)
    return grid, heights.max() - heights


def make_law(work, cells=4.0, cell=1.0):
    """Return an exponential law with so many cells of the cohesive length."""
    return BoundInteraction(rc.Exponential(work, math.sqrt(cells * cell * work)))


def judge(convolution, task, outcome):
    conditions = AdhesiveConditions(
        initial_gap=task.initial_gap,
        interaction=task.interaction,
        pressure_limit=task.pressure_limit,
        approach=task.approach,
    )
    return conditions.measure(outcome.pressure, outcome.tension, convolution.apply(outcome.pressure))


def contact_of(outcome):
    return outcome.pressure + outcome.tension > 0.0


def solve(convolution, task, solver=None):
    """Return an outcome that the conditions confirm, and whose load is right."""
    outcome = (solver or rc.GapDescent()).solve(convolution, task)
    assert outcome.status is rc.Status.CONVERGED
    assert judge(convolution, task, outcome).error < 2.0 * TOLERANCE
    if task.mean_pressure is not None:
        size = np.abs(outcome.pressure).mean()
        assert outcome.pressure.mean() == pytest.approx(task.mean_pressure, abs=1e-12 * size)
    opened = ~contact_of(outcome)
    np.testing.assert_array_equal(outcome.pressure[opened], -outcome.tension[opened])
    return outcome


class Ball:
    """A ball that unloads, by the theory of Maugis, in cells and E*."""

    def __init__(self, tabor, radius, smoothing=0.3, cells=None, place=(0.0, 0.0)):
        self.radius = 20.0 * radius
        self.work = radius**3 / (4.5 * math.pi * self.radius**2)
        strength = self.work / ((self.radius * self.work**2) ** (1 / 3) / tabor)
        self.theory = MaugisDugdale(self.radius, 1.0, self.work, strength)
        self.law = BoundInteraction(rc.Dugdale(self.work, strength, smoothing))
        # The tension around a hard ball acts far out.
        cells = cells or 2 * math.ceil((1.3 + 0.15 / tabor) * radius + 5)
        self.grid = rc.Grid((cells, cells), float(cells))
        self.gap = ((self.grid.x - place[0]) ** 2 + (self.grid.y - place[1]) ** 2) / (2.0 * self.radius)
        self.unit = (math.pi**2 * self.work**2 * self.radius / (16 / 9)) ** (1 / 3)

    @property
    def resolution(self):
        return 1.0 / self.law.steepest

    def unload(self, approaches):
        """Return the outcomes at approaches over their unit, each from the one before."""
        convolution = prepare(self.grid, "free")
        found = []
        start = start_gap = None
        for approach in approaches:
            task = Task(
                initial_gap=self.gap,
                approach=approach * self.unit,
                interaction=self.law,
                start=start,
                start_gap=start_gap,
            )
            outcome = solve(convolution, task)
            start = outcome.pressure
            gap = convolution.apply(start) + self.gap - task.approach
            start_gap = np.where(contact_of(outcome), 0.0, np.maximum(gap, 0.0))
            found.append(outcome)
        return found


@pytest.mark.parametrize(
    ("tabor", "radius", "smoothing", "error"), [(0.1, 10, 0.2, 2e-3), (0.3, 14, 0.2, 2e-3), (1.0, 20, 0.4, 5e-3)]
)
def test_ball_comes_off_at_the_force_of_maugis(tabor, radius, smoothing, error):
    ball = Ball(tabor, radius, smoothing, place=(0.2, 0.1))
    assert ball.resolution > 3.5
    forces = np.array([outcome.pressure.sum() for outcome in ball.unload(np.arange(0.2, -1.5, -0.05))])
    lowest = int(forces.argmin())
    assert 0 < lowest < forces.size - 1
    assert forces.min() == pytest.approx(ball.theory.pull_off, rel=error)


def test_radius_of_the_ball_without_load():
    ball = Ball(0.5, 16, 0.3)
    task = Task(initial_gap=ball.gap, mean_pressure=0.0, interaction=ball.law)
    outcome = solve(prepare(ball.grid, "free"), task)
    radius = math.sqrt(np.count_nonzero(contact_of(outcome)) / math.pi)
    assert radius == pytest.approx(ball.theory.radius_at_zero_load, rel=0.015)


def test_force_is_the_derivative_of_the_energy():
    ball = Ball(0.5, 12, 0.5)
    convolution = prepare(ball.grid, "free")
    energies, forces = [], []
    approaches = np.linspace(0.30, 0.34, 9)
    for outcome, approach in zip(ball.unload(approaches), approaches, strict=True):
        moved = convolution.apply(outcome.pressure)
        gap = np.where(contact_of(outcome), 0.0, np.maximum(moved + ball.gap - approach * ball.unit, 0.0))
        energies.append(0.5 * (outcome.pressure * moved).sum() + ball.law.energy(gap).sum())
        forces.append(outcome.pressure.sum())
    step = (approaches[1] - approaches[0]) * ball.unit
    slope = np.polyfit(np.arange(9) - 4, energies, 4)[-2] / step
    assert slope == pytest.approx(np.polyfit(np.arange(9) - 4, forces, 4)[-1], rel=2e-3)


@each_once(
    {
        "boundary": ["periodic", "free", "wrapped"],
        "control": ["load", "approach"],
        "limit": [math.inf, 0.8],
    }
)
def test_descent_and_majorise_agree(boundary, control, limit):
    grid, gap = make_rough((48, 48))
    load = {"mean_pressure": 0.05} if control == "load" else {"approach": 0.6 * gap.mean()}
    task = Task(initial_gap=gap, interaction=make_law(0.1), pressure_limit=limit, **load)
    convolution = prepare(grid, boundary)
    descent = solve(convolution, task)
    other = solve(convolution, task, rc.Majorise())
    np.testing.assert_array_equal(contact_of(descent), contact_of(other))
    np.testing.assert_allclose(descent.pressure, other.pressure, atol=2e-4 * descent.pressure.max())
    if math.isfinite(limit):
        assert descent.pressure.max() == limit
        assert descent.pressure.min() >= -float(task.interaction.strength)


@pytest.mark.parametrize(
    "law", [rc.Dugdale(0.2, 0.25, 0.5), rc.VanDerWaals(0.2, 2.2), rc.Exponential(0.2, 0.9)], ids=repr
)
def test_every_law_by_both_solvers(law):
    grid, gap = make_rough((48, 48), seed=3)
    task = Task(initial_gap=gap, interaction=BoundInteraction(law), mean_pressure=0.02)
    convolution = prepare(grid)
    descent = solve(convolution, task)
    other = solve(convolution, task, rc.Majorise())
    assert contact_of(descent).mean() == pytest.approx(contact_of(other).mean(), abs=0.01)


def test_weak_attraction_changes_the_pressure_in_proportion():
    grid, gap = make_rough()
    convolution = prepare(grid)
    plain = rc.ProjectedConjugateGradient(1e-9).solve(convolution, Task(initial_gap=gap, mean_pressure=0.05))
    changes = []
    for work in (1e-3, 1e-4, 1e-5):
        task = Task(initial_gap=gap, mean_pressure=0.05, interaction=BoundInteraction(rc.Exponential(work, 0.5)))
        outcome = rc.GapDescent(1e-8).solve(convolution, task)
        changes.append(np.abs(outcome.pressure - plain.pressure).max())
    assert changes[1] / changes[0] == pytest.approx(0.1, rel=0.2)
    assert changes[2] / changes[1] == pytest.approx(0.1, rel=0.2)
    np.testing.assert_array_equal(contact_of(outcome), plain.pressure > 0.0)


def test_without_interaction_it_is_the_default_solver():
    grid, gap = make_rough()
    task = Task(initial_gap=gap, mean_pressure=0.05)
    convolution = prepare(grid)
    plain = rc.ProjectedConjugateGradient().solve(convolution, task)
    for solver in (rc.GapDescent(), rc.Majorise()):
        np.testing.assert_array_equal(solver.solve(convolution, task).pressure, plain.pressure)


@each_once(
    {
        "shape spacing": [
            ((128, 16), (1.0, 1.0)),
            ((45, 63), (1.0, 1.0)),
            ((48, 32), (1.0, 3.0)),
            ((37, 64), (2.0, 1.0)),
        ],
        "boundary": ["periodic", "free"],
    }
)
def test_shapes_of_domains_and_cells_and_their_transposes(shape, spacing, boundary):
    grid, gap = make_rough(shape, spacing)
    law = make_law(0.1 * max(spacing), cell=max(spacing))
    turned = rc.Grid(shape[::-1], grid.size[::-1])
    for load in ({"mean_pressure": 0.03}, {"approach": 0.5 * gap.mean()}):
        task = Task(initial_gap=gap, interaction=law, **load)
        outcome = solve(prepare(grid, boundary), task)
        other = solve(prepare(turned, boundary), attrs.evolve(task, initial_gap=np.ascontiguousarray(gap.T)))
        np.testing.assert_array_equal(contact_of(outcome), contact_of(other).T)
        np.testing.assert_allclose(outcome.pressure, other.pressure.T, atol=2e-4 * outcome.pressure.max())


def test_a_law_that_varies_attracts_where_it_is_strong():
    grid, gap = make_rough(seed=5)
    work = np.where(grid.x < 0.0, 0.3, 1e-6) + 0.0 * grid.y
    task = Task(initial_gap=gap, interaction=BoundInteraction(rc.Exponential(work, 1.1)), mean_pressure=0.02)
    for boundary in ("periodic", "free"):
        outcome = solve(prepare(grid, boundary), task)
        assert outcome.tension[:32].max() > 1e4 * outcome.tension[32:].max()
        strong, weak = contact_of(outcome)[:32].mean(), contact_of(outcome)[32:].mean()
        assert strong > 2.0 * weak


def test_more_tension_less_contact_until_it_separates():
    grid, gap = make_rough()
    convolution = prepare(grid)
    law = make_law(0.5)
    start = None
    areas = []
    for load in (0.02, 0.0, -0.005, -0.01):
        outcome = solve(convolution, Task(initial_gap=gap, interaction=law, mean_pressure=load, start=start))
        areas.append(contact_of(outcome).mean())
        start = outcome.pressure
    assert np.all(np.diff(areas) < 0.0)
    assert areas[-1] > 0.0
    strength = float(law.strength)
    assert (
        rc.GapDescent()
        .solve(convolution, Task(initial_gap=gap, interaction=law, mean_pressure=-1.01 * strength))
        .status
        is rc.Status.SEPARATED
    )


def test_attraction_across_a_gap_without_contact():
    grid, gap = make_rough()
    law = BoundInteraction(rc.VanDerWaals(0.2, 4.0))
    for boundary in ("periodic", "free"):
        task = Task(initial_gap=gap, approach=-3.0, interaction=law)
        outcome = solve(prepare(grid, boundary), task)
        assert not contact_of(outcome).any()
        # Elasticity brings the surfaces closer than rigid ones, so that they attract each other more.
        rigid = law.tension(gap + 3.0).mean()
        assert rigid < -outcome.pressure.mean() < 2.0 * rigid


def test_the_margin_of_stability_falls_towards_pull_off():
    ball = Ball(1.0, 14, 0.5)
    convolution = prepare(ball.grid, "free")
    cells = ball.grid.cells
    start = start_gap = None
    margins = []
    for part in (0.0, -0.5, -0.8, -0.95):
        task = Task(
            initial_gap=ball.gap,
            mean_pressure=-part * ball.theory.pull_off / cells,
            interaction=ball.law,
            start=start,
            start_gap=start_gap,
        )
        outcome = solve(convolution, task)
        moved = convolution.apply(outcome.pressure) + ball.gap
        contact = contact_of(outcome)
        weights = (outcome.pressure + outcome.tension)[contact]
        gap = moved - (weights * moved[contact]).sum() / weights.sum()
        start = outcome.pressure
        start_gap = np.where(contact, 0.0, np.maximum(gap, 0.0))
        linear = LinearisedGap(
            surface_stiffness(convolution), ball.law, start_gap, np.zeros_like(contact), holds_approach=False
        )
        margins.append(linear.find_margin())
    assert 0.0 < margins[3] < 0.6 * margins[0]
    assert np.all(np.diff(margins) < 0.0)


def test_products_do_not_grow_with_the_grid():
    products = []
    for cells in (64, 128, 256):
        grid, gap = make_rough((cells, cells))
        task = Task(initial_gap=gap, interaction=make_law(0.2), mean_pressure=0.05)
        products.append(solve(prepare(grid), task).convolutions)
    assert max(products) < 80


def test_a_kernel_without_inverse_is_refused_in_a_sentence():
    class Blind(rc.InfluenceKernel):
        def spectrum(self, qx, qy, spacing, compliance):
            return np.maximum(1.0 - np.hypot(qx, qy), 0.0) + 0.0 * qx * qy

    grid, gap = make_rough()
    convolution = rc.CircularFFT().prepare(BoundKernel(Blind()), grid, rc.Boundary.PERIODIC)
    with pytest.raises(rc.InputError, match="majorise"):
        rc.GapDescent().solve(convolution, Task(initial_gap=gap, interaction=make_law(0.1), mean_pressure=0.05))


def test_numbers_that_are_not_finite_end_the_solve():
    grid, gap = make_rough()

    class Broken(rc.Exponential):
        def tension(self, gap):
            return super().tension(gap) * np.nan

        def scaled(self, length, pressure):
            return self

    task = Task(initial_gap=gap, interaction=BoundInteraction(Broken(0.1, 0.5)), mean_pressure=0.05)
    outcome = rc.GapDescent().solve(prepare(grid), task)
    assert outcome.status is rc.Status.NOT_FINITE
    assert outcome.iterations < 5


def test_a_limit_of_iterations_ends_the_solve_and_steps_are_reported():
    grid, gap = make_rough()
    steps = []
    task = Task(initial_gap=gap, interaction=make_law(0.1), mean_pressure=0.05, on_step=steps.append)
    outcome = rc.GapDescent(max_iterations=3).solve(prepare(grid), task)
    assert outcome.status is rc.Status.MAXIMUM_ITERATIONS
    assert [step.error for step in steps] == list(outcome.errors)
    assert steps[-1].shape == (64, 64)


@each_once(
    {
        "solver": [rc.GapDescent(), rc.Majorise()],
        "boundary": ["periodic", "free"],
        "given": ["load", "approach"],
    }
)
def test_a_solution_is_found_again_from_itself(solver, boundary, given):
    """From its pressure alone, and with its gap: the same contact, in a part of the products."""
    grid, gap = make_rough((40, 36), (1.0, 1.5))
    convolution = prepare(grid, boundary)
    task = Task(initial_gap=gap, interaction=make_law(0.1), mean_pressure=0.01)
    cold = solve(convolution, task, solver)
    moved = convolution.apply(cold.pressure) + gap
    weights = (cold.pressure + cold.tension) * contact_of(cold)
    approach = float((weights * moved).sum() / weights.sum())
    if given == "approach":
        task = attrs.evolve(task, mean_pressure=None, approach=approach)
    start_gap = np.where(contact_of(cold), 0.0, np.maximum(moved - approach, 0.0))
    starts = [{"start": cold.pressure, "start_gap": start_gap}, {"start": cold.pressure}]
    for start in starts:
        warm = solve(convolution, attrs.evolve(task, **start), solver)
        assert np.mean(contact_of(warm) != contact_of(cold)) < 0.01
        assert np.abs(warm.pressure - cold.pressure).max() < 0.02 * cold.pressure.max()
        # Of other shapes 29 for 37: the last digits decide on a few.
        assert warm.convolutions < 0.85 * cold.convolutions


@pytest.mark.parametrize("boundary", ["periodic", "free"])
def test_a_gap_to_start_from_needs_a_product_only_beyond_the_domain(boundary):
    grid, gap = make_rough((24, 20))
    start_gap = np.maximum(gap - 0.5 * gap.mean(), 0.0)
    task = Task(initial_gap=gap, interaction=make_law(0.1), mean_pressure=0.01, start=np.zeros(gap.shape))
    problem = GapOnGrid(prepare(grid, boundary), attrs.evolve(task, start_gap=start_gap))
    guess = problem.start_from_task()
    assert guess.products == (0.0 if boundary == "periodic" else 1.0)
    assert np.array_equal(problem.problem.stiffness.inner(guess.gap), start_gap)
    assert not np.shares_memory(guess.gap, start_gap)


def test_what_cannot_be_pressed_is_said():
    """More tension than any contact carries, an approach beyond reach, and too few rounds."""
    grid, gap = make_rough((32, 32))
    convolution = prepare(grid)
    task = Task(initial_gap=gap, interaction=make_law(0.02), mean_pressure=-10.0)
    outcome = rc.Majorise().solve(convolution, task)
    assert outcome.status is rc.Status.SEPARATED
    assert not outcome.pressure.any()
    far = attrs.evolve(task, mean_pressure=None, approach=-50.0 * float(gap.std()))
    apart = rc.Majorise().solve(convolution, far)
    assert apart.status is rc.Status.CONVERGED
    # Nothing touches: the tension of an open gap is all, and moves the surfaces by next to nothing.
    assert not contact_of(apart).any()
    np.testing.assert_allclose(apart.tension, task.interaction.tension(gap - far.approach), rtol=1e-3, atol=1e-30)
    steps = []
    given = attrs.evolve(task, mean_pressure=0.01, on_step=steps.append)
    few = rc.Majorise(max_rounds=2).solve(convolution, given)
    assert few.status is rc.Status.MAXIMUM_ITERATIONS
    assert few.iterations == len(few.errors) == len(steps) == 2
    assert [step.iteration for step in steps] == [0, 1]
    assert [step.error for step in steps] == list(few.errors)
