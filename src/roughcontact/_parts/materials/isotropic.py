"""Materials: the interface, and isotropic ones."""

from __future__ import annotations

import abc
import math
from typing import Any, ClassVar

import attrs
import numpy as np

from roughcontact._base.arrays import Array, read_only, restore_state
from roughcontact._base.checks import Part, number, number_or_array
from roughcontact._base.units import Quantity
from roughcontact.errors import InputError
from roughcontact.errors.door import guarded

# Dundurs' second constant, in magnitude, up to which normal and tangential displacement count as uncoupled.
MAX_UNCOUPLED_BETA = 0.01


class Material(Part, abc.ABC):
    """The material of a body; a class of your own gives its compliance and its pressure limit.

    Attributes
    ----------
    is_isotropic
        Whether its response is the same in all directions along the surface. If not, the compliance is their mean, and
        a solution by a kernel that does not know the directions warns.

    Examples
    --------
    >>> import roughcontact as rc
    >>> class Cork(rc.Material):
    ...     compliance = 1.0 / 20e6
    ...     pressure_limit = 1e6
    >>> rc.Body(rc.FlatSurface(), Cork()).material.pressure_limit
    1000000.0
    """

    is_isotropic: ClassVar[bool] = True

    @property
    @abc.abstractmethod
    def compliance(self) -> float:
        """Plane-strain compliance (1 - nu^2) / E, 1/Pa; zero for a rigid body."""

    @property
    @abc.abstractmethod
    def pressure_limit(self) -> float | Array:
        """Maximum contact pressure, Pa, a number or an array of the grid's shape (nx, ny); `math.inf` if unlimited."""

    def bring_laws(self, side: str) -> tuple[Any, ...]:
        """Return the laws that it brings to each problem in which it is that of a side; by default none.

        Parameters
        ----------
        side
            ``"body"`` or ``"counterbody"``.

        Returns
        -------
        tuple
            Laws (`Law`) of classes with `Law.of_material`, such as a process by which the material yields.
        """
        return ()


def contact_modulus(one: Material, other: Material) -> float:
    """Return the contact modulus E*, Pa.

    1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2: the plane-strain moduli, not Young's moduli. `InputError` if both bodies are
    rigid, or a compliance is not a finite number of at least zero.
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


def _beta(value: float) -> float:
    return number(value, "Dundurs' beta", above=-1.0, at_most=1.0)


def _gamma(value: float) -> float:
    return number(value, "The constant gamma of a pair of materials", above=-1.0)


@attrs.frozen
class PairConstants:
    r"""The two numbers by which unlike half-spaces respond to shear, beside their contact modulus E*.

    With p the pressure, q the shear on the body (minus that on the counterbody), the displacement u_z towards the
    insides, the other components those of the body minus those of the counterbody, and n the direction of a wave
    of wave number k,

    .. math:: \begin{aligned}
       \hat u_z &= \frac{2}{E^* k} \left(\hat p - i \beta\, n_b \hat q_b\right) \\
       \hat u_a &= \frac{2}{E^* k} \left[\left((1 + \gamma)\,\delta_{ab} - \gamma\, n_a n_b\right) \hat q_b
       + i \beta\, n_a \hat p\right] \end{aligned}

    Parameters
    ----------
    beta
        Dundurs' second constant, which couples pressure and shear:

        .. math:: \beta = \frac{E^*}{2} \left[\frac{1 - 2\nu_1}{2 G_1} - \frac{1 - 2\nu_2}{2 G_2}\right]

        Zero for like materials, at most 1/2 in size if no Poisson's ratio is negative.
    gamma
        By how much a wave of shear across its normal displaces more than one along it:

        .. math:: \gamma = E^* \left[\frac{\nu_1}{2 G_1} + \frac{\nu_2}{2 G_2}\right]

        nu / (1 - nu) for like materials.

    References
    ----------
    Johnson, Contact Mechanics (1985), eq. 5.3, https://doi.org/10.1017/CBO9781139171731
    """

    beta: float = attrs.field(default=0.0, converter=_beta)
    gamma: float = attrs.field(default=0.0, converter=_gamma)


@guarded
def pair_constants(one: Material, other: Material) -> PairConstants:
    """Return the constants of a body on a counterbody.

    Raises
    ------
    InputError
        If Poisson's ratio of a material that deforms is not known, or both bodies are rigid.

    Examples
    --------
    >>> import roughcontact as rc
    >>> from roughcontact.typing import pair_constants
    >>> pair = pair_constants(rc.Elastic(70e9, 0.33), rc.Elastic(210e9, 0.3))
    >>> print(f"beta {pair.beta:.3f}, gamma {pair.gamma:.3f}")
    beta 0.117, gamma 0.476
    """
    modulus = contact_modulus(one, other)
    ratios = [_poisson_of(material) for material in (one, other)]
    # E*/(2 G) of each.
    halves = [modulus * material.compliance / (1.0 - nu) for nu, material in zip(ratios, (one, other), strict=True)]
    beta = 0.5 * ((1.0 - 2.0 * ratios[0]) * halves[0] - (1.0 - 2.0 * ratios[1]) * halves[1])
    return PairConstants(beta, ratios[0] * halves[0] + ratios[1] * halves[1])


def _poisson_of(material: Material) -> float:
    """Return Poisson's ratio, zero for a rigid body."""
    if material.compliance == 0.0:
        return 0.0
    poisson = getattr(material, "poisson", None)
    if poisson is None:
        raise InputError(
            f"The tangential compliance needs Poisson's ratio: give the class {type(material).__name__} "
            "an attribute `poisson`."
        )
    return poisson_ratio(poisson)


