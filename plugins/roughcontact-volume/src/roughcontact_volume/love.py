"""The stress below a pressed cell of a half-space, mean over a layer: Love's solution, integrated in closed form."""

from __future__ import annotations

import math

import numpy as np
from roughcontact.typing import Array, Pair

# Whether a component is odd along x and along y: xx, yy, zz, yz, xz, xy.
ODD = ((False, False), (False, False), (False, False), (False, True), (True, False), (True, True))
# Images of a cell on each side that are added one by one: more change the stress by less than 1e-6 of the pressure.
_IMAGES = 4


def mean_stress_below_cell(top: float, bottom: float, poisson: float, shape: tuple[int, int], sides: Pair) -> Array:
    r"""Return the mean over a layer of the stress by unit pressure on a cell, at offsets from it, shape (6, nx, ny).

    With the corners :math:`X, Y` of the cell seen from the point, :math:`R^2 = X^2 + Y^2 + z^2` and
    :math:`L_X = \operatorname{arsinh}(Y / \sqrt{X^2 + z^2})`, Love's terms have the integrals over the depth

    .. math:: \int \arctan\frac{XY}{zR}\,dz &= z \arctan\frac{XY}{zR} - X L_X - Y L_Y, \quad
              \int \frac{z X Y}{R (X^2 + z^2)}\,dz = -X L_X, \\
              \int \frac{z^2 X}{R (Y^2 + z^2)}\,dz &= X \operatorname{arsinh}\frac{z}{\sqrt{X^2 + Y^2}}
              - Y \arctan\frac{XZ}{YR}, \quad \int \ln(R + z)\,dz = z \ln(R + z) - R.

    Parameters
    ----------
    top, bottom
        Depths of the layer, in the unit of the sides.
    poisson
        Poisson's ratio.
    shape
        Offsets (nx, ny) of the point from the centre of the cell: 0 .. nx-1 cells along x, 0 .. ny-1 along y.
    sides
        Sides of the cell.

    References
    ----------
    Love, Phil. Trans. R. Soc. A 228 (1929) 377-420, https://doi.org/10.1098/rsta.1929.0009
    """
    x, y = (np.asarray((np.arange(n + 1.0) - 0.5) * side) for n, side in zip(shape, sides, strict=True))
    strips = _mean_over_strips(x, y, top, bottom, poisson)
    return strips[:, :, 1:] - strips[:, :, :-1]


def mean_stress_below_row(top: float, bottom: float, poisson: float, shape: tuple[int, int], sides: Pair) -> Array:
    """Return what `mean_stress_below_cell` does, of a cell that repeats along y after as many cells as there are.

    The nearest images are added one by one. Those beyond are a strip of the mean pressure, without its middle.
    """
    nx, ny = shape
    kept = ny // 2 + 1
    near = mean_stress_below_cell(top, bottom, poisson, (nx, _IMAGES * ny + kept), sides)
    mirror = np.where([odd for _, odd in ODD], -1.0, 1.0)[:, np.newaxis, np.newaxis]
    half = near[:, :, :kept].copy()
    for start in range(ny, (_IMAGES + 1) * ny, ny):
        half += near[:, :, start : start + kept]
        half += mirror * near[:, :, start - kept + 1 : start + 1][:, :, ::-1]
    x = (np.arange(nx + 1.0) - 0.5) * sides[0]
    reach = (_IMAGES + 0.5) * ny * sides[1]
    ends = np.array([-reach, reach])[:, np.newaxis] + np.arange(kept) * sides[1]
    places = ends + np.array([-1.0, 0.0, 1.0])[:, np.newaxis, np.newaxis] * sides[1]
    strips = _mean_over_strips(x, places.ravel(), top, bottom, poisson).reshape(6, nx, *places.shape)
    outer = _integrate_edges(x, bottom, poisson) - _integrate_edges(x, top, poisson)
    outer = np.diff(outer, axis=1)[:, :, np.newaxis] / (math.pi * (bottom - top))
    half += (outer - np.diff(strips[:, :, 1], axis=2)[:, :, 0]) / ny
    # The sum over middles is the integral but for its slope at the end, by Euler and Maclaurin.
    slopes = np.diff(np.diff(strips, n=2, axis=2)[:, :, 0], axis=2)[:, :, 0]
    half += (ny - 1.0 / ny) / 24.0 * slopes
    # A component that is odd along y is zero where the distances to both neighbours are equal.
    if ny % 2 == 0:
        half[mirror[:, 0, 0] < 0.0, :, -1] = 0.0
    return np.concatenate((half, mirror * half[:, :, ny - kept : 0 : -1]), axis=2)


def _mean_over_strips(x: Array, y: Array, top: float, bottom: float, poisson: float) -> Array:
    """Return the mean over a layer of the stress by strips between neighbours of x, up to y, shape (6, nx, ny)."""
    table = np.empty((6, x.size - 1, y.size))
    factor = 0.5 / (math.pi * (bottom - top))
    upper = _integrate_corners(x[:, np.newaxis], y[np.newaxis, :], top, poisson)
    for place, lower in enumerate(_integrate_corners(x[:, np.newaxis], y[np.newaxis, :], bottom, poisson)):
        lower -= upper[place]
        np.multiply(lower[1:] - lower[:-1], factor, out=table[place])
    return table


def _integrate_corners(x: Array, y: Array, z: float, poisson: float) -> tuple[Array, ...]:
    """Return the integrals over the depth of a corner's terms, without functions of (x, z) or of (y, z) alone."""
    square = x * x + y * y
    r = np.sqrt(square + z * z)
    log_x = x * np.arcsinh(y / np.hypot(x, z))
    log_y = y * np.arcsinh(x / np.hypot(y, z))
    slope = np.arcsinh(z / np.sqrt(square))
    angle = z * np.arctan2(x * y, z * r)
    # The difference of both arc tangents as one of them, R - z without cancellation.
    turn = z * np.arctan(x * y * (square / (r + z)) / (x * x * r + z * (y * y)))
    shear = 1.0 - 2.0 * poisson
    v = angle - log_x - log_y
    c = shear * (turn - log_x)
    return (
        -log_x - 2.0 * poisson * v - c,
        -log_y - v + c,
        2.0 * (log_x + log_y) - angle,
        x * slope - y * np.arctan(x * z / (y * r)),
        y * slope - x * np.arctan(y * z / (x * r)),
        -(shear * (z * np.log(r + z) - r) + r),
    )


def _integrate_edges(x: Array, z: float, poisson: float) -> Array:
    """Return what half of the corners' terms are at an infinite y, but for functions of x alone, shape (6, nx)."""
    log = -0.5 * x * np.log(x * x + z * z)
    angle = z * np.arctan2(x, z)
    none = np.zeros_like(x)
    rest = angle - log
    return np.array([-log - rest, -2.0 * poisson * rest, 2.0 * log - angle, none, -x * np.arctan(z / x), none])
