"""The convolution of shear: displacements by tractions, and its approximate inverse."""

from __future__ import annotations

import abc
from collections.abc import Callable
from functools import cached_property

import attrs
import numpy as np
import numpy.typing as npt

from roughcontact._base.arrays import Array, Pair, RealArray
from roughcontact._parts.grid import Grid
from roughcontact._parts.kernels import BoundKernel
from roughcontact._solve.convolvers.base import ConvolutionSetup
from roughcontact._solve.convolvers.matrix import WaveMatrix
from roughcontact._solve.convolvers.transforms import half_waves
from roughcontact.errors import InputError


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
