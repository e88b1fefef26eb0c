"""Checks of the kernel and the convolution: how many digits are lost."""

from __future__ import annotations

import math
import sys

import numpy as np
import scipy.fft

from roughcontact._base.checks import Array, IntArray
from roughcontact._parts.grid import Boundary
from roughcontact._parts.kernels import BoundKernel, SupportsCoefficients, SupportsSpectrum
from roughcontact._solve.convolvers import periodic_spectrum, wrapped_spectrum
from roughcontact._solve.problem import ContactProblem, SolvePlan
from roughcontact._work.reports.stability.check import Check, SolvedProblem, assess, skip

# Differences of order n of 1/r are n!/r^n of it: 2e-17 for n = 12 beyond 128 cells, below float64's rounding.
_ORDER = 12
_FAR = 128
# Grid on which both forms are compared, cells a side, and the distance from the loaded cell, cells, within which.
_CELLS = 64
_NEAR = 8
# Laplacians after which Love's kernel and its images differ by 3e-15 there, for cells of any aspect.
_LAPLACIANS = 4
# Aspect of the cells up to which that grid is square in metres and still small (8 x 64 by 64 cells).
_MAX_ASPECT = 8.0
# Cells a side up to which sums of cosines, whose work grows as the cube of the side, take less than a second.
_MAX_SIDE = 1024
# Cells at which the displacement is compared; the cell of maximum pressure is added.
_SAMPLE = 16


def sum_displacement(problem: ContactProblem, pressure: Array, chosen: IntArray) -> Array:
    """Return the displacement at the cells of flat index `chosen`, m, by plain sums instead of transforms."""
    plan = problem.plan
    table = _bind(plan).responses(plan.grid, plan.boundary)
    sums = []
    for cell in zip(*np.divmod(chosen, pressure.shape[1]), strict=True):
        i, j = (np.abs(np.arange(n) - here) for n, here in zip(pressure.shape, cell, strict=True))
        if plan.boundary is Boundary.WRAPPED:
            i, j = (np.minimum(offsets, offsets.size - offsets) for offsets in (i, j))
        sums.append(float(np.einsum("ij,ij->", table[np.ix_(i, j)], pressure)))
    return np.array(sums)


def check_kernel(solved: SolvedProblem) -> list[Check]:
    """Return the digits that convolution and kernel lose, and whether the two forms of the kernel agree."""
    plan = solved.problem.plan
    return [_check_convolution(solved), _check_coefficients(plan), _check_forms(plan)]


def _check_convolution(solved: SolvedProblem) -> Check:
    """Return the digits that the displacement loses against plain sums."""
    name = "convolution: digits lost"
    solution = solved.solution
    if solution.boundary is Boundary.PERIODIC and max(solution.grid.shape) > _MAX_SIDE:
        return skip(name, f"plain sums of waves take too long beyond {_MAX_SIDE} cells a side")
    if not solution.contact.any():
        return skip(name, "there is no contact")
    evenly = np.linspace(0, solution.grid.cells - 1, _SAMPLE).astype(np.intp)
    chosen = np.unique(np.append(evenly, solution.pressure.argmax()))
    by_sums = sum_displacement(solved.problem, solution.pressure, chosen)
    largest = float(np.abs(solution.displacement).max())
    error = float(np.abs(by_sums - solution.displacement.ravel()[chosen]).max()) / largest if largest > 0.0 else 0.0
    finding = f"displacement at {chosen.size} cells against plain sums: relative difference {error:.1e}"
    return assess(name, _count_digits(error), finding)


def _check_coefficients(plan: SolvePlan) -> Check:
    """Return the digits that the real-space coefficients lose: far away, what is not smooth is rounding."""
    name = "kernel: digits lost"
    if plan.boundary is Boundary.PERIODIC:
        return skip(name, "the boundary is periodic: the spectrum is used, not the coefficients")
    if not isinstance(plan.kernel, SupportsCoefficients):
        return skip(name, "the kernel has no real-space coefficients")
    kernel = _bind(plan)
    noise = 0.0
    for axis, cells in enumerate(plan.grid.shape):
        count = max(cells, 2 * _FAR)
        strip = kernel.coefficients((count, 1) if axis == 0 else (1, count), plan.grid.spacing).ravel()[_FAR:]
        gain = math.sqrt(math.comb(2 * _ORDER, _ORDER))
        noise = max(noise, float(np.abs(np.diff(strip, _ORDER) / strip[_ORDER // 2 : -_ORDER // 2]).max()) / gain)
    finding = f"relative noise of the coefficients beyond {_FAR} cells is {noise:.1e}, by differences of order {_ORDER}"
    return assess(name, _count_digits(noise), finding)


def _check_forms(plan: SolvePlan) -> Check:
    """Return the difference of real-space coefficients and spectrum, after Laplacians that remove the images."""
    name = "kernel: two forms"
    for form, words in ((SupportsCoefficients, "real-space coefficients"), (SupportsSpectrum, "spectrum")):
        if not isinstance(plan.kernel, form):
            return skip(name, f"the kernel has one form only: no {words}")
    dx, dy = plan.grid.spacing
    if not 1.0 / _MAX_ASPECT <= dx / dy <= _MAX_ASPECT:
        return skip(name, f"for cells of aspect above {_MAX_ASPECT:g} the comparison would need too large a grid")
    kernel = _bind(plan)
    shape = (round(_CELLS * max(1.0, dy / dx)), round(_CELLS * max(1.0, dx / dy)))
    one, other = (
        _apply_laplacians(scipy.fft.irfft2(spectrum(kernel, shape, plan.grid.spacing), s=shape))
        for spectrum in (wrapped_spectrum, periodic_spectrum)
    )
    difference = float(np.abs(one - other)[:_NEAR, :_NEAR].max() / np.abs(one).max())
    return assess(name, difference, "relative difference of coefficients and spectrum near the loaded cell")


def _bind(plan: SolvePlan) -> BoundKernel:
    return BoundKernel(plan.kernel, compliance=1.0 / plan.modulus)


def _count_digits(error: float) -> float:
    """Return the decimal digits of float64 that a relative error costs."""
    return max(0.0, math.log10(error / sys.float_info.epsilon)) if error > 0.0 else 0.0


def _apply_laplacians(values: Array) -> Array:
    for _ in range(_LAPLACIANS):
        around = sum(np.roll(values, shift, axis) for axis in (0, 1) for shift in (-1, 1))
        values = values - 0.25 * around
    return values
