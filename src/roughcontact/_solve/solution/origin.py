"""Origin of a solution: its problem, load and programs, and the accuracy that was requested."""

from __future__ import annotations

import functools
import math
import platform
from collections.abc import Mapping, Sequence
from functools import cached_property
from importlib.metadata import version
from typing import Any

import attrs
import numpy as np

from roughcontact._base.archive.plain import (
    Described,
    describe,
    key_of,
    key_of_description,
    missing_classes,
    programs,
    programs_of,
    public_class,
    rebuild_fields,
)
from roughcontact._base.arrays import Mask, RealArray, as_shape
from roughcontact._base.units import ShownAsPrinted, percent
from roughcontact._parts.grid import Grid
from roughcontact._parts.materials import Material
from roughcontact._parts.surfaces import HeightMap, SelfAffineSurface, Surface, find_maps
from roughcontact.errors import InputError

_PROBLEM_PART = {"kind": "part", "name": "roughcontact:ContactProblem"}
# Admissible heights and waves of the surfaces of a problem from a file, plus a multiple of its cells.
_ALLOWED_NUMBERS = 2**20
_ALLOWED_NUMBERS_PER_CELL = 32


@attrs.frozen
class Trial(ShownAsPrinted):
    """One grid that was solved to reach an accuracy.

    Attributes
    ----------
    shape
        Cells of the grid.
    area, area_uncertainty
        Real contact area and its standard deviation, m2; nan if not requested.
    peak, peak_uncertainty
        Maximum pressure and its standard deviation, Pa; nan if not requested.
    convolutions, seconds
        Convolutions on this grid, and wall time, s.
    """

    shape: tuple[int, int] = attrs.field(converter=as_shape)
    area: float
    area_uncertainty: float
    peak: float
    peak_uncertainty: float
    convolutions: int
    seconds: float

    @property
    def spreads(self) -> tuple[float, float]:
        """Two standard deviations of area and maximum pressure over their values; nan if not requested."""
        pairs = (self.area, self.area_uncertainty), (self.peak, self.peak_uncertainty)
        area, peak = (2.0 * std / value if value != 0.0 else math.inf for value, std in pairs)
        return area, peak

    def __str__(self) -> str:
        spreads = " and ".join(percent(spread) for spread in self.spreads if not math.isnan(spread))
        return f"{self.shape[0]} x {self.shape[1]} ({spreads})"


@attrs.frozen
class Accuracy(ShownAsPrinted):
    """The accuracy that was requested, and its cost.

    Attributes
    ----------
    area_within, peak_within
        Admissible relative error of area and maximum pressure, with 95 %; None if not stated.
    tolerance
        The tolerance of the solver.
    estimator
        The area estimator; empty if no area was requested.
    trials
        The solved grids in order; the last one has the solution.
    shortfall
        Why the accuracy is not reached; empty if it is.
    """

    area_within: float | None
    peak_within: float | None
    tolerance: float
    estimator: str
    trials: tuple[Trial, ...]
    shortfall: str = ""

    @property
    def met(self) -> bool:
        """Whether two standard deviations are within the admissible errors."""
        return not self.shortfall

    @property
    def asked(self) -> str:
        """The requested accuracy in words."""
        pairs = ("area", self.area_within), ("maximum pressure", self.peak_within)
        return " and ".join(f"{name} within {100 * value:.3g} %" for name, value in pairs if value is not None)

    def explain(self) -> str:
        """Return sentences that say why the accuracy is not reached."""
        reason = f"{self.shortfall[:1].upper()}{self.shortfall[1:]}."
        return f"The {self.asked} is not reached, but {self.trials[-1]}, in two standard deviations. {reason}"

    def __str__(self) -> str:
        reached = "reached" if self.met else f"NOT reached: {self.shortfall}"
        estimator = f", estimator {self.estimator}" if self.estimator else ""
        seconds = sum(trial.seconds for trial in self.trials)
        return (
            f"{self.asked}, two standard deviations: {reached}\n"
            f"grids solved   {', '.join(map(str, self.trials))}, {seconds:.2g} s in all\n"
            f"tolerance      {self.tolerance:.1e}{estimator}"
        )


