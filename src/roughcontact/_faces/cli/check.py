"""``roughcontact check``: what must hold of a registered part, tried."""

from __future__ import annotations

import argparse
import ast
import inspect
from typing import Any

from roughcontact._base.registry import Registry
from roughcontact._base.units.text import fit
from roughcontact._faces.cli import Command
from roughcontact.errors import InputError


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

    def run(self, options: argparse.Namespace) -> int:
        """Return 0, or 1 if a claim does not hold."""
        from roughcontact.testing import KINDS, check

        candidates = {kind: tuple(registry) for kind, registry in KINDS.items() if options.kind in (None, kind)}
        kinds = [kind for kind, names in candidates.items() if options.name in names]
        if not kinds:
            what = KINDS[options.kind].kind if options.kind else "part"
            raise InputError.unknown(what, options.name, set().union(*candidates.values()))
        fields = dict(_field(text) for text in options.fields)
        reports = [check(_create(KINDS[kind], options.name, fields), kind) for kind in kinds]
        for report in reports:
            print(fit(str(report)))
        return 0 if all(report.passed for report in reports) else 1


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
