"""Statistics of heights: rms slope, form by least squares, and power spectrum."""

from __future__ import annotations

import math

import attrs
import numpy as np
import numpy.typing as npt
import scipy

from roughcontact._base.arrays import Array, Mask, RealArray, matrix_product
from roughcontact._base.units import si
from roughcontact._parts.grid import Grid
from roughcontact.errors import InputError

# Maximum rms step of periodic heights across the border, over the step between neighbouring cells.
_MAX_BORDER_JUMP = 3.0
# Step between cells over the range of heights that is rounding of transforms.
_HEIGHT_ROUNDING = 1e-13
# Relative change of misfit, parameters and gradient at which the fit of a sphere stops, a few times the rounding of
# float64 (2.2e-16): the fit has four parameters, so that full accuracy costs nothing.
_SPHERE_FIT_TOLERANCE = 1e-15
# Curvature of a flat map, times its length, over its height and length: rounding.
_CURVATURE_ROUNDING = 1e-13
_TOO_FEW_POINTS = "Too few points were measured, or they are too nearly in line, for"
# Degree of the polynomial that is the form of a map.
FORM_DEGREE = 2
# Ratio of the longest to the shortest wave in the fit of a power law (two octaves, a thousand waves on 128 x 128
# cells), its bands, and its sectors of direction over half a turn.
_FIT_RANGE = 4.0
_FIT_BANDS = 6
_DIRECTION_SECTORS = 16
# Minimum waves per side, so that window and form do not change the power, and minimum range of the fit.
_MIN_WAVES_PER_SIDE = 6.0
_MIN_FIT_RANGE = 2.0
# Standard deviation of the exponent by the unknown transfer function of a measurement: point samples lower it by 0.1 to
# 0.2, means over cells raise it by 0.05 to 0.15 (self-affine surfaces, Hurst exponents 0.3, 0.8; 128 x 128 cells).
_SAMPLING_STD = 0.15
# Modes per independent mode in a Hann window w: the mean of w^4 over the squared mean of w^2, 35/18, along each axis.
HANN_DEPENDENCE = (35.0 / 18.0) ** 2


def rms_slope(heights: Array, grid: Grid) -> float:
    """Return the root mean square of the gradient of heights, shape (nx, ny), m, from differences of neighbours."""
    steps = [_find_steps(heights, axis) / grid.spacing[axis] for axis in (0, 1) if grid.shape[axis] > 1]
    maximum = max(max(float(step.max()), -float(step.min())) for step in steps)
    if not 0.0 < maximum < math.inf:
        return maximum
    return maximum * math.sqrt(sum(float(np.mean((step / maximum) ** 2)) for step in steps))


def _find_steps(heights: Array, axis: int) -> Array:
    """Return the differences of neighbours along an axis; faster than `numpy.diff`."""
    return heights[1:] - heights[:-1] if axis == 0 else heights[:, 1:] - heights[:, :-1]


def repeats(heights: Array, axis: int | None = None) -> bool:
    """Return whether heights, shape (nx, ny), repeat beyond the border without a jump, along one axis or both."""
    if axis is None:
        return repeats(heights, 0) and repeats(heights, 1)
    return border_jump(heights, axis) <= _MAX_BORDER_JUMP


def border_jump(heights: Array, axis: int) -> float:
    """Return the rms step of heights, shape (nx, ny), across the border along an axis, over the step between cells."""
    if heights.shape[axis] <= 2:
        return 0.0
    inside = math.sqrt(np.mean(_find_steps(heights, axis) ** 2))
    across = math.sqrt(np.mean((heights.take(0, axis) - heights.take(-1, axis)) ** 2))
    # Heights that transforms have made are equal up to rounding.
    return across / inside if inside > _HEIGHT_ROUNDING * float(np.ptp(heights)) else 0.0


