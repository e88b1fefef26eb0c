"""Normal stiffness."""

from __future__ import annotations

import math

import attrs
import numpy as np

from roughcontact._answers.linear.edge_correction import correct_edges
from roughcontact._answers.linear.tangent import Tangent
from roughcontact._base.checks import Array
from roughcontact._base.warnings import ContactWarning
from roughcontact._parts.grid import Boundary
from roughcontact._solve.solution import ContactSolution, Estimate, Response, responses
from roughcontact.errors import InputError

# Relative residual of the answer to a unit displacement: the stiffness errs by its square.
_TOLERANCE = 1e-2


@responses.register("stiffness")
@attrs.frozen
class Stiffness(Response[Estimate]):
    r"""Normal stiffness :math:`S = dF/d\delta`, N/m, by the linear answer to a unit approach.

    .. math:: K_{AA}\, q = 1, \qquad S = q \cdot (1 + r)\, \Delta x \Delta y + dS

    with the cells A in contact below the pressure limit, the residual :math:`r = 1 - K q`, so that the error is
    the square of the residual, and the correction dS of the edge (`roughcontact._answers.linear.edge_correction`). Over
    ``solution.grid.area`` it is the stiffness of the interface, Pa/m. It is infinite in full contact on a periodic
    boundary, and zero where no cell is in contact below the limit.

    References
    ----------
    Barber, Proc. R. Soc. A 459 (2003) 53-66, https://doi.org/10.1098/rspa.2002.1038
    """

    def respond(self, solution: ContactSolution) -> Estimate:
        """Return the stiffness; see `Response.respond`."""
        normal = find_normal_answer(solution, "stiffness")
        return Estimate(normal.value, normal.uncertainty, "N/m", normal.warnings)


@attrs.frozen(eq=False)
class NormalAnswer:
    """The answer to a unit approach.

    Attributes
    ----------
    field
        Change of the pressure, shape (nx, ny), Pa/m; zero where the stiffness is infinite.
    value, uncertainty
        Its sum over the corrected area, N/m, and the standard deviation of that.
    warnings
        Why it must not be trusted, in sentences.
    """

    field: Array
    value: float
    uncertainty: float
    warnings: tuple[str, ...]


def find_normal_answer(solution: ContactSolution, what: str) -> NormalAnswer:
    """Return the answer to a unit approach of the cells below the pressure limit, for what is asked, in words."""
    require_mean_gap(solution, what)
    area = solution.area()
    warnings = list_warnings(solution, area.warnings)
    tangent = Tangent(solution)
    unit = np.ones(solution.grid.shape)
    if tangent.is_rigid:
        return NormalAnswer(0.0 * unit, math.inf, 0.0, (*warnings, describe_full_contact(what)))
    if not tangent.cells.any():
        return NormalAnswer(0.0 * unit, 0.0, 0.0, warnings)
    answer = tangent.solve(unit, _TOLERANCE)
    correction = correct_edges(solution, answer.values, tangent.cells, area)
    value = sum_of(answer.values, answer.residual) * solution.grid.cell_area + float(correction.patches.sum())
    return NormalAnswer(answer.values, value, correction.uncertainty, warnings)


def sum_of(values: Array, residual: Array) -> float:
    """Return the sum of the answer to a unit displacement, exact to the square of the residual."""
    return float(np.add.reduce(values * (1.0 + residual), axis=None))


def require_mean_gap(solution: ContactSolution, what: str) -> None:
    """Refuse a wrapped boundary, where the displacement by uniform pressure is arbitrary."""
    if solution.boundary is Boundary.WRAPPED:
        raise InputError(
            f"On a wrapped boundary uniform pressure moves the surfaces by an arbitrary amount, so that the {what} "
            "means nothing: choose boundary='periodic' or 'free'."
        )


def describe_full_contact(what: str) -> ContactWarning:
    """Return why what is asked, in words, is infinite in full contact on a periodic boundary."""
    text = f"the surfaces touch everywhere, so that the interface yields nothing and its {what} is infinite"
    return ContactWarning(text, "full contact")


def list_warnings(solution: ContactSolution, warnings: tuple[str, ...]) -> tuple[str, ...]:
    """Return the warnings of the area, and that of a contact which a free border cuts."""
    contact = solution.contact
    edges = (contact[0], contact[-1], contact[:, 0], contact[:, -1])
    if solution.boundary is not Boundary.FREE or not any(edge.any() for edge in edges):
        return warnings
    text = "the contact reaches the border of a free domain, which counts as its edge"
    return (*warnings, ContactWarning(text, "edge contact"))
