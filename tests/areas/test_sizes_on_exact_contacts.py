"""Answers about contacts with a closed form: right within their uncertainties, and these no larger than they must be.

Strips of Westergaard in any direction of the grid, balls, ellipsoids and rollers of Hertz, cones and quartic tips of
Galin: anywhere in their cells, which are oblong; many cells and few.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import optimize, special

import roughcontact as rc
from roughcontact import reference

POISSON = 0.3
MODULUS = 1e9
BODY = rc.Elastic(MODULUS * (1.0 - POISSON**2), POISSON)
SLOPE = 1e-3
# Side of a square cell, m: not one, or its powers would be alike.
SIDE = 0.3


def stress_on_axis():
    """Return the maximum von Mises stress below a ball over p0: Johnson, Contact Mechanics (1985), eq. 3.45."""

    def mises(z):
        along = 1.0 / (1.0 + z**2)
        return 1.5 * along - (1.0 + POISSON) * (1.0 - z * math.atan(1.0 / z))

    return -optimize.minimize_scalar(lambda z: -mises(z), bounds=(0.2, 1.0), method="bounded").fun


def solve(heights, grid, boundary="free", **load):
    body = rc.Body(rc.HeightMap(heights + np.zeros(grid.shape), size=grid.size, periodic=boundary == "periodic"), BODY)
    return rc.ContactProblem(body, boundary=boundary, threads=1).solve(**load)


def make_strips(rng, direction, cells):
    """Strips of a width of so many cells, one or more, along a lattice vector of the domain."""
    load = rng.uniform(0.1, 0.5)
    part = 2.0 / math.pi * math.asin(math.sqrt(load))
    turns = {
        "straight": (1, 0),
        "diagonal": (1, 1) if rng.integers(2) else (-1, 1),
        "oblique": ((1, 2), (2, 1), (1, -2), (3, 1))[rng.integers(4)],
    }[direction]
    if direction == "straight" and rng.integers(2):
        turns = turns[::-1]
    shape = (int(rng.integers(34, 44)), int(rng.integers(34, 44)))
    if direction == "diagonal":
        shape = (shape[0], shape[0])
    ratio = 1.0 if direction == "diagonal" else (1.0, 0.5, 1.5)[rng.integers(3)]
    # As many waves as make the strips so wide.
    wanted = max(round(part * shape[0] / (math.hypot(*turns) * cells)), 1)
    grid = rc.Grid(shape, (SIDE * shape[0], SIDE * ratio * shape[1]))
    qx, qy = (wanted * turn / side for turn, side in zip(turns, grid.size, strict=True))
    wave = 1.0 / math.hypot(qx, qy)
    heights = SLOPE * wave * np.cos(2.0 * np.pi * (qx * grid.x + qy * grid.y) + rng.uniform(0.0, 6.28))
    full = math.pi * MODULUS * SLOPE
    solution = solve(heights, grid, "periodic", pressure=load * full)
    gap = SLOPE * wave * (1.0 - load * (1.0 - math.log(load)))
    # The approach grows by -A ln(load) for each p*.
    stiffness = full * grid.area / (-math.log(load) * SLOPE * wave)
    return solution, {
        "area": part * grid.area,
        "perimeter": 2.0 * grid.area / wave,
        "peak-pressure": 2.0 * full * math.sqrt(load),
        "mean-gap": gap,
        "approach": SLOPE * wave - gap,
        "stiffness": stiffness,
        "conductance": stiffness / MODULUS,
    }


def make_grid(rng, half_sides):
    """Return a grid of cells of one area with room around these, m, and x and y from a place near its centre."""
    ratio = (1.0, 0.5, 2.0)[rng.integers(3)]
    sides = SIDE * math.sqrt(1.0 / ratio), SIDE * math.sqrt(ratio)
    shape = tuple(
        int(2.6 * half / side) + int(rng.integers(5, 8)) for half, side in zip(half_sides, sides, strict=True)
    )
    grid = rc.Grid(shape, (shape[0] * sides[0], shape[1] * sides[1]))
    place = rng.uniform(-0.5, 0.5, 2) * grid.spacing
    return grid, grid.x - place[0], grid.y - place[1]


def make_ellipse(rng, ratio, cells):
    """Hertz's contact with an area of so many square cells times pi, turned by any angle."""
    size = SIDE * cells
    radius = 100.0 * size
    radii = radius / math.sqrt(ratio), radius * math.sqrt(ratio)
    force = 4.0 / 3.0 * MODULUS * size**3 / radius
    exact = (
        reference.hertz_sphere(force, radius, MODULUS)
        if ratio == 1.0
        else reference.hertz_elliptic(force, radii, MODULUS)
    )
    short, long = sorted(exact.semi_axes)
    grid, x, y = make_grid(rng, (long, long))
    angle = rng.uniform(0.0, math.pi)
    u, v = math.cos(angle) * x + math.sin(angle) * y, math.cos(angle) * y - math.sin(angle) * x
    solution = solve(-(u**2) / (2.0 * radii[0]) - v**2 / (2.0 * radii[1]), grid, force=force)
    # F = b^(3/2) times a number, so that the stiffness is 3 F / 2 b.
    stiffness = 1.5 * force / exact.approach
    answers = {
        "area": exact.area,
        "perimeter": 4.0 * long * special.ellipe(1.0 - (short / long) ** 2),
        "peak-pressure": exact.p_max,
        "approach": exact.approach,
        "patches": 1.0,
        "stiffness": stiffness,
        "conductance": stiffness / MODULUS,
    }
    return solution, answers | ({"stress": stress_on_axis() * exact.p_max} if ratio == 1.0 else {})


