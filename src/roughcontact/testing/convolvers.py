"""Claims about convolvers."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from roughcontact._base.arrays import Array, RealArray
from roughcontact._parts.grid import Boundary, Grid
from roughcontact._parts.kernels import BoundKernel, Love
from roughcontact._solve.convolvers import ConvolutionSetup, Convolver, PreparedConvolution
from roughcontact.errors import InputError
from roughcontact.testing.claim import (
    claim,
    claim_input_unchanged,
    claim_powers_of_two,
    claim_repeatable,
    require,
    require_close,
)
from roughcontact.testing.problems import displace

_KERNEL = BoundKernel(Love())
GRIDS = (Grid((9, 8), (9.0, 8.0)), Grid((6, 13), (6.0, 26.0)), Grid((1, 10), (1.0, 10.0)), Grid((12, 1), (6.0, 1.0)))
# Maximum relative error of a displacement by rounding, with three digits to spare.
ROUNDING_ERROR = 1e-11


def _cases(convolver: Convolver) -> Iterator[tuple[str, PreparedConvolution, Array, Array]]:
    """Give convolutions for every boundary, each with two pressures that are read-only."""
    rng = np.random.default_rng(7)
    for boundary in sorted(convolver.boundaries):
        for grid in GRIDS:
            pressures = rng.random((2, *grid.shape))
            pressures.flags.writeable = False
            convolution = convolver.prepare(_KERNEL, grid, boundary)
            valid = isinstance(convolution, PreparedConvolution) and isinstance(convolution.setup, ConvolutionSetup)
            require(valid, "`prepare` must return a PreparedConvolution whose `setup` is a ConvolutionSetup")
            yield f"{grid}, {boundary}", convolution, pressures[0], pressures[1]


def _sum_plainly(convolution: PreparedConvolution, pressure: Array) -> Array:
    boundary = convolution.setup.boundary
    return displace(_KERNEL.responses(convolution.setup.grid, boundary), pressure, boundary)


@claim("convolver", "boundaries")
def _boundaries(convolver: Convolver) -> str:
    served = convolver.boundaries
    require(served and all(isinstance(one, Boundary) for one in served), f"its boundaries are {served!r}")
    for boundary in set(Boundary) - set(served):
        try:
            convolver.prepare(_KERNEL, GRIDS[0], boundary)
        except InputError:
            continue
        require(False, f"it prepares the boundary {boundary}, which `boundaries` does not contain")
    for boundary in served:
        nx, ny = convolver.transform_shape(GRIDS[0], boundary)
        require(nx >= 9 and ny >= 8, f"its transform of 9 x 8 cells has {nx} x {ny}")
    return f"serves {' and '.join(sorted(served))}, and refuses the others"


@claim("convolver", "sum over all cells", _cases)
def _sum(_: Convolver, convolution: PreparedConvolution, one: Array, __: Array) -> float:
    return require_close(
        convolution.apply(one), _sum_plainly(convolution, one), ROUNDING_ERROR, "it differs from plain sums"
    )


@claim("convolver", "linear", _cases)
def _linear(_: Convolver, convolution: PreparedConvolution, one: Array, other: Array) -> float:
    expected = 2.5 * convolution.apply(one) - 0.3 * convolution.apply(other)
    found = convolution.apply(2.5 * one - 0.3 * other)
    return require_close(found, expected, ROUNDING_ERROR, "the displacement by two pressures is not the sum of both")


@claim("convolver", "reciprocal (Betti)", _cases)
def _reciprocal(_: Convolver, convolution: PreparedConvolution, one: Array, other: Array) -> None:
    displacement = convolution.apply(one)
    error = abs(convolution.dot(one, convolution.apply(other)) - convolution.dot(other, displacement))
    require(error <= 1e-12 * float(np.abs(displacement).sum()), "the work of one pressure on another is not mutual")


@claim("convolver", "positive energy", _cases)
def _energy(_: Convolver, convolution: PreparedConvolution, one: Array, other: Array) -> None:
    # Wrapping loses the positivity of waves that are longer than the domain.
    pressure = one if convolution.setup.boundary is Boundary.WRAPPED else one - other
    displacement = convolution.apply(pressure)
    rounding = 1e-12 * float(np.abs(displacement).max() * np.abs(pressure).sum())
    require(convolution.dot(pressure, displacement) >= -rounding, "a pressure has negative energy")


def _prepare_pressure(
    _: Convolver, convolution: PreparedConvolution, one: Array, __: Array
) -> tuple[dict[str, Array], Callable[[], RealArray]]:
    given = one.copy()
    return {"pressure": given}, lambda: convolution.apply(given)


claim_input_unchanged("convolver", _cases, _prepare_pressure)
claim_repeatable(
    "convolver",
    _cases,
    lambda _, convolution, one, __: [convolution.apply(one)],
    lambda _, convolution, __, other: convolution.apply(other),
)


@claim("convolver", "float32 and float64", _cases)
def _single(_: Convolver, convolution: PreparedConvolution, one: Array, __: Array) -> float:
    single = convolution.apply(one.astype(np.float32))
    double = convolution.apply(one)
    require(single.dtype == np.float32, f"a float32 pressure gives {single.dtype}")
    require(double.dtype == np.float64, f"a float64 pressure gives {double.dtype}")
    return require_close(single, double, 1e-5, "in float32 it differs")


claim_powers_of_two(
    "convolver",
    _cases,
    lambda _, convolution, one, __, factor: [(convolution.apply(factor * one), factor * convolution.apply(one))],
    ((2.0**40,), (2.0**-60,)),
    "a pressure times {:g} changes bits",
)


@claim("convolver", "setup")
def _setup(convolver: Convolver) -> None:
    other = Grid((5, 4), 3.0)
    pressure = np.random.default_rng(1).random((5, 4))
    for boundary in convolver.boundaries:
        convolution = convolver.prepare(_KERNEL, GRIDS[0], boundary)
        setup = convolution.setup
        parts = (setup.convolver, setup.kernel, setup.grid, setup.boundary)
        require(parts == (convolver, _KERNEL, GRIDS[0], boundary), f"it was not prepared from {setup}")
        expected = displace(_KERNEL.responses(other, boundary), pressure, boundary)
        found = convolution.on(other).apply(pressure)
        require_close(found, expected, ROUNDING_ERROR, f"prepared on another grid, boundary {boundary}, it differs")
