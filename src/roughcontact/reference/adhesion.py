"""Closed forms of contact with adhesion: a ball and a wave; SI units."""

from __future__ import annotations

import math
from collections.abc import Callable

import attrs
import numpy as np

from roughcontact._base.arrays import Array
from roughcontact._base.checks import number
from roughcontact.errors import InputError
from roughcontact.errors.door import guarded
from roughcontact.reference.closed_forms import Wave, read_length, read_pressure

# Angles arccos(a/c) of Maugis' equations between which states are found: their contact radii span ten decades.
_SMALLEST_ANGLE = 1e-5
_LARGEST_ANGLE = 0.5 * math.pi - 1e-7
# States among which the first bracket of a minimum is found.
_SAMPLES = 2001


def read_work(value: float) -> float:
    """Return the work of adhesion of a closed form, J/m2, above zero."""
    return number(value, "The work of adhesion", "J/m2", above=0.0)


def _minimize(function: Callable[[float], float], places: Array) -> float:
    """Return the place of a minimum of a function, between the neighbours of its lowest sample."""
    # Imported here: most of what imports this module needs no optimizer.
    from scipy import optimize

    values = [function(float(place)) for place in places]
    lowest = min(max(int(np.argmin(values)), 1), len(values) - 2)
    bounds = (float(places[lowest - 1]), float(places[lowest + 1]))
    return float(optimize.minimize_scalar(function, bounds=bounds, method="bounded", options={"xatol": 1e-12}).x)


def _find_root(function: Callable[[float], float], low: float, high: float) -> float:
    from scipy import optimize

    return float(optimize.brentq(function, low, high, xtol=1e-15, rtol=1e-13))


@attrs.frozen
class _AdhesiveBall:
    """A ball on a flat that attract each other.

    Parameters
    ----------
    radius
        Relative radius of curvature R, m.
    modulus
        Contact modulus E*, Pa.
    work
        Work of adhesion w, J/m2.
    """

    radius: float = attrs.field(converter=read_length)
    modulus: float = attrs.field(converter=read_pressure)
    work: float = attrs.field(converter=read_work)


@guarded
@attrs.frozen
class JKR(_AdhesiveBall):
    r"""A soft ball on a flat, of which the attraction has no range: Johnson, Kendall and Roberts.

    .. math:: F = \frac{4 E^* a^3}{3R} - \sqrt{8\pi w E^* a^3}, \quad
              \delta = \frac{a^2}{R} - \sqrt{\frac{2\pi w a}{E^*}}, \quad F_c = -\tfrac32 \pi w R

    Parameters
    ----------
    radius
        Relative radius of curvature R, m.
    modulus
        Contact modulus E*, Pa.
    work
        Work of adhesion w, J/m2.

    References
    ----------
    Johnson, Kendall, Roberts, Proc. R. Soc. Lond. A 324 (1971) 301-313, https://doi.org/10.1098/rspa.1971.0141

    Examples
    --------
    A rubber ball of 10 mm on glass:

    >>> from roughcontact.reference import JKR
    >>> ball = JKR(radius=10e-3, modulus=1e6, work=0.05)
    >>> print(f"{ball.pull_off * 1e3:.3f} mN, {ball.radius_at_zero_load * 1e6:.1f} um")
    -2.356 mN, 413.5 um
    """

    @property
    def pull_off(self) -> float:
        """Minimum of the force, N."""
        return -1.5 * math.pi * self.work * self.radius

    @property
    def radius_at_zero_load(self) -> float:
        """Contact radius without a force, m."""
        return math.cbrt(4.5 * math.pi * self.work * self.radius**2 / self.modulus)

    def contact_radius(self, force: float) -> float:
        """Return the contact radius at a force of at least that of pull-off, m."""
        force = number(force, "The force", "N", at_least=self.pull_off)
        pull = 3.0 * math.pi * self.work * self.radius
        root = math.sqrt(max(pull * (2.0 * force + pull), 0.0))
        return math.cbrt(0.75 * self.radius / self.modulus * (force + pull + root))

    def force(self, contact_radius: float) -> float:
        """Return the force at a contact radius, N."""
        cube = read_length(contact_radius) ** 3
        return 4.0 * self.modulus * cube / (3.0 * self.radius) - math.sqrt(
            8.0 * math.pi * self.work * self.modulus * cube
        )

    def approach(self, contact_radius: float) -> float:
        """Return the approach of distant points at a contact radius, m."""
        a = read_length(contact_radius)
        return a**2 / self.radius - math.sqrt(2.0 * math.pi * self.work * a / self.modulus)


