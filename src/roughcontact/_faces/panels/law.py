"""The figure of a column of a law."""

from __future__ import annotations

from typing import Any

import numpy as np

from roughcontact._answers.laws import LawColumn, PowerFit
from roughcontact._base.checks import Array
from roughcontact._base.units import prefixed
from roughcontact._faces.panels.curves import add_key, draw_band, scale_axes
from roughcontact._faces.panels.theme import require_matplotlib, style, theme_of
from roughcontact.errors import InputError


def draw_column(pressures: Array, column: LawColumn, fit: PowerFit | None, axes: Any) -> Any:
    """Draw a column over the pressure; see `InterfaceLaw.plot`."""
    require_matplotlib()
    from matplotlib import pyplot
    from matplotlib.axes import Axes

    if axes is None:
        with style():
            axes = pyplot.subplots(layout="constrained")[1]
    if not isinstance(axes, Axes):
        raise InputError.about("The axes", axes, "an Axes of matplotlib, or None")
    values = column.values
    theme = theme_of(axes)
    shown = np.isfinite(values) & (values > 0.0)
    factor, unit = prefixed(float(np.sqrt(pressures.min() * pressures.max())), "Pa")
    name = column.name.replace("_", " ")
    with style(theme.is_dark):
        scale, named = _unit_of(column)
        spread = scale * column.uncertainties[shown]
        draw_band(axes, factor * pressures[shown], scale * values[shown], spread, label=name)
        if fit is not None:
            ends = np.array(fit.pressures)
            label = f"exponent {fit.exponent:.3f} ± {fit.exponent_std:.1g}"
            power = scale * fit.factor * (ends / fit.pivot) ** fit.exponent
            axes.plot(factor * ends, power, "--", color=theme.ink, zorder=3, label=label)
        # The mean gap falls with the logarithm of the pressure, the others rise with powers of it.
        scales = "x" if column.name == "mean_gap" else "xy"
        scale_axes(
            axes, x=f"nominal mean pressure, {unit}", y=f"{name}, {named}" if named else name, logarithmic=scales
        )
        add_key(axes)
    return axes


def _unit_of(column: LawColumn) -> tuple[float, str]:
    """Return the unit in which a column is drawn, and what its values are multiplied by for it."""
    if column.unit == "m":
        return prefixed(float(np.nanmax(column.values)), "m")
    if column.name == "area":
        return 1.0, "fraction of nominal"
    return 1.0, column.unit.replace("m2", "m²").replace("m3", "m³")
