"""Patches of a contact, and the coarse field between them."""

from __future__ import annotations

from typing import Literal

import attrs
import numpy as np

from roughcontact.certificate import certified
from roughcontact.checks import Array, Mask
from roughcontact.convolvers import DCFFT
from roughcontact.grid import Boundary, Grid
from roughcontact.kernels import BoundKernel
from roughcontact.loads import task_of
from roughcontact.problem import ContactProblem
from roughcontact.solution import ContactSolution

# Room around a contact, in coarse cells.
_ROOM = 2
# Coarse cells beyond a patch from which what lies outside is interpolated.
_BEYOND = 3


@attrs.frozen
class Box:
    """A rectangle of coarse cells."""

    rows: tuple[int, int]
    columns: tuple[int, int]

    @property
    def shape(self) -> tuple[int, int]:
        """Its cells along each axis."""
        return self.rows[1] - self.rows[0], self.columns[1] - self.columns[0]

    @property
    def cells(self) -> int:
        """Number of its cells."""
        return self.shape[0] * self.shape[1]

    def cut(self, field: Array, factor: int = 1) -> Array:
        """Return its part of a field of the domain that has `factor` times as many cells a side."""
        (first, last), (left, right) = self.rows, self.columns
        return field[factor * first : factor * last, factor * left : factor * right]


class Field:
    """The coarse grid: its pressure, and what that does everywhere.

    Parameters
    ----------
    problem, finer
        The problem on the coarse and on the fine grid.
    coarse
        The solution on the coarse grid.
    factor
        Fine cells in a coarse one, along each axis.
    """

    def __init__(self, problem: ContactProblem, finer: ContactProblem, coarse: ContactSolution, factor: int) -> None:
        self.problem, self.factor = problem, factor
        plan = problem.plan
        self._unit = plan.grid.spacing[0] / plan.modulus
        # Each grid has a summit of its own; approaches count from the fine one's first touch.
        self.undeformed = finer.undeformed
        self.approach = coarse.approach + finer.summit - problem.summit
        self.pressure: Array = np.array(coarse.pressure)

    @property
    def displacement(self) -> Array:
        """Displacement that the coarse pressure causes, on the coarse grid, m."""
        return self.problem.convolution.apply(self.pressure) * self._unit

    def touching(self, approach: float) -> Mask:
        """Mark the coarse cells in contact and those in which a fine cell would be."""
        gap = self.undeformed + interpolated(self.displacement, self.factor, self.problem.boundary) - approach
        nx, ny = self.problem.plan.grid.shape
        lowest = gap.reshape(nx, self.factor, ny, self.factor).min(axis=(1, 3))
        return np.asarray((lowest < 0.0) | (self.pressure > 0.0))

    def covers(self, boxes: list[Box], approach: float) -> bool:
        """Tell whether nothing outside the boxes touches."""
        touching = self.touching(approach)
        for box in boxes:
            touching[slice(*box.rows), slice(*box.columns)] = False
        return not touching.any()

    def gathered(self, patches: list[Patch]) -> Array:
        """Return the patches' pressure, averaged over coarse cells."""
        field = np.zeros_like(self.pressure)
        for patch in patches:
            field[slice(*patch.box.rows), slice(*patch.box.columns)] = patch.averaged
        return field


