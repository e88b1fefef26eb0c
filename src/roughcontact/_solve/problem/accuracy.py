"""Solves to a requested accuracy, from which the grid and the tolerance follow."""

from __future__ import annotations

import contextlib
import copy
import math
from collections.abc import Callable
from typing import TypeVar

import attrs
import numpy as np
import scipy

from roughcontact._base.arrays import Array
from roughcontact._base.checks import choice, number
from roughcontact._parts.grid import Grid, Load
from roughcontact._parts.surfaces import bilinear
from roughcontact._solve.problem.body import Body
from roughcontact._solve.problem.memory import require_memory_of_solve
from roughcontact._solve.problem.run import run_solve
from roughcontact._solve.problem.scene import Scene
from roughcontact._solve.solution import DEFAULT_AREA, Accuracy, ContactSolution, Trial
from roughcontact._solve.solvers import Step
from roughcontact.errors import InputError, NotEnoughMemory, argument

S = TypeVar("S", bound=Scene)

# Maximum algebraic error, over the requested standard deviation: the rule of Ern and Vohralik, SIAM J. Sci. Comput. 35
# (2013) A1761, https://doi.org/10.1137/120896918.
_ALGEBRAIC_ERROR_PART = 0.1
# Relative change of area and maximum pressure, over the tolerance, with a margin: at most 0.8 and 0.7 on 44 waves,
# balls, rough and capped contacts at tolerances of 1e-4, 0.4 and 1.1 at 1e-3 (docs/studies/tolerance.py).
_TOLERANCE_SENSITIVITY = 2.0
# Maximum tolerance with a settled set of cells in contact: areas are wrong by up to 0.8 % at 1e-2.
_MAX_TOLERANCE = 1e-3
# Minimum fraction of the mean square curvature of the heights that a coarse grid resolves (five cells to a wave), and
# that the only solved grid has beside one of twice the cells (three cells to a wave).
_MIN_CURVATURE_FRACTION = 0.75
_MIN_CONFIRMED_FRACTION = 0.5
# Minimum cells along an axis of the coarsest grid, and divisor of the cells of others.
_MIN_COARSE_CELLS = 64
_SIDE_MULTIPLE = 8
# Order of the uncertainty in the cell size before two grids show it, bounds of the observed order, and bounds of the
# factor between the cells of two grids.
_FIRST_ORDER = 3.0
_ORDER_RANGE = (1.0, 4.0)
_REFINEMENT_RANGE = (1.15, 4.0)
# Factor on the predicted cells of the next grid, because the uncertainty scatters.
_REFINEMENT_MARGIN = 1.05
# Factor on the cells after a grid that meets the accuracy but disagrees with the one before.
_CONFIRMING_REFINEMENT = 1.5
# Maximum cells of a refined grid, about ten seconds, and the same over the cells of the given grid.
_MAX_UNASKED_CELLS = 2**22
_MAX_CELLS_OVER_GIVEN = 64
_NO_HEIGHTS_REASON = (
    "the heights are known at the points of a map only, and a finer grid cannot add any: measure a finer map"
)


def resample_problem(problem: S, shape: tuple[int, int], interpolation: str | None = None) -> S:
    """Return the problem on another number of cells; see `roughcontact.on_grid`."""
    grid = Grid(shape, problem.plan.grid.size)
    if interpolation is not None:
        choice(interpolation, "The interpolation of a map between its points", ("bilinear", "cubic", "fourier", "mean"))
    if problem.plan.pressure_limit.ndim:
        raise InputError("The pressure limit is an array, which is not known between its cells.")
    body, counterbody = (
        Body(side.surface.resample_to(grid, interpolation), side.material)
        for side in (problem.body, problem.counterbody)
    )
    return attrs.evolve(problem, body=body, counterbody=counterbody, grid=grid)


def interpolate_pressure(solution: ContactSolution, problem: Scene) -> Array:
    """Return the pressure of a solution on the grid of the same problem on other cells, to start from, Pa."""
    free_x, free_y = problem.boundary.free_axes
    return bilinear(solution.pressure, problem.plan.grid.shape, periodic=(not free_x, not free_y))


