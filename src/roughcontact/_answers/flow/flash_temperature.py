"""The flash temperature of a contact that slides."""

from __future__ import annotations

import math
from collections.abc import Sequence

import attrs
import numpy as np

from roughcontact._answers.areas.edges import pass_on_warnings, warn_if_uncertain
from roughcontact._answers.flow.conduction import Conduction
from roughcontact._answers.flow.partition import split_heat
from roughcontact._answers.subsurface.inputs import degrees
from roughcontact._base.arrays import Array, Pair, read_only, restore_state, unit_vector
from roughcontact._base.checks import number_or_array, pair
from roughcontact._base.units import Estimate, Quantity, outlined, percent, si
from roughcontact._parts.grid import Boundary, extend, grow, list_borders
from roughcontact._parts.kernels import SupportsConduction
from roughcontact._solve.problem import computing, problem_of
from roughcontact._solve.solution import Area, ContactSolution, Response, responses
from roughcontact.errors import InputError, NotConverged, argument

# Largest Peclet number of a cell, V dx / D: above it a cell passes before its heat has spread by a three-hundredth of
# it, and the integral over the time takes long.
_MAX_CELL_PECLET = 1e5
# Standard deviation of the maximum, over its fall from the hottest cell to the next ones; the same where the border
# cuts the contact, because the pressure is unbounded there; and over the maximum itself. Set, like the next ones, on
# balls of 2 to 14 cells and rough contacts of 4 to 9 cells a shortest wave, Peclet numbers 0 to 300.
_FALL_STD = 0.04
_BORDER_STD = 0.2
_MAXIMUM_STD = 2e-4
# Standard deviation of the mean over that of the temperature in the contact, times the fraction e of cells at the edge:
# linear and square in e. Of the fraction of heat, over it, times e.
_MEAN_STD = (0.04, 0.1)
_FRACTION_STD = 0.04


def _friction(value: float | Array) -> float | Array:
    return number_or_array(value, "The coefficient of friction")


def _conductivity(value: Quantity | Sequence[Quantity]) -> Pair:
    found = pair(value, "The thermal conductivity of the bodies", "W/(m K)", at_least=0.0)
    if found == (0.0, 0.0):
        raise InputError.about("The thermal conductivity of the bodies", value, "above 0 (W/(m K)) for one of them")
    return found


def _diffusivity(value: Quantity | Sequence[Quantity]) -> Pair:
    return pair(value, "The thermal diffusivity of the bodies", "m2/s", above=0.0)


def _speed(value: Quantity | Sequence[Quantity]) -> Pair:
    is_list = isinstance(value, (tuple, list)) or (isinstance(value, np.ndarray) and value.ndim > 0)
    found = pair(value if is_list else (0.0, value), "The speed of the surfaces", "m/s")  # type: ignore[arg-type]
    if found[0] == found[1]:
        raise InputError.about("The speed of the surfaces", value, "other than 0 (m/s), or two that differ, to slide")
    return found


@attrs.frozen(eq=False, kw_only=True)
class FlashTemperature(Estimate):
    """The temperature of a sliding contact above that of the bodies far away.

    Attributes
    ----------
    value
        Maximum in the contact, K; on a periodic boundary above the mean of each surface.
    uncertainty
        One standard deviation, K.
    unit
        ``"K"``.
    mean
        Mean over the contact area, K.
    fraction
        Fraction of the heat that flows into the body; the rest flows into the counterbody.
    blok
        Maximum by Blok's postulate, K: the partition is the same everywhere and makes the maxima of both bodies equal.
    blok_fraction
        Fraction of the heat into the body by it.
    heat
        Heat of friction, W.
    peclet
        Peclet number V a / 2D of each body (body, counterbody), a the radius of a circle as large as the hottest patch.
    temperatures
        Temperature of the surface of the body and of the counterbody, shape (2, nx, ny), K: the same in the contact. A
        body that does not conduct is not heated elsewhere.
    warnings
        Why the value must not be trusted, in sentences; empty without a reason.
    """

    value: float
    uncertainty: float
    unit: str = attrs.field(default="K", init=False)
    mean: Estimate
    fraction: Estimate
    blok: float
    blok_fraction: float
    heat: float
    peclet: Pair
    temperatures: Array = attrs.field(converter=read_only, repr=outlined)
    warnings: tuple[str, ...] = ()

    def __str__(self) -> str:
        numbers = " and ".join(f"{one:.3g}" for one in self.peclet)
        return (
            f"{_write(self)}, mean {_write(self.mean)}; "
            f"{percent(self.fraction.value)} of {si(self.heat, 'W', 3)} into the body; Peclet {numbers}; "
            f"by Blok {self.blok:.5g} K, {percent(self.blok_fraction)}{self._reasons}"
        )


