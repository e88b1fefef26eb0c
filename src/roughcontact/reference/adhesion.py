"""Closed forms of adhesive contact: balls, a wave, and when rough surfaces stick; SI units."""

from __future__ import annotations

import abc
import math
from typing import final

import attrs
import numpy as np

from roughcontact._base.checks import Array, number
from roughcontact._parts.grid import Grid
from roughcontact.errors import InputError
from roughcontact.errors.door import guarded
from roughcontact.reference.waves import list_waves

# Contact radii, over their unit, between which a pull-off is looked for; the largest is that of JKR.
_RADII = (1e-6, 3.0)
# Tolerance of the search for a radius: the force is flat there, so that it is exact to the square of it.
_EXACT = 1e-10
# Area over load without adhesion, in units of E* rms slope (Pastewka and Robbins).
_KAPPA = 2.0


def _positive(value: float, unit: str) -> float:
    return number(value, "An argument of a closed form", unit, above=0.0)


def _length(value: float) -> float:
    return _positive(value, "m")


def _work(value: float) -> float:
    return _positive(value, "J/m2")


def _pascal(value: float) -> float:
    return _positive(value, "Pa")


@attrs.frozen
class AdhesiveSphere(abc.ABC):
    """A ball on a flat that attract each other: force and approach over the radius of contact.

    Parameters
    ----------
    radius
        Relative radius of curvature R, m.
    work
        Work of adhesion w, J/m2.
    modulus
        Contact modulus E*, Pa.
    """

    radius: float = attrs.field(converter=_length)
    work: float = attrs.field(converter=_work)
    modulus: float = attrs.field(converter=_pascal)

    @abc.abstractmethod
    def force(self, contact_radius: Array) -> Array:
        """Return the force at contact radii, m; N, negative where it pulls."""

    @abc.abstractmethod
    def approach(self, contact_radius: Array) -> Array:
        """Return the approach at contact radii, m, since the first touch without adhesion."""

    @property
    @abc.abstractmethod
    def pull_off(self) -> float:
        """Force at which the ball comes off under a given load, N, negative: the lowest one."""

    @property
    def zero_load_radius(self) -> float:
        """Contact radius without load, m."""
        from scipy import optimize

        unit = self._radius_unit

        def scaled(ratio: float) -> float:
            return float(self.force(np.array([ratio * unit]))[0]) / (math.pi * self.work * self.radius)

        return unit * float(optimize.brentq(scaled, self._lowest_ratio, _RADII[1], xtol=_EXACT))

    @property
    def _radius_unit(self) -> float:
        return float((0.75 * math.pi * self.work * self.radius**2 / self.modulus) ** (1 / 3))

    @property
    def _lowest_ratio(self) -> float:
        """Contact radius at the lowest force, over its unit."""
        return _RADII[0]


@final
@guarded
@attrs.frozen
class JkrSphere(AdhesiveSphere):
    r"""The theory of Johnson, Kendall and Roberts: attraction inside the contact alone, of soft balls.

    .. math:: F = \frac{4 E^* a^3}{3R} - \sqrt{8\pi w E^* a^3}, \quad
              \delta = \frac{a^2}{R} - \sqrt{\frac{2\pi w a}{E^*}}, \quad F_c = -\tfrac32 \pi w R

    References
    ----------
    Johnson, Kendall, Roberts, Proc. R. Soc. Lond. A 324 (1971) 301-313, https://doi.org/10.1098/rspa.1971.0141

    Examples
    --------
    A rubber ball of 5 mm on glass:

    >>> from roughcontact.reference.adhesion import JkrSphere
    >>> ball = JkrSphere(radius=5e-3, work=0.05, modulus=3e6)
    >>> print(f"{1e3 * ball.pull_off:.3f} mN, {1e6 * ball.zero_load_radius:.1f} um")
    -1.178 mN, 180.6 um
    """

    def force(self, contact_radius: Array) -> Array:
        """Return the force at contact radii, m; N."""
        a = np.asarray(contact_radius, dtype=np.float64)
        hertz = 4.0 * self.modulus * a**3 / (3.0 * self.radius)
        return np.asarray(hertz - np.sqrt(8.0 * math.pi * self.work * self.modulus * a**3))

    def approach(self, contact_radius: Array) -> Array:
        """Return the approach at contact radii, m."""
        a = np.asarray(contact_radius, dtype=np.float64)
        return np.asarray(a**2 / self.radius - np.sqrt(2.0 * math.pi * self.work * a / self.modulus))

    @property
    def pull_off(self) -> float:
        """Pull-off force, N."""
        return -1.5 * math.pi * self.work * self.radius

    @property
    def zero_load_radius(self) -> float:
        """Contact radius without load, m."""
        return float((4.5 * math.pi * self.work * self.radius**2 / self.modulus) ** (1 / 3))


