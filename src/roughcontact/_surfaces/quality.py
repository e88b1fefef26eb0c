"""Whether a measured height map shows its surface: interpolation, steps, filled points, blur and noise."""

from __future__ import annotations

import math

import numpy as np
import scipy.fft

from roughcontact._surfaces.spectrum import mean_in_bands, power_spectrum
from roughcontact.checks import Array
from roughcontact.grid import Grid
from roughcontact.units import si

# Sides of the part in the middle that is examined, and of the smallest map that is, cells: for each statistic enough.
_PART, _SMALLEST = 256, 32
# Edges of bands of a third of an octave, from waves of 16 cells to those of two, rad a cell.
_EDGES = math.pi * 2.0 ** (np.arange(-9, 1) / 3.0)
# Self-affine surfaces have slopes of -2 to -4, from means over cells to -5; a blur by s cells adds -2 (s q)^2. Long
# waves are few, so that their slopes scatter.
_BLURRED, _SCATTERED = -5.5, -6.5
# A spectrum that drops by this factor within a third of an octave was computed, with a shortest wave.
_COMPUTED = 1e-5
# Point samples of a surface of Hurst exponent 0.3 have -1.8 over the upper octave, white noise 0.
_WHITE = -1.0
# Noise raises the slope by more than this over that of the longer waves; aliasing at most by about 1.
_RISE = 1.3
# Third differences and Laplacians below this fraction of their rms are zero: rounding.
_ZERO = 1e-6
# Fewer different third differences, evenly spaced within this fraction, mean steps of more than a twentieth of their
# rms; shapes with flats have nine at most.
_FEW, _EVEN, _FEWEST = 200, 0.1, 9
# Third differences that agree within this fraction of their rms are equal, and the fraction of different ones above
# which heights are not rounded.
_LEVEL, _DISTINCT = 1e-5, 0.3
# Fraction of points that are the mean of their neighbours above which they are filled in.
_FILLED = 0.02
# Amplitude of a periodic part of the differences in interpolated maps, over their mean and over the median amplitude.
_PERIODIC, _PEAK = 0.1, 12.0
_ADVICE = "a finer grid adds no heights (rc.beyond_resolution gives the range of areas)"


def list_map_warnings(heights: Array, grid: Grid) -> tuple[str, ...]:
    """Return in which respects heights, shape (nx, ny), m, are not those of a measured surface, in sentences."""
    part = _take_middle(heights)
    if min(part.shape) < _SMALLEST or float(np.ptp(part)) == 0.0:
        return ()
    cell = max(grid.spacing)
    period = find_period(heights)
    if period > 0.0:
        return (
            f"the map looks interpolated (its differences repeat every {period:.2g} cells): use it as it was measured",
        )
    levels = _levels(part)
    steps = np.diff(levels) / float(np.median(np.diff(levels)))
    if _FEWEST < levels.size < _FEW and np.abs(steps - np.rint(steps)).max() < _EVEN:
        return ("the heights of the map rise in steps as large as their differences: measure with finer steps",)
    warnings = []
    filled = _filled_fraction(part)
    if levels.size > _DISTINCT * part.size and filled > _FILLED:
        warnings.append(f"about {100.0 * filled:.2g} % of the points of the map look filled in: mark them non-measured")
    return (*warnings, *_judge_spectrum(part, cell))


def _take_middle(heights: Array) -> Array:
    part = heights[tuple(slice(max(0, (n - _PART) // 2), (n + _PART) // 2) for n in heights.shape)]
    return np.asarray(part / (float(np.ptp(part)) or 1.0))


def find_period(heights: Array) -> float:
    """Return the period of the differences between neighbouring points, cells; zero if the map is not interpolated.

    Variances of derivatives of interpolated samples are periodic in the position between the original points:
    Gallagher, Proc. 2nd Canadian Conf. on Computer and Robot Vision (2005) 65, https://doi.org/10.1109/CRV.2005.33
    """
    part = _take_middle(heights)
    if min(part.shape) < _SMALLEST:
        return 0.0
    for axis in (0, 1):
        values = np.moveaxis(part, axis, 0)
        for order in (2, 3, 4):
            rms = np.std(np.diff(values, order, axis=0), axis=1)
            if rms.mean() <= _ZERO**2:
                continue
            tone = np.abs(scipy.fft.rfft(rms / rms.mean() - 1.0)) / rms.size
            # Originals of more than eight cells, and the constant part, are too few waves.
            tone[: rms.size // 8] = 0.0
            peak = int(np.argmax(tone))
            if tone[peak] > _PERIODIC and tone[peak] > _PEAK * float(np.median(tone[rms.size // 8 :])):
                return float(rms.size / peak)
    return 0.0


def _levels(part: Array) -> Array:
    """Return the different third differences, which tilt and form do not change, over their rms, ascending."""
    third = np.diff(part, 3, axis=0)
    rms = float(np.sqrt(np.mean(third**2)))
    if rms <= _ZERO**2:
        return np.arange(2.0)
    levels = np.sort(third, axis=None) / rms
    return np.asarray(levels[np.diff(levels, prepend=-np.inf) > _LEVEL])


def _filled_fraction(part: Array) -> float:
    """Return the fraction of points that are the mean of their neighbours, as harmonic ones are."""
    laplacian = part[1:-1, 2:] + part[1:-1, :-2] + part[2:, 1:-1] + part[:-2, 1:-1] - 4.0 * part[1:-1, 1:-1]
    rms = float(np.sqrt(np.mean(laplacian**2)))
    return float(np.mean(np.abs(laplacian) <= _ZERO * rms)) if rms > _ZERO**2 else 1.0


def _judge_spectrum(part: Array, cell: float) -> tuple[str, ...]:
    qx, qy, power = power_spectrum(part)
    bands = mean_in_bands(np.hypot(qx, qy), power, _EDGES)
    if bands.max() * part.size < _ZERO**2:
        return ()
    drops = bands[1:] / bands[:-1]
    # Over two thirds of an octave.
    slopes = np.log(drops[1:] * drops[:-1]) / math.log(2.0 ** (2.0 / 3.0))
    steep = np.flatnonzero((slopes[:-1] < _SCATTERED) & (slopes[1:] < _SCATTERED))
    warnings = []
    if steep.size or slopes[-1] < _BLURRED:
        first = int(steep[0]) if steep.size else slopes.size - 1
        if drops[first:].min() < _COMPUTED:
            return ()
        wave = 2.0 * math.pi / _EDGES[first + 1]
        warnings.append(
            f"waves below about {si(wave * cell, 'm', 2)} ({wave:.2g} cells) are faint in the map, as after optical "
            f"blur or interpolation: {_ADVICE}"
        )
    if slopes[-1] > max(_WHITE, min(0.0, float(np.mean(slopes[2:5])) + _RISE)):
        warnings.append("the shortest waves of the map are mostly noise, which makes the area too small: filter it")
    return tuple(warnings)
