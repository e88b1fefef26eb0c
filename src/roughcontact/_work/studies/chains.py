"""All chains of a study, each made when it is taken."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import attrs

from roughcontact._parts.load import Load
from roughcontact._solve.problem import ContactProblem
from roughcontact._work.studies.axes import BuiltProblems
from roughcontact._work.studies.chain import Chain, Unbuilt
from roughcontact._work.studies.record import Record
from roughcontact.errors import InputError


@attrs.frozen(eq=False)
class Chains(Sequence[Chain | Unbuilt]):
    """The chains of a study: a problem of a function is built each time that its chain is taken, and not kept.

    Attributes
    ----------
    problems, seeds, loads, areas
        Those of the study.
    folder
        The folder of its solutions.
    known
        Earlier records, by key.
    """

    problems: Mapping[str, ContactProblem]
    seeds: tuple[int, ...]
    loads: tuple[Load, ...]
    areas: tuple[str, ...]
    folder: Path
    known: Mapping[str, Record]
    _places: list[tuple[str, int | None]] = attrs.field(init=False)

    @_places.default
    def _list_places(self) -> list[tuple[str, int | None]]:
        return [(name, seed) for name in self.problems for seed in self.seeds or (None,)]

    def __len__(self) -> int:
        return len(self._places)

    def __getitem__(self, position: Any) -> Any:
        name, seed = self._places[position]
        parameters = self.problems.parameters(name) if isinstance(self.problems, BuiltProblems) else {}
        place: dict[str, Any] = {"name": name, "seed": seed, "parameters": parameters, "loads": self.loads}
        try:
            problem = self.problems[name]
        except InputError as error:
            return Unbuilt(**place, message=str(error))
        chain = Chain(**place, problem=problem, areas=self.areas, folder=self.folder)
        if not self.known:
            return chain
        # A worker needs the records of its own chain only.
        known = {key: self.known[key] for key in chain.solution_keys() if key in self.known}
        return attrs.evolve(chain, known=known)
