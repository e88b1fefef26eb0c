"""Projected, preconditioned, mixed-precision conjugate gradients: the default solver.

From the top: `solver`, `nested_iteration` (coarse grids, and the part that can touch), `refinement` (verification in
float64, and the gap instead of the pressure near full contact), `descent` (one iteration in float32), `preconditioner`
(the inverse kernel on the active cells); on small grids `field_descent` in place of both.

Constants without another source are tuned. Halving or doubling one changes the products of 26 contacts by at most 6 %
(docs/studies/solver_constants.py), unless its comment says more.
"""

from roughcontact._solve.solvers.conjugate.field_descent import NumpyPasses as NumpyPasses
from roughcontact._solve.solvers.conjugate.solver import ProjectedConjugateGradient as ProjectedConjugateGradient
