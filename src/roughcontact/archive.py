"""Arrays with a header in one npz file, written whole or not at all."""

from __future__ import annotations

import contextlib
import json
import os
import uuid
import zipfile
import zlib
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from roughcontact.checks import RealArray
from roughcontact.errors import InputError

_HEADER = "header"


def write_archive(path: str | os.PathLike[str], arrays: Mapping[str, npt.ArrayLike], header: Mapping[str, Any]) -> None:
    """Write arrays and a header that JSON can hold; an existing file is replaced only by a whole one.

    Raises
    ------
    InputError
        If the folder does not exist.
    OSError
        If the disk is full or cannot be written to; nothing is left behind then.
    """
    with replacing(path) as partial, partial.open("wb") as file:
        np.savez_compressed(file, **{_HEADER: np.array(json.dumps(header)), **arrays})  # type: ignore[arg-type]


@contextlib.contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Give the name of a file beside the one to be written, which takes its place when all has gone well."""
    target = Path(path)
    if not target.parent.is_dir():
        raise InputError(f"There is no folder {str(target.parent)!r} to write {target.name} into.")
    # Several processes, of several machines, may write the same file.
    partial = target.with_name(f".{target.name}.{uuid.uuid4().hex[:12]}.partial")
    try:
        yield partial
        partial.replace(target)
    except BaseException:
        partial.unlink(missing_ok=True)
        raise


def read_archive(path: str | os.PathLike[str]) -> tuple[dict[str, RealArray], dict[str, Any]]:
    """Return the arrays and the header of a file of `write_archive`.

    Raises
    ------
    InputError
        If there is no such file, or it is damaged or of another kind.
    """
    return _load(Path(path), lambda data: {name: data[name] for name in data.files})


def read_header(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Return the header alone; see `read_archive`."""
    return _load(Path(path), lambda data: {_HEADER: data[_HEADER]})[1]


def _load(file: Path, pick: Callable[[Any], dict[str, RealArray]]) -> tuple[dict[str, RealArray], dict[str, Any]]:
    if not file.is_file():
        raise InputError(f"There is no file {str(file)!r}.")
    try:
        with file.open("rb") as stream, np.load(stream, allow_pickle=False) as data:
            arrays = pick(data)
        header = json.loads(str(arrays.pop(_HEADER)))
    except (OSError, KeyError, ValueError, EOFError, zipfile.BadZipFile, zlib.error, AttributeError) as error:
        raise InputError(f"The file {file.name} is damaged, or is no file of this package ({error}).") from error
    if not isinstance(header, dict):
        raise InputError(f"The file {file.name} is no file of this package: its header is no mapping.")
    return arrays, header
