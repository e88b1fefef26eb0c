"""`read_surface`: a height map from a file of any known kind."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from roughcontact.checks import choice
from roughcontact.errors import InputError, RoughContactError
from roughcontact.files.base import RawMap, SurfaceReader
from roughcontact.files.missing import filled
from roughcontact.registry import readers
from roughcontact.surfaces import HeightMap
from roughcontact.units import si

_FALLBACK = "instrument"


def read_surface(
    path: str | os.PathLike[str],
    *,
    size: float | Sequence[float] | None = None,
    missing: str = "refuse",
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
        What to do with missing points: ``"refuse"`` them, or ``"fill"`` them with the harmonic
        surface through their neighbours, which makes no new summit.
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
    choice(missing, "The treatment of missing points", ("refuse", "fill"))
    file = Path(path)
    if not file.is_file():
        raise InputError(f"There is no file {str(file)!r}{' (it is a folder)' if file.is_dir() else ''}.")
    chosen: SurfaceReader = readers.resolve(_reader_for(file) if reader == "auto" else reader, SurfaceReader)
    raw = _read(chosen, file)
    if raw.size is None and size is None:
        raise InputError(f"The file {file.name} does not tell the size of its domain: give size=(x, y), m.")
    surface = HeightMap(_complete(raw.heights, file, missing), _size(raw, size), periodic=raw.periodic)
    if raw.size is not None and not np.allclose(surface.size, raw.size, rtol=1e-6, atol=0.0):
        raise InputError(
            f"The file {file.name} tells its own size, {si(raw.size[0], 'm')} x {si(raw.size[1], 'm')}, "
            f"which is not the size given: leave size= out."
        )
    return surface


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


def _complete(heights: np.ndarray, file: Path, missing: str) -> np.ndarray:
    if heights.dtype.kind != "f" or heights.ndim != 2:
        return heights
    holes = int(heights.size - np.count_nonzero(np.isfinite(heights)))
    if holes == 0:
        return heights
    if holes == heights.size:
        raise InputError(f"The file {file.name} holds no valid point at all.")
    if missing == "refuse":
        raise InputError(
            f"The file {file.name} misses {holes} of {heights.size} points: "
            "fill them from their neighbours with missing='fill' (on the command line --missing fill)."
        )
    return filled(heights)
