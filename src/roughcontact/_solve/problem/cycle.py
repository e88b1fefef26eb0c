"""Paths of surfaces that attract each other: loads in their order, loading and unloading, jumps and pull-off."""

from __future__ import annotations

import math
import os
import textwrap
from collections.abc import Callable, Iterable, Sequence
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias, overload

import attrs
import numpy as np

from roughcontact._base.arrays import Array, Mask
from roughcontact._base.tables import Table
from roughcontact._base.units import WIDTH, Estimate, Length, si, write_column
from roughcontact._parts.grid import Load
from roughcontact._parts.interactions import Exponential, ShortRange
from roughcontact._solve.problem.plan import SolvePlan
from roughcontact._solve.problem.sweep import Sweep, make_table
from roughcontact._solve.problem.task import bind_interaction, limit_load
from roughcontact._solve.solution import (
    TRAPPED_CELLS,
    ContactSolution,
    Status,
    count_patch_cells,
    describe_range,
    page_or_file,
    trapping_error,
    writers,
)
from roughcontact._solve.solvers import LinearisedGap, surface_stiffness
from roughcontact.errors import InputError

if TYPE_CHECKING:
    from roughcontact._solve.problem.problem import ContactProblem

# Steps of the approach on the way to pull-off, and by how much of the lowest force the force must have risen behind it.
_MAX_STEPS = 200
# Sticking to the cells raises it by a few per cent where a row of cells comes apart.
_RISEN = 0.2
# Rounds that halve the steps around the lowest force.
_REFINEMENTS = 4
_STATES_OF_REFINEMENT = 4
# Relative standard deviation of the lowest force, set on 400 balls and 100 rough surfaces in random places
# (benchmarks/adhesion_classes.py): because the edge of the contact sticks to the cells, by exp(-cells) of the cohesive
# length over the root of the cells of a patch; because a patch has few cells, and its maximum; and by the path.
_STICKING = 0.7
_COARSE = 1.8
_COARSEST = 0.14
_PATH = 2e-4
# Ratio of two ranges from which pull-off is extrapolated to none, and the power of the range by which it goes there:
# 1.5 for short ranges, less for those that cells resolve. On balls of 8 to 40 cells in the contact radius of Johnson,
# 1.2 errs by a fifth of the change.
_LONGER = math.sqrt(2.0)
_POWER = 1.2
_EXTRAPOLATION_ERROR = 0.25
# Differences of the initial gap along an axis, over those of all cells, up to which the surface is straight.
_STRAIGHT = 1e-6
# Energy lost in a step, over the work done in it and over that of the lowest force, above which it is a jump: the
# sum of both. The trapezoidal rule errs by a twelfth of the work where a force falls by a factor of e in a step.
_JUMP_OF_WORK = 0.1
_JUMP_OF_LOWEST = 0.05
# Columns of the table of a sweep that that of a cycle has too.
_COLUMNS = ("mean_pressure", "force", "approach", "area", "area_uncertainty", "area_fraction")


class Solve(Protocol):
    """A solve at a load, from a pressure and a gap."""

    def __call__(self, load: Load, start: Array | None = None, *, start_gap: Array | None = None) -> ContactSolution:
        """Return the certified solution."""


