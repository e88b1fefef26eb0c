"""From place to place: the states of a path, begun or continued from its file."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from itertools import pairwise
from typing import Any

import attrs

from roughcontact._solve.problem.coupled import SteadyFriction
from roughcontact._solve.problem.load_march import COST, LoadMarch, Place, Standing
from roughcontact._solve.problem.path_file import Leg, PathFile, list_increments
from roughcontact._solve.problem.run import run_solve
from roughcontact._solve.problem.scene import Scene
from roughcontact._solve.solution import ContactSolution
from roughcontact.errors import InputError


def choose_solve(problem: Scene, friction: SteadyFriction | None) -> Callable[..., ContactSolution]:
    """Return the solve of a problem whose bodies slide steadily with friction; None: without."""
    return partial(run_solve, problem) if friction is None else friction.solve_with(problem)


def follow_places(
    problem: Scene,
    solve: Callable[..., ContactSolution],
    places: Sequence[Place],
    accuracy: float,
    tell: Callable[[ContactSolution], object],
    count: Callable[[ContactSolution], object],
    file: PathFile | None = None,
) -> tuple[tuple[int, ...], tuple[ContactSolution, ...]]:
    """Return the increments to the places of a path, and the states there.

    Each increment is reported, and each of these states counted. From the file of a path that has begun it
    goes on, and into this it is written.
    """
    first = places[0]
    # Of several loads the first rises from zero if time or distance pass until there; one holds from the start on.
    at_once = len({place.load for place in places}) == 1 or not (first.time or first.sliding)
    if not at_once and problem.adhesion is not None:
        raise InputError(
            "Bodies that attract each other come from far away, and not from a load of zero, at which they may be in "
            "contact: begin the path at zero time and sliding distance, with the load from which they come."
        )
    start = Place(load=first.load if at_once else attrs.evolve(first.load, value=0.0), shift=first.shift)
    hidden = int(first != start)
    stops = (None, *[start] * hidden, *places)
    legs, standing = ([], Standing()) if file is None else file.read()
    if standing is None:
        # The file has the whole path.
        hidden = 0
    for leg in legs[hidden:]:
        count(leg.state)
    if standing is not None:

        def keep(state: ContactSolution) -> None:
            tell(state)
            if file is not None:
                file.write(legs, march.standing, hidden)

        march = LoadMarch(solve, accuracy, keep, standing)
        for begin, end in pairwise(stops[len(legs) :]):
            assert end is not None
            legs.append(Leg(increments=march.go(begin, end), state=march.last))
            if len(legs) > hidden:
                count(march.last)
    states = tuple(leg.state for leg in legs[hidden:])
    if hidden:
        spent: dict[str, Any] = {name: sum(getattr(leg.state, name) for leg in legs[: hidden + 1]) for name in COST}
        states = (attrs.evolve(states[0], **spent), *states[1:])
    increments = tuple(list_increments(legs, hidden))
    if standing is not None and file is not None:
        file.finish(increments, states)
    return increments, states
