"""Gradients of a solved contact by the adjoint: all heights, the modulus or the load for one or two linear answers."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import attrs
import numpy as np

from roughcontact._answers.linear.sensitivities import SENSITIVITIES, Sensitivity, mark_summit
from roughcontact._answers.linear.tangent import Tangent
from roughcontact._base.checks import Array, callback, choice, numbers, read_only
from roughcontact._solve.solution import ContactSolution, Response, responses
from roughcontact.errors import InputError
from roughcontact.errors.door import outside, warn

PressureDerivative: TypeAlias = Callable[[Array], Array]

# Relative residual of the linear answers: the gradient is linear in it.
_TOLERANCE = 1e-10
_WITH_RESPECT_TO = ("heights", "modulus", "load")
_OF_EDGE = ("stiffness", "conductance")
_HARDLY_CHANGES = (
    "under a given load the gradient of the area is a small difference of large parts, and even its sign may be wrong: "
    "that of the participation is exact"
)


def _number(value: str | PressureDerivative) -> str | PressureDerivative:
    if not isinstance(value, str):
        if callback(value, "of=", "pressure") is None:
            raise InputError.about("of=", value, "a name or a function of the pressure")
        return value
    if value in _OF_EDGE:
        raise InputError(
            f"The {value} changes only as the edge of the contact moves from cell to cell, so that it has no gradient "
            "on a grid: take the difference of two solves."
        )
    if value not in SENSITIVITIES:
        raise InputError.unknown("gradient of", value, SENSITIVITIES)
    return value


def _variable(value: str) -> str:
    return choice(value, "with_respect_to=", _WITH_RESPECT_TO)


@responses.register("gradient")
@attrs.frozen
class Gradient(Response[Array]):
    r"""Derivatives of a number of the contact with respect to the heights, the modulus or the load, by the adjoint.

    On the cells A in contact and below the pressure limit, a small change of the heights z and of the position
    :math:`\delta` of the bodies changes the pressure by :math:`K_{AA}\,\mathrm{d}p = \mathrm{d}z + \mathrm{d}\delta`.
    A function J of the pressure therefore has the derivatives

    .. math:: \frac{\mathrm{d}J}{\mathrm{d}z} = \lambda - \frac{\sum\lambda}{\sum s}\,s, \quad
              \lambda = K_{AA}^{-1} \frac{\partial J}{\partial p}, \quad s = K_{AA}^{-1} 1

    under a given load, and :math:`\lambda` at a given position. The load that was given is held
    fixed: pressure, force, or approach, which counts from the touch of the highest cell and so moves with it.

    Parameters
    ----------
    of
        ``"force"``, ``"approach"``, ``"mean-gap"``, ``"participation"`` or ``"area"``; or a function that takes the
        pressure, shape (nx, ny), Pa, and returns the derivative of J with respect to it, shape (nx, ny).
    with_respect_to
        ``"heights"``: the sum of the heights of both bodies in each cell, m; the result has shape (nx, ny).
        ``"modulus"``: the contact modulus E*, Pa, with that of any layers in proportion; ``"load"``: the pressure,
        force or approach, as it was given. The result has shape ().

    Notes
    -----
    Exact while the cells in contact remain the same, but for ``"area"``. That takes each patch to be Hertzian, of an
    area that grows as its force over modulus and curvature, to the power 2/3: right to 1 % for separate summits, and 10
    to 20 %, a quarter at most, too small where patches merge. With respect to heights under a given load it is a
    small difference of large parts there, and even the sign may be wrong: descend on the ``"participation"``,
    :math:`\frac{9}{8} (\int p)^2 / \int p^2`, the area of Hertzian spots of one size.
    """

    of: str | PressureDerivative = attrs.field(converter=_number)
    with_respect_to: str = attrs.field(default="heights", converter=_variable)

    def respond(self, solution: ContactSolution) -> Array:
        """Return the derivatives; see `Response.respond`."""
        # The tangent refuses a solution that does not say what was solved.
        tangent = Tangent(solution)
        sensitivity = self._differentiate(solution)
        kind = next(iter(solution.origin.load)) if solution.origin is not None else ""
        if kind == "approach":
            adjoint = _Adjoint.at_approach(tangent, sensitivity)
        else:
            adjoint = _Adjoint.under_load(tangent, sensitivity)
            if self.of == "area" and self.with_respect_to == "heights":
                warn(_HARDLY_CHANGES)
        if self.with_respect_to == "load":
            units = {"pressure": float(solution.pressure.size), "force": 1.0 / solution.grid.cell_area, "approach": 1.0}
            return read_only(np.asarray(adjoint.load * units[kind]))
        if self.with_respect_to == "heights":
            by_heights = adjoint.surface + sensitivity.heights + adjoint.summit * mark_summit(solution)
            return read_only(by_heights)
        # A larger modulus acts as heights in proportion to the displacement.
        moved = float(np.einsum("ij,ij->", adjoint.surface, solution.displacement))
        return read_only(np.asarray(moved / solution.modulus + sensitivity.modulus))

    def _differentiate(self, solution: ContactSolution) -> Sensitivity:
        if isinstance(self.of, str):
            return SENSITIVITIES[self.of](solution)
        shape = solution.grid.shape
        allowed = f"finite numbers of shape {shape}, the derivatives with respect to the pressure of each cell"
        values = numbers(outside(self.of)(solution.pressure), "What of= returns", allowed)
        if values.shape != shape or not np.isfinite(values).all():
            raise InputError.about("What of= returns", values, allowed)
        return Sensitivity(pressure=values)


@attrs.frozen(eq=False)
class _Adjoint:
    """Derivatives of J through the pressure and the position of the bodies.

    Attributes
    ----------
    surface
        With respect to heights at a position that does not move with them, shape (nx, ny); zero outside the contact.
    summit
        With respect to the height of the highest cell besides.
    load
        With respect to the sum of the pressure, or to the approach.
    """

    surface: Array
    summit: float
    load: float

    @classmethod
    def at_approach(cls, tangent: Tangent, sensitivity: Sensitivity) -> _Adjoint:
        """Return the derivatives at a given approach."""
        if tangent.is_rigid:
            raise InputError("In full contact on a periodic boundary the approach does not determine the pressure.")
        surface = _solve(tangent, sensitivity.pressure)
        by_position = float(surface.sum()) + sensitivity.position
        return cls(surface, -by_position, by_position)

    @classmethod
    def under_load(cls, tangent: Tangent, sensitivity: Sensitivity) -> _Adjoint:
        """Return the derivatives under a given load."""
        if not tangent.cells.any():
            raise InputError("All cells in contact are at the pressure limit: how they share a change of load is open.")
        if tangent.is_rigid:
            shares = np.full(tangent.cells.shape, 1.0 / tangent.cells.size)
            compliance = 0.0
        else:
            uniform = _solve(tangent, np.ones(()))
            compliance = 1.0 / float(uniform.sum())
            shares = uniform * compliance
        # What a uniform change of the derivative by the pressure adds is the change of the load, which is zero.
        mean = float(np.sum(shares * sensitivity.pressure))
        surface = _solve(tangent, sensitivity.pressure - mean) - sensitivity.position * shares
        return cls(surface, 0.0, mean + sensitivity.position * compliance)


def _solve(tangent: Tangent, right: Array) -> Array:
    """Return the pressure on the cells in contact by a right side, shape () or (nx, ny)."""
    return tangent.solve(np.broadcast_to(right, tangent.cells.shape), _TOLERANCE).values
