"""The certificate of a solve: what its conditions leave, recomputed from the pressure alone."""

from __future__ import annotations

import math
from collections.abc import Callable

import attrs
import numpy as np
from numpy.typing import ArrayLike

from roughcontact._base.arrays import Array, frozen_array
from roughcontact._base.units import outlined
from roughcontact._parts.grid import Load
from roughcontact._solve.convolvers import DCFFT, CircularFFT, Direct, PreparedConvolution
from roughcontact._solve.problem.body import InitialGap
from roughcontact._solve.problem.plan import SolvePlan
from roughcontact._solve.problem.scene import Scene
from roughcontact._solve.problem.task import LOAD_TOLERANCE, make_task, pressure_unit
from roughcontact._solve.solution import (
    MACHINE_DIFFERENCE,
    AdhesiveConditions,
    AdhesiveViolation,
    ContactConditions,
    ContactSolution,
    Governed,
    Residuals,
    Status,
    Violation,
)
from roughcontact._solve.solvers import Outcome, Task
from roughcontact.errors import InputError
from roughcontact.errors.door import guarded

# Rounding of a gap over its largest term, with a margin of four over that of `ContactConditions`.
_GAP_ROUNDING = 64.0 * float(np.finfo(np.float64).eps)


@attrs.frozen(eq=False, kw_only=True)
class ConfirmedFields:
    """What a solve has found, in SI units, and how well it satisfies the conditions of contact.

    Attributes
    ----------
    pressure
        Pressure, shape (nx, ny), Pa; saturated cells carry the limit to the last bit.
    displacement
        Displacement that it causes, shape (nx, ny), m.
    approach
        Approach, m.
    status
        The status; no success unless it is confirmed.
    residuals
        The violations of the conditions.
    """

    pressure: Array = attrs.field(repr=outlined)
    displacement: Array = attrs.field(repr=outlined)
    approach: float
    status: Status
    residuals: Residuals

    def convert(self, convert: Callable[[Array], Array]) -> ConfirmedFields:
        """Return the same certificate with its fields converted; itself where they stay as they are."""
        pressure = convert(self.pressure)
        displacement = convert(self.displacement)
        if pressure is self.pressure and displacement is self.displacement:
            return self
        return attrs.evolve(self, pressure=pressure, displacement=displacement)


def certify(
    plan: SolvePlan,
    convolution: PreparedConvolution,
    initial_gap: Array,
    task: Task,
    outcome: Outcome,
    *,
    seconds: float,
) -> ContactSolution:
    """Return the solution in SI units, with residuals recomputed in float64 from the pressure alone.

    A success is confirmed only if float64 resolves the gap, the residuals are small, the load is right to rounding and
    the bounds hold bit for bit.

    Parameters
    ----------
    plan, convolution, task
        The problem in dimensionless variables.
    initial_gap
        Gap before deformation, shape (nx, ny), m.
    outcome
        The pressure and status that the solver returned.
    seconds
        Wall time of the solve, s.
    """
    if not isinstance(outcome, Outcome) or outcome.pressure.shape != task.initial_gap.shape:
        raise InputError(f"The solver {plan.solver!r} must return an Outcome with a pressure of the grid's shape.")
    if task.start is not None:
        task = attrs.evolve(task, start=None)
    if task.interaction is not None:
        return make_solution(plan, initial_gap, outcome, confirm(plan, convolution, task, outcome), seconds)
    # The fields are measured where the arrays of the convolution are.
    place = convolution.from_numpy
    certificate = confirm(plan, convolution, task.convert(place), outcome.convert(place))
    return make_solution(plan, initial_gap, outcome, certificate.convert(convolution.to_numpy), seconds)


