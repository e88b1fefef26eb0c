"""Flow through a periodic gap: the flow by a mean pressure gradient and by sliding walls, in all directions."""

from __future__ import annotations

import math
from collections.abc import Mapping

import attrs
import numpy as np

from roughcontact._answers.flow.network import (
    MIN_FILM_RATIO,
    SIDE_NEIGHBOURS,
    Ends,
    FlowNetwork,
    factor,
    join_cells,
    number_cells,
)
from roughcontact._base.arrays import Array, IntArray, Mask

# Flow over that along the other axis up to which it is rounding.
_ROUNDING = 1e-24
# A copy of the domain by its numbers along both axes.
Copy = tuple[int, int]


@attrs.frozen(eq=False)
class PeriodicFlow:
    r"""The flow through one period of a gap, by two problems on its open cells.

    .. math:: \nabla \cdot g^3 (e_i + \nabla \chi_i) = 0,
       K_{ij} = \langle g^3 (e_i + \nabla \chi_i)_j \rangle, F_{ij} = \langle g (e_j + \nabla \chi_j)_i \rangle

    K is the flow by a mean gradient of the pressure, times 12 eta, and F / 2 the flow by a smooth wall that slides over
    a rough one at rest, over the speed. That problem,

    .. math:: \nabla \cdot (g^3 \nabla w_i + g e_i) = 0, F_{ij} = \langle (g^3 \nabla w_i + g e_i)_j \rangle

    needs no solution of its own: multiplied by chi_j and integrated it gives F by the first one (reciprocity).

    Attributes
    ----------
    network
        Cells of the pieces that repeat without end; None if there are none.
    drops
        Pressure drop over each face for a mean gradient of one along x and along y, shape (2, faces).
    cubes, films
        K over the cube of the widest gap and F over the widest gap, shape (2, 2).
    """

    network: FlowNetwork | None
    drops: Array
    cubes: Array
    films: Array


def solve_periodic(gap: Array, open_cells: Mask, *, aspect: float, creased: float = 0.0) -> PeriodicFlow:
    """Return the flow through a periodic gap.

    Parameters
    ----------
    gap, open_cells
        Gap, and the cells that are not in contact, shape (nx, ny).
    aspect
        Length of a cell along y over its length along x.
    creased
        How far the heights have grooves with creases, from 0 to 1 (`find_creases`).
    """
    network = make_periodic_network(gap, open_cells, aspect=aspect, creased=creased)
    if network is None:
        return PeriodicFlow(None, np.zeros((2, 0)), np.zeros((2, 2)), np.zeros((2, 2)))
    faces = network.faces
    steps = 1.0, aspect
    crossed = slice(None, faces.along), slice(faces.along, None)
    drops = np.zeros((2, faces.first.size))
    for given, part, step in zip(drops, crossed, steps, strict=True):
        given[part] = step
    solve = factor(network)
    # The second round takes away what rounding has left.
    for _ in range(2):
        flows = network.conductance * drops
        balances = [network.gather((faces.second, one), (faces.first, -one)) for one in flows]
        pressures = solve(np.stack(balances, axis=1))
        for given, pressure in zip(drops, pressures.T, strict=True):
            given += pressure[faces.first] - pressure[faces.second]
    area = aspect * math.prod(network.shape)
    flows = np.einsum("f,if,if->i", network.conductance, drops, drops) / area
    # Along an axis that is closed rounding alone is left.
    drops[flows <= _ROUNDING * flows.max()] = 0.0
    cubes = np.einsum("f,if,jf->ij", network.conductance, drops, drops) / area
    films = faces.find_films() / math.prod(network.shape)
    sums = [[films[part] @ given[part] / step for given in drops] for part, step in zip(crossed, steps, strict=True)]
    return PeriodicFlow(network, drops, cubes, np.array(sums))


def make_periodic_network(gap: Array, open_cells: Mask, *, aspect: float, creased: float = 0.0) -> FlowNetwork | None:
    """Return the network of the open cells of pieces that repeat without end, or None if there are none.

    Its pressure is zero in one cell of each piece, joined to the outlet, through which nothing flows.
    """
    widest = float(gap.max(where=open_cells, initial=0.0))
    if widest <= 0.0:
        return None
    film = np.where(open_cells, gap / widest, 0.0)
    pieces = find_endless_pieces(film > MIN_FILM_RATIO)
    number = number_cells(pieces > 0)
    cells = np.flatnonzero(pieces)
    if cells.size == 0:
        return None
    # The widest film of each piece.
    widest_first = np.argsort(-film.reshape(-1)[cells], kind="stable")
    _, place = np.unique(pieces.reshape(-1)[cells][widest_first], return_index=True)
    pinned = widest_first[place]
    nothing = np.zeros(0, dtype=np.int32)
    ends = Ends(nothing, pinned, np.zeros(0), film.reshape(-1)[cells][pinned] ** 3)
    return join_cells(film, number, ends, widest=widest, aspect=aspect, wraps=(True, True), creased=creased)


def find_endless_pieces(open_cells: Mask) -> IntArray:
    """Return the number of the piece of each cell that leads to itself in another copy of the domain, 0 elsewhere.

    Only such pieces have a net flow. Pieces are joined through sides of cells, over both borders too.
    """
    from scipy import ndimage

    labels, count = ndimage.label(open_cells, structure=SIDE_NEIGHBOURS)
    links: dict[int, set[tuple[int, Copy]]] = {label: set() for label in range(1, count + 1)}
    for one, other, (i, j) in ((labels[-1], labels[0], (1, 0)), (labels[:, -1], labels[:, 0], (0, 1))):
        both = (one > 0) & (other > 0)
        for before, behind in np.unique(np.stack((one[both], other[both])), axis=1).T.tolist():
            links[before].add((behind, (i, j)))
            links[behind].add((before, (-i, -j)))
    piece = np.zeros(count + 1, dtype=np.intp)
    seen: set[int] = set()
    for start in links:
        if start in seen:
            continue
        copies, is_endless = _follow(start, links)
        seen |= copies.keys()
        if is_endless:
            piece[list(copies)] = start
    return np.asarray(piece[labels])


def _follow(start: int, links: Mapping[int, set[tuple[int, Copy]]]) -> tuple[dict[int, Copy], bool]:
    """Return the labels of a piece, each with its copy of the domain, and whether one of them is in two copies."""
    copies = {start: (0, 0)}
    waiting = [start]
    is_endless = False
    while waiting:
        label = waiting.pop()
        i, j = copies[label]
        for other, (over_x, over_y) in links[label]:
            copy = i + over_x, j + over_y
            if other not in copies:
                copies[other] = copy
                waiting.append(other)
            elif copies[other] != copy:
                is_endless = True
    return copies, is_endless
