"""What the headers of text files say, in the form in which Gwyddion writes them."""

from __future__ import annotations

import re
from collections.abc import Sequence

import attrs

from roughcontact._base.checks import Pair
from roughcontact.errors import InputError

# "# Width: 10.0 µm", "# Height: 5.0 µm", "# Value units: nm".
_SIDE = re.compile(r"#?\s*(Width|Height):\s*([0-9]{1,30}(?:[.,][0-9]{1,30})?(?:e[-+]?[0-9]{1,3})?)\s*(\S{1,8})\s*")
_VALUES = re.compile(r"#?\s*Value units:\s*(\S{1,20})\s*")
# Metres in units of length; the two letters for micro, and the byte that it is in Latin-1, read as UTF-8.
_METRES = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "nm": 1e-9, "pm": 1e-12, "Å": 1e-10}
_METRES |= {"micron": 1e-6, "microns": 1e-6, "inch": 0.0254}
_MICRO = str.maketrans({"µ": "u", "μ": "u", "\udcb5": "u"})


def metres(unit: str) -> float | None:
    """Return how long a unit such as µm is, m; None if it is not a length that is known."""
    return _METRES.get(unit.translate(_MICRO))


@attrs.frozen
class Stated:
    """Sides (x, y) of an image, m, and the unit of its heights, m; None where a header does not state them."""

    size: Pair | None
    unit: float | None


def read_header(lines: Sequence[str]) -> Stated:
    """Return what a header states.

    Raises
    ------
    InputError
        If its values are not lengths.
    """
    sides = {}
    unit = None
    for line in lines:
        if found := _SIDE.fullmatch(line):
            length = metres(found[3])
            sides[found[1]] = None if length is None else float(found[2].replace(",", ".")) * length
        elif found := _VALUES.fullmatch(line):
            unit = metres(found[1])
            if unit is None:
                raise InputError(f"its header states values in {found[1]!a}, which is not a known unit of length")
    width = sides.get("Width")
    height = sides.get("Height")
    return Stated((width, height) if width and height else None, unit)
