"""Files of instruments, read by the package SurfaceTopography after what they declare has been checked."""

from __future__ import annotations

import re
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from roughcontact._base.arrays import Array
from roughcontact._base.units import si
from roughcontact._parts.files.base import (
    RawMap,
    SurfaceReader,
    find_foreign,
    name_rows,
    readers,
    require_memory_of_map,
    turn_up,
)
from roughcontact._parts.files.bounds import require_bounded, require_room
from roughcontact._parts.surfaces import read_topography
from roughcontact.errors import InputError, RoughContactError, requiring, shorten

# Endings of files that need no instrument's reader.
_ENDINGS = ".npz, .npy, .txt, .csv, .tsv, .dat, .asc, .xyz, .prn, .x3p, .mat"
# Largest difference of heights, m: more is another unit than the file states.
_MAX_DIFFERENCE = 1.0
# Names of channels that hold no heights, though some are in a unit of length, as a cantilever's bending.
_NO_HEIGHTS = re.compile(r"(?i)phase|amplitude|error|deflection|friction|lateral|current|potential|intensity")
# Formats of SurfaceTopography, by its names, that are read here: there, what they state of themselves is not.
_OWN_READERS = {"asc": "txt", "xyz": "txt", "npy": "npy", "npz": "npz", "h5": "hdf5", "nc": "netcdf"}
# Formats of which a file may have any first bytes, with the endings by which they are known instead. The reader of
# MATLAB's files would allocate what any of them declares; ours reads those, so that it has none.
_ENDINGS_OF_GREEDY = {"hgt": ".hgt", "ibw": ".ibw", "mat": "none"}
# Formats whose first line is the upper one, as in the texts of Gwyddion and SPIP, and as Gwyddion shows it;
# SurfaceTopography puts it at y = 0.
_DOWNWARDS = {"gwy", "bcr"}
# First bytes by which a format is recognised, characters of a reason that a message repeats, and words in one that only
# users of the other package understand.
_MAGIC_BYTES = 512
_MAX_REASON_CHARACTERS = 120
_WORDS = re.compile("[A-Za-z]{3,} [A-Za-z]{2,}")
_FOREIGN_WORDS = re.compile(
    r"(?i)[=`{}\n]|argument|keyword|\binfo\b|dict|codec|parameter|index|attribute|\bNone\b|\w_\w"
)


@attrs.frozen
class InstrumentReader(SurfaceReader):
    """Some forty instruments' formats (Sensofar, Zygo, Wyko, SUR, ...), read by the package SurfaceTopography.

    It is tried on every ending that no other reader claims. Of several channels the first with heights is read, which
    the history names. SurfaceTopography is not among the extras, because a package it needs (igor2) is under the LGPL.
    """

    suffixes = frozenset[str]()

    def read(self, path: Path) -> RawMap:
        """Return the map; raise `MissingPackage` if SurfaceTopography is not installed."""
        # SurfaceTopography searches all of a file of an unknown format, for minutes if it is large.
        if foreign := find_foreign(path):
            raise InputError(foreign)
        require_bounded(path)
        found = _open(path)
        if found.format() in _OWN_READERS:
            return readers.create(_OWN_READERS[found.format()]).read(path)
        channel, note = _choose_channel(found, path.stat().st_size)
        try:
            raw = _read_channel(channel, note)
            return _turn_image(raw) if found.format() in _DOWNWARDS else raw
        except (RoughContactError, MemoryError):
            raise
        # Each broken file fails in its own way.
        except Exception as error:
            raise InputError(f"its heights cannot be read{_quote(str(error))}: it is damaged, or incomplete") from error


def _open(path: Path) -> Any:
    """Return what SurfaceTopography knows of a file before it reads heights."""
    advice = (
        f"Reading {path.name} needs the package SurfaceTopography: pip install SurfaceTopography. "
        f"Files {_ENDINGS} are read without it, .tif by 'roughcontact[files]' and .h5 by 'roughcontact[store]'."
    )
    # Its imports warn of optional parallel packages.
    with requiring(advice), warnings.catch_warnings(action="ignore"):
        from SurfaceTopography import open_topography
    sure, possible = _find_kinds(path)
    reasons: list[str] = []
    for kind in sure or possible:
        # Each broken file fails in its own way.
        try:
            found = open_topography(str(path), format=kind.format())
            if found.channels:
                return found
        except Exception as error:
            reasons.append(str(error))
    raise InputError(_explain(sure, reasons))


