"""``roughcontact solve``: the contact of measured height maps at one load or several."""

from __future__ import annotations

import argparse
import functools
import sys
from typing import Any

import attrs

import roughcontact as rc
from roughcontact._base import checks
from roughcontact._base.arrays import Array
from roughcontact._base.machine.progress import ChangeProgress
from roughcontact._base.units import fit
from roughcontact._faces.cli import DOUBTFUL, Command
from roughcontact._faces.cli.answers import (
    LATE,
    describe_responses,
    describe_wanted,
    is_doubtful,
    name_written,
    plan_outputs,
    to_csv,
    to_json,
    to_text,
    write_late,
    write_outputs,
)
from roughcontact._faces.cli.help import add_group, leave_to, tell
from roughcontact._faces.cli.options import add_accuracy, add_problem, add_shape, refuse, whole_number
from roughcontact._faces.cli.paths import find_course, plan_path_outputs, write_path
from roughcontact._faces.cli.problem import loads_of, problem_of, set_tolerance
from roughcontact._faces.cli.progress import (
    count_grids,
    count_solves,
    describe_steps,
    show_progress,
)
from roughcontact._faces.cli.required_load import ANSWER, refuse_for_wanted, solve_wanted, wanted_of
from roughcontact._faces.cli.responses import add_responses, ask, refuse_pull_off, responses_of
from roughcontact._parts.grid import Load
from roughcontact._parts.surfaces import find_maps
from roughcontact._solve.problem import explain_loads, run_solve, sweep_loads, tolerance_within
from roughcontact._solve.solution import UNCERTAINTIES