def polynomial(values: Array, degree: int, non_measured: Mask | None, shape: tuple[int, int] | None = None) -> Array:
    """Return the least-squares polynomial of total degree `degree` through heights, shape (nx, ny), m.

    It is evaluated on the same cells, or on `shape` cells of the domain. Non-measured points do not count;
    `InputError` if the others do not determine the polynomial.
    """
    x, y = (np.linspace(-1.0, 1.0, n) for n in values.shape)
    px, py = (np.polynomial.legendre.legvander(t, degree) for t in (x, y))
    terms = [(i, j) for i in range(degree + 1) for j in range(degree + 1 - i)]
    # Products of terms factor over the axes, and so do the sums of the normal equations.
    n = degree + 1
    qx, qy = ((p[:, :, np.newaxis] * p[:, np.newaxis, :]).reshape(len(p), n * n) for p in (px, py))
    if non_measured is None:
        sums = np.outer(qx.sum(axis=0), qy.sum(axis=0))
        moments = matrix_product(matrix_product(px.T, values), py)
    else:
        counts = (~non_measured).astype(np.float64)
        sums = matrix_product(matrix_product(qx.T, counts), qy)
        moments = matrix_product(matrix_product(px.T, values * counts), py)
    sums = sums.reshape(n, n, n, n)
    gram = np.array([[sums[i, k, j, m] for k, m in terms] for i, j in terms])
    solved, _, rank, _ = np.linalg.lstsq(gram, np.array([moments[term] for term in terms]))
    if rank < len(terms):
        raise InputError(f"{_TOO_FEW_POINTS} a form of degree {degree}.")
    weights = np.zeros_like(moments)
    for term, weight in zip(terms, solved, strict=True):
        weights[term] = weight
    if shape is not None:
        x, y = (
            ((np.arange(m) + 0.5) * n / m - 0.5) * 2 / (n - 1) - 1 for m, n in zip(shape, values.shape, strict=True)
        )
        px, py = (np.polynomial.legendre.legvander(t, degree) for t in (x, y))
    return matrix_product(matrix_product(px, weights), py.T)


def sphere(values: Array, x: Array, y: Array, non_measured: Mask | None) -> tuple[Array, float]:
    r"""Return the least-squares sphere, shape (nx, ny), m, and its curvature 1/R, positive for a ball, 1/m.

    The sphere through (0, 0, c) with the unit normal n there is

    .. math:: z = c - \frac{2 C}{n_z + \sqrt{n_z^2 - 2 \kappa C}}, \quad
              C = \tfrac{\kappa}{2}(x^2 + y^2) + n_x x + n_y y

    and becomes a plane, without a singularity, as the curvature goes to zero; c, the two slopes and the
    curvature are fitted to the heights, starting from the least-squares paraboloid.

    Heights have shape (nx, ny), positions (nx, 1) and (1, ny), m. Non-measured points do not count; `InputError` if the
    others do not determine a sphere, or the best sphere does not cover the map.
    """
    from scipy.optimize import least_squares

    length = float(max(np.abs(x).max(), np.abs(y).max()))
    x = x / length
    y = y / length
    mean = float(values.mean())
    heights = (values - mean) / length
    use = slice(None) if non_measured is None else ~non_measured
    square = x**2 + y**2
    # Constant, slopes and curvature enter the paraboloid linearly.
    basis = np.stack([np.broadcast_to(t, values.shape)[use].ravel() for t in (np.ones((1, 1)), x, y, -0.5 * square)])
    goal = heights[use].ravel()
    gram = matrix_product(basis, basis.T)
    if goal.size <= len(gram) or np.linalg.matrix_rank(gram) < len(gram):
        raise InputError(f"{_TOO_FEW_POINTS} a sphere.")
    scale = float(np.ptp(goal)) or 1.0

    def misfit(parameters: Array) -> Array:
        return np.asarray((_cap(parameters, x, y, square)[0][use].ravel() - goal) / scale, dtype=np.float64)

    paraboloid = np.asarray(np.linalg.solve(gram, basis @ goal), dtype=np.float64)
    found = least_squares(
        misfit,
        paraboloid,
        "3-point",
        method="lm",
        ftol=_SPHERE_FIT_TOLERANCE,
        xtol=_SPHERE_FIT_TOLERANCE,
        gtol=_SPHERE_FIT_TOLERANCE,
    )
    fitted, inside = _cap(found.x, x, y, square)
    if not inside:
        raise InputError("No sphere fits the heights: the domain is wider than the best sphere.")
    curvature = float(found.x[3])
    flat = abs(curvature) <= _CURVATURE_ROUNDING * (1.0 + float(np.abs(values).max()) / length)
    return fitted * length + mean, 0.0 if flat else curvature / length


