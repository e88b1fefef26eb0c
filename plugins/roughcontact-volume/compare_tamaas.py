"""Plastic flow below a contact here and by tamaas, the open code that has it: the same states, and their cost.

Needs an environment with tamaas 2.9, which is under the AGPL and no dependency of ours:

    python -m venv peers && peers/bin/pip install -e . ./plugins/roughcontact-volume tamaas
    peers/bin/python plugins/roughcontact-volume/compare_tamaas.py [CELLS] [ELEMENTS]

A ball in a period, and a rough surface, are pressed on a body that hardens linearly, in the same steps of the load, all
periodic and of the same cells. Along the depth we have the box of layers that a path chooses, tamaas linear elements of
equal length; its solver is DFSANE inside an accelerated fixed point with the contact. Prints largest pressure, strain,
its sum over the volume, the differences of pressure and displacement, and CPU seconds on one thread.
"""

from __future__ import annotations

import os
import sys
import time
from typing import Any, NamedTuple

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
import roughcontact as rc

from roughcontact_volume import LinearHardening, Plastic
from roughcontact_volume.box import list_layers

# Lengths in cells, stresses over Young's modulus.
YOUNG, POISSON = 1.0, 0.3
MODULUS = YOUNG / (1.0 - POISSON**2)
HARDENING = 0.02
# Of the load: both codes return implicitly in each. We solve the whole first, and then in these two steps.
PARTS = (0.5, 1.0)
# Of the solvers of tamaas: contact, flow over the yield stress, and the fixed point of both.
TOLERANCES = (1e-10, 1e-5, 1e-5)


class Case(NamedTuple):
    """A rigid surface on a flat that flows, and its mean pressure."""

    name: str
    heights: Any
    limit: float
    pressure: float
    depth: float


class Found(NamedTuple):
    """A state: layers, pressure and displacement of cells, largest plastic strain and sum over the volume, CPU time."""

    depth: str
    pressure: Any
    displacement: Any
    strain: float
    amount: float
    seconds: float


def make_cases(cells: int) -> list[Case]:
    """Return a ball at some ten times its load of first yield, and a rough surface to a fifth in contact."""
    grid = rc.Grid((cells, cells), float(cells))
    limit, contact = 0.005, cells / 8.0
    peak = 3.45 * limit
    radius = 2.0 * MODULUS * contact / np.pi / peak
    ball = rc.ParaboloidSurface(radius).heights(grid)
    force = 2.0 / 3.0 * np.pi * contact**2 * peak
    rough = rc.SelfAffineSurface(
        hurst=0.8, rms_slope=0.1, shortest=8.0, longest=float(cells), rolloff=cells / 2, seed=1
    ).heights(grid)
    return [
        Case("ball", ball, limit, force / cells**2, 2.0 * contact),
        Case("rough", rough, 0.03, 0.008, 10.0),
    ]


def solve_ours(case: Case) -> Found:
    """Return our state."""
    grid = rc.Grid(case.heights.shape, tuple(map(float, case.heights.shape)))
    # An increment is divided once at least.
    steel = Plastic(YOUNG, POISSON, case.limit, LinearHardening(HARDENING), accuracy=1.0)
    problem = rc.ContactProblem(
        rc.Body(rc.HeightMap(case.heights, grid.size, periodic=True), rc.Rigid()),
        rc.Body(rc.FlatSurface(), steel),
        grid=grid,
        boundary="periodic",
    )
    start = time.process_time()
    state = problem.solve(pressure=case.pressure)
    seconds = time.process_time() - start
    memory = state.added[0].memory[0]
    strain = memory["accumulated_strain"]
    layers = list_layers(grid, len(strain))
    amount = float(np.einsum("z,zxy->", layers, strain))
    where = f"{len(layers)} layers to {layers.sum():.1f}"
    return Found(where, state.pressure, state.displacement + memory["imprint"], float(strain.max()), amount, seconds)


def solve_theirs(case: Case, elements: int) -> Found:
    """Return the state of tamaas."""
    import tamaas as tm
    from tamaas.nonlinear_solvers import DFSANESolver

    tm.set_log_level(tm.LogLevel.error)
    cells = case.heights.shape
    model = tm.ModelFactory.createModel(
        tm.model_type.volume_2d, [case.depth, *map(float, cells)], [elements + 1, *cells]
    )
    model.E, model.nu = YOUNG, POISSON
    material = tm.materials.IsotropicHardening(model, case.limit, HARDENING)
    in_contact, in_flow, in_both = TOLERANCES
    flow = DFSANESolver(tm.Residual(model, material))
    flow.tolerance = in_flow * case.limit
    contact = tm.PolonskyKeerRey(model, case.heights, in_contact)
    both = tm.EPICSolver(contact, flow, in_both)
    start = time.process_time()
    for part in PARTS:
        both.acceleratedSolve(part * case.pressure)
    seconds = time.process_time() - start
    strain = model["cumulated_plastic_strain"]
    length = case.depth / elements
    amount = length * float(np.trapezoid(strain.sum(axis=(1, 2))))
    return Found(
        f"{elements} elements to {case.depth:.1f}",
        model["traction"][..., 2].copy(),
        model["displacement"][0, ..., 2].copy(),
        float(strain.max()),
        amount,
        seconds,
    )


def main(cells: int = 64, elements: int = 16) -> None:
    """Print the table."""
    print(
        "case | code | depth in cells | p max / Y | strain | its sum | pressure % | displacement % | contact % | CPU s"
    )
    for case in make_cases(cells):
        ours = solve_ours(case)
        rows = {"roughcontact": ours, "tamaas": solve_theirs(case, elements)}
        for code, found in rows.items():
            cells_of = (
                case.name,
                code,
                found.depth,
                f"{found.pressure.max() / case.limit:.4f}",
                f"{found.strain:.5f}",
                f"{found.amount:.5g}",
                f"{100 * differ(found.pressure, ours.pressure):.2f}",
                f"{100 * differ(found.displacement, ours.displacement):.2f}",
                f"{100 * np.mean(found.pressure > 0):.2f}",
                f"{found.seconds:.2f}",
            )
            print(" | ".join(cells_of), flush=True)


def differ(one: Any, other: Any) -> float:
    """Return the rms difference of two fields but for their means, over the range of the second."""
    difference = (one - one.mean()) - (other - other.mean())
    return float(np.sqrt(np.mean(difference**2)) / np.ptp(other))


if __name__ == "__main__":
    main(*map(int, sys.argv[1:3]))
