"""The convolution of stress: that in a plane below the surface by pressure and tractions on it."""

from __future__ import annotations

from functools import cached_property, partial

import attrs
import numpy as np
import scipy

from roughcontact._base.arrays import RealArray, Waves
from roughcontact._base.machine import threads_for
from roughcontact._parts.grid import Boundary, Grid
from roughcontact._parts.kernels import STRESS_COMPONENTS, BoundStress, SupportsStress, odd_axes
from roughcontact._solve.convolvers.matrix import WaveMatrix, turn
from roughcontact._solve.convolvers.transforms import (
    half_waves,
    multiply_columns,
    transform_extended,
    transform_offsets,
    transform_rows_back,
)


@attrs.frozen(eq=False)
class StressConvolution:
    """The linear map from loads that are constant on each cell to the stress at a depth, in float32.

    Deep below the surface the short waves have decayed, and the stress is found at the centres of blocks of cells. A
    block has a power of two of cells along each axis, which divides the cells of the axis. Beyond a wrapped border
    nothing lies, as beyond a free one.

    Attributes
    ----------
    kernel
        The stress by a cell, or by a wave, of the body.
    grid, boundary
        The cells and the boundary of the domain.
    common
        The largest blocks along x and y for which `apply` is called.

    Examples
    --------
    Below the middle of a cell that is pressed, at a depth of its side:

    >>> import numpy as np
    >>> import roughcontact as rc
    >>> from roughcontact.typing import HalfSpaceStress, StressConvolution
    >>> convolution = StressConvolution(HalfSpaceStress(0.3), rc.Grid((9, 9), 9e-6), rc.Boundary.FREE)
    >>> pressure = np.zeros((1, 9, 9))
    >>> pressure[0, 4, 4] = 1.0
    >>> stress = convolution.apply(convolution.transform(pressure), depth=1e-6)
    >>> print(stress[:, 4, 4].round(4) + 0.0)
    [ 0.0014  0.0014 -0.3361  0.      0.      0.    ]
    """

    kernel: SupportsStress
    grid: Grid
    boundary: Boundary
    common: tuple[int, int] = (1, 1)

    @cached_property
    def padded(self) -> tuple[int, int]:
        """Cells of the padded grid: along free axes even multiples of the largest blocks."""
        mx, my = (
            n if repeats else 2 * step * int(scipy.fft.next_fast_len(-(-n // step), real=True))
            for n, step, repeats in zip(self.grid.shape, self.common, self.boundary.repeats, strict=True)
        )
        return mx, my

    def transform(self, loads: RealArray, of: str = "z") -> Waves:
        """Return the waves of loads on the padded grid, for `apply`, shape (len(of), mx, my // 2 + 1).

        Parameters
        ----------
        loads
            The loads, shape (len(of), nx, ny).
        of
            The letter of each: ``"z"`` for pressure, ``"x"`` and ``"y"`` for tractions.
        """
        mx, my = self.padded
        workers = threads_for(mx * my)
        rows = scipy.fft.rfft(loads.astype(np.float32, copy=False), n=my, axis=2, workers=workers)
        waves: Waves = scipy.fft.fft(rows, n=mx, axis=1, overwrite_x=True, workers=workers)
        turn(waves, of)
        return waves

    def apply(self, waves: Waves, depth: float, of: str = "z", steps: tuple[int, int] = (1, 1)) -> RealArray:
        """Return the stress at a depth, shape (6, nx // steps[0], ny // steps[1]), order `STRESS_COMPONENTS`, float32.

        Parameters
        ----------
        waves, of
            The waves of `transform`, and the letters of the loads.
        depth
            The depth, m.
        steps
            Cells of a block along each axis.
        """
        nx, ny = (n // step for n, step in zip(self.grid.shape, steps, strict=True))
        mx, my = (m // step for m, step in zip(self.padded, steps, strict=True))
        loads = coarsen(coarsen(waves, self.padded[1], steps[1], 1), self.padded[0], steps[0], 0)
        symbols: dict[str, RealArray] = {}
        for load in of:
            found = self._find_symbols(load, (mx, my), depth, steps)
            symbols |= {component + load: one for component, one in zip(STRESS_COMPONENTS, found, strict=True)}
        matrix = WaveMatrix(symbols, (mx, my))
        stress = np.empty((len(STRESS_COMPONENTS), nx, ny), dtype=np.float32)
        product = np.empty((1, nx, loads.shape[2]), dtype=loads.dtype)
        for component, plane in zip(STRESS_COMPONENTS, stress, strict=True):
            multiply = partial(matrix.multiply, of=of, to=(component,))
            multiply_columns(loads, None, multiply, product)
            transform_rows_back(product[0], my, ny, plane)
        return stress

    def _find_symbols(
        self, load: str, padded: tuple[int, int], depth: float, steps: tuple[int, int]
    ) -> list[RealArray]:
        kernel = BoundStress(self.kernel)
        spacing = steps[0] * self.grid.spacing[0], steps[1] * self.grid.spacing[1]
        odd = [odd_axes(component + load) for component in STRESS_COMPONENTS]
        if self.boundary is Boundary.PERIODIC:
            return list(kernel.spectrum(load, *half_waves(padded, spacing), spacing, depth))
        if not self.boundary.mixed:
            table = kernel.coefficients(load, (padded[0] // 2 + 1, padded[1] // 2 + 1), spacing, depth)
            # An odd table is zero at half of the grid.
            ends = [tuple(slice(-1 if is_odd else None) for is_odd in axes) for axes in odd]
            return [transform_offsets(one[end], padded, axes) for one, end, axes in zip(table, ends, odd, strict=True)]
        free = self.boundary.free_axis
        qx, qy = half_waves(padded, spacing)
        waves = qy[0] if free == 0 else qx[:, 0]
        responses = kernel.mixed_coefficients(load, padded[free] // 2 + 1, waves, spacing, depth, free)
        return [
            transform_extended(one, padded[free], axes[free], axis=free).astype(np.float32)
            for one, axes in zip(responses, odd, strict=True)
        ]


def coarsen(waves: Waves, length: int, step: int, axis: int) -> Waves:
    """Return the waves along an axis that points at the centres of blocks of cells resolve.

    Parameters
    ----------
    waves
        Waves of unit cells, shape (k, m, n): of all signs along x, without the negative ones along y.
    length
        Cells along the axis.
    step
        Cells of a block along it.
    axis
        0 for x, 1 for y.
    """
    if step == 1:
        return waves
    count = length // step
    # Without the wave of half the sampling wave number, which only an even number of blocks has.
    half = (count + 1) // 2
    number = np.arange(half)
    # The block's middle lies half a block behind its first cell's centre; a block stands for a cell.
    angle = np.pi * number / length
    with np.errstate(invalid="ignore"):
        ratio = np.where(number > 0, np.sin(angle) / np.sin(step * angle), 1.0 / step)
    factor = (ratio * np.exp(1j * (step - 1) * angle)).astype(waves.dtype)
    k, m, n = waves.shape
    kept = np.zeros((k, m, count // 2 + 1) if axis == 1 else (k, count, n), dtype=waves.dtype)
    if axis == 1:
        np.multiply(waves[:, :, :half], factor, out=kept[:, :, :half])
    else:
        np.multiply(waves[:, :half], factor[:, np.newaxis], out=kept[:, :half])
        np.multiply(waves[:, 1 - half :], factor[:0:-1, np.newaxis].conj(), out=kept[:, count - half + 1 :])
    return kept
