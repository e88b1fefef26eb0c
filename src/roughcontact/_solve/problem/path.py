"""Paths of normal and tangential loads with friction: their increments, extrapolated numbers, and energy lost."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, overload

import attrs
import numpy as np

from roughcontact._base import checks
from roughcontact._base.arrays import Array, Pair, read_only
from roughcontact._base.tables import Table
from roughcontact._base.units import ContactWarning, Estimate, PlainText, counted, outlined
from roughcontact._parts.grid import Load
from roughcontact._parts.interactions import Coulomb, FrictionLaw
from roughcontact._solve.problem.coupled import FrictionalFields, FrictionalRun, require_frictional
from roughcontact._solve.problem.task import limit_load
from roughcontact._solve.solution import (
    FrictionalSolution,
    FrictionalState,
    TangentialLoad,
    read_path,
    write_path,
)
from roughcontact.errors import InputError

if TYPE_CHECKING:
    from roughcontact._solve.problem.problem import ContactProblem

# Maximum increments of a step by "auto", and the changes from half as many at which it ends: of the displacement over
# its maximum, of the energy lost over its sum, and of the area that sticks over that of the contact.
_MAX_INCREMENTS = 16
_DISPLACEMENT_TOLERANCE = 2.5e-2
_ENERGY_TOLERANCE = 0.1
_STICK_TOLERANCE = 3e-2
# Least displacement over the approach, and energy lost over the elastic energy, that count.
_LEAST_DISPLACEMENT = 1e-2
_LEAST_LOSS = 1e-2
# Sine of the angle between two changes of load below which they have one direction.
_ONE_DIRECTION = 1e-9
# Numbers over the largest of their kind that a table shows as zero.
_TABLE_ROUNDING = 1e-9
_GIVEN_INCREMENTS = ContactWarning(
    "the number of increments was given, so that the error of the increments is not known: leave it to substeps='auto'",
    "increments",
)


@attrs.frozen(eq=False)
class TangentialLoop:
    """Tangential force over displacement along a path, from its start.

    Attributes
    ----------
    force
        Force (x, y) at each state, shape (n + 1, 2), N.
    displacement
        Displacement (x, y), shape (n + 1, 2), m.
    uncertainty
        Standard deviation of the displacement by the increments, shape (n + 1, 2), m.
    """

    force: Array = attrs.field(converter=read_only, repr=outlined)
    displacement: Array = attrs.field(converter=read_only, repr=outlined)
    uncertainty: Array = attrs.field(converter=read_only, repr=outlined)


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


@attrs.frozen(eq=False, kw_only=True)
class FrictionalPath(Sequence[FrictionalSolution]):
    """The states of a contact with friction along a path of loads: iterable, with `len` and ``[]``.

    Attributes
    ----------
    states
        The states at the given loads.
    pressed
        The state under the normal load alone, from which the path starts; None if it starts from the first touch.
    numbers
        Displacement, energy lost and area that sticks of each step, with the uncertainty of the increments.
    increments
        Increments of each step.
    reasons
        Why each step has its increments, in words.

    Examples
    --------
    Half a fretting cycle of a ball:

    >>> import roughcontact as rc
    >>> steel = rc.Elastic(young=210e9, poisson=0.3)
    >>> ball, flat = rc.Body(rc.SphereSurface(radius=1e-3), steel), rc.Body(rc.FlatSurface(), steel)
    >>> problem = rc.ContactProblem(ball, flat, grid=rc.Grid((32, 32), 100e-6))
    >>> path = problem.path(force=1.0, tangential_force=[(0.2, 0.0), (-0.2, 0.0)], friction=0.3)
    >>> len(path), [f"{x * 1e9:.1f} nm" for x in path.loop.displacement[:, 0]]
    (2, ['0.0 nm', '80.9 nm', '-74.3 nm'])
    """

    states: tuple[FrictionalSolution, ...]
    pressed: FrictionalSolution | None
    numbers: tuple[StepNumbers, ...]
    increments: tuple[int, ...]
    reasons: tuple[str, ...]

    def __iter__(self) -> Iterator[FrictionalSolution]:
        return iter(self.states)

    def __len__(self) -> int:
        return len(self.states)

    @overload
    def __getitem__(self, index: int) -> FrictionalSolution: ...

    @overload
    def __getitem__(self, index: slice) -> tuple[FrictionalSolution, ...]: ...

    def __getitem__(self, index: int | slice) -> FrictionalSolution | tuple[FrictionalSolution, ...]:
        return checks.item_of(self.states, index, "The index of a path")

    @cached_property
    def loop(self) -> TangentialLoop:
        """Tangential force over displacement, from the start of the path."""
        start = self.pressed
        forces = [(0.0, 0.0) if start is None else start.tangential_force]
        forces += [state.tangential_force for state in self.states]
        moved = [(0.0, 0.0) if start is None else start.displacement]
        moved += [(one.displacement[0].value, one.displacement[1].value) for one in self.numbers]
        unsure = [(0.0, 0.0)]
        unsure += [(one.displacement[0].uncertainty, one.displacement[1].uncertainty) for one in self.numbers]
        return TangentialLoop(np.array(forces), np.array(moved), np.array(unsure))

    @property
    def dissipated(self) -> Estimate:
        """Energy lost by friction along the path, J, without that of pressing; its uncertainty is of the increments."""
        parts = [one.dissipated for one in self.numbers]
        warnings = dict.fromkeys(text for part in parts for text in part.warnings)
        value = math.fsum(part.value for part in parts)
        return Estimate(value, math.fsum(part.uncertainty for part in parts), "J", tuple(warnings))

    @property
    def work(self) -> Array:
        """Energy lost by friction at each place in each step, by the slip at its end, shape (n, nx, ny), J/m2.

        It is what models of fretting wear take; its sum over the cells is that of a step in one increment.
        """
        return np.stack([np.einsum("aij,aij->ij", state.shear, state.slip) for state in self.states])

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """Why numbers of the path must not be trusted, in sentences; empty without a reason."""
        parts = [part for one in self.numbers for part in (*one.displacement, one.dissipated, one.stick_area)]
        found = [text for part in parts for text in part.warnings]
        return tuple(dict.fromkeys([*found, *(text for state in self.states for text in state.contact.warnings)]))

    def table(self) -> Table:
        """Return a row for each step, in SI units; see `roughcontact.typing.Table`."""
        columns: dict[str, Any] = {
            "force": np.array([state.force for state in self.states]),
            **{f"tangential_{axis}": _without_rounding(self.loop.force[1:])[:, k] for k, axis in enumerate("xy")},
            **{f"displacement_{axis}": self._displacements(k) for k, axis in enumerate("xy")},
            "dissipated": [one.dissipated for one in self.numbers],
            "stick_area": [one.stick_area for one in self.numbers],
            "approach": np.array([state.approach for state in self.states]),
            "increments": list(self.increments),
        }
        units = {"force": "N", "tangential_x": "N", "tangential_y": "N", "approach": "m"}
        return Table(columns, units)

    def _displacements(self, axis: int) -> list[Estimate]:
        values = _without_rounding(self.loop.displacement[1:])[:, axis].tolist()
        return [
            attrs.evolve(one.displacement[axis], value=value) for one, value in zip(self.numbers, values, strict=True)
        ]

    def plot(self, *, axes: Any = None, dark: bool = False) -> Any:
        """Draw the tangential force over the displacement (extra ``plot``); see `ContactSolution.plot`."""
        from roughcontact.plotting import draw_loop

        return draw_loop(self, axes, dark)

    def explain(self) -> str:
        """Return the constants of the pair, the increments with their reasons, and what was omitted, in words."""
        first = self.states[0]
        pair = first.pair
        coupled = pair.beta != 0.0
        passes = max(state.passes for state in self.states)
        omitted = []
        if not coupled:
            omitted.append("displacement across the surface by the traction, and along it by pressure: beta = 0")
        if pair.gamma == 0.0:
            omitted.append("displacement along x by traction along y: gamma = 0")
        if not coupled and self.pressed is not None:
            omitted.append("tangential solve of pressing: without a tangential load nothing moves")
        rows = [
            ("pair", f"beta {pair.beta:.4g}, gamma {pair.gamma:.4g}"),
            (
                "coupling",
                f"normal and tangential solves in turn, at most {passes} of each in an increment"
                if coupled
                else "none: one solve of each",
            ),
            ("components", "xx, yy, xy" + (", zx, zy" if coupled else "")),
            *(
                (f"step {number}", f"{counted(count, 'increment')}: {reason}")
                for number, (count, reason) in enumerate(zip(self.increments, self.reasons, strict=True), 1)
            ),
            *(("omitted", text) for text in omitted),
        ]
        return PlainText("\n".join(f"{label:<10} {text}" for label, text in rows))

    def verify(self) -> None:
        """Recompute the certificate of each state; `InputError` if one contradicts itself or the state before."""
        for state in (*([] if self.pressed is None else [self.pressed]), *self.states):
            state.verify()

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the path to a file ``.npz``, completely or not at all; an existing file is replaced."""
        numbers = [attrs.asdict(one) for one in self.numbers]
        notes = {"increments": list(self.increments), "reasons": list(self.reasons), "numbers": numbers}
        write_path(checks.path(path, "The file"), self.states, self.pressed, notes)

    @classmethod
    def load(cls, path: str | os.PathLike[str], *, verify: bool = True) -> FrictionalPath:
        """Return the path in a file that `save` has written.

        Parameters
        ----------
        path
            The file.
        verify
            Whether to build the problem and recompute the certificate of each state.

        Raises
        ------
        InputError
            If there is no such file, it is damaged or of another kind, or its content contradicts itself.
        """
        states, pressed, notes = read_path(checks.path(path, "The file"), verify=checks.flag(verify, "verify="))
        numbers = tuple(
            StepNumbers(
                displacement=(_estimate(one["displacement"][0]), _estimate(one["displacement"][1])),
                dissipated=_estimate(one["dissipated"]),
                stick_area=_estimate(one["stick_area"]),
            )
            for one in notes["numbers"]
        )
        return cls(
            states=states,
            pressed=pressed,
            numbers=numbers,
            increments=tuple(int(count) for count in notes["increments"]),
            reasons=tuple(str(text) for text in notes["reasons"]),
        )

    def __str__(self) -> str:
        lines = [self.table().to_text(), f"energy lost  {self.dissipated}"]
        return "\n".join([*lines, *(f"warning: {text}" for text in self.warnings)])

    def __repr__(self) -> str:
        return f"<FrictionalPath {counted(len(self), 'state')}, {self.states[0].grid}, lost {self.dissipated}>"


