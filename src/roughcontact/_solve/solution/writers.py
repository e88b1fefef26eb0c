"""Writers of solutions into files: the base class, the registry, archives and VTK."""

from __future__ import annotations

import abc
import sys
from pathlib import Path
from typing import Any, ClassVar, final

import attrs
import numpy as np

from roughcontact._base.archive import replacing
from roughcontact._base.arrays import RealArray
from roughcontact._base.checks import Part
from roughcontact._base.registry import Registry
from roughcontact._parts.grid import Grid
from roughcontact._solve.solution import storage
from roughcontact._solve.solution.answers import ContactAnswers
from roughcontact._solve.solution.storage import list_added, scalars_of
from roughcontact.errors import InputError, MissingPackage

_FIELDS = ("pressure", "gap", "initial_gap", "displacement")
_MASKS = ("contact", "saturated", "non_measured")
_VTK_TYPES = {np.dtype(np.float64): "Float64", np.dtype(np.uint8): "UInt8"}
# Bytes of the length that precedes each array.
_LENGTH_BYTES = 8


class SolutionWriter(Part, abc.ABC):
    """A writer of one kind of file. Subclass it and register it in ``roughcontact.writers``.

    Examples
    --------
    >>> import numpy as np
    >>> import roughcontact as rc
    >>> class Text(rc.SolutionWriter):
    ...     suffixes = frozenset({".txt"})
    ...
    ...     def write(self, solution, path):
    ...         np.savetxt(path, solution.pressure)
    >>> ".txt" in Text().suffixes
    True
    """

    # Whether it writes solutions that are divided among processes, each process its part, instead of whole ones.
    divided: ClassVar[bool] = False

    @property
    @abc.abstractmethod
    def suffixes(self) -> frozenset[str]:
        """The endings of the file names that it writes, lower case, with the dot; an empty one is a folder."""

    @abc.abstractmethod
    def write(self, solution: Any, path: Path) -> None:
        """Write the file, completely or not at all."""


writers = Registry(SolutionWriter, "solution writer", "roughcontact.writers", in_files=False)


@final
@attrs.frozen
class ArchiveWriter(SolutionWriter):
    """Arrays for numpy, or netCDF with units, with the problem; `ContactSolution.load` reads both."""

    @property
    def suffixes(self) -> frozenset[str]:
        """Npz and nc."""
        return frozenset({".npz", ".nc"})

    def write(self, solution: Any, path: Path) -> None:
        """Write the file."""
        storage.write(path, solution)


def write_solution(solution: ContactAnswers, path: Path) -> None:
    """Write a solution in the format that the ending of the file names."""
    # Endings of this package are found without loading plug-ins.
    names = sorted(writers, key=lambda name: path.suffix != f".{name}")
    known: set[str] = set()
    for name in names:
        writer = writers.create(name)
        if writer.divided is solution.parts.is_whole:
            continue
        if path.suffix in writer.suffixes:
            writer.write(solution, path)
            return
        known |= writer.suffixes
    folder = " or that of a folder" if "" in known else ""
    allowed = f"one ending in {', '.join(sorted(known - {''}))}{folder}"
    raise InputError.about("The name of a solution's file", path.name, allowed)


def describe_as_data(solution: ContactAnswers) -> dict[str, Any]:
    """Return a solution as plain data; see `ContactSolution.to_dict`."""
    # The problem, which it states, stands above the solution.
    writer: Any = writers.create("json")
    described: dict[str, Any] = writer.describe(solution)
    return described


@final
@attrs.frozen
class VtiWriter(SolutionWriter):
    """Image data for ParaView and VTK: the fields on the cells, the scalars as field data, all in SI units.

    It needs no package of VTK, which takes 560 MB: the format is a heading in XML, then the arrays.
    """

    @property
    def suffixes(self) -> frozenset[str]:
        """Vti."""
        return frozenset({".vti"})

    def write(self, solution: Any, path: Path) -> None:
        """Write the file."""
        cells = cells_of(solution)
        numbers = {name: np.array([value]) for name, value in scalars_of(solution).items()}
        with replacing(path) as partial, partial.open("wb") as file:
            file.write(_heading(solution.grid, numbers, cells).encode())
            for values in (*numbers.values(), *cells.values()):
                file.write(np.uint64(values.nbytes).tobytes())
                # x varies fastest.
                file.write(values.tobytes(order="F"))
            file.write(b"\n</AppendedData>\n</VTKFile>\n")


