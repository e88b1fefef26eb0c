"""Loading and unloading of surfaces that attract each other, with jumps and pull-off, and how near a state is to one.

`ContactProblem.cycle` calls `list_approaches` and `run_cycle`; answers call `find_stability` and `linearise`; a page
calls `describe_cycle`. Methods that begin with an underscore are hooks of `Path`: they write and read files.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from itertools import pairwise
from typing import Any

import attrs
import numpy as np

from roughcontact._base.arrays import Array, Mask
from roughcontact._base.checks import callback
from roughcontact._base.machine.progress import ChangeProgress, count_done, tell_both
from roughcontact._base.tables import Table
from roughcontact._base.units import Estimate, Length, si, write_column
from roughcontact._parts.grid import Load
from roughcontact._solve.problem.loads import Solve, cells_of, follow_loads, open_gap, plan_of, require_resolved
from roughcontact._solve.problem.path import Path
from roughcontact._solve.problem.plan import SolvePlan
from roughcontact._solve.problem.pull_off import find_lowest
from roughcontact._solve.problem.scene import Scene
from roughcontact._solve.problem.sweep import Sweep, report_states
from roughcontact._solve.problem.task import bind_interaction, limit_load
from roughcontact._solve.solution import (
    ContactSolution,
    Status,
    trapping_error,
)
from roughcontact._solve.solvers import LinearisedGap, surface_stiffness
from roughcontact.errors import InputError

# Energy lost in a step, over the work done in it and over that of the lowest force, above which it is a jump: the
# sum of both. The trapezoidal rule errs by a twelfth of the work where a force falls by a factor of e in a step.
_JUMP_OF_WORK = 0.1
_JUMP_OF_LOWEST = 0.05
# Columns of the table of a sweep that that of a cycle has too.
_COLUMNS = ("mean_pressure", "force", "approach", "area", "area_uncertainty", "area_fraction")


@attrs.frozen(eq=False)
class AdhesionCycle(Path):
    """Loading and unloading of surfaces that attract each other.

    Attributes
    ----------
    loading, unloading
        The states in the order in which they were passed; the first of unloading is the last of loading.

    Examples
    --------
    >>> import numpy as np
    >>> import roughcontact as rc
    >>> ball = rc.Body(rc.ParaboloidSurface(radius=1e-6), rc.Elastic(young=10e6, poisson=0.5))
    >>> law = rc.Exponential(work="50mJ/m2", range="60nm")
    >>> problem = rc.ContactProblem(ball, grid=rc.Grid((48, 48), 2e-6), adhesion=law)
    >>> cycle = problem.cycle(approach=np.linspace(-0.3e-6, 0.1e-6, 5))
    >>> len(cycle.loading), len(cycle.unloading)
    (5, 5)
    """

    # Files state it, and its last word is the method of a problem: a saved cycle is read by it.
    kind = "adhesion cycle"
    view = "cycle"
    curve = "force of both branches over the approach"

    loading: Sweep
    unloading: Sweep

    @property
    def states(self) -> tuple[ContactSolution, ...]:
        """Those of loading, then those of unloading."""
        return (*self.loading, *self.unloading)

    @property
    def given(self) -> Sequence[ContactSolution]:
        """The states of loading: those of unloading have the same approaches."""
        return self.loading.states

    def list_rest(self) -> Mapping[str, Any]:
        """Return the approaches, m, between which the contact jumps."""
        return {"jumps": [list(jump) for jump in self.jumps]}

    def label_states(self) -> tuple[Table, list[str]]:
        """Return branch and approach of each state, and its name in a sentence."""
        columns = self.short_table().columns
        heads = Table({name: columns[name] for name in ("branch", "approach")}, {"approach": "m"}, ("branch",))
        pairs = zip(columns["approach"], columns["branch"], strict=True)
        return heads, [f"at {si(float(approach), 'm', 3)}, {branch}" for approach, branch in pairs]

    @property
    def _saved_states(self) -> tuple[ContactSolution, ...]:
        return (*self.loading, *self.unloading[1:])

    def _note_rest(self) -> dict[str, Any]:
        return {"loading": len(self.loading)}

    @classmethod
    def _restore(cls, states: tuple[ContactSolution, ...], notes: Mapping[str, Any]) -> AdhesionCycle:
        last = int(notes["loading"])
        if not 0 < last < len(states):
            raise InputError("The file is damaged: a branch of its cycle has no state.")
        return cls(Sweep(states[:last]), Sweep(states[last - 1 :]))

    def list_numbers(self) -> Mapping[str, Estimate | None]:
        """Return pull-in, pull-off and the energy lost."""
        return {"pull_in": self.pull_in, "pull_off": self.pull_off, "dissipated": self.dissipated}

    @cached_property
    def energies(self) -> tuple[Array, Array]:
        """Elastic energy and energy of the attraction together, J, of the states of loading and of unloading."""
        return _find_energies(self.loading), _find_energies(self.unloading)

    @property
    def losses(self) -> tuple[Array, Array]:
        """Energy lost in each step, J, of loading and of unloading: the work done minus the energy gained."""
        loading, unloading = self.energies
        return _find_losses(self.loading, loading), _find_losses(self.unloading, unloading)

    @property
    def dissipated(self) -> Estimate:
        """Energy lost in the cycle, J: the area of the loop of force and approach."""
        lost = math.fsum(float(np.sum(part)) for part in self.losses)
        branches = (self.loading, self.unloading)
        # The smooth parts err as the trapezoidal rule, shown by every second state; a jump by where it is in its step.
        smooth = sum(map(_find_rule_error, branches))
        steps = zip(branches, self.jump_steps, strict=True)
        jumps = math.hypot(*(_find_jump_error(branch, is_jump) for branch, is_jump in steps))
        sticking = trapping_error(cells_of(self.loading[0])) * abs(lost)
        return Estimate(lost, math.hypot(smooth, jumps) + sticking, "J", self.warnings)

    @cached_property
    def pull_in(self) -> Estimate:
        """Minimum of the force on loading, N: that at which the surfaces snap together."""
        return find_lowest(self.loading, self.warnings)

    @cached_property
    def pull_off(self) -> Estimate:
        """Minimum of the force on unloading, N: that at which they come apart; solved more finely than the states."""
        return find_lowest(self.unloading, self.warnings)

    @property
    def jumps(self) -> tuple[tuple[float, float], ...]:
        """Approaches, m, between which the contact jumps: much of the work of such a step is lost."""
        found = []
        for sweep, is_jump in zip((self.loading, self.unloading), self.jump_steps, strict=True):
            found += [(float(sweep.approach[k]), float(sweep.approach[k + 1])) for k in np.flatnonzero(is_jump)]
        return tuple(found)

    @property
    def jump_steps(self) -> tuple[Mask, Mask]:
        """Whether each step of loading and of unloading is a jump."""
        lowest = abs(min(float(sweep.force.min()) for sweep in (self.loading, self.unloading)))
        losses = self.losses
        found = []
        for sweep, lost, back in zip((self.loading, self.unloading), losses, losses[::-1], strict=True):
            steps = np.abs(np.diff(sweep.approach))
            work = np.abs(0.5 * (sweep.force[1:] + sweep.force[:-1])) * steps
            allowed = _JUMP_OF_WORK * work + _JUMP_OF_LOWEST * lowest * steps
            # What the trapezoidal rule errs by on one branch it gives back on the other.
            found.append(np.asarray((lost > allowed) & (lost + back[::-1] > 0.5 * lost)))
        return found[0], found[1]

    def table(self) -> Table:
        """Return a row for each state, those of loading first; see `roughcontact.typing.Table`.

        Its columns are ``branch``, ``mean_pressure``, ``force``, ``approach``, ``area``, ``area_uncertainty`` and
        ``area_fraction``, and of the step that leads to a state ``lost``, its energy lost, J, and ``jump``, whether it
        is one.
        """
        branches = {"loading": self.loading, "unloading": self.unloading}
        tables = [sweep.table() for sweep in branches.values()]
        columns: dict[str, Any] = {"branch": [name for name, sweep in branches.items() for _ in sweep]}
        for name in _COLUMNS:
            columns[name] = np.concatenate([table.columns[name] for table in tables])
        columns["lost"] = np.concatenate([np.append(0.0, lost) for lost in self.losses])
        columns["jump"] = [bool(jump) for jumps in self.jump_steps for jump in (False, *jumps)]
        return Table(columns, {**{name: tables[0].units[name] for name in _COLUMNS}, "lost": "J"}, left=("branch",))

    def short_table(self) -> Table:
        """Return a row for each state for people, with the area in percent of nominal."""
        columns: dict[str, Any] = {"branch": [], "approach": [], "force": [], "area, %": [], "": []}
        for name, jumps in zip(("loading", "unloading"), self.jump_steps, strict=True):
            sweep: Sweep = getattr(self, name)
            columns["branch"] += [name] * len(sweep)
            # Approaches such as those of numpy.linspace may miss zero by a rounding.
            near = np.abs(sweep.approach) < 1e-9 * np.abs(sweep.approach).max()
            columns["approach"] += np.where(near, 0.0, sweep.approach).tolist()
            columns["force"] += sweep.force.tolist()
            columns["area, %"] += (100.0 * sweep.area / sweep[0].grid.area).tolist()
            columns[""] += ["", *("jump" if jump else "" for jump in jumps)]
        return Table(columns, {"approach": "m", "force": "N"}, left=("branch", ""))

    def _list_results(self) -> Mapping[str, str]:
        return describe_cycle(self)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Why all numbers of the cycle must not be trusted, in sentences; empty without a reason."""
        return tuple(text for text in self.loading[0].warnings if getattr(text, "rule", "") == "cohesive length")

    def __repr__(self) -> str:
        pull_off = describe_cycle(self)["pull-off"]
        return f"<AdhesionCycle {len(self.loading)} and {len(self.unloading)} states, pull-off {pull_off}>"


