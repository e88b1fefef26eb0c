"""The stress in one plane below a surface, and its invariants."""

from __future__ import annotations

import math

import attrs
import numpy as np

from roughcontact._base.checks import Array, RealArray, read_only
from roughcontact._base.units import si
from roughcontact._parts.grid import Grid


@attrs.frozen(eq=False)
class StressField:
    """The stress at one depth below a surface; tension is positive.

    Attributes
    ----------
    depth
        Depth below the surface, m.
    grid
        The points, centres of its cells: those of the solution near the surface, fewer where the stress varies slowly.
    values
        The components xx, yy, zz, yz, xz, xy over `scale`, float32, shape (6, nx, ny); z points into the body.
    scale
        The maximum contact pressure, Pa.
    """

    depth: float
    grid: Grid
    values: RealArray = attrs.field(converter=read_only, repr=False)
    scale: float

    @property
    def components(self) -> Array:
        """The components xx, yy, zz, yz, xz, xy, shape (6, nx, ny), Pa."""
        return np.asarray(self.values * np.float64(self.scale))

    @property
    def von_mises(self) -> Array:
        """Von Mises equivalent stress, shape (nx, ny), Pa."""
        return np.asarray(von_mises(self.values) * np.float64(self.scale))

    @property
    def shear(self) -> Array:
        """Maximum shear stress, half the difference of the extreme principal stresses, shape (nx, ny), Pa."""
        return np.asarray(maximum_shear(self.values) * np.float64(self.scale))

    def __str__(self) -> str:
        return (
            f"stress at a depth of {si(self.depth, 'm')} on {self.grid}: "
            f"von Mises up to {si(float(self.von_mises.max()), 'Pa')}"
        )


def shear_invariant(values: RealArray) -> RealArray:
    """Return the second invariant J2 of the deviator of stresses in the order `COMPONENTS`, along the first axis."""
    xx, yy, zz, yz, xz, xy = values
    normal = (xx - yy) ** 2
    normal += (yy - zz) ** 2
    normal += (zz - xx) ** 2
    normal /= 6.0
    for shear in (yz, xz, xy):
        normal += shear * shear
    return np.asarray(normal)


def von_mises(values: RealArray) -> RealArray:
    """Return the von Mises equivalent stress of stresses in the order `COMPONENTS`, along the first axis."""
    return np.asarray(np.sqrt(3.0 * shear_invariant(values)))


def maximum_shear(values: RealArray) -> RealArray:
    r"""Return the maximum shear stress of stresses in the order `COMPONENTS`, along the first axis.

    .. math:: \tau = \sqrt{J_2} \sin(\theta + \pi/3), \quad \cos 3\theta = \frac{3\sqrt 3}{2} \frac{J_3}{J_2^{3/2}}
    """
    root = np.sqrt(shear_invariant(values))
    # Over the root, so that the third invariant does not leave the range of float32.
    size = np.where(root > 0.0, root, 1.0)
    mean = (values[0] + values[1] + values[2]) / 3.0
    xx, yy, zz = ((normal - mean) / size for normal in values[:3])
    yz, xz, xy = (shear / size for shear in values[3:])
    cube = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz)
    angle = np.arccos(np.clip(1.5 * math.sqrt(3.0) * cube, -1.0, 1.0)) / 3.0
    return np.asarray(root * np.sin(angle + math.pi / 3.0))
