"""The mix of drawn edges and Hertz's areas that is the default."""

from __future__ import annotations

import attrs
import numpy as np

from roughcontact.areas.base import AreaEstimator
from roughcontact.areas.edges import drawn, edge_error, few_cells
from roughcontact.areas.hertz import common_error, hertz_areas
from roughcontact.areas.total import summed
from roughcontact.checks import Array
from roughcontact.solution import Area, ContactSolution

# From so many cells on the drawn area is worth extrapolating, and from so many it is wholly so.
_REFINED = (4.0, 12.0)
# Drawn edges of clusters with more cells beat Hertz in any case.
_LARGEST = 1000
# A cluster with more of its edge sharp than this is counted along it, and no Hertz contact. Heights that the
# grid does not resolve, of a roughness above one, make more edges look sharp.
_SHARP = 0.1


@attrs.frozen
class Blend(AreaEstimator):
    r"""Drawn edges and Hertz's areas, cluster by cluster, weighted by the inverse of their variances.

    .. math:: A = \sum_c w A_\mathrm{Hertz} + (1 - w) A_\mathrm{drawn},
              \quad w = \sigma_\mathrm{drawn}^2 / (\sigma_\mathrm{drawn}^2 + \sigma_\mathrm{Hertz}^2)

    Small clusters go by load and curvature, large ones by their edges; `LevelSet`,
    `LevelSetRichardson` and `Hertz` tell how. Sharp edges are counted, and no cluster is smaller
    than its load at the pressure limit.
    """

    def estimate(self, solution: ContactSolution) -> Area:
        """Return the blended area; see `AreaEstimator.estimate`."""
        edges = drawn(solution)
        cells = np.concatenate(([1.0], solution.clusters.cells))
        smooth = edges.sharp <= _SHARP * max(1.0, edges.roughness)
        share = np.clip((cells - _REFINED[0]) / (_REFINED[1] - _REFINED[0]), 0.0, 1.0)
        share = np.where(smooth, share * share * (3.0 - 2.0 * share), 0.0)
        fine, refined = edges.area - edges.excess, edges.refined - edges.excess_refined
        lines = np.maximum(share * refined + (1.0 - share) * np.where(smooth, fine, edges.area), _needed(solution))
        spread = np.hypot(few_cells(solution, edges), 0.5 * edges.excess + edges.blunt)
        found = hertz_areas(solution, _LARGEST)
        known = smooth & np.isfinite(found.error)
        # A contact much smaller than a cell is known by its load alone; else the greater area is the safer scale.
        below = found.area < solution.grid.cell_area
        error = np.where(known, found.error, 1.0) * np.where(below, found.area, np.maximum(found.area, lines))
        with np.errstate(invalid="ignore"):
            weight = np.where(known, spread**2 / (spread**2 + error**2), 0.0)
        weight = np.where(np.isfinite(weight), weight, 1.0)
        hertzian = weight * found.area
        values = hertzian + (1.0 - weight) * lines
        bars = np.where(known, np.sqrt(weight) * error, spread)
        excess = np.where(smooth, share * edges.excess_refined + (1.0 - share) * edges.excess, 0.0)
        common = edge_error(edges, excess, 1.0 - weight) + common_error(found, hertzian)
        return summed(solution, values, bars, common, edges, "blend")


def _needed(solution: ContactSolution) -> Array:
    """Return the areas that the clusters need to bear their loads at the pressure limit."""
    if np.isinf(solution.limit).all():
        return np.zeros(solution.clusters.count + 1)
    needed = solution.clusters.sums(solution.pressure / solution.limit) * solution.grid.cell_area
    return np.concatenate(([0.0], needed))
