"""What the laws of a problem have changed of a contact, and what they remember."""

from __future__ import annotations

import math
from collections import ChainMap
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any, final

import attrs
import numpy as np

from roughcontact._base.archive import digest_of, short_digest
from roughcontact._base.archive.plain import Described, describe, missing_classes, rebuild
from roughcontact._base.arrays import Array, RealArray, frozen_array
from roughcontact._base.checks import MAX_MAGNITUDE, integer, number
from roughcontact._base.units import Estimate
from roughcontact._parts.grid import Grid, Load
from roughcontact._solve.solution.additions import Addition, Condition
from roughcontact._solve.solution.laws import CoupledProcess, Law, Memory, Process
from roughcontact._solve.solution.load_increment import MAX_SHIFT, LoadIncrement
from roughcontact._solve.solution.results import areas
from roughcontact.errors import InputError

_NOTHING: Memory = MappingProxyType({})
_PLAIN = ("laws", "remembered")
# What a file states of an increment, where it is not that of a single load.
_AT_ONCE = {"time": 0.0, "sliding": 0.0, "cycles": 1.0, "elapsed": 0.0, "slid": 0.0, "cycle": 0.0, "stiffening": 1.0}
# Difference between machines, and versions of numpy and scipy, of residuals, and of other numbers over their maximum:
# transforms differ by some 1e-15, Love's kernel by up to 5e-11 between its forms.
MACHINE_DIFFERENCE = 1e-10


