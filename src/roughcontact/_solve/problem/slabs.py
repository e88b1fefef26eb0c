"""One contact solved by several processes, each with a slab of the domain; how they talk is left to plug-ins."""

from __future__ import annotations

import contextlib
import sys
import time
import traceback
from collections.abc import Callable, Iterator, Sequence
from typing import Any, ClassVar

import attrs
import numpy as np

from roughcontact._base.arrays import Array
from roughcontact._parts.grid import Boundary, Grid, Load
from roughcontact._parts.kernels import InfluenceKernel
from roughcontact._parts.materials import Material
from roughcontact._parts.surfaces import FlatSurface, HeightMap, SelfAffineSurface, SphereSurface
from roughcontact._solve.convolvers import Convolver, PreparedConvolution
from roughcontact._solve.problem.body import RIGID_FLAT, Body
from roughcontact._solve.problem.plan import SolvePlan
from roughcontact._solve.problem.problem import ContactProblem
from roughcontact._solve.problem.run import ConfirmedFields, certify, confirm, make_solution, require_certified
from roughcontact._solve.problem.task import bind_kernel, make_task
from roughcontact._solve.solution import ContactSolution, GridLevel, Origin, Residuals, Status
from roughcontact._solve.solvers import Outcome, ProjectedConjugateGradient, Solver, Step, Task, halve_shape
from roughcontact.errors import InputError, NotConverged, RoughContactError, UnexpectedError
from roughcontact.errors.door import guarded

# Cells along the sides of the small grid on which materials, kernel and boundary are checked.
_SCENE_CELLS = 8
# Seconds for which the first process goes first, so that an error of all appears once.
_PRECEDENCE = 1.0
# Exit status of a process that was interrupted.
_INTERRUPTED = 130


