"""Claims about kernels."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from roughcontact.checks import Array, Pair
from roughcontact.kernels import InfluenceKernel
from roughcontact.kernels.base import OffersCoefficients, OffersSpectrum
from roughcontact.testing.claim import Claim, DoesNotApply, require
from roughcontact.testing.common import common
from roughcontact.testing.dense import FREE, offset_matrix

COMPLIANCE = 1e-11
_CELLS: tuple[tuple[tuple[int, int], Pair], ...] = (
    ((9, 7), (1e-6, 1e-6)),
    ((6, 8), (1e-6, 2.5e-6)),
    ((1, 12), (3e-7, 2e-7)),
    ((8, 1), (2e-6, 2e-6)),
)
# Thick layers are nearly half-spaces: what scales to this share has no length or modulus of its own.
_ALIKE = 1e-9


def _coefficients(kernel: InfluenceKernel) -> OffersCoefficients:
    if not isinstance(kernel, OffersCoefficients):
        raise DoesNotApply("it offers no coefficients")
    return kernel


def _spectrum(kernel: InfluenceKernel) -> OffersSpectrum:
    if not isinstance(kernel, OffersSpectrum):
        raise DoesNotApply("it offers no spectrum")
    return kernel


def waves(shape: tuple[int, int], spacing: Pair) -> tuple[Array, Array]:
    """Return the wave numbers of a periodic grid of these cells, shapes (nx, 1) and (1, ny), rad/m."""
    qx, qy = (np.asarray(2 * np.pi * np.fft.fftfreq(n, h), np.float64) for n, h in zip(shape, spacing, strict=True))
    return qx[:, np.newaxis], qy[np.newaxis, :]


def _response(kernel: InfluenceKernel, shape: tuple[int, int], spacing: Pair, compliance: float) -> Iterator[Array]:
    """Give all that the kernel offers, spectra without their mean."""
    if isinstance(kernel, OffersCoefficients):
        yield np.array(kernel.coefficients(shape, spacing, compliance))
    if isinstance(kernel, OffersSpectrum):
        qx, qy = waves(shape, spacing)
        with np.errstate(divide="ignore", invalid="ignore"):
            values = np.array(kernel.spectrum(qx, qy, spacing, compliance))
        if values.shape == (qx.size, qy.size):
            values[0, 0] = 0.0
        yield values


def _offers(kernel: InfluenceKernel) -> str:
    found = [
        name
        for name, kind in (("coefficients", OffersCoefficients), ("spectrum", OffersSpectrum))
        if isinstance(kernel, kind)
    ]
    require(found, "it offers neither coefficients nor a spectrum")
    return " and ".join(found)


def _shapes(kernel: InfluenceKernel) -> str:
    for shape, spacing in _CELLS:
        for values in _response(kernel, shape, spacing, COMPLIANCE):
            require(values.shape == shape, f"an array of shape {values.shape} where {shape} was asked for")
            require(values.dtype == np.float64, f"numbers of type {values.dtype} where float64 is needed")
    return "float64 arrays of the shape that was asked for"


def _finite(kernel: InfluenceKernel) -> str:
    for shape, spacing in _CELLS:
        for values in _response(kernel, shape, spacing, COMPLIANCE):
            require(np.isfinite(values).all(), f"values that are not finite on {shape} cells")
            require(values.max() > 0.0, f"nothing above zero on {shape} cells")
    return "finite everywhere but at the mean, which is not used"


def _repeatable(kernel: InfluenceKernel) -> str:
    shape, spacing = _CELLS[1]
    first = _own_arrays(kernel, shape, spacing)
    kept = [values.copy() for values in first]
    # What a caller does with the arrays must not reach the kernel's own memory.
    for values in first:
        if values.flags.writeable:
            values[...] = 7.0
    list(_response(kernel, (3, 4), (1e-6, 1e-6), 2 * COMPLIANCE))
    for values, before in zip(_own_arrays(kernel, shape, spacing), kept, strict=True):
        require(np.array_equal(values, before, equal_nan=True), "asked again, it answers differently")
    return "the same bits, asked again"


def _own_arrays(kernel: InfluenceKernel, shape: tuple[int, int], spacing: Pair) -> list[Array]:
    found = []
    if isinstance(kernel, OffersCoefficients):
        found.append(kernel.coefficients(shape, spacing, COMPLIANCE))
    if isinstance(kernel, OffersSpectrum):
        with np.errstate(divide="ignore", invalid="ignore"):
            found.append(kernel.spectrum(*waves(shape, spacing), spacing, COMPLIANCE))
    return found


def _untouched(kernel: InfluenceKernel) -> str:
    offered = _spectrum(kernel)
    for shape, spacing in _CELLS:
        given = waves(shape, spacing)
        kept = [q.copy() for q in given]
        with np.errstate(divide="ignore", invalid="ignore"):
            offered.spectrum(*given, spacing, COMPLIANCE)
        require(all(map(np.array_equal, given, kept)), "it changed the wave numbers that it was given")
    return "the wave numbers are left as they were"


def _even(kernel: InfluenceKernel) -> str:
    offered, worst = _spectrum(kernel), 0.0
    for shape, spacing in _CELLS:
        qx, qy = (np.pi / step * np.linspace(0.1, 1.0, n) for n, step in zip(shape, spacing, strict=True))
        qx, qy = qx[:, np.newaxis], qy[np.newaxis, :]
        values = offered.spectrum(qx, qy, spacing, COMPLIANCE)
        for mirrored in ((-qx, qy), (qx, -qy), (-qx, -qy)):
            off = np.abs(offered.spectrum(*mirrored, spacing, COMPLIANCE) - values).max() / np.abs(values).max()
            worst = max(worst, float(off))
    require(worst <= 1e-12, f"waves that differ in sign only get answers that differ by {worst:.1e}")
    return f"even in x and y to {worst:.0e}"


def _each_alone(kernel: InfluenceKernel) -> str:
    worst = 0.0
    for shape, spacing in _CELLS:
        if isinstance(kernel, OffersCoefficients):
            few = kernel.coefficients(shape, spacing, COMPLIANCE)
            more = kernel.coefficients((shape[0] + 5, shape[1] + 3), spacing, COMPLIANCE)
            worst = max(worst, float(np.abs(more[: shape[0], : shape[1]] - few).max() / np.abs(few).max()))
        if isinstance(kernel, OffersSpectrum):
            qx, qy = (np.pi / step * np.linspace(0.1, 1.0, n) for n, step in zip((6, 5), spacing, strict=True))
            qx, qy = qx[:, np.newaxis], qy[np.newaxis, :]
            all_waves = kernel.spectrum(qx, qy, spacing, COMPLIANCE)
            some = kernel.spectrum(qx[::2], qy[:, 1:3], spacing, COMPLIANCE)
            worst = max(worst, float(np.abs(all_waves[::2, 1:3] - some).max() / np.abs(all_waves).max()))
    require(worst <= 1e-6, f"one offset or wave gets answers that differ by {worst:.1e} with what else is asked for")
    return f"an offset or wave gets one answer, to {worst:.0e}"


def _energy(kernel: InfluenceKernel) -> str:
    lowest = np.inf
    for spacing in ((1e-6, 1e-6), (1e-6, 2.5e-6)):
        if isinstance(kernel, OffersCoefficients):
            matrix = offset_matrix(kernel.coefficients((7, 6), spacing, COMPLIANCE), FREE)
            energies = np.linalg.eigvalsh(matrix)
            lowest = min(lowest, float(energies[0] / energies[-1]))
        if isinstance(kernel, OffersSpectrum):
            *_, values = _response(kernel, (12, 10), spacing, COMPLIANCE)
            lowest = min(lowest, float(np.delete(values.ravel(), 0).min() / values.max()))
    require(lowest >= -1e-10, f"a pressure does negative work, {lowest:.1e} of the greatest")
    return f"every pressure does positive work; the least is {lowest:.1e} of the greatest"


def _softer(kernel: InfluenceKernel) -> str:
    shape, spacing = _CELLS[0]
    for stiff, soft in zip(
        _response(kernel, shape, spacing, COMPLIANCE), _response(kernel, shape, spacing, 2 * COMPLIANCE), strict=True
    ):
        own = (0, 0) if stiff[0, 0] > 0.0 else np.unravel_index(np.argmax(stiff), shape)
        require(soft[own] >= stiff[own] * (1 - 1e-12), "on half-spaces twice as compliant it gives less displacement")
    return "softer half-spaces give no less displacement"


def _is_half_space(kernel: InfluenceKernel) -> bool:
    """Tell whether lengths and moduli scale the response, so that it has none of its own."""
    shape, (dx, dy) = _CELLS[1]
    for factor, compliance in ((1.7, 1.0), (1.0, 1.7)):
        for one, other in zip(
            _response(kernel, shape, (dx, dy), COMPLIANCE),
            _response(kernel, shape, (factor * dx, factor * dy), compliance * COMPLIANCE),
            strict=True,
        ):
            scaled = one * factor * compliance
            if np.abs(other - scaled).max() > _ALIKE * np.abs(scaled).max():
                return False
    return True


def _scales(kernel: InfluenceKernel) -> str:
    if not _is_half_space(kernel):
        raise DoesNotApply("the kernel has a length or a modulus of its own")
    for shape, (dx, dy) in _CELLS:
        for length, compliance in ((2.0**20, 1.0), (2.0**-30, 1.0), (1.0, 2.0**25), (2.0**-3, 2.0**-40)):
            for one, other in zip(
                _response(kernel, shape, (dx, dy), COMPLIANCE),
                _response(kernel, shape, (length * dx, length * dy), compliance * COMPLIANCE),
                strict=True,
            ):
                same = np.array_equal(one * (length * compliance), other)
                require(same, f"with lengths times {length:g} and compliances times {compliance:g} bits change")
    return "lengths and compliances times powers of two change no bit"


def _far(kernel: InfluenceKernel) -> str:
    if not _is_half_space(kernel):
        raise DoesNotApply("the kernel has a length or a modulus of its own")
    worst = 0.0
    dx, dy = 1e-6, 1.5e-6
    if isinstance(kernel, OffersCoefficients):
        line = kernel.coefficients((2001, 1), (dx, dy), COMPLIANCE)[-1, 0]
        worst = max(worst, abs(float(line) * np.pi * 2000 * dx / (COMPLIANCE * dx * dy) - 1.0))
    if isinstance(kernel, OffersSpectrum):
        q = np.array([[1e-3 / dx]])
        value = kernel.spectrum(q, 0.5 * q, (dx, dy), COMPLIANCE).item()
        worst = max(worst, abs(value * np.hypot(q.item(), 0.5 * q.item()) / (2.0 * COMPLIANCE) - 1.0))
    require(worst <= 1e-4, f"far away it is off by {worst:.1e} from a point load on a half-space")
    return f"far away a point load on a half-space, to {worst:.0e}"


def _agree(kernel: InfluenceKernel) -> str:
    # A pressure without low moments has no far field, so that images do not matter.
    table, amplitudes = _coefficients(kernel), _spectrum(kernel)
    n, spacing = 48, (1e-6, 1.5e-6)
    stencil = np.outer(*[np.array([1.0, -4.0, 6.0, -4.0, 1.0])] * 2)
    pressure = np.zeros((n, n))
    pressure[n // 2 - 2 : n // 2 + 3, n // 2 - 2 : n // 2 + 3] = stencil
    with np.errstate(divide="ignore", invalid="ignore"):
        symbol = np.array(amplitudes.spectrum(*waves((n, n), spacing), spacing, COMPLIANCE))
    symbol[0, 0] = 0.0
    periodic = np.fft.ifft2(symbol * np.fft.fft2(pressure)).real
    coefficients = table.coefficients((n, n), spacing, COMPLIANCE)
    free = np.zeros((n, n))
    here = np.arange(n)
    for i, j in zip(*np.nonzero(pressure), strict=True):
        free += pressure[i, j] * coefficients[np.abs(here - i)[:, np.newaxis], np.abs(here - j)]
    off = float(np.abs(free - periodic).max() / np.abs(free).max())
    require(off <= 1e-6, f"a pressure without far field moves the surface by {off:.1e} otherwise in Fourier space")
    return f"coefficients and spectrum are one response, to {off:.0e}"


CLAIMS = (
    Claim("kernel", "offers coefficients or a spectrum", _offers),
    Claim("kernel", "shapes and types", _shapes),
    Claim("kernel", "finite", _finite),
    Claim("kernel", "repeatable", _repeatable),
    Claim("kernel", "input left as it was", _untouched),
    Claim("kernel", "even in x and y", _even),
    Claim("kernel", "each offset and wave alone", _each_alone),
    Claim("kernel", "positive work", _energy),
    Claim("kernel", "softer bodies yield more", _softer),
    Claim("kernel", "units", _scales),
    Claim("kernel", "far field of the half-space", _far),
    Claim("kernel", "coefficients agree with the spectrum", _agree),
    *common("kernel"),
)
