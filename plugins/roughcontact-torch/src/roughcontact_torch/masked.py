"""The masked solver: nested grids, verification in float64, and many loads at once."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import ClassVar, cast

import attrs
import roughcontact as rc
import torch
from roughcontact.typing import Array, GridLevel, Load, Outcome, PreparedConvolution, Step, Task, make_task

from roughcontact_torch.arrays import TensorArray
from roughcontact_torch.convolver import TensorConvolution
from roughcontact_torch.masked_descent import MaskedDescent, State
from roughcontact_torch.masked_grid import Blocks, MaskedGrid

# Minimum cells along a halved axis, iterations on the coarsest grid and on each other coarse one, and between two
# verifications: the host reads a number after so many.
_MIN_COARSE_CELLS = 32
_COARSEST_ITERATIONS = 8
_ROUND = 4
# Verifications that do not halve the error after which the default solver continues.
_MAX_IDLE_ROUNDS = 3
_TOLERANCE = rc.ProjectedConjugateGradient().tolerance


@attrs.frozen(eq=False)
class _Batch:
    """Contacts on one grid that are solved at once, dimensionless, as `Task`; shapes (contacts, nx, ny) or (contacts, 1, 1)."""

    gap: torch.Tensor
    limit: torch.Tensor
    mean: torch.Tensor | None
    approach: torch.Tensor
    rms: torch.Tensor
    capped: bool

    @classmethod
    def of(cls, tasks: Sequence[Task]) -> _Batch:
        """Return tasks of one shape and one kind of load."""
        gap = torch.stack([_tensor(task.initial_gap) for task in tasks])
        device = gap.device

        def numbers(values: Sequence[float]) -> torch.Tensor:
            return torch.tensor(values, dtype=torch.float64, device=device).reshape(-1, 1, 1)

        loads = [task.mean_pressure for task in tasks if task.mean_pressure is not None]
        limits = [float(_tensor(task.pressure_limit)) for task in tasks]
        spread = [task.rms_gap for task in tasks]
        rms = gap.std((-2, -1), correction=0, keepdim=True) if None in spread else numbers(cast("list[float]", spread))
        return cls(
            gap=gap,
            limit=numbers(limits),
            mean=numbers(loads) if loads else None,
            approach=numbers([task.approach or 0.0 for task in tasks]),
            rms=rms,
            capped=any(math.isfinite(limit) for limit in limits),
        )

    def descent(self, grid: MaskedGrid) -> MaskedDescent:
        """Return the descent of these contacts on their grid."""
        load = None if self.mean is None else self.mean * (grid.shape[0] * grid.shape[1])
        return MaskedDescent(grid, self.limit, load, capped=self.capped)

    def halve(self, shape: tuple[int, int]) -> _Batch:
        """Return the contacts on a grid with one or both axes halved."""
        gap = self.gap
        for axis in (-2, -1):
            if gap.shape[axis] > shape[axis]:
                gap = gap.unflatten(axis, (shape[axis], 2)).mean(axis)
        return attrs.evolve(self, gap=gap)


@attrs.frozen(eq=False)
class _Solved:
    """Pressures, their errors and floors of rounding by contact, and the work."""

    pressure: torch.Tensor
    errors: tuple[tuple[float, ...], ...]
    floors: tuple[float, ...]
    levels: tuple[GridLevel, ...]

    def outcome(self, k: int, tolerance: float) -> Outcome:
        """Return the outcome of one contact."""
        finest = self.levels[-1].shape
        cells = finest[0] * finest[1]
        cost = sum(
            (one.double + one.single + one.inverse) * one.shape[0] * one.shape[1] / cells for one in self.levels
        )
        error = self.errors[-1][k]
        done = error <= max(tolerance, self.floors[k])
        status = rc.Status.CONVERGED.within(self.floors[k], tolerance) if done else rc.Status.STALLED
        return Outcome(
            pressure=cast(Array, TensorArray(self.pressure[k])),
            status=status if math.isfinite(error) else rc.Status.NOT_FINITE,
            iterations=self.levels[-1].iterations,
            convolutions=round(cost),
            errors=tuple(errors[k] for errors in self.errors),
            levels=self.levels,
        )


@attrs.frozen
class MaskedConjugateGradient(rc.Solver):
    """The default solver without a number that the host of a GPU waits for, but for one in four iterations.

    Active cells are a mask instead of a list, searches have a fixed number of rounds, steps that are taken in part or
    not at all are chosen by the device. It solves on the tensors of `TorchFFT` alone. What it does not solve, a limit
    that differs from cell to cell or an error that no longer falls, is left to the default solver.

    Parameters
    ----------
    tolerance
        Error (see `Violation`) to be reached.
    max_iterations
        Iterations on the finest grid after which the default solver continues.

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
        "lists of active cells: masks have fixed shapes, so that the host waits for no number but one in four iterations",
    )

    tolerance: float = attrs.field(default=_TOLERANCE, converter=lambda value: _check(tolerance=value).tolerance)
    max_iterations: int = attrs.field(default=80, converter=lambda value: _check(max_iterations=value).max_iterations)

    def solve(self, convolution: PreparedConvolution, task: Task) -> Outcome:
        """Return the contact pressure; see `Solver.solve`."""
        return self.solve_all(convolution, [task])[0]

    def solve_all(self, convolution: PreparedConvolution, tasks: Sequence[Task]) -> list[Outcome]:
        """Return the contact pressures of tasks on one grid, which are solved at once.

        Raises
        ------
        InputError
            If the convolution is not on tensors, or loads and approaches are mixed.
        """
        if not isinstance(convolution, TensorConvolution):
            raise rc.InputError("The masked solver works on tensors: choose convolver='torch'.")
        if len({task.mean_pressure is None for task in tasks}) > 1:
            raise rc.InputError("Contacts that are solved at once must all have a load, or all an approach.")
        default = rc.ProjectedConjugateGradient(self.tolerance)
        if any(task.pressure_limit.size > 1 for task in tasks):
            return [default.solve(convolution, task) for task in tasks]
        converted = [task.convert(convolution.from_numpy) for task in tasks]
        solved = self._solve(convolution, _Batch.of(converted), converted)
        outcomes = []
        for k, task in enumerate(tasks):
            outcome = solved.outcome(k, self.tolerance)
            outcome = attrs.evolve(outcome, pressure=convolution.to_numpy(outcome.pressure))
            outcomes.append(outcome if outcome.status.success else _continue(default, convolution, task, outcome))
        return outcomes

    def _solve(self, convolution: TensorConvolution, batch: _Batch, tasks: Sequence[Task]) -> _Solved:
        grid = MaskedGrid.of(convolution)
        descent = batch.descent(grid)
        given = [task.start for task in tasks]
        levels: tuple[GridLevel, ...] = ()
        if any(start is None for start in given):
            pressure, levels = _nest(convolution, batch)
        else:
            pressure = torch.stack([_tensor(start) for start in given])
        state = descent.start(pressure, torch.zeros_like(pressure, dtype=torch.float32))
        blocks = Blocks.of(grid, float(descent.mean_weight(state).mean()))
        best = torch.full_like(batch.limit, torch.inf)
        found = state.pressure
        errors: list[tuple[float, ...]] = []
        iterations = renewals = idle = 0
        while True:
            verified = descent.measure(state, batch.gap, batch.approach, batch.rms)
            # A contact that is solved keeps its pressure while the others go on.
            better = (verified.error < best) & (best > self.tolerance)
            found = torch.where(better, state.pressure, found)
            best = torch.where(better, verified.error, best)
            now, floors = torch.stack((best, verified.floor)).flatten(1).tolist()
            errors.append(tuple(now))
            idle = idle + 1 if len(errors) > 1 and max(errors[-1]) > 0.5 * max(errors[-2]) else 0
            for task in tasks[:1]:
                if task.on_step is not None:
                    task.on_step(Step(grid.shape, iterations, max(errors[-1])))
            done = all(one <= max(self.tolerance, floor) for one, floor in zip(errors[-1], floors, strict=True))
            finite = all(math.isfinite(one) for one in errors[-1])
            if done or not finite or idle > _MAX_IDLE_ROUNDS or iterations >= self.max_iterations:
                break
            renewals += iterations > 0
            state = _run(descent, state, blocks, _ROUND, renew=iterations > 0)
            iterations += _ROUND
        rigid = 0 if batch.mean is not None else 2
        inverse = 1 + iterations + (renewals if grid.takes_stencil else iterations)
        single = iterations + rigid * (1 + renewals)
        level = GridLevel(grid.shape, iterations, len(errors), single, inverse)
        return _Solved(found, tuple(errors), tuple(floors), (*levels, level))


