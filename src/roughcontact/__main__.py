"""The command ``roughcontact``."""

from __future__ import annotations

import argparse
import inspect
import io
import os
import re
import sys
import warnings
from collections.abc import Sequence

from roughcontact import __version__, show_versions
from roughcontact._base.units import fit
from roughcontact._faces.cli import Command, commands
from roughcontact._faces.cli.help import Parser, tell, wrap
from roughcontact._faces.cli.options import spell_options
from roughcontact.errors import InputError, MissingPackage, NotConverged, RoughContactError, UnexpectedError, shorten
from roughcontact.errors.door import translated
from roughcontact.errors.warning import saying_warnings

# The beginning of a negative number, such as -20nN.
_NEGATIVE = re.compile(r"-[.\d]")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit status: 1 for no certified answer, 2 for wrong input, 3 for warnings."""
    _prepare_streams()
    warnings.formatwarning = lambda message, *_, **__: f"{wrap(f'roughcontact: {message}')}\n"
    given = list(sys.argv[1:] if arguments is None else arguments)
    call = f"The command {shorten(given[0], 40)}" if given else "The command"
    try:
        with saying_warnings():
            return _answer(given)
    except ModuleNotFoundError as error:
        return _fail(f"This command needs {error.name}: pip install 'roughcontact[cli]'.", 2)
    except BrokenPipeError:
        # Whoever reads the output has enough, as head does; nor shall Python complain when it closes it.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return _PIPE_CLOSED
    except KeyboardInterrupt:
        return _fail("interrupted", 130)
    except Exception as error:
        known = translated(error, call)
        if isinstance(known, NotConverged):
            return _fail(known.reason, 1)
        return _fail(str(known), 1 if isinstance(known, UnexpectedError) else 2)


def _prepare_streams() -> None:
    for name in ("stdout", "stderr"):
        # A shell can close a stream: >&-.
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115 - it stays open
        # A terminal that cannot show a micro sign gets a question mark, not a traceback.
        if isinstance(stream := getattr(sys, name), io.TextIOWrapper):
            stream.reconfigure(errors="replace")


def _answer(given: Sequence[str]) -> int:
    """Run the command, or print the help; what is printed is out when it ends."""
    try:
        if given and not given[0].startswith("-"):
            return _run(given[0], given[1:])
        parser = _overview()
        if not given:
            parser.print_help()
            return _NO_ARGUMENTS
        options = parser.parse_args(given)
        if not options.version:
            parser.error("name a command")
        if options.verbose:
            show_versions()
        else:
            print(f"roughcontact {__version__}")
        return 0
    finally:
        sys.stdout.flush()


# The exit status without a command, or without arguments that it needs: the help is shown.
_NO_ARGUMENTS = 2
# The exit status when whoever reads the output has closed it: 128 and the number of SIGPIPE, as shells state it.
_PIPE_CLOSED = 141
_EPILOG = """
examples:
  roughcontact solve map.npz --pressure 10MPa --young 210GPa
  roughcontact solve map.npz --loads 1N 2N 5N --young 210GPa --csv > loads.csv
  roughcontact surface self-affine --hurst 0.8 --rms-height 100nm \\
      --shortest 2um --longest 100um --shape 256 256 --size 100um -o rough.npz
  roughcontact plot rough.npz -o rough.png

exit statuses:
  0    solved, without warnings
  1    no certified answer: not converged, or a check failed
  2    wrong input, or something is missing: one sentence says what
  3    solved, with warnings other than those of its area
  130  interrupted by Ctrl-C
  141  whoever reads the output, such as head, has closed it"""


def _fail(sentence: str, status: int) -> int:
    tell(f"roughcontact: {sentence}")
    return status


def _run(name: str, arguments: Sequence[str]) -> int:
    """Run one command. The others are not imported, so that a broken one stops nothing but itself."""
    command = _load(name)
    parser = Parser(
        prog=f"roughcontact {name}",
        description=fit(inspect.getdoc(command) or ""),
        epilog=f"Defaults are in parentheses.\n{command.epilog}".rstrip(),
    )
    try:
        command.declare(parser)
    except Exception as error:
        raise InputError(f"The command {name!r} cannot declare its arguments: {error}") from error
    parser.offer_topics()
    if not arguments and parser.needs_arguments:
        parser.print_help()
        return _NO_ARGUMENTS
    # A number with a minus is a value, not an option; a blank before it says so to argparse.
    options = parser.parse_args([f" {text}" if _NEGATIVE.match(text) else text for text in arguments])
    try:
        return command.run(options)
    except InputError as error:
        parser.topic = "all"
        shown = parser.format_help()
        names = [option for option in vars(options) if f"--{option.replace('_', '-')} " in shown]
        raise InputError(error.spell(spell_options(names), scripts=True)) from error


def _load(name: str) -> Command:
    if name == "app" and name not in commands:
        raise MissingPackage(
            "The page in the browser needs the package roughcontact-app: pip install 'roughcontact[app]', in a clone "
            "of the repository pip install ./plugins/roughcontact-app."
        )
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
        usage="roughcontact [-h] [--version [--verbose]] COMMAND ...",
        description="Contact of rough surfaces.",
        epilog="\n".join(["commands (each has a --help of its own):", *lines, _EPILOG]),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="store_true", help="show the version and exit")
    detailed = "with --version, also show those of packages and plug-ins, threads and memory"
    parser.add_argument("--verbose", action="store_true", help=detailed)
    return parser


if __name__ == "__main__":
    sys.exit(main())
