"""One increment of a contact with friction: normal and tangential solves in turn."""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Callable
from functools import partial

import attrs
import numpy as np

from roughcontact._base.arrays import Array, Pair
from roughcontact._base.units import si
from roughcontact._parts.grid import Load
from roughcontact._parts.interactions import FrictionLaw, shear_limit
from roughcontact._solve.problem.accuracy import with_tolerance
from roughcontact._solve.problem.coupled_starts import (
    LastIncrement,
    continue_increment,
    keep_sliding,
    list_loads,
)
from roughcontact._solve.problem.friction_certificate import (
    CONE_TOLERANCE,
    FORCE_TOLERANCE,
    FoundTractions,
    FrictionalContact,
    FrictionalFields,
    stack_along,
)
from roughcontact._solve.problem.loads import follow
from roughcontact._solve.problem.run import computing, run_solve
from roughcontact._solve.problem.scene import Scene
from roughcontact._solve.problem.strengths import MAX_SHEAR_ITERATIONS, solve_within_strength
from roughcontact._solve.problem.turns import Response, choose_tolerance, measure_violation, take_turns
from roughcontact._solve.solution import (
    ContactSolution,
    FrictionalState,
    Governed,
    LoadIncrement,
    Status,
    TangentialLoad,
)
from roughcontact._solve.solvers import (
    ProjectedShearCG,
    ShearOutcome,
    ShearTask,
    Step,
    project_to_discs,
)
from roughcontact.errors import InputError, NotConverged, argument, either

_LOGGER = logging.getLogger("roughcontact")
# Friction times beta beyond which a coupled solve is relaxed, and beyond which it may not converge.
_RELAXED_COUPLING = 0.7
_MAX_COUPLING = 1.0
# Error of a normal solve, and of a tangential one, over the last error of the normal equilibrium of a coupled solve.
_INNER_ERROR = 0.03
_INNER_SLIP = 0.1
# Bounds of the first, and of the second, the smaller one over the tolerance.
_LOOSEST_INNER = 100.0
_LOOSEST_SLIP = 0.03
_TIGHTEST_SLIP = 0.3
# Error expected after a pass, over the tolerance, up to which its solves are to be the last ones.
_LAST_ERROR = 2.0
# Depth of the summit, which touches last, over the peak-to-valley height: rounding of equal heights.
_SUMMIT_DEPTH = 1e-12
# Cells of the contacts without friction that are kept: a path is followed several times. Else the last one is.
_MAX_KEPT_CELLS = 2**19
# Growth of the pressure at which a law must not give less.
_PROBED_GROWTH = 1.25


@attrs.frozen
class SteadyFriction:
    """Friction of bodies that slide steadily: its law, and the direction of the counterbody over the body.

    Attributes
    ----------
    law
        The friction law.
    direction
        A unit vector.
    """

    law: FrictionLaw
    direction: Pair

    @classmethod
    def of(cls, state: ContactSolution) -> SteadyFriction | None:
        """Return that of a state; None unless its bodies slide steadily with friction."""
        return cls(state.friction, state.tangential_load.values) if state.is_steady else None

    def solve_with(self, problem: Scene) -> Callable[..., ContactSolution]:
        """Return the solve of a problem in sliding; see `run_solve`."""
        return partial(CoupledSolve(problem, self.law).slide, direction=self.direction)