def _without_rounding(values: Array) -> Array:
    """Return values with zeros in place of those that are rounding beside the largest one."""
    return np.where(np.abs(values) < _TABLE_ROUNDING * np.abs(values).max(), 0.0, values)


def _estimate(stored: Any) -> Estimate:
    return Estimate(
        float(stored["value"]), float(stored["uncertainty"]), str(stored["unit"]), tuple(map(str, stored["warnings"]))
    )


@attrs.frozen
class _Segment:
    """One step: the loads at its ends.

    Attributes
    ----------
    start, end
        Normal loads.
    before, after
        Tangential loads.
    exact
        Why one increment is enough; empty if it is not.
    """

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


def resolve_friction(friction: object) -> FrictionLaw:
    """Return a friction law: a number is a coefficient of friction."""
    if isinstance(friction, FrictionLaw):
        return friction
    if isinstance(friction, (bool, str)) or not isinstance(friction, (int, float, np.ndarray, np.number)):
        raise InputError.about("friction=", friction, "a coefficient or a FrictionLaw such as Coulomb(0.3)")
    return Coulomb(friction)


def run_path(
    problem: ContactProblem,
    normal: Mapping[str, object],
    tangential: Mapping[str, object],
    friction: object,
    substeps: object,
) -> FrictionalPath:
    """Return the states along a path; see `ContactProblem.path`."""
    law = resolve_friction(friction)
    count = None if substeps == "auto" else checks.integer(substeps, "substeps=", at_least=1)
    require_frictional(problem)
    run = FrictionalRun(problem, law)
    segments = _list_segments(run, normal, tangential)
    for segment in segments:
        limit_load(problem.plan, problem.initial_gap, segment.end)
    has_pressing = segments[0].after.values == (0.0, 0.0) and _is_single(normal)
    if count is not None or all(segment.exact for segment in segments):
        steps = _follow(run, segments, count or 1)
        warning = () if all(segment.exact for segment in segments) else (_GIVEN_INCREMENTS,)
        numbers = [_raw_numbers(step, warning) for step in steps]
        reasons = [segment.exact or "as given" for segment in segments]
    else:
        steps, numbers, reasons = _refine(run, segments)
    kept = slice(1 if has_pressing else 0, None)
    return FrictionalPath(
        states=tuple(steps[kept]),
        pressed=steps[0] if has_pressing else None,
        numbers=tuple(numbers[kept]),
        increments=tuple(step.increments for step in steps[kept]),
        reasons=tuple(reasons[kept]),
    )


