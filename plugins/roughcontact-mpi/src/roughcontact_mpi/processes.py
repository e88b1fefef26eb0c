"""The processes of a solve, the rows of each, and what they send each other."""

from __future__ import annotations

import contextlib
import os
import sys
import time
import traceback
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import roughcontact as rc
from roughcontact.errors import RoughContactError
from roughcontact.typing import RealArray, halve_shape

# Where the mpiexec of MPICH and of Open MPI states the number of processes.
_STARTED = ("PMI_SIZE", "OMPI_COMM_WORLD_SIZE")
# Seconds between two looks for the other processes.
_LOOK = 0.005
# Seconds for which the first process goes first, so that an error of all appears once.
_PRECEDENCE = 1.0
# Seconds from the sentence to the end of the job: mpiexec loses what it has not passed on by then.
_DELIVERY = 0.3


def share(count: int, parts: int) -> tuple[int, ...]:
    """Return the bounds of nearly equal parts of a number of things."""
    return tuple(part * count // parts for part in range(parts + 1))


class Processes:
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
        self.rank: int = communicator.Get_rank()
        self.count: int = communicator.Get_size()
        # Bytes sent to other processes, and reductions.
        self.sent = 0
        self.reductions = 0

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

    def rows(self, count: int) -> tuple[int, ...]:
        """Return the bounds of the rows of all processes, for a number of rows of the domain.

        They are shared on the coarsest grid, so that the rows of a process are those of its rows on the next one.
        """
        coarse = count
        while (half := halve_shape((coarse, 2))[0]) < coarse:
            coarse = half
        return tuple(bound * (count // coarse) for bound in share(coarse, self.count))

    def own_rows(self, count: int) -> slice:
        """Return the rows of this process."""
        bounds = self.rows(count)
        return slice(bounds[self.rank], bounds[self.rank + 1])

    def columns(self, count: int) -> tuple[int, ...]:
        """Return the bounds of the columns of all processes, for a number of columns."""
        return share(count, self.count)

    def own_columns(self, count: int) -> slice:
        """Return the columns of this process."""
        bounds = self.columns(count)
        return slice(bounds[self.rank], bounds[self.rank + 1])

    def collect(self, value: Any) -> RealArray:
        """Return a number or an array of each process, of one shape on all, shape (count, ...)."""
        own = np.asarray(value, order="C")
        self.reductions += 1
        if self.count == 1:
            return own[np.newaxis]
        found = np.empty((self.count, *own.shape), dtype=own.dtype)
        self.communicator.Allgather(own, found)
        return found

    def total(self, value: Any) -> Any:
        """Return the sum of a number or a small array over all processes, of the same bits on each."""
        # MPI recommends, but does not require, that its own sums have the same bits on all processes.
        return np.add.reduce(self.collect(value), axis=0)

    def across(self, ufunc: np.ufunc, value: float) -> float:
        """Return the sum, the minimum or the maximum of a number over all processes."""
        return float(ufunc.reduce(self.collect(value)))

    def total_blocks(self, values: RealArray) -> RealArray:
        """Return the sum of an array over all processes, of the same bits on each."""
        self.reductions += 1
        if self.count == 1:
            return values
        found = np.empty_like(values)
        self.communicator.Reduce(values, found if self.rank == 0 else None, root=0)
        self.communicator.Bcast(found, root=0)
        return found

    def rows_of_machine(self, own: int) -> int:
        """Return the rows of all processes on this machine, from those of each."""
        from mpi4py import MPI

        machine = self.communicator.Split_type(MPI.COMM_TYPE_SHARED)
        rows = int(machine.allreduce(own))
        machine.Free()
        return rows

    def exchange(self, values: RealArray, counts: Sequence[int], expected: Sequence[int]) -> RealArray:
        """Return what all processes send to this one, flat, in their order.

        Parameters
        ----------
        values
            What this process sends, flat, in the order of the receivers.
        counts, expected
            Entries to and from each process.
        """
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
        self.communicator.Allgatherv(values, _places(found, counts))
        return found

    def exchange_rows(self, values: RealArray, places: Sequence[Sequence[int]], expected: Sequence[int]) -> RealArray:
        """Return rows that all processes send to this one, shape (n, ny), in the order of the senders.

        Parameters
        ----------
        values
            Rows of this process, shape (nx, ny).
        places
            The rows that go to each process, as positions in `values`.
        expected
            The number of rows from each process.
        """
        width = values.shape[1]
        sent = np.concatenate([values[list(rows)].ravel() for rows in places])
        counts = [len(rows) * width for rows in places]
        return self.exchange(sent, counts, [count * width for count in expected]).reshape(-1, width)

    def fetch_rows(self, values: RealArray, bounds: Sequence[int], wanted: Sequence[Sequence[int]]) -> RealArray:
        """Return rows of a field, shape (n, ny), for each process those it wants, in their order.

        Parameters
        ----------
        values
            The rows of this process.
        bounds
            Bounds of the rows of all processes.
        wanted
            The rows that each process wants, counted in the whole field: the same on all processes.
        """
        start = bounds[self.rank]
        stop = bounds[self.rank + 1]
        places = [[row - start for row in rows if start <= row < stop] for rows in wanted]
        owners = np.searchsorted(np.asarray(bounds), np.asarray(wanted[self.rank], dtype=int), side="right") - 1
        expected = np.bincount(owners, minlength=self.count) if owners.size else np.zeros(self.count, dtype=int)
        found = self.exchange_rows(values, places, [int(count) for count in expected])
        order = np.argsort(owners, kind="stable")
        rows = np.empty_like(found)
        rows[order] = found
        return rows

    def move_rows(self, values: RealArray, source: Sequence[int], target: Sequence[int]) -> RealArray:
        """Return the rows of this process by other bounds, from those it has; bounds count in one field.

        Rows outside the bounds of the source are not filled: both ranges must overlap in what is wanted.
        """
        first = source[self.rank]
        last = source[self.rank + 1]
        begin = target[self.rank]
        end = target[self.rank + 1]

        def overlap(start: int, stop: int, low: int, high: int) -> range:
            return range(max(start, low), max(min(stop, high), max(start, low)))

        pairs = range(self.count)
        places = [[row - first for row in overlap(first, last, target[other], target[other + 1])] for other in pairs]
        expected = [len(overlap(begin, end, source[other], source[other + 1])) for other in pairs]
        return self.exchange_rows(values, places, expected)


def _places(values: RealArray, counts: Sequence[int]) -> list[Any]:
    """Return an array with the entries of each process in it, as MPI takes them."""
    starts = np.concatenate(([0], np.cumsum(counts)[:-1])).tolist()
    return [values, (list(counts), starts)]


@contextlib.contextmanager
def ending_all(processes: Processes) -> Iterator[None]:
    """End all processes, with one sentence, when one of them fails inside the context: the others would wait forever.

    The exit status is 1 if there is no certified answer or the error is not one of the user, else 2.
    """
    try:
        yield
    except KeyboardInterrupt:
        processes.communicator.Abort(130)
    except Exception as error:
        if processes.rank:
            time.sleep(_PRECEDENCE)
        if isinstance(error, RoughContactError):
            status = 1 if isinstance(error, (rc.NotConverged, rc.UnexpectedError)) else 2
        else:
            status = 1
            traceback.print_exc()
        print(f"roughcontact_mpi: {error} (process {processes.rank} of {processes.count})", file=sys.stderr, flush=True)
        time.sleep(_DELIVERY)
        processes.communicator.Abort(status)
