"""One line of a report."""

from __future__ import annotations

import math
from collections.abc import Sequence

import attrs
import numpy as np


@attrs.frozen
class Timing:
    """The same work, timed several times.

    Attributes
    ----------
    median, low, high
        Median, least and greatest, s.
    """

    median: float = math.nan
    low: float = math.nan
    high: float = math.nan

    @classmethod
    def of(cls, samples: Sequence[float]) -> Timing:
        """Return the timing of some samples, s."""
        return cls(float(np.median(samples)), min(samples), max(samples))


@attrs.frozen(kw_only=True)
class ReportRow:
    """One case with one area estimator: its answers, their errors, and its cost.

    Attributes
    ----------
    shape
        Cells (nx, ny).
    kernel, convolver, solver, estimator
        The parts, in words.
    tolerance
        Tolerance of the solver.
    area, area_uncertainty, p_max, approach
        Real contact area and its standard deviation, m2; greatest pressure, Pa; approach, m; nan if it failed.
    area_error, p_max_error, approach_error
        Errors relative to the truth, with sign; nan where that is not known.
    unresolved
        The quantities whose error is below that of the truth itself.
    cpu, wall
        CPU time of all threads and wall time, of the solve from the surface on and of the area.
    solve_cpu, area_cpu
        Both parts of `cpu`.
    iterations, convolutions
        What the solve took.
    single
        Convolutions of the solve in float32; zero if it used float64 throughout or does not tell.
    peak
        Greatest memory that numpy held beyond what was there before, bytes, as tracemalloc counts it.
    failure
        Why there is no answer, in a sentence; empty if there is.
    """

    shape: tuple[int, int]
    kernel: str
    convolver: str
    solver: str
    tolerance: float
    estimator: str
    area: float = math.nan
    area_uncertainty: float = math.nan
    p_max: float = math.nan
    approach: float = math.nan
    area_error: float = math.nan
    p_max_error: float = math.nan
    approach_error: float = math.nan
    unresolved: frozenset[str] = frozenset()
    cpu: Timing = Timing()
    wall: Timing = Timing()
    solve_cpu: Timing = Timing()
    area_cpu: Timing = Timing()
    iterations: int = 0
    convolutions: int = 0
    single: int = 0
    peak: int = 0
    failure: str = ""

    @property
    def cells(self) -> int:
        """Number of cells."""
        return self.shape[0] * self.shape[1]

    @property
    def setup(self) -> tuple[str, str, str, float, str]:
        """All but the grid: rows that share it make a line in the picture."""
        return (self.kernel, self.convolver, self.solver, self.tolerance, self.estimator)

    def error(self, quantity: str) -> float:
        """Return the size of the relative error of ``"area"``, ``"p_max"`` or ``"approach"``; nan if not known."""
        return abs(float(getattr(self, f"{quantity}_error")))

    def cost(self, quantity: str) -> float:
        """Return the median CPU time that a quantity takes, s: only the area needs an estimator."""
        return (self.cpu if quantity == "area" else self.solve_cpu).median