@attrs.frozen
class Target:
    """Admissible relative errors of area and maximum pressure, with 95 %; None if not requested."""

    area_within: float | None
    peak_within: float | None

    @classmethod
    def of(cls, area_within: object, peak_within: object) -> Target | None:
        """Return the target, or None if nothing is requested; `InputError` if a value is not between 0 and 1."""
        given = [
            None if value is None else number(value, f"The relative error {argument(name)}", above=0.0, at_most=1.0)
            for name, value in (("area_within", area_within), ("peak_within", peak_within))
        ]
        return None if given == [None, None] else cls(*given)

    def tolerance(self, smallest: float) -> float:
        """Return the tolerance of a solver, at least `smallest`."""
        within = min(value for value in (self.area_within, self.peak_within) if value is not None)
        return max(min(0.5 * within * _ALGEBRAIC_ERROR_PART / _TOLERANCE_SENSITIVITY, _MAX_TOLERANCE), smallest)

    def measure(self, solution: ContactSolution) -> Trial:
        """Return the trial of a solved grid."""
        area = (math.nan, math.nan)
        peak = (math.nan, math.nan)
        if self.area_within is not None:
            found = solution.area()
            area = found.value, found.uncertainty
        if self.peak_within is not None:
            highest = solution.peak_pressure()
            peak = highest.value, highest.uncertainty
        return Trial(solution.grid.shape, *area, *peak, solution.convolutions, solution.seconds)

    def excess(self, trial: Trial) -> float:
        """Return two standard deviations over the admissible error, the maximum of both: at most 1 if it is met."""
        within = self.area_within, self.peak_within
        return max(spread / value for spread, value in zip(trial.spreads, within, strict=True) if value is not None)


def solve_within(
    problem: Scene,
    load: Load,
    target: Target,
    tolerance: float | None,
    on_step: Callable[[Step], None] | None,
    start: Array | None,
) -> ContactSolution:
    """Return the solution on the coarsest grid found that meets a target, or the last one with the reason."""
    if problem.adhesion is not None:
        raise InputError(
            "With adhesion the accuracy cannot be asked for: give a grid whose cohesive length has 2.5 cells."
        )
    if start is not None:
        raise InputError(
            f"With {argument('area_within')} or {argument('peak_within')} the grid is chosen: omit start=, which "
            "needs one."
        )
    if load.kind == "approach":
        raise InputError(
            f"An accuracy needs {argument('pressure')} or {argument('force')}: an approach counts from first touch, "
            "which moves with the grid."
        )
    problem = _choose_tolerance(problem, target) if tolerance is None else with_tolerance(problem, tolerance)
    trials: list[Trial] = []
    rung = _coarsest(problem)
    solution = None
    shortfall = ""
    while True:
        start = None if solution is None else interpolate_pressure(solution, rung)
        try:
            solution = run_solve(rung, load, start, throw=False, on_step=on_step)
        except InputError as error:
            # The memory is checked again before a solve, because the heights take some.
            if solution is None:
                raise
            shortfall = _explain(error, rung.plan.grid.shape)
            break
        trials.append(target.measure(solution))
        if not solution.status.success:
            shortfall = "the solver did not converge"
            break
        if target.excess(trials[-1]) <= 1.0 and _is_confirmed(rung, problem, trials):
            break
        try:
            rung = _refine(problem, trials, target)
        except InputError as error:
            shortfall = str(error).rstrip(".")
            break
    estimator = DEFAULT_AREA if target.area_within is not None else ""
    within = target.area_within, target.peak_within
    return attrs.evolve(
        solution, accuracy=Accuracy(*within, rung.plan.solver.tolerance, estimator, tuple(trials), shortfall)
    )


def with_tolerance(problem: S, tolerance: float) -> S:
    """Return the same problem with another tolerance; heights and convolution are reused."""
    solver = problem.plan.solver.with_tolerance(tolerance)
    plan = attrs.evolve(problem.plan, solver=solver)
    changed = copy.copy(problem)
    known = {"solver": solver, "plan": plan, "convolution": problem.convolution, "_gap": problem._gap}
    for name, value in known.items():
        object.__setattr__(changed, name, value)
    return changed


def tolerance_within(problem: Scene, area_within: float | None, peak_within: float | None) -> float:
    """Return the tolerance of the solver with which `ContactProblem.solve` reaches an accuracy."""
    target = Target.of(area_within, peak_within)
    return (problem if target is None else _choose_tolerance(problem, target)).plan.solver.tolerance


def _choose_tolerance(problem: S, target: Target) -> S:
    """Return the problem with the tolerance that the target allows; a solver that was given keeps its own."""
    if not isinstance(problem.solver, str):
        return problem
    with contextlib.suppress(InputError):
        # The tolerance of a plug-in may be fixed.
        problem = with_tolerance(problem, target.tolerance(problem.plan.solver.tolerance))
    return problem


def _has_map(problem: Scene) -> bool:
    return any(body.own_grid is not None for body in (problem.body, problem.counterbody))


