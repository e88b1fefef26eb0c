"""Partial slip after Ciavarella and Jaeger, and its loop of force and displacement."""

from __future__ import annotations

import math

import attrs
import numpy as np

from roughcontact._answers.areas.approach import find_shift
from roughcontact._answers.linear.tangent import tangent_of
from roughcontact._answers.linear.tangential import (
    find_anisotropy,
    find_compliance_ratio,
    find_energy_ratio,
    tangential_axis,
)
from roughcontact._base.arrays import Array, Mask, Pair, read_only
from roughcontact._base.checks import flag, integer, number
from roughcontact._base.units import Quantity, ShownAsPrinted, WarningText, outlined, si
from roughcontact._parts.grid import Boundary, Load, list_borders
from roughcontact._parts.materials import MAX_UNCOUPLED_BETA, Material, pair_constants
from roughcontact._solve.problem import predict_pressure, problem_of
from roughcontact._solve.solution import ContactSolution, Estimate, Response, responses
from roughcontact.errors import InputError, argument
from roughcontact.errors.warning import Answer

# Fraction of the force of sliding up to which the errors of the two approaches cancel (measured on balls of 3 to 24
# cells radius: the error is the error of the stiffness for small forces).
_CANCELLATION_FORCE = 0.2
# Distance of a straight edge, as at a free border that cuts the contact, inside the edge of its cells, cells.
_BORDER_INSET_CELLS = 0.17
# Relative standard deviation of the displacement near sliding, and of the energy, over the anisotropy: tractions across
# the force take a part of the friction, and the contacts that stick one after another differ in shape. Set on 180 rough
# contacts and ellipses of Poisson's ratio 0, 0.3 and 0.5 beside `ContactProblem.path`.
_DISPLACEMENT_STD = 0.04
_ENERGY_STD = 0.12
# Fraction of the force of sliding below which the difference of two pressures is not accurate enough.
_SMALL_FORCE = 0.01
# Relative residual of the normal answer of the cells that stick.
_ANSWER_TOLERANCE = 1e-2
# Relative standard deviations of displacement and stick area by neglected coupling where beta is far above friction,
# and the square of beta over friction that halves them: pressing leaves slip and traction at the rim. Set on a ball and
# rough contacts of beta 0.12 to 0.5, friction 0.1 to 0.6, beside paths: all displacements lie within two.
_COUPLED_DISPLACEMENT_STD = 0.2
_COUPLED_STICK_STD = 1.5
_HALF_COUPLED = 0.5
# The same of the energy over beta times the force of sliding over the force: set on 10 rough pairs, beta 0.1 to 0.4.
_COUPLED_ENERGY_STD = 0.25
# Relative standard deviation above which the energy is called unresolved.
_MAX_ENERGY_STD = 0.5


@attrs.frozen(eq=False)
class FrettingLoop(ShownAsPrinted):
    """Tangential force and displacement at first loading, and in the cycles that follow.

    Attributes
    ----------
    force
        Tangential force at first loading, shape (points + 1,), N, from zero.
    displacement
        Tangential displacement, shape (points + 1,), m.
    uncertainty
        Standard deviation of the displacement, shape (points + 1,), m.
    """

    force: Array = attrs.field(converter=read_only, repr=outlined)
    displacement: Array = attrs.field(converter=read_only, repr=outlined)
    uncertainty: Array = attrs.field(converter=read_only, repr=outlined)

    @property
    def cycle(self) -> tuple[Array, Array]:
        """Force, N, and displacement, m, of a cycle from the maximum force and back, shape (2 points + 1,).

        After a reversal the change is twice the displacement of the first loading at half the change of force (Masing).
        """
        force = self.force[-1] - 2.0 * self.force
        moved = self.displacement[-1] - 2.0 * self.displacement
        return np.concatenate((force, -force[1:])), np.concatenate((moved, -moved[1:]))

    @property
    def energy(self) -> float:
        """Area within the cycle by the trapezoidal rule, J."""
        force, moved = self.cycle
        return float(abs(np.trapezoid(force, moved)))

    def __str__(self) -> str:
        lines = [f"{'force':>12} {'displacement':>14}"]
        lines += [f"{si(q, 'N'):>12} {si(u, 'm'):>14}" for q, u in zip(self.force, self.displacement, strict=True)]
        return "\n".join(lines)


