"""The problem that a solution solves."""

from __future__ import annotations

from roughcontact._solve.problem.problem import ContactProblem
from roughcontact._solve.solution import ContactSolution
from roughcontact.errors import InputError


def problem_of(solution: ContactSolution) -> ContactProblem:
    """Return the problem that a solution solves, with its prepared convolution; that of a file is built anew.

    Raises
    ------
    InputError
        If the solution does not say what was solved, or a class that it needs is not registered.
    """
    if solution.origin is None:
        raise InputError("The solution does not say which problem it solves, so that nothing can be computed with it.")
    problem = solution.origin.source or ContactProblem(**solution.origin.problem)
    if not isinstance(problem, ContactProblem):
        raise InputError(f"What was solved must be a ContactProblem, but is {problem!r}.")
    return problem
