"""Starts of a pressure: from coarser grids, or from another load; and the part of a free domain that can touch."""

from __future__ import annotations

from collections.abc import Callable

import attrs
import numpy as np

from roughcontact._base.arrays import Array, IntArray, RealArray, sum_of_products
from roughcontact._parts.grid import Boundary
from roughcontact._solve.convolvers import PreparedConvolution
from roughcontact._solve.solvers.base import Outcome, Step, Task, starting_pressure
from roughcontact._solve.solvers.conjugate.field_descent import FieldDescent
from roughcontact._solve.solvers.conjugate.preconditioner import is_steep
from roughcontact._solve.solvers.conjugate.refinement import NearlyFull, PressureRefinement
from roughcontact._solve.solvers.driver import Monitor
from roughcontact._solve.solvers.grids import GridProblem, Guess, coarsen, interpolate, repeat_cells
from roughcontact.errors.door import guarded

# Maximum cells of the grid that estimates the approach.
_MAX_ESTIMATE_CELLS = 64
# Error and iterations at which a coarse solve ends, which its grid limits to that accuracy, and at which the solve that
# estimates the approach ends.
_COARSE_TOLERANCE = 4e-2
_COARSE_ITERATIONS = 5
_ESTIMATE_TOLERANCE = 1e-2
_ESTIMATE_ITERATIONS = 60
# Factor on the estimated approach, for its error; a window that is too small is enlarged.
_APPROACH_MARGIN = 1.02
# Cells of which the sides of a window are multiples, so that they can be halved.
_WINDOW_MULTIPLE = 32
# Sum of the negative responses to a cell, over the maximum, that is rounding in float32.
_MAX_BULGE = 1e-6
# Maximum fraction of the domain for which a window saves work.
_MAX_WINDOW_FRACTION = 0.7
# Minimum fraction of the coarser grid in contact for a solve for the gap instead of the pressure.
_NEARLY_FULL_FRACTION = 0.6


@attrs.frozen(eq=False, kw_only=True)
class InitialGuess(Guess):
    """A pressure to start from.

    Attributes
    ----------
    pressure
        The pressure, shape (nx, ny), within the bounds; near full contact that which closes every gap.
    closed
        Whether the pressure closes every gap: it is then the solution.
    met_limit
        Whether the pressure limit shortened a step on any coarser grid.
    nearly_full
        Near full contact the gap to start from, from which the pressure follows.
    displacement
        The displacement by the pressure, if it was found.
    """

    pressure: Array
    closed: bool = False
    met_limit: bool = False
    nearly_full: NearlyFull | None = None
    displacement: RealArray | None = None


