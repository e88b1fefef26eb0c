"""The bodies in which regions below a surface are solved."""

from __future__ import annotations

from typing import Any

import roughcontact as rc

_KERNELS = (rc.Love, rc.FourierHalfSpace)


def require_uniform(problem: Any, material: Any, what: str) -> None:
    """Raise `InputError` unless a body, of which something is a part, is uniform and elastic."""
    if type(material) is not rc.Elastic:
        raise rc.InputError(
            f"{what} lies in an Elastic body, but its material is {material!r}: a body that yields, relaxes or has a "
            "hardness is not solved with it."
        )
    kernel = problem.plan.kernel
    if not isinstance(kernel, _KERNELS):
        raise rc.InputError(
            f"The stress below the surface is known for a homogeneous half-space, but not for the kernel {kernel!r}: "
            "omit kernel=, or what lies below the surface."
        )
