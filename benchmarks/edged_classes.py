"""Answers and flags on machined and on smooth surfaces, beside the same surfaces on finer grids.

    python benchmarks/edged_classes.py [--draw 1] [--count 8] [--answers area,peak-pressure] [--kinds edged] [--worst]

Eleven kinds have creases, steps or sharp edges (`EDGED`), eight are smooth (`SMOOTH`); they are judged apart. Each case
is a surface, a place, an angle, a grid (square, 1 : 2, cells 1 : 3, odd), a boundary and a load, drawn from the number
of the draw: constants may see the draws below 100, and a draw that judges is made when they are set. The surface is
solved on the grid and on cells a half and a quarter as long; the last is true within half of its last step. A pressure
grows if the largest of the cells rises by more than 4 % at both refinements: it has no limit.

Prints for each kind how many pressures grow, how many are found unbounded, the fraction that is flagged, and for each
answer how many errors lie within two standard deviations, and the median of these over that of the errors.
"""

from __future__ import annotations

import argparse
import math
import zlib
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

import roughcontact as rc

ELASTIC = rc.Elastic(1.0, 0.0)
UNCERTAINTIES = ("model", "auto", "two grids")
ANSWERS = ("area", "peak-pressure", "perimeter", "approach", "mean-gap")
GROWTH = 0.04
# Of a value that still changes by more than this between the finer grids no true value is known.
MAX_CHANGE = 0.2
Field = np.ndarray
Surface = Callable[[Field, Field], Field]


class Case(NamedTuple):
    """A surface of a domain of these sides, m, its cells on the coarsest grid, and a mean pressure, Pa."""

    surface: Surface
    cells: tuple[int, int]
    size: tuple[float, float]
    boundary: str
    pressure: float
    label: str

    def problem(self, refinement: int = 1) -> rc.ContactProblem:
        """Return the problem on cells so many times as short."""
        grid = rc.Grid((self.cells[0] * refinement, self.cells[1] * refinement), self.size)
        # Cells have the heights of their centres: a refined grid has other points of the same surface.
        x, y = np.broadcast_arrays(grid.x / self.size[0] + 0.5, grid.y / self.size[1] + 0.5)
        heights = self.surface(x, y)
        periodic = self.boundary == "periodic"
        body = rc.Body(rc.HeightMap(heights, size=self.size, periodic=periodic), ELASTIC)
        return rc.ContactProblem(body, boundary=self.boundary)


def generator(*words: object) -> np.random.Generator:
    return np.random.default_rng(zlib.crc32(" ".join(str(word) for word in words).encode()))


def log_uniform(random: np.random.Generator, low: float, high: float) -> float:
    return float(low * (high / low) ** random.random())


# --- surfaces of the unit domain, periodic ----------------------------------------------------------------------------


def waves(random: np.random.Generator, low: float, high: float, slope: float, stretch: float = 1.0) -> Surface:
    """Return self-affine waves of these numbers along a side (H = 0.8), of an rms slope; stretched, with a lay."""
    k = np.arange(-math.ceil(high), math.ceil(high) + 1)
    kx, ky = (each.ravel() for each in np.meshgrid(k, k, indexing="ij"))
    ring = np.hypot(kx, stretch * ky)
    chosen = (ring >= low) & (ring <= high) & ((kx > 0) | ((kx == 0) & (ky > 0)))
    kx, ky, ring = kx[chosen], ky[chosen], ring[chosen]
    height = random.normal(size=ring.size) * ring**-1.8
    phase = random.uniform(0.0, 2 * np.pi, ring.size)
    height *= slope / math.sqrt(0.5 * float(np.sum((2 * np.pi * np.hypot(kx, ky) * height) ** 2)))

    def field(x: Field, y: Field) -> Field:
        along = np.exp(2j * np.pi * np.outer(x[:, 0], kx) + 1j * phase) * height
        return np.real(along @ np.exp(2j * np.pi * np.outer(ky, y[0])))

    return field


def distance(x: Field, y: Field, at: tuple[float, float]) -> tuple[Field, Field]:
    """Return the distances along both axes from the nearest image of a point."""
    dx, dy = x - at[0], y - at[1]
    return dx - np.round(dx), dy - np.round(dy)


def places(random: np.random.Generator, count: int) -> list[tuple[float, float]]:
    return [tuple(random.random(2)) for _ in range(count)]


