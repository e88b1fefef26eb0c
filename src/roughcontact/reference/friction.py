"""Closed forms of contact with friction: like and unlike half-spaces; SI units.

Two half-spaces are the contact modulus E*, Dundurs' constant beta and gamma: see `PairConstants`. The tangential over
the normal compliance of a round contact is 1 + gamma/2, and (2 - nu)/(2 - 2 nu) if both have Poisson's ratio nu.
"""

from __future__ import annotations

import math

import attrs
import numpy as np
import scipy

from roughcontact._base.arrays import Array
from roughcontact._base.checks import number
from roughcontact.errors import InputError
from roughcontact.errors.door import guarded
from roughcontact.reference.closed_forms import Wave, read_force, read_length, read_pressure

# Series of atanh(x)/x below this x: the quotient loses its digits there.
_SMALL_BETA = 1e-4
# Maximum of log(c/(1 - c)), of which the square of c is a number of float64.
_LARGEST_LOGIT = 300.0


def _friction(value: float) -> float:
    return number(value, "The coefficient of friction", above=0.0)


def _ratio(value: float) -> float:
    return number(value, "The tangential over the normal compliance", above=0.0)


def _beta(value: float) -> float:
    return number(value, "Dundurs' beta", above=-1.0, at_most=1.0)


@guarded
@attrs.frozen
class CattaneoMindlin:
    r"""A ball of like material under a normal force P and a tangential force Q: Cattaneo and Mindlin.

    .. math:: c = a\,(1 - Q/\mu P)^{1/3}, \quad \delta_x = \frac{\mu\kappa}{R}(a^2 - c^2), \quad
              a^3 = \frac{3 P R}{4 E^*}

    with the tangential over the normal compliance :math:`\kappa`. The traction is taken to be parallel to Q, which is
    exact if Poisson's ratio is zero.

    Parameters
    ----------
    force
        Normal force P, N, constant.
    radius
        Relative radius of curvature R, m.
    modulus
        Contact modulus E*, Pa.
    friction
        Coefficient of friction.
    compliance_ratio
        Tangential over normal compliance: (2 - nu)/(2 - 2 nu).

    References
    ----------
    Johnson, Contact Mechanics (1985), section 7.2 and 7.4, https://doi.org/10.1017/CBO9781139171731

    Examples
    --------
    >>> from roughcontact.reference import CattaneoMindlin
    >>> ball = CattaneoMindlin(force=1.0, radius=1e-2, modulus=100e9, friction=0.3, compliance_ratio=1.0)
    >>> print(f"{ball.stick_radius(0.15) / ball.contact_radius:.4f}, {ball.displacement(0.15) * 1e9:.3f} nm")
    0.7937, 19.743 nm
    """

    force: float = attrs.field(converter=read_force)
    radius: float = attrs.field(converter=read_length)
    modulus: float = attrs.field(converter=read_pressure)
    friction: float = attrs.field(converter=_friction)
    compliance_ratio: float = attrs.field(converter=_ratio)

    @property
    def contact_radius(self) -> float:
        """Radius of the contact a, m."""
        return math.cbrt(0.75 * self.force * self.radius / self.modulus)

    @property
    def sliding_force(self) -> float:
        """Tangential force at which the ball slides, N."""
        return self.friction * self.force

    def stick_radius(self, tangential_force: float) -> float:
        """Return the radius of the zone that sticks at first loading, m."""
        return self.contact_radius * math.cbrt(1.0 - self._part(tangential_force))

    def displacement(self, tangential_force: float) -> float:
        """Return the tangential displacement of distant points at first loading, m."""
        depth = self.contact_radius**2 / self.radius
        stuck = float((1.0 - self._part(tangential_force)) ** (2 / 3))
        return self.friction * self.compliance_ratio * depth * (1.0 - stuck)

    def traction(self, distance: Array, tangential_force: float) -> Array:
        """Return the traction at distances from the centre, m, at first loading; Pa."""
        peak = self.friction * 1.5 * self.force / (math.pi * self.contact_radius**2)
        c = self.stick_radius(tangential_force)
        whole = np.sqrt(np.maximum(1.0 - (distance / self.contact_radius) ** 2, 0.0))
        inner = np.sqrt(np.maximum(c**2 - distance**2, 0.0)) / self.contact_radius
        return np.asarray(peak * (whole - inner), dtype=np.float64)

    def displacement_in_cycle(self, tangential_force: float, amplitude: float) -> float:
        r"""Return the displacement on the way back from an amplitude Q* of the force, m (Masing).

        .. math:: \delta = \delta(Q^*) - 2\,\delta\!\left(\tfrac12 (Q^* - Q)\right)
        """
        force = number(tangential_force, "The tangential force", "N", at_least=-amplitude, at_most=amplitude)
        return self.displacement(amplitude) - 2.0 * self.displacement(0.5 * (amplitude - force))

    def dissipated(self, amplitude: float) -> float:
        r"""Return the energy lost in a cycle between amplitude and -amplitude of the force, J: Mindlin, Deresiewicz.

        .. math:: W = \frac{18\kappa\,\mu^2 P^2}{5 a E^*}
                  \left[1 - (1 - x)^{5/3} - \tfrac56 x\,(1 + (1 - x)^{2/3})\right], \quad x = Q^*/\mu P
        """
        x = self._part(amplitude)
        bracket = float(1.0 - (1.0 - x) ** (5 / 3) - 5.0 / 6.0 * x * (1.0 + (1.0 - x) ** (2 / 3)))
        return 3.6 * self.compliance_ratio * self.sliding_force**2 / (self.contact_radius * self.modulus) * bracket

    def _part(self, tangential_force: float) -> float:
        force = number(tangential_force, "The tangential force", "N", at_least=0.0, at_most=self.sliding_force)
        return force / self.sliding_force


