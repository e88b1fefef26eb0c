"""The figure and the tables of docs/use/friction.md: balls, unlike bodies, a frozen cone, cost, and fretting.

python docs/studies/friction.py
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from pathlib import Path

import attrs
import numpy as np
from doc_tables import DocTable, pick, some_of, write_tables

import roughcontact as rc
from roughcontact._parts.grid import Load
from roughcontact._solve.problem.friction_certificate import FoundTractions, FrictionalContact
from roughcontact._solve.solution import FrictionalState, TangentialLoad
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
    for cells in some_of((4, 8, 16, 32), 0, 1, 2):
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
                f"{state.sheared.pair.beta:.3f}",
                f"{100.0 * _rms(uncoupled.pressure - state.pressure) / _rms(state.pressure):.1f}",
                f"{100.0 * (np.mean(uncoupled.contact) / np.mean(state.contact) - 1.0):+.1f}",
                f"{100.0 * (moved / path.numbers[0].displacement[0].value - 1.0):+.1f}",
                f"{100.0 * _rms(shear - state.shear) / _rms(state.shear):.0f}",
            ]
        )
    return rows


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def freeze_cone(
    problem: rc.ContactProblem, contact: rc.ContactSolution, pushed: float, *, coupled: bool
) -> tuple[float, np.ndarray]:
    """Return displacement, m, and traction, Pa, within the limits of a pressure that the traction does not change."""
    task = make_task(problem, contact, pushed, coupled=coupled, tolerance=1e-6)
    found = ProjectedShearCG().solve(problem.shear_convolution, task)
    return found.displacement[0] * problem.plan.grid.spacing[0], found.shear * problem.plan.modulus


def make_task(
    problem: rc.ContactProblem,
    contact: rc.ContactSolution,
    pushed: float,
    *,
    coupled: bool,
    tolerance: float,
) -> ShearTask:
    """Return the tangential problem of a first push, N, in units of E* and of the side of a cell."""
    unit = problem.plan.modulus
    pressure = contact.pressure / unit
    offset = np.zeros((2, *pressure.shape))
    if coupled:
        offset -= problem.shear_convolution.apply(pressure[np.newaxis], of="z")
    return ShearTask(
        limit=FRICTION * pressure,
        offset=offset,
        shear_force=(pushed / unit / problem.plan.grid.cell_area, 0.0),
        displacement=(None, None),
        start=None,
        tolerance=tolerance,
        max_iterations=500,
    )


def make_frozen_rows() -> list[list[str]]:
    rows = [["β", "state", "normal", "cone", "slip", "displacement, %", "beyond the limit, % of the force"]]
    for poisson in (0.3, 0.0):
        problem = make_rough(rc.Elastic(210e9, poisson), rc.Rigid())
        force = 0.005 * problem.plan.modulus * problem.plan.grid.area
        pushed = 0.7 * FRICTION * force
        true = problem.path(force=[force], tangential_force=[(pushed, 0.0)], friction=FRICTION, substeps=1)[0]
        frozen = certify_frozen(problem, force, pushed)
        for name, state in (("path", true), ("frozen cone", frozen)):
            beyond = np.maximum(np.hypot(*state.shear) - state.shear_strength, 0.0).sum() / np.abs(state.shear[0]).sum()
            rows.append(
                [
                    f"{state.sheared.pair.beta:.2f}",
                    name,
                    format_residual(max(state.residuals.complementarity, state.residuals.penetration)),
                    format_residual(state.sheared.residuals.cone),
                    format_residual(state.sheared.residuals.slip),
                    f"{100.0 * (state.tangential_displacement[0] / true.tangential_displacement[0] - 1.0):+.1f}",
                    f"{100.0 * beyond:.1f}",
                ]
            )
    return rows


def format_residual(value: float) -> str:
    return f"{value:.2f}" if value > 1e-3 else "below 1e-5" if value <= 1e-5 else f"{value:.0e}"


def certify_frozen(problem: rc.ContactProblem, force: float, pushed: float) -> rc.ContactSolution:
    """Return the state of a code that keeps the limits of the first pressure, with our certificate of it."""
    certificate = FrictionalContact(problem, rc.Coulomb(FRICTION))
    first = problem.solve(force=force)
    moved, shear = freeze_cone(problem, first, pushed, coupled=True)
    # The pressure that belongs to this traction: the normal contact is solved as it should be.
    lifted = problem.shear_convolution.apply(shear / problem.plan.modulus, to="z")[0] * problem.plan.grid.spacing[0]
    raised = rc.HeightMap(-(first.initial_gap + lifted), problem.plan.grid.size, periodic=True)
    answer = with_heights(problem, raised).solve(force=force)
    found = attrs.evolve(first, pressure=answer.pressure)
    contact = certificate.certify_contact(found, Load.of(force=force), certificate.lift(shear / certificate.unit))
    before = FrictionalState.unloaded(problem.plan.grid.shape)
    state = FrictionalState(
        pressure=contact.pressure, shear=shear, displacement=(moved, 0.0), approach=contact.approach
    )
    given = TangentialLoad("tangential_force", (pushed, 0.0))
    return certificate.judge(
        contact,
        state,
        given,
        before,
        certificate.fields_of(before),
        FoundTractions(contact, shear, np.zeros(2), contact.status, 1, 0),
        0.0,
    )[0]


def with_heights(problem: rc.ContactProblem, heights: rc.HeightMap) -> rc.ContactProblem:
    """Return the problem of the same material with other heights."""
    return rc.ContactProblem(
        rc.Body(heights, problem.body.material), grid=problem.plan.grid, boundary="periodic", threads=1
    )


def make_increment_rows() -> list[list[str]]:
    """Return what one ball finds with few increments: unlike materials pressed only, and like ones pushed meanwhile."""
    rows = [["increments", "unlike: radius that sticks / contact radius", "like, both loads at once: displacement, %"]]
    cells, together = 16, 0.5
    pressed, normal = make_ball(cells, (STEEL, rc.Rigid()), (0.3, 0.2))
    friction = 0.6 * pressed.shear_convolution.setup.kernel.pair.beta
    pushed, force = make_ball(cells, (STIFF, STIFF), (0.3, 0.2))
    exact = together * FRICTION * (cells * CELL) ** 2 / RADIUS
    for count in (1, 2, 4, 8, 16, "auto"):
        (alone,) = pressed.path(
            force=[normal], tangential_force=[(0.0, 0.0)], friction=friction, substeps=count
        ).numbers
        (both,) = pushed.path(
            force=[force], tangential_force=[(together * FRICTION * force, 0.0)], friction=FRICTION, substeps=count
        ).numbers
        area = math.pi * (cells * CELL) ** 2
        rows.append(
            [
                str(count),
                f"{math.sqrt(alone.stick_area.value / area):.2f}",
                f"{100.0 * (both.displacement[0].value / exact - 1.0):+.1f}",
            ]
        )
    rows.append(["punch", f"{measure_punch(friction):.2f}", ""])
    return rows


def measure_punch(friction: float, cells: int = 32) -> float:
    """Return the radius that sticks over that of a flat punch: that of a ball too, whose contact grows alike."""
    count = 2 * math.ceil(1.25 * cells) + 4
    axis = np.arange(count) - 0.5 * (count - 1)
    inside = np.hypot(axis[:, np.newaxis] - 0.3, axis - 0.2) <= cells
    punch = rc.HeightMap(np.where(inside, 0.0, -1e-4), size=count * CELL)
    problem = rc.ContactProblem(rc.Body(punch, STEEL), rc.Body(rc.FlatSurface(), rc.Rigid()), threads=1)
    force = 1e-3 * problem.plan.modulus * (cells * CELL) ** 2
    path = problem.path(force=[force], tangential_force=[(0.0, 0.0)], friction=friction, substeps=1)
    return math.sqrt(np.count_nonzero(path[0].stick) / np.count_nonzero(inside))


def make_cost_rows() -> list[list[str]]:
    rows = [
        [
            "contact, %",
            "like: iterations",
            "tangential solve, normal solves",
            "unlike: iterations",
            "step, normal solves",
        ]
    ]
    for pressure in some_of((0.001, 0.0025, 0.005), 0):
        like = make_rough(STEEL, STEEL, 512)
        force = pressure * like.plan.modulus * like.plan.grid.area
        contact = like.solve(force=force)
        normal = measure_cpu(lambda problem=like, force=force: problem.solve(force=force))
        task = make_task(like, contact, 0.5 * FRICTION * force, coupled=False, tolerance=1e-5)
        found = ProjectedShearCG().solve(like.shear_convolution, task)
        alone = measure_cpu(lambda problem=like, task=task: ProjectedShearCG().solve(problem.shear_convolution, task))
        unlike = make_rough(STEEL, ALUMINIUM, 512)
        force = pressure * unlike.plan.modulus * unlike.plan.grid.area
        loads = {"force": [force], "tangential_force": [(0.5 * FRICTION * force, 0.0)]}
        state = unlike.path(**loads, friction=FRICTION, substeps=1)[0]
        before = measure_cpu(lambda problem=unlike, force=force: problem.solve(force=force))
        step = measure_cpu(
            lambda problem=unlike, loads=loads: problem.path(**loads, friction=FRICTION, substeps=1), repeats=1
        )
        rows.append(
            [
                f"{100.0 * np.mean(contact.contact):.0f}",
                str(found.iterations),
                f"{alone / normal:.1f}",
                str(state.sheared.iterations),
                f"{step / before:.1f}",
            ]
        )
    return rows


def measure_cpu(compute: Callable[[], object], repeats: int = 3) -> float:
    """Return the smallest CPU time, s: another process on the machine only adds to it."""
    times = []
    for _ in some_of(range(repeats), 0):
        begin = time.process_time()
        compute()
        times.append(time.process_time() - begin)
    return min(times)


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
    zones = np.where(state.contact, np.where(state.stick, 1.0, 2.0), np.nan)
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
    "friction-balls": DocTable(make_ball_rows, seconds=8, shown=pick(lines=("4", "8", "32"))),
    "friction-increments": DocTable(
        make_increment_rows, seconds=7, shown=pick(lines=("1", "4", "16", "auto", "punch"))
    ),
    "friction-unlike": DocTable(make_unlike_rows, seconds=30),
    "friction-frozen": DocTable(
        make_frozen_rows,
        seconds=2,
        shown=pick(
            ["β", "normal", "cone", "slip", "displacement, %", "beyond the limit, % of the force"],
            ["0.29; frozen cone", "0.50; frozen cone"],
        ),
    ),
    "friction-cost": DocTable(
        make_cost_rows,
        seconds=25,
        timed=("tangential solve, normal solves", "step, normal solves"),
        units=2,
        shown=pick(lines=("5", "21")),
    ),
}

if __name__ == "__main__":
    write_tables(TABLES)
    draw()
