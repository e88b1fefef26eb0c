"""How often `rc.beyond_resolution` holds the area of the surface that a coarse map was taken from.

    python docs/studies/beyond_resolution.py [number of surfaces]

Prints the table of docs/use/maps.md. Each surface is self-affine with its own Hurst exponent, load, lay and shortest
wave, which is between one and half a cell of its map; the map holds the heights at points, or their means over cells.
The seeds are not those with which the method was developed.
"""

from __future__ import annotations

import sys

import numpy as np

import roughcontact as rc

CELLS, FINE = 64, 8  # cells of a map a side, and cells of the surface in one of the map
FIRST = 9000  # the first seed; smaller ones were used in the development
STEEL = rc.Elastic(young=1.0, poisson=0.0)


def draw(seed: int) -> tuple[np.ndarray, float, float, bool]:
    """Return heights, the pressure, the shortest wave in cells of the map, and whether there is a lay."""
    rng = np.random.default_rng(seed)
    lay, shortest = bool(rng.random() < 0.3), float(2.0 ** rng.uniform(-1.0, 0.0))
    side = float(CELLS)
    surface = rc.SelfAffineSurface(
        hurst=float(rng.choice([0.3, 0.5, 0.8, 1.0])),
        rms_slope=0.1,
        longest=side,
        rolloff=float(rng.uniform(0.3, 0.6)) * side,
        shortest=shortest,
        peklenik=4.0 if lay else 1.0,
        lay=float(rng.uniform(0.0, np.pi)),
        seed=seed,
    )
    # Nominal pressures for about 2 to 20 % of contact.
    pressure = 0.1 * 10.0 ** rng.uniform(-2.0, -1.0)
    return surface.heights(rc.Grid((FINE * CELLS,) * 2, side)), pressure, shortest, lay


def sample(heights: np.ndarray, kind: str) -> np.ndarray:
    """Return the map of a surface."""
    if kind == "points":
        return heights[FINE // 2 :: FINE, FINE // 2 :: FINE]
    return heights.reshape(CELLS, FINE, CELLS, FINE).mean(axis=(1, 3))


def solve(heights: np.ndarray) -> rc.ContactProblem:
    """Return the problem of heights on a rigid flat."""
    body = rc.Body(rc.HeightMap(heights, size=float(CELLS), periodic=True), STEEL)
    return rc.ContactProblem(body, boundary="periodic")


def measure(seed: int, kind: str) -> tuple[float, bool, bool, float, bool]:
    """Return the error of the map's area, whether the range holds, also of the row of its wave, its width, the lay."""
    heights, pressure, shortest, lay = draw(seed)
    true = solve(heights).solve(pressure=pressure).area().value
    found = rc.beyond_resolution(solve(sample(heights, kind)), pressure=pressure, cutoffs=(1.0, shortest, 0.5))
    low, high = found.range
    row = int(np.argmin(np.abs(np.array(found.wavelengths) - shortest)))
    near = abs(true - found.means[row]) <= 2.0 * found.stds[row]
    return found.measured.value / true - 1.0, low <= true <= high, bool(near), (high - low) / true, lay


def main(count: int) -> None:
    """Print the table."""
    print("| map | surfaces | its own area | range holds | row of the true wave holds | width of the range |")
    print("|---|---|---|---|---|---|")
    for kind in ("points", "means"):
        found = [measure(FIRST + index, kind) for index in range(count)]
        errors, holds, near, width, _ = (np.array(column) for column in zip(*found, strict=True))
        name = {"points": "heights at points", "means": "means over cells"}[kind]
        error = f"{100 * np.median(errors):+.0f} % ({100 * errors.min():+.0f} to {100 * errors.max():+.0f})"
        rates = f"{100 * holds.mean():.0f} % | {100 * near.mean():.0f} % | {100 * np.median(width):.0f} %"
        print(f"| {name} | {count} | {error} | {rates} |", flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 40)
