r"""The edge of the contact between cell centres.

Near a smooth edge, at the distance d, the pressure is :math:`K\sqrt{d}` inside and the gap
:math:`\tfrac{4K}{3E^*}d^{3/2}` outside, with one K for both. So with the one unknown y = (K/E*)^(-2/3)

.. math:: \varphi = (p/E^*)^2 y^3 \text{ inside}, \quad \varphi = -(3g/4)^{2/3} y \text{ outside}

is the signed distance from the edge on both sides, and y follows from a distance having the
gradient one. Between the centres of four neighbouring cells (a dual cell) the edge is then drawn
where the interpolated distance vanishes.

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

from roughcontact.areas.polygons import Corners, crossings, polygons, segments
from roughcontact.checks import Array, IntArray, Mask
from roughcontact.grid import Boundary
from roughcontact.solution import ContactSolution

# Inverse wave number of what is seen within a cell or two of the edge, in cells, where E* depends on it.
EDGE = 0.5
# Differences of the distance across a dual cell are below this many cells, or the edge is not smooth.
_STEEPEST = 16.0
# Where no y gives the gradient one, as in saddles, the corners are this many cells apart in distance.
_SADDLE = 0.7
_ROUNDS = 6
_BRACKETED = 16


@attrs.frozen(eq=False)
class Contour:
    """The edge of each cluster, by number; the first entry stands for no cluster and is zero.

    Attributes
    ----------
    area
        Area inside the edge, shape (count + 1,), m2.
    length
        Length of the edge, m.
    euler
        Euler number: one for each piece, less one for each hole.
    sharp
        Share of the edge that is sharp.
    """

    area: Array
    length: Array
    euler: Array
    sharp: Array


@attrs.frozen(eq=False)
class _DualCells:
    """Dual cells of one stride, their lower left corners in order; a frame gives all of them four corners.

    Attributes
    ----------
    stride
        Distance of the corners, in cells.
    before
        Width of the frame before the first cell; after the last it is `stride`.
    mode
        How fields go on in the frame.
    weights
        Share of each dual cell along each axis that lies in the domain.
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
        framed = np.pad(field, (self.before, s), mode=self.mode)
        return [framed[dx : dx + m, dy : dy + n] for dx, dy in ((0, 0), (s, 0), (s, s), (0, s))]

    def inside(self, contact: Mask) -> npt.NDArray[np.uint8]:
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


def contour(solution: ContactSolution, sharp: Mask, stride: int = 1) -> Contour:
    """Return the edge of the contact, drawn between every cell or between cells `stride` apart.

    With a stride all ways of choosing the cells are averaged.

    Parameters
    ----------
    solution
        The solved contact.
    sharp
        Cells at sharp edges, shape (nx, ny); there the cells are counted.
    stride
        Distance of the corners of a dual cell, in cells.
    """
    dual = _dual_cells(solution, stride)
    count, cell = solution.clusters.count, solution.grid.cell_area
    inside = dual.inside(solution.contact)
    weight = np.multiply.outer(*dual.weights)
    whole = inside == 4
    area = cell * _shared(dual.corners(solution.clusters.labels), whole, weight, count)
    chosen = np.flatnonzero((inside > 0) & ~whole)
    weight, inside, k = weight.ravel()[chosen], inside.ravel()[chosen], dual.cells(chosen)
    touching, jagged = solution.contact.ravel()[k], sharp.ravel()[k].any(axis=0)
    size = (stride * solution.grid.spacing[0], stride * solution.grid.spacing[1])
    distance = _distances(solution, k, touching, size)
    parts, chords, euler = polygons(distance, touching, inside, size)
    parts = np.where(jagged, inside / 4.0 * (size[0] * size[1]), parts)
    label = solution.clusters.labels.ravel()[k]
    # Each way to choose the cells covers the whole contact.
    weight = weight / stride**2
    smooth = weight * ~jagged

    def total(values: Array) -> Array:
        # Corners two cells apart may lie in different clusters: each has its share.
        shares = np.where(touching, values / inside, 0.0)
        found = np.bincount(label.ravel(), weights=shares.ravel(), minlength=count + 1)
        found[0] = 0.0
        return found.astype(np.float64)

    return Contour(
        area=area + total(parts * weight),
        length=total(chords * smooth),
        euler=total(euler * smooth),
        sharp=total(jagged * weight) / np.maximum(total(weight), cell),
    )


def _shared(labels: list[IntArray], whole: Mask, weight: Array, count: int) -> Array:
    """Return the weights of the whole dual cells of each cluster; where corners differ each has a quarter."""
    one = (labels[0] == labels[2]) & (labels[1] == labels[3]) & (labels[0] == labels[1])
    alike, mixed = whole & one, whole & ~one
    sums = np.bincount(labels[0][alike], weights=weight[alike], minlength=count + 1)
    for corner in labels if mixed.any() else ():
        sums = sums + np.bincount(corner[mixed], weights=0.25 * weight[mixed], minlength=count + 1)
    return sums.astype(np.float64)


