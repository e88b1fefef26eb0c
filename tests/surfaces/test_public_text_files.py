"""Text files as instruments, programs and libraries write them: read right, or refused with a sentence that helps."""

import gzip
import io

import numpy as np
import pytest

import roughcontact as rc

NX, NY = 24, 37
# Distances of the points along x and y, µm.
DX, DY = 2.0, 3.0
SIZE = (NX * DX * 1e-6, NY * DY * 1e-6)
X, Y = np.meshgrid(DX * np.arange(NX), DY * np.arange(NY), indexing="ij")
# Heights in µm, indexed [x, y], with the four decimals that the files have.
Z = np.round(1.3 + 0.8 * np.sin(0.31 * X + 0.2) * np.cos(0.17 * Y) + 0.013 * X, 4)
MISSING = (X > 30) & (Y > 90)
GIVEN = {"size": SIZE, "unit": "um"}
# Files with one distance of points are of square cells; they state it.
SQUARE = {"size": (NX * DX * 1e-6, NY * DX * 1e-6)}


def lines(values, separator="\t", form="{:.4f}", missing="nan", decimal="."):
    """Return a line of text for each first index."""
    return "".join(
        separator.join(missing if np.isnan(one) else form.format(one).replace(".", decimal) for one in row) + "\n"
        for row in values.tolist()
    )


def points(values=Z, separator="\t", form="{:.4f}", missing="nan", order="xyz", by="y", scale=1.0, more=()):
    """Return a line of text for each point, x fastest unless `by` is ``"x"``."""
    columns = {"x": X * scale, "y": Y * scale, "z": values} | dict(more)
    columns = {name: column if by == "x" else column.T for name, column in columns.items()}
    return "".join(
        separator.join(missing if np.isnan(one) else form.format(one) for one in numbers) + "\n"
        for numbers in zip(*(columns[name].ravel().tolist() for name in (*order, *(dict(more)))), strict=True)
    )


# Lines for each y: downwards, as of an image, and upwards.
DOWN = Z.T[::-1]
UP = Z.T


def gwyddion(channel="Height", width="Width", height="Height", units="Value units", unit="µm", mark="# "):
    side = (f"{NX * DX:.3f} µm", f"{NY * DY:.3f} µm")
    return f"{mark}Channel: {channel}\n{mark}{width}: {side[0]}\n{mark}{height}: {side[1]}\n{mark}{units}: {unit}\n"


def spip(*more):
    head = ["File Format = ASCII", "Created by SPIP 6.3.2.0 2014-12-12 11:16", "Original file: a.asc"]
    head += [f"x-pixels = {NX}", f"y-pixels = {NY}", f"x-length = {1e3 * NX * DX:g}", f"y-length = {1e3 * NY * DY:g}"]
    head += ["x-offset = 0", "y-offset = 0", *more, "voidpixels =0", "description:", "Start of Data:"]
    return "".join(f"# {line}\n" for line in head)


def attocube(unit="um"):
    head = ["Daisy frame view snapshot", "2009-07-14T10:12:34", f"x-pixels: {NX}", f"y-pixels: {NY}"]
    head += [f"x-length: {NX * DX}", f"y-length: {NY * DY}", "x-offset: 0", "y-offset: 0", "x-unit: um", "y-unit: um"]
    head += [f"z-unit: {unit}", "scanspeed: 2", "display: Topography", "Start of Data:"]
    return "".join(f"# {line}\n" for line in head)


def nova(scale=1.0):
    return (
        f"File Format = ASCII\nCreated by Nova\nNX = {NX}\nNY = {NY}\nScale X = {DX}\nScale Y = {DY}\nUnit X = um\n"
        f"Unit Data = um\nScale Data = {scale:g}\nDataScaleNeeded = no\nStart of Data :\n"
    )


def esri(missing="NODATA_value -9999\n", corner="corner"):
    return f"ncols {NX}\nnrows {NY}\nxll{corner} 0\nyll{corner} 0\ndx {DX}\ndy {DY}\n{missing}"


def grass(more=""):
    return f"north: {NY * DY}\nsouth: 0\neast: {NX * DX}\nwest: 0\nrows: {NY}\ncols: {NX}\n{more}"


def surfer():
    head = f"DSAA\n{NX} {NY}\n0 {DX * (NX - 1)}\n0 {DY * (NY - 1)}\n{Z.min()} {Z.max()}\n"
    wrapped = []
    for row in np.where(MISSING, np.nan, Z).T.tolist():
        texts = ["1.70141e+38" if np.isnan(one) else f"{one:.4f}" for one in row]
        wrapped += [" ".join(texts[k : k + 10]) for k in range(0, NX, 10)] + [""]
    return head + "\n".join(wrapped)


def sdf(version="aISO-1.0", kind=7, scale=1e-6):
    head = {"ManufacID": "ISOTC213", "CreateDate": "150320080000", "ModDate": "150320080000"}
    head |= {"NumPoints": NX, "NumProfiles": NY, "Xscale": DX * 1e-6, "Yscale": DY * 1e-6, "Zscale": scale}
    head |= {"Zresolution": -1, "Compression": 0, "DataType": kind, "CheckType": 0}
    stated = "".join(f"{name:<12}= {value}\n" for name, value in head.items())
    form = "{:.4f}" if kind == 7 else "{:.0f}"
    body = lines(np.where(MISSING, np.nan, Z).T * 1e-6 / scale, "\n", form, "BAD")
    return f"{version}\n{stated}*\n{body}*\n"


ZYGO = (
    '{kind}\n0 3 0 0 "Tue Aug 25 16:59:23 2026"\n0 0 0 0 1 255\n0 0 {nx} {ny}\n""\n""\n""\n'
    '0 0.5 6.328e-07 0.5 1 0 {step} 1787677163\n3 2 0 0 0 666666 ""\n1 0 1 33 0 0 0.1 60.4318 2 50\n'
    '1 1 100 0 0 0 0 0 0\n0 ""\n1 5\n""\n#\n'
)


