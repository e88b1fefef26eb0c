"""The cycles of running in."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import attrs
import numpy as np

from roughcontact.body import Body
from roughcontact.checks import Array, Mask, instance_of, integer, number
from roughcontact.errors import InputError
from roughcontact.flattening import PermanentSet
from roughcontact.grid import Boundary
from roughcontact.problem import ContactProblem
from roughcontact.registry import sets
from roughcontact.relief import repeats
from roughcontact.running_in.record import Cycle, RunIn
from roughcontact.solution import ContactSolution
from roughcontact.surfaces import HeightMap
from roughcontact.surfaces.base import history_of

_is_problem = instance_of(ContactProblem, "What is run in", "a ContactProblem")


def run_in(
    problem: ContactProblem,
    *,
    pressure: float | None = None,
    force: float | None = None,
    model: str | PermanentSet = "overlap",
    shifts: Sequence[tuple[int, int]] = ((0, 0),),
    rounds: int = 20,
    tolerance: float = 1e-3,
    on_cycle: Callable[[RunIn], None] | None = None,
) -> RunIn:
    """Load, flatten and unload two bodies again and again until nothing more is flattened.

    Each cycle solves the contact, and what `model` says is taken from the heights: by the softer body,
    by both in halves where they are equally hard. Between the cycles of a round the other body moves
    on by whole cells, going round at the border, as a ring does under a ball.

    Parameters
    ----------
    problem
        The fresh bodies; at least one has a pressure limit.
    pressure, force
        Exactly one load, as in `ContactProblem.solve`. (An approach is counted from first touch, which
        flattening moves.)
    model
        Registered name or instance of a permanent set: ``"overlap"`` or ``"uniform-rise"``.
    shifts
        Cells (x, y) by which the other body is moved, from where it was, for each cycle of a round.
    rounds
        Most rounds.
    tolerance
        Shakedown is reached when a round flattens no more than this share of the volume so far.
    on_cycle
        Called after each cycle with the `RunIn` so far; its problem may be saved, and run in further.

    Returns
    -------
    RunIn
        The residual topographies and a record of the cycles.

    Raises
    ------
    InputError
        If neither body has a pressure limit, the load cannot be carried or flattens everything, the other
        body is moved although its heights do not repeat, or the model gives no lowering.
    NotConverged
        If a contact is not certified.
    """
    _is_problem(None, None, problem)
    chosen: PermanentSet = sets.resolve(model, PermanentSet)
    moves = _moves(shifts, problem)
    rounds = integer(rounds, "The number of rounds", at_least=1)
    tolerance = number(tolerance, "The tolerance of shakedown", at_least=0.0, at_most=1.0)
    if on_cycle is not None and not callable(on_cycle):
        raise InputError.about("What is called after each cycle, on_cycle=,", on_cycle, "a function")
    problem.require_load(pressure=pressure, force=force)
    state = _State(problem)
    cycles: list[Cycle] = []
    while True:
        for shift in moves:
            solution = state.shifted(shift).solve(pressure=pressure, force=force)
            cycles.append(state.flatten(solution, _lowering(chosen, solution), shift))
            shakedown = _settled(cycles, len(moves), tolerance)
            if on_cycle is not None:
                on_cycle(state.result(cycles, shakedown, solution))
        if shakedown or len(cycles) >= rounds * len(moves):
            return state.result(cycles, shakedown, solution)


class _State:
    """The heights of both bodies, changed from cycle to cycle."""

    def __init__(self, problem: ContactProblem) -> None:
        self._problem = problem
        self._grid = problem.plan.grid
        self._fresh = [side.heights(self._grid) for side in (problem.body, problem.counter)]
        self._holes = (problem.body.holes(self._grid), problem.counter.holes(self._grid))
        self._heights = [heights.copy() for heights in self._fresh]
        self._share = _share(problem)

    def shifted(self, shift: tuple[int, int]) -> ContactProblem:
        """Return the problem with the heights as they are and the other body moved on."""
        moved = None if self._holes[1] is None else np.roll(self._holes[1], shift, axis=(0, 1))
        counter = np.roll(self._heights[1], shift, axis=(0, 1))
        return self._with(self._heights[0], counter, (self._holes[0], moved), ((), ()))

    def flatten(self, solution: ContactSolution, lowering: Array, shift: tuple[int, int]) -> Cycle:
        """Take the lowering from both bodies and tell of it."""
        self._heights[0] -= self._share * lowering
        back = (-shift[0], -shift[1])
        self._heights[1] -= np.roll((1.0 - self._share) * lowering, back, axis=(0, 1))
        return Cycle(
            shift=shift,
            volume=float(np.maximum(lowering, 0.0).sum()) * self._grid.cell_area,
            deepest=max(float(lowering.max()), 0.0),
            area=solution.area(),
            saturated=solution.saturated_area(),
            approach=solution.approach,
        )

    def result(self, cycles: Sequence[Cycle], shakedown: bool, solution: ContactSolution) -> RunIn:
        """Return what has come out so far."""
        done = f"run in by {len(cycles)} cycles"
        sides = (self._problem.body, self._problem.counter)
        one, other = ((*history_of(side.surface), done) for side in sides)
        body, counter = (fresh - now for fresh, now in zip(self._fresh, self._heights, strict=True))
        return RunIn(
            problem=self._with(self._heights[0], self._heights[1], self._holes, (one, other)),
            cycles=tuple(cycles),
            shakedown=shakedown,
            lowered=(body, counter),
            solution=solution,
        )

    def _with(
        self,
        body: Array,
        counter: Array,
        holes: tuple[Mask | None, Mask | None],
        histories: tuple[tuple[str, ...], tuple[str, ...]],
    ) -> ContactProblem:
        if np.ptp(body + counter) == 0.0:
            raise InputError("The load has flattened everything, and nothing is left to run in: choose a smaller one.")
        periodic = self._problem.boundary is not Boundary.FREE
        sides = (self._problem.body, self._problem.counter)
        one, other = (
            Body(HeightMap(heights, self._grid.size, periodic=periodic, holes=holes, history=history), side.material)
            for heights, holes, history, side in zip((body, counter), holes, histories, sides, strict=True)
        )
        return attrs.evolve(self._problem, body=one, counter=other, grid=self._grid)


def _lowering(model: PermanentSet, solution: ContactSolution) -> Array:
    lowering = np.asarray(model.lowering(solution))
    if lowering.shape != solution.grid.shape or lowering.dtype.kind != "f" or not np.isfinite(lowering).all():
        raise InputError(
            f"The permanent set {model!r} must give finite real heights of shape {solution.grid.shape}, but gave an "
            f"array of shape {lowering.shape} and type {lowering.dtype}."
        )
    return lowering


def _share(problem: ContactProblem) -> float | Array:
    """Return the body's share of the flattening: all where it is softer, half where both are equal."""
    one, other = (np.asarray(side.material.pressure_limit) for side in (problem.body, problem.counter))
    if np.isinf(one).all() and np.isinf(other).all():
        raise InputError(
            "Neither material has a pressure limit, so nothing sets: make one ElasticPerfectlyPlastic(...)."
        )
    share = 0.5 * (1.0 + np.sign(other - one, where=one != other, out=np.zeros(np.broadcast(one, other).shape)))
    return float(share) if share.ndim == 0 else share