@final
@attrs.frozen(eq=False, kw_only=True)
class Governed(Addition):
    """What the laws of a problem have changed of a contact, and what they remember.

    Attributes
    ----------
    laws
        The laws of the problem; empty of a file whose classes are not registered.
    remembered
        Meaning and unit of what each of them remembers, by name.
    offset
        What they add to the gap before deformation, at the end of the increment, shape (nx, ny), m.
    before, memory
        What each of them remembers at the begin and at the end of the increment.
    time, sliding
        Duration of the increment, s, and sliding distance in it, m.
    elapsed, slid
        Time, s, and sliding distance, m, since the first touch.
    cycles, cycle
        The cycles of loads for which the increment stands, and the last of them since the first touch; zero of loads
        that do not return.
    shift
        Cells (x, y) by which the counterbody is displaced from its first place.
    stiffening
        Contact modulus in the increment over that of the problem.
    local_compliance
        What the pressure on a cell adds to the gap there in the increment, m/Pa, a number or of shape (nx, ny).
    numbers
        Their numbers by name, each with its unit.
    added_conditions
        Their conditions of the certificate.
    previous
        What `identify` gives for the state at the place before on a path; empty at the first, and of other states.
    """

    kind = "laws"
    of_problem = True

    laws: tuple[Law, ...]
    remembered: tuple[Mapping[str, tuple[str, str]], ...]
    offset: Array
    before: tuple[Memory, ...]
    memory: tuple[Memory, ...]
    time: float = 0.0
    sliding: float = 0.0
    cycles: float = 1.0
    elapsed: float = 0.0
    slid: float = 0.0
    cycle: float = 0.0
    shift: tuple[int, int] = (0, 0)
    stiffening: float = 1.0
    local_compliance: float | Array = 0.0
    numbers: Mapping[str, Estimate | tuple[float, str]] = attrs.field(factory=dict)
    added_conditions: tuple[Condition, ...] = ()
    previous: str = ""

    @classmethod
    def begin(cls, problem: Any, increment: LoadIncrement, last: Any) -> Governed:
        """Return what the laws of a problem change in an increment that follows a state, or None at the first."""
        known = None if last is None else last._find_added(cls)
        if known is not None:
            return cls._change(problem, increment, known.memory, known.elapsed, known.slid)
        return cls._change(problem, increment, tuple(_start_memory(law, problem) for law in problem.laws))

    @classmethod
    def _change(
        cls,
        problem: Any,
        increment: LoadIncrement,
        before: tuple[Memory, ...],
        elapsed: float = 0.0,
        slid: float = 0.0,
    ) -> Governed:
        grid = problem.plan.grid
        stiffening = 1.0
        local: float | Array = 0.0
        for law, memory in zip(problem.laws, before, strict=True):
            stiffening *= number(
                law.find_stiffening(problem, increment, memory), f"The stiffening by {law!r}", above=0.0
            )
            local = local + _check_compliance(law.find_local_compliance(problem, increment, memory), grid, law)
        return cls(
            laws=problem.laws,
            remembered=tuple(map(_list_remembered, problem.laws)),
            offset=_add_changes(problem, increment, problem.laws, before),
            before=before,
            memory=before,
            time=increment.time,
            sliding=increment.sliding,
            cycles=increment.cycles,
            shift=increment.shift,
            elapsed=elapsed + increment.time,
            slid=slid + increment.sliding,
            stiffening=stiffening,
            local_compliance=local,
        )

    @property
    def is_implicit(self) -> bool:
        """Whether the pressure itself adds to the gap of its cell in the increment."""
        return bool(np.any(self.local_compliance))

    @property
    def responding(self) -> Law | None:
        """The law by which the displacement itself adds to the gap; None without one."""
        found = [law for law in self.laws if type(law).respond is not Law.respond]
        if len(found) > 1 or (found and self.is_implicit):
            raise InputError(f"Pressure itself may change a contact by one law alone: omit all but {found[0]!r}.")
        return found[0] if found else None

    @property
    def coupled(self) -> CoupledProcess | None:
        """The process that is solved together with the contact; None without one."""
        found = [law for law in self.laws if isinstance(law, CoupledProcess)]
        if len(found) > 1 or (found and (self.is_implicit or self.responding)):
            raise InputError(
                f"A process that is solved with the contact is alone in changing it: omit all but {found[0]!r}."
            )
        return found[0] if found else None

    def without_coupled(self, problem: Any, increment: LoadIncrement) -> Array:
        """Return what the other laws add to the gap, shape (nx, ny), m."""
        pairs = [pair for pair in zip(self.laws, self.before, strict=True) if pair[0] is not self.coupled]
        return _add_changes(problem, increment, *zip(*pairs, strict=True)) if pairs else np.zeros(self.offset.shape)

    def settle(self, problem: Any, increment: LoadIncrement, found: Memory) -> Governed:
        """Return it with what the coupled process remembers after the increment."""
        law = self.coupled
        assert law is not None
        kept = _check_memory(law, found, problem.plan.grid)
        memory = tuple(kept if one is law else known for one, known in zip(self.laws, self.before, strict=True))
        return attrs.evolve(self, memory=memory, offset=_add_changes(problem, increment, self.laws, memory))

    def press(self, problem: Any, pressure: Array) -> Governed:
        """Return it with what a pressure, shape (nx, ny), Pa, adds to the gap in the increment."""
        law = self.responding
        if law is not None:
            response = law.respond(problem, problem.displace(pressure))
            added = _check_field(response, problem.plan.grid, f"respond of {law!r}")
            return attrs.evolve(self, offset=frozen_array(self.offset + added))
        if not self.is_implicit:
            return self
        return attrs.evolve(self, offset=frozen_array(self.offset + self.local_compliance * pressure))

    def repeat(self, problem: Any, state: Any) -> Governed:
        """Return it anew from what the laws remembered before, and a state with its origin."""
        increment = self._find_increment(state)
        again = self._change(problem, increment, self.before).press(problem, state.pressure)
        if again.coupled is not None:
            again = again.settle(problem, increment, self.memory[again.laws.index(again.coupled)])
        again = attrs.evolve(again, elapsed=self.elapsed, slid=self.slid, cycle=self.cycle)
        return again.finish(state) if state.status.success else again

    def finish(self, state: Any) -> Governed:
        """Return what they remember, and their numbers and conditions, at the end of the increment."""
        increment = self._find_increment(state)
        memory = tuple(
            known if law is self.coupled else _remember(law, state, increment, before)
            for law, before, known in zip(self.laws, self.before, self.memory, strict=True)
        )
        numbers: dict[str, Estimate | tuple[float, str]] = {}
        conditions: list[Condition] = []
        for law, before, after in zip(self.laws, self.before, memory, strict=True):
            numbers |= law.list_numbers(state, after)
            conditions += law.list_conditions(state, after)
            if isinstance(law, CoupledProcess):
                conditions += law.judge(state.origin.scene, state, increment, before, after)
        return attrs.evolve(
            self, memory=memory, numbers=numbers, added_conditions=tuple(conditions), local_compliance=0.0
        )

    def _find_increment(self, state: Any) -> LoadIncrement:
        return LoadIncrement(Load.signed(**state.origin.load), self.time, self.sliding, self.cycles, self.shift)

    def begins_with(self, memory: tuple[Memory, ...]) -> bool:
        """Return whether the laws remembered just this at the begin of the increment."""
        pairs = zip(self.before, memory, strict=True)
        return all(np.array_equal(one[name], other[name]) for one, other in pairs for name in one)

    def require_same(self, again: Governed) -> None:
        """Raise `InputError` unless it is, up to rounding, what the laws give `again`."""
        pairs = [("change of the gap", self.offset, again.offset)]
        for stated, found in zip(self.memory, again.memory, strict=True):
            pairs += [(f"memory {name!r}", stated[name], found[name]) for name in found]
        stated_numbers, found_numbers = (
            {name: one.value if isinstance(one, Estimate) else one[0] for name, one in numbers.items()}
            for numbers in (self.numbers, again.numbers)
        )
        if stated_numbers.keys() != found_numbers.keys() or self.elapsed < self.time or self.slid < self.sliding:
            raise InputError("Its numbers contradict its laws.")
        pairs += [(name, np.array(stated_numbers[name]), np.array(found)) for name, found in found_numbers.items()]
        for one in again.conditions:
            if not one.holds:
                raise InputError(f"Its {one.name} is violated by {one.residual:.1e}: {one.meaning}.")
        for name, stated_field, found_field in pairs:
            scale = float(np.abs(found_field).max())
            if not np.abs(stated_field - found_field).max() <= MACHINE_DIFFERENCE * scale:
                raise InputError(f"Its {name} contradicts its laws and its fields.")

    def identify(self, state: Any) -> str:
        """Return digits by which a state, of which it is part, is known to the one that follows it on a path."""
        numbers = np.array([state.force, state.approach, self.time, self.sliding, self.elapsed, self.slid, *self.shift])
        fields = [one[name] for one in (*self.before, *self.memory) for name in sorted(one)]
        return short_digest(self.previous + "".join(map(digest_of, (numbers, state.pressure, *fields))))

    @property
    def conditions(self) -> tuple[Condition, ...]:
        """Those that the laws add."""
        return self.added_conditions

    @property
    def marks(self) -> frozenset[str]:
        """What answers must hold with: where a law changes the modulus, ``"relaxation"`` too."""
        return frozenset({self.kind} if all(law.keeps_modulus for law in self.laws) else {self.kind, "relaxation"})

    @property
    def limits(self) -> Mapping[str, str]:
        """What responses do not know of the laws, each with the reason of the first one."""
        pairs = zip(self.laws, self.memory, strict=False)
        return dict(ChainMap(*(dict(law.explain_limits(memory)) for law, memory in pairs)))

    def list_errors(self, state: Any) -> dict[str, float]:
        """Return what the laws add to the uncertainty of responses, by name."""
        found: dict[str, float] = {}
        for law, memory in zip(self.laws, self.memory, strict=False):
            for name, error in law.list_errors(state, memory).items():
                found[name] = math.hypot(found.get(name, 0.0), error)
        return found

    @property
    def default_area(self) -> str:
        """That with the fewest expectations, of the laws that, if they remember, had changed the surfaces before."""
        pairs = zip(self.laws, self.before, strict=True)
        known = (law.default_area for law, memory in pairs if not isinstance(law, Process) or _has_lengths(law, memory))
        return min(filter(None, known), key=lambda name: len(areas[name].expects), default="")

    @property
    def follows(self) -> bool:
        """Whether the laws remember anything of states before."""
        return any(map(_is_any, self.before))

    def list_numbers(self, state: Any) -> dict[str, Estimate | tuple[Any, str]]:
        """Return the numbers of the laws."""
        return dict(self.numbers)

    def list_rows(self, state: Any) -> dict[str, str]:
        """Return the laws, and their numbers in words."""
        return {"laws": "; ".join(map(repr, self.laws)), **super().list_rows(state)}

    def list_fields(self) -> dict[str, tuple[RealArray, str, str]]:
        """Return what the laws remember."""
        pairs = zip(self.remembered, self.memory, strict=True)
        return {
            name: (memory[name], *words)
            for names, memory in pairs
            for name, words in names.items()
            if memory[name].shape == self.offset.shape
        }

    def describe(self, arrays: dict[str, RealArray]) -> Described:
        """Return it as data for JSON; see `Addition.describe`."""
        # Numbers of laws state no sampling error.
        plain = attrs.filters.exclude("_relative_sampling")
        named = {
            name: attrs.asdict(one, filter=plain) if isinstance(one, Estimate) else one
            for name, one in self.numbers.items()
        }
        return {
            **{name: describe(getattr(self, name), arrays) for name in (*_PLAIN, "offset", "before", "memory")},
            **{name: getattr(self, name) for name in _AT_ONCE if getattr(self, name) != _AT_ONCE[name]},
            **({"previous": self.previous} if self.previous else {}),
            **({"shift": list(self.shift)} if self.shift != (0, 0) else {}),
            "numbers": describe(named, arrays),
            "conditions": describe([attrs.asdict(one) for one in self.added_conditions], arrays),
        }

    @classmethod
    def rebuild(cls, described: Mapping[str, Any], arrays: Mapping[str, RealArray], grid: Grid, given: Any) -> Governed:
        """Return what `describe` has described."""
        remembered = tuple(
            {str(name): (str(meaning), str(unit)) for name, (meaning, unit) in one.items()}
            for one in rebuild(described["remembered"], arrays)
        )
        known = () if missing_classes(described["laws"]) else described["laws"]
        laws: tuple[Law, ...] = tuple(rebuild(one, arrays, (Law,)) for one in known)
        checks = [_choose_check(law) for law in laws] or [_check_array] * len(remembered)
        before, memory = (
            tuple(
                {name: check(one[name], grid, f"memory {name!r}") for name in names}
                for check, names, one in zip(checks, remembered, rebuild(described[name], arrays), strict=True)
            )
            for name in ("before", "memory")
        )
        return cls(
            laws=laws,
            remembered=remembered,
            offset=_check_field(rebuild(described["offset"], arrays), grid, "change of the gap"),
            before=before,
            memory=memory,
            **{name: _check_length(described.get(name, one)) for name, one in _AT_ONCE.items()},
            previous=str(described.get("previous", "")),
            shift=_read_shift(described.get("shift", [0, 0])),
            numbers={name: _read_number(one) for name, one in rebuild(described["numbers"], arrays).items()},
            added_conditions=tuple(Condition(**one) for one in rebuild(described["conditions"], arrays)),
        )

    def __reduce__(self) -> tuple[Any, ...]:
        # Arrays in pickles and deep copies are writable: the checks make them read-only again. A read-only view of a
        # mapping has no pickle.
        memories = {name: tuple(map(dict, getattr(self, name))) for name in ("before", "memory")}
        return _restore, (attrs.asdict(self, recurse=False) | memories,)


