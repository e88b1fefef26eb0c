"""The reader interface."""

from __future__ import annotations

import abc
from pathlib import Path

import attrs
import numpy as np

from roughcontact._base.checks import Array, Pair, choice
from roughcontact._base.registry import Registry
from roughcontact._base.units import outlined


@attrs.frozen(eq=False)
class RawMap:
    """A height map as it stands in a file.

    Attributes
    ----------
    heights
        Heights, shape (nx, ny), indexed [x, y], m; NaN at non-measured points.
    size
        Sides of the domain (x, y), m; None if the file does not state it.
    periodic
        Whether the map repeats beyond its border.
    metric
        Whether the heights are known to be in metres.
    hint
        What the file says of its size, in words, where it does not state it; part of the sentence that asks for it.
    needs_unit
        Whether the heights are in an unknown unit, which must be given, as in images.
    needs_rows
        Whether the file does not say whether its rows are those of x or those of y; they were taken for those of x.
    """

    heights: Array = attrs.field(repr=outlined)
    size: Pair | None = None
    periodic: bool = False
    metric: bool = False
    hint: str = ""
    needs_unit: bool = False
    needs_rows: bool = False


def check_rows(value: str) -> str:
    """Return which axis the rows of a file are those of, ``"x"``, ``"y"`` or ``"auto"``, or raise `InputError`."""
    return choice(value, "The axis of the rows in a file", ("auto", "x", "y"))


def put_x_first(heights: Array, rows: str) -> Array:
    """Return heights as they stand in a file, with rows of x or of y, indexed [x, y]."""
    return np.ascontiguousarray(heights.T) if rows == "y" else heights


class SurfaceReader(abc.ABC):
    """A reader of one kind of file. Subclass it and register it in ``roughcontact.readers``.

    Its fields, if it has any, are options that `read_surface` accepts by their names; each has a default.

    Examples
    --------
    >>> import numpy as np
    >>> import roughcontact as rc
    >>> class Raw16(rc.SurfaceReader):
    ...     suffixes = frozenset({".raw16"})
    ...
    ...     def read(self, path):
    ...         heights = np.fromfile(path, dtype="<i2").reshape(512, 512) * 1e-9
    ...         return rc.typing.RawMap(heights, size=(1e-3, 1e-3), metric=True)
    >>> isinstance(Raw16(), rc.SurfaceReader)
    True
    """

    @property
    @abc.abstractmethod
    def suffixes(self) -> frozenset[str]:
        """The endings of the file names that it reads, lower case, with the dot."""

    @abc.abstractmethod
    def read(self, path: Path) -> RawMap:
        """Return the map in SI units; any error is reported by `read_surface` with the name of the file."""


readers = Registry(SurfaceReader, "surface reader", "roughcontact.readers")
