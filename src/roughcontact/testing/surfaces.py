"""Claims about surfaces."""

from __future__ import annotations

import numpy as np

from roughcontact.checks import Array
from roughcontact.errors import InputError
from roughcontact.grid import Grid
from roughcontact.surfaces import Surface
from roughcontact.surfaces.base import own_grid
from roughcontact.testing.claim import Claim, require
from roughcontact.testing.common import common


def _known(surface: Surface) -> tuple[Grid, Array]:
    """Return heights on a grid that the surface knows."""
    own = own_grid(surface)
    reasons = []
    for grid in (
        (own,) if own is not None else (Grid((24, 20), (24e-6, 20e-6)), Grid((24, 20), 1e-3), Grid((9, 8), 1.0))
    ):
        try:
            return grid, surface.heights(grid)
        except InputError as error:
            reasons.append(str(error))
    raise AssertionError(f"no grid will do: {reasons[0]}")


def _shapes(surface: Surface) -> str:
    grid, heights = _known(surface)
    require(heights.shape == grid.shape, f"heights of shape {heights.shape} on a grid of {grid.shape} cells")
    require(heights.dtype == np.float64, f"heights of type {heights.dtype} where float64 is needed")
    require(np.isfinite(heights).all(), "heights that are not finite")
    return f"a relief of {np.ptp(heights):.3g} m on {grid}"


def _repeatable(surface: Surface) -> str:
    grid, first = _known(surface)
    kept = first.copy()
    if first.flags.writeable:
        first[...] = 7.0
    require(np.array_equal(surface.heights(grid), kept), "asked again, it has other heights")
    return "the same heights, asked again"


CLAIMS = (
    Claim("surface", "shapes and types", _shapes),
    Claim("surface", "repeatable", _repeatable),
    *common("surface"),
)
