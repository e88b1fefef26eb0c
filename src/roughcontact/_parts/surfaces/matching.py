"""Height maps placed anywhere in a domain, and two of them on the grid that both cover."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import ClassVar

import attrs
import numpy as np

from roughcontact._base.arrays import Array, Mask, Pair
from roughcontact._base.checks import choice, instance_of, number, pair
from roughcontact._base.units import Length, Quantity, si
from roughcontact._parts.grid import Grid
from roughcontact._parts.surfaces.base import Surface
from roughcontact._parts.surfaces.heightmap import HeightMap
from roughcontact._parts.surfaces.resampling import interpolate
from roughcontact.errors import InputError
from roughcontact.errors.door import guarded

# Fraction of a map by which a domain may reach beyond it, and a domain found by iteration is reduced.
_COVER_TOLERANCE = 1e-6
# Minimum fraction of an additional cell that lies inside the domain.
_MIN_CELL_FRACTION = 1e-3
# Sine or cosine of a rotation between parallel axes: rounding.
_PARALLEL_TOLERANCE = 1e-12
# Fraction of a cell to which a place is stated.
_PLACE_STEP = 1e-3
_is_map = instance_of(HeightMap, "Each side of a pair", "a HeightMap")


def _offset(value: Quantity | Sequence[Quantity]) -> Pair:
    return pair(value, "The offset of a height map", "m")


def _rotation(value: Quantity) -> float:
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
        Position (x, y) of the map's centre relative to the centre of the domain, m.
    rotation
        Angle by which the map is rotated about its centre, counter-clockwise, rad.
    mirrored
        Whether the map is turned over first, x to -x: needed for one of two maps that were both measured from outside
        and now face each other.
    interpolation
        Interpolation between the points: ``"bilinear"``, ``"cubic"`` (splines), or ``"fourier"`` (exact for
        band-limited periodic maps that are not rotated).

    Raises
    ------
    InputError
        If the interpolation is unknown or is ``"fourier"`` for a map that is rotated or not periodic.

    Examples
    --------
    >>> import roughcontact as rc
    >>> import numpy as np
    >>> ridge = np.zeros((32, 32))
    >>> ridge[16] = 1e-6
    >>> turned = rc.PlacedMap(rc.HeightMap(ridge, size=32e-6), rotation=np.pi / 2)
    >>> heights = turned.heights(rc.Grid((16, 16), 16e-6))
    >>> heights.shape
    (16, 16)
    """

    is_random: ClassVar[bool] = True

    source: HeightMap = attrs.field(validator=instance_of(HeightMap, "What is placed", "a HeightMap"))
    offset: Pair = attrs.field(converter=_offset, default=(0.0, 0.0), kw_only=True)
    rotation: float = attrs.field(converter=_rotation, default=0.0, kw_only=True)
    mirrored: bool = attrs.field(
        default=False, kw_only=True, validator=instance_of(bool, "Whether a map is mirrored", "True or False")
    )
    interpolation: str = attrs.field(default="bilinear", kw_only=True, metadata={"formerly": "method"})

    def __attrs_post_init__(self) -> None:
        choice(self.interpolation, "The interpolation", ("bilinear", "cubic", "fourier"))
        if self.interpolation == "fourier" and (not self.source.periodic or self.rotation != 0.0):
            raise InputError("Fourier interpolation needs a periodic map that is not rotated: use 'cubic'.")

    @property
    def parts(self) -> tuple[Surface, ...]:
        """Empty: the map is moved."""
        return ()

    @property
    def provenance(self) -> tuple[str, ...]:
        """The history of the map and how it was placed."""
        texts = list(self.source.history)
        if self.mirrored:
            texts.append("turned over, x to -x")
        if self.rotation != 0.0:
            texts.append(f"rotated by {math.degrees(self.rotation):.6g} degrees")
        place = [
            si(_PLACE_STEP * step * round(value / (_PLACE_STEP * step)) + 0.0, "m")
            for value, step in zip(self.offset, self.source.grid.spacing, strict=True)
        ]
        if self.offset != (0.0, 0.0):
            texts.append(f"its centre at ({', '.join(place)})")
        pitch = " x ".join(si(step, "m") for step in self.source.grid.spacing)
        return (*texts, f"interpolated ({self.interpolation}) between its points, which are {pitch} apart")

    @property
    def is_smooth(self) -> bool:
        """Whether the interpolation is not bilinear."""
        return self.interpolation != "bilinear"

    def heights(self, grid: Grid) -> Array:
        """Return the heights at the cell centres of a grid that the map covers, shape `grid.shape`, m."""
        self._require_cover(grid)
        i, j = self._indices(grid.x, grid.y)
        return interpolate(self.source.values, i, j, self.interpolation, periodic=self.source.periodic)

    def non_measured_on(self, grid: Grid) -> Mask | None:
        """Return the cells with more than half of their weight on non-measured points, shape `grid.shape`."""
        return self._place(self.source.non_measured, grid)

    def uncertain_on(self, grid: Grid) -> Mask | None:
        """Return the cells with more than half of their weight on uncertain points, shape `grid.shape`."""
        return self._place(self.source.uncertain, grid)

    def _place(self, mask: Mask | None, grid: Grid) -> Mask | None:
        if mask is None:
            return None
        i, j = self._indices(grid.x, grid.y)
        return interpolate(mask.astype(np.float64), i, j, "bilinear", periodic=self.source.periodic) > 0.5

    def shift_half_cell(self, grid: Grid, *, periodic: bool) -> PlacedMap:
        """Return the map placed half a cell aside."""
        dx, dy = grid.spacing
        return attrs.evolve(self, offset=(self.offset[0] + 0.5 * dx, self.offset[1] + 0.5 * dy))

    def _indices(self, x: Array, y: Array) -> tuple[Array, Array]:
        """Return positions in cells of the map, shapes that broadcast."""
        x = x - self.offset[0]
        y = y - self.offset[1]
        if self.rotation != 0.0:
            cos = math.cos(self.rotation)
            sin = math.sin(self.rotation)
            x, y = cos * x + sin * y, cos * y - sin * x
        if self.mirrored:
            x = -x
        nx, ny = self.source.grid.shape
        dx, dy = self.source.grid.spacing
        return x / dx + 0.5 * (nx - 1), y / dy + 0.5 * (ny - 1)

    def _require_cover(self, grid: Grid) -> None:
        if self.source.periodic:
            return
        # The border of the domain, not only the centres of its outer cells, must lie on the map.
        x, y = (0.5 * side * np.array([-1.0, 1.0]) for side in grid.size)
        corners = self._indices(x[:, np.newaxis], y[np.newaxis, :])
        for index, count in zip(corners, self.source.grid.shape, strict=True):
            if index.min() < -0.5 - _COVER_TOLERANCE * count or index.max() > count - 0.5 + _COVER_TOLERANCE * count:
                raise InputError(
                    f"The height map of {self.source.grid}, as it is placed, does not cover the {grid}: choose a "
                    "smaller domain or another place; match() finds the overlap of two maps."
                )


