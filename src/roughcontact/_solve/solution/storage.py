"""Solutions in files, npz and netCDF."""

from __future__ import annotations

import contextlib
import importlib
import io
import math
import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeVar

import attrs
import numpy as np
import numpy.typing as npt

from roughcontact._base.archive import (
    SEAL,
    digest_of,
    opened,
    pack,
    read_archive,
    read_some,
    replacing,
    seal,
    unpack,
    write_archive,
)
from roughcontact._base.archive.plain import (
    Described,
    arrays_in,
    describe,
    missing_classes,
    public_class,
    rebuild,
)
from roughcontact._base.arrays import Array, Mask, RealArray, frozen_array, read_only
from roughcontact._base.tables import make_dataset
from roughcontact._parts.grid import Boundary, Grid
from roughcontact._solve.solution.additions import describe_additions, rebuild_additions
from roughcontact._solve.solution.answers import ContactAnswers
from roughcontact._solve.solution.origin import Origin, key_of_origin, require_key, versions
from roughcontact._solve.solution.results import GridLevel, Residuals, Status
from roughcontact.errors import InputError, MissingPackage
from roughcontact.errors.warning import warn

# Type as which xarray writes booleans, which netCDF does not have; no other array is of this type. Its attribute for
# them is not read: HDF5 may search a damaged file for an endless text.
_STORED_BOOLEANS = np.int8
T = TypeVar("T")
S = TypeVar("S", bound=ContactAnswers)
_ARCHIVE_KIND = "solution"
# Files of states with friction from before these were solutions.
_FRICTIONAL_KIND = "frictional solution"
_FRICTIONAL_PLAIN = ("friction", "given", "pair", "dissipated", "elastic_energy", "passes", "iterations", "increments")
_PART_PREFIX = "part_"
_NOTHING_ADDED: Mapping[str, Any] = MappingProxyType({"mapping": {}})
_FIELDS = {
    "pressure": ("contact pressure", "Pa"),
    "displacement": ("elastic displacement of both surfaces", "m"),
    "initial_gap": ("gap before deformation", "m"),
    "gap": ("gap", "m"),
}
_SCALARS = {
    "modulus": ("contact modulus", "Pa"),
    "maximum_pressure": ("maximum contact pressure", "Pa"),
    "force": ("normal force", "N"),
    "mean_pressure": ("nominal mean pressure", "Pa"),
    "approach": ("approach since first touch", "m"),
    "area": ("real contact area", "m2"),
    "area_uncertainty": ("standard deviation of the real contact area", "m2"),
    "saturated_area": ("area at the pressure limit", "m2"),
    "saturated_area_uncertainty": ("standard deviation of the saturated area", "m2"),
}
# Bytes that the arrays of a problem may take, plus a multiple of their own.
_COPY_ALLOWANCE = 2**26
_MAX_COPIES = 16
_REAL_FIELDS = ("modulus", "approach", "seconds", "edge_shift")
_COUNT_FIELDS = ("iterations", "convolutions")


def require_netcdf() -> None:
    """Raise `MissingPackage` without the packages that write netCDF."""
    for name in ("xarray", "h5netcdf"):
        try:
            importlib.import_module(name)
        except ImportError:
            raise MissingPackage(f"netCDF needs the package {name}: pip install 'roughcontact[store]'.") from None


def write_netcdf(path: Path, dataset: Any) -> None:
    """Write an xarray dataset with a seal, completely or not at all."""
    require_netcdf()
    import h5netcdf
    from xarray.backends import H5NetCDFStore

    # In memory: HDF5 ends the process when it cannot write its file.
    content = io.BytesIO()
    with h5netcdf.File(content, "w") as file:
        dataset.dump_to_store(H5NetCDFStore(file))
    content.seek(0, os.SEEK_END)
    content.write(SEAL)
    with replacing(path) as partial:
        partial.write_bytes(content.getvalue())
        seal(partial)