@guarded
def confirm(plan: SolvePlan, convolution: PreparedConvolution, task: Task, outcome: Outcome) -> ConfirmedFields:
    """Return what a solver has found, in SI units, with residuals recomputed in float64 from its fields alone.

    Parameters
    ----------
    plan, convolution, task
        The problem in dimensionless variables.
    outcome
        The pressure, with adhesion the tension too, and the status that the solver returned; without adhesion its
        arrays may be of the kind of the convolution.
    """
    if task.interaction is not None and (outcome.tension is None or outcome.tension.shape != outcome.pressure.shape):
        raise InputError(f"The solver {plan.solver!r} must return an Outcome with a tension of the grid's shape.")
    displacement = convolution.apply(outcome.pressure)
    state, load, bounded = _measure(convolution, task, outcome, displacement)
    bound = 2.0 * max(plan.solver.tolerance, state.floor)
    confirmed = state.error <= bound and load <= LOAD_TOLERANCE and bounded
    status = outcome.status.within(state.floor, plan.solver.tolerance)
    if status.success and not confirmed:
        status = Status.UNCONFIRMED
    residuals = Residuals(
        complementarity=max(state.complementarity, state.floor),
        penetration=max(state.penetration, state.floor),
        load=load,
        scale=state.scale * plan.peak_to_valley,
        tension=max(state.gap, state.floor) if isinstance(state, AdhesiveViolation) else 0.0,
    )
    return _in_si(plan, task, outcome, displacement, state.approach, status, residuals)


def _measure(
    convolution: PreparedConvolution, task: Task, outcome: Outcome, displacement: Array
) -> tuple[Violation | AdhesiveViolation, float, bool]:
    """Return the violation of the conditions, the relative error of the load, and whether the bounds hold."""
    pressure = outcome.pressure
    carried = convolution.sum(pressure) / pressure.size
    if task.interaction is None or outcome.tension is None:
        state = ContactConditions(task.initial_gap, task.pressure_limit, task.approach, task.rms).measure(
            pressure, displacement
        )
        within = (pressure <= task.pressure_limit).all() if task.capped else pressure.max() < math.inf
        load = 0.0 if task.mean_pressure is None else abs(carried / task.mean_pressure - 1.0)
        return state, load, bool(pressure.min() >= 0.0 and within)
    conditions = AdhesiveConditions(
        initial_gap=task.initial_gap,
        interaction=task.interaction,
        pressure_limit=task.pressure_limit,
        approach=task.approach,
        rms=task.rms_gap,
    )
    attracted = conditions.measure(pressure, outcome.tension, displacement)
    load = 0.0
    if task.mean_pressure is not None:
        # A load may be zero: its error is over the forces that balance in it.
        pressed = np.maximum(pressure + outcome.tension, 0.0)
        balanced = (convolution.sum(pressed) + convolution.sum(outcome.tension)) / pressure.size
        scale = max(abs(task.mean_pressure), balanced)
        load = abs(carried - task.mean_pressure) / scale if scale > 0.0 else 0.0
    return attracted, load, attracted.bounds <= LOAD_TOLERANCE


def _in_si(
    plan: SolvePlan,
    task: Task,
    outcome: Outcome,
    displacement: Array,
    approach: float,
    status: Status,
    residuals: Residuals,
) -> ConfirmedFields:
    """Return the certificate of dimensionless fields and a dimensionless approach."""
    unit = pressure_unit(plan)
    pressure = outcome.pressure * unit
    if task.capped:
        np.minimum(pressure, plan.pressure_limit, out=pressure)
        # Saturated cells carry the limit to the last bit.
        np.copyto(pressure, plan.pressure_limit, where=outcome.pressure >= task.pressure_limit)
    return ConfirmedFields(
        pressure=pressure,
        displacement=displacement * plan.peak_to_valley,
        approach=approach * plan.peak_to_valley,
        status=status,
        residuals=residuals,
    )


