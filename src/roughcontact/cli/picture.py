"""The picture of a solution: heights, pressure, contact."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.ticker import EngFormatter

from roughcontact.checks import Array
from roughcontact.solution import ContactSolution
from roughcontact.units import si


def draw_solution(solution: ContactSolution, path: Path) -> None:
    """Draw the undeformed gap, the pressure and the contact of a solution into a PNG file."""
    lx, ly = solution.grid.size
    height = min(max(3.6 * ly / lx, 2.0), 8.0)
    width = max(height * min(lx / ly, 3.0), 2.0)
    figure = Figure(figsize=(3 * (width + 1.7), height + 1.0), layout="compressed")
    heights, pressure, contact = figure.subplots(1, 3)
    _field(heights, -solution.undeformed, solution, "combined heights", "m", "viridis")
    shown = np.where(solution.contact, solution.pressure, np.nan)
    _field(pressure, shown, solution, f"pressure, mean {si(solution.mean_pressure, 'Pa')}", "Pa", "plasma")
    pressure.set_facecolor("0.92")
    kinds = solution.contact.astype(float) + solution.saturated
    image = _image(contact, kinds, solution, cmap=ListedColormap(["#2b4c8c", "#f4d35e", "#d1495b"]))
    image.set_norm(BoundaryNorm([-0.5, 0.5, 1.5, 2.5], 3))
    bar = figure.colorbar(image, ax=contact, ticks=[0, 1, 2])
    bar.ax.set_yticklabels(["open", "contact", "saturated"])
    contact.set_title(f"contact, {100 * solution.area().fraction:.3g} %")
    # A pixel for each cell, so that no small contact is lost in the picture.
    finest = max(solution.grid.shape[0] / width, solution.grid.shape[1] / height)
    figure.savefig(path, dpi=min(max(150.0, finest), 400.0))


def _image(axes: Axes, values: Array, solution: ContactSolution, **style: Any) -> AxesImage:
    lx, ly = solution.grid.size
    axes.xaxis.set_major_formatter(EngFormatter("m"))
    axes.yaxis.set_major_formatter(EngFormatter("m"))
    axes.set(xlabel="x", ylabel="y")
    axes.locator_params(axis="x", nbins=max(2, min(5, int(5 * lx / ly))))
    axes.locator_params(axis="y", nbins=5)
    extent = (0.0, lx, 0.0, ly)
    return axes.imshow(
        values.T, origin="lower", extent=extent, interpolation="nearest", aspect=_aspect(lx, ly), **style
    )


def _aspect(lx: float, ly: float) -> Literal["equal", "auto"]:
    """Return true proportions, unless the domain is too narrow to be seen so."""
    return "equal" if 1 / 6 <= lx / ly <= 6 else "auto"


def _field(axes: Axes, values: Array, solution: ContactSolution, title: str, unit: str, colors: str) -> None:
    # A few deep pits or high spikes would take all the colours.
    low, high = np.nanpercentile(values, (0.1, 99.9))
    ends = {(False, False): "neither", (True, False): "min", (False, True): "max", (True, True): "both"}
    extend = ends[bool(np.nanmin(values) < low), bool(np.nanmax(values) > high)]
    image = _image(axes, values, solution, cmap=colors, vmin=low, vmax=high)
    axes.figure.colorbar(image, ax=axes, format=EngFormatter(unit), extend=extend)
    axes.set_title(title)