def _coarsest(problem: S) -> S:
    """Return the problem on the coarsest grid that resolves the curvature of its heights; maps are not coarsened."""
    shape = problem.plan.grid.shape
    stride = 1
    if _has_map(problem):
        return problem
    all_of_it = _mean_square_curvature(problem.initial_gap, problem.plan.grid)
    while min(shape) // (2 * stride) >= _MIN_COARSE_CELLS:
        coarse = problem.initial_gap[:: 2 * stride, :: 2 * stride]
        if (
            _mean_square_curvature(coarse, Grid(coarse.shape, problem.plan.grid.size))
            < _MIN_CURVATURE_FRACTION * all_of_it
        ):
            break
        stride *= 2
    try:
        return problem if stride == 1 else resample_problem(problem, (shape[0] // stride, shape[1] // stride))
    except InputError:
        return problem


def _mean_square_curvature(gap: Array, grid: Grid) -> float:
    """Return the mean square second differences of the gap, 1/m2, where it is below its mean."""
    low = gap < gap.mean()
    total = 0.0
    for values, there, step in zip((gap, gap.T), (low, low.T), grid.spacing, strict=True):
        bends = np.diff(values, 2, axis=0)[there[1:-1]]
        # Fewer than three cells show no curvature.
        total += float(np.mean(bends**2)) / step**4 if bends.size else math.nan
    return total


def _is_confirmed(rung: Scene, problem: Scene, trials: list[Trial]) -> bool:
    """Return whether a grid agrees with the previous one, or a finer one has no sharper heights."""
    if len(trials) > 1:
        one, other = trials[-2:]
        area = other.area - one.area
        peak = other.peak - one.peak
        # Comparisons with nan, which is not requested, are false.
        return not (
            abs(area) > 2.0 * math.hypot(one.area_uncertainty, other.area_uncertainty)
            or abs(peak) > 2.0 * math.hypot(one.peak_uncertainty, other.peak_uncertainty)
        )
    nx, ny = rung.plan.grid.shape
    if rung is not problem or _has_map(problem):
        return True
    try:
        finer = resample_problem(problem, (2 * nx, 2 * ny))
    except InputError:
        return True
    sharp = _mean_square_curvature(finer.initial_gap, finer.plan.grid)
    return _mean_square_curvature(problem.initial_gap, problem.plan.grid) >= _MIN_CONFIRMED_FRACTION * sharp


def _refine(problem: S, trials: list[Trial], target: Target) -> S:
    """Return the problem on the grid that should meet the target; `InputError` with the reason if there is none."""
    excess = target.excess(trials[-1])
    order = _FIRST_ORDER
    cells = [math.sqrt(math.prod(trial.shape)) for trial in trials]
    if len(trials) > 1 and math.isfinite(before := target.excess(trials[-2])) and excess > 0.0:
        observed = math.log(before / excess) / math.log(cells[-1] / cells[-2])
        order = min(max(observed, _ORDER_RANGE[0]), _ORDER_RANGE[1])
    factor = (
        min(max(_REFINEMENT_MARGIN * excess ** (1.0 / order), _REFINEMENT_RANGE[0]), _REFINEMENT_RANGE[1])
        if excess > 1.0
        else _CONFIRMING_REFINEMENT
    )
    nx, ny = (
        _SIDE_MULTIPLE * scipy.fft.next_fast_len(math.ceil(factor * n / _SIDE_MULTIPLE), real=True)
        for n in trials[-1].shape
    )
    allowed = max(_MAX_UNASKED_CELLS, _MAX_CELLS_OVER_GIVEN * problem.plan.grid.cells)
    if nx * ny > allowed:
        raise InputError(
            f"it seems to need {nx} x {ny} cells, more than the {allowed} to which this grid of "
            f"{problem.plan.grid.shape[0]} x {problem.plan.grid.shape[1]} is refined: allow a larger error, or give a "
            "finer grid"
        )
    try:
        require_memory_of_solve(Grid((nx, ny), problem.plan.grid.size), problem.boundary, problem.memory_limit)
    except InputError as error:
        raise InputError(_explain(error, (nx, ny))) from error
    try:
        return resample_problem(problem, (nx, ny))
    except InputError as error:
        if _has_map(problem):
            raise InputError(_NO_HEIGHTS_REASON) from error
        raise


def _explain(error: InputError, shape: tuple[int, int]) -> str:
    """Return why a refined grid is not solved, without the advice to choose another."""
    if not isinstance(error, NotEnoughMemory):
        return str(error).rstrip(".")
    return (
        f"it seems to need {shape[0]} x {shape[1]} cells, for which there is too little memory ({error.available}): "
        "allow a larger error"
    )