class Patch:
    """A box on the fine grid.

    Parameters
    ----------
    field
        The coarse grid.
    box
        The coarse cells of the patch.
    """

    def __init__(self, field: Field, box: Box) -> None:
        self._field, self.box = field, box
        plan, factor = field.problem.plan, field.factor
        self._heights = box.cut(field.undeformed, factor)
        spacing = [step / factor for step in plan.grid.spacing]
        grid = Grid(self._heights.shape, tuple(n * d for n, d in zip(self._heights.shape, spacing, strict=True)))
        convolver = DCFFT()
        self._plan = attrs.evolve(plan, grid=grid, boundary=Boundary.FREE, convolver=convolver)
        self._convolution = convolver.plan(
            BoundKernel(plan.kernel, 1.0 / plan.modulus, spacing[0] / plan.modulus), grid, Boundary.FREE
        )
        # The coarse cells around it, as far as its own pressure is to be taken out of the coarse field.
        frame = Grid(
            tuple(n + 2 * _BEYOND for n in box.shape),
            tuple((n + 2 * _BEYOND) * d for n, d in zip(box.shape, plan.grid.spacing, strict=True)),
        )
        self._own = convolver.plan(
            BoundKernel(plan.kernel, 1.0 / plan.modulus, plan.grid.spacing[0] / plan.modulus), frame, Boundary.FREE
        )
        self._unit = plan.grid.spacing[0] / plan.modulus
        self._pressure: Array = np.zeros(self._heights.shape)

    @property
    def averaged(self) -> Array:
        """Its pressure averaged over coarse cells, shape `box.shape`, Pa."""
        (nx, ny), factor = self.box.shape, self._field.factor
        return np.asarray(self._pressure.reshape(nx, factor, ny, factor).mean(axis=(1, 3)))

    def solved(self, approach: float, displacement: Array) -> ContactSolution | None:
        """Solve it beside the others' pressure at a approach of u + h in the contact; None if it does not touch."""
        undeformed = self._heights + self._outside(displacement)
        lowest = float(undeformed.min())
        if approach <= lowest:
            self._pressure = np.zeros(self._heights.shape)
            return None
        undeformed = undeformed - lowest
        plan = attrs.evolve(self._plan, undeformed=undeformed, relief=float(undeformed.max()))
        start = self._pressure if self._pressure.any() else None
        task = task_of(plan, undeformed, approach=approach - lowest, start=start)
        outcome = plan.solver.solve(self._convolution, task)
        solution = certified(plan, self._convolution, undeformed, task, outcome, seconds=0.0)
        self._pressure = np.array(solution.pressure)
        return solution

    def _outside(self, displacement: Array) -> Array:
        """Return the displacement that all other pressure causes on the fine cells, m."""
        own = np.zeros(self._own.scene.grid.shape)
        own[_BEYOND:-_BEYOND, _BEYOND:-_BEYOND] = self.box.cut(self._field.pressure)
        (first, last), (left, right) = self.box.rows, self.box.columns
        rows, columns = np.arange(first - _BEYOND, last + _BEYOND), np.arange(left - _BEYOND, right + _BEYOND)
        nx, ny = displacement.shape
        whole = displacement[np.ix_(rows % nx, columns % ny)]
        outside = whole - self._own.apply(own) * self._unit
        fine = interpolated(outside, self._field.factor, Boundary.FREE)
        cut = self._field.factor * _BEYOND
        return fine[cut:-cut, cut:-cut]


def interpolated(values: Array, factor: int, boundary: Boundary) -> Array:
    """Return the values of a cubic spline at the centres of `factor` times as many cells a side."""
    from scipy import ndimage

    mode: Literal["nearest", "grid-wrap"] = "nearest" if boundary is Boundary.FREE else "grid-wrap"
    at = [(np.arange(n * factor) + 0.5) / factor - 0.5 for n in values.shape]
    return np.asarray(ndimage.map_coordinates(values, np.array(np.meshgrid(*at, indexing="ij")), order=3, mode=mode))


def boxes_around(touching: Mask, boundary: Boundary) -> list[Box] | None:
    """Return boxes around the marked cells with room to each side; None if one comes too near to a border."""
    from scipy import ndimage

    around = ndimage.binary_dilation(touching, structure=np.ones((3, 3), dtype=bool), iterations=_ROOM)
    while True:
        numbers, _ = ndimage.label(around, structure=np.ones((3, 3), dtype=bool))
        found = ndimage.find_objects(numbers)
        filled = np.zeros_like(around)
        for rows, columns in found:
            filled[rows, columns] = True
        if np.array_equal(filled, around):
            break
        around = filled
    margin = _BEYOND if boundary is Boundary.FREE else 1
    boxes = [Box((rows.start, rows.stop), (columns.start, columns.stop)) for rows, columns in found]
    nx, ny = touching.shape
    inside = all(
        box.rows[0] >= margin
        and box.rows[1] <= nx - margin
        and box.columns[0] >= margin
        and box.columns[1] <= ny - margin
        for box in boxes
    )
    return boxes if inside else None
