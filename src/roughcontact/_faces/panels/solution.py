"""Panels of a solution: fields over the plane, distributions, and a cut through both bodies."""

from __future__ import annotations

import math
from functools import partial
from typing import Any, final

import attrs
import numpy as np

from roughcontact._answers.areas.estimators import edge_law
from roughcontact._base.arrays import Array, Mask
from roughcontact._base.checks import choice, flag, number
from roughcontact._base.units import prefixed, si, with_spread
from roughcontact._faces.panels.base import Panel
from roughcontact._faces.panels.curves import add_key, say, scale_axes
from roughcontact._faces.panels.maps import (
    draw_edges,
    draw_map,
    draw_mask,
    length_scale,
    mark_non_measured,
    name_colors,
)
from roughcontact._faces.panels.theme import theme_of
from roughcontact._solve.solution import ContactSolution
from roughcontact.errors import InputError

# Heights that may be drawn.
_HEIGHTS = ("combined", "body", "counterbody")
# Gaps below this fraction of the largest have the same colour, on a logarithmic scale.
_MIN_GAP_FRACTION = 1e-4
# Smallest range of a logarithmic scale of the areas of patches.
_MIN_AREA_RATIO = 2.0
# Bins of a histogram for n numbers: about the cubic root of n, within these bounds.
_MIN_BINS = 8
_MAX_BINS = 60
# Fraction of the maximum pressure up to which the law of the edge is drawn.
_EDGE_LAW_FRACTION = 0.7
# Cells below which the area of a patch is hardly known.
_SMALL_PATCH_CELLS = 4
# Margin above and below both surfaces, over their range.
_PROFILE_MARGIN = 0.08


def height_scale(solution: ContactSolution) -> tuple[float, str]:
    """Return the factor of heights and gaps, and their unit: one for all panels of a figure."""
    gap = solution.initial_gap
    known = gap if solution.non_measured is None else gap[~solution.non_measured]
    return prefixed(float(known.max()), "m")


def pressure_scale(solution: ContactSolution) -> tuple[float, str]:
    """Return the factor of pressures, and their unit."""
    return prefixed(float(solution.pressure.max()), "Pa")


def hide_non_measured(solution: ContactSolution, values: Array) -> Array:
    """Return values, shape (nx, ny), with NaN at non-measured points."""
    return values if solution.non_measured is None else np.where(solution.non_measured, np.nan, values)


def _true_or_false(what: str) -> Any:
    return attrs.field(default=True, converter=partial(flag, what=what))


def _highest_pressure(value: object) -> float:
    return number(value, "The highest pressure that is drawn", "Pa", above=0.0)


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
        heights = -subject.initial_gap
        if self.of != "combined":
            if subject.origin is None:
                raise InputError(f"The heights of the {self.of} are not known: the solution does not say its problem.")
            heights = np.array(subject.origin.problem[self.of].heights(subject.grid))
        heights = hide_non_measured(subject, heights)
        factor, unit = height_scale(subject)
        label = "height" if self.of != "combined" else "combined height"
        draw_map(axes, factor * (heights - np.nanmean(heights)), subject.grid, label, unit, colors="cividis")
        name_colors(axes, mark_non_measured(axes, subject.non_measured))


@final
@attrs.frozen
class PressurePanel(Panel):
    """The contact pressure and the sub-grid edge of the contact; saturated cells have a colour of their own.

    Attributes
    ----------
    edge
        Whether the edge is drawn.
    highest
        Pressure at the end of the colours, Pa, such as that of several states; None: the highest one.
    """

    edge: bool = _true_or_false("edge=")
    highest: float | None = attrs.field(default=None, converter=attrs.converters.optional(_highest_pressure))

    def draw(self, subject: Any, axes: Any) -> None:
        highest = float(subject.contact_pressure.max()) if self.highest is None else self.highest
        draw_pressure(subject, axes, highest, names_saturated=subject.saturated.any(), edge=self.edge)


def draw_pressure(
    solution: ContactSolution, axes: Any, highest: float, *, names_saturated: bool, edge: bool = True
) -> None:
    """Draw the contact pressure, its colours from zero to a highest one, Pa, with or without a name for saturation."""
    theme = theme_of(axes)
    factor, unit = prefixed(highest, "Pa")
    axes.set_facecolor(theme.open)
    shown = np.where(solution.contact, factor * solution.contact_pressure, np.nan)
    draw_map(axes, shown, solution.grid, "pressure", unit, limits=(0.0, factor * highest))
    named = []
    if names_saturated:
        draw_mask(axes, solution.saturated, theme.limit)
        named.append((theme.limit, "saturated"))
    named += mark_non_measured(axes, solution.non_measured)
    name_colors(axes, named)
    if edge:
        draw_edges(axes, solution, theme.edge)


