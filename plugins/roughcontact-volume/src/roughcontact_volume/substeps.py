"""An increment of the load in substeps, as many as its answers ask for, each with the contact solved inside.

One body flows, or both do.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import attrs
import numpy as np
import roughcontact as rc
from roughcontact.typing import Array

from roughcontact_volume.box import count_deeper, count_layers, find_operators, find_stress, find_yield_depth
from roughcontact_volume.radial_return import find_accumulated
from roughcontact_volume.step import NO_FLOW, Flow, FlowingCells, solve_step
from roughcontact_volume.yielding import Yielding

# Most substeps of an increment: what is left then is stated.
_MAX_SUBSTEPS = 64
# Tolerance of a contact over the error of the flow: a looser one is noise at which the flow stalls.
_CONTACT_TOLERANCE = 1e-3
# Change of an answer by a doubling over that by the doubling before: of the first doubling, and its bounds. It is 1/2
# of many substeps, and larger where they are few.
_UNKNOWN_RATIO = 2.0 / 3.0
_SMALLEST_RATIO = 0.5
_LARGEST_RATIO = 0.75
# Error after the extrapolation, over the last change, at least.
_SMALLEST_ERROR = 0.5
ANSWERS = {"maximum pressure": "Pa", "approach": "m", "force": "N", "imprint": "m"}


@attrs.frozen(eq=False)
class PlasticState:
    """What a body has suffered, in its own frame.

    Attributes
    ----------
    plastic_strain
        Components xx, yy, zz, yz, xz, xy, shape (6, nz, nx, ny).
    accumulated_strain
        Accumulated plastic strain, shape (nz, nx, ny).
    last_flow
        What of the plastic strain flowed in the last substep, shape (6, nz, nx, ny).
    imprint
        Displacement of the surface by it, positive into the body, shape (nx, ny), m.
    """

    plastic_strain: Array
    accumulated_strain: Array
    last_flow: Array
    imprint: Array

    @classmethod
    def fresh(cls, shape: tuple[int, int], count: int) -> PlasticState:
        """Return that of a body that never flowed, in a box of as many layers."""
        six = np.zeros((6, count, *shape))
        return cls(six, np.zeros((count, *shape)), six, np.zeros(shape))

    @property
    def layers(self) -> int:
        """The number of layers of the box."""
        return len(self.accumulated_strain)

    @property
    def is_fresh(self) -> bool:
        """Whether nothing has flowed, and no box is chosen."""
        return self.layers == 1 and not self.accumulated_strain.any()

    def deepen(self, count: int) -> PlasticState:
        """Return it in a box of more layers, which lie below the old ones."""
        return attrs.evolve(
            self,
            plastic_strain=deepen(self.plastic_strain, count),
            accumulated_strain=deepen(self.accumulated_strain, count),
            last_flow=deepen(self.last_flow, count),
        )

    def rest(self) -> PlasticState:
        """Return it after an increment in which nothing flows."""
        return attrs.evolve(self, last_flow=np.zeros(self.last_flow.shape))


def deepen(values: Array, count: int) -> Array:
    """Return values of layers, shape (..., nz, nx, ny), with zeros in the layers below."""
    # Pages of zeros that are only read take no memory.
    deeper = np.zeros((*values.shape[:-3], count, *values.shape[-2:]))
    deeper[..., : values.shape[-3], :, :] = values
    return deeper


@attrs.frozen(eq=False)
class _Run:
    """An increment in substeps: the states at its begin, the flows in each, the states and the contact at its end.

    Each is a tuple of all bodies. It ends before the increment does where a flow is not found, which the conditions of
    its states then say.
    """

    begin: tuple[PlasticState, ...]
    flows: tuple[tuple[Flow, ...], ...]
    states: tuple[PlasticState, ...]
    contact: Any
    is_whole: bool

    @property
    def is_flowing(self) -> bool:
        """Whether anything flows in its first substep."""
        return any(flow.is_any for flow in self.flows[0])

    def halve(self) -> list[tuple[Flow, ...]]:
        """Return the flows of twice as many substeps."""
        return [halves for flows in self.flows for halves in [tuple(flow.halve() for flow in flows)] * 2]

    def differ(self, other: _Run) -> tuple[Array, float]:
        """Return the differences of the answers from those of another run, and the largest relative one.

        Their shape is (3 + bodies,): each body has an imprint.
        """
        pairs = zip(self._list_answers(), other._list_answers(), strict=True)
        differences, sizes = zip(*((np.abs(one - two).max(), np.abs(one).max()) for one, two in pairs), strict=True)
        relative = [change / size for change, size in zip(differences, sizes, strict=True) if size > 0.0]
        return np.array(differences), float(max(relative, default=0.0))

    def _list_answers(self) -> tuple[Array, ...]:
        contact = self.contact
        answers = (contact.pressure.max(), contact.approach, contact.force, *(state.imprint for state in self.states))
        return tuple(np.asarray(one) for one in answers)


def _estimate_errors(change: Array, before: Array) -> Array:
    """Return the errors that are left after the last two changes of the answers by doublings.

    They are those of a geometric series, of which the extrapolation has removed a change; the approach may cross its
    limit, but it moves with the imprints.
    """
    ratio = np.full(change.shape, _UNKNOWN_RATIO)
    np.divide(change, before, out=ratio, where=before > 0.0)
    ratio = np.clip(ratio, _SMALLEST_RATIO, _LARGEST_RATIO)
    errors = np.asarray(change * np.maximum(ratio / (1.0 - ratio) - 1.0, _SMALLEST_ERROR))
    errors[1] = max(errors[1], errors[3:].sum())
    return errors


def _extrapolate(begin: PlasticState, flows: Sequence[Flow], coarser: Sequence[Flow]) -> PlasticState:
    """Return the state of a body before the last substep of infinitely many, whose flow is that of the last of some.

    It follows to first order from the flows in some substeps and in half as many. The return from it to the stress at
    the load makes the last flow one that its stress asks for.
    """
    weighted = [(2.0, flow) for flow in flows[:-1]] + [(1.0, flows[-1])] + [(-1.0, flow) for flow in coarser]
    cells = np.unique(np.concatenate([flow.cells for _, flow in weighted]))
    strain, accumulated = np.zeros((6, cells.size)), np.zeros(cells.size)
    for weight, flow in weighted:
        places = np.searchsorted(cells, flow.cells)
        strain[:, places] += weight * flow.values
        accumulated[places] += weight * find_accumulated(flow.values)
    strain[:, accumulated <= 0.0] = 0.0
    # No way is shorter than the distance.
    accumulated = np.maximum(accumulated, find_accumulated(strain))
    total = begin.plastic_strain + Flow(cells, strain).fill(begin.accumulated_strain.shape)
    grown = begin.accumulated_strain.copy()
    grown.reshape(-1)[cells] += accumulated
    return PlasticState(total, grown, np.zeros(total.shape), begin.imprint)


@attrs.frozen(eq=False)
class FlowingBody:
    """A body that flows in a contact.

    Attributes
    ----------
    material
        The material.
    place, place_back
        Fields of the body where it lies on the grid, and back.
    """

    material: Yielding
    place: Callable[[Array], Array]
    place_back: Callable[[Array], Array]


@attrs.define(eq=False)
class SubstepMarch:
    """Goes from the states of bodies to those after an increment of the load.

    Attributes
    ----------
    grid, boundary
        The surface.
    bodies
        The bodies that flow, one or both; states are tuples of theirs.
    press
        The contact on the gap with an offset, m, at a part of the change of the load, from a pressure, to a tolerance.
    tolerance
        Admissible error of the flow; see `solve_step`.
    contact, pressure
        The last contact, and its pressure, Pa, from which the next one starts.
    """

    grid: rc.Grid
    boundary: rc.Boundary
    bodies: tuple[FlowingBody, ...]
    press: Callable[..., Any]
    tolerance: float
    contact: Any = None
    pressure: Array | None = None

    def settle(self, states: tuple[PlasticState, ...], *, is_divisible: bool) -> tuple[tuple[PlasticState, ...], Array]:
        """Return the states after the increment, and the errors of the answers by its substeps, shape (3 + bodies,).

        Where the load does not change, an increment is not divisible.
        """
        unchanged = np.zeros(3 + len(states))
        states = tuple(state.rest() for state in states)
        if all(state.is_fresh for state in states):
            self._touch([state.imprint for state in states], 1.0, _CONTACT_TOLERANCE)
            states = self._choose_boxes(states)
            if all(state.is_fresh for state in states):
                return states, unchanged
        run = self._run(states, [(NO_FLOW,) * len(states)])
        if not is_divisible or not run.is_flowing or not run.is_whole:
            return run.states if run.is_flowing else states, unchanged
        accuracy = min(body.material.accuracy for body in self.bodies)
        before, change = unchanged, unchanged
        while len(run.flows) < _MAX_SUBSTEPS:
            coarser, run = run, self._run(run.begin, run.halve())
            before, (change, largest) = change, run.differ(coarser)
            if largest <= accuracy or not run.is_whole:
                break
        if not run.is_whole:
            return run.states, _estimate_errors(change, before)
        of_each = zip(run.begin, zip(*run.flows, strict=True), zip(*coarser.flows, strict=True), strict=True)
        extrapolated = self._run(tuple(_extrapolate(*one) for one in of_each), run.flows[-1:])
        states = extrapolated.states if extrapolated.is_whole else run.states
        return states, _estimate_errors(change, before)

    def _choose_boxes(self, states: tuple[PlasticState, ...]) -> tuple[PlasticState, ...]:
        """Return the states, fresh ones in a box that is as deep as the last contact yields them, if it does.

        Below a box that has grown from above a residual stress may yield too.
        """
        found = []
        for body, state in zip(self.bodies, states, strict=True):
            depth = 0.0
            if state.is_fresh or body.material.residual is not None:
                pressure = body.place_back(self.contact.pressure)
                depth = find_yield_depth(self.grid, self.boundary, body.material, pressure)
            # The lowest layer must not flow, so that there are two at least.
            count = max(2, count_layers(self.grid, depth)) if depth else 0
            found.append(state.deepen(count) if count > state.layers else state)
        return tuple(found)

    def _run(self, begin: tuple[PlasticState, ...], guesses: Sequence[tuple[Flow, ...]]) -> _Run:
        """Follow the increment in as many substeps as there are guesses of their flow, in boxes that are deep enough.

        One body may be near its yield stress only after the other one has flowed.
        """
        while True:
            run = self._follow(begin, guesses)
            if not run.is_whole:
                return run
            deeper = tuple(map(self._deepen, begin, run.states))
            begin = self._choose_boxes(deeper)
            if all(one is other for one, other in zip(begin, run.begin, strict=True)):
                return run
            guesses = run.flows

    def _deepen(self, begin: PlasticState, end: PlasticState) -> PlasticState:
        """Return the state at the begin of an increment, in a deeper box if its lowest layer has flowed at the end."""
        flowed = end.accumulated_strain - deepen(begin.accumulated_strain, end.layers)
        return begin.deepen(count_deeper(self.grid, begin.layers)) if flowed[-1].any() else begin

    def _follow(self, begin: tuple[PlasticState, ...], guesses: Sequence[tuple[Flow, ...]]) -> _Run:
        states = begin
        # A body that is fresh even now stays elastic.
        active = [place for place, state in enumerate(states) if not state.is_fresh]
        materials = [self.bodies[place].material for place in active]
        every = []
        for number, guess in enumerate(guesses, 1):
            part = number / len(guesses)
            strains = [states[place].plastic_strain for place in active]
            known = [states[place].accumulated_strain for place in active]

            def find_stresses(
                flows: list[Array], error: float, part: float = part, strains: list[Array] = strains
            ) -> list[Array]:
                totals = [strain + flow for strain, flow in zip(strains, flows, strict=True)]
                self._touch_on(active, totals, part, error)
                return [self._find_stress(place, total) for place, total in zip(active, totals, strict=True)]

            cells = [FlowingCells(*one) for one in zip(materials, known, (guess[k] for k in active), strict=True)]
            step = solve_step(find_stresses, cells, self.tolerance)
            flows = [NO_FLOW] * len(states)
            after = list(states)
            for place, flow in zip(active, step.flows, strict=True):
                flows[place] = flow
                after[place] = self._flow(place, states[place], flow)
            every.append(tuple(flows))
            states = tuple(after)
            if step.error > self.tolerance:
                return _Run(begin, tuple(every), states, self.contact, is_whole=False)
        return _Run(begin, tuple(every), states, self.contact, is_whole=True)

    def _flow(self, place: int, state: PlasticState, flow: Flow) -> PlasticState:
        """Return the state of a body after a flow."""
        field = flow.fill(state.accumulated_strain.shape)
        total = state.plastic_strain + field
        accumulated = state.accumulated_strain + find_accumulated(field)
        return PlasticState(total, accumulated, field, self._displace(place, total))

    def _find_stress(self, place: int, strain: Array) -> Array:
        """Return the stress of a body in the last contact, shape (6, nz, nx, ny), Pa."""
        body = self.bodies[place]
        pressure = body.place_back(self.contact.pressure)
        return find_stress(self.grid, self.boundary, body.material, strain, pressure)

    def _displace(self, place: int, strain: Array) -> Array:
        """Return the imprint of a body in its frame, shape (nx, ny), m."""
        if not strain.any():
            return np.zeros(self.grid.shape)
        operators = find_operators(self.grid, self.boundary, strain.shape[1], self.bodies[place].material)
        return operators.displace(strain)

    def _touch_on(self, active: Sequence[int], strains: Sequence[Array], part: float, error: float) -> None:
        """Press the bodies on each other with the plastic strains of those that are not fresh."""
        imprints = [np.zeros(self.grid.shape)] * len(self.bodies)
        for place, strain in zip(active, strains, strict=True):
            imprints[place] = self._displace(place, strain)
        self._touch(imprints, part, error)

    def _touch(self, imprints: Sequence[Array], part: float, error: float) -> None:
        wanted = _CONTACT_TOLERANCE * max(self.tolerance, min(error, 1.0))
        offset = np.sum([body.place(one) for body, one in zip(self.bodies, imprints, strict=True)], axis=0)
        self.contact = self.press(offset, part=part, start=self.pressure, tolerance=wanted)
        self.pressure = self.contact.pressure
