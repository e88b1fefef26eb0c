"""The response of layers to waves, by Chebyshev series on octaves of the wave number."""

from __future__ import annotations

from collections.abc import Hashable
from functools import lru_cache
from typing import Protocol

import numpy as np
import scipy
from numpy.polynomial import chebyshev

from roughcontact_layered.stack import Array

# Chebyshev nodes per octave. The response of layers has no singularity but at complex wave numbers: those nearest to
# the real ones, at 30 degrees (a plate on an incompressible layer), make the coefficients fall by 3.3 each.
_NODES = 40
# Coefficients below this part of the largest one are rounding.
_NEGLIGIBLE = 1e-15


class SmoothResponse(Hashable, Protocol):
    """A response to waves that is smooth on the octaves of their wave number."""

    def find_rest(self, q: Array) -> Array:
        """Return q times the rest beside a half-space for wave numbers, shape (n,), rad/m, above zero."""


@lru_cache(maxsize=64)
def tabulate_rest(response: SmoothResponse) -> Octaves:
    """Return the function `find_rest` of a response: many grids, distances and aliases ask for the same octaves."""
    return Octaves(response)


class Octaves:
    """The function `find_rest` of a response, which is asked at the nodes of an octave once.

    The error is rounding beside the maximum in the octave.
    """

    def __init__(self, response: SmoothResponse) -> None:
        self._response = response
        self._series: dict[int, Array] = {}

    def __call__(self, q: Array) -> Array:
        """Return the function of wave numbers of any shape, rad/m."""
        mantissa, exponent = np.frexp(q)
        lowest = int(exponent.min())
        octaves = (np.flatnonzero(np.bincount(exponent.ravel() - lowest)) + lowest).tolist()
        self._tabulate([octave for octave in octaves if octave not in self._series])
        result = np.empty_like(q)
        for octave in octaves:
            inside = exponent == octave
            result[inside] = chebyshev.chebval(4.0 * mantissa[inside] - 3.0, self._series[octave])
        return result

    def _tabulate(self, octaves: list[int]) -> None:
        """Add the series of octaves, each from half of two to the power of its number to the whole of it."""
        if not octaves:
            return
        # From the upper end down, as the transform has them.
        nodes = chebyshev.chebpts1(_NODES)[::-1]
        q = np.ldexp(0.25 * (nodes + 3.0), np.array(octaves)[:, np.newaxis])
        terms = scipy.fft.dct(self._response.find_rest(q.ravel()).reshape(q.shape)) / _NODES
        terms[:, 0] *= 0.5
        for octave, series in zip(octaves, terms, strict=True):
            kept = np.abs(series) > _NEGLIGIBLE * np.abs(series).max()
            self._series[octave] = series[: int(np.flatnonzero(kept).max(initial=0)) + 1]
