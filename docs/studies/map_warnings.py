"""How often the warnings of measured maps are right, on synthetic maps with and without defects.

    python docs/studies/map_warnings.py [number of surfaces]

Prints the table of docs/use/maps.md. The thresholds were chosen on other seeds than the held-out ones. Maps of
160 x 160 cells, cropped from periodic surfaces with waves down to half a cell; heights at points or means over cells;
Hurst exponents 0.3, 0.5, 0.8 and 1; isotropic or with a lay 5:1 in any direction.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator

import numpy as np
from scipy import ndimage

import roughcontact as rc
from roughcontact._parts.surfaces.filling import fill

CELLS, FINE = 160, 4  # cells of a map a side, and cells of the surface in one of the map
TUNED, HELD_OUT = 1000, 2000  # first seeds
# How each warning begins.
WORDS = {
    "interpolation": "the map looks interpolated",
    "steps": "the heights of the map rise in steps",
    "filling": "about",
    "blur": "waves below",
    "noise": "the shortest waves of the map are mostly noise",
}


def draw(rng: np.random.Generator, shortest: float) -> np.ndarray:
    """Return a map with waves down to `shortest` cells."""
    side = 1.25 * CELLS
    surface = rc.SelfAffineSurface(
        hurst=float(rng.choice([0.3, 0.5, 0.8, 1.0])),
        rms_height=1.0,
        shortest=shortest,
        longest=side,
        rolloff=float(rng.uniform(0.3, 0.6)) * CELLS,
        peklenik=float(rng.choice([1.0, 5.0])),
        lay=float(rng.uniform(0.0, np.pi)),
        seed=int(rng.integers(2**31)),
    )
    cells = int(FINE * side)
    heights = surface.heights(rc.Grid((cells, cells), side))[: FINE * CELLS, : FINE * CELLS]
    if rng.random() < 0.5:
        return heights[FINE // 2 :: FINE, FINE // 2 :: FINE]
    return heights.reshape(CELLS, FINE, CELLS, FINE).mean(axis=(1, 3))


def resample(heights: np.ndarray, factor: int, method: str) -> np.ndarray:
    """Return part of a map on `factor` times as many cells."""
    count = CELLS // factor
    return rc.HeightMap(heights[:count, :count], size=1.0).resample((count * factor,) * 2, method).values


def honest(rng: np.random.Generator) -> Iterator[tuple[str, str, np.ndarray]]:
    """Yield the name of each kind of map without defects, the warning it should get, and the map."""
    heights = draw(rng, 0.5)
    rms, x = heights.std(), (np.arange(CELLS) - 0.5 * CELLS)[:, np.newaxis]
    level = np.quantile(heights, 0.8)
    yield "rough", "", heights
    yield "rough, tilted", "", heights + rms * (0.3 * x - 0.1 * x.T)
    yield "ball, rough", "", heights - rms * (x**2 + x.T**2) / 400.0
    yield "run in", "", np.where(heights > level, level + 0.1 * (heights - level), heights)
    yield "computed, 8 cells on the shortest wave", "", draw(rng, 8.0)
    yield "rough, 5 % of the points non-measured", "", np.where(rng.random(heights.shape) < 0.05, np.nan, heights)


def spoiled(rng: np.random.Generator) -> Iterator[tuple[str, str, np.ndarray]]:
    """Yield the same of maps with defects."""
    heights = draw(rng, 0.5)
    rms, white = heights.std(), rng.standard_normal(heights.shape)
    for factor in (2, 3, 4):
        for method in ("bilinear", "cubic"):
            yield f"upsampled {factor} times, {method}", "interpolation", resample(heights, factor, method)
    for width in (0.7, 1.0, 1.5, 2.0):
        # With the little noise that every instrument has.
        yield f"blurred by {width:g} cells", "blur", ndimage.gaussian_filter(heights, width) + 1e-4 * rms * white
    blurred = ndimage.gaussian_filter(heights, 1.5)
    yield "blurred by 1.5 cells, noise of 0.5 % of Sq", "blur", blurred + 0.005 * rms * white
    smooth = draw(rng, 8.0)
    for level in (0.01, 0.02, 0.05):
        yield f"8 cells on the shortest wave, noise of {100 * level:g} % of Sq", "noise", smooth + level * rms * white
        yield f"rough, noise of {100 * level:g} % of Sq", "noise", heights + level * rms * white
    for step in (0.02, 0.05, 0.1):
        yield f"steps of {step:g} Sq", "steps", np.rint(heights / (step * rms)) * step * rms
    mask = ndimage.gaussian_filter(white, 1.0)
    yield "5 % of the points filled", "filling", fill(np.where(mask > np.quantile(mask, 0.95), np.nan, heights))
    for shortest in (4.0, 6.0):
        cut = draw(rng, shortest)
        yield f"{shortest:g} cells on the shortest wave, noise of 0.9 % of Sq", "noise", cut + 0.009 * cut.std() * white


def measure(first: int, count: int) -> dict[str, tuple[str, float]]:
    """Return the warning that each kind of map should get, and the fraction of maps that get it (or any, if none)."""
    found: dict[str, tuple[str, list[bool]]] = {}
    for seed in range(first, first + count):
        for kinds in (honest, spoiled):
            for name, expected, heights in kinds(np.random.default_rng(seed)):
                warnings = rc.HeightMap(heights, size=1e-4).warnings
                begins = WORDS.get(expected, "")
                hit = any(text.startswith(begins) for text in warnings)
                found.setdefault(name, (expected, []))[1].append(hit)
    return {name: (expected, float(np.mean(hits))) for name, (expected, hits) in found.items()}


def main(count: int) -> None:
    """Print the table."""
    tuned, held_out = measure(TUNED, count), measure(HELD_OUT, count)
    print("| map | warning | seeds of the thresholds, % | held-out seeds, % |\n|---|---|---|---|")
    for name, (expected, rate) in held_out.items():
        print(f"| {name} | {expected or 'any: a false alarm'} | {100 * tuned[name][1]:.0f} | {100 * rate:.0f} |")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 50)
