"""Displacement over pressure as dense matrices, without any convolver: what small grids are judged by."""

from __future__ import annotations

import numpy as np

from roughcontact.checks import Array
from roughcontact.grid import Boundary, Grid
from roughcontact.kernels import BoundKernel
from roughcontact.kernels.offsets import responses

FREE, PERIODIC, WRAPPED = Boundary.FREE, Boundary.PERIODIC, Boundary.WRAPPED


def offset_matrix(table: Array, boundary: Boundary) -> Array:
    """Return the matrix, cells by cells, of a table of responses by offset, shape (nx, ny)."""
    nx, ny = table.shape
    i, j = (np.abs(np.arange(n)[:, np.newaxis] - np.arange(n)) for n in (nx, ny))
    if boundary is not FREE:
        i, j = np.minimum(i, nx - i), np.minimum(j, ny - j)
    return np.asarray(table[i[:, np.newaxis, :, np.newaxis], j[np.newaxis, :, np.newaxis, :]].reshape(nx * ny, nx * ny))


def dense_matrix(kernel: BoundKernel, grid: Grid, boundary: Boundary) -> Array:
    """Return the matrix, cells by cells, of a kernel on a grid."""
    return offset_matrix(responses(kernel, grid, boundary), boundary)
