"""Errors and uncertainties of the responses on classes of contacts with known answers, and of unkind geometry.

    python benchmarks/response_classes.py [--classes stiffness,leakage] [--split held-out] [--groups] [--worst 3]

Domains up to 8 : 1 and 1 : 8, cells 1 : 3 and 3 : 1, odd, prime and composite numbers of cells, free and periodic
boundaries, centres anywhere. Answers are closed forms, or those of the same contact on a grid four times as fine;
under tangential forces those of tractions that minimize the energy (`tangential_reference.py`). Constants are set on
the split tuned; held-out and fresh have other seeds. E* = 1 Pa.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from area_classes import HEADER, SPLITS, print_rows
from contact_classes import generator, log_uniform
from scipy.optimize import minimize_scalar
from scipy.special import ellipe, ellipk
from tangential_reference import TangentialKernel, slide, tangential_ratio

import roughcontact as rc
from roughcontact.reference import hertz_elliptic

CASES = 20  # of each class and split
FINE = 4  # times as many cells a side in reference solves
FRICTION = 0.3
LOADS = (0.004, 0.4)  # mean pressure over E* times the rms slope: some 1 to 60 % contact

Ask = Callable[[rc.ContactSolution], Any]


class Case(NamedTuple):
    """A contact, what is asked of it, and the true answer with its relative standard deviation."""

    problem: rc.ContactProblem
    load: dict[str, float]
    ask: Ask
    true: float
    std: float
    label: str
    group: str


def like(poisson: float) -> rc.Elastic:
    """Return the material of two like bodies with E* = 1 Pa."""
    return rc.Elastic(2.0 * (1.0 - poisson * poisson), poisson)


def press(
    surface: rc.HeightMap | rc.ParaboloidSurface | Any, grid: rc.Grid, poisson: float, **more: Any
) -> rc.ContactProblem:
    bodies = rc.Body(surface, like(poisson)), rc.Body(rc.FlatSurface(), like(poisson))
    return rc.ContactProblem(*bodies, grid=grid, threads=1, **more)


def press_unlike(
    surface: rc.HeightMap | rc.ParaboloidSurface | Any, grid: rc.Grid, poisson: float, **more: Any
) -> rc.ContactProblem:
    """Return the problem of unlike bodies with E* = 1 Pa, the counterbody three times as stiff."""
    bodies = [rc.Elastic(factor * (1.0 - ratio * ratio), ratio) for factor, ratio in ((4 / 3, poisson), (4.0, 0.45))]
    return rc.ContactProblem(
        rc.Body(surface, bodies[0]), rc.Body(rc.FlatSurface(), bodies[1]), grid=grid, threads=1, **more
    )


def on_axis(poisson: float) -> float:
    """Return the maximum von Mises stress below Hertz's ball over the maximum pressure; Johnson, eq. 3.45."""

    def negative(z: float) -> float:
        normal = -1.0 / (1.0 + z * z)
        return normal - (-(1.0 + poisson) * (1.0 - z * math.atan(1.0 / z)) - 0.5 * normal)

    return -float(minimize_scalar(negative, bounds=(0.1, 1.5), method="bounded", options={"xatol": 1e-9}).fun)


def ask_response(name: str, **arguments: Any) -> Ask:
    return lambda solution: solution.response(rc.responses.create(name, **arguments))


# --- Hertz's contacts -------------------------------------------------------------------------------------------------


class Hertzian(NamedTuple):
    """A paraboloid on a grid, its force, the semi-axes of its contact along x and y, and approach and pressure."""

    surface: rc.ParaboloidSurface
    grid: rc.Grid
    force: float
    axes: tuple[float, float]
    approach: float
    p_max: float
    label: str

    @property
    def stiffness(self) -> float:
        """Return dF/d(approach)."""
        return 1.5 * self.force / self.approach

    def mean_cosine(self, axis: int) -> float:
        """Return the mean of cos^2 of the angle of its waves to an axis; Mindlin (1949)."""
        long, short = max(self.axes), min(self.axes)
        m = 1.0 - (short / long) ** 2
        if m < 1e-6:
            return 0.5
        along_short = float((ellipk(m) - ellipe(m)) / (m * ellipk(m)))
        return along_short if self.axes[axis] == short else 1.0 - along_short


