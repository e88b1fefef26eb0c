"""Cycles of loads along a path with friction, of which some are computed, each for many."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import attrs
import numpy as np

from roughcontact._base import checks
from roughcontact._solve.problem.coupled import CoupledSolve
from roughcontact._solve.problem.increments import Increment, PathStep, follow_steps
from roughcontact._solve.problem.load_march import list_lengths
from roughcontact._solve.problem.step_numbers import StepNumbers, list_cell_errors, numbers_of
from roughcontact._solve.solution import ContactSolution, Governed
from roughcontact.errors import InputError, argument

# Deepest loss of a jump, over the admissible one, from which it is tried anew with fewer cycles.
_REFUSED_LOSS = 1.5


def list_cycles(cycles: object) -> tuple[float, ...]:
    """Return the numbers of the cycles whose states are wanted; `InputError` unless they are whole and rise."""
    allowed = "a list of whole numbers from one on that rise, such as [1, 100, 1e4]"
    found = tuple(
        checks.number(value, "A value of cycles=[...]", at_least=1.0)
        for value in checks.list_of(cycles, "The cycles of a path", allowed)
    )
    if not found or any(value != round(value) for value in found) or any(np.diff(found) <= 0.0):
        raise InputError.about("The cycles of a path", cycles, allowed)
    return found


def follow_cycles(
    run: CoupledSolve,
    segments: Sequence[PathStep],
    count: int | None,
    cycles: Sequence[float],
    accuracy: float,
    tell: Callable[[Increment], object],
    before: Sequence[ContactSolution] = (),
    wear: float = 0.0,
) -> tuple[list[ContactSolution], list[StepNumbers], list[str], float]:
    """Return the states of the wanted cycles, after that of pressing, their numbers, and for how many they are.

    They follow the states of a cycle `before`, if there is one, in which the deepest loss was `wear`, m; that of the
    last one is returned too.

    The first cycle is computed as it is. A later one stands for as many as wear the surfaces by a part `accuracy` of
    the approach: a longer jump is unstable in partial slip, where all wear is on a narrow ring. A jump that wears them
    by more is tried anew with fewer cycles.
    """
    if not any("slip" in law.rates for law in run.problem.laws):
        raise InputError(
            "Nothing changes with the cycles: give the problem a law that does, such as EnergyWear by "
            f"{argument('laws')}."
        )
    if count is None and not all(segment.exact for segment in segments):
        raise InputError(
            "The increments of cycles of loads are not doubled, and one of each step is not exact here: give "
            f"{argument('substeps')}."
        )
    substeps = count or 1
    first = segments[0].number
    loads = segments[1 - first :]
    again = [attrs.evolve(loads[0], start=loads[-1].end, before=loads[-1].after.values), *loads[1:]]
    found: list[ContactSolution] = []
    reasons: list[str] = []
    if not before:
        steps = follow_steps(run, segments, substeps, tell)
        found += steps[: 1 - first]
        steps = steps[1 - first :]
        done = 1.0
        wear = _find_deepest(found[-1] if found else None, steps[-1])
    else:
        steps = list(before)
        done = _find_effect(steps[-1]).cycle
    for place in cycles:
        count = 0
        begin = done
        while done < place:
            allowed = accuracy * max(step.approach for step in steps)
            stands = _choose(place - done, allowed / wear if wear > 0.0 else math.inf)
            jump = follow_steps(run, again, substeps, tell, steps[-1], stands)
            lost = _find_deepest(steps[-1], jump[-1])
            wear = lost / stands
            if lost > _REFUSED_LOSS * allowed and stands > 1.0:
                continue
            steps = jump
            done += stands
            count += 1
        found += [_set_cycle(step, place) for step in steps]
        told = f", the last of {count} computed for {place - begin:g}" if count else ""
        reasons += [f"of cycle {place:g}{told}"] * len(steps)
    errors = list_cell_errors(found, before[-1] if before else None)
    numbers = [numbers_of(step, error) for step, error in zip(found, errors, strict=True)]
    return found, numbers, reasons, wear


def _choose(left: float, most: float) -> float:
    """Return the cycles for which the next one stands: two equal jumps instead of a long one and a short one."""
    most = max(math.floor(most), 1.0) if most < left else left
    return min(most, float(math.ceil(0.5 * left))) if most < left < 2.0 * most else most


def _find_deepest(before: ContactSolution | None, after: ContactSolution) -> float:
    """Return the largest height that is worn from one state to another, m."""
    lengths = list_lengths(after, passing=True)
    earlier = [0.0 * one for one in lengths] if before is None else list_lengths(before, passing=True)
    return max((float(np.abs(one - other).max()) for one, other in zip(lengths, earlier, strict=True)), default=0.0)


def _set_cycle(state: ContactSolution, cycle: float) -> ContactSolution:
    return state._add(attrs.evolve(_find_effect(state), cycle=cycle))


def _find_effect(state: ContactSolution) -> Governed:
    effect = state._find_added(Governed)
    # Its problem has a law that wears.
    assert effect is not None
    return effect
