"""Analytic surfaces: the plane, spheres, paraboloids and waves."""

from __future__ import annotations

from collections.abc import Sequence

import attrs
import numpy as np

from roughcontact._base.checks import Array, Pair, number, pair
from roughcontact._base.machine import require_memory
from roughcontact._base.units import si
from roughcontact._parts.grid import Grid
from roughcontact._parts.surfaces.base import Surface
from roughcontact.errors import InputError


def _center(value: float | Sequence[float]) -> Pair:
    return pair(value, "The centre", "m")


def _radius(value: float) -> float:
    return number(value, "The radius of the sphere", "m", above=0.0)


def _radii(value: float | Sequence[float]) -> Pair:
    return pair(value, "The radius of curvature", "m", above=0.0)


def _amplitude(value: float | Sequence[float]) -> Pair:
    return pair(value, "The amplitude of the wave", "m", at_least=0.0)


def _wavelength(value: float | Sequence[float]) -> Pair:
    return pair(value, "The wavelength", "m", above=0.0)


def _phase(value: float | Sequence[float]) -> Pair:
    return pair(value, "The phase of the wave", "rad")


def _require_memory(grid: Grid, what: str, arrays: int) -> None:
    """Refuse a grid on which the heights, with what they are computed from, do not fit into memory."""
    nx, ny = grid.shape
    require_memory(8.0 * arrays * grid.cells, f"{what} on {nx} x {ny} cells", "choose fewer cells")


@attrs.frozen
class FlatSurface(Surface):
    """A plane: zero everywhere.

    Examples
    --------
    >>> import roughcontact as rc
    >>> print(rc.FlatSurface().heights(rc.Grid((2, 2), 1e-6)).tolist())
    [[0.0, 0.0], [0.0, 0.0]]
    """

    def heights(self, grid: Grid) -> Array:
        """Return zeros, shape `grid.shape`, m."""
        _require_memory(grid, "A plane", 1)
        return np.zeros(grid.shape)


@attrs.frozen
class SphereSurface(Surface):
    """A true sphere, z = sqrt(R^2 - r^2) - R (`ParaboloidSurface` is Hertz's approximation of it).

    Parameters
    ----------
    radius
        Radius R of the sphere, m.
    center
        Position (x, y) of the summit relative to the centre of the domain, m.

    Examples
    --------
    >>> import roughcontact as rc
    >>> ball = rc.SphereSurface(radius=1e-3)
    >>> heights = ball.heights(rc.Grid((3, 3), 30e-6))
    >>> print(f"{1e9 * (heights[1, 1] - heights[0, 1]):.1f} nm")
    50.0 nm
    """

    radius: float = attrs.field(converter=_radius, metadata={"unit": "m"})
    center: Pair = attrs.field(converter=_center, default=(0.0, 0.0), metadata={"unit": "m"})

    @property
    def provenance(self) -> tuple[str, ...]:
        """The radius in words."""
        return (f"a sphere of radius {si(self.radius, 'm')}",)

    def heights(self, grid: Grid) -> Array:
        """Return the heights at the cell centres, shape `grid.shape`, m, zero at the summit."""
        _require_memory(grid, "A sphere", 3)
        x = (grid.x - self.center[0]) / self.radius
        y = (grid.y - self.center[1]) / self.radius
        square = x**2 + y**2
        if square.max() > 1.0:
            raise InputError(
                f"The sphere of radius {self.radius:g} m does not cover the domain of {grid.size[0]:g} m x "
                f"{grid.size[1]:g} m: choose a smaller domain, or a ParaboloidSurface."
            )
        # R - sqrt(R^2 - r^2) cancels near the summit; this form does not.
        return np.asarray(-self.radius * (square / (1.0 + np.sqrt(1.0 - square))), dtype=np.float64)


@attrs.frozen
class ParaboloidSurface(Surface):
    """Paraboloid z = -(x^2 / (2 R1) + y^2 / (2 R2)), the shape of Hertz's theory; elliptic if the radii differ.

    Parameters
    ----------
    radius
        Radii of curvature along x and y, or of both, m.
    center
        Position (x, y) of the summit relative to the centre of the domain, m.

    Examples
    --------
    >>> import roughcontact as rc
    >>> barrel = rc.ParaboloidSurface(radius=(1e-3, 2e-3))
    >>> heights = barrel.heights(rc.Grid((3, 3), 30e-6))
    >>> print(f"{1e9 * (heights[1, 1] - heights[1, 0]):.1f} nm")
    25.0 nm
    """

    radius: Pair = attrs.field(converter=_radii, metadata={"unit": "m"})
    center: Pair = attrs.field(converter=_center, default=(0.0, 0.0), metadata={"unit": "m"})

    def heights(self, grid: Grid) -> Array:
        """Return the heights at the cell centres, shape `grid.shape`, m, zero at the summit."""
        _require_memory(grid, "A paraboloid", 1)
        x = grid.x - self.center[0]
        y = grid.y - self.center[1]
        return np.asarray(-(x * (x / (2 * self.radius[0])) + y * (y / (2 * self.radius[1]))), dtype=np.float64)


@attrs.frozen
class WavySurface(Surface):
    r"""Sum of two crossed cosine waves, one along each axis.

    .. math:: z(x, y) = \Delta_1 \cos(2\pi x/\lambda_1 + \varphi_1)
                      + \Delta_2 \cos(2\pi y/\lambda_2 + \varphi_2)

    with a summit in the centre of the domain when the phases are zero. An amplitude of zero along
    one axis makes a one-dimensional wave.

    Parameters
    ----------
    amplitude
        Amplitude along x and y, or of both, m.
    wavelength
        Wavelength along x and y, or of both, m.
    phase
        Phase along x and y, or of both, rad.

    Examples
    --------
    >>> import roughcontact as rc
    >>> wave = rc.WavySurface(amplitude=1e-6, wavelength=50e-6)
    >>> heights = wave.heights(rc.Grid((64, 64), 100e-6))
    >>> print(f"{1e6 * heights.max():.2f} µm")
    1.99 µm
    """

    amplitude: Pair = attrs.field(converter=_amplitude, metadata={"unit": "m"})
    wavelength: Pair = attrs.field(converter=_wavelength, metadata={"unit": "m"})
    phase: Pair = attrs.field(converter=_phase, default=(0.0, 0.0), metadata={"unit": "rad"})

    def heights(self, grid: Grid) -> Array:
        """Return the heights at the cell centres, shape `grid.shape`, m."""
        _require_memory(grid, "A wave", 1)
        along_x = self.amplitude[0] * np.cos(2 * np.pi * (grid.x / self.wavelength[0]) + self.phase[0])
        along_y = self.amplitude[1] * np.cos(2 * np.pi * (grid.y / self.wavelength[1]) + self.phase[1])
        return np.asarray(along_x + along_y, dtype=np.float64)
