"""Tangential stiffness before slip: the compliance of two materials under a given traction."""

from __future__ import annotations

import math

import attrs
import numpy as np

from roughcontact._answers.linear.stiffness import find_normal_answer
from roughcontact._base.arrays import Array, Mask, Pair
from roughcontact._base.checks import integer
from roughcontact._base.units import ContactWarning
from roughcontact._parts.grid import Boundary
from roughcontact._parts.kernels import BoundKernel, InfluenceKernel
from roughcontact._parts.materials import Material, pair_constants
from roughcontact._solve.convolvers import DCFFT
from roughcontact._solve.problem import problem_of
from roughcontact._solve.solution import ContactSolution, Estimate, Response, responses
from roughcontact.errors import InputError

# Dundurs' second constant below which normal and tangential displacement count as uncoupled.
_MAX_UNCOUPLED_BETA = 0.01
# Excess of the compliance under a traction in proportion to a normal pressure, over the product of Poisson's ratio and
# the standard deviation of the displacement where that should be uniform: 0.25 to 0.5 on rough surfaces and waves, by
# comparison with the traction that minimizes the energy (benchmarks/response_classes.py).
_EXCESS_FACTOR = 0.4
# Standard deviation of the stiffness over that excess. Set on the rough contacts of benchmarks/response_classes.py,
# three times its cases, so that 93 % of the differences are within two standard deviations.
_EXCESS_STD_FACTOR = 1.75
# Relative excess from which a warning names it.
_MIN_WARNED_EXCESS = 0.005


def judge_coupling(materials: tuple[Material, Material]) -> tuple[str, ...]:
    """Return a warning if one of the bodies is rigid and the other is not incompressible; otherwise nothing.

    Raises
    ------
    InputError
        If both bodies deform, and normal and tangential displacement are coupled.
    """
    beta = pair_constants(*materials).beta
    if abs(beta) <= _MAX_UNCOUPLED_BETA:
        return ()
    if min(material.compliance for material in materials) > 0.0:
        raise InputError(
            f"The bodies are of different materials, Dundurs' beta is {beta:.3g}, so that normal and tangential "
            "displacement are coupled and partial slip does not follow from normal contact. To neglect that, give one "
            "body the contact modulus E* of the pair, Elastic(E* (1 - nu^2), nu), and make the other Rigid()."
        )
    text = (
        f"one of the bodies is rigid: the results are those of two bodies of like materials with the same contact "
        f"modulus. The coupling of normal and tangential displacement, Dundurs' beta = {abs(beta):.2g}, is neglected"
    )
    return (ContactWarning(text, "coupling", abs(beta)),)


@attrs.frozen
class TangentialCompliance:
    """The tangential over the normal compliance.

    Attributes
    ----------
    ratio
        Along the axis of the force.
    excess
        Estimated relative excess: only ellipses have tractions in proportion to normal pressures.
    anisotropy
        Relative excess of the stiffness of waves along the force over waves across it: Poisson's ratio if materials
        are alike.
    """

    ratio: float
    excess: float
    anisotropy: float


def tangential_axis(value: int) -> int:
    """Return the axis of a tangential force, or raise `InputError`."""
    axis = integer(value, "The axis of the tangential force", at_least=0)
    if axis > 1:
        raise InputError.about("The axis of the tangential force", value, "0 (x) or 1 (y)")
    return axis


def find_tangential_compliance(
    solution: ContactSolution, traction: Array, stick: Mask, axis: int
) -> TangentialCompliance:
    """Return the compliance along an axis under a traction in proportion to a normal pressure.

    Parameters
    ----------
    solution
        The contact.
    traction
        Traction, shape (nx, ny), in any unit.
    stick
        Cells that all move by the same, shape (nx, ny).
    axis
        0 for a force along x, 1 along y.
    """
    plan = problem_of(solution).plan
    # A wave of shear across its normal is displaced more than one along it, by the factor 1 + gamma.
    free = 1.0 + pair_constants(*plan.materials).gamma
    anisotropy = 1.0 - 1.0 / free
    # The traction of a very small force is zero by rounding.
    traction = traction if traction.any() else solution.pressure
    displacements = _find_displacements(solution, traction / float(np.abs(traction).max()))
    energies = np.einsum("ij,kij->k", traction, displacements)
    total = float(energies.sum())
    cosine = float(energies[axis]) / total if total > 0.0 else 0.5
    displacement = displacements.sum(axis=0) - anisotropy * displacements[axis]
    deviation = _find_deviation(displacement, np.where(stick, traction, 0.0))
    ratio = free * (1.0 - anisotropy * cosine)
    return TangentialCompliance(ratio, _EXCESS_FACTOR * anisotropy * deviation, anisotropy)


