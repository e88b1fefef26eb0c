"""A contact on slabs as the estimators of one machine see it: by windows, on each process its own."""

from __future__ import annotations

from typing import Any, cast

import attrs
import roughcontact as rc
from roughcontact.typing import (
    Certificate,
    GridLevel,
    Outcome,
    Residuals,
    SolvePlan,
    make_solution,
)

from roughcontact_mpi.arrays import SlabArray
from roughcontact_mpi.parts import Part
from roughcontact_mpi.patches import WindowPatches, label_slabs, window_patches


@attrs.frozen(eq=False, kw_only=True)
class WindowSolution(rc.ContactSolution):
    """The solution of a contact on the rows of a window; its grid and its numbers are those of the whole domain."""

    parts: Part = attrs.field(repr=False)
    patches: WindowPatches = attrs.field(repr=False)

    @property
    def force(self) -> float:
        """Normal force, N; all processes must ask."""
        return self.parts.total(float(self.pressure[self.parts.inside].sum())) * self.grid.cell_area


@attrs.frozen(eq=False)
class SlabFields:
    """What a solution on slabs has, from which windows and whole solutions are made."""

    plan: SolvePlan
    pressure: SlabArray
    displacement: SlabArray
    approach: float
    status: rc.Status
    residuals: Residuals
    iterations: int
    convolutions: int
    errors: tuple[float, ...]
    levels: tuple[GridLevel, ...]
    seconds: float

    def outcome(self, pressure: Any) -> Outcome:
        """Return the outcome of the solver, with a pressure of no unit."""
        return Outcome(
            pressure=pressure,
            status=self.status,
            iterations=self.iterations,
            convolutions=self.convolutions - 1,
            errors=self.errors,
            levels=self.levels,
        )

    def open_window(self) -> WindowSolution:
        """Return the solution on the window of this process."""
        plan = self.plan
        gap: Any = plan.initial_gap
        part = Part(self.pressure.processes, plan.grid.shape, plan.boundary)
        pressure, displacement, initial_gap = (part.read(field) for field in (self.pressure, self.displacement, gap))
        labels, count = label_slabs(part, self.pressure, plan.grid, plan.boundary)
        patches = window_patches(part, labels, count, pressure, plan.grid, plan.boundary)
        certificate = Certificate(
            pressure=pressure,
            displacement=displacement,
            approach=self.approach,
            status=self.status,
            residuals=self.residuals,
        )
        base = make_solution(plan, initial_gap, self.outcome(pressure), certificate, self.seconds)
        fields = attrs.asdict(base, recurse=False)
        return WindowSolution(**cast(dict[str, Any], fields), parts=part, patches=patches)
