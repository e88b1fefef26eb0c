"""What a panel is, and what it draws."""

from __future__ import annotations

import abc
from typing import TYPE_CHECKING, Any, ClassVar

import attrs
import numpy as np

from roughcontact.checks import Array
from roughcontact.registry import Registry
from roughcontact.units import outlined

if TYPE_CHECKING:
    from roughcontact.grid import Grid


class Panel(abc.ABC):
    """One picture, drawn into axes of matplotlib. Subclass it, say what it draws, and define `draw`.

    Attributes
    ----------
    subject
        What it draws: ``"solution"``, ``"surface"`` (then `draw` gets a `SampledSurface`) or ``"sweep"``.
    """

    subject: ClassVar[str] = "solution"

    @abc.abstractmethod
    def draw(self, subject: Any, axes: Any) -> None:
        """Draw a solution, a surface or a sweep into `matplotlib.axes.Axes`.

        Raises
        ------
        InputError
            If there is nothing to draw: the sentence says why.
        """


panels = Registry(Panel, "panel", "roughcontact.panels", in_files=False)


@attrs.frozen(eq=False)
class SampledSurface:
    """Heights of a surface on a grid, as a `Panel` of surfaces gets them.

    Attributes
    ----------
    heights
        Shape `grid.shape`, m, positive outward; NaN at non-measured points.
    grid
        The cells.
    periodic
        Whether the surface repeats beyond its border.
    """

    heights: Array = attrs.field(repr=outlined)
    grid: Grid
    periodic: bool

    @property
    def rms_height(self) -> float:
        """Root mean square of the measured heights about their mean, m."""
        return float(np.nanstd(self.heights))
