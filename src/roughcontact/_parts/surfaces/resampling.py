"""Height arrays on other cell counts over the same domain, cell centres mapped to cell centres."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
import numpy.typing as npt
import scipy

from roughcontact._base.arrays import Array, matrix_product
from roughcontact._base.checks import choice
from roughcontact._base.machine import require_memory, split
from roughcontact._parts.grid import Grid

# Memory of each interpolation in float64 arrays of the new grid (the finer one for "fourier"), with the new map.
_ARRAYS_IN_MEMORY = {"bilinear": 2.0, "cubic": 3.6, "fourier": 5.0, "mean": 2.0}
# Cells that are interpolated at once, to save memory.
_CELLS_PER_BLOCK = 2**16


def check_interpolation(interpolation: str | None) -> None:
    """Raise `InputError` unless the interpolation is known, or None, for the default."""
    if interpolation is not None:
        choice(interpolation, "The resampling method", tuple(_ARRAYS_IN_MEMORY))


def resample(values: Array, shape: tuple[int, int], interpolation: str, *, periodic: bool) -> Array:
    """Return heights on another number of cells over the same domain, shape `shape`, m; see `HeightMap.resample`."""
    cells = max(math.prod(shape), values.size if interpolation == "fourier" else 0)
    what = f"Interpolation ({interpolation}) on {shape[0]} x {shape[1]} cells"
    require_memory(8.0 * _ARRAYS_IN_MEMORY[interpolation] * cells, what, "choose fewer cells")
    if interpolation == "fourier":
        return fourier(values, shape)
    if interpolation == "mean":
        nx, ny = values.shape
        mx, my = shape
        return np.asarray(values.reshape(mx, nx // mx, my, ny // my).mean(axis=(1, 3)), dtype=np.float64)
    if interpolation == "bilinear":
        return bilinear(values, shape, periodic=(periodic, periodic))
    i, j = ((np.arange(new) + 0.5) * (old / new) - 0.5 for new, old in zip(shape, values.shape, strict=True))
    return interpolate(values, i[:, np.newaxis], j[np.newaxis, :], interpolation, periodic=periodic)


def bilinear(values: Array, shape: tuple[int, int], *, periodic: tuple[bool, bool]) -> Array:
    """Return heights interpolated linearly between the four nearest cell centres, shape `shape`, m.

    Beyond the outermost centres along an axis, periodic heights repeat; others stay at the outermost height.
    """
    rows = _linear(values, np.empty((shape[0], values.shape[1])), periodic=periodic[0])
    result = np.empty(shape)
    _linear(rows.T, result.T, periodic=periodic[1])
    return result


def interpolate(values: Array, i: Array, j: Array, interpolation: str, *, periodic: bool) -> Array:
    """Return heights at fractional indices (i, j), which broadcast to the shape of the result, m.

    An integer index is a cell centre; for positions beyond the outermost centres see `bilinear`. The interpolation is
    ``"bilinear"``, ``"cubic"`` (splines) or ``"fourier"`` (the trigonometric polynomial through the values; then i has
    shape (mx, 1) and j (1, my)).
    """
    if interpolation == "fourier":
        return _trigonometric(values, i.ravel(), j.ravel())
    from scipy.ndimage import map_coordinates

    positions = np.stack(np.broadcast_arrays(i, j))
    order: Literal[1, 3] = 3 if interpolation == "cubic" else 1
    found = map_coordinates(values, positions, order=order, mode="grid-wrap" if periodic else "nearest")
    return np.asarray(found, dtype=np.float64)


def shift_by_half_cell(values: Array, grid: Grid) -> Array:
    """Return periodic heights on a grid, moved by half a cell along both axes, shape `grid.shape`, m."""
    nx, ny = grid.shape
    dx, dy = grid.spacing
    i = (grid.x - 0.5 * dx) / dx + 0.5 * (nx - 1)
    j = (grid.y - 0.5 * dy) / dy + 0.5 * (ny - 1)
    return interpolate(values, i, j, "fourier", periodic=True)


def _trigonometric(values: Array, i: Array, j: Array) -> Array:
    spectrum = scipy.fft.fft2(values, norm="forward")
    for axis, position in enumerate((i, j)):
        count = values.shape[axis]
        waves = np.outer(position, 2.0 * np.pi * scipy.fft.fftfreq(count))
        phases = np.exp(1j * waves)
        if count % 2 == 0:
            # The Nyquist wave is a standing wave.
            phases[:, count // 2] = np.cos(np.pi * position)
        spectrum = matrix_product(phases, spectrum) if axis == 0 else matrix_product(spectrum, phases.T)
    return np.ascontiguousarray(spectrum.real)


def fourier(values: Array, shape: tuple[int, int]) -> Array:
    """Return the trigonometric polynomial through periodic heights, cut at the coarser Nyquist wave, m."""
    spectrum = scipy.fft.fft2(values, norm="forward")
    for axis, count in enumerate(shape):
        if count != values.shape[axis]:
            spectrum = _resize_spectrum(spectrum, axis, count)
    return np.ascontiguousarray(scipy.fft.ifft2(spectrum, norm="forward").real)


def _linear(values: Array, result: Array, *, periodic: bool) -> Array:
    """Return `result`, filled with values interpolated linearly along the first axis."""
    old, _ = values.shape
    count, width = result.shape
    position = (np.arange(count) + 0.5) * (old / count) - 0.5
    if not periodic:
        position = np.clip(position, 0.0, old - 1.0)
    lower = np.floor(position).astype(np.intp)
    weight = (position - lower)[:, np.newaxis]
    for part in split(count, max(1, _CELLS_PER_BLOCK // width)):
        left = values[lower[part] % old]
        right = values[(lower[part] + 1) % old]
        result[part] = (1.0 - weight[part]) * left + weight[part] * right
    return result


def _resize_spectrum(spectrum: npt.NDArray[np.complex128], axis: int, count: int) -> npt.NDArray[np.complex128]:
    """Cut or pad a spectrum along one axis and move its origin from old to new cell centres."""
    old = spectrum.shape[axis]
    half = (min(old, count) - 1) // 2
    kept = np.arange(-half, half + 1)
    moved = np.moveaxis(spectrum, axis, 0)
    result = np.zeros((count, *moved.shape[1:]), dtype=np.complex128)
    shift = (np.pi * kept * (1.0 / count - 1.0 / old))[:, np.newaxis]
    result[kept % count] = moved[kept % old] * np.exp(1j * shift)
    if old % 2 == 0 and old < count:
        # The Nyquist wave of the old grid is a standing wave: half of it travels each way.
        for k in (old // 2, -(old // 2)):
            result[k % count] = 0.5 * moved[old // 2] * np.exp(1j * np.pi * k * (1.0 / count - 1.0 / old))
    return np.moveaxis(result, 0, axis)
