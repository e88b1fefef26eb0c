"""Solvers: the pressure that satisfies the conditions of contact.

One driver for three problems: `driver` (one loop, and refinement of float32 by float64), `grids` (starts on coarser
grids), `passes` (what is done to vectors beside the products). Below it the pressure (`conjugate`), the gap of surfaces
that attract each other (`adhesive`) and the shear (`shear`); `spectral_gradient` serves the first and the last.
"""

from roughcontact._solve.solvers.adhesive import GapDescent as GapDescent
from roughcontact._solve.solvers.adhesive import LinearisedGap as LinearisedGap
from roughcontact._solve.solvers.adhesive import Majorise as Majorise
from roughcontact._solve.solvers.adhesive import surface_stiffness as surface_stiffness
from roughcontact._solve.solvers.base import Outcome as Outcome
from roughcontact._solve.solvers.base import Solver as Solver
from roughcontact._solve.solvers.base import Step as Step
from roughcontact._solve.solvers.base import Task as Task
from roughcontact._solve.solvers.base import nearest_pressure as nearest_pressure
from roughcontact._solve.solvers.base import positive_tolerance as positive_tolerance
from roughcontact._solve.solvers.base import solvers as solvers
from roughcontact._solve.solvers.base import starting_pressure as starting_pressure
from roughcontact._solve.solvers.conjugate import NumpyPasses as NumpyPasses
from roughcontact._solve.solvers.conjugate import ProjectedConjugateGradient as ProjectedConjugateGradient
from roughcontact._solve.solvers.conjugate.nested_iteration import GridSolution as GridSolution
from roughcontact._solve.solvers.conjugate.nested_iteration import estimate_approach as estimate_approach
from roughcontact._solve.solvers.conjugate.nested_iteration import solve_in_window as solve_in_window
from roughcontact._solve.solvers.conjugate.preconditioner import LONG_WAVE_CUT as LONG_WAVE_CUT
from roughcontact._solve.solvers.conjugate.preconditioner import MAX_CUT_EXPONENT as MAX_CUT_EXPONENT
from roughcontact._solve.solvers.conjugate.preconditioner import Preconditioner as Preconditioner
from roughcontact._solve.solvers.conjugate.preconditioner import count_blocks as count_blocks
from roughcontact._solve.solvers.driver import Monitor as Monitor
from roughcontact._solve.solvers.driver import Work as Work
from roughcontact._solve.solvers.grids import coarser_shape as coarser_shape
from roughcontact._solve.solvers.grids import halve_shape as halve_shape
from roughcontact._solve.solvers.passes import ActiveCells as ActiveCells
from roughcontact._solve.solvers.passes import MaskedCells as MaskedCells
from roughcontact._solve.solvers.passes import active_cells as active_cells
from roughcontact._solve.solvers.passes import dot as dot
from roughcontact._solve.solvers.passes import total as total
from roughcontact._solve.solvers.polonsky_keer import PolonskyKeer as PolonskyKeer
from roughcontact._solve.solvers.projection import project_to_load as project_to_load
from roughcontact._solve.solvers.projection import rescale_to_load as rescale_to_load
from roughcontact._solve.solvers.shear import ProjectedShearCG as ProjectedShearCG
from roughcontact._solve.solvers.shear import ShearOutcome as ShearOutcome
from roughcontact._solve.solvers.shear import ShearSolver as ShearSolver
from roughcontact._solve.solvers.shear import ShearTask as ShearTask
from roughcontact._solve.solvers.shear import SpectralShearGradient as SpectralShearGradient
from roughcontact._solve.solvers.shear import magnitude as magnitude
from roughcontact._solve.solvers.shear import natural_residual as natural_residual
from roughcontact._solve.solvers.shear import project_to_discs as project_to_discs
from roughcontact._solve.solvers.shear import shear_solvers as shear_solvers
from roughcontact._solve.solvers.spectral_gradient import SpectralGradient as SpectralGradient
