"""What a study keeps of each solve."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

import attrs

from roughcontact._base.units import Estimate, printable
from roughcontact._solve.solution import DEFAULT_AREA, ContactSolution, Status, read
from roughcontact._work.studies.answers import Answer, read_answers
from roughcontact.errors import InputError

# Fields of a record that the file of its solution states under the same name.
_STATED_FIGURES = ("status", "force", "mean_pressure", "approach", "iterations", "convolutions", "seconds")
# Columns of a table that have other names than the fields, as in the table of a sweep.
_COLUMN_NAMES = {"saturated": "saturated_area"}
PATH_UNITS = {
    "dissipated": "J",
    "dissipated_uncertainty": "J",
    "stick_area": "m2",
    "stick_area_uncertainty": "m2",
}
PASSED_UNITS = {"time": "s", "sliding": "m"}
COUNT_COLUMNS = ("iterations", "convolutions")
# The place of a record in its study: problem, seed, kind of load, load.
Place: TypeAlias = tuple[str, int | None, str, float]


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


def _numbers(value: Mapping[str, tuple[float, str]]) -> dict[str, tuple[float, str]]:
    return {printable(name): (float(number), printable(unit)) for name, (number, unit) in value.items()}


@attrs.frozen(kw_only=True)
class Record:
    """One solve of a study.

    Attributes
    ----------
    problem, seed
        The name of the problem, and the seed; None without seeds.
    control, load
        The kind of load (pressure, Pa; force, N; approach, m), and its value; of a path whose loads are stated by
        factors the one that they multiply.
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
    time, sliding
        Time, s, and sliding distance, m, at the end of a path on which they pass; else None. The other figures are
        those of the contact there.
    numbers
        What the laws of the problem state of the contact, such as a worn volume: values and units by name.
    answers
        The numbers of the responses of the study, by their registered names.
    uncertainty
        What the uncertainties were found from; see `Study`.
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
    time: float | None = attrs.field(default=None, converter=_optional_float)
    sliding: float | None = attrs.field(default=None, converter=_optional_float)
    numbers: Mapping[str, tuple[float, str]] = attrs.field(factory=dict, converter=_numbers)
    answers: Mapping[str, Answer] = attrs.field(factory=dict, converter=read_answers)
    uncertainty: str = attrs.field(default="auto", converter=printable)

    def agrees_with(self, figures: Mapping[str, Any]) -> bool:
        """Return whether it states the figures of its file; the areas of other estimators are not in the file."""
        names = {"p_max": "maximum_pressure", "saturated": "saturated_area"}
        stated = (*_STATED_FIGURES, *names, *self.list_path_figures())
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
    def has_solution(self) -> bool:
        """Whether a state was found, certified or not."""
        return not math.isnan(self.force)

    @property
    def place(self) -> Place:
        """Where it is in its study."""
        return self.problem, self.seed, self.control, self.load

    @property
    def has_path(self) -> bool:
        """Whether a path was followed under this load."""
        return bool(self.list_path_figures())

    @property
    def has_friction(self) -> bool:
        """Whether this path was one with friction."""
        return self.dissipated is not None

    def list_path_figures(self) -> tuple[str, ...]:
        """Return the fields that say what a path led to."""
        passed = tuple(name for name in PASSED_UNITS if getattr(self, name) is not None)
        return tuple(PATH_UNITS) if self.has_friction else (*passed, "numbers") if passed else ()

    def row(self) -> dict[str, Any]:
        """Return the figures by name, one for each column of a table; the parameters come first."""
        figures = attrs.asdict(self, recurse=False)
        areas = figures.pop("areas")
        parameters = figures.pop("parameters")
        del figures["answers"], figures["uncertainty"]
        figures = {_COLUMN_NAMES.get(name, name): value for name, value in figures.items()}
        figures["warnings"] = " ".join(self.warnings)
        absent = {*PATH_UNITS, *PASSED_UNITS} - {*self.list_path_figures()}
        numbers = figures.pop("numbers")
        figures = {name: value for name, value in figures.items() if name not in absent}
        figures |= {name: value for name, (value, _) in numbers.items()}
        if parameters:
            del figures["seed"]
            figures = {**parameters, **figures}
        for name, (value, uncertainty) in areas.items():
            figures[f"area {name}"] = value
            figures[f"uncertainty {name}"] = uncertainty
        for name, one in self.estimates.items():
            figures[name] = one.value
            figures[f"{name}_uncertainty"] = one.uncertainty
        return figures

    @property
    def estimates(self) -> dict[str, Estimate]:
        """The numbers of the responses by the names of their columns, such as ``"stiffness"``."""
        return {
            f"{name} {part}".strip(): Estimate(*number)
            for name, answer in self.answers.items()
            for part, number in answer.numbers.items()
        }


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
