from __future__ import annotations

import math
import sys

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

import roughcontact as rc
from roughcontact.typing import read_raw

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


def test_a_size_stated_in_the_file_is_not_overruled(tmp_path):
    np.savez(tmp_path / "map.npz", heights=HEIGHTS, size=(1e-3, 1e-3))
    with pytest.raises(rc.InputError, match="leave size= out"):
        rc.read_surface(tmp_path / "map.npz", size=1.0)


def test_non_measured_points_are_refused_or_filled(tmp_path):
    incomplete = HEIGHTS.copy()
    incomplete[2, 3] = incomplete[0, 0] = np.nan
    np.savez(tmp_path / "map.npz", heights=incomplete, size=(1e-3, 1e-3))
    with pytest.raises(rc.InputError, match="2 of 35 points were not measured"):
        rc.read_surface(tmp_path / "map.npz")
    surface = rc.read_surface(tmp_path / "map.npz", non_measured="fill")
    known = np.isfinite(incomplete)
    np.testing.assert_array_equal(surface.values[known], HEIGHTS[known])
    assert surface.values[2, 3] == pytest.approx(np.mean([HEIGHTS[1, 3], HEIGHTS[3, 3], HEIGHTS[2, 2], HEIGHTS[2, 4]]))
    assert surface.values[0, 0] == pytest.approx(np.mean([HEIGHTS[0, 1], HEIGHTS[1, 0]]))


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("map.npz", b"not a zip", "cannot be read"),
        ("map.npy", b"", "does not begin as .npy files do"),
        ("map.txt", b"1 2 3\n\n4 5\n", "line 3 has 2 numbers, but the lines before it have 3: write nan"),
        ("map.txt", b"1 2\nx y\n", "line 2 holds 'x', which is not a number: .* comments behind #"),
        ("map.csv", b"1,2,\n3,4\n5,6,7\n", "line 2 has 2 numbers, but others have 3"),
        ("map.csv", b"1,2\n3,4\n", "one comma in each line and no points, .*: give decimal=',' or decimal='.'"),
        ("map.csv", b"1,2, 3,4\n5,6, 7,8\n", "commas, some of them beside blanks, and no points, .*: give decimal=','"),
        ("map.csv", b"1.5;2,5\n2.5;3,5\n", "line 1 holds '2,5', which is not a number: .* give decimal=','"),
        ("map.csv", b"1.234,5;2\n", "line 1 holds '1.234,5', which is not a number"),
        ("map.csv", b"z1.5,2,3\n4,5,6\n", "the line 'z1.5,2,3' above its heights .* skip_rows="),
        ("map.txt", b"2 2\n1 2 3\n1 2 3\n", "line 2 has 3 numbers, .*; if those lines are a header, .* skip_rows="),
        ("map.txt", b"1 2 3\nEnd of data\n", "line 2 holds 'End'"),
        ("map.txt", b"10 mm\n1 2\n", "line 1 holds 'mm', .* skipped with skip_rows="),
        ("map.csv", b"x,z\n" + b"1,0.5\n" * 9, "list of points x z of a profile"),
        ("map.txt", b"# Width: 1 m\n# Height: 1 m\n# Value units: V\n1 2\n3 4\n", "states values in 'V', which is not"),
        ("map.txt", b"1 2\n3 1e999\n", "line 2 holds 1e999, which is too large"),
        ("map.txt", b"1 2\n3 -1e999\n", "line 2 holds -1e999, which is too large"),
        ("map.txt", b"1 2\n3 1+2j\n", r"line 2 holds '1.2j', which is not a number"),
        ("map.txt", b"1 2\n3 1_000\n", "line 2 holds '1_000', which is not a number"),
        ("map.txt", b"1 2\n3 0x10\n", "line 2 holds '0x10', which is not a number"),
        ("map.txt", b"1 2\n3 1x-6\n", "line 2 holds '1x-6', which is not a number"),
        ("map.txt", "1 2\n3 \uff14\n".encode(), r"line 2 holds '.uff14', which is not a number"),
        ("map.txt", "1 2\n3 \u20134\n".encode(), r"line 2 holds '.u20134', which is not a number"),
        ("map.txt", b"1 2\n3 \xb5\n", r"line 2 holds '.udcb5', which is not a number"),
        ("map.dat", b"", "it holds no numbers"),
        ("map.dat", b"\x00\x01\x00\x02", "it is not text, although its name ends so"),
        ("map.txt", b"1 2\n3 \x00\n", "it is not text, although its name ends so"),
        ("map.txt", "1 2\n3 4\n".encode("utf-32-le"), "it is not text, although its name ends so"),
        ("map.txt", b"\xff\xfe1\x00 ", "it begins like text in utf-16, but is not"),
        ("map.txt", b"word" * 10**6, "it holds no numbers, and begins with 'wordwordword"),
        ("map.txt", b"# nothing\n", "holds no numbers"),
        ("map.txt", b"\xff\xfe\x00", "begins like text in utf-16, but is not"),
    ],
)
def test_unreadable_files_are_named(tmp_path, name, content, words):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(rc.InputError, match=words) as caught:
        rc.read_surface(tmp_path / name, size=1.0)
    assert name in str(caught.value)
    assert len(str(caught.value)) < 300
    assert str(caught.value).isprintable()


