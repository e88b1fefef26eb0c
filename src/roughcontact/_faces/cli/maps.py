"""``roughcontact info``, ``plot`` and ``surface``: maps and saved solutions in words and pictures, synthetic maps."""

from __future__ import annotations

import argparse
import contextlib
from pathlib import Path
from typing import Any

import attrs
import numpy as np

import roughcontact as rc
from roughcontact._base import checks
from roughcontact._base.archive import replacing
from roughcontact._base.arrays import Array
from roughcontact._base.registry import PartField, describe_fields, list_fields, summarize
from roughcontact._base.units import fit
from roughcontact._faces.cli import Command
from roughcontact._faces.cli.answers import (
    PICTURES,
    plan_path_picture,
    plan_picture,
    save_path_picture,
    to_json,
    to_text,
)
from roughcontact._faces.cli.options import METRE, add_reading, converter_of, describe_option, whole_number
from roughcontact._faces.cli.paths import path_to_json, path_to_text
from roughcontact._faces.cli.problem import read_map
from roughcontact._faces.panels.figures import save_figure
from roughcontact._parts.surfaces import list_facts, write_facts
from roughcontact._solve.problem import Path as StatePath
from roughcontact._solve.problem import find_saved_kind
from roughcontact._solve.solution import find_scene
from roughcontact.reference import roughness, texture

# Fraction of the variance of the heights that is form, from which on the spectrum shows the form.
_MIN_FORM_FRACTION = 0.5
# Degree of the polynomial that is taken for form (tilt, curvature, twist), and the fewest cells along an axis for it.
_FORM_DEGREE = 2
_MIN_FORM_CELLS = 8


def describe_map(surface: rc.HeightMap) -> str:
    """Return size, cells and roughness of a height map, and its warnings, in lines of at most 80 columns."""
    lines = write_facts(list_facts(surface._sample(None), surface.history))
    if not surface.periodic:
        lines.append("spectrum      of the heights times a Hann window:")
    lines.append(str(roughness(surface.values, surface.grid, periodic=surface.periodic)))
    lines += ["ISO 25178-2:", str(texture(surface.values, surface.grid, periodic=surface.periodic))]
    return "\n".join([fit("\n".join(lines)), *list_warnings(surface)])


def list_warnings(surface: rc.HeightMap) -> list[str]:
    """Return the warnings about units, form and quality of a height map, in lines of at most 80 columns."""
    gap = surface.values.max() - surface.values
    units = find_scene(gap, surface.grid, rc.Boundary.FREE, ())[0].warning
    texts = (units, _judge_form(surface), *surface.warnings)
    return [fit(f"warning       {text}") for text in texts if text]


def _judge_form(surface: rc.HeightMap) -> str:
    heights = _measured(surface)
    if surface.periodic or min(surface.grid.shape) < _MIN_FORM_CELLS or heights.max() == heights.min():
        return ""
    form = 1.0 - float(_measured(surface.detrend(_FORM_DEGREE)).var() / heights.var())
    if form < _MIN_FORM_FRACTION:
        return ""
    return (
        f"{100.0 * form:.3g} % of the variance of the heights is tilt and curvature: "
        "'roughcontact info --detrend 2' describes the roughness without them"
    )


def _measured(surface: rc.HeightMap) -> Array:
    return surface.values if surface.non_measured is None else np.asarray(surface.values[~surface.non_measured])


class Info(Command):
    """Describe a height map, or a solution or path that was saved."""

    epilog = """
examples:
  roughcontact info map.npz
  roughcontact info map.csv --size 256um --unit 1um
  roughcontact info contact.npz --json | jq .area
"""

    def declare(self, parser: argparse.ArgumentParser) -> None:
        add_reading(parser)
        parser.add_argument("--json", action="store_true", help="print a solution as one JSON object, in SI units")

    def run(self, options: argparse.Namespace) -> int:
        """Print the map or the solution of the file, and return 0."""
        subject = _read(options)
        if isinstance(subject, rc.ContactSolution):
            print((to_json if options.json else to_text)([subject]))
        elif isinstance(subject, StatePath):
            print((path_to_json if options.json else path_to_text)(subject))
        elif options.json:
            raise rc.InputError("--json is for solutions and paths: omit it for a height map.")
        else:
            print(describe_map(subject))
        return 0


