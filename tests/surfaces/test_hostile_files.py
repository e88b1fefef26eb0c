"""Hostile files: none runs, imports or allocates anything, and each gets one sentence.

An attacker knows the format, so most files here have the right checksums.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import pickle
import struct
import subprocess
import sys
import tracemalloc
import zipfile

import numpy as np
import pytest

import roughcontact as rc
from damage import right_key
from roughcontact.__main__ import main
from systems import posix
from unit_files import SEAL, archive, pack, read_archive, read_index, read_study, seal, write_archive

h5py = pytest.importorskip("h5py")
xarray = pytest.importorskip("xarray")

# Bytes that may be taken to refuse a file.
MEMORY = 2**24
RUNNING = {
    "subprocess.Popen",
    "os.system",
    "os.exec",
    "os.posix_spawn",
    "os.startfile",
    "pickle.find_class",
    "socket.connect",
}
events: list[str] = []
watching = False
# What takes the place of a file at the moment in which it is opened, by its name.
swapped: dict[str, str] = {}


def note(event, arguments):
    if event == "open" and swapped and (target := swapped.pop(str(arguments[0]), None)):
        os.replace(target, arguments[0])
    if watching and (event in RUNNING or (event == "import" and arguments[0].startswith("trap"))):
        events.append(f"{event}{arguments}")


sys.addaudithook(note)


@pytest.fixture(scope="module")
def solution():
    surface = rc.HeightMap(np.random.default_rng(0).random((12, 10)) * 1e-7, (1e-4, 1e-4), periodic=True)
    body = rc.Body(surface + rc.WavySurface(1e-8, 5e-5), rc.ElasticPerfectlyPlastic(210e9, 0.3, 6e9))
    return rc.ContactProblem(body, grid=surface.grid, boundary="periodic").solve(force=2.0)


@pytest.fixture(scope="module", autouse=True)
def readers():
    """Load the readers, those of plug-ins too, before anything is watched."""
    for name in rc.readers:
        rc.readers.create(name)


@pytest.fixture(scope="module")
def files(solution, tmp_path_factory):
    folder = tmp_path_factory.mktemp("intact")
    for name in ("solution.npz", "solution.nc"):
        solution.save(folder / name)
        use(folder / name)
    return folder


def use(path):
    """Load a solution and what can be rebuilt of its problem."""
    loaded = rc.ContactSolution.load(path)
    str(loaded), loaded.gap, loaded.origin.load
    problem = loaded.origin.problem
    str(problem)
    return problem


@contextlib.contextmanager
def nothing_happens(tmp_path, monkeypatch):
    """Fail if a program runs, a module of the file is imported, or memory is taken."""
    global watching
    (tmp_path / "trap.py").write_text(f"open({str(tmp_path / 'sprung')!r}, 'w').close()\nclass Trap: pass\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    events.clear()
    tracemalloc.start()
    watching = True
    try:
        yield
    finally:
        watching = False
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
    assert events == []
    assert "trap" not in sys.modules
    assert not (tmp_path / "sprung").exists()
    assert peak < MEMORY


def refuse(path, words, tmp_path, monkeypatch, action=use):
    with nothing_happens(tmp_path, monkeypatch), pytest.raises(rc.InputError, match=words) as caught:
        action(path)
    sentence = str(caught.value)
    assert "\n" not in sentence
    assert sentence.endswith(".")
    assert len(sentence) < 500


def test_the_watch_sees(tmp_path, monkeypatch):
    for action in (
        lambda: __import__("trap"),
        lambda: subprocess.run(["true"], check=True),
        lambda: os.system("true"),
        lambda: pickle.loads(pickle.dumps(rc.Love())),
        lambda: bytearray(2 * MEMORY),
    ):
        with pytest.raises(AssertionError), nothing_happens(tmp_path, monkeypatch):
            action()
        sys.modules.pop("trap", None)
        (tmp_path / "sprung").unlink(missing_ok=True)


def part(kind, name, **fields):
    return {"kind": kind, "name": name, "fields": fields}


BODY = ("problem", "fields", "body", "fields")
SURFACE = (*BODY, "surface")
# The place in the header, what is put there, and the sentence.
PARTS = {
    "an old class": (
        SURFACE,
        {"class": "subprocess:Popen", "fields": {"args": ["touch", "sprung"]}},
        "not describe a part",
    ),
    "a class of the library": (
        SURFACE,
        part("surface", "subprocess:Popen", args=["touch", "sprung"]),
        "surface subprocess:Popen must be registered",
    ),
    "a function": (SURFACE, part("surface", "os:system", command="touch sprung"), "os:system must be registered"),
    "a builtin": (SURFACE, part("part", "builtins:eval", source="1"), "part builtins:eval must be registered"),
    "a builtin unnamed": (SURFACE, part("part", "eval", source="1"), "part eval must be registered"),
    "a module on the path": (SURFACE, part("surface", "trap:Trap"), "surface trap:Trap must be registered"),
    "an entry point": (SURFACE, part("surface", "trap"), "surface trap must be registered"),
    "a private class": (SURFACE, part("surface", "roughcontact._parts.surfaces.base:_Samples"), "must be registered"),
    "a public function": (SURFACE, part("surface", "roughcontact:run_in"), "no surface named 'roughcontact:run_in'"),
    "a module of ours": (SURFACE, part("part", "roughcontact:archive"), "no part named 'roughcontact:archive'"),
    "an abstract class": (SURFACE, part("surface", "roughcontact:Surface"), "no surface named"),
    "an attribute": (SURFACE, part("surface", "roughcontact:Grid.__init__"), "no surface named"),
    "another problem": (SURFACE, part("part", "roughcontact:ContactProblem"), "stands where Surface must stand"),
    "a command": (SURFACE, part("command", "paper"), "no command named 'paper'"),
    "a kind that is not": (SURFACE, part("wormhole", "wavy"), "no wormhole named 'wavy'"),
    "a material as a surface": (SURFACE, part("material", "rigid"), "'rigid' stands where Surface must stand"),
    "a surface as a material": ((*BODY, "material"), part("surface", "flat"), "stands where Material must stand"),
    "a part as a number": (
        SURFACE,
        part("surface", "sphere", radius=part("surface", "flat")),
        "'flat' stands where .* must stand",
    ),
    "a part as the boundary": (
        ("problem", "fields", "boundary"),
        part("surface", "flat"),
        "stands where Boundary must",
    ),
    "a part as the grid": (("grid",), part("part", "roughcontact:Body"), "cannot be used"),
    "a text as a surface": (SURFACE, "wavy", "The surface of a body must be a Surface"),
    "a solver as a kernel": (
        ("problem", "fields", "kernel"),
        part("solver", "projected-cg"),
        "stands where str or InfluenceKernel must stand",
    ),
    "something else solved": (("problem",), part("surface", "flat"), "must be described as a ContactProblem"),
    "a list solved": (("problem",), [1, 2], "must be described as a ContactProblem"),
    "a field too many": (
        SURFACE,
        part("surface", "flat", path="/etc/passwd"),
        "fields of the surface 'flat' are nothing",
    ),
    "a field too few": (SURFACE, part("surface", "wavy"), "fields of the surface 'wavy' are amplitude"),
    "a wrong value": (SURFACE, part("surface", "sphere", radius="1 N"), "does not take its fields"),
    "fields in a list": (SURFACE, {"kind": "surface", "name": "flat", "fields": []}, "does not describe a part"),
    "a word more": (SURFACE, {**part("surface", "flat"), "then": "os:system"}, "does not describe a part"),
    "an array that is not there": (SURFACE, {"array": "../../x"}, "does not describe a part"),
    "a number that is not": (SURFACE, {"number": "1e999"}, "does not describe a part"),
    "a huge grid": (("grid",), {"mapping": {"shape": [2**40, 2**40], "size": [1.0, 1.0]}}, "2\\^40 cells"),
    "a large grid": (
        ("grid",),
        {"mapping": {"shape": [2**14, 2**14], "size": [1.0, 1.0]}},
        "on a grid of 16384 x 16384",
    ),
    "a grid of nothing": (("grid",), None, "its header is wrong"),
    "a status": (("status",), "__class__", "its header is wrong"),
    "a boundary": (("boundary",), ["free"], "its header is wrong"),
    "a pressure limit": (("pressure_limit",), "a", "its header is wrong"),
    "residuals": (("residuals",), {"mapping": {"complementarity": "a"}}, "its header is wrong"),
    "levels": (("levels",), 3, "its header is wrong"),
    "moduli": (("moduli",), 3, "its header is wrong"),
    "iterations": (("iterations",), [1], "its header is wrong"),
    "a history": (("history",), {"mapping": {"a": 1}}, "its header is wrong"),
    "a load": (("load",), ["force"], "its header is wrong"),
    "moduli without wave numbers": (("moduli",), [[1.0], [1.0, 2.0]], "It has 2 moduli at 1 wave numbers"),
    "levels of nothing": (
        ("levels",),
        [{"mapping": {"shape": "ab", "iterations": 1, "double": 1}}],
        "its header is wrong",
    ),
    "a name of lines": (SURFACE, part("surface", "a\n\x1b[31m:b"), "at most 400 printable characters"),
    "a name of a book": (SURFACE, part("surface", "a" * 10_000), "at most 400 printable characters"),
    "a kind of a book": (SURFACE, part("a" * 10_000, "a"), "at most 400 printable characters"),
    "a field of lines": (SURFACE, part("surface", "flat", **{"a\n\x1b" * 100: 1}), "fields of the surface 'flat' are"),
    "a status of a book": (("status",), "x" * 10_000, "its header is wrong"),
    "many classes": (
        SURFACE,
        part("surface", "sum", parts=[part("surface", f"a:{number}") for number in range(100)]),
        "a:4 must be registered, and 95 others as well",
    ),
    "another kind of file": (("kind",), "height map", "does not hold a solution"),
}


@pytest.mark.parametrize("name", PARTS)
def test_only_registered_parts_are_built(files, tmp_path, monkeypatch, name):
    place, content, words = PARTS[name]
    arrays, header = read_archive(files / "solution.npz")
    inner = header
    for key in place[:-1]:
        inner = inner[key]
    assert place[-1] in inner
    inner[place[-1]] = content
    # With its own key it would be refused for that.
    header["key"] = ""
    write_archive(tmp_path / "hostile.npz", arrays, header)
    refuse(tmp_path / "hostile.npz", words, tmp_path, monkeypatch)


def test_an_array_is_not_copied_more_often_than_the_file_is_long(files, tmp_path, monkeypatch):
    arrays, header = read_archive(files / "solution.npz")
    heights = np.zeros((128, 128))
    name = archive.digest_of(heights)
    surface = part("surface", "roughcontact:HeightMap", heights={"array": name}, size=1.0)
    header["problem"]["fields"]["body"]["fields"]["surface"] = part("surface", "sum", parts=[surface] * 1000)
    header["key"] = ""
    write_archive(tmp_path / "hostile.npz", {**arrays, f"part_{name}": heights}, header)
    refuse(tmp_path / "hostile.npz", "its problem names take 131072000 bytes", tmp_path, monkeypatch)


def cut_off(surface, length):
    return {**surface, "fields": {**surface["fields"], "rms_cutoff": length}}


WAVES = part("surface", "self-affine", hurst=0.8, shortest=3e-5, longest=1e-4, rms_height=1e-8)
# The place in the header, what is put there, and the sentence; 120 cells are computed in a millisecond.
WORK = {
    "waves": (SURFACE, cut_off(WAVES, 1e-9), "40000400001 waves on 120 cells"),
    "parts": (SURFACE, part("surface", "sum", parts=[cut_off(WAVES, 1e-6)] * 200), "202 surfaces of its problem"),
    "plain parts": (SURFACE, part("surface", "sum", parts=[part("surface", "flat")] * 9000), "9002 surfaces"),
    "nested parts": (
        SURFACE,
        part("surface", "sum", parts=[part("surface", "sum", parts=[cut_off(WAVES, 1e-6)] * 20)] * 10),
        "212 surfaces of its problem",
    ),
    "cells": (("problem", "fields", "grid"), part("part", "roughcontact:Grid", shape=[9000, 9000], size=1e-4), "9000"),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", WORK)
def test_no_file_takes_more_work_than_its_cells_warrant(files, tmp_path, monkeypatch, name):
    place, value, words = WORK[name]
    arrays, header = read_archive(files / "solution.npz")
    inner = header
    for key in place[:-1]:
        inner = inner[key]
    inner[place[-1]] = value
    header["key"] = ""
    write_archive(tmp_path / "hostile.npz", arrays, header)
    refuse(tmp_path / "hostile.npz", words, tmp_path, monkeypatch)


@pytest.mark.parametrize("boundary", ["free", "wrapped"])
def test_what_the_direct_sum_solved_is_verified_by_transforms(tmp_path, monkeypatch, boundary):
    surface = rc.SelfAffineSurface(hurst=0.8, shortest=3e-5, longest=1e-4, rms_height=1e-8, rms_cutoff=4e-6)
    problem = rc.ContactProblem(
        rc.Body(surface, rc.Elastic(2e11, 0.3)), grid=rc.Grid((27, 16), 1e-4), boundary=boundary, convolver="direct"
    )
    solution = problem.solve(pressure=1e6)
    solution.save(tmp_path / "solution.npz")
    monkeypatch.setattr("roughcontact._solve.convolvers.direct._DirectSum.apply", None)
    loaded = rc.ContactSolution.load(tmp_path / "solution.npz")
    np.testing.assert_array_equal(loaded.pressure, solution.pressure)
    assert loaded.origin.problem["convolver"] == "direct"


def npy(array):
    stream = io.BytesIO()
    np.save(stream, array, allow_pickle=True)
    return stream.getvalue()


def npy_of_shape(shape, descr="<f8", data=b"\0" * 64):
    stream = io.BytesIO()
    np.lib.format.write_array_header_1_0(stream, {"descr": descr, "fortran_order": False, "shape": shape})
    return stream.getvalue() + data


def sealed(path, content):
    """Put a right seal under anything."""
    path.write_bytes(content + SEAL)
    seal(path)


def sealed_zip(path, members, compression=zipfile.ZIP_STORED):
    with zipfile.ZipFile(path, "w", compression) as file:
        for name, content in members:
            file.writestr(name, content)
        file.comment = SEAL
    seal(path)


def members_of(files):
    with zipfile.ZipFile(files / "solution.npz") as file:
        return {name: file.read(name) for name in file.namelist()}


def replace_member(path, files, name, content):
    sealed_zip(path, [*{**members_of(files), name: content}.items()])


def replace_header(path, files, text):
    replace_member(path, files, "header.npy", npy(np.frombuffer(text, dtype=np.uint8)))


def doubled(path, files):
    with pytest.warns(UserWarning, match="Duplicate name"):
        sealed_zip(path, [*members_of(files).items(), ("pressure.npy", npy(np.ones((12, 10))))])


def deflated(method):
    def make(path, files):
        sealed_zip(path, members_of(files).items(), method)

    return make


def bomb(path, files):
    zeros = npy_of_shape((2**25,), data=bytes(2**28))
    sealed_zip(path, [*members_of(files).items(), ("bomb.npy", zeros)], zipfile.ZIP_DEFLATED)


def overlapping(path, files):
    """Many names of one stretch of bytes."""
    with zipfile.ZipFile(path, "w") as file:
        file.writestr("a.npy", npy(np.zeros(10_000)))
        first = file.infolist()[0]
        for number in range(200):
            other = zipfile.ZipInfo(f"{number}.npy")
            for field in ("header_offset", "CRC", "compress_size", "file_size"):
                setattr(other, field, getattr(first, field))
            file.filelist.append(other)
            file.NameToInfo[other.filename] = other
        file.comment = SEAL
    seal(path)


def newer(path, files):
    path.write_bytes((files / "solution.npz").read_bytes()[:-64].replace(b"format 1,", b"format 2,") + b"0" * 64)
    seal(path)


# An npy file whose header is declared to have 4 GiB.
ENDLESS = b"\x93NUMPY\x02\x00" + struct.pack("<I", 2**32 - 1) + b"{}"
# How the file is made, and the sentence.
CONTAINERS = {
    "nothing": (lambda path, files: path.write_bytes(b""), "does not end with a checksum"),
    "a text": (lambda path, files: path.write_bytes(b"pressure = 1\n"), "damaged, or was not written by roughcontact"),
    "numbers of numpy": (lambda path, files: np.savez(path, pressure=np.ones(3)), "does not end with a checksum"),
    "a newer file": (newer, "has format 2, but this version of roughcontact reads format 1"),
    "half a file": (
        lambda path, files: path.write_bytes((files / "solution.npz").read_bytes()[:2000]),
        "does not end with a checksum",
    ),
    "a byte more": (lambda path, files: path.write_bytes((files / "solution.npz").read_bytes() + b"\0"), "checksum"),
    "no archive": (lambda path, files: sealed(path, b"something else"), "not a zip file"),
    "a pickle": (
        lambda path, files: replace_member(path, files, "pressure.npy", npy(np.array([rc.Love()] * 120, dtype=object))),
        "an array of type object",
    ),
    "a bare pickle": (
        lambda path, files: replace_member(path, files, "pressure.npy", b"cos\nsystem\n(S'touch sprung'\ntR."),
        "magic",
    ),
    "a huge array": (
        lambda path, files: replace_member(path, files, "pressure.npy", npy_of_shape((2**40,))),
        "declares an array of type float64 and shape \\(1099511627776,\\)",
    ),
    "an array of nothings": (
        lambda path, files: replace_member(path, files, "pressure.npy", npy_of_shape((2**40,), "<U0")),
        "damaged",
    ),
    "an endless shape": (
        lambda path, files: replace_member(path, files, "pressure.npy", npy_of_shape((2**62, 2**62, 2**62))),
        "declares an array",
    ),
    "a negative shape": (
        lambda path, files: replace_member(path, files, "pressure.npy", npy_of_shape((-1, 120))),
        "declares an array",
    ),
    "code as a header of numpy": (
        lambda path, files: replace_member(
            path,
            files,
            "pressure.npy",
            b"\x93NUMPY\x01\x00" + struct.pack("<H", 40) + b"__import__('os').system('touch sprung')\n",
        ),
        "damaged",
    ),
    "a bomb": (bomb, "declares 268\\d+ bytes of data, more than a file of"),
    "deflated members": (deflated(zipfile.ZIP_DEFLATED), "compressed in a way that is not read"),
    "members of bzip2": (deflated(zipfile.ZIP_BZIP2), "compressed in a way that is not read"),
    "members of LZMA": (deflated(zipfile.ZIP_LZMA), "compressed in a way that is not read"),
    "a header of one long text": (
        lambda path, files: replace_header(path, files, b'{"kind": "' + b"a" * 2**20 + b'"}'),
        "damaged",
    ),
    "an endless header of numpy": (
        lambda path, files: replace_member(path, files, "pressure.npy", ENDLESS),
        "reading array header, expected 4294967295 bytes",
    ),
    "overlapping members": (overlapping, "more than a file of"),
    "a name twice": (doubled, "a name occurs twice"),
    "a path out of the folder": (
        lambda path, files: sealed_zip(path, [*members_of(files).items(), ("../../sprung.npy", npy(np.ones(3)))]),
        "its arrays are not those that its header lists",
    ),
    "a program inside": (
        lambda path, files: sealed_zip(path, [*members_of(files).items(), ("trap.py", b"import os")]),
        "magic",
    ),
    "another array": (
        lambda path, files: replace_member(path, files, "pressure.npy", npy(np.ones((12, 10)))),
        "its arrays are not those that its header lists",
    ),
    "no header": (
        lambda path, files: sealed_zip(path, [item for item in members_of(files).items() if "header" not in item[0]]),
        "no header",
    ),
    "a deep header": (lambda path, files: replace_header(path, files, b"[" * 100_000), "more than 150 levels"),
    "a long header": (
        lambda path, files: replace_header(path, files, b" " * (archive._MAX_HEADER_BYTES + 1)),
        "too long",
    ),
    "a header of one text": (lambda path, files: replace_header(path, files, b'"solution"'), "not a mapping"),
    "a header of no text": (lambda path, files: replace_header(path, files, b"\xff\xfe{}"), "damaged"),
    "not a number": (lambda path, files: replace_header(path, files, b'{"force": NaN}'), "the number NaN"),
    "infinity": (lambda path, files: replace_header(path, files, b'{"force": -Infinity}'), "the number -Infinity"),
    "an infinite number": (lambda path, files: replace_header(path, files, b'{"force": 1e999}'), "the number 1e999"),
    "an endless number": (
        lambda path, files: replace_header(path, files, b'{"force": ' + b"9" * 100_000 + b"}"),
        "the number 999",
    ),
    "half a header": (lambda path, files: replace_header(path, files, b'{"kind": "solution"'), "damaged"),
    "a header of little": (
        lambda path, files: replace_header(path, files, b'{"kind": "solution", "arrays": {}}'),
        "damaged",
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", CONTAINERS)
def test_damaged_and_foreign_archives_are_refused(files, tmp_path, monkeypatch, name):
    make, words = CONTAINERS[name]
    make(tmp_path / "hostile.npz", files)
    refuse(tmp_path / "hostile.npz", words, tmp_path, monkeypatch)


def with_netcdf(change):
    def make(path, files):
        path.write_bytes((files / "solution.nc").read_bytes()[: -len(SEAL)])
        with h5py.File(path, "r+") as file:
            change(file, path.parent)
        with path.open("ab") as stream:
            stream.write(SEAL)
        seal(path)

    return make


def link(kind, *place):
    def change(file, folder):
        del file["pressure"]
        file["pressure"] = kind(*(str(part).format(folder=folder) for part in place))

    return change


def external_storage(file, folder):
    (folder / "secret").write_bytes(b"\1" * 960)
    del file["pressure"]
    file.create_dataset("pressure", (12, 10), "f8", external=[(str(folder / "secret"), 0, 960)])


def virtual(file, folder):
    del file["pressure"]
    layout = h5py.VirtualLayout((12, 10), "f8")
    layout[:] = h5py.VirtualSource(str(folder / "other.nc"), "pressure", shape=(12, 10))
    file.create_virtual_dataset("pressure", layout)


def dataset(**options):
    def change(file, folder):
        del file["pressure"]
        file.create_dataset("pressure", **options)

    return change


def opaque(tag, length, attribute):
    """Bytes whose type the file chooses: of Python's objects, they would be taken for addresses."""

    def change(file, folder):
        kind = h5py.h5t.create(h5py.h5t.OPAQUE, 8)
        kind.set_tag(tag)
        space = h5py.h5s.create_simple((length,))
        if attribute:
            target = h5py.h5a.create(file["pressure"].id, b"dtype", kind, space)
            target.write(np.full(length, b"AAAABBBB", "V8"), mtype=kind)
        else:
            del file["pressure"]
            h5py.h5d.create(file.id, b"pressure", kind, space)

    return change


