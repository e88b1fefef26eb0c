"""Small contact problems that parts are tried on, and an independent judge of solutions."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from functools import cache, partial
from typing import TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from roughcontact._base.arrays import Array, Mask, RealArray
from roughcontact._parts.grid import Boundary, Grid, Load
from roughcontact._parts.interactions import Exponential
from roughcontact._parts.kernels import BoundKernel
from roughcontact._parts.materials import Elastic, ElasticPerfectlyPlastic, Material
from roughcontact._parts.surfaces import HeightMap, ParaboloidSurface, SelfAffineSurface, WavySurface
from roughcontact._solve.problem import LOAD_TOLERANCE, Body, ContactProblem
from roughcontact._solve.solution import ContactSolution
from roughcontact._solve.solvers import Solver
from roughcontact.errors import InputError

LongArray: TypeAlias = npt.NDArray[np.longdouble]
# Rounding error of fields in float64, in units of the last place of their maximum; measured on random problems.
_FIELD_ROUNDING_ULPS = 64.0
# The error, over the scale, that the documentation allows a solution which has converged to rounding.
_MAX_ERROR_OF_ROUNDED = 1e-5
# Range of the displacement, over the maximum pressure, below which the pressure is uniform up to rounding.
_UNIFORM_RANGE = 1e-12

# Elastic constants of the trials, Pa and 1; any would do, for the problems are dimensionless inside.
YOUNG = 1e9
POISSON = 0.3
# Contact modulus on a rigid body, Pa.
MODULUS = YOUNG / (1.0 - POISSON**2)
ELASTIC = Elastic(YOUNG, POISSON)


@attrs.frozen
class Judgement:
    """How far a solution is from satisfying the contact conditions.

    Attributes
    ----------
    complementarity, penetration
        As in `Residuals`, over the same scale.
    load
        Relative error of the load; zero where the approach was given.
    bounded
        Whether 0 <= p <= pressure limit, to the last bit.
    bound
        The error that the solver's tolerance, its status and rounding allow.

    Examples
    --------
    >>> from roughcontact import testing
    >>> found = testing.Judgement(complementarity=1e-9, penetration=2e-9, load=0.0, bounded=True, bound=1e-8)
    >>> print(found.error, found.holds)
    2e-09 True
    """

    complementarity: float
    penetration: float
    load: float
    bounded: bool
    bound: float

    @property
    def error(self) -> float:
        """The maximum of complementarity and penetration."""
        return max(self.complementarity, self.penetration)

    @property
    def holds(self) -> bool:
        """Whether the solution is as good as its status says."""
        return self.bounded and self.load <= LOAD_TOLERANCE and self.error <= self.bound


def displace(
    responses: RealArray, pressure: RealArray, boundary: Boundary, odd: tuple[bool, bool] = (False, False)
) -> RealArray:
    """Return the displacement by plain sums over all cells.

    Parameters
    ----------
    responses
        Displacement by unit pressure at each offset, shape (nx, ny).
    pressure
        Pressure, shape (nx, ny).
    boundary
        Along free axes absolute offsets count, along the others those to the nearest image.
    odd
        Whether the response is odd in x, and in y.
    """
    i, j = (np.arange(n)[:, np.newaxis] - np.arange(n) for n in pressure.shape)
    i, j = (
        offsets if free else offsets - len(offsets) * np.round(offsets / len(offsets)).astype(int)
        for offsets, free in zip((i, j), boundary.free_axes, strict=True)
    )
    x, y = (np.sign(offsets) if is_odd else np.ones_like(offsets) for offsets, is_odd in zip((i, j), odd, strict=True))
    rows = responses[:, np.abs(j)] * y
    return np.array(
        [
            np.einsum("ajk,ak->j", rows[np.abs(offsets)], pressure * signs[:, np.newaxis])
            for offsets, signs in zip(i, x, strict=True)
        ]
    )


def judge(
    problem: ContactProblem,
    load: Mapping[str, float],
    solution: ContactSolution,
    responses: RealArray | None = None,
) -> Judgement:
    """Return how far the pressure of a solution is from satisfying the contact conditions.

    Parameters
    ----------
    problem
        The problem, without non-measured points. The work is the square of the number of cells.
    load
        The load by the name of its argument, as in ``solution.origin.load``.
    solution
        Its pressure and its status are used, nothing else.
    responses
        Displacement by unit pressure at each offset, shape (nx, ny), m/Pa; by default from the kernel.

    Examples
    --------
    >>> import roughcontact as rc
    >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
    >>> problem = rc.ContactProblem(ball, grid=rc.Grid((8, 8), 100e-6))
    >>> rc.testing.judge(problem, {"force": 1.0}, problem.solve(force=1.0)).holds
    True
    """
    plan = problem.plan
    if responses is None:
        responses = BoundKernel(plan.kernel, 1.0 / plan.modulus).responses(plan.grid, problem.boundary)
    heights = problem.body.heights(plan.grid) + problem.counterbody.heights(plan.grid)
    initial_gap = (heights.max() - heights).astype(np.longdouble)
    pressure = solution.pressure.astype(np.longdouble)
    saturated = pressure >= plan.pressure_limit
    displacement = displace(responses, pressure, problem.boundary)
    level = displacement + initial_gap
    datum = _datum(level, pressure, saturated)
    off = 0.0
    given = Load.of(**load)
    if given.kind == "approach":
        datum = np.longdouble(given.value)
    else:
        area = plan.grid.area if given.kind == "force" else 1.0
        off = abs(float(pressure.mean() * area / np.longdouble(given.value)) - 1.0)
    gap = level - datum
    rms = float(np.std(initial_gap))
    bend = float(np.ptp(displacement))
    bend = bend if bend > _UNIFORM_RANGE * float(pressure.max()) * plan.grid.spacing[0] / plan.modulus else 0.0
    scale = min(rms, bend) or max(rms, bend)
    wrong = np.where(saturated, np.maximum(gap, 0.0), np.abs(gap))
    largest = float(np.abs(displacement).max() + initial_gap.max() + abs(datum))
    margin = 2.0 * plan.solver.tolerance + _FIELD_ROUNDING_ULPS * float(np.finfo(np.float64).eps) * largest / scale
    rounded = "rounding" in str(solution.status)
    return Judgement(
        complementarity=float(np.sum(pressure * wrong) / pressure.sum()) / scale if pressure.any() else 0.0,
        penetration=max(0.0, -float(gap[~saturated].min(initial=np.inf))) / scale,
        load=off,
        bounded=bool((pressure >= 0.0).all() and (pressure <= plan.pressure_limit).all()),
        bound=2.0 * _MAX_ERROR_OF_ROUNDED if rounded else min(margin, 2.0 * _MAX_ERROR_OF_ROUNDED),
    )


def _datum(level: LongArray, pressure: LongArray, saturated: Mask) -> np.longdouble:
    """Return the mean level of the cells in elastic contact, or a level that separates open from saturated cells."""
    elastic = np.where(saturated, 0.0, pressure)
    if elastic.any():
        return np.longdouble(np.sum(elastic * level) / elastic.sum())
    lower = level[saturated].max(initial=level.min())
    upper = level[pressure <= 0.0].min(initial=np.inf)
    return np.longdouble(min(lower, upper))


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

    def solve(self, solver: Solver) -> ContactSolution:
        """Return the solution, converged or not."""
        return self.problem(solver).solve(throw=False, **self.load.arguments)

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


@cache
def adhesive_contact() -> ContactSolution:
    """Return a ball and a flat that attract each other, without a load."""
    body = Body(ParaboloidSurface(2e-6), Elastic(5e6, 0.5))
    law = Exponential(work=0.05, range=2e-7)
    return ContactProblem(body, grid=Grid((32, 32), 8e-6), adhesion=law).solve(force=0.0)


CONTACTS: Mapping[str, Callable[[], ContactSolution]] = {
    "a rough surface": lambda: rough_contact(0.05),
    "a rough surface on a free boundary": lambda: rough_contact(0.05, Boundary.FREE),
    "a rough surface, free along x": lambda: rough_contact(0.05, Boundary.FREE_PERIODIC),
    "a sphere": lambda: sphere_contact(5.0, (0.3, 0.1)),
    "full contact": full_contact,
    "a plastic rough surface": lambda: rough_contact(0.05, Boundary.PERIODIC, True),
    "a plastic rough surface on a free boundary": lambda: rough_contact(0.02, Boundary.FREE, True),
}
PLASTIC_CONTACTS = tuple(name for name in CONTACTS if "plastic" in name)
ELASTIC_CONTACTS = tuple(name for name in CONTACTS if "plastic" not in name)


def list_contacts(*names: str) -> Callable[[object], Iterator[tuple[str, ContactSolution]]]:
    """Return the cases of a claim about a part that is asked of solutions: the named contacts, or all."""
    return lambda _: ((name, CONTACTS[name]()) for name in names or CONTACTS)


@attrs.frozen(eq=False)
class ChangedContact:
    """A solution moved or scaled, and the function that moves or scales an answer to it back."""

    solution: ContactSolution
    restore: Callable[[RealArray], RealArray]


def _with_fields(solution: ContactSolution, change: Callable[[Array], Array]) -> ContactSolution:
    limit = solution.pressure_limit
    return attrs.evolve(
        solution,
        pressure=np.ascontiguousarray(change(solution.pressure)),
        displacement=np.ascontiguousarray(change(solution.displacement)),
        initial_gap=np.ascontiguousarray(change(solution.initial_gap)),
        pressure_limit=np.ascontiguousarray(change(limit)) if limit.ndim else limit,
    )


def _restore_fields(move: Callable[[RealArray], RealArray]) -> Callable[[RealArray], RealArray]:
    """Return a function that moves fields, and leaves numbers as they are."""
    return lambda values: move(values) if values.ndim == 2 else values


def mirror_images(solution: ContactSolution) -> Iterator[ChangedContact]:
    """Give the mirror images of a solution along x, y and both."""
    for axes in ((0,), (1,), (0, 1)):
        mirror = partial(np.flip, axis=axes)
        yield ChangedContact(_with_fields(solution, mirror), _restore_fields(mirror))


def shifted_copies(solution: ContactSolution, *shifts: tuple[int, int]) -> Iterator[ChangedContact]:
    """Give copies of a solution shifted by numbers of cells along the axes on which it repeats; none of others."""
    axes = [axis for axis in (0, 1) if solution.boundary.repeats[axis]]
    for shift in shifts if axes else ():
        steps = [shift[axis] for axis in axes]
        there, back = (partial(np.roll, shift=[sign * step for step in steps], axis=axes) for sign in (1, -1))
        yield ChangedContact(_with_fields(solution, there), _restore_fields(back))


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
