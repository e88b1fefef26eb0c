"""The load at which a body first yields below its surface."""

from __future__ import annotations

import math
from functools import partial
from typing import TypeAlias

import attrs

from roughcontact._answers.areas.edges import warn_if_uncertain
from roughcontact._answers.subsurface.field import von_mises
from roughcontact._answers.subsurface.inputs import (
    SupportsResidualStress,
    body_name,
    coefficient,
    degrees,
    read_residual,
)
from roughcontact._answers.subsurface.maximum import StressMaximum
from roughcontact._answers.subsurface.stress import StressBelow
from roughcontact._base.arrays import Array
from roughcontact._base.checks import number
from roughcontact._base.units import Quantity, ShownAsPrinted, outlined, si
from roughcontact._parts.grid import Load
from roughcontact._solve.problem import (
    ContactProblem,
    LoadSearch,
    TriedLoad,
    maximum_pressure,
    problem_of,
    run_solve,
)
from roughcontact._solve.solution import ContactSolution, Estimate, Response, responses
from roughcontact.errors import InputError
from roughcontact.errors.warning import Answer

# Relative distance from the yield stress at which the search ends.
_STRESS_TOLERANCE = 1e-4
# Slope of the logarithm of the stress over the logarithm of the load: of a ball, and the smallest that is used.
_BALL_SLOPE = 1.0 / 3.0
_MIN_SLOPE = 0.05
# Largest factor of the load in the first step.
_MAX_LOAD_FACTOR = 300.0
# Width of a bracket of logarithmic loads below which the stress jumps across the yield stress from cell to cell.
_MIN_BRACKET_WIDTH = 1e-4
# Distance of two logarithmic loads from which their slope gives the uncertainty, which must not follow the steps of a
# maximum at the surface from cell to cell.
_UNCERTAINTY_LOAD_DISTANCE = 0.1
# Smallest load that is tried of surfaces that attract each other, over their attraction.
_MIN_LOAD_FRACTION = 1e-3
# Largest load that is tried, over the load that the bodies can carry.
_MAX_LOAD_FRACTION = 0.999


@attrs.frozen(eq=False)
class YieldPoint(ShownAsPrinted, Answer):
    """The load of first yield.

    Attributes
    ----------
    force
        The normal force, N.
    maximum
        The maximum von Mises stress at that load, with its place.
    solution
        The elastic contact at that load.
    layer
        Number of the layer that yields, 1 for the topmost; 0 for a body without layers, or the one under them.
    """

    force: Estimate
    maximum: StressMaximum
    solution: ContactSolution
    layer: int = 0

    @property
    def mean_pressure(self) -> Estimate:
        """The nominal mean pressure, Pa."""
        area = self.solution.grid.area
        return attrs.evolve(
            self.force, value=self.force.value / area, uncertainty=self.force.uncertainty / area, unit="Pa"
        )

    @property
    def estimates(self) -> dict[str, Estimate]:
        """The normal force and the mean pressure, by name."""
        return {"force": self.force, "mean_pressure": self.mean_pressure}

    @property
    def warnings(self) -> tuple[str, ...]:
        """Why the load must not be trusted, in sentences; empty without a reason."""
        return self.force.warnings

    def __str__(self) -> str:
        place = f"x = {si(self.maximum.x, 'm')}, y = {si(self.maximum.y, 'm')}, depth {si(self.maximum.depth, 'm')}"
        where = f" in layer {self.layer}" if self.layer else ""
        return f"first yield{where} at {place}: {self.force}"


# The maximum stress, and the number of its layer.
_Peak: TypeAlias = tuple[StressMaximum, int]


def _strength(value: Quantity) -> float:
    return number(value, "The yield stress", "Pa", above=0.0)


