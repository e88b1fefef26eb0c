"""Height maps in .mat files, against scipy's writer and as MATLAB writes version 7.3, and in other files of HDF5."""

from __future__ import annotations

import io
import struct
import sys
import tracemalloc
import zlib

import numpy as np
import pytest
import scipy.io
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

import roughcontact as rc
from roughcontact.typing import read_raw

HEIGHTS = np.random.default_rng(0).random((5, 7)) * 1e-6
# Bytes that may be taken to refuse a file.
MEMORY = 2**24


def write_hdf5(path, **contents):
    """Write arrays as MATLAB writes version 7.3: a head of 512 bytes, and dimensions in the order of columns."""
    h5py = pytest.importorskip("h5py")
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, values in contents.items():
            file.create_dataset(name, data=np.asarray(values).T, chunks=True, compression=3, shuffle=True)
    with path.open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\0\2IM")


@given(
    heights=arrays.arrays(
        st.sampled_from([np.float64, np.float32, np.int16, np.uint8, np.dtype(">f8")]),
        st.tuples(st.integers(2, 9), st.integers(2, 9)),
    ),
    compressed=st.booleans(),
)
@settings(deadline=None, max_examples=60)
def test_what_scipy_writes_is_read_back(tmp_path_factory, heights, compressed):
    path = tmp_path_factory.getbasetemp() / "written.mat"
    others = {"text": "abc", "cells": np.array(["a", 1.0], dtype=object), "record": {"x": np.eye(3)}, "none": []}
    scipy.io.savemat(path, {"heights": heights, **others, "z": 1j * np.eye(3)}, do_compression=compressed)
    found = read_raw(path, no_data="none")
    np.testing.assert_array_equal(found.heights, heights.astype(np.float64))
    assert found.heights.dtype == np.float64
    assert found.size is None


def test_the_only_map_is_taken_and_others_are_chosen(tmp_path):
    path = tmp_path / "map.mat"
    scipy.io.savemat(path, {"z": HEIGHTS, "n": 3.0, "high": HEIGHTS > 0, "x": np.arange(5.0)})
    np.testing.assert_array_equal(rc.read_surface(path, size=(5e-6, 7e-6)).values, HEIGHTS)
    scipy.io.savemat(path, {"z": HEIGHTS, "y": 2 * HEIGHTS})
    with pytest.raises(rc.InputError, match=r"give variable= with its name; .* are: y, z"):
        rc.read_surface(path, size=1e-6)
    np.testing.assert_array_equal(rc.read_surface(path, size=(5e-6, 7e-6), variable="y").values, 2 * HEIGHTS)
    with pytest.raises(rc.InputError, match="are: y, z"):
        rc.read_surface(path, size=1e-6, variable="w")
    with pytest.raises(rc.InputError, match="The variable in a file must be the name"):
        rc.read_surface(path, size=1e-6, variable=3)
    scipy.io.savemat(path, {"text": "abc"})
    with pytest.raises(rc.InputError, match="two dimensions are: none"):
        rc.read_surface(path, size=1e-6)


@pytest.mark.parametrize(
    ("lengths", "size"),
    [
        ({"size": [5e-6, 7e-6]}, (5e-6, 7e-6)),
        ({"size": [[5e-6], [7e-6]]}, (5e-6, 7e-6)),
        ({"lx": 5e-6, "ly": 7e-6}, (5e-6, 7e-6)),
        ({"dx": 1e-6}, (5e-6, 7e-6)),
        ({"dx": 1e-6, "dy": 2e-6}, (5e-6, 14e-6)),
        ({"dx": 1.0}, "sides of 5 and 7 m, more than 1 m"),
        ({"size": 5e-6}, "does not state the size"),
        ({"lx": 5e-6}, "does not state the size"),
        ({"dx": np.nan}, "sides of nan and nan, which must be positive"),
        ({"dx": -1e-6}, "must be positive"),
        ({"size": [1e-6, 2e-6, 3e-6]}, "does not state the size"),
        ({"size": [5e-6, 7e-6], "dx": 2e-6}, "which contradict each other"),
    ],
)
def test_the_size_is_read_where_it_is_certain(tmp_path, lengths, size):
    scipy.io.savemat(tmp_path / "map.mat", {"heights": HEIGHTS, **lengths})
    write_hdf5(tmp_path / "new.mat", heights=HEIGHTS, **{name: np.atleast_2d(value) for name, value in lengths.items()})
    for name in ("map.mat", "new.mat"):
        if isinstance(size, str):
            with pytest.raises(rc.InputError, match=size):
                rc.read_surface(tmp_path / name)
        else:
            surface = rc.read_surface(tmp_path / name)
            assert surface.size == pytest.approx(size)
            np.testing.assert_array_equal(surface.values, HEIGHTS)


