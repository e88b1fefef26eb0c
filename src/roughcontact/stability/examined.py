"""What is looked at: a problem, its load and its solution."""

from __future__ import annotations

import attrs

from roughcontact.load import Load
from roughcontact.problem import ContactProblem
from roughcontact.solution import ContactSolution


@attrs.frozen(eq=False)
class Examined:
    """A problem solved at a load.

    Attributes
    ----------
    problem
        The problem.
    solution
        Its solution, converged or not.
    load
        The load that was given.
    """

    problem: ContactProblem
    solution: ContactSolution
    load: Load

    def again(self, problem: ContactProblem) -> ContactSolution:
        """Solve another problem at the same load, the bodies being where they were if the approach is given.

        Raises
        ------
        InputError
            If the other problem cannot carry the load.
        NotConverged
            If its solution is not certified.
        """
        load = self.load
        if load.approach is not None:
            load = attrs.evolve(load, approach=load.approach + (problem.summit - self.problem.summit))
        return load.solve(problem)