@attrs.frozen(eq=False, kw_only=True)
class MatchedPair:
    """Two height maps on a common grid.

    Attributes
    ----------
    grid
        The common grid.
    body, counterbody
        The maps, placed on it.
    """

    grid: Grid
    body: PlacedMap
    counterbody: PlacedMap


@guarded
def match(
    body: HeightMap,
    counterbody: HeightMap,
    *,
    offset: Length | Sequence[Length] = (0.0, 0.0),
    rotation: Quantity = 0.0,
    mirrored: bool = False,
    interpolation: str = "bilinear",
    shape: Sequence[int] | None = None,
    size: Length | Sequence[Length] | None = None,
) -> MatchedPair:
    """Return two height maps on a common grid, along the axes of the first.

    Parameters
    ----------
    body, counterbody
        The maps, each with its own cells and size. A periodic map covers the plane; the first of two periodic maps
        gives the domain.
    offset, rotation, mirrored
        Placement of the second map relative to the first; see `PlacedMap`.
    interpolation
        Interpolation of both maps: ``"bilinear"``, ``"cubic"`` or ``"fourier"``.
    shape
        Cells (nx, ny) of the common grid; by default as fine as the finer map along each axis.
    size
        Sides of the domain (x, y) or of both, m, about the centre of the overlap; by default the largest rectangle
        that both maps cover.

    Raises
    ------
    InputError
        If the maps do not overlap, or the domain is larger than the overlap.

    Examples
    --------
    >>> import roughcontact as rc
    >>> import numpy as np
    >>> rng = np.random.default_rng(0)
    >>> lower, upper = (rc.HeightMap(1e-6 * rng.standard_normal((32, 32)), size=32e-6) for _ in range(2))
    >>> pair = rc.match(lower, upper, offset=(4e-6, 0.0), mirrored=True)
    >>> print(pair.grid)
    28 x 32 cells on 28 µm x 32 µm
    """
    for side in (body, counterbody):
        _is_map(None, None, side)
    placed = PlacedMap(counterbody, offset=offset, rotation=rotation, mirrored=mirrored, interpolation=interpolation)
    centre, largest = _overlap(body, placed)
    wanted = largest if size is None else pair(size, "The size of the domain", "m", above=0.0)
    if any(side > most * (1 + _COVER_TOLERANCE) for side, most in zip(wanted, largest, strict=True)):
        raise InputError(
            f"The maps overlap on {si(largest[0], 'm')} x {si(largest[1], 'm')}, but a domain of "
            f"{si(wanted[0], 'm')} x {si(wanted[1], 'm')} was asked for: choose a smaller one or leave it out."
        )
    return MatchedPair(
        grid=Grid(_finer_cells(body, placed, wanted) if shape is None else shape, wanted),
        body=PlacedMap(body, offset=(-centre[0], -centre[1]), interpolation=interpolation),
        counterbody=attrs.evolve(placed, offset=(placed.offset[0] - centre[0], placed.offset[1] - centre[1])),
    )


