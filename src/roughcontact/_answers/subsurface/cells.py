"""Love's stress below a cell under uniform pressure, for whole tables of offsets."""

from __future__ import annotations

import math
from typing import Any

import attrs
import numpy as np

from roughcontact._base.checks import Pair, RealArray
from roughcontact._base.machine import map_tiles, split

# The components of the stress in their order (Voigt's).
COMPONENTS = ("xx", "yy", "zz", "yz", "xz", "xy")
# Which components are odd in x, and in y; all others are even.
ODD_IN_X = (False, False, False, False, True, True)
ODD_IN_Y = (False, False, False, True, False, True)
# Values of a table that are computed at a time.
_TILE = 2**16


@attrs.frozen
class Depth:
    """A depth below a body's surface, and what the stress there depends on besides the pressure.

    Attributes
    ----------
    z
        Depth, in sides of a cell along x.
    poisson
        Poisson's ratio of the body.
    """

    z: float
    poisson: float


def cell_stress(depth: Depth, shape: tuple[int, int], sides: Pair, dtype: type[Any]) -> RealArray:
    r"""Return the stress by unit pressure on one cell, tension positive, shape (6, nx, ny), in the order `COMPONENTS`.

    With the corners :math:`X = x \pm a, Y = y \pm b` of the cell seen from the point, :math:`R^2 = X^2 + Y^2 + z^2`,
    :math:`V = -\arctan(XY / zR)` and :math:`C = \arctan(Y/X) - \arctan(zY / XR)`,

    .. math:: 2\pi\sigma_{xx} = \sum \pm [2\nu V - (1 - 2\nu) C - z V_{xx}], \quad
              2\pi\sigma_{zz} = \sum \pm [V + z (V_{xx} + V_{yy})], \ldots

    Parameters
    ----------
    depth
        The depth.
    shape
        Offsets (nx, ny) of the point from the centre of the cell: 0 .. nx-1 cells along x, 0 .. ny-1 along y.
    sides
        Sides of the cell.
    dtype
        Precision of the table: float32 or float64.

    References
    ----------
    Love, Phil. Trans. R. Soc. A 228 (1929) 377-420, https://doi.org/10.1098/rsta.1929.0009
    """
    # With one corner more than there are cells, from the one before the middle of the first cell.
    x = ((np.arange(shape[0] + 1) - 0.5) * sides[0]).astype(dtype)[:, np.newaxis]
    y = ((np.arange(shape[1] + 1) - 0.5) * sides[1]).astype(dtype)[np.newaxis, :]
    table = np.empty((len(COMPONENTS), *shape), dtype=dtype)

    def work(rows: slice) -> None:
        for place, corners in enumerate(_sum_corners(x[rows.start : rows.stop + 1], y, dtype(depth.z), depth.poisson)):
            across = np.subtract(corners[1:], corners[:-1])
            np.subtract(across[:, 1:], across[:, :-1], out=table[place, rows])

    map_tiles(work, split(shape[0], max(1, _TILE // shape[1])))
    return table


def _sum_corners(x: RealArray, y: RealArray, z: Any, poisson: float) -> tuple[RealArray, ...]:
    """Return the terms of one corner for each component; those that depend on x or on y alone are omitted."""
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
