"""The increments of the steps of a path, and the limits of its numbers for infinitely many of them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

import attrs
import numpy as np

from roughcontact._base import checks
from roughcontact._base.arrays import Array, Pair
from roughcontact._base.units import Estimate, WarningText, counted
from roughcontact._parts.grid import Load
from roughcontact._solve.problem.coupled import CoupledSolve
from roughcontact._solve.problem.friction_certificate import FrictionalFields
from roughcontact._solve.problem.task import limit_load
from roughcontact._solve.solution import FrictionalSolution, FrictionalState, TangentialLoad
from roughcontact.errors import InputError

if TYPE_CHECKING:
    from roughcontact._solve.problem.problem import ContactProblem

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
# Ratios of two changes in a row, half an order and two, and the standard deviation of a limit over the largest of these
# changes and what is extrapolated: set on paths with turns, from the first touch and of unlike bodies, against 64
# increments.
_SMALLEST_RATIO = math.sqrt(2.0)
_LARGEST_RATIO = 4.0
_LIMIT_STD = 0.5
# Sine of the angle between two changes of load below which they have one direction.
_ONE_DIRECTION = 1e-9
GIVEN_INCREMENTS = WarningText(
    "the number of increments was given, so that the error of the increments is not known: leave it to substeps='auto'",
    "increments",
)


@attrs.frozen(eq=False, kw_only=True)
class StepNumbers:
    """Numbers of one step, extrapolated to infinitely many increments.

    Attributes
    ----------
    displacement
        Along x and y, m.
    dissipated
        Energy lost in the step, J.
    stick_area
        Area that sticks at its end, m2.
    """

    displacement: tuple[Estimate, Estimate]
    dissipated: Estimate
    stick_area: Estimate


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
    state: FrictionalSolution

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


def list_loads(problem: ContactProblem, normal: Mapping[str, object]) -> tuple[Load, ...]:
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
        raise InputError(f"Give tangential_force= or displacement=, but got {given}.")
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
    run: CoupledSolve, segments: Sequence[PathStep], count: int, tell: Callable[[Increment], object]
) -> list[FrictionalSolution]:
    """Return the state at the end of each step, with so many increments where one is not exact."""
    state = FrictionalState.unloaded(run.problem.plan.grid.shape)
    fields = run.fields_of(state)
    steps: list[FrictionalSolution] = []
    for segment in segments:
        if steps and segment.end.value < segment.start.value and steps[-1].contact.saturated.any():
            raise InputError(
                "The normal load falls after the pressure has reached its limit: each state would be a first loading. "
                "Give loads that do not fall, or the problem that run_in(...) returns."
            )
        parts: list[FrictionalSolution] = []
        begin = fields
        increments = 1 if segment.exact else count
        for number in range(1, increments + 1):
            load, target = segment.at(number, increments)
            part, fields = run.step(load, target, state, fields)
            state = part.state
            parts.append(part)
            tell(Increment(segment.number, segments[-1].number, number, increments, part))
        steps.append(_join(run, parts, begin, fields, is_exact=bool(segment.exact)))
    return steps


def _join(
    run: CoupledSolve,
    parts: Sequence[FrictionalSolution],
    begin: FrictionalFields,
    end: FrictionalFields,
    *,
    is_exact: bool,
) -> FrictionalSolution:
    """Return the last increment of a step with slip, energy lost and cost of all of them."""
    value = math.fsum(part.dissipated.value for part in parts)
    unsure = 0.0 if is_exact else math.fsum(part.dissipated.uncertainty for part in parts)
    lost = Estimate(value, math.hypot(unsure, parts[-1].cell_errors[1] * value), "J")
    return attrs.evolve(
        parts[-1],
        slip=(end.relative - begin.relative) * run.length,
        dissipated=lost,
        passes=max(part.passes for part in parts),
        iterations=sum(part.iterations for part in parts),
        increments=len(parts),
        seconds=math.fsum(part.seconds for part in parts),
    )


def refine_steps(
    run: CoupledSolve, segments: Sequence[PathStep], tell: Callable[[Increment], object]
) -> tuple[list[FrictionalSolution], list[StepNumbers], list[str]]:
    """Double the increments until the numbers hardly change, and extrapolate these."""
    count = 1
    steps = follow_steps(run, segments, count, tell)
    change = math.inf
    sweeps = [steps]
    while count < _MIN_INCREMENTS or (count < _MAX_INCREMENTS and change > 1.0):
        count *= 2
        steps = follow_steps(run, segments, count, tell)
        change = _compare(sweeps[-1], steps)
        sweeps = [*sweeps[-2:], steps]
    warning: tuple[str, ...] = ()
    if change > 1.0:
        text = (
            f"{count} increments of a step are not enough: from half as many the numbers change by {change:.2g} times "
            "what is admissible; give more steps"
        )
        warning = (WarningText(text, "increments", change),)
    moved = find_amplitude(steps)
    numbers = [
        numbers_of(steps[place], moved)
        if all(one.exact for one in segments[: place + 1])
        else _extrapolate([sweep[place] for sweep in sweeps], moved, warning)
        for place in range(len(segments))
    ]
    reasons = [
        segment.exact or f"doubled until the numbers change by {change:.2g} of what is admissible"
        for segment in segments
    ]
    return steps, numbers, reasons


def _compare(coarse: Sequence[FrictionalSolution], fine: Sequence[FrictionalSolution]) -> float:
    """Return the largest change of a number over what is admissible."""
    moved = np.array([step.displacement for step in fine])
    shift = np.abs(moved - np.array([step.displacement for step in coarse])).max()
    lost = np.array([step.dissipated.value for step in fine])
    lost_shift = np.abs(lost - np.array([step.dissipated.value for step in coarse])).sum()
    # Where nothing slips the energy lost is rounding.
    scale = max(float(np.abs(lost).sum()), _MIN_LOSS * max(step.elastic_energy for step in fine))
    areas = [
        abs(one.stick_area.value - other.stick_area.value)
        / max(
            _STICK_TOLERANCE * float(np.count_nonzero(other.contact.contact)) * other.grid.cell_area,
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


def find_amplitude(steps: Sequence[FrictionalSolution]) -> float:
    """Return the largest tangential displacement of the steps, m."""
    return max(math.hypot(*step.displacement) for step in steps)


def numbers_of(step: FrictionalSolution, amplitude: float, warnings: tuple[str, ...] = ()) -> StepNumbers:
    """Return the numbers of a step as they are, of a path with a largest displacement."""
    error = _displacement_error(step, amplitude)
    x, y = (Estimate(value, error, "m", warnings) for value in step.displacement)
    return StepNumbers(
        displacement=(x, y),
        dissipated=attrs.evolve(step.dissipated, warnings=warnings),
        stick_area=attrs.evolve(step.stick_area, warnings=warnings),
    )


def _displacement_error(step: FrictionalSolution, amplitude: float) -> float:
    """Return the standard deviation of the displacement by the size of the cells, m; zero if it is given."""
    return 0.0 if step.given.kind == "displacement" else step.cell_errors[0] * amplitude


def _extrapolate(sweeps: Sequence[FrictionalSolution], amplitude: float, warnings: tuple[str, ...]) -> StepNumbers:
    """Return the limits of infinitely many increments, from the last three numbers of increments, each twice the other.

    The order of the error is observed: it is one where a direction turns, and a half where normal and tangential load
    grow together from the first touch.
    """
    fine = sweeps[-1]

    def extend(values: Sequence[float], unit: str, known: float, low: float, high: float) -> Estimate:
        limit, error = _find_limit([np.array([value]) for value in values])
        return Estimate(min(max(float(limit[0]), low), high), math.hypot(error, known), unit, warnings)

    limit, error = _find_limit([np.array(step.displacement) for step in sweeps])
    by_cells = _displacement_error(fine, amplitude)
    x, y = (Estimate(float(value), math.hypot(error, by_cells), "m", warnings) for value in limit)
    touching = int(np.count_nonzero(fine.contact.contact)) * fine.grid.cell_area
    lost = [step.dissipated.value for step in sweeps]
    stick = [step.stick_area.value for step in sweeps]
    return StepNumbers(
        displacement=(x, y),
        dissipated=extend(lost, "J", fine.cell_errors[1] * lost[-1], 0.0, math.inf),
        stick_area=extend(stick, "m2", fine.stick_area.uncertainty, 0.0, touching),
    )


def _find_limit(values: Sequence[Array]) -> tuple[Array, float]:
    r"""Return the limit of three vectors of one, two and four times as many increments, and its standard deviation.

    With changes a and b the error falls by :math:`r = a \cdot b / b^2` where the increments are halved, and
    :math:`b / (r - 1)` is left (Aitken). Where the changes do not fall there is no order, and both count.
    """
    first = values[1] - values[0]
    last = values[2] - values[1]
    square = float(last @ last)
    if square == 0.0:
        return values[2], 0.0
    ratio = float(first @ last) / square
    left = last / (min(max(ratio, _SMALLEST_RATIO), _LARGEST_RATIO) - 1.0)
    sizes = [math.hypot(*one) for one in (first, last, left)]
    return values[2] + left, _LIMIT_STD * max(sizes) if ratio > 1.0 else sizes[0] + sizes[1]
