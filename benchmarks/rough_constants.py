"""Constants of rough contacts: Hertz's theory on each patch.

    python benchmarks/rough_constants.py [number of surfaces]

Solves self-affine surfaces of 32 cells a shortest wave at three loads and compares Hertz's areas with the traced ones;
prints each constant of `roughcontact._answers.areas.calibration` beside what is measured again.
"""

from __future__ import annotations

import sys

import numpy as np

import roughcontact as rc
from roughcontact._answers.areas import calibration
from roughcontact._answers.areas.edges import trace_edges
from roughcontact._answers.areas.hertz import hertz_areas

SURFACES = ((0.8, 1), (0.5, 2), (0.8, 3), (0.3, 4), (0.7, 5), (0.4, 6))  # Hurst exponents and seeds
WAVES, FINEST = 32, 1024
LOADS = (5e-4, 2.5e-3, 8e-3)  # mean pressure over the modulus: 1 to 18 % contact
RESOLVED = 150  # cells of a patch on the finest grid whose traced area counts as true


def press(hurst: float, seed: int, cells: int, load: float) -> rc.ContactSolution:
    """Return the contact of a band-limited surface, the same one on every grid."""
    surface = rc.SelfAffineSurface(hurst=hurst, rms_slope=0.1, shortest=1.0, longest=16.0, rolloff=8.0, seed=seed)
    known = rc.HeightMap(surface.heights(rc.Grid((128, 128), float(WAVES))), size=float(WAVES), periodic=True)
    body = rc.Body(known.resample((cells, cells), "fourier"), rc.Elastic(1.0, 0.0))
    return rc.ContactProblem(body, boundary="periodic").solve(pressure=load)


def compare_hertz(fine: rc.ContactSolution, true: np.ndarray) -> np.ndarray:
    """Return spread of the curvature, relative error, stated error and area of each resolved summit."""
    areas = hertz_areas(fine)
    spread = np.concatenate(([0.0], areas.summits.spread))
    chosen = np.flatnonzero(np.concatenate(([False], fine.patches.cells >= RESOLVED)) & np.isfinite(areas.error))
    error = areas.area[chosen] / true[chosen] - 1.0
    return np.stack((spread[chosen], error, areas.error[chosen], true[chosen]), axis=1)


def measure(count: int = 4) -> dict[str, float]:
    """Return what is measured on so many surfaces."""
    summits = []
    for hurst, seed in SURFACES[:count]:
        for load in LOADS:
            fine = press(hurst, seed, FINEST, load)
            summits.append(compare_hertz(fine, np.maximum(trace_edges(fine).refined, 0.0)))
    spread, error, stated, area = np.concatenate(summits).T
    found = {}
    for low, high in ((0.15, 0.3), (0.3, 0.4), (0.4, 0.6), (0.6, 0.8), (0.8, 1.2)):
        some = (spread >= low) & (spread < high)
        rms = np.sqrt(np.mean(error[some] ** 2))
        found[f"Hertz error at {low} to {high}"] = float(rms)
        found[f"stated at {low} to {high}"] = float(np.mean(stated[some]))
    for name, some in (("one summit", spread < 0.3), ("all", spread < np.inf)):
        found[f"HERTZ_COMMON_FRACTION, {name}"] = float(
            abs(np.sum((error * area)[some])) / np.sum((stated * area)[some])
        )
    return found


if __name__ == "__main__":
    for name, value in measure(*map(int, sys.argv[1:])).items():
        in_use = getattr(calibration, name.split()[0].strip(","), None)
        print(f"{name:28} {value:8.4f}" + (f"   in use: {in_use:g}" if in_use else ""))
