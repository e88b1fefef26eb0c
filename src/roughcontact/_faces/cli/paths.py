"""Paths on the command line: cycles of adhesion, loads along the surface, wear; printed, and written to files."""

from __future__ import annotations

import abc
import argparse
import math
from collections.abc import Iterable, Mapping, Sequence
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
    plan_path_picture,
    plan_picture,
    plan_report,
    require_place,
    save_path_picture,
    to_csv,
    to_json,
    to_text,
    write_csv,
    write_json,
    write_rows_of_answers,
)
from roughcontact._faces.cli.options import refuse
from roughcontact._faces.cli.problem import make_part
from roughcontact._faces.cli.progress import count_solves, describe_steps, show_progress
from roughcontact._faces.cli.responses import ask_all_states
from roughcontact._faces.panels.figures import save_figure
from roughcontact._parts.grid import Load
from roughcontact._parts.materials import pair_constants
from roughcontact._solve.problem import (
    PATH_ACCURACY,
    AdhesionCycle,
    Increment,
    LoadPath,
    describe_estimate,
    explain_loads,
    explain_with_friction,
    find_path_inputs,
    list_cycles,
    list_loads,
    prepare_path,
    remember_changes,
    require_frictional,
    resolve_sliding,
    run_load_path,
    run_slide,
)
from roughcontact._solve.problem import Path as StatePath
from roughcontact._solve.solution import require_to_hold
from roughcontact._work.studies import Answers, add_answers, write_report

# States on each branch.
_STATES = 41
# Options of a solve that say nothing of a cycle.
_OUTSIDE_CYCLES = ("refine", "area", "area_within", "peak_within", "uncertainty")
# Options of a path without friction, and those of a solve that say nothing of it.
_OF_PATHS = ("path", "time", "sliding", "shift")
_OUTSIDE_PATHS = ("cycle", "solve_for", *_OUTSIDE_CYCLES)
# Options whose increments have an accuracy.
_WITH_ACCURACY = ("time", "sliding", "cycles")
# Options of a solve that say nothing of a contact with friction, or of one that slides at a speed.
_WITHOUT_FRICTION = ("cycle", *_OF_PATHS, *_OUTSIDE_CYCLES)
_WITHOUT_SPEED = ("friction", "cycle", *_OF_PATHS)


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
    is_path = options.slide is None or options.tangential is not None
    plan = plan_path_picture if is_path else plan_picture
    for text in options.output:
        path = checks.path(text, "The output")
        path = path if path.suffix == ".npz" else plan(text, (".npz",))
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
        elif file in reports:
            continue
        elif isinstance(subject, StatePath):
            save_path_picture(subject, file)
        else:
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


class Course(abc.ABC):
    """A path of states, or a state of sliding, that the options of a solve describe; what does not fit is refused."""

    def check(self, asked: Iterable[rc.Response[Any]]) -> None:
        """Take any responses that are asked for, unless a subclass refuses some."""
        return

    def explain(self, problem: rc.ContactProblem, loads: Sequence[Load]) -> str:
        """Return the plan, in words."""
        return explain_loads(problem, loads)

    @abc.abstractmethod
    def require(self, problem: rc.ContactProblem, loads: Sequence[Load]) -> tuple[Load, ...]:
        """Return the normal loads; `InputError` if the bodies cannot carry them."""

    @abc.abstractmethod
    def solve(self, problem: rc.ContactProblem, loads: Sequence[Load]) -> StatePath | rc.ContactSolution:
        """Return what is found, and show on the way what runs."""

    def list_doubted(self, found: Any) -> tuple[tuple[rc.ContactSolution, ...], list[rc.Estimate]]:
        """Return the states and numbers whose own warnings count beside those of the whole."""
        return (), []


def find_course(options: argparse.Namespace) -> Course | None:
    """Return what the options describe, before anything is read; None of single loads."""
    if options.substeps is not None and options.tangential is None:
        raise rc.InputError("--substeps is for loads along the surface: give --tangential too, or omit it.")
    if options.cycles is not None and options.tangential is None:
        raise rc.InputError("--cycles is for loads along the surface that return: give --tangential too, or omit it.")
    if options.speed is not None and options.slide is None:
        raise rc.InputError("--speed is for steady sliding: give --slide too, or omit it.")
    if options.friction is not None and options.tangential is None and options.slide is None:
        raise rc.InputError("--friction is for loads along the surface: give --tangential or --slide too.")
    if options.states is not None and options.cycle is None:
        raise rc.InputError("--states is for --cycle, whose branches have them: give both, or neither.")
    if options.accuracy is not None and all(getattr(options, name) is None for name in _WITH_ACCURACY):
        raise rc.InputError(
            "--accuracy is for increments of --time, --sliding or --cycles: give one of them, or omit it."
        )
    if options.speed is not None:
        _refuse_beside_speed(options)
    elif options.tangential is not None or (options.slide is not None and options.sliding is None):
        return LoadsAlong(options)
    if any(getattr(options, name) for name in _OF_PATHS):
        return ChangingSurfaces(options)
    return None if options.cycle is None else Cycle(options)