def test_files_without_heights_or_valid_points_are_named(tmp_path):
    np.savez(tmp_path / "a.npz", z=HEIGHTS)
    with pytest.raises(rc.InputError, match="no array named 'heights'"):
        rc.read_surface(tmp_path / "a.npz", size=1.0)
    np.savez(tmp_path / "b.npz", heights=np.full((3, 3), np.nan), size=1.0)
    with pytest.raises(rc.InputError, match="no valid point"):
        rc.read_surface(tmp_path / "b.npz", non_measured="fill")
    for extra, words in (
        ({"size": (1.0, 2.0, 3.0)}, r"'size' must hold one length or two, m, but has float64 of shape .3,."),
        ({"size": "1mm"}, r"'size' must hold one length or two, m, but has <U3"),
        (
            {"size": (1.0, 1.0), "periodic": [True, False]},
            r"'periodic' must be True or False, but has bool of shape .2,.",
        ),
        ({"size": (1.0, 1.0), "periodic": "no"}, "'periodic' must be True or False, but has <U2"),
    ):
        np.savez(tmp_path / "d.npz", heights=HEIGHTS, **extra)
        with pytest.raises(rc.InputError, match=words):
            rc.read_surface(tmp_path / "d.npz")
    np.savez(tmp_path / "c.npz", heights=np.array([["a", "b"]]), size=(1.0, 1.0))
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
            from roughcontact.typing import RawMap

            return RawMap(np.frombuffer(path.read_bytes(), dtype=np.uint8).reshape(2, 2) * 1e-9, (1.0, 1.0))

    rc.readers.register("bytes")(Bytes)
    (tmp_path / "map.bytes").write_bytes(b"\x00\x01\x02\x03")
    np.testing.assert_array_equal(rc.read_surface(tmp_path / "map.bytes").values, np.arange(4).reshape(2, 2) * 1e-9)


def test_a_solution_is_written_whole(tmp_path):
    surface = rc.HeightMap(HEIGHTS, size=(1e-3, 1e-3))
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
    surface = rc.HeightMap(HEIGHTS, size=(1e-3, 1e-3))
    solution = rc.ContactProblem(rc.Body(surface, rc.Elastic(1e9, 0.3))).solve(pressure=1e4)
    path = tmp_path / "solution.npz"
    path.write_bytes(b"old")

    def full_disk(*args, **kwargs):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(np.lib.format, "write_array", full_disk)
    with pytest.raises(OSError, match="No space"):
        solution.save(path)
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


def test_an_empty_field_is_a_non_measured_point(tmp_path):
    (tmp_path / "map.csv").write_text("1e-9,,3e-9\n4e-9,5e-9,7e-9\n2e-9,2e-9,2e-9\n")
    with pytest.raises(rc.InputError, match="1 of 9 points were not measured"):
        rc.read_surface(tmp_path / "map.csv", size=1.0)
    assert rc.read_surface(tmp_path / "map.csv", size=1.0, non_measured="fill").values.shape == (3, 3)


