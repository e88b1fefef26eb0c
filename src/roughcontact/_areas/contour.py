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
from typing import Any, Literal

import attrs
import numpy as np
import numpy.typing as npt

from roughcontact._areas import calibration
from roughcontact._areas.polygons import Corners, find_crossings, find_segments, measure_polygons
from roughcontact._solution import ContactSolution
from roughcontact.checks import Array, IntArray, Mask
from roughcontact.grid import Boundary

# Upper bound of the distance at the corners of a dual cell, in cells; at a smooth edge it is below sqrt(2).
_LONGEST = 16.0
# Distance of the furthest corner, in cells, where no y gives the gradient one, as at saddles: half a diagonal.
_SADDLE = 0.7
# Difference up to which edges in two dual cells count as the same, in cells, and the number of such steps in any.
_ALIKE, _KEYS = 1e-3, 10_000
# So that a half of a cell is not a limit between two steps.
_OFFSET = 0.382
# Newton steps for y^2 from an upper bound (quadratic convergence, rounding after 5), and inside a bracket.
_NEWTON, _BRACKETED = 6, 16


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
    """

    area: Array
    length: Array
    euler: Array
    sharp: Array
    alike: Array


@attrs.frozen(eq=False)
class _DualCells:
    """Dual cells, numbered by their lower left corners.

    Attributes
    ----------
    stride
        Distance of the corners, in cells.
    before, mode
        Cells by which fields are extended before the first one (`stride` after the last), and how.
    weights
        Fraction of each dual cell that lies in the domain, along x and along y.
    """

    stride: int
    before: int
    mode: Literal["edge", "wrap"]
    weights: tuple[Array, Array]

    @property
    def shape(self) -> tuple[int, int]:
        """Number of dual cells along each axis."""
        return self.weights[0].size, self.weights[1].size

    def corners(self, field: npt.NDArray[Any]) -> list[npt.NDArray[Any]]:
        """Return the field at the four corners, in order around each dual cell."""
        (m, n), s = self.shape, self.stride
        extended = np.pad(field, (self.before, s), mode=self.mode)
        return [extended[dx : dx + m, dy : dy + n] for dx, dy in ((0, 0), (s, 0), (s, s), (0, s))]

    def count_inside(self, contact: Mask) -> npt.NDArray[np.uint8]:
        """Return the number of corners in contact."""
        return np.asarray(np.add.reduce([mask.view(np.uint8) for mask in self.corners(contact)], axis=0))

    def cells(self, chosen: IntArray) -> IntArray:
        """Return the flat indices of the cells at the corners of some dual cells, shape (4, n)."""
        ends = []
        for first, count in zip(np.divmod(chosen, self.shape[1]), self.shape, strict=True):
            n, corners = count - self.before, (first - self.before, first - self.before + self.stride)
            ends.append([k % n if self.mode == "wrap" else np.clip(k, 0, n - 1) for k in corners])
        (low, high), (left, right) = ends
        ny = self.shape[1] - self.before
        return np.stack((low * ny + left, high * ny + left, high * ny + right, low * ny + right))


def trace_contour(solution: ContactSolution, sharp: Mask, stride: int = 1) -> Contour:
    """Return the edge of each patch between neighbouring cells, or between cells `stride` apart.

    With a stride it is the mean over all choices of cells. At the cells of sharp edges, shape (nx, ny), the
    cells are counted.
    """
    dual = _find_dual_cells(solution, stride)
    count, cell = solution.patches.count, solution.grid.cell_area
    inside = dual.count_inside(solution.contact)
    weight = np.multiply.outer(*dual.weights)
    full = inside == 4
    area = cell * _sum_full(dual.corners(solution.patches.labels), full, weight, count)
    chosen = np.flatnonzero((inside > 0) & ~full)
    weight, inside, k = weight.ravel()[chosen], inside.ravel()[chosen], dual.cells(chosen)
    touching, jagged = solution.contact.ravel()[k], sharp.ravel()[k].any(axis=0)
    # Beside non-measured points the contact ends with the cells.
    counted = jagged
    if solution.non_measured is not None:
        counted = jagged | solution.non_measured.ravel()[k].any(axis=0)
    size = (stride * solution.grid.spacing[0], stride * solution.grid.spacing[1])
    distance = _find_distances(solution, k, touching, size)
    parts, chords, euler = measure_polygons(distance, touching, inside, size)
    parts = np.where(counted, inside / 4.0 * (size[0] * size[1]), parts)
    label = solution.patches.labels.ravel()[k]
    alike = _count_alike(parts / (size[0] * size[1]), chords / size[0], distance)
    # Each of stride^2 choices of cells covers all of the contact.
    weight = weight / stride**2
    smooth = weight * ~counted

    def total(values: Array) -> Array:
        # Corners two cells apart may lie in different patches: each corner in contact has an equal part.
        parts = np.where(touching, values / inside, 0.0)
        sums = np.bincount(label.ravel(), weights=parts.ravel(), minlength=count + 1)
        sums[0] = 0.0
        return sums.astype(np.float64)

    return Contour(
        area=area + total(parts * weight),
        length=total(chords * smooth),
        euler=total(euler * smooth),
        sharp=total(jagged * weight) / np.maximum(total(weight), cell),
        alike=_divide(total(alike * weight), total(weight)),
    )


def _divide(sums: Array, counts: Array) -> Array:
    return np.divide(sums, counts, out=np.ones_like(sums), where=counts > 0.0)


def _count_alike(parts: Array, chords: Array, distance: Corners) -> Array:
    """Return how many dual cells have the same edge as each, shape (n,).

    Where the contact repeats on the grid, or is symmetric in it, the errors of its parts are the same.
    """
    highest = np.abs(distance).max(axis=0)
    features = np.stack((parts, chords, highest / np.maximum(highest.max(initial=0.0), np.finfo(float).tiny)))
    keys = np.floor(features / _ALIKE + _OFFSET).astype(np.int64)
    _, index, counts = np.unique((keys[0] * _KEYS + keys[1]) * _KEYS + keys[2], return_inverse=True, return_counts=True)
    return counts[index].astype(np.float64)


def _sum_full(labels: list[IntArray], full: Mask, weight: Array, count: int) -> Array:
    """Return the weights of the dual cells inside each patch; one whose corners differ counts by quarters."""
    one = (labels[0] == labels[2]) & (labels[1] == labels[3]) & (labels[0] == labels[1])
    alike, mixed = full & one, full & ~one
    sums = np.bincount(labels[0][alike], weights=weight[alike], minlength=count + 1)
    for corner in labels if mixed.any() else ():
        sums = sums + np.bincount(corner[mixed], weights=0.25 * weight[mixed], minlength=count + 1)
    return sums.astype(np.float64)


def outline(solution: ContactSolution) -> Array:
    """Return the edge of the contact as straight pieces, for a figure: their ends (x, y), shape (n, 2, 2), m."""
    dual = _find_dual_cells(solution, 1)
    inside = dual.count_inside(solution.contact)
    chosen = np.flatnonzero((inside > 0) & (inside < 4))
    k, size = dual.cells(chosen), solution.grid.spacing
    touching = solution.contact.ravel()[k]
    crossing = find_crossings(_find_distances(solution, k, touching, size))
    first = np.stack(np.divmod(chosen, dual.shape[1]), axis=-1) - dual.before
    which, ends = find_segments(crossing, touching)
    origin = np.array((solution.grid.x[0, 0], solution.grid.y[0, 0]))
    return np.asarray(origin + (first[which][:, np.newaxis] + ends) * size)


def _find_dual_cells(solution: ContactSolution, stride: int) -> _DualCells:
    if solution.boundary is not Boundary.FREE:
        nx, ny = solution.grid.shape
        return _DualCells(stride, 0, "wrap", (np.ones(nx), np.ones(ny)))
    weights = []
    for n in solution.grid.shape:
        # The domain ends half a cell beyond the outermost centres.
        first = np.arange(-stride, n)
        inside = np.minimum(first + stride, n - 0.5) - np.maximum(first, -0.5)
        weights.append(np.clip(inside, 0.0, stride) / stride)
    return _DualCells(stride, stride, "edge", (weights[0], weights[1]))


def find_modulus_change(solution: ContactSolution) -> float:
    """Return the logarithm of the change of E* over two octaves of wavelength at the edge; zero without layers."""
    length = calibration.EDGE_LENGTH * math.sqrt(solution.grid.cell_area)
    shorter, longer = solution.effective_modulus(np.array([2.0, 0.5]) / length)
    return abs(math.log(longer / shorter))


def _find_distances(solution: ContactSolution, k: IntArray, contact: Mask, size: tuple[float, float]) -> Corners:
    """Return the signed distance from the edge at the corners `k` of dual cells, shape (4, n), m."""
    step = np.sqrt(size[0] * size[1])
    inside = np.square(
        solution.pressure.ravel()[k] / solution.effective_modulus(1.0 / (calibration.EDGE_LENGTH * step))
    )
    outside = np.zeros_like(inside)
    outside[~contact] = np.cbrt(np.square(0.75 * np.maximum(solution.gap.ravel()[k[~contact]], 0.0)))
    ax, ay = _differentiate(inside, size)
    bx, by = _differentiate(outside, size)
    # |grad phi|^2 is a cubic in w = y^2.
    cubic, square, linear = ax * ax + ay * ay, -2.0 * (ax * bx + ay * by), bx * bx + by * by
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
    with np.errstate(divide="ignore"):
        # Where no coefficient is negative, each term alone gives an upper bound, from which the steps descend.
        w = np.minimum(np.minimum(np.cbrt(value / cubic), value / linear), highest)
    for _ in range(_NEWTON):
        excess, slope = ((cubic * w + square) * w + linear) * w - value, (3.0 * cubic * w + 2.0 * square) * w + linear
        w = w - np.divide(excess, slope, out=np.full_like(w, np.nan), where=slope != 0.0)
    wild = (square < 0.0) | ~(w >= 0.0)
    if wild.any():
        w[wild] = _find_bracketed_root(cubic[wild], square[wild], linear[wild], highest[wild], value)
    return w


def _find_bracketed_root(cubic: Array, square: Array, linear: Array, highest: Array, value: float) -> Array:
    low, high = np.zeros_like(highest), highest.copy()
    w = 0.5 * highest
    for _ in range(_BRACKETED):
        excess = ((cubic * w + square) * w + linear) * w - value
        above = excess > 0.0
        np.copyto(high, w, where=above)
        np.copyto(low, w, where=~above)
        slope = (3.0 * cubic * w + 2.0 * square) * w + linear
        with np.errstate(divide="ignore", invalid="ignore"):
            trial = w - excess / slope
        w = np.where((trial > low) & (trial < high), trial, 0.5 * (low + high))
    return w
