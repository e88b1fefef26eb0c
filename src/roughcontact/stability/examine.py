"""All checks of one contact."""

from __future__ import annotations

from roughcontact.errors import InputError
from roughcontact.load import Load
from roughcontact.problem import ContactProblem
from roughcontact.stability import again, fields, kernel
from roughcontact.stability.examined import Examined
from roughcontact.stability.report import StabilityReport, left_out
from roughcontact.stability.rules import RULES

# What can be asked of any solution, and what of a converged one only.
_PROOFS = (fields.convergence, fields.load_balance, fields.complementarity, fields.penetration)
_CHECKS = (
    kernel.convolution_digits,
    kernel.kernel_digits,
    kernel.kernel_forms,
    fields.edge_contact,
    fields.cells_a_wave,
    fields.slope,
    fields.peak_pressure,
    again.float32_inside,
)
_FAMILIES = (again.half_the_cells, again.half_a_cell, again.tighter)
_AREA = (fields.area_uncertainty, fields.area_doubts)


def stability(
    problem: ContactProblem,
    *,
    pressure: float | None = None,
    force: float | None = None,
    approach: float | None = None,
) -> StabilityReport:
    """Solve a contact and look at everything that its answer may hang on.

    Four more solves: by a solver in float64 throughout, on half the cells, half a cell aside and to a
    hundredth of the tolerance.

    Parameters
    ----------
    problem
        The problem.
    pressure, force, approach
        Exactly one: nominal mean pressure, Pa; normal force, N; approach since first touch, m.

    Returns
    -------
    StabilityReport
        Checks with measured values and verdicts. What cannot be done is left out, with the reason.

    Raises
    ------
    InputError
        If it is no problem, not exactly one load is given, or it cannot be carried.
    """
    if not isinstance(problem, ContactProblem):
        raise InputError.about("What is looked at", problem, "a ContactProblem")
    solution = problem.solve(pressure=pressure, force=force, approach=approach, throw=False)
    examined = Examined(problem, solution, Load(pressure=pressure, force=force, approach=approach))
    checks = [check(examined) for check in _PROOFS]
    if not solution.status.success:
        done = {check.name for check in checks}
        reason = "the solution is not converged"
        return StabilityReport((*checks, *(left_out(name, reason) for name in RULES if name not in done)), solution)
    checks += [check(examined) for check in _CHECKS]
    for family in _FAMILIES:
        checks += family(examined)
    checks += [check(examined) for check in _AREA]
    return StabilityReport(tuple(checks), solution)
