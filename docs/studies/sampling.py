"""Whether the sampling errors hold: answers at many places of rough surfaces, beside what each place states.

Writes the table of docs/understand/area.md. With the folder of measured maps, cut-outs of these are judged as well.

    python docs/studies/sampling.py [tuned | held-out [FOLDER [CLASS]]]     # 6 minutes each
"""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Callable, Iterator
from functools import lru_cache, partial
from pathlib import Path

import attrs
import numpy as np
import scipy.fft
from doc_tables import DocTable, gather

import roughcontact as rc
from roughcontact.typing import Array

# Rms slope of the surfaces, and nominal pressures over E* times it: about 0.6, 4, 13 and 40 % in contact.
SLOPE = 0.1
PRESSURES = (0.0025, 0.02, 0.06, 0.2)
MODULUS = 100e9
PLACES = 24
QUANTITIES = {
    "area": rc.ContactSolution.area,
    "stiffness": rc.ContactSolution.stiffness,
    "maximum pressure": rc.ContactSolution.peak_pressure,
}


@attrs.frozen
class Kind:
    """Surfaces of one spectrum: a domain of `shape` cells, and places of it.

    Attributes
    ----------
    hurst, rolloff, peklenik, lay
        As of `SelfAffineSurface`; the roll-off over the longer side of the domain.
    cells
        Cells of the shortest wave.
    boundary
        Boundary of the contact.
    shape, size
        Cells and sides of the domain.
    degree
        Degree of the form that is subtracted from cut-outs of a surface with sides four times as long; None: each
        place is a domain of its own, which repeats.
    skewed
        Whether the summits are blunt, as after honing.
    ball
        Radius of a ball that is pressed on the surface; zero: a flat.
    """

    hurst: float
    rolloff: float
    boundary: str | tuple[str, str] = "periodic"
    peklenik: float = 1.0
    lay: float = 0.0
    cells: float = 4.0
    shape: tuple[int, int] = (128, 128)
    size: tuple[float, float] = (1.0, 1.0)
    degree: int | None = None
    skewed: bool = False
    ball: float = 0.0

    @property
    def grid(self) -> rc.Grid:
        """The cells of a place."""
        return rc.Grid(self.shape, self.size)

    def draw(self, grid: rc.Grid, seed: int) -> Array:
        """Return Gaussian heights, whose rms slope has its expected value over many seeds."""
        qx, qy = (np.fft.fftfreq(n, step) for n, step in zip(grid.shape, grid.spacing, strict=True))
        along = math.cos(self.lay) * qx[:, np.newaxis] + math.sin(self.lay) * qy
        across = math.cos(self.lay) * qy - math.sin(self.lay) * qx[:, np.newaxis]
        q = np.hypot(self.peklenik * along, across)
        corner = 1.0 / (self.rolloff * max(self.size))
        power = np.where(q > 0.0, np.maximum(q, corner) ** (-2.0 - 2.0 * self.hurst), 0.0)
        power[q > 1.0 / (self.cells * max(grid.spacing))] = 0.0
        square = (2.0 * np.pi) ** 2 * (qx[:, np.newaxis] ** 2 + qy**2)
        power *= SLOPE**2 / np.sum(square * power)
        white = np.random.default_rng(seed).normal(size=grid.shape)
        heights = scipy.fft.ifft2(scipy.fft.fft2(white) * np.sqrt(power)).real * math.sqrt(grid.cells)
        if self.skewed:
            unit = heights.std()
            heights = -0.5 * unit * np.exp(-heights / unit)
        return np.asarray(heights)

    def list_maps(self, first: int) -> Iterator[rc.HeightMap]:
        """Yield the places."""
        repeats = self.boundary == "periodic"
        if self.degree is None:
            for seed in range(first, first + PLACES):
                yield rc.HeightMap(self.draw(self.grid, seed), size=self.size, periodic=repeats)
            return
        nx, ny = self.shape
        large = rc.Grid((4 * nx, 4 * ny), tuple(4.0 * side for side in self.size))
        for seed in range(first, first + 6):
            heights = self.draw(large, seed)
            # Places apart from each other.
            for i, j in ((0, 0), (0, 2), (2, 0), (2, 2)):
                part = heights[i * nx : (i + 1) * nx, j * ny : (j + 1) * ny]
                yield rc.HeightMap(part, size=self.size).detrend(self.degree)


