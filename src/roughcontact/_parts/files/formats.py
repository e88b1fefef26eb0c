"""The readers of numpy's files and of plain text: heights in metres, indexed [x, y]."""

from __future__ import annotations

from pathlib import Path

import attrs
import numpy as np

from roughcontact._base.archive import read_npy, read_npz
from roughcontact._base.arrays import Array
from roughcontact._base.checks import choice, integer
from roughcontact._parts.files.base import (
    RawMap,
    SurfaceReader,
    check_rows,
    name_rows,
    put_x_first,
    require_memory_of_map,
)
from roughcontact._parts.files.headers import Stated, apply_non_measured, read_header
from roughcontact._parts.files.named import STATING_NAMES, NamedArray, gather
from roughcontact._parts.files.points import order_columns, put_on_grid, refuse_further_columns
from roughcontact._parts.files.stated import build_map
from roughcontact._parts.files.text import SEPARATORS, WORDS, read_table, require_heights
from roughcontact.errors import InputError

# Numbers in a row of a profile x z and of a list of points x y z, and the minimum rows of such a list: 3 x 3 points.
_COLUMNS_OF_PROFILES = 2
_COLUMNS_OF_POINTS = 3
_MIN_LIST_ROWS = 9


@attrs.frozen
class NpzReader(SurfaceReader):
    """``numpy.savez(path, heights=..., size=(lx, ly), periodic=...)``; size and periodic are optional.

    `size` may be replaced by `dx` and `dy`; a `unit` of the heights, such as ``"um"`` or 1e-6, is used.
    """

    @property
    def suffixes(self) -> frozenset[str]:
        """Npz."""
        return frozenset({".npz"})

    def read(self, path: Path) -> RawMap:
        """Return the map."""
        require_memory_of_map(2.0 * path.stat().st_size)
        with path.open("rb") as file:
            data = read_npz(file, {"heights", "size", "periodic"} | STATING_NAMES, deflated=True)
        if "heights" not in data:
            raise InputError("it holds no array named 'heights'")
        heights = data.pop("heights")
        size = data.get("size")
        periodic = data.pop("periodic", np.array(False))
        if size is not None and (size.dtype.kind not in "iuf" or size.shape not in ((), (1,), (2,))):
            raise InputError(
                f"its array 'size' must hold one length or two, m, but has {size.dtype} of shape {size.shape}"
            )
        if size is not None and size.size == 1 and len(set(heights.shape)) > 1:
            raise InputError(
                f"its array 'size' must hold both sides, m, of a map of shape {heights.shape}, but holds one"
            )
        if periodic.size != 1 or periodic.dtype.kind not in "biu":
            raise InputError(
                f"its 'periodic' must be True or False, but has {periodic.dtype} of shape {periodic.shape}"
            )
        if heights.ndim != 2 or heights.dtype.kind not in "biuf":
            # What is no map is refused by `read_surface`, with its shape.
            lx, ly = np.broadcast_to(1.0 if size is None else size, 2).tolist()
            return RawMap(heights, (lx, ly), metric=True)
        arrays = {name: NamedArray(one) for name, one in data.items() if one.dtype.kind in "biuf"}
        texts = {name: str(one.item()) for name, one in data.items() if one.dtype.kind == "U" and one.size == 1}
        stated = attrs.evolve(gather(NamedArray(heights), arrays, texts), rows="x", periodic=bool(periodic))
        # Without a unit they are metres.
        found = build_map(heights, stated, line="the first index")
        return attrs.evolve(found, metric=True)


@attrs.frozen
class NpyReader(SurfaceReader):
    """``numpy.save(path, heights)``.

    Parameters
    ----------
    rows
        ``"x"`` or ``"y"``: the axis of the first index, the smallest first; by default x.
    """

    rows: str = attrs.field(default="auto", converter=check_rows)

    @property
    def suffixes(self) -> frozenset[str]:
        """Npy."""
        return frozenset({".npy"})

    def read(self, path: Path) -> RawMap:
        """Return the map."""
        require_memory_of_map(2.0 * path.stat().st_size)
        with path.open("rb") as file:
            heights = read_npy(file, path.stat().st_size)
        needs_rows = self.rows == "auto"
        rows = name_rows("x" if needs_rows else self.rows, assumed=needs_rows)
        return RawMap(put_x_first(heights, self.rows), needs_rows=needs_rows, rows=rows)


