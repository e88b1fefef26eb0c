"""The load at which a material that flows first yields, by its own yield stress."""

from __future__ import annotations

from typing import Any, ClassVar

import attrs
import roughcontact as rc
from roughcontact.responses import FirstYield, YieldPoint

from roughcontact_volume.flowed_body import read_body
from roughcontact_volume.forecast import make_elastic
from roughcontact_volume.yielding import Yielding

# Mean pressure over the yield stress from which the load is searched where the contact has none.
_FIRST_PRESSURE = 1e-3


@attrs.frozen
class FindOwnYield(rc.Response[YieldPoint]):
    """Load at which a body of the material `Plastic` first yields, of fresh surfaces, whatever the state.

    It is the response ``"first-yield"`` of the same bodies if they were elastic, at the yield stress of the material
    and with its residual stress.

    Parameters
    ----------
    body
        ``"body"`` or ``"counterbody"``; None: the one that flows.

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

    body: str | None = attrs.field(default=None, converter=read_body, kw_only=True)

    holds_with: ClassVar[frozenset[str]] = frozenset({"shear"})
    reads: ClassVar[str] = "state"
    memory_arrays: ClassVar[float] = 54.0  # solves at other loads, and the stress of each

    def respond(self, solution: Any) -> YieldPoint:
        """Return the load; see `Response.respond`."""
        problem: Any = None if solution.origin is None else solution.origin.scene
        sides = {side: getattr(problem, side, None) for side in ("body", "counterbody")}
        yielding = {side: one for side, one in sides.items() if one and isinstance(one.material, Yielding)}
        if not yielding:
            raise rc.InputError("Neither body yields: give one of them the material Plastic, or ask for 'first-yield'.")
        if self.body is None and len(yielding) > 1:
            raise rc.InputError("Both bodies yield: say which with body='body' or 'counterbody'.")
        asked = self.body or next(iter(yielding))
        if asked not in yielding:
            raise rc.InputError(f"The {asked} does not yield: give it the material Plastic, or ask for 'first-yield'.")
        material = yielding[asked].material
        twin = make_elastic(problem)
        force = solution.force or _FIRST_PRESSURE * material.yield_stress * solution.grid.area
        response = FirstYield(material.yield_stress, body=asked, residual=material.residual)
        found: YieldPoint = twin.solve(force=force).response(response)
        return found
