"""One contact on slabs: the solve, and its solution."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from functools import cached_property, partial
from pathlib import Path
from typing import Any, cast

import attrs
import roughcontact as rc
from roughcontact.solving import plan_slabs, require_memory_of_solve, solve_slabs
from roughcontact.typing import Load, Step, replacing, si

from roughcontact_mpi.arrays import SlabArray
from roughcontact_mpi.convolver import SlabFFT
from roughcontact_mpi.files import write_field
from roughcontact_mpi.patches import SlabPatches
from roughcontact_mpi.processes import Processes
from roughcontact_mpi.store import SUFFIX, require_place, write_store
from roughcontact_mpi.surfaces import make_heights
from roughcontact_mpi.windows import WindowSolution, gather_rows, open_window

# The area estimators whose text asks the other processes.
_ESTIMATORS = ("blend", "cell-count", "hertz", "level-set", "level-set-richardson", "perimeter")


@attrs.frozen(eq=False, kw_only=True)
class SlabSolution(rc.solving.SlabSolution):
    """The solution of a contact: its numbers on each process, and its fields, `SlabArray`, by slab."""

    _found: dict[str, rc.Estimate] = attrs.field(factory=dict, init=False, repr=False)

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
        return self.certify_whole(*(gather_rows(field) for field in (self.pressure, self.initial_gap)))

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
            write_store(folder, self, self.numbers)
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
    load = Load.of(pressure=pressure, force=force, approach=approach)
    if isinstance(heights, rc.Surface):
        heights = make_heights(heights, cast(rc.Grid, size))
    if not isinstance(heights, SlabArray) or not heights.is_divided or heights.ndim != 2:
        raise rc.InputError.about("The heights", heights, "an array in slabs, as read_heights returns it")
    processes = heights.processes
    processes.meet("solve")
    scene, plan = plan_slabs(
        heights,
        size,
        material,
        counterbody,
        boundary=boundary,
        kernel=kernel,
        tolerance=tolerance,
        convolver=SlabFFT(processes, gathers=False),
        require=partial(_require_memory, processes),
    )
    # The plan has the gap.
    del heights
    return solve_slabs(SlabSolution, scene, plan, load, on_step=on_step, throw=throw)


def _require_memory(processes: Processes, grid: rc.Grid, boundary: rc.Boundary) -> None:
    """Refuse a contact of which the slabs of one machine do not fit into its memory."""
    own = processes.own_rows(grid.shape[0])
    rows = processes.rows_of_machine(own.stop - own.start)
    if rows:
        require_memory_of_solve(rc.Grid((rows, grid.shape[1]), grid.size), boundary)
