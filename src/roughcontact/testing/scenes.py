"""Small scenes that parts are tried on, and an independent judge of their solutions."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from functools import cache
from typing import Any, TypeAlias

import attrs
import numpy as np

from roughcontact.body import Body
from roughcontact.checks import Array, Mask
from roughcontact.errors import InputError
from roughcontact.grid import Boundary, Grid
from roughcontact.kernels import BoundKernel
from roughcontact.materials import Elastic, ElasticPerfectlyPlastic, Material
from roughcontact.problem import ContactProblem
from roughcontact.solution import ContactSolution
from roughcontact.solvers import Solver
from roughcontact.surfaces import HeightMap, ParaboloidSurface, SelfAffineSurface, WavySurface
from roughcontact.testing.dense import dense_matrix

YOUNG, POISSON = 1e9, 0.3
MODULUS = YOUNG / (1.0 - POISSON**2)
ELASTIC = Elastic(YOUNG, POISSON)
# One of pressure, force and approach, with its value.
Load: TypeAlias = dict[str, Any]
# Rounding of fields, in units of the last place of their greatest value.
_PLACES = 64.0 * float(np.finfo(np.float64).eps)
# What the docs say that rounding may hide.
_UNRESOLVED = 1e-5


@attrs.frozen(eq=False)
class Trial:
    """A contact problem and its load, to be solved by some solver."""

    name: str
    surface: HeightMap
    material: Material
    boundary: Boundary
    load: Load

    def problem(self, solver: Solver, *, length: float = 1.0, stiffness: float = 1.0) -> ContactProblem:
        """Return the problem with all lengths and moduli times a factor."""
        surface = HeightMap(length * self.surface.values, tuple(length * side for side in self.surface.size))
        material: Material = Elastic(stiffness * YOUNG, POISSON)
        if isinstance(self.material, ElasticPerfectlyPlastic):
            hardness = stiffness * np.asarray(self.material.hardness)
            material = ElasticPerfectlyPlastic(
                stiffness * YOUNG, POISSON, hardness if hardness.ndim else hardness.item()
            )
        return ContactProblem(Body(surface, material), boundary=self.boundary, solver=solver)

    def __str__(self) -> str:
        return f"{self.name}, boundary {self.boundary}"


def _maps() -> Iterator[tuple[str, HeightMap]]:
    rng = np.random.default_rng(11)
    noise = rng.standard_normal((12, 10))
    grid = Grid((12, 10), (12e-6, 15e-6))
    yield "noise", HeightMap(1e-7 * noise, grid.size)
    yield "bowl", HeightMap(1e-7 * noise - (grid.x**2 + grid.y**2) / 4e-5, grid.size)


def trials() -> Iterator[Trial]:
    """Give small problems of every boundary, load and limit, from a light touch to all that is carried."""
    for (name, surface), boundary in itertools.product(_maps(), Boundary):
        relief = float(np.ptp(surface.values))
        scale = MODULUS * relief / max(surface.size)
        for share in (1e-4, 0.1, 10.0):
            yield Trial(f"{name} at {share:g} of E* slope", surface, ELASTIC, boundary, {"pressure": share * scale})
        full = float(surface.values.max() - surface.values.mean())
        for share in (0.01, 0.6):
            yield Trial(f"{name}, approached", surface, ELASTIC, boundary, {"approach": share * full})
        flat = ElasticPerfectlyPlastic(YOUNG, POISSON, 0.3 * scale)
        for share in (0.01, 0.5, 1.0):
            load = {"pressure": share * 0.3 * scale}
            yield Trial(f"{name}, capped, {share:g} of the cap", surface, flat, boundary, load)
        uneven = ElasticPerfectlyPlastic(YOUNG, POISSON, scale * np.linspace(0.1, 0.9, 120).reshape(12, 10))
        yield Trial(f"{name}, unevenly capped", surface, uneven, boundary, {"pressure": 0.2 * scale})
        yield Trial(f"{name}, capped and approached", surface, flat, boundary, {"approach": 0.5 * full})


def taken(solver: Solver) -> Iterator[tuple[Trial, ContactProblem, ContactSolution]]:
    """Solve all trials that a solver does not refuse."""
    for trial in trials():
        problem = trial.problem(solver)
        try:
            solution = problem.solve(throw=False, **trial.load)
        except InputError:
            continue
        yield trial, problem, solution


@attrs.frozen
class Judgement:
    """What a dense matrix says of a pressure: errors in units of the documented scale."""

    error: float
    load: float
    bounded: bool
    floor: float


def judge(problem: ContactProblem, load: Load, solution: ContactSolution) -> Judgement:
    """Judge a solution by its pressure alone."""
    plan, grid = problem.plan, problem.plan.grid
    matrix = dense_matrix(BoundKernel(plan.kernel, 1.0 / plan.modulus), grid, problem.boundary)
    p, limit = solution.pressure.ravel(), np.broadcast_to(plan.limit, grid.shape).ravel()
    undeformed, moved = problem.undeformed.ravel(), matrix @ p
    level, capped = moved + undeformed, p >= limit
    bearing = np.where(capped, 0.0, p)
    if "approach" in load:
        datum, off = load["approach"], 0.0
    else:
        off = abs(float(p.mean()) / load["pressure"] - 1.0)
        datum = float(bearing @ level / bearing.sum()) if bearing.any() else _between(level, capped, p)
    gap = level - datum
    scale = min(float(undeformed.std()), float(np.ptp(moved))) or float(undeformed.std())
    wrong = np.where(capped, np.maximum(gap, 0.0), np.abs(gap))
    opened = float(p @ wrong / p.sum()) if p.any() else 0.0
    closed = max(0.0, -float(gap[~capped].min(initial=np.inf)))
    # On a periodic domain the mean moves nothing, but its rounding does.
    largest = float(np.abs(matrix).sum(axis=1).max() * p.max() + undeformed.max() + abs(datum))
    bounded = bool((p >= 0.0).all() and (p <= limit).all())
    return Judgement(max(opened, closed) / scale, off, bounded, _PLACES * largest / scale)


def _between(level: Array, capped: Mask, p: Array) -> float:
    lower = float(level[capped].max(initial=level.min()))
    opened = level[p <= 0.0]
    return min(lower, float(opened.min())) if opened.size else lower


def allowed(solver: Solver, judgement: Judgement, solution: ContactSolution) -> float:
    """Return the greatest error that the status of a solution allows."""
    margin = 2.0 * solver.tolerance + judgement.floor
    return max(margin, 2.0 * _UNRESOLVED) if "rounding" in str(solution.status) else margin


@cache
def rough(pressure: float, boundary: Boundary = Boundary.PERIODIC, capped: bool = False) -> ContactSolution:
    """Return the contact of a rough surface of 48 x 40 cells at a share of E* times its rms slope."""
    surface = SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=8e-6, longest=40e-6, seed=5)
    scale = 0.1 * MODULUS
    material = ElasticPerfectlyPlastic(YOUNG, POISSON, 0.15 * scale) if capped else ELASTIC
    problem = ContactProblem(Body(surface, material), grid=Grid((48, 40), (48e-6, 40e-6)), boundary=boundary)
    return problem.solve(pressure=pressure * scale)


@cache
def full() -> ContactSolution:
    """Return a contact without a gap."""
    body = Body(WavySurface(1e-7, 1e-5), ELASTIC)
    problem = ContactProblem(body, grid=Grid((16, 12), (1e-5, 1e-5)), boundary=Boundary.PERIODIC)
    return problem.solve(pressure=1e9)


@cache
def sphere(cells: float, offset: tuple[float, float]) -> ContactSolution:
    """Return Hertz's contact with a radius of so many cells, its summit somewhere in a cell."""
    n, radius = 40, 1e-2
    grid = Grid((n, n), 1e-3)
    centre = offset[0] * grid.spacing[0], offset[1] * grid.spacing[1]
    body = Body(ParaboloidSurface(radius, center=centre), ELASTIC)
    force = 4.0 * MODULUS * (cells * grid.spacing[0]) ** 3 / (3.0 * radius)
    return ContactProblem(body, grid=grid).solve(force=force)
