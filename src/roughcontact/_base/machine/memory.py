"""How much more memory this process may take, asked before it is taken."""

from __future__ import annotations

import contextlib
import functools
import os
import re
from collections.abc import Callable, Iterator
from pathlib import Path

from roughcontact._base.checks import number
from roughcontact._base.checks.groups import control_groups
from roughcontact._base.units import binary
from roughcontact.errors import InputError, NotEnoughMemory
from roughcontact.errors.door import guarded

# Bytes that are taken without asking: asking costs up to a millisecond, and importing a library takes as much.
_UNASKED = 2**24
# Address space that threads and libraries reserve without taking memory.
_UNTOUCHED = 2**31
# A number of bytes in words, and the bytes of each unit.
_SIZE = re.compile(r"\s*([0-9]{1,18}(?:\.[0-9]{0,18})?)\s*(bytes|B|[kMGT]B|[KMGT]iB)\s*")
_UNITS = {"B": 1, "bytes": 1, **{f"{name}B": 1000**power for power, name in enumerate("kMGT", 1)}}
_UNITS |= {f"{name}iB": 1024**power for power, name in enumerate("KMGT", 1)}
# The files of a group's limit and use, and the entries of its memory.stat that the kernel gives back, by version.
_FILES = {
    2: ("memory.max", "memory.current", ("inactive_file", "active_file")),
    1: ("memory.limit_in_bytes", "memory.usage_in_bytes", ("total_inactive_file", "total_active_file")),
}


def limit_of_memory(value: float | str | None) -> int | None:
    """Return a limit in bytes, given as a number or a text such as ``"8 GiB"``, or None, or raise `InputError`."""
    what = "The limit of the memory"
    if isinstance(value, str):
        found = _SIZE.fullmatch(value)
        if found is None:
            raise InputError.about(what, value, "a number of bytes, or a text such as '8 GiB' or '500 MB'")
        value = float(found[1]) * _UNITS[found[2]]
    return None if value is None else int(number(value, what, "bytes", at_least=1.0))


def require_memory(needed: float, what: str, advice: str | Callable[[int], str], limit: int | None = None) -> None:
    """Raise `NotEnoughMemory` if `needed` exceeds the memory available to this process, as far as known, or `limit`.

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

    Raises
    ------
    NotEnoughMemory
        If there is less.
    """
    available = limit if limit is not None or needed <= _UNASKED else available_memory()
    if available is not None and needed > available:
        process = f"this process may take only {binary(available)} more"
        there = process if limit is None else f"memory_limit= allows only {binary(limit)}"
        told = advice if isinstance(advice, str) else advice(available)
        error = NotEnoughMemory(f"{what} needs {binary(needed)} of memory, but {there}: {told}.")
        error.available = there
        raise error


@guarded
def available_memory(root: Path = Path("/")) -> int | None:
    """Return how much more memory this process may take, bytes; None where that is not known.

    It is the minimum of what the machine has free or can free, what the control groups (cgroup 1 and 2) of a container
    or of a job leave, and what the limits of the process (``ulimit -v`` and ``-d``) leave. `root` is for tests.
    """
    found = [*_of_machine(root), *_of_groups(root), *_of_process(root)]
    return max(0, min(found)) if found else None


@guarded
def limit_address_space(root: Path = Path("/")) -> None:
    """Let this process take no more memory than there is now, where the system can: it fails before the machine does.

    What asks for more then meets a MemoryError. It may be called again, when there is more or less.
    """
    with contextlib.suppress(ImportError, OSError, ValueError):
        import resource

        soft, hard = _own_limits()
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))
        available = available_memory(root)
        used = int((root / "proc/self/statm").read_text().split()[0]) * os.sysconf("SC_PAGE_SIZE")
        if available is not None:
            limits = (used + available + _UNTOUCHED, soft, hard)
            limit = min(limit for limit in limits if limit != resource.RLIM_INFINITY)
            resource.setrlimit(resource.RLIMIT_AS, (limit, hard))


@functools.cache
def _own_limits() -> tuple[int, int]:
    """Return the limits of the address space with which this process was started."""
    import resource

    return resource.getrlimit(resource.RLIMIT_AS)


def _of_machine(root: Path) -> Iterator[int]:
    with contextlib.suppress(OSError, ValueError, KeyError):
        entries = _read_table(root / "proc/meminfo")
        yield 1024 * (entries["MemAvailable"] + entries.get("SwapFree", 0))


def _of_groups(root: Path) -> Iterator[int]:
    for group, version in control_groups("memory", root):
        yield from _of_group(group, *_FILES[version])


def _of_group(group: Path, limit: str, usage: str, cached: tuple[str, ...]) -> Iterator[int]:
    # Without a limit the file says "max", or is missing as in the topmost group.
    with contextlib.suppress(OSError, ValueError):
        free = int((group / limit).read_text()) - int((group / usage).read_text())
        with contextlib.suppress(OSError, ValueError):
            entries = _read_table(group / "memory.stat")
            free += sum(entries.get(name, 0) for name in cached)
        yield free


def _of_process(root: Path) -> Iterator[int]:
    with contextlib.suppress(ImportError, OSError, ValueError):
        import resource

        pages = [int(word) for word in (root / "proc/self/statm").read_text().split()]
        for kind, used in ((resource.RLIMIT_AS, pages[0]), (resource.RLIMIT_DATA, pages[5])):
            limit = resource.getrlimit(kind)[0]
            if limit != resource.RLIM_INFINITY:
                yield limit - used * os.sysconf("SC_PAGE_SIZE")


def _read_table(path: Path) -> dict[str, int]:
    """Return the first number of each line by the line's first word."""
    lines = (line.split() for line in path.read_text().splitlines())
    return {words[0].rstrip(":"): int(words[1]) for words in lines if len(words) > 1}
