"""The contacts that are timed: E* = 1 Pa on cells of 1 m, but for the paper's wave."""

from __future__ import annotations

import attrs
import numpy as np

import roughcontact as rc

SLOPE = 0.1  # rms slope of the rough surfaces
ELASTIC = rc.Elastic(1.0, 0.0)


@attrs.frozen(eq=False)
class Scene:
    """A problem, its mean pressure, Pa, and its true fraction of contact where that is known."""

    problem: rc.ContactProblem
    pressure: float
    fraction: float | None = None


def make_rough(cells: int, load: float, limit: float | None = None) -> Scene:
    """Return a rough contact; mean pressure and pressure limit are in units of E* times rms slope."""
    surface = rc.SelfAffineSurface(
        hurst=0.8, rms_slope=SLOPE, shortest=8.0, longest=float(cells), rolloff=cells / 8, seed=7
    )
    material = ELASTIC if limit is None else rc.ElasticPerfectlyPlastic(1.0, 0.0, limit * SLOPE)
    grid = rc.Grid((cells, cells), float(cells))
    return Scene(rc.ContactProblem(rc.Body(surface, material), grid=grid, boundary="periodic"), load * SLOPE)


def make_wave(cells: int) -> Scene:
    """Return the paper's wave at 100 MPa at an arbitrary phase; its true area is that of docs/trust/paper.md."""
    body = rc.Body(rc.WavySurface(0.5e-6, 12.5e-6, phase=(1.1, 2.3)), rc.Elastic(200e9, 0.3))
    grid = rc.Grid((cells, cells), 250e-6)
    return Scene(rc.ContactProblem(body, grid=grid, boundary="periodic"), 100e6, 0.0114192)


def make_ball(cells: int) -> Scene:
    """Return a ball on a free boundary, beside the middle of the grid; its true area is Hertz's."""
    radius, contact_radius = 10.0 * cells, 0.15 * cells
    ball = rc.ParaboloidSurface(radius, center=(0.3, -0.4))
    problem = rc.ContactProblem(rc.Body(ball, ELASTIC), grid=rc.Grid((cells, cells), float(cells)))
    pressure = 4.0 * contact_radius**3 / (3.0 * radius) / cells**2
    return Scene(problem, pressure, np.pi * contact_radius**2 / cells**2)


SCENES = {
    "rough, 0.05": lambda cells: make_rough(cells, 0.05),
    "rough, 0.2": lambda cells: make_rough(cells, 0.2),
    "rough, 1": lambda cells: make_rough(cells, 1.0),
    "rough, 1.5": lambda cells: make_rough(cells, 1.5),
    "rough, 0.05, limit 0.3": lambda cells: make_rough(cells, 0.05, 0.3),
    "wave": make_wave,
    "ball, free": make_ball,
}
