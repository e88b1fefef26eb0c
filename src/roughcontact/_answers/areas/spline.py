"""The initial gap between the cell centres: a quintic spline, and its derivatives at any points."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import attrs
import numpy as np

from roughcontact._base.arrays import Array, Pair
from roughcontact._parts.grid import Boundary, as_boundary
from roughcontact._solve.solution import ContactSolution

# Degree of the spline: its second derivatives err by (q h)^4 / 720, 0.02 % at ten cells a wave.
_DEGREE: Literal[5] = 5
# Number of centres before and behind a point whose B-splines cover the point.
_CENTRES_BEFORE = 3
_CENTRES_BEHIND = 3
# The pieces of the quintic B-spline at these centres, in powers of the fraction of a cell.
_SPLINE_PIECES = (
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
# Their first and second derivatives, and all three together.
_PIECE_SLOPES = np.pad(_SPLINE_PIECES[:, 1:] * np.arange(1, 6), ((0, 0), (0, 1)))
_PIECE_BENDS = np.pad(_PIECE_SLOPES[:, 1:] * np.arange(1, 6), ((0, 0), (0, 1)))
_PIECE_FACTORS = np.concatenate((_SPLINE_PIECES, _PIECE_SLOPES, _PIECE_BENDS))
# Cells by which values are continued beyond a free border: a mirrored spline bends at the border, and the bend has an
# effect over as many cells.
CONTINUED_CELLS = 8
# Second differences across a border, over those inside, from which heights do not repeat there: one on waves that do,
# and about the number of cells on a ball. Cells at a border that no contact touches then; lines that are compared.
_MIN_BORDER_STEP = 4.0
_BORDER_CELLS = 3
_COMPARED_LINES = 256
# Values of the B-spline at 0, 1 and 2 cells from its centre.
_CENTRE_VALUES = (66.0 / 120.0, 26.0 / 120.0, 1.0 / 120.0)
# Points at a time: their coefficients stay in a core's cache.
_POINTS_PER_CHUNK = 1024


@attrs.frozen(eq=False)
class Spline:
    """A quintic spline through values at cell centres.

    Attributes
    ----------
    coefficients
        Coefficients of the B-splines, also of those beyond the border that cover points inside it.
    spacing
        Distances of the centres, m.
    periodic
        Whether it repeats beyond the border along x, and along y.
    beyond
        Cells by which the values were continued beyond a free border, along x and along y.
    """

    coefficients: Array
    spacing: Pair
    periodic: tuple[bool, bool]
    beyond: tuple[int, int]

    @classmethod
    def through_gap(cls, solution: ContactSolution) -> Spline:
        """Return the spline through the initial gap, which goes on across a border only where the gap does."""
        return cls.through(solution.initial_gap, solution.grid.spacing, _find_repeating_axes(solution))

    @classmethod
    def through(cls, values: Array, spacing: Pair, boundary: Boundary) -> Spline:
        """Return the spline through values of shape (nx, ny)."""
        ends = (_CENTRES_BEFORE - 1, _CENTRES_BEHIND)
        if not boundary.has_free_axis:
            return cls(np.pad(_solve_periodic(values), ends, mode="wrap"), spacing, (True, True), (0, 0))
        from scipy import ndimage

        free_x, free_y = boundary.free_axes
        coefficients = values
        for free in boundary.free_axes:
            # Each axis in turn is the first one.
            coefficients = (continue_beyond(coefficients) if free else coefficients).T
        reach = tuple((more - n) // 2 for more, n in zip(coefficients.shape, values.shape, strict=True))
        for axis, free in enumerate(boundary.free_axes):
            mode: Literal["mirror", "grid-wrap"] = "mirror" if free else "grid-wrap"
            coefficients = ndimage.spline_filter1d(coefficients, _DEGREE, axis, np.float64, mode)
        for axis, free in enumerate(boundary.free_axes):
            widths = [(0, 0), (0, 0)]
            widths[axis] = ends
            coefficients = np.pad(coefficients, widths, mode="reflect" if free else "wrap")
        return cls(coefficients, spacing, (not free_x, not free_y), (reach[0], reach[1]))

    def derivatives(self, i: Array, j: Array, *degrees: int) -> Array:
        """Return derivatives at points given in cells from the first centre.

        Degree 0 is the value, degree 1 has the derivatives along x and y, degree 2 those along xx, xy and yy.
        """
        dx, dy = self.spacing
        orders = [(degree - n, n) for degree in degrees for n in range(degree + 1)]
        units = np.array([dx**m * dy**n for m, n in orders])
        parts = self._evaluate(np.stack((i.ravel(), j.ravel())), degrees) / units[:, np.newaxis]
        return np.asarray(parts.reshape(len(orders), *i.shape))

    def _evaluate(self, at: Array, degrees: Sequence[int]) -> Array:
        """Return derivatives, per cell, at points of shape (2, n)."""
        width = self.coefficients.shape[1]
        flat = self.coefficients.ravel()
        at = at + np.array(self.beyond)[:, np.newaxis]
        first = np.floor(at)
        fraction = at - first
        i, j = first.astype(np.intp)
        nx, ny = (n - (_CENTRES_BEFORE - 1) - _CENTRES_BEHIND for n in self.coefficients.shape)
        # A free domain is continued by more cells than an ellipse inside it needs.
        repeats_x, repeats_y = self.periodic
        row = i % nx if repeats_x else np.clip(i, 0, nx - 1)
        cell = row * width + (j % ny if repeats_y else np.clip(j, 0, ny - 1))
        around = np.arange(_CENTRES_BEFORE + _CENTRES_BEHIND)
        around = (around[:, np.newaxis] * width + around)[..., np.newaxis]
        highest = max(degrees)
        sums = np.empty((sum(degree + 1 for degree in degrees), cell.size))
        for begin in range(0, cell.size, _POINTS_PER_CHUNK):
            part = slice(begin, begin + _POINTS_PER_CHUNK)
            along_x, along_y = _weigh(fraction[:, part], highest)
            lines = np.einsum("man,abn->mbn", along_x, flat.take(cell[part] + around))
            row = 0
            for degree in degrees:
                rows = slice(row, row + degree + 1)
                np.einsum("kbn,kbn->kn", lines[degree::-1], along_y[: degree + 1], out=sums[rows, part])
                row = rows.stop
        return sums


def _weigh(fraction: Array, highest: int) -> Array:
    """Return the factors of the B-splines around points, shape (2, n), as an array (2, orders, centres, n)."""
    powers = np.ones((_DEGREE + 1, fraction.size))
    for degree in range(_DEGREE):
        np.multiply(powers[degree], fraction.ravel(), out=powers[degree + 1])
    factors = _PIECE_FACTORS[: (highest + 1) * len(_SPLINE_PIECES)] @ powers
    return factors.reshape(highest + 1, len(_SPLINE_PIECES), 2, -1).transpose(2, 0, 1, 3)


def _solve_periodic(values: Array) -> Array:
    """Return the coefficients of the B-splines of a spline that repeats beyond the border."""
    from scipy import fft

    nx, ny = values.shape
    own, first, second = _CENTRE_VALUES
    angles = 2.0 * np.pi * np.arange(nx) / nx, 2.0 * np.pi * np.arange(ny // 2 + 1) / ny
    rows, columns = (1.0 / (own + 2.0 * first * np.cos(one) + 2.0 * second * np.cos(2.0 * one)) for one in angles)
    spectrum = fft.rfft2(values)
    spectrum *= rows[:, np.newaxis]
    spectrum *= columns
    return np.asarray(fft.irfft2(spectrum, values.shape))


def _find_repeating_axes(solution: ContactSolution) -> Boundary:
    """Return the boundary that is free also where heights have a step or a kink at a border that no contact touches.

    A spline across it would swing far into the domain.
    """
    ends = []
    for axis, free in enumerate(solution.boundary.free_axes):
        gap = np.moveaxis(solution.initial_gap, axis, 0)
        contact = np.moveaxis(solution.contact, axis, 0)
        beside = contact[:_BORDER_CELLS].any() or contact[-_BORDER_CELLS:].any()
        ends.append(free or not (beside or _goes_on(gap)))
    return as_boundary(["free" if end else "periodic" for end in ends])


def _goes_on(values: Array) -> bool:
    """Return whether values go on across the ends of the first axis as inside."""
    if len(values) < 4 * _BORDER_CELLS:
        return True
    lines = values[:, :: max(1, values.shape[1] // _COMPARED_LINES)]
    border = np.diff(np.concatenate((lines[-2:], lines[:2])), 2, axis=0)
    inside = np.diff(lines, 2, axis=0)
    return float(np.mean(border**2)) <= _MIN_BORDER_STEP**2 * float(np.mean(inside**2))


def continue_beyond(values: Array) -> Array:
    """Return values continued beyond both ends of the first axis with their slope and curvature."""
    widest = (len(values) - 1) // 2
    if widest == 0:
        return values
    k = np.arange(1, CONTINUED_CELLS + 1)
    # A parabola through three points, as far apart as the new point from the border, or as the domain allows.
    step = np.minimum(k, widest)
    ahead = (k / step)[:, np.newaxis]
    first = 0.5 * (ahead + 1.0) * (ahead + 2.0)
    second = -ahead * (ahead + 2.0)
    third = 0.5 * ahead * (ahead + 1.0)
    before = first * values[0] + second * values[step] + third * values[2 * step]
    after = first * values[-1] + second * values[-1 - step] + third * values[-1 - 2 * step]
    return np.concatenate((before[::-1], values, after))