@attrs.frozen(eq=False)
class PressureOnGrid(GridProblem[InitialGuess]):
    """A contact whose pressure is sought."""

    @property
    def opens_cells(self) -> bool:
        """Whether the gap is sought near full contact, which saves steps on large grids without a pressure limit."""
        if self.task.capped:
            return False
        return not FieldDescent.serves(self.task) or is_steep(self.convolution.inverse(np.float32))

    def begin(self) -> InitialGuess:
        """Return the pressure of full contact, or a uniform one, or that of the task."""
        full = self.close()
        if full is None or not full.is_closed(self.task.pressure_limit):
            return InitialGuess(pressure=starting_pressure(self.task), products=0 if full is None else 1)
        return InitialGuess(pressure=full.closing, products=1, closed=True)

    def start_from(self, start: Array) -> InitialGuess:
        """Return a copy of a start, near full contact with its gap, as a guess."""
        task = self.task
        guess = InitialGuess(pressure=start.copy())
        bearing = start > 0.0
        contact = np.count_nonzero(bearing) / start.size
        if contact < 1.0 and (contact <= _NEARLY_FULL_FRACTION or not self.opens_cells):
            return guess
        full = self.close()
        if full is None or not full.inverse.exact:
            return attrs.evolve(guess, products=0 if full is None else 1)
        if full.is_closed(task.pressure_limit):
            return InitialGuess(pressure=full.closing, products=1, closed=True)
        if not self.opens_cells:
            return attrs.evolve(guess, products=1)
        gap = self.convolution.apply(start.astype(np.float32))
        gap += task.initial_gap
        gap -= np.float32(sum_of_products(start, gap) / float(start.sum()))
        nearly_full = attrs.evolve(full, gap=np.where(bearing, np.float32(0.0), np.maximum(gap, np.float32(0.0))))
        return InitialGuess(pressure=full.closing, products=2, nearly_full=nearly_full)

    def close(self) -> NearlyFull | None:
        """Return the pressure that closes every gap of a periodic surface at a load, without regard to its bounds."""
        if self.convolution.setup.boundary is not Boundary.PERIODIC or self.task.mean_pressure is None:
            return None
        inverse = self.convolution.inverse()
        closing = self.task.mean_pressure - inverse.apply(self.task.initial_gap)
        return NearlyFull(inverse, closing, np.zeros(closing.shape, dtype=np.float32, like=closing))

    def improve(self, guess: InitialGuess) -> InitialGuess:
        """Return a guess after a few iterations in float32."""
        gap = np.zeros(guess.pressure.shape, dtype=np.float32, like=guess.pressure)
        if not guess.closed:
            monitor = Monitor(self.task, _COARSE_TOLERANCE, _COARSE_ITERATIONS)
            refinement = PressureRefinement(self.convolution, self.task, monitor, guess.nearly_full)
            pressure, gap = refinement.approximate(guess.pressure)
            met_limit = guess.met_limit or refinement.met_limit
            guess = guess.after(refinement.level, pressure=pressure, met_limit=met_limit)
        gap -= self.task.initial_gap
        return attrs.evolve(guess, displacement=gap)

    def refine(self, coarse: PressureOnGrid, guess: InitialGuess, fx: int, fy: int) -> InitialGuess:
        """Return a guess from that on the coarser grid.

        The pressure is interpolated where the coarse grid is in contact, and where the gap is negative.
        """
        task = self.task
        pressure = guess.pressure
        assert guess.displacement is not None
        gap = interpolate(guess.displacement, fx, fy)
        gap += task.initial_gap
        guess = attrs.evolve(guess, displacement=None, nearly_full=None)
        is_open = (gap >= 0.0) & ~repeat_cells(pressure > 0.0, fx, fy)
        contact = np.count_nonzero(pressure) / pressure.size
        if contact == 1.0 or (contact > _NEARLY_FULL_FRACTION and self.opens_cells):
            full = self.close()
            guess = attrs.evolve(guess, products=guess.products + (0 if full is None else 1))
            if full is not None and full.is_closed(task.pressure_limit):
                return attrs.evolve(guess, pressure=full.closing, closed=True, met_limit=False)
            if full is not None and full.inverse.exact and self.opens_cells:
                nearly_full = attrs.evolve(full, gap=np.where(is_open, gap, np.float32(0.0)))
                # The pressure follows from that of full contact and the gap.
                return attrs.evolve(guess, pressure=full.closing, closed=False, nearly_full=nearly_full)
        fine = interpolate(pressure, fx, fy)
        np.maximum(fine, 0.0, out=fine)
        np.copyto(fine, 0.0, where=is_open)
        met_limit = guess.met_limit
        if task.capped:
            # Parabolas overshoot.
            met_limit = met_limit or bool((fine > task.pressure_limit).any())
            np.copyto(fine, task.pressure_limit, where=repeat_cells(pressure >= coarse.task.pressure_limit, fx, fy))
            np.minimum(fine, task.pressure_limit, out=fine)
        return attrs.evolve(guess, pressure=fine, closed=False, met_limit=met_limit)


