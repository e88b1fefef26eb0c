"""Thermal and electrical contact conductance."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache

import attrs
import numpy as np
import scipy

from roughcontact._answers.areas.edges import pass_on_warnings, warn_if_uncertain
from roughcontact._answers.linear.stiffness import (
    correct_edges,
    describe_full_contact,
    edge_length,
    require_mean_gap,
)
from roughcontact._answers.linear.tangent import Tangent
from roughcontact._base.arrays import Array, Pair, read_only
from roughcontact._base.checks import number, pair
from roughcontact._base.units import Estimate, Quantity, outlined, percent, si
from roughcontact._parts.kernels import BoundKernel, SupportsConduction, has_layers
from roughcontact._solve.problem import ContactProblem, problem_of
from roughcontact._solve.solution import Area, ContactSolution, Response, responses
from roughcontact.errors import InputError, argument

# Relative residual: the error of the conductance is its square; of the currents of the patches, the residual itself.
_RESIDUAL_TOLERANCE = 1e-3
# The integral over waves of the constriction of a disc: Gauss points on each panel, half waves, and panels that halve
# towards zero and double beyond; and radii between which it is interpolated, over their logarithm.
_POINTS = 12
_HALF_WAVES = 24
_HALVINGS = 24
_MAX_RADII = 200
# Maximum resistance of a film, m2 K/W or Ohm m2: that of a perfect insulator.
_MAX_FILM_RESISTANCE = 1e20
# Units of heat or of current, which a text may omit.
_CONDUCTIVITY_UNIT = "W/(m K) or S/m"
_FILM_UNIT = "m2 K/W or Ohm m2"


def _conductivity(value: Quantity | Sequence[Quantity]) -> Pair:
    return pair(value, "The conductivity of the bodies", _CONDUCTIVITY_UNIT, above=0.0)


def _film(value: Quantity) -> float:
    # More would leave the range of float32, in which the flow is found.
    return number(value, "The film resistance", _FILM_UNIT, at_least=0.0, at_most=_MAX_FILM_RESISTANCE)


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
        largest of all shapes; on layers up to 0.4 % more.
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
        relative = percent(self.uncertainty / self.value) if self.value > 0.0 else "0 %"
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

    with the conductivities k of the bodies and the film resistance r_f. E* cancels. On layers that know their
    conductivity (`roughcontact.typing.SupportsConduction`) K is instead their response to flow. On a periodic boundary
    G is the gap conductance of a model of the bodies: its inverse is the excess resistance over perfect contact. On a
    free boundary it contains the spreading into two infinite half-spaces. Conduction through the gap, by gas or
    radiation, is not contained.

    Parameters
    ----------
    conductivity
        Of both bodies, or of each (body, counterbody), under any layers, W/(m K) for heat or S/m for current.
    film_resistance
        Resistance of a film on the spots times its area, m2 K/W or Ohm m2.

    References
    ----------
    Barber, Proc. R. Soc. A 459 (2003) 53-66, https://doi.org/10.1098/rspa.2002.1038;
    Greenwood, Brit. J. Appl. Phys. 17 (1966) 1621-1632, https://doi.org/10.1088/0508-3443/17/12/310
    """

    holds_with = frozenset({"tension", "shear"})
    fails_with = frozenset({"inner moduli"})
    flagged_factors = 0.5, 0.1
    reads = "contact pressure"

    conductivity: Pair = attrs.field(converter=_conductivity, metadata={"plain_unit": _CONDUCTIVITY_UNIT})
    film_resistance: float = attrs.field(default=0.0, converter=_film, metadata={"plain_unit": _FILM_UNIT})

    def respond(self, solution: ContactSolution) -> Conductance:
        """Return the conductance; see `Response.respond`."""
        require_mean_gap(solution, "conductance")
        conduction = _find_conduction(solution, self.conductivity)
        area = solution.area(uncertainty="model")
        warnings = pass_on_warnings(area)
        analogy = conduction.analogy
        known = _find_areas(solution, area)
        constriction = conduction.find_constriction(np.sqrt(known / np.pi))
        film = self.film_resistance / known
        compliance = analogy * self.film_resistance * float(solution.patches.areas.sum()) / max(area.value, 1e-300)
        added = compliance if known.size else 0.0
        tangent = Tangent(solution, saturated=True, compliance=added, kernel=conduction.kernel)
        if tangent.is_rigid:
            currents = np.full(known.size, math.inf)
            std = 0.0
            warnings = (*warnings, describe_full_contact("conductance"))
        elif not known.size:
            currents = np.zeros(0)
            std = 0.0
        else:
            answer = tangent.solve(np.ones(solution.grid.shape), _RESIDUAL_TOLERANCE)
            correction = correct_edges(
                solution, answer.values, tangent.cells, area, compliance, conduction.edge_modulus
            )
            parts = solution.patches.sum(answer.values) * solution.grid.cell_area
            total = answer.product * solution.grid.cell_area
            currents = analogy * (parts * (total / float(parts.sum())) + correction.patches)
            std = analogy * correction.uncertainty
        value = float(np.sum(currents))
        warnings = warn_if_uncertain(value, std, "W/K", warnings).warnings
        return Conductance(value, std, value / solution.grid.area, currents, constriction, film, warnings)


