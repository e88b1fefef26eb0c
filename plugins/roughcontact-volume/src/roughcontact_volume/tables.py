"""The stress below pressed cells of a free half-space, mean over each layer, and its transpose: no images."""

from __future__ import annotations

import math
from functools import cached_property

import attrs
import numpy as np
import scipy.fft
from roughcontact.solving import map_tiles
from roughcontact.typing import Array, Pair

from roughcontact_volume.spectra import Waves

# Whether a component is odd along x and along y: xx, yy, zz, yz, xz, xy.
_ODD = ((False, False), (False, False), (False, False), (False, True), (True, False), (True, True))
_WEIGHTS = (1.0, 1.0, 1.0, 2.0, 2.0, 2.0)


def mean_stress_below_cell(top: float, bottom: float, poisson: float, shape: tuple[int, int], sides: Pair) -> Array:
    r"""Return the mean over a layer of the stress by unit pressure on a cell, at offsets from it, shape (6, nx, ny).

    With the corners :math:`X, Y` of the cell seen from the point, :math:`R^2 = X^2 + Y^2 + z^2` and
    :math:`L_X = \operatorname{arsinh}(Y / \sqrt{X^2 + z^2})`, Love's terms have the integrals over the depth

    .. math:: \int \arctan\frac{XY}{zR}\,dz &= z \arctan\frac{XY}{zR} - X L_X - Y L_Y, \quad
              \int \frac{z X Y}{R (X^2 + z^2)}\,dz = -X L_X, \\
              \int \frac{z^2 X}{R (Y^2 + z^2)}\,dz &= X \operatorname{arsinh}\frac{z}{\sqrt{X^2 + Y^2}}
              - Y \arctan\frac{XZ}{YR}, \quad \int \ln(R + z)\,dz = z \ln(R + z) - R.

    Parameters
    ----------
    top, bottom
        Depths of the layer, in the unit of the sides.
    poisson
        Poisson's ratio.
    shape
        Offsets (nx, ny) of the point from the centre of the cell: 0 .. nx-1 cells along x, 0 .. ny-1 along y.
    sides
        Sides of the cell.

    References
    ----------
    Love, Phil. Trans. R. Soc. A 228 (1929) 377-420, https://doi.org/10.1098/rsta.1929.0009
    """
    x, y = (np.asarray((np.arange(n + 1.0) - 0.5) * side) for n, side in zip(shape, sides, strict=True))
    x, y = x[:, np.newaxis], y[np.newaxis, :]
    table = np.empty((6, *shape))
    factor = 0.5 / (math.pi * (bottom - top))
    upper = _integrate_corners(x, y, top, poisson)
    for place, lower in enumerate(_integrate_corners(x, y, bottom, poisson)):
        lower -= upper[place]
        across = lower[1:] - lower[:-1]
        np.multiply(across[:, 1:] - across[:, :-1], factor, out=table[place])
    return table


