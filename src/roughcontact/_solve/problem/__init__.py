"""The contact problem: bodies, initial gap, load, plan, certificate."""

from roughcontact._solve.problem.accuracy import resample_problem, tolerance_within
from roughcontact._solve.problem.adhesive_path import follow, follow_loads
from roughcontact._solve.problem.body import RIGID_FLAT, Body
from roughcontact._solve.problem.cycle import AdhesionCycle, describe_cycle, find_stability, linearise
from roughcontact._solve.problem.description import (
    describe_estimate,
    describe_grid,
    describe_inputs,
    describe_loads,
    describe_problem,
    describe_solution,
    describe_state,
    describe_value,
    find_inputs,
    find_path_inputs,
    find_problem,
    find_versions,
    format_json,
)
from roughcontact._solve.problem.expressions import ExpressionWriter, NotInAScript, describe_part, write_number
from roughcontact._solve.problem.friction_certificate import require_frictional
from roughcontact._solve.problem.friction_plan import explain_with_friction, include_friction, memory_of_friction
from roughcontact._solve.problem.increments import Increment, list_loads, list_targets
from roughcontact._solve.problem.memory import require_memory_of_solve
from roughcontact._solve.problem.path import (
    AS_GIVEN,
    FrictionalPath,
    TangentialLoop,
    load_path,
    resolve_friction,
    run_slide,
    save_path,
)
from roughcontact._solve.problem.plan import SolvePlan
from roughcontact._solve.problem.problem import ContactProblem
from roughcontact._solve.problem.pull_off import OnStateToPullOff, find_pull_off
from roughcontact._solve.problem.required_load import RequiredLoad, find_required_load
from roughcontact._solve.problem.run import (
    Certificate,
    certify,
    computing,
    confirm,
    make_solution,
    require_certified,
    run_solve,
)
from roughcontact._solve.problem.saved import find_saved_kind, load, problem_of
from roughcontact._solve.problem.slabs import (
    SlabProcesses,
    SlabSolution,
    SolveRecord,
    ending_all,
    plan_slabs,
    solve_slabs,
)
from roughcontact._solve.problem.step_numbers import StepNumbers
from roughcontact._solve.problem.sweep import Sweep, order_of_solving, predict_pressure, run_sweep
from roughcontact._solve.problem.task import LOAD_TOLERANCE, bind_kernel, make_task, maximum_pressure, pressure_unit

__all__ = [
    "AS_GIVEN",
    "LOAD_TOLERANCE",
    "RIGID_FLAT",
    "AdhesionCycle",
    "Body",
    "Certificate",
    "ContactProblem",
    "ExpressionWriter",
    "FrictionalPath",
    "Increment",
    "NotInAScript",
    "OnStateToPullOff",
    "RequiredLoad",
    "SlabProcesses",
    "SlabSolution",
    "SolvePlan",
    "SolveRecord",
    "StepNumbers",
    "Sweep",
    "TangentialLoop",
    "bind_kernel",
    "certify",
    "computing",
    "confirm",
    "describe_cycle",
    "describe_estimate",
    "describe_grid",
    "describe_inputs",
    "describe_loads",
    "describe_part",
    "describe_problem",
    "describe_solution",
    "describe_state",
    "describe_value",
    "ending_all",
    "explain_with_friction",
    "find_inputs",
    "find_path_inputs",
    "find_problem",
    "find_pull_off",
    "find_required_load",
    "find_saved_kind",
    "find_stability",
    "find_versions",
    "follow",
    "follow_loads",
    "format_json",
    "include_friction",
    "linearise",
    "list_loads",
    "list_targets",
    "load",
    "load_path",
    "make_solution",
    "make_task",
    "maximum_pressure",
    "memory_of_friction",
    "order_of_solving",
    "plan_slabs",
    "predict_pressure",
    "pressure_unit",
    "problem_of",
    "require_certified",
    "require_frictional",
    "require_memory_of_solve",
    "resample_problem",
    "resolve_friction",
    "run_slide",
    "run_solve",
    "run_sweep",
    "save_path",
    "solve_slabs",
    "tolerance_within",
    "write_number",
]
