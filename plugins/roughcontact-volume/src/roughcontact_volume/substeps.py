"""An increment of the load in substeps, as many as its answers ask for, each with the contact solved inside."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import attrs
import numpy as np
import roughcontact as rc
from roughcontact.typing import Array

from roughcontact_volume.box import count_deeper, count_layers, find_operators, find_yield_depth
from roughcontact_volume.radial_return import find_accumulated
from roughcontact_volume.step import NO_FLOW, Flow, solve_step
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
    """An increment in substeps: the state at its begin, the flow in each, the state and the contact at its end.

    It ends before the increment does where a flow is not found, which the conditions of its state then say.
    """

    begin: PlasticState
    flows: tuple[Flow, ...]
    state: PlasticState
    contact: Any
    is_whole: bool

    def differ(self, other: _Run) -> tuple[Array, float]:
        """Return the differences of the answers from those of another run, shape (4,), and the largest relative one."""
        pairs = zip(self._list_answers(), other._list_answers(), strict=True)
        differences, sizes = zip(*((np.abs(one - two).max(), np.abs(one).max()) for one, two in pairs), strict=True)
        relative = [change / size for change, size in zip(differences, sizes, strict=True) if size > 0.0]
        return np.array(differences), float(max(relative, default=0.0))

    def _list_answers(self) -> tuple[Array, ...]:
        contact = self.contact
        answers = (contact.pressure.max(), contact.approach, contact.force, self.state.imprint)
        return tuple(np.asarray(one) for one in answers)


def _estimate_errors(change: Array, before: Array) -> Array:
    """Return the errors that are left after the last two changes of the answers by doublings.

    They are those of a geometric series; the approach may cross its limit, but it moves with the imprint.
    """
    ratio = np.full(change.shape, _UNKNOWN_RATIO)
    np.divide(change, before, out=ratio, where=before > 0.0)
    ratio = np.clip(ratio, _SMALLEST_RATIO, _LARGEST_RATIO)
    errors = np.asarray(change * ratio / (1.0 - ratio))
    errors[1] = max(errors[1], errors[3])
    return errors


@attrs.define(eq=False)
class SubstepMarch:
    """Goes from the state of a body to that after an increment of the load.

    Attributes
    ----------
    grid, boundary, material
        The surface and the material of the body.
    press
        The contact on the gap with an offset, m, at a part of the change of the load, from a pressure, to a tolerance.
    place, place_back
        Fields of the body where it lies on the grid, and back.
    tolerance
        Admissible error of the flow; see `solve_step`.
    contact, pressure
        The last contact, and its pressure, Pa, from which the next one starts.
    """

    grid: rc.Grid
    boundary: rc.Boundary
    material: Yielding
    press: Callable[..., Any]
    place: Callable[[Array], Array]
    place_back: Callable[[Array], Array]
    tolerance: float
    contact: Any = None
    pressure: Array | None = None

    def settle(self, state: PlasticState, accuracy: float, *, is_divisible: bool) -> tuple[PlasticState, Array]:
        """Return the state after the increment, and the errors of the answers by its substeps, shape (4,).

        Where the load does not change, an increment is not divisible.
        """
        unchanged = np.zeros(len(ANSWERS))
        state = state.rest()
        if state.layers == 1 and not state.accumulated_strain.any():
            state = self._choose_box(state)
            if state.layers == 1:
                return state, unchanged
        run = self._run(state, (NO_FLOW,))
        if not is_divisible or not run.flows[0].is_any or not run.is_whole:
            return run.state if run.flows[0].is_any else state, unchanged
        before, change = unchanged, unchanged
        while len(run.flows) < _MAX_SUBSTEPS:
            halves = [half for flow in run.flows for half in [flow.halve()] * 2]
            finer = self._run(run.begin, halves)
            before, (change, largest) = change, finer.differ(run)
            run = finer
            if largest <= accuracy or not run.is_whole:
                break
        return run.state, _estimate_errors(change, before)

    def _choose_box(self, fresh: PlasticState) -> PlasticState:
        """Return a fresh state in a box that is as deep as the elastic contact yields, if it does."""
        self._touch(fresh.imprint, 1.0, _CONTACT_TOLERANCE)
        pressure = self.place_back(self.contact.pressure)
        depth = find_yield_depth(self.grid, self.boundary, self.material, pressure)
        # The lowest layer must not flow, so that there are two at least.
        return fresh.deepen(max(2, count_layers(self.grid, depth))) if depth else fresh

    def _run(self, begin: PlasticState, guesses: Sequence[Flow]) -> _Run:
        """Follow the increment in as many substeps as there are guesses of their flow, in a box that is deep enough."""
        while True:
            run = self._follow(begin, guesses)
            flowed = run.state.accumulated_strain - deepen(begin.accumulated_strain, run.state.layers)
            if not flowed[-1].any() or not run.is_whole:
                return run
            begin = begin.deepen(count_deeper(self.grid, begin.layers))
            guesses = run.flows

    def _follow(self, begin: PlasticState, guesses: Sequence[Flow]) -> _Run:
        state = begin
        operators = find_operators(self.grid, self.boundary, state.layers, self.material)
        flows = []
        for number, guess in enumerate(guesses, 1):
            part = number / len(guesses)
            strain = state.plastic_strain

            def find_stress(flow: Array, error: float, part: float = part, strain: Array = strain) -> Array:
                total = strain + flow
                if not total.any():
                    self._touch(np.zeros(self.grid.shape), part, error)
                    return operators.press(self.place_back(self.contact.pressure))
                self._touch(operators.displace(total), part, error)
                stress = operators.find_stress(total)
                stress += operators.press(self.place_back(self.contact.pressure))
                return stress

            step = solve_step(find_stress, state.accumulated_strain, self.material, self.tolerance, guess)
            flows.append(step.flow)
            flow = step.flow.fill(state.accumulated_strain.shape)
            total = strain + flow
            state = PlasticState(
                total, state.accumulated_strain + find_accumulated(flow), flow, operators.displace(total)
            )
            if step.error > self.tolerance:
                return _Run(begin, tuple(flows), state, self.contact, is_whole=False)
        return _Run(begin, tuple(flows), state, self.contact, is_whole=True)

    def _touch(self, imprint: Array, part: float, error: float) -> None:
        wanted = _CONTACT_TOLERANCE * max(self.tolerance, min(error, 1.0))
        self.contact = self.press(self.place(imprint), part=part, start=self.pressure, tolerance=wanted)
        self.pressure = self.contact.pressure