def _find_deviation(displacement: Array, traction: Array) -> float:
    """Return the standard deviation over the mean of a displacement, weighted with the traction."""
    total = float(traction.sum())
    mean = float(np.sum(traction * displacement))
    # Uniform traction on a periodic boundary displaces nothing.
    if not (total > 0.0 and mean > 0.0):
        return 0.0
    weights = traction / total
    mean = mean / total
    return math.sqrt(max(float(np.sum(weights * (displacement / mean - 1.0) ** 2)), 0.0))


def _find_displacements(solution: ContactSolution, pressure: Array) -> Array:
    r"""Return the displacement by a pressure, each of its waves times :math:`\cos^2` of its angle to x, and to y.

    Shape (2, nx, ny), up to a common factor; the sum is the displacement itself.
    """
    grid = solution.grid
    if solution.boundary is not Boundary.PERIODIC:
        prepared = [DCFFT().prepare(BoundKernel(_WavesAlong(axis)), grid, Boundary.FREE) for axis in (0, 1)]
        return np.stack([convolution.apply(pressure) for convolution in prepared])
    waves = np.fft.rfft2(pressure)
    waves[0, 0] = 0.0
    qx = np.fft.fftfreq(grid.shape[0], grid.spacing[0])[:, np.newaxis]
    qy = np.fft.rfftfreq(grid.shape[1], grid.spacing[1])[np.newaxis, :]
    length = np.hypot(qx, qy)
    length[0, 0] = 1.0
    return np.stack([np.fft.irfft2(waves * component**2 / length**3, grid.shape) for component in (qx, qy)])


@attrs.frozen
class _WavesAlong(InfluenceKernel):
    r"""The displacement by pressure, with each wave multiplied by :math:`\cos^2` of its angle to an axis.

    Along x the response to a point force is :math:`y^2/r^3` in place of :math:`1/r`: its integral over a cell is the
    sum of :math:`\pm X \operatorname{asinh}(Y/|X|)` over the corners (X, Y).
    """

    axis: int

    def coefficients(self, shape: tuple[int, int], spacing: Pair, compliance: float) -> Array:
        if self.axis == 1:
            return _WavesAlong(0).coefficients(shape[::-1], spacing[::-1], compliance).T
        x = ((np.arange(shape[0] + 1) - 0.5) * spacing[0])[:, np.newaxis]
        y = ((np.arange(shape[1] + 1) - 0.5) * spacing[1])[np.newaxis, :]
        corners = x * np.arcsinh(y / np.abs(x))
        return np.asarray(np.diff(np.diff(corners, axis=0), axis=1) * (compliance / np.pi))


@responses.register("tangential-stiffness")
@attrs.frozen
class TangentialStiffness(Response[Estimate]):
    r"""Stiffness against a tangential force along an axis before any slip, N/m.

    With traction proportional to the normal answer q, which is exact for ellipses,

    .. math:: \frac{S_x}{S} = \frac{\sum_i c_i}{\sum_i c_i\, (1 - \nu_i \langle\cos^2\theta\rangle) / (1 - \nu_i)},
       \qquad c_i = \frac{1 - \nu_i^2}{E_i}

    where :math:`\theta` is the angle of a wave of q to the axis and the mean is weighted by the elastic energy of the
    waves. Round and isotropic contacts have 1/2, which gives Mindlin's :math:`2(1-\nu)/(2-\nu)` for like materials.
    Coupling of normal and tangential displacements is neglected, and bodies that differ are refused. For other contacts
    than ellipses the value is a lower bound unless Poisson's ratio is zero, because the true traction stores the
    smallest energy. The uncertainty contains the deficit, and a warning names it from half a per cent on.

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
                "The tangential stiffness follows from the normal one of two half-spaces, but this kernel is of a "
                "layer: choose kernel='love'."
            )
        if solution.saturated.any():
            raise InputError(
                "The pressure has reached its limit on a part of the contact, which resists a tangential force as a "
                "yielding solid: the tangential stiffness holds for elastic contact only."
            )
        plan = problem_of(solution).plan
        coupling = judge_coupling(plan.materials)
        normal = find_normal_answer(solution, "tangential stiffness")
        warnings = (*normal.warnings, *coupling)
        if not 0.0 < normal.value < math.inf:
            return Estimate(normal.value, 0.0, "N/m", warnings)
        compliance = find_tangential_compliance(solution, normal.field, normal.field > 0.0, self.axis)
        ratio = 1.0 / compliance.ratio
        too_small = compliance.excess
        if too_small > _MIN_WARNED_EXCESS:
            text = (
                f"the traction is taken to be in proportion to the normal answer, which makes the tangential stiffness "
                f"too small by about {100 * too_small:.1g} %"
            )
            warnings += (ContactWarning(text, "proportional traction", too_small),)
        std = ratio * math.hypot(normal.uncertainty, _EXCESS_STD_FACTOR * too_small * normal.value)
        return Estimate(ratio * normal.value, std, "N/m", warnings)
