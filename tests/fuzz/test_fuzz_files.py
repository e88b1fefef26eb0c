"""Files damaged at random, or forged with right digests: none is accepted with other data, and none stops a study.

A case is a number: it seeds what is done to which file. `pytest -m slow tests/fuzz/test_fuzz_files.py` runs all of
them; a number that once failed stays in FAILED.
"""

from __future__ import annotations

import contextlib
import copy
import hashlib
import io
import signal
import tracemalloc

import attrs
import numpy as np
import pytest
import scipy.io

import roughcontact as rc
from damage import damage_bytes, forge, forge_header, write_forged
from strategies import STRICT
from unit_files import SEAL, read_archive, read_index, seal, write_archive

h5py = pytest.importorskip("h5py")
tifffile = pytest.importorskip("tifffile")
pytest.importorskip("h5netcdf")

# Files of solutions and lists of records, height maps, and paths in the long run, of which the ordinary run takes the
# first.
FILES, MAPS, PATHS = 2_000, 3_000, 1_000
SHORT = 120
# Cases of one test of the long run.
BLOCK = 250
FAILED: tuple[int, ...] = ()
# Seconds after which a file counts as one that is never read.
PATIENCE = 60
# Bytes that reading one of these files, of some 10 kB, may take.
MEMORY = 2**24
# Relative difference that counts as the same: rounding stays far below it, and every forgery changes more.
SAME = 1e-8
# ... between two solves of one problem, whose errors are below 1e-6.
SOLVED = 1e-5


def make_problems():
    """Yield three problems with a load: with a pressure limit, with random heights, with non-measured points."""
    rng = np.random.default_rng(0)
    heights, missing = rng.random((12, 10)) * 1e-7, rng.random((12, 10)) < 0.1
    grid, steel = rc.Grid((12, 10), 1e-4), rc.Elastic(210e9, 0.3)
    plastic = rc.ElasticPerfectlyPlastic(210e9, 0.3, np.linspace(2e9, 6e9, 120).reshape(12, 10))
    repeated = rc.HeightMap(heights, (1e-4, 1e-4), periodic=True) + rc.WavySurface(1e-8, 5e-5)
    rough = rc.SelfAffineSurface(hurst=0.8, rms_height=1e-7, longest=1e-4, shortest=2e-5, seed=5)
    measured = rc.HeightMap(heights, (1e-4, 1e-4), non_measured=missing)
    yield rc.ContactProblem(rc.Body(repeated, plastic), grid=grid, boundary="periodic", solver=STRICT), {"force": 2.0}
    yield rc.ContactProblem(rc.Body(rough, steel), grid=grid, convolver=rc.DCFFT(), solver=STRICT), {"pressure": 1e7}
    yield rc.ContactProblem(rc.Body(measured, steel), solver=STRICT), {"approach": 5e-8}


PROBLEMS = tuple(make_problems())


def run_study(folder):
    problem, load = PROBLEMS[0]
    return rc.Study(problems=problem, force=[load["force"], 1.5], areas=["blend"]).run(folder)


@pytest.fixture(scope="module")
def intact(tmp_path_factory):
    """Solutions with their files, and the files of a study."""
    folder = tmp_path_factory.mktemp("intact")
    solutions = [problem.solve(**load) for problem, load in PROBLEMS]
    for number, solution in enumerate(solutions):
        for suffix in ("npz", "nc"):
            solution.save(folder / f"{number}.{suffix}")
    files = {path.name: path.read_bytes() for path in folder.iterdir()}
    contents = [read_archive(folder / f"{number}.npz") for number in range(len(solutions))]
    result = run_study(folder / "study")
    study = {path.name: path.read_bytes() for path in (folder / "study").iterdir()}
    return solutions, files, contents, result, study


@pytest.fixture(scope="module", autouse=True)
def readers(tmp_path_factory):
    """Load the packages of all readers before their memory is measured."""
    path = tmp_path_factory.mktemp("readers") / "nothing.txt"
    path.write_bytes(b"\xff\0")
    for name in rc.readers:
        with contextlib.suppress(rc.InputError, rc.MissingPackage):
            rc.read_surface(path, reader=name)


