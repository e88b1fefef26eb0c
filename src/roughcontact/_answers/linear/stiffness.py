"""Normal stiffness, corrected because cells follow the edge in steps; margin to a jump, and force of pull-off."""

from __future__ import annotations

import math

import attrs
import numpy as np

from roughcontact._answers.areas.calibration import MODULUS_LENGTH
from roughcontact._answers.areas.cells import count_sides, find_sharp_edges
from roughcontact._answers.areas.edges import ends_as_root, pass_on_warnings, trace_edges, warn_if_uncertain
from roughcontact._answers.areas.initial_gap import curvature_resolution
from roughcontact._answers.linear.tangent import Tangent, describe_jump, tangent_of
from roughcontact._base.archive.plain import key_of
from roughcontact._base.arrays import Array, IntArray, Mask
from roughcontact._base.checks import flag
from roughcontact._base.units import WarningText
from roughcontact._parts.grid import Boundary, Grid, grow
from roughcontact._solve.problem import ContactProblem, OnStateToPullOff, find_pull_off, find_stability, problem_of
from roughcontact._solve.solution import Area, ContactSolution, Estimate, Response, defer_stiffness_sampling, responses
from roughcontact.errors import InputError, argument

# Area by which the punch of the cells acts as smaller, in cells, for a row of L sides: a L - b ln L - c. Solved for
# periodic strips with edges of slopes 0 to 1/16: it agrees with Westergaard's closed form to 0.005 of a side.
_ROW_LOSS = 0.1736
_KINK_LOSS = 0.154
_END_LOSS = 0.0866
# Power of the side of a cell across the row over its side along the row, in the second term.
_ASPECT_EXPONENT = 0.7
# C^2 over h q^2 / (2 pi), q^2 averaged over the sides: of a wide contact, and the radius in cells that lowers it.
_EDGE_FACTOR = 1.346
_NARROW_RADIUS_CELLS = 0.147
# Compliance of a cell, h/E*, over the compliance of a film that halves this area; set on balls.
_FILM_FADING = 3.0
# Resolution ratio that halves the correction: on coarser grids the area between the cells is not known either.
_HALF_TRUST_RATIO = 0.8
# Remaining fraction of the correction from which sharp edges make no difference.
_MIN_FULL_TRUST = 0.9
# Relative standard deviation of the stiffness of a patch by the positions of its cells, times its radius in cells to
# the power 3/2.
_POSITION_STD = 0.03
# The same of patches that lie alike on the grid, over the fraction of the area that they lose at their edges. Set on
# waves of two directions: 1 to 3 % with 3 to 6 cells a radius.
_ALIKE_STD = 0.25
# Relative standard deviation of the stiffness of all patches together, over the resolution ratio to the power 3/2.
_COMMON_STD = 0.02
# Standard deviation of the correction over the correction.
_CORRECTION_STD = 0.25
# Radius, in cells over the root of the resolution ratio, of a contact patch between the cells, whose stiffness 2 E*
# times the radius light contacts lack once or twice. Set on the tuned split of benchmarks/response_classes.py, three
# times its cases.
_HIDDEN_RADIUS_FACTOR = 0.375
# Standard deviation of the stiffness over E* times the length of the free borders at which a contact lies between the
# last centres of cells and the border, at least so many cells from those in contact. Set on smooth contacts that free
# borders cut: there strips erred by 1 to 11 %.
_BORDER_STD = 0.12
_HIDDEN_BORDER_CELLS = 2
# Relative residual of the answer to a unit displacement: the relative error of the stiffness is its square, times the
# largest stiffness of waves over the smallest, which on stiff coatings is large: 1e-2 made an error of .28 % there.
_RESIDUAL_TOLERANCE = 1e-3
# The same with adhesion, where the pull of the open cells is subtracted, and the margin is met on the way.
_ADHESIVE_TOLERANCE = 3e-3
# Relative standard deviation of the stability margin by the steps of Lanczos' method.
_MARGIN_STD = 0.02
# Standard deviation of the stiffness of worn contacts over that which their counted area gives. Set on draw 1 of
# benchmarks/memory_classes.py.
_WORN_STD = 0.5


