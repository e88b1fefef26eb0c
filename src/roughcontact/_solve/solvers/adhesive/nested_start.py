"""Starts of an adhesive contact: from the contact without adhesion, from a coarser grid, or from another load."""

from __future__ import annotations

import math

import attrs
import numpy as np

from roughcontact._base.arrays import Array, RealArray
from roughcontact._parts.interactions import BoundInteraction
from roughcontact._solve.convolvers import PreparedConvolution
from roughcontact._solve.solution import GridLevel
from roughcontact._solve.solvers.adhesive.descent import AdhesiveDescent, GapProblem
from roughcontact._solve.solvers.adhesive.stiffness import SurfaceStiffness, surface_stiffness
from roughcontact._solve.solvers.base import Task
from roughcontact._solve.solvers.conjugate import ProjectedConjugateGradient
from roughcontact._solve.solvers.conjugate.nested_iteration import _interpolate, coarsen

# Error of the contact without adhesion, over the scale, at which a descent starts from it.
_ROUGHLY = 1e-2
# Error and iterations at which the solve on a coarse grid ends.
_TOLERANCE = 1e-2
_ITERATIONS = 8
# Cells of the cohesive length that a coarse grid should have: a range that is shorter is stretched.
_RESOLVED = 1.0


@attrs.frozen(eq=False)
class GapGuess:
    """A gap to start from, on the extended grid in float64, and the work on coarser grids.

    Attributes
    ----------
    products
        Cost in convolutions on the grid of the gap.
    """

    problem: GapProblem
    gap: Array
    products: float = 0.0
    levels: tuple[GridLevel, ...] = ()


def make_gap_problem(stiffness: SurfaceStiffness, task: Task) -> GapProblem:
    """Return what a descent minimises for a task."""
    approach = task.approach
    compliance = stiffness.mean_compliance
    nx, ny = stiffness.shape
    mx, my = stiffness.extended
    base = 0.0
    if task.mean_pressure is not None:
        base = task.mean_pressure * ((nx * ny) / (mx * my))
    elif approach is not None and compliance > 0.0:
        base = approach / compliance
    return GapProblem(
        stiffness=stiffness,
        interaction=task.interaction,
        closing=stiffness.embed(task.initial_gap),
        base=base,
        mean_stiffness=1.0 / compliance if approach is not None and compliance > 0.0 else 0.0,
        holds_mean=approach is not None and compliance == 0.0,
        limit=task.pressure_limit,
    )


def hold_mean(problem: GapProblem, task: Task, gap: Array) -> Array:
    """Return a gap, changed in place, whose open cells are scaled to the mean gap of the task, where it is held."""
    if not problem.holds_mean or task.approach is None:
        return gap
    needed = float(task.initial_gap.mean() - task.approach) * gap.size
    opened = np.maximum(gap, 0.0)
    total = float(opened.sum())
    flattened = float(gap.sum()) - total
    if needed - flattened > 0.0 and total > 0.0:
        np.multiply(gap, (needed - flattened) / total, out=gap, where=gap > 0.0)
    else:
        gap += needed / gap.size - float(gap.mean())
    return gap


def start_from_task(convolution: PreparedConvolution, task: Task) -> GapGuess:
    """Return the start that a task gives by its pressure, and by its gap if there is one."""
    problem = make_gap_problem(surface_stiffness(convolution), task)
    pressure = np.zeros_like(task.initial_gap) if task.start is None else task.start
    gap = _gap_of_pressure(problem, task, pressure)
    if task.start_gap is not None:
        inside = problem.stiffness.inner(gap)
        shift = (
            0.0 if problem.stiffness.extended == problem.stiffness.shape else float((task.start_gap - inside).mean())
        )
        gap += shift
        inside[:] = task.start_gap
    return GapGuess(problem, hold_mean(problem, task, gap), 1.0)


def start_from_contact(convolution: PreparedConvolution, task: Task, stiffness: SurfaceStiffness) -> GapGuess:
    """Return the gap of the contact without adhesion, or of the first touch where the load does not press."""
    problem = make_gap_problem(stiffness, task)
    load = task.mean_pressure if task.approach is None else task.approach - float(task.initial_gap.min())
    pressure = np.zeros_like(task.initial_gap)
    products = 0
    if load is not None and load > 0.0:
        plain = attrs.evolve(task, interaction=None, start=None, start_gap=None, on_step=None)
        outcome = ProjectedConjugateGradient(_ROUGHLY).solve(convolution, plain)
        pressure = outcome.pressure
        products = outcome.convolutions
    gap = _gap_of_pressure(problem, task, pressure)
    return GapGuess(problem, hold_mean(problem, task, gap), products + 1.0)


