"""Solvers of surfaces that attract each other."""

from roughcontact._solve.solvers.adhesive.gap_descent import GapDescent
from roughcontact._solve.solvers.adhesive.majorise import Majorise
from roughcontact._solve.solvers.adhesive.stability import stability_margin

__all__ = ["GapDescent", "Majorise", "stability_margin"]
