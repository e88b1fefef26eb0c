"""The stress by a pressure on a free domain, or one free along an axis, and its transpose: no images."""

from __future__ import annotations

from functools import cached_property

import attrs
import numpy as np
import scipy.fft
from roughcontact.solving import map_tiles
from roughcontact.typing import Array, Pair

from roughcontact_volume.love import ODD, mean_stress_below_cell, mean_stress_below_row
from roughcontact_volume.spectra import Waves, cut_layers

# Places of the components after an exchange of the axes.
_EXCHANGED = [1, 0, 2, 4, 3, 5]
_WEIGHTS = (1.0, 1.0, 1.0, 2.0, 2.0, 2.0)


@attrs.frozen(eq=False)
class PressureTables:
    """The stress of a pressure on a free half-space, mean over each layer, and its transpose.

    Attributes
    ----------
    shape, spacing
        Cells of the domain, and their sides, m.
    thicknesses
        Thicknesses of the layers, shape (nz,), m.
    poisson
        Poisson's ratio.
    repeats
        Whether the domain repeats along x, and along y: not along both.
    """

    shape: tuple[int, int]
    spacing: Pair
    thicknesses: Array
    poisson: float

    repeats: tuple[bool, bool] = (False, False)

    @cached_property
    def _padded(self) -> tuple[int, int]:
        """Cells of the period: along a free axis twice as many as there are, at least."""
        mx, my = (
            n if repeats else 2 * int(scipy.fft.next_fast_len(n, real=True))
            for n, repeats in zip(self.shape, self.repeats, strict=True)
        )
        return mx, my

    @property
    def kept_bytes(self) -> int:
        """Bytes of the tables."""
        mx, my = self._padded
        return 8 * 6 * self.thicknesses.size * (mx // 2 + 1) * (my // 2 + 1)

    @cached_property
    def _spectra(self) -> Array:
        """Spectra for wave numbers of one sign, real or over -i, shape (6, nz, mx // 2 + 1, my // 2 + 1)."""
        mx, my = self._padded
        depths = np.concatenate(([0.0], np.cumsum(self.thicknesses)))
        spectra = np.empty((6, self.thicknesses.size, mx // 2 + 1, my // 2 + 1))

        def work(layer: int) -> None:
            table = self._find_table(depths[layer], depths[layer + 1])
            for component, odd, spectrum in zip(table, ODD, spectra[:, layer], strict=True):
                waves = component
                for axis in (1, 0):
                    waves = _transform(waves, self._padded[axis], odd[axis], axis)
                # Odd along both axes it is over the square of -i.
                spectrum[...] = waves if odd != (True, True) else -waves

        map_tiles(work, range(self.thicknesses.size))
        return spectra

    def _find_table(self, top: float, bottom: float) -> Array:
        """Return the stress at offsets from a cell, shape (6, nx, ny)."""
        dx, dy = self.spacing
        find = mean_stress_below_row if any(self.repeats) else mean_stress_below_cell
        if self.repeats[0]:
            table = find(top / dy, bottom / dy, self.poisson, self.shape[::-1], (1.0, dx / dy))
            return table[_EXCHANGED].transpose(0, 2, 1)
        return find(top / dx, bottom / dx, self.poisson, self.shape, (1.0, dy / dx))

    @property
    def _blocks(self) -> list[slice]:
        """The layers that are transformed at once."""
        return cut_layers(self.thicknesses.size, self._padded[0] * self._padded[1])

    def _multiply(self, waves: Waves, layers: slice, place: int) -> Waves:
        """Return waves times the spectra of a component in some layers, of shears with z over -i."""
        mx = self._padded[0]
        count = mx // 2 + 1
        spectra = self._spectra[place, layers]
        product = np.empty((len(spectra), *waves.shape[-2:]), dtype=np.complex128)
        np.multiply(waves[..., :count, :], spectra, out=product[:, :count])
        mirrored = spectra[:, (mx - 1) // 2 : 0 : -1]
        np.multiply(waves[..., count:, :], -mirrored if ODD[place][0] else mirrored, out=product[:, count:])
        return product

    def press(self, pressure: Array) -> Array:
        """Return the stress by a pressure, shape (6, nz, nx, ny), Pa."""
        waves = self._transform_planes(pressure)
        turned: Waves = -1j * waves
        stress = np.empty((6, self.thicknesses.size, *self.shape))

        def work(layers: slice) -> None:
            for place in range(6):
                product = self._multiply(turned if place in (3, 4) else waves, layers, place)
                stress[place, layers] = self._transform_back(product)

        self._spectra  # noqa: B018 - by all threads
        map_tiles(work, self._blocks)
        return stress

    def displace(self, strain: Array) -> Array:
        """Return the displacement of the surface by an eigenstrain, positive into the body, shape (nx, ny), m."""
        blocks = [layers for layers in self._blocks if strain[:, layers].any()]

        def work(layers: slice) -> Waves:
            shape = self._padded[0], self._padded[1] // 2 + 1
            plain: Waves = np.zeros(shape, dtype=np.complex128)
            turned: Waves = np.zeros(shape, dtype=np.complex128)
            for place in range(6):
                if strain[place, layers].any():
                    weights = _WEIGHTS[place] * self.thicknesses[layers, np.newaxis, np.newaxis]
                    waves = self._transform_planes(weights * strain[place, layers])
                    total = turned if place in (3, 4) else plain
                    for product in self._multiply(waves, layers, place):
                        total += product
            turned *= 1j
            plain += turned
            return plain

        if not blocks:
            return np.zeros(self.shape)
        self._spectra  # noqa: B018 - by all threads
        found = map_tiles(work, blocks)
        return self._transform_back(sum(found[1:], found[0]))

    def _transform_planes(self, planes: Array) -> Waves:
        mx, my = self._padded
        return np.asarray(scipy.fft.fft(scipy.fft.rfft(planes, n=my), n=mx, axis=-2))

    def _transform_back(self, waves: Waves) -> Array:
        nx, ny = self.shape
        rows = scipy.fft.ifft(waves, axis=-2, overwrite_x=True)[..., :nx, :]
        return np.asarray(scipy.fft.irfft(rows, n=self._padded[1])[..., :ny])


def _transform(offsets: Array, period: int, odd: bool, axis: int) -> Array:
    """Return the spectrum along an axis, of an odd table over -i, for wave numbers 0 .. period // 2.

    Parameters
    ----------
    offsets
        A table for offsets 0 .. n - 1: all of the period, or less than half of them, whose mirror image follows.
    period
        Cells of the period.
    odd
        Whether the table is odd in the offset.
    axis
        The axis of the offsets.
    """
    count = offsets.shape[axis]
    if count == period:
        waves = scipy.fft.rfft(offsets, axis=axis)
        return np.asarray(-waves.imag if odd else waves.real)
    pads = [(0, 0), (0, 0)]
    pads[axis] = (0, period // 2 + 1 - count)
    padded = np.pad(offsets, pads)
    if not odd:
        return np.asarray(scipy.fft.dct(padded, type=1, axis=axis))
    inner = padded[1:-1] if axis == 0 else padded[:, 1:-1]
    pads[axis] = (1, 1)
    return np.pad(scipy.fft.dst(inner, type=1, axis=axis) if inner.size else inner, pads)
