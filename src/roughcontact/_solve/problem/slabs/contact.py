"""One contact solved by several processes, each with a slab of the domain; how they talk is left to plug-ins."""

from __future__ import annotations

import abc
import time
from collections.abc import Callable, Sequence
from typing import Any, ClassVar, TypeVar, final

import attrs
import numpy as np

from roughcontact._parts.grid import Boundary, Grid, Load
from roughcontact._parts.kernels import InfluenceKernel
from roughcontact._parts.materials import Material
from roughcontact._parts.surfaces import FlatSurface, HeightMap, SelfAffineSurface, SphereSurface, Surface
from roughcontact._solve.convolvers import Convolver, PreparedConvolution
from roughcontact._solve.problem.body import RIGID_FLAT, Body
from roughcontact._solve.problem.certificate import certify, confirm, make_solution
from roughcontact._solve.problem.plan import SolvePlan
from roughcontact._solve.problem.problem import ContactProblem
from roughcontact._solve.problem.run import require_certified
from roughcontact._solve.problem.slabs.arrays import SlabArray
from roughcontact._solve.problem.slabs.processes import SlabProcesses
from roughcontact._solve.problem.slabs.transforms import make_random_rows
from roughcontact._solve.problem.task import bind_kernel, make_task
from roughcontact._solve.solution import ContactSolution, Estimate, Origin, Whole, areas, responses
from roughcontact._solve.solvers import Outcome, ProjectedConjugateGradient, Solver, Step, Task
from roughcontact.errors import InputError
from roughcontact.errors.door import guarded

T = TypeVar("T")

# Cells along the sides of the small grid on which materials, kernel and boundary are checked.
_SCENE_CELLS = 8


@attrs.frozen(eq=False)
class Slabs(Whole):
    """What holds a solution together whose fields, `SlabArray`, are divided among processes.

    Attributes
    ----------
    scene, plan, load, convolution
        The problem on a few cells, its plan and load, and the convolution that solved it.
    answers
        The area estimators and responses that it can be asked for.
    """

    is_whole: ClassVar[bool] = False
    answers: ClassVar[tuple[str, ...]] = ()

    scene: ContactProblem
    plan: SolvePlan
    load: Load
    convolution: PreparedConvolution
    _answered: dict[str, Any] = attrs.field(factory=dict, init=False)

    def open(self, solution: Any) -> Any:
        """Return the solution on what this process has of it, with the part that asks the other ones."""
        return solution

    @final
    def window(self, solution: Any) -> Any:
        """Return what `open` does, once for each solution."""
        return solution._keep("window", lambda: self.open(solution))

    @final
    def ask(self, solution: Any, answer: Any, find: Callable[[Any], T]) -> T:
        """Return what a function finds of the solution on what this process has of it; all processes must ask."""
        known = {(areas if name in areas else responses)[name] for name in self.answers}
        if type(answer) not in known:
            asked = answer if isinstance(answer, str) else type(answer).__name__
            served = f"one of {', '.join(self.answers)}; solution.gather() has all"
            allowed = served if self.answers else "asked of solution.gather() instead"
            raise InputError.about("What is asked of a contact on slabs", asked, allowed)
        found = find(self.window(solution))
        self._answered[type(answer).__name__] = found
        return found

    def list_rows(self, solution: Any) -> dict[str, str]:
        """Return what each process holds, and the stiffness if it was asked for, in words."""
        processes = solution.pressure.processes
        heights = np.diff(processes.rows(solution.grid.shape[0]))
        number = f"{heights.min()} to {heights.max()}" if np.ptp(heights) else str(heights[0])
        slabs = f"{processes.count} processes, {number} rows on each" if processes.count > 1 else "1 process"
        stiffness = self._answered.get("Stiffness")
        return {"slabs": slabs} if stiffness is None else {"slabs": slabs, "stiffness": str(stiffness)}

    def list_numbers(self, solution: Any) -> dict[str, Any]:
        """Return the number of processes, and the numbers of their answers."""
        found = {"processes": (solution.pressure.processes.count, "")}
        stiffness: Estimate | None = self._answered.get("Stiffness")
        return found if stiffness is None else {**found, "stiffness": stiffness}

    def gather(self, solution: Any) -> ContactSolution | None:
        """Return the whole solution on the first process, certified anew there; None on the others."""
        pressure = solution.pressure.gather()
        gap = solution.initial_gap.gather()
        if pressure is None or gap is None:
            return None
        body = Body(HeightMap(-gap, solution.grid.size), self.scene.body.material)
        problem = attrs.evolve(self.scene, body=body, grid=None)
        task = make_task(problem.plan, problem.initial_gap, self.load, pressure)
        outcome = Outcome(
            pressure=np.zeros(gap.shape) if task.start is None else task.start,
            status=solution.status,
            iterations=solution.iterations,
            convolutions=solution.convolutions - 1,
            errors=solution.errors,
            levels=solution.levels,
        )
        found = certify(problem.plan, problem.convolution, problem.initial_gap, task, outcome, seconds=solution.seconds)
        return attrs.evolve(found, origin=Origin(problem.parts, self.load.arguments, source=problem))


