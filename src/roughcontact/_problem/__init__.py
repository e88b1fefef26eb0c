"""The contact problem: bodies, initial gap, load, plan, certificate."""

from roughcontact._problem.body import RIGID_FLAT, Body
from roughcontact._problem.plan import SolvePlan
from roughcontact._problem.problem import ContactProblem
from roughcontact._problem.source import problem_of
from roughcontact._problem.sweep import Sweep

__all__ = ["RIGID_FLAT", "Body", "ContactProblem", "SolvePlan", "Sweep", "problem_of"]
