"""Random paths of loads on bodies that yield, each of their states judged by code of its own.

python plugins/roughcontact-volume/tests/judged_paths.py [number of paths] [first seed] [boundary]
"""

from __future__ import annotations

import math
import sys
import warnings
from typing import Any, NamedTuple

import attrs
import numpy as np
import roughcontact as rc

from judge import WEIGHTS, HalfSpace, State, Verdict, judge
from roughcontact_volume import (
    LinearHardening,
    Plastic,
    ResidualStress,
    SwiftHardening,
    TabulatedHardening,
    VoceHardening,
)
from roughcontact_volume.box import list_layers

# Admissible violations of the flow on a periodic boundary and of one with a free axis, whose images are removed but for
# a thousandth of the residual stress, and of the contact, whose tolerance follows that of the flow.
FLOW = {"periodic": 5e-4, "free": 1e-2, "free-periodic": 1e-2, "periodic-free": 1e-2}
CONTACT = 1e-4
KINDS = ("plain", "stressed", "both")


class DrawnMaterial(NamedTuple):
    """A material that yields, and its yield stress by formulas of its own."""

    material: Plastic
    hardening: Any
    limit: float

    @classmethod
    def draw(cls, rng: Any, young: float, poisson: float, limit: float, **others: Any) -> DrawnMaterial:
        hardening = [
            None,
            LinearHardening(young * rng.uniform(0, 0.1)),
            SwiftHardening(rng.uniform(1e-3, 1e-2), rng.uniform(0.05, 0.5)),
            VoceHardening(limit * rng.uniform(1.1, 2.0), rng.uniform(1e-3, 1e-2)),
            TabulatedHardening([0.0, 0.002, 0.01], [limit, 1.2 * limit, 1.3 * limit]),
        ][rng.integers(5)]
        accuracy = rng.choice([0.1, 0.3, 1.0])
        return cls(Plastic(young, poisson, limit, hardening, accuracy=accuracy, **others), hardening, limit)

    def find_limit(self, strain: Any) -> Any:
        """Return the yield stress after an accumulated strain."""
        hard = self.hardening
        if hard is None:
            return np.full_like(strain, self.limit)
        if isinstance(hard, LinearHardening):
            return self.limit + hard.modulus * strain
        if isinstance(hard, SwiftHardening):
            return self.limit * (1 + strain / hard.strain) ** hard.power
        if isinstance(hard, VoceHardening):
            return hard.saturation - (hard.saturation - self.limit) * np.exp(-strain / hard.strain)
        return np.interp(strain, hard.strain, hard.stress)