def cells_of(solution: ContactAnswers) -> dict[str, RealArray]:
    """Return the fields of a solution by name, shape (nx, ny): float64, masks as uint8.

    They include the heights of the bodies, m, if the problem is known; heights of a flat counterbody are omitted.
    """
    fields: dict[str, RealArray] = {name: getattr(solution, name) for name in _FIELDS}
    masks = {name: getattr(solution, name) for name in _MASKS}
    fields |= {name: mask.astype(np.uint8) for name, mask in masks.items() if mask is not None}
    fields |= {name: np.ascontiguousarray(values) for name, (values, _, _) in list_added(solution).items()}
    try:
        bodies = {} if solution.origin is None else solution.origin.problem
    except InputError:
        bodies = {}
    for name, key in (("heights", "body"), ("counterbody_heights", "counterbody")):
        heights = np.asarray(bodies[key].surface.heights(solution.grid)) if key in bodies else np.zeros(1)
        if np.ptp(heights) > 0.0:
            fields[name] = heights
    return fields


def to_pyvista(solution: ContactAnswers) -> Any:
    """Return the solution as `pyvista.ImageData`; see `ContactSolution.to_pyvista`."""
    try:
        import pyvista
    except ImportError:
        raise MissingPackage("Views in three dimensions need pyvista: pip install 'roughcontact[vtk]'.") from None
    grid = solution.grid
    image = pyvista.ImageData(
        dimensions=(grid.shape[0] + 1, grid.shape[1] + 1, 1), spacing=_spacing(grid), origin=_origin(grid)
    )
    for name, values in cells_of(solution).items():
        image.cell_data[name] = values.ravel(order="F")
    for name, value in scalars_of(solution).items():
        image.field_data[name] = [value]
    return image


def _spacing(grid: Grid) -> tuple[float, float, float]:
    # A plane of cells has no thickness, but VTK needs a spacing.
    return (*grid.spacing, min(grid.spacing))


def _origin(grid: Grid) -> tuple[float, float, float]:
    return -0.5 * grid.size[0], -0.5 * grid.size[1], 0.0


def _heading(grid: Grid, numbers: dict[str, RealArray], cells: dict[str, RealArray]) -> str:
    """Return the XML up to the first byte of the arrays."""
    from xml.sax.saxutils import quoteattr

    offset = 0
    lines = {"numbers": "", "cells": ""}
    for group, arrays, tuples in (("numbers", numbers, ' NumberOfTuples="1"'), ("cells", cells, "")):
        for name, values in arrays.items():
            kind = f"type={quoteattr(_VTK_TYPES[values.dtype])} Name={quoteattr(name)}{tuples}"
            lines[group] += f'<DataArray {kind} format="appended" offset="{offset}"/>\n'
            offset += _LENGTH_BYTES + values.nbytes
    extent = f"0 {grid.shape[0]} 0 {grid.shape[1]} 0 0"
    origin, spacing = (" ".join(map(repr, values)) for values in (_origin(grid), _spacing(grid)))
    order = f"{sys.byteorder.capitalize()}Endian"
    return (
        f'<?xml version="1.0"?>\n<VTKFile type="ImageData" version="1.0" byte_order="{order}" header_type="UInt64">\n'
        f'<ImageData WholeExtent="{extent}" Origin="{origin}" Spacing="{spacing}">\n'
        f"<FieldData>\n{lines['numbers']}</FieldData>\n"
        f'<Piece Extent="{extent}">\n<CellData Scalars="pressure">\n{lines["cells"]}</CellData>\n</Piece>\n'
        f'</ImageData>\n<AppendedData encoding="raw">\n_'
    )