def read_netcdf(path: Path) -> tuple[dict[str, RealArray], dict[str, Any]]:
    """Return the arrays and the header of a file of `write_netcdf`; see `roughcontact._base.archive.opened`."""
    try:
        import h5py
    except ImportError:
        raise MissingPackage("netCDF needs the package h5py: pip install 'roughcontact[store]'.") from None
    packed = {}
    with opened(path) as stream, h5py.File(stream, "r") as file:
        left = os.fstat(stream.fileno()).st_size
        for name in file:
            link = file.get(name, getlink=True)
            item = file[name] if isinstance(link, h5py.HardLink) else None
            if not isinstance(item, h5py.Dataset):
                raise ValueError(f"{name!r} is not an array in it")
            # h5py takes the type of opaque bytes, even Python objects, from the file: they are not read.
            if item.id.get_type().get_class() not in (h5py.h5t.INTEGER, h5py.h5t.FLOAT):
                raise ValueError(f"its array {name!r} is not stored as plain numbers inside it")
            if item.is_scale:
                # Coordinates, and dimensions without coordinates, which have no data.
                continue
            stored = item.id.get_create_plist()
            is_inside = stored.get_layout() in (h5py.h5d.COMPACT, h5py.h5d.CONTIGUOUS)
            # Many names of one array would take more memory than the file has bytes.
            left -= math.prod(item.shape) * item.dtype.itemsize
            if item.dtype.kind not in "biuf" or not is_inside or stored.get_external_count() or left < 0:
                raise ValueError(f"its array {name!r} is not stored as plain numbers inside it")
            values = np.asarray(item[()])
            packed[name] = values.astype(bool) if values.dtype == _STORED_BOOLEANS else values
        return unpack(packed)


def write(
    path: Path, solution: ContactAnswers, *, flush: bool = True, earlier: Sequence[Mapping[str, float]] = ()
) -> None:
    """Write a solution; see `ContactSolution.save`, for `flush` `replacing`, and for `earlier` `solution_key`."""
    if path.suffix not in (".npz", ".nc"):
        raise InputError.about("The name of a solution's file", path.name, "one ending in .npz or .nc")
    arrays, header = disassemble(solution, earlier)
    if missing := missing_classes(header["problem"]):
        warn(f"{path.name} keeps the fields of the solution. {missing}")
    if path.suffix == ".nc":
        write_netcdf(path, _dataset(solution, pack(arrays, header)))
    else:
        write_archive(
            path, {**arrays, "size": np.array(solution.grid.size), "status": solution.status.name}, header, flush=flush
        )


def read(path: Path, key: str | None = None) -> dict[str, Any]:
    """Return the arguments of a `ContactSolution`, which must have the key if one is given; see its `load`."""
    arrays, header = read_netcdf(path) if path.suffix == ".nc" else read_archive(path)
    kind = header.get("kind")
    if kind not in (_ARCHIVE_KIND, _FRICTIONAL_KIND):
        raise InputError(f"The file {path.name} does not hold a solution: rc.load reads sweeps, cycles and paths too.")
    with usable(path, "its header is wrong"):
        if kind == _FRICTIONAL_KIND:
            arrays, header = translate_frictional(header["states"][0], arrays)
        require_key(header, key)
        fields = assemble(arrays, header)
        require_sound(fields, arrays)
        return fields


def read_figures(path: Path, key: str) -> dict[str, Any]:
    """Return status, cost and scalars of the solution with a key; the file is compared with its checksum."""
    arrays, header = read_some(path, _SCALARS)
    with usable(path, "its header is wrong"):
        require_key(header, key)
        numbers = {name: float(arrays[name]) for name in _SCALARS}
        stated = {name: rebuild(header[name], {}) for name in ("status", "seconds", *_COUNT_FIELDS)}
        return {**numbers, **stated}


def verify(path: Path, solution: ContactAnswers) -> None:
    """Raise `InputError` unless the residuals recomputed from a solution's pressure confirm it."""
    verify_states(path, [solution])


