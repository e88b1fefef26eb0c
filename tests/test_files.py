from __future__ import annotations

import sys

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.files.missing import filled

HEIGHTS = np.random.default_rng(0).random((5, 7)) * 1e-6


def test_npz_keeps_heights_size_and_period(tmp_path):
    path = tmp_path / "map.npz"
    np.savez(path, heights=HEIGHTS, size=(1e-3, 2e-3), periodic=True)
    surface = rc.read_surface(path)
    np.testing.assert_array_equal(surface.values, HEIGHTS)
    assert surface.size == (1e-3, 2e-3)
    assert surface.periodic


def test_npy_and_text_need_a_size(tmp_path):
    np.save(tmp_path / "map.npy", HEIGHTS)
    np.savetxt(tmp_path / "map.txt", HEIGHTS, header="heights in metres")
    np.savetxt(tmp_path / "map.csv", HEIGHTS, delimiter=",")
    for name in ("map.npy", "map.txt", "map.csv"):
        with pytest.raises(rc.InputError, match="give size="):
            rc.read_surface(tmp_path / name)
        surface = rc.read_surface(str(tmp_path / name), size=(1e-3, 2e-3))
        np.testing.assert_array_equal(surface.values, HEIGHTS)
        assert not surface.periodic


def test_a_size_that_the_file_tells_is_not_overruled(tmp_path):
    np.savez(tmp_path / "map.npz", heights=HEIGHTS, size=1e-3)
    with pytest.raises(rc.InputError, match="leave size= out"):
        rc.read_surface(tmp_path / "map.npz", size=1.0)


def test_missing_points_are_refused_or_filled(tmp_path):
    holey = HEIGHTS.copy()
    holey[2, 3] = holey[0, 0] = np.nan
    np.savez(tmp_path / "map.npz", heights=holey, size=1e-3)
    with pytest.raises(rc.InputError, match="misses 2 of 35 points"):
        rc.read_surface(tmp_path / "map.npz")
    surface = rc.read_surface(tmp_path / "map.npz", missing="fill")
    known = np.isfinite(holey)
    np.testing.assert_array_equal(surface.values[known], HEIGHTS[known])
    assert surface.values[2, 3] == pytest.approx(np.mean([HEIGHTS[1, 3], HEIGHTS[3, 3], HEIGHTS[2, 2], HEIGHTS[2, 4]]))
    assert surface.values[0, 0] == pytest.approx(np.mean([HEIGHTS[0, 1], HEIGHTS[1, 0]]))


def test_filling_makes_no_summit_and_continues_planes():
    rng = np.random.default_rng(1)
    holey = rng.random((20, 30))
    holey[5:12, 8:20] = np.nan
    holey[rng.random(holey.shape) < 0.3] = np.nan
    complete = filled(holey)
    assert np.nanmin(holey) <= complete.min()
    assert complete.max() <= np.nanmax(holey)
    plane = 3.0 * np.arange(20)[:, None] - np.arange(30)
    holed = plane.astype(float)
    holed[5:12, 8:20] = np.nan
    np.testing.assert_allclose(filled(holed), plane, atol=1e-12)


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("map.npz", b"not a zip", "cannot be read"),
        ("map.npy", b"", "cannot be read"),
        ("map.txt", b"1 2 3\n4 5\n", "cannot be read"),
        ("map.txt", b"1 2\nx y\n", "cannot be read"),
        ("map.txt", b"# nothing\n", "holds no numbers"),
        ("map.csv", b"0,5;1,5\n2,5;3,5\n", "only one may separate"),
        ("map.txt", b"\xff\xfe\x00", "cannot be read"),
    ],
)
def test_unreadable_files_are_named(tmp_path, name, content, words):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(rc.InputError, match=words) as caught:
        rc.read_surface(tmp_path / name, size=1.0)
    assert name in str(caught.value)


def test_files_without_heights_or_valid_points_are_named(tmp_path):
    np.savez(tmp_path / "a.npz", z=HEIGHTS)
    with pytest.raises(rc.InputError, match="no array named 'heights'"):
        rc.read_surface(tmp_path / "a.npz", size=1.0)
    np.savez(tmp_path / "b.npz", heights=np.full((3, 3), np.nan), size=1.0)
    with pytest.raises(rc.InputError, match="no valid point"):
        rc.read_surface(tmp_path / "b.npz", missing="fill")
    np.savez(tmp_path / "c.npz", heights=np.array([["a", "b"]]), size=1.0)
    with pytest.raises(rc.InputError, match="real numbers"):
        rc.read_surface(tmp_path / "c.npz")