def long_note(file, folder):
    file["pressure"].attrs["dtype"] = np.bytes_(b"bool" + b" " * 1000)


def note_of_many(file, folder):
    file["pressure"].attrs["dtype"] = ["bool", "bool"]


def many_names(file, folder):
    file["large"] = np.zeros(10_000)
    for number in range(1000):
        file[f"large{number}"] = file["large"]


def other_values(file, folder):
    file["pressure"][...] = 1.0


NETCDF = {
    "a text": (lambda path, files: path.write_bytes(b"CDF\x01"), "does not end with a checksum"),
    "a foreign file": (
        lambda path, files: xarray.Dataset({"a": 1.0}).to_netcdf(path, engine="h5netcdf"),
        "does not end with a checksum",
    ),
    "no HDF5": (lambda path, files: sealed(path, b"something else"), "damaged"),
    "a link to another file": (
        with_netcdf(link(h5py.ExternalLink, "{folder}/other.nc", "/pressure")),
        "'pressure' is not",
    ),
    "a link inside": (with_netcdf(link(h5py.SoftLink, "/gap")), "'pressure' is not an array in it"),
    "values in another file": (with_netcdf(external_storage), "not stored as plain numbers inside it"),
    "a view of another file": (with_netcdf(virtual), "not stored as plain numbers inside it"),
    "a bomb": (
        with_netcdf(dataset(shape=(2**14, 2**14), dtype="f8", chunks=(2**10, 2**10), compression="gzip")),
        "not stored as plain numbers inside it",
    ),
    "an array never written": (with_netcdf(dataset(shape=(2**20, 2**20), dtype="f8")), "not stored as plain numbers"),
    "texts of any length": (with_netcdf(dataset(data=["a", "b"])), "not stored as plain numbers inside it"),
    "references": (
        with_netcdf(dataset(shape=(12, 10), dtype=h5py.ref_dtype)),
        "not stored as plain numbers inside it",
    ),
    "addresses": (with_netcdf(opaque(b"NUMPY:|O", 4, attribute=False)), "not stored as plain numbers inside it"),
    "bytes as numbers": (with_netcdf(opaque(b"NUMPY:f8", 4, attribute=False)), "not stored as plain numbers inside it"),
    "many names of an array": (with_netcdf(many_names), "not stored as plain numbers inside it"),
    "a folder": (with_netcdf(lambda file, folder: file.create_group("more")), "'more' is not an array in it"),
    "other values": (with_netcdf(other_values), "its arrays are not those that its header lists"),
    "an array too many": (
        with_netcdf(lambda file, folder: file.create_dataset("more", data=np.ones(3))),
        "its arrays are not those that its header lists",
    ),
}


