"""The responses of a contact that are asked by name, as methods with their arguments."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, ClassVar

import attrs

from roughcontact._base.arrays import Array
from roughcontact._base.units import Estimate, Force, Length, Pressure, Quantity
from roughcontact._solve.solution.answers import ContactAnswers
from roughcontact._solve.solution.results import (
    responses,
)


@attrs.frozen(eq=False, kw_only=True)
class ContactResponses(ContactAnswers):
    """A solved contact, and its responses."""

    _public_name: ClassVar[str] = "ContactSolution"

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
