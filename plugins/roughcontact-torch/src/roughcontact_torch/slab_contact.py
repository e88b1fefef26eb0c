"""How contacts are solved on slabs of several devices: by the masked solver."""

from __future__ import annotations

import itertools
from typing import Any, cast

import attrs
import numpy as np
import roughcontact as rc
import torch
from roughcontact.errors import NotEnoughMemory
from roughcontact.results import SolvePlan
from roughcontact.slabs import SlabContacts
from roughcontact.solving import bind_kernel, require_memory_of_solve
from roughcontact.typing import Outcome, Task, binary

from roughcontact_torch.masked import MaskedConjugateGradient
from roughcontact_torch.processes import Processes
from roughcontact_torch.slab_arrays import SlabTensor
from roughcontact_torch.slab_convolver import SlabTorchFFT


class Contacts(SlabContacts):
    """Contacts on slabs of several devices."""

    processes = Processes
    array = SlabTensor

    @classmethod
    def make_convolver(cls, processes: Processes) -> SlabTorchFFT:
        """Return the convolver of slabs."""
        return SlabTorchFFT(processes)

    @classmethod
    def make_solver(cls, tolerance: float) -> rc.Solver:
        """Return the masked solver."""
        return MaskedConjugateGradient(tolerance)

    @classmethod
    def require_memory(cls, processes: Processes, grid: rc.Grid, boundary: rc.Boundary) -> None:
        """Refuse, on all processes, a contact of too few rows for them, or whose slab does not fit on a device."""
        processes.require(grid.shape)
        own = processes.own_rows(grid.shape[0])
        arrays = MaskedConjugateGradient().memory_arrays(boundary)
        needed = processes.across(np.maximum, 8.0 * arrays * (own.stop - own.start) * grid.shape[1])
        left = processes.across(np.minimum, processes.memory_left())
        if needed > left:
            raise NotEnoughMemory(
                f"A solve on {' x '.join(map(str, grid.shape))} cells, boundary {boundary}, needs {binary(needed)} of "
                f"memory for the slab of a process, but a device has only {binary(left)} left: start more processes, "
                "each with a device, or choose fewer cells."
            )

    @classmethod
    def rescue(cls, scene: rc.ContactProblem, plan: SolvePlan, task: Task, stalled: Outcome) -> Outcome:
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
        gap, start = (cast(SlabTensor, cast(Any, one)).gather() for one in (task.initial_gap, stalled.pressure))
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
        rows = processes.exchange(
            sent, counts, [0 if other else field.tensor.numel() for other in range(processes.count)]
        )
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
