"""How Hertz's areas err beside the images of a contact, measured on ellipses in domains that repeat.

    python benchmarks/image_constants.py [number of ellipses] [seed]

Each ellipse, of random semi-axes up to .42 of the sides of the domain, is solved on a grid and on one four times finer,
whose traced area is taken for true. Prints for each the error of Hertz's area and its standard deviation by
FAR_FIELD_ERROR and WRAPPED_ERROR, and how many of the stated areas and maximum pressures are within two standard
deviations; half a minute. Then the same for two balls about half of a wrapped domain apart, by KINK_ERROR.
"""

from __future__ import annotations

import math
import sys
import warnings
from collections.abc import Iterator

import attrs
import numpy as np

import roughcontact as rc
from roughcontact._answers.areas import peak
from roughcontact._answers.areas.hertz import hertz_areas
from roughcontact._answers.areas.summits import find_lowest
from roughcontact.reference import hertz_elliptic

BOUNDARIES = (("free", "periodic"), ("periodic", "free"), "periodic", "wrapped")
CURVATURE = 1e-3  # 1/m, the larger principal one; the modulus is 1 Pa
REFINED = 4


@attrs.frozen
class Ellipse:
    """An ellipse in a domain that repeats; the centre is in cells from that of the domain."""

    boundary: str | tuple[str, str]
    size: tuple[float, float]
    shape: tuple[int, int]
    center: tuple[float, float]
    radii: tuple[float, float]
    force: float

    def press(self, finer: int = 1) -> rc.ContactSolution:
        """Return the contact on cells that are finer by a factor."""
        center = [place * side / cells for place, side, cells in zip(self.center, self.size, self.shape, strict=True)]
        body = rc.Body(rc.ParaboloidSurface(self.radii, center=tuple(center)), rc.Elastic(1.0, 0.0))
        grid = rc.Grid(tuple(finer * cells for cells in self.shape), self.size)
        return rc.ContactProblem(body, grid=grid, boundary=self.boundary).solve(force=self.force)


def find_radii(semi_axes: tuple[float, float]) -> tuple[tuple[float, float], float]:
    """Return the radii of curvature and the force of an ellipse on a half-space."""
    target = max(semi_axes) / min(semi_axes)
    low, high = 1.0, 1e4
    for _ in range(60):
        ratio = math.sqrt(low * high)
        one = hertz_elliptic(1.0, (1.0 / CURVATURE, ratio / CURVATURE), 1.0).semi_axes
        low, high = (ratio, high) if max(one) / min(one) < target else (low, ratio)
    radii = (1.0 / CURVATURE, low / CURVATURE)
    radii = radii if semi_axes[0] < semi_axes[1] else radii[::-1]
    one = hertz_elliptic(1.0, radii, 1.0).semi_axes
    return radii, (semi_axes[0] * semi_axes[1] / (one[0] * one[1])) ** 1.5


def list_ellipses(count: int, seed: int) -> Iterator[Ellipse]:
    """Yield ellipses of random axes in domains of sides 8:1 to 1:8."""
    rng = np.random.default_rng(seed)
    for number in range(count):
        aspect = 2.0 ** rng.uniform(-1.5, 1.5)
        size = (aspect, 1.0 / aspect)
        part = rng.uniform(0.05, 0.42, 2)
        shape = tuple(int(cells) for cells in rng.integers(40, 90, 2))
        center = tuple(float(place) for place in rng.uniform(-0.5, 0.5, 2))
        radii, force = find_radii((part[0] * size[0], part[1] * size[1]))
        yield Ellipse(BOUNDARIES[number % len(BOUNDARIES)], size, shape, center, radii, force)


def measure(case: Ellipse) -> tuple[tuple[float, float], tuple[float, float], tuple[float, float]]:
    """Return the relative error, and its standard deviation, of Hertz's area, of the area and of the maximum."""
    solution = case.press()
    fine = case.press(REFINED)
    true = fine.area("level-set-richardson")
    highest = find_lowest(fine, -fine.pressure)
    largest = float(peak._fit_quadratics(fine, highest, peak._find_sharpness(fine, highest))[0].max())
    hertz = hertz_areas(solution)
    stated = solution.area()
    maximum = solution.response("peak-pressure")
    return (
        (float(hertz.area[1]) / true.value - 1.0, float(hertz.error[1])),
        (stated.value / true.value - 1.0, math.hypot(stated.uncertainty, true.uncertainty) / true.value),
        # The maximum on the finer grid errs by some 4e-5.
        (maximum.value / largest - 1.0, math.hypot(maximum.uncertainty / largest, 4e-5)),
    )


def press_two_balls(distance: float, radius: float, finer: int = 1) -> rc.ContactSolution:
    """Return two balls at a distance along x in a wrapped domain of side 1, which touch in circles of a radius."""
    grid = rc.Grid((64 * finer, 64 * finer), 1.0)
    places = [grid.x + sign * 0.5 * distance for sign in (-1.0, 1.0)]
    # The nearest image of each ball.
    steps = [place - np.round(place) for place in places]
    heights = np.max([-0.5 * CURVATURE * (step**2 + grid.y**2) for step in steps], axis=0)
    body = rc.Body(rc.HeightMap(heights, grid.size, periodic=True), rc.Elastic(1.0, 0.0))
    force = 2.0 * 4.0 / 3.0 * CURVATURE * radius**3
    return rc.ContactProblem(body, boundary="wrapped").solve(force=force)


def measure_two_balls(distance: float, radius: float) -> tuple[float, float]:
    """Return the relative error of Hertz's areas of both balls together, and its standard deviation."""
    hertz = hertz_areas(press_two_balls(distance, radius))
    true = press_two_balls(distance, radius, REFINED).area("level-set-richardson").value
    return float(np.sum(hertz.area[1:])) / true - 1.0, float(np.mean(hertz.error[1:]))


if __name__ == "__main__":
    warnings.filterwarnings("ignore", category=rc.ContactWarning)
    given = [int(text) for text in sys.argv[1:]]
    count, seed = given + [60, 1][len(given) :]
    within = []
    for case in list_ellipses(count, seed):
        (error, std), *stated = measure(case)
        within.append([abs(one) <= 2.0 * allowed for one, allowed in stated])
        stds = f"FAR_FIELD_ERROR, WRAPPED_ERROR {100.0 * std:8.3f} %"
        print(f"{case.boundary!s:24}  Hertz {100.0 * error:8.3f} %   {stds}")
    area, maximum = 100.0 * np.mean(within, axis=0)
    print(f"within two standard deviations: areas {area:.0f} %, maximum pressures {maximum:.0f} %")
    for radius in (0.06, 0.1):
        for missed in (-1.0, -0.5, 0.0, 0.5, 1.0, 2.0):
            error, std = measure_two_balls(0.5 - missed * radius, radius)
            errors = f"Hertz {100.0 * error:8.3f} %   KINK_ERROR {100.0 * std:8.3f} %"
            print(f"radius {radius:.2f}, {missed:4.1f} radii off half  {errors}")
