"""The accuracy that was asked of a solve, and its cost."""

from __future__ import annotations

import math
from collections.abc import Sequence

import attrs


def _shape(value: Sequence[int]) -> tuple[int, int]:
    nx, ny = value
    return int(nx), int(ny)


@attrs.frozen
class Trial:
    """One grid that was solved to reach an accuracy.

    Attributes
    ----------
    shape
        Cells of the grid.
    area, area_uncertainty
        Real contact area and its standard deviation, m2; nan where they were not asked for.
    peak, peak_uncertainty
        Maximum pressure and its standard deviation, Pa; nan where they were not asked for.
    convolutions, seconds
        The work: convolutions on this grid, and wall time, s.
    """

    shape: tuple[int, int] = attrs.field(converter=_shape)
    area: float
    area_uncertainty: float
    peak: float
    peak_uncertainty: float
    convolutions: int
    seconds: float

    @property
    def spreads(self) -> tuple[float, float]:
        """Two standard deviations of area and maximum pressure over their values; nan where not asked for."""
        pairs = (self.area, self.area_uncertainty), (self.peak, self.peak_uncertainty)
        area, peak = (2.0 * std / value if value != 0.0 else math.inf for value, std in pairs)
        return area, peak

    def __str__(self) -> str:
        spreads = " and ".join(f"{100 * spread:.2g} %" for spread in self.spreads if not math.isnan(spread))
        return f"{self.shape[0]} x {self.shape[1]} ({spreads})"


@attrs.frozen
class Accuracy:
    """The accuracy that was asked of a solve, and its cost.

    Attributes
    ----------
    area_within, peak_within
        Largest relative error of area and maximum pressure that was allowed, with 95 %; None where none was stated.
    tolerance
        The tolerance of the solver.
    estimator
        The area estimator; empty where no area was asked for.
    trials
        The grids that were solved, in order; the last is that of the solution.
    shortfall
        Why the accuracy is not reached; empty where it is.
    """

    area_within: float | None
    peak_within: float | None
    tolerance: float
    estimator: str
    trials: tuple[Trial, ...]
    shortfall: str = ""

    @property
    def met(self) -> bool:
        """Whether two standard deviations are within what was asked."""
        return not self.shortfall

    @property
    def asked(self) -> str:
        """What was asked, in words."""
        pairs = ("area", self.area_within), ("maximum pressure", self.peak_within)
        return " and ".join(f"{name} within {100 * value:.3g} %" for name, value in pairs if value is not None)

    def explain(self) -> str:
        """Return in a sentence why the accuracy is not reached."""
        reason = f"{self.shortfall[:1].upper()}{self.shortfall[1:]}."
        return f"The {self.asked} is not reached, but {self.trials[-1]}, in two standard deviations. {reason}"

    def __str__(self) -> str:
        reached = "reached" if self.met else f"NOT reached: {self.shortfall}"
        estimator = f", estimator {self.estimator}" if self.estimator else ""
        seconds = sum(trial.seconds for trial in self.trials)
        return (
            f"{self.asked}, two standard deviations: {reached}\n"
            f"grids solved   {', '.join(map(str, self.trials))}, {seconds:.2g} s in all\n"
            f"tolerance      {self.tolerance:.1e}{estimator}"
        )