@contextlib.contextmanager
def patient():
    """Fail if what is done inside never ends."""

    def stop(*_):
        raise KeyboardInterrupt("a file is never read")

    # Windows has no alarm: there the time limit of the test run must do.
    has_alarm = hasattr(signal, "alarm")
    if has_alarm:
        before = signal.signal(signal.SIGALRM, stop)
        signal.alarm(PATIENCE)
    try:
        yield
    finally:
        if has_alarm:
            signal.alarm(0)
            signal.signal(signal.SIGALRM, before)


@contextlib.contextmanager
def bounded():
    """Fail if what is done inside takes too much memory, or never ends."""
    with patient():
        tracemalloc.start()
        try:
            yield
        finally:
            peak = tracemalloc.get_traced_memory()[1]
            tracemalloc.stop()
    assert peak < MEMORY


def require_true(loaded, original):
    """Raise AssertionError unless a solution is the original, or another problem's that its file states with it."""
    try:
        require_same(loaded, original)
    except AssertionError:
        again = rc.ContactProblem(**loaded.origin.problem).solve(**loaded.origin.load)
        for name in ("pressure", "displacement", "initial_gap"):
            given, right = getattr(loaded, name), getattr(again, name)
            np.testing.assert_allclose(given, right, rtol=SOLVED, atol=SOLVED * np.abs(right).max(), err_msg=name)


def require_same(loaded, original):
    """Raise AssertionError unless a solution states what the original states, save its cost and how it was found."""
    assert (loaded.boundary, loaded.grid) == (original.boundary, original.grid)
    for name in ("pressure", "displacement", "initial_gap", "gap", "pressure_limit", "contact", "saturated"):
        given, right = getattr(loaded, name), getattr(original, name)
        assert given.shape == right.shape
        largest = np.abs(right[np.isfinite(right)], dtype=float).max(initial=0.0)
        np.testing.assert_allclose(given, right, rtol=SAME, atol=SAME * largest, err_msg=name)
    for name in ("modulus", "approach", "force", "mean_pressure", "edge_shift"):
        assert getattr(loaded, name) == pytest.approx(getattr(original, name), rel=SAME), name
    np.testing.assert_allclose(attrs.astuple(loaded.residuals), attrs.astuple(original.residuals), rtol=SAME, atol=SAME)


def read_or_refuse(read, path, **options):
    """Return what is in a file, or None where it is refused with one sentence."""
    sentence = ""
    with bounded():
        try:
            return read(path, **options)
        except rc.InputError as error:
            sentence = str(error)
    assert "\n" not in sentence
    assert sentence.endswith(".")
    return None


def write_case(path, data, content, other, rng):
    """Write a damaged or forged file; tell whether that could be written at all."""
    way = rng.choice(["damaged", "sealed again", "forged", "forged", "forged"])
    if way == "damaged":
        path.write_bytes(damage_bytes(data, rng))
    elif way == "sealed again":
        path.write_bytes(damage_bytes(data[: -len(SEAL)], rng) + SEAL)
        seal(path)
    else:
        try:
            write_forged(path, *forge(content, other, rng))
        except (rc.InputError, ValueError, TypeError, OverflowError):
            return False
    return True


def try_solution(number, intact, folder):
    """Damage or forge the file of a solution, and load it; then put it into a study in the place of its own."""
    rng = np.random.default_rng([1, number])
    solutions, files, contents, result, study = intact
    which, suffix = int(rng.integers(len(solutions))), ("npz", "nc")[int(rng.random() < 0.4)]
    path = folder / f"case.{suffix}"
    while not write_case(path, files[f"{which}.{suffix}"], contents[which], contents[(which + 1) % 3], rng):
        pass
    loaded = read_or_refuse(rc.ContactSolution.load, path)
    if loaded is not None:
        require_true(loaded, solutions[which])
    if which == 0 and suffix == "npz":
        key = result.records[0].key
        require_study(folder / "study", study | {f"{key}.npz": path.read_bytes()}, result, rng)
    return loaded is not None


def try_index(number, intact, folder):
    """Damage or forge the list of records of a study."""
    rng = np.random.default_rng([2, number])
    *_, result, study = intact
    (name,) = (name for name in study if name.endswith(".json"))
    text = study[name] if rng.random() < 0.5 else forge_index(study[name].decode(), result, rng)
    data = damage_bytes(text, rng) if text == study[name] else text
    (folder / name).write_bytes(data)
    with bounded():
        accepted = bool(read_index(folder / name))
    require_study(folder / "study", study | {name: data}, result, None)
    return accepted


