"""Height maps that the package makes itself: small, synthetic, plausible, and the same on every machine."""

from __future__ import annotations

import contextlib
import math
import os
import zipfile
from pathlib import Path

import numpy as np

from roughcontact._base import checks
from roughcontact._base.archive import read_npz, replacing
from roughcontact._base.arrays import Array
from roughcontact._parts.grid import Grid
from roughcontact._parts.surfaces import HeightMap, SelfAffineSurface, fill
from roughcontact.errors import InputError
from roughcontact.errors.door import guarded

# Decimals of heights in m: a picometre, far below every roughness, hides the rounding of machines.
_HEIGHT_DECIMALS = 12
# Differences between the numbers of a file and of its example that are rounding, in m and in µm.
_FILE_TOLERANCES = {".npz": 2e-12, ".csv": 2e-6}
# Standard deviation of the logarithm of the depth of skewed surfaces: a skewness of about -1.
_LOG_DEPTH_STD = 0.33


@guarded
def ball() -> HeightMap:
    """Return a map of a bearing ball: 256 x 256 cells of 1 µm around its highest point.

    The ball has a radius of 5 mm. Its roughness is isotropic, Sq about 12 nm, Hurst exponent 0.8, waves of 8 µm and
    more with a roll-off at 40 µm. It is tilted by 0.5 mrad, as it may lie under an instrument.

    Examples
    --------
    >>> import roughcontact as rc
    >>> print(rc.examples.ball().grid.shape)
    (256, 256)
    """
    grid = Grid((256, 256), 256e-6)
    rough = _crop(
        SelfAffineSurface(hurst=0.8, rms_height=12e-9, shortest=8e-6, longest=80e-6, rolloff=40e-6, seed=7), grid
    )
    return _make(rough - (grid.x**2 + grid.y**2) / (2 * 5e-3) + 5e-4 * grid.x, grid, "the example of a bearing ball")


@guarded
def ground_ring() -> HeightMap:
    """Return a map of the ground raceway of a bearing's inner ring: 256 x 256 cells of 1 µm.

    The raceway is a cylinder of radius 15 mm around an axis along x. Grinding left a lay along y, around the ring: Sq
    about 150 nm, Hurst exponent 0.8, waves across the lay of 8 µm and more with a roll-off at 32 µm, five times as long
    along it. The map is tilted by about 0.5 mrad.

    Examples
    --------
    >>> import roughcontact as rc
    >>> ring = rc.examples.ground_ring().detrend("plane")  # what is pressed
    >>> print(f"Sq {1e9 * ring.separate(2).roughness.values.std():.0f} nm")
    Sq 153 nm
    """
    grid = Grid((256, 256), 256e-6)
    ground = SelfAffineSurface(
        hurst=0.8,
        rms_height=150e-9,
        shortest=8e-6,
        longest=64e-6,
        rolloff=32e-6,
        peklenik=5.0,
        lay=math.pi / 2,
        seed=3,
    )
    return _make(_crop(ground, grid) - grid.y**2 / (2 * 15e-3) + 1e-3 * grid.y, grid, "the example of a ground ring")


@guarded
def lapped_plate() -> HeightMap:
    """Return a map of a lapped plate: 128 x 128 cells of 0.5 µm.

    It is flat and isotropic, and lapping has left more deep valleys than high summits: Sq about 50 nm, skewness about
    -0.9, waves of 4 µm and more. The map is tilted by 2 mrad.

    Examples
    --------
    >>> import roughcontact as rc
    >>> plate = rc.examples.lapped_plate().detrend("plane")
    >>> print(f"Sq {1e9 * plate.values.std():.0f} nm")
    Sq 51 nm
    """
    grid = Grid((128, 128), 64e-6)
    lapped = SelfAffineSurface(hurst=0.8, rms_height=1.0, shortest=4e-6, longest=32e-6, rolloff=8e-6, seed=2)
    return _make(140e-9 * _deepen(lapped, grid) + 2e-3 * grid.x, grid, "the example of a lapped plate")


@guarded
def honed_liner() -> HeightMap:
    """Return a map of a honed cylinder liner with non-measured points: 256 x 192 cells of 2 µm.

    The bore, of radius 41 mm, has its axis along x. Two lays cross at 25 degrees to either side of y; valleys are
    deeper than summits are high: Sq about 0.24 µm, waves of two cells and more. As in optical measurements the bottoms
    of the deepest valleys, 1 % of the points, are not measured.

    Examples
    --------
    >>> import roughcontact as rc
    >>> liner = rc.examples.honed_liner()
    >>> print(f"{100 * liner.non_measured.mean():.0f} % are not measured")
    1 % are not measured
    """
    grid = Grid((256, 192), (512e-6, 384e-6))
    heights = grid.y**2 / (2 * 41e-3)
    for degrees, seed in ((65.0, 11), (115.0, 12)):
        honed = SelfAffineSurface(
            hurst=0.8,
            rms_height=1.0,
            shortest=4e-6,
            longest=120e-6,
            rolloff=60e-6,
            peklenik=4.0,
            lay=math.radians(degrees),
            seed=seed,
        )
        heights = heights + 0.5e-6 * _deepen(honed, grid)
    valleys = heights < np.quantile(heights, 0.01)
    return _make(np.where(valleys, np.nan, heights), grid, "the example of a honed liner")


