"""The long waves of the inverse kernel, which a product between the limits of a contact does not see."""

from __future__ import annotations

import math
from functools import cached_property

import attrs
import numpy as np

from roughcontact._base.arrays import Mask, RealArray
from roughcontact._solve.convolvers import WaveMatrix
from roughcontact._solve.solvers.conjugate.preconditioner import cut_factor, partition_for, solve_on_blocks
from roughcontact._solve.solvers.shear.base import ShearSystem
from roughcontact._solve.solvers.shear.discs import Symmetric, dot

# Fraction of the cells that begin or end to slip before the weights are computed anew: 0.003 and 0.03 change the
# iterations of 54 rough contacts by less than 1 %, and the products by 4 %.
_MAX_CHANGED_FRACTION = 0.01
# Minimum weight, over that of a cell alone times the part of the cells that is free: smaller ones are ringing of the
# inverse. 0.01 and 0.03 change the iterations of 54 rough contacts by 1 %, 0.1 doubles them.
_MIN_WEIGHT = 0.02
# Mean weight, over the same, below which the contact is nearly full and moves as one: from 95 % of the area on.
_FULL_CONTACT_WEIGHT = 0.008
# Cells of a grid up to which all cells weigh alike: at 64 and 128 cells a side that takes a tenth more iterations.
_MAX_SMALL_CELLS = 2**15
# Minimum mean weight of a cell, far below that of one.
_MIN_MEAN = 1e-15


@attrs.frozen(eq=False)
class Weights:
    """The shear of each cell if all are displaced alike, each as the face allows: a symmetric matrix for each cell.

    Attributes
    ----------
    xx, xy, yy
        Its entries, float32, shape (n,).
    """

    xx: RealArray
    xy: RealArray
    yy: RealArray

    def multiply(self, vectors: RealArray) -> RealArray:
        """Return the products with vectors in float32, shape (2, n) or (2, 1)."""
        x, y = vectors
        products = np.empty((2, self.xx.size), dtype=np.float32)
        np.multiply(self.xx, x, out=products[0])
        np.multiply(self.yy, y, out=products[1])
        products[0] += self.xy * y
        products[1] += self.xy * x
        return products

    @cached_property
    def total(self) -> Symmetric:
        """The sum over all cells."""
        xx, xy, yy = (float(np.add.reduce(one)) for one in (self.xx, self.xy, self.yy))
        return xx, xy, yy


@attrs.frozen(eq=False)
class EqualWeights:
    """Weights that are alike for all cells, but for the circles of those that slip: they hold the force alone.

    Attributes
    ----------
    normal, ease
        Those of a `Face`.
    """

    normal: RealArray
    ease: RealArray

    def multiply(self, vectors: RealArray) -> RealArray:
        """Return the products with vectors; see `Weights`."""
        x, y = self.normal
        return np.asarray(self.ease * (vectors - self.normal * (x * vectors[0] + y * vectors[1])))

    @cached_property
    def total(self) -> Symmetric:
        """The sum over all cells."""
        eased = float(np.add.reduce(self.ease))
        (xx, xy), (_, yy) = np.einsum("an,bn->ab", self.ease * self.normal, self.normal).tolist()
        return eased - xx, -xy, eased - yy


