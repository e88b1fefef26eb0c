"""Options that several commands share, and quantities with units."""

from __future__ import annotations

import argparse
import math
import re
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache, partial
from typing import Any

_EXAMPLES = {"Pa": "100MPa", "m": "250um", "N": "2.5N", "rad": "30deg", "dimensionless": "0.3"}
# A number with a decimal point, its exponent of at most three digits (float64 ends at 1e308), and a unit such as N or
# N/mm^2, of names of at most 30 letters. pint alone evaluates whatever it is given, and takes 2,5 for 25.
_NAME = r"(?:[^\W\d_]{1,30}(?:(?:\^|\*\*)[1-4]|[²³])?)"
_QUANTITY = re.compile(
    r"\s*([-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]{1,3})?)\s*" rf"({_NAME}(?:[*/]{_NAME}){{0,5}}|[%°]|)\s*"
)
# Characters of a wrong argument that are shown.
_SHOWN = 80


def quantity(unit: str) -> Callable[[str], float]:
    """Return a converter from text such as ``100MPa``, one number and one unit, to a number in `unit`, for argparse.

    A number without a unit is accepted only where the quantity has no dimension: 210 may be Pa or GPa.
    """

    def convert(text: str) -> float:
        found = _QUANTITY.fullmatch(text)
        if found is None:
            one = "one number with a decimal point" + ("" if unit == "dimensionless" else " and one unit")
            raise argparse.ArgumentTypeError(f"{text[:_SHOWN]!r} is not {one}; write it like {_EXAMPLES[unit]}")
        try:
            if unit == "dimensionless" and not found[2]:
                value = float(found[1])
            else:
                given = _units().Quantity(float(found[1]), found[2])
                value = float(given.to(unit).magnitude) if _is_unit_of(given, unit) else math.nan
        # pint raises errors of many kinds, those of Python's tokenizer among them.
        except Exception:
            value = math.nan
        if not math.isfinite(value):
            what = f"a quantity in units of {unit}" if unit != "dimensionless" else "a plain number"
            raise argparse.ArgumentTypeError(f"{text[:_SHOWN]!r} is not {what}; write it like {_EXAMPLES[unit]}")
        return value

    return convert


def whole_number(text: str) -> int:
    """Return text such as ``256`` as an int, for argparse."""
    if not re.fullmatch(r"[-+]?[0-9]{1,18}", text):
        raise argparse.ArgumentTypeError(f"{text[:_SHOWN]!r} is not a whole number; write it like 256")
    return int(text)


def _is_unit_of(given: Any, unit: str) -> bool:
    # To pint radians are numbers: 20 may be degrees or radians, and Poisson's ratio is not an angle.
    return bool(given.to_root_units().units == _units().Quantity(1.0, unit).to_root_units().units)


@cache
def _units() -> Any:
    import pint

    return pint.UnitRegistry(autoconvert_offset_to_baseunit=True)


NUMBER = quantity("dimensionless")
_METRE, _PASCAL, _NEWTON, _ANGLE = (quantity(unit) for unit in ("m", "Pa", "N", "rad"))


@contextmanager
def show_progress(total: float) -> Iterator[Callable[..., None]]:
    """Show a progress bar on a terminal; the value changes its description and its completed part."""
    if not sys.stdout.isatty():
        # Before version 14, a disabled progress bar of rich prints an empty line.
        yield lambda **_: None
        return
    from rich.progress import Progress

    with Progress(transient=True) as progress:
        yield partial(progress.update, progress.add_task("solving", total=total))


def add_output(parser: argparse.ArgumentParser, folder: str) -> None:
    """Declare the output folder."""
    parser.add_argument("-o", "--output", default=folder, metavar="FOLDER", help=f"output folder ({folder})")


def add_problem(parser: argparse.ArgumentParser, *, study: bool = False) -> None:
    """Declare a contact problem of measured height maps, and its load; or a study file, which needs neither."""
    parser.usage = "%(prog)s MAP [MAP] --young E (--pressure P | --force F | --approach D) [options]"
    _add_maps(parser, study)
    _add_pair(parser)
    load = parser.add_argument_group("load, exactly one").add_mutually_exclusive_group(required=not study)
    load.add_argument("--pressure", type=_PASCAL, metavar="P", help="nominal mean pressure, such as 100MPa")
    load.add_argument("--force", type=_NEWTON, metavar="F", help="normal force, such as 2.5N")
    load.add_argument("--approach", type=_METRE, metavar="D", help="approach since first contact, such as 50nm")
    _add_materials(parser, study)
    method = parser.add_argument_group("method")
    method.add_argument(
        "--boundary", choices=("free", "periodic", "wrapped"), default="free", help="what lies beyond the domain (free)"
    )
    method.add_argument("--kernel", default="love", metavar="NAME", help="influence kernel (love)")
    method.add_argument("--solver", default="auto", metavar="NAME", help="solver (auto)")
    method.add_argument("--threads", type=_threads, default="auto", metavar="N", help="threads (as many as gain)")


