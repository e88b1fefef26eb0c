"""`read_surface`: a height map from a file of any known kind."""

from __future__ import annotations

import contextlib
import inspect
import logging
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from roughcontact._base import checks
from roughcontact._base.arrays import Pair
from roughcontact._base.checks import choice, number, pair
from roughcontact._base.registry import PartField, describe_fields, list_fields
from roughcontact._base.units import Length, si
from roughcontact._parts.files.base import RawMap, SurfaceReader, find_foreign, readers
from roughcontact._parts.files.bounds import HDF5_SIGNATURE
from roughcontact._parts.files.labelled import call_array, read_labelled
from roughcontact._parts.surfaces import TREATMENTS, HeightMap, complete
from roughcontact.errors import InputError, RoughContactError, Sentence, argument, shorten
from roughcontact.errors.door import guarded

_LOGGER = logging.getLogger("roughcontact")
_FALLBACK_READER = "instrument"
# First bytes of files whose ending does not tell the reader: of Zygo, SDF and Surfer in binary, Gwyddion's simple
# fields, MATLAB, and netCDF.
_READERS_BY_BEGINNING = {
    b"\x88\x1b\x03\x6f": _FALLBACK_READER,
    b"\x88\x1b\x03\x70": _FALLBACK_READER,
    b"\x88\x1b\x03\x71": _FALLBACK_READER,
    b"bISO-": _FALLBACK_READER,
    b"bBCR-": _FALLBACK_READER,
    b"DSBB": "surfer",
    b"DSRB": "surfer",
    b"Gwyddion Simpl": "simple-field",
    b"Gwyddion XYZ F": "simple-field",
    b"MATLAB 5.0 MAT": "mat",
    b"CDF\x01": "netcdf",
    b"CDF\x02": "netcdf",
}
# The ending of text files by Surfer and of netCDF by GMT, whose version 4 begins as HDF5 does.
_NETCDF_ENDING = ".grd"
# Characters of a reader's message, and of a line of a file, that ours repeats.
_MAX_REASON_CHARACTERS = 200
_MAX_HINT_CHARACTERS = 60
# Relative difference between a given size and the size in a file: six digits, as people type them.
_SIZE_TOLERANCE = 1e-6
# Relative difference between the proportions of cells and of points in a file: positions are printed with few digits.
_STEP_TOLERANCE = 0.02
# Relative difference of the sides of square cells: sizes are given with three digits.
_SQUARE_CELL_TOLERANCE = 5e-3
# Longest side that a file is believed to state, m: longer ones are in another unit, as of maps of a landscape.
_MAX_SIDE = 1.0