def test_a_given_size_that_agrees_is_accepted(tmp_path):
    np.savez(tmp_path / "map.npz", heights=HEIGHTS, size=(1e-3, 2e-3))
    assert rc.read_surface(tmp_path / "map.npz", size=np.array([1e-3, 2e-3])).size == (1e-3, 2e-3)


def test_results_can_be_read_by_others(tmp_path):
    surface = rc.HeightMap(HEIGHTS, size=(1e-3, 1e-3))
    solution = rc.ContactProblem(rc.Body(surface, rc.Elastic(1e9, 0.3))).solve(pressure=1e4)
    solution.save(tmp_path / "solution.npz")
    (tmp_path / "plain").write_text("")
    assert (tmp_path / "solution.npz").stat().st_mode == (tmp_path / "plain").stat().st_mode
    with pytest.raises(rc.InputError, match="There is no folder"):
        solution.save(tmp_path / "nowhere" / "solution.npz")


@pytest.mark.parametrize(
    ("content", "heights"),
    [
        (b"1,2,\n3,4,\n", [[1, 2], [3, 4]]),
        (b"1;2;\r\n3;4;\r\n", [[1, 2], [3, 4]]),
        (b"1\t2\t\n3\t4\t\n", [[1, 2], [3, 4]]),
        (b"1 2\t\n\t\n3 4\n", [[1, 2], [3, 4]]),
        (b"1, 2\n3, 4\n", [[1, 2], [3, 4]]),
        (b"1,2,\n3,4,5\n", [[1, 2, np.nan], [3, 4, 5]]),
        (b"\t\t\n1\t\t3\n\t\t\n", [[np.nan] * 3, [1, np.nan, 3], [np.nan] * 3]),
        (b"1 nan\n-inf 4", [[1, np.nan], [-np.inf, 4]]),
        (b"# H\xf6he in \xb5m\n1 2 # no\n3 4\n", [[1e-6, 2e-6], [3e-6, 4e-6]]),
        (b"\xef\xbb\xbf1 2\n3 4\n", [[1, 2], [3, 4]]),
        (b"1,2,\n3,4\n", [[1, 2], [3, 4]]),
        (b"1,2,3\n4,5,6,\n", [[1, 2, 3], [4, 5, 6]]),
        (b"0,5;1,5\n2,5;3,5\n", [[0.5, 1.5], [2.5, 3.5]]),
        (b"0,5;1,5;\r\n2,5;3,5;\r\n", [[0.5, 1.5], [2.5, 3.5]]),
        (b"1\t2\n3,4\t5\n", [[1, 2], [3.4, 5]]),
        (b"0,5 1,5\n2,5  -3,5e-6\n", [[0.5, 1.5], [2.5, -3.5e-6]]),
        (b"1 ; 2\n3 ; 4\n", [[1, 2], [3, 4]]),
        (b"1 , 2\n3 , 4\n", [[1, 2], [3, 4]]),
        (b"1.5, 2,3\n4,5, 6\n", [[1.5, 2, 3], [4, 5, 6]]),
        (b'"1.5","2.5"\n"3","4"\n', [[1.5, 2.5], [3, 4]]),
        (b"x [um],y [um]\n1.,2.\n3.,4.\n", [[1, 2], [3, 4]]),
        (b"Instrument: \xb5surf, 20x\nSize X,1360\nDate 2026-11-22\n\n-----\n1,2,3\n4,5,6\n", [[1, 2, 3], [4, 5, 6]]),
        (b"% of a program\n// and another\n\n1 2\n3 4\n", [[1, 2], [3, 4]]),
        (b",,\nNaN,BAD,***\n1,2,--\n", [[np.nan] * 3, [np.nan] * 3, [1, 2, np.nan]]),
        (b"1.#QNAN 2\n3 -1.#IND\n", [[np.nan, 2], [3, np.nan]]),
        (b"N/A;1,5\n2,5;null\n", [[np.nan, 1.5], [2.5, np.nan]]),
        ("1 2\n3 4\n".encode("utf-16"), [[1, 2], [3, 4]]),
        ("\ufeff1 2\n3 4\n".encode("utf-16-be"), [[1, 2], [3, 4]]),
        ("1 2\n3 4\n".encode("utf-32"), [[1, 2], [3, 4]]),
        (b" ".join([b"1.5"] * 10**5) + b"\n" + b" ".join([b"2.5"] * 10**5), [[1.5] * 10**5, [2.5] * 10**5]),
    ],
)
def test_tables_as_instruments_and_spreadsheets_write_them(tmp_path, content, heights):
    (tmp_path / "map.txt").write_bytes(content)
    np.testing.assert_array_equal(read_raw(tmp_path / "map.txt").heights, heights)


