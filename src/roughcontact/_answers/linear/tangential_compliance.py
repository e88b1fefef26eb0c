"""The tangential over the normal compliance of a contact under a given traction, along an axis."""

from __future__ import annotations

import math

import attrs
import numpy as np

from roughcontact._answers.linear.coupling import compare_compliances
from roughcontact._base.checks import Array, Mask, Pair, integer
from roughcontact._parts.grid import Boundary
from roughcontact._parts.kernels import BoundKernel, InfluenceKernel
from roughcontact._solve.convolvers import DCFFT
from roughcontact._solve.problem import problem_of
from roughcontact._solve.solution import ContactSolution
from roughcontact.errors import InputError

# By how much a traction in proportion to a normal pressure makes the compliance too large, over the product of
# Poisson's ratio and the standard deviation of the displacement that it causes where that should be uniform: 0.25 to
# 0.5 on rough surfaces and waves beside the traction that minimizes the energy (benchmarks/response_classes.py).
_EXCESS = 0.4


@attrs.frozen
class TangentialCompliance:
    """The tangential over the normal compliance.

    Attributes
    ----------
    ratio
        Along the axis of the force.
    excess
        About how much too large it is, relative: only ellipses have tractions in proportion to normal pressures.
    anisotropy
        By how much waves along the force are stiffer than those across it, relative: Poisson's ratio of like materials.
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
    """Return the compliance along an axis under a traction of the shape of a normal pressure.

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
    bound, free = (compare_compliances(plan.materials, plan.modulus, cosine) for cosine in (1.0, 0.0))
    anisotropy = 1.0 - bound / free
    # A force that rounding hides leaves no traction.
    traction = traction if traction.any() else solution.pressure
    displacements = _find_displacements(solution, traction / float(np.abs(traction).max()))
    energies = np.einsum("ij,kij->k", traction, displacements)
    total = float(energies.sum())
    cosine = float(energies[axis]) / total if total > 0.0 else 0.5
    displacement = displacements.sum(axis=0) - anisotropy * displacements[axis]
    deviation = _find_deviation(displacement, np.where(stick, traction, 0.0))
    ratio = free * (1.0 - anisotropy * cosine)
    return TangentialCompliance(ratio, _EXCESS * anisotropy * deviation, anisotropy)


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
    r"""The displacement by pressure, each wave of it times :math:`\cos^2` of its angle to an axis.

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
