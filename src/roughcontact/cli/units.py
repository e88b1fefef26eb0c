"""Quantities with units on the command line."""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable
from functools import cache
from typing import Any


@cache
def _registry() -> Any:
    import pint

    return pint.UnitRegistry(autoconvert_offset_to_baseunit=True)


def quantity(unit: str) -> Callable[[str], float]:
    """Return a converter from text such as ``100MPa`` to a number in `unit`, for argparse.

    A number alone is taken only where the quantity has no dimension: 210 may be Pa or GPa.
    """
    example = {"Pa": "100MPa", "m": "250um", "N": "2.5N", "rad": "30deg"}.get(unit, "0.3")

    def convert(text: str) -> float:
        # An angle without a unit is a number to pint: 20 may be degrees or radians.
        bare = unit == "rad" and not re.search(r"[a-z°]", text)
        if bare or not re.match(r"\s*[-+.]?\d", text):
            raise argparse.ArgumentTypeError(f"{text!r} is no number with a unit; write it like {example}")
        try:
            value = _registry().Quantity(text)
        # Whatever pint's tokenizer chokes on is no quantity.
        except Exception:
            raise argparse.ArgumentTypeError(f"{text!r} is no number with a unit; write it like {example}") from None
        try:
            return float(value.to(unit).magnitude)
        except Exception:
            raise argparse.ArgumentTypeError(f"{text!r} has not the unit it needs; write it like {example}") from None

    return convert