def lattice(random: np.random.Generator, side: int) -> list[tuple[float, float]]:
    """Return points of a lattice, each moved at random by a tenth of its distance."""
    first = random.random(2)
    moved = random.uniform(-0.1, 0.1, (side, side, 2))
    return [tuple((first + (np.array((i, j)) + moved[i, j]) / side) % 1.0) for i in range(side) for j in range(side)]


def background(random: np.random.Generator, slope: float = 0.004) -> Surface:
    """Return the shallow waves of a surface before it was machined."""
    return waves(random, 1.0, 6.0, slope)


def turned(random: np.random.Generator) -> Surface:
    """Cusps between the grooves of a tool, along any direction of the lattice."""
    feed = [(int(random.integers(3, 9)), 0), (0, int(random.integers(3, 9))), tuple(random.integers(2, 6, 2))]
    kx, ky = feed[int(random.integers(3))]
    phase, depth, land = random.random(), 0.25 * random.uniform(0.03, 0.12) / math.hypot(kx, ky), background(random)

    def field(x: Field, y: Field) -> Field:
        part = (kx * x + ky * y + phase) % 1.0
        return depth * (2.0 * part - 1.0) ** 2 + land(x, y)

    return field


def peened(random: np.random.Generator) -> Surface:
    """Dents of balls that meet in ridges, 3 to 9 along a side."""
    side = int(random.integers(3, 10))
    dents = lattice(random, side)
    bend = random.uniform(0.1, 0.3) * side
    deep = random.uniform(0.0, 0.02 / side, len(dents))
    land = background(random)

    def field(x: Field, y: Field) -> Field:
        found = np.full(x.shape, np.inf)
        for at, depth in zip(dents, deep, strict=True):
            dx, dy = distance(x, y, at)
            np.minimum(found, 0.5 * bend * (dx * dx + dy * dy) - depth, out=found)
        return found + land(x, y)

    return field


def rounded_flats(random: np.random.Generator) -> Surface:
    """Flat lands whose borders fall off as parabolas: the curvature jumps."""
    lands = lattice(random, int(random.integers(1, 4)))
    radius = random.uniform(0.15, 0.3) / math.sqrt(len(lands))
    bend, low = random.uniform(0.2, 1.0), random.uniform(0.0, 1e-4, len(lands))

    def field(x: Field, y: Field) -> Field:
        found = np.full(x.shape, -np.inf)
        for at, down in zip(lands, low, strict=True):
            outside = np.maximum(np.hypot(*distance(x, y, at)) - radius, 0.0)
            np.maximum(found, -0.5 * bend * outside**2 - down, out=found)
        return found

    return field


def additive(random: np.random.Generator) -> Surface:
    """Tracks of round beads with spatter on them."""
    tracks, along = int(random.integers(4, 9)), int(random.integers(2))
    bend, phase = random.uniform(0.1, 0.3) * tracks, random.random()
    spatter = [(at, random.uniform(0.01, 0.03)) for at in places(random, int(random.integers(4, 12)))]
    land = background(random)

    def field(x: Field, y: Field) -> Field:
        part = ((y if along else x) * tracks + phase) % 1.0 - 0.5
        found = -0.5 * bend * (part / tracks) ** 2 + land(x, y)
        for at, radius in spatter:
            dx, dy = distance(x, y, at)
            np.maximum(found, 0.1 * radius - 2.0 * (dx * dx + dy * dy) / radius * 0.1, out=found)
        return found

    return field


def wear_scar(random: np.random.Generator) -> Surface:
    """Return a rough surface whose summits are cut off by a plane."""
    rough = waves(random, 2.0, random.uniform(8.0, 14.0), 0.1)
    sample = np.linspace(0.0, 1.0, 64, endpoint=False)
    cut = float(np.quantile(rough(*np.meshgrid(sample, sample, indexing="ij")), random.uniform(0.7, 0.95)))
    land = background(random, 0.002)
    return lambda x, y: np.minimum(rough(x, y), cut) + land(x, y)


def honed(random: np.random.Generator) -> Surface:
    """Return a fine plateau with deep grooves that cross."""
    plateau = waves(random, 3.0, random.uniform(8.0, 14.0), 0.05)
    kx, ky = (int(k) for k in random.integers(2, 5, 2))
    phases, depth = random.random(2), random.uniform(0.004, 0.012)

    def field(x: Field, y: Field) -> Field:
        grooves = np.full(x.shape, np.inf)
        for sign, phase in zip((1, -1), phases, strict=True):
            part = np.abs((kx * x + sign * ky * y + phase) % 1.0 - 0.5)
            np.minimum(grooves, depth * (8.0 * part - 1.0), out=grooves)
        return np.minimum(plateau(x, y), grooves)

    return field


