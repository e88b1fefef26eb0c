"""Measure how often the stated uncertainties hold: of a body that flows, loaded, unloaded and loaded again.

``python measure_scenes.py [SCENES] [SEED] [FILE]`` draws balls, ellipsoids, wedges and rough surfaces (60 and seed 2 by
default; constants were set on other scenes and on the first 33 of these) on free, periodic and mixed boundaries, under
a path of three loads. It solves each on its grid, and on cells half as long with half the admissible change by the
substeps. That leaves about a quarter of what is wrong, so that the true value lies a third of the difference beyond.
True values are kept in the file, if one is named.

States whose contact reaches a free border, of which they warn, and those after them are omitted. A body that flows on
the finer grid alone has stated nothing, and errs by infinitely many uncertainties. Prints for each number how many
errors there are, the fraction of them within one and two standard deviations, the median error, relative, the median
uncertainty over it, and the scenes beyond two.
"""

from __future__ import annotations

import json
import sys
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import attrs
import numpy as np
import roughcontact as rc

from roughcontact_volume import (
    FindImprint,
    FindPlasticZone,
    FindResidualStress,
    FindTotalStress,
    LinearHardening,
    Plastic,
    SwiftHardening,
    VoceHardening,
)

YOUNG = 1.0
KINDS = ("ball", "ellipsoid", "wedge", "rough")
STATES = ("loaded", "unloaded", "again")
REFINEMENT = 2
# Admissible change by the substeps, over it of the reference.
SHARPER = 2.0
# Of the difference from the reference, what the reference itself is wrong.
BEYOND = 1.0 / 3.0
# Errors below this part of the value are noise of the tolerances.
NOISE = 1e-5


@attrs.frozen
class Wedge(rc.Surface):
    """A wedge along y of a slope, rounded over a length, m, that curves along y with a radius, m, or is straight."""

    slope: float
    rounding: float
    radius: float

    def heights(self, grid: rc.Grid) -> Any:
        """Return the heights at the middles of the cells."""
        across = np.hypot(grid.x, self.rounding) - self.rounding
        return -(self.slope * across + grid.y**2 / (2.0 * self.radius))


@attrs.frozen
class Hill(rc.Surface):
    """A rough surface on a ball."""

    rough: rc.SelfAffineSurface
    ball: rc.ParaboloidSurface

    def heights(self, grid: rc.Grid) -> Any:
        """Return the heights at the middles of the cells."""
        return self.rough.heights(grid) + self.ball.heights(grid)


