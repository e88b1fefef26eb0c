"""A height map put down anywhere in a domain: moved, rotated, turned over."""

from __future__ import annotations

import math
from collections.abc import Sequence

import attrs
import numpy as np

from roughcontact.checks import Array, Mask, Pair, choice, instance_of, number, pair
from roughcontact.errors import InputError
from roughcontact.grid import Grid
from roughcontact.surfaces.base import Surface
from roughcontact.surfaces.heightmap import HeightMap
from roughcontact.surfaces.resampling import between
from roughcontact.units import si

METHODS = ("bilinear", "cubic", "fourier")
# Share of a map by which a domain may reach beyond it: rounding.
_ROUNDING = 1e-6


def _offset(value: float | Sequence[float]) -> Pair:
    return pair(value, "The offset of a height map", "m")


def _rotation(value: float) -> float:
    # A larger angle was most likely meant in degrees.
    unit = "rad, np.deg2rad turns degrees into it"
    return number(value, "The rotation of a height map", unit, at_least=-math.tau, at_most=math.tau)


@attrs.frozen(eq=False)
class PlacedMap(Surface):
    """A height map moved, rotated or turned over, and interpolated between its points.

    Parameters
    ----------
    source
        The map.
    offset
        Where the centre of the map lies, relative to the centre of the domain, m.
    rotation
        Angle by which the map is rotated about its centre, counter-clockwise, rad.
    mirrored
        Whether the map is turned over first, x to -x: what was measured from outside, looking at
        one of the bodies, is so seen from inside the other.
    method
        Interpolation between the points: ``"bilinear"``, ``"cubic"`` (splines), or ``"fourier"``
        (exact for band-limited periodic maps that are not rotated).

    Raises
    ------
    InputError
        If the method is unknown or does not serve this map.
    """

    source: HeightMap = attrs.field(validator=instance_of(HeightMap, "What is placed", "a HeightMap"))
    offset: Pair = attrs.field(converter=_offset, default=(0.0, 0.0), kw_only=True)
    rotation: float = attrs.field(converter=_rotation, default=0.0, kw_only=True)
    mirrored: bool = attrs.field(
        default=False, kw_only=True, validator=instance_of(bool, "Whether a map is mirrored", "True or False")
    )
    method: str = attrs.field(default="bilinear", kw_only=True)

    def __attrs_post_init__(self) -> None:
        choice(self.method, "The interpolation", METHODS)
        if self.method == "fourier" and (not self.source.periodic or self.rotation != 0.0):
            raise InputError("Fourier interpolation needs a periodic map that is not rotated: use 'cubic'.")

    @property
    def history(self) -> tuple[str, ...]:
        """What was done to the map, this placing included."""
        texts = list(self.source.history)
        if self.mirrored:
            texts.append("turned over, x to -x")
        if self.rotation != 0.0:
            texts.append(f"rotated by {math.degrees(self.rotation):.6g} degrees")
        if self.offset != (0.0, 0.0):
            texts.append(f"its centre at ({si(self.offset[0], 'm')}, {si(self.offset[1], 'm')})")
        pitch = " x ".join(si(step, "m") for step in self.source.grid.spacing)
        return (*texts, f"interpolated ({self.method}) between its points, which are {pitch} apart")

    def heights(self, grid: Grid) -> Array:
        """Return the heights at the cell centres, shape `grid.shape`, m.

        Raises
        ------
        InputError
            If the map does not cover the grid.
        """
        self._require_cover(grid)
        i, j = self._indices(grid.x, grid.y)
        return between(self.source.values, i, j, self.method, periodic=self.source.periodic)

    def holes_on(self, grid: Grid) -> Mask | None:
        """Return which cells are made of holes for more than a half, shape `grid.shape`."""
        if self.source.holes is None:
            return None
        missing = self.source.holes.astype(np.float64)
        i, j = self._indices(grid.x, grid.y)
        return between(missing, i, j, "bilinear", periodic=self.source.periodic) > 0.5

    def _indices(self, x: Array, y: Array) -> tuple[Array, Array]:
        """Return positions, shapes that broadcast, in cells of the map."""
        x, y = x - self.offset[0], y - self.offset[1]
        if self.rotation != 0.0:
            cos, sin = math.cos(self.rotation), math.sin(self.rotation)
            x, y = cos * x + sin * y, cos * y - sin * x
        if self.mirrored:
            x = -x
        (nx, ny), (dx, dy) = self.source.grid.shape, self.source.grid.spacing
        return x / dx + 0.5 * (nx - 1), y / dy + 0.5 * (ny - 1)

    def _require_cover(self, grid: Grid) -> None:
        if self.source.periodic:
            return
        # The border of the domain, not only the centres of its outer cells, must lie on the map.
        x, y = (0.5 * side * np.array([-1.0, 1.0]) for side in grid.size)
        corners = self._indices(x[:, np.newaxis], y[np.newaxis, :])
        for index, count in zip(corners, self.source.grid.shape, strict=True):
            if index.min() < -0.5 - _ROUNDING * count or index.max() > count - 0.5 + _ROUNDING * count:
                raise InputError(
                    f"The height map of {self.source.grid}, as it is placed, does not cover the {grid}: choose a "
                    "smaller domain or another place; match() finds the overlap of two maps."
                )
