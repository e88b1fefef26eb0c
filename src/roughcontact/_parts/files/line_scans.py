"""`read_profile`: line scans from a file."""

from __future__ import annotations

import math
import os
from pathlib import Path

import attrs
import numpy as np

from roughcontact._base import checks
from roughcontact._base.arrays import Array, read_only
from roughcontact._base.checks import choice, integer, number
from roughcontact._base.units import Length, ShownAsPrinted, counted, outlined, si
from roughcontact._parts.files.points import list_names
from roughcontact._parts.files.stated import metres
from roughcontact._parts.files.text import read_table
from roughcontact._parts.surfaces.heightmap import check_history
from roughcontact.errors import InputError, argument
from roughcontact.errors.door import guarded

# Relative difference of steps between places that are evenly spaced: places are printed with few digits.
_STEP_TOLERANCE = 0.02
# Relative difference of a spacing that is given and one that is stated.
_SPACING_TOLERANCE = 1e-3
_MIN_POINTS = 8
_ARRAY_ENDING = ".npy"


@guarded
@attrs.frozen(eq=False)
class LineScans(ShownAsPrinted):
    """Heights along lines of the same spacing, as `read_profile` returns them.

    Attributes
    ----------
    heights
        Shape (lines, points), m, positive outward.
    spacing
        Distance of the points, m.
    history
        Where they come from, in words.
    """

    heights: Array = attrs.field(converter=read_only, repr=outlined)
    spacing: float
    history: tuple[str, ...] = attrs.field(default=(), converter=check_history)

    def __str__(self) -> str:
        lines, points = self.heights.shape
        length = si(points * self.spacing, "m")
        return f"{counted(lines, 'line')} of {points} points, {si(self.spacing, 'm')} apart, {length} long"


@guarded
def read_profile(
    path: str | os.PathLike[str],
    *,
    spacing: Length | None = None,
    unit: Length | str | None = None,
    position_unit: Length | str | None = None,
    separator: str = "auto",
    decimal: str = "auto",
    skip_rows: int = 0,
) -> LineScans:
    """Return the line scans in a text file, or in an array of numpy (npy).

    A file with more rows than columns has a line in each column, another one a line in each row. A first column of even
    positions is not a line; it gives the spacing.

    Parameters
    ----------
    path
        The file.
    spacing
        Distance of the points, m; needed where the file has no positions, and checked where it has.
    unit, position_unit
        Units of heights and positions, m, where the line above the columns does not state them: 1e-6 or ``"um"`` for
        micrometres. Without either they are taken as m.
    separator, decimal, skip_rows
        As for `read_surface`: separator and decimal mark of the numbers, and lines at the beginning that are none.

    Raises
    ------
    InputError
        If there is no such file, it is not a table of numbers, a point has no height, or the spacing is not known.

    Examples
    --------
    >>> import roughcontact as rc
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     path = Path(folder) / "line.csv"
    ...     lines = ["x (mm);z (um)", *(f"{0.001 * k:.3f};{0.1 * (k % 5):.1f}" for k in range(100))]
    ...     _ = path.write_text(chr(10).join(lines))
    ...     print(rc.read_profile(path))
    1 line of 100 points, 1 µm apart, 100 µm long
    """
    file = checks.path(path, "The profile")
    if not file.is_file():
        raise InputError(f"There is no file {str(file)!r}{' (it is a folder)' if file.is_dir() else ''}.")
    integer(skip_rows, "The number of rows to skip", at_least=0)
    choice(decimal, "The decimal mark", ("auto", ".", ","))
    try:
        table, units = _read(file, separator, decimal, skip_rows)
    except InputError as error:
        raise InputError(f"The file {file.name} cannot be used: {error.marked.rstrip('.')}.") from None
    except (OSError, ValueError) as error:
        raise InputError(f"The file {file.name} cannot be read as line scans: {error}.") from error
    in_columns = len(table) >= table.shape[1]
    lines = table.T if in_columns else table
    if lines.shape[1] < _MIN_POINTS:
        raise InputError(
            f"The file {file.name} has lines of {lines.shape[1]} points: at least {_MIN_POINTS} are needed."
        )
    positions = None
    if in_columns and len(lines) > 1 and _is_even(lines[0]):
        positions = lines[0]
        lines = lines[1:]
    missing = int(np.count_nonzero(~np.isfinite(lines)))
    if missing:
        raise InputError(f"In the file {file.name} {missing} points have no height: cut the lines there.")
    named = units if in_columns and len(units) == table.shape[1] else [""] * table.shape[1]
    scale, told = _find_unit(named[-1], unit, "unit", "heights", file)
    step = None if spacing is None else number(spacing, "The spacing of the points", "m", above=0.0)
    if positions is not None:
        length, _ = _find_unit(named[0], position_unit, "position_unit", "positions", file)
        found = length * float(positions[-1] - positions[0]) / (positions.size - 1)
        if step is not None and not math.isclose(found, step, rel_tol=_SPACING_TOLERANCE):
            raise InputError(
                f"The points in {file.name} are {si(found, 'm')} apart, which is not the spacing given: omit "
                f"{argument('spacing')}, or give {argument('position_unit', 'mm')}."
            )
        step = found
    elif position_unit is not None:
        raise InputError(f"The file {file.name} has no positions: omit {argument('position_unit')}.")
    if step is None:
        raise InputError(
            f"The file {file.name} does not state the positions of its points: give "
            f"{argument('spacing', unit='m')}, their distance."
        )
    made = LineScans(lines * scale, step)
    return attrs.evolve(made, history=(f"read from {file.name}: {made}, heights in {told}",))


def _read(file: Path, separator: str, decimal: str, skip_rows: int) -> tuple[Array, list[str]]:
    """Return the numbers of a file, shape (rows, columns), and the units that the names of its columns have."""
    if file.suffix.lower() == _ARRAY_ENDING:
        array = np.load(file, allow_pickle=False)
        if array.dtype.kind not in "fiu" or array.ndim not in (1, 2) or not array.size:
            raise InputError("it must hold numbers of shape (points,), (points, lines) or (lines, points)")
        return np.asarray(array.reshape(len(array), -1), dtype=np.float64), []
    table = read_table(file.read_bytes(), separator, decimal, skip_rows)
    columns = table.numbers.shape[1]
    for line in reversed(table.header):
        for names in list_names(line):
            if len(names) == columns:
                return table.numbers, [unit for _, unit in names]
    return table.numbers, []


def _is_even(positions: Array) -> bool:
    """Return whether numbers rise by equal steps."""
    steps = np.diff(positions)
    mean = float(steps.mean())
    return bool(mean > 0.0 and np.abs(steps - mean).max() <= _STEP_TOLERANCE * mean)


def _find_unit(stated: str, given: Length | str | None, name: str, what: str, file: Path) -> tuple[float, str]:
    """Return the unit of heights or positions, m, and the same in words."""
    known = metres(stated) if stated else None
    if given is None:
        return (1.0, "m (assumed: unit= says it)") if known is None else (known, stated)
    text = f"1{given}" if isinstance(given, str) and given[:1].isalpha() else given
    unit = number(text, f"The unit of the {what}", "m", above=0.0)
    if known is not None and not math.isclose(known, unit, rel_tol=_SPACING_TOLERANCE):
        raise InputError(f"The file {file.name} states its own unit of the {what}: omit {argument(name)}.")
    return unit, si(unit, "m")
