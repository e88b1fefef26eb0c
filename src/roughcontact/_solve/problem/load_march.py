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
_MAX_GROWTH = 2.0
_SAFETY = 0.9
_ERROR_OF_CHANGE = 1.0 / 6.0
# Range of what is remembered below which there is nothing, m.
_SMALLEST = 1e-300
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
        texts = ", ".join(f"{count} of {name}=" for name, count in counts.items())
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
    found = []
    for pair in checks.list_of(shifts, "The shifts of the counterbody", allowed):
        x, y = (
            checks.integer(cells, "A shift of the counterbody", at_least=-MAX_SHIFT)
            for cells in checks.list_of(pair, "A shift of the counterbody", "a pair (x, y) of whole numbers of cells")
        )
        found.append((x, y))
    if not found:
        raise InputError.about("The shifts of the counterbody", shifts, allowed)
    return tuple(found)


def _list_passed(values: object, name: str, unit: str) -> tuple[float, ...] | None:
    if values is None:
        return None
    allowed = f"a list of numbers of {unit} that do not fall, from zero on"
    given = checks.list_of(values, f"The {name} along a path", allowed)
    found = tuple(checks.number(value, f"A value of {name}=[...]", unit, at_least=0.0) for value in given)
    if not found or any(after < before for before, after in pairwise(found)):
        raise InputError.about(f"The {name} along a path", found, allowed)
    return found


class LoadMarch:
    """The last two states of a path, and the length of the next increment, over the interval that it is part of."""

    def __init__(
        self,
        solve: Callable[..., ContactSolution],
        accuracy: float,
        tell: Callable[[ContactSolution], object] = lambda state: None,
        states: Sequence[ContactSolution] = (),
    ) -> None:
        self._solve = solve
        self._accuracy = accuracy
        self._tell = tell
        self._states: list[ContactSolution] = list(states)
        # Lengths of the last increment and of the next one, s or m; zero after a step of load.
        self._before = 0.0
        self._next = 0.0

    @property
    def last(self) -> ContactSolution:
        """The last state."""
        return self._states[-1]

    def jump(self, load: Load, shift: tuple[int, int] = (0, 0)) -> None:
        """Go to a load at once."""
        self._accept(follow(partial(self._solve, increment=LoadIncrement(load, shift=shift)), self._states, load))
        self._before = self._next = 0.0

    def go(self, begin: Place, end: Place) -> int:
        """Go from one place to the next; return the number of increments."""
        time = end.time - begin.time
        sliding = end.sliding - begin.sliding
        # Where both pass, their ratio is that of the interval.
        length = sliding or time
        if length == 0.0:
            self.jump(end.load, end.shift)
            return 1
        if end.shift != begin.shift:
            # Other summits touch: nothing continues.
            self._before = self._next = 0.0
            increment = LoadIncrement(end.load, time, sliding, end.shift)
            self._accept(_set_clock(follow(partial(self._solve, increment=increment), self._states, end.load), end))
            return 1
        count = 0
        passed = 0.0
        while passed < length:
            step = self._choose(length, length - passed)
            is_last = step >= length - passed
            part = 1.0 if is_last else (passed + step) / length
            load = _between(begin.load, end.load, part)
            increment = LoadIncrement(load, time * step / length, sliding * step / length, end.shift)
            found = self._find(step, increment)
            error = self._measure(found, step)
            growth = _SAFETY / math.sqrt(error) if error > 0.0 else _MAX_GROWTH
            self._next = step * min(max(growth, _MIN_GROWTH), _MAX_GROWTH)
            if error > 1.0:
                continue
            self._accept(_set_clock(found, end) if is_last else found)
            self._before = step
            passed = length if is_last else passed + step
            count += 1
            if count > _MAX_INCREMENTS:
                raise InputError(
                    f"After {count} increments a path has passed {passed / length:.2g} of an interval: give places "
                    f"that are nearer to each other, or {argument('accuracy')} that is less strict."
                )
        return count

    def _choose(self, length: float, rest: float) -> float:
        step = self._next or _FIRST_PART * length
        # Two equal increments instead of a long one and a tiny one.
        return rest if step >= rest else min(step, 0.5 * rest) if 2.0 * step > rest else step

    def _accept(self, state: ContactSolution) -> None:
        self._states = [*self._states[-1:], state]
        self._tell(state)

    def _find(self, step: float, increment: LoadIncrement) -> ContactSolution:
        """Return the state after an increment, from the pressure extrapolated from the last two."""
        solve = partial(self._solve, increment=increment)
        if not self._before or len(self._states) < 2 or self.last.tension is not None:
            return follow(solve, self._states[-1:], increment.load)
        before, last = (state.pressure for state in self._states)
        start = np.clip(last + (last - before) * (step / self._before), 0.0, self.last.pressure_limit)
        return solve(increment.load, start, before=self.last)

    def _measure(self, state: ContactSolution, step: float) -> float:
        """Return the error of an increment over the admissible one, from what changes the gap and its extrapolation."""
        if not self._before or len(self._states) < 2:
            return 0.0
        part = _ERROR_OF_CHANGE * step / (step + self._before)
        error = 0.0
        for before, last, now in zip(*map(_list_lengths, (*self._states, state)), strict=True):
            change = now - last
            change -= (last - before) * (step / self._before)
            error = max(error, part * float(np.abs(change).max()) / max(float(np.ptp(now)), _SMALLEST))
        return error / self._accuracy


def _set_clock(state: ContactSolution, place: Place) -> ContactSolution:
    """Return a state at a place, whose time and distance are sums of increments, with those of the place."""
    effect = state._find_added(Governed)
    assert effect is not None
    return state._add(attrs.evolve(effect, elapsed=place.time, slid=place.sliding))


def _list_lengths(state: ContactSolution) -> list[Array]:
    """Return what the laws remember as lengths, such as heights that are lost."""
    effect = state._find_added(Governed)
    assert effect is not None
    pairs = zip(effect.remembered, effect.memory, strict=True)
    return [memory[name] for names, memory in pairs for name, (_, unit) in names.items() if unit == "m"]


def _between(begin: Load, end: Load, part: float) -> Load:
    return end if part == 1.0 else attrs.evolve(end, value=begin.value + part * (end.value - begin.value))