@guarded
def frictional_punch(friction_over_beta: float) -> float:
    r"""Return the radius of the stick zone over that of a flat, round punch under a normal force.

    .. math:: \frac{\beta}{\mu}\,\frac{a}{2c}\ln\frac{a + c}{a - c} = K'(c/a), \quad
              K'(k) = K\!\left(\sqrt{1 - k^2}\right)

    The influence of the traction on the pressure is neglected, after Goodman; K is the complete elliptic integral of
    the first kind. A ball has the same ratio as the punch: its contact grows similar to itself.

    Parameters
    ----------
    friction_over_beta
        Coefficient of friction over the magnitude of Dundurs' beta.

    Examples
    --------
    >>> from roughcontact.reference import frictional_punch
    >>> print(f"{frictional_punch(0.6):.4f}")
    0.6268
    """
    from scipy import optimize

    ratio = number(friction_over_beta, "The friction over beta", above=0.0)

    def mismatch(logit: float) -> float:
        c = float(scipy.special.expit(logit))
        logarithm = math.log1p(c) - float(scipy.special.log_expit(-logit))
        return logarithm / (2.0 * c * ratio) - float(scipy.special.ellipkm1(c**2))

    if not mismatch(-_LARGEST_LOGIT) < 0.0 < mismatch(_LARGEST_LOGIT):
        raise InputError.about("The friction over beta", friction_over_beta, "between 0.004 and 70")
    return float(scipy.special.expit(optimize.brentq(mismatch, -_LARGEST_LOGIT, _LARGEST_LOGIT, xtol=1e-12)))


@guarded
def bonded_punch(beta: float) -> float:
    r"""Return the normal force on a bonded, flat, round punch, over the force on one without friction.

    .. math:: \frac{P}{2 E^* a \delta} = \frac{\operatorname{artanh}\beta}{\beta}

    For a rigid punch, of which beta is (1 - 2 nu)/(2 - 2 nu), it is (1 - nu) ln(3 - 4 nu)/(1 - 2 nu).

    Parameters
    ----------
    beta
        Dundurs' constant.

    References
    ----------
    Johnson, Contact Mechanics (1985), section 3.8, https://doi.org/10.1017/CBO9781139171731

    Examples
    --------
    >>> from roughcontact.reference import bonded_punch
    >>> print(f"{bonded_punch(0.2 / 0.7):.4f}")  # rigid, on a body of Poisson's ratio 0.3
    1.0286
    """
    beta = _beta(beta)
    if abs(beta) >= 1.0:
        raise InputError.about("Dundurs' beta", beta, "between -1 and 1")
    return math.atanh(beta) / beta if abs(beta) > _SMALL_BETA else 1.0 + beta**2 / 3.0


