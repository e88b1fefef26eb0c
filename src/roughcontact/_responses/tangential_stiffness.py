"""Tangential stiffness before slip."""

from __future__ import annotations

import math

import attrs
import numpy as np

from roughcontact._problem import problem_of
from roughcontact._responses.coupling import compare_compliances, judge_coupling
from roughcontact._responses.stiffness import find_normal_answer
from roughcontact._solution import ContactSolution, Estimate, Response, responses
from roughcontact.checks import Array, integer
from roughcontact.errors import InputError
from roughcontact.grid import Boundary

# Standard deviation of the ratio to the normal stiffness over its anisotropic part: only ellipses are exact.
_SHAPE = 0.2


def _axis(value: int) -> int:
    axis = integer(value, "The axis of the tangential force", at_least=0)
    if axis > 1:
        raise InputError.about("The axis of the tangential force", value, "0 (x) or 1 (y)")
    return axis


@responses.register("tangential-stiffness")
@attrs.frozen
class TangentialStiffness(Response[Estimate]):
    r"""Stiffness against a tangential force along an axis before any slip, N/m.

    With traction proportional to the normal answer q, which is exact for ellipses,

    .. math:: \frac{S_x}{S} = \frac{\sum_i c_i}{\sum_i c_i\, (1 - \nu_i \langle\cos^2\theta\rangle) / (1 - \nu_i)},
       \qquad c_i = \frac{1 - \nu_i^2}{E_i}

    where :math:`\theta` is the angle of a wave of q to the axis and the mean is weighted by the elastic energy of the
    waves. Round and isotropic contacts have 1/2, which gives Mindlin's :math:`2(1-\nu)/(2-\nu)` for bodies alike.
    Coupling of normal and tangential displacements is neglected, and bodies that differ are refused.

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

    axis: int = attrs.field(default=0, converter=_axis)

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
        weight = _average_cosine(solution, normal.field, self.axis)
        ratio, round_ratio = (1.0 / compare_compliances(plan.materials, plan.modulus, part) for part in (weight, 0.5))
        std = math.hypot(ratio * normal.uncertainty, _SHAPE * (ratio - round_ratio) * normal.value)
        return Estimate(ratio * normal.value, std, "N/m", warnings)


def _average_cosine(solution: ContactSolution, answer: Array, axis: int) -> float:
    """Return the mean of cos^2 of the angle between waves and an axis, weighted by their elastic energy."""
    shape, spacing = solution.grid.shape, solution.grid.spacing
    padded = shape if solution.boundary is Boundary.PERIODIC else (2 * shape[0], 2 * shape[1])
    power = np.abs(np.fft.rfft2(answer, padded)) ** 2
    # Half of the waves along y are stored; the others equal them, but for the first and, if even, the last.
    power[:, 1 : (padded[1] + 1) // 2] *= 2.0
    qx, qy = np.fft.fftfreq(padded[0], spacing[0])[:, np.newaxis], np.fft.rfftfreq(padded[1], spacing[1])[np.newaxis]
    square = qx**2 + qy**2
    square[0, 0] = 1.0
    energy, along = power / np.sqrt(square), (qx if axis == 0 else qy) ** 2 / square
    energy[0, 0] = 0.0
    if solution.boundary is not Boundary.PERIODIC:
        # The mean of 1/q over the waves around zero, and the part of each axis in it.
        steps = (float(qx[1, 0]), float(qy[0, 1])) if axis == 0 else (float(qy[0, 1]), float(qx[1, 0]))
        parts = [0.5 * b * math.asinh(a / b) for a, b in (steps, steps[::-1])]
        energy[0, 0] = 4.0 * power[0, 0] * sum(parts) / (steps[0] * steps[1])
        along[0, 0] = parts[0] / sum(parts)
    total = float(energy.sum())
    return float((along * energy).sum()) / total if total > 0.0 else 0.5
