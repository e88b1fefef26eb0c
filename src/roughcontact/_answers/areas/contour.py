r"""The edge of the contact between cell centres.

Near a smooth edge, at the distance d, the pressure is :math:`K\sqrt{d}` inside and the gap
:math:`\tfrac{4K}{3E^*}d^{3/2}` outside, with one K for both. So with the one unknown y = (K/E*)^(-2/3)

.. math:: \varphi = (p/E^*)^2 y^3 \text{ inside}, \quad \varphi = -(3g/4)^{2/3} y \text{ outside}

is the signed distance from the edge on both sides, and y follows from the gradient of a distance,
which is one. Between the centres of four neighbouring cells (a dual cell) the edge lies where the
interpolated distance vanishes.

References
----------
Johnson, Contact Mechanics (1985), section 5.1, https://doi.org/10.1017/CBO9781139171731, for the edge.
"""

from __future__ import annotations

import math

import attrs
import numpy as np

from roughcontact._answers.areas import calibration
from roughcontact._answers.areas.dual_cells import Owners, find_dual_cells
from roughcontact._answers.areas.polygons import INSIDE, Corners, find_kinds, measure_polygons
from roughcontact._base.checks import Array, IntArray, Mask
from roughcontact._solve.solution import ContactSolution

# Upper bound of the distance at the corners of a dual cell, in cells; at a smooth edge it is below sqrt(2).
_LONGEST = 16.0
# Distance of the furthest corner, in cells, where no y gives the gradient one, as at saddles: half a diagonal.
_SADDLE = 0.7
# Difference up to which edges in two dual cells count as the same, in cells, and the number of such steps in any.
_ALIKE = 1e-3
_KEYS = 10_000
# So that a half of a cell is not a limit between two steps.
_OFFSET = 0.382
# Newton steps for y^2 from a start within 9 % (quadratic convergence, rounding after 4), and inside a bracket.
_NEWTON = 4
_BRACKETED = 16


@attrs.frozen(eq=False)
class Contour:
    """The edge of each patch, arrays of shape (count + 1,); the first entry stands for no patch and is zero.

    Attributes
    ----------
    area, length
        Area inside the edge, m2, and its length, m.
    euler
        Euler number: the number of pieces less the number of holes.
    sharp
        Fraction of the edge that is sharp.
    alike
        Mean number of dual cells whose edge is the same as that of one.
    meeting
        Number of dual cells in which the edge of the contact meets non-measured points.
    """

    area: Array
    length: Array
    euler: Array
    sharp: Array
    alike: Array
    meeting: Array


def trace_contour(solution: ContactSolution, sharp: Mask, stride: int = 1) -> Contour:
    """Return the edge of each patch between neighbouring cells, or between cells `stride` apart.

    With a stride it is the mean over all choices of cells. At the cells of sharp edges, shape (nx, ny), the
    cells are counted.
    """
    dual = find_dual_cells(solution, stride)
    patches = solution.patches
    cell = solution.grid.cell_area
    i, j = dual.find_edge(solution.contact)
    k = dual.corners(i, j)
    label = patches.labels.ravel().take(k)
    touching = label > 0
    kind = find_kinds(touching)
    inside = INSIDE[kind]
    jagged = sharp.ravel().take(k).any(axis=0) if sharp.any() else np.zeros(kind.size, dtype=bool)
    beside, meeting = _find_non_measured(solution, k, touching)
    # Beside non-measured points the contact ends with the cells.
    counted = jagged | beside
    size = (stride * solution.grid.spacing[0], stride * solution.grid.spacing[1])
    distance = find_distances(solution, k, touching, size)
    parts, chords, euler = measure_polygons(distance, touching, kind, size)
    parts = np.where(counted, inside / 4.0 * (size[0] * size[1]), parts)
    alike = _count_alike(parts / (size[0] * size[1]), chords / size[0], distance)
    # Each of stride^2 choices of cells covers all of the contact.
    weight = dual.weights[0][i] * dual.weights[1][j] / stride**2
    smooth = weight * ~counted
    owners = Owners.find(label, kind, patches.count)
    total = owners.sum(weight)
    # The dual cells inside the patches, with quarters of those at the edge, which their polygons replace.
    area = cell * dual.cover(solution) + owners.sum((parts - inside / 4.0 * (size[0] * size[1])) * weight)
    return Contour(
        area=area,
        length=owners.sum(chords * smooth),
        euler=owners.sum(euler * smooth),
        sharp=_divide(owners.sum(jagged * weight), total, 0.0),
        alike=_divide(owners.sum(alike * weight), total, 1.0),
        meeting=owners.sum(meeting * weight),
    )


def _find_non_measured(solution: ContactSolution, k: IntArray, touching: Mask) -> tuple[Mask, Mask]:
    """Mark the dual cells with non-measured corners, and those of them that have open ones too, shape (n,)."""
    if solution.non_measured is None:
        none = np.zeros(k.shape[1], dtype=bool)
        return none, none
    unknown = solution.non_measured.ravel()[k]
    beside = np.asarray(unknown.any(axis=0))
    return beside, np.asarray(beside & ~(unknown | touching).all(axis=0))


