"""The steps of a path, and their increments: as many as the numbers need."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Mapping, Sequence

import attrs
import numpy as np

from roughcontact._base import checks
from roughcontact._base.arrays import Array, Pair
from roughcontact._base.units import Estimate, WarningText, counted
from roughcontact._parts.grid import Load
from roughcontact._solve.problem.coupled import CoupledSolve
from roughcontact._solve.problem.friction_certificate import FrictionalFields
from roughcontact._solve.problem.load_march import COST
from roughcontact._solve.problem.path import march
from roughcontact._solve.problem.scene import Scene
from roughcontact._solve.problem.step_numbers import (
    StepNumbers,
    extrapolate_numbers,
    list_cell_errors,
    numbers_of,
)
from roughcontact._solve.problem.task import limit_load
from roughcontact._solve.solution import ContactSolution, TangentialLoad
from roughcontact.errors import InputError, argument

# Minimum increments of a step by "auto", whose errors show their order with those of half and a quarter as many; the
# maximum, and the changes from half as many at which it ends: of the displacement over
# its maximum, of the energy lost over its sum, and of the area that sticks over that of the contact.
_MIN_INCREMENTS = 4
_MAX_INCREMENTS = 16
_DISPLACEMENT_TOLERANCE = 2.5e-2
_ENERGY_TOLERANCE = 0.1
_STICK_TOLERANCE = 3e-2
# Minimum displacement over the approach, and energy lost over the elastic energy, that count.
_MIN_DISPLACEMENT = 1e-2
_MIN_LOSS = 1e-2
# Sine of the angle between two changes of load below which they have one direction.
_ONE_DIRECTION = 1e-9
# Why a step has its increments, if their number was given.
AS_GIVEN = "as given"
GIVEN_INCREMENTS = WarningText(
    "the number of increments was given, so that the error of the increments is not known: leave the number open",
    "increments",
)


@attrs.frozen(eq=False)
class Increment:
    """The progress of a path after one of its increments.

    Attributes
    ----------
    step, steps
        The step of the path, from one, zero while the bodies are pressed together; and how many there are.
    increment, increments
        The increment of that step, from one; and how many there are. They begin anew when ``"auto"`` doubles them.
    state
        The state at its end.
    """

    step: int
    steps: int
    increment: int
    increments: int
    state: ContactSolution

    def __str__(self) -> str:
        step = f"step {self.step} of {self.steps}" if self.step else "pressing"
        return f"{step}, increment {self.increment} of {self.increments}"


@attrs.frozen
class PathStep:
    """One step: the loads at its ends.

    Attributes
    ----------
    number
        From one; zero where the bodies are only pressed together.
    start, end
        Normal loads.
    before, after
        Tangential loads.
    exact
        Why one increment is enough; empty if it is not.
    """

    number: int
    start: Load
    end: Load
    before: Pair
    after: TangentialLoad
    exact: str = ""

    def at(self, number: int, count: int) -> tuple[Load, TangentialLoad]:
        """Return the loads at the end of an increment, of a number from one to `count`."""
        if number == count:
            return self.end, self.after
        part = number / count
        load = self.end
        if self.end.value != self.start.value:
            load = attrs.evolve(self.end, value=self.start.value + part * (self.end.value - self.start.value))
        x, y = (old + part * (new - old) for old, new in zip(self.before, self.after.values, strict=True))
        return load, attrs.evolve(self.after, values=(x, y))


def is_single(normal: Mapping[str, object]) -> bool:
    """Return whether one normal load holds for all steps."""
    values = [value for value in normal.values() if value is not None]
    return len(values) == 1 and (isinstance(values[0], str) or not isinstance(values[0], Iterable))


def list_loads(problem: Scene, normal: Mapping[str, object]) -> tuple[Load, ...]:
    """Return the normal loads of a path; `InputError` if the bodies cannot carry one of them."""
    loads = (Load.of(**normal),) if is_single(normal) else Load.unloading_sequence(**normal)
    for load in loads:
        limit_load(problem.plan, problem.initial_gap, load)
    return loads


def list_steps(run: CoupledSolve, normal: Mapping[str, object], tangential: Mapping[str, object]) -> list[PathStep]:
    """Return the steps of a path, that of pressing first if the normal load is constant."""
    single = is_single(normal)
    loads = list_loads(run.problem, normal)
    targets = list_targets(tangential)
    if len(targets) not in (1, len(loads)) and not single:
        raise InputError(
            f"The path has {counted(len(loads), 'normal load')}, but {counted(len(targets), 'tangential load')}: "
            "give as many of both, or one value for all steps."
        )
    steps = max(len(loads), len(targets))
    loads = loads * steps if len(loads) == 1 else loads
    targets = targets * steps if len(targets) == 1 else targets
    start = Load(loads[0].kind, 0.0)
    before: Pair = (0.0, 0.0)
    if single:
        loads = (loads[0], *loads)
        targets = [TangentialLoad(targets[0].kind, before), *targets]
    segments = []
    direction: Array | None = None
    is_straight = True
    for number, (load, target) in enumerate(zip(loads, targets, strict=True), 0 if single else 1):
        change = np.subtract(target.values, before)
        size = float(np.hypot(*change))
        if size > 0.0:
            unit = change / size
            is_straight = is_straight and (
                direction is None or abs(float(unit[0] * direction[1] - unit[1] * direction[0])) < _ONE_DIRECTION
            )
            direction = unit if direction is None else direction
        exact = ""
        if not run.shear.coupled:
            if direction is None:
                exact = "no tangential load, and pressure moves nothing along the surface"
            elif load == start and is_straight:
                exact = "the normal load is constant, slip is monotone"
        segments.append(PathStep(number, start, load, before, target, exact))
        start, before = load, target.values
    return segments


def list_targets(tangential: Mapping[str, object]) -> list[TangentialLoad]:
    """Return the loads along the surface that are given by `tangential_force` or `displacement`; the other is None."""
    named = {kind: value for kind, value in tangential.items() if value is not None}
    if len(named) != 1:
        given = " and ".join(f"{kind}=" for kind in named) or "neither"
        raise InputError(f"Give {argument('tangential_force')} or {argument('displacement')}, but got {given}.")
    kind, values = next(iter(named.items()))
    unit = "N" if kind == "tangential_force" else "m"
    allowed = f"pairs (x, y) in {unit}, {kind}=[(x, y), ...]"
    try:
        items = list(values) if not isinstance(values, (str, bytes)) else []  # type: ignore[call-overload]
    except TypeError:
        items = []
    if len(items) == 2 and all(isinstance(item, str) or np.ndim(item) == 0 for item in items):
        items = [items]
    if not items:
        raise InputError.about(f"{kind}=", values, allowed)
    targets = []
    for item in items:
        if isinstance(item, str) or np.ndim(item) != 1 or len(item) != 2:
            raise InputError.about(f"An item of {kind}=", item, allowed)
        x, y = (checks.number(value, f"A component of {kind}=", unit) for value in item)
        targets.append(TangentialLoad(kind, (x, y)))
    return targets


def follow_steps(
    run: CoupledSolve,
    segments: Sequence[PathStep],
    count: int,
    tell: Callable[[Increment], object],
    last: ContactSolution | None = None,
    cycles: float = 1.0,
) -> list[ContactSolution]:
    """Return the state at the end of each step, with so many increments where one is not exact.

    They follow a state `last`, and stand for so many cycles of loads.
    """
    counts = [1 if segment.exact else count for segment in segments]
    places = [
        (segment, number, total)
        for segment, total in zip(segments, counts, strict=True)
        for number in range(1, total + 1)
    ]

    def follow(before: Sequence[ContactSolution], place: tuple[PathStep, int, int]) -> ContactSolution:
        segment, number, total = place
        return run.step(*segment.at(number, total), before[-1] if before else None, cycles)

    parts = march(places, follow, last)
    end = None if last is None else next(parts)
    steps: list[ContactSolution] = []
    for segment, total in zip(segments, counts, strict=True):
        begin = run.fields_at(end)
        found: list[ContactSolution] = []
        for number, end in enumerate(itertools.islice(parts, total), 1):
            found.append(end)
            tell(Increment(segment.number, segments[-1].number, number, total, end))
        steps.append(_join(run, found, begin, run.fields_at(end), is_exact=bool(segment.exact)))
    return [
        _add_error(step, error.dissipated) for step, error in zip(steps, list_cell_errors(steps, last), strict=True)
    ]


def _add_error(step: ContactSolution, error: float) -> ContactSolution:
    """Return a step whose energy lost has another standard deviation beside its own, J."""
    lost = attrs.evolve(step.dissipated, uncertainty=math.hypot(step.dissipated.uncertainty, error))
    return step._add(attrs.evolve(step.sheared, dissipated=lost))


def _join(
    run: CoupledSolve,
    parts: Sequence[ContactSolution],
    begin: FrictionalFields,
    end: FrictionalFields,
    *,
    is_exact: bool,
) -> ContactSolution:
    """Return the last increment of a step with slip, energy lost and cost of all of them."""
    value = math.fsum(part.dissipated.value for part in parts)
    unsure = 0.0 if is_exact else math.fsum(part.dissipated.uncertainty for part in parts)
    sheared = attrs.evolve(
        parts[-1].sheared,
        slip=(end.relative - begin.relative) * run.length,
        dissipated=Estimate(value, unsure, "J"),
        passes=max(part.sheared.passes for part in parts),
        iterations=sum(part.sheared.iterations for part in parts),
        increments=len(parts),
    )
    spent = {name: sum(getattr(part, name) for part in parts) for name in COST}
    return parts[-1]._add(sheared, **spent)


def follow_loads(
    run: CoupledSolve,
    segments: Sequence[PathStep],
    count: int | None,
    tell: Callable[[Increment], object],
    last: ContactSolution | None = None,
) -> tuple[list[ContactSolution], list[StepNumbers], list[str]]:
    """Return the states of steps after a state `last`, their numbers, and why they have their increments."""
    if count is None and not all(segment.exact for segment in segments):
        return refine_steps(run, segments, tell, last)
    steps = follow_steps(run, segments, count or 1, tell, last)
    warning = () if all(segment.exact for segment in segments) else (GIVEN_INCREMENTS,)
    numbers = [
        numbers_of(step, error, warning) for step, error in zip(steps, list_cell_errors(steps, last), strict=True)
    ]
    return steps, numbers, [segment.exact or AS_GIVEN for segment in segments]


def refine_steps(
    run: CoupledSolve,
    segments: Sequence[PathStep],
    tell: Callable[[Increment], object],
    last: ContactSolution | None = None,
) -> tuple[list[ContactSolution], list[StepNumbers], list[str]]:
    """Double the increments after a state `last` until the numbers hardly change, and extrapolate these."""
    count = 1
    steps = follow_steps(run, segments, count, tell, last)
    change = math.inf
    sweeps = [steps]
    while count < _MIN_INCREMENTS or (count < _MAX_INCREMENTS and change > 1.0):
        count *= 2
        steps = follow_steps(run, segments, count, tell, last)
        change = _compare(sweeps[-1], steps)
        sweeps = [*sweeps[-2:], steps]
    warning: tuple[str, ...] = ()
    if change > 1.0:
        text = (
            f"{count} increments of a step are not enough: from half as many the numbers change by {change:.2g} times "
            "what is admissible; give more steps"
        )
        warning = (WarningText(text, "increments", change),)
    numbers = [
        numbers_of(steps[place], error)
        if all(one.exact for one in segments[: place + 1])
        else extrapolate_numbers([sweep[place] for sweep in sweeps], error, warning)
        for place, error in enumerate(list_cell_errors(steps, last))
    ]
    reasons = [
        segment.exact or f"doubled until the numbers change by {change:.2g} of what is admissible"
        for segment in segments
    ]
    return steps, numbers, reasons


def _compare(coarse: Sequence[ContactSolution], fine: Sequence[ContactSolution]) -> float:
    """Return the largest change of a number over what is admissible."""
    moved = np.array([step.tangential_displacement for step in fine])
    shift = np.abs(moved - np.array([step.tangential_displacement for step in coarse])).max()
    lost = np.array([step.dissipated.value for step in fine])
    lost_shift = np.abs(lost - np.array([step.dissipated.value for step in coarse])).sum()
    # Where nothing slips the energy lost is rounding.
    scale = max(float(np.abs(lost).sum()), _MIN_LOSS * max(step.elastic_energy for step in fine))
    areas = [
        abs(one.stick_area.value - other.stick_area.value)
        / max(
            _STICK_TOLERANCE * float(np.count_nonzero(other.contact)) * other.grid.cell_area,
            other.stick_area.uncertainty,
            other.grid.cell_area,
        )
        for one, other in zip(coarse, fine, strict=True)
    ]
    # Without a tangential load it is rounding, or small.
    largest = max(float(np.abs(moved).max()), _MIN_DISPLACEMENT * max(abs(step.approach) for step in fine))
    changes = (
        float(shift) / (_DISPLACEMENT_TOLERANCE * largest) if largest > 0.0 else 0.0,
        float(lost_shift) / (_ENERGY_TOLERANCE * scale) if scale > 0.0 else 0.0,
        *areas,
    )
    return max(changes)
