"""The convolver interface, and the prepared convolutions of pressure and shear that solvers use."""

from __future__ import annotations

import abc
import functools
import math
from collections.abc import Callable, Hashable
from contextlib import AbstractContextManager, nullcontext
from functools import cached_property
from typing import Any, TypeVar

import attrs
import numpy as np
import numpy.typing as npt
import scipy

from roughcontact._base.arrays import (
    Array,
    Pair,
    RealArray,
    frozen_array,
    sum_of_products,
)
from roughcontact._base.checks import Part
from roughcontact._base.registry import Registry
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
from roughcontact._solve.convolvers.field_passes import FieldPasses
from roughcontact._solve.convolvers.inverse import InverseConvolution, invert_response
from roughcontact._solve.convolvers.matrix import WaveMatrix
from roughcontact._solve.convolvers.transforms import (
    half_waves,
    transform_extended,
)
from roughcontact.errors import InputError, argument

# Minimum sides of the padded grid of the inverse on a free boundary, over the domain, and in additional cells, so that
# opposite borders hardly interact. 1.125 and 1.5, 8 and 32 cells change the products of
# the default solver by less than 1 % (docs/studies/solver_constants.py).
_PADDING_FACTOR = 1.25
_PADDING_CELLS = 16
# Maximum cells of a grid whose convolution is kept for other solves, as a study has them, and whose convolution keeps
# its inverses, and how many convolutions are kept: preparing them takes a third of a solve on 64 x 64 cells. On a free
# boundary each part that can touch has its own.
_MAX_KEPT_CELLS = 2**16
_MAX_KEPT = 8

T = TypeVar("T")


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
            f"use {argument('boundary', 'free')} or {argument('boundary', 'periodic')}."
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
        return prepare_once(self.setup.convolver, self.setup.kernel, grid, self.setup.boundary)

    def within(self, rows: slice, columns: slice) -> PreparedConvolution:
        """Return the convolution of a rectangle of its cells, on a boundary that is free around it."""
        nx, ny = (part.stop - part.start for part in (rows, columns))
        dx, dy = self.setup.grid.spacing
        return self.on(Grid((nx, ny), (nx * dx, ny * dy)))

    @property
    def fixes_mean(self) -> bool:
        """Whether on a periodic boundary the mean displacement is zero whatever the pressure; by default it is."""
        return True

    def inverse(self, dtype: type[np.float32] | type[np.float64] = np.float64) -> InverseConvolution:
        """Return the approximate inverse, its stiffness in a precision."""
        return self._keep(np.dtype(dtype), lambda: approximate_inverse(self.setup, dtype))

    def _keep(self, key: Hashable, prepare: Callable[[], T]) -> T:
        """Return an inverse, which other solves on a small grid have prepared, or prepare it."""
        if self.setup.grid.cells > _MAX_KEPT_CELLS:
            return prepare()
        found: T | None = self._kept.get(key)
        if found is None:
            self._kept[key] = found = prepare()
        return found

    @cached_property
    def _kept(self) -> dict[Hashable, Any]:
        """The inverses found so far."""
        return {}

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

    @property
    def passes(self) -> type[FieldPasses] | None:
        """What solvers do to whole fields beside its products, where it brings that compiled; None: numpy does it."""
        return None

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


def prepare_once(convolver: Convolver, kernel: BoundKernel, grid: Grid, boundary: Boundary) -> PreparedConvolution:
    """Return the convolution of a kernel on a grid, on a small one that of the last solves if they had the same."""
    content = (convolver, kernel, grid, boundary)
    return (
        _kept_convolution(*content) if grid.cells <= _MAX_KEPT_CELLS and _is_hashable(content) else _prepare(*content)
    )


def _prepare(convolver: Convolver, kernel: BoundKernel, grid: Grid, boundary: Boundary) -> PreparedConvolution:
    prepared = convolver.prepare(kernel, grid, boundary)
    if not isinstance(prepared, PreparedConvolution):
        raise InputError(f"The convolver {convolver!r} must return a PreparedConvolution, not {prepared!r}.")
    return prepared


_kept_convolution = functools.lru_cache(_MAX_KEPT)(_prepare)


def _is_hashable(content: tuple[object, ...]) -> bool:
    # A part of the user's may hold lists, or arrays.
    try:
        hash(content)
    except Exception:
        return False
    return True


