"""Bearing area, discrete power spectrum and spectral moments of heights, and what follows about summits."""

from __future__ import annotations

import math

import attrs
import numpy as np
import scipy

from roughcontact._base.arrays import Array, read_only, sum_of_products
from roughcontact._base.checks import MIN_MAGNITUDE, flag, heights_array, numbers
from roughcontact._base.units import Estimate, ShownAsPrinted, outlined
from roughcontact._parts.grid import Grid
from roughcontact._parts.surfaces import HANN_DEPENDENCE
from roughcontact.errors import InputError
from roughcontact.errors.door import guarded

# Power of rounding, over the power of the strongest wave.
_MIN_RELATIVE_POWER = 1e-28
# Parts along each side of a map, whose differences give the sampling error.
_PARTS_PER_SIDE = 4


@attrs.frozen(eq=False)
class Waves:
    """The waves of heights, without their mean, in cells along x and units of `height`; -q is counted with q.

    Attributes
    ----------
    qx, qy
        Wave numbers, shape (waves,), rad a cell along x.
    power
        Mean square of the mode q or -q, shape (waves,).
    count
        Number of modes of each entry, two or one, shape (waves,).
    height, cell
        Units of the heights and lengths, m.
    dependent
        Modes per independent mode.
    """

    qx: Array
    qy: Array
    power: Array
    count: Array
    height: float
    cell: float
    dependent: float

    @property
    def square(self) -> Array:
        """Squared wave numbers, shape (waves,)."""
        return np.asarray(self.qx**2 + self.qy**2)

    def sum(self, weight: Array | float) -> float:
        """Return the sum over all modes of weight times power."""
        return float(np.sum(self.count * weight * self.power))

    def spread(self, weight: Array | float) -> float:
        r"""Return the standard deviation of the weighted sum over surfaces of the same spectrum.

        The power of a pair of modes of a Gaussian surface is exponentially distributed: the variance of the sum is the
        sum of the squared expected parts of the pairs, and the squares found are on average twice as large.
        """
        return math.sqrt(self.dependent * float(np.sum(self.count * (weight * self.power) ** 2)))


def read_heights(heights: Array, grid: Grid) -> Array:
    """Return heights, m, of the shape of their grid, or raise `InputError`."""
    if not isinstance(grid, Grid):
        raise InputError.about("The grid", grid, "a Grid(shape, size)")
    heights = heights_array(heights)
    if heights.shape != grid.shape:
        raise InputError.about("The heights", heights, f"of the shape of the grid, {grid.shape}")
    return heights


def list_waves(heights: Array, grid: Grid, periodic: bool) -> Waves:
    """Return the waves of heights, shape `grid.shape`, m; heights that do not repeat are windowed (Hann)."""
    return transform_waves(read_heights(heights, grid), grid, flag(periodic, "periodic="))


def transform_waves(heights: Array, grid: Grid, periodic: bool = True) -> Waves:
    """Return the waves of heights that have been checked; see `list_waves`."""
    largest = max(float(heights.max()), -float(heights.min()))
    if largest < MIN_MAGNITUDE:
        raise InputError(f"The heights are below {MIN_MAGNITUDE:g} m: there is no roughness.")
    scaled = heights / largest
    scaled -= scaled.mean()
    unit = max(float(scaled.max()), -float(scaled.min()))
    if unit <= 16.0 * float(np.finfo(np.float64).eps):
        raise InputError("All heights are equal: there is no roughness.")
    scaled /= unit
    modes = scipy.fft.rfft2(scaled if periodic else _window(scaled), norm="forward")
    power = modes.real**2
    power += modes.imag**2
    power[0, 0] = 0.0
    # Most modes of a band-limited surface are rounding.
    i, j = np.nonzero(power > _MIN_RELATIVE_POWER * power.max())
    nx, ny = grid.shape
    ratio = grid.spacing[0] / grid.spacing[1]
    qx = 2.0 * np.pi * scipy.fft.fftfreq(nx)[i]
    qy = 2.0 * np.pi * ratio * scipy.fft.rfftfreq(ny)[j]
    count = np.where((j == 0) | (2 * j == ny), 1.0, 2.0)
    return Waves(qx, qy, power[i, j], count, unit * largest, grid.spacing[0], 1.0 if periodic else HANN_DEPENDENCE)


def _window(heights: Array) -> Array:
    """Return heights times a Hann window of mean square one, without their mean."""
    windows = [np.sin(np.pi * (np.arange(n) + 0.5) / n) ** 2 if n > 1 else np.ones(1) for n in heights.shape]
    window = windows[0][:, np.newaxis] * windows[1][np.newaxis, :]
    window /= np.sqrt(np.mean(window**2))
    return np.asarray((heights - np.sum(heights * window) / np.sum(window)) * window)


def _column(values: object) -> Array:
    return read_only(numbers(values, "A column of the bearing curve", "numbers"))


