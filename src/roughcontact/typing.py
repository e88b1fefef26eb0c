"""The types that plug-ins, callbacks and annotations name, but scripts seldom construct, and a solver's helpers.

===========  ==========================================================================================================
for          types
===========  ==========================================================================================================
kernels      `SupportsCoefficients`, `SupportsRows`, `SupportsSpectrum`, `SupportsShear`, `SupportsStress`,
             `SupportsConduction`, `SupportsTangential`
convolvers   `BoundKernel`, `ConvolutionSetup`, `PreparedConvolution`, `InverseConvolution`, `ShearConvolution`,
             `WaveMatrix`; the function `padded_shape`
solvers      `Task`, `Outcome`, `Step`, `GridLevel`, `Monitor`, `ContactConditions`, `Violation`; the functions
             `starting_pressure`, `nearest_pressure`, `project_to_load`, `rescale_to_load`,
             `halve_shape`, `count_blocks`; for a solve of your own
             `bind_kernel`, `make_task`, `confirm`, `Certificate`, `certify`, `make_solution`; for one that is divided
             among processes `Whole`, `find_patches`, `solve_on_cells`, `LinearSolution`, `require_found`
materials    the mapping `TYPICAL` of typical ones by name; `PairConstants`, the function `pair_constants`
readers      `RawMap`; the function `read_raw`
commands     `Table`; the functions `quantity`, `replacing`, `si`, `binary`, `write_column`, `available_memory`,
             `available_threads`, `limit_address_space`, `require_memory_of_solve`, `run_sweep`, `name_load`,
             `list_quantities`, `describe_other_places`, `gather_warnings`, `exceeds_metals`, `build_part`,
             `build_problem`, `describe_response`, `build_response`, `ask_states`, `tabulate_answers`, `write_report`
results      `ContactFields`, `Accuracy`, `Trial`, `Residuals`, `ContactPatches`, `Load`, `Origin`, `SolvePlan`,
             `Sweep`, `RequiredLoad`, `Ladder`, `BeyondResolution`, `RunIn`, `Cycle`, `StudyResult`, `Record`,
             `ErrorReport`, `KnownAnswer`, `ReportRow`, `Timing`, `StabilityReport`, `Check`, `Verdict`,
             `MatchedPair`, `Separated`, `PartialSlip`, `FrettingLoop`, `InterfaceLaw`, `LawColumn`, `PowerFit`,
             `TheoryBeside`, `Stickiness`, `AdhesionCycle`, `Stress`, `StressField`, `StressMaximum`, `YieldPoint`,
             `ContactWarning`
arrays       `Array` (float64), `RealArray` (float32 or float64), `IntArray`, `Mask` (bool), `Pair` (x, y)
responses    `ResponseForm`, `ResponseField`, `Leakage`, `Throat`, `Percolation`
friction     `FrictionalResiduals`, `FrictionalState`, `TangentialLoad`, `TangentialLoop`, `StepNumbers`,
             `Increment`
===========  ==========================================================================================================
"""

