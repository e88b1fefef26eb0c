"""Random paths of contacts that remember, and a judge of each of their states by a dense matrix and numpy alone."""

from __future__ import annotations

import attrs
import numpy as np

import roughcontact as rc

TOLERANCE = 1e-9
BOUNDARIES = ["free", "periodic", ("free", "periodic"), ("periodic", "free")]
# Errors of a state that count as a fault: of gaps over heights and displacements, and of loads and memories.
GAP_ERROR = 1e-6
MEMORY_ERROR = 1e-7


@attrs.frozen(eq=False)
class PathCase:
    """A problem, the arguments of its path, and the numbers of its laws, of which the judge needs no part of ours."""

    problem: rc.ContactProblem
    arguments: dict
    wear: float
    hardness: float
    # For each body that deforms: moduli under plane strain, of which the first never relaxes, and times.
    bodies: tuple

    def __str__(self):
        return f"{self.problem!r}, {self.problem.laws}, {self.bodies}, hardness {self.hardness:g}, {self.arguments}"


def draw_case(number):
    """Return the case of a number: hardness, wear and relaxation mixed, moduli from 1e-3 to 1e11 Pa, cells to 1 : 6."""
    rng = np.random.default_rng(number)
    shape = tuple(int(n) for n in rng.integers(5, 12, 2))
    cell = 10.0 ** rng.uniform(-8.0, -1.0)
    aspect = 6.0 ** rng.uniform(-1.0, 1.0)
    spacing = np.array([cell * aspect**0.5, cell / aspect**0.5])
    grid = rc.Grid(shape, tuple(np.array(shape) * spacing))
    boundary = BOUNDARIES[rng.choice(4, p=[0.35, 0.35, 0.15, 0.15])]
    modulus = 10.0 ** rng.uniform(-3.0, 11.0)
    poisson = rng.uniform(0.0, 0.5)
    heights = cell * 10.0 ** rng.uniform(-2.0, -0.3) * _draw_heights(rng, shape)
    reference = modulus * np.ptp(heights) / (4.0 * cell)
    has = rng.random(3) < [0.6, 0.6, 0.5]
    if not has.any():
        has[rng.integers(3)] = True
    count = int(rng.integers(2, 6))
    kind = "approach" if rng.random() < 0.25 else str(rng.choice(["pressure", "force"]))
    loads = 10.0 ** rng.uniform(-2.5, -0.3, count) * reference
    hardness = float(loads.max() * 10.0 ** rng.uniform(0.2, 1.5)) if has[0] else np.inf
    distance = 0.0 if not has[1] else 10.0 ** rng.uniform(-3.0, 3.0)
    wear = 10.0 ** rng.uniform(-2.0, 1.3) * cell / modulus / distance if has[1] else 0.0
    # Full contact is at the mean of the gap.
    approaches = (heights.max() - heights.mean()) * rng.uniform(0.05, 0.9, count)
    values = {"pressure": loads, "force": loads * grid.area, "approach": approaches}[kind]
    if kind != "approach":
        values[1:][rng.random(count - 1) < 0.15] = 0.0
    arguments = {kind: [float(one) for one in values] if rng.random() < 0.8 else float(values[0])}
    # Equal places are jumps of the load.
    passed = np.cumsum(rng.random(count) * (rng.random(count) < 0.75))
    if has[1]:
        arguments["sliding"] = [float(one) for one in distance * passed / max(passed[-1], 1.0)]
    slowest = 10.0 ** rng.uniform(-6.0, 6.0)
    if has[2]:
        arguments["time"] = [float(one) for one in slowest * 10.0 ** rng.uniform(-1.5, 1.5) * passed]
    if not has[1:].any():
        arguments = {kind: [float(one) for one in values]}
    materials, bodies = _draw_materials(rng, modulus, poisson, hardness, slowest if has[2] else None)
    whole = boundary == "periodic"
    body = rc.Body(rc.HeightMap(heights, grid.size, periodic=whole), materials[0])
    other = {} if len(materials) < 2 else {"counterbody": rc.Body(rc.FlatSurface(), materials[1])}
    laws = rc.Archard(wear, of=str(rng.choice(["body", "counterbody"]))) if wear else ()
    solver = rc.ProjectedConjugateGradient(tolerance=TOLERANCE)
    problem = rc.ContactProblem(body, **other, grid=grid, boundary=boundary, laws=laws, solver=solver)
    arguments["accuracy"] = 10.0 ** rng.uniform(-2.0, -1.0)
    return PathCase(problem, arguments, wear, hardness, bodies)


