"""Arrays of HDF5 files, as h5py, MATLAB 7.3 and many codes write them, and the map among the named arrays of a file."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

import attrs
import numpy as np

from roughcontact._base.arrays import Pair, RealArray
from roughcontact._parts.files.base import (
    RawMap,
    SurfaceReader,
    check_rows,
    name_rows,
    put_x_first,
    require_memory_of_map,
)
from roughcontact._parts.files.stated import metres
from roughcontact.errors import InputError, MissingPackage

# Bytes to which compressed arrays may expand, plus a multiple of the file: heights deflate by 1 to 2, zeros by 1000.
_EXPANSION_ALLOWANCE = 2**21
_MAX_EXPANSION_RATIO = 20
# Filters whose arrays are read: deflate, shuffle and Fletcher's checksum.
_FILTERS = {1, 2, 3}
_BEGINNING = b"\x89HDF\r\n\x1a\n"
# Members of a file, with those of its groups, that are looked at.
_MAX_MEMBERS = 1000
# Attributes of an array that state its unit, and the value of non-measured points.
_UNIT_ATTRIBUTES = ("units", "unit", "Unit", "Units")
_MISSING_ATTRIBUTES = ("_FillValue", "missing_value")
# Arrays that give the sides of a map, and the longest side of one, m.
_SIZE_NAMES = ("size", "lx", "ly", "dx", "dy")
_MAX_SIDE = 1.0


def bound_expansion(size: int) -> int:
    """Return the bytes to which the arrays of a file of so many bytes may expand."""
    return _EXPANSION_ALLOWANCE + _MAX_EXPANSION_RATIO * size


def read_hdf5(path: Path) -> tuple[dict[str, RealArray], dict[str, str]]:
    """Return the arrays of real numbers with at most two dimensions in an HDF5 file by name, with two dimensions.

    Scale, offset and value of non-measured points that an array states are applied; its unit is the second item, by
    name. `InputError` if they are larger than the file can hold; `MissingPackage` without h5py.
    """
    try:
        import h5py
    except ImportError:
        raise MissingPackage(
            "Files of HDF5, such as .h5 and .mat of version 7.3, need the package h5py: "
            "pip install 'roughcontact[store]', or write the heights with numpy.save, in MATLAB with "
            "save(file, 'heights', '-v7')."
        ) from None
    arrays: dict[str, RealArray] = {}
    units: dict[str, str] = {}
    size = path.stat().st_size
    left = bound_expansion(size)
    with path.open("rb") as stream, h5py.File(stream, "r") as file:
        for name, item in _find_arrays(file, h5py).items():
            left -= math.prod(item.shape) * item.dtype.itemsize
            if left < 0:
                raise InputError(f"its arrays are larger than a file of {size} bytes can hold")
            arrays[name] = _unpack(np.atleast_2d(np.asarray(item[()])), item.attrs)
            unit = next((_read_text(item.attrs[key]) for key in _UNIT_ATTRIBUTES if key in item.attrs), "")
            units |= {name: unit} if unit else {}
    return arrays, units


def _unpack(values: RealArray, stated: Any) -> RealArray:
    """Return the numbers that packed ones stand for, after the attributes of an array, as netCDF has them."""
    missing = [stated[key] for key in _MISSING_ATTRIBUTES if key in stated]
    scale = _read_number(stated.get("scale_factor", 1.0))
    offset = _read_number(stated.get("add_offset", 0.0))
    if not missing and (scale, offset) == (1.0, 0.0):
        return values
    found = values * scale + offset
    for one in missing:
        found[values == np.asarray(one).astype(values.dtype).ravel()[0]] = np.nan
    return np.asarray(found, dtype=np.float64)


def _read_number(value: Any) -> float:
    number = np.asarray(value).ravel()
    if number.size != 1 or number.dtype.kind not in "iuf" or not np.isfinite(number[0]):
        raise InputError(f"it states a scale or an offset of {value!r:.40}, which is not a number")
    return float(number[0])


def _read_text(value: Any) -> str:
    one = np.asarray(value).ravel()[:1].tolist()
    text = one[0] if one else ""
    return text.decode("utf-8", "replace") if isinstance(text, bytes) else str(text)


def is_hdf5(path: Path) -> bool:
    """Return whether a file begins as HDF5 does, whatever its ending."""
    with path.open("rb") as stream:
        return stream.read(len(_BEGINNING)) == _BEGINNING


def require_bounded_hdf5(path: Path) -> None:
    """Refuse an HDF5 file whose arrays, of any kind and dimension, are larger than it can hold.

    Foreign libraries make them before they look: a file of 10 kB may declare gigabytes that nobody has written.
    """
    try:
        import h5py
    except ImportError:
        return
    size = path.stat().st_size
    left = bound_expansion(size)

    def count(name: str, item: Any) -> None:
        nonlocal left
        if isinstance(item, h5py.Dataset):
            left -= math.prod(item.shape or ()) * item.dtype.itemsize

    with path.open("rb") as stream, h5py.File(stream, "r") as file:
        file.visititems(count)
    if left < 0:
        raise InputError(f"its arrays are larger than a file of {size} bytes can hold")


def _find_arrays(file: Any, h5py: Any) -> dict[str, Any]:
    """Return the arrays of numbers in a file and its groups that stand in the file itself, by their paths."""
    found = {}
    groups = [("", file)]
    # Links may form circles.
    seen = {h5py.h5o.get_info(file.id).addr}
    members = 0
    while groups:
        path, group = groups.pop()
        for name in group:
            members += 1
            if members > _MAX_MEMBERS:
                raise InputError(f"it has more than {_MAX_MEMBERS} members: write the heights alone")
            if not isinstance(group.get(name, getlink=True), h5py.HardLink):
                continue
            item = group[name]
            address = h5py.h5o.get_info(item.id).addr
            if address in seen:
                continue
            seen.add(address)
            if isinstance(item, h5py.Group):
                groups.append((f"{path}{name}/", item))
            elif isinstance(item, h5py.Dataset) and item.size and len(item.shape) <= 2 and _is_plain(item, h5py):
                found[f"{path}{name}"] = item
    return found


def _is_plain(item: Any, h5py: Any) -> bool:
    """Return whether an item is an array of numbers inside the file; other items are not read."""
    if item.id.get_type().get_class() not in (h5py.h5t.INTEGER, h5py.h5t.FLOAT) or item.dtype.kind not in "iuf":
        return False
    stored = item.id.get_create_plist()
    filters = {stored.get_filter(number)[0] for number in range(stored.get_nfilters())}
    is_inside = stored.get_layout() in (h5py.h5d.COMPACT, h5py.h5d.CONTIGUOUS, h5py.h5d.CHUNKED)
    return is_inside and not stored.get_external_count() and filters <= _FILTERS


def _find_size(arrays: dict[str, RealArray], shape: tuple[int, int]) -> tuple[Pair | None, str]:
    """Return the sides of a map, m, from `size`, `lx` and `ly`, or the pitch `dx` and `dy`; and these in words."""
    known = {name: arrays[name].ravel().astype(np.float64).tolist() for name in _SIZE_NAMES if name in arrays}
    known = {name: values for name, values in known.items() if len(values) <= 2}
    words = ", ".join(f"its {name} is {' x '.join(f'{value:g}' for value in values)}" for name, values in known.items())
    sides = known.get("size") or [*known.get("lx", []), *known.get("ly", [])]
    if not sides and "dx" in known:
        sides = [shape[0] * known["dx"][0], shape[1] * known.get("dy", known["dx"])[0]]
    if len(sides) == 1 and shape[0] == shape[1]:
        sides = 2 * sides
    # A side of more than a metre is in another unit.
    if len(sides) != 2 or not all(0.0 < side <= _MAX_SIDE for side in sides):
        return None, words
    return (sides[0], sides[1]), words


def check_variable(value: str | None) -> str | None:
    """Return the name of an array in a file, or raise `InputError`."""
    if value is not None and (not isinstance(value, str) or not value):
        raise InputError.about("The variable in a file", value, "the name of an array in it")
    return value


def choose_map(
    arrays: dict[str, RealArray], variable: str | None, rows: str, units: Mapping[str, str] = MappingProxyType({})
) -> RawMap:
    """Return the map among the arrays of a file: the one named, that named `heights`, or the only one.

    `units` are those that the arrays state, by name.
    """
    maps = {name: array for name, array in arrays.items() if min(array.shape) > 1}
    name = variable or ("heights" if "heights" in maps else min(maps, default=""))
    if name not in maps or (variable is None and name != "heights" and len(maps) > 1):
        found = ", ".join(sorted(maps)) or "none"
        raise InputError(
            "its array of heights is not known: give variable= with its name; its real arrays of two dimensions "
            f"are: {found:.200}"
        )
    heights = put_x_first(np.array(maps[name], dtype=np.float64, order="C"), rows)
    size, words = _find_size(arrays, (heights.shape[0], heights.shape[1]))
    if name in units:
        unit = metres(units[name])
        if unit is None:
            raise InputError(f"its heights are stated in {units[name][:20]!a}, which is not a known unit of length")
        heights *= unit
    needs_rows = rows == "auto"
    stated = name_rows("x" if needs_rows else rows, assumed=needs_rows).replace("a line of the file", "the first index")
    return RawMap(heights, size, hint=words, metric=name in units, needs_rows=needs_rows, rows=stated)


@attrs.frozen
class Hdf5Reader(SurfaceReader):
    """An array of numbers in an HDF5 file, first index x, as ``h5py.File(path, "w")["heights"] = heights`` writes it.

    The sides of the map are read as from .mat files. It needs h5py.

    Parameters
    ----------
    variable
        Name of the array, with its groups, as in ``"surface/z"``; by default `heights`, or the only one with two
        dimensions.
    rows
        ``"x"`` or ``"y"``: the axis of the first index, the smallest first; by default x.
    """

    variable: str | None = attrs.field(default=None, converter=check_variable)
    rows: str = attrs.field(default="auto", converter=check_rows)

    @property
    def suffixes(self) -> frozenset[str]:
        """H5 and hdf5."""
        return frozenset({".h5", ".hdf5"})

    def read(self, path: Path) -> RawMap:
        """Return the map."""
        require_memory_of_map(2.0 * path.stat().st_size)
        arrays, units = read_hdf5(path)
        return choose_map(arrays, self.variable, self.rows, units)