def test_a_size_in_another_unit_is_repeated(tmp_path):
    scipy.io.savemat(tmp_path / "map.mat", {"heights": 1e6 * HEIGHTS, "dx": 1.0, "dy": 2.0})
    with pytest.raises(rc.InputError, match=r"states sides of 5 and 14 m, .*: give size="):
        rc.read_surface(tmp_path / "map.mat")
    surface = rc.read_surface(tmp_path / "map.mat", size=(5e-6, 14e-6), unit=1e-6)
    np.testing.assert_allclose(surface.values, HEIGHTS)


def test_non_measured_points_are_nan(tmp_path):
    heights = HEIGHTS.copy()
    heights[2, 3] = np.nan
    scipy.io.savemat(tmp_path / "map.mat", {"heights": heights, "dx": 1e-6})
    with pytest.raises(rc.InputError, match="1 of 35 points were not measured"):
        rc.read_surface(tmp_path / "map.mat")


def test_version_7_3_needs_h5py(tmp_path, monkeypatch):
    write_hdf5(tmp_path / "new.mat", heights=HEIGHTS, dx=[[1e-6]])
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(rc.MissingPackage, match=r"pip install 'roughcontact\[store\]', or .*'-v7'"):
        rc.read_surface(tmp_path / "new.mat")


def test_other_files_of_hdf5_have_x_first_and_groups(tmp_path):
    h5py = pytest.importorskip("h5py")
    path = tmp_path / "surface.1024.h5"
    with h5py.File(path, "w") as file:
        file.create_dataset("surface", data=HEIGHTS, chunks=True, compression=3, fletcher32=True)
    np.testing.assert_array_equal(rc.read_surface(path, size=(5e-6, 7e-6)).values, HEIGHTS)
    np.testing.assert_array_equal(rc.read_surface(path, size=(7e-6, 5e-6), rows="y").values, HEIGHTS.T)
    with h5py.File(path, "a") as file:
        file["size"] = (5e-6, 7e-6)
        file["filtered/z"] = 2 * HEIGHTS
        file["filtered/again"] = file["filtered"]  # A circle.
    with pytest.raises(rc.InputError, match="are: filtered/z, surface"):
        rc.read_surface(path)
    surface = rc.read_surface(path, variable="filtered/z")
    np.testing.assert_array_equal(surface.values, 2 * HEIGHTS)
    assert surface.size == (5e-6, 7e-6)
    with h5py.File(path, "w") as file:
        for number in range(1001):
            file[f"n{number}"] = 1.0
    with pytest.raises(rc.InputError, match="more than 1000 members"):
        rc.read_surface(path)


def make_element(kind, data):
    return struct.pack("<II", kind, len(data)) + data + b"\0" * (-len(data) % 8)


def make_matrix(shape, data, kind=9, name=b"heights"):
    flags, dimensions = make_element(6, struct.pack("<II", 6, 0)), make_element(5, struct.pack("<ii", *shape))
    return make_element(14, flags + dimensions + make_element(1, name) + make_element(kind, data))


def make_file(*elements):
    return b"MATLAB 5.0 MAT-file".ljust(124) + b"\0\1IM" + b"".join(elements)


def squeeze(data):
    packed = zlib.compress(data)
    return struct.pack("<II", 15, len(packed)) + packed


