"""Paths on the command line: cycles of adhesion, loads along the surface, sliding; printed, and written to files."""

from __future__ import annotations

import argparse
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import attrs
import numpy as np

import roughcontact as rc
from roughcontact._base import checks
from roughcontact._base.machine.progress import ChangeProgress, count_done
from roughcontact._base.units import fit, parse_quantity, si
from roughcontact._faces.cli.answers import (
    describe_responses,
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
from roughcontact._faces.cli.options import refuse
from roughcontact._faces.cli.problem import make_part, set_tolerance
from roughcontact._faces.cli.progress import count_solves, describe_steps, show_progress
from roughcontact._faces.cli.responses import ask_all_states
from roughcontact._faces.panels.figures import save_figure
from roughcontact._parts.grid import Load
from roughcontact._parts.materials import pair_constants
from roughcontact._solve.problem import (
    AdhesionCycle,
    Increment,
    describe_estimate,
    explain_with_friction,
    find_path_inputs,
    require_frictional,
    run_slide,
)
from roughcontact._solve.problem import Path as StatePath
from roughcontact._work.studies import Answers, add_answers, write_report

# States on each branch.
_STATES = 41
# Options of a solve that say nothing of a cycle.
_OUTSIDE_CYCLES = ("refine", "area", "area_within", "peak_within")
# Options of a solve that say nothing of a contact with friction.
_WITHOUT_FRICTION = ("cycle", "refine", "area", "area_within", "peak_within")


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
    refuse(options, _OUTSIDE_CYCLES, "is for single loads: omit it with --cycle, which has many states.")
    if options.states is not None and options.states < 2:
        raise rc.InputError.about("The number of --states", options.states, "at least 2")
    low, high = options.cycle
    if not low < high:
        raise rc.InputError(f"--cycle needs its lower approach first, but got {si(low, 'm')} and {si(high, 'm')}.")


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
    refuse(options, _WITHOUT_FRICTION, f"is for loads without friction: omit it with {given}.")
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
