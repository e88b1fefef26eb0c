"""How much more memory this process may take, asked before it is taken."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path

from roughcontact.errors import InputError
from roughcontact.units import binary

# Bytes that are taken without asking: asking costs up to a millisecond, and importing a library takes as much.
_UNASKED = 2**24
# The files of a cgroup's limit and use, and the entries of its memory.stat that the kernel gives back; versions 2, 1.
_CGROUPS = {
    "": ("memory.max", "memory.current", ("inactive_file", "active_file")),
    "memory": ("memory.limit_in_bytes", "memory.usage_in_bytes", ("total_inactive_file", "total_active_file")),
}


def require_memory(needed: float, what: str, advice: str) -> None:
    """Refuse what needs more memory than this process may still take, as far as that is known.

    Parameters
    ----------
    needed
        Memory that will be taken at least, bytes.
    what
        What needs it, the subject of the sentence.
    advice
        What to do.

    Raises
    ------
    InputError
        If there is less.
    """
    if needed <= _UNASKED:
        return
    available = available_memory()
    if available is not None and needed > available:
        there = f"this process may take only {binary(available)} more"
        raise InputError(f"{what} needs {binary(needed)} of memory, but {there}: {advice}.")


def available_memory(root: Path = Path("/")) -> int | None:
    """Return how much more memory this process may take, bytes; None where that is not known.

    It is the minimum of what the machine has free or can free, what the control groups (cgroup 1 and 2) of a container
    or of a job leave, and what the limits of the process (``ulimit -v`` and ``-d``) leave. `root` is for tests.
    """
    found = [*_of_machine(root), *_of_groups(root), *_of_process(root)]
    return max(0, min(found)) if found else None


def _of_machine(root: Path) -> Iterator[int]:
    with contextlib.suppress(OSError, ValueError, KeyError):
        entries = _read_table(root / "proc/meminfo")
        yield 1024 * (entries["MemAvailable"] + entries.get("SwapFree", 0))


def _of_groups(root: Path) -> Iterator[int]:
    lines: list[str] = []
    with contextlib.suppress(OSError, ValueError):
        lines = (root / "proc/self/cgroup").read_text(encoding="utf-8").splitlines()
    for line in lines:
        _, controllers, place = line.split(":", 2)
        for controller, names in _CGROUPS.items():
            if controller in controllers.split(","):
                group = root / "sys/fs/cgroup" / controller / place.lstrip("/")
                # Every group above sets a limit too. In a container the lowest that is visible is its own.
                while group.is_relative_to(root / "sys/fs/cgroup" / controller):
                    yield from _of_group(group, *names)
                    group = group.parent


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