TUNED = {
    **{
        f"H {hurst}, roll-off {rolloff:.3g}, {boundary}": Kind(hurst, rolloff, boundary)
        for hurst in (0.3, 0.8)
        for rolloff in (1.0, 0.25)
        for boundary in ("periodic", "free")
    },
    **{
        f"H {hurst}, roll-off {rolloff:.3g}, {boundary}": Kind(hurst, rolloff, boundary)
        for hurst in (0.4, 0.6)
        for rolloff in (0.5, 0.125)
        for boundary in ("periodic", "free")
    },
    "8:1": Kind(0.8, 0.125, shape=(256, 32), size=(1.0, 0.125)),
    "1:8": Kind(0.5, 1.0, shape=(48, 384), size=(0.125, 1.0)),
    "lay along x": Kind(0.8, 0.25, peklenik=4.0),
    "lay, oblique": Kind(0.5, 0.5, peklenik=4.0, lay=0.5),
    "lay of 6, oblique": Kind(0.7, 0.125, peklenik=6.0, lay=1.2, shape=(144, 144)),
    "fine, 64 waves a side": Kind(0.7, 0.25, cells=2.0),
    "cut-outs less a plane": Kind(0.6, 2.0, "free", degree=1),
    "cut-outs less a form": Kind(0.8, 0.5, "free", degree=2),
}
HELD_OUT = {
    "Hurst exponent 0.5, roll-off at 1/3": Kind(0.5, 1 / 3, cells=6.0, shape=(160, 160)),
    "the same, free": Kind(0.5, 1 / 3, "free", cells=6.0, shape=(160, 160)),
    "Hurst exponent 0.9, roll-off at 1": Kind(0.9, 1.0, shape=(150, 150)),
    "Hurst exponent 0.2, roll-off at 1/6": Kind(0.2, 1 / 6, cells=3.0, shape=(135, 135)),
    "free along x": Kind(0.7, 0.5, ("free", "periodic")),
    "domain 8:1": Kind(0.6, 0.25, shape=(384, 48), size=(1.0, 0.125)),
    "domain 1:8, free": Kind(0.7, 0.125, "free", shape=(32, 256), size=(0.125, 1.0)),
    "cells 1:3": Kind(0.6, 0.25, cells=4.0, shape=(120, 240), size=(1.0, 2 / 3)),
    "lay of 3, oblique": Kind(0.7, 0.25, peklenik=3.0, lay=0.8),
    "lay of 5 along y, free": Kind(0.8, 0.125, "free", peklenik=5.0, lay=math.pi / 2),
    "honed": Kind(0.7, 0.25, skewed=True),
    "cut-outs, roll-off at 1": Kind(0.7, 1.0, "free", degree=2),
    "cut-outs, roll-off at 1/4": Kind(0.5, 0.25, "free", degree=1),
    "cut-outs with a lay": Kind(0.8, 0.25, "free", degree=2, peklenik=3.0, lay=0.3),
    "cut-outs, roll-off at 4": Kind(0.8, 4.0, "free", degree=2),
}
TUNED |= {
    "ball, roll-off at 1/8": Kind(0.8, 0.125, "free", ball=20.0),
    "ball on a lay": Kind(0.8, 0.125, "free", ball=20.0, peklenik=5.0, lay=math.pi / 2),
}
HELD_OUT |= {
    "ball on a fine surface": Kind(0.5, 0.25, "free", ball=40.0, cells=3.0, shape=(160, 160)),
    "ball on a lay": Kind(0.7, 0.1, "free", ball=12.0, peklenik=3.0, lay=0.5, shape=(144, 144)),
}
# Radii of the contact of a smooth ball.
RADII = (0.12, 0.16, 0.22, 0.3)
# Sides of the parts of measured maps, cells.
MEASURED = {"plu-1.plu": 192, "x3p-2.x3p": 216, "opd-1.opd": 160}


def cut_map(file: Path, side: int) -> Iterator[rc.HeightMap]:
    """Yield the parts of a measured map, each less its form."""
    whole = rc.read_surface(file, non_measured="fill")
    nx, ny = whole.grid.shape
    size = tuple(side * step for step in whole.grid.spacing)
    for i in range(0, nx - side + 1, side):
        for j in range(0, ny - side + 1, side):
            yield rc.HeightMap(whole.values[i : i + side, j : j + side], size=size).detrend(2)


@attrs.frozen
class Places:
    """Maps that are places of one surface, and what is pressed on them."""

    make: Callable[[], Iterator[rc.HeightMap]]
    boundary: str | tuple[str, str] = "free"
    ball: float = 0.0

    def solve(self) -> Iterator[list[rc.ContactSolution]]:
        """Yield for each place the solutions at all loads."""
        loads: list[dict[str, float]] = []
        other = rc.SphereSurface(self.ball) if self.ball else rc.FlatSurface()
        for height_map in self.make():
            if not loads and self.ball:
                loads = [{"force": 4.0 * MODULUS * radius**3 / (3.0 * self.ball)} for radius in RADII]
            elif not loads:
                slope = rc.reference.texture(height_map.values, height_map.grid, periodic=False).Sdq.value
                loads = [{"pressure": ratio * MODULUS * slope} for ratio in PRESSURES]
            body = rc.Body(height_map, rc.Rigid())
            problem = rc.ContactProblem(body, rc.Body(other, rc.Elastic(MODULUS, 0.0)), boundary=self.boundary)
            yield [problem.solve(**load) for load in loads]


