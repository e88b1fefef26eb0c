"""What is asked of a solved contact: areas, responses, warnings, and what theory says of it."""

from __future__ import annotations

import math
from functools import cached_property
from typing import Any, ClassVar, Self, TypeVar, overload

import attrs
import numpy as np

from roughcontact._base.checks import choice
from roughcontact._base.units import Estimate
from roughcontact._parts.materials import Material
from roughcontact._parts.surfaces import HeightMap
from roughcontact._solve.solution.additions import Addition
from roughcontact._solve.solution.attraction import interpolate_peak, warn_of_attraction, widen_area
from roughcontact._solve.solution.healing import heal
from roughcontact._solve.solution.judgement import (
    UNCERTAINTIES,
    explain_uncertainties,
    judge,
    judge_area,
    judge_maps,
)
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
    list_fields,
    require_to_hold,
    responses,
    warn_of_changes,
)
from roughcontact._solve.solution.sampling import defer_area_sampling
from roughcontact._solve.solution.shear import ShearFields
from roughcontact._solve.solution.theory import Stickiness, TheoryBeside, compare_with_theory, find_stickiness
from roughcontact._solve.solution.tip import judge_area_by_tip, judge_by_tip, warn_of_tip
from roughcontact.errors import InputError

T = TypeVar("T")
E = TypeVar("E", bound=Estimate)


@attrs.frozen(eq=False, kw_only=True)
class ContactAnswers(ShearFields):
    """The fields of a solved contact, and the answers derived from them."""

    _public_name: ClassVar[str] = "ContactSolution"

    def area(self, estimator: str | AreaEstimator = DEFAULT_AREA, *, uncertainty: str | None = None) -> Area:
        """Return the real contact area.

        Parameters
        ----------
        estimator
            Registered name or instance of an area estimator; ``"blend"``, the default, stands for the one that holds
            where loads have changed the surfaces.
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
            return self._keep(f"area, {kind}", lambda: self._add_errors(judge_area(self, found, kind), "area"))
        area = self._estimate_area(areas.resolve(estimator))
        judged = judge(self, area, kind, lambda one: one.area(estimator, uncertainty="model"))
        return self._add_errors(judged, "area")

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
        normal._found["shift"] = self._shift
        if self._is_changed:
            normal._found["offset"] = self._offset
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
        require_to_hold(response, self._laws, self._limits)
        if response.reads == "state":
            return self
        return self._normal if response.reads == "total pressure" else self._pressed

    @property
    def _pressed(self) -> Self:
        """The normal contact with its contact pressure alone, whose gap is the same."""
        if self.tension is None:
            return self._normal
        nothing = np.zeros(self.grid.shape)
        return self._keep("pressed", lambda: self._normal._evolve(pressure=self.contact_pressure, tension=nothing))

    def _estimate_area(self, chosen: AreaEstimator) -> Area:
        area = self.parts.ask(self, chosen, lambda one: chosen.estimate(heal(one._view(chosen))))
        if not isinstance(area, Area) or not np.isfinite([area.value, area.uncertainty]).all():
            raise InputError(
                f"The area estimator {chosen!r} returned {area!r}, which is not an Area of finite numbers."
            )
        area = judge_maps(area, self._maps, self.grid.resolved.cell_area)
        area = judge_area_by_tip(area, self)
        area = warn_of_changes(area, chosen, self._name_default_area())
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
        if self.tension is None:
            return self.response("peak-pressure", uncertainty=uncertainty)
        return judge_by_tip(interpolate_peak(self), self, "peak-pressure")

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
        name = responses.name_of(type(asked)) or ""
        if chosen is not asked:
            if kind in ("auto", "model"):
                return judge_by_tip(found, self, name)
            raise InputError(
                "Solved again the contact has no traction: with friction this answer is that of the model."
            )
        judged = judge(self, found, kind, lambda one: one.response(asked, uncertainty="model"), asked.flagged_factors)
        return judge_by_tip(self._add_errors(judged, name), self, name)

    def _add_errors(self, found: E, name: str) -> E:
        """Return a number of a name with what laws add to its uncertainty."""
        errors = [error for one in self.added if (error := one.list_errors(self).get(name, 0.0))]
        return attrs.evolve(found, uncertainty=math.hypot(found.uncertainty, *errors)) if errors else found

    def _add_traction(self, asked: Any) -> Any:
        """Return a response to pressure and traction of a contact with friction."""
        require_to_hold(asked, self._laws, self._limits)
        if "traction" not in list_fields(asked):
            return asked
        own = [name for name in ("traction", "friction") if getattr(asked, name, None) is not None]
        if own:
            raise InputError(f"The state has its own traction: omit {own[0]}= of the response.")
        return attrs.evolve(asked, traction=self.shear)

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
        return found if self.origin is None else (*found, *warn_of_attraction(self, self.origin), *warn_of_tip(self))

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
