"""``roughcontact solve --cycle``: loading and unloading of surfaces that attract each other."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

import roughcontact as rc
from roughcontact._base.machine.progress import count_done
from roughcontact._base.units import si
from roughcontact._faces.cli.paths import write_path
from roughcontact._faces.cli.problem import set_tolerance
from roughcontact._faces.cli.progress import show_progress
from roughcontact._solve.problem import AdhesionCycle

# States on each branch.
_STATES = 41
# Options of a solve that say nothing of a cycle.
_OF_SOLVES = ("refine", "area", "area_within", "peak_within")


def solve_cycle(
    options: argparse.Namespace,
    problem: rc.ContactProblem,
    asked: Mapping[str, rc.Response[Any]],
    files: list[Path],
) -> tuple[AdhesionCycle, bool]:
    """Return the cycle that the options describe, and whether it is warned of; it is printed, and its files written."""
    problem = set_tolerance(options, problem)
    low, high = options.cycle
    states = _STATES if options.states is None else options.states
    total = 2 * states - 1
    with show_progress("solving", quiet=options.quiet) as change:
        cycle = problem.cycle(approach=np.linspace(low, high, states), on_state=count_done(change, total, "state"))
    doubtful = write_path(options, cycle, asked, files)
    return cycle, doubtful or any(one.warnings for one in (cycle.pull_in, cycle.pull_off, cycle.dissipated))


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
