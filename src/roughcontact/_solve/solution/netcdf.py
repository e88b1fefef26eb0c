"""Sealed netCDF files of solutions."""

from __future__ import annotations

import importlib
import io
import math
import os
from pathlib import Path
from typing import Any

import numpy as np

from roughcontact._base.archive import SEAL, opened, replacing, seal, unpack
from roughcontact._base.checks import RealArray
from roughcontact.errors import MissingPackage

# As what xarray writes booleans, which netCDF has not; no other array is of this type. The attribute in which it notes
# them stays unread: HDF5 may search a damaged file without end for a text of any length.
_STORED_BOOLEANS = np.int8


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
            # h5py takes the type of opaque bytes from the file, even that of Python's objects: they stay unread.
            if item.id.get_type().get_class() not in (h5py.h5t.INTEGER, h5py.h5t.FLOAT):
                raise ValueError(f"its array {name!r} is not stored as plain numbers inside it")
            if item.is_scale:
                # Places, and dimensions without any, which have a shape but no data.
                continue
            stored = item.id.get_create_plist()
            is_inside = stored.get_layout() in (h5py.h5d.COMPACT, h5py.h5d.CONTIGUOUS)
            # Each array is read once: many names of one would take more memory than the file has bytes.
            left -= math.prod(item.shape) * item.dtype.itemsize
            if item.dtype.kind not in "biuf" or not is_inside or stored.get_external_count() or left < 0:
                raise ValueError(f"its array {name!r} is not stored as plain numbers inside it")
            values = np.asarray(item[()])
            packed[name] = values.astype(bool) if values.dtype == _STORED_BOOLEANS else values
        return unpack(packed)