def _force(value: Quantity) -> float:
    return number(value, "The tangential force", "N", at_least=0.0)


def _uncoupled(value: bool) -> bool:
    return flag(value, "uncoupled=")


def _friction(value: float) -> float:
    return number(value, "The coefficient of friction", above=0.0)


@attrs.frozen(eq=False)
class PartialSlip(ShownAsPrinted, Answer):
    """A contact under a constant normal force and a tangential force that does not make it slide.

    Attributes
    ----------
    tangential_force, friction
        Tangential force Q, N, and coefficient of friction, no unit.
    axis
        Direction of the force: 0 along x, 1 along y.
    contact
        The normal contact under the normal force P.
    stick_contact
        The normal contact under P - Q / friction, whose contact is the stick zone.
    traction
        Tangential traction in the direction of the force, shape (nx, ny), Pa.
    stick, slip
        Cells that stick and cells that slip, shape (nx, ny).
    stick_area, slip_area
        Area that sticks and area that slips, each with its uncertainty, m2.
    displacement
        Tangential displacement of the bodies far from the contact, m: on a periodic boundary the excess over bodies
        that are joined over the whole plane.
    energy
        Energy dissipated in a cycle between Q and -Q, J.
    compliance_ratio
        Tangential over normal compliance along the axis: (2 - nu) / (2 - 2 nu) of like materials if round; no unit.
    warnings
        Why the values must not be trusted, in sentences; empty without a reason.
    """

    tangential_force: float
    friction: float
    axis: int
    contact: ContactSolution
    stick_contact: ContactSolution
    compliance_ratio: float
    stick_area: Estimate
    slip_area: Estimate
    displacement: Estimate
    energy: Estimate
    warnings: tuple[str, ...] = ()
    _unsure: Pair = attrs.field(default=(0.0, 0.0), repr=False)

    @property
    def traction(self) -> Array:
        return read_only(self.friction * (self.contact.pressure - self.stick_contact.pressure))

    @property
    def estimates(self) -> dict[str, Estimate]:
        """The displacement, the areas that stick and slip, and the energy in a cycle, by name."""
        return {name: getattr(self, name) for name in ("displacement", "stick_area", "slip_area", "energy")}

    @property
    def stick(self) -> Mask:
        return self.stick_contact.contact

    @property
    def slip(self) -> Mask:
        return read_only(self.contact.contact & ~self.stick)

    def loop(self, points: int = 16) -> FrettingLoop:
        """Return the tangential force over the displacement, at first loading and in cycles between Q and -Q.

        Parameters
        ----------
        points
            Steps of the first loading; each takes one normal solve, from the solution before.
        """
        points = integer(points, "The number of points", at_least=1)
        forces = np.linspace(0.0, self.tangential_force, points + 1)
        moved = np.zeros(points + 1)
        std = np.zeros(points + 1)
        near = [self.contact]
        for k in range(1, points + 1):
            last = k == points
            lost = forces[k] / self.friction
            found = self.stick_contact if last else _solve_stick(near, self.contact, lost)
            near = [*near[-1:], found]
            one = _widen(
                _displace(self.contact, found, self.friction * self.compliance_ratio),
                _unite(self._unsure, lost / self.contact.force),
            )
            moved[k] = one.value
            std[k] = one.uncertainty
        return FrettingLoop(forces, moved, std)

    def __str__(self) -> str:
        sliding = self.tangential_force / (self.friction * self.contact.force)
        both = self.stick_area, self.slip_area
        areas = (f"{si(area.value, 'm2', 5)} +- {si(area.uncertainty, 'm2', 2)}" for area in both)
        rows = {
            "tangential force": f"{si(self.tangential_force, 'N')}, {100 * sliding:.3g} % of the force of sliding",
            "direction": "xy"[self.axis],
            "displacement": self.displacement,
            **dict(zip(("area that sticks", "area that slips"), areas, strict=True)),
            "energy in a cycle": self.energy,
        }
        lines = [f"{name:18} {value}" for name, value in rows.items()]
        return "\n".join([*lines, *(f"warning: {text}" for text in self.warnings)])