def test_a_file_made_by_hand_is_read(tmp_path):
    matrix = make_matrix((5, 7), HEIGHTS.tobytes("F"))
    for content in (make_file(matrix), make_file(squeeze(matrix)), make_file(make_element(1, b"other"), matrix)):
        (tmp_path / "map.mat").write_bytes(content)
        np.testing.assert_array_equal(read_raw(tmp_path / "map.mat").heights, HEIGHTS)


def make_bombs():
    small = [squeeze(make_matrix((2**9, 2**10), bytes(2**22), name=b"a%d" % n)) for n in range(9)]
    return {"a bomb": make_file(squeeze(make_matrix((2**12, 2**13), bytes(2**28)))), "many bombs": make_file(*small)}


HOSTILE = {
    "nothing": (b"", "is not a .mat file of level 5 or 7.3"),
    "level 4": (b"\0\0\0\0\5\0\0\0\7\0\0\0\0\0\0\0\10\0\0\0heights\0".ljust(400), "is not a .mat file of level 5"),
    "a huge map": (make_file(make_matrix((2**20, 2**20), bytes(64))), "declares 1048576 x 1048576 numbers"),
    "a negative map": (make_file(make_matrix((-2, -4), bytes(64))), "two dimensions are: none"),
    "objects": (make_file(make_element(14, 9 * make_element(6, bytes([17, 0, 0, 0, 0, 0, 0, 0])))), "are: none"),
    "a long name": (make_file(make_matrix((2, 4), bytes(64), name=b"x" * 999)), "two dimensions are: none"),
    "an odd name": (make_file(make_matrix((2, 3), bytes(64), name=b"\x1b\xff\n")), "its array '.x1b.ufffd.n' declares"),
    "a type unknown": (make_file(make_matrix((2, 4), bytes(64), kind=18)), "two dimensions are: none"),
    "a cut": (make_file(make_matrix((2, 4), bytes(64)))[:-9], "more than it has: it is damaged"),
    "an endless element": (make_file(struct.pack("<II", 14, 2**32 - 1) + bytes(64)), "declares 4294967295 bytes"),
    "a bomb": (None, "expands to more than"),
    "many bombs": (None, "expands to more than"),
    "no zlib": (make_file(struct.pack("<II", 15, 64) + bytes(64)), "cannot be read as a height map"),
    "no matrix inside": (make_file(squeeze(make_element(1, b"abc"))), "two dimensions are: none"),
    "an empty element": (make_file(squeeze(b"")), "two dimensions are: none"),
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_files_are_refused_in_little_memory(tmp_path, name):
    content, words = HOSTILE[name]
    (tmp_path / "map.mat").write_bytes(make_bombs()[name] if content is None else content)
    tracemalloc.start()
    with pytest.raises(rc.InputError, match=words) as caught:
        rc.read_surface(tmp_path / "map.mat", size=1e-6)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < MEMORY
    assert str(caught.value).isprintable()
    assert len(str(caught.value)) < 400


def test_what_is_not_plain_numbers_in_hdf5_stays_unread(tmp_path):
    h5py = pytest.importorskip("h5py")
    path = tmp_path / "map.mat"
    with h5py.File(path, "w") as file:
        file.create_dataset("text", data="abc")
        file.create_dataset("opaque", data=np.zeros((3, 3), "V8"))
        file.create_dataset("cube", data=np.zeros((3, 3, 3)))
        file["soft"], file["outside"] = h5py.SoftLink("/heights"), h5py.ExternalLink("other.mat", "/heights")
        file.create_dataset("external", (4, 4), "f8", external=[("/etc/passwd", 0, 128)])
        file.create_group("group")
    with pytest.raises(rc.InputError, match="two dimensions are: none"):
        rc.read_surface(path, size=1e-6)
    with h5py.File(path, "w") as file:
        file.create_dataset("heights", (2**20, 2**20), "f8", chunks=(64, 64))
    with pytest.raises(rc.InputError, match="its arrays are larger than a file of"):
        rc.read_surface(path, size=1e-6)


def test_scipy_agrees(tmp_path):
    """A file of ours by hand is one that scipy reads."""
    content = make_file(make_matrix((5, 7), HEIGHTS.tobytes("F")))
    np.testing.assert_array_equal(scipy.io.loadmat(io.BytesIO(content))["heights"], HEIGHTS)
