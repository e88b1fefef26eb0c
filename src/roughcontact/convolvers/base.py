"""The convolver interface and the planned convolution that a solver works with."""

from __future__ import annotations

import abc

import numpy as np

from roughcontact.checks import Array, integer
from roughcontact.errors import InputError
from roughcontact.grid import Boundary, Grid
from roughcontact.kernels import BoundKernel


class PlannedConvolution(abc.ABC):
    """The linear map from pressure to displacement on one grid, ready to be applied.

    The reductions live here and not in the solvers, so that one solver serves arrays of any kind.
    """

    @abc.abstractmethod
    def apply(self, pressure: Array) -> Array:
        """Return the displacement caused by `pressure`, both of the grid's shape."""

    def sum(self, values: Array) -> float:
        """Return the sum over all cells."""
        return float(np.add.reduce(values, axis=None))

    def dot(self, one: Array, other: Array) -> float:
        """Return the sum of products over all cells."""
        # A BLAS dot would start threads that cost more than they save at these sizes.
        return float(np.einsum("ij,ij->", one, other))

    def max(self, values: Array) -> float:
        """Return the greatest value."""
        return float(np.maximum.reduce(values, axis=None))


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
