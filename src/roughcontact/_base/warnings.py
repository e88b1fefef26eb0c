"""A warning as a value: a sentence that knows which rule found it, and the number that it found."""

from __future__ import annotations

import math
import re

# A number, and the prefix of its unit.
_NUMBER = re.compile(r"\d[\d.]*(?:e[+-]?\d+)?(?: [fpnµmkMGT]?(?=Pa|m|N))?")


class ContactWarning(str):
    """Why a number or a contact must not be trusted, in a sentence that suits every reader.

    Parameters
    ----------
    text
        What was found, and what to do about it.
    rule
        Name of the rule that found it, such as ``"resolution"`` or ``"tilt"``.
    value
        The number that broke it, in the unit of the rule; nan where there is none.

    Examples
    --------
    >>> import roughcontact as rc
    >>> heights = rc.SphereSurface(radius=1e-3).heights(rc.Grid((32, 32), 100e-6))
    >>> problem = rc.ContactProblem(rc.Body(rc.HeightMap(heights, size=100e-6), rc.Elastic(210e9, 0.3)))
    >>> for warning in problem.solve(force=60.0).warnings:
    ...     print(warning.rule, f"{warning.value:.2f}")
    edge contact 1.00
    """

    rule: str
    value: float

    def __new__(cls, text: str, rule: str = "", value: float = math.nan) -> ContactWarning:
        made = super().__new__(cls, text)
        made.rule = rule
        made.value = value
        return made

    def __getnewargs__(self) -> tuple[str, str, float]:  # type: ignore[override]
        return str(self), self.rule, self.value


def warn_about(name: str, warning: str) -> ContactWarning:
    """Return a warning of an estimate as one that names it: the contact area, the maximum pressure."""
    value: float = getattr(warning, "value", math.nan)
    return ContactWarning(f"The {name} is uncertain: {warning}", f"{name}: {kind_of(warning)}", value)


def kind_of(warning: str) -> str:
    """Return the rule of a warning; of a mere text, from a file or a plug-in, what it says without its numbers."""
    return getattr(warning, "rule", "") or _NUMBER.sub("#", warning)
