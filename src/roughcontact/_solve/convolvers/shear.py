"""The convolution of shear: displacements by tractions, component by component, and its approximate inverse."""

from __future__ import annotations

import abc
from collections.abc import Callable, Mapping
from functools import cached_property

import attrs
import numpy as np
import numpy.typing as npt
import scipy.fft

from roughcontact._base.arrays import Array, Pair, RealArray, Waves
from roughcontact._base.checks import choice
from roughcontact._base.units import outlined
from roughcontact._parts.grid import Grid
from roughcontact._parts.kernels import BoundKernel, odd_axes
from roughcontact._solve.convolvers.base import ConvolutionSetup
from roughcontact._solve.convolvers.transforms import multiply_columns, transform_rows, transform_rows_back
from roughcontact.errors import InputError


def find_component(to: str, of: str) -> tuple[str, int]:
    """Return the component that a kernel knows and the sign with which it gives the displacement `to` by `of`.

    `InputError` if a letter is not x, y or z.
    """
    for letter in (to, of):
        choice(letter, "The letter of a traction or displacement", ("x", "y", "z"))
    if of == "z" and to != "z":
        return of + to, -1
    return ("xy" if to + of == "yx" else to + of), 1


@attrs.frozen(eq=False)
class WaveMatrix:
    """The multiplication of each wave of several fields by a matrix, on a periodic grid that may be padded.

    Attributes
    ----------
    symbols
        The factor of each component, as in `SupportsShear`, or ``"zz"``, for half of the waves in x and in y, shape
        (mx // 2 + 1, my // 2 + 1). Of a component that is odd in one axis it is the imaginary part. A component that
        is missing is zero.
    padded
        Cells (mx, my) of the periodic grid.
    """

    symbols: Mapping[str, RealArray] = attrs.field(repr=outlined)
    padded: tuple[int, int]

    @cached_property
    def _symbols_float32(self) -> dict[str, RealArray]:
        return {name: symbol.astype(np.float32, copy=False) for name, symbol in self.symbols.items()}

    def apply(self, fields: RealArray, of: str = "xy", to: str = "xy") -> RealArray:
        """Return the products, shape (len(to), nx, ny), in the precision of the fields, shape (len(of), nx, ny).

        The letters of fields and products name the components.
        """
        count, nx, ny = fields.shape
        symbols = self._symbols_float32 if fields.dtype == np.float32 else self.symbols
        mx, my = self.padded
        rows = [[_find_real_component(letter, other) for other in of] for letter in to]

        def multiply(columns: Waves, block: slice) -> Waves:
            # The matrix is real if pressure is counted times i, and normal displacement over i.
            _turn(columns, of)
            products = np.empty((len(to), *columns.shape[1:]), dtype=columns.dtype)
            for product, row in zip(products, rows, strict=True):
                terms = [
                    (waves, symbols[name][:, block], sign, odd_axes(name)[0])
                    for waves, (name, sign) in zip(columns, row, strict=True)
                    if name in symbols
                ]
                _add_terms(product, terms)
            _turn(products, to)
            return products

        waves = transform_rows(fields.reshape(count * nx, ny), my).reshape(count, nx, -1)
        out = waves if len(of) == len(to) else np.empty((len(to), *waves.shape[1:]), dtype=waves.dtype)
        multiply_columns(waves, mx, multiply, out)
        return transform_rows_back(out.reshape(len(to) * nx, -1), my, ny).reshape(len(to), nx, ny)


def _find_real_component(to: str, of: str) -> tuple[str, int]:
    """Return component and sign for pressure times i and normal displacement over i; i times i is -1."""
    name, sign = find_component(to, of)
    return name, -sign if name == "zz" else sign


def _turn(waves: Waves, letters: str) -> None:
    """Multiply the waves of the normal field by i, in place."""
    for one, letter in zip(waves, letters, strict=True):
        if letter == "z":
            one *= 1j


def _add_terms(product: Waves, terms: list[tuple[Waves, RealArray, int, bool]]) -> None:
    """Set the product to the sum of waves times symbols, each with its sign, and whether it is odd in x.

    The symbols have half of the waves in x.
    """
    if not terms:
        product[...] = 0.0
        return
    half = terms[0][1].shape[0]
    for is_mirrored, part in enumerate((slice(half), slice(half, None))):
        target = product[part]
        for place, (waves, symbol, sign, is_odd) in enumerate(terms):
            factor = symbol[product.shape[0] - half : 0 : -1] if is_mirrored else symbol
            is_added = (sign > 0) != (is_mirrored and is_odd)
            if place == 0:
                np.multiply(waves[part], factor if is_added else -factor, out=target)
            elif is_added:
                target += waves[part] * factor
            else:
                target -= waves[part] * factor


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
    qx, qy = (2 * np.pi / step * scipy.fft.rfftfreq(n) for n, step in zip(shape, spacing, strict=True))
    return kernel.shear_spectrum(component, qx[:, np.newaxis], qy[np.newaxis, :], spacing)


@attrs.frozen(eq=False)
class SymbolShear(ShearConvolution):
    """Multiplication of waves by a matrix of symbols."""

    setup: ConvolutionSetup
    matrix: WaveMatrix

    @classmethod
    def of(
        cls, setup: ConvolutionSetup, find_symbol: Callable[[str], Array], normal: Array, padded: tuple[int, int]
    ) -> SymbolShear:
        """Return the convolution from a function that gives the symbol of a component, and the symbol of zz."""
        components = ["xx", "yy", "xy"]
        if setup.kernel.pair.beta != 0.0:
            components += ["zx", "zy"]
        symbols = {"zz": normal} | {component: find_symbol(component) for component in components}
        return cls(setup, WaveMatrix({name: symbol for name, symbol in symbols.items() if symbol.any()}, padded))

    def apply(self, tractions: RealArray, of: str = "xy", to: str = "xy") -> RealArray:
        return self.matrix.apply(tractions, of, to)