def _write(estimate: Estimate) -> str:
    """Return a temperature in kelvin, also a thousand of them."""
    spread = percent(estimate.uncertainty / abs(estimate.value)) if estimate.value else f"{estimate.uncertainty:.2g} K"
    return f"{estimate.value:.5g} K +- {spread}"


@responses.register("flash-temperature")
@attrs.frozen(eq=False, getstate_setstate=False)
class SlidingHeat(Response[FlashTemperature]):
    r"""Flash temperature: how much hotter than the bodies a contact is by the heat of its friction, while it slides.

    The heat :math:`q = \mu p\, |V_1 - V_2|` flows into two half-spaces, whose surfaces move along x with the velocities
    V past the contact, which stands still. Steadily, with the conductivity k and the diffusivity D of a body,

    .. math:: k\, T(x, y) = \int_0^\infty \sqrt{\frac{D}{\pi t}} \iint
       \frac{e^{-[(x - x' - Vt)^2 + (y - y')^2] / 4Dt}}{4 \pi D t}\, q(x', y')\,
       \mathrm{d}x'\, \mathrm{d}y'\, \mathrm{d}t

    and the heat is divided such that both bodies have the same temperature in each cell in contact:

    .. math:: q_1 + q_2 = q, \qquad T_1[q_1] = T_2[q_2]

    On a free boundary the bodies are infinite. On a periodic one the mean temperature of each surface, which is that of
    the bulk, is omitted. Heat passes through the contact alone, and no transient is contained.

    Parameters
    ----------
    friction
        Coefficient of friction, a number or shape (nx, ny).
    speed
        Speed at which the surface of the counterbody passes the contact, which stands still on the body, m/s; or of
        each (body, counterbody) past a contact at rest, as in rolling with slip. Negative ones are backwards.
    conductivity
        Thermal conductivity of both bodies, or of each (body, counterbody), W/(m K); zero of one that does not conduct.
    diffusivity
        Thermal diffusivity, conductivity over density and specific heat, of both or of each, m2/s.
    direction
        Direction of the speed, degrees from x towards y.

    References
    ----------
    Jaeger, J. Proc. R. Soc. N.S.W. 76 (1942); Carslaw, Jaeger, Conduction of Heat in Solids (1959), sec. 10.7;
    Bos, Moes, J. Tribol. 117 (1995) 171-177; Blok, Proc. Inst. Mech. Eng. Gen. Disc. Lubr. 2 (1937) 222-235

    Examples
    --------
    >>> import roughcontact as rc
    >>> steel = rc.Elastic("210GPa", 0.3)
    >>> ball = rc.Body(rc.SphereSurface(radius="5mm"), steel)
    >>> problem = rc.ContactProblem(ball, rc.Body(rc.FlatSurface(), steel), grid=rc.Grid((64, 64), "400um"))
    >>> found = problem.solve(force=10).flash_temperature(0.2, "1m/s", conductivity="45W/m/K", diffusivity="12mm2/s")
    >>> print(f"{found.value:.1f} K, {100 * found.fraction.value:.0f} % of {found.heat:.3g} W into the ball")
    86.2 K, 31 % of 2 W into the ball
    """

    holds_with = frozenset({"tension", "shear"})
    reads = "contact pressure"
    memory_arrays = 48.0  # the waves of both bodies on a padded domain, and the search for the partition

    friction: float | Array = attrs.field(converter=_friction, repr=outlined, metadata={"unit": ""})
    speed: Pair = attrs.field(converter=_speed, metadata={"unit": "m/s"})
    conductivity: Pair = attrs.field(converter=_conductivity, kw_only=True, metadata={"plain_unit": "W/(m K)"})
    diffusivity: Pair = attrs.field(converter=_diffusivity, kw_only=True, metadata={"unit": "m2/s"})
    direction: float = attrs.field(default=0.0, converter=degrees, kw_only=True)

    __setstate__ = restore_state

    def respond(self, solution: ContactSolution) -> FlashTemperature:
        """Return the temperatures; see `Response.respond`.

        Raises
        ------
        NotConverged
            If the partition of heat is not found.
        """
        heat = self._find_heat(solution)
        _require_half_spaces(solution)
        self._require_slow(solution)
        with computing(problem_of(solution)):
            return self._measure(solution, heat)

    @property
    def _sliding(self) -> float:
        """The speed of the counterbody relative to the body, m/s."""
        return abs(self.speed[1] - self.speed[0])

    def _find_heat(self, solution: ContactSolution) -> Array:
        """Return the heat of friction, shape (nx, ny), W/m2."""
        shape = solution.grid.shape
        if np.ndim(self.friction) and np.shape(self.friction) != shape:
            raise InputError.about(
                "The shape of the coefficient of friction", np.shape(self.friction), f"() or {shape}"
            )
        return np.asarray(self.friction * solution.pressure * self._sliding)

    def _require_slow(self, solution: ContactSolution) -> None:
        """Raise `InputError` if a cell passes before its heat spreads."""
        fastest = max(abs(v) / d for v, d in zip(self.speed, self.diffusivity, strict=True))
        if (peclet := fastest * max(solution.grid.spacing)) > _MAX_CELL_PECLET:
            raise InputError.about(
                "The Peclet number of a cell, speed times its side over the diffusivity",
                peclet,
                f"at most {_MAX_CELL_PECLET:g}",
                "Check the units of speed and diffusivity, or refine the grid.",
            )

    def _measure(self, solution: ContactSolution, heat: Array) -> FlashTemperature:
        """Return the temperatures by some heat."""
        cells = solution.contact
        conduction = Conduction(solution.grid, solution.boundary)
        x, y = unit_vector(self.direction)
        bodies = [
            (k, d, (v * x, v * y))
            for k, d, v in zip(self.conductivity, self.diffusivity, self.speed, strict=True)
            if k > 0.0
        ]
        waves = [conduction.find_waves(*one) for one in bodies]
        alone = [conduction.apply(one, heat) for one in waves]
        maxima = [float(one[cells].max(initial=0.0)) for one in alone]
        if len(waves) == 1:
            into = 1.0 if self.conductivity[0] > 0.0 else 0.0
            fields = [alone[0], np.where(cells, alone[0], 0.0)][:: 1 if into else -1]
            maximum = maxima[0]
            blok_fraction = into
        else:
            inverse = 1.0 / (conduction.find_free_waves(*bodies[0]) + conduction.find_free_waves(*bodies[1]))
            flow, converged = split_heat(conduction, waves[0] + waves[1], inverse, alone[1], cells)
            if not converged:
                raise NotConverged("The partition of heat between the bodies did not converge.", solution)
            into = float(flow.sum()) / total if (total := float(heat.sum())) > 0.0 else 0.0
            fields = [conduction.apply(waves[0], flow), conduction.apply(waves[1], heat - flow)]
            maximum, blok_fraction = _follow_blok(*maxima)
        area = solution.area(uncertainty="model")
        field = fields[0 if self.conductivity[0] > 0.0 else 1]
        found = _find_maximum(solution, field)
        edge = _find_edge_fraction(solution)
        estimate = warn_if_uncertain(found.value, found.uncertainty, "K", pass_on_warnings(area))
        return FlashTemperature(
            value=found.value,
            uncertainty=found.uncertainty,
            mean=_find_mean(solution, field, area, edge),
            fraction=Estimate(into, _FRACTION_STD * edge * abs(into) if len(waves) == 2 else 0.0, ""),
            blok=maximum,
            blok_fraction=blok_fraction,
            heat=float(heat.sum()) * solution.grid.cell_area,
            peclet=self._find_peclet(solution, area, field),
            temperatures=np.stack(fields),
            warnings=estimate.warnings,
        )

    def _find_peclet(self, solution: ContactSolution, area: Area, field: Array) -> Pair:
        """Return the Peclet number of each body by the radius of the patch of the highest temperature."""
        patches = solution.patches
        if not patches.count:
            return 0.0, 0.0
        label = patches.labels.ravel()[int(np.argmax(np.where(solution.contact, field, -np.inf)))]
        areas = patches.areas if area.patches is None else area.patches
        radius = math.sqrt(float(areas[label - 1]) / math.pi)
        body, counterbody = (abs(v) * radius / (2.0 * d) for v, d in zip(self.speed, self.diffusivity, strict=True))
        return body, counterbody


