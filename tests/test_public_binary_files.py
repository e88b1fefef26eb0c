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
IMAGE = MICROMETRES.T[::-1]
# Bytes that reading or refusing such a file may take.
MEMORY = 2**23


def h5(attributes=None, values=MICROMETRES, axes=(), **others):
    h5py = pytest.importorskip("h5py")
    stream = io.BytesIO()
    with h5py.File(stream, "w") as file:
        data = file.create_dataset("heights", data=values)
        data.attrs.update(attributes or {})
        for axis, name in enumerate(axes):
            data.dims[axis].label = name
        for name, one in others.items():
            file[name] = one
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
        for axis, places in zip(dims, (Y, X), strict=True):
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


def tiff(values=IMAGE.astype("f4"), **options):
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


def surfer_text(columns=24):
    rows = "\n".join(" ".join(f"{value:.9g}" for value in row) for row in MICROMETRES.T)
    return f"DSAA\n{columns} 37\n0 46\n0 108\n-1 1\n{rows}\n".encode()


AXIS = "<C{0}><AxisType>{1}</AxisType><DataType>{2}</DataType><Increment>{3}</Increment><Offset>0</Offset></C{0}>"


def x3p(digest="", first="I", size_x=24, mask=False):
    data = HEIGHTS.T.astype("<f8").tobytes()
    axes = AXIS.format("X", first, "D", 2e-6) + AXIS.format("Y", "I", "D", 3e-6) + AXIS.format("Z", "A", "D", 1)
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
    "TIFF, GeoTIFF": ("a.tif", lambda: tiff(extratags=[(33550, "d", 3, (2.0, 3.0, 0.0), True)]), ALL),
    "TIFF, big": ("a.tiff", lambda: tiff(bigtiff=True, compression="zlib"), ALL),
    "Surfer 6": ("a.grd", surfer6, ALL),
    "Surfer 7": ("a.grd", surfer7, ALL),
    "Surfer, text": ("a.grd", surfer_text, ALL),
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
        data = file.create_dataset("Data/Surface", shape=shape, dtype="f8", chunks=(10, 10))
        if values is not None:
            data[:] = values
        data.attrs["Unit"] = ["Meters"]
    return stream.getvalue()


def gwyddion(side=24):
    """A file of Gwyddion whose one field declares a number of columns."""

    def item(name, kind, content):
        return name.encode() + b"\0" + kind.encode() + content

    values = HEIGHTS.T.astype("<f8").tobytes()
    inner = item("xres", "i", struct.pack("<i", side)) + item("yres", "i", struct.pack("<i", 37))
    inner += item("xreal", "d", struct.pack("<d", SIZE[0])) + item("yreal", "d", struct.pack("<d", SIZE[1]))
    unit = b"GwySIUnit\0" + struct.pack("<I", 10) + item("unitstr", "s", b"m\0")[:10]
    inner += item("si_unit_xy", "o", unit) + item("si_unit_z", "o", unit)
    inner += item("data", "D", struct.pack("<I", 888) + values)
    field = b"GwyDataField\0" + struct.pack("<I", len(inner)) + inner
    content = item("/0/data", "o", field)
    return b"GWYPGwyContainer\0" + struct.pack("<I", len(content)) + content


def digital_surf(columns=24, rows=37, **changes):
    """A file .sur of Digital Surf; heights in steps of .1 nm."""
    fields = {"code": b"DIGITAL SURF", "items": 16, "columns": columns, "rows": rows, "dx": 2e-3, "dy": 3e-3} | changes
    text = [b"X", b"Y", b"Z", b"mm", b"mm", b"\xb5m", b"mm", b"mm", b"\xb5m"]
    head = (
        struct.pack(
            "<12s4H30s30s5H8xH5iI3f",
            fields["code"],
            0,
            1,
            1,
            2,
            b"map",
            b"",
            0,
            0,
            0,
            0,
            1,
            fields["items"],
            -9999,
            9999,
            columns,
            rows,
            columns * rows,
            fields["dx"],
            fields["dy"],
            1e-4,
        )
        if False
        else None
    )
    head = struct.pack("<12s4H30s30s5H", fields["code"], 0, 1, 1, 2, b"map", b"", 0, 0, 0, 0, 1) + bytes(8)
    head += struct.pack(
        "<H2i2iI3f", fields["items"], -9999, 9999, columns, rows, columns * rows, fields["dx"], fields["dy"], 1e-4
    )
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


INSTRUMENTS = {
    "Gwyddion": ("a.gwy", gwyddion),
    "Digital Surf": ("a.sur", digital_surf),
    "ISO 25178-71, binary": ("a.sdf", sdf),
    "ISO 25178-71, text": ("a.sdf", lambda columns=24: sdf(columns, "a")),
}


@pytest.fixture
def instruments():
    # Its imports warn of optional parallel packages.
    import warnings

    with warnings.catch_warnings(action="ignore"):
        pytest.importorskip("SurfaceTopography", exc_type=ImportError)
        import SurfaceTopography.IO  # noqa: F401


@pytest.mark.parametrize("name", INSTRUMENTS)
def test_what_instruments_write_is_read(instruments, tmp_path, name):
    file, make = INSTRUMENTS[name]
    (tmp_path / file).write_bytes(make())
    found = rc.read_surface(tmp_path / file)
    assert found.grid.shape == SHAPE
    assert found.grid.size == pytest.approx(SIZE)
    rows = [HEIGHTS, HEIGHTS[:, ::-1]]
    assert min(float(np.abs(found.values - one).max()) for one in rows) < 1e-10


@pytest.mark.parametrize("name", INSTRUMENTS)
def test_a_small_file_of_an_instrument_cannot_declare_gigabytes(instruments, tmp_path, name):
    file, make = INSTRUMENTS[name]
    (tmp_path / file).write_bytes(make())
    rc.read_surface(tmp_path / file)
    (tmp_path / file).write_bytes(make(30_000))
    refuse(tmp_path / file, "")
