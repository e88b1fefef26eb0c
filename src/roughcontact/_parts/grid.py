"""The grid of rectangular cells on which every field of a problem lives, and the load of a contact."""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum
from functools import cached_property
from typing import Any

import attrs
import numpy as np
import numpy.typing as npt

from roughcontact._base.arrays import Array, Mask, Pair
from roughcontact._base.checks import choice, integer, list_of, number, pair
from roughcontact._base.machine import require_memory
from roughcontact._base.units import PlainText, Quantity, si
from roughcontact.errors import InputError, argument

# Maximum cells of a grid: a field takes 8 TiB. Memory is asked for where fields are made: a process may have a slab.
_MAX_CELLS = 2**40
_LOAD_KINDS = {"pressure": ("The mean pressure", "Pa"), "force": ("The force", "N"), "approach": ("The approach", "m")}
# Note on several loads where the pressure has a limit.
FIRST_LOADING = "Each load is a first loading, of surfaces not flattened yet (see running in)."
_LOAD_ARGUMENTS = f"{argument('pressure')} (Pa), {argument('force')} (N) and {argument('approach')} (m)"


class Boundary(StrEnum):
    """What lies beyond the border of the grid: one word for both axes, or one for x and one for y.

    Examples
    --------
    >>> import roughcontact as rc
    >>> rc.Boundary("periodic") is rc.Boundary.PERIODIC
    True
    >>> rc.Boundary.FREE_PERIODIC.free_axes
    (True, False)
    """

    FREE = "free"
    PERIODIC = "periodic"
    WRAPPED = "wrapped"
    FREE_PERIODIC = "free-periodic"
    PERIODIC_FREE = "periodic-free"

    @property
    def free_axes(self) -> tuple[bool, bool]:
        """Whether the domain ends at its border along x, and along y."""
        return self in (Boundary.FREE, Boundary.FREE_PERIODIC), self in (Boundary.FREE, Boundary.PERIODIC_FREE)

    @property
    def repeats(self) -> tuple[bool, bool]:
        """Whether all images of the domain count along x, and along y: a wrapped domain has the nearest ones alone."""
        free_x, free_y = self.free_axes
        return (False, False) if self is Boundary.WRAPPED else (not free_x, not free_y)

    @property
    def has_free_axis(self) -> bool:
        """Whether the domain ends at its border along an axis."""
        return any(self.free_axes)

    @property
    def free_axis(self) -> int:
        """The first axis along which the domain ends at its border: the only one where the other is periodic."""
        return self.free_axes.index(True)

    @property
    def mixed(self) -> bool:
        """Whether the domain is free along one axis and periodic along the other."""
        return self in (Boundary.FREE_PERIODIC, Boundary.PERIODIC_FREE)


def as_boundary(value: str | Sequence[str]) -> Boundary:
    """Return the boundary that a word, or a pair of words for x and y, names; `InputError` if there is none."""
    word: object = value
    if isinstance(value, (tuple, list)) and len(value) == 2 and all(isinstance(one, str) for one in value):
        word = value[0] if value[0] == value[1] else "-".join(value)
    return Boundary(choice(word, "The boundary", [str(name) for name in Boundary]))


def grid_shape(value: Sequence[int]) -> tuple[int, int]:
    if not isinstance(value, (tuple, list, np.ndarray)) or len(value) != 2:
        raise InputError.about("The shape of the grid", value, "two whole numbers, (cells in x, cells in y)")
    nx, ny = (integer(n, "A cell count of the grid", at_least=1) for n in value)
    if nx * ny < 2:
        raise InputError.about("The grid", PlainText(f"{nx} x {ny}"), "of at least two cells")
    if nx * ny > _MAX_CELLS:
        raise InputError.about(
            "The grid", PlainText(f"{nx} x {ny}"), "of at most 2^40 cells, of which a field takes 8 TiB"
        )
    return nx, ny


def _size(value: Quantity | Sequence[Quantity]) -> Pair:
    return pair(value, "The size of the domain", "m", above=0.0)


