"""Binary kinds of files as public programs write them: each is read right, or refused with a sentence that helps.

Each file is written here as its program writes it, after the description of its format. The map is oblong, on cells of
2 x 3 µm, and no symmetry maps it onto itself.
"""

import contextlib
import gzip
import hashlib
import io
import struct
import tracemalloc
import warnings
import zipfile
import zlib

import numpy as np
import pytest
import scipy.io

import roughcontact as rc
from damage import damage_bytes

# 24 x 37 points, first index x.
SHAPE = (24, 37)
X, Y = 2.0 * np.arange(24), 3.0 * np.arange(37)
SIZE = (48e-6, 111e-6)
MICROMETRES = (0.8 * np.sin(0.15 * X)[:, None] * np.cos(0.09 * Y) + 0.01 * Y).astype("f4").astype("f8")
HEIGHTS = 1e-6 * MICROMETRES
GRID = np.meshgrid(X, Y, indexing="ij")
IMAGE = MICROMETRES.T[::-1]
PIXELS = IMAGE.astype("f4")
# Bytes that reading or refusing such a file may take.
MEMORY = 2**23


def h5(attributes=None, values=MICROMETRES, axes=(), of_file=None, **others):
    h5py = pytest.importorskip("h5py")
    stream = io.BytesIO()
    with h5py.File(stream, "w") as file:
        data = file.create_dataset("heights", data=values)
        data.attrs.update(attributes or {})
        for axis, name in enumerate(axes):
            data.dims[axis].label = name
        for name, one in others.items():
            file[name] = one
        file.attrs.update(of_file or {})
    return stream.getvalue()


def named_h5(name):
    h5py = pytest.importorskip("h5py")
    stream = io.BytesIO()
    with h5py.File(stream, "w") as file:
        file[name] = MICROMETRES
    return stream.getvalue()


def rows_and_columns():
    h5netcdf = pytest.importorskip("h5netcdf")
    stream = io.BytesIO()
    with h5netcdf.File(stream, "w") as file:
        file.dimensions = {"row": 37, "column": 24}
        file.create_variable("z", ("row", "column"), data=MICROMETRES.T).attrs["units"] = "um"
    return stream.getvalue()


def netcdf4(values=MICROMETRES.T, dims=("y", "x"), units="um", places=(Y, X), **attributes):
    h5netcdf = pytest.importorskip("h5netcdf")
    stream = io.BytesIO()
    with h5netcdf.File(stream, "w") as file:
        file.dimensions = dict(zip(dims, values.shape, strict=True))
        for name, place in zip(dims, places, strict=True):
            file.create_variable(name, (name,), data=place).attrs["units"] = units
        file.create_variable("z", dims, data=values).attrs.update(attributes)
    return stream.getvalue()


def netcdf3(name="z", values=MICROMETRES.T, dims=("y", "x"), units="um", **attributes):
    stream = io.BytesIO()
    with scipy.io.netcdf_file(stream, "w") as file:
        for axis in dims[:-2]:
            file.createDimension(axis, 1)
        for axis, places in zip(dims[-2:], (Y, X), strict=True):
            file.createDimension(axis, len(places))
            one = file.createVariable(axis, "d", (axis,))
            one[:] = places
            one.units = units
        data = file.createVariable(name, values.dtype, dims)
        data[:] = values
        for key, value in attributes.items():
            setattr(data, key, value)
        file.flush()
        return stream.getvalue()


def mat(**contents):
    stream = io.BytesIO()
    scipy.io.savemat(stream, contents)
    return stream.getvalue()


def npz(**contents):
    stream = io.BytesIO()
    np.savez(stream, **contents)
    return stream.getvalue()


def npy(values):
    stream = io.BytesIO()
    np.save(stream, values)
    return stream.getvalue()


def tiff(values=PIXELS, **options):
    tifffile = pytest.importorskip("tifffile")
    stream = io.BytesIO()
    tifffile.imwrite(stream, values, **options)
    return stream.getvalue()


def gdal(*items):
    text = "".join(f'<Item name="a" sample="0" role="{role}">{value}</Item>' for role, value in items)
    return {"extratags": [(42112, "s", 0, f"<GDALMetadata>{text}</GDALMetadata>", True)]}


def surfer6(columns=24, values=MICROMETRES.T):
    return b"DSBB" + struct.pack("<hh6d", columns, 37, 0, 46, 0, 108, -1, 1) + values.astype("<f4").tobytes()


def surfer7(rows=37, rotation=0.0, values=MICROMETRES.T):
    grid = struct.pack("<II8d", rows, 24, 0, 0, 2, 3, -1, 1, rotation, 1.70141e38)
    data = values.astype("<f8").tobytes()
    return (
        b"DSRB"
        + struct.pack("<II", 4, 1)
        + b"GRID"
        + struct.pack("<I", 72)
        + grid
        + b"DATA"
        + (struct.pack("<I", len(data)) + data)
    )


AXIS = "<C{0}><AxisType>{1}</AxisType><DataType>{2}</DataType><Increment>{3}</Increment><Offset>0</Offset></C{0}>"