def _find_kinds(path: Path) -> tuple[list[Any], list[Any]]:
    """Return the readers of SurfaceTopography as whose files a file surely, and as whose it possibly begins."""
    from SurfaceTopography.IO import MagicMatch
    from SurfaceTopography.IO import readers as known

    with path.open("rb") as stream:
        start = stream.read(_MAGIC_BYTES)
    ending = path.suffix.lower()
    allowed = [reader for reader in known if _ENDINGS_OF_GREEDY.get(reader.format(), ending) == ending]
    sure, possible = (
        [reader for reader in allowed if reader.can_read(start) is match]
        for match in (MagicMatch.YES, MagicMatch.MAYBE)
    )
    return sure, possible


def _explain(kinds: Sequence[Any], reasons: Sequence[str]) -> str:
    """Return why no reader took a file: the reason of the format as which it begins."""
    if kinds:
        return (
            f"it begins as files of {kinds[0].name()} do, but cannot be read{_quote(next(iter(reasons), ''))}: it is "
            "damaged, or of a revision that is not known; export it again, or its heights as text"
        )
    return (
        f"its content fits none of the formats that are read, which are those of {_ENDINGS}, .h5, .tif and of "
        "instruments (.al3d, .opd, .plu, .sur, ...): it is of another kind, or damaged"
    )


def _quote(reason: str) -> str:
    """Return the reason of another package in brackets, where users of this one understand it."""
    text = " ".join(reason.split()).rstrip(".")
    if not _WORDS.search(text) or _FOREIGN_WORDS.search(reason.strip()):
        return ""
    return f" ({shorten(text[0].lower() + text[1:], _MAX_REASON_CHARACTERS)})"


def _choose_channel(reader: Any, size: int) -> tuple[Any, str]:
    """Return the channel to read from a file of so many bytes, and in words which it is of several."""
    maps = [one for one in reader.channels if one.dim == 2]
    if not maps:
        raise InputError("it holds a line profile, not a height map")
    # The numbers of a channel of heights have the unit of its sides, or none; others have a pair of units.
    plain = [one for one in maps if one.is_height_channel and (one.unit is None or isinstance(one.unit, str))]
    found = [one for one in plain if not _NO_HEIGHTS.search(one.name)]
    if not found:
        names = ", ".join(one.name for one in maps)
        raise InputError(f"it holds no heights, but {names:.100}: export its topography")
    default = reader.default_channel
    chosen = next((one for one in found if one.index == default.index), found[0])
    nx, ny = chosen.nb_grid_pts
    require_room(8 * nx * ny, size, f"it declares {nx} x {ny} points, more")
    # Numbers as they stand in the file, as heights, and these in metres.
    require_memory_of_map(24.0 * nx * ny)
    return chosen, f"channel {chosen.name!r} of {len(maps)}" if len(maps) > 1 else ""


def _read_channel(channel: Any, note: str) -> RawMap:
    if channel.physical_sizes is None:
        topography = channel.topography(physical_sizes=tuple(map(float, channel.nb_grid_pts)))
    else:
        topography = channel.topography()
    if topography.unit is None:
        heights = np.ma.filled(np.ma.asarray(topography.heights(), dtype=np.float64), np.nan)
        return RawMap(heights, hint=_name_sides(channel.physical_sizes), needs_unit=True, rows=note)
    heights, sides, periodic = read_topography(topography)
    size = None if channel.physical_sizes is None else sides
    return RawMap(_require_heights(heights), size, periodic, metric=True, rows=note)


def _turn_image(raw: RawMap) -> RawMap:
    """Return a map whose first line is the upper one with y upwards."""
    notes = filter(None, (raw.rows, name_rows("y", downwards=True)))
    return attrs.evolve(raw, heights=turn_up(raw.heights, "y"), rows=", ".join(notes))


def _name_sides(sides: Any) -> str:
    if sides is None:
        return ""
    return f"its sides are {' x '.join(f'{float(side):g}' for side in sides)} in a unit that it does not state"


def _require_heights(heights: Array) -> Array:
    """Refuse heights that no map has: their unit is wrong."""
    known = heights[np.isfinite(heights)]
    if known.size and np.ptp(known) > _MAX_DIFFERENCE:
        raise InputError(
            f"its heights differ by {si(float(np.ptp(known)), 'm')}, which no instrument measures: its unit is wrong; "
            "export them as text"
        )
    return heights
