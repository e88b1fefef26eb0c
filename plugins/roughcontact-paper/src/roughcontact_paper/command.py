"""``roughcontact paper``."""

from __future__ import annotations

import argparse
from pathlib import Path

from roughcontact.typing import Command


class Paper(Command):
    """Recompute the tables and figures of the paper on the grid dependence of the contact area."""

    def declare(self, parser: argparse.ArgumentParser) -> None:
        """Declare the part of the paper, its finest grid and the output folder."""
        parser.add_argument("--pairs", action="store_true", help="Tables 4, 5 and Figures 8 to 13, on a synthetic pair")
        parser.add_argument("--full", action="store_true", help="include the grid of 2048 x 2048 cells")
        parser.add_argument(
            "-o", "--output", default="paper-results", metavar="FOLDER", help="output folder (paper-results)"
        )

    def run(self, options: argparse.Namespace) -> int:
        """Solve all cases, print the tables, write CSV files and figures; return 0."""
        from roughcontact_paper import published
        from roughcontact_paper.sections import recompute_pair, recompute_wave

        folder = Path(options.output)
        folder.mkdir(parents=True, exist_ok=True)
        recompute = recompute_pair if options.pairs else recompute_wave
        recompute(folder, published.GRIDS if options.full else published.GRIDS[:-1])
        if not options.full:
            print("The grid of 2048 x 2048 cells is omitted; --full includes it.")
        return 0
