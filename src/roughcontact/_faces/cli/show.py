"""``roughcontact info`` and ``roughcontact plot``: a height map or a saved solution, in words and as a picture."""

from __future__ import annotations

import argparse
import zipfile
from pathlib import Path
from typing import Any

import roughcontact as rc
from roughcontact._base import checks
from roughcontact._base.units.text import fit
from roughcontact._faces.cli import Command
from roughcontact._faces.cli.answers import to_json, to_text
from roughcontact._faces.cli.maps import describe_map, list_warnings
from roughcontact._faces.cli.options import add_reading
from roughcontact._faces.cli.outputs import plan_picture
from roughcontact._faces.cli.problem import read_map
from roughcontact._faces.panels.figures import save_figure


class Info(Command):
    """Describe a height map, or a solution that was saved."""

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
        """Print what the file holds, and return 0."""
        subject = _read(options)
        if isinstance(subject, rc.ContactSolution):
            print((to_json if options.json else to_text)([subject]))
        elif options.json:
            raise rc.InputError("--json is for solutions: omit it for a height map.")
        else:
            print(describe_map(subject))
        return 0


class Plot(Command):
    """Draw a height map, or a solution that was saved."""

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
        parser.add_argument("-o", "--output", required=True, metavar="FILE", help="picture to write: .png, .svg, .pdf")

    def run(self, options: argparse.Namespace) -> int:
        """Draw what the file holds, and return 0."""
        path = plan_picture(options.output)
        subject = _read(options)
        save_figure(subject.plot(panel=options.panel, dark=options.dark), path)
        print(fit(f"Written: {path}"))
        for text in list_warnings(subject) if isinstance(subject, rc.HeightMap) else ():
            print(text)
        return 0


def _read(options: argparse.Namespace) -> Any:
    """Return the solution or the height map of a file."""
    path = checks.path(options.surface, "The file")
    return rc.ContactSolution.load(path) if _holds_solution(path) else read_map(options)


def _holds_solution(path: Path) -> bool:
    if path.suffix == ".nc":
        return True
    try:
        with zipfile.ZipFile(path) as archive:
            return "displacement.npy" in archive.namelist()
    # What is not an archive is read as a height map, whose reader says what is wrong.
    except (OSError, zipfile.BadZipFile):
        return False
