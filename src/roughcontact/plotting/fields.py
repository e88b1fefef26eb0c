"""Panels of a solution over the plane."""

from __future__ import annotations

from typing import Any, final

import attrs
import numpy as np

from roughcontact.panel import Panel


@final
@attrs.frozen
class PressurePanel(Panel):
    """The contact pressure."""

    def draw(self, subject: Any, axes: Any) -> None:
        """Draw it."""
        lx, ly = subject.grid.size
        shown = np.where(subject.contact, subject.pressure, np.nan)
        axes.imshow(shown.T, origin="lower", extent=(-lx / 2, lx / 2, -ly / 2, ly / 2))
