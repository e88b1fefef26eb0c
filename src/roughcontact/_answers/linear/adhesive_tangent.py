"""The linear answer of surfaces that attract each other, on open cells too."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from roughcontact._answers.linear.tangent import LinearSolution, Tangent
from roughcontact._base.arrays import Array, Mask, read_only
from roughcontact._base.units import WarningText
from roughcontact._parts.grid import Boundary
from roughcontact._solve.problem import computing, linearise, problem_of
from roughcontact._solve.solution import ContactSolution
from roughcontact._solve.solvers import LinearisedGap
from roughcontact.errors import InputError

# Stability margin below which a jump is near.
_NEAR_JUMP_MARGIN = 0.05


class AdhesiveTangent:
    r"""Small changes of the pressure of surfaces that attract each other, for heights dz at a given position.

    In place of :math:`q = K_{AA}^{-1}\,\mathrm{d}z` of a `Tangent`, open cells answer too, by the slope s' of the law
    (see `LinearisedGap`); q is again linear and symmetric in dz.

    Parameters
    ----------
    solution
        The contact.

    Raises
    ------
    InputError
        If the solution does not say which problem it solves, or the surfaces have come apart.
    """

    def __init__(self, solution: ContactSolution) -> None:
        self._solution = solution
        self._problem = problem_of(solution)
        self.cells: Mask = read_only(solution.contact & ~solution.saturated)
        # Displacement in m by a pressure of one Pa on all cells, if the dimensionless kernel were one.
        self._unit = solution.grid.spacing[0] / solution.modulus

    @property
    def is_rigid(self) -> bool:
        """Whether all cells of a periodic domain touch, so that uniform pressure displaces nothing."""
        return self._solution.boundary is Boundary.PERIODIC and bool(self.cells.all())

    def solve(self, right: Array, tolerance: float = 1e-12) -> LinearSolution:
        """Return the change of the pressure by heights; see `Tangent.solve`.

        Parameters
        ----------
        right
            The heights, shape (nx, ny), m.
        tolerance
            Norm of the residual over that of the answer at which it ends, both in terms of the energy.

        Raises
        ------
        InputError
            If the state is unstable.
        NotConverged
            If the residual cannot be made that small, nor 1e-8.
        """
        if self.is_rigid:
            right = right - right.mean()
        size = float(np.abs(right).max())
        if size == 0.0:
            return LinearSolution(np.zeros_like(right), 0.0, 0.0, 0, 0)
        with computing(self._problem):
            found = self._linearised.solve(right / size, tolerance)
        if found.margin <= 0.0:
            raise InputError(
                "The state is not stable at a given approach, so that it answers no small change: follow the approach "
                "to a stable one by problem.sweep(approach=[...])."
            )
        scale = size / self._unit
        answer = LinearSolution(
            found.pressure * scale,
            found.product * size * scale,
            found.error,
            found.iterations,
            found.products,
            found.margin,
        )
        answer.require(tolerance, self._solution)
        return answer

    @cached_property
    def _linearised(self) -> LinearisedGap:
        return linearise(self._problem, self._solution, holds_approach=True)


def tangent_of(solution: ContactSolution) -> Tangent | AdhesiveTangent:
    """Return the linear answer of a contact with or without adhesion, under further load."""
    shared: Tangent | None = solution.parts.tangent(solution)
    if shared is not None:
        return shared
    return Tangent(solution) if solution.tension is None else AdhesiveTangent(solution)


def describe_jump(margin: float) -> WarningText | None:
    """Return a warning if a stability margin is that of a state near a jump."""
    if margin >= _NEAR_JUMP_MARGIN:
        return None
    text = "the state is close to a jump: a slightly other load may separate or join the surfaces"
    return WarningText(text, "near a jump", margin)
