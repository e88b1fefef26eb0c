"""Curvature of the initial gap under the contact, and how well the grid resolves it."""

from __future__ import annotations

import math

import numpy as np

from roughcontact._answers.areas.cells import Neighbourhood, split
from roughcontact._base.arrays import Array, IntArray, Mask
from roughcontact._parts.grid import Boundary
from roughcontact._solve.solution import ContactSolution, Whole, heal

# Weights of the central second difference of eighth order at the offsets 0 to 4: 0.7 % too small at four cells a wave.
_SECOND_DIFFERENCE = (-205.0 / 72.0, 8.0 / 5.0, -1.0 / 5.0, 8.0 / 315.0, -1.0 / 560.0)
# Offset of the outermost cell of that difference, in cells.
_DIFFERENCE_REACH = len(_SECOND_DIFFERENCE) - 1
# Number of cells that give the mean squares of differences to about 1 %.
_SAMPLE_CELLS = 100_000
# Cells below which a patch does not show how the curvature varies under it, so that the cells around it are used.
_TINY_PATCH_CELLS = 9
# Mean square distance from the centre along an axis: of three by three cells, cell^2 ...
_SQUARE_VARIANCE = 2.0 / 3.0
# ... and of a circle of radius one, weighted by Hertz's pressure (exact).
_CIRCLE_VARIANCE = 1.0 / 5.0
# Smallest number of cells that show whether heights are linear between points.
_MIN_LINEAR_CELLS = 24
# Fraction of them that then has no kink.
_KINKLESS_FRACTION = 0.3
# Smallest fraction of the differences that are distinct to these digits; a kink between two cells counts at both.
_MIN_DISTINCT_FRACTION = 0.35
_DISTINCT_DIGITS = 6
# Mean product of second differences of neighbours over their mean square, negative, from which heights have steps.
_MIN_STEP_CORRELATION = 0.1
# Largest differences, over their rms, that count as alike, and as equal up to rounding.
_ALIKE_DIFFERENCE = 1e-3
_EXACT_DIFFERENCE = 1e-6


def average_curvature(solution: ContactSolution, chosen: IntArray) -> tuple[Array, Array, Array, Array]:
    """Return the curvature of the initial gap under each patch, averaged over the chosen cells weighted by pressure.

    These are half the sum of the principal curvatures, 1/m, positive at a summit; half their difference, 1/m; the
    standard deviation of all components over the patch, relative to the first; and half the sum of the second
    differences along x and y, m; each of shape (count + 1,).
    """
    patches = solution.patches
    label = patches.labels.ravel()[chosen]
    weights = solution.pressure.ravel()[chosen]
    cells = np.concatenate(([0], patches.cells))
    tiny = chosen[cells[label] < _TINY_PATCH_CELLS]
    around, owner = _find_neighbours(solution, tiny)
    hessian = _find_hessian(solution, np.concatenate((chosen, around)))
    mean, variance = _average([part[: chosen.size] for part in hessian], label, weights, patches.count)
    _, beyond = _average([part[chosen.size :] for part in hessian], owner, np.ones(around.size), patches.count)
    reach = _CIRCLE_VARIANCE * cells / np.pi / (_SQUARE_VARIANCE + cells / (4.0 * np.pi))
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
    bends[near] = 0.5 * sum(pairs[0] - 2.0 * here for here, pairs in _gather_lines(solution, chosen[near], 1, 2))
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
    if steps or second == 0.0 or third <= _EXACT_DIFFERENCE * second:
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
    filled = (np.abs(along_x + along_y) < _EXACT_DIFFERENCE * size) & (np.abs(along_x) > _EXACT_DIFFERENCE * size)
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
        first, second, third, fourth = (heights.take(near.at(k * a, k * b)) for k in range(-1, 3))
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


def bend_kurtosis(solution: ContactSolution) -> float:
    """Return the kurtosis of the second differences under the contact: 3 of Gaussian heights, large at creases."""
    return _measure_heights(solution)[3]


def _measure_heights(solution: ContactSolution) -> tuple[float, float, float, float]:
    """Return resolution, rim ratio, lay ratio and kurtosis of the second differences."""
    healed = heal(solution)
    return healed._keep("ratios of curvatures", lambda: _find_ratios(healed))


def _find_ratios(solution: ContactSolution) -> tuple[float, float, float, float]:
    whole = solution.parts
    chosen = whole.sample(np.flatnonzero(whole.own(solution.contact)), _SAMPLE_CELLS)
    if whole.total(chosen.size) == 0:
        return 0.0, 0.0, 1.0, 0.0
    *lines, rising, falling = _gather_lines(solution, chosen, 2, 4)
    bends = [pairs[0] - 2.0 * here for here, pairs in lines]
    fourth = sum(whole.mean((pairs[1] - 4.0 * pairs[0] + 6.0 * here) ** 2) for here, pairs in lines)
    second = sum(whole.mean(bend**2) for bend in bends)
    dx, dy = solution.grid.spacing
    mixed = 0.25 * (rising[1][0] - falling[1][0])
    xx = bends[0] / dx**2
    xy = mixed / (dx * dy)
    yy = bends[1] / dy**2
    laplacian = xx + yy
    inside = _find_inner(solution, chosen)
    inner, outer = whole.total(np.array([np.count_nonzero(inside), np.count_nonzero(~inside)]))
    middle = abs(whole.mean(laplacian[inside])) if inner else 0.0
    rim = whole.mean(laplacian[~inside]) / middle if middle > 0.0 and outer else 0.0
    ratio = 0.0
    kurtosis = 0.0
    if second > 0.0:
        ratio = math.sqrt(fourth / second)
        # In units of the mean square, so that no height leaves the range of float64.
        kurtosis = 2.0 * sum(whole.mean((bend / math.sqrt(second)) ** 4) for bend in bends)
    return ratio, rim, _find_lay(whole, xx, xy, yy), kurtosis


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
    inner = np.logical_and.reduce([contact[near.at(*step)] for step in ((1, 0), (-1, 0), (0, 1), (0, -1))])
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
    around = np.stack([near.at(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1)], axis=1)
    return around.ravel(), np.repeat(solution.patches.labels.ravel()[chosen], 9)


def _find_hessian(solution: ContactSolution, chosen: IntArray) -> tuple[Array, Array, Array]:
    """Return the xx, yy and xy derivatives of the initial gap at cells, 1/m."""
    dx, dy = solution.grid.spacing
    along_x, along_y, rising, falling = (
        _SECOND_DIFFERENCE[0] * here
        + sum(factor * pair for factor, pair in zip(_SECOND_DIFFERENCE[1:], pairs, strict=True))
        for here, pairs in _gather_lines(solution, chosen, _DIFFERENCE_REACH, 4)
    )
    # Second differences along both diagonals differ by four mixed ones.
    return along_x / dx**2, along_y / dy**2, (rising - falling) / (4.0 * dx * dy)


def _gather_lines(
    solution: ContactSolution, chosen: IntArray, reach: int, lines: int
) -> list[tuple[Array, list[Array]]]:
    """Return the gap at cells, with the sums of both neighbours at each distance, along x, y and both diagonals.

    `lines` is the number of these lines.
    """
    near = Neighbourhood.inside(solution, chosen, reach)
    heights = solution.initial_gap.ravel()
    here = heights.take(near.at(0, 0))
    steps = range(1, reach + 1)
    return [
        (here, [heights.take(near.at(k * a, k * b)) + heights.take(near.at(-k * a, -k * b)) for k in steps])
        for a, b in ((1, 0), (0, 1), (1, 1), (1, -1))[:lines]
    ]
