"""A perfectly plastic ball on a flat, against an independent axisymmetric solution and against Thornton's model.

python docs/studies/capped_ball.py
"""

from __future__ import annotations

import functools
from pathlib import Path

import numpy as np
from doc_tables import DocTable, pick, some_of, write_tables
from matplotlib.figure import Figure
from scipy.special import ellipe, ellipk

import roughcontact as rc
from roughcontact.plotting import LIGHT, add_key, scale_axes, style

FIGURES = Path(__file__).parent.parent / "figures"
RADIUS, HARDNESS = 5e-3, 6e9
MODULUS = 210e9 / (2 * (1 - 0.3**2))
STEEL = rc.ElasticPerfectlyPlastic(210e9, 0.3, HARDNESS)
# Hertz's maximum pressure is the hardness at this load, contact radius and approach.
YIELD_RADIUS = np.pi * HARDNESS * RADIUS / (2 * MODULUS)
YIELD = 2 / 3 * np.pi * YIELD_RADIUS**2 * HARDNESS
YIELD_APPROACH = YIELD_RADIUS**2 / RADIUS
TIMES = (1.1, 1.5, 2.0, 3.0, 5.0, 8.0, 12.0)


def ball(cells: int, force: float, centre: tuple[float, float] = (0.0, 0.0)) -> rc.ContactSolution:
    """Return the contact on a domain of three times the larger of the elastic and the fully plastic contact radius."""
    size = 3 * max((3 * force * RADIUS / (4 * MODULUS)) ** (1 / 3), (force / (np.pi * HARDNESS)) ** 0.5)
    body = rc.Body(rc.ParaboloidSurface(RADIUS, center=np.array(centre) * size / cells), STEEL)
    flat = rc.Body(rc.FlatSurface(), STEEL)
    return rc.ContactProblem(body, flat, grid=rc.Grid((cells, cells), size)).solve(force=force)


def rings(force: float, count: int = 500) -> tuple[float, float, float]:
    """Return approach, contact area and saturated area of the paraboloid on rings of uniform pressure.

    Axisymmetric, dense, by trial of which rings are open, elastic and saturated. Displacement of a half-space
    under a uniform disc: Johnson, Contact Mechanics (1985), sec. 3.4.
    """
    edges = np.linspace(0.0, 1.6 * (3 * force * RADIUS / (4 * MODULUS)) ** (1 / 3), count + 1)
    r, s = 0.5 * (edges[1:] + edges[:-1])[:, None], edges[None, 1:]
    inside = s * ellipe(np.minimum(r / s, 1.0) ** 2)
    m = np.minimum(s / r, 1.0) ** 2
    outside = r * (ellipe(m) - (1 - m) * ellipk(np.minimum(m, 1 - 1e-15)))
    kernel = np.diff(4 / (np.pi * MODULUS) * np.where(r <= s, inside, outside), axis=1, prepend=0.0)
    areas = np.pi * np.diff(edges**2)
    gap = r[:, 0] ** 2 / (2 * RADIUS)
    full, free = np.zeros(count, dtype=bool), r[:, 0] < 0.6 * edges[-1]
    for _ in range(1000):
        p = np.where(full, HARDNESS, 0.0)
        n = int(free.sum())
        matrix = np.zeros((n + 1, n + 1))
        matrix[:n, :n], matrix[:n, n], matrix[n, :n] = kernel[np.ix_(free, free)], -1.0, areas[free]
        solved = np.linalg.solve(matrix, np.append(-(gap + kernel @ p)[free], force - p @ areas))
        p[free], approach = solved[:n], solved[n]
        opening = gap + kernel @ p - approach
        now_full = np.where(free, p > HARDNESS, full & (opening <= 0))
        now_free = np.where(free, (p >= 0) & (p <= HARDNESS), np.where(full, opening > 0, opening < 0))
        if np.array_equal(now_full, full) and np.array_equal(now_free, free):
            break
        full, free = now_full, now_free
    return approach, float(areas[full | free].sum()), float(areas[full].sum())