class Solve(Command):
    """Solve the contact of measured height maps."""

    epilog = """
examples:
  roughcontact solve map.npz --pressure 10MPa --young 210GPa
  roughcontact solve ball.npz ring.npz --force 5N --young 210GPa \\
      --hardness 6GPa --counterbody-young 210GPa --detrend plane \\
      -o contact.npz -o contact.png
  roughcontact solve map.npz --loads 1N 2N 5N --young 210GPa --csv > loads.csv
  roughcontact solve ball.npz --loads 10N 20N 0N 20N --path --young 210GPa \\
      --hardness 2GPa -o path.npz -o path.gif
  roughcontact solve map.npz --solve-for area=10% --young 210GPa
  roughcontact solve map.npz --force 1N --young 210GPa --stiffness \\
      --conductance 45 --stress --first-yield 1GPa
  roughcontact solve map.npz --cycle -0.1um 0.5um --young 2MPa \\
      --poisson 0.5 --adhesion short-range work=50mJ/m2 -o cycle.png
  roughcontact solve map.npz --force 1N --young 210GPa \\
      --counterbody-young 210GPa --friction 0.3 \\
      --tangential 0.2N -0.2N 0.2N -o loop.npz -o loop.png
  roughcontact solve map.npz --force 1N --young 210GPa \\
      --law archard coefficient=1e-16m2/N --sliding 0m 1m 10m -o worn.npz
"""

    def declare(self, parser: argparse.ArgumentParser) -> None:
        add_problem(parser)
        add_responses(parser)
        add_accuracy(parser)
        accuracy = add_group(parser, "grids", "method")
        accuracy.add_argument(
            "--refine",
            type=whole_number,
            nargs="?",
            const=3,
            metavar="N",
            help="solve on N grids, each twice as fine as the last (3); the finest gives the answer",
        )
        accuracy.add_argument(
            "--uncertainty",
            choices=list(UNCERTAINTIES),
            help="what the uncertainties are found from (auto: a model of the errors, or two coarser grids at sharp "
            "edges and rough heights)",
        )
        output = parser.add_argument_group("output")
        other = output.add_argument("--area", metavar="NAME", help="area estimator to report besides the default")
        add_shape(output)
        output.add_argument("--explain", action="store_true", help="print the plan first: cells, memory, threads, ...")
        dry = output.add_argument("--dry-run", action="store_true", help="print the plan, and solve nothing")
        leave_to("output", other, dry)
        output.add_argument(
            "-o",
            "--output",
            action="append",
            default=[],
            metavar="FILE",
            help="file to write, of the kind that its ending says: .npz, .nc, .json, .html, .png, ...; or a folder for "
            "solution.npz and solution.png; may be repeated",
        )
        output.add_argument("--report", metavar="FILE", help="report to write, one page of HTML")

    def run(self, options: argparse.Namespace) -> int:
        """Return 0, or 3 if a solution has warnings, or raise `NotConverged` after writing the last iterate."""
        if options.area is not None:
            rc.areas.resolve(options.area)
        piped = options.json or options.csv
        if options.dry_run and piped:
            raise rc.InputError("--dry-run prints the plan, which is text: omit --json or --csv.")
        _refuse_for_several(options)
        course = find_course(options)
        refuse_for_wanted(options)
        wanted = None if options.solve_for is None else wanted_of(options.solve_for)
        asked = responses_of(options)
        refuse_pull_off(options, asked)
        if course is not None:
            course.check(asked.values())
        maps = [name for name in (options.surface, options.counterbody) if name is not None]
        paths = [checks.path(name, "The map") for name in maps]
        if course is None:
            files = plan_outputs(options.output, options.report, paths, max(1, len(loads_of(options))))
        else:
            files = plan_path_outputs(options, paths)
        with show_progress("reading the maps", quiet=options.quiet) as change:
            problem = problem_of(options)
        loads = loads_of(options)
        if course is not None:
            loads = course.require(problem, loads)
        else:
            loads = tuple(problem.require_load(**load.arguments) for load in loads)
        if options.explain or options.dry_run:
            plan = fit(explain_loads(problem, loads) if course is None else course.explain(problem, loads))
            print(plan, end="\n" if options.dry_run else "\n\n", file=sys.stderr if piped else None)
        if options.dry_run:
            return 0
        if course is not None:
            path = course.solve(set_tolerance(options, problem), loads)
            doubtful = write_path(options, path, asked, files)
            states, numbers = course.list_doubted(path)
            return _status(states, doubtful or any(one.warnings for one in numbers), quiet=options.quiet)
        with show_progress("solving", quiet=options.quiet) as change:
            if wanted is None:
                subject, solutions = _judge_by(options.uncertainty, *_solve(options, problem, loads, change))
                found: dict[str, Any] = {}
                inputs = describe_responses(asked)
            else:
                required = solve_wanted(set_tolerance(options, problem), wanted, change)
                subject = required.solution
                solutions = (subject,)
                found = {ANSWER: [required]}
                inputs = {**describe_responses(asked), **describe_wanted(wanted[0], required)}
        # Solutions and pictures before the responses, of which one may have no answer.
        late = [path for path in files if path.suffix in LATE]
        written = write_outputs([path for path in files if path not in late], subject, solutions)
        if options.quiet and not late:
            return _status(solutions, quiet=True)
        answers = found
        try:
            with show_progress("answering", quiet=options.quiet or not asked) as change:
                answers = {**found, **ask(asked, solutions, change)}
        finally:
            write_late(late, solutions, options.area, answers, inputs)
        doubtful = is_doubtful(answers, solutions, options.area)
        if options.quiet:
            return _status(solutions, doubtful, quiet=True)
        done = name_written([*written, *late])
        if options.json:
            print(to_json(solutions, options.area, answers, inputs))
        else:
            print((to_csv if options.csv else to_text)(solutions, options.area, answers))
        if done and not piped:
            print(done)
        return _status(solutions, doubtful, quiet=options.quiet)


def _refuse_for_several(options: argparse.Namespace) -> None:
    """Refuse options that are for one grid, for one load or for surfaces that attract each other."""
    several = "--refine" if options.refine is not None else "--loads" if options.loads is not None else ""
    if several:
        reason = f"chooses the grid of one solve: omit it, or {several}, which has several."
        refuse(options, ("area_within", "peak_within"), reason)
    if options.refine is not None and options.loads is not None:
        raise rc.InputError("--refine is for one load: omit it, or give one load instead of --loads.")
    if len({load.kind for load in options.loads or ()}) > 1:
        kinds = " and ".join(sorted({load.kind for load in options.loads}))
        raise rc.InputError(f"The loads of --loads must be of one kind, but they are of {kinds}.")