def forge_index(text, result, rng):
    """Return a list of records in which a number, or a key, is another, with the right checksum."""
    head, lines, tail = text.split("\n", 1)[0], text.split("\n")[1:-2], text.split("\n")[-2:]
    row = int(rng.integers(len(lines)))
    values = [word for word in lines[row].replace("}", ",").replace("]", ",").split(",") if ":" in word or "." in word]
    old = values[rng.integers(len(values))].split(":")[-1].strip(" [{")
    odd = ["0.0", "-1", "1e300", "null", '"x"', "7.5", '{"number": "nan"}', f'"{result.records[1].key}"', "true"]
    lines[row] = lines[row].replace(old, odd[rng.integers(len(odd))], 1) if old else lines[row][:-1]
    body = "\n".join(lines)
    start = head.index('"sha256": "') + len('"sha256": "')
    head = head[:start] + hashlib.sha256(body.encode()).hexdigest() + head[start + 64 :]
    return "\n".join([head, body, *tail]).encode()


def require_study(folder, files, result, rng):
    """Raise AssertionError unless a study with these files gives the records of the intact one."""
    folder.mkdir(exist_ok=True)
    for path in folder.iterdir():
        path.unlink()
    for name, data in files.items():
        if rng is None or not name.endswith(".json") or rng.random() < 0.5:
            (folder / name).write_bytes(data)
    # The memory is measured where a file is read alone: a study reads as many times as slowly where it is traced.
    with patient():
        again = run_study(folder)
    # What the files of the solutions do not state is taken from the list.
    listed = {"seconds": 0.0, "iterations": 0, "convolutions": 0, "message": "", "warnings": (), "doubtful": False}
    listed |= {"peak_pressure": 0.0, "peak_pressure_uncertainty": 0.0}
    for one, right in zip(again.records, result.records, strict=True):
        assert attrs.evolve(one, **listed) == attrs.evolve(right, **listed)


def saved(save, *arguments, **options):
    """Return what a function that writes into a stream has written."""
    stream = io.BytesIO()
    save(stream, *arguments, **options)
    return stream.getvalue()


def write_hdf5(heights):
    """Return a file as MATLAB writes version 7.3: a head of 512 bytes, and deflated parts of arrays."""
    stream = io.BytesIO()
    with h5py.File(stream, "w", userblock_size=512) as file:
        file.create_dataset("heights", data=heights.T, chunks=(3, 3), compression=3, shuffle=True)
        file["heights"].attrs["MATLAB_class"] = np.bytes_("double")
        file.create_dataset("dx", data=[[1e-5]])
    return (b"MATLAB 7.3 MAT-file".ljust(124) + b"\0\2IM" + stream.getvalue()[128:]).ljust(1024, b"\0")


def list_points(heights):
    i, j = np.indices(heights.shape)
    return "X,Y,Z\n" + "\n".join(f"{x},{y},{z}" for x, y, z in zip(i.flat, j.flat, heights.flat, strict=True))


# A writer of each kind of file that holds a map.
WRITERS = {
    "map.npz": lambda heights: saved(np.savez_compressed, heights),
    "map.npy": lambda heights: saved(np.save, heights),
    "map.txt": lambda heights: saved(np.savetxt, heights),
    "decimal.csv": lambda heights: saved(np.savetxt, heights, delimiter=";").replace(b".", b","),
    "header.csv": lambda heights: b"# Width: 1 \xb5m\n# Height: 1 um\n" + saved(np.savetxt, heights, delimiter=","),
    "points.csv": lambda heights: list_points(heights).encode(),
    "wide.txt": lambda heights: "\n".join("\t".join(map(str, row)) for row in heights.tolist()).encode("utf-16"),
    "plain.mat": lambda heights: saved(scipy.io.savemat, {"heights": heights, "dx": 1e-5, "notes": {"a": "b"}}),
    "deflated.mat": lambda heights: saved(scipy.io.savemat, {"heights": heights, "dx": 1e-5}, do_compression=True),
    "hdf5.mat": write_hdf5,
    "plain.tif": lambda heights: saved(tifffile.imwrite, heights.astype("f4")),
    "deflated.tif": lambda heights: saved(tifffile.imwrite, heights, compression="zlib"),
    "tiled.tif": lambda heights: saved(tifffile.imwrite, heights.repeat(4, 0).repeat(4, 1), tile=(16, 16)),
}


