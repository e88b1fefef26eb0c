"""``roughcontact solve --cycle``: loading and unloading of surfaces that attract each other."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import numpy as np

import roughcontact as rc
from roughcontact._base.units import si
from roughcontact._faces.cli.answers import (
    describe_estimate,
    describe_rows,
    name_written,
    plan_picture,
    plan_report,
    write_csv,
    write_json,
    write_outputs,
)
from roughcontact._faces.cli.inputs import find_inputs
from roughcontact._faces.cli.problem import set_tolerance
from roughcontact._faces.cli.progress import count_done, show_progress
from roughcontact._solve.problem import AdhesionCycle

# States on each branch.
_STATES = 41
# Options of a solve that say nothing of a cycle.
_OF_SOLVES = ("refine", "area", "area_within", "peak_within", "pull_off")


def plan_cycle_outputs(options: argparse.Namespace, maps: list[Path]) -> list[Path]:
    """Return the files of a cycle: its pictures, and its report."""
    return [*(plan_picture(name) for name in options.output), *plan_report(options.report, maps)]


def solve_cycle(options: argparse.Namespace, problem: rc.ContactProblem, files: list[Path]) -> AdhesionCycle:
    """Return the cycle that the options describe, after writing its pictures and its report."""
    problem = set_tolerance(options, problem)
    low, high = options.cycle
    states = _STATES if options.states is None else options.states
    total = 2 * states - 1
    with show_progress("solving", quiet=options.quiet) as change:
        cycle = problem.cycle(approach=np.linspace(low, high, states), on_state=count_done(change, total, "state"))
    done = name_written(write_outputs(files, cycle, ()))
    if not options.quiet:
        write = cycle_to_json if options.json else cycle_to_csv if options.csv else str
        print(write(cycle))
        if done and write is str:
            print(done)
    return cycle


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


def cycle_to_csv(cycle: AdhesionCycle) -> str:
    """Return a header and a row for each state, in SI units: the columns of `AdhesionCycle.to_csv`."""
    return write_csv(cycle.table())


def cycle_to_json(cycle: AdhesionCycle) -> str:
    """Return one JSON object: the results of a cycle, and its states."""
    table = cycle.table()
    content: dict[str, Any] = {name: describe_estimate(getattr(cycle, name)) for name in ("pull_in", "pull_off")}
    content["dissipated"] = describe_estimate(cycle.dissipated)
    content["jumps"] = [list(jump) for jump in cycle.jumps]
    content["states"] = describe_rows(table)
    # Both branches have the same approaches.
    content["inputs"] = find_inputs(cycle.loading.solutions)
    return write_json({**content, "units": dict(table.units)})
