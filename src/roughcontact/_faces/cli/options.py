"""Options that several commands share, converters of their texts, and sentences in the words of the command line."""

from __future__ import annotations

import argparse
import contextlib
import math
import re
from collections.abc import Callable, Collection, Iterable
from types import NoneType
from typing import Any, get_args

import numpy as np

from roughcontact._answers.laws import MAX_LOAD_RATIO, space_separations
from roughcontact._base.checks import INFINITE
from roughcontact._base.registry import PartField
from roughcontact._base.units import EXAMPLES, parse_quantity, quantity, si
from roughcontact._faces.cli.help import add_group, leave_to, show
from roughcontact._parts.files import list_reader_options
from roughcontact._parts.grid import Boundary, Load
from roughcontact._parts.materials import TYPICAL, materials
from roughcontact.errors import Argument, InputError, Spell, write_number

# Arguments that are not options of their own names.
_SPELLED = {"displacement": "displacements to --tangential", "tangential_force": "forces to --tangential"}
# Arguments with several parts, each of which is given by an option of its own.
_GIVEN_ONE_BY_ONE = {"laws": "law"}
# Most characters of a wrong argument that are shown.
_MAX_SHOWN_CHARACTERS = 80
# Most loads of a range.
_MAX_LOADS = 200


def spell_options(known: Collection[str]) -> Spell:
    """Return how a command with these options spells an argument: ``--skip-rows 2``, ``--size X Y``."""

    def spell(one: Argument) -> str:
        if one.name in _SPELLED:
            return _SPELLED[one.name] if "tangential" in known else ""
        name = _GIVEN_ONE_BY_ONE.get(one.name, one.name)
        values = [_write_value(value, one) for value in one.values]
        return " ".join([f"--{name.replace('_', '-')}", *values]) if name in known else ""

    return spell


def _write_value(value: str | float, one: Argument) -> str:
    if not isinstance(value, str):
        return si(value, one.unit).replace(" ", "").replace("µ", "u") if one.unit else write_number(value)
    return value.upper() if len(one.values) > 1 else value if value.isalnum() else repr(value)


def refuse(options: argparse.Namespace, names: Iterable[str], reason: str) -> None:
    """Raise `InputError` for the first of these options that is given: a sentence that begins with it."""
    for name in names:
        if getattr(options, name) not in (None, False):
            raise InputError(f"--{name.replace('_', '-')} {reason}")


def add_shape(output: Any) -> None:
    """Declare the shape of what is printed, if it is not text."""
    shape = output.add_mutually_exclusive_group()
    shape.add_argument("--json", action="store_true", help="print one JSON object, in SI units")
    shape.add_argument("--csv", action="store_true", help="print a header and a row for each load, in SI units")
    leave_to("output", shape.add_argument("-q", "--quiet", action="store_true", help="print nothing but errors"))


def converter_of(field: PartField) -> Callable[[str], Any] | None:
    """Return the converter of the texts of a field, for argparse; None of a field that is neither a number nor two."""
    kinds = [kind for kind in (get_args(field.kind) or (field.kind,)) if kind is not NoneType]
    if kinds == [int]:
        return whole_number
    if kinds == [float, str]:
        return lambda text: text if text.isalpha() else NUMBER(text)
    if kinds != [float] and not field.is_pair:
        return None
    convert = quantity(field.unit or "")
    # The class reads the word of an infinite number, or refuses it.
    return lambda text: text if text == INFINITE else convert(text)


def describe_option(text: str, unit: str | None) -> str:
    """Return what is said of a field, with an example of how its number is written in place of the SI unit."""
    if not unit or unit not in EXAMPLES:
        return text
    return re.sub(rf", {re.escape(unit)}(?=[.;:,]|$)", f", such as {EXAMPLES[unit]}", text, count=1)


def whole_number(text: str) -> int:
    """Return text such as ``256`` as an int, for argparse."""
    if not re.fullmatch(r"[-+]?[0-9]{1,18}", text):
        raise argparse.ArgumentTypeError(f"{text[:_MAX_SHOWN_CHARACTERS]!r} is not a whole number; write it like 256")
    return int(text)


