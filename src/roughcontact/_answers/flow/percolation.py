"""The load at which the contact closes the last open path through the gap."""

from __future__ import annotations

import math
from functools import partial

import attrs
import numpy as np

from roughcontact._answers.areas.initial_gap import curvature_resolution
from roughcontact._answers.flow.leakage import find_open_cells, flow_axis
from roughcontact._answers.flow.network import find_paths
from roughcontact._base.checks import number
from roughcontact._base.units import ShownAsPrinted, si
from roughcontact._parts.grid import Load
from roughcontact._parts.surfaces import rms_slope
from roughcontact._solve.problem import ContactProblem, LoadSearch, TriedLoad, maximum_pressure, run_solve
from roughcontact._solve.solution import ContactSolution, Estimate, fill_gap
from roughcontact.errors import InputError
from roughcontact.errors.door import guarded

# First mean pressure over E* times the rms slope: a rough contact then has about two fifths of the nominal area.
_FIRST_PRESSURE_RATIO = 0.25
# Factor of the load in the first step until both an open and a closed contact are known, and the largest over the
# first load.
_LOAD_STEP_FACTOR = 1.5
_MAX_LOAD_FACTOR = 1e6
# Relative distance of two loads at which the search ends for paths as wide as two cells or as narrow as a corner.
_WIDTH_TOLERANCE = 0.01
# Standard deviation of the load over the distance of the loads that close these two paths.
_WIDTH_STD = 0.5
# Relative standard deviation of the load over the resolution ratio of the heights.
_RESOLUTION_STD = 0.1
# Widths of paths: two cells, one cell, and one point.
_BLOCKS, _SIDES, _CORNERS = range(3)


@attrs.frozen(eq=False)
class Percolation(ShownAsPrinted):
    """The load and the contact area at which the last open path through the gap closes.

    Attributes
    ----------
    pressure
        Nominal mean pressure, Pa.
    area_fraction
        Real over nominal contact area.
    last_open, first_closed
        The solutions that enclose it: the last with an open path, through sides of cells, and the first without any.
    axis
        0: the path joins the sides of smallest and largest x; 1: of y.
    """

    pressure: Estimate
    area_fraction: Estimate
    last_open: ContactSolution
    first_closed: ContactSolution
    axis: int

    def __str__(self) -> str:
        return f"closed along {'xy'[self.axis]} from {self.pressure} on; contact area over nominal {self.area_fraction}"


@guarded
def find_percolation(problem: ContactProblem, *, axis: int = 0, within: float = 0.01) -> Percolation:
    """Return the load at which the last open path between two opposite sides closes.

    Liquid passes through sides of cells. Paths that are two cells wide close at a lighter load, paths through corners
    at a heavier one: the distance of these loads gives the uncertainty by the grid.

    Parameters
    ----------
    problem
        The contact.
    axis
        0: between the sides of smallest and largest x; 1: of y.
    within
        Relative distance of two loads at which the search ends.

    Raises
    ------
    InputError
        If no load closes all paths, or no load leaves one open.
    NotConverged
        If a contact does not converge.

    Examples
    --------
    >>> import roughcontact as rc
    >>> from roughcontact.responses import find_percolation
    >>> wave = rc.WavySurface(amplitude=1e-6, wavelength=50e-6)
    >>> body = rc.Body(wave, rc.Elastic(young=210e9, poisson=0.3))
    >>> problem = rc.ContactProblem(body, grid=rc.Grid((32, 32), 100e-6), boundary="periodic")
    >>> found = find_percolation(problem)
    >>> print(found.pressure)
    6.8 GPa +- 1.8 %
    """
    if not isinstance(problem, ContactProblem):
        raise InputError.about("What is solved", problem, "a ContactProblem")
    axis = flow_axis(axis)
    within = number(within, "within=", above=0.0, at_most=1.0)
    enclose = partial(_enclose, problem, axis)
    coarse = max(within, _WIDTH_TOLERANCE)
    first, above = enclose(_SIDES, math.inf)
    last = above if not _is_open(above, axis, _CORNERS) else enclose(_CORNERS, math.inf, above)[1]
    low, high = enclose(_SIDES, within, first, last)
    narrowed, _ = enclose(_BLOCKS, coarse, first, low)
    _, passed = enclose(_CORNERS, coarse, high, last)
    value = math.sqrt(low.mean_pressure * high.mean_pressure)
    unresolved = _RESOLUTION_STD * curvature_resolution(low)
    std = math.hypot(_WIDTH_STD * (passed.mean_pressure - narrowed.mean_pressure), unresolved * value)
    areas = [solution.area(uncertainty="model") for solution in (narrowed, low, high, passed)]
    fraction = 0.5 * (areas[1].fraction + areas[2].fraction)
    own = areas[1].uncertainty / low.grid.area
    spread = math.hypot(_WIDTH_STD * (areas[3].fraction - areas[0].fraction), unresolved * fraction, own)
    warnings = tuple(dict.fromkeys(text for area in areas for text in area.warnings))
    return Percolation(Estimate(value, std, "Pa"), Estimate(fraction, spread, "", warnings), low, high, axis)


def _enclose(
    problem: ContactProblem, axis: int, width: int, within: float, *known: ContactSolution
) -> tuple[ContactSolution, ContactSolution]:
    """Return the last contact with an open path of a width and the first without any, at loads that differ by `within`.

    They are searched above a known open contact, or between it and one that counts as closed.
    """
    if len(known) == 2 and known[0] is known[1]:
        return known[0], known[1]
    maximum = maximum_pressure(problem.plan)
    slope = rms_slope(problem.initial_gap, problem.plan.grid)
    guess = min(_FIRST_PRESSURE_RATIO * problem.plan.modulus * slope, 0.5 * maximum)

    def read(x: float, solution: ContactSolution) -> TriedLoad[None]:
        counted = [solution is one for one in known]
        is_open = counted.index(True) == 0 if any(counted) else _is_open(solution, axis, width)
        return TriedLoad(x, -math.inf if is_open else math.inf, 0.0, None)

    search = LoadSearch(
        solve=partial(run_solve, problem),
        read=read,
        unit=Load("pressure", guess),
        ends=(guess / _MAX_LOAD_FACTOR, min(guess * _MAX_LOAD_FACTOR, maximum)),
        width=math.log1p(within),
        rises=True,
        factor=_LOAD_STEP_FACTOR,
    )
    if known:
        search.run_from(known)
    else:
        search.run(0.0)
    if search.bracket is not None:
        low, high = (search.solutions[one.x] for one in search.bracket)
        return low, high
    lowest, highest = (si(search.load_at(search.tried[place].x), "Pa") for place in (0, -1))
    if search.tried[0].off < 0.0:
        raise InputError(f"The two sides are joined even at a mean pressure of {highest}.")
    raise InputError(f"No path joins the two sides even at a mean pressure of {lowest}.")


def _is_open(solution: ContactSolution, axis: int, width: int) -> bool:
    """Return whether a path of a width joins the two sides."""
    open_cells = find_open_cells(solution, fill_gap(solution).values)
    periodic = not solution.boundary.free_axes[1 - axis]
    open_cells = open_cells if axis == 0 else open_cells.T
    if width == _BLOCKS:
        # Blocks of two by two cells, each at its first cell.
        open_cells = open_cells[:-1] & open_cells[1:]
        open_cells = open_cells & np.roll(open_cells, -1, axis=1)
        open_cells = open_cells if periodic else open_cells[:, :-1]
    return bool(find_paths(open_cells, periodic=periodic, corners=width == _CORNERS).any())
