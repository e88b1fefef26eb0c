"""The edges of the clusters, drawn between the cells, and how far they may be wrong."""

from __future__ import annotations

import math

import attrs
import numpy as np

from roughcontact.areas.base import straight_rows
from roughcontact.areas.contour import Contour, change_at_edge, contour
from roughcontact.areas.curvature import roughness
from roughcontact.areas.sharp import sharp_edges
from roughcontact.checks import Array
from roughcontact.grid import Boundary
from roughcontact.solution import ContactSolution

# The chords of a dual cell cut off kappa l^3 / 12 each. With the mean chords of the unit square,
# <l> = pi / 4 and <l^3> = 3 / 4, that is half a cell around each convex whole.
_CHORDS = 0.5
# What is missing besides, in cells around each whole: measured on solved spheres.
_BENT = 0.16
# The solution itself wanders by this much, in cells per root of the edge's length in cells.
_WANDER = 0.065
_COUNTED_SIDES = 4.0 / np.pi
# An edge along the grid is misplaced by this, in cells, as a whole, and the more the thinner the contact.
_ALIGNED = 0.1
_CURVED = 5.0
# Beside a cell of a free border that is in contact so much of a cell is not known.
_CUT = 0.1
# Clusters of as many cells are drawn alike by both strides, or their shape is not resolved.
_SHAPED = 12
# Edges drawn around no more than so many cells err more than edges wander.
_FEW = 3.0
# What is not known of the kernel's shift of the edge, in cells.
_SHIFT_ERROR = 0.003
# Shift of the edge, in cells, where the modulus changes by e from short to long waves there, measured on layers.
_VARIES = 0.1
# The same where the pressure limit is reached, measured on spheres.
_BLUNT = 0.06
# What a grid that hardly resolves the heights covers too much, in cells along the edge: by the
# roughness (q h)^2 before extrapolation and by its square after, measured on self-affine surfaces.
_UNRESOLVED = 0.03
_UNRESOLVED_REFINED = 0.009
# No more of an area than this is taken to be excess.
_AT_MOST = 0.3


@attrs.frozen(eq=False)
class Drawn:
    """Areas of the clusters by their drawn edges, and what is needed to judge them; first entry zero.

    Attributes
    ----------
    area
        Area drawn between all cells, with what chords cut off put back, shape (count + 1,), m2.
    refined
        The same, extrapolated from cells two apart.
    length
        Length of the edge, m.
    sharp
        Share of the edge that is sharp.
    wander
        Standard deviation of either area, m2.
    strip
        Area of a strip along the edge, one cell wide, m2.
    roughness
        How little the grid resolves the heights: see `roughcontact.areas.curvature.roughness`.
    excess, excess_refined
        What either area still covers too much for that, m2.
    blunt
        Error where the pressure reaches its limit near the edge, m2: the distance is not told there.
    straight
        Standard deviation of the area beside edges that run along the grid, and at a free border, m2.
    unknown
        A cell for each piece or hole of the larger clusters that is not the same in both drawings, m2.
    varies
        Logarithm of the change of the modulus between short and long waves at the edge; zero without layers.
    """

    area: Array
    refined: Array
    length: Array
    sharp: Array
    wander: Array
    strip: Array
    roughness: float
    excess: Array
    excess_refined: Array
    blunt: Array
    straight: float
    unknown: float
    varies: float


def drawn(solution: ContactSolution) -> Drawn:
    """Draw the edge of each cluster."""
    marked = sharp_edges(solution)
    one, two = (contour(solution, marked, stride) for stride in (1, 2))
    fine, coarse = _closed(solution, one, 1), _closed(solution, two, 2)
    cell = solution.grid.cell_area
    # However little of a cell is drawn, its edge wanders as that of a disc of half the size.
    disc = np.sqrt(np.pi * cell * np.concatenate(([0], solution.clusters.cells)))
    wander = _WANDER * np.sqrt(_COUNTED_SIDES * np.maximum(one.length, disc) / np.sqrt(cell)) * cell
    rough = roughness(solution)
    strip = np.sqrt(cell) * one.length
    return Drawn(
        area=fine,
        refined=(4.0 * fine - coarse) / 3.0,
        length=one.length,
        sharp=one.sharp,
        wander=wander,
        strip=strip,
        roughness=rough,
        excess=np.minimum(_UNRESOLVED * rough * strip, _AT_MOST * fine),
        excess_refined=np.minimum(_UNRESOLVED_REFINED * rough**2 * strip, _AT_MOST * fine),
        blunt=_BLUNT * _saturated_share(solution) * strip,
        straight=_border(solution) * cell
        + _straight(solution) * cell * (1.0 + float(np.sum(strip)) / max(2.0 * float(np.sum(fine)), cell)),
        unknown=abs(float(np.sum((one.euler - two.euler)[1:], where=solution.clusters.cells >= _SHAPED))) * cell,
        varies=change_at_edge(solution),
    )


def _border(solution: ContactSolution) -> float:
    """Return the error where a free border cuts the contact, in cells."""
    contact = solution.contact
    if solution.boundary is not Boundary.FREE or contact.all():
        return 0.0
    return _CUT * float(
        sum(np.count_nonzero(edge) for edge in (contact[0], contact[-1], contact[:, 0], contact[:, -1]))
    )


def _straight(solution: ContactSolution) -> float:
    """Return the error of edges that run along the grid, in cells: all of a straight row err together."""
    rows = straight_rows(solution.contact, solution.boundary).astype(np.float64)
    endless = rows >= min(solution.grid.shape)
    # The rows of a smooth closed edge have this sum of squares, for the sum of their lengths.
    curved = _CURVED * float(np.sum(rows[~endless]))
    squares = float(np.sum(rows[endless] ** 2)) + max(float(np.sum(rows[~endless] ** 2)) - curved, 0.0)
    return _ALIGNED * math.sqrt(squares)


def _saturated_share(solution: ContactSolution) -> Array:
    """Return twice the share of saturated cells in each cluster, at most one, shape (count + 1,)."""
    clusters = solution.clusters
    found = np.bincount(clusters.labels[solution.saturated], minlength=clusters.count + 1)
    cells = np.concatenate(([1], clusters.cells))
    return np.minimum(2.0 * found / cells, 1.0)


def _closed(solution: ContactSolution, edge: Contour, stride: int) -> Array:
    """Return the areas inside the curve of which the edge has the chords."""
    step = np.sqrt(solution.grid.cell_area)
    bent = (_CHORDS + _BENT) * stride**2 * edge.euler * solution.grid.cell_area
    return np.asarray(np.maximum(edge.area + solution.edge_shift * step * edge.length + bent, 0.0))


def edge_error(edges: Drawn, excess: Array, share: float | Array = 1.0) -> float:
    """Return the error that all drawn edges have in common, m2, where they make up a share of the area.

    That is half of what is allowed for the resolution, the part of the kernel's shift that is not
    known, and where the edges between all and between every second cell differ in their pieces and
    holes, a cell for each.
    """
    own = _SHIFT_ERROR + _VARIES * edges.varies
    return float(np.sum(share * (0.5 * excess + own * edges.strip + edges.blunt))) + edges.unknown


def few_cells(solution: ContactSolution, edges: Drawn) -> Array:
    """Return the standard deviations of drawn areas, shape (count + 1,), m2; those around a few cells err more."""
    cells = np.concatenate(([np.inf], solution.clusters.cells))
    return np.asarray(edges.wander * (1.0 + (_FEW / cells) ** 3))
