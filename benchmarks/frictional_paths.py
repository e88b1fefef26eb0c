"""Random paths with friction on small grids, each state judged on its returned fields by dense matrices.

The judge shares nothing with the package: its matrices are sums over cells and waves, and its conditions are written
down here. Run ``python benchmarks/frictional_paths.py [paths] [first seed] [1: bodies that yield]``; it prints the
worst violations, and the paths that failed.
"""

from __future__ import annotations

import sys
import time
from collections import Counter

import numpy as np

import roughcontact as rc

# Violations that a converged state may have: of the conditions, and of balances that hold to rounding.
CONDITIONS = 1e-4
ROUNDING = 1e-9


def cell_integrals(shape, spacing):
    """Return the integrals over a cell of 1/r, xx/r3, yy/r3, xy/r3, x/r2 and y/r2 at all offsets, shape (6, ...)."""
    x, y = ((np.arange(-n + 1, n + 1) - 0.5) * step for n, step in zip(shape, spacing, strict=True))
    x, y = x[:, None], y[None]
    r = np.hypot(x, y)
    xx = y * 0 + x * 0
    across, along = x * np.arcsinh(y / np.abs(x)), y * np.arcsinh(x / np.abs(y))
    tables = (
        across + along + xx,
        along,
        across,
        -r,
        y * np.log(r) + x * np.arctan(y / x),
        x * np.log(r) + y * np.arctan(x / y),
    )
    return np.stack([np.diff(np.diff(table, axis=0), axis=1) for table in tables])


def free_matrix(shape, spacing, modulus, beta, gamma):
    """Return the displacements (x, y, z) of all cells by tractions (x, y, pressure) on all cells, m/Pa."""
    nx, ny = shape
    i, j = (axis.ravel() for axis in np.meshgrid(np.arange(nx), np.arange(ny), indexing="ij"))
    di, dj = i[:, None] - i[None] + nx - 1, j[:, None] - j[None] + ny - 1
    one, xx, yy, xy, x, y = cell_integrals(shape, spacing)[:, di, dj] / (np.pi * modulus)
    return np.block(
        [
            [one + gamma * xx, gamma * xy, -beta * x],
            [gamma * xy, one + gamma * yy, -beta * y],
            [beta * x, beta * y, one],
        ]
    )


def periodic_matrix(shape, spacing, modulus, beta, gamma):
    """Return the same for a periodic half-space of which the waves of the grid alone act."""
    nx, ny = shape
    qx, qy = (2 * np.pi * np.fft.fftfreq(n, step) for n, step in zip(shape, spacing, strict=True))
    q = np.hypot(qx[:, None], qy[None])
    q[0, 0] = np.inf
    c, s = qx[:, None] / q, qy[None] / q
    c[0, 0] = s[0, 0] = 0.0
    # A wave of half the sampling wave number has no sine at the cells.
    odd_x = np.where((np.arange(nx) * 2 == nx)[:, None], 0.0, 1.0)
    odd_y = np.where((np.arange(ny) * 2 == ny)[None], 0.0, 1.0)
    scale = 2.0 / (modulus * q)
    symbols = {
        "xx": scale * (1 + gamma * (1 - c**2)),
        "yy": scale * (1 + gamma * (1 - s**2)),
        "xy": -scale * gamma * c * s * odd_x * odd_y,
        "zx": -1j * scale * beta * c * odd_x,
        "zy": -1j * scale * beta * s * odd_y,
        "zz": scale,
    }
    i, j = (axis.ravel() for axis in np.meshgrid(np.arange(nx), np.arange(ny), indexing="ij"))
    wave_x, wave_y = (np.exp(2j * np.pi * np.outer(k, np.arange(n)) / n) for k, n in ((i, nx), (j, ny)))
    waves = (wave_x[:, :, None] * wave_y[:, None, :]).reshape(nx * ny, -1)
    parts = {name: ((waves * symbol.ravel()) @ waves.conj().T).real / (nx * ny) for name, symbol in symbols.items()}
    return np.block(
        [
            [parts["xx"], parts["xy"], parts["zx"].T],
            [parts["xy"], parts["yy"], parts["zy"].T],
            [parts["zx"], parts["zy"], parts["zz"]],
        ]
    )


def constants(one, other):
    """Return E*, beta and gamma of two materials of given Young's modulus and Poisson's ratio; None is rigid."""
    c = [0.0 if body is None else (1 - body[1] ** 2) / body[0] for body in (one, other)]
    nu = [0.0 if body is None else body[1] for body in (one, other)]
    modulus = 1 / sum(c)
    beta = modulus / 2 * ((1 - 2 * nu[0]) / (1 - nu[0]) * c[0] - (1 - 2 * nu[1]) / (1 - nu[1]) * c[1])
    return modulus, beta, modulus * sum(v / (1 - v) * part for v, part in zip(nu, c, strict=True))


