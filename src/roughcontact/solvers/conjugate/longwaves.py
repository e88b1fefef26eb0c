"""Long waves of the active cells together, which the masked inverse kernel does not see."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
import scipy.fft

from roughcontact.checks import RealArray
from roughcontact.convolvers.inverse import InverseConvolution
from roughcontact.solvers.conjugate.active import Active, Partition, total

# Waves are long up to this multiple of the wave whose stiffness is the mean weight of the domain.
_CUT = 2.0
# Blocks still resolve this much more.
_RESOLVED = 1.5
_LARGEST_BLOCK = 64
_FEWEST_BLOCKS = 8
_STEPS = 4
_ENOUGH = 0.02
_EXPONENT = 30.0


class LongWaves:
    r"""Corrects :math:`z_0 = M_0 r` for the waves that are longer than the distance of contacts.

    Splitting the kernel into a near and a far part, with the flat-punch weights w of the near one,
    Woodbury's formula gives

    .. math:: z = z_0 - w\,P\,(P^T Q P + P^T \operatorname{diag}(w) P)^{-1} P^T (w\,r)

    with P constant on blocks of cells and Q the stiffness of the far part alone. The system on the
    blocks is solved by a few conjugate gradients.

    Parameters
    ----------
    inverse
        The stiffness of each wave.
    shape
        Cells of the grid (nx, ny).
    active, weights
        The active cells and the vector of their flat-punch weights.
    """

    def __init__(self, inverse: InverseConvolution, shape: tuple[int, int], active: Active, weights: RealArray) -> None:
        mx, my = inverse.padded
        mean = total(weights) / (mx * my)
        bx, by = (_blocks(axis, count, mean) for axis, count in zip(_axes(inverse), (mx, my), strict=True))
        self._partition = _partition(shape, (mx, my), (bx, by))
        self._diagonal = active.blocks(self._partition).sums(weights).astype(np.float32)
        half = np.fft.fftfreq(bx, 1 / bx).astype(int)
        stiffness = inverse.stiffness[half][:, : by // 2 + 1]
        size = mx * my / (bx * by)
        growth = np.minimum((stiffness / (_CUT * mean)) ** 2, _EXPONENT)
        self._far = stiffness * np.exp(growth) * np.float32(size)
        self._approximate = 1.0 / (self._far + np.float32(size * mean))

    def correction(self, active: Active, weights: RealArray, residual: RealArray) -> RealArray:
        """Return the vector that is to be taken from z0."""
        blocks = active.blocks(self._partition)
        solution = self._solved(blocks.sums(weights * residual).astype(np.float32))
        return weights * blocks.spread(solution)

    def _solved(self, right: RealArray) -> RealArray:
        """Solve the system on the blocks to a few per cent."""
        size = float(np.abs(right).max())
        solution = np.zeros_like(right)
        if size == 0.0:
            return solution
        # Squares of small residuals would leave the range of float32.
        residual = right / np.float32(size)
        first = math.sqrt(_dot(residual, residual))
        image = self._multiplied(residual, self._approximate)
        direction, product = image, _dot(residual, image)
        for _ in range(_STEPS):
            response = self._multiplied(direction, self._far) + self._diagonal * direction
            curvature = _dot(direction, response)
            if not (curvature > 0.0 and product > 0.0):
                break
            solution += np.float32(product / curvature) * direction
            residual = residual - np.float32(product / curvature) * response
            if math.sqrt(_dot(residual, residual)) < _ENOUGH * first:
                break
            image = self._multiplied(residual, self._approximate)
            previous, product = product, _dot(residual, image)
            direction = image + np.float32(product / previous) * direction
        return solution * np.float32(size)

    def _multiplied(self, values: RealArray, symbol: RealArray) -> RealArray:
        waves = scipy.fft.fft(scipy.fft.rfft(values, axis=1), axis=0, overwrite_x=True)
        waves *= symbol
        waves = scipy.fft.ifft(waves, axis=0, overwrite_x=True)
        return np.asarray(scipy.fft.irfft(waves, n=values.shape[1], axis=1))


def _axes(inverse: InverseConvolution) -> tuple[RealArray, RealArray]:
    """Return the stiffness of the waves along x and along y."""
    return inverse.stiffness[: inverse.padded[0] // 2 + 1, 0], inverse.stiffness[0]


def _blocks(stiffness: RealArray, count: int, mean: float) -> int:
    """Return the number of blocks along an axis: few, but enough for all long waves."""
    size = 1
    while 2 * size <= _LARGEST_BLOCK and count // (2 * size) >= _FEWEST_BLOCKS:
        if stiffness[max(count // (4 * size), 1)] < _RESOLVED * _CUT * mean:
            break
        size *= 2
    return max(count // size, 1)


@lru_cache(maxsize=4)
def _partition(shape: tuple[int, int], padded: tuple[int, int], blocks: tuple[int, int]) -> Partition:
    """Divide the cells; the same few partitions are asked for again and again."""
    rows, columns = (((np.arange(n) * b) // m).astype(np.int32) for n, m, b in zip(shape, padded, blocks, strict=True))
    return Partition(shape, blocks, rows, columns)


def _dot(one: RealArray, other: RealArray) -> float:
    return float(np.einsum("ij,ij->", one, other))
