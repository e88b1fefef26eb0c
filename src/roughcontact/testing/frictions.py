"""Claims about friction laws."""

from __future__ import annotations

import numpy as np

from roughcontact._base.arrays import Array
from roughcontact._parts.interactions import FrictionLaw, shear_limit
from roughcontact.testing.claim import claim, require, require_equal
from roughcontact.testing.generic import claim_repeatable

# Pressures at which a law is tried, Pa.
_PRESSURES = np.concatenate(([0.0], np.geomspace(1.0, 1e11, 119)))


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


@claim("friction law", "input unchanged")
def _unchanged(law: FrictionLaw) -> None:
    field = _fields(law)[60]
    kept = field.copy()
    law.limit(field)
    require_equal(field, kept, "it writes into the pressure")


claim_repeatable(
    "friction law", None, lambda law: [law.limit(_fields(law)[60])], lambda law: law.limit(_fields(law)[3])
)