def _restore(fields: dict[str, Any]) -> Governed:
    memories = {
        name: tuple({key: frozen_array(values) for key, values in one.items()} for one in fields[name])
        for name in ("before", "memory")
    }
    return Governed(**fields | memories | {"offset": frozen_array(fields["offset"])})


def _read_shift(stored: Any) -> tuple[int, int]:
    x, y = (integer(cells, "A displacement in cells", at_least=-MAX_SHIFT) for cells in stored)
    return x, y


def _read_number(stored: Any) -> Estimate | tuple[float, str]:
    if isinstance(stored, Mapping):
        return Estimate(**{**stored, "warnings": tuple(stored["warnings"])})
    value, unit = stored
    return float(value), str(unit)


def _is_any(memory: Memory) -> bool:
    return any(values.any() for values in memory.values())


def _has_lengths(law: Law, memory: Memory) -> bool:
    """Return whether a law remembers any length, such as a height that is lost."""
    units = _list_remembered(law)
    return any(values.any() for name, values in memory.items() if units[name][1] == "m" and values.ndim == 2)


def _list_remembered(law: Law) -> Mapping[str, tuple[str, str]]:
    return law.remembered if isinstance(law, Process) else {}


def _start_memory(law: Law, problem: Any) -> Memory:
    names = _list_remembered(law)
    grid = problem.plan.grid
    if isinstance(law, CoupledProcess):
        return MappingProxyType(_check_memory(law, law.start(problem), grid))
    return MappingProxyType({name: frozen_array(np.zeros(grid.shape)) for name in names}) if names else _NOTHING