def zygo_phase():
    phase = np.round(Z * 1e-6 / (0.5 * 6.328e-7 / 32768)).astype(int)
    numbers = np.where(MISSING, 2147483640, phase).T[::-1].ravel().tolist()
    body = "\n".join(" ".join(map(str, numbers[k : k + 10])) for k in range(0, len(numbers), 10))
    return ZYGO.format(kind="Zygo ASCII Data File - Format 2", nx=NX, ny=NY, step=2e-6) + "#\n" + body + "\n#\n"


def zygo_points():
    body = "".join(
        f"{i} {j} {'No Data' if MISSING[i, NY - 1 - j] else Z[i, NY - 1 - j]}\n" for j in range(NY) for i in range(NX)
    )
    return ZYGO.format(kind="Zygo XYZ Data File - Format 1", nx=NX, ny=NY, step=2e-6) + body + "#\n"


def wyko(in_nanometres=True):
    factor = 1.0 if in_nanometres else 600.0 / 2.0
    head = f"Wyko ASCII Data File Format 0\t{int(in_nanometres)}\t1\nX Size\t{NX}\nY Size\t{NY}\n"
    head += "Block Name\tType\tLength\tValue\nWavelength\t7\t4\t600\nMult\t7\t4\t2\nAspect\t7\t4\t1.5\n"
    head += f"Pixel_size\t7\t4\t{DX * 1e-3}\nTitle\t5\t20\tSample\nRAW_DATA\t3\t3552\t\n"
    return head + lines(np.where(MISSING, np.nan, Z) * 1e3 / factor, form="{:.9g}", missing="Bad")


def igor(unit="m", flag="/P", along_x=DX, along_y=DY):
    values = lines(Z * 1e-6, "\t", "\t{:.10g}")
    x, y = (f"{0.1 * flag.count('I'):g},{1e-6 * end + 0.1 * flag.count('I'):.12g}" for end in (along_x, along_y))
    return (
        f"IGOR\nWAVES/D/N=({NX},{NY})\theights\nBEGIN\n{values}END\n"
        f'X SetScale{flag} x {x},"m", heights; SetScale{flag} y {y},"m", heights; '
        f'SetScale d 0,0,"{unit}", heights\n'
    )


def wsxm(unit="um"):
    return f"WSxM file copyright UAM\nWSxM ASCII XYZ file\nX[um]\tY[um]\tZ[{unit}]\n\n"


def wsxm_matrix():
    return (
        "WSxM file copyright UAM\nWSxM ASCII Matrix file\n"
        f"X Amplitude: {NX * DX} µm\nY Amplitude: {NY * DY} µm\nZ Amplitude: 2.1 µm\n\n"
    )


def keyence(form='"{:.4f}"', unit="um", separator=","):
    head = [("Measured date", "2026-08-25"), ("Model", "VK-X3000 Series"), ("Data type", "ImageDataCsv")]
    head += [("Objective Lens Power", "50"), ("XY Calibration", "2000", "nm"), ("Output image data", "Height")]
    head += [("Horizontal", str(NX)), ("Vertical", str(NY)), ("Minimum value", "0.5"), ("Maximum value", "2.1")]
    head += [("Unit", unit), ("Reference data name", "")]
    text = "".join(separator.join(f'"{one}"' for one in line) + "\n" for line in head)
    return text + '\n"Height"\n' + lines(DOWN, separator, form)


KEYENCE_GERMAN = (
    f'"Messdatum";"25.08.2026"\n"XY-Justierung";"2000";"nm"\n"Bilddatenausgabe";"Höhe"\n"Horizont.";"{NX}"\n'
    f'"Vertikal";"{NY}"\n"Einheit";"um"\n\n"Höhe"\n' + lines(DOWN, ";", decimal=",")
)


def pandas_csv(**options):
    pandas = pytest.importorskip("pandas")
    frame = pandas.DataFrame(Z)
    text = io.StringIO()
    frame.to_csv(text, **options)
    return text.getvalue()


def savetxt(**options):
    text = io.StringIO()
    np.savetxt(text, Z, **options)
    return text.getvalue()


def r_table(names):
    first = " ".join(f'"V{k + 1}"' for k in range(NY)) + "\n"
    rows = "".join(
        (f'"{i + 1}" ' if names else "") + " ".join(map(str, row)) + "\n" for i, row in enumerate(Z.tolist())
    )
    return first + rows


def origin():
    heads = ("Long Name", "Units", "Comments")
    return "".join(head + "\t" * (NY - 1) + "\n" for head in heads) + lines(Z)


def without(values):
    return np.where(MISSING, np.nan, values)


