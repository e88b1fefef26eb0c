"""Memory and threads of the machine: how much a solve may take, and how passes over arrays share threads."""

from __future__ import annotations

import contextlib
import contextvars
import itertools
import math
import os
import re
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from roughcontact._base.checks import integer, number
from roughcontact._base.units import binary
from roughcontact.errors import InputError, NotEnoughMemory
from roughcontact.errors.door import guarded

S = TypeVar("S")
T = TypeVar("T")
# Bytes up to which the available memory is not looked up: that costs up to a millisecond.
_UNCHECKED_BYTES = 2**24
# Bytes that suffice where the available memory is not known: those of a solve on 16384 x 16384 cells near full contact
# (docs/studies/memory.py).
_ASSUMED_BYTES = 36 * 2**30
# Address space that threads and libraries reserve without taking memory.
_RESERVED_BYTES = 2**31
# A number of bytes in words, and the bytes of each unit.
_BYTES_IN_WORDS = re.compile(r"\s*([0-9]{1,18}(?:\.[0-9]{0,18})?)\s*(bytes|B|[kMGT]B|[KMGT]iB)\s*")
_BYTES_PER_UNIT = {"B": 1, "bytes": 1, **{f"{name}B": 1000**power for power, name in enumerate("kMGT", 1)}}
_BYTES_PER_UNIT |= {f"{name}iB": 1024**power for power, name in enumerate("KMGT", 1)}
# The files of a group's limit and use, and the entries of its memory.stat that the kernel gives back, by version.
_CGROUP_FILES = {
    2: ("memory.max", "memory.current", ("inactive_file", "active_file")),
    1: ("memory.limit_in_bytes", "memory.usage_in_bytes", ("total_inactive_file", "total_active_file")),
}
# Cells that make a further thread worth its hand-over: with two threads a solve on 512 x 512 cells takes 1.2 times
# the wall time of one, on 1024 x 1024 no more and on 2048 x 2048 less (docs/studies/scale.py).
_CELLS_PER_THREAD = 2**19
# Side of the square grid from which on two threads are used.
_TWO_THREADS_SIDE = math.isqrt(2 * _CELLS_PER_THREAD)
# Values of an array that a pass treats at a time: a few such tiles fit into the cache.
_VALUES_PER_TILE = 2**16
_THREADS = contextvars.ContextVar("threads of the solve that runs", default=1)
_IS_SHARED = contextvars.ContextVar("whether others of a pool work beside this one", default=False)


def control_groups(controller: str, root: Path) -> Iterator[tuple[Path, int]]:
    """Yield the folder and version of each control group that limits this process, from the innermost outwards.

    The controller is ``"memory"`` or ``"cpu"``; `root` is the root of the file system, another one for tests.
    """
    lines: list[str] = []
    with contextlib.suppress(OSError, ValueError):
        lines = (root / "proc/self/cgroup").read_text(encoding="utf-8").splitlines()
    for line in lines:
        _, controllers, place = line.split(":", 2)
        for name, version in (("", 2), (controller, 1)):
            if name in controllers.split(","):
                top = root / "sys/fs/cgroup" / name
                group = top / place.lstrip("/")
                # Outer groups limit as well. In a container its own group may be the only visible one.
                while group.is_relative_to(top):
                    yield group, version
                    group = group.parent


def limit_of_memory(value: float | str | None) -> int | None:
    """Return a limit in bytes from a number, a text such as ``"8 GiB"`` or None; `InputError` otherwise."""
    what = "The limit of the memory"
    if isinstance(value, str):
        found = _BYTES_IN_WORDS.fullmatch(value)
        if found is None:
            raise InputError.about(what, value, "a number of bytes, or a text such as '8 GiB' or '500 MB'")
        value = float(found[1]) * _BYTES_PER_UNIT[found[2]]
    return None if value is None else int(number(value, what, "bytes", at_least=1.0))


