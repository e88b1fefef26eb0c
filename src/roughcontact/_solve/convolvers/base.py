"""The convolver interface, the prepared convolution that a solver uses, and its approximate inverse."""

from __future__ import annotations

import abc
import itertools
import math
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar

import attrs
import numpy as np
import numpy.typing as npt
import scipy.fft

from roughcontact._base.arrays import (
    Array,
    IntArray,
    Pair,
    RealArray,
    frozen_array,
    matrix_product,
    sum_of_products,
)
from roughcontact._base.checks import Part
from roughcontact._base.machine import map_tiles, tiles_of
from roughcontact._base.registry import Registry
from roughcontact._base.units import outlined
from roughcontact._parts.grid import Boundary, Grid
from roughcontact._parts.kernels import (
    BoundKernel,
    InfluenceKernel,
    SupportsCoefficients,
    SupportsShear,
    SupportsSpectrum,
    odd_axes,
    require_form,
)
from roughcontact._parts.surfaces import Surface
from roughcontact._solve.convolvers.transforms import multiply_waves, multiply_waves_of_rows, transform_extended
from roughcontact.errors import InputError

if TYPE_CHECKING:
    from roughcontact._solve.convolvers.shear import ShearConvolution

# Minimum sides of the padded grid of the inverse on a free boundary, over the domain, and in additional cells, so that
# opposite borders hardly interact. 1.125 and 1.5, 8 and 32 cells change the products of
# the default solver by less than 1 % (docs/studies/solver_constants.py).
_PADDING_FACTOR = 1.25
_PADDING_CELLS = 16
# Minimum amplitude that is inverted, over the mean: smaller ones are rounding, or ringing of the kernel.
_MIN_AMPLITUDE = 1e-6


