"""The conditions of plastic flow, recomputed from the pressure and the plastic strain of a state alone."""

from __future__ import annotations

import attrs
import numpy as np
import roughcontact as rc
from roughcontact.results import Condition
from roughcontact.typing import Array

from roughcontact_volume.box import find_largest_below, find_stress
from roughcontact_volume.radial_return import (
    WEIGHTS,
    find_accumulated,
    find_deviator,
    find_equivalent,
    find_flow,
    find_norm,
)
from roughcontact_volume.substeps import PlasticState
from roughcontact_volume.yielding import Yielding

# Largest error of the flow with which a state counts as solved.
_MAX_ERROR = 1e-3
_FLOW = "change of the last flow by the return of its stress, 2 mu over the yield stress"
_YIELD = "von Mises stress beyond the yield stress, in the last flow also below it, over it"
_DIRECTION = "1 - cosine between the last flow and the deviator of its stress"
_TRACE = "volume strain of the plastic strain, over its largest size"
_BOX = "accumulated plastic strain in the lowest layer, over its maximum"
_BORDER = "accumulated plastic strain in the cells at a free border, over its maximum"


def judge_flow(
    grid: rc.Grid, boundary: rc.Boundary, material: Yielding, pressure: Array, state: PlasticState
) -> list[Condition]:
    """Return the conditions of a body under a pressure, shape (nx, ny), Pa, in its own frame."""
    if not state.accumulated_strain.any():
        largest = float(find_largest_below(grid, boundary, material, pressure).max())
        beyond = max(0.0, largest / material.yield_stress - 1.0)
        return [
            Condition("plastic flow", beyond, _FLOW, tolerance=_MAX_ERROR),
            Condition("yield", beyond, _YIELD, judges=False),
        ]
    stress = find_stress(grid, boundary, material, state.plastic_strain, pressure)
    # Layer by layer, which takes the memory of one.
    layers = [_LastFlow.of(stress, state, material, layer) for layer in range(state.layers)]
    highest = float(state.accumulated_strain.max())
    size = max(float(find_norm(state.plastic_strain[:, layer]).max()) for layer in range(state.layers))
    trace = float(np.abs(state.plastic_strain[:3].sum(axis=0)).max())
    at_border = find_at_border(state.accumulated_strain, boundary)
    return [
        Condition("plastic flow", max(one.find_error() for one in layers), _FLOW, tolerance=_MAX_ERROR),
        Condition("yield", max(one.find_excess() for one in layers), _YIELD, judges=False),
        Condition("flow direction", max(one.find_turn() for one in layers), _DIRECTION, judges=False),
        Condition("plastic volume strain", trace / size, _TRACE, judges=False),
        Condition("box", float(state.accumulated_strain[-1].max()) / highest, _BOX),
        Condition("border", at_border / highest, _BORDER, judges=False),
    ]


@attrs.frozen(eq=False)
class _LastFlow:
    """The last flow in the cells of a layer, shape (6, n), its stress, Pa, and the accumulated strain around it."""

    material: Yielding
    stress: Array
    flow: Array
    before: Array
    after: Array

    @classmethod
    def of(cls, stress: Array, state: PlasticState, material: Yielding, layer: int) -> _LastFlow:
        flow = state.last_flow[:, layer].reshape(6, -1)
        after = state.accumulated_strain[layer].reshape(-1)
        return cls(
            material, stress[:, layer].reshape(6, -1), flow, np.maximum(after - find_accumulated(flow), 0.0), after
        )

    def find_error(self) -> float:
        residual = find_flow(self.stress, self.flow, self.before, self.material) - self.flow
        return float(find_norm(residual).max()) * 2.0 * self.material.shear_modulus / self.material.yield_stress

    def find_excess(self) -> float:
        excess = find_equivalent(self.stress) / self.material.find_yield_stress(self.after) - 1.0
        flows = self.flow.any(axis=0)
        return float(max(excess.max(), np.max(-excess[flows], initial=0.0), 0.0))

    def find_turn(self) -> float:
        flows = self.flow.any(axis=0)
        deviator = find_deviator(self.stress[:, flows])
        flow = self.flow[:, flows]
        product = np.einsum("c,cn,cn->n", WEIGHTS, deviator, flow)
        return float(np.max(1.0 - product / (find_norm(deviator) * find_norm(flow)), initial=0.0))


def find_at_border(strain: Array, boundary: rc.Boundary) -> float:
    """Return the largest value in the outermost cells along axes at whose ends the domain is free."""
    found = 0.0
    for axis, is_free in enumerate(boundary.free_axes, 1):
        if is_free:
            found = max(found, float(strain.take((0, -1), axis=axis).max()))
    return found
