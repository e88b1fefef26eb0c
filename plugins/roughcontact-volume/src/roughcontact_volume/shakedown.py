"""Whether passes of a load shake down, flow in every pass, or are too few to tell."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import attrs
import numpy as np
import roughcontact as rc
from roughcontact.typing import Array, Mask, Table

from roughcontact_volume.flowed_body import FlowedBody, read_body
from roughcontact_volume.substeps import deepen

# New strain of a pass over the accumulated one, below which passes shake down.
_SHAKEN_DOWN = 1e-3
# Difference of the new strains of two passes, over the earlier one, below which a body flows in every pass.
_SAME_FLOW = 0.2
# Part of the track about its middle in which strains are compared: its ends see other passes.
_MIDDLE = 0.5


@attrs.frozen(eq=False)
class Passes:
    """Passes of a load along a track.

    Attributes
    ----------
    new_strain
        Largest accumulated plastic strain that each pass adds in the middle half of the track, shape (passes,).
    accumulated_strain
        Largest accumulated plastic strain there after each, shape (passes,).
    verdict
        ``"stays elastic"``: nothing flows; ``"shakes down"``: the last pass adds less than a thousandth of the
        accumulated strain; ``"flows in every pass"``: it adds as much as the one before but for a fifth; else
        ``"undecided"``.
    peak_pressure
        Largest pressure of the last pass, Pa.
    warnings
        Why it must not be trusted, in sentences; empty without a reason.
    """

    new_strain: Array
    accumulated_strain: Array
    verdict: str
    peak_pressure: float
    warnings: tuple[str, ...] = ()

    def table(self) -> Table:
        """Return a row for each pass."""
        columns: dict[str, Sequence[int] | Array] = {
            "pass": range(1, len(self.new_strain) + 1),
            "new_strain": self.new_strain,
            "accumulated_strain": self.accumulated_strain,
        }
        return Table(columns, {"new_strain": "", "accumulated_strain": ""})

    def __str__(self) -> str:
        last = self.new_strain[-1] / self.accumulated_strain[-1] if self.accumulated_strain[-1] > 0.0 else 0.0
        count = len(self.new_strain)
        text = f"{self.verdict} after {count} passes, of which the last adds {last:.2g} of the strain"
        return "\n".join([text, *(f"warning: {one}" for one in self.warnings)])


def judge_passes(path: Sequence[Any], places: int, body: str | None = None) -> Passes:
    """Return whether the passes of a load along a track shake down.

    Parameters
    ----------
    path
        A `LoadPath` with ``shift=``, whose places are those of one pass, repeated.
    places
        Number of places of a pass.
    body
        ``"body"`` or ``"counterbody"``; None: the one that flows.

    References
    ----------
    Johnson, Contact Mechanics (1985), sec. 9.2, https://doi.org/10.1017/CBO9781139171731

    Examples
    --------
    >>> import roughcontact as rc
    >>> from roughcontact_volume import Plastic, judge_passes
    >>> body = rc.Body(rc.FlatSurface(), Plastic("210GPa", 0.3, yield_stress="1GPa", hardening="20GPa", accuracy=0.2))
    >>> ball = rc.Body(rc.ParaboloidSurface("1mm"), rc.Rigid())
    >>> problem = rc.ContactProblem(body, ball, grid=rc.Grid((24, 12), ("104um", "52um")), boundary="periodic")
    >>> path = problem.path(force="0.3N", shift=2 * [(-4, 0), (0, 0), (4, 0)])
    >>> print(judge_passes(path, 3))
    stays elastic after 2 passes, of which the last adds 0 of the strain
    """
    states = tuple(path)
    whole = isinstance(places, int) and not isinstance(places, bool) and places > 0
    if not whole or len(states) < 2 * places or len(states) % places:
        allowed = f"a whole number of which the {len(states)} places of the path are at least twice a multiple"
        raise rc.InputError.about("The number of places of a pass", places, allowed)
    count = PassCount(read_body(body))
    for first in range(0, len(states), places):
        count.add(states[first : first + places])
    return count.judge()


@attrs.define(eq=False)
class PassCount:
    """What is kept of the passes of a load, one after the other: the strain after each, not their states."""

    body: str | None = None
    strains: list[Array] = attrs.field(factory=list)
    middle: Mask | None = None
    peak_pressure: float = 0.0
    warnings: tuple[str, ...] = ()

    def add(self, states: Sequence[Any]) -> None:
        """Add the states of the next pass."""
        bodies = [FlowedBody.of(state, self.body) for state in states]
        if self.middle is None:
            self.middle = _find_middle(bodies)
        self.strains.append(bodies[-1].flow.accumulated_strain)
        self.peak_pressure = max(float(body.pressure.max()) for body in bodies)
        self.warnings = tuple(dict.fromkeys((*self.warnings, *(text for body in bodies for text in body.warnings))))

    def judge(self) -> Passes:
        """Return whether they shake down."""
        middle, layers = self.middle, len(self.strains[-1])
        after = [np.zeros(self.strains[-1].shape), *(deepen(one, layers) for one in self.strains)]
        new = np.array([np.max((two - one)[:, middle]) for one, two in pairwise(after)])
        total = np.array([one[:, middle].max() for one in after[1:]])
        return Passes(new, total, judge_strains(new, total), self.peak_pressure, self.warnings)


def judge_strains(new: Array, total: Array) -> str:
    """Return the verdict on passes, from the strain that each adds and that after each; see `Passes`."""
    if total[-1] == 0.0:
        return "stays elastic"
    if new[-1] <= _SHAKEN_DOWN * total[-1]:
        return "shakes down"
    flows = len(new) > 1 and abs(new[-1] - new[-2]) < _SAME_FLOW * new[-2]
    return "flows in every pass" if flows else "undecided"


def _find_middle(bodies: Sequence[FlowedBody]) -> Mask:
    """Return the cells whose place along the track is in its middle, shape (nx, ny)."""
    grid = bodies[0].grid
    centres = np.array([_find_centre(body) for body in bodies])
    start, end = centres[0], centres[np.argmax(np.hypot(*(centres - centres[0]).T))]
    length = float(np.hypot(*(end - start)))
    if length == 0.0:
        return np.ones(grid.shape, dtype=bool)
    along = ((grid.x - start[0]) * (end - start)[0] + (grid.y - start[1]) * (end - start)[1]) / length**2
    return np.asarray(np.abs(along - 0.5) <= 0.5 * _MIDDLE)


def _find_centre(body: FlowedBody) -> Array:
    """Return the centre of the pressure on a body, around the ends of the grid too, m."""
    if not body.pressure.any():
        raise rc.InputError("A place of the passes carries no load.")
    total = float(body.pressure.sum())
    centre = []
    for axis, line in enumerate((body.grid.x[:, 0], body.grid.y[0])):
        turn = 2.0 * np.pi * (line / body.grid.size[axis])
        sums = body.pressure.sum(axis=1 - axis) / total
        centre.append(np.angle(np.sum(sums * np.exp(1j * turn))) / (2.0 * np.pi) * body.grid.size[axis])
    return np.array(centre)