def x3p(digest="", first="I", size_x=24, mask=False, rotation=None):
    data = HEIGHTS.T.astype("<f8").tobytes()
    axes = AXIS.format("X", first, "D", 2e-6) + AXIS.format("Y", "I", "D", 3e-6) + AXIS.format("Z", "A", "D", 1)
    if rotation is not None:
        turned = {f"r{row + 1}{column + 1}": rotation[row][column] for row in range(3) for column in range(3)}
        axes += f"<Rotation>{''.join(f'<{name}>{one:g}</{name}>' for name, one in turned.items())}</Rotation>"
    links = "<PointDataLink>bindata/data.bin</PointDataLink>"
    links += f"<MD5ChecksumPointData>{digest or hashlib.md5(data).hexdigest()}</MD5ChecksumPointData>"
    links += "<ValidPointsLink>bindata/valid.bin</ValidPointsLink>" if mask else ""
    xml = (
        '<?xml version="1.0"?><p:ISO5436_2 xmlns:p="http://www.opengps.eu/2008/ISO5436_2"><Record1>'
        f"<Revision>ISO5436 - 2000</Revision><FeatureType>SUR</FeatureType><Axes>{axes}</Axes></Record1><Record3>"
        f"<MatrixDimension><SizeX>{size_x}</SizeX><SizeY>37</SizeY><SizeZ>1</SizeZ></MatrixDimension>"
        f"<DataLink>{links}</DataLink></Record3></p:ISO5436_2>"
    )
    members = {"main.xml": xml, "bindata/data.bin": data}
    if mask:
        members["bindata/valid.bin"] = np.packbits(np.arange(888) != 25, bitorder="little").tobytes()
    return archive(members)


def archive(members):
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as file:
        for name, content in members.items():
            file.writestr(name, content)
    return stream.getvalue()


def simple_field(sides="XReal = 48e-6\nYReal = 111e-6\nXYUnits = m\nZUnits = m\n", values=HEIGHTS):
    head = f"Gwyddion Simple Field 1.0\nXRes = 24\nYRes = 37\n{sides}".encode()
    return head + bytes(4 - len(head) % 4) + values.T[::-1].astype("<f4").tobytes()


def simple_points(channels=1):
    head = f"Gwyddion XYZ Field 1.0\nNChannels = {channels}\nNPoints = 888\nXYUnits = m\nZUnits1 = m\n".encode()
    columns = [1e-6 * GRID[0], 1e-6 * GRID[1], *channels * [HEIGHTS]]
    return head + bytes(8 - len(head) % 8) + np.stack(columns, axis=-1).astype("<f8").tobytes()


