"""The command line: a `Command` for each subcommand of ``roughcontact``."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, ClassVar

from roughcontact._base.registry import Registry

if TYPE_CHECKING:
    import argparse

# The exit status of a converged solution that has warnings.
DOUBTFUL = 3


class Command(ABC):
    """A subcommand of ``roughcontact``, named by an entry point of the group ``roughcontact.commands``.

    The first line of its docstring describes it in ``roughcontact --help``.

    Attributes
    ----------
    epilog
        Examples at the end of its help.
    """

    epilog: ClassVar[str] = ""

    @abstractmethod
    def declare(self, parser: argparse.ArgumentParser) -> None:
        """Add the arguments of this command to its parser."""

    @abstractmethod
    def run(self, options: argparse.Namespace) -> int:
        """Return the exit status: 0, 1 if something failed that is not an error of the user, or `DOUBTFUL`.

        An error of `roughcontact.errors` becomes one sentence. Slow imports belong here, so that ``--help`` does not
        wait for them.
        """


commands = Registry(Command, "command", "roughcontact.commands", in_files=False, translates_errors=False)
