"""What a file states is used or refused, never skipped: unit, scale, non-measured value, axes, channels."""

import contextlib
import hashlib
import struct
import zipfile

import numpy as np
import pytest

import roughcontact as rc

SIZE = (48e-6, 74e-6)
# 24 x 37 points, heights in µm, first index x.
X, Y = np.meshgrid(np.arange(24) * 2.0, np.arange(37) * 2.0, indexing="ij")
MICROMETRES = (0.8 * np.sin(0.15 * X) * np.cos(0.09 * Y)).round(4)
HEIGHTS = 1e-6 * MICROMETRES


def table(values, separator="\t", write=str):
    return "\n".join(separator.join(map(write, row)) for row in values.tolist()) + "\n"


def write(folder, name, text):
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


# Lines for each y, downwards, as images have them.
IMAGE = table(MICROMETRES.T[::-1])
GWYDDION = "# Channel: Height\n# Width: 48.0 µm\n# Height: 74.0 µm\n# Value units: µm\n"
ESRI = "ncols 24\nnrows 37\nxllcorner 0\nyllcorner 0\ncellsize 2\nNODATA_value -9999\n"
SPIP = (
    "# File Format = ASCII\n# x-pixels = 24\n# y-pixels = 37\n# x-length = 48000\n# y-length = 74000\n# Bit2nm = 500\n"
)
QUOTED = table(MICROMETRES, ",", lambda v: f'"{v:.4f}"'.replace(".", ","))
POINTS = "\n".join(f"{x:g},{y:g},{z:g}" for x, y, z in zip(X.flat, Y.flat, MICROMETRES.flat, strict=True))
TURNED = "\n".join(f"{y:g},{x:g},{z:g}" for x, y, z in zip(X.flat, Y.flat, MICROMETRES.flat, strict=True))

READ = {
    "Gwyddion": ("a.txt", GWYDDION + IMAGE, {}),
    "NanoScope": ("a.txt", "\\Exported image units: µm\n" + table(MICROMETRES.T), {"size": SIZE, "rows": "y"}),
    "SPIP": ("a.asc", SPIP + "# Start of Data:\n" + table((2.0 * MICROMETRES).T[::-1]), {}),
    "ESRI": ("a.asc", ESRI + IMAGE, {"size": SIZE, "unit": "um"}),
    "pandas with decimal commas": ("a.csv", QUOTED, {"size": SIZE, "unit": "um"}),
    "points x y z": ("a.csv", "x,y,z\n" + POINTS, {"size": SIZE, "unit": "um"}),
    "points y x z": ("a.csv", "y,x,z\n" + TURNED, {"size": SIZE, "unit": "um"}),
    "fixed width": ("a.prn", table(MICROMETRES, "  ", lambda v: f"{v:9.4f}"), {"size": SIZE, "unit": "um"}),
}


@pytest.mark.parametrize("name", READ)
def test_what_is_stated_is_used(tmp_path, name):
    file, text, options = READ[name]
    found = rc.read_surface(write(tmp_path, file, text), **options)
    assert found.grid.shape == (24, 37)
    assert found.grid.size == pytest.approx(SIZE)
    np.testing.assert_allclose(found.values, HEIGHTS, atol=1e-16)


