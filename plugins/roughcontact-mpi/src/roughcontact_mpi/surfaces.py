"""Random heights of which each process makes its own rows."""

from __future__ import annotations

import numpy as np
import roughcontact as rc
import scipy.fft

from roughcontact_mpi.arrays import SlabArray
from roughcontact_mpi.convolver import Transpose, list_tiles, transform_back
from roughcontact_mpi.processes import Processes


def make_heights(surface: rc.SelfAffineSurface, grid: rc.Grid, processes: Processes | None = None) -> SlabArray:
    """Return the heights of a random surface, m, those of ``surface.heights(grid)`` but for rounding.

    Each process draws all random numbers, and keeps those of its waves: none has the whole field.

    Parameters
    ----------
    surface
        A self-affine surface.
    grid
        The grid, shape (nx, ny).
    processes
        The processes; None: all that `mpiexec` has started.

    Raises
    ------
    InputError
        If it is another surface, or its waves do not fit the grid.
    """
    processes = Processes() if processes is None else processes
    processes.require_random(surface, grid)
    processes.meet("make_heights")
    nx, ny = grid.shape
    own = processes.own_rows(nx)
    columns = processes.own_columns(ny // 2 + 1)
    half = surface.half_spectrum(grid, columns, processes.across)
    for tile in list_tiles(slice(0, half.shape[1]), 2 * nx):
        half[:, tile] = scipy.fft.ifft(half[:, tile], axis=0, norm="forward", overwrite_x=True)
    waves = np.empty((own.stop - own.start, ny // 2 + 1), dtype=half.dtype)
    transpose = Transpose(processes, processes.rows(nx), ny // 2 + 1)
    for block in range(transpose.blocks):
        transpose.back(half[:, transpose.own(block)], waves, block)
    del half
    return SlabArray.field(transform_back(waves, ny, ny, norm="forward"), processes, nx)
