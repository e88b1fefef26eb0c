"""The parser of a command, and its help: in short, or by topics of options that are seldom needed."""

from __future__ import annotations

import argparse
import contextlib
import difflib
import os
import re
import shutil
import sys
import textwrap
from collections.abc import Sequence
from typing import Any, NoReturn

from roughcontact._base.units import WIDTH, printable
from roughcontact.errors import name_known, shorten

# The topic of all options, and the option that asks for it.
_ALL = "all"
_HELP_ALL = "--help-all"
# Column from which on the texts of options stand, characters.
_TEXT_COLUMN = 27
# Most characters of a wrong argument's sentence.
_MAX_SENTENCE_CHARACTERS = 400


def tell(sentence: str) -> None:
    """Print a sentence on standard error."""
    print(wrap(sentence), file=sys.stderr)


def wrap(sentence: str) -> str:
    """Return a sentence for standard error; on a terminal it is wrapped at blanks, since terminals break words."""
    text = printable(sentence)
    if not sys.stderr.isatty():
        return text
    columns = 0
    # Of the terminal that shows it: standard output may go to a file. Some terminals state no width.
    with contextlib.suppress(OSError, ValueError):
        columns = os.get_terminal_size(sys.stderr.fileno()).columns
    width = max(shutil.get_terminal_size(fallback=(columns or WIDTH, 24)).columns - 1, 20)
    return textwrap.fill(text, width, break_long_words=False, break_on_hyphens=False)


def add_group(parser: argparse.ArgumentParser, title: str, topic: str = "") -> Any:
    """Return a group of options; with a topic the short help leaves them to ``--help TOPIC``."""
    group: Any = parser.add_argument_group(title)
    group.topic = topic
    return group


def leave_to(topic: str, *options: Any) -> None:
    """Leave single options of a group to ``--help TOPIC``."""
    for option in options:
        option.topic = topic


def show(*options: Any) -> None:
    """Show single options of a topic in the short help too."""
    for option in options:
        option.is_shown = True


class Parser(argparse.ArgumentParser):
    """A parser whose errors do not repeat thousands of characters, and that takes -1N for a value, not an option.

    Its help leaves options with a topic to ``--help TOPIC``.
    """

    def __init__(self, **others: Any) -> None:
        others = {"formatter_class": _Formatter, **others, "add_help": False}
        super().__init__(**others)
        self.topic = ""
        self._help = self.add_argument("-h", "--help", action=_Help, nargs=0, help="show this help and exit")
        # As Python 3.14 has it; before, it takes -1 for a number, but -1N for an option.
        self._negative_number_matcher = re.compile(r"-\.?[0-9]")

    @property
    def topics(self) -> dict[str, list[str]]:
        """The titles of the groups of each topic."""
        found: dict[str, list[str]] = {}
        for group in self._action_groups:
            for topic in dict.fromkeys(_topic_of(option, group) for option in group._group_actions):
                if topic:
                    found.setdefault(topic, []).append(group.title or "")
        return found

    @property
    def needs_arguments(self) -> bool:
        """Whether it refuses a call without arguments."""
        return any(action.required for action in self._actions)

    def offer_topics(self) -> None:
        """Let ``--help`` take a topic, if there are some."""
        if self.topics:
            self._help.nargs = "?"
            self._help.metavar = "TOPIC"
            self._help.help = f"show this help, or the options of a topic: {', '.join(self.topics)}"
            self.add_argument(_HELP_ALL, action=_Help, nargs=0, const=_ALL, help="show the help of all options")

    def format_help(self) -> str:
        """Return the help of the topic, or in short without one."""
        formatter = self._get_formatter()
        is_short = self.topic not in (*self.topics, _ALL)
        if is_short or self.topic == _ALL:
            formatter.add_usage(self.usage, self._actions, self._mutually_exclusive_groups)
            formatter.add_text(self.description)
        for group in self._action_groups:
            formatter.start_section(group.title)
            formatter.add_arguments([one for one in group._group_actions if self._shows(one, group, is_short)])
            formatter.end_section()
        if is_short:
            formatter.add_text(self._name_topics())
        if is_short or self.topic == _ALL:
            formatter.add_text(self.epilog)
        return formatter.format_help()

    def _shows(self, option: argparse.Action, group: Any, is_short: bool) -> bool:
        topic = _topic_of(option, group)
        if is_short:
            return not topic or getattr(option, "is_shown", False)
        return self.topic in (_ALL, topic)

    def _name_topics(self) -> str:
        lines = [f"  --help {topic:11} {', '.join(titles)}" for topic, titles in self.topics.items()]
        return "\n".join(["more options:", *lines, f"  {_HELP_ALL:18} all of them"]) if lines else ""

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Parse arguments, after naming the option that is meant by one that does not exist."""
        # A parser of several kinds leaves the options to that of the kind.
        for text in () if self._subparsers is not None else args or ():
            name = text.partition("=")[0]
            known = self._option_string_actions
            if name.startswith("--") and not any(one.startswith(name) for one in known):
                close = difflib.get_close_matches(name[:80], known, n=1)
                if close:
                    self.error(f"there is no option {name}; did you mean {close[0]}?")
        return super().parse_known_args(args, namespace)

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        """Refuse a word that is none of the choices of an option, and name those that may be meant."""
        if action.choices is not None and value not in action.choices:
            known = name_known(value, map(str, action.choices))
            raise argparse.ArgumentError(action, f"there is no {shorten(repr(value), 80)}.{known}")

    def error(self, message: str) -> NoReturn:
        """Print the usage and what is wrong, and exit with 2."""
        self.print_usage(sys.stderr)
        tell(f"{self.prog}: error: {shorten(message, _MAX_SENTENCE_CHARACTERS)}")
        raise SystemExit(2)


def _topic_of(option: argparse.Action, group: Any) -> str:
    topic: str = getattr(option, "topic", getattr(group, "topic", ""))
    return topic


class _Help(argparse.Action):
    """Print the help, of a topic if one is given, and exit."""

    def __init__(self, option_strings: Sequence[str], dest: str, **others: Any) -> None:
        super().__init__(option_strings, argparse.SUPPRESS, default=argparse.SUPPRESS, **others)

    def __call__(self, parser: Any, namespace: Any, values: Any, option_string: str | None = None) -> None:
        parser.topic = self.const or (values if isinstance(values, str) else "")
        parser.print_help()
        parser.exit()


class _Formatter(argparse.RawDescriptionHelpFormatter):
    """Help whose options have one value or several written short: ``--loads L ...``."""

    def __init__(self, prog: str, **others: Any) -> None:
        width = min(shutil.get_terminal_size().columns, WIDTH)
        super().__init__(prog, **{"max_help_position": _TEXT_COLUMN, "width": width, **others})

    def _split_lines(self, text: str, width: int) -> list[str]:
        return textwrap.wrap(" ".join(text.split()), width, break_long_words=False, break_on_hyphens=False)

    def _format_args(self, action: argparse.Action, default_metavar: str) -> str:
        names = action.metavar if isinstance(action.metavar, tuple) else (action.metavar or default_metavar,)
        if action.nargs == argparse.ONE_OR_MORE:
            return f"{' '.join(names)} ..." if len(names) == 1 else f"{names[0]} [{names[1]} ...]"
        if action.nargs == argparse.ZERO_OR_MORE and len(names) == 1:
            return f"[{names[0]} ...]"
        return super()._format_args(action, default_metavar)
