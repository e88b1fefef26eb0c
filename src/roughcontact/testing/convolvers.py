"""Claims about convolvers."""

from __future__ import annotations

from collections.abc import Iterator

import attrs
import numpy as np

from roughcontact.checks import Array, RealArray
from roughcontact.convolvers import Convolver, PlannedConvolution
from roughcontact.errors import InputError
from roughcontact.grid import Boundary, Grid
from roughcontact.kernels import BoundKernel, Love
from roughcontact.testing.claim import Claim, require
from roughcontact.testing.common import common
from roughcontact.testing.dense import dense_matrix

KERNEL = BoundKernel(Love())
_GRIDS = (Grid((9, 8), (9.0, 8.0)), Grid((6, 13), (6.0, 26.0)), Grid((1, 10), (1.0, 10.0)), Grid((12, 1), (6.0, 1.0)))


@attrs.frozen(eq=False)
class _Case:
    """A planned convolution, its matrix, and two pressures that nobody may write to."""

    plan: PlannedConvolution
    boundary: Boundary
    grid: Grid
    one: Array
    other: Array

    def by_matrix(self, pressure: Array) -> Array:
        matrix = dense_matrix(KERNEL, self.grid, self.boundary)
        return np.asarray((matrix @ pressure.ravel()).reshape(self.grid.shape))

    def __str__(self) -> str:
        nx, ny = self.grid.shape
        return f"on {nx} x {ny} cells, boundary {self.boundary}"


def _cases(convolver: Convolver) -> Iterator[_Case]:
    rng = np.random.default_rng(7)
    for boundary in sorted(convolver.boundaries):
        for grid in _GRIDS:
            pressures = rng.random((2, *grid.shape))
            pressures.flags.writeable = False
            yield _Case(convolver.plan(KERNEL, grid, boundary), boundary, grid, pressures[0], pressures[1])


def _off(values: RealArray, expected: RealArray) -> float:
    return float(np.abs(values - expected).max() / max(float(np.abs(expected).max()), 1e-300))


def _boundaries(convolver: Convolver) -> str:
    served = convolver.boundaries
    require(served and all(isinstance(one, Boundary) for one in served), f"its boundaries are {served!r}")
    for boundary in set(Boundary) - set(served):
        try:
            convolver.plan(KERNEL, _GRIDS[0], boundary)
        except InputError:
            continue
        require(False, f"it plans the boundary {boundary}, which it does not declare")
    for boundary in served:
        nx, ny = convolver.transform_shape(_GRIDS[0], boundary)
        require(nx >= 9 and ny >= 8, f"its transform of 9 x 8 cells has {nx} x {ny}")
    return f"serves {' and '.join(sorted(served))}, and refuses the others"


def _sum(convolver: Convolver) -> str:
    worst = 0.0
    for case in _cases(convolver):
        off = _off(case.plan.apply(case.one), case.by_matrix(case.one))
        # Where the mean alone is left, the mean displacement, nothing is left of it.
        require(off <= 1e-11, f"{off:.1e} from the sum over all cells {case}")
        worst = max(worst, off)
    return f"the sum over all cells, to {worst:.0e}"


def _linear(convolver: Convolver) -> str:
    for case in _cases(convolver):
        apart = 2.5 * case.plan.apply(case.one) - 0.3 * case.plan.apply(case.other)
        off = _off(case.plan.apply(2.5 * case.one - 0.3 * case.other), apart)
        require(off <= 1e-11, f"two pressures together move the surface by {off:.1e} otherwise {case}")
    return "two pressures together do what both do"


def _reciprocal(convolver: Convolver) -> str:
    for case in _cases(convolver):
        there, back = (
            case.plan.dot(p, case.plan.apply(q)) for p, q in ((case.one, case.other), (case.other, case.one))
        )
        scale = float(np.abs(case.plan.apply(case.one)).sum())
        require(abs(there - back) <= 1e-12 * scale, f"the work of one pressure on another is not mutual {case}")
    return "the work of one pressure on another is mutual (Betti)"


def _energy(convolver: Convolver) -> str:
    for case in _cases(convolver):
        # Wrapping loses the positivity of waves that are longer than the domain.
        pressure = case.one if case.boundary is Boundary.WRAPPED else case.one - case.other
        displacement = case.plan.apply(pressure)
        least = -1e-12 * float(np.abs(displacement).max() * np.abs(pressure).sum())
        require(case.plan.dot(pressure, displacement) >= least, f"a pressure does negative work {case}")
    return "every pressure does positive work"


def _untouched(convolver: Convolver) -> str:
    for case in _cases(convolver):
        given = case.one.copy()
        case.plan.apply(given)
        require(np.array_equal(given, case.one), f"it changed the pressure {case}")
    return "the pressure is left as it was, and may be read-only"


def _repeatable(convolver: Convolver) -> str:
    for case in _cases(convolver):
        first = case.plan.apply(case.one)
        kept = first.copy()
        case.plan.apply(case.other)
        require(np.array_equal(first, kept), f"a later call changes what an earlier one returned {case}")
        require(np.array_equal(case.plan.apply(case.one), kept), f"asked again, it answers differently {case}")
    return "the same bits, asked again"


def _single(convolver: Convolver) -> str:
    worst = 0.0
    for case in _cases(convolver):
        short = case.plan.apply(case.one.astype(np.float32))
        require(short.dtype == np.float32, f"a float32 pressure gives {short.dtype} {case}")
        require(case.plan.apply(case.one).dtype == np.float64, f"a float64 pressure gives another type {case}")
        size = float(np.abs(dense_matrix(KERNEL, case.grid, case.boundary)).sum(axis=1).max())
        worst = max(worst, float(np.abs(short - case.plan.apply(case.one)).max() / size))
    require(worst <= 1e-5, f"in float32 it is off by {worst:.1e}")
    return f"float32 in, float32 out, to {worst:.0e}"


def _units(convolver: Convolver) -> str:
    for case in _cases(convolver):
        expected = case.plan.apply(case.one)
        for factor in (2.0**40, 2.0**-60):
            same = np.array_equal(case.plan.apply(factor * case.one), factor * expected)
            require(same, f"a pressure times {factor:g} changes bits {case}")
    return "pressures times powers of two change no bit"


def _scene(convolver: Convolver) -> str:
    for case in _cases(convolver):
        scene = case.plan.scene
        told = (scene.convolver, scene.kernel, scene.grid, scene.boundary)
        require(told == (convolver, KERNEL, case.grid, case.boundary), f"it tells another scene, {scene}")
        finer = Grid((5, 4), 3.0)
        pressure = np.random.default_rng(1).random((5, 4))
        matrix = dense_matrix(KERNEL, finer, case.boundary)
        off = _off(case.plan.on(finer).apply(pressure).ravel(), matrix @ pressure.ravel())
        require(off <= 1e-11, f"planned again on another grid it is off by {off:.1e}")
    return "tells what it was planned from, and plans it on other grids"


CLAIMS = (
    Claim("convolver", "boundaries declared", _boundaries),
    Claim("convolver", "the sum over all cells", _sum),
    Claim("convolver", "linear", _linear),
    Claim("convolver", "reciprocal", _reciprocal),
    Claim("convolver", "positive work", _energy),
    Claim("convolver", "input left as it was", _untouched),
    Claim("convolver", "repeatable", _repeatable),
    Claim("convolver", "float32 and float64", _single),
    Claim("convolver", "units", _units),
    Claim("convolver", "tells its scene", _scene),
    *common("convolver"),
)
