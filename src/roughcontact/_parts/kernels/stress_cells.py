"""Stress below a cell with a uniform load on a half-space: Love's and Cerruti's solutions."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from roughcontact._base.arrays import Pair, RealArray
from roughcontact._base.machine import map_tiles, split

# The components of the stress, in Voigt's order.
STRESS_COMPONENTS = ("xx", "yy", "zz", "yz", "xz", "xy")
# Their places after an exchange of the axes x and y.
EXCHANGED_COMPONENTS = [1, 0, 2, 4, 3, 5]
# Values of a table that are computed at a time.
_TILE_VALUES = 2**16


def cell_stress(
    z: float, poisson: float, shape: tuple[int, int], sides: Pair, dtype: type[Any], load: str = "z"
) -> RealArray:
    r"""Return the stress by a unit load on one cell, tension positive, `STRESS_COMPONENTS`, shape (6, nx, ny).

    With the corners :math:`X = x \pm a, Y = y \pm b` of the cell seen from the point, :math:`R^2 = X^2 + Y^2 + z^2`,
    :math:`V = -\arctan(XY / zR)` and :math:`C = \arctan(Y/X) - \arctan(zY / XR)`, a pressure gives

    .. math:: 2\pi\sigma_{xx} = \sum \pm [2\nu V - (1 - 2\nu) C - z V_{xx}], \quad
              2\pi\sigma_{zz} = \sum \pm [V + z (V_{xx} + V_{yy})], \ldots

    and a traction along x, by integration of Cerruti's point force,

    .. math:: 2\pi\sigma_{xx} &= \sum \pm \left[2\ln(R + Y) + \frac{2\nu Y}{R + z} + \frac{zY}{R(R + z)}
              - \frac{z^2 Y}{R (X^2 + z^2)}\right], \\
              2\pi\sigma_{xy} &= \sum \pm \left[\ln(R + X) - \frac{2\nu X}{R + z} - \frac{zX}{R(R + z)}\right], \quad
              2\pi\sigma_{xz} = \sum \pm \left[V + \frac{zXY}{R (X^2 + z^2)}\right], \ldots

    Parameters
    ----------
    z
        Depth, in sides of a cell along x.
    poisson
        Poisson's ratio of the body.
    shape
        Offsets (nx, ny) of the point from the centre of the cell: 0 .. nx-1 cells along x, 0 .. ny-1 along y.
    sides
        Sides of the cell.
    dtype
        Precision of the table: float32 or float64.
    load
        ``"z"``, a pressure, or ``"x"`` or ``"y"``, a traction along this axis.

    References
    ----------
    Love, Phil. Trans. R. Soc. A 228 (1929) 377-420, https://doi.org/10.1098/rsta.1929.0009;
    Johnson, Contact Mechanics (1985), sec. 3.6, https://doi.org/10.1017/CBO9781139171731
    """
    if load == "y":
        exchanged = cell_stress(z, poisson, shape[::-1], sides[::-1], dtype, "x")
        return np.ascontiguousarray(exchanged[EXCHANGED_COMPONENTS].transpose(0, 2, 1))
    # One corner more than there are cells, from half a cell before the centre of the first cell.
    x = ((np.arange(shape[0] + 1) - 0.5) * sides[0]).astype(dtype)[:, np.newaxis]
    y = ((np.arange(shape[1] + 1) - 0.5) * sides[1]).astype(dtype)[np.newaxis, :]
    table = np.empty((len(STRESS_COMPONENTS), *shape), dtype=dtype)
    sum_corners = _sum_corners if load == "z" else _sum_shear_corners

    def work(rows: slice) -> None:
        for place, corners in enumerate(sum_corners(x[rows.start : rows.stop + 1], y, dtype(z), poisson)):
            across = np.subtract(corners[1:], corners[:-1])
            np.subtract(across[:, 1:], across[:, :-1], out=table[place, rows])

    map_tiles(work, split(shape[0], max(1, _TILE_VALUES // shape[1])))
    return table


def _sum_corners(x: RealArray, y: RealArray, z: Any, poisson: float) -> tuple[RealArray, ...]:
    """Return the terms of a corner under pressure for each component, without those of x or of y alone."""
    scale = 0.5 / math.pi
    shear = 1.0 - 2.0 * poisson
    xx = x * x
    yy = y * y
    xy = x * y
    square = xx + yy
    r = np.sqrt(square + z * z)
    # At the surface the quotient is infinite and its arc tangent a right angle.
    with np.errstate(divide="ignore", over="ignore"):
        v = np.arctan(xy / (z * r))
    beyond = r + z
    # The difference of both arc tangents as one of them, R - z without cancellation.
    c = np.arctan(xy * (square / beyond) / (xx * r + z * yy))
    along_x = 1.0 / (r * (xx + z * z))
    along_y = 1.0 / (r * (yy + z * z))
    bend_x = (z * scale) * xy * along_x
    bend_y = (z * scale) * xy * along_y
    v *= scale
    c *= scale * shear
    # V_xx + V_yy and both C together follow from Laplace's equation.
    return (
        bend_x - 2.0 * poisson * v - c,
        bend_y - v + c,
        -(v + bend_x + bend_y),
        (z * z * scale) * x * along_y,
        (z * z * scale) * y * along_x,
        -scale * (shear * np.log(beyond) + z / r),
    )


def _sum_shear_corners(x: RealArray, y: RealArray, z: Any, poisson: float) -> tuple[RealArray, ...]:
    """Return the terms of a corner under traction along x for each component, without those of x or of y alone."""
    scale = 0.5 / math.pi
    xx = x * x
    yy = y * y
    depth = z * z
    r = np.sqrt(xx + yy + depth)
    with np.errstate(divide="ignore", over="ignore"):
        v = np.arctan(x * y / (z * r))
    along_x = scale * z / (r * (xx + depth))
    beyond = r + z
    bend = scale * z / (r * beyond)
    lateral = scale * 2.0 * poisson / beyond
    # ln(R + Y) without its part in X, odd in Y; ln(R + X) likewise.
    log_y = scale * np.arcsinh(y / np.sqrt(xx + depth))
    log_x = scale * np.arcsinh(x / np.sqrt(yy + depth))
    return (
        2.0 * log_y + y * (lateral + bend - z * along_x),
        2.0 * poisson * log_y - y * (lateral + bend),
        z * y * along_x,
        -scale * z / r,
        x * y * along_x - scale * v,
        log_x - x * (lateral + bend),
    )
