"""The numbers of the steps of a path for infinitely many increments, and the errors that the cells leave in them."""

from __future__ import annotations

import math
from collections.abc import Sequence

import attrs
import numpy as np

from roughcontact._base.arrays import Array, Pair
from roughcontact._base.units import Estimate
from roughcontact._solve.solution import ContactSolution, find_sides

# Ratios of two changes in a row, half an order and two, and the standard deviation of a limit over the largest of these
# changes and what is extrapolated: set on paths with turns, from the first touch and of unlike bodies, against 64
# increments.
_SMALLEST_RATIO = math.sqrt(2.0)
_LARGEST_RATIO = 4.0
_LIMIT_STD = 0.5
# Standard deviation of the energy lost in slip that the cells do not resolve, over the work of the tangential force
# times its part of the force of sliding: of a ball it is 1/36 (Masing's rule on Mindlin's loading curve). And the width
# of slip, in cells, from which none is missed. Set with `_ENERGY_ERROR` on 180 steps of balls and rough surfaces.
_UNRESOLVED_LOSS = 0.1
_RESOLVED_WIDTH = 0.3
# Relative standard deviation of the displacement of a contact of one cell's radius, which falls as the square of the
# radius: measured on balls of 3 to 24 cells at random places against Cattaneo and Mindlin, and on rough contacts
# against finer grids. And of the energy lost in slip that is one cell wide, which falls as the square of the width: set
# on 180 steps of balls and rough surfaces against cells of a quarter. Both are means over x and y.
_DISPLACEMENT_ERROR = 0.1
_ENERGY_ERROR = 0.06
# Relative standard deviation of the displacement of a contact of one cell's radius whose edge sticks, which falls as
# the radius; and the part of the edge that slip one cell wide frees. Set on 50 balls of 3.5 to 16 cells with cells of
# 1:1 to 8:1 under 1e-6 to .9 of the force of sliding.
_STUCK_ERROR = 0.07
_RESOLVED_SLIP = 0.5


@attrs.frozen(eq=False, kw_only=True)
class StepNumbers:
    """Numbers of one step, extrapolated to infinitely many increments.

    Attributes
    ----------
    displacement
        Along x and y, m.
    tangential_force
        Along x and y, N.
    dissipated
        Energy lost in the step, J.
    stick_area
        Area that sticks at its end, m2.
    """

    displacement: tuple[Estimate, Estimate]
    tangential_force: tuple[Estimate, Estimate]
    dissipated: Estimate
    stick_area: Estimate


@attrs.frozen
class CellErrors:
    """Standard deviations of the numbers of a step by the size of the cells: of what is given, zero.

    Attributes
    ----------
    displacement, force
        Along each axis, m and N.
    dissipated
        Of the energy lost, J.
    """

    displacement: float
    force: float
    dissipated: float


def list_cell_errors(steps: Sequence[ContactSolution], before: ContactSolution | None = None) -> list[CellErrors]:
    """Return the errors by the size of the cells of each step of a path, which follows a state `before`."""
    # Pressure moves the surfaces of unlike bodies along each other by about beta times the approach.
    moved = max(math.hypot(*step.tangential_displacement, step.sheared.pair.beta * step.approach) for step in steps)
    pushed = max(math.hypot(*step.tangential_force) for step in steps)
    found: list[CellErrors] = []
    missed = 0.0
    for step in steps:
        # Bodies that have come apart have no cells in contact.
        touching = step if before is None or step.contact.any() else before
        relative, relative_loss = _find_cell_errors(touching)
        is_moved = step.tangential_load.kind == "displacement"
        own = math.hypot(relative_loss * step.dissipated.value, _find_unresolved_loss(step, before))
        # What one step misses is lost in the next.
        found.append(
            CellErrors(
                displacement=0.0 if is_moved else relative * moved,
                force=relative * pushed if is_moved else 0.0,
                dissipated=math.hypot(own, missed),
            )
        )
        before = step
        missed = own
    return found


def _find_cell_errors(state: ContactSolution) -> Pair:
    """Return relative standard deviations of the displacement and of the energy lost, by the size of the cells."""
    edge = _find_edge_length(state)
    if not edge:
        return 0.0, 0.0
    spacing = np.array(state.grid.spacing)
    radius = 2.0 * int(np.count_nonzero(state.contact)) * state.grid.cell_area / edge / spacing
    width = np.maximum(_find_slip_width(state), state.grid.cell_area / edge / spacing)
    # An edge that sticks in part of its cells, because slip has not reached across them.
    stuck = np.maximum(1.0 - _RESOLVED_SLIP * width, 0.0)
    displacement = math.hypot(
        _DISPLACEMENT_ERROR * float(np.mean(radius**-2)), _STUCK_ERROR * float(np.mean(stuck / radius))
    )
    return min(displacement, 1.0), _ENERGY_ERROR * float(np.mean(width**-2))


