"""The face of the discs on which a shear lies: cells that stick, and cells that slip along their circle."""

from __future__ import annotations

from functools import cached_property

import attrs
import numpy as np

from roughcontact._base.arrays import Array, Mask
from roughcontact._solve.solvers.shear.base import ShearSystem
from roughcontact._solve.solvers.shear.discs import dot


@attrs.frozen(eq=False)
class Face:
    """The directions in which the shear may change, and the curvature of the circles.

    Attributes
    ----------
    system
        The task.
    slips
        Cells that slip along their circle, shape (n,).
    normal
        Outward direction where a cell slips, zero where it sticks, shape (2, n).
    curvature
        Outward slip over the limit, which the circle adds to the kernel, shape (n,); zero where a cell sticks.
    """

    system: ShearSystem
    slips: Mask
    normal: Array
    curvature: Array

    @classmethod
    def find(cls, system: ShearSystem, shear: Array, slip: Array) -> Face:
        """Return the face of a shear: a cell slips if it lies on its circle and its slip points outwards."""
        outward = dot(shear, slip) / system.limit**2
        slips = system.find_on_circle(shear) & (outward > 0.0)
        return cls(system=system, slips=slips, normal=shear * (slips / system.limit), curvature=slips * outward)

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
    def _stiffness_of_mean(self) -> Array:
        """The change of the force by a displacement of all cells, each as easily as it follows, shape (2, 2)."""
        bent = -np.einsum("n,an,bn->ab", self.ease, self.normal, self.normal)
        return np.asarray(bent + self.ease.sum() * np.eye(2))

    def _solve_for_mean(self, total: Array) -> Array:
        """Return the displacement of all cells, each as easily as it follows, that changes the force by a total."""
        mean = self.system.control.solve_on_axes(self._stiffness_of_mean, total)[:, np.newaxis]
        return mean - self.normal * dot(self.normal, mean)

    def find_residual(self, slip: Array) -> Array:
        """Return the slip in the face without its mean along axes with a given force."""
        inside = self.restrict(slip)
        return inside - self._solve_for_mean((self.ease * inside).sum(axis=1))

    def balance(self, vectors: Array) -> Array:
        """Return vectors in the face that do not change the given force."""
        inside = self.restrict(vectors)
        return inside - self.ease * self._solve_for_mean(inside.sum(axis=1))

    def precondition(self, residual: Array) -> Array:
        r"""Return the preconditioned residual, in the face.

        With the inverse kernel M, the curvature :math:`\lambda` and a cell's own coefficient k it is
        :math:`R M R + (1 - D) / (\lambda + k)`, :math:`D = k / (k + \lambda)`, :math:`R = \sqrt D`: near the edge of
        the contact, where the limit falls to zero, the curvature is far above the kernel.
        """
        root = np.sqrt(self.ease)
        preconditioned = root * self.system.multiply_inverse((root * residual).astype(np.float32))
        preconditioned += self.ease * (1.0 - self.ease) / self.system.own * residual
        return self.balance(preconditioned)