@guarded
@attrs.frozen
class DMT(_AdhesiveBall):
    r"""A stiff ball on a flat, of which the attraction does not deform: Derjaguin, Muller and Toporov.

    .. math:: F = \frac{4 E^* a^3}{3R} - 2\pi w R, \quad \delta = \frac{a^2}{R}, \quad F_c = -2\pi w R

    Parameters
    ----------
    radius
        Relative radius of curvature R, m.
    modulus
        Contact modulus E*, Pa.
    work
        Work of adhesion w, J/m2.

    References
    ----------
    Derjaguin, Muller, Toporov, J. Colloid Interface Sci. 53 (1975) 314-326,
    https://doi.org/10.1016/0021-9797(75)90018-1

    Examples
    --------
    >>> from roughcontact.reference import DMT
    >>> tip = DMT(radius=20e-9, modulus=80e9, work=0.05)
    >>> print(f"{tip.pull_off * 1e9:.2f} nN, {tip.contact_radius(force=0.0) * 1e9:.2f} nm")
    -6.28 nN, 1.06 nm
    """

    @property
    def pull_off(self) -> float:
        """Minimum of the force, N."""
        return -2.0 * math.pi * self.work * self.radius

    def contact_radius(self, force: float) -> float:
        """Return the contact radius at a force of at least that of pull-off, m."""
        force = number(force, "The force", "N", at_least=self.pull_off)
        return math.cbrt(0.75 * self.radius / self.modulus * (force - self.pull_off))

    def force(self, contact_radius: float) -> float:
        """Return the force at a contact radius, N."""
        return 4.0 * self.modulus * read_length(contact_radius) ** 3 / (3.0 * self.radius) + self.pull_off

    def approach(self, contact_radius: float) -> float:
        """Return the approach of distant points at a contact radius, m."""
        return read_length(contact_radius) ** 2 / self.radius


@guarded
@attrs.frozen
class MaugisDugdale(_AdhesiveBall):
    r"""A ball on a flat that attract each other with a constant tension up to the gap w / strength: Maugis.

    The tension acts from the contact radius a to the radius c. With :math:`K = \tfrac43 E^*`,
    :math:`\lambda = 2 s_0 (R/(\pi w K^2))^{1/3}`, :math:`\bar a = a (K/(\pi w R^2))^{1/3}`, m = c/a and
    :math:`\theta = \arccos(1/m)` the gap at c is w over the strength,

    .. math:: \frac{\lambda\bar a^2}{2}\left[(m^2 - 2)\theta + \sqrt{m^2 - 1}\right]
              + \frac{4\lambda^2\bar a}{3}\left[\sqrt{m^2 - 1}\,\theta - m + 1\right] = 1

    and force and approach are

    .. math:: \frac{F}{\pi w R} = \bar a^3 - \lambda\bar a^2\left[\sqrt{m^2 - 1} + m^2\theta\right], \quad
              \delta\left(\frac{K^2}{\pi^2 w^2 R}\right)^{1/3} = \bar a^2 - \tfrac43\lambda\bar a\sqrt{m^2 - 1}

    Parameters
    ----------
    radius
        Relative radius of curvature R, m.
    modulus
        Contact modulus E*, Pa.
    work
        Work of adhesion w, J/m2.
    strength
        The tension s0, Pa.

    References
    ----------
    Maugis, J. Colloid Interface Sci. 150 (1992) 243-269, https://doi.org/10.1016/0021-9797(92)90285-T

    Examples
    --------
    Between the limits of Derjaguin, 2, and of Johnson, 1.5:

    >>> import math
    >>> from roughcontact.reference import MaugisDugdale
    >>> ball = MaugisDugdale(radius=1e-6, modulus=1e9, work=0.05, strength=20e6)
    >>> print(f"lambda {ball.transition:.3f}: {ball.pull_off / (math.pi * 0.05 * 1e-6):.4f} pi w R")
    lambda 0.612: -1.6801 pi w R
    """

    strength: float = attrs.field(converter=read_pressure)

    @property
    def transition(self) -> float:
        """Maugis' parameter lambda: small for stiff balls and long ranges (DMT), large for soft and short (JKR)."""
        return 2.0 * self.strength * math.cbrt(self.radius / (math.pi * self.work * self._stiffness**2))

    @property
    def pull_off(self) -> float:
        """Minimum of the force, N."""
        return self._state(self._pull_off_angle)[1]

    @property
    def radius_at_zero_load(self) -> float:
        """Contact radius without a force, m."""
        return self.contact_radius(0.0)

    def contact_radius(self, force: float) -> float:
        """Return the contact radius at a force of at least that of pull-off, m."""
        force = number(force, "The force", "N", at_least=self.pull_off)
        angle = _find_root(lambda place: self._state(place)[1] - force, _SMALLEST_ANGLE, self._pull_off_angle)
        return self._state(angle)[0]

    def force(self, contact_radius: float) -> float:
        """Return the force at a contact radius, N."""
        return self._state(self._angle(contact_radius))[1]

    def approach(self, contact_radius: float) -> float:
        """Return the approach of distant points at a contact radius, m."""
        return self._state(self._angle(contact_radius))[2]

    def tension_radius(self, contact_radius: float) -> float:
        """Return the radius c up to which the tension acts, at a contact radius, m."""
        return contact_radius / math.cos(self._angle(contact_radius))

    @property
    def _stiffness(self) -> float:
        return 4.0 / 3.0 * self.modulus

    @property
    def _pull_off_angle(self) -> float:
        tangents = np.geomspace(1e-4, math.tan(_LARGEST_ANGLE), _SAMPLES)
        return _minimize(lambda place: self._state(place)[1], np.arctan(tangents))

    def _angle(self, contact_radius: float) -> float:
        a = read_length(contact_radius)
        low = self._state(_LARGEST_ANGLE)[0]
        high = self._state(_SMALLEST_ANGLE)[0]
        if not low < a < high:
            raise InputError.about("The contact radius", contact_radius, f"between {low:g} and {high:g} m")
        return _find_root(lambda place: self._state(place)[0] / a - 1.0, _SMALLEST_ANGLE, _LARGEST_ANGLE)

    def _state(self, angle: float) -> tuple[float, float, float]:
        """Return the contact radius, m, the force, N, and the approach, m, at the angle arccos(a/c)."""
        ratio = 1.0 / math.cos(angle)
        tangent = math.tan(angle)
        transition = self.transition
        square = 0.5 * transition * ((ratio**2 - 2.0) * angle + tangent)
        linear = 4.0 / 3.0 * transition**2 * (tangent * angle - (ratio - 1.0))
        # The root of square a^2 + linear a = 1 without cancellation.
        a = 2.0 / (linear + math.sqrt(linear**2 + 4.0 * square))
        force = a**3 - transition * a**2 * (tangent + ratio**2 * angle)
        approach = a**2 - 4.0 / 3.0 * transition * a * tangent
        pull = math.pi * self.work * self.radius
        length = math.cbrt(pull * self.radius / self._stiffness)
        return a * length, force * pull, approach * length**2 / self.radius


