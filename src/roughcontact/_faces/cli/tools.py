"""``roughcontact check``, ``completion`` and ``examples``: claims about parts, the tab key, and example maps."""

from __future__ import annotations

import argparse
import ast
import inspect
from pathlib import Path
from typing import TYPE_CHECKING, Any

import attrs

import roughcontact as rc
from roughcontact._base.registry import Registry
from roughcontact._base.units import fit
from roughcontact._faces.cli import Command, commands
from roughcontact._faces.cli.answers import write_json
from roughcontact._faces.cli.help import Parser
from roughcontact._solve.problem import describe_part
from roughcontact.errors import InputError

if TYPE_CHECKING:
    from roughcontact.testing import Report


class Check(Command):
    """Try a registered part on the claims of its kind."""

    epilog = """
examples:
  roughcontact check love
  roughcontact check elastic --with young=200e9 poisson=0.3
"""

    def declare(self, parser: argparse.ArgumentParser) -> None:
        from roughcontact.testing import KINDS

        parser.add_argument("name", metavar="NAME", help="registered name of a kernel, solver, area estimator, ...")
        known = ", ".join(KINDS)
        parser.add_argument("--kind", choices=tuple(KINDS), metavar="KIND", help=f"{known} (every kind with the name)")
        parser.add_argument(
            "--with",
            dest="fields",
            nargs="+",
            default=[],
            metavar="FIELD=VALUE",
            help="its fields, in SI units, such as young=200e9 poisson=0.3",
        )
        parser.add_argument("--json", action="store_true", help="print one JSON object: the part and its claims")
        rows = (fit(f"  {kind:19} {', '.join(registry)}") for kind, registry in KINDS.items())
        parser.epilog = "\n".join([parser.epilog or "", "", "names:", *rows])

    def run(self, options: argparse.Namespace) -> int:
        """Return 0, or 1 if a claim does not hold."""
        from roughcontact.testing import KINDS, check

        candidates = {kind: tuple(registry) for kind, registry in KINDS.items() if options.kind in (None, kind)}
        kinds = [kind for kind, names in candidates.items() if options.name in names]
        if not kinds:
            what = KINDS[options.kind].kind if options.kind else "part"
            known = set().union(*candidates.values())
            raise InputError.unknown(what, options.name, known, "'roughcontact check --help'")
        fields = dict(_field(text) for text in options.fields)
        parts = [_create(KINDS[kind], options.name, fields) for kind in kinds]
        reports = [check(part, kind) for part, kind in zip(parts, kinds, strict=True)]
        if options.json:
            described = [_describe(part, report) for part, report in zip(parts, reports, strict=True)]
            print(write_json(described[0] if len(described) == 1 else {"reports": described}))
        else:
            print("\n".join(fit(str(report)) for report in reports))
        return 0 if all(report.passed for report in reports) else 1


def _describe(part: object, report: Report) -> dict[str, Any]:
    """Return what was found of a part as data that JSON can hold."""
    claims = [attrs.asdict(one) for one in report.findings]
    return {"inputs": {report.kind: describe_part(part)}, "passed": report.passed, "claims": claims}


def _create(registry: Registry[Any], name: str, fields: dict[str, Any]) -> Any:
    cls = registry[name]
    try:
        inspect.signature(cls).bind(**fields)
    except TypeError as error:
        raise InputError(
            f"The {registry.kind} {name!r} cannot be created ({error}): give its fields, --with FIELD=VALUE ..."
        ) from error
    return cls(**fields)


def _field(text: str) -> tuple[str, Any]:
    name, equals, value = text.partition("=")
    if not equals or not name.isidentifier():
        raise InputError.about("A field of a part", text, "FIELD=VALUE, such as young=200e9")
    try:
        return name, ast.literal_eval(value)
    # The parser has no memory for deep nesting, in its own words.
    except Exception:
        return name, value


class Completion(Command):
    """Print a script with which a shell completes commands and options."""

    epilog = """
examples:
  mkdir -p ~/.local/share/bash-completion/completions
  roughcontact completion bash \\
      > ~/.local/share/bash-completion/completions/roughcontact
  roughcontact completion fish > ~/.config/fish/completions/roughcontact.fish
  roughcontact completion zsh > ~/.zfunc/_roughcontact
"""

    def declare(self, parser: argparse.ArgumentParser) -> None:
        parser.add_argument("shell", choices=("bash", "fish", "zsh", "tcsh"), help="the shell that will read it")

    def run(self, options: argparse.Namespace) -> int:
        """Print the script, and return 0."""
        try:
            import shtab
        except ImportError:
            raise rc.MissingPackage("Completion needs shtab: pip install 'roughcontact[cli]'.") from None
        print(shtab.complete(_all_commands(), shell=options.shell))
        return 0


def _all_commands() -> argparse.ArgumentParser:
    """Return one parser of all commands that can be loaded."""
    parser = Parser(prog="roughcontact")
    parser.add_argument("--version", action="store_true")
    parser.add_argument("--verbose", action="store_true")
    known = parser.add_subparsers()
    for name in commands:
        try:
            command = commands.create(name)
            one = known.add_parser(name, help=(type(command).__doc__ or "").partition("\n")[0])
            command.declare(one)
            one.offer_topics()
        # A broken command of a plug-in is not completed.
        except Exception:
            continue
    return parser


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
