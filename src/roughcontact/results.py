"""What public calls return, for annotations and `isinstance`; scripts seldom construct it.

===================  ==============================================================================================
of                   classes
===================  ==============================================================================================
a solution           `ContactFields`, `ContactPatches`, `Certificate`, `Condition`, `Residuals`, `Origin`, `Accuracy`,
                     `Trial`, `TheoryBeside`, `Stickiness`, `WarningText`, `WorkText`
a problem            `SolvePlan`, `RequiredLoad`
several loads        `Path`, of which `Sweep`, `AdhesionCycle` and `LoadPath` are kinds; `RunIn`, `Cycle`,
                     `InterfaceLaw`, `LawColumn`, `PowerFit`, `FilmLaw`, `FilmFit`
loads along the      `Sheared`, `FrictionalState`, `FrictionalResiduals`, `TangentialLoad`, `TangentialLoop`,
surface              `StepNumbers`, `Increment`
several grids        `Ladder`, `BeyondResolution`
measured maps        `MatchedPair`, `Separated`, `LineScans`
a study              `StudyResult`, `Record`
reports              `ErrorReport`, `KnownAnswer`, `ReportRow`, `Timing`, `StabilityReport`, `Check`, `Verdict`
===================  ==============================================================================================

Those of responses are in `roughcontact.responses`.
"""

from roughcontact._answers.laws import FilmFit, FilmLaw, InterfaceLaw, LawColumn, PowerFit
from roughcontact._answers.refinement import BeyondResolution, Ladder
from roughcontact._base.units import WarningText, WorkText
from roughcontact._parts.files import LineScans
from roughcontact._parts.surfaces import MatchedPair, Separated
from roughcontact._solve.problem import (
    AdhesionCycle,
    Increment,
    LoadPath,
    Path,
    RequiredLoad,
    SolvePlan,
    StepNumbers,
    Sweep,
    TangentialLoop,
)
from roughcontact._solve.solution import (
    Accuracy,
    Certificate,
    Condition,
    ContactFields,
    ContactPatches,
    FrictionalResiduals,
    FrictionalState,
    Origin,
    Residuals,
    Sheared,
    Stickiness,
    TangentialLoad,
    TheoryBeside,
    Trial,
)
from roughcontact._work.processes import Cycle, RunIn
from roughcontact._work.reports import Check, ErrorReport, KnownAnswer, ReportRow, StabilityReport, Timing, Verdict
from roughcontact._work.studies import Record, StudyResult

__all__ = [
    "Accuracy",
    "AdhesionCycle",
    "BeyondResolution",
    "Certificate",
    "Check",
    "Condition",
    "ContactFields",
    "ContactPatches",
    "Cycle",
    "ErrorReport",
    "FilmFit",
    "FilmLaw",
    "FrictionalResiduals",
    "FrictionalState",
    "Increment",
    "InterfaceLaw",
    "KnownAnswer",
    "Ladder",
    "LawColumn",
    "LineScans",
    "LoadPath",
    "MatchedPair",
    "Origin",
    "Path",
    "PowerFit",
    "Record",
    "ReportRow",
    "RequiredLoad",
    "Residuals",
    "RunIn",
    "Separated",
    "Sheared",
    "SolvePlan",
    "StabilityReport",
    "StepNumbers",
    "Stickiness",
    "StudyResult",
    "Sweep",
    "TangentialLoad",
    "TangentialLoop",
    "TheoryBeside",
    "Timing",
    "Trial",
    "Verdict",
    "WarningText",
    "WorkText",
]
