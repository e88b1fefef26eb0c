"""The file of a path while it grows: a path whose process ends goes on where it stood."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Mapping, Sequence
from typing import Any

import attrs

from roughcontact._base import checks
from roughcontact._base.archive.plain import key_of
from roughcontact._solve.problem.coupled import SteadyFriction
from roughcontact._solve.problem.load_march import COST, Place, Standing, identify
from roughcontact._solve.problem.scene import Scene
from roughcontact._solve.solution import (
    ContactSolution,
    Governed,
    read_states,
    solution_key,
    usable,
    write_states,
)
from roughcontact.errors import InputError

KIND = "load path"
# What stands under this name in the notes of a file: the unfinished part of a path.
OPEN = "open"
_NUMBERS = ("since", "passed", "count", *COST, "last_length", "next_length")
# Time from one writing to the next, over that of the last one: a tenth of the path is spent on its file.
_PATIENCE = 10.0
# Time that a draft takes its first writing for, s: a path that is found before has none.
_EXPECTED_COST = 0.05


@attrs.frozen(eq=False, kw_only=True)
class Leg:
    """The increments from one place of a path to the next, and the state there."""

    increments: int
    state: ContactSolution


class PathFile:
    """The file into which a path is written while it grows.

    Parameters
    ----------
    path
        The file, ``.npz``.
    problem
        The problem, with the laws that its materials bring.
    places, accuracy
        What the path is along.
    is_draft
        Whether it holds the path only while that is unfinished: anything else that stands there is left as it is.
    friction
        The friction of bodies that slide along it; None: without.
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        problem: Scene,
        places: Sequence[Place],
        accuracy: float,
        is_draft: bool = False,
        friction: SteadyFriction | None = None,
    ) -> None:
        self._path = checks.path(path, "The file of a path")
        if self._path.suffix != ".npz":
            raise InputError.about("The name of the file of a path", self._path.name, "one ending in .npz")
        if not self._path.parent.is_dir():
            raise InputError(f"There is no folder {str(self._path.parent)!r} to write {self._path.name!r} into.")
        self._problem = problem
        self._accuracy = accuracy
        self._is_draft = is_draft
        self._is_taken = False
        content = [problem.parts, [attrs.asdict(place) for place in places], accuracy]
        self._given: dict[str, Any] = {}
        if friction is not None:
            content += [friction.law, friction.direction]
            self._given = {"shear": friction.law}
        # Another version of a package may find other bits.
        self._key = solution_key(key_of(content), {}, chosen=problem.chosen)
        self._written = time.perf_counter() if is_draft else -math.inf
        self._cost = _EXPECTED_COST if is_draft else 0.0

    def read(self) -> tuple[list[Leg], Standing | None]:
        """Return what the file has of the path, and where its march stands; None of a path that is finished.

        `InputError` if the file holds something else, unless it is a draft.
        """
        if not self._path.exists():
            return [], Standing()
        with usable(self._path, "it is not that of a path"):
            states, notes = self._read_states()
            if self._is_taken:
                return [], Standing()
            if notes.get("key") != self._key:
                raise InputError(
                    "It holds a path of another problem or along other places, or was written by another version of "
                    "roughcontact, numpy or scipy. Remove it, or give another name."
                )
            known = [self._bind(state) for state in states]
            opened = notes.get(OPEN)
            if opened is None:
                pairs = zip(notes["increments"], known, strict=True)
                return [Leg(increments=int(count), state=state) for count, state in pairs], None
            legs = [Leg(increments=int(count), state=known[place]) for count, place in opened["legs"]]
            standing = {name: type(getattr(Standing(), name))(opened[name]) for name in _NUMBERS}
            last = tuple(known[place] for place in opened["states"])
            require_digests([*(leg.state for leg in legs), last[-1]], str(opened["end"]))
            return legs, Standing(states=last, **standing)

    def _read_states(self) -> tuple[Sequence[ContactSolution], Mapping[str, Any]]:
        """Return the states and notes of the file; a draft notes whether it holds something else."""
        try:
            states, notes = read_states(self._path, KIND, verify=False, given=self._given)
        except InputError:
            self._is_taken = self._is_draft
            if not self._is_draft:
                raise
            return (), {}
        self._is_taken = self._is_draft and OPEN not in notes
        return states, notes

    def _bind(self, state: ContactSolution) -> ContactSolution:
        """Return a state with the problem itself, and its laws."""
        assert state.origin is not None
        state = attrs.evolve(state, origin=attrs.evolve(state.origin, source=self._problem))
        effect = state._find_added(Governed)
        return state if effect is None else state._add(attrs.evolve(effect, laws=self._problem.laws))

    def write(self, legs: Sequence[Leg], standing: Standing, hidden: int) -> None:
        """Write where a march stands, if the last time was long ago; the first legs, `hidden`, lead to no place."""
        begun = time.perf_counter()
        if self._is_taken or begun - self._written < _PATIENCE * self._cost:
            return
        shown = [leg.state for leg in legs[hidden:]]
        states = [*shown, *(leg.state for leg in legs[:hidden]), *standing.states]
        states = list({id(state): state for state in states}.values())
        places = {id(state): place for place, state in enumerate(states)}
        opened = {
            "legs": [[leg.increments, places[id(leg.state)]] for leg in legs],
            "states": [places[id(state)] for state in standing.states],
            **{name: getattr(standing, name) for name in _NUMBERS},
            "end": identify(standing.states[-1]),
        }
        notes = {**note_path(list_increments(legs, hidden), shown, self._accuracy), "key": self._key, OPEN: opened}
        write_states(self._path, KIND, states, notes)
        self._written = time.perf_counter()
        self._cost = self._written - begun

    def finish(self, increments: Sequence[int], states: Sequence[ContactSolution]) -> None:
        """Write a whole path; that of a draft is written by those who asked for it."""
        if self._is_draft:
            return
        notes = {**note_path(increments, states, self._accuracy), "key": self._key}
        write_states(self._path, KIND, states, notes)


def list_increments(legs: Sequence[Leg], hidden: int) -> list[int]:
    """Return the increments to each place, of which the first has those of the legs before, too."""
    counts = [leg.increments for leg in legs]
    return [sum(counts[: hidden + 1]), *counts[hidden + 1 :]] if len(counts) > hidden else []


def note_path(increments: Sequence[int], states: Sequence[ContactSolution], accuracy: float) -> dict[str, Any]:
    """Return what a file holds of a path beside its states, with what identifies the last one."""
    end = identify(states[-1]) if states else ""
    return {"increments": list(increments), "accuracy": accuracy, "end": end}


def require_digests(states: Sequence[ContactSolution], end: str) -> None:
    """Raise `InputError` unless each state is that which the next one follows, and the last one as stated.

    States of former files do not say which one they follow, nor these files which is the last one.
    """
    known = list(map(identify, states))
    stated = [*map(_find_previous, states[1:]), end]
    if any(name and name != one for one, name in zip(known, stated, strict=True)):
        raise InputError("The file is damaged: its states do not follow each other.")


def _find_previous(state: ContactSolution) -> str:
    effect = state._find_added(Governed)
    return "" if effect is None else effect.previous