@guarded
def write(folder: str | os.PathLike[str] = ".") -> tuple[Path, ...]:
    """Write the example maps to the files that the docs use, and return their paths.

    ``ball.npz``, ``ring.npz``, ``map.npz`` (the lapped plate) and ``liner.npz`` (the honed liner, NaN at non-measured
    points) hold `heights`, m, and `size`, m; ``map.csv`` the heights of ``map.npz`` in µm, one row for each x. Existing
    ones are not written again.

    Parameters
    ----------
    folder
        The folder; it is made if there is none.

    Raises
    ------
    InputError
        If a file of one of these names holds something else; then none is written.

    Examples
    --------
    >>> import tempfile
    >>> import roughcontact as rc
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     print(*(path.name for path in rc.examples.write(folder)))
    ball.npz ring.npz map.npz liner.npz map.csv
    """
    target = checks.path(folder, "The folder of the examples")
    target.mkdir(parents=True, exist_ok=True)
    maps = {"ball": ball(), "ring": ground_ring(), "map": lapped_plate(), "liner": honed_liner()}
    arrays = {
        target / f"{name}.npz": {"heights": _with_nan(surface), "size": np.array(surface.size)}
        for name, surface in maps.items()
    }
    table = target / "map.csv"
    arrays[table] = {"": 1e6 * maps["map"].values}
    missing = [path for path, content in arrays.items() if not _is_there(path, content)]
    for path in missing:
        with replacing(path) as partial, partial.open("wb") as file:
            if path == table:
                np.savetxt(file, arrays[path][""], fmt="%.6f", delimiter=",")
            else:
                np.savez_compressed(file, heights=arrays[path]["heights"], size=arrays[path]["size"])
    return tuple(arrays)


def _is_there(path: Path, content: dict[str, Array]) -> bool:
    """Return whether a file holds these arrays; `InputError` if it holds others."""
    if not path.exists():
        return False
    # A file that cannot be read holds something else.
    with contextlib.suppress(OSError, ValueError, zipfile.BadZipFile), path.open("rb") as file:
        found = {"": np.loadtxt(file, delimiter=",")} if path.suffix == ".csv" else read_npz(file, deflated=True)
        if found.keys() == content.keys() and all(
            np.shape(found[name]) == values.shape
            and np.allclose(found[name], values, rtol=0.0, atol=_FILE_TOLERANCES[path.suffix], equal_nan=True)
            for name, values in content.items()
        ):
            return True
    raise InputError(
        f"The file {str(path)!r} holds something else than the example of this name, and nothing was written: give "
        "another folder, such as write('maps') or the command 'roughcontact examples maps'."
    )


def _with_nan(surface: HeightMap) -> Array:
    return surface.values if surface.non_measured is None else np.where(surface.non_measured, np.nan, surface.values)


def _crop(surface: SelfAffineSurface, grid: Grid) -> Array:
    """Return the heights of a part of a surface twice as long, so that they do not repeat at the border."""
    return surface.heights(_double(grid))[: grid.shape[0], : grid.shape[1]]


def _double(grid: Grid) -> Grid:
    nx, ny = grid.shape
    lx, ly = grid.size
    return Grid((2 * nx, 2 * ny), (2 * lx, 2 * ly))


def _deepen(surface: SelfAffineSurface, grid: Grid) -> Array:
    """Return lognormal heights: valleys deeper than summits are high, without waves below the shortest."""
    whole = _double(grid)
    spectrum = np.fft.rfft2(-np.exp(-_LOG_DEPTH_STD * surface.heights(whole)))
    fx = np.fft.fftfreq(whole.shape[0], whole.spacing[0])
    fy = np.fft.rfftfreq(whole.shape[1], whole.spacing[1])
    spectrum[np.hypot(fx[:, None], fy) * surface.shortest > 1.0] = 0.0
    return np.fft.irfft2(spectrum, whole.shape)[: grid.shape[0], : grid.shape[1]]


def _make(heights: Array, grid: Grid, text: str) -> HeightMap:
    """Return the map of heights, NaN at non-measured points, which are filled as by `read_surface`."""
    rounded = np.asarray(np.round(heights - np.nanmean(heights), _HEIGHT_DECIMALS), dtype=np.float64)
    mask = np.isnan(rounded)
    return HeightMap(fill(rounded) if mask.any() else rounded, grid.size, non_measured=mask, history=(text,))
