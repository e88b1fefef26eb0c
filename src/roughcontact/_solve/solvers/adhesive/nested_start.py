"""Starts of an adhesive contact: from the contact without adhesion, from a coarser grid, or from another load."""

from __future__ import annotations

import math

import attrs
import numpy as np

from roughcontact._base.arrays import Array
from roughcontact._parts.interactions import BoundInteraction
from roughcontact._solve.convolvers import PreparedConvolution
from roughcontact._solve.solution import GridLevel
from roughcontact._solve.solvers.adhesive.descent import AdhesiveDescent
from roughcontact._solve.solvers.adhesive.gap_problem import GapProblem, gap_scale, hold_mean, make_gap_problem
from roughcontact._solve.solvers.adhesive.stiffness import SurfaceStiffness, surface_stiffness
from roughcontact._solve.solvers.base import Task
from roughcontact._solve.solvers.conjugate import ProjectedConjugateGradient
from roughcontact._solve.solvers.conjugate.nested_iteration import coarsen, interpolate, repeat_cells
from roughcontact._solve.solvers.driver import Log, iterate

# Error of the contact without adhesion at which a descent starts from it.
_ROUGHLY = 1e-2
# Error of the gap, over the scale, and iterations at which a descent on a coarse grid ends. 5 and 12 iterations change
# the products of 54 rough contacts by 3 %.
_TOLERANCE = 1e-2
_ITERATIONS = 8
# Cells of the cohesive length that a coarse grid needs: a shorter range is stretched to that. Between 0.7 and 2 the
# products change by 5 %.
_RESOLVED = 1.0
# Fraction of the work of adhesion on coarse grids: their contact must stay below that of the fine grid, which only
# grows to the smallest one in equilibrium. With 1 the area of 4 of 54 rough contacts is up to 0.8 % larger, and
# a wave closes at an alpha of 0.55 instead of 0.57; with 0.9, which costs 10 % more products, and 0.6 all are the same.
_WEAKENED = 0.9


@attrs.frozen(eq=False)
class GapGuess:
    """A gap to start from, on the extended grid in float64, and the work on coarser grids.

    Attributes
    ----------
    problem
        The problem of which it is a guess.
    gap
        The gap, shape (mx, my).
    products
        Cost in convolutions on the grid of the gap.
    levels
        The work on each coarser grid.
    """

    problem: GapProblem
    gap: Array
    products: float = 0.0
    levels: tuple[GridLevel, ...] = ()


def start_from_task(convolution: PreparedConvolution, task: Task) -> GapGuess:
    """Return the start that a task gives by its pressure, and by its gap if there is one."""
    problem = make_gap_problem(surface_stiffness(convolution), task)
    pressure = np.zeros_like(task.initial_gap) if task.start is None else task.start
    gap = _gap_of_pressure(problem, task, pressure)
    if task.start_gap is not None:
        inside = problem.stiffness.inner(gap)
        gap += float((task.start_gap - inside).mean())
        inside[:] = task.start_gap
    return GapGuess(problem, hold_mean(problem, task, gap), 1.0)