@responses.register("first-yield")
@attrs.frozen(eq=False)
class FirstYield(Response[YieldPoint]):
    r"""Load at which the maximum von Mises stress below a surface reaches the yield stress; the contact is elastic.

    On a ball :math:`F_Y = \pi^3 R^2 p_0^3 / 6 E^{*2}` with :math:`p_0 = 1.61\,Y` for :math:`\nu = 0.3`. The load is
    searched by a secant over the logarithms of load and stress. Its relative uncertainty is the uncertainty of the
    stress over their slope, a third for a ball, less for rough surfaces. Surfaces that attract each other have the
    stress of pressure and attraction together.

    Parameters
    ----------
    yield_stress
        Yield stress of the body in tension, Pa; of its layers that do not state their own too.
    body
        ``"body"`` or ``"counterbody"``.
    friction
        Coefficient of friction in full sliding, a number or shape (nx, ny); see `StressBelow`.
    direction
        Direction of the traction on the body, degrees from x towards y.
    residual
        Residual stress of the body by depth; see `StressBelow`.

    References
    ----------
    Johnson, Contact Mechanics (1985), sec. 6.1, https://doi.org/10.1017/CBO9781139171731
    """

    holds_with = frozenset({"tension"})
    fails_with = frozenset({"inner stress"})
    memory_arrays = 54.0  # solves at other loads, and the stress of each
    refusal = "it is that of pressure alone; ask for the stress, which counts the traction"

    yield_stress: float = attrs.field(converter=_strength, metadata={"unit": "Pa"})
    body: str = attrs.field(default="body", converter=body_name)
    friction: Array | None = attrs.field(default=None, converter=coefficient, repr=outlined, metadata={"unit": ""})
    direction: float = attrs.field(default=0.0, converter=degrees)
    residual: SupportsResidualStress | None = attrs.field(default=None, converter=read_residual)

    def respond(self, solution: ContactSolution) -> YieldPoint:
        """Return the load of first yield, searched from the load of the solution; see `Response.respond`."""
        problem = problem_of(solution)
        self._require_strength()
        attraction = 0.0 if solution.tension is None else float(solution.tension.sum()) * solution.grid.cell_area
        if not solution.force > 0.0:
            solution = _press(problem, attraction)
        carried = maximum_pressure(problem.plan) * solution.grid.area
        search = LoadSearch(
            solve=partial(run_solve, problem),
            read=self._read,
            unit=Load("force", solution.force),
            # Below the first one the attraction alone has made the body yield.
            ends=(_MIN_LOAD_FRACTION * attraction, _MAX_LOAD_FRACTION * carried),
            width=_MIN_BRACKET_WIDTH,
            power=_BALL_SLOPE,
            rises=True,
            has_kinks=True,
            factor=_MAX_LOAD_FACTOR,
        )
        found = search.run_from([solution])
        if found is None and search.is_jump:
            found = min(search.bracket or (), key=lambda one: abs(one.off))
        if found is None:
            raise InputError(self._explain(search))
        maximum, layer = found.answer
        slope = max(search.find_slope(found, _UNCERTAINTY_LOAD_DISTANCE) or _BALL_SLOPE, _MIN_SLOPE)
        relative = math.hypot(maximum.uncertainty / maximum.value, found.off) / slope
        contact = search.solutions[found.x]
        force = contact.force * math.exp(-found.off / slope)
        estimate = warn_if_uncertain(force, relative * force, "N", maximum.warnings)
        return YieldPoint(estimate, maximum, contact, layer)

    def _require_strength(self) -> None:
        """Raise `InputError` where the residual stress alone makes the body yield."""
        if self.residual is None:
            return
        largest = float(von_mises(self.residual.find_stress(self.residual.depth)).max())
        if largest >= self.yield_stress:
            raise InputError(
                f"The residual stress alone makes the {self.body} yield: its von Mises stress is {si(largest, 'Pa')}, "
                f"the yield stress {si(self.yield_stress, 'Pa')}."
            )

    def _read(self, x: float, solution: ContactSolution) -> TriedLoad[_Peak]:
        """Return the load with the maximum stress of the layer that is nearest to its yield stress, or beyond it."""
        below = StressBelow(None, self.body, friction=self.friction, direction=self.direction, residual=self.residual)
        # Of many loads none is solved on coarser grids too.
        stress = below.respond(attrs.evolve(solution, uncertainty="model"))
        stated: tuple[float | None, ...] = getattr(stress._kernel, "yield_stresses", ())
        found = []
        for place, maximum in stress.maxima.items() if stated else [(len(stated), stress.maximum)]:
            own = stated[place] if place < len(stated) else None
            strength = self.yield_stress if own is None else own
            layer = place + 1 if place < len(stated) else 0
            found.append(TriedLoad(x, math.log(maximum.value / strength), _STRESS_TOLERANCE, (maximum, layer)))
        return max(found, key=lambda one: one.off)

    def _explain(self, search: LoadSearch[_Peak]) -> str:
        """Return why no load makes the body yield."""
        lowest = search.tried[0]
        highest = search.tried[-1]
        if lowest.off > 0.0:
            return (
                f"The attraction alone makes the {self.body} yield: without a load the von Mises stress is "
                f"{si(lowest.answer[0].value, 'Pa')}."
            )
        return (
            f"No load was found at which the von Mises stress reaches {si(self.yield_stress, 'Pa')}: "
            f"at {si(search.load_at(highest.x), 'N')} it is {si(highest.answer[0].value, 'Pa')}."
        )


def _press(problem: ContactProblem, attraction: float) -> ContactSolution:
    """Return the contact under a load as large as the attraction, N, for one that has no load or a tensile one."""
    if not attraction > 0.0:
        raise InputError("The contact carries no load from which that of first yield could be searched.")
    return problem.solve(force=attraction)
