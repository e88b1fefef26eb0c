"""The initial gap between the cell centres: a quintic spline, and its derivatives at any points."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Literal

import attrs
import numpy as np

from roughcontact._solution import ContactSolution
from roughcontact.checks import Array, IntArray, Pair
from roughcontact.grid import Boundary

# Degree of the spline: its second derivatives err by (q h)^4 / 720, 0.02 % at ten cells a wave.
_DEGREE: Literal[5] = 5
# Orders of derivatives along x and y.
SLOPES, CURVATURES = ((1, 0), (0, 1)), ((2, 0), (0, 2), (1, 1))
# Offsets of the centres whose B-splines cover a point.
_OFFSETS = np.arange(-2, 4)
# The pieces of the quintic B-spline there, in powers of the fraction of a cell, with first and second derivatives.
_PIECES = (
    np.array(
        (
            (1.0, -5.0, 10.0, -10.0, 5.0, -1.0),
            (26.0, -50.0, 20.0, 20.0, -20.0, 5.0),
            (66.0, 0.0, -60.0, 0.0, 30.0, -10.0),
            (26.0, 50.0, 20.0, -20.0, -20.0, 10.0),
            (1.0, 5.0, 10.0, 10.0, 5.0, -5.0),
            (0.0, 0.0, 0.0, 0.0, 0.0, 1.0),
        )
    )
    / 120.0
)
# Cells by which values are continued beyond a free border, where a spline that is mirrored would bend: the bend of
# the continued one is felt over as many cells.
_BEYOND = 8
_SLOPES = np.pad(_PIECES[:, 1:] * np.arange(1, 6), ((0, 0), (0, 1)))
_BENDS = np.pad(_SLOPES[:, 1:] * np.arange(1, 6), ((0, 0), (0, 1)))
_FACTORS = np.concatenate((_PIECES, _SLOPES, _BENDS))
# The B-spline at the centres from 0 to 2 cells from its own.
_CENTRES = (66.0 / 120.0, 26.0 / 120.0, 1.0 / 120.0)
# Points at a time: their coefficients stay in a core's cache.
_CHUNK = 512


@attrs.frozen(eq=False)
class Spline:
    """A quintic spline through values at cell centres.

    Attributes
    ----------
    coefficients
        Of the B-splines, shape (nx, ny).
    spacing
        Distances of the centres, m.
    periodic
        Whether it repeats beyond the border.
    beyond
        Cells by which the values were continued beyond a free border.
    """

    coefficients: Array
    spacing: Pair
    periodic: bool
    beyond: tuple[int, int]

    @classmethod
    def through_gap(cls, solution: ContactSolution) -> Spline:
        """Return the spline through the initial gap; a non-measured point has the gap of the nearest measured one."""
        gap, non_measured = solution.initial_gap, solution.non_measured
        if non_measured is not None:
            from scipy import ndimage

            nearest = ndimage.distance_transform_edt(non_measured, return_distances=False, return_indices=True)
            gap = gap[tuple(nearest)]
        return cls.through(gap, solution.grid.spacing, solution.boundary)

    @classmethod
    def through(cls, values: Array, spacing: Pair, boundary: Boundary) -> Spline:
        """Return the spline through values of shape (nx, ny)."""
        if boundary is not Boundary.FREE:
            return cls(_solve_periodic(values), spacing, True, (0, 0))
        from scipy import ndimage

        reach = _count_beyond(values.shape[0]), _count_beyond(values.shape[1])
        continued = _continue(_continue(values, reach[0]).T, reach[1]).T
        return cls(ndimage.spline_filter(continued, _DEGREE, np.float64, "mirror"), spacing, False, reach)

    def values(self, i: Array, j: Array) -> Array:
        """Return the values at points given in cells from the first centre."""
        return np.asarray(self._evaluate(i, j, ((0, 0),))[0])

    def derivatives(self, i: Array, j: Array, orders: Sequence[tuple[int, int]]) -> list[Array]:
        """Return derivatives of orders (m, n) along x and y at points given in cells from the first centre."""
        dx, dy = self.spacing
        return [part / (dx**m * dy**n) for part, (m, n) in zip(self._evaluate(i, j, orders), orders, strict=True)]

    def _evaluate(self, i: Array, j: Array, orders: Sequence[tuple[int, int]]) -> Array:
        """Return derivatives of some orders along x and y, per cell."""
        highest, flat = max(max(pair) for pair in orders), self.coefficients.ravel()
        sums = np.empty((len(orders), i.size))
        for begin in range(0, i.size, _CHUNK):
            part = slice(begin, begin + _CHUNK)
            (rows, columns), (along_x, along_y) = self._weigh(np.stack((i.ravel()[part], j.ravel()[part])), highest)
            near = flat.take(rows[:, np.newaxis] + columns)
            lines = np.einsum("man,abn->mbn", along_x, near)
            for total, (m, n) in zip(sums, orders, strict=True):
                np.einsum("bn,bn->n", along_y[n], lines[m], out=total[part])
        return sums.reshape(len(orders), *i.shape)

    def _weigh(self, at: Array, highest: int) -> tuple[IntArray, Array]:
        """Return the centres around points, shape (2, n), and their factors by the order of the derivative.

        The centres, shape (2, 6, n), are numbered so that the sum of those along both axes is the flat index of a
        coefficient; the factors have the shape (2, orders, 6, n).
        """
        at = at + np.array(self.beyond)[:, np.newaxis]
        first = np.floor(at)
        fraction, powers = (at - first).ravel(), np.ones((_DEGREE + 1, at.size))
        for degree in range(_DEGREE):
            np.multiply(powers[degree], fraction, out=powers[degree + 1])
        factors = _FACTORS[: (highest + 1) * _OFFSETS.size] @ powers
        steps = np.arange(_OFFSETS.size)[:, np.newaxis]
        near = [
            table.take(one % (table.size - _OFFSETS.size) + steps)
            for one, table in zip(first.astype(np.intp), self._tables, strict=True)
        ]
        return np.stack(near), factors.reshape(highest + 1, _OFFSETS.size, 2, -1).transpose(2, 0, 1, 3)

    @cached_property
    def _tables(self) -> tuple[IntArray, IntArray]:
        """The centres from the first offset to the last one around a period, along x and along y; see `_weigh`."""
        tables = []
        for n, step in zip(self.coefficients.shape, (self.coefficients.shape[1], 1), strict=True):
            period = n if self.periodic else max(2 * (n - 1), 1)
            ahead = np.arange(_OFFSETS[0], period + _OFFSETS[-1] + 1)
            centres = ahead % n if self.periodic else np.abs((ahead + n - 1) % period - (n - 1))
            tables.append(centres * step)
        return tables[0], tables[1]


def _solve_periodic(values: Array) -> Array:
    """Return the coefficients of the B-splines of a spline that repeats beyond the border."""
    from scipy import fft

    (nx, ny), (own, first, second) = values.shape, _CENTRES
    angles = 2.0 * np.pi * np.arange(nx) / nx, 2.0 * np.pi * np.arange(ny // 2 + 1) / ny
    rows, columns = (1.0 / (own + 2.0 * first * np.cos(one) + 2.0 * second * np.cos(2.0 * one)) for one in angles)
    spectrum = fft.rfft2(values)
    spectrum *= rows[:, np.newaxis]
    spectrum *= columns
    return np.asarray(fft.irfft2(spectrum, values.shape))


def _count_beyond(cells: int) -> int:
    """Return by how many cells values on so many are continued."""
    return min(_BEYOND, (cells - 1) // 2)


def _continue(values: Array, reach: int) -> Array:
    """Return values continued beyond both ends of the first axis with their slope and curvature."""
    if reach == 0:
        return values
    k = np.arange(1, reach + 1)
    before = 3.0 * values[0] - 3.0 * values[k] + values[2 * k]
    after = 3.0 * values[-1] - 3.0 * values[-1 - k] + values[-1 - 2 * k]
    return np.concatenate((before[::-1], values, after))
