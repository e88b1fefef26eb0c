"""Bounds of files that are read, by the functions that hold them."""

from __future__ import annotations

import contextlib
import struct
import zipfile
import zlib

import numpy as np
import pytest

import roughcontact as rc
from roughcontact._parts.files.bounds import _count_inflated, _is_sound, require_bounded
from roughcontact._work.studies import lists
from unit_files import read_index

h5py = pytest.importorskip("h5py")


@pytest.fixture(scope="module", autouse=True)
def readers():
    """Load the readers, those of plug-ins too, before anything is watched."""
    for name in rc.readers:
        rc.readers.create(name)


def test_a_list_of_records_is_used_after_its_checksum(tmp_path, monkeypatch):
    built, path = [], tmp_path / "index.json"
    monkeypatch.setattr(lists, "rebuild", lambda described, _: built.append(described))
    for lines in ("{}", "{}" * 40_000, ",\n".join(["{}"] * 10)):
        path.write_text(lists._seal(lines, "", 0).replace('sha256": "', 'sha256": "0', 1))
        assert read_index(path) == {}
        assert not built
    path.write_text(lists._seal("{" + " " * 70_000 + "}", "", 0))
    assert read_index(path) == {}
    assert not built
    path.write_text(lists._seal("{},\n{}", "", 0))
    assert read_index(path) == {}
    assert built == [{}]


class TestBounds:
    """What expands is compared with the bytes of its file: 2 MiB and twenty times these."""

    COMPOUND = b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + bytes(504)

    @pytest.mark.parametrize(("megabytes", "refused"), [(1, False), (3, True)])
    def test_blocks_of_a_compound_file(self, tmp_path, megabytes, refused):
        path = tmp_path / "a.sur"
        block = zlib.compress(bytes(megabytes * 10**6))
        for content in (self.COMPOUND + block, self.COMPOUND + b"xy" + block + bytes(10)):
            path.write_bytes(content)
            with pytest.raises(rc.InputError, match="expand to more than") if refused else contextlib.nullcontext():
                require_bounded(path)
        # Several blocks count together.
        path.write_bytes(self.COMPOUND + 3 * block)
        with pytest.raises(rc.InputError, match=f"a file of {512 + 3 * len(block)} bytes can hold"):
            require_bounded(path)

    def test_damaged_blocks_are_none(self, tmp_path):
        random = np.random.default_rng(0).bytes(100_000)
        block = bytearray(zlib.compress(random))
        block[3000:3010] = bytes(10)
        path = tmp_path / "a.sur"
        path.write_bytes(self.COMPOUND + 50 * bytes(block))
        require_bounded(path)
        assert _count_inflated(memoryview(zlib.compress(random)), 10**9) == 100_000
        assert _count_inflated(memoryview(bytes(block)), 10**9) == 0
        assert _count_inflated(memoryview(zlib.compress(bytes(10**7))), 10**6) in range(10**6, 10**6 + 2**17)

    def test_members_of_a_file(self, tmp_path, monkeypatch):
        monkeypatch.setattr("roughcontact._parts.files.bounds._MAX_MEMBERS", 3)
        for count in (3, 4):
            path = tmp_path / f"{count}.h5"
            with h5py.File(path, "w") as file:
                for k in range(count):
                    file.create_dataset(f"a{k}", data=np.zeros(3))
            with pytest.raises(rc.InputError, match="more than 3 members") if count > 3 else contextlib.nullcontext():
                require_bounded(path)

    def test_descriptions_in_an_archive(self, tmp_path):
        path = tmp_path / "a.x3p"
        for size, refused in ((2**22, False), (2**22 + 1, True)):
            with zipfile.ZipFile(path, "w") as file:
                file.writestr("main.XML", np.random.default_rng(0).bytes(size))
                file.writestr("data.bin", bytes(20))
            with pytest.raises(rc.InputError, match="a description") if refused else contextlib.nullcontext():
                require_bounded(path)
        with zipfile.ZipFile(path, "w") as file:
            file.writestr("data.bin", bytes(20))
        require_bounded(path)

    @pytest.mark.parametrize(("lengths", "sound"), [((8, 16), True), ((0, 8), False), ((8, 10**6), False)])
    def test_heaps_of_texts(self, lengths, sound):
        """Each object has a head of 16 bytes and eight bytes at a time; number 0 is what is free, with its head."""
        objects = b""
        for number, length in enumerate(lengths, 1):
            free = length == 0
            objects += struct.pack("<HH4xQ", 0 if free else number, 1, length) + bytes(min(-(-length // 8) * 8, 64))
        heap = b"GCOL\x01\x00\x00\x00" + struct.pack("<Q", 16 + len(objects)) + objects
        assert _is_sound(heap, 0) == sound
        assert _is_sound(bytes(5) + heap, 5) == sound
        assert not _is_sound(heap[:12], 0)
        assert not _is_sound(heap[:-1], 0)
