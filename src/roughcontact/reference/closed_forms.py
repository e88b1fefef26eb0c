"""Closed forms of contact mechanics, for two elastic half-spaces; SI units."""

from __future__ import annotations

import math

import attrs
import numpy as np
import scipy

from roughcontact._base.arrays import Array, Pair
from roughcontact._base.checks import number, pair
from roughcontact.errors import InputError
from roughcontact.errors.door import guarded

# Maximum ratio of two radii: the ellipse of contact is too slender beyond.
_MAX_RADIUS_RATIO = 1e24


def read_length(value: float) -> float:
    """Return a length of a closed form, m, above zero."""
    return number(value, "A length of a closed form", "m", above=0.0)


def read_pressure(value: float) -> float:
    """Return a pressure or a modulus of a closed form, Pa, above zero."""
    return number(value, "A pressure of a closed form", "Pa", above=0.0)


def read_force(value: float) -> float:
    """Return a normal force of a closed form, N, above zero."""
    return number(value, "The normal force", "N", above=0.0)


@guarded
@attrs.frozen
class Hertz:
    """Contact of two paraboloids.

    Attributes
    ----------
    semi_axes
        Semi-axes of the contact ellipse along x and y, m.
    p_max
        Maximum pressure, Pa.
    approach
        Approach of distant points, m.

    Examples
    --------
    >>> import numpy as np
    >>> from roughcontact.reference import hertz_sphere
    >>> ball = hertz_sphere(force="10N", radius="5mm", modulus="115.4GPa")
    >>> print(f"{1e6 * ball.area:.4f} mm2")
    0.0148 mm2
    >>> print(ball.pressure(np.array([0.0, 0.5, 1.0, 2.0]) * ball.semi_axes[0], 0.0).round(-6))
    [1.01e+09 8.75e+08 0.00e+00 0.00e+00]
    """

    semi_axes: Pair
    p_max: float
    approach: float

    @property
    def area(self) -> float:
        """Contact area, m2."""
        return math.pi * self.semi_axes[0] * self.semi_axes[1]

    def pressure(self, x: Array, y: Array) -> Array:
        """Return the pressure at broadcastable positions x, y from the centre, m; Pa."""
        inside = 1.0 - (x / self.semi_axes[0]) ** 2 - (y / self.semi_axes[1]) ** 2
        return np.asarray(self.p_max * np.sqrt(np.maximum(inside, 0.0)), dtype=np.float64)


@guarded
def hertz_sphere(force: float, radius: float, modulus: float) -> Hertz:
    r"""Return Hertz's solution for a sphere on a flat.

    .. math:: a^3 = \frac{3FR}{4E^*}, \quad \delta = \frac{a^2}{R}, \quad p_0 = \frac{3F}{2\pi a^2}

    Parameters
    ----------
    force, modulus
        Normal force, N, and contact modulus E*, Pa.
    radius
        Relative radius of curvature, m.

    References
    ----------
    Johnson, Contact Mechanics (1985), sec. 4.2, https://doi.org/10.1017/CBO9781139171731

    Examples
    --------
    A steel ball of 5 mm on a steel flat, at 10 N:

    >>> from roughcontact.reference import hertz_sphere
    >>> ball = hertz_sphere(force=10.0, radius=5e-3, modulus=115.4e9)
    >>> print(f"{1e6 * ball.semi_axes[0]:.1f} um, {1e-9 * ball.p_max:.2f} GPa, {1e6 * ball.approach:.2f} um")
    68.8 um, 1.01 GPa, 0.95 um
    """
    force = read_force(force)
    radius = read_length(radius)
    modulus = read_pressure(modulus)
    a = (0.75 * force * radius / modulus) ** (1 / 3)
    return Hertz((a, a), 1.5 * force / (math.pi * a**2), a**2 / radius)


