"""Quantities with units on the command line."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from functools import cache
from typing import Any


@cache
def _registry() -> Any:
    import pint

    return pint.UnitRegistry(autoconvert_offset_to_baseunit=True)


def quantity(unit: str) -> Callable[[str], float]:
    """Return a converter from text such as ``100MPa`` to a number in `unit`, for argparse.

    A number without a unit is taken in `unit`.
    """

    def convert(text: str) -> float:
        import pint

        try:
            return float(text)
        except ValueError:
            pass
        try:
            return float(_registry().Quantity(text).to(unit).magnitude)
        except pint.DimensionalityError:
            raise argparse.ArgumentTypeError(f"{text!r} is no quantity in {unit}") from None
        # Whatever pint's tokenizer chokes on is no quantity.
        except Exception:
            raise argparse.ArgumentTypeError(
                f"{text!r} is no number with a unit; write it like 100{'' if unit == 'Pa' else ' '}M{unit}"
                if unit == "Pa"
                else f"{text!r} is no number with a unit; write it like 10 {unit}"
            ) from None

    return convert
