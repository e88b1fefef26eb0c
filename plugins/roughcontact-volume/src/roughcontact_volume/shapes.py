"""Shapes of regions below a surface, and the fraction of each cell that lies in one."""

from __future__ import annotations

import abc
import itertools
from collections.abc import Sequence
from typing import TypeAlias

import attrs
import numpy as np
import numpy.typing as npt
import roughcontact as rc
from roughcontact.typing import Array, Part, si

Triple: TypeAlias = tuple[float, float, float]
Mask: TypeAlias = npt.NDArray[np.bool_]
# Points along each side of a cell by which the fraction in a shape is counted.
_POINTS = 8


def read_lengths(values: object, what: str) -> Triple:
    """Return three lengths, m, above zero, or raise `InputError`."""
    x, y, z = read_triple(values, what)
    if not min(x, y, z) > 0.0:
        raise rc.InputError.about(what, values, "three lengths above zero (m)")
    return x, y, z


def read_triple(values: object, what: str) -> Triple:
    """Return three finite numbers or raise `InputError`."""
    allowed = "three finite numbers, along x, y and z (m)"
    found = np.asarray(values) if isinstance(values, (Sequence, np.ndarray)) else np.empty(0)
    if found.shape != (3,) or found.dtype.kind not in "fiu" or not np.isfinite(found).all():
        raise rc.InputError.about(what, values, allowed)
    x, y, z = map(float, found)
    return x, y, z


def read_centre(values: object) -> Triple:
    """Return the centre of a shape, m, or raise `InputError`."""
    return read_triple(values, "The centre of a region")


def read_shape(value: object) -> Shape:
    """Return a shape, or raise `InputError` for anything else."""
    if not isinstance(value, Shape):
        raise rc.InputError.about("The shape of a region", value, "a Sphere, an Ellipsoid or a Cuboid")
    return value


def read_side(value: object, what: str = "The side of a region") -> str:
    """Return the name of a body, or raise `InputError`, whose subject is `what`."""
    if value not in ("body", "counterbody"):
        raise rc.InputError.about(what, value, "'body' or 'counterbody'")
    return str(value)


class Shape(Part, abc.ABC):
    """A region of a body, around its centre."""

    @property
    @abc.abstractmethod
    def half_lengths(self) -> Triple:
        """Half its lengths along x, y and z, m."""

    @abc.abstractmethod
    def contains(self, x: Array, y: Array, z: Array) -> Mask:
        """Return whether points, broadcastable distances from the centre, m, lie in it."""


def _radius(value: object) -> float:
    return read_lengths((value,) * 3, "The radius of a sphere")[0]


def _semi_axes(values: object) -> Triple:
    return read_lengths(values, "The semi-axes of an ellipsoid")


def _lengths(values: object) -> Triple:
    return read_lengths(values, "The lengths of a cuboid")


@attrs.frozen
class Ellipsoid(Shape):
    """An ellipsoid with its axes along x, y and z.

    Parameters
    ----------
    semi_axes
        Its semi-axes along x, y and z, m.
    """

    semi_axes: Triple = attrs.field(converter=_semi_axes, metadata={"unit": "m"})

    @property
    def half_lengths(self) -> Triple:
        """Its semi-axes, m."""
        return self.semi_axes

    def contains(self, x: Array, y: Array, z: Array) -> Mask:
        """Return whether points lie in it; see `Shape.contains`."""
        a, b, c = self.semi_axes
        return np.asarray((x / a) ** 2 + (y / b) ** 2 + (z / c) ** 2 <= 1.0)


@attrs.frozen
class Sphere(Shape):
    """A sphere.

    Parameters
    ----------
    radius
        Its radius, m.
    """

    radius: float = attrs.field(converter=_radius, metadata={"unit": "m"})

    @property
    def half_lengths(self) -> Triple:
        """Its radius along x, y and z, m."""
        return self.radius, self.radius, self.radius

    def contains(self, x: Array, y: Array, z: Array) -> Mask:
        """Return whether points lie in it; see `Shape.contains`."""
        return np.asarray(x**2 + y**2 + z**2 <= self.radius**2)


@attrs.frozen
class Cuboid(Shape):
    """A cuboid with its edges along x, y and z.

    Parameters
    ----------
    lengths
        Its lengths along x, y and z, m.
    """

    lengths: Triple = attrs.field(converter=_lengths, metadata={"unit": "m"})

    @property
    def half_lengths(self) -> Triple:
        """Half its lengths, m."""
        a, b, c = self.lengths
        return 0.5 * a, 0.5 * b, 0.5 * c

    def contains(self, x: Array, y: Array, z: Array) -> Mask:
        """Return whether points lie in it; see `Shape.contains`."""
        a, b, c = self.half_lengths
        return np.asarray((np.abs(x) <= a) & (np.abs(y) <= b) & (np.abs(z) <= c))


def check_place(shape: Shape, centre: Triple, grid: rc.Grid, boundary: rc.Boundary) -> None:
    """Raise `InputError` unless a shape lies below the surface and within the borders that do not repeat."""
    halves = shape.half_lengths
    top = centre[2] - halves[2]
    if not top > 0.0:
        raise rc.InputError(
            f"The {type(shape).__name__.lower()} reaches the surface: its top lies at a depth of {si(top, 'm')}. "
            "Place its centre deeper, or describe the body down from the surface by a MaterialField."
        )
    for axis, name in enumerate("xy"):
        half = 0.5 * grid.size[axis]
        reach = halves[axis] if boundary.repeats[axis] else abs(centre[axis]) + halves[axis]
        if reach > half:
            raise rc.InputError(
                f"The {type(shape).__name__.lower()} reaches over the border of the domain along {name}: it ends "
                f"{si(reach, 'm')} from the middle, the domain at {si(half, 'm')}. Take a larger domain."
            )


def find_fractions(shape: Shape, centre: Triple, grid: rc.Grid, boundary: rc.Boundary, interfaces: Array) -> Array:
    """Return the fraction of each cell that lies in a shape, shape (nz, nx, ny).

    Parameters
    ----------
    interfaces
        Depths between which the layers lie, shape (nz + 1,), m.
    """
    offsets = (np.arange(_POINTS) + 0.5) / _POINTS
    steps = np.diff(interfaces)
    total = np.zeros((steps.size, *grid.shape))
    for a, b, c in itertools.product(offsets, repeat=3):
        x = _find_distance(grid, boundary, centre, 0, a)
        y = _find_distance(grid, boundary, centre, 1, b)
        z = interfaces[:-1] + c * steps - centre[2]
        total += shape.contains(x, y, z[:, np.newaxis, np.newaxis])
    return np.asarray(total / _POINTS**3)


def _find_distance(grid: rc.Grid, boundary: rc.Boundary, centre: Triple, axis: int, offset: float) -> Array:
    """Return how far points at a part of each cell lie from a centre along an axis, m."""
    step = grid.spacing[axis]
    distance = (grid.x, grid.y)[axis] + (offset - 0.5) * step - centre[axis]
    if boundary.repeats[axis]:
        side = grid.size[axis]
        distance = distance - side * np.round(distance / side)
    return np.asarray(distance)
