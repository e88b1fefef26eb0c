"""``roughcontact completion``: the tab key of a shell completes commands, options and files."""

from __future__ import annotations

import argparse

import roughcontact as rc
from roughcontact._faces.cli import Command, commands


class Completion(Command):
    """Print a script with which a shell completes commands and options."""

    epilog = """
examples:
  mkdir -p ~/.local/share/bash-completion/completions
  roughcontact completion bash \\
      > ~/.local/share/bash-completion/completions/roughcontact
  roughcontact completion zsh > ~/.zfunc/_roughcontact
"""

    def declare(self, parser: argparse.ArgumentParser) -> None:
        parser.add_argument("shell", choices=("bash", "zsh", "tcsh"), help="the shell that is to read it")

    def run(self, options: argparse.Namespace) -> int:
        """Print the script, and return 0."""
        try:
            import shtab
        except ImportError:
            raise rc.MissingPackage("Completion needs shtab: pip install 'roughcontact[cli]'.") from None
        print(shtab.complete(_all_commands(), shell=options.shell))
        return 0


def _all_commands() -> argparse.ArgumentParser:
    """Return one parser of all commands that can be loaded."""
    parser = argparse.ArgumentParser(prog="roughcontact")
    parser.add_argument("--version", action="store_true")
    known = parser.add_subparsers()
    for name in commands:
        try:
            command = commands.create(name)
            command.declare(known.add_parser(name, help=(type(command).__doc__ or "").partition("\n")[0]))
        # A broken command of somebody else is not completed.
        except Exception:
            continue
    return parser
