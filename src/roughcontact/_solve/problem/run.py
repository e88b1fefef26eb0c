"""One solve: the outcome of the solver on the gap as laws have changed it, and its certificate."""

from __future__ import annotations

import contextlib
import logging
import math
import time
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import attrs
import numpy as np

from roughcontact._base.arrays import Array, frozen_array
from roughcontact._base.machine import use_threads
from roughcontact._base.units import si
from roughcontact._parts.grid import Load
from roughcontact._parts.kernels import InfluenceKernel
from roughcontact._solve.convolvers import PreparedConvolution, SoftenedConvolution
from roughcontact._solve.problem.body import InitialGap
from roughcontact._solve.problem.certificate import certify, certify_again, displace_plan, stiffen_plan
from roughcontact._solve.problem.plan import SolvePlan
from roughcontact._solve.problem.scene import Scene
from roughcontact._solve.problem.task import LOAD_TOLERANCE, make_task, prepare_convolution, pressure_unit
from roughcontact._solve.problem.turns import Response, choose_tolerance, measure_violation, take_turns
from roughcontact._solve.solution import (
    ContactSolution,
    Governed,
    LoadIncrement,
    Memory,
    Origin,
    Status,
    load_of,
)
from roughcontact._solve.solvers import Step
from roughcontact.errors import InputError, NotConverged, argument
from roughcontact.errors.door import guarded

_LOGGER = logging.getLogger("roughcontact")
# New depth of non-measured points that touch, over the sum of the last depth and the approach, to the power of the
# round; and maximum rounds: after eight they are 4^36 = 5e21 times deeper.
_DEPTH_FACTOR = 4.0
_MAX_DEEPENINGS = 8
# Error of a contact over that of the last turn of contact and response, and its bound over the tolerance.
_INNER_ERROR = 0.1
_LOOSEST_INNER = 1000.0
# What the contacts of a coupled process cost.
_COST = ("iterations", "convolutions")


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
    increment: LoadIncrement | None = None,
) -> ContactSolution:
    """Return the certified solution at a load, on the gap of the problem or another one.

    If it is not certified it is returned unfinished, or raised in `NotConverged` where `throw` is true. Laws of the
    problem remember the state `before`; None: the surfaces are fresh. The increment from there is by default that of
    the load alone.
    """
    started = time.perf_counter()
    increment = increment or LoadIncrement(load)
    plan = problem.plan
    if gap is None:
        gap = problem._find_gap(increment.shift)
        plan = displace_plan(plan, gap)
    effect = Governed.begin(problem, increment, before) if problem.laws else None
    if effect is not None:
        plan = stiffen_plan(plan, effect.stiffening)
    fresh = _Fresh(problem, gap, keeps=before is not None)
    with computing(problem):
        run = _Run(plan, problem.convolution, on_step, started)
        pressing = None
        if effect is not None and effect.coupled is not None:
            pressing = _Pressing.begin(run, fresh, effect, increment, before, start)
            effect = effect.settle(problem, increment, pressing.settle(effect, increment))
            start = pressing.start
        gap, inner, datum = fresh.place(None if effect is None else effect.offset, load)
        law = None if effect is None else effect.responding
        if law is not None:
            solution = run.solve_by_turns(gap, inner, start, law.soften(problem), partial(law.respond, problem))
        elif effect is not None and effect.is_implicit:
            solution = run.solve_implicitly(gap, inner, start, effect.local_compliance)
        else:
            solution = run.solve(gap, inner, start, start_gap)
        if solution.status is Status.SEPARATED and start_gap is None:
            solution = run.try_other_states(gap, inner) or solution
    if pressing is not None:
        solution = pressing.add_cost(solution)
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
        solution = _govern(solution, effect.press(problem, solution.pressure), datum)
    return require_success(solution) if throw else solution


@attrs.frozen(eq=False)
class _Fresh:
    """The gap of a problem without its laws; whether a state before `keeps` bodies that come apart."""

    problem: Scene
    gap: InitialGap
    keeps: bool

    def place(self, offset: Array | None, load: Load) -> tuple[InitialGap, Load, float]:
        """Return the gap plus what laws add, if any, from its first touch, the load from there, and that touch, m."""
        if offset is None:
            return self.gap, load, 0.0
        gap, datum = _change_gap(self.gap, offset)
        datum += self.problem.summit - self.gap.summit
        inner = load.after(datum)
        if self.problem.adhesion is not None or not (inner.kind == "approach" and load.value >= 0.0 > inner.value):
            return gap, inner, datum
        if not self.keeps:
            raise InputError(
                f"At an approach of {si(load.value, 'm')} the surfaces do not touch: as the laws of the problem have "
                f"changed them, the first touch is at {si(datum, 'm')}."
            )
        # The bodies have come apart: nothing presses at the gap that is left.
        return attrs.evolve(gap, values=frozen_array(gap.values - inner.value)), Load("approach", 0.0), load.value


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
    if not changed.status.success:
        return changed._add(effect)
    found = effect.finish(changed)
    if all(one.holds for one in found.conditions):
        return changed._add(found)
    return attrs.evolve(changed, status=Status.UNCONFIRMED)._add(attrs.evolve(found, numbers={}))


