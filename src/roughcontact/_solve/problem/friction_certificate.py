"""The certificate of a contact with friction: its conditions, recomputed in float64 from two states in a row."""

from __future__ import annotations

from collections.abc import Collection
from functools import cached_property

import attrs
import numpy as np

from roughcontact._base.arrays import Array, Pair
from roughcontact._base.units import Estimate
from roughcontact._parts.grid import Load
from roughcontact._parts.interactions import FrictionLaw, shear_limit
from roughcontact._parts.materials import PairConstants
from roughcontact._solve.convolvers import ShearConvolution
from roughcontact._solve.problem.certificate import certify, find_touch, verify_laws, verify_solution
from roughcontact._solve.problem.scene import Scene
from roughcontact._solve.problem.strengths import StrengthBound
from roughcontact._solve.problem.task import make_task, pressure_unit
from roughcontact._solve.solution import (
    MACHINE_DIFFERENCE,
    ContactSolution,
    CoupledProcess,
    FrictionalResiduals,
    FrictionalState,
    Governed,
    Origin,
    Sheared,
    Status,
    TangentialLoad,
)
from roughcontact._solve.solvers import Outcome, natural_residual
from roughcontact.errors import InputError, argument

# Rounding of tangential forces and of the friction cone.
FORCE_TOLERANCE = 1e-10
CONE_TOLERANCE = 1e-12


@attrs.frozen(eq=False)
class FrictionalFields:
    """A state in dimensionless variables, with the displacements that it causes.

    Attributes
    ----------
    pressure, shear
        Tractions, shapes (nx, ny) and (2, nx, ny).
    tangential, normal
        Displacements by both tractions, shapes (2, nx, ny) and (nx, ny).
    relative
        Displacement of the counterbody's surface relative to the body's since the first touch, shape (2, nx, ny).
    displacement, approach
        Those of the bodies.
    lifted
        The part of `normal` by the shear alone.
    """

    pressure: Array
    shear: Array
    tangential: Array
    normal: Array
    relative: Array
    displacement: Array
    approach: float
    lifted: Array

    @property
    def energy(self) -> float:
        """Elastic energy of both bodies."""
        return 0.5 * (inner(self.pressure, self.normal) + inner(self.shear, self.tangential))


@attrs.frozen(eq=False)
class FoundTractions:
    """What the solves found: a contact, the dimensionless traction and displacement, and their cost."""

    contact: ContactSolution
    shear: Array
    displacement: Array
    status: Status
    passes: int
    iterations: int


