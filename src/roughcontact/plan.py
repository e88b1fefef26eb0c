"""The plan of a solve, for a person to read."""

from __future__ import annotations

import math
from functools import cached_property

import attrs
import numpy as np

from roughcontact.checks import Array, Mask
from roughcontact.convolvers import Convolver
from roughcontact.grid import Boundary, Grid
from roughcontact.kernels import InfluenceKernel
from roughcontact.relief import repeats, rms_slope
from roughcontact.solvers import Solver
from roughcontact.units import si

# Peak memory of a solve in real arrays of the grid's size, at shares of the cells in unsaturated contact,
# measured (docs/studies/memory.py). Where few touch, vectors hold their cells alone; on a free boundary
# kernel and spectra are longer.
_SHARES = {False: (0.0, 0.1, 0.28, 0.36, 1.0), True: (0.0, 0.1, 0.4, 1.0)}
_ARRAYS = {False: (8.0, 8.7, 10.3, 15.5, 16.6), True: (11.5, 12.7, 17.6, 17.8)}
# Notes are made above this rms slope, and above this multiple of the steps between neighbours.
_STEEP = 0.5


@attrs.frozen(eq=False, kw_only=True)
class Plan:
    """What will run, and what is left out and why; `str` of it is the text of ``explain()``.

    Attributes
    ----------
    grid, boundary, kernel, convolver, solver
        The parts that will run.
    modulus
        Contact modulus E*, Pa.
    undeformed
        Undeformed gap, shape (nx, ny), m.
    relief
        Greatest undeformed gap, m.
    limit
        Greatest pressure, Pa, a number or an array of shape (nx, ny).
    left_out
        What does not run, with the reason.
    holes
        Points that were not measured, shape (nx, ny); None if there are none.
    histories
        What was done to the heights of the body and of the other body, in words.
    """

    grid: Grid
    boundary: Boundary
    kernel: InfluenceKernel
    convolver: Convolver
    solver: Solver
    modulus: float
    undeformed: Array
    relief: float
    limit: float | Array
    left_out: tuple[str, ...]
    holes: Mask | None = None
    histories: tuple[tuple[str, ...], tuple[str, ...]] = ((), ())

    @cached_property
    def notes(self) -> tuple[str, ...]:
        """What looks unlike what was meant."""
        notes = []
        slope = rms_slope(self.undeformed, self.grid)
        if slope > _STEEP:
            notes.append(
                f"the rms slope of the heights is {slope:.2g}, too steep for a half-space: are they in metres?"
            )
        if self.boundary is not Boundary.FREE and not repeats(self.undeformed):
            notes.append("the heights jump across the border, where the domain is taken to go on with its own copy")
        return tuple(notes)

    @property
    def transform_shape(self) -> tuple[int, int]:
        """Cells the convolver works on, padding included."""
        return self.convolver.transform_shape(self.grid, self.boundary)

    @property
    def memory(self) -> int:
        """Peak memory of a solve at most, bytes."""
        return self.memory_at(1.0)

    def memory_at(self, touching: float) -> int:
        """Return the peak memory of a solve, beyond the problem itself, bytes.

        Parameters
        ----------
        touching
            Share of the cells that are in contact below the pressure limit, 0 to 1.
        """
        free = self.boundary is Boundary.FREE
        return int(8 * self.grid.cells * np.interp(touching, _SHARES[free], _ARRAYS[free]))

    def _memory(self, touching: float) -> str:
        size = self.memory_at(touching)
        return f"{size / 2**20:.3g} MiB ({size / (8 * self.grid.cells):.3g} arrays of the grid)"

    def __str__(self) -> str:
        mx, my = self.transform_shape
        cap = _range(self.limit)
        rows = [
            ("grid", f"{self.grid}, boundary {self.boundary}"),
            (
                "bodies",
                f"contact modulus {si(self.modulus, 'Pa')}, relief {si(self.relief, 'm')}, pressure limit {cap}",
            ),
            *(
                (f"heights {number}", "; ".join(history))
                for number, history in enumerate(self.histories, start=1)
                if history
            ),
            ("kernel", repr(self.kernel)),
            ("convolver", f"{self.convolver!r} on {mx} x {my} cells"),
            ("solver", repr(self.solver)),
            ("precision", "fields and residuals in float64, whatever the solver uses inside"),
            ("memory", f"{self._memory(0.0)} at light contact, at most {self._memory(1.0)}"),
        ]
        rows += [("left out", text) for text in self.left_out]
        rows += [("note", text) for text in self.notes]
        return "\n".join(f"{label:<10} {text}" for label, text in rows)


def _range(limit: float | Array) -> str:
    low, high = float(np.min(limit)), float(np.max(limit))
    if math.isinf(low):
        return "none"
    return si(low, "Pa") if low == high else f"{si(low, 'Pa')} to {si(high, 'Pa')}"
