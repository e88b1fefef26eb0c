"""What a solve returns."""

from roughcontact._solve.solution.accuracy import Accuracy, Trial
from roughcontact._solve.solution.conditions import ContactConditions, Violation
from roughcontact._solve.solution.contact import ContactSolution
from roughcontact._solve.solution.fields import ContactFields
from roughcontact._solve.solution.healing import fill_gap, heal
from roughcontact._solve.solution.netcdf import require_netcdf
from roughcontact._solve.solution.origin import Origin, key_of_origin, solution_key, versions
from roughcontact._solve.solution.patches import ContactPatches
from roughcontact._solve.solution.plausibility import exceeds_metals, find_contact, find_scene
from roughcontact._solve.solution.responses import Response, responses
from roughcontact._solve.solution.results import (
    DEFAULT_AREA,
    Area,
    AreaEstimator,
    Estimate,
    GridLevel,
    Residuals,
    Status,
    areas,
)
from roughcontact._solve.solution.rules import PLAUSIBILITY_RULES, Rule
from roughcontact._solve.solution.several import gather_warnings, list_quantities, name_load, note_loads
from roughcontact._solve.solution.storage import read, read_figures, write
from roughcontact._solve.solution.summary import (
    MORE_THAN_METALS,
    describe_maps,
    describe_work,
    list_all_warnings,
    list_answers,
)
from roughcontact._solve.solution.theory import TheoryBeside
from roughcontact._solve.solution.writers import SolutionWriter, page_or_file, writers

__all__ = [
    "DEFAULT_AREA",
    "MORE_THAN_METALS",
    "PLAUSIBILITY_RULES",
    "Accuracy",
    "Area",
    "AreaEstimator",
    "ContactConditions",
    "ContactFields",
    "ContactPatches",
    "ContactSolution",
    "Estimate",
    "GridLevel",
    "Origin",
    "Residuals",
    "Response",
    "Rule",
    "SolutionWriter",
    "Status",
    "TheoryBeside",
    "Trial",
    "Violation",
    "areas",
    "describe_maps",
    "describe_work",
    "exceeds_metals",
    "fill_gap",
    "find_contact",
    "find_scene",
    "gather_warnings",
    "heal",
    "key_of_origin",
    "list_all_warnings",
    "list_answers",
    "list_quantities",
    "name_load",
    "note_loads",
    "page_or_file",
    "read",
    "read_figures",
    "require_netcdf",
    "responses",
    "solution_key",
    "versions",
    "write",
    "writers",
]
