"""``roughcontact law``: the law of an interface of measured height maps, for finite-element codes."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import roughcontact as rc
from roughcontact._answers.laws import InterfaceLaw
from roughcontact._base import checks
from roughcontact._base.archive import replacing
from roughcontact._base.machine.progress import count_done
from roughcontact._base.units import fit
from roughcontact._faces.cli import DOUBTFUL, Command
from roughcontact._faces.cli.answers import (
    PICTURES,
    describe_responses,
    require_packages,
    require_place,
    write_csv,
    write_json,
)
from roughcontact._faces.cli.help import leave_to
from roughcontact._faces.cli.options import add_interface, add_shape
from roughcontact._faces.cli.problem import problem_of
from roughcontact._faces.cli.progress import show_progress
from roughcontact._faces.cli.responses import add_responses, responses_of
from roughcontact._faces.panels.figures import save_figure
from roughcontact._parts.grid import Load
from roughcontact._solve.problem import describe_estimate, describe_inputs

# Width of the picture of a column, and height of the figure, inches.
_PANEL_SIZE = (4.2, 3.6)
_ENDINGS = (".csv", ".html", ".json", *sorted(PICTURES))
# The ending of the table of pressure over closure, beside that of the conductance.
_CLOSURE = "-closure"


class Law(Command):
    """Make the law of an interface over the load, with files for finite-element codes."""

    epilog = """
examples:
  roughcontact law map.npz --young 210GPa --loads 4MPa..40MPa --mirror-borders
  roughcontact law map.npz --young 210GPa --loads 4MPa..40MPa --mirror-borders \\
      --conductance 45 --abaqus joint.inp -o joint.csv -o joint.png
  roughcontact law map.npz --young 210GPa --loads 5MPa 8MPa --mirror-borders \\
      --calculix joint.inp --units mm
"""

    def declare(self, parser: argparse.ArgumentParser) -> None:
        add_interface(parser)
        add_responses(parser)
        programs = parser.add_argument_group("files of other programs")
        for name, what in (
            ("abaqus", "surface interaction of Abaqus"),
            ("ansys", "conductance for Ansys, commands of Mechanical APDL"),
            ("calculix", "surface interaction of CalculiX"),
            ("comsol", f"conductance for COMSOL, and pressure over closure beside it, {_CLOSURE}"),
            ("moose", "conductance for MOOSE, .csv, and the blocks beside it, .i"),
        ):
            programs.add_argument(f"--{name}", metavar="FILE", help=what)
        programs.add_argument("--units", choices=("SI", "mm"), default="SI", help="units of these files (SI)")
        called = programs.add_argument(
            "--name", default="ROUGH", metavar="NAME", help="name of the interaction (ROUGH)"
        )
        leave_to("output", called)
        output = parser.add_argument_group("output")
        add_shape(output)
        files = f"table or picture to write: {', '.join(_ENDINGS)}; may be repeated"
        output.add_argument("-o", "--output", action="append", default=[], metavar="FILE", help=files)

    def run(self, options: argparse.Namespace) -> int:
        """Write the files and print the law; return 0, or 3 if it has warnings."""
        maps = [checks.path(name, "The map") for name in (options.surface, options.counterbody) if name is not None]
        writers = _plan_writers(options, maps, lambda law: {**describe_law(law), "inputs": inputs})
        asked = {"stiffness": rc.responses.create("stiffness"), **responses_of(options)}
        for name in ("ansys", "moose"):
            if getattr(options, name) is not None and "conductance" not in asked:
                raise rc.InputError(f"--{name} writes a conductance: give --conductance too.")
        with show_progress("reading the maps", quiet=options.quiet):
            problem = problem_of(options)
        pressures = [value for several in options.loads for value in several]
        loads = [Load("pressure", value) for value in sorted(pressures)]
        inputs = {**describe_inputs(problem, loads), **describe_responses(asked)}
        with show_progress("solving", quiet=options.quiet) as change:
            law = rc.interface_law(problem, pressures, asked, on_load=count_done(change, len(pressures), "load"))
        for write, path in writers:
            write(law, path)
        if options.json:
            print(write_json({**describe_law(law), "inputs": inputs}))
        elif options.csv:
            print(write_csv(law.table()))
        elif not options.quiet:
            print(fit(str(law)))
            if writers:
                print(fit(f"\nWritten: {', '.join(str(path) for _, path in writers)}"))
        return DOUBTFUL if law.warnings else 0


def _plan_writers(
    options: argparse.Namespace, maps: list[Path], describe: Callable[[InterfaceLaw], dict[str, Any]]
) -> list[tuple[Callable[[InterfaceLaw, Path], None], Path]]:
    """Return what will be written, with its files; `InputError` before anything is solved.

    `describe` gives the content of JSON.
    """
    units = options.units
    planned: list[tuple[Callable[[InterfaceLaw, Path], None], str]] = []
    for text in options.output:
        ending = Path(text).suffix
        if ending not in _ENDINGS:
            raise rc.InputError.about("The output", text, f"a file that ends in {', '.join(_ENDINGS)}")
        require_packages(ending)
        known = {
            ".csv": InterfaceLaw.to_csv,
            ".html": InterfaceLaw.to_html,
            ".json": lambda law, path: _write_json(describe(law), path),
        }
        planned.append((known.get(ending, _draw), text))
    for write in (InterfaceLaw.to_abaqus, InterfaceLaw.to_ansys, InterfaceLaw.to_calculix, InterfaceLaw.to_moose):
        if (text := getattr(options, write.__name__.removeprefix("to_"))) is not None:
            planned.append((partial(write, name=options.name, units=units), text))
    if options.comsol is not None:
        beside = checks.path(options.comsol, "The file")
        if getattr(options, "response conductance", None) is not None:
            planned.append((lambda law, path: law.to_comsol(path, units=units), options.comsol))
        closure = str(beside.with_stem(f"{beside.stem}{_CLOSURE}"))
        planned.append((lambda law, path: law.to_comsol(path, table="closure", units=units), closure))
    files = [(write, checks.path(text, "The file")) for write, text in planned]
    for _, path in files:
        require_place(path, [path], maps)
    return files


def describe_law(law: InterfaceLaw) -> dict[str, Any]:
    """Return a law as data that JSON can hold."""
    columns = {
        name: {"unit": one.unit, "values": one.values.tolist(), "uncertainties": one.uncertainties.tolist()}
        for name, one in law.columns.items()
    }
    fits = {name: law.fit(name) for name in law.columns}
    return {
        "pressures": {"unit": "Pa", "values": law.pressures.tolist()},
        "columns": columns,
        "exponents": {
            name: describe_estimate(rc.Estimate(found.exponent, found.exponent_std, ""))
            for name, found in fits.items()
            if found is not None
        },
        "description": list(law.description),
        "warnings": list(law.warnings),
    }


def _write_json(content: dict[str, Any], path: Path) -> None:
    with replacing(path) as partial:
        partial.write_text(f"{write_json(content)}\n", encoding="utf-8")


def _draw(law: InterfaceLaw, path: Path) -> None:
    """Draw all columns side by side."""
    from matplotlib.figure import Figure

    width, height = _PANEL_SIZE
    figure = Figure(figsize=(width * len(law.columns), height), layout="constrained")
    for name, axes in zip(law.columns, figure.subplots(1, len(law.columns), squeeze=False)[0], strict=True):
        law.plot(name, axes)
    save_figure(figure, path)
