"""Machined and smooth surfaces, and contacts of unkind geometry; judged by `benchmarks/stated_uncertainties.py`.

Eleven kinds have creases, steps or sharp edges (`EDGED`), eight are smooth (`SMOOTH`). A contact is a surface, a place,
an angle, a grid (square, 1 : 2, 8 : 1, cells 1 : 3, odd), a boundary and a load, drawn from the number of the draw:
constants may see the draws below 100, and a draw that judges is made when they are set. `FEATURES` adds layers, a
hardness, attraction, lost points and others to them.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Callable, Iterator

import attrs
import numpy as np

import roughcontact as rc

POISSON = 0.3
# Two like bodies of which E* is 1 Pa.
ELASTIC = rc.Elastic(2.0 * (1.0 - POISSON**2), POISSON)
Field = np.ndarray
Surface = Callable[[Field, Field], Field]


@attrs.frozen
class Case:
    """A contact of a surface on a grid and, to compare, on finer ones.

    Attributes
    ----------
    surface
        Heights over the unit domain, periodic.
    cells, size
        Cells of the coarsest grid, and sides of its domain, m.
    part
        Fraction of the unit domain, along both axes, that the grid shows.
    boundary
        Of the contact.
    pressure
        Mean pressure, Pa.
    label
        Kind, draw and number.
    feature
        A name of `FEATURES`, or empty.
    amount
        How much there is of the feature, from 0 to 1.
    """

    surface: Surface
    cells: tuple[int, int]
    size: tuple[float, float]
    part: tuple[float, float]
    boundary: str | tuple[str, str]
    pressure: float
    label: str
    feature: str = ""
    amount: float = 0.0

    def problem(self, refinement: int = 1) -> rc.ContactProblem:
        """Return the problem on cells so many times as short."""
        cells = tuple(n if n == 1 else n * refinement for n in self.cells)
        grid = rc.Grid(cells, self.size)
        # Cells have the heights of their centres: a refined grid has other points of the same surface.
        parts = zip((grid.x, grid.y), self.size, self.part, strict=True)
        x, y = np.broadcast_arrays(*((along / side + 0.5) * part for along, side, part in parts))
        lost = self._lose(refinement) if self.feature == "lost" else None
        height_map = rc.HeightMap(
            self.surface(x, y), size=self.size, periodic=self.boundary == "periodic", non_measured=lost
        )
        body, counterbody = rc.Body(height_map, self._material), rc.Body(rc.FlatSurface(), ELASTIC)
        return rc.ContactProblem(body, counterbody, boundary=self.boundary, threads=1, **self._more)

    def solve(self, refinement: int = 1) -> rc.ContactSolution:
        """Return the solution on cells so many times as short, whose answers have the uncertainty of a model."""
        solution = self.problem(refinement).solve(pressure=self.pressure)
        return attrs.evolve(solution, uncertainty="model")

    def count_wave_cells(self) -> float:
        """Return the cells of the grid in the shortest wave, which 1 % of the mean square curvature is beyond."""
        n = 256
        x, y = np.meshgrid(np.arange(n) / n, np.arange(n) / n, indexing="ij")
        power = np.abs(np.fft.fft2(self.surface(x, y))) ** 2
        found = []
        for axis in (0, 1):
            numbers = np.abs(np.fft.fftfreq(n, 1.0 / n))
            curvature = power.sum(axis=1 - axis) * numbers**4
            by_number = np.bincount(numbers.astype(int), curvature)
            shortest = int(np.searchsorted(np.cumsum(by_number), 0.99 * by_number.sum()))
            found.append(self.cells[axis] / self.part[axis] / max(shortest, 1))
        return min(found)

    @property
    def _material(self) -> rc.Elastic | rc.ElasticPerfectlyPlastic:
        if self.feature != "hardness":
            return ELASTIC
        return rc.ElasticPerfectlyPlastic(ELASTIC.young, POISSON, hardness=0.02 * 4.0**self.amount)

    @property
    def _more(self) -> dict[str, object]:
        """Return what a feature adds to the problem."""
        if self.feature == "layer":
            from roughcontact_layered import Layer, LayeredKernel

            layer = Layer(ELASTIC.young * 0.2 * 25.0**self.amount, POISSON, thickness=0.05 + 0.2 * self.amount)
            return {"kernel": LayeredKernel(layer, substrate=ELASTIC)}
        if self.feature == "attraction":
            work = 1e-6 * 4.0**self.amount
            # The cohesive length, E* range^2 / work, has four cells of the coarsest grid.
            length = 4.0 * max(side / n for side, n in zip(self.size, self.cells, strict=True))
            return {"adhesion": rc.Exponential(work, math.sqrt(work * length))}
        return {}

    def _lose(self, refinement: int) -> Field:
        """Return the points that are not measured: groups of 2 x 2 points of the coarsest grid, the same on all."""
        random = generator(self.label, "lost")
        groups = random.random([n // 2 + 1 for n in self.cells]) < 0.01 + 0.04 * self.amount
        first = np.kron(groups, np.ones((2, 2), dtype=bool))[: self.cells[0], : self.cells[1]]
        return np.kron(first, np.ones((refinement, refinement), dtype=bool))


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
# Cells, sides of the domain, and the part of the surface that it shows.
GRIDS = (
    ((64, 64), (1.0, 1.0), (1.0, 1.0)),
    ((48, 96), (1.0, 2.0), (1.0, 1.0)),
    ((63, 75), (1.0, 1.2), (1.0, 1.0)),
    ((84, 84), (1.0, 1.0), (1.0, 1.0)),
    ((144, 48), (1.0, 1.0), (1.0, 1.0)),
    ((384, 48), (1.0, 0.125), (1.0, 1.0)),
    ((136, 17), (1.0, 0.125), (1.0, 0.125)),
)
# Contacts with layers, a hardness, attraction, lines, cells 1 : 3, 95 to 99.9 % contact, and points that are not
# measured; of attraction and lines there are no two grids.
FEATURES = ("layer", "hardness", "attraction", "lines", "long cells", "nearly full", "lost")
_LONG_CELLS = 4
_STRIP = 6
# Of which a strip may show a flat part alone.
_SPARSE = ("punches", "pillars", "rounded-flats")
# Kinds that a feature does not have: lines may miss all lands, whose contact has no area between theirs and all.
_OMITTED = {"lines": _SPARSE, "nearly full": ("steps", *_SPARSE)}


def draw_case(kind: str, draw: int, number: int, feature: str = "") -> Case:
    """Return a contact of a kind; the number of the draw decides all that is random."""
    random = generator(kind, draw, number, *([feature] if feature else []))
    surface = {**EDGED, **SMOOTH}[kind](random)
    place = int(random.integers(len(GRIDS)))
    if feature == "long cells" or (place == _STRIP and kind in _SPARSE):
        place = _LONG_CELLS
    turn = -1 if random.random() < 0.5 else 1
    cells, size, part = (pair[::turn] for pair in GRIDS[place])
    free = ["free" if one < 1.0 else "periodic" for one in part]
    boundary = "free" if random.random() > 0.7 else "periodic" if free == ["periodic"] * 2 else tuple(free)
    pressure, amount = log_uniform(random, 3e-4, 1e-2), float(random.random())
    if feature == "lines":
        cells, size, part, boundary = (128, 1), (1.0, 1.0 / 128), (1.0, 1e-9), "periodic"
    case = Case(surface, cells, size, part, boundary, pressure, f"{kind} {draw}/{number} {feature}", feature, amount)
    if feature != "nearly full":
        return case
    found = case.problem().solve_for(area=f"{95.0 + 4.9 * amount}%")
    return attrs.evolve(case, pressure=found.pressure.value)


def draw_cases(kind: str, draw: int, count: int, feature: str = "") -> Iterator[Case]:
    """Yield contacts of a kind, none of a kind that the feature does not have."""
    for number in range(0 if kind in _OMITTED.get(feature, ()) else count):
        yield draw_case(kind, draw, number, feature)