@guarded
def make_solution(
    plan: SolvePlan, initial_gap: Array, outcome: Outcome, certificate: ConfirmedFields, seconds: float
) -> ContactSolution:
    """Return the solution with the fields of a certificate; parameters as of `certify`."""
    return ContactSolution(
        grid=plan.grid,
        boundary=plan.boundary,
        modulus=plan.modulus,
        pressure_limit=plan.pressure_limit,
        pressure=_freeze(certificate.pressure),
        displacement=_freeze(certificate.displacement),
        initial_gap=initial_gap,
        approach=certificate.approach,
        status=certificate.status,
        iterations=outcome.iterations,
        convolutions=outcome.convolutions + 1,
        seconds=seconds,
        residuals=certificate.residuals,
        errors=outcome.errors,
        levels=outcome.levels,
        edge_shift=plan.kernel.edge_shift,
        moduli=plan.sampled_moduli,
        directional_moduli=plan.sampled_directions,
        non_measured=plan.non_measured,
        tension=None if outcome.tension is None else frozen_array(outcome.tension * pressure_unit(plan)),
    )


def _freeze(field: Array) -> Array:
    """Return an array of numpy C-ordered and read-only, one of slabs or tensors as it is."""
    return frozen_array(field) if isinstance(field, np.ndarray) else field


def verify_solution(problem: Scene, solution: ContactSolution) -> None:
    """Recompute displacement and residuals of a solution from its pressure; see `ContactProblem.verify`.

    What laws have changed and remember is recomputed too; what friction adds is not.
    """
    if solution.origin is None or not solution.grid.matches(problem.plan.grid):
        raise InputError(f"It is not a solution at a load, on the grid of the problem, {problem.plan.grid}.")
    gap, plan = verify_laws(problem, solution)
    if gap.non_measured is not None:
        # The solve may have deepened them.
        gap = gap.with_depth(max(float(one[gap.non_measured].max()) for one in (gap.values, solution.initial_gap)))
    # A path may end in a load of zero; other loads that are not above zero are refused as a task.
    load = Load.signed(**solution.origin.load)
    if plan.interaction is None:
        load = find_touch(plan, gap.values, load)
    if (solution.tension is None) is not (plan.interaction is None):
        raise InputError("Its tension contradicts the adhesion of its problem.")
    convolution = _by_transforms(problem.convolution)
    again = certify_again(plan, convolution, solution, solution.initial_gap, load)
    _require_confirmed(solution, again, gap.values)


def find_touch(plan: SolvePlan, gap: Array, load: Load) -> Load:
    """Return a load on a gap, shape (nx, ny), m; of bodies that just touch, the approach at which they do.

    Changed surfaces touch later than fresh ones.
    """
    if load.value != 0.0 or load.kind == "approach":
        return load
    measured = True if plan.non_measured is None else ~plan.non_measured
    return Load("approach", float(np.min(gap, where=measured, initial=math.inf)))


def certify_again(
    plan: SolvePlan, convolution: PreparedConvolution, solution: ContactSolution, initial_gap: Array, load: Load
) -> ContactSolution:
    """Return the solution with the pressure of another one on an initial gap, certified anew."""
    unit = pressure_unit(plan)
    outcome = Outcome(
        pressure=solution.pressure / unit,
        status=solution.status,
        iterations=0,
        convolutions=0,
        errors=(),
        tension=None if solution.tension is None else solution.tension / unit,
    )
    return certify(plan, convolution, initial_gap, make_task(plan, initial_gap, load), outcome, seconds=0.0)


def stiffen_plan(plan: SolvePlan, stiffening: float) -> SolvePlan:
    """Return the plan of bodies whose contact modulus is so many times that of a plan; itself for one.

    `InputError` if the response is not that of one modulus.
    """
    if stiffening == 1.0:
        return plan
    if plan.sampled_moduli is not None:
        raise InputError(
            f"Bodies whose modulus changes are known for one half-space each, but the kernel is {plan.kernel!r}."
        )
    return attrs.evolve(plan, modulus=plan.modulus * stiffening)


def displace_plan(plan: SolvePlan, gap: InitialGap) -> SolvePlan:
    """Return the plan of a contact on the gap of a displaced counterbody; itself where none is displaced."""
    if gap.values is plan.initial_gap:
        return plan
    # The heights of the bodies may add up to a plane.
    height = float(gap.values.max()) or plan.peak_to_valley
    return attrs.evolve(plan, initial_gap=gap.values, peak_to_valley=height, non_measured=gap.non_measured)