from roughcontact._answers.laws import InterfaceLaw, LawColumn, PowerFit
from roughcontact._answers.linear.tangent import LinearSolution, require_found, solve_on_cells
from roughcontact._answers.refinement import BeyondResolution, Ladder
from roughcontact._base.archive import replacing
from roughcontact._base.arrays import Array, IntArray, Mask, Pair, RealArray
from roughcontact._base.machine import available_memory, available_threads, limit_address_space
from roughcontact._base.tables import Table
from roughcontact._base.units import ContactWarning, binary, quantity, si, write_column
from roughcontact._faces.cli import Command
from roughcontact._parts.files import RawMap, read_raw
from roughcontact._parts.grid import Load
from roughcontact._parts.interactions import BoundInteraction
from roughcontact._parts.kernels import (
    BoundKernel,
    SupportsCoefficients,
    SupportsConduction,
    SupportsRows,
    SupportsShear,
    SupportsSpectrum,
    SupportsStress,
    SupportsTangential,
)
from roughcontact._parts.materials import TYPICAL, PairConstants, pair_constants
from roughcontact._parts.surfaces import MatchedPair, Separated
from roughcontact._solve.convolvers import (
    ConvolutionSetup,
    InverseConvolution,
    PreparedConvolution,
    ShearConvolution,
    WaveMatrix,
    padded_shape,
)
from roughcontact._solve.problem import (
    AdhesionCycle,
    Certificate,
    Increment,
    RequiredLoad,
    SolvePlan,
    StepNumbers,
    Sweep,
    TangentialLoop,
    bind_kernel,
    certify,
    confirm,
    make_solution,
    make_task,
    require_memory_of_solve,
    run_sweep,
)
from roughcontact._solve.solution import (
    Accuracy,
    ContactConditions,
    ContactFields,
    ContactPatches,
    FrictionalResiduals,
    FrictionalState,
    GridLevel,
    Origin,
    Residuals,
    Stickiness,
    TangentialLoad,
    TheoryBeside,
    Trial,
    Violation,
    Whole,
    describe_other_places,
    exceeds_metals,
    find_patches,
    gather_warnings,
    list_quantities,
    name_load,
)
from roughcontact._solve.solvers import (
    Monitor,
    Outcome,
    ShearOutcome,
    ShearSolver,
    ShearTask,
    Step,
    Task,
    count_blocks,
    halve_shape,
    natural_residual,
    nearest_pressure,
    project_to_load,
    rescale_to_load,
    starting_pressure,
)
from roughcontact._work.processes import Cycle, RunIn
from roughcontact._work.reports.error import ErrorReport, KnownAnswer, ReportRow, Timing
from roughcontact._work.reports.stability import Check, StabilityReport, Verdict
from roughcontact._work.studies import (
    Record,
    ResponseField,
    ResponseForm,
    StudyResult,
    ask_states,
    build_part,
    build_problem,
    build_response,
    describe_response,
    tabulate_answers,
    write_report,
)
from roughcontact.responses import (
    Conductance,
    FrettingLoop,
    Leakage,
    PartialSlip,
    Percolation,
    Stress,
    StressField,
    StressMaximum,
    Throat,
    YieldPoint,
)

__all__ = [
    "TYPICAL",
    "Accuracy",
    "AdhesionCycle",
    "Array",
    "BeyondResolution",
    "BoundInteraction",
    "BoundKernel",
    "Certificate",
    "Check",
    "Command",
    "Conductance",
    "ContactConditions",
    "ContactFields",
    "ContactPatches",
    "ContactWarning",
    "ConvolutionSetup",
    "Cycle",
    "ErrorReport",
    "FrettingLoop",
    "FrictionalResiduals",
    "FrictionalState",
    "GridLevel",
    "Increment",
    "IntArray",
    "InterfaceLaw",
    "InverseConvolution",
    "KnownAnswer",
    "Ladder",
    "LawColumn",
    "Leakage",
    "LinearSolution",
    "Load",
    "Mask",
    "MatchedPair",
    "Monitor",
    "Origin",
    "Outcome",
    "Pair",
    "PairConstants",
    "PartialSlip",
    "Percolation",
    "PowerFit",
    "PreparedConvolution",
    "RawMap",
    "RealArray",
    "Record",
    "ReportRow",
    "RequiredLoad",
    "Residuals",
    "ResponseField",
    "ResponseForm",
    "RunIn",
    "Separated",
    "ShearConvolution",
    "ShearOutcome",
    "ShearSolver",
    "ShearTask",
    "SolvePlan",
    "StabilityReport",
    "Step",
    "StepNumbers",
    "Stickiness",
    "Stress",
    "StressField",
    "StressMaximum",
    "StudyResult",
    "SupportsCoefficients",
    "SupportsConduction",
    "SupportsRows",
    "SupportsShear",
    "SupportsSpectrum",
    "SupportsStress",
    "SupportsTangential",
    "Sweep",
    "Table",
    "TangentialLoad",
    "TangentialLoop",
    "Task",
    "TheoryBeside",
    "Throat",
    "Timing",
    "Trial",
    "Verdict",
    "Violation",
    "WaveMatrix",
    "Whole",
    "YieldPoint",
    "ask_states",
    "available_memory",
    "available_threads",
    "binary",
    "bind_kernel",
    "build_part",
    "build_problem",
    "build_response",
    "certify",
    "confirm",
    "count_blocks",
    "describe_other_places",
    "describe_response",
    "exceeds_metals",
    "find_patches",
    "gather_warnings",
    "halve_shape",
    "limit_address_space",
    "list_quantities",
    "make_solution",
    "make_task",
    "name_load",
    "natural_residual",
    "nearest_pressure",
    "padded_shape",
    "pair_constants",
    "project_to_load",
    "quantity",
    "read_raw",
    "replacing",
    "require_found",
    "require_memory_of_solve",
    "rescale_to_load",
    "run_sweep",
    "si",
    "solve_on_cells",
    "starting_pressure",
    "tabulate_answers",
    "write_column",
    "write_report",
]
