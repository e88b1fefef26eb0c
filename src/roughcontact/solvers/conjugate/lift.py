"""Pressures that lift the surface as a whole, which a given approach asks for and a given load forbids."""

from __future__ import annotations

import numpy as np

from roughcontact.checks import RealArray
from roughcontact.convolvers import PlannedConvolution
from roughcontact.solvers.conjugate.longwaves import Cells

# Of two pressures that lift alike one is enough.
_DISTINCT = 1e-6


class Lift:
    r"""Solves exactly in the space of two pressures, the flat-punch weights and the uniform one.

    .. math:: z \leftarrow z - w\,\frac{\sum z}{\sum w} + V\,(V^T K V)^{-1} V^T r, \quad V = [w, 1]

    Parameters
    ----------
    convolution
        Displacement from pressure.
    cells, weights
        Flat indices of the active cells and their weights, shape (n,).
    """

    def __init__(self, convolution: PlannedConvolution, cells: Cells, weights: RealArray) -> None:
        shape = convolution.scene.grid.shape
        vectors = _vectors(weights)
        responses = []
        for vector in vectors:
            field = np.zeros(shape[0] * shape[1], dtype=np.float32)
            field[cells] = vector
            responses.append(convolution.apply(field.reshape(shape)).ravel()[cells])
        products = [[float(np.einsum("i,i->", one, other)) for other in responses] for one in vectors]
        self._inverse = np.linalg.pinv(np.array(products), rcond=_DISTINCT, hermitian=False)

    def lifted(self, image: RealArray, residual: RealArray, weights: RealArray) -> RealArray:
        """Return the preconditioned residual with its lift made exact, shape (n,)."""
        vectors = _vectors(weights)
        share = float(np.add.reduce(image, dtype=np.float64)) / float(np.add.reduce(weights, dtype=np.float64))
        parts = self._inverse @ [float(np.einsum("i,i->", vector, residual)) for vector in vectors]
        return image + np.float32(parts[0] - share) * vectors[0] + np.float32(parts[1]) * vectors[1]


def _vectors(weights: RealArray) -> tuple[RealArray, RealArray]:
    return weights, np.ones_like(weights)
