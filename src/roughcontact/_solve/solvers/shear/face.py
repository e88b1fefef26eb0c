"""The face of the discs on which a shear lies: cells that stick, and cells that slip along their circle."""

from __future__ import annotations

from functools import cached_property

import attrs
import numpy as np

from roughcontact._base.arrays import Array, Mask, RealArray, sum_of_products
from roughcontact._solve.solvers.shear.base import ShearSystem
from roughcontact._solve.solvers.shear.discs import dot
from roughcontact._solve.solvers.shear.preconditioner import CoarseCorrection, PunchWeights, Weights

# Maximum curvature: its product with the shear of such a cell, below the limit, stays in the range of float32.
_MAX_CURVATURE = 1e30


@attrs.frozen(eq=False)
class Face:
    """The directions in which the shear may change, and the curvature of the circles.

    Attributes
    ----------
    system
        The task.
    punch
        The weights of the last face.
    slips
        Cells that slip along their circle, shape (n,).
    normal
        Outward direction where a cell slips, zero where it sticks, shape (2, n).
    curvature
        Outward slip over the limit, which the circle adds to the kernel, float32, shape (n,); zero where a cell sticks.
    """

    system: ShearSystem
    punch: PunchWeights
    slips: Mask
    normal: Array
    curvature: RealArray

    @classmethod
    def find(cls, system: ShearSystem, punch: PunchWeights, shear: Array, slip: Array) -> Face:
        """Return the face of a shear: a cell slips if it lies on its circle and its slip points outwards."""
        outward = dot(shear, slip) / system.limit**2
        slips = system.find_on_circle(shear) & (outward > 0.0)
        curvature = np.minimum(slips * outward, _MAX_CURVATURE).astype(np.float32)
        return cls(system=system, punch=punch, slips=slips, normal=shear * (slips / system.limit), curvature=curvature)

    def move_to(self, shear: Array) -> Face:
        """Return the face with the directions of another shear."""
        return attrs.evolve(self, normal=shear * (self.slips / self.system.limit))

    @cached_property
    def normal_float32(self) -> RealArray:
        """The outward direction in float32."""
        return self.normal.astype(np.float32)

    def restrict(self, vectors: RealArray) -> RealArray:
        """Return the part of vectors along the circle where a cell slips, and the vectors elsewhere."""
        normal = self.normal_float32 if vectors.dtype == np.float32 else self.normal
        outward = normal * dot(normal, vectors)
        return np.subtract(vectors, outward, out=outward)

    @cached_property
    def ease(self) -> RealArray:
        """How easily a cell follows a displacement, 1 where it sticks: own over own plus curvature; float32."""
        own = np.float32(self.system.own)
        return np.asarray(own / (self.curvature + own))

    @cached_property
    def weights(self) -> Weights:
        """The shear if all cells are displaced alike."""
        return self.punch.find(self.slips, self.normal_float32, self.ease)

    def _solve_for_mean(self, total: Array) -> RealArray:
        """Return the displacement of all cells that changes the force by a total, float32, shape (2, 1)."""
        mean = self.system.control.solve_on_axes(self.weights.total, total)
        return mean.astype(np.float32)[:, np.newaxis]

    def find_residual(self, slip: Array) -> RealArray:
        """Return the slip in the face without its mean along axes with a given force, float32."""
        # Along the circle it is a small part of the slip.
        inside = self.restrict(slip).astype(np.float32)
        return inside - self.restrict(self._solve_for_mean(self.weights.multiply(inside).sum(axis=1)))

    def balance(self, vectors: RealArray) -> RealArray:
        """Return vectors in the face that do not change the given force, float32."""
        inside = self.restrict(vectors)
        inside -= self.weights.multiply(self._solve_for_mean(inside.sum(axis=1)))
        return inside

    def precondition(self, residual: RealArray) -> RealArray:
        r"""Return the preconditioned residual, in the face.

        With the inverse kernel M, the curvature :math:`\lambda` and a cell's own coefficient k it is
        :math:`R M R + (1 - D) / (\lambda + k)`, :math:`D = k / (k + \lambda)`, :math:`R = \sqrt D`: near the edge of
        the contact, where the limit falls to zero, the curvature is far above the kernel.
        """
        root = np.sqrt(self.ease)
        preconditioned = self.system.multiply_inverse(root * residual)
        preconditioned *= root
        preconditioned += (self.ease - self.ease * self.ease) / np.float32(self.system.own) * residual
        weights = self.weights
        if self.punch.is_full:
            return self.balance(preconditioned)
        corrected = preconditioned - CoarseCorrection(self.system, weights).apply(residual)
        # Where weights ring, the correction may turn the direction uphill.
        is_downhill = sum_of_products(residual, corrected) > 0.0
        return self.balance(corrected if is_downhill else preconditioned)
