"""Checks that solve again: by another solver, on other grids, to a tighter tolerance."""

from __future__ import annotations

from collections.abc import Callable

import attrs
import numpy as np

from roughcontact._answers.refinement import on_grid
from roughcontact._parts.grid import Boundary
from roughcontact._parts.surfaces import HeightMap
from roughcontact._solve.problem import Body, ContactProblem
from roughcontact._solve.solution import ContactSolution
from roughcontact._solve.solvers import ProjectedConjugateGradient, SpectralGradient
from roughcontact._work.reports.stability.check import Check, SolvedProblem, assess, skip
from roughcontact.errors import InputError, NotConverged

# The solver in float64 runs on up to 512 x 512 cells, where 3000 iterations take about a minute.
_MAX_CELLS = 2**18
_MAX_ITERATIONS = 3000
# Cells a side below which a grid of half as many is too coarse for a comparison.
_MIN_SIDE = 16
# Cells up to which a grid that cannot be halved is doubled: four times as many take seconds.
_MAX_DOUBLED = 2**20
# Change between half the cells and all of them, over that between all and twice as many, at second order.
_ORDER = 4.0


def check_precision(solved: SolvedProblem) -> Check:
    """Return the change of the pressure by a solver that works in float64 throughout."""
    name = "float32 iterations"
    solution = solved.solution
    solver = solved.problem.plan.solver
    if not isinstance(solver, ProjectedConjugateGradient):
        return skip(name, f"{type(solver).__name__} does not work in float32")
    if solution.grid.cells > _MAX_CELLS:
        return skip(name, "the solver in float64 takes too long beyond 512 x 512 cells")
    if not solution.contact.any():
        return skip(name, "there is no contact")
    try:
        # At the default tolerance solvers differ by more than float32 would show.
        problem, single = solved.tighter
        double = SpectralGradient(problem.plan.solver.tolerance, _MAX_ITERATIONS)
        other = solved.solve_variant(attrs.evolve(problem, solver=double))
    except InputError as error:
        return skip(name, str(error))
    except NotConverged as error:
        return skip(name, f"at the tighter tolerance: {error.solution.status}")
    change = float(np.abs(other.pressure - single.pressure).max() / single.pressure.max())
    finding = f"maximum change of the pressure over its peak; {other.iterations} iterations of spectral-gradient"
    return assess(name, change, finding)


def check_variants(solved: SolvedProblem) -> list[Check]:
    """Return the changes of area, peak pressure and approach or load on other grids and to a tighter tolerance."""
    variants: dict[str, Callable[[], tuple[ContactProblem, ContactSolution]]] = {
        "coarser grid": lambda: _solve_changed(solved, change_cells),
        "shifted grid": lambda: _solve_changed(solved, shift_half_cell),
        "tighter tolerance": lambda: solved.tighter,
    }
    checks = []
    for variant, solve in variants.items():
        names = [f"{variant}: {quantity}" for quantity in ("area", "peak pressure", "approach or load")]
        try:
            problem, solution = solve()
        except InputError as error:
            checks += [skip(name, str(error)) for name in names]
        except NotConverged as error:
            checks += [skip(name, f"the other solve: {error.solution.status}") for name in names]
        else:
            before = _answers(solved, solved.solution, solved.problem.summit)
            after = _answers(solved, solution, problem.summit)
            doubled = problem.plan.grid.cells > solved.solution.grid.cells
            checks += [_compare(name, old, new, doubled) for name, old, new in zip(names, before, after, strict=True)]
    return checks


def change_cells(problem: ContactProblem) -> ContactProblem:
    """Return the problem on half as many cells along both axes or, where that cannot be, on twice as many."""
    try:
        return halve_cells(problem)
    except InputError as error:
        nx, ny = problem.plan.grid.shape
        reason = str(error)
        if nx * ny > _MAX_DOUBLED or problem.plan.pressure_limit.ndim:
            raise
    try:
        return on_grid(problem, (2 * nx, 2 * ny))
    except InputError as error:
        raise InputError(f"{reason} Doubling it needs heights between its points. {error}") from error


def halve_cells(problem: ContactProblem) -> ContactProblem:
    """Return the problem on half as many cells along both axes, or raise `InputError`."""
    nx, ny = problem.plan.grid.shape
    if nx % 2 or ny % 2 or min(nx, ny) < _MIN_SIDE:
        raise InputError(f"Halving the grid needs even numbers of at least {_MIN_SIDE} cells along both axes.")
    try:
        return on_grid(problem, (nx // 2, ny // 2))
    except InputError:
        # A map that is not known between its points has means over its cells nevertheless.
        return on_grid(problem, (nx // 2, ny // 2), "mean")


def shift_half_cell(problem: ContactProblem) -> ContactProblem:
    """Return the problem with both surfaces shifted by half a cell along both axes, or raise `InputError`."""
    plan = problem.plan
    if plan.pressure_limit.ndim:
        raise InputError("The pressure limit is an array, which is not known between its cells.")
    if plan.non_measured is not None:
        raise InputError("A surface has non-measured points, which cannot be shifted by half a cell.")
    grid = plan.grid
    periodic = plan.boundary is not Boundary.FREE
    body, counterbody = (
        Body(HeightMap(side.surface.shift_half_cell(grid, periodic=periodic).heights(grid), grid.size), side.material)
        for side in (problem.body, problem.counterbody)
    )
    return attrs.evolve(problem, body=body, counterbody=counterbody, grid=grid)


def _solve_changed(
    solved: SolvedProblem, change: Callable[[ContactProblem], ContactProblem]
) -> tuple[ContactProblem, ContactSolution]:
    problem = change(solved.problem)
    return problem, solved.solve_variant(problem)


def _answers(solved: SolvedProblem, solution: ContactSolution, summit: float) -> list[tuple[float, str]]:
    """Return area, peak pressure, and approach or load, with their units."""
    # Where the sampled summits are lower the bodies touch later: one datum for both approaches.
    approach = solution.approach + (solved.problem.summit - summit)
    response = (solution.force, "N") if solved.load.kind == "approach" else (approach, "m")
    return [(solution.area().value, "m2"), (float(solution.pressure.max()), "Pa"), response]


def _compare(name: str, before: tuple[float, str], after: tuple[float, str], doubled: bool) -> Check:
    old, unit = before
    new, _ = after
    if old == 0.0:
        return skip(name, "there is no contact")
    finding = f"relative change, from {old:.5g} to {new:.5g} {unit}"
    if not doubled:
        return assess(name, abs(new / old - 1.0), finding)
    # Judged like the change of half the cells, which has its error on the other side.
    return assess(name, _ORDER * abs(old / new - 1.0), f"on twice the cells a side, {_ORDER:g} times the {finding}")