# Standard deviation of the stiffness over the pull of the open cells, times the width of the ring of them in cells; and
# as a fraction of the stiffness, because the edge sticks to the cells: a factor, and the fall with the cells of the
# cohesive length. Set on 675 balls of Maugis' parameter 0.25 to 2 and exponential laws of Tabor's number 0.5 to 2 at
# random places, on 24 to 96 cells at three loads: 98 % of the errors lie within two standard deviations.
_PULL_STD = 0.05
_STUCK_STD = 1.5
_STUCK_FALL = 1.5
# Forces that are kept, by the key of their problem: solutions at several loads, also those from files, share one.
_FOUND: dict[str, Estimate] = {}
_MOST_KEPT = 32


@attrs.frozen(eq=False)
class EdgeCorrection:
    """The correction of each patch, shape (count,), N/m, and the standard deviation of their sum, N/m."""

    patches: Array
    uncertainty: float


def correct_edges(
    solution: ContactSolution, answer: Array, cells: Mask, area: Area, film: float, modulus: float
) -> EdgeCorrection:
    """Return the correction of the stiffness of each patch.

    Parameters
    ----------
    solution
        The contact.
    answer
        The answer q to a unit displacement, shape (nx, ny), Pa/m.
    cells
        The cells on which it was solved, shape (nx, ny).
    area
        The area of the contact and of each patch.
    film
        Compliance of a film on the cells, m/Pa, scaled so that the cells together yield as the film on the real area.
    modulus
        Contact modulus of waves as short as the edge, Pa.
    """
    count = solution.patches.count
    cell = solution.grid.cell_area
    step = math.sqrt(solution.grid.resolved.cell_area)
    cells_of = solution.patches.sum(cells.astype(np.float64))
    lost, sides, squares, along = _measure_rows(solution, answer, cells)
    # A film that yields more than a cell makes the pressure even at the edge: the cells then act with their own area.
    faded = 1.0 - 1.0 / (1.0 + _FILM_FADING * film * modulus / step)
    lost *= 1.0 - faded
    acting = np.maximum(cells_of - lost, 0.3 * cells_of) * cell
    known = _find_areas(solution, cells_of, acting, area)
    width = np.where(sides > 0.0, 2.0 * acting / np.maximum(0.25 * np.pi * sides, 1e-300), np.inf) / step
    factor = _EDGE_FACTOR * (1.0 - _NARROW_RADIUS_CELLS / np.maximum(width, 2.0 * _NARROW_RADIUS_CELLS))
    slope = factor * squares * cell / (np.maximum(sides, 1e-300) * modulus)
    # The stiffness of a single spot is proportional to the root of its area.
    growth = np.where(acting > 0.0, known / np.maximum(acting, 1e-300), 1.0)
    ratio = curvature_resolution(solution)
    trust = _find_trust(solution, ratio)
    correction = 2.0 * trust * slope * acting * (np.sqrt(growth) - 1.0)
    stiffness = solution.patches.sum(answer) * cell
    total = float(stiffness.sum())
    nominal = float(acting.sum())
    unsure = _CORRECTION_STD * abs(float(correction.sum()))
    growing = float(np.sum(slope * acting))
    in_film = np.zeros(count)
    if film > 0.0:
        in_film = film * solution.patches.sum(answer**2) * cell
        at_edge = film * along / np.maximum(sides, 1e-300)
        counted = cells_of * cell
        grown = float(known.sum()) / float(counted.sum()) - 1.0
        of_film = trust * (at_edge * (known - counted) - in_film * grown)
        correction += of_film
        # Both parts mostly cancel, and how fast the first fades depends on the shape.
        unsure += _CORRECTION_STD * abs(float(of_film.sum())) + faded * float(np.sum(slope * lost)) * cell
        growing += float(in_film.sum())
    correction = _bound_loss(correction, stiffness, slope * acting + in_film)
    # The part of the displacement that is not in the film is at the edges.
    open_part = max(1.0 - float(in_film.sum()) / total, 0.0) if total > 0.0 else 0.0
    by_area = growing / nominal * area.uncertainty if nominal > 0.0 else 0.0
    # The longer sides of the cells place the edge.
    oblong = max(solution.grid.resolved.spacing) / step
    by_patch = stiffness * (oblong / np.maximum(width, 0.5)) ** 1.5
    by_cells = open_part * _POSITION_STD * math.sqrt(float(np.sum(by_patch**2)))
    # Patches that lie alike on the grid lose alike.
    equal = np.clip(trace_edges(solution).alike[1:], 1.0, count) - 1.0
    by_loss = stiffness * lost * np.sqrt(equal / max(count, 1)) / np.maximum(cells_of, 1.0)
    alike = open_part * _ALIKE_STD * float(np.sum(by_loss))
    # Near full contact the stiffness grows much faster than the area.
    common = open_part * _COMMON_STD * ratio**1.5 * math.sqrt(total * max(total, 2.0 * growing))
    unseen = open_part * 2.0 * modulus * _HIDDEN_RADIUS_FACTOR * math.sqrt(min(ratio, 1.0)) * cell / step
    border = open_part * _BORDER_STD * modulus * _measure_hidden_border(solution)
    return EdgeCorrection(correction, math.hypot(by_area, by_cells, alike, unsure, common, unseen, border))


