"""The solver interface: a dimensionless task in, a pressure out."""

from __future__ import annotations

import abc
import math
from collections.abc import Callable
from functools import cached_property
from typing import Any, ClassVar

import attrs
import numpy as np

from roughcontact._base.arrays import Array
from roughcontact._base.checks import Part, integer, number
from roughcontact._base.registry import Registry
from roughcontact._parts.grid import Boundary
from roughcontact._parts.interactions import BoundInteraction
from roughcontact._solve.convolvers import PreparedConvolution
from roughcontact._solve.solution import GridLevel, Status, standard_deviation
from roughcontact._solve.solvers.projection import LOAD_ROUNDING, project_to_load, rescale_to_load
from roughcontact.errors import InputError
from roughcontact.errors.door import guarded

# Error (see `Violation`) at which solvers end by default: areas and maximum pressures move by 3e-5 at most
# (docs/studies/tolerance.py), a tenth of the smallest uncertainty that an area is given.
DEFAULT_TOLERANCE = 1e-5
# Fraction of a solve that the coarse grids are counted as.
_COARSE_FRACTION = 0.1


@attrs.frozen
class Step:
    """The progress of a solver after one iteration.

    Attributes
    ----------
    shape
        Cells of the grid on which it iterates.
    iteration
        Iterations on that grid so far.
    error
        Error (see `Violation`), estimated or verified.
    """

    shape: tuple[int, int]
    iteration: int
    error: float

    def fraction(self, shape: tuple[int, int], tolerance: float) -> float:
        """Return the fraction of a solve on the grid of `shape` that is done, about: errors fall as a power."""
        if self.shape != shape or not 0.0 < self.error < math.inf:
            return 0.0
        digits = math.log(min(1.0, self.error)) / math.log(tolerance)
        return _COARSE_FRACTION + (1.0 - _COARSE_FRACTION) * min(1.0, digits)


def _as_limit(value: Any) -> Array:
    # Other arrays than numpy's keep their type.
    like = value if hasattr(value, "__array_function__") else None
    return np.asarray(value, dtype=np.float64, like=like)


@attrs.frozen(eq=False, kw_only=True)
class Task:
    """A dimensionless contact problem: lengths in cells, gaps in peak-to-valley heights, pressures in E* height / cell.

    Attributes
    ----------
    initial_gap
        Gap before deformation, shape (nx, ny), 0 to 1.
    mean_pressure
        Mean pressure, above zero and at most the mean of the limit; None if the approach is given.
    approach
        Approach since first touch, above zero; None if the mean pressure is given.
    pressure_limit
        Maximum pressure, an array that broadcasts to (nx, ny): one value, or one per cell; `inf` where
        there is none. A number is converted.
    rms_gap
        The standard deviation of the initial gap at the measured points; None: of all cells.
    start
        Pressure to start from, shape (nx, ny), within the bounds; None if there is none.
    interaction
        The attraction of the surfaces; None without adhesion. With it the mean pressure and the approach may have any
        sign, and the pressure to start from too.
    start_gap
        Gap of the pressure to start from, shape (nx, ny), at least zero, and zero where the surfaces touch: it decides,
        where `start` leaves open, which cells touch. For solvers of adhesion alone.
    on_step
        Called after each iteration, on coarse grids too.
    """

    initial_gap: Array
    mean_pressure: float | None = None
    approach: float | None = None
    pressure_limit: Array = attrs.field(default=math.inf, converter=_as_limit)
    rms_gap: float | None = None
    start: Array | None = None
    interaction: BoundInteraction | None = None
    start_gap: Array | None = None
    on_step: Callable[[Step], None] | None = None

    @cached_property
    def capped(self) -> bool:
        """Whether the pressure of any cell is limited."""
        return bool(np.isfinite(self.pressure_limit).any())

    @cached_property
    def rms(self) -> float:
        """The standard deviation of the initial gap, `rms_gap` if it is given."""
        return standard_deviation(self.initial_gap) if self.rms_gap is None else self.rms_gap

    def convert(self, convert: Callable[[Array], Array]) -> Task:
        """Return the same task with each of its arrays converted; itself where they stay as they are."""
        start = None if self.start is None else convert(self.start)
        gap = convert(self.initial_gap)
        limit = convert(self.pressure_limit)
        if gap is self.initial_gap and limit is self.pressure_limit and start is self.start:
            return self
        return attrs.evolve(self, initial_gap=gap, pressure_limit=limit, start=start)


