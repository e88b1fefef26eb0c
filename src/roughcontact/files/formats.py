"""The readers that ship: numpy's files and plain text (heights in metres, indexed [x, y]), and instruments' files."""

from __future__ import annotations

import warnings
from pathlib import Path

import attrs
import numpy as np

from roughcontact._surfaces.topography import read_topography
from roughcontact.archive import read_npy, read_npz
from roughcontact.checks.memory import require_memory
from roughcontact.errors import InputError, MissingPackage
from roughcontact.files.base import RawMap, SurfaceReader
from roughcontact.files.text import read_table

# Numbers in a row of a list of points: x z, or x y z; and rows from which on such a table is a list: 3 x 3 points.
_COLUMNS_OF_LISTS, _ROWS_OF_LISTS = (2, 3), 9


@attrs.frozen
class NpzReader(SurfaceReader):
    """``numpy.savez(path, heights=..., size=(lx, ly), periodic=...)``; size and periodic are optional."""

    @property
    def suffixes(self) -> frozenset[str]:
        """Npz."""
        return frozenset({".npz"})

    def read(self, path: Path) -> RawMap:
        """Return the map."""
        _require_memory(path, 2.0)
        with path.open("rb") as file:
            data = read_npz(file, {"heights", "size", "periodic"}, deflated=True)
        if "heights" not in data:
            raise InputError("it holds no array named 'heights'")
        size, periodic = data.get("size"), data.get("periodic", np.array(False))
        if size is not None and (size.dtype.kind not in "iuf" or size.shape not in ((), (1,), (2,))):
            raise InputError(
                f"its array 'size' must hold one length or two, m, but has {size.dtype} of shape {size.shape}"
            )
        if size is not None and size.size == 1 and len(set(data["heights"].shape)) > 1:
            raise InputError(
                f"its array 'size' must hold both sides, m, of a map of shape {data['heights'].shape}, but holds one"
            )
        if periodic.size != 1 or periodic.dtype.kind not in "biu":
            raise InputError(
                f"its 'periodic' must be True or False, but has {periodic.dtype} of shape {periodic.shape}"
            )
        lx, ly = np.broadcast_to(np.nan if size is None else size, 2).tolist()
        return RawMap(data["heights"], None if size is None else (lx, ly), bool(periodic), metric=True)


@attrs.frozen
class NpyReader(SurfaceReader):
    """``numpy.save(path, heights)``."""

    @property
    def suffixes(self) -> frozenset[str]:
        """Npy."""
        return frozenset({".npy"})

    def read(self, path: Path) -> RawMap:
        """Return the map."""
        _require_memory(path, 2.0)
        with path.open("rb") as file:
            return RawMap(read_npy(file, path.stat().st_size))


@attrs.frozen
class TextReader(SurfaceReader):
    """A table of numbers, one row for each x, separated by blanks or by one of ``, ;`` and tab; ``#`` comments.

    An empty field is a non-measured point. A separator at the end of every row is ignored.
    """

    @property
    def suffixes(self) -> frozenset[str]:
        """Txt, csv, dat and asc."""
        return frozenset({".txt", ".csv", ".dat", ".asc"})

    def read(self, path: Path) -> RawMap:
        """Return the map."""
        # A number takes 25 characters at most, as numpy.savetxt writes it.
        _require_memory(path, 16.0 / 25.0)
        heights = read_table(path)
        if heights.shape[0] >= _ROWS_OF_LISTS and heights.shape[1] in _COLUMNS_OF_LISTS:
            raise InputError(
                f"each of its {heights.shape[0]} rows holds {heights.shape[1]} numbers, as in a list of points x y z, "
                "but a height map has a row for each x and a number for each y: sort the points into an array "
                "heights[i, j], with i and j from numpy.unique(x, return_inverse=True) and the same of y, and write it "
                "with numpy.savez(path, heights=heights, size=(lx, ly))"
            )
        return RawMap(heights)


def _require_memory(path: Path, multiple: float) -> None:
    """Refuse a file whose map, held twice while it is checked, takes more memory than there is."""
    require_memory(multiple * path.stat().st_size, "it", "cut it, or write it with fewer points")


@attrs.frozen
class InstrumentReader(SurfaceReader):
    """Some forty instruments' formats (Sensofar, Zygo, Wyko, X3P, SUR, ...), read by the package SurfaceTopography.

    It is tried on every ending that no other reader claims. SurfaceTopography is not among the extras, because a
    package it needs (igor2) is under the LGPL.
    """

    @property
    def suffixes(self) -> frozenset[str]:
        """None."""
        return frozenset()

    def read(self, path: Path) -> RawMap:
        """Return the map; raise `MissingPackage` if SurfaceTopography is not installed."""
        try:
            # Its imports warn of optional parallel packages.
            with warnings.catch_warnings(action="ignore"):
                from SurfaceTopography import read_topography as read_file
        except ImportError:
            raise MissingPackage(
                f"Reading {path.name} needs the package SurfaceTopography: pip install SurfaceTopography. "
                "(Files .npz, .npy, .txt, .csv, .dat and .asc are read without it.)"
            ) from None
        heights, size, periodic = read_topography(read_file(str(path)))
        return RawMap(heights, size, periodic, metric=True)
