"""A contact on slabs as the estimators of one machine see it: by windows, on each process its own."""

from __future__ import annotations

import attrs
import numpy as np
import roughcontact as rc
from roughcontact.typing import Array, PreparedConvolution

from roughcontact_mpi.arrays import SlabArray
from roughcontact_mpi.parts import Part
from roughcontact_mpi.patches import WindowPatches, label_slabs, window_patches


@attrs.frozen(eq=False, kw_only=True)
class WindowSolution(rc.ContactSolution):
    """The solution of a contact on the rows of a window; its grid and its numbers are those of the whole domain."""

    parts: Part = attrs.field(repr=False)  # type: ignore[misc]
    patches: WindowPatches = attrs.field(repr=False)
    convolution: PreparedConvolution = attrs.field(repr=False)

    @property
    def force(self) -> float:
        """Normal force, N; all processes must ask."""
        return self.parts.total(float(self.pressure[self.parts.inside].sum())) * self.grid.cell_area

    @property
    def warnings(self) -> tuple[str, ...]:
        """None: what fields are warned of needs those of the whole domain, which `SlabSolution.gather` returns."""
        return ()


def open_window(solution: rc.solving.SlabSolution) -> WindowSolution:
    """Return a solution on the window of this process."""
    plan = solution.plan
    part = Part(solution.pressure.processes, plan.grid.shape, plan.boundary)
    pressure, displacement, initial_gap = (
        part.read(field) for field in (solution.pressure, solution.displacement, solution.initial_gap)
    )
    labels, touching, count = label_slabs(part, solution.pressure, plan.grid, plan.boundary)
    patches = window_patches(part, labels, touching, count, pressure, plan.grid, plan.boundary)
    base = solution.to_solution(plan, initial_gap, pressure, displacement)
    fields = attrs.asdict(base, recurse=False)
    return WindowSolution(**fields, parts=part, patches=patches, convolution=solution.convolution)


def gather_rows(field: SlabArray) -> Array | None:
    """Return all rows of a field on the first process."""
    processes = field.processes
    counts = [field.shape[1] * rows if processes.rank == 0 else 0 for rows in np.diff(processes.rows(field.shape[0]))]
    sent = [field.part.size if rank == 0 else 0 for rank in range(processes.count)]
    found = processes.exchange(np.ascontiguousarray(field.part).ravel(), sent, [int(count) for count in counts])
    return found.reshape(field.shape) if processes.rank == 0 else None
