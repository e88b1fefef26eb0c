"""The result of a study: its records as a table, as arrays over its axes, and as a figure."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any, final, overload

import attrs
import numpy as np

from roughcontact._base.arrays import RealArray
from roughcontact._base.checks import flag, item_of
from roughcontact._base.registry import find_view
from roughcontact._base.tables import Table, TableResult, make_dataset
from roughcontact._base.units import Estimate, counted
from roughcontact._parts.grid import FIRST_LOADING, Load
from roughcontact._solve.problem import FrictionalPath, LoadPath, read_frictional_path, read_load_path
from roughcontact._solve.solution import ContactSolution
from roughcontact._work.studies.chain import solve_again
from roughcontact._work.studies.loading import judge_by
from roughcontact._work.studies.record import (
    COUNT_COLUMNS,
    PASSED_UNITS,
    PATH_UNITS,
    Record,
    read_solution,
    solution_path,
)
from roughcontact._work.studies.tasks import Chains
from roughcontact.errors import InputError

_UNITS = {
    "force": "N",
    "mean_pressure": "Pa",
    "approach": "m",
    "p_max": "Pa",
    "saturated_area": "m2",
    "seconds": "s",
    "peak_pressure": "Pa",
    "peak_pressure_uncertainty": "Pa",
}
_NO_AREA = (np.nan, np.nan)
_NO_NUMBER = (np.nan, "")
# Number of a contact that remembers how far it was flattened.
_FLATTENED = "flattened_volume"


@attrs.frozen
class StudyNames:
    """The columns of a study that a figure shows: see `StudyResult.plot`; `spread` has the standard deviation of y."""

    x: str
    y: str
    spread: str
    color: str = ""
    over: str = ""


@final
class SolvedAgain:
    """What was found at the loads of a study, solved again: the loads of the last problem and seed are kept.

    Parameters
    ----------
    chains
        The problems and loads of the study.
    """

    def __init__(self, chains: Chains) -> None:
        self._chains = chains
        self._last: dict[str, Any] = {}

    def find(self, record: Record) -> Any:
        """Return what was found at the load of a record; `InputError` if the study does not have it any more."""
        if record.key not in self._last:
            self._last = {}
            self._last = solve_again(self._chains.find(record), record.key)
        found = self._last[record.key]
        if isinstance(found, Exception):
            raise found
        return found


@attrs.frozen(eq=False, kw_only=True)
class StudyResult(TableResult):
    """All records of a study, in its order: iterable, with `len` and ``[]``.

    Attributes
    ----------
    folder
        The folder of the solutions.
    records
        One for each problem, seed and load.
    computed
        How many of them were solved now, and not found in the folder.
    """

    folder: Path
    records: tuple[Record, ...]
    computed: int
    _again: SolvedAgain | None = attrs.field(default=None, repr=False)

    def __iter__(self) -> Iterator[Record]:
        return iter(self.records)

    def __len__(self) -> int:
        return len(self.records)

    @overload
    def __getitem__(self, index: int) -> Record: ...

    @overload
    def __getitem__(self, index: slice) -> tuple[Record, ...]: ...

    def __getitem__(self, index: int | slice) -> Record | tuple[Record, ...]:
        return item_of(self.records, index, "The index of a record")

    @property
    def failed(self) -> tuple[Record, ...]:
        """The records without a certified solution, or without an area that was asked for: their messages say why."""
        return tuple(record for record in self.records if record.message or not record.success)

    def solution(self, record: Record) -> ContactSolution:
        """Return the solution of a record, from its file or solved again; `InputError` if there is none.

        Of a path it is the state at its end. What has no file is solved again together with the other
        loads of its problem and seed, to the same bits.
        """
        state: ContactSolution = self.path(record)[-1] if record.has_path else self._find(record, read_solution)
        return judge_by(record.uncertainty, state)

    def path(self, record: Record) -> FrictionalPath | LoadPath:
        """Return the path of a record, from its file or solved again; `InputError` if there is none."""
        if not record.has_path:
            raise InputError(
                "This record has no path: a study with friction= and tangential_force=, or time= or sliding=, has some."
            )
        path: FrictionalPath | LoadPath = self._find(record, _read_frictional if record.has_friction else _read_passed)
        return path

    def _find(self, record: Record, read: Callable[[Path, str], Any]) -> Any:
        is_kept = solution_path(self.folder, record.key).exists()
        if is_kept or self._again is None or not record.has_solution:
            return read(self.folder, record.key)
        return self._again.find(record)

    def plot(
        self,
        x: str = "load",
        y: str = "area",
        *,
        color: str | None = None,
        over: str | None = None,
        axes: Any = None,
        dark: bool = False,
    ) -> Any:
        """Draw one column over another one (extra ``plot``), with a band of two standard deviations.

        Parameters
        ----------
        x, y
            Columns of `to_pandas`; ``"area"`` is that of the first estimator. Units are chosen.
        color
            A column, of whose values each has a curve.
        over
            An axis, such as ``"seed"``: drawn are the mean and the scatter over it, in place of the uncertainty.
        axes, dark
            As for `ContactSolution.plot`.

        Returns
        -------
        matplotlib.axes.Axes
            The axes.

        Raises
        ------
        InputError
            If there is no such column, or several solves have the same place on a curve.

        Examples
        --------
        >>> import roughcontact as rc
        >>> def make(seed: int, hurst: float) -> rc.ContactProblem:
        ...     rough = rc.SelfAffineSurface(hurst=hurst, rms_slope=0.1, shortest=8e-6, longest=64e-6, seed=seed)
        ...     body = rc.Body(rough, rc.Elastic(young=210e9, poisson=0.3))
        ...     return rc.ContactProblem(body, grid=rc.Grid((32, 32), 64e-6), boundary="periodic")
        >>> study = rc.Study(make, seed=[1, 2], hurst=[0.5, 0.8], pressure=[50e6, 100e6])
        >>> from tempfile import TemporaryDirectory
        >>> with TemporaryDirectory() as folder:
        ...     axes = study.run(folder).plot(color="hurst", over="seed")
        >>> axes.get_xlabel(), axes.get_ylabel()
        ('load, MPa', 'area blend, µm²')
        """
        table = self.table()
        estimated = [name for name in table.columns if name.startswith("area ")]
        y = estimated[0] if y == "area" and estimated else y
        for name in (x, y, color, over):
            if name is not None and name not in table.columns:
                raise InputError.unknown("column", name, table.columns)
        near = (y.replace("area ", "uncertainty ", 1), f"{y}_uncertainty")
        spread = next((name for name in near if name != y and name in table.columns), "")
        names = StudyNames(x, y, spread, color or "", over or "")
        return find_view("study")(table, names, axes, flag(dark, "dark="))

    def table(self) -> Table:
        """Return a row for each solve; see `roughcontact.typing.Table`.

        Its columns are the axes of the study, or ``problem`` and ``seed``, then those of a `Record`: ``load``,
        ``status``, ``mean_pressure``, ``approach``, ``area blend``, ``uncertainty blend`` and so on. What is missing is
        NaN. ``warnings`` is a text, empty where there are none.
        """
        columns = self._columns
        known = {**_UNITS, **PATH_UNITS, **PASSED_UNITS, **self._law_units}
        units = {name: known[name] for name in columns if name in known}
        units |= {name: "m2" for name in columns if name.startswith(("area ", "uncertainty "))}
        for name, unit in self._answer_units.items():
            units |= {name: unit, f"{name}_uncertainty": unit}
        return Table(columns, units | {"load": self._load_unit})

    def to_xarray(self) -> Any:
        """Return an `xarray.Dataset` over the axes of the study and the load (extra ``store``).

        The dimensions are the axes, or ``problem`` and ``seed``, then ``load``; ``area`` and ``area_uncertainty``
        have the dimension ``estimator`` too if there are several. What is missing is NaN, and its status
        and warnings are empty.
        """
        places = self._places
        positions = [{value: position for position, value in enumerate(values)} for values in places.values()]
        index = [
            tuple(known[_place(record, name)] for name, known in zip(places, positions, strict=True))
            for record in self.records
        ]
        rows = [record.row() for record in self.records]
        estimators = list(dict.fromkeys(name for record in self.records for name in record.areas))

        def spread(values: Iterable[Any], missing: object, kind: type) -> RealArray:
            filled: RealArray = np.full([len(known) for known in positions], missing, dtype=kind)
            for where, value in zip(index, values, strict=True):
                filled[where] = value
            return filled

        answers = {
            column: unit for name, unit in self._answer_units.items() for column in (name, f"{name}_uncertainty")
        }
        stated = {name for record in self.records for name in record.list_path_figures()}
        of_paths = {name: unit for name, unit in {**PATH_UNITS, **PASSED_UNITS}.items() if name in stated}
        variables: dict[str, Any] = {
            name: (tuple(places), spread((row.get(name, np.nan) for row in rows), np.nan, float), {"units": unit})
            for name, unit in {
                **_UNITS,
                **of_paths,
                **self._law_units,
                **answers,
                **dict.fromkeys(COUNT_COLUMNS, ""),
            }.items()
        }
        for name in ("status", "warnings"):
            variables[name] = (tuple(places), spread((row[name] for row in rows), "", object).astype(str))
        for part, name in enumerate(("area", "area_uncertainty")):
            values = [
                spread((one.areas.get(estimator, _NO_AREA)[part] for one in self), np.nan, float)
                for estimator in estimators
            ]
            variables[name] = (("estimator", *places), values or np.empty((0, *map(len, positions))), {"units": "m2"})
        coordinates: dict[str, Any] = {name: (name, values) for name, values in places.items()}
        coordinates["load"] = ("load", places["load"], {"units": self._load_unit})
        dataset = make_dataset(variables, {**coordinates, "estimator": estimators}, {"folder": str(self.folder)})
        return dataset.squeeze("estimator") if len(estimators) == 1 else dataset

    @property
    def _load_unit(self) -> str:
        units = {Load(record.control, record.load).unit for record in self.records}
        return units.pop() if len(units) == 1 else ""

    @property
    def _places(self) -> dict[str, list[Any]]:
        """The values on each axis, in the order in which they first occur."""
        axes = list(dict.fromkeys(name for record in self.records for name in record.parameters))
        if not axes:
            seeds = any(record.seed is not None for record in self.records)
            axes = ["problem", *["seed"][:seeds]]
        return {name: list(dict.fromkeys(_place(one, name) for one in self.records)) for name in (*axes, "load")}

    @cached_property
    def _answer_units(self) -> dict[str, str]:
        """The unit of each number of the responses, by its column."""
        return {name: one.unit for record in self.records for name, one in record.estimates.items()}

    @cached_property
    def _law_units(self) -> dict[str, str]:
        """The unit of each number of the laws, by its column."""
        return {name: unit for record in self.records for name, (_, unit) in record.numbers.items()}

    @property
    def _columns(self) -> dict[str, list[Any]]:
        rows = [record.row() for record in self.records]
        names = dict.fromkeys(name for row in rows for name in row)
        return {name: [row.get(name) for row in rows] for name in names}

    def __repr__(self) -> str:
        return f"<StudyResult {self._summary}>"

    def short_table(self) -> Table:
        """Return a row for each solve for people: the axes, the load, and the answers with their uncertainties."""
        rows = self.records
        columns: dict[str, list[Any]] = {name: [_place(record, name) for record in rows] for name in self._places}
        if not all(record.success for record in rows):
            columns["status"] = [record.status for record in rows]
        for name in dict.fromkeys(name for record in rows for name in record.areas):
            pairs = [record.areas.get(name, _NO_AREA) for record in rows]
            columns[f"area {name}"] = [Estimate(area, uncertainty, "m2") for area, uncertainty in pairs]
        columns["maximum pressure"] = [
            Estimate(record.peak_pressure, record.peak_pressure_uncertainty, "Pa") for record in rows
        ]
        if any(record.has_friction for record in rows):
            lost = [(one.dissipated, one.dissipated_uncertainty) for one in rows]
            stick = [(one.stick_area, one.stick_area_uncertainty) for one in rows]
            columns["energy lost"] = [_estimate(*pair, "J") for pair in lost]
            columns["area that sticks"] = [_estimate(*pair, "m2") for pair in stick]
        units = {"load": self._load_unit, "mean pressure": "Pa", "approach": "m"}
        for name, unit in self._law_units.items():
            if (of := name.removesuffix("_uncertainty")) != name and of in self._law_units:
                continue
            words = name.replace("_", " ")
            spread = f"{name}_uncertainty"
            values, spreads = ([one.numbers.get(key, _NO_NUMBER)[0] for one in rows] for key in (name, spread))
            if spread in self._law_units:
                columns[words] = [Estimate(*pair, unit) for pair in zip(values, spreads, strict=True)]
            else:
                columns[words] = values
                units |= {words: unit}
        for name in self._answer_units:
            columns[name.replace("_", " ")] = [record.estimates.get(name) for record in rows]
        given = {record.control for record in rows}
        if given != {"pressure"}:
            columns["mean pressure"] = [record.mean_pressure for record in rows]
        if given != {"approach"}:
            columns["approach"] = [record.approach for record in rows]
        if any(record.doubtful for record in rows):
            columns["doubtful"] = ["yes" if record.doubtful else "" for record in rows]
        return Table(columns, units)

    # Hooks of TableResult, as _list_notes.
    def _list_head(self) -> Sequence[str]:
        return [self._summary]

    @property
    def _keys(self) -> int:
        return len(self._places)

    def _list_notes(self) -> Sequence[str]:
        forgets = any(record.saturated > 0.0 and _FLATTENED not in record.numbers for record in self.records)
        return [FIRST_LOADING] if forgets else []

    @property
    def _summary(self) -> str:
        counts = {
            "a certified solution": sum(not record.success for record in self.records),
            "all areas and answers": sum(record.success for record in self.failed),
        }
        bad = "".join(f", {count} without {what}" for what, count in counts.items() if count)
        if doubtful := sum(record.doubtful for record in self.records):
            bad += f", {doubtful} doubtful (see their warnings)"
        return f"{counted(len(self), 'solve')}, {self.computed} of them now{bad}, in {self.folder}"


def _read_frictional(folder: Path, key: str) -> FrictionalPath:
    return read_frictional_path(solution_path(folder, key), verify=False, key=key)


def _read_passed(folder: Path, key: str) -> LoadPath:
    return read_load_path(solution_path(folder, key), key)


def _estimate(value: float | None, uncertainty: float | None, unit: str) -> Estimate | None:
    return None if value is None or uncertainty is None else Estimate(value, uncertainty, unit)


def _place(record: Record, name: str) -> Any:
    return record.parameters[name] if name in record.parameters else getattr(record, name)
