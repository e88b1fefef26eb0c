"""How near the numbers of line scans are to those of the surface, and whether their uncertainties hold.

python docs/studies/doc_tables.py profiles writes the table of docs/use/profiles.md.
"""

from __future__ import annotations

import numpy as np
from doc_tables import DocTable, some_of

import roughcontact as rc

SURFACES = 200
COUNTS = (1, 5, 20)
SIDE = 768  # points of the surface a side
POINTS = 512  # of a line: 64 of the shortest waves, 4 or 8 of the longest
SHORTEST = 8.0
HEADING = [
    "surfaces",
    "lines",
    "Sdq: error, %",
    "Sdq: stated, %",
    "Sdq: within two, %",
    "Sq: error, %",
    "Sq: mean error, %",
    "Sq: stated, %",
    "Sq: within two, %",
]


def draw(seed: int, laid: bool) -> tuple[np.ndarray, float, float]:
    """Return the heights of a surface, with a lay in any direction or without, and its Sq and Sdq."""
    rng = np.random.default_rng(seed)
    longest = float(rng.choice([64.0, 128.0]))
    surface = rc.SelfAffineSurface(
        hurst=float(rng.choice([0.3, 0.5, 0.8, 1.0])),
        rms_height=1.0,
        shortest=SHORTEST,
        longest=longest,
        peklenik=float(rng.choice([2.0, 3.0, 6.0])) if laid else 1.0,
        lay=float(rng.uniform(0.0, np.pi)),
        seed=seed,
    )
    heights = surface.heights(rc.Grid((SIDE, SIDE), float(SIDE)))
    power = np.abs(np.fft.fft2(heights)) ** 2 / heights.size**2
    q = 2.0 * np.pi * np.fft.fftfreq(SIDE)
    return heights, 1.0, float(np.sqrt(np.sum(power * (q[:, np.newaxis] ** 2 + q**2))))


def measure(seed: int, laid: bool, count: int, surface: tuple[np.ndarray, float, float]) -> list[float]:
    """Return relative error and uncertainty of Sdq and Sq from so many lines, in each of two directions with a lay."""
    heights, rms_height, slope = surface
    apart = SIDE // count
    places = apart * np.arange(count) + np.random.default_rng(seed).integers(apart)
    along = heights[:POINTS, places].T
    if laid:
        found = rc.reference.profile(along, 1.0, across=heights[places, :POINTS])
    else:
        found = rc.reference.profile(along, 1.0, isotropic=True)
    pairs = ((found.Sdq, slope), (found.Sq, rms_height))
    return [number for one, true in pairs for number in (one.value / true - 1.0, one.uncertainty / true)]


def make_rows() -> list[list[str]]:
    """Return the lines of the table."""
    rows = [HEADING]
    for laid, name in ((False, "isotropic"), (True, "with a lay, two directions")):
        found: dict[int, list[list[float]]] = {count: [] for count in COUNTS}
        for seed in some_of(range(SURFACES), *range(3)):
            surface = draw(seed, laid)
            for count in COUNTS:
                found[count].append(measure(seed, laid, count, surface))
        for count, numbers in found.items():
            slope, slope_std, height, height_std = 100.0 * np.array(numbers).T
            cells = [f"{np.sqrt(np.mean(slope**2)):.1f}", f"{slope_std.mean():.1f}"]
            cells.append(f"{100.0 * np.mean(np.abs(slope) < 2.0 * slope_std):.0f}")
            cells += [f"{np.sqrt(np.mean(height**2)):.0f}", f"{height.mean():+.0f}", f"{height_std.mean():.0f}"]
            cells.append(f"{100.0 * np.mean(np.abs(height) < 2.0 * height_std):.0f}")
            rows.append([name, f"{count}", *cells])
    return rows


TABLES = {"profiles": DocTable(make_rows, seconds=120)}
