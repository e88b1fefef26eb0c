"""Balls that attract a flat, on rings instead of cells: answers for `adhesion_classes.py`.

Lengths over the contact radius of Johnson at zero load, E* = 1 Pa, and that radius over the radius of the ball is
SLOPE. Rings of uniform pressure, of which the displacement is in closed form; Newton's method on the pressures of all
rings. Nothing here is shared with the solvers of the package.
"""

from __future__ import annotations

import json
import math
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

import roughcontact as rc

Array = np.ndarray

ANSWERS = Path(__file__).parent / "adhesion_references.json"
SLOPE = 0.05
RADIUS = 1.0 / SLOPE
WORK = SLOPE**2 / (4.5 * math.pi)
RINGS = (400, 800)
# Rings of which the first equilibrium is found.
FEWEST = 200
# Maugis' parameter and smoothing; Tabor's parameter.
DUGDALE = (
    *((0.1, 0.2), (0.1, 0.5), (0.2, 0.3), (0.35, 0.2), (0.35, 0.5), (0.6, 0.3), (1.0, 0.2), (1.0, 0.5)),
    *((1.4, 0.3), (1.9, 0.2), (2.0, 0.5), (2.4, 0.3), (3.0, 0.5), (4.0, 0.5)),
)
EXPONENTIAL = (0.1, 0.3, 0.6, 1.0, 1.4, 2.0, 2.5, 3.0)
# Fraction of the strength below which a tension counts as none.
FAINT = 1e-4


class BallAnswer(NamedTuple):
    """Force of pull-off, area at zero load, the radius up to which surfaces attract each other, and two errors."""

    pull_off: float
    area: float
    reach: float
    pull_off_std: float
    area_std: float


def displacement_of_rings(edges: Array, places: Array) -> Array:
    """Return the displacement at places, by a unit pressure on each ring between edges; Johnson, eq. 3.29."""
    b, x = edges[None, :], places[:, None]
    inside = np.minimum(x / np.where(b > 0.0, b, 1.0), 1.0) ** 2
    outside = np.minimum(b / x, 1.0) ** 2
    beyond = x * (ellipe(outside) - (1.0 - outside) * ellipk(np.minimum(outside, 1.0 - 1e-15)))
    return np.diff(4.0 / math.pi * np.where(x < b, b * ellipe(inside), beyond), axis=1)


def stretch(law: rc.Interaction, factor: float) -> rc.Interaction:
    """Return a law of the same work and of a range divided by a factor."""
    if isinstance(law, rc.Dugdale):
        return rc.Dugdale(law.work, law.strength * factor, law.smoothing)
    assert isinstance(law, rc.Exponential)
    return rc.Exponential(law.work, law.range / factor)


class _Rings:
    """The contact of a ball by rings up to a radius."""

    def __init__(self, law: rc.Interaction, outermost: float, count: int) -> None:
        self._take(law)
        self.edges = np.linspace(0.0, outermost, count + 1)
        self.places = 0.5 * (self.edges[1:] + self.edges[:-1])
        self.areas = math.pi * np.diff(self.edges**2)
        self.matrix = displacement_of_rings(self.edges, self.places)
        self.heights = 0.5 * self.places**2 / RADIUS
        self.approach = 0.7 / RADIUS
        self.touching = int(np.count_nonzero(self.places < 1.0))
        self.gap = np.where(self.places < 1.0, 0.0, self.heights)
        self.pressure = np.where(self.places < 1.0, 0.0, -law.tension(self.gap))

    def _take(self, law: rc.Interaction) -> None:
        self.law = law
        self.strength = float(law.tension(np.zeros(1))[0])
        self.range = self.strength / law.steepest

    def start(self, law: rc.Interaction, approach: float) -> float:
        """Find the first equilibrium, from those of the same work with longer ranges; return the force."""
        factors = np.geomspace(min(1.0, 0.15 * SLOPE / self.range / RADIUS), 1.0, 12)
        for factor in factors:
            self._take(stretch(law, float(factor)))
            force = self.solve(approach)
        return force

    def start_from(self, coarse: _Rings) -> None:
        """Start from the state of fewer rings."""
        self.touching = round(coarse.touching * len(self.places) / len(coarse.places))
        self.gap = np.interp(self.places, coarse.places, coarse.gap)
        self.gap[: self.touching] = 0.0
        self.pressure = np.interp(self.places, coarse.places, coarse.pressure)

    def solve(self, approach: float, halvings: int = 6) -> float:
        """Bring the pressures to equilibrium at an approach, in smaller steps if need be, and return the force."""
        before = self.approach, self.touching, self.gap, self.pressure
        force = self._iterate(approach)
        if force is None:
            if halvings == 0:
                raise RuntimeError(f"no equilibrium at {approach}")
            self.approach, self.touching, self.gap, self.pressure = before
            self.solve(0.5 * (self.approach + approach), halvings - 1)
            return self.solve(approach, halvings - 1)
        self.approach = approach
        return force

    def _iterate(self, approach: float) -> float | None:
        """Return the force in equilibrium; None without one. The contact is a disc of rings."""
        touching = np.arange(len(self.gap)) < self.touching
        seen: set[int] = set()
        for turn in range(200):
            slope = self.law.slope(self.gap)
            matrix = np.where(touching[:, None], 1.0, slope[:, None]) * self.matrix
            opened = np.flatnonzero(~touching)
            matrix[opened, opened] += 1.0
            gap = self.matrix @ self.pressure + self.heights - approach
            law = self.pressure + self.law.tension(self.gap) + slope * (gap - self.gap)
            change = np.linalg.solve(matrix, -np.where(touching, gap, law))
            self.pressure = self.pressure + change
            gap = self.matrix @ self.pressure + self.heights - approach
            pulled = int(np.count_nonzero(touching & (self.pressure < -self.strength)))
            closed = int(np.count_nonzero(~touching & (gap < 0.0)))
            touched = self.touching
            settled = np.abs(change).max() < 1e-10 * self.strength
            # Large steps first; where they turn in a circle, one ring at a time from equilibrium to equilibrium.
            most = 8 if turn < 15 else 1
            if settled or turn < 15:
                self.touching += min(closed, most) if closed else -min(pulled, most)
            touching = np.arange(len(self.gap)) < self.touching
            # The law is linear only over a part of its range.
            near = np.clip(gap, self.gap - self.range, self.gap + self.range) if turn else gap
            self.gap = np.where(touching, 0.0, np.maximum(near, 0.0))
            # A ring may fit neither way: by less than its width.
            if settled and (touched in seen or not (closed or pulled)):
                return float(self.pressure @ self.areas)
            seen |= {touched} if settled else set()
        return None

    def contact_area(self) -> float:
        """Return the area within the radius at which the square of the contact pressure extrapolates to zero."""
        pressed = np.arange(self.touching)[-8:-1]
        squares = (self.pressure[pressed] + self.strength) ** 2
        r = self.places[pressed]
        coefficients = np.polyfit(r - r[-1], squares, 2)
        roots = np.roots(coefficients)
        roots = roots[np.isreal(roots)].real
        return math.pi * float(r[-1] + roots[roots > 0.0].min()) ** 2


