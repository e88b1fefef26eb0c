"""Numbers with units as people give them: texts such as ``210GPa``, and quantities of packages for units."""

from __future__ import annotations

import contextlib
import math
import re
from collections.abc import Callable
from decimal import Decimal
from typing import Any, Protocol, TypeAlias, TypeGuard, runtime_checkable

from roughcontact.errors import InputError
from roughcontact.errors.door import guarded

# An example of each kind of quantity, by its SI unit; the empty one is that of plain numbers.
EXAMPLES = {"Pa": "100MPa", "m": "250um", "N": "2.5N", "rad": "30deg", "": "0.3", "J/m2": "50mJ/m2", "Pa s": "1mPa.s"}
EXAMPLES |= {"m2": "0.1mm2", "N/m": "1GN/m", "m3/s": "2mm3/s", "s": "10s", "m2/N": "1e-16m2/N", "m3/J": "1e-15m3/J"}
EXAMPLES |= {"m/s": "5m/s", "m2/s": "12mm2/s", "W/(m K)": "45W/m/K"}
# Of heat or of current, which a plain number leaves open.
EXAMPLES |= {"W/(m K) or S/m": "45W/m/K", "m2 K/W or Ohm m2": "1e-6m2*K/W", "W/K or S": "0.5W/K"}
# Units without which a number says too little.
_USUAL_UNITS = {
    "Pa": "Pa, MPa or GPa",
    "m": "mm, um or nm",
    "N": "N or mN",
    "rad": "deg or rad",
    "J/m2": "mJ/m2 or J/m2",
    "Pa s": "Pa.s or mPa.s",
    "m2": "mm2 or um2",
    "N/m": "N/m or GN/m",
    "m3/s": "m3/s or mm3/s",
    "s": "s, min or h",
    "m/s": "m/s or mm/s",
    "m2/s": "m2/s or mm2/s",
}
_USUAL_UNITS |= {"m2/N": "m2/N or mm2/N", "m3/J": "m3/J or mm3/J"}
# Characters of a wrong text that are shown.
_MAX_QUOTED_CHARACTERS = 80
# A number with a decimal point, its exponent of at most three digits (float64 ends at 1e308), and a unit such as N,
# N/mm^2 or W m-1 K-1, of names of at most 30 letters.
_UNIT_NAME = r"[^\W\d_¹²³]{1,30}(?:(?:\^|\*\*)?-?[1-4]|⁻?[¹²³])?"
_QUANTITY = re.compile(
    r"\s*([-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]{1,3})?)\s*"
    rf"({_UNIT_NAME}(?:[*/.· ]{_UNIT_NAME}){{0,5}}|[%°]|)\s*"
)
_UNIT_FACTOR = re.compile(r"([*/.· ]?)([^\W\d_¹²³]+|[%°])(?:\^|\*\*)?([-⁻]?)([1-4¹²³]?)")
# Factors in brackets, such as those of W/(m K).
_BRACKET = re.compile(r"(/?)\s*\(([^()/\d][^()/]*)\)")
# What a power in the name of a unit means.
_POWERS = {"": 1, "¹": 1, "²": 2, "³": 3}
# Powers of ten of the prefixes of SI; two letters look like mu.
_POWERS_OF_PREFIXES = {"f": -15, "p": -12, "n": -9, "u": -6, "µ": -6, "μ": -6, "m": -3, "c": -2, "d": -1}
_POWERS_OF_PREFIXES |= {"": 0, "h": 2, "k": 3, "M": 6, "G": 9, "T": 12}
Dimension: TypeAlias = tuple[int, int, int, int, int, int]
# Powers of metre, kilogram, second, radian, kelvin and ampere.
_LENGTH = (1, 0, 0, 0, 0, 0)
_MASS = (0, 1, 0, 0, 0, 0)
_TIME = (0, 0, 1, 0, 0, 0)
_ANGLE = (0, 0, 0, 1, 0, 0)
_TEMPERATURE = (0, 0, 0, 0, 1, 0)
# The same of forces, of pressures and of numbers.
_FORCE = (1, 1, -2, 0, 0, 0)
_ENERGY = (2, 1, -2, 0, 0, 0)
_POWER = (2, 1, -3, 0, 0, 0)
_PRESSURE = (-1, 1, -2, 0, 0, 0)
_RESISTANCE = (2, 1, -3, 0, 0, -2)
_CONDUCTANCE = (-2, -1, 3, 0, 0, 2)
_NO_DIMENSION = (0, 0, 0, 0, 0, 0)
# Units that take a prefix: their power of ten in SI units.
_METRIC_UNITS: dict[str, tuple[int, Dimension]] = {
    "m": (0, _LENGTH),
    "g": (-3, _MASS),
    "s": (0, _TIME),
    "N": (0, _FORCE),
    "J": (0, _ENERGY),
    "Pa": (0, _PRESSURE),
    "bar": (5, _PRESSURE),
    "rad": (0, _ANGLE),
    "W": (0, _POWER),
    "K": (0, _TEMPERATURE),
    "S": (0, _CONDUCTANCE),
    "Ohm": (0, _RESISTANCE),
    "ohm": (0, _RESISTANCE),
    "Ω": (0, _RESISTANCE),
    "\N{OHM SIGN}": (0, _RESISTANCE),
}
# Units that take none: their value in SI units (NIST SP 811, appendix B).
_POUND = 4.4482216152605
_INCH = 0.0254
_OTHER_UNITS: dict[str, tuple[float, Dimension]] = {
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
    "min": (60.0, _TIME),
    "h": (3600.0, _TIME),
    "%": (1e-2, _NO_DIMENSION),
}


