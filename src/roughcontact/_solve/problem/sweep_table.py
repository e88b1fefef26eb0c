"""The results of a sweep as a table, and with its fields as a dataset."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from roughcontact._base.tables import Table, make_dataset

if TYPE_CHECKING:
    from roughcontact._solve.problem.sweep import Sweep

_UNITS = {
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
_LOADS = {"pressure": ("nominal mean pressure", "Pa"), "force": ("normal force", "N"), "approach": ("approach", "m")}


def make_table(sweep: Sweep) -> Table:
    """Return a row for each load."""
    peaks = [solution.peak_pressure() for solution in sweep.solutions]
    columns = {name: getattr(sweep, name) for name in _UNITS if hasattr(sweep, name)}
    columns |= {
        "area_fraction": sweep.area / [solution.grid.area for solution in sweep.solutions],
        "peak_pressure": np.array([peak.value for peak in peaks]),
        "peak_pressure_uncertainty": np.array([peak.uncertainty for peak in peaks]),
    }
    return Table({name: columns[name] for name in _UNITS}, _UNITS)


def to_dataset(sweep: Sweep) -> Any:
    """Return scalars and fields over the load; see `Sweep.to_xarray`."""
    first = sweep.solutions[0]
    kind = "pressure"
    loads = sweep.mean_pressure
    origins = [solution.origin for solution in sweep.solutions]
    kinds = {next(iter(origin.load)) for origin in origins if origin is not None}
    if len(kinds) == 1 and None not in origins:
        (kind,) = kinds
        loads = np.array([origin.load[kind] for origin in origins if origin is not None])
    table = make_table(sweep)
    variables: dict[str, Any] = {
        name: ("load", values, {"units": table.units[name]}) for name, values in table.columns.items()
    }
    for name, words, unit in (("pressure", "contact pressure", "Pa"), ("gap", "gap", "m")):
        fields = np.stack([getattr(solution, name) for solution in sweep.solutions])
        variables[name] = (("load", "x", "y"), fields, {"long_name": words, "units": unit})
    notes = {"long_name": "gap before deformation", "units": "m"}
    variables["initial_gap"] = (("x", "y"), first.initial_gap.copy(), notes)
    places = {
        "load": ("load", loads, dict(zip(("long_name", "units"), _LOADS[kind], strict=True))),
        "x": ("x", first.grid.x[:, 0], {"units": "m"}),
        "y": ("y", first.grid.y[0], {"units": "m"}),
    }
    return make_dataset(variables, places, {"title": "contact of rough surfaces"})
