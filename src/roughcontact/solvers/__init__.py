"""Solvers: the pressure that satisfies the conditions of contact."""

from roughcontact.solvers.base import Outcome, Solver, Step, Task
from roughcontact.solvers.conjugate import ProjectedConjugateGradient
from roughcontact.solvers.polonsky_keer import PolonskyKeer
from roughcontact.solvers.spectral_gradient import SpectralGradient

__all__ = ["Outcome", "PolonskyKeer", "ProjectedConjugateGradient", "Solver", "SpectralGradient", "Step", "Task"]
