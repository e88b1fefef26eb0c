"""Solvers of shear: stick and slip within given limits."""

from roughcontact._solve.solvers.shear.base import ShearOutcome, ShearSolver, ShearTask, shear_solvers
from roughcontact._solve.solvers.shear.discs import magnitude, natural_residual, project_to_discs
from roughcontact._solve.solvers.shear.projected_cg import ProjectedShearCG
from roughcontact._solve.solvers.shear.spectral_gradient import SpectralShearGradient

__all__ = [
    "ProjectedShearCG",
    "ShearOutcome",
    "ShearSolver",
    "ShearTask",
    "SpectralShearGradient",
    "magnitude",
    "natural_residual",
    "project_to_discs",
    "shear_solvers",
]