def _cap(parameters: RealArray, x: Array, y: Array, square: Array) -> tuple[Array, bool]:
    """Return the heights of the sphere, beyond its equator those of the equator, and whether all points are inside."""
    c, slope_x, slope_y, curvature = parameters
    normal_z = 1.0 / np.sqrt(1.0 + slope_x**2 + slope_y**2)
    lift = 0.5 * curvature * square - normal_z * (slope_x * x + slope_y * y)
    root = normal_z**2 - 2.0 * curvature * lift
    inside = bool((root > 0.0).all())
    heights = c - 2.0 * lift / (normal_z + np.sqrt(np.maximum(root, 0.0)))
    return np.asarray(heights, dtype=np.float64), inside


def power_spectrum(heights: Array, steepness: int = 4) -> tuple[Array, Array, Array]:
    r"""Return wave numbers qx, qy, shapes (nx, 1) and (1, ny), rad a cell, and the power there, shape (nx, ny), m2.

    The heights, shape (nx, ny), m, less their quadratic form are windowed by a power of the cosine: the 4th, whose
    leakage falls as :math:`q^{-10}`, faster than any spectrum of interest, or the 2nd (Hann), :math:`q^{-6}`, which
    keeps more independent waves. The power is scaled to a map without window.

    References
    ----------
    Jacobs, Junge, Pastewka, Surf. Topogr.: Metrol. Prop. 5 (2017) 013001, https://doi.org/10.1088/2051-672X/aa51f8
    """
    rough = heights - polynomial(heights, FORM_DEGREE, None)
    for axis, count in enumerate(heights.shape):
        window = np.sin(np.pi * (np.arange(count) + 0.5) / count) ** steepness
        rough = rough * np.expand_dims(window / np.sqrt(np.mean(window**2)), 1 - axis)
    power = np.abs(scipy.fft.fft2(rough, norm="forward")) ** 2
    qx, qy = (2.0 * np.pi * scipy.fft.fftfreq(count) for count in heights.shape)
    return qx[:, np.newaxis], qy[np.newaxis, :], power


def mean_in_bands(values: Array, power: Array, edges: Array) -> Array:
    """Return the mean power of the waves whose `values` lie between neighbouring edges; nan where there are none."""
    band = np.digitize(values.ravel(), edges)
    count = np.bincount(band, minlength=edges.size + 1)[1:-1]
    total = np.bincount(band, weights=power.ravel(), minlength=edges.size + 1)[1:-1]
    return np.asarray(np.divide(total, count, out=np.full(count.size, np.nan), where=count > 0))


@attrs.frozen(eq=False)
class PowerLaw:
    """The power of the Fourier modes of a domain: `power` at the wave number `pivot`, falling as q^-`exponent`.

    Attributes
    ----------
    power
        Power in each sector of direction over half a turn, m2.
    pivot
        Wave number, rad/m, at which power and exponent are uncorrelated.
    exponent
        2 + 2 Hurst exponent, on self-affine surfaces.
    power_std, exponent_std
        Standard errors of the logarithm of the power at the pivot, and of the exponent.
    """

    power: Array
    pivot: float
    exponent: float
    power_std: float
    exponent_std: float

    def evaluate(self, qx: Array, qy: Array, deviation: float = 0.0) -> Array:
        """Return the power at wave numbers, rad/m, so many standard errors above the law, m2; zero at zero."""
        q = np.hypot(qx, qy) / self.pivot
        logarithm = np.log(q, out=np.zeros_like(q), where=q > 0.0)
        power = np.exp(deviation * np.hypot(self.power_std, self.exponent_std * logarithm) - self.exponent * logarithm)
        power[q == 0.0] = 0.0
        return np.asarray(power * self.power[_sector(qx, qy)])


