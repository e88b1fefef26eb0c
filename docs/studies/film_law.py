"""Whether the uncertainties of a film law hold: by the grid beside finer cells, and by place beside other seeds.

python docs/studies/doc_tables.py film-law-grid film-law-places writes the tables of docs/use/film_laws.md;
python docs/studies/film_law.py figure draws docs/figures/film_law.png.

By the grid: maps of `benchmarks/edged_classes.py` on 64 to 96 cells, against cells a quarter as long at the same
separations in metres. By place: surfaces of one spectrum, each with the scatter that it states, beside the others.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from functools import lru_cache
from pathlib import Path

import numpy as np
from doc_tables import DocTable, write_tables
from matplotlib.figure import Figure

import roughcontact as rc
from roughcontact.plotting import style
from roughcontact.typing import Array

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

from edged_classes import EDGED, SMOOTH, Surface, generator

# A draw of maps, and the first seed of the surfaces, that no constant has seen: 1, 2 and 1001 have set them.
DRAW = 5
FIRST_SEED = 2001
MAPS = 10  # of each kind
PLACES = 48
SEPARATIONS = (0.5, 1.0, 2.0)
KINDS = {"rough": SMOOTH["rough"], "lay": SMOOTH["lay"], "honed": EDGED["honed"], "wear scar": EDGED["wear-scar"]}
SIDE = 1e-3  # m
ROUNDING = 1e-12
MACHINED = ("honed", "wear scar")
STEEL = rc.Elastic(young=210e9, poisson=0.3)
FIGURES = Path(__file__).parent.parent / "figures"
COLUMNS = {
    "asperity_pressure": ("asperity_pressure",),
    "area": ("area",),
    "phi_xx, phi_yy": ("phi_xx", "phi_yy"),
    "phi_xy": ("phi_xy",),
    "phi_s_xx, phi_s_yy": ("phi_s_xx", "phi_s_yy"),
    "phi_s_xy, phi_s_yx": ("phi_s_xy", "phi_s_yx"),
    "phi_fp_xx, phi_fp_yy": ("phi_fp_xx", "phi_fp_yy"),
    "phi_fp_xy, phi_fp_yx": ("phi_fp_xy", "phi_fp_yx"),
}


def ask(surface: rc.HeightMap, lengths: Sequence[float]) -> rc.FilmLaw:
    """Return the law at separations in m, whose shear flow factors are over its own Sq."""
    problem = rc.ContactProblem(rc.Body(surface, STEEL), boundary="periodic", threads=1)
    rms = float(np.std(surface.values))
    return rc.film_law(problem, [one / rms for one in lengths], sampling=False)


def sample(surface: Surface, cells: Sequence[int]) -> rc.HeightMap:
    """Return the map of a surface of the unit domain: cells have the heights of their centres."""
    grid = rc.Grid((cells[0], cells[1]), 1.0)
    x, y = np.broadcast_arrays(grid.x + 0.5, grid.y + 0.5)
    return rc.HeightMap(SIDE * surface(x, y), size=(SIDE, SIDE), periodic=True)


def compare(kind: str, number: int, draw: int) -> dict[str, Array]:
    """Return error and uncertainty of each column of a map, shape (2, separations), phi_s over Sq of the coarse map."""
    random = generator("film", kind, draw, number)
    surface = KINDS[kind](random)
    cells = random.integers(64, 97, 2)
    maps = sample(surface, cells), sample(surface, 4 * cells)
    rms, finer = (float(np.std(one.values)) for one in maps)
    lengths = [one * rms for one in SEPARATIONS]
    coarse, fine = (ask(one, lengths) for one in maps)
    found = {}
    for name, column in coarse.columns.items():
        scale = finer / rms if name.startswith("phi_s") else 1.0
        found[name] = np.array([column.values - scale * fine[name].values, column.uncertainties])
    return found


@lru_cache(maxsize=1)
def judge_grid(draw: int = DRAW) -> dict[str, list[dict[str, Array]]]:
    """Return what `compare` finds of all maps, by their kind."""
    return {kind: [compare(kind, number, draw) for number in range(MAPS)] for kind in KINDS}


def make_grid(draw: int = DRAW) -> list[list[str]]:
    rows = [["column", "surfaces", "errors", "within two", "u/e"]]
    found = judge_grid(draw)
    groups = {
        "smooth": [one for kind in KINDS if kind not in MACHINED for one in found[kind]],
        "machined": [one for kind in MACHINED for one in found[kind]],
    }
    for label, names in COLUMNS.items():
        for group, maps in groups.items():
            errors, stated = np.concatenate([one[name] for one in maps for name in names], axis=1)
            # Where nothing touches, or flows on both grids, there is no error to judge.
            counted = (np.abs(errors) > ROUNDING) | (stated > 0.0)
            inside = np.abs(errors[counted]) <= 2.0 * stated[counted]
            ratio = float(np.median(stated[counted]) / np.median(np.abs(errors[counted])))
            rows.append([label, group, str(inside.size), f"{100.0 * inside.mean():.0f} %", f"{ratio:.1f}"])
    return rows


def spectrum(**changed: float) -> Callable[[int], rc.SpectralSurface]:
    """Return surfaces by their seed: four of the longest waves along a side, four cells in the shortest."""
    given = {"hurst": 0.8, "rms_height": 1e-6, "shortest": SIDE / 16, "longest": SIDE, "rolloff": SIDE / 4} | changed
    kind = rc.NonGaussianSurface if "skewness" in given else rc.SelfAffineSurface
    return lambda seed: kind(**given, seed=seed)


# Surfaces and the sides of their domain over SIDE, of 64 cells.
ENSEMBLES = {
    "isotropic": (spectrum(), (1.0, 1.0)),
    "eight waves": (spectrum(hurst=0.5, rolloff=SIDE / 8), (1.0, 1.0)),
    "lay of 3": (spectrum(peklenik=3.0), (3.0, 1.0)),
    "skewed": (spectrum(skewness=-1.0), (1.0, 1.0)),
}


@lru_cache(maxsize=1)
def judge_places(first: int = FIRST_SEED) -> dict[str, dict[str, Array]]:
    """Return values and scatter of each column of all ensembles, shape (2, places, separations)."""
    found = {}
    for label, (make, size) in ENSEMBLES.items():
        laws = []
        for seed in range(first, first + PLACES):
            grid = rc.Grid(tuple(round(64 * side) for side in size), tuple(SIDE * side for side in size))
            problem = rc.ContactProblem(rc.Body(make(seed), STEEL), grid=grid, boundary="periodic", threads=1)
            laws.append(rc.film_law(problem, SEPARATIONS))
        found[label] = {
            name: np.stack([(law[name].values, law[name].sampling) for law in laws], axis=1)
            for name in laws[0].columns
            if laws[0][name].sampling is not None
        }
    return found


def make_places(first: int = FIRST_SEED) -> list[list[str]]:
    rows = [["column", "places", "mean within two", "others within three", "s/scatter"]]
    ensembles = judge_places(first).values()
    for label, names in COLUMNS.items():
        means, others, ratios = [], [], []
        for values, stated in (one[name] for one in ensembles for name in names):
            means.append(np.abs(values - values.mean(axis=0)) <= 2.0 * stated)
            near = np.abs(values[:, np.newaxis] - values) <= 3.0 * stated[:, np.newaxis]
            # A place is as near to itself as can be.
            others.append((near.sum(axis=1) - 1.0) / (len(values) - 1.0))
            ratios.append(np.sqrt(np.mean(stated**2, axis=0)) / values.std(axis=0, ddof=1))
        count = sum(one.size for one in means)
        shares = [f"{100.0 * np.mean(np.concatenate(one)):.0f} %" for one in (means, others)]
        rows.append([label, str(count), *shares, f"{np.median(ratios):.1f}"])
    return rows


TABLES = {"film-law-grid": DocTable(make_grid, seconds=80), "film-law-places": DocTable(make_places, seconds=75)}


@style()
def draw(folder: Path = FIGURES, cells: int = 256) -> None:
    """Draw the law of a rough surface, that of the page on a finer grid."""
    surface = rc.SelfAffineSurface(hurst=0.8, rms_height=1e-6, shortest=62.5e-6, longest=SIDE, rolloff=SIDE / 8, seed=1)
    problem = rc.ContactProblem(rc.Body(surface, STEEL), grid=rc.Grid((cells, cells), SIDE), boundary="periodic")
    law = rc.film_law(problem, [0.5, 0.75, 1.0, 1.25, 1.5, 1.75, 2.0, 2.25, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0])
    figure = Figure(figsize=(12, 3.8), layout="constrained")
    pressure, shear, load = figure.subplots(1, 3)
    for axes, names in ((pressure, ("phi_xx", "phi_yy")), (shear, ("phi_s_xx", "phi_s_yy"))):
        for name in names:
            law.plot(name, axes)
    pressure.set_ylabel("pressure flow factors")
    shear.set_ylabel("shear flow factors")
    law.plot("asperity_pressure", load)
    folder.mkdir(parents=True, exist_ok=True)
    figure.savefig(folder / "film_law.png", dpi=120)


if __name__ == "__main__":
    if sys.argv[1:] == ["figure"]:
        draw()
    else:
        write_tables(TABLES)
