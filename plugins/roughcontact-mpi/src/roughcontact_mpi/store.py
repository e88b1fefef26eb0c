"""Solutions in zarr stores, of which each process writes its own chunks."""

from __future__ import annotations

import math
import os
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import roughcontact as rc

from roughcontact_mpi.arrays import SlabArray
from roughcontact_mpi.processes import Processes

SUFFIX = ".zarr"
# Names in words and units, as in the netCDF files of roughcontact.
_FIELDS = {
    "pressure": ("contact pressure", "Pa"),
    "displacement": ("elastic displacement of both surfaces", "m"),
    "initial_gap": ("gap before deformation", "m"),
    "gap": ("gap", "m"),
}
# The file by which a store of format 2 is known: xarray reads its summary of metadata, which format 3 does not define.
_MARK = ".zgroup"
# The most values of a chunk.
_CHUNK_VALUES = 2**23


def require_place(path: Path) -> None:
    """Refuse a name that a solution cannot be written to: of a store, or of a folder of .npy files."""
    if path.suffix == SUFFIX:
        _require_zarr()
        if path.exists() and not (path / _MARK).is_file():
            raise rc.InputError(f"There is something else than a zarr store at {str(path)!r}: give another name.")
        if not path.parent.is_dir():
            raise rc.InputError(f"There is no folder {str(path.parent)!r} to write {path.name!r} into.")
    elif path.suffix in (".npy", ".npz", ".nc") or path.is_file():
        raise rc.InputError(f"The output {str(path)!r} must be a folder for .npy files, or a store, NAME{SUFFIX}.")


def _require_zarr() -> Any:
    try:
        import zarr
    except ImportError:
        raise rc.MissingPackage("A store needs the package zarr: pip install 'roughcontact-mpi[zarr]'.") from None
    return zarr


def write_store(path: Path, solution: rc.solving.SlabSolution, numbers: Mapping[str, Any]) -> None:
    """Write the fields of a solution to a zarr store, each process its rows; an older store is replaced at the end.

    Its arrays have the names, dimensions, units and coordinates of the netCDF files of roughcontact, so that
    ``xarray.open_zarr`` reads it; its attributes are the numbers.
    """
    zarr = _require_zarr()
    processes = solution.pressure.processes
    partial = path.with_name(f".{path.name}.part")
    if processes.rank == 0:
        _create(zarr, partial, solution.grid, processes, {"title": "contact of rough surfaces", **numbers})
    processes.communicator.Barrier()
    own = processes.own_rows(solution.grid.shape[0])
    store = zarr.open_group(partial, mode="r+")
    for name in _FIELDS:
        field: SlabArray = getattr(solution, name)
        if field.part.size:
            store[name][own] = field.part
    processes.communicator.Barrier()
    if processes.rank == 0:
        _replace(partial, path)
    processes.communicator.Barrier()


def _create(zarr: Any, path: Path, grid: rc.Grid, processes: Processes, attributes: Mapping[str, Any]) -> None:
    """Make a store without values."""
    shutil.rmtree(path, ignore_errors=True)
    store = zarr.create_group(path, attributes=attributes, zarr_format=2)
    for name, (words, unit) in _FIELDS.items():
        store.create_array(
            name,
            shape=grid.shape,
            dtype="f8",
            chunks=(_rows_of_chunk(grid.shape, processes), grid.shape[1]),
            compressors=None,
            fill_value=math.nan,
            attributes={"long_name": words, "units": unit, "_ARRAY_DIMENSIONS": ["x", "y"]},
        )
    for name, places in (("x", grid.x[:, 0]), ("y", grid.y[0])):
        axis = store.create_array(name, data=places, compressors=None)
        axis.attrs.update({"units": "m", "_ARRAY_DIMENSIONS": [name]})
    zarr.consolidate_metadata(path, zarr_format=2)


def _rows_of_chunk(shape: tuple[int, int], processes: Processes) -> int:
    """Return a number of rows of which the slab of each process has a whole number, but for the last."""
    rows = math.gcd(*processes.rows(shape[0])[:-1]) or shape[0]
    while rows % 2 == 0 and rows * shape[1] > _CHUNK_VALUES:
        rows //= 2
    return rows


def _replace(partial: Path, path: Path) -> None:
    """Give a store its name; an older one of this name goes."""
    former = path.with_name(f".{path.name}.former")
    shutil.rmtree(former, ignore_errors=True)
    if path.exists():
        os.replace(path, former)
    os.replace(partial, path)
    shutil.rmtree(former, ignore_errors=True)
