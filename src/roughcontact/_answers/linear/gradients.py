"""Gradients of a solved contact by the adjoint: heights, modulus or load, for one or two linear answers."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import attrs
import numpy as np

from roughcontact._answers.areas.cells import Neighbourhood, split
from roughcontact._answers.linear.tangent import LinearAnswer, LinearSolution, Tangent, describe_jump, tangent_of
from roughcontact._base.arrays import Array, IntArray, read_only
from roughcontact._base.checks import callback, choice, numbers
from roughcontact._parts.grid import Boundary
from roughcontact._solve.problem import computing, problem_of
from roughcontact._solve.solution import ContactSolution, Response, responses
from roughcontact.errors import InputError
from roughcontact.errors.door import outside
from roughcontact.errors.warning import warn

PressureDerivative: TypeAlias = Callable[[Array], Array]

# Power of the force with which a Hertzian area grows.
_HERTZ_EXPONENT = 2.0 / 3.0
# Relative residual of the answer to a unit approach, whose moments need no more.
_MOMENT_TOLERANCE = 1e-3
# Ratio of the load of a patch by its virial to its actual load, or the inverse, from which it has several summits.
_MAX_SUMMIT_LOAD_RATIO = 2.0
# Area of Hertzian spots of one size over (sum p)^2 / sum p^2: the mean of the square of their pressure.
_PARTICIPATION_FACTOR = 9.0 / 8.0
# Relative residual of the linear answers: the gradient is linear in it.
_ADJOINT_TOLERANCE = 1e-10
_VARIABLES = ("heights", "modulus", "load")
_EDGE_RESPONSES = ("stiffness", "conductance")
_AREA_WARNING = (
    "under a given load the gradient of the area is a small difference of large parts, and even its sign may be wrong: "
    "the gradient of the participation is exact"
)


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

    pressure: Array = attrs.field(factory=lambda: np.zeros(()))
    position: float = 0.0
    heights: Array = attrs.field(factory=lambda: np.zeros(()))
    modulus: float = 0.0


def mark_summit(solution: ContactSolution) -> Array:
    """Return one at the highest cell, whose first touch is the zero of the approach, and zero elsewhere."""
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
    # Squares of very large or small pressures leave the range of float64.
    largest = float(solution.contact_pressure.max())
    if largest == 0.0:
        raise InputError("The participation has no gradient where nothing is in contact.")
    relative = solution.contact_pressure / largest
    total = float(relative.sum())
    square = float(np.einsum("ij,ij->", relative, relative))
    factor = 2.0 * _PARTICIPATION_FACTOR * solution.grid.cell_area * total / square
    by_pressure = factor * (1.0 - total / square * relative) / largest
    return Sensitivity(pressure=np.where(solution.contact, by_pressure, 0.0))


def _of_area(solution: ContactSolution) -> Sensitivity:
    if "tension" in solution._laws:
        raise InputError(
            "The area has no gradient where surfaces attract each other: its edge is that of a crack, and it does not "
            "grow as Hertz's area. Take the difference of two solves."
        )
    patches = solution.patches
    area = solution.area(uncertainty="model")
    # Contact everywhere has no edge that could move.
    if patches.count == 0 or solution.contact.all():
        return Sensitivity()
    areas = patches.areas if area.patches is None else area.patches
    growth = _HERTZ_EXPONENT * areas / patches.forces * solution.grid.cell_area
    return Sensitivity(
        pressure=np.concatenate(([0.0], growth))[patches.labels],
        heights=_find_sharpening(solution, _HERTZ_EXPONENT * areas),
        modulus=-_HERTZ_EXPONENT * float(np.sum(areas)) / solution.modulus,
    )


def _find_sharpening(solution: ContactSolution, weights: Array) -> Array:
    r"""Return the derivative of the weighted sum of log(1/V) over the patches with respect to the heights.

    V is the virial :math:`\sum q\, x \cdot \nabla g` of the initial gap g, over the centre x = 0 of the answer q to a
    unit approach: the load that presses a round tip by itself to the size of the patch. Patches that carry another load
    have several summits and are omitted.
    """
    labels = solution.patches.labels
    shape = solution.grid.shape
    tangent = Tangent(solution)
    answer = tangent.solve(np.ones(shape), _MOMENT_TOLERANCE).values
    cells = np.flatnonzero(answer)
    members = labels.ravel()[cells] - 1
    stiffness = answer.ravel()[cells]
    moments = []
    for axis in (0, 1):
        place = np.unravel_index(cells, shape)[axis]
        offset = _center(solution, place, members, stiffness, axis)
        low, high, width = _find_neighbours(solution, cells, axis)
        moments.append((low, high, np.where(width > 0.0, stiffness * offset / np.maximum(width, 1e-300), 0.0)))
    gap = solution.initial_gap.ravel()
    count = solution.patches.count
    virial = sum(np.bincount(members, moment * (gap[high] - gap[low]), count) for low, high, moment in moments)
    round_load = virial * solution.grid.cell_area / solution.patches.forces
    trusted = (round_load > 1.0 / _MAX_SUMMIT_LOAD_RATIO) & (round_load < _MAX_SUMMIT_LOAD_RATIO)
    scale = np.where(trusted, weights / np.where(trusted, virial, 1.0), 0.0)[members]
    found = np.zeros(gap.size)
    for low, high, moment in moments:
        found += np.bincount(high, scale * moment, gap.size) - np.bincount(low, scale * moment, gap.size)
    return found.reshape(shape)


def _center(solution: ContactSolution, place: IntArray, members: IntArray, stiffness: Array, axis: int) -> Array:
    """Return the distance of cells along an axis from the centre of the answer of their patch, m."""
    size = solution.grid.shape[axis]
    count = solution.patches.count
    distance = place.astype(np.float64)
    if not solution.boundary.free_axes[axis]:
        # A patch may cross the border: distances are the shorter way to the mean direction on a circle.
        angle = 2.0 * np.pi / size * distance
        sine, cosine = (np.bincount(members, stiffness * part, count) for part in (np.sin(angle), np.cos(angle)))
        distance -= size / (2.0 * np.pi) * np.arctan2(sine, cosine)[members]
        distance = (distance + 0.5 * size) % size - 0.5 * size
    weight = np.maximum(np.bincount(members, stiffness, count), 1e-300)
    middle = np.bincount(members, stiffness * distance, count) / weight
    return np.asarray((distance - middle[members]) * solution.grid.spacing[axis])


def _find_neighbours(solution: ContactSolution, cells: IntArray, axis: int) -> tuple[IntArray, IntArray, Array]:
    """Return the neighbours of cells along an axis (the cells themselves where not measured) and their distance, m."""
    shape = solution.grid.shape
    near = Neighbourhood.of(*split(cells, shape[1]), shape, solution.boundary, 1)
    low, high = near.at(np.outer((-1, 1), (axis == 0, axis == 1)))
    if solution.non_measured is not None:
        unknown = solution.non_measured.ravel()
        low, high = (np.where(unknown[other], cells, other) for other in (low, high))
    steps = np.not_equal(low, cells).astype(np.float64) + np.not_equal(high, cells)
    return low, high, np.asarray(steps * solution.grid.spacing[axis])


SENSITIVITIES: dict[str, Callable[[ContactSolution], Sensitivity]] = {
    "approach": _of_approach,
    "area": _of_area,
    "force": _of_force,
    "mean-gap": _of_mean_gap,
    "participation": _of_participation,
}


def _number(value: str | PressureDerivative) -> str | PressureDerivative:
    if not isinstance(value, str):
        if callback(value, "of=", "pressure") is None:
            raise InputError.about("of=", value, "a name or a function of the pressure")
        return value
    if value in _EDGE_RESPONSES:
        raise InputError(
            f"The {value} changes only as the edge of the contact moves from cell to cell, so that it has no gradient "
            "on a grid: take the difference of two solves."
        )
    if value not in SENSITIVITIES:
        raise InputError.unknown("gradient of", value, SENSITIVITIES)
    return value


def _variable(value: str) -> str:
    return choice(value, "with_respect_to=", _VARIABLES)


@responses.register("gradient")
@attrs.frozen
class Gradient(Response[Array]):
    r"""Derivatives of a number of the contact with respect to the heights, the modulus or the load, by the adjoint.

    On the cells A in contact and below the pressure limit, a small change of the heights z and of the position
    :math:`\delta` of the bodies changes the pressure by :math:`K_{AA}\,\mathrm{d}p = \mathrm{d}z + \mathrm{d}\delta`.
    A function J of the pressure therefore has the derivatives

    .. math:: \frac{\mathrm{d}J}{\mathrm{d}z} = \lambda - \frac{\sum\lambda}{\sum s}\,s, \quad
              \lambda = K_{AA}^{-1} \frac{\partial J}{\partial p}, \quad s = K_{AA}^{-1} 1

    under a given load, and :math:`\lambda` at a given position. Where surfaces attract each other open cells follow the
    law, which is held, and :math:`K_{AA}^{-1}` is the answer of `LinearisedGap`. The load that was given is held fixed:
    pressure, force, or approach, which counts from the touch of the highest cell and so moves with it.

    Parameters
    ----------
    of
        ``"force"``, ``"approach"``, ``"mean-gap"``, ``"participation"`` (with adhesion of the contact pressure) or,
        without adhesion, ``"area"``; or a function that takes the pressure, shape (nx, ny), Pa, and returns the
        derivative of J with respect to it, shape (nx, ny).
    with_respect_to
        ``"heights"``: the sum of the heights of both bodies in each cell, m; the result has shape (nx, ny).
        ``"modulus"``: the contact modulus E*, Pa, with that of any layers in proportion; ``"load"``: the pressure,
        force or approach, as it was given. The result has shape ().

    Notes
    -----
    Exact while the cells in contact remain the same, but for ``"area"``. That takes each patch to be Hertzian, of an
    area that grows as its force over modulus and curvature, to the power 2/3: right to 1 % for separate summits, and 10
    to 20 %, a quarter at most, too small where patches merge. With respect to heights under a given load it is a
    small difference of large parts there, and even the sign may be wrong: descend on the ``"participation"``,
    :math:`\frac{9}{8} (\int p)^2 / \int p^2`, the area of Hertzian spots of one size.
    """

    holds_with = frozenset({"tension", "shear"})
    fails_with = frozenset({"inner flow", "inner moduli"})
    memory_arrays = 17.0

    of: str | PressureDerivative = attrs.field(converter=_number)
    with_respect_to: str = attrs.field(default="heights", converter=_variable)

    def respond(self, solution: ContactSolution) -> Array:
        """Return the derivatives; see `Response.respond`."""
        # The tangent refuses a solution that does not say what was solved.
        tangent = tangent_of(solution)
        sensitivity = self._differentiate(solution)
        kind = next(iter(solution.origin.load)) if solution.origin is not None else ""
        if kind == "approach":
            adjoint = _Adjoint.at_approach(tangent, sensitivity)
        else:
            adjoint = _Adjoint.under_load(tangent, sensitivity)
            if self.of == "area" and self.with_respect_to == "heights":
                warn(_AREA_WARNING)
        jump = describe_jump(adjoint.margin)
        if jump is not None:
            warn(jump)
        if self.with_respect_to == "load":
            units = {"pressure": float(solution.pressure.size), "force": 1.0 / solution.grid.cell_area, "approach": 1.0}
            return read_only(np.asarray(adjoint.load * units[kind]))
        if self.with_respect_to == "heights":
            by_heights = adjoint.surface + sensitivity.heights + adjoint.summit * mark_summit(solution)
            return read_only(by_heights)
        # A larger modulus acts as heights in proportion to the displacement.
        moved = float(np.einsum("ij,ij->", adjoint.surface, solution.displacement))
        return read_only(np.asarray(moved / solution.modulus + sensitivity.modulus))

    def _differentiate(self, solution: ContactSolution) -> Sensitivity:
        if isinstance(self.of, str):
            return SENSITIVITIES[self.of](solution)
        shape = solution.grid.shape
        allowed = f"finite numbers of shape {shape}, the derivatives with respect to the pressure of each cell"
        values = numbers(outside(self.of)(solution.pressure), "What of= returns", allowed)
        if values.shape != shape or not np.isfinite(values).all():
            raise InputError.about("What of= returns", values, allowed)
        return Sensitivity(pressure=values)


@attrs.frozen(eq=False)
class _Adjoint:
    """Derivatives of J through the pressure and the position of the bodies.

    Attributes
    ----------
    surface
        With respect to heights at a position that does not move with them, shape (nx, ny); zero outside the contact but
        for surfaces that attract each other.
    summit
        With respect to the height of the highest cell, in addition to `surface`.
    load
        With respect to the sum of the pressure, or to the approach.
    margin
        How far surfaces that attract each other are from a jump, as `StabilityMargin`; 1 without adhesion.
    """

    surface: Array
    summit: float
    load: float
    margin: float = 1.0

    @classmethod
    def at_approach(cls, tangent: LinearAnswer, sensitivity: Sensitivity) -> _Adjoint:
        """Return the derivatives at a given approach."""
        if tangent.is_rigid:
            raise InputError("In full contact on a periodic boundary the approach does not determine the pressure.")
        answer = _solve(tangent, sensitivity.pressure)
        by_position = float(answer.values.sum()) + sensitivity.position
        return cls(answer.values, -by_position, by_position, answer.margin)

    @classmethod
    def under_load(cls, tangent: LinearAnswer, sensitivity: Sensitivity) -> _Adjoint:
        """Return the derivatives under a given load."""
        if not tangent.cells.any():
            raise InputError("All cells in contact are at the pressure limit: how they share a change of load is open.")
        margin = 1.0
        if tangent.is_rigid:
            fractions = np.full(tangent.cells.shape, 1.0 / tangent.cells.size)
            compliance = 0.0
        else:
            uniform = _solve(tangent, np.ones(()))
            stiffness = float(uniform.values.sum())
            if not stiffness > 0.0:
                raise InputError(
                    "Under a given load the state is not stable, so that it has no gradient: solve for its approach."
                )
            # At a jump of the load the attraction pulls as much as the contact resists.
            margin = min(uniform.margin, stiffness / float(np.abs(uniform.values).sum()))
            compliance = 1.0 / stiffness
            fractions = uniform.values * compliance
        # A constant added to the derivative by the pressure counts the change of the load, which is zero.
        mean = float(np.sum(fractions * sensitivity.pressure))
        surface = _solve(tangent, sensitivity.pressure - mean).values - sensitivity.position * fractions
        return cls(surface, 0.0, mean + sensitivity.position * compliance, margin)


def _solve(tangent: LinearAnswer, right: Array) -> LinearSolution:
    """Return the answer to a right side of shape () or (nx, ny)."""
    return tangent.solve(np.broadcast_to(right, tangent.cells.shape), _ADJOINT_TOLERANCE)
