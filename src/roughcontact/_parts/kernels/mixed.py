"""Coefficients along a free axis for the waves of a periodic one, from the spectrum of a kernel."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeAlias

import numpy as np
import scipy

from roughcontact._base.arrays import Array, Pair, RealArray
from roughcontact._parts.kernels.cells import alias_sum

# Spectrum of a kernel: a function of the wave numbers along x, shape (m, 1), along y, (1, n), and the sides of a cell.
Spectrum: TypeAlias = Callable[[Array, Array, Pair], Array]

# Distance to the nearest image along the free axis, over the wavelength: the response falls by exp(-2 pi) on each.
_IMAGE_WAVELENGTHS = 6.0
# Cells over those of the domain in the sum for uniform pressure, whose rest falls as the square, and their maximum.
_UNIFORM_FACTOR = 64
_MAX_UNIFORM_CELLS = 2**20
# Wave number, times the length of the domain, at which the spectrum is that of the far field.
_FAR_PHASE = 1e-7
# Response beside the far field of a homogeneous half-space, relative, that is rounding.
_ROUNDING = 1e-13


def mixed_coefficients(
    spectrum: Spectrum,
    cells: int,
    waves: Array,
    spacing: Pair,
    datum: float,
    *,
    odd: bool = False,
    part: slice = slice(None),
) -> Array:
    r"""Return the response along a free x to pressure waves along y on one row of cells, shape (cells, n).

    It is the sum over the waves of a periodic domain that is so long that its images do not act,

    .. math:: c_i(q_y) = \frac{1}{m} \sum_{q_x} \hat K(q_x, q_y) \cos(q_x i\,\Delta x),

    and for a uniform pressure, :math:`q_y = 0`, that of the strip of a plane half-space,

    .. math:: c_i(0) = -\frac{A}{\pi} \int_{x_i - \Delta x/2}^{x_i + \Delta x/2} \ln\frac{|s|}{D}\,\mathrm{d}s,

    with :math:`A = \lim |q_x| \hat K(q_x, 0)` and the distance D at which the displacement is taken as zero, because
    that of a line load has no limit (Johnson, Contact Mechanics (1985), sec. 2.3,
    https://doi.org/10.1017/CBO9781139171731). What a kernel has beside this far field is summed over waves too.

    Parameters
    ----------
    spectrum
        The spectrum of the kernel, m/Pa.
    cells
        Number of offsets along x.
    waves
        Wave numbers along y, ascending from zero, shape (n,), rad/m.
    spacing
        Sides of a cell (dx, dy), m.
    datum
        The distance D, m.
    odd
        Whether the response is odd in x: the sum is then one of sines, with a minus sign.
    part
        The waves of which it is returned, neighbours.
    """
    start, stop, _ = part.indices(waves.size)
    result: Array = np.empty((1, cells, stop - start))
    if start == 0 < stop:
        result[0, :, 0] = _respond_to_uniform(spectrum, cells, spacing, datum, odd)

    def find_amplitudes(along: Array, across: Array) -> Array:
        return spectrum(along, across, spacing)[np.newaxis]

    set_octaves(result, find_amplitudes, waves, spacing[0], (odd,), _IMAGE_WAVELENGTHS, part=slice(start, stop))
    return np.asarray(result[0])


def set_octaves(
    result: RealArray,
    find_amplitudes: Callable[[Array, Array], RealArray],
    waves: Array,
    step: float,
    odd: Sequence[bool],
    wavelengths: float,
    *,
    beyond: float = 0.0,
    part: slice,
) -> None:
    """Set the responses along a free axis to waves along the periodic one, but to the uniform load.

    Parameters
    ----------
    result
        The responses, shape (k, cells, n).
    find_amplitudes
        Function of wave numbers along both axes, shapes (m, 1) and (1, n), that returns the amplitudes, (k, m, n).
    waves
        Wave numbers along the periodic axis, ascending from zero, rad/m.
    step
        Side of a cell along the free axis, m.
    odd
        Whether each of the responses is odd along the free axis.
    wavelengths, beyond
        Distance to the nearest image along it, in wavelengths, and in m beyond these.
    part
        The waves of which it is found, neighbours, with a start and a stop.
    """
    cells = result.shape[1]
    for octave in list_octaves(waves.size):
        own = slice(max(octave.start, part.start), min(octave.stop, part.stop))
        if own.start >= own.stop:
            continue
        length = wavelengths * 2.0 * np.pi / waves[octave.start] + beyond
        count = scipy.fft.next_fast_len(cells + int(np.ceil(length / step)), real=True)
        amplitudes = find_amplitudes(_list_waves(count, step), waves[np.newaxis, own])
        columns = slice(own.start - part.start, own.stop - part.start)
        for response, one, is_odd in zip(result, amplitudes, odd, strict=True):
            response[:, columns] = _sum_along_x(one.astype(np.float64, copy=False), count, is_odd)[:cells]


def list_octaves(count: int) -> list[slice]:
    """Return the octaves of the waves 1 .. count - 1: the images of shorter waves may be nearer."""
    starts = 2 ** np.arange(max(count - 1, 0).bit_length())
    return [slice(start, min(2 * start, count)) for start in starts.tolist()]


def _list_waves(count: int, step: float) -> Array:
    waves = 2.0 * np.pi / step * np.asarray(scipy.fft.rfftfreq(count), dtype=np.float64)
    return np.asarray(waves[:, np.newaxis])


def _sum_along_x(amplitudes: Array, count: int, odd: bool) -> Array:
    """Return the sum of waves along the first axis at `count` cells: of cosines or, if odd, minus that of sines."""
    return np.asarray(scipy.fft.irfft(1j * amplitudes if odd else amplitudes, n=count, axis=0))


def _respond_to_uniform(spectrum: Spectrum, cells: int, spacing: Pair, datum: float, odd: bool) -> Array:
    """Return the response to pressure on a strip along y, shape (cells,)."""
    none = np.zeros((1, 1))
    step = spacing[0]
    small = _FAR_PHASE / (cells * step)
    # The limit from two waves, because it vanishes on a layer with a rigid base; the shortest wave tells the scale.
    phases = np.array([[small], [2.0 * small], [np.pi / step]])
    one, other, _ = (phases * spectrum(phases, none, spacing))[:, 0].tolist()
    far = 2.0 * one - other
    plane = _respond_to_strip(cells, far * step, datum / step, odd)

    def find_rest(waves: Array) -> Array:
        rest = spectrum(waves, none, spacing)[:, 0]
        largest = float(np.abs(rest).max())
        rest[1:] -= _sample_far_field(waves[1:, 0] * step, far * step, odd)
        return np.asarray(rest[np.newaxis] * (np.abs(rest[1:]).max(initial=0.0) > _ROUNDING * largest))

    return np.asarray(plane + sum_rest(find_rest, cells, step, (odd,))[0])


def sum_rest(find_rest: Callable[[Array], RealArray], cells: int, step: float, odd: Sequence[bool]) -> Array:
    """Return the responses along a free axis to a uniform load on a row of cells, beside known ones, shape (k, cells).

    Parameters
    ----------
    find_rest
        Function of wave numbers along the free axis, shape (m, 1), the mean first, that returns what the amplitudes
        have beside known ones, shape (k, m); that of the mean is not used.
    cells, step
        Number of offsets along the axis, and side of a cell, m.
    odd
        Whether each of the responses is odd along it.
    """
    count = scipy.fft.next_fast_len(min(_UNIFORM_FACTOR * cells, _MAX_UNIFORM_CELLS), real=True)
    sums = []
    for number in (count, 2 * count):
        rest = find_rest(_list_waves(number, step)).astype(np.float64, copy=False)
        if not rest.any():
            return np.zeros((len(odd), cells))
        # The mean wave by a parabola through the next three.
        rest[:, 0] = np.where(odd, 0.0, 3.0 * rest[:, 1] - 3.0 * rest[:, 2] + rest[:, 3])
        sums.append(
            np.array([_sum_along_x(one, number, is_odd)[:cells] for one, is_odd in zip(rest, odd, strict=True)])
        )
    return np.asarray((4.0 * sums[1] - sums[0]) / 3.0)


def _respond_to_strip(cells: int, far: float, datum: float, odd: bool) -> Array:
    """Return the response of a half-space in plane strain to a strip one cell wide; the datum is in cells."""
    offset = np.arange(1.0, cells)
    if odd:
        # Both sides of the strip move by the same amount, in opposite directions.
        return np.concatenate(([0.0], np.full(cells - 1, -0.5 * far)))
    half = 0.5 / offset
    # The mean of ln|s| over a cell, less ln of the distance of its centre.
    excess = offset * ((1.0 + half) * np.log1p(half) - (1.0 - half) * np.log1p(-half)) - 1.0
    mean = np.concatenate(([np.log(2.0 * datum) + 1.0], np.log(datum / offset) - excess))
    return np.asarray(far / np.pi * mean)


def _sample_far_field(phases: Array, far: float, odd: bool) -> Array:
    """Return the spectrum of `_respond_to_strip`, at phases per cell."""
    return np.asarray(far * alias_sum(phases, np.zeros(1), 1.0, "x/k2" if odd else "1/k")[:, 0])
