"""Checks of input values, each of which returns the clean value or raises an `InputError`; fields that take texts."""

from __future__ import annotations

import contextlib
import inspect
import math
import mmap
import os
import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

import attrs
import numpy as np
import numpy.typing as npt

from roughcontact._base.arrays import Array, Pair, RealArray, frozen_array
from roughcontact._base.units import EXAMPLES, Quantity, has_unit, parse_quantity, read_unit
from roughcontact.errors import InputError, NoSuchItem
from roughcontact.errors.door import outside

T = TypeVar("T")
# Magnitudes of quantities in SI units; products of a few of them stay within float64.
MIN_MAGNITUDE = 1e-60
MAX_MAGNITUDE = 1e60
# The text of an infinite number; and texts that may be numbers: digits, inf or nan behind a sign, if any.
INFINITE = "inf"
_NUMBER_LIKE = re.compile(r"\s*[-+.]*(?:[0-9]|inf|nan)", re.IGNORECASE)
# Characters of a path: PATH_MAX of Linux, the largest of the systems.
_MAX_PATH_CHARACTERS = 4096


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
        The value given by the user: a number in SI units, a text with a unit such as ``"210GPa"``, or a quantity.
    what, unit
        The name of the quantity and its SI unit, for the sentence.
    above, at_least, at_most
        Bounds: exclusive lower, inclusive lower, inclusive upper.

    Raises
    ------
    InputError
        If `value` is not a real finite number or is out of bounds.
    """
    bounds = [
        f"above {above:g}" if above is not None else "",
        f"at least {at_least:g}" if at_least is not None else "",
        f"at most {at_most:g}" if at_most is not None else "",
    ]
    limits = " and ".join(filter(None, bounds))
    allowed = "a finite number" + (f", {limits}" if limits else "") + (f" ({unit})" if unit else "")
    if has_unit(value):
        value = without_unit(value, what, unit)
    if isinstance(value, str) and unit and unit in EXAMPLES:
        with contextlib.suppress(ValueError):
            value = parse_quantity(value, unit)
    kind = getattr(getattr(value, "dtype", None), "kind", "f")
    if kind not in "fiu" or isinstance(value, (bool, complex)) or not hasattr(value, "__float__"):
        raise InputError.about(what, value, allowed)
    try:
        result = math.nan if np.ma.is_masked(value) or np.ndim(value) else float(value)  # type: ignore[arg-type]
    # A class of the user may raise anything.
    except Exception:
        raise InputError.about(what, value, allowed) from None
    inside = (
        math.isfinite(result)
        and (above is None or result > above)
        and (at_least is None or result >= at_least)
        and (at_most is None or result <= at_most)
    )
    if not inside:
        raise InputError.about(what, value, allowed)
    if abs(result) > MAX_MAGNITUDE or (above == 0.0 and result < MIN_MAGNITUDE):
        allowed = f"between {MIN_MAGNITUDE:g} and {MAX_MAGNITUDE:g} in magnitude"
        raise InputError.about(what, result, allowed, "Check its unit.")
    return result


def without_unit(value: object, what: str, unit: str) -> Any:
    """Return the numbers of a quantity of pint, or of a list of them, in an SI unit; anything else as it is.

    `InputError` if it is of another dimension.
    """
    if isinstance(value, (list, tuple)) and any(map(has_unit, value)):
        read = [without_unit(one, what, unit) for one in value]
        return tuple(read) if isinstance(value, tuple) else read
    if not has_unit(value):
        return value
    try:
        return read_unit(value, unit)
    except ValueError as error:
        raise InputError(f"{what}: {error}.") from error


def number_or_array(value: object, what: str, unit: str = "", *, zero: bool = False) -> float | Array:
    """Return a number above zero, or a read-only array (nx, ny) of such numbers, or raise `InputError`.

    Parameters
    ----------
    value
        A number in SI units, a text with a unit, or an array of numbers.
    what, unit
        The name of the quantity and its SI unit, for the sentence.
    zero
        Whether zero is allowed.
    """
    bound = "at least 0" if zero else "above 0"
    value = without_unit(value, what, unit)
    if isinstance(value, str) and unit:
        try:
            value = parse_quantity(value, unit)
        except ValueError as error:
            raise InputError(f"{what}: {error}.") from error
    if not isinstance(value, (list, tuple)) and np.ndim(value) == 0:  # type: ignore[arg-type]
        return number(value, what, unit, **({"at_least": 0.0} if zero else {"above": 0.0}))
    try:
        array = np.array(value)
    except ValueError:
        array = np.empty(0)
    is_real = array.ndim == 2 and array.size > 0 and array.dtype.kind in "fiu" and not np.ma.is_masked(value)
    lowest = 0.0 if zero else MIN_MAGNITUDE
    if not (is_real and array.min() >= lowest and array.max() <= MAX_MAGNITUDE):
        raise InputError.about(what, value, f"a number or an array (nx, ny), finite and {bound} ({unit or 'no unit'})")
    return frozen_array(array)


def integer(value: object, what: str, *, at_least: int) -> int:
    """Return `value` as an int of at least `at_least`, or raise `InputError`."""
    allowed = f"a whole number of at least {at_least}"
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or value < at_least:
        raise InputError.about(what, value, allowed)
    return int(value)


def axis(value: object, what: str) -> int:
    """Return `value` as 0 or 1, an axis of the plane, or raise `InputError`."""
    found = integer(value, what, at_least=0)
    if found > 1:
        raise InputError.about(what, value, "0 (along x) or 1 (along y)")
    return found


def item_of(items: tuple[T, ...], index: object, what: str) -> T | tuple[T, ...]:
    """Return the item at a position, or the items of a slice, or raise `InputError`."""
    if isinstance(index, slice):
        try:
            chosen = items[index]
        except (TypeError, ValueError):
            chosen = ()
        if not chosen:
            raise InputError.about(what, index, f"a slice of at least one of {len(items)}")
        return chosen
    whole = isinstance(index, (int, np.integer)) and not isinstance(index, bool)
    if not (whole and -len(items) <= index < len(items)):  # type: ignore[operator]
        error = NoSuchItem if whole else InputError
        raise error.about(what, index, f"a whole number from 0 to {len(items) - 1}, or a slice")
    return items[int(index)]  # type: ignore[call-overload]


def flag(value: object, what: str) -> bool:
    """Return `value` as a bool, or raise `InputError` if it is something else."""
    if not isinstance(value, (bool, np.bool_)):
        raise InputError.about(what, value, "True or False")
    return bool(value)


def pair(
    value: Quantity | Sequence[Quantity],
    what: str,
    unit: str = "",
    *,
    above: float | None = None,
    at_least: float | None = None,
) -> Pair:
    """Return one value or two as an (x, y) pair of finite floats, or raise `InputError`."""
    plain = without_unit(value, what, unit)
    is_list = isinstance(plain, (tuple, list)) or (isinstance(plain, np.ndarray) and plain.ndim > 0)
    items: list[Any] = list(plain) if is_list else [plain, plain]
    if len(items) != 2:
        raise InputError.about(what, value, f"one value or two, (x, y) ({unit or 'no unit'})")
    x, y = (number(item, what, unit, above=above, at_least=at_least) for item in items)
    return x, y


def list_of(values: object, what: str, allowed: str, advice: str = "") -> tuple[Any, ...]:
    """Return the items of a list, or raise `InputError`, with advice, if it is something else, such as a text."""
    items: tuple[Any, ...] | None
    try:
        items = None if isinstance(values, (str, bytes)) else tuple(values)  # type: ignore[arg-type]
    except Exception:
        items = None
    if items is None:
        raise InputError.about(what, values, allowed, advice)
    return items


def choice(value: object, what: str, allowed: Sequence[str]) -> str:
    """Return `value` if it is one of the words in `allowed`, or raise `InputError`."""
    if not isinstance(value, str) or value not in allowed:
        words = ", ".join(repr(word) for word in allowed)
        raise InputError.about(what, value, f"one of {words}")
    return str(value)


def instance_of(base: type, what: str, allowed: str) -> Callable[[Any, Any, Any], None]:
    """Return an attrs validator that requires an instance of `base`; `what` and `allowed` are for the message."""

    def check(_: Any, __: Any, value: Any) -> None:
        if not isinstance(value, base):
            raise InputError.about(what, value, allowed)

    return check


def path(value: object, what: str) -> Path:
    """Return a text or a path as a `Path` of admissible length, or raise `InputError`."""
    if not isinstance(value, (str, os.PathLike)):
        raise InputError.about(what, value, "a str or a path")
    name = os.fspath(value)
    if not isinstance(name, str) or not 0 < len(name) <= _MAX_PATH_CHARACTERS or "\0" in name:
        raise InputError.about(
            what, name, f"a path of 1 to {_MAX_PATH_CHARACTERS} characters, without the character NUL"
        )
    return Path(name)


def callback(value: object, what: str, *given: str) -> Callable[..., Any] | None:
    """Return a user's function of the arguments `given`, wrapped so that its errors stay as they are, or None."""
    if value is None:
        return None
    allowed = f"a function of {len(given)} argument{'s'[: len(given) > 1]}, {', '.join(given)}"
    if not callable(value):
        raise InputError.about(what, value, allowed)
    try:
        inspect.signature(value).bind(*given)
    except TypeError:
        raise InputError.about(what, value, allowed) from None
    # Functions written in C have no signature.
    except ValueError:
        pass
    return outside(value)


