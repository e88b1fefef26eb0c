"""The figure of a solution: heights, pressure, contact."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.ticker import EngFormatter

from roughcontact._solution import ContactSolution
from roughcontact.archive import replacing
from roughcontact.checks import Array
from roughcontact.units import si


def draw_solution(solution: ContactSolution, path: Path) -> None:
    """Draw the combined heights, the pressure and the contact of a solution into a PNG file."""
    lx, ly = solution.grid.size
    height = min(max(3.6 * ly / lx, 2.0), 8.0)
    width = max(height * min(lx / ly, 3.0), 2.0)
    figure = Figure(figsize=(3 * (width + 1.7), height + 1.0), layout="compressed")
    heights, pressure, contact = figure.subplots(1, 3)
    _draw_field(heights, -solution.initial_gap, solution, "combined heights", "m", "viridis")
    shown = np.where(solution.contact, solution.pressure, np.nan)
    _draw_field(pressure, shown, solution, f"pressure, mean {si(solution.mean_pressure, 'Pa')}", "Pa", "plasma")
    pressure.set_facecolor("0.92")
    kinds = solution.contact.astype(float) + solution.saturated
    colors = ListedColormap(["#2b4c8c", "#f4d35e", "#d1495b"])
    image = _draw_image(contact, kinds, solution, cmap=colors, norm=BoundaryNorm([-0.5, 0.5, 1.5, 2.5], 3))
    figure.colorbar(image, ax=contact, ticks=[0, 1, 2]).ax.set_yticklabels(["open", "contact", "saturated"])
    contact.set_title(f"contact, {100 * solution.area().fraction:.3g} %")
    # A pixel for each cell, so that no small contact is lost in the figure.
    finest = max(solution.grid.shape[0] / width, solution.grid.shape[1] / height)
    content = io.BytesIO()
    figure.savefig(content, dpi=min(max(150.0, finest), 400.0), format="png")
    with replacing(path) as partial:
        partial.write_bytes(content.getvalue())


def _draw_field(axes: Axes, values: Array, solution: ContactSolution, title: str, unit: str, colors: str) -> None:
    # Without the few deepest pits and highest spikes, which would use all the colours.
    low, high = np.nanpercentile(values, (0.1, 99.9))
    image = _draw_image(axes, values, solution, cmap=colors, vmin=low, vmax=high)
    ends = {(False, False): "neither", (True, False): "min", (False, True): "max", (True, True): "both"}
    extend = ends[bool(np.nanmin(values) < low), bool(np.nanmax(values) > high)]
    axes.figure.colorbar(image, ax=axes, format=EngFormatter(unit), extend=extend)
    axes.set_title(title)


def _draw_image(axes: Axes, values: Array, solution: ContactSolution, **style: Any) -> AxesImage:
    lx, ly = solution.grid.size
    axes.xaxis.set_major_formatter(EngFormatter("m"))
    axes.yaxis.set_major_formatter(EngFormatter("m"))
    axes.set(xlabel="x", ylabel="y")
    axes.locator_params(axis="x", nbins=max(2, min(5, int(5 * lx / ly))))
    axes.locator_params(axis="y", nbins=5)
    # True proportions, unless the domain is too narrow to be seen so.
    style |= {"extent": (-lx / 2, lx / 2, -ly / 2, ly / 2), "aspect": "equal" if 1 / 6 <= lx / ly <= 6 else "auto"}
    return axes.imshow(values.T, origin="lower", interpolation="nearest", **style)
