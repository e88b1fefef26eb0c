"""The box of a plastic zone: layers of cells below the surface, as deep as the material yields."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
import roughcontact as rc
from roughcontact.typing import Array, si

from roughcontact_volume.kept_stress import take_stress
from roughcontact_volume.operators import VolumeOperators
from roughcontact_volume.radial_return import find_equivalent
from roughcontact_volume.yielding import Yielding

# Thickness of the uppermost layer over the side of a cell, and of each layer over that above it: measured, they cost
# half of equal layers and lose nothing.
_FIRST_LAYER = 0.7
_GROWTH = 1.15
# The same of the layers in which an elastic stress is looked through, and their depth over the larger side of the grid.
_GROWTH_OF_PROBE = 1.5
_DEEPEST = 1.0
# Von Mises stress of an elastic contact over the yield stress, from which on there is a box.
_NEAR_YIELD = 0.8
# The same down to which the first box reaches: at most two layers more than balls and rough surfaces need, up to a
# hundred times the load of first yield.
_LOWEST_STRESS = 0.7
# Depth of a box that grows, over its depth before.
_DEEPENING = 1.5


def list_layers(grid: rc.Grid, count: int) -> Array:
    """Return the thicknesses of the layers of a box, from the surface down, m."""
    return np.asarray(_FIRST_LAYER * _find_side(grid) * _GROWTH ** np.arange(float(count)))


def count_layers(grid: rc.Grid, depth: float) -> int:
    """Return the number of layers that reach to a depth, m."""
    ratio = depth / (_FIRST_LAYER * _find_side(grid))
    # A rounding more is not a layer more.
    return max(1, math.ceil(math.log1p(ratio * (_GROWTH - 1.0)) / math.log(_GROWTH) - 1e-9))


def count_deeper(grid: rc.Grid, count: int) -> int:
    """Return the number of layers of a box that is half as deep again; `InputError` beyond what a grid resolves."""
    depth = _DEEPENING * float(list_layers(grid, count).sum())
    require_depth(grid, depth)
    return max(count + 1, count_layers(grid, depth))


def require_depth(grid: rc.Grid, depth: float) -> None:
    """Raise `InputError` if a plastic zone is deeper than the grid is wide."""
    deepest = _DEEPEST * max(grid.size)
    if depth > _DEEPENING * deepest:
        raise rc.InputError(
            f"The material yields deeper than {si(deepest, 'm')}, the side of the grid: its load yields the bulk. "
            "Choose a smaller load, or a larger grid."
        )


def find_yield_depth(grid: rc.Grid, boundary: rc.Boundary, material: Yielding, pressure: Array) -> float:
    """Return the depth down to which a body that never flowed is near its yield stress, m; zero where it is nowhere.

    Parameters
    ----------
    grid, boundary
        The grid of the surface and its boundary.
    material
        The material.
    pressure
        The pressure, Pa, shape (nx, ny).
    """
    thicknesses = probe_layers(grid)
    bottoms = np.cumsum(thicknesses)
    stress = _press_probe(grid, boundary, material, pressure)
    pairs = zip(bottoms - thicknesses, bottoms, strict=True)
    parts = [_find_part_of_yield(material, stress[:, z], top, bottom) for z, (top, bottom) in enumerate(pairs)]
    near = [z for z, part in enumerate(parts) if part > _NEAR_YIELD]
    if not near:
        return 0.0
    if near[-1] == len(parts) - 1:
        require_depth(grid, math.inf)
    if material.residual is not None:
        # What is near its yield stress may lie anywhere in the layer.
        return float(bottoms[near[-1]])
    last = max(z for z, part in enumerate(parts) if part > _LOWEST_STRESS)
    if last == len(parts) - 1:
        return float(bottoms[last])
    # Between the middles of two layers the stress falls as a power of the depth.
    upper, lower = (bottoms - 0.5 * thicknesses)[last : last + 2]
    way = math.log(parts[last] / _LOWEST_STRESS) / math.log(parts[last] / parts[last + 1])
    return float(upper * (lower / upper) ** way)


def _find_part_of_yield(material: Yielding, stress: Array, top: float, bottom: float) -> float:
    """Return the largest von Mises stress in a layer over the yield stress, with the residual stress at any depth.

    The stress has shape (6, nx, ny), Pa; where there is a residual stress, what it adds to the von Mises stress of that
    counts, over what that leaves to the yield stress.
    """
    given = material.residual
    if given is None:
        return float(find_equivalent(stress).max()) / material.yield_stress
    # The von Mises stress is convex: between points of the residual stress, where that is linear, it is less.
    points = np.concatenate(([top], given.depth[(given.depth > top) & (given.depth < bottom)], [bottom]))
    found = []
    for own in given.find_stress(points).T:
        rest = float(find_equivalent(own))
        most = float(find_equivalent(stress + own[:, np.newaxis, np.newaxis]).max())
        found.append((most - rest) / (material.yield_stress - rest))
    return max(found)


def probe_layers(grid: rc.Grid) -> Array:
    """Return the thicknesses of the layers in which an elastic stress is looked through, m."""
    first = _FIRST_LAYER * _find_side(grid)
    ratio = _DEEPEST * max(grid.size) / first
    count = math.ceil(math.log1p(ratio * (_GROWTH_OF_PROBE - 1.0)) / math.log(_GROWTH_OF_PROBE))
    return np.asarray(first * _GROWTH_OF_PROBE ** np.arange(float(count)))


def find_largest_below(grid: rc.Grid, boundary: rc.Boundary, material: Yielding, pressure: Array) -> Array:
    """Return the largest von Mises stress in each of `probe_layers` of a body that never flowed, Pa."""
    stress = _press_probe(grid, boundary, material, pressure)
    stress += material.find_residual(probe_layers(grid))[:, :, np.newaxis, np.newaxis]
    return np.asarray(find_equivalent(stress).max(axis=(1, 2)))


def _press_probe(grid: rc.Grid, boundary: rc.Boundary, material: Yielding, pressure: Array) -> Array:
    """Return the stress by a pressure in `probe_layers`, shape (6, nz, nx, ny), Pa."""
    layers = tuple(probe_layers(grid).tolist())
    return make_operators(grid, boundary, layers, material.young, material.poisson).press(pressure)


def find_stress(
    grid: rc.Grid, boundary: rc.Boundary, material: Yielding, strain: Array, pressure: Array | None = None
) -> Array:
    """Return the stress in the layers of a box, mean over each, shape (6, nz, nx, ny), Pa.

    Parameters
    ----------
    grid, boundary
        The grid of the surface and its boundary.
    material
        The material, whose own residual stress is part of it.
    strain
        The plastic strain, shape (6, nz, nx, ny).
    pressure
        The pressure, Pa, shape (nx, ny); None: that of an unloaded body.
    """
    operators = find_operators(grid, boundary, strain.shape[1], material)
    stress = take_stress(operators, strain) if strain.any() else np.zeros(operators.shape)
    if pressure is not None and pressure.any():
        stress += operators.press(pressure)
    if material.residual is not None:
        stress += material.find_residual(operators.thicknesses)[:, :, np.newaxis, np.newaxis]
    return stress


def find_operators(grid: rc.Grid, boundary: rc.Boundary, count: int, material: Yielding) -> VolumeOperators:
    """Return the operators of a box of as many layers."""
    layers = tuple(list_layers(grid, count).tolist())
    return make_operators(grid, boundary, layers, material.young, material.poisson)


@lru_cache(maxsize=4)
def make_operators(
    grid: rc.Grid, boundary: rc.Boundary, layers: tuple[float, ...], young: float, poisson: float
) -> VolumeOperators:
    """Return the operators of layers, which are prepared once."""
    return VolumeOperators(grid, boundary, np.array(layers), young, poisson)


def _find_side(grid: rc.Grid) -> float:
    return math.sqrt(grid.resolved.cell_area)