@attrs.frozen(eq=False)
class Origin:
    """What was solved: ``ContactProblem(**origin.problem).solve(**origin.load)`` does it again.

    Attributes
    ----------
    problem
        The arguments of the `ContactProblem`; `InputError` if it cannot be built, see `missing`.
    load
        The load, by the name of its argument.
    source
        The `ContactProblem` itself with its prepared convolution; None in a solution from a file or another process.
    versions
        The versions of the packages that solved it, by name.
    """

    _problem: Mapping[str, Any] | None
    load: Mapping[str, float]
    _saved: tuple[Described, Mapping[str, RealArray]] = attrs.field(default=(None, {}), kw_only=True, repr=False)
    source: Any = attrs.field(default=None, kw_only=True, repr=False)
    versions: Mapping[str, str] = attrs.field(kw_only=True)

    @versions.default
    def _find_versions(self) -> dict[str, str]:
        return versions(() if self.source is None else self.source.chosen)

    def __reduce__(self) -> tuple[Any, ...]:
        return _restore, (self._problem, self.load, self._saved, self.versions)

    @property
    def problem(self) -> Mapping[str, Any]:
        if self._problem is not None:
            return self._problem
        described, arrays = self._saved
        if self.missing:
            raise InputError(self.missing)
        if not isinstance(described, dict) or described | _PROBLEM_PART != described:
            raise InputError("What was solved must be described as a ContactProblem.")
        return rebuild_fields(described, arrays, (object,))[1]

    @cached_property
    def scene(self) -> Any:
        """The `ContactProblem`, built anew where there is no `source`; `InputError` if it cannot be built."""
        kind: Any = public_class("ContactProblem")
        return self.source or kind(**self.problem)

    @property
    def maps(self) -> tuple[HeightMap, ...]:
        """The height maps of the bodies; empty if the problem cannot be built."""
        try:
            surfaces = [self.problem[name].surface for name in ("body", "counterbody")]
        except InputError:
            return ()
        return tuple(found for surface in surfaces for found in find_maps(surface))

    @property
    def surfaces(self) -> tuple[Surface, ...]:
        """The surfaces of the bodies, sums as their members; empty if the problem cannot be built."""
        try:
            found = [self.problem[name].surface for name in ("body", "counterbody")]
        except InputError:
            return ()
        return tuple(one for surface in found for one in _list_members(surface))

    def find_uncertain(self, grid: Grid, shift: tuple[int, int]) -> Mask | None:
        """Return the cells that the tip of a stylus has not surely touched on one of the bodies; None without a tip.

        The counterbody is displaced by cells (x, y), periodically.
        """
        try:
            body, counterbody = (self.problem[name].uncertain(grid) for name in ("body", "counterbody"))
        except InputError:
            return None
        moved = None if counterbody is None else np.roll(counterbody, shift, axis=(0, 1))
        known = [mask for mask in (body, moved) if mask is not None]
        return np.logical_or.reduce(known) if known else None

    @property
    def missing(self) -> str:
        """A sentence with the classes to register before a loaded problem can be solved; empty if there are none."""
        return missing_classes(self._saved[0])

    @property
    def programs(self) -> list[str]:
        """The programs that define the parts of the problem, except this package."""
        return programs_of(self._problem)

    @property
    def materials(self) -> dict[str, Material]:
        """The materials by body; empty if they are not known."""
        try:
            return {name: self.problem[name].material for name in ("body", "counterbody")}
        except InputError:
            return {}

    def bound(self, grid: Grid) -> Mapping[str, Any]:
        """Return the arguments of the problem with which a solution on a grid is verified.

        `InputError` if it has another grid, or its heights take far more work than its cells: a file of some kilobytes
        could otherwise take all memory, or hours.
        """
        problem = self.problem
        bodies = [problem[name] for name in ("body", "counterbody") if name in problem]
        known = (problem.get("grid"), *(body.own_grid for body in bodies))
        own = next((found for found in known if found is not None), None)
        if own is None or not grid.matches(own):
            raise InputError(f"It is not a solution on the grid of its problem, {own}.")
        surfaces = [surface for body in bodies for surface in _list_surfaces(body.surface)]
        waves = sum(surface.count_waves(grid) for surface in surfaces if isinstance(surface, SelfAffineSurface))
        if waves + len(surfaces) * grid.cells > _ALLOWED_NUMBERS + _ALLOWED_NUMBERS_PER_CELL * grid.cells:
            raise InputError(
                f"The {len(surfaces)} surfaces of its problem have {waves} waves on {grid.cells} cells, too many "
                "for a file: ContactSolution.load(..., verify=False) takes its fields and residuals as they are."
            )
        return problem

    def describe(self, arrays: dict[str, RealArray]) -> Described:
        """Return the problem as plain data; see `roughcontact._base.archive.plain.describe`."""
        if self._problem is not None:
            return {**_PROBLEM_PART, "fields": {name: describe(part, arrays) for name, part in self._problem.items()}}
        arrays.update(self._saved[1])
        return self._saved[0]


