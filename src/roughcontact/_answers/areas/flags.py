"""Flags of a contact: what its cells show of places where the pressure is unbounded, or that no grid resolves.

At a sharp edge the pressure rises outwards as the inverse root of the distance, at a crease that points at the other
surface as the logarithm; both have no maximum. Heights as rough at the scale of the cells as at any other have details
that these cells do not show.
"""

from __future__ import annotations

import math

import attrs
import numpy as np

from roughcontact._answers.areas.cells import gather_around, split
from roughcontact._base.arrays import Array, IntArray
from roughcontact._base.units import percent
from roughcontact._parts.grid import extend
from roughcontact._solve.solution import ContactSolution, Response, responses

# Steps to the cell beyond each side, and to that across a crease: along both axes and both diagonals.
_SIDES = ((1, 0), (-1, 0), (0, 1), (0, -1))
_LINES = ((1, 0), (0, 1), (1, 1), (1, -1))
# Cells in contact in line inwards from a side, whose pressures tell whether it rises outwards.
_ROW = 4
# Pressure of the second cell from a sharp edge at most over that of the innermost of the row.
_FLATNESS = 0.9
# Gap beyond a sharp edge, times E* over the cell, over the pressure beside it, at least.
_MIN_OPENING = 0.5
# Sides of a sharp edge, and the share of the pressure beside sides that they carry, at least.
_MIN_SIDES = 3
_MIN_SHARE = 0.1
# Cells around the highest pressure, shape (2, 1, 9), and places on a line through each of them, shape (11, 1).
_AROUND = np.stack(np.meshgrid((-1, 0, 1), (-1, 0, 1), indexing="ij")).reshape(2, 1, 9)
_PLACES = np.arange(-5, 6)[:, np.newaxis]
_REACH = 6
# Second differences on the line: that at the cell, and those beside it and the next one, at most over their sum.
_MIDDLE = 4
_BESIDE = np.array((1, 2, 3, 6, 7, 8))
_MAX_BEND_BESIDE = 0.15
# Jump of the slope at a crease, times E*, over the maximum pressure, at least.
_MIN_JUMP = 0.02
# Kurtosis of the second differences (3 on Gaussian heights), and mean square of the fourth over that of the second
# differences, above which heights are rough at the scale of the cells.
_MIN_KURTOSIS = 6.0
_MIN_ROUGHNESS = 1.0


@attrs.frozen
class Flags:
    """What the cells show of places that no grid resolves.

    Attributes
    ----------
    sharp_edge
        Share of the pressure beside open cells, in contacts of at least four cells across, that stands at sharp edges,
        where it is unbounded; zero without any.
    crease
        Jump of the slope under the maximum pressure, at a crease, times the modulus E* over that pressure: the pressure
        is unbounded there; zero without one.
    rough_tail
        Whether the heights are as rough from cell to cell as over several: their curvature depends on the cell.

    Examples
    --------
    >>> import numpy as np
    >>> import roughcontact as rc
    >>> grid = rc.Grid((48, 48), 48e-6)
    >>> inside = np.hypot(grid.x, grid.y) < 10e-6
    >>> punch = rc.Body(rc.HeightMap(np.where(inside, 0.0, -5e-6), size=grid.size), rc.Elastic(210e9, 0.3))
    >>> print(rc.ContactProblem(punch).solve(force=0.1).response("flags"))
    sharp edges with 100 % of the pressure beside open cells: it is unbounded
    """

    sharp_edge: float
    crease: float
    rough_tail: bool

    @property
    def unbounded(self) -> bool:
        """Whether the pressure has no maximum: each finer grid has a higher one."""
        return self.sharp_edge > 0.0 or self.crease > 0.0

    def __bool__(self) -> bool:
        """Return whether there is any flag."""
        return self.unbounded or self.rough_tail

    def __str__(self) -> str:
        found = []
        if self.sharp_edge > 0.0:
            found.append(
                f"sharp edges with {percent(self.sharp_edge)} of the pressure beside open cells: it is unbounded"
            )
        if self.crease > 0.0:
            found.append("a crease under the maximum pressure, which is unbounded")
        if self.rough_tail:
            found.append("heights as rough from cell to cell as over several cells")
        return "; ".join(found) or "none: no sharp edge, no crease under the maximum pressure, smooth heights"


@responses.register("flags")
@attrs.frozen
class FindFlags(Response[Flags]):
    """Sharp edges, creases and rough heights of a contact, which decide how far its numbers depend on the grid."""

    def respond(self, solution: ContactSolution) -> Flags:
        """Return the flags of a solution."""
        return find_flags(solution)


def find_flags(solution: ContactSolution) -> Flags:
    """Return the flags of a solution, which it keeps."""
    return solution._keep("flags", lambda: _find_flags(solution))


def _find_flags(solution: ContactSolution) -> Flags:
    if solution.patches.count == 0 or solution.contact.all():
        return Flags(0.0, 0.0, False)
    return Flags(_find_sharp_share(solution), _find_crease(solution), _is_rough(solution))


def _modulus(solution: ContactSolution) -> float:
    """Return the modulus E* at the scale of the cells, Pa."""
    return float(solution.effective_modulus(1.0 / math.sqrt(solution.grid.resolved.cell_area)))