def _draw_heights(rng, shape):
    x, y = np.meshgrid(*(np.arange(n) / n for n in shape), indexing="ij")
    noise = rng.standard_normal(shape)
    wave = np.cos(2.0 * np.pi * (x + rng.random())) * np.cos(2.0 * np.pi * (y + rng.random()))
    ball = -((x - 0.5) ** 2) - (y - 0.5) ** 2
    parts = rng.dirichlet([0.5, 0.5, 0.5])
    return parts[0] * noise + 3.0 * parts[1] * wave + 8.0 * parts[2] * ball


def _draw_materials(rng, modulus, poisson, hardness, slowest):
    """Return the materials of one body or both, and moduli under plane strain and times of those that deform."""
    unit = 1.0 - poisson**2
    hard = {} if np.isinf(hardness) else {"hardness": hardness}
    solid = rc.ElasticPerfectlyPlastic if hard else rc.Elastic
    ratio = 10.0 ** rng.uniform(-1.0, 2.0)
    if slowest is None:
        first = solid(young=modulus * unit, poisson=poisson, **hard)
        if rng.random() < 0.6:
            return [first], (([modulus], []),)
        second = rc.Elastic(young=ratio * modulus * unit, poisson=poisson)
        return [first, second], (([modulus], []), ([ratio * modulus], []))
    terms = int(rng.integers(1, 4))
    moduli = modulus * rng.dirichlet(np.ones(terms + 1))
    times = np.sort(slowest * 10.0 ** rng.uniform(-2.0, 0.0, terms))
    first = rc.Viscoelastic(moduli=(moduli * unit).tolist(), times=times.tolist(), poisson=poisson)
    sides = [(moduli.tolist(), times.tolist())]
    if not hard and rng.random() < 0.5:
        return [first], tuple(sides)
    if not hard and rng.random() < 0.5:
        second = rc.Viscoelastic([ratio * modulus * unit, modulus * unit], [slowest], poisson)
        return [first, second], (*sides, ([ratio * modulus, modulus], [slowest]))
    return [first, solid(young=ratio * modulus * unit, poisson=poisson, **hard)], (*sides, ([ratio * modulus], []))