@responses.register("partial-slip")
@attrs.frozen(kw_only=True)
class CiavarellaJaeger(Response[PartialSlip]):
    r"""Partial slip under a tangential force Q that grows after a normal force P, which stays constant.

    The tangential traction is friction times the difference of two normal pressures,

    .. math:: q = \mu\,[p(P) - p(P^*)], \quad \mu (P - P^*) = Q, \quad
              \delta_x = \mu c\,[\delta(P) - \delta(P^*)],

    with the tangential over the normal compliance c of this traction, less what the cells that stick, those in contact
    under P*, gain by a traction of their own (`TangentialStiffness`). A cycle between Q and -Q follows by superposition
    (Masing), and dissipates

    .. math:: W = 4 c \mu^2 \left\{2\,[U(P) - U(P^*)] - (P - P^*)\,[\delta(P) + \delta(P^*)]\right\}, \quad
              U = P\delta - \frac{1}{2}\int p\,u\,\mathrm{d}A .

    Parameters
    ----------
    tangential_force
        Tangential force Q, N, from zero to less than friction times the normal force.
    friction
        Coefficient of friction.
    axis
        Direction of the force: 0 along x, 1 along y.
    uncoupled
        Whether to neglect, with a warning, that normal and tangential displacement of unlike bodies are coupled.

    Notes
    -----
    Exact for plane contacts of like materials, and for all contacts if Poisson's ratio is zero; else the direction of
    slip differs from the direction of the traction by a few per cent, which the uncertainty contains.
    `ContactProblem.path` solves for friction in every cell.

    References
    ----------
    Ciavarella, Int. J. Solids Struct. 35 (1998) 2349-2362, https://doi.org/10.1016/S0020-7683(97)00154-6;
    Jaeger, J. Tribol. 120 (1998) 677-684, https://doi.org/10.1115/1.2833765
    """

    memory_arrays = 34.0  # the symbols of shear
    holds_with = frozenset()
    fails_with = frozenset({"inner flow", "inner moduli"})
    refusal = "it is under one tangential force, and the states of a path have their own stick and slip"

    tangential_force: float = attrs.field(converter=_force, metadata={"unit": "N"})
    friction: float = attrs.field(converter=_friction, metadata={"unit": ""})
    axis: int = attrs.field(default=0, converter=tangential_axis)
    uncoupled: bool = attrs.field(default=False, converter=_uncoupled)

    def respond(self, solution: ContactSolution) -> PartialSlip:
        """Return the contact under the tangential force; see `Response.respond`."""
        problem = problem_of(solution)
        materials = (problem.body.material, problem.counterbody.material)
        _require_elastic(solution)
        warnings = _judge_coupling(materials, self.friction, uncoupled=self.uncoupled)
        lost = self.tangential_force / self.friction
        # There is no contact to solve under a normal force that is zero but for rounding.
        if not lost < solution.force * (1.0 - 1e-12):
            raise InputError(
                f"The bodies slide: the tangential force of {si(self.tangential_force, 'N')} is not below friction "
                f"times the normal force, {si(self.friction * solution.force, 'N')}."
            )
        stuck = _solve_stick([solution], solution, lost)
        ratio = _find_ratio(solution, stuck, self.axis)
        sliding = lost / solution.force
        anisotropy = find_anisotropy(solution)
        neglected = abs(pair_constants(*materials).beta) if warnings else 0.0
        saturation = _saturate(neglected, self.friction)
        unsure = _DISPLACEMENT_STD * anisotropy, _COUPLED_DISPLACEMENT_STD * saturation
        stick_area, slip_area = _compare_areas(solution, stuck, _COUPLED_STICK_STD * saturation)
        energy = _widen(_dissipate(solution, stuck, 4.0 * self.friction**2 * ratio), _ENERGY_STD * anisotropy)
        if energy.uncertainty > _MAX_ENERGY_STD * energy.value and energy.uncertainty > 0.0:
            text = "the slip zone is too narrow for this grid to resolve the dissipated energy"
            warnings += (WarningText(text, "resolution"),)
        if neglected > 0.0 and sliding > 0.0:
            energy = _widen(energy, _COUPLED_ENERGY_STD * neglected / sliding)
        warnings += stick_area.warnings
        warnings += tuple(
            WarningText(str(one.status), "convergence") for one in (solution, stuck) if not one.status.success
        )
        return PartialSlip(
            tangential_force=self.tangential_force,
            friction=self.friction,
            axis=self.axis,
            contact=solution,
            stick_contact=stuck,
            compliance_ratio=ratio,
            stick_area=stick_area,
            slip_area=slip_area,
            displacement=_widen(_displace(solution, stuck, self.friction * ratio), _unite(unsure, sliding)),
            energy=energy,
            warnings=tuple(dict.fromkeys(warnings)),
            unsure=unsure,
        )