OCTAVE = "# Created by Octave 9.2\n# name: z\n# type: matrix\n# rows: 24\n# columns: 37\n"
ROUNDED = "\t".join(f"{0.137 * k:.2f}" for k in range(NX)) + "\n"
DOUBLE = gwyddion() + lines(DOWN) + "\n" + gwyddion("Phase", unit="deg") + lines(30.0 * DOWN)
TITLED = "{}\n" + "".join(
    f"{x * 1e-3:.4f},{y * 1e-3:.4f},{z:.4f}\n"
    for y, row in zip(Y[0], Z.T, strict=True)
    for x, z in zip(X[:, 0], row, strict=True)
)
# The file, its text or bytes, and the options with which it is read.
READ = {
    "Gwyddion": ("a.txt", gwyddion() + lines(DOWN), {}),
    "Gwyddion in metres": ("a.txt", gwyddion(unit="m") + lines(DOWN * 1e-6, form="{:.10g}"), {}),
    "Gwyddion in German": ("a.txt", gwyddion("Topo", "Breite", "Höhe", "Einheiten") + lines(DOWN, decimal=","), {}),
    "Gwyddion in Czech": ("a.txt", gwyddion("Topo", "Šířka", "Výška", "Jednotky hodnot") + lines(DOWN), {}),
    "Gwyddion in French": ("a.txt", gwyddion("Topo", "Largeur ", "Hauteur ", "Unités ") + lines(DOWN), {}),
    "Gwyddion in Japanese": ("a.txt", gwyddion("Topo", "幅", "高さ", "値の単位") + lines(DOWN), {}),
    "Gwyddion in Russian": ("a.txt", gwyddion("Topo", "Ширина", "Высота", "Единицы измерения") + lines(DOWN), {}),
    "Gwyddion, points x y z": ("a.xyz", points(), GIVEN),
    "SPIP, bits": ("a.asc", spip("Bit2nm = 0.5") + lines(2e3 * DOWN), {}),
    "SPIP, unit": ("a.asc", spip("z-unit = um") + lines(DOWN), {}),
    "SPIP, another unit and bits of one": ("a.asc", spip("z-unit = um", "Bit2nm = 1") + lines(DOWN), {}),
    "scales that change nothing": (
        "a.txt",
        "# z-scale: 1\n# z offset: 0 nm\n# lsb: 1.0\n# missing points: 0\n# scale bar: 5 um\n" + lines(Z),
        GIVEN | {"rows": "x"},
    ),
    "a step in its bracket": ("a.txt", "# dx [um]: 2\n# dy [nm]: 3000\n# z unit: um\n" + lines(Z), {"rows": "x"}),
    "steps per pixel": (
        "a.txt",
        "# X scale: 2 um/pixel\n# Y scale: 3 um per point\nZ (um)\n" + lines(Z),
        {"rows": "x"},
    ),
    "sides without a unit, and theirs": (
        "a.txt",
        f"# x size: {NX * DX}\n# y size: {NY * DY}\n# lateral unit: um\n# z unit: um\n" + lines(Z),
        {"rows": "x"},
    ),
    "a unit that is a multiple": ("a.txt", "# z unit: 0.5 um\n" + lines(2.0 * Z), {"size": SIZE, "rows": "x"}),
    "lengths in a sentence": (
        "a.txt",
        f"# All lengths are in um\n# x size: {NX * DX}\n# y size: {NY * DY}\n" + lines(Z),
        {"rows": "x"},
    ),
    "heights in a sentence": ("a.txt", "# All heights are given in nm\n" + lines(1e3 * Z), {"size": SIZE, "rows": "x"}),
    "SPIP, unit and bits of one": ("a.asc", spip("z-unit = nm", "Bit2nm = 1") + lines(1e3 * DOWN), {}),
    "Attocube": ("a.asc", attocube() + lines(DOWN), {}),
    "Nova": ("a.txt", nova() + lines(DOWN), {}),
    "Nova, scaled": ("a.txt", nova(0.25) + lines(4.0 * DOWN), {}),
    "NanoScope": ("a.txt", "\\Exported image units: um\n" + lines(UP), {"size": SIZE, "rows": "y"}),
    "WSxM, points": ("a.txt", wsxm() + points(), {}),
    "WSxM, matrix": ("a.txt", wsxm_matrix() + lines(DOWN), {"unit": "um"}),
    "Igor": ("a.itx", igor(), {}),
    "Igor, first and last point": ("a.itx", igor("m", "/I", DX * (NX - 1), DY * (NY - 1)), {}),
    "Igor, first point and end": ("a.itx", igor("m", "", DX * NX, DY * NY), {}),
    "ESRI": ("a.asc", esri() + lines(without(Z).T[::-1], " ", missing="-9999"), GIVEN),
    "ESRI without its value": ("a.asc", esri("") + lines(without(Z).T[::-1], " ", missing="-9999"), GIVEN),
    "ESRI, centres": ("a.asc", esri(corner="center") + lines(DOWN, " "), GIVEN),
    "GRASS": ("a.asc", grass() + lines(without(Z).T[::-1], " ", missing="*"), GIVEN),
    "GRASS, null": ("a.asc", grass("null: -1\n") + lines(without(Z).T[::-1], " ", missing="-1"), GIVEN),
    "GRASS, multiplier": ("a.asc", grass("multiplier: 0.5\n") + lines(2.0 * DOWN, " "), GIVEN),
    "Surfer": ("a.grd", surfer(), GIVEN),
    "Surfer, points": ("a.dat", '"X","Y","Z"\n' + points(separator=","), GIVEN),
    "SDF": ("a.sdf", sdf(), {}),
    "SDF, integers": ("a.sdf", sdf(kind=6, scale=1e-10), {}),
    "SDF, revision 2": ("a.sdf", sdf("aISO-2.0"), {}),
    "BCR": ("a.sdf", sdf("aBCR-1.0"), {}),
    "Wyko": ("a.asc", wyko(), {}),
    "Wyko, wavelengths": ("a.asc", wyko(in_nanometres=False), {}),
    "Keyence": ("a.csv", keyence(), SQUARE),
    "Keyence, unquoted": ("a.csv", keyence("{:.4f}"), SQUARE),
    "Keyence in German": ("a.csv", KEYENCE_GERMAN, SQUARE),
    "Alicona, points": ("a.txt", points(separator=" ", scale=1e-6, values=Z * 1e-6, form="{:.10f}"), {"size": SIZE}),
    "Sensofar, points": ("a.dat", points(separator=" ", missing="***", values=without(Z)), GIVEN),
    "Mountains, points with units": ("a.txt", "X (µm);Y (µm);Z (µm)\n" + points(separator=";"), {}),
    "Mountains, decimal commas": ("a.txt", "X (µm);Y (µm);Z (µm)\n" + points(separator=";").replace(".", ","), {}),
    "points in other units": ("a.csv", "x [mm],y [mm],z [nm]\n" + points(1e3 * Z, ",", "{:.6f}", scale=1e-3), {}),
    "points y x z": ("a.csv", "y,x,z\n" + points(separator=",", order="yxz"), GIVEN),
    "points with an intensity": (
        "a.csv",
        "x,y,z,intensity\n" + points(separator=",", more={"i": np.round(100 + 50 * Y)}),
        GIVEN,
    ),
    "points with an index": (
        "a.csv",
        ",x,y,z\n" + "".join(f"{k},{line}\n" for k, line in enumerate(points(separator=",").splitlines())),
        GIVEN,
    ),
    "points of gnuplot": (
        "a.xyz",
        "".join(
            line + ("\n\n" if (k + 1) % NX == 0 else "\n") for k, line in enumerate(points(separator=" ").splitlines())
        ),
        GIVEN,
    ),
    "CloudCompare": ("a.xyz", "//X Y Z\n" + points(separator=" "), GIVEN),
    "Talymap, a title of heights": ("a.txt", "Z (µm)\n" + lines(UP), {"size": SIZE, "rows": "y"}),
    "Matlab": ("a.txt", lines(Z, "", "  {:.7e}"), GIVEN),
    "Matlab, writematrix": ("a.csv", lines(without(Z), ",", missing="NaN"), GIVEN),
    "Octave": (
        "a.txt",
        "# Created by Octave 9.2\n# name: z\n# type: matrix\n# rows: 24\n# columns: 37\n" + lines(Z, " "),
        GIVEN | {"rows": "x"},
    ),
    "numpy": ("a.txt", savetxt(), GIVEN),
    "numpy, commas": ("a.csv", savetxt(delimiter=",", fmt="%.4f"), GIVEN),
    "numpy, header": ("a.csv", savetxt(delimiter=",", header="heights of a plate"), GIVEN),
    "numpy, rows of y": ("a.txt", lines(UP), GIVEN | {"rows": "y"}),
    "pandas": ("a.csv", lambda: pandas_csv(header=False, index=False), GIVEN),
    "pandas, decimal commas": ("a.csv", lambda: pandas_csv(header=False, index=False, decimal=","), GIVEN),
    "pandas, semicolons": ("a.csv", lambda: pandas_csv(header=False, index=False, decimal=",", sep=";"), GIVEN),
    "pandas, tabs": ("a.tsv", lambda: pandas_csv(header=False, index=False, sep="\t"), GIVEN),
    "pandas, quoted": ("a.csv", lambda: pandas_csv(header=False, index=False, quoting=1), GIVEN),
    "Excel in German": ("a.csv", lines(Z, ";", decimal=",").replace("\n", "\r\n"), GIVEN),
    "Excel in English": ("a.csv", "\ufeff" + lines(Z, ",").replace("\n", "\r\n"), GIVEN),
    "Excel, Unicode text": ("a.txt", lines(Z).replace("\n", "\r\n").encode("utf-16"), GIVEN),
    "Excel, empty fields": ("a.csv", lines(without(Z), ";", decimal=",", missing=""), GIVEN),
    "Excel, an old Mac": ("a.txt", lines(Z).replace("\n", "\r"), GIVEN),
    "Origin": ("a.txt", origin(), GIVEN),
    "R": ("a.txt", r_table(names=False), GIVEN),
    "Fortran": ("a.dat", lines(Z, "  ", "{:.6E}").replace("E", "D"), GIVEN),
    "Fortran, fixed": ("a.prn", lines(Z, "", "{:11.4f}"), GIVEN),
    "C of Windows": ("a.txt", lines(without(Z), missing="-1.#IND"), GIVEN),
    "Mountains, names of several words": ("a.csv", TITLED.format("X position (mm),Y position (mm),Height (um)"), {}),
    "points with names behind words": ("a.csv", TITLED.format("Pos X [mm],Distance Y [mm],Höhe [µm]"), {}),
    "a unit alone": ("a.txt", "[nm]\n" + lines(1e3 * Z), {"size": SIZE}),
    "a title with its unit": ("a.txt", "height_nm\n" + lines(1e3 * Z), {"size": SIZE}),
    "a title in French": ("a.txt", "Altitudes en nm\n" + lines(1e3 * Z), {"size": SIZE}),
    "points with units below the names": ("a.csv", TITLED.format("X,Y,Z\nmm,mm,um"), {}),
    "points with units in brackets": ("a.csv", TITLED.format("X,Y,Z\n[mm],[mm],[um]"), {}),
    "Tecplot": ("a.dat", TITLED.format('VARIABLES = "X [mm]", "Y [mm]", "Z [um]"\nZONE I=24, J=37, F=POINT'), {}),
    "COMSOL": ("a.txt", "% Length unit: um\n% x y h (um)\n" + points(separator=" "), {}),
    "items of one line": ("a.txt", "# dx = 2 um, dy = 3 um, zunit = um\n" + lines(Z), {"rows": "x"}),
    "items of JSON": ("a.txt", '# {"dx": "2 um", "dy": "3 um", "zunit": "nm"}\n' + lines(1e3 * Z), {"rows": "x"}),
    "steps and sides that fit one order": (
        "a.txt",
        f"X size: {NX * DX} um\nY size: {NY * DY} um\nStep X: {DX} um\nStep Y: {DY} um\nZ unit: um\n" + lines(UP),
        {},
    ),
    "MATLAB, shown": ("a.txt", "z =\n\n   1.0e-06 *\n\n" + lines(Z, "", "{:12.4f}"), {"size": SIZE}),
    "Wyko, as CSV": ("a.csv", wyko().replace("\t", ","), {}),
    "Excel, errors": ("a.csv", lines(without(Z), ",", missing="#N/A"), GIVEN),
    "Excel, errors in German": ("a.csv", lines(without(Z), ";", missing="#NV", decimal=","), GIVEN),
    "microinches": ("a.csv", "Height (µin)\n" + lines(Z / 0.0254, ",", "{:.8f}"), {"size": SIZE}),
    "WSxM, a matrix": (
        "a.txt",
        f"WSxM file copyright UAM\nWSxM ASCII Matrix file\nX Amplitude: {NX * DX:g} um\nY Amplitude: {NY * DY:g} um\n"
        f"Z Amplitude: {np.ptp(Z):.2f} um\n\n[Header end]\n{lines(DOWN)}",
        {},
    ),
    "AFM Workshop": (
        "a.txt",
        f"Pixels in X: {NX}\nLines in Y: {NY}\nX Range: {NX * DX:g} um\nY Range: {NY * DY:g} um\n"
        f"Max Z: {Z.max():.4f} um\nStart of Data:\n{lines(DOWN)}",
        {},
    ),
    "the largest height in nanometres": (
        "a.txt",
        f"Max height: {1e3 * Z.max():.1f} nm\n" + lines(1e3 * Z),
        {"size": SIZE},
    ),
    "Shimadzu": (
        "a.txt",
        f"SHIMADZU SPM File Format Version 2.00\nPixelX {NX}\nPixelY {NY}\nScanSizeX {NX * DX:g} um\n"
        f"ScanSizeY {NY * DY:g} um\nZUnit um\nDATA\n{lines(DOWN)}",
        {},
    ),
    "Nanosurf": (
        "a.csv",
        f"XDim: {NX * DX:g}um YDim: {NY * DY:g}um\nPoints: {NX} Lines: {NY}\nZ unit: um\n{lines(UP, ';')}",
        {"rows": "y"},
    ),
    "Keyence VR": (
        "a.csv",
        f'"Image width","{NX}"\n"Image height","{NY}"\n"XY Pitch","0.002","mm"\n"Unit","mm"\n"Height"\n'
        + lines(1e-3 * DOWN, ",", "{:.7f}"),
        SQUARE,
    ),
    "Keyence VK, not quoted": (
        "a.csv",
        f"XY calibration,2000.000,nm\nOutput image data,Height\nHorizontal,{NX}\nVertical,{NY}\nUnit,um\nHeight\n"
        + lines(DOWN, ","),
        SQUARE,
    ),
    "Olympus": (
        "a.csv",
        f"Width,{NX},pixel\nHeight,{NY},pixel\nPixel size,2.0,um\nZ unit,um\nDATA\n" + lines(DOWN, ","),
        SQUARE,
    ),
    "sides with their numbers of points": (
        "a.txt",
        f"X axis: {NX * DX:g} µm, {NX} points\nY axis: {NY * DY:g} µm, {NY} points\nZ unit: µm\n{lines(UP)}",
        {},
    ),
    "Vision, as CSV": (
        "a.csv",
        f"X Size,{NX}\nY Size,{NY}\nPixel_size,0.002,mm\nUnits,mm\n" + lines(1e-3 * UP, ",", "{:.7f}"),
        SQUARE,
    ),
    "ESRI, decimal commas": (
        "a.asc",
        f"ncols {NX}\nnrows {NY}\nxllcorner 0,0\nyllcorner 0,5\ncellsize 2,0\n" + lines(DOWN, " ", decimal=","),
        SQUARE | {"unit": "um"},
    ),
    "a mark of Fortran": ("a.txt", "! unit: nm\n" + lines(1e3 * Z), {"size": SIZE}),
    "a German title in Latin-1": (
        "a.txt",
        TITLED.format("X [mm];Y [mm];Höhe [µm]").encode("latin-1"),
        {},
    ),
    "points in inches": (
        "a.csv",
        "x_inch,y_inch,z_microinch\n" + points(Z / 0.0254, ",", "{:.12f}", scale=1 / 25400.0),
        {},
    ),
    "points with both letters for micro": (
        "a.csv",
        "x [\u03bcm],y [\u00b5m],z [\u03bcm]\n" + points(separator=","),
        {},
    ),
    "thousands of angstroms": ("a.csv", "x (µm),y (µm),z (kÅ)\n" + points(10.0 * Z, ","), {}),
    "UTF-16 without a mark": ("a.txt", lines(Z).encode("utf-16-be"), GIVEN),
    "minus signs of typography": ("a.txt", lines(Z, form="{:.4E}").replace("-", "\u2212"), GIVEN),
    "units in one line": (
        "a.txt",
        "Units: x=mm, y=mm, z=um\n" + points(scale=1e-3, form="{:.6f}"),
        {},
    ),
    "front matter": ("a.csv", "---\nunits: {x: um, y: um, z: nm}\npitch: [2, 3]\n---\n" + lines(1e3 * Z, ","), {}),
    "a pair of sides": ("a.txt", f"Scan size: {NX * DX:g} µm x {NY * DY:g} µm\nz unit: µm\n" + lines(Z), {}),
    "a pair of numbers of points": (
        "a.txt",
        f"Size: {NX} x {NY} pixels\nPixel size: 2 um, 3 um\nz unit: um\n" + lines(UP),
        {},
    ),
    "units behind the names of keys": (
        "a.txt",
        "Pixel pitch X [µm]: 2\nPixel pitch Y [µm]: 3\nHeight unit [nm]\n" + lines(1e3 * Z),
        {},
    ),
    "a row of units": (
        "a.txt",
        "Units" + NY * "\tum" + "\n" + lines(Z),
        {"size": SIZE},
    ),
    "a value of bad pixels": ("a.txt", "# bad pixel value = -1\n" + lines(without(Z), missing="-1"), GIVEN),
    "a value of invalid data": ("a.txt", "Invalid data value: 9999\n" + lines(without(Z), missing="9999"), GIVEN),
    "a missing value in German": ("a.csv", "# Fehlwert: -99,5\n" + lines(without(Z), ";", missing="-99.5"), GIVEN),
    "bad pixels in a sentence": (
        "a.txt",
        "# invalid pixels are set to 0.\n" + lines(without(Z), missing="0"),
        GIVEN,
    ),
    "a pair of distances": ("a.txt", "Sampling distance: 2 µm x 3 µm\nz-unit: µm\n" + lines(Z), {}),
    "a unit with a factor": ("a.txt", "# values in units of 10 nm\n" + lines(100.0 * Z), {"size": SIZE}),
    "a title in Japanese": ("a.csv", "高さ(nm)\n" + lines(1e3 * Z, ","), {"size": SIZE}),
    "a unit in Chinese": ("a.csv", "单位：纳米\n" + lines(1e3 * Z, ","), {"size": SIZE}),
    "a unit in Russian": ("a.txt", "# Единицы: нм\n" + lines(1e3 * Z), {"size": SIZE}),
    "Park, as CSV": (
        "a.csv",
        f"Unit,nm\nPixel Width,{NX}\nPixel Height,{NY}\nScan Width (um),{NX * DX}\nScan Height (um),{NY * DY}\n"
        + lines(1e3 * DOWN, ","),
        {},
    ),
    "a title with a given unit": ("a.txt", "Topography - nm\n" + lines(Z), GIVEN),
    "units behind keys": (
        "a.txt",
        "[Header]\nX_Spacing_mm=0.002\nY_Spacing_mm=0.003\nZ_Unit=um\n[Data]\n" + lines(Z),
        {},
    ),
    "Mahr": (
        "a.csv",
        f"Messpunkte in X;{NX}\nMesspunkte in Y;{NY}\nAbstand X [mm];0,002\nAbstand Y [mm];0,003\nHöhe [µm]\n"
        + lines(UP, ";", decimal=","),
        {},
    ),
    "points with German names": ("a.csv", TITLED.format("X-Koordinate [mm];Y-Koordinate [mm];Z-Wert [µm]"), {}),
    "points with joint names": (
        "a.csv",
        "PosX[um],PosY[um],Height[nm]\n" + points(1e3 * Z, ","),
        {},
    ),
    "one distance that agrees": ("a.txt", "# dx = 2 um\n" + lines(Z), GIVEN),
    "compressed": ("a.csv.gz", gzip.compress(lines(Z, ",").encode()), GIVEN),
    "compressed, Gwyddion": ("a.txt.gz", gzip.compress((gwyddion() + lines(DOWN)).encode()), {}),
}
# And a part of the sentence with which it is refused.
REFUSED = {
    "Gwyddion, a phase": ("a.txt", gwyddion("Phase", unit="deg") + lines(DOWN), {}, "values in 'deg'"),
    "Gwyddion, two channels": ("a.txt", DOUBLE, {}, "stands between its numbers"),
    "SPIP, volts": ("a.asc", spip("z-unit = V") + lines(DOWN), {}, "values in 'V'"),
    "a channel of currents": ("a.txt", "# Channel: Current\n" + lines(DOWN), GIVEN, "'# Channel: Current', which"),
    "a calibration of one": ("a.txt", "Height calibration = 1 nm/V\n" + lines(Z), GIVEN, "'Height calibration = 1 nm"),
    "void pixels": ("a.txt", "# void pixels: 3\n" + lines(Z), GIVEN, "'# void pixels: 3', which changes"),
    "two unlike sides": ("a.txt", "# x size: 5 um\n# x size: 6 um\n" + lines(Z), GIVEN, "contradict each other"),
    "SPIP, two units": ("a.asc", spip("z-unit = um", "Bit2nm = 0.5") + lines(DOWN), {}, "'# Bit2nm = 0.5'"),
    "Attocube, volts": ("a.asc", attocube("V") + lines(DOWN), {}, "values in 'V'"),
    "NanoScope, one column": ("a.txt", "Height(nm)\n" + lines(UP, "\n"), GIVEN, "stand in one column"),
    "WSxM, amperes": ("a.txt", wsxm("A.U.") + points(), {}, "values in 'A.U.'"),
    "WSxM, binary": (
        "a.stp",
        b"WSxM file copyright Nanotec Electronica\r\nSxM Image file\r\nImage header size: 1000\r\n" + bytes(range(256)),
        {},
        "",
    ),
    "Igor, amperes": ("a.itx", igor("A"), {}, "values in 'A'"),
    "Zygo, unequal cells": ("a.asc", zygo_phase(), {"size": SIZE}, "states its own size"),
    "Zygo, points without a unit": ("a.xyz", zygo_points(), {}, "numbers without a unit"),
    "a scale that is not understood": ("a.txt", "# z-scale: 0.5\n" + lines(Z), GIVEN, "'# z-scale: 0.5'"),
    "a calibration": ("a.txt", "Height calibration = 12.5 nm/V\n" + lines(Z), GIVEN, "'Height calibration = 12.5"),
    "an offset": ("a.txt", "# offset: 3.5\n" + lines(Z), GIVEN, "'# offset: 3.5'"),
    "counts above a title": ("a.txt", f"{NX}\t{NY}\t2.0\nZ-data (um)\n" + lines(UP), GIVEN, "skip_rows=2"),
    "a footer": ("a.txt", lines(Z) + "Mean\t0.1\n", GIVEN, "24 rows of numbers stand above it"),
    "pandas with header and index": ("a.csv", lambda: pandas_csv(), GIVEN, "count, as header and index of pandas do"),
    "pandas with an index": ("a.csv", lambda: pandas_csv(header=False), GIVEN, "count, as header and index of pandas"),
    "pandas with a header": ("a.csv", lambda: pandas_csv(index=False), GIVEN, "count, as header and index of pandas"),
    "R with names": ("a.txt", r_table(names=True), GIVEN, "its first column count"),
    "a table with positions": (
        "a.csv",
        "y\\x,"
        + ",".join(f"{x:g}" for x in X[:, 0])
        + "\n"
        + "".join(f"{y:g},{line}\n" for y, line in zip(Y[0], lines(UP, ",").splitlines(), strict=True)),
        GIVEN | {"rows": "y"},
        "",
    ),
    "positions rounded": (
        "a.txt",
        "\t".join(f"{0.137 * k:.2f}" for k in range(NX)) + "\n" + lines(UP),
        GIVEN,
        "equal steps",
    ),
    "points, sides exchanged": ("a.xyz", points(), GIVEN | {"size": SIZE[::-1]}, "apart along x and y"),
    "points with a nameless column": ("a.csv", points(separator=",", more={"i": Y * 0.1}), GIVEN, "name them above"),
    "points that are scattered": ("a.xyz", points(by="x").replace("2.0000\t", "2.4000\t", 9), GIVEN, "regular grid"),
    "a profile": ("a.txt", lines(np.column_stack((X[:, 0], Z[:, 0]))), GIVEN, "points x z of a profile"),
    "thousands": ("a.txt", lines(np.round(1e3 * Z), "\t", "{:,.0f}"), GIVEN, "may separate thousands"),
    "-9999 without a header": ("a.txt", lines(without(Z), missing="-9999"), GIVEN, "no_data=-9999"),
    "-32768 without a header": ("a.txt", lines(without(Z), missing="-32768"), GIVEN, "no_data=-32768"),
    "1e30 without a header": ("a.txt", lines(without(Z), missing="1e30"), GIVEN, "no_data=1e+30"),
    "0 without a header": ("a.txt", lines(without(Z + 90.0), missing="0"), GIVEN, "no_data=0"),
    "two tables with a blank line": ("a.txt", lines(Z) + "\n" + lines(2.0 * Z), GIVEN, "blank line"),
    "-10000 without a header": ("a.txt", lines(without(Z), missing="-10000"), GIVEN, "no_data=-10000"),
    "steps of integers": ("a.txt", "# height resolution = 1 nm/digit\n" + lines(Z), GIVEN, "1 nm/digit"),
    "counts of integers": ("a.txt", "# 1 count = 2 nm\n" + lines(Z), GIVEN, "# 1 count = 2 nm"),
    "a factor in words": ("a.txt", "# values x 1000\n" + lines(Z), GIVEN, "# values x 1000"),
    "depths": ("a.txt", "Depth (um)\n" + lines(-Z), GIVEN, "'Depth (um)', which changes"),
    "depths of points": ("a.csv", "x,y,depth\n" + points(-Z, ","), GIVEN, "its third column is a depth"),
    "a unit in another encoding": (
        "a.txt",
        "# 値の単位: um\n".encode("shift-jis") + lines(Z).encode(),
        GIVEN,
        "which changes",
    ),
    "a unit of an unknown name": ("a.txt", "# Jednostka: nm\n" + lines(Z), GIVEN, "'# Jednostka: nm', which changes"),
    "rows and columns, and lengths": (
        "a.txt",
        f"#rows {NY}\n#columns {NX}\n#x pitch: 2 um\n#y pitch: 3 um\n" + lines(UP),
        {"unit": "um"},
        "say it with rows='y', or rows='x'",
    ),
    "a largest height that is another": (
        "a.txt",
        "Max Z: 9 um\n" + lines(Z),
        {"size": SIZE},
        "'largest height 9 \\xb5m', which may",
    ),
    "turned over": ("a.txt", "# inverted: yes\n# unit: um\n" + lines(-Z), {"size": SIZE}, "'# inverted: yes', which"),
    "micrometres in Japanese": (
        "a.csv",
        ('"単位","um"\r\n"高さ"\r\n' + lines(Z, ",")).encode("cp932"),
        {"size": SIZE},
        "which changes what its numbers mean",
    ),
    "Tecplot, a block": (
        "a.dat",
        'VARIABLES = "X", "Y", "Z"\nZONE I=24, J=37, F=BLOCK\n'
        + lines(np.array([X.T.ravel(), Y.T.ravel(), Z.T.ravel()]), " "),
        GIVEN,
        "names 3 columns, but its rows hold 888",
    ),
    "VTK": ("a.txt", "# vtk DataFile Version 3.0\nheights\nASCII\nSPACING 2 3 1\n" + lines(UP), GIVEN, "data of VTK"),
    "ZMAP+": ("a.dat", f"! file\n@a, GRID, 5\n15, 1e30, , 4, 1\n@\n{lines(Z, ' ')}", GIVEN, "a grid of ZMAP+"),
    "CPS-3": ("a.txt", "FSASCI 0 1 COMPUTED 0 1e30 0\n" + lines(Z, " "), GIVEN, "a grid of CPS-3"),
    "Irap": (
        "a.txt",
        f"-996 {NY} 2.0 3.0\n0.0 46.0 0.0 108.0\n{NX} 0.0 0.0 0.0\n0 0 0 0 0 0 0\n" + lines(UP, " "),
        GIVEN,
        "a grid of Irap",
    ),
    "GXF": ("a.txt", f"#POINTS\n{NX}\n#ROWS\n{NY}\n#GRID\n" + lines(UP, " "), GIVEN, "Grid eXchange Format"),
    "ArcInfo": ("a.e00", "EXP  0 A.E00\nGRD  2\n" + lines(UP, " "), GIVEN, "interchange format of ArcInfo"),
    "JSON": ("a.json", '{"z": [[0.1, 0.2], [0.3, 0.4]]}', GIVEN, "a text in JSON"),
    "Mathematica": ("a.txt", "{{0.1, 0.2}, {0.3, 0.4}}", GIVEN, "a list of Mathematica"),
    "SMD": ("a.smd", "1 2 T 1.0\r\nCX A 9 MM 1.0 I 2e-3\r\nEOR\r\n1.0\r\n", GIVEN, "ISO 5436-2 (SMD)"),
    "OBJ": ("a.txt", "v 0 0 1\nv 1 0 1\nv 0 1 2\n", GIVEN, "a mesh in OBJ"),
    "thousands by marks": (
        "a.csv",
        "x;y;z\n" + lines(np.stack((1e3 * X, 1e3 * Y, Z), axis=-1).reshape(-1, 3), ";", "{:,.0f}").replace(",", "'"),
        GIVEN,
        "without separators of thousands",
    ),
    "a vertical exaggeration": (
        "a.txt",
        "Vertical exaggeration: 10\n" + lines(Z),
        GIVEN,
        "'Vertical exaggeration: 10'",
    ),
    "counts in a sentence": ("a.txt", "# z = counts * 2.5 nm\n" + lines(Z), GIVEN, "'# z = counts * 2.5 nm'"),
    "a factor behind a word": ("a.txt", "% heights*1e6\n" + lines(Z), GIVEN, "'% heights*1e6'"),
    "names of all columns but the first": (
        "a.csv",
        "".join(f",y={y:g}" for y in Y[0]) + "\n" + lines(np.column_stack((X[:, 0], Z)), ","),
        GIVEN,
        "names all columns but the first",
    ),
    "a title that may name the unit": (
        "a.txt",
        "Topography - nm\n" + lines(Z),
        {"size": SIZE},
        "'Topography - nm', which may be the unit",
    ),
    "names with units behind commas": (
        "a.txt",
        "X, um\tY, um\tZ, nm\n" + points(),
        {"size": SIZE},
        "which may be the unit of its heights: give unit=",
    ),
    "Asylum": (
        "a.txt",
        f"ScanPoints: {NX}\nScanLines: {NY}\nFastScanSize: 48e-6\nSlowScanSize: 111e-6\nHeight [um]\n" + lines(UP),
        {"size": SIZE},
        "say it with rows='y'",
    ),
    "points at rows and columns": (
        "a.csv",
        "row,col,z\n" + points(separator=","),
        GIVEN,
        "places that are not x and y",
    ),
    "points with two heights": (
        "a.csv",
        "x,y,z before,z after\n" + points(separator=",", more={"i": Y * 0.1}),
        GIVEN,
        "name them above",
    ),
    "PGM": ("a.txt", "P2\n24 37\n255\n" + lines(UP, " ", "{:.0f}"), GIVEN, "a picture (PGM)"),
    "PFM": ("a.pfm", b"Pf\n24 37\n-1.0\n" + UP.astype("<f4").tobytes(), GIVEN, "a picture (PFM)"),
    "DXF": ("a.dxf", "0\nSECTION\n2\nENTITIES\n", GIVEN, "a drawing in DXF"),
    "one distance that does not agree": ("a.txt", "# dx = 5 um\n" + lines(Z), GIVEN, "are 5 µm apart along x, but on"),
    "invalid points in German": ("a.csv", "# Ungültig: -99.99\n" + lines(Z, ";"), GIVEN, "-99.99', which changes"),
    "Wyko, cut": ("a.asc", wyko()[:150], {}, "it begins as 'Wyko ASCII Data File Format 0"),
    "sides in landscape": ("a.txt", gwyddion().replace("µm", "km", 2) + lines(DOWN), {}, "size"),
    "metres by mistake": ("a.txt", gwyddion().replace("µm", "m", 2) + lines(DOWN), {}, "more than 1 m"),
}


