"""What line scans tell of a surface: its slope and its moments, with their sampling errors."""

from __future__ import annotations

import math
from typing import Any

import attrs
import numpy as np
import numpy.typing as npt
import scipy

from roughcontact._base.arrays import Array
from roughcontact._base.checks import flag, integer, number, numbers
from roughcontact._base.units import Estimate, Length, Quantity, ShownAsPrinted, WarningText
from roughcontact._parts.surfaces import HANN_DEPENDENCE, SelfAffineSurface
from roughcontact.errors import InputError, argument
from roughcontact.errors.door import guarded

# Weights of the differences z_k - z_-k over 60 spacings of ISO 25178-2 and ISO 21920-2, which lose 0.1 % of waves of
# eight points.
_SLOPE_WEIGHTS = (45.0, -9.0, 1.0)
_SLOPE_SPACINGS = 60.0
# Fewest points of a line.
_MIN_POINTS = 32
# Autocorrelation at which the length of correlation ends, and its multiple up to which squares are summed.
_CORRELATION_END = 0.05
_CORRELATION_LENGTHS = 4.0
# Standard deviations of the correlation of independent lines from which on it is not by chance.
_CHANCE = 3.0
# Independent heights of a line below which waves longer than the line matter to Sq.
_FEW_HEIGHTS = 30.0
# Squared correlation of neighbouring lines, summed, above which they are warned of; and rounding of heights.
_MAX_SHARED = 0.5
_ROUNDING = 1e-14
# Fewest lines from which a spectrum is fitted, and of the shortest waves in each.
_MIN_LINES_OF_FIT = 5
_MIN_WAVES_OF_FIT = 8.0
# Points of the projection of a spectrum, and numbers of exponents and roll-offs whose likelihood is found.
_FIT_POINTS = 60
_FIT_EXPONENTS = 21
_FIT_ROLLOFFS = 25


@guarded
@attrs.frozen(kw_only=True)
class ProfileStatistics(ShownAsPrinted):
    """What line scans tell of a surface; sampling errors are one standard deviation.

    Attributes
    ----------
    Rq, Rdq
        Root mean square height, m, and slope of the lines, each less its mean line; those of all lines.
    Rdq_across
        The slope of the lines at right angles; None without them.
    Sq
        Root mean square height of the surface, m: that of the lines, corrected for the waves that are longer than
        them, with an error of the size of the correction.
    Sdq
        Root mean square gradient of the surface; None unless it is stated to be isotropic, or lines at right angles are
        given.
    m0, m2
        Moments of the spectrum as of `roughness`: Sq^2, m2, and Sdq^2 / 2; m2 is None where Sdq is.
    """

    Rq: Estimate
    Rdq: Estimate
    Rdq_across: Estimate | None
    Sq: Estimate
    Sdq: Estimate | None
    m0: Estimate
    m2: Estimate | None

    def persson_area(self, pressure: Quantity, modulus: Quantity) -> Estimate:
        r"""Return the fraction of the nominal area in contact by Persson's theory, with the error by that of Sdq.

        .. math:: \frac{A}{A_0} = \mathrm{erf}\left( \sqrt{2}\, \frac{p}{E^* S_{dq}} \right)

        It is 17 to 31 % below that of solved contacts of isotropic surfaces; see `persson`.

        Parameters
        ----------
        pressure
            Nominal mean pressure, Pa.
        modulus
            Contact modulus E*, Pa.

        Raises
        ------
        InputError
            If Sdq is not known.
        """
        if self.Sdq is None:
            raise InputError("Without a statement that the surface is isotropic, or lines across, there is no Sdq.")
        p = number(pressure, "The mean pressure", "Pa", at_least=0.0)
        x = math.sqrt(2.0) * p / (number(modulus, "The contact modulus", "Pa", above=0.0) * self.Sdq.value)
        steepness = 2.0 / math.sqrt(math.pi) * math.exp(-min(x**2, 700.0)) * x
        return Estimate(math.erf(x), steepness * self.Sdq.uncertainty / self.Sdq.value, "", self.Sdq.warnings)

    def __str__(self) -> str:
        rows = {
            "Rq": ("root mean square height of the lines", self.Rq),
            "Rdq": ("root mean square slope of the lines", self.Rdq),
            "across": ("the same at right angles", self.Rdq_across),
            "Sq": ("root mean square height", self.Sq),
            "Sdq": ("root mean square gradient", self.Sdq),
            "m0": ("mean square height", self.m0),
            "m2": ("mean square slope along a line", self.m2),
        }
        return "\n".join(f"{name:7} {text:38} {value}" for name, (text, value) in rows.items() if value is not None)


