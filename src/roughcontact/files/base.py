"""The reader interface."""

from __future__ import annotations

import abc
from pathlib import Path

import attrs

from roughcontact.checks import Array, Pair


@attrs.frozen(eq=False)
class RawMap:
    """A height map as it stands in a file.

    Attributes
    ----------
    heights
        Heights, shape (nx, ny), indexed [x, y], m; NaN where a point is missing.
    size
        Sides of the domain (x, y), m; None if the file does not tell.
    periodic
        Whether the map repeats.
    metric
        Whether the file itself tells that its heights are in metres, or the reader converted them.
    """

    heights: Array
    size: Pair | None = None
    periodic: bool = False
    metric: bool = False


class SurfaceReader(abc.ABC):
    """A reader of one kind of file. Subclass it and register it in ``roughcontact.readers``."""

    @property
    @abc.abstractmethod
    def suffixes(self) -> frozenset[str]:
        """The file name endings it reads, lower case, with the dot."""

    @abc.abstractmethod
    def read(self, path: Path) -> RawMap:
        """Return the map in SI units.

        Raises
        ------
        Exception
            Any error; `read_surface` tells the user which file it was.
        """
