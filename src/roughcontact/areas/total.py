"""From the areas of clusters to the area of the contact."""

from __future__ import annotations

import math

import numpy as np

from roughcontact.areas.base import framed
from roughcontact.areas.edges import Drawn
from roughcontact.areas.trust import doubts
from roughcontact.checks import Array
from roughcontact.solution import Area, ContactSolution

# Relative error by the square of the roughness, of the share in clusters of less than four cells, for
# summits that the grid does not show; and of a cluster of one cell by the roughness.
_UNSEEN = 0.12
_FLUCTUATION = 0.3


def summed(solution: ContactSolution, values: Array, bars: Array, common: float, edges: Drawn, name: str) -> Area:
    """Return the area of all clusters, with exactly nothing and the whole where that is.

    Parameters
    ----------
    values, bars
        Areas of the clusters and their standard deviations, shape (count + 1,), m2.
    common
        Error that all have in common, m2.
    """
    grid, clusters = solution.grid, solution.clusters
    cells = int(clusters.cells.sum())
    if cells in (0, solution.contact.size):
        whole = float(cells > 0)
        parts = np.full(int(whole), grid.area)
        hidden = _hidden(solution) * grid.cell_area
        return Area(whole * grid.area, whole, hidden, name, perimeter=0.0, clusters=parts)
    total = float(values.sum())
    value = min(total, grid.area)
    values = values * (value / total if total > 0.0 else 1.0)
    # Summits that the grid does not show have clusters of a few cells beside them.
    unseen = _UNSEEN * clusters.small_share * edges.roughness**2 * value
    few = np.concatenate(([1.0], clusters.cells))
    bars = np.hypot(bars, _FLUCTUATION * edges.roughness * values / few**1.5)
    return Area(
        value,
        value / grid.area,
        math.sqrt(float(np.sum(bars**2)) + common**2 + unseen**2 + edges.straight**2),
        name,
        perimeter=float(edges.length.sum()),
        clusters=values[1:],
        doubts=doubts(solution, edges.roughness),
    )


def _hidden(solution: ContactSolution) -> float:
    """Return the cells in full contact beside which the pressure would be gone before the next centre."""
    pressure = solution.pressure
    beyond = framed(pressure, 1, solution.boundary)
    around = (beyond[:-2, 1:-1], beyond[2:, 1:-1], beyond[1:-1, :-2], beyond[1:-1, 2:])
    steepest = np.max([np.abs(neighbour - pressure) for neighbour in around], axis=0)
    return float(np.count_nonzero((pressure > 0.0) & (2.0 * pressure < steepest)))
