"""Field parameters of surface texture after ISO 25178-2, with their sampling errors."""

from __future__ import annotations

import math

import attrs
import numpy as np
import scipy

from roughcontact._base.arrays import Array, Mask
from roughcontact._base.checks import flag
from roughcontact._base.units import Estimate, ShownAsPrinted
from roughcontact._parts.grid import Grid
from roughcontact.errors import InputError
from roughcontact.errors.door import guarded
from roughcontact.reference.roughness import read_heights, split_map

# Autocorrelation at which its lengths are read, and directions in which they are.
_CORRELATION = 0.2
_DIRECTIONS = 180
# Cells along a side of a quarter of a map whose autocorrelation is measured.
_MIN_QUARTER_CELLS = 8
# Material ratios of the standard: of the secant, of the core's bounds, of peak extremes.
_SECANT = 0.4
_PEAKS = 0.1
_VALLEYS = 0.8
_EXTREME = 0.025
_MIDDLE = 0.5


def _says(unit: str, meaning: str) -> dict[str, str]:
    return {"unit": unit, "meaning": meaning}


@guarded
@attrs.frozen
class Texture(ShownAsPrinted):
    """Numbers of a scale-limited surface after ISO 25178-2; heights count from their mean, outward.

    The uncertainties are sampling errors, one standard deviation: by the jackknife over 16 parts of the map, which must
    be larger than its longest waves; those of extremes are the spread of the parts, those of Sal and Str that
    of the quarters.

    Attributes
    ----------
    Sa, Sq
        Mean absolute height and root mean square height, m.
    Ssk, Sku
        Skewness and kurtosis.
    Sp, Sv, Sz
        Highest peak, deepest valley and their sum, m.
    Sal, Str
        Distance of the fastest decay of the autocorrelation to 0.2, m, and its ratio to that of the slowest; the ratio
        is not a number where the slowest decay does not end in the map.
    Std
        Direction of the lay, counter-clockwise from x, 0 to 180 degrees: perpendicular to that of the largest root mean
        square slope.
    Sdq, Sdr
        Root mean square gradient, and the developed area over the nominal one, less one.
    Sk, Spk, Svk
        Core height, reduced peak height and reduced valley depth of the material ratio curve, m.
    Smr1, Smr2
        Material ratios above and below the core.
    Vmp, Vmc, Vvc, Vvv
        Volume over area of the material of peaks (10 %) and core (10 to 80 %), and of the voids of core and valleys, m.
    Sxp
        Height between the material ratios 2.5 and 50 %, m.
    """

    Sa: Estimate = attrs.field(metadata=_says("m", "mean absolute height"))
    Sq: Estimate = attrs.field(metadata=_says("m", "root mean square height"))
    Ssk: Estimate = attrs.field(metadata=_says("", "skewness"))
    Sku: Estimate = attrs.field(metadata=_says("", "kurtosis"))
    Sp: Estimate = attrs.field(metadata=_says("m", "highest peak"))
    Sv: Estimate = attrs.field(metadata=_says("m", "deepest valley"))
    Sz: Estimate = attrs.field(metadata=_says("m", "peak to valley"))
    Sal: Estimate = attrs.field(metadata=_says("m", "autocorrelation length"))
    Str: Estimate = attrs.field(metadata=_says("", "aspect ratio of the texture"))
    Std: Estimate = attrs.field(metadata=_says("deg", "direction of the lay"))
    Sdq: Estimate = attrs.field(metadata=_says("", "root mean square gradient"))
    Sdr: Estimate = attrs.field(metadata=_says("", "developed area ratio"))
    Sk: Estimate = attrs.field(metadata=_says("m", "core height"))
    Spk: Estimate = attrs.field(metadata=_says("m", "reduced peak height"))
    Svk: Estimate = attrs.field(metadata=_says("m", "reduced valley depth"))
    Smr1: Estimate = attrs.field(metadata=_says("", "material ratio of the peaks"))
    Smr2: Estimate = attrs.field(metadata=_says("", "material ratio above the valleys"))
    Vmp: Estimate = attrs.field(metadata=_says("m", "material volume of the peaks"))
    Vmc: Estimate = attrs.field(metadata=_says("m", "material volume of the core"))
    Vvc: Estimate = attrs.field(metadata=_says("m", "void volume of the core"))
    Vvv: Estimate = attrs.field(metadata=_says("m", "void volume of the valleys"))
    Sxp: Estimate = attrs.field(metadata=_says("m", "peak extreme height"))

    def __str__(self) -> str:
        texts = {field: str(getattr(self, field.name)) for field in attrs.fields(Texture)}
        texts[attrs.fields(Texture).Std] = f"{self.Std.value:.0f} +- {self.Std.uncertainty:.0f} degrees"
        return "\n".join(f"{field.name:4} {field.metadata['meaning']:32} {text}" for field, text in texts.items())


