"""What plastic flow and regions below a surface are not solved with."""

from __future__ import annotations

from typing import Any

import numpy as np
import roughcontact as rc
from roughcontact.errors import argument

from roughcontact_volume.yielding import Yielding

_KERNELS = (rc.Love, rc.FourierHalfSpace)
_INCOMPRESSIBLE = 0.5


def require_possible(problem: Any) -> None:
    """Raise `InputError` where a problem has another part with which plastic flow is not solved."""
    materials = (problem.body.material, problem.counterbody.material)
    if any(np.isfinite(np.asarray(material.pressure_limit)).any() for material in materials):
        raise rc.InputError(
            "A hardness beside a Plastic body would count its flow twice, as the limit of the pressure that the flow "
            "below the surface gives by itself: omit the hardness."
        )
    if any(isinstance(material, rc.Viscoelastic) for material in materials):
        raise rc.InputError("Plastic flow is not solved together with relaxation: make the other body Elastic.")
    if problem.adhesion is not None:
        raise rc.InputError(f"Plastic flow is not solved with {argument('adhesion')}: omit one of them.")
    if any(isinstance(material, Yielding) and material.poisson >= _INCOMPRESSIBLE for material in materials):
        raise rc.InputError("Plastic flow is solved for a Poisson's ratio below 0.5, such as 0.49: choose that.")
    _require_half_space(problem, "make the body Elastic")
    if problem.boundary is rc.Boundary.WRAPPED:
        raise rc.InputError(
            "A wrapped boundary has the nearest images of the pressure alone, which a plastic zone is not solved for: "
            "choose 'free' or 'periodic'."
        )
    if len(problem.laws) > 1:
        others = ", ".join(rc.laws.name_of(type(law)) or repr(law) for law in problem.laws if not law.of_material)
        raise rc.InputError(f"Plastic flow is not solved together with other laws: omit {others}.")


def require_uniform(problem: Any, material: Any, what: str) -> None:
    """Raise `InputError` unless a body, of which something is a part, is uniform and elastic."""
    if type(material) is not rc.Elastic:
        raise rc.InputError(
            f"{what} lies in an Elastic body, but its material is {material!r}: a body that yields, relaxes or has a "
            "hardness is not solved with it."
        )
    _require_half_space(problem, "omit what lies below the surface")


def _require_half_space(problem: Any, otherwise: str) -> None:
    kernel = problem.plan.kernel
    if not isinstance(kernel, _KERNELS):
        raise rc.InputError(
            f"The stress below the surface is known for a homogeneous half-space, but not for the kernel {kernel!r}: "
            f"omit kernel=, or {otherwise}."
        )
