"""Tangential stiffness before slip."""

from __future__ import annotations

import math

import attrs

from roughcontact._answers.linear.coupling import judge_coupling
from roughcontact._answers.linear.stiffness import find_normal_answer
from roughcontact._answers.linear.tangential_compliance import find_tangential_compliance, tangential_axis
from roughcontact._base.warnings import ContactWarning
from roughcontact._solve.problem import problem_of
from roughcontact._solve.solution import ContactSolution, Estimate, Response, responses
from roughcontact.errors import InputError

# Standard deviation of what the traction makes the stiffness too small by, over its expected value. Set on the rough
# contacts of benchmarks/response_classes.py, three times its cases, so that 93 % of the differences are within two.
_UNSURE = 1.75
# Part of the stiffness from which a warning says so.
_TOLD = 0.005


@responses.register("tangential-stiffness")
@attrs.frozen
class TangentialStiffness(Response[Estimate]):
    r"""Stiffness against a tangential force along an axis before any slip, N/m.

    With traction proportional to the normal answer q, which is exact for ellipses,

    .. math:: \frac{S_x}{S} = \frac{\sum_i c_i}{\sum_i c_i\, (1 - \nu_i \langle\cos^2\theta\rangle) / (1 - \nu_i)},
       \qquad c_i = \frac{1 - \nu_i^2}{E_i}

    where :math:`\theta` is the angle of a wave of q to the axis and the mean is weighted by the elastic energy of the
    waves. Round and isotropic contacts have 1/2, which gives Mindlin's :math:`2(1-\nu)/(2-\nu)` for bodies alike.
    Coupling of normal and tangential displacements is neglected, and bodies that differ are refused. For other contacts
    than ellipses the value is a lower bound unless Poisson's ratio is zero: of any traction the true one stores the
    smallest energy. The uncertainty contains what it lacks, and a warning names it from half a per cent on.

    Parameters
    ----------
    axis
        0 for a force along x, 1 along y.

    References
    ----------
    Mindlin, J. Appl. Mech. 16 (1949) 259-268, https://doi.org/10.1115/1.4009973;
    Campañá, Persson, Müser, J. Phys. Condens. Matter 23 (2011) 085001,
    https://doi.org/10.1088/0953-8984/23/8/085001
    """

    axis: int = attrs.field(default=0, converter=tangential_axis)

    def respond(self, solution: ContactSolution) -> Estimate:
        """Return the stiffness; see `Response.respond`."""
        if solution.moduli is not None:
            raise InputError(
                "The tangential stiffness follows from that of two half-spaces, but this kernel is that of a layer: "
                "choose kernel='love'."
            )
        if solution.saturated.any():
            raise InputError(
                "The pressure has reached its limit on a part of the contact, which resists a tangential force as a "
                "yielding solid: the tangential stiffness holds for elastic contact only."
            )
        plan = problem_of(solution).plan
        coupling = judge_coupling(plan.materials, plan.modulus)
        normal = find_normal_answer(solution, "tangential stiffness")
        warnings = (*normal.warnings, *coupling)
        if not 0.0 < normal.value < math.inf:
            return Estimate(normal.value, 0.0, "N/m", warnings)
        compliance = find_tangential_compliance(solution, normal.field, normal.field > 0.0, self.axis)
        ratio = 1.0 / compliance.ratio
        too_small = compliance.excess
        if too_small > _TOLD:
            text = (
                f"the traction is taken to be in proportion to the normal answer, which makes the tangential stiffness "
                f"too small by about {100 * too_small:.1g} %"
            )
            warnings += (ContactWarning(text, "proportional traction", too_small),)
        std = ratio * math.hypot(normal.uncertainty, _UNSURE * too_small * normal.value)
        return Estimate(ratio * normal.value, std, "N/m", warnings)
