"""Numbers with SI prefixes, for people to read."""

from __future__ import annotations

import math

_PREFIXES = {-15: "f", -12: "p", -9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G", 12: "T", 15: "P"}


def si(value: float, unit: str, digits: int = 4) -> str:
    """Return `value` in words such as ``12.5 µm``, with so many significant digits."""
    if value == 0.0 or not math.isfinite(value):
        return f"{value:g} {unit}"
    power = 3 * math.floor(math.log10(abs(value)) / 3 + 1e-9)
    if power not in _PREFIXES:
        return f"{value:.{digits}g} {unit}"
    return f"{value / 10.0**power:.{digits}g} {_PREFIXES[power]}{unit}"


def binary(size: float) -> str:
    """Return a number of bytes in words such as ``1.5 GiB``."""
    power = min(max(0, int(size).bit_length() - 1) // 10, 4)
    return f"{size / 2 ** (10 * power):.4g} {('bytes', 'KiB', 'MiB', 'GiB', 'TiB')[power]}"
