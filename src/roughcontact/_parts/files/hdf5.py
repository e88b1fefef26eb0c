"""Arrays of HDF5 files, as h5py, MATLAB 7.3 and many codes write them, and of netCDF, whose version 4 is HDF5."""

from __future__ import annotations

import io
import math
import warnings
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from roughcontact._base.arrays import RealArray
from roughcontact._parts.files.base import RawMap, require_memory_of_map
from roughcontact._parts.files.bounds import HDF5_SIGNATURE, begins_with, list_members, require_room, require_sound_hdf5
from roughcontact._parts.files.named import (
    CHANGING_NAMES,
    DESCRIBING_ATTRIBUTES,
    NUMBER_ATTRIBUTES,
    STATING_ATTRIBUTES,
    STEPS_OF_HEIGHTS,
    UNIT_ATTRIBUTES,
    NamedArray,
    NamedArrayReader,
    choose_map,
    find_stating,
    is_changing,
    read_numbers,
)
from roughcontact.errors import InputError, requiring

# Filters whose arrays are read: deflate, shuffle and Fletcher's checksum.
_FILTERS = {1, 2, 3}
# Members of a file, with those of its groups, that are looked at.
_MAX_MEMBERS = 1000
# What netCDF writes for the name of an axis without places.
_NO_PLACES = "This is a netCDF dimension but not"
# Bytes of a text that may name a unit.
MAX_TEXT_BYTES = 64
# Names by which SurfaceTopography marks points that were not measured, and an axis along which the map repeats.
_MASK = "mask"
_PERIODIC = "periodic"


def read_hdf5(path: Path) -> tuple[dict[str, NamedArray], dict[str, str]]:
    """Return the arrays of real numbers with at most two dimensions in an HDF5 file, and its short texts, by name.

    `InputError` if they are larger than the file can hold; `MissingPackage` without h5py.
    """
    with requiring(
        "Files of HDF5, such as .h5 and .mat of version 7.3, need the package h5py: "
        "pip install 'roughcontact[store]', or write the heights with numpy.save, in MATLAB with "
        "save(file, 'heights', '-v7')."
    ):
        import h5py
    arrays: dict[str, NamedArray] = {}
    texts: dict[str, str] = {}
    require_sound_hdf5(path)
    with path.open("rb") as stream, h5py.File(stream, "r") as file:
        members = list_members(file, _MAX_MEMBERS)
        groups = {f"{name}/": item for name, item in members.items() if isinstance(item, h5py.Group)}
        for path_of_group, group in ({"": file} | groups).items():
            for name, value in _read_statements(group, h5py).items():
                if isinstance(value, str):
                    texts[f"{path_of_group}{name}"] = value
                else:
                    arrays[f"{path_of_group}{name}"] = NamedArray(value)
        items = {
            name: item
            for name, item in members.items()
            if isinstance(item, h5py.Dataset) and (_is_plain(item, h5py) or _is_short_text(item, h5py))
        }
        require_room(sum(math.prod(item.shape) * item.dtype.itemsize for item in items.values()), path.stat().st_size)
        for name, item in items.items():
            if "MATLAB_class" in item.attrs and _read_text(_read_plain(item, "MATLAB_class", h5py)) == "char":
                texts[name] = _read_letters(item[()])
            elif item.id.get_type().get_class() == h5py.h5t.STRING:
                texts[name] = _read_text(item[()])
            else:
                one = NamedArray(np.asarray(item[()]), _read_attributes(item, h5py), _name_axes(item, h5py))
                arrays[name] = one.squeezed()
    return arrays, texts


def _read_attributes(item: Any, h5py: Any) -> dict[str, Any]:
    """Return what the attributes of an array state of its numbers."""
    found: dict[str, Any] = {}
    for name in item.attrs:
        if name in UNIT_ATTRIBUTES:
            found[name] = _read_text(_read_plain(item, name, h5py))
        elif name in NUMBER_ATTRIBUTES:
            found[name] = read_numbers(name, _read_plain(item, name, h5py))
        elif name in STATING_ATTRIBUTES or is_changing(name) or name.lower() in STEPS_OF_HEIGHTS:
            found[name] = _read_value(item, name, h5py)
        elif name in DESCRIBING_ATTRIBUTES and _is_short(item, name, h5py):
            found[name] = _read_text(item.attrs[name])
    return {name: value for name, value in found.items() if not isinstance(value, str) or value}


def _is_short(item: Any, name: str, h5py: Any) -> bool:
    """Return whether an attribute is a short text."""
    attribute = h5py.h5a.open(item.id, name.encode())
    return bool(attribute.get_type().get_class() == h5py.h5t.STRING and attribute.get_storage_size() <= MAX_TEXT_BYTES)


def _read_statements(group: Any, h5py: Any) -> dict[str, Any]:
    """Return the attributes of a group that state sides or units, or change what numbers mean: texts and arrays."""
    found: dict[str, Any] = {}
    for name in group.attrs:
        stating = find_stating(name) or (name if name.lower() in CHANGING_NAMES else "")
        if stating:
            found[stating] = _read_value(group, name, h5py)
        elif name in DESCRIBING_ATTRIBUTES and _is_short(group, name, h5py):
            found[name] = _read_text(group.attrs[name])
    return {name: value for name, value in found.items() if not isinstance(value, str) or value}