def _refuse_beside_speed(options: argparse.Namespace) -> None:
    """Refuse what does not fit bodies that slide at a speed, a law of single loads."""
    refuse(options, _WITHOUT_SPEED, "is not for bodies that slide at a speed: omit it with --speed.")
    if options.viscoelastic is None and options.counterbody_viscoelastic is None:
        raise rc.InputError(
            "--speed is for viscoelastic bodies: give --viscoelastic moduli=1MPa,3MPa times=10ms poisson=0.5, for "
            "example, or --friction instead."
        )


class Cycle(Course):
    """Loading and unloading of surfaces that attract each other: ``--cycle``."""

    def __init__(self, options: argparse.Namespace):
        if options.adhesion is None:
            raise rc.InputError("--cycle is for surfaces that attract each other: give --adhesion too.")
        refuse(options, _OUTSIDE_CYCLES, "is for single loads: omit it with --cycle, which has many states.")
        if options.states is not None and options.states < 2:
            raise rc.InputError.about("The number of --states", options.states, "at least 2")
        low, high = options.cycle
        if not low < high:
            raise rc.InputError(f"--cycle needs its lower approach first, but got {si(low, 'm')} and {si(high, 'm')}.")
        self._approach = np.linspace(low, high, _STATES if options.states is None else options.states)
        self._quiet = options.quiet

    def require(self, problem: rc.ContactProblem, loads: Sequence[Load]) -> tuple[Load, ...]:
        """Return the first and the last approach."""
        for load in loads:
            problem.require_load(**load.arguments)
        return problem.require_cycle(approach=[load.value for load in loads])

    def solve(self, problem: rc.ContactProblem, loads: Sequence[Load]) -> AdhesionCycle:
        """Return both branches."""
        with show_progress("solving", quiet=self._quiet) as change:
            tell = count_done(change, 2 * len(self._approach) - 1, "state")
            return problem.cycle(approach=self._approach, on_state=tell)

    def list_doubted(self, found: Any) -> tuple[tuple[rc.ContactSolution, ...], list[rc.Estimate]]:
        """Return all states and all numbers."""
        return found.states, [found.pull_in, found.pull_off, found.dissipated]


class ChangingSurfaces(Course):
    """Loads and what passes, along which the surfaces change: ``--path``, ``--time``, ``--sliding``, ``--shift``."""

    def __init__(self, options: argparse.Namespace):
        given = next(f"--{name}" for name in _OF_PATHS if getattr(options, name))
        refuse(options, _OUTSIDE_PATHS, f"is not for a path: omit it with {given}, which has many states.")
        if options.sliding is not None and options.law is None:
            raise rc.InputError(
                "--sliding needs a law by which surfaces wear: give --law archard coefficient=1e-16m2/N, for example."
            )
        if given == "--path" and options.loads is None:
            raise rc.InputError("--path is for several loads: give them to --loads, in their order, or omit it.")
        self._passed = {name: getattr(options, name) for name in ("time", "sliding", "shift")}
        self._accuracy = PATH_ACCURACY if options.accuracy is None else options.accuracy
        self._friction = None
        if options.slide is not None:
            self._friction = resolve_sliding(_require_law(options, "--slide"), math.degrees(options.slide))
        self._outputs = options.output
        self._quiet = options.quiet

    def check(self, asked: Iterable[rc.Response[Any]]) -> None:
        """Refuse a response that means nothing for bodies that slide with friction."""
        if self._friction is not None:
            _require_shear(asked)

    def explain(self, problem: rc.ContactProblem, loads: Sequence[Load]) -> str:
        """Return the plan of a state, or of all with friction, in words, with the laws that remember."""
        scene = remember_changes(problem)
        if self._friction is None:
            return explain_loads(scene, loads)
        return explain_with_friction(scene.plan, self._friction.law, len(self._passed["sliding"]))

    def require(self, problem: rc.ContactProblem, loads: Sequence[Load]) -> tuple[Load, ...]:
        """Return the normal loads, which after the first may be zero."""
        slides = self._friction is not None
        prepare_path(problem, _list_normal(loads), **self._passed, accuracy=self._accuracy, slides=slides)
        return tuple(loads)

    def solve(self, problem: rc.ContactProblem, loads: Sequence[Load]) -> LoadPath:
        """Return the path."""
        normal = _list_normal(loads)
        # What a killed command has left goes on; anything else is replaced at the end.
        file = next((path for path in map(Path, self._outputs) if path.suffix == ".npz"), None)
        with show_progress("solving", quiet=self._quiet) as change:
            return run_load_path(
                problem,
                normal,
                omitted={},
                passed=self._passed,
                accuracy=self._accuracy,
                on_increment=None,
                change=change,
                file=file,
                friction=self._friction,
                is_draft=True,
            )


