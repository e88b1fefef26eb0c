"""Height maps in numpy's own files and in plain text; heights in metres, indexed [x, y]."""

from __future__ import annotations

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
            return RawMap(data["heights"], size, periodic)


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
    """A table of numbers, one row of the file for each x; ``#`` starts a comment, commas may separate."""

    @property
    def suffixes(self) -> frozenset[str]:
        """Txt, csv, dat and asc."""
        return frozenset({".txt", ".csv", ".dat", ".asc"})

    def read(self, path: Path) -> RawMap:
        """Return the map; see `SurfaceReader.read`."""
        text = path.read_text(encoding="utf-8").replace(",", " ").replace(";", " ")
        lines = [line for line in text.splitlines() if line.partition("#")[0].strip()]
        if not lines:
            raise InputError("it holds no numbers")
        return RawMap(np.loadtxt(lines, ndmin=2))