@attrs.frozen(eq=False)
class FrictionalContact:
    """A problem with a friction law, in dimensionless variables, and the certificate of its states.

    Attributes
    ----------
    problem
        The contact.
    law
        The friction law.
    """

    problem: Scene
    law: FrictionLaw

    @cached_property
    def shear(self) -> ShearConvolution:
        """The linear map from tractions to displacements."""
        return self.problem.shear_convolution

    @property
    def pair(self) -> PairConstants:
        """The constants of the two materials."""
        return self.shear.setup.kernel.pair

    @cached_property
    def unit(self) -> float:
        """Tractions that count as one, Pa."""
        return pressure_unit(self.problem.plan)

    @property
    def length(self) -> float:
        """Displacements that count as one, m."""
        return self.problem.plan.peak_to_valley

    @property
    def tolerance(self) -> float:
        """Error that counts as converged."""
        return self.problem.plan.solver.tolerance

    @property
    def force_unit(self) -> float:
        """Force that counts as one, N."""
        return self.unit * self.problem.plan.grid.cell_area

    def fields_of(
        self, state: FrictionalState, contact: ContactSolution | None = None, lifted: Array | None = None
    ) -> FrictionalFields:
        """Return a state in dimensionless variables; products with zero tractions are omitted.

        So are those whose results are known: the displacement of the contact of its pressure, and that by the shear
        across the surface.
        """
        pressure = state.pressure / self.unit
        shear = state.shear / self.unit
        moved = np.array(state.displacement) / self.length
        loaded = bool(pressure.any())
        tangential = np.zeros_like(shear)
        if self.shear.coupled and loaded:
            tangential = self.shear.apply(np.concatenate([shear, pressure[np.newaxis]]), of="xyz")
        elif shear.any():
            tangential = self.shear.apply(shear)
        if contact is not None:
            normal = contact.displacement / self.length
        else:
            normal = self.problem.convolution.apply(pressure) if loaded else np.zeros_like(pressure)
        lifted = self.lift(shear) if lifted is None else lifted
        normal += lifted
        relative = moved[:, np.newaxis, np.newaxis] - tangential
        approach = state.approach / self.length
        return FrictionalFields(pressure, shear, tangential, normal, relative, moved, approach, lifted)

    def lift(self, shear: Array) -> Array:
        """Return the displacement across the surface by a dimensionless shear, shape (nx, ny)."""
        if not self.shear.coupled or not shear.any():
            # It takes no memory.
            return np.broadcast_to(0.0, shear.shape[1:])
        return np.asarray(self.shear.apply(shear, to="z")[0])

    def find_gap(self, contact: ContactSolution) -> Array:
        """Return the gap of the problem as its laws have changed it for a contact, shape (nx, ny), m."""
        effect = contact._find_added(Governed)
        values = self.problem._gap.values
        return values if effect is None else values + effect.offset

    def find_left(self, contact: ContactSolution, lifted: Array) -> Array:
        """Return the gap as laws and a dimensionless displacement by the traction have left it for a contact, m."""
        values = self.find_gap(contact) + lifted * self.length
        if self.problem.plan.non_measured is not None:
            # The solve may have deepened them.
            values = np.where(self.problem.plan.non_measured, np.maximum(values, contact.initial_gap), values)
        return values

    def certify_contact(self, contact: ContactSolution, load: Load, lifted: Array) -> ContactSolution:
        """Return a contact with the certificate of its pressure on the gap changed by the final traction."""
        plan = self.problem.plan
        values = self.find_left(contact, lifted)
        outcome = Outcome(
            pressure=contact.pressure / self.unit,
            status=contact.status,
            iterations=contact.iterations,
            convolutions=contact.convolutions,
            errors=contact.errors,
            levels=contact.levels,
        )
        task = make_task(plan, values, find_touch(plan, values, load))
        found = certify(plan, self.problem.convolution, values, task, outcome, seconds=contact.seconds)
        # To the last bit: the unit may round.
        origin = Origin(self.problem.parts, load.arguments, source=self.problem)
        return attrs.evolve(found, pressure=contact.pressure, origin=origin, added=contact.added)

    def judge(
        self,
        contact: ContactSolution,
        state: FrictionalState,
        tangential: TangentialLoad,
        before: FrictionalState,
        start: FrictionalFields,
        found: FoundTractions,
        seconds: float,
        lifted: Array | None = None,
    ) -> tuple[ContactSolution, FrictionalFields]:
        """Return the solution with the residuals recomputed from two states, and its fields.

        The contact is certified, and `lifted` the displacement across the surface by the traction, if it is known.
        """
        steady = tangential.is_steady
        if steady:
            # The displacement of steady sliding is not determined.
            fields = self.fields_of(attrs.evolve(state, displacement=(0.0, 0.0)), contact, lifted)
            slip = np.broadcast_to(np.array(tangential.values)[:, np.newaxis, np.newaxis], state.shear.shape)
        else:
            fields = self.fields_of(state, contact, lifted)
            slip = fields.relative - start.relative
        strength = shear_limit(self.law, state.pressure) / self.unit
        own = 0.5 * sum(self.shear.own)
        bound = StrengthBound(strength, own, float(fields.pressure.max()))
        limit = strength if steady else bound.find(fields.shear, slip)
        strongest = float(limit.max()) or 1.0
        total = float(limit.sum()) or 1.0
        lost = inner(fields.shear, slip)
        if steady:
            residual = float(np.abs(fields.shear - stack_along(limit, tangential.values)).max()) / strongest
        else:
            residual = natural_residual(fields.shear, slip, limit, own) if limit.any() else 0.0
        wanted = np.array(tangential.values)
        load_error = 0.0
        if tangential.kind == "tangential_force":
            load_error = float(np.hypot(*(fields.shear.sum(axis=(1, 2)) - wanted / self.force_unit))) / total
        elif not steady:
            load_error = float(np.abs(state.displacement - wanted).max()) / self.length
        excess = np.hypot(*fields.shear) - strength
        residuals = FrictionalResiduals(
            shear_load=load_error,
            cone=max(float(excess.max()), 0.0) / strongest,
            slip=residual,
            dissipation=max(-lost, 0.0) / (own * strongest * total),
            energy=0.0 if steady else _find_imbalance(start, fields),
        )
        confirmed = (
            residuals.shear_load <= FORCE_TOLERANCE
            and residuals.cone <= CONE_TOLERANCE
            and residuals.slip <= 2.0 * self.tolerance
        )
        status = contact.status if not contact.status.success or found.status.success else found.status
        if status.success and not confirmed:
            status = Status.UNCONFIRMED
        # Per distance in steady sliding.
        factor = self.force_unit * (1.0 if steady else self.length)
        unsure = 0.0 if steady else 0.5 * abs(inner(fields.shear - start.shear, slip)) * factor
        sheared = Sheared(
            traction=state.shear,
            displacement=state.displacement,
            slip=slip if steady else slip * self.length,
            friction=self.law,
            given=tangential,
            pair=self.pair,
            before=before,
            dissipated=Estimate(lost * factor, unsure, "J/m" if steady else "J"),
            elastic_energy=fields.energy * self.force_unit * self.length,
            residuals=residuals,
            passes=found.passes,
            iterations=found.iterations,
        )
        return contact._add(sheared, status=status, seconds=seconds), fields


