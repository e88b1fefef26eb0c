"""Claims about the response to shear: of kernels that have it, and of convolvers that serve it."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from roughcontact._base.arrays import Array, Pair
from roughcontact._parts.grid import Boundary
from roughcontact._parts.kernels import (
    BoundKernel,
    InfluenceKernel,
    Love,
    SupportsCoefficients,
    SupportsShear,
    SupportsSpectrum,
    odd_axes,
)
from roughcontact._parts.materials import PairConstants
from roughcontact._solve.convolvers import Convolver, ShearConvolution
from roughcontact.errors import InputError
from roughcontact.testing.claim import (
    DoesNotApply,
    claim,
    claim_powers_of_two,
    claim_repeatable,
    require,
    require_array,
    require_close,
    require_equal,
)
from roughcontact.testing.convolvers import GRIDS, ROUNDING_ERROR
from roughcontact.testing.kernels import COMPLIANCE, compare_forms
from roughcontact.testing.problems import displace

COMPONENTS = ("xx", "yy", "xy", "zx", "zy")
# A compressible body on a rigid counterbody, and like bodies.
PAIRS = (PairConstants(2 / 7, 3 / 7), PairConstants(0.0, 3 / 7))
_SHAPE = (8, 6)
# Sides of cells, m.
_SPACINGS: tuple[Pair, ...] = ((1e-6, 1e-6), (1e-6, 2.5e-6), (3e-6, 1e-6))


def _bound(kernel: InfluenceKernel, pair: PairConstants = PAIRS[0]) -> BoundKernel:
    """Return a kernel with the constants of a pair, or say that the claim does not apply."""
    if not isinstance(kernel, SupportsShear):
        raise DoesNotApply("the kernel has no response to shear")
    return BoundKernel(kernel, COMPLIANCE, pair=pair)


def _waves(spacing: Pair, shape: tuple[int, int] = _SHAPE) -> tuple[Array, Array]:
    """Return wave numbers above zero and below half the sampling one, shapes (nx, 1) and (1, ny), rad/m."""
    qx, qy = (np.pi / step * np.linspace(0.1, 0.9, n) for n, step in zip(shape, spacing, strict=True))
    return qx[:, np.newaxis], qy[np.newaxis, :]


def _cases(kernel: InfluenceKernel) -> Iterator[tuple[str, BoundKernel, Pair]]:
    for pair in PAIRS:
        for spacing in _SPACINGS:
            yield f"beta {pair.beta:.2g}, cells {spacing[0]:g} x {spacing[1]:g}", _bound(kernel, pair), spacing


def _half_space_cases(kernel: InfluenceKernel) -> Iterator[tuple[str, BoundKernel, Pair]]:
    """Give the cases, if the kernel is of homogeneous half-spaces: it has no modulus that depends on the wave."""
    bound = _bound(kernel)
    if kernel.effective_modulus(np.geomspace(1e4, 1e7, 4), COMPLIANCE) is not None:
        raise DoesNotApply("the constants of the pair are those of half-spaces")
    for spacing in _SPACINGS:
        yield f"cells {spacing[0]:g} x {spacing[1]:g}", bound, spacing


def _answers(bound: BoundKernel, spacing: Pair) -> Iterator[tuple[str, Array]]:
    """Give each component of coefficients and of the spectrum, as the kernel returns it."""
    kernel = bound.kernel
    qx, qy = _waves(spacing)
    assert isinstance(kernel, SupportsShear)
    for component in COMPONENTS:
        if isinstance(kernel, SupportsCoefficients):
            yield component, kernel.shear_coefficients(component, _SHAPE, spacing, bound.compliance, bound.pair)
        if isinstance(kernel, SupportsSpectrum):
            yield component, kernel.shear_spectrum(component, qx, qy, spacing, bound.compliance, bound.pair)


@claim("kernel", "shear: shapes and types", _cases)
def _shapes(_: InfluenceKernel, bound: BoundKernel, spacing: Pair) -> None:
    for component, values in _answers(bound, spacing):
        require_array(values, _SHAPE)
        require(np.isfinite(values).all(), f"{component} has values that are not finite")


claim_repeatable("kernel", _cases, lambda _, *case: [values for _, values in _answers(*case)], name="shear: repeatable")


def _scale(
    _: InfluenceKernel, bound: BoundKernel, spacing: Pair, length: float, compliance: float
) -> Iterator[tuple[Array, Array]]:
    other = BoundKernel(bound.kernel, compliance * bound.compliance, pair=bound.pair)
    longer = length * spacing[0], length * spacing[1]
    for (_name, values), (_name, scaled) in zip(_answers(bound, spacing), _answers(other, longer), strict=True):
        yield scaled, length * compliance * values


claim_powers_of_two(
    "kernel",
    _half_space_cases,
    _scale,
    ((2.0**20, 1.0), (2.0**-30, 1.0), (1.0, 2.0**25)),
    "lengths times {:g} and compliances times {:g} change bits",
    name="shear: powers of two change no bit",
)


@claim("kernel", "shear: odd and even", _cases)
def _parity(kernel: InfluenceKernel, bound: BoundKernel, spacing: Pair) -> None:
    for component in COMPONENTS:
        odd = odd_axes(component)
        if isinstance(kernel, SupportsSpectrum):
            qx, qy = _waves(spacing)
            values = bound.shear_spectrum(component, qx, qy, spacing)
            for waves, is_odd in zip(((-qx, qy), (qx, -qy)), odd, strict=True):
                mirrored = bound.shear_spectrum(component, *waves, spacing)
                expected = -values if is_odd else values
                scale = float(np.abs(bound.shear_spectrum("xx", qx, qy, spacing)).max())
                error = float(np.abs(mirrored - expected).max())
                require(error <= 1e-12 * scale, f"waves of another sign have another {component}")
        if isinstance(kernel, SupportsCoefficients):
            values = bound.shear_coefficients(component, _SHAPE, spacing)
            at_zero = [values.take(0, axis).any() for axis in (0, 1) if odd[axis]]
            require(not any(at_zero), f"{component} is not zero at offset zero of the axis in which it is odd")


@claim("kernel", "shear: positive energy", _cases)
def _energy(kernel: InfluenceKernel, bound: BoundKernel, spacing: Pair) -> float:
    lowest = np.inf
    if isinstance(kernel, SupportsSpectrum):
        waves = _waves(spacing)
        zx, zy = (1j * bound.shear_spectrum(name, *waves, spacing) for name in ("zx", "zy"))
        xx, yy, xy = (bound.shear_spectrum(name, *waves, spacing) for name in ("xx", "yy", "xy"))
        zz = bound.spectrum(*waves, spacing)
        matrix = np.array([[xx, xy, -zx], [xy, yy, -zy], [zx, zy, zz]])
        energies = np.linalg.eigvalsh(np.moveaxis(matrix, (0, 1), (-2, -1)))
        lowest = min(lowest, float((energies[..., 0] / energies[..., -1]).min()))
    if isinstance(kernel, SupportsCoefficients):
        energies = np.linalg.eigvalsh(_matrix_of_cells(bound, (6, 5), spacing))
        lowest = min(lowest, float(energies[0] / energies[-1]))
    require(lowest >= -1e-10, f"pressure and shear have negative energy, {lowest:.1e} of the maximum")
    return lowest


def _matrix_of_cells(bound: BoundKernel, shape: tuple[int, int], spacing: Pair) -> Array:
    """Return the matrix from the tractions x, y, z of all cells to their displacements on a free boundary."""
    cells = np.eye(shape[0] * shape[1]).reshape(-1, *shape)

    def block(responses: Array, odd: tuple[bool, bool]) -> Array:
        return np.array([displace(responses, cell, Boundary.FREE, odd).ravel() for cell in cells]).T

    blocks = {name: block(bound.shear_coefficients(name, shape, spacing), odd_axes(name)) for name in COMPONENTS}
    zz = block(bound.coefficients(shape, spacing), (False, False))
    return np.block([
        [blocks["xx"], blocks["xy"], -blocks["zx"]],
        [blocks["xy"], blocks["yy"], -blocks["zy"]],
        [blocks["zx"], blocks["zy"], zz],
    ])  # fmt: skip


@claim("kernel", "shear: without constants each axis is as the normal one", _half_space_cases)
def _uncoupled(kernel: InfluenceKernel, bound: BoundKernel, spacing: Pair) -> None:
    springs = BoundKernel(kernel, bound.compliance)
    qx, qy = _waves(spacing)
    normals = []
    if isinstance(kernel, SupportsCoefficients):
        normals.append(kernel.coefficients(_SHAPE, spacing, bound.compliance))
    if isinstance(kernel, SupportsSpectrum):
        normals.append(kernel.spectrum(qx, qy, spacing, bound.compliance))
    for place, (component, values) in enumerate(_answers(springs, spacing)):
        normal = normals[place % len(normals)]
        expected = normal if component in ("xx", "yy") else np.zeros(_SHAPE)
        error = float(np.abs(values - expected).max() / normal.max())
        require(error <= 1e-12, f"with beta = gamma = 0, {component} is wrong by {error:.1e}")


@claim("kernel", "shear: signs", _half_space_cases)
def _signs(kernel: InfluenceKernel, bound: BoundKernel, spacing: Pair) -> None:
    if isinstance(kernel, SupportsSpectrum):
        q = np.array([[0.3 / max(spacing)]])
        none = np.zeros((1, 1))
        along = bound.shear_spectrum("xx", q, none, spacing).item()
        across = bound.shear_spectrum("xx", none, q, spacing).item()
        require(along < across, "a wave of shear across its normal displaces no more than one along it")
        for component, qx, qy in (("xy", q, q), ("zx", q, none), ("zy", none, q)):
            amplitude = bound.shear_spectrum(component, qx, qy, spacing).item()
            require(amplitude < 0.0, f"the amplitude {component} of waves towards +x and +y is not negative")
    if isinstance(kernel, SupportsCoefficients):
        square = (spacing[0], spacing[0])
        xx, yy, xy, zx, zy = (bound.shear_coefficients(name, (4, 4), square) for name in COMPONENTS)
        require(xx[3, 0] > xx[0, 3] and yy[0, 3] > yy[3, 0], "shear displaces as much beside it as ahead of it")
        require(xy[2, 2] > 0.0, "shear along +x does not displace the cells at (+, +) along +y")
        # Then pressure, with the same coefficients times -1, draws the surface of the softer body towards it.
        require(zx[3, 0] > 0.0 and zy[0, 3] > 0.0, "shear does not press the softer body in ahead of it")


@claim("kernel", "shear: coefficients agree with spectrum")
def _agree(kernel: InfluenceKernel) -> str:
    bound = _bound(kernel)
    for form, name in ((SupportsCoefficients, "coefficients"), (SupportsSpectrum, "spectrum")):
        if not isinstance(kernel, form):
            raise DoesNotApply(f"the kernel has no {name}")
    errors = [
        compare_forms(partial(bound.shear_responses, component), odd_axes(component), component)
        for component in COMPONENTS
    ]
    return f"to {max(errors):.0e}"


def _convolution_cases(convolver: Convolver) -> Iterator[tuple[str, ShearConvolution, Array]]:
    """Give convolutions of shear on each boundary, with three tractions that are read-only."""
    rng = np.random.default_rng(11)
    for boundary in sorted(set(convolver.boundaries) - {Boundary.WRAPPED}):
        for grid in GRIDS:
            for pair in PAIRS:
                tractions = rng.standard_normal((3, *grid.shape))
                tractions.flags.writeable = False
                prepared = convolver.prepare(BoundKernel(Love(), pair=pair), grid, boundary)
                try:
                    convolution = prepared.shear()
                except InputError as error:
                    raise DoesNotApply(str(error)) from error
                yield f"{grid}, {boundary}, beta {pair.beta:.2g}", convolution, tractions


@claim("convolver", "shear: sum over all cells", _convolution_cases)
def _sum(_: Convolver, convolution: ShearConvolution, tractions: Array) -> float:
    setup = convolution.setup

    def plain(component: str, traction: Array) -> Array:
        responses = setup.kernel.shear_responses(component, setup.grid, setup.boundary)
        return displace(responses, traction, setup.boundary, odd_axes(component))

    x, y, z = tractions
    normal = displace(setup.kernel.responses(setup.grid, setup.boundary), z, setup.boundary)
    expected = np.stack(
        [
            plain("xx", x) + plain("xy", y) - plain("zx", z),
            plain("xy", x) + plain("yy", y) - plain("zy", z),
            plain("zx", x) + plain("zy", y) + normal,
        ]
    )
    detail = "it differs from plain sums"
    error = require_close(convolution.apply(tractions, "xyz", "xyz"), expected, ROUNDING_ERROR, detail)
    scale = float(np.abs(expected).max())
    for of, to in (("xy", "xy"), ("z", "xy"), ("xy", "z"), ("z", "z"), ("y", "zx")):
        given = ["xyz".index(letter) for letter in of]
        wanted = ["xyz".index(letter) for letter in to]
        alone = np.zeros_like(tractions)
        alone[given] = tractions[given]
        difference = convolution.apply(tractions[given], of, to) - convolution.apply(alone, "xyz", "xyz")[wanted]
        require(np.abs(difference).max() <= ROUNDING_ERROR * scale, f"the part from {of} to {to} differs")
    return error


@claim("convolver", "shear: reciprocal, positive energy", _convolution_cases)
def _work(_: Convolver, convolution: ShearConvolution, tractions: Array) -> None:
    other = tractions[::-1, ::-1]
    displacement = convolution.apply(tractions, "xyz", "xyz")
    moved = convolution.apply(np.ascontiguousarray(other), "xyz", "xyz")
    scale = float(np.abs(displacement).max() * np.abs(tractions).sum())
    require(abs(np.vdot(tractions, moved) - np.vdot(other, displacement)) <= 1e-12 * scale, "the work is not mutual")
    require(np.vdot(tractions, displacement) >= -1e-12 * scale, "tractions have negative energy")


@claim("convolver", "shear: float32 and float64, input unchanged", _convolution_cases)
def _precision(_: Convolver, convolution: ShearConvolution, tractions: Array) -> float:
    given = np.array(tractions)
    double = convolution.apply(given, "xyz", "xyz")
    require_equal(given, tractions, "it writes into the tractions")
    require_equal(convolution.apply(given, "xyz", "xyz"), double, "a second call gives another result")
    require_equal(convolution.apply(2.0**40 * given, "xyz", "xyz"), 2.0**40 * double, "a power of two changes bits")
    single = convolution.apply(given.astype(np.float32), "xyz", "xyz")
    require(single.dtype == np.float32, f"float32 tractions give {single.dtype}")
    require(double.dtype == np.float64, f"float64 tractions give {double.dtype}")
    return require_close(single, double, 1e-5, "in float32 it differs")


@claim("convolver", "shear: own displacement and approximate inverse", _convolution_cases)
def _inverse(_: Convolver, convolution: ShearConvolution, tractions: Array) -> None:
    setup = convolution.setup
    for own, component in zip(convolution.own, ("xx", "yy"), strict=True):
        expected = setup.kernel.shear_responses(component, setup.grid, setup.boundary)[0, 0]
        require(abs(own - expected) <= ROUNDING_ERROR * expected, f"the displacement of a cell by itself is {own}")
    shear = np.ascontiguousarray(tractions[:2])
    inverse = convolution.inverse(np.float64)
    found = inverse.apply(shear)
    other = np.ascontiguousarray(shear[:, ::-1])
    scale = float(np.abs(found).max() * np.abs(shear).sum())
    require(abs(np.vdot(other, found) - np.vdot(inverse.apply(other), shear)) <= 1e-12 * scale, "it is not symmetric")
    require(np.vdot(shear, found) >= -1e-12 * scale, "the inverse is not positive")
    if setup.boundary is Boundary.PERIODIC:
        restored = inverse.apply(convolution.apply(shear))
        require_close(restored, shear - shear.mean(axis=(1, 2), keepdims=True), 1e-10, "it does not invert")
