"""The figure and the tables of docs/use/friction.md: balls, unlike bodies, a frozen cone, cost, and fretting.

python docs/studies/friction.py
"""

from __future__ import annotations

import math
import time
from pathlib import Path

import numpy as np
from doc_tables import DocTable, write_tables

import roughcontact as rc
from roughcontact._solve.solvers import ProjectedShearCG, ShearTask
from roughcontact.plotting import style
from roughcontact.reference import CattaneoMindlin

FIGURES = Path(__file__).parent.parent / "figures"
RADIUS = 1e-2
CELL = 1e-6
FRICTION = 0.3
STIFF = rc.Elastic(young=200e9, poisson=0.0)
STEEL = rc.Elastic(young=210e9, poisson=0.3)
ALUMINIUM = rc.Elastic(young=70e9, poisson=0.33)
ELASTOMER = rc.Elastic(young=5e6, poisson=0.45)


def make_ball(
    cells: float, bodies: tuple[rc.Material, rc.Material], place: tuple[float, float] = (0.0, 0.0)
) -> tuple[rc.ContactProblem, float]:
    """Return a ball on a flat, its place in cells, and the force that gives a contact radius in cells."""
    count = 2 * math.ceil(1.25 * cells) + 4
    ball = rc.ParaboloidSurface(RADIUS, center=(place[0] * CELL, place[1] * CELL))
    problem = rc.ContactProblem(
        rc.Body(ball, bodies[0]),
        rc.Body(rc.FlatSurface(), bodies[1]),
        grid=rc.Grid((count, count), count * CELL),
        threads=1,
    )
    return problem, 4.0 * problem.plan.modulus * (cells * CELL) ** 3 / (3.0 * RADIUS)


def make_rough(one: rc.Material, other: rc.Material, cells: int = 128) -> rc.ContactProblem:
    """Return an isotropic rough surface on a flat, periodic, with eight cells in its shortest wave."""
    surface = rc.SelfAffineSurface(
        hurst=0.8, rms_slope=0.05, shortest=8 * CELL, longest=cells / 2 * CELL, rolloff=cells / 4 * CELL, seed=5
    )
    grid = rc.Grid((cells, cells), cells * CELL)
    return rc.ContactProblem(
        rc.Body(surface, one), rc.Body(rc.FlatSurface(), other), grid=grid, boundary="periodic", threads=1
    )


def make_ball_rows() -> list[list[str]]:
    rows = [
        ["contact radius, cells", "displacement, %", "stated, %", "energy of a cycle, %", "stated, %", "within two, %"]
    ]
    random = np.random.default_rng(2)
    for cells in (4, 8, 16, 32):
        found = []
        for _ in range(24):
            problem, force = make_ball(cells, (STIFF, STIFF), tuple(random.uniform(-0.5, 0.5, 2)))
            ball = CattaneoMindlin(force, RADIUS, problem.plan.modulus, FRICTION, 1.0)
            pushed = float(random.uniform(0.2, 0.9)) * FRICTION * force
            path = problem.path(force=force, tangential_force=[(pushed, 0.0), (-pushed, 0.0)], friction=FRICTION)
            moved = path.numbers[0].displacement[0]
            lost = path.numbers[1].dissipated
            exact = ball.displacement(pushed), 0.5 * ball.dissipated(pushed)
            found.append(
                [
                    (part.value / true - 1.0, part.uncertainty / true)
                    for part, true in zip((moved, lost), exact, strict=True)
                ]
            )
        values = np.array(found)
        rms = 100.0 * np.sqrt(np.mean(values**2, axis=0))
        inside = 100.0 * np.mean(np.abs(values[:, :, 0]) <= 2.0 * values[:, :, 1])
        rows.append([str(cells), *(f"{value:.2g}" for value in rms.ravel()), f"{inside:.0f}"])
    return rows


def make_unlike_rows() -> list[list[str]]:
    rows = [["bodies", "β", "pressure, rms %", "area, %", "displacement, %", "traction, rms %"]]
    pairs = {
        "steel on aluminium": (STEEL, ALUMINIUM),
        "elastomer on steel": (ELASTOMER, STEEL),
        "steel on a rigid body": (STEEL, rc.Rigid()),
    }
    for name, (one, other) in pairs.items():
        problem = make_rough(one, other)
        pressure = 0.005 * problem.plan.modulus
        force = pressure * problem.plan.grid.area
        pushed = 0.5 * FRICTION * force
        path = problem.path(force=force, tangential_force=[(pushed, 0.0)], friction=FRICTION)
        uncoupled = problem.solve(force=force)
        moved, shear = freeze_cone(problem, uncoupled, pushed, coupled=False)
        state = path[0]
        rows.append(
            [
                name,
                f"{state.pair.beta:.3f}",
                f"{100.0 * _rms(uncoupled.pressure - state.pressure) / _rms(state.pressure):.1f}",
                f"{100.0 * (np.mean(uncoupled.contact) / np.mean(state.contact.contact) - 1.0):+.1f}",
                f"{100.0 * (moved / path.numbers[0].displacement[0].value - 1.0):+.1f}",
                f"{100.0 * _rms(shear - state.shear) / _rms(state.shear):.0f}",
            ]
        )
    return rows


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def freeze_cone(
    problem: rc.ContactProblem, contact: rc.typing.ContactSolution, pushed: float, *, coupled: bool
) -> tuple[float, np.ndarray]:
    """Return displacement, m, and traction, Pa, within the limits of a pressure that the traction does not change."""
    shear = problem.shear_convolution
    unit = problem.plan.modulus
    pressure = contact.pressure / unit
    offset = -shear.apply(pressure[np.newaxis], of="z") if coupled else np.zeros((2, *pressure.shape))
    task = ShearTask(
        limit=FRICTION * pressure,
        offset=offset,
        shear_force=(pushed / unit / problem.plan.grid.cell_area, 0.0),
        displacement=(None, None),
        start=None,
        tolerance=1e-6,
        max_iterations=500,
    )
    found = ProjectedShearCG().solve(shear, task)
    return found.displacement[0] * problem.plan.grid.spacing[0], found.shear * unit


