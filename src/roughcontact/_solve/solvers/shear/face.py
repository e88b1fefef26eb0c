"""The face of the discs on which a shear lies: cells that stick, and cells that slip along their circle."""

from __future__ import annotations

import attrs
import numpy as np

from roughcontact._base.arrays import Array, Mask, RealArray
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
        Direction along the circle, float32, shape (2, n).
    curvature
        Outward slip over the limit, which the circle adds to the kernel, float32, shape (n,); zero where a cell sticks.
    """

    system: ShearSystem
    slips: Mask
    tangent: RealArray
    curvature: RealArray

    @classmethod
    def find(cls, system: ShearSystem, shear: Array, slip: RealArray) -> Face:
        """Return the face of a shear: a cell slips if it lies on its circle and its slip points outwards."""
        normal = directions(shear, magnitude(shear))
        outward = dot(normal, slip) / system.limit
        slips = system.find_on_circle(shear) & (outward > 0.0)
        return cls(
            system=system,
            slips=slips,
            tangent=np.stack((-normal[1], normal[0])).astype(np.float32),
            curvature=np.where(slips, outward, 0.0).astype(np.float32),
        )

    def restrict(self, vectors: RealArray) -> RealArray:
        """Return the part of vectors along the circle where a cell slips, and the vectors elsewhere."""
        return np.where(self.slips, self.tangent * dot(self.tangent, vectors), vectors)

    def balance(self, vectors: RealArray) -> RealArray:
        """Return the nearest vectors in the face that do not change the given force."""
        inside = self.restrict(vectors)
        x, y = self.tangent
        xx, xy, yy = (
            float(np.where(self.slips, product, stuck).sum(dtype=np.float64))
            for product, stuck in ((x * x, 1.0), (x * y, 0.0), (y * y, 1.0))
        )
        total = inside.sum(axis=1, dtype=np.float64)
        mean = self.system.control.solve_on_axes(np.array([[xx, xy], [xy, yy]]), total, x.size)
        return inside - self.restrict(np.broadcast_to(mean.astype(np.float32)[:, np.newaxis], inside.shape))

    def precondition(self, residual: RealArray) -> RealArray:
        r"""Return the preconditioned residual, in the face.

        With the inverse kernel M, the curvature :math:`\lambda` and a cell's own coefficient k it is
        :math:`R M R + (1 - D) / (\lambda + k)`, :math:`D = k / (k + \lambda)`, :math:`R = \sqrt D`: near the edge of
        the contact, where the limit falls to zero, the curvature is far above the kernel.
        """
        own = np.float32(self.system.own)
        stiffness = self.curvature + own
        root = np.sqrt(own / stiffness)
        preconditioned = root * self.system.multiply_inverse(root * residual)
        preconditioned += self.curvature / (stiffness * stiffness) * residual
        return self.balance(preconditioned)
