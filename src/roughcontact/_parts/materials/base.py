"""The material interface, and the contact modulus and pressure limit of two materials."""

from __future__ import annotations

import abc
import math

import numpy as np

from roughcontact._base.checks import Array, number
from roughcontact._base.registry import Registry
from roughcontact.errors import InputError


class Material(abc.ABC):
    """The material of a body; a class of your own gives its compliance and its pressure limit.

    Examples
    --------
    >>> import roughcontact as rc
    >>> class Cork(rc.Material):
    ...     compliance = 1.0 / 20e6
    ...     pressure_limit = 1e6
    >>> rc.Body(rc.FlatSurface(), Cork()).material.pressure_limit
    1000000.0
    """

    @property
    @abc.abstractmethod
    def compliance(self) -> float:
        """Plane-strain compliance (1 - nu^2) / E, 1/Pa; zero for a rigid body."""

    @property
    @abc.abstractmethod
    def pressure_limit(self) -> float | Array:
        """Maximum contact pressure, Pa, a number or an array of the grid's shape (nx, ny); `math.inf` if unlimited."""


materials = Registry(Material, "material", "roughcontact.materials")


def contact_modulus(one: Material, other: Material) -> float:
    """Return the contact modulus E*, Pa.

    1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2: the plane-strain moduli, not Young's moduli.

    Raises
    ------
    InputError
        If both bodies are rigid, or a compliance is not a finite number of at least zero.
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


def combined_pressure_limit(one: Material, other: Material) -> Array:
    """Return the maximum contact pressure, shape () or (nx, ny), Pa: that of the softer body.

    Raises
    ------
    InputError
        If a pressure limit is not positive, or those of the bodies differ in shape.
    """
    limits = [np.asarray(material.pressure_limit) for material in (one, other)]
    for limit in limits:
        if limit.dtype.kind not in "fiu" or not np.all(limit > 0.0):
            raise InputError.about("The pressure limit of a material", limit, "a number above 0, or inf (Pa)")
    shapes = {limit.shape for limit in limits if limit.ndim}
    if len(shapes) > 1:
        raise InputError(f"The pressure limits of the bodies are arrays of different shapes, {sorted(shapes)}.")
    softer = np.asarray(np.minimum(*limits), dtype=np.float64)
    softer.flags.writeable = False
    return softer
