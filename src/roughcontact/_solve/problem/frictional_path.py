"""Paths of normal and tangential loads with friction: their increments, extrapolated numbers, and energy lost."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from pathlib import Path as File
from typing import Any

import attrs
import numpy as np

from roughcontact._base import checks
from roughcontact._base.arrays import Array, read_only
from roughcontact._base.tables import Table
from roughcontact._base.units import Estimate, Force, Length, PlainText, Pressure, counted, outlined
from roughcontact._parts.interactions import FrictionLaw
from roughcontact._solve.problem.body import Body
from roughcontact._solve.problem.coupled import CoupledSolve
from roughcontact._solve.problem.fretting import follow_cycles, list_cycles
from roughcontact._solve.problem.friction_plan import (
    include_friction,
    list_omitted_shear,
    list_pair,
    write_rows,
)
from roughcontact._solve.problem.increments import (
    AS_GIVEN,
    Increment,
    follow_loads,
    is_single,
    list_steps,
    list_targets,
)
from roughcontact._solve.problem.load_path import PATH_ACCURACY, find_bodies, require_omitted
from roughcontact._solve.problem.path import Path
from roughcontact._solve.problem.plan import SolvePlan
from roughcontact._solve.problem.step_numbers import StepNumbers
from roughcontact._solve.problem.sweep import tabulate_added
from roughcontact._solve.solution import ContactSolution, Governed, find_load, read_estimate, read_states
from roughcontact.errors import InputError, argument

# States that a picture draws in each step, and the states of a path of which it draws more.
_DRAWN_STATES = 10
_MAX_REFINED_STATES = 12
# Numbers over the largest of their kind that a table shows as zero.
_TABLE_ROUNDING = 1e-9


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
class FrictionalPath(Path):
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
    accuracy
        Admissible height that is lost at once in many cycles of loads, over the approach.
    cycle_wear
        Largest height that is lost in one of the last cycles, m; zero of loads that do not return.

    Examples
    --------
    Half a fretting cycle of a ball:

    >>> import roughcontact as rc
    >>> steel = rc.Elastic(young=210e9, poisson=0.3)
    >>> ball, flat = rc.Body(rc.SphereSurface(radius=1e-3), steel), rc.Body(rc.FlatSurface(), steel)
    >>> problem = rc.ContactProblem(ball, flat, grid=rc.Grid((32, 32), 100e-6))
    >>> path = problem.path(force=1.0, tangential_force=[(0.2, 0.0), (-0.2, 0.0)], friction=0.3)
    >>> len(path), [f"{x * 1e9:.1f} nm" for x in path.loop.displacement[:, 0]]
    (2, ['0.0 nm', '65.8 nm', '-65.8 nm'])
    """

    kind = "frictional path"
    view = "path"
    curve = "tangential force over the displacement"

    states: tuple[ContactSolution, ...]
    pressed: ContactSolution | None
    numbers: tuple[StepNumbers, ...]
    increments: tuple[int, ...]
    reasons: tuple[str, ...]
    accuracy: float = PATH_ACCURACY
    cycle_wear: float = 0.0

    @property
    def cycles(self) -> Array:
        """The cycle of loads of each state; zero of loads that do not return."""
        effects = (state._find_added(Governed) for state in self.states)
        return np.array([0.0 if effect is None else effect.cycle for effect in effects])

    @property
    def bodies(self) -> tuple[Body, Body]:
        """Both bodies with the heights that they have after the path, unloaded; see `LoadPath.bodies`."""
        return find_bodies(self.states[-1])

    @property
    def detailed(self) -> ContactSolution:
        """The state that a page shows in detail, the last one."""
        return self.states[-1]

    @cached_property
    def loop(self) -> TangentialLoop:
        """Tangential force over displacement, from the start of the path."""
        start = self.pressed
        forces = [(0.0, 0.0) if start is None else start.tangential_force]
        forces += [(one.tangential_force[0].value, one.tangential_force[1].value) for one in self.numbers]
        moved = [(0.0, 0.0) if start is None else start.tangential_displacement]
        moved += [(one.displacement[0].value, one.displacement[1].value) for one in self.numbers]
        unsure = [(0.0, 0.0)]
        unsure += [(one.displacement[0].uncertainty, one.displacement[1].uncertainty) for one in self.numbers]
        return TangentialLoop(np.array(forces), np.array(moved), np.array(unsure))

    @property
    def dissipated(self) -> Estimate:
        """Energy lost by friction in the states of the path, J, without that of pressing; with its uncertainty."""
        return _sum_lost(self.numbers)

    @property
    def work(self) -> Array:
        """Energy lost by friction at each place in each step, by the slip at its end, shape (n, nx, ny), J/m2.

        It is what models of fretting wear take; its sum over the cells is that of a step in one increment.
        """
        return np.stack([np.einsum("aij,aij->ij", one.sheared.traction, one.slip) for one in self.states])

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """Why numbers of the path must not be trusted, in sentences; empty without a reason."""
        parts = [part for one in self.numbers for part in (*one.displacement, one.dissipated, one.stick_area)]
        found = [text for part in parts for text in part.warnings]
        return tuple(dict.fromkeys([*found, *(text for state in self.states for text in state.warnings)]))

    @cached_property
    def drawn_loop(self) -> TangentialLoop:
        """The loop with states between those of the path, which a picture needs: a turn alone is a straight line.

        Where the path has many states, its increments are not exact, or its problem is not known, it is `loop`.
        """
        origin = self.states[0].origin
        exact = self.pressed is not None and all(count == 1 for count in self.increments) and not self.cycles.any()
        if origin is None or origin.missing or not exact or len(self) > _MAX_REFINED_STATES:
            return self.loop
        parts = np.arange(1, _DRAWN_STATES + 1)[:, np.newaxis] / _DRAWN_STATES
        ends = np.array([(0.0, 0.0), *(state.tangential_load.values for state in self.states)])
        targets = np.concatenate([old + parts * (new - old) for old, new in itertools.pairwise(ends)])
        # To the last bit: the turns are states of the path.
        targets[_DRAWN_STATES - 1 :: _DRAWN_STATES] = ends[1:]
        along = {self.states[0].tangential_load.kind: targets.tolist()}
        path: FrictionalPath = origin.scene.path(**origin.load, **along, friction=self.states[0].friction, substeps=1)
        return path.loop

    def extend(
        self,
        *,
        force: Iterable[Force] | None = None,
        pressure: Iterable[Pressure] | None = None,
        approach: Iterable[Length] | None = None,
        tangential_force: Iterable[Sequence[Force]] | Sequence[Force] | None = None,
        displacement: Iterable[Sequence[Length]] | Sequence[Length] | None = None,
        cycles: Iterable[float] | None = None,
        substeps: int | str = "auto",
    ) -> FrictionalPath:
        """Return the path continued from its last state, such as one from a file; see `ContactProblem.path`.

        Loads are of the kinds of the path. Where one normal load holds for all steps it holds on; a path of cycles is
        continued by `cycles` alone, which count from its start.

        Examples
        --------
        >>> import roughcontact as rc
        >>> steel = rc.ElasticPerfectlyPlastic(young=210e9, poisson=0.3, hardness=1e9)
        >>> ball, flat = rc.Body(rc.SphereSurface(radius=1e-3), steel), rc.Body(rc.FlatSurface(), steel)
        >>> problem = rc.ContactProblem(ball, flat, grid=rc.Grid((32, 32), 100e-6))
        >>> path = problem.path(force=[2.0, 1.0], tangential_force=[(0.3, 0.0), (0.0, 0.0)], friction=0.3, substeps=2)
        >>> len(path.extend(force=[2.0], tangential_force=(0.3, 0.0), substeps=2))
        3
        """
        last = self.states[-1]
        if last.origin is None:
            raise InputError("The path does not say which problem it followed, so that it cannot be continued.")
        known = self.list_arguments()
        count = None if substeps == "auto" else checks.integer(substeps, argument("substeps"), at_least=1)
        run = CoupledSolve(last.origin.scene, known["friction"])
        kind = next(name for name in ("force", "pressure", "approach") if name in known)
        along = last.tangential_load.kind
        given: dict[str, Any] = {"force": force, "pressure": pressure, "approach": approach}
        pushed: dict[str, Any] = {"tangential_force": tangential_force, "displacement": displacement}
        if self.cycles.any():
            require_omitted(given | pushed, "for loads that do not return")
            segments = list_steps(run, {kind: known[kind]}, {along: known[along]})
            places = list_cycles(cycles)
            if places[0] <= self.cycles[-1]:
                raise InputError(
                    f"The path ends with cycle {self.cycles[-1]:g}: cycles count from its start, and rise."
                )
            before = self.states[-len(self._first_cycle) :]
            steps, numbers, reasons, wear = follow_cycles(
                run, segments, count, places, self.accuracy, _tell_nothing, before, self.cycle_wear
            )
        else:
            require_omitted({"cycles": cycles}, "for loads that return")
            targets = list_targets(pushed)
            if targets[0].kind != along:
                raise InputError(f"The path is along {along}=: continue it so.")
            normal = known[kind]
            if self.pressed is not None:
                require_omitted(given, "where the normal load changes")
            elif given[kind] is None or any(value is not None for name, value in given.items() if name != kind):
                raise InputError(f"The path has normal loads by {kind}=: continue it so.")
            else:
                more = [given[kind]] if is_single({kind: given[kind]}) else list(given[kind])
                targets = targets * len(more) if len(targets) == 1 else targets
                normal = [*normal, *more]
            every = [*known[along], *(target.values for target in targets)]
            segments = list_steps(run, {kind: normal}, {along: every})[-len(targets) :]
            steps, numbers, reasons = follow_loads(run, segments, count, _tell_nothing, last)
            wear = 0.0
        return self._append(steps, numbers, reasons, wear)

    def _append(
        self,
        states: Sequence[ContactSolution],
        numbers: Sequence[StepNumbers],
        reasons: Sequence[str],
        cycle_wear: float,
    ) -> FrictionalPath:
        """Return the path with more states at its end, and what `extend` needs to go on from these."""
        return attrs.evolve(
            self,
            states=(*self.states, *states),
            numbers=(*self.numbers, *numbers),
            increments=(*self.increments, *(state.sheared.increments for state in states)),
            reasons=(*self.reasons, *reasons),
            cycle_wear=cycle_wear,
        )

    def table(self) -> Table:
        """Return a row for each step, in SI units; see `roughcontact.typing.Table`."""
        remembered, remembered_units = tabulate_added(self.states, Governed)
        columns: dict[str, Any] = {
            **({"cycle": self.cycles} if self.cycles.any() else {}),
            "force": np.array([state.force for state in self.states]),
            **{f"tangential_{axis}": self._forces(k) for k, axis in enumerate("xy")},
            **{f"displacement_{axis}": self._displacements(k) for k, axis in enumerate("xy")},
            "dissipated": [one.dissipated for one in self.numbers],
            "stick_area": [one.stick_area for one in self.numbers],
            "approach": np.array([state.approach for state in self.states]),
            "increments": list(self.increments),
            **remembered,
        }
        units = {"force": "N", "tangential_x": "N", "tangential_y": "N", "approach": "m"}
        return Table(columns, units | remembered_units)

    def _forces(self, axis: int) -> Any:
        values = _without_rounding(self.loop.force[1:])[:, axis]
        if self.states[0].tangential_load.kind != "displacement":
            return values
        return [
            attrs.evolve(one.tangential_force[axis], value=value)
            for one, value in zip(self.numbers, values.tolist(), strict=True)
        ]

    def _displacements(self, axis: int) -> list[Estimate]:
        values = _without_rounding(self.loop.displacement[1:])[:, axis].tolist()
        return [
            attrs.evolve(one.displacement[axis], value=value) for one, value in zip(self.numbers, values, strict=True)
        ]

    def explain(self) -> str:
        """Return the constants of the pair, the increments with their reasons, and what was omitted, in words."""
        first = self.states[0]
        pair = first.sheared.pair
        passes = max(state.sheared.passes for state in self.states)
        omitted = list_omitted_shear(pair)
        if pair.beta == 0.0 and self.pressed is not None:
            omitted.append(("omitted", "tangential solve of pressing: without a tangential load nothing moves"))
        rows = [
            *list_pair(pair, passes),
            *(
                (f"step {number}", f"{counted(count, 'increment')}: {reason}")
                for number, (count, reason) in enumerate(zip(self.increments, self.reasons, strict=True), 1)
            ),
            *omitted,
        ]
        return PlainText("\n".join(write_rows(rows)))

    @property
    def given(self) -> Sequence[ContactSolution]:
        """The states whose normal loads were given: under one load the bodies are pressed first, and then moved."""
        return self._first_cycle if self.pressed is None else self.states[:1]

    @property
    def _first_cycle(self) -> tuple[ContactSolution, ...]:
        """The states of the first cycle of loads; all if the loads do not return."""
        return self.states[: int(np.count_nonzero(self.cycles == self.cycles[0]))]

    @property
    def dissipated_in_loop(self) -> Estimate | None:
        """Energy lost since the loads last were those at the end of the path, J; None if they never were."""
        states = self._saved_states
        numbers = self.numbers[len(self.numbers) - len(states) + 1 :]
        loads = [(find_load(state), state.tangential_load.values) for state in states]
        for back in range(2, len(states)):
            if loads[-1 - back] == loads[-1]:
                return _sum_lost(numbers[-back:])
        return None

    def explain_plan(self, plan: SolvePlan | None) -> str:
        """Return the plan of the normal contact, if it is known, and `explain`."""
        return self.explain() if plan is None else f"{include_friction(plan)}\n{self.explain()}"

    def list_arguments(self) -> dict[str, Any]:
        """Return the arguments of `ContactProblem.path`."""
        along = [state.tangential_load for state in self._first_cycle]
        found = super().list_arguments()
        if self.pressed is not None:
            # Under one load the bodies are pressed first, and then moved.
            found = {kind: values[0] for kind, values in found.items()}
        found |= {along[0].kind: [one.values for one in along], "friction": self[0].friction}
        given = self.reasons.index(AS_GIVEN) if AS_GIVEN in self.reasons else None
        if self.cycles.any():
            found |= {"cycles": np.unique(self.cycles).tolist(), "accuracy": self.accuracy}
            given = None if max(self.increments) == 1 else int(np.argmax(self.increments))
        return found if given is None else {**found, "substeps": self.increments[given]}

    def list_numbers(self) -> Mapping[str, Estimate | None]:
        """Return the energy lost along the path, and in its last loop if it ends with one."""
        return {"dissipated": self.dissipated, "loop": self.dissipated_in_loop}

    def list_rest(self) -> Mapping[str, Any]:
        """Return the constants of the pair of materials."""
        return {"pair": attrs.asdict(self.states[0].sheared.pair)}

    def label_states(self) -> tuple[Table, list[str]]:
        """Return the number of each state with its tangential loads, and its name in a sentence."""
        table = self.table()
        along = [name for name in ("tangential_x", "tangential_y") if any(map(_is_pushed, table.columns[name]))]
        numbers = range(1, len(self) + 1)
        heads = Table({"state": numbers, **{name: table.columns[name] for name in along}}, table.units)
        return heads, [f"state {number}" for number in numbers]

    @property
    def _saved_states(self) -> tuple[ContactSolution, ...]:
        return (*([] if self.pressed is None else [self.pressed]), *self.states)

    def _note_rest(self) -> dict[str, Any]:
        numbers = [attrs.asdict(one) for one in self.numbers]
        return {
            "key": "",
            "pressed": self.pressed is not None,
            "increments": list(self.increments),
            "reasons": list(self.reasons),
            "numbers": numbers,
            "accuracy": self.accuracy,
            "cycle_wear": self.cycle_wear,
        }

    @classmethod
    def _restore(cls, states: tuple[ContactSolution, ...], notes: Mapping[str, Any]) -> FrictionalPath:
        pressed, *rest = states if notes["pressed"] else (None, *states)
        if any(len(notes[name]) != len(rest) for name in ("numbers", "increments", "reasons")):
            raise InputError("The file is damaged: its numbers are not those of its states.")
        numbers = (_read_numbers(one, state) for one, state in zip(notes["numbers"], rest, strict=True) if state)
        return cls(
            states=tuple(state for state in rest if state),
            pressed=pressed,
            numbers=tuple(numbers),
            increments=tuple(int(count) for count in notes["increments"]),
            reasons=tuple(str(text) for text in notes["reasons"]),
            # Former files have no cycles.
            accuracy=float(notes.get("accuracy", PATH_ACCURACY)),
            cycle_wear=float(notes.get("cycle_wear", 0.0)),
        )

    def _list_results(self) -> Mapping[str, str]:
        found = {"energy lost": self.dissipated, "in the last loop": self.dissipated_in_loop}
        texts = {name: str(attrs.evolve(one, warnings=())) for name, one in found.items() if one is not None}
        if self.cycles.any():
            # That of the states is not that of the cycles between them.
            del texts["energy lost"]
        last = self.states[-1]
        effect = last._find_added(Governed)
        texts |= {} if effect is None else effect.list_rows(last)
        texts["friction"] = repr(self.states[0].friction)
        return texts | {"status": "; ".join(dict.fromkeys(str(state.status) for state in self))}

    def __repr__(self) -> str:
        return f"<FrictionalPath {counted(len(self), 'state')}, {self.states[0].grid}, lost {self.dissipated}>"


