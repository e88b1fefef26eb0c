"""The states of a cycle or a path as text, JSON and CSV, and the files that a command writes of it."""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import attrs

import roughcontact as rc
from roughcontact._base import checks
from roughcontact._base.units import fit
from roughcontact._faces.cli.answers import (
    describe_rows,
    is_doubtful,
    name_written,
    plan_picture,
    plan_report,
    require_place,
    to_csv,
    to_json,
    to_text,
    write_csv,
    write_json,
    write_rows_of_answers,
)
from roughcontact._faces.cli.inputs import describe_responses
from roughcontact._faces.cli.progress import show_progress
from roughcontact._faces.cli.responses import ask_all_states
from roughcontact._faces.panels.figures import save_figure
from roughcontact._solve.problem import Path as StatePath
from roughcontact._solve.problem import describe_estimate, find_path_inputs
from roughcontact._work.studies import Answers, add_answers, write_report


@attrs.frozen
class Asked:
    """Responses that were asked for, their answers for each state, and why some have none."""

    responses: Mapping[str, rc.Response[Any]] = attrs.Factory(dict)
    answers: Answers = attrs.Factory(dict)
    reasons: Mapping[str, str] = attrs.Factory(dict)


_NOTHING = Asked()


def plan_path_outputs(options: argparse.Namespace, maps: list[Path]) -> list[Path]:
    """Return the files of a path or a state: itself, .npz, its picture, and its report."""
    files = []
    for text in options.output:
        path = checks.path(text, "The output")
        path = path if path.suffix == ".npz" else plan_picture(text, (".npz",))
        require_place(path, [path], maps)
        files.append(path)
    return files + plan_report(options.report, maps)


def write_path(
    options: argparse.Namespace,
    subject: StatePath | rc.ContactSolution,
    asked: Mapping[str, rc.Response[Any]],
    files: Sequence[Path],
) -> bool:
    """Print a path, or a state, as text, JSON or CSV and write its files; return whether it has warnings."""
    states = subject.states if isinstance(subject, StatePath) else [subject]
    reports = [file for file in files if file.suffix == ".html"]
    # Files before the responses, of which one may have no answer.
    for file in files:
        if file.suffix == ".npz":
            subject.save(file)
        elif file not in reports:
            save_figure(subject.plot(), file)
    found = Asked(asked)
    try:
        if asked and not (options.quiet and not reports):
            with show_progress("answering", quiet=options.quiet) as change:
                found = Asked(asked, *ask_all_states(asked, states, change))
    finally:
        for file in reports:
            write_report(subject if isinstance(subject, StatePath) else states, file, found.answers)
    if not options.quiet:
        print(_format(subject, found, options))
        if files and not (options.json or options.csv):
            print(name_written(files))
    return bool(subject.warnings or found.reasons) or is_doubtful(found.answers, states)


def _format(subject: StatePath | rc.ContactSolution, asked: Asked, options: argparse.Namespace) -> str:
    if isinstance(subject, StatePath):
        write = path_to_json if options.json else path_to_csv if options.csv else path_to_text
        return write(subject, asked)
    if options.json:
        return to_json([subject], None, asked.answers, describe_responses(asked.responses))
    return (to_csv if options.csv else to_text)([subject], None, asked.answers)


def path_to_text(path: StatePath, asked: Asked = _NOTHING) -> str:
    """Return a path for people, and below it what responses say of its states, in lines of at most 80 columns."""
    lines = [str(path)]
    if asked.answers:
        lines += ["", *write_rows_of_answers(*path.label_states(), asked.answers, asked.reasons)]
    return fit("\n".join(lines))


def path_to_csv(path: StatePath, asked: Asked = _NOTHING) -> str:
    """Return a header and a row for each state, in SI units: the columns of its `table`, and answers."""
    return write_csv(add_answers(path.table(), asked.answers))


def path_to_json(path: StatePath, asked: Asked = _NOTHING) -> str:
    """Return one JSON object: the numbers of a path, and its states, with what responses say of them."""
    table = add_answers(path.table(), asked.answers)
    states = describe_rows(table)
    for row, state in zip(states, path, strict=True):
        row |= {"status": state.status.name, "residual": state.certificate.error}
    numbers = path.list_numbers().items()
    inputs = find_path_inputs(path)
    content = {
        **{name: None if one is None else describe_estimate(one) for name, one in numbers},
        **path.list_rest(),
        "states": states,
        "warnings": list(path.warnings),
        **({"without_answer": dict(asked.reasons)} if asked.reasons else {}),
        "inputs": None if inputs is None else inputs | describe_responses(asked.responses),
        "units": dict(table.units),
    }
    return write_json(content)
