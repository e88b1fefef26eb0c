"""Theories beside a solution, where they hold: Persson's, and with adhesion whether rough surfaces stick."""

from __future__ import annotations

import math
from typing import Any

import attrs
import numpy as np

from roughcontact._base.arrays import Array
from roughcontact._base.units import ShownAsPrinted, si
from roughcontact._parts.grid import Boundary, Grid
from roughcontact._parts.interactions import Interaction
from roughcontact._solve.solution.fields import ContactFields
from roughcontact.reference.roughness import Waves, find_lay, find_shape, transform_waves
from roughcontact.reference.theories import (
    FullContactEnergies,
    PastewkaRobbins,
    PerssonContact,
    evaluate_full_contact,
    evaluate_persson,
    find_persson_area,
)

# Range of theoretical over solved area on isotropic Gaussian surfaces of Hurst exponents 0.3 to 0.8, and the range of
# contact fractions where it holds (docs/studies/persson.py).
_AREA_RATIO_RANGE = (0.65, 0.9)
_CONTACT_RANGE = (0.01, 0.4)
# Surfaces that the theory describes: maximum relative sampling error of the mean square height and slope, ratio of the
# rms slopes along two directions, skewness, kurtosis, and fraction of the mean square slope in waves below four cells.
_MAX_HEIGHT_ERROR = 0.35
_MAX_SLOPE_ERROR = 0.15
_MAX_LAY_RATIO = 1.5
_MAX_SKEWNESS = 0.6
_KURTOSIS_RANGE = (2.0, 4.5)
_MAX_UNRESOLVED_FRACTION = 0.3
# Relative standard deviation of the area of one patch at a given load, from random scenes.
_PATCH_AREA_STD = 0.25
# Maximum cells of a grid whose spectrum is computed by default: 0.6 s.
_MAX_CELLS = 2**22


@attrs.frozen(eq=False)
class TheoryBeside(ShownAsPrinted):
    """Persson's theory for the surface and load of a solution.

    Attributes
    ----------
    contact
        The contact of the theory at the mean pressure of the solution.
    area_ratio
        Its area over the solved one.
    gap_ratio
        Its mean gap over the solved one; nan in full contact.
    departure
        Distance of `area_ratio` from the range of 0.65 to 0.9, in standard deviations by sampling, few patches and the
        solved area; zero inside, and if the range does not apply.
    """

    contact: PerssonContact
    area_ratio: float
    gap_ratio: float
    departure: float

    def __str__(self) -> str:
        area = float(self.contact.area_fraction)
        gap = float(self.contact.mean_gap)
        beside = "" if math.isnan(self.gap_ratio) else f" ({self.gap_ratio:.2f} of the solved)"
        return f"area {100.0 * area:.3g} % ({self.area_ratio:.2f} of the solved), mean gap {si(gap, 'm')}{beside}"


def compare_with_theory(solution: Any) -> TheoryBeside | None:
    """Return the theory beside a solution, or None if it does not hold: see `ContactSolution.theory`."""
    area = compare_areas(solution)
    # The waves take as much memory as the fields, so that they are not kept.
    waves = None if area is None else _find_waves(solution.initial_gap, solution.grid)
    if area is None or waves is None:
        return None
    contact = evaluate_persson(waves, solution.modulus, np.asarray(solution.mean_pressure))
    gap = float(np.mean(solution.gap))
    gap_ratio = float(contact.mean_gap) / gap if gap > solution.residuals.scale * 1e-3 else math.nan
    return TheoryBeside(contact, area.ratio, gap_ratio, area.departure)


@attrs.frozen
class AreaBeside:
    """The area of Persson's theory over that of a solution, and its departure; see `TheoryBeside`."""

    ratio: float
    departure: float


def compare_areas(solution: Any) -> AreaBeside | None:
    """Return the area of the theory beside that of a solution, without its gap; None if it does not hold."""
    found: AreaBeside | None = solution._keep("area beside theory", lambda: _compare_areas(solution))
    return found


def _compare_areas(solution: Any) -> AreaBeside | None:
    if not _is_alone(solution) or not _has_spectrum(solution) or not solution.contact.any():
        return None
    waves = _find_waves(solution.initial_gap, solution.grid)
    if waves is None:
        return None
    area = solution.area()
    ratio = find_persson_area(waves, solution.modulus, solution.mean_pressure) / area.fraction
    departure = 0.0
    if _CONTACT_RANGE[0] <= area.fraction <= _CONTACT_RANGE[1]:
        nearest = min(max(ratio, _AREA_RATIO_RANGE[0]), _AREA_RATIO_RANGE[1])
        square = waves.square
        sampling = waves.spread(square) / waves.sum(square)
        few = _PATCH_AREA_STD / math.sqrt(solution.patches.count)
        departure = abs(ratio - nearest) / (nearest * math.hypot(sampling, few, area.uncertainty / area.value))
    return AreaBeside(ratio, departure)