def test_pickled_objects_are_not_loaded(tmp_path):
    np.save(tmp_path / "evil.npy", np.array([{"a": 1}], dtype=object), allow_pickle=True)
    with pytest.raises(rc.InputError, match="cannot be read"):
        rc.read_surface(tmp_path / "evil.npy", size=1.0)


def test_without_the_package_for_instruments_the_sentence_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "SurfaceTopography", None)
    (tmp_path / "map.sur").write_bytes(b"DIGITAL SURF")
    with pytest.raises(rc.MissingPackage, match="pip install SurfaceTopography"):
        rc.read_surface(tmp_path / "map.sur")


def test_a_reader_of_somebody_else(tmp_path):
    class Bytes(rc.SurfaceReader):
        suffixes = frozenset({".bytes"})

        def read(self, path):
            from roughcontact.files import RawMap

            return RawMap(np.frombuffer(path.read_bytes(), dtype=np.uint8).reshape(2, 2) * 1e-9, (1.0, 1.0))

    rc.readers.register("bytes")(Bytes)
    (tmp_path / "map.bytes").write_bytes(b"\x00\x01\x02\x03")
    np.testing.assert_array_equal(rc.read_surface(tmp_path / "map.bytes").values, np.arange(4).reshape(2, 2) * 1e-9)


def test_a_solution_is_written_whole(tmp_path):
    surface = rc.HeightMap(HEIGHTS, size=1e-3)
    solution = rc.ContactProblem(rc.Body(surface, rc.Elastic(1e9, 0.3))).solve(pressure=1e4)
    solution.save(tmp_path / "solution.npz")
    assert [path.name for path in tmp_path.iterdir()] == ["solution.npz"]
    with np.load(tmp_path / "solution.npz") as data:
        np.testing.assert_array_equal(data["pressure"], solution.pressure)
        np.testing.assert_array_equal(data["gap"], solution.gap)
        assert data["force"] == solution.force
        assert data["status"] == "CONVERGED"
        assert tuple(data["size"]) == (1e-3, 1e-3)


def test_a_failed_write_leaves_the_old_file(tmp_path, monkeypatch):
    surface = rc.HeightMap(HEIGHTS, size=1e-3)
    solution = rc.ContactProblem(rc.Body(surface, rc.Elastic(1e9, 0.3))).solve(pressure=1e4)
    path = tmp_path / "solution.npz"
    path.write_bytes(b"old")

    def full_disk(*args, **kwargs):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(np, "savez_compressed", full_disk)
    with pytest.raises(OSError, match="No space"):
        solution.save(path)
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


def test_an_empty_field_is_a_missing_point(tmp_path):
    (tmp_path / "map.csv").write_text("1e-9,,3e-9\n4e-9,5e-9,7e-9\n2e-9,2e-9,2e-9\n")
    with pytest.raises(rc.InputError, match="misses 1 of 9 points"):
        rc.read_surface(tmp_path / "map.csv", size=1.0)
    assert rc.read_surface(tmp_path / "map.csv", size=1.0, missing="fill").values.shape == (3, 3)


def test_a_given_size_that_agrees_is_accepted(tmp_path):
    np.savez(tmp_path / "map.npz", heights=HEIGHTS, size=(1e-3, 2e-3))
    assert rc.read_surface(tmp_path / "map.npz", size=np.array([1e-3, 2e-3])).size == (1e-3, 2e-3)


def test_results_can_be_read_by_others(tmp_path):
    surface = rc.HeightMap(HEIGHTS, size=1e-3)
    solution = rc.ContactProblem(rc.Body(surface, rc.Elastic(1e9, 0.3))).solve(pressure=1e4)
    solution.save(tmp_path / "solution.npz")
    (tmp_path / "plain").write_text("")
    assert (tmp_path / "solution.npz").stat().st_mode == (tmp_path / "plain").stat().st_mode
    with pytest.raises(rc.InputError, match="There is no folder"):
        solution.save(tmp_path / "nowhere" / "solution.npz")
