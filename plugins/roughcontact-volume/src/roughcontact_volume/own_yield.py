"""The load at which a material that flows first yields, by its own yield stress."""

from __future__ import annotations

from typing import Any, ClassVar

import attrs
import roughcontact as rc
from roughcontact.responses import FirstYield, YieldPoint

from roughcontact_volume.forecast import make_elastic
from roughcontact_volume.yielding import Yielding

# Mean pressure over the yield stress from which the load is searched where the contact has none.
_FIRST_PRESSURE = 1e-3


@attrs.frozen
class FindOwnYield(rc.Response[YieldPoint]):
    """Load at which a body of the material `Plastic` first yields, of fresh surfaces, whatever the state.

    It is the response ``"first-yield"`` of the same bodies if they were elastic, at the yield stress of the material.

    Examples
    --------
    >>> import roughcontact as rc
    >>> from roughcontact_volume import FindOwnYield, Plastic
    >>> steel = Plastic("210GPa", 0.3, yield_stress="1GPa", hardening="4GPa")
    >>> ball = rc.Body(rc.ParaboloidSurface("1mm"), rc.Rigid())
    >>> problem = rc.ContactProblem(ball, rc.Body(rc.FlatSurface(), steel), grid=rc.Grid((24, 24), "30um"))
    >>> found = problem.solve(force="0.3N").response(FindOwnYield())
    >>> 0.37 < found.force.value < 0.43
    True
    """

    holds_with: ClassVar[frozenset[str]] = frozenset({"shear"})
    reads: ClassVar[str] = "state"
    memory_arrays: ClassVar[float] = 54.0  # solves at other loads, and the stress of each

    def respond(self, solution: Any) -> YieldPoint:
        """Return the load; see `Response.respond`."""
        problem: Any = None if solution.origin is None else solution.origin.scene
        for side in ("body", "counterbody"):
            body = getattr(problem, side, None)
            if body is not None and isinstance(body.material, Yielding):
                material = body.material
                twin = make_elastic(problem, side)
                force = solution.force or _FIRST_PRESSURE * material.yield_stress * solution.grid.area
                found: YieldPoint = twin.solve(force=force).response(FirstYield(material.yield_stress, body=side))
                return found
        raise rc.InputError("Neither body yields: give one of them the material Plastic, or ask for 'first-yield'.")