@final
@guarded
@attrs.frozen
class DmtSphere(AdhesiveSphere):
    r"""The theory of Derjaguin, Muller and Toporov: long-range attraction that deforms nothing, of hard balls.

    .. math:: F = \frac{4 E^* a^3}{3R} - 2\pi w R, \quad \delta = \frac{a^2}{R}

    References
    ----------
    Derjaguin, Muller, Toporov, J. Colloid Interface Sci. 53 (1975) 314-326,
    https://doi.org/10.1016/0021-9797(75)90018-1
    """

    def force(self, contact_radius: Array) -> Array:
        """Return the force at contact radii, m; N."""
        a = np.asarray(contact_radius, dtype=np.float64)
        return np.asarray(4.0 * self.modulus * a**3 / (3.0 * self.radius) + self.pull_off)

    def approach(self, contact_radius: Array) -> Array:
        """Return the approach at contact radii, m."""
        return np.asarray(np.asarray(contact_radius, dtype=np.float64) ** 2 / self.radius)

    @property
    def pull_off(self) -> float:
        """Pull-off force, N."""
        return -2.0 * math.pi * self.work * self.radius


@final
@guarded
@attrs.frozen
class MaugisSphere(AdhesiveSphere):
    r"""The theory of Maugis: a constant tension around the contact, up to a gap, from DMT to JKR.

    With K = 4 E*/3, lengths over :math:`(\pi w R^2/K)^{1/3}`, forces over :math:`\pi w R`, approaches over
    :math:`(\pi^2 w^2 R/K^2)^{1/3}`, the ratio m of the radii of tension and contact and
    :math:`\lambda = 2 s_0 (R/\pi w K^2)^{1/3}`,

    .. math:: \tfrac12\lambda a^2\left[\sqrt{m^2-1} + (m^2-2)\,\mathrm{arcsec}\,m\right]
              + \tfrac43\lambda^2 a\left[\sqrt{m^2-1}\,\mathrm{arcsec}\,m - m + 1\right] = 1

    .. math:: F = a^3 - \lambda a^2\left[\sqrt{m^2-1} + m^2\,\mathrm{arcsec}\,m\right], \quad
              \delta = a^2 - \tfrac43\lambda a\sqrt{m^2-1}

    Parameters
    ----------
    radius
        Relative radius of curvature R, m.
    work
        Work of adhesion w, J/m2.
    modulus
        Contact modulus E*, Pa.
    strength
        The tension s0, Pa.

    References
    ----------
    Maugis, J. Colloid Interface Sci. 150 (1992) 243-269, https://doi.org/10.1016/0021-9797(92)90285-T

    Examples
    --------
    >>> from roughcontact.reference.adhesion import MaugisSphere
    >>> ball = MaugisSphere(radius=1e-6, work=0.05, modulus=1e9, strength=2e7)
    >>> print(f"lambda {ball.parameter:.3f}, pull-off {1e9 * ball.pull_off:.1f} nN")
    lambda 0.612, pull-off -263.9 nN
    """

    strength: float = attrs.field(converter=_pascal)

    @property
    def parameter(self) -> float:
        """Maugis' parameter lambda, 1.127 times Tabor's: below 0.1 DMT holds, above 5 JKR."""
        stiffness = 4.0 * self.modulus / 3.0
        return float(2.0 * self.strength * (self.radius / (math.pi * self.work * stiffness**2)) ** (1 / 3))

    def force(self, contact_radius: Array) -> Array:
        """Return the force at contact radii, m; N."""
        ratios = np.asarray(contact_radius, dtype=np.float64) / self._radius_unit
        forces = [self._scaled_force(float(ratio)) for ratio in ratios.ravel()]
        return np.reshape(forces, ratios.shape) * (math.pi * self.work * self.radius)

    def approach(self, contact_radius: Array) -> Array:
        """Return the approach at contact radii, m."""
        ratios = np.asarray(contact_radius, dtype=np.float64) / self._radius_unit
        shifts = [math.sqrt(self._extent(float(ratio)) ** 2 - 1.0) for ratio in ratios.ravel()]
        scaled = ratios**2 - 4.0 / 3.0 * self.parameter * ratios * np.reshape(shifts, ratios.shape)
        return np.asarray(scaled * (self._radius_unit**2 / self.radius))

    def tension_radius(self, contact_radius: Array) -> Array:
        """Return the outer radius of the tension at contact radii, m."""
        ratios = np.asarray(contact_radius, dtype=np.float64) / self._radius_unit
        extents = [self._extent(float(ratio)) for ratio in ratios.ravel()]
        return np.reshape(extents, ratios.shape) * ratios * self._radius_unit

    @property
    def pull_off(self) -> float:
        """Pull-off force, N."""
        return self._scaled_force(self._lowest_ratio) * math.pi * self.work * self.radius

    @property
    def _lowest_ratio(self) -> float:
        from scipy import optimize

        # Logarithms, because of hard balls the contact vanishes at pull-off.
        bounds = (math.log(_RADII[0]), math.log(_RADII[1]))
        found = optimize.minimize_scalar(
            lambda logarithm: self._scaled_force(math.exp(logarithm)),
            bounds=bounds,
            method="bounded",
            options={"xatol": 1e-9},
        )
        return math.exp(float(found.x))

    def _scaled_force(self, ratio: float) -> float:
        m = self._extent(ratio)
        root = math.sqrt(m * m - 1.0)
        return ratio**3 - self.parameter * ratio**2 * (root + m * m * math.atan(root))

    def _extent(self, ratio: float) -> float:
        """Return the ratio m of the radii of the tension and of a contact radius over its unit."""
        from scipy import optimize

        parameter = self.parameter

        def excess(m: float) -> float:
            root = math.sqrt(max(m * m - 1.0, 0.0))
            angle = math.atan(root)
            first = 0.5 * parameter * ratio**2 * (root + (m * m - 2.0) * angle)
            return first + 4.0 / 3.0 * parameter**2 * ratio * (root * angle - m + 1.0) - 1.0

        upper = 2.0
        while excess(upper) < 0.0:
            upper *= 2.0
        return float(optimize.brentq(excess, 1.0, upper, xtol=1e-15, rtol=1e-15))


