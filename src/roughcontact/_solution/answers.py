"""What is asked of a solved contact: areas, numbers with their uncertainty, responses, warnings."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, TypeVar

import attrs
import numpy as np

from roughcontact._materials import Material
from roughcontact._solution.fields import ContactFields
from roughcontact._solution.plausibility import list_warnings
from roughcontact._solution.responses import Response, responses
from roughcontact._solution.results import (
    DEFAULT_AREA,
    Area,
    AreaEstimator,
    Estimate,
    QuantityEstimator,
    areas,
    judge_maps,
    quantities,
    require_estimate,
)
from roughcontact._solution.saturation import estimate_saturated_area
from roughcontact._solution.theory import TheoryBeside, compare_with_theory
from roughcontact._surfaces import HeightMap
from roughcontact.checks import Array
from roughcontact.errors import InputError

if TYPE_CHECKING:
    from roughcontact._responses import Conductance, Leakage, PartialSlip, Stress, YieldPoint

T = TypeVar("T")


@attrs.frozen(eq=False, kw_only=True)
class ContactAnswers(ContactFields):
    """A solved contact: its fields, the certificate, and all that is asked of them."""

    def area(self, estimator: str | AreaEstimator = DEFAULT_AREA) -> Area:
        """Return the real contact area.

        Parameters
        ----------
        estimator
            Registered name or instance of an area estimator.

        Raises
        ------
        InputError
            If there is no such estimator.
        """
        # Every number and response asks for this one.
        default = isinstance(estimator, str) and estimator == DEFAULT_AREA
        return self._default_area if default else self._estimate_area(areas.resolve(estimator))

    @cached_property
    def _default_area(self) -> Area:
        return self._estimate_area(areas.resolve(DEFAULT_AREA))

    def _estimate_area(self, chosen: AreaEstimator) -> Area:
        area = chosen.estimate(self)
        if not isinstance(area, Area) or not np.isfinite([area.value, area.uncertainty]).all():
            raise InputError(
                f"The area estimator {chosen!r} returned {area!r}, which is not an Area of finite numbers."
            )
        return judge_maps(area, self._maps, self.grid.cell_area)

    @cached_property
    def _maps(self) -> tuple[HeightMap, ...]:
        return () if self.origin is None else self.origin.maps

    def peak_pressure(self) -> Estimate:
        """Return the maximum contact pressure between the cells, Pa; see `estimate`."""
        return self.estimate("peak-pressure")

    def estimate(self, quantity: str | QuantityEstimator, area: str | AreaEstimator = DEFAULT_AREA) -> Estimate:
        """Return a number of the contact with its uncertainty, given an area estimator.

        The names are ``"peak-pressure"``, ``"perimeter"``, ``"patches"``, ``"mean-gap"`` and ``"approach"``, since the
        first touch of the summits between the cells.
        """
        chosen = quantities.resolve(quantity)
        return require_estimate(chosen, chosen.estimate(self, self.area(area)))

    def response(self, response: str | Response[T]) -> T:
        """Return what the contact does: its answer to a small change, a current, a flow.

        Parameters
        ----------
        response
            Registered name or instance of a response.

        Raises
        ------
        InputError
            If there is no such response, or it means nothing for this contact.
        """
        chosen: Response[T] = responses.resolve(response)
        return chosen.respond(self)

    def stiffness(self) -> Estimate:
        """Return the normal stiffness dF/d(approach), N/m; see `roughcontact._responses.Stiffness`."""
        return self.response("stiffness")

    def conductance(self, conductivity: float | Sequence[float], film_resistance: float = 0.0) -> Conductance:
        """Return the thermal or electrical contact conductance; see `roughcontact._responses.ContactConductance`."""
        asked = responses.create("conductance", conductivity, film_resistance=film_resistance)
        found: Conductance = self.response(asked)
        return found

    def stress(self, depths: float | Array | Sequence[float] | None = None, body: str = "body") -> Stress:
        """Return the stress below a surface, Pa, at depths, m; see `roughcontact._responses.StressBelow`."""
        stress: Stress = self.response(responses.create("stress", depths, body=body))
        return stress

    def first_yield(self, yield_stress: float, body: str = "body") -> YieldPoint:
        """Return the load at which a body first yields below its surface; see `roughcontact._responses.FirstYield`."""
        found: YieldPoint = self.response(responses.create("first-yield", yield_stress, body=body))
        return found

    def leakage(self, *, axis: int = 0, viscosity: float, pressure_drop: float) -> Leakage:
        """Return the flow of a liquid through the gap, m3/s; see `roughcontact._responses.GapFlow`."""
        asked = responses.create("leakage", axis=axis, viscosity=viscosity, pressure_drop=pressure_drop)
        found: Leakage = self.response(asked)
        return found

    def gradient(self, of: str | Callable[[Array], Array], with_respect_to: str = "heights") -> Array:
        """Return the derivatives of a number of the contact; see `roughcontact._responses.Gradient`."""
        return self.response(responses.create("gradient", of, with_respect_to=with_respect_to))

    def partial_slip(self, *, tangential_force: float, friction: float) -> PartialSlip:
        """Return the contact under a tangential force, N, below that of sliding.

        See `roughcontact._responses.CiavarellaJaeger`.
        """
        asked = responses.create("partial-slip", tangential_force=tangential_force, friction=friction)
        found: PartialSlip = self.response(asked)
        return found

    def saturated_area(self, estimator: str | AreaEstimator = "level-set") -> Area:
        """Return the part of the contact area where the pressure has reached the limit; zero without a limit.

        limit - p and -gap satisfy the contact conditions, and the contact of that complementary problem is
        the area that is not saturated; so the estimators of the contact's edge find this edge as well.

        Parameters
        ----------
        estimator
            Registered name or instance of an area estimator.

        Raises
        ------
        InputError
            If there is no such estimator.
        """
        return estimate_saturated_area(self, estimator)

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """Likely mistakes, and why the model or the grid does not suit the contact, in sentences; empty if none.

        They do not include those of the `area`.
        """
        return list_warnings(self, self._materials.values())

    @cached_property
    def theory(self) -> TheoryBeside | None:
        """Persson's theory for the same surface and load; None where it does not hold.

        It is given on periodic boundaries, without saturated cells, for nominally flat, isotropic, Gaussian roughness
        of many waves, most of them longer than four cells, on at most 2048 x 2048 cells.
        """
        return compare_with_theory(self)

    @property
    def _materials(self) -> dict[str, Material]:
        return {} if self.origin is None else self.origin.materials

    @property
    def _measured(self) -> list[HeightMap]:
        return [one for one in self._maps if not one.periodic]
