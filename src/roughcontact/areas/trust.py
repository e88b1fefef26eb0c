"""What speaks against an area."""

from __future__ import annotations

import math

from roughcontact.areas.contour import change_at_edge
from roughcontact.solution import ContactSolution

# Above this share of the area in clusters of less than four cells the grid does not see the contact.
_SMALL = 0.2
# Waves of fewer cells than this carry curvature that the grid does not resolve.
_CELLS = 5.5
# Below this roughness load and curvature tell the area of the smallest clusters.
_ROUGH = 0.4
# Above this logarithmic change of the modulus between the shortest and the next waves the edge law errs by
# per cents of a cell.
_CHANGE = 0.3


def doubts(solution: ContactSolution, roughness: float) -> tuple[str, ...]:
    """Say why an area from this solution must not be trusted; nothing if nothing speaks against it."""
    found = []
    waves = 2.0 * math.pi / math.sqrt(roughness) if roughness > 0.0 else math.inf
    if waves < _CELLS:
        found.append(f"the curvature of the heights goes with waves of about {waves:.2g} cells: refine the grid")
    if solution.clusters.small_share > _SMALL and roughness > _ROUGH:
        found.append(
            f"{100 * solution.clusters.small_share:.3g} % of the counted area lies in clusters of less than four cells"
        )
    change = change_at_edge(solution)
    if change > _CHANGE:
        found.append(
            f"the modulus changes by a factor of {math.exp(change):.2g} within the cells at the edge, as under a thin "
            "layer: refine the grid"
        )
    if not solution.status.success:
        found.append("the solution is not converged")
    return tuple(found)