def _list_members(surface: Surface) -> list[Surface]:
    """Return the surfaces without parts of which a surface is made."""
    parts = surface.parts
    return [found for part in parts for found in _list_members(part)] if parts else [surface]


def _list_surfaces(surface: Surface) -> list[Surface]:
    """Return a surface and its parts, with their parts."""
    return [surface, *(found for part in surface.parts for found in _list_surfaces(part))]


def _restore(
    problem: Mapping[str, Any] | None,
    load: Mapping[str, float],
    saved: tuple[Described, Mapping[str, RealArray]],
    made_by: Mapping[str, str],
) -> Origin:
    return Origin(problem, load, saved=saved, versions=made_by)


# Parsing the metadata of a package takes a millisecond, and a study needs it with each solve.
_version = functools.cache(version)


def versions(chosen: tuple[type, ...] = ()) -> dict[str, str]:
    """Return the versions that a result depends on, also those of the packages of parts that ``"auto"`` has chosen."""
    found = {name: _version(name) for name in ("roughcontact", "numpy", "scipy")}
    return {**found, **_find_programs(chosen), "python": platform.python_version()}


@functools.cache
def _find_programs(kinds: tuple[type, ...]) -> dict[str, str]:
    """Return the versions of the programs that define classes, by name, except this package."""
    named = (program.rpartition(" ") for program in programs(kinds))
    return {name: number for name, _, number in named}


def solution_key(
    problem_key: str,
    load: Mapping[str, float],
    made_by: Mapping[str, str] | None = None,
    earlier: Sequence[Mapping[str, float]] = (),
    chosen: tuple[type, ...] = (),
) -> str:
    """Return the key of a solution, from the key of its problem, its load and the versions, by default today's.

    Where a state depends on those before, `earlier` has their loads; `chosen` is as in `versions`.
    """
    numbers = versions(chosen) if made_by is None else made_by
    problem_key = key_of([problem_key, *earlier]) if earlier else problem_key
    return key_of([problem_key, load], *(f"{name} {number}" for name, number in numbers.items() if name != "python"))


def key_of_origin(origin: Origin | None, earlier: Sequence[Mapping[str, float]] = ()) -> str:
    """Return the key of a solution by its origin, and the loads before its own; empty if there is none."""
    try:
        return "" if origin is None else solution_key(key_of(origin.problem), origin.load, origin.versions, earlier)
    except InputError:
        return ""


def require_key(header: Mapping[str, Any], key: str | None = None) -> None:
    """Raise `InputError` unless the key in a header fits its problem, load and programs, and the key that is given."""
    found = header["key"]
    if found:
        problem = key_of_description({"mapping": header["problem"]["fields"]}, *header["programs"])
        made_by = (f"{name} {number}" for name, number in header["versions"].items() if name != "python")
        earlier = header.get("earlier")
        if earlier:
            problem = key_of_description([problem, *earlier])
        if found != key_of_description([problem, header["load"]], *made_by):
            raise InputError("Its key is not that of its problem.")
    if key not in (None, found):
        raise InputError(f"It is not the solution with the key {key}.")
