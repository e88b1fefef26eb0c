"""``roughcontact solve --friction``: a contact with friction along a path of tangential loads, or in steady sliding."""

from __future__ import annotations

import argparse
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import roughcontact as rc
from roughcontact._base.machine.progress import ChangeProgress
from roughcontact._base.units import parse_quantity
from roughcontact._faces.cli.paths import write_path
from roughcontact._faces.cli.problem import make_part, set_tolerance
from roughcontact._faces.cli.progress import count_solves, describe_steps, show_progress
from roughcontact._parts.grid import Load
from roughcontact._parts.materials import pair_constants
from roughcontact._solve.problem import (
    Increment,
    explain_with_friction,
    require_frictional,
    run_slide,
)

# Options of a solve that say nothing of a contact with friction.
_OF_SOLVES = ("cycle", "refine", "area", "area_within", "peak_within")


def refuse_for_friction(options: argparse.Namespace) -> None:
    """Refuse what does not fit a contact with friction, before anything is read."""
    if options.substeps is not None and options.tangential is None:
        raise rc.InputError("--substeps is for loads along the surface: give --tangential too, or omit it.")
    if options.tangential is None and options.slide is None:
        if options.friction is not None:
            raise rc.InputError("--friction is for loads along the surface: give --tangential or --slide too.")
        return
    given = "--tangential" if options.slide is None else "--slide"
    if options.friction is None:
        raise rc.InputError(f"{given} needs a law by which the surfaces slip: give --friction 0.3, for example.")
    for name in _OF_SOLVES:
        if getattr(options, name) not in (None, False):
            shown = f"--{name.replace('_', '-')}"
            raise rc.InputError(f"{shown} is for loads without friction: omit it with {given}.")
    if options.slide is not None:
        if options.loads is not None:
            raise rc.InputError("--slide is for one load: give that instead of --loads.")
        return
    kinds = {kind for kind, _ in options.tangential}
    if len(kinds) > 1:
        raise rc.InputError("--tangential needs loads of one kind, but got forces and displacements.")


def friction_of(options: argparse.Namespace) -> rc.FrictionLaw:
    """Return the law that ``--friction`` names: a number is a coefficient of friction."""
    # A blank stands before a number with a minus; see `main`.
    first, *others = (text.strip() for text in options.friction)
    if others or first[:1].isalpha():
        law: rc.FrictionLaw = make_part(rc.frictions, "--friction", first, others)
        return law
    try:
        return rc.Coulomb(parse_quantity(first, ""))
    except ValueError as error:
        raise rc.InputError(f"--friction: {error}.") from error


def explain_friction(options: argparse.Namespace, problem: rc.ContactProblem, law: rc.FrictionLaw) -> str:
    """Return the plan of a path or of steady sliding, in words."""
    require_frictional(problem)
    # A path begins with the state under the normal load alone.
    states = 1 if options.tangential is None else 1 + len(options.tangential)
    return explain_with_friction(problem.plan, law, states)


def solve_friction(
    options: argparse.Namespace,
    problem: rc.ContactProblem,
    law: rc.FrictionLaw,
    loads: tuple[Load, ...],
    asked: Mapping[str, rc.Response[Any]],
    files: list[Path],
) -> bool:
    """Solve a contact with friction, print it and write its files; return whether it has warnings."""
    problem = set_tolerance(options, problem)
    if options.slide is None:
        return write_path(options, _solve_path(options, problem, law, loads), asked, files)
    with show_progress("pressing", quiet=options.quiet) as change:
        state = _slide(options, problem, law, loads[0], change)
    return write_path(options, state, asked, files)


def _solve_path(
    options: argparse.Namespace, problem: rc.ContactProblem, law: rc.FrictionLaw, loads: tuple[Load, ...]
) -> rc.FrictionalPath:
    values: Any = loads[0].value if options.loads is None else [load.value for load in loads]
    kind = options.tangential[0][0]
    along: dict[str, Any] = {kind: [pair for _, pair in options.tangential]}
    substeps = "auto" if options.substeps is None else options.substeps
    with show_progress("pressing", quiet=options.quiet) as change:

        def tell(done: Increment) -> None:
            # The pressing is not counted: it may be a solve that has been asked for, or many increments.
            change(str(done), (done.step - 1 + done.increment / done.increments) / done.steps if done.step else None)

        return problem.path(**{loads[0].kind: values}, **along, friction=law, substeps=substeps, on_increment=tell)


def _slide(
    options: argparse.Namespace, problem: rc.ContactProblem, law: rc.FrictionLaw, load: Load, change: ChangeProgress
) -> rc.ContactSolution:
    shape = problem.plan.grid.shape
    tolerance = problem.plan.solver.tolerance
    # Of unlike bodies pressure and traction are found in turn, which takes about as long as pressing.
    unlike = pair_constants(problem.body.material, problem.counterbody.material).beta != 0.0
    press = describe_steps(change, "pressing", count_solves(shape, tolerance, (0, 2 if unlike else 1)))
    slide = describe_steps(change, "sliding", count_solves(shape, tolerance, (1, 2)))
    return run_slide(problem, load.arguments, law, math.degrees(options.slide), press, slide)