def verify_states(path: Path, states: Sequence[S]) -> list[S]:
    """Return states with their problem, that of the first one; `InputError` unless it confirms all of them."""
    first = states[0]
    origin = first.origin
    missing = "It does not name its problem." if origin is None else origin.missing
    if origin is None or missing:
        raise InputError(
            f"The file {path.name} cannot be verified. {missing} ContactSolution.load(..., verify=False) takes its "
            "fields and residuals as they are."
        )
    with usable(path, "its problem cannot be verified"):
        kind: Any = public_class("ContactProblem")
        problem = kind(**origin.bound(first.grid))
        for state in states:
            problem.verify(state)
        return [attrs.evolve(one, origin=attrs.evolve(one.origin, source=problem)) for one in states if one.origin]


@contextlib.contextmanager
def usable(path: Path, trouble: str) -> Iterator[None]:
    """Turn any error by the content of a file into an `InputError`."""
    try:
        # Numbers of a file may overflow: infinite ones are refused later.
        with np.errstate(all="ignore"):
            yield
    except MemoryError:
        raise
    except InputError as error:
        raise InputError(f"The file {path.name} cannot be used: {' '.join(str(error).split())}") from error
    # Each plug-in refuses wrong fields in its own way.
    except Exception as error:
        raise InputError(f"The file {path.name} cannot be used: {trouble} ({error!r:.200}).") from error


def require_sound(fields: Mapping[str, Any], arrays: Mapping[str, RealArray]) -> None:
    """Raise `InputError` if the figures and fields of a file contradict each other; no convolution is needed."""
    pressure = fields["pressure"]
    status = fields["status"]
    residuals = fields["residuals"]
    gap = fields["initial_gap"] + fields["displacement"] - fields["approach"]
    if not np.array_equal(arrays["gap"], gap, equal_nan=True):
        raise InputError("Its gap is not the initial gap plus displacement minus approach.")
    if min(fields[name] for name in _COUNT_FIELDS) < 0 or not fields["seconds"] >= 0.0 or not fields["modulus"] > 0.0:
        raise InputError("A number of iterations or convolutions, the time or the contact modulus is negative.")
    force = float(np.add.reduce(pressure, axis=None)) * fields["grid"].cell_area
    if not np.allclose([arrays["force"], arrays["mean_pressure"] * fields["grid"].area], force, equal_nan=True):
        raise InputError("Its force is not that of its pressure.")
    finite = all(np.isfinite(fields[name]).all() for name in ("pressure", "displacement", "initial_gap", *_REAL_FIELDS))
    residuals_hold = all(0.0 <= value < math.inf for value in attrs.astuple(residuals))
    lowest = 0.0 if fields["tension"] is None else -fields["tension"]
    bounded = finite and (pressure >= lowest).all() and (pressure <= fields["pressure_limit"]).all()
    if status.success and not (bounded and residuals_hold):
        raise InputError(f"Its status is {status.name}, but values are not finite or the pressure leaves its bounds.")


def to_xarray(solution: ContactAnswers) -> Any:
    """Return the solution as an xarray dataset; see `ContactSolution.to_xarray`."""
    variables = {name: np.asarray(values) for name, values in _list_variables(solution).items()}
    return _dataset(solution, variables | {name: values for name, (values, _, _) in list_added(solution).items()})


def list_added(solution: ContactAnswers) -> dict[str, tuple[RealArray, str, str]]:
    """Return the fields that physics have added to a solution; see `Addition.list_fields`."""
    return {name: field for one in solution.added for name, field in one.list_fields().items()}


def _dataset(solution: ContactAnswers, packed: Mapping[str, RealArray]) -> Any:
    grid = solution.grid
    variables = {}
    fields = _FIELDS | {name: (words, unit) for name, (_, words, unit) in list_added(solution).items()}
    for name, values in packed.items():
        axes = ("x", "y") if name in fields else tuple(f"{name}_{axis}" for axis in range(values.ndim))
        words, unit = {**fields, **_SCALARS}.get(name, (None, None))
        variables[name] = (axes, values, {"long_name": words, "units": unit} if words else {})
    places = {"x": ("x", grid.x[:, 0], {"units": "m"}), "y": ("y", grid.y[0], {"units": "m"})}
    made_with = versions() if solution.origin is None else solution.origin.versions
    made_by = ", ".join(f"{name} {number}" for name, number in made_with.items())
    title = {"title": "contact of rough surfaces", "status": str(solution.status), "versions": made_by}
    return make_dataset(variables, places, title)


