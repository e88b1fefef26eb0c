"""The stress in one plane below a surface, its points, and its invariants."""

from __future__ import annotations

import math
from collections.abc import Sequence

import attrs
import numpy as np

from roughcontact._base.arrays import Array, Pair, RealArray, read_only
from roughcontact._base.units import ShownAsPrinted, si
from roughcontact._parts.grid import Grid

# Cells of a block in the depth: the waves that blocks of side s do not resolve have decayed to exp(-pi z / s) at the
# depth z, which is 5e-5 for a quarter of the depth.
_MIN_STEPS_IN_DEPTH = 4.0
# Smallest number of points along an axis.
_MIN_POINTS = 16


def find_steps(shape: tuple[int, int], sides: Pair, z: float) -> tuple[int, int]:
    """Return the cells of a block along each axis that resolve the stress at a depth."""
    return _find_step(shape[0], z / sides[0]), _find_step(shape[1], z / sides[1])


def _find_step(count: int, cells: float) -> int:
    step = 1
    while count % (2 * step) == 0 and count >= 2 * step * _MIN_POINTS and 2.0 * step * _MIN_STEPS_IN_DEPTH <= cells:
        step *= 2
    return step


def common_step(steps: Sequence[tuple[int, int]]) -> tuple[int, int]:
    """Return the largest of several steps along each axis: powers of two, so that each divides it."""
    along_x, along_y = zip(*steps, strict=True)
    return max(along_x), max(along_y)


@attrs.frozen(eq=False)
class StressField(ShownAsPrinted):
    """The stress at one depth below a surface; tension is positive.

    Attributes
    ----------
    depth
        Depth below the surface, m.
    grid
        The points, centres of its cells: the cells of the solution near the surface, fewer where the stress is smooth.
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

    @property
    def principal(self) -> Array:
        """Maximum principal stress, shape (nx, ny), Pa; tension is positive."""
        return np.asarray(maximum_principal(self.values) * np.float64(self.scale))

    def __str__(self) -> str:
        return (
            f"stress at a depth of {si(self.depth, 'm')} on {self.grid}: "
            f"von Mises up to {si(float(self.von_mises.max()), 'Pa')}"
        )


def shear_invariant(values: RealArray) -> RealArray:
    """Return the second invariant J2 of the deviator of stresses, Voigt's components along the first axis."""
    xx, yy, zz, yz, xz, xy = values
    normal = (xx - yy) ** 2
    normal += (yy - zz) ** 2
    normal += (zz - xx) ** 2
    normal /= 6.0
    for shear in (yz, xz, xy):
        normal += shear * shear
    return np.asarray(normal)


def von_mises(values: RealArray) -> RealArray:
    """Return the von Mises equivalent stress of stresses, Voigt's components along the first axis."""
    return np.asarray(np.sqrt(3.0 * shear_invariant(values)))


def maximum_shear(values: RealArray) -> RealArray:
    r"""Return the maximum shear stress of stresses, Voigt's components along the first axis.

    .. math:: \tau = \sqrt{J_2} \sin(\theta + \pi/3), \quad \cos 3\theta = \frac{3\sqrt 3}{2} \frac{J_3}{J_2^{3/2}}
    """
    root, angle = _find_lode_angle(values)
    return np.asarray(root * np.sin(angle + math.pi / 3.0))


def maximum_principal(values: RealArray) -> RealArray:
    r"""Return the maximum principal stress of stresses, Voigt's components along the first axis.

    .. math:: \sigma_1 = \tfrac13 \operatorname{tr}\sigma + 2 \sqrt{J_2/3} \cos\theta
    """
    root, angle = _find_lode_angle(values)
    return np.asarray(mean_stress(values) + 2.0 / math.sqrt(3.0) * root * np.cos(angle))


def mean_stress(values: RealArray) -> RealArray:
    """Return the mean of the normal stresses of stresses, Voigt's components along the first axis."""
    return np.asarray((values[0] + values[1] + values[2]) / 3.0)


def _find_lode_angle(values: RealArray) -> tuple[RealArray, RealArray]:
    """Return the root of the second invariant of the deviator and the angle of `maximum_shear`."""
    root = np.sqrt(shear_invariant(values))
    # Over the root, so that the third invariant does not leave the range of float32.
    size = np.where(root > 0.0, root, 1.0)
    mean = mean_stress(values)
    xx, yy, zz = ((normal - mean) / size for normal in values[:3])
    yz, xz, xy = (shear / size for shear in values[3:])
    cube = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz)
    return root, np.asarray(np.arccos(np.clip(1.5 * math.sqrt(3.0) * cube, -1.0, 1.0)) / 3.0)
