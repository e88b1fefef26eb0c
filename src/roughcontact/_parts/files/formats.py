"""Readers of numpy's files (heights in metres, indexed [x, y]), and of instruments' files."""

from __future__ import annotations

import warnings
from pathlib import Path

import attrs
import numpy as np

from roughcontact._base.archive import read_npy, read_npz
from roughcontact._parts.files.base import (
    RawMap,
    SurfaceReader,
    check_rows,
    find_foreign,
    require_memory_of_map,
)
from roughcontact._parts.files.hdf5 import is_hdf5, require_bounded_hdf5
from roughcontact._parts.files.stated import Stated, build_map, check_no_data
from roughcontact._parts.files.x3p import require_bounded_archive
from roughcontact._parts.surfaces import read_topography
from roughcontact.errors import InputError, MissingPackage

# Endings of files that need no instrument's reader.
_ENDINGS = ".npz, .npy, .txt, .csv, .tsv, .dat, .asc, .xyz, .prn, .mat"


@attrs.frozen
class NpzReader(SurfaceReader):
    """``numpy.savez(path, heights=..., size=(lx, ly), periodic=...)``; size and periodic are optional."""

    @property
    def suffixes(self) -> frozenset[str]:
        """Npz."""
        return frozenset({".npz"})

    def read(self, path: Path) -> RawMap:
        """Return the map."""
        require_memory_of_map(2.0 * path.stat().st_size)
        with path.open("rb") as file:
            data = read_npz(file, {"heights", "size", "periodic"}, deflated=True)
        if "heights" not in data:
            raise InputError("it holds no array named 'heights'")
        size = data.get("size")
        periodic = data.get("periodic", np.array(False))
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
    """``numpy.save(path, heights)``.

    Parameters
    ----------
    rows
        ``"x"`` or ``"y"``: the axis of the first index, the smallest first; by default x.
    no_data
        The number that stands for a non-measured point, or ``"none"``; one that looks so is asked about.
    """

    rows: str = attrs.field(default="auto", converter=check_rows)
    no_data: float | str | None = attrs.field(default=None, converter=check_no_data)

    @property
    def suffixes(self) -> frozenset[str]:
        """Npy."""
        return frozenset({".npy"})

    def read(self, path: Path) -> RawMap:
        """Return the map."""
        require_memory_of_map(2.0 * path.stat().st_size)
        with path.open("rb") as file:
            heights = read_npy(file, path.stat().st_size)
        if heights.dtype.kind not in "biuf" or heights.ndim != 2:
            return RawMap(heights)
        return build_map(heights, Stated(), rows=self.rows, line="the first index", no_data=self.no_data)


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
        # SurfaceTopography searches all of a file of an unknown format, for minutes if it is large.
        if foreign := find_foreign(path):
            raise InputError(foreign)
        require_bounded_archive(path)
        if is_hdf5(path):
            require_bounded_hdf5(path)
        try:
            # Its imports warn of optional parallel packages.
            with warnings.catch_warnings(action="ignore"):
                from SurfaceTopography import read_topography as read_file
                from SurfaceTopography.Exceptions import CannotDetectFileFormat
        except ImportError:
            raise MissingPackage(
                f"Reading {path.name} needs the package SurfaceTopography: pip install SurfaceTopography. "
                f"Files {_ENDINGS} are read without it, .tif by 'roughcontact[files]' and .h5 by 'roughcontact[store]'."
            ) from None
        try:
            topography = read_file(str(path))
        except CannotDetectFileFormat:
            raise InputError(
                f"its content fits none of the formats that are read, which are those of {_ENDINGS}, .h5, .tif and of "
                "instruments (.al3d, .opd, .plu, .sur, .x3p, ...): it is of another kind, or damaged"
            ) from None
        except ValueError as error:
            if "physical_sizes" not in str(error):
                raise
            raise InputError(
                "it does not state the sides of its domain: export it in a format that does, such as .x3p, or its "
                "heights as text"
            ) from None
        heights, size, periodic = read_topography(topography)
        return RawMap(heights, size, periodic, metric=True)