@attrs.frozen(eq=False)
class CoupledSolve(FrictionalContact):
    """The solves of a path.

    Attributes
    ----------
    on_step
        Called after each iteration of `press`.
    """

    on_step: Callable[[Step], None] | None = None
    _known: dict[Load, ContactSolution] = attrs.field(factory=dict, init=False)
    _ends: dict[ContactSolution, LastIncrement] = attrs.field(factory=dict, init=False)

    def press(
        self, load: Load, last: ContactSolution | None = None, increment: LoadIncrement | None = None
    ) -> ContactSolution:
        """Return the frictionless contact: that of `ContactProblem.solve`; the last ones are kept.

        Laws of the problem remember the state `last`.
        """
        if self.problem.laws:
            solve = partial(run_solve, self.problem, on_step=self.on_step, increment=increment)
            return follow(solve, [last] if last else [], load)
        if load not in self._known:
            found = run_solve(self.problem, load, on_step=self.on_step)
            if len(self._known) * self.problem.plan.grid.cells >= _MAX_KEPT_CELLS:
                self._known.clear()
            self._known[load] = found
        return self._known[load]

    def fields_at(self, state: ContactSolution | None) -> FrictionalFields:
        """Return the fields at the end of an increment, those of the last one without a product; None: unloaded."""
        if state is None:
            return self.fields_of(FrictionalState.unloaded(self.problem.plan.grid.shape))
        return self._ends[state].end if state in self._ends else self.fields_of(state.end)

    def step(
        self, load: Load, tangential: TangentialLoad, last: ContactSolution | None, cycles: float = 1.0
    ) -> ContactSolution:
        """Return the certified end of one increment.

        Parameters
        ----------
        load, tangential
            The normal and the tangential load at the end of the increment.
        last
            The state at its begin; None: of bodies that just touch.
        cycles
            The cycles of loads for which it stands.
        """
        started = time.perf_counter()
        before = FrictionalState.unloaded(self.problem.plan.grid.shape) if last is None else last.end
        start = self.fields_at(last)
        known = None if last is None else self._ends.get(last)
        increment = LoadIncrement(load, cycles=cycles)
        loads = (np.zeros(3) if known is None else known.loads[1], list_loads(load, tangential))
        with computing(self.problem):
            if load.value == 0.0:
                found = self._unload(load, tangential, start, last)
            elif self.shear.coupled:
                found = self._step_coupled(tangential, start, known, last, increment)
            else:
                found = self._step_like(tangential, start, last, increment)
            solution, fields = self._certify(load, tangential, found, before, start, started)
        _LOGGER.info("increment to %s, %s: %s, %.3g s", load, tangential, solution.status.name, solution.seconds)
        self._ends.clear()
        self._ends[_require_success(solution)] = LastIncrement(loads, before, start.lifted, fields)
        return solution

    def slide(
        self,
        load: Load,
        start: Array | None = None,
        *,
        direction: Pair,
        before: ContactSolution | None = None,
        increment: LoadIncrement | None = None,
        on_pass: Callable[[Step], None] | None = None,
    ) -> ContactSolution:
        """Return the contact of bodies that slide steadily: the traction is the shear strength, in one direction.

        Laws of the problem remember the state `before`; the solve begins with the pressure `start`.
        """
        started = time.perf_counter()
        tangential = TangentialLoad("direction", direction)
        unloaded = FrictionalState.unloaded(self.problem.plan.grid.shape)
        increment = increment or LoadIncrement(load)
        with computing(self.problem):
            found = (
                self._slide_coupled(direction, start, before, increment, on_pass)
                if self.shear.coupled and load.value != 0.0
                else self._slide_like(direction, start, before, increment)
            )
            solution, _ = self._certify(load, tangential, found, unloaded, self.fields_of(unloaded), started)
        return _require_success(solution)

    def _unload(
        self, load: Load, tangential: TangentialLoad, start: FrictionalFields, last: ContactSolution | None
    ) -> FoundTractions:
        """Return bodies that carry nothing; unless it is given, the displacement is the slip where they touch last."""
        contact = run_solve(self.problem, load, before=last)
        gap = contact.initial_gap
        shape = gap.shape
        self._require_stick(tangential, np.zeros(shape))
        moved = np.array(tangential.values) / self.length
        if tangential.kind == "tangential_force":
            # Without load only the summit touches, and sticks: the limit of ever smaller loads.
            moved = start.relative[:, gap <= gap.min() + _SUMMIT_DEPTH * self.length].mean(axis=1)
        return FoundTractions(contact, np.zeros((2, *shape)), moved, Status.CONVERGED, 1, 0)

    def _step_like(
        self,
        tangential: TangentialLoad,
        start: FrictionalFields,
        last: ContactSolution | None,
        increment: LoadIncrement,
    ) -> FoundTractions:
        """Solve once for the pressure, and once for the traction."""
        contact = self.press(increment.load, last, increment)
        if not contact.pressure.any():
            return self._unload(increment.load, tangential, start, last)
        limit, _ = self._find_limit(contact.pressure)
        self._require_stick(tangential, limit)
        at_rest = tangential.values == (0.0, 0.0) and not start.shear.any()
        if at_rest and (tangential.kind == "tangential_force" or not start.displacement.any()):
            return FoundTractions(contact, start.shear, start.displacement, Status.CONVERGED, 1, 0)
        peak = float(contact.pressure.max()) / self.unit
        outcome = self._shear(tangential, limit, peak, -start.relative, start.shear, self.tolerance)
        return FoundTractions(
            contact, outcome.shear, np.array(outcome.displacement), outcome.status, 1, outcome.iterations
        )

    def _slide_like(
        self, direction: Pair, start: Array | None, before: ContactSolution | None, increment: LoadIncrement
    ) -> FoundTractions:
        contact = self._press_once(start, before, increment)
        shear = stack_along(self._find_limit(contact.pressure)[0], direction)
        return FoundTractions(contact, shear, np.full(2, math.nan), Status.CONVERGED, 1, 0)

    def _press_once(
        self, start: Array | None, before: ContactSolution | None, increment: LoadIncrement
    ) -> ContactSolution:
        """Return the frictionless contact at the end of an increment."""
        return run_solve(self.problem, increment.load, start, on_step=self.on_step, before=before, increment=increment)

    def _step_coupled(
        self,
        tangential: TangentialLoad,
        start: FrictionalFields,
        known: LastIncrement | None,
        last: ContactSolution | None,
        increment: LoadIncrement,
    ) -> FoundTractions:
        """Alternate: the traction changes the initial gap, the pressure changes the limit and the offset."""
        pressure, lifted = continue_increment(known, start, list_loads(increment.load, tangential), self.unit)
        turns = _IncrementTurns(self, tangential, start, last, increment, pressure, start.shear)
        response, passes = take_turns(turns.respond, lifted, self.tolerance)
        outcome = turns.outcome
        if outcome is None:
            return self._unload(increment.load, tangential, start, last)
        error = max(response.error, response.own_error)
        status = Status.CONVERGED if error <= self.tolerance else Status.MAXIMUM_ITERATIONS
        moved = np.array(outcome.displacement)
        return FoundTractions(response.contact, outcome.shear, moved, status, passes, turns.iterations)

    def _slide_coupled(
        self,
        direction: Pair,
        start: Array | None,
        before: ContactSolution | None,
        increment: LoadIncrement,
        on_pass: Callable[[Step], None] | None,
    ) -> FoundTractions:
        """Alternate as for a step, with combinations of earlier passes: what is left is linear on a fixed contact."""
        lifted = np.zeros(self.problem.plan.grid.shape)
        begun = start is not None and bool(start.any())
        if start is None or not begun:
            start = self._press_once(None, before, increment).pressure
        pressure = start
        limit, coupling = self._find_limit(pressure)
        if not pressure.all():
            self._require_coupling(coupling)
        damping = 1.0 / (1.0 + coupling**2)
        shear = stack_along(limit, direction)
        if begun:
            lifted = self.lift(shear)

        def respond(lifted: Array, error: float) -> Response:
            nonlocal pressure, shear
            # A frictionless contact is known as well as it is to be.
            error = error if begun or math.isfinite(error) else self.tolerance
            contact = self._press_on(lifted, pressure, error, before, increment)
            pressure = contact.pressure
            shear = stack_along(self._find_limit(pressure)[0], direction)
            found = self.lift(shear)
            return Response(contact, found, self._normal_error(contact, increment.load, found), damping=damping)

        def tell(passes: int, error: float) -> None:
            if on_pass is not None:
                on_pass(Step(self.problem.plan.grid.shape, passes, error))

        response, passes = take_turns(respond, lifted, self.tolerance, tell)
        status = Status.CONVERGED if response.error <= self.tolerance else Status.MAXIMUM_ITERATIONS
        return FoundTractions(response.contact, shear, np.full(2, math.nan), status, passes, 0)

    def _press_on(
        self,
        lifted: Array,
        pressure: Array | None,
        error: float,
        last: ContactSolution | None,
        increment: LoadIncrement,
    ) -> ContactSolution:
        """Return the contact on the initial gap changed by the traction, as accurate as a coupled error asks for."""
        gap, datum = self.problem._gap.change(lifted * self.length)
        increment = attrs.evolve(increment, load=increment.load.after(datum))
        inner = choose_tolerance(error, self.tolerance, _INNER_ERROR, _LOOSEST_INNER)
        problem = with_tolerance(self.problem, min(inner, 1.0))
        found = run_solve(problem, increment.load, pressure, throw=False, gap=gap, before=last, increment=increment)
        # It solves the changed gap, which is not that of the problem.
        found = attrs.evolve(found, origin=None)
        return attrs.evolve(found, initial_gap=found.initial_gap + datum, approach=found.approach + datum)

    def _normal_error(self, contact: ContactSolution, load: Load, lifted: Array) -> float:
        """Return the error of a pressure on the gap changed by the traction."""
        left = self.find_left(contact, lifted)
        return measure_violation(self.problem.plan, left, load, contact.pressure, contact.displacement).error

    def _find_limit(self, pressure: Array) -> tuple[Array, float]:
        """Return the dimensionless shear strength of each cell, and how strongly it couples to the pressure.

        The second is the largest slope of the strength over the pressure times the magnitude of beta.
        """
        limit = shear_limit(self.law, pressure)
        growth = shear_limit(self.law, pressure * _PROBED_GROWTH) - limit
        if (growth < -CONE_TOLERANCE * limit).any():
            raise InputError(f"The limit of the friction law {self.law!r} falls with the pressure: it must not.")
        pressed = pressure > 0.0
        slope = float(np.max(growth[pressed] / pressure[pressed], initial=0.0)) / (_PROBED_GROWTH - 1.0)
        return limit / self.unit, abs(self.pair.beta) * slope

    def _require_coupling(self, coupling: float) -> None:
        if coupling > _MAX_COUPLING:
            raise InputError(
                f"Friction times Dundurs' beta is {coupling:.3g}: above {_MAX_COUPLING:g} the coupled problem may have "
                "several solutions or none. Lower the friction, or choose materials that differ less."
            )

    def _require_stick(self, tangential: TangentialLoad, limit: Array) -> None:
        if tangential.kind != "tangential_force":
            return
        sliding = float(limit.sum()) * self.force_unit
        size = math.hypot(*tangential.values)
        if not size < sliding * (1.0 - FORCE_TOLERANCE) and size > 0.0:
            slide = argument("slide", call="problem.slide(...)")
            advice = either(f"Give {argument('displacement')} instead, or {slide}", "Give a smaller tangential force")
            raise InputError(
                f"The bodies slide: the tangential force of {si(size, 'N')} is not below the sum of the shear "
                f"strengths, {si(sliding, 'N')}. {advice}."
            )

    def _shear(
        self,
        tangential: TangentialLoad,
        limit: Array,
        peak: float,
        offset: Array,
        shear: Array,
        tolerance: float,
        *,
        verifies: bool = True,
    ) -> ShearOutcome:
        """Return the traction within a shear strength, from another one.

        `offset` is what moves the surfaces, `peak` the maximum pressure.
        """
        x, y = tangential.values
        force: tuple[float | None, float | None] = (None, None)
        moved: tuple[float | None, float | None] = (None, None)
        if tangential.kind == "tangential_force":
            force = x / self.force_unit, y / self.force_unit
        else:
            moved = x / self.length, y / self.length
        task = ShearTask(
            limit=limit,
            offset=offset,
            shear_force=force,
            displacement=moved,
            start=shear,
            tolerance=tolerance,
            max_iterations=MAX_SHEAR_ITERATIONS,
        )
        solver = ProjectedShearCG()
        return solve_within_strength(self.shear, task, peak, solver.solve if verifies else solver.approximate)

    def _certify(
        self,
        load: Load,
        tangential: TangentialLoad,
        found: FoundTractions,
        before: FrictionalState,
        start: FrictionalFields,
        started: float,
    ) -> tuple[ContactSolution, FrictionalFields]:
        """Return the solution in SI units with its residuals."""
        contact = found.contact
        shear = found.shear * self.unit
        limit = shear_limit(self.law, contact.pressure)
        # The unit may round a traction beyond the cone.
        shear = project_to_discs(shear, limit)
        lifted = self.lift(shear / self.unit)
        if self.shear.coupled:
            contact = self.certify_contact(contact, load, lifted)
        moved = (float(found.displacement[0]) * self.length, float(found.displacement[1]) * self.length)
        state = FrictionalState(pressure=contact.pressure, shear=shear, displacement=moved, approach=contact.approach)
        seconds = time.perf_counter() - started
        solution, fields = self.judge(contact, state, tangential, before, start, found, seconds, lifted)
        effect = solution._find_added(Governed)
        if effect is not None and solution.status.success:
            # What laws remember may depend on traction and slip.
            solution = solution._add(effect.finish(solution))
        return solution, fields