@attrs.frozen(eq=False, kw_only=True)
class Outcome:
    """The result of a solver.

    Attributes
    ----------
    pressure
        Pressure, shape (nx, ny), between zero, or minus the tension, and the limit.
    status
        How the solve ended.
    iterations, convolutions
        Iterations, and convolutions on the finest grid or work of the same cost.
    errors
        Error (see `Violation`) at the start of each iteration.
    levels
        The work on each grid, from coarse to fine; may be empty.
    tension
        Tension of the interaction, shape (nx, ny), not negative, with which the pressure is minus the tension, to the
        last bit, where the surfaces do not touch; None without adhesion.
    """

    pressure: Array
    status: Status
    iterations: int
    convolutions: int
    errors: tuple[float, ...]
    levels: tuple[GridLevel, ...] = ()
    tension: Array | None = None

    def convert(self, convert: Callable[[Array], Array]) -> Outcome:
        """Return the same outcome with its pressure converted."""
        pressure = convert(self.pressure)
        return self if pressure is self.pressure else attrs.evolve(self, pressure=pressure)


class Solver(Part, abc.ABC):
    """A method to find the contact pressure, from a prepared convolution alone.

    Examples
    --------
    >>> import roughcontact as rc
    >>> class Careful(rc.Solver):
    ...     tolerance = 1e-10
    ...
    ...     def solve(self, convolution, task):
    ...         return rc.PolonskyKeer(tolerance=self.tolerance).solve(convolution, task)
    >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
    >>> solution = rc.ContactProblem(ball, grid=rc.Grid((32, 32), 100e-6), solver=Careful()).solve(force=1.0)
    >>> solution.residuals.error < 1e-10
    True
    """

    omitted: ClassVar[tuple[str, ...]] = ()
    """Steps that its solves omit and why, for ``explain()``."""

    climbs_grids: ClassVar[bool] = False
    """Whether its solves start on coarser grids (`halve_shape`), for ``explain()``."""

    adhesive: ClassVar[bool] = False
    """Whether it can treat an interaction of the surfaces, `Task.interaction`."""

    @property
    @abc.abstractmethod
    def tolerance(self) -> float:
        """The error (see `Violation`) below which a pressure counts as converged; a field may define it."""

    def require(self, *, capped: bool = False, approach: bool = False) -> None:
        """Raise `InputError` if this solver cannot treat a pressure limit, or a given approach; by default it can."""
        return

    def memory_arrays(self, boundary: Boundary) -> float | None:
        """Return the peak memory of a solve in float64 arrays of the grid; None, the default: that of the plan."""
        return None

    def with_tolerance(self, tolerance: float) -> Solver:
        """Return the same solver with another tolerance; override it if that is not a field of an attrs class."""
        solver: Any = self
        if not (attrs.has(type(self)) and "tolerance" in attrs.fields_dict(type(solver))):
            raise InputError(f"The tolerance of the solver {self!r} cannot be set.")
        changed: Solver = attrs.evolve(solver, tolerance=tolerance)
        return changed

    @abc.abstractmethod
    def solve(self, convolution: PreparedConvolution, task: Task) -> Outcome:
        """Return the contact pressure at the load or approach of the task.

        Raises
        ------
        InputError
            If this solver cannot treat such a task.
        """


solvers = Registry(Solver, "solver", "roughcontact.solvers")


@guarded
def starting_pressure(task: Task) -> Array:
    """Return the start of a task, or a uniform pressure within the limit, with its load; zero for an approach."""
    shape = task.initial_gap.shape
    limit = task.pressure_limit
    if task.mean_pressure is None:
        return np.zeros(shape, like=limit) if task.start is None else task.start
    start = np.minimum(np.full(shape, task.mean_pressure, like=limit), limit) if task.start is None else task.start
    load = task.mean_pressure * start.size
    if task.mean_pressure >= (1.0 - LOAD_ROUNDING) * float(limit.mean()):
        return np.broadcast_to(limit, shape).copy()
    if abs(float(np.add.reduce(start, axis=None)) - load) <= LOAD_ROUNDING * load:
        return start
    return rescale_to_load(start.copy(), load, limit)


@guarded
def nearest_pressure(values: Array, task: Task) -> Array:
    """Return the pressure nearest to a finite field within the bounds and with the load of the task, if it has one."""
    if task.mean_pressure is None:
        return np.clip(values, 0.0, task.pressure_limit)
    return project_to_load(values, task.mean_pressure, task.pressure_limit)


def positive_tolerance(value: float) -> float:
    """Return a tolerance, checked to be above zero."""
    return number(value, "The tolerance of the solver", above=0.0, at_most=1.0)


def iteration_limit(value: int) -> int:
    """Return a maximum number of iterations, checked to be at least one."""
    return integer(value, "The maximum number of iterations", at_least=1)