def _measure_hidden_border(solution: ContactSolution) -> float:
    """Return the length of the free borders at which there is a contact that no centre of a cell is in, m.

    The gap, continued to the border, vanishes there, away from the cells in contact.
    """
    if not solution.boundary.has_free_axis:
        return 0.0
    away = ~grow(solution.contact, _HIDDEN_BORDER_CELLS, solution.boundary)
    length = 0.0
    for axis, cells in enumerate(away.shape):
        if solution.boundary.free_axes[axis] and cells > 1:
            hidden = np.zeros_like(away)
            gap, open_, marked = (np.moveaxis(field, axis, 0) for field in (solution.gap, away, hidden))
            for outer, inner in ((0, 1), (-1, -2)):
                marked[outer] = open_[outer] & open_[inner] & (3.0 * gap[outer] <= gap[inner])
            length += np.count_nonzero(solution.parts.own(hidden)) * solution.grid.spacing[1 - axis]
    return float(solution.parts.total(length))


def _bound_loss(correction: Array, stiffness: Array, growing: Array) -> Array:
    """Return the corrections, whose negative ones leave a positive stiffness: near full contact the compliance grows.

    The stiffness of a spot grows with the root of its area, to which the correction is linear. Where it grows much
    faster, its inverse vanishes with the open area: linear to it, dS becomes dS / (1 - dS / S).
    """
    power = growing / np.maximum(stiffness, 1e-300)
    beyond = np.clip(1.0 - 0.5 / np.maximum(power, 0.5), 0.0, 1.0)
    loss = np.maximum(-correction / np.maximum(stiffness, 1e-300), 0.0)
    return np.asarray(correction / (1.0 + beyond * loss))


def edge_length(grid: Grid) -> float:
    """Return the inverse of the wave number at an edge of a contact, m."""
    return MODULUS_LENGTH * math.sqrt(grid.resolved.cell_area)


def _find_trust(solution: ContactSolution, ratio: float) -> float:
    """Return the fraction of the correction that the resolution allows: all of it at sharp edges, as of punches."""
    trust = 1.0 / (1.0 + (ratio / _HALF_TRUST_RATIO) ** 4)
    if trust > _MIN_FULL_TRUST:
        return trust
    sides = count_sides(solution)
    sharp = count_sides(solution, find_sharp_edges(solution))
    return max(trust, sharp / sides) if sides else trust


def _find_areas(solution: ContactSolution, cells_of: Array, acting: Array, area: Area) -> Array:
    """Return the areas inside the edges between the cells, m2, less saturated cells unless `cells_of` counts them."""
    if area.patches is None:
        return acting
    saturated = (solution.patches.cells - cells_of) * solution.grid.cell_area
    return np.asarray(np.maximum(area.patches - saturated, 0.0))


