"""``roughcontact solve --friction``: a contact with friction along a path of tangential loads, or in steady sliding."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import attrs

import roughcontact as rc
from roughcontact._base import checks
from roughcontact._base.tables import Table
from roughcontact._base.units import fit, parse_quantity
from roughcontact._faces.cli.answers import (
    describe_estimate,
    describe_rows,
    describe_solution,
    name_written,
    plan_picture,
    plan_report,
    require_place,
    write_csv,
    write_json,
)
from roughcontact._faces.cli.inputs import find_path_inputs, find_state_inputs
from roughcontact._faces.cli.options import name_options
from roughcontact._faces.cli.problem import make_part, set_tolerance
from roughcontact._faces.cli.progress import ChangeProgress, count_solves, describe_steps, show_progress
from roughcontact._faces.panels.figures import save_figure
from roughcontact._parts.grid import Load
from roughcontact._parts.materials import pair_constants
from roughcontact._solve.problem import Increment, run_slide

# Options of a solve that say nothing of a contact with friction.
_OF_SOLVES = ("cycle", "refine", "area", "area_within", "peak_within", "pull_off")
# What a script does where the bodies slide, and what the command line does.
_SLIDING = (
    "Give displacement= instead, or call problem.slide(...).",
    "Give displacements to --tangential instead, or --slide.",
)


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
        if options.report is not None:
            raise rc.InputError(
                "--report with friction is of a path: give --tangential instead of --slide, or omit it."
            )
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


def plan_friction_outputs(options: argparse.Namespace, maps: list[Path]) -> list[Path]:
    """Return the files of a path or a state: itself, .npz, or its picture."""
    files = []
    for text in options.output:
        path = checks.path(text, "The output")
        path = path if path.suffix == ".npz" else plan_picture(text, (".npz",))
        require_place(path, [path], maps)
        files.append(path)
    return files + plan_report(options.report, maps)


def solve_friction(
    options: argparse.Namespace,
    problem: rc.ContactProblem,
    law: rc.FrictionLaw,
    loads: tuple[Load, ...],
    files: list[Path],
) -> bool:
    """Solve a contact with friction, print it and write its files; return whether it has warnings."""
    problem = set_tolerance(options, problem)
    if options.slide is None:
        path = _solve_path(options, problem, law, loads)
        _write_outputs(options, path, path.plot, files, (path_to_text, path_to_json, path_to_csv))
        return bool(path.warnings)
    with show_progress("pressing", quiet=options.quiet) as change:
        state = _slide(options, problem, law, loads[0], change)
    _write_outputs(options, state, state.contact.plot, files, (state_to_text, state_to_json, state_to_csv))
    return bool(state.contact.warnings)


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

        try:
            return problem.path(**{loads[0].kind: values}, **along, friction=law, substeps=substeps, on_increment=tell)
        except rc.InputError as error:
            raise rc.InputError(str(error).replace(*_SLIDING)) from error


def _slide(
    options: argparse.Namespace, problem: rc.ContactProblem, law: rc.FrictionLaw, load: Load, change: ChangeProgress
) -> rc.FrictionalSolution:
    shape = problem.plan.grid.shape
    tolerance = problem.plan.solver.tolerance
    # Of unlike bodies pressure and traction are found in turn, which takes about as long as pressing.
    unlike = pair_constants(problem.body.material, problem.counterbody.material).beta != 0.0
    press = describe_steps(change, "pressing", count_solves(shape, tolerance, (0, 2 if unlike else 1)))
    slide = describe_steps(change, "sliding", count_solves(shape, tolerance, (1, 2)))
    return run_slide(problem, load.arguments, law, math.degrees(options.slide), press, slide)


def _write_outputs(
    options: argparse.Namespace,
    subject: Any,
    plot: Callable[[], Any],
    files: list[Path],
    writers: tuple[Callable[[Any], str], ...],
) -> None:
    """Print a path or a state by the writer of text, JSON or CSV, and write its files."""
    for file in files:
        if file.suffix == ".npz":
            subject.save(file)
        elif file.suffix == ".html":
            subject.to_html(file)
        else:
            save_figure(plot(), file)
    if options.quiet:
        return
    to_text, to_json, to_csv = writers
    write = to_json if options.json else to_csv if options.csv else to_text
    print(write(subject))
    if files and write is to_text:
        print(name_written(files))


def state_to_text(state: rc.FrictionalSolution) -> str:
    """Return a state of a path, or of steady sliding, for people, with its warnings, in lines of at most 80 columns."""
    warnings = (f"{'warning':18} {text}" for text in state.contact.warnings)
    return fit("\n".join([str(state), *warnings]))


def state_to_json(state: rc.FrictionalSolution) -> str:
    """Return one JSON object: the normal contact, the tangential force and the energy lost."""
    content = describe_solution(state.contact) | {
        "tangential_force": {"value": list(state.tangential_force), "unit": "N"},
        "dissipated": describe_estimate(state.dissipated),
        "residual": state.residuals.error,
        "pair": attrs.asdict(state.pair),
        "inputs": find_state_inputs(state),
    }
    return write_json(content)


def state_to_csv(state: rc.FrictionalSolution) -> str:
    """Return a header and a row, in SI units."""
    contact = state.contact
    along = zip("xy", state.tangential_force, strict=True)
    row = {
        "force": state.force,
        **{f"tangential_{axis}": force for axis, force in along},
        "dissipated": state.dissipated,
        "area": contact.area(),
        "peak_pressure": contact.peak_pressure(),
        "approach": state.approach,
    }
    units = {"force": "N", "tangential_x": "N", "tangential_y": "N", "approach": "m"}
    return write_csv(Table({name: [value] for name, value in row.items()}, units))


def lost_in_loop(path: rc.FrictionalPath) -> rc.Estimate | None:
    """Return the energy lost since the loads last were those at the end of the path, J; None if they never were."""
    states = [*([] if path.pressed is None else [path.pressed]), *path.states]
    numbers = path.numbers[len(path.numbers) - len(states) + 1 :]
    loads = [(_normal_load(state), state.given.values) for state in states]
    for back in range(2, len(states)):
        if loads[-1 - back] == loads[-1]:
            parts = [one.dissipated for one in numbers[-back:]]
            texts = dict.fromkeys(text for part in parts for text in part.warnings)
            value, uncertainty = (math.fsum(getattr(part, name) for part in parts) for name in ("value", "uncertainty"))
            return rc.Estimate(value, uncertainty, "J", tuple(texts))
    return None


def _normal_load(state: rc.FrictionalSolution) -> Any:
    return None if state.contact.origin is None else state.contact.origin.load


def path_to_text(path: rc.FrictionalPath) -> str:
    """Return a path for people: its states, the energy lost and its warnings, in lines of at most 80 columns."""
    lines = [path.table().to_text(), f"energy lost  {_without_warnings(path.dissipated)}"]
    lost = lost_in_loop(path)
    if lost is not None:
        lines.append(f"in the last loop  {_without_warnings(lost)}")
    statuses = dict.fromkeys(str(state.status) for state in path)
    lines += [f"status       {'; '.join(statuses)}"]
    lines += [f"warning      {name_options(text, ('substeps',))}" for text in path.warnings]
    return fit("\n".join(lines))


def _without_warnings(found: rc.Estimate) -> rc.Estimate:
    return attrs.evolve(found, warnings=())


def path_to_csv(path: rc.FrictionalPath) -> str:
    """Return a header and a row for each state, in SI units: the columns of `FrictionalPath.table`."""
    return write_csv(path.table())


def path_to_json(path: rc.FrictionalPath) -> str:
    """Return one JSON object: the energy lost along a path and in its last loop, and its states."""
    table = path.table()
    states = describe_rows(table)
    for row, state in zip(states, path, strict=True):
        row |= {"status": state.status.name, "residual": state.residuals.error}
    lost = lost_in_loop(path)
    content = {
        "dissipated": describe_estimate(path.dissipated),
        "loop": None if lost is None else describe_estimate(lost),
        "states": states,
        "pair": attrs.asdict(path[0].pair),
        "warnings": list(path.warnings),
        "inputs": find_path_inputs(path),
        "units": dict(table.units),
    }
    return write_json(content)
