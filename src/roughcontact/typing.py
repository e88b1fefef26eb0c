"""The types that plug-ins, callbacks and annotations name, but scripts seldom construct, and a solver's helpers.

===========  ==========================================================================================================
for          types
===========  ==========================================================================================================
kernels      `SupportsCoefficients`, `SupportsSpectrum`
convolvers   `BoundKernel`, `ConvolutionSetup`, `PreparedConvolution`, `InverseConvolution`
solvers      `Task`, `Outcome`, `Step`, `GridLevel`, `Monitor`, `ContactConditions`, `Violation`; the functions
             `starting_pressure`, `nearest_pressure`, `project_to_load`, `rescale_to_load`
readers      `RawMap`
commands     `Table`; the function `replacing`
results      `ContactFields`, `Accuracy`, `Trial`, `Residuals`, `ContactPatches`, `Load`, `Origin`, `SolvePlan`,
             `Sweep`, `Ladder`, `BeyondResolution`, `RunIn`, `Cycle`, `StudyResult`, `Record`, `ErrorReport`,
             `KnownAnswer`, `ReportRow`, `Timing`, `StabilityReport`, `Check`, `Verdict`, `Gallery`, `GalleryRow`,
             `MatchedPair`, `Separated`, `PartialSlip`, `FrettingLoop`, `InterfaceLaw`, `LawColumn`, `PowerFit`,
             `TheoryBeside`, `Stress`, `StressField`, `StressMaximum`, `YieldPoint`, `ContactWarning`
arrays       `Array` (float64), `RealArray` (float32 or float64), `IntArray`, `Mask` (bool), `Pair` (x, y)
responses    `Leakage`, `Throat`, `Percolation`
===========  ==========================================================================================================
"""

from roughcontact._answers.laws import InterfaceLaw, LawColumn, PowerFit
from roughcontact._answers.refinement import BeyondResolution, Ladder
from roughcontact._base.archive import replacing
from roughcontact._base.checks import Array, IntArray, Mask, Pair, RealArray
from roughcontact._base.tables import Table
from roughcontact._base.warnings import ContactWarning
from roughcontact._faces.cli import Command
from roughcontact._parts.files import RawMap
from roughcontact._parts.kernels import BoundKernel, SupportsCoefficients, SupportsSpectrum
from roughcontact._parts.load import Load
from roughcontact._parts.surfaces import MatchedPair, Separated
from roughcontact._solve.convolvers import ConvolutionSetup, InverseConvolution, PreparedConvolution
from roughcontact._solve.problem import SolvePlan, Sweep
from roughcontact._solve.solution import (
    Accuracy,
    ContactConditions,
    ContactFields,
    ContactPatches,
    GridLevel,
    Origin,
    Residuals,
    TheoryBeside,
    Trial,
    Violation,
)
from roughcontact._solve.solvers import (
    Monitor,
    Outcome,
    Step,
    Task,
    nearest_pressure,
    project_to_load,
    rescale_to_load,
    starting_pressure,
)
from roughcontact._work.processes.running_in import Cycle, RunIn
from roughcontact._work.reports.error import ErrorReport, KnownAnswer, ReportRow, Timing
from roughcontact._work.reports.stability import Check, Gallery, GalleryRow, StabilityReport, Verdict
from roughcontact._work.studies import Record, StudyResult
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
    "Accuracy",
    "Array",
    "BeyondResolution",
    "BoundKernel",
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
    "Gallery",
    "GalleryRow",
    "GridLevel",
    "IntArray",
    "InterfaceLaw",
    "InverseConvolution",
    "KnownAnswer",
    "Ladder",
    "LawColumn",
    "Leakage",
    "Load",
    "Mask",
    "MatchedPair",
    "Monitor",
    "Origin",
    "Outcome",
    "Pair",
    "PartialSlip",
    "Percolation",
    "PowerFit",
    "PreparedConvolution",
    "RawMap",
    "RealArray",
    "Record",
    "ReportRow",
    "Residuals",
    "RunIn",
    "Separated",
    "SolvePlan",
    "StabilityReport",
    "Step",
    "Stress",
    "StressField",
    "StressMaximum",
    "StudyResult",
    "SupportsCoefficients",
    "SupportsSpectrum",
    "Sweep",
    "Table",
    "Task",
    "TheoryBeside",
    "Throat",
    "Timing",
    "Trial",
    "Verdict",
    "Violation",
    "YieldPoint",
    "nearest_pressure",
    "project_to_load",
    "replacing",
    "rescale_to_load",
    "starting_pressure",
]