@guarded
def profile(
    lines: npt.ArrayLike, spacing: Length, *, isotropic: bool = False, across: npt.ArrayLike | None = None
) -> ProfileStatistics:
    r"""Return what line scans tell of a surface.

    Of an isotropic surface all lines have the same slope, and of any surface two directions at right angles have the
    trace of its mean square slopes, whatever the lay:

    .. math:: S_{dq}^2 = 2 R_{dq}^2, \qquad S_{dq}^2 = R_{dq,1}^2 + R_{dq,2}^2

    Lines along one direction cannot tell a lay, along which Rdq may be a fifth of that across it: without a statement
    there is no Sdq. The errors follow from the autocorrelation :math:`\rho` of the lines, since a mean square of n
    points has the relative variance

    .. math:: \frac{2}{n} \left( 1 + 2 \sum_{k > 0} \rho_k^2 \right)

    and lines beside each other, which are correlated, count less. Waves with fewer than 6 points lose slope, noise adds
    it.

    Parameters
    ----------
    lines
        Heights along one line, shape (points,), or along several, shape (lines, points), m.
    spacing
        Distance of the points, m.
    isotropic
        Whether the surface is stated to be isotropic.
    across
        Lines at right angles to the first, with the same spacing.

    Raises
    ------
    InputError
        If the lines are not finite numbers of at least 32 points, all are equal, or a surface with lines across is said
        to be isotropic.

    References
    ----------
    Nayak, J. Lubr. Technol. 93 (1971) 398-407, https://doi.org/10.1115/1.3451608

    Examples
    --------
    >>> import roughcontact as rc
    >>> rough = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=8e-6, longest=128e-6, seed=1)
    >>> heights = rough.heights(rc.Grid((512, 512), 512e-6))
    >>> found = rc.reference.profile(heights[:, ::100].T, 1e-6, isotropic=True)
    >>> print(found.Sdq)
    0.1054 +- 0.0034
    """
    step = number(spacing, "The spacing of the points", "m", above=0.0)
    is_isotropic = flag(isotropic, "isotropic=")
    if is_isotropic and across is not None:
        raise InputError(f"Lines across tell of any lay: omit {argument('isotropic')} or {argument('across')}.")
    along = _Lines.of(lines, step, "The lines")
    other = None if across is None else _Lines.of(across, step, "The lines across")
    both = [along] if other is None else [along, other]
    heights = _join([one.height for one in both])
    square, error, warnings = heights
    Rq = Estimate(math.sqrt(square), 0.5 * error * math.sqrt(square), "m")
    lost = sum(one.lost * one.height[0] for one in both) / sum(one.height[0] for one in both)
    whole = square / (1.0 - lost)
    spread = math.hypot(error, lost)
    if lost > 2.0 / _FEW_HEIGHTS:
        text = "the lines are short: waves longer than them are not measured, and are only estimated in Sq"
        warnings = (*warnings, WarningText(text, "short lines", lost))
    slopes = [_root(one.slope) for one in both]
    total: tuple[float, float] | None = None
    if other is not None:
        total = along.slope[0] + other.slope[0], math.hypot(*(one.slope[0] * one.slope[1] for one in both))
    elif is_isotropic:
        total = 2.0 * along.slope[0], 2.0 * along.slope[0] * along.slope[1]
    steep = () if total is None else tuple(dict.fromkeys(text for one in both for text in one.slope[2]))
    return ProfileStatistics(
        Rq=Rq,
        Rdq=slopes[0],
        Rdq_across=slopes[1] if other is not None else None,
        Sq=Estimate(math.sqrt(whole), 0.5 * spread * math.sqrt(whole), "m", warnings),
        Sdq=None if total is None else Estimate(math.sqrt(total[0]), 0.5 * total[1] / math.sqrt(total[0]), "", steep),
        m0=Estimate(whole, spread * whole, "m2", warnings),
        m2=None if total is None else Estimate(0.5 * total[0], 0.5 * total[1], "", steep),
    )


@attrs.frozen
class _Lines:
    """Lines of one direction: mean square height, m2, and slope, each with its relative error and warnings.

    And the fraction of the mean square height that they lack by waves longer than themselves.
    """

    height: tuple[float, float, tuple[str, ...]]
    slope: tuple[float, float, tuple[str, ...]]
    lost: float

    @classmethod
    def of(cls, values: Any, step: float, what: str) -> _Lines:
        heights = read_lines(values, what)
        slopes = _differentiate(heights, step)
        first = float(np.mean(heights**2)), *_find_error(heights)
        second = float(np.mean(slopes**2)), *_find_error(slopes)
        correlation = _correlate(heights)
        end = int(np.argmax(correlation <= 0.0)) or correlation.size
        independent = heights.shape[1] / (1.0 + 2.0 * float(correlation[1:end].sum()))
        # Mean and slope of a line take the fraction of two of its independent heights.
        return cls(first, second, min(2.0 / independent, 0.5))


