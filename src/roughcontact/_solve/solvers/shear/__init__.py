"""Solvers of shear: stick and slip within given limits."""

from roughcontact._solve.solvers.shear.base import ShearOutcome as ShearOutcome
from roughcontact._solve.solvers.shear.base import ShearSolver as ShearSolver
from roughcontact._solve.solvers.shear.base import ShearTask as ShearTask
from roughcontact._solve.solvers.shear.base import shear_solvers as shear_solvers
from roughcontact._solve.solvers.shear.discs import magnitude as magnitude
from roughcontact._solve.solvers.shear.discs import natural_residual as natural_residual
from roughcontact._solve.solvers.shear.discs import project_to_discs as project_to_discs
from roughcontact._solve.solvers.shear.projected_cg import ProjectedShearCG as ProjectedShearCG
from roughcontact._solve.solvers.shear.spectral_gradient import SpectralShearGradient as SpectralShearGradient