@attrs.frozen
class Grid:
    """A rectangle of `shape` cells; fields are given at the cell centres and indexed [x, y].

    Parameters
    ----------
    shape
        Number of cells (nx, ny).
    size
        Lengths of the sides of the domain (x, y) or of both, m.

    Raises
    ------
    InputError
        If there are fewer than two cells or a side is not a positive finite length.

    Examples
    --------
    >>> import roughcontact as rc
    >>> grid = rc.Grid(shape=(4, 2), size=(8e-6, 6e-6))
    >>> print(grid)
    4 x 2 cells on 8 µm x 6 µm
    >>> [f"{1e6 * x:g}" for x in grid.x.ravel()]
    ['-3', '-1', '1', '3']
    >>> rc.Grid((64, 64), 1e-3).size
    (0.001, 0.001)
    """

    shape: tuple[int, int] = attrs.field(converter=grid_shape)
    size: Pair = attrs.field(converter=_size, metadata={"unit": "m"})

    @cached_property
    def spacing(self) -> Pair:
        """Sides of a cell (dx, dy), m."""
        return self.size[0] / self.shape[0], self.size[1] / self.shape[1]

    @property
    def cells(self) -> int:
        """Number of cells."""
        return self.shape[0] * self.shape[1]

    @cached_property
    def cell_area(self) -> float:
        """Area of a cell, m2."""
        return self.spacing[0] * self.spacing[1]

    @property
    def area(self) -> float:
        """Nominal area of the domain, m2."""
        return self.size[0] * self.size[1]

    @property
    def resolved(self) -> Grid:
        """The grid itself, with square cells where an axis has a single one, along which nothing varies, as of lines.

        Its sides are the lengths that the cells resolve.
        """
        if 1 not in self.shape:
            return self
        side = self.spacing[self.shape.index(1) - 1]
        return Grid(self.shape, (self.shape[0] * side, self.shape[1] * side))

    @property
    def x(self) -> Array:
        """Cell centres along x, shape (nx, 1), m; the origin is the centre of the domain."""
        return _centres(self.shape[0], self.size[0])[:, np.newaxis]

    @property
    def y(self) -> Array:
        """Cell centres along y, shape (1, ny), m; the origin is the centre of the domain."""
        return _centres(self.shape[1], self.size[1])[np.newaxis, :]

    def matches(self, other: Grid) -> bool:
        """Return whether both grids have the same cells, to a billionth of their size (rounding)."""
        if not isinstance(other, Grid):
            raise InputError.about("The grid", other, "a Grid(shape, size)")
        return self.shape == other.shape and bool(np.allclose(self.size, other.size, rtol=1e-9, atol=0.0))

    def __str__(self) -> str:
        return f"{self.shape[0]} x {self.shape[1]} cells on {si(self.size[0], 'm')} x {si(self.size[1], 'm')}"


def _centres(count: int, size: float) -> Array:
    # Three arrays while they are computed.
    require_memory(24.0 * count, f"A row of {count} cells", "choose fewer cells")
    # Twice the offset is an integer, so that mirror images are exact.
    return np.asarray((2 * np.arange(count) + 1 - count) * (0.5 * size / count), dtype=np.float64)


def extend(field: npt.NDArray[Any], width: int, boundary: Boundary) -> npt.NDArray[Any]:
    """Return a field with `width` cells more on each side: periodic images, or the outermost cells repeated."""
    return pad_axes(field, ((width, width), (width, width)), boundary.free_axes)


def pad_axes(
    field: npt.NDArray[Any], widths: tuple[tuple[int, int], tuple[int, int]], free: tuple[bool, bool]
) -> npt.NDArray[Any]:
    """Return a field with so many cells more before and behind it along x and y; see `extend`."""
    (x0, x1), (y0, y1) = widths
    nx, ny = field.shape
    if max(x0, x1) > nx or max(y0, y1) > ny:
        rows, columns = (
            np.clip(at, 0, n - 1) if ends else at % n
            for at, n, ends in zip((np.arange(-x0, nx + x1), np.arange(-y0, ny + y1)), (nx, ny), free, strict=True)
        )
        return np.asarray(field[rows[:, np.newaxis], columns])
    # Faster than `numpy.pad`, by a factor of ten on small fields.
    padded = np.empty((x0 + nx + x1, y0 + ny + y1), field.dtype)
    inside = padded[x0 : x0 + nx]
    inside[:, y0 : y0 + ny] = field
    inside[:, :y0] = field[:, :1] if free[1] else field[:, ny - y0 :]
    inside[:, y0 + ny :] = field[:, -1:] if free[1] else field[:, :y1]
    padded[:x0] = inside[:1] if free[0] else inside[nx - x0 :]
    padded[x0 + nx :] = inside[-1:] if free[0] else inside[:x1]
    return padded


def list_borders(field: npt.NDArray[Any], boundary: Boundary) -> list[npt.NDArray[Any]]:
    """Return the values along the free borders: at the lower and the upper end of x, then of y."""
    lines = []
    for axis, free in enumerate(boundary.free_axes):
        if free:
            along = np.moveaxis(field, axis, 0)
            lines += [along[0], along[-1]]
    return lines


def grow(mask: Mask, width: int, boundary: Boundary) -> Mask:
    """Return a mask grown by `width` cells along rows, columns and diagonals."""
    nx, ny = mask.shape
    extended = extend(mask, width, boundary)
    along_x = extended[:nx].copy()
    for step in range(1, 2 * width + 1):
        along_x |= extended[step : step + nx]
    grown = along_x[:, :ny].copy()
    for step in range(1, 2 * width + 1):
        grown |= along_x[:, step : step + ny]
    return grown


