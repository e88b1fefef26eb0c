"""Checks of the kernel and the convolution: how many digits are lost."""

from __future__ import annotations

import math
import sys

import numpy as np
import scipy.fft

from roughcontact.checks import Array
from roughcontact.convolvers.spectra import periodic_spectrum, wrapped_spectrum
from roughcontact.grid import Boundary
from roughcontact.kernels import BoundKernel, OffersCoefficients, OffersSpectrum
from roughcontact.stability.examined import Examined
from roughcontact.stability.report import Check, judged, left_out
from roughcontact.stability.summation import displacement_at

# So many differences of a power of the distance vanish below rounding beyond so many cells.
_ORDER = 12
_AWAY = 128
# Cells of the grid on which both forms are compared, and how far from the loaded cell.
_CELLS = 64
_NEAR = 8
# Laplacians that make the far images vanish below rounding, and the greatest aspect at which they do.
_LAPLACIANS = 4
_ASPECT = 8.0
# Sums of plain cosines grow as the cube of the side.
_LONGEST = 1024
_SAMPLE = 16


def kernel_digits(examined: Examined) -> Check:
    """Measure the rounding of real-space coefficients: far away all that is not smooth is noise."""
    name, plan = "kernel: digits lost", examined.problem.plan
    if plan.boundary is Boundary.PERIODIC:
        return left_out(name, "the boundary is periodic: the spectrum is used, not the coefficients")
    if not isinstance(plan.kernel, OffersCoefficients):
        return left_out(name, "the kernel offers no real-space coefficients")
    kernel = BoundKernel(plan.kernel, compliance=1.0 / plan.modulus)
    noise = 0.0
    for axis, cells in enumerate(plan.grid.shape):
        count = max(cells, 2 * _AWAY)
        strip = kernel.coefficients((count, 1) if axis == 0 else (1, count), plan.grid.spacing).ravel()[_AWAY:]
        gain = math.sqrt(math.comb(2 * _ORDER, _ORDER))
        noise = max(noise, float(np.abs(np.diff(strip, _ORDER) / strip[_ORDER // 2 : -_ORDER // 2]).max()) / gain)
    found = f"noise of the coefficients beyond {_AWAY} cells, by differences of order {_ORDER}, is {noise:.1e} of them"
    return judged(name, _digits(noise), found)


def kernel_forms(examined: Examined) -> Check:
    """Compare real-space coefficients with the spectrum, after Laplacians that remove what images add."""
    name, plan = "kernel: two forms", examined.problem.plan
    for form, words in ((OffersCoefficients, "real-space coefficients"), (OffersSpectrum, "spectrum")):
        if not isinstance(plan.kernel, form):
            return left_out(name, f"the kernel offers one form only: no {words}")
    dx, dy = plan.grid.spacing
    if not 1.0 / _ASPECT <= dx / dy <= _ASPECT:
        return left_out(name, f"with cells of aspect above {_ASPECT:g} the comparison would take too large a grid")
    kernel = BoundKernel(plan.kernel, compliance=1.0 / plan.modulus)
    shape = (round(_CELLS * max(1.0, dy / dx)), round(_CELLS * max(1.0, dx / dy)))
    one, other = (
        _laplacians(scipy.fft.irfft2(spectrum(kernel, shape, plan.grid.spacing), s=shape))
        for spectrum in (wrapped_spectrum, periodic_spectrum)
    )
    difference = float(np.abs(one - other)[:_NEAR, :_NEAR].max() / np.abs(one).max())
    return judged(name, difference, "relative difference of real-space and Fourier form near the loaded cell")


def convolution_digits(examined: Examined) -> Check:
    """Compare the displacement with plain sums on some cells."""
    name, solution = "convolution: digits lost", examined.solution
    if solution.boundary is Boundary.PERIODIC and max(solution.grid.shape) > _LONGEST:
        return left_out(name, f"plain sums of waves are too much work beyond {_LONGEST} cells a side")
    if not solution.contact.any():
        return left_out(name, "nothing touches")
    cells = solution.grid.cells
    chosen = np.unique(np.append(np.linspace(0, cells - 1, _SAMPLE).astype(np.intp), solution.pressure.argmax()))
    by_sums = displacement_at(examined.problem, solution.pressure, chosen)
    size = float(np.abs(solution.displacement).max())
    off = float(np.abs(by_sums - solution.displacement.ravel()[chosen]).max()) / size if size > 0.0 else 0.0
    return judged(name, _digits(off), f"on {chosen.size} cells the displacement is within {off:.1e} of plain sums")


def _digits(error: float) -> float:
    """Return the decimal digits that an error takes from float64."""
    return max(0.0, math.log10(error / sys.float_info.epsilon)) if error > 0.0 else 0.0


def _laplacians(values: Array) -> Array:
    for _ in range(_LAPLACIANS):
        around = sum(np.roll(values, shift, axis) for axis in (0, 1) for shift in (-1, 1))
        values = values - 0.25 * around
    return values
