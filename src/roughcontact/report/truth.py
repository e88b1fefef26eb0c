"""What errors are measured against: a closed form, or a refined solution with its own error."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from typing import Any

import attrs

from roughcontact.checks import number
from roughcontact.errors import InputError
from roughcontact.extrapolation import richardson
from roughcontact.grid import Boundary
from roughcontact.load import Load
from roughcontact.problem import ContactProblem
from roughcontact.refinement import Ladder, on_grid
from roughcontact.solution import DEFAULT_AREA, ContactSolution
from roughcontact.surfaces import PlacedMap, Surface
from roughcontact.surfaces.base import own_grid
from roughcontact.surfaces.resampling import bilinear
from roughcontact.surfaces.sum import SurfaceSum

QUANTITIES = ("area", "p_max", "approach")
_UNITS = {"area": "m2", "p_max": "Pa", "approach": "m"}
_ALLOWED = "a Truth, or an object or dict with at least one of area (m2), p_max (Pa) and approach (m)"
# The reference is finer than the finest case by this factor a side, as long as it has at most so many cells.
_FINER = 2
_MOST_CELLS = 2**24
# Three grids give a limit and an order; the fourth tells whether they are to be believed.
_LEVELS = 4


def _value(value: Any, field: Any) -> float | None:
    return None if value is None else number(value, f"The true {field.name}", _UNITS[field.name], above=0.0)


def _error(value: Any, field: Any) -> float:
    what = field.name.removesuffix("_error")
    return number(value, f"The error of the true {what}", _UNITS[what], at_least=0.0)


def _known(known_error: bool) -> Any:
    convert = attrs.Converter(_error if known_error else _value, takes_field=True)
    return attrs.field(default=0.0 if known_error else None, converter=convert)


@attrs.frozen(kw_only=True)
class Truth:
    """What is known of the true answer.

    Parameters
    ----------
    area, p_max, approach
        Real contact area, m2; greatest pressure, Pa; approach since first touch, m; at least one of them.
    area_error, p_max_error, approach_error
        How far each may be off, in the same units: smaller errors cannot be told from none.
    source
        Where it comes from, in words.

    Raises
    ------
    InputError
        If nothing is known, or a value is not positive and finite.
    """

    area: float | None = _known(False)
    p_max: float | None = _known(False)
    approach: float | None = _known(False)
    area_error: float = _known(True)
    p_max_error: float = _known(True)
    approach_error: float = _known(True)
    source: str = "given"

    def __attrs_post_init__(self) -> None:
        if not self.quantities:
            raise InputError("Nothing is known of the truth: give at least one of area=, p_max= and approach=.")

    @property
    def quantities(self) -> tuple[str, ...]:
        """The names of what is known."""
        return tuple(name for name in QUANTITIES if getattr(self, name) is not None)

    def blur(self, quantity: str) -> float:
        """Return the relative error of what is known of a quantity; nan if nothing is."""
        true = getattr(self, quantity)
        return float("nan") if true is None else float(getattr(self, f"{quantity}_error") / true)

    def error(self, quantity: str, value: float) -> float:
        """Return the relative error of a value, its sign included; nan if the truth is not known."""
        true = getattr(self, quantity)
        return float("nan") if true is None else float(value / true - 1.0)


def truth_of(given: object) -> Truth:
    """Return what the user gave as a truth: a `Truth`, a dict, or an object such as `reference.Hertz`.

    Raises
    ------
    InputError
        If it tells nothing that is known here.
    """
    if isinstance(given, Truth):
        return given
    if isinstance(given, Mapping):
        names = {field.name for field in attrs.fields(Truth)}
        if not given or not set(given) <= names:
            raise InputError.about("The truth", given, _ALLOWED)
        return Truth(**given)
    found = {name: getattr(given, name) for name in QUANTITIES if hasattr(given, name)}
    if not found:
        raise InputError.about("The truth", given, _ALLOWED)
    return Truth(**found, source=type(given).__name__)


def refined_truth(problem: ContactProblem, load: Load, finest: tuple[int, int], between: str | None) -> Truth:
    """Return what a ladder of up to four grids tells.

    Surfaces that go on smoothly between the cells are solved on grids up to twice as fine as the finest
    case, and what four grids bear is extrapolated. A map that does not is solved on its own grid. The
    own error is twice the standard deviation of the area; of pressure and approach it is the step to
    the extrapolated value, else the last change between grids, half the one before, and so on, whatever
    is greatest.

    Raises
    ------
    InputError
        If the surfaces are not known on the finest grid of the ladder.
    NotConverged
        If a solution is not certified.
    """
    smooth = _smooth(problem, between)
    solutions: list[ContactSolution] = []
    for rung in _rungs(attrs.evolve(problem, solver="auto"), finest, between, smooth):
        start = None
        if solutions:
            closed = rung.boundary is not Boundary.FREE
            start = bilinear(solutions[-1].pressure, rung.plan.grid.shape, periodic=closed)
        solutions.append(load.solve(rung, start))
    last = solutions[-1]
    area = Ladder(tuple(solutions), DEFAULT_AREA).area if smooth and len(solutions) > 1 else last.area()
    known: dict[str, Any] = {"area": area.value, "area_error": 2.0 * area.uncertainty}
    found = {"p_max": [float(solution.pressure.max()) for solution in solutions]}
    if load.approach is None:
        found["approach"] = [solution.approach for solution in solutions]
    if len(solutions) > 1:
        cells = [solution.grid.shape[0] for solution in solutions]
        for name, values in found.items():
            known[name], known[f"{name}_error"] = _limit(cells, values, smooth)
    nx, ny = last.grid.shape
    return Truth(**known, source=f"a solution on {nx} x {ny} cells (area by {area.estimator})")


def _rungs(problem: ContactProblem, finest: tuple[int, int], between: str | None, smooth: bool) -> list[ContactProblem]:
    """Return the problems of the ladder, from coarse to fine; the last one must do, the others may."""
    nx, ny = finest if smooth else problem.plan.grid.shape
    if smooth and nx * ny * _FINER**2 <= _MOST_CELLS:
        nx, ny = _FINER * nx, _FINER * ny
    rungs = [problem if (nx, ny) == problem.plan.grid.shape else on_grid(problem, (nx, ny), between)]
    for level in range(1, _LEVELS):
        if nx % 2**level or ny % 2**level or min(nx, ny) < 2 ** (level + 1):
            break
        try:
            rungs.insert(0, on_grid(problem, (nx >> level, ny >> level), between))
        except InputError:
            break
    return rungs


def _smooth(problem: ContactProblem, between: str | None) -> bool:
    """Tell whether the surfaces go on smoothly between the cells: what is bilinear has a ridge at each of them."""
    surfaces = [problem.body.surface, problem.counter.surface]
    if any(_ridged(surface) for surface in surfaces):
        return False
    if all(own_grid(surface) is None for surface in surfaces):
        return isinstance(problem.plan.limit, float)
    nx, ny = problem.plan.grid.shape
    try:
        on_grid(problem, (max(nx // 2, 2), max(ny // 2, 2)), between)
    except InputError:
        return False
    return between in (None, "fourier")


def _ridged(surface: Surface) -> bool:
    if isinstance(surface, SurfaceSum):
        return any(_ridged(part) for part in surface.parts)
    return isinstance(surface, PlacedMap) and surface.method == "bilinear"


def _limit(cells: list[int], values: list[float], smooth: bool) -> tuple[float, float]:
    """Return the value at infinite resolution, and how far it may be off."""
    if smooth and len(values) == _LEVELS:
        limit = richardson(cells, values)
        if limit.trustworthy and limit.value > 0.0:
            return limit.value, abs(limit.value - values[-1])
    # Each step halves the cell, and with it at least the error.
    steps = [abs(after - before) for before, after in itertools.pairwise(values)]
    return values[-1], max(step / 2**back for back, step in enumerate(reversed(steps)))
