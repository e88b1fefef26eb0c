"""The inverse kernel on the active cells."""

from __future__ import annotations

import numpy as np

from roughcontact.checks import Mask, RealArray
from roughcontact.convolvers import PlannedConvolution
from roughcontact.convolvers.inverse import InverseConvolution
from roughcontact.solvers.conjugate.active import Active, dot, total
from roughcontact.solvers.conjugate.lift import Lift
from roughcontact.solvers.conjugate.longwaves import LongWaves

# Share of the smaller of the active and the passive cells that may change before weights are renewed.
_CHANGED = 0.01
_PASSIVE = 0.02
_SMALLEST_WEIGHT = 1e-3


class Preconditioner:
    """Stiffness of the active cells, masked, with the long waves put right.

    Parameters
    ----------
    inverse
        The approximate inverse of the kernel.
    convolution
        Displacement from pressure.
    lifting
        Whether the surface may rise as a whole, because the approach is given.
    """

    def __init__(self, inverse: InverseConvolution, convolution: PlannedConvolution, *, lifting: bool) -> None:
        self._inverse = inverse
        self._convolution = convolution
        self._lifting = lifting
        self._lift: Lift | None = None
        self._shape = shape = convolution.scene.grid.shape
        self._mask: Mask = np.zeros(0, dtype=bool)
        # Weights of all cells, flat; those that were passive have the mean.
        self.field: RealArray = np.ones(shape[0] * shape[1], dtype=np.float32)
        self._waves: LongWaves | None = None
        self.products = 0

    def weights(self, active: Active) -> RealArray:
        """Return the vector of flat-punch weights M 1 of the active cells, positive.

        They are renewed, at the price of a product, only when the active set has changed enough.
        """
        mask = active.mask
        smaller = min(active.count, mask.size - active.count + _PASSIVE * mask.size)
        if self._mask.size and np.count_nonzero(mask ^ self._mask) <= _CHANGED * smaller:
            return active.take(self.field)
        ones = active.ones
        weights = self._masked(active, ones)
        mean = total(weights) / active.count
        self._waves = None
        if mean > 0.0:
            # Ringing of the inverse may leave cells without weight, or with a negative one.
            weights = np.maximum(weights, np.float32(_SMALLEST_WEIGHT * mean) * ones)
            self._waves = LongWaves(self._inverse, self._shape, active, weights)
        else:
            weights, mean = ones, 1.0
        if self._lifting:
            self._lift = Lift(self._convolution, active, weights)
            self.products += 2
        self._mask = mask
        self.field = np.full(mask.size, mean, dtype=np.float32)
        active.store(self.field, weights)
        return weights

    def apply(self, active: Active, weights: RealArray, residual: RealArray) -> RealArray:
        """Return the vector of the preconditioned residual."""
        image = self._masked(active, residual)
        if self._waves is not None:
            corrected = image - self._waves.correction(active, weights, residual)
            # Where weights ring the correction may lose its sign, and is of no use for this residual.
            if dot(residual, corrected) > 0.0:
                image = corrected
        return image if self._lift is None else self._lift.lifted(active, image, residual, weights)

    def _masked(self, active: Active, vector: RealArray) -> RealArray:
        self.products += 1
        return active.take(self._inverse.apply(active.put(vector).reshape(self._shape)).ravel())
