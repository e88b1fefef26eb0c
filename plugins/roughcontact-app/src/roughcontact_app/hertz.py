"""Hertz's closed form beside the answer, where it is of the same contact."""

from __future__ import annotations

import numpy as np
from roughcontact import (
    Boundary,
    ContactSolution,
    Elastic,
    ElasticPerfectlyPlastic,
    FlatSurface,
    Rigid,
    SphereSurface,
)
from roughcontact.reference import hertz_sphere

_MATERIALS = (Elastic, ElasticPerfectlyPlastic, Rigid)
# The closed form is that of a paraboloid: a ball differs from it by the square of this, contact radius over radius.
_MOST_CURVED = 0.1
# What is in a problem of the closed form beside its bodies and its grid.
_PLAIN = {"kernel": "love", "boundary": Boundary.FREE}


def list_closed_form(solution: ContactSolution) -> dict[str, float]:
    """Return what Hertz's closed form says of a contact, in SI units by the names of an answer; or nothing.

    It holds for an elastic ball on a flat, without adhesion, layers and laws, whose contact lies within the domain.

    References
    ----------
    Johnson, Contact Mechanics (1985), sec. 4.2, https://doi.org/10.1017/CBO9781139171731
    """
    ball = _find_ball(solution)
    if ball is None:
        return {}
    found = hertz_sphere(solution.force, ball.radius, solution.modulus)
    radius = found.semi_axes[0]
    if radius > _MOST_CURVED * ball.radius:
        return {}
    stiffness = 2.0 * solution.modulus * radius
    return {
        "contact area": found.area,
        "maximum pressure": found.p_max,
        "approach": found.approach,
        "stiffness": stiffness,
    }


def _find_ball(solution: ContactSolution) -> SphereSurface | None:
    """Return the ball of a contact that the closed form is of; None of any other."""
    problem = {} if solution.origin is None else solution.origin.problem
    bodies = [problem[name] for name in ("body", "counterbody") if name in problem]
    if len(bodies) < 2 or not solution.status.success or not solution.force > 0.0:
        return None
    ball, flat = (body.surface for body in bodies)
    if type(ball) is not SphereSurface or type(flat) is not FlatSurface:
        return None
    if any(problem.get(name) != value for name, value in _PLAIN.items()) or problem.get("adhesion") or solution.added:
        return None
    if any(type(body.material) not in _MATERIALS for body in bodies):
        return None
    # Of what flows, and where the border of the domain cuts the contact, it says nothing.
    highest = float(solution.pressure.max())
    inside = solution.pressure[1:-1, 1:-1]
    is_whole = np.count_nonzero(solution.pressure) == np.count_nonzero(inside)
    is_elastic = all(highest < float(np.min(body.material.pressure_limit)) for body in bodies)
    return ball if is_whole and is_elastic else None
