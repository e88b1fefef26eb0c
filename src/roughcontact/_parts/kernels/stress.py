"""What a kernel of one body may know beside the displacement by pressure: the stress below, conduction, shear."""

from __future__ import annotations

import math
from typing import Any, Protocol, runtime_checkable

import attrs
import numpy as np

from roughcontact._base.arrays import Array, Pair, RealArray
from roughcontact._base.checks import returned_array
from roughcontact._parts.kernels.base import InfluenceKernel, is_at_nyquist, odd_axes
from roughcontact._parts.kernels.half_space import Love
from roughcontact._parts.kernels.mixed import set_octaves, sum_rest
from roughcontact._parts.kernels.stress_cells import STRESS_COMPONENTS, cell_stress, wave_stress
from roughcontact._parts.materials import Material, PairConstants
from roughcontact.errors import InputError

# Square of the depth over the area of a cell above which the corners of a cell cancel too much for float32.
_MAX_FLOAT32_DEPTH_SQUARE = 256.0
# Distance to the nearest image along a free axis, in wavelengths and depths: the stress falls by exp(-2 pi) on each
# wavelength, and is wanted in float32.
_IMAGE_WAVELENGTHS = 3.0
# Length of a strip, in the longest distance from it, that stands for one without ends.
_STRIP_LENGTH = 1e8


@runtime_checkable
class SupportsStress(Protocol):
    """A kernel of one body that knows the stress below its surface: an optional ability.

    Its components are xx, yy, zz, yz, xz, xy by a load ``"z"``, a pressure, or ``"x"`` or ``"y"``, a traction along
    this axis. Tension is positive, and z points into the body. A component is odd in x, or in y, if its name and that
    of the load together have the letter an odd number of times. The precision of float32 is enough.

    Attributes
    ----------
    interfaces
        Depths of the interfaces of layers, shape (n,), m, ascending: there the stress along the surface jumps.
    base_depth
        Depth of a rigid base, at which the stress ends, m; infinite on a half-space.

    A kernel with ``yield_stresses``, one or None for each layer, has the first yield of each by its own strength.
    """

    @property
    def interfaces(self) -> Array: ...

    @property
    def base_depth(self) -> float: ...

    def describes(self, material: Material) -> bool:
        """Return whether a body of this material is the one with the layers."""

    def poisson_at(self, depth: float) -> float:
        """Return Poisson's ratio at a depth, m; at an interface the one above."""

    def stress_coefficients(self, load: str, shape: tuple[int, int], spacing: Pair, depth: float) -> RealArray:
        """Return the stress at offsets from a cell with unit load.

        Parameters
        ----------
        load
            The letter of the load.
        shape, spacing
            As for `SupportsCoefficients.coefficients`.
        depth
            Depth, m, at least zero.

        Returns
        -------
        RealArray
            Shape (6, nx, ny), float32 or float64; zero at offset zero along an axis in which the component is odd.
        """

    def stress_spectrum(self, load: str, qx: Array, qy: Array, spacing: Pair, depth: float) -> RealArray:
        """Return the stress by a wave of unit load.

        Parameters
        ----------
        load, depth
            As for `stress_coefficients`.
        qx, qy, spacing
            As for `SupportsSpectrum.spectrum`; at qx = qy = 0 the stress by a uniform load on a body without ends.

        Returns
        -------
        RealArray
            Amplitudes at the centres of the cells, shape (6, m, n), float32 or float64, of components that are odd in
            one axis their imaginary parts.
        """


@attrs.frozen
class HalfSpaceStress:
    """The stress below the surface of a homogeneous half-space, by Love's and Cerruti's solutions; `SupportsStress`.

    Attributes
    ----------
    poisson
        Poisson's ratio.

    Examples
    --------
    Below the middle of a square cell under unit pressure, at a depth of its side:

    >>> import roughcontact as rc
    >>> stress = rc.typing.HalfSpaceStress(0.3).stress_coefficients("z", (1, 1), (1e-6, 1e-6), 1e-6)
    >>> print(f"{stress[2].item():.4f}")
    -0.3361
    """

    poisson: float

    @property
    def interfaces(self) -> Array:
        """No depths."""
        return np.empty(0)

    @property
    def base_depth(self) -> float:
        """Infinite."""
        return math.inf

    def describes(self, material: Material) -> bool:
        """Return whether a material has this Poisson's ratio."""
        return getattr(material, "poisson", None) == self.poisson

    def poisson_at(self, depth: float) -> float:
        """Return Poisson's ratio."""
        return self.poisson

    def stress_coefficients(self, load: str, shape: tuple[int, int], spacing: Pair, depth: float) -> RealArray:
        """Return the stress at offsets from a cell with unit load; see `SupportsStress`."""
        dtype = np.float64 if depth * depth > _MAX_FLOAT32_DEPTH_SQUARE * spacing[0] * spacing[1] else np.float32
        return cell_stress(depth / spacing[0], self.poisson, shape, (1.0, spacing[1] / spacing[0]), dtype, load)

    def stress_spectrum(self, load: str, qx: Array, qy: Array, spacing: Pair, depth: float) -> RealArray:
        """Return the stress by a wave of unit load; see `SupportsStress`."""
        phases = qx[:, 0] * spacing[0], qy[0] * spacing[1]
        return wave_stress(phases, (1.0, spacing[1] / spacing[0]), depth / spacing[0], self.poisson, load)