@guarded
def texture(heights: Array, grid: Grid, *, periodic: bool = True) -> Texture:
    r"""Return the field parameters of a scale-limited surface: filter it, and subtract its form, first.

    The material ratio curve is that of the sorted heights; the core is the line of least squares through the 40 % of it
    where the secant is flattest, and reduced peak heights and valley depths are those of triangles of the same area.
    Gradients are those of the waves where the map repeats, and central differences elsewhere. The developed area is

    .. math:: \mathrm{Sdr} = \frac{1}{A} \int \left( \sqrt{1 + z_x^2 + z_y^2} - 1 \right) \mathrm{d}A

    Parameters
    ----------
    heights, grid
        Heights, shape `grid.shape`, m, outward, and their grid.
    periodic
        Whether the heights repeat beyond the border.

    Raises
    ------
    InputError
        If the heights are not finite numbers of the shape of the grid, all are equal, or an axis has one cell.

    References
    ----------
    ISO 25178-2:2021, Geometrical product specifications - Surface texture: Areal - Part 2: Terms, definitions and
    surface texture parameters

    Examples
    --------
    >>> import roughcontact as rc
    >>> grid = rc.Grid((64, 64), 64e-6)
    >>> wave = rc.WavySurface((1e-6, 0.0), 16e-6)
    >>> found = rc.reference.texture(wave.heights(grid), grid)
    >>> print(f"{1e6 * found.Sq.value:.4f} µm, lay at {found.Std.value:g} degrees")
    0.7071 µm, lay at 90 degrees
    """
    rough = read_heights(heights, grid)
    if min(grid.shape) < 2:
        raise InputError.about("The grid", grid.shape, "of at least two cells along each axis")
    repeats = flag(periodic, "periodic=")
    rough = rough - rough.mean()
    unit = float(np.abs(rough).max())
    if unit <= 16.0 * float(np.finfo(np.float64).eps) * float(np.abs(heights).max()):
        raise InputError("All heights are equal: there is no texture.")
    slopes = _find_slopes(rough, grid, repeats)
    values = _measure(rough, slopes, unit)
    spread = _find_sampling_errors(rough, slopes, unit)
    decay, warnings = _measure_decay(rough, grid, repeats)
    values |= decay
    spread |= _find_errors_of_decay(rough, grid)
    return Texture(
        **{
            one.name: Estimate(
                values[one.name], spread.get(one.name, 0.0), one.metadata["unit"], warnings.get(one.name, ())
            )
            for one in attrs.fields(Texture)
        }
    )


def _measure(heights: Array, slopes: tuple[Array, Array], unit: float) -> dict[str, float]:
    """Return all parameters that are means over places or sort them."""
    return _measure_heights(heights, unit) | _measure_slopes(*slopes)


def _find_sampling_errors(heights: Array, slopes: tuple[Array, Array], unit: float) -> dict[str, float]:
    """Return the jackknife's standard deviations, and for extremes and the direction those of the parts."""
    fields = [[part.ravel() for part in split_map(field)] for field in (heights, *slopes)]
    count = len(fields[0])
    if count < 2:
        return {}
    remaining = []
    for k in range(count):
        kept, *others = (np.concatenate(parts[:k] + parts[k + 1 :]) for parts in fields)
        remaining.append(_measure(kept, (others[0], others[1]), unit))
    errors = {
        name: math.sqrt((count - 1) * float(np.var([one[name] for one in remaining])))
        for name in remaining[0]
        if name not in ("Sp", "Sv", "Sz", "Std")
    }
    parts = [_measure(one, (x, y), unit) for one, x, y in zip(*fields, strict=True)]
    errors |= {name: float(np.std([one[name] for one in parts], ddof=1)) for name in ("Sp", "Sv", "Sz")}
    # Directions are doubled: those of 0 and 180 degrees are the same.
    length = float(np.abs(np.mean(np.exp(2j * np.radians([one["Std"] for one in remaining])))))
    scatter = math.degrees(0.5 * math.sqrt(max(-2.0 * math.log(min(length, 1.0)), 0.0))) if length > 0.0 else 90.0
    return errors | {"Std": min(math.sqrt(count - 1) * scatter, 90.0)}


