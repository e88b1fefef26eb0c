"""The power spectrum of a surface."""

from __future__ import annotations

import math
from typing import Any, final

import attrs
import numpy as np
import scipy.fft

from roughcontact._base.checks import Array
from roughcontact._base.units import prefixed
from roughcontact._faces.panels.base import Panel
from roughcontact._faces.panels.curves import add_key, scale_axes
from roughcontact._faces.panels.theme import theme_of
from roughcontact._parts.surfaces import SampledSurface, fill, mean_in_bands, power_spectrum
from roughcontact.errors import InputError

# Bands of wave numbers a decade.
_BANDS = 8
# Half the angle of the sectors around x and y.
_SECTOR = math.pi / 8.0
# Power over the largest below which it is rounding, or what a window lets through.
_ROUNDING = 1e-12


@final
@attrs.frozen
class SpectrumPanel(Panel):
    r"""The power spectral density :math:`C(q) = A\,|h_q|^2`, m4, over the wave number.

    With the coefficients :math:`h_q` of the Fourier series on the area A, the mean square height is the integral of C
    over the plane of wave numbers, over :math:`4 \pi^2`. The curves are the means over all directions, and over those
    within 22.5 degrees of x and of y. A map that does not repeat is taken less its quadratic form and through a window;
    non-measured points are filled.

    References
    ----------
    Jacobs, Junge, Pastewka, Surf. Topogr.: Metrol. Prop. 5 (2017) 013001, https://doi.org/10.1088/2051-672X/aa51f8
    """

    subject = "surface"

    def draw(self, subject: Any, axes: Any) -> None:
        """Draw a surface; see `Panel.draw`."""
        theme = theme_of(axes)
        qx, qy, density = spectral_density(subject)
        q = np.hypot(qx, qy)
        if not density.max() > 0.0:
            raise InputError("The surface is flat, so that it has no spectrum to draw.")
        angle = np.arctan2(np.abs(qy), np.abs(qx))
        # The unit suits the middle of the range.
        factor, unit = prefixed(2.0 * math.pi / math.sqrt(float(q.max()) * float(q[q > 0.0].min())), "m")
        sectors = (angle <= _SECTOR, angle >= 0.5 * math.pi - _SECTOR, np.ones(q.shape, dtype=bool))
        styles = (
            ("along x", theme.lines[0], "-"),
            ("along y", theme.lines[1], "-"),
            ("all directions", theme.lines[2], "--"),
        )
        for inside, (name, color, line) in zip(sectors, styles, strict=True):
            centre, mean = average_in_bands(q[inside], density[inside])
            if centre.size:
                axes.plot(
                    centre / factor,
                    mean,
                    linestyle=line,
                    marker="." if centre.size < 3 else "",
                    color=color,
                    label=name,
                )
        scale_axes(axes, x=f"wave number, rad/{unit}", y="power spectral density, m⁴", logarithmic="xy")
        if np.isnan(subject.heights).any():
            axes.plot([], [], " ", label="non-measured points filled")
        add_key(axes)


def spectral_density(sampled: SampledSurface) -> tuple[Array, Array, Array]:
    """Return wave numbers, rad/m, shapes (nx, 1) and (1, ny), and the density there, shape (nx, ny), m4."""
    heights = sampled.heights
    dx, dy = sampled.grid.spacing
    if np.isnan(heights).any():
        heights = fill(heights)
    if sampled.periodic or min(heights.shape) < 4:
        power = np.abs(scipy.fft.fft2(heights - heights.mean(), norm="forward")) ** 2
        qx, qy = (2.0 * np.pi * scipy.fft.fftfreq(count) for count in heights.shape)
        return qx[:, np.newaxis] / dx, qy[np.newaxis] / dy, power * sampled.grid.area
    across, along, power = power_spectrum(heights)
    return across / dx, along / dy, power * sampled.grid.area


def average_in_bands(q: Array, density: Array) -> tuple[Array, Array]:
    """Return wave numbers and the mean density of the waves, shapes (n,), in bands of equal ratio with waves."""
    used = q > 0.0
    q = q[used]
    density = density[used]
    if not q.size:
        return np.empty(0), np.empty(0)
    low = float(q.min())
    high = float(q.max()) * (1.0 + 1e-9)
    count = max(round(_BANDS * math.log10(high / low)), 1)
    edges = np.geomspace(low * (1.0 - 1e-9), high, count + 1)
    mean = mean_in_bands(q, density, edges)
    centre = mean_in_bands(q, np.log(q), edges)
    drawn = np.isfinite(mean) & (mean > _ROUNDING * density.max(initial=0.0))
    return np.exp(centre[drawn]), mean[drawn]
