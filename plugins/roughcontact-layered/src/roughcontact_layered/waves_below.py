"""Stress below layers by waves of loads that are constant on each cell: in all directions, with their aliases."""

from __future__ import annotations

import math

import numpy as np
import roughcontact as rc
import scipy

from roughcontact_layered.harmonics import FindWaves, add_angles, list_amplitudes
from roughcontact_layered.stack import Array

# Wave number times reach from which waves have decayed: exp(-18) = 2e-8.
_DECAYED = 18.0
# Nodes per octave of the wave number, between which splines have errors below 1e-7 of the load.
_NODES = 48
# Highest order of the aliases: those of a reach of a quarter of a cell.
_MAX_ORDER = 12


def sum_waves(find: FindWaves, load: str, qx: Array, qy: Array, spacing: tuple[float, float], reach: float) -> Array:
    """Return the stress at the centres of cells by waves of loads on cells, shape (6, m, n).

    Parameters
    ----------
    find
        The stress by waves along x.
    load
        ``"z"``, a pressure, or ``"x"``, a traction along x.
    qx, qy
        Wave numbers, shapes (m, 1) and (1, n), rad/m.
    spacing
        Sides of a cell (dx, dy), m.
    reach
        Distance over which the waves decay, m.

    Raises
    ------
    roughcontact.InputError
        If the layers are much thinner than a cell.
    """
    # A wave that is uniform along an axis has no aliases there.
    orders = [_count_orders(side, reach) if q.any() else 0 for side, q in zip(spacing, (qx, qy), strict=True)]
    table = _Table(find, load, _smallest(qx, qy), _DECAYED / reach)
    total = np.zeros((6, qx.shape[0], qy.shape[1]))
    along_x, along_y = (
        [_alias(q, order, side) for order in range(-most, most + 1)]
        for q, side, most in zip((qx, qy), spacing, orders, strict=True)
    )
    for x, cell_x in along_x:
        for y, cell_y in along_y:
            if math.hypot(np.abs(x).min(), np.abs(y).min()) <= table.last:
                total += cell_x * cell_y * table(x, y)
    return total


def _alias(q: Array, order: int, side: float) -> tuple[Array, Array]:
    """Return the aliases of waves along an axis, rad/m, and their amplitudes in unit load on cells."""
    wave = q + 2.0 * np.pi * order / side
    return wave, np.sinc(wave * side / (2.0 * np.pi))


def _count_orders(side: float, reach: float) -> int:
    order = math.ceil(max(_DECAYED * side / reach - np.pi, 0.0) / (2.0 * np.pi))
    if order > _MAX_ORDER:
        raise rc.InputError(
            f"The stress changes over {reach:.3g} m below the surface, which cells of {side:.3g} m do not resolve: "
            "take a finer grid, or thicker layers."
        )
    return order


def _smallest(qx: Array, qy: Array) -> float:
    steps = [np.abs(q[q != 0.0]).min() for q in (qx, qy) if np.any(q != 0.0)]
    return float(min(steps))


class _Table:
    """The stress by waves of all directions, from that by waves along x, tabulated over the wave number."""

    def __init__(self, find: FindWaves, load: str, first: float, last: float) -> None:
        self.load = load
        self.last = max(last, 2.0 * first)
        count = math.ceil(_NODES * math.log2(self.last / first)) + 8
        q = np.geomspace(0.99 * first, 1.01 * self.last, count)
        self.spline = scipy.interpolate.CubicSpline(np.log(q), list_amplitudes(find, load, q)[1], axis=1)

    def __call__(self, qx: Array, qy: Array) -> Array:
        """Return the components, shape (6, m, n); zero at the mean and where waves have decayed."""
        q = np.hypot(qx, qy)
        kept = np.nonzero((q > 0.0) & (q <= self.last))
        at = q[kept]
        result = np.zeros((6, *q.shape))
        cos = qx[kept[0], 0] / at
        sin = qy[0, kept[1]] / at
        result[:, kept[0], kept[1]] = add_angles(self.load, self.spline(np.log(at)), cos, sin)
        return result