@attrs.frozen(eq=False)
class InverseConvolution:
    """Division by the kernel's spectrum on a periodic grid: a good preconditioner, not an exact inverse.

    A subclass for another kind of array overrides `multiply`; one for parts of arrays `long_waves`, `blocks` and
    `add_near` too.

    Attributes
    ----------
    local
        Whether its effect on a few cells is cheaper by `coefficients` than by a product.
    by_rows
        Whether `multiply` saves work where few rows are not zero.
    stiffness
        Pressure amplitude per displacement amplitude of each wave, not negative, zero for the mean,
        shape (mx, my // 2 + 1).
    padded
        Cells (mx, my) of the periodic grid.
    exact
        Whether it inverts the convolution, but for the mean.
    """

    local: ClassVar[bool] = True
    by_rows: ClassVar[bool] = True

    stiffness: RealArray = attrs.field(repr=outlined)
    padded: tuple[int, int]
    exact: bool = False

    @cached_property
    def axes(self) -> tuple[RealArray, RealArray]:
        """The stiffness of the waves along x and along y, arrays of numpy."""
        return self.stiffness[: self.padded[0] // 2 + 1, 0], self.stiffness[0]

    def long_waves(self, rows: IntArray, columns: int) -> RealArray:
        """Return the stiffness of some waves along x and of the first ones along y."""
        found: RealArray = self.stiffness[rows][:, :columns]
        return found

    def blocks(self, active: Any, partition: Any) -> Any:
        """Return active cells by blocks of a partition, which sum vectors and spread values."""
        return active.blocks(partition)

    def apply(self, displacement: RealArray) -> RealArray:
        """Return the pressure, of the shape and precision of `displacement` (float32 or float64)."""
        return self.multiply(displacement, self.stiffness, self.padded)

    def multiply(
        self, values: RealArray, symbol: RealArray, padded: tuple[int, int], rows: IntArray | None = None
    ) -> RealArray:
        """Return a field with each of its waves multiplied by a real symbol, shape of `values`.

        Parameters
        ----------
        values
            A field, which is padded with zeros, shape (nx, ny).
        symbol
            The factors, in its precision, shape (mx, my // 2 + 1).
        padded
            Cells (mx, my) of the periodic grid.
        rows
            Rows outside which the field is zero and the result is arbitrary; None for all rows.
        """
        if rows is None:
            return multiply_waves(values, symbol, padded)
        return multiply_waves_of_rows(values, rows, symbol, padded)

    def coefficients(self, reach: int, first: int = 0) -> RealArray:
        """Return the pressure at (i, j) cells from a unit displacement of one, shape (reach + 1, reach + 1).

        The part of it due to the waves along y from the first one on for which there is a stiffness.
        """
        mx, my = self.padded
        columns = np.arange(first, first + self.stiffness.shape[1])
        offsets = 2.0 * np.pi * np.arange(reach + 1)
        x = np.cos(np.outer(offsets, np.arange(mx) / mx)).astype(self.stiffness.dtype) / mx
        y = np.cos(np.outer(columns / my, offsets)).astype(self.stiffness.dtype) / my
        # Half of the waves along y are stored; each counts twice, except the first and, if even, the last.
        y[(columns > 0) & (2 * columns < my)] *= 2.0
        return matrix_product(matrix_product(x, self.stiffness), y)

    def add_near(
        self, field: RealArray, shape: tuple[int, int], cells: IntArray, amounts: RealArray, stencil: RealArray
    ) -> None:
        """Add amounts times a stencil, as of `coefficients`, around cells of a flat field, in place."""
        nx, ny = shape
        padded = self.padded
        # On a small periodic grid a cell is reached once.
        reach = tuple(min(n - 1, (m - 1) // 2) for n, m in zip(stencil.shape, padded, strict=True))
        rows, columns = np.divmod(cells, ny)
        far = (np.minimum(rows, nx - 1 - rows) >= reach[0]) & (np.minimum(columns, ny - 1 - columns) >= reach[1])
        inner = cells[far]
        inner_amounts = amounts[far]
        near = ~far
        rows = rows[near]
        columns = columns[near]
        near_amounts = amounts[near]
        for i, j in itertools.product(*(range(-n, n + 1) for n in reach)):
            value = stencil[abs(i), abs(j)]
            field[inner + (i * ny + j)] += value * inner_amounts
            if near_amounts.size:
                row = (rows + i) % padded[0]
                column = (columns + j) % padded[1]
                inside = (row < nx) & (column < ny)
                field[row[inside] * ny + column[inside]] += value * near_amounts[inside]


def approximate_inverse(setup: ConvolutionSetup, dtype: npt.DTypeLike = np.float64) -> InverseConvolution:
    """Return the approximate inverse of a convolution, its stiffness in the given precision."""
    shape = setup.inverse_shape
    if setup.boundary is Boundary.PERIODIC:
        response = setup.spectrum
    else:
        known = isinstance(setup.kernel.kernel, SupportsSpectrum)
        spectrum = periodic_spectrum if known else wrapped_spectrum
        response = spectrum(setup.kernel, shape, setup.grid.spacing)
    stiffness, raised = invert_response(response, dtype, response.size)
    return InverseConvolution(stiffness, shape, setup.boundary is Boundary.PERIODIC and not raised)


def invert_response(
    response: RealArray,
    dtype: npt.DTypeLike,
    size: int,
    across: Callable[[np.ufunc, float], float] = lambda _, value: value,
    *,
    has_mean: bool = True,
) -> tuple[RealArray, bool]:
    """Return the stiffness of waves from their response, zero for the mean, and whether a response was too small.

    Parameters
    ----------
    response
        The response of all waves, or of those of a part that has some of the columns.
    dtype
        Type of the stiffness.
    size
        Number of waves of all parts.
    across
        Function of a ufunc and a number of this part that returns the sum or the minimum over all parts.
    has_mean
        Whether the first wave is the mean.
    """
    tiles = tiles_of(response)

    def measure(rows: slice) -> tuple[float, float]:
        return _measure_response(response[rows], is_first=has_mean and rows.start == 0)

    sums, minima = zip(*map_tiles(measure, tiles), strict=True)
    floor = _MIN_AMPLITUDE * (across(np.add, math.fsum(sums)) / size)
    raised = not across(np.minimum, min(minima)) > floor
    stiffness = np.empty(response.shape, dtype=dtype)

    def invert(rows: slice) -> None:
        amplitude = np.abs(response[rows])
        vanishing = amplitude == 0.0
        np.divide(1.0, np.maximum(amplitude, floor, out=amplitude), out=stiffness[rows], casting="same_kind")
        stiffness[rows][vanishing] = 0.0

    map_tiles(invert, tiles)
    if has_mean:
        stiffness[0, 0] = 0.0
    return stiffness, raised


def _measure_response(rows: RealArray, *, is_first: bool) -> tuple[float, float]:
    """Return the sum of the amplitudes in rows, and the minimum, without the mean wave, which is the first of all."""
    values = rows.ravel()[1 if is_first else 0 :]
    return float(np.abs(values).sum()), float(values.min(initial=math.inf))


def periodic_spectrum(
    kernel: BoundKernel, shape: tuple[int, int], spacing: Pair, columns: slice = slice(None)
) -> Array:
    """Return the kernel's spectrum at the waves of a periodic grid, shape (nx, ny // 2 + 1), or columns of it."""
    qx = 2 * np.pi / spacing[0] * scipy.fft.fftfreq(shape[0])[:, np.newaxis]
    qy = 2 * np.pi / spacing[1] * scipy.fft.rfftfreq(shape[1])[np.newaxis, columns]
    return kernel.spectrum(qx, qy, spacing) if qy.size else np.zeros((shape[0], 0))


def wrapped_spectrum(kernel: BoundKernel, shape: tuple[int, int], spacing: Pair) -> Array:
    """Return the transform of the coefficients of the nearest images, shape (nx, ny // 2 + 1)."""
    nearest = kernel.coefficients((shape[0] // 2 + 1, shape[1] // 2 + 1), spacing)
    i, j = (np.minimum(np.arange(n), n - np.arange(n)) for n in shape)
    return np.ascontiguousarray(scipy.fft.rfft2(nearest[np.ix_(i, j)]).real)


def mixed_spectrum(setup: ConvolutionSetup, padded: tuple[int, int], component: str = "zz") -> Array:
    """Return the factors of a component where one axis is free, shape (mx // 2 + 1, my // 2 + 1).

    The padded grid has the cells of the grid along the periodic axis, and at least twice as many, less one, along the
    free one.
    """
    boundary = setup.boundary
    free = boundary.free_axis
    length = padded[free]
    coefficients = setup.kernel.mixed_coefficients(setup.grid, boundary, component, length // 2 + 1)
    odd = odd_axes(component)[free]
    return transform_extended(coefficients, length, odd, axis=free)


class Convolver(Part, abc.ABC):
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
        """Raise `InputError` if it cannot treat the boundary, or the kernel lacks the form needed there.

        The form is a spectrum on a periodic boundary and coefficients elsewhere, both where one axis is periodic and
        the other free; override it if that differs.
        """
        if boundary not in self.boundaries:
            served = " or ".join(sorted(f"'{name}'" for name in self.boundaries))
            raise InputError(
                f"{self!r} serves the boundary {served}, not '{boundary!s:.9}'; convolver='auto' chooses one that fits."
            )
        if boundary is not Boundary.PERIODIC:
            require_form(kernel, SupportsCoefficients)
        if boundary is Boundary.PERIODIC or boundary.mixed:
            require_form(kernel, SupportsSpectrum)

    def transform_shape(self, grid: Grid, boundary: Boundary) -> tuple[int, int]:
        """Return the number of cells (x, y) of its transforms, padding included; by default those of the grid."""
        return grid.shape

    def heights(self, surface: Surface, grid: Grid) -> Array:
        """Return the heights of a surface, shape `grid.shape`, m; it may transform their waves where it transforms."""
        return surface.heights(grid)


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
        """The kernel's spectrum at the waves of the periodic grid, shape (nx, ny // 2 + 1), read-only."""
        return frozen_array(periodic_spectrum(self.kernel, self.grid.shape, self.grid.spacing))

    def spectrum_of_columns(self, shape: tuple[int, int], columns: slice) -> Array:
        """Return columns of the kernel's spectrum at the waves of a periodic grid of cells as here, shape (mx, n)."""
        return periodic_spectrum(self.kernel, shape, self.grid.spacing, columns)

    def stiffness_of_columns(
        self, columns: slice, dtype: npt.DTypeLike, across: Callable[[np.ufunc, float], float]
    ) -> tuple[RealArray, bool]:
        """Return columns of the stiffness of the approximate inverse, shape (mx, n), and whether it is exact.

        `across` is a function of a ufunc, `np.add` or `np.minimum`, and a number of these columns that returns the sum
        or the minimum over all parts, which together have each of the my // 2 + 1 columns once.
        """
        mx, my = self.inverse_shape
        response = self.spectrum_of_columns(self.inverse_shape, columns)
        has_mean = columns.start == 0 < columns.stop
        stiffness, raised = invert_response(response, dtype, mx * (my // 2 + 1), across, has_mean=has_mean)
        return stiffness, self.boundary is Boundary.PERIODIC and not raised

    @property
    def inverse_shape(self) -> tuple[int, int]:
        """The cells of the periodic grid of the approximate inverse, along free axes with those of its padding."""
        mx, my = (
            scipy.fft.next_fast_len(max(math.ceil(_PADDING_FACTOR * n), n + _PADDING_CELLS), real=True) if free else n
            for n, free in zip(self.grid.shape, self.boundary.free_axes, strict=True)
        )
        return mx, my


def require_shear(setup: ConvolutionSetup) -> None:
    """Raise `InputError` if there is no convolution of shear for the kernel or on the boundary."""
    require_form(setup.kernel.kernel, SupportsShear)
    if setup.boundary is Boundary.WRAPPED:
        raise InputError(
            "A wrapped boundary has no response to shear, whose sign at half of the domain would be arbitrary: "
            "use boundary='free' or boundary='periodic'."
        )


class PreparedConvolution(abc.ABC):
    """The linear map from pressure to displacement on one grid.

    It may work on other arrays than numpy's, such as tensors on a GPU, if these follow numpy's protocols for ufuncs and
    functions: a solver then converts its task by `from_numpy`, and its result by `to_numpy`.
    """

    @property
    @abc.abstractmethod
    def setup(self) -> ConvolutionSetup:
        """Its convolver, kernel, grid and boundary; an attribute may define it."""

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

    def shear(self) -> ShearConvolution:
        """Return the linear map from shear and pressure to displacement, for the pair of materials of the kernel.

        Raises
        ------
        InputError
            If the kernel has no response to shear, on a wrapped boundary, or if the convolver has no convolution of
            shear, which is the default.
        """
        require_shear(self.setup)
        raise InputError(
            f"{self.setup.convolver!r} has no convolution of shear, which friction needs: use convolver='auto'."
        )

    def from_numpy(self, values: Array) -> Array:
        """Return a numpy array in the form on which it works; by default itself."""
        return values

    def to_numpy(self, values: Array) -> Array:
        """Return an array of that form as a numpy array; by default itself."""
        return values

    def use_threads(self, count: int) -> AbstractContextManager[None]:
        """Limit the threads used inside the context; the transforms of numpy arrays are limited already."""
        return nullcontext()

    def sum(self, values: RealArray) -> float:
        """Return the sum over all cells."""
        return float(np.add.reduce(values, axis=None))

    def dot(self, one: RealArray, other: RealArray) -> float:
        """Return the sum of products over all cells."""
        return sum_of_products(one, other)