def _is_alone(solution: Any) -> bool:
    """Return whether nothing acts beside the pressure, on whole fields, and no load before has changed the surfaces."""
    alone = solution.tension is None and not solution.added and not solution._is_changed
    return alone and bool(solution.parts.is_whole)


@attrs.frozen(eq=False)
class Stickiness(ShownAsPrinted):
    """What theory says of rough surfaces that attract each other: whether they stick, and what full contact costs.

    Attributes
    ----------
    criterion
        The criterion of Pastewka and Robbins; None where the surface is not isotropic, Gaussian roughness of many waves
        that the grid resolves, where loads before have changed it, or the range exceeds the heights around a contact
        patch.
    full_contact
        The energies of full contact by Persson and Tosatti.
    work
        Work of adhesion, J/m2.
    """

    criterion: PastewkaRobbins | None
    full_contact: FullContactEnergies
    work: float

    def __str__(self) -> str:
        compared = "more" if self.full_contact.released < 0.0 else "less"
        elastic, work = (si(energy, "J/m2", 3) for energy in (self.full_contact.elastic, self.work))
        costs = f"full contact takes {elastic}, {compared} than the work of adhesion, {work} (Persson, Tosatti)"
        if self.criterion is None:
            return costs
        return f"ratio {self.criterion.ratio:.3g}, sticky below 1 (Pastewka, Robbins); {costs}"


def find_stickiness(solution: ContactFields) -> Stickiness | None:
    """Return the theories of adhesion beside a solution; see `ContactSolution.stickiness`."""
    if solution.tension is None or solution.origin is None or solution.origin.missing or not _has_spectrum(solution):
        return None
    given: Interaction = solution.origin.problem["adhesion"]
    law = given.resolve(solution.grid.resolved.spacing, solution.surface_modulus)
    if np.ndim(law.work) or np.ndim(law.strength):
        return None
    work = float(law.work)
    waves = transform_waves(solution.initial_gap, solution.grid)
    energies = evaluate_full_contact(waves, work, solution.modulus)
    return Stickiness(_find_criterion(solution, waves, work, work / float(law.strength)), energies, work)


def _find_criterion(solution: ContactFields, waves: Waves, work: float, reach: float) -> PastewkaRobbins | None:
    if solution._is_changed or not (_is_gaussian(solution.initial_gap) and _is_resolved(waves, solution.grid)):
        return None
    slope = math.sqrt(waves.sum(waves.square)) * waves.height / waves.cell
    curvature = math.sqrt(waves.sum(waves.square**2)) * waves.height / waves.cell**2
    found = PastewkaRobbins(slope, curvature, solution.modulus, work, reach)
    # Else the attracted zones beside the patches, d (3 range / (4 h' d))^(2/3) wide, would meet.
    return found if 0.75 * reach < slope * found.patch_diameter else None


def _has_spectrum(solution: ContactFields) -> bool:
    """Return whether the solution is one of elastic half-spaces whose heights have a spectrum."""
    return bool(
        solution.boundary is Boundary.PERIODIC
        and solution.status.success
        and solution.moduli is None
        and solution.non_measured is None
        and solution.grid.cells <= _MAX_CELLS
        and solution.initial_gap.any()
        and not solution.saturated.any()
    )


def _find_waves(initial_gap: Array, grid: Grid) -> Waves | None:
    """Return the waves of isotropic Gaussian roughness that the grid resolves; None for other surfaces."""
    if not _is_gaussian(initial_gap):
        return None
    waves = transform_waves(initial_gap, grid)
    return waves if _is_resolved(waves, grid) else None


def _is_gaussian(initial_gap: Array) -> bool:
    # The heights are the negative gap, so that their skewness has the other sign.
    skewness, kurtosis = find_shape(initial_gap)
    return abs(skewness) <= _MAX_SKEWNESS and _KURTOSIS_RANGE[0] <= kurtosis <= _KURTOSIS_RANGE[1]


def _is_resolved(waves: Waves, grid: Grid) -> bool:
    """Return whether there are many waves without a lay, most of them longer than four cells."""
    square = waves.square
    slope = waves.sum(square)
    cell = max(grid.resolved.spacing) / grid.spacing[0]
    short = waves.sum(np.where(square > (0.5 * np.pi / cell) ** 2 * (1.0 + 1e-9), square, 0.0))
    few = waves.spread(1.0) > _MAX_HEIGHT_ERROR * waves.sum(1.0) or waves.spread(square) > _MAX_SLOPE_ERROR * slope
    return not few and short <= _MAX_UNRESOLVED_FRACTION * slope and find_lay(waves)[0] <= _MAX_LAY_RATIO