@pytest.fixture
def write(tmp_path):
    def write_file(name, content):
        content = content() if callable(content) else content
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode("utf-8"))
        return path

    return write_file


@pytest.mark.parametrize("kind", READ)
def test_is_read_right(write, kind):
    name, content, options = READ[kind]
    found = rc.read_surface(write(name, content), non_measured="keep", **options)
    assert found.grid.shape == (NX, NY)
    assert found.grid.size == pytest.approx(options.get("size", SIZE))
    heights = np.asarray(found)
    assert np.isnan(heights).sum() in (0, MISSING.sum())
    assert not np.isnan(heights[~MISSING]).any()
    expected = np.where(np.isnan(heights), np.nan, Z * 1e-6)
    np.testing.assert_allclose(heights, expected, rtol=0, atol=1.01e-10)


HARMLESS = """Operator: A. B.|Date: 2026-01-02 10:11:12|Objective: 50x NA 0.8|Zoom: 1.0|Scale bar: 10 µm|Z range: 10 µm
Light intensity: 50 %|Scan speed = 1.2 Hz|Wavelength: 633 nm|Tip radius: 10 nm|Filter: 0.8 mm Gaussian|Sq = 12 nm
Sa [µm]: 0.3|Sample: disc 3, 10 mm|Grid: 3 x 3|Version 3.2|Stage X: 12.3 mm|X position: 12.3 mm|Z position: 4.5 mm
File: C:\\data\\nm\\a.nms|Rotation: 0 deg|Feedback gain: 0.3|Sensitivity deflection: 45 nm/V|Material: steel 100Cr6
Ra: 0.4|Invalid points: 0|Missing data: 0 %|Filter: none|Form removed: plane|Resolution: 0.3 nm (vertical)
Threshold: 5 %|Batch: 7/12|Height above stage: 4 mm|Pixel depth: 16 bit|Units of length: SI|Lay: 90 deg|Force (mN): 0.7
Traverse length: 4 mm|Date of calibration: 3.4.2026|Calibration: valid|Z scanner: 10 um|Samples: 7"""