def nested_start(convolution: PreparedConvolution, task: Task, extended: tuple[int, int] | None = None) -> GapGuess:
    """Return the gap of the next coarser grid, itself found so, interpolated to the grid of the task."""
    stiffness = surface_stiffness(convolution, extended)
    extended = stiffness.extended
    halved = coarsen(convolution.setup.grid, task)
    if halved is None:
        return start_from_contact(convolution, task, stiffness)
    grid, coarse_task = halved
    factors = [n // m for n, m in zip(task.initial_gap.shape, grid.shape, strict=True)]
    if any(m % f for m, f in zip(extended, factors, strict=True)):
        return start_from_contact(convolution, task, stiffness)
    fx, fy = factors
    coarse_extended = (extended[0] // fx, extended[1] // fy)
    coarse_task = attrs.evolve(coarse_task, interaction=_coarsen_interaction(task, fx, fy))
    guess = nested_start(convolution.on(grid), coarse_task, coarse_extended)
    guess = _solve_coarse(guess, coarse_task)
    problem = make_gap_problem(stiffness, task)
    gap = _refine(guess, problem, task, fx, fy)
    return GapGuess(problem, hold_mean(problem, task, gap), guess.products / (fx * fy), guess.levels)


def _coarsen_interaction(task: Task, fx: int, fy: int) -> BoundInteraction | None:
    """Return the interaction on a coarser grid: its arrays averaged, its range stretched to what the grid resolves."""
    interaction = task.interaction
    if interaction is None:
        return None

    def average(values: Array) -> Array:
        nx, ny = values.shape
        return np.asarray(values.reshape(nx // fx, fx, ny // fy, fy).mean(axis=(1, 3)))

    return interaction.convert(average)


def _solve_coarse(guess: GapGuess, task: Task) -> GapGuess:
    problem = guess.problem
    interaction = task.interaction
    if interaction is not None:
        resolved = problem.stiffness.cohesive_cells(interaction)
        stretch = math.sqrt(max(_RESOLVED / resolved, 1.0))
        problem = attrs.evolve(problem, interaction=interaction.stretched(stretch))
    descent = AdhesiveDescent(problem, np.float32)
    descent.start(guess.gap)
    scale = gap_scale(task, guess.gap, problem)
    count = 0
    while True:
        error = descent.measure()
        if error <= _TOLERANCE * scale or count >= _ITERATIONS or not descent.advance():
            break
        count += 1
    gap = hold_mean(problem, task, descent.gap.astype(np.float64))
    level = GridLevel(task.initial_gap.shape, count, 0, 0, descent.products)
    return attrs.evolve(guess, gap=gap, products=guess.products + descent.products, levels=(*guess.levels, level))


def gap_scale(task: Task, gap: Array, problem: GapProblem) -> float:
    """Return the smaller of the standard deviation of the initial gap and the range of the displacement."""
    rms = float(task.initial_gap.std()) if task.rms_gap is None else task.rms_gap
    displacement = problem.stiffness.inner(gap) - task.initial_gap
    moved = float(displacement.max() - displacement.min())
    return min(rms, moved) or max(rms, moved) or 1.0


def _gap_of_pressure(problem: GapProblem, task: Task, pressure: Array) -> Array:
    """Return the gap of a pressure on the extended grid, zero where it presses, from the approach that it implies."""
    stiffness = problem.stiffness
    gap = stiffness.displace(stiffness.embed(pressure))
    gap += problem.closing
    inside = stiffness.inner(gap)
    bearing = pressure > 0.0
    approach = task.approach
    if approach is None:
        load = float(np.maximum(pressure, 0.0).sum())
        weighted = float(np.einsum("ij,ij->", np.maximum(pressure, 0.0), inside))
        approach = weighted / load if load > 0.0 else float(inside.min())
    gap -= approach
    np.maximum(inside, 0.0, out=inside)
    inside[bearing] = 0.0
    return gap


def _refine(guess: GapGuess, problem: GapProblem, task: Task, fx: int, fy: int) -> Array:
    """Return the gap on a finer grid: the displacement is interpolated, and cells in contact stay so."""
    coarse = guess.gap - guess.problem.closing
    gap = _interpolate(coarse, fx, fy)
    gap += problem.closing
    inside = problem.stiffness.inner(gap)
    parent = _repeat(guess.problem.stiffness.inner(guess.gap), fx, fy)
    near = 0.0
    if task.interaction is not None:
        near = 0.5 * float(np.max(task.interaction.strength)) / task.interaction.steepest
    flattened = parent < 0.0
    inside[(parent <= 0.0) & (inside < near) & ~flattened] = 0.0
    np.maximum(inside, 0.0, out=inside, where=~flattened)
    np.minimum(inside, 0.0, out=inside, where=flattened)
    return gap


def _repeat(values: RealArray, fx: int, fy: int) -> RealArray:
    return np.repeat(np.repeat(values, fy, axis=1), fx, axis=0)
