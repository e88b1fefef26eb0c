"""Files of measuring instruments, read by the package SurfaceTopography."""

from __future__ import annotations

import warnings
from pathlib import Path

import attrs
import numpy as np

from roughcontact.errors import InputError, MissingPackage
from roughcontact.files.base import RawMap, SurfaceReader


@attrs.frozen
class InstrumentReader(SurfaceReader):
    """Some forty formats (Sensofar, Zygo, Wyko, X3P, SUR, ...); tried on every ending nobody else reads.

    SurfaceTopography is not among the extras, because a package it needs (igor2) is under the LGPL;
    whoever wants it installs it.
    """

    @property
    def suffixes(self) -> frozenset[str]:
        """None of its own: the fallback."""
        return frozenset()

    def read(self, path: Path) -> RawMap:
        """Return the map in SI units; see `SurfaceReader.read`.

        Raises
        ------
        MissingPackage
            If SurfaceTopography is not installed.
        """
        try:
            # Its imports warn of optional parallel packages that play no part here.
            with warnings.catch_warnings(action="ignore"):
                from SurfaceTopography import read_topography
        except ImportError:
            raise MissingPackage(
                f"Reading {path.name} needs the package SurfaceTopography: pip install SurfaceTopography. "
                "(Files .npz, .npy, .txt, .csv, .dat and .asc are read without it.)"
            ) from None
        topography = read_topography(str(path))
        if topography.dim != 2:
            raise InputError("it holds a line profile, not a height map")
        if topography.unit is None:
            raise InputError("it does not state its unit of length")
        topography = topography.to_unit("m")
        heights = np.ma.filled(np.ma.asarray(topography.heights(), dtype=np.float64), np.nan)
        lx, ly = (float(side) for side in topography.physical_sizes)
        return RawMap(heights, (lx, ly), bool(topography.is_periodic), metric=True)
