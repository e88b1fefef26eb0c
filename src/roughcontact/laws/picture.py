"""The figure of a column of a law."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from roughcontact.checks import Array
from roughcontact.errors import InputError, MissingPackage
from roughcontact.laws.fits import PowerFit

try:
    from matplotlib import pyplot
    from matplotlib.axes import Axes
    from matplotlib.ticker import EngFormatter
except ImportError:
    raise MissingPackage("Drawing needs matplotlib: pip install 'roughcontact[plot]'.") from None

if TYPE_CHECKING:
    from roughcontact.laws.law import LawColumn


def draw_column(pressures: Array, column: LawColumn, fit: PowerFit | None, axes: Axes | None) -> Axes:
    """Draw a column over the pressure; see `InterfaceLaw.plot`."""
    if axes is None:
        axes = pyplot.subplots(layout="constrained")[1]
    if not isinstance(axes, Axes):
        raise InputError.about("The axes", axes, "an Axes of matplotlib, or None")
    values, spread = column.values, 2.0 * column.uncertainties
    shown = np.isfinite(values) & (values > 0.0)
    (line,) = axes.plot(pressures[shown], values[shown], "o-", markersize=3.5, label=column.name.replace("_", " "))
    lower = np.maximum(values - spread, 0.05 * values)
    axes.fill_between(pressures[shown], lower[shown], (values + spread)[shown], color=line.get_color(), alpha=0.25)
    if fit is not None:
        ends = np.array(fit.pressures)
        label = f"exponent {fit.exponent:.3f} +- {fit.exponent_std:.1g}"
        axes.plot(
            ends,
            fit.factor * (ends / fit.pivot) ** fit.exponent,
            "--",
            color="0.2",
            linewidth=1.5,
            zorder=3,
            label=label,
        )
    # The mean gap falls with the logarithm of the pressure, the others rise with powers of it.
    axes.set(xscale="log", yscale="linear" if column.name == "mean_gap" else "log", xlabel="nominal mean pressure")
    axes.set_ylabel(column.name.replace("_", " ") + (f", {column.unit}" if column.unit else ""))
    axes.xaxis.set_major_formatter(EngFormatter("Pa"))
    axes.grid(alpha=0.3, which="both")
    axes.legend()
    return axes