@guarded
@attrs.frozen(eq=False)
class BearingCurve:
    """The Abbott-Firestone curve.

    Attributes
    ----------
    levels
        Levels above the mean height, shape (n,), m.
    fractions
        Fraction of the heights above each level, shape (n,).
    uncertainties
        Their sampling error, one standard deviation, shape (n,): from the differences of the 16 parts of the map,
        which must be larger than its longest waves.
    """

    levels: Array = attrs.field(converter=_column, repr=outlined)
    fractions: Array = attrs.field(converter=_column, repr=outlined)
    uncertainties: Array = attrs.field(converter=_column, repr=outlined)


@guarded
def bearing_area(heights: Array, levels: Array | None = None) -> BearingCurve:
    """Return the bearing area of heights: the area at which a flat at each level would cut them.

    This overlap takes no account of elasticity: at the same mean gap the elastic contact is several times smaller.

    Parameters
    ----------
    heights
        Heights, shape (nx, ny), m.
    levels
        Levels above the mean height, m; None: 101 levels from the lowest height to the highest.

    Raises
    ------
    InputError
        If the heights or the levels are not finite numbers of the right shape.

    References
    ----------
    Abbott, Firestone, Mech. Eng. 55 (1933) 569-572

    Examples
    --------
    >>> import roughcontact as rc
    >>> curve = rc.reference.bearing_area(rc.examples.lapped_plate().detrend("plane").values)
    >>> print(f"{100 * curve.fractions[curve.levels > 0].max():.0f} % of the plate is above its mean plane")
    54 % of the plate is above its mean plane
    """
    rough = heights_array(heights)
    rough = rough - rough.mean()
    what = "The levels"
    allowed = "a list of finite numbers (m)"
    at = np.linspace(rough.min(), rough.max(), 101) if levels is None else numbers(levels, what, allowed, "m")
    if at.ndim != 1 or not np.isfinite(at).all():
        raise InputError.about(what, levels, allowed)
    parts = np.array([_find_fractions(part, at) for part in split_map(rough)])
    spread = np.std(parts, axis=0, ddof=1) / np.sqrt(len(parts)) if len(parts) > 1 else np.zeros(at.size)
    return BearingCurve(at, _find_fractions(rough, at), spread)


def split_map(heights: Array) -> list[Array]:
    """Return the 16 parts of a map, fewer if it has fewer cells along an axis."""
    rows = np.array_split(heights, _PARTS_PER_SIDE, axis=0)
    return [part for row in rows for part in np.array_split(row, _PARTS_PER_SIDE, axis=1) if part.size]


def _find_fractions(heights: Array, levels: Array) -> Array:
    """Return the fraction of the heights above each level."""
    ordered = np.sort(heights, axis=None)
    return np.asarray(1.0 - np.searchsorted(ordered, levels, side="right") / ordered.size)


@guarded
@attrs.frozen
class Roughness(ShownAsPrinted):
    """Spectral moments of heights, and the summits of a Gaussian surface with these moments.

    The uncertainties are sampling errors: standard deviations over Gaussian surfaces of the same spectrum and size.

    Attributes
    ----------
    m0, m2, m4
        Mean square of the height, m2, of the slope along a line, and of the curvature along a line, 1/m2.
    rms_height, rms_slope
        Root mean square of the height, m, and of the gradient's magnitude.
    nayak
        Nayak's parameter m0 m4 / m2^2: the breadth of the spectrum.
    summit_density
        Summits over area, 1/m2.
    summit_height, summit_deviation
        Mean height of the summits above the mean plane, and its standard deviation, m.
    summit_radius
        Inverse of the mean curvature of the summits, m.
    skewness, kurtosis
        Third and fourth moments of the heights over powers of the second: 0 and 3 for a Gaussian surface.
    """

    m0: Estimate
    m2: Estimate
    m4: Estimate
    rms_height: Estimate
    rms_slope: Estimate
    nayak: Estimate
    summit_density: Estimate
    summit_height: Estimate
    summit_deviation: Estimate
    summit_radius: Estimate
    skewness: float
    kurtosis: float

    def __str__(self) -> str:
        rows = {
            "root of m0": self.rms_height,
            "rms slope": self.rms_slope,
            "m0": self.m0,
            "m2": self.m2,
            "m4": self.m4,
            "Nayak's parameter": self.nayak,
            "summit density": self.summit_density,
            "mean height of summits": self.summit_height,
            "deviation of summits": self.summit_deviation,
            "mean radius of summits": self.summit_radius,
        }
        lines = [f"{name:23} {value}" for name, value in rows.items()]
        return "\n".join([*lines, f"{'skewness, kurtosis':23} {self.skewness:.3g}, {self.kurtosis:.3g}"])


