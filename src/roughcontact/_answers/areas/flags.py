"""Flags of a contact: what its cells show of places where the pressure is unbounded, or that no grid resolves.

At a sharp edge the pressure rises outwards as the inverse root of the distance, at a crease that points at the other
surface as the logarithm; both have no maximum. Heights as rough at the scale of the cells as at any other have details
that these cells do not show.
"""

from __future__ import annotations

import math

import attrs
import numpy as np

from roughcontact._answers.areas.cells import (
    MIN_SHARP_PATCH_CELLS,
    NEIGHBOUR_STEPS,
    find_edge_cells,
    find_jumps,
    gather_around,
    split,
)
from roughcontact._base.arrays import Array, IntArray, Mask
from roughcontact._base.units import Estimate, ShownAsPrinted, percent
from roughcontact._solve.solution import ContactSolution, Response, heal, responses
from roughcontact.errors import InputError

# Steps to the cell across a crease: along both axes and both diagonals.
_LINES = NEIGHBOUR_STEPS[::2]
# Steps to the cells in contact in line inwards from a side, whose pressures tell whether it rises outwards.
_ROW = (0, -1, -2, -3)
# Steps outwards from the last cell in contact.
_BEYOND = (0, 1, 2, 3)
# Pressure of the second cell from a sharp edge at most over that of the innermost of the row.
_FLATNESS = 0.9
# Gap beyond a sharp edge, times E* over the cell, over the pressure beside it, at least.
_MIN_OPENING = 0.5
# Sides of a sharp edge, and the fraction of the pressure beside sides that they carry, at least.
_MIN_SIDES = 3
_MIN_FRACTION = 0.1
# Cells on each side of the highest pressure, and the places there of the lines through each of the nine cells around
# it, shape (2, places on a line, lines, cells).
_REACH = 6
_AROUND = np.stack(np.meshgrid((-1, 0, 1), (-1, 0, 1), indexing="ij")).reshape(2, 1, 1, 9)
_PLACES = np.arange(-5, 6)[:, np.newaxis, np.newaxis]
_CELLS_ON_LINES = _REACH + _AROUND + _LINES.T[:, np.newaxis, :, np.newaxis] * _PLACES
# Second differences beside those at a crease, in cells from the first of both, and at most over their sum.
_BESIDE = (-3, -2, -1, 2, 3, 4)
_MAX_BEND_BESIDE = 0.15
# Largest change of the heights over two cells inward from a step, over the height of the step.
_MAX_FLAT_RATIO = 0.25
# Jump of the slope at a crease, times E*, over the maximum pressure, at least.
_MIN_JUMP = 0.02
# Kurtosis of the second differences (3 on Gaussian heights), and mean square of the fourth over that of the second
# differences, above which heights are rough at the scale of the cells.
_MIN_KURTOSIS = 6.0
_MIN_ROUGHNESS = 1.0
# Heights whose differences are in the cache of a core at once.
_TILE_CELLS = 2**14


@attrs.frozen
class Flags(ShownAsPrinted):
    """What the cells show of places that no grid resolves.

    Attributes
    ----------
    sharp_edge
        Fraction of the pressure beside open cells, in contacts of at least four cells across, that stands at sharp
        edges, where it is unbounded; one if the maximum is beside a step of the heights; zero without any.
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
    >>> flags = rc.ContactProblem(punch).solve(force=0.1).response("flags")
    >>> flags.unbounded, flags.sharp_edge, flags.crease
    (True, 1.0, 0.0)
    """

    sharp_edge: float
    crease: float
    rough_tail: bool

    @property
    def unbounded(self) -> bool:
        """Whether the pressure has no maximum: each finer grid has a higher one."""
        return self.sharp_edge > 0.0 or self.crease > 0.0

    @property
    def unresolved(self) -> bool:
        """Whether edges or heights are sharp at the scale of the cells, so that every answer depends on the grid.

        A crease is known at one place, under the maximum pressure.
        """
        return self.sharp_edge > 0.0 or self.rough_tail

    @property
    def estimates(self) -> dict[str, Estimate]:
        """The flags as numbers by name; the last is 1 or 0."""
        names = ("sharp edge", "crease", "rough tail")
        return {name: Estimate(float(value), 0.0, "") for name, value in zip(names, attrs.astuple(self), strict=True)}

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

    memory_arrays = 6.0  # patches, and the gap

    def respond(self, solution: ContactSolution) -> Flags:
        """Return the flags of a solution.

        Raises
        ------
        InputError
            If the fields of the solution are divided among processes.
        """
        if not solution.parts.is_whole:
            raise InputError("The heights here are those of a slab: ask gather() for the whole contact.")
        return find_flags(heal(solution))


def find_flags(solution: ContactSolution) -> Flags:
    """Return the flags of a whole solution, which it keeps."""
    return solution._keep("flags", lambda: Flags(*find_unbounded(solution), _is_rough(solution)))


def find_unbounded(solution: ContactSolution) -> tuple[float, float]:
    """Return `Flags.sharp_edge` and `Flags.crease`, which take a list of cells each; the third needs all heights."""
    return solution._keep("unbounded", lambda: _find_unbounded(solution))


def _find_unbounded(solution: ContactSolution) -> tuple[float, float]:
    patches = solution.patches
    if patches.count == 0:
        return 0.0, 0.0
    highest = solution.parts.highest(float(solution.pressure.max()))
    top = np.flatnonzero(solution.parts.own((solution.pressure >= highest) & ~solution.saturated))[:1]
    if not solution.parts.highest(float(top.size)):
        # The maximum is the limit of the pressure.
        return 0.0, 0.0
    steep = flat = 0.0
    if top.size:
        steep = _find_jump(solution, top) * _modulus(solution) / highest
        wide = patches.cells[patches.labels.ravel()[top] - 1] >= MIN_SHARP_PATCH_CELLS
        flat = float(wide.all() and _lies_at_step(solution, top))
    crease, step = (float(solution.parts.highest(value)) for value in (steep, flat))
    return max(_find_sharp_fraction(solution), step), crease if crease > _MIN_JUMP else 0.0


