"""The figure of a path along which the surfaces change: its curve, and what else changes."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from roughcontact._base.arrays import Array
from roughcontact._base.tables import Table
from roughcontact._base.units import Estimate
from roughcontact._faces.panels.results import (
    choose_unit,
    draw_load_path,
    draw_over_course,
    label_axis,
    numbers_of,
)
from roughcontact._faces.panels.theme import style
from roughcontact._solve.problem import LoadPath
from roughcontact.errors.door import guarded

# Columns of the table of a path that are not drawn: what passes, the work of the solver, what other columns say.
_OMITTED = ("sliding", "time", "increments", "mean_pressure", "area_fraction")
# What the curve of a path shows, over sliding distance or time, and over nothing of them.
_IN_CURVE = {True: ("area",), False: ("force", "approach")}
# Change of a number over its size from which it is drawn.
_MIN_CHANGE = 1e-6
# Curves in a row, and the width and height of each, inches.
_COLUMNS = 2
_INCHES = (3.2, 2.4)


@guarded
def draw_course(path: LoadPath, dark: bool = False) -> Any:
    """Return a figure of a path along which the surfaces change: its curve, and what else changes in its table.

    Parameters
    ----------
    path
        The path.
    dark
        Whether the background is dark.

    Examples
    --------
    >>> import roughcontact as rc
    >>> pin = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
    >>> problem = rc.ContactProblem(pin, grid=rc.Grid((48, 48), 160e-6), laws=rc.Archard("1e-16m2/N"))
    >>> figure = rc.plotting.draw_course(problem.path(force=1.0, sliding=["0m", "1m"]))  # doctest: +SKIP
    """
    table = path.table()
    name = next((one for one in ("sliding", "time") if one in table.columns), "state")
    passed = np.arange(1.0, len(path) + 1.0) if name == "state" else np.asarray(table.columns[name])
    omitted = (*_OMITTED, *_IN_CURVE[name != "state"])
    columns = {
        one: _read(table, one) for one in table.columns if one not in omitted and not one.endswith("_uncertainty")
    }
    columns = {one: column for one, column in columns.items() if _changes(column[0])}
    rows = math.ceil((1 + len(columns)) / _COLUMNS)
    with style(dark):
        from matplotlib import pyplot

        figure = pyplot.figure(figsize=(_COLUMNS * _INCHES[0], rows * _INCHES[1]), layout="constrained")
        draw_load_path(path, figure.add_subplot(rows, _COLUMNS, 1), dark)
        for place, (one, (values, spread, base)) in enumerate(columns.items(), 2):
            factor, unit = choose_unit(values[np.isfinite(values) & (values != 0.0)], base)
            axes = figure.add_subplot(rows, _COLUMNS, place)
            draw_over_course(axes, name, passed, factor * values, factor * spread, label_axis(one, unit))
    return figure


def _read(table: Table, name: str) -> tuple[Array, Array, str]:
    """Return the numbers of a column, their standard deviations and their unit."""
    column = table.columns[name]
    if isinstance(column[0], Estimate):
        values, spread = (np.array([getattr(one, part) for one in column]) for part in ("value", "uncertainty"))
        return values, spread, column[0].unit
    spread = numbers_of(table, f"{name}_uncertainty" if f"{name}_uncertainty" in table.columns else "")
    return numbers_of(table, name), spread, table.units.get(name, "")


def _changes(values: Array) -> bool:
    known = values[np.isfinite(values)]
    return bool(known.size and np.ptp(known) > _MIN_CHANGE * np.abs(known).max())
