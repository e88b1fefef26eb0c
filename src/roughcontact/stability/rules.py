"""The thresholds of all checks, with their reasons: the one place."""

from __future__ import annotations

import math

import attrs


@attrs.frozen
class Rule:
    """When a measured value passes.

    Attributes
    ----------
    good, bearable
        Up to `good` it passes, up to `bearable` it needs attention; from there down where `good` is the
        greater of the two.
    reason
        Why there.
    advice
        What to do about a value that does not pass.
    """

    good: float
    bearable: float
    reason: str
    advice: str


_PRECISION = "Use a kernel whose sums do not cancel, such as 'love', or report the plug-in."
_SOLVER = "Look at the status; try solver='spectral-gradient', or lengths and moduli nearer to each other."
_FINER = "Refine the grid; for measured maps, measure with a finer pitch."

RULES = {
    "convergence": Rule(0, 0, "only a certified solution is worth more questions", _SOLVER),
    "load balance": Rule(
        1e-12, 1e-9, "the sum of 1e6 pressures rounds to 1e-13; nothing beyond 1e-9 is rounding", _SOLVER
    ),
    "complementarity": Rule(
        2e-8,
        1e-5,
        "the solvers' own tolerance is 1e-8 and confirmed at twice that; 1e-5 of the relief moves no edge",
        "Lower the solver's tolerance.",
    ),
    "penetration": Rule(2e-8, 1e-5, "as for complementarity", "Lower the solver's tolerance."),
    "convolution: digits lost": Rule(
        3, 7, "of 16 digits the gap needs 8 for the tolerance, and the displacement may be 1e4 reliefs", _PRECISION
    ),
    "kernel: digits lost": Rule(3, 7, "as for the convolution", _PRECISION),
    "kernel: two forms": Rule(
        1e-10, 1e-6, "both forms are of one body; a difference above 1e-6 is a difference of formulas", _PRECISION
    ),
    "edge contact": Rule(
        0,
        1.5,
        "a contact away from the border presses nothing there, an even one its share; a flat punch twice that",
        "On a free boundary nothing lies beyond: enlarge the domain, or make it periodic if the surface goes on.",
    ),
    "cells a wave": Rule(
        8, 4, "from eight cells a wave on the area is right to 0.1 %; noise from cell to cell has 3.4", _FINER
    ),
    "slope": Rule(
        0.2,
        0.5,
        "a half-space neglects the square of the slope: 4 % at 0.2, a quarter at 0.5",
        "Check that heights and sizes are in metres; smooth what is noise.",
    ),
    "peak pressure": Rule(
        0.1,
        0.3,
        "strains are about p / E*, and linear elasticity holds up to a tenth",
        "Give a hardness (ElasticPerfectlyPlastic), or a lower load.",
    ),
    "float32 inside": Rule(
        1e-5,
        1e-3,
        "two solvers at a tolerance of 1e-8 differ by 1e-6 of the peak where the stiffest waves count",
        "Take solver='spectral-gradient', which works in float64 throughout.",
    ),
    "half the cells: area": Rule(
        0.05, 0.2, "errors fall at second order: a change of 5 % leaves less than 2 % on the finer grid", _FINER
    ),
    "half the cells: peak pressure": Rule(
        0.15, 0.5, "peaks are local: a change by half leaves about a tenth on the finer grid", _FINER
    ),
    "half the cells: approach or load": Rule(0.05, 0.2, "as for the area", _FINER),
    "half a cell aside: area": Rule(
        0.02, 0.1, "where the cells lie is chance; what hangs on it is an error bar of about that size", _FINER
    ),
    "half a cell aside: peak pressure": Rule(0.05, 0.2, "as for the area; a peak between cells is cut", _FINER),
    "half a cell aside: approach or load": Rule(0.02, 0.1, "as for the area", _FINER),
    "tolerance / 100: area": Rule(
        1e-4, 1e-2, "at 1e-8 only cells at the very edge may still change sides", "Lower the solver's tolerance."
    ),
    "tolerance / 100: peak pressure": Rule(1e-5, 1e-3, "as for float32 inside", "Lower the solver's tolerance."),
    "tolerance / 100: approach or load": Rule(1e-6, 1e-4, "as for the area", "Lower the solver's tolerance."),
    "area: uncertainty": Rule(
        0.05, 0.3, "one standard deviation over the area; beyond 30 % the order of magnitude is what is known", _FINER
    ),
    "area: doubts": Rule(0, math.inf, "a doubt is no error, but the bar does not know of it", _FINER),
}
