"""How much the approach is too small with uniform pressure on each cell, and too large where the contact is cut."""

from __future__ import annotations

import math
from weakref import WeakKeyDictionary

import attrs
import numpy as np

from roughcontact._answers.areas import quantity_calibration as calibration
from roughcontact._answers.areas.cells import find_cut_cells, find_straight_rows
from roughcontact._answers.areas.curvature import (
    average_differences,
    curvature_resolution,
    find_filled,
    is_linear,
    lay_ratio,
    rim_ratio,
)
from roughcontact._answers.areas.edges import STRAIGHT, is_diagonal
from roughcontact._base.checks import Array
from roughcontact._parts.grid import Boundary
from roughcontact._solve.solution import ContactSolution, heal

# What was measured on solutions that still exist: approach and mean gap both ask for it.
_MEASURED: WeakKeyDictionary[ContactSolution, Bend] = WeakKeyDictionary()


@attrs.frozen(eq=False)
class Bend:
    """The curvature of the heights under a contact, and what of them the cells do not show.

    Attributes
    ----------
    load
        Part of the load on each patch, shape (count,).
    spread
        Standard deviation of the curvature of each over its mean, shape (count,).
    mean
        Half the second differences under the contact along x and y together, weighted by the pressure, m.
    width
        Fourth root of the cells of a patch, weighted by the load.
    saturated, filled
        Parts of the load on saturated cells and on those that were filled from their neighbours.
    resolution
        Resolution ratio of `curvature_resolution`.
    rim
        How sharp the rims of flats are that were run in, times the width, 0 without them.
    linear
        Whether the heights are linear between points further apart than the cells.
    """

    load: Array
    spread: Array
    mean: float
    width: float
    saturated: float
    filled: float
    resolution: float
    rim: float
    linear: bool


def measure_bend(solution: ContactSolution) -> Bend:
    """Return the curvature of the heights under the contact of a solution that has one."""
    solution = heal(solution)
    if solution in _MEASURED:
        return _MEASURED[solution]
    patches = solution.patches
    touching = np.flatnonzero(solution.contact)
    _, _, spread, bends = (part[1:] for part in average_differences(solution, touching))
    load = patches.forces / patches.forces.sum()
    pressure = solution.pressure.ravel()[touching] / np.sum(solution.pressure)
    resolution = curvature_resolution(solution)
    width = float(np.sum(load * np.sqrt(np.sqrt(patches.cells))))
    _MEASURED[solution] = Bend(
        load=load,
        spread=spread,
        mean=float(np.sum(load * np.maximum(bends, 0.0))),
        width=width,
        saturated=float(np.sum(pressure, where=solution.saturated.ravel()[touching])),
        filled=float(np.sum(pressure, where=find_filled(solution, touching))),
        resolution=resolution,
        rim=min(resolution, 1.0) * width * _ramp(rim_ratio(solution), calibration.RIM),
        linear=is_linear(solution, touching),
    )
    return _MEASURED[solution]


def find_shift(solution: ContactSolution) -> tuple[float, float]:
    """Return how much the approach is too small, and the standard deviation of that, m."""
    solution = heal(solution)
    if solution.patches.count == 0:
        return 0.0, 0.0
    bend = measure_bend(solution)
    cells = np.maximum(solution.patches.cells, 1)
    held = cells / (cells + calibration.SHIFTED_CELLS)
    shift = calibration.SHIFT_OF_GAP * solution.edge_shift * float(np.sum(bend.load * held))
    kinked = 0.0
    kinked_std = 0.0
    if bend.linear:
        kinked, kinked_std = calibration.LINEAR_GAP
    filled, filled_std = calibration.FILLED_GAP
    rim, rim_std = calibration.RIM_GAP
    # Uniform pressure is exact where cells are saturated.
    elastic = 1.0 - bend.saturated
    shift = (shift + kinked + filled * bend.filled + rim * bend.rim) * elastic
    unsure = (
        _find_spread(bend, cells),
        _find_aligned(solution),
        kinked_std,
        filled_std * math.sqrt(bend.filled),
        rim_std * bend.rim * elastic,
    )
    # The shift fades with the open part of a periodic domain.
    open_part = 1.0 if solution.boundary is Boundary.FREE else 1.0 - float(np.mean(solution.contact))
    fading = min(1.0, calibration.FADING_GAP * open_part)
    std = max(fading, calibration.SMALLEST_FADING) * math.hypot(*unsure)
    return fading * shift * bend.mean, std * bend.mean


