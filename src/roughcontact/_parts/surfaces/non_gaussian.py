"""Random surfaces of a given spectrum whose heights are not normally distributed."""

from __future__ import annotations

import functools
import math
from typing import Any, TypeAlias

import attrs
import numpy as np
import scipy

from roughcontact._base.arrays import Array, Pair
from roughcontact._base.checks import number, numbers
from roughcontact._base.machine import require_memory
from roughcontact._base.units import Quantity
from roughcontact._parts.grid import Grid
from roughcontact._parts.surfaces.resampling import fourier
from roughcontact._parts.surfaces.synthetic import SelfAffineSurface, SpectralSurface
from roughcontact.errors import InputError

# Levels and fractions of a bearing curve.
Bearing: TypeAlias = tuple[tuple[float, ...], tuple[float, ...]]

# Cells on the shortest wave of the grid on which the phases are found: the fourth moments of its heights are exact.
_CELLS_PER_WAVE = 4.0
# Rounds of the transform, how often at most the wanted moments are then corrected by what was reached, the rounds
# between, and the error of the moments that needs no correction.
_ROUNDS = 60
_MAX_CORRECTIONS = 12
_ROUNDS_BETWEEN = 15
_CLOSE_MOMENTS = 0.002
# Maximum error of skewness and kurtosis, and the kurtosis from which that of both grows in proportion.
_MAX_MOMENT_ERROR = 0.01
_USUAL_KURTOSIS = 10.0
# Points of the Gauss-Hermite quadrature of moments, and accuracy of the parameters that give them.
_QUADRATURE_POINTS = 120
_MOMENT_TOLERANCE = 1e-6
# Parameters from which those of given moments are sought: skew, and logarithm of the tail.
_STARTS = ((0.0, 0.0), (0.5, -0.3), (0.4, -0.6), (1.0, 0.0), (1.5, 0.3), (0.1, -0.8))
# Kurtosis by default: 3 + 1.5 skewness^2, that of a gamma distribution.
_GAMMA_EXCESS = 1.5
# Peak memory in float64 arrays of the grid of the phases; measured.
_ARRAYS_IN_MEMORY = 12.0


def _skewness(value: Quantity) -> float:
    return number(value, "The skewness")


def _kurtosis(value: Quantity | None) -> float | None:
    return None if value is None else number(value, "The kurtosis", above=1.0)


def _bearing(value: Any) -> Bearing | None:
    """Return levels and fractions of a bearing curve by descending level, or raise `InputError`."""
    if value is None:
        return None
    what = "The bearing curve"
    allowed = (
        "a pair of lists, levels (m) and the fractions of the surface above them, as (curve.levels, curve.fractions)"
    )
    is_list = isinstance(value, (tuple, list)) or (isinstance(value, np.ndarray) and value.ndim > 0)
    is_pair = is_list and len(value) == 2
    lists = [numbers(value[0], what, allowed, "m"), numbers(value[1], what, allowed)] if is_pair else []
    if not lists or any(one.ndim != 1 or one.size < 2 or not np.isfinite(one).all() for one in lists):
        raise InputError.about(what, value, allowed)
    if lists[0].size != lists[1].size:
        raise InputError(f"{what} has {lists[0].size} levels, but {lists[1].size} fractions.")
    order = np.argsort(lists[0], kind="stable")[::-1]
    levels, fractions = (one[order] for one in lists)
    if levels[0] == levels[-1] or fractions[0] == fractions[-1]:
        raise InputError(f"{what} must have more than one level and more than one fraction.")
    if fractions.min() < 0.0 or fractions.max() > 1.0 or (np.diff(fractions) < 0.0).any():
        raise InputError(f"{what} must have fractions from 0 to 1 that grow as the level falls.")
    return tuple(levels.tolist()), tuple(fractions.tolist())


def _outline(bearing: Bearing | None) -> str:
    return "None" if bearing is None else f"<{len(bearing[0])} levels>"


