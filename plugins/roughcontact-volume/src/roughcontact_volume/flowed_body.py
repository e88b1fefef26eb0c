"""The body of a state that has flowed below its surface: what its process remembers, and where it lies."""

from __future__ import annotations

from typing import Any, Self

import attrs
import numpy as np
import roughcontact as rc
from roughcontact.results import WarningText
from roughcontact.typing import Array, Load, LoadIncrement

from roughcontact_volume.box import find_stress, list_layers
from roughcontact_volume.cell_maximum import find_cell_maximum
from roughcontact_volume.flow import PlasticFlow
from roughcontact_volume.judgement import find_at_border
from roughcontact_volume.shapes import read_side
from roughcontact_volume.substeps import PlasticState
from roughcontact_volume.yielding import Yielding

# Largest accumulated strain beyond which strains are not small: a ball has it where the radius of its contact is a
# tenth of its own.
_LARGEST_SMALL_STRAIN = 0.03


def read_body(value: str | None) -> str | None:
    """Return the name of a body, or None: the one that flows; or raise `InputError`."""
    return None if value is None else read_side(value, "The body")


@attrs.frozen(eq=False)
class FlowedBody:
    """A body that flows, at a state of its contact.

    Attributes
    ----------
    grid, boundary
        Its cells, and what lies beyond them.
    material
        Its material.
    flow
        What it has suffered, in its own frame.
    pressure
        The pressure on it, in its own frame, shape (nx, ny), Pa.
    step_errors
        Errors of the answers by the substeps; see `PlasticFlow`.
    is_certified
        Whether the contact is.
    side
        ``"body"`` or ``"counterbody"``.
    """

    grid: rc.Grid
    boundary: rc.Boundary
    material: Yielding
    flow: PlasticState
    pressure: Array
    step_errors: Array
    is_certified: bool
    side: str

    @classmethod
    def list_of(cls, state: Any) -> tuple[Self, ...]:
        """Return those of a `ContactSolution`; `InputError` if none of its bodies flows, or its problem is unknown."""
        for addition in state.added:
            for law, memory in zip(getattr(addition, "laws", ()), getattr(addition, "memory", ()), strict=True):
                if isinstance(law, PlasticFlow):
                    return tuple(cls._read(state, law.read(memory, side), side, addition.shift) for side in law.sides)
        raise rc.InputError("Neither body flows below its surface: give one of them the material Plastic.")

    @classmethod
    def of(cls, state: Any, body: str | None = None) -> Self:
        """Return that of a side, or the one that flows; `InputError` if that one does not, or both do."""
        found = {one.side: one for one in cls.list_of(state)}
        if body is None and len(found) > 1:
            raise rc.InputError("Both bodies flow below their surfaces: say which with body='body' or 'counterbody'.")
        if body is not None and body not in found:
            raise rc.InputError(f"The {body} does not flow below its surface: give it the material Plastic.")
        return found[body] if body else next(iter(found.values()))

    @classmethod
    def _read(cls, state: Any, memory: Any, side: str, shift: tuple[int, int]) -> Self:
        problem = state.origin.scene
        pressure = state.pressure
        if side == "counterbody":
            increment = LoadIncrement(Load("force", state.force), shift=shift)
            pressure = np.asarray(increment.place_back(pressure))
        flow = PlasticState(**{name: memory[name] for name in attrs.fields_dict(PlasticState)})
        return cls(
            problem.plan.grid,
            problem.boundary,
            getattr(problem, side).material,
            flow,
            pressure,
            memory["step_errors"],
            state.status.success,
            side,
        )

    @property
    def thicknesses(self) -> Array:
        """Thicknesses of the layers of the box, shape (nz,), m."""
        return list_layers(self.grid, self.flow.layers)

    @property
    def step_error(self) -> float:
        """Error of the plastic strain by the substeps, over it: that of the imprint, which is linear in it."""
        deepest = float(np.abs(self.flow.imprint).max())
        return float(self.step_errors[3]) / deepest if deepest > 0.0 else 0.0

    def find_largest_yield_stress(self) -> float:
        """Return the yield stress of the largest accumulated strain, and what this may be more, Pa."""
        strain = self.flow.accumulated_strain
        interfaces = np.concatenate(([0.0], np.cumsum(self.thicknesses)))
        largest = find_cell_maximum(strain, self.grid, interfaces, self.step_error)
        return float(self.material.find_yield_stress(np.array([largest.value + largest.uncertainty]))[0])

    def find_stress(self, *, is_loaded: bool) -> Array:
        """Return the residual stress, mean over each layer, shape (6, nz, nx, ny), Pa, or that with the pressure."""
        pressure = self.pressure if is_loaded else None
        return find_stress(self.grid, self.boundary, self.material, self.flow.plastic_strain, pressure)

    @property
    def warnings(self) -> tuple[WarningText, ...]:
        """Why what is below must not be trusted, in sentences; empty without a reason."""
        found = []
        if not self.is_certified:
            found.append(WarningText("the contact is not certified", "convergence"))
        if find_at_border(self.flow.accumulated_strain, self.boundary) > 0.0:
            text = "the body flows at the free border, beyond which nothing lies: enlarge the grid"
            found.append(WarningText(text, "grid"))
        largest = float(self.flow.accumulated_strain.max())
        if largest > _LARGEST_SMALL_STRAIN:
            text = (
                f"the plastic strain reaches {largest:.2g}, but strains are taken as small, as of a ball whose contact "
                "has less than a tenth of its radius"
            )
            found.append(WarningText(text, "small strain", largest))
        return tuple(found)
