"""Laws of friction: the shear strength of a contact as a function of the pressure."""

from __future__ import annotations

import abc

import attrs
import numpy as np

from roughcontact._base.arrays import Array, RealArray, restore_state
from roughcontact._base.checks import Part, number_or_array
from roughcontact._base.registry import Registry
from roughcontact.errors import InputError


class FrictionLaw(Part, abc.ABC):
    """The shear traction, Pa, at which the surfaces slip, as a function of the pressure, Pa.

    A class of your own gives the limit of each cell from the pressure there: zero without pressure, and not falling
    with it. Arrays in the fields of an attrs class, of the grid's shape (nx, ny), make it vary from cell to cell.

    Examples
    --------
    >>> import numpy as np
    >>> import roughcontact as rc
    >>> class Saturating(rc.FrictionLaw):
    ...     def limit(self, pressure):
    ...         return 50e6 * np.tanh(0.4 * pressure / 50e6)
    >>> [f"{limit / 1e6:.1f} MPa" for limit in Saturating().limit(np.array([0.0, 50e6, 500e6]))]
    ['0.0 MPa', '19.0 MPa', '50.0 MPa']
    """

    @abc.abstractmethod
    def limit(self, pressure: RealArray) -> RealArray:
        """Return the shear strength at a pressure of at least zero, Pa: not negative, of the shape of the pressure."""


frictions = Registry(FrictionLaw, "friction law", "roughcontact.frictions")


def shear_limit(law: FrictionLaw, pressure: Array) -> Array:
    """Return the limit of the shear traction on each cell, Pa, shape (nx, ny), checked.

    Parameters
    ----------
    law
        The friction law.
    pressure
        Pressure, Pa, shape (nx, ny).

    Raises
    ------
    InputError
        If the limit is of another shape, not finite, negative, or above zero where there is no pressure.
    """
    shape = pressure.shape
    limit = np.asarray(law.limit(pressure), dtype=np.float64)
    if limit.shape != shape:
        raise InputError(
            f"The friction law {law!r} has limits of shape {limit.shape}, where those of the grid, {shape}, are needed."
        )
    if not (np.isfinite(limit).all() and limit.min() >= 0.0):
        raise InputError(f"The friction law {law!r} has limits that are negative or not finite.")
    if limit[pressure <= 0.0].any():
        raise InputError(f"The friction law {law!r} has a limit above zero where there is no pressure.")
    return limit


def _fitting(parameter: float | Array, pressure: RealArray) -> float | Array:
    """Return a parameter; `InputError` if it is an array of another shape than the pressure."""
    if isinstance(parameter, np.ndarray) and parameter.shape != np.shape(pressure):
        raise InputError(
            f"The friction varies over cells of shape {parameter.shape}, but the pressure has shape "
            f"{np.shape(pressure)}."
        )
    return parameter


def _coefficient(value: object) -> float | Array:
    return number_or_array(value, "The coefficient of friction", zero=True)


def _strength(value: object) -> float | Array:
    return number_or_array(value, "The shear strength", "Pa")


@attrs.frozen(eq=False)
class Coulomb(FrictionLaw):
    r"""Shear strength in proportion to the pressure, :math:`s = \mu p`, as found by Amontons and Coulomb.

    Parameters
    ----------
    coefficient
        Coefficient of friction :math:`\mu`, at least zero: a number, or an array of the grid's shape (nx, ny).

    Examples
    --------
    >>> import numpy as np
    >>> import roughcontact as rc
    >>> print(f"{rc.Coulomb(0.3).limit(np.array([100e6]))[0] / 1e6:g} MPa")
    30 MPa
    """

    coefficient: float | Array = attrs.field(converter=_coefficient, metadata={"unit": ""})

    __setstate__ = restore_state

    def limit(self, pressure: RealArray) -> RealArray:
        """Return the shear strength, Pa; see `FrictionLaw.limit`."""
        return np.asarray(_fitting(self.coefficient, pressure) * pressure)


@attrs.frozen(eq=False)
class LimitedCoulomb(FrictionLaw):
    r"""Coulomb's law up to the shear strength of the softer body, :math:`s = \min(\mu p, k)`.

    Parameters
    ----------
    coefficient
        Coefficient of friction :math:`\mu`, at least zero: a number, or an array of the grid's shape (nx, ny).
    strength
        Maximum k, Pa, above zero: a number, a text such as ``"200MPa"``, or an array (nx, ny).

    Examples
    --------
    >>> import numpy as np
    >>> import roughcontact as rc
    >>> law = rc.LimitedCoulomb(0.3, strength="200MPa")
    >>> [f"{limit / 1e6:g} MPa" for limit in law.limit(np.array([100e6, 1e9]))]
    ['30 MPa', '200 MPa']
    """

    coefficient: float | Array = attrs.field(converter=_coefficient, metadata={"unit": ""})
    strength: float | Array = attrs.field(converter=_strength, metadata={"unit": "Pa"})

    __setstate__ = restore_state

    def limit(self, pressure: RealArray) -> RealArray:
        """Return the shear strength, Pa; see `FrictionLaw.limit`."""
        return np.minimum(_fitting(self.coefficient, pressure) * pressure, _fitting(self.strength, pressure))
