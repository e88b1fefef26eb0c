"""Height maps from and to the package SurfaceTopography."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, Any

import numpy as np

from roughcontact._base.checks import Array, Pair, choice
from roughcontact._parts.surfaces.filling import TREATMENTS, complete
from roughcontact.errors import InputError, MissingPackage

if TYPE_CHECKING:
    from roughcontact._parts.surfaces.heightmap import HeightMap

_ASKED = ("dim", "unit", "to_unit", "heights", "physical_sizes", "is_periodic")


def read_topography(topography: Any) -> tuple[Array, Pair, bool]:
    """Return heights, shape (nx, ny), m, NaN at non-measured points; the sides, m; and whether it is periodic.

    Raises
    ------
    InputError
        If it is not a two-dimensional topography of SurfaceTopography, or does not state its unit.
    """
    if not all(hasattr(topography, name) for name in _ASKED):
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


def read_map(topography: Any, non_measured: str) -> dict[str, Any]:
    """Return the arguments of a `HeightMap`; see `HeightMap.from_topography`."""
    choice(non_measured, "The treatment of non-measured points", TREATMENTS)
    try:
        heights, size, periodic = read_topography(topography)
    except InputError as error:
        raise InputError(f"The topography cannot be used: {str(error).rstrip('.')}.") from error
    heights, mask, done = complete(heights, "the topography", non_measured)
    history = (f"from a topography of SurfaceTopography{done}",)
    return {"heights": heights, "size": size, "periodic": periodic, "non_measured": mask, "history": history}


def make_topography(height_map: HeightMap) -> Any:
    """Return the map as a `SurfaceTopography.Topography`; see `HeightMap.to_topography`."""
    try:
        # Its imports warn of optional parallel packages.
        with warnings.catch_warnings(action="ignore"):
            from SurfaceTopography import Topography
    except ImportError:
        raise MissingPackage(
            "A topography needs the package SurfaceTopography: pip install SurfaceTopography."
        ) from None
    heights = height_map.values.copy()
    mask = height_map.non_measured
    return Topography(
        heights if mask is None else np.ma.masked_array(heights, mask),
        height_map.size,
        periodic=height_map.periodic,
        unit="m",
    )