def _find_edge_length(state: ContactSolution) -> float:
    """Return the length of the edge of the contact, m, zero without one: the sides of cells of a disc are longer."""
    return 0.25 * math.pi * find_sides(state)[0]


def _find_slip_width(state: ContactSolution) -> Array:
    """Return the mean width of the slip along the edge of the contact in cells along x and y, shape (2,)."""
    area = int(np.count_nonzero(state.slipping)) * state.grid.cell_area
    return area / max(_find_edge_length(state), math.sqrt(state.grid.cell_area)) / np.array(state.grid.spacing)


def _find_unresolved_loss(step: ContactSolution, before: ContactSolution | None) -> float:
    """Return the energy that slip narrower than the cells may lose in a step, J."""
    strength = float(step.shear_strength.sum())
    push = np.array(step.tangential_force)
    move = np.array(step.tangential_displacement)
    if before is not None:
        strength = max(strength, float(before.shear_strength.sum()))
        push = push - before.tangential_force
        move = move - before.tangential_displacement
    width = math.sqrt(float(np.prod(_find_slip_width(step))))
    if strength == 0.0 or width >= _RESOLVED_WIDTH:
        return 0.0
    part = math.hypot(*push) / (strength * step.grid.cell_area)
    return _UNRESOLVED_LOSS * part * abs(float(push @ move)) * (1.0 - width / _RESOLVED_WIDTH)


def numbers_of(step: ContactSolution, error: CellErrors, warnings: tuple[str, ...] = ()) -> StepNumbers:
    """Return the numbers of a step as they are, with the errors that the cells leave."""
    return StepNumbers(
        displacement=_pair(step.tangential_displacement, error.displacement, "m", warnings),
        tangential_force=_pair(step.tangential_force, error.force, "N", warnings),
        dissipated=attrs.evolve(step.dissipated, warnings=warnings),
        stick_area=attrs.evolve(step.stick_area, warnings=warnings),
    )


def extrapolate_numbers(sweeps: Sequence[ContactSolution], error: CellErrors, warnings: tuple[str, ...]) -> StepNumbers:
    """Return the limits of infinitely many increments, from the last three numbers of increments, each twice the other.

    The order of the error is observed: it is one where a direction turns, and a half where normal and tangential load
    grow together from the first touch.
    """
    fine = sweeps[-1]

    def extend(values: Sequence[float], unit: str, known: float, high: float) -> Estimate:
        limit, unsure = _find_limit([np.array([value]) for value in values])
        return Estimate(min(max(float(limit[0]), 0.0), high), math.hypot(unsure, known), unit, warnings)

    def extend_pair(values: Sequence[Pair], unit: str, known: float) -> tuple[Estimate, Estimate]:
        limit, unsure = _find_limit([np.array(value) for value in values])
        return _pair((float(limit[0]), float(limit[1])), math.hypot(unsure, known), unit, warnings)

    is_moved = fine.tangential_load.kind == "displacement"
    moved = [step.tangential_displacement for step in sweeps]
    pushed = [step.tangential_force for step in sweeps]
    stick = [step.stick_area.value for step in sweeps]
    touching = max(stick[-1], fine.area(uncertainty="model").value)
    return StepNumbers(
        displacement=_pair(moved[-1], 0.0, "m", warnings) if is_moved else extend_pair(moved, "m", error.displacement),
        tangential_force=extend_pair(pushed, "N", error.force) if is_moved else _pair(pushed[-1], 0.0, "N", warnings),
        dissipated=extend([step.dissipated.value for step in sweeps], "J", error.dissipated, math.inf),
        stick_area=extend(stick, "m2", fine.stick_area.uncertainty, touching),
    )


def _pair(values: Pair, uncertainty: float, unit: str, warnings: tuple[str, ...]) -> tuple[Estimate, Estimate]:
    x, y = (Estimate(value, uncertainty, unit, warnings) for value in values)
    return x, y


def _find_limit(values: Sequence[Array]) -> tuple[Array, float]:
    r"""Return the limit of three vectors of one, two and four times as many increments, and its standard deviation.

    With changes a and b the error falls by :math:`r = a \cdot b / b^2` where the increments are halved, and
    :math:`b / (r - 1)` is left (Aitken). Where the changes do not fall there is no order, and both count.
    """
    first = values[1] - values[0]
    last = values[2] - values[1]
    square = float(last @ last)
    if square == 0.0:
        return values[2], 0.0
    ratio = float(first @ last) / square
    left = last / (min(max(ratio, _SMALLEST_RATIO), _LARGEST_RATIO) - 1.0)
    sizes = [math.hypot(*one) for one in (first, last, left)]
    return values[2] + left, _LIMIT_STD * max(sizes) if ratio > 1.0 else sizes[0] + sizes[1]
