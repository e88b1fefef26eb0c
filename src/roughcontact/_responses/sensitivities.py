"""How numbers of a contact depend on its pressure, the position of the bodies, the heights and the modulus."""

from __future__ import annotations

from collections.abc import Callable

import attrs
import numpy as np

from roughcontact._problem import problem_of
from roughcontact._problem.run import computing
from roughcontact._solution import ContactSolution
from roughcontact.checks import Array
from roughcontact.errors import InputError
from roughcontact.grid import Boundary

# A Hertzian area grows as its force to this power.
_HERTZ = 2.0 / 3.0
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
    total, square = float(relative.sum()), float(np.einsum("ij,ij->", relative, relative))
    factor = 2.0 * _PARTICIPATION * solution.grid.cell_area * total / square
    return Sensitivity(pressure=factor * (1.0 - total / square * relative) / largest)


def _of_area(solution: ContactSolution) -> Sensitivity:
    patches, area = solution.patches, solution.area()
    # Contact everywhere has no edge that could move.
    if patches.count == 0 or solution.contact.all():
        return Sensitivity()
    areas = patches.areas if area.patches is None else area.patches
    growth = _HERTZ * areas / patches.forces * solution.grid.cell_area
    return Sensitivity(pressure=np.concatenate(([0.0], growth))[patches.labels])


SENSITIVITIES: dict[str, Callable[[ContactSolution], Sensitivity]] = {
    "approach": _of_approach,
    "area": _of_area,
    "force": _of_force,
    "mean-gap": _of_mean_gap,
    "participation": _of_participation,
}
