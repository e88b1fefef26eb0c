"""Whether the uncertainty of the area holds: the fresh classes of benchmarks/area_classes.py.

Writes the table of docs/understand/area.md and docs/figures/reliability.png; the solutions are kept in a folder
(15 minutes at first, then one).

    python docs/studies/area_uncertainty.py [FOLDER]
"""

from __future__ import annotations

import sys
from functools import lru_cache
from pathlib import Path

import numpy as np
from doc_tables import DocTable, gather, write_tables
from matplotlib.figure import Figure

FIGURES = Path(__file__).parent.parent / "figures"
sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

import area_classes

from roughcontact.plotting import LIGHT, style

# Groups of classes, by panels of the figure.
PANELS = {
    "waves, balls, ellipses": ("wave", "ball", "ellipse"),
    "rough surfaces": ("rough",),
    "rough surfaces with a lay": ("lay",),
    "strips, cones": ("strips", "cone", "cubic"),
    "limited pressure, running in": ("capped", "run-in"),
    "borders, measured maps": ("border", "holes", "map"),
}
# The classes in words.
WORDS = {
    "wave-whole": "wave of whole cells",
    "wave-random": "wave at any place",
    "wave-other": "other waves",
    "ball-centred": "ball at the centre",
    "ball-random": "ball at any place",
    "ellipse-centred": "ellipse at the centre",
    "ellipse-random": "ellipse at any place",
    **{f"rough-{load}": f"{load} load" for load in area_classes.BANDS},
    **{f"lay-{load}": f"along the grid, {load} load" for load in area_classes.BANDS},
    **{f"lay-turned-{load}": f"turned, {load} load" for load in area_classes.BANDS},
    "strips-axis": "strips along the grid",
    "strips-45": "strips at 45°",
    "strips-1:2": "strips at a slope of 1 : 2",
    "cone": "cone",
    "cubic": "cubic tip",
    "capped-rough": "rough, with a hardness",
    "capped-ball": "ball, with a hardness",
    "capped-punch": "flat punch, with a hardness",
    "run-in-half": "run in, at half the load",
    "run-in-own": "run in, at the same load",
    "border": "cut by a free border",
    "holes-kept": "non-measured points kept",
    "holes-filled": "non-measured points filled",
    "map-blurred": "blurred map",
    "map-upsampled": "interpolated map",
}


@lru_cache
def judge(name: str, folder: str | None = None) -> list[tuple[float, float, float]]:
    """Return the relative errors, stated and true uncertainties of the fresh cases of a class."""
    place = Path(folder) if folder else None
    return [row[:3] for row in area_classes.estimate(name, "fresh", "blend", place)]


def list_classes() -> list[str]:
    return list(area_classes.CLASSES)


def make_rows(folder: str | None = None) -> list[list[str]]:
    heading = [
        "class",
        "cases",
        "error, rms, %",
        "95 %, %",
        "median, %",
        "uncertainty, median, %",
        "within 1",
        "within 2",
    ]
    rows = [heading]
    for name in list_classes():
        found = area_classes.judge(judge(name, folder))
        parts = ("rms", "95 %", "median error", "median uncertainty")
        held = [f"{100 * found[key]:.0f} %" for key in ("within 1", "within 2")]
        rows.append([name, str(found["n"]), *(f"{100 * found[key]:.3g}" for key in parts), *held])
        print(" | ".join(rows[-1]), flush=True)
    return rows


@style()
def draw(folder: str | None = None) -> None:
    """Draw the fraction of errors within any number of standard deviations beside that of normal ones."""
    from scipy.special import erf

    figure = Figure(figsize=(11, 6), layout="constrained")
    z = np.linspace(0.0, 3.0, 121)
    for axes, (title, starts) in zip(figure.subplots(2, 3, sharex=True, sharey=True).flat, PANELS.items(), strict=True):
        axes.plot(z, erf(z / np.sqrt(2.0)), "k--", lw=1.0, label="normal errors")
        for place, name in enumerate(name for name in list_classes() if name.startswith(starts)):
            errors = np.array(judge(name, folder))
            found = np.abs(errors[:, 0]) / np.maximum(errors[:, 1], np.finfo(float).tiny)
            dashes = "-" if place < len(LIGHT.lines) else "-."
            axes.plot(z, np.mean(found[:, np.newaxis] <= z, axis=0), dashes, lw=1.4, label=WORDS[name])
        axes.axvline(2.0, color="0.7", lw=0.8)
        axes.set(title=title, xlim=(0.0, 3.0), ylim=(0.0, 1.02))
        axes.legend(fontsize=7, loc="lower right", frameon=True)
    for axes in figure.axes[3:]:
        axes.set_xlabel("error over stated standard deviation")
    for axes in figure.axes[::3]:
        axes.set_ylabel("fraction of cases below")
    figure.savefig(FIGURES / "reliability.png", dpi=110)


# The lines of the page, and its columns.
CONTACTS = {
    "waves": ("wave-whole", "wave-random", "wave-other"),
    "balls, ellipses": ("ball-centred", "ball-random", "ellipse-centred", "ellipse-random"),
    "rough: light, middle, heavy load": ("rough-light", "rough-middle", "rough-heavy"),
    "rough with a lay": (
        *("lay-light", "lay-middle", "lay-heavy"),
        *("lay-turned-light", "lay-turned-middle", "lay-turned-heavy"),
    ),
    "strips": ("strips-axis", "strips-45", "strips-1:2"),
    "with a hardness": ("capped-rough", "capped-ball", "capped-punch"),
    "after running in": ("run-in-half", "run-in-own"),
    "cones, cubic tips": ("cone", "cubic"),
    "cut by a free border": ("border",),
    "non-measured points": ("holes-kept", "holes-filled"),
    "blurred, interpolated maps": ("map-blurred", "map-upsampled"),
}
COLUMNS = {
    "class": "contacts",
    "median, %": "error, median, %",
    "95 %, %": "95 % of the errors below, %",
    "uncertainty, median, %": "stated, median, %",
    "within 2": "within two",
}
SHOWN = gather(CONTACTS, COLUMNS)
TABLES = {"area-classes": DocTable(make_rows, seconds=900, shown=SHOWN)}

if __name__ == "__main__":
    folder = sys.argv[1] if len(sys.argv) > 1 else None
    write_tables({"area-classes": DocTable(lambda: make_rows(folder), seconds=900, shown=SHOWN)})
    draw(folder)
