"""The command ``roughcontact``."""

from __future__ import annotations

import argparse
import io
import sys
from collections.abc import Callable, Sequence

from roughcontact import __version__
from roughcontact.errors import MissingPackage, NotConverged, RoughContactError

_EXTRA = "roughcontact[cli]"


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit status."""
    # A terminal that cannot show a micro sign gets a question mark, not a traceback.
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")
    try:
        chosen = _parser().parse_args(arguments)
        command: Callable[[argparse.Namespace], int | None] = chosen.command
        return command(chosen) or 0
    except NotConverged as error:
        return _fail(str(error), 1)
    except RoughContactError as error:
        return _fail(str(error), 2)
    except OSError as error:
        return _fail(f"{error.strerror or error}" + (f": {error.filename}" if error.filename else ""), 2)
    except KeyboardInterrupt:
        return _fail("interrupted", 130)


def _fail(sentence: str, status: int) -> int:
    print(f"roughcontact: {sentence}", file=sys.stderr)
    return status


def _parser() -> argparse.ArgumentParser:
    try:
        from roughcontact.cli import check, options, pairs, paper, report, run, solve, stability
    except ImportError as error:
        raise MissingPackage(f"The command line needs {error.name}: pip install '{_EXTRA}'.") from error
    parser = argparse.ArgumentParser(prog="roughcontact", description="Contact of rough surfaces.")
    parser.add_argument("--version", action="version", version=f"roughcontact {__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    one = commands.add_parser("paper", help="recompute the tables and figures of the paper")
    one.add_argument("--full", action="store_true", help="with the grid of 2048 x 2048 cells")
    options.add_output(one, "paper-results")
    one.add_argument("--pairs", action="store_true", help="Table 5 and Figures 8 to 13 instead, on a stand-in pair")
    one.set_defaults(command=lambda chosen: (pairs if chosen.pairs else paper).run(chosen))
    other = commands.add_parser("solve", help="solve the contact of measured height maps")
    third = commands.add_parser("report", help="error against run time of the contact of measured height maps")
    fourth = commands.add_parser("stability", help="what the answer of a solve hangs on: digits, cells, tolerances")
    for command in (other, third, fourth):
        for declare in (options.add_surfaces, options.add_load, options.add_materials, options.add_parts):
            declare(command)
    options.add_area(other)
    options.add_area(fourth)
    fourth.add_argument("--gallery", action=stability.ShowGallery, help="run the built-in extreme scenes instead")
    fourth.set_defaults(command=stability.run)
    options.add_comparison(third)
    options.add_output(third, "contact-report")
    third.set_defaults(command=report.run)
    options.add_output(other, "contact-results")
    other.set_defaults(command=solve.run)
    study = commands.add_parser("run", help="run a study from its TOML file, or go on with it")
    study.add_argument("study", metavar="STUDY.toml", help="problems, loads, seeds and estimators")
    study.add_argument("--dry-run", action="store_true", help="print every plan, and solve nothing")
    study.add_argument("--workers", type=int, default=1, metavar="N", help="processes (1)")
    study.add_argument("-o", "--output", metavar="FOLDER", help="where the results go (named like the study)")
    study.set_defaults(command=run.run)
    part = commands.add_parser("check", help="try a registered part on the claims that its kind makes")
    check.declare(part)
    part.set_defaults(command=check.run)
    return parser


if __name__ == "__main__":
    sys.exit(main())
