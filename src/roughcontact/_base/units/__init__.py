"""Numbers with SI prefixes and uncertainties, and texts, for people to read."""

from __future__ import annotations

import math
import re
from typing import Any

import attrs
import numpy as np

from roughcontact.errors.door import guarded

_PREFIXES = {-15: "f", -12: "p", -9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G", 12: "T", 15: "P"}
# Areas and volumes, whose prefix is raised to the power behind it; and units with another power or an inverse.
_AREA_OR_VOLUME = re.compile(r"m([23])\b")
_POWER = re.compile(r"[^\W\d]+\d|1/")

# Decimals beyond which a number is written with an exponent.
_DECIMALS = 9
_RAISED = {1: "", 2: "²", 3: "³"}


@guarded
def si(value: float, unit: str, digits: int = 4) -> str:
    """Return `value` in words such as ``12.5 µm`` or ``360 µm2``, with so many significant digits."""
    if value == 0.0 or not math.isfinite(value):
        return f"{value:g} {unit}"
    raised = _AREA_OR_VOLUME.match(unit)
    order = int(raised[1]) if raised else 1
    # Areas have 0.01 to 10000 of their unit and volumes 0.001 to a million, as people write them.
    shift = order if raised else 0
    power = 3 * math.floor((math.log10(abs(value)) + shift) / (3 * order) + 1e-9)
    if power not in _PREFIXES or (raised and power > 0) or (has_power(unit) and not raised):
        return f"{value:.{digits}g} {unit}"
    rounded = float(f"{value / 10.0 ** (order * power):.{digits}g}")
    return f"{rounded:.{max(digits, 3 * order)}g} {_PREFIXES[power]}{unit}"


def has_power(unit: str) -> bool:
    """Tell whether a unit begins with a power or an inverse, such as ``m3/s``, so that a prefix would be misread."""
    return _POWER.match(unit) is not None


def with_spread(value: float, uncertainty: float) -> str:
    """Return a number and its uncertainty, of two digits, in words such as ``(1.142 +- 0.012)``."""
    if not (uncertainty > 0.0 and math.isfinite(value) and math.isfinite(uncertainty)):
        return f"{value:.5g}"
    decimals = 1 - math.floor(math.log10(uncertainty))
    if abs(decimals) > _DECIMALS:
        return f"({value:.5g} +- {uncertainty:.2g})"
    texts = (f"{round(number, decimals):.{max(0, decimals)}f}" for number in (value, uncertainty))
    return f"({' +- '.join(texts)})"


class PlainText(str):
    """A text that a notebook and the interpreter show as it prints, line by line."""

    __slots__ = ()

    def __repr__(self) -> str:
        return str(self)


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
        # An area of 0.5 µm² is not 500000 nm².
        thousands = 3 * math.floor((math.log10(largest) + 2 * (power - 1)) / (3 * power) + 1e-9)
    exponent = min(max(thousands, min(_PREFIXES)), max(_PREFIXES))
    return 10.0 ** (-exponent * power), f"{_PREFIXES[exponent]}{unit}{_RAISED[power]}"


@guarded
def binary(size: float) -> str:
    """Return a number of bytes in words such as ``1.5 GiB``."""
    power = min(max(0, int(size).bit_length() - 1) // 10, 4)
    return f"{size / 2 ** (10 * power):.4g} {('bytes', 'KiB', 'MiB', 'GiB', 'TiB')[power]}"


def counted(count: int, what: str) -> str:
    """Return a number of things in words such as ``1 load`` and ``2 loads``."""
    return f"{count} {what}{'' if count == 1 else 's'}"


def outlined(value: Any) -> str:
    """Return a field of a result for its `repr`: an array as ``<8 x 8 float64>``."""
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

    Examples
    --------
    >>> import roughcontact as rc
    >>> stiffness = rc.Estimate(12.3e6, 0.2e6, "N/m")
    >>> print(stiffness)
    12.3 MN/m +- 1.6 %
    """

    value: float
    uncertainty: float
    unit: str
    warnings: tuple[str, ...] = ()

    @property
    def _reasons(self) -> str:
        """Why the value must not be trusted, at the end of a line."""
        return "".join(f"; uncertain: {warning}" for warning in self.warnings)

    def __str__(self) -> str:
        if not self.unit:
            return f"{self.value:.6g} +- {self.uncertainty:.2g}{self._reasons}"
        if math.isinf(self.value):
            return f"{si(self.value, self.unit)}{self._reasons}"
        relative = (
            f"{100 * self.uncertainty / abs(self.value):.2g} %" if self.value else si(self.uncertainty, self.unit)
        )
        return f"{si(self.value, self.unit, 5)} +- {relative}{self._reasons}"
