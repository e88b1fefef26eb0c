"""What a file states about its numbers, and the one place where it is used or refused: `build_map`."""

from __future__ import annotations

import contextlib
import re

import attrs
import numpy as np
import numpy.typing as npt

from roughcontact._base.arrays import Array, Pair
from roughcontact._base.units import si
from roughcontact._parts.files.base import RawMap, name_rows, turn_up
from roughcontact.errors import InputError, argument, either, write_number

# Metres in units of length, as instruments and persons write them; the two letters for micro, and its byte in Latin-1,
# read as UTF-8.
_METRES_PER_UNIT = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "km": 1e3, "um": 1e-6, "nm": 1e-9, "pm": 1e-12, "Å": 1e-10}
_METRES_PER_UNIT |= {"meter": 1.0, "metre": 1.0, "millimeter": 1e-3, "millimetre": 1e-3, "micrometer": 1e-6}
_METRES_PER_UNIT |= {"micrometre": 1e-6, "nanometer": 1e-9, "nanometre": 1e-9, "mikrometer": 1e-6}
_METRES_PER_UNIT |= {"micron": 1e-6, "~m": 1e-6, "mum": 1e-6, "ang": 1e-10, "angstrom": 1e-10}
_METRES_PER_UNIT |= {"inch": 0.0254, "in": 0.0254, "mil": 2.54e-5, "thou": 2.54e-5}
_METRES_PER_UNIT |= {"inches": 0.0254, "uin": 2.54e-8, "microinch": 2.54e-8, "microinches": 2.54e-8}
_METRES_PER_UNIT |= {"нм": 1e-9, "мкм": 1e-6, "мм": 1e-3, "纳米": 1e-9, "微米": 1e-6, "毫米": 1e-3}
_METRES_PER_UNIT |= {"kÅ": 1e-7, "kang": 1e-7, "kiloangstrom": 1e-7, "dm": 0.1}
# Units that are words of other meanings, too; and a word, and a number before it, of which it is then the unit.
_WORDS = frozenset({"m", "in", "mil", "thou", "ang", "cm", "dm"})
_WORD = re.compile(r"(?<![^\W\d_])[^\W\d_]{1,14}(?![^\W_])")
_NUMBER_BEFORE = re.compile(r"[0-9]\s*[\[(]?\s*$")
_MICRO = str.maketrans({"µ": "u", "μ": "u", "\udcb5": "u", "\N{ANGSTROM SIGN}": "Å"})
# Relative difference between a stated size and the stated steps times the number of points, or of their distances.
_SIZE_TOLERANCE = 2e-2
# Minimum distance of a number of non-measured points from the heights, over their range, and such numbers of programs:
# nines, and the limits of integers.
_MARK_DISTANCE = 2.0
_MARKS = {99.0, 999.0, 999.25, 999.9, 9999.0, 9999.9, 99999.0, 99999.9, 999999.0, 9999999.0, 99999999.0}
_MARKS |= {32767.0, 32768.0, 65535.0, 2147483647.0, 2147483648.0, 4294967295.0, 8388607.0, 8388608.0}
# Distance, over the range of the heights, at which any whole number at several points is none of them.
_MIN_OUTLYING = 1000.0
# Number that is too large for any height in any unit.
_MIN_MARK = 1e20
# Minimum points at which a zero, far from all other numbers, is none of the heights.
_MIN_ZEROS = 16
# Relative difference between a range of heights that a header states and that of the numbers: it has two digits.
_EXTENT_TOLERANCE = 0.06
# Characters of what a file states that a message repeats.
_MAX_QUOTED_CHARACTERS = 60


def metres(unit: str) -> float | None:
    """Return the metres in a unit such as µm; None if it is not a known unit of length."""
    name = unit.strip().strip("()[]").translate(_MICRO)
    small = name.lower()
    return next(
        (_METRES_PER_UNIT[one] for one in (name, small, small.removesuffix("s")) if one in _METRES_PER_UNIT), None
    )


def in_metres(unit: str | float | None) -> float | None:
    """Return the metres in a unit as a file states it, by name or in metres; None if it is not known or not stated."""
    return metres(unit) if isinstance(unit, str) else unit


def parse_number(text: str, what: str) -> float:
    """Return the finite number that is a text of a file; `InputError` if it is something else, of this name."""
    with contextlib.suppress(ValueError):
        if np.isfinite(number := float(text)):
            return number
    raise InputError(f"its {what} is {text[:20]!a}, which is not a number")