class Judge:
    """The conditions of contact with friction, by dense matrices; what has flowed stays away from the gap."""

    def __init__(self, matrix, heights, area, strength, hardness=np.inf):
        self.matrix, self.area, self.strength, self.hardness = matrix, area, strength, hardness
        self.gap = (heights.max() - heights).ravel()
        self.cells = self.gap.size

    def moved(self, pressure, shear):
        """Return displacements along the surface, shape (2, cells), and across it."""
        found = self.matrix @ np.concatenate([shear[0].ravel(), shear[1].ravel(), pressure.ravel()])
        return found[: 2 * self.cells].reshape(2, -1), found[2 * self.cells :]

    def judge(self, state, load, target):
        """Return the violations by name."""
        p, q = state.pressure.ravel(), state.shear.reshape(2, -1)
        along, across = self.moved(state.pressure, state.shear)
        before = state.sheared.before
        p0, q0 = before.pressure.ravel(), before.shear.reshape(2, -1)
        along0, across0 = self.moved(before.pressure, before.shear)
        d, d0 = np.array(state.tangential_displacement), np.array(before.displacement)
        w = (d[:, None] - along) - (d0[:, None] - along0)
        gap = self.gap + across - state.approach
        overlap = np.where(p >= self.hardness, np.maximum(-gap, 0.0), 0.0)
        gap += overlap
        self.gap = self.gap + overlap
        scale = min(self.gap.std(), np.ptp(across)) or 1.0
        s = self.strength(p)
        # Bodies that have come apart carry nothing.
        total, peak, strongest = p.sum() or 1.0, p.max() or 1.0, s.max() or 1.0
        own = max(self.matrix[0, 0], self.matrix[self.cells, self.cells])
        trial = q + w / own
        size = np.hypot(*trial)
        nearest = trial * np.where(size > s, s / np.where(size > 0, size, 1), 1)
        kind, value = load
        carried = {"force": p.sum() * self.area, "pressure": p.mean(), "approach": state.approach}[kind]
        name, wanted = target
        if name == "tangential_force":
            error = np.hypot(*(q.sum(axis=1) * self.area - wanted)) / ((s.sum() or 1.0) * self.area)
        else:
            error = np.abs(d - wanted).max() / max(np.abs(d).max(), state.approach)
        energy, energy0 = (
            0.5 * (x @ v + (y * u).sum()) for x, v, y, u in ((p, across, q, along), (p0, across0, q0, along0))
        )
        pressing = 0.5 * (p + p0) @ (across - across0)
        mean = 0.5 * (q + q0)
        driving, losing = mean.sum(axis=1) @ (d - d0), (mean * w).sum()
        terms = (energy, energy0, pressing, driving, losing)
        return {
            "penetration": max(-gap.min(), 0) / scale,
            "complementarity": (p * np.abs(gap)).sum() / total / scale,
            "tension": max(-p.min(), 0) / peak,
            "hardness": max(p.max() / self.hardness - 1, 0),
            "cone": max((np.hypot(*q) - s).max(), 0) / strongest,
            "slip": np.hypot(*(q - nearest)).max() / strongest,
            "load": abs(carried / value - 1),
            "tangential load": error,
            "energy": abs(energy - energy0 - pressing - driving + losing) / (max(map(abs, terms)) or 1.0),
            "loss": max(-(q * w).sum(), 0) / (own * strongest * (s.sum() or 1.0)),
        }


TOLERANCES = {
    "penetration": CONDITIONS,
    "complementarity": CONDITIONS,
    "tension": 0.0,
    "hardness": 0.0,
    "cone": 1e-11,
    "slip": CONDITIONS,
    "load": ROUNDING,
    "tangential load": ROUNDING,
    "energy": 1e-10,
    "loss": CONDITIONS,
}


def draw_material(draws):
    """Return Young's modulus, Pa, and Poisson's ratio."""
    return float(10 ** draws.uniform(9, 11.5)), float(draws.uniform(-0.3, 0.5))


def make_material(young, poisson, hardness):
    """Return an elastic material, or one that yields at a hardness."""
    if hardness == np.inf:
        return rc.Elastic(young, poisson)
    return rc.ElasticPerfectlyPlastic(young, poisson, hardness)


def draw_heights(draws, grid):
    """Return heights of very different character, about one high."""
    kind = draws.choice(["noise", "bowl", "wave", "steps"])
    x, y = grid.x / max(grid.size), grid.y / max(grid.size)
    noise = draws.standard_normal(grid.shape)
    return {
        "noise": noise,
        "bowl": -20 * (x**2 + y**2) + 0.02 * noise,
        "wave": np.cos(2 * np.pi * x) * (1 + 0.3 * np.cos(4 * np.pi * y)) + 0.05 * noise,
        "steps": (noise > 0.5) * 1.0 + 0.01 * noise,
    }[kind]


