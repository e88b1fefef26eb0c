"""The laws that materials bring to a path of loads: their flattening, and their relaxation."""

from __future__ import annotations

from typing import TypeVar

import attrs
import numpy as np

from roughcontact._parts.materials import Viscoelastic
from roughcontact._solve.problem.scene import Scene
from roughcontact._solve.solution import Flattening, Relaxation, find_softer

S = TypeVar("S", bound=Scene)


def remember_flattening(problem: S) -> S:
    """Return the problem with a law that remembers how far it is flattened, if its pressure has a limit."""
    is_known = any(isinstance(law, Flattening) for law in problem.laws)
    if is_known or not np.isfinite(problem.plan.pressure_limit).any():
        return problem
    return attrs.evolve(problem, laws=(*problem.laws, Flattening()))


def remember_both(problem: S) -> S:
    """Return the problem of bodies that move, each of which remembers how far it is flattened if both are."""
    has_limit = np.isfinite(problem.plan.pressure_limit).any()
    if not has_limit or find_softer(problem) in (0.0, 1.0):
        return problem
    laws = (attrs.evolve(law, both=True) if isinstance(law, Flattening) else law for law in problem.laws)
    return attrs.evolve(problem, laws=tuple(laws))


def remember_changes(problem: S) -> S:
    """Return the problem with the laws that its materials bring: flattening, and relaxation."""
    sides = (problem.body.material, problem.counterbody.material)
    relaxing = [material if isinstance(material, Viscoelastic) else None for material in sides]
    is_known = not all(law.keeps_modulus for law in problem.laws)
    if any(relaxing) and not is_known:
        problem = attrs.evolve(problem, laws=(*problem.laws, Relaxation(*relaxing)))
    return remember_flattening(problem)
