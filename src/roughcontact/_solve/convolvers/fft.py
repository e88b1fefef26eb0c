"""Convolution by FFT: on a padded grid for the free boundary, and circular."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

import attrs
import numpy as np

from roughcontact._base.arrays import Array, RealArray, Waves
from roughcontact._base.units import outlined
from roughcontact._parts.grid import Boundary, Grid
from roughcontact._parts.kernels import BoundKernel, odd_axes
from roughcontact._solve.convolvers.base import (
    ConvolutionSetup,
    Convolver,
    PreparedConvolution,
    ShearConvolution,
    mixed_spectrum,
    periodic_shear_spectrum,
    require_shear,
    wrapped_spectrum,
)
from roughcontact._solve.convolvers.matrix import WaveMatrix
from roughcontact._solve.convolvers.transforms import (
    multiply_columns,
    multiply_waves,
    padded_shape,
    transform_offsets,
    transform_rows,
    transform_rows_back,
)


@attrs.frozen
class DCFFT(Convolver):
    """Linear convolution: zero-padded to at least 2n - 1 cells along a free axis, so that no image acts.

    The padded grid is never in memory: rows are padded along y only, and columns are padded,
    multiplied and cut a few at a time.

    References
    ----------
    Liu, Wang, Liu, Wear 243 (2000) 101-111, https://doi.org/10.1016/S0043-1648(00)00427-0

    Examples
    --------
    >>> import roughcontact as rc
    >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
    >>> problem = rc.ContactProblem(ball, grid=rc.Grid((32, 32), 100e-6), convolver=rc.DCFFT())
    >>> print(problem.solve(force=1.2).area())
    (778.331 +- 0.023) µm2, (7.78331 +- 0.00023) % of nominal [blend]
    """

    boundaries = frozenset({Boundary.FREE, Boundary.FREE_PERIODIC, Boundary.PERIODIC_FREE})

    def transform_shape(self, grid: Grid, boundary: Boundary) -> tuple[int, int]:
        """Return the cells of the padded grid; see `padded_shape`."""
        return padded_shape(grid, boundary)

    def prepare(self, kernel: BoundKernel, grid: Grid, boundary: Boundary) -> PreparedConvolution:
        setup = ConvolutionSetup(self, kernel, grid, boundary)
        padded = self.transform_shape(grid, boundary)
        return _PaddedConvolution(setup, _find_symbol(setup, padded, "zz"), padded)


def _find_symbol(setup: ConvolutionSetup, padded: tuple[int, int], component: str) -> Array:
    """Return the factors of a component for the waves of the padded grid, shape (mx // 2 + 1, my // 2 + 1)."""
    kernel = setup.kernel
    grid = setup.grid
    if setup.boundary.mixed:
        return mixed_spectrum(setup, padded, component)
    if component == "zz":
        return transform_offsets(kernel.coefficients(grid.shape, grid.spacing), padded)
    coefficients = kernel.shear_coefficients(component, grid.shape, grid.spacing)
    return transform_offsets(coefficients, padded, odd_axes(component))


@attrs.frozen(eq=False)
class _SymbolConvolution(PreparedConvolution):
    """Multiplication of waves by a symbol."""

    setup: ConvolutionSetup
    symbol: Array = attrs.field(repr=outlined)

    @cached_property
    def symbol_float32(self) -> RealArray:
        """The symbol in float32."""
        return self.symbol.astype(np.float32)

    def symbol_like(self, pressure: RealArray) -> RealArray:
        """Return the symbol in the precision of a pressure."""
        return self.symbol_float32 if pressure.dtype == np.float32 else self.symbol


@attrs.frozen(eq=False)
class _PaddedConvolution(_SymbolConvolution):
    """Transform with padding, multiply, cut; the symbol is stored for half of the waves in x."""

    padded: tuple[int, int]

    @cached_property
    def _shear(self) -> ShearConvolution:
        require_shear(self.setup)
        return _SymbolShear.of(
            self.setup, lambda component: _find_symbol(self.setup, self.padded, component), self.symbol, self.padded
        )

    def shear(self) -> ShearConvolution:
        return self._shear

    def apply(self, pressure: RealArray) -> RealArray:
        symbol = self.symbol_like(pressure)
        mx = self.padded[0]
        half = self.symbol.shape[0]

        def multiply(columns: Waves, block: slice) -> Waves:
            columns[:half] *= symbol[:, block]
            columns[half:] *= symbol[mx - half : 0 : -1, block]
            return columns

        waves = transform_rows(pressure, self.padded[1])
        multiply_columns(waves, mx, multiply)
        return transform_rows_back(waves, self.padded[1], pressure.shape[1])


@attrs.frozen
class CircularFFT(Convolver):
    """Multiplication in Fourier space, without padding.

    ``periodic``: the domain repeats without end and every image counts; the kernel's spectrum is used,
    and the mean displacement, which is arbitrary, is zero. ``wrapped``: only the nearest image of
    each cell counts, as in many codes that forget the padding; the kernel's coefficients are used.

    Examples
    --------
    >>> import roughcontact as rc
    >>> wave = rc.WavySurface(amplitude=1e-6, wavelength=50e-6)
    >>> body = rc.Body(wave, rc.Elastic(young=210e9, poisson=0.3))
    >>> grid = rc.Grid((32, 32), 100e-6)
    >>> problem = rc.ContactProblem(body, grid=grid, boundary="periodic", convolver=rc.CircularFFT())
    >>> print(problem.solve(pressure=100e6).area())
    (176.341 +- 0.069) µm2, (1.76341 +- 0.00069) % of nominal [blend]
    """

    boundaries = frozenset({Boundary.PERIODIC, Boundary.WRAPPED})

    def prepare(self, kernel: BoundKernel, grid: Grid, boundary: Boundary) -> PreparedConvolution:
        setup = ConvolutionSetup(self, kernel, grid, boundary)
        if boundary is Boundary.PERIODIC:
            return _CircularConvolution(setup, setup.spectrum)
        return _CircularConvolution(setup, wrapped_spectrum(kernel, grid.shape, grid.spacing))


@attrs.frozen(eq=False)
class _CircularConvolution(_SymbolConvolution):
    """Transform, multiply by the real symbol, transform back."""

    @cached_property
    def _shear(self) -> ShearConvolution:
        require_shear(self.setup)
        grid = self.setup.grid
        return _SymbolShear.of(
            self.setup,
            lambda component: periodic_shear_spectrum(self.setup.kernel, component, grid.shape, grid.spacing),
            self.symbol[: grid.shape[0] // 2 + 1],
            grid.shape,
        )

    def shear(self) -> ShearConvolution:
        return self._shear

    def apply(self, pressure: RealArray) -> RealArray:
        return multiply_waves(pressure, self.symbol_like(pressure), pressure.shape)


@attrs.frozen(eq=False)
class _SymbolShear(ShearConvolution):
    """Multiplication of waves by a matrix of symbols."""

    setup: ConvolutionSetup
    matrix: WaveMatrix

    @classmethod
    def of(
        cls, setup: ConvolutionSetup, find_symbol: Callable[[str], Array], normal: Array, padded: tuple[int, int]
    ) -> _SymbolShear:
        """Return the convolution from a function that gives the symbol of a component, and the symbol of zz."""
        components = ["xx", "yy", "xy"]
        if setup.kernel.pair.beta != 0.0:
            components += ["zx", "zy"]
        symbols = {"zz": normal} | {component: find_symbol(component) for component in components}
        return cls(setup, WaveMatrix({name: symbol for name, symbol in symbols.items() if symbol.any()}, padded))

    def apply(self, tractions: RealArray, of: str = "xy", to: str = "xy") -> RealArray:
        return self.matrix.apply(tractions, of, to)
