"""Laws of interaction: exponential, Dugdale, van der Waals, and the shortest range that a grid resolves."""

from __future__ import annotations

import math

import attrs
import numpy as np

from roughcontact._base.arrays import Array, Pair, RealArray, restore_state
from roughcontact._base.checks import number, number_or_array, pair
from roughcontact._base.units import Quantity
from roughcontact._parts.interactions.base import Interaction
from roughcontact.errors import InputError

# Exponents below which an exponential counts as its value there, in each precision: what is smaller would be
# denormal, which is slow.
_LOWEST_EXPONENT = {np.dtype(np.float32): -60.0, np.dtype(np.float64): -600.0}
# Cells of the cohesive length of a law that a grid just resolves: fewer make the edge of the contact stick to the
# cells, and pull-off too strong by about 80 % exp(-2 cells).
_RESOLVED = 2.0


def _work(value: object) -> float | Array:
    return number_or_array(value, "The work of adhesion", "J/m2")


def _range(value: object) -> float | Array:
    return number_or_array(value, "The range of the interaction", "m")


def _strength(value: object) -> float | Array:
    return number_or_array(value, "The strength of the interaction", "Pa")


def _smoothing(value: Quantity) -> float:
    return number(value, "The smoothing of the Dugdale law", above=0.0, at_most=1.0)


def _like(parameter: float | Array, gap: RealArray) -> float | RealArray:
    """Return a parameter in the precision of a gap; a number does not change that precision."""
    return parameter if isinstance(parameter, float) else parameter.astype(gap.dtype, copy=False)


def _spread(gap: RealArray, *parameters: float | Array) -> RealArray:
    """Return gaps as an array of the shape that they have together with the parameters."""
    gaps = np.asarray(gap)
    if all(isinstance(parameter, float) for parameter in parameters):
        return gaps
    shape = np.broadcast_shapes(gaps.shape, *(np.shape(parameter) for parameter in parameters))
    return gaps if shape == gaps.shape else np.broadcast_to(gaps, shape)


@attrs.frozen(eq=False)
class Exponential(Interaction):
    r"""Tension that falls exponentially with the gap.

    .. math:: s(g) = \frac{w}{\rho}\, e^{-g/\rho}, \quad W(g) = -w\, e^{-g/\rho}, \quad
              \max|s'| = \frac{w}{\rho^2}

    Parameters
    ----------
    work
        Work of adhesion w, J/m2, above zero: a number, a text such as ``"50mJ/m2"``, or an array of the grid's
        shape (nx, ny).
    range
        Range rho, m, above zero: a number, a text such as ``"2nm"``, or an array (nx, ny).

    References
    ----------
    Müser, Dapp, Bugnicourt et al., Tribol. Lett. 65 (2017) 118, https://doi.org/10.1007/s11249-017-0900-2

    Examples
    --------
    >>> import numpy as np
    >>> from roughcontact._parts.interactions import Exponential
    >>> law = Exponential(work="50mJ/m2", range="2nm")
    >>> print(f"{law.strength / 1e6:g} MPa")
    25 MPa
    >>> print(f"{law.tension(np.array([4e-9]))[0] / 1e6:.3f} MPa")
    3.383 MPa
    """

    work: float | Array = attrs.field(converter=_work, metadata={"unit": "J/m2"})
    range: float | Array = attrs.field(converter=_range, metadata={"unit": "m"})

    __setstate__ = restore_state

    def tension(self, gap: RealArray) -> RealArray:
        """Return the tension, Pa; see `Interaction.tension`."""
        return self._decay(gap, self.work / self.range)

    def slope(self, gap: RealArray) -> RealArray:
        """Return the derivative of the tension, Pa/m."""
        return self._decay(gap, -self.work / self.range / self.range)

    def energy(self, gap: RealArray) -> RealArray:
        """Return the energy per area, J/m2."""
        return self._decay(gap, -self.work)

    @property
    def reach(self) -> float:
        """Gap beyond which the energy is less than a millionth of the work of adhesion, m."""
        return float(-math.log(1e-6) * np.max(self.range))

    @property
    def steepest(self) -> float:
        """Maximum of the magnitude of the slope, Pa/m."""
        return float(np.max(self.work / self.range / self.range))

    def scaled(self, length: float, pressure: float) -> Exponential:
        """Return the law in units of a length, m, and a pressure, Pa."""
        return Exponential(self.work / length / pressure, self.range / length)

    def _decay(self, gap: RealArray, amplitude: float | Array) -> RealArray:
        gaps = _spread(gap, self.work, self.range)
        values = np.asarray(gaps * _like(-1.0 / self.range, gaps))
        lowest = _LOWEST_EXPONENT[values.dtype]
        if values.size and values.min() < lowest:
            np.maximum(values, lowest, out=values)
        np.exp(values, out=values)
        values *= _like(amplitude, gaps)
        return values


