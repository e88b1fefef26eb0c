"""The classes of rough contacts, limited pressures and measured maps; see `benchmarks/contact_classes.py`."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np
import scipy.fft
from contact_classes import ELASTIC, LOADS, SHORTEST, SLOPE, WAVES, Case, generator, group_of_radius, log_uniform

import roughcontact as rc
from roughcontact._parts.surfaces.filling import fill
from roughcontact.reference import hertz_sphere

HURSTS = (0.3, 0.5, 0.8, 1.0)
CELLS = (2, 3, 4, 6, 8, 12)  # cells a shortest wave


def surface(hurst: float, seed: int, **options: float) -> rc.SelfAffineSurface:
    """Return the rough surface of these numbers, the same on all grids."""
    limits = {"shortest": SHORTEST, "longest": 16.0, "rolloff": 8.0}
    return rc.SelfAffineSurface(hurst=hurst, rms_slope=SLOPE, seed=seed, **limits, **options)


def press(cells: int, body: rc.Surface, material: rc.Elastic = ELASTIC, **parts: Any) -> rc.ContactProblem:
    parts = {"boundary": "periodic", **parts}
    return rc.ContactProblem(rc.Body(body, material), grid=rc.Grid((cells, cells), float(WAVES)), **parts)


def surfaces(name: str, split: str, seeds: int) -> Iterator[tuple[float, int, np.random.Generator]]:
    random = generator(name, split)
    for number in range(seeds * len(HURSTS)):
        yield HURSTS[number % len(HURSTS)], int(random.integers(1, 10**6)), random


def rough(split: str, band: str) -> Iterator[Case]:
    """Isotropic surfaces, 2 to 12 cells a shortest wave, both kernels."""
    for hurst, seed, random in surfaces(f"rough {band}", split, 3):
        load, body = log_uniform(random, *LOADS[band]), surface(hurst, seed)
        for cells in CELLS:
            for kernel in ("love", "fourier"):
                yield rough_case(f"H {hurst} seed {seed} {load:.4g} Pa", body, cells, load, kernel)


def rough_case(key: str, body: rc.Surface, cells: int, load: float, kernel: str = "love", **parts: Any) -> Case:
    return Case(
        partial(press, WAVES * cells, body, kernel=kernel, **parts),
        {"pressure": load},
        f"{key}, {cells} cells, {kernel}",
        f"{cells} cells",
        key=key,
        fine=lambda fine: press(fine, body, **parts),
    )


def lay(split: str, band: str, turned: bool) -> Iterator[Case]:
    """Peklenik's number 5, along the grid (along x or y) or turned by 45 degrees, 1:2 or any angle."""
    for number, (hurst, seed, random) in enumerate(surfaces(f"lay {band} {turned}", split, 2)):
        turns = (np.pi / 4, math.atan(0.5), *random.uniform(0.1, 1.4, 2)) if turned else (0.0, np.pi / 2)
        load, angle = log_uniform(random, *LOADS[band]), turns[number % len(turns)]
        body = surface(hurst, seed, peklenik=5.0, lay=angle)
        for cells in CELLS:
            yield rough_case(f"H {hurst} seed {seed} lay {angle:.3f} {load:.4g} Pa", body, cells, load)


# --- pressure limits --------------------------------------------------------------------------------------------------


def capped_rough(split: str) -> Iterator[Case]:
    for hurst, seed, random in surfaces("capped", split, 2):
        limit = log_uniform(random, 0.25, 0.7) * SLOPE
        load, body = log_uniform(random, 5e-4, 1.5e-2), surface(hurst, seed)
        material = rc.ElasticPerfectlyPlastic(1.0, 0.0, limit)
        for cells in (3, 4, 6, 8, 12):
            key = f"H {hurst} seed {seed} limit {limit:.4g} {load:.4g} Pa"
            yield rough_case(key, body, cells, load, material=material)


def capped_sphere(cells: int, side: float, center: tuple[float, float], limit: float) -> rc.ContactProblem:
    material = rc.ElasticPerfectlyPlastic(1.0, 0.0, limit)
    body = rc.Body(rc.ParaboloidSurface(1000.0, center=center), material)
    return rc.ContactProblem(body, grid=rc.Grid((cells, cells), side))


