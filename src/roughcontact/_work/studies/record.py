"""The records of a study, the file that lists them, and the result as a table and as arrays over its axes."""

from __future__ import annotations

import hashlib
import json
import math
import os
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, overload

import attrs
import numpy as np

from roughcontact._base.archive import replacing
from roughcontact._base.archive.plain import describe, rebuild
from roughcontact._base.arrays import RealArray
from roughcontact._base.checks import flag, item_of
from roughcontact._base.tables import Table, make_dataset
from roughcontact._base.units import Estimate, counted, printable
from roughcontact._parts.grid import FIRST_LOADING
from roughcontact._solve.problem import FrictionalPath, load_path
from roughcontact._solve.solution import DEFAULT_AREA, ContactSolution, Status, read
from roughcontact.errors import InputError

_FORMAT = "roughcontact study, format 1"
# Fields of a record that the file of its solution states under the same name.
_STATED_FIGURES = ("status", "force", "mean_pressure", "approach", "iterations", "convolutions", "seconds")
# Columns of a table that have other names than the fields, as in the table of a sweep.
_COLUMN_NAMES = {"saturated": "saturated_area"}
# Most characters of the list of records, and of one record (about 500 and its warnings); the end of the list.
_MAX_INDEX_CHARACTERS = 2**28
_MAX_RECORD_CHARACTERS = 2**16
_INDEX_END = "\n]}\n"
_LOAD_UNITS = {"pressure": "Pa", "force": "N", "approach": "m"}
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
_FRICTION_UNITS = {
    "dissipated": "J",
    "dissipated_uncertainty": "J",
    "stick_area": "m2",
    "stick_area_uncertainty": "m2",
}
_COUNT_COLUMNS = ("iterations", "convolutions")
_NO_AREA = (np.nan, np.nan)
# Solves whose answers are printed: the first and the last ones of a longer study.
_MAX_PRINTED_ROWS = 40


def _key(value: str) -> str:
    if re.fullmatch("[0-9a-f]{32}", value) is None:
        raise InputError.about("The key of a record", value, "32 hexadecimal digits")
    return value


def _optional_float(value: float | None) -> float | None:
    return None if value is None else float(value)


def _warnings(value: Sequence[str]) -> tuple[str, ...]:
    return tuple(map(printable, value))


def _areas(value: Mapping[str, tuple[float, float]]) -> dict[str, tuple[float, float]]:
    return {name: (float(area), float(uncertainty)) for name, (area, uncertainty) in value.items()}


@attrs.frozen(kw_only=True)
class Record:
    """One solve of a study.

    Attributes
    ----------
    problem, seed
        The name of the problem, and the seed; None without seeds.
    control, load
        The kind of load (pressure, Pa; force, N; approach, m), and its value.
    key
        The name of its file without ending, made from the problem, the load and the versions of the packages.
    status
        The name of the status; ``"REFUSED"`` where the problem or the load cannot be solved at all, ``"FAILED"``
        where an exception ended the solve.
    message
        Why it was not solved, or which areas are missing and why.
    force, mean_pressure, approach, saturated
        N; Pa; m; saturated area, m2, ``saturated_area`` in tables.
    p_max
        Maximum pressure of a cell, Pa.
    peak_pressure, peak_pressure_uncertainty
        Maximum pressure between the cells and its standard deviation, Pa; see `ContactSolution.peak_pressure`.
    areas
        Area and standard deviation, m2, by the name of the estimator.
    iterations, convolutions, seconds
        Cost of the solve.
    warnings
        All that ``print(solution)`` warns of, in sentences.
    doubtful
        Whether they concern the solution itself, as `ContactSolution.warnings`, not only its area or maximum pressure.
    parameters
        The value on each axis of the study; empty without axes.
    dissipated, dissipated_uncertainty
        Energy lost by friction along the path of this load, J; None without friction. The other figures are those of
        the contact at the end of the path.
    stick_area, stick_area_uncertainty
        Area that sticks at the end of the path, m2.
    """

    problem: str = attrs.field(converter=str)
    seed: int | None
    control: str = attrs.field(converter=str)
    load: float = attrs.field(converter=float)
    key: str = attrs.field(converter=_key)
    status: str = attrs.field(converter=printable)
    message: str = attrs.field(default="", converter=printable)
    force: float = attrs.field(default=math.nan, converter=float)
    mean_pressure: float = attrs.field(default=math.nan, converter=float)
    approach: float = attrs.field(default=math.nan, converter=float)
    p_max: float = attrs.field(default=math.nan, converter=float)
    saturated: float = attrs.field(default=math.nan, converter=float)
    areas: Mapping[str, tuple[float, float]] = attrs.field(factory=dict, converter=_areas)
    iterations: int = attrs.field(default=0, converter=int)
    convolutions: int = attrs.field(default=0, converter=int)
    seconds: float = attrs.field(default=math.nan, converter=float)
    peak_pressure: float = attrs.field(default=math.nan, converter=float)
    peak_pressure_uncertainty: float = attrs.field(default=math.nan, converter=float)
    warnings: tuple[str, ...] = attrs.field(default=(), converter=_warnings)
    doubtful: bool = attrs.field(default=False, converter=bool)
    parameters: Mapping[str, Any] = attrs.field(factory=dict, converter=dict)
    dissipated: float | None = attrs.field(default=None, converter=_optional_float)
    dissipated_uncertainty: float | None = attrs.field(default=None, converter=_optional_float)
    stick_area: float | None = attrs.field(default=None, converter=_optional_float)
    stick_area_uncertainty: float | None = attrs.field(default=None, converter=_optional_float)

    def agrees_with(self, figures: Mapping[str, Any]) -> bool:
        """Return whether it states the figures of its file; the areas of other estimators are not in the file."""
        names = {"p_max": "maximum_pressure", "saturated": "saturated_area"}
        stated = (*_STATED_FIGURES, *names, *(_FRICTION_UNITS if self.has_friction else ()))
        blend = self.areas.get(DEFAULT_AREA, (figures["area"], figures["area_uncertainty"]))
        return all(getattr(self, name) == figures[names.get(name, name)] for name in stated) and blend == (
            figures["area"],
            figures["area_uncertainty"],
        )

    @property
    def success(self) -> bool:
        """Whether the solution is certified."""
        return self.status in Status.__members__ and Status[self.status].success

    @property
    def has_friction(self) -> bool:
        """Whether a path with friction was followed."""
        return self.dissipated is not None

    def row(self) -> dict[str, Any]:
        """Return the figures by name, one for each column of a table; the parameters come first."""
        figures = attrs.asdict(self, recurse=False)
        areas = figures.pop("areas")
        parameters = figures.pop("parameters")
        figures = {_COLUMN_NAMES.get(name, name): value for name, value in figures.items()}
        figures["warnings"] = " ".join(self.warnings)
        if not self.has_friction:
            figures = {name: value for name, value in figures.items() if name not in _FRICTION_UNITS}
        if parameters:
            del figures["seed"]
            figures = {**parameters, **figures}
        for name, (value, uncertainty) in areas.items():
            figures[f"area {name}"] = value
            figures[f"uncertainty {name}"] = uncertainty
        return figures