@pytest.mark.parametrize(
    ("content", "options", "heights"),
    [
        (b"1,2\n3,4\n", {"decimal": "."}, [[1, 2], [3, 4]]),
        (b"1,2\n3,4\n", {"separator": ","}, [[1, 2], [3, 4]]),
        (b"1,2\n3,4\n", {"decimal": ","}, [[1.2], [3.4]]),
        (b"1,2, 3,4\n5,6, 7,8\n", {"decimal": ","}, [[1.2, 3.4], [5.6, 7.8]]),
        (b"1,2, 3,4\n5,6, 7,8\n", {"decimal": "."}, [[1, 2, 3, 4], [5, 6, 7, 8]]),
        (b"1,2;3\n5,6;7\n", {"separator": ";"}, [[1.2, 3], [5.6, 7]]),
        (b"1,2\t3\n5,6\t7\n", {"separator": "tab", "decimal": ","}, [[1.2, 3], [5.6, 7]]),
        (b"1,2 3\n5,6 7\n", {"separator": "blank"}, [[1.2, 3], [5.6, 7]]),
        (b"2 2\n1 2 3\n1 2 3\n", {"skip_rows": 1}, [[1, 2, 3], [1, 2, 3]]),
        (b"10 mm wide\nx y z\n1 2 3\n", {"skip_rows": 1}, [[1, 2, 3]]),
    ],
)
def test_what_is_ambiguous_in_a_table_is_said_by_options(tmp_path, content, options, heights):
    (tmp_path / "map.csv").write_bytes(content)
    np.testing.assert_array_equal(read_raw(tmp_path / "map.csv", **options).heights, heights)
    reader = rc.readers.create("txt", **options)
    np.testing.assert_array_equal(read_raw(tmp_path / "map.csv", reader).heights, heights)


@given(
    heights=arrays.arrays(
        np.float64,
        st.tuples(st.integers(2, 8), st.integers(4, 9)),
        elements=st.one_of(st.floats(-1e9, 1e9), st.just(math.nan)),
    ),
    separator=st.sampled_from([",", ";", "\t", " ", ", ", " ; ", "  "]),
    decimal=st.sampled_from([".", ","]),
    missing=st.sampled_from(["nan", "***", "BAD", "--", ""]),
    end=st.sampled_from(["\n", "\r\n"]),
    header=st.sampled_from(["", "# Höhe: 3 µm\n", "Map 7 of 9\nWidth,10\n\n", "z [um];z [um]\n----------\n"]),
    encoding=st.sampled_from(["utf-8", "utf-8-sig", "utf-16", "latin-1"]),
    trailing=st.booleans(),
)
@settings(deadline=None, max_examples=60)
def test_what_is_written_in_any_layout_is_read_back(
    tmp_path_factory, heights, separator, decimal, missing, end, header, encoding, trailing
):
    blank = not separator.strip(" ")
    assume(not (blank and missing == "") and np.isfinite(heights).any())
    # A comma for both cannot be told apart; blanks with it can, if decimals are asked for.
    assume(decimal == "." or separator != ",")
    # Heights that look like marks of lost points would be asked about.
    options = {"no_data": "none"} | ({"decimal": decimal} if separator.strip() == "," else {})
    words = [[missing if math.isnan(z) else repr(z).replace(".", decimal) for z in row] for row in heights.tolist()]
    # A last column of empty fields alone is taken for separators at the ends of rows.
    assume(missing or trailing or np.isfinite(heights[:, -1]).any())
    # With decimals in commas an empty field between commas and blanks would be none.
    assume(not (decimal == "," and separator == ", "))
    last = separator.strip(" ") if trailing else ""
    path = tmp_path_factory.getbasetemp() / "layout.csv"
    path.write_bytes(
        (header.replace("\n", end) + "".join(separator.join(row) + last + end for row in words)).encode(encoding)
    )
    found = read_raw(path, **options).heights
    np.testing.assert_array_equal(found, heights)


