"""The march along a path: increments of load, time and sliding distance, as many as their error asks for."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from itertools import pairwise
from typing import Any

import attrs
import numpy as np

from roughcontact._base import checks
from roughcontact._base.arrays import Array
from roughcontact._parts.grid import Load
from roughcontact._solve.problem.loads import follow
from roughcontact._solve.solution import MAX_SHIFT, ContactSolution, Governed, LoadIncrement
from roughcontact.errors import InputError, argument

# First increment of time or sliding after a step of load, over its interval; factors by which the next one follows from
# the error, at least, at most, and of safety; and the error of an increment over the change from its extrapolation.
_FIRST_PART = 1e-3
_MIN_GROWTH = 0.2
_MAX_GROWTH = 4.0
_SAFETY = 0.9
_ERROR_OF_CHANGE = 1.0 / 6.0
# Power of a force with which displacements grow at least, below an approach in proportion to it: that of a ball.
_POWER_OF_FORCE = 2.0 / 3.0
# Range of what is remembered below which there is nothing, m.
_SMALLEST = 1e-300
# What solves cost.
COST = ("iterations", "convolutions", "seconds")
# Increments of one interval after which a path is given up.
_MAX_INCREMENTS = 10_000


@attrs.frozen(kw_only=True)
class Place:
    """A place on a path: the normal load, time, s, and sliding distance, m, since its start, and the shift in cells."""

    load: Load
    time: float = 0.0
    sliding: float = 0.0
    shift: tuple[int, int] = (0, 0)


def list_places(loads: Sequence[Load], time: object, sliding: object, shift: object = None) -> tuple[Place, ...]:
    """Return the places of a path; one load holds at all of them.

    `InputError` if the lists do not have one length, or time or distance fall.
    """
    passed: dict[str, tuple[Any, ...] | None] = {
        "time": _list_passed(time, "time", "s"),
        "sliding": _list_passed(sliding, "sliding", "m"),
        "shift": None if shift is None else list_shifts(shift),
    }
    counts = {name: len(values) for name, values in passed.items() if values is not None}
    if len(loads) > 1 or not counts:
        counts[f"{loads[0].kind}"] = len(loads)
    if len(set(counts.values())) > 1:
        texts = ", ".join(f"{count} for {argument(name)}" for name, count in counts.items())
        raise InputError(f"The lists of a path must have one value for each place, but there are {texts}.")
    count = next(iter(counts.values()))
    given = {name: values for name, values in passed.items() if values is not None}
    every = tuple(loads) if len(loads) > 1 else tuple(loads) * count
    return tuple(
        Place(load=load, **{name: values[number] for name, values in given.items()})
        for number, load in enumerate(every)
    )


def list_shifts(shifts: object) -> tuple[tuple[int, int], ...]:
    """Return the cells by which the counterbody is displaced at each place of a path."""
    allowed = "a list of pairs (x, y) of whole numbers of cells"
    what = "The shifts of the counterbody"
    pairs = [checks.list_of(pair, what, allowed) for pair in checks.list_of(shifts, what, allowed)]
    if not pairs or any(len(pair) != 2 for pair in pairs):
        raise InputError.about(what, shifts, allowed)
    each = "Each of the shifts of the counterbody"
    x, y = ([checks.integer(cells, each, at_least=-MAX_SHIFT) for cells in one] for one in zip(*pairs, strict=True))
    return tuple(zip(x, y, strict=True))


def _list_passed(values: object, name: str, unit: str) -> tuple[float, ...] | None:
    if values is None:
        return None
    allowed = f"a list of numbers of {unit} that do not fall, from zero on"
    given = checks.list_of(values, f"The {name} along a path", allowed)
    found = tuple(checks.number(value, f"A value of {name}=[...]", unit, at_least=0.0) for value in given)
    if not found or any(after < before for before, after in pairwise(found)):
        raise InputError.about(f"The {name} along a path", found, allowed)
    return found


@attrs.frozen(eq=False, kw_only=True)
class Standing:
    """Where a march stands: all that its next increment depends on.

    Attributes
    ----------
    states
        The last two states.
    since
        What identifies the state at the last place.
    passed, count
        What has passed of the interval, s or m, and in how many increments.
    iterations, convolutions, seconds
        Of all solves for them.
    last_length, next_length
        Lengths of the last increment and of the next one, s or m; zero after a step of load.
    """

    states: tuple[ContactSolution, ...] = ()
    since: str = ""
    passed: float = 0.0
    count: int = 0
    iterations: int = 0
    convolutions: int = 0
    seconds: float = 0.0
    last_length: float = 0.0
    next_length: float = 0.0


class LoadMarch:
    """Goes from place to place on a path, in increments as long as their error allows."""

    def __init__(
        self,
        solve: Callable[..., ContactSolution],
        accuracy: float,
        tell: Callable[[ContactSolution], object] = lambda state: None,
        standing: Standing | None = None,
    ) -> None:
        self._solve = solve
        self._accuracy = accuracy
        self._tell = tell
        self.standing = standing or Standing()

    @property
    def last(self) -> ContactSolution:
        """The last state."""
        return self.standing.states[-1]

    def go(self, begin: Place | None, end: Place) -> int:
        """Go from one place, None at the start of a path, to the next; return the number of increments.

        The state there has the cost of all of them, and of those that were tried and refused.
        """
        time = end.time - begin.time if begin else 0.0
        sliding = end.sliding - begin.sliding if begin else 0.0
        # Where both pass, their ratio is that of the interval.
        length = sliding or time
        if begin is None or length == 0.0 or end.shift != begin.shift:
            if not self.standing.count:
                self._jump(end, time, sliding)
        else:
            while self.standing.passed < length:
                self._step(begin, end, length, time / length, sliding / length)
        standing = self.standing
        spent: dict[str, Any] = {name: getattr(standing, name) for name in COST}
        states = (*standing.states[:-1], attrs.evolve(self.last, **spent))
        nothing: dict[str, Any] = dict.fromkeys(COST, 0)
        since = identify(self.last)
        self.standing = attrs.evolve(standing, states=states, since=since, passed=0.0, count=0, **nothing)
        return standing.count

    def _jump(self, place: Place, time: float, sliding: float) -> None:
        """Go to a load, or to other summits, at once: nothing continues."""
        increment = LoadIncrement(place.load, time, sliding, shift=place.shift)
        found = follow(partial(self._solve, increment=increment), self.standing.states, place.load)
        found = _set_clock(found, place) if time or sliding else found
        self._accept(found, attrs.evolve(self.standing, count=1, last_length=0.0, next_length=0.0))

    def _step(self, begin: Place, end: Place, length: float, time: float, sliding: float) -> None:
        """Try the next increment of an interval, over whose length time and distance pass at these rates."""
        standing = self.standing
        rest = length - standing.passed
        step = self._choose(length, rest)
        is_last = step >= rest
        passed = length if is_last else standing.passed + step
        load = begin.load.toward(end.load, passed / length)
        found = self._find(step, LoadIncrement(load, time * step, sliding * step, shift=end.shift))
        error = self._measure(found, step) / _find_rise(load, end.load)
        growth = _SAFETY / math.sqrt(error) if error > 0.0 else _MAX_GROWTH
        following = step * min(max(growth, _MIN_GROWTH), _MAX_GROWTH)
        if error > 1.0:
            self.standing = attrs.evolve(_spend(standing, found), next_length=following)
            return
        if standing.count == _MAX_INCREMENTS:
            raise InputError(
                f"After {standing.count} increments a path has passed {standing.passed / length:.2g} of an interval: "
                f"give places that are nearer to each other, or {argument('accuracy')} that is less strict."
            )
        found = _set_clock(found, end) if is_last else found
        count = standing.count + 1
        self._accept(found, attrs.evolve(standing, passed=passed, count=count, last_length=step, next_length=following))

    def _choose(self, length: float, rest: float) -> float:
        step = self.standing.next_length or _FIRST_PART * length
        # Two equal increments instead of a long one and a tiny one.
        return rest if step >= rest else min(step, 0.5 * rest) if 2.0 * step > rest else step

    def _accept(self, state: ContactSolution, standing: Standing) -> None:
        """Take a state as the last one, which states the place that it follows."""
        effect = state._find_added(Governed)
        if effect is not None:
            state = state._add(attrs.evolve(effect, previous=standing.since))
        self.standing = attrs.evolve(_spend(standing, state), states=(*standing.states[-1:], state))
        self._tell(state)

    def _find(self, step: float, increment: LoadIncrement) -> ContactSolution:
        """Return the state after an increment, from the pressure extrapolated from the last two."""
        standing = self.standing
        solve = partial(self._solve, increment=increment)
        if not standing.last_length or len(standing.states) < 2 or self.last.tension is not None:
            return follow(solve, standing.states[-1:], increment.load)
        before, last = (state.pressure for state in standing.states)
        start = np.clip(last + (last - before) * (step / standing.last_length), 0.0, self.last.pressure_limit)
        return solve(increment.load, start, before=self.last)

    def _measure(self, state: ContactSolution, step: float) -> float:
        """Return the error of an increment over the admissible one, from what changes the gap and its extrapolation."""
        states = self.standing.states
        earlier = self.standing.last_length
        if not earlier or len(states) < 2:
            return 0.0
        part = _ERROR_OF_CHANGE * step / (step + earlier)
        error = 0.0
        for before, last, now in zip(*(list_lengths(one, passing=True) for one in (*states, state)), strict=True):
            change = now - last
            change -= (last - before) * (step / earlier)
            error = max(error, part * float(np.abs(change).max()))
        scale = max((float(np.ptp(now)) for now in list_lengths(state)), default=0.0)
        return error / (self._accuracy * max(scale, _SMALLEST))


def _spend(standing: Standing, state: ContactSolution) -> Standing:
    """Return where a march stands with the cost of another solve."""
    spent: dict[str, Any] = {name: getattr(standing, name) + getattr(state, name) for name in COST}
    return attrs.evolve(standing, **spent)


def identify(state: ContactSolution) -> str:
    """Return digits that identify a state on a path; empty where no law remembers."""
    effect = state._find_added(Governed)
    return "" if effect is None else effect.identify(state)


def _set_clock(state: ContactSolution, place: Place) -> ContactSolution:
    """Return a state at a place, whose time and distance are sums of increments, with those of the place."""
    effect = state._find_added(Governed)
    assert effect is not None
    return state._add(attrs.evolve(effect, elapsed=place.time, slid=place.sliding))


def list_lengths(state: ContactSolution, *, passing: bool = False) -> list[Array]:
    """Return what the laws remember as lengths, such as heights that are lost; where only what passes changes them.

    What changes with the load alone, as by flattening, has no length of increments on which it depends.
    """
    effect = state._find_added(Governed)
    assert effect is not None
    known = zip(effect.laws, effect.remembered, effect.memory, strict=True)
    return [
        memory[name]
        for law, names, memory in known
        for name, (_, unit) in names.items()
        if unit == "m" and memory[name].ndim == 2 and (law.rates or not passing)
    ]


def _find_rise(load: Load, end: Load) -> float:
    """Return about by how much the surfaces will have changed more under a load that rises than under one before."""
    if not 0.0 < load.value < end.value:
        return 1.0
    return float((end.value / load.value) ** (1.0 if load.kind == "approach" else _POWER_OF_FORCE))
