"""Heights from and to the topographies of the package SurfaceTopography."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np

from roughcontact._base.arrays import Array, Mask, Pair
from roughcontact.errors import InputError, requiring

_TOPOGRAPHY_ATTRIBUTES = ("dim", "unit", "to_unit", "heights", "physical_sizes", "is_periodic")


def read_topography(topography: Any) -> tuple[Array, Pair, bool]:
    """Return heights, shape (nx, ny), m, NaN at non-measured points; the sides, m; and whether it is periodic.

    `InputError` if it is not a two-dimensional topography of SurfaceTopography, or does not state its unit.
    """
    if not all(hasattr(topography, name) for name in _TOPOGRAPHY_ATTRIBUTES):
        raise InputError.about("it", topography, "a Topography of the package SurfaceTopography")
    if topography.dim != 2:
        raise InputError("it holds a line profile, not a height map")
    if topography.unit is None:
        raise InputError("it does not state its unit of length")
    if getattr(topography, "is_domain_decomposed", False):
        raise InputError("it is spread over several processes: gather it in one")
    metric = topography.to_unit("m")
    heights = np.ma.filled(np.ma.asarray(metric.heights(), dtype=np.float64), np.nan)
    lx, ly = (float(side) for side in metric.physical_sizes)
    return heights, (lx, ly), bool(metric.is_periodic)


def make_topography(heights: Array, size: Pair, *, periodic: bool, non_measured: Mask | None) -> Any:
    """Return heights, m, as a `SurfaceTopography.Topography`, masked at non-measured points."""
    advice = "A topography needs the package SurfaceTopography: pip install SurfaceTopography."
    # Its imports warn of optional parallel packages.
    with requiring(advice), warnings.catch_warnings(action="ignore"):
        from SurfaceTopography import Topography
    values = heights.copy() if non_measured is None else np.ma.masked_array(heights.copy(), non_measured)
    return Topography(values, size, periodic=periodic, unit="m")
