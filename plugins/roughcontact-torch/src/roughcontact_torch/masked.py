"""The masked solver: nested grids, verification in float64, and many contacts at once."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from functools import partial
from typing import Any, ClassVar, NamedTuple, cast

import attrs
import numpy as np
import roughcontact as rc
import torch
import torch.nn.functional as functional
from roughcontact.solving import GridLevel, GridSolution, estimate_approach, halve_shape, solve_in_window
from roughcontact.typing import Array, Outcome, PreparedConvolution, Step, Task

from roughcontact_torch.arrays import TensorArray
from roughcontact_torch.convolver import TensorConvolution
from roughcontact_torch.graph import GraphedIteration, record_graph
from roughcontact_torch.masked_descent import MaskedDescent, State
from roughcontact_torch.masked_grid import Blocks

# Iterations on a coarse grid and on the coarsest one, with those after which, for a given approach, weights and rigid
# motions are computed anew; iterations between two readings of the host on average, and the maximum at once.
_COARSE_ITERATIONS = (4, 2)
_COARSEST_ITERATIONS = (8, 1)
_ITERATIONS_OF_READING = 4
_MAX_ROUND = 8
# Goals of the first round and of later ones, over the tolerance, their minimum factor on the error in float32, and the
# range of factors of an iteration on the error, from which the length of a round is predicted.
_FIRST_GOAL_FRACTION = 0.3
_GOAL_FRACTION = 0.7
_FLOAT32_GAIN = 2e-5
_FASTEST = 0.02
_SLOWEST = 0.3
# Changed cells before weights are computed anew, over the active or, if these are fewer, the passive cells plus a
# fraction of the grid, as in the default solver.
_MAX_CHANGED_FRACTION = 0.5
_PASSIVE_ALLOWANCE = 0.02
# Peak memory of a solve in float64 arrays of the grid, periodic and with a free axis, measured on a processor; see
# tests/test_memory.py.
_ARRAYS = {False: 19.0, True: 23.6}
# Maximum cells a side of the grid that the host takes to estimate the approach.
_MAX_HOST_CELLS = 128
# Minimum cells of a grid that the core halves to estimate an approach.
_MIN_HALVED_CELLS = 2**13
# Verifications in turn that do not halve the error after which the default solver continues.
_MAX_IDLE_ROUNDS = 3
_DEFAULT = rc.ProjectedConjugateGradient()

# Contacts that were solved at once, and are now certified one by one.
_SOLVED: ContextVar[tuple[tuple[Task, Outcome], ...]] = ContextVar("solved contacts", default=())


def _as_tolerance(value: float) -> float:
    return attrs.evolve(_DEFAULT, tolerance=value).tolerance


def _as_iterations(value: int) -> int:
    return attrs.evolve(_DEFAULT, max_iterations=value).max_iterations


class _Guess(NamedTuple):
    """Pressures to start from, and the errors at both ends of the last coarse grid; None: there was none."""

    pressure: torch.Tensor
    levels: tuple[GridLevel, ...]
    errors: tuple[torch.Tensor, torch.Tensor] | None = None
    closed: torch.Tensor | None = None


@attrs.define
class _Progress:
    """The errors of contacts by verification, as the host knows them.

    Attributes
    ----------
    tolerance
        Error to be reached.
    factors
        Factor of an iteration on the error of each contact.
    floors
        Errors by rounding.
    errors
        Errors of all contacts by verification.
    idle
        Verifications in turn that did not halve the error of each contact.
    iterations
        Iterations so far.
    """

    tolerance: float
    factors: list[float]
    floors: list[float]
    errors: list[tuple[float, ...]]
    idle: list[int] = attrs.field(init=False)
    iterations: int = 0

    def __attrs_post_init__(self) -> None:
        self.idle = [0] * len(self.floors)

    @property
    def unfinished(self) -> list[int]:
        """The contacts that are neither solved nor given up."""
        numbers = enumerate(zip(self.errors[-1], self.floors, self.idle, strict=True))
        return [
            k
            for k, (error, floor, idle) in numbers
            if max(self.tolerance, floor) < error < math.inf and idle <= _MAX_IDLE_ROUNDS
        ]

    def count_iterations(self) -> int:
        """Return after how many iterations the errors are worth a verification; seldom less than four."""
        needed = [self._predict(self.errors[-1][k], self.factors[k]) for k in self.unfinished]
        return max(*needed, _ITERATIONS_OF_READING * len(self.errors) - self.iterations)

    def record(self, errors: list[float], floors: list[float], iterations: int) -> None:
        """Add what a verification has found after further iterations."""
        self.iterations += iterations
        halved = [one < 0.5 * other for one, other in zip(errors, self.errors[-1], strict=True)]
        self.idle = [0 if better else idle + 1 for better, idle in zip(halved, self.idle, strict=True)]
        self.errors.append(tuple(errors))
        self.floors = floors
        first = self.errors[0]
        self.factors = [_factor(one, other, self.iterations) for one, other in zip(first, errors, strict=True)]

    def _predict(self, error: float, factor: float) -> int:
        fraction = _GOAL_FRACTION if self.iterations else _FIRST_GOAL_FRACTION
        goal = max(fraction * self.tolerance, _FLOAT32_GAIN * error)
        return min(max(math.ceil(math.log(goal / error) / math.log(factor)), 1), _MAX_ROUND)


@attrs.frozen(eq=False)
class _Solved:
    """Pressures and approaches, by verification their errors, floors of rounding, and the work."""

    pressure: torch.Tensor
    approaches: tuple[float, ...]
    errors: tuple[tuple[float, ...], ...]
    floors: tuple[float, ...]
    levels: tuple[GridLevel, ...]

    def outcome(self, k: int, tolerance: float) -> Outcome:
        """Return the outcome of one contact, its pressure on the device."""
        finest = self.levels[-1].shape
        cells = finest[0] * finest[1]
        cost = sum((one.double + one.single + one.inverse) * math.prod(one.shape) / cells for one in self.levels)
        error = self.errors[-1][k]
        done = error <= max(tolerance, self.floors[k])
        status = rc.Status.CONVERGED.within(self.floors[k], tolerance) if done else rc.Status.STALLED
        return Outcome(
            pressure=cast(Any, TensorArray(self.pressure[k])),
            status=status if math.isfinite(error) else rc.Status.NOT_FINITE,
            iterations=self.levels[-1].iterations,
            convolutions=round(cost),
            errors=tuple(errors[k] for errors in self.errors),
            levels=self.levels,
        )


@attrs.frozen
class MaskedConjugateGradient(rc.Solver):
    """The default solver on a GPU whose host waits for a number in one of four iterations, and on each coarse grid.

    Active cells are a mask instead of a list, searches have a fixed number of rounds, and the device chooses which part
    of a step is taken. It solves on the tensors of `TorchFFT` alone. The default solver, on tensors too, solves for a
    limit that differs from cell to cell, and continues where the error no longer falls.

    Parameters
    ----------
    tolerance
        Error (see `Violation`) to be reached.
    max_iterations
        Iterations on the finest grid after which the default solver continues.
    compiled
        Whether torch first compiles the iteration, once for each grid and kind of problem in a process: for about half
        a minute each, and of at most eight. On a GPU each solve then records it as a CUDA graph for each grid.

    References
    ----------
    Polonsky, Keer, Wear 231 (1999) 206-219, https://doi.org/10.1016/S0043-1648(99)00113-1

    Examples
    --------
    >>> import roughcontact as rc
    >>> from roughcontact_torch import MaskedConjugateGradient, TorchFFT
    >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
    >>> tensors = {"convolver": TorchFFT("cpu"), "solver": MaskedConjugateGradient()}
    >>> problem = rc.ContactProblem(ball, grid=rc.Grid((64, 64), 100e-6), **tensors)
    >>> print(problem.solve(force=1.0).status)
    converged: the conditions of contact hold within the tolerance
    """

    omitted: ClassVar[tuple[str, ...]] = (
        "lists of active cells: masks have fixed shapes, so that the host waits for a number in one of four iterations",
        rc.ProjectedConjugateGradient.omitted[0],
    )

    tolerance: float = attrs.field(default=_DEFAULT.tolerance, converter=_as_tolerance)
    max_iterations: int = attrs.field(default=80, converter=_as_iterations)
    compiled: bool = attrs.field(default=False, kw_only=True, validator=attrs.validators.instance_of(bool))

    def memory_arrays(self, boundary: rc.Boundary) -> float:
        """Return the peak memory of a solve, on the device, in float64 arrays of the grid."""
        return _ARRAYS[boundary.has_free_axis]

    def solve(self, convolution: PreparedConvolution, task: Task) -> Outcome:
        """Return the contact pressure; see `Solver.solve`."""
        for known, outcome in _SOLVED.get():
            if _is_same(known, task):
                return outcome
        return self.solve_all(convolution, [task])[0]

    def solve_all(self, convolution: PreparedConvolution, tasks: Sequence[Task]) -> list[Outcome]:
        """Return the contact pressures of tasks on one grid, which are solved at once; see `solve_on_device`."""
        outcomes = self.solve_on_device(convolution, tasks)
        return [attrs.evolve(one, pressure=convolution.to_numpy(one.pressure)) for one in outcomes]

    def solve_on_device(self, convolution: PreparedConvolution, tasks: Sequence[Task]) -> list[Outcome]:
        """Return the contact pressures of tasks on one grid, which are solved at once, as arrays of tensors.

        Raises
        ------
        InputError
            If the convolution is not on tensors, or loads and approaches are mixed.
        """
        if not isinstance(convolution, TensorConvolution):
            raise rc.InputError("The masked solver works on tensors: choose convolver='torch'.")
        if len({task.mean_pressure is None for task in tasks}) > 1:
            raise rc.InputError("Contacts that are solved at once must all have a load, or all an approach.")
        default = attrs.evolve(_DEFAULT, tolerance=self.tolerance)
        if any(task.pressure_limit.size > 1 for task in tasks):
            outcomes = [default.solve(convolution, task) for task in tasks]
        else:
            outcomes = []
            for task, found in zip(tasks, self._solve_in_windows(convolution, tasks), strict=True):
                ended = found.status.success or not convolution.serves_default
                outcomes.append(found if ended else _continue(default, convolution, task, found))
        return [attrs.evolve(one, pressure=convolution.from_numpy(one.pressure)) for one in outcomes]

    def _solve_in_windows(self, convolution: TensorConvolution, tasks: Sequence[Task]) -> list[Outcome]:
        """Return the outcomes; a single contact is solved on the cells that can touch alone."""
        if len(tasks) > 1 or not convolution.serves_default:
            solved = self._solve(convolution, tasks)
            return [solved.outcome(k, self.tolerance) for k in range(len(tasks))]

        def solve(part: PreparedConvolution, task: Task) -> GridSolution:
            found = self._solve(cast(TensorConvolution, part), [task])
            return GridSolution(found.outcome(0, self.tolerance), found.approaches[0])

        task = tasks[0].convert(convolution.from_numpy)
        return [solve_in_window(convolution, task, solve, _estimate_approach).outcome]

    def _solve(self, convolution: TensorConvolution, tasks: Sequence[Task]) -> _Solved:
        descents = _make_descents(convolution, tasks)
        shape = descents[0].grid.shape
        starts = [task.start for task in tasks if task.start is not None]

        def report(iterations: int, error: float) -> None:
            for task in tasks:
                if task.on_step is not None:
                    task.on_step(Step(shape, iterations, error))

        if len(starts) == len(tasks):
            return self._finish(descents[0], _Guess(_stack(convolution, starts), ()), report)
        return self._finish(descents[0], self._nest(descents), report)

    def _nest(self, descents: list[MaskedDescent]) -> _Guess:
        """Return pressures on the finest grid, interpolated from those on the next one, itself solved so.

        Only the finest descent is left: the others take memory.
        """
        coarsest = descents[-1]
        guess = _Guess(torch.zeros_like(coarsest.initial_gap), ())
        if coarsest.load is not None:
            mean = coarsest.load / coarsest.grid.cells
            guess = _close(coarsest, guess._replace(pressure=guess.pressure + torch.minimum(mean, coarsest.limit)))
        while len(descents) > 1:
            guess = self._approximate(descents.pop(), descents[-1], guess)
        return guess

    def _approximate(self, coarse: MaskedDescent, fine: MaskedDescent, guess: _Guess) -> _Guess:
        """Return pressures for the next finer grid after iterations on a coarse one."""
        grid = coarse.grid
        pressure = guess.pressure if coarse.load is None else coarse.rescale(guess.pressure)
        state, verified = coarse.start(pressure, grid.displace(pressure.to(torch.float32)))
        closed = torch.zeros_like(verified.error) if guess.closed is None else guess.closed.to(torch.float64)
        means, solved = grid.read(grid.mean_weight(state.weights), closed)
        iterations = renewals = 0
        if not all(solved):
            blocks = grid.blocks(max(means))
            iterate = self._iteration(coarse, blocks)
            coarsest = not any(level.iterations for level in guess.levels)
            iterations, renewed = _COARSEST_ITERATIONS if coarsest else _COARSE_ITERATIONS
            for k in range(iterations):
                if coarse.load is None and k % renewed == 0 and k:
                    # Far from the given approach the active cells, and with them the rigid motion, change at each step.
                    state = coarse.renew(state)
                    renewals += 1
                state = iterate(state)
        work = _count_work(coarse, iterations, 1 + renewals)
        levels = (*guess.levels, attrs.evolve(work, single=work.single + 1))
        errors = (verified.error, coarse.estimate(state, verified.scale))
        finer = _Guess(_refine(coarse, fine, state), levels, errors)
        return _close(fine, finer) if any(solved) else finer

    def _finish(self, descent: MaskedDescent, guess: _Guess, report: Callable[[int, float], None]) -> _Solved:
        """Return the solutions on the finest grid from a guess."""
        grid = descent.grid
        pressure = guess.pressure if descent.load is None else descent.rescale(guess.pressure)
        levels = guess.levels
        estimates = guess.errors
        # Fields that are no longer needed take memory.
        del guess
        state, verified = descent.start(pressure, grid.displace(pressure))
        del pressure
        mean = grid.mean_weight(state.weights).amax(keepdim=True).expand_as(verified.error)
        coarse = estimates if estimates is not None else (verified.error, verified.error)
        now, floors, approaches, before, after, means = grid.read(
            verified.error, verified.floor, verified.approach, *coarse, mean
        )
        # On the last coarse grid the error fell as it will here.
        factors = [_factor(one, other, _COARSE_ITERATIONS[0]) for one, other in zip(before, after, strict=True)]
        progress = _Progress(self.tolerance, factors, floors, [tuple(now)])
        blocks = grid.blocks(means[0])
        iterate = self._iteration(descent, blocks)
        best = verified.error
        approach = verified.approach
        found = state.pressure
        renewals = 0
        while True:
            report(progress.iterations, max(progress.errors[-1]))
            if not progress.unfinished or progress.iterations >= self.max_iterations:
                break
            count = progress.count_iterations()
            for _ in range(count):
                state = iterate(state)
            state, verified = descent.verify(state)
            # A contact that is solved keeps its pressure while the others go on.
            better = (verified.error < best) & (best > self.tolerance)
            found = torch.where(better, state.pressure, found)
            approach = torch.where(better, verified.approach, approach)
            best = torch.where(better, verified.error, best)
            now, floors, approaches, changed = grid.read(
                best, verified.floor, approach, _changed_fraction(descent, state)
            )
            progress.record(now, floors, count)
            if any(changed[k] > _MAX_CHANGED_FRACTION for k in progress.unfinished):
                state = descent.renew(state)
                renewals += 1
        work = _count_work(descent, progress.iterations, 1 + renewals)
        level = attrs.evolve(work, double=len(progress.errors))
        return _Solved(found, tuple(approaches), tuple(progress.errors), tuple(progress.floors), (*levels, level))

    def _iteration(self, descent: MaskedDescent, blocks: Blocks) -> Callable[[State], State]:
        """Return the iteration on a grid, in the form that was asked for."""
        if not self.compiled:
            return partial(descent.iterate, blocks=blocks)
        iterate = partial(torch.compile(descent.iterate, dynamic=False), blocks=blocks)
        return GraphedIteration(iterate, record_graph) if descent.initial_gap.is_cuda else iterate


def _estimate_approach(convolution: PreparedConvolution, task: Task) -> tuple[float | None, bool]:
    """Return about the approach; found on the host: on few cells the calls of a device take longer than the work."""
    if task.approach is not None:
        return task.approach, False
    tensors = cast(TensorConvolution, convolution)
    grid = tensors.setup.grid
    shape = grid.shape
    half = halve_shape(shape)
    # The core halves at least once more.
    while max(shape) > _MAX_HOST_CELLS and half[0] * half[1] >= _MIN_HALVED_CELLS and halve_shape(half) != half:
        shape = half
        half = halve_shape(half)
    sizes = (grid.shape[0] // shape[0], grid.shape[1] // shape[1])
    gap = functional.avg_pool2d(_stack(tensors, [task.initial_gap]), sizes)[0].numpy(force=True)
    small = attrs.evolve(task, initial_gap=gap, pressure_limit=tensors.to_numpy(task.pressure_limit), start=None)
    return estimate_approach(tensors.on_host(rc.Grid(shape, grid.size)), small)


def _factor(before: float, after: float, iterations: int) -> float:
    """Return the factor of an iteration on the error."""
    ratio = after / before if before > 0.0 and after > 0.0 else 1.0
    return min(max(ratio ** (1.0 / iterations), _FASTEST), _SLOWEST)


def _changed_fraction(descent: MaskedDescent, state: State) -> torch.Tensor:
    """Return the cells that changed since weights were computed by a product, over the fewer of active and passive."""
    cells = descent.grid.cells
    active = descent.grid.total(state.active)
    return state.changed / torch.minimum(active, cells - active + _PASSIVE_ALLOWANCE * cells).clamp(min=1.0)


def _count_work(descent: MaskedDescent, iterations: int, renewals: int) -> GridLevel:
    """Return the work of iterations, and of products for weights."""
    rigid = 0 if descent.load is not None else 2
    near = descent.grid.takes_stencil
    inverse = iterations + renewals + (0 if near else iterations)
    return GridLevel(descent.grid.shape, iterations, 0, iterations + rigid * renewals, inverse)


def _close(descent: MaskedDescent, guess: _Guess) -> _Guess:
    """Return the pressures that close every gap of a periodic surface where they are within the bounds."""
    closing = descent.close()
    if closing is None:
        return guess
    grid = descent.grid
    closed = (grid.lowest(closing) >= 0.0) & (grid.highest(closing) <= descent.limit)
    level = GridLevel(grid.shape, 0, 0, 0, 1)
    return guess._replace(
        pressure=torch.where(closed, closing, guess.pressure), closed=closed, levels=(*guess.levels, level)
    )


def _refine(coarse: MaskedDescent, fine: MaskedDescent, state: State) -> torch.Tensor:
    """Return pressures on a grid, interpolated where the coarser one is in contact or the gap is negative."""
    grid = fine.grid
    displacement = coarse.from_level(state) - coarse.initial_gap.to(torch.float32)
    gap = grid.interpolate(displacement) + fine.initial_gap.to(torch.float32)
    is_open = (gap >= 0.0) & ~grid.repeat(state.pressure > 0.0)
    pressure = torch.clamp(grid.interpolate(state.pressure), min=0.0)
    pressure = torch.where(is_open, 0.0, pressure)
    if fine.capped:
        pressure = torch.where(grid.repeat(state.pressure >= coarse.limit), fine.limit, pressure)
        pressure = torch.minimum(pressure, fine.limit)
    return pressure


def _make_descents(convolution: TensorConvolution, tasks: Sequence[Task]) -> list[MaskedDescent]:
    """Return the descents of tasks of one shape and one kind of load, from the finest grid to the coarsest."""
    gap = _stack(convolution, [task.initial_gap for task in tasks])

    def numbers(values: Sequence[float | None]) -> torch.Tensor:
        known = [math.nan if value is None else value for value in values]
        return torch.tensor(known, dtype=torch.float64, device=gap.device).reshape(-1, 1, 1)

    mean = numbers([task.mean_pressure for task in tasks])
    given = numbers([task.rms_gap for task in tasks])
    approach = numbers([task.approach for task in tasks])
    limit = numbers([float(task.pressure_limit) for task in tasks])
    capped = any(task.capped for task in tasks)
    loaded = tasks[0].mean_pressure is not None
    descents = []
    for grid in convolution.nested_grids():
        gap = grid.average(gap)
        center = grid.total(gap) / grid.cells
        own = (grid.total((gap - center) ** 2) / grid.cells).sqrt()
        rms = torch.where(torch.isnan(given), own, given)
        load = mean * grid.cells if loaded else None
        descents.append(MaskedDescent(grid, gap, limit, rms, load, approach, capped))
    return descents


def _continue(
    default: rc.ProjectedConjugateGradient, convolution: TensorConvolution, task: Task, stalled: Outcome
) -> Outcome:
    """Return the outcome of the default solver from the pressure of a masked descent that did not end."""
    start = stalled.pressure if stalled.status is rc.Status.STALLED else None
    rescue = default.solve(convolution, attrs.evolve(task, start=start))
    return attrs.evolve(
        rescue,
        status=rc.Status.RESCUED if rescue.status is rc.Status.CONVERGED else rescue.status,
        iterations=stalled.iterations + rescue.iterations,
        convolutions=stalled.convolutions + rescue.convolutions,
        errors=stalled.errors + rescue.errors,
        levels=stalled.levels,
    )


@contextmanager
def known_outcomes(outcomes: Sequence[tuple[Task, Outcome]]) -> Iterator[None]:
    """Let the masked solver return these outcomes for these tasks until the end."""
    token = _SOLVED.set(tuple(outcomes))
    try:
        yield
    finally:
        _SOLVED.reset(token)


def _is_same(known: Task, task: Task) -> bool:
    """Return whether two tasks of one convolution, both of a given load, are the same."""
    pairs = ((known.initial_gap, task.initial_gap), (known.pressure_limit, task.pressure_limit))
    return known.mean_pressure == task.mean_pressure and all(np.array_equal(*pair) for pair in pairs)


def _stack(convolution: TensorConvolution, fields: Sequence[Array]) -> torch.Tensor:
    """Return fields of numpy on the device, along a leading axis."""
    return torch.stack([cast(torch.Tensor, cast(Any, convolution.from_numpy(field)).tensor) for field in fields])