@final
@attrs.frozen
class GapPanel(Panel):
    """The gap after deformation; the contact is white.

    Attributes
    ----------
    logarithmic
        Whether the colours follow the logarithm of the gap.
    """

    logarithmic: bool = _true_or_false("logarithmic=")

    def draw(self, subject: Any, axes: Any) -> None:
        factor, unit = height_scale(subject)
        gap = factor * hide_non_measured(subject, subject.gap)
        opened = np.where(subject.contact, np.nan, gap)
        axes.set_facecolor("white")
        limits = None
        if np.isfinite(opened).any():
            high = float(np.nanpercentile(opened, 99.9))
            smallest = max(high, np.finfo(float).tiny) * _MIN_GAP_FRACTION
            # Rounding may leave a gap of zero beside the contact.
            opened = np.maximum(opened, smallest)
            low = max(float(np.nanpercentile(opened, 0.5)), smallest) if self.logarithmic else 0.0
            limits = (low, high)
        draw_map(
            axes, opened, subject.grid, "gap", unit, colors="viridis_r", limits=limits, logarithmic=self.logarithmic
        )
        name_colors(axes, mark_non_measured(axes, subject.non_measured))


@final
@attrs.frozen
class TensionPanel(Panel):
    """The attraction of the surfaces outside the contact, which is white."""

    needs_adhesion = True

    def draw(self, subject: Any, axes: Any) -> None:
        """Draw a solution; see `Panel.draw`."""
        if subject.tension is None:
            raise InputError("The surfaces do not attract each other: there is no tension to draw.")
        factor, unit = prefixed(float(subject.tension.max()), "Pa")
        outside = np.where(subject.contact, np.nan, factor * subject.tension)
        axes.set_facecolor("white")
        draw_map(axes, outside, subject.grid, "tension", unit, colors="magma_r", limits=None, logarithmic=False)


@final
@attrs.frozen
class PatchesPanel(Panel):
    """The contact patches, coloured by the area of each."""

    def draw(self, subject: Any, axes: Any) -> None:
        areas = areas_of_patches(subject)
        factor, unit = prefixed(float(areas.max(initial=0.0)), "m", 2)
        by_label = np.concatenate(([np.nan], factor * areas))
        low, high = (float(end) for end in (np.nanmin(by_label), np.nanmax(by_label))) if areas.size else (0.5, 1.0)
        middle = np.sqrt(low * high)
        limits = (min(low, middle / _MIN_AREA_RATIO), max(high, middle * _MIN_AREA_RATIO))
        axes.set_facecolor(theme_of(axes).open)
        draw_map(
            axes, by_label[subject.patches.labels], subject.grid, "patch area", unit, limits=limits, logarithmic=True
        )
        named = mark_non_measured(axes, subject.non_measured)
        name_colors(axes, named)
        if not named:
            say(axes, f"{areas.size} patch{'' if areas.size == 1 else 'es'}")


def areas_of_patches(solution: ContactSolution) -> Array:
    """Return the area of each patch, shape (count,), m2: estimated, or else counted."""
    estimated = solution.area().patches
    counted = solution.patches.areas
    return counted if estimated is None else np.where(estimated > 0.0, estimated, counted)


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
        theme = theme_of(axes)
        factor, unit = pressure_scale(subject)
        saturated = subject.saturated & subject.contact
        values = factor * subject.contact_pressure[subject.contact & ~saturated]
        highest = factor * float(subject.contact_pressure.max()) or 1.0
        bins = min(max(round(2.0 * values.size ** (1.0 / 3.0)), _MIN_BINS), _MAX_BINS)
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
            end = min(_EDGE_LAW_FRACTION * highest, top / slope)
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
        theme = theme_of(axes)
        areas = np.sort(areas_of_patches(subject))
        cell = subject.grid.cell_area
        factor, unit = prefixed(max(float(areas.max(initial=0.0)), cell), "m", 2)
        scale_axes(axes, x=f"patch area, {unit}", y="number of patches at least as large", logarithmic="xy")
        smallest = factor * min(float(areas.min(initial=cell)), cell)
        largest = factor * max(float(areas.max(initial=0.0)), 10.0 * cell)
        axes.axvspan(
            0.5 * smallest,
            factor * _SMALL_PATCH_CELLS * cell,
            color=theme.open,
            linewidth=0.0,
            label="below four cells",
        )
        if areas.size:
            numbers = np.arange(areas.size, 0, -1)
            x = factor * np.concatenate((areas, areas[-1:]))
            axes.step(x, np.append(numbers, 0.7), where="pre", color=theme.lines[0], label="_patches")
            axes.plot(factor * areas, numbers, "o", color=theme.lines[0], markersize=2.5, label="_patches")
        axes.set(
            xlim=(0.5 * smallest, 2.0 * largest), ylim=(0.7, 10.0 ** math.ceil(math.log10(max(areas.size, 2)) + 0.1))
        )
        add_key(axes)


