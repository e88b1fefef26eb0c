"""``roughcontact examples``: the height maps that the docs mention."""

from __future__ import annotations

import argparse
from pathlib import Path

import roughcontact as rc
from roughcontact._faces.cli import Command


class Examples(Command):
    """Write the example height maps that the docs mention: ball.npz, ring.npz, map.npz, map.csv, liner.npz."""

    epilog = """
examples:
  roughcontact examples
  roughcontact examples maps
"""

    def declare(self, parser: argparse.ArgumentParser) -> None:
        parser.add_argument("folder", nargs="?", default=".", metavar="FOLDER", help="where to (this folder)")

    def run(self, options: argparse.Namespace) -> int:
        """Write the files, print their names, and return 0."""
        before = set(Path(options.folder).glob("*"))
        for path in rc.examples.write(options.folder):
            print(f"{path}{' (already there)' if path in before else ''}")
        return 0