ALL = {"size": SIZE, "unit": "um"}
READ = {
    "HDF5, units in an attribute": ("a.h5", lambda: h5({"units": "um"}), {"size": SIZE}),
    "HDF5, text of one length": ("a.h5", lambda: h5({"Unit": np.bytes_("µm".encode())}), {"size": SIZE}),
    "HDF5, a dataset names the unit": ("a.h5", lambda: h5(zunit="um", size=SIZE), {}),
    "HDF5, sides with a unit": ("a.h5", lambda: h5({"units": "um"}, size=SIZE), {}),
    "HDF5, packed": (
        "a.h5",
        lambda: h5(
            {"units": "nm", "scale_factor": 1e-4, "add_offset": 5.0}, np.round((HEIGHTS * 1e9 - 5) * 1e4).astype("i8")
        ),
        {"size": SIZE},
    ),
    "HDF5, axes with labels": ("a.h5", lambda: h5({"units": "um"}, MICROMETRES.T, ("y", "x")), {"size": SIZE}),
    "HDF5, positions": ("a.hdf5", lambda: h5({"units": "um"}, x=X, y=Y), {"size": SIZE}),
    "HDF5, attributes of the file": ("a.h5", lambda: h5(of_file={"zunit": "um", "lx": SIZE[0], "ly": SIZE[1]}), {}),
    "HDF5, capitals": ("a.h5", lambda: h5({"UNITS": "um"}), {"size": SIZE}),
    "HDF5, a size of pixels": ("a.h5", lambda: h5({"unit_z": "um", "pixel_size": (2e-6, 3e-6)}), {}),
    "HDF5, a pitch beside the heights": ("a.h5", lambda: h5({"unit": "um", "dx": 2e-6, "dy": 3e-6}), {}),
    "HDF5, positions of all points": ("a.h5", lambda: h5(values=MICROMETRES.T, x=GRID[0].T, y=GRID[1].T), ALL),
    "netCDF of GMT": ("a.grd", netcdf4, {"unit": "um"}),
    "netCDF classic of GMT": ("a.grd", lambda: netcdf3(), {"unit": "um"}),
    "netCDF classic, places on the earth": ("a.nc", lambda: netcdf3(dims=("lat", "lon")), {"unit": "um"}),
    "netCDF-4, y first": (
        "a.nc",
        netcdf4,
        {"unit": "um"},
    ),
    "netCDF-4, unit of heights": ("a.nc", lambda: netcdf4(values=1e3 * MICROMETRES.T, long_name="z"), {"unit": "nm"}),
    "netCDF-4, positions in mm": ("a.nc", lambda: netcdf4(units="mm", places=(1e-3 * Y, 1e-3 * X)), {"unit": "um"}),
    "netCDF-4, y falls": ("a.nc", lambda: netcdf4(IMAGE, places=(Y[::-1], X)), {"unit": "um"}),
    "netCDF classic": ("a.nc", lambda: netcdf3(), {"unit": "um"}),
    "netCDF classic, packed": (
        "a.nc",
        lambda: netcdf3(values=np.round(MICROMETRES.T * 1e7).astype("i4"), scale_factor=1e-7),
        {"unit": "um"},
    ),
    "MATLAB, a text names the unit": ("a.mat", lambda: mat(heights=MICROMETRES, zunit="um", size=SIZE), {}),
    "MATLAB, positions": ("a.mat", lambda: mat(z=MICROMETRES.T, x=X, y=Y), ALL),
    "MATLAB, a number as unit": ("a.mat", lambda: mat(heights=MICROMETRES, zunit=1e-6, lx=SIZE[0], ly=SIZE[1]), {}),
    "numpy, a unit": ("a.npz", lambda: npz(heights=MICROMETRES, zunit="um", size=SIZE), {}),
    "numpy, a common unit": ("a.npz", lambda: npz(heights=MICROMETRES, unit="µm", size=(48.0, 111.0)), {"size": SIZE}),
    "numpy, positions of all points": (
        "a.npz",
        lambda: npz(heights=HEIGHTS.T, x=1e-6 * GRID[0].T, y=1e-6 * GRID[1].T),
        {"size": SIZE},
    ),
    "numpy, a pitch": ("a.npz", lambda: npz(heights=HEIGHTS, dx=2e-6, dy=3e-6), {}),
    "numpy, in single precision": ("a.npy", lambda: npy(MICROMETRES.astype("f4")), ALL),
    "TIFF": ("a.tif", lambda: tiff(), ALL),
    "TIFF, OME": (
        "a.ome.tif",
        lambda: tiff(
            ome=True,
            metadata={"axes": "YX", "PhysicalSizeX": 2.0, "PhysicalSizeY": 3000.0, "PhysicalSizeYUnit": "nm"},
        ),
        {"unit": "um"},
    ),
    "TIFF, GDAL's scale and unit": (
        "a.tif",
        lambda: tiff((IMAGE * 2).astype("f4"), **gdal(("scale", 0.5), ("unittype", "um"))),
        {"size": SIZE},
    ),
    "TIFF, GeoTIFF without a scale along y": (
        "a.tif",
        lambda: tiff(extratags=[(33550, "d", 3, (2.0, 0.0, 0.0), True)]),
        ALL,
    ),
    "TIFF, GeoTIFF": ("a.tif", lambda: tiff(extratags=[(33550, "d", 3, (2.0, 3.0, 0.0), True)]), ALL),
    "TIFF, big": ("a.tiff", lambda: tiff(bigtiff=True, compression="zlib"), ALL),
    "Surfer 6": ("a.grd", surfer6, ALL),
    "Surfer 7": ("a.grd", surfer7, ALL),
    "Gwyddion, a simple field": ("a.gsf", simple_field, {}),
    "Gwyddion, a simple field without units": (
        "a.gsf",
        lambda: simple_field("XReal = 48\nYReal = 111\n", MICROMETRES),
        ALL,
    ),
    "Gwyddion, simple points": ("a.gxyzf", simple_points, {}),
    "HDF5, several missing values": (
        "a.h5",
        lambda: h5({"units": "um", "missing_value": np.array([-99.0, -98.0])}),
        {"size": SIZE},
    ),
    "HDF5, an axis of one": (
        "a.h5",
        lambda: h5({"units": "um"}, MICROMETRES[None], ("time", "x", "y")),
        {"size": SIZE},
    ),
    "HDF5, a calibration of one": ("a.h5", lambda: h5({"units": "um", "z_calibration": 1.0}), {"size": SIZE}),
    "HDF5, upwards": ("a.h5", lambda: h5({"units": "um", "positive": "up"}), {"size": SIZE}),
    "HDF5, a resolution along each axis": (
        "a.h5",
        lambda: h5({"units": "um"}, of_file={"x_resolution": 2.0, "y_resolution": 3.0, "resolution_unit": "um"}),
        {},
    ),
    "netCDF classic, an axis of one": (
        "a.nc",
        lambda: netcdf3(values=MICROMETRES.T[None], dims=("time", "y", "x")),
        {"unit": "um"},
    ),
    "MATLAB, places of meshgrid": (
        "a.mat",
        lambda: mat(Z=MICROMETRES.T, X=GRID[0].T, Y=GRID[1].T),
        ALL,
    ),
    "TIFF, a description": ("a.tif", lambda: tiff(description="Z unit: um\ndx = 2 um\ndy = 3 um"), {}),
    "numpy, an extent": ("a.npz", lambda: npz(heights=HEIGHTS, extent=(0.0, 48e-6, -1e-6, 110e-6)), {}),
    "MATLAB, logicals": ("a.mat", lambda: mat(z=MICROMETRES, chosen=MICROMETRES > 0.1), ALL),
    "HDF5, attributes that change nothing": (
        "a.h5",
        lambda: h5({"units": "um", "calibration": "valid", "count": 888, "pixel_scale": 3.0, "info": "noise 3 nm"}),
        {"size": SIZE},
    ),
    "HDF5, words of the file": ("a.h5", lambda: h5(of_file={"Units Z": "um"}), {"size": SIZE}),
    "HDF5, a resolution of real numbers": ("a.h5", lambda: h5({"units": "um", "z_resolution": 1e-10}), {"size": SIZE}),
    "netCDF, axes without places": ("a.nc", rows_and_columns, {"size": SIZE}),
    "HDF5, a unit in the name": ("a.h5", lambda: named_h5("height_um"), {"size": SIZE}),
    "numpy, names of axes": ("a.npz", lambda: npz(heights=HEIGHTS.T, dims=("y", "x"), size=SIZE), {}),
    "numpy, a text without a unit": ("a.npz", lambda: npz(heights=HEIGHTS, info="sample 10 nm", size=SIZE), {}),
    "HDF5, a unit that is given": ("a.h5", lambda: h5({"description": "heights in nm"}), ALL),
    "X3P, not turned": ("a.x3p", lambda: x3p(rotation=np.eye(3)), {}),
    "X3P": ("a.x3p", x3p, {}),
    "X3P without a checksum": ("a.x3p", lambda: x3p(digest="0" * 32), {}),
}