def _solve(
    options: argparse.Namespace, problem: rc.ContactProblem, loads: tuple[Load, ...], change: ChangeProgress
) -> tuple[Any, tuple[rc.ContactSolution, ...]]:
    """Return the solution or sweep to be drawn, and the solutions at all loads."""
    if options.refine is None and options.loads is None:
        asked = {name: getattr(options, name) for name in ("area_within", "peak_within", "tolerance")}
        tolerance = options.tolerance or tolerance_within(problem, options.area_within, options.peak_within)
        count: Any = count_solves
        if options.area_within is not None or options.peak_within is not None:
            # Nobody knows on which grid an accuracy is reached; measured maps have one.
            count = functools.partial(count_grids, doublings=None, refined=not _is_measured(problem))
        steps = describe_steps(change, "solving", count(problem.plan.grid.shape, tolerance))
        solution = problem.solve(**loads[0].arguments, **asked, throw=False, on_step=steps)
        return solution, (solution,)
    problem = set_tolerance(options, problem)
    if options.refine is not None:
        _refuse_measured(problem)
        fraction = count_grids(problem.plan.grid.shape, problem.plan.solver.tolerance, options.refine - 1)
        steps = describe_steps(change, "solving", fraction)
        ladder = rc.extrapolate(problem, **loads[0].arguments, levels=options.refine, on_step=steps)
        if not options.quiet:
            print(f"{ladder}\n", file=sys.stderr if options.json or options.csv else None)
        return ladder.states[-1], ladder.states[-1:]

    plan = problem.plan
    done = 0

    def solve(load: Load, start: Array | None = None, **others: Any) -> rc.ContactSolution:
        nonlocal done
        what = f"load {done + 1} of {len(loads)}, {load}"
        fraction = count_solves(plan.grid.shape, plan.solver.tolerance, (done, len(loads)))
        steps = describe_steps(change, what, fraction)
        done += 1
        return run_solve(problem, load, start, throw=False, on_step=steps, **others)

    sweep = sweep_loads(problem, solve, loads)
    return sweep, sweep.states


def _judge_by(
    uncertainty: str | None, subject: Any, solutions: tuple[rc.ContactSolution, ...]
) -> tuple[Any, tuple[rc.ContactSolution, ...]]:
    """Return what is drawn, and its solutions, whose answers have uncertainties found from this."""
    if uncertainty is None:
        return subject, solutions
    judged = tuple(attrs.evolve(one, uncertainty=uncertainty) for one in solutions)
    return (judged[0] if subject is solutions[0] else attrs.evolve(subject, states=judged)), judged


def _is_measured(problem: rc.ContactProblem) -> bool:
    """Return whether the problem has a map that is not known between its points."""
    sides = problem.body.surface, problem.counterbody.surface
    return any(not found.periodic for surface in sides for found in find_maps(surface))


def _refuse_measured(problem: rc.ContactProblem) -> None:
    if _is_measured(problem):
        raise rc.InputError(
            "--refine solves on finer grids, which add no heights to a map that is not periodic. Its "
            "area is stated with an uncertainty without it; 'roughcontact report' compares coarser grids."
        )


def _status(solutions: tuple[rc.ContactSolution, ...], doubtful: bool = False, *, quiet: bool) -> int:
    """Return the exit status, where other answers too may be doubtful; one that is not certified is raised."""
    for solution in solutions:
        if not solution.status.success:
            raise rc.NotConverged(f"The contact is {solution.status}; what is shown is the last iterate.", solution)
        if solution.accuracy is not None and not solution.accuracy.met:
            raise rc.NotConverged(solution.accuracy.explain(), solution)
    doubtful = doubtful or any(solution.warnings for solution in solutions)
    if doubtful and not quiet:
        tell("roughcontact: The solution is converged, but doubtful: see its warnings.")
    return DOUBTFUL if doubtful else 0