@attrs.frozen(eq=False)
class AdhesionCycle:
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

    loading: Sweep
    unloading: Sweep

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
        # Where nothing jumps the trapezoidal rule errs by a twelfth of the second differences of the force.
        error = sum(_find_rule_error(part) for part in (self.loading, self.unloading))
        return Estimate(lost, error + trapping_error(_cells_of(self.loading[0])) * abs(lost), "J", self.warnings)

    @property
    def pull_in(self) -> Estimate:
        """Minimum of the force on loading, N: that at which the surfaces snap together."""
        return _find_minimum(self.loading, self.warnings)

    @property
    def pull_off(self) -> Estimate:
        """Minimum of the force on unloading, N: that at which they come apart."""
        return _find_minimum(self.unloading, self.warnings)

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
        """Return a row for each state, with the columns of `to_pandas`; see `roughcontact.typing.Table`."""
        branches = {"loading": self.loading, "unloading": self.unloading}
        tables = [make_table(sweep) for sweep in branches.values()]
        columns: dict[str, Any] = {"branch": [name for name, sweep in branches.items() for _ in sweep]}
        for name in _COLUMNS:
            columns[name] = np.concatenate([table.columns[name] for table in tables])
        columns["lost"] = np.concatenate([np.append(0.0, lost) for lost in self.losses])
        columns["jump"] = [bool(jump) for jumps in self.jump_steps for jump in (False, *jumps)]
        return Table(columns, {**{name: tables[0].units[name] for name in _COLUMNS}, "lost": "J"}, left=("branch",))

    def to_pandas(self) -> Any:
        """Return the states as a `pandas.DataFrame`, those of loading first (extra ``table``).

        Its columns are ``branch``, ``mean_pressure``, ``force``, ``approach``, ``area``, ``area_uncertainty`` and
        ``area_fraction``, in the units of ``frame.attrs["units"]``, and of the step that leads to a state ``lost``, its
        energy lost, J, and ``jump``, whether it is one.
        """
        return self.table().to_pandas()

    def to_csv(self, path: str | os.PathLike[str]) -> None:
        """Write the columns of `to_pandas` to a CSV file in SI units, with all digits; an existing file is replaced."""
        self.table().to_csv(path)

    @overload
    def to_html(self, path: None = None) -> str: ...

    @overload
    def to_html(self, path: str | os.PathLike[str]) -> None: ...

    def to_html(self, path: str | os.PathLike[str] | None = None) -> str | None:
        """Return a report of the cycle, its largest load in detail, or write it; see `ContactSolution.to_html`."""
        writer: Any = writers.create("html")
        return page_or_file(lambda: writer.cycle_text(self), path)

    def plot(self, *, axes: Any = None, dark: bool = False) -> Any:
        """Draw the force of both branches over the approach (extra ``plot``); see `ContactSolution.plot`."""
        from roughcontact.plotting import draw_cycle

        return draw_cycle(self, axes, dark)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Why all numbers of the cycle must not be trusted, in sentences; empty without a reason."""
        return tuple(text for text in self.loading[0].warnings if getattr(text, "rule", "") == "cohesive length")

    def __str__(self) -> str:
        rows = [*describe_cycle(self).items(), *(("warning", text) for text in self.warnings)]
        lines = [textwrap.wrap(f"{name:<12}{text}", WIDTH, subsequent_indent=" " * 12) for name, text in rows]
        return "\n".join([list_states(self).to_text(), *(line for wrapped in lines for line in wrapped)])

    def __repr__(self) -> str:
        pull_off = describe_cycle(self)["pull-off"]
        return f"<AdhesionCycle {len(self.loading)} and {len(self.unloading)} states, pull-off {pull_off}>"

    def _repr_html_(self) -> str:
        results = [f"{name}: {text}" for name, text in describe_cycle(self).items()]
        return list_states(self).to_html(*results, *self.warnings)


def describe_cycle(cycle: AdhesionCycle) -> dict[str, str]:
    """Return pull-in, pull-off, the energy lost and the jumps as texts, without the warnings that they share."""
    found = {"pull-in": cycle.pull_in, "pull-off": cycle.pull_off, "dissipated": cycle.dissipated}
    texts = {}
    for name, one in found.items():
        reasons = "; ".join(text for text in one.warnings if text not in cycle.warnings)
        texts[name] = f"{write_column([one])[0]}{f' ({reasons})' if reasons else ''}".replace("±", "+-")
    return texts | {"jumps": "; ".join(f"{si(a, 'm', 3)} to {si(b, 'm', 3)}" for a, b in cycle.jumps) or "none"}


def list_states(cycle: AdhesionCycle) -> Table:
    """Return the states of a cycle in short, a row for each."""
    columns: dict[str, Any] = {"branch": [], "approach": [], "force": [], "area, %": [], "": []}
    for name, jumps in zip(("loading", "unloading"), cycle.jump_steps, strict=True):
        sweep: Sweep = getattr(cycle, name)
        columns["branch"] += [name] * len(sweep)
        # Approaches such as those of numpy.linspace may miss zero by a rounding.
        near = np.abs(sweep.approach) < 1e-9 * np.abs(sweep.approach).max()
        columns["approach"] += np.where(near, 0.0, sweep.approach).tolist()
        columns["force"] += sweep.force.tolist()
        columns["area, %"] += (100.0 * sweep.area / sweep[0].grid.area).tolist()
        columns[""] += ["", *("jump" if jump else "" for jump in jumps)]
    return Table(columns, {"approach": "m", "force": "N"}, left=("branch", ""))


def _require_resolved(plan: SolvePlan) -> None:
    """Raise `InputError` unless there is adhesion and the cells resolve it well enough to follow a path."""
    if plan.interaction is None:
        raise InputError("Without adhesion= nothing is pulled apart: give the problem a law, such as Exponential.")
    cells = plan.interaction.cohesive_cells(plan.grid.spacing, plan.modulus)
    if cells < TRAPPED_CELLS:
        raise InputError(f"A path cannot be followed: {describe_range(plan.interaction, plan.grid, plan.modulus)}.")


def follow_loads(solve: Solve, loads: Sequence[Load], first: ContactSolution | None = None) -> Sweep:
    """Return the solutions in the order of the loads, each from the ones before."""
    solutions: list[ContactSolution] = [] if first is None else [first]
    for load in loads if first is None else loads[1:]:
        solutions.append(_follow(solve, solutions, load))
    return Sweep(tuple(solutions))


def _follow(solve: Solve, before: Sequence[ContactSolution], load: Load) -> ContactSolution:
    """Return the solution at a load that continues those before."""
    if not before:
        return solve(load)
    last = before[-1]
    return solve(load, last.pressure, start_gap=_open_gap(last))


def _open_gap(state: ContactSolution) -> Array:
    """Return the gap, shape (nx, ny), m: exactly zero where the surfaces touch."""
    return np.where(state.contact, 0.0, np.maximum(state.gap, 0.0))


def find_stability(problem: ContactProblem, solution: ContactSolution) -> float:
    """Return how far a state with adhesion is from a jump: 1 far away, 0 at one, negative where it is unstable."""
    held = "" if solution.origin is None else next(iter(solution.origin.load))
    return linearise(problem, solution, holds_approach=held == "approach").find_margin()


def linearise(problem: ContactProblem, solution: ContactSolution, *, holds_approach: bool) -> LinearisedGap:
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
        _open_gap(solution) / plan.peak_to_valley,
        solution.saturated,
        holds_approach=holds_approach,
    )


def list_approaches(plan: SolvePlan, initial_gap: Array, approach: Iterable[Length]) -> tuple[Load, ...]:
    """Return the loads of a branch of a cycle; `InputError` if it cannot be followed."""
    _require_resolved(plan)
    loads = Load.signed_sequence(approach=approach)
    values = [load.value for load in loads]
    if len(values) < 2 or any(after <= before for before, after in pairwise(values)):
        raise InputError("The approaches of a cycle must ascend, two of them or more: unloading passes them backwards.")
    for load in loads:
        limit_load(plan, initial_gap, load)
    return loads


def run_cycle(
    solve: Solve, loads: tuple[Load, ...], on_state: Callable[[ContactSolution], object] | None = None
) -> AdhesionCycle:
    """Return both branches over ascending approaches; a callback gets each state."""

    def solve_and_report(load: Load, start: Array | None = None, *, start_gap: Array | None = None) -> ContactSolution:
        state = solve(load, start, start_gap=start_gap)
        if on_state is not None:
            on_state(state)
        return state

    loading = follow_loads(solve_and_report, loads)
    return AdhesionCycle(loading, follow_loads(solve_and_report, loads[::-1], loading[-1]))


# Called with each state on the way to pull-off, and how many are to come; None while nobody knows.
OnStateToPullOff: TypeAlias = Callable[[ContactSolution, int | None], object]


def find_pull_off(problem: ContactProblem, on_state: OnStateToPullOff | None = None) -> Estimate:
    """Return the minimum of the force on unloading from zero load; see `ContactProblem.pull_off`."""
    _require_resolved(problem.plan)
    tell: OnStateToPullOff = on_state or (lambda state, left: None)
    is_limit = isinstance(problem.adhesion, ShortRange)
    first = _ToldStates(problem._solve, tell, paths=2 if is_limit else 1)
    found = _follow_to_pull_off(first, problem.plan)
    if not is_limit:
        return found
    law = problem.plan.interaction
    assert isinstance(law, Exponential)
    longer = attrs.evolve(problem, adhesion=Exponential(law.work, _LONGER * law.range))
    # By a longer range the way is about as long.
    second = _ToldStates(longer._solve, tell, left=first.count)
    return _extrapolate_range(found, _follow_to_pull_off(second, longer.plan), problem.initial_gap)


class _ToldStates:
    """A solve that tells each state, and how many are to come on this path and on others like it."""

    def __init__(self, solve: Solve, tell: OnStateToPullOff, paths: int = 1, left: int | None = None) -> None:
        self.solve = solve
        self.tell = tell
        self.paths = paths
        self.left = left
        self.count = 0

    def __call__(self, load: Load, start: Array | None = None, *, start_gap: Array | None = None) -> ContactSolution:
        state = self.solve(load, start, start_gap=start_gap)
        self.count += 1
        if self.left is not None:
            self.left = max(self.left - 1, 0)
        self.tell(state, self.left)
        return state

    def expect(self, left: int) -> None:
        """Take it that so many states are to come on this path."""
        self.left = left + (self.paths - 1) * (self.count + left)


def _follow_to_pull_off(solve: _ToldStates, plan: SolvePlan) -> Estimate:
    states = [solve(Load("pressure", 0.0))]
    step = _first_step(plan, states[0])
    for _ in range(_MAX_STEPS):
        states.append(_follow(solve, states, Load("approach", states[-1].approach - step)))
        force = np.array([state.force for state in states])
        lowest = int(force.argmin())
        has_risen = force[-1] - force[lowest] > -_RISEN * force[lowest]
        if force[lowest] < 0.0 and (has_risen or not states[-1].contact.any()):
            break
        if force[-2] - force[-1] < 0.1 * abs(force.min()):
            step *= 1.5
    path = states
    solve.expect(_REFINEMENTS * _STATES_OF_REFINEMENT)
    for _ in range(_REFINEMENTS):
        path = _refine(solve, path)
    sweep = Sweep(tuple(path))
    warning = None if plan.interaction is None else describe_range(plan.interaction, plan.grid, plan.modulus)
    return _find_minimum(sweep, () if warning is None else (warning,))


def _extrapolate_range(shorter: Estimate, longer: Estimate, initial_gap: Array) -> Estimate:
    """Return the force of pull-off without a range, N, from those by a range and by a longer one.

    Straight edges along the cells stick to them as a whole, which no longer range shows: there the change is the
    uncertainty.
    """
    change = (shorter.value - longer.value) / (_LONGER**_POWER - 1.0)
    if min(float(np.ptp(initial_gap, axis=axis).max()) for axis in (0, 1)) <= _STRAIGHT * float(np.ptp(initial_gap)):
        return attrs.evolve(shorter, uncertainty=math.hypot(shorter.uncertainty, change))
    error = math.hypot(shorter.uncertainty, longer.uncertainty, _EXTRAPOLATION_ERROR * change)
    return attrs.evolve(shorter, value=shorter.value + change, uncertainty=error)


def _first_step(plan: SolvePlan, state: ContactSolution) -> float:
    """Return a step of the approach: a tenth of the displacement, or of the reach of the law if that is longer."""
    moved = float(state.displacement.max() - state.displacement.min())
    law = plan.interaction
    range_of_law = 0.0 if law is None else float(np.max(np.asarray(law.work) / np.asarray(law.strength)))
    return 0.1 * max(moved, range_of_law)


def _refine(solve: Solve, path: Sequence[ContactSolution]) -> list[ContactSolution]:
    """Return the three states around the lowest force with two more between them, on the way down."""
    force = [state.force for state in path]
    lowest = min(max(int(np.argmin(force)), 1), len(path) - 2)
    found = [path[lowest - 1]]
    for state in path[lowest : lowest + 2]:
        middle = 0.5 * (found[-1].approach + state.approach)
        found.append(_follow(solve, found, Load("approach", middle)))
        found.append(_follow(solve, found, Load("approach", state.approach)))
    return found


def _find_minimum(sweep: Sweep, warnings: tuple[str, ...]) -> Estimate:
    """Return the lowest force of a path by the parabola through three states, N."""
    force = sweep.force
    k = int(force.argmin())
    trapped = _find_grid_error(sweep[k]) * abs(float(force[k]))
    if not 0 < k < len(force) - 1:
        text = "the lowest force is at the end of the path: continue it"
        return Estimate(float(force[k]), float(np.ptp(force)), "N", (*warnings, text))
    places = sweep.approach[k - 1 : k + 2]
    values = force[k - 1 : k + 2]
    curvature, slope, _ = np.polyfit(places - places[1], values - values[1], 2)
    below = slope**2 / (4.0 * curvature) if curvature > 0.0 else 0.0
    jumps = abs(float(values[0] - values[2])) > 0.5 * abs(float(values[1]))
    bracket = abs(float(values[0] - values[1])) if jumps else 0.0
    uncertainty = math.hypot(0.5 * below + bracket, trapped)
    return Estimate(float(values[1]) - (0.0 if jumps else below), uncertainty, "N", warnings)


def _find_grid_error(state: ContactSolution) -> float:
    """Return the relative standard deviation of the lowest force by the size of the cells."""
    assert state.tension is not None
    attracted = state.contact | (state.tension > 0.5 * float(state.tension.max()))
    size = count_patch_cells(attracted, state.boundary)
    sticking = _STICKING * math.exp(-_cells_of(state)) / math.sqrt(size)
    return math.hypot(sticking, min(_COARSE * size ** (-4.0 / 3.0), _COARSEST), _PATH)


def _find_energies(sweep: Sweep) -> Array:
    found = []
    for state in sweep:
        assert state.origin is not None
        law = state.origin.source.plan.interaction
        elastic = 0.5 * float(np.sum(state.pressure * state.displacement))
        attraction = float(np.sum(law.energy(_open_gap(state))))
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
    # A jump bends the force as well, but the energies on both of its sides are known: the median step counts.
    return float(np.median(_second_differences(sweep))) * math.sqrt(len(sweep))


def _cells_of(state: ContactSolution) -> float:
    assert state.origin is not None
    plan = state.origin.source.plan
    cells: float = plan.interaction.cohesive_cells(plan.grid.spacing, plan.modulus)
    return cells
