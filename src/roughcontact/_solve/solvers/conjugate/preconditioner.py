"""The inverse kernel on the active cells, corrected for long waves and for rigid motion."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from roughcontact._base.checks import RealArray
from roughcontact._solve.convolvers import InverseConvolution, PreparedConvolution
from roughcontact._solve.solvers.conjugate.active import ActiveCells, Partition
from roughcontact._solve.solvers.conjugate.extension import ExtendedInverse, half_space_inverse, is_steep
from roughcontact._solve.solvers.conjugate.weights import PunchWeights
from roughcontact._solve.solvers.projection import dot, total

# Waves are long up to this multiple of the wave whose stiffness is the mean weight; blocks resolve so much more.
_CUT = 3.0
_RESOLVED = 1.5
# Maximum cells along a block, and minimum blocks along an axis.
_LARGEST_BLOCK = 64
_FEWEST_BLOCKS = 8
# Conjugate gradients on the blocks at most, and the relative residual at which they end.
_STEPS = 4
_ENOUGH = 0.02
# Bound of the exponent that cuts the short waves off: exp(30) = 1e13 is beyond float32's resolution.
_EXPONENT = 30.0
# Singular values of the two rigid pressures, over the larger, below which they are one; float32 has 1e-7.
_DISTINCT = 1e-6


class Preconditioner:
    """The stiffness of the active cells: the inverse kernel between masks, with two corrections.

    The second, for rigid motion, is needed only if `rigid`: if the approach is given. A kernel that is much
    stiffer for short waves is inverted by `ExtendedInverse` instead, with the weights of a half-space and
    without the first correction.
    """

    def __init__(self, inverse: InverseConvolution, convolution: PreparedConvolution, *, rigid: bool) -> None:
        self._inverse = inverse
        self._convolution = convolution
        self._rigid = rigid
        self._shape = convolution.setup.grid.shape
        self._extended = ExtendedInverse(inverse, self._shape) if is_steep(inverse) else None
        if self._extended is None:
            self._punch = PunchWeights(inverse, self._shape)
        else:
            spacing = convolution.setup.grid.spacing
            self._punch = PunchWeights(half_space_inverse(inverse, spacing), self._shape)
        self._rigid_correction: RigidCorrection | None = None
        self._coarse_correction: CoarseCorrection | None = None
        self._products = 0

    @property
    def products(self) -> int:
        """Products so far."""
        extended = 0 if self._extended is None else self._extended.products
        return self._products + self._punch.products + extended

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
            self._products += 2
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

    def _apply_masked(self, active: ActiveCells, vector: RealArray) -> RealArray:
        self._products += 1
        if self._extended is not None:
            self._extended.update(active)
            return self._extended.apply(active, vector)
        return multiply_active(active, vector, self._inverse, self._inverse.stiffness, self._shape)


def multiply_active(
    active: ActiveCells, vector: RealArray, inverse: InverseConvolution, symbol: RealArray, shape: tuple[int, int]
) -> RealArray:
    """Return the vector of a field that is zero where it is not active, with its waves multiplied by a symbol."""
    field = active.scatter(vector).reshape(shape)
    rows = active.few_rows(shape[1])
    return active.gather(inverse.multiply(field, symbol, inverse.padded, rows).ravel())


class CoarseCorrection:
    r"""Corrects :math:`z_0 = M_0 r` for the waves that are longer than the distance of contacts.

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
        bx, by = (_count_blocks(axis, count, mean) for axis, count in zip(inverse.axes, (mx, my), strict=True))
        partition = _divide(shape, (mx, my), (bx, by))
        self._blocks = active.blocks(partition)
        self._diagonal = self._blocks.sums(weights).astype(np.float32)
        half = np.fft.fftfreq(bx, 1 / bx).astype(int)
        stiffness = inverse.stiffness[half][:, : by // 2 + 1]
        size = mx * my / (bx * by)
        growth = np.minimum((stiffness / (_CUT * mean)) ** 2, _EXPONENT)
        far = stiffness * np.exp(growth) * np.float32(size)
        self._mean = np.float32(size * mean)
        self._approximate = 1.0 / (far + self._mean)

    def apply(self, weights: RealArray, residual: RealArray) -> RealArray:
        """Return the vector to be subtracted from z0."""
        solution = self._solve(self._blocks.sums(weights * residual).astype(np.float32))
        return weights * self._blocks.spread(solution)

    def _solve(self, right: RealArray) -> RealArray:
        """Solve the system on the blocks to a few per cent."""
        size = float(np.abs(right).max())
        solution = np.zeros_like(right)
        if size == 0.0:
            return solution
        # Squares of small residuals would leave the range of float32.
        residual = right / np.float32(size)
        first = math.sqrt(_dot(residual, residual))
        direction = response = np.zeros_like(right)
        previous = math.inf
        for _ in range(_STEPS):
            image = self._inverse.multiply(residual, self._approximate, right.shape)
            product = _dot(residual, image)
            factor = np.float32(product / previous)
            direction = image + factor * direction
            # The system is the inverse of the approximation and what the diagonal exceeds its mean by.
            response = residual + (self._diagonal - self._mean) * image + factor * response
            curvature = _dot(direction, response)
            if not (curvature > 0.0 and product > 0.0):
                break
            solution += np.float32(product / curvature) * direction
            residual = residual - np.float32(product / curvature) * response
            if math.sqrt(_dot(residual, residual)) < _ENOUGH * first:
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
        self._inverse = np.linalg.pinv(np.array(products), rcond=_DISTINCT)

    def apply(self, active: ActiveCells, image: RealArray, residual: RealArray, weights: RealArray) -> RealArray:
        """Return the preconditioned residual with its rigid part made exact."""
        fraction = total(image) / total(weights)
        parts = self._inverse @ [dot(vector, residual) for vector in (weights, active.ones)]
        return image + np.float32(parts[0] - fraction) * weights + np.float32(parts[1]) * active.ones


def _count_blocks(stiffness: RealArray, count: int, mean: float) -> int:
    """Return the number of blocks along an axis: few, but enough for all long waves."""
    size = 1
    while 2 * size <= _LARGEST_BLOCK and count // (2 * size) >= _FEWEST_BLOCKS:
        if stiffness[max(count // (4 * size), 1)] < _RESOLVED * _CUT * mean:
            break
        size *= 2
    return max(count // size, 1)


@lru_cache(maxsize=4)
def _divide(shape: tuple[int, int], padded: tuple[int, int], blocks: tuple[int, int]) -> Partition:
    """Return the partition of the cells; a solve needs the same few repeatedly."""
    rows, columns = (((np.arange(n) * b) // m).astype(np.int32) for n, m, b in zip(shape, padded, blocks, strict=True))
    return Partition(shape, blocks, rows, columns)


def _dot(one: RealArray, other: RealArray) -> float:
    return float(np.einsum("ij,ij->", one, other))