@guarded
def estimate_approach(convolution: PreparedConvolution, task: Task) -> tuple[float | None, bool]:
    """Return the approach at the load of a task from a coarse grid, and whether the limit shortened a step.

    Returns
    -------
    approach : float or None
        The approach to about 2 %, in the variables of the task; `None` if there is no coarse grid.
    met_limit : bool
        Whether the pressure limit shortened a step.

    Examples
    --------
    >>> import roughcontact as rc
    >>> from roughcontact.solving import estimate_approach, make_task
    >>> from roughcontact.typing import Load
    >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
    >>> problem = rc.ContactProblem(ball, grid=rc.Grid((256, 256), 400e-6))
    >>> task = make_task(problem.plan, problem.initial_gap, Load.of(pressure=62.5e6))
    >>> approach, _ = estimate_approach(problem.convolution, task)
    >>> print(f"{approach * problem.plan.peak_to_valley * 1e6:.2f} um")
    1.02 um
    """
    if task.approach is not None:
        return task.approach, False
    half = coarsen(convolution.setup.grid, attrs.evolve(task, start=None))
    if half is None:
        return None, False
    while max(half[0].shape) > _MAX_ESTIMATE_CELLS and (coarser := coarsen(*half)) is not None:
        half = coarser
    coarse = convolution.on(half[0])
    coarse_task = half[1]
    monitor = Monitor(coarse_task, _ESTIMATE_TOLERANCE, _ESTIMATE_ITERATIONS)
    refinement = PressureRefinement(coarse, coarse_task, monitor)
    _, violation, _ = refinement.run(PressureOnGrid(coarse, coarse_task).begin().pressure)
    return violation.approach, refinement.met_limit


@attrs.frozen(eq=False)
class Window:
    """A rectangle of cells outside which a free domain cannot touch.

    Pressure moves every cell away from the other body: with K and p not negative the gap is at least h - approach, so
    that contact needs an initial gap h below the approach. Beside a load an incompressible layer bulges: K is negative.
    """

    rows: slice
    columns: slice

    def restrict(self, values: Array) -> Array:
        """Return the field inside the window."""
        return values[self.rows, self.columns].copy()

    def embed(self, values: Array, shape: tuple[int, int]) -> Array:
        """Return a field of the grid's shape that is zero outside the window."""
        field = np.zeros(shape, like=values)
        field[self.rows, self.columns] = values
        return field

    def task(self, task: Task) -> Task:
        """Return the same task for the cells inside: the same load, limit and start."""
        inside = self.restrict(task.initial_gap)
        mean = task.mean_pressure
        limit = task.pressure_limit
        return attrs.evolve(
            task,
            initial_gap=inside,
            mean_pressure=None if mean is None else mean * (task.initial_gap.size / inside.size),
            pressure_limit=limit if limit.size == 1 else self.restrict(limit),
            start=None if task.start is None else self.restrict(task.start),
            on_step=self._report_to(task, inside.shape),
        )

    @staticmethod
    def _report_to(task: Task, inside: tuple[int, int]) -> Callable[[Step], None] | None:
        """Return a function for the steps inside, which reports them as steps of the whole grid."""
        tell = task.on_step
        if tell is None:
            return None
        whole = task.initial_gap.shape
        return lambda step: tell(attrs.evolve(step, shape=whole) if step.shape == inside else step)

    def convolution(self, convolution: PreparedConvolution) -> PreparedConvolution:
        """Return the convolution of the cells inside."""
        return convolution.within(self.rows, self.columns)

    def contains_contact(self, initial_gap: Array, approach: float) -> bool:
        """Return whether no cell outside can touch at an approach."""
        touching = initial_gap < approach
        inside = np.count_nonzero(touching[self.rows, self.columns])
        return bool(np.count_nonzero(touching) == inside)


@attrs.frozen(eq=False)
class GridSolution:
    """The outcome on one grid, the approach of its pressure, and whether the pressure limit shortened any step.

    Attributes
    ----------
    outcome
        Pressure and work.
    approach
        Approach at this pressure, in the variables of the task.
    met_limit
        Whether the pressure limit shortened any step.
    """

    outcome: Outcome
    approach: float
    met_limit: bool = False