@guarded
def hertz_elliptic(force: float, radii: Pair, modulus: float) -> Hertz:
    r"""Return Hertz's solution for a paraboloid with two principal radii, along x and y.

    With e the eccentricity of the ellipse, b = a sqrt(1 - e^2) its minor semi-axis and K, E the
    complete elliptic integrals of e,

    .. math:: \frac{1}{2R'} = \frac{p_0}{E^*}\frac{b}{e^2 a^2}(K - E), \quad
              \frac{1}{2R''} = \frac{p_0}{E^*}\frac{b}{e^2 a^2}\left(\frac{a^2}{b^2}E - K\right), \quad
              \delta = \frac{p_0}{E^*} b K

    Parameters
    ----------
    force, modulus
        Normal force, N, and contact modulus E*, Pa.
    radii
        Relative radii of curvature along x and y, m.

    References
    ----------
    Johnson, Contact Mechanics (1985), eq. 4.24 to 4.26, https://doi.org/10.1017/CBO9781139171731

    Examples
    --------
    A barrel of 5 and 20 mm on a flat, of steel, at 10 N:

    >>> from roughcontact.reference import hertz_elliptic
    >>> barrel = hertz_elliptic(force=10.0, radii=(5e-3, 20e-3), modulus=115.4e9)
    >>> print(*(f"{1e6 * axis:.1f} um" for axis in barrel.semi_axes))
    53.4 um 133.5 um
    """
    # Imported here, because most uses of this package need no optimizer.
    from scipy import optimize

    force = read_force(force)
    modulus = read_pressure(modulus)
    radii = pair(radii, "The radii", "m", above=0.0)
    blunt = max(radii)
    sharp = min(radii)
    if blunt == sharp:
        return hertz_sphere(force, blunt, modulus)
    if blunt > _MAX_RADIUS_RATIO * sharp:
        raise InputError(
            f"The radii {radii} differ by more than {_MAX_RADIUS_RATIO:g} times: take a contact of cylinders."
        )

    def mismatch(log_ratio: float) -> float:
        shallow, steep = _curvature_integrals(math.exp(log_ratio))
        return float(math.log(steep / shallow) - math.log(blunt / sharp))

    ratio = math.exp(float(optimize.brentq(mismatch, math.log(1e-15), 0.0, xtol=1e-15, rtol=1e-14)))
    shallow, _ = _curvature_integrals(ratio)
    # From 1/(2 R') with p0 = 3F / (2 pi a b).
    a = (3.0 * force * blunt * shallow / (math.pi * modulus)) ** (1 / 3)
    b = a * ratio
    p_max = 1.5 * force / (math.pi * a * b)
    axes = (a, b) if radii[0] >= radii[1] else (b, a)
    return Hertz(axes, p_max, p_max * b * float(scipy.special.ellipkm1(ratio**2)) / modulus)


@attrs.frozen
class Wave:
    """A flat on the wave z = amplitude cos(2 pi x / wavelength).

    Parameters
    ----------
    amplitude, wavelength
        Amplitude and length of the wave, m.
    modulus
        Contact modulus E*, Pa.
    """

    amplitude: float = attrs.field(converter=read_length)
    wavelength: float = attrs.field(converter=read_length)
    modulus: float = attrs.field(converter=read_pressure)

    @property
    def full_contact_pressure(self) -> float:
        """Mean pressure p* = pi E* amplitude / wavelength at which the last gap closes, Pa."""
        return math.pi * self.modulus * self.amplitude / self.wavelength


@guarded
@attrs.frozen
class WavyContact(Wave):
    r"""Contact of a flat with the wave z = amplitude (cos(2 pi x / wavelength) + cos(2 pi y / wavelength)).

    Parameters
    ----------
    amplitude, wavelength
        Amplitude of each of the two waves and their common length, m.
    modulus
        Contact modulus E*, Pa.

    References
    ----------
    Johnson, Greenwood, Higginson, Int. J. Mech. Sci. 27 (1985) 383-396,
    https://doi.org/10.1016/0020-7403(85)90029-3

    Examples
    --------
    >>> from roughcontact.reference import WavyContact
    >>> wave = WavyContact(amplitude="1um", wavelength="100um", modulus="200GPa")
    >>> print(f"full at {1e-9 * wave.full_contact_pressure:.2f} GPa, {100 * wave.light_area_fraction('100MPa'):.1f} %")
    full at 12.57 GPa, 3.0 %
    """

    @property
    def full_contact_pressure(self) -> float:
        """Mean pressure p* = 2 pi E* amplitude / wavelength at which the last gap closes, Pa."""
        return 2.0 * math.pi * self.modulus * self.amplitude / self.wavelength

    def light_area_fraction(self, mean_pressure: float) -> float:
        """Return the contact area over the nominal area in the limit of light load (the paper's eq. 27)."""
        mean_pressure = number(mean_pressure, "The mean pressure", "Pa", at_least=0.0)
        return math.pi * math.pow(3.0 * mean_pressure / (8.0 * math.pi * self.full_contact_pressure), 2 / 3)

    def light_p_max(self, mean_pressure: float) -> float:
        """Return the maximum pressure in the limit of light load, Pa (the paper's eq. 26)."""
        return 1.5 * mean_pressure / self.light_area_fraction(mean_pressure)

    def heavy_area_fraction(self, mean_pressure: float) -> float:
        """Return the contact area over the nominal area in the limit of nearly full contact."""
        return 1.0 - 1.5 / math.pi * (1.0 - mean_pressure / self.full_contact_pressure)

    def full_contact(self, x: Array, y: Array, mean_pressure: float) -> Array:
        """Return the pressure in full contact at broadcastable x, y, Pa, for a mean of at least p*."""
        phase_x, phase_y = (2 * np.pi * t / self.wavelength for t in (x, y))
        return np.asarray(mean_pressure + 0.5 * self.full_contact_pressure * (np.cos(phase_x) + np.cos(phase_y)))