@pytest.mark.parametrize("name", READ)
def test_what_public_programs_write_is_read(tmp_path, name):
    file, make, options = READ[name]
    (tmp_path / file).write_bytes(make())
    found = rc.read_surface(tmp_path / file, **options)
    assert found.grid.shape == SHAPE
    assert found.grid.size == pytest.approx(SIZE)
    np.testing.assert_allclose(found.values, HEIGHTS, atol=2e-13)


def datx(shape=SHAPE, values=None):
    """A file of Zygo's Mx, which declares heights of a shape; those that are not written take no bytes."""
    h5py = pytest.importorskip("h5py")
    stream = io.BytesIO()
    with h5py.File(stream, "w") as file:
        rows = [(b"Root", b"Measurement", b"{M}"), (b"{M}", b"Surface", b"{S}"), (b"{S}", b"Path", b"/Data/Surface")]
        file["MetaData"] = np.array(rows, np.dtype([(key, "S64") for key in "abc"]))
        data = file.create_dataset("Data/Surface", shape=shape, dtype="f8", chunks=True)
        if values is not None:
            data[:] = values
        data.attrs["Unit"] = ["Meters"]
    return stream.getvalue()


def gwyddion(side=24, names=(("Topography", "m"),)):
    """A file of Gwyddion with fields of these names and units, which declare a number of columns."""

    def item(name, kind, content):
        return name.encode() + b"\0" + kind.encode() + content

    # The first line is the upper one, as in its text.
    values = HEIGHTS.T[::-1].astype("<f8").tobytes()
    inner = item("xres", "i", struct.pack("<i", side)) + item("yres", "i", struct.pack("<i", 37))
    inner += item("xreal", "d", struct.pack("<d", SIZE[0])) + item("yreal", "d", struct.pack("<d", SIZE[1]))

    def unit(text):
        named = item("unitstr", "s", text.encode() + b"\0")
        return b"GwySIUnit\0" + struct.pack("<I", len(named)) + named

    content = b""
    for number, (name, height_unit) in enumerate(names):
        field = inner + item("si_unit_xy", "o", unit("m")) + item("si_unit_z", "o", unit(height_unit))
        field += item("data", "D", struct.pack("<I", 888) + values)
        whole = b"GwyDataField\0" + struct.pack("<I", len(field)) + field
        content += item(f"/{number}/data", "o", whole)
        content += item(f"/{number}/data/title", "s", name.encode() + b"\0")
    return b"GWYPGwyContainer\0" + struct.pack("<I", len(content)) + content


def digital_surf(columns=24):
    """A file .sur of Digital Surf; heights in steps of .1 nm."""
    text = [b"X", b"Y", b"Z", b"mm", b"mm", b"\xb5m", b"mm", b"mm", b"\xb5m"]
    head = struct.pack("<12s4H30s30s5H", b"DIGITAL SURF", 0, 1, 1, 2, b"map", b"", 0, 0, 0, 0, 1) + bytes(8)
    head += struct.pack("<H2i2iI3f", 16, -9999, 9999, columns, 37, columns * 37, 2e-3, 3e-3, 1e-4)
    head += b"".join(word.ljust(16) for word in text) + struct.pack("<3f3H", 1, 1, 1, 0, 0, 0) + bytes(12)
    head += struct.pack("<7Hf", 0, 0, 0, 1, 1, 2026, 1, 0) + bytes(10) + struct.pack("<2H", 0, 0) + bytes(128)
    head += struct.pack("<3f", 0, 0, 0) + bytes(34)
    return head + np.round(MICROMETRES.T * 1e4).astype("<i2").tobytes()


