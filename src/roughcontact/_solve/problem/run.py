"""One solve: the outcome of the solver, and its certificate, recomputed from the pressure alone."""

from __future__ import annotations

import contextlib
import logging
import math
import time
from collections.abc import Callable, Iterator
from typing import Any

import attrs
import numpy as np
from numpy.typing import ArrayLike

from roughcontact._base.arrays import Array, frozen_array
from roughcontact._base.machine import use_threads
from roughcontact._base.units import outlined, si
from roughcontact._parts.grid import Load
from roughcontact._solve.convolvers import DCFFT, CircularFFT, Direct, PreparedConvolution
from roughcontact._solve.problem.body import InitialGap
from roughcontact._solve.problem.plan import SolvePlan
from roughcontact._solve.problem.scene import Scene
from roughcontact._solve.problem.task import LOAD_TOLERANCE, make_task, pressure_unit
from roughcontact._solve.solution import (
    AdhesiveConditions,
    AdhesiveViolation,
    ContactConditions,
    ContactSolution,
    Governed,
    Origin,
    Residuals,
    Status,
    Violation,
)
from roughcontact._solve.solvers import Outcome, Step, Task
from roughcontact.errors import InputError, NotConverged
from roughcontact.errors.door import guarded

_LOGGER = logging.getLogger("roughcontact")
# Difference between machines, and versions of numpy and scipy, of residuals, and of other numbers over their maximum:
# transforms differ by some 1e-15, Love's kernel by up to 5e-11 between its forms.
_MACHINE_DIFFERENCE = 1e-10
# Rounding of a gap over its largest term, with a margin of four over that of `ContactConditions`.
_GAP_ROUNDING = 64.0 * float(np.finfo(np.float64).eps)
# New depth of non-measured points that touch, over the sum of the last depth and the approach, to the power of the
# round; and maximum rounds: after eight they are 4^36 = 5e21 times deeper.
_DEPTH_FACTOR = 4.0
_MAX_DEEPENINGS = 8


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
    plan = problem.plan
    if solution.origin is None or not solution.grid.matches(plan.grid):
        raise InputError(f"It is not a solution at a load, on the grid of the problem, {plan.grid}.")
    gap = _verify_laws(problem, solution)
    if gap.non_measured is not None:
        # The solve may have deepened them.
        gap = gap.with_depth(max(plan.peak_to_valley, float(solution.initial_gap[gap.non_measured].max())))
    # A path with friction may end in a load of zero; other loads that are not above zero are refused as a task.
    load = Load.signed(**solution.origin.load)
    task = make_task(plan, solution.initial_gap, load)
    if (solution.tension is None) is not (plan.interaction is None):
        raise InputError("Its tension contradicts the adhesion of its problem.")
    unit = pressure_unit(plan)
    pressure = solution.pressure / unit
    tension = None if solution.tension is None else solution.tension / unit
    outcome = Outcome(
        pressure=pressure, status=solution.status, iterations=0, convolutions=0, errors=(), tension=tension
    )
    convolution = _by_transforms(problem.convolution)
    again = certify(plan, convolution, solution.initial_gap, task, outcome, seconds=0.0)
    _require_confirmed(solution, again, gap.values)