def make_frozen_rows() -> list[list[str]]:
    rows = [["β", "displacement, %", "traction beyond the limit, % of the force"]]
    for poisson in (0.3, 0.0):
        problem = make_rough(rc.Elastic(210e9, poisson), rc.Rigid())
        force = 0.005 * problem.plan.modulus * problem.plan.grid.area
        pushed = 0.7 * FRICTION * force
        frozen = problem.solve(force=force)
        moved, shear = freeze_cone(problem, frozen, pushed, coupled=True)
        true = problem.path(force=[force], tangential_force=[(pushed, 0.0)], friction=FRICTION, substeps=1)[0]
        # The pressure that belongs to the frozen traction.
        lifted = problem.shear_convolution.apply(shear / problem.plan.modulus, to="z")[0] * problem.plan.grid.spacing[0]
        raised = rc.HeightMap(-(frozen.initial_gap + lifted), problem.plan.grid.size, periodic=True)
        answer = with_heights(problem, raised).solve(force=force)
        beyond = np.maximum(np.hypot(*shear) - FRICTION * answer.pressure, 0.0).sum() / np.abs(shear[0]).sum()
        rows.append(
            [
                f"{true.pair.beta:.2f}",
                f"{100.0 * (moved / true.displacement[0] - 1.0):+.1f}",
                f"{100.0 * beyond:.1f}",
            ]
        )
    return rows


def with_heights(problem: rc.ContactProblem, heights: rc.HeightMap) -> rc.ContactProblem:
    """Return the problem of the same material with other heights."""
    return rc.ContactProblem(
        rc.Body(heights, problem.body.material), grid=problem.plan.grid, boundary="periodic", threads=1
    )


def make_cost_rows() -> list[list[str]]:
    rows = [["cells", "bodies", "iterations", "CPU, s", "in normal solves"]]
    for cells in (256, 512):
        for name, other in (("like", STEEL), ("unlike", ALUMINIUM)):
            problem = make_rough(STEEL, other, cells)
            force = 0.005 * problem.plan.modulus * problem.plan.grid.area
            problem.shear_convolution.inverse(np.float32)
            begin = time.process_time()
            problem.solve(force=force)
            normal = time.process_time() - begin
            begin = time.process_time()
            path = problem.path(
                force=[force], tangential_force=[(0.5 * FRICTION * force, 0.0)], friction=FRICTION, substeps=1
            )
            spent = time.process_time() - begin
            rows.append([f"{cells} x {cells}", name, str(path[0].iterations), f"{spent:.2f}", f"{spent / normal:.1f}"])
    return rows


def run_fretting(points: int = 8) -> tuple[rc.ContactProblem, rc.FrictionalPath]:
    """Return ground steel on lapped steel, and a cycle of 0.6 times the sliding force."""
    ground = rc.SelfAffineSurface(
        hurst=0.8, rms_height=150e-9, shortest=8e-6, longest=64e-6, rolloff=32e-6, peklenik=5.0, lay=math.pi / 2, seed=3
    )
    problem = rc.ContactProblem(
        rc.Body(ground, STEEL),
        rc.Body(rc.FlatSurface(), STEEL),
        grid=rc.Grid((128, 128), 128e-6),
        boundary="periodic",
        threads=1,
    )
    force = 300e6 * problem.plan.grid.area
    there = 0.6 * FRICTION * force * np.linspace(0.0, 1.0, points + 1)[1:]
    back = 0.6 * FRICTION * force * np.linspace(1.0, -1.0, 2 * points + 1)[1:]
    pushed = [*there, *back, *-back]
    path = problem.path(force=force, tangential_force=[(float(part), 0.0) for part in pushed], friction=FRICTION)
    return problem, path


@style()
def draw(folder: Path = FIGURES) -> None:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 3.6), layout="constrained")
    left, middle, right = figure.subplots(1, 3)
    problem, path = run_fretting()
    path.plot(axes=left)
    left.set_title("A cycle of the force")
    extent = 1e6 * np.array([0.0, problem.plan.grid.size[0], 0.0, problem.plan.grid.size[1]])
    state = path[7]
    zones = np.where(state.contact.contact, np.where(state.stick, 1.0, 2.0), np.nan)
    middle.imshow(zones.T, origin="lower", extent=extent, cmap="viridis", vmin=0.5, vmax=2.5, interpolation="nearest")
    middle.set(xlabel="x, µm", ylabel="y, µm", title="Stick (dark) and slip (light)")
    work = path.work[8:].sum(axis=0)
    image = right.imshow(
        np.where(work > 0.0, work, np.nan).T, origin="lower", extent=extent, cmap="magma_r", interpolation="nearest"
    )
    figure.colorbar(image, ax=right, label="energy lost in the cycle, J/m²")
    right.set(xlabel="x, µm", ylabel="y, µm", title="Where it wears")
    folder.mkdir(parents=True, exist_ok=True)
    figure.savefig(folder / "friction.png", dpi=120)


TABLES = {
    "friction-balls": DocTable(make_ball_rows, seconds=8),
    "friction-unlike": DocTable(make_unlike_rows, seconds=30),
    "friction-frozen": DocTable(make_frozen_rows, seconds=6),
    "friction-cost": DocTable(make_cost_rows, seconds=30, timed=("CPU, s", "in normal solves")),
}

if __name__ == "__main__":
    write_tables(TABLES)
    draw()
