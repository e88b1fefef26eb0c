"""Checks of a solution as it is."""

from __future__ import annotations

import math

import numpy as np

from roughcontact.areas.curvature import roughness
from roughcontact.grid import Boundary
from roughcontact.relief import rms_slope
from roughcontact.solution import Status
from roughcontact.stability.examined import Examined
from roughcontact.stability.report import Check, Verdict, judged, left_out
from roughcontact.stability.rules import RULES

# The strip along the border, as a part of a side.
_STRIP = 16


def convergence(examined: Examined) -> Check:
    """Tell how the solve ended."""
    status, error = examined.solution.status, examined.solution.residuals.error
    found = f"{status}; {examined.solution.iterations} iterations, {examined.solution.convolutions} convolutions"
    if status is Status.CONVERGED:
        return Check("convergence", Verdict.PASS, error, found)
    verdict = Verdict.ATTENTION if status.success else Verdict.FAIL
    return Check("convergence", verdict, error, found, RULES["convergence"].advice)


def load_balance(examined: Examined) -> Check:
    """Add the pressures up exactly and compare with the load that was asked for."""
    name, grid = "load balance", examined.solution.grid
    load = examined.load
    if load.approach is not None:
        return left_out(name, "the approach is given, and the load is what it takes")
    asked = load.force if load.pressure is None else load.pressure * grid.area
    carried = math.fsum(examined.solution.pressure.ravel()) * grid.cell_area
    off = math.nan if asked is None else abs(carried / asked - 1.0)
    return judged(name, off, "relative error of the load, summed exactly")


def complementarity(examined: Examined) -> Check:
    """Report the gap that is left where there is pressure."""
    found = "mean gap under the pressure, over the scale of the residuals"
    return judged("complementarity", examined.solution.residuals.complementarity, found)


def penetration(examined: Examined) -> Check:
    """Report the deepest overlap."""
    found = "deepest overlap outside saturated cells, over the scale of the residuals"
    return judged("penetration", examined.solution.residuals.penetration, found)


def edge_contact(examined: Examined) -> Check:
    """Look for pressure near the border of a free domain."""
    name, solution = "edge contact", examined.solution
    if solution.boundary is not Boundary.FREE:
        return left_out(name, f"the boundary is {solution.boundary}: the domain has no border")
    if min(solution.grid.shape) < _STRIP:
        return left_out(name, f"with fewer than {_STRIP} cells along an axis all cells are near the border")
    inside = np.zeros(solution.grid.shape, dtype=bool)
    inside[tuple(slice(n // _STRIP, n - n // _STRIP) for n in solution.grid.shape)] = True
    near = solution.pressure[~inside]
    share = float(near.sum() / solution.pressure.sum()) if solution.contact.any() else 0.0
    border = solution.contact.copy()
    border[1:-1, 1:-1] = False
    found = (
        f"{100 * share:.3g} % of the load lies within 1/{_STRIP} of the border, on "
        f"{100 * near.size / inside.size:.3g} % of the domain; {np.count_nonzero(border)} cells touch on the border"
    )
    return judged(name, share * inside.size / near.size, found)


def cells_a_wave(examined: Examined) -> Check:
    """Ask whether the grid resolves the heights under the contact."""
    if not examined.solution.contact.any():
        return left_out("cells a wave", "nothing touches")
    rough = roughness(examined.solution)
    waves = 2.0 * math.pi / math.sqrt(rough) if rough > 0.0 else math.inf
    return judged("cells a wave", waves, "the curvature under the contact goes with waves of so many cells")


def slope(examined: Examined) -> Check:
    """Ask whether the surfaces are flat enough for a half-space."""
    solution = examined.solution
    return judged("slope", rms_slope(solution.undeformed, solution.grid), "rms slope of both surfaces together")


def peak_pressure(examined: Examined) -> Check:
    """Ask whether the strains are small."""
    solution = examined.solution
    return judged("peak pressure", float(solution.pressure.max()) / solution.modulus, "greatest pressure over E*")


def area_uncertainty(examined: Examined) -> Check:
    """Report the area's own bar."""
    area = examined.solution.area()
    if not area.value > 0.0:
        return left_out("area: uncertainty", "nothing touches")
    found = f"the area is {100 * area.fraction:.4g} % of nominal; standard deviation over area [{area.estimator}]"
    return judged("area: uncertainty", area.uncertainty / area.value, found)


def area_doubts(examined: Examined) -> Check:
    """Report the area's own doubts."""
    doubts = examined.solution.area().doubts
    return judged("area: doubts", len(doubts), "; ".join(doubts) or "nothing speaks against the area")