@attrs.frozen(kw_only=True)
class NonGaussianSurface(SpectralSurface):
    r"""Periodic roughness with a self-affine power spectrum and a given skewness and kurtosis, or bearing curve.

    Honed, lapped and worn surfaces have plateaus and valleys, a skewness below zero. The spectrum is that of the
    `SelfAffineSurface` of the same seed; its phases are changed in turn so that the heights are distributed as wanted
    and the amplitudes are as they were (IAAFT), and the last step is that of the amplitudes: no wave is outside the
    band, and rms height and slope are exact. Skewness and kurtosis are then within 0.01. Valleys are pits in random
    places: long grooves, as of honing, have phases of their own.

    Parameters
    ----------
    hurst
        Hurst exponent, 0 to 1.
    shortest, longest
        Shortest and longest wavelength, across the lay if there is one, m.
    rms_height
        Root mean square of the height, m; exactly one of this and the slope, or none with a bearing curve whose rms
        height is taken.
    rms_slope
        Root mean square of the gradient's magnitude.
    rolloff
        Wavelength of the roll-off, across the lay, m; by default the longest wavelength.
    peklenik
        Ratio of the lengths along the lay to those across it, at least 1 (isotropic).
    lay
        Direction of the lay, counter-clockwise from the x axis, rad.
    seed
        Seed of the random numbers.
    skewness
        Skewness Ssk of the heights.
    kurtosis
        Kurtosis Sku of the heights; by default 3 + 1.5 Ssk^2.
    bearing
        Levels, m, and the fractions of the surface above them, in place of skewness and kurtosis, as of
        `roughcontact.reference.bearing_area`: ``(curve.levels, curve.fractions)``.

    Raises
    ------
    InputError
        If the kurtosis is too small for the skewness.

    References
    ----------
    Schreiber, Schmitz, Phys. Rev. Lett. 77 (1996) 635-638, https://doi.org/10.1103/PhysRevLett.77.635

    Jones, Pewsey, Biometrika 96 (2009) 761-780, https://doi.org/10.1093/biomet/asp053 (the distribution of heights)

    Examples
    --------
    >>> import roughcontact as rc
    >>> worn = rc.NonGaussianSurface(hurst=0.8, rms_height=1e-6, shortest=4e-6, longest=32e-6, skewness=-1, kurtosis=5)
    >>> grid = rc.Grid((64, 64), 64e-6)
    >>> found = rc.reference.texture(worn.heights(grid), grid)
    >>> print(f"Ssk {found.Ssk.value:.2f}, Sku {found.Sku.value:.2f}")
    Ssk -1.00, Sku 5.00
    """

    skewness: float = attrs.field(converter=_skewness, default=0.0)
    kurtosis: float | None = attrs.field(converter=_kurtosis, default=None)
    bearing: Bearing | None = attrs.field(converter=_bearing, default=None, repr=_outline)

    def __attrs_post_init__(self) -> None:
        super().__attrs_post_init__()
        given = (self.rms_height is not None) + (self.rms_slope is not None)
        if given > 1 or (given == 0 and self.bearing is None):
            raise InputError(
                "Give exactly one of rms_height= and rms_slope=, or a bearing curve whose rms height it has."
            )
        if self.bearing is not None:
            if self.skewness != 0.0 or self.kurtosis is not None:
                raise InputError("Give skewness= and kurtosis=, or bearing=, which has both.")
            return
        _find_parameters(self.skewness, self._kurtosis)

    @property
    def _kurtosis(self) -> float:
        return 3.0 + _GAMMA_EXCESS * self.skewness**2 if self.kurtosis is None else self.kurtosis

    @property
    def gaussian(self) -> SelfAffineSurface:
        """The Gaussian surface of the same waves, whose phases are others."""
        rms_height = self.rms_height
        if rms_height is None and self.rms_slope is None and self.bearing is not None:
            heights = _invert(self.bearing, (np.arange(2**12) + 0.5) / 2**12)
            rms_height = float(heights.std())
        return SelfAffineSurface(
            hurst=self.hurst,
            shortest=self.shortest,
            longest=self.longest,
            rms_height=rms_height,
            rms_slope=self.rms_slope,
            rolloff=self.rolloff,
            peklenik=self.peklenik,
            lay=self.lay,
            seed=self.seed,
        )

    def heights(self, grid: Grid) -> Array:
        """Return the heights at the cell centres, shape `grid.shape`, m, of mean zero."""
        source = self.gaussian
        # It refuses a grid that is too coarse before the work begins.
        source.require_grid(grid)
        nx, ny = (scipy.fft.next_fast_len(math.ceil(_CELLS_PER_WAVE * side / self.shortest)) for side in grid.size)
        require_memory(8.0 * _ARRAYS_IN_MEMORY * nx * ny, f"A surface of {nx} x {ny} cells", "choose fewer cells")
        return fourier(_make_heights(self, (nx, ny), grid.size), grid.shape)


