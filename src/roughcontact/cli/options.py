"""The options of the commands."""

from __future__ import annotations

import argparse

from roughcontact.cli.units import quantity

_METRE, _PASCAL, _NEWTON, _ANGLE, _RATIO = (quantity(unit) for unit in ("m", "Pa", "N", "rad", "dimensionless"))


def add_output(parser: argparse.ArgumentParser, folder: str) -> None:
    """Declare where the results go."""
    parser.add_argument("-o", "--output", default=folder, metavar="FOLDER", help=f"where the results go ({folder})")


def add_load(parser: argparse.ArgumentParser) -> None:
    """Declare the load: exactly one of two."""
    load = parser.add_mutually_exclusive_group(required=True)
    load.add_argument("--pressure", type=_PASCAL, metavar="P", help="nominal mean pressure, such as 100MPa")
    load.add_argument("--approach", type=_METRE, metavar="D", help="approach since first touch, such as 50nm")
    load.add_argument("--force", type=_NEWTON, metavar="F", help="normal force, such as 2.5N")


def add_materials(parser: argparse.ArgumentParser) -> None:
    """Declare the materials of both bodies."""
    body = parser.add_argument_group("material of the body")
    body.add_argument("--young", type=_PASCAL, required=True, metavar="E", help="Young's modulus, such as 210GPa")
    body.add_argument("--poisson", type=_RATIO, default=0.3, metavar="NU", help="Poisson's ratio (0.3)")
    body.add_argument("--hardness", type=_PASCAL, metavar="H", help="pressure at which it flows, such as 6GPa")
    other = parser.add_argument_group("material of the other body")
    other.add_argument("--counter-young", type=_PASCAL, metavar="E", help="Young's modulus; rigid if left out")
    other.add_argument("--counter-poisson", type=_RATIO, metavar="NU", help="Poisson's ratio (the body's)")
    other.add_argument("--counter-hardness", type=_PASCAL, metavar="H", help="pressure at which it flows")


def add_surfaces(parser: argparse.ArgumentParser) -> None:
    """Declare the height maps and what is done to them."""
    parser.add_argument("surface", help="height map of the body: npz, npy, text, or an instrument's file")
    parser.add_argument("counter", nargs="?", help="height map of the other body; a flat if left out")
    maps = parser.add_argument_group("height maps")
    maps.add_argument("--size", type=_METRE, nargs="+", metavar="L", help="sides x [y] where the file does not tell")
    maps.add_argument("--unit", type=_METRE, metavar="U", help="unit of the heights, where the file does not tell: 1um")
    maps.add_argument(
        "--missing", choices=("refuse", "fill", "holes"), default="refuse", help="missing points (refuse)"
    )
    maps.add_argument(
        "--detrend",
        type=_form,
        metavar="FORM",
        help="take a form away: plane, sphere, or the degree of a polynomial (2 has curvature and twist)",
    )
    maps.add_argument("--resample", type=int, nargs=2, metavar=("NX", "NY"), help="bilinear, to so many cells")
    for name, what in (("size", _METRE), ("unit", _METRE), ("detrend", _form)):
        maps.add_argument(
            f"--counter-{name}",
            type=what,
            nargs="+" if name == "size" else None,
            metavar=name.upper(),
            help="the same for the other map, where it differs",
        )
    maps.add_argument("--ball", type=_METRE, metavar="R", help="add a sphere of this radius to the first map")
    pair = parser.add_argument_group("two maps of different grids, brought together where both lie")
    pair.add_argument(
        "--match",
        choices=("bilinear", "cubic", "fourier"),
        help="interpolate both on a common grid, as fine as the finer one or as --resample says",
    )
    pair.add_argument(
        "--offset", type=_place, metavar="X,Y", help="centre of the other map; if X is negative, --offset=-5um,2um"
    )
    pair.add_argument("--rotation", type=_ANGLE, metavar="A", help="of the other map, such as 30deg")
    pair.add_argument("--mirror", action="store_true", help="turn the other map over, x to -x")
    pair.add_argument("--domain", type=_METRE, nargs="+", metavar="L", help="sides x [y], if not the whole overlap")


def _place(text: str) -> tuple[float, float]:
    parts = text.split(",")
    if len(parts) != 2:
        raise argparse.ArgumentTypeError(f"{text!r} is no place; write it like 5um,-2um")
    return _METRE(parts[0]), _METRE(parts[1])


def _form(text: str) -> str | int:
    return int(text) if text.isdecimal() else text


def add_parts(parser: argparse.ArgumentParser) -> None:
    """Declare the parts of the problem that can be exchanged."""
    parts = parser.add_argument_group("parts")
    parts.add_argument("--boundary", choices=("free", "periodic", "wrapped"), default="free", help="(free)")
    parts.add_argument("--kernel", default="love", help="influence kernel (love)")
    parts.add_argument("--solver", default="auto", help="solver (auto)")


def add_area(parser: argparse.ArgumentParser) -> None:
    """Declare the area estimator of a single solve."""
    parser.add_argument("--area", metavar="ESTIMATOR", help="area estimator to report besides the default")


def add_comparison(parser: argparse.ArgumentParser) -> None:
    """Declare what a report compares."""
    compared = parser.add_argument_group("what is compared; every combination is solved")
    compared.add_argument(
        "--cells", type=int, nargs="+", metavar="N", help="cells along x (an eighth, a quarter, half and all)"
    )
    compared.add_argument("--areas", nargs="+", metavar="NAME", help="area estimators (blend cell-count)")
    compared.add_argument("--kernels", nargs="+", metavar="NAME", help="kernels (that of --kernel)")
    compared.add_argument("--solvers", nargs="+", metavar="NAME", help="solvers (that of --solver)")
    compared.add_argument("--tolerances", type=float, nargs="+", metavar="T", help="of the solvers (their own)")
    compared.add_argument(
        "--between",
        choices=("bilinear", "fourier", "mean"),
        default="bilinear",
        help="how maps go on between their points (bilinear)",
    )
    compared.add_argument("--repeats", type=int, default=3, metavar="R", help="how often each case is timed (3)")