def _measure_rows(solution: ContactSolution, answer: Array, cells: Mask) -> tuple[Array, Array, Array, Array]:
    """Return the area loss of each patch, cells; the length of its sides, m; sum and integral of q^2 over them."""
    width = solution.patches.count + 1
    spacing = solution.grid.spacing
    free = solution.boundary.free_axes
    found: list[tuple[IntArray, IntArray, Array]] = []
    cells_in_lines = []
    for axis in (0, 1):
        # Rows of sides that face x lie along y, and the other way round.
        label, field = (solution.parts.lines(values, axis).ravel() for values in (solution.patches.labels, answer))
        for step in (-1, 1):
            open_ = ~_shift(solution.contact, step, axis, free=free[axis])
            facing = solution.parts.lines(cells & open_, axis)
            at = np.flatnonzero(facing)
            found.append((at, label.take(at), field.take(at)))
            cells_in_lines.append(facing.shape[1])
    at, label, field = (np.concatenate(one) for one in zip(*found, strict=True))
    group = np.repeat(np.arange(len(found)), [one[0].size for one in found])
    longest = np.array(cells_in_lines)
    repeating = np.where(np.repeat(free[::-1], 2), 0, longest)
    line = at // longest[group]
    place = at - line * longest[group]
    # Lines of another group are other ones.
    starts, lengths = _find_rows(line * len(found) + group, place, repeating[group])
    of_rows = group[starts]
    loss = np.empty(starts.size)
    for axis in (0, 1):
        rows = of_rows // 2 == axis
        loss[rows] = _find_loss(lengths[rows], cells_in_lines[2 * axis], spacing[axis] / spacing[1 - axis])
    owner = group * width + label
    size = len(found) * width
    side = np.repeat(spacing[::-1], 2)[:, np.newaxis]
    lost, count, squares = (
        np.bincount(of, weights=values, minlength=size).reshape(-1, width)
        for of, values in ((owner[starts], loss), (owner, None), (owner, field**2))
    )
    sums = np.stack([one.sum(axis=0) for one in (lost, side * count, squares, side * squares)])
    lost, sides, squares, along = solution.parts.total(sums[:, 1:])
    return lost, sides, squares, along


def _shift(mask: Mask, step: int, axis: int, *, free: bool) -> Mask:
    """Return which cells have a marked neighbour on one side along an axis; beyond a free border there is none."""
    moved = np.roll(mask, step, axis=axis)
    if free:
        np.moveaxis(moved, axis, 0)[0 if step == 1 else -1] = False
    return moved


def _find_rows(i: IntArray, j: IntArray, periods: IntArray | int) -> tuple[IntArray, IntArray]:
    """Return where rows of adjacent sides at (i, j) begin, and their lengths.

    Rows across the border are joined in lines that repeat after so many cells; zero for lines that do not.
    """
    starts = np.flatnonzero(np.concatenate(([i.size > 0], (np.diff(i) != 0) | (np.diff(j) != 1))))
    lengths = np.diff(np.append(starts, i.size))
    period = np.broadcast_to(periods, i.shape)[starts]
    lines = i[starts]
    first = j[starts]
    parted = lengths < period
    heads = np.flatnonzero(parted & (first == 0))
    tails = np.flatnonzero(parted & (first + lengths == period))
    head_of = np.full(int(lines.max(initial=0)) + 1, -1)
    head_of[lines[heads]] = heads
    joined = head_of[lines[tails]]
    tails = tails[joined >= 0]
    joined = joined[joined >= 0]
    lengths[tails] += lengths[joined]
    kept = np.ones(starts.size, dtype=bool)
    kept[joined] = False
    return starts[kept], lengths[kept]


