"""The convolver interface and the prepared convolution that a solver uses."""

from __future__ import annotations

import abc
from contextlib import AbstractContextManager, nullcontext
from functools import cached_property

import attrs
import numpy as np

from roughcontact._base.checks import Array, RealArray, frozen_array
from roughcontact._base.registry import Registry
from roughcontact._parts.grid import Boundary, Grid
from roughcontact._parts.kernels import (
    BoundKernel,
    InfluenceKernel,
    SupportsCoefficients,
    SupportsSpectrum,
    require_form,
)
from roughcontact._solve.convolvers.inverse import InverseConvolution, approximate_inverse, periodic_spectrum
from roughcontact.errors import InputError


class Convolver(abc.ABC):
    """A method to compute the displacement caused by a pressure.

    Examples
    --------
    >>> import roughcontact as rc
    >>> class Padded(rc.Convolver):
    ...     boundaries = frozenset({rc.Boundary.FREE})
    ...
    ...     def prepare(self, kernel, grid, boundary):
    ...         return rc.DCFFT().prepare(kernel, grid, boundary)
    >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
    >>> rc.ContactProblem(ball, grid=rc.Grid((32, 32), 100e-6), convolver=Padded()).solve(force=1.0).status.success
    True
    """

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

    It may work on arrays of another kind than numpy's, such as tensors on a GPU, as long as these follow numpy's
    protocols for ufuncs and functions: a solver then converts its task by `from_numpy`, and its result by `to_numpy`.
    """

    @property
    @abc.abstractmethod
    def setup(self) -> ConvolutionSetup:
        """What it was prepared from; an attribute may define it."""

    @abc.abstractmethod
    def apply(self, pressure: RealArray) -> RealArray:
        """Return the displacement caused by a pressure, both of the grid's shape and in one precision.

        The pressure, float64 or float32, is not changed; numpy arrays give numpy arrays.
        """

    def on(self, grid: Grid) -> PreparedConvolution:
        """Return the convolution of the same kernel and boundary on another grid: a coarser one, or a part."""
        return self.setup.convolver.prepare(self.setup.kernel, grid, self.setup.boundary)

    def inverse(self, dtype: type[np.float32] | type[np.float64] = np.float64) -> InverseConvolution:
        """Return the approximate inverse, its stiffness in a precision."""
        return approximate_inverse(self.setup, dtype)

    def from_numpy(self, values: Array) -> Array:
        """Return numpy's array as one of the kind on which it works; by default itself."""
        return values

    def to_numpy(self, values: Array) -> Array:
        """Return an array of that kind as numpy's; by default itself."""
        return values

    def use_threads(self, count: int) -> AbstractContextManager[None]:
        """Limit the threads used inside the context; the transforms of numpy arrays are limited already."""
        return nullcontext()

    def sum(self, values: RealArray) -> float:
        """Return the sum over all cells."""
        return float(np.add.reduce(values, axis=None))

    def dot(self, one: RealArray, other: RealArray) -> float:
        """Return the sum of products over all cells."""
        # A BLAS dot would start threads that cost more than they save at these sizes.
        return float(np.einsum("ij,ij->", one, other))