class Plot(Command):
    """Draw a height map, or a solution or path that was saved."""

    epilog = """
examples:
  roughcontact plot map.npz -o map.png
  roughcontact plot contact.npz -o contact.pdf
  roughcontact plot contact.npz --panel pressure --dark -o pressure.svg
"""

    def declare(self, parser: argparse.ArgumentParser) -> None:
        add_reading(parser)
        parser.add_argument("--panel", metavar="NAME", help=f"one picture ({', '.join(rc.panels)}) instead of all")
        parser.add_argument("--dark", action="store_true", help="on a dark background")
        parser.add_argument(
            "-o",
            "--output",
            required=True,
            metavar="FILE",
            help="picture to write: .png, .svg, .pdf; of a path also .gif, its states one after the other",
        )

    def run(self, options: argparse.Namespace) -> int:
        """Draw the map or the solution of the file, and return 0."""
        path = plan_path_picture(options.output)
        subject = _read(options)
        if isinstance(subject, StatePath):
            if options.panel is not None:
                raise rc.InputError("--panel is for maps and solutions: omit it for a path, which has one picture.")
            save_path_picture(subject, path, options.dark)
        elif path.suffix not in PICTURES:
            raise rc.InputError(f"{path.suffix} is for paths, which have several states: write a .png, .svg or .pdf.")
        else:
            save_figure(subject.plot(panel=options.panel, dark=options.dark), path)
        print(fit(f"Written: {path}"))
        for text in list_warnings(subject) if isinstance(subject, rc.HeightMap) else ():
            print(text)
        return 0


def _read(options: argparse.Namespace) -> Any:
    """Return the solution, path or height map of a file."""
    path = checks.path(options.surface, "The file")
    kind = find_saved_kind(path)
    return read_map(options) if kind is None else kind.load(path)


class MakeSurface(Command):
    """Make a height map of a synthetic surface."""

    epilog = """
examples:
  roughcontact surface self-affine --hurst 0.8 --rms-height 100nm \\
      --shortest 2um --longest 100um --shape 256 256 --size 100um -o rough.npz
  roughcontact surface sphere --radius 5mm --shape 64 64 --size 0.2mm \\
      -o ball.npz
  roughcontact surface wavy --amplitude 0.5um --wavelength 12.5um \\
      --shape 128 128 --size 250um --periodic -o wave.npz -o wave.png
  roughcontact surface self-affine --help
"""

    def declare(self, parser: argparse.ArgumentParser) -> None:
        kinds = parser.add_subparsers(dest="kind", required=True, metavar="KIND", help=", ".join(_kinds()))
        for name, cls in _kinds().items():
            own = kinds.add_parser(name, help=summarize(cls).replace("%", "%%"), description=f"{summarize(cls)}.")
            texts = describe_fields(cls)
            fields = own.add_argument_group("surface")
            for field in list_fields(cls).values():
                if (convert := converter_of(field)) is not None:
                    fields.add_argument(
                        f"--{field.name.replace('_', '-')}",
                        dest=f"field_{field.name}",
                        type=convert,
                        nargs="+" if field.is_pair else None,
                        required=field.is_needed,
                        metavar="V",
                        help=describe_option(texts.get(field.name, ""), field.unit).replace("%", "%%"),
                    )
            grid = own.add_argument_group("grid")
            grid.add_argument("--shape", type=whole_number, nargs=2, required=True, metavar=("NX", "NY"), help="cells")
            grid.add_argument(
                "--size", type=METRE, nargs="+", required=True, metavar="L", help="sides, one or x y: 5mm"
            )
            grid.add_argument("--periodic", action="store_true", help="it repeats, as self-affine does by itself")
            own.add_argument_group("output").add_argument(
                "-o",
                "--output",
                action="append",
                default=[],
                metavar="FILE",
                help="height map to write, .npz, or a picture, .png, .svg or .pdf; may be repeated",
            )

    def run(self, options: argparse.Namespace) -> int:
        """Write the map, print its roughness, and return 0."""
        files = [_plan(text) for text in options.output]
        grid = rc.Grid(options.shape, _single(options.size))
        given = {
            name.removeprefix("field_"): value
            for name, value in vars(options).items()
            if name.startswith("field_") and value is not None
        }
        surface = rc.surfaces.create(options.kind, **{name: _single(value) for name, value in given.items()})
        periodic = options.periodic or bool(getattr(surface, "periodic", False))
        made = rc.HeightMap(surface.heights(grid), grid.size, periodic=periodic)
        print(describe_map(made))
        for path in files:
            if path.suffix == ".npz":
                with replacing(path) as partial, partial.open("wb") as file:
                    np.savez(file, heights=made.values, size=np.array(made.size), periodic=np.array(made.periodic))
            else:
                save_figure(made.plot(), path)
        if files:
            print(fit(f"\nWritten: {', '.join(map(str, files))}"))
        return 0


def _plan(text: str) -> Path:
    path = checks.path(text, "The output")
    return path if path.suffix == ".npz" else plan_picture(text, (".npz",))


def _single(value: Any) -> Any:
    return value[0] if isinstance(value, list) and len(value) == 1 else value


def _kinds() -> dict[str, type[Any]]:
    """Return the registered surfaces that numbers alone describe, by name."""
    found: dict[str, type[Any]] = {}
    for name in rc.surfaces:
        # A broken plug-in leaves the others as they are.
        with contextlib.suppress(rc.InputError):
            cls: type[Any] = rc.surfaces[name]
            if attrs.has(cls) and all(map(converter_of, filter(_is_needed, list_fields(cls).values()))):
                found[name] = cls
    return found


def _is_needed(field: PartField) -> bool:
    return field.is_needed
