"""The face of the discs on which a shear lies: cells that stick, and cells that slip along their circle."""

from __future__ import annotations

from functools import cached_property

import attrs
import numpy as np

from roughcontact._base.arrays import Array, Mask
from roughcontact._solve.solvers.shear.base import ShearSystem
from roughcontact._solve.solvers.shear.discs import directions, dot, magnitude


@attrs.frozen(eq=False)
class Face:
    """The directions in which the shear may change, and the curvature of the circles.

    Attributes
    ----------
    system
        The task.
    slips
        Cells that slip along their circle, shape (n,).
    tangent
        Direction along the circle, shape (2, n).
    curvature
        Outward slip over the limit, which the circle adds to the kernel, shape (n,); zero where a cell sticks.
    """

    system: ShearSystem
    slips: Mask
    tangent: Array
    curvature: Array

    @classmethod
    def find(cls, system: ShearSystem, shear: Array, slip: Array) -> Face:
        """Return the face of a shear: a cell slips if it lies on its circle and its slip points outwards."""
        normal = directions(shear, magnitude(shear))
        outward = dot(normal, slip) / system.limit
        slips = system.find_on_circle(shear) & (outward > 0.0)
        return cls(
            system=system,
            slips=slips,
            tangent=_turn(normal),
            curvature=np.where(slips, outward, 0.0),
        )

    def move_to(self, shear: Array) -> Face:
        """Return the face with the tangents of another shear."""
        return attrs.evolve(self, tangent=_turn(directions(shear, self.system.limit)))

    def restrict(self, vectors: Array) -> Array:
        """Return the part of vectors along the circle where a cell slips, and the vectors elsewhere."""
        return np.where(self.slips, self.tangent * dot(self.tangent, vectors), vectors)

    @cached_property
    def ease(self) -> Array:
        """How easily a cell follows a displacement, 1 where it sticks: own over own plus curvature."""
        own = self.system.own
        return np.asarray(own / (self.curvature + own))

    def _solve_for_mean(self, total: Array) -> Array:
        """Return the displacement of all cells, each as easily as it follows, that changes the force by a total."""
        x, y = self.tangent
        xx, xy, yy = (
            float((self.ease * np.where(self.slips, product, stuck)).sum())
            for product, stuck in ((x * x, 1.0), (x * y, 0.0), (y * y, 1.0))
        )
        mean = self.system.control.solve_on_axes(np.array([[xx, xy], [xy, yy]]), total)
        return self.restrict(np.broadcast_to(mean[:, np.newaxis], self.tangent.shape))

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


def _turn(normal: Array) -> Array:
    """Return the directions along the circles."""
    return np.stack((-normal[1], normal[0]))
