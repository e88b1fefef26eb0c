"""From the areas of patches to the area of the contact, and the warnings that go with it."""

from __future__ import annotations

import math

import numpy as np

from roughcontact._answers.areas.contour import find_modulus_change
from roughcontact._answers.areas.edges import TracedEdges
from roughcontact._base.checks import Array
from roughcontact._base.warnings import ContactWarning
from roughcontact._parts.grid import extend
from roughcontact._solve.solution import Area, ContactSolution, Estimate

# Fraction of the counted area in patches of fewer than four cells above which the grid does not resolve the contact ...
_SMALL = 0.2
# ... unless the resolution ratio is below this (six cells a shortest wave), when load and curvature determine the area.
_SMOOTH = 0.4
# Cells of the waves that dominate the curvature below which the grid does not resolve it; self-affine surfaces come
# below with three cells a shortest wave, where areas err by up to 3 % (benchmarks/rough_constants.py).
_CELLS = 5.5
# Logarithm of the change of E* over two octaves of wavelength above which the edge is uncertain by 0.03 cells.
_LAYERED = 0.3
# Relative uncertainty above which two of it are more than 10 %.
_UNCERTAIN = 0.05


def total_area(
    solution: ContactSolution, values: Array, stds: Array, common: float, edges: TracedEdges, name: str
) -> Area:
    """Return the area of the contact from those of the patches; exactly zero or nominal without or in full contact.

    `values` and `stds` are the areas and their independent standard deviations, shape (count + 1,), m2; `common`
    is the one that they share, m2.
    """
    grid = solution.grid
    patches = solution.patches
    cells = int(patches.cells.sum())
    if cells in (0, solution.contact.size):
        fraction = float(cells > 0)
        parts = np.full(int(fraction), grid.area)
        hidden = _count_hidden_gaps(solution) * grid.cell_area
        return Area(fraction * grid.area, fraction, hidden, name, perimeter=0.0, patches=parts)
    total = float(values.sum())
    value = min(total, grid.area)
    values = values * (value / total if total > 0.0 else 1.0)
    uncertainty = math.sqrt(float(np.sum(stds**2)) + common**2 + edges.border**2)
    warnings = list_warnings(solution, edges.curvature_resolution)
    warnings = _judge_uncertainty("the area", value, uncertainty, warnings)
    return Area(
        value,
        value / grid.area,
        uncertainty,
        name,
        perimeter=float(edges.length.sum()),
        patches=values[1:],
        warnings=warnings,
    )


def _count_hidden_gaps(solution: ContactSolution) -> float:
    """Return the cells in full contact beside which the pressure, extrapolated, vanishes before the next centre."""
    pressure = solution.pressure
    extended = extend(pressure, 1, solution.boundary)
    around = (extended[:-2, 1:-1], extended[2:, 1:-1], extended[1:-1, :-2], extended[1:-1, 2:])
    steepest = np.max([np.abs(neighbour - pressure) for neighbour in around], axis=0)
    return float(np.count_nonzero((pressure > 0.0) & (2.0 * pressure < steepest)))


def warn_if_uncertain(value: float, std: float, unit: str, warnings: tuple[str, ...]) -> Estimate:
    """Return an estimate, with a warning if it has none and two of its standard deviations are more than 10 %."""
    if value != 0.0:
        warnings = _judge_uncertainty("this number", value, std, warnings)
    return Estimate(value, std, unit, warnings)


def _judge_uncertainty(what: str, value: float, std: float, warnings: tuple[str, ...]) -> tuple[str, ...]:
    """Return the warnings, or if there are none and two standard deviations are more than 10 %, that they are."""
    if warnings or std <= _UNCERTAIN * abs(value):
        return warnings
    text = f"the grid hardly determines {what}, whose uncertainty is above 5 %: refine the grid"
    return (ContactWarning(text, "uncertainty", std / abs(value) if value else math.inf),)


def list_warnings(solution: ContactSolution, curvature_resolution: float) -> tuple[str, ...]:
    """Return why an area from this solution must not be trusted, in sentences; empty if there are no warnings."""
    warnings = []
    waves = 2.0 * math.pi / math.sqrt(curvature_resolution) if curvature_resolution > 0.0 else math.inf
    if waves < _CELLS:
        text = (
            f"the shortest waves have about {waves:.2g} cells; the area needs about 8 "
            "(a finer grid of a measured map adds no heights)"
        )
        warnings.append(ContactWarning(text, "resolution", waves))
    small = solution.patches.small_fraction
    if small > _SMALL and curvature_resolution > _SMOOTH:
        text = f"{100 * small:.3g} % of the counted area is in patches of fewer than four cells"
        warnings.append(ContactWarning(text, "small patches", small))
    change = find_modulus_change(solution)
    if change > _LAYERED:
        text = (
            f"the modulus changes by a factor of {math.exp(change):.2g} between wavelengths of about a cell, as on a "
            "thin layer: refine the grid"
        )
        warnings.append(ContactWarning(text, "layer", math.exp(change)))
    if not solution.status.success:
        warnings.append(ContactWarning("the solution is not converged", "convergence"))
    return tuple(warnings)