def describe_cycle(cycle: AdhesionCycle) -> dict[str, str]:
    """Return pull-in, pull-off, the energy lost and the jumps as texts, without the warnings that they share."""
    found = {"pull-in": cycle.pull_in, "pull-off": cycle.pull_off, "dissipated": cycle.dissipated}
    texts = {}
    for name, one in found.items():
        reasons = "; ".join(text for text in one.warnings if text not in cycle.warnings)
        texts[name] = f"{write_column([one])[0]}{f' ({reasons})' if reasons else ''}".replace("±", "+-")
    return texts | {"jumps": "; ".join(f"{si(a, 'm', 3)} to {si(b, 'm', 3)}" for a, b in cycle.jumps) or "none"}


def find_stability(problem: Scene, solution: ContactSolution) -> float:
    """Return how far a state with adhesion is from a jump: 1 far away, 0 at one, negative where it is unstable."""
    held = "" if solution.origin is None else next(iter(solution.origin.load))
    return linearise(problem, solution, holds_approach=held == "approach").find_margin()


def linearise(problem: Scene, solution: ContactSolution, *, holds_approach: bool) -> LinearisedGap:
    """Return the linear problem of small changes of a solution with adhesion, at a given approach or load.

    Its pressures are in E* over the cell, times the unit of the heights.
    """
    plan = problem.plan
    if plan.interaction is None or solution.tension is None:
        raise InputError("Without adhesion each state is stable: there is no jump.")
    if solution.status is Status.SEPARATED:
        raise InputError("The surfaces have come apart: there is no contact that could change a little.")
    return LinearisedGap(
        surface_stiffness(problem.convolution),
        bind_interaction(plan, plan.interaction),
        open_gap(solution) / plan.peak_to_valley,
        solution.saturated,
        holds_approach=holds_approach,
    )


