"""What a contact does, such as its stiffness, on the command line: an option for each registered response."""

from __future__ import annotations

import argparse
import contextlib
from collections.abc import Mapping, Sequence
from typing import Any

import roughcontact as rc
from roughcontact._answers.linear.stiffness import find_pull_off_once
from roughcontact._base.machine.progress import ChangeProgress
from roughcontact._base.registry import PartField
from roughcontact._base.units import EXAMPLES, si
from roughcontact._faces.cli.help import add_group
from roughcontact._faces.cli.problem import make_part
from roughcontact._solve.problem import OnStateToPullOff, problem_of
from roughcontact._work.studies import Answers, ask_states, describe_response
from roughcontact.errors import Sentence

# Registered name of the force of pull-off.
PULL_OFF = "pull-off"


def add_responses(parser: argparse.ArgumentParser) -> None:
    """Declare an option for each registered response whose name is free; `InputError` if one cannot be loaded."""
    group = add_group(parser, "what the contact does", "responses")
    for name in rc.responses:
        form = describe_response(name)
        if form.is_array:
            continue
        needed = [f"{field.name}={_write_example(field)}" for field in form.fields if field.is_needed]
        others = [f"[{field.name}={_write_default(field)}]" for field in form.fields if not field.is_needed]
        with contextlib.suppress(argparse.ArgumentError):
            group.add_argument(
                f"--{name}",
                dest=f"response {name}",
                nargs="+" if needed else "*",
                metavar="VALUE" if len(needed) == 1 else "FIELD=VALUE",
                help=": ".join(filter(None, (form.summary, " ".join(needed + others)))).replace("%", "%%"),
            )


def _write_example(field: PartField) -> str:
    """Return an example of the value of a field, with its unit; dots where it has none."""
    unit = field.unit or field.plain_unit
    return f"{EXAMPLES[unit] if unit and unit in EXAMPLES else '...'}{_write_plain_unit(field)}"


def _write_plain_unit(field: PartField) -> str:
    return f" ({field.plain_unit})" if field.plain_unit else ""


def _write_default(field: PartField) -> str:
    """Return the default of a field of a response; dots where it is nothing that one can write."""
    default = field.default
    shown = f"{default:g}" if isinstance(default, float) else str(default) if isinstance(default, (int, str)) else "..."
    return f"{shown}{_write_plain_unit(field)}"


def responses_of(options: argparse.Namespace) -> dict[str, rc.Response[Any]]:
    """Return the responses that the options ask for, by name."""
    asked = {}
    for name in rc.responses:
        texts = getattr(options, f"response {name}", None)
        if texts is not None:
            needed = [field.name for field in describe_response(name).fields if field.is_needed]
            # Of one field that is needed the value is enough: --first-yield 1GPa.
            named = [f"{needed[0]}={text}" if len(needed) == 1 and "=" not in text else text for text in texts]
            asked[name] = make_part(rc.responses, f"--{name}", name, named)
    return asked


def refuse_pull_off(options: argparse.Namespace, asked: Mapping[str, rc.Response[Any]]) -> None:
    """Refuse the force of pull-off of surfaces that do not attract each other, and beside a path that has its own."""
    if PULL_OFF not in asked:
        return
    if options.adhesion is None:
        raise rc.InputError("--pull-off is for surfaces that attract each other: give --adhesion too.")
    if options.cycle is not None:
        raise rc.InputError("--pull-off is for single loads: omit it with --cycle, which states its own.")


def ask_all_states(
    asked: Mapping[str, rc.Response[Any]],
    states: Sequence[rc.ContactSolution],
    change: ChangeProgress,
) -> tuple[Answers, dict[str, str]]:
    """Return what each response says of each state, None where it has no answer, and in sentences why.

    `InputError`, with its option, of one that has no answer at all.
    """
    total = len(asked) * len({id(state) for state in states})
    done = 0

    def tell(name: str) -> None:
        nonlocal done
        change(f"{name}, answer {done + 1} of {total}", done / total)
        done += 1

    answers, reasons = ask_states(asked, states, tell)
    for name, reason in reasons.items():
        if not any(result is not None for result in answers[name]):
            raise rc.InputError(f"--{name}: {Sentence(reason).marked}")
    return answers, reasons


def _tell_states(change: ChangeProgress) -> OnStateToPullOff:
    """Return a function that shows each state on the way to pull-off."""
    count = 0
    change("pull-off, state 1")

    def tell(state: rc.ContactSolution, left: int | None) -> None:
        nonlocal count
        count += 1
        total = None if left is None else count + left
        text = f"pull-off, state {count}{f' of about {total}' if total else ''}, force {si(state.force, 'N', 3)}"
        change(text, count / total if total else None)

    return tell


def ask(
    asked: Mapping[str, rc.Response[Any]], solutions: Sequence[rc.ContactSolution], change: ChangeProgress
) -> Answers:
    """Return what each response says of each solution; `InputError`, with its option, where it has no answer."""
    found: dict[str, list[Any]] = {}
    total = len(asked) * len(solutions)
    for name, response in asked.items():
        found[name] = []
        for solution in solutions:
            done = len(solutions) * (len(found) - 1) + len(found[name])
            change(f"{name}, answer {done + 1} of {total}", done / total)
            try:
                if name == PULL_OFF:
                    find_pull_off_once(problem_of(solution), _tell_states(change))
                found[name].append(solution.response(response))
            except rc.InputError as error:
                raise rc.InputError(f"--{name}: {error.marked}") from error
    return found
