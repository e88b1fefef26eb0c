"""The solution of a contact: its fields, its certificate, and the answers derived from them."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, TypeVar, overload

import attrs
import numpy as np

from roughcontact._base import checks
from roughcontact._base.arrays import Array
from roughcontact._base.registry import find_view
from roughcontact._base.tables import Result
from roughcontact._base.units import Estimate, Force, Length, Pressure, Quantity
from roughcontact._parts.materials import Material
from roughcontact._parts.surfaces import HeightMap
from roughcontact._solve.solution import storage
from roughcontact._solve.solution.additions import Addition
from roughcontact._solve.solution.attraction import interpolate_peak, warn_of_attraction, widen_area
from roughcontact._solve.solution.healing import heal
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
    require_with_friction,
    responses,
)
from roughcontact._solve.solution.sampling import PlaceStatistics, find_area_sampling, find_place_statistics
from roughcontact._solve.solution.shear import ShearFields
from roughcontact._solve.solution.summary import abbreviate, summarize
from roughcontact._solve.solution.theory import Stickiness, TheoryBeside, compare_with_theory, find_stickiness
from roughcontact._solve.solution.writers import describe_as_data, to_pyvista, write_solution
from roughcontact.errors import InputError

if TYPE_CHECKING:
    from roughcontact.responses import Conductance, Leakage, PartialSlip, Stress, YieldPoint

T = TypeVar("T")


@attrs.frozen(eq=False, kw_only=True)
class ContactSolution(Result, ShearFields):
    """A solved contact: its fields, its certificate, and the answers derived from them.

    With friction it is the end of one step of a path, or steady sliding: beside the normal contact it has ``shear``,
    ``slip``, ``stick`` and the other fields of friction. Of unlike bodies the initial gap is that changed by the
    traction, of like ones that without friction.

    Examples
    --------
    >>> import roughcontact as rc
    >>> wave = rc.WavySurface(amplitude=1e-6, wavelength=50e-6)
    >>> body = rc.Body(wave, rc.Elastic(young=210e9, poisson=0.3))
    >>> problem = rc.ContactProblem(body, grid=rc.Grid((32, 32), 100e-6), boundary="periodic")
    >>> solution = problem.solve(pressure=100e6)
    >>> solution.pressure.shape
    (32, 32)
    >>> print(solution.status)
    converged: the conditions of contact hold within the tolerance
    >>> print(solution.area())
    (176.343 +- 0.056) µm2, (1.76343 +- 0.00056) % of nominal [blend]
    """

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
        # The default area is kept, because every number and response needs it.
        default = isinstance(estimator, str) and estimator == DEFAULT_AREA
        return self._default_area if default else self._estimate_area(areas.resolve(estimator))

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

    @property
    def _normal(self) -> ContactSolution:
        """The normal contact alone, which area and responses read."""
        return self._keep("normal", lambda: attrs.evolve(self, added=())) if self.added else self

    def _add(self, addition: Addition, **changes: Any) -> ContactSolution:
        """Return the state with what a physics adds in place of its former addition; the normal contact is the same."""
        others = tuple(one for one in self.added if one.kind != addition.kind)
        state = attrs.evolve(self, added=(*others, addition), **changes)
        state._found["normal"] = self._normal
        return state

    @cached_property
    def _default_area(self) -> Area:
        if self.added:
            return self._normal._default_area
        return self._estimate_area(areas.resolve(DEFAULT_AREA if self.tension is None else DEFAULT_ADHESIVE_AREA))

    def _view(self, response: Response[Any]) -> ContactSolution:
        """Return what a response reads of the solution: with adhesion the pressure that it holds for."""
        if self.tension is None:
            return self._normal
        if response.with_adhesion == "refused":
            raise InputError(
                f"{type(response).__name__} does not hold for surfaces that attract each other: it knows no tension."
            )
        return self._normal if response.with_adhesion == "total pressure" else self._pressed

    @cached_property
    def _pressed(self) -> ContactSolution:
        """The solution with its contact pressure alone, whose gap is the same."""
        return attrs.evolve(self._normal, pressure=self.contact_pressure, tension=np.zeros(self.grid.shape))

    def _estimate_area(self, chosen: AreaEstimator) -> Area:
        area = chosen.estimate(heal(self._view(chosen)))
        if not isinstance(area, Area) or not np.isfinite([area.value, area.uncertainty]).all():
            raise InputError(
                f"The area estimator {chosen!r} returned {area!r}, which is not an Area of finite numbers."
            )
        area = judge_maps(area, self._maps, self.grid.resolved.cell_area)
        area = area if self.origin is None else widen_area(area, self, self.origin)
        return attrs.evolve(area, relative_sampling=find_area_sampling(self))

    @cached_property
    def _place(self) -> PlaceStatistics | None:
        return find_place_statistics(heal(self._normal), self.non_measured)

    @cached_property
    def _maps(self) -> tuple[HeightMap, ...]:
        return () if self.origin is None else self.origin.maps

    def peak_pressure(self) -> Estimate:
        """Return the maximum contact pressure between the cells, Pa; see `roughcontact.responses.PeakPressure`."""
        return self.response("peak-pressure") if self.tension is None else interpolate_peak(self)

    @overload
    def response(self, response: NameOfNumber) -> Estimate: ...
    @overload
    def response(self, response: Response[T]) -> T: ...
    @overload
    def response(self, response: str) -> Any: ...
    def response(self, response: str | Response[Any]) -> Any:
        """Return a quantity of the contact, or its response to a small change, a current or a flow.

        Parameters
        ----------
        response
            Registered name or instance of a response. The names of those without arguments are ``"peak-pressure"``,
            ``"perimeter"``, ``"patches"``, ``"mean-gap"``, ``"approach"`` (since the first touch of the summits between
            the cells), ``"stiffness"`` and ``"tangential-stiffness"``; ``roughcontact.responses.create`` makes others.
            With friction a response with a field ``traction``, such as the stress, is that under pressure and traction,
            others are those of the normal contact.

        Raises
        ------
        InputError
            If there is no such response, or it means nothing for this contact or has no value; with friction also if
            it states a traction or a friction of its own.
        """
        asked: Any = responses.resolve(response)
        return ask(self, self._add_traction(asked) if self.added else asked)

    def _add_traction(self, asked: Any) -> Any:
        """Return a response to pressure and traction of a contact with friction."""
        require_with_friction(asked)
        if "traction" not in list_fields(asked):
            return asked
        own = [name for name in ("traction", "friction") if getattr(asked, name, None) is not None]
        if own:
            raise InputError(f"The state has its own traction: omit {own[0]}= of the response.")
        return attrs.evolve(asked, traction=self.shear)

    def stiffness(self) -> Estimate:
        """Return the normal stiffness dF/d(approach), N/m; `roughcontact.responses.Stiffness` states the equations."""
        return self.response("stiffness")

    def stability(self) -> Estimate:
        """Return how far surfaces that attract each other are from a jump: 1 far away, 0 at one.

        `roughcontact.responses.StabilityMargin` states the equation.
        """
        return self.response("stability")

    def conductance(self, conductivity: Quantity | Sequence[Quantity], film_resistance: Quantity = 0.0) -> Conductance:
        """Return the thermal or electrical contact conductance, W/K or S.

        `roughcontact.responses.ContactConductance` states the equations.

        Parameters
        ----------
        conductivity
            Conductivity of both bodies, or of each (body, counterbody), W/(m K) for heat or S/m for current; that of
            layers is with the kernel.
        film_resistance
            Resistance of a film on the spots times its area, m2 K/W or Ohm m2.

        Raises
        ------
        InputError
            If a number is not positive, the boundary has no conductance, or that of a layer is not known.
        """
        asked = responses.create("conductance", conductivity, film_resistance=film_resistance)
        found: Conductance = self.response(asked)
        return found

    def stress(
        self,
        depths: Length | Array | Sequence[Length] | None = None,
        body: str = "body",
        *,
        traction: Array | None = None,
        friction: float | Array | None = None,
        direction: float = 0.0,
    ) -> Stress:
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

        Raises
        ------
        InputError
            If the body has no stress: it is rigid or layered; or if a traction has another shape than the grid.
        """
        asked = responses.create("stress", depths, body=body, traction=traction, friction=friction, direction=direction)
        stress: Stress = self.response(asked)
        return stress

    def first_yield(
        self,
        yield_stress: Pressure,
        body: str = "body",
        *,
        friction: float | Array | None = None,
        direction: float = 0.0,
    ) -> YieldPoint:
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

        Raises
        ------
        InputError
            If the body has no stress, or the problem cannot be solved again.
        """
        asked = responses.create("first-yield", yield_stress, body=body, friction=friction, direction=direction)
        found: YieldPoint = self.response(asked)
        return found

    def leakage(self, *, axis: int = 0, viscosity: Quantity, pressure_drop: Pressure) -> Leakage:
        """Return the flow of a liquid through the gap, m3/s; `roughcontact.responses.GapFlow` states the equations.

        Parameters
        ----------
        axis
            Axis along which it flows: 0 (x) or 1 (y).
        viscosity
            Viscosity, Pa s.
        pressure_drop
            Pressure difference between the two sides, Pa.

        Raises
        ------
        InputError
            If a number is not positive, or the axis neither 0 nor 1.
        """
        asked = responses.create("leakage", axis=axis, viscosity=viscosity, pressure_drop=pressure_drop)
        found: Leakage = self.response(asked)
        return found

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

    def partial_slip(
        self, *, tangential_force: Force, friction: float, axis: int = 0, uncoupled: bool = False
    ) -> PartialSlip:
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

        Raises
        ------
        InputError
            If the force reaches that of sliding, the contact has saturated cells, or the bodies are unlike:
            `ContactProblem.path` serves them.
        """
        asked = responses.create(
            "partial-slip", tangential_force=tangential_force, friction=friction, axis=axis, uncoupled=uncoupled
        )
        found: PartialSlip = self.response(asked)
        return found

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
        return estimate_saturated_area(heal(self._normal if self.tension is None else self._pressed), estimator)

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """Likely mistakes, and limits of model and grid for this contact, in sentences; empty if there are none.

        The warnings of the `area` are not among them.
        """
        pressed = self._normal if self.tension is None else self._pressed
        found = list_warnings(pressed, self._materials.values())
        return found if self.origin is None else (*found, *warn_of_attraction(self, self.origin))

    @cached_property
    def theory(self) -> TheoryBeside | None:
        """Persson's theory for the same surface and load; None if it does not hold.

        It holds on periodic boundaries without saturated cells, for nominally flat, isotropic, Gaussian roughness of
        many waves, most of them longer than four cells; grids have at most 2048 x 2048 cells.
        """
        return compare_with_theory(self) if self.tension is None and not self.added else None

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

    def verify(self) -> None:
        """Recompute the certificate from the fields, with friction from those of the state before too.

        Raises
        ------
        InputError
            If they contradict each other or the problem, or the solution is from a file: `ContactProblem.verify` takes
            its problem.
        """
        if self.origin is None or self.origin.source is None:
            raise InputError("The solution does not hold its problem: call problem.verify(solution).")
        self.origin.source.verify(self)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the solution to a file, completely or not at all.

        Parameters
        ----------
        path
            Its ending names one of the registered ``writers``; an existing file is replaced. ``.npz``, or ``.nc`` for
            netCDF with units (extra ``store``), can be loaded again: they hold the fields, shape (nx, ny), under
            their own names, the force, approach and area, the versions of the packages, and the problem: each part by
            its registered name and fields; with friction also the state before, so that it is verified alone.
            A warning names parts whose class is not registered. ``.html`` is the report,
            ``.vti`` image data for ParaView, ``.json`` what `to_dict` returns.

        Raises
        ------
        InputError
            If there is no such folder.
        MissingPackage
            If netCDF is asked for without its packages.
        """
        write_solution(self, checks.path(path, "The file"))

    def plot(self, panel: Any = None, *, axes: Any = None, dark: bool = False) -> Any:
        """Draw the contact (extra ``plot``).

        Parameters
        ----------
        panel
            Registered name or instance of one panel; None: the four most important ones, side by side.
        axes
            Matplotlib's axes to draw one panel on; None: new ones.
        dark
            Whether the background is dark.

        Returns
        -------
        matplotlib.axes.Axes or matplotlib.figure.Figure
            The axes of one panel, or the figure of several.
        """
        return find_view("panels")("solution", self, panel, axes, checks.flag(dark, "dark="))

    def plot_3d(self, *, exaggeration: float | None = None, dark: bool = False) -> Any:
        """Return a `pyvista.Plotter` of the combined heights in space, coloured by the pressure (extra ``vtk``).

        Heights are drawn `exaggeration` times as high; None: 0.12 domains from peak to valley, at most.
        """
        return find_view("solution-3d")(self, exaggeration, dark)

    @classmethod
    def load(cls, path: str | os.PathLike[str], *, verify: bool = True) -> ContactSolution:
        """Return the solution in a file that `save` has written.

        Its problem can be solved again with ``ContactProblem(**solution.origin.problem)``, once the classes
        that ``solution.origin.missing`` names are registered. A file cannot run code: only registered
        classes and public ones of this package are built.

        Parameters
        ----------
        path
            The file.
        verify
            Whether to build the problem and recompute displacement and residuals from the pressure: the time of one
            convolution. False takes them from the file.

        Raises
        ------
        InputError
            If there is no such file, or it is damaged, of another kind or of another format; if its content
            contradicts itself, or cannot be verified because a class of the problem is not registered.
        """
        file = checks.path(path, "The file")
        solution = cls(**storage.read(file))
        if checks.flag(verify, "verify="):
            storage.verify(file, solution)
        return solution

    def to_dict(self) -> dict[str, Any]:
        """Return answers with uncertainty and unit, certificate, warnings and inputs as plain data, in SI units.

        Its types are those of JSON; what is not known is None. ``roughcontact solve --json`` prints the same.
        """
        return describe_as_data(self)

    def to_xarray(self) -> Any:
        """Return the solution as an `xarray.Dataset` over x and y, m, with units (extra ``store``)."""
        return storage.to_xarray(self)

    def to_pyvista(self) -> Any:
        """Return the solution as `pyvista.ImageData`, for views in three dimensions (extra ``vtk``).

        Its cells, in the plane z = 0 about the centre of the domain, have ``pressure``, Pa, ``gap``, ``initial_gap``,
        ``displacement`` and the ``heights`` of the body, m, and ``contact``; the scalars, as ``force``, are field data.
        """
        return to_pyvista(self)

    def __str__(self) -> str:
        return summarize(self, [one for one in self._maps if not one.periodic], self._materials)

    def __repr__(self) -> str:
        return abbreviate(self)
