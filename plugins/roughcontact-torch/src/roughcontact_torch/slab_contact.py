"""One contact on slabs of several devices: the heights, the solve, and its solution."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, cast

import attrs
import numpy as np
import roughcontact as rc
import torch
from roughcontact.errors import NotEnoughMemory
from roughcontact.results import SolvePlan
from roughcontact.solving import bind_kernel, plan_slabs, require_memory_of_solve, solve_slabs
from roughcontact.typing import Load, Outcome, Step, Task, binary

from roughcontact_torch.masked import MaskedConjugateGradient
from roughcontact_torch.processes import Processes
from roughcontact_torch.slab_arrays import SlabTensor
from roughcontact_torch.slab_convolver import SlabTorchFFT
from roughcontact_torch.slab_grid import Transpose


@attrs.frozen(eq=False, kw_only=True)
class SlabSolution(rc.solving.SlabSolution):
    """The solution of a contact: its numbers on each process, and its fields, `SlabTensor`, by slab.

    The `tensor` of a field has the rows of this process, on its device.
    """

    @property
    def contact_cells(self) -> int:
        """Number of cells in contact; all processes must ask."""
        contact: Any = self.pressure > 0.0
        return int(np.count_nonzero(contact))

    def gather(self) -> rc.ContactSolution | None:
        """Return the whole solution on the first process, certified anew there, with every answer; None on the others.

        It must fit into the memory of the device of that process and of its host. All processes must ask.
        """
        return self.certify_whole(*(_gather(field) for field in (self.pressure, self.initial_gap)))


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
    load = Load.of(pressure=pressure, force=force, approach=approach)
    if isinstance(heights, rc.Surface):
        heights = make_heights(heights, cast(rc.Grid, size), processes)
    if not isinstance(heights, SlabTensor) or heights.ndim != 2:
        raise rc.InputError.about("The heights", heights, "a SlabTensor, or a SelfAffineSurface")
    own = heights.processes
    scene, plan = plan_slabs(
        heights,
        size,
        material,
        counterbody,
        boundary=boundary,
        kernel=kernel,
        tolerance=tolerance,
        convolver=SlabTorchFFT(own),
        require=partial(_require_room, own),
        solver=MaskedConjugateGradient,
    )
    # The plan has the gap.
    del heights
    return solve_slabs(SlabSolution, scene, plan, load, on_step=on_step, throw=throw, rescue=_continue_on_one)


def _continue_on_one(scene: rc.ContactProblem, plan: SolvePlan, task: Task, stalled: Outcome) -> Outcome:
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
        convolution = scene.plan.convolver.prepare(bind_kernel(plan), plan.grid, plan.boundary)
        found = scene.plan.solver.solve(convolution, attrs.evolve(task, initial_gap=gap, start=given))
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


def _require_room(processes: Processes, grid: rc.Grid, boundary: rc.Boundary) -> None:
    """Refuse, on all processes, a contact of too few rows for them, or whose slab does not fit on a device."""
    processes.require(grid.shape)
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
    processes = Processes() if processes is None else processes
    processes.require_random(surface, grid)
    processes.require(grid.shape)
    nx, ny = grid.shape
    columns = processes.own_columns(ny // 2 + 1)
    half = torch.tensor(surface.half_spectrum(grid, columns, processes.across), device=processes.device)
    transpose = Transpose(processes, processes.rows(nx), processes.columns(ny // 2 + 1))
    waves = transpose.back(torch.fft.ifft(half, dim=0, norm="forward")[None])
    return SlabTensor.field(torch.fft.irfft(waves[0], n=ny, dim=-1, norm="forward"), processes, nx)