def make_power(rng, power, cells):
    """Galin: the approach under c r^n is c a^n sqrt(pi) G(n/2 + 1) / G(n/2 + 1/2)."""
    size = SIDE * cells
    rise = 0.01 * size
    approach = rise * math.sqrt(math.pi) * math.gamma(0.5 * power + 1.0) / math.gamma(0.5 * power + 0.5)
    grid, x, y = make_grid(rng, (size, size))
    force = 2.0 * MODULUS * power / (power + 1.0) * approach * size
    solution = solve(-rise * (np.hypot(x, y) / size) ** power, grid, force=force)
    return solution, {
        "area": math.pi * size**2,
        "perimeter": 2.0 * math.pi * size,
        "approach": approach,
        "patches": 1.0,
        "stiffness": 2.0 * MODULUS * size,
        "conductance": 2.0 * size,
    }


def make_roller(rng, axis, cells):
    """A cylinder on a domain that repeats along it: Johnson, section 4.2 (c)."""
    half = SIDE * cells
    grid, x, y = make_grid(rng, (half, 8.0 * SIDE) if axis == 0 else (8.0 * SIDE, half))
    radius, length = 100.0 * half, grid.size[1 - axis]
    load = math.pi * MODULUS * half**2 / (4.0 * radius)
    boundary = ("free-periodic", "periodic-free")[axis]
    across = (x, y)[axis]
    body = rc.Body(rc.HeightMap(-(across**2) / (2.0 * radius) + np.zeros(grid.shape), size=grid.size), BODY)
    solution = rc.ContactProblem(body, boundary=boundary, threads=1).solve(force=load * length)
    return solution, {
        "area": 2.0 * half * length,
        "perimeter": 2.0 * length,
        "peak-pressure": 2.0 * load / (math.pi * half),
    }


def ask(solution, names):
    found = {}
    for name in names:
        if name == "area":
            found[name] = solution.area(uncertainty="model")
        elif name == "conductance":
            # Both resistances together are those of bodies of conductivity one.
            found[name] = solution.conductance((0.75, 1.5))
        elif name == "stress":
            found[name] = solution.stress().maximum
        else:
            found[name] = solution.response(name, uncertainty="model")
    return found


