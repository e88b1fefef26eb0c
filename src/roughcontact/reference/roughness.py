"""Spectral moments of heights, and what follows from them about summits."""

from __future__ import annotations

import math

import attrs
import numpy as np

from roughcontact._base.checks import Array, heights_array
from roughcontact._base.units import Estimate
from roughcontact._parts.grid import Grid
from roughcontact.errors.door import guarded
from roughcontact.reference.waves import Waves, list_waves


@guarded
@attrs.frozen
class Roughness:
    """Spectral moments of heights, and the summits of a Gaussian surface with these moments.

    Each uncertainty is that of sampling: the standard deviation over Gaussian surfaces of the same spectrum and size.

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
    """
    waves = list_waves(heights, grid, periodic)
    unit = waves.height
    cell = waves.cell
    square = waves.square
    weights = (np.ones_like(square), 0.5 * square, 0.375 * square**2)
    m0, m2, m4 = (waves.sum(weight) for weight in weights)
    relative = [weight / moment for weight, moment in zip(weights, (m0, m2, m4), strict=True)]

    def estimate(value: float, powers: tuple[float, float, float], label: str) -> Estimate:
        """Return a number that depends on the moments by these powers."""
        change = sum(power * weight for power, weight in zip(powers, relative, strict=True))
        return Estimate(value, abs(value) * waves.spread(change), label)

    alpha = m0 * m4 / m2**2
    # d ln(deviation) / d ln(alpha); below alpha = 1.5 no isotropic surface lies.
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
    third, fourth = (float(np.einsum("ij,ij->", square, other)) / rough.size for other in (rough, square))
    return third / second**1.5, fourth / second**2


def find_lay(waves: Waves) -> float:
    """Return the ratio of the larger to the smaller rms slope along two perpendicular directions; 1 if isotropic."""
    xx, yy, xy = (waves.sum(weight) for weight in (waves.qx**2, waves.qy**2, waves.qx * waves.qy))
    middle = 0.5 * (xx + yy)
    half = math.hypot(0.5 * (xx - yy), xy)
    return math.sqrt((middle + half) / max(middle - half, 1e-12 * middle))
