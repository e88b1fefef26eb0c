"""Which of two bodies a kernel describes, and which part of 1/E* is the other one's."""

from __future__ import annotations

import roughcontact as rc

from roughcontact_layered.stack import Layer

# Fraction of 1/E* by which rounding may make one body softer than both together.
_ROUNDING = 1e-9


def compliance_of_other(name: str, own: float, compliance: float) -> float:
    """Return 1/E* less the part of the body that a kernel describes, at least zero, 1/Pa.

    Parameters
    ----------
    name
        What the kernel describes, the subject of the sentence.
    own, compliance
        1/E* of that body alone, and of both together, 1/Pa.

    Raises
    ------
    roughcontact.InputError
        If that body alone is softer than both together, so that none of them can be made of it.
    """
    other = compliance - own
    if other < -_ROUNDING * compliance:
        raise rc.InputError(
            f"{name} alone is softer (1/E* = {own:g} 1/Pa) than both bodies together ({compliance:g} 1/Pa): give the "
            "kernel the material of its body."
        )
    return max(other, 0.0)


def require_sum(names: list[str], own: list[float], compliance: float) -> None:
    """Refuse two bodies whose 1/E* together is not the sum of what their kernels describe.

    Parameters
    ----------
    names
        The material of each body as its kernel tells it.
    own, compliance
        1/E* of each of them alone, and of the bodies of the contact problem together, 1/Pa.
    """
    if abs(compliance - sum(own)) > _ROUNDING * compliance:
        raise rc.InputError(
            f"The kernels describe bodies of {' and '.join(names)} (1/E* = {sum(own):g} 1/Pa), but those in contact "
            f"have {compliance:g} 1/Pa: give each kernel the material of its body."
        )


def is_made_of(material: rc.Material, own: Layer | rc.Elastic) -> bool:
    """Return whether a material has the elastic constants of a part of a kernel, whatever its pressure limit."""
    constants = (getattr(material, "young", None), getattr(material, "poisson", None))
    return constants == (own.young, own.poisson)
