"""Periods of a body's surface: fields transformed in blocks of planes, and swept in tiles of wave vectors."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import TypeAlias

import attrs
import numpy as np
import numpy.typing as npt
import scipy.fft
from roughcontact.solving import map_tiles
from roughcontact.typing import Array, Pair, RealArray

from roughcontact_volume.waves import WaveVectors, find_means, sweep

Waves: TypeAlias = npt.NDArray[np.complexfloating]

# Values of a tile of wave vectors, about: a layer of it stays in the cache.
_TILE_WAVES = 2**12
# Values of the planes that are transformed at once, about: fewer are mostly calls.
_BLOCK_VALUES = 2**14
# Places of the shears with z, which are divided by the imaginary unit.
_TURNED = (3, 4)


def cut_layers(layers: int, plane: int) -> list[slice]:
    """Return the layers in the blocks in which they are transformed, of planes of so many values."""
    deep = max(1, _BLOCK_VALUES // plane)
    return [slice(start, min(start + deep, layers)) for start in range(0, layers, deep)]


@attrs.frozen(eq=False)
class Period:
    """One period of layers of a half-space, of which a field fills a corner.

    Attributes
    ----------
    shape
        Cells of the period (mx, my).
    spacing
        Sides of a cell, m.
    thicknesses
        Thicknesses of the layers, shape (nz,), m.
    poisson
        Poisson's ratio.
    dtype
        Precision inside.
    weigh
        A factor of waves by their wave vectors, shapes (m, 1) and (n,), rad/m; None: 1.
    """

    shape: tuple[int, int]
    spacing: Pair
    thicknesses: Array
    poisson: float
    dtype: type[np.floating] = np.float64
    weigh: Callable[[Array, Array], Array] | None = None

    @cached_property
    def wave_numbers(self) -> tuple[Array, Array]:
        """Wave numbers along x, of both signs, and along y, shapes (mx,) and (my // 2 + 1,), rad/m."""
        (mx, my), (dx, dy) = self.shape, self.spacing
        along_x, along_y = np.fft.fftfreq(mx), np.fft.rfftfreq(my)
        return np.asarray(2.0 * np.pi * along_x / dx), np.asarray(2.0 * np.pi * along_y / dy)

    def bytes_for(self, rows: int) -> int:
        """Return the bytes that the waves of a field take, and one tile of them, with so many rows of cells along x."""
        value = np.dtype(self.dtype).itemsize
        mx, my = self.shape
        layer = 12 * self.thicknesses.size * value
        columns = max(1, _TILE_WAVES // mx)
        # A tile is held as it is transformed, by parts and as waves upwards; a single one keeps its wave vectors.
        return layer * (rows * (my // 2 + 1) + 5 * mx * columns)

    def find_stress(self, strain: RealArray) -> Array:
        """Return the residual stress over twice the shear modulus, shape (6, nz, nx, ny), nx <= mx and ny <= my.

        Parameters
        ----------
        strain
            Eigenstrain, shape (6, nz, nx, ny), in one corner of the period.
        """
        components, layers, nx, ny = strain.shape
        mx, my = self.shape
        rows = np.zeros((components, layers, nx, my // 2 + 1), dtype=np.result_type(self.dtype, 1j))
        blocks = self._list_blocks(components, layers, nx)

        def transform(block: tuple[slice, slice]) -> None:
            if strain[block].any():
                rows[block] = scipy.fft.rfft(strain[block].astype(self.dtype, copy=False), n=my)

        def respond(columns: slice) -> None:
            waves = scipy.fft.fft(rows[..., columns], n=mx, axis=2)
            self._respond(waves, columns)
            rows[..., columns] = scipy.fft.ifft(waves, axis=2, overwrite_x=True)[:, :, :nx]

        stress = np.empty(strain.shape)

        def transform_back(block: tuple[slice, slice]) -> None:
            stress[block] = scipy.fft.irfft(rows[block], n=my)[..., :ny]

        map_tiles(transform, blocks)
        map_tiles(respond, self._list_tiles())
        map_tiles(transform_back, blocks)
        return stress

    def _list_blocks(self, components: int, layers: int, rows: int) -> list[tuple[slice, slice]]:
        """Return the blocks of components and layers that are transformed at once, of planes of so many rows."""
        plane = rows * self.shape[1]
        wide = max(1, _BLOCK_VALUES // (plane * layers))
        return [
            (slice(start, start + wide), deep)
            for start in range(0, components, wide)
            for deep in cut_layers(layers, plane)
        ]

    def _list_tiles(self) -> list[slice]:
        """Return the tiles of wave numbers along y."""
        mx, my = self.shape
        end, step = my // 2 + 1, max(1, _TILE_WAVES // mx)
        return [slice(start, min(start + step, end)) for start in range(0, end, step)]

    def _respond(self, waves: Waves, columns: slice) -> None:
        """Replace the waves of strain by those of stress.

        The shortest wave of an even number of cells has no sign, and the mean over both is taken: along y by the
        transform back, which drops what is imaginary, along x here.
        """
        mx, row = self.shape[0], self._signless_row
        tile = self._load(waves, row)
        vectors = self._only_vectors or self._find_vectors(columns)
        if self.weigh is not None:
            tile *= self.weigh(vectors.qx[:, np.newaxis], vectors.qy).astype(self.dtype)
        sweep(tile, vectors, self.poisson)
        if row is not None:
            tile[..., row, :] = 0.5 * (tile[..., row, :] + tile[..., -1, :])
        self._store(tile[..., :mx, :], waves)

    @property
    def _signless_row(self) -> int | None:
        """The row of the waves of two cells along x."""
        mx = self.shape[0]
        return mx // 2 if mx % 2 == 0 else None

    @cached_property
    def _only_vectors(self) -> WaveVectors | None:
        """The wave vectors with what is computed of them, which are kept where they are one tile."""
        tiles = self._list_tiles()
        return self._find_vectors(tiles[0]) if len(tiles) == 1 else None

    def _find_vectors(self, columns: slice) -> WaveVectors:
        """Return the wave vectors of a tile, with those of the row without a sign again."""
        (qx, qy), row = self.wave_numbers, self._signless_row
        qx = qx if row is None else np.append(qx, -qx[row])
        return WaveVectors(qx, qy[columns], self.thicknesses, self.dtype)

    def _load(self, waves: Waves, row: int | None) -> RealArray:
        """Return the waves by real and imaginary parts, with a row again behind them."""
        components, layers, rows, columns = waves.shape
        tile = np.empty((components, layers, 2, rows + (row is not None), columns), dtype=self.dtype)
        kept = tile[..., :rows, :]
        for place, component in enumerate(waves):
            if place in _TURNED:
                kept[place, :, 0] = component.imag
                np.negative(component.real, out=kept[place, :, 1])
            else:
                kept[place, :, 0] = component.real
                kept[place, :, 1] = component.imag
        if row is not None:
            tile[..., -1, :] = tile[..., row, :]
        return tile

    @staticmethod
    def _store(tile: RealArray, waves: Waves) -> None:
        """Put real and imaginary parts into waves."""
        for place, component in enumerate(waves):
            if place in _TURNED:
                np.negative(tile[place, :, 1], out=component.real)
                component.imag = tile[place, :, 0]
            else:
                component.real = tile[place, :, 0]
                component.imag = tile[place, :, 1]


@attrs.frozen(eq=False)
class PressureWaves:
    r"""The stress of waves of pressure, mean over each layer, and the displacement of eigenstrains by reciprocity.

    .. math:: \sigma_{nn} = (\zeta - 1) e^{-\zeta} \hat p, \quad \sigma_{zz} = -(1 + \zeta) e^{-\zeta} \hat p, \quad
              \sigma_{tt} = -2\nu e^{-\zeta} \hat p, \quad \sigma_{nz} = i \zeta e^{-\zeta} \hat p

    Attributes
    ----------
    shape, spacing
        Cells of the period, and their sides, m.
    thicknesses
        Thicknesses of the layers, shape (nz,), m.
    poisson
        Poisson's ratio.
    """

    shape: tuple[int, int]
    spacing: Pair
    thicknesses: Array
    poisson: float

    @cached_property
    def _waves(self) -> WaveVectors:
        qx, qy = Period(self.shape, self.spacing, self.thicknesses, self.poisson).wave_numbers
        return WaveVectors(qx, qy, self.thicknesses)

    @cached_property
    def _directions(self) -> tuple[Array, ...]:
        """Squares and products of the cosines, and the cosines, without odd parts of waves of two cells along x.

        Those along y the transform back drops.
        """
        x, y = (one.astype(np.float64) for one in self._waves.direction)
        squares = x * x, y * y
        if self.shape[0] % 2 == 0:
            x[self.shape[0] // 2] = 0.0
        return (*squares, x, y, x * y)

    def _list_factors(self, layers: slice) -> list[Array]:
        """Return the stress of waves of unit pressure in some layers, that of shears with z over the imaginary unit."""
        thicknesses = self.thicknesses[layers, np.newaxis, np.newaxis]
        tops = np.concatenate(([0.0], np.cumsum(self.thicknesses[:-1])))
        top = self._waves.q * tops[layers, np.newaxis, np.newaxis]
        _, mean, moment = find_means(self._waves.q * thicknesses)
        decay = np.exp(-top)
        moment = decay * (top * mean + moment)
        mean = decay * mean
        along = moment - mean
        across = -2.0 * self.poisson * mean
        along[:, 0, 0] = across[:, 0, 0] = -self.poisson / (1.0 - self.poisson)
        xx, yy, x, y, xy = self._directions
        return [
            xx * along + yy * across,
            yy * along + xx * across,
            -(mean + moment),
            y * moment,
            x * moment,
            xy * (along - across),
        ]

    def press(self, pressure: Array) -> Array:
        """Return the stress by a pressure, shape (6, nz, nx, ny), Pa."""
        waves = scipy.fft.rfft2(pressure)
        turned = 1j * waves
        stress = np.empty((6, self.thicknesses.size, *self.shape))

        def work(layers: slice) -> None:
            for place, factor in enumerate(self._list_factors(layers)):
                stress[place, layers] = scipy.fft.irfft2(
                    factor * (turned if place in _TURNED else waves), s=self.shape, overwrite_x=True
                )

        map_tiles(work, cut_layers(self.thicknesses.size, pressure.size))
        return stress

    def displace(self, strain: Array) -> Array:
        """Return the displacement of the surface by an eigenstrain, positive into the body, shape (nx, ny), m."""

        def work(layers: slice) -> Waves | None:
            if not strain[:, layers].any():
                return None
            total: Waves = np.zeros(self._waves.q.shape, dtype=np.complex128)
            thicknesses = self.thicknesses[layers, np.newaxis, np.newaxis]
            for place, factor in enumerate(self._list_factors(layers)):
                if strain[place, layers].any():
                    weight = thicknesses * (-2j if place in _TURNED else 2.0 if place == 5 else 1.0)
                    total += (scipy.fft.rfft2(strain[place, layers]) * (weight * factor)).sum(axis=0)
            return total

        found = [one for one in map_tiles(work, cut_layers(len(strain[0]), strain[0, 0].size)) if one is not None]
        if not found:
            return np.zeros(self.shape)
        return np.asarray(scipy.fft.irfft2(sum(found[1:], found[0]), s=self.shape, overwrite_x=True))
