"""Writers of solutions into files: the base class, the registry, and the two formats that can be read back."""

from __future__ import annotations

import abc
import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, final

import attrs

from roughcontact._base import checks
from roughcontact._base.archive import replacing
from roughcontact._base.registry import Registry
from roughcontact._solve.solution import storage
from roughcontact.errors import InputError

if TYPE_CHECKING:
    from roughcontact._solve.solution.contact import ContactSolution


class SolutionWriter(abc.ABC):
    """A writer of one kind of file. Subclass it and register it in ``roughcontact.writers``.

    Examples
    --------
    >>> import numpy as np
    >>> import roughcontact as rc
    >>> class Text(rc.SolutionWriter):
    ...     suffixes = frozenset({".txt"})
    ...
    ...     def write(self, solution, path):
    ...         np.savetxt(path, solution.pressure)
    >>> ".txt" in Text().suffixes
    True
    """

    @property
    @abc.abstractmethod
    def suffixes(self) -> frozenset[str]:
        """The endings of the file names that it writes, lower case, with the dot."""

    @abc.abstractmethod
    def write(self, solution: ContactSolution, path: Path) -> None:
        """Write the file, completely or not at all."""


writers = Registry(SolutionWriter, "solution writer", "roughcontact.writers", in_files=False)


@final
@attrs.frozen
class ArchiveWriter(SolutionWriter):
    """Arrays for numpy, or netCDF with units, with the problem; `ContactSolution.load` reads both."""

    @property
    def suffixes(self) -> frozenset[str]:
        """Npz and nc."""
        return frozenset({".npz", ".nc"})

    def write(self, solution: ContactSolution, path: Path) -> None:
        """Write the file."""
        storage.write(path, solution)


def write_solution(solution: ContactSolution, path: Path) -> None:
    """Write a solution in the format that the ending of the file names."""
    # An ending that ships is found without a look at what plug-ins bring.
    names = sorted(writers, key=lambda name: path.suffix != f".{name}")
    known: set[str] = set()
    for name in names:
        writer = writers.create(name)
        if path.suffix in writer.suffixes:
            writer.write(solution, path)
            return
        known |= writer.suffixes
    raise InputError.about("The name of a solution's file", path.name, f"one ending in {', '.join(sorted(known))}")


def page_or_file(make: Callable[[], Any], path: str | os.PathLike[str] | None) -> str | None:
    """Return the text of a page, or write it to a file and return None."""
    target = None if path is None else checks.path(path, "The report")
    text: str = make()
    if target is None:
        return text
    with replacing(target) as partial:
        partial.write_text(text, encoding="utf-8")
    return None