def _integrate_corners(x: Array, y: Array, z: float, poisson: float) -> tuple[Array, ...]:
    """Return the integrals over the depth of a corner's terms, without functions of (x, z) or of (y, z) alone."""
    square = x * x + y * y
    r = np.sqrt(square + z * z)
    log_x = x * np.arcsinh(y / np.hypot(x, z))
    log_y = y * np.arcsinh(x / np.hypot(y, z))
    slope = np.arcsinh(z / np.sqrt(square))
    angle = z * np.arctan2(x * y, z * r)
    # The difference of both arc tangents as one of them, R - z without cancellation.
    turn = z * np.arctan(x * y * (square / (r + z)) / (x * x * r + z * (y * y)))
    shear = 1.0 - 2.0 * poisson
    v = angle - log_x - log_y
    c = shear * (turn - log_x)
    return (
        -log_x - 2.0 * poisson * v - c,
        -log_y - v + c,
        2.0 * (log_x + log_y) - angle,
        x * slope - y * np.arctan(x * z / (y * r)),
        y * slope - x * np.arctan(y * z / (x * r)),
        -(shear * (z * np.log(r + z) - r) + r),
    )


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
    """

    shape: tuple[int, int]
    spacing: Pair
    thicknesses: Array
    poisson: float

    @property
    def half(self) -> tuple[int, int]:
        """Half the cells of the padded domain."""
        half_x, half_y = (int(scipy.fft.next_fast_len(n, real=True)) for n in self.shape)
        return half_x, half_y

    @cached_property
    def _padded(self) -> tuple[int, int]:
        return 2 * self.half[0], 2 * self.half[1]

    @cached_property
    def _spectra(self) -> Array:
        """Spectra for wave numbers of one sign, shape (nz, 6, m / 2 + 1, n / 2 + 1); of shears with z over -i."""
        half_x, half_y = self.half
        depths = np.concatenate(([0.0], np.cumsum(self.thicknesses))) / self.spacing[0]
        sides = 1.0, self.spacing[1] / self.spacing[0]
        spectra = np.zeros((self.thicknesses.size, 6, half_x + 1, half_y + 1))

        def work(layer: int) -> None:
            table = mean_stress_below_cell(depths[layer], depths[layer + 1], self.poisson, self.shape, sides)
            for component, odd, spectrum in zip(table, _ODD, spectra[layer], strict=True):
                waves = _transform(_transform(component, half_y, odd[1], 1), half_x, odd[0], 0)
                spectrum[...] = waves if odd != (True, True) else -waves

        map_tiles(work, range(self.thicknesses.size))
        return spectra

    def _multiply(self, waves: Waves, layer: int, place: int, weight: float = 1.0) -> Waves:
        """Return waves times the spectrum of a component, without the imaginary unit of shears with z."""
        half_x = self.half[0]
        spectrum = self._spectra[layer, place]
        product = np.empty_like(waves)
        np.multiply(waves[: half_x + 1], spectrum, out=product[: half_x + 1])
        mirrored = spectrum[half_x - 1 : 0 : -1]
        np.multiply(waves[half_x + 1 :], -mirrored if _ODD[place][0] else mirrored, out=product[half_x + 1 :])
        product *= weight
        return product

    def press(self, pressure: Array) -> Array:
        """Return the stress by a pressure, shape (6, nz, nx, ny), Pa."""
        nx, ny = self.shape
        waves = self._transform_plane(pressure)
        turned: Waves = -1j * waves
        stress = np.empty((6, self.thicknesses.size, nx, ny))

        def work(layer: int) -> None:
            for place in range(6):
                product = self._multiply(turned if place in (3, 4) else waves, layer, place)
                stress[place, layer] = self._transform_back(product)

        self._spectra  # noqa: B018 - by all threads
        map_tiles(work, range(self.thicknesses.size))
        return stress

    def displace(self, strain: Array) -> Array:
        """Return the displacement of the surface by an eigenstrain, positive into the body, shape (nx, ny), m."""
        layers = [layer for layer in range(self.thicknesses.size) if strain[:, layer].any()]

        def work(layer: int) -> Waves:
            shape = self._padded[0], self.half[1] + 1
            plain: Waves = np.zeros(shape, dtype=np.complex128)
            turned: Waves = np.zeros(shape, dtype=np.complex128)
            for place in range(6):
                if strain[place, layer].any():
                    waves = self._transform_plane(strain[place, layer])
                    total = turned if place in (3, 4) else plain
                    total += self._multiply(waves, layer, place, self.thicknesses[layer] * _WEIGHTS[place])
            turned *= 1j
            plain += turned
            return plain

        if not layers:
            return np.zeros(self.shape)
        self._spectra  # noqa: B018 - by all threads
        found = map_tiles(work, layers)
        return self._transform_back(sum(found[1:], found[0]))

    def _transform_plane(self, plane: Array) -> Waves:
        mx, my = self._padded
        return np.asarray(scipy.fft.fft(scipy.fft.rfft(plane, n=my, axis=1), n=mx, axis=0))

    def _transform_back(self, waves: Waves) -> Array:
        nx, ny = self.shape
        rows = scipy.fft.ifft(waves, axis=0, overwrite_x=True)[:nx]
        return np.asarray(scipy.fft.irfft(rows, n=self._padded[1], axis=1)[:, :ny])


def _transform(offsets: Array, half: int, odd: bool, axis: int) -> Array:
    """Return the spectrum, of an odd table over -i, of wave numbers 0 .. half on a period of twice as many cells."""
    count = offsets.shape[axis]
    before = 1 if odd else 0
    kept = offsets[1:] if odd and axis == 0 else offsets[:, 1:] if odd else offsets
    length = half - 1 if odd else half + 1
    pads = [(0, 0), (0, 0)]
    pads[axis] = (0, length - (count - before))
    padded = np.pad(kept, pads)
    if not odd:
        return np.asarray(scipy.fft.dct(padded, type=1, axis=axis))
    pads[axis] = (1, 1)
    return np.asarray(np.pad(scipy.fft.dst(padded, type=1, axis=axis) if length else padded, pads))
