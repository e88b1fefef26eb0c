"""Height maps from arrays with named axes and units, as xarray has them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import attrs
import numpy as np

from roughcontact._base.checks import without_unit
from roughcontact._base.units import has_unit
from roughcontact._parts.files.base import RawMap
from roughcontact._parts.files.hdf5 import NetcdfReader
from roughcontact._parts.files.named import (
    DESCRIBING_ATTRIBUTES,
    NUMBER_ATTRIBUTES,
    STATING_ATTRIBUTES,
    STEPS_OF_HEIGHTS,
    UNIT_ATTRIBUTES,
    NamedArray,
    choose_map,
    is_changing,
    name_axis,
    read_numbers,
)
from roughcontact.errors import InputError


def call_array(array: Any) -> str:
    """Return what a sentence calls an array with named axes."""
    return f"array {str(array.name)[:40]!r}" if getattr(array, "name", None) is not None else "array"


def read_labelled(array: Any, no_data: float | str | None) -> RawMap:
    """Return the map in an array with named axes; what it states is used or refused, as in netCDF.

    `no_data` is that of `NetcdfReader`. The `InputError` continues a sentence that names the array.
    """
    if hasattr(array, "data_vars"):
        raise InputError(f"it is a set of arrays: give one of them, such as {str(next(iter(array.data_vars), ''))!r}")
    array = array.squeeze() if array.ndim > 2 else array
    axes = tuple(map(name_axis, map(str, array.dims)))
    if sorted(axes) != ["x", "y"]:
        names = ", ".join(repr(str(name)) for name in array.dims) or "none"
        raise InputError(f"its axes, {names[:80]}, must be two, named 'x' and 'y': rename them")
    if min(array.shape) < 2:
        raise InputError("it has less than two places along x or y")
    name = str(array.name) if array.name is not None else "heights"
    named = {str(key): _name(one) for key, one in array.coords.items() if one.ndim <= 2}
    arrays = {key: one for key, one in named.items() if one.values.dtype.kind in "iuf"}
    heights = attrs.evolve(_name(array), axes=axes)
    if heights.values.dtype.kind not in "iuf":
        raise InputError("it must hold real numbers")
    raw = choose_map({**arrays, name: heights}, {}, NetcdfReader(variable=name, no_data=no_data))
    return attrs.evolve(raw, needs_unit=raw.unit is None and not raw.unit_hint)


def _name(array: Any) -> NamedArray:
    """Return the numbers of an array, and what its attributes state of them."""
    values = array.data
    found = _read_attributes(array.attrs)
    if has_unit(values):
        values = without_unit(values, "its unit", "m")
        found["units"] = "m"
    return NamedArray(np.asarray(values), found, tuple(map(str, array.dims)))


def _read_attributes(stated: Mapping[Any, Any]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name, value in ((str(key), value) for key, value in stated.items()):
        if name in UNIT_ATTRIBUTES or name in DESCRIBING_ATTRIBUTES:
            found[name] = str(value)
        elif name in NUMBER_ATTRIBUTES:
            found[name] = read_numbers(name, value)
        elif name in STATING_ATTRIBUTES or is_changing(name) or name.lower() in STEPS_OF_HEIGHTS:
            numbers = np.asarray(value)
            found[name] = numbers if numbers.dtype.kind in "iuf" else str(value)
    return {name: value for name, value in found.items() if not isinstance(value, str) or value}