@guarded
@attrs.frozen
class Westergaard(Wave):
    """Contact of a flat with the one-dimensional wave z = amplitude cos(2 pi x / wavelength); see `WavyContact`.

    References
    ----------
    Westergaard, J. Appl. Mech. 6 (1939) A49-A53, https://doi.org/10.1115/1.4008919;
    Johnson, Contact Mechanics (1985), sec. 13.2, https://doi.org/10.1017/CBO9781139171731

    Examples
    --------
    >>> from roughcontact.reference import Westergaard
    >>> wave = Westergaard(amplitude=1e-6, wavelength=100e-6, modulus=200e9)
    >>> print(f"{wave.full_contact_pressure / 1e9:.2f} GPa, {2e6 * wave.half_width(1e9):.1f} um in contact at 1 GPa")
    6.28 GPa, 26.1 um in contact at 1 GPa
    """

    def half_width(self, mean_pressure: float) -> float:
        """Return half the width of a contact strip, m."""
        mean_pressure = number(mean_pressure, "The mean pressure", "Pa", above=0.0, at_most=self.full_contact_pressure)
        return self.wavelength / math.pi * math.asin(math.sqrt(mean_pressure / self.full_contact_pressure))

    def pressure(self, x: Array, mean_pressure: float) -> Array:
        """Return the pressure at distances x from a crest, Pa, for a mean of at most p*."""
        edge = math.sin(math.pi * self.half_width(mean_pressure) / self.wavelength) ** 2
        place = np.pi * np.asarray(x) / self.wavelength
        inside = np.sqrt(np.maximum(edge - np.sin(place) ** 2, 0.0))
        return np.asarray(2.0 * mean_pressure * np.abs(np.cos(place)) / edge * inside, dtype=np.float64)


@guarded
@attrs.frozen
class FlatPunch:
    r"""Rigid flat circular punch.

    .. math:: \delta = \frac{F}{2 E^* a}, \quad p(r) = \frac{F}{2\pi a^2}\left(1 - r^2/a^2\right)^{-1/2}

    Parameters
    ----------
    force, modulus
        Normal force, N, and contact modulus E*, Pa.
    radius
        Radius a of the punch, m.

    References
    ----------
    Johnson, Contact Mechanics (1985), sec. 3.4, https://doi.org/10.1017/CBO9781139171731

    Examples
    --------
    >>> from roughcontact.reference import FlatPunch
    >>> print(f"{1e9 * FlatPunch(force=10.0, radius=100e-6, modulus=115.4e9).approach:.0f} nm")
    433 nm
    """

    force: float = attrs.field(converter=read_force)
    radius: float = attrs.field(converter=read_length)
    modulus: float = attrs.field(converter=read_pressure)

    @property
    def approach(self) -> float:
        """Depth of the indentation, m."""
        return self.force / (2.0 * self.modulus * self.radius)

    def pressure(self, r: Array) -> Array:
        """Return the pressure at distances r from the axis, Pa; zero from the edge on."""
        mean = self.force / (math.pi * self.radius**2)
        inside = np.maximum(1.0 - (np.asarray(r) / self.radius) ** 2, 0.0)
        return np.where(inside > 0.0, 0.5 * mean / np.sqrt(np.where(inside > 0.0, inside, 1.0)), 0.0)


def _curvature_integrals(ratio: float) -> tuple[float, float]:
    """Return (K - E)/e^2 and (E/ratio^2 - K)/e^2 of the ellipse b/a = ratio, in Carlson's form without cancellation."""
    square = ratio**2
    return float(scipy.special.elliprd(0.0, square, 1.0)) / 3.0, float(scipy.special.elliprd(0.0, 1.0, square)) / 3.0