def dimples(random: np.random.Generator) -> Surface:
    """Return a land with spherical dimples, smooth or rough."""
    at = lattice(random, int(random.integers(2, 5)))
    radius, depth = random.uniform(0.2, 0.38) / math.sqrt(len(at)), random.uniform(0.003, 0.02)
    land = waves(random, 1.0, 3.0, 0.002) if random.random() < 0.5 else waves(random, 2.0, 10.0, 0.03)

    def field(x: Field, y: Field) -> Field:
        found = land(x, y)
        for one in at:
            dx, dy = distance(x, y, one)
            found = found - depth * np.maximum(1.0 - (dx * dx + dy * dy) / radius**2, 0.0)
        return found

    return field


def steps(random: np.random.Generator) -> Surface:
    """Terraces with rough tops."""
    edges, height = waves(random, 1.0, 3.0, 1.0), random.uniform(0.002, 0.01)
    land = waves(random, 2.0, random.uniform(6.0, 12.0), random.uniform(0.005, 0.04))
    return lambda x, y: height * np.floor(4.0 * edges(x, y)) + land(x, y)


def punches(random: np.random.Generator) -> Surface:
    """Return a flat punch, round, square or turned, or two."""
    at = places(random, int(random.integers(1, 3)))
    angle, square = random.uniform(0.0, np.pi / 2) * random.integers(2), random.random() < 0.6
    radius, lower = random.uniform(0.1, 0.2), random.uniform(0.0, 5e-4)

    def field(x: Field, y: Field) -> Field:
        found = np.full(x.shape, -0.1)
        for number, one in enumerate(at):
            dx, dy = distance(x, y, one)
            u, v = math.cos(angle) * dx + math.sin(angle) * dy, math.cos(angle) * dy - math.sin(angle) * dx
            inside = (np.maximum(np.abs(u), np.abs(v)) if square else np.hypot(u, v)) < radius
            found[inside] = -number * lower
        return found

    return field


def pillars(random: np.random.Generator) -> Surface:
    """Round pillars, their tops flat, of somewhat different height."""
    at = lattice(random, int(random.integers(2, 5)))
    radius = random.uniform(0.2, 0.4) / math.sqrt(len(at))
    tops = random.uniform(-1e-3, 0.0, len(at))

    def field(x: Field, y: Field) -> Field:
        found = np.full(x.shape, -0.1)
        for one, top in zip(at, tops, strict=True):
            found[np.hypot(*distance(x, y, one)) < radius] = top
        return found

    return field


def merging_tips(random: np.random.Generator) -> Surface:
    """Tips of balls, the highest at each place: creases in the valleys alone."""
    at = places(random, int(random.integers(10, 40)))
    bend, tops = random.uniform(0.5, 2.0), random.uniform(-0.01, 0.0, len(at))

    def field(x: Field, y: Field) -> Field:
        found = np.full(x.shape, -np.inf)
        for one, top in zip(at, tops, strict=True):
            dx, dy = distance(x, y, one)
            np.maximum(found, top - 0.5 * bend * (dx * dx + dy * dy), out=found)
        return found

    return field


def rough(random: np.random.Generator) -> Surface:
    return waves(random, random.uniform(1.0, 4.0), random.uniform(10.0, 18.0), 0.1)


def lay(random: np.random.Generator) -> Surface:
    """Waves four to eight times as long along one axis."""
    return waves(random, 2.0, random.uniform(10.0, 18.0), 0.1, stretch=random.uniform(4.0, 8.0))


def ground(random: np.random.Generator) -> Surface:
    """Long scratches under waves without a lay."""
    scratches = waves(random, 3.0, 16.0, 0.08, stretch=random.uniform(6.0, 12.0))
    waviness = waves(random, 1.0, 4.0, 0.02)
    return lambda x, y: scratches(x, y) + waviness(x, y)


def skewed(random: np.random.Generator) -> Surface:
    """Worn or pointed heights: a smooth function of rough ones."""
    base, bend = waves(random, 2.0, random.uniform(6.0, 10.0), 0.1), random.choice([-1.0, 1.0]) * random.uniform(20, 50)
    return lambda x, y: np.expm1(bend * np.clip(base(x, y), -0.1, 0.1)) / bend