def add_accuracy(parser: argparse.ArgumentParser) -> None:
    """Declare what a solve may aim at."""
    accuracy = parser.add_argument_group("accuracy, with 95 %")
    for name, what in (("area", "contact area"), ("peak", "maximum pressure")):
        accuracy.add_argument(
            f"--{name}-within", type=NUMBER, metavar="D", help=f"relative error of the {what}, such as 0.01 or 1%%"
        )
    accuracy.add_argument(
        "--tolerance", type=NUMBER, metavar="T", help="tolerance of the solver (as the accuracy needs)"
    )


def _add_materials(parser: argparse.ArgumentParser, study: bool) -> None:
    for prefix, body, poisson in (("", "body", "0.3"), ("counterbody-", "counterbody", "the body's")):
        group = parser.add_argument_group(f"material of the {body}")
        modulus = "Young's modulus, such as 210GPa" + (" (rigid)" if prefix else "")
        group.add_argument(f"--{prefix}young", type=_PASCAL, required=not (prefix or study), metavar="E", help=modulus)
        group.add_argument(f"--{prefix}poisson", type=NUMBER, metavar="NU", help=f"Poisson's ratio ({poisson})")
        group.add_argument(f"--{prefix}hardness", type=_PASCAL, metavar="H", help="hardness, such as 6GPa (elastic)")


def _add_maps(parser: argparse.ArgumentParser, study: bool) -> None:
    other = "; or a study file" if study else ""
    parser.add_argument("surface", help=f"height map of the body: npz, npy, text or instrument file{other}")
    parser.add_argument("counterbody", nargs="?", help="height map of the counterbody (a flat)")
    maps = parser.add_argument_group("height maps")
    maps.add_argument("--size", type=_METRE, nargs="+", metavar="L", help="side lengths, one or x y (the file's)")
    maps.add_argument("--unit", type=_METRE, metavar="U", help="unit of the heights, such as 1um (the file's)")
    treatments = ("refuse", "fill", "keep")
    maps.add_argument("--non-measured", choices=treatments, default="refuse", help="non-measured points (refuse)")
    maps.add_argument(
        "--detrend", type=_form, metavar="FORM", help="mean, plane, sphere or degree of a polynomial to subtract"
    )
    maps.add_argument(
        "--resample", type=whole_number, nargs=2, metavar=("NX", "NY"), help="number of cells, bilinearly"
    )
    for name, what in (("size", _METRE), ("unit", _METRE), ("detrend", _form)):
        maps.add_argument(
            f"--counterbody-{name}",
            type=what,
            nargs="+" if name == "size" else None,
            metavar=name.upper(),
            help=f"--{name} of the counterbody, if different",
        )
    maps.add_argument("--ball", type=_METRE, metavar="R", help="add a sphere of this radius to the body")


def _add_pair(parser: argparse.ArgumentParser) -> None:
    pair = parser.add_argument_group("two height maps on different grids")
    pair.add_argument(
        "--match",
        choices=("bilinear", "cubic", "fourier"),
        help="interpolate both on a common grid, as fine as the finer of the two or as --resample says",
    )
    pair.add_argument(
        "--offset", type=_place, metavar="X,Y", help="centre of the counterbody; if X is negative, --offset=-5um,2um"
    )
    pair.add_argument("--rotation", type=_ANGLE, metavar="A", help="rotation of the counterbody, such as 30deg")
    pair.add_argument("--mirror", action="store_true", help="turn the counterbody over, x to -x")
    pair.add_argument("--domain", type=_METRE, nargs="+", metavar="L", help="side lengths, one or x y (the overlap)")


def _place(text: str) -> tuple[float, float]:
    parts = text.split(",")
    if len(parts) != 2:
        raise argparse.ArgumentTypeError(f"{text!r} is not a position; write it like 5um,-2um")
    return _METRE(parts[0]), _METRE(parts[1])


def _threads(text: str) -> int | str:
    return text if text == "auto" else whole_number(text)


def _form(text: str) -> str | int:
    return whole_number(text) if text.isdecimal() else text
