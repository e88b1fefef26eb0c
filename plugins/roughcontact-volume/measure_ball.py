"""The ball of this plug-in beside finite elements: `python measure_ball.py [CELLS ...]`, cells along a contact radius.

The answers of the elements stand in `tests/ball_references.json`, which `tests/ball_by_elements.py` computes. Lengths
over the contact radius at first yield, stresses over the yield stress.
"""

from __future__ import annotations

import math
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import roughcontact as rc
from scipy.interpolate import CubicSpline

from roughcontact_volume import LinearHardening, Plastic, SwiftHardening, VolumeOperators
from roughcontact_volume.box import list_layers

sys.path.insert(0, str(Path(__file__).parent / "tests"))
from ball_by_elements import (
    DEPTHS,
    PLACES,
    POISSON,
    RADIUS,
    UNIT_APPROACH,
    UNIT_FORCE,
    YOUNG,
    hertz_radius,
    load_answers,
)

HARDENINGS = {"perfectly plastic": None, "linear": LinearHardening(0.02 * YOUNG), "Swift": SwiftHardening(0.005, 0.2)}
ERRORS = ("approach %", "p0 %", "strain %", "stress / Y", "residual / Y", "imprint %")
HEADING = ("case", "cells", "accuracy", *ERRORS, "second loading", "CPU s")
# Admissible change by twice the substeps.
ACCURACY = 0.01
# Half the side of the grid over the contact radius.
HALF = 1.8


def measure(name: str, load: float, cells: int, answers: dict[str, list]) -> list[str]:
    """Return the errors of a ball with so many cells along its contact radius, and the CPU time."""
    contact = answers["contact radius"][0]
    # The middle of a cell lies below the ball.
    count = 2 * math.ceil(HALF * cells) + 1
    steel = rc.Body(rc.FlatSurface(), Plastic(YOUNG, POISSON, 1.0, HARDENINGS[name], accuracy=ACCURACY))
    ball = rc.Body(rc.ParaboloidSurface(RADIUS), rc.Rigid())
    problem = rc.ContactProblem(ball, steel, grid=rc.Grid((count, count), count * contact / cells))
    start = time.process_time()
    force = load * UNIT_FORCE
    path = problem.path(force=[force, 0.0, force])
    spent = time.process_time() - start
    loaded, unloaded, again = path
    unit = hertz_radius(load)
    error = {
        "approach": loaded.approach / UNIT_APPROACH / answers["approach"][0] - 1,
        "p0": fit_middle(loaded) / answers["maximum pressure"][0] - 1,
        "strain": find_memory(loaded)["accumulated_strain"].max() / answers["largest strain"][0] - 1,
    }
    depths = unit * np.array(DEPTHS)
    stress, residual = (
        np.array([answers[f"{kind}{way} stress"][0] for way in ("radial", "vertical")]) for kind in ("", "residual ")
    )
    middle = count // 2
    imprint = find_memory(unloaded)["imprint"][middle:, middle] / UNIT_APPROACH
    place = np.arange(imprint.size) * contact / cells
    expected = np.array(answers["imprint"][0])
    seen = unit * np.array(PLACES) < place[-1]
    differences = CubicSpline(place, imprint)(unit * np.array(PLACES)[seen]) - expected[seen]
    new = (find_memory(again)["accumulated_strain"] - find_memory(loaded)["accumulated_strain"]).max()
    deep = [np.abs(on_axis(state, depths) - one).max() for state, one in ((loaded, stress), (unloaded, residual))]
    return [
        f"{name} {load:g}",
        str(cells),
        f"{ACCURACY:g}",
        *(f"{100 * value:+.2f}" for value in error.values()),
        *(f"{value:.3f}" for value in deep),
        f"{100 * np.abs(differences).max() / expected[0]:.1f}",
        f"{new:.1e}",
        f"{spent:.1f}",
    ]


def find_memory(state: Any) -> Any:
    """Return the fields of the plastic flow."""
    return state.added[0].memory[0]


def fit_middle(state: Any) -> float:
    """Return the pressure in the middle by a polynomial in the square of the distance over half of the contact."""
    count = state.grid.shape[0] // 2
    x = np.arange(-count, count + 1) * state.grid.spacing[0]
    square = (x[:, None] ** 2 + x**2).ravel()
    inside = square < 0.25 * square[state.pressure.ravel() > 0].max()
    return float(np.polyfit(square[inside], state.pressure.ravel()[inside], 2)[-1])


def on_axis(state: Any, depths: Any) -> Any:
    """Return the radial and the vertical stress at depths below the middle, shape (2, depths)."""
    memory = find_memory(state)
    layers = list_layers(state.grid, len(memory["accumulated_strain"]))
    # Below the box no strain lies.
    lower = 1.15 ** np.arange(1, 12) * layers[-1]
    operators = VolumeOperators(state.grid, rc.Boundary.FREE, np.concatenate((layers, lower)), YOUNG, POISSON)
    strain = np.zeros(operators.shape)
    strain[:, : layers.size] = memory["plastic_strain"]
    stress = operators.press(state.pressure) + operators.find_stress(strain)
    middle = state.grid.shape[0] // 2
    column = stress[:, :, middle, middle]
    return CubicSpline(operators.depths, (column[:2].mean(axis=0), column[2]), axis=1)(depths)


def main() -> None:
    """Print the table."""
    cells = [int(word) for word in sys.argv[1:]] or [8, 16]
    print(" | ".join(HEADING))
    for case, answers in load_answers().items():
        name, load = case.rsplit(" ", 1)
        for count in cells:
            print(" | ".join(measure(name, float(load), count, answers)), flush=True)


if __name__ == "__main__":
    main()
