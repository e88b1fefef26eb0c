"""The default area on the paper's wave, on grids with and without a whole number of cells in a wave, at several phases.

    python docs/studies/paper_grids.py

Writes a table of docs/trust/paper.md. Needs plugins/roughcontact-paper for the converged values.
"""

from __future__ import annotations

import numpy as np
from doc_tables import DocTable, pick, some_of, write_tables

import roughcontact as rc
from roughcontact_paper import published

GRIDS = (160, 200, 240, 250, 256, 260, 320, 500, 512)
PHASES = 4
SIZE, WAVELENGTH, SEED = 250e-6, 12.5e-6, 14


def measure(cells: int, load: int, phase: tuple[float, float]) -> tuple[float, float, float]:
    """Return the errors of area and maximum pressure, and the stated uncertainty of the area, %."""
    surface = rc.WavySurface(amplitude=0.5e-6, wavelength=WAVELENGTH, phase=phase)
    body = rc.Body(surface, rc.Elastic(young=200e9, poisson=0.3))
    problem = rc.ContactProblem(body, grid=rc.Grid((cells, cells), SIZE), boundary="periodic")
    solution = problem.solve(pressure=1e6 * load)
    area = solution.area()
    error = 100 * area.fraction / published.TRUE_AREA[load] - 1
    peak = solution.pressure.max() / 1e9 / published.TRUE_P_MAX[load] - 1
    return 100 * error, 100 * peak, 100 * area.uncertainty / area.value


def make_rows() -> list[list[str]]:
    phases = 2 * np.pi * np.random.default_rng(SEED).random((PHASES, 2))
    lines = [["N", "cells a wave", "phase zero: 50, 100, 200 MPa, %", "stated, %", "random phases: rms, %", "worst, %"]]
    lines[0] += ["within two", "maximum cell pressure: rms, %"]
    for cells in some_of(GRIDS, 0, 3, 4):
        zero = [measure(cells, load, (0.0, 0.0)) for load in published.LOADS]
        rest = [measure(cells, load, (float(x), float(y))) for x, y in phases for load in published.LOADS]
        errors, peaks, stated = np.array(zero + rest).T
        random = errors[len(zero) :]
        line = [f"{cells}", f"{cells * WAVELENGTH / SIZE:g}", ", ".join(f"{row[0]:+.2f}" for row in zero)]
        line += [", ".join(f"{row[2]:.2f}" for row in zero), f"{np.sqrt(np.mean(random**2)):.2f}"]
        line += [
            f"{random[np.argmax(np.abs(random))]:+.2f}",
            f"{int(np.sum(np.abs(errors) <= 2 * stated))} of {errors.size}",
        ]
        lines.append([*line, f"{np.sqrt(np.mean(peaks**2)):.1f}"])
    return lines


# The columns of the page.
SHOWN = (
    "N",
    "cells a wave",
    "phase zero: 50, 100, 200 MPa, %",
    "stated, %",
    "worst, %",
    "maximum cell pressure: rms, %",
)
TABLES = {"paper-grids": DocTable(make_rows, seconds=25, shown=pick(SHOWN, ("160", "256", "512")))}

if __name__ == "__main__":
    write_tables(TABLES)
