"""The versions of the programs and what the machine has, for a report of a fault."""

from __future__ import annotations

import os
import platform
import re
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, entry_points, requires, version

from roughcontact._base.machine import available_memory, available_threads
from roughcontact._base.units import binary
from roughcontact.errors.door import guarded

_PACKAGE = "roughcontact"
# Variables that set the threads of the libraries below numpy.
_THREAD_VARIABLES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


@guarded
def show_versions() -> None:
    """Print the versions of Python, the system, the packages and the plug-ins, with threads and memory.

    A report of a fault needs them. The command ``roughcontact --version --verbose`` prints the same.

    Examples
    --------
    >>> import roughcontact as rc
    >>> rc.show_versions()  # doctest: +SKIP
    roughcontact  0.1.0
    python        3.11.7 (CPython)
    system        Linux-6.1-x86_64
    threads       2
    memory        22.9 GiB
    numpy         2.4.6
    ...
    """
    rows = list_versions()
    width = max(map(len, rows))
    print("\n".join(f"{name:{width}}  {text}" for name, text in rows.items()))


def list_versions() -> dict[str, str]:
    """Return what `show_versions` prints, by name."""
    memory = available_memory()
    rows = {
        _PACKAGE: version(_PACKAGE),
        "python": f"{platform.python_version()} ({platform.python_implementation()})",
        "system": platform.platform(),
        "threads": str(available_threads()),
        "memory": "not known" if memory is None else f"{binary(memory)} available",
    }
    rows |= {name: os.environ[name] for name in _THREAD_VARIABLES if name in os.environ}
    for name in [*_list_packages(), *_list_plugins()]:
        with suppress(PackageNotFoundError):
            rows.setdefault(name, version(name))
    return rows


def _list_packages() -> list[str]:
    """Return the names of the packages that this one needs or can use."""
    names = (re.match(r"[\w.-]+", line) for line in requires(_PACKAGE) or ())
    return list(dict.fromkeys(found[0] for found in names if found and not found[0].startswith(_PACKAGE)))


def _list_plugins() -> list[str]:
    """Return the names of the distributions that add parts, commands or pictures."""
    points = entry_points()
    groups = [group for group in points.groups if group.startswith(f"{_PACKAGE}.")]
    return sorted({one.dist.name for group in groups for one in points.select(group=group) if one.dist is not None})
