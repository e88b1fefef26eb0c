"""The gap between two undeformed bodies."""

from __future__ import annotations

import attrs
import numpy as np

from roughcontact.body import Body
from roughcontact.checks import Array, Mask, frozen_array
from roughcontact.errors import InputError
from roughcontact.grid import Grid


@attrs.frozen(eq=False)
class Gap:
    """The bodies where their summits just touch.

    Attributes
    ----------
    undeformed
        Gap, shape (nx, ny), m, at least zero; at holes deeper than anywhere else.
    summit
        Greatest sum of both heights, m.
    holes
        Points that were not measured on one of the bodies, shape (nx, ny); None if there are none.
    """

    undeformed: Array
    summit: float
    holes: Mask | None

    def deeper(self, depth: float) -> Gap:
        """Return the same gap with the holes at another depth, m."""
        return attrs.evolve(self, undeformed=frozen_array(np.where(np.asarray(self.holes), depth, self.undeformed)))


def gap_between(body: Body, counter: Body, grid: Grid) -> Gap:
    """Return the gap of two bodies on a grid.

    Raises
    ------
    InputError
        If a surface does not give heights on the grid, or the holes of both leave nothing.
    """
    total = body.heights(grid) + counter.heights(grid)
    masks = [mask for mask in (body.holes(grid), counter.holes(grid)) if mask is not None]
    if not masks:
        summit = float(total.max())
        return Gap(frozen_array(summit - total), summit, None)
    holes = np.logical_or.reduce(masks)
    if holes.all():
        raise InputError("The bodies have nothing but holes where they face each other: no point was measured on both.")
    summit = float(total[~holes].max())
    gap = Gap(frozen_array(summit - total), summit, holes)
    deepest = float(gap.undeformed[~holes].max())
    return gap.deeper(2.0 * deepest or min(grid.spacing))
