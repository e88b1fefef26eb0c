"""The conditions of an adhesive contact, measured on a pressure and a tension.

With the displacement u by the pressure p, the initial gap h, the gap g = u + h - approach and the tension t, the
contact pressure is c = p + t. The exact solution satisfies g = 0 where c > 0 and p is below its limit, g >= 0 and
t = s(g), the law of the interaction, where c = 0, and g <= 0 where p is at its limit.
"""

from __future__ import annotations

import math

import attrs
import numpy as np

from roughcontact._base.arrays import Array, Mask
from roughcontact._base.units import Estimate, WarningText, si
from roughcontact._parts.grid import Boundary, Grid, extend, grow
from roughcontact._parts.interactions import BoundInteraction, Interaction, ShortRange
from roughcontact._solve.solution.fields import ContactFields
from roughcontact._solve.solution.origin import Origin
from roughcontact._solve.solution.results import Area

# Rounding of the gap over its largest term, as in `conditions`.
_ROUNDING = 16.0 * float(np.finfo(np.float64).eps)
# Displacement over the contact pressure, in the units of a `Task`, below which what causes it may be what is left of
# contact pressure and tension in float32.
_CANCELLED = 1e-6


@attrs.frozen
class AdhesiveViolation:
    """The amount by which a pressure and a tension violate the conditions of contact, and the approach they imply.

    Attributes
    ----------
    approach
        The approach, given or implied by the contact pressure.
    complementarity
        Mean of the gaps that should vanish, weighted by the contact pressure, over `scale`.
    penetration
        Maximum overlap outside the saturated cells, over `scale`.
    tension
        Maximum difference between the tension and the law at the gap, over the strength of the law.
    gap
        The same difference over the maximum slope of the law and `scale`: how far the gap is off.
    bounds
        Maximum amount by which the pressure leaves its bounds, minus the strength and the limit, over the strength.
    scale
        The smaller of the standard deviation of the initial gap and, in contact, the range of the displacement.
    floor
        The error that rounding in float64 may cause on these fields, over `scale`.
    """

    approach: float
    complementarity: float
    penetration: float
    tension: float
    gap: float
    bounds: float
    scale: float
    floor: float

    @property
    def error(self) -> float:
        """The maximum of the errors of the gap: complementarity, penetration, `gap` and `floor`."""
        return max(self.complementarity, self.penetration, self.gap, self.floor)


@attrs.frozen(eq=False, kw_only=True)
class AdhesiveConditions:
    """The conditions of one adhesive contact, in float64 and in the units of a `Task`.

    Parameters
    ----------
    initial_gap
        Gap before deformation, shape (nx, ny).
    interaction
        The law.
    pressure_limit
        Maximum pressure, which broadcasts to (nx, ny); `inf` where there is none.
    approach
        The approach if it is given; None if the load is.
    rms
        The standard deviation of the initial gap, if it is not that of all cells.
    """

    initial_gap: Array
    interaction: BoundInteraction
    pressure_limit: Array = attrs.field(factory=lambda: np.array(math.inf))
    approach: float | None = None
    rms: float | None = None

    def measure(self, pressure: Array, tension: Array, displacement: Array) -> AdhesiveViolation:
        """Return the violation by a pressure and a tension, and the displacement by the pressure, shape (nx, ny).

        Unless it is given, the approach is the mean of u + h weighted by the contact pressure of the cells that are
        not saturated; without such cells, the value at which the highest cell touches.
        """
        contact = np.maximum(pressure + tension, 0.0)
        saturated = pressure >= self.pressure_limit
        elastic = np.where(saturated, 0.0, contact)
        approach = self._find_approach(elastic, saturated, displacement)
        gap = displacement + self.initial_gap
        gap -= approach
        closing = np.where(saturated, np.maximum(gap, 0.0), gap)
        carried = float(contact.sum())
        opened = float(np.einsum("ij,ij->", contact, np.abs(closing))) / carried if carried > 0.0 else 0.0
        overlap = max(0.0, -float(closing.min()))
        scale = self._find_scale(displacement, contact, carried)
        off = self._tension_error(gap, tension, contact)
        strength = float(np.max(self.interaction.strength))
        below = float((-np.asarray(self.interaction.strength) - pressure).max())
        above = float((pressure - self.pressure_limit).max())
        largest = max(float(np.abs(displacement).max()), float(np.abs(pressure).max()), abs(approach))
        return AdhesiveViolation(
            approach=approach,
            complementarity=opened / scale,
            penetration=overlap / scale,
            tension=off / strength,
            gap=off / (self.interaction.steepest * scale),
            bounds=max(0.0, below, above) / strength,
            scale=scale,
            floor=_ROUNDING * largest / scale,
        )

    def _find_approach(self, elastic: Array, saturated: Mask, displacement: Array) -> float:
        if self.approach is not None:
            return self.approach
        load = float(elastic.sum())
        if load > 0.0:
            return float(np.einsum("ij,ij->", elastic, displacement + self.initial_gap)) / load
        moved = displacement + self.initial_gap
        return float(moved[saturated].max()) if saturated.any() else float(moved.min())

    def _find_scale(self, displacement: Array, contact: Array, carried: float) -> float:
        rms = float(self.initial_gap.std()) if self.rms is None else self.rms
        if carried == 0.0 and rms > 0.0:
            # Surfaces that do not touch may hardly deform.
            return rms
        moved = float(displacement.max() - displacement.min())
        # Where contact pressure and tension cancel, as below a flat pad without a load, the rest is rounding.
        elastic = moved if moved > _CANCELLED * float(contact.max()) else 0.0
        return min(rms, elastic) or max(rms, elastic) or 1.0

    def _tension_error(self, gap: Array, tension: Array, contact: Array) -> float:
        """Return the maximum difference of the tension from the law: at the gap of open cells, at zero in contact."""
        law = self.interaction.tension(np.where(contact > 0.0, 0.0, np.maximum(gap, 0.0)))
        return float(np.abs(law - tension).max())


