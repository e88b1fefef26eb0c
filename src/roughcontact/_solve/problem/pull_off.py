"""The force at which surfaces that attract each other come apart: the lowest one on unloading."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any, TypeAlias

import attrs
import numpy as np

from roughcontact._base.arrays import Array, Mask
from roughcontact._base.units import Estimate
from roughcontact._parts.grid import Load, extend
from roughcontact._parts.interactions import Exponential, ShortRange
from roughcontact._solve.problem.brought_laws import remember_flattening
from roughcontact._solve.problem.loads import Solve, cells_of, follow, open_gap, plan_of, require_resolved
from roughcontact._solve.problem.path import march
from roughcontact._solve.problem.plan import SolvePlan
from roughcontact._solve.problem.run import run_solve
from roughcontact._solve.problem.scene import Scene
from roughcontact._solve.problem.sweep import Sweep
from roughcontact._solve.solution import (
    ContactSolution,
    count_patch_cells,
    find_cut_tension,
    warn_of_border,
)

# Steps of the approach on the way to pull-off, and the part of one that comes first, which shows the stiffness.
_MAX_STEPS = 200
_FIRST_PART = 1.0 / 16.0
# Rounds that halve the steps in which the lowest force may be, how many states each solves on balls, and by how much of
# the force, at least, a step must promise a lower one.
_REFINEMENTS = 4
_STATES_OF_REFINEMENT = 4
_PROMISE = 5e-4
# Relative standard deviation of the lowest force, set on 400 balls and 100 rough surfaces in random places
# (benchmarks/adhesion_classes.py): because the edge of the contact sticks to the cells, by exp(-cells) of the cohesive
# length over the root of the cells of a patch; because a patch has few cells, and its maximum; and by the path.
_STICKING = 0.7
_COARSE = 1.8
_COARSEST = 0.14
_PATH = 2e-4
# The tension of a sharp law ends within a cell, and cells count what lies within its edge: standard deviation over the
# attraction, times the cells of a patch to the power 3/4, as of the lattice points in a disc, of which long cells bring
# fewer; and its fall with the cells over which the tension falls. On 48 balls under Dugdale laws of smoothing 0.1 and
# 40 under smooth ones, on cells of 1 : 1 to 3 : 1.
_COUNTED = 0.7
_COUNTED_FALL = 2.5
# Ratio of two ranges from which pull-off is extrapolated to none, and the power of the range by which it goes there:
# 1.5 for short ranges, less for those that cells resolve. On balls of 8 to 40 cells in the contact radius of Johnson,
# 1.2 errs by a fifth of the change.
_LONGER = math.sqrt(2.0)
_POWER = 1.2
_EXTRAPOLATION_ERROR = 0.25
# Largest change that is extrapolated, over the force.
_MAX_EXTRAPOLATION = 0.25
# Where summits differ, on 104 rough surfaces, some under layers (benchmarks/adhesion_classes.py), relative to
# pull-off in the limit of a short range: standard deviation, as a shorter range may join or separate other summits;
# that of a contact of few cells, over their number, at most the next one; and how much too strong those few
# are, over that deviation, since their range is not short.
_UNLIKE = 0.25
_UNLIKE_FEW = 3.0
_UNLIKE_FEWEST = 0.33
_TOO_STRONG = 0.7
# Relative standard deviation of the lowest force by the range that the cells resolve, in the limit of a short range,
# over a power of the radius of a patch in cells: balls of 8 to 40 cells pull off at 9 to 3 % more.
_LIMIT = 0.35
_LIMIT_EXPONENT = -0.8
# Differences of the initial gap along an axis, over those of all cells, up to which the surface is straight.
_STRAIGHT = 1e-6

# Called with each state on the way to pull-off, and how many are to come; None while nobody knows.
OnStateToPullOff: TypeAlias = Callable[[ContactSolution, int | None], object]


def find_pull_off(problem: Scene, on_state: OnStateToPullOff | None = None) -> Estimate:
    """Return the minimum of the force on unloading from zero load; see `ContactProblem.pull_off`."""
    require_resolved(problem.plan)
    problem = remember_flattening(problem)
    tell: OnStateToPullOff = on_state or (lambda state, left: None)
    is_limit = isinstance(problem.adhesion, ShortRange)
    first = _ToldStates(partial(run_solve, problem), tell, paths=2 if is_limit else 1)
    found = _follow_to_pull_off(first, problem.plan)
    if not is_limit:
        return found
    law = problem.plan.interaction
    assert isinstance(law, Exponential)
    longer = attrs.evolve(problem, adhesion=Exponential(law.work, _LONGER * law.range))
    # By a longer range the way is about as long.
    second = _ToldStates(partial(run_solve, longer), tell, left=first.count)
    assert first.start is not None
    return _extrapolate_range(found, _follow_to_pull_off(second, longer.plan), first.start)


class _ToldStates:
    """A solve that tells each state, and how many are to come on this path and on others like it."""

    def __init__(self, solve: Solve, tell: OnStateToPullOff, paths: int = 1, left: int | None = None) -> None:
        self.solve = solve
        self.tell = tell
        self.paths = paths
        self.left = left
        self.count = 0
        self.start: ContactSolution | None = None

    def __call__(self, load: Load, start: Array | None = None, **others: Any) -> ContactSolution:
        state = self.solve(load, start, **others)
        self.start = self.start or state
        self.count += 1
        if self.left is not None:
            self.left = max(self.left - 1, 0)
        self.tell(state, self.left)
        return state

    def expect(self, left: int) -> None:
        """Take it that so many states are to come on this path."""
        self.left = left + (self.paths - 1) * (self.count + left)


def _follow_to_pull_off(solve: _ToldStates, plan: SolvePlan) -> Estimate:
    states: list[ContactSolution] = []
    for state in march(_list_descending(states, plan), partial(follow, solve)):
        states.append(state)
    solve.expect(_REFINEMENTS * _STATES_OF_REFINEMENT)
    path = Sweep(tuple(_refine(solve, states)))
    return find_minimum(path, tuple(text for text in plan.warnings if getattr(text, "rule", "") == "cohesive length"))


def _list_descending(states: Sequence[ContactSolution], plan: SolvePlan) -> Iterator[Load]:
    """Yield zero load, and then approaches downwards, until no lower force can follow the states that they found."""
    yield Load("pressure", 0.0)
    step = _first_step(plan, states[0])
    yield Load("approach", states[0].approach - _FIRST_PART * step)
    for _ in range(_MAX_STEPS):
        yield Load("approach", states[-1].approach - step)
        force = np.array([state.force for state in states])
        # Patches of rough surfaces separate one by one, and the force rises at each. No force is lower than that by the
        # whole attraction, which falls with the approach.
        if _find_attraction(states[-1]) < -force.min():
            break
        if abs(force[-2] - force[-1]) < 0.1 * abs(force.min()):
            step *= 1.5


def _find_attraction(state: ContactSolution) -> float:
    """Return the sum of the tensions of all cells, N."""
    assert state.tension is not None
    return float(state.tension.sum()) * state.grid.cell_area


def _extrapolate_range(shorter: Estimate, longer: Estimate, start: ContactSolution) -> Estimate:
    """Return the force of pull-off without a range, N, from those by a range and by a longer one.

    Straight edges along the cells stick to them as a whole, which no longer range shows, and of rough surfaces another
    summit may hold last: there, and where the change is a large part of the force, it is the uncertainty.
    """
    change = (shorter.value - longer.value) / (_LONGER**_POWER - 1.0)
    initial_gap = start.initial_gap
    straight = min(float(np.ptp(initial_gap, axis=axis).max()) for axis in (0, 1))
    is_straight = straight <= _STRAIGHT * float(np.ptp(initial_gap))
    is_extrapolated = not is_straight and abs(change) <= _MAX_EXTRAPOLATION * abs(shorter.value)
    value = shorter.value + (change if is_extrapolated else 0.0)
    error = math.hypot(longer.uncertainty, _EXTRAPOLATION_ERROR * change) if is_extrapolated else abs(change)
    too_strong, unlike = _find_unlike_summits(start)
    error = math.hypot(shorter.uncertainty, error, unlike * value)
    return attrs.evolve(shorter, value=value if is_straight else (1.0 - too_strong) * value, uncertainty=error)


def _find_unlike_summits(start: ContactSolution) -> tuple[float, float]:
    """Return by how much pull-off is too strong in the limit of a short range since summits differ, and its deviation.

    Both are relative, and zero on a paraboloid, whose bend is the same everywhere.
    """
    attracted = _find_attracted(start)
    around = extend(start.initial_gap, 1, start.boundary)
    bends = np.zeros(start.grid.shape)
    inside = np.ones(start.grid.shape, dtype=bool)
    for axis, (side, free) in enumerate(zip(start.grid.spacing, start.boundary.free_axes, strict=True)):
        lines = np.moveaxis(around, axis, 0)[:, 1:-1]
        bends += np.moveaxis(np.diff(lines, 2, axis=0), 0, axis) / side**2
        if free:
            # The cells repeated beyond a border bend it.
            np.moveaxis(inside, axis, 0)[[0, -1]] = False
    if not (attracted & inside).any():
        return 0.0, _UNLIKE
    mean = abs(float(bends[attracted & inside].mean()))
    differing = min(float(bends[inside].std()) / mean, 1.0) if mean > 0.0 else 0.0
    few = differing * min(_UNLIKE_FEW / count_patch_cells(attracted, start.boundary), _UNLIKE_FEWEST)
    return _TOO_STRONG * few, math.hypot(_UNLIKE * differing, few)


def _first_step(plan: SolvePlan, state: ContactSolution) -> float:
    """Return a step of the approach: a tenth of the displacement, or of the reach of the law if that is longer."""
    moved = float(state.displacement.max() - state.displacement.min())
    law = plan.interaction
    range_of_law = 0.0 if law is None else float(np.max(np.asarray(law.work) / np.asarray(law.strength)))
    return 0.1 * max(moved, range_of_law)


def _refine(solve: Solve, path: Sequence[ContactSolution]) -> list[ContactSolution]:
    """Return the states of a path with more of them where the force may be lowest, each from the one before."""
    refined = list(path)
    for _ in range(_REFINEMENTS):
        found: list[ContactSolution] = []
        for state in march(_list_halved(found, refined), partial(_follow_or_keep, solve), refined[0]):
            found.append(state)
        refined = found
    return refined


def _list_halved(found: Sequence[ContactSolution], path: Sequence[ContactSolution]) -> Iterator[Load | ContactSolution]:
    """Yield the states of a path, or two loads where the force may be lowest: in the middle, and of the state."""
    for state, halved in zip(path[1:], _may_be_lowest(path), strict=True):
        if halved:
            yield Load("approach", 0.5 * (found[-1].approach + state.approach))
            yield Load("approach", state.approach)
        else:
            yield state


def _follow_or_keep(solve: Solve, before: Sequence[ContactSolution], place: Load | ContactSolution) -> ContactSolution:
    return follow(solve, before, place) if isinstance(place, Load) else place


def _may_be_lowest(path: Sequence[ContactSolution]) -> Mask:
    """Return whether the lowest force may be in each step of a path: beside the lowest state, or before a jump.

    A force that falls may fall on at that rate, and rise by a jump at the end of the step.
    """
    force = np.array([state.force for state in path])
    steps = np.abs(np.diff([state.approach for state in path]))
    falls = np.maximum(-np.diff(force) / steps, 0.0)
    before = np.append(falls[0], falls[:-1])
    lowest = int(force.argmin())
    may_be = np.asarray(force[:-1] - before * steps < force[lowest] - _PROMISE * abs(float(force[lowest])))
    may_be[max(lowest - 1, 0) : lowest + 1] = True
    return may_be


def find_minimum(sweep: Sweep, warnings: tuple[str, ...]) -> Estimate:
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
    _, cut = find_cut_tension(sweep[k])
    uncertainty = math.hypot(0.5 * below + bracket, trapped, cut)
    border = warn_of_border(sweep[k])
    warnings = warnings if border is None else (*warnings, border)
    return Estimate(float(values[1]) - (0.0 if jumps else below), uncertainty, "N", warnings)


def _find_grid_error(state: ContactSolution) -> float:
    """Return the relative standard deviation of the lowest force by the size of the cells."""
    size = count_patch_cells(_find_attracted(state), state.boundary)
    sticking = _STICKING * math.exp(-cells_of(state)) / math.sqrt(size)
    coarse = math.hypot(_COARSE * size ** (-4.0 / 3.0), _find_counting_error(state, size))
    return math.hypot(sticking, min(coarse, _COARSEST), _PATH)


def _find_counting_error(state: ContactSolution, size: float) -> float:
    """Return the relative standard deviation of the lowest force as cells count what a sharp law attracts."""
    sides = state.grid.spacing
    points = size * math.sqrt(min(sides) / max(sides))
    pull = _find_attraction(state) / max(abs(state.force), 1e-300)
    return pull * _COUNTED * math.pow(points, -0.75) * math.exp(-_COUNTED_FALL * _count_falling_cells(state))


def _count_falling_cells(state: ContactSolution) -> float:
    """Return over how many cells the tension falls at the edge of what is attracted."""
    law = plan_of(state).interaction
    gap = open_gap(state)
    falls = np.where(gap > 0.0, -law.slope(gap), 0.0)
    around = extend(gap, 1, state.boundary)
    steps = np.hypot(around[2:, 1:-1] - around[:-2, 1:-1], around[1:-1, 2:] - around[1:-1, :-2])
    rise = 0.5 * float(np.sum(falls * steps))
    height: float = np.max(law.strength) / law.steepest
    return height * float(falls.sum()) / rise if rise > 0.0 else math.inf


def _find_attracted(state: ContactSolution) -> Mask:
    """Return the cells in contact, and open ones of at least half the maximum of the tension."""
    assert state.tension is not None
    return np.asarray(state.contact | (state.tension > 0.5 * float(state.tension.max())))


def find_lowest(sweep: Sweep, warnings: tuple[str, ...]) -> Estimate:
    """Return the lowest force of a branch, N, solved more finely where it may be."""
    origin = sweep[0].origin
    if origin is None or origin.missing or not 0 < int(sweep.force.argmin()) < len(sweep) - 1:
        return find_minimum(sweep, warnings)
    refined = Sweep(tuple(_refine(partial(run_solve, origin.scene), sweep.states)))
    found = find_minimum(refined, warnings)
    if not origin.scene.plan.chosen_range:
        return found
    attracted = _find_attracted(refined[int(refined.force.argmin())])
    size = count_patch_cells(attracted, sweep[0].boundary)
    limit = _LIMIT * math.sqrt(size / math.pi) ** _LIMIT_EXPONENT
    error = math.hypot(limit, _find_unlike_summits(sweep[0])[1]) * abs(found.value)
    return attrs.evolve(found, uncertainty=math.hypot(found.uncertainty, error))
