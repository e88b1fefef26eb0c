"""One contact on slabs: the solve, and its solution."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any, cast

import attrs
import roughcontact as rc
from roughcontact.typing import (
    GridLevel,
    Load,
    PreparedConvolution,
    Residuals,
    SolvePlan,
    Step,
    bind_kernel,
    confirm,
    make_task,
    replacing,
    require_certified,
    require_memory_of_solve,
    si,
)

from roughcontact_mpi.arrays import SlabArray
from roughcontact_mpi.convolver import SlabFFT
from roughcontact_mpi.files import write_field
from roughcontact_mpi.patches import SlabPatches
from roughcontact_mpi.processes import Processes
from roughcontact_mpi.store import SUFFIX, require_place, write_store
from roughcontact_mpi.surfaces import make_heights
from roughcontact_mpi.windows import WindowSolution, gather, open_window

# Cells along the sides of the small grid on which materials, kernel and boundary are checked.
_SCENE_CELLS = 8
# The area estimators whose text asks the other processes.
_ESTIMATORS = ("blend", "cell-count", "hertz", "level-set", "level-set-richardson", "perimeter")


@attrs.frozen(eq=False, kw_only=True)
class SlabSolution:
    """The solution of a contact: its numbers on each process, and its fields by slab.

    Attributes
    ----------
    grid, boundary
        The domain.
    modulus
        Contact modulus E*, Pa.
    pressure_limit
        Maximum pressure, Pa; `inf` without a hardness.
    pressure
        Contact pressure, shape (nx, ny), Pa.
    displacement
        Displacement that it causes, shape (nx, ny), m.
    initial_gap
        Gap before deformation, shape (nx, ny), m.
    scene, plan, load, convolution
        The problem on a small grid, its plan, the load, and the convolution that solved it.
    approach
        Approach since first touch, m.
    status, residuals
        The certificate, recomputed in float64 from the pressure alone.
    iterations, convolutions
        Iterations, and convolutions on the finest grid or work of the same cost.
    errors
        The solver's error before each iteration.
    levels
        The work on each grid.
    seconds
        Wall time, s.
    """

    grid: rc.Grid
    boundary: rc.Boundary
    modulus: float
    pressure_limit: float
    pressure: SlabArray = attrs.field(repr=False)
    displacement: SlabArray = attrs.field(repr=False)
    initial_gap: SlabArray = attrs.field(repr=False)
    scene: rc.ContactProblem = attrs.field(repr=False)
    plan: SolvePlan = attrs.field(repr=False)
    load: Load
    convolution: PreparedConvolution = attrs.field(repr=False)
    approach: float
    status: rc.Status
    residuals: Residuals
    iterations: int
    convolutions: int
    errors: tuple[float, ...] = attrs.field(repr=False)
    levels: tuple[GridLevel, ...] = attrs.field(repr=False)
    seconds: float
    _found: dict[str, rc.Estimate] = attrs.field(factory=dict, init=False, repr=False)

    @property
    def gap(self) -> SlabArray:
        """Gap after deformation, shape (nx, ny), m."""
        return cast(SlabArray, self.displacement + self.initial_gap - self.approach)

    @property
    def force(self) -> float:
        """Normal force, N; all processes must ask."""
        return float(self.pressure.sum()) * self.grid.cell_area

    @property
    def mean_pressure(self) -> float:
        """Nominal mean pressure, Pa; all processes must ask."""
        return float(self.pressure.mean())

    @cached_property
    def _window(self) -> WindowSolution:
        return open_window(self)

    def area(self, estimator: str = "blend") -> rc.Area:
        """Return the real contact area; all processes must ask.

        Parameters
        ----------
        estimator
            Name of an area estimator of roughcontact.
        """
        if estimator not in _ESTIMATORS:
            raise rc.InputError.about("The area estimator on slabs", estimator, f"one of {', '.join(_ESTIMATORS)}")
        return self._window.area(estimator)

    def peak_pressure(self) -> rc.Estimate:
        """Return the maximum pressure between the cells, Pa; all processes must ask."""
        return self._window.peak_pressure()

    def stiffness(self) -> rc.Estimate:
        """Return the normal stiffness dF/d(approach), N/m, by one more solve; all processes must ask."""
        if "stiffness" not in self._found:
            self._found["stiffness"] = self._window.stiffness()
        return self._found["stiffness"]

    @property
    def patches(self) -> SlabPatches:
        """The connected patches of the contact; all processes must ask."""
        return self._window.patches.public

    def gather(self) -> rc.ContactSolution | None:
        """Return the whole solution on the first process, certified anew there, with every answer; None on the others.

        It must fit into the memory of that process. All processes must ask.
        """
        return gather(self)

    @property
    def numbers(self) -> dict[str, Any]:
        """The numbers of the solution, SI units, with the stiffness once it was asked for; all processes must ask."""
        counted = self.area("cell-count")
        area = self.area()
        peak = self.peak_pressure()
        stiffness = {name: found.value for name, found in self._found.items()}
        stiffness |= {f"{name}_uncertainty": found.uncertainty for name, found in self._found.items()}
        return stiffness | {
            "shape": list(self.grid.shape),
            "size": list(self.grid.size),
            "boundary": str(self.boundary),
            "processes": self.pressure.processes.count,
            "status": self.status.name,
            "force": self.force,
            "mean_pressure": self.mean_pressure,
            "maximum_pressure": float(self.pressure.max()),
            "peak_pressure": peak.value,
            "peak_pressure_uncertainty": peak.uncertainty,
            "approach": self.approach,
            "area": area.value,
            "area_uncertainty": area.uncertainty,
            "counted_area": counted.value,
            "patches": self.patches.count,
            "contact_modulus": self.modulus,
            "iterations": self.iterations,
            "convolutions": self.convolutions,
            "residuals": {
                "complementarity": self.residuals.complementarity,
                "penetration": self.residuals.penetration,
                "load": self.residuals.load,
            },
            "seconds": self.seconds,
        }

    def describe(self) -> str:
        """Return the numbers in words; all processes must ask."""
        numbers = self.numbers
        slabs = f"{numbers['processes']} processes"
        rows = (
            ("grid", f"{self.grid}, boundary {self.boundary}, {slabs}"),
            ("status", f"{self.status}; {self.residuals}"),
            ("force", si(numbers["force"], "N", 6)),
            (
                "pressure",
                f"mean {si(numbers['mean_pressure'], 'Pa', 6)}, maximum {si(numbers['maximum_pressure'], 'Pa', 6)}",
            ),
            ("peak", str(self.peak_pressure())),
            ("approach", si(self.approach, "m", 6)),
            ("area", str(self.area())),
            ("counted", f"{si(numbers['counted_area'], 'm2', 6)} in {numbers['patches']} patches"),
            *((name, str(found)) for name, found in self._found.items()),
            ("work", f"{self.iterations} iterations, {self.convolutions} convolutions, {self.seconds:.3g} s"),
        )
        return "\n".join(f"{label:<10} {text}" for label, text in rows)

    def save(self, folder: str | Path) -> None:
        """Write pressure, displacement and gap to .npy files, each process its rows, and the numbers to numbers.json.

        Parameters
        ----------
        folder
            A folder on a disk of all processes; it is made if it is not there. Or a zarr store, ``NAME.zarr``, which
            gets the initial gap too, and the numbers as attributes.

        Raises
        ------
        InputError
            If something else is there.
        MissingPackage
            Of a store, if zarr is not installed.
        """
        folder = Path(folder)
        require_place(folder)
        if folder.suffix == SUFFIX:
            write_store(folder, self)
            return
        processes = self.pressure.processes
        if processes.rank == 0:
            folder.mkdir(parents=True, exist_ok=True)
        processes.communicator.Barrier()
        for name in ("pressure", "displacement", "gap"):
            write_field(folder / f"{name}.npy", getattr(self, name))
        numbers = self.numbers
        if processes.rank == 0:
            with replacing(folder / "numbers.json") as partial:
                partial.write_text(json.dumps(numbers, indent=2) + "\n", encoding="utf-8")


def solve(
    heights: SlabArray | rc.SelfAffineSurface,
    size: float | str | Sequence[float | str] | rc.Grid,
    material: rc.Material | str,
    counterbody: rc.Material | str | None = None,
    *,
    pressure: float | str | None = None,
    force: float | str | None = None,
    approach: float | str | None = None,
    boundary: str | Sequence[str] = "free",
    kernel: str | rc.InfluenceKernel = "love",
    tolerance: float | None = None,
    on_step: Callable[[Step], None] | None = None,
    throw: bool = True,
) -> SlabSolution:
    """Solve the contact of heights in slabs with a flat counterbody, by the default solver; all processes must call it.

    Parameters
    ----------
    heights
        Heights, shape (nx, ny), m, as of `read_heights`, or of ``SlabArray.field(own_rows, processes, nx)`` with the
        rows ``processes.own_rows(nx)``; of two rough bodies the sum of both. Or a self-affine surface; see
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
        An influence kernel.
    tolerance
        Tolerance of the solver.
    on_step
        Called with a `Step` after each iteration.
    throw
        Whether to raise when the solver does not converge, or to return the unfinished solution.

    Raises
    ------
    InputError
        If something does not fit together, or the bodies cannot carry the load.
    NotConverged
        If the solution is not certified and `throw` is true.
    """
    started = time.perf_counter()
    load = Load.of(pressure=pressure, force=force, approach=approach)
    if isinstance(heights, rc.Surface):
        heights = make_heights(heights, cast(rc.Grid, size))
    if not isinstance(heights, SlabArray) or not heights.is_divided or heights.ndim != 2:
        raise rc.InputError.about("The heights", heights, "an array in slabs, as read_heights returns it")
    heights.processes.meet("solve")
    grid = size if isinstance(size, rc.Grid) else rc.Grid(cast(tuple[int, int], heights.shape), cast(Any, size))
    if grid.shape != heights.shape:
        raise rc.InputError.about("The grid", grid.shape, f"of the shape of the heights, {heights.shape}")
    solver = rc.ProjectedConjugateGradient() if tolerance is None else rc.ProjectedConjugateGradient(tolerance)
    scene, plan = _plan(heights, grid, material, counterbody, boundary, kernel, solver)
    # The plan has the gap, and the heights may go; arrays in slabs follow numpy's protocols.
    del heights
    gap: Any = plan.initial_gap
    convolver = cast(SlabFFT, plan.convolver)
    convolution = convolver.prepare(bind_kernel(plan), grid, plan.boundary)
    task = attrs.evolve(make_task(plan, gap, load), on_step=on_step)
    outcome = solver.solve(convolution, task)
    certificate = confirm(plan, convolution, task, outcome)
    fields: Any = certificate
    solution = SlabSolution(
        grid=grid,
        boundary=plan.boundary,
        modulus=plan.modulus,
        pressure_limit=float(plan.pressure_limit),
        pressure=fields.pressure,
        displacement=fields.displacement,
        initial_gap=gap,
        scene=scene,
        plan=plan,
        load=load,
        convolution=convolution,
        approach=certificate.approach,
        status=certificate.status,
        residuals=certificate.residuals,
        iterations=outcome.iterations,
        convolutions=outcome.convolutions + 1,
        errors=outcome.errors,
        levels=outcome.levels,
        seconds=time.perf_counter() - started,
    )
    if throw:
        require_certified(solution)
    return solution


def _plan(
    heights: SlabArray,
    grid: rc.Grid,
    material: rc.Material | str,
    counterbody: rc.Material | str | None,
    boundary: str | Sequence[str],
    kernel: str | rc.InfluenceKernel,
    solver: rc.Solver,
) -> tuple[rc.ContactProblem, SolvePlan]:
    """Return the problem on a few cells, on which materials, kernel and boundary are checked, and the plan of all."""
    processes = heights.processes
    few = rc.Grid((_SCENE_CELLS, _SCENE_CELLS), tuple(_SCENE_CELLS * step for step in grid.spacing))
    flat = rc.FlatSurface()
    problem = rc.ContactProblem(
        rc.Body(rc.SphereSurface(max(few.size)), material),
        rc.RIGID_FLAT if counterbody is None else rc.Body(flat, counterbody),
        grid=few,
        boundary=boundary,
        kernel=kernel,
        solver=solver,
    )
    scene = problem.plan
    convolver = SlabFFT(processes, gathers=False)
    convolver.require(scene.kernel, scene.boundary)
    if scene.pressure_limit.ndim:
        raise rc.InputError("On slabs the hardness must be one number for all cells.")
    _require_memory(processes, grid, scene.boundary)
    summit = float(heights.max())
    gap = summit - heights
    height = float(gap.max())
    if not height > 0.0:
        raise rc.InputError("The heights are all the same: of flat bodies there is nothing to solve.")
    return problem, attrs.evolve(
        scene, grid=grid, initial_gap=cast(Any, gap), peak_to_valley=height, convolver=convolver
    )


def _require_memory(processes: Processes, grid: rc.Grid, boundary: rc.Boundary) -> None:
    """Refuse a contact of which the slabs of one machine do not fit into its memory."""
    own = processes.own_rows(grid.shape[0])
    rows = processes.rows_of_machine(own.stop - own.start)
    if rows:
        require_memory_of_solve(rc.Grid((rows, grid.shape[1]), grid.size), boundary)
