"""The stress in the layers below a surface: profiles, slices, its maximum, and a file for ParaView."""

from __future__ import annotations

import math
import os
from argparse import ArgumentTypeError
from collections.abc import Mapping
from functools import cached_property

import attrs
import numpy as np
import roughcontact as rc
from roughcontact.responses import StressMaximum
from roughcontact.typing import STRESS_COMPONENTS, Array, Length, Table, quantity, si

from roughcontact_volume.cell_maximum import find_cell_maximum
from roughcontact_volume.radial_return import find_equivalent
from roughcontact_volume.vtk_file import write_layers


@attrs.frozen(eq=False)
class LayeredStress:
    """The stress in layers below a surface, mean over each cell of each layer; tension is positive.

    Places are those of the body, of which x and y are zero in the middle of the domain and z is the depth.

    Attributes
    ----------
    grid
        The cells of a layer.
    interfaces
        Depths between the layers, from 0 at the surface, shape (nz + 1,), m.
    components
        The components xx, yy, zz, yz, xz, xy, shape (6, nz, nx, ny), Pa.
    step_error
        Error by the substeps of the loads, over the largest stress.
    most
        Von Mises stress that a body which flows exceeds nowhere, Pa.
    warnings
        Why the stress must not be trusted, in sentences; empty without a reason.
    """

    grid: rc.Grid
    interfaces: Array
    components: Array = attrs.field(repr=False)
    step_error: float = 0.0
    most: float = math.inf
    warnings: tuple[str, ...] = ()

    @property
    def depths(self) -> Array:
        """Depths of the middles of the layers, shape (nz,), m."""
        return np.asarray(0.5 * (self.interfaces[1:] + self.interfaces[:-1]))

    @cached_property
    def von_mises(self) -> Array:
        """Von Mises equivalent stress, shape (nz, nx, ny), Pa."""
        return find_equivalent(self.components)

    @property
    def maximum(self) -> StressMaximum:
        """The largest von Mises stress of a cell, and its place.

        Its uncertainty is that by the substeps, and by the cells; with the pressure no stress is beyond the yield
        stress.
        """
        found = find_cell_maximum(self.von_mises, self.grid, self.interfaces, self.step_error, self.most)
        return StressMaximum(found.value, found.uncertainty, found.x, found.y, found.depth, warnings=self.warnings)

    @property
    def estimates(self) -> Mapping[str, rc.Estimate]:
        """The largest von Mises stress."""
        return {"von_mises": self.maximum}

    def find_profile(self, x: Length = 0.0, y: Length = 0.0) -> Table:
        """Return the stress under a point: a row for each layer, with depth, m, components and von Mises stress, Pa.

        Parameters
        ----------
        x, y
            The point, m; between the middles of cells it is linear.
        """
        stress = _interpolate(self.components, self._find_weights(0, x), self._find_weights(1, y))
        columns = {"depth": self.depths, **dict(zip(STRESS_COMPONENTS, stress, strict=True))}
        columns["von_mises"] = find_equivalent(stress)
        return Table(columns, {"depth": "m", **dict.fromkeys([*STRESS_COMPONENTS, "von_mises"], "Pa")})

    def cut(self, *, x: Length | None = None, y: Length | None = None, depth: Length | None = None) -> Array:
        """Return the components in a plane through cells, Pa.

        Parameters
        ----------
        x, y, depth
            One of them: the place of the plane, m. The shape is (6, nz, ny), (6, nz, nx) or (6, nx, ny); at a depth it
            is that of the layer there.
        """
        given = {name: place for name, place in (("x", x), ("y", y), ("depth", depth)) if place is not None}
        if len(given) != 1:
            raise rc.InputError("A plane has one place: give one of x=, y= and depth=.")
        if depth is not None:
            place = _read_place(depth, "The depth", 0.0, float(self.interfaces[-1]))
            layer = min(int(np.searchsorted(self.interfaces, place, side="right")) - 1, len(self.depths) - 1)
            return self.components[:, layer]
        axis, where = (0, x) if x is not None else (1, y)
        first, part = self._find_weights(axis, where)
        one, other = (self.components.take(place, axis=axis + 2) for place in (first, first + 1))
        return np.asarray((1.0 - part) * one + part * other)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the components and the von Mises stress to a file ``.vtr`` for ParaView, depths along -z."""
        fields = {f"stress_{name}": one for name, one in zip(STRESS_COMPONENTS, self.components, strict=True)}
        write_layers(path, self.grid, self.interfaces, {**fields, "von_mises": self.von_mises})

    def _find_weights(self, axis: int, where: Length | None) -> tuple[int, float]:
        """Return the cell before a place, along an axis, and the weight of the one behind it."""
        middles = self.grid.x[:, 0] if axis == 0 else self.grid.y[0]
        half = 0.5 * self.grid.size[axis]
        place = _read_place(where, f"The place along {'xy'[axis]}", -half, half)
        at = np.clip((place - middles[0]) / self.grid.spacing[axis], 0.0, len(middles) - 1.0)
        first = min(int(at), len(middles) - 2)
        return first, float(at) - first

    def __str__(self) -> str:
        return (
            f"stress in {len(self.depths)} layers down to {si(float(self.interfaces[-1]), 'm')}\n"
            f"largest von Mises stress {self.maximum}"
        )


def _read_place(value: Length | None, what: str, low: float, high: float) -> float:
    try:
        place = quantity("m")(value) if isinstance(value, str) else float(value)  # type: ignore[arg-type]
    except (ArgumentTypeError, TypeError, ValueError):
        place = np.nan
    if not low <= place <= high:
        raise rc.InputError.about(what, value, f"a number from {low:g} to {high:g} (m)")
    return place


def _interpolate(values: Array, along_x: tuple[int, float], along_y: tuple[int, float]) -> Array:
    (i, a), (j, b) = along_x, along_y
    near = values[..., i : i + 2, j : j + 2]
    return np.asarray(np.einsum("...xy,x,y->...", near, [1.0 - a, a], [1.0 - b, b]))
