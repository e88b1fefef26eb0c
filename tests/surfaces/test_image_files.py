"""Heights in TIFF images."""

from __future__ import annotations

import struct
import sys
import tracemalloc
import zlib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import roughcontact as rc
from roughcontact.typing import read_raw

tifffile = pytest.importorskip("tifffile")

# 3 rows of 4 pixels: the highest point is at the top on the right.
IMAGE = np.array([[0.0, 1.0, 2.0, 9.0], [3.0, 4.0, 5.0, 6.0], [7.0, 8.0, 1.0, 2.0]])
GIVEN = {"size": (4e-6, 3e-6), "unit": 1e-9}


def test_an_image_has_x_to_the_right_and_y_upwards(tmp_path):
    tifffile.imwrite(tmp_path / "map.tif", IMAGE.astype("f4"))
    surface = rc.read_surface(tmp_path / "map.tif", **GIVEN)
    assert surface.grid.shape == (4, 3)
    for row in range(3):
        for column in range(4):
            i = np.argmin(np.abs(surface.grid.x[:, 0] - (column - 1.5) * 1e-6))
            j = np.argmin(np.abs(surface.grid.y[0] - (1 - row) * 1e-6))
            assert surface.values[i, j] == pytest.approx(1e-9 * IMAGE[row, column])


@given(
    shape=st.tuples(st.integers(2, 40), st.integers(2, 40)),
    dtype=st.sampled_from(["f4", "f8", "u1", "u2", "i2", "i4"]),
    options=st.sampled_from(
        [{}, {"compression": "zlib"}, {"tile": (16, 16)}, {"rowsperstrip": 3}, {"bigtiff": True}, {"byteorder": ">"}]
    ),
    seed=st.integers(0, 100),
)
@settings(deadline=None, max_examples=60)
def test_what_tifffile_writes_is_read_back(tmp_path_factory, shape, dtype, options, seed):
    path = tmp_path_factory.getbasetemp() / "written.tif"
    image = (np.random.default_rng(seed).random(shape) * 100).astype(dtype)
    tifffile.imwrite(path, image, photometric="minisblack", **options)
    np.testing.assert_array_equal(read_raw(path).heights[:, ::-1].T, image)


def test_unit_and_size_must_be_given(tmp_path):
    tifffile.imwrite(tmp_path / "map.tif", IMAGE.astype("f4"))
    with pytest.raises(rc.InputError, match=r"does not state the size .*: give size=\(x, y\), m, or cell="):
        rc.read_surface(tmp_path / "map.tif", unit=1e-9)
    # Heights without a unit are not taken as m in an image.
    with pytest.raises(rc.InputError, match=r"or cell=, the distance of its points\.$"):
        rc.read_surface(tmp_path / "map.tif")
    with pytest.raises(rc.InputError, match=r"numbers without a unit: give .* such as unit=1e-09\.$"):
        rc.read_surface(tmp_path / "map.tif", size=(4e-6, 3e-6))


@pytest.mark.parametrize("zero", [(0, 1), (300, 0), (0, 0)])
@pytest.mark.parametrize("tag", ["XResolution", "YResolution"])
def test_a_resolution_of_zero_says_nothing(tmp_path, zero, tag):
    path = tmp_path / "map.tif"
    tifffile.imwrite(path, IMAGE.astype("f4"), resolution=(1e7, 1e7), resolutionunit="CENTIMETER")
    assert rc.read_surface(path, unit=1e-9).size == pytest.approx((4e-9, 3e-9), rel=1e-5)
    with tifffile.TiffFile(path) as file:
        place, order = file.pages[0].tags[tag].valueoffset, file.byteorder
    content = bytearray(path.read_bytes())
    content[place : place + 8] = struct.pack(f"{order}II", *zero)
    path.write_bytes(content)
    assert rc.read_surface(path, **GIVEN).size == GIVEN["size"]
    with pytest.raises(rc.InputError, match="does not state the size"):
        rc.read_surface(path, unit=1e-9)


@pytest.mark.parametrize(
    ("options", "size"),
    [
        ({"imagej": True, "resolution": (2.0, 4.0), "metadata": {"unit": "um"}}, (2e-6, 0.75e-6)),
        ({"imagej": True, "resolution": (2.0, 2.0), "metadata": {"unit": "\\u00B5m"}}, (2e-6, 1.5e-6)),
        ({"resolution": (2e4, 1e4), "resolutionunit": "CENTIMETER"}, (2e-6, 3e-6)),
        ({"resolution": (25400.0, 25400.0), "resolutionunit": "INCH"}, (4e-6, 3e-6)),
    ],
)
def test_the_size_is_read_where_it_is_certain(tmp_path, options, size):
    tifffile.imwrite(tmp_path / "map.tif", IMAGE.astype("f4"), **options)
    assert rc.read_surface(tmp_path / "map.tif", unit=1e-9).size == pytest.approx(size, rel=1e-5)


