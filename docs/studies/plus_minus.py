"""The figure of docs/understand/uncertainty.md: whether the uncertainties of all answers hold, and how wide they are.

Drawn from the stored tables of area_uncertainty.py, quantities.py, responses.py and two_grids.py, in a second. The
picture keeps the numbers that it shows, which tests/pages/test_doc_tables.py compares with these tables.

    python docs/studies/plus_minus.py
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import attrs
import numpy as np
from doc_tables import read
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from roughcontact.plotting import LIGHT, style

PICTURE = Path(__file__).parent.parent / "figures" / "plus_minus.png"
# What is aimed at: the fraction of errors within two standard deviations, %, and the width u/e.
WITHIN = 93.0
WIDTH = 3.0
# Both axes end here: what lies beyond is drawn at the end.
LOWEST = 80.0
NARROWEST = 0.5
WIDEST = 60.0
# Where 95 % of the errors are below this, %, a wide uncertainty costs nothing.
TINY = 0.1
# Classes whose contacts end at an edge or a tip; all others of the fresh classes are smooth.
SHARP = ("cone", "capped-punch", "tip-1", "tip-1.5")
ROWS = (
    *("area", "maximum pressure", "perimeter", "approach", "mean gap", "stiffness", "tangential stiffness"),
    *("conductance", "partial slip", "stress", "first yield", "leakage"),
)
# The rows of the classes of benchmarks/response_classes.py, by how their names begin.
RESPONSES = {
    "stiffness": "stiffness",
    "tangential": "tangential stiffness",
    "unlike": "tangential stiffness",
    "conductance": "conductance",
    "film": "conductance",
    "partial-slip": "partial slip",
    "stress": "stress",
    "first-yield": "first yield",
    "leakage": "leakage",
}


@attrs.frozen
class Dot:
    """A class of contacts: an answer, whether they are smooth, % within two, u/e, and whether all errors are tiny."""

    answer: str
    is_smooth: bool
    within: float
    width: float | None
    is_tiny: bool = False


def find_dots() -> list[Dot]:
    """Return the dots of all tables, each once."""
    return [*find_areas(), *find_quantities(), *find_responses(), *find_machined()]


def read_lines(name: str) -> Iterator[tuple[str, dict[str, str]]]:
    """Yield the first cell of each line of a table, and all cells by their headings."""
    heading, *lines = read(name)
    for line in lines:
        yield line[0], dict(zip(heading, line, strict=True))


def find_areas() -> Iterator[Dot]:
    for name, line in read_lines("area-classes"):
        width = float(line["uncertainty, median, %"]) / float(line["median, %"])
        within = float(line["within 2"].removesuffix(" %"))
        yield Dot("area", name not in SHARP, within, width, float(line["95 %, %"]) < TINY)


def find_quantities() -> Iterator[Dot]:
    answers = {"peak pressure": "maximum pressure"} | {name: name for name in ("perimeter", "approach", "mean gap")}
    for table in ("quantities", "quantities-unkind"):
        for name, line in read_lines(table):
            for column, answer in answers.items():
                within, width = line[f"{column}: within two"], line[f"{column}: u/e"]
                if within:
                    is_tiny = float(line[f"{column}: error, %"]) < TINY
                    stated = float(width) if width else None
                    yield Dot(answer, name not in SHARP, round(100 * float(within)), stated, is_tiny)


def find_responses() -> Iterator[Dot]:
    for name, line in read_lines("responses"):
        answer = next(row for start, row in RESPONSES.items() if name.startswith(start))
        width = float(line["held-out: median uncertainty, %"]) / float(line["held-out: median error, %"])
        yield Dot(answer, True, float(line["held-out: within two, %"]), width)


def find_machined() -> Iterator[Dot]:
    for name, line in read_lines("two-grids"):
        answer = name.replace("peak", "maximum")
        within = float(line["within two, default"].removesuffix(" %"))
        yield Dot(answer, line["surfaces"] == "smooth", within, float(line["u/e, default"]))


def list_numbers(dots: list[Dot]) -> str:
    """Return what the picture keeps: its dots, to three digits."""
    return json.dumps(
        [[dot.answer, dot.is_smooth, dot.within, dot.width and float(f"{dot.width:.3g}"), dot.is_tiny] for dot in dots]
    )


def draw_panel(axes: Axes, dots: list[Dot], values: list[float | None], ends: tuple[float, float]) -> None:
    """Draw one number of all dots: in each row smooth contacts above the others, scattered where they are many."""
    shifts = np.random.default_rng(0).uniform(-0.14, 0.14, len(dots))
    blue, orange = LIGHT.lines[:2]
    for dot, value, shift in zip(dots, values, shifts, strict=True):
        if value is not None:
            color, marker, size = (blue, "o", 4.0) if dot.is_smooth else (orange, "D", 4.5)
            axes.plot(
                np.clip(value, *ends),
                ROWS.index(dot.answer) + (-0.2 + shift if dot.is_smooth else 0.27 + shift / 2),
                marker if ends[0] <= value <= ends[1] else "<>"[value > ends[1]],
                color=color,
                markersize=size,
                markerfacecolor="none" if dot.is_tiny else color,
                clip_on=False,
                zorder=3,
            )
    axes.set_yticks(range(len(ROWS)), ROWS)
    axes.set_ylim(len(ROWS) - 0.5, -0.5)
    axes.set_yticks(np.arange(len(ROWS) - 1) + 0.5, minor=True)
    axes.grid(visible=False, which="both")
    axes.grid(visible=True, axis="y", which="minor", color="0.8")
    axes.tick_params(axis="y", which="both", length=0)


@style()
def draw(path: Path = PICTURE) -> None:
    dots = find_dots()
    figure = Figure(figsize=(9.5, 5.6), layout="constrained")
    left, right = figure.subplots(1, 2, sharey=True)
    draw_panel(left, dots, [dot.within for dot in dots], (LOWEST, 100.0))
    left.axvspan(WITHIN, 100.0, color="0.93", lw=0, zorder=0)
    left.axvline(WITHIN, color="0.4", ls="--", lw=1.0)
    left.set(xlim=(LOWEST, 100.0), xticks=range(80, 101, 5), xlabel="errors within two standard deviations, %")
    draw_panel(right, dots, [dot.width for dot in dots], (NARROWEST, WIDEST))
    right.axvspan(NARROWEST, WIDTH, color="0.93", lw=0, zorder=0)
    right.axvline(WIDTH, color="0.4", ls="--", lw=1.0)
    right.set(xscale="log", xlim=(NARROWEST, WIDEST), xlabel="median uncertainty over median error")
    ticks = (0.5, 1, 2, 3, 5, 10, 20, 50)
    right.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    right.set_xticks([], minor=True)
    blue, orange = LIGHT.lines[:2]
    handles = [
        Line2D([], [], marker="o", ls="", color=blue, label="smooth"),
        Line2D([], [], marker="D", ls="", color=orange, label="machined, tips, edges"),
        Line2D([], [], marker="o", ls="", color=blue, mfc="none", label=f"95 % of the errors below {TINY:g} %"),
        Line2D([], [], ls="--", color="0.4", label=f"aim: {WITHIN:.0f} % or more, {WIDTH:g} or less"),
    ]
    figure.legend(handles=handles, loc="outside upper center", ncols=4)
    figure.savefig(path, dpi=110, metadata={"Comment": list_numbers(dots)})


if __name__ == "__main__":
    draw()
