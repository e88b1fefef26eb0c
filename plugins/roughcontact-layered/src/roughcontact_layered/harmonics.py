"""Stress by uniform load on a cell, from that of waves: Hankel's transforms of several orders, and sums over cells."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TypeAlias

import attrs
import numpy as np
import scipy
from numpy.polynomial import chebyshev, legendre

from roughcontact_layered.cells import integrate_gauss
from roughcontact_layered.radial import count_halvings, list_points
from roughcontact_layered.stack import Array

# Stress by waves along x with wave numbers q, shape (n,), by unit amplitude of the load: as of `below.find_excess`.
FindWaves: TypeAlias = Callable[[str, Array], Array]

# Chebyshev nodes per octave of the distance: see `radial`.
_NODES = 20
# Points per octave of the spline through them: its errors are below 1e-7 of the load.
_POINTS = 48
# Offsets, in shorter sides, and Gauss points across one of them: the cell itself in parts that halve towards its
# centre, those near, those between, and those beyond. Errors are below 1e-7 of the load.
_NEAR = 3
_FAR = 20
_NEAR_POINTS = 10
_BETWEEN_POINTS = 5
_FAR_POINTS = 2
# The factor i^k of Hankel's transform of order k, times the factor i that odd components lack.
_SIGNS = (1.0, -1.0, -1.0, 1.0)


def integrate_stress(
    find: FindWaves, load: str, shape: tuple[int, int], spacing: tuple[float, float], reach: float
) -> Array:
    """Return the stress at each offset from a cell with unit load, shape (6, nx, ny).

    Parameters
    ----------
    find
        The stress by waves along x.
    load
        ``"z"``, a pressure, or ``"x"``, a traction along x.
    shape
        Offsets (nx, ny): 0 .. nx-1 cells along x, 0 .. ny-1 along y.
    spacing
        Sides of a cell (dx, dy), m.
    reach
        Distance over which the waves decay, m.
    """
    own = [_halve_towards_zero(0.5 * side, reach)[0][0] for side in spacing]
    largest = math.hypot(*(n * side for n, side in zip(shape, spacing, strict=True)))
    result = integrate_cells(_tabulate(find, load, math.hypot(*own), largest, reach), 6, shape, spacing, reach)
    # At the centre of the load the odd components vanish.
    result[:, 0, 0] *= (1, 1, 1, 0, 0, 0) if load == "z" else (0, 0, 0, 0, 1, 0)
    # Exactly zero where the Gauss points on both sides cancel.
    for place, component in enumerate(("xx", "yy", "zz", "yz", "xz", "xy")):
        for axis, letter in enumerate("xy"):
            if (component + load).count(letter) % 2:
                result[(place, *((0, slice(None)) if axis == 0 else (slice(None), 0)))] = 0.0
    return result


def integrate_cells(
    field: Callable[[Array, Array], Array],
    count: int,
    shape: tuple[int, int],
    spacing: tuple[float, float],
    reach: float,
) -> Array:
    """Return the integrals of a field around a point over the cell at each offset, shape (count, nx, ny).

    That over the cell at the point itself is four times the integral over a quarter.

    Parameters
    ----------
    field
        Its components, shape (count, ...), at offsets along x and y, m.
    count
        Number of components.
    shape, spacing
        Offsets (nx, ny), and sides of a cell (dx, dy), m.
    reach
        Distance from the point up to which the field is smooth, m.
    """
    own = [_halve_towards_zero(0.5 * side, reach) for side in spacing]
    result = np.zeros((count, *shape))
    near, far = (
        tuple(min(n, math.ceil(cells * min(spacing) / side) + 1) for n, side in zip(shape, spacing, strict=True))
        for cells in (_NEAR, _FAR)
    )
    blocks = (
        (slice(far[0], None), slice(None), _FAR_POINTS),
        (slice(0, far[0]), slice(far[1], None), _FAR_POINTS),
        (slice(near[0], far[0]), slice(0, far[1]), _BETWEEN_POINTS),
        (slice(0, near[0]), slice(near[1], far[1]), _BETWEEN_POINTS),
        (slice(1, near[0]), slice(0, near[1]), _NEAR_POINTS),
        (slice(0, 1), slice(1, near[1]), _NEAR_POINTS),
    )
    for along_x, along_y, points in blocks:
        integrate_gauss(result, field, spacing, (along_x, along_y), points)
    (x, weights_x), (y, weights_y) = own
    result[:, 0, 0] = 4.0 * np.einsum("cij,i,j->c", field(x[:, np.newaxis], y[np.newaxis, :]), weights_x, weights_y)
    return result


def _halve_towards_zero(length: float, reach: float) -> tuple[Array, Array]:
    """Return Gauss points and weights on 0 .. length, in parts that halve towards zero down to the reach."""
    halvings = max(0, math.ceil(math.log2(2.0 * length / reach)))
    edges = np.concatenate(([0.0], length * 2.0 ** np.arange(-halvings, 1.0)))
    at, weight = legendre.leggauss(_NEAR_POINTS)
    half = 0.5 * np.diff(edges)[:, np.newaxis]
    return (edges[:-1, np.newaxis] + half * (at + 1.0)).ravel(), (half * weight).ravel()


@attrs.frozen(eq=False)
class _PointStress:
    """The stress around a point load: radial functions times sines and cosines of the angle, tabulated by octaves.

    Attributes
    ----------
    load
        ``"z"`` or ``"x"``.
    spline
        r^2 times each radial function, over the binary logarithm of r.
    """

    load: str
    spline: scipy.interpolate.CubicSpline

    def __call__(self, x: Array, y: Array) -> Array:
        """Return the components at offsets x and y, shape (6, ...), 1/m^2."""
        r = np.hypot(x, y)
        return add_angles(self.load, self.spline(np.log2(r)) / r**2, x / r, y / r)


def add_angles(load: str, radial: Array, cos: Array, sin: Array) -> Array:
    """Return the components, shape (6, ...), from functions of the distance or of the wave number.

    Parameters
    ----------
    load
        ``"z"`` or ``"x"``.
    radial
        The functions, in the order of `list_amplitudes`, shape (functions, ...).
    cos, sin
        Cosine and sine of the angle from the x axis, shape (...).
    """
    one = cos + 1j * sin
    two = one * one
    if load == "z":
        mean, difference, normal, shear = radial
        return np.array(
            [
                mean + difference * two.real,
                mean - difference * two.real,
                normal,
                shear * one.imag,
                shear * one.real,
                difference * two.imag,
            ]
        )
    normal, along, across, lateral, third, mean, difference = radial
    three = one * two
    return np.array(
        [
            along * one.real + third * three.real,
            across * one.real - third * three.real,
            normal * one.real,
            difference * two.imag,
            mean + difference * two.real,
            lateral * one.imag + third * three.imag,
        ]
    )


def list_amplitudes(find: FindWaves, load: str, q: Array) -> tuple[tuple[int, ...], Array]:
    """Return the order of Hankel's transform of each function of `add_angles`, and the amplitudes, (functions, n)."""
    if load == "z":
        along, across, normal, _, shear, _ = find("z", q)
        return (0, 2, 0, 1), np.array([0.5 * (along + across), 0.5 * (along - across), normal, shear])
    along, across, normal, _, shear, _ = find("x", q)
    _, _, _, shear_across, _, lateral = find("y", q)
    return (1, 1, 1, 1, 3, 0, 2), np.array(
        [
            normal,
            0.25 * (3.0 * along + across + 2.0 * lateral),
            0.25 * (along + 3.0 * across - 2.0 * lateral),
            0.25 * (along - across + 2.0 * lateral),
            0.25 * (along - across - 2.0 * lateral),
            0.5 * (shear + shear_across),
            0.5 * (shear - shear_across),
        ]
    )


