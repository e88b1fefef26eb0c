r"""Gaps at non-measured points, from the gaps of their neighbours.

Near the contact the gap between the points that were measured is continued by the surface of minimum bending,

.. math:: \min \sum g_{xx}^2 + 2 g_{xy}^2 + g_{yy}^2,

with differences between neighbouring cells, and further away by the harmonic surface, which never exceeds its
surroundings. A point whose gap is then open under the load counts as measured.

References
----------
Duchon, Splines minimizing rotation-invariant semi-norms in Sobolev spaces (1977), https://doi.org/10.1007/BFb0086566
"""

from __future__ import annotations

import math
from typing import Any, TypeVar

import attrs
import numpy as np

from roughcontact._base.arrays import Array, IntArray, Mask
from roughcontact._parts.grid import Boundary, Grid, extend, grow
from roughcontact._parts.surfaces import MAX_BANDWIDTH, fill, polynomial, solve_in_bands
from roughcontact._solve.solution.fields import ContactFields
from roughcontact.errors import InputError

S = TypeVar("S", bound=ContactFields)
# Cells from the contact within which its edge, ellipses and curvature depend on the gap, and from a measured point
# within which the surface of minimum bending is better than the harmonic one.
_BENDING_RANGE = 6
# Weight of the harmonic surface in the minimum of bending, which two rows of points do not determine.
_HARMONIC_WEIGHT = 1e-9
# Standard deviation of the mean gap in a hole, over the difference of both surfaces; set on rough contacts and balls.
_MEAN_GAP_STD = 0.5
# Standard deviation of the gap far from measured points over that of the measured gap; set on balls, cylinders and
# rough contacts with margins and blobs.
_DEEP_SCATTER = 2.0
# Standard deviation of the mean gap, because the measured points carry what the others would have carried, over the
# fraction of that load: part of the mean gap, or of the approach where that is less, as for a ball. Set on rough
# contacts and rough balls with blobs and margins.
_LOST_LOAD_STD = (0.25, 0.67)
# Minimum overlap of a touching point, over p h / E* around it: 1.1 for one cell in a uniform pressure (exact).
_TOUCHING_OVERLAP = 0.3
# Steps to the cells around one.
_NEIGHBOUR_STEPS = np.mgrid[-1:2, -1:2].reshape(2, 9)
# Second differences along x and y, and the mixed one: steps along both axes, and weights.
_SECOND_DIFFERENCES = (
    ((-1, 0, 1.0), (0, 0, -2.0), (1, 0, 1.0)),
    ((0, -1, 1.0), (0, 0, -2.0), (0, 1, 1.0)),
    ((0, 0, 1.0), (1, 0, -1.0), (0, 1, -1.0), (1, 1, 1.0)),
)
# Name in `ContactFields._found` of the points of a healed solution that were not measured.
_NON_MEASURED = "non-measured"


def heal(solution: S) -> S:
    """Return the solution with gaps at its non-measured points; those that would touch stay non-measured.

    Pressure, displacement and certificate are those of the solution: points that were not measured carry nothing.
    """
    if solution.non_measured is None or _NON_MEASURED in solution._found:
        return solution
    missing = solution.non_measured
    return solution._keep("healed", lambda: _heal(solution, missing))


def _heal(solution: S, missing: Mask) -> S:
    harmonic = fill(np.where(missing, np.nan, solution.initial_gap))
    gap = _bend_near(harmonic, missing, solution.contact, solution)
    touching = missing & solution.contact
    touching[missing] |= _overlaps(gap, solution, missing)
    healed = solution._evolve(initial_gap=gap, non_measured=touching if touching.any() else None)
    healed._found[_NON_MEASURED] = missing
    return healed


def _overlaps(gap: Array, solution: ContactFields, missing: Mask) -> Mask:
    """Return the missing points, shape (n,), that overlap by more than the error of the initial gap found there."""
    overlap = solution.approach - gap[missing] - solution.displacement[missing]
    places = np.flatnonzero(overlap > 0.0)
    i, j = (index[places, np.newaxis] + _NEIGHBOUR_STEPS[axis] for axis, index in enumerate(np.nonzero(missing)))
    around = extend(solution.pressure, 1, solution.boundary)[i + 1, j + 1].max(axis=1)
    depth = around * math.sqrt(solution.grid.cell_area) / solution.modulus
    result = np.zeros(overlap.shape, dtype=bool)
    result[places] = overlap[places] > _TOUCHING_OVERLAP * depth
    return result