def fit_power_law(heights: Array, grid: Grid, shortest: float) -> PowerLaw:
    """Return the power law of the spectrum of heights, shape (nx, ny), m, down to waves of `shortest` m.

    The standard errors account for the independent modes, the misfit of the bands, and the sampling of the map.
    `InputError` if the map is too small, or its spectrum does not fall with the wave number.
    """
    qx, qy, power = power_spectrum(heights, 2)
    qx = qx / grid.spacing[0]
    qy = qy / grid.spacing[1]
    q = np.hypot(qx, qy)
    limit = 2.0 * math.pi / shortest
    start = max(limit / _FIT_RANGE, 2.0 * math.pi * _MIN_WAVES_PER_SIDE / min(grid.size))
    if start * _MIN_FIT_RANGE > limit:
        raise InputError(
            f"The height map of {grid} is too small to extrapolate its spectrum from waves of "
            f"{si(_MIN_FIT_RANGE * shortest, 'm')} to {si(shortest, 'm')}, of which it must hold at least "
            f"{_MIN_WAVES_PER_SIDE:g} a side: give a larger map, or a shorter resolved=."
        )
    edges = np.geomspace(start, limit, _FIT_BANDS + 1)
    mean, squares, centre = (
        mean_in_bands(q, values, edges) for values in (power, power**2, np.log(np.maximum(q, start)))
    )
    if not mean.min() > 0.0:
        raise InputError(f"The height map has no waves of {si(shortest, 'm')}, whose spectrum could be extrapolated.")
    # The mean square of exponentially distributed powers is twice the square of their mean; the modes -q repeat q.
    weight = 2.0 * np.histogram(q, edges)[0] * mean**2 / squares / (2.0 * HANN_DEPENDENCE)
    pivot = float(np.average(centre, weights=weight))
    spread = float(np.sum(weight * (centre - pivot) ** 2))
    # The mean logarithm of the mean of n exponentially distributed powers is too small by 1/(2 n).
    level = np.log(mean) + 0.5 / weight
    exponent = -float(np.sum(weight * (centre - pivot) * level)) / spread
    misfit = level - np.average(level, weights=weight) + exponent * (centre - pivot)
    excess = max(1.0, float(np.sum(weight * misfit**2)) / (_FIT_BANDS - 2))
    if not exponent > 0.0:
        raise InputError(
            f"The spectrum of the height map does not fall with the wave number down to waves of {si(shortest, 'm')}: "
            "they are noise; give the shortest wave that the map resolves, resolved=."
        )
    stds = math.sqrt(excess / float(np.sum(weight))), math.hypot(math.sqrt(excess / spread), _SAMPLING_STD)
    inside = (q >= start) & (q <= limit)
    sector = _sector(qx, qy)[inside]
    scaled = power[inside] * (q[inside] * math.exp(-pivot)) ** exponent
    modes = np.bincount(sector, minlength=_DIRECTION_SECTORS)
    total = np.bincount(sector, weights=scaled, minlength=_DIRECTION_SECTORS)
    return PowerLaw(total / np.maximum(modes, 1), math.exp(pivot), exponent, *stds)


def _sector(qx: Array, qy: Array) -> npt.NDArray[np.intp]:
    angle = np.arctan2(qy, qx) / math.pi
    return np.asarray((angle * _DIRECTION_SECTORS + 0.5).astype(np.intp) % _DIRECTION_SECTORS)
