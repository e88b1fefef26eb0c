"""Responses of a state whose body has flowed: its plastic zone, and the imprint that it leaves."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, ClassVar

import attrs
import numpy as np
import roughcontact as rc
from roughcontact.typing import Array, Table, si

from roughcontact_volume.cell_maximum import CellMaximum, find_cell_maximum
from roughcontact_volume.flowed_body import FlowedBody, read_body
from roughcontact_volume.vtk_file import write_layers

# Standard deviation of a border that lies anywhere in its cell, over the side of the cell.
_BORDER_STD = 1.0 / math.sqrt(12.0)
# The part of all cells at the border of a zone that err together.
_BORDER_PART = 0.25
# Relative errors over that of the depth of an imprint: pile-up is narrower, and a volume is a sum. Set on seed 1 and
# half of seed 2 of `measure_scenes.py`, as is that of the border.
_PILE_UP_FACTOR = 1.5
_VOLUME_FACTOR = 0.7


@attrs.frozen(eq=False)
class PlasticZone:
    """The cells below a surface that have flowed.

    Attributes
    ----------
    grid
        The cells of a layer.
    interfaces
        Depths between the layers, from 0 at the surface, shape (nz + 1,), m.
    plastic_strain
        Components xx, yy, zz, yz, xz, xy, tensor shears, shape (6, nz, nx, ny).
    accumulated_strain
        Accumulated plastic strain, shape (nz, nx, ny).
    step_error
        Error of the strain by the substeps of the loads, over it.
    warnings
        Why it must not be trusted, in sentences; empty without a reason.
    """

    grid: rc.Grid
    interfaces: Array = attrs.field(repr=False)
    plastic_strain: Array = attrs.field(repr=False)
    accumulated_strain: Array = attrs.field(repr=False)
    step_error: float = 0.0
    warnings: tuple[str, ...] = ()

    @property
    def volume(self) -> rc.Estimate:
        """Volume of the zone, m3, known but for the part of its border in a cell."""
        flowed = np.pad(self.accumulated_strain > 0.0, 1)
        sides = (np.diff(self.interfaces)[:, np.newaxis, np.newaxis], *self.grid.spacing)
        cells = np.ones(self.accumulated_strain.shape) * sides[0] * sides[1] * sides[2]
        value = float(np.sum(cells, where=flowed[1:-1, 1:-1, 1:-1]))
        inner = (slice(1, -1),) * 3
        spread = 0.0
        for axis in range(3):
            for step in (-1, 1):
                # The surface of the body is a border that is known.
                beyond = np.roll(flowed, step, axis=axis)[inner]
                open_ = flowed[inner] & ~beyond
                if axis == 0 and step == 1:
                    open_[0] = False
                spread += float(np.sum(cells, where=open_))
        return rc.Estimate(
            value, math.hypot(_BORDER_PART * _BORDER_STD * spread, self.step_error * value), "m3", self.warnings
        )

    @property
    def depth(self) -> rc.Estimate:
        """Depth of the lowest layer that has flowed, m: the border may lie in the layer above or below it."""
        deep = np.flatnonzero(self.accumulated_strain.any(axis=(1, 2)))
        if not deep.size:
            return rc.Estimate(0.0, 0.0, "m", self.warnings)
        bottom, top = float(self.interfaces[deep[-1] + 1]), float(self.interfaces[deep[-1]])
        spread = math.hypot(2.0 * _BORDER_STD * (bottom - top), self.step_error * bottom)
        return rc.Estimate(bottom, spread, "m", self.warnings)

    @property
    def largest(self) -> CellMaximum:
        """The largest accumulated plastic strain, with its uncertainty and its place, m."""
        return find_cell_maximum(self.accumulated_strain, self.grid, self.interfaces, self.step_error)

    @property
    def estimates(self) -> Mapping[str, rc.Estimate]:
        """Volume, depth and largest accumulated strain."""
        largest = rc.Estimate(self.largest.value, self.largest.uncertainty, "", self.warnings)
        return {"volume": self.volume, "depth": self.depth, "largest_strain": largest}

    def table(self) -> Table:
        """Return a row for each layer: its depth, m, the area that has flowed, m2, mean and largest strain there."""
        flowed = self.accumulated_strain > 0.0
        count = flowed.sum(axis=(1, 2))
        columns = {
            "depth": 0.5 * (self.interfaces[1:] + self.interfaces[:-1]),
            "area": count * self.grid.cell_area,
            "mean_strain": self.accumulated_strain.sum(axis=(1, 2)) / np.maximum(count, 1),
            "largest_strain": self.accumulated_strain.max(axis=(1, 2)),
        }
        return Table(columns, {"depth": "m", "area": "m2", "mean_strain": "", "largest_strain": ""})

    def save(self, path: Any) -> None:
        """Write the strains to a file ``.vtr`` for ParaView, depths along -z."""
        names = ("xx", "yy", "zz", "yz", "xz", "xy")
        fields = {f"plastic_strain_{name}": one for name, one in zip(names, self.plastic_strain, strict=True)}
        write_layers(path, self.grid, self.interfaces, {"accumulated_strain": self.accumulated_strain, **fields})

    def __str__(self) -> str:
        largest = self.largest
        place = f"x = {si(largest.x, 'm')}, y = {si(largest.y, 'm')}, depth {si(largest.depth, 'm')}"
        lines = [f"{name.replace('_', ' ')} {one}" for name, one in self.estimates.items()]
        return "\n".join([*lines[:-1], f"{lines[-1]} at {place}"])


@attrs.frozen
class FindPlasticZone(rc.Response[PlasticZone]):
    """The plastic zone below a surface that has flowed: its volume, depth and strain.

    Parameters
    ----------
    body
        ``"body"`` or ``"counterbody"``; None: the one that flows.

    Examples
    --------
    >>> import roughcontact as rc
    >>> from roughcontact_volume import FindPlasticZone, Plastic
    >>> steel = Plastic("210GPa", 0.3, yield_stress="1GPa", hardening="4GPa")
    >>> ball = rc.Body(rc.ParaboloidSurface("1mm"), rc.Rigid())
    >>> problem = rc.ContactProblem(ball, rc.Body(rc.FlatSurface(), steel), grid=rc.Grid((15, 15), "65um"))
    >>> zone = problem.solve(force="2N").response(FindPlasticZone())
    >>> 0.002 < zone.largest.value < 0.01
    True
    """

    body: str | None = attrs.field(default=None, converter=read_body, kw_only=True)

    holds_with: ClassVar[frozenset[str]] = frozenset({"shear"})
    reads: ClassVar[str] = "state"

    def respond(self, solution: Any) -> PlasticZone:
        """Return the zone; see `Response.respond`."""
        body = FlowedBody.of(solution, self.body)
        interfaces = np.concatenate(([0.0], np.cumsum(body.thicknesses)))
        flow = body.flow
        return PlasticZone(
            body.grid, interfaces, flow.plastic_strain, flow.accumulated_strain, body.step_error, body.warnings
        )


@attrs.frozen(eq=False)
class Imprint:
    """What plastic strain leaves of a surface.

    Attributes
    ----------
    grid
        The cells.
    displacement
        Displacement of the surface by the plastic strain, shape (nx, ny), m, positive into the body.
    relative_error
        Its error over it: that of the largest plastic strain, by the substeps of the loads and by the cells.
    warnings
        Why it must not be trusted, in sentences; empty without a reason.
    """

    grid: rc.Grid
    displacement: Array = attrs.field(repr=False)
    relative_error: float = 0.0
    warnings: tuple[str, ...] = ()

    @property
    def estimates(self) -> Mapping[str, rc.Estimate]:
        """Depth and pile-up, m, and volume below the former surface, m3."""
        deepest = max(0.0, float(self.displacement.max()))
        numbers = {
            "depth": (deepest, "m", 1.0),
            "pile_up": (max(0.0, -float(self.displacement.min())), "m", _PILE_UP_FACTOR),
            "volume": (float(np.maximum(self.displacement, 0.0).sum()) * self.grid.cell_area, "m3", _VOLUME_FACTOR),
        }
        return {
            name: rc.Estimate(value, factor * self.relative_error * value, unit, self.warnings)
            for name, (value, unit, factor) in numbers.items()
        }

    def __str__(self) -> str:
        return "\n".join(f"{name.replace('_', ' ')} {one}" for name, one in self.estimates.items())


@attrs.frozen
class FindImprint(rc.Response[Imprint]):
    """The imprint in a surface that has flowed: its depth, pile-up and volume, and the field.

    `LoadPath.bodies` returns the bodies with these heights: pressed again as of another problem they have neither the
    residual stress nor the hardening, which `LoadPath.extend` keeps.

    Parameters
    ----------
    body
        ``"body"`` or ``"counterbody"``; None: the one that flows.

    Examples
    --------
    >>> import roughcontact as rc
    >>> from roughcontact_volume import FindImprint, Plastic
    >>> steel = Plastic("210GPa", 0.3, yield_stress="1GPa", hardening="4GPa")
    >>> ball = rc.Body(rc.ParaboloidSurface("1mm"), rc.Rigid())
    >>> problem = rc.ContactProblem(ball, rc.Body(rc.FlatSurface(), steel), grid=rc.Grid((15, 15), "65um"))
    >>> path = problem.path(force=["2N", "0N"])
    >>> 40e-9 < path[1].response(FindImprint()).estimates["depth"].value < 60e-9
    True
    """

    body: str | None = attrs.field(default=None, converter=read_body, kw_only=True)

    holds_with: ClassVar[frozenset[str]] = frozenset({"shear"})
    reads: ClassVar[str] = "state"

    def respond(self, solution: Any) -> Imprint:
        """Return the imprint; see `Response.respond`."""
        zone = FindPlasticZone(body=self.body).respond(solution)
        largest = zone.largest
        relative = largest.uncertainty / largest.value if largest.value > 0.0 else 0.0
        return Imprint(zone.grid, FlowedBody.of(solution, self.body).flow.imprint, relative, zone.warnings)
