"""A load, to be put on one problem after another."""

from __future__ import annotations

import attrs

from roughcontact.checks import Array
from roughcontact.problem import ContactProblem
from roughcontact.solution import ContactSolution
from roughcontact.units import si


@attrs.frozen(kw_only=True)
class Load:
    """Exactly one of the three, as `ContactProblem.solve` takes it.

    Attributes
    ----------
    pressure, force, approach
        Nominal mean pressure, Pa; normal force, N; approach since first touch, m.
    """

    pressure: float | None
    force: float | None
    approach: float | None

    def require(self, problem: ContactProblem) -> None:
        """Raise `InputError` unless it is one load, and the problem can carry it."""
        problem.require_load(pressure=self.pressure, force=self.force, approach=self.approach)

    def solve(self, problem: ContactProblem, start: Array | None = None) -> ContactSolution:
        """Return the problem's solution under this load, from a pressure of shape (nx, ny), Pa, if one is given."""
        return problem.solve(pressure=self.pressure, force=self.force, approach=self.approach, start=start)

    def __str__(self) -> str:
        given = {"pressure": (self.pressure, "Pa"), "force": (self.force, "N"), "approach": (self.approach, "m")}
        return " ".join(f"{name} {si(value, unit)}" for name, (value, unit) in given.items() if value is not None)
