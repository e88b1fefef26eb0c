"""An independent judge of solutions: plain sums over all cells in extended precision.

It uses no convolver, no solver and not the library's own measure of the contact conditions.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from roughcontact._base.checks import Mask, RealArray
from roughcontact._parts.grid import Boundary
from roughcontact._parts.kernels import BoundKernel
from roughcontact._parts.load import Load
from roughcontact._solve.problem import LOAD_TOLERANCE, ContactProblem
from roughcontact._solve.solution import ContactSolution

LongArray: TypeAlias = npt.NDArray[np.longdouble]
# Rounding of fields computed in float64, in units of the last place of their maximum; measured on random problems.
_PLACES = 64.0
# The error, over the scale, that the documentation allows a solution which has converged to rounding.
_UNRESOLVED = 1e-5
# Range of the displacement, over the maximum pressure, below which the pressure is uniform up to rounding.
_UNIFORM = 1e-12


@attrs.frozen
class Judgement:
    """How far a solution is from satisfying the contact conditions.

    Attributes
    ----------
    complementarity, penetration
        As in `Residuals`, over the same scale.
    load
        Relative error of the load; zero where the approach was given.
    bounded
        Whether 0 <= p <= pressure limit, to the last bit.
    bound
        The error that the solver's tolerance, its status and rounding allow.
    """

    complementarity: float
    penetration: float
    load: float
    bounded: bool
    bound: float

    @property
    def error(self) -> float:
        """The maximum of complementarity and penetration."""
        return max(self.complementarity, self.penetration)

    @property
    def holds(self) -> bool:
        """Whether the solution is as good as its status says."""
        return self.bounded and self.load <= LOAD_TOLERANCE and self.error <= self.bound


def displace(responses: RealArray, pressure: RealArray, boundary: Boundary) -> RealArray:
    """Return the displacement by plain sums over all cells.

    Parameters
    ----------
    responses
        Displacement by unit pressure at each offset, shape (nx, ny).
    pressure
        Pressure, shape (nx, ny).
    boundary
        Free: absolute offsets; otherwise those of the nearest image.
    """
    i, j = (np.abs(np.arange(n)[:, np.newaxis] - np.arange(n)) for n in pressure.shape)
    if boundary is not Boundary.FREE:
        i, j = (np.minimum(offsets, len(offsets) - offsets) for offsets in (i, j))
    rows = responses[:, j]
    return np.array([np.einsum("ajk,ak->j", rows[offsets], pressure) for offsets in i])


def judge(
    problem: ContactProblem,
    load: Mapping[str, float],
    solution: ContactSolution,
    responses: RealArray | None = None,
) -> Judgement:
    """Return how far the pressure of a solution is from satisfying the contact conditions.

    Parameters
    ----------
    problem
        The problem, without non-measured points. The work is the square of the number of cells.
    load
        The load by the name of its argument, as in ``solution.origin.load``.
    solution
        Its pressure and its status are used, nothing else.
    responses
        Displacement by unit pressure at each offset, shape (nx, ny), m/Pa; by default from the kernel.
    """
    plan = problem.plan
    if responses is None:
        responses = BoundKernel(plan.kernel, 1.0 / plan.modulus).responses(plan.grid, problem.boundary)
    heights = problem.body.heights(plan.grid) + problem.counterbody.heights(plan.grid)
    initial_gap = (heights.max() - heights).astype(np.longdouble)
    pressure = solution.pressure.astype(np.longdouble)
    saturated = pressure >= plan.pressure_limit
    displacement = displace(responses, pressure, problem.boundary)
    level = displacement + initial_gap
    datum = _datum(level, pressure, saturated)
    off = 0.0
    given = Load.of(**load)
    if given.kind == "approach":
        datum = np.longdouble(given.value)
    else:
        area = plan.grid.area if given.kind == "force" else 1.0
        off = abs(float(pressure.mean() * area / np.longdouble(given.value)) - 1.0)
    gap = level - datum
    rms = float(np.std(initial_gap))
    bend = float(np.ptp(displacement))
    bend = bend if bend > _UNIFORM * float(pressure.max()) * plan.grid.spacing[0] / plan.modulus else 0.0
    scale = min(rms, bend) or max(rms, bend)
    wrong = np.where(saturated, np.maximum(gap, 0.0), np.abs(gap))
    largest = float(np.abs(displacement).max() + initial_gap.max() + abs(datum))
    margin = 2.0 * plan.solver.tolerance + _PLACES * float(np.finfo(np.float64).eps) * largest / scale
    rounded = "rounding" in str(solution.status)
    return Judgement(
        complementarity=float(np.sum(pressure * wrong) / pressure.sum()) / scale if pressure.any() else 0.0,
        penetration=max(0.0, -float(gap[~saturated].min(initial=np.inf))) / scale,
        load=off,
        bounded=bool((pressure >= 0.0).all() and (pressure <= plan.pressure_limit).all()),
        bound=2.0 * _UNRESOLVED if rounded else min(margin, 2.0 * _UNRESOLVED),
    )


def _datum(level: LongArray, pressure: LongArray, saturated: Mask) -> np.longdouble:
    """Return the mean level of the cells in elastic contact, or a level that separates open from saturated cells."""
    elastic = np.where(saturated, 0.0, pressure)
    if elastic.any():
        return np.longdouble(np.sum(elastic * level) / elastic.sum())
    lower = level[saturated].max(initial=level.min())
    upper = level[pressure <= 0.0].min(initial=np.inf)
    return np.longdouble(min(lower, upper))