def _find_sharp_share(solution: ContactSolution) -> float:
    """Return the share of the pressure beside open cells that stands at sharp edges."""
    shape = solution.contact.shape
    modulus = _modulus(solution)
    loaded = np.where(solution.saturated, 0.0, solution.pressure) if solution.capped else solution.pressure
    pressure = extend(loaded, _ROW, solution.boundary)
    contact = extend(solution.contact, 1, solution.boundary)
    at_edge = solution.parts.own(solution.contact) & ~(
        contact[:-2, 1:-1] & contact[2:, 1:-1] & contact[1:-1, :-2] & contact[1:-1, 2:]
    )
    cells = np.flatnonzero(at_edge)
    i, j = split(cells, shape[1])
    gap = extend(solution.gap, 1, solution.boundary)
    all_sides = 0.0
    sharp_sides = 0.0
    count = 0
    for (di, dj), step in zip(_SIDES, np.repeat(solution.grid.spacing, 2), strict=True):
        beyond = ~contact[i + 1 + di, j + 1 + dj]
        row = np.stack([pressure[i + _ROW - k * di, j + _ROW - k * dj] for k in range(_ROW)])
        facing = beyond & (row > 0.0).all(axis=0)
        rises = (row[0] > row[1]) & (row[1] > row[2]) & (row[2] > _FLATNESS * row[3])
        opening = gap[i + 1 + di, j + 1 + dj] * modulus / step
        sharp = facing & rises & (opening > _MIN_OPENING * row[0])
        all_sides += float(np.sum(row[0], where=facing))
        sharp_sides += float(np.sum(row[0], where=sharp))
        count += int(np.count_nonzero(sharp))
    all_sides, sharp_sides, found = solution.parts.total(np.array((all_sides, sharp_sides, count)))
    share = sharp_sides / all_sides if all_sides > 0.0 else 0.0
    return float(share) if found >= _MIN_SIDES and share > _MIN_SHARE else 0.0


def _find_crease(solution: ContactSolution) -> float:
    """Return the jump of the slope at a crease under the maximum pressure, times E* over that pressure."""
    highest = solution.parts.highest(float(solution.pressure.max()))
    top = np.flatnonzero(solution.parts.own(solution.pressure >= highest))[:1]
    jump = _find_jump(solution, top) if top.size else 0.0
    strongest = float(solution.parts.highest(jump)) * _modulus(solution) / highest
    return strongest if strongest > _MIN_JUMP else 0.0


def _find_jump(solution: ContactSolution, top: IntArray) -> float:
    """Return the largest jump of the slope within a cell of this one, on lines that are bent nowhere else; or zero."""
    near = gather_around(solution.initial_gap, top, _REACH, solution.boundary)[..., 0]
    # Beyond a free border there are no heights, and a short domain has no line.
    shape = solution.contact.shape
    steps = np.arange(-_REACH, _REACH + 1)
    for axis, (at, n, free) in enumerate(zip(split(top, shape[1]), shape, solution.boundary.free_axes, strict=True)):
        known = (at + steps >= 0) & (at + steps < n) if free else np.full(steps.shape, n > 2 * _REACH)
        near = np.where(np.expand_dims(known, 1 - axis), near, np.nan)
    strongest = 0.0
    for di, dj in _LINES:
        # By place on the line, and line through each of the nine cells.
        rows = _REACH + _AROUND[0] + di * _PLACES
        columns = _REACH + _AROUND[1] + dj * _PLACES
        length = math.hypot(di * solution.grid.spacing[0], dj * solution.grid.spacing[1])
        bends = np.diff(near[rows, columns], 2, axis=0) / length
        for there in (bends, bends[::-1]):
            jump = there[_MIDDLE] + there[_MIDDLE + 1]
            beside = np.abs(there[_BESIDE]).max(axis=0)
            strongest = max(strongest, float(np.max(jump, where=beside < _MAX_BEND_BESIDE * jump, initial=0.0)))
    return strongest


def _is_rough(solution: ContactSolution) -> bool:
    """Return whether heights are rough at the scale of the cells, and their curvature far from Gaussian."""
    heights = solution.initial_gap
    second = fourth = quartic = count = 0.0
    for axis, (n, free) in enumerate(zip(heights.shape, solution.boundary.free_axes, strict=True)):
        if n < 2 * _ROW:
            continue
        lines = extend(heights, 2, solution.boundary)
        lines = lines[:, 2:-2] if axis == 0 else lines[2:-2]
        if free:
            lines = np.take(lines, range(2, lines.shape[axis] - 2), axis=axis)
        bends = np.diff(lines, 2, axis=axis)
        turns = np.diff(bends, 2, axis=axis)
        squares = bends * bends
        second += float(np.sum(squares))
        quartic += float(np.sum(squares * squares))
        fourth += float(np.sum(turns * turns)) * bends.size / turns.size
        count += bends.size
    second, fourth, quartic, count = solution.parts.total(np.array((second, fourth, quartic, count)))
    if second == 0.0:
        return False
    return bool(quartic * count > _MIN_KURTOSIS * second**2 and fourth > _MIN_ROUGHNESS * second)
