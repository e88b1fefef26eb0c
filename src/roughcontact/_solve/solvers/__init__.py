"""Solvers: the pressure that satisfies the conditions of contact."""

from roughcontact._solve.solvers.adhesive import GapDescent, LinearisedGap, Majorise, surface_stiffness
from roughcontact._solve.solvers.base import (
    Monitor,
    Outcome,
    Solver,
    Step,
    Task,
    nearest_pressure,
    positive_tolerance,
    solvers,
    starting_pressure,
)
from roughcontact._solve.solvers.conjugate import ProjectedConjugateGradient
from roughcontact._solve.solvers.conjugate.active import ActiveCells, MaskedCells, active_cells
from roughcontact._solve.solvers.conjugate.nested_iteration import (
    GridSolution,
    estimate_approach,
    halve_shape,
    solve_in_window,
)
from roughcontact._solve.solvers.conjugate.preconditioner import (
    LONG_WAVE_CUT,
    MAX_CUT_EXPONENT,
    Preconditioner,
    count_blocks,
)
from roughcontact._solve.solvers.polonsky_keer import PolonskyKeer
from roughcontact._solve.solvers.projection import dot, project_to_load, rescale_to_load, total
from roughcontact._solve.solvers.shear import (
    ProjectedShearCG,
    ShearOutcome,
    ShearSolver,
    ShearTask,
    SpectralShearGradient,
    magnitude,
    natural_residual,
    project_to_discs,
    shear_solvers,
)
from roughcontact._solve.solvers.spectral_gradient import SpectralGradient

__all__ = [
    "LONG_WAVE_CUT",
    "MAX_CUT_EXPONENT",
    "ActiveCells",
    "GapDescent",
    "GridSolution",
    "LinearisedGap",
    "Majorise",
    "MaskedCells",
    "Monitor",
    "Outcome",
    "PolonskyKeer",
    "Preconditioner",
    "ProjectedConjugateGradient",
    "ProjectedShearCG",
    "ShearOutcome",
    "ShearSolver",
    "ShearTask",
    "Solver",
    "SpectralGradient",
    "SpectralShearGradient",
    "Step",
    "Task",
    "active_cells",
    "count_blocks",
    "dot",
    "estimate_approach",
    "halve_shape",
    "magnitude",
    "natural_residual",
    "nearest_pressure",
    "positive_tolerance",
    "project_to_discs",
    "project_to_load",
    "rescale_to_load",
    "shear_solvers",
    "solve_in_window",
    "solvers",
    "starting_pressure",
    "surface_stiffness",
    "total",
]
