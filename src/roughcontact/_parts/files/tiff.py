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
from roughcontact._parts.files.base import RawMap, SurfaceReader, readers, require_memory_of_map
from roughcontact._parts.files.bounds import TEXT_OR_IMAGE, require_room
from roughcontact._parts.files.headers import read_header
from roughcontact._parts.files.stated import Stated, build_map, check_no_data, metres, parse_number
from roughcontact.errors import InputError, MissingPackage, argument, requiring

# Number of the tag with the value of points without data, in geographic images.
_NODATA_TAG = 42113
# Number of the tag in which GDAL keeps its items, and those that say what pixels mean.
_GDAL_TAG = 42112
_GDAL_ITEM = re.compile(r'role="(scale|offset|unittype)"[^>]*>([^<]*)<')
# Number of the tag with the sides of the pixels of a map of the earth, and of that with the heights of Park Systems.
_PIXEL_SCALE_TAG = 33550
_PARK_TAG = 50434
# Attributes of OME with the sides of the pixels, and their units.
_OME_SIZE = re.compile(r'PhysicalSize([XY])="([0-9.eE+-]+)"')
_OME_UNIT = re.compile(r'PhysicalSize([XY])Unit="([^"]*)"')
# What ImageJ writes as a unit where none was set.
_NO_UNITS = ("gray value", "grey value", "pixel", "pixels", "inch")
# Numbers of the compressions that are read: none, LZW, deflate (two), PackBits; others lose digits or are rare.
_COMPRESSIONS = {1, 5, 8, 32773, 32946}
_DEFLATE_COMPRESSIONS = {8, 32946}
# Characters of a description that are read.
_MAX_DESCRIPTION = 10_000
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
    no_data
        The number that stands for a non-measured point, or ``"none"``; one that looks so is asked about.
    """

    page: int | None = attrs.field(default=None, converter=_page)
    no_data: float | str | None = attrs.field(default=None, converter=check_no_data)

    suffixes = frozenset({".tif", ".tiff"})

    def read(self, path: Path) -> RawMap:
        """Return the map; raise `MissingPackage` if tifffile is not installed."""
        with requiring(f"Reading {path.name} needs the package tifffile: pip install 'roughcontact[files]'."):
            from tifffile import TiffFile
        # tifffile logs oddities of a file; real errors become an `InputError`.
        logging.getLogger("tifffile").addHandler(logging.NullHandler())
        with TiffFile(path) as file:
            if _PARK_TAG in file.pages.first.tags:
                # Its image is a picture; the heights stand in a tag, which the reader of instruments knows.
                return readers.create("instrument").read(path)
            page = self._choose(file)
            _require_heights(page, path.stat().st_size)
            _require_honest(page, file.filehandle)
            imagej = file.imagej_metadata or {}
            stated = _read_stated(page, imagej, file.ome_metadata)
            image = _read_pixels(page)
            words = _describe_print(page, stated)
        found = build_map(image, stated, line="a line of the image", needs_unit=True, no_data=self.no_data)
        return attrs.evolve(found, hint=found.hint or words)

    def _choose(self, file: Any) -> Any:
        count = len(file.pages)
        if self.page is None and count > 1:
            raise InputError(f"it holds {count} images: choose one with {argument('page')}, from 0 to {count - 1}")
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
    require_room(needed, size, f"it declares {shape[1]} x {shape[0]} pixels, more", TEXT_OR_IMAGE)
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
        return np.asarray(page.asarray(maxworkers=1))
    except ValueError as error:
        if "imagecodecs" in str(error):
            name = page.compression.name.lower()
            raise MissingPackage(
                f"Its compression ({name}) needs the package imagecodecs: pip install imagecodecs, or save the image "
                "without compression."
            ) from None
        raise


def _read_stated(page: Any, imagej: dict[str, Any], ome: str | None) -> Stated:
    """Return what the tags of an image, and the texts of ImageJ, OME and GDAL in it, state."""
    orientation = page.tags.get("Orientation")
    if orientation is not None and int(orientation.value) != 1:
        raise InputError(
            f"its first pixel is not that at the top on the left (orientation {orientation.value}): save it upright"
        )
    stated = Stated(rows="y", falling="y")
    tag = page.tags.get(_NODATA_TAG)
    if tag is not None:
        stated = attrs.evolve(stated, non_measured=(_read_nodata(str(tag.value)),))
    stated = _read_items(stated, page)
    stated = _read_calibration(stated, imagej)
    if not imagej and not ome:
        stated = _read_description(stated, str(page.description or ""))
    for found in (_read_ome(stated, ome), _read_resolution(stated, page, imagej), _read_geographic(stated, page)):
        if found is not None:
            return found
    return stated


def _read_nodata(text: str) -> float:
    try:
        return float(text.strip("\0 "))
    except ValueError:
        raise InputError(f"its value of points without data, {text[:20]!a}, is not a number") from None


def _read_items(stated: Stated, page: Any) -> Stated:
    """Return what is stated with the unit, scale and offset of GDAL."""
    tag = page.tags.get(_GDAL_TAG)
    if tag is None:
        return stated
    items = {role.lower(): text.strip() for role, text in _GDAL_ITEM.findall(str(tag.value))}
    factor, offset = (parse_number(items.get(role, one), role) for role, one in (("scale", "1"), ("offset", "0")))
    return attrs.evolve(stated, factor=factor, offset=offset, unit=items.get("unittype") or None)


def _read_description(stated: Stated, text: str) -> Stated:
    """Return what is stated with what the description of an image says as the header of a text would."""
    found = read_header(text[:_MAX_DESCRIPTION].splitlines())
    return attrs.evolve(
        stated,
        unit=stated.unit if stated.unit is not None else found.unit,
        factor=stated.factor * found.factor,
        non_measured=stated.non_measured or found.non_measured,
        size=found.size,
        steps=found.steps,
        length=found.length,
        not_understood=found.not_understood,
    )


def _read_calibration(stated: Stated, imagej: dict[str, Any]) -> Stated:
    """Return what is stated with the calibration of ImageJ."""
    if "c0" not in imagej and "c1" not in imagej:
        return stated
    # ImageJ numbers its functions; 0 is the straight line c0 + c1 v.
    if int(imagej.get("cf", 0)) != 0:
        raise InputError("its pixels are calibrated by a function of ImageJ that is not a straight line: write heights")
    return attrs.evolve(
        stated,
        factor=float(imagej.get("c1", 1.0)),
        offset=float(imagej.get("c0", 0.0)),
        unit=_clean_unit(imagej.get("vunit", "")) or None,
    )


def _clean_unit(unit: object) -> str:
    """Return the name of a unit as ImageJ writes it; empty where none was set."""
    name = str(unit).replace("\\u00B5", "µ").strip('" ')
    return "" if name.lower() in _NO_UNITS else name


def _read_ome(stated: Stated, text: str | None) -> Stated | None:
    """Return what is stated with the size of pixels of OME; None without one."""
    sizes = dict(_OME_SIZE.findall(text or ""))
    if not {"X", "Y"} <= set(sizes):
        return None
    units = {"X": "µm", "Y": "µm"} | dict(_OME_UNIT.findall(text or ""))
    x, y = (float(sizes[axis]) * (metres(units[axis]) or math.nan) for axis in "XY")
    return attrs.evolve(stated, steps=(x, y), length=1.0) if x * y > 0.0 else None


def _read_resolution(stated: Stated, page: Any, imagej: dict[str, Any]) -> Stated | None:
    """Return what is stated with the distance of pixels, where it is certain; None elsewhere."""
    found = _find_pixels_per_unit(page)
    if found is None:
        return None
    if named := _clean_unit(imagej.get("unit", "")):
        along = (named, _clean_unit(imagej.get("yunit", named)))
        known = [metres(one) for one in along]
        x, y = (one / count if one else 1.0 / count for one, count in zip(known, found, strict=True))
        if None not in known:
            return attrs.evolve(stated, steps=(x, y), length=1.0)
        return attrs.evolve(stated, steps=(x, y), length=named) if along[0] == along[1] and None in known else None
    unit = _find_unit(page)
    if unit is None or min(found) / unit <= _MIN_MEASURED_RESOLUTION:
        return None
    return attrs.evolve(stated, steps=(unit / found[0], unit / found[1]), length=1.0)


def _find_pixels_per_unit(page: Any) -> Pair | None:
    per_unit = [page.tags.get(name) for name in ("XResolution", "YResolution")]
    if any(tag is None or len(tag.value) != 2 or 0 in tag.value for tag in per_unit):
        return None
    x, y = (tag.value[0] / tag.value[1] for tag in per_unit if tag is not None)
    return x, y


def _find_unit(page: Any) -> float | None:
    """Return the metres in the unit of the resolution; None where it has none."""
    tag = page.tags.get("ResolutionUnit")
    return None if tag is None else _METRES_PER_UNIT.get(int(tag.value))


def _read_geographic(stated: Stated, page: Any) -> Stated | None:
    """Return what is stated with the pixels of a map of the earth, in a unit that is not looked for; None without."""
    tag = page.tags.get(_PIXEL_SCALE_TAG)
    if tag is None or np.size(tag.value) < 2:
        return None
    x, y = (float(value) for value in tag.value[:2])
    return attrs.evolve(stated, steps=(x, y), length=None) if min(x, y) > 0.0 else None


def _describe_print(page: Any, stated: Stated) -> str:
    """Return in words a resolution that may be that of a screen or a printer."""
    found = _find_pixels_per_unit(page)
    unit = _find_unit(page)
    if stated.steps != (None, None) or found is None or unit is None:
        return ""
    return f"its resolution of {found[0] * 0.0254 / unit:.4g} dots per inch may be that of a screen or a printer"