@guarded
def require_memory(needed: float, what: str, advice: str | Callable[[int], str], limit: int | None = None) -> None:
    """Raise `NotEnoughMemory` if `needed` exceeds the memory available to this process, 36 GiB if unknown, or `limit`.

    Parameters
    ----------
    needed
        Smallest memory needed, bytes.
    what
        What needs it, the subject of the sentence.
    advice
        What to do, or a function that returns it given the available memory, bytes.
    limit
        Limit set by the user, bytes; None: no limit.
    """
    if limit is None and needed <= _UNCHECKED_BYTES:
        return
    known = available_memory() if limit is None else limit
    available = _ASSUMED_BYTES if known is None else known
    if needed > available:
        if limit is not None:
            there = f"memory_limit= allows only {binary(limit)}"
        elif known is None:
            there = f"what this machine has is not known, and {binary(available)} is assumed"
        else:
            there = f"this process may take only {binary(available)} more"
        hint = advice if isinstance(advice, str) else advice(available)
        error = NotEnoughMemory(f"{what} needs {binary(needed)} of memory, but {there}: {hint}.")
        error.available = there
        raise error


@guarded
def available_memory(root: Path = Path("/")) -> int | None:
    """Return how much more memory this process may take, bytes; None where that is not known.

    It is the minimum of the machine's available memory and of what remains within the limits of the control groups
    (cgroup 1 and 2) of a container or job and of the process (``ulimit -v`` and ``-d``). `root` is for tests.
    """
    found = [*_left_on_machine(root), *_left_in_groups(root), *_left_in_process(root)]
    return max(0, min(found)) if found else None


@guarded
def limit_address_space(root: Path = Path("/"), *, most: int | None = None) -> None:
    """Limit this process to the memory that is available now, where the system can: beyond it, MemoryError is raised.

    It may be called again when more or less is available. `most` bounds the bytes that are taken from now on, beside
    the address space that threads and libraries only reserve.
    """
    with contextlib.suppress(ImportError, OSError, ValueError):
        import resource

        soft, hard = _own_limits()
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))
        available = available_memory(root)
        used = int((root / "proc/self/statm").read_text().split()[0]) * os.sysconf("SC_PAGE_SIZE")
        if most is not None:
            available = most if available is None else min(available, most)
        if available is not None:
            limits = (used + available + _RESERVED_BYTES, soft, hard)
            limit = min(limit for limit in limits if limit != resource.RLIM_INFINITY)
            resource.setrlimit(resource.RLIMIT_AS, (limit, hard))


@cache
def _own_limits() -> tuple[int, int]:
    """Return the limits of the address space with which this process was started."""
    import resource

    return resource.getrlimit(resource.RLIMIT_AS)


def _left_on_machine(root: Path) -> Iterator[int]:
    with contextlib.suppress(OSError, ValueError, KeyError):
        entries = _read_table(root / "proc/meminfo")
        yield 1024 * (entries["MemAvailable"] + entries.get("SwapFree", 0))


def _left_in_groups(root: Path) -> Iterator[int]:
    for group, version in control_groups("memory", root):
        limit, usage, cached = _CGROUP_FILES[version]
        # Without a limit the file says "max", or is missing as in the topmost group.
        with contextlib.suppress(OSError, ValueError):
            free = int((group / limit).read_text()) - int((group / usage).read_text())
            with contextlib.suppress(OSError, ValueError):
                entries = _read_table(group / "memory.stat")
                free += sum(entries.get(name, 0) for name in cached)
            yield free


def _left_in_process(root: Path) -> Iterator[int]:
    with contextlib.suppress(ImportError, OSError, ValueError):
        import resource

        pages = [int(word) for word in (root / "proc/self/statm").read_text().split()]
        for kind, used in ((resource.RLIMIT_AS, pages[0]), (resource.RLIMIT_DATA, pages[5])):
            limit = resource.getrlimit(kind)[0]
            if limit != resource.RLIM_INFINITY:
                yield limit - used * os.sysconf("SC_PAGE_SIZE")


def _read_table(path: Path) -> dict[str, int]:
    """Return the number in each line by the line's first word."""
    lines = (line.split() for line in path.read_text().splitlines())
    return {words[0].rstrip(":"): int(words[1]) for words in lines if len(words) > 1}


def thread_count(value: object) -> int | str:
    """Return ``"auto"``, or a number of threads, checked to be at least one."""
    if isinstance(value, str) and value == "auto":
        return "auto"
    try:
        return integer(value, "The number of threads", at_least=1)
    except InputError:
        raise InputError.about("The number of threads", value, "'auto' or a whole number of at least 1") from None


