"""The figure of several panels, as notebooks and files need it."""

from __future__ import annotations

from typing import Any

import matplotlib
from matplotlib.figure import Figure


class FigureView(Figure):
    """A figure that is saved with at least one pixel for each cell of its maps, and that notebooks show once."""

    saving_dpi = 150.0

    def savefig(self, fname: Any, **options: Any) -> None:
        """Save the figure; see `matplotlib.figure.Figure.savefig`."""
        if matplotlib.rcParams["savefig.dpi"] == "figure":
            options.setdefault("dpi", self.saving_dpi)
        super().savefig(fname, **options)

    def _ipython_display_(self) -> None:
        # With figures in line, a notebook shows the value of a cell and then all figures of pyplot: once is enough.
        from matplotlib import pyplot

        if "inline" in matplotlib.get_backend():
            pyplot.close(self)
        raise NotImplementedError  # the notebook shows it like any other figure
