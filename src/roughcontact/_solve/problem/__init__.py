"""The contact problem: bodies, initial gap, load, plan, certificate."""

from roughcontact._solve.problem.body import RIGID_FLAT, Body
from roughcontact._solve.problem.plan import SolvePlan
from roughcontact._solve.problem.problem import ContactProblem
from roughcontact._solve.problem.source import problem_of
from roughcontact._solve.problem.sweep import Sweep

__all__ = ["RIGID_FLAT", "Body", "ContactProblem", "SolvePlan", "Sweep", "problem_of"]
