"""Constants of rough contacts: heights that the grid hardly resolves, and Hertz's theory on each patch.

    python benchmarks/rough_constants.py [number of surfaces]

Solves self-affine surfaces at three loads on grids of 2 to 8 cells a shortest wave and compares them with 32; prints
each constant of `roughcontact._answers.areas.calibration` beside what is measured again. One minute for four surfaces.
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


def compare_patches(coarse: rc.ContactSolution, fine: rc.ContactSolution, true: np.ndarray) -> np.ndarray:
    """Return cells and relative error of each coarse patch of at most three cells, over the resolution ratio."""
    ratio, factor = trace_edges(coarse).curvature_resolution, FINEST // coarse.grid.shape[0]
    i, j = np.nonzero(fine.contact)
    label = fine.patches.labels[i, j]
    each = true[label] / np.concatenate(([1], fine.patches.cells))[label]
    owner = coarse.patches.labels[i // factor, j // factor]
    reached = np.bincount(owner, weights=each, minlength=coarse.patches.count + 1)[1:]
    areas, cells = coarse.area().patches, coarse.patches.cells
    small = cells <= 3
    return np.stack((cells[small], (1.0 - reached[small] / areas[small]) / ratio), axis=1)


def measure(count: int = 4) -> dict[str, float]:
    """Return what is measured on so many surfaces."""
    edges, summits, patches, unseen = [], [], [], []
    for hurst, seed in SURFACES[:count]:
        for load in LOADS:
            fine = press(hurst, seed, FINEST, load)
            true = np.maximum(trace_edges(fine).refined, 0.0)
            summits.append(compare_hertz(fine, true))
            for per_wave in (2, 3, 4, 6, 8):
                coarse = press(hurst, seed, WAVES * per_wave, load)
                traced = trace_edges(coarse)
                ratio, strip = traced.curvature_resolution, traced.strip.sum()
                excess, refined = (areas.sum() - true.sum() for areas in (traced.area, traced.refined))
                edges.append((ratio, excess / strip, refined / strip))
                if per_wave == 2:
                    patches.append(compare_patches(coarse, fine, true))
                    error = abs(coarse.area().value / true.sum() - 1.0)
                    unseen.append(error / (coarse.patches.small_fraction * ratio**2))
    ratio, excess, refined = np.array(edges).T
    spread, error, stated, area = np.concatenate(summits).T
    cells, scatter = np.concatenate(patches).T
    found = {
        "EXCESS": np.sum(excess * ratio) / np.sum(ratio**2),
        "EXCESS_REFINED": np.sum(refined * ratio**2) / np.sum(ratio**4),
        "edge shift on rough": rc.Love.edge_shift - np.linalg.lstsq(np.stack((ratio, ratio**0), 1), excess)[0][1],
        "UNSEEN_STD (maximum)": max(unseen),
    }
    for n in (1, 2, 3):
        found[f"SMALL_PATCH_STD at {n} cells"] = float(np.median(np.abs(scatter[cells == n]))) * n**1.5
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
