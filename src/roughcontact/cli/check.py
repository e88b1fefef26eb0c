"""``roughcontact check``: a registered name in, what holds of it out."""

from __future__ import annotations

import argparse
import ast
import difflib
from typing import Any

from roughcontact.errors import InputError
from roughcontact.registry import Registry
from roughcontact.testing import KINDS, check


def declare(parser: argparse.ArgumentParser) -> None:
    """Declare what is checked."""
    parser.add_argument("name", metavar="NAME", help="registered name of a kernel, solver, area estimator, ...")
    parser.add_argument("--kind", choices=tuple(KINDS), help="what it is (every kind that has the name)")
    parser.add_argument(
        "--with",
        dest="fields",
        nargs="+",
        default=[],
        metavar="FIELD=VALUE",
        help="what it is made with, in SI units, such as young=200e9 poisson=0.3",
    )


def run(options: argparse.Namespace) -> int:
    """Print a table of claims for each kind; return the exit status, 1 where a claim is broken."""
    kinds = [kind for kind in KINDS if options.kind in (None, kind) and options.name in KINDS[kind].names()]
    if not kinds:
        raise InputError(_unknown(options.name, options.kind))
    fields = dict(_field(text) for text in options.fields)
    reports = [check(_made(KINDS[kind], options.name, fields), kind) for kind in kinds]
    for report in reports:
        print(report)
    return 0 if all(report.passed for report in reports) else 1


def _made(registry: Registry, name: str, fields: dict[str, Any]) -> Any:
    made = registry.get(name)
    try:
        return made(**fields)
    except TypeError as error:
        raise InputError(
            f"The {registry.kind} {name!r} cannot be made so ({error}): say --with FIELD=VALUE, once for each field."
        ) from error


def _field(text: str) -> tuple[str, Any]:
    name, equals, value = text.partition("=")
    if not equals or not name.isidentifier():
        raise InputError.about("What a part is made with", text, "FIELD=VALUE, such as young=200e9")
    try:
        return name, ast.literal_eval(value)
    except (ValueError, SyntaxError):
        return name, value


def _unknown(name: str, kind: str | None) -> str:
    if kind is not None:
        return f"There is no {KINDS[kind].kind} named {name!r}. Known: {', '.join(KINDS[kind].names())}."
    names = sorted({known for registry in KINDS.values() for known in registry.names()})
    close = difflib.get_close_matches(name.lower(), names, n=1, cutoff=0.5)
    guess = f" Did you mean {close[0]!r}?" if close else ""
    return f"Nothing is registered as {name!r}.{guess} Known: {', '.join(names)}."
