"""The reader of heights in text: tables, images with a header, lists of points, and what some programs write."""

from __future__ import annotations

import gzip
from pathlib import Path

import attrs

from roughcontact._base.archive import bound_expansion
from roughcontact._base.arrays import Array
from roughcontact._base.checks import choice, integer
from roughcontact._parts.files.base import RawMap, SurfaceReader, check_rows, find_foreign, require_memory_of_map
from roughcontact._parts.files.bounds import TEXT_OR_IMAGE
from roughcontact._parts.files.headers import read_header
from roughcontact._parts.files.points import (
    MIN_POINTS,
    put_on_grid,
    read_columns,
    refuse_further_columns,
    require_named_columns,
)
from roughcontact._parts.files.programs import read_program
from roughcontact._parts.files.stated import Stated, build_map, check_no_data, metres
from roughcontact._parts.files.text import SEPARATORS, WORDS, read_table, require_heights, require_no_index
from roughcontact.errors import InputError

# Numbers in a row of a profile x z and of a list of points x y z.
_COLUMNS_OF_PROFILES = 2
_COLUMNS_OF_POINTS = 3
# Ending of compressed text.
_COMPRESSED = ".gz"


def _is_one_unit(one: str, other: str) -> bool:
    """Return whether two names of units, such as with both letters for micro, are of the same unit."""
    return one == other or metres(one) == metres(other) is not None


def _separator(value: str) -> str:
    return choice(value, "The separator of the numbers in a text file", ("auto", *SEPARATORS, *WORDS))


def _decimal(value: str) -> str:
    return choice(value, "The decimal mark of the numbers in a text file", ("auto", ".", ","))


def _skip_rows(value: int) -> int:
    return integer(value, "The number of lines to skip in a text file", at_least=0)


@attrs.frozen
class TextReader(SurfaceReader):
    """A table of numbers, one row for each x; or lines of points x y z, in any order, on a regular grid.

    What the lines of words above the numbers state is used, or refused where it changes the numbers and is not
    understood: sides, steps and counts of an image, whose rows are those of y, downwards; unit and scale of the
    heights; the number of non-measured points; names of columns. Empty fields, ``nan``, ``***`` and ``BAD`` are
    non-measured points; a separator at the end of rows adds none. Surfer's grids, SDF (ISO 25178-71), ASCII files of
    Zygo and Wyko, and Igor's waves are read in their own order.

    Parameters
    ----------
    separator
        Separator of the numbers: ``","``, ``";"``, a tab (or ``"tab"``), white space (``" "`` or ``"blank"``); by
        default it is found.
    decimal
        Decimal mark, ``"."`` or ``","``; by default it is found.
    skip_rows
        Lines at the beginning of the file that are neither heights nor a header to be read.
    rows
        ``"x"`` or ``"y"``: whether a table has a row for each x or for each y, the smallest first; by default x. An
        image with a header, and points x y z, state their axes.
    no_data
        The number that stands for a non-measured point, such as -9999, or ``"none"``; one that looks so is asked about.
    """

    separator: str = attrs.field(default="auto", converter=_separator)
    decimal: str = attrs.field(default="auto", converter=_decimal)
    skip_rows: int = attrs.field(default=0, converter=_skip_rows)
    rows: str = attrs.field(default="auto", converter=check_rows)
    no_data: float | str | None = attrs.field(default=None, converter=check_no_data)

    suffixes = frozenset({".txt", ".csv", ".tsv", ".dat", ".asc", ".xyz", ".prn", ".grd", ".sdf", ".itx", ".gz"})

    def read(self, path: Path) -> RawMap:
        """Return the map."""
        if path.suffix.lower() != _COMPRESSED and (foreign := find_foreign(path)):
            raise InputError(foreign)
        # The text is held twice, and then the map.
        require_memory_of_map(2.0 * path.stat().st_size)
        data = self._unpack(path) if path.suffix.lower() == _COMPRESSED else path.read_bytes()
        # numpy.savetxt writes a number in at most 25 characters; the map is held twice while it is checked.
        require_memory_of_map(16.0 / 25.0 * len(data))
        program = read_program(data, self.rows) if not self.skip_rows else None
        if program is not None:
            return program
        table = read_table(data, self.separator, self.decimal, self.skip_rows)
        stated = read_header(table.header)
        numbers = table.numbers
        count, columns = numbers.shape
        require_named_columns(table.header, columns)
        if count >= MIN_POINTS and columns == _COLUMNS_OF_PROFILES:
            raise InputError(
                f"each of its {count} rows holds 2 numbers, as in a list of points x z of a profile, but a height map "
                "has a row for each x and a number for each y"
            )
        if count >= MIN_POINTS and (columns == _COLUMNS_OF_POINTS or read_columns(numbers, table.header)):
            return self._read_points(numbers, table.header, stated)
        refuse_further_columns(numbers)
        require_no_index(table.header, columns)
        if table.blank is not None:
            raise InputError(
                f"its line {table.blank} between the numbers is blank, as where a second table begins: a blank line "
                "stands behind each row or behind none; keep the heights alone"
            )
        if None in stated.shape:
            require_heights(numbers)
        return build_map(numbers, stated, rows=self.rows, no_data=self.no_data)

    def _unpack(self, path: Path) -> bytes:
        """Return the text in a file that gzip has compressed."""
        if Path(path.stem).suffix.lower() not in self.suffixes - {_COMPRESSED}:
            raise InputError("it is compressed by gzip: unpack it first (gunzip)")
        most = bound_expansion(path.stat().st_size, TEXT_OR_IMAGE)
        with gzip.open(path) as packed:
            data = packed.read(most + 1)
        if len(data) > most:
            raise InputError(f"it expands to more than {most} bytes: unpack it first (gunzip)")
        return data

    def _read_points(self, numbers: Array, header: tuple[str, ...], stated: Stated) -> RawMap:
        """Return the map of a list of points; the units are those of the names of its columns, or of its header."""
        points, units = read_columns(numbers, header) or (numbers, {})
        grid = put_on_grid(points)
        if "x" in units and not _is_one_unit(units["x"], units.get("y", units["x"])):
            raise InputError(f"it states x in {units['x']!a} and y in {units['y']!a}: use one unit for both")
        stated = attrs.evolve(
            stated,
            unit=units.get("z", stated.unit),
            length=units.get("x", stated.length),
            steps=grid.steps or (None, None),
            size=(None, None),
            rows="x",
            falling="",
        )
        raw = build_map(grid.heights, stated, no_data=self.no_data)
        return attrs.evolve(raw, rows="", hint=raw.hint and grid.hint)