def numbers(values: object, what: str, allowed: str, unit: str = "") -> Array:
    """Return `values` as an array of float64, or raise `InputError` if it is something else.

    Quantities of pint are read in the unit, without one as plain numbers.
    """
    values = without_unit(values, what, unit)
    try:
        # numpy would omit an imaginary part, with a warning, and read texts and times as numbers.
        if np.asarray(values).dtype.kind not in "biufO":
            raise TypeError
        return np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError, OverflowError, RecursionError):
        raise InputError.about(what, values, allowed) from None


def returned_array(values: object, shape: tuple[int, ...], source: str, what: str = "an array") -> RealArray:
    """Return what a part of a plug-in returned as an array; `InputError` unless it holds real numbers of a shape."""
    array = np.asarray(values)
    if array.shape != shape or array.dtype.kind != "f":
        raise InputError(
            f"{source} returned {what} of shape {array.shape} and type {array.dtype}, where real numbers of shape "
            f"{shape} are needed."
        )
    return array


def _is_mapped(values: object) -> bool:
    """Return whether values belong to a file that is mapped read-only, as by ``mmap_mode="r"`` of numpy."""
    mapped = False
    while isinstance(values, np.ndarray) and not values.flags.writeable:
        mapped = mapped or isinstance(values, np.memmap)
        values = values.base
    return mapped and isinstance(values, mmap.mmap)


