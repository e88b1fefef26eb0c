"""Checks that solve again: by another solver, on other cells, to another tolerance."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import attrs
import numpy as np

from roughcontact.errors import InputError, NotConverged
from roughcontact.problem import ContactProblem
from roughcontact.refinement import on_grid
from roughcontact.solution import ContactSolution
from roughcontact.solvers import ProjectedConjugateGradient, SpectralGradient
from roughcontact.stability.examined import Examined
from roughcontact.stability.moved import half_a_cell_aside
from roughcontact.stability.report import Check, judged, left_out

# Grids that the slower solver is asked for, its patience, and the smallest that are worth halving.
_MOST_CELLS = 2**18
_PATIENCE = 3000
_FEWEST = 16
_TIGHTER = 100.0

_QUANTITIES = ("area", "peak pressure", "approach or load")


def float32_inside(examined: Examined) -> Check:
    """Compare with a solver that works in float64 throughout."""
    name, solution = "float32 inside", examined.solution
    solver = examined.problem.plan.solver
    if not isinstance(solver, ProjectedConjugateGradient):
        return left_out(name, f"{type(solver).__name__} does not work in float32")
    if solution.grid.cells > _MOST_CELLS:
        return left_out(name, "the solver in float64 takes too long beyond 512 x 512 cells")
    other = SpectralGradient(solver.tolerance, _PATIENCE)
    try:
        slow = examined.again(attrs.evolve(examined.problem, solver=other))
    except NotConverged as error:
        return left_out(name, f"the solver in float64 did not get there: {error.solution.status}")
    if not solution.contact.any():
        return left_out(name, "nothing touches")
    off = float(np.abs(slow.pressure - solution.pressure).max() / solution.pressure.max())
    found = f"greatest difference of pressures over the peak; {slow.iterations} iterations of spectral-gradient"
    return judged(name, off, found)


def half_the_cells(examined: Examined) -> list[Check]:
    """Solve on every second cell."""
    return _compared("half the cells", examined, _halved)


def half_a_cell(examined: Examined) -> list[Check]:
    """Solve with the cells elsewhere."""
    return _compared("half a cell aside", examined, half_a_cell_aside)


def tighter(examined: Examined) -> list[Check]:
    """Solve to a hundredth of the tolerance."""
    return _compared("tolerance / 100", examined, _tightened)


def _halved(problem: ContactProblem) -> ContactProblem:
    nx, ny = problem.plan.grid.shape
    if nx % 2 or ny % 2 or min(nx, ny) < _FEWEST:
        raise InputError(f"Half the cells need even counts of at least {_FEWEST} along both axes.")
    shape = (nx // 2, ny // 2)
    try:
        return on_grid(problem, shape)
    except InputError:
        # A map that is not known between its points has means over its cells nevertheless.
        return on_grid(problem, shape, "mean")


def _tightened(problem: ContactProblem) -> ContactProblem:
    solver: Any = problem.plan.solver
    if not (attrs.has(type(solver)) and "tolerance" in attrs.fields_dict(type(solver))):
        raise InputError(f"{type(solver).__name__} takes no tolerance.")
    return attrs.evolve(problem, solver=attrs.evolve(solver, tolerance=solver.tolerance / _TIGHTER))


def _compared(name: str, examined: Examined, change: Callable[[ContactProblem], ContactProblem]) -> list[Check]:
    """Return what changes of area, peak pressure and response."""
    names = [f"{name}: {quantity}" for quantity in _QUANTITIES]
    try:
        problem = change(examined.problem)
        solution = examined.again(problem)
    except InputError as error:
        return [left_out(each, str(error)) for each in names]
    except NotConverged as error:
        return [left_out(each, f"the other solve did not converge: {error.solution.status}") for each in names]
    before = _answers(examined, examined.solution, examined.problem.summit)
    after = _answers(examined, solution, problem.summit)
    checks = []
    for each, (was, unit), (becomes, _) in zip(names, before, after, strict=True):
        if was == 0.0:
            checks.append(left_out(each, "nothing touches"))
        else:
            found = f"relative change, from {was:.5g} to {becomes:.5g} {unit}"
            checks.append(judged(each, abs(becomes / was - 1.0), found))
    return checks


def _answers(examined: Examined, solution: ContactSolution, summit: float) -> list[tuple[float, str]]:
    """Return area, peak pressure, and approach or load, with their units."""
    # Where the sampled summits are lower the bodies touch later: one datum for both approaches.
    approach = solution.approach + (examined.problem.summit - summit)
    response = (approach, "m") if examined.load.approach is None else (solution.force, "N")
    return [(solution.area().value, "m2"), (float(solution.pressure.max()), "Pa"), response]
