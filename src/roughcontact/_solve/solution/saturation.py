"""The part of the contact where the pressure has reached its limit."""

from __future__ import annotations

from typing import TYPE_CHECKING

import attrs
import numpy as np

from roughcontact._base.warnings import ContactWarning
from roughcontact._solve.solution.results import Area, AreaEstimator, areas

if TYPE_CHECKING:
    from roughcontact._solve.solution.contact import ContactSolution

# A pressure this close to the limit, relative to it, counts as the limit; a gap up to this times the scale, as zero.
_CLOSE = 1e-4
# Fraction of the pressure limit above which a cell, whose pressure is a mean, may hold saturated points.
_NEAR = 0.95
# Fraction of the saturated area that may be undecided without a warning.
_UNDECIDED = 0.05
# Standard deviation of the position of the edge of saturated cells beyond that of the edge of the rest, cells: the
# elastic ring around them is narrow. Measured on 60 balls whose maximum pressure by Hertz is 1.15 to 2.5 times it.
_EDGE = 0.055
_RUN_IN = ContactWarning(
    "cells at the pressure limit hardly overlap, as on run-in surfaces: their saturated part is not determined",
    "run in",
)


def estimate_saturated_area(solution: ContactSolution, estimator: str | AreaEstimator) -> Area:
    """Return the saturated area; see `ContactSolution.saturated_area`."""
    name = str(estimator) if isinstance(estimator, str) else type(estimator).__name__
    areas.resolve(estimator)
    if not solution.saturated.any():
        # A cell whose mean pressure is near the limit may hold a point that has reached it.
        near = int(np.count_nonzero(solution.pressure > _NEAR * solution.pressure_limit)) * solution.grid.cell_area
        return Area(0.0, 0.0, near, name, perimeter=0.0)
    complement = attrs.evolve(
        solution,
        pressure=solution.pressure_limit - solution.pressure,
        displacement=-solution.displacement,
        initial_gap=-solution.initial_gap,
        approach=-solution.approach,
    )
    rest = complement.area(estimator)
    # A larger saturated area would carry more than the load.
    admissible = float(np.sum(solution.pressure / solution.pressure_limit)) * solution.grid.cell_area
    value = min(solution.grid.area - rest.value, admissible)
    undecided = _undecided(solution)
    warnings = rest.warnings
    if undecided > _UNDECIDED * value:
        warnings += (_RUN_IN,)
    edge = _EDGE * rest.perimeter * float(np.sqrt(solution.grid.cell_area)) if np.isfinite(rest.perimeter) else 0.0
    uncertainty = float(np.hypot(np.hypot(rest.uncertainty, undecided), edge))
    fraction = value / solution.grid.area
    return attrs.evolve(rest, value=value, fraction=fraction, uncertainty=uncertainty, warnings=warnings, patches=None)


def _undecided(solution: ContactSolution) -> float:
    """Return the area of the cells at the limit whose gap is zero within the residual, m2: saturated or not."""
    at_limit = solution.pressure > (1.0 - _CLOSE) * solution.pressure_limit
    closed = np.abs(solution.gap) <= _CLOSE * solution.residuals.scale
    return int(np.count_nonzero(at_limit & closed)) * solution.grid.cell_area