def test_options_of_readers_are_checked(tmp_path):
    np.savez(tmp_path / "map.npz", heights=HEIGHTS, size=(1e-3, 1e-3))
    np.savetxt(tmp_path / "map.csv", HEIGHTS, delimiter=";")
    with pytest.raises(rc.InputError, match=r"no option of the reader 'npz', which reads map\.npz, named 'decimal'"):
        rc.read_surface(tmp_path / "map.npz", decimal=",")
    with pytest.raises(rc.InputError, match=r"named 'separators'\. Did you mean 'separator'"):
        rc.read_surface(tmp_path / "map.csv", size=1e-3, separators=";")
    with pytest.raises(rc.InputError, match="Give decimal to the reader itself"):
        rc.read_surface(tmp_path / "map.csv", size=1e-3, reader=rc.readers.create("txt"), decimal=".")
    for options, words in (
        ({"separator": "|"}, "The separator .* must be one of"),
        ({"decimal": ":"}, "The decimal mark .* must be one of"),
        ({"skip_rows": -1}, "The number of lines to skip .* must be"),
        ({"separator": ",", "decimal": ","}, "cannot both separate the numbers and be their decimal mark"),
    ):
        with pytest.raises(rc.InputError, match=words):
            rc.read_surface(tmp_path / "map.csv", size=1e-3, **options)


def test_points_x_y_z_on_a_regular_grid_are_a_map(tmp_path):
    rng = np.random.default_rng(3)
    nx, ny = 12, 9
    i, j = (axis.ravel() for axis in np.meshgrid(np.arange(nx), np.arange(ny), indexing="ij"))
    # Places rounded to three digits, as they are printed, in any order.
    lines = [f"{0.333 * a - 2:.3f} {1.5 * b:.3f} {1e6 * h}" for a, b, h in zip(i, j, rng.random(nx * ny), strict=True)]
    heights = np.array([float(line.split()[2]) for line in lines]).reshape(nx, ny)
    order = rng.permutation(nx * ny)
    path = tmp_path / "points.xyz"
    path.write_text("X Y Z\n" + "\n".join(lines[k] for k in order))
    with pytest.raises(rc.InputError, match=r"its 12 x 9 points are 0.333 x 1.5 apart .*size=.3.996e-06, 1.35e-05."):
        rc.read_surface(path)
    surface = rc.read_surface(path, size=(4e-6, 13.5e-6), unit=1e-6)
    np.testing.assert_array_equal(surface.values, 1e-6 * heights)
    for text in ("um", "1um", "0.001 mm"):
        read = rc.read_surface(path, size=(4e-6, 13.5e-6), unit=text)
        np.testing.assert_array_equal(read.values, surface.values)
    for wrong in ("Pa", "umm", "", "-1um"):
        with pytest.raises(rc.InputError, match="The unit of the heights"):
            rc.read_surface(path, size=(4e-6, 13.5e-6), unit=wrong)
    # Points that are not listed, or have no height, were not measured.
    lines[order[0]] = lines[order[0]].rsplit(" ", 1)[0] + " BAD"
    path.write_text("\n".join(lines[k] for k in order[:-4]))
    kept = rc.read_surface(path, size=(4e-6, 13.5e-6), non_measured="keep")
    assert np.flatnonzero(kept.non_measured.ravel()).tolist() == sorted([*order[-4:], order[0]])


