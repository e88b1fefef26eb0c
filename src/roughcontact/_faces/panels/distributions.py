"""Panels of the distributions of pressures and of contact patches."""

from __future__ import annotations

import math
from typing import Any, final

import attrs
import numpy as np

from roughcontact._answers.areas.outline import edge_law
from roughcontact._base.units import prefixed, with_spread
from roughcontact._faces.panels.base import Panel
from roughcontact._faces.panels.curves import add_key, scale_axes
from roughcontact._faces.panels.fields import areas_of_patches, pressure_scale
from roughcontact._faces.panels.theme import theme_of

# Bins of a histogram for n numbers: about the cubic root of n, within these bounds.
_FEWEST = 8
_MOST = 60
# Fraction of the maximum pressure up to which the law of the edge is drawn.
_DRAWN = 0.7
# Cells below which the area of a patch is hardly known.
_SMALL = 4


@final
@attrs.frozen
class PressureHistogramPanel(Panel):
    r"""The distribution of the contact pressure over the nominal area, and the law of the edge.

    The area of the histogram is the fraction of the cells that are in contact below the pressure limit; saturated
    cells are a line of their own, named with the fraction of `ContactSolution.saturated_area`. At the distance d from
    an edge :math:`p = K\sqrt{d}`, so that the distribution begins in proportion to p: the dashed line, with K along the
    traced edge. The edge cuts cells, which then carry less, so that a coarse grid has too many of low pressure.
    """

    def draw(self, subject: Any, axes: Any) -> None:
        """Draw a solution; see `Panel.draw`."""
        theme = theme_of(axes)
        factor, unit = pressure_scale(subject)
        saturated = subject.saturated & subject.contact
        values = factor * subject.pressure[subject.contact & ~saturated]
        highest = factor * float(subject.pressure.max()) or 1.0
        bins = min(max(round(2.0 * values.size ** (1.0 / 3.0)), _FEWEST), _MOST)
        edges = np.linspace(0.0, highest, bins + 1)
        counts, _ = np.histogram(values, edges)
        density = counts / subject.grid.cells / np.diff(edges)
        axes.bar(
            edges[:-1], density, np.diff(edges), align="edge", color=theme.lines[0], alpha=0.6, linewidth=0.0,
            label="cells in contact",
        )  # fmt: skip
        top = 1.08 * float(density.max(initial=0.0)) or 1.0
        slope = edge_law(subject) / factor**2
        if slope > 0.0:
            end = min(_DRAWN * highest, top / slope)
            axes.plot(
                (0.0, end), (0.0, slope * end), "--", color=theme.lines[1], linewidth=2.0, label="law of the edge, ∝ p"
            )
        if saturated.any():
            area = subject.saturated_area()
            percent = with_spread(100.0 * area.fraction, 100.0 * area.uncertainty / subject.grid.area)
            label = f"saturated: {percent.strip('(').partition(' ')[0]} % of nominal"
            axes.plot((highest, highest), (0.0, top), color=theme.limit, linewidth=4.0, label=label)
        scale_axes(axes, x=f"pressure, {unit}", y=f"fraction of nominal area per {unit}")
        axes.set(xlim=(0.0, 1.03 * highest), ylim=(0.0, top))
        add_key(axes)


@final
@attrs.frozen
class PatchSizesPanel(Panel):
    """The number of contact patches that are larger than an area; shaded where a patch has less than four cells."""

    def draw(self, subject: Any, axes: Any) -> None:
        """Draw a solution; see `Panel.draw`."""
        theme = theme_of(axes)
        areas = np.sort(areas_of_patches(subject))
        cell = subject.grid.cell_area
        factor, unit = prefixed(max(float(areas.max(initial=0.0)), cell), "m", 2)
        scale_axes(axes, x=f"patch area, {unit}", y="number of patches at least as large", logarithmic="xy")
        smallest = factor * min(float(areas.min(initial=cell)), cell)
        largest = factor * max(float(areas.max(initial=0.0)), 10.0 * cell)
        axes.axvspan(0.5 * smallest, factor * _SMALL * cell, color=theme.open, linewidth=0.0, label="below four cells")
        if areas.size:
            numbers = np.arange(areas.size, 0, -1)
            x = factor * np.concatenate((areas, areas[-1:]))
            axes.step(x, np.append(numbers, 0.7), where="pre", color=theme.lines[0], label="_patches")
            axes.plot(factor * areas, numbers, "o", color=theme.lines[0], markersize=2.5, label="_patches")
        axes.set(
            xlim=(0.5 * smallest, 2.0 * largest), ylim=(0.7, 10.0 ** math.ceil(math.log10(max(areas.size, 2)) + 0.1))
        )
        add_key(axes)