def solution_path(folder: Path, key: str) -> Path:
    """Return the file of the solution with a key; `InputError` if it is a symbolic link, which leads elsewhere."""
    path = folder / f"{key}.npz"
    if path.is_symlink():
        raise InputError(f"The file {path.name} is a symbolic link, which a study does not follow.")
    return path


def read_solution(folder: Path, key: str) -> ContactSolution:
    """Return the solution with a key after a check of its digests and its key; residuals are not recomputed.

    Raises
    ------
    InputError
        If there is no such file, or it is a link, damaged or of another solution.
    """
    return ContactSolution(**read(solution_path(folder, key), key))


def read_index(path: Path) -> dict[str, Record]:
    """Return the records of a file of `write_index` by key; none if there is no such file, or it is damaged."""
    try:
        if path.is_symlink() or not path.is_file() or path.stat().st_size > _MAX_INDEX_CHARACTERS:
            return {}
        text = path.read_text(encoding="utf-8")
        lines = text.partition("\n")[2].removesuffix(_INDEX_END)
        # Checked before any of the content is used.
        if _sealed(lines) != text:
            return {}
        texts = lines.split(",\n") if lines else []
        if max(map(len, texts), default=0) > _MAX_RECORD_CHARACTERS:
            return {}
        records = [Record(**rebuild(json.loads(one), {})) for one in texts]
    # The list only saves time: it is made again if it is damaged in any way.
    except Exception:
        return {}
    return {record.key: record for record in records} if _index(records) == lines else {}


def write_index(path: Path, records: Sequence[Record]) -> None:
    """Write the records with a checksum, completely or not at all."""
    with replacing(path) as partial:
        partial.write_text(_sealed(_index(records)), encoding="utf-8")


def _stated(record: Record) -> dict[str, Any]:
    """Return the fields of a record, without those that it does not have, as in the lists of older versions."""
    absent = [] if record.parameters else ["parameters"]
    absent += [] if record.has_friction else list(_FRICTION_UNITS)
    return {name: value for name, value in attrs.asdict(record).items() if name not in absent}


def _index(records: Sequence[Record]) -> str:
    return ",\n".join(json.dumps(describe(_stated(record), {})) for record in records)


def _sealed(lines: str) -> str:
    """Return the text of the list of records, with the checksum of its lines."""
    digest = hashlib.sha256(lines.encode()).hexdigest()
    return f'{{"format": "{_FORMAT}", "sha256": "{digest}", "records": [\n{lines}{_INDEX_END}'


