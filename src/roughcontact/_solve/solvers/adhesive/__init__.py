"""Solvers of surfaces that attract each other.

From the top: `gap_descent` (the solver), `nested_start` (coarse grids, and other starts), `descent` (one iteration),
`gap_problem` (what is minimised), `stiffness` (the inverse of a convolution); `majorise` (by solvers of contact without
adhesion) and `stability` beside it.
"""

from roughcontact._solve.solvers.adhesive.gap_descent import GapDescent
from roughcontact._solve.solvers.adhesive.majorise import Majorise
from roughcontact._solve.solvers.adhesive.stability import stability_margin

__all__ = ["GapDescent", "Majorise", "stability_margin"]
