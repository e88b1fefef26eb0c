"""The material interface, and what two materials make together."""

from __future__ import annotations

import abc
import math

import numpy as np

from roughcontact.checks import Array, number
from roughcontact.errors import InputError


class Material(abc.ABC):
    """What a body is made of. Subclass it and say two numbers."""

    @property
    @abc.abstractmethod
    def compliance(self) -> float:
        """Plane-strain compliance (1 - nu^2) / E, 1/Pa; zero for a rigid body."""

    @property
    @abc.abstractmethod
    def pressure_limit(self) -> float | Array:
        """Greatest contact pressure that the surface bears, Pa; `math.inf` where there is none.

        A number, or an array of the grid's shape (nx, ny) where it differs from place to place.
        """


def contact_modulus(one: Material, other: Material) -> float:
    """Return the contact modulus E*, Pa.

    1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2: the plane-strain moduli, not Young's moduli.

    Raises
    ------
    InputError
        If both bodies are rigid, or a compliance is no finite number of at least zero.
    """
    compliance = sum(
        number(material.compliance, "The compliance of a material", "1/Pa", at_least=0.0) for material in (one, other)
    )
    if compliance == 0.0:
        raise InputError("Both bodies are rigid, so nothing can deform: make one of them Elastic(young, poisson).")
    modulus = 1.0 / compliance
    if not math.isfinite(modulus):
        raise InputError.about("The contact modulus E*", modulus, "a finite number (Pa)", "The bodies are too stiff.")
    return modulus


def pressure_limit(one: Material, other: Material) -> float | Array:
    """Return the greatest contact pressure, Pa, a number or an array: that of the softer body.

    Raises
    ------
    InputError
        If a limit is not positive.
    """
    limits = (one.pressure_limit, other.pressure_limit)
    for limit in limits:
        array = np.asarray(limit)
        if array.dtype.kind not in "fiu" or not np.all(array > 0.0):
            raise InputError.about("The pressure limit of a material", limit, "a number above 0, or inf (Pa)")
    softer = np.minimum(*limits)
    return float(softer) if np.ndim(softer) == 0 else np.asarray(softer, dtype=np.float64)


def plane_strain_compliance(young: float, poisson: float) -> float:
    """Return (1 - nu^2) / E, 1/Pa."""
    return (1.0 - poisson**2) / young


def young_modulus(value: float) -> float:
    """Check Young's modulus, Pa."""
    return number(value, "Young's modulus", "Pa", above=0.0)


def poisson_ratio(value: float) -> float:
    """Check Poisson's ratio."""
    return number(value, "Poisson's ratio", above=-1.0, at_most=0.5)
