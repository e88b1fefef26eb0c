"""Panels of a solution over the plane: heights, pressure, gap, contact patches."""

from __future__ import annotations

from typing import Any, final

import attrs
import numpy as np

from roughcontact._base.checks import Array, choice, flag
from roughcontact._base.units import prefixed
from roughcontact._faces.panels.base import Panel
from roughcontact._faces.panels.curves import say
from roughcontact._faces.panels.edges import draw_edges
from roughcontact._faces.panels.maps import draw_map, draw_mask, name_colors
from roughcontact._faces.panels.theme import theme_of
from roughcontact._solve.solution import ContactSolution
from roughcontact.errors import InputError

# What heights may be drawn.
_HEIGHTS = ("combined", "body", "counterbody")
# Gaps below this fraction of the largest have the same colour, on a logarithmic scale.
_SMALLEST_GAP = 1e-4
# Smallest range of a logarithmic scale of the areas of patches.
_RANGE = 2.0


def height_scale(solution: ContactSolution) -> tuple[float, str]:
    """Return what heights and gaps are multiplied by, and their unit: one for all panels of a figure."""
    gap = solution.initial_gap
    known = gap if solution.non_measured is None else gap[~solution.non_measured]
    return prefixed(float(known.max()), "m")


def pressure_scale(solution: ContactSolution) -> tuple[float, str]:
    """Return what pressures are multiplied by, and their unit."""
    return prefixed(float(solution.pressure.max()), "Pa")


def hide_non_measured(solution: ContactSolution, values: Array) -> Array:
    """Return values, shape (nx, ny), with NaN at non-measured points."""
    return values if solution.non_measured is None else np.where(solution.non_measured, np.nan, values)


def _mark_unknown(axes: Any, solution: ContactSolution) -> list[tuple[str, str]]:
    """Draw the non-measured points, and return their entry in the legend."""
    if solution.non_measured is None:
        return []
    color = theme_of(axes).unknown
    draw_mask(axes, solution.non_measured, color)
    return [(color, "non-measured")]


def _edge(value: object) -> bool:
    return flag(value, "edge=")


def _logarithmic(value: object) -> bool:
    return flag(value, "logarithmic=")


def _known_heights(value: object) -> str:
    return choice(value, "The heights to draw", _HEIGHTS)


@final
@attrs.frozen
class HeightsPanel(Panel):
    """The heights before deformation, about their mean.

    Attributes
    ----------
    of
        ``"combined"``, the sum of both, ``"body"`` or ``"counterbody"``.
    """

    of: str = attrs.field(default="combined", converter=_known_heights)

    def draw(self, subject: Any, axes: Any) -> None:
        """Draw a solution; see `Panel.draw`."""
        heights = -subject.initial_gap
        if self.of != "combined":
            if subject.origin is None:
                raise InputError(f"The heights of the {self.of} are not known: the solution does not say its problem.")
            heights = np.array(subject.origin.problem[self.of].heights(subject.grid))
        heights = hide_non_measured(subject, heights)
        factor, unit = height_scale(subject)
        label = "height" if self.of != "combined" else "combined height"
        draw_map(axes, factor * (heights - np.nanmean(heights)), subject.grid, label, unit, colors="cividis")
        name_colors(axes, _mark_unknown(axes, subject))


@final
@attrs.frozen
class PressurePanel(Panel):
    """The contact pressure and the sub-grid edge of the contact; saturated cells have a colour of their own.

    Attributes
    ----------
    edge
        Whether the edge is drawn.
    """

    edge: bool = attrs.field(default=True, converter=_edge)

    def draw(self, subject: Any, axes: Any) -> None:
        """Draw a solution; see `Panel.draw`."""
        theme = theme_of(axes)
        factor, unit = pressure_scale(subject)
        axes.set_facecolor(theme.open)
        shown = np.where(subject.contact, factor * subject.pressure, np.nan)
        highest = factor * float(subject.pressure.max())
        draw_map(axes, shown, subject.grid, "pressure", unit, limits=(0.0, highest))
        named = []
        if subject.saturated.any():
            draw_mask(axes, subject.saturated, theme.limit)
            named.append((theme.limit, "saturated"))
        named += _mark_unknown(axes, subject)
        name_colors(axes, named)
        if self.edge:
            draw_edges(axes, subject, theme.edge)


@final
@attrs.frozen
class GapPanel(Panel):
    """The gap after deformation; the contact is white.

    Attributes
    ----------
    logarithmic
        Whether the colours follow the logarithm of the gap.
    """

    logarithmic: bool = attrs.field(default=True, converter=_logarithmic)

    def draw(self, subject: Any, axes: Any) -> None:
        """Draw a solution; see `Panel.draw`."""
        factor, unit = height_scale(subject)
        gap = factor * hide_non_measured(subject, subject.gap)
        opened = np.where(subject.contact, np.nan, gap)
        axes.set_facecolor("white")
        limits = None
        if np.isfinite(opened).any():
            high = float(np.nanpercentile(opened, 99.9))
            smallest = max(high, np.finfo(float).tiny) * _SMALLEST_GAP
            # Rounding may leave a gap of zero beside the contact.
            opened = np.maximum(opened, smallest)
            low = max(float(np.nanpercentile(opened, 0.5)), smallest) if self.logarithmic else 0.0
            limits = (low, high)
        draw_map(
            axes, opened, subject.grid, "gap", unit, colors="viridis_r", limits=limits, logarithmic=self.logarithmic
        )
        name_colors(axes, _mark_unknown(axes, subject))


@final
@attrs.frozen
class PatchesPanel(Panel):
    """The contact patches, coloured by the area of each."""

    def draw(self, subject: Any, axes: Any) -> None:
        """Draw a solution; see `Panel.draw`."""
        areas = areas_of_patches(subject)
        factor, unit = prefixed(float(areas.max(initial=0.0)), "m", 2)
        by_label = np.concatenate(([np.nan], factor * areas))
        low, high = (float(end) for end in (np.nanmin(by_label), np.nanmax(by_label))) if areas.size else (0.5, 1.0)
        middle = np.sqrt(low * high)
        limits = (min(low, middle / _RANGE), max(high, middle * _RANGE))
        axes.set_facecolor(theme_of(axes).open)
        draw_map(
            axes, by_label[subject.patches.labels], subject.grid, "patch area", unit, limits=limits, logarithmic=True
        )
        named = _mark_unknown(axes, subject)
        name_colors(axes, named)
        if not named:
            say(axes, f"{areas.size} patch{'' if areas.size == 1 else 'es'}")


def areas_of_patches(solution: ContactSolution) -> Array:
    """Return the area of each patch, shape (count,), m2: estimated, or counted where it is not."""
    estimated = solution.area().patches
    counted = solution.patches.areas
    return counted if estimated is None else np.where(estimated > 0.0, estimated, counted)