def _check(**values: object) -> rc.ProjectedConjugateGradient:
    """Return the default solver with these parameters, which are checked."""
    return rc.ProjectedConjugateGradient(**values)  # type: ignore[arg-type]


def _run(descent: MaskedDescent, state: State, blocks: Blocks, iterations: int, *, renew: bool) -> State:
    """Return the state after some iterations, of which the first may compute weights anew."""
    for k in range(iterations):
        state = descent.iterate(state, blocks, renew=renew and k == 0)
    return state


def _nest(convolution: TensorConvolution, batch: _Batch) -> tuple[torch.Tensor, tuple[GridLevel, ...]]:
    """Return pressures to start from, of the next coarser grid or uniform, and the work on coarser grids."""
    shape = convolution.setup.grid.shape
    half = tuple(n // 2 if n % 2 == 0 and n // 2 >= _MIN_COARSE_CELLS else n for n in shape)
    if half == shape:
        mean = torch.zeros_like(batch.limit) if batch.mean is None else batch.mean
        return torch.minimum(mean, batch.limit) * torch.ones_like(batch.gap), ()
    coarse = cast(TensorConvolution, convolution.on(rc.Grid(half, convolution.setup.grid.size)))
    own = batch.halve(half)
    pressure, levels = _nest(coarse, own)
    grid = MaskedGrid.of(coarse)
    descent = own.descent(grid)
    gap = grid.displace(pressure.to(torch.float32)) + own.gap.to(torch.float32)
    state = descent.start(pressure, gap - own.approach.to(torch.float32) if batch.mean is None else gap)
    blocks = Blocks.of(grid, float(descent.mean_weight(state).mean()))
    iterations = _ROUND if levels else _COARSEST_ITERATIONS
    state = _run(descent, state, blocks, iterations, renew=False)
    rigid = 0 if batch.mean is not None else 2
    inverse = 1 + iterations + (0 if grid.takes_stencil else iterations)
    level = GridLevel(half, iterations, 0, 1 + iterations + rigid, inverse)
    return _refine(descent, state, own, batch), (*levels, level)


def _refine(descent: MaskedDescent, state: State, coarse: _Batch, fine: _Batch) -> torch.Tensor:
    """Return pressures on a grid, interpolated where the coarser one is in contact or the gap is negative."""
    shape = fine.gap.shape[-2:]
    gap = descent.from_level(state)
    contact = state.pressure > 0.0
    displacement = _interpolate(gap - coarse.gap.to(torch.float32), shape)
    is_open = (displacement + fine.gap.to(torch.float32) >= 0.0) & ~_repeat(contact, shape)
    pressure = torch.clamp(_interpolate(state.pressure, shape), min=0.0)
    pressure = torch.where(is_open, 0.0, pressure)
    if fine.capped:
        pressure = torch.where(_repeat(state.pressure >= coarse.limit, shape), coarse.limit, pressure)
        pressure = torch.minimum(pressure, coarse.limit)
    if fine.mean is None:
        return pressure
    load = fine.mean * (shape[0] * shape[1])
    return descent.project_to_load(pressure, load)


def _repeat(values: torch.Tensor, shape: Sequence[int]) -> torch.Tensor:
    for axis in (-2, -1):
        if shape[axis] > values.shape[axis]:
            values = values.repeat_interleave(2, axis)
    return values


def _interpolate(values: torch.Tensor, shape: Sequence[int]) -> torch.Tensor:
    """Interpolate by parabolas through three cell centres along the axes that were halved; the values repeat."""
    for axis in (-2, -1):
        if shape[axis] > values.shape[axis]:
            before = values.roll(1, axis)
            after = values.roll(-1, axis)
            first = 0.9375 * values + 0.15625 * before - 0.09375 * after
            second = 0.9375 * values + 0.15625 * after - 0.09375 * before
            values = torch.stack((first, second), axis if axis == -1 else -2).flatten(axis - 1, axis)
    return values


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


def solve_loads(problem: rc.ContactProblem, pressures: Sequence[float | str]) -> list[rc.ContactSolution]:
    """Return the certified solutions of a problem at several mean pressures, which are solved at once.

    Parameters
    ----------
    problem
        A problem on tensors, `TorchFFT`, and with the solver `MaskedConjugateGradient`.
    pressures
        Nominal mean pressures, Pa or with a unit.

    Raises
    ------
    InputError
        If the problem has another solver, or its bodies cannot carry a load.

    Examples
    --------
    >>> import roughcontact as rc
    >>> from roughcontact_torch import MaskedConjugateGradient, TorchFFT, solve_loads
    >>> surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=4e-6, longest=32e-6, seed=1)
    >>> body = rc.Body(surface, rc.Elastic("210GPa", 0.3))
    >>> tensors = {"convolver": TorchFFT("cpu"), "solver": MaskedConjugateGradient()}
    >>> problem = rc.ContactProblem(body, grid=rc.Grid((64, 64), 64e-6), boundary="periodic", **tensors)
    >>> low, high = solve_loads(problem, ["100MPa", "200MPa"])
    >>> low.area().value < high.area().value
    True
    """
    plan = problem.plan
    solver = plan.solver
    if not isinstance(solver, MaskedConjugateGradient):
        raise rc.InputError(f"Loads are solved at once by the masked solver, but the problem has {solver!r}.")
    loads = [Load.of(pressure=pressure) for pressure in pressures]
    tasks = [make_task(plan, plan.initial_gap, load) for load in loads]
    convolution = problem.convolution
    outcomes = solver.solve_all(convolution, tasks) if tasks else []
    unit = plan.modulus * plan.peak_to_valley / plan.grid.spacing[0]
    return [
        problem.solve(pressure=load.value, start=outcome.pressure * unit)
        for load, outcome in zip(loads, outcomes, strict=True)
    ]


def _tensor(values: object) -> torch.Tensor:
    return cast(TensorArray, values).tensor