def disassemble(
    solution: ContactAnswers, earlier: Sequence[Mapping[str, float]] = ()
) -> tuple[dict[str, npt.ArrayLike], dict[str, Any]]:
    """Return all arrays by name, and everything else as data for JSON; see `solution_key` for `earlier`."""
    parts: dict[str, RealArray] = {}
    origin = solution.origin
    limit = solution.pressure_limit
    described = ("moduli", "directional_moduli", "boundary", *_REAL_FIELDS, *_COUNT_FIELDS)
    tables = {name: attrs.asdict(getattr(solution, name)) for name in ("grid", "residuals")}
    header = {
        "kind": _ARCHIVE_KIND,
        # A study finds a solution by it, if its problem tells it.
        "key": key_of_origin(origin, earlier) if all(one.of_problem for one in solution.added) else "",
        **({"earlier": describe(list(earlier), parts)} if earlier else {}),
        "versions": versions() if origin is None else dict(origin.versions),
        "programs": [] if origin is None else origin.programs,
        "status": solution.status.name,
        "pressure_limit": describe(limit if limit.ndim else float(limit), parts),
        "non_measured": describe(solution.non_measured, parts),
        # The errors of the iterations have their former name in files.
        "history": describe(solution.errors, parts),
        **{name: describe(getattr(solution, name), parts) for name in described},
        **{name: describe(table, parts) for name, table in tables.items()},
        "levels": [describe(attrs.asdict(level), parts) for level in solution.levels],
        "tension": describe(solution.tension, parts),
        "added": describe_additions(solution.added, parts),
        "problem": None if origin is None else origin.describe(parts),
        "load": None if origin is None else describe(origin.load, parts),
    }
    return {**_list_variables(solution), **{_PART_PREFIX + name: values for name, values in parts.items()}}, header


def _list_variables(solution: ContactAnswers) -> dict[str, npt.ArrayLike]:
    return {**{name: getattr(solution, name) for name in _FIELDS}, **scalars_of(solution)}


def scalars_of(solution: ContactAnswers) -> dict[str, float]:
    """Return the scalars of a file by name, in SI units."""
    figures = {
        "maximum_pressure": float(solution.pressure.max()),
        **_estimate(solution, "area"),
        **_estimate(solution, "saturated_area"),
    }
    return {name: figures.get(name, getattr(solution, name, math.nan)) for name in _SCALARS}


def _estimate(solution: ContactAnswers, what: str) -> dict[str, float]:
    """Return an area and its uncertainty; nan if it fails, so that the solution can still be saved."""
    try:
        area = getattr(solution, what)()
        value = float(area.value)
        uncertainty = float(area.uncertainty)
    except Exception:
        value = uncertainty = math.nan
    return {what: value, f"{what}_uncertainty": uncertainty}


def translate_frictional(
    described: Mapping[str, Any], arrays: Mapping[str, RealArray]
) -> tuple[dict[str, RealArray], dict[str, Any]]:
    """Return arrays and header of a state in a file from before states with friction were solutions."""
    contact = described["contact"]
    names = {**contact["arrays"]}
    before = described["before"]
    own = {**described["arrays"], "before": before["pressure"], "before shear": before["shear"]}
    names |= {_PART_PREFIX + digest: digest for digest in (*own.values(), *described["parts"].values())}
    residuals = {name: one for name, one in described["residuals"]["mapping"].items() if name != "normal"}
    shear = {
        **{name: described[name] for name in (*_FRICTIONAL_PLAIN, "displacement")},
        "residuals": {"mapping": residuals},
        "traction": {"array": own["shear"]},
        "slip": {"array": own["slip"]},
        "before": {**before, "pressure": {"array": before["pressure"]}, "shear": {"array": before["shear"]}},
    }
    header = {
        **contact["header"],
        "status": described["status"],
        "seconds": described["seconds"],
        "key": "",
        "added": {"mapping": {"shear": shear}},
    }
    return {name: arrays[digest] for name, digest in names.items()}, header