def _measure_heights(heights: Array, unit: float) -> dict[str, float]:
    """Return what depends on the heights about the mean plane alone, not on their places."""
    scaled = heights / unit
    square = float(np.mean(scaled**2))
    if square == 0.0:
        return dict.fromkeys(_HEIGHT_NAMES, 0.0)
    moments = {
        "Sa": float(np.mean(np.abs(scaled))) * unit,
        "Sq": math.sqrt(square) * unit,
        "Ssk": float(np.mean(scaled**3)) / square**1.5,
        "Sku": float(np.mean(scaled**4)) / square**2,
        "Sp": float(scaled.max()) * unit,
        "Sv": -float(scaled.min()) * unit,
        "Sz": float(np.ptp(scaled)) * unit,
    }
    curve = _MaterialRatio(np.sort(scaled, axis=None)[::-1])
    return moments | {
        name: value if name in ("Smr1", "Smr2") else value * unit for name, value in curve.measure().items()
    }


class _MaterialRatio:
    """The material ratio curve: the height above which a fraction of the surface lies, linear between the heights."""

    def __init__(self, levels: Array) -> None:
        """Take the heights, the highest first."""
        self._levels = levels
        count = levels.size
        self._ratios = (np.arange(count) + 0.5) / count
        # Integral of the curve up to each end of a cell of the map.
        self._ends = np.arange(count + 1) / count
        self._integral = np.concatenate([[0.0], np.cumsum(levels)]) / count

    def height(self, ratio: float) -> float:
        """Return the height at a material ratio."""
        return float(np.interp(ratio, self._ratios, self._levels))

    def ratio(self, height: float) -> float:
        """Return the material ratio at a height."""
        return float(np.interp(-height, -self._levels, self._ratios))

    def integrate(self, low: float, high: float) -> float:
        """Return the integral of the height over material ratios."""
        first, last = np.interp((low, high), self._ends, self._integral)
        return float(last - first)

    def measure(self) -> dict[str, float]:
        """Return the parameters of the curve; heights and volumes in its unit."""
        upper, lower = self._fit_core()
        peaks = self.ratio(upper) if upper < self._levels[0] else 0.0
        valleys = self.ratio(lower) if lower > self._levels[-1] else 1.0
        above = self.integrate(0.0, peaks) - upper * peaks
        below = lower * (1.0 - valleys) - self.integrate(valleys, 1.0)
        at_peaks = self.height(_PEAKS)
        at_valleys = self.height(_VALLEYS)
        material = self.integrate(0.0, _VALLEYS) - at_valleys * _VALLEYS
        peak_material = self.integrate(0.0, _PEAKS) - at_peaks * _PEAKS
        valley_voids = at_valleys * (1.0 - _VALLEYS) - self.integrate(_VALLEYS, 1.0)
        voids = at_peaks * (1.0 - _PEAKS) - self.integrate(_PEAKS, 1.0)
        return {
            "Sk": upper - lower,
            "Spk": 2.0 * max(above, 0.0) / peaks if peaks else 0.0,
            "Svk": 2.0 * max(below, 0.0) / (1.0 - valleys) if valleys < 1.0 else 0.0,
            "Smr1": peaks,
            "Smr2": valleys,
            "Vmp": peak_material,
            "Vmc": material - peak_material,
            "Vvc": voids - valley_voids,
            "Vvv": valley_voids,
            "Sxp": self.height(_EXTREME) - self.height(_MIDDLE),
        }

    def _fit_core(self) -> tuple[float, float]:
        """Return the heights of the line through the core at the material ratios zero and one."""
        count = self._levels.size
        if count == 1:
            return float(self._levels[0]), float(self._levels[0])
        span = max(round(_SECANT * count), 1)
        drops = self._levels[: count - span] - self._levels[span:]
        # Of equal secants the middle one, of a symmetrical curve that of the centre.
        gentle = np.flatnonzero(drops <= drops.min() + 1e-12 * (self._levels[0] - self._levels[-1]))
        start = int(gentle[len(gentle) // 2])
        part = slice(start, start + span + 1)
        ratios = self._ratios[part]
        levels = self._levels[part]
        middle = float(ratios.mean())
        slope = float(np.sum((ratios - middle) * levels) / np.sum((ratios - middle) ** 2))
        upper = float(levels.mean()) - slope * middle
        return upper, upper + slope


_HEIGHT_NAMES = (
    *("Sa", "Sq", "Ssk", "Sku", "Sp", "Sv", "Sz"),
    *("Sk", "Spk", "Svk", "Smr1", "Smr2", "Vmp", "Vmc", "Vvc", "Vvv", "Sxp"),
)


def _find_slopes(heights: Array, grid: Grid, periodic: bool) -> tuple[Array, Array]:
    """Return the derivatives along x and y."""
    if not periodic:
        along_x, along_y = np.gradient(heights, *grid.spacing)
        return np.asarray(along_x), np.asarray(along_y)
    modes = scipy.fft.rfft2(heights)
    waves = [
        2j * np.pi * frequencies(n, step)
        for n, step, frequencies in zip(grid.shape, grid.spacing, (scipy.fft.fftfreq, scipy.fft.rfftfreq), strict=True)
    ]
    # A wave of two cells has no slope at the cells.
    for axis, n in enumerate(grid.shape):
        if n % 2 == 0:
            waves[axis][n // 2] = 0.0
    factors = (waves[0][:, np.newaxis], waves[1][np.newaxis])
    along_x, along_y = (scipy.fft.irfft2(modes * factor, grid.shape) for factor in factors)
    return np.asarray(along_x), np.asarray(along_y)


def _measure_slopes(along_x: Array, along_y: Array) -> dict[str, float]:
    square = along_x**2 + along_y**2
    across = 0.5 * math.atan2(2.0 * float(np.mean(along_x * along_y)), float(np.mean(along_x**2 - along_y**2)))
    return {
        "Sdq": math.sqrt(float(square.mean())),
        # Small slopes: sqrt(1 + s) - 1 loses its digits.
        "Sdr": float(np.mean(square / (1.0 + np.sqrt(1.0 + square)))),
        "Std": (math.degrees(across) + 90.0) % 180.0,
    }


def _measure_decay(heights: Array, grid: Grid, periodic: bool) -> tuple[dict[str, float], dict[str, tuple[str, ...]]]:
    """Return the lengths of the autocorrelation, and warnings."""
    lengths, reached = _find_decay(heights, grid, periodic)
    fastest = float(lengths.min())
    slowest = float(lengths.max())
    open_ends = ("the autocorrelation does not fall to 0.2 inside the map along the lay: a bound from above",)
    never = ("the autocorrelation does not fall to 0.2 inside the map: a bound from below",)
    warnings: dict[str, tuple[str, ...]] = {
        "Str": () if reached.all() else open_ends,
        "Sal": () if reached.any() else never,
    }
    return {"Sal": fastest, "Str": fastest / slowest}, warnings


def _find_errors_of_decay(heights: Array, grid: Grid) -> dict[str, float]:
    """Return the spread of the lengths of the autocorrelation over the quarters of the map.

    The mean of four would scatter half as much, but quarters miss the longest waves: over 90 surfaces of 4 to 16 such
    waves a side, the scatter of the map's lengths was 0.6 to 1 of it.
    """
    half = tuple(n // 2 for n in grid.shape)
    if min(half) < _MIN_QUARTER_CELLS:
        return {}
    quarter = Grid(half, tuple(n * step for n, step in zip(half, grid.spacing, strict=True)))
    corners = [heights[i : i + half[0], j : j + half[1]] for i in (0, half[0]) for j in (0, half[1])]
    found = [_measure_decay(corner - corner.mean(), quarter, periodic=False)[0] for corner in corners if np.ptp(corner)]
    if len(found) < 2:
        return {}
    return {name: float(np.std([one[name] for one in found], ddof=1)) for name in ("Sal", "Str")}


def _find_decay(heights: Array, grid: Grid, periodic: bool) -> tuple[Array, Mask]:
    """Return the distance at which the autocorrelation falls to 0.2 by direction, and whether it does in the map."""
    from scipy.ndimage import map_coordinates

    shape = grid.shape if periodic else tuple(scipy.fft.next_fast_len(2 * n, real=True) for n in grid.shape)
    modes = scipy.fft.rfft2(heights / np.abs(heights).max(), shape)
    correlation = scipy.fft.irfft2(modes.real**2 + modes.imag**2, shape)
    half = [n // 2 for n in grid.shape]
    rows, columns = (np.arange(-n, n + 1) for n in half)
    near = correlation[np.ix_(rows, columns)]
    if not periodic:
        near = near / ((grid.shape[0] - np.abs(rows))[:, np.newaxis] * (grid.shape[1] - np.abs(columns)))
    near = near / near[half[0], half[1]]
    angles = np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS
    directions = np.stack((np.cos(angles) / grid.spacing[0], np.sin(angles) / grid.spacing[1]))
    with np.errstate(divide="ignore"):
        longest = np.min(np.array(half)[:, np.newaxis] / np.abs(directions), axis=0)
    found = longest.copy()
    reached = np.zeros(_DIRECTIONS, dtype=bool)
    step = 0.25 * min(grid.spacing)
    for k in range(_DIRECTIONS):
        distances = np.append(np.arange(0.0, longest[k], step), longest[k])
        places = [directions[axis, k] * distances + half[axis] for axis in range(2)]
        values = map_coordinates(near, places, order=3, mode="mirror")
        below = np.flatnonzero(values <= _CORRELATION)
        if below.size:
            last = below[0]
            rise = (values[last - 1] - _CORRELATION) / (values[last - 1] - values[last])
            found[k] = distances[last - 1] + rise * (distances[last] - distances[last - 1])
            reached[k] = True
    return found, reached
