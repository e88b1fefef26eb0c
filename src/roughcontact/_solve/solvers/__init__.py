"""Solvers: the pressure that satisfies the conditions of contact."""

from roughcontact._solve.solvers.base import (
    Monitor,
    Outcome,
    Solver,
    Step,
    Task,
    nearest_pressure,
    solvers,
    starting_pressure,
)
from roughcontact._solve.solvers.conjugate import ProjectedConjugateGradient
from roughcontact._solve.solvers.polonsky_keer import PolonskyKeer
from roughcontact._solve.solvers.projection import project_to_load, rescale_to_load
from roughcontact._solve.solvers.spectral_gradient import SpectralGradient

__all__ = [
    "Monitor",
    "Outcome",
    "PolonskyKeer",
    "ProjectedConjugateGradient",
    "Solver",
    "SpectralGradient",
    "Step",
    "Task",
    "nearest_pressure",
    "project_to_load",
    "rescale_to_load",
    "solvers",
    "starting_pressure",
]
