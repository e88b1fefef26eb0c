"""What a page, a service or a command needs to ask for a contact in words and to show it in words.

===============  ==================================================================================================
for              names
===============  ==================================================================================================
input            `build_problem`, `build_part`, `build_layer`, `build_response`; what a response asks for,
                 `describe_response`, `ResponseForm`; a part in a line, `summarize`, and its fields, `list_fields`,
                 `PartField`, and the parts that one may hold, `find_parts`; typical materials by name, `TYPICAL`
the machine      `available_threads`, `limit_address_space`
a run            `explain_loads`, `prepare_path`, `run_sweep`, `ask_states`; of a film law `space_separations`,
                 `plan_film`, `FilmPlan`
words            `name_load`, `list_quantities`, `describe_other_places`, `gather_warnings`, `exceeds_metals`,
                 `list_answer_warnings`
tables, reports  `tabulate_answers`, `write_column`, `write_report`
===============  ==================================================================================================
"""

from roughcontact._answers.laws import FilmPlan, plan_film, space_separations
from roughcontact._base.machine import available_threads, limit_address_space
from roughcontact._base.registry import PartField, list_fields, summarize
from roughcontact._base.units import write_column
from roughcontact._parts.materials import TYPICAL
from roughcontact._solve.problem import explain_loads, prepare_path, run_sweep
from roughcontact._solve.solution import (
    describe_other_places,
    exceeds_metals,
    gather_warnings,
    list_quantities,
    name_load,
)
from roughcontact._work.studies import (
    ResponseForm,
    ask_states,
    build_layer,
    build_part,
    build_problem,
    build_response,
    describe_response,
    find_parts,
    list_answer_warnings,
    tabulate_answers,
    write_report,
)

__all__ = [
    "TYPICAL",
    "FilmPlan",
    "PartField",
    "ResponseForm",
    "ask_states",
    "available_threads",
    "build_layer",
    "build_part",
    "build_problem",
    "build_response",
    "describe_other_places",
    "describe_response",
    "exceeds_metals",
    "explain_loads",
    "find_parts",
    "gather_warnings",
    "limit_address_space",
    "list_answer_warnings",
    "list_fields",
    "list_quantities",
    "name_load",
    "plan_film",
    "prepare_path",
    "run_sweep",
    "space_separations",
    "summarize",
    "tabulate_answers",
    "write_column",
    "write_report",
]
