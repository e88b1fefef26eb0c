"""A convolution with a local compliance: pressure on a cell displaces that cell by so much more."""

from __future__ import annotations

import attrs
import numpy as np

from roughcontact._base.arrays import Array, RealArray
from roughcontact._base.units import outlined
from roughcontact._parts.grid import Grid
from roughcontact._solve.convolvers.base import ConvolutionSetup, PreparedConvolution
from roughcontact._solve.convolvers.field_passes import FieldPasses
from roughcontact._solve.convolvers.inverse import InverseConvolution


@attrs.frozen(eq=False)
class SoftenedConvolution(PreparedConvolution):
    """A prepared convolution plus a local compliance, of which its inverse knows the mean.

    On a periodic boundary a uniform pressure, which the kernel lets displace nothing, displaces the cells.

    Attributes
    ----------
    hard
        The convolution without it.
    local
        Displacement of a cell by a unit pressure on it, a number or an array of numpy of shape (nx, ny), at least zero.
    """

    hard: PreparedConvolution
    local: float | Array = attrs.field(repr=outlined)

    @property
    def setup(self) -> ConvolutionSetup:
        """That of the convolution without local compliance."""
        return self.hard.setup

    @property
    def fixes_mean(self) -> bool:
        """False: a uniform pressure moves the cells."""
        return False

    @property
    def passes(self) -> type[FieldPasses] | None:
        """Those of the convolution without local compliance."""
        return self.hard.passes

    def apply(self, pressure: RealArray) -> RealArray:
        """Return the displacement; see `PreparedConvolution.apply`."""
        local = self.from_numpy(self.local) if isinstance(self.local, np.ndarray) else self.local
        moved: RealArray = self.hard.apply(pressure)
        moved += (local * pressure).astype(pressure.dtype, copy=False)
        return moved

    def on(self, grid: Grid) -> PreparedConvolution:
        """Return it on another grid: on a coarser one with the mean local compliance of its cells."""
        hard = self.hard.on(grid)
        if not isinstance(self.local, np.ndarray):
            return SoftenedConvolution(hard, self.local)
        fx, fy = (n // m for n, m in zip(self.local.shape, grid.shape, strict=True))
        nx, ny = grid.shape
        return SoftenedConvolution(hard, self.local.reshape(nx, fx, ny, fy).mean(axis=(1, 3)))

    def within(self, rows: slice, columns: slice) -> PreparedConvolution:
        """Return it on a rectangle of its cells."""
        local = self.local[rows, columns] if isinstance(self.local, np.ndarray) else self.local
        return SoftenedConvolution(self.hard.within(rows, columns), local)

    def inverse(self, dtype: type[np.float32] | type[np.float64] = np.float64) -> InverseConvolution:
        """Return the approximate inverse, exact where that of the convolution is and the compliance is uniform."""
        hard = self.hard.inverse(dtype)
        local = float(np.mean(self.local))
        stiffness = hard.stiffness / (1.0 + dtype(local) * hard.stiffness)
        exact = hard.exact and not isinstance(self.local, np.ndarray)
        return attrs.evolve(hard, stiffness=stiffness.astype(dtype, copy=False), exact=exact)

    def from_numpy(self, values: Array) -> Array:
        """Return an array in the form on which it works."""
        return self.hard.from_numpy(values)

    def to_numpy(self, values: Array) -> Array:
        """Return an array of that form as an array of numpy."""
        return self.hard.to_numpy(values)

    def sum(self, values: RealArray) -> float:
        """Return the sum over all cells."""
        return self.hard.sum(values)

    def dot(self, one: RealArray, other: RealArray) -> float:
        """Return the sum of products over all cells."""
        return self.hard.dot(one, other)
