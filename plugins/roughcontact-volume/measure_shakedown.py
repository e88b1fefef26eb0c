"""Shakedown of a rolling ball against Johnson's limit.

A residual stress that is the same all along a track does not change the shear that alternates on planes along it, so
that nothing shakes down where that exceeds k: of Hertz's circular contact at a pressure of 4.68 k. First Hertz's
pressure is moved over a body that flows, without a contact. Then the contact is solved: the ball sinks into its track,
and the alternating shear of the pressure that is left is compared with k. ``python measure_shakedown.py 5 2`` takes 5
cells in the radius of the contact, and 2 between two places; a minute of one core.
"""

from __future__ import annotations

import sys
import time

import numpy as np
import roughcontact as rc
from roughcontact.typing import Array

from roughcontact_volume import Plastic, VolumeOperators, find_shakedown_load
from roughcontact_volume.box import find_operators, list_layers
from roughcontact_volume.radial_return import find_accumulated
from roughcontact_volume.shakedown import judge_strains
from roughcontact_volume.step import FlowingCells, solve_step

LIMIT, YOUNG, POISSON, RADIUS = 1e9, 200e9, 0.3, 1e-3
SHEAR_LIMIT = LIMIT / np.sqrt(3.0)
MODULUS = YOUNG / (1.0 - POISSON**2)
MATERIAL = Plastic(YOUNG, POISSON, LIMIT, accuracy=1.0)
# Components xx, yy, zz, yz, xz, xy.
XZ = 4


def find_force(ratio: float) -> float:
    """Return the force of Hertz's contact of a maximum pressure over k."""
    radius = 0.5 * np.pi * ratio * SHEAR_LIMIT * RADIUS / MODULUS
    return 2.0 / 3.0 * np.pi * radius**2 * ratio * SHEAR_LIMIT


def make_track(cells: int, step: int) -> list[int]:
    """Return the places of a pass of three radii, in cells."""
    half = int(1.5 * cells) // step
    return [step * place for place in range(-half, half + 1)]


def make_grid(cells: int, radius: float) -> rc.Grid:
    """Return seven radii along the track, and five across."""
    shape = (int(7 * cells), int(5 * cells))
    return rc.Grid(shape, tuple(count * radius / cells for count in shape))


def press_hertz(grid: rc.Grid, radius: float, place: float) -> Array:
    """Return Hertz's pressure over its maximum, the mean over each cell."""
    points = (np.arange(5) - 2.0) / 5.0
    found = np.zeros(grid.shape)
    for x in points * grid.spacing[0]:
        for y in points * grid.spacing[1]:
            squares = (grid.x + x - place) ** 2 + (grid.y + y) ** 2
            found += np.sqrt(np.maximum(0.0, 1.0 - squares / radius**2)) / 25.0
    return found


def move_pressure(ratio: float, cells: int = 5, step: int = 1, passes: int = 8) -> tuple[str, list[float]]:
    """Return the verdict on passes of Hertz's pressure, with a maximum over k, and their new and all strain."""
    radius = 1e-5
    grid = make_grid(cells, radius)
    count = int(np.ceil(np.log1p(2.2 * cells / 0.7 * 0.15) / np.log(1.15)))
    operators = find_operators(grid, rc.Boundary.PERIODIC, count, MATERIAL)
    places = [place * grid.spacing[0] for place in make_track(cells, step)]
    stresses = [ratio * SHEAR_LIMIT * operators.press(press_hertz(grid, radius, place)) for place in places]
    strain, total = np.zeros(operators.shape), np.zeros(operators.shape[1:])
    middle = np.abs(grid.x[:, 0]) <= 0.75 * radius
    new = []
    for _ in range(passes):
        before = total
        for stress in stresses:

            def find_stresses(
                flows: list[Array], error: float, stress: Array = stress, strain: Array = strain
            ) -> list[Array]:
                return [operators.find_stress(strain + flows[0]) + stress]

            flow = solve_step(find_stresses, [FlowingCells(MATERIAL, total)], 1e-4).flows[0].fill(total.shape)
            strain, total = strain + flow, total + find_accumulated(flow)
        new.append(float((total - before)[:, middle].max()))
    return judge_strains(np.array(new), np.cumsum(new)), new


def main(cells: int = 5, step: int = 2) -> None:
    """Print both."""
    for ratio in (4.4, 4.6, 4.8, 5.0):
        verdict, new = move_pressure(ratio, cells, 1)
        print(f"Hertz's pressure of {ratio} k, held: {verdict}, the last pass adds {new[-1]:.1e} of {sum(new):.1e}")
    grid = make_grid(cells, 0.5 * np.pi * 5.5 * SHEAR_LIMIT * RADIUS / MODULUS)
    body, ball = rc.Body(rc.FlatSurface(), MATERIAL), rc.Body(rc.ParaboloidSurface(RADIUS), rc.Rigid())
    problem = rc.ContactProblem(body, ball, grid=grid, boundary="periodic")
    track = [(place, 0) for place in make_track(cells, step)]
    started = time.process_time()
    found = find_shakedown_load(problem, track, (find_force(4.5), find_force(7.0)), passes=12)
    print(f"{found}\n{time.process_time() - started:.0f} s of one core")
    columns = found.table().columns
    for row in zip(*columns.values(), strict=True):
        print(", ".join(f"{name} {value}" for name, value in zip(columns, row, strict=True)))
    print(f"Hertz's pressure at this force: {(found.force.value / find_force(1.0)) ** (1.0 / 3.0):.2f} k")
    operators = VolumeOperators(grid, rc.Boundary.PERIODIC, list_layers(grid, 12), YOUNG, POISSON)
    for force, _ in (found.below, found.above):
        state = problem.path(force=force, shift=4 * track)[3 * len(track) + len(track) // 2]
        shear = np.abs(operators.press(state.pressure)[XZ]).max() / SHEAR_LIMIT
        print(f"{force:.4g} N: pressure {state.pressure.max() / SHEAR_LIMIT:.2f} k, alternating shear {shear:.3f} k")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