@guarded
def read_surface(
    path: Any,
    *,
    size: Length | Sequence[Length] | None = None,
    cell: Length | Sequence[Length] | None = None,
    non_measured: str = "refuse",
    unit: Length | str | None = None,
    reader: str | SurfaceReader = "auto",
    **options: Any,
) -> HeightMap:
    """Return the height map in a file, or in an array of xarray, m, positive outward.

    Parameters
    ----------
    path
        The file. npz, npy and text files have heights in m, first index x, where they state nothing else; those of
        instruments are read by the package SurfaceTopography. Or a ``xarray.DataArray`` with the axes x and y in any
        order: the size of its map follows from its places along them, which are evenly spaced, and its units from the
        attribute ``units`` of the places and of the heights.
    size
        Sides of the domain (x, y) or of both, m; needed where the file does not state it, and checked
        where it does.
    cell
        Sides of a cell (x, y) or of both, m, in place of the size: the distance of neighbouring points.
    non_measured
        Treatment of non-measured points: ``"refuse"`` the file; ``"fill"`` them with the harmonic surface through
        their neighbours, which makes no new summit; or ``"keep"`` them: they never touch, and do not count when form
        is fitted.
    unit
        Unit of the heights, m, where the file does not state it: 1e-6 or ``"um"`` for micrometres.
    reader
        Registered name or instance; ``"auto"`` chooses by the ending of the file name.
    **options
        Fields of the reader. For text files ``separator=``, ``decimal=`` and ``skip_rows=``: separator and decimal mark
        of the numbers, and how many lines at the beginning are not heights, if they are not found correctly. For text,
        npy and mat files ``rows=``: whether they have a row for each ``"x"``, as is assumed, or for each ``"y"``.
        For text and arrays ``no_data=``: the number of non-measured points, such as -9999, or ``"none"``.

    Raises
    ------
    InputError
        If there is no such file, it or the array cannot be read, non-measured points are refused, size or unit are
        unknown, or only a row for each y would make the cells square, and ``rows=`` is not given.
    MissingPackage
        If the package that reads such files is not installed.

    Examples
    --------
    >>> import roughcontact as rc
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> import numpy as np
    >>> with TemporaryDirectory() as folder:
    ...     path = Path(folder) / "map.txt"
    ...     np.savetxt(path, np.zeros((8, 4)))
    ...     print(rc.read_surface(path, size=(8e-6, 4e-6)).grid)
    8 x 4 cells on 8 µm x 4 µm
    """
    choice(non_measured, "The treatment of non-measured points", TREATMENTS)
    sides: Any = checks.without_unit(size, "The size of the height map", "m")
    meant: Any = checks.without_unit(unit, "The unit of the heights", "m")
    raw, called, named = _read_any(path, reader, options)
    given = _choose_size(_find_size(sides, cell, raw), raw, meant, called)
    _require_fitting(raw, given, called)
    heights, mask, done = complete(raw.heights, f"the {called}", non_measured)
    surface = HeightMap(heights, given, periodic=raw.periodic, non_measured=mask)
    scale = _unit(raw, meant, called)
    told = scale if raw.unit is None else raw.unit
    in_units = f", heights in units of {si(told, 'm')}"
    if unit is None and raw.unit is None:
        in_units = "" if raw.metric else ", heights in m (assumed: unit= says it)"
    in_units += f", {raw.rows}" if raw.rows else ""
    # Free the heights of the file before new ones are made.
    del raw, heights
    values = surface.values if scale == 1.0 else surface.values * scale
    _LOGGER.info("read %s%s: %s%s", named, done, surface.grid, in_units)
    return attrs.evolve(surface, heights=values, history=(f"read from {named}{done}: {surface.grid}{in_units}",))


def _read_any(path: Any, reader: str | SurfaceReader, options: dict[str, Any]) -> tuple[RawMap, str, str]:
    """Return the map in a file or an array, what sentences call that, and its name."""
    if not checks.is_labelled(path):
        file = checks.path(path, "The height map")
        return read_raw(file, reader, **options), f"file {file.name}", file.name
    called = call_array(path)
    if reader != "auto":
        raise InputError(f"The {called} needs no reader: omit {argument('reader')}.")
    no_data = options.pop("no_data", None)
    if options:
        raise InputError.unknown("option of an array with named axes", next(iter(options)), ["no_data"])
    try:
        return read_labelled(path, no_data), called, f"the {called}"
    except InputError as error:
        raise InputError(f"The {called} cannot be used: {error.marked.rstrip('.')}.") from error


@guarded
def read_raw(file: str | Path, reader: str | SurfaceReader = "auto", **options: Any) -> RawMap:
    """Return the map in a file as it is; see `read_surface`."""
    file = checks.path(file, "The height map")
    if not file.is_file():
        raise InputError(f"There is no file {str(file)!r}{' (it is a folder)' if file.is_dir() else ''}.")
    chosen = _make_reader(_reader_for(file) if reader == "auto" else reader, file, options)
    try:
        raw = chosen.read(file)
    # Each broken file fails in its own way; the user needs one sentence.
    except Exception as error:
        explained = _explain(error, file)
        if explained is error:
            raise
        raise explained from error
    if not isinstance(raw, RawMap) or not isinstance(raw.heights, np.ndarray):
        raise InputError(
            f"The reader {chosen!r} must return a RawMap with an array of heights, but returned {raw!r:.80}."
        )
    if raw.heights.size < 2:
        raise InputError(f"The file {file.name} cannot be used: it holds no more than one number, not a height map.")
    return raw


def _explain(error: Exception, file: Path) -> Exception:
    """Return the error for a file that its reader could not read."""
    # Text that was unpacked is known.
    said = error.marked if isinstance(error, InputError) else ""
    foreign = "" if file.suffix.lower() == ".gz" and said else find_foreign(file)
    if foreign or said:
        return InputError(f"The file {file.name} cannot be used: {foreign or said.rstrip('.')}.")
    if isinstance(error, RoughContactError):
        return error
    reason = " ".join(str(error).split()) or type(error).__name__
    return InputError(
        f"The file {file.name} cannot be read as a height map: {shorten(reason, _MAX_REASON_CHARACTERS).rstrip('.')}."
    )


