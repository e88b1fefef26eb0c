"""The convolver interface and the planned convolution that a solver works with."""

from __future__ import annotations

import abc

import attrs
import numpy as np

from roughcontact.checks import RealArray, integer
from roughcontact.errors import InputError
from roughcontact.grid import Boundary, Grid
from roughcontact.kernels import BoundKernel


class Convolver(abc.ABC):
    """A way to compute displacement from pressure."""

    @property
    @abc.abstractmethod
    def boundaries(self) -> frozenset[Boundary]:
        """The boundaries it can serve."""

    @abc.abstractmethod
    def transform_shape(self, grid: Grid, boundary: Boundary) -> tuple[int, int]:
        """Return the number of cells (x, y) it works on, padding included."""

    @abc.abstractmethod
    def plan(self, kernel: BoundKernel, grid: Grid, boundary: Boundary) -> PlannedConvolution:
        """Return the planned convolution of `kernel` on `grid`.

        Raises
        ------
        InputError
            If the boundary is not served, or the kernel does not offer what is needed for it.
        """


@attrs.frozen
class Scene:
    """What a convolution was planned from."""

    convolver: Convolver
    kernel: BoundKernel
    grid: Grid
    boundary: Boundary


class PlannedConvolution(abc.ABC):
    """The linear map from pressure to displacement on one grid, ready to be applied.

    The reductions live here and not in the solvers, so that one solver serves arrays of any kind.
    """

    @property
    @abc.abstractmethod
    def scene(self) -> Scene:
        """What was planned; solvers plan coarser grids and parts of the domain from it."""

    @abc.abstractmethod
    def apply(self, pressure: RealArray) -> RealArray:
        """Return the displacement caused by `pressure`, both of the grid's shape and of one precision.

        A float32 pressure is convolved in float32.
        """

    def on(self, grid: Grid) -> PlannedConvolution:
        """Plan the same kernel and boundary on another grid."""
        return self.scene.convolver.plan(self.scene.kernel, grid, self.scene.boundary)

    def sum(self, values: RealArray) -> float:
        """Return the sum over all cells."""
        return float(np.add.reduce(values, axis=None))

    def dot(self, one: RealArray, other: RealArray) -> float:
        """Return the sum of products over all cells."""
        # A BLAS dot would start threads that cost more than they save at these sizes.
        return float(np.einsum("ij,ij->", one, other))


def require_boundary(convolver: Convolver, boundary: Boundary) -> None:
    """Raise `InputError` if `convolver` does not serve `boundary`."""
    if boundary not in convolver.boundaries:
        served = " or ".join(sorted(f"'{name}'" for name in convolver.boundaries))
        raise InputError(
            f"{convolver!r} serves the boundary {served}, not '{boundary}'; convolver='auto' chooses one that fits."
        )


def worker_count(value: int) -> int:
    """Check a number of threads."""
    return integer(value, "The number of workers", at_least=1)