@attrs.frozen(eq=False, kw_only=True)
class StudyResult:
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
        """Return the solution of a record from its file; `InputError` if there is none, or it is damaged.

        Of a path with friction it is the contact at its end.
        """
        return self.path(record)[-1].contact if record.has_friction else read_solution(self.folder, record.key)

    def path(self, record: Record) -> FrictionalPath:
        """Return the path with friction of a record from its file; `InputError` if there is none, or it is damaged."""
        if not record.has_friction:
            raise InputError("This record has no path: a study with friction= and tangential_force= has some.")
        return load_path(solution_path(self.folder, record.key), verify=False, key=record.key)

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
        >>> axes = study.run("results").plot(color="hurst", over="seed")
        >>> axes.get_xlabel(), axes.get_ylabel()
        ('load, MPa', 'area blend, µm²')
        """
        from roughcontact.plotting import StudyNames, draw_study

        table = self._table
        estimated = [name for name in table.columns if name.startswith("area ")]
        y = estimated[0] if y == "area" and estimated else y
        for name in (x, y, color, over):
            if name is not None and name not in table.columns:
                raise InputError.unknown("column", name, table.columns)
        near = (y.replace("area ", "uncertainty ", 1), f"{y}_uncertainty")
        spread = next((name for name in near if name != y and name in table.columns), "")
        return draw_study(table, StudyNames(x, y, spread, color or "", over or ""), axes, flag(dark, "dark="))

    def to_csv(self, path: str | os.PathLike[str]) -> None:
        """Write the columns of `to_pandas` to a CSV file, completely or not at all.

        It has a row for each solve; the units are in the heading, as ``force [N]``.
        """
        self._table.to_csv(path)

    def to_pandas(self) -> Any:
        """Return a `pandas.DataFrame` with a row for each solve (extra ``table``).

        Its columns are the axes of the study, or ``problem`` and ``seed``, then those of a `Record`: ``load``,
        ``status``, ``mean_pressure``, ``approach``, ``area blend``, ``uncertainty blend`` and so on, in the units of
        ``frame.attrs["units"]``. What is missing is NaN. ``warnings`` is a text, empty where there are none.
        """
        return self._table.to_pandas()

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

        friction = _FRICTION_UNITS if any(record.has_friction for record in self.records) else {}
        variables: dict[str, Any] = {
            name: (tuple(places), spread((row.get(name, np.nan) for row in rows), np.nan, float), {"units": unit})
            for name, unit in {**_UNITS, **friction, **dict.fromkeys(_COUNT_COLUMNS, "")}.items()
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
        kinds = {record.control for record in self.records}
        return _LOAD_UNITS.get(kinds.pop(), "") if len(kinds) == 1 else ""

    @property
    def _places(self) -> dict[str, list[Any]]:
        """The values on each axis, in the order in which they first occur."""
        axes = list(dict.fromkeys(name for record in self.records for name in record.parameters))
        if not axes:
            seeds = any(record.seed is not None for record in self.records)
            axes = ["problem", *["seed"][:seeds]]
        return {name: list(dict.fromkeys(_place(one, name) for one in self.records)) for name in (*axes, "load")}

    @property
    def _columns(self) -> dict[str, list[Any]]:
        rows = [record.row() for record in self.records]
        names = dict.fromkeys(name for row in rows for name in row)
        return {name: [row.get(name) for row in rows] for name in names}

    @property
    def _table(self) -> Table:
        columns = self._columns
        known = {**_UNITS, **_FRICTION_UNITS}
        units = {name: known[name] for name in columns if name in known}
        units |= {name: "m2" for name in columns if name.startswith(("area ", "uncertainty "))}
        return Table(columns, units | {"load": self._load_unit})

    def __repr__(self) -> str:
        return f"<StudyResult {self._summary}>"

    def _repr_html_(self) -> str:
        return self._answers.to_html(self._summary, *self._notes)

    def __str__(self) -> str:
        answers = self._answers.to_text(keys=len(self._places), max_rows=_MAX_PRINTED_ROWS)
        return "\n".join([self._summary, "", answers, *self._notes])

    @property
    def _answers(self) -> Table:
        """The table for people: the axes, the load, and the answers with their uncertainties."""
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
        given = {record.control for record in rows}
        if given != {"pressure"}:
            columns["mean pressure"] = [record.mean_pressure for record in rows]
        if given != {"approach"}:
            columns["approach"] = [record.approach for record in rows]
        if any(record.doubtful for record in rows):
            columns["doubtful"] = ["yes" if record.doubtful else "" for record in rows]
        return Table(columns, {"load": self._load_unit, "mean pressure": "Pa", "approach": "m"})

    @property
    def _notes(self) -> list[str]:
        return [FIRST_LOADING] if any(record.saturated > 0.0 for record in self.records) else []

    @property
    def _summary(self) -> str:
        counts = {
            "a certified solution": sum(not record.success for record in self.records),
            "all areas": sum(record.success for record in self.failed),
        }
        bad = "".join(f", {count} without {what}" for what, count in counts.items() if count)
        if doubtful := sum(record.doubtful for record in self.records):
            bad += f", {doubtful} doubtful (see their warnings)"
        return f"{counted(len(self), 'solve')}, {self.computed} of them now{bad}, in {self.folder}"


def _estimate(value: float | None, uncertainty: float | None, unit: str) -> Estimate | None:
    return None if value is None or uncertainty is None else Estimate(value, uncertainty, unit)


def _place(record: Record, name: str) -> Any:
    return record.parameters[name] if name in record.parameters else getattr(record, name)
