"""Claims about laws of the interface: of the attraction of surfaces, and of friction."""

from __future__ import annotations

import numpy as np

from roughcontact._base.arrays import Array
from roughcontact._parts.grid import Grid
from roughcontact._parts.interactions import FrictionLaw, Interaction, shear_limit
from roughcontact._parts.materials import Elastic
from roughcontact._parts.surfaces import ParaboloidSurface
from roughcontact._solve.problem import Body, ContactProblem
from roughcontact.testing.claim import (
    DoesNotApply,
    claim,
    claim_input_unchanged,
    claim_repeatable,
    require,
    require_close,
    require_equal,
)

# Gaps at which a law is tried, over its reach, and the step of central differences over the reach.
_GAPS = np.concatenate(([0.0], np.geomspace(1e-4, 1.0, 400)))
_STEP = 1e-6
# Relative error that central differences may have, over the maximum of what they are compared with.
_DIFFERENCE = 1e-4
# Cells of the ball that laws are tried on, and its radius over the reach of the law.
_BALL_CELLS = 24
_RADIUS = 40.0
# Pressures at which a law is tried, Pa.
_PRESSURES = np.concatenate(([0.0], np.geomspace(1.0, 1e11, 119)))


def _resolved(law: Interaction) -> Interaction:
    """Return the law itself, or that of a grid of micrometres on a soft solid."""
    return law.resolve((1e-6, 1e-6), 1e7)


def _shaped_gaps(law: Interaction) -> Array:
    """Return gaps to try a law at, shape (n, 1, 1), or (n, nx, ny) where its parameters are arrays."""
    shape = np.broadcast_shapes(np.shape(law.work), np.shape(law.strength)) or (1, 1)
    return np.broadcast_to((_GAPS * law.reach)[:, np.newaxis, np.newaxis], (_GAPS.size, *shape)).copy()


@claim("interaction", "attracts")
def _attracts(law: Interaction) -> str:
    law = _resolved(law)
    tensions = np.array([law.tension(gap) for gap in _shaped_gaps(law)])
    require(np.isfinite(tensions).all(), "a tension is not finite")
    require(tensions.min() >= 0.0, "a tension is negative: the surfaces repel each other")
    require(np.min(law.work) > 0.0, "the work of adhesion is not above zero")
    return f"work {np.max(law.work):.3g} J/m2, strength {np.max(law.strength):.3g} Pa, reach {law.reach:.3g} m"


@claim("interaction", "tension is the derivative of the energy")
def _derivative(law: Interaction) -> str:
    law = _resolved(law)
    return f"to {_compare(law, law.energy, law.tension):.0e}"


@claim("interaction", "slope is the derivative of the tension")
def _slope(law: Interaction) -> str:
    law = _resolved(law)
    return f"to {_compare(law, law.tension, law.slope):.0e}"


def _compare(law: Interaction, value: object, derivative: object) -> float:
    step = _STEP * law.reach
    gaps = _shaped_gaps(law) + step
    found = np.array([(value(gap + step) - value(gap - step)) / (2.0 * step) for gap in gaps])  # type: ignore[operator]
    expected = np.array([derivative(gap) for gap in gaps])  # type: ignore[operator]
    return require_close(found, expected, _DIFFERENCE, "central differences are another derivative")


@claim("interaction", "ends at its reach")
def _ends(law: Interaction) -> None:
    law = _resolved(law)
    beyond = np.abs(law.energy(1.001 * _shaped_gaps(law)[-1]))
    require(bool((beyond <= 1.01e-6 * np.max(law.work)).all()), "beyond its reach more than 1e-6 of the work is left")


@claim("interaction", "shape")
def _shape(law: Interaction) -> None:
    law = _resolved(law)
    gaps = _shaped_gaps(law)[3]
    for precision in (np.float32, np.float64):
        given = gaps.astype(precision)
        kept = given.copy()
        for function in (law.tension, law.slope, law.energy):
            values = np.asarray(function(given))
            require(values.shape == given.shape, f"{values.shape} for gaps of shape {given.shape}")
        require_equal(given, kept, "it writes into the gap")


@claim("interaction", "contact")
def _contact(law: Interaction) -> str:
    resolved = _resolved(law)
    if np.ndim(resolved.work) or np.ndim(resolved.strength):
        raise DoesNotApply("its parameters are arrays, for a grid of their own")
    reach = float(np.max(resolved.work) / np.max(resolved.strength))
    spacing = 2.0 * reach
    grid = Grid((_BALL_CELLS, _BALL_CELLS), _BALL_CELLS * spacing)
    # The modulus at which the cohesive length has three cells.
    modulus = 3.0 * resolved.steepest * spacing
    body = Body(ParaboloidSurface(_RADIUS * spacing), Elastic(modulus, 0.0))
    problem = ContactProblem(body, grid=grid, adhesion=resolved)
    free = ContactProblem(body, grid=grid)
    force = resolved.work * np.pi * _RADIUS * spacing
    pressed = problem.solve(force=float(force))
    without = free.solve(force=float(force))
    require(pressed.contact.sum() >= without.contact.sum(), "with it the contact is smaller than without")
    closer = pressed.approach > 1.001 * without.approach
    require(closer, "with it the bodies do not approach more than without")
    return f"{int(pressed.contact.sum())} cells in contact, {int(without.contact.sum())} without it"


def _fields(law: FrictionLaw) -> list[Array]:
    """Return uniform pressures to try a law at, of the shape of its arrays."""
    maps = [np.shape(getattr(law, field.name)) for field in getattr(type(law), "__attrs_attrs__", ())]
    shape = next((one for one in maps if len(one) == 2), (12, 10))
    return [np.full(shape, pressure) for pressure in _PRESSURES]


@claim("friction law", "limits")
def _limits(law: FrictionLaw) -> str:
    # `shear_limit` requires the shape, finite values, at least zero, and none without pressure.
    limits = [shear_limit(law, field) for field in _fields(law)]
    return f"from {min(limit.max() for limit in limits):.3g} to {max(limit.max() for limit in limits):.3g} Pa"


@claim("friction law", "not falling with the pressure")
def _monotone(law: FrictionLaw) -> None:
    limits = np.array([law.limit(field) for field in _fields(law)])
    require((np.diff(limits, axis=0) >= 0.0).all(), "the limit falls as the pressure rises")


@claim("friction law", "local")
def _local(law: FrictionLaw) -> None:
    fields = _fields(law)
    one = fields[60].copy()
    before = law.limit(one.copy())
    one[0, 0] *= 2.0
    after = law.limit(one)
    after[0, 0] = before[0, 0]
    require_equal(after, before, "the pressure of one cell changes the limit of another")


claim_input_unchanged(
    "friction law",
    lambda law: [("a pressure", _fields(law)[60])],
    lambda law, field: ({"pressure": field}, lambda: law.limit(field)),
)
claim_repeatable(
    "friction law", None, lambda law: [law.limit(_fields(law)[60])], lambda law: law.limit(_fields(law)[3])
)