def _modulus(solution: ContactSolution) -> float:
    """Return the modulus E* at the scale of the cells, Pa."""
    return float(solution.effective_modulus(1.0 / math.sqrt(solution.grid.resolved.cell_area)))


def _find_sharp_fraction(solution: ContactSolution) -> float:
    """Return the fraction of the pressure beside open cells that stands at sharp edges."""
    edge = find_edge_cells(solution)
    # The first four neighbours are those along an axis.
    direction, facing = np.nonzero(~edge.touching[:4])
    mine = solution.parts.own_rows(edge.rows[facing])
    direction = direction[mine]
    facing = facing[mine]
    row = solution.pressure.ravel().take(edge.walk(direction, facing, _ROW))
    outermost = np.where((row > 0.0).all(axis=0), row[0], 0.0)
    rising = np.flatnonzero((outermost > row[1]) & (row[1] > row[2]) & (row[2] > _FLATNESS * row[3]))
    opening = solution.gap.ravel().take(edge.walk(direction[rising], facing[rising], (1,))[0]) * _modulus(solution)
    step = np.repeat(solution.grid.spacing, 2)[direction[rising]]
    beyond = solution.initial_gap.ravel().take(edge.walk(direction[rising], facing[rising], _BEYOND))
    found = outermost[rising][(opening > _MIN_OPENING * step * outermost[rising]) & ~_is_rounded(beyond)]
    beside, sharp, sides = solution.parts.total(np.array((outermost.sum(), found.sum(), found.size)))
    return float(sharp / beside) if sides >= _MIN_SIDES and sharp > _MIN_FRACTION * beside else 0.0


def _lies_at_step(solution: ContactSolution, cell: IntArray) -> bool:
    """Return whether the contact ends at a step of the heights beside this cell, and the heights inward are flat."""
    middle = _BEYOND[-1]
    contact = gather_around(solution.contact.view(np.uint8), cell, middle, solution.boundary)[..., 0]
    gap = gather_around(solution.initial_gap, cell, middle, solution.boundary)[..., 0]
    for touching, rise in ((contact[:, middle], gap[:, middle]), (contact[middle], gap[middle])):
        for outward in (1, -1):
            rises = (rise - rise[middle])[::outward]
            inward = slice(middle - 2, middle)
            if (
                touching[::outward][inward].all()
                and not touching[middle + outward]
                and np.abs(rises[inward]).max() < _MAX_FLAT_RATIO * rises[middle + 1]
                and not _is_rounded(rises[middle:])
            ):
                return True
    return False


def _is_rounded(beyond: Array) -> Mask:
    """Return whether the gap from the last cell in contact outwards, shape (4, ...), bends away over several cells.

    Beyond a sharp edge it bends at the edge alone.
    """
    first, second = np.diff(beyond, 2, axis=0)
    return np.asarray((first > 0.0) & (2.0 * second > first))


def _find_jump(solution: ContactSolution, top: IntArray) -> float:
    """Return the largest jump of the slope within a cell of this one, on lines that are bent nowhere else; or zero."""
    near = gather_around(solution.initial_gap, top, _REACH, solution.boundary)[..., 0]
    # Beyond a free border there are no heights.
    shape = solution.contact.shape
    steps = np.arange(-_REACH, _REACH + 1)
    for axis, (at, n, free) in enumerate(zip(split(top, shape[1]), shape, solution.boundary.free_axes, strict=True)):
        if free:
            known = (at + steps >= 0) & (at + steps < n)
            near = np.where(np.expand_dims(known, 1 - axis), near, np.nan)
    length = np.hypot(*(_LINES * solution.grid.spacing).T)[:, np.newaxis]
    bends = np.diff(near[_CELLS_ON_LINES[0], _CELLS_ON_LINES[1]], 2, axis=0) / length
    return max(float(find_jumps(there, _BESIDE, _MAX_BEND_BESIDE).max()) for there in (bends, bends[::-1]))


def _is_rough(solution: ContactSolution) -> bool:
    """Return whether heights are rough at the scale of the cells, and their curvature far from Gaussian.

    Differences across the border are omitted: there heights that do not repeat have a crease far from their contact.
    """
    gap = solution.initial_gap
    height = float(np.ptp(gap))
    if height == 0.0:
        return False
    moments = np.zeros(4)
    rows = max(_TILE_CELLS // gap.shape[1], 1)
    for first in range(0, gap.shape[0], rows):
        # The differences of a tile along x begin in its rows, and end in those of the next one.
        moments += _sum_differences(gap[first : first + rows + 4] / height, 0)
        moments += _sum_differences(gap[first : first + rows] / height, 1)
    count, second, quartic, fourth = moments
    return bool(quartic * count > _MIN_KURTOSIS * second**2 and fourth > _MIN_ROUGHNESS * second)


def _sum_differences(heights: Array, axis: int) -> Array:
    """Return the number of fourth differences of heights along an axis, and sums at their places.

    The sums are those of the squares and fourth powers of the second differences, and of the squares of the fourth.
    """
    if heights.shape[axis] <= 4:
        return np.zeros(4)
    bends = np.diff(heights, 2, axis=axis)
    turns = np.diff(bends, 2, axis=axis)
    squares = (bends[1:-1] if axis == 0 else bends[:, 1:-1]) ** 2
    return np.array((squares.size, squares.sum(), np.sum(squares * squares), np.sum(turns * turns)))
