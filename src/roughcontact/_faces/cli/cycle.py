"""``roughcontact solve --cycle``: loading and unloading of surfaces that attract each other."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

import roughcontact as rc
from roughcontact._base.machine.progress import count_done
from roughcontact._base.tables import Table
from roughcontact._base.units import fit, si
from roughcontact._faces.cli.answers import (
    describe_rows,
    is_doubtful,
    name_written,
    plan_picture,
    plan_report,
    write_csv,
    write_json,
    write_outputs,
    write_rows_of_answers,
)
from roughcontact._faces.cli.inputs import describe_responses
from roughcontact._faces.cli.problem import set_tolerance
from roughcontact._faces.cli.progress import show_progress
from roughcontact._faces.cli.responses import ask_all_states
from roughcontact._solve.problem import AdhesionCycle, describe_estimate, find_inputs
from roughcontact._work.studies import Answers, add_answers, write_report

# States on each branch.
_STATES = 41
# Options of a solve that say nothing of a cycle.
_OF_SOLVES = ("refine", "area", "area_within", "peak_within")


def plan_cycle_outputs(options: argparse.Namespace, maps: list[Path]) -> list[Path]:
    """Return the files of a cycle: its pictures, and its report."""
    return [*(plan_picture(name) for name in options.output), *plan_report(options.report, maps)]


def solve_cycle(
    options: argparse.Namespace,
    problem: rc.ContactProblem,
    asked: Mapping[str, rc.Response[Any]],
    files: list[Path],
) -> tuple[AdhesionCycle, bool]:
    """Return the cycle that the options describe, and whether its answers are warned of or missing.

    Its states are asked, and its pictures and its report are written.
    """
    problem = set_tolerance(options, problem)
    low, high = options.cycle
    states = _STATES if options.states is None else options.states
    total = 2 * states - 1
    with show_progress("solving", quiet=options.quiet) as change:
        cycle = problem.cycle(approach=np.linspace(low, high, states), on_state=count_done(change, total, "state"))
    reports = [path for path in files if path.suffix == ".html"]
    # Pictures before the responses, of which one may have no answer.
    written = write_outputs([path for path in files if path not in reports], cycle, ())
    answers: Answers = {}
    reasons: dict[str, str] = {}
    try:
        if asked and not (options.quiet and not reports):
            with show_progress("answering", quiet=options.quiet) as change:
                answers, reasons = ask_all_states(asked, (*cycle.loading, *cycle.unloading), change)
    finally:
        for path in reports:
            write_report(cycle, path, answers)
    if options.json:
        print(cycle_to_json(cycle, asked, answers, reasons))
    elif options.csv:
        print(write_csv(add_answers(cycle.table(), answers)))
    elif not options.quiet:
        print(cycle_to_text(cycle, answers, reasons))
        if done := name_written([*written, *reports]):
            print(done)
    warned = any(one.warnings for one in (cycle.pull_in, cycle.pull_off, cycle.dissipated))
    return cycle, bool(warned or reasons) or is_doubtful(answers, (*cycle.loading, *cycle.unloading))


def refuse_for_cycle(options: argparse.Namespace) -> None:
    """Refuse what does not fit a cycle, before anything is read."""
    if options.cycle is None:
        if options.states is not None:
            raise rc.InputError("--states is for --cycle, whose branches have them: give both, or neither.")
        return
    if options.adhesion is None:
        raise rc.InputError("--cycle is for surfaces that attract each other: give --adhesion too.")
    for name in _OF_SOLVES:
        if getattr(options, name) not in (None, False):
            shown = f"--{name.replace('_', '-')}"
            raise rc.InputError(f"{shown} is for single loads: omit it with --cycle, which has many states.")
    if options.states is not None and options.states < 2:
        raise rc.InputError.about("The number of --states", options.states, "at least 2")
    low, high = options.cycle
    if not low < high:
        raise rc.InputError(f"--cycle needs its lower approach first, but got {si(low, 'm')} and {si(high, 'm')}.")


def cycle_to_text(cycle: AdhesionCycle, answers: Answers, reasons: Mapping[str, str]) -> str:
    """Return a cycle for people, and below it what responses say of its states."""
    if not answers:
        return str(cycle)
    states = cycle.short_table()
    heads = Table({name: states.columns[name] for name in ("branch", "approach")}, {"approach": "m"}, ("branch",))
    names = [
        f"at {si(float(approach), 'm', 3)}, {branch}" for branch, approach in zip(*heads.columns.values(), strict=True)
    ]
    return fit("\n".join([str(cycle), "", *write_rows_of_answers(heads, names, answers, reasons)]))


def cycle_to_json(
    cycle: AdhesionCycle, asked: Mapping[str, rc.Response[Any]], answers: Answers, reasons: Mapping[str, str]
) -> str:
    """Return one JSON object: the results of a cycle, and its states, with what responses say of them."""
    table = add_answers(cycle.table(), answers)
    content: dict[str, Any] = {name: describe_estimate(getattr(cycle, name)) for name in ("pull_in", "pull_off")}
    content["dissipated"] = describe_estimate(cycle.dissipated)
    content["jumps"] = [list(jump) for jump in cycle.jumps]
    content["states"] = describe_rows(table)
    # Both branches have the same approaches.
    inputs = find_inputs(cycle.loading.states)
    content["inputs"] = None if inputs is None else inputs | describe_responses(asked)
    if reasons:
        content["without_answer"] = dict(reasons)
    return write_json({**content, "units": dict(table.units)})
