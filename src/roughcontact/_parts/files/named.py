"""The map among the named arrays of a file of HDF5, netCDF, MATLAB or numpy, and what they state of each other."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Mapping
from typing import Any

import attrs
import numpy as np

from roughcontact._base.arrays import RealArray
from roughcontact._parts.files.base import GRIDDATA_ADVICE, RawMap, SurfaceReader, check_rows
from roughcontact._parts.files.points import MIN_POINTS, are_on_grid
from roughcontact._parts.files.stated import Stated, build_map, check_no_data, metres, names_unit
from roughcontact.errors import InputError, argument

# Attributes of an array that are read: its unit, packing, the values of non-measured points, and the valid ones.
UNIT_ATTRIBUTES = ("units", "unit", "Units", "Unit", "UNITS", "UNIT")
MISSING_ATTRIBUTES = ("_FillValue", "missing_value")
# Names of the number of non-measured points.
_MISSING_NAMES = ("nodata", "no_data", "nodata_value", "fill_value", "fillvalue")
VALID_ATTRIBUTES = ("valid_range", "valid_min", "valid_max")
PACKING_ATTRIBUTES = ("scale_factor", "add_offset")
NUMBER_ATTRIBUTES = (*PACKING_ATTRIBUTES, *MISSING_ATTRIBUTES, *VALID_ATTRIBUTES)
# Names that change what numbers mean, and have no meaning on which all agree.
CHANGING_NAMES = frozenset(
    {"scale", "z_scale", "zscale", "scaling", "factor", "z_factor", "gain", "multiplier", "offset", "z_offset", "lsb"}
    | {"height_scale", "scale_z", "height_factor", "conversion", "conversion_factor", "to_metres", "to_meters"}
    | {"invalid", "mask", "valid", "bit2nm", "_unsigned", *_MISSING_NAMES}
)
# Words in the names of attributes that change what numbers mean, too, unless others say that they are about something
# else; and the values by which they change nothing.
_CHANGING_WORDS = frozenset({"scale", "scaling", "factor", "gain", "multiplier", "calibration", "sensitivity", "lsb"})
_STEP_WORDS = frozenset({"count", "counts", "digit", "dn", "adu"})
# Words in such names whose text changes nothing, unless it has a number or a unit.
_DESCRIBED_WORDS = frozenset({"calibration", "sensitivity", "gain"})
_CHANGING_WORDS |= {"conversion", "inverted", "inversion", "flipped", "positive"}
_OTHER_WORDS = frozenset(
    {"x", "y", "xy", "lateral", "pixel", "time", "date", "color", "colour", "bar", "laser", "axis"}
)
_NEUTRAL = {"positive": "up", "unsigned": "false"}
_WORD = re.compile("[A-Z]?[a-z]+|[A-Z]+(?![a-z])")
# Words for heights that are positive downwards.
_DEPTHS = frozenset({"depth", "depths", "tiefe", "tiefen", "profondeur"})
DESCRIBING_ATTRIBUTES = (
    *("long_name", "standard_name", "description", "comment", "title", "label", "note", "notes", "info", "meta"),
    *("metadata", "header"),
)
# A name of a factor to a unit, such as to_um; and names of the step of heights that are integers.
_TO_UNIT = re.compile(r"(?i)(?:^|_)to_(?:m|[umn]m|microns?|(?:micro|nano|milli)?met(?:er|re)s?)$")
STEPS_OF_HEIGHTS = frozenset(
    f"{one}" for name in ("step", "res", "resolution", "increment") for one in (f"z{name}", f"z_{name}", f"{name}_z")
) | {"dz"}
# A name of heights with their unit, such as height_nm.
_JOINT_NAME = re.compile(r"(?i)(?:z|heights?|topography|surface)_([^\W\d_]+)")
# Names of arrays that state the unit of the heights, and that of the sides; that of everything is named as a unit is.
_HEIGHT_UNITS = (
    *("zunit", "z_unit", "zunits", "z_units", "height_unit", "height_units", "heights_unit", "heights_units"),
    *("unit_z", "units_z", "zUnit", "zUnits", "ZUnit", "heightUnit", "heightUnits"),
)
_SIDE_UNITS = (
    "resolution_unit",
    "xyunit",
    "xy_unit",
    "xyunits",
    "xunit",
    "x_unit",
    "xunits",
    "lateral_unit",
    "size_unit",
)
_SPECIFIC_UNITS = frozenset({*_HEIGHT_UNITS, *_SIDE_UNITS})
_PITCH_NAMES = ("pixel_size", "pixelsize", "pixelSize", "cell_size", "cellsize", "pitch")
# Names of the pitch along an axis, with that of the axis before or behind it.
_PITCHES = ("resolution", "res", "step", "spacing", "increment", "pitch", "pixel_size", "pixelsize")
_PITCHES_X, _PITCHES_Y = (
    tuple(f"{axis}{gap}{name}" for gap in ("_", "") for name in _PITCHES)
    + tuple(f"{name}_{axis}" for name in _PITCHES)
    + (f"d{axis}",)
    for axis in "xy"
)
_SIZE_NAMES = ("size", "lx", "ly", *_PITCHES_X, *_PITCHES_Y, *_PITCH_NAMES)
# Name of the places of the left, right, lower and upper border, as matplotlib has them.
_EXTENT = "extent"
# Names of the axes, and of the positions along them.
_AXES = {"x": "x", "lon": "x", "longitude": "x", "easting": "x", "col": "x", "column": "x"}
_AXES |= {"y": "y", "lat": "y", "latitude": "y", "northing": "y", "row": "y"}
# Names of sides and units that may be attributes, too; and all names that `gather` looks for.
STATING_ATTRIBUTES = frozenset({*_HEIGHT_UNITS, *UNIT_ATTRIBUTES, *_SIDE_UNITS, *_SIZE_NAMES, _EXTENT})
STATING_NAMES = {*STATING_ATTRIBUTES, *CHANGING_NAMES, *"xyXY"}
# Relative difference between the steps of positions that are regular: they are printed with six digits, or in 32 bits.
_STEP_TOLERANCE = 1e-2


def is_changing(name: str) -> bool:
    """Return whether an attribute of this name changes what numbers mean."""
    words = {word.lower() for word in _WORD.findall(name)}
    is_step = ("per" in words and bool(words & _STEP_WORDS)) or _TO_UNIT.search(name) is not None
    return name.lower() in CHANGING_NAMES or is_step or bool(words & _CHANGING_WORDS and not words & _OTHER_WORDS)


def _is_neutral(name: str, value: Any) -> bool:
    """Return whether a value of such an attribute changes nothing."""
    words = {word.lower() for word in _WORD.findall(name)}
    if isinstance(value, str):
        if words & _DESCRIBED_WORDS and not re.search("[0-9]", value) and not names_unit(value):
            return True
        return any(word in words and value.lower() == neutral for word, neutral in _NEUTRAL.items())
    return bool(np.size(value) == 1 and float(np.ravel(value)[0]) == (0.0 if "offset" in words else 1.0))


def _require_heights(name: str, one: NamedArray) -> None:
    """Refuse an array whose name says that it holds depths, or whose shape is that of a list of points x y z."""
    if found := next(
        (word for word in one.describe(name) if _DEPTHS.intersection(re.findall("[a-z]+", word.lower()))), None
    ):
        raise InputError(f"its array is {found[:40]!a}, positive downwards: write heights, positive outwards")
    require_table(one.values)


def require_table(numbers: RealArray) -> None:
    """Refuse an array whose rows are points x y z on a regular grid."""
    is_list = numbers.ndim == 2 and numbers.shape[1] == 3 and numbers.shape[0] >= MIN_POINTS
    if is_list and are_on_grid(np.asarray(numbers, dtype=np.float64)):
        raise InputError(
            f"each of its {numbers.shape[0]} rows is a point x y z of a regular grid, but an array of heights has an x "
            "for each row: bring the heights into that shape, or save the points as text x y z"
        )


def find_stating(name: str) -> str:
    """Return the name, as `gather` looks for it, of an attribute that states sides or units; empty if it is none."""
    plain = re.sub(r"\W+", "_", name)
    return next((one for one in (name, plain, plain.lower()) if one in STATING_ATTRIBUTES), "")


@attrs.frozen(eq=False)
class NamedArray:
    """An array of numbers of a file: its values, what its attributes state, and the names of its axes, if stated."""

    values: RealArray
    attributes: Mapping[str, Any] = attrs.field(factory=dict)
    axes: tuple[str, ...] = ()

    @property
    def unit(self) -> Any:
        """The unit that its attributes name; None where they do not."""
        return next((self.attributes[name] for name in UNIT_ATTRIBUTES if name in self.attributes), None)

    def describe(self, name: str) -> list[str]:
        """Return the last part of its name, and what its attributes say of it in words."""
        return [name.rpartition("/")[2], *(str(self.attributes.get(key, "")) for key in DESCRIBING_ATTRIBUTES)]

    def squeezed(self) -> NamedArray:
        """Return an array of more than two dimensions without axes of one point, such as one time."""
        shape = self.values.shape
        if len(shape) <= 2:
            return self
        axes = tuple(axis for axis, count in zip(self.axes, shape, strict=False) if count > 1)
        return attrs.evolve(self, values=self.values.squeeze(), axes=axes)


def read_numbers(name: str, value: Any) -> float | tuple[float, ...]:
    """Return the number of an attribute, or its numbers; `InputError` unless there are as many as it must have."""
    numbers = np.ravel(value)
    several = name in MISSING_ATTRIBUTES
    count = 2 if name == "valid_range" else 1
    is_real = numbers.dtype.kind in "iuf" and (name not in PACKING_ATTRIBUTES or bool(np.isfinite(numbers).all()))
    if not is_real or not (several or numbers.size == count):
        allowed = "a number" if count == 1 else "a pair of numbers"
        raise InputError(f"it states {value!r:.40} as its {name}, which is not {allowed}")
    return tuple(map(float, numbers)) if several or count == 2 else float(numbers[0])


def check_variable(value: str | None) -> str | None:
    """Return the name of an array in a file, or raise `InputError`."""
    if value is not None and (not isinstance(value, str) or not value):
        raise InputError.about("The variable in a file", value, "the name of an array in it")
    return value


@attrs.frozen
class NamedArrayReader(SurfaceReader):
    """A reader of files of named arrays; see its subclasses for the options."""

    variable: str | None = attrs.field(default=None, converter=check_variable)
    rows: str = attrs.field(default="auto", converter=check_rows)
    no_data: float | str | None = attrs.field(default=None, converter=check_no_data)


def choose_map(
    arrays: Mapping[str, NamedArray],
    texts: Mapping[str, str],
    reader: NamedArrayReader,
) -> RawMap:
    """Return the map among the arrays of a file: the one that the reader names, `heights`, or the only one.

    `texts` are its texts, by their names, which may state units.
    """
    maps = {name: one for name, one in arrays.items() if one.values.ndim == 2 and min(one.values.shape) > 1}
    # As meshgrid writes places.
    places = {name for name in maps if name.rpartition("/")[2] in ("x", "y", "X", "Y")}
    beside_it = {name for name in maps if name.rpartition("/")[2].lower() in CHANGING_NAMES}
    beside_it |= places if len(places) == 2 else set()
    chosen = [name for name in maps if name not in beside_it] or [*maps]
    name = reader.variable or ("heights" if "heights" in maps else min(chosen, default=""))
    if name not in maps or (reader.variable is None and name != "heights" and len(chosen) > 1):
        found = ", ".join(sorted(maps)) or "none"
        raise InputError(
            f"its array of heights is not known: give {argument('variable')} with its name; its real arrays of two "
            "dimensions "
            f"are: {found:.200}"
        )
    # What stands beside the map counts before what stands above it.
    group, _, last = name.rpartition("/")
    _require_heights(name, maps[name])
    beside = _find_beside(texts, group)
    stated = gather(maps[name], _find_beside(arrays, group), beside)
    joint = _JOINT_NAME.fullmatch(last)
    if stated.unit is None and joint is not None and metres(joint[1]) is not None:
        stated = attrs.evolve(stated, unit=joint[1])
    words = [*maps[name].describe(name), *(text for key, text in beside.items() if key in DESCRIBING_ATTRIBUTES)]
    stated = attrs.evolve(stated, unit_hint=next(filter(names_unit, words), ""))
    numbers = _mark_invalid(maps[name])
    return build_map(numbers, stated, rows=reader.rows, line="the first index", no_data=reader.no_data)


def _find_beside(found: Mapping[str, Any], group: str) -> dict[str, Any]:
    """Return what stands in the file itself or in a group, by its last name; what is in the group counts."""
    own = {name.rpartition("/")[2]: one for name, one in found.items() if name.rpartition("/")[0] == group}
    return {name: one for name, one in found.items() if "/" not in name} | own


def _mark_invalid(one: NamedArray) -> RealArray:
    """Return numbers with NaN outside the range that is stated to be valid."""
    stated = one.attributes
    smallest, largest = stated.get("valid_range", (stated.get("valid_min", -np.inf), stated.get("valid_max", np.inf)))
    if (smallest, largest) == (-np.inf, np.inf):
        return one.values
    values = np.array(one.values, dtype=np.float64)
    values[(values < smallest) | (values > largest)] = np.nan
    return values


def gather(one: NamedArray, arrays: Mapping[str, NamedArray], texts: Mapping[str, str]) -> Stated:
    """Return what the attributes of an array, and the arrays and texts beside it, state."""
    own = {name: np.asarray(value) for name, value in one.attributes.items() if name in (*_SIZE_NAMES, _EXTENT)}
    arrays = {**arrays, **{name: NamedArray(value) for name, value in own.items() if value.dtype.kind in "iuf"}}
    texts = {**texts, **{name: str(value) for name, value in one.attributes.items() if name in _SPECIFIC_UNITS}}
    scalars = {name: float(other.values.ravel()[0]) for name, other in arrays.items() if other.values.size == 1}
    arrays = {_AXES.get(name.lower(), name): other for name, other in arrays.items()} | dict(arrays)
    # A number as unit is that of metres.
    units: dict[str, str | float] = {**scalars, **texts}
    specific, common, lateral = (
        next((units[name] for name in names if name in units), None)
        for names in (_HEIGHT_UNITS, UNIT_ATTRIBUTES, _SIDE_UNITS)
    )
    unit = next((value for value in (one.unit, specific, common) if value is not None), None)
    alike = {name: "an array" for name, other in arrays.items() if other.values.shape == one.values.shape}
    changing = {name: value for name, value in (scalars | alike).items() if name.lower() in CHANGING_NAMES}
    changing |= {
        name: value
        for name, value in one.attributes.items()
        if is_changing(name) and name not in PACKING_ATTRIBUTES and not _is_neutral(name, value)
    }
    if one.values.dtype.kind in "iu":
        changing |= {name: value for name, value in one.attributes.items() if name.lower() in STEPS_OF_HEIGHTS}
    missing = [float(value) for name in MISSING_ATTRIBUTES for value in np.ravel(one.attributes.get(name, ()))]
    for name in [name for name in changing if name.lower() in _MISSING_NAMES]:
        with contextlib.suppress(TypeError, ValueError):
            missing.append(float(changing[name]))
            del changing[name]
    # A common unit may be that of the sides, too: then these ask for themselves.
    length = lateral if lateral is not None or common is not None else 1.0
    found = Stated(
        unit=unit,
        factor=float(one.attributes.get("scale_factor", 1.0)),
        offset=float(one.attributes.get("add_offset", 0.0)),
        non_measured=tuple(missing),
        not_understood=tuple(f"{name} = {value}" for name, value in changing.items()),
        rows=_name_first(one.axes),
        length=length,
    )
    return _find_places(found, one, arrays) or _find_sides(found, one.values.shape, arrays)


def name_axis(name: str) -> str:
    """Return ``"x"`` or ``"y"`` for the name of an axis; empty for another one."""
    return _AXES.get(name.rpartition("/")[2].lower(), "")


def _name_first(axes: tuple[str, ...]) -> str:
    names = list(map(name_axis, axes))
    return names[0] if sorted(names) == ["x", "y"] else ""


def _find_sides(stated: Stated, shape: tuple[int, ...], arrays: Mapping[str, NamedArray]) -> Stated:
    """Return what is stated with the sides of the map from `size`, `lx` and `ly`, or the pitch `dx` and `dy`."""
    known = {name: arrays[name] for name in _SIZE_NAMES if name in arrays and arrays[name].values.size <= 2}
    units = {one.unit for one in known.values()}
    if len(units) > 1:
        raise InputError(
            f"its sides are stated in different units: give {argument('size')}, and keep the heights alone"
        )
    if units - {None}:
        stated = attrs.evolve(stated, length=units.pop())
    values = {name: one.values.ravel().astype(np.float64).tolist() for name, one in known.items()}
    sides = values.get("size") or [*values.get("lx", []), *values.get("ly", [])]
    if not sides and _EXTENT in arrays and arrays[_EXTENT].values.size == 4:
        left, right, bottom, top = arrays[_EXTENT].values.ravel().astype(np.float64).tolist()
        sides = [abs(right - left), abs(top - bottom)]
    if len(sides) == 1 and shape[0] == shape[1]:
        sides = 2 * sides
    if len(sides) == 2:
        stated = attrs.evolve(stated, size=(sides[0], sides[1]))
    pitch = next((values[name] for name in _PITCH_NAMES if name in values), None)
    if pitch is not None:
        stated = attrs.evolve(stated, steps=(pitch[0], pitch[-1]))
    along_x, along_y = (
        next((values[name][0] for name in names if name in values), None) for names in (_PITCHES_X, _PITCHES_Y)
    )
    if along_x is not None:
        stated = attrs.evolve(stated, steps=(along_x, along_x if along_y is None else along_y))
    return stated


def _find_places(stated: Stated, one: NamedArray, arrays: Mapping[str, NamedArray]) -> Stated | None:
    """Return what is stated with the steps of the positions `x` and `y` of the points; None without both."""
    if not {"x", "y"} <= set(arrays):
        return None
    shape = one.values.shape
    both = [arrays[axis].values.astype(np.float64) for axis in "xy"]
    first = stated.rows
    if both[0].shape == both[1].shape == shape and len(shape) == 2 and min(shape) > 1:
        # As meshgrid writes them: x is constant along the index of y.
        first = "x" if np.ptp(both[0][:, 0]) >= np.ptp(both[0][0]) else "y"
        both = [places[:, 0] if axis == first else places[0] for axis, places in zip("xy", both, strict=True)]
    places = [place.ravel() for place in both]
    counts = tuple(place.size for place in places)
    if counts not in (shape, shape[::-1]) or min(counts) < 2:
        return None
    if not first and counts[0] != counts[1]:
        first = "x" if counts == shape else "y"
    steps = [_find_step(place, axis) for place, axis in zip(places, "xy", strict=True)]
    unit = arrays["x"].unit
    other = unit if arrays["y"].unit is None else arrays["y"].unit
    if unit != other:
        along_x, along_y = (metres(str(name)) for name in (unit, other))
        if along_x is None or along_y is None:
            raise InputError(f"its x are in {str(unit)!a}, its y in {str(other)!a}: give both in one unit of length")
        steps[1] *= along_y / along_x
    falling = "".join(axis for axis, step in zip("xy", steps, strict=True) if step < 0.0)
    return attrs.evolve(
        stated, rows=first, steps=(abs(steps[0]), abs(steps[1])), falling=falling, length=unit, size=(None, None)
    )


def _find_step(places: RealArray, axis: str) -> float:
    step = float(places[-1] - places[0]) / (places.size - 1)
    if not np.isfinite(step) or step == 0.0 or np.abs(np.diff(places) - step).max() > _STEP_TOLERANCE * abs(step):
        raise InputError(
            f"its positions {axis} are not regular: interpolate the heights on a regular grid{GRIDDATA_ADVICE}"
        )
    return step
