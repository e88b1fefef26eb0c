"""Error against run time on the paper's wave at 100 MPa: one solve on N x N cells, each area estimator.

Writes docs/figures/error_vs_time.png and prints the table of the README. Times are CPU times of the
whole solve and its area, kernel included, medians over repeats after a warm-up.

    python docs/studies/error_vs_time.py
"""

from __future__ import annotations

import statistics
import time
from pathlib import Path

from matplotlib.figure import Figure

import roughcontact as rc
from roughcontact.paper import printed

FIGURES = Path(__file__).parent.parent / "figures"
GRIDS = (64, 128, 256, 512, 1024)
REPEATS = 5
NAMES = ("cell-count", "perimeter", "blend")


def problem(cells: int) -> rc.ContactProblem:
    """Twenty whole waves on a truly periodic domain: no sampling tricks."""
    surface = rc.WavySurface(amplitude=0.5e-6, wavelength=12.5e-6)
    body = rc.Body(surface, rc.Elastic(young=200e9, poisson=0.3))
    return rc.ContactProblem(body, grid=rc.Grid((cells, cells), 250e-6), boundary="periodic")


def measure(cells: int, repeats: int = REPEATS) -> dict[str, float]:
    """Errors in percent and the median CPU time in seconds."""
    times = []
    for _ in range(repeats + 1):
        started = time.process_time()
        solution = problem(cells).solve(pressure=100e6)
        solution.area()
        times.append(time.process_time() - started)
    errors = {name: 100 * (100 * solution.area(name).fraction / printed.TRUE_AREA[100] - 1) for name in NAMES}
    bars = {
        f"{name} bar": 100 * 100 * solution.area(name).uncertainty / solution.grid.area / printed.TRUE_AREA[100]
        for name in NAMES
    }
    p_max = 100 * (solution.pressure.max() / 1e9 / printed.TRUE_P_MAX[100] - 1)
    return {"cpu": statistics.median(times[1:]), "p_max": p_max, "iterations": solution.iterations, **errors, **bars}


def table(rows: dict[int, dict[str, float]]) -> str:
    lines = [
        "| N | CPU time, s | iterations | cell count, % | perimeter, % (its bar) "
        "| blend, % (its bar) | maximum pressure, % |",
        "|---|---|---|---|---|---|---|",
    ]
    lines += [
        f"| {cells} | {row['cpu']:.3f} | {row['iterations']} | {row['cell-count']:+.1f} "
        f"| {row['perimeter']:+.1f} (± {row['perimeter bar']:.1f}) "
        f"| {row['blend']:+.2f} (± {row['blend bar']:.2f}) | {row['p_max']:+.2f} |"
        for cells, row in rows.items()
    ]
    return "\n".join(lines)


def draw(rows: dict[int, dict[str, float]], path: Path) -> None:
    figure = Figure(figsize=(6, 4.2), layout="constrained")
    axes = figure.subplots()
    cpu = [row["cpu"] for row in rows.values()]
    for name, style in (("cell-count", "o-"), ("perimeter", "s-"), ("blend", "D-"), ("p_max", "^-")):
        label = "maximum pressure" if name == "p_max" else f"area, {name}"
        axes.loglog(cpu, [abs(row[name]) for row in rows.values()], style, label=label)
    for cells, row in rows.items():
        axes.annotate(f"N = {cells}", (row["cpu"], abs(row["cell-count"])), xytext=(4, 6), textcoords="offset points")
    axes.set_xlim(right=3 * max(cpu))
    axes.set(xlabel="CPU time of one solve, s", ylabel="error against the converged answer, %")
    axes.grid(alpha=0.3, which="both")
    axes.legend()
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=150)


def main(grids: tuple[int, ...] = GRIDS, repeats: int = REPEATS, folder: Path = FIGURES) -> None:
    rows = {cells: measure(cells, repeats) for cells in grids}
    print(table(rows))
    draw(rows, folder / "error_vs_time.png")


if __name__ == "__main__":
    main()
