"""The initial gap under the contact: its curvature, how well the grid resolves it, and a spline between the cells."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import Literal

import attrs
import numpy as np

from roughcontact._answers.areas.cells import CORNER_STEPS, NEIGHBOUR_STEPS, SIDE_STEPS, Neighbourhood, split
from roughcontact._base.arrays import Array, IntArray, Mask, Pair
from roughcontact._parts.grid import Boundary, as_boundary, pad_axes
from roughcontact._solve.solution import ContactSolution, Whole, heal

# Offset of the outermost cell of the second differences, in cells: of eighth order, 0.7 % too small at four cells a
# wave.
_DIFFERENCE_REACH = 4
# Number of cells that give the mean squares of differences to about 1 %.
_SAMPLE_CELLS = 100_000
# Cells below which a patch does not show how the curvature varies under it, so that the cells around it are used.
_TINY_PATCH_CELLS = 9
# Smallest number of cells that show whether heights are linear between points.
_MIN_LINEAR_CELLS = 24
# Fraction of them that then has no kink.
_KINKLESS_FRACTION = 0.3
# Smallest fraction of the differences that are distinct to these digits; a kink between two cells counts at both.
_MIN_DISTINCT_FRACTION = 0.35
_DISTINCT_DIGITS = 6
# Mean product of second differences of neighbours over their mean square, negative, from which heights have steps.
_MIN_STEP_CORRELATION = 0.1
# Largest differences, over their rms, that count as alike.
_ALIKE_DIFFERENCE = 1e-3
# Largest relative difference of heights or places that are equal up to rounding.
ROUNDING = 1e-6
# Steps, in cells, to the three by three cells around one.
_SURROUNDINGS = np.mgrid[-1:2, -1:2].reshape(2, 9).T
# Degree of the spline: its second derivatives err by (q h)^4 / 720, 0.02 % at ten cells a wave.
_DEGREE: Literal[5] = 5
# Number of centres before, and behind, a point whose B-splines cover the point.
SPLINE_REACH = 3
_CENTRES = np.arange(SPLINE_REACH + SPLINE_REACH)
# Cells by which values are continued beyond a free border: a mirrored spline bends at the border, and the bend has an
# effect over as many cells.
CONTINUED_CELLS = 8
# Second differences across a border, over those inside, from which heights do not repeat there: one on waves that do,
# and about the number of cells on a ball. Cells at a border that no contact touches then; lines that are compared.
_MIN_BORDER_STEP = 4.0
_BORDER_CELLS = 3
_COMPARED_LINES = 256
# Points at a time: their coefficients stay in a core's cache.
_POINTS_PER_CHUNK = 1024


def _weigh_second_difference(reach: int) -> list[float]:
    """Return the weights of the central second difference of highest order at the offsets 0 to the reach (exact)."""
    whole = math.factorial(reach) ** 2
    weights = [-2 * sum(whole // k**2 for k in range(1, reach + 1)) / whole]
    for k in range(1, reach + 1):
        weights.append(-2 * (-1) ** k * whole / (k**2 * math.factorial(reach - k) * math.factorial(reach + k)))
    return weights


def _list_pieces(degree: int) -> Array:
    """Return the pieces of the B-spline of a degree, the last first, in powers of the fraction of a cell (exact)."""
    pieces = [
        [
            sum((-1) ** k * math.comb(degree + 1, k) * (piece - k) ** (degree - power) for k in range(piece + 1))
            * math.comb(degree, power)
            for power in range(degree + 1)
        ]
        for piece in range(degree, -1, -1)
    ]
    return np.array(pieces, dtype=np.float64) / math.factorial(degree)


def _derive_pieces(pieces: Array) -> Array:
    """Return the derivatives of pieces in powers of a fraction, of the same shape."""
    powers = np.arange(1, pieces.shape[1])
    return np.pad(pieces[:, 1:] * powers, ((0, 0), (0, 1)))


_SECOND_DIFFERENCE = _weigh_second_difference(_DIFFERENCE_REACH)
# The pieces of the B-spline at its centres, and with their first and second derivatives.
_SPLINE_PIECES = _list_pieces(_DEGREE)
_PIECE_FACTORS = np.concatenate(
    (_SPLINE_PIECES, _derive_pieces(_SPLINE_PIECES), _derive_pieces(_derive_pieces(_SPLINE_PIECES)))
)


def average_curvature(solution: ContactSolution) -> tuple[Array, Array, Array, Array]:
    """Return the curvature of the initial gap under each patch, averaged over its cells weighted by pressure.

    These are half the sum of the principal curvatures, 1/m, positive at a summit; half their difference, 1/m; the
    standard deviation of all components over the patch, relative to the first; and half the sum of the second
    differences along x and y, m; each of shape (count + 1,).
    """
    # Perimeter, approach and mean gap ask for the same.
    return solution._keep("average curvature", lambda: _average_curvature(solution))


def _average_curvature(solution: ContactSolution) -> tuple[Array, Array, Array, Array]:
    patches = solution.patches
    chosen = np.flatnonzero(solution.contact)
    label = patches.labels.ravel()[chosen]
    weights = solution.pressure.ravel()[chosen]
    cells = np.concatenate(([0], patches.cells))
    tiny = chosen[cells[label] < _TINY_PATCH_CELLS]
    around, owner = _find_neighbours(solution, tiny)
    hessian = _find_hessian(solution, np.concatenate((chosen, around)))
    mean, variance = _average([part[: chosen.size] for part in hessian], label, weights, patches.count)
    _, beyond = _average([part[chosen.size :] for part in hessian], owner, np.ones(around.size), patches.count)
    # Mean square distance from the centre along an axis: 2/3 of three by three cells; a^2 / 5 of a circle of radius a,
    # weighted by Hertz's pressure (exact).
    reach = (1.0 / 5.0) * cells / np.pi / (2.0 / 3.0 + cells / (4.0 * np.pi))
    variance = np.maximum(variance, np.where(cells < _TINY_PATCH_CELLS, beyond * reach, 0.0))
    middle, difference = combine_principal(mean[0], mean[2], mean[1])
    with np.errstate(divide="ignore", invalid="ignore"):
        spread = np.sqrt(variance) / np.abs(middle)
    dx, dy = solution.grid.spacing
    bend = 0.5 * (dx**2 * mean[0] + dy**2 * mean[1])
    return middle, difference, spread, bend


def combine_principal(xx: Array, xy: Array, yy: Array) -> tuple[Array, Array]:
    """Return half the sum and half the difference of the principal curvatures of second derivatives."""
    return 0.5 * (xx + yy), np.hypot(0.5 * (xx - yy), xy)


def bend_at_border(solution: ContactSolution, chosen: IntArray) -> Array:
    """Return half the sum of the second differences along x and y of cells near a free border, m; zero elsewhere.

    The stencil of `average_curvature` is moved inside there, where the curvature may be another one.
    """
    i, j = split(chosen, solution.grid.shape[1])
    near = np.zeros(chosen.shape, dtype=bool)
    for at, n, free in zip((i, j), solution.grid.shape, solution.boundary.free_axes, strict=True):
        if free:
            near |= (at < _DIFFERENCE_REACH) | (at >= n - _DIFFERENCE_REACH)
    bends = np.zeros(chosen.shape)
    lines = _gather_lines(solution, Neighbourhood.inside(solution, chosen[near], 1), 1, 2)
    bends[near] = 0.5 * sum(pairs[0] - 2.0 * here for here, pairs in lines)
    return bends


def is_linear(solution: ContactSolution, chosen: IntArray) -> bool:
    """Return whether the heights at the chosen cells are linear between points further apart than the cells.

    The second difference is then zero at many cells, or the same at two neighbours: there is no kink between them.
    """
    if chosen.size < _MIN_LINEAR_CELLS:
        return False
    chosen = chosen[:: max(1, chosen.size // _SAMPLE_CELLS)]
    lines = _find_differences(solution, chosen)
    here, after = max(lines, key=lambda line: float(np.sum((line[1] - line[0]) ** 2)))
    second = math.sqrt(float(np.mean(here**2)))
    third = math.sqrt(float(np.mean((after - here) ** 2)))
    # A step bends the line one way before it and the other way behind it.
    steps = float(np.mean(here * after)) < -_MIN_STEP_CORRELATION * second**2
    if steps or second == 0.0 or third <= ROUNDING * second:
        return False
    if not _are_distinct(solution.parts, here[np.abs(here) > _ALIKE_DIFFERENCE * second] / second):
        return False
    kinked = np.minimum(np.abs(here) / second, np.abs(after - here) / third)
    return bool(np.quantile(kinked, _KINKLESS_FRACTION) < _ALIKE_DIFFERENCE)


def find_filled(solution: ContactSolution, chosen: IntArray) -> Mask:
    """Return which of the chosen cells have the mean height of their four neighbours, as filled points have."""
    (along_x, _), (along_y, _) = _find_differences(solution, chosen)
    whole = solution.parts
    if whole.total(chosen.size) == 0:
        return np.zeros(chosen.shape, dtype=bool)
    size = math.sqrt(whole.mean(along_x**2 + along_y**2))
    filled = (np.abs(along_x + along_y) < ROUNDING * size) & (np.abs(along_x) > ROUNDING * size)
    if not whole.total(np.count_nonzero(filled)) or not _are_distinct(whole, along_x / size):
        return np.zeros(chosen.shape, dtype=bool)
    return np.asarray(filled)


def _are_distinct(whole: Whole, differences: Array) -> bool:
    """Return whether few differences are equal: many are if summits lie alike on the grid, or heights are rounded."""
    distinct = whole.count_distinct(np.round(differences, _DISTINCT_DIGITS))
    return distinct >= _MIN_DISTINCT_FRACTION * whole.total(differences.size)


def _find_differences(solution: ContactSolution, chosen: IntArray) -> list[tuple[Array, Array]]:
    """Return the second differences of the initial gap at cells and at the next cells along x and y, m."""
    near = Neighbourhood.inside(solution, chosen, 2)
    heights = solution.initial_gap.ravel()
    found = []
    for a, b in ((1, 0), (0, 1)):
        first, second, third, fourth = heights.take(near.at(np.outer(range(-1, 3), (a, b))))
        found.append((first - 2.0 * second + third, second - 2.0 * third + fourth))
    return found


def curvature_resolution(solution: ContactSolution) -> float:
    """Return the resolution ratio (q h)^2 of the heights under the contact: small where the grid resolves them.

    The rms of the fourth differences over the rms of the second differences, equal to (q h)^2 for one wave of wave
    number q on cells of size h.
    """
    return _measure_heights(solution)[0]


def rim_ratio(solution: ContactSolution) -> float:
    """Return the mean curvature of the heights along the edge of the contact over the mean inside; zero without inside.

    Summits have less curvature along the edge, sharp rims of flats that were run in have more.
    """
    return _measure_heights(solution)[1]


def lay_ratio(solution: ContactSolution) -> float:
    """Return the smallest over the largest rms curvature in any direction under the contact.

    One for isotropic heights, zero for ridges of one direction.
    """
    return _measure_heights(solution)[2]


def _measure_heights(solution: ContactSolution) -> tuple[float, float, float]:
    """Return resolution, rim ratio and lay ratio."""
    healed = heal(solution)
    return healed._keep("ratios of curvatures", lambda: _find_ratios(healed))


def _find_ratios(solution: ContactSolution) -> tuple[float, float, float]:
    whole = solution.parts
    chosen = whole.sample(np.flatnonzero(whole.own(solution.contact)), _SAMPLE_CELLS)
    if whole.total(chosen.size) == 0:
        return 0.0, 0.0, 1.0
    near = Neighbourhood.inside(solution, chosen, 2)
    lines = list(_gather_lines(solution, near, 2, 2))
    corners = solution.initial_gap.ravel().take(near.at(CORNER_STEPS))
    bends = [pairs[0] - 2.0 * here for here, pairs in lines]
    fourth = sum(whole.mean((pairs[1] - 4.0 * pairs[0] + 6.0 * here) ** 2) for here, pairs in lines)
    second = sum(whole.mean(bend**2) for bend in bends)
    dx, dy = solution.grid.spacing
    mixed = 0.25 * ((corners[0] + corners[1]) - (corners[2] + corners[3]))
    xx = bends[0] / dx**2
    xy = mixed / (dx * dy)
    yy = bends[1] / dy**2
    laplacian = xx + yy
    inside = _find_inner(solution, chosen)
    inner, outer = whole.total(np.array([np.count_nonzero(inside), np.count_nonzero(~inside)]))
    middle = abs(whole.mean(laplacian[inside])) if inner else 0.0
    rim = whole.mean(laplacian[~inside]) / middle if middle > 0.0 and outer else 0.0
    ratio = math.sqrt(fourth / second) if second > 0.0 else 0.0
    return ratio, rim, _find_lay(whole, xx, xy, yy)


def _find_lay(whole: Whole, xx: Array, xy: Array, yy: Array) -> float:
    """Return the lay ratio for these second derivatives, from the mean square of their 2 x 2 matrix."""
    along_x = whole.mean(xx**2 + xy**2)
    along_y = whole.mean(xy**2 + yy**2)
    middle = 0.5 * (along_x + along_y)
    difference = math.hypot(0.5 * (along_x - along_y), whole.mean(xy * (xx + yy)))
    return math.sqrt(max(middle - difference, 0.0) / (middle + difference)) if middle > 0.0 else 1.0


def _find_inner(solution: ContactSolution, chosen: IntArray) -> Mask:
    """Return which cells have neighbours in contact on all four sides."""
    shape = solution.contact.shape
    contact = solution.contact.ravel()
    places = split(chosen, shape[1])
    near = Neighbourhood.of(*places, shape, Boundary.PERIODIC, 1)
    inner = contact[near.at(SIDE_STEPS)].all(axis=0)
    for at, n, free in zip(places, shape, solution.boundary.free_axes, strict=True):
        if free:
            # Beyond a free border nothing touches.
            inner &= (at > 0) & (at < n - 1)
    return np.asarray(inner)


def _average(hessian: list[Array], label: IntArray, weights: Array, count: int) -> tuple[Array, Array]:
    """Return the mean of each component by patch, shape (3, count + 1), and the variance of all together."""
    total = np.bincount(label, weights=weights, minlength=count + 1)
    total[total == 0.0] = 1.0

    def mean(values: Array) -> Array:
        return np.asarray(np.bincount(label, weights=weights * values, minlength=count + 1) / total)

    means = np.stack([mean(part) for part in hessian])
    squares = [mean((part - middle[label]) ** 2) for part, middle in zip(hessian, means, strict=True)]
    return means, squares[0] + squares[1] + 2.0 * squares[2]


def _find_neighbours(solution: ContactSolution, chosen: IntArray) -> tuple[IntArray, IntArray]:
    """Return the three by three cells around each cell, and the patch that each of them belongs to."""
    shape = solution.contact.shape
    near = Neighbourhood.of(*split(chosen, shape[1]), shape, solution.boundary, 1)
    return near.at(_SURROUNDINGS).T.ravel(), np.repeat(solution.patches.labels.ravel()[chosen], 9)


def _find_hessian(solution: ContactSolution, chosen: IntArray) -> tuple[Array, Array, Array]:
    """Return the xx, yy and xy derivatives of the initial gap at cells, 1/m."""
    dx, dy = solution.grid.spacing
    near = Neighbourhood.inside(solution, chosen, _DIFFERENCE_REACH)
    along_x, along_y, rising, falling = (
        _SECOND_DIFFERENCE[0] * here
        + sum(factor * pair for factor, pair in zip(_SECOND_DIFFERENCE[1:], pairs, strict=True))
        for here, pairs in _gather_lines(solution, near, _DIFFERENCE_REACH, 4)
    )
    # Second differences along both diagonals differ by four mixed ones.
    return along_x / dx**2, along_y / dy**2, (rising - falling) / (4.0 * dx * dy)


def _gather_lines(
    solution: ContactSolution, near: Neighbourhood, reach: int, lines: int
) -> Iterator[tuple[Array, Array]]:
    """Yield the gap at cells, with the sums of both neighbours at each distance, along x, y and both diagonals.

    `lines` is the number of these lines.
    """
    heights = solution.initial_gap.ravel()
    here = heights.take(near.cells)
    steps = np.arange(1, reach + 1)
    for direction in NEIGHBOUR_STEPS[: 2 * lines : 2]:
        pairs = heights.take(near.at(np.outer(steps, direction)))
        pairs += heights.take(near.at(np.outer(-steps, direction)))
        yield here, pairs


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
        ends = (SPLINE_REACH - 1, SPLINE_REACH)
        if not boundary.has_free_axis:
            return cls(pad_axes(_solve_periodic(values), (ends, ends), (False, False)), spacing, (True, True), (0, 0))
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
        parts = self._evaluate(np.stack((i.ravel(), j.ravel())), degrees)
        parts /= _list_units(self.spacing, degrees)
        return parts.reshape(len(parts), *i.shape)

    def _evaluate(self, at: Array, degrees: Sequence[int]) -> Array:
        """Return derivatives, per cell, at points of shape (2, n)."""
        width = self.coefficients.shape[1]
        flat = self.coefficients.ravel()
        if self.beyond != (0, 0):
            at = at + np.array(self.beyond)[:, np.newaxis]
        first = np.floor(at)
        fraction = at - first
        i, j = first.astype(np.intp)
        nx, ny = (n - (SPLINE_REACH - 1) - SPLINE_REACH for n in self.coefficients.shape)
        # A free domain is continued by more cells than an ellipse inside it needs.
        repeats_x, repeats_y = self.periodic
        row = i % nx if repeats_x else np.clip(i, 0, nx - 1)
        cell = row * width + (j % ny if repeats_y else np.clip(j, 0, ny - 1))
        around = (_CENTRES[:, np.newaxis] * width + _CENTRES)[..., np.newaxis]
        highest = max(degrees)
        sums = np.empty((sum(degrees) + len(degrees), cell.size))
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


@lru_cache(maxsize=64)
def _list_units(spacing: Pair, degrees: tuple[int, ...]) -> Array:
    """Return the units of the derivatives of these degrees per cell, shape (derivatives, 1)."""
    dx, dy = spacing
    return np.array([[dx ** (degree - n) * dy**n] for degree in degrees for n in range(degree + 1)])


def _weigh(fraction: Array, highest: int) -> Array:
    """Return the factors of the B-splines around points, shape (2, n), as an array (2, orders, centres, n)."""
    powers = np.empty((_DEGREE + 1, fraction.size))
    powers[0] = 1.0
    powers[1] = fraction.ravel()
    for degree in range(1, _DEGREE):
        np.multiply(powers[degree], powers[1], out=powers[degree + 1])
    factors = _PIECE_FACTORS[: (highest + 1) * len(_SPLINE_PIECES)] @ powers
    return factors.reshape(highest + 1, len(_SPLINE_PIECES), 2, -1).transpose(2, 0, 1, 3)


@lru_cache(maxsize=8)
def _invert_splines(cells: int, count: int) -> Array:
    """Return the inverse of the transform of the B-spline at the first waves of so many cells."""
    own, first, second = _SPLINE_PIECES[SPLINE_REACH - 1 : -1, 0]
    angle = 2.0 * np.pi * np.arange(count) / cells
    return np.asarray(1.0 / (own + 2.0 * first * np.cos(angle) + 2.0 * second * np.cos(2.0 * angle)))


def _solve_periodic(values: Array) -> Array:
    """Return the coefficients of the B-splines of a spline that repeats beyond the border."""
    from scipy import fft

    nx, ny = values.shape
    spectrum = fft.rfft2(values)
    spectrum *= _invert_splines(nx, nx)[:, np.newaxis]
    spectrum *= _invert_splines(ny, ny // 2 + 1)
    return np.asarray(fft.irfft2(spectrum, values.shape))


def _find_repeating_axes(solution: ContactSolution) -> Boundary:
    """Return the boundary that is free also where heights have a step or a kink at a border that no contact touches.

    A spline across it would swing far into the domain.
    """
    ends = []
    fields = (solution.initial_gap, solution.contact), (solution.initial_gap.T, solution.contact.T)
    for free, (gap, contact) in zip(solution.boundary.free_axes, fields, strict=True):
        beside = contact[:_BORDER_CELLS].any() or contact[-_BORDER_CELLS:].any()
        ends.append(free or not (beside or _goes_on(gap)))
    if tuple(ends) == solution.boundary.free_axes:
        return solution.boundary
    return as_boundary(["free" if end else "periodic" for end in ends])


def _goes_on(values: Array) -> bool:
    """Return whether values go on across the ends of the first axis as inside."""
    if len(values) < 4 * _BORDER_CELLS:
        return True
    lines = values[:, :: max(1, values.shape[1] // _COMPARED_LINES)]
    border, inside = (
        np.diff(part[1:] - part[:-1], axis=0) for part in (np.concatenate((lines[-2:], lines[:2])), lines)
    )
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