@guarded
@attrs.frozen
class UnlikeCylinder:
    r"""A cylinder that slides over a body of other material, by plane strain.

    .. math:: p = \frac{E^*\cos\pi\eta}{2R}\,(b + \xi)^{1/2-\eta}\,(b - \xi)^{1/2+\eta}, \quad \xi = x + 2\eta b, \quad
              \tan\pi\eta = \mu\beta, \quad b^2 = \frac{4 P R}{\pi E^* (1 - 4\eta^2)}

    with the half-width b, a place x from the lowest line, and the traction :math:`\mu p` along x on the body, which
    for beta above zero is the softer one.

    Parameters
    ----------
    force
        Normal force over length P, N/m.
    radius
        Relative radius of curvature R, m.
    modulus
        Contact modulus E*, Pa.
    friction
        Coefficient of friction.
    beta
        Dundurs' constant.

    Notes
    -----
    The pressure solves :math:`\frac1\pi\int p(t)/(x - t)\,dt - \mu\beta p = E^* x/2R` inside the contact. See Johnson,
    Contact Mechanics (1985), section 8.1, https://doi.org/10.1017/CBO9781139171731.

    Examples
    --------
    >>> from roughcontact.reference import UnlikeCylinder
    >>> cylinder = UnlikeCylinder(force=1e4, radius=1e-2, modulus=100e9, friction=0.5, beta=0.4)
    >>> print(f"{cylinder.half_width * 1e6:.2f} um, centre at {cylinder.centre * 1e6:.2f} um")
    35.97 um, centre at -4.52 um
    """

    force: float = attrs.field(converter=read_force)
    radius: float = attrs.field(converter=read_length)
    modulus: float = attrs.field(converter=read_pressure)
    friction: float = attrs.field(converter=_friction)
    beta: float = attrs.field(converter=_beta)

    @property
    def eta(self) -> float:
        """Deviation of the exponents from 1/2."""
        return math.atan(self.friction * self.beta) / math.pi

    @property
    def half_width(self) -> float:
        """Half of the width of the contact b, m."""
        square = 4.0 * self.force * self.radius / (math.pi * self.modulus * (1.0 - 4.0 * self.eta**2))
        return math.sqrt(square)

    @property
    def centre(self) -> float:
        """Middle of the contact, m: against the traction on the softer body."""
        return -2.0 * self.eta * self.half_width

    def pressure(self, x: Array) -> Array:
        """Return the pressure at places from the lowest line of the cylinder, m; Pa."""
        place = x - self.centre
        left, right = (np.maximum(self.half_width + sign * place, 0.0) for sign in (1.0, -1.0))
        factor = self.modulus * math.cos(math.pi * self.eta) / (2.0 * self.radius)
        return np.asarray(factor * left ** (0.5 - self.eta) * right ** (0.5 + self.eta), dtype=np.float64)


@guarded
@attrs.frozen
class SlidingWave(Wave):
    r"""A wave that slides in full contact over a body of other material, by plane strain.

    .. math:: p = \bar p + \frac{\pi E^* A}{\lambda\sqrt{1 + \mu^2\beta^2}}\,
              \cos\!\left(\frac{2\pi x}{\lambda} + \arctan\mu\beta\right)

    where the heights are :math:`A\cos(2\pi x/\lambda)`, and the traction on the body is :math:`\mu p` along x. It
    follows from :math:`\hat u_z = \frac{\lambda}{\pi E^*}(1 - i\mu\beta)\,\hat p`.

    Parameters
    ----------
    amplitude, wavelength
        Of the heights, m.
    modulus
        Contact modulus E*, Pa.
    friction
        Coefficient of friction.
    beta
        Dundurs' constant.

    Examples
    --------
    >>> from roughcontact.reference import SlidingWave
    >>> wave = SlidingWave(amplitude=1e-6, wavelength=1e-3, modulus=100e9, friction=2.0, beta=0.5)
    >>> print(f"{wave.pressure_amplitude / 1e6:.2f} MPa, phase {wave.phase:.4f}")
    222.14 MPa, phase 0.7854
    """

    friction: float = attrs.field(converter=_friction)
    beta: float = attrs.field(converter=_beta)

    @property
    def pressure_amplitude(self) -> float:
        """Amplitude of the pressure, Pa: contact is full if the mean pressure is not below it."""
        return self.full_contact_pressure / math.hypot(1.0, self.friction * self.beta)

    @property
    def phase(self) -> float:
        """Phase by which the pressure is before the heights, rad."""
        return math.atan(self.friction * self.beta)

    def pressure(self, x: Array, mean: float) -> Array:
        """Return the pressure at places from a crest, m, at a mean pressure, Pa; Pa."""
        wave = np.cos(2.0 * math.pi * x / self.wavelength + self.phase)
        return np.asarray(mean + self.pressure_amplitude * wave, dtype=np.float64)