@guarded
def solve_in_window(
    convolution: PreparedConvolution,
    task: Task,
    solve: Callable[[PreparedConvolution, Task], GridSolution],
    estimate: Callable[[PreparedConvolution, Task], tuple[float | None, bool]] = estimate_approach,
) -> GridSolution:
    """Solve a contact on the part of a free domain that can touch, or on all of it.

    Parameters
    ----------
    convolution
        The convolution of all cells.
    task
        The contact.
    solve
        Return the solution on all cells of a convolution.
    estimate
        Return about the approach and whether the pressure limit shortened a step, as `estimate_approach` does; instead
        of the approach `None`: take all cells. Where it is too low, the window is enlarged.

    Returns
    -------
    GridSolution
        The solution, its pressure zero outside the part.

    Examples
    --------
    >>> import roughcontact as rc
    >>> from roughcontact.solving import GridSolution, make_task, solve_in_window
    >>> from roughcontact.typing import Load
    >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
    >>> problem = rc.ContactProblem(ball, grid=rc.Grid((256, 256), 400e-6))
    >>> def solve(convolution, task):
    ...     print(task.initial_gap.shape)
    ...     return GridSolution(rc.SpectralGradient().solve(convolution, task), task.approach)
    >>> task = make_task(problem.plan, problem.initial_gap, Load.of(approach=1e-7))
    >>> found = solve_in_window(problem.convolution, task, solve)
    (32, 32)
    >>> found.outcome.pressure.shape
    (256, 256)
    """
    if not convolution.setup.boundary.has_free_axis:
        return solve(convolution, task)
    approach, met_limit = estimate(convolution, task)
    while approach is not None and (window := find_window(convolution, task, approach)) is not None:
        found = solve(window.convolution(convolution), window.task(task))
        approach = found.approach
        met_limit = met_limit or found.met_limit
        pressure = window.embed(found.outcome.pressure, task.initial_gap.shape)
        if not found.outcome.status.success or window.contains_contact(task.initial_gap, approach):
            return GridSolution(attrs.evolve(found.outcome, pressure=pressure), approach, met_limit)
        # The estimate was too low: the next window is larger, and starts from this pressure.
        task = attrs.evolve(task, start=pressure)
    found = solve(convolution, task)
    return attrs.evolve(found, met_limit=met_limit or found.met_limit)


def find_window(convolution: PreparedConvolution, task: Task, approach: float) -> Window | None:
    """Return the window of the cells that can touch at about this approach; None if it saves nothing."""
    if not convolution.setup.boundary.has_free_axis:
        return None
    touching = task.initial_gap <= _APPROACH_MARGIN * approach
    if not touching.any() or _bulges(convolution, task):
        return None
    rows, columns = (
        _extent(np.flatnonzero(touching.any(axis=1 - axis)), count) if free else slice(0, count)
        for axis, (count, free) in enumerate(zip(touching.shape, convolution.setup.boundary.free_axes, strict=True))
    )
    if touching[rows, columns].size > _MAX_WINDOW_FRACTION * touching.size:
        return None
    capacity = np.sum(np.broadcast_to(task.pressure_limit, touching.shape)[rows, columns])
    mean = task.mean_pressure
    return Window(rows, columns) if mean is None or mean * task.initial_gap.size <= capacity else None


def _bulges(convolution: PreparedConvolution, task: Task) -> bool:
    """Return whether pressure on a cell moves others towards the other body, as on no homogeneous half-space."""
    setup = convolution.setup
    wavenumbers = np.array([1.0 / max(setup.grid.size), 1.0 / min(setup.grid.spacing)])
    if setup.kernel.kernel.effective_modulus(wavenumbers, setup.kernel.compliance) is None:
        return False
    load = np.zeros(task.initial_gap.shape, like=task.initial_gap)
    load[0, 0] = 1.0
    response = convolution.apply(load)
    return float(-response[response < 0.0].sum()) > _MAX_BULGE * float(response.max())


def _extent(marked: IntArray, count: int) -> slice:
    """Return a range of `count` cells that contains the marked ones, `_WINDOW_MULTIPLE` times a whole number long."""
    first = int(marked[0])
    last = int(marked[-1]) + 1
    length = min(-(-(last - first + 2) // _WINDOW_MULTIPLE) * _WINDOW_MULTIPLE, count)
    start = min(max(first - (length - (last - first)) // 2, 0), count - length)
    return slice(start, start + length)
