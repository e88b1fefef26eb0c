"""The face of the discs on which a shear lies: cells that stick, and cells that slip along their circle."""

from __future__ import annotations

from functools import cached_property

import attrs
import numpy as np

from roughcontact._base.arrays import Array, Mask, sum_of_products
from roughcontact._solve.solvers.shear.base import ShearSystem
from roughcontact._solve.solvers.shear.discs import dot
from roughcontact._solve.solvers.shear.preconditioner import CoarseCorrection, PunchWeights, Weights


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
        Outward slip over the limit, which the circle adds to the kernel, shape (n,); zero where a cell sticks.
    """

    system: ShearSystem
    punch: PunchWeights
    slips: Mask
    normal: Array
    curvature: Array

    @classmethod
    def find(cls, system: ShearSystem, punch: PunchWeights, shear: Array, slip: Array) -> Face:
        """Return the face of a shear: a cell slips if it lies on its circle and its slip points outwards."""
        outward = dot(shear, slip) / system.limit**2
        slips = system.find_on_circle(shear) & (outward > 0.0)
        return cls(
            system=system, punch=punch, slips=slips, normal=shear * (slips / system.limit), curvature=slips * outward
        )

    def move_to(self, shear: Array) -> Face:
        """Return the face with the directions of another shear."""
        return attrs.evolve(self, normal=shear * (self.slips / self.system.limit))

    def restrict(self, vectors: Array) -> Array:
        """Return the part of vectors along the circle where a cell slips, and the vectors elsewhere."""
        return vectors - self.normal * dot(self.normal, vectors)

    @cached_property
    def ease(self) -> Array:
        """How easily a cell follows a displacement, 1 where it sticks: own over own plus curvature."""
        own = self.system.own
        return np.asarray(own / (self.curvature + own))

    @cached_property
    def weights(self) -> Weights:
        """The shear if all cells are displaced alike."""
        return self.punch.find(self.slips, self.normal, self.ease)

    def _solve_for_mean(self, total: Array) -> Array:
        """Return the displacement of all cells that changes the force by a total, shape (2, 1)."""
        return self.system.control.solve_on_axes(self.weights.total, total)[:, np.newaxis]

    def find_residual(self, slip: Array) -> Array:
        """Return the slip in the face without its mean along axes with a given force."""
        mean = self._solve_for_mean(self.weights.multiply(slip).sum(axis=1))
        return self.restrict(slip - mean)

    def balance(self, vectors: Array) -> Array:
        """Return vectors in the face that do not change the given force."""
        inside = self.restrict(vectors)
        return inside - self.weights.multiply(self._solve_for_mean(inside.sum(axis=1)))

    def precondition(self, residual: Array) -> Array:
        r"""Return the preconditioned residual, in the face.

        With the inverse kernel M, the curvature :math:`\lambda` and a cell's own coefficient k it is
        :math:`R M R + (1 - D) / (\lambda + k)`, :math:`D = k / (k + \lambda)`, :math:`R = \sqrt D`: near the edge of
        the contact, where the limit falls to zero, the curvature is far above the kernel.
        """
        root = np.sqrt(self.ease)
        preconditioned = root * self.system.multiply_inverse((root * residual).astype(np.float32))
        preconditioned += self.ease * (1.0 - self.ease) / self.system.own * residual
        corrected = preconditioned - CoarseCorrection(self.system, self.weights).apply(residual)
        # Where weights ring, the correction may turn the direction uphill.
        is_downhill = sum_of_products(residual, corrected) > 0.0
        return self.balance(corrected if is_downhill else preconditioned)
