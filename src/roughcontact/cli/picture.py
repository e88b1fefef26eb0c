"""The picture of a solution: heights, pressure, contact."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.ticker import EngFormatter

from roughcontact.checks import Array
from roughcontact.solution import ContactSolution


def draw_solution(solution: ContactSolution, path: Path) -> None:
    """Draw the undeformed gap, the pressure and the contact of a solution into a PNG file."""
    wide = solution.grid.size[0] >= 0.8 * solution.grid.size[1]
    figure = Figure(figsize=(15, 4.6) if wide else (11, 6.5), layout="constrained")
    heights, pressure, contact = figure.subplots(1, 3)
    _field(heights, -solution.undeformed, solution, "Combined heights below the highest point", "m", "viridis")
    shown = np.where(solution.contact, solution.pressure, np.nan)
    _field(pressure, shown, solution, f"Contact pressure, {solution.mean_pressure:.4g} Pa in the mean", "Pa", "inferno")
    pressure.set_facecolor("0.9")
    kinds = solution.contact.astype(float) + solution.saturated
    image = _image(contact, kinds, solution, cmap=ListedColormap(["#2b4c8c", "#f4d35e", "#d1495b"]))
    image.set_norm(BoundaryNorm([-0.5, 0.5, 1.5, 2.5], 3))
    bar = figure.colorbar(image, ax=contact, ticks=[0, 1, 2])
    bar.ax.set_yticklabels(["open", "contact", "saturated"])
    contact.set_title(f"Contact, {100 * solution.area().fraction:.3g} % of nominal")
    figure.savefig(path, dpi=150)


def _image(axes: Axes, values: Array, solution: ContactSolution, **style: object):  # type: ignore[no-untyped-def]
    lx, ly = solution.grid.size
    axes.xaxis.set_major_formatter(EngFormatter("m"))
    axes.yaxis.set_major_formatter(EngFormatter("m"))
    axes.set(xlabel="x", ylabel="y")
    axes.locator_params(nbins=5)
    extent = (0.0, lx, 0.0, ly)
    return axes.imshow(values.T, origin="lower", extent=extent, interpolation="nearest", aspect="equal", **style)


def _field(axes: Axes, values: Array, solution: ContactSolution, title: str, unit: str, colors: str) -> None:
    image = _image(axes, values, solution, cmap=colors)
    axes.figure.colorbar(image, ax=axes, format=EngFormatter(unit))
    axes.set_title(title)
