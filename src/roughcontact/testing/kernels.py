"""Claims about kernels."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from roughcontact._base.arrays import Array, Pair
from roughcontact._parts.grid import Boundary, Grid
from roughcontact._parts.kernels import (
    BoundKernel,
    InfluenceKernel,
    SupportsCoefficients,
    SupportsRows,
    SupportsSpectrum,
    knows_own_rows,
)
from roughcontact.testing.claim import (
    DoesNotApply,
    claim,
    claim_input_unchanged,
    claim_powers_of_two,
    claim_repeatable,
    require,
    require_array,
    require_close,
)
from roughcontact.testing.problems import displace

# 1/E* of the trials, 1/Pa: about the value of two steel bodies.
COMPLIANCE = 1e-11
# Shapes and sides of cells, m.
_GRIDS: tuple[tuple[tuple[int, int], Pair], ...] = (
    ((9, 7), (1e-6, 1e-6)),
    ((6, 8), (1e-6, 2.5e-6)),
    ((1, 12), (3e-7, 2e-7)),
    ((8, 1), (2e-6, 2e-6)),
)
# Relative error of scaling up to which a kernel has no length or modulus of its own: thick layers are near half-spaces.
_MAX_SCALING_ERROR = 1e-9
# Directions of waves of which moduli are compared.
_DIRECTIONS = 16


def _cases(_: InfluenceKernel) -> Iterator[tuple[str, tuple[int, int], Pair]]:
    for shape, spacing in _GRIDS:
        yield f"{shape[0]} x {shape[1]} cells", shape, spacing


def _waves(shape: tuple[int, int], spacing: Pair) -> tuple[Array, Array]:
    """Return the wave numbers of a periodic grid, shapes (nx, 1) and (1, ny), rad/m."""
    qx, qy = (np.asarray(2 * np.pi * np.fft.fftfreq(n, h), np.float64) for n, h in zip(shape, spacing, strict=True))
    return qx[:, np.newaxis], qy[np.newaxis, :]


def _waves_off_grid(shape: tuple[int, int], spacing: Pair) -> tuple[Array, Array]:
    """Return wave numbers above zero that no grid has, shapes (nx, 1) and (1, ny), rad/m."""
    qx, qy = (np.pi / step * np.linspace(0.1, 1.0, n) for n, step in zip(shape, spacing, strict=True))
    return qx[:, np.newaxis], qy[np.newaxis, :]


def _answers(
    kernel: InfluenceKernel, shape: tuple[int, int], spacing: Pair, compliance: float = COMPLIANCE
) -> list[Array]:
    """Return coefficients and spectrum, or whichever the kernel has, as it returns them."""
    found = []
    if isinstance(kernel, SupportsCoefficients):
        found.append(kernel.coefficients(shape, spacing, compliance))
    if isinstance(kernel, SupportsSpectrum):
        found.append(kernel.spectrum(*_waves(shape, spacing), spacing, compliance))
    return found


def _responses(
    kernel: InfluenceKernel, shape: tuple[int, int], spacing: Pair, compliance: float = COMPLIANCE
) -> list[Array]:
    """Return copies of coefficients and spectrum, with the mean of the spectrum, which is not used, set to zero.

    Parameters
    ----------
    kernel
        The kernel.
    shape, spacing
        Cells, and their sides, m.
    compliance
        Inverse of the contact modulus, 1/Pa.

    Returns
    -------
    list of array
        Those of the two that the kernel defines, shape `shape`: m/Pa, and m/Pa by wave number.
    """
    found = [np.array(values) for values in _answers(kernel, shape, spacing, compliance)]
    if isinstance(kernel, SupportsSpectrum) and found[-1].shape == shape:
        found[-1][0, 0] = 0.0
    return found


def _scaled_pairs(
    kernel: InfluenceKernel, shape: tuple[int, int], spacing: Pair, length: float, compliance: float
) -> Iterator[tuple[Array, Array]]:
    """Give each response with lengths and compliance scaled, and the unscaled response times both factors."""
    longer = length * spacing[0], length * spacing[1]
    others = _responses(kernel, shape, longer, compliance * COMPLIANCE)
    for other, one in zip(others, _responses(kernel, shape, spacing), strict=True):
        yield other, one * (length * compliance)


def _coefficients(kernel: InfluenceKernel) -> SupportsCoefficients:
    if not isinstance(kernel, SupportsCoefficients):
        raise DoesNotApply("the kernel has no coefficients")
    return kernel


def _spectrum(kernel: InfluenceKernel) -> SupportsSpectrum:
    if not isinstance(kernel, SupportsSpectrum):
        raise DoesNotApply("the kernel has no spectrum")
    return kernel


@claim("kernel", "coefficients or spectrum")
def _defined(kernel: InfluenceKernel) -> str:
    methods = {"coefficients": SupportsCoefficients, "spectrum": SupportsSpectrum}
    found = [name for name, kind in methods.items() if isinstance(kernel, kind)]
    require(found, "it defines neither coefficients nor a spectrum")
    return " and ".join(found)


@claim("kernel", "shapes and types", _cases)
def _shapes(kernel: InfluenceKernel, shape: tuple[int, int], spacing: Pair) -> None:
    for values in _answers(kernel, shape, spacing):
        require_array(values, shape)


@claim("kernel", "finite", _cases)
def _finite(kernel: InfluenceKernel, shape: tuple[int, int], spacing: Pair) -> None:
    for values in _responses(kernel, shape, spacing):
        require(np.isfinite(values).all(), "values that are not finite")
        require(values.max() > 0.0, "no value above zero")


def _ask_of_other_cells(kernel: InfluenceKernel, *_: object) -> None:
    _answers(kernel, (3, 4), (1e-6, 1e-6), 2 * COMPLIANCE)


claim_repeatable("kernel", _cases, _answers, _ask_of_other_cells)


def _prepare_waves(
    kernel: InfluenceKernel, shape: tuple[int, int], spacing: Pair
) -> tuple[dict[str, Array], Callable[[], Array]]:
    qx, qy = _waves(shape, spacing)
    given = {"wave numbers along x": qx, "wave numbers along y": qy}
    return given, lambda: _spectrum(kernel).spectrum(qx, qy, spacing, COMPLIANCE)


claim_input_unchanged("kernel", _cases, _prepare_waves)


@claim("kernel", "even in x and y", _cases)
def _even(kernel: InfluenceKernel, shape: tuple[int, int], spacing: Pair) -> float:
    qx, qy = _waves_off_grid(shape, spacing)
    values, *others = (
        _spectrum(kernel).spectrum(*waves, spacing, COMPLIANCE)
        for waves in ((qx, qy), (-qx, qy), (qx, -qy), (-qx, -qy))
    )
    return max(require_close(other, values, 1e-12, "waves of another sign have other amplitudes") for other in others)


@claim("kernel", "offsets and waves independent", _cases)
def _independent(kernel: InfluenceKernel, shape: tuple[int, int], spacing: Pair) -> float:
    errors = []
    detail = "the value at one offset or wave depends on the others of the same call"
    if isinstance(kernel, SupportsCoefficients):
        few = kernel.coefficients(shape, spacing, COMPLIANCE)
        more = kernel.coefficients((shape[0] + 5, shape[1] + 3), spacing, COMPLIANCE)
        errors.append(require_close(more[: shape[0], : shape[1]], few, 1e-6, detail))
    if isinstance(kernel, SupportsSpectrum):
        qx, qy = _waves_off_grid((6, 5), spacing)
        few = kernel.spectrum(qx[::2], qy[:, 1:3], spacing, COMPLIANCE)
        more = kernel.spectrum(qx, qy, spacing, COMPLIANCE)
        errors.append(require_close(more[::2, 1:3], few, 1e-6, detail))
    return max(errors)


@claim("kernel", "rows of coefficients", _cases)
def _rows(kernel: InfluenceKernel, shape: tuple[int, int], spacing: Pair) -> float:
    if not (isinstance(kernel, SupportsRows) and knows_own_rows(kernel)):
        raise DoesNotApply("the kernel has no coefficients_from of its own")
    whole = _coefficients(kernel).coefficients((shape[0] + 4, shape[1]), spacing, COMPLIANCE)
    values = kernel.coefficients_from(4, shape, spacing, COMPLIANCE)
    require_array(values, shape)
    return require_close(values, whole[4:], 1e-6, "the coefficients from a row on are not those of the whole")


@claim("kernel", "positive energy")
def _energy(kernel: InfluenceKernel) -> str:
    lowest = np.inf
    for spacing in ((1e-6, 1e-6), (1e-6, 2.5e-6)):
        if isinstance(kernel, SupportsCoefficients):
            responses = kernel.coefficients((7, 6), spacing, COMPLIANCE)
            matrix = [displace(responses, unit.reshape(7, 6), Boundary.FREE).ravel() for unit in np.eye(42)]
            energies = np.linalg.eigvalsh(np.array(matrix))
            lowest = min(lowest, float(energies[0] / energies[-1]))
        if isinstance(kernel, SupportsSpectrum):
            values = _responses(kernel, (12, 10), spacing)[-1]
            lowest = min(lowest, float(np.delete(values.ravel(), 0).min() / values.max()))
    require(lowest >= -1e-10, f"a pressure has negative energy, {lowest:.1e} of the maximum")
    return f"at least {lowest:.1e} of the maximum"


@claim("kernel", "grows with compliance")
def _grows(kernel: InfluenceKernel) -> None:
    shape, spacing = _GRIDS[0]
    softer = _responses(kernel, shape, spacing, 2 * COMPLIANCE)
    for stiff, soft in zip(_responses(kernel, shape, spacing), softer, strict=True):
        own = (0, 0) if stiff[0, 0] > 0.0 else np.unravel_index(np.argmax(stiff), shape)
        require(soft[own] >= stiff[own] * (1 - 1e-12), "half-spaces twice as compliant are displaced less")


def _half_space_cases(kernel: InfluenceKernel) -> Iterator[tuple[str, tuple[int, int], Pair]]:
    """Give the cases, if lengths and moduli scale the response."""
    for factors in ((1.7, 1.0), (1.0, 1.7)):
        for other, scaled in _scaled_pairs(kernel, *_GRIDS[1], *factors):
            if np.abs(other - scaled).max() > _MAX_SCALING_ERROR * np.abs(scaled).max():
                raise DoesNotApply("the kernel has a length or a modulus of its own")
    yield from _cases(kernel)


claim_powers_of_two(
    "kernel",
    _half_space_cases,
    _scaled_pairs,
    ((2.0**20, 1.0), (2.0**-30, 1.0), (1.0, 2.0**25), (2.0**-3, 2.0**-40)),
    "lengths times {:g} and compliances times {:g} change bits",
)


@claim("kernel", "far field of the half-space", _half_space_cases)
def _far_field(kernel: InfluenceKernel, _: tuple[int, int], spacing: Pair) -> float:
    dx, dy = spacing
    errors = []
    if isinstance(kernel, SupportsCoefficients):
        line = kernel.coefficients((2001, 1), spacing, COMPLIANCE)[-1, 0]
        errors.append(abs(float(line) * np.pi * 2000 * dx / (COMPLIANCE * dx * dy) - 1.0))
    if isinstance(kernel, SupportsSpectrum):
        q = np.array([[1e-3 / dx]])
        value = kernel.spectrum(q, 0.5 * q, spacing, COMPLIANCE).item()
        errors.append(abs(value * np.hypot(q.item(), 0.5 * q.item()) / (2.0 * COMPLIANCE) - 1.0))
    require(max(errors) <= 1e-4, f"it differs by {max(errors):.1e} from a point load on a half-space")
    return max(errors)


def compare_forms(
    respond: Callable[[Grid, Boundary], Array], odd: tuple[bool, bool] = (False, False), component: str = "zz"
) -> float:
    """Return how far displacements by coefficients and by the spectrum differ, which must be little.

    `respond` gives the response at each offset, which is odd along some axes. A traction without low moments has no far
    field, so that images do not matter.
    """
    grid = Grid((48, 48), (48e-6, 72e-6))
    traction = np.zeros(grid.shape)
    traction[22:27, 22:27] = np.outer(*[np.array([1.0, -4.0, 6.0, -4.0, 1.0])] * 2)
    free, periodic, mixed = (
        displace(respond(grid, boundary), traction, boundary, odd)
        for boundary in (Boundary.FREE, Boundary.PERIODIC, Boundary.FREE_PERIODIC)
    )
    detail = f"coefficients and spectrum of {component} differ"
    return max(require_close(other, free, 1e-6, detail) for other in (periodic, mixed))


@claim("kernel", "coefficients agree with spectrum")
def _agree(kernel: InfluenceKernel) -> str:
    _coefficients(kernel)
    _spectrum(kernel)
    return f"to {compare_forms(BoundKernel(kernel, COMPLIANCE).responses):.0e}"


@claim("kernel", "effective modulus agrees with spectrum")
def _modulus(kernel: InfluenceKernel) -> str:
    spectrum = _spectrum(kernel)
    wavenumbers = np.geomspace(1e4, 1e7, 7)
    moduli = kernel.effective_modulus(wavenumbers, COMPLIANCE)
    stated = np.full(7, 1.0 / COMPLIANCE) if moduli is None else moduli
    # The mean over the directions of a quarter turn.
    angles = 0.5 * np.pi * (np.arange(_DIRECTIONS) + 0.5) / _DIRECTIONS
    found = stated * wavenumbers * np.array([_respond(spectrum, q, angles).mean() for q in wavenumbers])
    return f"to {require_close(found, np.full(7, 2.0), 1e-4, 'E*(q) q u(q) differs from 2'):.0e}"


@claim("kernel", "directional modulus agrees with spectrum")
def _directions(kernel: InfluenceKernel) -> str:
    spectrum = _spectrum(kernel)
    angles = np.linspace(0.0, 0.5 * np.pi, _DIRECTIONS)
    wavenumber = 1e6
    waves = _respond(spectrum, wavenumber, angles)
    moduli = kernel.directional_modulus(angles, COMPLIANCE)
    # Without it all directions are alike.
    stated = np.full(_DIRECTIONS, waves.mean()) if moduli is None else 2.0 / (wavenumber * moduli)
    return f"to {require_close(waves, stated, 1e-4, 'waves of other directions differ'):.0e}"


def _respond(spectrum: SupportsSpectrum, wavenumber: float, angles: Array) -> Array:
    """Return the amplitudes of waves of these directions, on cells much smaller than they are, shape (n,)."""
    qx, qy = wavenumber * np.cos(angles), wavenumber * np.sin(angles)
    side = 1e-3 / wavenumber
    return np.diagonal(spectrum.spectrum(qx[:, np.newaxis], qy[np.newaxis, :], (side, side), COMPLIANCE))
