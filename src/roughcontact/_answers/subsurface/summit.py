"""The maximum of a stress under a summit whose contact has a few cells, by Hertz's pressure on its ellipse."""

from __future__ import annotations

import math
from functools import lru_cache

import attrs
import numpy as np

from roughcontact._answers.areas.hertz import hertz_areas
from roughcontact._answers.subsurface.field import Measure
from roughcontact._answers.subsurface.maximum import (
    MIN_RELATIVE_ERROR,
    StressMaximum,
    drop_warnings_of_cells,
    is_near_surface,
    warn_of_depth,
)
from roughcontact._base.arrays import Array, read_only
from roughcontact._parts.kernels import HalfSpaceStress
from roughcontact._solve.solution import ContactSolution

# Cells of a semi-axis on which Hertz's pressure is uniform, and depths over the smaller semi-axis: the maxima lie at
# 0.38 to 0.79 of it for all ellipses and Poisson's ratios.
_CELLS = 48
_DEPTHS = np.geomspace(0.25, 1.0, 40)
# Largest difference from the maximum of the cells, in its standard deviations.
_MAX_DIFFERENCE = 3.0


def judge_by_summit(found: StressMaximum, solution: ContactSolution, poisson: float, measure: Measure) -> StressMaximum:
    """Return the maximum under the summit above it, if that is known better than what the cells give.

    Its uncertainty is that of the maximum pressure, and by how much an ellipsoid of the same load differs from it.

    Parameters
    ----------
    found
        The maximum by the cells.
    solution
        The contact.
    poisson
        Poisson's ratio of the half-space.
    measure
        Returns the measure of stress components, shape (6, ...).
    """
    if not is_near_surface(found, solution):
        return found
    patches = solution.patches
    label = _find_label(found, solution)
    if label == 0:
        return found
    summits = hertz_areas(solution)
    if not np.isfinite(summits.error[label]) or summits.tip[label] >= found.uncertainty / found.value:
        return found
    mean = patches.forces[label - 1] * summits.correction.factor[label - 1] / summits.area[label]
    peak = solution.peak_pressure(uncertainty="model")
    ratio = float(summits.summits.axes_ratio[label - 1])
    stress = measure(_find_under_ellipse(ratio, poisson))[:, 0]
    place = int(np.argmax(stress))
    value = peak.value * float(stress[place])
    uneven = 1.5 * mean / peak.value - 1.0
    std = value * math.hypot(peak.uncertainty / peak.value, uneven, MIN_RELATIVE_ERROR)
    if std >= found.uncertainty or abs(value - found.value) > _MAX_DIFFERENCE * found.uncertainty:
        return found
    depth = float(summits.summits.semi_axis[label - 1]) / ratio * float(_DEPTHS[place])
    under = attrs.evolve(drop_warnings_of_cells(found), value=value, uncertainty=std, depth=depth)
    return warn_of_depth(under, solution)


def _find_label(found: StressMaximum, solution: ContactSolution) -> int:
    """Return the number of the patch above a maximum; zero if it is not below one."""
    grid = solution.grid
    first = float(grid.x[0, 0]), float(grid.y[0, 0])
    steps = zip((found.x, found.y), first, grid.spacing, grid.shape, strict=True)
    i, j = (round((at - start) / step) % n for at, start, step, n in steps)
    return int(solution.patches.labels[i, j])


@lru_cache(maxsize=64)
def _find_under_ellipse(ratio: float, poisson: float) -> Array:
    """Return the stress below the centre of Hertz's ellipse over its maximum pressure, shape (6, depths, 1)."""
    spacing = (ratio / (_CELLS - 0.5), 1.0 / (_CELLS - 0.5))
    part = np.arange(_CELLS) / (_CELLS - 0.5)
    pressure = np.sqrt(np.maximum(1.0 - part[:, np.newaxis] ** 2 - part**2, 0.0))
    # A quarter stands for all: but for the first, rows and columns count twice.
    twice = np.where(part > 0.0, 2.0, 1.0)
    load = pressure * np.outer(twice, twice)
    kernel = HalfSpaceStress(poisson)
    stress = np.zeros((6, _DEPTHS.size, 1))
    for number, depth in enumerate(_DEPTHS):
        field = kernel.stress_coefficients("z", load.shape, spacing, float(depth))
        # The shear of opposite quarters cancels.
        stress[:3, number, 0] = np.sum(field[:3] * load, axis=(1, 2))
    return read_only(stress)