def _require_shape(heights: Array, stated: Stated) -> None:
    """Refuse numbers of another shape than a header states."""
    columns, rows = stated.shape
    if (rows or heights.shape[0], columns or heights.shape[1]) != heights.shape:
        raise InputError(
            f"its header states {columns} columns and {rows} rows, but it holds {heights.shape[1]} and "
            f"{heights.shape[0]}: it is damaged, or holds more than one table"
        )


def _separator(value: str) -> str:
    return choice(value, "The separator of the numbers in a text file", ("auto", *SEPARATORS, *WORDS))


def _decimal(value: str) -> str:
    return choice(value, "The decimal mark of the numbers in a text file", ("auto", ".", ","))


def _skip_rows(value: int) -> int:
    return integer(value, "The number of lines to skip in a text file", at_least=0)


@attrs.frozen
class TextReader(SurfaceReader):
    """A table of numbers, one row for each x; or lines of points x y z, in any order, on a regular grid.

    Lines of words above the numbers and what follows ``#`` are skipped. Empty fields, ``nan``, ``***`` and ``BAD`` are
    non-measured points; a separator at the end of rows adds none. Where the header states width and height of an image,
    as Gwyddion writes them, it is read, and the rows are those of the image: y, downwards.

    Parameters
    ----------
    separator
        Separator of the numbers: ``","``, ``";"``, a tab (or ``"tab"``), white space (``" "`` or ``"blank"``); by
        default it is found.
    decimal
        Decimal mark, ``"."`` or ``","``; by default it is found.
    skip_rows
        Lines at the beginning of the file that are not heights, if they are not skipped automatically.
    rows
        ``"x"`` or ``"y"``: whether a table has a row for each x or for each y, the smallest first; by default x. An
        image with a header, and points x y z, state their axes.
    """

    separator: str = attrs.field(default="auto", converter=_separator)
    decimal: str = attrs.field(default="auto", converter=_decimal)
    skip_rows: int = attrs.field(default=0, converter=_skip_rows)
    rows: str = attrs.field(default="auto", converter=check_rows)

    @property
    def suffixes(self) -> frozenset[str]:
        """Txt, csv, tsv, dat, asc, xyz and prn."""
        return frozenset({".txt", ".csv", ".tsv", ".dat", ".asc", ".xyz", ".prn"})

    def read(self, path: Path) -> RawMap:
        """Return the map."""
        # numpy.savetxt writes a number in at most 25 characters; the map is held twice while it is checked.
        require_memory_of_map(16.0 / 25.0 * path.stat().st_size)
        table = read_table(path, self.separator, self.decimal, self.skip_rows)
        stated = read_header(table.header)
        heights = apply_non_measured(table.numbers, stated)
        if heights.shape[0] >= _MIN_LIST_ROWS and heights.shape[1] == _COLUMNS_OF_PROFILES:
            raise InputError(
                f"each of its {heights.shape[0]} rows holds 2 numbers, as in a list of points x z of a profile, but a "
                "height map has a row for each x and a number for each y"
            )
        if heights.shape[0] >= _MIN_LIST_ROWS and heights.shape[1] == _COLUMNS_OF_POINTS:
            return put_on_grid(order_columns(heights, table.header))
        refuse_further_columns(heights)
        _require_shape(heights, stated)
        require_heights(heights)
        if stated.unit is not None:
            heights = heights * stated.unit
        metric = stated.unit is not None
        if not stated.is_image:
            needs_rows = self.rows == "auto"
            rows = name_rows("x" if needs_rows else self.rows, assumed=needs_rows)
            return RawMap(put_x_first(heights, self.rows), metric=metric, needs_rows=needs_rows, rows=rows)
        if self.rows == "x":
            raise InputError("its header states width and height of an image, whose rows are those of y: omit rows=")
        steps = None if stated.step is None else (stated.step, stated.step)
        # An image has y downwards.
        image = put_x_first(heights[::-1], "y")
        return RawMap(image, stated.size, metric=metric, steps=steps, rows=name_rows("y", downwards=True))