def read_lines(values: Any, what: str) -> Array:
    """Return lines less their mean lines, shape (lines, points), m, or raise `InputError`."""
    allowed = f"heights of shape (points,) or (lines, points), m, with at least {_MIN_POINTS} points"
    heights = np.atleast_2d(numbers(values, what, allowed, "m"))
    if heights.ndim != 2 or heights.shape[1] < _MIN_POINTS or not np.isfinite(heights).all():
        raise InputError.about(what, values, allowed)
    place = np.arange(heights.shape[1]) - 0.5 * (heights.shape[1] - 1)
    rough = heights - heights.mean(axis=1, keepdims=True)
    rough -= (rough @ place / (place @ place))[:, np.newaxis] * place
    if np.abs(rough).max() <= _ROUNDING * max(float(np.abs(heights).max()), _ROUNDING):
        raise InputError(f"{what} are straight: they tell no roughness.")
    return np.asarray(rough)


def _differentiate(heights: Array, step: float) -> Array:
    """Return the slopes of lines at the points that have three neighbours on both sides."""
    slopes = np.zeros((len(heights), heights.shape[1] - 6))
    for reach, weight in enumerate(_SLOPE_WEIGHTS, start=1):
        stop = heights.shape[1] - 3
        slopes += weight * (heights[:, 3 + reach : stop + reach] - heights[:, 3 - reach : stop - reach])
    return slopes / (_SLOPE_SPACINGS * step)


def _correlate(values: Array) -> Array:
    """Return the autocorrelation of lines, shape (points,), the mean over them."""
    count = values.shape[1]
    modes = scipy.fft.rfft(values, scipy.fft.next_fast_len(2 * count, real=True))
    sums = scipy.fft.irfft(np.sum(np.abs(modes) ** 2, axis=0))[:count]
    return np.asarray(sums / sums[0])


def _find_error(values: Array) -> tuple[float, tuple[str, ...]]:
    """Return the relative standard deviation of the mean square of lines, and warnings."""
    lines, points = values.shape
    correlation = _correlate(values)
    small = np.abs(correlation) < _CORRELATION_END
    reach = min(int(_CORRELATION_LENGTHS * max(int(np.argmax(small)), 1)), points - 1)
    independent = points / (1.0 + 2.0 * float(np.sum(correlation[1 : reach + 1] ** 2)))
    shared = 0.0
    for apart in range(1, lines):
        one = values[:-apart]
        other = values[apart:]
        common = float(np.sum(one * other)) / math.sqrt(float(np.sum(one**2)) * float(np.sum(other**2)))
        if abs(common) < _CHANCE / math.sqrt(independent * (lines - apart)):
            break
        shared += 2.0 * (1.0 - apart / lines) * common**2
    warnings: tuple[str, ...] = ()
    if shared > _MAX_SHARED:
        text = f"the lines are so near to each other that {lines} count as {lines / (1.0 + shared):.2g}: spread them"
        warnings = (WarningText(text, "lines side by side", shared),)
    return math.sqrt(2.0 * (1.0 + shared) / (independent * lines)), warnings


def _join(parts: list[tuple[float, float, tuple[str, ...]]]) -> tuple[float, float, tuple[str, ...]]:
    """Return the mean of mean squares weighted by their precision, its relative error, and all warnings."""
    weights = np.array([1.0 / error**2 for _, error, _ in parts])
    mean = float(np.average([value for value, _, _ in parts], weights=weights))
    return (
        mean,
        1.0 / math.sqrt(float(weights.sum())),
        tuple(dict.fromkeys(text for _, _, texts in parts for text in texts)),
    )


def _root(part: tuple[float, float, tuple[str, ...]]) -> Estimate:
    value, error, warnings = part
    return Estimate(math.sqrt(value), 0.5 * error * math.sqrt(value), "", warnings)


@guarded
@attrs.frozen(kw_only=True)
class ProfileFit(ShownAsPrinted):
    """An isotropic self-affine surface with the spectrum of line scans.

    Attributes
    ----------
    surface
        The surface, with the rms slope that the lines have.
    hurst, rolloff
        Its Hurst exponent and roll-off, m, with their standard errors.
    """

    surface: SelfAffineSurface
    hurst: Estimate
    rolloff: Estimate


