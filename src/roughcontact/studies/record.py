"""What a study has found."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import attrs

from roughcontact.archive import replacing
from roughcontact.solution import ContactSolution, Status


@attrs.frozen(kw_only=True)
class Record:
    """One solve of a study.

    Attributes
    ----------
    problem, seed
        The name of the problem, and the seed; None without seeds.
    control, load
        Which load was given (pressure, Pa; force, N; approach, m), and its value.
    key
        The name of its file, without ending, made from the content of the problem, the load and the
        versions.
    status
        The name of the status; ``"REFUSED"`` where the problem or the load cannot be solved at all.
    message
        Why, where it was not solved.
    force, mean_pressure, approach, p_max, saturated
        N; Pa; m; greatest pressure, Pa; saturated area, m2.
    areas
        Area and standard deviation, m2, by the name of the estimator.
    iterations, convolutions, seconds
        What the solve took.
    """

    problem: str
    seed: int | None
    control: str
    load: float
    key: str
    status: str
    message: str = ""
    force: float = float("nan")
    mean_pressure: float = float("nan")
    approach: float = float("nan")
    p_max: float = float("nan")
    saturated: float = float("nan")
    areas: Mapping[str, tuple[float, float]] = attrs.Factory(dict)
    iterations: int = 0
    convolutions: int = 0
    seconds: float = float("nan")

    @property
    def success(self) -> bool:
        """Whether the solution is certified."""
        return self.status in Status.__members__ and Status[self.status].success

    def row(self) -> dict[str, Any]:
        """Return the figures by name, one for each column of a table."""
        figures = attrs.asdict(self, recurse=False)
        areas = figures.pop("areas")
        for name, (value, uncertainty) in areas.items():
            figures[f"area {name}"], figures[f"uncertainty {name}"] = value, uncertainty
        return figures


@attrs.frozen(eq=False, kw_only=True)
class StudyResult:
    """All records of a study, in its order.

    Attributes
    ----------
    folder
        Where the solutions lie.
    records
        One for each problem, seed and load.
    computed
        How many of them were solved now, and not found in the folder.
    """

    folder: Path
    records: tuple[Record, ...]
    computed: int

    @property
    def failed(self) -> tuple[Record, ...]:
        """The records without a certified solution."""
        return tuple(record for record in self.records if not record.success)

    def solution(self, record: Record) -> ContactSolution:
        """Return the solution of a record from its file.

        Raises
        ------
        InputError
            If there is none, or it is damaged.
        """
        return ContactSolution.load(self.folder / f"{record.key}.npz")

    def to_csv(self, path: str | Path) -> None:
        """Write the records as a table, which appears whole or not at all."""
        rows = [record.row() for record in self.records]
        columns = list(dict.fromkeys(name for row in rows for name in row))
        with replacing(path) as partial, partial.open("w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, columns)
            writer.writeheader()
            writer.writerows(rows)

    def __str__(self) -> str:
        bad = f", {len(self.failed)} without a certified solution" if self.failed else ""
        return f"{len(self.records)} solves, {self.computed} of them now{bad}, in {self.folder}"
