"""What every source of stress fields shares: the waves of the pressure, and the steps of the output."""

from __future__ import annotations

import abc
from collections.abc import Sequence
from typing import Any

import numpy as np

from roughcontact._base.checks import Pair, RealArray, Waves

# Waves shorter than twice a step have died by exp(-pi z / step): a step of a quarter of the depth loses 5e-5.
_STEPS_IN_DEPTH = 4.0
# Fewest points along an axis.
_FEWEST = 16


class StressPlanes(abc.ABC):
    """The stress below a pressure, a depth at a time, in units of the pressure and of a cell's side along x.

    Deep below the surface the short waves have died, and the stress is found in each n-th cell along an axis, n a power
    of two that divides the cells of the axis: the points lie at the centres of such blocks of cells.
    """

    @abc.abstractmethod
    def at(self, z: float, poisson: float, steps: tuple[int, int]) -> RealArray:
        """Return the stress at a depth, shape (6, nx // steps[0], ny // steps[1]), order `COMPONENTS`, float32."""


def find_steps(shape: tuple[int, int], sides: Pair, z: float) -> tuple[int, int]:
    """Return the cells of a block along each axis that resolve the stress at a depth."""
    return _find_step(shape[0], z / sides[0]), _find_step(shape[1], z / sides[1])


def _find_step(count: int, cells: float) -> int:
    step = 1
    while count % (2 * step) == 0 and count >= 2 * step * _FEWEST and 2.0 * step * _STEPS_IN_DEPTH <= cells:
        step *= 2
    return step


def coarsen(waves: Waves, length: int, step: int, axis: int) -> Waves:
    """Return the waves along an axis that points at the centres of blocks resolve.

    Parameters
    ----------
    waves
        Waves of unit cells: of all signs along the first axis, without the negative ones along the last.
    length
        Cells along the axis.
    step
        Cells of a block along it.
    axis
        0 or 1.
    """
    if step == 1:
        return waves
    count = length // step
    # Without the wave of half the sampling wave number, which only an even number of blocks has.
    half = (count + 1) // 2
    number = np.arange(half)
    # The block's middle lies half a block behind its first cell's centre; a block stands for a cell (`cell_stress`).
    angle = np.pi * number / length
    with np.errstate(invalid="ignore"):
        ratio = np.where(number > 0, np.sin(angle) / np.sin(step * angle), 1.0 / step)
    factor = (ratio * np.exp(1j * (step - 1) * angle)).astype(waves.dtype)
    shape: list[Any] = list(waves.shape)
    shape[axis] = count // 2 + 1 if axis == 1 else count
    kept = np.zeros(shape, dtype=waves.dtype)
    if axis == 1:
        np.multiply(waves[:, :half], factor, out=kept[:, :half])
    else:
        np.multiply(waves[:half], factor[:, np.newaxis], out=kept[:half])
        np.multiply(waves[1 - half :], factor[:0:-1, np.newaxis].conj(), out=kept[count - half + 1 :])
    return kept


def common_step(steps: Sequence[tuple[int, int]]) -> tuple[int, int]:
    """Return the largest of several steps along each axis: powers of two, so that each divides it."""
    along_x, along_y = zip(*steps, strict=True)
    return max(along_x), max(along_y)