@pytest.mark.parametrize("options", [{"resolutionunit": "INCH"}, {"resolutionunit": "NONE"}])
def test_a_resolution_for_printing_is_not_a_size(tmp_path, options):
    tifffile.imwrite(tmp_path / "map.tif", IMAGE.astype("f4"), resolution=(300.0, 300.0), **options)
    with pytest.raises(rc.InputError, match="does not state the size"):
        rc.read_surface(tmp_path / "map.tif", unit=1e-9)


def test_points_without_data_are_not_measured(tmp_path):
    image = IMAGE.copy()
    image[0, 0] = np.nan
    tags = [(42113, "s", 0, "9", True)]
    tifffile.imwrite(tmp_path / "map.tif", image.astype("f4"), extratags=tags)
    surface = rc.read_surface(tmp_path / "map.tif", **GIVEN, non_measured="keep")
    np.testing.assert_array_equal(surface.non_measured, [[0, 0, 1], [0, 0, 0], [0, 0, 0], [0, 0, 1]])


def test_one_of_several_images_is_chosen(tmp_path):
    pages = np.random.default_rng(0).random((4, 6, 5)).astype("f4")
    tifffile.imwrite(tmp_path / "map.tif", pages, photometric="minisblack")
    with pytest.raises(rc.InputError, match="it holds 4 images: choose one with page=, from 0 to 3"):
        rc.read_surface(tmp_path / "map.tif", size=(5e-6, 6e-6), unit=1e-9)
    surface = rc.read_surface(tmp_path / "map.tif", size=(5e-6, 6e-6), unit=1.0, page=2)
    np.testing.assert_array_equal(surface.values[:, ::-1].T, pages[2])
    with pytest.raises(rc.InputError, match="it has no page 4: its pages are 0 to 3"):
        rc.read_surface(tmp_path / "map.tif", size=(5e-6, 6e-6), unit=1.0, page=4)
    with pytest.raises(rc.InputError, match="The page of a TIFF file"):
        rc.read_surface(tmp_path / "map.tif", size=(5e-6, 6e-6), unit=1.0, page=-1)


def huge(path):
    """An image that declares 2^32 pixels."""
    tifffile.imwrite(path, np.zeros((70_000, 2), "f4"), compression="zlib")
    with tifffile.TiffFile(path) as file:
        width = file.pages[0].tags["ImageWidth"].valueoffset
    content = bytearray(path.read_bytes())
    content[width : width + 4] = (2**16).to_bytes(4, "little")
    path.write_bytes(content)


def bomb(path):
    """An image whose one part expands to much more than its pixels."""
    image, marker = np.random.default_rng(0).random((64, 64)), zlib.compress(bytes(2**26))
    tifffile.imwrite(path, image, compression="zlib")
    with tifffile.TiffFile(path) as file:
        offset = file.pages[0].dataoffsets[0]
        count = file.pages[0].tags["StripByteCounts"].valueoffset
    content = bytearray(path.read_bytes()[:offset]) + marker
    content[count : count + 4] = len(marker).to_bytes(4, "little")
    path.write_bytes(content)


BAD = {
    "colours": (lambda path: tifffile.imwrite(path, np.zeros((8, 9, 3), "u1"), photometric="rgb"),
                r"an image of 3 channels \(rgb\), not of heights: export"),
    "a palette": (lambda path: tifffile.imwrite(path, np.zeros((8, 9), "u1"), photometric="palette",
                                                colormap=np.zeros((3, 256), "u2")), "palette"),
    "inverted": (lambda path: tifffile.imwrite(path, np.zeros((8, 9), "u1"), photometric="miniswhite"), "miniswhite"),
    "complex": (lambda path: tifffile.imwrite(path, np.zeros((8, 9), "c8")), "are not numbers of heights"),
    "no image": (lambda path: path.write_bytes(b"II*\0\0\0\0\0"), "cannot be"),
    "noise": (lambda path: path.write_bytes(b"noise" * 99), "not a TIFF file"),
    "huge": (huge, "declares 65536 x 70000 pixels, more than a file of"),
    "a bomb": (bomb, "a part of it expands to more than its 32768 bytes"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_what_is_no_map_of_heights_is_refused(tmp_path, name):
    make, words = BAD[name]
    make(tmp_path / "map.tif")
    tracemalloc.start()
    with pytest.raises(rc.InputError, match=words) as caught:
        rc.read_surface(tmp_path / "map.tif", **GIVEN)
    assert tracemalloc.get_traced_memory()[1] < 2**24
    tracemalloc.stop()
    assert str(caught.value).isprintable()
    assert len(str(caught.value)) < 400


def test_without_tifffile_the_sentence_says_what_to_install(tmp_path, monkeypatch):
    tifffile.imwrite(tmp_path / "map.tif", IMAGE)
    monkeypatch.setitem(sys.modules, "tifffile", None)
    with pytest.raises(rc.MissingPackage, match=r"pip install 'roughcontact\[files\]'"):
        rc.read_surface(tmp_path / "map.tif", **GIVEN)
