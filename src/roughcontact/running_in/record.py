"""What comes out of running in."""

from __future__ import annotations

import attrs

from roughcontact.checks import Array
from roughcontact.problem import ContactProblem
from roughcontact.solution import Area, ContactSolution
from roughcontact.units import si


@attrs.frozen(kw_only=True)
class Cycle:
    """One load, flattening and unloading.

    Attributes
    ----------
    shift
        Cells (x, y) by which the other body was moved on.
    volume
        Volume flattened in this cycle, of both bodies, m3.
    deepest
        Greatest loss of height in this cycle, of both bodies, m.
    area, saturated
        Real contact area under load, and the part of it at the limit.
    approach
        Approach under load, m.
    """

    shift: tuple[int, int]
    volume: float
    deepest: float
    area: Area
    saturated: Area
    approach: float


@attrs.frozen(eq=False, kw_only=True)
class RunIn:
    """Surfaces run in, and how they came to be.

    Attributes
    ----------
    problem
        The problem with the residual topographies, unloaded, the other body where it was at first.
    cycles
        What each cycle did.
    shakedown
        Whether the last round of cycles flattened next to nothing.
    lowered
        Loss of height of the body and of the other body, each of shape (nx, ny), m.
    solution
        The last contact under load.
    """

    problem: ContactProblem
    cycles: tuple[Cycle, ...]
    shakedown: bool
    lowered: tuple[Array, Array]
    solution: ContactSolution

    @property
    def volume(self) -> float:
        """Volume flattened in all cycles, m3."""
        return sum(cycle.volume for cycle in self.cycles)

    def __str__(self) -> str:
        nominal = self.problem.plan.grid.area
        end = "shakedown" if self.shakedown else "no shakedown yet"
        lines = [f"{end} after {len(self.cycles)} cycles, {self.volume * 1e18:.4g} um3 flattened"]
        lines.append(
            f"{'cycle':>5} {'shift':>12} {'volume, um3':>12} {'deepest':>10} {'area, %':>8} {'at limit, %':>11}"
        )
        for number, cycle in enumerate(self.cycles, start=1):
            lines.append(
                f"{number:>5} {cycle.shift!s:>12} {cycle.volume * 1e18:>12.4g} {si(cycle.deepest, 'm', 3):>10} "
                f"{100 * cycle.area.value / nominal:>8.4g} {100 * cycle.saturated.value / nominal:>11.3g}"
            )
        return "\n".join(lines)
