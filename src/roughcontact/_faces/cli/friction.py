"""``roughcontact solve --friction``: a contact with friction along a path of tangential loads, or in steady sliding."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import attrs

import roughcontact as rc
from roughcontact._base import checks
from roughcontact._base.machine.progress import ChangeProgress
from roughcontact._base.tables import Table
from roughcontact._base.units import fit, parse_quantity
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
from roughcontact._faces.cli.options import name_options
from roughcontact._faces.cli.problem import make_part, set_tolerance
from roughcontact._faces.cli.progress import count_solves, describe_steps, show_progress
from roughcontact._faces.cli.responses import ask_all_states
from roughcontact._faces.panels.figures import save_figure
from roughcontact._parts.grid import Load
from roughcontact._parts.materials import pair_constants
from roughcontact._solve.problem import (
    Increment,
    describe_estimate,
    explain_with_friction,
    find_path_inputs,
    require_frictional,
    run_slide,
)
from roughcontact._work.studies import Answers, add_answers, write_report

# Options of a solve that say nothing of a contact with friction.
_OF_SOLVES = ("cycle", "refine", "area", "area_within", "peak_within")
# What a script does where the bodies slide, and what the command line does.
_SLIDING = (
    "Give displacement= instead, or call problem.slide(...).",
    "Give displacements to --tangential instead, or --slide.",
)


@attrs.frozen
class Asked:
    """Responses that were asked for, their answers for each state, and why some have none."""

    responses: Mapping[str, rc.Response[Any]] = attrs.Factory(dict)
    answers: Answers = attrs.Factory(dict)
    reasons: Mapping[str, str] = attrs.Factory(dict)

    def add_inputs(self, inputs: dict[str, Any] | None) -> dict[str, Any] | None:
        """Return the inputs with the responses."""
        return None if inputs is None else inputs | describe_responses(self.responses)

    def describe_reasons(self) -> dict[str, Any]:
        """Return why answers are missing as data that JSON can hold; empty if none is."""
        return {"without_answer": dict(self.reasons)} if self.reasons else {}


_NOTHING = Asked()


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


def plan_friction_outputs(options: argparse.Namespace, maps: list[Path]) -> list[Path]:
    """Return the files of a path or a state: itself, .npz, or its picture."""
    files = []
    for text in options.output:
        path = checks.path(text, "The output")
        path = path if path.suffix == ".npz" else plan_picture(text, (".npz",))
        require_place(path, [path], maps)
        files.append(path)
    return files + plan_report(options.report, maps)


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
        path = _solve_path(options, problem, law, loads)
        found = _write_outputs(options, path, path.plot, files, asked, (path_to_text, path_to_json, path_to_csv))
        return bool(path.warnings or found.reasons) or is_doubtful(found.answers, path.states)
    with show_progress("pressing", quiet=options.quiet) as change:
        state = _slide(options, problem, law, loads[0], change)
    found = _write_outputs(options, state, state.plot, files, asked, (_state_to_text, _state_to_json, _state_to_csv))
    return bool(state.warnings or found.reasons) or is_doubtful(found.answers, [state])


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
) -> rc.ContactSolution:
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
    asked: Mapping[str, rc.Response[Any]],
    writers: tuple[Callable[[Any, Asked], str], ...],
) -> Asked:
    """Return what was asked of a path or a state, after printing both as text, JSON or CSV and writing their files."""
    reports = [file for file in files if file.suffix == ".html"]
    for file in files:
        if file.suffix == ".npz":
            subject.save(file)
        elif file not in reports:
            save_figure(plot(), file)
    found = Asked(asked)
    try:
        if asked and not (options.quiet and not reports):
            states = [subject] if isinstance(subject, rc.ContactSolution) else subject.states
            with show_progress("answering", quiet=options.quiet) as change:
                found = Asked(asked, *ask_all_states(asked, states, change))
    finally:
        for file in reports:
            write_report(subject, file, found.answers)
    if options.quiet:
        return found
    to_text, to_json, to_csv = writers
    write = to_json if options.json else to_csv if options.csv else to_text
    print(write(subject, found))
    if files and write is to_text:
        print(name_written(files))
    return found


def _state_to_text(state: rc.ContactSolution, asked: Asked) -> str:
    return to_text([state], None, asked.answers)


def _state_to_json(state: rc.ContactSolution, asked: Asked) -> str:
    return to_json([state], None, asked.answers, describe_responses(asked.responses))


def _state_to_csv(state: rc.ContactSolution, asked: Asked) -> str:
    return to_csv([state], None, asked.answers)


def lost_in_loop(path: rc.FrictionalPath) -> rc.Estimate | None:
    """Return the energy lost since the loads last were those at the end of the path, J; None if they never were."""
    states = [*([] if path.pressed is None else [path.pressed]), *path.states]
    numbers = path.numbers[len(path.numbers) - len(states) + 1 :]
    loads = [(_normal_load(state), state.tangential_load.values) for state in states]
    for back in range(2, len(states)):
        if loads[-1 - back] == loads[-1]:
            parts = [one.dissipated for one in numbers[-back:]]
            texts = dict.fromkeys(text for part in parts for text in part.warnings)
            value, uncertainty = (math.fsum(getattr(part, name) for part in parts) for name in ("value", "uncertainty"))
            return rc.Estimate(value, uncertainty, "J", tuple(texts))
    return None


def _normal_load(state: rc.ContactSolution) -> Any:
    return None if state.origin is None else state.origin.load


def path_to_text(path: rc.FrictionalPath, asked: Asked = _NOTHING) -> str:
    """Return a path for people: its states, the energy lost and its warnings, in lines of at most 80 columns."""
    lines = [path.table().to_text(), f"energy lost  {_without_warnings(path.dissipated)}"]
    lost = lost_in_loop(path)
    if lost is not None:
        lines.append(f"in the last loop  {_without_warnings(lost)}")
    statuses = dict.fromkeys(str(state.status) for state in path)
    lines += [f"status       {'; '.join(statuses)}"]
    lines += [f"warning      {name_options(text, ('substeps',))}" for text in path.warnings]
    if asked.answers:
        table = path.table()
        along = [name for name in ("tangential_x", "tangential_y") if any(map(_is_pushed, table.columns[name]))]
        numbers = range(1, len(path) + 1)
        heads = Table({"state": numbers, **{name: table.columns[name] for name in along}}, table.units)
        names = [f"state {number}" for number in numbers]
        lines += ["", *write_rows_of_answers(heads, names, asked.answers, asked.reasons)]
    return fit("\n".join(lines))


def _is_pushed(force: float | rc.Estimate) -> bool:
    return (force.value if isinstance(force, rc.Estimate) else force) != 0.0


def _without_warnings(found: rc.Estimate) -> rc.Estimate:
    return attrs.evolve(found, warnings=())


def path_to_csv(path: rc.FrictionalPath, asked: Asked = _NOTHING) -> str:
    """Return a header and a row for each state, in SI units: the columns of `FrictionalPath.table`, and answers."""
    return write_csv(add_answers(path.table(), asked.answers))


def path_to_json(path: rc.FrictionalPath, asked: Asked = _NOTHING) -> str:
    """Return one JSON object: the energy lost along a path and in its last loop, and its states."""
    table = add_answers(path.table(), asked.answers)
    states = describe_rows(table)
    for row, state in zip(states, path, strict=True):
        row |= {"status": state.status.name, "residual": state.certificate.error}
    lost = lost_in_loop(path)
    content = {
        "dissipated": describe_estimate(path.dissipated),
        "loop": None if lost is None else describe_estimate(lost),
        "states": states,
        "pair": attrs.asdict(path[0].sheared.pair),
        "warnings": list(path.warnings),
        **asked.describe_reasons(),
        "inputs": asked.add_inputs(find_path_inputs(path)),
        "units": dict(table.units),
    }
    return write_json(content)
