"""The inverse kernel on the active cells: flat-punch weights, long waves, rigid motion, stiff layers."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable

import attrs
import numpy as np

from roughcontact._base.arrays import IntArray, Mask, Pair, RealArray, sum_of_products
from roughcontact._base.checks import integer, number, numbers
from roughcontact._solve.convolvers import InverseConvolution, PreparedConvolution
from roughcontact._solve.solvers.driver import Work
from roughcontact._solve.solvers.passes import ActiveCells, Levels, Partition, divide, dot, total
from roughcontact.errors import InputError
from roughcontact.errors.door import guarded

# Maximum changed cells before weights are computed anew, over the active cells or, if these are fewer, the passive ones
# plus a fraction of the grid: the stencil omits distant effects.
_MAX_CHANGED_FRACTION = 0.5
_PASSIVE_ALLOWANCE = 0.02
# Maximum fraction of all cells that change at once for the stencil; a product is faster above.
_MAX_STENCIL_FRACTION = 0.03
# Cells of the stencil to each side of a cell that joins or leaves: the inverse kernel falls as the third power of the
# distance.
_STENCIL_REACH = 3
# Minimum weight, over the mean: smaller ones are ringing of the inverse.
_MIN_WEIGHT = 1e-3
# Minimum steepness (see `is_steep`) for which the extension saves products. Love's kernel has 0.7; a layer five times
# stiffer than its substrate and as thick as a cell 9, one ten times stiffer 12 and 28 at half a cell and a cell,
# and 7 at four cells.
_MIN_STEEPNESS = 10.0
# Minimum cells along an axis whose waves show the steepness.
_MIN_STEEPNESS_CELLS = 16
# Decay length of the average, in blocks.
_DECAY_BLOCKS = 0.7
# Weight of zero in the average: the extension ends where the active cells together weigh less.
_EXTENSION_END_WEIGHT = 0.01
# Cut between long and short waves, over the wave whose stiffness is the mean weight, and resolution of blocks, over it.
LONG_WAVE_CUT = 3.0
_BLOCK_RESOLUTION = 1.5
# Maximum cells along a block, and minimum blocks along an axis.
_MAX_BLOCK_CELLS = 64
_MIN_BLOCKS = 8
# Maximum steps of conjugate gradients on the blocks, and relative residual at which they end.
_MAX_BLOCK_STEPS = 4
_BLOCK_RESIDUAL = 0.02
# Part of the mean overlap of the contacts of a block that a step removes, about its length: open cells that remain
# without overlap are not released. Otherwise long waves of the gap release many cells that the next steps open again:
# at x = 0.2 29 instead of 23 products on 2048 x 2048 cells, 52 instead of 26 on 4096 x 4096.
_RELEASE_PART = 0.7
# Minimum sum of the weights of a block, to avoid 0 / 0.
_MIN_BLOCK_WEIGHT = 1e-30
# Maximum exponent in the cut of the short waves: exp(30) = 1e13 is beyond the resolution of float32.
MAX_CUT_EXPONENT = 30.0
# Minimum ratio of the singular values of two distinct rigid pressures; float32 has 1e-7.
_MIN_SINGULAR_RATIO = 1e-6


class PunchWeights:
    """The pressure M 1 of the active cells under a flat punch, M the inverse kernel.

    A cell that joins or leaves changes the weights nearby by the inverse kernel: a stencil adds this change, and the
    product is only repeated after many cells have changed.
    """

    def __init__(self, inverse: InverseConvolution, shape: tuple[int, int], work: Work) -> None:
        self._inverse = inverse
        self._shape = shape
        self._work = work
        self._mask: Mask = np.zeros(0, dtype=bool)
        # M 1 on all cells, flat.
        self._field: RealArray = np.zeros(0, dtype=np.float32)
        self._stencil: RealArray | None = None
        self._changed = 0
        # Whether the weights were computed anew, because many cells have changed.
        self.renewed = False

    def update(self, active: ActiveCells) -> RealArray | None:
        """Return the vector of the weights, above zero; None if ringing of the inverse leaves none."""
        mask = active.mask
        changed = np.flatnonzero(mask ^ self._mask) if self._mask.size else None
        self._changed += 0 if changed is None else changed.size
        self.renewed = (
            changed is None
            or changed.size > _MAX_STENCIL_FRACTION * mask.size
            or self._changed > _MAX_CHANGED_FRACTION * _smaller(active)
        )
        if self.renewed:
            self._changed = 0
        if changed is None or self.renewed or (changed.size and not self._inverse.local):
            self._field = self._work.invert(self._inverse, active.scatter(active.ones).reshape(self._shape)).ravel()
        elif changed.size:
            self._add(changed, np.where(mask[changed], np.float32(1.0), np.float32(-1.0)))
        self._mask = mask
        weights = active.gather(self._field)
        mean = total(weights) / active.count
        if not mean > 0.0:
            return None
        return np.maximum(weights, np.float32(_MIN_WEIGHT * mean) * active.ones)

    def _add(self, cells: IntArray, amounts: RealArray) -> None:
        """Add amounts times the inverse kernel around cells."""
        if self._stencil is None:
            self._stencil = self._inverse.coefficients(_STENCIL_REACH)
        self._inverse.add_near(self._field, self._shape, cells, amounts, self._stencil)


def _smaller(active: ActiveCells) -> float:
    """Return the number of active cells or, if less, of passive cells and a fraction of the grid."""
    cells = active.mask.size
    return min(active.count, cells - active.count + _PASSIVE_ALLOWANCE * cells)


def is_steep(inverse: InverseConvolution) -> bool:
    """Return whether the inverse rises much faster than the wave number.

    The stiffness S of an elastic half-space is proportional to the wave number. With the shortest wave N along an
    axis, the longest one 1 and one of four times the shortest length, the steepness is the product
    (S_N / S_1 / N) (S_N / S_{N/4} / 4): large if short waves are much stiffer than long ones, above all near the length
    of the cells.
    """
    return any(
        float(axis[m // 2]) ** 2 > _MIN_STEEPNESS * 4 * (m // 2) * float(axis[1]) * float(axis[m // 8])
        for axis, m in zip(inverse.axes, inverse.padded, strict=True)
        if m >= _MIN_STEEPNESS_CELLS
    )


def half_space_inverse(inverse: InverseConvolution, spacing: Pair) -> InverseConvolution:
    """Return the inverse of a half-space with the stiffness of another inverse for its longest wave along y.

    Its flat-punch weights are above zero; the weights of a steep inverse ring.
    """
    mx, my = inverse.padded
    dx, dy = spacing
    q = np.hypot(np.fft.fftfreq(mx, dx)[:, np.newaxis], np.fft.rfftfreq(my, dy)[np.newaxis, :])
    scale = float(inverse.axes[1][1]) / float(q[0, 1])
    stiffness = np.asarray(scale * q, dtype=inverse.stiffness.dtype, like=inverse.stiffness)
    return attrs.evolve(inverse, stiffness=stiffness, exact=False)


class ExtendedInverse:
    r"""The inverse kernel M applied to a displacement that is continued smoothly beyond the active cells.

    A displacement that is continued by zero has a step around each contact, which needs a large pressure if the kernel
    is stiff for short waves. With the extension E, a matrix,

    .. math:: z = E^T M E\,r, \qquad E\,r = \begin{cases} r & \text{on active cells} \\
        \dfrac{G r}{G 1 + \epsilon} & \text{elsewhere} \end{cases}

    G averages over the neighbourhood, on blocks of 2 x 2 cells. The result is symmetric and not negative. If E r
    minimised the energy of M, z would be exact; a uniform displacement gives none, so that rigid motion has to be
    excluded or treated on its own.
    """

    def __init__(self, inverse: InverseConvolution, shape: tuple[int, int], work: Work) -> None:
        self._inverse = inverse
        self._shape = shape
        self._work = work
        self._average = _BlockAverage.of(inverse)
        self._mask: Mask | None = None
        # Zero on active cells; elsewhere the reciprocal weight of the active cells.
        self._factor: RealArray = np.zeros(0, dtype=np.float32, like=inverse.stiffness)

    def update(self, active: ActiveCells) -> None:
        """Set the active cells."""
        if self._mask is not None and not (self._mask ^ active.mask).any():
            return
        self._mask = active.mask
        indicator = self._embed(active.mask.astype(np.float32))
        weight = np.maximum(self._apply_average(indicator), np.float32(0.0))
        self._factor = (np.float32(1.0) - indicator) / (weight + np.float32(_EXTENSION_END_WEIGHT))

    def apply(self, active: ActiveCells, residual: RealArray) -> RealArray:
        """Return the vector of the preconditioned residual, without its rigid part."""
        nx, ny = self._shape
        mx, my = self._inverse.padded
        field = self._embed(active.scatter(residual))
        field += self._factor * self._apply_average(field)
        # A last row or column beyond the padded grid stays zero.
        field[:mx, :my] = self._inverse.apply(field[:mx, :my])
        field += self._apply_average(self._factor * field)
        return active.gather(field[:nx, :ny].copy().ravel())

    def _apply_average(self, field: RealArray) -> RealArray:
        # An average takes a quarter of a product.
        self._work.inverse += 0.25
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
        symbol = (1.0 + (2.0 * np.pi * _DECAY_BLOCKS * waves) ** 2) ** -1.5
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


class Preconditioner:
    """The stiffness of the active cells: the inverse kernel between masks, with two corrections.

    The second, for rigid motion, is needed only if `rigid`: if the approach is given. A kernel that is much
    stiffer for short waves is inverted by `ExtendedInverse` instead, with the weights of a half-space and
    without the first correction.
    """

    def __init__(
        self, inverse: InverseConvolution, convolution: PreparedConvolution, work: Work, *, rigid: bool
    ) -> None:
        self.work = work
        self._inverse = inverse
        self._convolution = convolution
        self._rigid = rigid
        self._shape = convolution.setup.grid.shape
        self._extended = ExtendedInverse(inverse, self._shape, work) if is_steep(inverse) else None
        if self._extended is not None:
            inverse = half_space_inverse(inverse, convolution.setup.grid.spacing)
        self._punch = PunchWeights(inverse, self._shape, work)
        self._rigid_correction: RigidCorrection | None = None
        self._coarse_correction: CoarseCorrection | None = None

    def weights(self, active: ActiveCells) -> RealArray:
        """Return the vector of flat-punch weights M 1 of the active cells, above zero."""
        weights = self._punch.update(active)
        self._coarse_correction = None
        if weights is None:
            weights = active.ones
        elif self._extended is None:
            self._coarse_correction = CoarseCorrection(self._inverse, self._shape, active, weights)
        if self._rigid and self._punch.renewed:
            self._rigid_correction = RigidCorrection(self._convolution, active, weights)
            self.work.inverse += 2
        return weights

    def apply(self, active: ActiveCells, weights: RealArray, residual: RealArray) -> RealArray:
        """Return the vector of the preconditioned residual."""
        image = self._apply_masked(active, residual)
        if self._coarse_correction is not None:
            corrected = image - self._coarse_correction.apply(weights, residual)
            # Where weights ring, the correction may turn the direction uphill.
            if dot(residual, corrected) > 0.0:
                image = corrected
        if self._rigid_correction is None:
            return image
        return self._rigid_correction.apply(active, image, residual, weights)

    def levels(self, weights: RealArray, gap: RealArray, level: np.float32) -> Levels:
        """Return the level below which open cells are released; see `SupportsPreconditioning`."""
        correction = self._coarse_correction
        return None if correction is None else correction.levels(weights, gap, level)

    def _apply_masked(self, active: ActiveCells, vector: RealArray) -> RealArray:
        self.work.inverse += 1
        if self._extended is not None:
            self._extended.update(active)
            return self._extended.apply(active, vector)
        return multiply_active(active, vector, self._inverse, self._inverse.stiffness, self._shape)


def multiply_active(
    active: ActiveCells, vector: RealArray, inverse: InverseConvolution, symbol: RealArray, shape: tuple[int, int]
) -> RealArray:
    """Return the vector of a field that is zero where it is not active, with its waves multiplied by a symbol."""
    field = active.scatter(vector).reshape(shape)
    rows = active.few_rows(shape[1]) if inverse.by_rows else None
    return active.gather(inverse.multiply(field, symbol, inverse.padded, rows).ravel())


class CoarseCorrection:
    r"""Corrects :math:`z_0 = M_0 r` for waves longer than the distance of contacts.

    Splitting the kernel into a near and a far part, with the flat-punch weights w of the near one,
    Woodbury's formula gives

    .. math:: z = z_0 - w\,P\,(P^T Q P + P^T \operatorname{diag}(w) P)^{-1} P^T (w\,r)

    with P constant on blocks of cells and Q the stiffness of the far part alone. The system on the
    blocks is solved by a few conjugate gradients.
    """

    def __init__(
        self, inverse: InverseConvolution, shape: tuple[int, int], active: ActiveCells, weights: RealArray
    ) -> None:
        self._inverse = inverse
        mx, my = inverse.padded
        mean = total(weights) / (mx * my)
        partition = partition_for(inverse.axes, mean, shape, (mx, my))
        bx, by = partition.blocks
        self._blocks = inverse.blocks(active, partition)
        self._diagonal = self._blocks.sums(weights).astype(np.float32)
        half = np.fft.fftfreq(bx, 1 / bx).astype(int)
        stiffness = inverse.long_waves(half, by // 2 + 1)
        size = mx * my / (bx * by)
        far = stiffness * cut_factor(stiffness, mean) * np.float32(size)
        self._mean = np.float32(size * mean)
        self._approximate = 1.0 / (far + self._mean)

    def apply(self, weights: RealArray, residual: RealArray) -> RealArray:
        """Return the vector to be subtracted from z0."""
        solution = self._solve(self._blocks.sums(weights * residual).astype(np.float32))
        spread: RealArray = self._blocks.spread(solution)
        return weights * spread

    def levels(self, weights: RealArray, gap: RealArray, level: np.float32) -> Callable[[slice], RealArray]:
        """Return the level by tiles, lower by a part of the mean overlap where the contacts of a block overlap."""
        loads = np.maximum(self._blocks.sums(weights), _MIN_BLOCK_WEIGHT)
        excess = np.minimum(self._blocks.sums(weights * (gap - level)) / loads, 0.0)
        tiles: Callable[[slice], RealArray] = self._blocks.tiles((_RELEASE_PART * excess + level).astype(np.float32))
        return tiles

    def _solve(self, right: RealArray) -> RealArray:
        return solve_on_blocks(
            right,
            lambda values: self._inverse.multiply(values, self._approximate, values.shape),
            lambda values: (self._diagonal - self._mean) * values,
        )


def solve_on_blocks(
    right: RealArray, approximate: Callable[[RealArray], RealArray], rest: Callable[[RealArray], RealArray]
) -> RealArray:
    """Solve the system of a coarse correction to a few per cent, by conjugate gradients.

    Parameters
    ----------
    right
        The right side, float32, with two axes.
    approximate
        The inverse of an approximation of the system.
    rest
        The system less the inverse of `approximate`.
    """
    size = float(np.abs(right).max())
    solution = np.zeros_like(right)
    if size == 0.0:
        return solution
    # Squares of small residuals would leave the range of float32.
    residual = right / np.float32(size)
    first = math.sqrt(sum_of_products(residual, residual))
    direction = response = np.zeros_like(right)
    previous = math.inf
    for _ in range(_MAX_BLOCK_STEPS):
        image = approximate(residual)
        product = sum_of_products(residual, image)
        factor = np.float32(product / previous)
        direction = image + factor * direction
        response = residual + rest(image) + factor * response
        curvature = sum_of_products(direction, response)
        if not (curvature > 0.0 and product > 0.0):
            break
        solution += np.float32(product / curvature) * direction
        residual = residual - np.float32(product / curvature) * response
        if math.sqrt(sum_of_products(residual, residual)) < _BLOCK_RESIDUAL * first:
            break
        previous = product
    return solution * np.float32(size)


class RigidCorrection:
    r"""Solves exactly in the space of two pressures that move the surface: the flat-punch weights and a uniform one.

    .. math:: z \leftarrow z - w\,\frac{\sum z}{\sum w} + V\,(V^T K V)^{-1} V^T r, \quad V = [w, 1]

    Such a motion is part of the solution if the approach is given, and excluded if the load is.
    """

    def __init__(self, convolution: PreparedConvolution, active: ActiveCells, weights: RealArray) -> None:
        shape = convolution.setup.grid.shape
        vectors = weights, active.ones
        responses = [
            active.gather(convolution.apply(active.scatter(vector).reshape(shape)).ravel()) for vector in vectors
        ]
        products = [[dot(one, other) for other in responses] for one in vectors]
        self._inverse = np.linalg.pinv(np.array(products), rcond=_MIN_SINGULAR_RATIO)

    def apply(self, active: ActiveCells, image: RealArray, residual: RealArray, weights: RealArray) -> RealArray:
        """Return the preconditioned residual with its rigid part made exact."""
        fraction = total(image) / total(weights)
        parts = self._inverse @ [dot(vector, residual) for vector in (weights, active.ones)]
        return image + np.float32(parts[0] - fraction) * weights + np.float32(parts[1]) * active.ones


@guarded
def count_blocks(stiffness: RealArray, count: int, mean: float) -> int:
    """Return the number of blocks of the coarse correction along an axis: few, but enough for all long waves.

    Parameters
    ----------
    stiffness
        Stiffness of the waves along the axis, shape (count // 2 + 1,).
    count
        Cells along the axis.
    mean
        Mean of the flat-punch weights over all cells, in units of the stiffness.

    Examples
    --------
    >>> import numpy as np
    >>> import roughcontact as rc
    >>> rc.solving.count_blocks(np.arange(65.0), 128, 1.0)
    16
    """
    count = integer(count, "count=", at_least=1)
    mean = number(mean, "mean=", at_least=0.0)
    allowed = "finite numbers, one for each of the count // 2 + 1 waves along the axis"
    axis = numbers(stiffness, "stiffness=", allowed)
    if axis.shape != (count // 2 + 1,) or not np.isfinite(axis).all():
        raise InputError.about("stiffness=", stiffness, allowed)
    return _count_blocks(axis, count, mean)


def _count_blocks(axis: RealArray, count: int, mean: float) -> int:
    size = 1
    while 2 * size <= _MAX_BLOCK_CELLS and count // (2 * size) >= _MIN_BLOCKS:
        if axis[max(count // (4 * size), 1)] < _BLOCK_RESOLUTION * LONG_WAVE_CUT * mean:
            break
        size *= 2
    return max(count // size, 1)


def partition_for(axes: Iterable[RealArray], mean: float, shape: tuple[int, int], padded: tuple[int, int]) -> Partition:
    """Return the blocks of a coarse correction of cells, from the stiffness along both axes; see `count_blocks`."""
    bx, by = (_count_blocks(axis, count, mean) for axis, count in zip(axes, padded, strict=True))
    return divide(shape, padded, (bx, by))


def cut_factor(stiffness: RealArray, mean: float) -> RealArray:
    """Return the factor on the stiffness of waves that takes short ones, beyond the cut, out of the far part."""
    return np.exp(np.minimum((stiffness / (LONG_WAVE_CUT * mean)) ** 2, MAX_CUT_EXPONENT))