@attrs.frozen(eq=False)
class Dugdale(Interaction):
    r"""Constant tension up to a gap, beyond which it falls smoothly to zero.

    With :math:`g_c = w/s_0` and :math:`x = (g - g_c)/(f g_c)`, limited to -1 to 1,

    .. math:: s(g) = \frac{s_0}{2}\left(1 - \sin\frac{\pi x}{2}\right), \quad
              \max|s'| = \frac{\pi s_0^2}{4 f w}

    Without smoothing, f = 0, the edge of the tension would stick to the cells; with it the work of adhesion is the
    same.

    Parameters
    ----------
    work
        Work of adhesion w, J/m2, above zero: a number, a text such as ``"50mJ/m2"``, or an array of the grid's
        shape (nx, ny).
    strength
        Tension s0 of surfaces that just touch, Pa, above zero: a number, a text or an array (nx, ny).
    smoothing
        Half width f of the gaps over which the tension falls, over g_c; above 0 and at most 1.

    References
    ----------
    Maugis, J. Colloid Interface Sci. 150 (1992) 243-269, https://doi.org/10.1016/0021-9797(92)90285-T

    Examples
    --------
    >>> import numpy as np
    >>> from roughcontact._parts.interactions import Dugdale
    >>> law = Dugdale(work="50mJ/m2", strength="10MPa")
    >>> [f"{tension / 1e6:g} MPa" for tension in law.tension(np.array([0.0, 3e-9, 5e-9, 7e-9]))]
    ['10 MPa', '10 MPa', '5 MPa', '0 MPa']
    """

    work: float | Array = attrs.field(converter=_work, metadata={"unit": "J/m2"})
    strength: float | Array = attrs.field(converter=_strength, metadata={"unit": "Pa"})
    smoothing: float = attrs.field(converter=_smoothing, default=0.3, metadata={"unit": ""})

    __setstate__ = restore_state

    def tension(self, gap: RealArray) -> RealArray:
        """Return the tension, Pa; see `Interaction.tension`."""
        values = self._place(gap)
        np.sin(values, out=values)
        np.subtract(1.0, values, out=values)
        values *= _like(0.5 * self.strength, values)
        return values

    def slope(self, gap: RealArray) -> RealArray:
        """Return the derivative of the tension, Pa/m."""
        values = self._place(gap)
        outside = np.abs(values) >= values.dtype.type(0.5 * math.pi)
        np.cos(values, out=values)
        values *= _like(-0.25 * math.pi * self.strength / (self.smoothing * self._center), values)
        values[outside] = 0.0
        return values

    def energy(self, gap: RealArray) -> RealArray:
        """Return the energy per area, J/m2."""
        # Where the tension falls it contributes f w (1 - x - 2 cos(pi x / 2) / pi) / 2, below that s0 for each metre.
        place = self._place(gap)
        fallen = 1.0 - (2.0 / math.pi) * (place + np.cos(place))
        fallen *= _like(-0.5 * self.smoothing * self.work, fallen)
        constant = np.minimum(np.asarray(gap) - _like((1.0 - self.smoothing) * self._center, fallen), 0.0)
        constant *= _like(self.strength, fallen)
        fallen += constant
        return fallen

    @property
    def reach(self) -> float:
        """Gap beyond which the tension is zero, m."""
        return float((1.0 + self.smoothing) * np.max(self._center))

    @property
    def steepest(self) -> float:
        """Maximum of the magnitude of the slope, Pa/m."""
        return float(np.max(0.25 * math.pi * self.strength / (self.smoothing * self._center)))

    def scaled(self, length: float, pressure: float) -> Dugdale:
        """Return the law in units of a length, m, and a pressure, Pa."""
        return Dugdale(self.work / length / pressure, self.strength / pressure, self.smoothing)

    @property
    def _center(self) -> float | Array:
        """The gap at which the tension is half of the strength, m."""
        return self.work / self.strength

    def _place(self, gap: RealArray) -> RealArray:
        """Return pi x / 2, a new array."""
        gaps = _spread(gap, self.work, self.strength)
        half = 0.5 * math.pi / self.smoothing
        values = np.asarray(gaps * _like(half / self._center, gaps))
        values -= values.dtype.type(half)
        bound = 0.5 * math.pi
        return np.clip(values, -bound, bound, out=values)


