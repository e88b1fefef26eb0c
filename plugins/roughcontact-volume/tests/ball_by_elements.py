"""A rigid ball on a half-space that yields, by axisymmetric finite elements: the answers in `ball_references.json`.

python plugins/roughcontact-volume/tests/ball_by_elements.py

The ball is frictionless and a paraboloid, strains are small, and nothing here is shared with the package. Four-node
rings with mean dilatation (Hughes, The Finite Element Method, 1987, section 4.5), von Mises with isotropic hardening,
returned implicitly with its consistent tangent (Simo, Taylor, Comput. Methods Appl. Mech. Eng. 48 (1985) 101-118,
https://doi.org/10.1016/0045-7825(85)90070-2). Far away the body moves as by a point force.

Lengths over the contact radius of Hertz at a maximum pressure of 1.6 Y, stresses over Y; E = 200 Y, Poisson's ratio
0.3. z points into the body, tension is positive.
"""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.linalg import solveh_banded

Array = np.ndarray

ANSWERS = Path(__file__).parent / "ball_references.json"
YOUNG, POISSON = 200.0, 0.3
SHEAR = YOUNG / 2 / (1 + POISSON)
BULK = YOUNG / 3 / (1 - 2 * POISSON)
PLANE = YOUNG / (1 - POISSON**2)
# Maximum pressure of Hertz by which loads and lengths are measured; then the radius of the ball and the load.
FIRST = 1.6
RADIUS = 2 * PLANE / math.pi / FIRST
UNIT_FORCE = 2 * math.pi / 3 * FIRST
UNIT_APPROACH = 1 / RADIUS
# A load under which nothing yields.
ELASTIC_LOAD = 0.9
LOADS = (10.0, 100.0, 2.0, 5.0, 20.0, 50.0)
# Elements along the contact radius at the largest load, and steps up to it.
COUNT = 24
# Over the radius of Hertz at the load.
DEPTHS = (0.1, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0, 3.0)
PLACES = (0.0, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0, 3.0)


class Hardening(NamedTuple):
    """Yield stress by accumulated plastic strain, and its derivative."""

    stress: Callable[[Array], Array]
    slope: Callable[[Array], Array]


HARDENINGS = {
    "perfectly plastic": Hardening(np.ones_like, np.zeros_like),
    "linear": Hardening(lambda k: 1 + 0.02 * YOUNG * k, lambda k: np.full_like(k, 0.02 * YOUNG)),
    "Swift": Hardening(lambda k: (1 + k / 0.005) ** 0.2, lambda k: 40 * (1 + k / 0.005) ** -0.8),
}
ELASTIC = Hardening(lambda k: np.full_like(k, np.inf), np.zeros_like)


class Memory(NamedTuple):
    """Plastic strain (rr, zz, tt, twice rz) and its accumulated size, of each element at its four points."""

    strain: Array
    accumulated: Array


def return_stress(strain: Array, before: Memory, hardening: Hardening) -> tuple[Array, Array, Memory]:
    """Return stress, consistent tangent and memory at a total strain."""
    elastic = strain - before.strain
    dilatation = elastic[..., :3].sum(-1)
    deviator = 2 * SHEAR * elastic
    deviator[..., :3] -= 2 / 3 * SHEAR * dilatation[..., None]
    deviator[..., 3] /= 2
    mises = np.sqrt(1.5 * (np.sum(deviator**2, axis=-1) + deviator[..., 3] ** 2))
    flows = mises > hardening.stress(before.accumulated)
    trial, start = mises[flows], before.accumulated[flows]
    # Convex and falling: Newton's method comes from one side.
    step = np.zeros_like(trial)
    for _ in range(30):
        excess = trial - 3 * SHEAR * step - hardening.stress(start + step)
        step += excess / (3 * SHEAR + hardening.slope(start + step))
    kept, turned = np.ones_like(mises), np.zeros_like(mises)
    kept[flows] = 1 - 3 * SHEAR * step / trial
    turned[flows] = kept[flows] - 1 + 1 / (1 + hardening.slope(start + step) / (3 * SHEAR))
    normal = deviator / np.where(mises > 0, mises, 1)[..., None]
    plastic = np.zeros_like(strain)
    plastic[flows] = 1.5 * step[:, None] * normal[flows]
    plastic[..., 3] *= 2
    accumulated = before.accumulated.copy()
    accumulated[flows] += step
    unit = np.array([1.0, 1.0, 1.0, 0.0])
    stress = kept[..., None] * deviator + BULK * dilatation[..., None] * unit
    projection = np.diag([1.0, 1.0, 1.0, 0.5]) - np.outer(unit, unit) / 3
    tangent = BULK * np.outer(unit, unit) + 2 * SHEAR * kept[..., None, None] * projection
    tangent = tangent - (3 * SHEAR * turned)[..., None, None] * normal[..., :, None] * normal[..., None, :]
    return stress, tangent, Memory(before.strain + plastic, accumulated)