@pytest.mark.parametrize("name", NETCDF)
def test_damaged_and_foreign_netcdf_is_refused(files, tmp_path, monkeypatch, name):
    make, words = NETCDF[name]
    make(tmp_path / "hostile.nc", files)
    refuse(tmp_path / "hostile.nc", words, tmp_path, monkeypatch)


NOTES = {
    "addresses": opaque(b"NUMPY:|O", 4, attribute=True),
    "a huge type": opaque(b"NUMPY:<U200000000", 1, attribute=True),
    "a long text": long_note,
    "two texts": note_of_many,
}


@pytest.mark.slow
@pytest.mark.parametrize("name", NOTES)
def test_only_a_short_text_beside_an_array_is_read(files, tmp_path, monkeypatch, name):
    """In a process of its own, because h5py would read addresses that end it."""
    with_netcdf(NOTES[name])(tmp_path / "hostile.nc", files)
    code = "import roughcontact, sys; print(roughcontact.ContactSolution.load(sys.argv[1]).status.name)"
    ran = subprocess.run([sys.executable, "-c", code, str(tmp_path / "hostile.nc")], capture_output=True, text=True)
    assert ran.returncode == 0, ran.stderr
    with nothing_happens(tmp_path, monkeypatch):
        use(tmp_path / "hostile.nc")