def _find_loss(lengths: IntArray, longest: int, aspect: float) -> Array:
    """Return the area loss of rows, in cells; a row across the whole domain has no ends."""
    ends = _KINK_LOSS * aspect**_ASPECT_EXPONENT * np.log(lengths) + _END_LOSS
    return np.asarray(_ROW_LOSS * lengths - np.where(lengths < longest, ends, 0.0))


def _unloading(value: bool) -> bool:
    return flag(value, "unloading=")


@responses.register("stiffness")
@attrs.frozen
class Stiffness(Response[Estimate]):
    r"""Normal stiffness :math:`S = dF/d\delta`, N/m, by the linear answer to a unit approach.

    .. math:: K_{AA}\, q = 1, \qquad S = q \cdot (1 + r)\, \Delta x \Delta y + dS

    with the cells A in contact below the pressure limit, the residual :math:`r = 1 - K q`, so that the error is
    the square of the residual, and the correction dS of the edge (`roughcontact._answers.linear.stiffness`). Where
    surfaces attract each other open cells answer too, by the slope of the law (`LinearisedGap`), and the stiffness may
    be negative. Over
    ``solution.grid.area`` it is the stiffness of the interface, Pa/m. It is infinite in full contact on a periodic
    boundary, and zero where no cell is in contact below the limit.

    Parameters
    ----------
    unloading
        Whether the load falls. What has flowed is then elastic, and A is all cells in contact.

    References
    ----------
    Barber, Proc. R. Soc. A 459 (2003) 53-66, https://doi.org/10.1098/rspa.2002.1038
    """

    unloading: bool = attrs.field(default=False, converter=_unloading)

    holds_with = frozenset({"tension", "shear"})
    flagged_factors = 0.5, 0.1

    @property
    def fails_with(self) -> frozenset[str]:  # type: ignore[override]
        """What it does not know of laws: other moduli below the surface, and flow there unless the load falls."""
        return frozenset({"inner moduli"} if self.unloading else {"inner moduli", "inner flow"})

    def respond(self, solution: ContactSolution) -> Estimate:
        """Return the stiffness; see `Response.respond`."""
        normal = find_normal_answer(solution, "stiffness", unloading=self.unloading)
        sampling = defer_stiffness_sampling(solution, normal.value)
        return Estimate(normal.value, normal.uncertainty, "N/m", normal.warnings, relative_sampling=sampling)


@responses.register("stability")
@attrs.frozen
class StabilityMargin(Response[Estimate]):
    r"""How far surfaces that attract each other are from a jump: 1 far away, 0 at one, negative where unstable.

    It is the lowest eigenvalue of :math:`Z (M + s'(g))` on the open cells, with the stiffness M of the surface, the
    slope s' of the law and a preconditioner Z that is 1/M for short waves, found by 30 steps of Lanczos' method.
    """

    holds_with = frozenset({"tension", "shear"})

    def respond(self, solution: ContactSolution) -> Estimate:
        """Return the margin; see `Response.respond`."""
        margin = find_stability(problem_of(solution), solution)
        jump = describe_jump(margin)
        return Estimate(margin, _MARGIN_STD * abs(margin), "", () if jump is None else (jump,))


@attrs.frozen(eq=False)
class NormalAnswer:
    """The answer to a unit approach.

    Attributes
    ----------
    field
        Change of the pressure, shape (nx, ny), Pa/m; zero where the stiffness is infinite.
    value, uncertainty
        The stiffness, its integral over the corrected area, and its standard deviation, N/m.
    warnings
        Why it must not be trusted, in sentences.
    """

    field: Array
    value: float
    uncertainty: float
    warnings: tuple[str, ...]


