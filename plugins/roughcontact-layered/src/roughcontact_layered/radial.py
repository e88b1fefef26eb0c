"""The displacement around a point force beyond that of a half-space, by Hankel's transform."""

from __future__ import annotations

import math
from functools import lru_cache

import attrs
import numpy as np
import roughcontact as rc
from numpy.polynomial import chebyshev, legendre
from scipy import special

from roughcontact_layered.stack import Array, Layer, waves

# Chebyshev nodes per octave of the distance: the images that layers make lie at imaginary distances,
# beyond an ellipse on which the coefficients fall by nine each.
_NODES = 20
# Gauss points on each panel of x = q r.
_POINTS = 16
# The first half wave ends here; panels below it halve, those above are half waves of Bessel's functions.
_FIRST = 2.4
# Half waves summed as they are, and half waves whose partial sums are averaged (Euler's method).
_PLAIN, _AVERAGED = 20, 26
# q r times the thickness over r below which waves do not tell the layers from nothing.
_LONG = 1e-3


@attrs.frozen(eq=False)
class Radial:
    """Functions of the distance r, tabulated by octaves.

    Attributes
    ----------
    first
        The first octave begins at 2^first, m.
    point
        Chebyshev coefficients of r times the displacement by a unit force, (nodes, octaves), m^2/(N).
    disc
        The same of the integral of r' times that displacement over 0 < r' < r, over r.
    """

    first: int
    point: Array
    disc: Array

    def displacement(self, r: Array) -> Array:
        """Return the displacement by a unit force at the distances `r`, m/N."""
        return self._read(self.point, r) / r

    def within(self, r: Array) -> Array:
        """Return the integral of r' times the displacement from 0 to `r`, m^3/N."""
        return self._read(self.disc, r) * r

    def _read(self, table: Array, r: Array) -> Array:
        mantissa, exponent = np.frexp(r)
        octave = exponent - 1 - self.first
        result = np.empty_like(r)
        position = 2.0 * (np.log2(mantissa) + 1.0) - 1.0
        for k in range(table.shape[1]):
            inside = octave == k
            result[inside] = chebyshev.chebval(position[inside], table[:, k])
        return result


def radial(layers: tuple[Layer, ...], substrate: rc.Elastic, smallest: float, greatest: float) -> Radial:
    """Tabulate what a stack adds to a half-space of its topmost layer, between two distances, m."""
    first, last = (math.floor(math.log2(r)) for r in (smallest, greatest))
    tables = [_octave(layers, substrate, k) for k in range(first, last + 1)]
    point, disc = (np.stack(part, axis=1) for part in zip(*tables, strict=True))
    return Radial(first, point, disc)


@lru_cache(maxsize=1024)
def _octave(layers: tuple[Layer, ...], substrate: rc.Elastic, octave: int) -> tuple[Array, Array]:
    r"""Return the Chebyshev coefficients on 2^octave .. 2^(octave + 1), over the logarithm of the distance.

    .. math:: r\,G(r) = \frac{1}{2\pi} \int_0^\infty F(x / r)\,J_0(x)\,\mathrm{d}x, \quad
              \frac{1}{r} \int_0^r G\,r'\,\mathrm{d}r' = \frac{1}{2\pi} \int_0^\infty F(x / r)\,\frac{J_1(x)}{x}\,
              \mathrm{d}x

    with F the second of `waves`, which is finite at zero: what is left far away needs no care.
    """
    nodes = chebyshev.chebpts1(_NODES)
    r = 2.0 ** (octave + 0.5 * (nodes + 1.0))
    x, weights = _rule(_halvings(sum(layer.thickness for layer in layers) / 2.0**octave))
    _, values = waves(layers, substrate, (x[np.newaxis, :] / r[:, np.newaxis]).ravel())
    values = values.reshape(r.size, x.size) / (2.0 * np.pi)
    point = values @ (weights * special.j0(x))
    disc = values @ (weights * special.j1(x) / x)
    vandermonde = chebyshev.chebvander(nodes, _NODES - 1)
    solved = np.linalg.solve(vandermonde, np.stack((point, disc), axis=1)).astype(np.float64)
    return solved[:, 0], solved[:, 1]


def _halvings(thickness: float) -> int:
    """Return how often the first panel is halved before the layers, `thickness` over r in all, are not seen."""
    return max(4, math.ceil(math.log2(_FIRST * max(thickness, 1.0) / _LONG)))


@lru_cache(maxsize=64)
def _rule(halvings: int) -> tuple[Array, Array]:
    """Return nodes and weights for the integral over 0 .. infinity of a slow function times Bessel's."""
    edges = np.concatenate(([0.0], _FIRST * 2.0 ** np.arange(-halvings, 1.0)))
    waves_edges = _FIRST + np.pi * np.arange(1.0, _PLAIN + _AVERAGED + 1.0)
    edges = np.concatenate((edges, waves_edges))
    # The weight of a half wave is the share of the averaged partial sums that hold it.
    shares = np.cumsum([math.comb(_AVERAGED, k) for k in range(_AVERAGED, 0, -1)]) / 2.0**_AVERAGED
    panels = np.concatenate((np.ones(edges.size - 1 - _AVERAGED), shares[::-1]))
    at, weight = legendre.leggauss(_POINTS)
    half = 0.5 * np.diff(edges)[:, np.newaxis]
    x = edges[:-1, np.newaxis] + half * (at + 1.0)
    return x.ravel(), (half * weight * panels[:, np.newaxis]).ravel()
