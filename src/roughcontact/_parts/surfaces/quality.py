"""What is to be said of a height map: its facts, and whether it shows its surface.

Signs that it does not are interpolation, steps, filled points, blur and noise.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np
import scipy

from roughcontact._base.arrays import Array, Mask
from roughcontact._base.units import WarningText, counted, percent, si
from roughcontact._parts.grid import Grid
from roughcontact._parts.surfaces.base import SampledSurface
from roughcontact._parts.surfaces.filling import smooth_over
from roughcontact._parts.surfaces.statistics import mean_in_bands, power_spectrum

# Side of the middle part that is examined, and minimum side of a map, cells: enough for each statistic.
_EXAMINED_CELLS = 256
_MIN_CELLS = 32
# Edges of bands of a third of an octave, from waves of 16 cells to those of two, rad a cell.
_BAND_EDGES = math.pi * 2.0 ** (np.arange(-9, 1) / 3.0)
# Slope of the spectrum below which a map is blurred: self-affine surfaces have -2 to -4, means over cells down to -5; a
# blur by s cells adds -2 (s q)^2. Second, the same for the few long waves, whose slopes scatter.
_BLUR_SLOPE = -5.5
_LONG_WAVE_BLUR_SLOPE = -6.5
# Drop of the spectrum within a third of an octave below which heights were computed, with a shortest wave.
_COMPUTED_DROP = 1e-5
# Slope above which there is noise: point samples of Hurst exponent 0.3 have -1.8 over the upper octave, white noise 0.
_NOISE_SLOPE = -1.0
# Rise of the slope by noise, over longer waves; aliasing raises it at most by about 1.
_NOISE_RISE = 1.3
# Slope above which there is noise even where longer waves are noise too: above those of aliased surfaces, and below
# the scatter of white noise.
_WHITE_SLOPE = -0.5
# Third differences and Laplacians below this fraction of their rms are zero: rounding.
_ZERO_FRACTION = 1e-6
# Maximum number of different third differences of stepped heights, and how evenly they are spaced, over the spacing:
# the steps are then more than a twentieth of their rms. Shapes with flats have nine at most.
_MAX_LEVELS = 200
_STEP_TOLERANCE = 0.1
_MIN_LEVELS = 9
# Difference of equal third differences, over their rms, and fraction of different ones above which heights are not
# rounded.
_LEVEL_TOLERANCE = 1e-5
_DISTINCT_FRACTION = 0.3
# Fraction of non-measured points above which a map is not examined, and above which it is not examined for noise: the
# surface through the holes has some.
_MAX_HOLE_FRACTION = 0.5
_MAX_NOISE_HOLE_FRACTION = 0.05
# Mean power of the waves shorter than two cells, over the lowest band, above which the bands below a steep fall are
# noise, which is the same everywhere: 0.7 to 2 with noise of 0.1 to 3 % of Sq, at most 0.53 on creased, clipped and
# blurred maps. Factor of the mean over the median of an exponential distribution.
_FLOOR_FRACTION = 0.65
_MEAN_OVER_MEDIAN = 1.0 / math.log(2.0)
# Rms of the second differences by noise, over the whole, above which it matters: the area is then 0.1 % too small, at
# 0.25 it is 0.5 %, at 0.5 it is 3 %.
_MIN_NOISE_FRACTION = 0.05
# Slope below which the spectrum is cut off, not blurred; set on the same maps.
_CUT_SLOPE = -13.0
_NOISE_RULE = "noise"
_MOSTLY_NOISE = "the shortest waves of the map are mostly noise"
_FILTER_NOISE = 'which makes the area too small: filter it, or ask for uncertainty="noise"'
# Minimum fraction of points that are the mean of their neighbours in a map with filled points.
_FILLED_FRACTION = 0.02
# Minimum amplitude of the periodic part of differences in interpolated maps, over their mean and the median amplitude.
_PERIODIC_AMPLITUDE = 0.1
_PEAK_OVER_MEDIAN = 12.0
# Minimum waves of a rough map, and cells for each: the differences of fewer waves are periodic without interpolation.
# Sums of 1 to 40 waves have up to 37, rough maps interpolated four times at least 57 on 160 x 160 cells, 20 on 64 x 64.
_MIN_WAVES = 40
_CELLS_PER_WAVE = 300
# Characters of the names beside the facts.
_LABEL_WIDTH = 14


def list_map_warnings(
    heights: Array, grid: Grid, non_measured: Mask | None = None, *, was_filled: bool = False
) -> tuple[str, ...]:
    """Return signs of interpolation, steps, filled points, blur or noise in heights, shape (nx, ny), m, in sentences.

    Non-measured points, shape (nx, ny), are not examined; `was_filled`: whether points are known to be filled.
    """
    part, unit = _take_middle(heights, non_measured)
    if min(part.shape) < _MIN_CELLS or float(np.ptp(part)) == 0.0:
        return ()
    cell = max(grid.resolved.spacing)
    period = _find_period(part)
    if period > 0.0:
        text = (
            f"the map looks interpolated (its differences repeat every {period:.2g} cells): use it as it was measured"
        )
        return (WarningText(text, "interpolated map", period),)
    levels = _levels(part)
    steps = np.diff(levels) / float(np.median(np.diff(levels)))
    if _MIN_LEVELS < levels.size < _MAX_LEVELS and np.abs(steps - np.rint(steps)).max() < _STEP_TOLERANCE:
        text = "the heights of the map rise in steps as large as their differences: measure with finer steps"
        return (WarningText(text, "stepped map"),)
    warnings = []
    filled = _find_filled(part)
    if levels.size <= _DISTINCT_FRACTION * part.size:
        filled[...] = False
    if filled.mean() > _FILLED_FRACTION:
        share = f"about {100.0 * float(filled.mean()):.2g} % of the points of the map"
        known = f"{share} are filled from their neighbours: where they touch, the contact is a guess"
        text = known if was_filled else f"{share} look filled in: mark them non-measured"
        warnings.append(WarningText(text, "filled points", float(filled.mean())))
    # The edges of harmonic patches look like noise.
    spectrum = _judge_spectrum(smooth_over(part, filled) if filled.any() else part, cell, unit)
    holes = filled if non_measured is None else filled | _middle(non_measured)
    return (
        *warnings,
        *(text for text in spectrum if text.rule != _NOISE_RULE or holes.mean() <= _MAX_NOISE_HOLE_FRACTION),
    )


def _middle(values: Any) -> Any:
    """Return the part that is examined."""
    return values[tuple(slice(max(0, (n - _EXAMINED_CELLS) // 2), (n + _EXAMINED_CELLS) // 2) for n in values.shape)]


def _take_middle(heights: Array, non_measured: Mask | None) -> tuple[Array, float]:
    """Return the part that is examined, smooth over non-measured points, in units of its peak-to-valley height, m.

    It is empty if more than half of its points are non-measured.
    """
    part = _middle(heights)
    holes = None if non_measured is None else _middle(non_measured)
    if holes is not None and holes.any():
        if holes.mean() > _MAX_HOLE_FRACTION:
            return np.zeros((0, 0)), 1.0
        part = smooth_over(part, holes)
    unit = float(np.ptp(part)) or 1.0
    return np.asarray(part / unit), unit


def find_period(heights: Array, non_measured: Mask | None = None) -> float:
    """Return the period of the differences between neighbouring points, cells; zero if the map is not interpolated."""
    return _find_period(_take_middle(heights, non_measured)[0])


def _find_period(part: Array) -> float:
    """Return the period of the differences in the examined part, cells; zero if there is none.

    Variances of derivatives of interpolated samples are periodic in the position between the original points:
    Gallagher, Proc. 2nd Canadian Conf. on Computer and Robot Vision (2005) 65, https://doi.org/10.1109/CRV.2005.33
    """
    if min(part.shape) < _MIN_CELLS:
        return 0.0
    for axis in (0, 1):
        values = np.moveaxis(part, axis, 0)
        for order in (2, 3, 4):
            rms = np.std(np.diff(values, order, axis=0), axis=1)
            if rms.mean() <= _ZERO_FRACTION**2:
                continue
            tone = np.abs(scipy.fft.rfft(rms / rms.mean() - 1.0)) / rms.size
            # Without the mean, and periods of more than eight cells, of which there are too few waves.
            tone[: rms.size // 8] = 0.0
            peak = int(np.argmax(tone))
            if tone[peak] > _PERIODIC_AMPLITUDE and tone[peak] > _PEAK_OVER_MEDIAN * float(
                np.median(tone[rms.size // 8 :])
            ):
                enough = min(_MIN_WAVES, part.size / _CELLS_PER_WAVE)
                return float(rms.size / peak) if _count_waves(part) >= enough else 0.0
    return 0.0


def _count_waves(part: Array) -> float:
    """Return the number of waves in the curvature of heights, by the participation ratio of its spectrum."""
    powers = (power_spectrum(np.diff(part, 2, axis=axis), steepness=2)[2] for axis in (0, 1))
    # A wave has two modes.
    return min(float(power.sum() ** 2 / (2.0 * (power**2).sum())) for power in powers)


def _levels(part: Array) -> Array:
    """Return the distinct third differences over their rms, ascending; tilt and form do not change them."""
    third = np.diff(part, 3, axis=0)
    rms = float(np.sqrt(np.mean(third**2)))
    if rms <= _ZERO_FRACTION**2:
        return np.arange(2.0)
    levels = np.sort(third, axis=None) / rms
    return np.asarray(levels[np.diff(levels, prepend=-np.inf) > _LEVEL_TOLERANCE])


def _find_filled(part: Array) -> Mask:
    """Return the mask of the points that are the mean of their neighbours, as filled ones are."""
    filled = np.zeros(part.shape, dtype=bool)
    laplacian = part[1:-1, 2:] + part[1:-1, :-2] + part[2:, 1:-1] + part[:-2, 1:-1] - 4.0 * part[1:-1, 1:-1]
    rms = float(np.sqrt(np.mean(laplacian**2)))
    filled[1:-1, 1:-1] = np.abs(laplacian) <= max(_ZERO_FRACTION * rms, _ZERO_FRACTION**3)
    return filled


def _judge_spectrum(part: Array, cell: float, unit: float) -> tuple[WarningText, ...]:
    """Return signs of blur or noise in heights over `unit`, m, with cells of `cell`, m."""
    qx, qy, power = power_spectrum(part)
    wavenumbers = np.hypot(qx, qy)
    bands = mean_in_bands(wavenumbers, power, _BAND_EDGES)
    if bands.max() * part.size < _ZERO_FRACTION**2:
        return ()
    drops = bands[1:] / bands[:-1]
    # Over two thirds of an octave.
    slopes = np.log(drops[1:] * drops[:-1]) / math.log(2.0 ** (2.0 / 3.0))
    steep = np.flatnonzero((slopes[:-1] < _LONG_WAVE_BLUR_SLOPE) & (slopes[1:] < _LONG_WAVE_BLUR_SLOPE))
    warnings = []
    if steep.size or slopes[-1] < _BLUR_SLOPE:
        first = int(steep[0]) if steep.size else slopes.size - 1
        floor = _MEAN_OVER_MEDIAN * float(np.median(power[wavenumbers > _BAND_EDGES[-1]]))
        # No instrument has less noise than seven digits leave: such smooth heights were computed.
        if drops[first:].min() < _COMPUTED_DROP or floor < _ZERO_FRACTION**3 * bands.max():
            return ()
        noisy = floor > _FLOOR_FRACTION * bands[first + 1 :].min() and _shows_in_differences(part, floor)
        # Noise ends the fall.
        if not noisy or slopes[first : first + 2].min() > _CUT_SLOPE:
            wave = 2.0 * math.pi / _BAND_EDGES[first + 1]
            text = (
                f"waves below about {si(wave * cell, 'm', 2)} ({wave:.2g} cells) are faint in the map, as after "
                "optical blur or interpolation: a finer grid cannot bring them back"
            )
            warnings.append(WarningText(text, "blurred map", wave * cell))
        if noisy:
            noise = unit * math.sqrt(floor * part.size)
            text = f"{_MOSTLY_NOISE}, of about {si(noise, 'm', 2)}, {_FILTER_NOISE}"
            return (*warnings, WarningText(text, _NOISE_RULE, noise))
    if slopes[-1] > max(_NOISE_SLOPE, min(_WHITE_SLOPE, float(np.mean(slopes[2:5])) + _NOISE_RISE)):
        warnings.append(WarningText(f"{_MOSTLY_NOISE}, {_FILTER_NOISE}", _NOISE_RULE))
    return tuple(warnings)


def _shows_in_differences(part: Array, floor: float) -> bool:
    """Return whether noise of this power of a mode makes up a part of the second differences that matters."""
    # A second difference of noise has six times its variance.
    noise = 6.0 * floor * part.size
    squares = [float(np.mean(np.diff(part, 2, axis=axis) ** 2)) for axis in (0, 1)]
    return noise > _MIN_NOISE_FRACTION**2 * min(squares)


def list_facts(sampled: SampledSurface, history: Iterable[str], warnings: Iterable[str] = ()) -> list[tuple[str, str]]:
    """Return cells, size, heights, history, non-measured points and warnings of a map, each with its name."""
    grid = sampled.grid
    heights = sampled.heights
    missing = int(np.count_nonzero(np.isnan(heights)))
    low, high, rms, dx, dy = (
        si(float(value), "m") for value in (np.nanmin(heights), np.nanmax(heights), sampled.rms_height, *grid.spacing)
    )
    facts = [
        ("grid", f"{grid}{', periodic' if sampled.periodic else ''}, cells of {dx} x {dy}"),
        ("heights", f"{low} to {high}"),
        ("Sq", f"{rms} about the mean"),
        *(("history", text) for text in history),
    ]
    if missing:
        text = f"{missing} of {counted(heights.size, 'point')} ({percent(missing / heights.size)})"
        facts.append(("non-measured", text))
    return [*facts, *(("warning", text) for text in warnings)]


def write_facts(facts: Iterable[tuple[str, str]]) -> list[str]:
    """Return facts line by line."""
    return [f"{name:<{_LABEL_WIDTH}}{text}" for name, text in facts]
