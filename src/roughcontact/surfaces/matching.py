"""Two height maps of different grids, brought together on the domain that both cover."""

from __future__ import annotations

import math
from collections.abc import Sequence

import attrs
import numpy as np

from roughcontact.checks import Array, Pair, instance_of, pair
from roughcontact.errors import InputError
from roughcontact.grid import Grid
from roughcontact.surfaces.heightmap import HeightMap
from roughcontact.surfaces.placed import PlacedMap
from roughcontact.units import si

# A domain found by iteration is shrunk by this share, so that it does not reach over the border of a map.
_INSIDE = 1e-6
# A cell that would be cut by no more than this share of itself is not added.
_CUT = 1e-3
_ALIGNED = 1e-12
_ANYWHERE = [(None, None), (None, None), (0.0, None)]
_is_map = instance_of(HeightMap, "Each side of a pair", "a HeightMap")


@attrs.frozen(eq=False, kw_only=True)
class MatchedPair:
    """Two height maps on a common grid.

    Attributes
    ----------
    grid
        The common grid.
    body, counter
        The maps as they lie on it.
    """

    grid: Grid
    body: PlacedMap
    counter: PlacedMap


def match(
    body: HeightMap,
    counter: HeightMap,
    *,
    offset: float | Sequence[float] = (0.0, 0.0),
    rotation: float = 0.0,
    mirrored: bool = False,
    method: str = "bilinear",
    shape: Sequence[int] | None = None,
    size: float | Sequence[float] | None = None,
) -> MatchedPair:
    """Put two height maps on a common grid, along the axes of the first.

    Parameters
    ----------
    body, counter
        The maps, each with its own cells and size. A periodic map covers the whole plane; of two
        periodic maps the first gives the domain.
    offset
        Where the centre of the second map lies, relative to that of the first, m.
    rotation
        Angle by which the second map is rotated about its centre, counter-clockwise, rad.
    mirrored
        Whether the second map is turned over first, x to -x: maps measured from outside, each
        looking at its own body, face each other so.
    method
        Interpolation: ``"bilinear"``, ``"cubic"`` or ``"fourier"``; see `PlacedMap`.
    shape
        Cells (nx, ny) of the common grid; if left out, as fine as the finer map along each axis.
    size
        Sides of the domain (x, y) or of both, m, about the centre of the overlap; if left out, the
        largest rectangle that both maps cover.

    Raises
    ------
    InputError
        If the maps do not overlap, or the domain asked for is larger than the overlap.
    """
    for side in (body, counter):
        _is_map(None, None, side)
    placed = PlacedMap(counter, offset=offset, rotation=rotation, mirrored=mirrored, method=method)
    centre, largest = _overlap(body, placed)
    wanted = largest if size is None else pair(size, "The size of the domain", "m", above=0.0)
    if any(side > most * (1 + _INSIDE) for side, most in zip(wanted, largest, strict=True)):
        raise InputError(
            f"The maps overlap on {si(largest[0], 'm')} x {si(largest[1], 'm')}, but a domain of "
            f"{si(wanted[0], 'm')} x {si(wanted[1], 'm')} was asked for: choose a smaller one or leave it out."
        )
    grid = Grid(_finest(body, placed, wanted) if shape is None else shape, wanted)
    return MatchedPair(
        grid=grid,
        body=PlacedMap(body, offset=(-centre[0], -centre[1]), method=method),
        counter=attrs.evolve(placed, offset=(placed.offset[0] - centre[0], placed.offset[1] - centre[1])),
    )