def list_classes(split: str, folder: str | None = None) -> dict[str, Places]:
    """Return the classes by name."""
    first = 1000 if split == "held-out" else 0
    kinds = HELD_OUT if split == "held-out" else TUNED
    found = {name: Places(partial(kind.list_maps, first), kind.boundary, kind.ball) for name, kind in kinds.items()}
    if folder is not None and split == "held-out":
        found |= {
            f"cut-outs of a measured map, {number}": Places(partial(cut_map, Path(folder) / name, side))
            for number, (name, side) in enumerate(MEASURED.items(), 1)
        }
    return found


@lru_cache
def solve_class(split: str, name: str, folder: str | None = None) -> dict[str, Array]:
    """Return for each quantity values and sampling errors, shape (2, places, loads)."""
    found: dict[str, list[list[tuple[float, float]]]] = {quantity: [] for quantity in QUANTITIES}
    for solutions in list_classes(split, folder)[name].solve():
        for quantity, ask in QUANTITIES.items():
            answers = [ask(solution) for solution in solutions]
            pairs = [(one.value, math.nan if one.sampling is None else one.sampling) for one in answers]
            found[quantity].append(pairs)
    return {quantity: np.moveaxis(np.array(places), 2, 0) for quantity, places in found.items()}


def judge(values: Array, stated: Array) -> tuple[float, float, float, float]:
    """Return scatter and stated errors (rms over the loads), and how often the mean and another place are within two.

    Another place is within two standard deviations of a difference, root two of one. Places at which the contact is too
    small to tell are not counted.
    """
    mean = values.mean(axis=0)
    scatter = values.std(axis=0, ddof=1) / mean
    known = np.isfinite(stated)
    inside = np.abs(values - mean)[known] < 2.0 * stated[known]
    near = np.abs(values[:, np.newaxis] - values) < 2.0 * math.sqrt(2.0) * stated[:, np.newaxis]
    # A place is as near to itself as can be.
    others = (near.sum(axis=1)[known] - 1.0) / (len(values) - 1.0)
    typical = np.nanmedian(stated / mean, axis=0)
    return (
        float(np.sqrt(np.mean(scatter**2))),
        float(np.sqrt(np.mean(typical**2))),
        float(inside.mean()),
        float(others.mean()),
    )


def make_rows(split: str = "held-out", folder: str | None = None, named: str = "") -> list[list[str]]:
    heading = ["places", "number"]
    heading += [
        f"{part} of the {q}, %" for q in QUANTITIES for part in ("scatter", "sampling", "mean in two", "others")
    ]
    rows = [heading]
    total: dict[str, list[tuple[float, float, int]]] = {quantity: [] for quantity in QUANTITIES}
    for name in (one for one in list_classes(split, folder) if named in one):
        found = solve_class(split, name, folder)
        cells = [name, str(found["area"].shape[1])]
        for quantity, (values, stated) in found.items():
            if np.isnan(stated).all():
                cells += [""] * 4
                continue
            numbers = judge(values, stated)
            total[quantity].append((*numbers[2:], len(values)))
            cells += [f"{100.0 * number:.2g}" for number in numbers[:2]] + [f"{100.0 * n:.0f}" for n in numbers[2:]]
        rows.append(cells)
        print(" | ".join(cells), flush=True)
    cells = ["all", str(sum(int(row[1]) for row in rows[1:]))]
    for quantity in QUANTITIES:
        parts = np.array(total[quantity]).reshape(-1, 3)
        cells += ["", ""] + [f"{100.0 * np.average(parts[:, k], weights=parts[:, 2]):.0f}" for k in (0, 1)]
    rows.append(cells)
    print(" | ".join(cells), flush=True)
    return rows


GROUPS = {
    "periodic": [name for name, kind in HELD_OUT.items() if kind.boundary == "periodic"],
    "free along one axis or both": [
        name for name, kind in HELD_OUT.items() if kind.boundary != "periodic" and kind.degree is None and not kind.ball
    ],
    "cut-outs of a larger surface": [name for name, kind in HELD_OUT.items() if kind.degree is not None],
    "below a ball": [name for name, kind in HELD_OUT.items() if kind.ball],
    **{f"cut-outs of a measured map, {k}": [f"cut-outs of a measured map, {k}"] for k in (1, 2, 3)},
    "all": ["all"],
}
SHOWN = {
    "places": "places",
    "scatter of the area, %": "scatter of the area, %",
    "sampling of the area, %": "sampling, median, %",
    **{f"mean in two of the {quantity}, %": f"mean within two: {quantity}, %" for quantity in QUANTITIES},
}
MAPS = os.environ.get("ROUGHCONTACT_MAPS")
TABLES = {"sampling": DocTable(partial(make_rows, folder=MAPS), 400, shown=gather(GROUPS, SHOWN))}

if __name__ == "__main__":
    make_rows(*sys.argv[1:])