@attrs.frozen
class Scene:
    """A rigid surface on a flat body that flows; lengths over the side of a cell, stresses over Young's modulus."""

    kind: str
    surface: rc.Surface
    material: Plastic
    shape: tuple[int, int]
    sides: tuple[float, float]
    boundary: str
    forces: tuple[float, ...]

    @classmethod
    def draw(cls, seed: int, number: int) -> Scene:
        """Return the scene of a number."""
        random = np.random.default_rng((seed, number))
        kind = KINDS[number % len(KINDS)]
        poisson = random.uniform(0.2, 0.4)
        modulus = YOUNG / (1.0 - poisson**2)
        limit = YOUNG * 10.0 ** random.uniform(-2.7, -2.0)
        # The elastic pressure of the load: 1.6 is first yield, and the force grows with its third power.
        peak = limit * random.uniform(2.0, 4.5)
        contact = random.uniform(3.5, 5.0)
        sides = (1.0, 1.0)
        shape = (2 * round(2.0 * contact),) * 2
        boundary = str(random.choice(("free", "periodic")))
        surface: rc.Surface
        if kind == "rough":
            shape = (20, 20)
            slope = random.uniform(3.0, 8.0) * limit / modulus
            rough = rc.SelfAffineSurface(
                hurst=random.uniform(0.6, 0.9),
                rms_slope=slope,
                shortest=random.uniform(7.0, 9.0),
                longest=20.0,
                rolloff=random.uniform(10.0, 20.0),
                seed=int(random.integers(10**6)),
            )
            force = random.uniform(0.02, 0.08) * modulus * slope * 20.0**2
            # The border of a free domain must not be in contact.
            surface = rough if boundary == "periodic" else Hill(rough, rc.ParaboloidSurface(50.0 / slope))
            force *= 1.0 if boundary == "periodic" else 0.5
        elif kind == "wedge":
            slope = random.uniform(3.0, 6.0) * limit / modulus
            rounding = random.uniform(0.0, 3.0)
            if boundary == "periodic" or random.random() < 0.5:
                boundary = str(random.choice(("periodic", "free-periodic")))
                shape = (shape[0], 8)
                surface = Wedge(slope, rounding, 1e12)
                force = modulus * slope * contact * 8.0 * 0.7
            else:
                radius = modulus * contact / limit * random.uniform(0.3, 1.0)
                surface = Wedge(slope, rounding, radius)
                force = 0.5 * modulus * slope * contact**2
        else:
            radius = 2.0 * modulus * contact / np.pi / peak
            radii = (radius, radius)
            force = 2.0 / 3.0 * np.pi * contact**2 * peak
            if kind == "ellipsoid":
                ratio = random.uniform(1.3, 3.0)
                radii = (radius / ratio, radius)
                sides = (1.0, random.uniform(1.0, 1.8))
                shape = (shape[0], round(1.2 * shape[1] / sides[1]))
                force *= 0.9
            place = tuple(random.uniform(-0.5, 0.5, 2).tolist())
            surface = rc.ParaboloidSurface(radii, place)
        hardening = [
            None,
            LinearHardening(YOUNG * random.uniform(0.0, 0.05)),
            SwiftHardening(random.uniform(2e-3, 1e-2), random.uniform(0.1, 0.3)),
            VoceHardening(limit * random.uniform(1.2, 1.6), random.uniform(3e-3, 2e-2)),
        ][number // len(KINDS) % 4]
        material = Plastic(YOUNG, poisson, limit, hardening, accuracy=random.choice((0.02, 0.05)))
        unloaded = random.choice((0.0, 0.0, 0.4))
        again = random.choice((0.8, 1.0, 1.3))
        return cls(kind, surface, material, shape, sides, boundary, (force, force * unloaded, force * again))

    def follow(self, refinement: int = 1) -> rc.LoadPath:
        """Return the states, with cells so many times shorter and substeps as much sharper as those of a reference."""
        grid = rc.Grid(
            tuple(refinement * n for n in self.shape),
            tuple(n * side for n, side in zip(self.shape, self.sides, strict=True)),
        )
        sharper = SHARPER if refinement > 1 else 1.0
        material = attrs.evolve(self.material, accuracy=self.material.accuracy / sharper)
        problem = rc.ContactProblem(
            rc.Body(self.surface, rc.Rigid()),
            rc.Body(rc.FlatSurface(), material),
            grid=grid,
            boundary=self.boundary,
        )
        return problem.path(force=list(self.forces))


def list_answers(state: rc.ContactSolution) -> dict[str, rc.Estimate]:
    """Return all numbers of a state that state an uncertainty."""
    found: dict[str, rc.Estimate] = {}
    if state.force > 0.0:
        names = ("peak-pressure", "approach", "mean-gap")
        found |= {name: state.response(name) for name in names} | {"area": state.area()}
    parts: dict[str, Callable[[], Any]] = {
        "zone": FindPlasticZone,
        "imprint": FindImprint,
        "residual": FindResidualStress,
        "total": FindTotalStress,
    }
    for name, response in parts.items():
        found |= {f"{name} {one}": value for one, value in state.response(response()).estimates.items()}
    return found


def find_references(scene: Scene, known: dict[str, Any], label: str, file: Path | None) -> list[dict[str, float]]:
    """Return the answers of the finer grid by name, of each state."""
    if label not in known:
        path = scene.follow(REFINEMENT)
        known[label] = [{name: one.value for name, one in list_answers(state).items()} for state in path]
        if file:
            with file.open("a", encoding="utf-8") as stream:
                stream.write(json.dumps([label, known[label]]) + "\n")
    return known[label]


def main(scenes: int = 60, seed: int = 2, file: Path | None = None) -> None:
    """Print the table."""
    warnings.simplefilter("ignore", rc.errors.ContactWarning)
    known = dict(map(json.loads, file.read_text().splitlines())) if file and file.exists() else {}
    rows: dict[str, list[tuple[float, float, str]]] = {}
    for number in range(scenes):
        scene = Scene.draw(seed, number)
        start = time.process_time()
        path = scene.follow()
        middle = time.process_time()
        references = find_references(scene, known, f"{seed} {number}", file)
        spent = time.process_time() - middle
        flowed = [state.added[0].memory[0]["accumulated_strain"].max() for state in path]
        print(
            f"{number:3d} {scene.kind:9s} {scene.boundary:13s} {'x'.join(map(str, scene.shape))} "
            f"strain {flowed[0]:.2g} {flowed[2]:.2g} CPU {middle - start:.1f} {spent:.1f} s",
            file=sys.stderr,
            flush=True,
        )
        for which, state, expected in zip(STATES, path, references, strict=True):
            if "border" in " ".join(state.warnings):
                break
            for name, one in list_answers(state).items():
                true = expected[name] + BEYOND * (expected[name] - one.value)
                size = max(abs(true), abs(one.value))
                error = abs(one.value - true)
                if error > NOISE * size:
                    where = f"{number} {scene.kind} {which}"
                    rows.setdefault(name, []).append((error / size, one.uncertainty / size, where))
    print("number | errors | within one | within two | median error % | median u / median e | beyond two")
    for name, found in rows.items():
        errors, stated = (np.array([row[place] for row in found]) for place in (0, 1))
        ratios = np.divide(errors, stated, out=np.full(errors.size, np.inf), where=stated > 0.0)
        beyond = [f"{where} {ratio:.1f}" for (_, _, where), ratio in zip(found, ratios, strict=True) if ratio > 2.0]
        cells = (
            name,
            str(len(found)),
            f"{100 * np.mean(ratios <= 1.0):.0f} %",
            f"{100 * np.mean(ratios <= 2.0):.0f} %",
            f"{100 * np.median(errors):.2f}",
            f"{np.median(stated) / np.median(errors):.1f}",
            "; ".join(beyond),
        )
        print(" | ".join(cells), flush=True)


if __name__ == "__main__":
    words = sys.argv[1:]
    main(*map(int, words[:2]), *map(Path, words[2:3]))
