"""Panels of a sweep: approach, contact area and stiffness over the load, with bands of two standard deviations."""

from __future__ import annotations

from typing import Any, final

import attrs
import numpy as np

from roughcontact._base.checks import Array
from roughcontact._base.units import prefixed
from roughcontact._faces.panels.base import Panel
from roughcontact._faces.panels.curves import draw_band, scale_axes
from roughcontact._faces.panels.layout import loads_of
from roughcontact._solve.problem import Sweep
from roughcontact._solve.solution import Estimate
from roughcontact.errors import InputError

# Smallest load over the largest, of those that a unit is chosen for.
_NARROW = 1e-4


def _scale_loads(sweep: Sweep) -> tuple[Array, str]:
    """Return the loads in the unit that suits them and a label."""
    loads, name, unit = loads_of(sweep)
    # The unit suits the middle of the range.
    factor, prefixed_unit = prefixed(float(np.sqrt(loads.max() * max(loads.min(), _NARROW * loads.max()))), unit)
    return factor * loads, f"{name}, {prefixed_unit}"


def _draw(axes: Any, sweep: Sweep, estimates: list[tuple[float, float]], unit: str, name: str) -> None:
    """Draw values and standard deviations over the load, with logarithmic axes where both are positive."""
    loads, label = _scale_loads(sweep)
    values, deviations = np.array(estimates).T
    drawn = np.isfinite(values) & np.isfinite(loads)
    if not drawn.any():
        raise InputError(f"The {name} is not finite at any load, so that there is nothing to draw.")
    order = np.argsort(loads[drawn], kind="stable")
    x, y, spread = (column[drawn][order] for column in (loads, values, deviations))
    factor, prefixed_unit = prefixed(float(np.abs(y).max()), unit) if unit != "%" else (100.0, "% of nominal")
    positive = bool((x > 0.0).all() and (y > 0.0).all())
    scale_axes(axes, x=label, y=f"{name}, {prefixed_unit}", logarithmic="xy" if positive else "")
    draw_band(axes, x, factor * y, factor * spread)


@final
@attrs.frozen
class AreaLoadPanel(Panel):
    """The real contact area over the load."""

    subject = "sweep"

    def draw(self, subject: Any, axes: Any) -> None:
        """Draw a sweep; see `Panel.draw`."""
        found = [solution.area() for solution in subject.solutions]
        nominal = subject.solutions[0].grid.area
        _draw(axes, subject, [(one.fraction, one.uncertainty / nominal) for one in found], "%", "contact area")


@final
@attrs.frozen
class StiffnessLoadPanel(Panel):
    """The normal stiffness over the load; infinite ones, of full contact, are not drawn."""

    subject = "sweep"

    def draw(self, subject: Any, axes: Any) -> None:
        """Draw a sweep; see `Panel.draw`."""
        found = [solution.stiffness() for solution in subject.solutions]
        _draw(axes, subject, [(one.value, one.uncertainty) for one in found], "N/m", "stiffness")


@final
@attrs.frozen
class LoadApproachPanel(Panel):
    """The load over the approach, since the first touch of the summits between the cells."""

    subject = "sweep"

    def draw(self, subject: Any, axes: Any) -> None:
        """Draw a sweep; see `Panel.draw`."""
        found: list[Estimate] = [solution.response("approach") for solution in subject.solutions]
        loads, label = _scale_loads(subject)
        approach, deviation = (np.array([getattr(one, name) for one in found]) for name in ("value", "uncertainty"))
        factor, unit = prefixed(float(np.abs(approach).max()), "m")
        order = np.argsort(approach, kind="stable")
        x = factor * approach[order]
        y = loads[order]
        spread = factor * deviation[order]
        scale_axes(axes, x=f"approach since first touch, {unit}", y=label)
        line = draw_band(axes, x, y, np.zeros(y.size))
        axes.fill_betweenx(y, x - 2.0 * spread, x + 2.0 * spread, color=line.get_color(), alpha=0.25, linewidth=0.0)
