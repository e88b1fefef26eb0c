"""Whether the sampling errors hold: answers at many places of rough surfaces, beside what each place states.

Writes the table of docs/understand/area.md. With the folder of measured maps, cut-outs of these are judged as well;
the third helped to set the constants, the second led to the strips along a lay, whose numbers were set without it.

    python docs/studies/sampling.py [tuned | held-out [FOLDER [CLASS]]]     # 4 minutes each
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


def filter_noise(power: Array, seed: int) -> Array:
    """Return Gaussian heights of a spectrum, whose sum is their mean square."""
    white = np.random.default_rng(seed).normal(size=power.shape)
    return np.asarray(scipy.fft.ifft2(scipy.fft.fft2(white) * np.sqrt(power)).real * math.sqrt(power.size))


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
    modulation, patch
        Standard deviation of the logarithm of the amplitude from place to place, and its correlation length (to 1/e)
        over the longer side.
    varies
        What the modulation acts on: "heights", "short waves" (of less than an eighth of the longer side), or "states",
        which makes a mosaic of rough and smooth patches.
    scratches
        Scratches along random lines, some along a length of the longer side.
    grooves
        Grooves along y on the longer side, of twice the rms height.
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
    modulation: float = 0.0
    patch: float = 0.25
    varies: str = "heights"
    scratches: int = 0
    grooves: int = 0

    @property
    def grid(self) -> rc.Grid:
        """The cells of a place."""
        return rc.Grid(self.shape, self.size)

    def draw(self, grid: rc.Grid, seed: int) -> Array:
        """Return heights, whose rms slope without modulation has its expected value over many seeds."""
        qx, qy = (np.fft.fftfreq(n, step) for n, step in zip(grid.shape, grid.spacing, strict=True))
        along = math.cos(self.lay) * qx[:, np.newaxis] + math.sin(self.lay) * qy
        across = math.cos(self.lay) * qy - math.sin(self.lay) * qx[:, np.newaxis]
        q = np.hypot(self.peklenik * along, across)
        corner = 1.0 / (self.rolloff * max(self.size))
        power = np.where(q > 0.0, np.maximum(q, corner) ** (-2.0 - 2.0 * self.hurst), 0.0)
        power[q > 1.0 / (self.cells * max(grid.spacing))] = 0.0
        square = (2.0 * np.pi) ** 2 * (qx[:, np.newaxis] ** 2 + qy**2)
        power *= SLOPE**2 / np.sum(square * power)
        heights = filter_noise(power, seed)
        if self.modulation:
            amplitude = self.modulate(q * self.patch * max(self.size), seed)
            short = q > 8.0 / max(self.size) if self.varies == "short waves" else q > 0.0
            heights = filter_noise(power * ~short, seed) + amplitude * filter_noise(power * short, seed)
        if self.scratches:
            heights = heights + self.scratch(grid, seed, 3.0 * heights.std())
        if self.grooves:
            turns = np.arange(grid.shape[0]) * grid.spacing[0] / max(self.size) * self.grooves
            heights = heights + 2.0 * math.sqrt(2.0) * heights.std() * np.sin(2.0 * np.pi * turns)[:, np.newaxis]
        if self.skewed:
            unit = heights.std()
            heights = -0.5 * unit * np.exp(-heights / unit)
        return heights

    def modulate(self, waves: Array, seed: int) -> Array:
        """Return a factor of the heights whose logarithm is Gaussian; `waves` are patches per wavelength."""
        power = np.exp(-((np.pi * waves) ** 2))
        field = filter_noise(power / power.sum(), seed + 10**6)
        return np.exp(self.modulation * (np.sign(field) if self.varies == "states" else field))

    def scratch(self, grid: rc.Grid, seed: int, depth: float) -> Array:
        """Return grooves with a ridge on both sides."""
        rng = np.random.default_rng(seed + 2 * 10**6)
        x, y = (step * np.arange(n) for n, step in zip(grid.shape, grid.spacing, strict=True))
        found = np.zeros(grid.shape)
        width = 1.5 * self.cells * max(grid.spacing)
        count = self.scratches * round(grid.area / (self.size[0] * self.size[1]))
        for angle, place_x, place_y in rng.uniform(0.0, 1.0, (count, 3)):
            direction = (math.cos(math.pi * angle), math.sin(math.pi * angle))
            from_x, from_y = x[:, np.newaxis] - place_x * grid.size[0], y - place_y * grid.size[1]
            off = (direction[0] * from_y - direction[1] * from_x) / width
            along = (direction[0] * from_x + direction[1] * from_y) / (0.5 * max(self.size))
            found -= depth * (1.0 - off**2) * np.exp(-0.5 * off**2 - along**4)
        return found

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
    "cut-outs with a lay, roll-off at 2": Kind(0.8, 2.0, "free", degree=2, peklenik=4.0, lay=1.4),
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
# Roughness that differs from place to place.
SMALL = partial(Kind, shape=(112, 112))
TUNED_UNEVEN = {
    "modulated over 1/8": SMALL(0.8, 0.125, modulation=0.4, patch=1 / 8),
    "modulated over 1/3, free": SMALL(0.6, 0.25, "free", modulation=0.4, patch=1 / 3),
    "modulated over 1/2, cut-outs": SMALL(0.7, 0.25, "free", degree=2, modulation=0.3, patch=1 / 2),
    "modulated over 1, cut-outs": SMALL(0.8, 0.25, "free", degree=1, modulation=0.3, patch=1.0),
    "mosaic over 1/4, short waves": SMALL(0.4, 0.25, modulation=0.3, patch=1 / 4, varies="states"),
    "modulated over 1/4, 8:1": Kind(0.8, 0.125, shape=(256, 32), size=(1.0, 0.125), modulation=0.4, patch=1 / 4),
    "scratches, cut-outs": SMALL(0.6, 0.25, "free", degree=2, scratches=4),
    "lay, modulated over 1/3": SMALL(0.7, 0.25, "free", peklenik=4.0, lay=0.3, modulation=0.3, patch=1 / 3),
    "grooves, modulated over 1/3": SMALL(0.7, 0.25, "free", degree=1, grooves=9, modulation=0.3, patch=1 / 3),
    "marks over 1/6, oblique": SMALL(0.6, 0.25, "free", degree=1, peklenik=8.0, lay=0.4, modulation=0.35, patch=1 / 6),
    "marks over 1/4": SMALL(0.8, 0.25, peklenik=6.0, lay=math.pi / 2, modulation=0.35, patch=1 / 4),
    "worn": SMALL(0.5, 0.25, skewed=True),
    "worn, cut-outs": SMALL(0.8, 0.25, "free", degree=1, skewed=True),
    "plateaus over 1/3": SMALL(0.7, 0.25, skewed=True, modulation=0.4, patch=1 / 3),
}
HELD_OUT_UNEVEN = {
    "modulated over 1/16": SMALL(0.7, 1 / 6, modulation=0.4, patch=1 / 16),
    "modulated over 1/4": SMALL(0.6, 0.25, modulation=0.3, patch=1 / 4),
    "modulated over 1/2, free": SMALL(0.5, 0.25, "free", modulation=0.3, patch=1 / 2),
    "modulated over 1/4, cut-outs": SMALL(0.8, 0.5, "free", degree=2, modulation=0.5, patch=1 / 4),
    "modulated over 1, cut-outs": SMALL(0.6, 0.25, "free", degree=2, modulation=0.25, patch=1.0),
    "modulated over 2, cut-outs": SMALL(0.7, 0.25, "free", degree=2, modulation=0.25, patch=2.0),
    "short waves modulated over 1/3": SMALL(0.7, 0.5, modulation=0.4, patch=1 / 3, varies="short waves"),
    "mosaic over 1/3": SMALL(0.7, 0.25, modulation=0.35, patch=1 / 3, varies="states"),
    "modulated over 1/8, 8:1": Kind(0.6, 0.125, shape=(256, 32), size=(1.0, 0.125), modulation=0.4, patch=1 / 8),
    "modulated over 1/4, cells 1:3": Kind(
        0.7, 0.25, "free", shape=(80, 160), size=(1.0, 2 / 3), modulation=0.3, patch=1 / 4
    ),
    "lay, modulated over 1/4": SMALL(0.7, 0.125, "free", peklenik=3.0, modulation=0.3, patch=1 / 4),
    "marks over 1/5, cut-outs": SMALL(0.7, 0.25, "free", degree=2, peklenik=10.0, lay=1.5, modulation=0.4, patch=1 / 5),
    "marks over 1/3, oblique": SMALL(0.6, 0.25, "free", peklenik=6.0, lay=0.9, modulation=0.3, patch=1 / 3),
    "marks over 1/5, cells 1:3": Kind(
        0.6, 0.25, shape=(81, 161), size=(1.0, 2 / 3), peklenik=8.0, lay=math.pi / 2, modulation=0.4, patch=1 / 5
    ),
    "marks over 1/8, 1:8": Kind(
        0.6, 0.125, "free", shape=(32, 256), size=(0.125, 1.0), peklenik=6.0, modulation=0.4, patch=1 / 8
    ),
    "plateaus and scratches, cut-outs": SMALL(
        0.7, 0.25, "free", degree=2, skewed=True, modulation=0.3, patch=1 / 2, scratches=3
    ),
    "scratches": SMALL(0.8, 0.25, "free", degree=1, scratches=2),
}
# Radii of the contact of a smooth ball.
RADII = (0.12, 0.16, 0.22, 0.3)
# Measured maps, and sides of their parts, cells; constants were set on one of them too.
MEASURED = {"1": ("plu-1.plu", (192, 96)), "2": ("x3p-2.x3p", (216, 108)), "3 (tuned)": ("opd-1.opd", (160, 80))}


def cut_map(file: Path, side: int, step: int) -> Iterator[rc.HeightMap]:
    """Yield parts of a measured map, each less its form; `step` cells from one to the next."""
    whole = rc.read_surface(file, non_measured="fill")
    nx, ny = whole.grid.shape
    size = tuple(side * spacing for spacing in whole.grid.spacing)
    for i in range(0, nx - side + 1, step):
        for j in range(0, ny - side + 1, step):
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
    kinds = HELD_OUT | HELD_OUT_UNEVEN if split == "held-out" else TUNED | TUNED_UNEVEN
    found = {name: Places(partial(kind.list_maps, first), kind.boundary, kind.ball) for name, kind in kinds.items()}
    if folder is not None and split == "held-out":
        found |= {
            f"cut-outs of a measured map, {label}, {side} cells": Places(
                partial(cut_map, Path(folder) / name, side, sides[0])
            )
            for label, (name, sides) in MEASURED.items()
            for side in sides
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
            total[quantity].append((*numbers[2:], len(values) * ("(tuned)" not in name)))
            cells += [f"{100.0 * number:.2g}" for number in numbers[:2]] + [f"{100.0 * n:.0f}" for n in numbers[2:]]
        rows.append(cells)
        print(" | ".join(cells), flush=True)
    cells = ["all", str(sum(int(row[1]) for row in rows[1:] if "(tuned)" not in row[0]))]
    for quantity in QUANTITIES:
        parts = np.array([one for one in total[quantity] if one[2]]).reshape(-1, 3)
        means = [np.average(parts[:, k], weights=parts[:, 2]) for k in (0, 1)] if len(parts) else []
        cells += ["", "", *(f"{100.0 * mean:.0f}" for mean in means)]
    rows.append(cells)
    print(" | ".join(cells), flush=True)
    return rows


GROUPS = {
    "periodic": [name for name, kind in HELD_OUT.items() if kind.boundary == "periodic"],
    "free": [
        name for name, kind in HELD_OUT.items() if kind.boundary != "periodic" and kind.degree is None and not kind.ball
    ],
    "cut-outs": [name for name, kind in HELD_OUT.items() if kind.degree is not None],
    "below a ball": [name for name, kind in HELD_OUT.items() if kind.ball],
    "scratches": ["scratches"],
    "changing over up to a third of a side": [
        name for name, kind in HELD_OUT_UNEVEN.items() if kind.modulation and kind.patch < 0.4 and kind.peklenik == 1.0
    ],
    "changing across a lay": [name for name, kind in HELD_OUT_UNEVEN.items() if kind.peklenik > 1.0],
    "changing over a half to a side": [
        name for name, kind in HELD_OUT_UNEVEN.items() if kind.modulation and 0.4 < kind.patch < 1.5
    ],
    "changing over two sides": [name for name, kind in HELD_OUT_UNEVEN.items() if kind.patch > 1.5],
    **{
        f"measured map, {label}": [f"cut-outs of a measured map, {label}, {side} cells" for side in sides]
        for label, (_, sides) in MEASURED.items()
    },
    "all but the tuned": ["all"],
}
SHOWN = {
    "places": "places",
    "scatter of the area, %": "scatter of the area, %",
    "sampling of the area, %": "sampling, median, %",
    "mean in two of the area, %": "mean within two, %",
}
MAPS = os.environ.get("ROUGHCONTACT_MAPS")
TABLES = {"sampling": DocTable(partial(make_rows, folder=MAPS), 240, shown=gather(GROUPS, SHOWN))}

if __name__ == "__main__":
    make_rows(*sys.argv[1:])
