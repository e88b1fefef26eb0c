"""Random self-affine roughness."""

from __future__ import annotations

import math

import attrs
import numpy as np
import numpy.typing as npt
import scipy.fft

from roughcontact.checks import Array, integer, number
from roughcontact.errors import InputError
from roughcontact.grid import Grid
from roughcontact.surfaces.base import Surface

# Waves that meet a limit up to rounding are inside.
_TOUCH = 1e-9


def _hurst(value: float) -> float:
    return number(value, "The Hurst exponent", at_least=0.0, at_most=1.0)


def _wavelength(value: float) -> float:
    return number(value, "A limiting wavelength of the roughness", "m", above=0.0)


def _rms(value: float | None) -> float | None:
    return None if value is None else number(value, "The rms height or slope", above=0.0)


def _peklenik(value: float) -> float:
    return number(value, "Peklenik's number", at_least=1.0)


def _lay(value: float) -> float:
    return number(
        value, "The direction of the lay", "rad, np.deg2rad turns degrees into it", at_least=-math.tau, at_most=math.tau
    )


def _seed(value: int) -> int:
    return integer(value, "The seed", at_least=0)


@attrs.frozen(kw_only=True)
class SelfAffineSurface(Surface):
    r"""Periodic Gaussian roughness with a self-affine power spectrum, isotropic or with a lay.

    The power spectral density is constant from the longest wave to the roll-off, falls as
    q^(-2 - 2 Hurst) to the shortest wave and is zero outside. The waves are drawn in an order that
    does not depend on the grid: the same seed gives the same surface at every resolution.

    With a lay, as grinding leaves it, all lengths along the lay are Peklenik's number times those
    across it: the spectrum depends on :math:`q = \sqrt{q_\perp^2 + \gamma^2 q_\parallel^2}`.

    Parameters
    ----------
    hurst
        Hurst exponent, 0 to 1.
    shortest, longest
        Shortest and longest wavelength, across the lay if there is one, m.
    rms_height, rms_slope
        Exactly one: root mean square of the height, m, or of the gradient's magnitude.
    rolloff
        Wavelength of the roll-off, across the lay, m; the longest wavelength if left out.
    peklenik
        Ratio of the lengths along the lay to those across it, at least 1 (isotropic).
    lay
        Direction of the lay, counter-clockwise from the x axis, rad.
    seed
        Seed of the random numbers.

    References
    ----------
    Jacobs, Junge, Pastewka, Surf. Topogr.: Metrol. Prop. 5 (2017) 013001,
    https://doi.org/10.1088/2051-672X/aa51f8

    Peklenik, Proc. Inst. Mech. Eng. 182(3K) (1967) 108 (the number gamma)
    """

    hurst: float = attrs.field(converter=_hurst)
    shortest: float = attrs.field(converter=_wavelength)
    longest: float = attrs.field(converter=_wavelength)
    rms_height: float | None = attrs.field(converter=_rms, default=None)
    rms_slope: float | None = attrs.field(converter=_rms, default=None)
    rolloff: float = attrs.field(converter=_wavelength, default=attrs.Factory(lambda self: self.longest, True))
    peklenik: float = attrs.field(converter=_peklenik, default=1.0)
    lay: float = attrs.field(converter=_lay, default=0.0)
    seed: int = attrs.field(converter=_seed, default=0)

    def __attrs_post_init__(self) -> None:
        if (self.rms_height is None) == (self.rms_slope is None):
            raise InputError("Give exactly one of rms_height= and rms_slope= for a self-affine surface.")
        if not self.shortest <= self.rolloff <= self.longest:
            raise InputError.about(
                "The roll-off wavelength",
                self.rolloff,
                f"between shortest ({self.shortest:g} m) and longest ({self.longest:g} m)",
            )

    def heights(self, grid: Grid) -> Array:
        """Return the heights at the cell centres, shape `grid.shape`, m, of mean zero.

        Raises
        ------
        InputError
            If the grid cannot carry the shortest wave, or the domain holds no wave at all.
        """
        limit = max(2.0 * step for step in grid.spacing)
        if self.shortest < limit * (1 - _TOUCH):
            raise InputError.about(
                "The shortest wavelength",
                self.shortest,
                f"at least two cells ({limit:g} m) on this grid",
                "Refine the grid or choose a longer wave.",
            )
        kx, ky = (np.arange(-m, m + 1) for m in (int(side / self.shortest * (1 + _TOUCH)) for side in grid.size))
        qx, qy = (
            np.asarray(2 * np.pi * k / side, dtype=np.float64)
            for k, side in ((kx[:, None], grid.size[0]), (ky[None, :], grid.size[1]))
        )
        modes = self._modes(qx, qy)
        # The origin is the centre of the domain; the FFT's is the first cell.
        modes = modes * np.exp(1j * (qx * grid.x[0, 0] + qy * grid.y[0, 0]))
        spectrum = np.zeros(grid.shape, dtype=np.complex128)
        np.add.at(spectrum, np.ix_(kx % grid.shape[0], ky % grid.shape[1]), modes)
        return np.ascontiguousarray(scipy.fft.ifft2(spectrum, norm="forward").real)

    def _modes(self, qx: Array, qy: Array) -> npt.NDArray[np.complex128]:
        """Return the Fourier coefficients of a real surface with the exact rms asked for."""
        cos, sin = math.cos(self.lay), math.sin(self.lay)
        q = np.hypot(self.peklenik * (cos * qx + sin * qy), cos * qy - sin * qx)
        inside = (q * self.longest >= 2 * np.pi * (1 - _TOUCH)) & (q * self.shortest <= 2 * np.pi * (1 + _TOUCH))
        if not inside.any():
            raise InputError("No wave between shortest and longest fits into the domain: enlarge it.")
        flat = np.maximum(q, 2 * np.pi / self.rolloff)
        amplitude = np.where(inside, flat ** (-1.0 - self.hurst), 0.0)
        noise = np.random.default_rng(self.seed).standard_normal((2, *q.shape))
        modes = amplitude / amplitude.max() * (noise[0] + 1j * noise[1])
        modes = modes + np.conj(modes[::-1, ::-1])
        if self.rms_height is not None:
            return np.asarray(modes * (self.rms_height / np.sqrt(np.sum(np.abs(modes) ** 2))))
        slope = np.sqrt(np.sum((np.hypot(qx, qy) * np.abs(modes)) ** 2))
        return np.asarray(modes * (self.rms_slope / slope))