class Drawn:
    """A surface on a flat that yields, and the loads of a path.

    The surface is rigid, but of the kind ``"both"`` yields too; of the kind ``"stressed"`` the flat has a residual
    stress before any load. The boundary is drawn where none is given.
    """

    def __init__(self, seed: int, kind: str = "plain", boundary: str | None = None) -> None:
        rng = np.random.default_rng(seed)
        beside = np.random.default_rng([seed, 1])
        self.rng = rng
        modulus, unit = 10 ** rng.uniform(-3, 11), 10 ** rng.uniform(-7, -2)
        poisson = rng.choice([0.0, 0.3, rng.uniform(-0.2, 0.45)])
        young = modulus * (1 - poisson**2)
        self.limit = young * 10 ** rng.uniform(-3, -1.7)
        flat = DrawnMaterial.draw(rng, young, poisson, self.limit)
        self.materials = {"body": flat}
        tip = rc.Rigid()
        if kind == "both":
            other = 0.1 + 0.3 * beside.random()
            stiffness = modulus * 3 ** beside.uniform(-1, 1)
            limit = self.limit * beside.uniform(0.8, 1.3)
            self.materials["counterbody"] = DrawnMaterial.draw(beside, stiffness * (1 - other**2), other, limit)
            tip = self.materials["counterbody"].material
            modulus = 1 / (1 / modulus + 1 / stiffness)
        self.shape = tuple(rng.integers(5, 10, 2).tolist())
        ratio = 6 ** rng.uniform(-1, 1)
        self.grid = rc.Grid(self.shape, (unit * self.shape[0], unit * ratio * self.shape[1]))
        if kind == "stressed":
            depth = np.cumsum(np.append(0.0, beside.uniform(0.1, 2.0, 3))) * math.sqrt(self.grid.cell_area)
            residual = ResidualStress(depth, self.limit * beside.uniform(-0.8, 0.8, 4))
            self.materials["body"] = flat._replace(material=attrs.evolve(flat.material, residual=residual))
        drawn = str(rng.choice(["free", "periodic"]))
        self.boundary = boundary or drawn
        self.heights, force = self._draw_heights(modulus)
        factors = np.append(1.0, rng.choice([0.0, 0.3, 0.8, 1.0, 1.3, 1.6], 4))
        self.forces = (force * factors).tolist()
        self.shifts = [(0, 0)] * len(self.forces)
        if self.boundary == "periodic":
            self.shifts = [tuple(pair) for pair in rng.integers(-2, 3, (len(self.forces), 2)).tolist()]
        below = rc.Body(rc.FlatSurface(), self.materials["body"].material)
        above = rc.Body(rc.HeightMap(-self.heights, self.grid.size, periodic=self.boundary == "periodic"), tip)
        self.problem = rc.ContactProblem(below, above, grid=self.grid, boundary=self.boundary)
        self.modulus = modulus

    def _draw_heights(self, modulus: float) -> tuple[Any, float]:
        """Return the gap of a ball, of an ellipsoid, or of both with waves, and a force under which they yield."""
        rng, grid = self.rng, self.grid
        x, y = ((np.arange(n) + 0.5) * side / n for n, side in zip(self.shape, grid.size, strict=True))
        x, y = (x - x.mean())[:, None] + 0.2 * grid.spacing[0], y - y.mean() - 0.1 * grid.spacing[1]
        contact, peak = 0.3 * min(grid.size) * rng.uniform(0.7, 1.1), self.limit * rng.uniform(1.7, 4.0)
        radius = 2 * modulus * contact / math.pi / peak
        heights = (x**2 + y**2 * rng.choice([1.0, rng.uniform(0.5, 2.0)])) / 2 / radius
        force = 2 / 3 * math.pi * contact**2 * peak
        if rng.random() < 0.5:
            phases = rng.uniform(0, 2 * np.pi, 2)
            waves = np.cos(6 * np.pi * x / grid.size[0] + phases[0]) * np.cos(4 * np.pi * y / grid.size[1] + phases[1])
            heights = heights + 0.1 * contact**2 / radius * waves
        return heights, force


def size_of(strain: Any) -> Any:
    """Return the equivalent size of a plastic strain."""
    return np.sqrt(2 / 3 * np.einsum("c,c...->...", WEIGHTS, strain**2))


def judge_path(seed: int, kind: str = "plain", boundary: str | None = None) -> tuple[list[str], int, int]:
    """Return the faults of a random path, the number of its states, and of those that flow; on a drawn boundary."""
    drawn = Drawn(seed, kind, boundary)
    shifts = {"shift": drawn.shifts} if drawn.boundary == "periodic" else {}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", rc.errors.ContactWarning)
        try:
            path = drawn.problem.path(force=drawn.forces, **shifts)
        except rc.InputError as refusal:
            return ([] if "yields deeper" in str(refusal) else [f"seed {seed}: {refusal}"]), 0, 0
    faults: list[str] = []
    flowing = 0
    fresh = np.zeros((7, 1, *drawn.shape))
    known = dict.fromkeys(drawn.materials, (fresh[:6], fresh[6]))
    for number, (state, shift, force) in enumerate(zip(path, drawn.shifts, drawn.forces, strict=True)):
        memories = {side: _read(drawn, state, side) for side in drawn.materials}
        found = _judge(drawn, state.pressure, memories, shift)
        complaints = [one for verdict in found for one in verdict.find_faults(FLOW[drawn.boundary], CONTACT)]
        carried = float(state.pressure.sum()) * drawn.grid.cell_area
        if not abs(carried - force) <= 1e-6 * max(drawn.forces):
            complaints.append(f"force {carried:.6g} for {force:.6g}")
        has_grown = False
        for side, memory in memories.items():
            deeper = (0, len(memory["accumulated_strain"]) - len(known[side][1]))
            strain = np.pad(known[side][0], ((0, 0), deeper, (0, 0), (0, 0)))
            grown = memory["accumulated_strain"] - np.pad(known[side][1], (deeper, (0, 0), (0, 0)))
            # What it has suffered is at least the distance from where it was.
            most = grown + 1e-9 * memory["accumulated_strain"].max()
            if not np.all(size_of(memory["plastic_strain"] - strain) <= most):
                complaints.append("strain without its accumulated size")
            has_grown |= bool(grown.max() > 0)
            known[side] = (memory["plastic_strain"], memory["accumulated_strain"])
        flowing += has_grown
        faults += [f"seed {seed}, {kind}, state {number}, {drawn.boundary}: {one}" for one in complaints]
    return faults, len(path), flowing


