"""One contact on slabs of several devices: the heights, the solve, and its solution."""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable, Sequence
from typing import Any, cast

import attrs
import numpy as np
import roughcontact as rc
import torch
from roughcontact.errors import NotEnoughMemory
from roughcontact.typing import (
    GridLevel,
    Load,
    Origin,
    Outcome,
    Residuals,
    SolvePlan,
    Step,
    Task,
    binary,
    bind_kernel,
    certify,
    confirm,
    make_task,
    require_certified,
    require_memory_of_solve,
)

from roughcontact_torch.masked import MaskedConjugateGradient
from roughcontact_torch.processes import Processes
from roughcontact_torch.slab_arrays import SlabTensor
from roughcontact_torch.slab_convolver import SlabTorchFFT
from roughcontact_torch.slab_grid import Transpose

# Cells along the sides of the small grid on which materials, kernel and boundary are checked.
_SCENE_CELLS = 8


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
        Contact pressure, shape (nx, ny), Pa; `tensor` has the rows of this process, on its device.
    displacement
        Displacement that it causes, shape (nx, ny), m.
    initial_gap
        Gap before deformation, shape (nx, ny), m.
    scene, plan, load
        The problem on a small grid, its plan, and the load.
    approach
        Approach since first touch, m.
    status, residuals
        The certificate, recomputed in float64 from the pressure alone, by sums over all processes.
    iterations, convolutions
        Iterations, and convolutions on the finest grid or work of the same cost.
    errors
        The solver's errors by verification.
    levels
        The work on each grid.
    seconds
        Wall time, s.
    """

    grid: rc.Grid
    boundary: rc.Boundary
    modulus: float
    pressure_limit: float
    pressure: SlabTensor = attrs.field(repr=False)
    displacement: SlabTensor = attrs.field(repr=False)
    initial_gap: SlabTensor = attrs.field(repr=False)
    scene: rc.ContactProblem = attrs.field(repr=False)
    plan: SolvePlan = attrs.field(repr=False)
    load: Load
    approach: float
    status: rc.Status
    residuals: Residuals
    iterations: int
    convolutions: int
    errors: tuple[float, ...] = attrs.field(repr=False)
    levels: tuple[GridLevel, ...] = attrs.field(repr=False)
    seconds: float

    @property
    def gap(self) -> SlabTensor:
        """Gap after deformation, shape (nx, ny), m."""
        return cast(SlabTensor, self.displacement + self.initial_gap - self.approach)

    @property
    def mean_pressure(self) -> float:
        """Nominal mean pressure, Pa; all processes must ask."""
        return float(self.pressure.mean())

    @property
    def force(self) -> float:
        """Normal force, N; all processes must ask."""
        return float(self.pressure.sum()) * self.grid.cell_area

    @property
    def contact_cells(self) -> int:
        """Number of cells in contact; all processes must ask."""
        contact: Any = self.pressure > 0.0
        return int(np.count_nonzero(contact))

    def gather(self) -> rc.ContactSolution | None:
        """Return the whole solution on the first process, certified anew there, with every answer; None on the others.

        It must fit into the memory of the device of that process and of its host. All processes must ask.
        """
        pressure, gap = (_gather(field) for field in (self.pressure, self.initial_gap))
        if pressure is None or gap is None:
            return None
        body = rc.Body(rc.HeightMap(-gap, self.grid.size), self.scene.body.material)
        problem = attrs.evolve(self.scene, body=body, grid=None)
        task = make_task(problem.plan, problem.initial_gap, self.load, pressure)
        outcome = Outcome(
            pressure=np.zeros(gap.shape) if task.start is None else task.start,
            status=self.status,
            iterations=self.iterations,
            convolutions=self.convolutions - 1,
            errors=self.errors,
            levels=self.levels,
        )
        found = certify(problem.plan, problem.convolution, problem.initial_gap, task, outcome, seconds=self.seconds)
        return attrs.evolve(found, origin=Origin(problem.parts, self.load.arguments, source=problem))


def _gather(field: SlabTensor) -> np.ndarray | None:
    """Return all rows of a field on the first process."""
    rows = field.processes.gather_rows(field.tensor, field.rows, first=True)
    return None if rows is None else rows.numpy(force=True)


def solve_on_slabs(
    heights: SlabTensor | rc.SelfAffineSurface,
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
    processes: Processes | None = None,
) -> SlabSolution:
    """Solve the contact of heights in slabs with a flat counterbody, by the masked solver; all processes must call it.

    Parameters
    ----------
    heights
        Heights, shape (nx, ny), m: ``SlabTensor.field(own_rows, processes, nx)`` with the rows
        ``processes.own_rows(nx)``; of two rough bodies the sum of both. Or a self-affine surface; see `make_heights`.
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
        Called with a `Step` after each verification, on each process.
    throw
        Whether to raise when the solver does not converge, or to return the unfinished solution.
    processes
        The processes of a surface; None: all that `torchrun` has started.

    Raises
    ------
    InputError
        If something does not fit together, or the bodies cannot carry the load.
    NotConverged
        If the solution is not certified and `throw` is true. Where the error no longer falls, the default solver
        continues on the processor of the first process, if its memory suffices.
    """
    started = time.perf_counter()
    load = Load.of(pressure=pressure, force=force, approach=approach)
    if isinstance(heights, rc.Surface):
        heights = make_heights(heights, cast(rc.Grid, size), processes)
    if not isinstance(heights, SlabTensor) or heights.ndim != 2:
        raise rc.InputError.about("The heights", heights, "a SlabTensor, or a SelfAffineSurface")
    shape = cast(tuple[int, int], heights.shape)
    grid = size if isinstance(size, rc.Grid) else rc.Grid(shape, cast(Any, size))
    if grid.shape != shape:
        raise rc.InputError.about("The grid", grid.shape, f"of the shape of the heights, {shape}")
    scene, plan = _plan(heights, grid, material, counterbody, boundary, kernel, tolerance)
    # The plan has the gap, and the heights may go.
    del heights
    gap: Any = plan.initial_gap
    convolution = plan.convolver.prepare(bind_kernel(plan), grid, plan.boundary)
    task = attrs.evolve(make_task(plan, gap, load), on_step=on_step)
    outcome = plan.solver.solve(convolution, task)
    if not outcome.status.success:
        outcome = _continue_on_one(scene.plan, plan, task, outcome)
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


def _continue_on_one(scene: SolvePlan, plan: SolvePlan, task: Task, stalled: Outcome) -> Outcome:
    """Return the outcome of the default solver on the first process, from a descent that did not end, on slabs.

    If it does not fit into the memory there, that of the descent is returned.
    """
    field = cast(SlabTensor, cast(Any, stalled.pressure))
    processes = field.processes
    fits = 1
    if processes.rank == 0:
        try:
            require_memory_of_solve(plan.grid, plan.boundary)
        except NotEnoughMemory:
            fits = 0
    if processes.total(fits) != processes.count:
        return stalled
    gap, start = (_gather(cast(SlabTensor, cast(Any, one))) for one in (task.initial_gap, stalled.pressure))
    found = stalled
    sent = field.tensor.new_empty(0)
    if gap is not None:
        given = start if stalled.status is rc.Status.STALLED else None
        convolution = scene.convolver.prepare(bind_kernel(plan), plan.grid, plan.boundary)
        found = scene.solver.solve(convolution, attrs.evolve(task, initial_gap=gap, start=given))
        sent = torch.tensor(found.pressure, dtype=field.tensor.dtype, device=processes.device).reshape(-1)
    first = processes.rank == 0
    nx, ny = plan.grid.shape
    counts = [ny * (stop - start) if first else 0 for start, stop in itertools.pairwise(processes.rows(nx))]
    rows = processes.exchange(sent, counts, [0 if other else field.tensor.numel() for other in range(processes.count)])
    statuses = list(rc.Status)
    own = (statuses.index(found.status), found.iterations, found.convolutions, len(found.errors))
    number, iterations, convolutions, length = (int(one) for one in processes.total(np.array(own) * first))
    errors = processes.total(np.array(found.errors) if first else np.zeros(length))
    status = statuses[number]
    return attrs.evolve(
        stalled,
        pressure=cast(Any, SlabTensor.field(rows.reshape(field.tensor.shape), processes, nx)),
        status=rc.Status.RESCUED if status is rc.Status.CONVERGED else status,
        iterations=stalled.iterations + iterations,
        convolutions=stalled.convolutions + convolutions,
        errors=stalled.errors + tuple(float(one) for one in errors),
    )


def _require_memory(processes: Processes, grid: rc.Grid, boundary: rc.Boundary) -> None:
    """Refuse a contact of which the slab of a process does not fit on its device, on all processes."""
    own = processes.own_rows(grid.shape[0])
    arrays = MaskedConjugateGradient().memory_arrays(boundary)
    needed = processes.across(np.maximum, 8.0 * arrays * (own.stop - own.start) * grid.shape[1])
    left = processes.across(np.minimum, processes.memory_left())
    if needed > left:
        raise NotEnoughMemory(
            f"A solve on {' x '.join(map(str, grid.shape))} cells, boundary {boundary}, needs {binary(needed)} of "
            f"memory for the slab of a process, but a device has only {binary(left)} left: start more processes, each "
            "with a device, or choose fewer cells."
        )


def _plan(
    heights: SlabTensor,
    grid: rc.Grid,
    material: rc.Material | str,
    counterbody: rc.Material | str | None,
    boundary: str | Sequence[str],
    kernel: str | rc.InfluenceKernel,
    tolerance: float | None,
) -> tuple[rc.ContactProblem, SolvePlan]:
    """Return the problem on a few cells, on which materials, kernel and boundary are checked, and the plan of all."""
    processes = heights.processes
    few = rc.Grid((_SCENE_CELLS, _SCENE_CELLS), tuple(_SCENE_CELLS * step for step in grid.spacing))
    default = rc.ProjectedConjugateGradient()
    default = default if tolerance is None else attrs.evolve(default, tolerance=tolerance)
    problem = rc.ContactProblem(
        rc.Body(rc.SphereSurface(max(few.size)), material),
        rc.RIGID_FLAT if counterbody is None else rc.Body(rc.FlatSurface(), counterbody),
        grid=few,
        boundary=boundary,
        kernel=kernel,
        solver=default,
    )
    scene = problem.plan
    convolver = SlabTorchFFT(processes)
    convolver.require(scene.kernel, scene.boundary)
    processes.require(grid.shape)
    _require_memory(processes, grid, scene.boundary)
    if scene.pressure_limit.ndim:
        raise rc.InputError("On slabs the hardness must be one number for all cells.")
    finite: Any = np.isfinite(cast(Any, heights))
    if not finite.all():
        raise rc.InputError("The heights are not all finite: on slabs points that were not measured must be filled.")
    highest = float(heights.max())
    gap: Any = highest - heights
    height = float(gap.max())
    if not height > 0.0:
        raise rc.InputError("The heights are all the same: of flat bodies there is nothing to solve.")
    return problem, attrs.evolve(
        scene,
        grid=grid,
        initial_gap=gap,
        peak_to_valley=height,
        convolver=convolver,
        solver=MaskedConjugateGradient(tolerance=scene.solver.tolerance),
    )


def make_heights(surface: rc.SelfAffineSurface, grid: rc.Grid, processes: Processes | None = None) -> SlabTensor:
    """Return the heights of a random surface, m, those of ``surface.heights(grid)`` but for rounding.

    Each process draws all random numbers, and keeps those of its waves: none has the whole field.

    Parameters
    ----------
    surface
        A self-affine surface.
    grid
        The grid, shape (nx, ny).
    processes
        The processes; None: all that `torchrun` has started.

    Raises
    ------
    InputError
        If it is another surface, its waves do not fit the grid, or there are more processes than rows.
    """
    if not isinstance(surface, rc.SelfAffineSurface):
        raise rc.InputError.about("The surface on slabs", surface, "a SelfAffineSurface, or its heights a SlabTensor")
    if not isinstance(grid, rc.Grid):
        raise rc.InputError.about("The grid", grid, "an rc.Grid, which has the cells and the size")
    processes = Processes() if processes is None else processes
    processes.require(grid.shape)
    nx, ny = grid.shape
    columns = processes.own_columns(ny // 2 + 1)
    half = torch.tensor(surface.half_spectrum(grid, columns, processes.across), device=processes.device)
    transpose = Transpose(processes, processes.rows(nx), processes.columns(ny // 2 + 1))
    waves = transpose.back(torch.fft.ifft(half, dim=0, norm="forward")[None])
    return SlabTensor.field(torch.fft.irfft(waves[0], n=ny, dim=-1, norm="forward"), processes, nx)