def _saturate(beta: float, friction: float) -> float:
    """Return the part of its full effect that a neglected beta has: the more slips in pressing, the more."""
    square = (beta / friction) ** 2
    return square / (_HALF_COUPLED + square)


def _judge_coupling(materials: tuple[Material, Material], friction: float, *, uncoupled: bool) -> tuple[str, ...]:
    """Return a warning if normal and tangential displacement are coupled; otherwise nothing.

    Raises
    ------
    InputError
        If they are, both bodies deform, and it is not asked for uncoupled ones.
    """
    beta = pair_constants(*materials).beta
    if abs(beta) <= MAX_UNCOUPLED_BETA:
        return ()
    if min(material.compliance for material in materials) > 0.0 and not uncoupled:
        raise InputError(
            f"The bodies are of different materials, Dundurs' beta is {beta:.3g}, so that normal and tangential "
            "displacement are coupled and partial slip does not follow from normal contact. Take problem.path(force=, "
            "tangential_force=, friction=), or neglect the coupling: uncoupled=True."
        )
    saturation = _saturate(beta, friction)
    text = (
        f"the coupling of normal and tangential displacement, Dundurs' beta = {abs(beta):.2g}, is neglected: expect a "
        f"displacement too small by {100.0 * _COUPLED_DISPLACEMENT_STD * saturation:.2g} % and a stick area too "
        f"large by {100.0 * _COUPLED_STICK_STD * saturation:.2g} %; problem.path(...) contains it"
    )
    return (WarningText(text, "coupling", abs(beta)),)


def _find_ratio(contact: ContactSolution, stuck: ContactSolution, axis: int) -> float:
    """Return the tangential over the normal compliance along an axis.

    It is that of the traction, a difference of pressures, less what the cells that stick gain by a traction of their
    own over one in proportion to their normal answer; under a small force it is that of these cells alone.
    """
    energy_ratio = 1.0
    traction = contact.pressure - stuck.pressure
    for solution in (stuck, contact):
        tangent = tangent_of(solution)
        if tangent.is_rigid or not tangent.cells.any():
            continue
        answer = tangent.solve(np.ones(solution.grid.shape), _ANSWER_TOLERANCE).values
        energy_ratio = find_energy_ratio(solution, answer, axis)
        if contact.force - stuck.force < _SMALL_FORCE * contact.force:
            traction = answer
        break
    return energy_ratio * (find_compliance_ratio(contact, traction, axis) if traction.any() else 1.0)


def _require_elastic(solution: ContactSolution) -> None:
    """Raise `InputError` unless the contact is elastic, of homogeneous bodies, on a free or periodic boundary."""
    if solution.boundary is Boundary.WRAPPED:
        raise InputError(
            f"Partial slip needs {argument('boundary', 'free')} or 'periodic': on 'wrapped' the approach has no "
            "meaning."
        )
    if solution.moduli is not None:
        raise InputError(
            "Partial slip needs homogeneous, isotropic bodies: it is the difference of two normal contacts only where "
            "the ratio of tangential to normal compliance is the same for all waves, which layers and crystals change."
        )
    if solution.saturated.any():
        raise InputError(
            "Partial slip needs an elastic contact, but the pressure reaches its limit: lower the load, or take "
            "Elastic materials."
        )


