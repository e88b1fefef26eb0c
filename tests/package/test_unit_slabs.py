"""Slabs of one process, and of several that talk within this one: rows, products, random heights, what is refused."""

from __future__ import annotations

import math
import threading

import attrs
import numpy as np
import pytest

import roughcontact as rc
from roughcontact.slabs import (
    SlabArray,
    SlabContacts,
    SlabConvolver,
    SlabProcesses,
    make_random_rows,
    multiply_on_slabs,
    symbol_of_columns,
)
from roughcontact.typing import BoundKernel, ConvolutionSetup

SHAPES = [(16, 12), (9, 7), (2, 20), (40, 6)]
BOUNDARIES = ["periodic", "free", "free-periodic", "periodic-free"]


class Threads(SlabProcesses):
    """Processes that are threads of this one."""

    def __init__(self, rank, shared):
        self.rank = rank
        self.count = len(shared["slots"])
        self._shared = shared

    def _swap(self, value):
        """Return what all have given."""
        self._shared["slots"][self.rank] = value
        self._shared["barrier"].wait(30.0)
        found = list(self._shared["slots"])
        self._shared["barrier"].wait(30.0)
        return found

    def collect(self, value):
        return np.stack([np.asarray(one) for one in self._swap(value)])

    def exchange(self, values, counts, expected):
        assert len(values) == sum(counts)
        given = self._swap((values, counts))
        starts = [sum(other[: self.rank]) for _, other in given]
        parts = [one[start : start + other[self.rank]] for (one, other), start in zip(given, starts, strict=True)]
        assert [len(part) for part in parts] == list(expected)
        return np.concatenate(parts)

    def gather(self, values):
        return np.concatenate(self._swap(values))


def run(count, work):
    """Return what `work` returns on each of several processes."""
    shared = {"slots": [None] * count, "barrier": threading.Barrier(count)}
    found = [None] * count

    def target(rank):
        try:
            found[rank] = work(Threads(rank, shared))
        except BaseException:
            shared["barrier"].abort()
            raise

    threads = [threading.Thread(target=target, args=(rank,)) for rank in range(count)]
    for one in threads:
        one.start()
    for one in threads:
        one.join()
    return found


@attrs.frozen(eq=False)
class Product(SlabConvolver):
    """A convolver of which the symbol alone is asked."""

    def convolve(self, setup, symbol, padded):
        return symbol


@pytest.mark.parametrize("count", [1, 2, 3])
@pytest.mark.parametrize("boundary", BOUNDARIES)
@pytest.mark.parametrize("shape", SHAPES)
def test_products_are_those_of_one_process(shape, boundary, count):
    grid = rc.Grid(shape, tuple(map(float, shape)))
    kernel = BoundKernel(rc.Love(), unit=1.0, datum=float(max(shape)))
    kind = rc.Boundary(boundary)
    pressure = np.random.default_rng(1).random(shape)
    convolver = rc.CircularFFT() if kind is rc.Boundary.PERIODIC else rc.DCFFT()
    expected = convolver.prepare(kernel, grid, kind).apply(pressure)

    def work(processes):
        ours = Product(processes)
        padded = ours.transform_shape(grid, kind)
        symbol = symbol_of_columns(ConvolutionSetup(ours, kernel, grid, kind), padded, processes)
        rows = pressure[processes.own_rows(shape[0])]
        return multiply_on_slabs(processes, rows, shape[0], lambda part: symbol[:, part], padded)

    found = np.concatenate(run(count, work))
    assert np.abs(found - expected).max() < 1e-13 * np.abs(expected).max()


@pytest.mark.parametrize("count", [1, 2, 3])
@pytest.mark.parametrize("shape", [(40, 33), (16, 64)])
def test_random_heights_are_those_of_the_surface(shape, count):
    rough = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=0.25, longest=1.0, lay=0.3, peklenik=2.0, seed=2)
    grid = rc.Grid(shape, (2.0, 1.0))
    found = np.concatenate(run(count, lambda processes: make_random_rows(rough, grid, processes)))
    expected = rough.heights(grid)
    assert np.abs(found - expected).max() < 1e-14 * np.abs(expected).max()


