"""The tables and the figure of docs/use/stress.md: the stress below balls and rough surfaces, and its cost.

python docs/studies/stress.py          # the tables
python docs/studies/stress.py figure   # docs/figures/stress.png
"""

from __future__ import annotations

import sys
import time
import tracemalloc
from pathlib import Path

import numpy as np
from doc_tables import DocTable, pick, some_of, write_tables
from matplotlib.figure import Figure
from scipy import optimize

import roughcontact as rc
from roughcontact.plotting import LIGHT, style
from roughcontact.reference import SlidingSphere, hertz_sphere
from roughcontact.responses import StressMaximum

FIGURES = Path(__file__).parent.parent / "figures"
STEEL = rc.Elastic(young=200e9, poisson=0.3)


def find_maximum_shear() -> tuple[float, float]:
    """Return the maximum shear stress on Hertz's axis over p0, and its depth over the radius; Johnson (1985), 3.45."""

    def negative(z: float) -> float:
        axial = -1.0 / (1.0 + z * z)
        radial = -(1.0 + STEEL.poisson) * (1.0 - z * np.arctan(1.0 / z)) - 0.5 * axial
        return 0.5 * (axial - radial)

    found = optimize.minimize_scalar(negative, bounds=(0.1, 1.0), method="bounded", options={"xatol": 1e-9})
    return -float(found.fun), float(found.x)


def press_ball(cells: float, rng: np.random.Generator) -> tuple[rc.ContactSolution, float, float]:
    """Return the contact of a ball at a random place with so many cells in its radius, its p0 and its radius."""
    spacing, radius, modulus = 4e-6, 1e-2, 1.0 / STEEL.compliance
    sides, count = (1.0, float(rng.uniform(0.7, 1.0))), int(2.6 * cells) + 8
    shape = (count, int(count / sides[1]))
    force = 4.0 * modulus * (cells * spacing) ** 3 / (3.0 * radius)
    ball = rc.ParaboloidSurface(radius, center=tuple(spacing * rng.uniform(-0.5, 0.5, 2)))
    size = tuple(n * side * spacing for n, side in zip(shape, sides, strict=True))
    problem = rc.ContactProblem(rc.Body(ball, STEEL), grid=rc.Grid(shape, size), threads=1)
    hertz = hertz_sphere(force, radius, modulus)
    return problem.solve(force=force), hertz.p_max, hertz.semi_axes[0]


def list_balls() -> list[list[str]]:
    rows = [["cells in the radius", "maximum shear: mean, std, %", "stated, %", "within 2 std", "depth: mean, std, %"]]
    shear, lowest = find_maximum_shear()
    for cells in some_of((1.5, 3, 6, 12, 16, 24), 0, 1, 2):
        rng, values = np.random.default_rng(200), []
        for _ in range(12):
            solution, p0, radius = press_ball(cells, rng)
            found = solution.stress().maximum_shear
            values.append((found.value / p0 / shear, found.uncertainty / p0 / shear, found.depth / radius / lowest))
        value, stated, depth = (100.0 * column for column in np.array(values).T)
        within = np.mean(np.abs(value - 100.0) < 2.0 * stated)
        rows.append(
            [
                f"{cells:g}",
                f"{value.mean() - 100.0:.2f}, {value.std():.2f}",
                f"{np.median(stated):.2g}",
                f"{within:.2f}",
                f"{depth.mean() - 100.0:.1f}, {depth.std():.1f}",
            ]
        )
    return rows


def find_largest_sliding(friction: float) -> float:
    """Return the maximum von Mises stress below Hamilton's ball over p0, in the plane of sliding."""
    sphere = SlidingSphere(1.0, 1.0, friction, STEEL.poisson)

    def measure(x: float, z: float) -> float:
        xx, yy, zz, yz, xz, xy = sphere.stress(x, 0.0, z)
        normal = 0.5 * ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2)
        return float(np.sqrt(normal + 3.0 * (yz**2 + xz**2 + xy**2)))

    found = optimize.minimize(lambda place: -measure(place[0], abs(place[1])), (friction, 0.45), method="Nelder-Mead")
    return max(-float(found.fun), measure(-1.0, 0.0))


