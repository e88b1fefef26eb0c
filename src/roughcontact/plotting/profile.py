"""A cut through both bodies."""

from __future__ import annotations

from typing import Any, final

import attrs
import numpy as np

from roughcontact._solution import ContactSolution
from roughcontact.checks import Array, number
from roughcontact.errors import InputError
from roughcontact.panel import Panel
from roughcontact.panel.curves import add_key, say, scale_axes
from roughcontact.panel.maps import length_scale
from roughcontact.panel.theme import theme_of
from roughcontact.plotting.fields import height_scale
from roughcontact.units import si

# Margin above and below both surfaces, over their range.
_MARGIN = 0.08


def _axis(value: object) -> int:
    if value not in (0, 1) or isinstance(value, bool):
        raise InputError.about("The axis of a profile", value, "0 for a cut along x or 1 for one along y")
    return int(value)  # type: ignore[call-overload, no-any-return]


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
    position: float | None = attrs.field(
        default=None, converter=attrs.converters.optional(lambda value: number(value, "The position of a profile", "m"))
    )

    def draw(self, subject: Any, axes: Any) -> None:
        """Draw a solution; see `Panel.draw`."""
        row, place = self._find_row(subject)
        theme, (along, unit), (factor, high_unit) = theme_of(axes), length_scale(subject.grid), height_scale(subject)
        cut = (lambda field: field[:, row]) if self.axis == 0 else (lambda field: field[row, :])
        x = along * (subject.grid.x if self.axis == 0 else subject.grid.y).ravel()
        heights, part = _split(subject)
        lower = cut(heights - part * subject.displacement)
        lower = factor * (lower - np.nanmean(lower))
        # Saturated cells overlap by what the bodies are flattened.
        upper = lower + factor * np.maximum(cut(subject.gap), 0.0)
        known = np.isfinite(lower) if subject.non_measured is None else ~cut(subject.non_measured)
        lower, upper = np.where(known, lower, np.nan), np.where(known, upper, np.nan)
        touching = cut(subject.contact) & known
        low, high = (np.nanmin(lower), np.nanmax(upper)) if known.any() else (0.0, 1.0)
        margin = _MARGIN * (high - low) or 1.0
        low, high = low - margin, high + margin
        half = 0.5 * subject.grid.size[self.axis] * along
        axes.fill_between(
            x, low, lower, color=theme.body, linewidth=0.0, label="body", step="mid" if x.size < 3 else None
        )
        axes.fill_between(x, upper, high, color=theme.counterbody, linewidth=0.0, label="counterbody")
        axes.plot(x, lower, color=theme.ink, linewidth=0.6, label="_body")
        axes.plot(x, upper, color=theme.ink, linewidth=0.6, label="_counterbody")
        marked = np.where(touching, lower, np.nan)
        axes.plot(x, marked, ".-", color=theme.limit, linewidth=2.5, markersize=4, label="contact")
        name, other = ("x", "y") if self.axis == 0 else ("y", "x")
        scale_axes(axes, x=f"{name}, {unit}", y=f"height, {high_unit}")
        axes.grid(False)
        axes.set(xlim=(-half, half), ylim=(low, high))
        add_key(axes)
        say(axes, f"{other} = {si(place, 'm', 3)}", loc="right")

    def _find_row(self, solution: ContactSolution) -> tuple[int, float]:
        """Return the index of the cut on the other axis, and its place, m."""
        other = 1 - self.axis
        places = (solution.grid.x[:, 0], solution.grid.y[0, :])[other]
        if self.position is None:
            row = int(np.unravel_index(int(np.argmax(solution.pressure)), solution.grid.shape)[other])
        else:
            half = 0.5 * solution.grid.size[other]
            if abs(self.position) > half:
                allowed = f"within {si(half, 'm')} of the centre"
                raise InputError.about("The position of a profile", si(self.position, "m"), allowed)
            row = int(np.argmin(np.abs(places - self.position)))
        return row, float(places[row])


def _split(solution: ContactSolution) -> tuple[Array, float]:
    """Return the heights of the body, shape (nx, ny), m, and the fraction of the displacement that is its own."""
    materials = {} if solution.origin is None else solution.origin.materials
    if not materials:
        return -solution.initial_gap, 1.0
    compliance = {name: material.compliance for name, material in materials.items()}
    heights = np.asarray(solution.origin.problem["body"].heights(solution.grid))  # type: ignore[union-attr]
    return heights, compliance["body"] / sum(compliance.values())