@guarded
@attrs.frozen
class JohnsonWave(Wave):
    r"""A flat on the wave z = amplitude cos(2 pi x / wavelength), with an attraction without a range: Johnson.

    With half the width a of a contact strip, :math:`p^* = \pi E^* A/L` and
    :math:`\alpha^2 = 2wL/(\pi^2 E^* A^2)` the mean pressure is

    .. math:: \frac{p}{p^*} = \sin^2\frac{\pi a}{L} - \alpha\sqrt{\tan\frac{\pi a}{L}}

    Parameters
    ----------
    amplitude, wavelength
        Amplitude A and length L of the wave, m.
    modulus
        Contact modulus E*, Pa.
    work
        Work of adhesion w, J/m2.

    References
    ----------
    Johnson, Int. J. Solids Struct. 32 (1995) 423-430, https://doi.org/10.1016/0020-7683(94)00111-9

    Examples
    --------
    >>> from roughcontact.reference import JohnsonWave
    >>> wave = JohnsonWave(amplitude=1e-6, wavelength=1e-4, modulus=1e6, work=2e-3)
    >>> print(f"alpha {wave.alpha:.3f}, pull-off at {wave.pull_off / wave.full_contact_pressure:.4f} p*")
    alpha 0.201, pull-off at -0.0561 p*
    """

    work: float = attrs.field(converter=read_work)

    @property
    def alpha(self) -> float:
        """Root of the work of adhesion over the elastic energy of full contact, times 2/pi."""
        energy = math.pi**2 * self.modulus * self.amplitude**2
        return math.sqrt(2.0 * self.work * self.wavelength / energy)

    @property
    def pull_off(self) -> float:
        """Minimum of the mean pressure, Pa, of a contact that is not full."""
        return self.mean_pressure(self._folds[0])

    @property
    def pressure_of_full_contact(self) -> float:
        """Mean pressure from which the strips spread to full contact, Pa; negative: they do so without a load."""
        return self.mean_pressure(self._folds[1])

    def mean_pressure(self, half_width: float) -> float:
        """Return the mean pressure at half the width of a strip, between zero and half a wavelength, Pa."""
        a = number(half_width, "Half the width of a strip", "m", above=0.0, at_most=0.5 * self.wavelength)
        angle = math.pi * a / self.wavelength
        return self.full_contact_pressure * (math.sin(angle) ** 2 - self.alpha * math.sqrt(math.tan(angle)))

    def half_width(self, mean_pressure: float) -> float:
        """Return half the width of a strip at a mean pressure, m: the stable one."""
        low, high = self._folds
        pressure = number(
            mean_pressure, "The mean pressure", "Pa", at_least=self.pull_off, at_most=self.pressure_of_full_contact
        )
        return _find_root(lambda place: self.mean_pressure(place) - pressure, low, high)

    @property
    def _folds(self) -> tuple[float, float]:
        """Half widths between which a strip is stable, m."""
        places = np.linspace(0.0, 0.5, _SAMPLES)[1:-1]
        rising = np.diff([self.mean_pressure(place * self.wavelength) for place in places]) > 0.0
        if not rising.any():
            raise InputError(f"At alpha = {self.alpha:.3g} no strip is stable: the contact is full, or there is none.")
        stable = places[:-1][rising]
        low = self._fold(stable[0], 1.0)
        return low, self._fold(stable[-1], -1.0)

    def _fold(self, place: float, sign: float) -> float:
        around = place + np.linspace(-2.0, 2.0, 9) / _SAMPLES
        around = self.wavelength * around[(around > 0.0) & (around < 0.5)]
        return _minimize(lambda half: sign * self.mean_pressure(half), around)