def _find_aligned(solution: ContactSolution) -> float:
    """Return the error of the shift where the edge is straight, so that its cells err alike, over the bend, no unit."""
    rows = find_straight_rows(solution.contact, solution.boundary)
    # On average, for a slender ellipse has some long ones too.
    long = rows.size > 0 and float(np.mean(rows)) > 0.5 * min(solution.grid.shape)
    if long:
        return calibration.ALIGNED_GAP
    lay = lay_ratio(solution)
    return calibration.OBLIQUE_GAP if lay < STRAIGHT and is_diagonal(solution, lay) else 0.0


def _find_spread(bend: Bend, cells: Array) -> float:
    """Return the standard deviation of the shift of smooth heights over their second difference, no unit."""
    # Alike patches err alike; others average out.
    alike = min(1.0, float(np.sum(bend.load * bend.spread)) ** 2)
    number = 1.0 + (1.0 / float(np.sum(bend.load**2)) - 1.0) * alike
    few = calibration.SMALL_PATCH_GAP * float(np.sum(bend.load / np.sqrt(cells)))
    ratio = min(bend.resolution, 1.0)
    own = (calibration.GAP_ERROR + few * (1.0 + ratio)) / math.sqrt(number)
    edge = calibration.SATURATED_GAP * bend.saturated**2 * bend.width / number
    return math.hypot(calibration.COMMON_GAP, own, edge, calibration.UNRESOLVED_GAP * ratio)


def find_hidden_rise(solution: ContactSolution) -> float:
    """Return the standard deviation of the height of the highest summit where the cells do not show it, m."""
    solution = heal(solution)
    if solution.patches.count == 0:
        return 0.0
    bend = measure_bend(solution)
    lost, rims, filled = calibration.HIDDEN_RISE
    unresolved = lost * _ramp(bend.resolution, calibration.UNRESOLVED)
    return math.hypot(unresolved, rims * bend.rim, filled * math.sqrt(bend.filled)) * bend.mean


def _ramp(value: float, ends: tuple[float, float]) -> float:
    """Return how far a value lies from the first end to the second, from 0 to 1."""
    return min(max((value - ends[0]) / (ends[1] - ends[0]), 0.0), 1.0)


def find_cut_shift(solution: ContactSolution) -> tuple[float, float]:
    """Return how much the approach is too large where the contact is cut, and the standard deviation of that, m.

    There the pressure rises as the inverse root of the distance, which uniform pressure on each cell does not follow:
    what it lacks in energy is a part of p^2 / E* over the cells at the cut.
    """
    missing = solution.non_measured
    free = solution.boundary is Boundary.FREE
    if solution.force == 0.0 or (missing is None and not free):
        return 0.0, 0.0
    cut = find_cut_cells(solution)
    beside = None if missing is None else np.nonzero(missing)
    border = 0.0
    holes = 0.0
    for axis, step in enumerate(solution.grid.spacing):
        weight = step * solution.grid.cell_area
        pressure = np.moveaxis(solution.pressure, axis, 0)
        elastic = np.moveaxis(~solution.saturated, axis, 0)
        if free:
            ends = np.moveaxis(cut, axis, 0)[[0, -1]] & elastic[[0, -1]]
            border += weight * float(np.sum(pressure[[0, -1]] ** 2, where=ends))
        if beside is not None:
            for neighbour in (beside[axis] - 1, beside[axis] + 1):
                row = np.clip(neighbour, 0, len(pressure) - 1) if free else neighbour % len(pressure)
                at = row, beside[1 - axis]
                holes += weight * float(np.sum(pressure[at] ** 2, where=elastic[at]))
    energies = np.array((border, holes))
    modulus = float(solution.effective_modulus(1.0 / math.sqrt(solution.grid.cell_area)))
    shift, std = np.transpose((calibration.CUT_BORDER, calibration.CUT_HOLES)) @ energies / (modulus * solution.force)
    return float(shift), float(std)
