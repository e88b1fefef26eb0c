"""Arrays of netCDF: version 4 is HDF5; the classic kind is read by scipy."""

from __future__ import annotations

import io
import math
import warnings
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from roughcontact._parts.files.base import RawMap, require_memory_of_map
from roughcontact._parts.files.bounds import HDF5_SIGNATURE, begins_with, require_room
from roughcontact._parts.files.hdf5 import read_hdf5
from roughcontact._parts.files.named import (
    DESCRIBING_ATTRIBUTES,
    NUMBER_ATTRIBUTES,
    STEPS_OF_HEIGHTS,
    UNIT_ATTRIBUTES,
    NamedArray,
    NamedArrayReader,
    choose_map,
    is_changing,
    read_numbers,
)
from roughcontact.errors import InputError

# Names by which SurfaceTopography marks points that were not measured, and an axis along which the map repeats.
_MASK = "mask"
_PERIODIC = "periodic"


@attrs.frozen
class NetcdfReader(NamedArrayReader):
    """An array of numbers in a netCDF file; the names and positions of its axes are read.

    Version 4 needs h5py.

    Parameters
    ----------
    variable
        Name of the array; by default `heights`, or the only one with two dimensions.
    rows
        ``"x"`` or ``"y"``: the axis of the first index, where the names of the axes do not say it; by default x.
    no_data
        The number that stands for a non-measured point, or ``"none"``; one that looks so is asked about.
    """

    suffixes = frozenset({".nc", ".nc4", ".cdf"})

    def read(self, path: Path) -> RawMap:
        """Return the map."""
        require_memory_of_map(4.0 * path.stat().st_size)
        if begins_with(path, HDF5_SIGNATURE):
            return choose_map(*read_hdf5(path), self)
        try:
            arrays, periodic = _read_classic(path)
        except InputError:
            raise
        except (ValueError, TypeError, KeyError, IndexError, AttributeError, AssertionError, OverflowError) as error:
            raise InputError("its head states more than it holds: it is damaged, or no classic netCDF") from error
        return attrs.evolve(choose_map(arrays, {}, self), periodic=periodic)


def _read_classic(path: Path) -> tuple[dict[str, NamedArray], bool]:
    """Return the arrays of a classic netCDF file by name, and whether both axes are stated to be periodic."""
    from scipy.io import netcdf_file

    found = {}
    # Of a file, scipy allocates what is declared; of bytes, what is there.
    stream = io.BytesIO(path.read_bytes())
    with warnings.catch_warnings(action="ignore"), netcdf_file(stream, "r", mmap=False) as file:
        needed = sum(math.prod(one.shape) * one.itemsize() for one in file.variables.values())
        require_room(needed, path.stat().st_size)
        for name, one in file.variables.items():
            array = NamedArray(np.array(one.data), axes=tuple(one.dimensions)).squeezed()
            if array.values.dtype.kind in "iuf" and array.values.ndim <= 2:
                found[name] = attrs.evolve(array, attributes=_read_attributes(vars(one)))
        axes = [file.variables[axis] for axis in "xy" if axis in file.variables]
        periodic = len(axes) == 2 and all(int(getattr(axis, _PERIODIC, 0)) for axis in axes)
    mask = found.pop(_MASK, None)
    for name, array in found.items():
        if mask is not None and array.values.shape == mask.values.shape:
            marked = np.array(array.values, dtype=np.float64)
            marked[mask.values != 0] = np.nan
            found[name] = attrs.evolve(array, values=marked)
    return found, periodic


def _read_attributes(stored: dict[str, Any]) -> dict[str, Any]:
    """Return what the attributes of an array state of its numbers."""
    found: dict[str, Any] = {}
    for name, value in stored.items():
        if isinstance(value, bytes) and (name in (*UNIT_ATTRIBUTES, *DESCRIBING_ATTRIBUTES) or is_changing(name)):
            found[name] = value.decode("utf-8", "replace").strip("\0 ")
        elif name in NUMBER_ATTRIBUTES:
            found[name] = read_numbers(name, value)
        elif is_changing(name) or name.lower() in STEPS_OF_HEIGHTS:
            found[name] = value
    return found