def craters(random: np.random.Generator) -> Surface:
    """Overlapping smooth craters, as of electrical discharge."""
    at = [(one, random.uniform(0.05, 0.12), random.uniform(0.002, 0.006)) for one in places(random, 30)]

    def field(x: Field, y: Field) -> Field:
        found = np.zeros(x.shape)
        for one, radius, depth in at:
            dx, dy = distance(x, y, one)
            r2 = (dx * dx + dy * dy) / radius**2
            found = found - depth * (1.0 - r2) * np.exp(-r2)
        return found

    return field


def balls(random: np.random.Generator) -> Surface:
    """One to four smooth summits of different height and curvature."""
    at = places(random, int(random.integers(1, 5)))
    bends, tops = random.uniform(0.1, 0.4, len(at)), random.uniform(-0.002, 0.0, len(at))
    low = -float(np.log(len(at) + 1)) * 0.02

    def field(x: Field, y: Field) -> Field:
        total = np.zeros(x.shape)
        for one, bend, top in zip(at, bends, tops, strict=True):
            dx, dy = distance(x, y, one)
            total += (0.02 + top) * np.exp(-0.5 * bend * (np.sin(np.pi * dx) ** 2 + np.sin(np.pi * dy) ** 2) / 0.0035)
        return total + low

    return field


def double_wave(random: np.random.Generator) -> Surface:
    number, phase = random.integers(2, 7, 2), random.uniform(0.0, 2 * np.pi, 2)
    height = 0.1 / (2 * np.pi * float(number.max()))
    return lambda x, y: (
        height * np.cos(2 * np.pi * number[0] * x + phase[0]) * np.cos(2 * np.pi * number[1] * y + phase[1])
    )


def smooth_steps(random: np.random.Generator) -> Surface:
    """Plateaus joined by smooth flanks of some cells."""
    base, height = waves(random, 2.0, 7.0, 0.1), random.uniform(0.004, 0.01)
    return lambda x, y: height * np.tanh(base(x, y) / 0.01) + 0.3 * base(x, y)


EDGED = {
    one.__name__.replace("_", "-"): one
    for one in (
        turned, peened, rounded_flats, additive, wear_scar, honed, dimples, steps, punches, pillars, merging_tips
    )
}  # fmt: skip
SMOOTH = {
    one.__name__.replace("_", "-"): one
    for one in (rough, lay, ground, skewed, craters, balls, double_wave, smooth_steps)
}
GRIDS = (((64, 64), 1.0, 1.0), ((48, 96), 1.0, 2.0), ((63, 75), 1.0, 1.2), ((84, 84), 1.0, 1.0), ((144, 48), 1.0, 1.0))


def draw_cases(kind: str, draw: int, count: int) -> Iterator[Case]:
    """Yield contacts of a kind; the number of the draw decides all that is random."""
    for number in range(count):
        random = generator(kind, draw, number)
        surface = {**EDGED, **SMOOTH}[kind](random)
        cells, wide, long = GRIDS[int(random.integers(len(GRIDS)))]
        if random.random() < 0.5:
            cells, wide, long = cells[::-1], long, wide
        boundary = "periodic" if random.random() < 0.7 else "free"
        pressure = log_uniform(random, 3e-4, 1e-2)
        yield Case(surface, cells, (wide, long), boundary, pressure, f"{kind} {draw}/{number}")


# --- judgement --------------------------------------------------------------------------------------------------------


class Judged(NamedTuple):
    """A contact: whether its pressure grows, was found unbounded and was flagged.

    Of each answer that has a true value, by its name and the way its uncertainty is found: the relative error, the
    relative uncertainty, and whether the error is within two of these.
    """

    case: Case
    grows: bool
    unbounded: bool
    flagged: bool
    errors: dict[tuple[str, str], tuple[float, float, bool]]


def ask(solution: rc.ContactSolution, answer: str, uncertainty: str) -> rc.Estimate:
    if answer == "area":
        return solution.area(uncertainty=uncertainty)
    return solution.response(answer, uncertainty=uncertainty)


