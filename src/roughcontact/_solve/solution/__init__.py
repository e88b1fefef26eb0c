"""The solution of a contact, its file, and its text."""

from roughcontact._solve.solution.attraction import (
    RESOLVED_CELLS,
    TRAPPED_CELLS,
    AdhesiveConditions,
    AdhesiveViolation,
    count_patch_cells,
    describe_range,
    trapping_error,
)
from roughcontact._solve.solution.conditions import ContactConditions, Violation
from roughcontact._solve.solution.contact import ContactSolution
from roughcontact._solve.solution.fields import ContactFields, ContactPatches, find_patches
from roughcontact._solve.solution.frictional import FrictionalSolution
from roughcontact._solve.solution.frictional_files import read_estimate, read_path, write_path
from roughcontact._solve.solution.frictional_state import FrictionalResiduals, FrictionalState, TangentialLoad
from roughcontact._solve.solution.healing import fill_gap, heal
from roughcontact._solve.solution.origin import Accuracy, Origin, Trial, key_of_origin, solution_key, versions
from roughcontact._solve.solution.plausibility import PLAUSIBILITY_RULES, Rule, exceeds_metals, find_contact, find_scene
from roughcontact._solve.solution.results import (
    DEFAULT_AREA,
    Area,
    AreaEstimator,
    Estimate,
    GridLevel,
    Residuals,
    Response,
    Status,
    areas,
    list_estimates,
    read_number,
    require_with_friction,
    responses,
)
from roughcontact._solve.solution.sampling import find_peak_sampling, find_stiffness_sampling
from roughcontact._solve.solution.storage import read, read_figures, require_netcdf, scalars_of, write
from roughcontact._solve.solution.summary import (
    MORE_THAN_METALS,
    describe_maps,
    describe_other_places,
    describe_work,
    find_load,
    format_sampling,
    gather_warnings,
    list_all_warnings,
    list_answers,
    list_quantities,
    name_load,
    note_loads,
)
from roughcontact._solve.solution.theory import Stickiness, TheoryBeside
from roughcontact._solve.solution.whole import Whole
from roughcontact._solve.solution.writers import SolutionWriter, page_or_file, writers

__all__ = [
    "DEFAULT_AREA",
    "MORE_THAN_METALS",
    "PLAUSIBILITY_RULES",
    "RESOLVED_CELLS",
    "TRAPPED_CELLS",
    "Accuracy",
    "AdhesiveConditions",
    "AdhesiveViolation",
    "Area",
    "AreaEstimator",
    "ContactConditions",
    "ContactFields",
    "ContactPatches",
    "ContactSolution",
    "Estimate",
    "FrictionalResiduals",
    "FrictionalSolution",
    "FrictionalState",
    "GridLevel",
    "Origin",
    "Residuals",
    "Response",
    "Rule",
    "SolutionWriter",
    "Status",
    "Stickiness",
    "TangentialLoad",
    "TheoryBeside",
    "Trial",
    "Violation",
    "Whole",
    "areas",
    "count_patch_cells",
    "describe_maps",
    "describe_other_places",
    "describe_range",
    "describe_work",
    "exceeds_metals",
    "fill_gap",
    "find_contact",
    "find_load",
    "find_patches",
    "find_peak_sampling",
    "find_scene",
    "find_stiffness_sampling",
    "format_sampling",
    "gather_warnings",
    "heal",
    "key_of_origin",
    "list_all_warnings",
    "list_answers",
    "list_estimates",
    "list_quantities",
    "name_load",
    "note_loads",
    "page_or_file",
    "read",
    "read_estimate",
    "read_figures",
    "read_number",
    "read_path",
    "require_netcdf",
    "require_with_friction",
    "responses",
    "scalars_of",
    "solution_key",
    "trapping_error",
    "versions",
    "write",
    "write_path",
    "writers",
]
