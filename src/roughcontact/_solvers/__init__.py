"""Solvers: the pressure that satisfies the conditions of contact."""

from roughcontact._solvers.base import (
    Monitor,
    Outcome,
    Solver,
    Step,
    Task,
    nearest_pressure,
    solvers,
    starting_pressure,
)
from roughcontact._solvers.conjugate import ProjectedConjugateGradient
from roughcontact._solvers.polonsky_keer import PolonskyKeer
from roughcontact._solvers.projection import project_to_load, rescale_to_load
from roughcontact._solvers.spectral_gradient import SpectralGradient

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
