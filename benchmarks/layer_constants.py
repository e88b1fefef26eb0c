"""Constants of contacts on layers, where E* depends on the wavelength, measured on spheres.

    python benchmarks/layer_constants.py

Needs the plug-in roughcontact-layered. Compares spheres on one layer with six times finer grids, for three values of
each length at which E* is taken, beside `roughcontact._answers.areas.calibration`; one minute.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable

import attrs
import numpy as np

import roughcontact as rc
from roughcontact._answers.areas import calibration
from roughcontact._answers.areas.contour import find_modulus_change
from roughcontact._answers.areas.edges import trace_edges
from roughcontact._answers.areas.hertz import hertz_areas
from roughcontact_layered import Layer, LayeredKernel

RATIOS = (0.1, 0.25, 4.0, 10.0)  # modulus of the layer over that of the substrate
THICK, THIN = (1.0, 3.0), (0.2, 0.4)  # thickness in cells: for the lengths, and where the edge does not see the layer
LENGTHS = (0.25, 0.5, 1.0)
CELLS, FINER = 40, 6


def press(ratio: float, thickness: float, cells: int, centre: tuple[float, float]) -> rc.ContactSolution:
    """Return the contact of a sphere, ten coarse cells in radius without the layer."""
    substrate = rc.Elastic(1.0, 0.0)
    kernel = LayeredKernel((Layer(young=ratio, poisson=0.0, thickness=thickness),), substrate=substrate)
    body = rc.Body(rc.ParaboloidSurface(1e4, center=centre), substrate)
    problem = rc.ContactProblem(body, grid=rc.Grid((cells, cells), float(CELLS)), kernel=kernel)
    return problem.solve(force=4.0 * 10.0**3 / 3e4)


def measure() -> dict[str, float]:
    """Return rms errors for each length tried, and errors over the logarithm of the change of E*."""
    rng = np.random.default_rng(0)
    errors, shifts, scatter = [], [], []
    in_use = calibration.MODULUS_LENGTH
    for ratio, thickness in itertools.product(RATIOS, THICK + THIN):
        centre = tuple(rng.random(2) - 0.5)
        true = press(ratio, thickness, FINER * CELLS, centre).area("level-set").value
        solution = press(ratio, thickness, CELLS, centre)
        traced = trace_edges(solution)
        if thickness in THIN:
            shifts.append((traced.area.sum() - true) / traced.strip.sum() / find_modulus_change(solution))
            continue
        found = hertz_areas(solution)
        change = float(found.summits.change.min())
        scatter.append((found.area.sum() / true - 1.0) / change)
        tried = []
        for length in LENGTHS:
            calibration.MODULUS_LENGTH = length
            traced = trace_edges(attrs.evolve(solution))
            tried.append((traced.area.sum() - true) / traced.strip.sum())
            # What was found for a solution is kept, so that this is another one.
            tried.append(hertz_areas(attrs.evolve(solution)).area.sum() / true - 1.0)
        calibration.MODULUS_LENGTH = in_use
        errors.append(tried)
    names = [f"{name} {length}" for length in LENGTHS for name in ("cells", "radii")]
    found = {
        f"rms error with MODULUS_LENGTH, {name}": rms(of) for name, of in zip(names, np.transpose(errors), strict=True)
    }
    return found | {"LAYERED_POSITION_STD (rms)": rms(shifts), "HERTZ_LAYERED_ERROR (rms)": rms(scatter)}


def rms(values: Iterable[float]) -> float:
    """Return the root mean square."""
    return float(np.sqrt(np.mean(np.square(tuple(values)))))


if __name__ == "__main__":
    for name, value in measure().items():
        in_use = next(getattr(calibration, word) for word in name.replace(",", "").split() if word.isupper())
        print(f"{name:44} {value:8.4f}   in use: {in_use:g}")