@pytest.mark.parametrize("count", [1, 2, 3])
@pytest.mark.parametrize("rows", [4, 9, 24])
def test_rows_come_from_the_processes_that_have_them(rows, count):
    values = np.random.default_rng(2).random((rows, 5))

    def work(processes):
        own = processes.own_rows(rows)
        part = values[own]
        wide = processes.widen(part, rows, 2)
        zeros = processes.widen(part, rows, 1, periodic=False)
        if part.size:
            assert np.array_equal(wide, np.take(values, np.arange(own.start - 2, own.stop + 2), 0, mode="wrap"))
            assert np.array_equal(zeros, np.pad(values, ((1, 1), (0, 0)))[own.start : own.stop + 2])
        assert np.array_equal(processes.gather_rows(part, rows), values)
        stack = np.stack((part, -part))
        first = processes.gather_rows(stack, rows, first=True)
        assert first is None if processes.rank else np.array_equal(first, np.stack((values, -values)))
        slab = SlabArray.field(part.copy(), processes, rows)
        assert np.array_equal(np.roll(slab, 1, 0).part, np.roll(values, 1, 0)[own])
        assert np.array_equal(np.roll(slab, -1, 0).part, np.roll(values, -1, 0)[own])
        window = slab[1 : rows - 1, 1:4]
        assert window.shape == (rows - 2, 3)
        assert float(window.sum()) == pytest.approx(values[1 : rows - 1, 1:4].sum())
        assert bool((slab > 0.5).any()) is bool((values > 0.5).any())
        assert float(np.where(slab > 0.5, slab, 0.0).max()) == np.where(values > 0.5, values, 0.0).max()
        return True

    assert run(count, work) == [True] * count


class Alone(SlabContacts):
    """Contacts of one process, which are refused before they are solved."""

    @classmethod
    def make_convolver(cls, processes):
        return Product(processes)

    @classmethod
    def require_memory(cls, processes, grid, boundary):
        pass


def test_slabs_refuse_heights_without_a_contact():
    def solve(heights, size=1e-3):
        slab = SlabArray.field(heights, SlabProcesses(), len(heights))
        return Alone.solve(slab, size, "glass", pressure=1e6, boundary="periodic")

    heights = np.zeros((32, 32))
    with pytest.raises(rc.InputError, match="all the same"):
        solve(heights)
    for wrong in (math.nan, math.inf, -math.inf):
        heights[3, 4] = wrong
        with pytest.raises(rc.InputError, match="not all finite"):
            solve(heights)
    with pytest.raises(rc.InputError, match="of the shape of the heights"):
        solve(heights, rc.Grid((16, 32), 1e-3))


def test_a_whole_solution_gathers_itself():
    body = rc.Body(rc.WavySurface(1e-6, 50e-6), rc.Elastic(2e9, 0.25))
    solution = rc.ContactProblem(body, grid=rc.Grid((16, 16), 100e-6), boundary="periodic").solve(pressure=1e6)
    assert solution.gather() is solution


@pytest.mark.parametrize("count", [1, 2, 3, 5, 7])
@pytest.mark.parametrize("rows", [64, 96, 100, 513, 1024])
def test_rows_of_slabs_are_those_of_their_coarser_rows(count, rows):
    """Each process has the finer rows of its rows on the coarsest grid, and all have all."""
    shares = []
    for rank in range(count):
        processes = SlabProcesses()
        processes.rank, processes.count = rank, count
        shares.append(processes.own_rows(rows))
        factor = rows // processes.coarsest_rows(rows)
        assert processes.own_rows(rows).start == factor * processes.own_rows(rows // factor).start
        assert processes.own_columns(rows) == slice(rank * rows // count, (rank + 1) * rows // count)
    assert [one.start for one in shares[1:]] == [one.stop for one in shares[:-1]]
    assert (shares[0].start, shares[-1].stop) == (0, rows)


@pytest.mark.parametrize(
    ("error", "status", "said"),
    [
        (rc.InputError("The map is empty."), 2, "roughcontact: The map is empty. (process 0 of 1)"),
        (rc.UnexpectedError("It failed."), 1, "roughcontact: It failed. (process 0 of 1)"),
        (ValueError("no"), 1, "Traceback"),
        (KeyboardInterrupt(), 130, ""),
    ],
)
def test_an_error_of_one_process_ends_all(error, status, said, capsys):
    with pytest.raises(SystemExit) as found, SlabProcesses().ending_all():
        raise error
    assert found.value.code == status
    assert said in capsys.readouterr().err
