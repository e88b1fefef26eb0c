"""Quantities as people write them, one number and one unit such as ``210GPa``, in SI units."""

from __future__ import annotations

import contextlib
import math
import re
from decimal import Decimal
from typing import TypeAlias

# An example of each kind of quantity, by its SI unit; the empty one is that of plain numbers.
EXAMPLES = {"Pa": "100MPa", "m": "250um", "N": "2.5N", "rad": "30deg", "": "0.3", "J/m2": "50mJ/m2"}
_USUAL = {"Pa": "Pa, MPa or GPa", "m": "mm, um or nm", "N": "N or mN", "rad": "deg or rad", "J/m2": "mJ/m2 or J/m2"}
# Characters of a wrong text that are shown.
_SHOWN = 80
# A number with a decimal point, its exponent of at most three digits (float64 ends at 1e308), and a unit such as N or
# N/mm^2, of names of at most 30 letters.
_NAME = r"[^\W\d_²³]{1,30}(?:(?:\^|\*\*)?[1-4]|[²³])?"
_QUANTITY = re.compile(
    r"\s*([-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]{1,3})?)\s*" rf"({_NAME}(?:[*/]{_NAME}){{0,5}}|[%°]|)\s*"
)
_FACTOR = re.compile(r"([*/]?)([^\W\d_²³]+|[%°])(?:\^|\*\*)?([1-4²³]?)")
# What a power in the name of a unit means.
_POWERS = {"": 1, "²": 2, "³": 3}
# Powers of ten of the prefixes of SI; two letters look like mu.
_PREFIXES = {"f": -15, "p": -12, "n": -9, "u": -6, "µ": -6, "μ": -6, "m": -3, "c": -2, "d": -1}
_PREFIXES |= {"": 0, "h": 2, "k": 3, "M": 6, "G": 9, "T": 12}
Dimension: TypeAlias = tuple[int, int, int, int]
# Powers of metre, kilogram, second and radian.
_LENGTH = (1, 0, 0, 0)
_MASS = (0, 1, 0, 0)
_TIME = (0, 0, 1, 0)
_ANGLE = (0, 0, 0, 1)
# The same of forces, of pressures, of energies and of numbers.
_FORCE = (1, 1, -2, 0)
_PRESSURE = (-1, 1, -2, 0)
_ENERGY = (2, 1, -2, 0)
_NONE = (0, 0, 0, 0)
# Units that take a prefix: their power of ten in SI units.
_METRIC: dict[str, tuple[int, Dimension]] = {
    "m": (0, _LENGTH),
    "g": (-3, _MASS),
    "s": (0, _TIME),
    "N": (0, _FORCE),
    "J": (0, _ENERGY),
    "Pa": (0, _PRESSURE),
    "bar": (5, _PRESSURE),
    "rad": (0, _ANGLE),
}
# Units that take none: their value in SI units (NIST SP 811, appendix B).
_POUND = 4.4482216152605
_INCH = 0.0254
_OTHERS: dict[str, tuple[float, Dimension]] = {
    "Å": (1e-10, _LENGTH),
    "in": (_INCH, _LENGTH),
    "inch": (_INCH, _LENGTH),
    "kgf": (9.80665, _FORCE),
    "lbf": (_POUND, _FORCE),
    "psi": (_POUND / _INCH**2, _PRESSURE),
    "ksi": (1e3 * _POUND / _INCH**2, _PRESSURE),
    "atm": (101325.0, _PRESSURE),
    "deg": (math.pi / 180.0, _ANGLE),
    "°": (math.pi / 180.0, _ANGLE),
    "%": (1e-2, _NONE),
}


def parse_quantity(text: str, unit: str) -> float:
    """Return text such as ``100MPa``, one number and one unit, as a number in an SI unit of `EXAMPLES`.

    A number without a unit is accepted only where the quantity has no dimension: 210 may be Pa or GPa.

    Raises
    ------
    ValueError
        If it is something else, or of another dimension; the text says why, without a full stop.
    """
    found = _QUANTITY.fullmatch(text)
    if found is None:
        raise _refusal(text, f"is not one number with a decimal point{' and one unit' if unit else ''}", unit)
    if unit and not found[2]:
        raise _refusal(text, f"has no unit ({_USUAL[unit]}?)", unit)
    value = math.nan
    with contextlib.suppress(KeyError, ArithmeticError):
        factor, ten, dimension = _unit_of(found[2])
        if dimension == _unit_of(unit)[2]:
            # The float64 nearest to the decimal number: 250 um are 250e-6 m to the last bit.
            value = factor * float(f"{Decimal(found[1]).scaleb(ten)}")
    if not math.isfinite(value):
        raise _refusal(text, f"is not a quantity in units of {unit}" if unit else "is not a plain number", unit)
    return value


def _refusal(text: str, reason: str, unit: str) -> ValueError:
    return ValueError(f"{text[:_SHOWN]!r} {reason}; write it like {EXAMPLES[unit]}")


def _unit_of(name: str) -> tuple[float, int, Dimension]:
    """Return the value of a unit in SI units, a factor and a power of ten, and its dimension; `KeyError` if unknown."""
    factor = 1.0
    ten = 0
    total = [0, 0, 0, 0]
    for sign, one, power in _FACTOR.findall(name):
        exponent = (-1 if sign == "/" else 1) * (_POWERS.get(power) or int(power))
        value, prefix, dimension = _one_unit(one)
        factor = factor * value**exponent
        ten = ten + exponent * prefix
        total = [before + exponent * more for before, more in zip(total, dimension, strict=True)]
    return factor, ten, (total[0], total[1], total[2], total[3])


def _one_unit(name: str) -> tuple[float, int, Dimension]:
    if name in _OTHERS:
        value, dimension = _OTHERS[name]
        return value, 0, dimension
    for unit, (ten, dimension) in _METRIC.items():
        if name.endswith(unit) and name.removesuffix(unit) in _PREFIXES:
            return 1.0, _PREFIXES[name.removesuffix(unit)] + ten, dimension
    raise KeyError(name)