def lying_zip(method, content, size):
    """A map whose directory states another size than it expands to."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", method) as file:
        file.writestr("heights.npy", content)
    data = bytearray(stream.getvalue())
    struct.pack_into("<I", data, data.rfind(b"PK\1\2") + 24, size)
    return bytes(data)


def deflated_map(shape, descr):
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as file:
        file.writestr("heights.npy", npy_of_shape(shape, descr, bytes(shape[0] * shape[1])))
    return stream.getvalue()


MAPS = {
    "an endless header": ("npy", ENDLESS, "reading array header, expected 4294967295 bytes"),
    "a bomb of another kind": (
        "npz",
        lying_zip(zipfile.ZIP_BZIP2, npy_of_shape((16, 16), data=bytes(2**26)), 2176),
        "compressed in a way that is not read",
    ),
    "a dictionary": ("npz", lying_zip(zipfile.ZIP_LZMA, npy(np.ones((4, 4))), 256), "compressed in a way"),
    "small numbers": ("npz", deflated_map((2**12, 3000), "|i1"), "declares 12288000 numbers, more than a file of"),
    "a pickle": ("npy", npy(np.array([rc.Love()], dtype=object)), "an array of type object"),
    "a huge map": ("npy", npy_of_shape((2**20, 2**20)), "declares an array of type float64 and shape"),
    "records": ("npy", npy(np.zeros(3, dtype=[("a", "f8")])), "holds an array of type"),
    "texts": ("npy", npy(np.array([["a", "b"]])), "must be an array of real numbers"),
    "nothing": ("npz", b"", "cannot be read as a height map"),
    "endless numbers": ("txt", b"1 " + b"9" * 10_000 + b"\n2 3\n", "line 1 holds 9+, which is too large"),
    "rows that differ": ("txt", b"1 2 3\n4 5\n", "line 2 has 2 numbers"),
    "words": ("txt", b"__import__('os').system('touch sprung')\n", "it holds no numbers, and begins with"),
}


@pytest.mark.parametrize("name", MAPS)
def test_hostile_height_maps_are_refused(tmp_path, monkeypatch, name):
    suffix, content, words = MAPS[name]
    path = tmp_path / f"hostile.{suffix}"
    path.write_bytes(content)
    refuse(path, words, tmp_path, monkeypatch, lambda path: rc.read_surface(path, size=1e-3))


@pytest.mark.slow
def test_a_height_map_that_is_a_bomb_is_refused(tmp_path, monkeypatch):
    path = tmp_path / "bomb.npz"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        file.writestr("heights.npy", npy_of_shape((2**12, 2**13), data=bytes(2**28)))
    words = "declares 268435584 bytes of data"
    refuse(path, words, tmp_path, monkeypatch, lambda path: rc.read_surface(path, size=1e-3))


STUDIES = {
    "a key of many parts": ("[problems]\na" + ".a" * 20_000 + " = 1\n", "a key has too many parts"),
    "a key of many texts": ('[problems]\n"\\""' + ' . "\\""' * 20_000 + " = 1\n", "a key has too many parts"),
    "a table of lines": ('"a\\n\\u001b" = 1\n', "unknown table"),
    "a table of a book": ("a" * 10_000 + " = 1\n", "unknown table"),
}


def zip_of(method=zipfile.ZIP_DEFLATED, **members):
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", method) as file:
        for name, content in members.items():
            file.writestr(name, content)
    return stream.getvalue()


NOISE = np.random.default_rng(0).bytes(2**18)
ARCHIVES = {
    "zeros": (zip_of(**{"main.xml": b"", "bindata/data.bin": bytes(5 * 10**7)}), "declares 50000000 bytes of data"),
    "elements": (
        zip_of(**{"main.xml": b"<a>1</a>" * 10**6, "data.bin": NOISE}),
        "a description in it has 8000000 bytes",
    ),
    "a recipe": (zip_of(**{"Recipe.TXT": bytes(10**7), "data.bin": NOISE}), "a description in it has 10000000 bytes"),
    "bzip2": (zip_of(zipfile.ZIP_BZIP2, **{"main.xml": b"<a/>"}), "compressed in a way that is not read"),
}


@pytest.mark.parametrize("suffix", [".x3p", ".plux", ".oir", ".unknown"])
@pytest.mark.parametrize("name", ARCHIVES)
def test_archives_of_instruments_are_bounded(tmp_path, monkeypatch, name, suffix):
    content, words = ARCHIVES[name]
    path = tmp_path / f"hostile{suffix}"
    path.write_bytes(content)
    refuse(path, words, tmp_path, monkeypatch, rc.read_surface)


@pytest.mark.parametrize("name", STUDIES)
def test_hostile_studies_are_refused(tmp_path, name):
    text, words = STUDIES[name]
    (tmp_path / "study.toml").write_text(text)
    with pytest.raises(rc.InputError, match=words) as caught:
        read_study(tmp_path / "study.toml")
    assert str(caught.value).isprintable()
    assert len(str(caught.value)) < 1000


@posix
def test_a_list_of_records_is_a_file(tmp_path):
    """A pipe would be waited for, and a device read without end."""
    os.mkfifo(tmp_path / "pipe.json")
    (tmp_path / "device.json").symlink_to("/dev/zero")
    for name in ("pipe.json", "device.json"):
        assert read_index(tmp_path / name) == {}


ESCAPE = "\x1b[31m\u202e\r"


def test_no_file_reaches_the_terminal_with_its_escape_sequences(files, tmp_path, capsys):
    arrays, header = read_archive(files / "solution.npz")
    inner = header
    for key in SURFACE:
        inner = inner[key]
    surface = inner["fields"]["parts"][0]
    surface["fields"]["history"] = [f"read from {ESCAPE}map.npz"]
    header["key"] = right_key(header)
    path = tmp_path / "hostile.npz"
    write_archive(path, arrays, header)
    problem = use(path)
    texts = [str(rc.ContactProblem(**problem).explain()), str(problem["body"].surface.parts[0])]
    for arguments in (["info", str(path)], ["info", str(tmp_path / f"{ESCAPE}none.npz")], [f"{ESCAPE}"]):
        main(arguments)
        texts += capsys.readouterr()
    for text in texts:
        assert not set(ESCAPE) - set("[31m") & set(text), text
    assert any("\\x1b[31m" in text for text in texts)


@posix
@pytest.mark.parametrize("what", ["device", "pipe"])
@pytest.mark.parametrize("name", ["solution.npz", "solution.nc"])
def test_a_file_that_is_swapped_while_it_is_opened_is_refused(files, tmp_path, monkeypatch, name, what):
    path, other = tmp_path / name, tmp_path / "other"
    path.write_bytes((files / name).read_bytes())
    other.symlink_to("/dev/zero") if what == "device" else os.mkfifo(other)
    monkeypatch.setitem(swapped, str(path), str(other))
    refuse(path, "There is no file", tmp_path, monkeypatch)
    assert not swapped


def test_maps_that_deflate_well_are_read(tmp_path):
    heights = np.tile(1e-6 * np.cos(np.linspace(0.0, 50.0, 1000)), (1000, 1))
    np.savez_compressed(tmp_path / "wave.npz", heights=heights, size=1e-3)
    assert (tmp_path / "wave.npz").stat().st_size < heights.nbytes / 50
    np.testing.assert_array_equal(rc.read_surface(tmp_path / "wave.npz").values, heights)


@pytest.mark.parametrize(("name", "count"), [("solution.npz", 100), ("solution.nc", 100)])
def test_every_flipped_bit_is_found(files, tmp_path, name, count):
    intact = (files / name).read_bytes()
    rng = np.random.default_rng(12)
    for position in rng.integers(8 * len(intact), size=count):
        content = bytearray(intact)
        content[position // 8] ^= 1 << (position % 8)
        (tmp_path / name).write_bytes(content)
        with pytest.raises(rc.InputError, match=r"is damaged, or was not written by roughcontact: it"):
            rc.ContactSolution.load(tmp_path / name)


def test_a_flipped_bit_at_each_place_of_the_end_is_found(files, tmp_path):
    """The directory of the archive and the seal itself, where a checksum of the arrays alone sees nothing."""
    intact = (files / "solution.npz").read_bytes()
    for place in range(1, 600):
        content = bytearray(intact)
        content[-place] ^= 1 << (place % 8)
        (tmp_path / "solution.npz").write_bytes(content)
        with pytest.raises(rc.InputError, match="damaged"):
            rc.ContactSolution.load(tmp_path / "solution.npz")


def test_others_read_the_files(files, solution):
    """Numpy and xarray read sealed files."""
    with np.load(files / "solution.npz", allow_pickle=False) as data:
        np.testing.assert_array_equal(data["pressure"], solution.pressure)
        assert json.loads(bytes(data["header"]))["kind"] == "solution"
    with xarray.open_dataset(files / "solution.nc", engine="h5netcdf") as data:
        np.testing.assert_array_equal(data["pressure"], solution.pressure)
        assert data["pressure"].attrs["units"] == "Pa"


def test_the_header_lists_what_the_file_holds(files):
    for name in ("solution.npz", "solution.nc"):
        with archive.opened(files / name):
            pass
    arrays, header = read_archive(files / "solution.npz")
    assert len(header["key"]) == 32
    assert json.loads(bytes(pack(arrays, header)["header"]))["arrays"].keys() == arrays.keys()


@pytest.mark.slow
def test_a_damaged_heap_of_texts_is_not_searched(tmp_path):
    heights, missing = np.random.default_rng(0).random((12, 10)) * 1e-7, np.eye(12, 10) > 0
    surface = rc.HeightMap(heights, (1e-4, 1e-4), non_measured=missing)
    solution = rc.ContactProblem(rc.Body(surface, rc.Elastic(210e9, 0.3))).solve(force=2.0)
    path = tmp_path / "solution.nc"
    solution.save(path)
    content = path.read_bytes()[: -len(SEAL)]
    # Objects without a size follow the head of 16 bytes: HDF5 would step from one to itself.
    first, *heaps = content.split(b"GCOL")
    path.write_bytes(b"GCOL".join([first, *(heap[:12] + bytes(len(heap[12:204])) + heap[204:] for heap in heaps)]))
    with path.open("ab") as file:
        file.write(SEAL)
    seal(path)
    script = "import sys, roughcontact as rc; print(rc.ContactSolution.load(sys.argv[1]).non_measured.sum())"
    child = subprocess.run([sys.executable, "-c", script, str(path)], capture_output=True, text=True, timeout=60)
    assert child.stdout.split() == ["10"], child.stderr
