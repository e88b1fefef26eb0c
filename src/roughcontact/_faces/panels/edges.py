"""The sub-grid edge of the contact, drawn as closed lines."""

from __future__ import annotations

from typing import Any

import numpy as np

from roughcontact._answers.areas import LevelSet
from roughcontact._faces.panels.maps import length_scale
from roughcontact._parts.grid import Boundary
from roughcontact._solve.solution import ContactSolution

# Width of the line over that of a cell, and its bounds, points.
_WIDTH = 0.3
_THINNEST = 0.03
_THICKEST = 1.0
# Mean width of the contact patches, cells, below which the line is thinner, so that it does not hide them.
_NARROW = 8.0


def draw_edges(axes: Any, solution: ContactSolution, color: str) -> None:
    """Draw the edge of the contact on axes that show the plane of a solution.

    A line that crosses a periodic border is drawn at both sides of the domain.
    """
    from matplotlib.collections import LineCollection

    size = np.array(solution.grid.size)
    factor, _ = length_scale(solution.grid)
    lines = []
    for line in LevelSet().contours(solution):
        if solution.boundary is Boundary.FREE:
            lines.append(line)
            continue
        first = np.ceil(-0.5 - line.max(axis=0) / size).astype(int)
        last = np.floor(0.5 - line.min(axis=0) / size).astype(int)
        shifts = [(i, j) for i in range(first[0], last[0] + 1) for j in range(first[1], last[1] + 1)]
        lines.extend(line + np.array(shift) * size for shift in shifts)
    across = 72.0 * axes.get_window_extent().width / axes.get_figure(root=True).dpi
    finest = min(1.0, _measure_patches(solution) / _NARROW) * _WIDTH
    width = min(max(finest * across / solution.grid.shape[0], _THINNEST), _THICKEST)
    axes.add_collection(
        LineCollection([factor * line for line in lines], colors=color, linewidths=width, joinstyle="round"),
        autolim=False,
    )


def _measure_patches(solution: ContactSolution) -> float:
    """Return the mean width of the contact patches, cells: that of strips of the same area and edge."""
    area = solution.area()
    return 2.0 * area.value / (area.perimeter * solution.grid.cell_area**0.5) if area.perimeter > 0.0 else np.inf
