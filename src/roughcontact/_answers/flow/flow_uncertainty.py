"""How far the cells resolve the flow through a gap."""

from __future__ import annotations

import math

import numpy as np

from roughcontact._answers.flow.flow_network import FlowNetwork
from roughcontact._base.checks import Array, Mask

# Weights of the three measures below, set on twelve rough surfaces at four loads and four grids so that 95 % of the
# errors are within two standard deviations; others confirm them (docs/studies/leakage.py). All three are a fourth
# larger since: tight contacts on oblong domains and cells had up to 2.5 (benchmarks/response_classes.py).
_THROATS = 0.94
_RULE = 0.125
_EDGES = 0.25
# Cells across a periodic border to which the contact is looked for.
_BEYOND = 16


def estimate_uncertainty(
    network: FlowNetwork,
    faces: Array,
    lost: Array,
    open_cells: Mask,
    *,
    aspect: float,
    periodic: bool,
    gap_error: float,
) -> float:
    """Return one standard deviation of the flow over the flow.

    Means over the cells, weighted with the power that they lose, tell what matters: the change to another rule for
    the faces, and 1/d^2 and 1/d^3 of the distance d to the contact in cells. An edge that is a fraction of a cell off
    changes the gap beside it as 1/d, and a wall of steps the flow along it.

    Parameters
    ----------
    network, faces, lost
        The network, and the power lost in its faces and cells.
    open_cells
        Cells that are not in contact, shape (along, across) the flow.
    aspect
        Length of a cell across the flow over its length along it.
    periodic
        Whether the gap repeats across the flow.
    gap_error
        Error of the gap by the residual of the contact, over the widest gap.
    """
    flow = float(lost.sum())
    rule = _compare_rules(network, faces, flow)
    # The longer sides of the cells place the edge of the contact.
    oblong = math.sqrt(max(aspect, 1.0 / aspect))
    near = oblong / _find_distances(network, open_cells, aspect=aspect, periodic=periodic)
    squared, cubed = (float(np.sum(lost * near**power)) / flow for power in (2, 3))
    residual = 3.0 * gap_error * float(np.sum(lost / network.film)) / flow
    return math.hypot(_THROATS * math.sqrt(rule * squared), _RULE * rule, _EDGES * cubed, residual)


def _compare_rules(network: FlowNetwork, faces: Array, flow: float) -> float:
    """Return how much the flow rises if the film is linear between two cells, over the flow.

    It is the lower bound of that rise by Thomson's principle, with the flow through each face as it is.
    """
    one = network.film[network.first]
    other = network.film[network.second]
    excess = (one - other) ** 2 / (one**2 - one * other + other**2)
    return 1.0 / (1.0 - float(np.sum(faces * excess)) / flow) - 1.0


def _find_distances(network: FlowNetwork, open_cells: Mask, *, aspect: float, periodic: bool) -> Array:
    """Return the distance of each cell of the network to the contact, in cells; infinite without any."""
    from scipy import ndimage

    if open_cells.all():
        return np.full(network.cells.size, math.inf)
    beyond = min(_BEYOND, open_cells.shape[1]) if periodic else 0
    extended = np.pad(open_cells, ((0, 0), (beyond, beyond)), mode="wrap") if beyond else open_cells
    side = math.sqrt(aspect)
    distances = ndimage.distance_transform_edt(extended, sampling=(1.0 / side, side))
    inside = distances[:, beyond : beyond + open_cells.shape[1]]
    return np.asarray(inside[np.divmod(network.cells, open_cells.shape[1])], dtype=np.float64)