def try_map(number, folder):
    """Damage a height map: its numbers have no checksum, so it is refused or has finite heights."""
    rng = np.random.default_rng([3, number])
    name = sorted(WRITERS)[number % len(WRITERS)]
    path = folder / name
    path.write_bytes(damage_bytes(WRITERS[name](rng.random((6, 5)) * 1e-6), rng))
    non_measured = ("refuse", "keep", "fill")[int(rng.integers(3))]
    unit = {"unit": 1.0} if name.endswith(".tif") else {}
    found = read_or_refuse(rc.read_surface, path, size=1e-4, non_measured=non_measured, **unit)
    assert found is None or np.isfinite(found.heights(found.grid)).all()


@pytest.fixture(scope="module")
def paths(tmp_path_factory):
    """Paths that are flattened and worn, with the bytes and the content of their files."""
    file = tmp_path_factory.mktemp("paths") / "path.npz"
    hard, load = PROBLEMS[0]
    elastic = rc.ContactProblem(rc.Body(rc.SphereSurface(1e-3), rc.Elastic(210e9, 0.3)), grid=rc.Grid((12, 10), 1e-4))
    followed = [
        hard.path(force=[load["force"], 0.5, 1.0]),
        attrs.evolve(elastic, laws=rc.Archard(1e-16)).path(force=[1.0, 0.5], sliding=[0.0, 0.1]),
    ]
    made = []
    for one in followed:
        one.save(file)
        made.append((one, file.read_bytes(), read_archive(file)))
    return made


def try_path(number, paths, folder):
    """Damage or forge the file of a path, and load it: it is refused, or its states are those of the original."""
    rng = np.random.default_rng([4, number])
    which = int(rng.integers(len(paths)))
    original, data, (arrays, header) = paths[which]
    file = folder / "path.npz"
    if rng.random() < 0.4:
        file.write_bytes(damage_bytes(data, rng))
    elif rng.random() < 0.2:
        file.write_bytes(damage_bytes(data[: -len(SEAL)], rng) + SEAL)
        seal(file)
    else:
        changed = copy.deepcopy(header)
        forge_header(arrays, changed, paths[1 - which][2], rng)
        write_archive(file, arrays, changed)
    loaded = read_or_refuse(rc.results.LoadPath.load, file)
    if loaded is not None:
        np.testing.assert_allclose(loaded.sliding, original.sliding, rtol=SAME)
        for one, other in zip(loaded, original, strict=True):
            require_same(one, other)
            (remembered,), (right,) = one.added, other.added
            for name, (values, *_) in remembered.list_fields().items():
                expected = right.list_fields()[name][0]
                np.testing.assert_allclose(
                    values, expected, rtol=SAME, atol=SAME * np.abs(expected).max(), err_msg=name
                )


def run_files(numbers, intact, folder):
    for number in numbers:
        try:
            try_index(number, intact, folder) if number % 5 == 4 else try_solution(number, intact, folder)
        except BaseException as error:
            raise AssertionError(f"case {number}: {error!r}") from error


def run_maps(numbers, folder):
    for number in numbers:
        try:
            try_map(number, folder)
        except BaseException as error:
            raise AssertionError(f"map {number}: {error!r}") from error


def test_intact_files_are_accepted(intact, tmp_path):
    solutions, files, _, result, study = intact
    for number, solution in enumerate(solutions):
        for suffix in ("npz", "nc"):
            (tmp_path / f"case.{suffix}").write_bytes(files[f"{number}.{suffix}"])
            require_same(read_or_refuse(rc.ContactSolution.load, tmp_path / f"case.{suffix}"), solution)
    require_study(tmp_path / "study", study, result, None)


def test_some_damaged_maps(tmp_path):
    run_maps(range(SHORT), tmp_path)


def run_paths(numbers, paths, folder):
    for number in numbers:
        try:
            try_path(number, paths, folder)
        except BaseException as error:
            raise AssertionError(f"path {number}: {error!r}") from error


def test_some_damaged_paths(paths, tmp_path):
    run_paths(range(SHORT // 2), paths, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("start", range(0, PATHS, BLOCK))
def test_every_damaged_path(paths, tmp_path, start):
    run_paths(range(start, start + BLOCK), paths, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("start", range(0, FILES, BLOCK))
def test_every_damaged_file(intact, tmp_path, start):
    run_files([*FAILED, *range(start, start + BLOCK)], intact, tmp_path)


@pytest.mark.slow
def test_every_damaged_map(tmp_path):
    run_maps(range(MAPS), tmp_path)