def space_edges(count: int, radius: float) -> Array:
    """Return edges of elements: equal ones up to twice the radius, then growing ones up to 50 times."""
    edges = list(np.linspace(0, 2 * radius, 2 * count + 1))
    growth = 1 + 3.6 / count
    while edges[-1] < 50 * radius:
        edges.append(edges[-1] + growth * (edges[-1] - edges[-2]))
    return np.array(edges)


class Body:
    """The half-space, its memory and the ball that presses it."""

    def __init__(self, count: int, radius: float, hardening: Hardening) -> None:
        self.hardening = hardening
        self.edges = space_edges(count, radius)
        size = len(self.edges)
        node = np.arange(size * size).reshape(size, size)
        corners = np.stack([node[:-1, :-1], node[1:, :-1], node[1:, 1:], node[:-1, 1:]], axis=-1).reshape(-1, 4)
        self.dofs = (2 * corners[:, :, None] + np.arange(2)).reshape(-1, 8)
        self.band = 2 * size + 4
        self.operator, self.weights = self._differentiate()
        self.surface = 2 * node[:, 0] + 1
        self.gap = self.edges**2 / 2 / RADIUS
        self.far, self.held = self._hold_far(node)
        self.displacement = np.zeros(2 * size * size)
        shape = self.weights.shape
        self.memory = Memory(np.zeros((*shape, 4)), np.zeros(shape))
        self.stress = np.zeros((*shape, 4))
        self.touching = np.zeros(size, bool)
        self.touching[0] = True
        self.forces = np.zeros(size)
        self.approach = self.force = 0.0

    def _differentiate(self) -> tuple[Array, Array]:
        """Return strains by displacements, shape (elements, 4, 4, 8), and the volume at each point."""
        r, _ = np.meshgrid(self.edges[:-1], self.edges[:-1], indexing="ij")
        height = np.diff(self.edges)
        wide, deep = np.meshgrid(height, height, indexing="ij")
        r, wide, deep = r.ravel(), wide.ravel(), deep.ravel()
        signs = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
        operator = np.zeros((len(r), 4, 4, 8))
        weights = np.zeros((len(r), 4))
        for place, (x, y) in enumerate(signs / math.sqrt(3)):
            value = (1 + signs[:, 0] * x) * (1 + signs[:, 1] * y) / 4
            along = (signs[:, 0] * (1 + signs[:, 1] * y) / 2) / wide[:, None]
            down = (signs[:, 1] * (1 + signs[:, 0] * x) / 2) / deep[:, None]
            middle = r + wide * (1 + x) / 2
            rows = operator[:, place]
            rows[:, 0, 0::2], rows[:, 1, 1::2], rows[:, 2, 0::2] = along, down, value / middle[:, None]
            rows[:, 3, 0::2], rows[:, 3, 1::2] = down, along
            weights[:, place] = 2 * math.pi * middle * wide * deep / 4
        dilatation = operator[:, :, :3].sum(axis=2)
        mean = np.einsum("ep,epi->ei", weights, dilatation) / weights.sum(axis=1)[:, None]
        operator[:, :, :3] += ((mean[:, None] - dilatation) / 3)[:, :, None]
        return operator, weights

    def _hold_far(self, node: Array) -> tuple[Array, Array]:
        """Return the displacement by a unit point force where it is held, and which numbers are held."""
        r, z = np.meshgrid(self.edges, self.edges, indexing="ij")
        distance = np.hypot(r, z)
        distance[0, 0] = 1.0
        scale = (1 + POISSON) / 2 / math.pi / YOUNG
        down = scale * (z**2 / distance**3 + 2 * (1 - POISSON) / distance)
        out = scale * (r * z / distance**3 - (1 - 2 * POISSON) * r / distance / (distance + z))
        far = np.stack([out, down], axis=-1).ravel()
        held = np.zeros(far.size, bool)
        for edge in (node[-1], node[:, -1]):
            held[2 * edge] = held[2 * edge + 1] = True
        held[2 * node[0]] = True
        far[~held] = 0.0
        return far, held

    def _gather(self, parts: Array) -> Array:
        return np.bincount(self.dofs.ravel(), parts.ravel(), self.displacement.size)

    def _assemble(self, stiffness: Array, fixed: Array) -> Array:
        """Return the lower band of the stiffness; the rows and columns of fixed numbers are those of the unit."""
        rows = np.repeat(self.dofs, 8, axis=1)
        columns = np.tile(self.dofs, 8)
        taken = (rows >= columns) & ~fixed[rows] & ~fixed[columns]
        place = (rows - columns)[taken] * fixed.size + columns[taken]
        band = np.bincount(place, stiffness.reshape(len(rows), 64)[taken], self.band * fixed.size)
        band = band.reshape(self.band, fixed.size)
        band[0, fixed] = 1.0
        return band

    def load(self, force: float) -> None:
        """Bring the body to equilibrium under a force, in units of that at first yield."""
        kept = self.force, self.displacement, self.memory, self.touching, self.approach
        self.force = force * UNIT_FORCE
        if self._settle():
            return
        self.force, self.displacement, self.memory, self.touching, self.approach = kept
        self.load((kept[0] / UNIT_FORCE + force) / 2)
        self.load(force)

    def _settle(self) -> bool:
        """Return whether the body has come to equilibrium."""
        before, seen, settled = self.memory, set(), False
        for turn in range(30):
            try:
                error = self._move(before)
            except np.linalg.LinAlgError:
                return False
            # The contact is chosen at first, then where the body is nearly in equilibrium, and at last where it is.
            if turn < 2:
                self._choose_touching(set())
            elif error < (1e-9 if settled else 1e-4) * UNIT_FORCE:
                if settled:
                    return True
                settled = self._choose_touching(seen)
        return False

    def _move(self, before: Memory) -> float:
        """Do one step of Newton's method at the nodes that touch; return the force that was not in equilibrium."""
        strain = np.einsum("epij,ej->epi", self.operator, self.displacement[self.dofs])
        self.stress, tangent, self.memory = return_stress(strain, before, self.hardening)
        weighted = self.operator * self.weights[..., None, None]
        inner = self._gather(np.einsum("epij,epi->ej", weighted, self.stress))
        contact = np.zeros(self.held.size, bool)
        contact[self.surface[self.touching]] = True
        fixed = self.held | contact
        error = np.abs(inner[~fixed]).max()
        stiffness = np.matmul(np.swapaxes(weighted, 2, 3), tangent @ self.operator).sum(axis=1)

        def push(moves: Array) -> Array:
            return self._gather(np.einsum("eij,ej->ei", stiffness, moves[self.dofs]))

        level = np.zeros_like(inner)
        level[self.surface] = self.approach - self.gap
        move = np.where(fixed, np.where(contact, level, self.far * self.force) - self.displacement, 0.0)
        rise = 1.0 * contact
        right = np.where(fixed, 0.0, [-inner - push(move), -push(rise)])
        band = self._assemble(stiffness, fixed)
        moves = solveh_banded(band, right.T, lower=True, overwrite_ab=True, check_finite=False)
        move, rise = move + moves[:, 0], rise + moves[:, 1]
        self.forces = inner + push(move)
        if self.touching.any():
            stiff = push(rise)
            climb = (self.force - self.forces[contact].sum()) / stiff[contact].sum()
            move, self.approach = move + climb * rise, self.approach + climb
            self.forces += climb * stiff
        self.forces = self.forces[self.surface]
        self.displacement = self.displacement + move
        return error

    def _choose_touching(self, seen: set[bytes]) -> bool:
        """Take the nodes that the ball pushes or would enter; return whether they are those of before."""
        height = self.displacement[self.surface] + self.gap
        if self.force == 0.0:
            self.approach = float(height.min())
        touching = np.where(self.touching, self.forces > 0.0, height < self.approach)
        touching &= self.force > 0.0
        touching[-1] = False
        # A node may fit neither way: by less than an element.
        if touching.tobytes() in seen:
            return True
        seen.add(touching.tobytes())
        same = np.array_equal(touching, self.touching)
        self.touching = touching
        return same

    def maximum_pressure(self) -> float:
        """Return the pressure in the middle: nodal forces of a polynomial in r^2 over the inner half of the contact."""
        count = max(4, int(np.count_nonzero(self.touching)) // 2)
        at, weight = np.polynomial.legendre.leggauss(4)
        edges = self.edges[: count + 1]
        half = np.diff(edges)[:, None] / 2
        r = edges[:-1, None] + half * (1 + at)
        powers = (r[..., None] / edges[-1]) ** np.array([0, 2, 4])
        area = (2 * math.pi * r * half * weight)[..., None] * powers
        system = np.zeros((count + 1, 3))
        system[:-1] += np.sum(area * ((1 - at) / 2)[:, None], axis=1)
        system[1:] += np.sum(area * ((1 + at) / 2)[:, None], axis=1)
        size = system[:count, 0]
        found = np.linalg.lstsq(system[:count] / size[:, None], self.forces[:count] / size, rcond=None)[0]
        return float(found[0])

    def contact_radius(self) -> float:
        """Return the radius between the last node that touches and the next."""
        last = int(np.flatnonzero(self.touching)[-1])
        return float(self.edges[last : last + 2].mean())

    def on_axis(self, depths: Iterable[float]) -> Array:
        """Return the radial and the vertical stress at depths below the middle, shape (2, depths)."""
        size = len(self.edges) - 1
        column = self.stress[:size].mean(axis=1)
        middles = (self.edges[:-1] + self.edges[1:]) / 2
        return CubicSpline(middles, (column[:, [0, 2]].mean(axis=1), column[:, 1]), axis=1)(np.array(list(depths)))

    def sunk(self, places: Iterable[float]) -> Array:
        """Return the displacement of the surface into the body at distances from the middle."""
        return CubicSpline(self.edges, self.displacement[self.surface])(np.array(list(places)))


def hertz_radius(load: float) -> float:
    """Return the contact radius of an elastic body."""
    return load ** (1 / 3)


def press(load: float, hardening: Hardening, count: int, steps: int) -> dict[str, Array]:
    """Return what a body answers after loading, unloading and loading again."""
    unit = hertz_radius(load)
    # Of an elastic contact, or of one under a mean pressure of 2.8 Y.
    body = Body(count, max(unit, math.sqrt(load * UNIT_FORCE / 2.8 / math.pi)), ELASTIC)
    depths, places = unit * np.array(DEPTHS), unit * np.array(PLACES)
    body.load(ELASTIC_LOAD)
    body.hardening = hardening
    for root in np.linspace(math.sqrt(ELASTIC_LOAD), math.sqrt(load), steps + 1)[1:]:
        body.load(root**2)
    loaded = body.memory.accumulated
    answer = _answer_contact(body, "")
    answer |= {"largest strain": loaded.max()}
    answer["radial stress"], answer["vertical stress"] = body.on_axis(depths)
    back = np.linspace(math.sqrt(load), math.sqrt(0.02 * load), steps // 2)
    for root in back[1:]:
        body.load(root**2)
    last = body.touching
    body.load(0.0)
    unloaded = body.memory.accumulated
    answer["unloaded approach"] = body.approach / UNIT_APPROACH
    answer["imprint"] = body.sunk(places) / UNIT_APPROACH
    answer["residual radial stress"], answer["residual vertical stress"] = body.on_axis(depths)
    body.touching = last
    for root in back[::-1]:
        body.load(root**2)
    answer |= _answer_contact(body, "reloaded ")
    answer["strain by unloading"] = (unloaded - loaded).max()
    answer["strain by reloading"] = (body.memory.accumulated - unloaded).max()
    return {name: np.asarray(value, float) for name, value in answer.items()}


def _answer_contact(body: Body, when: str) -> dict[str, object]:
    return {
        f"{when}approach": body.approach / UNIT_APPROACH,
        f"{when}maximum pressure": body.maximum_pressure(),
        f"{when}contact radius": body.contact_radius(),
    }


def find_answer(load: float, hardening: Hardening) -> dict[str, list]:
    """Return each answer and its error: those of small elements and short steps, extrapolated.

    The error falls with the square of the size of the elements, and by about two thirds with each halving of the steps.
    At 100 times the load of first yield other numbers of elements (16 and 32) change the approach by 0.3 %.
    """
    fine = press(load, hardening, COUNT, COUNT)
    coarse, short, shortest = (press(load, hardening, COUNT // 2, steps * COUNT) for steps in (1, 2, 4))
    found = {}
    # What flows back at the edge while it is unloaded depends on single nodes.
    for name in (each for each in fine if not each.startswith("strain by")):
        elements, steps = (fine[name] - coarse[name]) / 3, (shortest[name] - short[name]) / 2
        value = fine[name] + elements + shortest[name] - coarse[name] + steps
        found[name] = [np.round(each, 6).tolist() for each in (value, np.abs(elements) + np.abs(steps))]
    return found


def load_answers() -> dict[str, dict[str, list]]:
    """Return the answers in the file by hardening and load: each value and its error."""
    return json.loads(ANSWERS.read_text(encoding="utf-8")) if ANSWERS.exists() else {}


def main() -> None:
    """Compute the answers that are missing and write them to the file."""
    table = load_answers()
    for load, name in itertools.product(LOADS, HARDENINGS):
        case = f"{name} {load:g}"
        if case in table:
            continue
        table[case] = find_answer(load, HARDENINGS[name])
        print(case, {key: value for key, value in table[case].items() if np.ndim(value) == 1}, flush=True)
        cases = []
        for each, answers in table.items():
            rows = [f"  {json.dumps(key)}: {json.dumps(value)}" for key, value in answers.items()]
            cases.append(f"{json.dumps(each)}: {{\n" + ",\n".join(rows) + "\n}")
        ANSWERS.write_text("{\n" + ",\n".join(cases) + "\n}\n", encoding="utf-8")


if __name__ == "__main__":
    main()
