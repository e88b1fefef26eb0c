"""Heights in TIFF images, read by the package tifffile."""

from __future__ import annotations

import logging
import math
import re
import zlib
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from roughcontact._base.arrays import Array, Pair
from roughcontact._base.checks import integer
from roughcontact._parts.files.base import RawMap, SurfaceReader, require_memory_of_map
from roughcontact._parts.files.stated import metres
from roughcontact.errors import InputError, MissingPackage

# Number of the tag with the value of points without data, in geographic images.
_NODATA_TAG = 42113
# Number of the tag in which GDAL keeps its items, and those that change what pixels mean.
_GDAL_TAG = 42112
_GDAL_SCALE = re.compile(r'role="(?:scale|offset)"[^<]*')
# Bytes to which an image may expand, plus a multiple of its file.
_EXPANSION_ALLOWANCE = 2**22
_MAX_EXPANSION_RATIO = 50
# Numbers of the compressions that are read: none, LZW, deflate (two), PackBits; others lose digits or are rare.
_COMPRESSIONS = {1, 5, 8, 32773, 32946}
_DEFLATE_COMPRESSIONS = {8, 32946}
# Minimum resolution of a measurement, pixels per metre: printers and screens have 72 to 2400 to the inch.
_MIN_MEASURED_RESOLUTION = 3000 / 0.0254
# Metres in the units of resolution of TIFF: inch and centimetre.
_METRES_PER_UNIT = {2: 0.0254, 3: 0.01}


def _page(value: int | None) -> int | None:
    return None if value is None else integer(value, "The page of a TIFF file", at_least=0)


@attrs.frozen
class TiffReader(SurfaceReader):
    """An image of heights in one channel: x to the right, y upwards, so that its first row has the largest y.

    Its numbers have no unit, which must be given. Its size is read from the metadata of ImageJ, or from a resolution
    finer than any printer's.

    Parameters
    ----------
    page
        Which image of several, from 0.
    """

    page: int | None = attrs.field(default=None, converter=_page)

    @property
    def suffixes(self) -> frozenset[str]:
        """Tif and tiff."""
        return frozenset({".tif", ".tiff"})

    def read(self, path: Path) -> RawMap:
        """Return the map; raise `MissingPackage` if tifffile is not installed."""
        try:
            from tifffile import TiffFile
        except ImportError:
            raise MissingPackage(
                f"Reading {path.name} needs the package tifffile: pip install 'roughcontact[files]'."
            ) from None
        # tifffile logs oddities of a file; real errors become an `InputError`.
        logging.getLogger("tifffile").addHandler(logging.NullHandler())
        with TiffFile(path) as file:
            page = self._choose(file)
            _require_heights(page, path.stat().st_size)
            _require_honest(page, file.filehandle)
            imagej = file.imagej_metadata or {}
            image = _read_pixels(page)
            unit = _calibrate(image, page, imagej)
            size, words = _find_size(page, imagej)
        heights = np.ascontiguousarray(image[::-1].T, dtype=np.float64)
        heights[~np.isfinite(heights)] = np.nan
        if unit is not None:
            heights *= unit
        return RawMap(heights, size, hint=words, metric=unit is not None, needs_unit=unit is None)

    def _choose(self, file: Any) -> Any:
        count = len(file.pages)
        if self.page is None and count > 1:
            raise InputError(f"it holds {count} images: choose one with page=, from 0 to {count - 1}")
        if (self.page or 0) >= count:
            raise InputError(f"it has no page {self.page}: its pages are 0 to {count - 1}")
        return file.pages[self.page or 0]


def _require_heights(page: Any, size: int) -> None:
    """Refuse colours, and an image that its file cannot hold."""
    shape = page.shape
    dtype = page.dtype
    if len(shape) != 2 or page.samplesperpixel != 1 or int(page.photometric) not in (0, 1):
        channels = f"{page.samplesperpixel} channels" if page.samplesperpixel > 1 else f"shape {shape}"
        raise InputError(
            f"it is an image of {channels} ({page.photometric.name.lower()}), not of heights: export the heights as "
            "one channel of numbers, in 32-bit floating point if that can be chosen"
        )
    if dtype is None or dtype.kind not in "iuf" or int(page.photometric) == 0:
        raise InputError(f"its pixels ({dtype}, {page.photometric.name.lower()}) are not numbers of heights")
    needed = math.prod(shape) * dtype.itemsize
    if needed > _EXPANSION_ALLOWANCE + _MAX_EXPANSION_RATIO * size:
        raise InputError(f"it declares {shape[1]} x {shape[0]} pixels, more than a file of {size} bytes can hold")
    require_memory_of_map(3.0 * 8.0 * math.prod(shape))


