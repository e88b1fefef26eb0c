"""What a solve returns."""

from roughcontact._solve.solution.contact import ContactSolution
from roughcontact._solve.solution.healing import fill_gap, heal
from roughcontact._solve.solution.origin import Origin
from roughcontact._solve.solution.responses import Response, responses
from roughcontact._solve.solution.results import (
    DEFAULT_AREA,
    Area,
    AreaEstimator,
    Estimate,
    GridLevel,
    QuantityEstimator,
    Residuals,
    Status,
    areas,
    quantities,
)
from roughcontact._solve.solution.writers import SolutionWriter, writers

__all__ = [
    "DEFAULT_AREA",
    "Area",
    "AreaEstimator",
    "ContactSolution",
    "Estimate",
    "GridLevel",
    "Origin",
    "QuantityEstimator",
    "Residuals",
    "Response",
    "SolutionWriter",
    "Status",
    "areas",
    "fill_gap",
    "heal",
    "quantities",
    "responses",
    "writers",
]