class SlabProcesses:
    """The processes that solve one contact: rows and columns of each. Subclasses let them talk.

    Each calls the same functions in the same order, and gets the same numbers.

    Attributes
    ----------
    rank, count
        The number of this process, from zero on, and of all.
    name
        What is named before the sentence of an error.
    """

    name: ClassVar[str] = "roughcontact"
    rank: int = 0
    count: int = 1

    @staticmethod
    def share(count: int, parts: int) -> tuple[int, ...]:
        """Return the bounds of nearly equal parts of a number of things."""
        return tuple(part * count // parts for part in range(parts + 1))

    def rows(self, count: int) -> tuple[int, ...]:
        """Return the bounds of the rows of all processes, for a number of rows of the domain.

        They are shared on the coarsest grid, so that the rows of a process are those of its rows on the next one.
        """
        coarse = self.coarsest_rows(count)
        return tuple(bound * (count // coarse) for bound in self.share(coarse, self.count))

    def coarsest_rows(self, count: int) -> int:
        """Return the rows of the coarsest grid, for a number of rows of the domain."""
        while (half := halve_shape((count, 2))[0]) < count:
            count = half
        return count

    def own_rows(self, count: int) -> slice:
        """Return the rows of this process."""
        bounds = self.rows(count)
        return slice(bounds[self.rank], bounds[self.rank + 1])

    def columns(self, count: int) -> tuple[int, ...]:
        """Return the bounds of the columns of all processes, for a number of columns."""
        return self.share(count, self.count)

    def own_columns(self, count: int) -> slice:
        """Return the columns of this process."""
        bounds = self.columns(count)
        return slice(bounds[self.rank], bounds[self.rank + 1])

    def require_random(self, surface: object, grid: object) -> None:
        """Raise `InputError` unless each process can make its rows of the heights of a surface on a grid."""
        if not isinstance(surface, SelfAffineSurface):
            raise InputError.about("The surface on slabs", surface, "a SelfAffineSurface, or its heights in slabs")
        if not isinstance(grid, Grid):
            raise InputError.about("The grid", grid, "an rc.Grid, which has the cells and the size")

    def end(self, status: int) -> None:
        """End all processes with an exit status."""
        sys.exit(status)

    @contextlib.contextmanager
    def ending_all(self) -> Iterator[None]:
        """End all processes, with one sentence, when one of them fails inside the context: the others would wait.

        The exit status is 1 if there is no certified answer or the error is not one of the user, else 2.
        """
        try:
            yield
        except KeyboardInterrupt:
            self.end(_INTERRUPTED)
        except Exception as error:
            if self.rank:
                time.sleep(_PRECEDENCE)
            if isinstance(error, RoughContactError):
                status = 1 if isinstance(error, (NotConverged, UnexpectedError)) else 2
            else:
                status = 1
                traceback.print_exc()
            where = f"process {self.rank} of {self.count}"
            print(f"{self.name}: {error} ({where})", file=sys.stderr, flush=True)
            self.end(status)


@attrs.frozen(eq=False, kw_only=True)
class SolveRecord:
    """The numbers of a solve whose fields are of a kind of their own.

    Attributes
    ----------
    load
        The load.
    approach
        Approach since first touch, m.
    status, residuals
        The certificate, recomputed in float64 from the pressure alone.
    iterations, convolutions
        Iterations, and convolutions on the finest grid or work of the same cost.
    errors
        The solver's error at each verification.
    levels
        The work on each grid.
    seconds
        Wall time, s.
    """

    load: Load
    approach: float
    status: Status
    residuals: Residuals
    iterations: int
    convolutions: int
    errors: tuple[float, ...] = attrs.field(repr=False)
    levels: tuple[GridLevel, ...] = attrs.field(repr=False)
    seconds: float

    @staticmethod
    def numbers_of(load: Load, outcome: Outcome, certificate: ConfirmedFields, started: float) -> dict[str, Any]:
        """Return the fields of a record; `started` is the reading of `time.perf_counter` at the start of the solve."""
        return {
            "load": load,
            "approach": certificate.approach,
            "status": certificate.status,
            "residuals": certificate.residuals,
            "iterations": outcome.iterations,
            "convolutions": outcome.convolutions + 1,
            "errors": outcome.errors,
            "levels": outcome.levels,
            "seconds": time.perf_counter() - started,
        }

    def outcome(self, pressure: Array) -> Outcome:
        """Return what the solver has found, with this pressure."""
        return Outcome(
            pressure=pressure,
            status=self.status,
            iterations=self.iterations,
            convolutions=self.convolutions - 1,
            errors=self.errors,
            levels=self.levels,
        )

    def to_solution(self, plan: SolvePlan, initial_gap: Array, pressure: Array, displacement: Array) -> ContactSolution:
        """Return the solution with fields as arrays of numpy, shape (nx, ny); its certificate is not computed again.

        Parameters
        ----------
        plan
            The plan that was solved.
        initial_gap, pressure, displacement
            Gap before deformation, m; contact pressure, Pa; the displacement that it causes, m.
        """
        certificate = ConfirmedFields(
            pressure=pressure,
            displacement=displacement,
            approach=self.approach,
            status=self.status,
            residuals=self.residuals,
        )
        return make_solution(plan, initial_gap, self.outcome(pressure), certificate, self.seconds)

    def require_certified(self) -> None:
        """Raise `NotConverged` if the solution is not certified."""
        require_certified(self)


@attrs.frozen(eq=False, kw_only=True)
class SlabSolution(SolveRecord):
    """The solution of a contact: its numbers on each process, and its fields by slab.

    Attributes
    ----------
    pressure
        Contact pressure, shape (nx, ny), Pa.
    displacement
        Displacement that it causes, shape (nx, ny), m.
    initial_gap
        Gap before deformation, shape (nx, ny), m.
    scene, plan, convolution
        The problem on a small grid, its plan, and the convolution that solved it.
    """

    pressure: Any = attrs.field(repr=False)
    displacement: Any = attrs.field(repr=False)
    initial_gap: Any = attrs.field(repr=False)
    scene: ContactProblem = attrs.field(repr=False)
    plan: SolvePlan = attrs.field(repr=False)
    convolution: PreparedConvolution = attrs.field(repr=False)

    @property
    def grid(self) -> Grid:
        """The grid."""
        return self.plan.grid

    @property
    def boundary(self) -> Boundary:
        """What lies beyond the border."""
        return self.plan.boundary

    @property
    def modulus(self) -> float:
        """Contact modulus E*, Pa."""
        return self.plan.modulus

    @property
    def pressure_limit(self) -> float:
        """Maximum pressure, Pa; `inf` without a hardness."""
        return float(self.plan.pressure_limit)

    @property
    def gap(self) -> Any:
        """Gap after deformation, shape (nx, ny), m."""
        return self.displacement + self.initial_gap - self.approach

    @property
    def force(self) -> float:
        """Normal force, N; all processes must ask."""
        return float(self.pressure.sum()) * self.grid.cell_area

    @property
    def mean_pressure(self) -> float:
        """Nominal mean pressure, Pa; all processes must ask."""
        return float(self.pressure.mean())

    def certify_whole(self, pressure: Array | None, gap: Array | None) -> ContactSolution | None:
        """Return the whole solution, certified anew, from gathered fields; None on a process that has none."""
        if pressure is None or gap is None:
            return None
        body = Body(HeightMap(-gap, self.grid.size), self.scene.body.material)
        problem = attrs.evolve(self.scene, body=body, grid=None)
        task = make_task(problem.plan, problem.initial_gap, self.load, pressure)
        outcome = self.outcome(np.zeros(gap.shape) if task.start is None else task.start)
        found = certify(problem.plan, problem.convolution, problem.initial_gap, task, outcome, seconds=self.seconds)
        return attrs.evolve(found, origin=Origin(problem.parts, self.load.arguments, source=problem))


@guarded
def plan_slabs(
    heights: Any,
    size: float | str | Sequence[float | str] | Grid,
    material: Material | str,
    counterbody: Material | str | None = None,
    *,
    boundary: str | Sequence[str],
    kernel: str | InfluenceKernel,
    tolerance: float | None,
    convolver: Convolver,
    require: Callable[[Grid, Boundary], None],
    solver: Callable[[float], Solver] = ProjectedConjugateGradient,
) -> tuple[ContactProblem, SolvePlan]:
    """Return the problem on a few cells, and the plan of heights in slabs; all processes must call it.

    The plan has the gap, and the heights may go.

    Parameters
    ----------
    heights
        Heights, shape (nx, ny), m, of an array that follows numpy's protocols.
    size
        Length of the domain along x and y, or of both sides, m; or the grid.
    material, counterbody
        Materials of the rough body and of the flat one; by default this one is rigid. One hardness for all cells.
    boundary, kernel, tolerance
        As of `ContactProblem` and of its solver.
    convolver
        The convolver of slabs.
    require
        Called with the grid and its boundary before anything of their size is made; it refuses what the processes, or
        their memory, do not allow.
    solver
        Makes the solver from its tolerance.

    Raises
    ------
    InputError
        If something does not fit together, or the heights are not finite, or all the same.
    """
    grid = size if isinstance(size, Grid) else Grid(heights.shape, size)
    if grid.shape != heights.shape:
        raise InputError.about("The grid", grid.shape, f"of the shape of the heights, {heights.shape}")
    scene = _make_scene(grid, material, counterbody, boundary, kernel, tolerance)
    convolver.require(scene.plan.kernel, scene.plan.boundary)
    require(grid, scene.plan.boundary)
    # Where heights are not finite, the gap is not either.
    with np.errstate(invalid="ignore"):
        gap = float(heights.max()) - heights
        height = float(gap.max())
    if not np.isfinite(height):
        raise InputError("The heights are not all finite: on slabs points that were not measured must be filled.")
    if not height > 0.0:
        raise InputError("The heights are all the same: of flat bodies there is nothing to solve.")
    chosen = solver(scene.plan.solver.tolerance)
    plan = attrs.evolve(
        scene.plan, grid=grid, initial_gap=gap, peak_to_valley=height, convolver=convolver, solver=chosen
    )
    return scene, plan


@guarded
def solve_slabs(
    kind: type[SlabSolution],
    scene: ContactProblem,
    plan: SolvePlan,
    load: Load,
    *,
    on_step: Callable[[Step], None] | None = None,
    throw: bool = True,
    rescue: Callable[[ContactProblem, SolvePlan, Task, Outcome], Outcome] | None = None,
) -> Any:
    """Return the certified solution of a plan of heights in slabs; all processes must call it.

    Parameters
    ----------
    kind
        The class of the solution.
    scene, plan
        The problem; see `plan_slabs`.
    load, on_step, throw
        As of `ContactProblem.solve`.
    rescue
        Called where the solver did not succeed, with the problem, the dimensionless task and what was found; returns
        what is to be certified instead.

    Raises
    ------
    InputError
        If the bodies cannot carry the load.
    NotConverged
        If the solution is not certified and `throw` is true.

    Examples
    --------
    One process, whose slab is an array of numpy:

    >>> import roughcontact as rc
    >>> from roughcontact.solving import SlabSolution, plan_slabs, solve_slabs
    >>> from roughcontact.typing import Load
    >>> heights = rc.WavySurface(1e-6, 50e-6).heights(rc.Grid((64, 64), 100e-6))
    >>> options = {"boundary": "periodic", "kernel": "love", "tolerance": None, "convolver": rc.CircularFFT()}
    >>> scene, plan = plan_slabs(heights, 100e-6, "glass", require=lambda grid, boundary: None, **options)
    >>> solution = solve_slabs(SlabSolution, scene, plan, Load.of(pressure=50e6))
    >>> solution.status.success, round(solution.mean_pressure)
    (True, 50000000)
    """
    started = time.perf_counter()
    convolution = plan.convolver.prepare(bind_kernel(plan), plan.grid, plan.boundary)
    task = attrs.evolve(make_task(plan, plan.initial_gap, load), on_step=on_step)
    outcome = plan.solver.solve(convolution, task)
    if rescue is not None and not outcome.status.success:
        outcome = rescue(scene, plan, task, outcome)
    certificate = confirm(plan, convolution, task, outcome)
    solution = kind(
        **SolveRecord.numbers_of(load, outcome, certificate, started),
        pressure=certificate.pressure,
        displacement=certificate.displacement,
        initial_gap=plan.initial_gap,
        scene=scene,
        plan=plan,
        convolution=convolution,
    )
    if throw:
        solution.require_certified()
    return solution


def _make_scene(
    grid: Grid,
    material: Material | str,
    counterbody: Material | str | None,
    boundary: str | Sequence[str],
    kernel: str | InfluenceKernel,
    tolerance: float | None,
) -> ContactProblem:
    """Return the problem on a few cells of the grid, on which materials, kernel and boundary are checked."""
    few = Grid((_SCENE_CELLS, _SCENE_CELLS), tuple(_SCENE_CELLS * step for step in grid.spacing))
    problem = ContactProblem(
        Body(SphereSurface(max(few.size)), material),
        RIGID_FLAT if counterbody is None else Body(FlatSurface(), counterbody),
        grid=few,
        boundary=boundary,
        kernel=kernel,
        solver=ProjectedConjugateGradient() if tolerance is None else ProjectedConjugateGradient(tolerance),
    )
    if problem.plan.pressure_limit.ndim:
        raise InputError("On slabs the hardness must be one number for all cells.")
    return problem
