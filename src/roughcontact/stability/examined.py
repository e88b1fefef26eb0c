"""What is looked at: a problem, its load and its solution."""

from __future__ import annotations

import attrs

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
    pressure, force, approach
        The load that was given, in Pa, N or m; the other two are None.
    """

    problem: ContactProblem
    solution: ContactSolution
    pressure: float | None
    force: float | None
    approach: float | None

    def again(self, problem: ContactProblem) -> ContactSolution:
        """Solve another problem at the same load, the bodies being where they were if the approach is given.

        Raises
        ------
        InputError
            If the other problem cannot carry the load.
        NotConverged
            If its solution is not certified.
        """
        approach = None if self.approach is None else self.approach + (problem.summit - self.problem.summit)
        return problem.solve(pressure=self.pressure, force=self.force, approach=approach)
