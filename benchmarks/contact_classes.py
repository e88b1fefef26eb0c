"""The classes of contacts on which areas and their uncertainties are judged; `benchmarks/area_classes.py` judges.

Each class has a tuned, a held-out and a fresh split, of other seeds, places and loads. E* = 1 Pa and lengths of about
1 m, but for the paper's wave. A true value is a closed form, or that of the same surface on a grid of up to 1024 x 1024
cells.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Callable, Iterator
from functools import partial
from typing import NamedTuple

import numpy as np
from scipy.special import ellipe, gamma

import roughcontact as rc
from roughcontact.reference import Westergaard, hertz_elliptic, hertz_sphere

Make = Callable[[], rc.ContactProblem]
ELASTIC = rc.Elastic(1.0, 0.0)
# Number of the draw of the fresh cases: another one once constants have been set on those that were drawn.
DRAW = 3
WAVES = 24  # shortest waves along a side of rough surfaces
SHORTEST = 24.0 / 23.5  # m; so the shortest wave is above two cells of the coarsest grid
SLOPE = 0.1  # rms slope of rough surfaces
FINEST = 1024  # cells along a side of one wave in its reference solves
FINE = 768  # cells along a side of the reference solves, 32 a shortest wave
LOADS = {"light": (2e-4, 9e-4), "middle": (1.3e-3, 6e-3), "heavy": (7e-3, 4e-2)}  # Pa: 0.3-2, 2-12, 12-60 % contact
PHASES = tuple((0.01 * k, 0.023 * k * k) for k in range(8))  # of the paper's wave in its reference solves
WAVE_GRIDS = (160, 200, 240, 250, 256, 260, 320, 500, 512)


class Case(NamedTuple):
    """A contact whose area is known: by `true`, or by the reference `key` that `fine` solves."""

    problem: Make
    load: dict[str, float]
    label: str
    group: str
    true: dict[str, float] | None = None
    key: str = ""
    fine: Callable[[int], rc.ContactProblem] | None = None
    others: tuple[Callable[[int], rc.ContactProblem], ...] = ()  # the same contact in other places of the grid


def generator(*words: object) -> np.random.Generator:
    """Return a generator of random numbers for these words; `DRAW` tells the fresh cases from those of before."""
    chosen = (f"fresh {DRAW}" if word == "fresh" else str(word) for word in words)
    return np.random.default_rng(zlib.crc32(" ".join(chosen).encode()))


def log_uniform(random: np.random.Generator, low: float, high: float) -> float:
    return float(low * (high / low) ** random.random())


# --- the paper's wave -------------------------------------------------------------------------------------------------


def wave(cells: int, waves: int, phase: tuple[float, float], boundary: str = "periodic") -> rc.ContactProblem:
    surface = rc.WavySurface(amplitude=0.5e-6, wavelength=12.5e-6, phase=phase)
    grid = rc.Grid((cells, cells), waves * 12.5e-6)
    return rc.ContactProblem(rc.Body(surface, rc.Elastic(200e9, 0.3)), grid=grid, boundary=boundary)


def wave_case(megapascal: float, cells: int, waves: int, phase: tuple[float, float]) -> Case:
    return Case(
        partial(wave, cells, waves, phase),
        {"pressure": 1e6 * megapascal},
        f"{megapascal:.5g} MPa, N = {cells}, {waves} waves, phase {phase[0]:.3g} {phase[1]:.3g}",
        f"{cells / waves:.4g} cells",
        key=f"wave {megapascal:.5g} MPa",
        fine=partial(wave, waves=1, phase=PHASES[0]),
        others=tuple(partial(wave, waves=1, phase=phase) for phase in PHASES[1:]),
    )


def wave_whole(split: str) -> Iterator[Case]:
    grids = {
        "tuned": (160, 200, 240, 260, 320, 500),
        "held-out": (180, 220, 250, 256, 280, 400, 512),
        "fresh": (170, 195, 245, 290, 330, 390, 440),
    }
    for cells in grids[split]:
        for load in (50, 100, 200):
            yield wave_case(load, cells, 20, (0.0, 0.0))


def wave_random(split: str) -> Iterator[Case]:
    random = generator("wave-random", split)
    for cells in WAVE_GRIDS:
        for load in (50, 100, 200):
            yield wave_case(load, cells, 20, tuple(random.uniform(0.0, 2 * np.pi, 2)))


def wave_other(split: str) -> Iterator[Case]:
    """Waves at 3 to 65 % contact, 5 to 25 cells a wave, whole or not, phase zero or not."""
    random = generator("wave-other", split)
    # Full contact is at 50.6 GPa.
    loads = {
        "tuned": (700.0, 2500.0, 8000.0, 20000.0),
        "held-out": (400.0, 1400.0, 5000.0, 13000.0),
        "fresh": (480.0, 1650.0, 5600.0, 15000.0),
    }
    for load in loads[split]:
        for number in range(16):
            waves = int(random.integers(2, 8))
            cells = round(log_uniform(random, 5, 26) * (1 if number % 2 else waves))
            cells *= waves if number % 2 else 1
            phase = (0.0, 0.0) if number % 4 < 2 else tuple(random.uniform(0.0, 2 * np.pi, 2))
            yield wave_case(load, cells, waves, phase)


# --- summits with closed forms ----------------------------------------------------------------------------------------


def paraboloid(
    cells: int, radii: tuple[float, float], center: tuple[float, float], angle: float, power: float = 2.0
) -> rc.ContactProblem:
    """Return a summit on a free boundary, its cells of 1 m; a height map unless it is a paraboloid along the axes."""
    grid = rc.Grid((cells, cells), float(cells))
    if angle == 0.0 and power == 2.0:
        return rc.ContactProblem(rc.Body(rc.ParaboloidSurface(radii, center=center), ELASTIC), grid=grid)
    x, y = grid.x - center[0], grid.y - center[1]
    along, across = np.cos(angle) * x + np.sin(angle) * y, np.cos(angle) * y - np.sin(angle) * x
    if power == 2.0:
        heights = -(along**2) / (2 * radii[0]) - across**2 / (2 * radii[1])
    else:
        heights = -(np.hypot(x, y) ** power) / radii[0]
    return rc.ContactProblem(rc.Body(rc.HeightMap(heights, size=float(cells)), ELASTIC))


def ball(split: str, centred: bool) -> Iterator[Case]:
    random = generator("ball", centred, split)
    for number in range(72):
        a = log_uniform(random, 0.5, 20.0)
        cells = (64 if a > 8 else 32) + number % 2
        center = (0.0, 0.0) if centred else tuple(random.uniform(-0.5, 0.5, 2) * 2.0)
        force = 4 * a**3 / 3 / (radius := 1e3 * a)
        exact = hertz_sphere(force, radius, 1.0)
        yield Case(
            partial(paraboloid, cells, (radius, radius), center, 0.0),
            {"force": force},
            f"a = {a:.3g} cells, {cells} cells, {number}",
            group_of_radius(a),
            {"area": exact.area, "p_max": exact.p_max, "approach": exact.approach, "perimeter": 2 * np.pi * a},
        )


def group_of_radius(a: float) -> str:
    return next(f"a < {limit}" for limit in (1, 2, 4, 8, 16, 99) if a < limit)


def ellipse(split: str, centred: bool) -> Iterator[Case]:
    """Ellipses of axis ratio up to 5, along the axes and at any angle."""
    random = generator("ellipse", centred, split)
    for number in range(60):
        ratio, minor = log_uniform(random, 1.1, 8.0), log_uniform(random, 0.6, 9.0)
        radius = 1e3 * minor
        force = 4 * minor**3 / 3 / radius
        exact = hertz_elliptic(force, (ratio * radius, radius), 1.0)
        while exact.semi_axes[1] < minor:
            force *= 1.1
            exact = hertz_elliptic(force, (ratio * radius, radius), 1.0)
        angle = (0.0, np.pi / 4, math.atan(0.5), random.uniform(0.0, np.pi))[number % 4]
        cells = int(min(128, 2 * math.ceil(1.4 * exact.semi_axes[0]) + 10)) + number % 2
        center = (0.0, 0.0) if centred else tuple(random.uniform(-0.5, 0.5, 2))
        e = 1 - (exact.semi_axes[1] / exact.semi_axes[0]) ** 2
        yield Case(
            partial(paraboloid, cells, (ratio * radius, radius), center, angle),
            {"force": force},
            f"axes {exact.semi_axes[0]:.3g} {exact.semi_axes[1]:.3g} cells, angle {angle:.3g}, {number}",
            group_of_radius(exact.semi_axes[1]),
            {
                "area": exact.area,
                "p_max": exact.p_max,
                "approach": exact.approach,
                "perimeter": 4 * exact.semi_axes[0] * float(ellipe(e)),
            },
        )


def cone(split: str, power: float) -> Iterator[Case]:
    """Cones and r^3: F = 2 n kappa c E* a^(n + 1) / (n + 1), kappa = sqrt(pi) Gamma(n/2 + 1) / Gamma((n + 1)/2).

    Popov, Hess, Willert, Handbook of Contact Mechanics (2019), sec. 2.3.8, https://doi.org/10.1007/978-3-662-58709-6.
    """
    random = generator("cone", power, split)
    kappa = math.sqrt(math.pi) * gamma(power / 2 + 1) / gamma((power + 1) / 2)
    for number in range(60):
        a = log_uniform(random, 0.7, 16.0)
        cells = (64 if a > 8 else 32) + number % 2
        center = (0.0, 0.0) if number % 4 < 2 else tuple(random.uniform(-0.5, 0.5, 2))
        c = 1e-3 / a ** (power - 1)
        true = {"area": np.pi * a**2, "approach": kappa * c * a**power, "perimeter": 2 * np.pi * a}
        yield Case(
            partial(paraboloid, cells, (1 / c, 1 / c), center, 0.0, power),
            {"force": 2 * power * kappa * c * a ** (power + 1) / (power + 1)},
            f"r^{power:g}, a = {a:.3g} cells, {number}",
            group_of_radius(a),
            true,
        )


# --- strips -----------------------------------------------------------------------------------------------------------


def strip(cells: int, along: tuple[int, int], phase: float) -> rc.ContactProblem:
    grid = rc.Grid((cells, cells), 1.0)
    heights = 0.01 * np.cos(2 * np.pi * (along[0] * grid.x + along[1] * grid.y) + phase)
    return rc.ContactProblem(rc.Body(rc.HeightMap(heights, size=1.0, periodic=True), ELASTIC), boundary="periodic")


def strip_values(exact: Westergaard, pressure: float) -> dict[str, float]:
    """Return what is known of one-dimensional waves: stiff as flat punches, L ln(sin(pi a / L)) 2 / (pi E*)."""
    square = pressure / exact.full_contact_pressure
    approach = exact.amplitude * square * (1.0 - math.log(square))
    return {
        "p_max": float(exact.pressure(np.zeros(1), pressure)[0]),
        # Lines of the wave per unit of area: the length of its edges is twice that.
        "perimeter": 2 / exact.wavelength,
        "approach": approach,
        "mean_gap": exact.amplitude - approach,
    }


def strips(split: str, directions: tuple[tuple[int, int], ...]) -> Iterator[Case]:
    """One-dimensional waves of 6 to 64 cells, half-widths of 0.7 to 20 cells."""
    random = generator("strips", directions, split)
    for number in range(48):
        base = directions[number % len(directions)]
        repeats = int(random.integers(1, 4))
        along = (base[0] * repeats, base[1] * repeats)
        cells = int(random.integers(48, 97))
        wavelength = 1.0 / math.hypot(*along)
        exact = Westergaard(0.01, wavelength, 1.0)
        half = log_uniform(random, 0.7, min(20.0, 0.4 * wavelength * cells))
        pressure = exact.full_contact_pressure * math.sin(math.pi * half / cells / wavelength) ** 2
        phase = 0.0 if number % 4 == 0 else random.uniform(0.0, 2 * np.pi)
        true = {"area": 2 * exact.half_width(pressure) / wavelength, **strip_values(exact, pressure)}
        yield Case(
            partial(strip, cells, along, phase),
            {"pressure": pressure},
            f"{along}, half-width {half:.3g} cells, N = {cells}, {number}",
            group_of_radius(half),
            true,
        )
