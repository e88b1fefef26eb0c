"""How contacts are solved on slabs under MPI: by the default solver, with the answers of one machine."""

from __future__ import annotations

from typing import Any, ClassVar

import attrs
import roughcontact as rc
from roughcontact.slabs import SlabContacts, Slabs
from roughcontact.solving import require_memory_of_solve

from roughcontact_mpi.convolver import SlabFFT
from roughcontact_mpi.parts import Part
from roughcontact_mpi.patches import SlabPatches, label_slabs, window_patches
from roughcontact_mpi.processes import Processes


class AnsweringSlabs(Slabs):
    """What holds a solution on slabs together: each process opens a window on it, its rows with some beside them."""

    answers: ClassVar[tuple[str, ...]] = (
        *("blend", "cell-count", "hertz", "level-set", "level-set-richardson", "perimeter"),
        *("peak-pressure", "stiffness"),
    )

    def open(self, solution: Any) -> Any:
        """Return the solution on the window of this process."""
        part = Part(solution.pressure.processes, solution.grid.shape, solution.boundary, self.convolution)
        fields = {name: part.read(getattr(solution, name)) for name in ("pressure", "displacement", "initial_gap")}
        labels = label_slabs(part, solution.pressure, solution.grid, solution.boundary)
        part.found = window_patches(part, *labels, fields["pressure"], solution.grid, solution.boundary)
        return attrs.evolve(solution, **fields, parts=part)

    def patches(self, solution: Any) -> SlabPatches:
        """Return the connected patches of the contact; all processes must ask."""
        public: SlabPatches = self.window(solution).patches.public
        return public

    def list_numbers(self, solution: Any) -> dict[str, Any]:
        """Return the numbers of processes and patches, the counted area, and the stiffness if it was asked for."""
        counted = solution.area("cell-count").value, "m2"
        return {**super().list_numbers(solution), "counted_area": counted, "patches": (solution.patches.count, "")}


class Contacts(SlabContacts):
    """Contacts on slabs under MPI."""

    processes = Processes
    slabs = AnsweringSlabs

    @classmethod
    def make_convolver(cls, processes: Processes) -> SlabFFT:
        """Return the convolver of slabs."""
        return SlabFFT(processes, gathers=False)

    @classmethod
    def require_memory(cls, processes: Processes, grid: rc.Grid, boundary: rc.Boundary) -> None:
        """Refuse a contact of which the slabs of one machine do not fit into its memory."""
        own = processes.own_rows(grid.shape[0])
        rows = processes.rows_of_machine(own.stop - own.start)
        if rows:
            require_memory_of_solve(rc.Grid((rows, grid.shape[1]), grid.size), boundary)