def run_slide(
    problem: ContactProblem, normal: Mapping[str, object], friction: object, direction: object
) -> FrictionalSolution:
    """Return the contact in steady sliding; see `ContactProblem.slide`."""
    law = resolve_friction(friction)
    angle = math.radians(checks.number(direction, "The direction of sliding", "degrees"))
    require_frictional(problem)
    load = Load.of(**normal)
    limit_load(problem.plan, problem.initial_gap, load)
    # Exactly along an axis.
    x, y = (round(value, 15) for value in (math.cos(angle), math.sin(angle)))
    return FrictionalRun(problem, law).slide(load, (x, y))


def _is_single(normal: Mapping[str, object]) -> bool:
    values = [value for value in normal.values() if value is not None]
    return len(values) == 1 and (isinstance(values[0], str) or not isinstance(values[0], Iterable))


def _list_segments(
    run: FrictionalRun, normal: Mapping[str, object], tangential: Mapping[str, object]
) -> list[_Segment]:
    """Return the steps of a path, that of pressing first if the normal load is constant."""
    single = _is_single(normal)
    loads = (Load.of(**normal),) if single else Load.sequence(**normal)
    targets = _list_targets(tangential)
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
    for load, target in zip(loads, targets, strict=True):
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
        segments.append(_Segment(start, load, before, target, exact))
        start, before = load, target.values
    return segments


