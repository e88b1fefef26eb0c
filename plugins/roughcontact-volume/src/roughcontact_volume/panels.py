"""Panels of a state whose body has flowed: what lies in a plane below its surface, over the depth."""

from __future__ import annotations

import math
from typing import Any, ClassVar

import attrs
import numpy as np
import roughcontact as rc
from roughcontact.plotting import add_key, draw_section, theme_of
from roughcontact.typing import Array, Length, Mask, si

from roughcontact_volume.box import count_layers, list_layers
from roughcontact_volume.flow import PlasticFlow
from roughcontact_volume.flowed_body import FlowedBody, read_body
from roughcontact_volume.plastic_zone import FindPlasticZone, PlasticZone
from roughcontact_volume.stress_answers import FindResidualStress, FindTotalStress

# Depth down to which strain is drawn, as stress is, over that of the plastic zone.
_DRAWN_DEPTH = 2.0


def _axis(value: object) -> int:
    if isinstance(value, bool) or value not in (0, 1):
        raise rc.InputError.about("The axis of a plane", value, "0 for a plane along x or 1 for one along y")
    return 1 if value else 0


def _position(value: Length | None) -> float | None:
    if value is None:
        return None
    try:
        place = float(value)
    except (TypeError, ValueError):
        place = np.nan
    if not math.isfinite(place):
        raise rc.InputError.about("The position of a plane", value, "a finite number (m)")
    return place


@attrs.frozen
class PlasticZonePanel(rc.Panel):
    """The accumulated plastic strain in a plane through the deepest point that has flowed.

    Attributes
    ----------
    axis
        0 for a plane along x, 1 for one along y.
    position
        Place of the plane on the other axis, in the frame of the body, m; None: through the cell with the largest
        strain of the deepest layer that has flowed, or through the maximum pressure where nothing has.
    body
        ``"body"`` or ``"counterbody"``; None: the one that flows, of two that of the deeper plastic zone.

    Examples
    --------
    >>> import roughcontact as rc
    >>> from roughcontact_volume import Plastic, PlasticZonePanel
    >>> steel = Plastic("210GPa", 0.3, yield_stress="1GPa", hardening="4GPa")
    >>> ball = rc.Body(rc.ParaboloidSurface("1mm"), rc.Rigid())
    >>> problem = rc.ContactProblem(ball, rc.Body(rc.FlatSurface(), steel), grid=rc.Grid((12, 12), "100um"))
    >>> axes = problem.solve(force="2N").plot(PlasticZonePanel(axis=1))
    >>> axes.get_xlabel(), axes.get_ylabel()
    ('y, µm', 'depth, µm')
    """

    axis: int = attrs.field(default=0, converter=_axis)
    position: float | None = attrs.field(default=None, converter=_position, metadata={"unit": "m"})
    body: str | None = attrs.field(default=None, converter=read_body, kw_only=True)

    needs_law: ClassVar[type[rc.Law] | None] = PlasticFlow
    quantity: ClassVar[str] = "accumulated plastic strain"
    unit: ClassVar[str] = ""

    def draw(self, subject: Any, axes: Any) -> None:
        """Draw a solution; see `Panel.draw`."""
        side = self.body or _find_deeper(subject)
        zone = FindPlasticZone(body=side).respond(subject)
        pressure = FlowedBody.of(subject, side).pressure
        row, place = self._find_row(zone, pressure)
        interfaces, values = self.find_values(subject, side)
        shown = self._cut(values, row)
        strain = self._cut(_fit(zone.accumulated_strain, len(shown)), row)
        theme = theme_of(axes)
        axes.set_facecolor(theme.open)
        shown = np.where(shown > 0.0, shown, np.nan)
        image = draw_section(axes, shown, zone.grid, interfaces, self.quantity, self.unit, axis=self.axis)
        ends, depths = image.get_coordinates()[0, :, 0], image.get_coordinates()[:, 0, 1]
        _outline(axes, ends, depths, strain > 0.0, theme.edge)
        touching = self._cut(pressure[np.newaxis], row)[0] > 0.0
        _mark_contact(axes, ends, touching, theme.limit)
        where = f"{'yx'[self.axis]} = {si(place, 'm', 3)}".replace("-", "−")
        where += f", {side}" if len(FlowedBody.list_of(subject)) > 1 else ""
        axes.plot([], [], " ", label=where if strain.any() else f"{where}, nothing has flowed")
        add_key(axes)

    def find_values(self, subject: Any, side: str) -> tuple[Array, Array]:
        """Return depths between layers, shape (nz + 1,), m, and what is drawn in them, shape (nz, nx, ny)."""
        zone = FindPlasticZone(body=side).respond(subject)
        count = count_layers(zone.grid, _DRAWN_DEPTH * zone.depth.value or float(zone.interfaces[-1]))
        interfaces = np.concatenate(([0.0], np.cumsum(list_layers(zone.grid, count))))
        return interfaces, _fit(zone.accumulated_strain, count)

    def _find_row(self, zone: PlasticZone, pressure: Array) -> tuple[int, float]:
        """Return the index of the plane on the other axis, and its place, m."""
        other = 1 - self.axis
        places = (zone.grid.x[:, 0], zone.grid.y[0])[other]
        if self.position is None:
            strain = zone.accumulated_strain
            layers = np.flatnonzero(strain.any(axis=(1, 2)))
            field = strain[layers[-1]] if layers.size else pressure
            row = int(np.argmax(field.max(axis=self.axis)))
        else:
            half = 0.5 * zone.grid.size[other]
            if abs(self.position) > half:
                allowed = f"within {si(half, 'm')} of the centre"
                raise rc.InputError.about("The position of a plane", si(self.position, "m"), allowed)
            row = int(np.argmin(np.abs(places - self.position)))
        return row, float(places[row])

    def _cut(self, values: Array, row: int) -> Array:
        """Return the values of layers, shape (nz, nx, ny), in the plane."""
        return values[:, :, row] if self.axis == 0 else values[:, row]