NUMBER = quantity("")
METRE, PASCAL, _NEWTON, _ANGLE, _SECOND, _SPEED = (quantity(unit) for unit in ("m", "Pa", "N", "rad", "s", "m/s"))


def length_unit(text: str) -> float:
    """Return the length that a height of one means, for argparse: ``um`` alone is ``1um``."""
    return METRE(f"1{text}" if text[:1].isalpha() else text)


def _load(text: str) -> Load:
    """Return a load, whose kind follows from its unit, for argparse."""
    for kind, unit in (("force", "N"), ("pressure", "Pa"), ("approach", "m")):
        with contextlib.suppress(ValueError):
            value = parse_quantity(text, unit)
            return Load(kind, value)
    shown = f"{text[:_MAX_SHOWN_CHARACTERS]!r} is not a force, a pressure or an approach"
    raise argparse.ArgumentTypeError(f"{shown}; write it like 2.5N, 100MPa or 50nm")


def add_problem(parser: argparse.ArgumentParser, *, study: bool = False) -> None:
    """Declare a contact problem of measured height maps, and its loads; or a study file, which needs neither."""
    others = "" if study else " |\n            --loads L ... | --solve-for NAME=VALUE | --cycle FROM TO"
    loads = f"--pressure P | --force F | --approach D{others}"
    parser.usage = f"%(prog)s MAP [MAP] (--young E | --material NAME) [options]\n           ({loads})"
    _add_maps(parser, study)
    _add_pair(parser)
    load = parser.add_argument_group("load, exactly one").add_mutually_exclusive_group(required=not study)
    load.add_argument("--pressure", type=PASCAL, metavar="P", help="nominal mean pressure, such as 100MPa")
    load.add_argument("--force", type=_NEWTON, metavar="F", help="normal force, such as 2.5N")
    load.add_argument("--approach", type=METRE, metavar="D", help="approach since first contact, such as 50nm")
    if not study:
        several = "loads of one kind, each a first loading: 1N 2N 5N"
        load.add_argument("--loads", type=_load, nargs="+", metavar="L", help=several)
        wanted = "the load of an answer: area=0.1mm2, area=10%%, stiffness=1GN/m, leakage=1mm3/s viscosity=1mPa.s ..."
        load.add_argument("--solve-for", nargs="+", metavar=("NAME=VALUE", "FIELD=VALUE"), help=wanted)
        path = "loading and unloading between two approaches, with --adhesion: -0.1um 0.5um"
        leave_to("adhesion", load.add_argument("--cycle", type=METRE, nargs=2, metavar=("FROM", "TO"), help=path))
    _add_materials(parser, study)
    adhesion = add_group(parser, "adhesion", "adhesion")
    adhesion.add_argument(
        "--adhesion",
        nargs="+",
        metavar=("LAW", "FIELD=VALUE"),
        help="law by which the surfaces attract each other: exponential work=50mJ/m2 range=2nm (none)",
    )
    if not study:
        adhesion.add_argument("--states", type=whole_number, metavar="N", help="states on each branch of --cycle (41)")
    law = "what else changes the contact; may be repeated: archard coefficient=1e-16m2/N"
    laws = add_group(parser, "laws", "paths")
    laws.add_argument("--law", nargs="+", action="append", metavar=("LAW", "FIELD=VALUE"), help=law)
    if not study:
        _add_paths(parser)
        _add_friction(parser)
    _add_method(parser)


def add_interface(parser: argparse.ArgumentParser, *, of_film: bool = False) -> None:
    """Declare an interface of measured height maps that repeats, and its loads, or the separations of a film."""
    rows = "--separation FROM..TO" if of_film else "--loads FROM..TO"
    parser.usage = f"%(prog)s MAP [MAP] (--young E | --material NAME)\n           {rows} [options]"
    maps = _add_maps(parser, study=False)
    mirror = "repeat maps that do not repeat, mirrored at their borders"
    maps.add_argument("--mirror-borders", action="store_true", help=mirror)
    _add_pair(parser)
    if of_film:
        what = "distances of the mean planes over Sq, as a range or one by one: 0.5..4; its steps grow from 0.25 to 1"
        group = parser.add_argument_group("separations")
        group.add_argument("--separation", type=_separations, nargs="+", metavar="H", required=True, help=what)
    else:
        loads = "mean pressures, as a range or one by one: 4MPa..40MPa; in a range each is at most 1.6 times the last"
        group = parser.add_argument_group("loads")
        group.add_argument("--loads", type=_pressures, nargs="+", metavar="P", required=True, help=loads)
    _add_materials(parser, study=False)
    _add_method(parser, boundary=False)
    parser.set_defaults(adhesion=None, law=None, boundary=str(Boundary.PERIODIC))