def list_reader_options() -> dict[str, tuple[PartField, str]]:
    """Return the options of all readers by name, each with what the first reader that has it says of it."""
    found: dict[str, tuple[PartField, str]] = {}
    for name in sorted(readers, reverse=True):
        # A broken plug-in must not keep others from reading their files.
        with contextlib.suppress(InputError):
            texts = describe_fields(readers[name])
            for option, field in list_fields(readers[name]).items():
                found.setdefault(option, (field, texts.get(option, "")))
    return found


def options_of(file: Path, reader: str = "auto") -> tuple[str, ...]:
    """Return the names of the options of the reader that reads a file."""
    return tuple(inspect.signature(readers[_reader_for(file) if reader == "auto" else reader]).parameters)


def _make_reader(choice: str | SurfaceReader, file: Path, options: dict[str, Any]) -> SurfaceReader:
    """Return the reader with its options."""
    if not options:
        return readers.resolve(choice)
    if not isinstance(choice, str):
        raise InputError(f"Give {', '.join(options)} to the reader itself, or name the reader.")
    known = options_of(file, choice)
    if unknown := [name for name in options if name not in known]:
        raise InputError.unknown(f"option of the reader {choice!r}, which reads {file.name},", unknown[0], known)
    return readers.create(choice, **options)


def _reader_for(file: Path) -> str:
    suffix = file.suffix.lower()
    start = b""
    with contextlib.suppress(OSError), file.open("rb") as stream:
        start = stream.read(max(map(len, _READERS_BY_BEGINNING)))
    if found := [name for mark, name in _READERS_BY_BEGINNING.items() if start.startswith(mark)]:
        return found[0]
    if suffix == _NETCDF_ENDING and start.startswith(HDF5_SIGNATURE):
        return "netcdf"
    for name in readers:
        # A broken plug-in must not keep others from reading their files.
        with contextlib.suppress(InputError):
            if name != _FALLBACK_READER and suffix in readers.create(name).suffixes:
                return name
    return _FALLBACK_READER


def _require_fitting(raw: RawMap, size: Any, called: str) -> None:
    """Refuse a size that contradicts the points in the file.

    A row for each x does not make the cells square, but one for each y does: the user must say which it is. Or the
    cells have other proportions than the file states, or another side along the one axis of which it states the step.
    """
    if raw.heights.ndim != 2:
        return
    sides = _as_sides(size)
    nx, ny = raw.heights.shape
    cells = (sides[0] / nx, sides[1] / ny)
    turned = (sides[0] / ny, sides[1] / nx)
    is_square = abs(cells[0] / cells[1] - 1.0) <= _SQUARE_CELL_TOLERANCE
    if (
        raw.needs_rows
        and np.size(size) > 1
        and not is_square
        and abs(turned[0] / turned[1] - 1.0) <= _SQUARE_CELL_TOLERANCE
    ):
        raise InputError(
            f"The {called} has {nx} rows of {ny} numbers: on {si(sides[0], 'm')} x {si(sides[1], 'm')}, a row "
            f"for each x makes cells of {si(cells[0], 'm')} x {si(cells[1], 'm')}, a row for each y square ones of "
            f"{si(turned[0], 'm')}. Say which it is: {argument('rows', 'y')}, or {argument('rows', 'x')}."
        )
    # Where no steps are stated, those of the cells contradict nothing.
    steps = raw.steps or cells
    # Steps of one may be counts: then only sides that are exchanged contradict them.
    may_differ = steps == (1.0, 1.0) and abs(turned[1] / turned[0] - 1.0) > _STEP_TOLERANCE
    if abs(cells[0] / cells[1] * steps[1] / steps[0] - 1.0) > _STEP_TOLERANCE and not may_differ:
        raise InputError(
            f"The points in the {called} are {steps[0]:.6g} and {steps[1]:.6g} apart along x and y, but on "
            f"{si(sides[0], 'm')} x {si(sides[1], 'm')} its {nx} x {ny} points would be {si(cells[0], 'm')} and "
            f"{si(cells[1], 'm')} apart: give the sides of x and of y in this order, or name the columns above the "
            "points."
        )
    for axis, side, cell, count, step in zip("xy", sides, cells, (nx, ny), raw.partial, strict=True):
        if step is not None and abs(cell / step - 1.0) > _STEP_TOLERANCE:
            raise InputError(
                f"The points in the {called} are {si(step, 'm')} apart along {axis}, but on a side of {si(side, 'm')} "
                f"its {count} points would be {si(cell, 'm')} apart: give the sides of x and of y in this order, or "
                "leave that statement out."
            )