def list_sliding() -> list[list[str]]:
    """Return the errors below a sliding ball with 16 cells in its radius, in % of p0, and of its first yield."""
    depths = (0.5, 1, 2, 4, 8)
    errors = [f"at {depth:g}, % of p0" for depth in depths]
    rows = [["cells", "friction", *errors, "first yield: error, %", "stated, %", "its depth, radii"]]
    modulus, radius, spacing = 1.0 / STEEL.compliance, 1e-2, 4e-6
    force = 4.0 * modulus * (16.0 * spacing) ** 3 / (3.0 * radius)
    hertz = hertz_sphere(force, radius, modulus)
    place = spacing * np.array((0.31, -0.17))
    body = rc.Body(rc.ParaboloidSurface(radius, center=tuple(place)), STEEL)
    for shape, sides in (((48, 45), (1, 1)), ((17, 49), (3, 1))):
        size = tuple(spacing * n * side for n, side in zip(shape, sides, strict=True))
        solution = rc.ContactProblem(body, grid=rc.Grid(shape, size), threads=1).solve(force=force)
        x, y = solution.grid.x - place[0], solution.grid.y - place[1]
        for friction in (0.1, 0.25, 0.5):
            sphere = SlidingSphere(hertz.semi_axes[0], 1.0, friction, STEEL.poisson)
            planes = solution.stress([depth * max(solution.grid.spacing) for depth in depths], friction=friction)
            largest = [
                float(np.abs(plane / hertz.p_max - sphere.stress(x, y, depth)).max())
                for depth, plane in zip(planes.depths, planes.components, strict=True)
            ]
            found = solution.first_yield(find_largest_sliding(friction) * hertz.p_max, friction=friction)
            rows.append(
                [
                    f"{sides[0]} : {sides[1]}",
                    f"{friction:g}",
                    *(f"{100.0 * error:.2g}" for error in largest),
                    f"{100.0 * (found.force.value / force - 1.0):.2g}",
                    f"{100.0 * found.force.uncertainty / found.force.value:.2g}",
                    f"{found.maximum.depth / hertz.semi_axes[0]:.2f}",
                ]
            )
    return rows


def list_edges() -> list[list[str]]:
    """Return the errors of the maximum principal stress at the surface, behind sliding balls and rough surfaces."""
    rows = [["cells in the", "friction", "error: median, largest, %", "stated, %", "within 2 std"]]
    rng = np.random.default_rng(205)
    for cells in some_of((1.5, 3, 6, 16), 0, 1):
        for friction in (0.1, 0.5):
            tension = (1.0 - 2.0 * STEEL.poisson) / 3.0 + np.pi * (4.0 + STEEL.poisson) / 8.0 * friction
            pairs = []
            for _ in range(12):
                solution, p0, _ = press_ball(cells, rng)
                found = solution.stress(friction=friction, direction=float(rng.uniform(0.0, 360.0))).maximum_principal
                pairs.append((found, tension * p0))
            rows.append([f"radius: {cells:g}", f"{friction:g}", *list_errors(pairs)])
    scenes = [(seed, hurst, load, 1 + seed % 2) for seed, (hurst, load) in enumerate(EDGE_SCENES, 90)]
    exact = [solve_rough(800, *scene) for scene in scenes]
    for cells in some_of((80, 160, 240), 1):
        solutions = [solve_rough(cells, *scene) for scene in scenes]
        for friction in (0.1, 0.5):
            pairs = [
                tuple(one.stress([0.0], friction=friction).maximum_principal for one in pair)
                for pair in zip(solutions, exact, strict=True)
            ]
            pairs = [(found, true.value) for found, true in pairs]
            rows.append([f"shortest wave: {cells // 10}", f"{friction:g}", *list_errors(pairs)])
    return rows


EDGE_SCENES = ((0.8, 0.02), (0.5, 0.05), (0.8, 0.2), (0.3, 0.1)) * 2


def list_errors(pairs: list[tuple[StressMaximum, float]]) -> list[str]:
    error = np.array([abs(found.value / true - 1.0) for found, true in pairs])
    stated = np.array([found.uncertainty / true for found, true in pairs])
    return [
        f"{100 * np.median(error):.2g}, {100 * error.max():.2g}",
        f"{100 * np.median(stated):.2g}",
        f"{np.mean(error < 2.0 * stated):.2f}",
    ]