def _list_targets(tangential: Mapping[str, object]) -> list[TangentialLoad]:
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


def _follow(run: FrictionalRun, segments: Sequence[_Segment], count: int) -> list[FrictionalSolution]:
    """Return the state at the end of each step, with so many increments where one is not exact."""
    state = FrictionalState.unloaded(run.problem.plan.grid.shape)
    fields = run.fields_of(state)
    steps = []
    for segment in segments:
        parts: list[FrictionalSolution] = []
        begin = fields
        increments = 1 if segment.exact else count
        for number in range(1, increments + 1):
            load, target = segment.at(number, increments)
            part, fields = run.step(load, target, state, fields)
            state = part.state
            parts.append(part)
        steps.append(_join(run, parts, begin, fields))
    return steps


def _join(
    run: FrictionalRun, parts: Sequence[FrictionalSolution], begin: FrictionalFields, end: FrictionalFields
) -> FrictionalSolution:
    """Return the last increment of a step with slip, energy lost and cost of all of them."""
    lost = Estimate(
        math.fsum(part.dissipated.value for part in parts),
        math.fsum(part.dissipated.uncertainty for part in parts),
        "J",
    )
    return attrs.evolve(
        parts[-1],
        slip=(end.relative - begin.relative) * run.length,
        dissipated=lost,
        passes=max(part.passes for part in parts),
        iterations=sum(part.iterations for part in parts),
        increments=len(parts),
        seconds=math.fsum(part.seconds for part in parts),
    )


def _refine(
    run: FrictionalRun, segments: Sequence[_Segment]
) -> tuple[list[FrictionalSolution], list[StepNumbers], list[str]]:
    """Double the increments until the numbers hardly change, and extrapolate these."""
    count = 1
    steps = _follow(run, segments, count)
    change = math.inf
    while count < _MAX_INCREMENTS and change > 1.0:
        count *= 2
        coarser = steps
        steps = _follow(run, segments, count)
        change = _compare(coarser, steps)
    warning: tuple[str, ...] = ()
    if change > 1.0:
        text = (
            f"{count} increments of a step are not enough: from half as many the numbers change by {change:.2g} times "
            "what is admissible; give more steps"
        )
        warning = (ContactWarning(text, "increments", change),)
    pairs = zip(segments, coarser, steps, strict=True)
    numbers = [
        _raw_numbers(fine)
        if segment.exact and all(one.exact for one in segments[:place])
        else _extrapolate(coarse, fine, warning)
        for place, (segment, coarse, fine) in enumerate(pairs)
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
    scale = max(float(np.abs(lost).sum()), _LEAST_LOSS * max(step.elastic_energy for step in fine))
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
    largest = max(float(np.abs(moved).max()), _LEAST_DISPLACEMENT * max(abs(step.approach) for step in fine))
    changes = (
        float(shift) / (_DISPLACEMENT_TOLERANCE * largest) if largest > 0.0 else 0.0,
        float(lost_shift) / (_ENERGY_TOLERANCE * scale) if scale > 0.0 else 0.0,
        *areas,
    )
    return max(changes)


def _raw_numbers(step: FrictionalSolution, warnings: tuple[str, ...] = ()) -> StepNumbers:
    x, y = (Estimate(value, 0.0, "m", warnings) for value in step.displacement)
    lost = step.dissipated if warnings else attrs.evolve(step.dissipated, uncertainty=0.0)
    return StepNumbers(
        displacement=(x, y),
        dissipated=attrs.evolve(lost, warnings=warnings),
        stick_area=attrs.evolve(step.stick_area, warnings=warnings),
    )


def _extrapolate(coarse: FrictionalSolution, fine: FrictionalSolution, warnings: tuple[str, ...]) -> StepNumbers:
    """Return the limits of infinitely many increments: the error is of first order in the increment."""

    def extend(
        old: float, new: float, unit: str, known: float = 0.0, low: float = -math.inf, high: float = math.inf
    ) -> Estimate:
        return Estimate(min(max(2.0 * new - old, low), high), math.hypot(abs(new - old), known), unit, warnings)

    x, y = (extend(old, new, "m") for old, new in zip(coarse.displacement, fine.displacement, strict=True))
    stick = fine.stick_area
    touching = int(np.count_nonzero(fine.contact.contact)) * fine.grid.cell_area
    return StepNumbers(
        displacement=(x, y),
        dissipated=extend(coarse.dissipated.value, fine.dissipated.value, "J", low=0.0),
        stick_area=extend(coarse.stick_area.value, stick.value, "m2", stick.uncertainty, 0.0, touching),
    )
