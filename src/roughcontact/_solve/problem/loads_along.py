"""Loads along the surface: the path of a problem with friction, and its steady sliding."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from roughcontact._base import checks
from roughcontact._base.arrays import unit_vector
from roughcontact._base.machine.progress import ChangeProgress, tell_both
from roughcontact._parts.grid import Load
from roughcontact._parts.interactions import Coulomb, FrictionLaw
from roughcontact._solve.problem.brought_laws import remember_flattening
from roughcontact._solve.problem.coupled import CoupledSolve, SteadyFriction
from roughcontact._solve.problem.fretting import follow_cycles, list_cycles
from roughcontact._solve.problem.friction_certificate import require_frictional
from roughcontact._solve.problem.friction_plan import require_memory_of_friction
from roughcontact._solve.problem.frictional_path import FrictionalPath
from roughcontact._solve.problem.increments import follow_loads, list_steps
from roughcontact._solve.problem.load_path import PATH_ACCURACY, require_omitted
from roughcontact._solve.problem.scene import Scene
from roughcontact._solve.problem.task import limit_load
from roughcontact._solve.solution import ContactSolution
from roughcontact._solve.solvers import Step
from roughcontact.errors import InputError, argument
from roughcontact.errors.door import guarded


def resolve_friction(friction: object) -> FrictionLaw:
    """Return a friction law: a number is a coefficient of friction."""
    if isinstance(friction, FrictionLaw):
        return friction
    if isinstance(friction, (bool, str)) or not isinstance(friction, (int, float, np.ndarray, np.number)):
        raise InputError.about(argument("friction"), friction, "a coefficient or a FrictionLaw such as Coulomb(0.3)")
    return Coulomb(friction)


def run_path(
    problem: Scene,
    normal: Mapping[str, object],
    tangential: Mapping[str, object],
    omitted: Mapping[str, object],
    friction: object,
    substeps: object,
    on_increment: object,
    change: ChangeProgress,
    cycles: object = None,
    accuracy: float = PATH_ACCURACY,
) -> FrictionalPath:
    """Return the states along a path; see `ContactProblem.path`."""
    require_omitted(omitted, "where bodies slide or have no friction")
    law = resolve_friction(friction)
    count = None if substeps == "auto" else checks.integer(substeps, argument("substeps"), at_least=1)
    told = checks.callback(on_increment, "on_increment=", "increment")
    tell = tell_both(told, lambda done: change(str(done)))
    problem = remember_flattening(problem)
    require_frictional(problem)
    run = CoupledSolve(problem, law)
    segments = list_steps(run, normal, tangential)
    has_pressing = segments[0].number == 0
    places = None if cycles is None else list_cycles(cycles)
    is_exact = count == 1 or all(segment.exact for segment in segments)
    computed = len(segments) * len(places or (0.0,))
    # Kept states that do not begin with the one before, but between its increments or after other cycles.
    apart = len(places or ()) if is_exact else computed
    require_memory_of_friction(problem.plan, computed, apart)
    wear = 0.0
    if places is not None:
        accuracy = checks.number(accuracy, "The accuracy of a path", above=0.0, at_most=1.0)
        steps, numbers, reasons, wear = follow_cycles(run, segments, count, places, accuracy, tell)
        reasons = [*([""] if has_pressing else []), *reasons]
    else:
        steps, numbers, reasons = follow_loads(run, segments, count, tell)
    kept = slice(1 if has_pressing else 0, None)
    pressed = steps[0] if has_pressing else None
    begin = FrictionalPath(states=(), pressed=pressed, numbers=(), increments=(), reasons=(), accuracy=accuracy)
    return begin._append(steps[kept], numbers[kept], reasons[kept], wear)


def resolve_sliding(friction: object, direction: object) -> SteadyFriction | None:
    """Return the friction of bodies that slide in a direction, degrees, by default along x; None without friction."""
    if friction is None:
        require_omitted({"direction": direction}, f"with {argument('friction', '0.3')}")
        return None
    return _slide_along(friction, 0.0 if direction is None else direction)


def _slide_along(friction: object, direction: object) -> SteadyFriction:
    along = unit_vector(checks.number(direction, "The direction of sliding", "degrees"))
    return SteadyFriction(resolve_friction(friction), along)


@guarded
def run_slide(
    problem: Scene,
    normal: Mapping[str, object],
    friction: object,
    direction: object,
    on_step: Callable[[Step], None] | None = None,
    on_pass: Callable[[Step], None] | None = None,
) -> ContactSolution:
    """Return the contact in steady sliding; see `ContactProblem.slide`.

    `on_step` is called after each iteration of the frictionless contact, from which the bodies slide, and `on_pass`
    after each alternation of pressure and traction of unlike bodies.
    """
    sliding = _slide_along(friction, direction)
    # Nothing passes in one state.
    require_frictional(problem, passing=("time", "sliding", "slip"))
    load = Load.of(**normal)
    limit_load(problem.plan, problem.initial_gap, load)
    return CoupledSolve(problem, sliding.law, on_step=on_step).slide(load, direction=sliding.direction, on_pass=on_pass)
