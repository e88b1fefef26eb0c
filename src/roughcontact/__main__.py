"""The command ``roughcontact``."""

from __future__ import annotations

import argparse
import inspect
import io
import os
import sys
import warnings
from collections.abc import Sequence
from typing import NoReturn

from roughcontact import __version__
from roughcontact.cli import Command, commands
from roughcontact.errors import InputError, NotConverged, RoughContactError, UnexpectedError, shorten
from roughcontact.errors.door import translated
from roughcontact.units.text import fit


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit status: 1 for no certified answer, 2 for wrong input, 3 for warnings."""
    # A terminal that cannot show a micro sign gets a question mark, not a traceback.
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")
    warnings.formatwarning = lambda message, *_, **__: f"roughcontact: {message}\n"
    given = list(sys.argv[1:] if arguments is None else arguments)
    call = f"The command {shorten(given[0], 40)}" if given else "The command"
    try:
        if given and not given[0].startswith("-"):
            status = _run(given[0], given[1:])
            sys.stdout.flush()
            return status
        parser = _overview()
        parser.parse_args(given)
        parser.error("name a command")
    except ModuleNotFoundError as error:
        return _fail(f"This command needs {error.name}: pip install 'roughcontact[cli]'.", 2)
    except BrokenPipeError:
        # Whoever reads the output has enough, as head does; nor shall Python complain when it closes it.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except KeyboardInterrupt:
        return _fail("interrupted", 130)
    except Exception as error:
        known = translated(error, call)
        return _fail(str(known), 1 if isinstance(known, (NotConverged, UnexpectedError)) else 2)


_EPILOG = """
examples:
  roughcontact solve map.npz --pressure 10MPa --young 210GPa
  roughcontact solve map.npz --loads 1N 2N 5N --young 210GPa --csv > loads.csv
  roughcontact surface self-affine --hurst 0.8 --rms-height 100nm \\
      --shortest 2um --longest 100um --shape 256 256 --size 100um -o map.npz
  roughcontact plot map.npz -o map.png

exit statuses:
  0    solved, without warnings
  1    no certified answer: not converged, or a check failed
  2    wrong input, or something is missing: one sentence says what
  3    solved, with warnings other than those of its area
  130  interrupted by Ctrl-C"""


class _Parser(argparse.ArgumentParser):
    """A parser whose errors do not repeat thousands of characters."""

    def error(self, message: str) -> NoReturn:
        super().error(shorten(message, 400))


def _fail(sentence: str, status: int) -> int:
    print(f"roughcontact: {sentence}", file=sys.stderr)
    return status


def _run(name: str, arguments: Sequence[str]) -> int:
    """Run one command. The others are not imported, so that a broken one stops nothing but itself."""
    command = _load(name)
    parser = _Parser(
        prog=f"roughcontact {name}",
        description=fit(inspect.getdoc(command) or ""),
        epilog=f"Defaults are in parentheses.\n{command.epilog}".rstrip(),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    try:
        command.declare(parser)
    except Exception as error:
        raise InputError(f"The command {name!r} cannot declare its arguments: {error}") from error
    return command.run(parser.parse_args(arguments))


def _load(name: str) -> Command:
    try:
        return commands.create(name)
    except SystemExit as error:
        raise InputError(f"The command {name!r} cannot be loaded: its module exits.") from error


def _overview() -> argparse.ArgumentParser:
    """Return the parser of the options that stand before a command; its help lists the commands."""
    lines = []
    for name in commands:
        try:
            lines.append(fit(f"  {name:12}{(inspect.getdoc(_load(name)) or '').partition(chr(10))[0]}"))
        except RoughContactError:
            lines.append(f"  {name:12}(cannot be loaded: 'roughcontact {name}' says why)")
    parser = argparse.ArgumentParser(
        prog="roughcontact",
        usage="roughcontact [-h] [--version] COMMAND ...",
        description="Contact of rough surfaces.",
        epilog="\n".join(["commands (each has a --help of its own):", *lines, _EPILOG]),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"roughcontact {__version__}")
    return parser


if __name__ == "__main__":
    sys.exit(main())