def _finer_cells(body: HeightMap, placed: PlacedMap, size: Pair) -> tuple[int, int]:
    """Return the cells of a grid that is as fine as the finer map along each axis."""
    dx, dy = placed.source.grid.spacing
    cos = abs(math.cos(placed.rotation))
    sin = abs(math.sin(placed.rotation))
    # Pitch of the rotated map along an axis, from the cells that a line along it crosses.
    rotated = 1.0 / math.hypot(cos / dx, sin / dy), 1.0 / math.hypot(sin / dx, cos / dy)
    pitches = (min(one, other) for one, other in zip(body.grid.spacing, rotated, strict=True))
    nx, ny = (max(2, math.ceil(side / pitch - _MIN_CELL_FRACTION)) for side, pitch in zip(size, pitches, strict=True))
    return nx, ny


def _overlap(body: HeightMap, placed: PlacedMap) -> tuple[Pair, Pair]:
    """Return centre and sides of the largest rectangle that both cover, in the frame of the body, m."""
    if placed.source.periodic:
        return (0.0, 0.0), body.size
    cos = abs(math.cos(placed.rotation))
    sin = abs(math.sin(placed.rotation))
    if min(cos, sin) >= _PARALLEL_TOLERANCE:
        return _largest_rectangle(body, placed)
    lx, ly = placed.source.size
    sides = (lx, ly) if sin < _PARALLEL_TOLERANCE else (ly, lx)
    if body.periodic:
        return placed.offset, sides
    (x, width), (y, height) = (_intersect(*spans) for spans in zip(body.size, sides, placed.offset, strict=True))
    if min(width, height) <= 0.0:
        raise _apart(placed)
    return (x, y), (width, height)


def _intersect(one: float, other: float, offset: float) -> tuple[float, float]:
    """Return centre and length of the intersection of two intervals; the first is centred."""
    low = max(-0.5 * one, offset - 0.5 * other)
    high = min(0.5 * one, offset + 0.5 * other)
    return 0.5 * (low + high), high - low


def _apart(placed: PlacedMap) -> InputError:
    x, y = (si(value, "m") for value in placed.offset)
    return InputError(f"The height maps do not overlap where the second is shifted by ({x}, {y}): move them together.")


def _largest_rectangle(body: HeightMap, placed: PlacedMap) -> tuple[Pair, Pair]:
    """Return centre and sides of the largest rectangle inside all half planes of both maps, m."""
    from scipy.optimize import linprog, minimize_scalar

    normals, reach = _half_planes(placed.source.size, placed.rotation, placed.offset)
    if not body.periodic:
        more = _half_planes(body.size, 0.0, (0.0, 0.0))
        normals = np.vstack([normals, more[0]])
        reach = np.concatenate([reach, more[1]])
    unit = min(*placed.source.size, *body.size)
    bounds = [(None, None), (None, None), (0.0, None)]

    def best(skew: float) -> Array:
        """Return centre and half side of the largest rectangle of aspect ratio exp(2 skew), in units."""
        # A rectangle lies in a half plane if its centre does, by the extent of the rectangle along the normal.
        extent = np.abs(normals) @ [math.exp(skew), math.exp(-skew)]
        found = linprog([0.0, 0.0, -1.0], A_ub=np.column_stack([normals, extent]), b_ub=reach / unit, bounds=bounds)
        if found.x is None or found.x[2] <= 0.0:
            raise _apart(placed)
        return np.asarray(found.x, dtype=np.float64)

    skew = float(minimize_scalar(lambda s: -best(s)[2], bounds=(-5.0, 5.0), options={"xatol": 1e-9}).x)
    x, y, half = np.where(np.abs(found := best(skew)) < _COVER_TOLERANCE, 0.0, found) * unit
    width, height = (2.0 * half * (1 - _COVER_TOLERANCE) * math.exp(sign * skew) for sign in (1, -1))
    return (float(x), float(y)), (float(width), float(height))


def _half_planes(size: Pair, rotation: float, offset: Pair) -> tuple[Array, Array]:
    """Return the normals, shape (4, 2), and the bounds, shape (4,), of a rectangle: inside, n . p <= bound."""
    cos = math.cos(rotation)
    sin = math.sin(rotation)
    normals = np.array([[cos, sin], [-cos, -sin], [-sin, cos], [sin, -cos]])
    reach = 0.5 * np.array([size[0], size[0], size[1], size[1]])
    return normals, reach + normals @ np.array(offset)
