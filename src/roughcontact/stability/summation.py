"""Displacements by plain sums, without a transform: an independent way to what the convolver gave."""

from __future__ import annotations

import math

import attrs
import numpy as np

from roughcontact.checks import Array, IntArray
from roughcontact.grid import Boundary
from roughcontact.kernels import BoundKernel
from roughcontact.kernels.offsets import responses
from roughcontact.problem import ContactProblem
from roughcontact.solution import ContactSolution


def displacement_at(problem: ContactProblem, pressure: Array, chosen: IntArray) -> Array:
    """Return the displacement at the cells of flat index `chosen`, m."""
    kernel = BoundKernel(problem.plan.kernel, compliance=1.0 / problem.plan.modulus)
    table = responses(kernel, problem.plan.grid, problem.boundary)
    sums = []
    for cell in zip(*np.divmod(chosen, pressure.shape[1]), strict=True):
        i, j = (np.abs(np.arange(n) - here) for n, here in zip(pressure.shape, cell, strict=True))
        if problem.boundary is Boundary.WRAPPED:
            i, j = (np.minimum(offsets, offsets.size - offsets) for offsets in (i, j))
        sums.append(float(np.einsum("ij,ij->", table[np.ix_(i, j)], pressure)))
    return np.array(sums)


@attrs.frozen
class Recomputed:
    """What plain sums find of a solution's promises.

    Attributes
    ----------
    gap
        Greatest overlap outside the saturated cells or weighted mean gap in contact, over the scale.
    load
        Relative error of the load; nan where the approach was given.
    """

    gap: float
    load: float


def recomputed(problem: ContactProblem, solution: ContactSolution, mean: float) -> Recomputed:
    """Return what a solution for a given mean pressure, Pa, looks like by plain sums."""
    pressure = solution.pressure.ravel()
    level = displacement_at(problem, solution.pressure, np.arange(pressure.size)) + solution.undeformed.ravel()
    full = solution.saturated.ravel()
    bearing = np.where(full, 0.0, pressure)
    # Where all that carries is saturated, any level between the open and the saturated cells will do.
    datum = float(bearing @ level) / float(bearing.sum()) if bearing.any() else float(level[full].max())
    if not bearing.any() and not full.all():
        datum = min(datum, float(level[pressure == 0.0].min()))
    gap = (level - datum) / solution.residuals.scale
    opened = float(pressure @ np.where(full, np.maximum(gap, 0.0), np.abs(gap))) / float(pressure.sum())
    closed = max(0.0, -float(gap[~full].min(initial=math.inf)))
    return Recomputed(max(opened, closed), abs(math.fsum(pressure) / pressure.size / mean - 1.0))
