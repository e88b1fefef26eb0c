"""The areal Gaussian filter of surface texture."""

from __future__ import annotations

import math

import numpy as np
import scipy

from roughcontact._base.arrays import Array, Mask
from roughcontact._parts.grid import Grid

# Beyond so many cut-off wavelengths the weights of the filter are below 1e-12.
_REACH = 1.5


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