def _divide(sums: Array, counts: Array, otherwise: float) -> Array:
    return np.divide(sums, counts, out=np.full_like(sums, otherwise), where=counts > 0.0)


def _count_alike(parts: Array, chords: Array, distance: Corners) -> Array:
    """Return how many dual cells have the same edge as each, shape (n,).

    Where the contact repeats on the grid, or is symmetric in it, the errors of its parts are the same.
    """
    highest = np.abs(distance).max(axis=0)
    highest = highest / np.maximum(highest.max(initial=0.0), np.finfo(float).tiny)
    first, second, third = (np.floor(part / _ALIKE + _OFFSET) for part in (parts, chords, highest))
    keys = (first * _KEYS + second) * _KEYS + third
    order = np.argsort(keys)
    ends = np.flatnonzero(np.diff(keys[order], append=np.inf)) + 1
    counts = np.diff(ends, prepend=0)
    alike = np.empty(keys.size)
    alike[order] = np.repeat(counts, counts)
    return alike


def find_modulus_change(solution: ContactSolution) -> float:
    """Return the logarithm of the change of E* over two octaves of wavelength at the edge; zero without layers."""
    length = calibration.EDGE_LENGTH * math.sqrt(solution.grid.cell_area)
    shorter, longer = solution.effective_modulus(np.array([2.0, 0.5]) / length)
    return abs(math.log(longer / shorter))


def find_distances(solution: ContactSolution, k: IntArray, contact: Mask, size: tuple[float, float]) -> Corners:
    """Return the signed distance from the edge at the corners `k` of dual cells, shape (4, n), m."""
    step = np.sqrt(size[0] * size[1])
    modulus = solution.effective_modulus(1.0 / (calibration.EDGE_LENGTH * step))
    inside = np.square(solution.pressure.ravel().take(k) / modulus)
    outside = np.zeros_like(inside)
    open_ = np.flatnonzero(~contact)
    outside.ravel()[open_] = np.cbrt(np.square(0.75 * np.maximum(solution.gap.ravel().take(k.ravel()[open_]), 0.0)))
    ax, ay = _differentiate(inside, size)
    bx, by = _differentiate(outside, size)
    # |grad phi|^2 is a cubic in w = y^2.
    cubic = ax * ax + ay * ay
    square = -2.0 * (ax * bx + ay * by)
    linear = bx * bx + by * by
    longest = _LONGEST * step
    with np.errstate(divide="ignore"):
        highest = np.minimum(np.cbrt(longest / inside.max(axis=0)) ** 2, (longest / outside.max(axis=0)) ** 2)
    highest = np.where(np.isfinite(highest), highest, 1.0)
    w = _find_root(cubic, square, linear, highest)
    rootless = ((cubic * highest + square) * highest + linear) * highest < 1.0
    if rootless.any():
        top = inside[:, rootless].max(axis=0), outside[:, rootless].max(axis=0)
        # The square of P y^3 + G y is a cubic in w too.
        saddle = (_SADDLE * step) ** 2
        w[rootless] = _find_root(top[0] ** 2, 2 * top[0] * top[1], top[1] ** 2, highest[rootless], saddle)
    y = np.sqrt(w)
    return np.asarray(inside * (w * y) - outside * y)


def _differentiate(values: Corners, size: tuple[float, float]) -> tuple[Array, Array]:
    low_left, high_left, high_right, low_right = values
    along_x = (high_left + high_right - low_left - low_right) / (2.0 * size[0])
    along_y = (high_right + low_right - low_left - high_left) / (2.0 * size[1])
    return along_x, along_y


def _find_root(cubic: Array, square: Array, linear: Array, highest: Array, value: float = 1.0) -> Array:
    """Return w in [0, highest] where the polynomial reaches a value, by Newton's method."""
    with np.errstate(divide="ignore", invalid="ignore"):
        # Each term alone reaches the value at the inverse of one of these; all together near that of their norm.
        w = 1.0 / np.sqrt(np.cbrt(cubic / value) ** 2 + square / value + (linear / value) ** 2)
        for _ in range(_NEWTON):
            excess = ((cubic * w + square) * w + linear) * w - value
            w = w - excess / ((3.0 * cubic * w + 2.0 * square) * w + linear)
    wild = (square < 0.0) | ~((w >= 0.0) & (w < np.inf))
    if wild.any():
        w[wild] = _find_bracketed_root(cubic[wild], square[wild], linear[wild], highest[wild], value)
    return w


def _find_bracketed_root(cubic: Array, square: Array, linear: Array, highest: Array, value: float) -> Array:
    low = np.zeros_like(highest)
    high = highest.copy()
    w = 0.5 * highest
    for _ in range(_BRACKETED):
        excess = ((cubic * w + square) * w + linear) * w - value
        above = excess > 0.0
        np.copyto(high, w, where=above)
        np.copyto(low, w, where=~above)
        slope = (3.0 * cubic * w + 2.0 * square) * w + linear
        with np.errstate(divide="ignore", invalid="ignore"):
            trial = w - excess / slope
        # A root that is found is an end of the bracket.
        w = np.where((trial >= low) & (trial <= high), trial, 0.5 * (low + high))
    return w