@attrs.frozen(eq=False)
class FilledGap:
    """The gap with values at all non-measured points.

    Attributes
    ----------
    values
        Gap, shape `grid.shape`, m; zero at non-measured points that would touch.
    std
        Standard deviation of each gap by non-measured points, shape `grid.shape`, m; zero at measured points.
    mean_std
        Standard deviation of the mean gap by non-measured points, m.
    """

    values: Array
    std: Array
    mean_std: float


def fill_gap(solution: ContactFields) -> FilledGap:
    """Return the gap with values at all non-measured points, and their uncertainty.

    Far from measured points nothing is known of the gap: there it is, on a free domain, the form through the measured
    gap, and all ways to continue it count.
    """
    from scipy import ndimage

    solution = heal(solution)
    missing = solution._found.get(_NON_MEASURED)
    if missing is None:
        return FilledGap(solution.gap, np.zeros(solution.grid.shape), 0.0)
    harmonic = fill(np.where(missing, np.nan, solution.gap))
    gap = _bend_near(harmonic, missing, ~missing, solution)
    holes = np.asarray(ndimage.label(missing)[0], dtype=np.intp)
    differences = np.bincount(holes[missing], weights=(gap - harmonic)[missing])
    mean_std = _MEAN_GAP_STD * float(np.linalg.norm(differences)) / missing.size
    mean_std = math.hypot(mean_std, _find_lost_load_std(solution, missing, holes, gap))
    unknown = _find_unknown_fraction(missing, solution.boundary)
    measured = gap[~missing]
    std = np.hypot(np.where(missing, _MEAN_GAP_STD * (gap - harmonic), 0.0), unknown * float(measured.std()))
    gap = np.where(missing, np.maximum(gap, 0.0), gap)
    if solution.non_measured is not None:
        gap[solution.non_measured] = 0.0
    mean_std = math.hypot(mean_std, _scatter_of_mean(gap, missing, float(unknown.sum())))
    deep = unknown == 1.0
    if not deep.any():
        return FilledGap(gap, std, mean_std)
    ways = [gap, np.where(deep, float(measured.mean()), gap)]
    if all(solution.boundary.free_axes):
        form = _continue_form(gap, missing | (solution.contact_pressure > 0.0))
        ways.insert(0, np.where(deep, form, gap))
    means = [float(np.mean(way)) for way in ways]
    mean_std = math.hypot(mean_std, max(means) - min(means))
    return FilledGap(ways[0], np.hypot(std, np.ptp(ways, axis=0)), mean_std)


def _find_unknown_fraction(missing: Mask, boundary: Boundary) -> Array:
    """Return how little the neighbours tell of the gap, shape `missing.shape`: from 0 at measured points to 1."""
    unknown = missing.astype(np.float64)
    for depth in range(_BENDING_RANGE, 0, -1):
        unknown[missing & grow(~missing, depth, boundary)] = (depth / (_BENDING_RANGE + 1)) ** 2
    return unknown


def _find_lost_load_std(solution: ContactFields, missing: Mask, holes: IntArray, gap: Array) -> float:
    """Return the standard deviation of the mean gap by the load that non-measured points would have carried, m.

    They would have carried as much as the points around their holes; around a single one the neighbours do.
    """
    if not solution.contact.any():
        return 0.0
    weight = 1.0 - 1.0 / np.sqrt(np.bincount(holes[missing]))[holes[missing]]
    fields = (solution.contact.astype(np.float64), solution.contact_pressure)
    known = [(fill(np.where(missing, np.nan, field)), float(np.sum(field, where=~missing))) for field in fields]
    lost = max(float(np.sum(weight * field[missing])) / total for field, total in known if total > 0.0)
    of_gap, of_approach = _LOST_LOAD_STD
    return lost * min(of_gap * float(np.mean(gap)), of_approach * abs(solution.approach))


def _continue_form(gap: Array, omitted: Mask) -> Array:
    """Return the form of second degree through the open gap, shape (nx, ny), m, at least zero."""
    try:
        return np.maximum(polynomial(gap, 2, omitted), 0.0)
    # Too few points of the gap are known.
    except InputError:
        return gap