def parse_quantity(text: str, unit: str) -> float:
    """Return a text such as ``100MPa``, one number and one unit, as a number in an SI unit of `EXAMPLES`.

    A number without a unit is accepted where the quantity has no dimension, or is one of heat or of current, such as
    ``"W/(m K) or S/m"``; nowhere else: 210 may be Pa or GPa. `ValueError` if it is something else, or of another
    dimension; its text says why, without a full stop.
    """
    found = _QUANTITY.fullmatch(_without_brackets(text))
    if found is None:
        raise _refusal(text, f"is not one number with a decimal point{' and one unit' if unit else ''}", unit)
    if unit in _USUAL_UNITS and not found[2]:
        raise _refusal(text, f"has no unit ({_USUAL_UNITS[unit]}?)", unit)
    value = math.nan
    with contextlib.suppress(KeyError, ArithmeticError):
        factor, ten, dimension = _unit_of(found[2])
        if not found[2] or dimension in [_unit_of(_without_brackets(one))[2] for one in unit.split(" or ")]:
            # The float64 nearest to the decimal number: 250 um are 250e-6 m to the last bit.
            value = factor * float(f"{Decimal(found[1]).scaleb(ten)}")
    if not math.isfinite(value):
        raise _refusal(text, f"is not a quantity in units of {unit}" if unit else "is not a plain number", unit)
    return value


@guarded
def quantity(unit: str) -> Callable[[str], float]:
    """Return a converter from text such as ``100MPa`` to a number in an SI unit, for argparse.

    Parameters
    ----------
    unit
        An SI unit such as ``"Pa"``, or ``""`` for a plain number.

    Examples
    --------
    >>> from roughcontact.typing import quantity
    >>> quantity("Pa")("100MPa")
    100000000.0
    """
    if unit not in EXAMPLES:
        raise InputError.unknown("unit of a quantity", unit, EXAMPLES)

    def convert(text: str) -> float:
        try:
            return parse_quantity(text, unit)
        except ValueError as error:
            # Nothing but a command line needs it.
            from argparse import ArgumentTypeError

            raise ArgumentTypeError(str(error)) from error

    return convert


@runtime_checkable
class HasUnit(Protocol):
    """A number or an array with a unit of its own, as packages for units have them: pint, and those that act as it."""

    @property
    def magnitude(self) -> Any:
        """The numbers, in the unit."""

    def __float__(self) -> float:
        """Return a number without a dimension; of another one it fails."""

    def to(self, other: Any, /) -> Any:
        """Return the same in another unit, or raise an error if its dimension is another one."""


def has_unit(value: object) -> TypeGuard[HasUnit]:
    """Return whether a value has a unit of its own."""
    return all(hasattr(type(value), name) for name in ("to", "to_base_units"))


def read_unit(value: HasUnit, unit: str) -> Any:
    """Return the numbers of a value with a unit of its own in an SI unit; `ValueError` if it has another dimension."""
    # What may stand behind a unit is an example.
    for one in unit.partition(",")[0].split(" or "):
        # Each package has errors of its own for another dimension, and for a unit that it does not know.
        with contextlib.suppress(Exception):
            name = re.sub(r"(?<=[a-z])(?=\d)", "**", one.replace("Ohm", "ohm"))
            return value.to(name or "dimensionless").magnitude
    raise _refusal(str(value), f"is not a quantity in units of {unit}" if unit else "is not a plain number", unit)


def _refusal(text: str, reason: str, unit: str) -> ValueError:
    # A plug-in may name a unit of its own.
    example = EXAMPLES.get(unit, EXAMPLES[""])
    return ValueError(f"{text[:_MAX_QUOTED_CHARACTERS]!r} {reason}; write it like {example}")


def _without_brackets(text: str) -> str:
    """Return a text with ``W/m/K`` for ``W/(m K)``."""
    return _BRACKET.sub(
        lambda found: found[1] + (re.sub(r"[*.· ]+", "/", found[2].strip()) if found[1] else found[2]), text
    )


def _unit_of(name: str) -> tuple[float, int, Dimension]:
    """Return factor, power of ten and dimension of a unit in SI units; `KeyError` if it is not known."""
    factor = 1.0
    ten = 0
    total = [0] * len(_NO_DIMENSION)
    for sign, one, inverse, power in _UNIT_FACTOR.findall(name):
        exponent = (-1 if (sign == "/") != bool(inverse) else 1) * (_POWERS.get(power) or int(power))
        value, prefix, dimension = _one_unit(one)
        factor = factor * value**exponent
        ten = ten + exponent * prefix
        total = [before + exponent * more for before, more in zip(total, dimension, strict=True)]
    return factor, ten, (total[0], total[1], total[2], total[3], total[4], total[5])


def _one_unit(name: str) -> tuple[float, int, Dimension]:
    if name in _OTHER_UNITS:
        value, dimension = _OTHER_UNITS[name]
        return value, 0, dimension
    for unit, (ten, dimension) in _METRIC_UNITS.items():
        if name.endswith(unit) and name.removesuffix(unit) in _POWERS_OF_PREFIXES:
            return 1.0, _POWERS_OF_PREFIXES[name.removesuffix(unit)] + ten, dimension
    raise KeyError(name)