def is_labelled(value: object) -> bool:
    """Return whether a value is an array with named axes, as of xarray."""
    return all(hasattr(type(value), name) for name in ("dims", "coords", "attrs"))


def measured_heights(values: npt.ArrayLike) -> Array:
    """Return `heights_array` of heights that may be NaN or masked, but not everywhere."""
    return heights_array(values, nan=True)


def heights_array(values: npt.ArrayLike, *, nan: bool = False) -> Array:
    """Return a read-only copy of a height map after checking it; a map of a file on disk is not copied.

    `InputError` if the array is not two-dimensional, holds fewer than two cells, no numbers, or values that are not
    finite (missing points of a measurement, usually).
    """
    what = "The height map"
    if is_labelled(values):
        raise InputError(
            "The height map is an array with named axes: read_surface takes it with its axes, size and units. Give "
            "its values, indexed [x, y] and in m, to use them alone."
        )
    values = without_unit(values, what, "m")
    if isinstance(values, np.ma.MaskedArray) and np.ma.is_masked(values):
        values = np.ma.filled(np.ma.asarray(values, dtype=np.float64), np.nan)
    try:
        array = np.asarray(values) if _is_mapped(values) else np.array(values)
    except ValueError:
        raise InputError(f"{what} must be a rectangular array, but its rows differ in length.") from None
    if array.dtype.kind not in "fiu":
        raise InputError.about(what, array, "an array of real numbers (m)")
    if array.ndim != 2 or array.size < 2:
        raise InputError.about(what, array.shape, "a two-dimensional array [x, y] of at least two cells")
    array = np.ascontiguousarray(array, dtype=np.float64)
    low = float(array.min())
    high = float(array.max())
    if nan and math.isnan(low):
        measured = array[~np.isnan(array)]
        if not measured.size:
            raise InputError("No point of the height map was measured: at least one is needed.")
        low = float(measured.min())
        high = float(measured.max())
    if not (math.isfinite(low) and math.isfinite(high)):
        missing = array.size - int(np.count_nonzero(np.isfinite(array)))
        raise InputError(
            f"{what} must be finite everywhere, but {missing} of {array.size} points are NaN or infinite. "
            "Fill them first, for instance with read_surface(path, non_measured='fill')."
        )
    if max(high, -low) > MAX_MAGNITUDE:
        raise InputError(f"{what} must hold heights of at most {MAX_MAGNITUDE:g} m: check the unit.")
    return frozen_array(array)


