"""Stress below layers: that of a homogeneous half-space, and what the layers add to it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import attrs
import numpy as np

from roughcontact._answers.subsurface.free import cell_stress
from roughcontact._answers.subsurface.maximum import PlanePeak, StressMaximum, find_maximum
from roughcontact._answers.subsurface.periodic import find_symbols
from roughcontact._base.arrays import Array, Pair, RealArray
from roughcontact._parts.kernels import SupportsStress

# Distance of the depths on both sides of an interface, over its depth: that of rounding.
_SIDE = 1e-9


@attrs.frozen(eq=False)
class BelowLayers:
    """Tables and factors of the stress below a kernel's layers, in place of those of `free` and `periodic`.

    Attributes
    ----------
    kernel
        The kernel.
    unit
        Side of a cell along x, m, in which lengths are given.
    """

    kernel: SupportsStress
    unit: float

    def find_table(
        self, z: float, poisson: float, shape: tuple[int, int], sides: Pair, dtype: type[Any], load: str = "z"
    ) -> RealArray:
        """Return the stress by a unit load on one cell; see `cell_stress`."""
        table = cell_stress(z, poisson, shape, sides, dtype, load)
        added = self.kernel.stress_coefficients(load, shape, self._lengths(sides), z * self.unit)
        return np.asarray(table + added.astype(dtype))

    def find_symbols(
        self, phases: tuple[Array, Array], sides: Pair, z: float, poisson: float, load: str = "z"
    ) -> list[RealArray]:
        """Return the factors of all waves; see `periodic.find_symbols`."""
        spacing = self._lengths(sides)
        qx, qy = (phase / side for phase, side in zip(phases, spacing, strict=True))
        added = self.kernel.stress_spectrum(load, qx[:, np.newaxis], qy[np.newaxis, :], spacing, z * self.unit)
        symbols = find_symbols(phases, sides, z, poisson, load)
        return [symbol + one.astype(np.float32) for symbol, one in zip(symbols, added, strict=True)]

    def _lengths(self, sides: Pair) -> Pair:
        return sides[0] * self.unit, sides[1] * self.unit


def with_interfaces(depths: Array, interfaces: Array) -> Array:
    """Return depths, and those of both sides of each interface among them, m, ascending."""
    inside = interfaces[interfaces < depths.max()]
    return np.unique(np.concatenate((depths, (1.0 - _SIDE) * inside, (1.0 + _SIDE) * inside)))


def find_maximum_of_layers(
    depths: Array, interfaces: Array, peaks: Sequence[PlanePeak], scale: float, cell: float
) -> StressMaximum:
    """Return the largest of the maxima in each layer, across whose interfaces the stress jumps; see `find_maximum`."""
    layer = np.searchsorted(interfaces, depths)
    found = []
    for number in np.unique(layer):
        places = np.flatnonzero(layer == number)
        one = find_maximum(depths[places], [peaks[int(place)] for place in places], scale, cell)
        # At an interface a layer ends: nothing of it lies beyond the depths.
        if np.isclose(one.depth, interfaces, rtol=1e-6, atol=0.0).any():
            kept = tuple(text for text in one.warnings if getattr(text, "rule", "") != "depths")
            one = attrs.evolve(one, warnings=kept)
        found.append(one)
    return max(found, key=lambda one: one.value)
