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
    StressPlanes,
    coarsen,
    is_odd,
    list_loads,
)
from roughcontact._answers.subsurface.free import cell_stress
from roughcontact._answers.subsurface.periodic import find_symbols
from roughcontact._base.arrays import Array, Pair, RealArray, Waves
from roughcontact._base.machine import threads_for
from roughcontact._solve.convolvers import transform_extended

# Distance to the nearest image along the free axis, over the wavelength: the stress falls by exp(-2 pi) on each, and is
# wanted in float32.
_IMAGE_WAVELENGTHS = 3.0
# Length of a strip, in the longest distance from it, that stands for one without ends.
_STRIP_LENGTH = 1e8


@attrs.frozen(eq=False)
class MixedPlanes(StressPlanes):
    """The stress where x is free and y periodic: waves along y, and linear convolution along x.

    The stress of a wave along y falls exponentially along x, so that it is that below a periodic domain which is long
    enough. The mean along y is that of strips in plane strain.

    Attributes
    ----------
    pressure
        Pressure on the cells, float32, shape (nx, ny).
    sides
        Sides of a cell.
    common
        The largest step along x for which `at` is called.
    traction
        Traction on the cells along x and y, float32, shape (2, nx, ny); None without.
    """

    pressure: RealArray
    sides: Pair
    common: int
    traction: RealArray | None = None

    @cached_property
    def padded(self) -> int:
        """Cells along x of the padded grid, an even multiple of the largest step."""
        return 2 * self.common * int(scipy.fft.next_fast_len(-(-self.pressure.shape[0] // self.common), real=True))

    @cached_property
    def waves(self) -> dict[str, Waves]:
        """The waves of the padded loads by their letters, shape (mx, ny // 2 + 1) each."""
        workers = threads_for(self.pressure.size)
        shape = self.padded, self.pressure.shape[1]
        return {
            load: np.asarray(scipy.fft.rfft2(field, s=shape, workers=workers))
            for load, field in list_loads(self.pressure, self.traction).items()
        }

    def at(self, z: float, poisson: float, steps: tuple[int, int]) -> RealArray:
        ny = self.pressure.shape[1]
        shape = self.padded // steps[0], ny // steps[1]
        kept = self.pressure.shape[0] // steps[0]
        sides = steps[0] * self.sides[0], steps[1] * self.sides[1]
        stress = np.zeros((len(COMPONENTS), kept, shape[1]), dtype=np.float32)
        for load, fine in self.waves.items():
            waves = coarsen(coarsen(fine, ny, steps[1], 1), self.padded, steps[0], 0)
            for place, symbol in enumerate(_find_symbols(shape, sides, z, poisson, load)):
                odd_in_x, odd_in_y = (is_odd(axis, COMPONENTS[place], load) for axis in "xy")
                if odd_in_y and shape[1] % 2 == 0:
                    symbol[:, -1] = 0.0
                product = waves * _list_all(symbol, shape[0], odd_in_x)
                if odd_in_x != odd_in_y:
                    product *= 1j
                workers = threads_for(product.size)
                stress[place] += scipy.fft.irfft2(product, s=shape, overwrite_x=True, workers=workers)[:kept]
        return stress


@attrs.frozen(eq=False)
class ExchangedPlanes(StressPlanes):
    """The stress of other planes, whose first axis is y."""

    planes: StressPlanes

    def at(self, z: float, poisson: float, steps: tuple[int, int]) -> RealArray:
        stress = self.planes.at(z, poisson, (steps[1], steps[0]))
        return np.ascontiguousarray(stress[EXCHANGED_COMPONENTS].transpose(0, 2, 1))


def _find_symbols(shape: tuple[int, int], sides: Pair, z: float, poisson: float, load: str) -> list[Array]:
    """Return the factors for each component, shape (mx // 2 + 1, my // 2 + 1); odd along one axis alone lack the i."""
    mx = shape[0]
    count = shape[1] // 2 + 1
    phases = 2.0 * np.pi * np.asarray(np.fft.rfftfreq(shape[1]), dtype=np.float64)
    reach = mx // 2 + 1
    responses = [np.empty((reach, count)) for _ in COMPONENTS]
    length = _STRIP_LENGTH * (mx * sides[0] + z)
    strips = cell_stress(z, poisson, (reach, 1), (sides[0], length), np.float64, load)
    for response, row in zip(responses, strips, strict=True):
        response[:, 0] = row[:, 0]
    first = 1
    while first < count:
        # The images of shorter waves may be nearer: octave by octave.
        last = min(2 * first, count)
        wavelength = 2.0 * np.pi * sides[1] / phases[first]
        cells = reach + math.ceil((_IMAGE_WAVELENGTHS * wavelength + z) / sides[0])
        cells = int(scipy.fft.next_fast_len(cells, real=True))
        along = 2.0 * np.pi * np.asarray(np.fft.rfftfreq(cells), dtype=np.float64)
        # The mean is treated as that of a confined body: its place is taken by a wave that is not used.
        across = np.concatenate(([0.0], phases[first:last]))
        for place, symbol in enumerate(find_symbols((along, across), sides, z, poisson, load)):
            amplitudes = symbol[:, 1:].astype(np.float64)
            odd = is_odd("x", COMPONENTS[place], load)
            if odd and cells % 2 == 0:
                amplitudes[-1] = 0.0
            values = scipy.fft.irfft(1j * amplitudes if odd else amplitudes, n=cells, axis=0)
            responses[place][:, first:last] = values[:reach]
        first = last
    return [
        transform_extended(response, mx, is_odd("x", component, load))
        for component, response in zip(COMPONENTS, responses, strict=True)
    ]


def _list_all(half: Array, length: int, odd: bool) -> RealArray:
    """Return the factors of all waves along x, of which half are given."""
    rows = np.arange(length)
    mirrored = rows > length // 2
    values = half[np.where(mirrored, length - rows, rows)].astype(np.float32)
    if odd:
        values[mirrored] *= -1.0
    return values
