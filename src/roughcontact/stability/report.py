"""Checks with verdicts, and the report that a person reads."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterable
from enum import StrEnum

import attrs

from roughcontact.solution import ContactSolution
from roughcontact.stability.rules import RULES

_WIDTH = 120


class Verdict(StrEnum):
    """What a check found; from good to bad, and what could not be looked at."""

    PASS = "pass"
    ATTENTION = "attention"
    FAIL = "fail"
    LEFT_OUT = "left out"


# From good to bad.
_ORDER = (Verdict.LEFT_OUT, Verdict.PASS, Verdict.ATTENTION, Verdict.FAIL)


def worst(verdicts: Iterable[Verdict]) -> Verdict:
    """Return the worst verdict; what was left out counts for nothing beside the others."""
    return max(verdicts, key=_ORDER.index, default=Verdict.LEFT_OUT)


@attrs.frozen
class Check:
    """One thing that was looked at.

    Attributes
    ----------
    name
        What was looked at.
    verdict
        What came out.
    value
        What was measured; nan where the check was left out.
    found
        The finding in words, or why the check was left out.
    advice
        What to do; empty where nothing needs to be done.
    """

    name: str
    verdict: Verdict
    value: float
    found: str
    advice: str = ""

    def __str__(self) -> str:
        value = "" if math.isnan(self.value) else f"{self.value:.3g}"
        text = f"{self.found}. {self.advice}".strip() if self.advice else self.found
        return _columns((self.verdict, self.name, value), text)


def judged(name: str, value: float, found: str) -> Check:
    """Return the check of this name with the verdict of its rule; a value that is no number fails."""
    rule = RULES[name]
    sign = 1.0 if rule.good <= rule.bearable else -1.0
    if sign * value <= sign * rule.good:
        return Check(name, Verdict.PASS, value, found)
    verdict = Verdict.ATTENTION if sign * value <= sign * rule.bearable else Verdict.FAIL
    return Check(name, verdict, value, found, rule.advice)


def left_out(name: str, reason: str) -> Check:
    """Return the check of this name as one that could not be done."""
    return Check(name, Verdict.LEFT_OUT, math.nan, reason)


@attrs.frozen(eq=False)
class StabilityReport:
    """What all checks found; `str` of it is a table.

    Attributes
    ----------
    checks
        The checks.
    solution
        The solution that was looked at.
    """

    checks: tuple[Check, ...]
    solution: ContactSolution

    @property
    def verdict(self) -> Verdict:
        """The worst of all verdicts."""
        return worst(check.verdict for check in self.checks)

    def __getitem__(self, name: str) -> Check:
        """Return the check of this name."""
        return next(check for check in self.checks if check.name == name)

    def __str__(self) -> str:
        head = _columns(("verdict", "check", "value"), "found; what to do")
        counts = [(verdict, sum(check.verdict is verdict for check in self.checks)) for verdict in Verdict]
        said = ", ".join(f"{count} {verdict}" for verdict, count in counts if count)
        return "\n".join([head, *map(str, self.checks), f"overall: {self.verdict} ({said})"])


def _columns(cells: tuple[str, str, str], text: str) -> str:
    left = f"{cells[0]:<10} {cells[1]:<35} {cells[2]:>9}  "
    return textwrap.fill(text, _WIDTH, initial_indent=left, subsequent_indent=" " * len(left))
