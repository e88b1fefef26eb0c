"""How numbers of a contact depend on its pressure, the position of the bodies, the heights and the modulus."""

from __future__ import annotations

from collections.abc import Callable

import attrs
import numpy as np

from roughcontact._answers.linear.tangent import Tangent
from roughcontact._base.checks import Array, IntArray
from roughcontact._parts.grid import Boundary
from roughcontact._solve.problem import computing, problem_of
from roughcontact._solve.solution import ContactSolution
from roughcontact.errors import InputError

# A Hertzian area grows as its force to this power.
_HERTZ = 2.0 / 3.0
# Relative residual of the answer to a unit approach, whose moments need no more.
_TOLERANCE = 1e-3
# Load of a patch by its virial over its own, or the inverse, from which it has more than one summit.
_ROUND = 2.0
# Area of Hertzian spots of one size over (sum p)^2 / sum p^2: the mean of the square of their pressure.
_PARTICIPATION = 9.0 / 8.0


def _nothing() -> Array:
    return np.zeros(())


@attrs.frozen(eq=False, kw_only=True)
class Sensitivity:
    """Partial derivatives of a number J(p, position, heights, modulus) of the contact.

    Attributes
    ----------
    pressure
        With respect to the pressure of each cell, shape () or (nx, ny), 1/Pa times the unit of J.
    position
        With respect to the position of the bodies, positive as they approach, 1/m times the unit of J.
    heights
        With respect to the heights, shape () or (nx, ny), 1/m times the unit of J.
    modulus
        With respect to the contact modulus E*, 1/Pa times the unit of J.
    """

    pressure: Array = attrs.field(factory=_nothing)
    position: float = 0.0
    heights: Array = attrs.field(factory=_nothing)
    modulus: float = 0.0


def mark_summit(solution: ContactSolution) -> Array:
    """Return one at the highest cell, from whose touch the approach counts, and zero elsewhere, shape (nx, ny)."""
    summit = np.zeros(solution.grid.shape)
    summit.flat[np.argmin(solution.initial_gap)] = 1.0
    return summit


def _of_force(solution: ContactSolution) -> Sensitivity:
    return Sensitivity(pressure=np.asarray(solution.grid.cell_area))


def _of_approach(solution: ContactSolution) -> Sensitivity:
    return Sensitivity(position=1.0, heights=mark_summit(solution))


def _of_mean_gap(solution: ContactSolution) -> Sensitivity:
    if solution.non_measured is not None:
        raise InputError("The mean gap has no gradient where points were not measured: there the gap is not known.")
    size = float(solution.pressure.size)
    sensitivity = Sensitivity(position=-1.0, heights=np.asarray(-1.0 / size))
    if solution.boundary is Boundary.PERIODIC:
        # Pressure does not change the mean displacement.
        return sensitivity
    problem = problem_of(solution)
    unit = solution.grid.spacing[0] / solution.modulus
    with computing(problem):
        convolution = problem.convolution
        uniform = convolution.from_numpy(np.full(solution.grid.shape, unit / size))
        by_pressure = convolution.to_numpy(convolution.apply(uniform))
    by_modulus = -float(np.mean(solution.displacement)) / solution.modulus
    return attrs.evolve(sensitivity, pressure=by_pressure, modulus=by_modulus)


def _of_participation(solution: ContactSolution) -> Sensitivity:
    # Squares of pressures near the ends of float64 leave it.
    largest = float(solution.pressure.max())
    if largest == 0.0:
        raise InputError("The participation has no gradient where nothing is in contact.")
    relative = solution.pressure / largest
    total = float(relative.sum())
    square = float(np.einsum("ij,ij->", relative, relative))
    factor = 2.0 * _PARTICIPATION * solution.grid.cell_area * total / square
    return Sensitivity(pressure=factor * (1.0 - total / square * relative) / largest)


def _of_area(solution: ContactSolution) -> Sensitivity:
    patches = solution.patches
    area = solution.area()
    # Contact everywhere has no edge that could move.
    if patches.count == 0 or solution.contact.all():
        return Sensitivity()
    areas = patches.areas if area.patches is None else area.patches
    growth = _HERTZ * areas / patches.forces * solution.grid.cell_area
    return Sensitivity(
        pressure=np.concatenate(([0.0], growth))[patches.labels],
        heights=_find_sharpening(solution, _HERTZ * areas),
        modulus=-_HERTZ * float(np.sum(areas)) / solution.modulus,
    )