@attrs.frozen(eq=False)
class VanDerWaals(Interaction):
    r"""The attraction of two bodies of molecules that attract by the sixth power of their distance, from contact on.

    It is the attractive part of the potential 9-3, its repulsive one replaced by a hard wall.

    .. math:: s(g) = \frac{2w}{z}\left(1 + \frac{g}{z}\right)^{-3}, \quad
              W(g) = -w \left(1 + \frac{g}{z}\right)^{-2}, \quad \max|s'| = \frac{6w}{z^2}

    Parameters
    ----------
    work
        Work of adhesion w, J/m2, above zero: a number, a text such as ``"50mJ/m2"``, or an array of the grid's
        shape (nx, ny).
    range
        Distance z of the surfaces in contact, m, above zero: a number, a text such as ``"0.3nm"``, or an array
        (nx, ny). The Hamaker constant is 12 pi w z^2.

    References
    ----------
    Israelachvili, Intermolecular and Surface Forces (2011), ch. 13, https://doi.org/10.1016/C2009-0-21560-1

    Examples
    --------
    >>> import numpy as np
    >>> from roughcontact._parts.interactions import VanDerWaals
    >>> law = VanDerWaals(work="30mJ/m2", range="0.3nm")
    >>> print(f"{law.strength / 1e6:g} MPa, {law.tension(np.array([3e-10]))[0] / 1e6:g} MPa")
    200 MPa, 25 MPa
    """

    work: float | Array = attrs.field(converter=_work, metadata={"unit": "J/m2"})
    range: float | Array = attrs.field(converter=_range, metadata={"unit": "m"})

    __setstate__ = restore_state

    def tension(self, gap: RealArray) -> RealArray:
        """Return the tension, Pa; see `Interaction.tension`."""
        return self._power(gap, 2.0 * self.work / self.range, 3)

    def slope(self, gap: RealArray) -> RealArray:
        """Return the derivative of the tension, Pa/m."""
        return self._power(gap, -6.0 * self.work / self.range / self.range, 4)

    def energy(self, gap: RealArray) -> RealArray:
        """Return the energy per area, J/m2."""
        return self._power(gap, -self.work, 2)

    @property
    def reach(self) -> float:
        """Gap beyond which the energy is less than a millionth of the work of adhesion, m."""
        return float(999.0 * np.max(self.range))

    @property
    def steepest(self) -> float:
        """Maximum of the magnitude of the slope, Pa/m."""
        return float(np.max(6.0 * self.work / self.range / self.range))

    def scaled(self, length: float, pressure: float) -> VanDerWaals:
        """Return the law in units of a length, m, and a pressure, Pa."""
        return VanDerWaals(self.work / length / pressure, self.range / length)

    def _power(self, gap: RealArray, amplitude: float | Array, exponent: int) -> RealArray:
        gaps = _spread(gap, self.work, self.range)
        base = np.asarray(gaps * _like(1.0 / self.range, gaps))
        base += base.dtype.type(1.0)
        np.reciprocal(base, out=base)
        values = base * base
        if exponent == 4:
            values *= values
        elif exponent == 3:
            values *= base
        values *= _like(amplitude, gaps)
        return values


@attrs.frozen(eq=False)
class ShortRange(Interaction):
    r"""The limit of Johnson, Kendall and Roberts: the exponential law with the shortest range that a grid resolves.

    .. math:: \rho = \sqrt{n\, w\, \Delta / E^*}, \quad n = 2

    with the longer side :math:`\Delta` of a cell: the cohesive length has n cells. `resolve` returns that law. Pull-off
    and contact radius go to those of the limit as the power 1.5 of the range; `ContactProblem.pull_off` extrapolates.

    Parameters
    ----------
    work
        Work of adhesion w, J/m2, above zero: a number, a text such as ``"50mJ/m2"``, or an array of the grid's
        shape (nx, ny).

    References
    ----------
    Johnson, Kendall, Roberts, Proc. R. Soc. Lond. A 324 (1971) 301-313, https://doi.org/10.1098/rspa.1971.0141

    Examples
    --------
    >>> from roughcontact._parts.interactions import ShortRange
    >>> law = ShortRange(work="50mJ/m2").resolve(spacing=(1e-8, 1e-8), modulus=1e9)
    >>> print(f"{law.range * 1e9:g} nm, {law.cohesive_cells((1e-8, 1e-8), 1e9):g} cells")
    1 nm, 2 cells
    """

    work: float | Array = attrs.field(converter=_work, metadata={"unit": "J/m2"})

    __setstate__ = restore_state

    def resolve(self, spacing: Pair, modulus: float) -> Exponential:
        """Return the exponential law with the shortest range that cells of a spacing, m, resolve at a modulus, Pa."""
        longer = max(pair(spacing, "The cell", "m", above=0.0))
        stiff = number(modulus, "The contact modulus", "Pa", above=0.0)
        return Exponential(self.work, np.sqrt(_RESOLVED * self.work * (longer / stiff)))

    def tension(self, gap: RealArray) -> RealArray:
        """Raise `InputError`: the law depends on the grid."""
        raise self._refusal()

    def slope(self, gap: RealArray) -> RealArray:
        """Raise `InputError`: the law depends on the grid."""
        raise self._refusal()

    def energy(self, gap: RealArray) -> RealArray:
        """Raise `InputError`: the law depends on the grid."""
        raise self._refusal()

    def scaled(self, length: float, pressure: float) -> Interaction:
        """Raise `InputError`: the law depends on the grid."""
        raise self._refusal()

    def _refusal(self) -> InputError:
        return InputError(f"The range of {self!r} depends on the grid: `resolve` returns the law for a grid.")