@attrs.frozen
class Load:
    """One load, as ``problem.solve(**load.arguments)`` takes it.

    Attributes
    ----------
    kind
        ``"pressure"``, the nominal mean pressure; ``"force"``, the normal force; or ``"approach"``, the
        approach since first touch.
    value
        Its value, Pa, N or m: above zero, but where the surfaces attract each other.
    """

    kind: str
    value: float

    @property
    def unit(self) -> str:
        """SI unit of the value."""
        return _LOAD_KINDS[self.kind][1]

    def after(self, datum: float) -> Load:
        """Return the load of a contact whose first touch is at an approach of `datum`, m, from there."""
        return Load("approach", self.value - datum) if self.kind == "approach" else self

    def toward(self, end: Load, part: float) -> Load:
        """Return the load after a part, at most one, of the way from here to another load of the same kind."""
        return end if part == 1.0 else attrs.evolve(end, value=self.value + part * (end.value - self.value))

    @classmethod
    def of(cls, **given: object) -> Load:
        """Return the one load that is given by `pressure`, Pa, `force`, N, or `approach`, m; the others are None.

        Raises
        ------
        InputError
            If not exactly one is given, or it is not a number above zero.
        """
        return cls._of_one(given, 0.0)

    @classmethod
    def signed(cls, **given: object) -> Load:
        """Return the one load that is given, as `of` does, of any sign: for surfaces that attract each other."""
        return cls._of_one(given, None)

    @classmethod
    def _of_one(cls, given: dict[str, object], above: float | None) -> Load:
        kind, value = _the_one(given, f"Give exactly one of {_LOAD_ARGUMENTS}")
        name, unit = _LOAD_KINDS[kind]
        return cls(kind, number(value, name, unit, above=above))

    @classmethod
    def sequence(cls, **given: object) -> tuple[Load, ...]:
        """Return the loads of the one list that is given; see `Load.of`.

        Raises
        ------
        InputError
            If not exactly one list is given, it is empty, or a load in it is not a number above zero.
        """
        return cls._of_list(given, 0.0)

    @classmethod
    def signed_sequence(cls, **given: object) -> tuple[Load, ...]:
        """Return the loads of the one list that is given, as `sequence` does, of any sign; see `signed`."""
        return cls._of_list(given, None)

    @classmethod
    def unsigned_sequence(cls, **given: object) -> tuple[Load, ...]:
        """Return the loads of the one list that is given, as `sequence` does; they may be zero."""
        loads = cls._of_list(given, None)
        for load in loads:
            number(load.value, f"A load of {load.kind}=[...]", load.unit, at_least=0.0)
        return loads

    @classmethod
    def resting_sequence(cls, **given: object) -> tuple[Load, ...]:
        """Return the loads of the one list that is given, as `unsigned_sequence` does; the first is not zero."""
        loads = cls.unsigned_sequence(**given)
        number(loads[0].value, f"The first load of {loads[0].kind}=[...]", loads[0].unit, above=0.0)
        return loads

    @classmethod
    def unloading_sequence(cls, **given: object) -> tuple[Load, ...]:
        """Return the loads of the one list that is given, as `sequence` does; the last of several may be zero."""
        loads = cls._of_list(given, None)
        name = f"A load of {loads[0].kind}=[...]"
        last = len(loads) - 1
        for place, load in enumerate(loads):
            if load.value == 0.0 and 0 < place < last:
                raise InputError(
                    f"{name} is zero before the last one: the bodies come apart there. Follow another path from there."
                )
            if load.value != 0.0 or place < last or last == 0:
                number(load.value, name, load.unit, above=0.0)
        return loads

    @classmethod
    def _of_list(cls, given: dict[str, object], above: float | None) -> tuple[Load, ...]:
        kind, values = _the_one(given, f"Give exactly one list of loads: {_LOAD_ARGUMENTS}")
        items = list_of(values, "The loads", f"a list, {kind}=[...]", "For one load call solve().")
        unit = _LOAD_KINDS[kind][1]
        loads = tuple(cls(kind, number(value, f"A load of {kind}=[...]", unit, above=above)) for value in items)
        if not loads:
            raise InputError(f"The list of loads, {kind}=, is empty: give at least one load.")
        return loads

    @property
    def arguments(self) -> dict[str, Any]:
        """The load as the keyword argument of `ContactProblem.solve`."""
        return {self.kind: self.value}

    def __str__(self) -> str:
        return f"{self.kind} {si(self.value, self.unit)}"


def _the_one(given: dict[str, object], request: str) -> tuple[str, object]:
    named = {kind: value for kind, value in given.items() if value is not None}
    if len(named) != 1:
        raise InputError(f"{request}, but got {' and '.join(argument(kind) for kind in named) or 'none of them'}.")
    return next(iter(named.items()))