def combined_pressure_limit(one: Material, other: Material) -> Array:
    """Return the pressure limit of the softer body at each cell, shape () or (nx, ny), Pa.

    `InputError` if a pressure limit is not positive, or the limits of the bodies differ in shape.
    """
    limits = [np.asarray(material.pressure_limit) for material in (one, other)]
    for limit in limits:
        if limit.dtype.kind not in "fiu" or not np.all(limit > 0.0):
            raise InputError.about("The pressure limit of a material", limit, "a number above 0, or inf (Pa)")
    shapes = {limit.shape for limit in limits if limit.ndim}
    if len(shapes) > 1:
        raise InputError(f"The pressure limits of the bodies are arrays of different shapes, {sorted(shapes)}.")
    return read_only(np.asarray(np.minimum(*limits), dtype=np.float64))


def _young(value: Quantity) -> float:
    return number(value, "Young's modulus", "Pa", above=0.0)


def poisson_ratio(value: Quantity) -> float:
    """Return Poisson's ratio, checked to be above -1 and at most 0.5."""
    return number(value, "Poisson's ratio", above=-1.0, at_most=0.5)


def _hardness(value: Quantity | Array) -> float | Array:
    return number_or_array(value, "The hardness", "Pa")


# Without its own state for pickles: a subclass whose arrays are restored would keep the fields of this class alone.
@attrs.frozen(getstate_setstate=False)
class _Isotropic(Material):
    """A material of two elastic constants."""

    young: float = attrs.field(converter=_young, metadata={"unit": "Pa"})
    poisson: float = attrs.field(converter=poisson_ratio, metadata={"unit": ""})

    @property
    def compliance(self) -> float:
        """Plane-strain compliance (1 - nu^2) / E, 1/Pa."""
        return (1.0 - self.poisson**2) / self.young


@attrs.frozen
class Elastic(_Isotropic):
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

    @property
    def pressure_limit(self) -> float:
        """Infinite."""
        return math.inf


@attrs.frozen(eq=False)
class ElasticPerfectlyPlastic(_Isotropic):
    """Elastic until the contact pressure reaches the hardness, which it never exceeds.

    The limited pressure displaces an elastic half-space; in saturated cells the surfaces may overlap by the plastic
    flattening.

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

    hardness: float | Array = attrs.field(converter=_hardness, metadata={"unit": "Pa"})

    __setstate__ = restore_state

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
    (625.924 +- 0.015) µm2, (1.564811 +- 0.000037) % of nominal [blend]
    """

    @property
    def compliance(self) -> float:
        """Zero."""
        return 0.0

    @property
    def pressure_limit(self) -> float:
        """Infinite."""
        return math.inf
