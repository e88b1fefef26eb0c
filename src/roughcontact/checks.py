"""Checks of input values at the door: each returns the clean value or raises a sentence."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from roughcontact.errors import InputError

Array: TypeAlias = npt.NDArray[np.float64]
RealArray: TypeAlias = npt.NDArray[Any]
IntArray: TypeAlias = npt.NDArray[np.intp]
Mask: TypeAlias = npt.NDArray[np.bool_]
Pair: TypeAlias = tuple[float, float]


def number(
    value: object,
    what: str,
    unit: str = "",
    *,
    above: float | None = None,
    at_least: float | None = None,
    at_most: float | None = None,
) -> float:
    """Return `value` as a finite float inside the given bounds.

    Parameters
    ----------
    value
        What the user gave.
    what, unit
        The name of the quantity and its SI unit, for the sentence.
    above, at_least, at_most
        Bounds: exclusive lower, inclusive lower, inclusive upper.

    Raises
    ------
    InputError
        If `value` is no real finite number or is out of bounds.
    """
    bounds = [
        f"above {above:g}" if above is not None else "",
        f"at least {at_least:g}" if at_least is not None else "",
        f"at most {at_most:g}" if at_most is not None else "",
    ]
    limits = " and ".join(filter(None, bounds))
    allowed = "a finite number" + (f", {limits}" if limits else "") + (f" ({unit})" if unit else "")
    if isinstance(value, (str, bytes, bool, np.bool_)) or np.iscomplexobj(value) or np.ndim(value) != 0:  # type: ignore[arg-type]
        raise InputError.about(what, value, allowed)
    try:
        result = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError):
        raise InputError.about(what, value, allowed) from None
    inside = (
        math.isfinite(result)
        and (above is None or result > above)
        and (at_least is None or result >= at_least)
        and (at_most is None or result <= at_most)
    )
    if not inside:
        raise InputError.about(what, result, allowed)
    return result


def integer(value: object, what: str, *, at_least: int) -> int:
    """Return `value` as an int of at least `at_least`, or raise `InputError`."""
    allowed = f"a whole number of at least {at_least}"
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or value < at_least:
        raise InputError.about(what, value, allowed)
    return int(value)


def pair(
    value: float | Sequence[float],
    what: str,
    unit: str = "",
    *,
    above: float | None = None,
    at_least: float | None = None,
) -> Pair:
    """Return one value or two as an (x, y) pair of finite floats, or raise `InputError`."""
    items: list[object] = list(value) if isinstance(value, (tuple, list, np.ndarray)) else [value, value]
    if len(items) != 2:
        raise InputError.about(what, value, f"one value or two, (x, y) ({unit or 'no unit'})")
    x, y = (number(item, what, unit, above=above, at_least=at_least) for item in items)
    return x, y


def choice(value: object, what: str, allowed: Sequence[str]) -> str:
    """Return `value` if it is one of the words in `allowed`, or raise `InputError`."""
    if not isinstance(value, str) or value not in allowed:
        words = ", ".join(repr(word) for word in allowed)
        raise InputError.about(what, value, f"one of {words}")
    return str(value)


def instance_of(base: type, what: str, allowed: str) -> Callable[[Any, Any, Any], None]:
    """Return an attrs validator that asks for an instance of `base`, in words."""

    def check(_: Any, __: Any, value: Any) -> None:
        if not isinstance(value, base):
            raise InputError.about(what, value, allowed)

    return check


def frozen_array(values: Array) -> Array:
    """Return `values` as a C-ordered, read-only float64 array."""
    array = np.ascontiguousarray(values, dtype=np.float64)
    array.flags.writeable = False
    return array


def heights_array(values: npt.ArrayLike) -> Array:
    """Return a private, read-only copy of a height map after checking it.

    Raises
    ------
    InputError
        If the array is not two-dimensional, holds fewer than two cells, no numbers, or values
        that are not finite (missing points of a measurement, usually).
    """
    what = "The height map"
    if isinstance(values, np.ma.MaskedArray) and np.ma.is_masked(values):
        values = np.ma.filled(np.ma.asarray(values, dtype=np.float64), np.nan)
    try:
        array = np.array(values)
    except ValueError:
        raise InputError(f"{what} must be a rectangular array, but its rows differ in length.") from None
    if array.dtype.kind not in "fiu":
        raise InputError.about(what, array.dtype, "an array of real numbers (m)")
    if array.ndim != 2 or array.size < 2:
        raise InputError.about(what, array.shape, "a two-dimensional array [x, y] of at least two cells")
    array = np.array(array, dtype=np.float64, order="C")
    missing = array.size - int(np.count_nonzero(np.isfinite(array)))
    if missing:
        raise InputError(
            f"{what} must be finite everywhere, but {missing} of {array.size} points are NaN or infinite. "
            "Fill them first, for instance with read_surface(path, missing='fill')."
        )
    return frozen_array(array)