@functools.lru_cache(maxsize=2)
def _make_heights(surface: NonGaussianSurface, shape: tuple[int, int], size: Pair) -> Array:
    """Return the heights on cells that resolve all waves, shape `shape`, m, read-only: those of the spectrum."""
    heights = surface.gaussian.heights(Grid(shape, size))
    amplitudes = np.abs(scipy.fft.rfft2(heights))
    ratios = (np.arange(heights.size) + 0.5) / heights.size
    if surface.bearing is not None:
        found = _shape(heights, amplitudes, _invert(surface.bearing, ratios), _ROUNDS)
    else:
        wanted = np.array((surface.skewness, surface._kurtosis))
        aim = wanted
        found = _shape(heights, amplitudes, _spread(aim, ratios), _ROUNDS)
        for _ in range(_MAX_CORRECTIONS):
            error = wanted - _measure(found)
            if np.abs(error).max() < _CLOSE_MOMENTS:
                break
            nearer = aim + error
            try:
                values = _spread(nearer, ratios)
            # Beyond what the distribution can be the surface stays as near as it is.
            except InputError:
                break
            aim = nearer
            found = _shape(found, amplitudes, values, _ROUNDS_BETWEEN)
        reached = _measure(found)
        if np.abs(reached - wanted).max() > _MAX_MOMENT_ERROR * max(1.0, float(wanted[1]) / _USUAL_KURTOSIS):
            raise InputError(
                f"These waves make no surface with a skewness of {wanted[0]:.4g} and a kurtosis of {wanted[1]:.4g}: "
                f"they reach {reached[0]:.3g} and {reached[1]:.3g}. Choose moments nearer to 0 and 3, or more waves."
            )
    found.flags.writeable = False
    return found


def _shape(heights: Array, amplitudes: Array, values: Array, rounds: int) -> Array:
    """Return heights of these amplitudes whose distribution is nearly that of ascending values, shape (n,)."""
    ordered = np.empty(heights.size)
    for _ in range(rounds):
        ordered[np.argsort(heights, axis=None)] = values
        modes = scipy.fft.rfft2(ordered.reshape(heights.shape))
        lengths = np.abs(modes)
        modes *= np.divide(amplitudes, lengths, out=np.zeros_like(lengths), where=lengths > 0.0)
        heights = scipy.fft.irfft2(modes, heights.shape)
    return heights


def _measure(heights: Array) -> Array:
    """Return skewness and kurtosis."""
    square = float(np.mean(heights**2))
    return np.array([float(np.mean(heights**3)) / square**1.5, float(np.mean(heights**4)) / square**2])


def _spread(moments: Array, ratios: Array) -> Array:
    """Return ascending values at fractions of a distribution of this skewness and kurtosis."""
    skew, tail = _find_parameters(float(moments[0]), float(moments[1]))
    values = np.sinh((np.arcsinh(scipy.special.ndtri(ratios)) + skew) / tail)
    return np.asarray((values - values.mean()) / values.std())


def _find_parameters(skewness: float, kurtosis: float) -> Pair:
    """Return the parameters of the sinh-arcsinh distribution with these moments; `InputError` if there is none."""
    from scipy.optimize import root

    nodes, weights = np.polynomial.hermite_e.hermegauss(_QUADRATURE_POINTS)
    weights = weights / weights.sum()
    stretched = np.arcsinh(nodes)

    def miss(parameters: Array) -> Array:
        values = np.sinh((stretched + parameters[0]) / np.exp(parameters[1]))
        values -= weights @ values
        square = weights @ values**2
        return np.array([weights @ values**3 / square**1.5 - skewness, (weights @ values**4 / square**2 - kurtosis)])

    for start in _STARTS:
        with np.errstate(all="ignore"):
            found = root(miss, [math.copysign(start[0], skewness), start[1]])
        if np.abs(found.fun).max() < _MOMENT_TOLERANCE * kurtosis:
            return float(found.x[0]), math.exp(float(found.x[1]))
    usual = 3.0 + _GAMMA_EXCESS * skewness**2
    advice = f"choose a larger kurtosis, such as {usual:.4g}" if kurtosis < usual else "choose a skewness nearer to 0"
    raise InputError(
        f"No surface is made with a skewness of {skewness:.4g} and a kurtosis of {kurtosis:.4g}: {advice}."
    )


def _invert(bearing: Bearing, ratios: Array) -> Array:
    """Return ascending heights of mean zero at fractions from the lowest, linear between the points of the curve."""
    levels, fractions = (np.array(one)[::-1] for one in bearing)
    values = np.interp(ratios, 1.0 - fractions, levels)
    return np.asarray(values - values.mean())
