"""Sharp edges of the contact, at which the pressure does not fall to zero."""

from __future__ import annotations

import numpy as np

from roughcontact.areas.base import framed
from roughcontact.checks import Mask
from roughcontact.solution import ContactSolution

# A chain of cells at the edge of a smaller cluster may rise outward by chance.
_FEWEST = 9
_REACH = 2
_DIRECTIONS = ((1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (1, -1), (-1, 1), (-1, -1))


def sharp_edges(solution: ContactSolution) -> Mask:
    """Mark the cells of the contact at a sharp edge, as of a flat punch, shape (nx, ny).

    There the pressure does not decay towards the edge over three cells. Along an axis both lateral
    neighbours must be in contact as well, along a diagonal both cells beside the one outside must
    be open, for an edge that runs past a cell at an angle has no other meaning. Saturated cells are
    never sharp: their pressure tells nothing.
    """
    contact, clusters = solution.contact, solution.clusters
    beyond = framed(contact, _REACH, solution.boundary)
    pressure = framed(solution.pressure, _REACH, solution.boundary).ravel()
    width, (nx, ny) = beyond.shape[1], contact.shape
    closed = np.ones_like(contact)
    for dx in (1, 2, 3):
        for dy in (1, 2, 3):
            closed &= beyond[dx : dx + nx, dy : dy + ny]
    found = np.zeros(contact.size, dtype=bool)
    edge = np.flatnonzero(contact & ~closed)
    large = np.concatenate(([False], clusters.cells >= _FEWEST))[clusters.labels.ravel()[edge]]
    edge = edge[large & ~solution.saturated.ravel()[edge]]
    at = (edge // ny + _REACH) * width + edge % ny + _REACH
    touching = beyond.ravel()
    for dx, dy in _DIRECTIONS:
        step, side = dx * width + dy, dy * width + dx
        if dx == 0 or dy == 0:
            sides = touching.take(at + side) & touching.take(at - side)
        else:
            sides = ~(touching.take(at + dx * width) | touching.take(at + dy))
        facing = np.flatnonzero(sides & ~touching.take(at + step))
        here, inner, innermost = (pressure.take(at[facing] - k * step) for k in (0, 1, 2))
        found[edge[facing[(here >= inner) & (inner >= innermost) & (innermost > 0.0)]]] = True
    return found.reshape(contact.shape)