def capped_ball(split: str) -> Iterator[Case]:
    """Balls of elastic contact radius 1 m at a pressure limit below Hertz's maximum pressure, on any place."""
    random = generator("capped ball", split)
    hertz = hertz_sphere(4e-3 / 3, 1000.0, 1.0)
    overloads = {"tuned": (1.1, 1.4, 2.0, 3.0), "held-out": (1.2, 1.6, 2.4), "fresh": (1.25, 1.7, 2.6)}[split]
    for overload in overloads:
        limit = hertz.p_max / overload
        for number in range(14):
            a = log_uniform(random, 1.0, 12.0)
            cells = 2 * math.ceil(2.2 * a * max(1.0, math.sqrt(overload / 1.5))) + number % 2
            center = (0.0, 0.0) if number % 4 < 2 else tuple(random.uniform(-0.5, 0.5, 2) / a)
            yield Case(
                partial(capped_sphere, cells, cells / a, center, limit),
                {"force": 4e-3 / 3},
                f"overload {overload}, elastic a = {a:.3g} cells, {number}",
                group_of_radius(a),
                key=f"overload {overload}",
                fine=lambda cells, limit=limit: capped_sphere(cells // 2, 5.0, (1e-3, 2e-3), limit),
            )


def flat_punch(cells: int, sides: tuple[float, float], angle: float, limit: float) -> rc.ContactProblem:
    """Return a punch of flat face, a disc if its second side is zero, cells of 1 m."""
    grid = rc.Grid((cells, cells), float(cells))
    x, y = np.cos(angle) * grid.x + np.sin(angle) * grid.y, np.cos(angle) * grid.y - np.sin(angle) * grid.x
    disc, rectangle = np.hypot(x, y) < sides[0], (np.abs(x) < sides[0]) & (np.abs(y) < sides[1])
    inside = disc if sides[1] == 0.0 else rectangle
    material = rc.ElasticPerfectlyPlastic(1.0, 0.0, limit)
    return rc.ContactProblem(rc.Body(rc.HeightMap(np.where(inside, 0.0, -1.0), size=float(cells)), material))


def capped_punch(split: str) -> Iterator[Case]:
    """Discs and rectangles, their edges saturated at 50 to 95 % of the load that they can carry."""
    random = generator("capped punch", split)
    for number in range(48):
        half, limit = random.uniform(5.0, 22.0), 0.01
        if number % 3 == 0:
            half = round(half)  # along the axes, edges between the cells
        sides = (half, 0.0) if number % 3 == 1 else (half, half if number % 2 else max(4.0, round(0.6 * half)))
        angle = (0.0, 0.0, random.uniform(0.0, np.pi))[number % 3]
        area = np.pi * half**2 if sides[1] == 0.0 else 4.0 * sides[0] * sides[1]
        yield Case(
            partial(flat_punch, 72, sides, angle, limit),
            {"force": random.uniform(0.5, 0.95) * limit * area},
            f"sides {sides[0]:.3g} {sides[1]:.3g} cells, angle {angle:.3g}, {number}",
            ("along the axes", "disc", "turned")[number % 3],
            {"area": area},
        )


def worn(cells: int, hurst: float, seed: int, limit: float, load: float) -> rc.ContactProblem:
    fresh = press(cells, surface(hurst, seed), rc.ElasticPerfectlyPlastic(1.0, 0.0, limit))
    return rc.run_in(fresh, pressure=load).problem


def run_in(split: str, fraction: float) -> Iterator[Case]:
    """Surfaces run in on each grid, loaded by this fraction of the load of running in; the true one on the finest."""
    for hurst, seed, random in surfaces(f"run in {fraction}", split, 2):
        limit, load = log_uniform(random, 0.25, 0.6) * SLOPE, log_uniform(random, 1e-3, 1e-2)
        for cells in (2, 4, 6, 8, 12):
            yield Case(
                partial(worn, WAVES * cells, hurst, seed, limit, load),
                {"pressure": fraction * load},
                f"H {hurst} seed {seed} limit {limit:.4g} {load:.4g} Pa, {cells} cells",
                f"{cells} cells",
                key=f"H {hurst} seed {seed} limit {limit:.4g} {load:.4g} Pa x {fraction}",
                fine=partial(worn, hurst=hurst, seed=seed, limit=limit, load=load),
            )


# --- borders and measured maps ----------------------------------------------------------------------------------------


def border(split: str) -> Iterator[Case]:
    """Rough bodies that end at the border of the domain, in contact there."""
    for hurst, seed, random in surfaces("border", split, 2):
        load, body = log_uniform(random, 1e-3, 2e-2), surface(hurst, seed)
        for cells in (3, 4, 6, 8, 12):
            yield rough_case(f"H {hurst} seed {seed} {load:.4g} Pa", body, cells, load, boundary="free")


def holed(cells: int, hurst: float, seed: int, coarse: int, fraction: float, filled: bool) -> rc.ContactProblem:
    """Return a surface with non-measured points of the size of a coarse cell, single and in groups."""
    heights = surface(hurst, seed).heights(rc.Grid((cells, cells), float(WAVES)))
    random = generator("holes", seed)
    mask = random.random((coarse, coarse)) < 0.5 * fraction
    spots = scipy.fft.irfft2(scipy.fft.rfft2(random.random((coarse, coarse)) < 0.02 * fraction) * _disc(coarse, 2.5))
    mask |= np.abs(spots) > 0.5
    if filled:
        # Only the map has lost its points, not the surface.
        heights = fill(np.where(mask, np.nan, heights)) if cells == coarse else heights
        return press(cells, rc.HeightMap(heights, size=float(WAVES), periodic=True))
    fine = np.kron(mask, np.ones((cells // coarse,) * 2, dtype=bool)) if cells > coarse else mask
    return press(cells, rc.HeightMap(heights, size=float(WAVES), periodic=True, non_measured=fine))


def _disc(cells: int, radius: float) -> np.ndarray:
    x = (np.arange(cells) + cells // 2) % cells - cells // 2
    return scipy.fft.rfft2((np.hypot(x[:, None], x[None, :]) < radius).astype(float))


def holes(split: str, filled: bool) -> Iterator[Case]:
    """Yield maps of 3 to 8 cells a shortest wave with 1 to 5 % non-measured points, kept or filled."""
    for hurst, seed, random in surfaces(f"holes {filled}", split, 2):
        load, fraction = log_uniform(random, 1e-3, 1.5e-2), log_uniform(random, 0.01, 0.05)
        for cells in (3, 4, 6, 8):
            make = partial(holed, hurst=hurst, seed=seed, coarse=WAVES * cells, fraction=fraction, filled=filled)
            # Kept, the holes are parts of the surface, and each grid has its own.
            whole = f"H {hurst} seed {seed} {load:.4g} Pa"
            key = whole if filled else f"{whole}, {fraction:.3g} of {cells} cells"
            yield Case(
                partial(make, WAVES * cells),
                {"pressure": load},
                f"{whole}, {fraction:.3g} of {cells} cells",
                f"{cells} cells",
                key=key,
                fine=partial(_refined, make, WAVES * cells),
            )


def _refined(make: Any, coarse: int, cells: int) -> rc.ContactProblem:
    return make(coarse * max(1, cells // coarse))


def blurred(cells: int, hurst: float, seed: int, width: float) -> rc.ContactProblem:
    """Return a surface convolved with a Gaussian of this standard deviation, m: its own surface on all grids."""
    heights = surface(hurst, seed).heights(rc.Grid((cells, cells), float(WAVES)))
    q = 2 * np.pi * scipy.fft.fftfreq(cells, WAVES / cells)
    filtered = scipy.fft.fft2(heights) * np.exp(-0.5 * width**2 * (q[:, None] ** 2 + q[None, :] ** 2))
    return press(cells, rc.HeightMap(scipy.fft.ifft2(filtered).real, size=float(WAVES), periodic=True))


def upsampled(cells: int, hurst: float, seed: int, coarse: int) -> rc.ContactProblem:
    heights = surface(hurst, seed).heights(rc.Grid((coarse, coarse), float(WAVES)))
    known = rc.HeightMap(heights, size=float(WAVES), periodic=True)
    return press(cells, known.resample((cells, cells), "bilinear"))


def maps(split: str, kind: str, original: bool) -> Iterator[Case]:
    """Yield maps blurred by 1.5 cells, or linear between points 2 or 4 cells apart; true is what it is or was."""
    for hurst, seed, random in surfaces(f"maps {kind}", split, 2):
        load = log_uniform(random, 1e-3, 1e-2)
        for cells in (4, 8):
            # The reference has four times the cells of the map, so that no map of 8 cells is upsampled by four.
            for factor in (1.5,) if kind == "blurred" else (2, 4) if cells == 4 else (2,):
                if kind == "upsampled":
                    make = partial(upsampled, hurst=hurst, seed=seed, coarse=WAVES * cells)
                    own, grid = f" linear between {cells} cells", WAVES * cells * factor
                else:
                    make = partial(blurred, hurst=hurst, seed=seed, width=factor / cells)
                    own, grid = f" blurred by {factor} of {cells} cells", WAVES * cells
                if original:
                    own, fine = "", partial(press, body=surface(hurst, seed))
                else:
                    fine = partial(_refined, make, WAVES * cells)
                yield Case(
                    partial(make, grid),
                    {"pressure": load},
                    f"H {hurst} seed {seed} {load:.4g} Pa, {cells} cells, {kind} by {factor}",
                    f"{cells} cells x {factor}",
                    key=f"H {hurst} seed {seed} {load:.4g} Pa{own}",
                    fine=fine,
                )