@contextlib.contextmanager
def computing(problem: Scene) -> Iterator[None]:
    """Limit the threads used inside the context to those of a problem."""
    threads = problem.plan.thread_choice[0]
    with use_threads(threads), problem.convolution.use_threads(threads):
        yield


@attrs.frozen(eq=False)
class _Run:
    """The plan, the convolution and the clock of a solve, which may take several attempts."""

    plan: SolvePlan
    convolution: PreparedConvolution
    on_step: Callable[[Step], None] | None
    started: float

    def solve(
        self, gap: InitialGap, load: Load, start: Array | None = None, start_gap: Array | None = None
    ) -> ContactSolution:
        """Solve until no non-measured point touches."""
        plan = self.plan
        deepened = 0
        while True:
            task = make_task(plan, gap.values, load, start, start_gap)
            if self.on_step is not None:
                task = attrs.evolve(task, on_step=self.on_step)
            outcome = plan.solver.solve(self.convolution, task)
            # A clock may be set back, for instance on a suspended machine.
            seconds = max(0.0, time.perf_counter() - self.started)
            solution = certify(plan, self.convolution, gap.values, task, outcome, seconds=seconds)
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
            solution = certify(plan, self.convolution, gap.values, task, outcome, seconds=seconds)
        return solution

    def solve_implicitly(
        self, gap: InitialGap, load: Load, start: Array | None, compliance: float | Array
    ) -> ContactSolution:
        """Solve a contact to whose gap its own pressure adds, with a local compliance, m/Pa.

        It is solved with that compliance and certified without, as a contact of the surfaces that are left.
        """
        plan = self.plan
        if plan.interaction is not None:
            raise InputError(
                "Laws by which the pressure itself changes the gap, such as wear, are not solved with "
                f"{argument('adhesion')}: omit one of them."
            )
        local = compliance * (pressure_unit(plan) / plan.peak_to_valley)
        softened = attrs.evolve(self, convolution=SoftenedConvolution(self.convolution, local))
        found = softened.solve(gap, load, start)
        left = frozen_array(found.initial_gap + compliance * found.pressure)
        again = certify_again(plan, self.convolution, found, left, load)
        kept = ("iterations", "convolutions", "errors", "levels", "seconds")
        return attrs.evolve(again, **{name: getattr(found, name) for name in kept})

    def solve_by_turns(
        self,
        gap: InitialGap,
        load: Load,
        start: Array | None,
        kernel: InfluenceKernel,
        respond: Callable[[Array], Array],
    ) -> ContactSolution:
        """Solve a contact to whose gap its own displacement adds, with another kernel and the rest as an offset.

        It is certified with the kernel of the plan, as a contact of the gap that is left.
        """
        turns = _ResponsiveTurns(self, gap, load, start, attrs.evolve(self.plan, kernel=kernel), respond)
        response, count = take_turns(turns.respond, np.zeros(gap.values.shape), self.plan.solver.tolerance)
        found = response.contact
        again = certify_again(self.plan, self.convolution, found, frozen_array(turns.left), load)
        kept = ("iterations", "errors", "levels", "seconds")
        # One for the response in each turn.
        products = found.convolutions + count + 1
        return attrs.evolve(again, convolutions=products, **{name: getattr(found, name) for name in kept})

    def displace(self, pressure: Array) -> Array:
        """Return the displacement by a pressure, m."""
        given = self.convolution.from_numpy(pressure / pressure_unit(self.plan))
        return self.convolution.to_numpy(self.convolution.apply(given)) * self.plan.peak_to_valley

    def try_other_states(self, gap: InitialGap, load: Load) -> ContactSolution | None:
        """Return a state that carries a load found from that at zero load, or from full contact; None without one.

        Without adhesion nothing touches under a tensile load, so that the first start says little.
        """
        rest = self.solve(gap, Load(load.kind, 0.0))
        starts: list[tuple[Array | None, Array]] = [(None, np.zeros(gap.values.shape))]
        if rest.status.success:
            starts.insert(0, (rest.pressure, np.where(rest.contact, 0.0, np.maximum(rest.gap, 0.0))))
        for pressure, opened in starts:
            found = self.solve(gap, load, pressure, opened)
            if found.status.success:
                return found
        return None


