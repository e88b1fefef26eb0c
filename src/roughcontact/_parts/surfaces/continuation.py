"""Height maps extended by random short waves that continue the spectrum of the measured ones."""

from __future__ import annotations

import math

import attrs
import numpy as np
import scipy

from roughcontact._base.arrays import Array, Pair
from roughcontact._parts.grid import Grid
from roughcontact._parts.surfaces.base import Surface
from roughcontact._parts.surfaces.heightmap import HeightMap
from roughcontact._parts.surfaces.matching import PlacedMap
from roughcontact._parts.surfaces.resampling import fourier, resample_mask
from roughcontact._parts.surfaces.statistics import FORM_DEGREE, PowerLaw, fit_power_law, polynomial

# Cells per shortest wave for an area within 2 % (docs/understand/area.md).
_CELLS_PER_WAVE = 4.0
# Number of cells beyond any memory.
_MAX_CELLS = 2**50


def find_maps(surface: Surface) -> tuple[HeightMap, ...]:
    """Return the height maps that a surface is made of."""
    if isinstance(surface, HeightMap):
        return (surface,)
    parts = (surface.source,) if isinstance(surface, PlacedMap) else surface.parts
    return tuple(found for part in parts for found in find_maps(part))


def cells_for(size: Pair, shortest: float) -> tuple[int, int]:
    """Return the cells that a domain of this size, m, needs for its shortest wave, m."""
    nx, ny = (math.ceil(_CELLS_PER_WAVE * side / shortest) for side in size)
    # More cells than fit into any memory have no such length.
    return (
        (nx, ny)
        if nx * ny > _MAX_CELLS
        else (scipy.fft.next_fast_len(nx, real=True), scipy.fft.next_fast_len(ny, True))
    )


@attrs.frozen(eq=False)
class Continuation:
    """Random waves shorter than those that the maps of a surface resolve.

    Attributes
    ----------
    shortest, finest
        Shortest random wave, m, and the shortest one of the ensemble, m.
    resolved
        Shortest wave that is kept as measured, m; None: four cells of each map.
    seed
        The seed, and the number of the realization.
    deviation
        Deviation of the spectra from the power laws, in standard errors.
    """

    shortest: float
    finest: float
    resolved: float | None
    seed: tuple[int, int]
    deviation: float

    def extend(self, surface: Surface, place: int = 0) -> Surface:
        """Return the surface with its maps extended; `place` numbers the maps."""
        if isinstance(surface, HeightMap):
            return self._extend_map(surface, place)
        if isinstance(surface, PlacedMap):
            interpolation = surface.interpolation if surface.is_smooth else "cubic"
            return attrs.evolve(surface, source=self._extend_map(surface.source, place), interpolation=interpolation)
        parts = []
        for part in surface.parts:
            parts.append(self.extend(part, place))
            place += len(find_maps(part))
        return surface.with_parts(parts) if parts else surface

    def _extend_map(self, source: HeightMap, place: int) -> HeightMap:
        grid = source.grid
        shape = cells_for(source.size, self.shortest)
        resolved = self.resolved or _CELLS_PER_WAVE * max(grid.spacing)
        law = fit_power_law(source.values, grid, resolved)
        rng = np.random.default_rng(np.random.SeedSequence(self.seed[0], spawn_key=(self.seed[1], place)))
        heights = _filter(source, shape, resolved)
        heights += self._draw(Grid(shape, source.size), law, resolved, rng)
        lost, uncertain = (
            resample_mask(mask, shape, periodic=source.periodic) for mask in (source.non_measured, source.uncertain)
        )
        return attrs.evolve(source, heights=heights, non_measured=lost, uncertain=uncertain)

    def _draw(self, grid: Grid, law: PowerLaw, resolved: float, rng: np.random.Generator) -> Array:
        """Return random heights with the waves between the resolved and the shortest one, shape `grid.shape`, m."""
        fine = cells_for(grid.size, self.finest)
        # White noise has the same modes on every grid of the ensemble.
        modes = scipy.fft.rfft2(rng.standard_normal(fine), norm="ortho")
        kx, ky = (min(m, n) // 2 for m, n in zip(grid.shape, fine, strict=True))
        spectrum = np.zeros((grid.shape[0], grid.shape[1] // 2 + 1), dtype=np.complex128)
        spectrum[:kx, :ky] = modes[:kx, :ky]
        spectrum[-kx:, :ky] = modes[-kx:, :ky]
        qx = 2.0 * np.pi * scipy.fft.fftfreq(grid.shape[0], grid.spacing[0])[:, np.newaxis]
        qy = 2.0 * np.pi * scipy.fft.rfftfreq(grid.shape[1], grid.spacing[1])[np.newaxis, :]
        q = np.hypot(qx, qy)
        power = np.where((q * resolved > 2.0 * np.pi) & (q * self.shortest <= 2.0 * np.pi), 1.0, 0.0)
        spectrum *= np.sqrt(power * law.evaluate(qx, qy, self.deviation))
        # The origin is the centre of the domain; the FFT has it in the first cell.
        spectrum *= np.exp(1j * qx * grid.x[0, 0])
        spectrum *= np.exp(1j * qy * grid.y[0, 0])
        return np.asarray(scipy.fft.irfft2(spectrum, s=grid.shape, norm="forward"))


def _filter(source: HeightMap, shape: tuple[int, int], resolved: float) -> Array:
    """Return a map on `shape` cells, m, without its waves shorter than `resolved` m."""
    if source.periodic:
        modes = scipy.fft.fft2(source.values)
        qx, qy = (scipy.fft.fftfreq(n, step) for n, step in zip(source.grid.shape, source.grid.spacing, strict=True))
        modes[np.hypot(qx[:, np.newaxis], qy) * resolved > 1.0] = 0.0
        return fourier(scipy.fft.ifft2(modes).real, shape)
    rough = source.values - polynomial(source.values, FORM_DEGREE, source.non_measured)
    # The mirror image of a map does not jump at its border: a sum of cosines.
    cosines = scipy.fft.dctn(rough, norm="forward")
    nx, ny = (min(m, n) for m, n in zip(shape, rough.shape, strict=True))
    qx, qy = (0.5 * np.arange(n) / side for n, side in zip((nx, ny), source.size, strict=True))
    kept = np.zeros(shape)
    kept[:nx, :ny] = np.where(np.hypot(qx[:, np.newaxis], qy) * resolved <= 1.0, cosines[:nx, :ny], 0.0)
    form = polynomial(source.values, FORM_DEGREE, source.non_measured, shape)
    return np.asarray(form + scipy.fft.idctn(kept, norm="forward"))
