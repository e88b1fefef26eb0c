"""The reference of a report: a closed form, or a solution on finer grids with error bounds."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import attrs
import numpy as np

from roughcontact._answers.refinement import on_grid, solve_ladder
from roughcontact._base.checks import number
from roughcontact._parts.grid import Grid, Load
from roughcontact._solve.problem import ContactProblem
from roughcontact.errors import InputError
from roughcontact.errors.door import guarded
from roughcontact.extrapolation import richardson

UNITS = {"area": "m2", "p_max": "Pa", "approach": "m"}
QUANTITIES = tuple(UNITS)
_ALLOWED = "a KnownAnswer, or an object or dict with at least one of area (m2), p_max (Pa) and approach (m)"
# Last step of a maximum pressure over the one before where it has no bound: 1.4 at the edge of a punch, and at creases,
# 0.5 or less where it has one; waves that the first grids do not resolve make larger steps.
_UNBOUNDED_RATIOS = (1.2, 1.7)
# The reference has this many times the cells a side of the finest case, up to 4096 x 4096 cells in all.
_REFINEMENT = 2
_MAX_REFERENCE_CELLS = 2**24
# Grids of the reference: three give a limit and an order, the fourth tests both.
_MAX_REFERENCE_GRIDS = 4


def _value(name: str) -> Any:
    check = partial(number, what=f"The reference {name}", unit=UNITS[name], above=0.0)
    return attrs.field(default=None, converter=attrs.converters.optional(check))


def _bound(name: str) -> Any:
    check = partial(number, what=f"The error bound of the reference {name}", unit=UNITS[name], at_least=0.0)
    return attrs.field(default=0.0, converter=check)


def _shape(value: Sequence[int]) -> tuple[int, int]:
    return Grid(value, 1.0).shape


@guarded
@attrs.frozen(kw_only=True)
class KnownAnswer:
    """A reference solution with error bounds.

    Parameters
    ----------
    area, p_max, approach
        Real contact area, m2; maximum pressure, Pa; approach since first touch, m; at least one of them.
    area_error, p_max_error, approach_error
        Their error bounds, in the same units: smaller errors are not resolved.
    source
        Where it comes from, in words.
    shape
        Cells (nx, ny) if it is a solution, which is not compared with itself.

    Raises
    ------
    InputError
        If it is empty, or a value is not positive and finite.

    Examples
    --------
    >>> import roughcontact as rc
    >>> exact = rc.results.KnownAnswer(area=1.5e-9, area_error=1e-12, source="closed form")
    >>> print(exact.source)
    closed form
    """

    area: float | None = _value("area")
    p_max: float | None = _value("p_max")
    approach: float | None = _value("approach")
    area_error: float = _bound("area")
    p_max_error: float = _bound("p_max")
    approach_error: float = _bound("approach")
    source: str = "given"
    shape: tuple[int, int] | None = attrs.field(default=None, converter=attrs.converters.optional(_shape))

    def __attrs_post_init__(self) -> None:
        if not self.quantities:
            raise InputError("The reference is empty: give at least one of area=, p_max= and approach=.")

    @property
    def quantities(self) -> tuple[str, ...]:
        """The names of the quantities that it has."""
        return tuple(name for name in QUANTITIES if getattr(self, name) is not None)

    def relative_uncertainty(self, quantity: str) -> float:
        """Return the error bound of a quantity over its value; nan if there is none."""
        value = getattr(self, quantity)
        return float("nan") if value is None else float(getattr(self, f"{quantity}_error") / value)

    def error(self, quantity: str, value: float) -> float:
        """Return the relative error of a value, with its sign; nan if the reference does not have the quantity."""
        known = getattr(self, quantity)
        return float("nan") if known is None else float(value / known - 1.0)


def read_reference(given: object) -> KnownAnswer:
    """Return a `KnownAnswer` from one, a dict, or an object such as `reference.Hertz`.

    Raises
    ------
    InputError
        If it has none of the quantities.
    """
    if isinstance(given, KnownAnswer):
        return given
    if isinstance(given, Mapping):
        if not given or not set(given) <= set(attrs.fields_dict(KnownAnswer)):
            raise InputError.about("The reference", given, _ALLOWED)
        return KnownAnswer(**given)
    known = {name: getattr(given, name) for name in QUANTITIES if hasattr(given, name)}
    if not known:
        raise InputError.about("The reference", given, _ALLOWED)
    return KnownAnswer(**known, source=type(given).__name__)


def solve_reference(
    problem: ContactProblem, load: Load, finest: tuple[int, int], interpolation: str | None
) -> KnownAnswer:
    """Return a reference from solutions on up to four grids.

    Surfaces that are smooth between the cells are solved on grids up to twice as fine as the finest case,
    and extrapolated where the grids agree on an order. A map that is not smooth is solved on its own grid.
    The error bound of the area is two standard deviations. The error bound of pressure and approach is the step to
    the extrapolated value, or else the largest of the last change between grids, half the change before, and so on. A
    maximum pressure whose steps do not shrink, or at a sharp edge or a crease, has no bound, and is omitted: it grows
    with every grid.

    Raises
    ------
    InputError
        If the surfaces are not known on the finest grid.
    NotConverged
        If a solution is not verified.
    """
    smooth = _is_smooth(problem, interpolation)
    ladder = solve_ladder(_make_problems(attrs.evolve(problem, solver="auto"), finest, interpolation, smooth), load)
    solutions = ladder.states
    last = ladder.states[-1]
    area = ladder.area
    known: dict[str, Any] = {"area": area.value, "area_error": 2.0 * area.uncertainty}
    values = {"p_max": [float(solution.pressure.max()) for solution in solutions]}
    if load.kind != "approach":
        values["approach"] = [solution.approach for solution in solutions]
    unbounded = ""
    if len(solutions) > 1:
        cells = [solution.grid.shape[0] for solution in solutions]
        for name, series in values.items():
            if name == "p_max" and (_grows(series) or last.response("flags").unbounded):
                unbounded = "; the maximum pressure has no limit: it grows with every grid"
                continue
            known[name], known[f"{name}_error"] = _extrapolate(cells, series, smooth)
    nx, ny = last.grid.shape
    what = "a solution on" if smooth else "the map solved on its own"
    source = f"{what} {nx} x {ny} cells (area by {area.estimator}){unbounded}"
    return KnownAnswer(**known, source=source, shape=(nx, ny))


def _make_problems(
    problem: ContactProblem, finest: tuple[int, int], interpolation: str | None, smooth: bool
) -> list[ContactProblem]:
    """Return the problem on the grids of the reference, from coarse to fine; only the finest must be possible."""
    nx, ny = finest if smooth else problem.plan.grid.shape
    if smooth and nx * ny * _REFINEMENT**2 <= _MAX_REFERENCE_CELLS:
        nx = _REFINEMENT * nx
        ny = _REFINEMENT * ny
    problems = [problem if (nx, ny) == problem.plan.grid.shape else on_grid(problem, (nx, ny), interpolation)]
    for level in range(1, _MAX_REFERENCE_GRIDS):
        if nx % 2**level or ny % 2**level or min(nx, ny) < 2 ** (level + 1):
            break
        try:
            problems.insert(0, on_grid(problem, (nx >> level, ny >> level), interpolation))
        except InputError:
            break
    return problems


def _is_smooth(problem: ContactProblem, interpolation: str | None) -> bool:
    """Return whether the surfaces are smooth between the cells: bilinear surfaces have a ridge at each cell."""
    surfaces = [problem.body.surface, problem.counterbody.surface]
    if not all(surface.is_smooth for surface in surfaces):
        return False
    if all(surface.own_grid is None for surface in surfaces):
        return problem.plan.pressure_limit.ndim == 0
    nx, ny = (max(n // 2, 2) for n in problem.plan.grid.shape)
    try:
        on_grid(problem, (nx, ny), interpolation)
    except InputError:
        return False
    return interpolation in (None, "fourier")


def _grows(values: list[float]) -> bool:
    """Return whether a value grows by steps that do not shrink, as the pressure at a sharp edge does."""
    steps = np.diff(values)
    if steps.size < 3 or not (steps > 0.0).all():
        return False
    ratios = steps[1:] / steps[:-1]
    smallest, largest = _UNBOUNDED_RATIOS
    return bool(smallest < ratios[-1] < largest and ratios[-2] > smallest)


def _extrapolate(cells: list[int], values: list[float], smooth: bool) -> tuple[float, float]:
    """Return the value at infinite resolution, and its error bound."""
    if smooth and len(values) == _MAX_REFERENCE_GRIDS:
        limit = richardson(cells, values)
        if limit.trustworthy and limit.value > 0.0:
            return limit.value, abs(limit.value - values[-1])
    # Each step halves the cell, and with it at least the error.
    steps = [abs(after - before) for before, after in itertools.pairwise(values)]
    return values[-1], max(step / 2**back for back, step in enumerate(reversed(steps)))
