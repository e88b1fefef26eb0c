"""The processes of a solve, the rows of each, and what they send each other."""

from __future__ import annotations

import os
import time
from collections.abc import Sequence
from typing import Any

import numpy as np
import roughcontact as rc
from roughcontact.slabs import SlabProcesses
from roughcontact.typing import RealArray

# Where the mpiexec of MPICH and of Open MPI states the number of processes.
_STARTED = ("PMI_SIZE", "OMPI_COMM_WORLD_SIZE")
# Seconds between two looks for the other processes.
_LOOK = 0.005
# Seconds from the sentence to the end of the job: mpiexec loses what it has not passed on by then.
_DELIVERY = 0.3


class Processes(SlabProcesses):
    """The processes of an MPI communicator that solve one contact.

    Each calls the same functions in the same order, and gets the same numbers.

    Parameters
    ----------
    communicator
        A communicator of mpi4py; None: all processes that `mpiexec` has started.
    patience
        Seconds for which a process waits at `meet` until all others have come.

    Raises
    ------
    InputError
        If there is no MPI, or not the one of `mpiexec`.
    """

    name = "roughcontact_mpi"

    def __init__(self, communicator: Any = None, patience: float = 600.0) -> None:
        if communicator is None:
            try:
                from mpi4py import MPI
            except (ImportError, RuntimeError) as error:
                raise rc.InputError(
                    "No MPI was found: load that of this machine, or install one by 'pip install mpich'."
                ) from error
            communicator = MPI.COMM_WORLD
            started = max(int(os.environ.get(name, "1")) for name in _STARTED)
            if communicator.Get_size() < started:
                raise rc.InputError(
                    f"mpiexec has started {started} processes, but mpi4py uses another MPI, in which each is alone: "
                    "use the mpiexec of that MPI, or install only one."
                )
        self.communicator = communicator
        self.patience = patience
        self.rank = communicator.Get_rank()
        self.count = communicator.Get_size()

    def meet(self, call: str) -> None:
        """Wait until all processes have made a call; `InputError` if one does not, for which the others would wait."""
        arrival = self.communicator.Ibarrier()
        end = time.monotonic() + self.patience
        while not arrival.Test():
            if time.monotonic() > end:
                raise rc.InputError(
                    f"Only some of {self.count} processes have called {call} within {self.patience:g} s: all must make "
                    "the same calls in the same order; if some come later, choose a longer patience=."
                )
            time.sleep(_LOOK)

    def collect(self, value: Any) -> RealArray:
        """Return a number or an array of each process, of one shape on all, shape (count, ...)."""
        own = np.asarray(value, order="C")
        self.reductions += 1
        if self.count == 1:
            return own[np.newaxis]
        found = np.empty((self.count, *own.shape), dtype=own.dtype)
        self.communicator.Allgather(own, found)
        return found

    def total_blocks(self, values: RealArray) -> RealArray:
        """Return the sum of an array over all processes, of the same bits on each."""
        self.reductions += 1
        if self.count == 1:
            return values
        found = np.empty_like(values)
        self.communicator.Reduce(values, found if self.rank == 0 else None, root=0)
        self.communicator.Bcast(found, root=0)
        return found

    def end(self, status: int) -> None:
        """End all processes with an exit status."""
        time.sleep(_DELIVERY)
        self.communicator.Abort(status)

    def rows_of_machine(self, own: int) -> int:
        """Return the rows of all processes on this machine, from those of each."""
        from mpi4py import MPI

        machine = self.communicator.Split_type(MPI.COMM_TYPE_SHARED)
        rows = int(machine.allreduce(own))
        machine.Free()
        return rows

    def exchange(self, values: RealArray, counts: Sequence[int], expected: Sequence[int]) -> RealArray:
        """Return what all processes send to this one, flat, in their order; see `SlabProcesses.exchange`."""
        if self.count == 1:
            return values
        self.sent += values.itemsize * (sum(counts) - counts[self.rank])
        found = np.empty(sum(expected), dtype=values.dtype)
        self.communicator.Alltoallv(_places(values, counts), _places(found, expected))
        return found

    def gather(self, values: RealArray) -> RealArray:
        """Return the flat arrays of all processes one after the other, on each."""
        if self.count == 1:
            return values
        counts = [int(count) for count in self.collect(values.size)]
        found = np.empty(sum(counts), dtype=values.dtype)
        self.communicator.Allgatherv(_places(values, [values.size])[0], _places(found, counts))
        return found


def _places(values: RealArray, counts: Sequence[int]) -> list[Any]:
    """Return an array with the entries of each process in it, as MPI takes them, which knows no booleans of numpy."""
    starts = np.concatenate(([0], np.cumsum(counts)[:-1])).tolist()
    return [values.view(np.uint8) if values.dtype == np.bool_ else values, (list(counts), starts)]
