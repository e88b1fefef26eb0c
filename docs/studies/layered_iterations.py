"""Iterations and products of the default solver on bonded layers, over those without layers.

    python docs/studies/layered_iterations.py
    python docs/studies/doc_tables.py layered-iterations

Needs `plugins/roughcontact-layered`. Self-affine surfaces (Hurst 0.8, rms slope 0.1, shortest wave of 8 cells) with
seeds that were used for no constant of the solver, on 128 and 256 cells along a side, on both boundaries, at two
loads. The load is that of the homogeneous body times the modulus that a wave of 16 cells meets.
"""

from __future__ import annotations

import itertools
import statistics

import numpy as np
from doc_tables import DocTable, Rows, format_rows

import roughcontact as rc
from roughcontact_layered import Layer, LayeredKernel

SUBSTRATE = rc.Elastic(1.0, 0.3)
SLOPE, SHORTEST = 0.1, 8.0
RATIOS = (0.1, 2.0, 5.0, 10.0, 30.0)
THICKNESSES = (0.5, 1.0, 2.0, 4.0, 8.0)
# Cells along a side, boundary, seed.
SCENES = ((128, "periodic", 11), (256, "periodic", 12), (128, "free", 13), (256, "free", 14))
LOADS = (0.05, 0.2)


def coating(ratio: float, thickness: float) -> LayeredKernel:
    """Return the kernel of a layer of a modulus over the substrate's, as thick as some cells of side one."""
    return LayeredKernel(Layer(ratio, 0.3, thickness), substrate=SUBSTRATE)


def count(kernel: LayeredKernel | str, cells: int, boundary: str, seed: int, load: float) -> tuple[int, int]:
    """Return the iterations on the finest grid and all products of one contact."""
    longest = float(cells) if boundary == "periodic" else cells / 2
    surface = rc.SelfAffineSurface(
        hurst=0.8, rms_slope=SLOPE, shortest=SHORTEST, longest=longest, rolloff=cells / 8, seed=seed
    )
    grid = rc.Grid((cells, cells), float(cells))
    modulus = 1.0 / SUBSTRATE.compliance
    if isinstance(kernel, LayeredKernel):
        modulus = kernel.effective_modulus(np.array([np.pi / SHORTEST]), SUBSTRATE.compliance).item()
    problem = rc.ContactProblem(rc.Body(surface, SUBSTRATE), grid=grid, boundary=boundary, kernel=kernel, threads=1)
    solution = problem.solve(pressure=load * SLOPE * modulus)
    return solution.iterations, solution.convolutions


def make_rows() -> Rows:
    """Return medians of iterations and products over those without layers, and the maxima in brackets."""
    contacts = [(*scene, load) for scene, load in itertools.product(SCENES, LOADS)]
    plain = [count("love", *contact) for contact in contacts]
    rows = [["E ratio", *(f"{thickness:g} cells" for thickness in THICKNESSES)]]
    for ratio in RATIOS:
        row = [f"{ratio:g}"]
        for thickness in THICKNESSES:
            kernel = coating(ratio, thickness)
            found = [count(kernel, *contact) for contact in contacts]
            parts = []
            for kind in (0, 1):
                ratios = [one[kind] / other[kind] for one, other in zip(found, plain, strict=True)]
                parts.append(f"{statistics.median(ratios):.1f} ({max(ratios):.1f})")
            row.append("; ".join(parts))
        rows.append(row)
    return rows


TABLES = {"layered-iterations": DocTable(make_rows, seconds=100)}

if __name__ == "__main__":
    print(format_rows(make_rows()))