@guarded
def fit_surface(lines: npt.ArrayLike, spacing: Length, shortest: Length, *, seed: int = 0) -> ProfileFit:
    r"""Return a random surface with the spectrum of five or more line scans of an isotropic surface.

    The spectrum of a line is a projection of that of the surface,

    .. math:: C_1(q) = 2 \int_0^\infty C_2\left(\sqrt{q^2 + k^2}\right) \mathrm{d}k,

    and Hurst exponent and roll-off are the means under its likelihood (Whittle's) over all values; projecting backwards
    would differentiate noise. The rms slope is that of `profile`, whose error is smaller than that of a fit. Other
    seeds are other surfaces of the same spectrum: the measured one is not among them.

    Parameters
    ----------
    lines
        Heights along the lines, shape (lines, points), m.
    spacing
        Distance of the points, m.
    shortest
        Shortest wavelength of the surface, m, at least four points: below it the lines are noise, or the surface ends.
    seed
        Seed of the surface.

    Raises
    ------
    InputError
        If there are fewer than five lines, or they hold fewer than 8 of the shortest waves.

    References
    ----------
    Jacobs, Junge, Pastewka, Surf. Topogr.: Metrol. Prop. 5 (2017) 013001, https://doi.org/10.1088/2051-672X/aa51f8

    Examples
    --------
    >>> import roughcontact as rc
    >>> rough = rc.SelfAffineSurface(
    ...     hurst=0.8, rms_slope=0.1, shortest=8e-6, longest=512e-6, rolloff=64e-6, seed=1
    ... )
    >>> heights = rough.heights(rc.Grid((512, 512), 512e-6))
    >>> found = rc.reference.fit_surface(heights[:, ::64].T, 1e-6, shortest=8e-6)
    >>> print(f"{found.hurst.value:.2f} +- {found.hurst.uncertainty:.2f}")
    0.75 +- 0.07
    """
    step = number(spacing, "The spacing of the points", "m", above=0.0)
    wave = number(shortest, "The shortest wavelength", "m", above=0.0)
    heights = read_lines(lines, "The lines")
    count, points = heights.shape
    length = points * step
    if count < _MIN_LINES_OF_FIT:
        raise InputError.about("The number of lines", count, f"at least {_MIN_LINES_OF_FIT} for a spectrum")
    if wave < 4.0 * step * (1.0 - 1e-9) or wave > length / _MIN_WAVES_OF_FIT:
        allowed = f"from four points ({4.0 * step:g} m) to an eighth of the lines ({length / _MIN_WAVES_OF_FIT:g} m)"
        raise InputError.about("The shortest wavelength", wave, allowed)
    slope = profile(heights, step, isotropic=True).Sdq
    hurst, rolloff = _fit_spectrum(heights, step, wave)
    made = SelfAffineSurface(
        hurst=hurst.value,
        rms_slope=slope.value if slope is not None else None,
        shortest=wave,
        rolloff=min(rolloff.value, length),
        longest=length,
        seed=integer(seed, "The seed", at_least=0),
    )
    return ProfileFit(surface=made, hurst=hurst, rolloff=rolloff)


def _fit_spectrum(heights: Array, step: float, shortest: float) -> tuple[Estimate, Estimate]:
    """Return Hurst exponent and roll-off, m: means and standard deviations under the likelihood of the spectrum."""
    points = heights.shape[1]
    window = np.sin(np.pi * (np.arange(points) + 0.5) / points) ** 2
    power = np.mean(np.abs(scipy.fft.rfft(heights * window)) ** 2, axis=0)
    q = 2.0 * math.pi * scipy.fft.rfftfreq(points, step)
    highest = 2.0 * math.pi / shortest
    # The window mixes the lowest waves with the mean line, and the highest ones with what lies beyond the band.
    used = slice(2, int(np.searchsorted(q, 0.9 * highest)))
    power = power[used]
    q = q[used, np.newaxis]
    # Points of the projection, closer where the spectrum is steep.
    ends = np.sqrt(highest**2 - q**2) * np.linspace(0.0, 1.0, _FIT_POINTS) ** 2
    lengths = np.hypot(q, ends)
    exponents = np.linspace(0.0, 1.0, _FIT_EXPONENTS)
    waves = np.geomspace(2.0 * shortest, points * step, _FIT_ROLLOFFS)
    loss = np.empty((exponents.size, waves.size))
    for i, exponent in enumerate(exponents):
        for j, rolloff in enumerate(waves):
            density = np.maximum(lengths, 2.0 * math.pi / rolloff) ** (-2.0 - 2.0 * exponent)
            model = np.trapezoid(density, ends, axis=1)
            ratio = power / model
            loss[i, j] = power.size * math.log(float(ratio.mean())) + float(np.log(model).sum())
    weight = np.exp(-(loss - loss.min()) * len(heights) / math.sqrt(HANN_DEPENDENCE))
    weight /= weight.sum()
    found = []
    for values, marginal in ((exponents, weight.sum(axis=1)), (np.log(waves), weight.sum(axis=0))):
        mean = float(marginal @ values)
        found.append((mean, math.sqrt(float(marginal @ (values - mean) ** 2))))
    (exponent, exponent_std), (logarithm, logarithm_std) = found
    wave = math.exp(logarithm)
    return Estimate(exponent, exponent_std, ""), Estimate(wave, wave * logarithm_std, "m")