def _find_sharpening(solution: ContactSolution, weights: Array) -> Array:
    r"""Return by how much heights change the sum of the logarithms of 1/V of the patches, each times its weight.

    V is the virial :math:`\sum q\, x \cdot \nabla g` of the initial gap g, over the centre x = 0 of the answer q to a
    unit approach: the load that presses a round tip by itself to the size of the patch. Patches that carry another load
    are of several summits, and are omitted.
    """
    labels = solution.patches.labels
    shape = solution.grid.shape
    tangent = Tangent(solution)
    answer = tangent.solve(np.ones(shape), _TOLERANCE).values
    cells = np.flatnonzero(answer)
    members = labels.ravel()[cells] - 1
    stiffness = answer.ravel()[cells]
    moments = []
    for axis in (0, 1):
        place = np.unravel_index(cells, shape)[axis]
        offset = _center(solution, place, members, stiffness, axis)
        low, high, width = _find_neighbours(solution, cells, place, axis)
        moments.append((low, high, np.where(width > 0.0, stiffness * offset / np.maximum(width, 1e-300), 0.0)))
    gap = solution.initial_gap.ravel()
    count = solution.patches.count
    virial = sum(np.bincount(members, moment * (gap[high] - gap[low]), count) for low, high, moment in moments)
    round_load = virial * solution.grid.cell_area / solution.patches.forces
    trusted = (round_load > 1.0 / _ROUND) & (round_load < _ROUND)
    scale = np.where(trusted, weights / np.where(trusted, virial, 1.0), 0.0)[members]
    found = np.zeros(gap.size)
    for low, high, moment in moments:
        found += np.bincount(high, scale * moment, gap.size) - np.bincount(low, scale * moment, gap.size)
    return found.reshape(shape)


def _center(solution: ContactSolution, place: IntArray, members: IntArray, stiffness: Array, axis: int) -> Array:
    """Return the distance of cells along an axis to the centre of the answer of their patch, m."""
    size = solution.grid.shape[axis]
    count = solution.patches.count
    distance = place.astype(np.float64)
    if solution.boundary is not Boundary.FREE:
        # A patch may cross the border: distances are the shorter way to the mean direction on a circle.
        angle = 2.0 * np.pi / size * distance
        sine, cosine = (np.bincount(members, stiffness * part, count) for part in (np.sin(angle), np.cos(angle)))
        distance -= size / (2.0 * np.pi) * np.arctan2(sine, cosine)[members]
        distance = (distance + 0.5 * size) % size - 0.5 * size
    weight = np.maximum(np.bincount(members, stiffness, count), 1e-300)
    middle = np.bincount(members, stiffness * distance, count) / weight
    return np.asarray((distance - middle[members]) * solution.grid.spacing[axis])


def _find_neighbours(
    solution: ContactSolution, cells: IntArray, place: IntArray, axis: int
) -> tuple[IntArray, IntArray, Array]:
    """Return the measured neighbours of cells on both sides along an axis, else the cells, and their distance, m."""
    shape = solution.grid.shape
    stride = shape[1] if axis == 0 else 1
    sides = []
    for step in (-1, 1):
        moved = place + step
        if solution.boundary is Boundary.FREE:
            moved = np.clip(moved, 0, shape[axis] - 1)
        other = cells + (moved % shape[axis] - place) * stride
        if solution.non_measured is not None:
            missing = solution.non_measured.ravel()[other]
            moved = np.where(missing, place, moved)
            other = np.where(missing, cells, other)
        sides.append((moved, other))
    (before, low), (behind, high) = sides
    return low, high, np.asarray((behind - before) * solution.grid.spacing[axis], dtype=np.float64)


SENSITIVITIES: dict[str, Callable[[ContactSolution], Sensitivity]] = {
    "approach": _of_approach,
    "area": _of_area,
    "force": _of_force,
    "mean-gap": _of_mean_gap,
    "participation": _of_participation,
}