def _tell_nothing(done: Increment) -> None:
    pass


def _sum_lost(steps: Sequence[StepNumbers]) -> Estimate:
    """Return the energy lost in steps together, J."""
    parts = [one.dissipated for one in steps]
    warnings = dict.fromkeys(text for part in parts for text in part.warnings)
    value = math.fsum(part.value for part in parts)
    return Estimate(value, math.fsum(part.uncertainty for part in parts), "J", tuple(warnings))


def _is_pushed(force: float | Estimate) -> bool:
    return (force.value if isinstance(force, Estimate) else force) != 0.0


def save_path(file: File, path: FrictionalPath, key: str) -> None:
    """Write a path under the key by which a study finds it; see `FrictionalPath.save`."""
    path._save(file, key=key)


def read_frictional_path(file: File, *, verify: bool, key: str = "", law: FrictionLaw | None = None) -> FrictionalPath:
    """Return the path in a file; see `FrictionalPath.load`.

    Parameters
    ----------
    file, verify
        The file, and whether to recompute the certificate of each state.
    key
        The key that it must have; empty: any.
    law
        Its friction law, which then need not be registered; None: the one in the file.
    """
    given = {} if law is None else {"shear": law}
    states, notes = read_states(file, FrictionalPath.kind, verify=verify, given=given)
    if key not in ("", notes.get("key")):
        raise InputError(f"The file {file.name} does not hold the path with the key {key}.")
    return FrictionalPath._rebuild(file, states, notes)


def _read_numbers(stored: Mapping[str, Any], state: ContactSolution) -> StepNumbers:
    def read_pair(name: str) -> tuple[Estimate, Estimate]:
        x, y = map(read_estimate, stored[name])
        return x, y

    # Files of the first version do not state the error of the force.
    pushed = tuple(Estimate(value, 0.0, "N") for value in state.tangential_force)
    return StepNumbers(
        displacement=read_pair("displacement"),
        tangential_force=read_pair("tangential_force") if "tangential_force" in stored else (pushed[0], pushed[1]),
        dissipated=read_estimate(stored["dissipated"]),
        stick_area=read_estimate(stored["stick_area"]),
    )


def _without_rounding(values: Array) -> Array:
    """Return values with zeros in place of those that are rounding beside the largest one."""
    return np.where(np.abs(values) < _TABLE_ROUNDING * np.abs(values).max(), 0.0, values)
