"""Flow factors of a periodic gap: averaged Reynolds' equation, each factor with its uncertainty by the grid."""

from __future__ import annotations

import math

import attrs
import numpy as np

from roughcontact._answers.flow.network import estimate_uncertainty
from roughcontact._answers.flow.periodic import PeriodicFlow, solve_periodic
from roughcontact._base.arrays import Array, Mask
from roughcontact._parts.grid import Grid

# Fraction of the uncertainty of a leakage that a flow factor has: at a given separation the load errs, not the gap.
# And weights of what the uncertainty of a shear flow factor is made of: the change of rule of the film in the faces,
# and the relative uncertainty of the flow. All were set on 6 rough surfaces at four separations, of 3 and 6 cells in
# the shortest wave, so that the uncertainty is about twice the rms error.
_FLOW_FRACTION = 0.4
_FILM_RULE_WEIGHT = 0.2
_FLOW_WEIGHT = 0.5
# Weight of the standard deviations of the diagonal off it, where the change of rule passes through zero.
_OBLIQUE_WEIGHT = 0.5
# Weight of the change of a factor on every second cell. Errors of narrow and creased grooves, which the measures above
# do not see, are 0.2 to 0.4 of it, as of an order between one and two (docs/studies/film_law.py, draw 1).
_SPARSE_WEIGHT = 0.3
# Cells along an axis from which every second one is taken.
_MIN_CELLS = 8


@attrs.frozen(eq=False)
class FlowFactors:
    r"""The factors of the averaged Reynolds' equation, for one separation h of the mean planes.

    .. math:: q = -\frac{h^3}{12 \eta} \phi \nabla p + \frac{U_1 + U_2}{2} h_T + \frac{U_1 - U_2}{2} S_q \phi_s

    with wall 1 rough and wall 2 smooth.

    Attributes
    ----------
    pressure, shear, viscous
        :math:`\phi`, :math:`S_q \phi_s` (m) and :math:`\phi_{fp} = 1 - S_q \phi_s^T / h`, shape (2, 2).
    pressure_std, shear_std, viscous_std
        One standard deviation of each by the grid, shape (2, 2).
    """

    pressure: Array
    shear: Array
    viscous: Array
    pressure_std: Array
    shear_std: Array
    viscous_std: Array

    def widen(self, sparse: FlowFactors) -> FlowFactors:
        """Return the factors with uncertainties that contain their change on every second cell."""
        stds = {}
        for name in ("pressure", "shear", "viscous"):
            changes = _SPARSE_WEIGHT * np.abs(getattr(sparse, name) - getattr(self, name))
            stds[f"{name}_std"] = np.hypot(getattr(self, f"{name}_std"), changes)
        return attrs.evolve(self, **stds)


def find_flow_factors(
    gap: Array, open_cells: Mask, grid: Grid, separation: float, *, creased: float, gap_error: float = 0.0
) -> FlowFactors:
    """Return the flow factors of a periodic gap.

    Parameters
    ----------
    gap, open_cells
        Gap, m, and the cells that are not in contact, shape (nx, ny).
    grid, separation
        Its grid, and the distance of the mean planes, m.
    creased
        How far the heights have grooves with creases, from 0 to 1 (`find_creases`).
    gap_error
        Error of the gap by the residual of the contact, m.
    """
    found = _find_factors(gap, open_cells, grid, separation, creased, gap_error)
    strides = [2 if count >= _MIN_CELLS else 1 for count in grid.shape]
    # Of an odd number the last cell is omitted.
    chosen = tuple(
        slice(None, count - count % stride, stride) for count, stride in zip(grid.shape, strides, strict=True)
    )
    sparse_shape = tuple(count // stride for count, stride in zip(grid.shape, strides, strict=True))
    if sparse_shape == grid.shape:
        return found
    steps = (step * stride for step, stride in zip(grid.spacing, strides, strict=True))
    size = tuple(count * step for count, step in zip(sparse_shape, steps, strict=True))
    sparse = _find_factors(gap[chosen], open_cells[chosen], Grid(sparse_shape, size), separation, creased, gap_error)
    return found.widen(sparse)


def _find_factors(
    gap: Array, open_cells: Mask, grid: Grid, separation: float, creased: float, gap_error: float
) -> FlowFactors:
    """Return the flow factors, with what the flow itself says of their uncertainties."""
    flow = solve_periodic(gap, open_cells, aspect=grid.spacing[1] / grid.spacing[0], creased=creased)
    identity = np.eye(2)
    if flow.network is None:
        none = np.zeros((2, 2))
        return FlowFactors(none, separation * identity, none, none, none, none)
    widest = flow.network.widest
    pressure = flow.cubes * (widest / separation) ** 3
    films = flow.films * widest
    relative = _find_relative_stds(flow, open_cells, gap_error)
    sizes = relative * np.diag(pressure)
    pressure_std = np.sqrt(np.outer(sizes, sizes)) * (_OBLIQUE_WEIGHT + (1.0 - _OBLIQUE_WEIGHT) * np.eye(2))
    along = np.hypot(
        _FILM_RULE_WEIGHT * np.abs(_compare_films(flow)) * widest, _FLOW_WEIGHT * relative * np.abs(np.diag(films))
    )
    # What is dragged along either axis errs with the flow along the other one.
    shear_std = np.where(np.eye(2) > 0.0, along, _OBLIQUE_WEIGHT * along)
    shear = separation * identity - films
    viscous = films.T / separation
    return FlowFactors(pressure, shear, viscous, pressure_std, shear_std, shear_std.T / separation)


def _find_relative_stds(flow: PeriodicFlow, open_cells: Mask, gap_error: float) -> Array:
    """Return the relative standard deviations of the flow along x and along y."""
    network = flow.network
    assert network is not None
    found = np.zeros(2)
    for axis, drops in enumerate(flow.drops):
        faces, lost = network.spread_loss(drops)
        if math.fsum(lost) > 0.0:
            error = gap_error / network.widest
            found[axis] = _FLOW_FRACTION * estimate_uncertainty(network, faces, lost, open_cells, gap_error=error)
    return found


def _compare_films(flow: PeriodicFlow) -> Array:
    """Return how much the dragged film along x and along y changes from one rule of the faces to the other."""
    network = flow.network
    assert network is not None
    faces = network.faces
    changes = faces.compare_films()
    parts = slice(None, faces.along), slice(faces.along, None)
    steps = 1.0, network.aspect
    cells = math.prod(network.shape)
    return np.array(
        [changes[part] @ drops[part] / step / cells for part, step, drops in zip(parts, steps, flow.drops, strict=True)]
    )
