"""The thresholds of all checks, with their reasons."""

from __future__ import annotations

import math

from roughcontact._solve.solution import PLAUSIBILITY_RULES, Rule

_KERNEL = "Use a kernel whose sums do not cancel, such as 'love', or report the error to its author."
_SOLVER = "Read the status; try the solver spectral-gradient, or lengths and moduli in units nearer to one."
_GRID = "Refine the grid; for measured maps, measure with a finer pitch."
_TOLERANCE = "Lower the solver's tolerance."

RULES = {
    "convergence": Rule(0, 0, "decided by the status; an unconverged solution is not checked further", _SOLVER),
    "load balance": Rule(1e-12, 1e-9, "the sum of 1e6 pressures has a rounding error of 1e-13", _SOLVER),
    "complementarity": Rule(
        2e-5, 1e-3, "twice the solvers' tolerance of 1e-5; 1e-3 moves areas and peak pressures by 0.1 %", _TOLERANCE
    ),
    "penetration": Rule(2e-5, 1e-3, "as for complementarity", _TOLERANCE),
    "convolution: digits lost": Rule(
        3, 7, "of 16 digits the gap needs 8, and the displacement may be 1e4 times the rms height", _KERNEL
    ),
    "kernel: digits lost": Rule(3, 7, "as for the convolution", _KERNEL),
    "kernel: two forms": Rule(1e-10, 1e-6, "both forms describe one body; beyond 1e-6 the formulas differ", _KERNEL),
    **PLAUSIBILITY_RULES,
    "cells per wavelength": Rule(8, 4, "from eight on the area is right to 0.1 %; white noise has 3.4", _GRID),
    "float32 iterations": Rule(
        1e-5,
        1e-3,
        "at a tolerance of 1e-8 two solvers differ by up to 1e-6 of the peak pressure",
        "Use the solver spectral-gradient, which works in float64 throughout.",
    ),
    "coarser grid: area": Rule(
        0.05, 0.2, "at second order a change of 5 % leaves an error of less than 2 % on the finer grid", _GRID
    ),
    "coarser grid: peak pressure": Rule(
        0.15, 0.5, "peaks are local: a change by half leaves about a tenth on the finer grid", _GRID
    ),
    "coarser grid: approach or load": Rule(0.05, 0.2, "as for the area", _GRID),
    "shifted grid: area": Rule(
        0.02, 0.1, "the position of the grid is arbitrary; the change is an uncertainty of about that size", _GRID
    ),
    "shifted grid: peak pressure": Rule(0.05, 0.2, "as for the area; a peak between cell centres is missed", _GRID),
    "shifted grid: approach or load": Rule(0.02, 0.1, "as for the area", _GRID),
    "tighter tolerance: area": Rule(1e-4, 1e-2, "at 1e-5 only cells at the contact edge may still change", _TOLERANCE),
    "tighter tolerance: peak pressure": Rule(1e-4, 1e-2, "as for the area", _TOLERANCE),
    "tighter tolerance: approach or load": Rule(1e-4, 1e-2, "as for the area", _TOLERANCE),
    "area: uncertainty": Rule(
        0.05, 0.3, "one standard deviation over the area; above 30 % only its order of magnitude is known", _GRID
    ),
    "area: warnings": Rule(0, math.inf, "a warning is not an error, but the uncertainty does not include it", _GRID),
}
