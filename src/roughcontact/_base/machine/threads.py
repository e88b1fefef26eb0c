"""The threads of a solve: how many there are, and how passes over arrays share them in tiles."""

from __future__ import annotations

import contextlib
import contextvars
import itertools
import math
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from roughcontact._base.checks import integer
from roughcontact._base.checks.groups import control_groups
from roughcontact.errors import InputError
from roughcontact.errors.door import guarded

S = TypeVar("S")
T = TypeVar("T")
# Cells that make a further thread worth its hand-over: with two threads a solve on 512 x 512 cells takes 1.2 times
# the wall time of one, on 1024 x 1024 no more and on 2048 x 2048 less (docs/studies/scale.py).
_CELLS = 2**19
# Side of the square grid from which on two threads are used.
_TWO = math.isqrt(2 * _CELLS)
# Values of an array that a pass treats at a time: a few such tiles fit into the cache.
_TILE = 2**16

_COUNT = contextvars.ContextVar("threads of the solve that runs", default=1)
_SHARED = contextvars.ContextVar("whether others of a pool work beside this one", default=False)


def thread_count(value: object) -> int | str:
    """Return ``"auto"``, or a number of threads, checked to be at least one."""
    if isinstance(value, str) and value == "auto":
        return "auto"
    try:
        return integer(value, "The number of threads", at_least=1)
    except InputError:
        raise InputError.about("The number of threads", value, "'auto' or a whole number of at least 1") from None


def choose_threads(given: int | str, cells: int) -> tuple[int, str]:
    """Return how many threads a solve takes, and why.

    Parameters
    ----------
    given
        What the problem says; a text is ``"auto"``.
    cells
        Cells of its grid.
    """
    useful = max(1, cells // _CELLS)
    asked = None if isinstance(given, str) else given
    if asked is None and useful == 1:
        return 1, f"two pay from {_TWO} x {_TWO} cells"
    if asked is None and (_SHARED.get() or _is_pooled()):
        return 1, "others of a pool work beside this process"
    if asked is None and _has_limited_address_space():
        return 1, "each takes a part of the address space, which is limited (ulimit -v)"
    available = available_threads()
    if asked is not None:
        return (asked, "as given") if asked <= available else (available, f"not {asked}: this process may use no more")
    return (
        (useful, f"one for each {_CELLS} cells") if useful < available else (available, "this process may use no more")
    )


@guarded
def available_threads(root: Path = Path("/")) -> int:
    """Return how many processors this process may use: its affinity, and the quota of its control groups.

    `root` is for tests.
    """
    if hasattr(os, "process_cpu_count"):
        count = os.process_cpu_count() or 1
    else:
        count = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    quotas = (_read_quota(group, version) for group, version in control_groups("cpu", root))
    return max(1, int(min([count, *(quota for quota in quotas if quota is not None)])))


def _read_quota(group: Path, version: int) -> float | None:
    """Return the processors that a control group may use; None if it has no limit."""
    names = ("cpu.max",) if version == 2 else ("cpu.cfs_quota_us", "cpu.cfs_period_us")
    # Without a limit the first word is "max", or -1, or the file is missing.
    with contextlib.suppress(OSError, ValueError):
        quota, period = (int(word) for name in names for word in (group / name).read_text().split())
        return quota / period if quota > 0 and period > 0 else None
    return None


def _is_pooled() -> bool:
    """Return whether this process was started by another one of Python's, as one of a pool is."""
    process = sys.modules.get("multiprocessing.process")
    return process is not None and process.parent_process() is not None


def _has_limited_address_space() -> bool:
    """Return whether what this process may address is limited: the heap of each thread reserves 64 MiB of that."""
    with contextlib.suppress(ImportError):
        import resource

        return resource.getrlimit(resource.RLIMIT_AS)[0] != resource.RLIM_INFINITY
    return False


@contextlib.contextmanager
def use_threads(count: int) -> Iterator[None]:
    """Limit the threads used inside the context."""
    token = _COUNT.set(count)
    try:
        yield
    finally:
        _COUNT.reset(token)


@contextlib.contextmanager
def share_machine() -> Iterator[None]:
    """Let each problem inside that does not say how many threads it takes use one: others work beside it."""
    token = _SHARED.set(True)
    try:
        yield
    finally:
        _SHARED.reset(token)


def threads_for(cells: int) -> int:
    """Return how many threads work on an array of so many cells gains from, of those that the solve has."""
    return min(_COUNT.get(), max(1, cells // _CELLS))


def split(length: int, step: int) -> list[slice]:
    """Return the tiles of an axis: ranges of `step` entries, the last one shorter, whatever the number of threads."""
    return [slice(start, min(start + step, length)) for start in range(0, length, step)]


def tiles_of(values: npt.NDArray[Any]) -> list[slice]:
    """Return the tiles of a pass over an array, along its first axis; an array of another kind than numpy's is one."""
    length = values.shape[0]
    width = max(1, math.prod(values.shape[1:]))
    return split(length, max(1, _TILE // width) if isinstance(values, np.ndarray) else max(1, length))


def map_tiles(work: Callable[[S], T], tiles: Sequence[S]) -> list[T]:
    """Return what `work` returns for each tile, in their order; the threads of the solve share the tiles.

    The work on one tile must not depend on that on another. Results have the same bits whatever the number of threads.
    """
    count = min(_COUNT.get(), len(tiles))
    if count == 1:
        return [work(tile) for tile in tiles]
    results: dict[int, T] = {}
    places = itertools.count()

    def take() -> None:
        while (place := next(places)) < len(tiles):
            results[place] = work(tiles[place])

    others = []
    # Where no thread can be started, this one does all the work.
    with contextlib.suppress(RuntimeError):
        for _ in range(count - 1):
            # A copy of the context, in which numpy keeps how it treats floating-point errors.
            others.append(_pool().submit(contextvars.copy_context().run, take))
    try:
        take()
    finally:
        for other in others:
            # One that has not begun has nothing left to do.
            if not other.cancel():
                other.result()
    return [results[place] for place in range(len(tiles))]


@cache
def _pool() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(os.cpu_count() or 1, thread_name_prefix="roughcontact")


# The threads of a pool stay behind when a process is forked.
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_pool.cache_clear)