def assemble(
    arrays: Mapping[str, RealArray], header: Mapping[str, Any], given: Mapping[str, Any] = MappingProxyType({})
) -> dict[str, Any]:
    """Return the arguments of a `ContactSolution`; `given` has parts that a file need not name, by kind of addition."""
    parts = {
        name.removeprefix(_PART_PREFIX): values for name, values in arrays.items() if name.startswith(_PART_PREFIX)
    }

    def build(cls: type[T], described: Described) -> T:
        return cls(**rebuild(described, parts))

    if any(digest_of(values) != name for name, values in parts.items()):
        raise InputError("An array of its problem is not the one that it is named after.")
    _require_few(header["problem"], parts)
    grid = build(Grid, header["grid"])
    limit, moduli = (rebuild(header[name], parts) for name in ("pressure_limit", "moduli"))
    # Files from before there were anisotropic bodies do not name them.
    directional = rebuild(header.get("directional_moduli"), parts)
    origin = None
    if header["problem"] is not None:
        load = {name: float(value) for name, value in rebuild(header["load"], parts).items()}
        made_by = {str(name): str(number) for name, number in header["versions"].items()}
        origin = Origin(None, load, saved=(header["problem"], parts), versions=made_by)
        origin = origin if origin.missing else Origin(origin.problem, load, versions=made_by)
    return {
        **{name: float(rebuild(header[name], parts)) for name in _REAL_FIELDS},
        **{name: int(header[name]) for name in _COUNT_FIELDS},
        **{name: _field(arrays[name], grid) for name in ("pressure", "displacement", "initial_gap")},
        "grid": grid,
        "pressure_limit": _field(limit, grid) if isinstance(limit, np.ndarray) else float(limit),
        "residuals": build(Residuals, header["residuals"]),
        "levels": tuple(build(GridLevel, level) for level in header["levels"]),
        "moduli": None if moduli is None else _table(moduli),
        "directional_moduli": None if directional is None else tuple(map(float, directional)),
        "non_measured": _mask(rebuild(header["non_measured"], parts), grid),
        "boundary": Boundary(header["boundary"]),
        "status": Status[header["status"]],
        # Files from before there was adhesion do not name it.
        "tension": _tension(rebuild(header.get("tension"), parts), grid),
        "added": rebuild_additions(header.get("added", _NOTHING_ADDED), parts, grid, given),
        "errors": tuple(map(float, rebuild(header["history"], parts))),
        "origin": origin,
    }


def _tension(value: Any, grid: Grid) -> Array | None:
    if value is None:
        return None
    tension = _field(value, grid)
    if not (np.isfinite(tension).all() and tension.min() >= 0.0):
        raise InputError("Its tension is negative or not finite.")
    return tension


def _require_few(described: Described, parts: Mapping[str, RealArray]) -> None:
    """Raise `InputError` if a problem names its arrays so often that their copies take far more than the file."""
    # A copy may be float64; a sum of two surfaces may name a map twice.
    taken = sum(8 * parts[name].size for name in arrays_in(described) if name in parts)
    if taken > _COPY_ALLOWANCE + _MAX_COPIES * sum(values.nbytes for values in parts.values()):
        raise InputError(f"The arrays that its problem names take {taken} bytes, more than it may hold.")


def _table(rows: Any) -> tuple[tuple[float, ...], tuple[float, ...]]:
    lengths, moduli = (tuple(map(float, row)) for row in rows)
    if len(lengths) != len(moduli) or not moduli:
        raise InputError(f"It has {len(moduli)} moduli at {len(lengths)} wave numbers.")
    return lengths, moduli


def _mask(values: Any, grid: Grid) -> Mask | None:
    if values is None:
        return None
    if not isinstance(values, np.ndarray) or values.shape != grid.shape or values.dtype != np.bool_:
        raise InputError(f"Its non-measured points are not booleans on a grid of {grid}.")
    return read_only(values)


def _field(values: RealArray, grid: Grid) -> Array:
    if values.shape != grid.shape or values.dtype != np.float64:
        raise InputError(f"It has an array of {values.shape} values of type {values.dtype} on a grid of {grid}.")
    return frozen_array(values)
