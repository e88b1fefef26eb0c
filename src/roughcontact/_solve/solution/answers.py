"""What is asked of a solved contact: areas, responses, warnings, and what theory says of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any, ClassVar, Self, TypeVar, overload

import attrs
import numpy as np

from roughcontact._base.arrays import Array
from roughcontact._base.checks import choice
from roughcontact._base.units import Estimate, Force, Length, Pressure, Quantity
from roughcontact._parts.materials import Material
from roughcontact._parts.surfaces import HeightMap
from roughcontact._solve.solution.additions import Addition
from roughcontact._solve.solution.attraction import interpolate_peak, warn_of_attraction, widen_area
from roughcontact._solve.solution.healing import heal
from roughcontact._solve.solution.judgement import UNCERTAINTIES, explain_uncertainties, judge, judge_area
from roughcontact._solve.solution.place import Place
from roughcontact._solve.solution.plausibility import list_warnings
from roughcontact._solve.solution.results import (
    DEFAULT_ADHESIVE_AREA,
    DEFAULT_AREA,
    Area,
    AreaEstimator,
    NameOfNumber,
    Response,
    areas,
    ask,
    estimate_attractive_area,
    estimate_saturated_area,
    judge_maps,
    list_fields,
    require_to_hold,
    responses,
)
from roughcontact._solve.solution.sampling import defer_area_sampling
from roughcontact._solve.solution.shear import ShearFields
from roughcontact._solve.solution.theory import Stickiness, TheoryBeside, compare_with_theory, find_stickiness
from roughcontact.errors import InputError

T = TypeVar("T")


@attrs.frozen(eq=False, kw_only=True)
class ContactAnswers(ShearFields):
    """The fields of a solved contact, and the answers derived from them."""

    _public_name: ClassVar[str] = "ContactSolution"

    def area(self, estimator: str | AreaEstimator = DEFAULT_AREA, *, uncertainty: str | None = None) -> Area:
        """Return the real contact area.

        Parameters
        ----------
        estimator
            Registered name or instance of an area estimator.
        uncertainty
            ``"model"``: by a model of the errors of the estimator; ``"two grids"``: by what changes on coarser grids of
            the same heights, `phases`, over which the default area is extrapolated at sharp edges and rough heights;
            ``"auto"``: by two grids there, if there is a coarser one, else by the model; ``"noise"``: by the model and
            by what as much more noise as the heights have changes, to whose absence the area is extrapolated, see
            `roughcontact.responses.Noise`; None: as the solution states, which is ``"auto"`` unless a study says
            otherwise. `explain` says what it was.

        Raises
        ------
        InputError
            If there is no such estimator, or no coarser grid.
        """
        kind = self._choose_uncertainty(uncertainty)
        # The default area is kept, because every number and response needs it.
        if isinstance(estimator, str) and estimator == DEFAULT_AREA:
            found = self._default_area
            return self._keep(f"area, {kind}", lambda: judge_area(self, found, kind))
        area = self._estimate_area(areas.resolve(estimator))
        return judge(self, area, kind, lambda one: one.area(estimator, uncertainty="model"))

    def _choose_uncertainty(self, uncertainty: str | None) -> str:
        return self.uncertainty if uncertainty is None else choice(uncertainty, "The uncertainty", list(UNCERTAINTIES))

    def explain(self) -> str:
        """Return what the uncertainties of the answers are found from, and why."""
        return explain_uncertainties(self)

    def phases(self) -> Any:
        """Return the contact on both diagonal phases of its grid, solved once; see `roughcontact.responses.Phases`."""
        return self.response("phases")

    def attractive_area(self, fraction: float = 0.1) -> Area:
        """Return the area outside the contact where the tension exceeds a fraction of its maximum.

        Parameters
        ----------
        fraction
            Tension over the maximum tension of all cells, above 0 and below 1.

        Raises
        ------
        InputError
            If the surfaces do not attract each other.
        """
        return estimate_attractive_area(self, fraction)

    def gather(self) -> Self | None:
        """Return the solution with all its fields as arrays of numpy.

        It is the solution itself, unless it is divided among processes or on another device: then the fields must fit
        into the memory of this process. All processes must ask; the first gets the solution, certified anew, the others
        None.
        """
        whole: Self | None = self.parts.gather(self)
        return whole

    @property
    def _normal(self) -> Self:
        """The normal contact alone, which area and responses read."""
        return self._keep("normal", self._find_normal) if self.added else self

    def _find_normal(self) -> Self:
        normal = attrs.evolve(self, added=())
        # Answers of the normal contact need the area that holds for its surfaces.
        normal._found["default area"] = self._name_default_area()
        offset = next((one.offset for one in self.added if one.offset is not None and one.offset.any()), None)
        if offset is not None:
            normal._found["fresh gap"] = self.initial_gap - offset
        return normal

    def _name_default_area(self) -> str:
        """Return the name of the area estimator that holds for the surfaces."""
        own: str = self._found.get("default area", "")
        usual = DEFAULT_AREA if self.tension is None else DEFAULT_ADHESIVE_AREA
        return own or next((one.default_area for one in self.added if one.default_area), usual)

    def _add(self, addition: Addition, **changes: Any) -> Self:
        """Return the state with what a physics adds in place of its former addition; the normal contact is the same."""
        others = tuple(one for one in self.added if one.kind != addition.kind)
        state = attrs.evolve(self, added=(*others, addition), **changes)
        if not addition.default_area and addition.offset is None:
            state._found["normal"] = self._normal
        return state

    @cached_property
    def _default_area(self) -> Area:
        if self.added:
            return self._normal._default_area
        return self._estimate_area(areas.resolve(self._name_default_area()))

    def _view(self, response: Response[Any]) -> Self:
        """Return what a response reads of the solution: with adhesion the pressure that it holds for."""
        require_to_hold(response, self._laws)
        return self._normal if response.reads == "total pressure" else self._pressed

    @property
    def _pressed(self) -> Self:
        """The normal contact with its contact pressure alone, whose gap is the same."""
        if self.tension is None:
            return self._normal
        nothing = np.zeros(self.grid.shape)
        return self._keep(
            "pressed", lambda: attrs.evolve(self._normal, pressure=self.contact_pressure, tension=nothing)
        )

    def _estimate_area(self, chosen: AreaEstimator) -> Area:
        area = self.parts.ask(self, chosen, lambda one: chosen.estimate(heal(one._view(chosen))))
        if not isinstance(area, Area) or not np.isfinite([area.value, area.uncertainty]).all():
            raise InputError(
                f"The area estimator {chosen!r} returned {area!r}, which is not an Area of finite numbers."
            )
        area = judge_maps(area, self._maps, self.grid.resolved.cell_area)
        area = area if self.origin is None else widen_area(area, self, self.origin)
        return attrs.evolve(area, relative_sampling=defer_area_sampling(self))

    @cached_property
    def _place(self) -> Place | None:
        return Place.of(heal(self._normal), self.non_measured)

    @cached_property
    def _maps(self) -> tuple[HeightMap, ...]:
        return () if self.origin is None else self.origin.maps

    def peak_pressure(self, *, uncertainty: str | None = None) -> Estimate:
        """Return the maximum contact pressure between the cells, Pa; see `roughcontact.responses.PeakPressure`.

        Parameters
        ----------
        uncertainty
            See `area`; of surfaces that attract each other it is that of a model.
        """
        return (
            interpolate_peak(self)
            if self.tension is not None
            else self.response("peak-pressure", uncertainty=uncertainty)
        )

    @overload
    def response(self, response: NameOfNumber, *, uncertainty: str | None = None) -> Estimate: ...
    @overload
    def response(self, response: Response[T], *, uncertainty: str | None = None) -> T: ...
    @overload
    def response(self, response: str, *, uncertainty: str | None = None) -> Any: ...
    def response(self, response: str | Response[Any], *, uncertainty: str | None = None) -> Any:
        """Return a quantity of the contact, or its response to a small change, a current or a flow.

        Parameters
        ----------
        response
            Registered name or instance of a response. The names of those without arguments are ``"peak-pressure"``,
            ``"perimeter"``, ``"patches"``, ``"mean-gap"``, ``"approach"`` (since the first touch of the summits between
            the cells), ``"stiffness"`` and ``"tangential-stiffness"``; ``roughcontact.responses.create`` makes others.
            With friction a response with a field ``traction``, such as the stress, is that under pressure and traction,
            others are those of the normal contact.
        uncertainty
            Of a number, ``"auto"``, ``"model"`` or ``"two grids"``; see `area`.

        Raises
        ------
        InputError
            If there is no such response, or it means nothing for this contact or has no value; with friction also if
            it states a traction or a friction of its own.
        """
        kind = self._choose_uncertainty(uncertainty)
        asked: Any = responses.resolve(response)
        chosen = self._add_traction(asked) if self.added else asked
        found = self.parts.ask(self, chosen, lambda one: ask(one, chosen))
        if not isinstance(found, Estimate):
            if uncertainty not in (None, "auto"):
                raise InputError(
                    f"The response {response!r} is not a number that has one uncertainty: omit uncertainty=."
                )
            return found
        if chosen is not asked:
            if kind in ("auto", "model"):
                return found
            raise InputError(
                "Solved again the contact has no traction: with friction this answer is that of the model."
            )
        return judge(self, found, kind, lambda one: one.response(asked, uncertainty="model"))

    def _add_traction(self, asked: Any) -> Any:
        """Return a response to pressure and traction of a contact with friction."""
        require_to_hold(asked, self._laws)
        if "traction" not in list_fields(asked):
            return asked
        own = [name for name in ("traction", "friction") if getattr(asked, name, None) is not None]
        if own:
            raise InputError(f"The state has its own traction: omit {own[0]}= of the response.")
        return attrs.evolve(asked, traction=self.shear)

    def stiffness(self, *, unloading: bool = False) -> Estimate:
        """Return the normal stiffness dF/d(approach), N/m; `roughcontact.responses.Stiffness` states the equations.

        Parameters
        ----------
        unloading
            Whether the load falls: cells at the pressure limit then answer too.
        """
        found: Estimate = self.response(responses.create("stiffness", unloading=unloading))
        return found

    def stability(self) -> Estimate:
        """Return how far surfaces that attract each other are from a jump: 1 far away, 0 at one.

        `roughcontact.responses.StabilityMargin` states the equation.
        """
        return self.response("stability")

    def conductance(self, conductivity: Quantity | Sequence[Quantity], film_resistance: Quantity = 0.0) -> Any:
        """Return the thermal or electrical contact conductance, W/K or S.

        `roughcontact.responses.ContactConductance` states the equations.

        Parameters
        ----------
        conductivity
            Conductivity of both bodies, or of each (body, counterbody), W/(m K) for heat or S/m for current; that of
            layers is with the kernel.
        film_resistance
            Resistance of a film on the spots times its area, m2 K/W or Ohm m2.

        Returns
        -------
        roughcontact.responses.Conductance
            An `Estimate`, with its parts.

        Raises
        ------
        InputError
            If a number is not positive, the boundary has no conductance, or that of a layer is not known.
        """
        asked = responses.create("conductance", conductivity, film_resistance=film_resistance)
        return self.response(asked)

    def stress(
        self,
        depths: Length | Array | Sequence[Length] | None = None,
        body: str = "body",
        *,
        traction: Array | None = None,
        friction: float | Array | None = None,
        direction: float = 0.0,
    ) -> Any:
        """Return the stress below a surface; `roughcontact.responses.StressBelow` states the equations.

        Parameters
        ----------
        depths
            Depths below the surface, m, shape (n,); None: from half a cell to two radii of the largest patch, and the
            surface where there is a tangential traction.
        body
            ``"body"`` or ``"counterbody"``.
        traction
            Tangential traction on the body along x and y, shape (2, nx, ny), Pa; the counterbody has the opposite one.
        friction
            In place of a traction: the coefficient of friction in full sliding, a number or shape (nx, ny).
        direction
            Direction of the traction on the body in full sliding, degrees from x towards y.

        Returns
        -------
        roughcontact.responses.Stress
            Components, maximum and uncertainty.

        Raises
        ------
        InputError
            If the body has no stress: it is rigid or layered; or if a traction has another shape than the grid.
        """
        asked = responses.create("stress", depths, body=body, traction=traction, friction=friction, direction=direction)
        return self.response(asked)

    def first_yield(
        self,
        yield_stress: Pressure,
        body: str = "body",
        *,
        friction: float | Array | None = None,
        direction: float = 0.0,
    ) -> Any:
        """Return the load, N, and depth, m, at which a body first yields below its surface.

        `roughcontact.responses.FirstYield` states the method.

        Parameters
        ----------
        yield_stress
            Yield stress in tension, Pa.
        body
            ``"body"`` or ``"counterbody"``.
        friction
            Coefficient of friction in full sliding, a number or shape (nx, ny); None: without friction.
        direction
            Direction of the traction on the body, degrees from x towards y.

        Returns
        -------
        roughcontact.responses.YieldPoint
            Load and depth.

        Raises
        ------
        InputError
            If the body has no stress, or the problem cannot be solved again.
        """
        asked = responses.create("first-yield", yield_stress, body=body, friction=friction, direction=direction)
        return self.response(asked)

    def leakage(self, *, axis: int = 0, viscosity: Quantity, pressure_drop: Pressure) -> Any:
        """Return the flow of a liquid through the gap, m3/s; `roughcontact.responses.GapFlow` states the equations.

        Parameters
        ----------
        axis
            Axis along which it flows: 0 (x) or 1 (y).
        viscosity
            Viscosity, Pa s.
        pressure_drop
            Pressure difference between the two sides, Pa.

        Returns
        -------
        roughcontact.responses.Leakage
            An `Estimate`, with the throats of the flow.

        Raises
        ------
        InputError
            If a number is not positive, or the axis neither 0 nor 1.
        """
        asked = responses.create("leakage", axis=axis, viscosity=viscosity, pressure_drop=pressure_drop)
        return self.response(asked)

    def flash_temperature(
        self,
        friction: float | Array,
        speed: Quantity | Sequence[Quantity],
        *,
        conductivity: Quantity | Sequence[Quantity],
        diffusivity: Quantity | Sequence[Quantity],
        direction: float = 0.0,
    ) -> Any:
        """Return how much hotter the contact is than the bodies, K, by the heat of friction in steady sliding.

        `roughcontact.responses.SlidingHeat` states the equations.

        Parameters
        ----------
        friction
            Coefficient of friction, a number or shape (nx, ny).
        speed
            Speed at which the surface of the counterbody passes the contact, which stands still on the body, m/s; or of
            each (body, counterbody) past a contact at rest, as in rolling with slip.
        conductivity
            Thermal conductivity of both bodies, or of each (body, counterbody), W/(m K); zero of one that does not
            conduct.
        diffusivity
            Thermal diffusivity of both or of each, m2/s.
        direction
            Direction of the speed, degrees from x towards y.

        Returns
        -------
        roughcontact.responses.FlashTemperature
            An `Estimate` of the maximum, with the mean, the partition of the heat and the fields.

        Raises
        ------
        InputError
            If a number is out of its range, nothing slides, or the bodies are not homogeneous half-spaces.
        """
        asked = responses.create(
            "flash-temperature",
            friction,
            speed,
            conductivity=conductivity,
            diffusivity=diffusivity,
            direction=direction,
        )
        return self.response(asked)

    def gradient(self, of: str | Callable[[Array], Array], with_respect_to: str = "heights") -> Array:
        """Return the derivatives of a number of the contact, shape (nx, ny) for heights, else ().

        `roughcontact.responses.Gradient` states the equations.

        Parameters
        ----------
        of
            ``"force"``, ``"approach"``, ``"mean-gap"``, ``"participation"`` or ``"area"``; or a function that takes the
            pressure, shape (nx, ny), Pa, and returns the derivative of a number with respect to it, of that shape.
        with_respect_to
            ``"heights"``, m, ``"modulus"``, Pa, or ``"load"``, as it was given.
        """
        return self.response(responses.create("gradient", of, with_respect_to=with_respect_to))

    def partial_slip(self, *, tangential_force: Force, friction: float, axis: int = 0, uncoupled: bool = False) -> Any:
        """Return the contact under a tangential force below that of sliding.

        `roughcontact.responses.CiavarellaJaeger` states the equations.

        Parameters
        ----------
        tangential_force
            Tangential force, N.
        friction
            Coefficient of friction.
        axis
            Direction of the force: 0 along x, 1 along y.
        uncoupled
            Whether to neglect, with a warning, that normal and tangential displacement of unlike bodies are coupled.

        Returns
        -------
        roughcontact.responses.PartialSlip
            Traction, slip, stick and displacement.

        Raises
        ------
        InputError
            If the force reaches that of sliding, the contact has saturated cells, or the bodies are unlike:
            `ContactProblem.path` serves them.
        """
        asked = responses.create(
            "partial-slip", tangential_force=tangential_force, friction=friction, axis=axis, uncoupled=uncoupled
        )
        return self.response(asked)

    def saturated_area(self, estimator: str | AreaEstimator = "level-set") -> Area:
        """Return the part of the contact area where the pressure has reached the limit; zero without a limit.

        limit - p and -gap satisfy the conditions of contact too, and the contact of this complementary problem is the
        area that is not saturated: the area estimators find its edge as well.

        Parameters
        ----------
        estimator
            Registered name or instance of an area estimator.

        Raises
        ------
        InputError
            If there is no such estimator.
        """
        return self.parts.ask(
            self, "saturated area", lambda one: estimate_saturated_area(heal(one._pressed), estimator)
        )

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """Likely mistakes, and limits of model and grid for this contact, in sentences; empty if there are none.

        The warnings of the `area` are not among them.
        """
        if not self.parts.is_whole:
            # They are those of the whole fields, which `gather` returns.
            return ()
        found = list_warnings(self._pressed, self._materials.values())
        return found if self.origin is None else (*found, *warn_of_attraction(self, self.origin))

    @cached_property
    def theory(self) -> TheoryBeside | None:
        """Persson's theory for the same surface and load; None if it does not hold.

        It holds on periodic boundaries without saturated cells, for nominally flat, isotropic, Gaussian roughness of
        many waves, most of them longer than four cells; grids have at most 2048 x 2048 cells.
        """
        return compare_with_theory(self)

    @cached_property
    def stickiness(self) -> Stickiness | None:
        """Whether the surfaces stick by theory, and the energy of full contact; None without adhesion.

        The energy needs a periodic boundary without saturated cells and a law that is the same everywhere, the
        criterion also the roughness of `theory` and a range that is short beside the heights.
        """
        return find_stickiness(self)

    @property
    def _materials(self) -> dict[str, Material]:
        return {} if self.origin is None else self.origin.materials
