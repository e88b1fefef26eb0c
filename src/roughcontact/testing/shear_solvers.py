"""Claims about solvers of shear."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import attrs
import numpy as np

from roughcontact._base.arrays import Array, RealArray
from roughcontact._parts.grid import Boundary, Grid
from roughcontact._parts.kernels import BoundKernel, Love
from roughcontact._parts.materials import PairConstants
from roughcontact._solve.convolvers import DCFFT, CircularFFT, ConvolutionSetup, ShearConvolution
from roughcontact._solve.solvers import ShearSolver, ShearTask, natural_residual
from roughcontact.testing.claim import claim, require, require_close
from roughcontact.testing.generic import claim_input_unchanged, claim_powers_of_two, claim_repeatable

# Residual that the solvers must reach, and by how much shears may differ then, over the maximum limit.
_TOLERANCE = 1e-8
_DIFFERENCE = 1e-5
# Error of sums and magnitudes by rounding.
_ROUNDING = 1e-13
_SHAPE = (24, 20)
# Fraction of the force of sliding, or displacement, along x and y.
_GIVEN = {
    "small force": ((0.1, 0.0), (None, None)),
    "oblique force": ((0.4, 0.3), (None, None)),
    "near sliding": ((0.0, -0.97), (None, None)),
    "displacement": ((None, None), (2.0, 1.0)),
    "force and displacement": ((0.3, None), (None, 0.5)),
}


def _convolve(boundary: Boundary, compliance: float = 1.0) -> ShearConvolution:
    grid = Grid(_SHAPE, (float(_SHAPE[0]), float(_SHAPE[1])))
    kernel = BoundKernel(Love(), compliance=compliance, pair=PairConstants(0.0, 0.4))
    convolver = DCFFT() if boundary is Boundary.FREE else CircularFFT()
    return convolver.prepare(kernel, grid, boundary).shear()


def _cases(_: object) -> Iterator[tuple[str, ShearConvolution, ShearTask]]:
    """Yield a name, a convolution and a task: a ball with a stretch of small limits, and displacements of cells."""
    x, y = ((np.arange(n) - 0.5 * n + 0.3) / (0.4 * n) for n in _SHAPE)
    limit = np.sqrt(np.maximum(1.0 - x[:, np.newaxis] ** 2 - y**2, 0.0))
    limit[:8] *= 1e-3
    offset = 0.2 * np.random.default_rng(1).standard_normal((2, *_SHAPE))
    for boundary in (Boundary.FREE, Boundary.PERIODIC):
        convolution = _convolve(boundary)
        for name, (force, displacement) in _GIVEN.items():
            fx, fy = (None if one is None else one * float(limit.sum()) for one in force)
            task = ShearTask(
                limit=limit, offset=offset, shear_force=(fx, fy), displacement=displacement, tolerance=_TOLERANCE
            )
            yield f"{name}, {boundary}", convolution, attrs.evolve(task, max_iterations=20_000)


@claim("shear solver", "stick and slip", _cases)
def _conditions(solver: ShearSolver, convolution: ShearConvolution, task: ShearTask) -> float:
    found = solver.solve(convolution, task)
    require(found.status.success, f"{found.status}")
    moved = np.reshape(found.displacement, (2, 1, 1))
    slip = task.offset + moved - convolution.apply(found.shear)
    residual = natural_residual(found.shear, slip, task.limit, float(np.mean(convolution.own)))
    require(residual <= 1.01 * _TOLERANCE, f"a residual of {residual:.1e}, above {_TOLERANCE:.1e}")
    return residual


@claim("shear solver", "limits and forces to rounding", _cases)
def _bounds(solver: ShearSolver, convolution: ShearConvolution, task: ShearTask) -> None:
    found = solver.solve(convolution, task)
    beyond = float((np.hypot(*found.shear) - task.limit).max())
    require(beyond <= _ROUNDING * task.limit.max(), f"a shear of {beyond:.1e} above its limit")
    for axis, force in enumerate(task.shear_force):
        if force is not None:
            error = abs(float(found.shear[axis].sum()) - force)
            require(error <= _ROUNDING * task.limit.sum(), f"an error of the force of {error:.1e}")
    for given, moved in zip(task.displacement, found.displacement, strict=True):
        require(given is None or given == moved, f"a displacement of {moved} where {given} is given")


@claim("shear solver", "any start", _cases)
def _starts(solver: ShearSolver, convolution: ShearConvolution, task: ShearTask) -> float:
    expected = solver.solve(convolution, task).shear
    other = solver.solve(convolution, attrs.evolve(task, start=-2.0 * expected[:, ::-1]))
    return require_close(other.shear, expected, _DIFFERENCE, "another start changes the shear")


@claim("shear solver", "opposite directions", _cases)
def _directions(solver: ShearSolver, convolution: ShearConvolution, task: ShearTask) -> float:
    expected = solver.solve(convolution, task).shear
    fx, fy = (None if one is None else -one for one in task.shear_force)
    dx, dy = (None if one is None else -one for one in task.displacement)
    opposite = attrs.evolve(task, offset=-task.offset, shear_force=(fx, fy), displacement=(dx, dy))
    return require_close(
        -solver.solve(convolution, opposite).shear, expected, _DIFFERENCE, "the opposite task has another shear"
    )


def _prepare(
    solver: ShearSolver, convolution: ShearConvolution, task: ShearTask
) -> tuple[dict[str, Any], Callable[[], object]]:
    given: dict[str, Any] = {"limit": task.limit.copy(), "offset": task.offset.copy(), "start": 0.1 * task.offset}
    return given, lambda: solver.solve(convolution, attrs.evolve(task, **given))


claim_input_unchanged("shear solver", _cases, _prepare)
claim_repeatable("shear solver", _cases, lambda solver, convolution, task: [solver.solve(convolution, task).shear])


def _scale(
    solver: ShearSolver, convolution: ShearConvolution, task: ShearTask, stress: float, compliance: float
) -> list[tuple[RealArray, RealArray]]:
    length = stress * compliance
    fx, fy = (None if one is None else stress * one for one in task.shear_force)
    dx, dy = (None if one is None else length * one for one in task.displacement)
    other = attrs.evolve(
        task,
        limit=stress * task.limit,
        offset=length * task.offset,
        shear_force=(fx, fy),
        displacement=(dx, dy),
    )
    found = solver.solve(_convolve(convolution.setup.boundary, compliance), other).shear
    return [(found, stress * solver.solve(convolution, task).shear)]


claim_powers_of_two(
    "shear solver",
    _cases,
    _scale,
    ((2.0**20, 1.0), (2.0**-30, 2.0**25)),
    "limits times {:g} and compliances times {:g} change bits",
)


class _Diverging(ShearConvolution):
    """A convolution that returns infinite displacements after a few calls."""

    def __init__(self, convolution: ShearConvolution, finite: int) -> None:
        self._convolution = convolution
        self._finite = finite
        self.calls = 0

    @property
    def setup(self) -> ConvolutionSetup:
        return self._convolution.setup

    def apply(self, tractions: RealArray, of: str = "xy", to: str = "xy") -> Array:
        self.calls += 1
        response = self._convolution.apply(tractions, of, to)
        return np.asarray(response * (np.inf if self.calls > self._finite else 1.0))


@claim("shear solver", "stops at non-finite values")
def _stops(solver: ShearSolver) -> str:
    name, convolution, task = next(_cases(solver))
    broken = _Diverging(convolution, 4)
    broken.own  # noqa: B018 - it is computed by two calls and kept
    try:
        outcome = solver.solve(broken, task)
    except Exception as error:
        advice = "a solver must return Status.NOT_FINITE"
        raise AssertionError(f"{name}: with infinite displacements it raised {error!r}: {advice}") from error
    require(not outcome.status.success, f"{name}: with infinite displacements it is {outcome.status}")
    return f"{outcome.status}"