@attrs.frozen(eq=False)
class _Conduction:
    """How the bodies conduct.

    Attributes
    ----------
    resistivity
        1/k1 + 1/k2 of the half-spaces, under any layers, m K/W.
    analogy
        Displacement by a unit pressure over temperature by a unit flow; one where `kernel` relates both.
    edge_modulus
        What the contact modulus is to pressure and displacement, of waves as short as the edge.
    kernel
        The kernel of temperature by flow; None for that of the contact.
    """

    resistivity: float
    analogy: float
    edge_modulus: float
    kernel: BoundKernel | None = None

    def find_constriction(self, radii: Array) -> Array:
        r"""Return the resistance of a disc with each radius, shape (n,), K/W.

        On layers the flow through a unit disc is that of an isothermal one on a half-space and a uniform one, in the
        parts of the smallest energy (Thomson's principle), with their transforms t and the modulus E of waves:


        .. math:: \min \frac{1}{2\pi a} \int_0^\infty \frac{2}{E(x/a)}\,t^2\,\mathrm{d}x, \qquad
           t = (1 - c)\,\frac{\sin x}{x} + c\,\frac{2 J_1(x)}{x}
        """
        moduli = None
        x, weights = _list_points()
        sizes = np.unique(radii)
        if sizes.size > _MAX_RADII:
            sizes = np.geomspace(sizes[0], sizes[-1], _MAX_RADII)
        if self.kernel is not None:
            moduli = self.kernel.kernel.effective_modulus((x / sizes[:, np.newaxis]).ravel(), 0.5 * self.resistivity)
        if moduli is None or not radii.size:
            return np.asarray(0.25 * self.resistivity / radii)
        isothermal, both, uniform = weights @ (2.0 / moduli).reshape(sizes.size, x.size).T
        smallest = (isothermal * uniform - both**2) / (isothermal + uniform - 2.0 * both)
        return np.asarray(np.interp(np.log(radii), np.log(sizes), smallest) / (2.0 * np.pi * radii))


def _find_conduction(solution: ContactSolution, conductivity: Pair) -> _Conduction:
    resistivity = sum(1.0 / value for value in conductivity)
    problem = problem_of(solution)
    kernel = problem.plan.kernel
    if isinstance(kernel, SupportsConduction):
        kernel = kernel.conduction_kernel(_find_substrate(kernel, problem, conductivity))
        mean = 0.5 * resistivity
        unit = solution.grid.spacing[0] * mean
        bound = attrs.evolve(problem.convolution.setup.kernel, kernel=kernel, compliance=mean, unit=unit)
        moduli = kernel.effective_modulus(np.array([1.0 / edge_length(solution.grid)]), mean)
        return _Conduction(resistivity, 1.0, 1.0 / mean if moduli is None else float(moduli[0]), bound)
    if solution.moduli is not None:
        raise InputError(
            "The conductance follows from the stiffness of two isotropic half-spaces, but this kernel is of a graded "
            "body, of a crystal or of layers that do not state how they conduct: choose "
            f"{argument('kernel', 'love')}, or a kernel "
            "with the conductivity of its layers."
        )
    return _Conduction(resistivity, 2.0 / (solution.modulus * resistivity), solution.modulus)


def _find_substrate(kernel: SupportsConduction, problem: ContactProblem, conductivity: Pair) -> float:
    """Return the conductivity of the body under the layers: of two alike ones, of the first."""
    for name, value in zip(("body", "counterbody"), conductivity, strict=True):
        if has_layers(kernel, name, getattr(problem, name).material):
            return value
    raise InputError(
        f"The conductance needs to know which body carries the layers, but neither {problem.body.material!r} nor "
        f"{problem.counterbody.material!r} is the substrate of {kernel!r}."
    )


@lru_cache(maxsize=1)
def _list_points() -> tuple[Array, Array]:
    """Return nodes x, shape (n,), and weights of the products of both transforms of flows, shape (3, n).

    Up to some half waves the products are as they are; beyond, their means over a half wave.
    """
    at, weight = np.polynomial.legendre.leggauss(_POINTS)
    last = np.pi * _HALF_WAVES
    near = np.pi * 2.0 ** np.arange(-_HALVINGS, 1.0)
    far = last * 2.0 ** np.arange(1.0, _HALVINGS + 1.0)
    edges = np.concatenate(([0.0], near, np.pi * np.arange(2.0, _HALF_WAVES + 1.0), far))
    half = 0.5 * np.diff(edges)[:, np.newaxis]
    x = (edges[:-1, np.newaxis] + half * (at + 1.0)).ravel()
    sine = np.sin(x)
    bessel = 2.0 * scipy.special.j1(x)
    means = np.array([np.full(x.size, 0.5), 1.0 / np.sqrt(np.pi * x), 4.0 / (np.pi * x)])
    products = np.where(x < last, np.array([sine**2, sine * bessel, bessel**2]), means) * (half * weight).ravel() / x**2
    # Exact of a half-space.
    exact = np.array([0.5 * np.pi, 0.5 * np.pi, 16.0 / (3.0 * np.pi)])
    return x, products * (exact / products.sum(axis=1))[:, np.newaxis]


def _find_areas(solution: ContactSolution, area: Area) -> Array:
    """Return the area of each patch, above zero."""
    counted = solution.patches.areas
    return counted if area.patches is None else np.maximum(area.patches, 0.01 * counted)