def solve_rough(cells: int, seed: int, hurst: float, load: float, aspect: int) -> rc.ContactSolution:
    surface = rc.SelfAffineSurface(hurst=hurst, rms_slope=0.05, shortest=1e-4, longest=1e-3, rolloff=3e-4, seed=seed)
    grid = rc.Grid((cells // aspect, cells), 1e-3)
    problem = rc.ContactProblem(rc.Body(surface, STEEL), grid=grid, boundary="periodic", threads=1)
    return problem.solve(pressure=load * 0.05 / STEEL.compliance)


def list_rough() -> list[list[str]]:
    scenes = [
        (seed, hurst, load, aspect)
        for seed, (hurst, load, aspect) in enumerate(
            ((0.8, 0.02, 1), (0.5, 0.05, 1), (0.8, 0.2, 1), (0.3, 0.1, 2)) * 2, 70
        )
    ]
    exact = [solve_rough(480, *scene).stress().maximum for scene in scenes]
    rows = [["cells in the shortest wave", "depth, cells", "error: median, largest, %", "stated, %", "within 2 std"]]
    for cells in some_of((40, 80, 160, 240), 0, 1):
        found = [solve_rough(cells, *scene).stress().maximum for scene in scenes]
        depth = [one.depth / (1e-3 * scene[3] / cells) for one, scene in zip(found, scenes, strict=True)]
        pairs = [(one, true.value) for one, true in zip(found, exact, strict=True)]
        rows.append([f"{cells // 10}", f"{min(depth):.1f} .. {max(depth):.1f}", *list_errors(pairs)])
    return rows


def list_costs() -> list[list[str]]:
    rows = [["cells", "boundary", "depths", "CPU, s", "memory, MiB"]]
    for cells in (256, 1024):
        surface = rc.SelfAffineSurface(
            hurst=0.8, rms_slope=0.05, shortest=8e-6, longest=1e-6 * cells, rolloff=2.5e-7 * cells, seed=4
        )
        for boundary in ("free", "periodic"):
            grid = rc.Grid((cells, cells), 1e-6 * cells)
            problem = rc.ContactProblem(rc.Body(surface, STEEL), grid=grid, boundary=boundary, threads=1)
            solution = problem.solve(pressure=100e6)
            for count in (8, 64):
                depths = np.geomspace(1e-6, 0.25 * grid.size[0], count)
                started = time.process_time()
                _ = solution.stress(depths).maximum
                spent = time.process_time() - started
                tracemalloc.start()
                for _ in solution.stress(depths):
                    pass
                peak = tracemalloc.get_traced_memory()[1] / 2**20
                tracemalloc.stop()
                rows.append([f"{cells} x {cells}", boundary, f"{count}", f"{spent:.1f}", f"{peak:.0f}"])
    return rows


@style()
def draw(folder: Path = FIGURES) -> None:
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.06, shortest=6e-6, longest=60e-6, rolloff=30e-6, seed=7)
    grid = rc.Grid((384, 384), 100e-6)
    problem = rc.ContactProblem(rc.Body(surface, STEEL), grid=grid, boundary="periodic", threads=1)
    solution = problem.solve(pressure=1.2e9)
    stress = solution.stress(np.linspace(0.0, 10e-6, 101))
    maximum = solution.stress().maximum
    row = int(np.argmin(np.abs(grid.x[:, 0] - maximum.x)))
    cut = stress.von_mises[:, row] / 1e9
    figure = Figure(figsize=(11, 4.6), layout="constrained")
    pressure, field = figure.subplots(2, 1, sharex=True, height_ratios=(1, 2.2))
    y = 1e6 * grid.y[0]
    pressure.fill_between(y, solution.pressure[row] / 1e9, color=LIGHT.body)
    pressure.set(ylabel="pressure, GPa", xlim=(-50, 50), ylim=(0, None))
    image = field.imshow(cut, extent=(-50, 50, 10.05, -0.05), cmap="inferno", aspect="auto", interpolation="bilinear")
    field.plot(1e6 * maximum.y, 1e6 * maximum.depth, "+", color="black", markersize=12, markeredgewidth=2)
    field.set(xlabel="y, µm", ylabel="depth, µm")
    figure.colorbar(image, ax=field, label="von Mises stress, GPa")
    folder.mkdir(parents=True, exist_ok=True)
    figure.savefig(folder / "stress.png", dpi=110)


# What the page shows.
EDGES = ("radius: 1.5", "radius: 3", "radius: 16", "shortest wave: 8", "shortest wave: 24")
SLIDING = ("cells", "friction", "at 0.5, % of p0", "at 2, % of p0", "at 8, % of p0")
SLIDING += ("first yield: error, %", "stated, %", "its depth, radii")
TABLES = {
    "stress-balls": DocTable(list_balls, seconds=25, units=2.0, shown=pick(lines=("1.5", "3", "24"))),
    "stress-sliding": DocTable(
        list_sliding,
        seconds=8,
        units=2.0,
        shown=pick(SLIDING, [f"{cells}; {friction}" for cells in ("1 : 1", "3 : 1") for friction in ("0.1", "0.5")]),
    ),
    "stress-edges": DocTable(
        list_edges,
        seconds=60,
        units=2.0,
        shown=pick(lines=EDGES),
    ),
    "stress-rough": DocTable(list_rough, seconds=50, units=2.0, shown=pick(lines=("4", "8", "16"))),
    "stress-cost": DocTable(
        list_costs,
        seconds=90,
        timed=("CPU, s", "memory, MiB"),
        shown=pick(lines=("1024 x 1024; free; 64", "1024 x 1024; periodic; 64")),
    ),
}

if __name__ == "__main__":
    if sys.argv[1:] == ["figure"]:
        draw()
    else:
        write_tables(TABLES)
