"""Solvers of surfaces that attract each other.

From the top: `gap_descent` (the solver, and its starts), `descent` (one iteration), `gap_problem` (what is minimised),
`stiffness` (the inverse of a convolution); `majorise` (by solvers of contact without adhesion) and `linearised_gap`
(small changes of a state) beside it.
"""

from roughcontact._solve.solvers.adhesive.gap_descent import GapDescent as GapDescent
from roughcontact._solve.solvers.adhesive.linearised_gap import LinearisedGap as LinearisedGap
from roughcontact._solve.solvers.adhesive.majorise import Majorise as Majorise
from roughcontact._solve.solvers.adhesive.stiffness import surface_stiffness as surface_stiffness