def sdf(columns=24, kind="b"):
    """A file of ISO 25178-71, binary in double precision, or text."""
    dates = (b"own       ", b"010120260000", b"010120260000")
    if kind == "b":
        head = b"bISO-1.0" + b"".join(dates) + struct.pack("<2H4d3B", columns, 37, 2e-6, 3e-6, 1e-6, -1, 0, 7, 0)
        return head + MICROMETRES.T.astype("<f8").tobytes()
    lines = ["aISO-1.0", "ManufacID = own", "CreateDate = 010120260000", "ModDate = 010120260000"]
    lines += [f"NumPoints = {columns}", "NumProfiles = 37", "Xscale = 2e-6", "Yscale = 3e-6", "Zscale = 1e-6"]
    lines += ["Zresolution = -1", "Compression = 0", "DataType = 7", "CheckType = 0", "*"]
    lines += [" ".join(f"{value:.9g}" for value in row) for row in MICROMETRES.T]
    return ("\n".join([*lines, "*"]) + "\n").encode()


def bcr(columns=24):
    """A file of the Community Bureau of Reference, as SPIP writes it: the first line is the upper one."""
    head = f"fileformat = bcrstm\nheadersize = 2048\nxpixels = {columns}\nypixels = 37\nxlength = 48000\n"
    head += "ylength = 111000\nxunit = nm\nyunit = nm\nzunit = nm\nbit2nm = 0.1\nintelmode = 1\nvoidpixels = 0\n"
    return head.encode().ljust(2048, b"%") + np.round(1e4 * IMAGE).astype("<i2").tobytes()


# The largest error of the heights that each file holds, m: half a step of its integers, and the digits of its text.
INSTRUMENTS = {
    "BCR-STM": ("a.bcr", bcr, 0.51e-10),
    "Gwyddion": ("a.gwy", gwyddion, 1e-20),
    "Digital Surf": ("a.sur", digital_surf, 0.51e-10),
    "ISO 25178-71, binary": ("a.sdf", sdf, 1e-20),
    "ISO 25178-71, text": ("a.sdf", lambda columns=24: sdf(columns, "a"), 1e-14),
}


@pytest.fixture
def instruments():
    # Its imports warn of optional parallel packages.
    with warnings.catch_warnings(action="ignore"):
        pytest.importorskip("SurfaceTopography", exc_type=ImportError)
        import SurfaceTopography.IO  # noqa: F401


@pytest.mark.parametrize("name", INSTRUMENTS)
def test_what_instruments_write_is_read(instruments, tmp_path, name):
    file, make, error = INSTRUMENTS[name]
    (tmp_path / file).write_bytes(make())
    found = rc.read_surface(tmp_path / file)
    assert found.grid.shape == SHAPE
    assert found.grid.size == pytest.approx(SIZE)
    np.testing.assert_allclose(found.values, HEIGHTS, atol=error, rtol=0.0)


def refuse(path, words, **options):
    """Require that a file is refused with a sentence that has these words, in little memory."""
    tracemalloc.start()
    with pytest.raises(rc.InputError) as caught:
        rc.read_surface(path, **options)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    sentence = str(caught.value)
    assert words in sentence
    assert sentence.isprintable()
    assert len(sentence) < 500
    assert peak < MEMORY


@pytest.mark.parametrize("name", INSTRUMENTS)
def test_a_small_file_of_an_instrument_cannot_declare_gigabytes(instruments, tmp_path, name):
    file, make, _ = INSTRUMENTS[name]
    (tmp_path / file).write_bytes(make())
    rc.read_surface(tmp_path / file)
    (tmp_path / file).write_bytes(make(30_000))
    refuse(
        tmp_path / file,
        {
            "Gwyddion": "more than",
        }.get(name, "30000 x 37"),
    )


def compound(block):
    """A file of Windows as MountainsMap has it, with a deflated block."""
    return b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + bytes(504) + zlib.compress(block)


def endless_heap():
    """A file of HDF5 whose heap of texts has an object without a size: HDF5 would step from it to itself."""
    head, *heaps = h5({"units": "um"}).split(b"GCOL")
    return b"GCOL".join([head, *(heap[:12] + bytes(192) + heap[204:] for heap in heaps)])


