"""Classes of contacts of unkind geometry with closed forms: long domains and cells, slender ellipses, tips, holes.

As in `benchmarks/contact_classes.py`, each has a tuned, a held-out and a fresh split of other seeds. All boundaries are
free but those of strips and lines; numbers of cells are odd, composite and prime; the modulus is 1 Pa.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np
from contact_classes import ELASTIC, Case, generator, group_of_radius, log_uniform, strip_values
from scipy.integrate import quad
from scipy.ndimage import maximum_filter
from scipy.optimize import minimize_scalar
from scipy.special import ellipe, gamma

import roughcontact as rc
from roughcontact.reference import Westergaard, hertz_elliptic, hertz_sphere

COUNT = 30  # cases of each class
SHORT_SIDES = (13, 15, 17, 21, 24, 25)  # cells: odd, composite, prime


def _along(axis: int, first: Any, second: Any) -> tuple[Any, Any]:
    """Return the first along an axis and the second along the other."""
    return (first, second) if axis == 0 else (second, first)


def summit(
    shape: tuple[int, int],
    cell: tuple[float, float],
    center: tuple[float, float],
    curvatures: tuple[float, float],
    power: float = 2.0,
    holes: tuple[float, int, int, int] | None = None,
) -> rc.ContactProblem:
    """Return the summit r^power / power, r^2 = curvatures (x^2, y^2), on cells of these sides.

    Of the cells beyond the radius holes[0] + 1 about the fraction 1 / holes[1] is not measured, by the seed holes[2],
    in groups of holes[3] x holes[3].
    """
    grid = rc.Grid(shape, (shape[0] * cell[0], shape[1] * cell[1]))
    x, y = grid.x - center[0], grid.y - center[1]
    heights = -((curvatures[0] * x**2 + curvatures[1] * y**2) ** (power / 2)) / power
    if holes is None:
        return rc.ContactProblem(rc.Body(rc.HeightMap(heights, size=grid.size), ELASTIC))
    radius, every, seed, side = holes
    mask = np.random.default_rng(seed).random(shape) < 1.0 / (every * side**2)
    mask = maximum_filter(mask, side) & (np.hypot(x, y) > radius + 1.0)
    return rc.ContactProblem(rc.Body(rc.HeightMap(heights, size=grid.size, non_measured=mask), ELASTIC))


def summit_case(
    label: str,
    semi_axes: tuple[float, float],
    shape: tuple[int, int],
    cell: tuple[float, float],
    center: tuple[float, float],
    curvatures: tuple[float, float],
    force: float,
) -> Case:
    a, b = semi_axes
    exact = hertz_elliptic(force, (1.0 / curvatures[0], 1.0 / curvatures[1]), 1.0)
    true = {
        "area": math.pi * a * b,
        "p_max": exact.p_max,
        "perimeter": 4 * a * float(ellipe(1 - (b / a) ** 2)),
        "approach": exact.approach,
    }
    width = b / math.sqrt(cell[0] * cell[1])
    make = partial(summit, shape, cell, center, curvatures)
    return Case(make, {"force": force}, label, group_of_radius(min(width, 98.0)), true)


def long_domain(split: str) -> Iterator[Case]:
    """Balls anywhere in domains 1 : 8 and 8 : 1, at least two cells of a border away."""
    random = generator("long-domain", split)
    for number in range(COUNT):
        short = int(random.choice(SHORT_SIDES))
        shape = (8 * short + 1, short) if number % 2 else (short, 8 * short + 1)
        a = log_uniform(random, 0.7, 0.5 * short - 3.0)
        free = [max(0.5 * n - a - 3.0, 0.0) for n in shape]
        center = (random.uniform(-free[0], free[0]), random.uniform(-free[1], free[1]))
        curvature = 1e-3 / a
        yield summit_case(
            f"{shape}, a = {a:.3g} cells, {number}", (a, a), shape, (1.0, 1.0), center, (curvature, curvature),
            4 * a**3 * curvature / 3,
        )  # fmt: skip


def long_cells(split: str) -> Iterator[Case]:
    """Balls on cells 1 : 3 and 3 : 1."""
    random = generator("long-cells", split)
    for number in range(COUNT):
        long = 3.0 if number % 3 else 2.0
        cell = (long, 1.0) if number % 2 else (1.0, long)
        a = log_uniform(random, 1.5, 14.0)
        shape = tuple(2 * math.ceil(1.5 * a / side + 4) + number % 2 for side in cell)
        center = (random.uniform(-0.5, 0.5) * cell[0], random.uniform(-0.5, 0.5) * cell[1])
        curvature = 1e-3 / a
        yield summit_case(
            f"cells {cell}, a = {a:.3g}, {number}", (a, a), shape, cell, center, (curvature, curvature),
            4 * a**3 * curvature / 3,
        )  # fmt: skip


def slender(split: str) -> Iterator[Case]:
    """Ellipses of radii 3 to 50 : 1 in domains of their shape."""
    random = generator("slender", split)
    for number in range(COUNT):
        ratio, b = log_uniform(random, 3.0, 50.0), log_uniform(random, 0.7, 6.0)
        radius = 1e3 * b
        unit = hertz_elliptic(1.0, (ratio * radius, radius), 1.0)
        force = (b / unit.semi_axes[1]) ** 3  # all lengths of the contact grow with the cube root of the load
        a = unit.semi_axes[0] * b / unit.semi_axes[1]
        shape = (2 * math.ceil(1.3 * a + 3) + number % 2, 2 * math.ceil(1.3 * b + 3) + number % 3 % 2)
        center = (random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5))
        curvatures = (1.0 / (ratio * radius), 1.0 / radius)
        if turned := number % 4 > 1:
            shape, curvatures = shape[::-1], curvatures[::-1]
        yield summit_case(
            f"radii {ratio:.3g} : 1, axes {a:.3g} {b:.3g} cells{', turned' * turned}, {number}",
            (a, b), shape, (1.0, 1.0), center, curvatures, force,
        )  # fmt: skip


def find_maximum(power: float) -> float:
    """Return the maximum over r of the integral of s^(power - 1) / sqrt(s^2 - r^2) from r to 1: a ring if blunt."""

    def lack(r: float) -> float:
        return -float(quad(lambda t: (t**2 + r**2) ** (0.5 * power - 1.0), 0.0, math.sqrt(1.0 - r**2))[0])

    return -float(minimize_scalar(lack, bounds=(0.0, 1.0)).fun) if power > 2.0 else 1.0 / (power - 1.0)


def tip(split: str, power: float) -> Iterator[Case]:
    """Tips r^power of many sizes; see `contact_classes.cone` for the closed form."""
    random = generator("tip", power, split)
    kappa = math.sqrt(math.pi) * gamma(power / 2 + 1) / gamma((power + 1) / 2)
    for number in range(COUNT):
        a = log_uniform(random, 0.7, 16.0)
        cells = 2 * math.ceil(1.6 * a + 5) + number % 2
        center = (0.0, 0.0) if number % 4 == 0 else (random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5))
        c = 1e-3 / a ** (power - 1)
        scale = (power * c) ** (2 / power)
        true = {"area": math.pi * a**2, "approach": kappa * c * a**power, "perimeter": 2 * math.pi * a}
        if power > 1.0:
            true["p_max"] = power * kappa * c * a ** (power - 1) / math.pi * find_maximum(power)
        yield Case(
            partial(summit, (cells, cells), (1.0, 1.0), center, (scale, scale), power),
            {"force": 2 * power * kappa * c * a ** (power + 1) / (power + 1)},
            f"r^{power:g}, a = {a:.3g} cells, {number}",
            group_of_radius(a),
            true,
        )


def holes_outside(split: str, side: int) -> Iterator[Case]:
    """Balls with 1 to 10 % non-measured points, single or in groups, all outside the contact."""
    random = generator("holes-outside", *((side,) if side > 1 else ()), split)
    for number in range(COUNT):
        a = log_uniform(random, 1.5, 16.0)
        cells = 2 * math.ceil(1.6 * a + 6) + number % 2
        center = (random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5))
        every = (100, 33, 10)[number % 3]
        curvature = 1e-3 / a
        force = 4 * a**3 * curvature / 3
        exact = hertz_sphere(force, 1.0 / curvature, 1.0)
        yield Case(
            partial(
                summit,
                (cells, cells),
                (1.0, 1.0),
                center,
                (curvature, curvature),
                holes=(a, every, 97 * number + 1, side),
            ),
            {"force": force},
            f"a = {a:.3g} cells, one of {every}, {number}",
            group_of_radius(a),
            {
                "area": math.pi * a**2,
                "p_max": exact.p_max,
                "perimeter": 2 * math.pi * a,
                "approach": exact.approach,
            },
        )


def long_strip(shape: tuple[int, int], size: tuple[float, float], along: tuple[int, int]) -> rc.ContactProblem:
    grid = rc.Grid(shape, size)
    phase = 2 * np.pi * (along[0] * grid.x / size[0] + along[1] * grid.y / size[1])
    heights = 0.01 * np.cos(phase + 1.0)
    return rc.ContactProblem(rc.Body(rc.HeightMap(heights, size=size, periodic=True), ELASTIC), boundary="periodic")


def strips(split: str) -> Iterator[Case]:
    """Oblique waves 2:3, 1:3, 1:4 and straight ones, on square and on long cells, with odd numbers of cells."""
    random = generator("strips-unkind", split)
    for number in range(COUNT):
        along = ((2, 3), (1, 3), (4, 1), (3, 1), (2, 0), (0, 3))[number % 6]
        size = ((1.0, 1.0), (1.0, 3.0), (3.0, 1.0))[number // 6 % 3]
        cells = int(random.integers(30, 60)) * 2 + 1
        wavelength = 1.0 / math.hypot(along[0] / size[0], along[1] / size[1])
        exact = Westergaard(0.01, wavelength, 1.0)
        fraction = random.uniform(0.1, 0.8)
        pressure = exact.full_contact_pressure * math.sin(0.5 * math.pi * fraction) ** 2
        wide, values = size[0] * size[1], strip_values(exact, pressure)
        coarse = math.sqrt(wide) / cells
        true = {**values, "area": fraction * wide, "perimeter": wide * values["perimeter"]}
        yield Case(
            partial(long_strip, (cells, cells), size, along),
            {"pressure": pressure},
            f"{along}, {size}, {100 * fraction:.3g} % of N = {cells}, {number}",
            group_of_radius(0.5 * fraction * wavelength / coarse),
            true,
        )


def roller(shape: tuple[int, int], size: tuple[float, float], axis: int, place: float) -> rc.ContactProblem:
    """Return a cylinder of radius 1 km, free along the axis and periodic along its own."""
    body = rc.Body(rc.ParaboloidSurface(_along(axis, 1e3, math.inf), _along(axis, place, 0.0)), ELASTIC)
    return rc.ContactProblem(body, grid=rc.Grid(shape, size), boundary=_along(axis, "free", "periodic"))


def lines(split: str) -> Iterator[Case]:
    """Cylinders of 1 to 32 cells half width anywhere in a cell, on cells 1 : 3 and 3 : 1, of 1 to 33 cells along."""
    random = generator("lines", split)
    for number in range(2 * COUNT):
        axis = number % 2
        half = log_uniform(random, 1.0, 32.0)
        across = int(half * random.uniform(2.4, 6.0)) + 7
        along = int(random.choice((1, 2, 7, 33)))
        side = (1.0, 3.0, 1.0 / 3.0)[number // 2 % 3]
        size = (float(across), along * side)
        load = math.pi * half**2 / (4.0 * 1e3)
        place = random.uniform(-0.5, 0.5) * min(0.4 * (across - 2.0 * half), 8.0)
        true = {
            "area": 2.0 * half * size[1],
            "p_max": 2.0 * load / (math.pi * half),
            "perimeter": 2.0 * size[1],
            "approach": load / math.pi * (2.0 * math.log(2.0 * size[0] / half) + 1.0),
        }
        yield Case(
            partial(roller, _along(axis, across, along), _along(axis, *size), axis, place),
            {"force": load * size[1]},
            f"axis {axis}, half width {half:.3g} of {across} cells, {along} along, side {side:.2g}, {number}",
            group_of_radius(half),
            true,
        )


CLASSES = {
    "lines": lines,
    "long-domain": long_domain,
    "long-cells": long_cells,
    "slender": slender,
    **{f"tip-{power:g}": partial(tip, power=power) for power in (1.0, 1.5, 2.0, 3.0, 4.0)},
    "strips-unkind": strips,
    "holes-outside": partial(holes_outside, side=1),
    "blobs-outside": partial(holes_outside, side=4),
}