def choose_threads(given: int | str, cells: int) -> tuple[int, str]:
    """Return the number of threads of a solve on so many cells, and why; a text that is given is ``"auto"``."""
    useful = max(1, cells // _CELLS_PER_THREAD)
    asked = None if isinstance(given, str) else given
    if asked == 1:
        return 1, "as given"
    if asked is None and useful == 1:
        return 1, f"two pay from {_TWO_THREADS_SIDE} x {_TWO_THREADS_SIDE} cells"
    if asked is None and (_IS_SHARED.get() or _is_pooled()):
        return 1, "others of a pool work beside this process"
    if asked is None and _has_limited_address_space():
        return 1, "each takes a part of the address space, which is limited (ulimit -v)"
    available = available_threads()
    if asked is not None:
        return (asked, "as given") if asked <= available else (available, f"not {asked}: this process may use no more")
    if useful < available:
        return useful, f"one for each {_CELLS_PER_THREAD} cells"
    return available, "this process may use no more"


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
    """Return whether Python's multiprocessing started this process, as for a pool."""
    process = sys.modules.get("multiprocessing.process")
    return process is not None and process.parent_process() is not None


def _has_limited_address_space() -> bool:
    """Return whether the address space is limited, of which the heap of each thread reserves 64 MiB."""
    with contextlib.suppress(ImportError):
        import resource

        return resource.getrlimit(resource.RLIMIT_AS)[0] != resource.RLIM_INFINITY
    return False


@contextlib.contextmanager
def _set(variable: contextvars.ContextVar[T], value: T) -> Iterator[None]:
    token = variable.set(value)
    try:
        yield
    finally:
        variable.reset(token)


def use_threads(count: int) -> contextlib.AbstractContextManager[None]:
    """Limit the threads used inside the context."""
    return _set(_THREADS, count)


def share_machine() -> contextlib.AbstractContextManager[None]:
    """Solve with one thread inside the context unless a problem asks for more: other processes use the machine too."""
    return _set(_IS_SHARED, True)


def threads_for(cells: int) -> int:
    """Return how many of the threads of the solve an array of so many cells can use."""
    return min(_THREADS.get(), max(1, cells // _CELLS_PER_THREAD))


def split(length: int, step: int) -> list[slice]:
    """Return the slices of an axis into parts of `step` entries; the last may be shorter."""
    return [slice(start, min(start + step, length)) for start in range(0, length, step)]


def tiles_of(values: npt.NDArray[Any]) -> list[slice]:
    """Return the tiles of an array along its first axis; one tile if it is not numpy's."""
    length = values.shape[0]
    if 0 < values.size <= _VALUES_PER_TILE:
        return [slice(0, length)]
    width = max(1, math.prod(values.shape[1:]))
    return split(length, max(1, _VALUES_PER_TILE // width) if isinstance(values, np.ndarray) else max(1, length))


def map_tiles(work: Callable[[S], T], tiles: Sequence[S]) -> list[T]:
    """Return the result of `work` for each tile, in their order; the threads of the solve share the tiles.

    Tiles must be independent of each other. The results have the same bits for any number of threads.
    """
    count = min(_THREADS.get(), len(tiles))
    if count == 1:
        return [work(tile) for tile in tiles]
    results: dict[int, T] = {}
    places = itertools.count()

    def take() -> None:
        while (place := next(places)) < len(tiles):
            results[place] = work(tiles[place])

    others = []
    # If no thread can be started, this one does all the work.
    with contextlib.suppress(RuntimeError):
        for _ in range(count - 1):
            # numpy keeps its treatment of floating-point errors in the context.
            others.append(_pool().submit(contextvars.copy_context().run, take))
    try:
        take()
    finally:
        for other in others:
            # A worker that has not begun has nothing left to do.
            if not other.cancel():
                other.result()
    return [results[place] for place in range(len(tiles))]


@cache
def _pool() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(os.cpu_count() or 1, thread_name_prefix="roughcontact")


# A forked process does not inherit the threads of the pool.
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_pool.cache_clear)