def _follow(law: rc.Interaction, outermost: float, count: int) -> tuple[float, float, float]:
    """Return pull-off, area at zero load and reach by a number of rings."""
    rings = _Rings(law, outermost, count)
    approach = 0.7 / RADIUS
    step = 0.05 / RADIUS
    coarse = _Rings(law, outermost, FEWEST)
    coarse.start(law, approach)
    rings.start_from(coarse)
    force = rings.solve(approach)
    path = [(approach, force)]
    while force > 0.0:
        approach -= step
        force = rings.solve(approach)
        path.append((approach, force))
    rest = brentq(rings.solve, path[-1][0], path[-2][0], xtol=1e-7 / RADIUS)
    rings.solve(rest)
    area = rings.contact_area()
    tension = np.where(rings.gap > 0.0, -rings.pressure, rings.strength)
    reach = float(rings.edges[1:][tension > FAINT * rings.strength][-1])
    while force < 0.98 * min(each for _, each in path) or len(path) < 3:
        approach -= step
        force = rings.solve(approach)
        path.append((approach, force))
    for _ in range(4):
        lowest = min(range(1, len(path) - 1), key=lambda k: path[k][1])
        around = path[lowest - 1 : lowest + 2]
        path = [around[0]]
        for place, force in around[1:]:
            middle = 0.5 * (path[-1][0] + place)
            path += [(middle, rings.solve(middle)), (place, force)]
    lowest = min(range(1, len(path) - 1), key=lambda k: path[k][1])
    places, forces = np.array(path[lowest - 1 : lowest + 2]).T
    curvature, slope, value = np.polyfit(places - places[1], forces, 2)
    return value - slope**2 / (4.0 * curvature), area, reach


def find_answer(law: rc.Interaction, outermost: float) -> BallAnswer:
    """Return what a ball does under a law, from two numbers of rings up to a radius."""
    (coarse, wide, _), (fine, area, reach) = (_follow(law, outermost, count) for count in RINGS)
    # The error falls with the square of the width of a ring, or nearly so.
    return BallAnswer(fine, area, reach, abs(fine - coarse) / 2.0, abs(area - wide) / 2.0)


def make_laws() -> dict[str, tuple[rc.Interaction, float]]:
    """Return the laws by name, and the radius that each of them reaches from a ball that is pressed."""
    laws: dict[str, tuple[rc.Interaction, float]] = {}
    for transition, smoothing in DUGDALE:
        strength = 0.5 * transition * math.cbrt(math.pi * WORK * (4.0 / 3.0) ** 2 / RADIUS)
        gap = (1.0 + smoothing) * WORK / strength
        laws[f"Dugdale {transition:g} {smoothing:g}"] = rc.Dugdale(WORK, strength, smoothing), _outermost(gap)
    for tabor in EXPONENTIAL:
        length = math.cbrt(RADIUS * WORK**2) / tabor
        laws[f"Exponential {tabor:g}"] = rc.Exponential(WORK, length), _outermost(-math.log(FAINT) * length)
    return laws


def _outermost(gap: float) -> float:
    """Return the radius at which a ball that is pressed to 1.2 times the contact radius of Johnson has a gap."""
    return math.sqrt(1.2**2 + 2.0 * RADIUS * gap) + 0.05


@lru_cache(maxsize=1)
def load_answers() -> dict[str, BallAnswer]:
    """Return the answers in the file by the name of the law."""
    table = json.loads(ANSWERS.read_text(encoding="utf-8")) if ANSWERS.exists() else {}
    return {name: BallAnswer(*values) for name, values in table.items()}


def main() -> None:
    """Compute the answers that are missing and write them to the file."""
    table = dict(load_answers())
    for name, (law, outermost) in make_laws().items():
        if name not in table:
            table[name] = BallAnswer(*(float(f"{value:.8g}") for value in find_answer(law, outermost)))
            print(name, table[name], flush=True)
        rows = [f"{json.dumps(key)}: {json.dumps(values)}" for key, values in table.items()]
        ANSWERS.write_text("{\n" + ",\n".join(rows) + "\n}\n", encoding="utf-8")


if __name__ == "__main__":
    main()
