"""Plastic flow below one surface or both as a process that is solved together with the contact."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from typing import Any, ClassVar

import attrs
import numpy as np
import roughcontact as rc
from roughcontact.results import Condition
from roughcontact.typing import Array, Load, LoadIncrement

from roughcontact_volume.cell_maximum import find_imprint_error
from roughcontact_volume.forecast import forecast_flow
from roughcontact_volume.judgement import judge_flow
from roughcontact_volume.measures import measure_flow
from roughcontact_volume.refusals import require_possible
from roughcontact_volume.substeps import ANSWERS, FlowingBody, PlasticState, SubstepMarch
from roughcontact_volume.yielding import Yielding

# Admissible error of the flow in a step.
_TOLERANCE = 1e-4
# Difference of two loads, over them, below which they are the same: then substeps change nothing.
_SAME_LOAD = 1e-6
# What of the error of an imprint by the cells the approach and the mean gap under a force take, and of the relative
# error of the pressure the area; set on seed 1 and half of seed 2 of `measure_scenes.py`.
_PART_IN_APPROACH = 0.3
_PART_IN_AREA = 0.5
_FIELDS = tuple(attrs.fields_dict(PlasticState))
_SIDES = {"body": ("body",), "counterbody": ("counterbody",), "both": ("body", "counterbody")}
# What is remembered of a body, with its unit.
_REMEMBERED = {
    "plastic_strain": ("plastic strain xx, yy, zz, yz, xz, xy below the surface", ""),
    "accumulated_strain": ("accumulated plastic strain below the surface", ""),
    "last_flow": ("plastic strain that flowed in the last substep", ""),
    "imprint": ("displacement of the surface by the plastic strain, into the body", "m"),
    "step_errors": (f"errors of {', '.join(ANSWERS)} by the substeps, in SI units", ""),
    "last_load": ("force, N, and approach, m, at the end of the increment", ""),
}
# Numbers of a state that are not those of one of the bodies.
_COMMON = frozenset(f"step_error_of_{name.replace(' ', '_')}" for name in ANSWERS if name != "imprint")


def _of(value: object) -> str:
    if value not in _SIDES:
        raise rc.InputError.about("The body that flows", value, "'body', 'counterbody' or 'both'")
    return str(value)


@attrs.frozen
class PlasticFlow(rc.CoupledProcess):
    r"""The plastic flow of a body of the material `Plastic`, which brings it, or of both.

    The plastic strain :math:`\varepsilon` in cells below the surface leaves the residual stress
    :math:`T \varepsilon` and the imprint :math:`U \varepsilon`, an offset of the gap. In an increment of the load it
    grows until the stress is nowhere beyond the yield surface, with the contact on the changed gap solved in each
    evaluation. Each body keeps its fields in its own frame, with z into it.

    Parameters
    ----------
    of
        The body that flows: ``"body"``, ``"counterbody"`` or ``"both"``.
    is_stressed
        Whether one of them has a residual stress before any load.

    References
    ----------
    Jacq, Nelias, Lormand, Girodin, J. Tribol. 124 (2002) 653-667, https://doi.org/10.1115/1.1467920

    Examples
    --------
    A ball is pressed into steel that flows, lifted, and pressed again, when nothing flows:

    >>> import roughcontact as rc
    >>> from roughcontact_volume import Plastic
    >>> steel = Plastic("210GPa", 0.3, yield_stress="1GPa", hardening="4GPa")
    >>> ball = rc.Body(rc.ParaboloidSurface("1mm"), rc.Rigid())
    >>> problem = rc.ContactProblem(ball, rc.Body(rc.FlatSurface(), steel), grid=rc.Grid((12, 12), "100um"))
    >>> path = problem.path(force=["2N", "0N", "2N"])
    >>> [f"{work * 1e9:.0f} nJ" for work in path.table().columns["plastic_work"]]
    ['37 nJ', '37 nJ', '37 nJ']
    """

    of: str = attrs.field(default="body", converter=_of)
    is_stressed: bool = attrs.field(default=False, kw_only=True, repr=False)

    rates: ClassVar[tuple[str, ...]] = ()
    of_material: ClassVar[bool] = True
    follows_bodies: ClassVar[bool] = True
    left_behind: ClassVar[str] = "the residual stress and the hardening below the surface"

    @property
    def sides(self) -> tuple[str, ...]:
        """The bodies that flow."""
        return _SIDES[self.of]

    @property
    def remembered(self) -> Mapping[str, tuple[str, str]]:  # type: ignore[override]
        """Meaning and unit of what it remembers, of two bodies that of each."""
        if self.of != "both":
            return _REMEMBERED
        return {
            self._name(name, side): (f"{side}: {meaning}", unit)
            for side in self.sides
            for name, (meaning, unit) in _REMEMBERED.items()
        }

    def join(self, other: rc.CoupledProcess) -> PlasticFlow | None:
        """Return the flow of both bodies; see `CoupledProcess.join`."""
        if not isinstance(other, PlasticFlow) or {self.of, other.of} != {"body", "counterbody"}:
            return None
        return PlasticFlow("both", is_stressed=self.is_stressed or other.is_stressed)

    def read(self, memory: Mapping[str, Array], side: str) -> Mapping[str, Array]:
        """Return what is remembered of a side, by the names of a single body."""
        return {name: memory[self._name(name, side)] for name in _REMEMBERED}

    def start(self, problem: Any) -> Mapping[str, Array]:
        """Return what is remembered of fresh bodies: nothing, in the uppermost layer alone."""
        require_possible(problem)
        fresh = PlasticState.fresh(problem.plan.grid.shape, 1)
        beside = {"step_errors": np.zeros(len(ANSWERS)), "last_load": np.zeros(2)}
        return self._join_sides([_describe(fresh) | beside for _ in self.sides])

    def change_gap(self, problem: Any, increment: LoadIncrement, memory: Mapping[str, Array]) -> Array:
        """Return the imprints where their bodies lie, m; see `Law.change_gap`."""
        placed = [_place(side, increment, self.read(memory, side)["imprint"]) for side in self.sides]
        return np.asarray(np.sum(placed, axis=0))

    def settle(
        self, problem: Any, press: Any, increment: LoadIncrement, memory: Mapping[str, Array]
    ) -> Mapping[str, Array]:
        """Return what is remembered after an increment of the load, in substeps that its answers ask for."""
        grid = problem.plan.grid
        bodies = [
            FlowingBody(
                _find_material(problem, side), partial(_place, side, increment), partial(_back, side, increment)
            )
            for side in self.sides
        ]
        march = SubstepMarch(grid, problem.boundary, tuple(bodies), press, _TOLERANCE)
        before = [self.read(memory, side) for side in self.sides]
        is_divisible = not _is_same(increment, grid, before[0]["last_load"])
        states, change = march.settle(tuple(map(_read, before)), is_divisible=is_divisible)
        last_load = np.array([march.contact.force, march.contact.approach])
        found = []
        for number, (state, known) in enumerate(zip(states, before, strict=True)):
            own = np.append(change[:3], change[3 + number])
            errors = np.hypot(known["step_errors"], own)
            found.append(_describe(state) | {"step_errors": errors, "last_load": last_load})
        return self._join_sides(found)

    def judge(
        self,
        problem: Any,
        state: Any,
        increment: LoadIncrement,
        before: Mapping[str, Array],
        after: Mapping[str, Array],
    ) -> Iterable[Condition]:
        """Return the conditions of plastic flow, with the stress recomputed from pressure and plastic strain."""
        for side in self.sides:
            material = _find_material(problem, side)
            pressure = _back(side, increment, state.pressure)
            for one in judge_flow(
                problem.plan.grid, problem.boundary, material, pressure, _read(self.read(after, side))
            ):
                yield attrs.evolve(one, name=f"{one.name} of the {side}") if self.of == "both" else one

    def list_errors(self, state: Any, memory: Mapping[str, Array]) -> Mapping[str, float]:
        """Return the errors of maximum pressure, area, approach and mean gap by the substeps, and by the cells.

        To fit an imprint of another depth the pressure changes by E* times the difference over the size of the plastic
        zone, the area under the same force with it, and the approach by less than the difference.
        """
        bodies = [self.read(memory, side) for side in self.sides]
        pressure, approach, *_ = bodies[0]["step_errors"].tolist()
        known = [find_imprint_error(state.grid, one["accumulated_strain"], one["imprint"]) for one in bodies]
        moved = math.hypot(approach, _PART_IN_APPROACH * sum(deeper for deeper, _ in known))
        errors = {"approach": moved, "mean-gap": moved}
        largest = float(state.pressure.max())
        if largest <= 0.0:
            return errors
        by_cells = state.modulus * sum(deeper / depth for deeper, depth in known if depth > 0.0)
        touching = float(np.count_nonzero(state.pressure > 0.0)) * state.grid.cell_area
        area = _PART_IN_AREA * touching * min(1.0, by_cells / largest)
        return {"peak-pressure": math.hypot(pressure, by_cells), "area": area, **errors}

    def explain_limits(self, memory: Mapping[str, Array]) -> Mapping[str, str]:
        """Return what a body that has flowed asks of responses; see `Law.explain_limits`."""
        if not any(self.read(memory, side)["accumulated_strain"].any() for side in self.sides):
            stress = "the material has a residual stress, which the pressure does not tell"
            return {"inner stress": f"{stress}: ask for 'total-stress' or 'own-yield'"} if self.is_stressed else {}
        stress = "plastic flow leaves a stress below the surface, which the pressure does not tell"
        return {
            "inner stress": f"{stress}: ask for the response 'total-stress'",
            "inner flow": "the body may flow as the load changes: ask for the stiffness on unloading",
        }

    def explain_work(self, problem: Any, load: Load | None) -> Iterable[tuple[str, str]]:
        """Return the box that a load takes, its memory, and the stresses that are computed; see `Law.explain_work`."""
        for side in self.sides:
            for name, text in forecast_flow(problem, _find_material(problem, side), load):
                yield f"{name} of the {side}" if self.of == "both" else name, text

    def divide(self, problem: Any, memory: Mapping[str, Array]) -> tuple[float | Array, float | Array]:
        """Return the imprints as what their bodies have lost of their heights, m."""
        lost = {side: self.read(memory, side)["imprint"] for side in self.sides}
        return lost.get("body", 0.0), lost.get("counterbody", 0.0)

    def list_numbers(self, state: Any, memory: Mapping[str, Array]) -> Mapping[str, Any]:
        """Return the size of the plastic zone of each body, what flowed in it, and what is left of it."""
        problem, kinds = state.origin.scene, state.origin.load
        found: dict[str, Any] = {}
        for side in self.sides:
            known = self.read(memory, side)
            material = _find_material(problem, side)
            numbers = measure_flow(
                problem.plan.grid, problem.boundary, material, _read(known), known["step_errors"], kinds
            )
            found |= {name if name in _COMMON else self._name(name, side): one for name, one in numbers.items()}
        return found

    def _name(self, name: str, side: str) -> str:
        """Return the name of something of a side among those of both."""
        return f"{name}_of_{side}" if self.of == "both" else name

    def _join_sides(self, found: Sequence[Mapping[str, Array]]) -> dict[str, Array]:
        pairs = zip(self.sides, found, strict=True)
        return {self._name(name, side): values for side, one in pairs for name, values in one.items()}


def _find_material(problem: Any, side: str) -> Yielding:
    material = getattr(problem, side).material
    if not isinstance(material, Yielding):
        raise rc.InputError.about(f"The material of the {side} that flows", material, "a Plastic")
    return material


def _place(side: str, increment: LoadIncrement, values: Array) -> Array:
    return np.asarray(increment.place(values)) if side == "counterbody" else values


def _back(side: str, increment: LoadIncrement, values: Array) -> Array:
    return np.asarray(increment.place_back(values)) if side == "counterbody" else values


def _read(memory: Mapping[str, Array]) -> PlasticState:
    return PlasticState(**{name: memory[name] for name in _FIELDS})


def _describe(state: PlasticState) -> dict[str, Array]:
    return {name: getattr(state, name) for name in _FIELDS}


def _is_same(increment: LoadIncrement, grid: rc.Grid, last: Array) -> bool:
    """Return whether the load is that at the end of the increment before."""
    force, approach = last.tolist()
    before = {"force": force, "pressure": force / grid.area, "approach": approach}[increment.load.kind]
    return bool(abs(increment.load.value - before) <= _SAME_LOAD * abs(before))
