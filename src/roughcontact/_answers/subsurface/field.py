"""The stress in one plane below a surface, its invariants, and the waves of the load above it."""

from __future__ import annotations

import abc
import math
from collections.abc import Sequence
from functools import cached_property
from typing import Any

import attrs
import numpy as np
import scipy.fft

from roughcontact._base.arrays import Array, Pair, RealArray, Waves, read_only
from roughcontact._base.machine import threads_for
from roughcontact._base.units import ShownAsPrinted, si
from roughcontact._parts.grid import Grid
from roughcontact._parts.kernels import SupportsStress

# The components of the stress, in Voigt's order.
COMPONENTS = ("xx", "yy", "zz", "yz", "xz", "xy")
# Their places after an exchange of the axes x and y.
EXCHANGED_COMPONENTS = [1, 0, 2, 4, 3, 5]
# Cells of a block in the depth: the waves that blocks of side s do not resolve have decayed to exp(-pi z / s) at the
# depth z, which is 5e-5 for a quarter of the depth.
_MIN_STEPS_IN_DEPTH = 4.0
# Smallest number of points along an axis.
_MIN_POINTS = 16


def is_odd(axis: str, component: str, load: str) -> bool:
    """Return whether a component of the stress is odd along an axis, around a cell with a unit load.

    The load is ``"z"``, a pressure, or ``"x"`` or ``"y"``, a traction along this axis.
    """
    return (component + load).count(axis) % 2 == 1


class StressPlanes(abc.ABC):
    """The stress below a load, one depth at a time, in units of the pressure and of a cell's side along x.

    Deep below the surface the short waves have decayed, and the stress is found at the centres of blocks of cells. A
    block has a power of two of cells along each axis, which divides the cells of the axis.
    """

    @abc.abstractmethod
    def at(self, z: float, poisson: float, steps: tuple[int, int]) -> RealArray:
        """Return the stress at a depth, shape (6, nx // steps[0], ny // steps[1]), order `COMPONENTS`, float32."""


@attrs.frozen(eq=False)
class LayersBelow:
    """What the layers of a kernel add to the stress below a homogeneous half-space.

    Attributes
    ----------
    kernel
        The kernel.
    unit
        Side of a cell along x, m, in which lengths are given.
    """

    kernel: SupportsStress
    unit: float

    def find_table(self, load: str, shape: tuple[int, int], sides: Pair, z: float) -> Array:
        """Return what they add at offsets from a cell with unit load, shape (6, nx, ny)."""
        return self.kernel.stress_coefficients(load, shape, self._lengths(sides), z * self.unit)

    def find_symbols(self, load: str, phases: tuple[Array, Array], sides: Pair, z: float) -> Array:
        """Return what they add for waves with these phases from cell to cell, shape (6, m, n)."""
        spacing = self._lengths(sides)
        qx, qy = (phase / side for phase, side in zip(phases, spacing, strict=True))
        return self.kernel.stress_spectrum(load, qx[:, np.newaxis], qy[np.newaxis, :], spacing, z * self.unit)

    def _lengths(self, sides: Pair) -> Pair:
        return sides[0] * self.unit, sides[1] * self.unit