def _finest(body: HeightMap, placed: PlacedMap, size: Pair) -> tuple[int, int]:
    """Return the cells of a grid that is as fine as the finer map along each axis."""
    dx, dy = placed.source.grid.spacing
    cos, sin = abs(math.cos(placed.rotation)), abs(math.sin(placed.rotation))
    # The pitch of the rotated map along an axis, by the cells that a line along it crosses.
    turned = 1.0 / math.hypot(cos / dx, sin / dy), 1.0 / math.hypot(sin / dx, cos / dy)
    pitches = (min(one, other) for one, other in zip(body.grid.spacing, turned, strict=True))
    nx, ny = (max(2, math.ceil(side / pitch - _CUT)) for side, pitch in zip(size, pitches, strict=True))
    return nx, ny


def _overlap(body: HeightMap, placed: PlacedMap) -> tuple[Pair, Pair]:
    """Return centre and sides of the largest rectangle that both cover, in the frame of the body, m."""
    if placed.source.periodic:
        return (0.0, 0.0), body.size
    cos, sin = abs(math.cos(placed.rotation)), abs(math.sin(placed.rotation))
    lx, ly = placed.source.size
    if min(cos, sin) < _ALIGNED:
        sides = (lx, ly) if sin < _ALIGNED else (ly, lx)
        if body.periodic:
            return placed.offset, sides
        spans = [_span(*span) for span in zip(body.size, sides, placed.offset, strict=True)]
        (x, width), (y, height) = spans
        if min(width, height) <= 0.0:
            raise _apart(placed)
        return (x, y), (width, height)
    return _largest_rectangle(body, placed)


def _span(one: float, other: float, offset: float) -> tuple[float, float]:
    """Return centre and length of what two intervals share; the first is centred."""
    low, high = max(-0.5 * one, offset - 0.5 * other), min(0.5 * one, offset + 0.5 * other)
    return 0.5 * (low + high), high - low


def _apart(placed: PlacedMap) -> InputError:
    x, y = (si(value, "m") for value in placed.offset)
    return InputError(f"The height maps do not overlap with an offset of ({x}, {y}): move them together.")


def _largest_rectangle(body: HeightMap, placed: PlacedMap) -> tuple[Pair, Pair]:
    """Return centre and sides of the largest rectangle inside all half planes of both maps, m."""
    from scipy.optimize import linprog, minimize_scalar

    normals, reach = _half_planes(placed.source.size, placed.rotation, placed.offset)
    if not body.periodic:
        more = _half_planes(body.size, 0.0, (0.0, 0.0))
        normals, reach = np.vstack([normals, more[0]]), np.concatenate([reach, more[1]])
    unit = min(*placed.source.size, *body.size)

    def best(skew: float) -> Array:
        """Return centre and half side of the largest rectangle of aspect ratio exp(2 skew), in units."""
        # A rectangle lies in a half plane when its centre does by its own extent along the normal.
        extent = np.abs(normals) @ [math.exp(skew), math.exp(-skew)]
        found = linprog([0.0, 0.0, -1.0], A_ub=np.column_stack([normals, extent]), b_ub=reach / unit, bounds=_ANYWHERE)
        if found.x is None or found.x[2] <= 0.0:
            raise _apart(placed)
        return np.asarray(found.x, dtype=np.float64)

    skew = float(minimize_scalar(lambda s: -best(s)[2], bounds=(-5.0, 5.0), options={"xatol": 1e-9}).x)
    x, y, half = np.where(np.abs(found := best(skew)) < _INSIDE, 0.0, found) * unit
    width, height = (2.0 * half * (1 - _INSIDE) * math.exp(sign * skew) for sign in (1, -1))
    return (float(x), float(y)), (float(width), float(height))


def _half_planes(size: Pair, rotation: float, offset: Pair) -> tuple[Array, Array]:
    """Return the normals, shape (4, 2), and the bounds, shape (4,), of a rectangle: inside, n . p <= bound."""
    cos, sin = math.cos(rotation), math.sin(rotation)
    normals = np.array([[cos, sin], [-cos, -sin], [-sin, cos], [sin, -cos]])
    reach = 0.5 * np.array([size[0], size[0], size[1], size[1]])
    return normals, reach + normals @ np.array(offset)
