"""``roughcontact surface``: a height map of a synthetic surface."""

from __future__ import annotations

import argparse
import contextlib
import inspect
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import attrs
import numpy as np

import roughcontact as rc
from roughcontact._base import checks
from roughcontact._base.archive import replacing
from roughcontact._base.units.text import fit
from roughcontact._faces.cli import Command
from roughcontact._faces.cli.maps import describe_map
from roughcontact._faces.cli.options import METRE, NUMBER, quantity, whole_number
from roughcontact._faces.cli.outputs import plan_picture
from roughcontact._faces.panels.figures import save_figure

# Types of fields, as they are annotated, that an option can give: the converter, and how many values.
_TYPES: dict[str, tuple[Callable[[str], Any], str | None]] = {
    "float": (NUMBER, None),
    "int": (whole_number, None),
    "Pair": (NUMBER, "+"),
}


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
            first = (inspect.getdoc(cls) or "").partition("\n")[0].replace("`", "")
            own = kinds.add_parser(name, help=first.replace("%", "%%"), description=first)
            texts = dict(_field_texts(cls))
            fields = own.add_argument_group("surface")
            for field, convert, count in _options_of(cls):
                fields.add_argument(
                    f"--{str(field.alias).replace('_', '-')}",
                    dest=f"field_{field.alias}",
                    type=convert,
                    nargs=count,
                    required=field.default is attrs.NOTHING,
                    metavar="V",
                    help=texts.get(str(field.alias), "").replace("%", "%%").replace("`", ""),
                )
            grid = own.add_argument_group("grid")
            grid.add_argument("--shape", type=whole_number, nargs=2, required=True, metavar=("NX", "NY"), help="cells")
            grid.add_argument("--size", type=METRE, nargs="+", required=True, metavar="L", help="sides, one or x y")
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
        grid = rc.Grid(options.shape, options.size[0] if len(options.size) == 1 else options.size)
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
            given = {field.name for field, _, _ in _options_of(cls)}
            if attrs.has(cls) and all(
                field.name in given or field.default is not attrs.NOTHING for field in _fields(cls)
            ):
                found[name] = cls
    return found


def _fields(cls: type[Any]) -> tuple[Any, ...]:
    return tuple(attrs.fields(cls)) if attrs.has(cls) else ()


def _options_of(cls: type[Any]) -> Iterator[tuple[Any, Callable[[str], Any], str | None]]:
    """Yield each field that an option can give, with the converter of its text and the number of values."""
    for field in _fields(cls):
        annotation = field.type if isinstance(field.type, str) else getattr(field.type, "__name__", "")
        kind = _TYPES.get(annotation.removesuffix(" | None"))
        if field.init and kind is not None:
            convert, count = kind
            yield field, quantity(field.metadata["unit"]) if "unit" in field.metadata else convert, count


def _field_texts(cls: type) -> Iterator[tuple[str, str]]:
    """Yield the fields that the docstring of a class describes under Parameters, with their descriptions."""
    section = re.search(r"^Parameters\n-+\n(.*?)(?:\n\n\S|\Z)", inspect.getdoc(cls) or "", re.DOTALL | re.MULTILINE)
    for names, text in re.findall(r"^(\w[\w, ]*)\n((?:[ ]+.*\n?)+)", section[1] if section else "", re.MULTILINE):
        for name in names.split(", "):
            yield name, " ".join(text.split())
