"""Two grids: what a coarser grid of the same heights says about every answer.

Every second point of a map, from the first and from the second on along both axes, is a map of the same surface with a
quarter of the cells: a phase of the grid. How far an answer of these two differs from that of all points contains the
change by the size of the cells and the scatter by their place. A contact without sharp edges and rough heights is
judged by a model of the errors instead, which costs no solve.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TypeVar

import attrs
import numpy as np
import scipy

from roughcontact._answers.areas.edges import judge_uncertainty
from roughcontact._base.arrays import Array
from roughcontact._base.units import Estimate, ShownAsPrinted
from roughcontact._parts.grid import Boundary, pad_axes
from roughcontact._parts.surfaces import FlatSurface, HeightMap
from roughcontact._solve.problem import Body, ContactProblem
from roughcontact._solve.solution import Area, ContactSolution, Response, responses
from roughcontact.errors import InputError, RoughContactError

Number = TypeVar("Number", bound=Estimate)

# Tolerance of the solves: at 1e-3 the differences are those of converged ones to 5 %, at 1e-2 up to eight times them.
_TOLERANCE = 1e-3
# Cells of an axis at least, and those before and behind it for the splines.
_MIN_CELLS = 8
_SPLINE_CELLS = 8
# Change between two points over the mean of those up to so many points away, from which heights have a step there.
_MIN_STEP = 4.0
_STEP_REACH = 4
# Standard deviation over the differences: of smooth heights, and of flagged ones, whose answers change slowly.
_SMOOTH_FACTOR = 0.5
_FLAGGED_FACTOR = 1.0
# The same of a flagged area that is extrapolated, and the part of the difference by which it is.
_EXTRAPOLATED_FACTOR = 0.8
_EXTRAPOLATION = 1.0 / 3.0
# Uncertainty of an extrapolated area over that of a model, at least: lands along the grid are the same on both.
_MIN_AREA_PART = 0.5
# Relative standard deviation by the tolerance of the solves, at least, unless that of one grid is less.
_MIN_STD = 1e-4
# Warnings that a model of the errors gives where it does not know them.
_MODEL_RULES = ("resolution", "uncertainty")


@attrs.frozen(eq=False)
class Phases:
    """The contact on both diagonal phases of the grid.

    Attributes
    ----------
    states
        The solutions on every second point along x and y, from the first and from the second on, at the same load.
    factor
        Standard deviation of an answer over the root mean square of its differences from theirs.
    flagged
        Whether edges or heights are sharp at the scale of the cells (`roughcontact.responses.Flags.unresolved`).

    Examples
    --------
    >>> import roughcontact as rc
    >>> wave = rc.Body(rc.WavySurface(amplitude=0.5e-6, wavelength=12.5e-6), rc.Elastic(young=200e9, poisson=0.3))
    >>> problem = rc.ContactProblem(wave, grid=rc.Grid((64, 64), 50e-6), boundary="periodic")
    >>> solution = problem.solve(pressure=100e6)
    >>> [state.grid.shape for state in solution.phases().states]
    [(32, 32), (32, 32)]
    """

    states: tuple[ContactSolution, ContactSolution]
    flagged: bool

    @property
    def factor(self) -> float:
        return _FLAGGED_FACTOR if self.flagged else _SMOOTH_FACTOR

    @property
    def convolutions(self) -> int:
        """Convolutions of both solves, on a quarter of the cells."""
        return sum(state.convolutions for state in self.states)

    def judge(
        self,
        found: Number,
        ask: Callable[[ContactSolution], Estimate],
        flagged_factors: tuple[float, float] = (_FLAGGED_FACTOR, 1.0),
    ) -> Number:
        """Return an answer with the standard deviation by both grids.

        Parameters
        ----------
        found
            The answer of all points.
        ask
            Returns the answer of a solution.
        flagged_factors
            Those of the response, where the contact is flagged (`roughcontact.Response.flagged_factors`).

        Returns
        -------
        Number
            The same value. Where the contact is flagged, and nothing else is given, the standard deviation is at least
            that of a model.
        """
        change = _root_mean_square(found.value, [ask(state).value for state in self.states])
        if self.flagged:
            factor, part = flagged_factors
            return _with_uncertainty(found, max((factor or _FLAGGED_FACTOR) * change, part * found.uncertainty))
        std = self.factor * change
        return _with_uncertainty(found, max(std, min(found.uncertainty, _MIN_STD * abs(found.value))))

    def extrapolate_area(self, solution: ContactSolution, found: Area) -> Area:
        """Return the area inside the edge, extrapolated over both grids: creases and edges err with the cell."""
        level, *others = (state.area("level-set", uncertainty="model").value for state in (solution, *self.states))
        value = level + _EXTRAPOLATION * (level - sum(others) / len(others))
        value = min(max(value, 0.0), solution.grid.area)
        change = _root_mean_square(level, others)
        # Areas that agree as well as the solves, such as those of punches that yield, say nothing of the grid.
        part = _MIN_AREA_PART if change > _TOLERANCE * level else 1.0
        std = max(_EXTRAPOLATED_FACTOR * change, part * found.uncertainty)
        extrapolated = attrs.evolve(
            found, value=value, fraction=value / solution.grid.area, estimator="level-set, two grids", patches=None
        )
        return _with_uncertainty(extrapolated, std)


def _with_uncertainty(found: Number, std: float) -> Number:
    """Return an answer with another standard deviation, and warned by that instead of by the model."""
    kept = tuple(text for text in found.warnings if getattr(text, "rule", "") not in _MODEL_RULES)
    what = "the area" if isinstance(found, Area) else "this number"
    return attrs.evolve(found, uncertainty=std, warnings=judge_uncertainty(what, found.value, std, kept))


def _root_mean_square(value: float, others: list[float]) -> float:
    return math.sqrt(sum((value - other) ** 2 for other in others) / len(others))


@responses.register("phases")
@attrs.frozen
class SolvePhases(Response[Phases]):
    """The contact on both diagonal phases of its grid, which tell how much each answer depends on the grid."""

    def respond(self, solution: ContactSolution) -> Phases:
        """Return the phases, solved once.

        Raises
        ------
        InputError
            If there are fewer than eight cells along an axis, or the problem of the solution is not known, or it has
            laws or a pressure limit for each cell.
        NotConverged
            If a phase is not certified.
        """
        return solution._keep("phases", lambda: _solve_phases(solution))


@attrs.frozen(eq=False)
class Judgement(ShownAsPrinted):
    """What the uncertainties of a contact are found from where nobody chooses.

    Attributes
    ----------
    phases
        The contact on both diagonal phases of its grid; None if a model of the errors is asked.
    reason
        Why, in words.

    Examples
    --------
    >>> import roughcontact as rc
    >>> wave = rc.Body(rc.WavySurface(amplitude=0.5e-6, wavelength=12.5e-6), rc.Elastic(young=200e9, poisson=0.3))
    >>> problem = rc.ContactProblem(wave, grid=rc.Grid((64, 64), 50e-6), boundary="periodic")
    >>> print(problem.solve(pressure=100e6).response("judgement"))
    uncertainties by a model of the errors: no sharp edge, no crease under the maximum pressure, smooth heights
    """

    phases: Phases | None
    reason: str

    def __str__(self) -> str:
        if self.phases is None:
            return f"uncertainties by a model of the errors: {self.reason}"
        work = f"{self.phases.convolutions} convolutions on a quarter of the cells"
        return f"uncertainties by two grids: {self.reason}; {work}"


@responses.register("judgement")
@attrs.frozen
class JudgeContact(Response[Judgement]):
    """What the uncertainties of a contact are found from, and why.

    Sharp edges and rough heights ask for two grids, unless there is no coarser one.
    """

    holds_with = frozenset({"tension", "shear", "relaxation"})
    memory_arrays = 0.0  # those of the answers that it asks for, which are refused themselves

    def respond(self, solution: ContactSolution) -> Judgement:
        """Return the judgement of a solution, which it keeps."""
        return solution._keep("judgement", lambda: _judge(solution))


def _judge(solution: ContactSolution) -> Judgement:
    if solution.non_measured is not None:
        return Judgement(None, "points were not measured, whose heights each grid fills in another way")
    try:
        flags = solution.response("flags")
        if not flags.unresolved:
            return Judgement(None, str(flags).removeprefix("none: "))
        return Judgement(solution.phases(), str(flags))
    except RoughContactError as error:
        return Judgement(None, str(error).rstrip("."))


def _solve_phases(solution: ContactSolution) -> Phases:
    _require_problem(solution)
    if any(n < _MIN_CELLS for n in solution.grid.shape):
        raise InputError(f"A grid of {' x '.join(map(str, solution.grid.shape))} cells has no coarser one.")
    flagged = solution.response("flags").unresolved
    # Nothing coarser judges the coarser ones.
    first, second = (attrs.evolve(_solve_phase(solution, offset), uncertainty="model") for offset in (0, 1))
    return Phases((first, second), flagged)


def _require_problem(solution: ContactSolution) -> ContactProblem:
    """Return the problem of a solution, or raise `InputError` if it cannot be solved with other heights."""
    if solution.origin is None or not solution.parts.is_whole:
        raise InputError("Its problem is not known here, so that it cannot be solved with other heights.")
    problem: ContactProblem = solution.origin.scene
    if problem.laws or np.ndim(solution.pressure_limit):
        raise InputError("A contact with laws, or a pressure limit for each cell, is not solved with other heights.")
    return problem


def _solve_phase(solution: ContactSolution, offset: int) -> ContactSolution:
    """Return the solution on every second point from an offset on."""
    boundary = solution.boundary
    gap = _coarsen(solution.initial_gap, boundary, offset, _insert_row)
    start = _coarsen(solution.pressure, boundary, offset, _repeat_row)
    lost = None
    if solution.non_measured is not None:
        lost = _coarsen(solution.non_measured.astype(np.float64), boundary, offset, _repeat_row) > 0.0
    sides = zip(solution.grid.size, solution.grid.shape, boundary.free_axes, strict=True)
    # Along a free axis the last row of an odd number has no second one.
    size = tuple(side * (n - n % 2) / n if free else side for side, n, free in sides)
    heights = HeightMap(-gap, size=size, periodic=boundary is Boundary.PERIODIC, non_measured=lost)
    return solve_with(heights, solution, start)


def solve_with(heights: HeightMap, solution: ContactSolution, start: Array) -> ContactSolution:
    """Return the solution with other heights of both bodies together, from this pressure on, under the same load."""
    problem = _require_problem(solution)
    other = attrs.evolve(
        problem,
        body=Body(heights, problem.body.material),
        counterbody=Body(FlatSurface(), problem.counterbody.material),
        grid=None,
        solver=problem.plan.solver.with_tolerance(max(_TOLERANCE, problem.plan.solver.tolerance)),
    )
    if solution.origin is None or "approach" not in solution.origin.load:
        return other.solve(force=solution.force, start=start)
    # Its highest point may be lower, and is then touched later.
    known = True if heights.non_measured is None else ~heights.non_measured
    approach = solution.approach + float(np.max(heights.values, where=known, initial=-np.inf))
    if approach <= 0.0:
        raise InputError("With other heights nothing touches.")
    return other.solve(approach=approach, start=start)


def _coarsen(field: Array, boundary: Boundary, offset: int, insert: Callable[[Array, int], Array]) -> Array:
    """Return every second row and column of a field; an odd number of periodic ones is first made even."""
    for axis, free in enumerate(boundary.free_axes):
        n = field.shape[axis]
        if n % 2 and not free:
            field = insert(field, axis)
        field = np.take(field, range(offset, field.shape[axis] - n % 2 * free, 2), axis=axis)
    return field


def _insert_row(field: Array, axis: int) -> Array:
    """Return periodic values at one more point along an axis, by splines that leave steps sharp."""
    n = field.shape[axis]
    ends = (_SPLINE_CELLS, _SPLINE_CELLS)
    values = pad_axes(field, (ends, (0, 0)) if axis == 0 else ((0, 0), ends), (False, False))
    known = np.arange(-_SPLINE_CELLS, n + _SPLINE_CELLS)
    spline = scipy.interpolate.Akima1DInterpolator(known, values, axis=axis, method="makima")
    places = (np.arange(n + 1) + 0.5) * n / (n + 1) - 0.5
    found = np.moveaxis(np.asarray(spline(places)), axis, 0)
    # A height between both sides of a step would be an edge that is not sharp, and one beyond them a higher land.
    rows = np.moveaxis(values, axis, 0)
    changes = np.abs(np.diff(rows, axis=0))
    steps = changes > _MIN_STEP * scipy.ndimage.uniform_filter1d(changes, 2 * _STEP_REACH + 1, axis=0)
    near = scipy.ndimage.maximum_filter1d(steps, 5, axis=0)
    first = np.floor(places).astype(int) + _SPLINE_CELLS
    ends = rows[first], rows[first + 1]
    found = np.where(near[first], np.clip(found, np.minimum(*ends), np.maximum(*ends)), found)
    found = np.where(steps[first], rows[np.rint(places).astype(int) + _SPLINE_CELLS], found)
    return np.moveaxis(found, 0, axis)


def _repeat_row(field: Array, axis: int) -> Array:
    """Return the nearest periodic values at one more point along an axis."""
    n = field.shape[axis]
    nearest = ((np.arange(n + 1) + 0.5) * n / (n + 1)).astype(int)
    return np.asarray(np.take(field, nearest, axis=axis))
