"""Panels of a surface: map, bearing curve, autocorrelation and power spectrum."""

from __future__ import annotations

import math
from typing import Any, final

import attrs
import numpy as np
import scipy

from roughcontact._base.arrays import Array
from roughcontact._base.units import prefixed, si
from roughcontact._faces.panels.base import Panel
from roughcontact._faces.panels.curves import add_key, scale_axes
from roughcontact._faces.panels.maps import draw_map, mark_non_measured, name_colors
from roughcontact._faces.panels.theme import theme_of
from roughcontact._parts.surfaces import SampledSurface, fill, mean_in_bands, power_spectrum
from roughcontact.errors import InputError
from roughcontact.reference.roughness import bearing_area

# Bands of wave numbers a decade.
_BANDS_PER_DECADE = 8
# Half the angle of the sectors around x and y.
_HALF_SECTOR_ANGLE = math.pi / 8.0
# Power over the maximum power below which it is rounding, or leaks through a window.
_MIN_POWER_RATIO = 1e-12
# Value of the autocorrelation at its length, ISO 25178-2.
_LENGTH_CORRELATION = 0.2
# Number of levels of a bearing curve.
_BEARING_LEVELS = 201
# Rounding of distances, cells.
_DISTANCE_ROUNDING_CELLS = 1e-9


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
        theme = theme_of(axes)
        qx, qy, density = spectral_density(subject)
        q = np.hypot(qx, qy)
        if not density.max() > 0.0:
            raise InputError("The surface is flat, so that it has no spectrum to draw.")
        angle = np.arctan2(np.abs(qy), np.abs(qx))
        # The unit suits the middle of the range.
        factor, unit = prefixed(2.0 * math.pi / math.sqrt(float(q.max()) * float(q[q > 0.0].min())), "m")
        sectors = (
            angle <= _HALF_SECTOR_ANGLE,
            angle >= 0.5 * math.pi - _HALF_SECTOR_ANGLE,
            np.ones(q.shape, dtype=bool),
        )
        names = ("along x", "along y", "all directions")
        for inside, name, color, line in zip(sectors, names, theme.lines[:3], ("-", "-", "--"), strict=True):
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
    count = max(round(_BANDS_PER_DECADE * math.log10(high / low)), 1)
    edges = np.geomspace(low * (1.0 - 1e-9), high, count + 1)
    mean = mean_in_bands(q, density, edges)
    centre = mean_in_bands(q, np.log(q), edges)
    drawn = np.isfinite(mean) & (mean > _MIN_POWER_RATIO * density.max(initial=0.0))
    return np.exp(centre[drawn]), mean[drawn]


def _scale(sampled: SampledSurface) -> tuple[float, str]:
    return prefixed(float(np.nanmax(np.abs(sampled.heights - np.nanmean(sampled.heights)))), "m")


@final
@attrs.frozen
class MapPanel(Panel):
    """The heights about their mean."""

    subject = "surface"

    def draw(self, subject: Any, axes: Any) -> None:
        factor, unit = _scale(subject)
        heights = factor * (subject.heights - np.nanmean(subject.heights))
        draw_map(axes, heights, subject.grid, "height", unit, colors="cividis")
        name_colors(axes, mark_non_measured(axes, np.isnan(heights)))


@final
@attrs.frozen
class BearingCurvePanel(Panel):
    """The Abbott-Firestone curve: the fraction of the heights above a level, with their distribution."""

    subject = "surface"

    def draw(self, subject: Any, axes: Any) -> None:
        theme = theme_of(axes)
        factor, unit = _scale(subject)
        known = subject.heights[np.isfinite(subject.heights)]
        heights = known - known.mean()
        levels = np.linspace(heights.min(), heights.max(), _BEARING_LEVELS)
        if known.size == subject.heights.size and np.ptp(heights) > 0.0:
            curve = bearing_area(subject.heights, levels)
            fractions = curve.fractions
            deviations = curve.uncertainties
        else:
            fractions = 1.0 - np.searchsorted(np.sort(heights), levels, side="right") / heights.size
            deviations = np.zeros(levels.size)
        counts, edges = np.histogram(factor * heights, 40)
        largest = max(int(counts.max()), 1)
        axes.barh(
            edges[:-1], 40.0 * counts / largest, np.diff(edges), align="edge", color=theme.lines[1], alpha=0.45,
            linewidth=0.0, label="distribution",
        )  # fmt: skip
        axes.plot(100.0 * fractions, factor * levels, color=theme.lines[0], label="material ratio")
        low, high = (100.0 * np.clip(fractions + sign * 2.0 * deviations, 0.0, 1.0) for sign in (-1.0, 1.0))
        axes.fill_betweenx(factor * levels, low, high, color=theme.lines[0], alpha=0.25, linewidth=0.0)
        scale_axes(axes, x="material ratio, %", y=f"height, {unit}")
        axes.set_xlim(0.0, 100.0)
        add_key(axes)


