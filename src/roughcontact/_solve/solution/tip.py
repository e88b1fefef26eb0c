"""What the tip of a stylus has not touched, in the answers of a contact on a map that was restored below it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, TypeVar

import attrs
import numpy as np

from roughcontact._base.arrays import Array, Mask
from roughcontact._base.units import Estimate, WarningText, percent
from roughcontact._parts.grid import Grid
from roughcontact._solve.solution.results import Area

E = TypeVar("E", bound=Estimate)

# All constants were set on surfaces of known heights, of other draws than those of docs/studies/stylus_tip.py.
# Certain fraction of a contact below which a stylus is too blunt; relative standard deviation of the area over the
# uncertain fraction, and of an area below a tip that is certain, by the cells of the map: restored maps give areas 1, 5
# and 10 % too large where 0.98, 0.85 and 0.7 of the contact are certain.
_MIN_CERTAIN_FRACTION = 0.9
_UNCERTAIN_AREA_STD = 1.0 / 3.0
_CERTAIN_AREA_STD = 0.006
# Relative standard deviations of other answers: below a tip that is certain, and over the uncertain fraction.
_CONTACT_STDS: Mapping[str, tuple[float, float]] = MappingProxyType(
    {
        "approach": (0.002, 0.04),
        "conductance": (0.004, 0.17),
        "patches": (0.0, 0.33),
        "peak-pressure": (0.004, 0.1),
        "perimeter": (0.006, 0.3),
        "stiffness": (0.004, 0.17),
        "tangential-stiffness": (0.004, 0.17),
    }
)
# Standard deviation of the mean depth of a surface below its restored map, over the mean square of the distance to the
# next certain point and the sharpest bend there, which all but a thousandth of the certain points are below: the depth
# is 0.06 to 0.11 times that on Gaussian surfaces with and without a lay, 0.09 to 0.27 times on plateaus with grooves,
# and 0.04 to 0.06 times below sharp summits.
_DEPTH_STD = 0.15
_SHARPEST = 0.999
# Largest distance that counts, over the median: wide bands are those of borders, mirrored or not measured.
_MAX_DISTANCE = 3.0
# Part of the mean gap by that depth from which valleys are warned of.
_MAX_DEPTH_PART = 0.05
# Answers whose uncertainty counts the depth, a leakage by that of the mean gap.
_OF_GAP = frozenset({"leakage", "mean-gap"})
# Answers that are of the grid or of the heights, not of the contact.
_NOT_OF_CONTACT = frozenset({"flags", "judgement", "noise", "phases"})
# Rule of the warning of a large uncertainty, whose advice is a finer grid.
_RULE_OF_GRID = "uncertainty"


@attrs.frozen
class Untouched:
    """What the tip of a stylus has not surely touched.

    Attributes
    ----------
    contact, points
        Fraction of the contact, and of all points.
    depth
        Standard deviation of the mean depth of the surface below the map, m; nan where it is not known.
    gap
        Mean gap, m.
    """

    contact: float
    points: float
    depth: float
    gap: float

    @property
    def is_blunt(self) -> bool:
        """Whether the summits that carry the load are sharper than the tip."""
        return self.contact > 1.0 - _MIN_CERTAIN_FRACTION

    @property
    def hides_valleys(self) -> bool:
        """Whether the mean gap may be much larger than that of the map."""
        return not self.depth <= _MAX_DEPTH_PART * self.gap

    @property
    def text(self) -> str:
        """What the tip has touched."""
        contact, points = (percent(1.0 - part) for part in (self.contact, self.points))
        return f"the tip of the stylus has surely touched {contact} of the contact and {points} of the points"


def find_untouched(solution: Any) -> Untouched | None:
    """Return what the tip has not touched of the surfaces of a solution, found once; None without a tip."""
    found: Untouched | None = solution._keep("untouched", lambda: _find_untouched(solution))
    return found


def _find_untouched(solution: Any) -> Untouched | None:
    uncertain = None if solution.origin is None else solution.origin.find_uncertain(solution.grid, solution._shift)
    if uncertain is None:
        return None
    whole = solution.parts
    contact = whole.own(solution.contact)
    count = whole.total(int(np.count_nonzero(contact)))
    lost = whole.total(int(np.count_nonzero(contact & uncertain[whole.rows(np.arange(len(contact)))])))
    depth = math.nan
    gap = math.nan
    if whole.is_whole:
        heights = -solution.initial_gap
        if solution.non_measured is not None:
            heights = np.where(solution.non_measured, np.nan, heights)
        depth = measure_depth(heights, uncertain, solution.grid)
        gap = float(np.mean(np.maximum(solution.gap, 0.0)))
    return Untouched(lost / count if count else 0.0, float(uncertain.mean()), depth, gap)


def measure_depth(heights: Array, uncertain: Mask, grid: Grid) -> float:
    r"""Return the standard deviation of the mean depth of a surface below its restored map, m.

    Below a ball that touches two summits the surface may have any depth. As sharp in its valleys as where it was
    touched it lies by :math:`d^2 \kappa` times a factor lower at the distance d from the next certain point, with the
    sharpest bend :math:`\kappa`, of z_xx + z_yy, at certain points. A band at a border without any certain point is
    taken for as deep as the rest.

    Parameters
    ----------
    heights
        Heights of the map, shape (nx, ny), m; nan where nothing was measured.
    uncertain
        Points that the tip has not surely touched, of the same shape.
    grid
        Their cells.
    """
    from scipy.ndimage import distance_transform_edt

    if uncertain.all():
        return float(np.nanmax(heights) - np.nanmin(heights))
    known = [np.flatnonzero(~uncertain.all(axis=1 - axis)) for axis in (0, 1)]
    inner = tuple(slice(rows[0], rows[-1] + 1) for rows in known)
    bend = np.zeros(heights.shape)
    for axis, side in enumerate(grid.spacing):
        if heights.shape[axis] > 1:
            bend += (np.roll(heights, 1, axis) + np.roll(heights, -1, axis) - 2.0 * heights) / side**2
    distances = distance_transform_edt(uncertain[inner], sampling=grid.spacing)
    within = distances[distances > 0.0]
    if not within.size:
        return 0.0
    distances = np.minimum(distances, _MAX_DISTANCE * float(np.median(within)))
    touched = np.abs(bend[~uncertain])
    sharpest = float(np.quantile(touched[np.isfinite(touched)], _SHARPEST))
    return _DEPTH_STD * float(np.mean(distances**2)) * sharpest


def judge_area_by_tip(area: Area, solution: Any) -> Area:
    """Return an area with its certain fraction, which widens its uncertainty; the same without a tip.

    Where a tip has not touched, the restored surface is too high and the area too large.
    """
    found = find_untouched(solution)
    if found is None or not solution.parts.total(int(np.count_nonzero(solution.parts.own(solution.contact)))):
        return area
    warnings = area.warnings
    if found.is_blunt:
        text = (
            f"the tip of the stylus has surely touched only {percent(1.0 - found.contact)} of the contact: it is "
            "blunter than the summits that carry the load, and the area is too large; measure with a sharper one"
        )
        warnings = (*warnings, WarningText(text, "stylus tip", 1.0 - found.contact))
    return widen_area_by_tip(attrs.evolve(area, warnings=warnings, certain_fraction=1.0 - found.contact))


def widen_area_by_tip(area: Area) -> Area:
    """Return an area whose uncertainty has that of its surface below a tip too, where there was one."""
    if area.certain_fraction is None:
        return area
    lost = _UNCERTAIN_AREA_STD * (1.0 - area.certain_fraction)
    return attrs.evolve(
        area, uncertainty=math.hypot(area.uncertainty, lost * area.value, _CERTAIN_AREA_STD * area.value)
    )


def judge_by_tip(found: E, solution: Any, name: str) -> E:
    """Return a number of a registered name with what a tip has not touched in its uncertainty, or a warning of that."""
    untouched = find_untouched(solution)
    if untouched is None or name in _NOT_OF_CONTACT:
        return found
    std = found.uncertainty
    warnings = list(found.warnings)
    if name in _CONTACT_STDS:
        certain, lost = _CONTACT_STDS[name]
        std = math.hypot(std, certain * found.value, lost * untouched.contact * found.value)
    if name == "mean-gap" and math.isfinite(untouched.depth):
        std = math.hypot(std, untouched.depth)
    if name in _OF_GAP and untouched.hides_valleys:
        # A finer grid does not help.
        warnings = [text for text in warnings if getattr(text, "rule", "") != _RULE_OF_GRID]
        text = (
            f"the tip of the stylus has surely touched only {percent(1.0 - untouched.points)} of the points: valleys "
            "are deeper than the map, and this number is too small; measure with a sharper one"
        )
        warnings.append(WarningText(text, "stylus valleys", 1.0 - untouched.points))
    is_counted = name in _CONTACT_STDS or (name in _OF_GAP and math.isfinite(untouched.depth))
    if untouched.is_blunt and is_counted and not any(getattr(text, "rule", "") == "stylus tip" for text in warnings):
        text = f"{untouched.text}: it is blunter than the summits that carry the load; measure with a sharper one"
        warnings.append(WarningText(text, "stylus tip", 1.0 - untouched.contact))
    if not is_counted and (untouched.is_blunt or untouched.hides_valleys):
        text = f"the uncertainty does not count that {untouched.text}"
        warnings.append(WarningText(text, "stylus tip, not counted", 1.0 - untouched.contact))
    return attrs.evolve(found, uncertainty=std, warnings=tuple(warnings))


def warn_of_tip(solution: Any) -> tuple[str, ...]:
    """Return a warning of a solution whose fields are those of a map that differs from the surface."""
    untouched = find_untouched(solution)
    if untouched is None or not (untouched.is_blunt or untouched.hides_valleys):
        return ()
    text = (
        f"{untouched.text[0].upper()}{untouched.text[1:]}: between them the surface lies lower than the map. The "
        "uncertainties of area, maximum pressure, stiffness and mean gap count that; fields and stresses do not."
    )
    return (WarningText(text, "stylus", 1.0 - untouched.contact),)