def names_unit(text: str) -> bool:
    """Return whether a text names a unit of length that is not that of a number in it."""
    return any(
        metres(found[0]) is not None
        and found[0].lower() not in _WORDS
        and not _NUMBER_BEFORE.search(text[: found.start()])
        for found in _WORD.finditer(text)
    )


@attrs.frozen(kw_only=True)
class Stated:
    """What a file states about its numbers; by default it states nothing.

    A height is (factor times number plus offset) times unit.

    Attributes
    ----------
    unit
        Unit of the heights, as the file names it, or in metres; None where it states none.
    factor, offset
        Scale and offset of the heights.
    non_measured
        Numbers that stand for non-measured points.
    shape
        Numbers of points along x and y; None for one that is not stated.
    table
        Numbers of first and of second indices, such as lines and numbers in a line; None for one that is not stated.
    rows
        Axis of the first index, ``"x"`` or ``"y"``; empty where it is not stated.
    falling
        The axes whose positions fall as their index rises: ``"y"`` for an image, ``"xy"``, or none.
    size
        Sides of the map along x and y, in `length`; None for one that is not stated.
    steps
        Distances of its points along x and y, in `length`; None for one that is not stated.
    length
        Unit of `size` and `steps`, as the file names it, or in metres; None where it states none.
    periodic
        Whether the map repeats beyond its border.
    extent
        ``"range"``, ``"largest"`` or ``"smallest"`` of the heights, its value in metres, and its unit as the file names
        it, which tell the unit of the heights where the file does not state that; None where it states none.
    unit_hint
        What may state the unit of the heights, in its own words, where it is not understood; else empty.
    channels
        Names of the arrays that it holds, where they are more than the one of heights.
    not_understood
        What it states, in its own words, that changes what the numbers mean and is not understood.
    """

    unit: str | float | None = None
    factor: float = 1.0
    offset: float = 0.0
    non_measured: tuple[float, ...] = ()
    shape: tuple[int | None, int | None] = (None, None)
    table: tuple[int | None, int | None] = (None, None)
    rows: str = ""
    falling: str = ""
    size: tuple[float | None, float | None] = (None, None)
    steps: tuple[float | None, float | None] = (None, None)
    length: str | float | None = None
    periodic: bool = False
    extent: tuple[str, float, str | float] | None = None
    unit_hint: str = ""
    channels: tuple[str, ...] = ()
    not_understood: tuple[str, ...] = ()


def build_map(
    numbers: npt.NDArray[np.generic],
    stated: Stated,
    *,
    rows: str = "auto",
    line: str = "a line of the file",
    needs_unit: bool = False,
    no_data: float | str | None = "none",
) -> RawMap:
    """Return the map of the numbers of a file, in any type, shape (n, m); what the file states is used or refused.

    Parameters
    ----------
    rows
        Axis of the first index, ``"x"`` or ``"y"``, as the user gives it; ``"auto"``: as the file states it, or x.
    line
        What one first index is, in the words of a user.
    needs_unit
        Whether numbers without a stated unit have an unknown one, as in images, instead of metres.
    no_data
        The number that stands for a non-measured point, as the user gives it; ``"none"`` if there is none; None if
        nobody says so: a number that looks like one is asked about.
    """
    require_understood(stated)
    if isinstance(no_data, float):
        stated = attrs.evolve(stated, non_measured=(no_data,))
    elif no_data is None and not stated.non_measured:
        _refuse_marks(numbers)
    _require_shape(numbers.shape, stated.table, "lines and numbers in a line")
    first = _find_rows(stated, rows, numbers.shape)
    if not first:
        _require_rows(stated)
    heights = _scale(numbers, stated)
    heights = np.ascontiguousarray(heights.T) if first == "y" else heights
    _require_shape(heights.shape, stated.shape, "points along x and y")
    if stated.falling and first == (stated.rows or first):
        heights = turn_up(heights, stated.falling)
    unit = _find_unit(stated)
    unit_hint = stated.unit_hint
    if unit is None and stated.extent is not None:
        unit = _find_unit_of_extent(heights, *stated.extent)
        unit_hint = unit_hint or f"{stated.extent[0]} height {si(stated.extent[1], 'm')}"
    if unit is not None:
        heights *= unit
    size, steps, hint = _find_sides(stated, (heights.shape[0], heights.shape[1]))
    downwards = (first or "x") in stated.falling
    in_words = name_rows(first or "x", line, assumed=not first, downwards=downwards)
    if first == "y" and rows == "auto" and not stated.rows:
        # Counts say which axis it is, but not its direction.
        in_words += ", upwards (assumed)"
    return RawMap(
        heights,
        size,
        periodic=stated.periodic,
        metric=unit is not None,
        hint=hint,
        needs_unit=needs_unit and unit is None,
        needs_rows=not first,
        steps=steps,
        rows=in_words,
        unit=unit,
        partial=_find_partial(stated),
        unit_hint=unit_hint if unit is None else "",
    )


