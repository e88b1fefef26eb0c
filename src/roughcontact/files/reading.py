"""`read_surface`: a height map from a file of any known kind."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Sequence
from pathlib import Path

import attrs
import numpy as np

from roughcontact.checks import Array, Mask, choice, number
from roughcontact.errors import InputError, RoughContactError
from roughcontact.files.base import RawMap, SurfaceReader
from roughcontact.files.missing import filled
from roughcontact.registry import readers
from roughcontact.surfaces import HeightMap
from roughcontact.units import si

_TREATED = {"fill": "filled from their neighbours", "holes": "taken as holes"}
_FALLBACK = "instrument"


def read_surface(
    path: str | os.PathLike[str],
    *,
    size: float | Sequence[float] | None = None,
    missing: str = "refuse",
    unit: float | None = None,
    reader: str | SurfaceReader = "auto",
) -> HeightMap:
    """Read a height map from a file.

    Parameters
    ----------
    path
        The file. npz, npy and text files are read by numpy, heights in m, first index x; all others
        by the package SurfaceTopography, units converted to SI.
    size
        Sides of the domain (x, y) or of both, m; needed where the file does not tell, and checked
        where it does.
    missing
        What to do with missing points: ``"refuse"`` them, ``"fill"`` them with the harmonic surface
        through their neighbours, which makes no new summit, or take them as ``"holes"``, which do not
        touch and do not count when form is fitted.
    unit
        What a height of one in the file means, m, where the file does not tell: 1e-6 for micrometres.
    reader
        Registered name or instance; ``"auto"`` goes by the ending of the file name.

    Returns
    -------
    HeightMap
        The heights, m, positive outward.

    Raises
    ------
    InputError
        If there is no such file, it cannot be read, points are missing and refused, or the size is
        neither given nor told.
    MissingPackage
        If the package that reads such files is not installed.
    """
    choice(missing, "The treatment of missing points", ("refuse", *_TREATED))
    file = Path(path)
    raw = read_raw(file, reader)
    if raw.size is None and size is None:
        raise InputError(f"The file {file.name} does not tell the size of its domain: give size=(x, y), m.")
    heights, holes, done = _complete(raw, file, missing)
    surface = HeightMap(heights, _size(raw, size), periodic=raw.periodic, holes=holes)
    metres = surface.values * _unit(raw, unit, file)
    counted = "" if unit is None else f", heights in units of {si(unit, 'm')}"
    surface = attrs.evolve(surface, heights=metres, history=(f"{done}: {surface.grid}{counted}",))
    if raw.size is not None and not np.allclose(surface.size, raw.size, rtol=1e-6, atol=0.0):
        raise InputError(
            f"The file {file.name} tells its own size, {si(raw.size[0], 'm')} x {si(raw.size[1], 'm')}, "
            f"which is not the size given: leave size= out."
        )
    return surface


def read_raw(file: Path, reader: str | SurfaceReader = "auto") -> RawMap:
    """Return the map as it stands in a file; see `read_surface`."""
    if not file.is_file():
        raise InputError(f"There is no file {str(file)!r}{' (it is a folder)' if file.is_dir() else ''}.")
    chosen: SurfaceReader = readers.resolve(_reader_for(file) if reader == "auto" else reader, SurfaceReader)
    return _read(chosen, file)


def _reader_for(file: Path) -> str:
    suffix = file.suffix.lower()
    for name in readers.names():
        # A broken plug-in must not keep others from reading their files.
        with contextlib.suppress(InputError):
            if name != _FALLBACK and suffix in readers.create(name).suffixes:
                return name
    return _FALLBACK


def _size(raw: RawMap, given: float | Sequence[float] | None) -> float | Sequence[float]:
    if given is not None:
        return given
    return raw.size if raw.size is not None else 0.0


def _read(reader: SurfaceReader, file: Path) -> RawMap:
    try:
        raw = reader.read(file)
    except InputError as error:
        raise InputError(f"The file {file.name} cannot be used: {error}.") from error
    except RoughContactError:
        raise
    # Readers fail in as many ways as there are broken files; the user needs one sentence.
    except Exception as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        raise InputError(f"The file {file.name} cannot be read as a height map: {reason[:200]}.") from error
    if not isinstance(raw, RawMap) or not isinstance(raw.heights, np.ndarray):
        raise InputError(
            f"The reader {reader!r} must return a RawMap with an array of heights, but returned {raw!r:.80}."
        )
    return raw


def _unit(raw: RawMap, given: float | None, file: Path) -> float:
    if given is None:
        return 1.0
    if raw.metric:
        raise InputError(f"The file {file.name} tells its own unit of height: leave unit= out.")
    return number(given, "The unit of the heights", "m", above=0.0)


def _complete(raw: RawMap, file: Path, missing: str) -> tuple[Array, Mask | None, str]:
    """Return heights without gaps, the holes if they are to be kept, and what was done."""
    heights, read = raw.heights, f"read from {file.name}"
    if heights.dtype.kind != "f" or heights.ndim != 2:
        return heights, None, read
    absent = ~np.isfinite(heights)
    count = int(np.count_nonzero(absent))
    if count == 0:
        return heights, None, read
    share = f"{count} of {heights.size} points"
    if count == heights.size:
        raise InputError(f"The file {file.name} holds no valid point at all.")
    if missing == "refuse":
        raise InputError(
            f"The file {file.name} misses {share}: fill them from their neighbours with missing='fill', "
            "or take them as holes with missing='holes' (on the command line --missing)."
        )
    done = f"{read}, {share} missing and {_TREATED[missing]}"
    return filled(heights), absent if missing == "holes" else None, done
