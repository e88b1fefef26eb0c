"""An adhesive contact as a problem of its gap, in the units of `Task`.

`gap_descent` makes it, holds and scales its gaps, and `descent` minimises it. A gap here has the shape (mx, my) of the
extended grid, that of a task the shape (nx, ny) of the grid.
"""

from __future__ import annotations

from functools import cached_property

import attrs
import numpy as np

from roughcontact._base.arrays import Array
from roughcontact._parts.interactions import BoundInteraction
from roughcontact._solve.solvers.adhesive.stiffness import SurfaceStiffness
from roughcontact._solve.solvers.base import Task


@attrs.frozen(eq=False, kw_only=True)
class GapProblem:
    """What a descent minimises, on the extended grid of a stiffness.

    Attributes
    ----------
    stiffness
        The stiffness of the surface.
    interaction
        The attraction; None without adhesion.
    closing
        Gap less displacement, shape (mx, my): the initial gap in the domain, zero outside.
    base
        Uniform pressure to which that of the gap is added: the mean pressure on the extended grid, or that of a given
        approach.
    mean_stiffness
        Stiffness of the mean displacement: zero unless an approach is given on a boundary that is not periodic.
    holds_mean
        Whether the mean gap is held: an approach is given on a periodic boundary.
    limit
        Pressure limit, of one entry or shape (nx, ny).
    """

    stiffness: SurfaceStiffness
    interaction: BoundInteraction | None
    closing: Array
    base: float
    mean_stiffness: float
    holds_mean: bool
    limit: Array

    @cached_property
    def capped(self) -> bool:
        """Whether the pressure of any cell is limited."""
        return bool(np.isfinite(self.limit).any())


def make_gap_problem(stiffness: SurfaceStiffness, task: Task) -> GapProblem:
    """Return what a descent minimises for a task."""
    approach = task.approach
    compliance = stiffness.mean_compliance
    nx, ny = stiffness.shape
    mx, my = stiffness.extended
    base = 0.0
    if task.mean_pressure is not None:
        base = task.mean_pressure * ((nx * ny) / (mx * my))
    elif approach is not None and compliance > 0.0:
        base = approach / compliance
    return GapProblem(
        stiffness=stiffness,
        interaction=task.interaction,
        closing=stiffness.embed(task.initial_gap),
        base=base,
        mean_stiffness=0.0 if approach is None else stiffness.mean_stiffness,
        holds_mean=approach is not None and compliance == 0.0,
        limit=task.pressure_limit,
    )


def hold_mean(problem: GapProblem, task: Task, gap: Array) -> Array:
    """Return a gap, changed in place, whose open cells are scaled to the mean gap of the task, where it is held."""
    if not problem.holds_mean or task.approach is None:
        return gap
    needed = float(task.initial_gap.mean() - task.approach) * gap.size
    opened = np.maximum(gap, 0.0)
    total = float(opened.sum())
    flattened = float(gap.sum()) - total
    if needed - flattened > 0.0 and total > 0.0:
        np.multiply(gap, (needed - flattened) / total, out=gap, where=gap > 0.0)
    else:
        gap += needed / gap.size - float(gap.mean())
    return gap


def gap_scale(task: Task, gap: Array, problem: GapProblem) -> float:
    """Return the smaller of the standard deviation of the initial gap and, in contact, the range of the displacement.

    Surfaces that do not touch may hardly deform.
    """
    rms = float(task.initial_gap.std()) if task.rms_gap is None else task.rms_gap
    inside = problem.stiffness.inner(gap)
    displacement = inside - task.initial_gap
    moved = float(displacement.max() - displacement.min())
    if inside.min() > 0.0 and rms > 0.0:
        return rms
    return min(rms, moved) or max(rms, moved) or 1.0
