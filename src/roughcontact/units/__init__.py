"""Numbers with SI prefixes and uncertainties, for people to read."""

from __future__ import annotations

import math
import re

import attrs

_PREFIXES = {-15: "f", -12: "p", -9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G", 12: "T", 15: "P"}
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


def binary(size: float) -> str:
    """Return a number of bytes in words such as ``1.5 GiB``."""
    power = min(max(0, int(size).bit_length() - 1) // 10, 4)
    return f"{size / 2 ** (10 * power):.4g} {('bytes', 'KiB', 'MiB', 'GiB', 'TiB')[power]}"


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