def require_understood(stated: Stated) -> None:
    """Refuse what changes the meaning of numbers and is not understood, and more than one array."""
    if stated.not_understood:
        skipped = either(f" (in text, {argument('skip_rows')} skips the line)")
        quoted = stated.not_understood[0].strip()[:_MAX_QUOTED_CHARACTERS]
        raise InputError(
            f"it states {quoted!a}, which changes what its numbers mean and is not understood: write the heights "
            f"themselves, with nan for points that were not measured, and omit that{skipped}"
        )
    if len(stated.channels) > 1:
        names = ", ".join(repr(name) for name in stated.channels)
        raise InputError(f"it holds more than one array, {names:.200}: keep the heights alone")


def _find_rows(stated: Stated, rows: str, table: tuple[int, ...]) -> str:
    """Return the axis of the first index; empty where neither the file nor the user says it."""
    shape = tuple(_count(*one, stated.length) for one in zip(stated.shape, stated.size, stated.steps, strict=True))
    if rows == "auto" and not stated.rows and shape[0] != shape[1] and None not in shape:
        # The stated numbers of points along x and y fit one order.
        return "x" if table == shape else "y" if table == shape[::-1] else ""
    if rows == "auto":
        return stated.rows
    if stated.rows and rows != stated.rows:
        raise InputError(f"it states that its rows are those of {stated.rows}: omit {argument('rows')}")
    return rows


def _require_rows(stated: Stated) -> None:
    """Refuse a table whose rows and columns, and the sides along x and y, are stated, but not which are which."""
    rows, columns = stated.table
    lengths = next((pair for pair in (stated.size, stated.steps) if None not in pair), (None, None))
    if rows is not None and columns is not None and rows != columns and lengths[0] != lengths[1]:
        raise InputError(
            f"it states {rows} rows, {columns} columns and lengths along x and y, but not whether a row is one x or "
            f"one y: say it with {argument('rows', 'y')}, or {argument('rows', 'x')}"
        )


def _count(count: int | None, side: float | None, step: float | None, unit: str | float | None) -> int | None:
    """Return the number of points along an axis, as stated, or that of the stated steps in the stated side.

    A side without a unit may be a number of points.
    """
    if count is not None or not side:
        return count
    return round(side / step) if step else round(side) if unit is None else None


def _scale(numbers: npt.NDArray[np.generic], stated: Stated) -> Array:
    """Return new numbers in the unit of the file, NaN where a point was not measured."""
    values = np.array(numbers, dtype=np.float64, order="C", ndmin=2)
    for one in stated.non_measured:
        # A value is written with other digits than the numbers may have, as -3.4e38 in 32 bits.
        with np.errstate(over="ignore"):
            marked = np.asarray(one).astype(numbers.dtype) if numbers.dtype.kind == "f" else np.asarray(one)
        values[values == float(marked)] = np.nan
    if stated.factor != 1.0:
        values *= stated.factor
    if stated.offset != 0.0:
        values += stated.offset
    return values


def _refuse_marks(numbers: npt.NDArray[np.generic]) -> None:
    """Refuse an extreme number, far from all others, that programs write for a non-measured point."""
    values = np.asarray(numbers, dtype=np.float64)
    # No copy of the numbers is made: maps are large.
    known = np.isfinite(values)
    total = int(np.count_nonzero(known))
    lowest, highest = _find_range(values, known)
    for mark in (lowest, highest):
        others = known & (values != mark)
        count = total - int(np.count_nonzero(others))
        if count == total:
            return
        low, high = _find_range(values, others)
        span = high - low
        distance = max(low - mark, mark - high)
        if distance > _MARK_DISTANCE * span > 0.0 and _is_mark(mark, count, total, distance / span):
            named = f"say so with {argument('no_data', mark)}, or {argument('no_data', 'none')} if it is a height"
            advice = either(named, "leave these fields empty")
            raise InputError(
                f"its number {write_number(mark)} stands at {count} points, far from all others ({low:.6g} to "
                f"{high:.6g}), as programs write it where nothing was measured: {advice}"
            )