FOURTH = "\n".join(f"{line},{k % 7}" for k, line in enumerate(POINTS.split("\n")))
THOUSANDS = table(1000 + 400 * np.sin(X), "\t", lambda v: f"{v:,.0f}")
ROUNDED = "\t".join(f"{0.137 * k:.2f}" for k in range(24)) + "\n" + table(MICROMETRES.T)
REFUSED = {
    "a unit of angles": (
        "a.txt",
        GWYDDION.replace("units: µm", "units: deg") + IMAGE,
        {},
        "'deg', which is not",
    ),
    "a scale": ("a.txt", "# z-scale: 0.5\n" + IMAGE, {"size": SIZE}, "states '# z-scale: 0.5', which changes"),
    "another number of rows": (
        "a.asc",
        ESRI.replace("37", "36") + IMAGE,
        {"size": SIZE},
        "states 36 x 24 lines and numbers in a line, but holds 37 x 24",
    ),
    "thousands": ("a.txt", THOUSANDS, {"size": SIZE, "unit": "nm"}, "commas may separate thousands"),
    "a fourth column": ("a.csv", FOURTH, {"size": SIZE}, "with further columns"),
    "points and sides exchanged": ("a.csv", POINTS, {"size": SIZE[::-1]}, "2 and 2 apart along x and y, but on"),
    "rounded positions": ("a.txt", ROUNDED, {"size": SIZE, "rows": "y"}, "its first row rise in equal steps"),
    "two channels": (
        "a.txt",
        "# Height\n" + IMAGE + "# Phase\n" + IMAGE,
        {"size": SIZE},
        "'# Phase' stands between its",
    ),
    "two images": ("a.txt", GWYDDION + IMAGE + "\n" + GWYDDION + IMAGE, {}, "stands between its numbers"),
    "a title below counts": ("a.txt", "24\t37\t2\nHeights\n" + IMAGE, {"size": SIZE}, "skipped with skip_rows=2"),
    "a point cloud": ("a.ply", "ply\nformat ascii 1.0\nend_header\n0 0 0\n", {}, "a cloud of points in PLY"),
    "a size and its cells": ("a.txt", GWYDDION + IMAGE, {"size": SIZE[::-1]}, "states its own size"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_stated_and_not_understood_is_refused(tmp_path, name):
    file, text, options, words = REFUSED[name]
    with pytest.raises(rc.InputError) as caught:
        rc.read_surface(write(tmp_path, file, text), **options)
    assert words in str(caught.value)


def test_a_stated_value_of_non_measured_points_is_none_of_the_heights(tmp_path):
    values = MICROMETRES.T[::-1].copy()
    values[:5, :7] = -9999
    path = write(tmp_path, "a.asc", ESRI + table(values))
    found = rc.read_surface(path, size=SIZE, unit="um", non_measured="keep")
    assert np.count_nonzero(found.non_measured) == 35
    assert found.non_measured[:7, -5:].all()
    assert np.ptp(found.values[~found.non_measured]) < 2e-6


def test_the_words_no_data_are_a_non_measured_point(tmp_path):
    lines = [f"{i} {j} {'No Data' if i == j == 3 else MICROMETRES[i, j]}" for i in range(24) for j in range(37)]
    path = write(tmp_path, "a.xyz", "\n".join(lines))
    found = rc.read_surface(path, size=(24e-6, 37e-6), unit="um", non_measured="keep")
    assert np.argwhere(found.non_measured).tolist() == [[3, 3]]


def test_the_history_says_what_a_line_is(tmp_path):
    plain = write(tmp_path, "a.txt", table(MICROMETRES))
    assumed = rc.read_surface(plain, size=SIZE, unit="um")
    assert "a line of the file is one x (assumed: rows= says it)" in assumed.history[0]
    assert "a line of the file is one x" in rc.ContactProblem(rc.Body(assumed, rc.Elastic(1e9, 0.3))).explain()
    given = rc.read_surface(write(tmp_path, "b.txt", table(MICROMETRES.T)), size=SIZE, unit="um", rows="y")
    assert "a line of the file is one y" in given.history[0]
    image = rc.read_surface(write(tmp_path, "c.txt", GWYDDION + IMAGE))
    assert "a line of the file is one y, downwards" in image.history[0]
    counted = rc.read_surface(write(tmp_path, "d.txt", "# nx = 24\n# ny = 37\n" + table(MICROMETRES.T)), size=SIZE)
    assert "heights in m (assumed: unit= says it), a line of the file is one y, upwards (assumed)" in counted.history[0]


class TestHdf5:
    """Attributes of an array: unit, packing, value of non-measured points."""

    @pytest.mark.parametrize(
        ("values", "attributes"),
        [
            (MICROMETRES, {"units": "um"}),
            (np.round(MICROMETRES * 1e4).astype("i2"), {"units": "m", "scale_factor": 1e-10}),
            (np.round(MICROMETRES * 1e4 + 9).astype("i4"), {"units": "nm", "scale_factor": 0.1, "add_offset": -0.9}),
        ],
    )
    def test_are_used(self, tmp_path, values, attributes):
        h5py = pytest.importorskip("h5py")
        with h5py.File(tmp_path / "a.h5", "w") as file:
            file.create_dataset("heights", data=values).attrs.update(attributes)
        np.testing.assert_allclose(rc.read_surface(tmp_path / "a.h5", size=SIZE).values, HEIGHTS, atol=1e-15)
        with pytest.raises(rc.InputError, match="states its own unit"):
            rc.read_surface(tmp_path / "a.h5", size=SIZE, unit="mm")

    def test_mark_non_measured_points(self, tmp_path):
        h5py = pytest.importorskip("h5py")
        with h5py.File(tmp_path / "a.h5", "w") as file:
            data = np.where(MICROMETRES > 0.79, -9999.0, HEIGHTS)
            file.create_dataset("heights", data=data).attrs.update({"units": "m", "_FillValue": -9999.0})
        found = rc.read_surface(tmp_path / "a.h5", size=SIZE, non_measured="keep")
        np.testing.assert_array_equal(found.non_measured, MICROMETRES > 0.79)

    def test_a_unit_of_volts_is_refused(self, tmp_path):
        h5py = pytest.importorskip("h5py")
        with h5py.File(tmp_path / "a.h5", "w") as file:
            file.create_dataset("heights", data=HEIGHTS).attrs["units"] = "V"
        with pytest.raises(rc.InputError, match="values in 'V'"):
            rc.read_surface(tmp_path / "a.h5", size=SIZE)

    @pytest.mark.parametrize("ending", ["datx", "h5", "nid"])
    def test_a_small_file_cannot_declare_gigabytes(self, tmp_path, ending):
        h5py = pytest.importorskip("h5py")
        with h5py.File(tmp_path / f"bomb.{ending}", "w") as file:
            file.create_dataset(
                "Data/Surface", shape=(20000, 20000, 1)[: 2 + (ending == "nid")], dtype="f8", chunks=True
            )
        with pytest.raises(rc.InputError, match=r"larger than a file of \d+ bytes can hold"):
            rc.read_surface(tmp_path / f"bomb.{ending}", size=SIZE)


class TestTiff:
    @pytest.mark.parametrize("stated", ["-9999", "-3.4028235e+38", "-3.40282346638529e+38", "nan"])
    def test_points_without_data_are_compared_with_the_digits_of_the_pixels(self, tmp_path, stated):
        tifffile = pytest.importorskip("tifffile")
        pixels = MICROMETRES.T.astype("f4")
        pixels[4, 5] = np.float32(stated)
        tifffile.imwrite(tmp_path / "a.tif", pixels, extratags=[(42113, "s", 0, stated, True)])
        found = rc.read_surface(tmp_path / "a.tif", size=SIZE, unit="um", non_measured="keep")
        assert np.count_nonzero(found.non_measured) == 1
        assert np.ptp(found.values[~found.non_measured]) < 2e-6

    def test_a_straight_calibration_of_imagej_is_used(self, tmp_path):
        tifffile = pytest.importorskip("tifffile")
        counts = np.round(3e4 + 2e4 * MICROMETRES.T).astype("u2")
        metadata = {"unit": "um", "cf": 0, "c0": -1.5, "c1": 5e-5, "vunit": "um"}
        tifffile.imwrite(tmp_path / "a.tif", counts, imagej=True, resolution=(0.5, 0.5), metadata=metadata)
        found = rc.read_surface(tmp_path / "a.tif")
        np.testing.assert_allclose(found.values, HEIGHTS[:, ::-1], atol=5e-11)

    def test_another_unit_along_y_is_used(self, tmp_path):
        tifffile = pytest.importorskip("tifffile")
        metadata = {"unit": "um", "yunit": "nm"}
        pixels = MICROMETRES.T.astype("f4")
        tifffile.imwrite(tmp_path / "a.tif", pixels, imagej=True, resolution=(0.5, 0.0005), metadata=metadata)
        assert rc.read_surface(tmp_path / "a.tif", unit="um").size == pytest.approx(SIZE)


AXIS = "<C{0}><AxisType>{1}</AxisType><DataType>{2}</DataType>{3}<Offset>0</Offset></C{0}>"
TYPES = {"I": ("<h", 1e-10), "L": ("<i", 1e-12), "F": ("<f", 1.0), "D": ("<d", 1.0)}


def write_x3p(path, folder="", revision="ISO5436 - 2000", kind="D", inline=False, step="2e-6", entity=""):
    form, scale = TYPES[kind]
    numbers = (HEIGHTS / scale).T.ravel()
    numbers = np.round(numbers).astype(int).tolist() if kind in "IL" else numbers.tolist()
    axes = AXIS.format("X", "I", "D", f"<Increment>{step}</Increment>")
    axes += AXIS.format("Y", "I", "D", "<Increment>2e-6</Increment>")
    axes += AXIS.format("Z", "A", kind, f"<Increment>{scale}</Increment>")
    data = b"".join(struct.pack(form, number) for number in numbers)
    digest = hashlib.md5(data).hexdigest()
    link = f"<DataLink><PointDataLink>bindata/data.bin</PointDataLink><MD5>{digest}</MD5></DataLink>"
    listed = "<DataList>" + "".join(f"<Datum>{number}</Datum>" for number in numbers) + "</DataList>"
    xml = (
        f'<?xml version="1.0" encoding="UTF-8"?>{entity}<p:ISO5436_2 xmlns:p="http://www.opengps.eu/2008/ISO5436_2">'
        f"<Record1><Revision>{revision}</Revision><FeatureType>SUR</FeatureType><Axes>{axes}</Axes></Record1>"
        "<Record3><MatrixDimension><SizeX>24</SizeX><SizeY>37</SizeY><SizeZ>1</SizeZ></MatrixDimension>"
        f"{listed if inline else link}</Record3></p:ISO5436_2>"
    )
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr(f"{folder}main.xml", xml)
        if not inline:
            archive.writestr(f"{folder}bindata/data.bin", data)


class TestX3p:
    @pytest.mark.parametrize(
        "how",
        [{"folder": "map/"}, {"revision": "GK"}, {"inline": True}, {"kind": "I"}, {"kind": "L"}, {"kind": "F"}, {}],
        ids=str,
    )
    def test_is_read_as_others_write_it(self, tmp_path, how):
        write_x3p(tmp_path / "a.x3p", **how)
        found = rc.read_surface(tmp_path / "a.x3p")
        assert found.grid.size == pytest.approx(SIZE)
        np.testing.assert_allclose(found.values, HEIGHTS, atol=1e-10 if how.get("kind") == "I" else 1e-12)

    @pytest.mark.parametrize(
        ("how", "words"),
        [
            ({"step": "0"}, "distance of its points along x"),
            ({"step": "wide"}, "'wide', which is not a number"),
            ({"entity": '<!DOCTYPE a [<!ENTITY b "c">]>'}, "defines entities"),
        ],
    )
    def test_says_why_it_is_refused(self, tmp_path, how, words):
        write_x3p(tmp_path / "a.x3p", **how)
        with pytest.raises(rc.InputError) as caught:
            rc.read_surface(tmp_path / "a.x3p")
        assert words in str(caught.value)

    def test_damage_is_a_sentence(self, tmp_path):
        write_x3p(tmp_path / "a.x3p")
        whole = (tmp_path / "a.x3p").read_bytes()
        draws = np.random.default_rng(0)
        for _ in range(200):
            broken = bytearray(whole)
            for place in draws.integers(0, len(whole), 3):
                broken[place] = draws.integers(0, 256)
            (tmp_path / "b.x3p").write_bytes(bytes(broken[: draws.integers(len(whole) // 2, len(whole) + 1)]))
            with contextlib.suppress(rc.InputError):
                assert rc.read_surface(tmp_path / "b.x3p", non_measured="keep").grid.cells == HEIGHTS.size


class TestCell:
    """The distance of the points, in place of the size."""

    def test_gives_the_size(self, tmp_path):
        path = write(tmp_path, "a.txt", table(MICROMETRES))
        assert rc.read_surface(path, cell=("2um", 2e-6), unit="um").grid.size == pytest.approx(SIZE)
        assert rc.read_surface(path, cell="2um", unit="um").grid.size == pytest.approx(SIZE)

    def test_agrees_with_a_size_and_with_the_file(self, tmp_path):
        path = write(tmp_path, "a.txt", table(MICROMETRES))
        assert rc.read_surface(path, cell=2e-6, size=SIZE).size == pytest.approx(SIZE)
        with pytest.raises(rc.InputError, match="give size= or cell= alone"):
            rc.read_surface(path, cell=3e-6, size=SIZE)
        stated = write(tmp_path, "b.txt", GWYDDION + IMAGE)
        assert rc.read_surface(stated, cell=2e-6).grid.size == pytest.approx(SIZE)
        with pytest.raises(rc.InputError, match="states its own size"):
            rc.read_surface(stated, cell=1e-6)

    def test_is_an_option_and_an_entry_of_study_files(self, tmp_path, run):
        path = write(tmp_path, "a.txt", table(MICROMETRES))
        status, out, _ = run("info", path, "--cell", "2um", "--unit", "um")
        assert status == 0
        assert "48 µm x 74 µm" in out
        study = write(
            tmp_path,
            "study.toml",
            '[problems.a.body]\nsurface = {type = "file", path = "a.txt", cell = "2um", unit = "1um"}\n'
            'material = {young = "1GPa", poisson = 0.3}\n[study]\nforce = ["1mN"]\n',
        )
        status, out, err = run("run", study, "--dry-run")
        assert status == 0, err
        assert "24 x 37 cells on 48 µm x 74 µm" in out


class TestArrays:
    """A map is an array of its heights for numpy."""

    def test_of_numpy_have_nan_where_nothing_was_measured(self):
        heights = HEIGHTS.copy()
        heights[3, 4] = np.nan
        kept = rc.HeightMap(heights, SIZE, non_measured="keep")
        assert kept.non_measured.sum() == 1
        np.testing.assert_array_equal(np.asarray(kept), heights)
        whole = rc.HeightMap(HEIGHTS, SIZE)
        assert np.asarray(whole, dtype=np.float32).shape == (24, 37)
        assert np.ptp(whole) == pytest.approx(np.ptp(HEIGHTS))
        changed = np.array(whole)
        changed[0, 0] = 1.0
        assert whole.values[0, 0] == HEIGHTS[0, 0]