def _require_law(options: argparse.Namespace, given: str) -> rc.FrictionLaw:
    """Return the friction law; `InputError` if there is none for what is given."""
    if options.friction is None:
        rubber = "" if options.slide is None else ", or --speed of viscoelastic bodies"
        raise rc.InputError(
            f"{given} needs a law by which the surfaces slip: give --friction 0.3, for example{rubber}."
        )
    return _read_law(options)


def _require_shear(asked: Iterable[rc.Response[Any]]) -> None:
    for response in asked:
        require_to_hold(response, {"shear"})


def _list_normal(loads: Sequence[Load]) -> dict[str, Any]:
    """Return the argument of `ContactProblem.path` that states these loads: one, or a list."""
    values = [load.value for load in loads]
    return {loads[0].kind: values if len(values) > 1 else values[0]}


class LoadsAlong(Course):
    """A contact with friction, loaded along the surface or in steady sliding: ``--tangential``, ``--slide``."""

    def __init__(self, options: argparse.Namespace):
        given = "--tangential" if options.slide is None else "--slide"
        self._law = _require_law(options, given)
        refuse(options, _WITHOUT_FRICTION, f"is for loads without friction: omit it with {given}.")
        if options.cycles is None:
            refuse(options, ("accuracy",), f"is for --cycles: omit it with {given} alone.")
        if options.slide is not None and options.loads is not None:
            raise rc.InputError("--slide is for one load: give that instead of --loads.")
        if len({kind for kind, _ in options.tangential or ()}) > 1:
            raise rc.InputError("--tangential needs loads of one kind, but got forces and displacements.")
        if options.cycles is not None and options.law is None:
            raise rc.InputError(
                "--cycles needs a law by which slip wears: give --law energy-wear coefficient=1e-14m3/J, for example."
            )
        self._options = options

    def check(self, asked: Iterable[rc.Response[Any]]) -> None:
        """Refuse a response that means nothing for a state with a tangential traction."""
        _require_shear(asked)

    def explain(self, problem: rc.ContactProblem, loads: Sequence[Load]) -> str:
        """Return the plan of a path or of steady sliding, in words."""
        require_frictional(problem)
        # A path begins with the state under the normal load alone.
        states = 1 + len(self._options.tangential or ()) * len(self._options.cycles or (1,))
        return explain_with_friction(problem.plan, self._law, states)

    def require(self, problem: rc.ContactProblem, loads: Sequence[Load]) -> tuple[Load, ...]:
        """Return the normal loads, of which the last of several may be zero."""
        if self._options.cycles is not None:
            list_cycles(self._options.cycles)
        if self._options.loads is None:
            return tuple(problem.require_load(**load.arguments) for load in loads)
        return list_loads(problem, {loads[0].kind: [load.value for load in loads]})

    def solve(self, problem: rc.ContactProblem, loads: Sequence[Load]) -> StatePath | rc.ContactSolution:
        """Return the path of the loads along the surface, or the state of sliding."""
        with show_progress("pressing", quiet=self._options.quiet) as change:
            solve = self._slide if self._options.tangential is None else self._follow
            return solve(problem, loads, change)

    def _follow(
        self, problem: rc.ContactProblem, loads: Sequence[Load], change: ChangeProgress
    ) -> StatePath | rc.ContactSolution:
        values: Any = loads[0].value if self._options.loads is None else [load.value for load in loads]
        kind = self._options.tangential[0][0]
        given: dict[str, Any] = {loads[0].kind: values, kind: [pair for _, pair in self._options.tangential]}
        substeps = "auto" if self._options.substeps is None else self._options.substeps
        cycles = {name: value for name in ("cycles", "accuracy") if (value := getattr(self._options, name)) is not None}

        def tell(done: Increment) -> None:
            # The pressing is not counted: it may be a solve that has been asked for, or many increments; nor are
            # cycles, of which nobody knows how many are computed.
            is_counted = done.step and not cycles
            change(str(done), (done.step - 1 + done.increment / done.increments) / done.steps if is_counted else None)

        return problem.path(**given, friction=self._law, substeps=substeps, on_increment=tell, **cycles)

    def _slide(
        self, problem: rc.ContactProblem, loads: Sequence[Load], change: ChangeProgress
    ) -> StatePath | rc.ContactSolution:
        work = (problem.plan.grid.shape, problem.plan.solver.tolerance)
        # Of unlike bodies pressure and traction are found in turn, which takes about as long as pressing.
        unlike = pair_constants(problem.body.material, problem.counterbody.material).beta != 0.0
        press = describe_steps(change, "pressing", count_solves(*work, (0, 2 if unlike else 1)))
        slide = describe_steps(change, "sliding", count_solves(*work, (1, 2)))
        return run_slide(problem, loads[0].arguments, self._law, math.degrees(self._options.slide), press, slide)


def _read_law(options: argparse.Namespace) -> rc.FrictionLaw:
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