def test_what_changes_no_number_is_passed_over(write):
    header = "".join(f"# {line}\n" for line in HARMLESS.replace("\n", "|").split("|"))
    found = rc.read_surface(write("a.txt", header + lines(Z)), **GIVEN)
    np.testing.assert_allclose(found.values, Z * 1e-6, rtol=0, atol=1.01e-10)


@pytest.mark.parametrize("kind", REFUSED)
def test_is_refused_in_words_that_help(write, kind):
    name, content, options, words = REFUSED[kind]
    with pytest.raises((rc.InputError, rc.errors.MissingPackage)) as caught:
        rc.read_surface(write(name, content), **{"non_measured": "keep"} | options)
    assert words in str(caught.value)


def test_the_phase_of_zygo_is_heights(write):
    found = rc.read_surface(write("a.asc", zygo_phase()), non_measured="keep")
    assert found.size == pytest.approx((NX * 2e-6, NY * 2e-6))
    np.testing.assert_allclose(np.asarray(found), np.where(MISSING, np.nan, Z * 1e-6), atol=1e-11)


def test_the_points_of_zygo_have_the_unit_of_a_setting(write):
    found = rc.read_surface(write("a.xyz", zygo_points()), unit="um", non_measured="keep")
    assert found.size == pytest.approx((NX * 2e-6, NY * 2e-6))
    np.testing.assert_allclose(np.asarray(found), np.where(MISSING, np.nan, Z * 1e-6), atol=1e-16)


@pytest.mark.parametrize("mark", ["-9999", "-32768", "1e30", "0"])
def test_a_number_of_non_measured_points_is_given(write, mark):
    path = write("a.txt", lines(without(Z + 90.0), missing=mark))
    found = rc.read_surface(path, **GIVEN, no_data=float(mark), non_measured="keep")
    np.testing.assert_array_equal(found.non_measured, MISSING)
    kept = rc.read_surface(path, **GIVEN, no_data="none")
    assert kept.non_measured is None
    with pytest.raises(rc.InputError, match="The number of non-measured points in a file"):
        rc.read_surface(path, **GIVEN, no_data="all")


def test_heights_that_only_look_so_are_not_asked_about(write):
    # A plane with dimples, steps, and one low point.
    for values in (np.where(Z > 1.5, 0.0, -Z), np.where(Z > 1.5, 5.0, 1.0), np.where(X + Y == 0, -3.0, Z)):
        rc.read_surface(write("a.txt", lines(values)), **GIVEN)