@attrs.define(eq=False)
class _Pressing:
    """The contacts by which a coupled process finds what it changes in an increment, from one load to the next."""

    run: _Run
    fresh: _Fresh
    others: Array
    memory: Memory
    first: Load
    last: Load
    start: Array | None
    cost: dict[str, int] = attrs.field(factory=lambda: dict.fromkeys(_COST, 0))

    @classmethod
    def begin(
        cls,
        run: _Run,
        fresh: _Fresh,
        effect: Governed,
        increment: LoadIncrement,
        before: ContactSolution | None,
        start: Array | None,
    ) -> _Pressing:
        """Return the contacts of an increment, on the gap as the other laws have changed it."""
        if run.plan.interaction is not None:
            raise InputError(f"The law {effect.coupled!r} is not solved with {argument('adhesion')}: omit one of them.")
        load = increment.load
        return cls(
            run=run,
            # An offset that is tried may part the bodies.
            fresh=attrs.evolve(fresh, keeps=True),
            others=effect.without_coupled(fresh.problem, increment),
            memory=effect.before[effect.laws.index(effect.coupled)],
            first=Load(load.kind, 0.0) if before is None else load_of(before, load.kind),
            last=load,
            start=start,
        )

    def settle(self, effect: Governed, increment: LoadIncrement) -> Memory:
        """Return what the coupled process remembers after the increment."""
        assert effect.coupled is not None
        return effect.coupled.settle(self.fresh.problem, self.press, increment, self.memory)

    def press(
        self, offset: Array, *, part: float = 1.0, start: Array | None = None, tolerance: float | None = None
    ) -> ContactSolution:
        """Return the contact on the gap with an offset; see `Press`."""
        gap, load, datum = self.fresh.place(frozen_array(self.others + offset), self.first.toward(self.last, part))
        plan = self.run.plan
        if tolerance is not None:
            plan = attrs.evolve(plan, solver=plan.solver.with_tolerance(tolerance))
        found = attrs.evolve(self.run, plan=plan).solve(gap, load, self.start if start is None else start)
        self.start = found.pressure
        self.cost = self._sum_cost(found)
        return attrs.evolve(found, initial_gap=frozen_array(found.initial_gap + datum), approach=found.approach + datum)

    def add_cost(self, solution: ContactSolution) -> ContactSolution:
        """Return a solution with the cost of all contacts."""
        return attrs.evolve(solution, **self._sum_cost(solution))

    def _sum_cost(self, found: ContactSolution) -> dict[str, Any]:
        return {name: spent + getattr(found, name) for name, spent in self.cost.items()}


@attrs.define(eq=False)
class _ResponsiveTurns:
    """Contacts by another kernel in turn with what is left of the displacement, the offset, m."""

    run: _Run
    gap: InitialGap
    load: Load
    start: Array | None
    softened: SolvePlan
    add: Callable[[Array], Array]
    convolution: PreparedConvolution = attrs.field(init=False)
    left: Array = attrs.field(init=False)
    scale: float = 1.0

    @convolution.default
    def _prepare(self) -> PreparedConvolution:
        return prepare_convolution(self.softened)

    @left.default
    def _begin(self) -> Array:
        return self.gap.values

    def respond(self, rest: Array, error: float) -> Response:
        """Return the contact on the gap with an offset, and what the displacement by its pressure adds to the gap."""
        plan = self.run.plan
        inner = choose_tolerance(error, plan.solver.tolerance, _INNER_ERROR, _LOOSEST_INNER) * self.scale
        changed, datum = self.gap.change(rest)
        softened = attrs.evolve(self.softened, solver=plan.solver.with_tolerance(min(inner, 1.0)))
        turn = attrs.evolve(self.run, plan=softened, convolution=self.convolution)
        found = turn.solve(changed, self.load.after(datum), self.start)
        self.start = found.pressure
        moved = self.run.displace(found.pressure)
        added = self.add(moved)
        self.left = self.gap.values + added
        if self.gap.non_measured is not None:
            # The solve may have deepened them.
            deepest = datum + float(found.initial_gap[self.gap.non_measured].max())
            self.left[self.gap.non_measured] = max(deepest, float(self.left[self.gap.non_measured].max()))
        violation = measure_violation(plan, self.left, self.load, found.pressure, moved)
        # Errors of the softer contact are over its own displacement.
        self.scale = min(1.0, violation.scale * plan.peak_to_valley / found.residuals.scale)
        return Response(found, moved + added - found.displacement, violation.error, is_last=not found.status.success)


@guarded
def require_certified(solution: Any) -> None:
    """Raise `NotConverged` if a solution, whose fields may be of any kind, is not certified.

    Parameters
    ----------
    solution
        Has the status, iterations, residuals and, if it has any, warnings of a `ContactSolution`.
    """
    if not solution.status.success:
        conditions = getattr(solution, "certificate", solution.residuals)
        status = f"The contact is {solution.status} ({solution.iterations} iterations; {conditions})."
        raise NotConverged(" ".join((status, *getattr(solution, "warnings", ()))), solution)


def require_success(solution: ContactSolution) -> ContactSolution:
    """Return the solution, or raise `NotConverged` if it is not certified or not as accurate as requested."""
    require_certified(solution)
    if solution.accuracy is not None and not solution.accuracy.met:
        raise NotConverged(solution.accuracy.explain(), solution)
    return solution
