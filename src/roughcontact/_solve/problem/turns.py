"""Contact and response in turn, for a contact to whose gap something adds that it causes itself."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import attrs
import numpy as np

from roughcontact._base.arrays import Array
from roughcontact._parts.grid import Load
from roughcontact._solve.problem.plan import SolvePlan
from roughcontact._solve.problem.task import pressure_unit
from roughcontact._solve.solution import ContactConditions, ContactSolution, Violation

# Turns after which a solve is given up.
_MAX_TURNS = 250
# Error of a contact, over that with its response, of which it makes up all.
_UNSOLVED_PART = 1.1
# Earlier turns that are combined with one (Anderson).
_MIXED_TURNS = 8
# Smallest error of a contact in a turn, over the tolerance.
_TIGHTEST_INNER = 0.3


@attrs.frozen(eq=False)
class Response:
    """A contact on a gap with an offset, and what it adds to the gap.

    Attributes
    ----------
    contact
        The contact.
    offset
        What it adds, shape (nx, ny), in the unit of the offset.
    error
        Error of the contact on the gap with what it adds.
    own_error
        Error of the response itself.
    damping
        The part of the change of the offset with which to go on.
    is_last
        Whether another turn would not help.
    """

    contact: ContactSolution
    offset: Array
    error: float
    own_error: float = 0.0
    damping: float = 1.0
    is_last: bool = False


def take_turns(
    respond: Callable[[Array, float], Response],
    offset: Array,
    tolerance: float,
    tell: Callable[[int, float], object] = lambda turns, error: None,
) -> tuple[Response, int]:
    """Return the response to the contact that it does not change any more, and the number of turns.

    That contact has the iterations and convolutions of all of them.

    Parameters
    ----------
    respond
        Solves the contact on the gap with an offset, as accurately as the error of the last turn asks for.
    offset
        The offset of the first turn, shape (nx, ny).
    tolerance
        The error at which both are found; after many turns the last ones are returned.
    tell
        Called after each turn with their number and the error.
    """
    mixing = _Mixing()
    error = math.inf
    cost: dict[str, Any] = {"iterations": 0, "convolutions": 0}
    for turns in range(1, _MAX_TURNS + 1):
        response = respond(offset, error)
        error = response.error
        cost = {name: value + getattr(response.contact, name) for name, value in cost.items()}
        tell(turns, error)
        if response.is_last or max(error, response.own_error) <= tolerance:
            break
        change = response.offset - offset
        if max(response.own_error, _UNSOLVED_PART * response.contact.residuals.error) < error:
            offset = mixing.combine(offset, change, response.damping)
        else:
            # Changes by a rough response, or a contact that is hardly solved, are not those by the offset.
            offset = offset + response.damping * change
    return attrs.evolve(response, contact=attrs.evolve(response.contact, **cost)), turns


def choose_tolerance(error: float, tolerance: float, part: float, loosest: float) -> float:
    """Return the error of the next contact: a part of that of the last turn, between bounds over the tolerance."""
    return min(max(part * error, _TIGHTEST_INNER * tolerance), loosest * tolerance)


def measure_violation(plan: SolvePlan, left: Array, load: Load, pressure: Array, displacement: Array) -> Violation:
    """Return the violation of a pressure, Pa, as the contact on the gap that is left; it displaces by m."""
    length = plan.peak_to_valley
    unit = pressure_unit(plan)
    approach = load.value / length if load.kind == "approach" else None
    measured = True if plan.non_measured is None else ~plan.non_measured
    gap = left / length
    conditions = ContactConditions(gap, plan.pressure_limit / unit, approach, float(gap.std(where=measured)))
    return conditions.measure(pressure / unit, displacement / length)


class _Mixing:
    """The next field of a fixed-point iteration, from the last ones: Anderson's combination of smallest change."""

    def __init__(self) -> None:
        self._fields: list[Array] = []
        self._changes: list[Array] = []

    def combine(self, field: Array, change: Array, damping: float) -> Array:
        """Return the field from which to go on, after one and its change, of which a part is taken."""
        self._fields = [*self._fields[-_MIXED_TURNS:], field]
        self._changes = [*self._changes[-_MIXED_TURNS:], change]
        best = field
        left = change
        if len(self._changes) > 1:
            steps = np.stack([np.ravel(one - change) for one in self._changes[:-1]], axis=1)
            weights = np.linalg.lstsq(steps, -np.ravel(change), rcond=1e-10)[0]
            for weight, one, moved in zip(weights, self._fields, self._changes, strict=False):
                best = best + weight * (one - field)
                left = left + weight * (moved - change)
        return best + damping * left
