"""Isotropic materials: elastic, elastic-perfectly plastic and rigid."""

from __future__ import annotations

import math

import attrs
import numpy as np

from roughcontact._base.checks import LARGEST, SMALLEST, Array, frozen_array, number
from roughcontact._base.checks.pickling import restore_state
from roughcontact._parts.materials.base import Material
from roughcontact.errors import InputError


def _young(value: float) -> float:
    return number(value, "Young's modulus", "Pa", above=0.0)


def _poisson(value: float) -> float:
    return number(value, "Poisson's ratio", above=-1.0, at_most=0.5)


def _hardness(value: float | Array) -> float | Array:
    if not isinstance(value, (list, tuple)) and np.ndim(value) == 0:
        return number(value, "The hardness", "Pa", above=0.0)
    try:
        array = np.array(value)
    except ValueError:
        array = np.empty(0)
    is_real = array.ndim == 2 and array.size > 0 and array.dtype.kind in "fiu" and not np.ma.is_masked(value)
    if not (is_real and array.min() >= SMALLEST and array.max() <= LARGEST):
        raise InputError.about("The hardness", value, "a number or an array (nx, ny), finite and above 0 (Pa)")
    return frozen_array(array)


@attrs.frozen
class Elastic(Material):
    """Homogeneous, isotropic, linear elastic half-space.

    Parameters
    ----------
    young
        Young's modulus, Pa, above zero.
    poisson
        Poisson's ratio, above -1 and at most 0.5.

    Examples
    --------
    >>> import roughcontact as rc
    >>> steel = rc.Elastic(young=210e9, poisson=0.3)
    >>> print(f"{steel.young / 1e9:g} GPa")
    210 GPa
    """

    young: float = attrs.field(converter=_young, metadata={"unit": "Pa"})
    poisson: float = attrs.field(converter=_poisson, metadata={"unit": ""})

    @property
    def compliance(self) -> float:
        """Plane-strain compliance (1 - nu^2) / E, 1/Pa."""
        return (1.0 - self.poisson**2) / self.young

    @property
    def pressure_limit(self) -> float:
        """Infinite."""
        return math.inf


@attrs.frozen(eq=False)
class ElasticPerfectlyPlastic(Material):
    """Elastic until the contact pressure reaches the hardness, which it never exceeds.

    The displacement is that of the elastic half-space under the limited pressure; where the limit is reached, the
    surfaces may overlap by the plastic flattening.

    Parameters
    ----------
    young
        Young's modulus, Pa, above zero.
    poisson
        Poisson's ratio, above -1 and at most 0.5.
    hardness
        Contact pressure at full plasticity, Pa, above zero: a number, or an array of the grid's shape (nx, ny).

    Examples
    --------
    >>> import roughcontact as rc
    >>> steel = rc.ElasticPerfectlyPlastic(young=210e9, poisson=0.3, hardness=2e9)
    >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), steel)
    >>> problem = rc.ContactProblem(ball, grid=rc.Grid((32, 32), 100e-6))
    >>> print(f"{problem.solve(force=3.0).pressure.max() / 1e9:g} GPa")
    2 GPa
    """

    young: float = attrs.field(converter=_young, metadata={"unit": "Pa"})
    poisson: float = attrs.field(converter=_poisson, metadata={"unit": ""})
    hardness: float | Array = attrs.field(converter=_hardness, metadata={"unit": "Pa"})

    __setstate__ = restore_state

    @property
    def compliance(self) -> float:
        """Plane-strain compliance (1 - nu^2) / E, 1/Pa."""
        return (1.0 - self.poisson**2) / self.young

    @property
    def pressure_limit(self) -> float | Array:
        """The hardness, Pa."""
        return self.hardness


@attrs.frozen
class Rigid(Material):
    """A body that does not deform.

    Examples
    --------
    >>> import roughcontact as rc
    >>> rigid = rc.Body(rc.SphereSurface(radius=1e-3), rc.Rigid())
    >>> rubber = rc.Body(rc.FlatSurface(), rc.Elastic(young=2e6, poisson=0.5))
    >>> problem = rc.ContactProblem(rigid, rubber, grid=rc.Grid((32, 32), 200e-6))
    >>> print(problem.solve(force=1e-5).area())
    (625.924 +- 0.014) µm2, (1.564811 +- 0.000035) % of nominal [blend]
    """

    @property
    def compliance(self) -> float:
        """Zero."""
        return 0.0

    @property
    def pressure_limit(self) -> float:
        """Infinite."""
        return math.inf