class SlabContacts(abc.ABC):
    """How contacts are solved on slabs: a plug-in says by which processes, on which arrays and by which solver."""

    processes: ClassVar[type[SlabProcesses]] = SlabProcesses
    array: ClassVar[type[SlabArray]] = SlabArray
    slabs: ClassVar[type[Slabs]] = Slabs

    @classmethod
    @abc.abstractmethod
    def make_convolver(cls, processes: Any) -> Convolver:
        """Return the convolver of slabs."""

    @classmethod
    def make_solver(cls, tolerance: float) -> Solver:
        """Return the solver."""
        return ProjectedConjugateGradient(tolerance)

    @classmethod
    @abc.abstractmethod
    def require_memory(cls, processes: Any, grid: Grid, boundary: Boundary) -> None:
        """Refuse a contact that the processes, or their memory, do not allow."""

    @classmethod
    def rescue(cls, scene: ContactProblem, plan: SolvePlan, task: Task, outcome: Outcome) -> Outcome:
        """Return what is to be certified where the solver did not succeed."""
        return outcome

    @final
    @classmethod
    @guarded
    def make_heights(cls, surface: SelfAffineSurface, grid: Grid, processes: Any = None) -> Any:
        """Return the heights of a random surface in slabs, m, those of ``surface.heights(grid)`` but for rounding.

        Each process draws all random numbers, and keeps those of its waves: none has the whole field.

        Parameters
        ----------
        surface
            A self-affine surface.
        grid
            The grid, shape (nx, ny).
        processes
            The processes; None: all that were started.

        Raises
        ------
        InputError
            If it is another surface, its waves do not fit the grid, or the processes are too many.
        """
        processes = cls.processes() if processes is None else processes
        if not isinstance(surface, SelfAffineSurface):
            raise InputError.about("The surface on slabs", surface, "a SelfAffineSurface, or its heights in slabs")
        if not isinstance(grid, Grid):
            raise InputError.about("The grid", grid, "an rc.Grid, which has the cells and the size")
        processes.require(grid.shape)
        processes.meet("make_heights")
        return cls.array.field(make_random_rows(surface, grid, processes), processes, grid.shape[0])

    @final
    @classmethod
    @guarded
    def solve(
        cls,
        heights: Any,
        size: float | str | Sequence[float | str] | Grid,
        material: Material | str,
        counterbody: Material | str | None = None,
        *,
        pressure: float | str | None = None,
        force: float | str | None = None,
        approach: float | str | None = None,
        boundary: str | Sequence[str] = "free",
        kernel: str | InfluenceKernel = "love",
        tolerance: float | None = None,
        on_step: Callable[[Step], None] | None = None,
        throw: bool = True,
        processes: Any = None,
    ) -> ContactSolution:
        """Solve the contact of heights in slabs with a flat counterbody; all processes must call it.

        The fields of the solution are slabs: each process has the rows ``solution.pressure.part``. Its numbers, its
        text and what it answers are the same on all processes, which must ask together; ``solution.gather()`` returns
        the whole one on the first process.

        Parameters
        ----------
        heights
            Heights in slabs, shape (nx, ny), m: an array of the plug-in, made by ``.field(own_rows, processes, nx)``
            with the rows ``processes.own_rows(nx)``; of two rough bodies the sum of both. Or a self-affine surface; see
            `make_heights`.
        size
            Length of the domain along x and y, or of both sides, m; of a surface the grid.
        material, counterbody
            Materials of the rough body and of the flat one; by default this one is rigid. One hardness for all cells.
        pressure, force, approach
            Exactly one load: nominal mean pressure, Pa; normal force, N; approach since first touch, m.
        boundary
            ``"free"`` or ``"periodic"``, or a pair of them, for x and y.
        kernel
            An influence kernel that has a spectrum.
        tolerance
            Tolerance of the solver.
        on_step
            Called with a `Step` after each iteration or verification, on each process.
        throw
            Whether to raise when the solver does not converge, or to return the unfinished solution.
        processes
            The processes of a surface; None: all that were started.

        Raises
        ------
        InputError
            If something does not fit together, or the bodies cannot carry the load.
        NotConverged
            If the solution is not certified and `throw` is true.
        """
        load = Load.of(pressure=pressure, force=force, approach=approach)
        if isinstance(heights, Surface):
            heights = cls.make_heights(heights, size, processes)  # type: ignore[arg-type]
        if not isinstance(heights, cls.array) or not heights.is_divided or heights.ndim != 2:
            allowed = f"a {cls.array.__name__}, an array in slabs as of read_heights, or a SelfAffineSurface"
            raise InputError.about("The heights", heights, allowed)
        heights.processes.meet("solve")
        grid = size if isinstance(size, Grid) else Grid(heights.shape, size)
        if grid.shape != heights.shape:
            raise InputError.about("The grid", grid.shape, f"of the shape of the heights, {heights.shape}")
        scene = _make_scene(grid, material, counterbody, boundary, kernel, tolerance)
        plan = cls._plan(heights, scene, grid)
        # The plan has the gap.
        del heights
        solution = cls._solve(scene, plan, load, on_step)
        if throw:
            require_certified(solution)
        return solution

    @classmethod
    def _plan(cls, heights: Any, scene: ContactProblem, grid: Grid) -> SolvePlan:
        """Return the plan of heights in slabs."""
        convolver = cls.make_convolver(heights.processes)
        convolver.require(scene.plan.kernel, scene.plan.boundary)
        cls.require_memory(heights.processes, grid, scene.plan.boundary)
        # Where heights are not finite, the gap is not either.
        with np.errstate(invalid="ignore"):
            gap = float(heights.max()) - heights
            height = float(gap.max())
        if not np.isfinite(height):
            raise InputError("The heights are not all finite: on slabs points that were not measured must be filled.")
        if not height > 0.0:
            raise InputError("The heights are all the same: of flat bodies there is nothing to solve.")
        solver = cls.make_solver(scene.plan.solver.tolerance)
        return attrs.evolve(
            scene.plan, grid=grid, initial_gap=gap, peak_to_valley=height, convolver=convolver, solver=solver
        )

    @classmethod
    def _solve(
        cls, scene: ContactProblem, plan: SolvePlan, load: Load, on_step: Callable[[Step], None] | None
    ) -> ContactSolution:
        """Return the solution of a plan, with its certificate."""
        started = time.perf_counter()
        convolution = plan.convolver.prepare(bind_kernel(plan), plan.grid, plan.boundary)
        task = attrs.evolve(make_task(plan, plan.initial_gap, load), on_step=on_step)
        outcome = plan.solver.solve(convolution, task)
        if not outcome.status.success:
            outcome = cls.rescue(scene, plan, task, outcome)
        certificate = confirm(plan, convolution, task, outcome)
        found = make_solution(plan, plan.initial_gap, outcome, certificate, time.perf_counter() - started)
        return attrs.evolve(found, parts=cls.slabs(scene, plan, load, convolution))


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