class Part:
    """A class whose fields may be given as texts with a unit, as in study files and on the command line.

    All bases of parts derive from it. A field of an attrs class takes such texts if its metadata have ``unit``, the SI
    unit of the number (empty for a number without one), or ``plain_unit``, a unit that texts may omit. A converter of
    the field gets the number. With ``infinite`` it takes ``"inf"``.

    Examples
    --------
    >>> import attrs
    >>> import roughcontact as rc
    >>> @attrs.frozen
    ... class Coating(rc.typing.Part):
    ...     thickness: float = attrs.field(metadata={"unit": "m"})
    >>> print(Coating("2 um"))
    Coating(thickness=2e-06)
    """

    __slots__ = ()

    def __init_subclass__(cls, **others: Any) -> None:
        super().__init_subclass__(**others)
        # Fields are seen here before the decorator of attrs has made them; a class with slots is made once more.
        for name, field in list(vars(cls).items()):
            metadata = getattr(field, "metadata", None)
            if not isinstance(metadata, Mapping) or not hasattr(field, "_validator"):
                continue
            unit = metadata.get("unit", metadata.get("plain_unit"))
            if isinstance(unit, str):
                reader = _TextReader(f"The field {name} of {cls.__name__}", unit, bool(metadata.get("infinite")))
                field.converter = _before(reader, field.converter)


@attrs.frozen
class _TextReader:
    """Reads the texts of a field, what a sentence calls it, in a unit; whether it may be infinite, ``"inf"``."""

    what: str
    unit: str
    is_infinite: bool

    def read(self, value: Any, *, is_word: bool) -> Any:
        """Return a value with its texts, also those in lists, as numbers in SI units; words may be kept."""
        value = without_unit(value, self.what, self.unit)
        if isinstance(value, (list, tuple)) and any(isinstance(one, str) for one in value):
            return type(value)(self.read(one, is_word=False) for one in value)
        if not isinstance(value, str):
            return value
        if self.is_infinite and value.strip() == INFINITE:
            return math.inf
        try:
            return parse_quantity(value, self.unit)
        except ValueError as error:
            if is_word and not _NUMBER_LIKE.match(value):
                return value
            raise InputError(f"{self.what}: {error}.") from error


def _ask_own(own: Callable[[Any], Any], value: Any) -> None:
    """Raise the `InputError` of a converter for a wrong value, if it has one."""
    try:
        own(value)
    except InputError:
        raise
    # It is of a plug-in; a wrong text is refused anyhow.
    except Exception:
        return


def _before(reader: _TextReader, own: Any) -> Any:
    """Return a converter that reads texts, and then calls the field's own converter, if there is one.

    That one gets words, such as ``"auto"``, and may refuse a wrong text in its own words.
    """
    if isinstance(own, attrs.Converter):
        return attrs.converters.pipe(lambda value: reader.read(value, is_word=True), own)

    def convert(value: Any) -> Any:
        if own is None:
            return reader.read(value, is_word=False)
        try:
            read = reader.read(value, is_word=True)
        except InputError as refusal:
            _ask_own(own, value)
            raise refusal from None
        return own(read)

    return convert