def _as_sides(size: Length | Sequence[Length]) -> Pair:
    return pair(size, "The size of the height map", "m", above=0.0)


def _find_size(
    size: Length | Sequence[Length] | None, cell: Length | Sequence[Length] | None, raw: RawMap
) -> Length | Sequence[Length] | None:
    """Return the size that is given, or that of the given cells; `InputError` if both are given and differ."""
    if cell is None or raw.heights.ndim != 2:
        return size
    sides = pair(cell, "The cell of the height map", "m", above=0.0)
    nx, ny = raw.heights.shape
    found = (sides[0] * nx, sides[1] * ny)
    if size is not None and not np.allclose(_as_sides(size), found, rtol=_SIZE_TOLERANCE):
        raise InputError(
            f"Cells of {si(sides[0], 'm')} x {si(sides[1], 'm')} make {nx} x {ny} points {si(found[0], 'm')} x "
            f"{si(found[1], 'm')} large, which is not the size given: give {argument('size')} or {argument('cell')} "
            "alone."
        )
    return found


def _choose_size(
    size: Length | Sequence[Length] | None, raw: RawMap, unit: Length | str | None, called: str
) -> Length | Sequence[Length]:
    """Return the size of the map, as given or stated; `InputError` if there is none, or if they differ."""
    if raw.size is not None and max(raw.size) > _MAX_SIDE and size is None:
        raise InputError(
            f"The {called} states sides of {raw.size[0]:g} and {raw.size[1]:g} m, more than "
            f"{_MAX_SIDE:g} m, so that they may be in another unit: give {argument('size', 'x', 'y', unit='m')}."
        )
    if raw.size is not None and max(raw.size) <= _MAX_SIDE:
        if size is not None and not np.allclose(_as_sides(size), raw.size, rtol=_SIZE_TOLERANCE, atol=0.0):
            raise InputError(
                f"The {called} states its own size, {si(raw.size[0], 'm')} x {si(raw.size[1], 'm')}, "
                f"which is not the size given: leave {argument('size')} out."
            )
        return raw.size
    if size is not None:
        return size
    known = f" ({Sentence(raw.hint).marked})" if raw.hint else ""
    # Who looks up the size has the unit at hand too.
    in_metres = unit is None and not raw.metric and not raw.needs_unit
    taken = f" Its heights are taken as m: give {argument('unit', 'um')} too if they are µm." if in_metres else ""
    raise InputError(
        f"The {called} does not state the size of its domain{known}: give "
        f"{argument('size', 'x', 'y', unit='m')}, or "
        f"{argument('cell')}, the distance of its points.{taken}"
    )


def _unit(raw: RawMap, given: float | str | None, called: str) -> float:
    if given is None and raw.needs_unit:
        raise InputError(
            f"The heights in the {called} are numbers without a unit: give what one of them means, m, such as "
            f"{argument('unit', 1e-9, unit='m')}."
        )
    if given is None and raw.unit_hint:
        raise InputError(
            f"The {called} states {shorten(raw.unit_hint.strip(), _MAX_HINT_CHARACTERS)!a}, which may be the "
            f"unit of its heights: give {argument('unit', 'nm')}, for example, or {argument('unit', 1)} if they are "
            "metres."
        )
    if given is None:
        return 1.0
    what = "The unit of the heights"
    if isinstance(given, str):
        # "um" alone is "1um".
        unit = number(f"1{given}" if given[:1].isalpha() else given, what, "m", above=0.0)
    else:
        unit = number(given, what, "m, such as 1e-6 for µm", above=0.0)
    if not raw.metric:
        return unit
    if raw.unit is None or not math.isclose(raw.unit, unit, rel_tol=_SIZE_TOLERANCE):
        raise InputError(f"The {called} states its own unit of height: leave {argument('unit')} out.")
    return 1.0