def run(seed, yields=False):
    """Follow one random path; return what happened, and the violations of its worst state.

    Bodies that yield have a hardness of a few times the nominal pressure.
    """
    draws = np.random.default_rng(seed)
    shape = tuple(int(n) for n in draws.integers(2, 13, 2))
    cell = 10 ** draws.uniform(-8, -3)
    grid = rc.Grid(shape, (shape[0] * cell, shape[1] * cell * draws.uniform(0.5, 2)))
    heights = draw_heights(draws, grid) * cell * 10 ** draws.uniform(-4, -1)
    one = draw_material(draws)
    pairing = draws.choice(["like", "unlike", "rigid"])
    other = {"like": one, "unlike": draw_material(draws), "rigid": None}[pairing]
    boundary = str(draws.choice(["free", "periodic"]))
    modulus, beta, gamma = constants(one, other)
    make = free_matrix if boundary == "free" else periodic_matrix
    mu = float(10 ** draws.uniform(-1.5, 0.3))
    mu = min(mu, 0.9 / abs(beta)) if beta else mu
    law = str(draws.choice(["number", "varying", "limited"]))
    pressure = modulus * np.ptp(heights) / max(grid.size) * 10 ** draws.uniform(-2, 0.3)
    hardness = pressure * 10 ** np.random.default_rng((seed, 1)).uniform(0.3, 1.5) if yields else np.inf
    bodies = [rc.Rigid() if body is None else make_material(*body, hardness) for body in (one, other)]
    problem = rc.ContactProblem(
        rc.Body(rc.HeightMap(heights, grid.size), bodies[0]),
        rc.Body(rc.FlatSurface(), bodies[1]),
        grid=grid,
        boundary=boundary,
        kernel="love" if boundary == "free" else "fourier",
        threads=1,
    )
    varying = mu * draws.uniform(0.2, 1.0, shape)
    top = 2 * mu * pressure
    friction, strength = {
        "number": (mu, lambda p: mu * p),
        "varying": (rc.Coulomb(varying), lambda p: varying.ravel() * p),
        "limited": (rc.LimitedCoulomb(mu, top), lambda p: np.minimum(mu * p, top)),
    }[law]
    judge = Judge(make(shape, grid.spacing, modulus, beta, gamma), heights, grid.cell_area, strength, hardness)
    steps = int(draws.integers(1, 5))
    constant = draws.random() < 0.5
    kind = str(draws.choice(["force", "pressure", "approach"]))
    full = heights.max() - heights.mean()
    middle = {"force": pressure * grid.area, "pressure": pressure, "approach": 0.3 * full}[kind]
    loads = [middle] * steps if constant else list(middle * draws.uniform(0.4, 1.5, steps))
    substeps = int(draws.integers(1, 4))
    if draws.random() < 0.6:
        carried = (
            min(loads) * {"force": 1.0, "pressure": grid.area, "approach": 0.1 * pressure * grid.area / full}[kind]
        )
        name, unit = "tangential_force", 0.2 * mu * carried
    else:
        # About what slides.
        name, unit = "displacement", mu * pressure * max(grid.size) / modulus
    targets = [tuple(float(value) for value in unit * draws.uniform(-1, 1, 2)) for _ in range(steps)]
    label = f"{pairing}, {boundary}"
    worst = {}

    def judge_state(state, load, target):
        found = judge.judge(state, load, target)
        worst.update({key: max(value, worst.get(key, 0.0)) for key, value in found.items()})

    def judge_increment(done):
        ((kind, value),) = done.state.origin.load.items()
        judge_state(done.state, (kind, value), (done.state.tangential_load.kind, done.state.tangential_load.values))

    try:
        path = problem.path(
            **{kind: loads[0] if constant else loads, name: targets},
            friction=friction,
            substeps=substeps,
            # What flows in an increment counts in the next.
            on_increment=judge_increment if yields else None,
        )
    except rc.InputError as error:
        return label, "refused: " + str(error)[:40], {}
    except rc.NotConverged:
        return label, "not converged", {}
    if not yields:
        for state, load, target in zip(path, loads, targets, strict=True):
            judge_state(state, (kind, load), (name, np.array(target)))
    falsely = [key for key, value in worst.items() if not value <= TOLERANCES[key]]
    return label, "false: " + ", ".join(falsely) if falsely else "verified", worst


def main(count=2000, first=0, yields=0):
    """Print the outcomes by kind, the worst violations, and the seeds of what was not verified."""
    started = time.process_time()
    outcomes, worst, slowest, others = Counter(), {}, (0.0, -1), []
    for seed in range(first, first + count):
        begin = time.process_time()
        label, outcome, violations = run(seed, yields=bool(yields))
        slowest = max(slowest, (time.process_time() - begin, seed))
        outcomes[label, outcome] += 1
        worst = {key: max(value, worst.get(key, 0.0)) for key, value in {**worst, **violations}.items()}
        if outcome != "verified":
            others.append((seed, outcome))
    for (label, outcome), number in sorted(outcomes.items()):
        print(f"{label:18} {outcome:50} {number}")
    print(", ".join(f"{key} {value:.1e}" for key, value in worst.items()))
    print(f"{time.process_time() - started:.0f} s, slowest {slowest[0]:.1f} s (seed {slowest[1]})")
    print("others:", *others[:40], sep="\n  ")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
