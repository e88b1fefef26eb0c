"""Size, arrangement and titles of figures."""

from __future__ import annotations

import math
from typing import Any

import attrs

from roughcontact._base.checks import Array
from roughcontact._base.units import counted, si
from roughcontact._faces.panels.maps import proportion
from roughcontact._parts.grid import Grid

# Side of a square map, and what labels beside and below it take, inches.
_SIDE = 3.0
_BESIDE = 1.3
_BELOW = 0.65
# Width and height of axes with curves, inches.
_CURVES = (3.6, 2.9)
# Smallest width and height of a panel alone and of one among others, inches.
_ALONE = (2.8, 2.4)
_AMONG = (1.3, 0.8)
# Width over height from which maps are stacked, and below which they stand in one row.
_WIDE = 2.2
_TALL = 0.55
# Pixels an inch of saved figures: at least the first number, at most the second, else one for each cell.
_PIXELS = (150.0, 300.0)


@attrs.frozen
class Layout:
    """How a figure is laid out.

    Attributes
    ----------
    rows, columns
        Number of panels along each direction.
    size
        Width and height, inches.
    dpi
        Pixels an inch that show every cell.
    engine
        Name of the layout engine.
    """

    rows: int
    columns: int
    size: tuple[float, float]
    dpi: float
    engine: str


def arrange(kind: str, subject: Any, count: int) -> Layout:
    """Return the layout of so many panels of a subject."""
    if kind == "sweep":
        width, height = _CURVES
        return Layout(1, count, (count * width, height), _PIXELS[0], "constrained")
    return _arrange_maps(subject.grid, count, "compressed" if kind == "solution" else "constrained")


def _arrange_maps(grid: Grid, count: int, engine: str) -> Layout:
    ratio = proportion(grid)
    columns = count if ratio < _TALL else (1 if ratio > _WIDE and count > 1 else math.ceil(math.sqrt(count)))
    if engine == "constrained":
        columns = math.ceil(math.sqrt(count))
    rows = math.ceil(count / columns)
    # Narrow maps are larger along their longer side.
    side = _SIDE * max(ratio, 1.0 / ratio) ** (0.35 if engine == "compressed" else 0.1)
    width, height = (side, side / ratio) if ratio > 1.0 else (side * ratio, side)
    dpi = max(grid.shape[0] / width, grid.shape[1] / height)
    if engine == "constrained":
        width = max(width, _CURVES[0] - 0.7)
        height = max(height, _CURVES[1] - 0.5)
    # Legends and curves need as much beside and below narrow domains.
    smallest = _ALONE if count == 1 else _AMONG
    width = max(width, smallest[0])
    height = max(height, smallest[1])
    if count == 1:
        # Constrained layout cuts the labels of a map alone: it is sized before its proportions are.
        engine = "compressed"
    size = (columns * (width + _BESIDE), rows * (height + _BELOW))
    return Layout(rows, columns, size, min(max(dpi, _PIXELS[0]), _PIXELS[1]), engine)


def title_of(kind: str, subject: Any) -> str:
    """Return what a figure of the subject says."""
    titles = {"solution": title_of_solution, "surface": title_of_surface, "sweep": title_of_sweep}
    return titles[kind](subject)


def title_of_solution(solution: Any) -> str:
    """Return the answer of a solution with its uncertainty, its load, and whether it has warnings."""
    area = solution.area()
    free = solution.boundary.value == "free"
    load = si(solution.force, "N", 3) if free else f"{si(solution.mean_pressure, 'Pa', 3)} mean pressure"
    text = f"Contact area {percent(area.fraction, area.uncertainty / solution.grid.area)} of nominal at {load}"
    text += f", {solution.boundary.value} boundary"
    count = len({*solution.warnings, *area.warnings})
    if not solution.status.success:
        text = f"NOT CONVERGED. {text}"
    return f"{text}\n{counted(count, 'warning')}" if count else text


def percent(fraction: float, uncertainty: float) -> str:
    """Return a fraction and its standard deviation in per cent, to the digits that it is known to."""
    value = 100.0 * fraction
    spread = 100.0 * uncertainty
    if not 0.0 < spread < math.inf:
        return f"{value:.4g} %"
    digits = min(max(1 - math.floor(math.log10(spread)), 0), 12)
    if value < 10.0**-3:
        return f"({value:.3g} ± {spread:.2g}) %"
    return f"({value:.{digits}f} ± {spread:.{digits}f}) %"


def title_of_surface(sampled: Any) -> str:
    """Return the rms height of a surface and its cells."""
    rms = si(sampled.rms_height, "m", 3)
    nx, ny = sampled.grid.shape
    lx, ly = sampled.grid.size
    size = si(lx, "m", 4) if lx == ly else f"{si(lx, 'm', 4)} x {si(ly, 'm', 4)}"
    return f"Rms height {rms} on {size}, {nx} x {ny} cells"


def loads_of(sweep: Any) -> tuple[Array, str, str]:
    """Return the loads of a sweep, their name and their unit: forces on a free boundary, else mean pressures."""
    if sweep.solutions[0].boundary.value == "free":
        return sweep.force, "force", "N"
    return sweep.mean_pressure, "mean pressure", "Pa"


def title_of_sweep(sweep: Any) -> str:
    """Return the number of loads and their range."""
    loads, name, unit = loads_of(sweep)
    low, high = (si(float(bound), unit, 3) for bound in (loads.min(), loads.max()))
    return f"{counted(len(loads), 'load')}, {name} {low if low == high else f'{low} to {high}'}"
