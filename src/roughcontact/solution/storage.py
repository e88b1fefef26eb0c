"""Solutions in files: npz, and netCDF through xarray."""

from __future__ import annotations

import json
import platform
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from roughcontact.archive import read_archive, replacing, write_archive
from roughcontact.checks import RealArray, frozen_array
from roughcontact.description import describe, rebuild
from roughcontact.errors import InputError, MissingPackage
from roughcontact.grid import Boundary
from roughcontact.solution.figures import Status

if TYPE_CHECKING:
    from roughcontact.solution.contact import ContactSolution

_KIND = "roughcontact solution 1"
_ORIGIN = "origin_"
_FIELDS = {
    "pressure": ("contact pressure", "Pa"),
    "displacement": ("elastic displacement of both surfaces", "m"),
    "undeformed": ("gap before deformation", "m"),
    "gap": ("gap", "m"),
}
_SCALARS = {
    "modulus": ("contact modulus", "Pa"),
    "force": ("normal force", "N"),
    "mean_pressure": ("nominal mean pressure", "Pa"),
    "approach": ("approach since first touch", "m"),
    "area": ("real contact area", "m2"),
    "area_uncertainty": ("standard deviation of the real contact area", "m2"),
    "saturated_area": ("area at the pressure limit", "m2"),
    "saturated_area_uncertainty": ("standard deviation of the saturated area", "m2"),
}
_PLAIN = ("modulus", "approach", "iterations", "convolutions", "seconds", "edge_shift")


def versions() -> dict[str, str]:
    """Return the versions that a result depends on."""
    found = {name: version(name) for name in ("roughcontact", "numpy", "scipy")}
    return {**found, "python": platform.python_version()}


def write(path: Path, solution: ContactSolution) -> None:
    """Write a solution; see `ContactSolution.save`."""
    if path.suffix == ".nc":
        _write_netcdf(path, solution)
        return
    if path.suffix != ".npz":
        raise InputError.about("The name of a solution's file", path.name, "one ending in .npz or .nc")
    arrays, header = _taken_apart(solution)
    size = np.array(solution.grid.size)
    write_archive(path, {**arrays, **_scalars(solution), "size": size, "status": solution.status.name}, header)


def read(path: Path) -> dict[str, Any]:
    """Return the arguments of a `ContactSolution`; see `ContactSolution.load`."""
    arrays, header = _read_netcdf(path) if path.suffix == ".nc" else read_archive(path)
    if header.get("kind") != _KIND:
        raise InputError(f"The file {path.name} holds no solution of this version of the package.")
    try:
        return _put_together(arrays, header)
    except InputError:
        raise
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f"The file {path.name} is damaged: {error!r}.") from error


def to_xarray(solution: ContactSolution) -> Any:
    """Return the solution as an xarray dataset; see `ContactSolution.to_xarray`."""
    try:
        import xarray
    except ImportError:
        raise MissingPackage("Datasets need the package xarray: pip install 'roughcontact[store]'.") from None
    arrays, header = _taken_apart(solution)
    grid = solution.grid
    names = {name: (("x", "y"), arrays[name], _described(_FIELDS[name])) for name in _FIELDS}
    numbers = {name: ((), value, _described(_SCALARS[name])) for name, value in _scalars(solution).items()}
    rest = {
        name: (tuple(f"{name}_{axis}" for axis in range(np.ndim(values))), values)
        for name, values in arrays.items()
        if name not in _FIELDS
    }
    places = {"x": ("x", grid.x[:, 0], {"units": "m"}), "y": ("y", grid.y[0], {"units": "m"})}
    title = {"title": "contact of rough surfaces", "status": str(solution.status), "header": json.dumps(header)}
    return xarray.Dataset({**names, **numbers, **rest}, coords=places, attrs=title)


def _described(words: tuple[str, str]) -> dict[str, str]:
    return {"long_name": words[0], "units": words[1]}


def _scalars(solution: ContactSolution) -> dict[str, float]:
    area, saturated = solution.area(), solution.saturated_area()
    figures = {
        "area": area.value,
        "area_uncertainty": area.uncertainty,
        "saturated_area": saturated.value,
        "saturated_area_uncertainty": saturated.uncertainty,
    }
    return {name: figures[name] if name in figures else getattr(solution, name) for name in _SCALARS}


def _taken_apart(solution: ContactSolution) -> tuple[dict[str, npt.ArrayLike], dict[str, Any]]:
    """Return all arrays by name, and everything else as data that JSON can hold."""
    parts: dict[str, RealArray] = {}
    header = {
        "kind": _KIND,
        "versions": versions(),
        **{name: getattr(solution, name) for name in _PLAIN},
        "moduli": describe(solution.moduli, parts),
        "boundary": str(solution.boundary),
        "status": solution.status.name,
        "history": list(solution.history),
        **{
            name: describe(getattr(solution, name), parts)
            for name in ("grid", "limit", "residuals", "levels", "origin")
        },
    }
    arrays: dict[str, npt.ArrayLike] = {name: getattr(solution, name) for name in _FIELDS}
    return {**arrays, **{_ORIGIN + name: values for name, values in parts.items()}}, header


def _put_together(arrays: Mapping[str, RealArray], header: Mapping[str, Any]) -> dict[str, Any]:
    parts = {name.removeprefix(_ORIGIN): values for name, values in arrays.items() if name.startswith(_ORIGIN)}
    return {
        **{name: header[name] for name in _PLAIN},
        **{name: rebuild(header[name], parts) for name in ("grid", "limit", "residuals", "levels", "origin")},
        **{name: frozen_array(arrays[name]) for name in ("pressure", "displacement", "undeformed")},
        "moduli": rebuild(header.get("moduli"), parts),
        "boundary": Boundary(header["boundary"]),
        "status": Status[header["status"]],
        "history": tuple(header["history"]),
    }


def _write_netcdf(path: Path, solution: ContactSolution) -> None:
    dataset = to_xarray(solution)
    _require_netcdf()
    with replacing(path) as partial:
        dataset.to_netcdf(partial, engine="h5netcdf")


def _read_netcdf(path: Path) -> tuple[dict[str, RealArray], dict[str, Any]]:
    _require_netcdf()
    import xarray

    if not path.is_file():
        raise InputError(f"There is no file {str(path)!r}.")
    try:
        with xarray.open_dataset(path, engine="h5netcdf") as dataset:
            arrays = {str(name): np.asarray(values) for name, values in dataset.data_vars.items()}
            return arrays, json.loads(dataset.attrs["header"])
    except (OSError, KeyError, ValueError, RuntimeError) as error:
        raise InputError(f"The file {path.name} is damaged, or is no file of this package ({error}).") from error


def _require_netcdf() -> None:
    try:
        import h5netcdf  # noqa: F401
        import xarray  # noqa: F401
    except ImportError as error:
        raise MissingPackage(f"netCDF needs the package {error.name}: pip install 'roughcontact[store]'.") from None