REFUSED = {
    "HDF5, volts": ("a.h5", lambda: h5({"units": "V"}), "values in 'V', which is not a known unit of length"),
    "HDF5, a scale": ("a.h5", lambda: h5({"units": "m", "scale": 1e-3}), "'scale = 0.001', which changes"),
    "HDF5, a mask": ("a.h5", lambda: h5(mask=np.ones(SHAPE, "u1")), "'mask = an array', which changes"),
    "HDF5, packed with a text": ("a.h5", lambda: h5({"scale_factor": "small"}), "'small' as its scale_factor"),
    "HDF5, irregular positions": ("a.h5", lambda: h5(x=X**2, y=Y), "its positions x are not regular"),
    "HDF5, an endless heap": ("a.h5", endless_heap, "its texts are damaged"),
    "HDF5, objects of Python": ("a.h5", lambda: h5(a=1.0) + b"NUMPY:|O", "objects of Python"),
    "HDF5, nothing written": ("a.h5", lambda: datx((20_000, 20_000)), "larger than a file of"),
    "Zygo, nothing written": ("a.datx", lambda: datx((20_000, 20_000)), "larger than a file of"),
    "any ending, nothing written": ("a.spm", lambda: datx((3000, 3000, 40)), "larger than a file of"),
    "netCDF, feet": ("a.nc", lambda: netcdf4(units="feet"), "are 2 x 3 apart in 'feet'"),
    "netCDF classic, nothing written": (
        "a.nc",
        lambda: netcdf3().replace(struct.pack(">I", 37), struct.pack(">I", 10**8), 1),
        "its head states more than it holds",
    ),
    "HDF5, a scale of the file": ("a.h5", lambda: h5(of_file={"scale": 0.5}), "'scale = 0.5', which changes"),
    "HDF5, a calibration": ("a.h5", lambda: h5({"z_calibration": "12 nm/V"}), "'z_calibration = 12 nm/V', which"),
    "HDF5, downwards": ("a.h5", lambda: h5({"units": "um", "positive": "down"}), "'positive = down', which"),
    "HDF5, depths": ("a.h5", lambda: h5({"units": "um", "long_name": "depth of wear"}), "'depth of wear', positive"),
    "netCDF classic, downwards": ("a.nc", lambda: netcdf3(positive=b"down"), "'positive = down', which"),
    "netCDF, depths": ("a.nc", lambda: netcdf3(name="depth"), "'depth', positive downwards"),
    "numpy, points": (
        "a.npy",
        lambda: npy(np.stack((*GRID, MICROMETRES), axis=-1).reshape(-1, 3)),
        "is a point x y z of a regular grid",
    ),
    "MATLAB, a mask": ("a.mat", lambda: mat(z=MICROMETRES, mask=MICROMETRES > 0.1), "'mask = an array'"),
    "netCDF, without signs": ("a.nc", lambda: netcdf4(_Unsigned="true"), "'_Unsigned = true'"),
    "HDF5, a unit in its description": (
        "a.h5",
        lambda: h5({"description": "heights in nm", "size": SIZE}),
        "'heights in nm', which may be the unit of its heights: give unit=",
    ),
    "HDF5, a unit for a count": ("a.h5", lambda: h5({"nm_per_count": 0.1}), "'nm_per_count = 0.1', which"),
    "netCDF classic, a unit in its name": (
        "a.nc",
        lambda: netcdf3(long_name=b"height (nm)"),
        "'height (nm)', which may",
    ),
    "numpy, a unit in a text": (
        "a.npz",
        lambda: npz(heights=MICROMETRES, metadata='{"z_unit": "um"}', size=SIZE),
        "which may name the unit",
    ),
    "HDF5, a factor to a unit": ("a.h5", lambda: h5({"to_um": 1e-3}), "'to_um = 0.001', which"),
    "HDF5, steps of integers": (
        "a.h5",
        lambda: h5({"zstep": 1e-10}, np.round(1e4 * MICROMETRES).astype("i4")),
        "'zstep = 1e-10', which",
    ),
    "HDF5, a text of the file": (
        "a.h5",
        lambda: h5({"size": SIZE}, of_file={"meta": '{"z": "um"}'}),
        "which may be the unit of its heights",
    ),
    "MATLAB, a unit in a cell": (
        "a.mat",
        lambda: mat(heights=MICROMETRES, units=np.array(["um"], dtype=object)),
        "'units' is a cell or a structure",
    ),
    "MATLAB, points": (
        "a.mat",
        lambda: mat(z=np.stack((*GRID, MICROMETRES), axis=-1).reshape(-1, 3)),
        "is a point x y z of a regular grid",
    ),
    "Gwyddion, a simple field, volts": (
        "a.gsf",
        lambda: simple_field("XReal = 48e-6\nYReal = 111e-6\nXYUnits = m\nZUnits = V\n"),
        "values in 'V'",
    ),
    "Gwyddion, a simple field, cut": ("a.gsf", lambda: simple_field()[:-1], "declares 3552 bytes of numbers"),
    "Gwyddion, a simple field without an end": ("a.gsf", lambda: b"Gwyddion Simple Field 1.0\nX = 1\n", "does not end"),
    "Gwyddion, a simple field without points": (
        "a.gsf",
        lambda: simple_field().replace(b"XRes = 24", b"XRes = -4"),
        "its XRes is '-4'",
    ),
    "Gwyddion, a simple field without a side": (
        "a.gsf",
        lambda: simple_field("XReal = wide\nYReal = 1\n"),
        "its XReal is 'wide'",
    ),
    "Gwyddion, simple points of two channels": ("a.gxyzf", lambda: simple_points(2), "it holds 2 channels"),
    "Gwyddion, another simple field": ("a.gsf", lambda: b"GSF 2", "does not begin as the simple fields"),
    "TIFF, a scale in its description": (
        "a.tif",
        lambda: tiff(description="Z scale: 12.5 nm per count"),
        "'Z scale: 12.5 nm per count', which",
    ),
    "X3P, turned": ("a.x3p", lambda: x3p(rotation=np.diag([1.0, -1.0, -1.0])), "a rotation of its axes"),
    "MATLAB, volts": ("a.mat", lambda: mat(heights=MICROMETRES, unit="V"), "values in 'V'"),
    "MATLAB, a scale": ("a.mat", lambda: mat(heights=MICROMETRES, zscale=0.5), "'zscale = 0.5', which changes"),
    "numpy, a scale": ("a.npz", lambda: npz(heights=MICROMETRES, scale=1e-3), "'scale = 0.001'"),
    "numpy, a scale of heights": (
        "a.npz",
        lambda: npz(heights=MICROMETRES, height_scale=1e-6),
        "'height_scale = 1e-06'",
    ),
    "numpy, a mask": ("a.npz", lambda: npz(heights=MICROMETRES, mask=np.ones(SHAPE, bool)), "'mask = an array'"),
    "numpy, sides in a common unit": (
        "a.npz",
        lambda: npz(heights=MICROMETRES, unit="um", size=(0.048, 0.111)),
        "apart in a unit that it does not state",
    ),
    "TIFF, upside down": ("a.tif", lambda: tiff(extratags=[(274, "H", 1, 4, True)]), "orientation 4"),
    "TIFF, feet": ("a.tif", lambda: tiff(**gdal(("unittype", "feet"))), "values in 'feet'"),
    "TIFF, a curve": (
        "a.tif",
        lambda: tiff(imagej=True, metadata={"cf": 2, "c0": 0, "c1": 1, "vunit": "um"}),
        "not a straight line",
    ),
    "Surfer 6, cut": ("a.grd", lambda: surfer6()[:-4], "24 x 37 points, but holds 887"),
    "Surfer 6, huge": ("a.grd", lambda: surfer6(30_000), "30000 x 37 points, but holds 888"),
    "Surfer 7, huge": ("a.grd", lambda: surfer7(2**31), "24 x 2147483648 points, but holds 888"),
    "Surfer 7, turned": ("a.grd", lambda: surfer7(rotation=30.0), "turned by 30"),
    "X3P, another checksum": ("a.x3p", lambda: x3p(digest="1" * 32), "not those of its checksum"),
    "X3P, absolute positions": ("a.x3p", lambda: x3p(first="A"), "its x are absolute positions"),
    "X3P, huge": ("a.x3p", lambda: x3p(size_x=30_000), "bytes, but 8880000 are stated"),
    "MountainsMap, a bomb": ("a.mnt", lambda: compound(bytes(2**24)), "its blocks expand to more than"),
    "MountainsMap, compressed": ("a.sur", lambda: b"DSCOMPRESSED" + bytes(600), "a compressed file of MountainsMap"),
    "JPK": ("a.h5-jpk", h5, "export its heights as .jpk"),
    "a workbook": (
        "a.xlsx",
        lambda: archive({"xl/_rels/a": "", "[Content_Types].xml": ""}),
        "the sheet of its heights",
    ),
    "a workbook by another name": ("a.plux", lambda: archive({"[Content_Types].xml": ""}), "the sheet of its heights"),
    "an old workbook": ("a.xls", lambda: compound(b"a"), "the sheet of its heights as CSV"),
    "gzip": ("a.tif.gz", lambda: gzip.compress(tiff()), "gunzip"),
    "xz": ("a.txt.xz", lambda: b"\xfd7zXZ\0\0", "unpack it first"),
    "a mesh": ("a.stl", lambda: bytes(80) + struct.pack("<I", 1) + bytes(50), "a mesh in STL"),
    "a cloud": ("a.las", lambda: b"LASF" + bytes(99), "a cloud of points in LAS"),
    "a pickle": ("a.pkl", lambda: b"\x80\x04\x8c\x02os.", "an object of Python"),
    "FITS": ("a.fits", lambda: b"SIMPLE  =                    T".ljust(2880), "an image in FITS"),
    "numpy, one number": ("a.npy", lambda: npy(np.ones((1, 1))), "no more than one number"),
    "numpy, records": ("a.npy", lambda: npy(np.ones(SHAPE, [("z", "f8")])), "not of numbers: save the heights alone"),
    "no npy": ("a.npy", lambda: b"\xef\xbf\xbdNUMPY" + bytes(99), "does not begin as .npy files do"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_not_understood_is_refused_with_a_sentence(tmp_path, name):
    file, make, words = REFUSED[name]
    (tmp_path / file).write_bytes(make())
    if file in ("a.datx", "a.spm", "a.mnt"):
        with contextlib.suppress(rc.InputError):
            rc.read_surface(tmp_path / file)
    refuse(tmp_path / file, words)


def test_points_without_data_are_not_measured(tmp_path):
    values = MICROMETRES.T.copy()
    values[4, 7] = 1.70141e38
    missing = np.zeros(SHAPE, bool)
    missing[7, 4] = True
    outside = np.where(missing, 99.0, MICROMETRES)
    masked = np.zeros(SHAPE[::-1], "i1")
    masked[4, 7] = 1
    (tmp_path / "6.grd").write_bytes(surfer6(values=values))
    (tmp_path / "7.grd").write_bytes(surfer7(values=values))
    (tmp_path / "a.h5").write_bytes(h5({"units": "um", "valid_range": (-9.0, 9.0)}, outside))
    (tmp_path / "b.h5").write_bytes(h5({"units": "um", "valid_max": 9.0}, outside))
    (tmp_path / "a.nc").write_bytes(netcdf3(values=outside.T.copy(), missing_value=99.0, units="um"))
    for name, unit in (("6.grd", "um"), ("7.grd", "um"), ("a.h5", None), ("b.h5", None), ("a.nc", "um")):
        found = rc.read_surface(tmp_path / name, size=SIZE, unit=unit, non_measured="keep")
        np.testing.assert_array_equal(found.non_measured, missing)
    # A stated number is used, one that is not stated is asked about.
    marked = np.where(missing, -9999.0, MICROMETRES)
    (tmp_path / "c.h5").write_bytes(h5({"units": "um", "nodata": -9999.0}, marked))
    np.testing.assert_array_equal(
        rc.read_surface(tmp_path / "c.h5", size=SIZE, non_measured="keep").non_measured, missing
    )
    bare = {
        "d.h5": h5({}, marked),
        "d.mat": mat(heights=marked),
        "d.npz": npz(heights=marked),
        "d.nc": netcdf3(values=marked.T.copy()),
        "d.tif": tiff(marked.T[::-1].astype("f4")),
    }
    for name, content in bare.items():
        (tmp_path / name).write_bytes(content)
        refuse(tmp_path / name, "no_data=-9999, or no_data='none'")
        options = {"size": SIZE} if name == "d.npz" else ALL
        found = rc.read_surface(tmp_path / name, **options, no_data=-9999.0, non_measured="keep")
        np.testing.assert_array_equal(found.non_measured, missing)
    (tmp_path / "d.npz").write_bytes(npz(heights=marked, size=SIZE, periodic=False))
    assert rc.read_surface(tmp_path / "d.npz").non_measured is None
    (tmp_path / "a.x3p").write_bytes(x3p(mask=True))
    found = rc.read_surface(tmp_path / "a.x3p", non_measured="keep")
    assert np.argwhere(found.non_measured).tolist() == [[1, 1]]


def test_the_sentence_of_a_damaged_file_names_its_kind(instruments, tmp_path):
    (tmp_path / "a.sur").write_bytes(digital_surf()[:200])
    refuse(tmp_path / "a.sur", "begins as files of Digital Surf SUR do")
    # 100 integers of 16 bits are no heights of the earth by another name.
    (tmp_path / "a.raw").write_bytes(bytes(range(200)))
    refuse(tmp_path / "a.raw", "its content fits none of the formats")


def test_the_channel_of_heights_is_taken_and_named(instruments, tmp_path):
    shown = [("Phase", "deg"), ("Height", "m"), ("Deflection", "m"), ("ZSensor", "m")]
    path = tmp_path / "a.gwy"
    path.write_bytes(gwyddion(names=shown))
    assert "channel 'Height' of 3" in rc.read_surface(path).history[0]
    path.write_bytes(gwyddion(names=[("Phase", "deg"), ("Deflection", "m")]))
    refuse(path, "it holds no heights, but Deflection")


# Draws of damage for each kind; `pytest -m slow` makes more.
DRAWS = 12


def damage(path, make, options, numbers):
    """Read a file that is damaged at random: it is refused with a sentence, or a map of finite heights."""
    whole = make()
    for number in numbers:
        path.write_bytes(damage_bytes(whole, np.random.default_rng(number)))
        with contextlib.suppress(rc.InputError):
            found = rc.read_surface(path, non_measured="keep", **options)
            assert np.isfinite(found.values).all(), number


@pytest.mark.parametrize("name", READ)
def test_damage_is_a_sentence(tmp_path, name):
    file, make, options = READ[name]
    damage(tmp_path / file, make, options, range(DRAWS))


@pytest.mark.parametrize("name", INSTRUMENTS)
def test_damage_of_instruments_files_is_a_sentence(instruments, tmp_path, name):
    file, make, _ = INSTRUMENTS[name]
    damage(tmp_path / file, make, {}, range(DRAWS))


@pytest.mark.slow
@pytest.mark.parametrize("name", READ | INSTRUMENTS)
def test_much_damage_is_a_sentence(instruments, tmp_path, name):
    file, make, options = (READ | INSTRUMENTS)[name]
    damage(tmp_path / file, make, options if name in READ else {}, range(DRAWS, 300))