@final
@attrs.frozen
class AutocorrelationPanel(Panel):
    """The autocorrelation of the heights along x and y, and its mean over all directions.

    On a map that does not repeat each distance counts the pairs of points that lie on the map, and non-measured points
    count in no pair. The length is that at which the mean first falls to 0.2.
    """

    subject = "surface"

    def draw(self, subject: Any, axes: Any) -> None:
        theme = theme_of(axes)
        dx, dy = subject.grid.spacing
        if not np.nanmax(subject.heights) > np.nanmin(subject.heights):
            raise InputError("The surface is flat, so that it has no autocorrelation to draw.")
        correlation = correlate(subject.heights, subject.periodic)
        nx, ny = correlation.shape
        factor, unit = prefixed(0.5 * max(subject.grid.size), "m")
        along = (np.arange(nx) * dx, correlation[:, 0]), (np.arange(ny) * dy, correlation[0])
        for (distance, values), name, color in zip(along, ("along x", "along y"), theme.lines[:2], strict=True):
            axes.plot(factor * distance, values, color=color, label=name)
        distance, mean = average_radially(correlation, subject.grid.spacing)
        axes.plot(factor * distance, mean, color=theme.lines[2], linestyle="--", label="all directions")
        below = np.flatnonzero(mean <= _LENGTH_CORRELATION)
        if below.size and below[0] > 0:
            ends = [below[0], below[0] - 1]
            length = float(np.interp(_LENGTH_CORRELATION, mean[ends], distance[ends]))
            label = f"{_LENGTH_CORRELATION} at {si(length, 'm', 3)}"
            axes.plot(factor * length, _LENGTH_CORRELATION, "o", color=theme.limit, label=label)
        scale_axes(axes, x=f"distance, {unit}", y="autocorrelation")
        axes.axhline(0.0, color=theme.ink, linewidth=0.5)
        axes.set_xlim(0.0, factor * max(float(distance[-1]), dx))
        add_key(axes)


def correlate(heights: Array, periodic: bool) -> Array:
    """Return the autocorrelation at distances of up to half the domain, shape (nx // 2 + 1, ny // 2 + 1).

    It is one at zero distance and the mean over both signs of one of the distances.
    """
    known = np.isfinite(heights)
    rough = np.where(known, heights - np.nanmean(heights), 0.0)
    shape = tuple(n if periodic else 2 * n for n in heights.shape)

    def pairs(values: Array) -> Array:
        transformed = scipy.fft.rfft2(values, shape)
        return np.asarray(scipy.fft.irfft2(np.abs(transformed) ** 2, shape))

    counts = pairs(known.astype(np.float64))
    full = np.divide(pairs(rough), counts, out=np.zeros(shape), where=counts > 0.5)
    mirrored = 0.5 * (full + np.roll(full[::-1], 1, axis=0))
    nx, ny = (n // 2 + 1 for n in heights.shape)
    return np.asarray(mirrored[:nx, :ny] / full[0, 0])


def average_radially(values: Array, spacing: tuple[float, float]) -> tuple[Array, Array]:
    """Return distances, m, and the mean of values, shape (nx, ny), in complete rings one cell wide."""
    nx, ny = values.shape
    x = np.arange(nx) * spacing[0]
    y = np.arange(ny) * spacing[1]
    step = max(spacing)
    # Distances of a whole number of cells and a half lie in the outer ring, however they are rounded.
    ring = np.floor(np.hypot(x[:, np.newaxis], y) / step + (0.5 + _DISTANCE_ROUNDING_CELLS)).astype(np.intp)
    last = int(max(min(x[-1], y[-1]), step) / step + _DISTANCE_ROUNDING_CELLS)
    # The values cover a quarter of the plane: on the axes each stands for two points, inside for four.
    weight = np.where(np.arange(nx) > 0, 2.0, 1.0)[:, np.newaxis] * np.where(np.arange(ny) > 0, 2.0, 1.0)
    inside = ring <= last
    total, count, radius = (
        np.bincount(ring[inside], weights=(weight * one)[inside], minlength=last + 1)
        for one in (values, np.ones_like(values), np.hypot(x[:, np.newaxis], y))
    )
    there = count > 0.0
    return radius[there] / count[there], total[there] / count[there]