def _remember(law: Law, state: Any, increment: LoadIncrement, before: Memory) -> Memory:
    if not isinstance(law, Process):
        return before
    return _check_memory(law, law.remember(state, increment, before), state.grid)


def _check_memory(law: Process, found: object, grid: Grid) -> dict[str, Array]:
    if not isinstance(found, Mapping) or set(found) != set(law.remembered):
        raise InputError.about(f"What {law!r} remembers", found, f"a mapping with {', '.join(law.remembered)}")
    check = _choose_check(law)
    return {name: check(found[name], grid, f"{name} of {law!r}") for name in law.remembered}


def _add_changes(problem: Any, increment: LoadIncrement, laws: Sequence[Law], memories: Sequence[Memory]) -> Array:
    """Return what laws add to the gap by what they remember, shape (nx, ny), m."""
    grid = problem.plan.grid
    offset = np.zeros(grid.shape)
    for law, memory in zip(laws, memories, strict=True):
        offset += _check_field(law.change_gap(problem, increment, memory), grid, f"change_gap of {law!r}")
    return frozen_array(offset)


def _check_length(value: object) -> float:
    return number(value, "A time, a distance, or cycles of its laws", at_least=0.0)


def _check_compliance(values: object, grid: Grid, law: Law) -> float | Array:
    found = np.asarray(values)
    if found.shape == ():
        return number(values, f"The local compliance of {law!r}", "m/Pa", at_least=0.0)
    field = _check_field(values, grid, f"find_local_compliance of {law!r}")
    if field.min() < 0.0:
        raise InputError.about(f"The local compliance of {law!r}", values, "at least zero (m/Pa)")
    return field


def _choose_check(law: Law) -> Callable[[object, Grid, str], Array]:
    return _check_array if isinstance(law, CoupledProcess) else _check_field


def _check_array(values: object, grid: Grid, what: str) -> Array:
    """Return an array of any shape; `InputError` unless its values are finite numbers."""
    array = np.asarray(values)
    if array.dtype.kind not in "fiu" or not np.abs(array).max(initial=0.0) <= MAX_MAGNITUDE:
        raise InputError(f"The {what} must be finite numbers, but it is an array of type {array.dtype}.")
    return frozen_array(np.array(array, dtype=np.float64))


def _check_field(values: object, grid: Grid, what: str) -> Array:
    field = np.asarray(values)
    if field.shape != grid.shape or field.dtype.kind not in "fiu" or not np.abs(field).max() <= MAX_MAGNITUDE:
        raise InputError(
            f"The {what} must be finite numbers of shape {grid.shape}, but it is an array of shape {field.shape} and "
            f"type {field.dtype}."
        )
    return frozen_array(np.array(field, dtype=np.float64))
