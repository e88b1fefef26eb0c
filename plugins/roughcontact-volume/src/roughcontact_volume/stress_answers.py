"""Responses of a state whose body has flowed: the residual stress below it, and that with the pressure."""

from __future__ import annotations

import math
from typing import Any, ClassVar

import attrs
import numpy as np
import roughcontact as rc
from roughcontact.typing import Array, Length

from roughcontact_volume.box import count_layers
from roughcontact_volume.flowed_body import FlowedBody, read_body
from roughcontact_volume.layered_stress import LayeredStress


def _depth(value: Length | None) -> float | None:
    if value is None:
        return None
    try:
        depth = float(value)
    except (TypeError, ValueError):
        depth = np.nan
    if not 0.0 < depth < 1e60:
        raise rc.InputError.about("The depth of the stress", value, "a number above 0 (m)")
    return depth


@attrs.frozen
class FindResidualStress(rc.Response[LayeredStress]):
    r"""The residual stress below a surface that has flowed, :math:`T \varepsilon` of its plastic strain.

    It is what an unloaded body has, and what it has below its load beside the stress of the pressure. That which the
    material had before any load is part of it.

    Parameters
    ----------
    depth
        Depth down to which it is found, m; None: twice that of the plastic zone.
    body
        ``"body"`` or ``"counterbody"``; None: the one that flows.

    Examples
    --------
    A ball leaves compression where the body has flowed:

    >>> import roughcontact as rc
    >>> from roughcontact_volume import FindResidualStress, Plastic
    >>> steel = Plastic("210GPa", 0.3, yield_stress="1GPa", hardening="4GPa")
    >>> ball = rc.Body(rc.ParaboloidSurface("1mm"), rc.Rigid())
    >>> problem = rc.ContactProblem(ball, rc.Body(rc.FlatSurface(), steel), grid=rc.Grid((15, 15), "65um"))
    >>> found = problem.path(force=["2N", "0N"])[1].response(FindResidualStress())
    >>> found.components.shape[0], bool(found.find_profile().columns["xx"].min() < -2e8)
    (6, True)
    """

    depth: float | None = attrs.field(default=None, converter=_depth, metadata={"unit": "m"})
    body: str | None = attrs.field(default=None, converter=read_body, kw_only=True)

    holds_with: ClassVar[frozenset[str]] = frozenset({"shear"})
    reads: ClassVar[str] = "state"
    is_loaded: ClassVar[bool] = False

    def respond(self, solution: Any) -> LayeredStress:
        """Return the stress; see `Response.respond`."""
        body = FlowedBody.of(solution, self.body)
        count = count_layers(body.grid, 2.0 * _find_depth(body) if self.depth is None else self.depth)
        deeper = attrs.evolve(body, flow=body.flow.deepen(max(count, body.flow.layers)))
        stress = deeper.find_stress(is_loaded=self.is_loaded)[:, :count]
        interfaces = np.concatenate(([0.0], np.cumsum(deeper.thicknesses)))[: count + 1]
        most = body.find_largest_yield_stress() if self.is_loaded else math.inf
        return LayeredStress(body.grid, interfaces, stress, body.step_error, most, body.warnings)


@attrs.frozen
class FindTotalStress(FindResidualStress):
    r"""The stress below a surface that has flowed, :math:`S p + T \varepsilon` of its pressure and its plastic strain.

    Parameters
    ----------
    depth
        Depth down to which it is found, m; None: twice that of the plastic zone, or twice the radius of a disc as large
        as the contact if nothing has flowed.
    body
        ``"body"`` or ``"counterbody"``; None: the one that flows.

    Examples
    --------
    Its von Mises stress is at most the yield stress where the body flows:

    >>> import roughcontact as rc
    >>> from roughcontact_volume import FindTotalStress, Plastic
    >>> steel = Plastic("210GPa", 0.3, yield_stress="1GPa")
    >>> ball = rc.Body(rc.ParaboloidSurface("1mm"), rc.Rigid())
    >>> problem = rc.ContactProblem(ball, rc.Body(rc.FlatSurface(), steel), grid=rc.Grid((15, 15), "65um"))
    >>> f"{problem.solve(force='2N').response(FindTotalStress()).von_mises.max() / 1e9:.3f} GPa"
    '1.000 GPa'
    """

    is_loaded: ClassVar[bool] = True


def _find_depth(body: FlowedBody) -> float:
    """Return the depth of the plastic zone, m; of a body that never flowed the radius of its contact."""
    thicknesses: Array = body.thicknesses
    in_layers = np.flatnonzero(body.flow.accumulated_strain.any(axis=(1, 2)))
    if in_layers.size:
        return float(thicknesses[: in_layers[-1] + 1].sum())
    radius = math.sqrt(np.count_nonzero(body.pressure) * body.grid.cell_area / math.pi)
    return max(radius, float(thicknesses[0]))