def _require_half_spaces(solution: ContactSolution) -> None:
    """Raise `InputError` unless the temperature is that of homogeneous half-spaces, free or periodic."""
    if solution.boundary not in (Boundary.FREE, Boundary.PERIODIC):
        raise InputError(
            f"The flash temperature needs {argument('boundary', 'free')} or 'periodic': a line of contact without end "
            "heats a body at rest without end, and on 'wrapped' the mean temperature has no meaning."
        )
    if solution.moduli is not None or isinstance(problem_of(solution).plan.kernel, SupportsConduction):
        raise InputError(
            "The flash temperature is known for homogeneous half-spaces, but this kernel is of layers, of a graded "
            f"body or of a crystal: choose {argument('kernel', 'love')}."
        )
    if solution.boundary is Boundary.PERIODIC and solution.contact.all():
        raise InputError(
            "The surfaces touch everywhere and repeat, so that the bulk behind them decides where the heat flows: "
            f"lower the load, or choose {argument('boundary', 'free')}."
        )


def _follow_blok(body: float, counterbody: float) -> tuple[float, float]:
    """Return the maximum by Blok, K, and the fraction into the body, from the maxima if all heat went into each."""
    both = body + counterbody
    return (body * counterbody / both, counterbody / both) if both > 0.0 else (0.0, 0.0)


