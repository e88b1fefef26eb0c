"""Heights and fields in .npy files, of which each process reads and writes its own rows."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import roughcontact as rc
from numpy.lib import format as npy

from roughcontact_mpi.arrays import SlabArray
from roughcontact_mpi.processes import Processes


def read_heights(path: str | Path, processes: Processes | None = None, *, unit: float = 1.0) -> SlabArray:
    """Return the heights of a .npy file, m, of which each process reads its rows.

    Parameters
    ----------
    path
        A file that all processes can read, an array of shape (nx, ny).
    processes
        The processes; None: all that `mpiexec` has started.
    unit
        The length that a height of one means, m.

    Raises
    ------
    FileError
        If it cannot be read, or is not an array of numbers with two axes.
    InputError
        If a height is not finite.
    """
    processes = Processes() if processes is None else processes
    try:
        stored = np.load(path, mmap_mode="r", allow_pickle=False)
    except (OSError, ValueError, EOFError) as error:
        raise rc.FileError(f"{path} cannot be read as a .npy file: {error}") from error
    if not isinstance(stored, np.ndarray) or stored.ndim != 2 or stored.dtype.kind not in "fiu" or not stored.size:
        raise rc.FileError(f"{path} must hold one array of real numbers with two axes.")
    part = stored[processes.own_rows(stored.shape[0])].astype(np.float64)
    part *= unit
    heights = SlabArray.field(part, processes, stored.shape[0])
    processes.meet("read_heights")
    if not np.isfinite(heights).all():
        raise rc.InputError(f"{path} has heights that are not finite: points that were not measured must be filled.")
    return heights


def write_field(path: str | Path, field: SlabArray) -> None:
    """Write a field to a .npy file, of which each process writes its rows; an older file is replaced at the end.

    Parameters
    ----------
    path
        A file on a disk of all processes.
    field
        Shape (nx, ny).
    """
    processes = field.processes
    path = Path(path)
    part = path.with_name(f".{path.name}.part")
    if processes.rank == 0:
        npy.open_memmap(part, mode="w+", dtype=field.dtype, shape=field.shape).flush()
    processes.communicator.Barrier()
    if field.part.size:
        stored = npy.open_memmap(part, mode="r+")
        stored[processes.own_rows(field.shape[0])] = field.part
        stored.flush()
    processes.communicator.Barrier()
    if processes.rank == 0:
        os.replace(part, path)
    processes.communicator.Barrier()