MAKERS = {
    "straight": (make_strips, "straight"),
    "diagonal": (make_strips, "diagonal"),
    "oblique": (make_strips, "oblique"),
    "ball": (make_ellipse, 1.0),
    "ellipsoid": (make_ellipse, 3.0),
    "cone": (make_power, 1.0),
    "quartic": (make_power, 4.0),
    "roller along y": (make_roller, 0),
    "roller along x": (make_roller, 1),
}
# Largest standard deviation over the value, by kind, cells and answer.
LARGEST = {
    ("straight", 4.0): {
        "area": 0.045,
        "perimeter": 2e-9,
        "peak-pressure": 0.043,
        "mean-gap": 0.074,
        "approach": 0.027,
        "stiffness": 0.065,
        "conductance": 0.065,
    },
    ("straight", 9.0): {
        "area": 0.012,
        "perimeter": 2e-9,
        "peak-pressure": 0.0056,
        "mean-gap": 0.018,
        "approach": 0.0068,
        "stiffness": 0.042,
        "conductance": 0.042,
    },
    ("diagonal", 4.0): {
        "area": 0.022,
        "perimeter": 0.11,
        "peak-pressure": 0.0072,
        "mean-gap": 0.028,
        "approach": 0.0063,
        "stiffness": 0.055,
        "conductance": 0.055,
    },
    ("diagonal", 9.0): {
        "area": 0.0091,
        "perimeter": 0.096,
        "peak-pressure": 0.00076,
        "mean-gap": 0.0026,
        "approach": 0.0012,
        "stiffness": 0.035,
        "conductance": 0.035,
    },
    ("oblique", 4.0): {
        "area": 0.026,
        "perimeter": 0.18,
        "peak-pressure": 0.0096,
        "mean-gap": 0.038,
        "approach": 0.0087,
        "stiffness": 0.061,
        "conductance": 0.061,
    },
    ("oblique", 9.0): {
        "area": 0.0053,
        "perimeter": 0.11,
        "peak-pressure": 0.0052,
        "mean-gap": 0.014,
        "approach": 0.0059,
        "stiffness": 0.013,
        "conductance": 0.013,
    },
    ("ball", 4.0): {
        "area": 0.00018,
        "perimeter": 0.0038,
        "peak-pressure": 0.00018,
        "approach": 0.0032,
        "patches": 2e-9,
        "stiffness": 0.013,
        "conductance": 0.013,
        "stress": 0.01,
    },
    ("ball", 9.0): {
        "area": 2.8e-05,
        "perimeter": 0.0038,
        "peak-pressure": 4.9e-05,
        "approach": 0.00042,
        "patches": 2e-9,
        "stiffness": 0.0025,
        "conductance": 0.0025,
        "stress": 0.0017,
    },
    ("ellipsoid", 4.0): {
        "area": 7.8e-05,
        "perimeter": 0.0038,
        "peak-pressure": 9.1e-05,
        "approach": 0.0047,
        "patches": 2e-9,
        "stiffness": 0.014,
        "conductance": 0.014,
    },
    ("ellipsoid", 9.0): {
        "area": 5.3e-06,
        "perimeter": 0.0038,
        "peak-pressure": 3e-05,
        "approach": 0.00043,
        "patches": 2e-9,
        "stiffness": 0.003,
        "conductance": 0.003,
    },
    ("cone", 4.0): {
        "area": 0.018,
        "perimeter": 0.092,
        "approach": 0.0055,
        "patches": 0.57,
        "stiffness": 0.13,
        "conductance": 0.13,
    },
    ("cone", 9.0): {
        "area": 0.0052,
        "perimeter": 0.08,
        "approach": 0.0016,
        "patches": 0.56,
        "stiffness": 0.059,
        "conductance": 0.059,
    },
    ("quartic", 4.0): {
        "area": 0.057,
        "perimeter": 0.052,
        "approach": 0.0061,
        "patches": 0.4,
        "stiffness": 0.09,
        "conductance": 0.09,
    },
    ("quartic", 9.0): {
        "area": 0.019,
        "perimeter": 0.029,
        "approach": 0.00056,
        "patches": 0.2,
        "stiffness": 0.021,
        "conductance": 0.021,
    },
    ("roller along y", 4.0): {"area": 0.008, "perimeter": 2e-9, "peak-pressure": 0.0062},
    ("roller along y", 9.0): {"area": 0.00083, "perimeter": 2e-9, "peak-pressure": 0.00057},
    ("roller along x", 4.0): {"area": 0.008, "perimeter": 2e-9, "peak-pressure": 0.0062},
    ("roller along x", 9.0): {"area": 0.0016, "perimeter": 2e-9, "peak-pressure": 0.0011},
}


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(("name", "cells"), LARGEST)
def test_answers_are_right_within_uncertainties_of_a_known_size(name, cells, seed):
    make, kind = MAKERS[name]
    solution, exact = make(np.random.default_rng([seed, int(cells)]), kind, cells)
    for quantity, found in ask(solution, exact).items():
        true = exact[quantity]
        assert abs(found.value - true) <= 2.5 * found.uncertainty + 1e-6 * true, quantity
        assert found.uncertainty <= LARGEST[name, cells][quantity] * true, quantity
