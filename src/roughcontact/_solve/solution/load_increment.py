"""What changes from one state of a contact to the next: load, time, sliding distance, and the place of the bodies."""

from __future__ import annotations

from typing import Any

import attrs
import numpy as np

from roughcontact._base.arrays import Array
from roughcontact._parts.grid import Load

# Cells by which the counterbody may be displaced to either side.
MAX_SHIFT = 2**40


def load_of(state: Any, kind: str) -> Load:
    """Return the normal load of a state, a `ContactSolution`, as a force, a pressure or an approach."""
    values = {"force": state.force, "pressure": state.mean_pressure, "approach": state.approach}
    return Load(kind, values[kind])


@attrs.frozen
class LoadIncrement:
    """What changes from one state to the next.

    Attributes
    ----------
    load
        The normal load at its end.
    time
        Its duration, s; zero: the load changes at once.
    sliding
        The distance by which the surfaces slide over each other in it, m.
    cycles
        The cycles for which it stands, of loads that return, along a path with friction: what slip changes in it
        happens as often.
    shift
        Cells (x, y) by which the counterbody is displaced at its end from its first place, periodically.
    """

    load: Load
    time: float = 0.0
    sliding: float = 0.0
    cycles: float = 1.0
    shift: tuple[int, int] = (0, 0)

    def place(self, values: float | Array) -> float | Array:
        """Return a field of the counterbody, a number or of shape (nx, ny), where it lies over the body."""
        return np.roll(values, self.shift, axis=(0, 1)) if np.ndim(values) and self.shift != (0, 0) else values

    def place_back(self, values: float | Array) -> float | Array:
        """Return a field over the body, a number or of shape (nx, ny), on the counterbody."""
        return attrs.evolve(self, shift=(-self.shift[0], -self.shift[1])).place(values)
