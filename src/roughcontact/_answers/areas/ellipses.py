"""The contact ellipses of summits on bodies whose modulus depends on the direction."""

from __future__ import annotations

import attrs
import numpy as np

from roughcontact._base.arrays import Array, Mask

# Newton's steps, the largest change of the logarithm of the ratio of the axes in one, the step of its derivatives, and
# the residual that is a solution.
_STEPS = 25
_MAX_STEP = 0.7
_DIFFERENCE = 1e-6
_TOLERANCE = 1e-8
# Logarithm of the ratio of the axes beyond which the directions that are sampled do not resolve the ellipse.
_MAX_LOGARITHM = 3.0


@attrs.frozen(eq=False)
class Ellipses:
    """Contact ellipses, arrays of shape (count,): areas, m2, ratios of the axes, angles of the longer ones, rad.

    All but `known` is without meaning where no ellipse was found.
    """

    known: Mask
    area: Array
    axes_ratio: Array
    angle: Array


def find_ellipses(moduli: tuple[float, ...], force: Array, curvature: Array, deviator: Array) -> Ellipses:
    r"""Return the ellipses of paraboloids on anisotropic half-spaces.

    The pressure is Hertz's, an ellipsoid over an ellipse with the matrix W of its squared semi-axes. It displaces the
    surface by a paraboloid, whose curvatures K are those of the summit: by Fourier's transform, over all directions n,

    .. math:: K = \frac{3 F}{2} \left\langle \frac{n\,n^T}{E^*(n)\,(n^T W n)^{3/2}} \right\rangle

    Parameters
    ----------
    moduli
        E* of waves at equal angles from the x axis over half a turn, Pa.
    force
        Loads, shape (count,), N.
    curvature
        Half the sum of the principal curvatures, shape (count,), 1/m, above zero.
    deviator
        Half the difference of the xx and the yy curvature, and the xy curvature, shape (2, count), 1/m.

    References
    ----------
    Vlassak, Ciavarella, Barber, Wang, J. Mech. Phys. Solids 51 (2003) 1701-1721,
    https://doi.org/10.1016/S0022-5096(03)00066-8
    """
    angles = np.pi / len(moduli) * np.arange(len(moduli))
    double = np.stack((np.cos(2.0 * angles), np.sin(2.0 * angles)))
    compliance = 1.0 / np.array(moduli)
    sought = deviator / curvature
    # Half of the deviatoric part of the logarithm of W, whose determinant is one here.
    shape = np.zeros_like(sought)
    for _ in range(_STEPS):
        ratios = _find_ratios(shape, compliance, double)[1]
        residual = ratios - sought
        columns = [
            (_find_ratios(shape + step[:, np.newaxis], compliance, double)[1] - ratios) / _DIFFERENCE
            for step in _DIFFERENCE * np.eye(2)
        ]
        (a, c), (b, d) = columns
        determinant = a * d - b * c
        step = np.stack((d * residual[0] - b * residual[1], a * residual[1] - c * residual[0])) / determinant
        shape = shape - step * np.minimum(1.0, _MAX_STEP / np.maximum(np.hypot(*step), np.finfo(float).tiny))
    mean, ratios = _find_ratios(shape, compliance, double)
    size = np.hypot(*shape)
    known = (np.abs(ratios - sought).max(axis=0) < _TOLERANCE) & (size < _MAX_LOGARITHM)
    # The product of the semi-axes.
    product = (1.5 * force * mean / (2.0 * curvature)) ** (2.0 / 3.0)
    return Ellipses(known, np.pi * product, np.exp(size), 0.5 * np.arctan2(shape[1], shape[0]))


def _find_ratios(shape: Array, compliance: Array, double: Array) -> tuple[Array, Array]:
    """Return the mean of the compliance over (n W n)^(3/2), (count,), and its second harmonics over it, (2, count)."""
    size = np.hypot(*shape)
    factor = np.sinh(size) / np.where(size > 0.0, size, 1.0)
    factor = np.where(size > 0.0, factor, 1.0)
    square = np.cosh(size)[:, np.newaxis] + factor[:, np.newaxis] * (shape.T @ double)
    weighted = compliance / (square * np.sqrt(square))
    mean = weighted.mean(axis=1)
    return mean, (weighted @ double.T / compliance.size).T / mean