@attrs.define(eq=False)
class _IncrementTurns:
    """Contacts in turn with the displacement by the tractions on them, the offset, dimensionless."""

    run: CoupledSolve
    tangential: TangentialLoad
    start: FrictionalFields
    last: ContactSolution | None
    increment: LoadIncrement
    pressure: Array | None
    shear: Array
    limit: Array | None = None
    coupling: float = 1.0
    outcome: ShearOutcome | None = None
    iterations: int = 0

    def respond(self, lifted: Array, error: float) -> Response:
        """Return the contact on the gap with an offset, and the displacement across the surface by its traction."""
        run = self.run
        ends = self.coupling * error <= _LAST_ERROR * run.tolerance
        contact = run._press_on(lifted, self.pressure, 0.0 if ends else error, self.last, self.increment)
        self.pressure = contact.pressure
        if not contact.pressure.any():
            self.outcome = None
            return Response(contact, lifted, 0.0, is_last=True)
        limit, self.coupling = run._find_limit(contact.pressure)
        if self.limit is not None:
            self.shear = keep_sliding(self.shear, self.limit, limit)
        self.limit = limit
        run._require_coupling(self.coupling)
        run._require_stick(self.tangential, limit)
        offset = -self.start.relative - run.shear.apply(contact.pressure[np.newaxis] / run.unit, of="z")
        peak = float(contact.pressure.max()) / run.unit
        goal = max(min(_INNER_SLIP * error, _LOOSEST_SLIP), _TIGHTEST_SLIP * run.tolerance)
        solve = partial(run._shear, self.tangential, limit, peak, offset)
        outcome = solve(self.shear, run.tolerance) if ends else solve(self.shear, goal, verifies=False)
        self.iterations += outcome.iterations
        found = run.lift(outcome.shear)
        error = run._normal_error(contact, self.increment.load, found)
        if not ends and max(error, outcome.residual) <= run.tolerance:
            outcome = solve(outcome.shear, run.tolerance)
            self.iterations += outcome.iterations
            found = run.lift(outcome.shear)
            error = run._normal_error(contact, self.increment.load, found)
        self.shear = outcome.shear
        self.outcome = outcome
        damping = 1.0 / (1.0 + self.coupling**2) if self.coupling > _RELAXED_COUPLING else 1.0
        return Response(contact, found, error, outcome.residual, damping)


def _require_success(solution: ContactSolution) -> ContactSolution:
    if not solution.status.success:
        raise NotConverged(
            f"The contact with friction is {solution.status} ({solution.sheared.passes} passes, "
            f"{solution.sheared.iterations} tangential iterations; {solution.certificate}).",
            solution,
        )
    return solution
