"""Claims about plug-ins, and the report of what was found."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

import attrs

from roughcontact.errors import InputError

Examination: TypeAlias = Callable[[Any], str]


class DoesNotApply(Exception):
    """A claim says nothing about this part."""


def require(holds: object, found: str) -> None:
    """Raise `AssertionError` with what was found unless the condition holds."""
    if not holds:
        raise AssertionError(found)


@attrs.frozen
class Finding:
    """What came of one claim.

    Attributes
    ----------
    claim
        Name of the claim.
    passed
        Whether it holds; true as well where it says nothing about the part.
    found
        What was found, in words.
    applies
        Whether the claim says anything about the part.
    """

    claim: str
    passed: bool
    found: str
    applies: bool = True

    @property
    def verdict(self) -> str:
        """Holds, BROKEN, or a dash where the claim does not apply."""
        if not self.applies:
            return "-"
        return "holds" if self.passed else "BROKEN"

    def __str__(self) -> str:
        return f"{self.verdict}  {self.claim}: {self.found}"


@attrs.frozen
class Claim:
    """Something that every part of one kind must do; `str` of it is its name.

    Attributes
    ----------
    kind
        The kind of part, such as ``"kernel"``.
    name
        The claim in a few words.
    examine
        Looks at a part and returns what it found, or raises `AssertionError`.
    """

    kind: str
    name: str
    examine: Examination = attrs.field(repr=False)

    def judge(self, part: object) -> Finding:
        """Return what was found; nothing is raised."""
        try:
            return Finding(self.name, True, self.examine(part))
        except DoesNotApply as reason:
            return Finding(self.name, True, f"does not apply: {reason}", applies=False)
        except (AssertionError, InputError) as error:
            return Finding(self.name, False, str(error))
        # Plug-ins fail in as many ways as there are; a report goes on to the next claim.
        except Exception as error:
            return Finding(self.name, False, f"raised {type(error).__name__}: {error}")

    def check(self, part: object) -> None:
        """Raise `AssertionError`, with what was found, if the claim is broken."""
        finding = self.judge(part)
        require(finding.passed, f"{part!r} breaks the claim {self.name!r}: {finding.found}")

    def __str__(self) -> str:
        return self.name


@attrs.frozen
class Report:
    """The findings of all claims about one part; `str` of it is a table.

    Attributes
    ----------
    part
        What was examined, as it prints.
    kind
        The kind of part.
    findings
        One for each claim.
    """

    part: str
    kind: str
    findings: tuple[Finding, ...]

    @property
    def passed(self) -> bool:
        """Whether no claim is broken."""
        return all(finding.passed for finding in self.findings)

    @property
    def failures(self) -> tuple[Finding, ...]:
        """The broken claims."""
        return tuple(finding for finding in self.findings if not finding.passed)

    def raise_for_failures(self) -> None:
        """Raise `AssertionError` that lists the broken claims, if there are any."""
        require(self.passed, "\n".join((self._headline(), *(f"  {finding}" for finding in self.failures))))

    def _headline(self) -> str:
        asked = sum(finding.applies for finding in self.findings)
        others = len(self.findings) - asked
        silent = f", {others} {'does' if others == 1 else 'do'} not apply" if others else ""
        return f"{self.kind} {self.part}: {asked - len(self.failures)} of {asked} claims hold{silent}"

    def __str__(self) -> str:
        width = max((len(finding.claim) for finding in self.findings), default=0)
        rows = (f"  {finding.verdict:<6}  {finding.claim:<{width}}  {finding.found}" for finding in self.findings)
        return "\n".join((self._headline(), *rows))
