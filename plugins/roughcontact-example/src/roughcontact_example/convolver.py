"""A convolver."""

import attrs
import numpy as np
import scipy

import roughcontact as rc
from roughcontact.typing import Array, ConvolutionSetup, PreparedConvolution


@attrs.frozen
class SignalConvolver(rc.Convolver):
    """The free boundary by `scipy.signal.fftconvolve`."""

    boundaries = frozenset({rc.Boundary.FREE})

    def transform_shape(self, grid, boundary):
        """Return the number of cells of the transforms, padding included."""
        return 2 * grid.shape[0] - 1, 2 * grid.shape[1] - 1

    def prepare(self, kernel, grid, boundary):
        """Return the convolution of a kernel on a grid."""
        setup = ConvolutionSetup(self, kernel, grid, boundary)
        i, j = (np.abs(np.arange(1 - n, n)) for n in grid.shape)
        return SignalConvolution(setup, kernel.coefficients(grid.shape, grid.spacing)[np.ix_(i, j)])


@attrs.frozen(eq=False)
class SignalConvolution(PreparedConvolution):
    """Displacement from pressure, by the responses at all offsets, shape (2 nx - 1, 2 ny - 1)."""

    setup: ConvolutionSetup
    responses: Array

    def apply(self, pressure):
        """Return the displacement, shape (nx, ny), in the precision of the pressure."""
        return scipy.signal.fftconvolve(self.responses.astype(pressure.dtype), pressure, mode="valid")