# Cells of the cohesive length from which pull-off is right to 0.5 %, and below which states are stuck to the cells:
# pull-off is too strong, by 80 % exp(-2 cells) root mean square over the places of balls of 1.2 to 3.6 cells, up to
# twice that where the centre lies on a symmetry of the cells.
RESOLVED_CELLS = 2.5
TRAPPED_CELLS = 1.5
# Relative standard deviation of the area because the contact pressure varies over the cohesive length at its edge: this
# number over the cells of that length and the root of the cells of a patch, on 200 balls and 50 rough surfaces in
# random places (benchmarks/adhesion_classes.py). Because it sticks to the cells: on a ball of 0.5 and one of 1 cell.
_EDGE_ERROR = 0.2
_STUCK_AREA = 1.6
_STUCK_DECAY = 4.0
# Relative standard deviation of the area in the limit of a short range, over a power of the radius of a patch in cells:
# the radius of balls of 7 to 40 cells under no load is 8.5 to 2.9 % below that of Johnson, Kendall and Roberts.
_LIMIT_AREA = 0.45
_LIMIT_AREA_EXPONENT = -0.7
# Tension at a free border over the strength from which the domain cuts off what counts.
_MAX_BORDER_TENSION = 1e-3
# Cells of the cohesive length below which pull-off is too strong by a factor, about the root of this number over them.
_FACTOR_CELLS = 0.84
# Standard deviation of the mean gap over the mean bend of the gap in and around the contact, the second differences
# along both axes together, on 75 rough surfaces: summits lie between the cells.
_MISSED_SUMMIT = 0.05


def trapping_error(cells: float) -> float:
    """Return the relative error of the force of pull-off because the edge of the contact sticks to the cells."""
    return 0.8 * math.exp(-2.0 * cells)


def count_patch_cells(mask: Mask, boundary: Boundary) -> float:
    """Return the number of cells of a mask, at most that of a disc of the same ratio of area to edge; one at least."""
    cells = np.count_nonzero(mask)
    border = np.count_nonzero(mask & grow(~mask, 1, boundary))
    disc = 4.0 * math.pi * (cells / border) ** 2 if border else math.inf
    return max(min(disc, float(cells)), 1.0)


def widen_area(area: Area, solution: ContactFields, origin: Origin) -> Area:
    """Return an area with the uncertainty by the size of the cells beside that of its estimator."""
    cells = _count_cohesive_cells(solution, origin)
    if cells is None or area.value == 0.0:
        return area
    size = count_patch_cells(solution.contact, solution.boundary)
    error = math.hypot(_EDGE_ERROR / (cells * math.sqrt(size)), _STUCK_AREA * math.exp(-_STUCK_DECAY * cells))
    if isinstance(origin.problem["adhesion"], ShortRange):
        # The contact is that of the limit, which the range that the cells resolve makes smaller.
        error = math.hypot(error, _LIMIT_AREA * math.sqrt(size / math.pi) ** _LIMIT_AREA_EXPONENT)
    return attrs.evolve(area, uncertainty=math.hypot(area.uncertainty, error * area.value))


def _count_cohesive_cells(solution: ContactFields, origin: Origin) -> float | None:
    """Return the number of cells of the cohesive length; None without a law."""
    if solution.tension is None or origin.missing:
        return None
    law: Interaction = origin.problem["adhesion"]
    spacing = solution.grid.resolved.spacing
    modulus = solution.surface_modulus
    return law.resolve(spacing, modulus).cohesive_cells(spacing, modulus)


def describe_range(law: Interaction, grid: Grid, modulus: float) -> WarningText | None:
    """Return a warning if the cells do not resolve the range of a law; None if they do."""
    cells = law.cohesive_cells(grid.resolved.spacing, modulus)
    if cells >= RESOLVED_CELLS:
        return None
    side = si(max(grid.resolved.spacing) * cells / RESOLVED_CELLS, "m", 2)
    longer = math.sqrt(RESOLVED_CELLS / cells)
    stuck = "sticks" if cells < TRAPPED_CELLS else "starts to stick"
    factor = math.sqrt(_FACTOR_CELLS / cells)
    error = trapping_error(cells)
    off = f"{100 * error:.2g} % off" if factor < 1.0 + error else f"too strong by a factor of about {factor:.2g}"
    text = (
        f"the cohesive length E*/max|ds/dg| has {cells:.2g} cells, so that the edge of the contact {stuck} to the "
        f"cells and pull-off may be {off}: use cells of at most {side}, or a range {longer:.2g} times as long"
    )
    return WarningText(text, "cohesive length", cells)


