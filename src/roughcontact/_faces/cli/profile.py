"""``roughcontact profile``: what line scans tell of a surface."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import Any

import numpy as np

import roughcontact as rc
from roughcontact._base.arrays import Array
from roughcontact._base.tables import Table
from roughcontact._base.units import counted, fit, si
from roughcontact._faces.cli import DOUBTFUL, Command
from roughcontact._faces.cli.answers import write_csv, write_json
from roughcontact._faces.cli.options import METRE, PASCAL, add_shape, length_unit, whole_number
from roughcontact._solve.problem import describe_estimate
from roughcontact.reference import ProfileStatistics, fit_surface, profile

_NEVER_KNOWN = "summits, Sk of the area, percolation, leakage, a map to press"
_NO_SLOPE = "state --isotropic, or give lines at right angles with --across"


class Profile(Command):
    """State what line scans tell of a surface: heights and slopes, and the contact area at light load."""

    epilog = """
examples:
  roughcontact profile lines.csv --isotropic
  roughcontact profile one.csv two.csv --across other.csv --json
  roughcontact profile lines.csv --isotropic --pressure 50MPa --modulus 230GPa
"""

    def declare(self, parser: argparse.ArgumentParser) -> None:
        parser.add_argument(
            "lines", nargs="+", metavar="FILE", help="line scans along one direction (text, npy), a line a column"
        )
        stated = parser.add_argument_group("the surface")
        stated.add_argument("--across", nargs="+", default=[], metavar="FILE", help="lines at right angles to them")
        stated.add_argument("--isotropic", action="store_true", help="the surface is known to have no lay")
        stated.add_argument("--shortest", type=METRE, metavar="L", help="shortest wave of an isotropic spectrum to fit")
        reading = parser.add_argument_group("files")
        reading.add_argument("--spacing", type=METRE, metavar="L", help="distance of the points (the file's)")
        reading.add_argument(
            "--unit", type=length_unit, metavar="U", help="unit of the heights, such as um (the file's)"
        )
        reading.add_argument(
            "--position-unit", type=length_unit, metavar="U", help="unit of the positions, such as mm (the file's)"
        )
        reading.add_argument("--separator", default="auto", metavar="S", help="separator of the numbers (auto)")
        reading.add_argument("--decimal", default="auto", metavar="D", help="decimal mark (auto)")
        reading.add_argument("--skip-rows", type=whole_number, default=0, metavar="N", help="lines to skip (0)")
        load = parser.add_argument_group("contact area by Persson's theory, at light load")
        load.add_argument("--pressure", type=PASCAL, metavar="P", help="mean pressure, such as 50MPa")
        load.add_argument(
            "--modulus", type=PASCAL, metavar="E", help="contact modulus E* of both bodies, such as 115GPa"
        )
        add_shape(parser.add_argument_group("output"))

    def run(self, options: argparse.Namespace) -> int:
        """Print what the lines tell; return 0, or 3 if it is warned of."""
        _require(options)
        lines, step = _read(options.lines, options)
        across, other_step = _read(options.across, options) if options.across else (None, step)
        if not np.isclose(step, other_step, rtol=1e-3):
            raise rc.InputError(
                f"The points of the lines are {si(step, 'm')} apart, those across {si(other_step, 'm')}."
            )
        found = profile(lines, step, isotropic=options.isotropic, across=across)
        answers = _list_answers(found, options)
        if options.shortest is not None:
            fitted = fit_surface(lines, step, options.shortest)
            answers |= {"hurst": fitted.hurst, "rolloff": fitted.rolloff}
        unknown = [*([] if found.Sdq else ["Sdq", "m2"]), *_NEVER_KNOWN.split(", ")]
        if options.json:
            counts = {"lines": len(lines), "lines_across": 0 if across is None else len(across)}
            shape = {**counts, "points": lines.shape[1], "spacing": step}
            described = {name: describe_estimate(one) for name, one in answers.items()}
            print(write_json({**shape, "isotropic": options.isotropic, "answers": described, "unknown": unknown}))
        elif options.csv:
            print(write_csv(_tabulate(answers)))
        elif not options.quiet:
            print(fit("\n".join(_write(found, answers, lines, across, step))))
        return DOUBTFUL if any(one.warnings for one in answers.values()) else 0


def _require(options: argparse.Namespace) -> None:
    """Raise `InputError` where what is asked for cannot be found, before anything is read."""
    if (options.pressure is None) != (options.modulus is None):
        raise rc.InputError("The contact area needs --pressure and --modulus: give both, or omit both.")
    if options.pressure is not None and not (options.isotropic or options.across):
        raise rc.InputError(f"The contact area needs Sdq: {_NO_SLOPE}.")
    if options.shortest is not None and not options.isotropic:
        raise rc.InputError(
            "A spectrum is fitted to lines of an isotropic surface alone: state --isotropic, or omit --shortest."
        )


def _read(names: Sequence[str], options: argparse.Namespace) -> tuple[Array, float]:
    """Return the lines of files, shape (lines, points), m, and the distance of their points, m."""
    scans = [
        rc.read_profile(
            name,
            spacing=options.spacing,
            unit=options.unit,
            position_unit=options.position_unit,
            separator=options.separator,
            decimal=options.decimal,
            skip_rows=options.skip_rows,
        )
        for name in names
    ]
    first = scans[0]
    for name, one in zip(names, scans, strict=True):
        alike = np.isclose(one.spacing, first.spacing, rtol=1e-3)
        if one.heights.shape[1] != first.heights.shape[1] or not alike:
            raise rc.InputError(
                f"The lines of {names[0]} and {name} differ in points or spacing: cut them to one length."
            )
    return np.concatenate([one.heights for one in scans]), first.spacing


def _list_answers(found: ProfileStatistics, options: argparse.Namespace) -> dict[str, rc.Estimate]:
    """Return what is known, by name."""
    names = ("Rq", "Rdq", "Rdq_across", "Sq", "Sdq", "m0", "m2")
    answers = {name: getattr(found, name) for name in names if getattr(found, name) is not None}
    if options.pressure is not None:
        answers["area"] = found.persson_area(options.pressure, options.modulus)
    return answers


def _tabulate(answers: dict[str, rc.Estimate]) -> Table:
    """Return a row for each answer."""
    columns: dict[str, list[Any]] = {"quantity": list(answers)}
    for name in ("value", "uncertainty", "unit"):
        columns[name] = [getattr(one, name) for one in answers.values()]
    columns["warnings"] = ["; ".join(map(str, one.warnings)) for one in answers.values()]
    return Table(columns, {})


def _write(
    found: ProfileStatistics, answers: dict[str, rc.Estimate], lines: Array, across: Array | None, step: float
) -> list[str]:
    """Return what is known and what is not, in lines of text."""
    length = si(lines.shape[1] * step, "m")
    beside = "" if across is None else f", {counted(len(across), 'line')} across"
    texts = [f"{counted(len(lines), 'line')} of {lines.shape[1]} points{beside}, {si(step, 'm')} apart, {length} long"]
    texts.append(str(found))
    if "hurst" in answers:
        texts.append(f"fitted  Hurst exponent {answers['hurst']}, roll-off {answers['rolloff']}")
    if "area" in answers:
        area = answers["area"]
        texts.append(
            f"area    by Persson's theory ({100.0 * area.value:.3g} +- {100.0 * area.uncertainty:.2g}) % of nominal"
        )
        texts.append("        solved contacts of isotropic surfaces have 20 to 45 % more")
    if found.Sdq is None:
        texts.append(f"Sdq is not known: {_NO_SLOPE}")
    texts.append(f"never known from lines: {_NEVER_KNOWN}")
    return texts