def _axis(value: object) -> int:
    if not isinstance(value, (int, np.integer)) or isinstance(value, bool) or value not in (0, 1):
        raise InputError.about("The axis of a profile", value, "0 for a cut along x or 1 for one along y")
    return int(value)


def _position(value: float) -> float:
    return number(value, "The position of a profile", "m")


@final
@attrs.frozen
class ProfilePanel(Panel):
    """A cut through both bodies, deformed, with the contact marked; the heights are exaggerated.

    The displacement is divided between the bodies in proportion to their compliances. Where the problem of a solution
    is not known, one body has the combined heights and all of the displacement.

    Attributes
    ----------
    axis
        0 for a cut along x, 1 for one along y.
    position
        Place of the cut on the other axis from the centre, m; None: through the maximum pressure.
    """

    axis: int = attrs.field(default=0, converter=_axis)
    position: float | None = attrs.field(default=None, converter=attrs.converters.optional(_position))

    def draw(self, subject: Any, axes: Any) -> None:
        row, place = self._find_row(subject)
        theme = theme_of(axes)
        along, unit = length_scale(subject.grid)
        factor, high_unit = height_scale(subject)
        x = along * (subject.grid.x if self.axis == 0 else subject.grid.y).ravel()
        lower, upper = (factor * self._cut(field, row) for field in find_surfaces(subject))
        level = np.nanmean(lower) if np.isfinite(lower).any() else 0.0
        lower = lower - level
        upper = upper - level
        known = np.concatenate((lower, upper))[np.isfinite(np.concatenate((lower, upper)))]
        low, high = (float(known.min()), float(known.max())) if known.size else (0.0, 1.0)
        margin = _PROFILE_MARGIN * (high - low) or 1.0
        half = 0.5 * subject.grid.size[self.axis] * along
        ends = np.concatenate(([-half], x, [half]))
        below = np.pad(lower, 1, mode="edge")
        above = np.pad(upper, 1, mode="edge")
        axes.fill_between(ends, low - margin, below, color=theme.body, linewidth=0.0, label="body")
        axes.fill_between(ends, above, high + margin, color=theme.counterbody, linewidth=0.0, label="counterbody")
        axes.plot(x, lower, color=theme.ink, linewidth=0.6, label="_body")
        axes.plot(x, upper, color=theme.ink, linewidth=0.6, label="_counterbody")
        touching = np.where(self._cut(subject.contact, row), lower, np.nan)
        axes.plot(x, touching, ".-", color=theme.limit, linewidth=2.5, markersize=4, label="contact")
        name, other = ("x", "y") if self.axis == 0 else ("y", "x")
        scale_axes(axes, x=f"{name}, {unit}", y=f"height, {high_unit}")
        axes.grid(False)
        axes.set(xlim=(-half, half), ylim=(low - margin, high + margin))
        axes.plot([], [], " ", label=f"{other} = {si(place, 'm', 3)}".replace("-", "−"))
        add_key(axes)

    def _cut(self, field: Array | Mask, row: int) -> Array:
        return np.asarray(field[:, row] if self.axis == 0 else field[row])

    def _find_row(self, solution: ContactSolution) -> tuple[int, float]:
        """Return the index of the cut on the other axis, and its place, m."""
        other = 1 - self.axis
        places = (solution.grid.x[:, 0], solution.grid.y[0, :])[other]
        highest = solution.pressure == solution.pressure.max()
        if self.position is None:
            # Of several equal maxima, as of saturated cells, the one with the longest contact.
            row = int(np.argmax(np.where(highest.any(axis=self.axis), solution.contact.sum(axis=self.axis), -1)))
        else:
            half = 0.5 * solution.grid.size[other]
            if abs(self.position) > half:
                allowed = f"within {si(half, 'm')} of the centre"
                raise InputError.about("The position of a profile", si(self.position, "m"), allowed)
            row = int(np.argmin(np.abs(places - self.position)))
        return row, float(places[row])


def find_surfaces(solution: ContactSolution) -> tuple[Array, Array]:
    """Return both deformed surfaces, shape (nx, ny), m; NaN at non-measured points.

    Where saturated cells overlap, the softer body is flattened.
    """
    materials = {} if solution.origin is None else solution.origin.materials
    heights = -solution.initial_gap
    part = 1.0
    body_yields = np.array(True)
    if materials:
        body = materials["body"]
        counterbody = materials["counterbody"]
        heights = np.asarray(solution.origin.problem["body"].heights(solution.grid))  # type: ignore[union-attr]
        part = body.compliance / (body.compliance + counterbody.compliance)
        body_yields = np.less_equal(body.pressure_limit, counterbody.pressure_limit)
    lower = heights - part * solution.displacement + np.where(body_yields, np.minimum(solution.gap, 0.0), 0.0)
    upper = lower + np.maximum(solution.gap, 0.0)
    if solution.non_measured is not None:
        lower, upper = (np.where(solution.non_measured, np.nan, surface) for surface in (lower, upper))
    return lower, upper