def _pressures(text: str) -> list[float]:
    """Return the mean pressures of a text, for argparse: one, or a range such as ``4MPa..40MPa``."""
    low, dots, high = text.partition("..")
    if not dots:
        return [PASCAL(low)]
    ends = PASCAL(low), PASCAL(high)
    if not 0.0 < ends[0] < ends[1]:
        raise argparse.ArgumentTypeError(f"{text[:_MAX_SHOWN_CHARACTERS]!r} is not a range; write it like 4MPa..40MPa")
    count = math.ceil(math.log(ends[1] / ends[0]) / math.log(MAX_LOAD_RATIO) - 1e-9)
    if count > _MAX_LOADS:
        raise argparse.ArgumentTypeError(f"{text[:_MAX_SHOWN_CHARACTERS]!r} needs more than {_MAX_LOADS} loads")
    return [float(one) for one in np.geomspace(*ends, count + 1)]


def _separations(text: str) -> list[float]:
    """Return the separations of a text, for argparse: one, or a range such as ``0.5..4``."""
    low, dots, high = text.partition("..")
    if not dots:
        return [NUMBER(low)]
    at = NUMBER(low)
    end = NUMBER(high)
    try:
        return space_separations(at, end)
    except InputError:
        raise argparse.ArgumentTypeError(
            f"{text[:_MAX_SHOWN_CHARACTERS]!r} is not a range of at most 100; write it like 0.5..4"
        ) from None


def _add_method(parser: argparse.ArgumentParser, *, boundary: bool = True) -> None:
    if boundary:
        add_group(parser, "domain").add_argument(
            "--boundary",
            choices=[str(one) for one in Boundary],
            default="free",
            metavar="WORD",
            help=f"what lies beyond the domain: {', '.join(map(str, Boundary))} (free)",
        )
    method = add_group(parser, "method", "method")
    kernel = "influence kernel, and its fields (love)"
    method.add_argument("--kernel", nargs="+", metavar=("NAME", "FIELD=VALUE"), help=kernel)
    method.add_argument("--solver", default="auto", metavar="NAME", help="solver (auto)")
    method.add_argument(
        "--threads", type=_number_or_auto, default="auto", metavar="N", help="threads (as many as gain)"
    )


def _add_paths(parser: argparse.ArgumentParser) -> None:
    """Declare loads and what passes at the places of a path on which the surfaces change."""
    paths = add_group(parser, "paths", "paths")
    paths.add_argument("--path", action="store_true", help="follow --loads in their order, and remember")
    for name, convert, metavar, what in (
        ("time", _SECOND, "T", "times at its places, under one load or as many: 0s 1s 1e3s"),
        ("sliding", METRE, "S", "sliding distances there: 0m 1m 10m"),
        ("shift", _shift, "N", "cells by which the counterbody is displaced there, along x or as X,Y: 0 4 8"),
    ):
        paths.add_argument(f"--{name}", type=convert, nargs="+", metavar=metavar, help=what)
    strict = "relative error of each increment; with --cycles height that is lost at once, over the approach (0.001)"
    paths.add_argument("--accuracy", type=NUMBER, metavar="D", help=strict)


def _shift(text: str) -> tuple[int, int]:
    """Return cells along x, or along x and y, for argparse."""
    along, comma, across = text.strip().partition(",")
    return whole_number(along), whole_number(across) if comma else 0


