"""Solvers of surfaces that attract each other."""

from roughcontact._solve.solvers.adhesive.gap_descent import GapDescent

__all__ = ["GapDescent"]