def thornton(force: float) -> tuple[float, float]:
    """Return approach and contact area by the truncated Hertz pressure, which keeps a^2 = R approach."""
    approach = YIELD_APPROACH + (force - YIELD) / (np.pi * RADIUS * HARDNESS)
    return approach, np.pi * RADIUS * approach


@functools.cache
def measure(cells: int = 512, count: int = 800) -> dict[float, tuple[float, ...]]:
    """Return approach, area and saturated area by the load in units of F_y: ours, and those of the rings."""
    found = {}
    for factor in some_of(TIMES, 0, 4, 6):
        solution = ball(cells, factor * YIELD, (0.3, -0.2))
        ours = solution.approach, solution.area().value, solution.saturated_area().value
        found[factor] = *ours, *rings(factor * YIELD, count)
    return found


def make_rows(cells: int = 512, count: int = 800) -> list[list[str]]:
    lines = [["F / F_y", "approach, error", "area", "saturated area", "area / (F / H)"]]
    lines[0] += ["Thornton: approach", "Thornton: area"]
    for factor, (approach, area, saturated, *exact) in measure(cells, count).items():
        truncated = thornton(factor * YIELD)
        areas = [f"{100 * (found / true - 1):+.2f} %" for found, true in ((area, exact[1]), (saturated, exact[2]))]
        load = area * HARDNESS / (factor * YIELD)
        model = [f"{100 * (truncated[k] / exact[k] - 1):+.1f} %" for k in (0, 1)]
        lines.append([f"{factor:g}", f"{approach / exact[0] - 1:+.1e}", *areas, f"{load:.4f}", *model])
    return lines


def main(cells: int = 512, count: int = 800, folder: Path = FIGURES) -> None:
    ours = np.array([found[:3] for found in measure(cells, count).values()])
    draw(np.array(TIMES), ours, folder)


def draw(times: np.ndarray, ours: np.ndarray, folder: Path) -> None:
    fine, unit = np.linspace(0.05, times[-1], 300), np.pi * YIELD_RADIUS**2
    plastic = fine[fine >= 1]
    truncated = np.array([thornton(factor * YIELD) for factor in plastic])
    with style():
        figure = Figure(figsize=(11, 4.6), layout="constrained")
        left, right = figure.subplots(1, 2)
        for axes in (left, right):
            axes.plot(fine, fine ** (2 / 3), ":", color=LIGHT.ink, label="Hertz, elastic")
        blue, orange, _, green, *_ = LIGHT.lines
        left.plot(plastic, truncated[:, 0] / YIELD_APPROACH, "--", color=green, label="truncated Hertz (Thornton)")
        left.plot(times, ours[:, 0] / YIELD_APPROACH, "o", ms=6, color=blue, label="elastic, perfectly plastic")
        right.plot(plastic, truncated[:, 1] / unit, "--", color=green, label="truncated Hertz")
        right.plot(fine, fine * YIELD / HARDNESS / unit, "-", color=LIGHT.unknown, label="load / hardness")
        right.plot(times, ours[:, 1] / unit, "o", ms=6, color=blue, label="contact")
        right.plot(times, ours[:, 2] / unit, "s", ms=6, color=orange, label="saturated")
        for axes, name in ((left, "approach / approach at first yield"), (right, "area / area at first yield")):
            scale_axes(axes, x="force / force at first yield", y=name)
            axes.set(xlim=(0, None), ylim=(0, None))
            add_key(axes)
        figure.savefig(folder / "capped_ball.png", dpi=110)


# The errors of the approach are those of the solver's tolerance.
# The columns of the page.
SHOWN = ("F / F_y", "approach, error", "area", "saturated area", "Thornton: approach", "Thornton: area")
TABLES = {"capped-ball": DocTable(make_rows, seconds=11, units=3, shown=pick(SHOWN, ("1.1", "5", "12")))}

if __name__ == "__main__":
    write_tables(TABLES)
    main()
