"""Stress below a load on a domain that is free along one axis and periodic along the other."""

from __future__ import annotations

import math
from functools import cached_property

import attrs
import numpy as np
import scipy.fft

from roughcontact._answers.subsurface.field import (
    COMPONENTS,
    EXCHANGED_COMPONENTS,
    LoadedPlanes,
    StressPlanes,
    is_odd,
)
from roughcontact._answers.subsurface.free import cell_stress
from roughcontact._answers.subsurface.periodic import add_stress, find_symbols
from roughcontact._base.arrays import Pair, RealArray, Waves
from roughcontact._parts.kernels import list_octaves, sum_along_x
from roughcontact._solve.convolvers import list_all_waves, transform_extended

# Distance to the nearest image along the free axis, over the wavelength: the stress falls by exp(-2 pi) on each, and is
# wanted in float32.
_IMAGE_WAVELENGTHS = 3.0
# Length of a strip, in the longest distance from it, that stands for one without ends.
_STRIP_LENGTH = 1e8


@attrs.frozen(eq=False)
class MixedPlanes(LoadedPlanes):
    """The stress where x is free and y periodic: waves along y, and linear convolution along x.

    The stress of a wave along y falls exponentially along x, so that it is that below a periodic domain which is long
    enough. The mean along y is that of strips in plane strain.

    Attributes
    ----------
    common
        The largest step along x for which `at` is called.
    """

    common: int = 1

    @cached_property
    def padded(self) -> tuple[int, int]:
        """Cells of the padded grid: along x an even multiple of the largest step."""
        nx, ny = self.pressure.shape
        return 2 * self.common * int(scipy.fft.next_fast_len(-(-nx // self.common), real=True)), ny

    def add(
        self, stress: RealArray, load: str, waves: Waves, shape: tuple[int, int], sides: Pair, z: float, poisson: float
    ) -> None:
        add_stress(stress, waves, _find_symbols(shape, sides, z, poisson, load), load, shape)


@attrs.frozen(eq=False)
class ExchangedPlanes(StressPlanes):
    """The stress of other planes, whose first axis is y."""

    planes: StressPlanes

    def at(self, z: float, poisson: float, steps: tuple[int, int]) -> RealArray:
        stress = self.planes.at(z, poisson, (steps[1], steps[0]))
        return np.ascontiguousarray(stress[EXCHANGED_COMPONENTS].transpose(0, 2, 1))


def _find_symbols(shape: tuple[int, int], sides: Pair, z: float, poisson: float, load: str) -> list[RealArray]:
    """Return the factors for each component, shape (mx, my // 2 + 1); those odd along one axis alone lack the i."""
    mx = shape[0]
    count = shape[1] // 2 + 1
    phases = 2.0 * np.pi * np.asarray(np.fft.rfftfreq(shape[1]), dtype=np.float64)
    reach = mx // 2 + 1
    responses = [np.empty((reach, count)) for _ in COMPONENTS]
    length = _STRIP_LENGTH * (mx * sides[0] + z)
    strips = cell_stress(z, poisson, (reach, 1), (sides[0], length), np.float64, load)
    for response, row in zip(responses, strips, strict=True):
        response[:, 0] = row[:, 0]
    for octave in list_octaves(count):
        wavelength = 2.0 * np.pi * sides[1] / phases[octave.start]
        cells = reach + math.ceil((_IMAGE_WAVELENGTHS * wavelength + z) / sides[0])
        cells = int(scipy.fft.next_fast_len(cells, real=True))
        along = 2.0 * np.pi * np.asarray(np.fft.rfftfreq(cells), dtype=np.float64)
        # The mean is treated as that of a confined body: its place is taken by a wave that is not used.
        across = np.concatenate(([0.0], phases[octave]))
        for place, symbol in enumerate(find_symbols((along, across), sides, z, poisson, load)):
            odd = is_odd("x", COMPONENTS[place], load)
            responses[place][:, octave] = sum_along_x(symbol[:, 1:].astype(np.float64), cells, odd)[:reach]
    odd_in_x = (is_odd("x", component, load) for component in COMPONENTS)
    return [
        list_all_waves(transform_extended(response, mx, odd).astype(np.float32), mx, odd)
        for response, odd in zip(responses, odd_in_x, strict=True)
    ]