@attrs.frozen(eq=False)
class LoadedPlanes(StressPlanes):
    """The stress below a load that is constant on each cell, by the waves of the load on a padded grid.

    Attributes
    ----------
    pressure
        Pressure on the cells, float32, shape (nx, ny).
    sides
        Sides of a cell.
    traction
        Traction on the cells along x and y, float32, shape (2, nx, ny); None without.
    layers
        The layers of the body; None of a homogeneous half-space.
    """

    pressure: RealArray
    sides: Pair
    traction: RealArray | None = None
    layers: LayersBelow | None = attrs.field(default=None, kw_only=True)

    @property
    @abc.abstractmethod
    def padded(self) -> tuple[int, int]:
        """Cells (mx, my) of the padded grid."""

    @abc.abstractmethod
    def add(
        self, stress: RealArray, load: str, waves: Waves, shape: tuple[int, int], sides: Pair, z: float, poisson: float
    ) -> None:
        """Add the stress of a load, of which the waves on a padded grid of `shape` with cells of `sides` are given."""

    @cached_property
    def waves(self) -> dict[str, Waves]:
        """The waves of the padded loads by their letters, shape (mx, my // 2 + 1) each; none of a traction of zero."""
        mx, my = self.padded
        workers = threads_for(mx * my)
        loads = {"z": self.pressure}
        if self.traction is not None:
            loads |= {letter: field for letter, field in zip("xy", self.traction, strict=True) if field.any()}
        waves: dict[str, Waves] = {}
        for load, field in loads.items():
            rows = scipy.fft.rfft(field, n=my, axis=1, workers=workers)
            waves[load] = scipy.fft.fft(rows, n=mx, axis=0, overwrite_x=True, workers=workers)
        return waves

    def at(self, z: float, poisson: float, steps: tuple[int, int]) -> RealArray:
        nx, ny = self.pressure.shape
        mx, my = self.padded
        shape = mx // steps[0], my // steps[1]
        sides = steps[0] * self.sides[0], steps[1] * self.sides[1]
        stress = np.zeros((len(COMPONENTS), nx // steps[0], ny // steps[1]), dtype=np.float32)
        for load, fine in self.waves.items():
            waves = coarsen(coarsen(fine, my, steps[1], 1), mx, steps[0], 0)
            self.add(stress, load, waves, shape, sides, z, poisson)
        return stress


def find_steps(shape: tuple[int, int], sides: Pair, z: float) -> tuple[int, int]:
    """Return the cells of a block along each axis that resolve the stress at a depth."""
    return _find_step(shape[0], z / sides[0]), _find_step(shape[1], z / sides[1])


def _find_step(count: int, cells: float) -> int:
    step = 1
    while count % (2 * step) == 0 and count >= 2 * step * _MIN_POINTS and 2.0 * step * _MIN_STEPS_IN_DEPTH <= cells:
        step *= 2
    return step


def coarsen(waves: Waves, length: int, step: int, axis: int) -> Waves:
    """Return the waves along an axis that points at the centres of blocks of cells resolve.

    Parameters
    ----------
    waves
        Waves of unit cells: of all signs along the first axis, without the negative ones along the last.
    length
        Cells along the axis.
    step
        Cells of a block along it.
    axis
        0 or 1.
    """
    if step == 1:
        return waves
    count = length // step
    # Without the wave of half the sampling wave number, which only an even number of blocks has.
    half = (count + 1) // 2
    number = np.arange(half)
    # The block's middle lies half a block behind its first cell's centre; a block stands for a cell (`cell_stress`).
    angle = np.pi * number / length
    with np.errstate(invalid="ignore"):
        ratio = np.where(number > 0, np.sin(angle) / np.sin(step * angle), 1.0 / step)
    factor = (ratio * np.exp(1j * (step - 1) * angle)).astype(waves.dtype)
    shape: list[Any] = list(waves.shape)
    shape[axis] = count // 2 + 1 if axis == 1 else count
    kept = np.zeros(shape, dtype=waves.dtype)
    if axis == 1:
        np.multiply(waves[:, :half], factor, out=kept[:, :half])
    else:
        np.multiply(waves[:half], factor[:, np.newaxis], out=kept[:half])
        np.multiply(waves[1 - half :], factor[:0:-1, np.newaxis].conj(), out=kept[count - half + 1 :])
    return kept


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
    root, angle = _find_lode_angle(values)
    return np.asarray(root * np.sin(angle + math.pi / 3.0))


def maximum_principal(values: RealArray) -> RealArray:
    r"""Return the maximum principal stress of stresses in the order `COMPONENTS`, along the first axis.

    .. math:: \sigma_1 = \tfrac13 \operatorname{tr}\sigma + 2 \sqrt{J_2/3} \cos\theta
    """
    root, angle = _find_lode_angle(values)
    return np.asarray(mean_stress(values) + 2.0 / math.sqrt(3.0) * root * np.cos(angle))


def mean_stress(values: RealArray) -> RealArray:
    """Return the mean of the normal stresses of stresses in the order `COMPONENTS`, along the first axis."""
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