@attrs.frozen
class ResidualStressPanel(PlasticZonePanel):
    """The von Mises stress that flow leaves, in a plane through the deepest point that has flowed."""

    quantity: ClassVar[str] = "residual von Mises stress"
    unit: ClassVar[str] = "Pa"
    response: ClassVar[type[FindResidualStress]] = FindResidualStress

    def find_values(self, subject: Any, side: str) -> tuple[Array, Array]:
        """Return what is drawn, Pa; see `PlasticZonePanel.find_values`."""
        found = self.response(body=side).respond(subject)
        return found.interfaces, found.von_mises


@attrs.frozen
class TotalStressPanel(ResidualStressPanel):
    """The von Mises stress by the pressure and by what has flowed, in a plane through the deepest point that has."""

    quantity: ClassVar[str] = "von Mises stress"
    response: ClassVar[type[FindResidualStress]] = FindTotalStress


def _find_deeper(subject: Any) -> str:
    """Return the side of the body that flows, of two that of the deeper plastic zone."""
    sides = [one.side for one in FlowedBody.list_of(subject)]
    return max(sides, key=lambda side: FindPlasticZone(body=side).respond(subject).depth.value)


def _fit(strain: Array, count: int) -> Array:
    """Return the strain of a number of layers, zero below those that are known."""
    return np.pad(strain, ((0, max(0, count - len(strain))), (0, 0), (0, 0)))[:count]


def _outline(axes: Any, ends: Array, depths: Array, flowed: Mask, color: str) -> None:
    """Draw the border of the cells that have flowed, of a plane, shape (layers, cells), if there are any."""
    from matplotlib.collections import LineCollection

    inside = np.pad(flowed, 1)
    lines = [
        ((ends[i], depths[k]), (ends[i + 1], depths[k])) for k, i in np.argwhere(inside[:-1, 1:-1] != inside[1:, 1:-1])
    ]
    lines += [
        ((ends[i], depths[k]), (ends[i], depths[k + 1])) for k, i in np.argwhere(inside[1:-1, :-1] != inside[1:-1, 1:])
    ]
    if lines:
        axes.add_collection(LineCollection(lines, colors=color, linewidths=1.0, label="has flowed"), autolim=False)


def _mark_contact(axes: Any, ends: Array, touching: Mask, color: str) -> None:
    """Draw the contact on the surface, of cells along a plane, shape (cells,), if there is any."""
    from matplotlib.collections import LineCollection

    lines = [((ends[i], 0.0), (ends[i + 1], 0.0)) for i in np.flatnonzero(touching)]
    if lines:
        marks = LineCollection(lines, colors=color, linewidths=4.0, label="contact", clip_on=False, zorder=3)
        axes.add_collection(marks, autolim=False)