def list_approaches(plan: SolvePlan, initial_gap: Array, approach: Iterable[Length]) -> tuple[Load, ...]:
    """Return the loads of a branch of a cycle; `InputError` if it cannot be followed."""
    require_resolved(plan)
    loads = Load.signed_sequence(approach=approach)
    values = [load.value for load in loads]
    if len(values) < 2 or any(after <= before for before, after in pairwise(values)):
        raise InputError("The approaches of a cycle must ascend, two of them or more: unloading passes them backwards.")
    for load in loads:
        limit_load(plan, initial_gap, load)
    return loads


def run_cycle(
    solve: Solve,
    loads: tuple[Load, ...],
    on_state: object,
    change: ChangeProgress,
) -> AdhesionCycle:
    """Return both branches over ascending approaches; a callback gets each state."""
    told = callback(on_state, "on_state=", "solution")
    count = count_done(change, 2 * len(loads) - 1, "state")
    solve_and_report: Solve = report_states(solve, tell_both(told, count))
    loading = follow_loads(solve_and_report, loads)
    return AdhesionCycle(loading, follow_loads(solve_and_report, loads[::-1], loading[-1]))


def _find_energies(sweep: Sweep) -> Array:
    found = []
    law = plan_of(sweep[0]).interaction
    for state in sweep:
        elastic = 0.5 * float(np.sum(state.pressure * state.displacement))
        attraction = float(np.sum(law.energy(open_gap(state))))
        found.append((elastic + attraction) * state.grid.cell_area)
    return np.array(found)


def _find_losses(sweep: Sweep, energies: Array) -> Array:
    work = 0.5 * (sweep.force[1:] + sweep.force[:-1]) * np.diff(sweep.approach)
    return np.asarray(work - np.diff(energies))


def _second_differences(sweep: Sweep) -> Array:
    """Return the error of the trapezoidal rule in each step, J."""
    force = sweep.force
    if len(force) < 3:
        return np.full(len(force) - 1, math.inf)
    bends = np.abs(np.diff(force, 2))
    around = np.maximum(np.append(bends, bends[-1]), np.insert(bends, 0, bends[0]))
    return np.asarray(around / 12.0 * np.abs(np.diff(sweep.approach)))


def _find_rule_error(sweep: Sweep) -> float:
    """Return the error of the energy lost on a branch by the trapezoidal rule, J, without that of jumps."""
    # A jump bends the force as well, but the energies on both of its sides are known: the median step counts.
    return float(np.median(_second_differences(sweep))) * math.sqrt(len(sweep))


def _find_jump_error(sweep: Sweep, is_jump: Mask) -> float:
    """Return the standard deviation of the energy lost on a branch because a jump may be anywhere in its step, J."""
    steps = np.abs(np.diff(sweep.approach) * np.diff(sweep.force))[is_jump]
    return float(np.linalg.norm(steps)) / math.sqrt(12.0)
