"""The tangential compliance of two materials, and how far it is independent of the normal one."""

from __future__ import annotations

from collections.abc import Sequence

from roughcontact._base.checks import number
from roughcontact._base.warnings import ContactWarning
from roughcontact._parts.materials import Material
from roughcontact.errors import InputError

# Dundurs' second constant below which normal and tangential displacement count as uncoupled.
_UNCOUPLED = 0.01


def compare_compliances(materials: Sequence[Material], modulus: float, cosine: float = 0.5) -> float:
    r"""Return the tangential over the normal compliance of two half-spaces, from 1 (nu = 0) to 3/2 (nu = 1/2).

    .. math:: E^*\sum_i\frac{2-\nu_i}{4G_i} = E^*\sum_i\frac{2-\nu_i}{2(1-\nu_i)}\,\frac{1-\nu_i^2}{E_i}

    A pressure wave at an angle to the force has its `cosine`, squared, in place of 1/2.

    Raises
    ------
    InputError
        If the Poisson's ratio of a material that deforms is not known.
    """
    parts = ((1.0 - nu * cosine) / (1.0 - nu) * compliance for nu, compliance in map(_constants, materials))
    return modulus * sum(parts)


def dundurs_beta(materials: Sequence[Material], modulus: float) -> float:
    r"""Return Dundurs' second constant, by which normal and tangential displacement are coupled.

    .. math:: \beta = \frac{E^*}{2}\left[\frac{1-2\nu_1}{2G_1} - \frac{1-2\nu_2}{2G_2}\right]

    References
    ----------
    Johnson, Contact Mechanics (1985), eq. 5.3, https://doi.org/10.1017/CBO9781139171731
    """
    one, other = ((1.0 - 2.0 * nu) / (1.0 - nu) * compliance for nu, compliance in map(_constants, materials))
    return 0.5 * modulus * (one - other)


def judge_coupling(materials: Sequence[Material], modulus: float) -> tuple[str, ...]:
    """Return a warning if one of the bodies is rigid and the other is not incompressible; else nothing.

    Raises
    ------
    InputError
        If both bodies deform, and normal and tangential displacement are coupled.
    """
    beta = dundurs_beta(materials, modulus)
    if abs(beta) <= _UNCOUPLED:
        return ()
    if min(material.compliance for material in materials) > 0.0:
        raise InputError(
            f"The bodies are of different materials, Dundurs' beta is {beta:.3g}, so that normal and tangential "
            "displacement are coupled and partial slip does not follow from normal contact. To neglect that, give one "
            "body the contact modulus E* of the pair, Elastic(E* (1 - nu^2), nu), and make the other Rigid()."
        )
    text = (
        f"one of the bodies is rigid: the results are those of two bodies of like materials with the same contact "
        f"modulus. The coupling of normal and tangential displacement, Dundurs' beta = {abs(beta):.2g}, is neglected"
    )
    return (ContactWarning(text, "coupling", abs(beta)),)


def _constants(material: Material) -> tuple[float, float]:
    """Return Poisson's ratio and the plane-strain compliance, 1/Pa."""
    compliance = material.compliance
    if compliance == 0.0:
        return 0.0, 0.0
    poisson = getattr(material, "poisson", None)
    if poisson is None:
        raise InputError(
            f"The tangential compliance needs Poisson's ratio: give the class {type(material).__name__} "
            "an attribute `poisson`."
        )
    return number(poisson, "Poisson's ratio", above=-1.0, at_most=0.5), compliance