@guarded
def roughness(heights: Array, grid: Grid, *, periodic: bool = True) -> Roughness:
    r"""Return the spectral moments of heights, and the summits that follow from them, with their sampling errors.

    .. math:: m_0 = \sum_q C_q, \quad m_2 = \frac{1}{2} \sum_q q^2 C_q, \quad m_4 = \frac{3}{8} \sum_q q^4 C_q, \quad
              \alpha = \frac{m_0 m_4}{m_2^2}

    The derivatives are taken from the spectrum, not from differences of heights, which lose a third of m4 for waves of
    four cells. For isotropic Gaussian surfaces the density of the summits, their mean height, the variance of their
    heights, and their mean curvature are

    .. math:: D = \frac{m_4}{6 \sqrt 3\, \pi\, m_2}, \quad \bar z = 4 \sqrt{\frac{m_0}{\pi \alpha}}, \quad
              \sigma_s^2 = \left(1 - \frac{0.8968}{\alpha}\right) m_0, \quad
              \bar\kappa = \frac{8}{3} \sqrt{\frac{m_4}{\pi}}

    Parameters
    ----------
    heights, grid
        Heights, shape `grid.shape`, m, and their grid.
    periodic
        Whether the heights repeat beyond the border. If not, subtract their form first; they are windowed (Hann), and
        all results depend on both.

    References
    ----------
    Longuet-Higgins, Phil. Trans. R. Soc. A 249 (1957) 321-387, https://doi.org/10.1098/rsta.1957.0002;
    Nayak, J. Lubr. Technol. 93 (1971) 398-407, https://doi.org/10.1115/1.3451608;
    McCool, Wear 107 (1986) 37-60, https://doi.org/10.1016/0043-1648(86)90045-1

    Examples
    --------
    >>> import roughcontact as rc
    >>> grid = rc.Grid((128, 128), 128e-6)
    >>> rough = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=8e-6, longest=64e-6, seed=1)
    >>> found = rc.reference.roughness(rough.heights(grid), grid)
    >>> print(f"{found.m2.value:.4f}")  # half of the mean square gradient
    0.0050
    """
    waves = list_waves(heights, grid, periodic)
    unit = waves.height
    cell = waves.cell
    square = waves.square
    weights = (np.ones_like(square), 0.5 * square, 0.375 * square**2)
    m0, m2, m4 = (waves.sum(weight) for weight in weights)
    relative = [weight / moment for weight, moment in zip(weights, (m0, m2, m4), strict=True)]

    def estimate(value: float, powers: tuple[float, float, float], label: str) -> Estimate:
        """Return the estimate of a product of these powers of the moments."""
        change = sum(power * weight for power, weight in zip(powers, relative, strict=True))
        return Estimate(value, abs(value) * waves.spread(change), label)

    alpha = m0 * m4 / m2**2
    # d ln(deviation) / d ln(alpha); isotropic surfaces have alpha >= 1.5.
    broad = max(alpha, 1.5)
    bend = 0.5 * 0.8968 / (broad - 0.8968)
    skewness, kurtosis = find_shape(heights_array(heights))
    return Roughness(
        estimate(m0 * unit**2, (1, 0, 0), "m2"),
        estimate(m2 * (unit / cell) ** 2, (0, 1, 0), ""),
        estimate(m4 * (unit / cell**2) ** 2, (0, 0, 1), "1/m2"),
        estimate(math.sqrt(m0) * unit, (0.5, 0, 0), "m"),
        estimate(math.sqrt(2.0 * m2) * (unit / cell), (0, 0.5, 0), ""),
        estimate(alpha, (1, -2, 1), ""),
        estimate(m4 / m2 / (6.0 * math.sqrt(3.0) * math.pi * cell**2), (0, -1, 1), "1/m2"),
        estimate(4.0 * math.sqrt(m0 / (math.pi * alpha)) * unit, (0, 1, -0.5), "m"),
        estimate(math.sqrt((1.0 - 0.8968 / broad) * m0) * unit, (0.5 + bend, -2.0 * bend, bend), "m"),
        estimate(0.375 * math.sqrt(math.pi / m4) * cell**2 / unit, (0, 0, -0.5), "m"),
        skewness,
        kurtosis,
    )


def find_shape(heights: Array) -> tuple[float, float]:
    """Return skewness and kurtosis of heights, which must not all be equal."""
    rough = heights / max(float(heights.max()), -float(heights.min()))
    rough -= rough.mean()
    rough /= max(float(rough.max()), -float(rough.min()))
    square = rough**2
    second = float(square.mean())
    third, fourth = (sum_of_products(square, other) / rough.size for other in (rough, square))
    return third / second**1.5, fourth / second**2


def find_lay(waves: Waves) -> tuple[float, float]:
    """Return the ratio of the larger to the smaller rms slope along two perpendicular directions, 1 if isotropic.

    And the direction of the larger one, from x, rad.
    """
    xx, yy, xy = (waves.sum(weight) for weight in (waves.qx**2, waves.qy**2, waves.qx * waves.qy))
    middle = 0.5 * (xx + yy)
    half = math.hypot(0.5 * (xx - yy), xy)
    ratio = math.sqrt((middle + half) / max(middle - half, 1e-12 * middle))
    return ratio, 0.5 * math.atan2(2.0 * xy, xx - yy)