class PunchWeights:
    """The weights of faces, one after the other; those of a face little different from the last one are adapted.

    A cell that slips follows along its circle alone. So a displacement along the main direction of slip, and one across
    it, find different cells that resist: each gets a product with the mean of the inverse kernel over directions.

    Attributes
    ----------
    are_equal
        Whether all cells weigh alike: a contact that is nearly full moves as one, and on a small grid the weights, and
        the correction for long waves, cost more than the iterations that they save.
    """

    def __init__(self, system: ShearSystem) -> None:
        self._system = system
        self._is_small = math.prod(system.shape) <= _MAX_SMALL_CELLS
        self.are_equal = self._is_small
        self._slips: Mask | None = None

    def find(self, slips: Mask, normal: RealArray, ease: RealArray) -> Weights | EqualWeights:
        """Return the weights of the cells that slip, their normals and how easily each cell follows; see `Face`."""
        if self._is_small:
            return EqualWeights(normal, ease)
        if self._slips is None or np.count_nonzero(slips != self._slips) > _MAX_CHANGED_FRACTION * slips.size:
            self._slips = slips
            self._renew(normal, ease)
        x, y = normal
        xx, xy, yy = self._stiffness
        own = np.float32(self._system.own)
        along = ease * (y * y * xx - 2 * x * y * xy + x * x * yy + (1 - ease) / own)
        sticks = ~slips
        return Weights(sticks * xx + along * (y * y), sticks * xy - along * (x * y), sticks * yy + along * (x * x))

    def _renew(self, normal: RealArray, ease: RealArray) -> None:
        """Compute the shear if all cells are displaced, as a matrix that does not know yet where cells slip."""
        xx, xy, yy = (float(np.einsum("n,n->", one, other)) for one, other in (normal[[0, 0]], normal, normal[[1, 1]]))
        angle = 0.5 * math.atan2(2.0 * xy, xx - yy)
        along = np.array([math.cos(angle), math.sin(angle)], dtype=np.float32)
        across = np.array([-along[1], along[0]], dtype=np.float32)
        free = np.stack([1 - dot(normal, one[:, np.newaxis]) ** 2 for one in (along, across)])
        shear = self._system.multiply_mean_inverse(np.sqrt(ease) * free)
        own = np.float32(self._system.own)
        alone = free.mean(axis=1, keepdims=True) / own
        self.are_equal = bool((shear.mean(axis=1, keepdims=True) < _FULL_CONTACT_WEIGHT * alone).any())
        one, other = np.full_like(shear, 1 / own) if self.are_equal else np.maximum(shear, _MIN_WEIGHT * alone)
        self._stiffness = [
            along[i] * along[j] * one + across[i] * across[j] * other for i, j in ((0, 0), (0, 1), (1, 1))
        ]


class CoarseCorrection:
    r"""Corrects a preconditioned residual for waves longer than the distance of contacts.

    As for pressure, but with a matrix W for each cell and wave,

    .. math:: z = z_0 - W\,P\,(P^T Q P + P^T W P)^{-1} P^T (W\,r)

    with P constant on blocks of cells and Q the inverse of the far part of the kernel alone.
    """

    def __init__(self, system: ShearSystem, weights: Weights) -> None:
        self._weights = weights
        inverse = system.inverse
        mx, my = inverse.padded
        stiffness = system.mean_stiffness
        along_x, _, along_y = weights.total
        mean = max(0.5 * (along_x + along_y) / (mx * my), _MIN_MEAN)
        partition = partition_for((stiffness[:, 0], stiffness[0]), mean, system.shape, (mx, my))
        self._blocks = system.cells.blocks(partition)
        self._shape = bx, by = partition.blocks
        diagonal = [self._blocks.sums(one).astype(np.float32) for one in (weights.xx, weights.xy, weights.yy)]
        size = mx * my / (bx * by)
        half = np.s_[: bx // 2 + 1, : by // 2 + 1]
        far = cut_factor(stiffness[half], mean) * np.float32(size)
        means = [np.float32(one.mean()) for one in (diagonal[0], diagonal[2])]
        xx, yy = (
            system.scaled_inverse(name)[half] * far + mean for name, mean in zip(("xx", "yy"), means, strict=True)
        )
        xy = system.scaled_inverse("xy")[half] * far
        if bx % 2 == 0:
            xy[-1] = 0.0
        if by % 2 == 0:
            xy[:, -1] = 0.0
        determinant = xx * yy - xy * xy
        symbols = {"xx": yy / determinant, "yy": xx / determinant, "xy": -xy / determinant}
        for name, given in zip(("xx", "yy"), system.control.axes, strict=True):
            # The inverse has no mean wave: the mean shear is corrected only where it is given.
            symbols[name][0, 0] *= np.float32(given)
        self._approximate = WaveMatrix(symbols, (bx, by))
        self._rest = [diagonal[0] - means[0], diagonal[1], diagonal[2] - means[1]]

    def apply(self, residual: RealArray) -> RealArray:
        """Return the vectors to be subtracted from the preconditioned residual."""
        bx, by = self._shape
        right = np.concatenate([self._blocks.sums(one) for one in self._weights.multiply(residual)])
        found = solve_on_blocks(right.astype(np.float32), self._invert, self._respond)
        return self._weights.multiply(np.stack([self._blocks.spread(one) for one in found.reshape(2, bx, by)]))

    def _invert(self, values: RealArray) -> RealArray:
        return self._approximate.apply(values.reshape(2, *self._shape)).reshape(values.shape)

    def _respond(self, values: RealArray) -> RealArray:
        x, y = values.reshape(2, *self._shape)
        xx, xy, yy = self._rest
        return np.concatenate([xx * x + xy * y, xy * x + yy * y])