@guarded
def tabor_parameter(radius: float, work: float, reach: float, modulus: float) -> float:
    r"""Return Tabor's parameter of a ball: below 0.1 the theory DMT holds, above 5 that of JKR.

    .. math:: \mu = \left(\frac{R w^2}{E^{*2} \rho^3}\right)^{1/3}

    Parameters
    ----------
    radius
        Relative radius of curvature R, m.
    work
        Work of adhesion w, J/m2.
    reach
        Range of the attraction rho, m: the work over the strength.
    modulus
        Contact modulus E*, Pa.

    References
    ----------
    Maugis, J. Colloid Interface Sci. 150 (1992) 243-269, https://doi.org/10.1016/0021-9797(92)90285-T
    """
    cube = _positive(radius, "m") * _positive(work, "J/m2") ** 2 / _positive(modulus, "Pa") ** 2
    return float(cube ** (1 / 3) / _positive(reach, "m"))


@final
@guarded
@attrs.frozen
class JohnsonWave:
    r"""Contact of a wave in one direction with a flat, with attraction inside the contact alone.

    With the half width of contact a over the wavelength L, the pressure of full contact without adhesion
    :math:`p^* = \pi E^* D/L` and :math:`\alpha = \sqrt{2 w L/(\pi^2 E^* D^2)}`,

    .. math:: \frac{p}{p^*} = \sin^2 \pi a - \alpha\sqrt{\tan \pi a}

    Parameters
    ----------
    amplitude
        Amplitude of the wave D, half of its height from peak to valley, m.
    wavelength
        Wavelength L, m.
    work
        Work of adhesion w, J/m2.
    modulus
        Contact modulus E*, Pa.

    References
    ----------
    Johnson, Int. J. Solids Struct. 32 (1995) 423-430, https://doi.org/10.1016/0020-7683(94)00111-9

    Examples
    --------
    >>> from roughcontact.reference.adhesion import JohnsonWave
    >>> wave = JohnsonWave(amplitude=1e-6, wavelength=100e-6, work=0.05, modulus=20e6)
    >>> print(f"alpha {wave.parameter:.3f}, full contact without load: {wave.snaps_into_full_contact}")
    alpha 0.225, full contact without load: False
    >>> print(f"{1e-3 * wave.pull_off:.1f} kPa, {wave.zero_load_fraction:.3f}")
    -40.9 kPa, 0.248
    """

    amplitude: float = attrs.field(converter=_length)
    wavelength: float = attrs.field(converter=_length)
    work: float = attrs.field(converter=_work)
    modulus: float = attrs.field(converter=_pascal)

    @property
    def parameter(self) -> float:
        """Johnson's parameter alpha."""
        square = 2.0 * self.work * self.wavelength / (math.pi**2 * self.modulus * self.amplitude**2)
        return math.sqrt(square)

    @property
    def full_pressure(self) -> float:
        """Mean pressure of full contact without adhesion, Pa."""
        return math.pi * self.modulus * self.amplitude / self.wavelength

    def pressure(self, fraction: Array) -> Array:
        """Return the mean pressure, Pa, at the fraction 2 a of the surface in contact, from 0 to below 1."""
        angle = 0.5 * math.pi * np.asarray(fraction, dtype=np.float64)
        return np.asarray((np.sin(angle) ** 2 - self.parameter * np.sqrt(np.tan(angle))) * self.full_pressure)

    @property
    def snaps_into_full_contact(self) -> bool:
        """Whether surfaces that touch without load close: alpha above (27/256)^(1/4) = 0.570."""
        return bool(self.parameter > (27.0 / 256.0) ** 0.25)

    @property
    def pull_off(self) -> float:
        """Mean pressure at which partial contact comes off, Pa, negative.

        Raises
        ------
        InputError
            If there is no partial contact in equilibrium.
        """
        return float(self.pressure(np.array(self._fold())))

    @property
    def zero_load_fraction(self) -> float:
        """Fraction of the surface in stable contact without load; 1 if it closes."""
        if self.snaps_into_full_contact:
            return 1.0
        from scipy import optimize

        fold = self._fold()
        # The maximum of sin^(3/2) cos^(1/2) is at 60 degrees: contact beyond is not stable.
        return float(optimize.brentq(lambda fraction: float(self.pressure(np.array(fraction))), fold, 2.0 / 3.0))

    def _fold(self) -> float:
        """Return the fraction at which partial contact comes off: where the slope of the pressure vanishes."""
        from scipy import optimize

        # The slope 2 sin cos - alpha / (2 cos^2 sqrt(tan)) vanishes where 4 sin^(3/2) cos^(5/2) = alpha.
        top = math.asin(math.sqrt(0.375))

        def excess(angle: float) -> float:
            return 4.0 * math.sqrt(math.sin(angle) ** 3 * math.cos(angle) ** 5) - self.parameter

        if excess(top) <= 0.0:
            raise InputError(
                f"With alpha = {self.parameter:.3g} the wave has no partial contact in equilibrium: it closes."
            )
        return 2.0 * float(optimize.brentq(excess, 0.0, top)) / math.pi


