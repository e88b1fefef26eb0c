"""Claims about materials."""

from __future__ import annotations

import attrs
import numpy as np

from roughcontact.body import Body
from roughcontact.checks import number
from roughcontact.grid import Grid
from roughcontact.materials import Elastic, Material, Rigid, contact_modulus, pressure_limit
from roughcontact.problem import ContactProblem
from roughcontact.surfaces import ParaboloidSurface
from roughcontact.testing.claim import Claim, require
from roughcontact.testing.common import common, pickled

_COUNTER = Elastic(1e9, 0.3)


def _compliance(material: Material) -> str:
    found = number(material.compliance, "The compliance", "1/Pa", at_least=0.0)
    require(material.compliance == found, "asked again, it is another")
    together = contact_modulus(material, _COUNTER)
    require(together <= contact_modulus(Rigid(), _COUNTER), "with it a pair is stiffer than with a rigid body")
    return f"{found:g} 1/Pa" if found else "rigid"


def _limit(material: Material) -> str:
    limit = material.pressure_limit
    require(np.ndim(limit) in (0, 2), f"an array of {np.ndim(limit)} dimensions is neither a number nor a map")
    softer = pressure_limit(material, Rigid())
    require(np.array_equal(softer, pressure_limit(Rigid(), material)), "it depends on which body comes first")
    if np.isinf(softer).all():
        return "none"
    return f"{np.min(softer):g} Pa" if np.ndim(softer) == 0 else f"{np.min(softer):g} to {np.max(softer):g} Pa"


def _frozen(material: Material) -> str:
    # A solution names its material: one that changes later would make it a lie.
    kind: type = type(material)
    fields = [field.name for field in attrs.fields(kind)] if attrs.has(kind) else []
    for name in ("compliance", "pressure_limit", *fields):
        try:
            setattr(material, name, getattr(material, name))
        except (AttributeError, TypeError):
            continue
        require(False, f"{name} can be set")
    limit = material.pressure_limit
    require(not isinstance(limit, np.ndarray) or not limit.flags.writeable, "the map of limits can be written to")
    return "cannot be changed"


def _travels(material: Material) -> str:
    copy = pickled(material)
    same = copy.compliance == material.compliance and np.array_equal(copy.pressure_limit, material.pressure_limit)
    require(same, "its copy has another compliance or limit")
    return "a copy has the same compliance and limit"


def _bears(material: Material) -> str:
    limit = material.pressure_limit
    shape = limit.shape if isinstance(limit, np.ndarray) else (16, 16)
    grid = Grid((shape[0], shape[1]), (shape[0] * 1e-6, shape[1] * 1e-6))
    body, other = Body(ParaboloidSurface(1e-4), material), Body(ParaboloidSurface(1e-3), _COUNTER)
    problem = ContactProblem(body, other, grid=grid)
    solution = problem.solve(approach=0.1 * float(problem.undeformed.max()))
    require((solution.pressure <= limit).all(), "a contact has pressures above its limit")
    require(problem.plan.modulus == contact_modulus(_COUNTER, material), "it matters which body comes first")
    return f"a contact at {solution.mean_pressure:.3g} Pa, {np.count_nonzero(solution.saturated)} cells at the limit"


CLAIMS = (
    Claim("material", "compliance", _compliance),
    Claim("material", "pressure limit", _limit),
    Claim("material", "frozen", _frozen),
    Claim("material", "same after a journey", _travels),
    Claim("material", "bears a contact", _bears),
    *common("material"),
)
