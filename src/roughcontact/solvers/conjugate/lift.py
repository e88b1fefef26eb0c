"""Pressures that lift the surface as a whole, which a given approach asks for and a given load forbids."""

from __future__ import annotations

import numpy as np

from roughcontact.checks import RealArray
from roughcontact.convolvers import PlannedConvolution
from roughcontact.solvers.conjugate.active import Active, dot, total

# Of two pressures that lift alike one is enough.
_DISTINCT = 1e-6


class Lift:
    r"""Solves exactly in the space of two pressures, the flat-punch weights and the uniform one.

    .. math:: z \leftarrow z - w\,\frac{\sum z}{\sum w} + V\,(V^T K V)^{-1} V^T r, \quad V = [w, 1]

    Parameters
    ----------
    convolution
        Displacement from pressure.
    active, weights
        The active cells and the vector of their weights.
    """

    def __init__(self, convolution: PlannedConvolution, active: Active, weights: RealArray) -> None:
        shape = convolution.scene.grid.shape
        vectors = _vectors(active, weights)
        responses = [active.take(convolution.apply(active.put(vector).reshape(shape)).ravel()) for vector in vectors]
        products = [[dot(one, other) for other in responses] for one in vectors]
        self._inverse = np.linalg.pinv(np.array(products), rcond=_DISTINCT)

    def lifted(self, active: Active, image: RealArray, residual: RealArray, weights: RealArray) -> RealArray:
        """Return the preconditioned residual with its lift made exact."""
        vectors = _vectors(active, weights)
        share = total(image) / total(weights)
        parts = self._inverse @ [dot(vector, residual) for vector in vectors]
        return image + np.float32(parts[0] - share) * vectors[0] + np.float32(parts[1]) * vectors[1]


def _vectors(active: Active, weights: RealArray) -> tuple[RealArray, RealArray]:
    return weights, active.ones
