"""How stable a solution is: checks of fields, of the kernel, and by solving again."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from typing import Any

import attrs
import numpy as np
import scipy

from roughcontact._answers.areas.initial_gap import curvature_resolution
from roughcontact._answers.refinement import on_grid
from roughcontact._base.arrays import Array, IntArray
from roughcontact._base.checks import callback, flag
from roughcontact._base.machine.progress import show_progress, tell_both
from roughcontact._base.units import Force, Length, Pressure
from roughcontact._parts.grid import Boundary, Load
from roughcontact._parts.kernels import BoundKernel, SupportsCoefficients, SupportsSpectrum
from roughcontact._parts.surfaces import HeightMap
from roughcontact._solve.convolvers import periodic_spectrum, wrapped_spectrum
from roughcontact._solve.problem import Body, ContactProblem, SolvePlan
from roughcontact._solve.solution import ContactSolution, Status, find_contact, find_scene
from roughcontact._solve.solvers import ProjectedConjugateGradient, SpectralGradient
from roughcontact._work.reports.stability_report import (
    RULES,
    Check,
    SolvedProblem,
    StabilityReport,
    Verdict,
    assess,
    skip,
)
from roughcontact.errors import InputError, NotConverged
from roughcontact.errors.door import guarded

# Differences of order n of 1/r are n!/r^n times 1/r: 2e-17 for n = 12 beyond 128 cells, below float64's rounding.
_DIFFERENCE_ORDER = 12
_FAR_FIELD_CELLS = 128
# Grid on which both forms are compared, cells a side, and the distance from the loaded cell, cells, within which.
_COMPARISON_CELLS = 64
_NEAR_FIELD_CELLS = 8
# Laplacians after which Love's kernel and its images differ by 3e-15 there, for cells of any aspect.
_LAPLACIAN_COUNT = 4
# Aspect of the cells up to which that grid is square in metres and still small (8 x 64 by 64 cells).
_MAX_ASPECT = 8.0
# Cells a side up to which sums of cosines, whose work grows as the cube of the side, take less than a second.
_MAX_PLAIN_SUM_SIDE = 1024
# Cells at which the displacement is compared; the cell of maximum pressure is added.
_SAMPLED_CELLS = 16
# The solver in float64 runs on up to 512 x 512 cells, where 3000 iterations take about a minute.
MAX_FLOAT64_CELLS = 2**18
_MAX_FLOAT64_ITERATIONS = 3000
# Cells a side below which a grid of half as many is too coarse for a comparison.
_MIN_HALVED_SIDE = 16
# Cells up to which a grid that cannot be halved is doubled: four times as many take seconds.
_MAX_DOUBLED_CELLS = 2**20
# Change between half the cells and all of them, over that between all and twice as many, at second order.
_SECOND_ORDER_RATIO = 4.0
# Parts of the work, and their time over that of the first solve: measured on rough contacts of 128 to 640 cells a side.
_WORK = {
    "the solve": 1.0,
    "kernel and model": 0.3,
    "float32 iterations": 6.0,
    "coarser grid": 0.3,
    "shifted grid": 1.0,
    "tighter tolerance": 0.7,
}


def check_residuals(solved: SolvedProblem) -> list[Check]:
    """Return how the solve ended, the error of the load, and the residuals of the contact conditions."""
    solution = solved.solution
    residuals = solved.solution.residuals
    verdict = Verdict.PASS
    advice = ""
    if solution.status is not Status.CONVERGED:
        verdict = Verdict.ATTENTION if solution.status.success else Verdict.FAIL
        advice = RULES["convergence"].advice
    finding = f"{solution.status}; {solution.iterations} iterations, {solution.convolutions} convolutions"
    gap = "pressure-weighted mean gap in contact, over the scale of the residuals"
    overlap = "maximum overlap outside saturated cells, over the scale of the residuals"
    return [
        Check("convergence", verdict, residuals.error, finding, advice),
        _check_load(solved),
        assess("complementarity", residuals.complementarity, gap),
        assess("penetration", residuals.penetration, overlap),
    ]


def check_model(solved: SolvedProblem) -> list[Check]:
    """Return whether units, domain, grid and half-space suit the contact."""
    plan = solved.problem.plan
    solution = solved.solution
    findings = find_scene(solution.initial_gap, plan.grid, plan.boundary, plan.materials)
    findings += find_contact(solution, plan.materials)
    checks = [
        skip(finding.rule, finding.text)
        if math.isnan(finding.value)
        else assess(finding.rule, finding.value, finding.text)
        for finding in findings
    ]
    return [*checks, _check_resolution(solution)]


def check_area(solution: ContactSolution) -> list[Check]:
    """Return the relative uncertainty of the real contact area, and the number of its warnings."""
    name = "area: uncertainty"
    area = solution.area()
    warnings = assess("area: warnings", len(area.warnings), "; ".join(area.warnings) or "no warnings")
    if not area.value > 0.0:
        return [skip(name, "there is no contact"), warnings]
    finding = f"the area is {100 * area.fraction:.4g} % of nominal; standard deviation over area [{area.estimator}]"
    return [assess(name, area.uncertainty / area.value, finding), warnings]


def _check_load(solved: SolvedProblem) -> Check:
    name = "load balance"
    load = solved.load
    grid = solved.solution.grid
    if load.kind == "approach":
        return skip(name, "the approach is given, and the load follows from it")
    force = load.value if load.kind == "force" else load.value * grid.area
    carried = math.fsum(solved.solution.pressure.ravel()) * grid.cell_area
    return assess(name, abs(carried / force - 1.0), "relative error of the load, summed without rounding")


def _check_resolution(solution: ContactSolution) -> Check:
    name = "cells per wavelength"
    if not solution.contact.any():
        return skip(name, "there is no contact")
    squared = curvature_resolution(solution)
    cells = 2.0 * math.pi / math.sqrt(squared) if squared > 0.0 else math.inf
    return assess(name, cells, "wavelength that dominates the curvature in contact, in cells")


def sum_displacement(problem: ContactProblem, pressure: Array, chosen: IntArray) -> Array:
    """Return the displacement at the cells of flat index `chosen`, m, by plain sums instead of transforms."""
    plan = problem.plan
    table = _bind(plan).responses(plan.grid, plan.boundary)
    sums = []
    for cell in zip(*np.divmod(chosen, pressure.shape[1]), strict=True):
        i, j = (np.abs(np.arange(n) - here) for n, here in zip(pressure.shape, cell, strict=True))
        if plan.boundary is Boundary.WRAPPED:
            i, j = (np.minimum(offsets, offsets.size - offsets) for offsets in (i, j))
        sums.append(float(np.einsum("ij,ij->", table[np.ix_(i, j)], pressure)))
    return np.array(sums)


def check_kernel(solved: SolvedProblem) -> list[Check]:
    """Return the digits that convolution and kernel lose, and whether the two forms of the kernel agree."""
    plan = solved.problem.plan
    return [_check_convolution(solved), _check_coefficients(plan), _check_forms(plan)]


def _check_convolution(solved: SolvedProblem) -> Check:
    """Return the digits that the displacement loses against plain sums."""
    name = "convolution: digits lost"
    solution = solved.solution
    if solution.boundary is Boundary.PERIODIC and max(solution.grid.shape) > _MAX_PLAIN_SUM_SIDE:
        return skip(name, f"plain sums of waves take too long beyond {_MAX_PLAIN_SUM_SIDE} cells a side")
    if not solution.contact.any():
        return skip(name, "there is no contact")
    evenly = np.linspace(0, solution.grid.cells - 1, _SAMPLED_CELLS).astype(np.intp)
    chosen = np.unique(np.append(evenly, solution.pressure.argmax()))
    by_sums = sum_displacement(solved.problem, solution.pressure, chosen)
    largest = float(np.abs(solution.displacement).max())
    error = float(np.abs(by_sums - solution.displacement.ravel()[chosen]).max()) / largest if largest > 0.0 else 0.0
    finding = f"displacement at {chosen.size} cells against plain sums: relative difference {error:.1e}"
    return assess(name, _count_digits(error), finding)


def _check_coefficients(plan: SolvePlan) -> Check:
    """Return the digits that the real-space coefficients lose: far away they are smooth but for rounding."""
    name = "kernel: digits lost"
    if plan.boundary is Boundary.PERIODIC:
        return skip(name, "the boundary is periodic: the spectrum is used, not the coefficients")
    if not isinstance(plan.kernel, SupportsCoefficients):
        return skip(name, "the kernel has no real-space coefficients")
    kernel = _bind(plan)
    gain = math.sqrt(math.comb(2 * _DIFFERENCE_ORDER, _DIFFERENCE_ORDER))
    noise = 0.0
    for axis, cells in enumerate(plan.grid.shape):
        count = max(cells, 2 * _FAR_FIELD_CELLS)
        strip = kernel.coefficients((count, 1) if axis == 0 else (1, count), plan.grid.spacing).ravel()[
            _FAR_FIELD_CELLS:
        ]
        differences = np.diff(strip, _DIFFERENCE_ORDER) / strip[_DIFFERENCE_ORDER // 2 : -_DIFFERENCE_ORDER // 2]
        noise = max(noise, float(np.abs(differences).max()) / gain)
    finding = (
        f"relative noise of the coefficients beyond {_FAR_FIELD_CELLS} cells is {noise:.1e}, "
        f"by differences of order {_DIFFERENCE_ORDER}"
    )
    return assess(name, _count_digits(noise), finding)


def _check_forms(plan: SolvePlan) -> Check:
    """Return the difference of real-space coefficients and spectrum, after Laplacians that remove the images."""
    name = "kernel: two forms"
    for form, words in ((SupportsCoefficients, "real-space coefficients"), (SupportsSpectrum, "spectrum")):
        if not isinstance(plan.kernel, form):
            return skip(name, f"the kernel has one form only: no {words}")
    dx, dy = plan.grid.spacing
    if not 1.0 / _MAX_ASPECT <= dx / dy <= _MAX_ASPECT:
        return skip(name, f"for cells of aspect above {_MAX_ASPECT:g} the comparison would need too large a grid")
    kernel = _bind(plan)
    shape = (round(_COMPARISON_CELLS * max(1.0, dy / dx)), round(_COMPARISON_CELLS * max(1.0, dx / dy)))
    one, other = (
        _apply_laplacians(scipy.fft.irfft2(spectrum(kernel, shape, plan.grid.spacing), s=shape))
        for spectrum in (wrapped_spectrum, periodic_spectrum)
    )
    difference = float(np.abs(one - other)[:_NEAR_FIELD_CELLS, :_NEAR_FIELD_CELLS].max() / np.abs(one).max())
    return assess(name, difference, "relative difference of coefficients and spectrum near the loaded cell")


def _bind(plan: SolvePlan) -> BoundKernel:
    return BoundKernel(plan.kernel, compliance=1.0 / plan.modulus)


def _count_digits(error: float) -> float:
    """Return the decimal digits of float64 that a relative error costs."""
    return max(0.0, math.log10(error / sys.float_info.epsilon)) if error > 0.0 else 0.0


def _apply_laplacians(values: Array) -> Array:
    for _ in range(_LAPLACIAN_COUNT):
        around = sum(np.roll(values, shift, axis) for axis in (0, 1) for shift in (-1, 1))
        values = values - 0.25 * around
    return values


def check_precision(solved: SolvedProblem) -> Check:
    """Return the change of the pressure by a solver that works in float64 throughout."""
    name = "float32 iterations"
    solution = solved.solution
    solver = solved.problem.plan.solver
    if not isinstance(solver, ProjectedConjugateGradient):
        return skip(name, f"{type(solver).__name__} does not work in float32")
    if solution.grid.cells > MAX_FLOAT64_CELLS:
        return skip(name, "the solver in float64 takes too long beyond 512 x 512 cells")
    if not solution.contact.any():
        return skip(name, "there is no contact")
    try:
        # At the default tolerance solvers differ by more than float32 would show.
        problem, single = solved.tighter
        double = SpectralGradient(problem.plan.solver.tolerance, _MAX_FLOAT64_ITERATIONS)
        other = solved.solve_variant(attrs.evolve(problem, solver=double))
    except InputError as error:
        return skip(name, str(error))
    except NotConverged as error:
        return skip(name, f"at the tighter tolerance: {error.solution.status}")
    change = float(np.abs(other.pressure - single.pressure).max() / single.pressure.max())
    finding = f"maximum change of the pressure over its peak; {other.iterations} iterations of spectral-gradient"
    return assess(name, change, finding)


def check_variants(solved: SolvedProblem, begin: Callable[[str], None]) -> list[Check]:
    """Return the changes of area, maximum pressure and approach or load on other grids and to a tighter tolerance.

    `begin` is called with the name of each variant before it is solved.
    """
    variants: dict[str, Callable[[], tuple[ContactProblem, ContactSolution]]] = {
        "coarser grid": lambda: _solve_changed(solved, change_cells),
        "shifted grid": lambda: _solve_changed(solved, shift_half_cell),
        "tighter tolerance": lambda: solved.tighter,
    }
    checks = []
    for variant, solve in variants.items():
        names = [f"{variant}: {quantity}" for quantity in ("area", "maximum pressure", "approach or load")]
        begin(variant)
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
        if nx * ny > _MAX_DOUBLED_CELLS or problem.plan.pressure_limit.ndim:
            raise
    try:
        return on_grid(problem, (2 * nx, 2 * ny))
    except InputError as error:
        raise InputError(f"{reason} Doubling it needs heights between its points. {error}") from error


def halve_cells(problem: ContactProblem) -> ContactProblem:
    """Return the problem on half as many cells along both axes, or raise `InputError`."""
    nx, ny = problem.plan.grid.shape
    if nx % 2 or ny % 2 or min(nx, ny) < _MIN_HALVED_SIDE:
        raise InputError(f"Halving the grid needs even numbers of at least {_MIN_HALVED_SIDE} cells along both axes.")
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
    if plan.boundary.mixed:
        raise InputError("The heights repeat along one axis alone, and are not shifted.")
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
    """Return area, maximum pressure, and approach or load, with their units."""
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
    # Judged like the change to half the cells, whose grid is the coarser one.
    return assess(
        name,
        _SECOND_ORDER_RATIO * abs(old / new - 1.0),
        f"on twice the cells a side, {_SECOND_ORDER_RATIO:g} times the {finding}",
    )


@guarded
def stability(
    problem: ContactProblem,
    *,
    pressure: Pressure | None = None,
    force: Force | None = None,
    approach: Length | None = None,
    on_check: Callable[[str, float], None] | None = None,
    progress: bool = False,
) -> StabilityReport:
    """Return how far a solution depends on rounding, grid and tolerance, and whether the model holds.

    Four more solves: in float64 throughout, on half as many cells a side, on a grid shifted by half a
    cell, and to a thousandth of the tolerance.

    Parameters
    ----------
    problem
        The problem.
    pressure, force, approach
        Exactly one: nominal mean pressure, Pa; normal force, N; approach since first touch, m.
    on_check
        Called before each part of the work with its name and the fraction of the work that is done, about.
    progress
        Whether to show on standard error how far it has come (extra ``progress``).

    Returns
    -------
    StabilityReport
        Checks with measured values and verdicts; a check that cannot be made is skipped, with the reason.

    Raises
    ------
    InputError
        If `problem` is not a `ContactProblem`, not exactly one load is given, or it cannot be carried.

    Examples
    --------
    >>> import roughcontact as rc
    >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
    >>> problem = rc.ContactProblem(ball, grid=rc.Grid((32, 32), 100e-6))
    >>> report = rc.stability(problem, force=1.0)
    >>> print(report.verdict)
    pass
    """
    if not isinstance(problem, ContactProblem):
        raise InputError.about("The problem", problem, "a ContactProblem")
    told = callback(on_check, "on_check=", "name", "fraction")
    with show_progress("stability", shown=flag(progress, "progress=")) as change:
        begin = _count_work(problem, tell_both(told, change))
        return _check_solution(problem, {"pressure": pressure, "force": force, "approach": approach}, begin)


def _check_solution(problem: ContactProblem, load: dict[str, Any], begin: Callable[[str], None]) -> StabilityReport:
    begin("the solve")
    solution = problem.solve(**load, throw=False)
    solved = SolvedProblem(problem, solution, Load.of(**load))
    checks = check_residuals(solved)
    if solution.status.success:
        begin("kernel and model")
        checks += [*check_kernel(solved), *check_model(solved)]
        begin("float32 iterations")
        checks += [check_precision(solved), *check_variants(solved, begin)]
        checks += check_area(solution)
    else:
        checks += [skip(name, "the solution is not converged") for name in list(RULES)[len(checks) :]]
    return StabilityReport(tuple(checks), solution)


def _count_work(problem: ContactProblem, tell: Callable[[str, float], None]) -> Callable[[str], None]:
    """Return a function that says which part of the work begins, and the fraction that is done."""
    work = dict(_WORK)
    if problem.plan.grid.cells > MAX_FLOAT64_CELLS:
        work["float32 iterations"] = 0.0
    names = list(work)

    def begin(name: str) -> None:
        tell(name, sum(work[before] for before in names[: names.index(name)]) / sum(work.values()))

    return begin