def judge(case: Case, answers: Sequence[str]) -> Judged:
    """Solve a contact on three grids and return what its answers on the first err by."""
    first, half, quarter = (case.problem(refinement).solve(pressure=case.pressure) for refinement in (1, 2, 4))
    tops = [float(solution.pressure.max()) for solution in (first, half, quarter)]
    grows = tops[1] > (1.0 + GROWTH) * tops[0] and tops[2] > (1.0 + GROWTH) * tops[1]
    errors = {}
    for answer in answers:
        finer, finest = (ask(solution, answer, "model") for solution in (half, quarter))
        if finest.value <= 0.0 or abs(finest.value - finer.value) > MAX_CHANGE * finest.value:
            continue
        unsure = 0.5 * max(abs(finest.value - finer.value), finest.uncertainty) / finest.value
        for uncertainty in UNCERTAINTIES:
            found = ask(first, answer, uncertainty)
            error, stated = abs(found.value / finest.value - 1.0), found.uncertainty / finest.value
            errors[answer, uncertainty] = error, stated, error - 2.0 * unsure <= 2.0 * stated
    flags = first.response("flags")
    return Judged(case, grows, flags.unbounded, bool(flags), errors)


def judge_kinds(kinds: Sequence[str], draw: int, count: int, answers: Sequence[str]) -> dict[str, list[Judged]]:
    return {kind: [judge(case, answers) for case in draw_cases(kind, draw, count)] for kind in kinds}


def count_unbounded(rows: Sequence[Judged]) -> tuple[int, int, int, int]:
    """Return how many pressures grow and are found, and how many others there are and are found by mistake."""
    grow, still = ([row.unbounded for row in rows if row.grows is grows] for grows in (True, False))
    return len(grow), sum(grow), len(still), sum(still)


def cover(rows: Sequence[Judged], answer: str, uncertainty: str) -> tuple[int, float, float]:
    """Return the number of errors, the fraction within two, and the median uncertainty over the median error."""
    found = [row.errors[answer, uncertainty] for row in rows if (answer, uncertainty) in row.errors]
    if not found:
        return 0, math.nan, math.nan
    errors, stated, within = (np.array(column, dtype=float) for column in zip(*found, strict=True))
    return len(found), float(np.mean(within)), float(np.median(stated)) / max(float(np.median(errors)), 1e-12)


def print_rows(title: str, rows: Sequence[Judged], answers: Sequence[str], worst: bool) -> None:
    grow, found, still, false = count_unbounded(rows)
    print(
        f"{title:14}{len(rows):4} contacts, {np.mean([row.flagged for row in rows]):4.0%} flagged; "
        f"unbounded: {found} of {grow} that grow, {false} of {still} others"
    )
    for answer in answers:
        cells = [cover(rows, answer, uncertainty) for uncertainty in UNCERTAINTIES]
        parts = (
            f"{name} {within:4.0%} {ratio:4.1f}" for name, (_, within, ratio) in zip(UNCERTAINTIES, cells, strict=True)
        )
        print(f"    {answer:14}{cells[0][0]:4}   {'   '.join(parts)}", flush=True)
    for row in rows if worst else ():
        off = [f"{key} {e:.2%} +- {u:.2%}" for key, (e, u, within) in row.errors.items() if not within]
        if off or row.grows is not row.unbounded:
            print(f"    {row.case.label} {row.case.cells} {row.case.boundary}: grows {row.grows}, {'; '.join(off)}")


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kinds", default="all", help=f"edged, smooth, all, or of {', '.join((*EDGED, *SMOOTH))}")
    parser.add_argument("--answers", default=",".join(ANSWERS))
    parser.add_argument("--draw", type=int, default=1)
    parser.add_argument("--count", type=int, default=8, help="contacts of each kind")
    parser.add_argument("--worst", action="store_true", help="list what was missed")
    options = parser.parse_args(arguments)
    answers = tuple(name for name in options.answers.split(",") if name)
    groups = {"edged": list(EDGED), "smooth": list(SMOOTH), "all": [*EDGED, *SMOOTH]}
    wanted = groups.get(options.kinds) or options.kinds.split(",")
    for title, kinds in (("edged", EDGED), ("smooth", SMOOTH)):
        found: list[Judged] = []
        for kind in (name for name in kinds if name in wanted):
            rows = judge_kinds([kind], options.draw, options.count, answers)[kind]
            print_rows(kind, rows, answers, options.worst)
            found += rows
        if found:
            print_rows(title.upper(), found, answers, worst=False)


if __name__ == "__main__":
    main()
