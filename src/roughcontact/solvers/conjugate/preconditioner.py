"""The inverse kernel on the active cells."""

from __future__ import annotations

import numpy as np

from roughcontact.checks import Mask, RealArray
from roughcontact.convolvers import PlannedConvolution
from roughcontact.convolvers.inverse import InverseConvolution
from roughcontact.solvers.conjugate.lift import Lift
from roughcontact.solvers.conjugate.longwaves import Cells, LongWaves

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
        self._active: Mask = np.zeros(0, dtype=bool)
        # Weights of all cells, flat; those that were passive have the mean.
        self.field: RealArray = np.ones(shape[0] * shape[1], dtype=np.float32)
        self._waves: LongWaves | None = None
        self.renewals = 0
        self.products = 0

    def weights(self, active: Mask, cells: Cells) -> RealArray:
        """Return the flat-punch weights M 1 of the active cells, shape (n,), positive.

        They are renewed, at the price of a product, only when the active set has changed enough.

        Parameters
        ----------
        active
            Mask of all cells, flat.
        cells
            Flat indices of the active ones.
        """
        smaller = min(cells.size, active.size - cells.size + _PASSIVE * active.size)
        if self._active.size and np.count_nonzero(active ^ self._active) <= _CHANGED * smaller:
            return self.field[cells]
        weights = self._masked(cells, np.ones(cells.size, dtype=np.float32))
        mean = float(weights.mean())
        self._waves = None
        if mean > 0.0:
            # Ringing of the inverse may leave cells without weight, or with a negative one.
            weights = np.maximum(weights, np.float32(_SMALLEST_WEIGHT * mean))
            self._waves = LongWaves(self._inverse, self._shape, cells, weights)
        else:
            weights, mean = np.ones_like(weights), 1.0
        if self._lifting:
            self._lift = Lift(self._convolution, cells, weights)
            self.products += 2
        self._active = active
        self.field = np.full(active.size, mean, dtype=np.float32)
        self.field[cells] = weights
        self.renewals += 1
        return weights

    def apply(self, cells: Cells, weights: RealArray, residual: RealArray) -> RealArray:
        """Return the preconditioned residual on the active cells, shape (n,)."""
        image = self._masked(cells, residual)
        if self._waves is not None:
            corrected = image - self._waves.correction(cells, weights, residual)
            if float(np.einsum("i,i->", residual, corrected)) > 0.0:
                image = corrected
            else:
                # Where weights ring the correction may lose its sign; it is then of no use for this set.
                self._waves = None
        return image if self._lift is None else self._lift.lifted(image, residual, weights)

    def _masked(self, cells: Cells, values: RealArray) -> RealArray:
        self.products += 1
        return self._inverse.apply(spread(cells, values, self._shape)).ravel()[cells]


def spread(cells: Cells, values: RealArray, shape: tuple[int, int]) -> RealArray:
    """Return a field of the grid's shape that has `values` on `cells` and is zero elsewhere."""
    field = np.zeros(shape[0] * shape[1], dtype=values.dtype)
    field[cells] = values
    return field.reshape(shape)
