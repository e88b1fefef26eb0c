"""Small contact problems and solutions that parts are tried on."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import cache

import attrs
import numpy as np

from roughcontact._base.checks import Array
from roughcontact._parts.grid import Boundary, Grid
from roughcontact._parts.load import Load
from roughcontact._parts.materials import Elastic, ElasticPerfectlyPlastic, Material
from roughcontact._parts.surfaces import HeightMap, ParaboloidSurface, SelfAffineSurface, WavySurface
from roughcontact._solve.problem import Body, ContactProblem
from roughcontact._solve.solution import ContactSolution
from roughcontact._solve.solvers import Solver
from roughcontact.errors import InputError

# Elastic constants of the trials, Pa and 1; any would do, for the problems are dimensionless inside.
YOUNG = 1e9
POISSON = 0.3
# Contact modulus on a rigid body, Pa.
MODULUS = YOUNG / (1.0 - POISSON**2)
ELASTIC = Elastic(YOUNG, POISSON)


@attrs.frozen(eq=False)
class Case:
    """A contact problem and its load, for any solver."""

    name: str
    surface: HeightMap
    hardness: float | Array | None
    boundary: Boundary
    load: Load
    young: float = YOUNG

    def problem(self, solver: Solver) -> ContactProblem:
        """Return the problem."""
        material: Material = Elastic(self.young, POISSON)
        if self.hardness is not None:
            material = ElasticPerfectlyPlastic(self.young, POISSON, self.hardness)
        return ContactProblem(Body(self.surface, material), boundary=self.boundary, solver=solver)

    def scaled(self, length: float, stiffness: float) -> Case:
        """Return the case with all lengths and moduli times a factor."""
        x, y = self.surface.size
        return attrs.evolve(
            self,
            surface=HeightMap(length * self.surface.values, (length * x, length * y)),
            hardness=None if self.hardness is None else stiffness * self.hardness,
            load=Load(self.load.kind, self.load.value * (length if self.load.kind == "approach" else stiffness)),
            young=stiffness * self.young,
        )

    def __str__(self) -> str:
        return f"{self.name}, boundary {self.boundary}"


def _maps() -> Iterator[tuple[str, HeightMap]]:
    rng = np.random.default_rng(11)
    noise = rng.standard_normal((12, 10))
    grid = Grid((12, 10), (12e-6, 15e-6))
    yield "noise", HeightMap(1e-7 * noise, grid.size)
    yield "bowl", HeightMap(1e-7 * noise - (grid.x**2 + grid.y**2) / 4e-5, grid.size)


def cases() -> Iterator[Case]:
    """Give small problems of every boundary, load and pressure limit, from first touch to the admissible maximum."""
    for (name, surface), boundary in itertools.product(_maps(), Boundary):
        scale = MODULUS * float(np.ptp(surface.values)) / max(surface.size)
        full = float(surface.values.max() - surface.values.mean())
        hardness = 0.3 * scale
        uneven = scale * np.linspace(0.1, 0.9, 120).reshape(12, 10)
        for text, limit, load in (
            *((f"elastic, {part:g} of E* slope", None, Load("pressure", part * scale)) for part in (1e-4, 0.1, 10.0)),
            *(("approach given", None, Load("approach", part * full)) for part in (0.01, 0.6)),
            *((f"{part:g} of the hardness", hardness, Load("pressure", part * hardness)) for part in (0.01, 0.5, 1.0)),
            ("uneven hardness", uneven, Load("pressure", 0.2 * scale)),
            ("plastic, approach given", hardness, Load("approach", 0.5 * full)),
        ):
            yield Case(f"{name}, {text}", surface, limit, boundary, load)


def solve_cases(solver: Solver) -> Iterator[tuple[str, Case, ContactProblem, ContactSolution]]:
    """Solve all cases that a solver does not refuse."""
    for case in cases():
        with suppress(InputError):
            problem = case.problem(solver)
            yield str(case), case, problem, problem.solve(throw=False, **case.load.arguments)


@cache
def rough_contact(pressure: float, boundary: Boundary = Boundary.PERIODIC, plastic: bool = False) -> ContactSolution:
    """Return the contact of a rough surface of 48 x 40 cells at a fraction of E* times its rms slope."""
    surface = SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=8e-6, longest=40e-6, seed=5)
    scale = 0.1 * MODULUS
    material = ElasticPerfectlyPlastic(YOUNG, POISSON, 0.15 * scale) if plastic else ELASTIC
    problem = ContactProblem(Body(surface, material), grid=Grid((48, 40), (48e-6, 40e-6)), boundary=boundary)
    return problem.solve(pressure=pressure * scale)


@cache
def full_contact() -> ContactSolution:
    """Return a wavy surface pressed flat."""
    body = Body(WavySurface(1e-7, 1e-5), ELASTIC)
    problem = ContactProblem(body, grid=Grid((16, 12), (1e-5, 1e-5)), boundary=Boundary.PERIODIC)
    return problem.solve(pressure=1e9)


@cache
def sphere_contact(cells: float, offset: tuple[float, float]) -> ContactSolution:
    """Return Hertz's contact of a radius given in cells; the summit is offset from the centre, in cells."""
    n = 40
    radius = 1e-2
    grid = Grid((n, n), 1e-3)
    centre = offset[0] * grid.spacing[0], offset[1] * grid.spacing[1]
    body = Body(ParaboloidSurface(radius, center=centre), ELASTIC)
    force = 4.0 * MODULUS * (cells * grid.spacing[0]) ** 3 / (3.0 * radius)
    return ContactProblem(body, grid=grid).solve(force=force)


def _with_fields(solution: ContactSolution, change: Callable[[Array], Array]) -> ContactSolution:
    limit = solution.pressure_limit
    return attrs.evolve(
        solution,
        pressure=change(solution.pressure),
        displacement=change(solution.displacement),
        initial_gap=change(solution.initial_gap),
        pressure_limit=change(limit) if limit.ndim else limit,
    )


def mirror(solution: ContactSolution, axes: tuple[int, ...]) -> ContactSolution:
    """Return the mirror image of a solution along the axes."""
    return _with_fields(solution, lambda field: np.ascontiguousarray(np.flip(field, axes)))


def shift(solution: ContactSolution, cells: tuple[int, int]) -> ContactSolution:
    """Return a periodic solution shifted by a number of cells along x and y."""
    return _with_fields(solution, lambda field: np.roll(field, cells, axis=(0, 1)))


def scale_units(solution: ContactSolution, length: float, stiffness: float) -> ContactSolution:
    """Return the solution with all lengths and moduli times a factor."""
    grid = solution.grid
    return attrs.evolve(
        solution,
        grid=Grid(grid.shape, (length * grid.size[0], length * grid.size[1])),
        modulus=stiffness * solution.modulus,
        pressure_limit=np.asarray(stiffness * solution.pressure_limit),
        pressure=stiffness * solution.pressure,
        displacement=length * solution.displacement,
        initial_gap=length * solution.initial_gap,
        approach=length * solution.approach,
        residuals=attrs.evolve(solution.residuals, scale=length * solution.residuals.scale),
    )
