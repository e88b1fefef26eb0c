"""Contacts on slabs, and the same ones of a single process: run by torchrun, `slab_cases.py FOLDER NAME ...`."""

import json
import sys
from pathlib import Path

import numpy as np
import roughcontact as rc
import torch

from roughcontact_torch import (
    MaskedConjugateGradient,
    Processes,
    SlabTensor,
    TorchFFT,
    ending_all,
    make_heights,
    slab_convolver,
    solve_on_slabs,
)

# Shapes that two or three processes do not divide among them.
SHAPES = {
    "square": (64, 64),
    "odd": (75, 49),
    "wide": (50, 110),
    "nested": (96, 96),
    "large": (512, 512),
    "low": (2, 40),
}
MIXED = {"free-periodic": ("free", "periodic"), "periodic-free": ("periodic", "free")}
LOADS = {"light": 5e6, "heavy": 2e7, "nearly-full": 1e8, "hard": 1e7}
STEEL = rc.Elastic(1e9, 0.0)
PLASTIC = rc.ElasticPerfectlyPlastic(1e9, 0.0, 3e7)


def make_case(name):
    """Return heights, grid, material and arguments of a case: shape, boundary, load and seed."""
    shape, boundary, load, seed = name.split("_")
    nx, ny = SHAPES[shape]
    grid = rc.Grid((nx, ny), (float(nx), float(ny)))
    if nx < 8:
        heights = np.random.default_rng(int(seed)).normal(size=(nx, ny))
    else:
        side = float(max(nx, ny))
        waves = {"shortest": 8.0, "longest": side, "rolloff": side / 8}
        heights = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, seed=int(seed), **waves).heights(grid)
    kind = load.removeprefix("hard-")
    pressed = {"pressure": LOADS[kind]} if kind in LOADS else {"approach": 0.5 * float(heights.max() - heights.mean())}
    material = PLASTIC if load.startswith("hard") else STEEL
    return heights, grid, material, {"boundary": MIXED.get(boundary, boundary), **pressed}


def solve_alone(name):
    """Return the solution of one process, by the masked solver on whole tensors."""
    heights, grid, material, arguments = make_case(name)
    boundary = arguments.pop("boundary")
    body = rc.Body(rc.HeightMap(heights, size=grid.size, periodic=True), material)
    tensors = {"convolver": TorchFFT("cpu"), "solver": MaskedConjugateGradient()}
    return rc.ContactProblem(body, boundary=boundary, threads=1, **tensors).solve(**arguments)


def solve_case(name, processes):
    """Return the numbers of a case on slabs, and on the first process the gathered solution."""
    heights, grid, material, arguments = make_case(name)
    part = SlabTensor.field(heights[processes.own_rows(grid.shape[0])], processes, grid.shape[0])
    steps = []
    solution = solve_on_slabs(part, grid.size, material, on_step=steps.append, **arguments)
    numbers = {
        "status": solution.status.name,
        "iterations": solution.iterations,
        "convolutions": solution.convolutions,
        "contact": int(np.count_nonzero(solution.contact)),
        "force": solution.force,
        "mean": solution.mean_pressure,
        "approach": solution.approach,
        "residuals": [solution.residuals.complementarity, solution.residuals.penetration, solution.residuals.load],
        "steps": [step.iteration for step in steps],
        "rows": solution.pressure.tensor.shape[0],
        "gap": float(solution.gap.min()),
    }
    return numbers, solution.gather()


def main(folder, names):
    """Solve cases, and write what the first process has."""
    torch.set_num_threads(1)
    processes = Processes("cpu")
    with ending_all(processes):
        for name in names:
            # Grids in slabs down to the coarsest but one, as those of large contacts are.
            slab_convolver._WHOLE_CELLS = 40**2 if name.startswith("nested") else 256**2
            numbers, solution = solve_case(name, processes)
            if solution is not None:
                np.save(folder / f"{name}-{processes.count}.npy", solution.pressure)
                gathered = solution.residuals
                numbers["gathered"] = [gathered.complementarity, gathered.penetration, gathered.load]
                (folder / f"{name}-{processes.count}.json").write_text(json.dumps(numbers))
        surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=4.0, longest=37.0, seed=1)
        grid = rc.Grid((37, 45), (37.0, 45.0))
        found = make_heights(surface, grid, processes)
        rest = found.tensor.numpy() - surface.heights(grid)[processes.own_rows(37)]
        assert np.abs(rest).max() < 1e-14 * float(found.max())
        if processes.rank == 0:
            print("done")


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2:])
