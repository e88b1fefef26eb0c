"""The processes of a contact that is divided among them: the rows of each, and what they send each other."""

from __future__ import annotations

import contextlib
import itertools
import sys
import time
import traceback
from collections.abc import Callable, Iterator, Sequence
from typing import Any, ClassVar

import numpy as np
import scipy

from roughcontact._base.arrays import RealArray
from roughcontact._solve.solvers import halve_shape
from roughcontact.errors import NotConverged, RoughContactError, UnexpectedError

# Seconds for which the first process goes first, so that an error of all appears once.
_PRECEDENCE = 1.0
# Exit status of a process that was interrupted.
_INTERRUPTED = 130
# Columns that are transformed at a time: few enough for the cache.
_COLUMNS = 32
# The fewest tiles of an array, so that those of small ones take little memory too.
_TILES = 4


class SlabProcesses:
    """The processes that solve one contact: rows and columns of each, and how they talk; this class is a single one.

    Each calls the same functions in the same order, and gets the same numbers. Subclasses let several talk, by
    `collect`, `gather` and `exchange`; their slabs are arrays of numpy, or of a library with the same names.

    Attributes
    ----------
    rank, count
        The number of this process, from zero on, and of all.
    reductions, sent
        Reductions so far, and the bytes sent to other processes.
    name
        What is named before the sentence of an error.
    library
        The library of the slabs.
    max_exchanges
        Maximum parts in which rows are exchanged for columns, so that they take little memory.
    """

    name: ClassVar[str] = "roughcontact"
    library: ClassVar[Any] = np
    max_exchanges: ClassVar[int] = 8
    rank: int = 0
    count: int = 1
    reductions: int = 0
    sent: int = 0

    @property
    def transforms(self) -> Any:
        """The Fourier transforms of the library; scipy loads its own at their first use."""
        return scipy.fft

    @staticmethod
    def share(count: int, parts: int) -> tuple[int, ...]:
        """Return the bounds of nearly equal parts of a number of things."""
        return tuple(part * count // parts for part in range(parts + 1))

    def rows(self, count: int) -> tuple[int, ...]:
        """Return the bounds of the rows of all processes, for a number of rows of the domain.

        They are shared on the coarsest grid, so that the rows of a process are those of its rows on the next one.
        """
        coarse = self.coarsest_rows(count)
        return tuple(bound * (count // coarse) for bound in self.share(coarse, self.count))

    def coarsest_rows(self, count: int) -> int:
        """Return the rows of the coarsest grid, for a number of rows of the domain."""
        while (half := halve_shape((count, 2))[0]) < count:
            count = half
        return count

    def own_rows(self, count: int) -> slice:
        """Return the rows of this process."""
        bounds = self.rows(count)
        return slice(bounds[self.rank], bounds[self.rank + 1])

    def columns(self, count: int) -> tuple[int, ...]:
        """Return the bounds of the columns of all processes, for a number of columns."""
        return self.share(count, self.count)

    def own_columns(self, count: int) -> slice:
        """Return the columns of this process."""
        bounds = self.columns(count)
        return slice(bounds[self.rank], bounds[self.rank + 1])

    def meet(self, call: str) -> None:
        """Wait until all processes have made a call."""

    def wait(self) -> None:
        """Wait for all processes."""
        self.total(0)

    def require(self, shape: tuple[int, int]) -> None:
        """Raise `InputError` unless a grid can be divided among the processes."""

    def collect(self, value: Any) -> RealArray:
        """Return a number or an array of numpy of each process, of one shape on all, shape (count, ...)."""
        self.reductions += 1
        return np.asarray(value, order="C")[np.newaxis]

    def total(self, value: Any) -> Any:
        """Return the sum of a number or a small array of numpy over all processes, of the same bits on each."""
        return np.add.reduce(self.collect(value), axis=0)

    def across(self, ufunc: np.ufunc, value: float) -> float:
        """Return the sum, the minimum or the maximum of a number over all processes."""
        return float(ufunc.reduce(self.collect(value)))

    def total_blocks(self, values: RealArray) -> RealArray:
        """Return the sum of an array of numpy over all processes, of the same bits on each."""
        found: RealArray = self.total(values)
        return found

    def exchange(self, values: Any, counts: Sequence[int], expected: Sequence[int]) -> Any:
        """Return what all processes send to this one, flat, in their order.

        Parameters
        ----------
        values
            What this process sends, flat, in the order of the receivers.
        counts, expected
            Entries to and from each process.
        """
        return values

    def place(self, values: RealArray) -> Any:
        """Return an array of numpy as one of the library."""
        return values

    def empty(self, shape: int | tuple[int, ...], like: Any = None) -> Any:
        """Return a new array of the type of another one; by default float64."""
        return np.empty(shape, dtype=np.float64 if like is None else like.dtype)

    def tiles(self, whole: slice, most: int) -> Iterator[slice]:
        """Yield parts of a range of at most so many entries, which are worked on one after the other."""
        step = max(1, min(most, (whole.stop - whole.start) // _TILES))
        for start in range(whole.start, whole.stop, step):
            yield slice(start, min(start + step, whole.stop))

    def tiles_of_columns(self, whole: slice, *, padded: bool) -> Iterator[slice]:
        """Yield parts of columns that are padded, or not, and transformed one after the other."""
        return self.tiles(whole, _COLUMNS)

    def gather_rows(self, values: Any, count: int, *, first: bool = False) -> Any:
        """Return all rows of fields, shape (..., count, ny), on each process, or on the first one alone.

        Parameters
        ----------
        values
            The rows of this process.
        count
            Rows of the domain.
        first
            Whether the others get None.
        """
        *lead, own, width = values.shape
        readers = 1 if first else self.count
        # Rows of several fields do not lie in one piece.
        fields = int(np.prod(lead, dtype=np.int64))
        sent = self.library.concatenate([values.reshape(-1)] * readers)
        counts = [fields * own * width if rank < readers else 0 for rank in range(self.count)]
        heights = np.diff(self.rows(count)).tolist() if self.rank < readers else [0] * self.count
        found = self.exchange(sent, counts, [fields * height * width for height in heights])
        if self.rank >= readers:
            return None
        ends = np.cumsum([0, *heights]).tolist()
        parts = [
            found[fields * width * start : fields * width * stop].reshape(*lead, stop - start, width)
            for start, stop in itertools.pairwise(ends)
        ]
        return self.library.concatenate(parts, -2)

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
        sent = self.library.concatenate([values[list(rows)].reshape(-1) for rows in places])
        counts = [len(rows) * width for rows in places]
        found: RealArray = self.exchange(sent, counts, [count * width for count in expected]).reshape(-1, width)
        return found

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
        expected = np.bincount(owners, minlength=self.count).tolist()
        found = self.exchange_rows(values, places, expected)
        return found[np.argsort(np.argsort(owners, kind="stable"))]

    def widen(self, values: Any, count: int, reach: int, *, periodic: bool = True) -> Any:
        """Return the rows of this process of a field with those of the others before and behind them.

        Parameters
        ----------
        values
            The rows of this process; without any, none are returned.
        count
            Rows of the field.
        reach
            Rows on either side.
        periodic
            Whether the last rows of the field lie before the first ones, or zeros.
        """
        bounds = self.rows(count)
        wanted = [
            [row % count for row in (*range(start - reach, start), *range(stop, stop + reach))] if start < stop else []
            for start, stop in itertools.pairwise(bounds)
        ]
        beside = self.fetch_rows(values, bounds, wanted)
        before = beside[:reach]
        behind = beside[reach:]
        if not periodic and self.rank == 0:
            before = self.library.zeros_like(before)
        if not periodic and self.rank == self.count - 1:
            behind = self.library.zeros_like(behind)
        return self.library.concatenate((before, values, behind))

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

    def gather(self, values: RealArray) -> RealArray:
        """Return the flat arrays of all processes one after the other, on each."""
        return values

    def end(self, status: int) -> None:
        """End all processes with an exit status."""
        sys.exit(status)

    @contextlib.contextmanager
    def ending_all(self) -> Iterator[None]:
        """End all processes, with one sentence, when one of them fails inside the context: the others would wait.

        The exit status is 1 if there is no certified answer or the error is not one of the user, else 2.
        """
        try:
            yield
        except KeyboardInterrupt:
            self.end(_INTERRUPTED)
        except Exception as error:
            if self.rank:
                time.sleep(_PRECEDENCE)
            if isinstance(error, RoughContactError):
                status = 1 if isinstance(error, (NotConverged, UnexpectedError)) else 2
            else:
                status = 1
                traceback.print_exc()
            where = f"process {self.rank} of {self.count}"
            print(f"{self.name}: {error} ({where})", file=sys.stderr, flush=True)
            self.end(status)


def in_tiles(work: Callable[[Any], Any], values: Any, tiles: Sequence[slice]) -> Any:
    """Return columns that are worked on tile by tile, in their place; those of a single tile at once."""
    if len(tiles) == 1:
        return work(values)
    for tile in tiles:
        values[:, tile] = work(values[:, tile])
    return values