@guarded
def stickiness(rms_slope: float, rms_curvature: float, work: float, reach: float, modulus: float) -> float:
    r"""Return how strongly a rough surface sticks by the criterion of Pastewka and Robbins: above 1 it does.

    It is the ratio of attraction and repulsion of contact patches of the width :math:`d = 4 h'/h''`, with the tension
    :math:`w/\rho` around each up to the gap :math:`\rho`, whose width follows from the gap of a contact without
    adhesion, :math:`\tfrac43 h' s^{3/2}/\sqrt d` at a distance s of its edge:

    .. math:: \kappa\,\pi \frac{w}{E^* h' \rho}\left(\frac{3 \rho}{4 h' d}\right)^{2/3}, \quad \kappa = 2

    Parameters
    ----------
    rms_slope
        Root mean square of the slope h'.
    rms_curvature
        Root mean square of the Laplacian of the heights h'', 1/m: of a ball two over its radius.
    work
        Work of adhesion w, J/m2.
    reach
        Range of the attraction rho, m: the work over the strength.
    modulus
        Contact modulus E*, Pa.

    References
    ----------
    Pastewka, Robbins, PNAS 111 (2014) 3298-3303, https://doi.org/10.1073/pnas.1320846111
    """
    slope = _positive(rms_slope, "")
    width = 4.0 * slope / _positive(rms_curvature, "1/m")
    reach = _length(reach)
    length = _positive(work, "J/m2") / _positive(modulus, "Pa")
    scaled = _KAPPA * math.pi * length / (slope * reach)
    return float(scaled * (0.75 * reach / (slope * width)) ** (2 / 3))


@final
@attrs.frozen
class FullContactEnergies:
    """The energies of two surfaces pressed into full contact, per nominal area, J/m2.

    Attributes
    ----------
    elastic
        Elastic energy of closing all gaps.
    released
        Work of adhesion less the elastic energy: what full contact releases, or takes if negative. It is the effective
        work of adhesion of Persson and Tosatti, without the increase of the area by the roughness.
    """

    elastic: float
    released: float


@guarded
def full_contact_energies(heights: Array, grid: Grid, work: float, modulus: float) -> FullContactEnergies:
    r"""Return the energies of full contact of a surface that repeats, by the power of its waves.

    .. math:: U = \frac{E^*}{4} \sum_q q\,|h_q|^2

    Parameters
    ----------
    heights
        Heights, shape (nx, ny), m.
    grid
        Their grid.
    work
        Work of adhesion, J/m2.
    modulus
        Contact modulus E*, Pa.

    References
    ----------
    Persson, Tosatti, J. Chem. Phys. 115 (2001) 5597-5610, https://doi.org/10.1063/1.1398300
    """
    waves = list_waves(heights, grid, periodic=True)
    strain = waves.sum(np.sqrt(waves.square)) * waves.height**2 / waves.cell
    elastic = 0.25 * _positive(modulus, "Pa") * strain
    return FullContactEnergies(elastic, _positive(work, "J/m2") - elastic)