def find_normal_answer(solution: ContactSolution, what: str, *, unloading: bool = False) -> NormalAnswer:
    """Return the answer of the contact to a unit approach; messages name the number `what`.

    Cells at the pressure limit yield, but on unloading.
    """
    require_mean_gap(solution, what)
    area = solution.area(uncertainty="model")
    warnings = pass_on_warnings(area)
    tangent = _find_elastic_tangent(solution) if unloading and solution.capped else tangent_of(solution)
    unit = np.ones(solution.contact.shape)
    if tangent.is_rigid:
        return NormalAnswer(0.0 * unit, math.inf, 0.0, (*warnings, describe_full_contact(what)))
    answer = tangent.solve(unit, _RESIDUAL_TOLERANCE if solution.tension is None else _ADHESIVE_TOLERANCE)
    jump = describe_jump(answer.margin)
    warnings = warnings if jump is None else (*warnings, jump)
    value = answer.product * solution.grid.cell_area
    std = 0.0
    if solution.parts.total(np.count_nonzero(solution.parts.own(tangent.cells))):
        modulus = float(solution.effective_modulus(1.0 / edge_length(solution.grid)))
        correction = correct_edges(solution, answer.values, tangent.cells, area, 0.0, modulus)
        value += float(correction.patches.sum())
        std = correction.uncertainty * (1.0 if ends_as_root(solution) else _WORN_STD)
    if solution.tension is not None:
        std = math.hypot(std, _find_pull_std(solution, answer.values, value))
    return NormalAnswer(answer.values, value, std, warn_if_uncertain(value, std, "N/m", warnings).warnings)


def _find_elastic_tangent(solution: ContactSolution) -> Tangent:
    """Return the linear answer of all cells in contact; `InputError` where it is not known."""
    if solution.tension is not None:
        raise InputError("The stiffness on unloading of surfaces that attract each other is that of two states.")
    return Tangent(solution, saturated=True)


def _find_pull_std(solution: ContactSolution, answer: Array, value: float) -> float:
    """Return the standard deviation of a stiffness by the cells in which open surfaces attract each other, N/m."""
    law = problem_of(solution).plan.interaction
    pull = np.abs(answer[~solution.contact])
    total = float(pull.sum())
    if law is None or total == 0.0:
        return 0.0
    # Cells that pull alike in a ring around the contact, whose sides are 4/pi times its length.
    count = total**2 / float(np.einsum("i,i->", pull, pull))
    width = count / (0.25 * math.pi * max(count_sides(solution), 1))
    cells = law.cohesive_cells(solution.grid.resolved.spacing, solution.surface_modulus)
    stuck = _STUCK_STD * math.exp(-_STUCK_FALL * cells)
    return math.hypot(_PULL_STD * total * solution.grid.cell_area / width, stuck * value)


def require_mean_gap(solution: ContactSolution, what: str) -> None:
    """Raise `InputError` on a wrapped boundary, where the displacement by uniform pressure is arbitrary."""
    if solution.boundary is Boundary.WRAPPED:
        raise InputError(
            f"On a wrapped boundary uniform pressure moves the surfaces by an arbitrary amount, so that the {what} "
            f"means nothing: choose {argument('boundary', 'periodic')} or 'free'."
        )


def describe_full_contact(what: str) -> WarningText:
    """Return the warning that a number, named by `what`, is infinite in full contact on a periodic boundary."""
    text = f"the surfaces touch everywhere, so that the interface yields nothing and its {what} is infinite"
    return WarningText(text, "full contact")


@responses.register("pull-off")
@attrs.frozen
class PullOff(Response[Estimate]):
    """Force at which surfaces that attract each other come apart, negative: the minimum on unloading from zero load.

    It is that of the problem, whatever the load of the solution; see `ContactProblem.pull_off`.
    """

    holds_with = frozenset({"tension", "shear"})

    def respond(self, solution: ContactSolution) -> Estimate:
        """Return the force, N; see `Response.respond`."""
        return find_pull_off_once(problem_of(solution))


def find_pull_off_once(problem: ContactProblem, on_state: OnStateToPullOff | None = None) -> Estimate:
    """Return the force of pull-off of a problem, N, which is followed once; see `find_pull_off`."""
    key = key_of(problem.parts)
    if key not in _FOUND:
        found = find_pull_off(problem, on_state)
        while len(_FOUND) >= _MOST_KEPT:
            del _FOUND[next(iter(_FOUND))]
        _FOUND[key] = found
    return _FOUND[key]
