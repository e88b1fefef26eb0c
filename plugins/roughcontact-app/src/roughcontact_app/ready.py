"""What processes need before their first task; imported once by the process that they are forked from."""

from __future__ import annotations

import contextlib
import io
import os

os.environ["MPLBACKEND"] = "agg"

from roughcontact_app import work


def _draw_nothing() -> None:
    """Draw an empty picture, so that fonts and formulas are read."""
    # Without matplotlib, or with a broken one, the first picture says so.
    with contextlib.suppress(Exception):
        from matplotlib import pyplot

        figure, axes = pyplot.subplots()
        axes.set(title="$10^2$ µm", xscale="log")
        figure.savefig(io.BytesIO(), format="png", bbox_inches="tight")
        pyplot.close(figure)


_draw_nothing()

__all__ = ["work"]
