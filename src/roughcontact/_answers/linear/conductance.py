"""Thermal and electrical contact conductance."""

from __future__ import annotations

import math
from collections.abc import Sequence

import attrs
import numpy as np

from roughcontact._answers.linear.stiffness import (
    correct_edges,
    describe_full_contact,
    list_warnings,
    require_mean_gap,
)
from roughcontact._answers.linear.tangent import LinearSolution, Tangent
from roughcontact._base.arrays import Array, Pair, read_only
from roughcontact._base.checks import number, pair
from roughcontact._base.units import Estimate, outlined, si
from roughcontact._solve.solution import Area, ContactSolution, Response, responses
from roughcontact.errors import InputError

# Relative residual: the error of the conductance is its square; of the currents of the patches, the residual itself.
_RESIDUAL_TOLERANCE = 1e-3


def _conductivity(value: float | Sequence[float]) -> Pair:
    return pair(value, "The conductivity of the bodies", "W/(m K) or S/m", above=0.0)


def _film(value: float) -> float:
    return number(value, "The film resistance", "m2 K/W or Ohm m2", at_least=0.0)


@attrs.frozen(eq=False)
class Conductance(Estimate):
    """The contact conductance: W/K for conductivities in W/(m K), S for conductivities in S/m.

    Attributes
    ----------
    value
        Heat flow over temperature difference, or current over voltage, W/K or S; infinite in full contact on a periodic
        boundary without film.
    uncertainty
        One standard deviation, W/K or S.
    unit
        ``"W/K"``; the same number is in S where the conductivities are in S/m.
    per_area
        `value` over the nominal area, W/(m2 K) or S/m2.
    patches
        Flow through each of the solution's patches at a unit difference, shape (count,), W/K or S.
    constriction
        Constriction resistance of each patch by itself, shape (count,), K/W or Ohm: of a disc with its area, the
        largest of all shapes.
    film
        Resistance of the film on each patch, shape (count,), K/W or Ohm.
    interaction
        Excess of the total resistance over independent patches in parallel, K/W or Ohm. The patches count as discs, so
        that slender ones may make it negative.
    warnings
        Why the value must not be trusted, in sentences; empty without a reason.
    """

    value: float
    uncertainty: float
    per_area: float
    patches: Array = attrs.field(converter=read_only, repr=outlined)
    constriction: Array = attrs.field(converter=read_only, repr=outlined)
    film: Array = attrs.field(converter=read_only, repr=outlined)
    unit: str = attrs.field(default="W/K", init=False)
    warnings: tuple[str, ...] = ()

    @property
    def interaction(self) -> float:
        if not 0.0 < self.value < math.inf:
            return 0.0
        return 1.0 / self.value - 1.0 / float(np.sum(1.0 / (self.constriction + self.film)))

    def __str__(self) -> str:
        if math.isinf(self.value):
            return f"infinite conductance{self._reasons}"
        relative = f"{100 * self.uncertainty / self.value:.2g} %" if self.value > 0.0 else "0 %"
        heat = si(self.value, "W/K", 5)
        heat_per_area = si(self.per_area, "W/(m2 K)", 5)
        # The same number, with the same prefix, is an electrical conductance.
        current = heat.partition(" ")[2].replace("W/K", "S")
        current_per_area = heat_per_area.partition(" ")[2].replace("W/(m2 K)", "S/m2")
        return (
            f"{heat} ({current} if the conductivities are in S/m) +- {relative}, "
            f"{heat_per_area} ({current_per_area}) of nominal area, "
            f"through {self.patches.size} patch{'' if self.patches.size == 1 else 'es'}{self._reasons}"
        )


@responses.register("conductance")
@attrs.frozen
class ContactConductance(Response[Conductance]):
    r"""Thermal or electrical conductance of the spots in contact.

    Potential and current obey the equations of displacement and pressure (Barber's analogy): with the answer q to a
    unit displacement on all touching cells A, saturated ones too,

    .. math:: (K_{AA} + R I)\, q = 1, \qquad G = \frac{2}{E^* (1/k_1 + 1/k_2)} \sum_A q\, \Delta x \Delta y, \qquad
       R = \frac{2\, r_f}{E^* (1/k_1 + 1/k_2)}

    with the conductivities k of the bodies and the film resistance r_f. E* cancels. On a periodic boundary G is the
    gap conductance of a model of the bodies: its inverse is the excess resistance over perfect contact. On a free
    boundary it contains the spreading into two infinite half-spaces. Conduction through the gap, by gas or radiation,
    is not contained.

    Parameters
    ----------
    conductivity
        Of both bodies, or of each (body, counterbody), W/(m K) for heat or S/m for current.
    film_resistance
        Resistance of a film on the spots times its area, m2 K/W or Ohm m2.

    References
    ----------
    Barber, Proc. R. Soc. A 459 (2003) 53-66, https://doi.org/10.1098/rspa.2002.1038;
    Greenwood, Brit. J. Appl. Phys. 17 (1966) 1621-1632, https://doi.org/10.1088/0508-3443/17/12/310
    """

    with_adhesion = "contact pressure"

    conductivity: Pair = attrs.field(converter=_conductivity)
    film_resistance: float = attrs.field(default=0.0, converter=_film)

    def respond(self, solution: ContactSolution) -> Conductance:
        """Return the conductance; see `Response.respond`."""
        require_mean_gap(solution, "conductance")
        if solution.moduli is not None:
            raise InputError(
                "The conductance follows from the stiffness of two isotropic half-spaces, but this kernel is of a "
                "layer or a crystal, which conducts otherwise than it deforms: choose kernel='love'."
            )
        area = solution.area()
        warnings = list_warnings(solution, area.warnings)
        resistivity = sum(1.0 / value for value in self.conductivity)
        # Displacement by a unit pressure over the potential by a unit current.
        analogy = 2.0 / (solution.modulus * resistivity)
        known = _find_areas(solution, area)
        constriction = 0.25 * resistivity * np.sqrt(np.pi / known)
        film = self.film_resistance / known
        compliance = analogy * self.film_resistance * float(solution.patches.areas.sum()) / max(area.value, 1e-300)
        tangent = Tangent(solution, saturated=True, compliance=compliance if known.size else 0.0)
        if tangent.is_rigid:
            currents = np.full(known.size, math.inf)
            std = 0.0
            warnings = (*warnings, describe_full_contact("conductance"))
        elif not known.size:
            currents = np.zeros(0)
            std = 0.0
        else:
            answer = tangent.solve(np.ones(solution.grid.shape), _RESIDUAL_TOLERANCE)
            currents, std = _find_currents(solution, answer, tangent, area, compliance)
            currents = analogy * currents
            std = analogy * std
        value = float(np.sum(currents))
        return Conductance(value, std, value / solution.grid.area, currents, constriction, film, warnings)


def _find_areas(solution: ContactSolution, area: Area) -> Array:
    """Return the area of each patch, above zero."""
    counted = solution.patches.areas
    return counted if area.patches is None else np.maximum(area.patches, 0.01 * counted)


def _find_currents(
    solution: ContactSolution, answer: LinearSolution, tangent: Tangent, area: Area, film: float
) -> tuple[Array, float]:
    """Return the stiffness of each patch and the standard deviation of their sum, N/m."""
    correction = correct_edges(solution, answer.values, tangent.cells, area, film)
    parts = solution.patches.sum(answer.values) * solution.grid.cell_area
    total = answer.product * solution.grid.cell_area
    return parts * (total / float(parts.sum())) + correction.patches, correction.uncertainty
