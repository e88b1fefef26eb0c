"""Height arrays on other cell counts over the same domain, cell centres mapped to cell centres."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import scipy.fft

from roughcontact.checks import Array


def bilinear(values: Array, shape: tuple[int, int], *, periodic: bool) -> Array:
    """Interpolate linearly between the four nearest cell centres.

    Beyond the outermost centres the heights of a periodic map come from the opposite border;
    otherwise the outermost height is kept.
    """
    rows = _interpolated(values, shape[0], periodic=periodic)
    return np.ascontiguousarray(_interpolated(rows.T, shape[1], periodic=periodic).T)


def between(values: Array, i: Array, j: Array, method: str, *, periodic: bool) -> Array:
    """Interpolate at fractional indices (i, j), which broadcast to the shape of the result.

    Parameters
    ----------
    values
        Heights, shape (nx, ny).
    i, j
        Positions in cells; a whole number is a cell centre. Beyond the outermost centres as in `bilinear`.
    method
        ``"bilinear"``, ``"cubic"`` (splines) or ``"fourier"`` (the trigonometric polynomial through the
        values; then i has shape (mx, 1) and j (1, my)).
    periodic
        Whether the map goes on with its own copy.
    """
    if method == "fourier":
        return _trigonometric(values, i.ravel(), j.ravel())
    from scipy.ndimage import map_coordinates

    found = map_coordinates(
        values,
        np.stack(np.broadcast_arrays(i, j)),
        order=3 if method == "cubic" else 1,
        mode="grid-wrap" if periodic else "nearest",
    )
    return np.asarray(found, dtype=np.float64)


def _trigonometric(values: Array, i: Array, j: Array) -> Array:
    spectrum = scipy.fft.fft2(values, norm="forward")
    for axis, position in enumerate((i, j)):
        count = values.shape[axis]
        waves = np.outer(position, 2.0 * np.pi * scipy.fft.fftfreq(count))
        phases = np.exp(1j * waves)
        if count % 2 == 0:
            # The Nyquist wave is a standing wave.
            phases[:, count // 2] = np.cos(np.pi * position)
        spectrum = phases @ spectrum if axis == 0 else spectrum @ phases.T
    return np.ascontiguousarray(spectrum.real)


def block_mean(values: Array, shape: tuple[int, int]) -> Array:
    """Average over whole blocks of cells; `shape` must divide the shape of `values`."""
    (nx, ny), (mx, my) = values.shape, shape
    return np.asarray(values.reshape(mx, nx // mx, my, ny // my).mean(axis=(1, 3)), dtype=np.float64)


def fourier(values: Array, shape: tuple[int, int]) -> Array:
    """Interpolate by the trigonometric polynomial through the values, cut at the coarser Nyquist wave."""
    spectrum = scipy.fft.fft2(values, norm="forward")
    for axis, count in enumerate(shape):
        if count == values.shape[axis]:
            continue
        spectrum = _resized(spectrum, axis, count)
    return np.ascontiguousarray(scipy.fft.ifft2(spectrum, norm="forward").real)


def _interpolated(values: Array, count: int, *, periodic: bool) -> Array:
    """Interpolate linearly along the first axis."""
    old = values.shape[0]
    position = (np.arange(count) + 0.5) * (old / count) - 0.5
    if not periodic:
        position = np.clip(position, 0.0, old - 1.0)
    lower = np.floor(position).astype(np.intp)
    weight = (position - lower)[:, np.newaxis]
    return np.asarray((1.0 - weight) * values[lower % old] + weight * values[(lower + 1) % old], dtype=np.float64)


def _resized(spectrum: npt.NDArray[np.complex128], axis: int, count: int) -> npt.NDArray[np.complex128]:
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