def _add_friction(parser: argparse.ArgumentParser) -> None:
    """Declare loads along the surface, and steady sliding."""
    friction = add_group(parser, "friction", "paths")
    friction.add_argument(
        "--friction",
        nargs="+",
        metavar=("MU", "FIELD=VALUE"),
        help="coefficient of friction, or a law: 0.3, limited-coulomb coefficient=0.3 strength=200MPa",
    )
    along = friction.add_mutually_exclusive_group()
    along.add_argument(
        "--tangential",
        type=_tangential,
        nargs="+",
        metavar="Q",
        help="tangential forces or displacements one after the other, along x or as X,Y: 0.5N -0.5N 0.5N",
    )
    along.add_argument(
        "--slide",
        type=_ANGLE,
        nargs="?",
        const=0.0,
        metavar="A",
        help="steady sliding, or with --sliding a path of it: angle of the friction force on the body from x "
        "towards y, such as 30deg (0)",
    )
    friction.add_argument(
        "--speed", type=_SPEED, metavar="V", help="with --slide, speed of viscoelastic bodies instead of --friction"
    )
    friction.add_argument(
        "--substeps", type=_number_or_auto, metavar="N", help="increments of each step, with --tangential (auto)"
    )
    cycles = "numbers of the cycles to state, if --tangential is one of many, with --law energy-wear: 1 100 1e4"
    friction.add_argument("--cycles", type=NUMBER, nargs="+", metavar="N", help=cycles)


def _tangential(text: str) -> tuple[str, tuple[float, float]]:
    """Return the kind of a load along the surface, which follows from its unit, and its components, for argparse."""
    along, comma, across = text.partition(",")
    for kind, unit in (("tangential_force", "N"), ("displacement", "m")):
        with contextlib.suppress(ValueError):
            return kind, (parse_quantity(along, unit), parse_quantity(across, unit) if comma else 0.0)
    shown = f"{text[:_MAX_SHOWN_CHARACTERS]!r} is not a tangential force or displacement"
    raise argparse.ArgumentTypeError(f"{shown}; write it like 0.5N, 0.5N,-0.1N or 50nm")


def add_accuracy(parser: argparse.ArgumentParser) -> None:
    """Declare the accuracy at which a solve may aim."""
    accuracy = add_group(parser, "accuracy, with 95 %", "method")
    for name, what in (("area", "contact area"), ("peak", "maximum pressure")):
        accuracy.add_argument(
            f"--{name}-within", type=NUMBER, metavar="D", help=f"relative error of the {what}, such as 0.01 or 1%%"
        )
    accuracy.add_argument(
        "--tolerance", type=NUMBER, metavar="T", help="tolerance of the solver (as the accuracy needs)"
    )


def _add_materials(parser: argparse.ArgumentParser, study: bool) -> None:
    for prefix, body, poisson in (("", "body", "0.3"), ("counterbody-", "counterbody", "the body's")):
        group = add_group(parser, f"material of the {body}", "materials")
        rigid = " (rigid)" if prefix else ""
        choice = group.add_mutually_exclusive_group(required=not (prefix or study))
        named = f"typical values by name, such as 'bearing steel', or a material with --{prefix}fields{rigid}"
        modulus = f"Young's modulus, such as 210GPa{rigid}"
        usual = [
            choice.add_argument(f"--{prefix}material", choices=(*TYPICAL, *materials), metavar="NAME", help=named),
            choice.add_argument(f"--{prefix}young", type=PASCAL, metavar="E", help=modulus),
        ]
        relaxes = "with a modulus that relaxes: moduli=1MPa,3MPa times=10ms poisson=0.5"
        choice.add_argument(f"--{prefix}viscoelastic", nargs="+", metavar="FIELD=VALUE", help=relaxes)
        fields = "fields of such a material: young=210GPa poisson=0.3"
        group.add_argument(f"--{prefix}fields", nargs="+", metavar="FIELD=VALUE", help=fields)
        own = [
            group.add_argument(f"--{prefix}poisson", type=NUMBER, metavar="NU", help=f"Poisson's ratio ({poisson})"),
            group.add_argument(
                f"--{prefix}hardness", type=PASCAL, metavar="H", help="hardness, such as 6GPa (elastic)"
            ),
        ]
        layer = "a layer, from the surface downwards; may be repeated: young=400GPa poisson=0.25 thickness=2um (none)"
        group.add_argument(f"--{prefix}layer", action="append", nargs="+", metavar="FIELD=VALUE", help=layer)
        show(*usual, *(() if prefix else own))