def verify_laws(problem: Scene, solution: ContactSolution) -> tuple[InitialGap, SolvePlan]:
    """Return the gap of a problem as its laws have changed it, from the first touch of the fresh bodies, and its plan.

    `InputError` if a solution states another change.
    """
    effect = solution._find_added(Governed)
    if (effect is None) is bool(problem.laws):
        raise InputError("Its laws are not those of its problem.")
    if effect is None:
        return problem._gap, problem.plan
    assert solution.origin is not None
    # What laws give of its fields is that of this problem, not of the one that it states.
    asked = attrs.evolve(solution, origin=attrs.evolve(solution.origin, problem=problem.parts, source=problem))
    again = effect.repeat(problem, asked)
    effect.require_same(again)
    gap = problem._find_gap(effect.shift)
    plan = stiffen_plan(displace_plan(problem.plan, gap), again.stiffening)
    datum = problem.summit - gap.summit
    return attrs.evolve(gap, values=gap.values + datum + again.offset), plan


def _by_transforms(convolution: PreparedConvolution) -> PreparedConvolution:
    """Return a convolution with transforms instead of the direct sum, which takes minutes on large grids."""
    setup = convolution.setup
    if not isinstance(setup.convolver, Direct):
        return convolution
    convolver = DCFFT() if setup.boundary.has_free_axis else CircularFFT()
    return convolver.prepare(setup.kernel, setup.grid, setup.boundary)


def _require_confirmed(stated: ContactSolution, again: ContactSolution, initial_gap: Array) -> None:
    """Raise `InputError` unless a solution has the gap of its problem and, up to rounding, the recomputed numbers."""
    residuals = stated.residuals
    found = again.residuals
    moduli = again.moduli or ()
    directional = again.directional_moduli or ()
    displaced = float(np.abs(again.displacement).max())
    margin = MACHINE_DIFFERENCE + _GAP_ROUNDING * (displaced + float(np.abs(again.initial_gap).max())) / found.scale
    pairs: dict[str, tuple[ArrayLike, ArrayLike, float]] = {
        "initial gap": (stated.initial_gap, initial_gap, MACHINE_DIFFERENCE * float(initial_gap.max())),
        "boundary": (float(stated.boundary is again.boundary), 1.0, 0.0),
        "pressure limit": (stated.pressure_limit, again.pressure_limit, 0.0),
        "contact modulus": (stated.modulus, again.modulus, MACHINE_DIFFERENCE * again.modulus),
        "moduli": (stated.moduli or (), moduli, MACHINE_DIFFERENCE * float(np.max(moduli, initial=0.0))),
        "directional moduli": (
            stated.directional_moduli or (),
            directional,
            MACHINE_DIFFERENCE * float(np.max(directional, initial=0.0)),
        ),
        "edge shift": (stated.edge_shift, again.edge_shift, MACHINE_DIFFERENCE),
        "displacement": (stated.displacement, again.displacement, MACHINE_DIFFERENCE * displaced),
        "approach": (stated.approach, again.approach, margin * found.scale),
        "scale": (residuals.scale, found.scale, margin * found.scale),
        "complementarity": (residuals.complementarity, found.complementarity, margin),
        "penetration": (residuals.penetration, found.penetration, margin),
        "error of the tension": (residuals.tension, found.tension, margin),
        "error of the load": (residuals.load, found.load, LOAD_TOLERANCE),
    }
    for name, (given, right, allowed) in pairs.items():
        if not _are_close(np.asarray(given), np.asarray(right), allowed):
            raise InputError(f"Its {name} contradicts its pressure and its problem.")
    if stated.status.success and not again.status.success:
        raise InputError(f"Its status is {stated.status.name}, but the recomputed residuals are {found}.")


def _are_close(given: Array, right: Array, allowed: float) -> bool:
    # Limits and the residuals of a failed solve may be infinite.
    if given.shape != right.shape or np.array_equal(given, right):
        return given.shape == right.shape
    with np.errstate(all="ignore"):
        return bool(np.abs(given - right).max() <= allowed)
