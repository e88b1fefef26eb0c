"""Hardening: the yield stress of a material that has flowed, and the work that flow has taken."""

from __future__ import annotations

import abc
from collections.abc import Sequence

import attrs
import numpy as np
import roughcontact as rc
from roughcontact.typing import Array, Part, Quantity

# Largest number in SI units that a material may have: powers of it stay within float64.
_MAX_MAGNITUDE = 1e60
# Strain up to which a power whose slope is unbounded at zero is replaced by its chord.
_STRAIGHT = 1e-4


def check_stress(value: Quantity, what: str = "A stress", *, zero: bool = False) -> float:
    """Return a stress, Pa, checked to be finite and above zero, or at least zero."""
    return check_number(value, what, "Pa", zero=zero)


def check_number(value: Quantity, what: str, unit: str, *, zero: bool = False, most: float = _MAX_MAGNITUDE) -> float:
    """Return a number checked to be finite, above zero or at least zero, and at most another one."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = np.nan
    is_number = not isinstance(value, (str, bool)) and 0.0 <= number <= most and (zero or number > 0.0)
    if not is_number:
        bound = "at least 0" if zero else "above 0"
        bound = bound if most == _MAX_MAGNITUDE else f"{bound}, at most {most:g}"
        raise rc.InputError.about(what, value, f"a finite number, {bound} ({unit or 'no unit'})")
    return number


def _modulus(value: Quantity) -> float:
    return check_stress(value, "The hardening modulus", zero=True)


def _saturation(value: Quantity) -> float:
    return check_stress(value, "The stress at which hardening ends")


def _strain(value: float) -> float:
    return check_number(value, "The strain over which a material hardens", "")


def _power(value: float) -> float:
    return check_number(value, "The power of hardening", "", zero=True, most=1.0)


def _ludwik_modulus(value: Quantity) -> float:
    return check_stress(value, "The stress that a plastic strain of one adds", zero=True)


def _ludwik_power(value: float) -> float:
    return check_number(value, "The power of hardening", "", most=1.0)


def _list(values: Sequence[Quantity], what: str, unit: str) -> tuple[float, ...]:
    if isinstance(values, (str, bytes)) or not np.iterable(values):
        raise rc.InputError.about(what, values, f"a list of numbers ({unit or 'no unit'})")
    return tuple(check_number(value, what, unit, zero=True) for value in values)


def _strains(values: Sequence[float]) -> tuple[float, ...]:
    return _list(values, "A plastic strain of a table", "")


def _stresses(values: Sequence[Quantity]) -> tuple[float, ...]:
    return _list(values, "A stress of a table", "Pa")


class Hardening(Part, abc.ABC):
    """How the yield stress grows with the accumulated plastic strain, equally in all directions; never falling.

    Examples
    --------
    A class of your own gives the three:

    >>> import attrs
    >>> from roughcontact_volume import Hardening, Plastic
    >>> @attrs.frozen
    ... class RootHardening(Hardening):
    ...     def find_yield_stress(self, initial, strain):
    ...         return initial * (1 + strain) ** 0.5
    ...     def find_slope(self, initial, strain):
    ...         return 0.5 * initial * (1 + strain) ** -0.5
    ...     def find_work(self, initial, strain):
    ...         return initial * ((1 + strain) ** 1.5 - 1) / 1.5
    >>> Plastic("70GPa", 0.33, "100MPa", RootHardening()).find_yield_stress(3.0)
    200000000.0
    """

    @abc.abstractmethod
    def find_yield_stress(self, initial: float, strain: Array) -> Array:
        """Return the yield stress, Pa, from that of the material that never flowed and the accumulated strain."""

    @abc.abstractmethod
    def find_slope(self, initial: float, strain: Array) -> Array:
        """Return the derivative of the yield stress by the accumulated strain, Pa, at least zero."""

    @abc.abstractmethod
    def find_work(self, initial: float, strain: Array) -> Array:
        """Return the plastic work per volume, J/m3: the integral of the yield stress over the accumulated strain."""

    def require_fitting(self, initial: float) -> None:
        """Raise `InputError` unless it fits a material of this yield stress, Pa."""


@attrs.frozen
class LinearHardening(Hardening):
    r"""A yield stress that grows in proportion to the strain: :math:`Y = Y_0 + H \kappa`.

    Parameters
    ----------
    modulus
        Hardening modulus H, Pa, at least zero: the slope of the true stress over the plastic strain. Zero is perfect
        plasticity.

    Examples
    --------
    >>> from roughcontact_volume import LinearHardening
    >>> LinearHardening("4GPa").find_yield_stress(1e9, 0.1)
    1400000000.0
    """

    modulus: float = attrs.field(converter=_modulus, metadata={"unit": "Pa"})

    def find_yield_stress(self, initial: float, strain: Array) -> Array:
        """Return the yield stress, Pa; see `Hardening.find_yield_stress`."""
        return initial + self.modulus * strain

    def find_slope(self, initial: float, strain: Array) -> Array:
        """Return its derivative, Pa."""
        return self.modulus + 0.0 * strain

    def find_work(self, initial: float, strain: Array) -> Array:
        """Return the plastic work per volume, J/m3."""
        return (initial + 0.5 * self.modulus * strain) * strain


@attrs.frozen
class SwiftHardening(Hardening):
    r"""A yield stress that grows as a power of the strain: :math:`Y = Y_0 (1 + \kappa / \kappa_0)^n`.

    Parameters
    ----------
    strain
        The strain :math:`\kappa_0`, above zero, of a pre-stretched material that hardens from nothing.
    power
        The power n, from 0 to 1.

    References
    ----------
    Swift, J. Mech. Phys. Solids 1 (1952) 1-18, https://doi.org/10.1016/0022-5096(52)90002-1

    Examples
    --------
    >>> from roughcontact_volume import SwiftHardening
    >>> SwiftHardening(strain=0.005, power=0.5).find_yield_stress(1e9, 0.015)
    2000000000.0
    """

    strain: float = attrs.field(converter=_strain, metadata={"unit": ""})
    power: float = attrs.field(converter=_power, metadata={"unit": ""})

    def find_yield_stress(self, initial: float, strain: Array) -> Array:
        """Return the yield stress, Pa; see `Hardening.find_yield_stress`."""
        return initial * (1.0 + strain / self.strain) ** self.power

    def find_slope(self, initial: float, strain: Array) -> Array:
        """Return its derivative, Pa."""
        return initial * self.power / self.strain * (1.0 + strain / self.strain) ** (self.power - 1.0)

    def find_work(self, initial: float, strain: Array) -> Array:
        """Return the plastic work per volume, J/m3."""
        power = self.power + 1.0
        return initial * self.strain / power * np.expm1(power * np.log1p(strain / self.strain))


@attrs.frozen
class LudwikHardening(Hardening):
    r"""A yield stress to which a power of the strain is added: :math:`Y = Y_0 + B \kappa^n`.

    It is the static part of the model of Johnson and Cook, with the constants :math:`A = Y_0`, B and n. Its slope is
    unbounded at a strain of zero: up to 1e-4, a twentieth of the 0.2 % at which yield stresses are read, it rises
    straight.

    Parameters
    ----------
    modulus
        The stress B that a strain of one adds, Pa, at least zero.
    power
        The power n, above zero, at most 1.

    References
    ----------
    Johnson, Cook, Eng. Fract. Mech. 21 (1985) 31-48, https://doi.org/10.1016/0013-7944(85)90052-9

    Examples
    --------
    >>> from roughcontact_volume import LudwikHardening
    >>> f"{LudwikHardening('300MPa', power=0.5).find_yield_stress(100e6, 0.25) / 1e6:.0f} MPa"
    '250 MPa'
    """

    modulus: float = attrs.field(converter=_ludwik_modulus, metadata={"unit": "Pa"})
    power: float = attrs.field(converter=_ludwik_power, metadata={"unit": ""})

    @property
    def _first_slope(self) -> float:
        return float(self.modulus * _STRAIGHT ** (self.power - 1.0))

    def find_yield_stress(self, initial: float, strain: Array) -> Array:
        """Return the yield stress, Pa; see `Hardening.find_yield_stress`."""
        power = self.modulus * np.maximum(strain, _STRAIGHT) ** self.power
        return initial + np.where(strain < _STRAIGHT, self._first_slope * strain, power)

    def find_slope(self, initial: float, strain: Array) -> Array:
        """Return its derivative, Pa."""
        power = self.power * self.modulus * np.maximum(strain, _STRAIGHT) ** (self.power - 1.0)
        return np.asarray(np.where(strain < _STRAIGHT, self._first_slope, power))

    def find_work(self, initial: float, strain: Array) -> Array:
        """Return the plastic work per volume, J/m3."""
        power = self.power + 1.0
        straight = 0.5 * self._first_slope * np.minimum(strain, _STRAIGHT) ** 2
        beyond = self.modulus / power * (np.maximum(strain, _STRAIGHT) ** power - _STRAIGHT**power)
        return np.asarray(initial * strain + straight + beyond)


@attrs.frozen
class VoceHardening(Hardening):
    r"""A yield stress that approaches a limit: :math:`Y = Y_\infty - (Y_\infty - Y_0) e^{-\kappa / \kappa_0}`.

    Parameters
    ----------
    saturation
        The limit, Pa, at least the yield stress of the material.
    strain
        The strain :math:`\kappa_0` over which what is left to it falls to 1/e.

    References
    ----------
    Voce, J. Inst. Metals 74 (1948) 537-562.

    Examples
    --------
    >>> from roughcontact_volume import VoceHardening
    >>> f"{VoceHardening('2GPa', strain=0.05).find_yield_stress(1e9, 0.05) / 1e9:.3f} GPa"
    '1.632 GPa'
    """

    saturation: float = attrs.field(converter=_saturation, metadata={"unit": "Pa"})
    strain: float = attrs.field(converter=_strain, metadata={"unit": ""})

    def find_yield_stress(self, initial: float, strain: Array) -> Array:
        """Return the yield stress, Pa; see `Hardening.find_yield_stress`."""
        return initial - (self.saturation - initial) * np.expm1(-strain / self.strain)

    def find_slope(self, initial: float, strain: Array) -> Array:
        """Return its derivative, Pa."""
        return (self.saturation - initial) / self.strain * np.exp(-strain / self.strain)

    def find_work(self, initial: float, strain: Array) -> Array:
        """Return the plastic work per volume, J/m3."""
        rest = (self.saturation - initial) * self.strain
        return self.saturation * strain + rest * np.expm1(-strain / self.strain)

    def require_fitting(self, initial: float) -> None:
        """Raise `InputError` if the limit is below the yield stress."""
        if self.saturation < initial:
            raise rc.InputError.about(
                "The stress at which hardening ends", self.saturation, f"at least the yield stress, {initial:g} Pa"
            )


@attrs.frozen
class TabulatedHardening(Hardening):
    """A yield stress from a table, as of a compression test, straight between its points; behind them it is constant.

    Parameters
    ----------
    strain
        Accumulated plastic strains (true ones), rising, shape (n,).
    stress
        The true stresses there, Pa, which do not fall, shape (n,). The first point is the yield stress at a strain of
        zero, or one behind it.

    Examples
    --------
    >>> from roughcontact_volume import Plastic, TabulatedHardening
    >>> table = TabulatedHardening(strain=[0.01, 0.1], stress=["300MPa", "400MPa"])
    >>> print(Plastic("210GPa", 0.3, "200MPa", table).find_yield_stress(0.005))
    250000000.0
    """

    strain: tuple[float, ...] = attrs.field(converter=_strains, metadata={"unit": ""})
    stress: tuple[float, ...] = attrs.field(converter=_stresses, metadata={"unit": "Pa"})

    def __attrs_post_init__(self) -> None:
        if not 0 < len(self.strain) == len(self.stress):
            raise rc.InputError(
                f"A table of hardening has a stress for each strain, but there are {len(self.strain)} strains and "
                f"{len(self.stress)} stresses."
            )
        if np.any(np.diff(self.strain) <= 0.0) or np.any(np.diff(self.stress) < 0.0):
            raise rc.InputError(
                "The strains of a table of hardening must rise, and its stresses must not fall: a material that "
                "softens flows in bands as thin as a cell, which are not computed."
            )

    def require_fitting(self, initial: float) -> None:
        """Raise `InputError` if a stress is below the yield stress, or the first one contradicts it."""
        first = self.stress[0]
        if first < initial or (self.strain[0] == 0.0 and first != initial):
            raise rc.InputError(
                f"The table of hardening begins with {first:g} Pa at a plastic strain of {self.strain[0]:g}, which "
                f"contradicts the yield stress of {initial:g} Pa."
            )

    def find_yield_stress(self, initial: float, strain: Array) -> Array:
        """Return the yield stress, Pa; see `Hardening.find_yield_stress`."""
        return np.interp(strain, *self._list_points(initial))

    def find_slope(self, initial: float, strain: Array) -> Array:
        """Return its derivative, Pa, at a point of the table that behind it."""
        strains, stresses = self._list_points(initial)
        slopes = np.append(np.diff(stresses) / np.diff(strains), 0.0)
        return np.asarray(slopes[np.searchsorted(strains, strain, side="right") - 1])

    def find_work(self, initial: float, strain: Array) -> Array:
        """Return the plastic work per volume, J/m3."""
        strains, stresses = self._list_points(initial)
        until = np.append(0.0, np.cumsum(0.5 * (stresses[1:] + stresses[:-1]) * np.diff(strains)))
        piece = np.searchsorted(strains, strain, side="right") - 1
        here = self.find_yield_stress(initial, strain)
        return np.asarray(until[piece] + 0.5 * (stresses[piece] + here) * (strain - strains[piece]))

    def _list_points(self, initial: float) -> tuple[Array, Array]:
        before = 0 if self.strain[0] == 0.0 else 1
        strains = np.array((0.0,) * before + self.strain)
        return strains, np.array((initial,) * before + self.stress)