class ShearConvolution(abc.ABC):
    """The linear map from shear and pressure to displacement on one grid, with the constants of a pair of materials.

    Shear is the traction on the body; the displacement along z is towards the insides, along x and y that of the body
    minus that of the counterbody (`PairConstants`).

    Examples
    --------
    Shear on one cell presses the surface of a softer body in ahead of it:

    >>> import numpy as np
    >>> import roughcontact as rc
    >>> from roughcontact.typing import BoundKernel, PairConstants
    >>> kernel = BoundKernel(rc.Love(), pair=PairConstants(beta=0.3, gamma=0.4))
    >>> convolution = rc.DCFFT().prepare(kernel, rc.Grid((9, 9), 9.0), rc.Boundary.FREE).shear()
    >>> shear = np.zeros((2, 9, 9))
    >>> shear[0, 4, 4] = 1.0
    >>> print(convolution.apply(shear, to="z")[0, 3:6, 4].round(4) + 0.0)
    [-0.094  0.     0.094]
    """

    @property
    @abc.abstractmethod
    def setup(self) -> ConvolutionSetup:
        """Its convolver, kernel, grid and boundary; an attribute may define it."""

    @abc.abstractmethod
    def apply(self, tractions: RealArray, of: str = "xy", to: str = "xy") -> RealArray:
        """Return the displacement caused by tractions.

        Parameters
        ----------
        tractions
            The tractions, float64 or float32, shape (len(of), nx, ny); they are not changed.
        of
            The letter of each: ``"x"`` and ``"y"`` for shear, ``"z"`` for pressure.
        to
            The letter of each displacement.

        Returns
        -------
        RealArray
            Displacements in the same precision, shape (len(to), nx, ny).
        """

    @property
    def coupled(self) -> bool:
        """Whether pressure causes tangential displacement, and shear a normal one."""
        return self.setup.kernel.pair.beta != 0.0

    @cached_property
    def own(self) -> Pair:
        """The displacement of a cell by a unit shear on it, along x and along y, above zero."""
        unit = np.zeros((1, *self.setup.grid.shape))
        unit[0, 0, 0] = 1.0
        return float(self.apply(unit, "x", "x")[0, 0, 0]), float(self.apply(unit, "y", "y")[0, 0, 0])

    def on(self, grid: Grid) -> ShearConvolution:
        """Return the convolution of the same kernel and boundary on another grid: a coarser one, or a part."""
        return self.setup.convolver.prepare(self.setup.kernel, grid, self.setup.boundary).shear()

    def inverse(self, dtype: type[np.float32] | type[np.float64] = np.float64) -> WaveMatrix:
        """Return the approximate inverse of the map from shear to tangential displacement.

        It multiplies each wave by the inverse matrix of the kernel's spectrum on a periodic grid, the mean by zero: a
        good preconditioner, on a free boundary not an exact inverse.
        """
        if dtype not in self._inverses:
            self._inverses[dtype] = approximate_shear_inverse(self.setup, dtype)
        return self._inverses[dtype]

    @cached_property
    def _inverses(self) -> dict[type, WaveMatrix]:
        """The inverses found so far: a path of loads needs one many times."""
        return {}


def approximate_shear_inverse(setup: ConvolutionSetup, dtype: npt.DTypeLike) -> WaveMatrix:
    """Return the approximate inverse of the tangential part of a convolution of shear."""
    shape = setup.inverse_shape
    xx, yy, xy = (
        periodic_shear_spectrum(setup.kernel, component, shape, setup.grid.spacing) for component in ("xx", "yy", "xy")
    )
    determinant = xx * yy - xy**2
    # The mean wave.
    determinant[0, 0] = np.inf
    if not (determinant > 0.0).all():
        raise InputError(f"The response of the kernel {setup.kernel.kernel!r} to shear is not positive definite.")
    symbols = {"xx": yy / determinant, "yy": xx / determinant, "xy": -xy / determinant}
    return WaveMatrix({name: symbol.astype(dtype) for name, symbol in symbols.items()}, shape)


def periodic_shear_spectrum(kernel: BoundKernel, component: str, shape: tuple[int, int], spacing: Pair) -> Array:
    """Return the amplitudes of a component at half of the waves of a grid, shape (nx // 2 + 1, ny // 2 + 1)."""
    return kernel.shear_spectrum(component, *half_waves(shape, spacing), spacing)
