"""The convolver interface and the prepared convolution that a solver uses."""

from __future__ import annotations

import abc
from functools import cached_property

import attrs
import numpy as np
import scipy.fft

from roughcontact._kernels import BoundKernel, InfluenceKernel, SupportsCoefficients, SupportsSpectrum
from roughcontact._kernels.base import require_form
from roughcontact.checks import Array, Pair, RealArray, frozen_array
from roughcontact.errors import InputError
from roughcontact.grid import Boundary, Grid
from roughcontact.registry import Registry


class Convolver(abc.ABC):
    """A method to compute the displacement caused by a pressure."""

    @property
    @abc.abstractmethod
    def boundaries(self) -> frozenset[Boundary]:
        """The boundaries it can treat."""

    @abc.abstractmethod
    def prepare(self, kernel: BoundKernel, grid: Grid, boundary: Boundary) -> PreparedConvolution:
        """Return the convolution of a kernel on a grid, with all that does not depend on the pressure computed.

        Raises
        ------
        InputError
            If it cannot treat the boundary (`ConvolutionSetup` raises it), or the kernel lacks what it needs.
        """

    def require(self, kernel: InfluenceKernel, boundary: Boundary) -> None:
        """Raise `InputError` if it cannot treat the boundary, or the kernel lacks the form that is needed there.

        That is a spectrum on a periodic boundary and coefficients elsewhere; override it where that is otherwise.
        """
        if boundary not in self.boundaries:
            served = " or ".join(sorted(f"'{name}'" for name in self.boundaries))
            raise InputError(
                f"{self!r} serves the boundary {served}, not '{boundary!s:.9}'; convolver='auto' chooses one that fits."
            )
        require_form(kernel, SupportsSpectrum if boundary is Boundary.PERIODIC else SupportsCoefficients)

    def transform_shape(self, grid: Grid, boundary: Boundary) -> tuple[int, int]:
        """Return the number of cells (x, y) of its transforms, padding included; by default those of the grid."""
        return grid.shape


convolvers = Registry(Convolver, "convolver", "roughcontact.convolvers")


@attrs.frozen
class ConvolutionSetup:
    """The convolver, kernel, grid and boundary of a prepared convolution.

    Raises
    ------
    InputError
        If the convolver cannot treat the boundary.
    """

    convolver: Convolver
    kernel: BoundKernel
    grid: Grid
    boundary: Boundary

    def __attrs_post_init__(self) -> None:
        self.convolver.require(self.kernel.kernel, self.boundary)

    @cached_property
    def spectrum(self) -> Array:
        """The kernel's spectrum at the waves of the grid, which repeats, shape (nx, ny // 2 + 1), read-only."""
        return frozen_array(periodic_spectrum(self.kernel, self.grid.shape, self.grid.spacing))


class PreparedConvolution(abc.ABC):
    """The linear map from pressure to displacement on one grid.

    Solvers use its sums and products instead of their own, so that one solver serves arrays of any kind.
    """

    @property
    @abc.abstractmethod
    def setup(self) -> ConvolutionSetup:
        """What it was prepared from; an attribute may define it."""

    @abc.abstractmethod
    def apply(self, pressure: RealArray) -> RealArray:
        """Return the displacement caused by a pressure, both of the grid's shape and in one precision.

        The pressure, float64 or float32, is not changed.
        """

    def on(self, grid: Grid) -> PreparedConvolution:
        """Return the convolution of the same kernel and boundary on another grid: a coarser one, or a part."""
        return self.setup.convolver.prepare(self.setup.kernel, grid, self.setup.boundary)

    def sum(self, values: RealArray) -> float:
        """Return the sum over all cells."""
        return float(np.add.reduce(values, axis=None))

    def dot(self, one: RealArray, other: RealArray) -> float:
        """Return the sum of products over all cells."""
        # A BLAS dot would start threads that cost more than they save at these sizes.
        return float(np.einsum("ij,ij->", one, other))


def periodic_spectrum(kernel: BoundKernel, shape: tuple[int, int], spacing: Pair) -> Array:
    """Return the kernel's spectrum at the waves of a periodic grid, shape (nx, ny // 2 + 1)."""
    qx = 2 * np.pi / spacing[0] * scipy.fft.fftfreq(shape[0])[:, np.newaxis]
    qy = 2 * np.pi / spacing[1] * scipy.fft.rfftfreq(shape[1])[np.newaxis, :]
    return kernel.spectrum(qx, qy, spacing)