class Judge:
    """Follows the states of a path from their pressures alone, and keeps the largest error of each kind."""

    def __init__(self, case):
        self.case = case
        problem = case.problem
        shape = problem.grid.shape
        cells = np.eye(shape[0] * shape[1]).reshape(-1, *shape)
        instant = 1.0 / sum(1.0 / sum(moduli) for moduli, _ in case.bodies)
        scale = 2.0 ** np.round(np.log2(instant))
        # For a modulus of one.
        columns = [problem.displace(scale * one).ravel() for one in cells]
        self.matrix = np.stack(columns, axis=1) * (instant / scale)
        self.gap = problem.initial_gap.ravel()
        self.worn = np.zeros(len(cells))
        self.before = np.zeros(len(cells))
        self.flattened = np.zeros(len(cells))
        self.bodies = [[np.zeros(len(cells)), [np.zeros(len(cells)) for _ in times]] for _, times in case.bodies]
        self.states = 0
        self.errors = {"gap": 0.0, "memory": 0.0, "bounds": 0.0}

    def __call__(self, state):
        """Take the next state of the path."""
        case = self.case
        effect = state.added[0] if state.added else None
        time = 0.0 if effect is None else effect.time
        sliding = 0.0 if effect is None else effect.sliding
        pressure = state.pressure.ravel()
        self.worn = self.worn + 0.5 * case.wear * sliding * (self.before + pressure)
        self.before = pressure
        unit = self.matrix @ pressure
        moved = sum(self._relax(place, unit, time) for place in range(len(case.bodies)))
        left = self.gap + self.worn + self.flattened
        gap = left + moved - state.approach
        full = pressure >= case.hardness * (1.0 - 1e-12)
        pressed = (pressure > 0.0) & ~full
        scale = max(np.ptp(self.gap), np.abs(moved).max())
        wrong = [np.abs(gap[pressed]), -gap[pressure == 0.0], gap[full]]
        self._note("gap", max(float(one.max(initial=0.0)) for one in wrong) / scale)
        if not pressure.any() and "approach" not in case.arguments:
            # Without a load the bodies just touch.
            self._note("gap", abs(float(gap.min())) / scale)
        self._note("bounds", 0.0 if pressure.min() >= 0.0 and pressure.max() <= case.hardness else 1.0)
        self.flattened = self.flattened + np.where(full, np.maximum(-gap, 0.0), 0.0)
        known = {} if effect is None else {name: values for one in effect.memory for name, values in one.items()}
        for name, mine in (("worn_height", self.worn), ("flattened_height", self.flattened)):
            if name in known:
                self._note("memory", float(np.abs(known[name].ravel() - mine).max()) / max(scale, float(mine.max())))
        for side, (mine, _) in zip(("body", "counterbody"), self.bodies, strict=False):
            name = f"displacement_of_{side}"
            if name in known:
                self._note("memory", float(np.abs(known[name].ravel() - mine).max()) / scale)
        self.states += 1

    def _note(self, name, error):
        # Errors that are not numbers are faults too.
        self.errors[name] = max(self.errors[name], error if error == error else np.inf)

    def _relax(self, place, unit, time):
        """Return the displacement of a body, for which a pressure would displace a body of modulus one by `unit`."""
        moduli, times = self.case.bodies[place]
        displacement, terms = self.bodies[place]
        left = [np.exp(-time / one) for one in times]
        part = [1.0 if time == 0.0 else -np.expm1(-time / one) * one / time for one in times]
        hold = sum((modulus * one for modulus, one in zip(moduli[1:], part, strict=True)), 0.0)
        rest = sum((one * term for one, term in zip(left, terms, strict=True)), 0.0) - hold * displacement
        moved = (unit - rest) / (moduli[0] + hold)
        self.bodies[place] = [
            moved,
            [
                one * term + modulus * mean * (moved - displacement)
                for one, term, modulus, mean in zip(left, terms, moduli[1:], part, strict=True)
            ],
        ]
        return moved

    def judge_places(self, path):
        """Compare the loads and the clock at the places of the path with those that were asked for."""
        given = {name: values for name, values in self.case.arguments.items() if name != "accuracy"}
        for name, values in given.items():
            found = np.array({"pressure": path.mean_pressure}.get(name, getattr(path, name, None)))
            asked = np.broadcast_to(values, found.shape)
            self._note("memory", float((np.abs(found - asked) / np.maximum(np.abs(asked).max(), 1e-300)).max()))

    @property
    def fault(self):
        """What is wrong, or None."""
        bounds = {"gap": GAP_ERROR, "memory": MEMORY_ERROR, "bounds": 0.5}
        wrong = [f"{name} {self.errors[name]:.1e}" for name, bound in bounds.items() if self.errors[name] > bound]
        return ", ".join(wrong) or None


def judge_path(case):
    """Return the status of a path, and its judge."""
    judge = Judge(case)
    try:
        path = case.problem.path(**case.arguments, on_increment=judge)
    except rc.RoughContactError as error:
        return type(error).__name__, judge
    judge.judge_places(path)
    return "followed", judge