def _tabulate(find: FindWaves, load: str, smallest: float, largest: float, reach: float) -> _PointStress:
    r"""Return the stress around a point load between two distances, m.

    .. math:: r^2 f(r) = \frac{i^k}{2\pi} \int_0^\infty A(x / r)\,J_k(x)\,x\,\mathrm{d}x
    """
    first = math.floor(math.log2(smallest))
    # One octave more, so that the spline reaches beyond the largest distance.
    last = math.floor(math.log2(largest)) + 1
    nodes = chebyshev.chebpts1(_NODES)
    vandermonde = chebyshev.chebvander(nodes, _NODES - 1)
    points = np.linspace(-1.0, 1.0, _POINTS, endpoint=False)
    tables = []
    for octave in range(first, last + 1):
        r = 2.0 ** (octave + 0.5 * (nodes + 1.0))
        x, weights = list_points(count_halvings(reach / 2.0**octave))
        q = x / r[:, np.newaxis]
        orders, amplitudes = list_amplitudes(find, load, q.ravel())
        values = [
            amplitude.reshape(q.shape) @ (weights * x * _SIGNS[k] / (2.0 * np.pi) * scipy.special.jv(k, x))
            for k, amplitude in zip(orders, amplitudes, strict=True)
        ]
        tables.append(chebyshev.chebval(points, np.linalg.solve(vandermonde, np.stack(values, axis=1))))
    at = first + np.arange(_POINTS * len(tables)) / _POINTS
    return _PointStress(load, scipy.interpolate.CubicSpline(at, np.concatenate(tables, axis=1), axis=1))