def _find_range(values: Array, chosen: npt.NDArray[np.bool_]) -> tuple[float, float]:
    with np.errstate(invalid="ignore"):
        return (
            float(np.min(values, where=chosen, initial=np.inf)),
            float(np.max(values, where=chosen, initial=-np.inf)),
        )


def _is_mark(value: float, count: int, total: int, distance: float) -> bool:
    """Return whether a number at so many of all points, far from them over their range, is one of no height."""
    if value == 0.0:
        return _MIN_ZEROS <= count <= total // 2
    is_outlying = count > 1 and value == round(value) and distance > _MIN_OUTLYING
    return is_outlying or abs(value) in _MARKS or abs(value) >= _MIN_MARK


def check_no_data(value: float | str | None) -> float | str | None:
    """Return the number of non-measured points in a file, ``"none"`` or None, or raise `InputError`."""
    with contextlib.suppress(TypeError, ValueError):
        if value is not None and not isinstance(value, bool) and np.isfinite(float(value)):
            return float(value)
    if value not in (None, "none"):
        allowed = "a number such as -9999, or 'none' if it holds only heights"
        raise InputError.about("The number of non-measured points in a file", value, allowed)
    return value


def _require_shape(there: tuple[int, ...], stated: tuple[int | None, int | None], what: str) -> None:
    """Refuse numbers of another shape than the file states."""
    n, m = (count or found for count, found in zip(stated, there, strict=True))
    if (n, m) != there:
        raise InputError(
            f"it states {n} x {m} {what}, but holds {there[0]} x {there[1]}: it is damaged, or holds more than one "
            "table"
        )


def _find_unit(stated: Stated) -> float | None:
    """Return the metres in the unit of the heights; None where none is stated."""
    unit = in_metres(stated.unit)
    if unit is None and isinstance(stated.unit, str):
        raise InputError(
            f"it states values in {stated.unit.strip()[:_MAX_QUOTED_CHARACTERS]!a}, which is not a known unit of length"
        )
    return unit


def _find_unit_of_extent(heights: Array, what: str, value: float, name: str | float) -> float | None:
    """Return the metres in the unit of heights whose range, or extreme, is stated; None if it fits none."""
    low, high = _find_range(heights, np.isfinite(heights))
    there = {"range": high - low, "largest": high, "smallest": low}[what]
    fitting = (
        unit for unit in (in_metres(name), 1.0) if unit and abs(there * unit - value) <= _EXTENT_TOLERANCE * abs(value)
    )
    return next(fitting, None)


def _find_partial(stated: Stated) -> tuple[float | None, float | None]:
    """Return the distances of the points along x and y, m, of which the file states one alone; else None twice."""
    length = in_metres(stated.length)
    if length is None or stated.steps.count(None) != 1:
        return (None, None)
    x, y = (None if step is None else step * length for step in stated.steps)
    return (x, y)


def _find_sides(stated: Stated, shape: tuple[int, int]) -> tuple[Pair | None, Pair | None, str]:
    """Return the sides of the map, m, the distances of its points in an unknown unit, and a hint in words."""
    length = in_metres(stated.length)
    x_side, y_side = (
        side if side is not None or step is None else step * count
        for side, step, count in zip(stated.size, stated.steps, shape, strict=True)
    )
    for side, step, count, axis in zip(stated.size, stated.steps, shape, "xy", strict=True):
        if side is not None and step is not None and not _agree(side, step, count):
            raise InputError(
                f"it states {count} points {step:g} apart along {axis}, and a side of {side:g} there, which contradict "
                "each other"
            )
    if x_side is None or y_side is None:
        return None, None, ""
    if min(x_side, y_side) <= 0.0 or not np.isfinite([x_side, y_side]).all():
        raise InputError(f"it states sides of {x_side:g} and {y_side:g}, which must be positive")
    if length is not None:
        return (x_side * length, y_side * length), None, ""
    if (x_side, y_side) == shape:
        # They are numbers of points.
        return None, None, ""
    steps = (x_side / shape[0], y_side / shape[1])
    named = "a unit that it does not state" if stated.length is None else repr(stated.length)
    return None, steps, f"its {shape[0]} x {shape[1]} points are {steps[0]:.6g} x {steps[1]:.6g} apart in {named}"


def _agree(side: float, step: float, count: int) -> bool:
    """Return whether a side is that of the cells of a step, or the distance of the first and the last point."""
    return min(abs(side / step - count), abs(side / step - count + 1)) <= _SIZE_TOLERANCE * count if step else False
