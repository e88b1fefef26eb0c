"""The sum over all pairs of cells, without a transform."""

from __future__ import annotations

from collections.abc import Mapping

import attrs
import numpy as np

from roughcontact._base.arrays import Array, IntArray, RealArray, matrix_product
from roughcontact._base.machine import split
from roughcontact._base.units import outlined
from roughcontact._parts.grid import Boundary, Grid
from roughcontact._parts.kernels import BoundKernel, odd_axes
from roughcontact._solve.convolvers.base import (
    ConvolutionSetup,
    Convolver,
    PreparedConvolution,
    ShearConvolution,
    require_shear,
)
from roughcontact._solve.convolvers.matrix import find_component

# Numbers of a Toeplitz matrix that are in memory at once: all of them up to 2048 cells along y.
_MAX_MATRIX_NUMBERS = 2**22


@attrs.frozen
class Direct(Convolver):
    """Direct summation: the work grows as the square of the number of cells, the memory in proportion to it.

    For very small grids, and to check the transforms, with which it shares no code.

    Examples
    --------
    >>> import roughcontact as rc
    >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
    >>> problem = rc.ContactProblem(ball, grid=rc.Grid((16, 16), 100e-6), convolver=rc.Direct())
    >>> print(f"{100 * problem.solve(force=1.0).area().fraction:.2f} % of nominal")
    6.89 % of nominal
    """

    boundaries = frozenset({Boundary.FREE, Boundary.WRAPPED})

    def prepare(self, kernel: BoundKernel, grid: Grid, boundary: Boundary) -> PreparedConvolution:
        setup = ConvolutionSetup(self, kernel, grid, boundary)
        return _DirectSum(setup, kernel.coefficients(grid.shape, grid.spacing))


@attrs.frozen(eq=False)
class _DirectSum(PreparedConvolution):
    """One Toeplitz matrix along y for each distance of rows along x."""

    setup: ConvolutionSetup
    coefficients: Array = attrs.field(repr=outlined)
    odd: tuple[bool, bool] = (False, False)
    """Whether the coefficients are odd in x, and in y."""

    def shear(self) -> ShearConvolution:
        require_shear(self.setup)
        grid = self.setup.grid
        components = {"zz": self}
        for name in ("xx", "yy", "xy", "zx", "zy"):
            coefficients = self.setup.kernel.shear_coefficients(name, grid.shape, grid.spacing)
            components[name] = _DirectSum(self.setup, coefficients, odd_axes(name))
        return _DirectShear(self.setup, components)

    def apply(self, pressure: RealArray) -> RealArray:
        nx, ny = self.coefficients.shape
        total = np.zeros((nx, ny), dtype=pressure.dtype)
        for part in split(ny, max(1, _MAX_MATRIX_NUMBERS // ny)):
            self._add(total[:, part], pressure, np.arange(ny)[part] - np.arange(ny)[:, np.newaxis])
        return total

    def _add(self, total: RealArray, pressure: RealArray, offsets: IntArray) -> None:
        """Add to some columns of the result; `offsets` are those of these from all columns."""
        nx, ny = self.coefficients.shape
        signs = np.sign(offsets).astype(pressure.dtype) if self.odd[1] else None
        offsets = np.abs(offsets)
        if self.setup.boundary is Boundary.WRAPPED:
            # Each cell is acted on by the nearest image of every other.
            offsets = np.minimum(offsets, ny - offsets)
            for shift in range(nx):
                row = self.coefficients[min(shift, nx - shift)]
                total += matrix_product(np.roll(pressure, shift, axis=0), row[offsets])
            return
        for distance, row in enumerate(self.coefficients):
            matrix = row[offsets] if signs is None else row[offsets] * signs
            total[distance:] += matrix_product(pressure[: nx - distance], matrix)
            if distance:
                back = matrix_product(pressure[distance:], matrix)
                total[:-distance] += -back if self.odd[0] else back


@attrs.frozen(eq=False)
class _DirectShear(ShearConvolution):
    """The direct sum of each component."""

    setup: ConvolutionSetup
    components: Mapping[str, _DirectSum] = attrs.field(repr=outlined)

    def apply(self, tractions: RealArray, of: str = "xy", to: str = "xy") -> RealArray:
        total = np.zeros((len(to), *tractions.shape[1:]), dtype=tractions.dtype)
        for displacement, letter in zip(total, to, strict=True):
            for traction, other in zip(tractions, of, strict=True):
                name, sign = find_component(letter, other)
                displacement += sign * self.components[name].apply(traction)
        return total
