"""Heights on other cell counts over the same domain, cell centres mapped to cell centres, and their Gaussian means."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
import numpy.typing as npt
import scipy

from roughcontact._base.arrays import Array, Mask, matrix_product
from roughcontact._base.checks import choice
from roughcontact._base.machine import require_memory, split
from roughcontact._parts.grid import Grid

# Memory of each interpolation in float64 arrays of the new grid (the finer one for "fourier"), with the new map.
_ARRAYS_IN_MEMORY = {"bilinear": 2.0, "cubic": 3.6, "fourier": 5.0, "mean": 2.0}
# Cells that are interpolated at once, to save memory.
_CELLS_PER_BLOCK = 2**16
# Beyond so many cut-off wavelengths the weights of the filter are below 1e-12.
_REACH = 1.5


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


def resample_mask(
    mask: Mask | None, shape: tuple[int, int], interpolation: str = "bilinear", *, periodic: bool
) -> Mask | None:
    """Return a mask on another number of cells: those with more than half of their weight on its points."""
    return None if mask is None else resample(mask.astype(np.float64), shape, interpolation, periodic=periodic) > 0.5


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


def smooth(heights: Array, grid: Grid, cutoff: float, *, periodic: bool, non_measured: Mask | None) -> Array:
    r"""Return the mean of heights under Gaussian weights, which halve a wave of the cut-off wavelength.

    .. math:: s(r) = \frac{1}{\alpha^2 \lambda_c^2} \exp\left(-\frac{\pi r^2}{\alpha^2 \lambda_c^2}\right), \quad
              \alpha = \sqrt{\ln 2 / \pi}, \quad \hat s(\lambda) = 2^{-(\lambda_c / \lambda)^2}

    (ISO 16610-61). Beyond the border of heights that do not repeat, and where none was measured, there is no weight:
    that of the others is raised to one.
    """
    if periodic and non_measured is None:
        return _convolve(heights, grid, cutoff, heights.shape)
    shape = heights.shape
    if not periodic:
        reach = [math.ceil(_REACH * cutoff / step) for step in grid.spacing]
        shape = tuple(
            scipy.fft.next_fast_len(n + min(extra, n), real=True) for n, extra in zip(shape, reach, strict=True)
        )
    weights = np.ones(heights.shape) if non_measured is None else (~non_measured).astype(np.float64)
    # Sums of small differences: a constant map stays constant to rounding.
    middle = float(np.sum(heights * weights) / np.sum(weights))
    sums = _convolve((heights - middle) * weights, grid, cutoff, shape)
    total = _convolve(weights, grid, cutoff, shape)
    # Deep in holes that are wider than the filter the weights are rounding.
    return np.asarray(middle + sums / np.maximum(total, 1e-9))


def _convolve(values: Array, grid: Grid, cutoff: float, shape: tuple[int, ...]) -> Array:
    """Return values under the weights of the filter, on a domain padded with zeros to so many cells."""
    halved = [
        np.exp2(-((cutoff * waves(n, step)) ** 2))
        for n, step, waves in zip(shape, grid.spacing, (scipy.fft.fftfreq, scipy.fft.rfftfreq), strict=True)
    ]
    modes = scipy.fft.rfft2(values, shape)
    modes *= halved[0][:, np.newaxis]
    modes *= halved[1]
    smoothed = scipy.fft.irfft2(modes, shape)
    return np.ascontiguousarray(smoothed[: values.shape[0], : values.shape[1]])
