"""The stiffness of the surface: the pressure that a displacement takes, exactly, on a grid with room for it."""

from __future__ import annotations

from functools import cached_property

import attrs
import numpy as np
import scipy

from roughcontact._base.arrays import RealArray
from roughcontact._parts.grid import Boundary
from roughcontact._parts.interactions import BoundInteraction
from roughcontact._solve.convolvers import (
    ConvolutionSetup,
    InverseConvolution,
    PreparedConvolution,
    list_all_waves,
    mixed_spectrum,
    wrapped_spectrum,
)
from roughcontact.errors import InputError, argument

# Amplitude over the mean one below which a displacement does not determine the pressure.
_SINGULAR = 1e-9
# Support against waves longer than the open cells, over the mean stiffness of a punch of them, and its minimum over the
# stiffness of the longest wave.
_SUPPORT = 0.5
_LONGEST = 0.02


@attrs.frozen(eq=False)
class SurfaceStiffness:
    """The map M from displacement to pressure, by division by the kernel's spectrum.

    On a free boundary it acts on a grid of at least twice the cells along each axis, on which the images of the
    domain do not reach it: there it inverts the free half-space exactly, with a pressure that vanishes outside the
    domain as a condition. Elsewhere it acts on the grid itself.

    Attributes
    ----------
    inverse
        Multiplies waves, of which it has the stiffness, zero for the mean.
    shape
        Cells (nx, ny) of the domain, which is the corner of the extended grid from (0, 0) on.
    mean_compliance
        Displacement by a uniform unit pressure on the extended grid; zero on a periodic boundary, where it is
        arbitrary.
    """

    inverse: InverseConvolution
    shape: tuple[int, int]
    mean_compliance: float

    @property
    def extended(self) -> tuple[int, int]:
        """Cells (mx, my) of the extended grid."""
        return self.inverse.padded

    @property
    def longest(self) -> float:
        """Stiffness of the longest wave, the lowest one."""
        return float(min(axis[1] for axis in self.inverse.axes if axis.size > 1))

    @property
    def shortest(self) -> float:
        """Stiffness of the shortest wave along the axis where that is lower."""
        return float(min(axis[-1] for axis in self.inverse.axes if axis.size > 1))

    def cohesive_cells(self, interaction: BoundInteraction) -> float:
        """Return the cells of the cohesive length of an interaction: the shortest wave of a half-space has pi E*/2."""
        return 2.0 / np.pi * self.shortest / interaction.steepest

    @property
    def mean_stiffness(self) -> float:
        """Uniform pressure of a uniform unit displacement; zero on a periodic boundary, where it is arbitrary."""
        return 1.0 / self.mean_compliance if self.mean_compliance > 0.0 else 0.0

    def symbol(self, mean_stiffness: float, dtype: type) -> RealArray:
        """Return the stiffness of each wave in float32 or float64, with that of the mean."""
        symbol = self.of_precision(dtype).stiffness
        if mean_stiffness:
            symbol = symbol.copy()
            symbol[0, 0] = mean_stiffness
        return symbol

    def precondition(self, symbol: RealArray, punch: float) -> RealArray:
        """Return an approximate inverse of a symbol on some cells, which resist a uniform displacement as a punch.

        Parameters
        ----------
        symbol
            Stiffness of each wave.
        punch
            Mean stiffness of the punch of these cells.
        """
        support = max(_SUPPORT * punch, _LONGEST * self.longest)
        return np.asarray(1.0 / (symbol + symbol.dtype.type(support)))

    @cached_property
    def single(self) -> InverseConvolution:
        """The same with its stiffness in float32."""
        return attrs.evolve(self.inverse, stiffness=self.inverse.stiffness.astype(np.float32))

    def of_precision(self, dtype: type) -> InverseConvolution:
        """Return what multiplies waves in float32 or float64."""
        return self.single if dtype is np.float32 else self.inverse

    @cached_property
    def _response(self) -> RealArray:
        stiffness = self.inverse.stiffness
        response = np.zeros_like(stiffness)
        np.divide(1.0, stiffness, out=response, where=stiffness > 0.0)
        response[0, 0] = self.mean_compliance
        return response

    def displace(self, pressure: RealArray) -> RealArray:
        """Return the displacement by a pressure on the extended grid, in float64."""
        return self.inverse.multiply(pressure, self._response, self.extended)

    def inner(self, field: RealArray) -> RealArray:
        """Return the part of an extended field, or of some rows of it, that lies in the domain, as a view."""
        return field[: self.shape[0], : self.shape[1]]

    def embed(self, values: RealArray) -> RealArray:
        """Return the extended field that has values in the domain and is zero outside."""
        if self.extended == self.shape:
            return values
        field = np.zeros(self.extended, dtype=values.dtype)
        self.inner(field)[:] = values
        return field


def surface_stiffness(convolution: PreparedConvolution, extended: tuple[int, int] | None = None) -> SurfaceStiffness:
    """Return the stiffness that inverts a convolution; on a small grid it is kept for the next states of a path.

    Parameters
    ----------
    convolution
        The convolution.
    extended
        Cells of the extended grid of a free boundary; None: chosen for fast transforms.

    Raises
    ------
    InputError
        If a wave of pressure displaces nothing, or the wrong way, so that the convolution has no inverse.
    """
    setup = convolution.setup
    if extended is None or not setup.boundary.has_free_axis:
        extended = extended_shape(setup.grid.shape, setup.boundary)
    return convolution._keep(("stiffness", extended), lambda: _invert(setup, extended))


def _invert(setup: ConvolutionSetup, extended: tuple[int, int]) -> SurfaceStiffness:
    """Return the stiffness on an extended grid."""
    shape = setup.grid.shape
    if setup.boundary is Boundary.PERIODIC:
        response = setup.spectrum
    elif setup.boundary.mixed:
        response = list_all_waves(mixed_spectrum(setup, extended), extended[0])
    else:
        response = wrapped_spectrum(setup.kernel, extended, setup.grid.spacing)
    mean = float(response[0, 0])
    others = response.ravel()[1:]
    if others.size and not others.min() > _SINGULAR * float(others.mean()):
        raise InputError(
            f"The kernel {setup.kernel.kernel!r} displaces nothing by some waves of pressure, so that a gap does not "
            f"determine the pressure on this grid: {argument('solver', 'majorise')} finds the contact, but without "
            "its stability, "
            "stiffness and gradients."
        )
    stiffness = np.zeros_like(response)
    np.divide(1.0, response, out=stiffness, where=response > 0.0)
    stiffness[0, 0] = 0.0
    return SurfaceStiffness(
        InverseConvolution(stiffness, extended, exact=True), shape, 0.0 if setup.boundary is Boundary.PERIODIC else mean
    )


def extended_shape(shape: tuple[int, int], boundary: Boundary) -> tuple[int, int]:
    """Return at least twice the cells, less one, of free axes, fast to transform and halved as long as the axis is."""
    mx, my = (_extend(n) if free else n for n, free in zip(shape, boundary.free_axes, strict=True))
    return mx, my


def _extend(count: int) -> int:
    if count % 2:
        return int(scipy.fft.next_fast_len(2 * count - 1, real=True))
    return 2 * int(scipy.fft.next_fast_len(count, real=True))
