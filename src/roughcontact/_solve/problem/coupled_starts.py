"""Where the solves of coupled pressure and traction start: from the increments, and the passes, before."""

from __future__ import annotations

import attrs
import numpy as np

from roughcontact._base.arrays import Array
from roughcontact._parts.grid import Load
from roughcontact._solve.problem.friction_certificate import FrictionalFields
from roughcontact._solve.solution import FrictionalState, TangentialLoad
from roughcontact._solve.solvers import magnitude

# Change of the loads across that of the increment before, over it, up to which it continues it, and over that change
# along it up to which tractions are extrapolated.
_TURN = 1e-2
_MAX_RATIO = 2.0
# Part of a strength that counts as reached by the traction from which a solve starts.
_REACHED_STRENGTH = 1.0 - 1e-9


@attrs.frozen(eq=False)
class LastIncrement:
    """The last increment: the loads at both ends, its begin with the lift there (`FrictionalFields`), and its end."""

    loads: tuple[Array, Array]
    before: FrictionalState
    lifted: Array
    end: FrictionalFields


def list_loads(load: Load, tangential: TangentialLoad) -> Array:
    """Return the values of both loads, shape (3,)."""
    return np.array([load.value, *tangential.values])


def continue_increment(
    known: LastIncrement | None, start: FrictionalFields, loads: Array, unit: float
) -> tuple[Array | None, Array]:
    """Return the pressure from which an increment starts, Pa, and the displacement across the surface by its shear.

    They continue the increment before it if the loads do.

    Parameters
    ----------
    known
        The increment before, if it is known.
    start
        Its end, in dimensionless variables.
    loads
        The loads at the end of the next one.
    unit
        The pressure that counts as one, Pa.
    """
    pressure = start.pressure
    lifted = start.lifted
    ratio = 0.0 if known is None else find_ratio(known.loads, loads)
    if known is not None and ratio > 0.0:
        pressure = np.maximum(pressure + ratio * (pressure - known.before.pressure / unit), 0.0)
        lifted = lifted + ratio * (lifted - known.lifted)
    return pressure * unit if pressure.any() else None, lifted


def find_ratio(before: tuple[Array, Array], end: Array) -> float:
    """Return the change of the loads over that of the increment before; zero if it has another direction."""
    earlier = before[1] - before[0]
    later = end - before[1]
    # Forces, pressures and lengths are compared with their own changes.
    for part in (slice(1), slice(1, None)):
        scale = max(np.abs(earlier[part]).max(), np.abs(later[part]).max()) or 1.0
        earlier[part] /= scale
        later[part] /= scale
    if not earlier.any():
        return 0.0
    ratio = float(later @ earlier) / float(earlier @ earlier)
    is_straight = np.abs(later - ratio * earlier).max() <= _TURN * np.abs(later).max()
    return ratio if is_straight and 0.0 < ratio <= _MAX_RATIO else 0.0


def keep_sliding(shear: Array, before: Array, limit: Array) -> Array:
    """Return a traction to start from, which reaches the strength where it reached the one before.

    Where a strength that was reached grows a little, cells would stick until the first step moves them beyond it.
    """
    reached = (before > 0.0) & (magnitude(shear) >= _REACHED_STRENGTH * before)
    return shear * np.divide(limit, before, out=np.ones_like(limit), where=reached)