def _solve_stick(near: list[ContactSolution], contact: ContactSolution, lost: float) -> ContactSolution:
    """Return the contact under a normal force that is less by `lost`, N, solved from the solutions nearest to it."""
    if lost == 0.0:
        return contact
    load = Load("pressure", max(contact.force - lost, 0.0) / contact.grid.area)
    problem = problem_of(contact)
    found: ContactSolution = problem.solve(pressure=load.value, start=predict_pressure(near, load))
    return found


def _compare_areas(contact: ContactSolution, stuck: ContactSolution, unsure: float = 0.0) -> tuple[Estimate, Estimate]:
    """Return the areas that stick and that slip; the first has a further, relative standard deviation."""
    total = contact.area(uncertainty="model")
    stick = total if stuck is contact else stuck.area(uncertainty="model")
    warnings = tuple(dict.fromkeys((*total.warnings, *stick.warnings)))
    further = 0.0 if stuck is contact else unsure * stick.value
    slip = 0.0 if stuck is contact else math.hypot(total.uncertainty, stick.uncertainty, further)
    return (
        Estimate(stick.value, math.hypot(stick.uncertainty, further), "m2", stick.warnings),
        Estimate(max(total.value - stick.value, 0.0), slip, "m2", warnings),
    )


def _displace(contact: ContactSolution, stuck: ContactSolution, factor: float) -> Estimate:
    """Return the tangential displacement: a factor times the difference of the approaches."""
    value = factor * max(contact.approach - stuck.approach, 0.0)
    std = math.hypot(factor * _approach_std(contact, stuck), _BORDER_INSET_CELLS * _cut_fraction(contact) * value)
    return Estimate(value, std, "m")


def _widen(estimate: Estimate, relative: float) -> Estimate:
    """Return an estimate with a further, relative standard deviation."""
    return attrs.evolve(estimate, uncertainty=math.hypot(estimate.uncertainty, relative * estimate.value))


def _unite(unsure: Pair, sliding: float) -> float:
    """Return a relative standard deviation from one that grows in proportion to the force and one that does not."""
    return math.hypot(unsure[0] * sliding, unsure[1])


def _cut_fraction(contact: ContactSolution) -> float:
    """Return half the number of contact cells along a free border, over the number of all cells."""
    ends = list_borders(contact.contact, contact.boundary)
    return 0.5 * sum(np.count_nonzero(cells) for cells in ends) / contact.contact.size


def _approach_std(contact: ContactSolution, stuck: ContactSolution) -> float:
    """Return the standard deviation of the difference of two approaches, m: their errors cancel if they are close."""
    if stuck is contact:
        return 0.0
    sliding = 1.0 - stuck.force / contact.force
    different = sliding / math.hypot(sliding, _CANCELLATION_FORCE)
    different *= max(contact.grid.resolved.spacing) / min(contact.grid.resolved.spacing)
    shifts = (different * find_shift(one)[1] for one in (contact, stuck))
    solved = (one.residuals.error * one.residuals.scale for one in (contact, stuck))
    std = math.hypot(*shifts, *solved)
    # Even on few cells the difference lies between zero and about twice its value.
    return min(std, abs(contact.approach - stuck.approach))


def _dissipate(contact: ContactSolution, stuck: ContactSolution, factor: float) -> Estimate:
    """Return the energy dissipated in a cycle, J: a factor times the area between approach over force and its chord."""
    lost = contact.force - stuck.force
    between = 2.0 * (_complementary_energy(contact) - _complementary_energy(stuck))
    area = between - lost * (contact.approach + stuck.approach)
    return Estimate(factor * max(area, 0.0), factor * lost * _approach_std(contact, stuck), "J")


def _complementary_energy(solution: ContactSolution) -> float:
    """Return the integral of the approach over the force, J."""
    stored = 0.5 * float(np.einsum("ij,ij->", solution.pressure, solution.displacement)) * solution.grid.cell_area
    return solution.force * solution.approach - stored
