"""Loads in their order, each state from the one before: of surfaces that attract each other, or laws that remember."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any, Protocol

import numpy as np

from roughcontact._base.arrays import Array
from roughcontact._base.machine.progress import ChangeProgress, count_done
from roughcontact._base.units import WorkText
from roughcontact._parts.grid import Load
from roughcontact._solve.problem.path import march
from roughcontact._solve.problem.plan import SolvePlan
from roughcontact._solve.problem.run import run_solve
from roughcontact._solve.problem.scene import Scene
from roughcontact._solve.problem.sweep import Sweep, order_of_solving, predict_pressure, report_states, run_sweep
from roughcontact._solve.solution import TRAPPED_CELLS, ContactSolution, describe_range, load_of, remembers_flattening
from roughcontact.errors import InputError, argument
from roughcontact.errors.door import guarded


class Solve(Protocol):
    """A solve at a load, from a pressure and a gap, after a state that laws remember."""

    def __call__(
        self,
        load: Load,
        start: Array | None = None,
        *,
        start_gap: Array | None = None,
        before: ContactSolution | None = None,
    ) -> ContactSolution:
        """Return the certified solution."""


def require_resolved(plan: SolvePlan) -> None:
    """Raise `InputError` unless there is adhesion and the cells resolve it well enough to follow a path."""
    if plan.interaction is None:
        raise InputError(
            f"Without {argument('adhesion')} nothing is pulled apart: give the problem a law, such as Exponential."
        )
    cells = plan.interaction.cohesive_cells(plan.grid.resolved.spacing, plan.surface_modulus)
    if cells < TRAPPED_CELLS:
        reason = describe_range(plan.interaction, plan.grid, plan.surface_modulus)
        raise InputError(f"A path cannot be followed: {reason}.")


def solve_loads(problem: Scene, loads: tuple[Load, ...], change: ChangeProgress) -> Sweep:
    """Return the solutions at all loads; see `sweep_loads`."""
    solve = report_states(partial(run_solve, problem), count_done(change, len(loads), "load"))
    return sweep_loads(problem, solve, loads)


def sweep_loads(problem: Scene, solve: Solve, loads: tuple[Load, ...]) -> Sweep:
    """Return the solutions of a problem at all loads, in their order where a state depends on those before."""
    return follow_loads(solve, loads) if problem.remembers else run_sweep(solve, loads)


@guarded
def explain_loads(problem: Scene, loads: Sequence[Load]) -> WorkText:
    """Return the plan of a problem at the largest of some loads, in words; see `ContactProblem.explain`.

    Parameters
    ----------
    problem
        A `ContactProblem`.
    loads
        Its loads, all of a kind; none: the plan of an unknown load.

    Examples
    --------
    >>> import roughcontact as rc
    >>> from roughcontact.faces import explain_loads
    >>> ball = rc.Body(rc.SphereSurface(1e-3), rc.Elastic(210e9, 0.3))
    >>> problem = rc.ContactProblem(ball, grid=rc.Grid((32, 32), 100e-6))
    >>> explain_loads(problem, [problem.require_load(force=1.0)]) == problem.explain(force=1.0)
    True
    """
    largest = max(loads, key=lambda load: load.value, default=None)
    return problem.explain() if largest is None else problem.explain(**largest.arguments)


def order_loads(problem: Scene, loads: Sequence[Load]) -> Sequence[int]:
    """Return the positions of loads in the order in which they are solved: theirs, where a state depends on others."""
    return range(len(loads)) if problem.remembers else order_of_solving(loads)


def solve_next(problem: Any, before: Sequence[ContactSolution], load: Load) -> ContactSolution:
    """Return the solution of a `ContactProblem` at a load, from the solutions before in this order."""
    if problem.remembers:
        return follow(partial(run_solve, problem), before, load)
    found: ContactSolution = problem.solve(**load.arguments, start=predict_pressure(before, load))
    return found


def follow_loads(solve: Solve, loads: Sequence[Load], first: ContactSolution | None = None) -> Sweep:
    """Return the solutions in the order of the loads, each from the ones before."""
    return Sweep(tuple(march(loads if first is None else loads[1:], partial(follow, solve), first)))


def follow(solve: Solve, before: Sequence[ContactSolution], load: Load) -> ContactSolution:
    """Return the solution at a load that continues those before."""
    if not before:
        return solve(load)
    last = before[-1]
    if last.tension is None:
        return solve(load, predict_pressure(before, load), before=last)
    require_memory_of_flow(last, load)
    return solve(load, last.pressure, start_gap=open_gap(last), before=last)


def require_memory_of_flow(last: ContactSolution, load: Load) -> None:
    """Refuse a lower load after the pressure has reached its limit: the flattened summits would be forgotten."""
    if load.value < load_of(last, load.kind).value and last.saturated.any() and not remembers_flattening(last):
        raise InputError(
            f"The load falls to {load} after the pressure has reached its limit on {last.saturated.sum()} cells: each "
            "state is a first loading, which forgets how far the summits were flattened, and with them the pull-off. "
            "Follow them by cycle or path, which remember it, or give the problem laws=rc.Flattening()."
        )


def open_gap(state: ContactSolution) -> Array:
    """Return the gap, shape (nx, ny), m: exactly zero where the surfaces touch."""
    return np.where(state.contact, 0.0, np.maximum(state.gap, 0.0))


def plan_of(state: ContactSolution) -> Any:
    """Return the plan of a state's problem."""
    assert state.origin is not None
    return state.origin.scene.plan


def cells_of(state: ContactSolution) -> float:
    plan = plan_of(state)
    cells: float = plan.interaction.cohesive_cells(plan.grid.resolved.spacing, plan.surface_modulus)
    return cells