def _settled(cycles: Sequence[Cycle], count: int, tolerance: float) -> bool:
    """Tell whether the last round is whole and flattened next to nothing."""
    volumes = [cycle.volume for cycle in cycles]
    return len(cycles) % count == 0 and sum(volumes[-count:]) <= tolerance * sum(volumes)


def _moves(shifts: Sequence[tuple[int, int]], problem: ContactProblem) -> list[tuple[int, int]]:
    allowed = "a list of pairs (x, y) of whole numbers of cells"
    try:
        array = np.asarray(shifts)
    except ValueError:
        array = np.empty(0)
    if array.ndim != 2 or array.shape[0] < 1 or array.shape[1] != 2 or array.dtype.kind not in "iu":
        raise InputError.about("The shifts of the other body", shifts, allowed)
    if array.any():
        if not isinstance(problem.plan.limit, float):
            raise InputError("The pressure limit is an array, so the other body cannot be moved: leave shifts= out.")
        heights = problem.counter.surface.heights(problem.plan.grid)
        for axis, name in enumerate("xy"):
            if array[:, axis].any() and not repeats(heights, axis):
                raise InputError(
                    f"The other body's heights do not repeat along {name}, so moving it round the border would put "
                    f"a cliff into the contact: use a map that repeats, or shifts of zero along {name}."
                )
    return [(int(x), int(y)) for x, y in array]