def _require_honest(page: Any, stream: Any) -> None:
    """Refuse unknown compressions, and strips or tiles that expand to more than their size."""
    if int(page.compression) not in _COMPRESSIONS:
        raise InputError(f"its compression ({page.compression.name.lower()}) is not read: save it without compression")
    if int(page.compression) not in _DEFLATE_COMPRESSIONS:
        return
    most = math.prod(page.chunks) * page.dtype.itemsize
    for data, _ in stream.read_segments(page.dataoffsets, page.databytecounts):
        if data and len(zlib.decompressobj().decompress(data, most + 1)) > most:
            raise InputError(f"a part of it expands to more than its {most} bytes: it is damaged")


def _read_pixels(page: Any) -> Array:
    try:
        image = np.asarray(page.asarray(maxworkers=1), dtype=np.float64)
    except ValueError as error:
        if "imagecodecs" in str(error):
            name = page.compression.name.lower()
            raise MissingPackage(
                f"Its compression ({name}) needs the package imagecodecs: pip install imagecodecs, or save the image "
                "without compression."
            ) from None
        raise
    tag = page.tags.get(_NODATA_TAG)
    if tag is not None:
        # It is written with other digits than the pixels have.
        with np.errstate(over="ignore", invalid="ignore"):
            stated = np.array(_read_nodata(str(tag.value))).astype(page.dtype).astype(np.float64)
        image[image == stated] = np.nan
    return image


def _read_nodata(text: str) -> float:
    try:
        return float(text.strip("\0 "))
    except ValueError:
        raise InputError(f"its value of points without data, {text[:20]!a}, is not a number") from None


def _calibrate(image: Array, page: Any, imagej: dict[str, Any]) -> float | None:
    """Convert pixels to what the file says that they stand for; return its unit, m, or None if it is not a length."""
    tag = page.tags.get(_GDAL_TAG)
    if tag is not None and (found := _GDAL_SCALE.search(str(tag.value))):
        raise InputError(
            f"it states a scale or an offset of its pixels ({found[0][:60]!a}), which is not applied: write the "
            "heights themselves"
        )
    if "c0" not in imagej and "c1" not in imagej:
        return None
    # ImageJ numbers its functions; 0 is the straight line c0 + c1 v.
    if int(imagej.get("cf", 0)) != 0:
        raise InputError("its pixels are calibrated by a function of ImageJ that is not a straight line: write heights")
    image *= float(imagej.get("c1", 1.0))
    image += float(imagej.get("c0", 0.0))
    return metres(_clean_unit(imagej.get("vunit", "")))


def _clean_unit(unit: object) -> str:
    return str(unit).replace("\\u00B5", "µ").strip('"')


def _find_size(page: Any, imagej: dict[str, Any]) -> tuple[Pair | None, str]:
    """Return the sides (x, y), m, if they are certain, and a hint in words."""
    per_unit = [page.tags.get(name) for name in ("XResolution", "YResolution")]
    if any(tag is None or len(tag.value) != 2 or 0 in tag.value for tag in per_unit):
        return None, ""
    x, y = (tag.value[0] / tag.value[1] for tag in per_unit if tag is not None)
    rows, columns = page.shape
    stated = metres(_clean_unit(imagej.get("unit", "")))
    along_y = metres(_clean_unit(imagej["yunit"])) if "yunit" in imagej else stated
    if (along_y is None) is not (stated is None):
        return None, ""
    tag = page.tags.get("ResolutionUnit")
    unit = _METRES_PER_UNIT.get(int(tag.value)) if stated is None and tag is not None else stated
    if unit is None:
        return None, ""
    if stated is not None or min(x, y) / unit > _MIN_MEASURED_RESOLUTION:
        return (columns / x * unit, rows / y * (along_y or unit)), ""
    return None, f"its resolution of {x * 0.0254 / unit:.4g} dots per inch may be that of a screen or a printer"