def draw_hertzian(random: np.random.Generator, number: int, ratio: float) -> Hertzian:
    """Draw a paraboloid whose contact has a minor semi-axis of 2 to 12 cells."""
    sides = (1.0, (1.0, 3.0, 1.0 / 3.0)[number % 3])
    minor = log_uniform(random, 2.0, 12.0) * max(sides)
    radii = (1e3 * minor, ratio * 1e3 * minor) if number % 2 else (ratio * 1e3 * minor, 1e3 * minor)
    unit = hertz_elliptic(1.0, radii, 1.0)
    force = (minor / min(unit.semi_axes)) ** 3
    exact = hertz_elliptic(force, radii, 1.0)
    axes = (min(exact.semi_axes), max(exact.semi_axes))
    axes = axes if radii[0] <= radii[1] else axes[::-1]
    cells = [2 * math.ceil(1.1 * axis / side) + 5 for axis, side in zip(axes, sides, strict=True)]
    longer = (number // 3) % 3
    if longer < 2:
        # A domain of 8 : 1 or 1 : 8, if the grid is not too large for it.
        extent = cells[1 - longer] * sides[1 - longer] * 8
        cells[longer] = max(cells[longer], min(int(extent / sides[longer]), 500))
    cells = [count + int(random.integers(0, 3)) for count in cells]
    room = [0.5 * n * side - axis - 1.5 * side for n, side, axis in zip(cells, sides, axes, strict=True)]
    center = tuple(float(random.uniform(-part, part)) for part in room)
    grid = rc.Grid((cells[0], cells[1]), (cells[0] * sides[0], cells[1] * sides[1]))
    label = f"{cells[0]} x {cells[1]} cells of 1 x {sides[1]:.2g}, axes {axes[0]:.3g} {axes[1]:.3g}, {number}"
    return Hertzian(rc.ParaboloidSurface(radii, center), grid, force, axes, exact.approach, exact.p_max, label)


def hertz(kind: str, split: str) -> Iterator[Case]:
    """Ellipses up to 12 : 1; balls for the stress and the film."""
    random = generator("response", kind, split)
    for number in range(CASES):
        ratio = 1.0 if kind in ("stress", "first-yield", "film") or number % 4 == 0 else log_uniform(random, 1.2, 40.0)
        scene = draw_hertzian(random, number, ratio)
        poisson = float(random.uniform(0.0, 0.5)) if kind != "stress" else float(random.uniform(0.1, 0.45))
        ask, true, std = ANSWERS[kind](scene, poisson, random)
        problem = press(scene.surface, scene.grid, poisson)
        yield Case(problem, {"force": scene.force}, ask, true, std, scene.label, f"cells {scene.grid.spacing[1]:.2g}")


def hertz_stiffness(scene: Hertzian, poisson: float, random: np.random.Generator) -> tuple[Ask, float, float]:
    return ask_response("stiffness"), scene.stiffness, 0.0


def hertz_tangential(scene: Hertzian, poisson: float, random: np.random.Generator) -> tuple[Ask, float, float]:
    axis = int(random.integers(2))
    ratio = (1.0 - poisson) / (1.0 - poisson * scene.mean_cosine(axis))
    return ask_response("tangential-stiffness", axis=axis), ratio * scene.stiffness, 0.0


def hertz_conductance(scene: Hertzian, poisson: float, random: np.random.Generator) -> tuple[Ask, float, float]:
    return ask_response("conductance", conductivity=(1.0, 3.0)), 1.5 * scene.stiffness, 0.0


_FILMS: dict[float, float] = {}


def hertz_film(scene: Hertzian, poisson: float, random: np.random.Generator) -> tuple[Ask, float, float]:
    """Return the answer for one of six films: that of a ball of 40 cells radius."""
    relative = (0.01, 0.1, 0.3, 1.0, 10.0, 1e3)[int(random.integers(6))]
    if relative not in _FILMS:
        surface = rc.ParaboloidSurface(4e4, (0.2, 0.3))
        ball = press(surface, rc.Grid((95, 95), 95.0), 0.0).solve(force=4 / 3 * 40.0**3 / 4e4)
        _FILMS[relative] = ball.conductance(1.0, 40.0 * relative).value / 40.0
    radius = scene.axes[0]
    return (
        ask_response("conductance", conductivity=1.0, film_resistance=relative * radius),
        _FILMS[relative] * radius,
        1e-4,
    )


def hertz_stress(scene: Hertzian, poisson: float, random: np.random.Generator) -> tuple[Ask, float, float]:
    return lambda solution: solution.stress().maximum, on_axis(poisson) * scene.p_max, 0.0


def hertz_yield(scene: Hertzian, poisson: float, random: np.random.Generator) -> tuple[Ask, float, float]:
    strength = on_axis(poisson) * scene.p_max * float(random.uniform(0.8, 1.1))
    force = scene.force * (strength / on_axis(poisson) / scene.p_max) ** 3
    return lambda solution: solution.first_yield(strength).force, force, 0.0


def hertz_partial_slip(scene: Hertzian, poisson: float, random: np.random.Generator) -> tuple[Ask, float, float]:
    axis, sliding = int(random.integers(2)), float(random.uniform(0.1, 0.95))
    ratio = (1.0 - poisson * scene.mean_cosine(axis)) / (1.0 - poisson)
    moved = FRICTION * ratio * scene.approach * (1.0 - (1.0 - sliding) ** (2 / 3))
    force = sliding * FRICTION * scene.force

    def ask(solution: rc.ContactSolution) -> Any:
        return solution.partial_slip(tangential_force=force, friction=FRICTION, axis=axis).displacement

    # The closed form has all traction along the force.
    return ask, moved, 0.01 * poisson**2


ANSWERS: dict[str, Callable[[Hertzian, float, np.random.Generator], tuple[Ask, float, float]]] = {
    "stiffness": hertz_stiffness,
    "tangential": hertz_tangential,
    "conductance": hertz_conductance,
    "film": hertz_film,
    "stress": hertz_stress,
    "first-yield": hertz_yield,
    "partial-slip": hertz_partial_slip,
}


# --- rough contacts ---------------------------------------------------------------------------------------------------


def draw_rough(
    random: np.random.Generator, number: int, per_wave: tuple[float, float]
) -> tuple[Any, list[rc.Grid], str, float]:
    """Draw a self-affine surface, a grid and one FINE times as fine, a boundary, and the cells a shortest wave."""
    sides = (1.0, (1.0, 3.0, 1.0 / 3.0)[number % 3])
    cells_per_wave = log_uniform(random, *per_wave)
    waves = (8.0, (8.0, 2.0, 6.0)[(number // 3) % 3])
    waves = waves if number % 2 else waves[::-1]
    # The longer side of a cell resolves the waves.
    wave = cells_per_wave * max(sides)
    cells = [
        max(round(part * wave / side), 8) + int(random.integers(0, 2)) for part, side in zip(waves, sides, strict=True)
    ]
    size = cells[0] * sides[0], cells[1] * sides[1]
    surface = rc.SelfAffineSurface(
        hurst=float(random.uniform(0.4, 0.9)),
        rms_slope=0.1,
        shortest=wave,
        longest=max(size) / 2,
        seed=int(random.integers(2**31)),
    )
    grids = [rc.Grid((factor * cells[0], factor * cells[1]), size) for factor in (1, FINE)]
    return surface, grids, ("periodic", "free")[(number // 2) % 2], cells_per_wave


def rough(
    kind: str, split: str, per_wave: tuple[float, float] = (4.0, 9.0), loads: tuple[float, float] = LOADS
) -> Iterator[Case]:
    """Rough surfaces of 4 to 9 cells a shortest wave."""
    random = generator("response rough", kind, per_wave, loads, split)
    number = found = 0
    while found < CASES and number < 3 * CASES:
        surface, grids, boundary, per_wave_drawn = draw_rough(random, number, per_wave)
        number += 1
        poisson = float(random.uniform(0.0, 0.5))
        pressure = 0.1 * log_uniform(random, *loads)
        pair = press_unlike if kind == "unlike" else press
        problem, fine = (pair(surface, grid, poisson, boundary=boundary) for grid in grids)
        ask, true, std = ROUGH[kind](fine.solve(pressure=pressure), poisson, random)
        if not true > 0.0:
            continue
        found += 1
        label = (
            f"{grids[0].shape} of {grids[0].spacing[1]:.2g}, {boundary}, {pressure:.3g} Pa, nu {poisson:.2f}, {number}"
        )
        yield Case(problem, {"pressure": pressure}, ask, true, std, label, f"c < {4 * math.ceil(per_wave_drawn / 4)}")


def rough_same(ask: Ask) -> Callable[..., tuple[Ask, float, float]]:
    """Return the answer of the fine grid."""

    def answer(fine: rc.ContactSolution, poisson: float, random: np.random.Generator) -> tuple[Ask, float, float]:
        found = ask(fine)
        return ask, found.value, found.uncertainty / found.value if found.value > 0.0 else 0.0

    return answer


def rough_tangential(fine: rc.ContactSolution, poisson: float, random: np.random.Generator) -> tuple[Ask, float, float]:
    axis, periodic = int(random.integers(2)), fine.boundary == "periodic"
    ratio = tangential_ratio(fine.contact, fine.grid.spacing, poisson, axis, periodic)
    normal = fine.stiffness()
    return ask_response("tangential-stiffness", axis=axis), ratio * normal.value, normal.uncertainty / normal.value


def rough_unlike(fine: rc.ContactSolution, poisson: float, random: np.random.Generator) -> tuple[Ask, float, float]:
    return rough_same(ask_response("tangential-stiffness", axis=int(random.integers(2))))(fine, poisson, random)


def rough_film(fine: rc.ContactSolution, poisson: float, random: np.random.Generator) -> tuple[Ask, float, float]:
    film = fine.grid.spacing[0] * log_uniform(random, 0.1, 1e3)
    return rough_same(ask_response("conductance", conductivity=1.0, film_resistance=film))(fine, poisson, random)


def rough_leakage(fine: rc.ContactSolution, poisson: float, random: np.random.Generator) -> tuple[Ask, float, float]:
    axis = int(random.integers(2))
    return rough_same(ask_response("leakage", axis=axis, viscosity=1.0, pressure_drop=1.0))(fine, poisson, random)


def rough_yield(fine: rc.ContactSolution, poisson: float, random: np.random.Generator) -> tuple[Ask, float, float]:
    strength = fine.stress().maximum.value
    return rough_same(lambda solution: solution.first_yield(strength).force)(fine, poisson, random)


def rough_partial_slip(
    fine: rc.ContactSolution, poisson: float, random: np.random.Generator
) -> tuple[Ask, float, float]:
    axis, sliding = int(random.integers(2)), float(random.uniform(0.1, 0.95))
    near = fine.partial_slip(tangential_force=sliding * FRICTION * fine.force, friction=FRICTION, axis=axis)
    kernel = TangentialKernel(fine.grid.shape, fine.grid.spacing, poisson, axis, fine.boundary == "periodic")
    traction = slide(kernel, FRICTION * fine.pressure, near.displacement.value, near.traction)
    force = float(traction[0].sum()) * fine.grid.cell_area

    def ask(solution: rc.ContactSolution) -> Any:
        return solution.partial_slip(tangential_force=force, friction=FRICTION, axis=axis).displacement

    # Without coupling the solution by normal contacts is exact: it tells the error of the fine grid.
    return ask, near.displacement.value, 2e-3


ROUGH: dict[str, Callable[[rc.ContactSolution, float, np.random.Generator], tuple[Ask, float, float]]] = {
    "stiffness": rough_same(ask_response("stiffness")),
    "tangential": rough_tangential,
    "unlike": rough_unlike,
    "conductance": rough_same(ask_response("conductance", conductivity=1.0)),
    "film": rough_film,
    "stress": rough_same(lambda solution: solution.stress().maximum),
    "first-yield": rough_yield,
    "leakage": rough_leakage,
    "partial-slip": rough_partial_slip,
}

CLASSES: dict[str, Callable[[str], Iterator[Case]]] = {
    **{f"{kind}-hertz": partial(hertz, kind) for kind in ANSWERS},
    **{f"{kind}-rough": partial(rough, kind) for kind in ROUGH if kind != "leakage"},
    "leakage-open": partial(rough, "leakage", loads=(0.004, 0.1)),
    "leakage-tight": partial(rough, "leakage", loads=(0.1, 0.3)),
}


# --- table ------------------------------------------------------------------------------------------------------------


def judge_cases(name: str, split: str) -> list[tuple[float, float, float, Case]]:
    """Return relative error, stated relative uncertainty, that of the true value, and the case."""
    rows = []
    for case in CLASSES[name](split):
        found = case.ask(case.problem.solve(**case.load))
        stated = math.hypot(found.uncertainty / case.true, case.std)
        warned = " WARNED" if found.warnings else ""
        rows.append((found.value / case.true - 1.0, stated, case.std, case._replace(label=case.label + warned)))
    return rows


def report(names: Sequence[str], split: str, *, groups: bool = False, worst: int = 0) -> dict[str, dict[str, float]]:
    """Print the table and return its rows by class, with the largest error that has no warning."""
    print(f"{split}\n{HEADER}")
    table = {}
    for name in names:
        rows = judge_cases(name, split)
        table[name] = print_rows(name, rows, groups=groups, worst=worst)
        table[name]["unwarned"] = max((abs(row[0]) for row in rows if "WARNED" not in row[3].label), default=0.0)
        table[name]["warned"] = float(np.mean(["WARNED" in row[3].label for row in rows]))
    print(f"classes below 93 % within two: {[name for name, row in table.items() if row['within 2'] < 0.93]}")
    return table


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--classes", default="all")
    parser.add_argument("--split", default="tuned", choices=SPLITS)
    parser.add_argument("--groups", action="store_true")
    parser.add_argument("--worst", type=int, default=0)
    options = parser.parse_args(arguments)
    wanted = tuple(options.classes.split(","))
    names = [name for name in CLASSES if options.classes == "all" or name.startswith(wanted)]
    report(names, options.split, groups=options.groups, worst=options.worst)


if __name__ == "__main__":
    main()