def nested_start(convolution: PreparedConvolution, task: Task, extended: tuple[int, int] | None = None) -> GapGuess:
    """Return the gap of the next coarser grid, itself found so, interpolated to the grid of the task.

    Parameters
    ----------
    convolution, task
        The contact.
    extended
        Cells of the extended grid of a free boundary; None: chosen for fast transforms.
    """
    stiffness = surface_stiffness(convolution, extended)
    halved = coarsen(convolution.setup.grid, task)
    if halved is None:
        return _start_from_contact(convolution, task, stiffness)
    grid, coarse_task = halved
    fx, fy = (n // m for n, m in zip(task.initial_gap.shape, grid.shape, strict=True))
    mx, my = stiffness.extended
    if mx % fx or my % fy:
        return _start_from_contact(convolution, task, stiffness)
    coarse_task = attrs.evolve(coarse_task, interaction=_average(task.interaction, fx, fy))
    guess = nested_start(convolution.on(grid), coarse_task, (mx // fx, my // fy))
    guess = _descend(guess, coarse_task)
    problem = make_gap_problem(stiffness, task)
    gap = hold_mean(problem, task, _refine(guess, problem, fx, fy))
    return GapGuess(problem, gap, guess.products / (fx * fy), guess.levels)


def _start_from_contact(convolution: PreparedConvolution, task: Task, stiffness: SurfaceStiffness) -> GapGuess:
    """Return the gap of the contact without adhesion, or of the first touch where the load does not press."""
    problem = make_gap_problem(stiffness, task)
    pressure = np.zeros_like(task.initial_gap)
    products = 0
    lowest = float(task.initial_gap.min())
    load = task.mean_pressure if task.approach is None else task.approach - lowest
    if load is not None and load > 0.0:
        plain = attrs.evolve(task, interaction=None, start=None, start_gap=None, on_step=None)
        outcome = ProjectedConjugateGradient(_ROUGHLY).solve(convolution, plain)
        pressure = outcome.pressure
        products = outcome.convolutions
    gap = _gap_of_pressure(problem, task, pressure)
    return GapGuess(problem, hold_mean(problem, task, gap), products + 1.0)


def _gap_of_pressure(problem: GapProblem, task: Task, pressure: Array) -> Array:
    """Return the gap of a pressure on the extended grid, zero where it presses; it implies the approach if need be."""
    stiffness = problem.stiffness
    gap: Array = stiffness.displace(stiffness.embed(pressure))
    gap += problem.closing
    inside = stiffness.inner(gap)
    bearing = np.maximum(pressure, 0.0)
    approach = task.approach
    if approach is None:
        load = float(bearing.sum())
        approach = float(np.einsum("ij,ij->", bearing, inside)) / load if load > 0.0 else float(inside.min())
    gap -= approach
    np.maximum(inside, 0.0, out=inside)
    inside[bearing > 0.0] = 0.0
    return gap


def _average(interaction: BoundInteraction | None, fx: int, fy: int) -> BoundInteraction | None:
    """Return an interaction on a coarser grid: its arrays are averaged."""

    def average(values: Array) -> Array:
        nx, ny = values.shape
        means: Array = values.reshape(nx // fx, fx, ny // fy, fy).mean(axis=(1, 3))
        return means

    return None if interaction is None else interaction.convert(average)


def _descend(guess: GapGuess, task: Task) -> GapGuess:
    """Return a guess after a few iterations on a coarse grid, of a law that this grid resolves."""
    problem = guess.problem
    if problem.interaction is not None:
        stretch = math.sqrt(max(_RESOLVED / problem.stiffness.cohesive_cells(problem.interaction), 1.0))
        problem = attrs.evolve(problem, interaction=problem.interaction.stretched(stretch).weakened(_WEAKENED))
    descent = AdhesiveDescent(problem, np.float32)
    descent.start(guess.gap)
    descent.scale = gap_scale(task, guess.gap, problem)
    log = Log(task.initial_gap.shape, _ITERATIONS)
    iterate(descent, log, _TOLERANCE)
    gap = hold_mean(problem, task, descent.gap.astype(np.float64))
    level = GridLevel(task.initial_gap.shape, len(log.errors) - 1, 0, 0, descent.products)
    return attrs.evolve(guess, gap=gap, products=guess.products + descent.products, levels=(*guess.levels, level))


def _refine(guess: GapGuess, problem: GapProblem, fx: int, fy: int) -> Array:
    """Return the gap on a finer grid: the displacement is interpolated, and cells in contact stay so.

    A cell of a coarse one in contact may be open, but not by less than half of the range of the law.
    """
    coarse = guess.gap
    gap = interpolate(coarse - guess.problem.closing, fx, fy)
    gap += problem.closing
    inside = problem.stiffness.inner(gap)
    parent = repeat_cells(guess.problem.stiffness.inner(coarse), fx, fy)
    near = 0.0
    if problem.interaction is not None:
        near = 0.5 * float(np.max(problem.interaction.strength)) / problem.interaction.steepest
    flattened = parent < 0.0
    inside[(parent == 0.0) & (inside < near)] = 0.0
    np.maximum(inside, 0.0, out=inside, where=~flattened)
    np.minimum(inside, 0.0, out=inside, where=flattened)
    return gap
