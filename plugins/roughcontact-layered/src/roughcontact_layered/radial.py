"""The displacement around a point force beyond that of a half-space, by Hankel's transform."""

from __future__ import annotations

import math
from collections.abc import Hashable
from functools import lru_cache
from typing import Protocol

import attrs
import numpy as np
import scipy
from numpy.polynomial import chebyshev, legendre

from roughcontact_layered.stack import Array

# Chebyshev nodes per octave of the distance: the images of the layers lie at imaginary distances, beyond an
# ellipse on which the coefficients fall by nine each, 9^-20 = 8e-20.
_NODES = 20
# Gauss points on each panel of x = q r, and half waves of Bessel's functions summed as they are and by averages of
# their partial sums (Euler's method): errors below 1e-11 of the displacement (tests/test_cells.py).
_POINTS = 16
_PLAIN = 20
_AVERAGED = 26
# End of the first half wave, near the zero 2.405 of J0; panels below it halve.
_FIRST = 2.4
# Wave number times depth below which the body changes nothing.
_LONG = 1e-3


class DepthDependent(Hashable, Protocol):
    """A kernel of a body whose modulus depends on the depth alone."""

    @property
    def depth(self) -> float:
        """Depth below which the body changes little, m."""

    def rest(self, q: Array) -> Array:
        """Return the response to waves less that of a half-space of what lies at the surface, shape of `q`, m/Pa."""


@attrs.frozen(eq=False)
class Radial:
    """The displacement around a point force, a function of the distance r, tabulated by octaves.

    Attributes
    ----------
    first
        The first octave begins at 2^first, m.
    point
        Chebyshev coefficients of r times the displacement by a unit force, (nodes, octaves), m^2/(N).
    disc
        The same of the integral of r' times that displacement over 0 < r' < r, over r, if it is the same all round.
    """

    first: int
    point: Array
    disc: Array

    def displacement(self, x: Array, y: Array) -> Array:
        """Return the displacement by a unit force; see `PointForce`."""
        r = np.hypot(x, y)
        return self._evaluate(self.point, r) / r

    def along_ray(self, x: Array, y: Array) -> Array:
        """Return the integral of the displacement along a ray; see `PointForce`."""
        r = np.hypot(x, y)
        return self._evaluate(self.disc, r) / r

    def _evaluate(self, table: Array, r: Array) -> Array:
        mantissa, exponent = np.frexp(r)
        octave = exponent - 1 - self.first
        result = np.empty_like(r)
        position = 2.0 * (np.log2(mantissa) + 1.0) - 1.0
        for k in range(table.shape[1]):
            inside = octave == k
            result[inside] = chebyshev.chebval(position[inside], table[:, k])
        return result


def tabulate(kernel: DepthDependent, smallest: float, largest: float, order: int = 0) -> Radial:
    """Return what a body adds to a half-space of what lies at its surface, between two distances, m.

    Of order n, 0 or 2, it is what stands before the cosine of n times the angle, for waves with that factor.
    """
    first, last = (math.floor(math.log2(r)) for r in (smallest, largest))
    tables = [_octave(kernel, k, order) for k in range(first, last + 1)]
    point, disc = (np.stack(part, axis=1) for part in zip(*tables, strict=True))
    return Radial(first, point, disc)


@lru_cache(maxsize=1024)
def _octave(kernel: DepthDependent, octave: int, order: int) -> tuple[Array, Array]:
    r"""Return the Chebyshev coefficients on 2^octave .. 2^(octave + 1), over the logarithm of the distance.

    .. math:: r\,G(r) = \frac{1}{2\pi} \int_0^\infty F(x / r)\,J_0(x)\,\mathrm{d}x, \quad
              \frac{1}{r} \int_0^r G\,r'\,\mathrm{d}r' = \frac{1}{2\pi} \int_0^\infty F(x / r)\,\frac{J_1(x)}{x}\,
              \mathrm{d}x

    with F = q u the rest of the kernel times q, which is finite at zero, so that the integrals converge. For order 2
    -J2 is in place of J0.
    """
    nodes = chebyshev.chebpts1(_NODES)
    r = 2.0 ** (octave + 0.5 * (nodes + 1.0))
    x, weights = list_points(count_halvings(kernel.depth / 2.0**octave))
    q = x[np.newaxis, :] / r[:, np.newaxis]
    values = kernel.rest(q) * q / (2.0 * np.pi)
    point = values @ (weights * (scipy.special.j0(x) if order == 0 else -scipy.special.jv(2, x)))
    disc = values @ (weights * scipy.special.j1(x) / x)
    vandermonde = chebyshev.chebvander(nodes, _NODES - 1)
    solved = np.linalg.solve(vandermonde, np.stack((point, disc), axis=1)).astype(np.float64)
    return solved[:, 0], solved[:, 1]


def count_halvings(depth: float) -> int:
    """Return how often the first panel is halved until what lies down to a depth, over r, changes nothing."""
    return max(4, math.ceil(math.log2(_FIRST * max(depth, 1.0) / _LONG)))


@lru_cache(maxsize=64)
def list_points(halvings: int) -> tuple[Array, Array]:
    """Return nodes and weights for the integral over 0 .. infinity of a slow function times Bessel's."""
    edges = np.concatenate(([0.0], _FIRST * 2.0 ** np.arange(-halvings, 1.0)))
    half_waves = _FIRST + np.pi * np.arange(1.0, _PLAIN + _AVERAGED + 1.0)
    edges = np.concatenate((edges, half_waves))
    # The weight of a half wave is the fraction of the averaged partial sums that contain it.
    fractions = np.cumsum([math.comb(_AVERAGED, k) for k in range(_AVERAGED, 0, -1)]) / 2.0**_AVERAGED
    panels = np.concatenate((np.ones(edges.size - 1 - _AVERAGED), fractions[::-1]))
    at, weight = legendre.leggauss(_POINTS)
    half = 0.5 * np.diff(edges)[:, np.newaxis]
    x = edges[:-1, np.newaxis] + half * (at + 1.0)
    return x.ravel(), (half * weight * panels[:, np.newaxis]).ravel()