def warn_of_attraction(solution: ContactFields, origin: Origin) -> tuple[str, ...]:
    """Return the warnings of the range of the law by which the surfaces attract each other, and of the border, if any.

    A range that is chosen by the cells, as that of `ShortRange`, is an uncertainty of each answer instead.
    """
    if solution.tension is None or origin.missing:
        return ()
    law: Interaction = origin.problem["adhesion"]
    modulus = solution.surface_modulus
    found = [warn_of_border(solution)]
    if law.resolve(solution.grid.resolved.spacing, modulus) is law:
        found.append(describe_range(law, solution.grid, modulus))
    return tuple(filter(None, found))


def warn_of_border(solution: ContactFields) -> WarningText | None:
    """Return a warning if the tension reaches a free border, beyond which it is cut off; None otherwise."""
    ratio, _ = find_cut_tension(solution)
    if ratio <= _MAX_BORDER_TENSION:
        return None
    text = (
        f"the tension at the free border is {100 * ratio:.3g} % of its maximum, and what lies beyond is cut off: "
        "enlarge the domain, or make it periodic if the surface repeats"
    )
    return WarningText(text, "border tension", ratio)


def find_cut_tension(solution: ContactFields) -> tuple[float, float]:
    """Return the largest tension at a free border over the largest of all, and about the force beyond it, N.

    Each line of cells across the border is continued by its fall from the last but one cell to the last, over no more
    cells than are attracted along it before the border. Where the contact itself is cut, its pressure bears most of the
    tension, as within the domain.
    """
    tension = solution.tension
    largest = 0.0 if tension is None else float(tension.max())
    if tension is None or largest == 0.0:
        return 0.0, 0.0
    ratio = 0.0
    force = 0.0
    net = min(abs(solution.force) / (float(tension.sum()) * solution.grid.cell_area), 1.0)
    for axis, free in enumerate(solution.boundary.free_axes):
        rows = np.moveaxis(tension, axis, 0)
        if not free or len(rows) < 2:
            continue
        shares = np.where(np.moveaxis(solution.contact, axis, 0), net, 1.0)
        for inwards, share in ((rows, shares[0]), (rows[::-1], shares[-1])):
            last = inwards[0]
            ratio = max(ratio, float(last.max()) / largest)
            fall = last / np.maximum(np.maximum(inwards[1], last), 1e-300)
            attracted = np.logical_and.accumulate(inwards >= 0.5 * last, axis=0).sum(axis=0)
            force += float(np.sum(share * last * np.minimum(fall / np.maximum(1.0 - fall, 1e-3), attracted)))
    return ratio, min(force * solution.grid.cell_area, abs(solution.force))


def interpolate_peak(solution: ContactFields) -> Estimate:
    """Return the maximum contact pressure, Pa, of the parabolas through the highest cell and its neighbours.

    The load of a patch does not tell it where surfaces attract each other, as it does without adhesion.
    """
    pressure = solution.contact_pressure
    i, j = np.unravel_index(int(pressure.argmax()), pressure.shape)
    highest = float(pressure[i, j])
    around = extend(pressure, 1, solution.boundary)[i : i + 3, j : j + 3]
    rise = 0.0
    for before, after in ((around[0, 1], around[2, 1]), (around[1, 0], around[1, 2])):
        bend = 2.0 * highest - float(before) - float(after)
        rise += (float(after) - float(before)) ** 2 / (8.0 * bend) if bend > 0.0 else 0.0
    # Where the neighbours are much lower the grid does not show the top.
    drop = highest - float(np.mean([around[0, 1], around[2, 1], around[1, 0], around[1, 2]]))
    return Estimate(highest + rise, 0.5 * rise + 0.25 * drop, "Pa")


def average_gap(solution: ContactFields) -> Estimate:
    """Return the mean gap, m, over the cell centres; its uncertainty is that of summits between the cells."""
    gap = np.maximum(solution.gap, 0.0)
    initial = solution.gap - solution.displacement
    around = grow(solution.contact if solution.contact.any() else initial == initial.min(), 1, solution.boundary)
    extended = extend(initial, 1, solution.boundary)
    bend = np.abs(extended[:-2, 1:-1] + extended[2:, 1:-1] - 2.0 * initial)
    bend += np.abs(extended[1:-1, :-2] + extended[1:-1, 2:] - 2.0 * initial)
    missed = _MISSED_SUMMIT * float(bend[around].mean())
    return Estimate(float(gap.mean()), math.hypot(missed, solution.residuals.error * solution.residuals.scale), "m")