def outline(solution: ContactSolution) -> Array:
    """Return the edge of the contact as straight pieces, for a picture.

    Returns
    -------
    Array
        Both ends (x, y) of each piece, shape (n, 2, 2), m.
    """
    dual = _dual_cells(solution, 1)
    inside = dual.inside(solution.contact)
    chosen = np.flatnonzero((inside > 0) & (inside < 4))
    k, size = dual.cells(chosen), solution.grid.spacing
    touching = solution.contact.ravel()[k]
    share = crossings(_distances(solution, k, touching, size))
    first = np.stack(np.divmod(chosen, dual.shape[1]), axis=-1) - dual.before
    which, ends = segments(share, touching)
    origin = np.array((solution.grid.x[0, 0], solution.grid.y[0, 0]))
    return np.asarray(origin + (first[which][:, np.newaxis] + ends) * size)


def _dual_cells(solution: ContactSolution, stride: int) -> _DualCells:
    if solution.boundary is not Boundary.FREE:
        nx, ny = solution.grid.shape
        return _DualCells(stride, 0, "wrap", (np.ones(nx), np.ones(ny)))
    weights = []
    for n in solution.grid.shape:
        # The outermost cells reach half a cell beyond their centres, and their fields with them.
        first = np.arange(-stride, n)
        inside = np.minimum(first + stride, n - 0.5) - np.maximum(first, -0.5)
        weights.append(np.clip(inside, 0.0, stride) / stride)
    return _DualCells(stride, stride, "edge", (weights[0], weights[1]))


def change_at_edge(solution: ContactSolution) -> float:
    """Return the logarithm of the change of the modulus over two octaves at the edge, zero without layers."""
    length = EDGE * math.sqrt(solution.grid.cell_area)
    shorter, longer = solution.modulus_at(np.array([0.5 * length, 2.0 * length]))
    return abs(math.log(longer / shorter))


def _distances(solution: ContactSolution, k: IntArray, contact: Mask, size: tuple[float, float]) -> Corners:
    """Return the signed distance from the edge at the corners `k` of dual cells, shape (4, n), m."""
    step = np.sqrt(size[0] * size[1])
    inside = np.square(solution.pressure.ravel()[k] / solution.modulus_at(EDGE * step))
    outside = np.zeros_like(inside)
    outside[~contact] = np.cbrt(np.square(0.75 * np.maximum(solution.gap.ravel()[k[~contact]], 0.0)))
    ax, ay = _gradient(inside, size)
    bx, by = _gradient(outside, size)
    # |grad phi|^2 is a cubic in w = y^2.
    cubic, square, linear = ax * ax + ay * ay, -2.0 * (ax * bx + ay * by), bx * bx + by * by
    steepest = _STEEPEST * step
    with np.errstate(divide="ignore"):
        highest = np.minimum(np.cbrt(steepest / inside.max(axis=0)) ** 2, (steepest / outside.max(axis=0)) ** 2)
    highest = np.where(np.isfinite(highest), highest, 1.0)
    w = _root(cubic, square, linear, highest)
    lost = ((cubic * highest + square) * highest + linear) * highest < 1.0
    if lost.any():
        top = inside[:, lost].max(axis=0), outside[:, lost].max(axis=0)
        # A root of P y^3 + G y = 0.7 cells, by the same means: its square is a cubic in w.
        w[lost] = _root(top[0] ** 2, 2 * top[0] * top[1], top[1] ** 2, highest[lost], (_SADDLE * step) ** 2)
    y = np.sqrt(w)
    return np.asarray(inside * (w * y) - outside * y)


def _gradient(values: Corners, size: tuple[float, float]) -> tuple[Array, Array]:
    low_left, high_left, high_right, low_right = values
    along_x = (high_left + high_right - low_left - low_right) / (2.0 * size[0])
    along_y = (high_right + low_right - low_left - high_left) / (2.0 * size[1])
    return along_x, along_y


def _root(cubic: Array, square: Array, linear: Array, highest: Array, value: float = 1.0) -> Array:
    """Return w in [0, highest] where the polynomial reaches a value."""
    with np.errstate(divide="ignore"):
        # Where all terms rise, each alone gives an upper bound, from which Newton's method descends.
        w = np.minimum(np.minimum(np.cbrt(value / cubic), value / linear), highest)
    for _ in range(_ROUNDS):
        excess, slope = ((cubic * w + square) * w + linear) * w - value, (3.0 * cubic * w + 2.0 * square) * w + linear
        w = w - np.divide(excess, slope, out=np.full_like(w, np.nan), where=slope != 0.0)
    wild = (square < 0.0) | ~(w >= 0.0)
    if wild.any():
        w[wild] = _bracketed(cubic[wild], square[wild], linear[wild], highest[wild], value)
    return w


def _bracketed(cubic: Array, square: Array, linear: Array, highest: Array, value: float) -> Array:
    """Return the same by Newton's method inside a bracket."""
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
