"""Files of fields in layers below a surface for ParaView and VTK, which need no package."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np
import roughcontact as rc
from roughcontact.typing import Array, replacing

# Bytes of the length that precedes each array.
_LENGTH_BYTES = 8


def write_layers(path: str | os.PathLike[str], grid: rc.Grid, interfaces: Array, fields: Mapping[str, Array]) -> None:
    """Write fields of the cells of layers as a rectilinear grid, completely or not at all; in SI units.

    Parameters
    ----------
    path
        The file, which ends in ``.vtr``; an existing one is replaced.
    grid
        The cells of a layer.
    interfaces
        Depths between the layers, shape (nz + 1,), m; they lie along -z.
    fields
        Values by name, shape (nz, nx, ny).
    """
    file = Path(path)
    if file.suffix != ".vtr":
        raise rc.InputError.about("The name of a file of layers", file.name, "one that ends in .vtr")
    nx, ny = grid.shape
    # Coordinates ascend.
    lines = [*(_list_ends(grid, axis) for axis in (0, 1)), -interfaces[::-1]]
    names = ["x", "y", "z", *fields]
    values = [*lines, *(np.asarray(one, dtype=np.float64)[::-1] for one in fields.values())]
    offsets = np.concatenate(([0], np.cumsum([one.nbytes + _LENGTH_BYTES for one in values])))
    texts = [
        f'<DataArray type="Float64" Name={quoteattr(name)} format="appended" offset="{offset}"/>\n'
        for name, offset in zip(names, offsets.tolist(), strict=False)
    ]
    extent = f"0 {nx} 0 {ny} 0 {len(interfaces) - 1}"
    heading = (
        f'<?xml version="1.0"?>\n<VTKFile type="RectilinearGrid" version="1.0" '
        f'byte_order="{sys.byteorder.capitalize()}Endian" header_type="UInt64">\n'
        f'<RectilinearGrid WholeExtent="{extent}">\n<Piece Extent="{extent}">\n'
        f"<Coordinates>\n{''.join(texts[:3])}</Coordinates>\n<CellData>\n{''.join(texts[3:])}</CellData>\n"
        f'</Piece>\n</RectilinearGrid>\n<AppendedData encoding="raw">\n_'
    )
    with replacing(file) as partial, partial.open("wb") as opened:
        opened.write(heading.encode())
        for one in values:
            opened.write(np.uint64(one.nbytes).tobytes())
            # x varies fastest, then y.
            opened.write(one.swapaxes(-1, -2).tobytes() if one.ndim == 3 else one.tobytes())
        opened.write(b"\n</AppendedData>\n</VTKFile>\n")


def _list_ends(grid: rc.Grid, axis: int) -> Array:
    """Return the ends of the cells along an axis, m."""
    half = 0.5 * grid.size[axis]
    return np.linspace(-half, half, grid.shape[axis] + 1)
