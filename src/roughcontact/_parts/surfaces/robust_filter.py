"""Gaussian means that grooves and spikes do not move: local paraboloids with robust weights."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy

from roughcontact._base.arrays import Array, Mask
from roughcontact._base.machine import require_memory, split
from roughcontact._parts.grid import Grid

# Width of the weights over the cut-off at which a local paraboloid halves a wave: u = pi gamma^2 solves
# (1 + u) exp(-u) = 1/2.
_GAMMA = 0.7309134280947581
# Beyond so many cut-off wavelengths the weights are below 1e-10.
_REACH = 2.0
# Residual without weight, over the median of the absolute ones: three standard deviations of normal ones.
_CUT = 3.0 / 0.6744897501960817
# Relative change of that residual at which the rounds end, and rounds at most.
_CUT_TOLERANCE = 1e-3
_MAX_ROUNDS = 50
# Diagonal that is added to the normal equations, over their largest weight, so that points without weights have a mean;
# and distances over the range of the heights that are rounding.
_RIDGE = 1e-11
_ROUNDING = 1e-8
# Powers of x and y of the paraboloid.
_TERMS = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
# Cells whose normal equations are solved at once.
_CELLS_PER_BLOCK = 2**14
# Peak memory in float64 arrays of the padded map; measured.
_ARRAYS_IN_MEMORY = 34.0


def smooth_robustly(
    heights: Array, grid: Grid, cutoff: float, *, periodic: bool, non_measured: Mask | None = None
) -> Array:
    r"""Return the heights of the local paraboloids through heights, shape (nx, ny), m, at their centres.

    Each is the least-squares paraboloid under the weights

    .. math:: s(r)\, \delta, \quad s(r) = \exp\left(-\frac{\pi r^2}{\gamma^2 \lambda_c^2}\right), \quad
              \delta = \left(1 - (e/c)^2\right)^2 \text{ for } |e| < c, \quad
              c = \frac{3}{0.6745} \operatorname{med} |e|

    with the distances e of the points from the surface of the round before (Tukey's biweight), which is repeated until
    c changes by less than 0.1 % (ISO 16610-71:2014). At first all measured points have the weight one. With it a wave
    of the cut-off wavelength is halved, and a form of second degree stays.
    """
    shape = heights.shape
    reach = [math.ceil(_REACH * cutoff / step) for step in grid.spacing]
    if not periodic:
        shape = tuple(
            scipy.fft.next_fast_len(n + min(extra, n), real=True) for n, extra in zip(shape, reach, strict=True)
        )
        reach = [min(extra, n - 1) for extra, n in zip(reach, heights.shape, strict=True)]
    require_memory(8.0 * _ARRAYS_IN_MEMORY * math.prod(shape), "The robust filter", "choose fewer cells")
    kernels = [
        _transform_weights(n, cells, step / (_GAMMA * cutoff), transform)
        for n, cells, step, transform in zip(shape, reach, grid.spacing, (scipy.fft.fft, scipy.fft.rfft), strict=True)
    ]
    known = np.ones(heights.shape) if non_measured is None else (~non_measured).astype(np.float64)
    measured = known > 0.0
    # Sums of small differences: a constant map stays constant to rounding.
    middle = float(np.median(heights[measured]))
    rough = heights - middle
    weights = known
    means = np.zeros_like(rough)
    cut = math.inf
    rounding = _ROUNDING * float(np.ptp(rough))
    for _ in range(_MAX_ROUNDS):
        means = _fit(rough, weights, kernels, shape)
        misfit = rough - means
        found = _CUT * float(np.median(np.abs(misfit[measured])))
        if abs(found - cut) <= _CUT_TOLERANCE * found or found <= rounding:
            break
        cut = found
        weights = known * np.maximum(1.0 - (misfit / cut) ** 2, 0.0) ** 2
    return np.asarray(middle + means)


def _transform_weights(count: int, reach: int, step: float, transform: Any) -> list[npt.NDArray[np.complex128]]:
    """Return the transforms of the weights along an axis times powers 0 to 4 of the distance, in widths."""
    cells = np.arange(-reach, reach + 1)
    # A mean at a cell takes the points beyond it: the weights are mirrored for a convolution.
    distance = -cells * step
    weights = step * np.exp(-math.pi * distance**2)
    found = []
    for power in range(5):
        kernel = np.zeros(count)
        np.add.at(kernel, cells % count, weights * distance**power)
        found.append(transform(kernel))
    return found


def _fit(
    heights: Array, weights: Array, kernels: list[list[npt.NDArray[np.complex128]]], shape: tuple[int, ...]
) -> Array:
    """Return the paraboloids of least squares at their centres, shape (nx, ny), m."""
    nx, ny = heights.shape

    def average(values: Array, powers: list[tuple[int, int]]) -> dict[tuple[int, int], Array]:
        modes = scipy.fft.rfft2(values, shape)
        return {
            (a, b): scipy.fft.irfft2(modes * kernels[0][a][:, np.newaxis] * kernels[1][b], shape)[:nx, :ny]
            for a, b in powers
        }

    moments = average(weights, [(a, b) for a, b in itertools.product(range(5), range(5)) if a + b <= 4])
    right = average(weights * heights, list(_TERMS))
    ridge = _RIDGE * float(moments[0, 0].max()) * np.eye(len(_TERMS))
    means = np.empty_like(heights)
    for rows in split(nx, max(1, _CELLS_PER_BLOCK // ny)):
        matrix = np.stack(
            [np.stack([moments[a + c, b + d][rows] for c, d in _TERMS], axis=-1) for a, b in _TERMS], axis=-2
        )
        sums = np.stack([right[term][rows] for term in _TERMS], axis=-1)
        means[rows] = np.linalg.solve(matrix + ridge, sums[..., np.newaxis])[..., 0, 0]
    return means