@attrs.frozen
class BoundStress:
    """The stress that a kernel states for one body, finite, float32; `InputError` otherwise."""

    kernel: SupportsStress

    def coefficients(self, load: str, shape: tuple[int, int], spacing: Pair, depth: float) -> RealArray:
        """Return the stress at offsets from a cell, shape (6, nx, ny); see `SupportsStress.stress_coefficients`."""
        return self._check(self.kernel.stress_coefficients(load, shape, spacing, depth), shape)

    def spectrum(self, load: str, qx: Array, qy: Array, spacing: Pair, depth: float) -> RealArray:
        """Return the stress by waves, shape (6, m, n); see `SupportsStress.stress_spectrum`.

        Components that are odd along an axis are zero at half the sampling wave number there.
        """
        stress = self._check(self.kernel.stress_spectrum(load, qx, qy, spacing, depth), (qx.shape[0], qy.shape[1]))
        for component, one in zip(STRESS_COMPONENTS, stress, strict=True):
            odd_in_x, odd_in_y = odd_axes(component + load)
            if odd_in_x:
                one[is_at_nyquist(qx[:, 0], spacing[0])] = 0.0
            if odd_in_y:
                one[:, is_at_nyquist(qy[0], spacing[1])] = 0.0
        return stress

    def mixed_coefficients(
        self, load: str, cells: int, waves: Array, spacing: Pair, depth: float, free: int
    ) -> RealArray:
        """Return the stress at offsets along a free axis by the waves along the periodic one.

        The stress by the mean along it is that of strips in plane strain.

        Parameters
        ----------
        load, spacing, depth
            As for `SupportsStress.stress_coefficients`.
        cells
            Number of offsets.
        waves
            Wave numbers along the periodic axis, ascending from zero, shape (n,), rad/m.
        free
            The free axis, 0 or 1.

        Returns
        -------
        RealArray
            Shape (6, cells, n), or (6, n, cells) if y is the free axis.
        """
        odd = [odd_axes(component + load)[free] for component in STRESS_COMPONENTS]
        step = spacing[free]

        def find_amplitudes(along: Array, across: Array) -> RealArray:
            if free == 0:
                return self.spectrum(load, along, across, spacing, depth)
            return self.spectrum(load, across.T, along.T, spacing, depth).transpose(0, 2, 1)

        half_space = HalfSpaceStress(self.kernel.poisson_at(depth))

        def find_rest(along: Array) -> RealArray:
            none = np.zeros((1, 1))
            qx, qy = (along, none) if free == 0 else (none, along.T)
            known = half_space.stress_spectrum(load, qx, qy, spacing, depth)
            return (self.kernel.stress_spectrum(load, qx, qy, spacing, depth) - known).reshape(len(odd), -1)

        result = np.empty((len(odd), cells, waves.size))
        length = _STRIP_LENGTH * (2.0 * cells + depth / step)
        shape, sides = ((cells, 1), (1.0, length)) if free == 0 else ((1, cells), (length, 1.0))
        strip = cell_stress(depth / step, half_space.poisson, shape, sides, np.float64, load)
        result[:, :, 0] = strip.reshape(len(odd), cells)
        if self.kernel != half_space:
            result[:, :, 0] += sum_rest(find_rest, cells, step, odd)
        set_octaves(
            result, find_amplitudes, waves, step, odd, _IMAGE_WAVELENGTHS, beyond=depth, part=slice(0, waves.size)
        )
        return result if free == 0 else result.transpose(0, 2, 1)

    def _check(self, given: Any, shape: tuple[int, int]) -> RealArray:
        whole = len(STRESS_COMPONENTS), *shape
        stress = np.require(returned_array(given, whole, f"The kernel {self.kernel!r}", "stresses"), np.float32, "W")
        if not math.isfinite(float(stress.sum())):
            raise InputError(f"The kernel {self.kernel!r} returned stresses that are not finite.")
        return stress


def has_layers(kernel: Any, body: str, material: Material) -> bool:
    """Return whether the layers of a kernel may lie on the ``"body"`` or the ``"counterbody"``, of this material."""
    part = kernel.part_of(body)
    return not isinstance(part, Love) and (kernel if part is None else part).describes(material)


@runtime_checkable
class SupportsConduction(Protocol):
    """A kernel of a body of layers that knows how they conduct heat or current: an optional ability."""

    def describes(self, material: Material) -> bool:
        """Return whether a body of this material is the one with the layers."""

    def conduction_kernel(self, conductivity: float) -> InfluenceKernel:
        """Return the kernel of temperature, or potential, by the flow through the surface.

        Parameters
        ----------
        conductivity
            Of the half-space under the layers, W/(m K) for heat or S/m for current.

        Returns
        -------
        InfluenceKernel
            A kernel whose `compliance` is (1/k1 + 1/k2) / 2 of the half-spaces under the layers, and whose values are
            temperatures by flows, K/(W/m2).

        Raises
        ------
        InputError
            If the conductivity of a layer is not known.
        """


@runtime_checkable
class SupportsTangential(Protocol):
    """A kernel of a body of layers that knows the displacement along an axis by shear along it: an optional ability.

    The tangential stiffness needs it. In both methods `pair` has the constants of the half-spaces under the layers.
    """

    def describes(self, material: Material) -> bool:
        """Return whether a body of this material is the one with the layers."""

    def shear_kernel(self, axis: int, pair: PairConstants) -> InfluenceKernel:
        """Return the kernel of the displacement along x, 0, or y, 1, by shear along it, of the same compliance."""

    def coupling(self, wavenumber: Array, compliance: float, pair: PairConstants) -> Array:
        """Return Dundurs' beta of waves.

        Parameters
        ----------
        wavenumber
            Wave numbers, shape (n,), rad/m, above zero.
        compliance
            1/E* of the half-spaces under the layers, 1/Pa.
        pair
            Their constants, with the body with the layers first.
        """
