"""Height maps in numpy's own files and in plain text; heights in metres, indexed [x, y]."""

from __future__ import annotations

import math
from pathlib import Path

import attrs
import numpy as np

from roughcontact.errors import InputError
from roughcontact.files.base import RawMap, SurfaceReader


@attrs.frozen
class NpzReader(SurfaceReader):
    """``numpy.savez(path, heights=..., size=(lx, ly), periodic=...)``; size and periodic may be left out."""

    @property
    def suffixes(self) -> frozenset[str]:
        """Npz."""
        return frozenset({".npz"})

    def read(self, path: Path) -> RawMap:
        """Return the map; see `SurfaceReader.read`."""
        with np.load(path, allow_pickle=False) as data:
            if "heights" not in data:
                raise InputError(f"it holds {sorted(data)}, but no array named 'heights'")
            size = None
            if "size" in data:
                lx, ly = (float(side) for side in np.broadcast_to(data["size"], 2))
                size = lx, ly
            periodic = bool(data["periodic"]) if "periodic" in data else False
            return RawMap(data["heights"], size, periodic, metric=True)


@attrs.frozen
class NpyReader(SurfaceReader):
    """``numpy.save(path, heights)``."""

    @property
    def suffixes(self) -> frozenset[str]:
        """Npy."""
        return frozenset({".npy"})

    def read(self, path: Path) -> RawMap:
        """Return the map; see `SurfaceReader.read`."""
        return RawMap(np.load(path, allow_pickle=False))


@attrs.frozen
class TextReader(SurfaceReader):
    """A table of numbers, one row for each x, separated by blanks or by one of ``, ;`` and tab; ``#`` comments."""

    @property
    def suffixes(self) -> frozenset[str]:
        """Txt, csv, dat and asc."""
        return frozenset({".txt", ".csv", ".dat", ".asc"})

    def read(self, path: Path) -> RawMap:
        """Return the map; see `SurfaceReader.read`."""
        lines = [line.partition("#")[0].strip() for line in path.read_text(encoding="utf-8").splitlines()]
        lines = [line for line in lines if line]
        if not lines:
            raise InputError("it holds no numbers")
        separators = [mark for mark in ",;\t" if any(mark in line for line in lines)]
        if len(separators) > 1:
            raise InputError(
                f"it uses {' and '.join(map(repr, separators))}; only one may separate, and points are decimal"
            )
        separator = separators[0] if separators else None
        # An empty field is a missing point.
        rows = [[float(field) if field.strip() else math.nan for field in line.split(separator)] for line in lines]
        return RawMap(np.array(rows, dtype=np.float64))
