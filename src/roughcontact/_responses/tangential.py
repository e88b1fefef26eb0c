"""Tangential stiffness before slip."""

from __future__ import annotations

import math
from collections.abc import Sequence

import attrs
import numpy as np

from roughcontact._problem import problem_of
from roughcontact._responses.stiffness import find_normal_answer
from roughcontact._solution import ContactSolution, Estimate, Response, responses
from roughcontact.checks import Array, Pair, integer, pair
from roughcontact.errors import InputError
from roughcontact.grid import Boundary

# Dundurs' second parameter above which normal and tangential displacements are coupled by more than is neglected.
_COUPLED = 0.02
# Standard deviation of the ratio to the normal stiffness over its anisotropic part: only ellipses are exact.
_SHAPE = 0.2


def _poisson(value: float | Sequence[float] | None) -> Pair | None:
    if value is None:
        return None
    ratios = pair(value, "Poisson's ratio of the bodies")
    if not all(-1.0 < ratio <= 0.5 for ratio in ratios):
        raise InputError.about("Poisson's ratio of the bodies", value, "above -1 and at most 0.5, one number or two")
    return ratios


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
    Coupling of normal and tangential displacements is neglected.

    Parameters
    ----------
    axis
        0 for a force along x, 1 along y.
    poisson
        Poisson's ratio of both bodies, or of each (body, counterbody); None takes those of the materials.

    References
    ----------
    Mindlin, J. Appl. Mech. 16 (1949) 259-268, https://doi.org/10.1115/1.4009973;
    Campañá, Persson, Müser, J. Phys. Condens. Matter 23 (2011) 085001,
    https://doi.org/10.1088/0953-8984/23/8/085001
    """

    axis: int = attrs.field(default=0, converter=_axis)
    poisson: Pair | None = attrs.field(default=None, converter=_poisson)

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
        compliances, ratios = self._read_materials(solution)
        normal = find_normal_answer(solution, "tangential stiffness")
        warnings = (*normal.warnings, *_warn_of_coupling(compliances, ratios))
        if not 0.0 < normal.value < math.inf:
            return Estimate(normal.value, 0.0, "N/m", warnings)
        weight = _average_cosine(solution, normal.field, self.axis)
        ratio, round_ratio = (_find_ratio(compliances, ratios, part) for part in (weight, 0.5))
        std = math.hypot(ratio * normal.uncertainty, _SHAPE * (ratio - round_ratio) * normal.value)
        return Estimate(ratio * normal.value, std, "N/m", warnings)

    def _read_materials(self, solution: ContactSolution) -> tuple[Pair, Pair]:
        """Return the compliances and Poisson's ratios of both bodies; a rigid body has any."""
        materials = problem_of(solution).plan.materials
        found = []
        for number, material in enumerate(materials):
            ratio = getattr(material, "poisson", 0.0 if material.compliance == 0.0 else None)
            ratio = ratio if self.poisson is None else self.poisson[number]
            if ratio is None:
                raise InputError(f"The material {material!r} has no Poisson's ratio: give poisson=.")
            found.append(float(ratio))
        return (materials[0].compliance, materials[1].compliance), (found[0], found[1])


def _find_ratio(compliances: Pair, ratios: Pair, cosine: float) -> float:
    """Return the tangential over the normal stiffness."""
    sheared = sum(c * (1.0 - nu * cosine) / (1.0 - nu) for c, nu in zip(compliances, ratios, strict=True))
    return sum(compliances) / sheared


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
    power[0, 0] = 0.0
    energy = power / np.sqrt(square)
    along = (qx if axis == 0 else qy) ** 2 / square
    total = float(energy.sum())
    return float((along * energy).sum()) / total if total > 0.0 else 0.5


def _warn_of_coupling(compliances: Pair, ratios: Pair) -> tuple[str, ...]:
    """Return a warning if the bodies differ so that normal and tangential displacements are coupled."""
    parts = [c * (1.0 - 2.0 * nu) / (1.0 - nu) for c, nu in zip(compliances, ratios, strict=True)]
    dundurs = 0.5 * abs(parts[0] - parts[1]) / sum(compliances)
    if dundurs <= _COUPLED:
        return ()
    return (
        f"the bodies differ (Dundurs' beta is {dundurs:.2g}): the coupling of normal and tangential load is neglected",
    )
