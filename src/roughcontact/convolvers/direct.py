"""The sum over all pairs of cells, without a transform: the oracle."""

from __future__ import annotations

import attrs
import numpy as np

from roughcontact.checks import Array, RealArray
from roughcontact.convolvers.base import Convolver, PlannedConvolution, Scene, require_boundary
from roughcontact.grid import Boundary, Grid
from roughcontact.kernels import BoundKernel


@attrs.frozen
class Direct(Convolver):
    """Direct summation: the work grows as the square of the number of cells, the memory only as it.

    It shares nothing with the transforms and is there to check them, and for very small grids.
    """

    @property
    def boundaries(self) -> frozenset[Boundary]:
        """Free and wrapped."""
        return frozenset({Boundary.FREE, Boundary.WRAPPED})

    def transform_shape(self, grid: Grid, boundary: Boundary) -> tuple[int, int]:
        """Return the grid's own shape."""
        return grid.shape

    def plan(self, kernel: BoundKernel, grid: Grid, boundary: Boundary) -> PlannedConvolution:
        """Return the planned sum; see `Convolver.plan`."""
        require_boundary(self, boundary)
        coefficients = kernel.coefficients(grid.shape, grid.spacing)
        scene = Scene(self, kernel, grid, boundary)
        return (_WrappedSum if boundary is Boundary.WRAPPED else _FreeSum)(scene, coefficients)


@attrs.frozen(eq=False)
class _FreeSum(PlannedConvolution):
    """All cells of the grid act on each other and nothing else does."""

    scene: Scene
    coefficients: Array

    def apply(self, pressure: RealArray) -> RealArray:
        """Return the displacement; see `PlannedConvolution.apply`."""
        nx, ny = self.coefficients.shape
        offsets = np.abs(np.arange(ny)[:, np.newaxis] - np.arange(ny))
        total = np.zeros((nx, ny), dtype=pressure.dtype)
        for distance, row in enumerate(self.coefficients):
            # One Toeplitz matrix for each distance in x serves all pairs of rows that far apart.
            matrix = row[offsets]
            total[distance:] += pressure[: nx - distance] @ matrix
            if distance:
                total[:-distance] += pressure[distance:] @ matrix
        return total


@attrs.frozen(eq=False)
class _WrappedSum(PlannedConvolution):
    """Each cell is acted on by the nearest image of every other."""

    scene: Scene
    coefficients: Array

    def apply(self, pressure: RealArray) -> RealArray:
        """Return the displacement; see `PlannedConvolution.apply`."""
        nx, ny = self.coefficients.shape
        offsets = np.abs(np.arange(ny)[:, np.newaxis] - np.arange(ny))
        offsets = np.minimum(offsets, ny - offsets)
        total = np.zeros((nx, ny), dtype=pressure.dtype)
        for shift in range(nx):
            row = self.coefficients[min(shift, nx - shift)]
            total += np.roll(pressure, shift, axis=0) @ row[offsets]
        return total