def _scatter_of_mean(gap: Array, missing: Mask, count: float) -> float:
    """Return the standard deviation of the mean gap, m, because the gap scatters at `count` points."""
    measured = ~missing
    departure = np.where(measured, gap - float(gap[measured].mean()), 0.0)
    lengths = []
    for axis in (0, 1):
        spectrum = np.abs(np.fft.rfft(departure, n=2 * gap.shape[axis], axis=axis)) ** 2
        correlation = np.fft.irfft(spectrum.sum(axis=1 - axis))[: gap.shape[axis]]
        fallen = np.flatnonzero(correlation < 0.5 * correlation[0])
        lengths.append(float(fallen[0]) if fallen.size else float(gap.shape[axis]))
    independent = max(count / (4.0 * math.pi * lengths[0] * lengths[1]), 1.0)
    return _DEEP_SCATTER * count / gap.size * float(gap[measured].std()) / math.sqrt(independent)


def _bend_near(gap: Array, missing: Mask, places: Mask, solution: ContactFields) -> Array:
    """Return a gap with the surface of minimum bending at the missing points near `places`, masks of the same shape."""
    near = missing & grow(places, _BENDING_RANGE, solution.boundary)
    if not near.any():
        return gap
    result = gap.copy()
    result[near] = _minimise_bending(gap, near, solution.grid, solution.boundary)
    return result


def _minimise_bending(gap: Array, unknown: Mask, grid: Grid, boundary: Boundary) -> Array:
    """Return the gaps at the unknown points, shape (n,), m, from those elsewhere, shape (nx, ny)."""
    from scipy.sparse import csr_array
    from scipy.sparse.linalg import splu

    nx, ny = unknown.shape
    i, j = np.nonzero(unknown)
    diagonal = np.arange(i.size, dtype=np.int32)
    number = np.full(gap.size, -1, dtype=np.int32)
    number[i * ny + j] = diagonal
    right = _HARMONIC_WEIGHT * gap[unknown]
    rows = [diagonal]
    columns = [diagonal]
    values = [np.full(i.size, _HARMONIC_WEIGHT)]
    for (along, across), weights in _weigh_neighbours(i, j, grid, boundary).items():
        place = (i + along) % nx * ny + (j + across) % ny
        column = number[place]
        right -= np.where(column < 0, weights * gap.ravel()[place], 0.0)
        inside = (column >= 0) & (weights != 0.0)
        rows.append(diagonal[inside])
        columns.append(column[inside])
        values.append(np.broadcast_to(weights, i.shape)[inside])
    places = np.concatenate(rows), np.concatenate(columns)
    matrix = csr_array((np.concatenate(values), places), shape=(i.size, i.size))
    found = solve_in_bands(matrix, right, 2 * MAX_BANDWIDTH)
    if found is None:
        # Symmetric and positive definite.
        options = {"SymmetricMode": True}
        factored: Any = splu(matrix.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)
        found = factored.solve(right)
    return np.asarray(found)


def _weigh_neighbours(i: IntArray, j: IntArray, grid: Grid, boundary: Boundary) -> dict[tuple[int, int], Array]:
    """Return half the derivative of the bending with respect to the points (i, j): weights of their neighbours by step.

    Differences that cross a free border do not count.
    """
    ratio = grid.spacing[0] / grid.spacing[1]
    weights: dict[tuple[int, int], Array] = {}
    for steps, square in zip(_SECOND_DIFFERENCES, (ratio**-2, ratio**2, 2.0), strict=True):
        for along, across, factor in steps:
            own = np.asarray(square * factor)
            if boundary.has_free_axis:
                inside = np.ones(i.shape, dtype=bool)
                for axis, first in ((0, i - along), (1, j - across)):
                    if not boundary.free_axes[axis]:
                        continue
                    offsets = [step[axis] for step in steps]
                    inside &= (first + min(offsets) >= 0) & (first + max(offsets) < grid.shape[axis])
                own = np.where(inside, own, 0.0)
            for other in steps:
                step = (other[0] - along, other[1] - across)
                weights[step] = weights.get(step, 0.0) + own * other[2]
    return weights