@pytest.mark.parametrize(
    "points",
    [
        np.random.default_rng(4).random((50, 3)),
        np.array([[i, i, 0.0] for i in range(20)]),
        np.array([[i % 5, np.exp(i // 5), 0.0] for i in range(25)]),
        np.ones((10, 3)),
        np.full((10, 3), 1e308) * np.array([1, 1, 0]) * (-1.0) ** np.arange(10)[:, None],
        np.array([[np.nan, 1.0, 2.0]] * 9),
    ],
)
def test_points_on_no_regular_grid_are_refused(tmp_path, points):
    np.savetxt(tmp_path / "points.txt", points)
    with pytest.raises(rc.InputError, match="do not lie on a regular grid: interpolate them"):
        rc.read_surface(tmp_path / "points.txt", size=1e-3)


def test_two_points_at_one_place_are_named(tmp_path):
    points = np.array([[i % 5, 3.0 * (i // 5 % 7), 0.1 * i] for i in range(36)])
    np.savetxt(tmp_path / "points.txt", points)
    with pytest.raises(rc.InputError, match="at one place of a regular grid, as at x = 0, y = 0: keep one"):
        rc.read_surface(tmp_path / "points.txt", size=1e-3)


def test_an_image_of_gwyddion_has_its_size_its_unit_and_x_first(tmp_path):
    # The highest point of the image is at the top on the right: at large x and large y.
    text = "# Channel: Z\n# Width: 30,0 \u00b5m\n# Height: 20.0 \u00b5m\n# Value units: nm\n0\t1\t9\n2\t3\t4\n"
    for encoding in ("utf-8", "latin-1", "utf-16"):
        (tmp_path / "image.txt").write_bytes(text.encode(encoding))
        surface = rc.read_surface(tmp_path / "image.txt")
        assert surface.size == pytest.approx((30e-6, 20e-6))
        np.testing.assert_allclose(surface.values, 1e-9 * np.array([[2, 0], [3, 1], [4, 9]]))
        x, y = surface.grid.x[:, 0], surface.grid.y[0]
        place = np.unravel_index(surface.values.argmax(), surface.values.shape)
        assert x[place[0]] == x.max()
        assert y[place[1]] == y.max()
    np.testing.assert_array_equal(rc.read_surface(tmp_path / "image.txt", unit="nm").values, surface.values)
    with pytest.raises(rc.InputError, match="states its own unit of height"):
        rc.read_surface(tmp_path / "image.txt", unit=1e-6)


def test_points_that_take_more_memory_than_there_is_are_not_filled(tmp_path, leave_memory):
    heights = np.full((300, 300), np.nan)
    heights[0] = 0.0
    np.savez(tmp_path / "map.npz", heights=heights, size=1e-3)
    leave_memory(2**24)
    with pytest.raises(rc.InputError, match=r"Filling 89700 non-measured points needs 42\.77 MiB of memory"):
        rc.read_surface(tmp_path / "map.npz", non_measured="fill")


class TestWhatIsNotHeightsInATable:
    ROUGH = np.random.default_rng(2).normal(size=(12, 10))

    def refusal(self, tmp_path, table, text="nan"):
        path = tmp_path / "map.csv"
        path.write_text("\n".join(",".join(map(str, row)) for row in table).replace("nan", text) + "\n")
        with pytest.raises(rc.InputError) as caught:
            rc.read_surface(path, size=1e-3)
        return str(caught.value)

    def test_what_pandas_writes_beside_the_heights_is_refused(self, tmp_path):
        table = np.pad(self.ROUGH, ((1, 0), (1, 0)))
        table[0, 1:], table[1:, 0], table[0, 0] = np.arange(10), np.arange(12), np.nan
        both, index = self.refusal(tmp_path, table, text=""), self.refusal(tmp_path, table[1:])
        assert "the numbers of its first row and its first column count, as header and index of pandas do" in both
        assert "the numbers of its first row count, as" in (header := self.refusal(tmp_path, table[:, 1:]))
        assert "the numbers of its first column count, as" in index
        assert "skip_rows=" in header
        assert all("to_csv(path, header=False, index=False)" in words for words in (both, header, index))
        path = tmp_path / "map.csv"
        np.savetxt(path, table[:, 1:], delimiter=",")
        surface = rc.read_surface(path, size=(1.0, 1.0), skip_rows=1)
        np.testing.assert_array_equal(surface.values, self.ROUGH)

    def test_rows_and_columns_of_places_are_refused(self, tmp_path):
        table = np.pad(self.ROUGH, ((1, 0), (1, 0)))
        table[0, 1:], table[1:, 0] = np.round(np.arange(10) / 3, 4), -2.5 * np.arange(12)
        for part, what in ((table, "row and its first column"), (table[:, 1:], "row"), (table[1:], "column")):
            words = self.refusal(tmp_path, part)
            assert f"its first {what} rise in equal steps, as places x and y do" in words
            assert "give size=" in words

    @pytest.mark.parametrize("turn", [np.asarray, np.transpose])
    def test_many_numbers_in_one_line_are_refused(self, tmp_path, turn):
        words = self.refusal(tmp_path, turn(self.ROUGH.reshape(-1, 1)))
        assert "its 120 numbers stand in one" in words
        assert "reshape(nx, ny)" in words

    @pytest.mark.parametrize(
        "heights",
        [
            np.arange(12.0)[:, None] + np.arange(10.0),
            np.arange(120.0).reshape(12, 10),
            np.outer(np.arange(12.0), np.arange(1.0, 11.0)),
            np.abs(np.arange(12.0)[:, None] - 5.0) + 0.0 * np.arange(10.0),
            np.full((12, 10), 3.0),
        ],
    )
    def test_planes_and_wedges_are_heights(self, tmp_path, heights):
        np.savetxt(tmp_path / "map.csv", heights, delimiter=",")
        np.testing.assert_array_equal(rc.read_surface(tmp_path / "map.csv", size=(1.0, 1.0)).values, heights)


class TestFilesThatHoldNoHeights:
    @pytest.mark.parametrize(
        ("name", "content", "words"),
        [
            ("a.png", b"\x89PNG\r\n\x1a\n", "a PNG picture"),
            ("a.csv", b"\x89PNG\r\n\x1a\n", "a PNG picture"),
            ("a.jpg", b"\xff\xd8\xff\xe0", "a JPEG picture"),
            ("a.gif", b"GIF89a", "a GIF picture"),
            ("a.pdf", b"%PDF-1.7", "a PDF document"),
            ("a.htm", b"\n<!DOCTYPE html>\n<html>", "a page of HTML"),
            ("a.xml", b"<?xml version='1.0'?>\n<a/>", "an XML document"),
            ("a.vti", b'<?xml version="1.0"?>\n<VTKFile type="ImageData">', "image data of VTK"),
            ("a.zip", b"PK\x03\x04", "a ZIP archive"),
        ],
    )
    def test_are_named_with_and_without_further_packages(self, tmp_path, monkeypatch, name, content, words):
        (tmp_path / name).write_bytes(content)
        for hidden in (False, True):
            if hidden:
                monkeypatch.setitem(sys.modules, "SurfaceTopography", None)
            with pytest.raises(rc.InputError, match=f"The file {name} cannot be used: it is {words}"):
                rc.read_surface(tmp_path / name)

    @pytest.mark.parametrize("ending", ["npz", "nc"])
    def test_a_saved_solution_says_how_to_continue(self, tmp_path, ending):
        if ending == "nc":
            pytest.importorskip("xarray")
        problem = rc.ContactProblem(rc.Body(rc.HeightMap(HEIGHTS, size=(1e-3, 1e-3)), rc.Elastic(1e9, 0.3)))
        problem.solve(pressure=1e4).save(tmp_path / f"contact.{ending}")
        with pytest.raises(rc.InputError, match=r"it is a saved solution, .*ContactSolution.load.*roughcontact plot"):
            rc.read_surface(tmp_path / f"contact.{ending}")

    def test_of_no_known_format_name_those_that_are_read(self, tmp_path):
        pytest.importorskip("SurfaceTopography", exc_type=ImportError)
        (tmp_path / "a.bin").write_bytes(bytes(range(256)))
        with pytest.raises(rc.InputError, match=r"none of the formats that are read, .* \.npz, .*\.x3p.*\.tif"):
            rc.read_surface(tmp_path / "a.bin")


def test_the_package_of_each_ending_is_named(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "SurfaceTopography", None)
    (tmp_path / "a.plux").write_bytes(b"PK\x03\x04")
    with pytest.raises(rc.MissingPackage, match=r"\.mat are read without it, \.tif by .*roughcontact\[files\]"):
        rc.read_surface(tmp_path / "a.plux")