def _add_maps(parser: argparse.ArgumentParser, study: bool) -> argparse._ArgumentGroup:
    other = "; or a study file" if study else ""
    parser.add_argument("surface", help=f"height map of the body (npz, npy, text, instrument){other}")
    parser.add_argument("counterbody", nargs="?", help="height map of the counterbody (a flat)")
    maps = _add_treatment(parser, "maps")
    maps.add_argument(
        "--resample", type=whole_number, nargs=2, metavar=("NX", "NY"), help="number of cells, bilinearly"
    )
    for name, what in (("size", METRE), ("unit", length_unit), ("tip-radius", METRE), ("detrend", _form)):
        maps.add_argument(
            f"--counterbody-{name}",
            type=what,
            nargs="+" if name == "size" else None,
            metavar=name.upper(),
            help=f"--{name} of the counterbody, if different",
        )
    shape = maps.add_mutually_exclusive_group()
    shape.add_argument("--ball", type=METRE, metavar="R", help="add a sphere of this radius, such as 5mm, to the body")
    shape.add_argument(
        "--roller",
        type=METRE,
        metavar="R",
        help="add a cylinder of this radius, such as 5mm, along y, or along x with --boundary periodic-free",
    )
    return maps


def add_reading(parser: argparse.ArgumentParser) -> None:
    """Declare a file that holds a height map or a solution."""
    parser.add_argument("surface", metavar="FILE", help="height map (npz, npy, text or instrument file) or solution")
    _add_treatment(parser)


def _add_treatment(parser: argparse.ArgumentParser, topic: str = "") -> argparse._ArgumentGroup:
    """Declare how a height map is read."""
    maps: argparse._ArgumentGroup = add_group(parser, "height maps", topic)
    sides = "side lengths, one or x y, such as 5mm (the file's)"
    show(maps.add_argument("--size", type=METRE, nargs="+", metavar="L", help=sides))
    maps.add_argument(
        "--cell", type=METRE, nargs="+", metavar="L", help="distance of the points, such as 1um, in place of --size"
    )
    show(
        maps.add_argument("--unit", type=length_unit, metavar="U", help="unit of the heights, such as 1um (the file's)")
    )
    treatments = ("refuse", "fill", "keep")
    maps.add_argument("--non-measured", choices=treatments, default="refuse", help="non-measured points (refuse)")
    for name, (field, what) in list_reader_options().items():
        convert = converter_of(field) or str
        text = describe_option(what, field.unit)
        maps.add_argument(f"--{name.replace('_', '-')}", type=convert, metavar=name[0].upper(), help=text)
    tip = "radius of the stylus tip that has traced the map, taken away from it, such as 2um"
    maps.add_argument("--tip-radius", type=METRE, metavar="R", help=tip)
    maps.add_argument(
        "--detrend", type=_form, metavar="FORM", help="mean, plane, sphere or degree of a polynomial to subtract"
    )
    maps.add_argument(
        "--shortest", type=METRE, metavar="L", help="waves shorter than this, such as 8um, are filtered out (none)"
    )
    maps.add_argument(
        "--longest", type=METRE, metavar="L", help="waves longer than this, such as 0.8mm, are filtered out (none)"
    )
    maps.add_argument("--robust", action="store_true", help="filters that grooves and spikes do not move")
    return maps


def _add_pair(parser: argparse.ArgumentParser) -> None:
    pair = add_group(parser, "two height maps on different grids", "maps")
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
    pair.add_argument(
        "--domain", type=METRE, nargs="+", metavar="L", help="side lengths, one or x y, such as 1mm (the overlap)"
    )


def _place(text: str) -> tuple[float, float]:
    parts = text.split(",")
    if len(parts) != 2:
        raise argparse.ArgumentTypeError(f"{text!r} is not a position; write it like 5um,-2um")
    return METRE(parts[0]), METRE(parts[1])


def _number_or_auto(text: str) -> int | str:
    return text if text == "auto" else whole_number(text)


def _form(text: str) -> str | int:
    return whole_number(text) if text.isdecimal() else text