def _read(drawn: Drawn, state: Any, side: str) -> dict[str, Any]:
    """Return what is remembered of a side, by the names of a single body."""
    ending = f"_of_{side}" if len(drawn.materials) > 1 else ""
    return {name.removesuffix(ending): values for name, values in state.added[0].memory[0].items() if ending in name}


def _judge(drawn: Drawn, pressure: Any, memories: dict[str, Any], shift: tuple[int, int]) -> list[Verdict]:
    """Return the verdict on each body, in its own frame: the other one's imprint belongs to the gap."""
    bodies = {
        side: HalfSpace(
            drawn.shape,
            drawn.grid.spacing,
            tuple(list_layers(drawn.grid, len(memory["accumulated_strain"])).tolist()),
            rc.Boundary(drawn.boundary).repeats,
            drawn.materials[side].material.young,
            drawn.materials[side].material.poisson,
        )
        for side, memory in memories.items()
    }
    imprints = {side: body.displace(memories[side]["plastic_strain"]) for side, body in bodies.items()}
    # From the frame of the body into that of the counterbody, where the heights are, and back.
    back, forth = (-shift[0], -shift[1]), shift
    gaps = {
        "body": np.roll(drawn.heights + imprints.get("counterbody", 0.0), forth, (0, 1)),
        "counterbody": drawn.heights + np.roll(imprints["body"], back, (0, 1)),
    }
    pressures = {"body": pressure, "counterbody": np.roll(pressure, back, (0, 1))}
    found = []
    for side, memory in memories.items():
        accumulated, last = memory["accumulated_strain"], memory["last_flow"]
        drawn_material = drawn.materials[side]
        state = State(
            pressure=pressures[side],
            heights=gaps[side],
            modulus=drawn.modulus,
            strain_before=memory["plastic_strain"] - last,
            strain=memory["plastic_strain"],
            accumulated_before=accumulated - size_of(last),
            accumulated=accumulated,
            yield_stress=drawn_material.find_limit,
            given_stress=_average(drawn_material.material.residual, bodies[side].thicknesses),
        )
        found.append(judge(bodies[side], state))
    return found


def _average(residual: Any, thicknesses: tuple[float, ...]) -> Any:
    """Return the means of a residual stress over layers, at many points of each."""
    if residual is None:
        return None
    edges = np.concatenate(([0.0], np.cumsum(thicknesses)))
    points = np.linspace(edges[:-1], edges[1:], 20_001)
    means = np.trapezoid(np.interp(points, residual.depth, residual.stress), dx=1 / 20_000, axis=0)
    return np.vstack([means, means, np.zeros((4, len(thicknesses)))])


def main() -> None:
    """Judge as many paths as are asked for."""
    words = sys.argv[1:]
    count, first = (int(word) for word in (*words[:2], *("100", "0")[len(words) :]))
    states = flowing = false = 0
    for seed in range(first, first + count):
        for kind in KINDS:
            faults, judged, flowed = judge_path(seed, kind, *words[2:])
            states, flowing, false = states + judged, flowing + flowed, false + bool(faults)
            print(*faults, sep="\n", end="\n" if faults else "", flush=True)
    print(f"{count * len(KINDS)} paths, {states} states, {flowing} of them with flow: {false} paths with faults")


if __name__ == "__main__":
    main()
