"""Heights and solutions in files, of which each process reads and writes its own rows."""

from __future__ import annotations

import json
import math
import os
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar, final

import attrs
import numpy as np
import roughcontact as rc
from numpy.lib import format as npy
from roughcontact.slabs import SlabArray
from roughcontact.typing import replacing

from roughcontact_mpi.processes import Processes

_STORE = ".zarr"
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


def read_heights(path: str | Path, processes: Processes | None = None, *, unit: float = 1.0) -> SlabArray:
    """Return the heights of a .npy file, m, of which each process reads its rows.

    Parameters
    ----------
    path
        A file that all processes can read, an array of shape (nx, ny).
    processes
        The processes; None: all that `mpiexec` has started.
    unit
        The length that a height of one means, m.

    Raises
    ------
    FileError
        If it cannot be read, or is not an array of numbers with two axes.
    InputError
        If a height is not finite.
    """
    processes = Processes() if processes is None else processes
    try:
        stored = np.load(path, mmap_mode="r", allow_pickle=False)
    except (OSError, ValueError, EOFError) as error:
        raise rc.FileError(f"{path} cannot be read as a .npy file: {error}") from error
    if not isinstance(stored, np.ndarray) or stored.ndim != 2 or stored.dtype.kind not in "fiu" or not stored.size:
        raise rc.FileError(f"{path} must hold one array of real numbers with two axes.")
    part = stored[processes.own_rows(stored.shape[0])].astype(np.float64)
    part *= unit
    heights = SlabArray.field(part, processes, stored.shape[0])
    processes.meet("read_heights")
    if not np.isfinite(heights).all():
        raise rc.InputError(f"{path} has heights that are not finite: points that were not measured must be filled.")
    return heights


def write_field(path: str | Path, field: SlabArray) -> None:
    """Write a field to a .npy file, of which each process writes its rows; an older file is replaced at the end.

    Parameters
    ----------
    path
        A file on a disk of all processes.
    field
        Shape (nx, ny).
    """
    processes = field.processes
    path = Path(path)
    part = path.with_name(f".{path.name}.part")
    if processes.rank == 0:
        npy.open_memmap(part, mode="w+", dtype=field.dtype, shape=field.shape).flush()
    processes.wait()
    if field.part.size:
        stored = npy.open_memmap(part, mode="r+")
        stored[processes.own_rows(field.shape[0])] = field.part
        stored.flush()
    processes.wait()
    if processes.rank == 0:
        os.replace(part, path)
    processes.wait()


@final
@attrs.frozen
class FolderWriter(rc.SolutionWriter):
    """A folder of .npy files, pressure, displacement and gap, and numbers.json, each process writing its rows."""

    divided: ClassVar[bool] = True

    @property
    def suffixes(self) -> frozenset[str]:
        """None."""
        return frozenset({""})

    def write(self, solution: Any, path: Path) -> None:
        """Write the folder, on a disk of all processes; it is made if it is not there."""
        require_place(path)
        processes = solution.pressure.processes
        if processes.rank == 0:
            path.mkdir(parents=True, exist_ok=True)
        processes.wait()
        for name in ("pressure", "displacement", "gap"):
            write_field(path / f"{name}.npy", getattr(solution, name))
        numbers = _list_numbers(solution)
        if processes.rank == 0:
            with replacing(path / "numbers.json") as partial:
                partial.write_text(json.dumps(numbers, indent=2) + "\n", encoding="utf-8")


@final
@attrs.frozen
class StoreWriter(rc.SolutionWriter):
    """A zarr store, of which each process writes its own chunks; `xarray.open_zarr` reads it.

    Its arrays have the names, dimensions, units and coordinates of the netCDF files of roughcontact; its attributes are
    the numbers.
    """

    divided: ClassVar[bool] = True

    @property
    def suffixes(self) -> frozenset[str]:
        """Zarr."""
        return frozenset({_STORE})

    def write(self, solution: Any, path: Path) -> None:
        """Write the store; an older one is replaced at the end."""
        require_place(path)
        zarr = _require_zarr()
        processes = solution.pressure.processes
        partial = path.with_name(f".{path.name}.part")
        numbers = _list_numbers(solution)
        if processes.rank == 0:
            _create(zarr, partial, solution.grid, processes, {"title": "contact of rough surfaces", **numbers})
        processes.wait()
        own = processes.own_rows(solution.grid.shape[0])
        store = zarr.open_group(partial, mode="r+")
        for name in _FIELDS:
            field: SlabArray = getattr(solution, name)
            if field.part.size:
                store[name][own] = field.part
        processes.wait()
        if processes.rank == 0:
            _replace(partial, path)
        processes.wait()


def require_place(path: Path) -> None:
    """Refuse a name that a solution on slabs cannot be written to: of a store, or of a folder of .npy files."""
    if path.suffix == _STORE:
        _require_zarr()
        if path.exists() and not (path / _MARK).is_file():
            raise rc.InputError(f"There is something else than a zarr store at {str(path)!r}: give another name.")
        if not path.parent.is_dir():
            raise rc.InputError(f"There is no folder {str(path.parent)!r} to write {path.name!r} into.")
    elif path.suffix or path.is_file():
        raise rc.InputError(f"The output {str(path)!r} must be a folder for .npy files, or a store, NAME{_STORE}.")


def _list_numbers(solution: Any) -> dict[str, Any]:
    """Return the numbers of `to_dict`, each value by its name, with its uncertainty beside it."""
    flat = {}
    for name, one in solution.to_dict().items():
        values = one if isinstance(one, Mapping) and "value" in one else {"value": one}
        flat[name] = values["value"]
        if "uncertainty" in values:
            flat[f"{name}_uncertainty"] = values["uncertainty"]
    return flat


def _require_zarr() -> Any:
    try:
        import zarr
    except ImportError:
        raise rc.MissingPackage("A store needs the package zarr: pip install 'roughcontact-mpi[zarr]'.") from None
    return zarr


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
