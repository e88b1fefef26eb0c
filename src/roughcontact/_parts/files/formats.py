"""Readers of numpy's files: heights in metres, indexed [x, y]."""

from __future__ import annotations

import contextlib
from pathlib import Path

import attrs
import numpy as np

from roughcontact._base.archive import read_npy, read_npz
from roughcontact._parts.files.base import RawMap, SurfaceReader, check_rows, require_memory_of_map
from roughcontact._parts.files.named import STATING_NAMES, NamedArray, gather, require_table
from roughcontact._parts.files.stated import Stated, build_map, check_no_data, names_unit
from roughcontact.errors import InputError

# Names of an array of the names of both axes, and of texts that may name the unit of the heights.
_AXES = ("dims", "dimensions", "axes")
_DESCRIBING_NAMES = ("metadata", "meta", "description", "comment", "info", "header", "notes")
_NONE = np.empty(0)


def _require_no_unit(path: Path) -> None:
    """Refuse a file whose texts name a unit that may be that of its heights, which are taken as metres."""
    for name in _DESCRIBING_NAMES:
        texts: dict[str, np.ndarray] = {}
        # Objects are not read.
        with contextlib.suppress(ValueError), path.open("rb") as file:
            texts = read_npz(file, {name}, deflated=True)
        text = str(texts[name].item()) if name in texts and texts[name].size == 1 else ""
        if names_unit(text):
            raise InputError(
                f"its {name} is {text[:60]!a}, which may name the unit of its heights: write it as unit= with "
                "numpy.savez, such as unit='nm', or unit='m'"
            )


@attrs.frozen
class NpzReader(SurfaceReader):
    """``numpy.savez(path, heights=..., size=(lx, ly), periodic=...)``; size and periodic are optional.

    `size` may be replaced by `dx` and `dy`; a `unit` of the heights, such as ``"um"`` or 1e-6, is used.

    Parameters
    ----------
    no_data
        The number that stands for a non-measured point, or ``"none"``; one that looks so is asked about, unless the
        file has `periodic`, as this package writes it.
    """

    no_data: float | str | None = attrs.field(default=None, converter=check_no_data)

    suffixes = frozenset({".npz"})

    def read(self, path: Path) -> RawMap:
        """Return the map."""
        require_memory_of_map(2.0 * path.stat().st_size)
        with path.open("rb") as file:
            data = read_npz(file, {"heights", "size", "periodic", *_AXES} | STATING_NAMES, deflated=True)
        if "heights" not in data:
            raise InputError("it holds no array named 'heights'")
        heights = data.pop("heights")
        size = data.get("size")
        no_data = "none" if self.no_data is None and "periodic" in data else self.no_data
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
            # What is not a map is refused by `read_surface`, with its shape.
            lx, ly = np.broadcast_to(1.0 if size is None else size, 2).tolist()
            return RawMap(heights, (lx, ly), metric=True)
        axes = next((tuple(map(str, data.pop(name))) for name in _AXES if data.get(name, _NONE).shape == (2,)), ())
        arrays = {name: NamedArray(one) for name, one in data.items() if one.dtype.kind in "biuf"}
        texts = {name: str(one.item()) for name, one in data.items() if one.dtype.kind == "U" and one.size == 1}
        stated = gather(NamedArray(heights, axes=axes), arrays, texts)
        if stated.unit is None:
            _require_no_unit(path)
        stated = attrs.evolve(stated, rows=stated.rows or "x", periodic=bool(periodic))
        # Without a unit they are metres.
        found = build_map(heights, stated, line="the first index", no_data=no_data)
        return attrs.evolve(found, metric=True, rows=found.rows if stated.rows == "y" else "")


@attrs.frozen
class NpyReader(SurfaceReader):
    """``numpy.save(path, heights)``.

    Parameters
    ----------
    rows
        ``"x"`` or ``"y"``: the axis of the first index, the smallest first; by default x.
    no_data
        The number that stands for a non-measured point, or ``"none"``; one that looks so is asked about.
    """

    rows: str = attrs.field(default="auto", converter=check_rows)
    no_data: float | str | None = attrs.field(default=None, converter=check_no_data)

    suffixes = frozenset({".npy"})

    def read(self, path: Path) -> RawMap:
        """Return the map."""
        require_memory_of_map(2.0 * path.stat().st_size)
        with path.open("rb") as file:
            heights = read_npy(file, path.stat().st_size)
        if heights.dtype.kind not in "biuf" or heights.ndim != 2:
            return RawMap(heights)
        require_table(heights)
        return build_map(heights, Stated(), rows=self.rows, line="the first index", no_data=self.no_data)
