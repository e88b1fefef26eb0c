"""Several loads in a row, and their results as a table."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, overload

import attrs
import numpy as np

from roughcontact._base.arrays import Array
from roughcontact._base.checks import flag
from roughcontact._base.registry import find_view
from roughcontact._base.tables import Table, make_dataset
from roughcontact._base.units import Estimate, counted, si
from roughcontact._parts.grid import Load
from roughcontact._solve.problem.path import Path, march
from roughcontact._solve.solution import Addition, ContactSolution, note_loads
from roughcontact.errors.door import guarded

# Power of the pressure that is extrapolated, maximum pressure of an elastic cell, over the limit, and power of the
# overlap that is extrapolated.
_PRESSURE_POWER = 1.75
_MAX_UNSATURATED_PRESSURE = 0.97
_OVERLAP_POWER = 2.0 / 3.0
# Relative difference of two equal loads, or of their approaches: rounding.
_EQUAL_LOAD_TOLERANCE = 1e-9
# Minimum ratio of two loads at which the solution of one is a faster start for the other than coarse grids.
_MIN_LOAD_RATIO = 0.5
_COLUMN_UNITS = {
    "mean_pressure": "Pa",
    "force": "N",
    "approach": "m",
    "area": "m2",
    "area_uncertainty": "m2",
    "area_fraction": "",
    "peak_pressure": "Pa",
    "peak_pressure_uncertainty": "Pa",
    "secant_stiffness": "N/m",
}
_LOAD_NAMES = {
    "pressure": ("nominal mean pressure", "Pa"),
    "force": ("normal force", "N"),
    "approach": ("approach", "m"),
}


@attrs.frozen(eq=False)
class Sweep(Path):
    """Solutions at several loads, and their results as columns of a table: iterable, with `len` and ``[]``.

    ``sweep[0]`` is a solution, ``sweep[:3]`` a sweep.

    Attributes
    ----------
    states
        In the order of the loads.
    """

    kind = "sweep"
    view = "panels"
    curve = "results over the load"

    states: tuple[ContactSolution, ...]

    @overload
    def __getitem__(self, index: int) -> ContactSolution: ...

    @overload
    def __getitem__(self, index: slice) -> Sweep: ...

    def __getitem__(self, index: int | slice) -> ContactSolution | Sweep:
        chosen = super().__getitem__(index)
        return chosen if isinstance(chosen, ContactSolution) else Sweep(tuple(chosen))

    @classmethod
    def _restore(cls, states: tuple[ContactSolution, ...], notes: Mapping[str, Any]) -> Sweep:
        return cls(states)

    @property
    def area(self) -> Array:
        """Real contact areas by the default estimator, m2."""
        return np.array([solution.area().value for solution in self.states])

    @property
    def area_uncertainty(self) -> Array:
        """One standard deviation of each area, m2."""
        return np.array([solution.area().uncertainty for solution in self.states])

    @property
    def secant_stiffness(self) -> Array:
        """Slopes of the chords (F[k+1] - F[k-1]) / (d[k+1] - d[k-1]) of force over approach, N/m.

        The loads are ordered from the smallest up, and equal ones count once. At the smallest and the largest load, the
        chord ends at the load itself; for a single load it is nan. `ContactSolution.stiffness` gives the stiffness at a
        load, with its uncertainty.
        """
        order = np.argsort(self.force, kind="stable")
        force = self.force[order]
        approach = self.approach[order]
        differ = [np.diff(one) > _EQUAL_LOAD_TOLERANCE * np.abs(one[1:]) for one in (force, approach)]
        is_new = np.append(True, differ[0] & differ[1])
        force = force[is_new]
        approach = approach[is_new]
        last = int(is_new.sum()) - 1
        slopes = np.full(last + 1, np.nan)
        if last > 0:
            place = np.arange(last + 1)
            above = np.minimum(place + 1, last)
            below = np.maximum(place - 1, 0)
            slopes = (force[above] - force[below]) / (approach[above] - approach[below])
        secants = np.empty(len(order))
        secants[order] = slopes[np.cumsum(is_new) - 1]
        return secants

    def plot(self, panel: Any = None, *, axes: Any = None, dark: bool = False) -> Any:
        """Draw the results over the load (extra ``plot``); see `ContactSolution.plot`."""
        return find_view("panels")("sweep", self, panel, axes, flag(dark, "dark="))

    def table(self) -> Table:
        """Return a row for each load; see `roughcontact.typing.Table`.

        Its columns are ``mean_pressure``, ``force``, ``approach``, ``area``, ``area_uncertainty``, ``area_fraction``,
        ``peak_pressure``, ``peak_pressure_uncertainty`` and ``secant_stiffness``, then what friction adds.
        """
        found = tabulate_states(self.states)
        columns: dict[str, Any] = dict(found.columns)
        columns["secant_stiffness"] = self.secant_stiffness
        order = [*_COLUMN_UNITS, *(name for name in columns if name not in _COLUMN_UNITS)]
        return Table({name: columns[name] for name in order}, {**_COLUMN_UNITS, **found.units})

    def short_table(self) -> Table:
        """Return a row for each load for people: the area with its uncertainty in percent of nominal."""
        percent = 100.0 / self.states[0].grid.area
        areas = [solution.area() for solution in self.states]
        columns: dict[str, Any] = {
            "mean pressure": self.mean_pressure,
            "force": self.force,
            "approach": self.approach,
            "area, %": [Estimate(percent * area.value, percent * area.uncertainty, "") for area in areas],
            "secant": self.secant_stiffness,
        }
        return Table(columns, {"mean pressure": "Pa", "force": "N", "approach": "m", "secant": "N/m"})

    def _list_notes(self) -> Sequence[str]:
        return note_loads(self.states)

    def to_xarray(self) -> Any:
        """Return the results and fields as an `xarray.Dataset` over the load, x and y, m (extra ``store``).

        ``pressure`` and ``gap`` have the dimensions (load, x, y), ``initial_gap`` has (x, y), and the columns of
        `to_pandas` have (load,); the coordinate ``load`` is the given load, in its unit. The fields are copies.
        """
        return to_dataset(self)

    def __repr__(self) -> str:
        low, high = (si(float(bound), "Pa") for bound in (self.mean_pressure.min(), self.mean_pressure.max()))
        return f"<Sweep {counted(len(self), 'load')}, mean pressure {low} to {high}, {self.states[0].grid}>"


def tabulate_states(states: Sequence[ContactSolution]) -> Table:
    """Return a row for each state: load, approach, area, peak pressure, and what physics have added."""
    areas = [state.area() for state in states]
    peaks = [state.peak_pressure() for state in states]
    columns: dict[str, Any] = {
        "mean_pressure": np.array([state.mean_pressure for state in states]),
        "force": np.array([state.force for state in states]),
        "approach": np.array([state.approach for state in states]),
        "area": np.array([area.value for area in areas]),
        "area_uncertainty": np.array([area.uncertainty for area in areas]),
        "area_fraction": np.array([area.value / state.grid.area for area, state in zip(areas, states, strict=True)]),
        "peak_pressure": np.array([peak.value for peak in peaks]),
        "peak_pressure_uncertainty": np.array([peak.uncertainty for peak in peaks]),
    }
    added, units = tabulate_added(states)
    return Table(columns | added, {name: _COLUMN_UNITS[name] for name in columns} | units)


def tabulate_added(
    states: Sequence[ContactSolution], kind: type[Addition] = Addition
) -> tuple[dict[str, list[Any]], dict[str, str]]:
    """Return a column for each number that physics, of a kind, have added to states of one kind, and the units."""
    columns: dict[str, list[Any]] = {}
    units: dict[str, str] = {}
    for state in states:
        for added in (one for one in state.added if isinstance(one, kind)):
            for name, one in added.list_columns(state).items():
                number, unit = (one, "") if isinstance(one, Estimate) else one
                columns.setdefault(name, []).append(number)
                units |= {name: unit} if unit else {}
    return columns, units


@guarded
def run_sweep(solve: Callable[[Load, Array | None], ContactSolution], loads: tuple[Load, ...]) -> Sweep:
    """Return the solutions at all loads; see `solve_from_largest`."""
    solutions = dict(solve_from_largest(solve, loads))
    return Sweep(tuple(solutions[index] for index in range(len(loads))))


def solve_from_largest(
    solve: Callable[[Load, Array | None], ContactSolution], loads: Sequence[Load]
) -> Iterator[tuple[int, ContactSolution]]:
    """Yield the position of each load and its solution, from the largest down: each starts from the two before."""
    order = order_of_solving(loads)

    def follow(before: Sequence[ContactSolution], load: Load) -> ContactSolution:
        return solve(load, predict_pressure(before, load))

    return zip(order, march([loads[index] for index in order], follow), strict=True)


def report_states(
    solve: Callable[..., ContactSolution], tell: Callable[[ContactSolution], object]
) -> Callable[..., ContactSolution]:
    """Return a solve that calls a function with each state that it finds."""

    def solve_and_report(load: Load, start: Array | None = None, **others: Any) -> ContactSolution:
        state = solve(load, start, **others)
        tell(state)
        return state

    return solve_and_report


def order_of_solving(loads: Sequence[Load]) -> list[int]:
    """Return the positions of the loads from the largest down.

    Cells that will leave the contact are known, with their pressures; cells that will join it are not.
    """
    return sorted(range(len(loads)), key=lambda index: -loads[index].value)


def predict_pressure(solutions: Sequence[ContactSolution], load: Load) -> Array | None:
    """Return a pressure to start from, shape (nx, ny), Pa; None if a solve without it is as fast.

    Towards smaller loads the pressure of a cell falls nearly in proportion to the load inside a contact, and as a
    square root to zero at a passing edge: a power between them is extrapolated over the logarithm of the load. A
    saturated cell stays at the limit while its extrapolated gap is negative.

    The earlier solutions end with the nearest load, better a larger than a smaller one than the next load.
    """
    if not solutions:
        return None
    last = solutions[-1]
    if last.tension is not None:
        # The contact with adhesion does not follow the load so simply.
        return None
    name = {"pressure": "mean_pressure"}.get(load.kind, load.kind)
    values = [float(getattr(solution, name)) for solution in solutions[-2:]]
    if min(*values, load.value) <= 0.0:
        # Of bodies that have come apart nothing is known.
        return None
    if not _MIN_LOAD_RATIO <= load.value / values[-1] <= 1.0 / _MIN_LOAD_RATIO:
        return None
    if len(values) == 1 and last.saturated.any():
        return None
    if len(values) == 1 or values[0] == values[1]:
        return np.asarray(np.minimum(last.pressure * (load.value / values[-1]), last.pressure_limit))
    step = math.log(load.value / values[1]) / math.log(values[1] / values[0])
    before = solutions[-2]
    cells = np.flatnonzero(last.contact)
    peak = float(last.pressure.max())
    # Powers take a tenth of the time in float32.
    now, then = ((one.pressure.take(cells) / peak).astype(np.float32) ** _PRESSURE_POWER for one in (last, before))
    inside = peak * (np.maximum(now + np.float32(step) * (now - then), 0.0) ** (1.0 / _PRESSURE_POWER)).astype(
        np.float64
    )
    limit = np.broadcast_to(last.pressure_limit, last.pressure.shape).take(cells)
    np.minimum(inside, _MAX_UNSATURATED_PRESSURE * limit, out=inside)
    if last.saturated.any():
        depth, earlier = (np.maximum(-one.gap.take(cells), 0.0) ** _OVERLAP_POWER for one in (last, before))
        overlap = depth + step * (depth - earlier) > 0.0
        np.copyto(inside, limit, where=last.saturated.take(cells) & overlap)
    start = np.zeros_like(last.pressure)
    start.reshape(-1)[cells] = inside
    return start if inside.max(initial=0.0) > 0.0 else None


def to_dataset(sweep: Sweep) -> Any:
    """Return scalars and fields over the load; see `Sweep.to_xarray`."""
    first = sweep.states[0]
    kind = "pressure"
    loads = sweep.mean_pressure
    origins = [solution.origin for solution in sweep.states]
    kinds = {next(iter(origin.load)) for origin in origins if origin is not None}
    if len(kinds) == 1 and None not in origins:
        (kind,) = kinds
        loads = np.array([origin.load[kind] for origin in origins if origin is not None])
    table = sweep.table()
    variables: dict[str, Any] = {
        name: ("load", values, {"units": table.units[name]}) for name, values in table.columns.items()
    }
    for name, words, unit in (("pressure", "contact pressure", "Pa"), ("gap", "gap", "m")):
        fields = np.stack([getattr(solution, name) for solution in sweep.states])
        variables[name] = (("load", "x", "y"), fields, {"long_name": words, "units": unit})
    notes = {"long_name": "gap before deformation", "units": "m"}
    variables["initial_gap"] = (("x", "y"), first.initial_gap.copy(), notes)
    places = {
        "load": ("load", loads, dict(zip(("long_name", "units"), _LOAD_NAMES[kind], strict=True))),
        "x": ("x", first.grid.x[:, 0], {"units": "m"}),
        "y": ("y", first.grid.y[0], {"units": "m"}),
    }
    return make_dataset(variables, places, {"title": "contact of rough surfaces"})
