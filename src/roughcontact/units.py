"""Numbers with SI prefixes and uncertainties, for people to read."""

from __future__ import annotations

import math
import re
from typing import Any

import attrs
import numpy as np

_PREFIXES = {-15: "f", -12: "p", -9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G", 12: "T", 15: "P"}
_RAISED = {1: "", 2: "²", 3: "³"}
# Units that begin with a power or an inverse, such as m2 or 1/m.
_POWER = re.compile(r"[^\W\d]+\d|1/")


def si(value: float, unit: str, digits: int = 4) -> str:
    """Return `value` in words such as ``12.5 µm``, with so many significant digits."""
    if value == 0.0 or not math.isfinite(value):
        return f"{value:g} {unit}"
    power = 3 * math.floor(math.log10(abs(value)) / 3 + 1e-9)
    # A prefix would be raised to the power of the unit behind it.
    if power not in _PREFIXES or _POWER.match(unit):
        return f"{value:.{digits}g} {unit}"
    return f"{value / 10.0**power:.{digits}g} {_PREFIXES[power]}{unit}"


def prefixed(largest: float, unit: str, power: int = 1) -> tuple[float, str]:
    """Return the unit with the prefix that suits numbers up to `largest`, and what they are multiplied by for it.

    Parameters
    ----------
    largest
        Largest magnitude among the numbers, in the SI unit raised to the power.
    unit, power
        SI unit and the power that it is raised to, such as ``"m"`` and 2 for areas.
    """
    thousands = 0
    if 0.0 < largest < math.inf:
        thousands = 3 * math.floor(math.log10(largest) / (3 * power) + 1e-9)
    exponent = min(max(thousands, min(_PREFIXES)), max(_PREFIXES))
    return 10.0 ** (-exponent * power), f"{_PREFIXES[exponent]}{unit}{_RAISED[power]}"


def binary(size: float) -> str:
    """Return a number of bytes in words such as ``1.5 GiB``."""
    power = min(max(0, int(size).bit_length() - 1) // 10, 4)
    return f"{size / 2 ** (10 * power):.4g} {('bytes', 'KiB', 'MiB', 'GiB', 'TiB')[power]}"


def counted(count: int, what: str) -> str:
    """Return a number of things in words such as ``1 load`` and ``2 loads``."""
    return f"{count} {what}{'' if count == 1 else 's'}"


def outlined(value: Any) -> str:
    """Return an array in words such as ``<8 x 8 float64>``, and anything else as `repr` does."""
    if isinstance(value, np.ndarray):
        return f"<{' x '.join(map(str, value.shape))} {value.dtype}>" if value.ndim else repr(value.item())
    return repr(value)


@attrs.frozen
class Estimate:
    """A number with its uncertainty.

    Attributes
    ----------
    value
        The number, in the unit.
    uncertainty
        One standard deviation: the true value should lie within two of them.
    unit
        SI unit; empty for a count.
    warnings
        Why the value must not be trusted, in sentences; empty without a reason.
    """

    value: float
    uncertainty: float
    unit: str
    warnings: tuple[str, ...] = ()

    def __str__(self) -> str:
        doubtful = "".join(f"; doubtful: {warning}" for warning in self.warnings)
        if not self.unit:
            return f"{self.value:.6g} +- {self.uncertainty:.2g}{doubtful}"
        relative = (
            f"{100 * self.uncertainty / abs(self.value):.2g} %" if self.value else si(self.uncertainty, self.unit)
        )
        return f"{si(self.value, self.unit, 5)} +- {relative}{doubtful}"
