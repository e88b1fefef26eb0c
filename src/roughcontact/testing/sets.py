"""Claims about permanent sets."""

from __future__ import annotations

import numpy as np

from roughcontact.flattening import PermanentSet
from roughcontact.grid import Boundary
from roughcontact.solution import ContactSolution
from roughcontact.testing.claim import Claim, require
from roughcontact.testing.common import common
from roughcontact.testing.moved import copied, mirrored, shifted
from roughcontact.testing.scenes import full, rough, sphere


def _scenes() -> tuple[ContactSolution, ...]:
    return rough(0.05, Boundary.PERIODIC, True), rough(0.02, Boundary.FREE, True)


def _shapes(model: PermanentSet) -> str:
    deepest = 0.0
    for solution in (*_scenes(), full()):
        lower = model.lowering(solution)
        require(lower.shape == solution.grid.shape, f"an array of shape {lower.shape} on {solution.grid.shape} cells")
        require(lower.dtype == np.float64, f"numbers of type {lower.dtype} where float64 is needed")
        require(np.isfinite(lower).all(), "values that are not finite")
        deepest = max(deepest, float(lower.max()))
    return f"finite, at most {deepest:.2g} m"


def _elastic(model: PermanentSet) -> str:
    for solution in (rough(0.05), rough(0.05, Boundary.FREE), sphere(5.0, (0.3, 0.1)), full()):
        left = float(np.abs(model.lowering(solution)).max())
        require(left == 0.0, f"{left:.2g} m stay where nothing flows")
    return "nothing stays where nothing flows"


def _mass(model: PermanentSet) -> str:
    for solution in _scenes():
        lower = model.lowering(solution)
        rise = -float(lower.mean()) / float(np.abs(lower).max(initial=1e-300))
        require(rise <= 1e-12, "the surfaces have gained volume")
        deep = float(lower[solution.saturated].min())
        require(deep >= 0.0, f"cells that flow rise by {-deep:.2g} m")
    return "no volume out of nothing, and what flows does not rise"


def _mirrored(model: PermanentSet) -> str:
    for solution in _scenes():
        lower = model.lowering(solution)
        for axes in ((0,), (1,), (0, 1)):
            other = np.flip(model.lowering(mirrored(solution, axes)), axes)
            require(np.allclose(lower, other, rtol=0, atol=1e-12 * np.abs(lower).max()), "a mirror changes it")
        if solution.boundary is Boundary.PERIODIC:
            other = np.roll(model.lowering(shifted(solution, (7, 5))), (-7, -5), axis=(0, 1))
            require(np.allclose(lower, other, rtol=0, atol=1e-12 * np.abs(lower).max()), "moving changes it")
    return "mirrored and moved with the contact"


def _untouched(model: PermanentSet) -> str:
    for solution in _scenes():
        given = copied(solution)
        first = model.lowering(given)
        for name in ("pressure", "displacement", "undeformed", "gap"):
            same = np.array_equal(getattr(given, name), getattr(solution, name))
            require(same, f"it changed the {name} of the solution")
        require(np.array_equal(first, model.lowering(given)), "asked again, it answers differently")
    return "the solution is left as it was; the same bits, asked again"


CLAIMS = (
    Claim("set", "shapes and types", _shapes),
    Claim("set", "elastic contacts leave nothing", _elastic),
    Claim("set", "no volume out of nothing", _mass),
    Claim("set", "mirrored and moved contacts", _mirrored),
    Claim("set", "solution left as it was", _untouched),
    *common("set"),
)
