"""Paths of normal loads, times and sliding distances along which the surfaces change, each state from the one before.

`ContactProblem.path` calls `run_load_path` where no tangential loads are given.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import accumulate, pairwise
from pathlib import Path as File
from typing import Any, TypeVar

import attrs
import numpy as np

from roughcontact._base import checks
from roughcontact._base.arrays import Array, IntArray
from roughcontact._base.machine.progress import ChangeProgress, count_done
from roughcontact._base.tables import Table
from roughcontact._base.units import Estimate, Force, Length, Pressure, counted, si
from roughcontact._parts.grid import Load
from roughcontact._parts.surfaces import HeightMap
from roughcontact._solve.problem.body import Body
from roughcontact._solve.problem.brought_laws import remember_both, remember_changes
from roughcontact._solve.problem.coupled import SteadyFriction
from roughcontact._solve.problem.follow_places import choose_solve, follow_places
from roughcontact._solve.problem.friction_certificate import require_frictional
from roughcontact._solve.problem.friction_plan import require_memory_of_friction
from roughcontact._solve.problem.increments import is_single
from roughcontact._solve.problem.load_march import LoadMarch, Place, Standing, identify, list_places, list_shifts
from roughcontact._solve.problem.path import Path
from roughcontact._solve.problem.path_file import (
    KIND,
    OPEN,
    PathFile,
    note_path,
    require_digests,
)
from roughcontact._solve.problem.scene import Scene
from roughcontact._solve.problem.sweep import tabulate_states
from roughcontact._solve.problem.task import limit_load
from roughcontact._solve.solution import ContactSolution, Governed, Process, load_of, read_states
from roughcontact.errors import ContactWarning, InputError, argument
from roughcontact.errors.door import guarded
from roughcontact.errors.warning import warn

S = TypeVar("S", bound=Scene)

# Admissible error of an increment, over the change of the surfaces.
PATH_ACCURACY = 1e-3
_PASSED = {"time": "time", "sliding": "sliding distance"}


@attrs.frozen(eq=False, kw_only=True)
class LoadPath(Path):
    """The states of a contact along normal loads, times and sliding distances: iterable, with `len` and ``[]``.

    The surfaces change along it: they are flattened where a material has a hardness, and as the laws of the problem
    say. Each state remembers those before.

    Attributes
    ----------
    states
        The states at the given places, in their order.
    increments
        Increments from the place before to each.
    accuracy
        Admissible error of an increment; see `ContactProblem.path`.

    Examples
    --------
    A ball that is pressed, unloaded and pressed again carries the second load elastically:

    >>> import roughcontact as rc
    >>> steel = rc.ElasticPerfectlyPlastic(young=210e9, poisson=0.3, hardness=2e9)
    >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), steel)
    >>> path = rc.ContactProblem(ball, grid=rc.Grid((48, 48), 100e-6)).path(force=[4.0, 0.0, 4.0])
    >>> [f"{work * 1e9:.1f} nJ" for work in path.table().columns["plastic_work"]]
    ['267.8 nJ', '267.8 nJ', '267.8 nJ']
    """

    kind = KIND
    view = "load-path"
    curve = "contact along the path"

    states: tuple[ContactSolution, ...]
    increments: tuple[int, ...]
    accuracy: float = PATH_ACCURACY

    @property
    def time(self) -> Array:
        """Time since the start of the path, s."""
        return np.array([_read(state, "elapsed") for state in self.states])

    @property
    def sliding(self) -> Array:
        """Sliding distance since the start of the path, m."""
        return np.array([_read(state, "slid") for state in self.states])

    @property
    def shift(self) -> IntArray:
        """Cells by which the counterbody is displaced from its first place, shape (states, 2)."""
        effects = (state._find_added(Governed) for state in self.states)
        return np.array([(0, 0) if effect is None else effect.shift for effect in effects])

    @property
    def detailed(self) -> ContactSolution:
        """The state that a page shows in detail, the last one that carries a load."""
        return next((state for state in reversed(self.states) if state.force), self.states[-1])

    @property
    def bodies(self) -> tuple[Body, Body]:
        """Both bodies with the heights that they have after the path, unloaded, as of another problem.

        What is flattened is taken from the softer body, half of it from each where both are equally hard. A warning
        says what laws remember that is not in the heights.
        """
        return find_bodies(self.states[-1])

    def extend(
        self,
        *,
        force: Force | Iterable[Force] | None = None,
        pressure: Pressure | Iterable[Pressure] | None = None,
        approach: Length | Iterable[Length] | None = None,
        time: Iterable[float | str] | None = None,
        sliding: Iterable[Length] | None = None,
        shift: Iterable[Sequence[int]] | None = None,
        accuracy: float | None = None,
    ) -> LoadPath:
        """Return the path continued from its last state, such as one from a file; see `ContactProblem.path`.

        Times and distances still count from the start of the path; the accuracy is by default that of the path.

        Examples
        --------
        >>> import roughcontact as rc
        >>> steel = rc.ElasticPerfectlyPlastic(young=210e9, poisson=0.3, hardness=2e9)
        >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), steel)
        >>> path = rc.ContactProblem(ball, grid=rc.Grid((32, 32), 100e-6)).path(force=[4.0, 0.0])
        >>> len(path.extend(force=[2.0, 6.0]))
        4
        """
        last = self.states[-1]
        if last.origin is None:
            raise InputError("The path does not say which problem it followed, so that it cannot be continued.")
        scene: Scene = last.origin.scene
        loads = _list_loads(scene, {"force": force, "pressure": pressure, "approach": approach}, Load.unsigned_sequence)
        first = (int(self.shift[-1, 0]), int(self.shift[-1, 1]))
        moved = None if shift is None else list_shifts(shift)
        passed = {"time": time, "sliding": _measure_sliding(scene, sliding, moved, first, float(self.sliding[-1]))}
        require_used(scene, passed)
        _require_movable(scene, moved)
        begin = Place(
            load=load_of(last, loads[0].kind),
            time=float(self.time[-1]),
            sliding=float(self.sliding[-1]),
            shift=first,
        )
        kept = passed | {"shift": moved}
        places = [
            attrs.evolve(place, **{name: getattr(begin, name) for name, given in kept.items() if given is None})
            for place in list_places(loads, **kept)
        ]
        if any(getattr(places[0], name) < getattr(begin, name) for name in passed):
            raise InputError(
                f"The path ends after {si(begin.time, 's')} and {si(begin.sliding, 'm')}: times and distances "
                "count from its start, and do not fall."
            )
        strict = self.accuracy if accuracy is None else check_accuracy(accuracy)
        standing = Standing(states=(last,), since=identify(last))
        solve = choose_solve(scene, SteadyFriction.of(last))
        march = LoadMarch(solve, strict, standing=standing)
        found = [(march.go(one, other), march.last) for one, other in pairwise([begin, *places])]
        counts, states = zip(*found, strict=True)
        return LoadPath(states=(*self.states, *states), increments=(*self.increments, *counts), accuracy=strict)

    def verify(self) -> None:
        """Recompute the certificate of each state; `InputError` if one contradicts itself or the state before."""
        super().verify()
        self._require_row()

    def _require_row(self, stated: str = "") -> None:
        """Raise `InputError` unless the states follow each other, the last one as a file states it."""
        for before, after, count in zip(self.states, self.states[1:], self.increments[1:], strict=False):
            _require_following(before, after, count)
        require_digests(self.states, stated)

    @classmethod
    def _restore(cls, states: tuple[ContactSolution, ...], notes: Mapping[str, Any]) -> LoadPath:
        counts = tuple(int(count) for count in notes["increments"])
        if OPEN in notes:
            # Behind the places that are reached, the file has states from which the path goes on.
            states = states[: len(counts)]
            if not states:
                raise InputError("The path has not reached its first place: follow it on, with the same file=.")
        if len(counts) != len(states) or min(counts) < 1:
            raise InputError("The file is damaged: its increments are not those of its states.")
        # Former files do not state the accuracy, nor which states follow which.
        path = cls(states=states, increments=counts, accuracy=check_accuracy(notes.get("accuracy", PATH_ACCURACY)))
        path._require_row(str(notes.get("end", "")))
        return path

    def _note_rest(self) -> dict[str, Any]:
        return note_path(self.increments, self.states, self.accuracy)

    def list_arguments(self) -> dict[str, Any]:
        """Return the arguments of `ContactProblem.path`."""
        passed = {name: values.tolist() for name, values in self._list_passed().items()}
        moved = {"shift": self.shift.tolist()} if self.shift.any() else {}
        strict = {"accuracy": self.accuracy} if passed else {}
        friction = SteadyFriction.of(self.states[0])
        angle = None if friction is None else self.states[0].tangential_load.angle
        slides = {} if friction is None else {"friction": friction.law, "direction": angle}
        return super().list_arguments() | passed | moved | strict | slides

    def _list_passed(self) -> dict[str, Array]:
        """Return time and sliding distance, as far as they pass."""
        return {name: values for name in ("time", "sliding") if (values := getattr(self, name)).any()}

    def label_states(self) -> tuple[Table, list[str]]:
        """Return what passes until each state, or its number, and its name in a sentence."""
        passed = self._list_passed()
        units = {"time": "s", "sliding": "m"}
        heads = Table(passed or {"state": range(1, len(self) + 1)}, {name: units[name] for name in passed})
        if not passed:
            return heads, [f"state {number}" for number in range(1, len(self) + 1)]
        words = {"time": "after", "sliding": "after sliding"}
        name, values = next(iter(passed.items()))
        return heads, [f"{words[name]} {si(float(value), units[name], 3)}" for value in values]

    def table(self) -> Table:
        """Return a row for each state, in SI units; see `roughcontact.typing.Table`.

        Its columns are ``time`` and ``sliding`` where they pass, ``increments``, and those of a sweep without
        ``secant_stiffness``.
        """
        found = tabulate_states(self.states)
        return Table(
            {**self._list_passed(), "increments": list(self.increments), **found.columns},
            {"time": "s", "sliding": "m", **found.units},
        )

    def short_table(self) -> Table:
        """Return a row for each state for people: the area with its uncertainty in percent of nominal."""
        percent = 100.0 / self.states[0].grid.area
        areas = [state.area() for state in self.states]
        columns: dict[str, Any] = {
            **self._list_passed(),
            "force": self.force,
            "approach": self.approach,
            "area, %": [Estimate(percent * area.value, percent * area.uncertainty, "") for area in areas],
            "peak": [float(state.pressure.max()) for state in self.states],
        }
        return Table(columns, {"time": "s", "sliding": "m", "force": "N", "approach": "m", "peak": "Pa"})

    def _list_results(self) -> Mapping[str, str]:
        last = self.states[-1]
        rows = {name: text for one in last.added for name, text in one.list_rows(last).items()}
        # A page begins with the first one.
        return {name: text for name, text in rows.items() if name != "laws"} | rows

    def __repr__(self) -> str:
        low, high = (si(float(bound), "N") for bound in (self.force.min(), self.force.max()))
        return f"<LoadPath {counted(len(self), 'state')}, force {low} to {high}, {self.states[0].grid}>"


def _require_following(before: ContactSolution, after: ContactSolution, increments: int) -> None:
    """Raise `InputError` unless a state may follow another one of a path, and does if it is of one increment."""
    one, other = (state._find_added(Governed) for state in (before, after))
    if one is None or other is None:
        return
    begins = increments > 1 or all(
        np.array_equal(known[name], found[name])
        for known, found in zip(one.memory, other.before, strict=True)
        for name in known
    )
    if not begins or other.elapsed < one.elapsed or other.slid < one.slid:
        raise InputError("The file is damaged: its states do not follow each other.")


def _read(state: ContactSolution, name: str) -> float:
    effect = state._find_added(Governed)
    return 0.0 if effect is None else float(getattr(effect, name))


def find_bodies(last: ContactSolution, history: str = "changed along a path of loads") -> tuple[Body, Body]:
    """Return both bodies with the heights that they have after a last state, unloaded; see `LoadPath.bodies`."""
    origin = last.origin
    if origin is None:
        raise InputError("The path does not say which problem it followed, so that its bodies are not known.")
    scene: Scene = origin.scene
    effect = last._find_added(Governed)
    losses = [np.zeros(last.grid.shape) for _ in range(2)]
    pairs = () if effect is None else zip(scene.laws, effect.memory, strict=True)
    for law, memory in pairs:
        parts = law.divide(scene, memory) if isinstance(law, Process) else (0.0, 0.0)
        for loss, part in zip(losses, parts, strict=True):
            loss += part
        if isinstance(law, Process) and law.left_behind and any(np.any(part) for part in parts):
            warn(
                f"The bodies have the heights after the path, but not {law.left_behind}: extend the path to keep it.",
                ContactWarning,
            )
    body, counterbody = (
        _take_heights(side, loss, last, history)
        for side, loss in zip((scene.body, scene.counterbody), losses, strict=True)
    )
    return body, counterbody


def _take_heights(side: Body, loss: Array, last: ContactSolution, history: str) -> Body:
    if not loss.any():
        return side
    surface = HeightMap(
        side.heights(last.grid) - loss,
        last.grid.size,
        periodic=not last.boundary.has_free_axis,
        non_measured=side.non_measured(last.grid),
        history=(*side.provenance, history),
    )
    return Body(surface, side.material)


def run_load_path(
    problem: Scene,
    normal: Mapping[str, Any],
    omitted: Mapping[str, Any],
    passed: Mapping[str, Any],
    accuracy: float,
    on_increment: object,
    change: ChangeProgress,
    file: str | os.PathLike[str] | None = None,
    friction: SteadyFriction | None = None,
    is_draft: bool = False,
) -> LoadPath:
    """Return the path of a problem without tangential loads; see `ContactProblem.path`, and `PathFile` for its file.

    With friction its bodies slide steadily.
    """
    slides = friction is not None
    require_omitted(omitted, f"without {argument('sliding')}" if slides else f"with {argument('friction', '0.3')}")
    accuracy = check_accuracy(accuracy)
    told = checks.callback(on_increment, "on_increment=", "state")
    scene, places = prepare_path(problem, normal, **passed, accuracy=accuracy, slides=slides)
    count = count_done(change, len(places), "place")
    kept = None if file is None else PathFile(file, scene, places, accuracy, is_draft, friction)
    solve = choose_solve(scene, friction)
    counts, states = follow_places(scene, solve, places, accuracy, told or (lambda state: None), count, kept)
    return LoadPath(states=states, increments=counts, accuracy=accuracy)


@guarded
def prepare_path(
    problem: S,
    normal: Mapping[str, Any],
    *,
    time: Any = None,
    sliding: Any = None,
    shift: Any = None,
    accuracy: object = PATH_ACCURACY,
    slides: bool = False,
) -> tuple[S, tuple[Place, ...]]:
    """Return the problem with the laws that its materials bring, and the places of a path; see `ContactProblem.path`.

    Its bodies may slide steadily with friction. `InputError` if they cannot carry a load, if friction does not fit
    them, or if nothing that is given uses what passes.
    """
    check_accuracy(accuracy)
    loads = _list_loads(problem, normal, Load.resting_sequence)
    moved = None if shift is None else list_shifts(shift)
    scene = remember_changes(problem)
    if slides:
        require_omitted({"shift": shift}, "without friction")
        require_frictional(scene, passing=("time", "sliding"))
    passed = {"time": time, "sliding": _measure_sliding(scene, sliding, moved, (0, 0), 0.0)}
    places = list_places(loads, **passed, shift=moved)
    require_used(scene, passed)
    _require_movable(scene, moved)
    if np.any(moved or 0):
        scene = remember_both(scene)
    if slides:
        require_memory_of_friction(scene.plan, states=len(places))
    return scene, places


def check_accuracy(value: object) -> float:
    """Return the admissible error of an increment; `InputError` if it is none."""
    return checks.number(value, "The accuracy of a path", above=0.0, at_most=1.0)


def _list_loads(problem: Scene, normal: Mapping[str, Any], make: Callable[..., tuple[Load, ...]]) -> tuple[Load, ...]:
    """Return the loads of a path, which surfaces that attract each other may have of any sign."""
    lists = {kind: [value] if is_single({kind: value}) else value for kind, value in normal.items()}
    loads = (make if problem.adhesion is None else Load.signed_sequence)(**lists)
    for load in loads:
        limit_load(problem.plan, problem.initial_gap, load)
    return loads


def require_omitted(given: Mapping[str, object], when: str) -> None:
    """Raise `InputError` if an argument is given that is used otherwise alone, `when`."""
    for name, value in given.items():
        if value is not None:
            raise InputError(f"The argument {name}= of a path is used only {when}: omit it.")


def require_used(problem: Scene, passed: Mapping[str, object]) -> None:
    """Refuse time and distance if no law of the problem depends on them."""
    for name, value in passed.items():
        if value is not None and not any(name in law.rates for law in problem.laws):
            raise InputError(
                f"Nothing changes with the {_PASSED[name]}: give the problem a law that does, such as Archard's of "
                f"wear by {argument('laws')}, or a viscoelastic body."
            )


def _measure_sliding(
    problem: Scene, given: Any, shifts: Sequence[tuple[int, int]] | None, first: tuple[int, int], slid: float
) -> Any:
    """Return the sliding distances of a path, by default those of the counterbody where a law depends on them, m."""
    if given is not None or shifts is None or not any("sliding" in law.rates for law in problem.laws):
        return given
    dx, dy = problem.plan.grid.spacing
    steps = [math.hypot(dx * (x - u), dy * (y - v)) for (u, v), (x, y) in pairwise([first, *shifts])]
    return [slid + total for total in accumulate(steps)]


def _require_movable(problem: Scene, shifts: Sequence[tuple[int, int]] | None) -> None:
    """Refuse that the counterbody moves where its heights do not repeat, or something would not move with it."""
    if shifts is None or not np.any(shifts):
        return
    plan = problem.plan
    for axis, repeats in enumerate(plan.boundary.repeats):
        if np.any(np.array(shifts)[:, axis]) and not repeats:
            raise InputError(
                f"A counterbody that moves along {'xy'[axis]} needs a boundary that is periodic there, but it is "
                f"{plan.boundary!s}."
            )
    if plan.interaction is not None or np.ndim(plan.pressure_limit):
        raise InputError(f"A counterbody moves without adhesion and a hardness that varies: omit {argument('shift')}.")
    if not problem.laws:
        raise InputError(
            f"Nothing remembers where the counterbody has been: give the problem a law by {argument('laws')}, or omit "
            f"{argument('shift')}."
        )
    left = [law for law in problem.laws if not law.follows_bodies]
    if left:
        raise InputError(f"The law {left[0]!r} does not follow bodies that move: omit {argument('shift')}.")


def save_load_path(file: str | os.PathLike[str], path: LoadPath, key: str) -> None:
    """Write a path under the key by which a study finds it; see `LoadPath.save`."""
    path._save(file, key=key)


def read_load_path(file: File, key: str) -> LoadPath:
    """Return the path in a file, which must have a key; its certificates are not computed again."""
    states, notes = read_states(file, KIND, verify=False)
    if notes.get("key") != key:
        raise InputError(f"The file {file.name} does not hold the path with the key {key}.")
    return LoadPath._rebuild(file, states, notes)