def _find_maximum(solution: ContactSolution, field: Array) -> Estimate:
    """Return the maximum of the temperature in the contact, of a parabola around its hottest cell."""
    if not solution.contact.any():
        return Estimate(0.0, 0.0, "K")
    i, j = divmod(int(np.argmax(np.where(solution.contact, field, -np.inf))), field.shape[1])
    around = extend(field, 1, solution.boundary)[i : i + 3, j : j + 3]
    top = float(around[1, 1])
    slope = 0.5 * np.array([around[2, 1] - around[0, 1], around[1, 2] - around[1, 0]])
    twist = 0.25 * (around[2, 2] - around[2, 0] - around[0, 2] + around[0, 0])
    bend = np.array([
        [around[2, 1] - 2.0 * top + around[0, 1], twist],
        [twist, around[1, 2] - 2.0 * top + around[1, 0]],
    ])  # fmt: skip
    fall = -float(np.trace(bend))
    value = top
    if np.isfinite(bend).all() and np.linalg.eigvalsh(bend)[-1] < 0.0:
        place = np.clip(-np.linalg.solve(bend, slope), -0.5, 0.5)
        value += float(slope @ place + 0.5 * place @ bend @ place)
    cut = any(border.any() for border in list_borders(solution.contact, solution.boundary))
    std = math.hypot((_BORDER_STD if cut else _FALL_STD) * fall, _MAXIMUM_STD * value)
    return Estimate(value, std, "K")


def _find_edge_fraction(solution: ContactSolution) -> float:
    """Return the fraction of the cells in contact that are beside open ones."""
    cells = solution.contact
    edge = cells & grow(~cells, 1, solution.boundary)
    return float(np.count_nonzero(edge)) / max(int(np.count_nonzero(cells)), 1)


def _find_mean(solution: ContactSolution, field: Array, area: Area, edge: float) -> Estimate:
    """Return the mean over the contact area: what the cells have too much of it is as hot as those at its edge."""
    cells = solution.contact
    if not cells.any() or area.value == 0.0:
        return Estimate(0.0, 0.0, "K")
    hot = field[cells]
    beside = field[cells & grow(~cells, 1, solution.boundary)]
    at_edge = float(beside.mean()) if beside.size else float(hot.mean())
    counted = hot.size * solution.grid.cell_area
    mean = (float(hot.mean()) * counted - at_edge * (counted - area.value)) / area.value
    linear, square = _MEAN_STD
    std = (linear * edge + square * edge**2) * float(hot.std())
    return Estimate(mean, math.hypot(std, (at_edge - mean) * area.uncertainty / area.value), "K")
