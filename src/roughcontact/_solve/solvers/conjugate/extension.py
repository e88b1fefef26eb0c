"""The inverse of a kernel that is much stiffer for short waves, on the active cells: a thin, stiff layer."""

from __future__ import annotations

import attrs
import numpy as np

from roughcontact._base.checks import Mask, Pair, RealArray
from roughcontact._solve.convolvers import InverseConvolution
from roughcontact._solve.solvers.conjugate.active import ActiveCells

# Steepness (see `is_steep`) above which the extension saves products. Love's kernel has 0.7; a layer five times
# stiffer than its substrate and as thick as a cell 9, one ten times stiffer 12 and 28 at half a cell and a cell,
# and 7 at four cells.
_STEEP = 10.0
# Cells along an axis from which on its waves tell the steepness.
_FEWEST = 16
# Length over which the average falls, in blocks.
_REACH = 0.7
# Weight of zero in the average: the extension ends where all active cells together weigh less.
_FAR = 0.01


def is_steep(inverse: InverseConvolution) -> bool:
    """Return whether the inverse rises much faster than the wave number.

    The stiffness S of an elastic half-space is proportional to the wave number. With the shortest wave N along an
    axis, the longest one 1 and one of four times the shortest length, the steepness is the product
    (S_N / S_1 / N) (S_N / S_{N/4} / 4): large if short waves are much stiffer than long ones, and nearest to the
    length of the cells most so.
    """
    return any(
        float(axis[m // 2]) ** 2 > _STEEP * 4 * (m // 2) * float(axis[1]) * float(axis[m // 8])
        for axis, m in zip(inverse.axes, inverse.padded, strict=True)
        if m >= _FEWEST
    )


def half_space_inverse(inverse: InverseConvolution, spacing: Pair) -> InverseConvolution:
    """Return the inverse of a half-space that is as stiff as another inverse for its longest wave along y.

    Its flat-punch weights are above zero, where those of a steep inverse ring.
    """
    mx, my = inverse.padded
    dx, dy = spacing
    q = np.hypot(np.fft.fftfreq(mx, dx)[:, np.newaxis], np.fft.rfftfreq(my, dy)[np.newaxis, :])
    scale = float(inverse.axes[1][1]) / float(q[0, 1])
    stiffness = np.asarray(scale * q, dtype=inverse.stiffness.dtype, like=inverse.stiffness)
    return attrs.evolve(inverse, stiffness=stiffness, exact=False)


class ExtendedInverse:
    r"""The inverse kernel M applied to a displacement that is continued smoothly beyond the active cells.

    Continued by zero instead, the displacement has a step around each contact, which a kernel that is stiff for
    short waves answers with a large pressure. With the extension E, a matrix,

    .. math:: z = E^T M E\,r, \qquad E\,r = \begin{cases} r & \text{on active cells} \\
        \dfrac{G r}{G 1 + \epsilon} & \text{elsewhere} \end{cases}

    G averages over the neighbourhood, on blocks of 2 x 2 cells. The result is symmetric and not negative. If E r
    minimised the energy of M, z would be exact; a uniform displacement gives none, so that rigid motion has to be
    excluded or treated on its own.
    """

    def __init__(self, inverse: InverseConvolution, shape: tuple[int, int]) -> None:
        self._inverse = inverse
        self._shape = shape
        self._average = _BlockAverage.of(inverse)
        self._mask: Mask | None = None
        # Zero on active cells; elsewhere the reciprocal of what the active cells weigh.
        self._factor: RealArray = np.zeros(0, dtype=np.float32, like=inverse.stiffness)
        self._averages = 0

    @property
    def products(self) -> int:
        """Products so far: an average takes a quarter of one."""
        return -(-self._averages // 4)

    def update(self, active: ActiveCells) -> None:
        """Set the active cells."""
        if self._mask is not None and not (self._mask ^ active.mask).any():
            return
        self._mask = active.mask
        indicator = self._embed(active.mask.astype(np.float32))
        weight = np.maximum(self._apply_average(indicator), np.float32(0.0))
        self._factor = (np.float32(1.0) - indicator) / (weight + np.float32(_FAR))

    def apply(self, active: ActiveCells, residual: RealArray) -> RealArray:
        """Return the vector of the preconditioned residual, without its rigid part."""
        nx, ny = self._shape
        mx, my = self._inverse.padded
        field = self._embed(active.scatter(residual))
        field += self._factor * self._apply_average(field)
        # A last row or column beyond the padded grid is zero and stays so.
        field[:mx, :my] = self._inverse.apply(field[:mx, :my])
        field += self._apply_average(self._factor * field)
        return active.gather(field[:nx, :ny].copy().ravel())

    def _apply_average(self, field: RealArray) -> RealArray:
        self._averages += 1
        return self._average.apply(field)

    def _embed(self, flat: RealArray) -> RealArray:
        """Return a field on the padded grid, which has an even number of cells along both axes."""
        hx, hy = self._average.blocks
        field = np.zeros((2 * hx, 2 * hy), dtype=np.float32, like=flat)
        field[: self._shape[0], : self._shape[1]] = flat.reshape(self._shape)
        return field


@attrs.frozen(eq=False)
class _BlockAverage:
    """A symmetric weighted mean over the neighbourhood, which falls exponentially, on a periodic grid."""

    inverse: InverseConvolution
    blocks: tuple[int, int]
    symbol: RealArray

    @classmethod
    def of(cls, inverse: InverseConvolution) -> _BlockAverage:
        """Return the average on a grid of at least the cells of an inverse, in blocks of 2 x 2."""
        cells = inverse.padded
        hx, hy = blocks = (-(-cells[0] // 2), -(-cells[1] // 2))
        waves = np.hypot(np.fft.fftfreq(hx)[:, np.newaxis], np.fft.rfftfreq(hy)[np.newaxis, :])
        # Transform of exp(-r / reach) in two dimensions.
        symbol = (1.0 + (2.0 * np.pi * _REACH * waves) ** 2) ** -1.5
        return cls(inverse, blocks, np.asarray(symbol, dtype=np.float32, like=inverse.stiffness))

    def apply(self, field: RealArray) -> RealArray:
        """Return the average, of the shape of the field."""
        means = _gather_blocks(_gather_blocks(field, 0), 1)
        means = self.inverse.multiply(means, self.symbol, self.blocks)
        return _spread_blocks(_spread_blocks(means, 1), 0)


def _spread_blocks(values: RealArray, axis: int) -> RealArray:
    """Interpolate linearly from block centres to cell centres along an axis."""
    coarse = np.moveaxis(values, axis, 0)
    shape = [n * (1 + (k == axis)) for k, n in enumerate(values.shape)]
    result = np.empty(shape, dtype=values.dtype, like=values)
    fine = np.moveaxis(result, axis, 0)
    quarter = np.float32(0.25) * coarse
    np.multiply(coarse, np.float32(0.75), out=fine[0::2])
    fine[1::2] = fine[0::2]
    fine[2::2] += quarter[:-1]
    fine[0] += quarter[-1]
    fine[1:-1:2] += quarter[1:]
    fine[-1] += quarter[0]
    return result


def _gather_blocks(values: RealArray, axis: int) -> RealArray:
    """Apply half of the transpose of `_spread_blocks`: weighted means."""
    fine = np.moveaxis(values, axis, 0)
    first = fine[0::2]
    second = fine[1::2]
    means = first + second
    means *= np.float32(0.375)
    eighth = np.float32(0.125) * first
    means[:-1] += eighth[1:]
    means[-1] += eighth[0]
    np.multiply(second, np.float32(0.125), out=eighth)
    means[1:] += eighth[:-1]
    means[0] += eighth[-1]
    return np.moveaxis(means, 0, axis).copy()