def _read_plain(item: Any, name: str, h5py: Any) -> Any:
    """Return a short attribute of numbers or texts; `InputError` if it is of another type, which is not read."""
    attribute = h5py.h5a.open(item.id, name.encode())
    kind = attribute.get_type()
    plain = (h5py.h5t.INTEGER, h5py.h5t.FLOAT, h5py.h5t.STRING)
    if kind.get_class() not in plain or attribute.get_storage_size() > MAX_TEXT_BYTES:
        raise InputError(f"its attribute {name[:20]!a} is neither a number nor a short text")
    return item.attrs[name]


def _read_value(item: Any, name: str, h5py: Any) -> RealArray | str:
    value = np.asarray(_read_plain(item, name, h5py))
    return value if value.dtype.kind in "iuf" else _read_text(value)


def _read_text(value: Any) -> str:
    one = np.asarray(value).ravel()[:1].tolist()
    text = one[0] if one else ""
    return (text.decode("utf-8", "replace") if isinstance(text, bytes) else str(text)).strip("\0 ")


def _read_letters(codes: Any) -> str:
    """Return the text that MATLAB keeps as the numbers of its letters."""
    return "".join(chr(int(code)) for code in np.ravel(codes)[:MAX_TEXT_BYTES])


def _name_axes(item: Any, h5py: Any) -> tuple[str, ...]:
    """Return the names of the axes of an array, as its labels or the scales of netCDF state them."""
    if "DIMENSION_LABELS" in item.attrs:
        kind = h5py.h5a.open(item.id, b"DIMENSION_LABELS").get_type()
        if kind.get_class() == h5py.h5t.STRING:
            return tuple(_read_text(label) for label in np.ravel(item.attrs["DIMENSION_LABELS"]))
    if "DIMENSION_LIST" not in item.attrs:
        return ()
    return tuple(str(axis[0].name).rpartition("/")[2] if len(axis) else "" for axis in item.dims)


def _is_plain(item: Any, h5py: Any) -> bool:
    """Return whether an item is an array of numbers inside the file; other items are not read."""
    if "NAME" in item.attrs and _is_short(item, "NAME", h5py) and _read_text(item.attrs["NAME"]).startswith(_NO_PLACES):
        return False
    if not item.size or len(item.shape) > 2 + item.shape.count(1):
        return False
    if item.id.get_type().get_class() not in (h5py.h5t.INTEGER, h5py.h5t.FLOAT) or item.dtype.kind not in "iuf":
        return False
    return _is_inside(item, h5py)


def _is_short_text(item: Any, h5py: Any) -> bool:
    """Return whether an item is one short text inside the file, such as the name of a unit."""
    kind = item.id.get_type()
    if item.size != 1 or kind.get_class() != h5py.h5t.STRING:
        return False
    return (kind.is_variable_str() or kind.get_size() <= MAX_TEXT_BYTES) and _is_inside(item, h5py)


def _is_inside(item: Any, h5py: Any) -> bool:
    """Return whether the numbers of an item stand in the file itself, under filters that are known."""
    stored = item.id.get_create_plist()
    filters = {stored.get_filter(number)[0] for number in range(stored.get_nfilters())}
    is_inside = stored.get_layout() in (h5py.h5d.COMPACT, h5py.h5d.CONTIGUOUS, h5py.h5d.CHUNKED)
    return is_inside and not stored.get_external_count() and filters <= _FILTERS


@attrs.frozen
class Hdf5Reader(NamedArrayReader):
    """An array of numbers in an HDF5 file, first index x, as ``h5py.File(path, "w")["heights"] = heights`` writes it.

    The sides of the map are read as from .mat files. It needs h5py.

    Parameters
    ----------
    variable
        Name of the array, with its groups, as in ``"surface/z"``; by default `heights`, or the only one with two
        dimensions.
    rows
        ``"x"`` or ``"y"``: the axis of the first index, the smallest first; by default x.
    no_data
        The number that stands for a non-measured point, or ``"none"``; one that looks so is asked about.
    """

    suffixes = frozenset({".h5", ".hdf5"})

    def read(self, path: Path) -> RawMap:
        """Return the map."""
        require_memory_of_map(2.0 * path.stat().st_size)
        arrays, texts = read_hdf5(path)
        return choose_map(arrays, texts, self)


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
                found[name] = attrs.evolve(array, attributes=_read_classic_attributes(vars(one)))
        axes = [file.variables[axis] for axis in "xy" if axis in file.variables]
        periodic = len(axes) == 2 and all(int(getattr(axis, _PERIODIC, 0)) for axis in axes)
    mask = found.pop(_MASK, None)
    for name, array in found.items():
        if mask is not None and array.values.shape == mask.values.shape:
            marked = np.array(array.values, dtype=np.float64)
            marked[mask.values != 0] = np.nan
            found[name] = attrs.evolve(array, values=marked)
    return found, periodic


def _read_classic_attributes(stored: dict[str, Any]) -> dict[str, Any]:
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
