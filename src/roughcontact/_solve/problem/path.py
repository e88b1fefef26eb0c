"""Paths: the states of a contact in their order, and what a sweep, a cycle and a path with friction share."""

from __future__ import annotations

import abc
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path as File
from typing import Any, ClassVar, Self, TypeVar, overload

import attrs
import numpy as np

from roughcontact._base import checks
from roughcontact._base.arrays import Array
from roughcontact._base.registry import find_view
from roughcontact._base.tables import Table, TableResult
from roughcontact._base.units import Estimate
from roughcontact._solve.problem.plan import SolvePlan
from roughcontact._solve.solution import ContactSolution, find_load, read_states, usable, write_states

T = TypeVar("T")


@attrs.frozen(eq=False)
class Path(TableResult, Sequence[ContactSolution]):
    """The states of a contact in their order: iterable, with `len` and ``[]``; a row of numbers for each."""

    # Its name in files, the view that draws it, and what this view shows.
    kind: ClassVar[str]
    view: ClassVar[str]
    curve: ClassVar[str]

    @property
    def verb(self) -> str:
        """The method of a problem that follows such a path."""
        return self.kind.rpartition(" ")[2]

    @property
    @abc.abstractmethod
    def states(self) -> tuple[ContactSolution, ...]:
        """The states; an attribute may define it."""

    def __iter__(self) -> Iterator[ContactSolution]:
        return iter(self.states)

    def __len__(self) -> int:
        return len(self.states)

    @overload
    def __getitem__(self, index: int) -> ContactSolution: ...

    @overload
    def __getitem__(self, index: slice) -> Sequence[ContactSolution]: ...

    def __getitem__(self, index: int | slice) -> ContactSolution | Sequence[ContactSolution]:
        return checks.item_of(self.states, index, f"The index of a {self.verb}")

    @property
    def force(self) -> Array:
        """Normal forces, N."""
        return np.array([state.force for state in self.states])

    @property
    def mean_pressure(self) -> Array:
        """Nominal mean pressures, Pa."""
        return np.array([state.mean_pressure for state in self.states])

    @property
    def approach(self) -> Array:
        """Approaches since first touch, m."""
        return np.array([state.approach for state in self.states])

    @property
    def convolutions(self) -> int:
        """Convolutions of all solves together."""
        return sum(state.convolutions for state in self.states)

    @property
    def detailed(self) -> ContactSolution:
        """The state that a page shows in detail, that of the largest load."""
        return max(self.states, key=lambda state: state.force)

    @property
    def given(self) -> Sequence[ContactSolution]:
        """The states whose loads were given, in their order."""
        return self.states

    def list_arguments(self) -> dict[str, Any]:
        """Return the arguments of the call that follows the path again: `verb` of its problem."""
        loads = [load for load in map(find_load, self.given) if load is not None]
        return {loads[0].kind: [load.value for load in loads]}

    def explain_plan(self, plan: SolvePlan | None) -> str:
        """Return the plan, if it is known, and what was chosen on the way, in words; empty: that of its states."""
        return ""

    def list_numbers(self) -> Mapping[str, Estimate | None]:
        """Return the numbers of the path as a whole by name; None where one has no value."""
        return {}

    def list_rest(self) -> Mapping[str, Any]:
        """Return what else data of the path as a whole have, as plain values."""
        return {}

    @property
    def warnings(self) -> tuple[str, ...]:
        """Why all numbers of the path must not be trusted, in sentences; empty without a reason."""
        return ()

    def label_states(self) -> tuple[Table, list[str]]:
        """Return the columns that tell the states apart, and the name of each in a sentence."""
        numbers = range(1, len(self) + 1)
        return Table({"state": numbers}), [f"state {number}" for number in numbers]

    def verify(self) -> None:
        """Recompute the certificate of each state; `InputError` if one contradicts itself or the state before."""
        for state in self._saved_states:
            state.verify()

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the path to a file ``.npz``, completely or not at all; an existing file is replaced."""
        self._save(path)

    def _save(self, path: str | os.PathLike[str], **notes: Any) -> None:
        write_states(checks.path(path, "The file"), self.kind, self._saved_states, {**self._note_rest(), **notes})

    @classmethod
    def load(cls, path: str | os.PathLike[str], *, verify: bool = True) -> Self:
        """Return the path in a file that `save` has written.

        Parameters
        ----------
        path
            The file.
        verify
            Whether to build the problem and recompute the certificate of each state.

        Raises
        ------
        InputError
            If there is no such file, it is damaged or of another kind, or its content contradicts itself.
        """
        file = checks.path(path, "The file")
        return cls._rebuild(file, *read_states(file, cls.kind, verify=checks.flag(verify, "verify=")))

    @classmethod
    def _rebuild(cls, file: File, states: tuple[ContactSolution, ...], notes: Mapping[str, Any]) -> Self:
        """Return the path of what was read; `InputError` if it contradicts itself."""
        with usable(file, "its numbers are wrong"):
            return cls._restore(states, notes)

    @property
    def _saved_states(self) -> tuple[ContactSolution, ...]:
        """The states in a file, from the first on."""
        return self.states

    def _note_rest(self) -> dict[str, Any]:
        """Return what a file holds beside the states, as plain data."""
        return {}

    @classmethod
    @abc.abstractmethod
    def _restore(cls, states: tuple[ContactSolution, ...], notes: Mapping[str, Any]) -> Self:
        """Return the path of states in a file and what `_note_rest` returned."""

    def plot(self, *, axes: Any = None, dark: bool = False) -> Any:
        """Draw the curve of the path (extra ``plot``); see `ContactSolution.plot`."""
        return find_view(self.view)(self, axes, dark)

    def animate(self, path: str | os.PathLike[str], *, dark: bool = False) -> None:
        """Write a moving picture of the pressure, a state after the other, to one file ``.gif`` (extra ``plot``).

        Its colours mean the same pressures in all states. The file is written completely or not at all.
        """
        find_view("animation")(self, checks.path(path, "The animation"), checks.flag(dark, "dark="))


def march(
    loads: Iterable[T],
    follow: Callable[[Sequence[ContactSolution], T], ContactSolution],
    first: ContactSolution | None = None,
) -> Iterator[ContactSolution]:
    """Yield a state for each load in turn, after a first one if it is given; each is found from the two before."""
    before: Sequence[ContactSolution] = []
    if first is not None:
        before = [first]
        yield first
    for load in loads:
        before = [*before[-1:], follow(before, load)]
        yield before[-1]