def require_frictional(problem: Scene, passing: Collection[str] = ("slip",)) -> None:
    """Raise `InputError` unless a problem may have a contact with friction; its shear convolution is prepared.

    `passing` is what changes its surfaces: slip along a path of tangential loads, time and distance in sliding.
    """
    if problem.adhesion is not None:
        raise InputError(f"Friction with adhesion is not known: omit {argument('adhesion')}.")
    for law in problem.laws:
        if isinstance(law, CoupledProcess):
            raise InputError(
                f"{law!r} is solved with the pressure, but not with the tractions of friction: omit it, or follow "
                "normal loads."
            )
        if law.keeps_modulus and (not law.rates or set(passing).intersection(law.rates)):
            continue
        if "slip" in law.rates:
            raise InputError(
                f"Where bodies slide steadily, {law!r} has no slip that it follows: give Archard by "
                f"{argument('laws')}, with the coefficient of friction times its own."
            )
        raise InputError(
            f"Along a path with friction neither time nor a sliding distance passes, on which {law!r} depends: "
            f"leave it out of {argument('laws')}."
        )
    _ = problem.shear_convolution


def verify_state(problem: Scene, solution: ContactSolution) -> None:
    """Recompute the certificate of a solution, with friction or without; see `ContactProblem.verify`."""
    if solution.shear is not None:
        _verify_sheared(problem, solution, solution.sheared)
    else:
        verify_solution(problem, solution)


def _verify_sheared(problem: Scene, solution: ContactSolution, sheared: Sheared) -> None:
    """Recompute the certificate of a solution with friction from both states."""
    run = FrictionalContact(problem, sheared.friction)
    origin = solution.origin
    if origin is None or not solution.grid.matches(problem.plan.grid):
        raise InputError(f"It is not a solution at a load, on the grid of the problem, {problem.plan.grid}.")
    load = Load.signed(**origin.load)
    contact = attrs.evolve(solution, added=tuple(one for one in solution.added if one is not sheared))
    lifted = run.lift(np.asarray(sheared.traction) / run.unit)
    if run.shear.coupled:
        contact = run.certify_contact(contact, load, lifted)
        if not _are_close(solution.initial_gap, contact.initial_gap, run.length):
            raise InputError("Its initial gap contradicts its traction and its problem.")
        if solution.status.success and not contact.status.success:
            raise InputError(f"Its contact is not in equilibrium: the recomputed residuals are {contact.residuals}.")
    found = FoundTractions(contact, sheared.traction, np.zeros(2), solution.status, sheared.passes, sheared.iterations)
    start = run.fields_of(sheared.before)
    again, fields = run.judge(contact, solution.end, sheared.given, sheared.before, start, found, 0.0, lifted)
    if solution.status.success and not again.status.success:
        raise InputError(f"Its status is {solution.status.name}, but the recomputed residuals are {again.certificate}.")
    # With the slip of the last increment, by which laws remember.
    if run.shear.coupled:
        verify_laws(problem, again)
    else:
        verify_solution(problem, again)
    energy = abs(again.elastic_energy)
    moved = float(np.abs(fields.tangential).max()) * run.length
    pairs: dict[str, tuple[float | Array, float | Array, float]] = {
        "approach": (solution.approach, again.approach, run.length),
        "elastic energy": (solution.elastic_energy, again.elastic_energy, energy),
    }
    if sheared.increments == 1:
        pairs["slip"] = solution.slip, again.slip, 1.0 if solution.is_steady else moved
        pairs["energy lost"] = solution.dissipated.value, again.dissipated.value, max(energy, again.dissipated.value)
    for name, (given, right, scale) in pairs.items():
        if not _are_close(given, right, scale):
            raise InputError(f"Its {name} contradicts its tractions and its problem.")


def _are_close(given: float | Array, right: float | Array, scale: float) -> bool:
    return bool(np.abs(np.subtract(given, right)).max() <= MACHINE_DIFFERENCE * scale)


def _find_imbalance(start: FrictionalFields, end: FrictionalFields) -> float:
    """Return the error of the balance of energy and work between two states, over its largest term."""
    pressing = 0.5 * inner(start.pressure + end.pressure, end.normal - start.normal)
    mean = 0.5 * (start.shear + end.shear)
    driving = float(mean.sum(axis=(1, 2)) @ (end.displacement - start.displacement))
    losing = inner(mean, end.relative - start.relative)
    terms = (end.energy, start.energy, pressing, driving, losing)
    scale = max(abs(term) for term in terms)
    return abs(terms[0] - terms[1] - pressing - driving + losing) / scale if scale > 0.0 else 0.0


def stack_along(limit: Array, direction: Pair) -> Array:
    """Return tractions of given sizes in one direction, shape (2, nx, ny)."""
    return np.stack([limit * direction[0], limit * direction[1]])


def inner(one: Array, other: Array) -> float:
    """Return the sum of the products of two fields."""
    return float(np.einsum("i,i->", np.ravel(one), np.ravel(other)))
