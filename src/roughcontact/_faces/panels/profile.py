"""A cut through both bodies."""

from __future__ import annotations

from typing import Any, final

import attrs
import numpy as np

from roughcontact._base.checks import Array, Mask, number
from roughcontact._base.units import si
from roughcontact._faces.panels.base import Panel
from roughcontact._faces.panels.curves import add_key, scale_axes
from roughcontact._faces.panels.fields import height_scale
from roughcontact._faces.panels.maps import length_scale
from roughcontact._faces.panels.theme import theme_of
from roughcontact._solve.solution import ContactSolution
from roughcontact.errors import InputError

# Margin above and below both surfaces, over their range.
_MARGIN = 0.08


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
        """Draw a solution; see `Panel.draw`."""
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
        margin = _MARGIN * (high - low) or 1.0
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
            # Of several equal maxima, as of saturated cells, that with the longest contact.
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