def _verify_laws(problem: Scene, solution: ContactSolution) -> InitialGap:
    """Return the gap of a problem as its laws have changed it; `InputError` if a solution states another change."""
    effect = solution._find_added(Governed)
    if (effect is None) is bool(problem.laws):
        raise InputError("Its laws are not those of its problem.")
    if effect is None:
        return problem._gap
    again = effect.repeat(problem, solution)
    effect.require_same(again)
    return attrs.evolve(problem._gap, values=problem._gap.values + again.offset)


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
    margin = _MACHINE_DIFFERENCE + _GAP_ROUNDING * (displaced + float(np.abs(again.initial_gap).max())) / found.scale
    pairs: dict[str, tuple[ArrayLike, ArrayLike, float]] = {
        "initial gap": (stated.initial_gap, initial_gap, _MACHINE_DIFFERENCE * float(initial_gap.max())),
        "boundary": (float(stated.boundary is again.boundary), 1.0, 0.0),
        "pressure limit": (stated.pressure_limit, again.pressure_limit, 0.0),
        "contact modulus": (stated.modulus, again.modulus, _MACHINE_DIFFERENCE * again.modulus),
        "moduli": (stated.moduli or (), moduli, _MACHINE_DIFFERENCE * float(np.max(moduli, initial=0.0))),
        "directional moduli": (
            stated.directional_moduli or (),
            directional,
            _MACHINE_DIFFERENCE * float(np.max(directional, initial=0.0)),
        ),
        "edge shift": (stated.edge_shift, again.edge_shift, _MACHINE_DIFFERENCE),
        "displacement": (stated.displacement, again.displacement, _MACHINE_DIFFERENCE * displaced),
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


def run_solve(
    problem: Scene,
    load: Load,
    start: Array | None = None,
    *,
    throw: bool = True,
    on_step: Callable[[Step], None] | None = None,
    start_gap: Array | None = None,
    gap: InitialGap | None = None,
    before: ContactSolution | None = None,
) -> ContactSolution:
    """Return the certified solution at a load, on the gap of the problem or another one.

    If it is not certified it is returned unfinished, or raised in `NotConverged` where `throw` is true. Laws of the
    problem remember the state `before`; None: the surfaces are fresh.
    """
    started = time.perf_counter()
    gap = problem._gap if gap is None else gap
    effect = Governed.begin(problem, load, before) if problem.laws else None
    gap, datum = (gap, 0.0) if effect is None else _change_gap(gap, effect.offset)
    inner = load.after(datum)
    if problem.adhesion is None and inner.kind == "approach" and load.value > 0.0 >= inner.value:
        raise InputError(
            f"At an approach of {si(load.value, 'm')} the surfaces do not touch: as the laws of the problem have "
            f"changed them, the first touch is at {si(datum, 'm')}."
        )
    with computing(problem):
        solution = _solve(problem, gap, inner, start, on_step, started, start_gap)
        if solution.status is Status.SEPARATED and start_gap is None:
            solution = _try_other_states(problem, gap, inner, on_step, started) or solution
    level = logging.INFO if solution.status.success else logging.WARNING
    _LOGGER.log(
        level,
        "solved %s, %s: %s, %d iterations, %.3g s",
        problem.plan.grid,
        load,
        solution.status.name,
        solution.iterations,
        solution.seconds,
    )
    solution = attrs.evolve(solution, origin=Origin(problem.parts, load.arguments, source=problem))
    if effect is not None:
        solution = _govern(solution, effect, datum)
    return require_success(solution) if throw else solution


def _change_gap(gap: InitialGap, offset: Array) -> tuple[InitialGap, float]:
    """Return a gap plus what laws add, from its first touch, with one depth of its lost points; and that touch, m."""
    changed, datum = gap.change(offset)
    if changed.non_measured is None:
        return changed, datum
    return changed.with_depth(float(changed.values[changed.non_measured].max())), datum


def _govern(solution: ContactSolution, effect: Governed, datum: float) -> ContactSolution:
    """Return a solution with approach and gap from the first touch of the fresh surfaces, and the memory of the laws.

    What is not certified leaves nothing behind.
    """
    changed = attrs.evolve(
        solution, initial_gap=frozen_array(solution.initial_gap + datum), approach=solution.approach + datum
    )
    return changed._add(effect.finish(changed) if changed.status.success else effect)


def _try_other_states(
    problem: Scene, gap: InitialGap, load: Load, on_step: Callable[[Step], None] | None, started: float
) -> ContactSolution | None:
    """Return a state that carries a load found from that at zero load, or from full contact; None without one.

    Without adhesion nothing touches under a tensile load, so that the first start says little.
    """
    rest = _solve(problem, gap, Load(load.kind, 0.0), None, on_step, started, None)
    starts: list[tuple[Array | None, Array]] = [(None, np.zeros(gap.values.shape))]
    if rest.status.success:
        starts.insert(0, (rest.pressure, np.where(rest.contact, 0.0, np.maximum(rest.gap, 0.0))))
    for pressure, opened in starts:
        found = _solve(problem, gap, load, pressure, on_step, started, opened)
        if found.status.success:
            return found
    return None


@contextlib.contextmanager
def computing(problem: Scene) -> Iterator[None]:
    """Limit the threads used inside the context to those of a problem."""
    threads = problem.plan.thread_choice[0]
    with use_threads(threads), problem.convolution.use_threads(threads):
        yield


def _solve(
    problem: Scene,
    gap: InitialGap,
    load: Load,
    start: Array | None,
    on_step: Callable[[Step], None] | None,
    started: float,
    start_gap: Array | None,
) -> ContactSolution:
    """Solve until no non-measured point touches; `started` is the time of the clock at the start."""
    plan = problem.plan
    deepened = 0
    while True:
        task = make_task(plan, gap.values, load, start, start_gap)
        if on_step is not None:
            task = attrs.evolve(task, on_step=on_step)
        outcome = plan.solver.solve(problem.convolution, task)
        # A clock may be set back, for instance on a suspended machine.
        seconds = max(0.0, time.perf_counter() - started)
        solution = certify(plan, problem.convolution, gap.values, task, outcome, seconds=seconds)
        pressed = solution.contact_pressure
        excess = gap.sum_non_measured(pressed)
        touch = LOAD_TOLERANCE * float(pressed.sum()) < excess < math.inf if excess else False
        if not touch or deepened == _MAX_DEEPENINGS:
            break
        # Non-measured points do not touch, however large the approach.
        deepened += 1
        gap = gap.with_depth(_DEPTH_FACTOR**deepened * (float(gap.values.max()) + abs(solution.approach)))
    if excess > 0.0:
        # Only measured points carry load: the certificate shows whether more than rounding is missing.
        outcome = attrs.evolve(outcome, pressure=np.where(np.asarray(gap.non_measured), 0.0, outcome.pressure))
        solution = certify(plan, problem.convolution, gap.values, task, outcome, seconds=seconds)
    return solution


@guarded
def require_certified(solution: Any) -> None:
    """Raise `NotConverged` if a solution, whose fields may be of any kind, is not certified.

    Parameters
    ----------
    solution
        Has the status, iterations, residuals and, if it has any, warnings of a `ContactSolution`.
    """
    if not solution.status.success:
        status = f"The contact is {solution.status} ({solution.iterations} iterations; {solution.residuals})."
        raise NotConverged(" ".join((status, *getattr(solution, "warnings", ()))), solution)


def require_success(solution: ContactSolution) -> ContactSolution:
    """Return the solution, or raise `NotConverged` if it is not certified or not as accurate as requested."""
    require_certified(solution)
    if solution.accuracy is not None and not solution.accuracy.met:
        raise NotConverged(solution.accuracy.explain(), solution)
    return solution
