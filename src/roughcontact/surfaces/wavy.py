"""The wavy surface of the paper."""

from __future__ import annotations

from collections.abc import Sequence

import attrs
import numpy as np

from roughcontact.checks import Array, Pair, pair
from roughcontact.grid import Grid
from roughcontact.surfaces.base import Surface


def _amplitude(value: float | Sequence[float]) -> Pair:
    return pair(value, "The amplitude of the wave", "m", at_least=0.0)


def _wavelength(value: float | Sequence[float]) -> Pair:
    return pair(value, "The wavelength", "m", above=0.0)


def _phase(value: float | Sequence[float]) -> Pair:
    return pair(value, "The phase of the wave", "rad")


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
    """

    amplitude: Pair = attrs.field(converter=_amplitude)
    wavelength: Pair = attrs.field(converter=_wavelength)
    phase: Pair = attrs.field(converter=_phase, default=(0.0, 0.0))

    def heights(self, grid: Grid) -> Array:
        """Return the heights at the cell centres, shape `grid.shape`, m."""
        along_x = self.amplitude[0] * np.cos(2 * np.pi * (grid.x / self.wavelength[0]) + self.phase[0])
        along_y = self.amplitude[1] * np.cos(2 * np.pi * (grid.y / self.wavelength[1]) + self.phase[1])
        return np.asarray(along_x + along_y, dtype=np.float64)
