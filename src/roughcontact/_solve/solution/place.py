"""One place of a rough surface: numbers of its contact from which the differences between places follow."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property

import attrs
import numpy as np
import scipy

from roughcontact._base.arrays import Array, IntArray, Mask
from roughcontact._base.units import Deferred
from roughcontact._parts.grid import Boundary, Grid
from roughcontact._parts.surfaces import FlatSurface, polynomial
from roughcontact._solve.solution.fields import ContactFields
from roughcontact.errors import InputError
from roughcontact.reference.roughness import Waves, find_lay, transform_waves

# Maximum cells of a contact whose answers hold its fields until their sampling errors are read.
_MAX_HELD_CELLS = 2**16
# All further constants were set on the tuned classes of docs/studies/sampling.py.
# Tiles of a square domain along each side, between which the load is compared with the area, and cells along a side
# of the coarse heights, which hold the longest waves.
_TILES = 8
_COARSE_CELLS = 64
# Relative standard deviation of the area of one patch at a given load, and the number of tiles for which it counts.
_PATCH_STD = 0.3
_PATCH_WEIGHT = 3.0
# Parts of a square domain along each side whose slopes show whether the roughness changes from place to place, and
# factors: the largest parts show it best, but as they are four they may be alike by chance.
_PART_FACTORS = {2: 10.0, 4: 20.0}
# Numbers of strips along a lay whose slopes show whether the roughness changes across it.
_STRIPS = (2, 4, 8)
# Cells along a side from which slopes are taken at most.
_SAMPLED_CELLS = 192
# Minimum fraction of measured points.
_MIN_KNOWN_FRACTION = 0.25
# Multiple of the variance of the slopes of a Gaussian surface that passes for chance.
_CHANCE = 3.0
# Of Gaussian surfaces: maximum of the mean square pressure over the squared mean, minimum excess of the area at small
# loads over Persson's, and multiple of that area beyond which summits are blunt; factors of the departures.
_USUAL_SPREAD = 1.65
_USUAL_EXCESS = 0.25
_BLUNT_AREA = 1.5
_SPREAD_FACTOR = 0.6
_STEEP_FACTOR = 0.5
# Maximum relative error of the mean square height that counts, and maximum ratio of slopes across and along a lay.
_MAX_HEIGHT_ERROR = 0.6
_MAX_LAY_RATIO = 10.0
# Power of that ratio with which tiles differ more that are not independent along a lay.
_TILE_LAY_EXPONENT = 0.4
# Minimum cells of coarse heights along an axis that determine a plane and roughness, and range of flat ones over all.
_MIN_PLANE_CELLS = 4
_FLATNESS = 1e-9


@attrs.frozen
class PlaceStatistics:
    """Numbers of one place that tell how much others differ, without units.

    Attributes
    ----------
    tiles
        Standard deviation of the area at a given load, by the differences of the tiles.
    elasticity
        By how much per cent the area falls if the slopes grow by one.
    height
        Sampling error of the mean square height.
    lay
        Ratio of the rms slopes across and along the lay.
    unevenness
        Standard deviation of the rms slope in contact beyond that of a Gaussian surface alike everywhere.
    """

    tiles: float
    elasticity: float
    height: float
    lay: float
    unevenness: float


@attrs.frozen(eq=False)
class Place:
    """What the sampling errors of a contact follow from, without the rest of its fields.

    Attributes
    ----------
    grid, boundary, initial_gap, pressure
        Those of the contact.
    non_measured
        Points whose roughness is not known, shape `grid.shape`; None without any.
    members, count
        Flat indices of the cells in contact, and the number of its patches.
    has_form
        Whether a ball, say, is pressed on the roughness, so that it touches in a part of the domain.
    modulus
        Contact modulus of the shortest waves, Pa.
    """

    grid: Grid
    boundary: Boundary
    initial_gap: Array
    pressure: Array
    non_measured: Mask | None
    members: IntArray
    count: int
    has_form: bool
    modulus: float

    @classmethod
    def of(cls, solution: ContactFields, non_measured: Mask | None = None) -> Place | None:
        """Return the place of a solution; None where no other places are known, or without a contact."""
        if solution.origin is None or solution.tension is not None or not solution.status.success:
            return None
        surfaces = solution.origin.surfaces
        has_form = any(not (one.is_random or isinstance(one, FlatSurface)) for one in surfaces)
        # On a periodic boundary a form is a wave of the domain.
        is_sampled = any(one.is_random for one in surfaces) and (all(solution.boundary.free_axes) or not has_form)
        if not is_sampled or not solution.contact.any():
            return None
        return cls(
            grid=solution.grid,
            boundary=solution.boundary,
            initial_gap=solution.initial_gap,
            pressure=solution.pressure,
            non_measured=non_measured,
            members=solution.patches.members,
            count=solution.patches.count,
            has_form=has_form,
            modulus=solution.surface_modulus,
        )

    @cached_property
    def cells(self) -> tuple[IntArray, IntArray]:
        """Rows and columns of the cells in contact."""
        rows = self.members // self.grid.shape[1]
        return rows, self.members - rows * self.grid.shape[1]

    @cached_property
    def pressures(self) -> Array:
        """Pressures of the cells in contact, Pa."""
        return np.asarray(self.pressure.ravel()[self.members])

    @cached_property
    def fractions(self) -> Array:
        """Fractions of the load on the cells in contact."""
        return np.asarray(self.pressures / self.pressures.sum())

    @cached_property
    def statistics(self) -> PlaceStatistics | None:
        """The statistics of the place; None without roughness, or where too few points were measured to tell it."""
        try:
            return find_place_statistics(self)
        except InputError:
            # Too few points for a form.
            return None

    def defer(self, find: Callable[[Place, PlaceStatistics], float | None], *, at_once: bool) -> Deferred:
        """Return a sampling error that is found when it is read; of large contacts at once, or it would hold them."""

        def read() -> float | None:
            return None if self.statistics is None else find(self, self.statistics)

        found = Deferred(read)
        if at_once or self.grid.cells > _MAX_HELD_CELLS:
            found.read()
        return found


def find_place_statistics(place: Place) -> PlaceStatistics | None:
    """Return the statistics of a place; None without roughness.

    The roughness at non-measured points is not known, whatever gap the place has there.
    """
    window = find_window(place)
    waves = _find_long_waves(place, window)
    if waves is None:
        return None
    height = min(waves.spread(1.0) / waves.sum(1.0), _MAX_HEIGHT_ERROR)
    lay = min(find_lay(waves)[0], _MAX_LAY_RATIO)
    known = np.ones(window.shape, dtype=bool)
    if place.non_measured is not None:
        known = ~place.non_measured[window.slices]
    if known.mean() < _MIN_KNOWN_FRACTION:
        return None
    elasticity = _find_elasticity(min(place.members.size / np.count_nonzero(known), 1.0))
    tiles = _compare_tiles(place, window, elasticity) * lay**_TILE_LAY_EXPONENT
    unevenness = _find_unevenness(place, window, waves, known)
    return None if unevenness is None else PlaceStatistics(tiles, elasticity, height, lay, unevenness)


@attrs.frozen
class _Window:
    """The part of the domain in which the surfaces touch: first cells, numbers of cells, and sides, m."""

    first: tuple[int, int]
    shape: tuple[int, int]
    size: tuple[float, float]

    @property
    def slices(self) -> tuple[slice, slice]:
        """The cells along both axes."""
        i, j = (slice(at, at + cells) for at, cells in zip(self.first, self.shape, strict=True))
        return i, j


def find_window(place: Place) -> _Window:
    grid = place.grid
    if not place.has_form:
        return _Window((0, 0), grid.shape, grid.size)
    i, j = place.cells
    nx, ny = (int(k.max() - k.min()) + 1 for k in (i, j))
    dx, dy = grid.spacing
    return _Window((int(i.min()), int(j.min())), (nx, ny), (nx * dx, ny * dy))


def _find_edges(count: int, cells: int) -> IntArray:
    """Return the first cell of each tile along an axis, and the number of cells; tiles differ by a cell at most."""
    return np.arange(count + 1) * cells // count


def _count_tiles(window: _Window, per_side: int) -> tuple[int, int]:
    """Return the numbers of tiles along both axes, of which a square window has `per_side`."""
    ratio = math.sqrt(window.size[0] / window.size[1])
    nx, ny = (
        max(1, min(round(per_side * scale), cells))
        for scale, cells in zip((ratio, 1.0 / ratio), window.shape, strict=True)
    )
    return nx, ny


def _share(place: Place, window: _Window, per_side: int, weights: Array) -> Array:
    """Return the sums of the weights of the cells in contact over each tile of a window."""
    nx, ny = _count_tiles(window, per_side)
    rows, columns = (
        np.repeat(np.arange(count), np.diff(_find_edges(count, cells)))
        for count, cells in zip((nx, ny), window.shape, strict=True)
    )
    i, j = place.cells
    tile = rows[i - window.first[0]] * ny + columns[j - window.first[1]]
    return np.asarray(np.bincount(tile, weights=weights, minlength=nx * ny), dtype=np.float64)


def _compare_tiles(place: Place, window: _Window, elasticity: float) -> float:
    r"""Return the standard deviation of the area at a given load, by tiles of a window.

    With loads F and areas A of independent tiles the ratio of the sums, :math:`r = \sum A / \sum F`, has

    .. math:: \left(\frac{s_r}{r}\right)^2 = \frac{\sum (A_i - r F_i)^2}{(\sum A_i)^2}
    """
    size = place.members.size
    loads, areas = (_share(place, window, _TILES, part) for part in (place.fractions, np.full(size, 1.0 / size)))
    found = float(np.sum((areas - loads) ** 2))
    count = 1.0 / float(np.sum(loads**2))
    usual = (_PATCH_STD * elasticity) ** 2 / place.count
    return math.sqrt((count * found + _PATCH_WEIGHT * usual) / (count + _PATCH_WEIGHT))


def _find_unevenness(place: Place, window: _Window, waves: Waves, measured: Mask) -> float | None:
    r"""Return the relative standard deviation of the rms slope in contact beyond that of a Gaussian surface.

    None where the cells that are compared are flat, or their upper half is, as on a map of a few steps.

    With mean square slopes m of n parts, that carry the fractions F of the load, the one in contact,
    :math:`\sum F m`, would vary by

    .. math:: s_n^2 = \sum F^2 \left(\frac{\operatorname{var} m}{\bar m^2} - n v\right)

    more than on a Gaussian surface, v for the whole, if the parts were independent. They are not where larger parts
    vary more; those weigh more then, because the whole varies more again. Along a lay they are not either: there the
    parts are strips. Few steep summits have two other signs: pressures that spread more than those of a Gaussian
    surface, and a contact smaller than its.
    """
    heights, slopes, compared = _sample_slopes(place, window, measured)
    if not compared.any():
        return None
    # The contact knows only the upper half.
    upper = compared & (heights < heights.mean(where=compared))
    if not slopes[upper].any():
        return None
    square = float(slopes.mean(where=compared))
    cells = np.count_nonzero(measured)
    pressures = place.pressures
    fraction = pressures.size / cells
    load = float(pressures.sum()) / cells / (place.modulus * math.sqrt(square))
    # Persson's area.
    usual = (1.0 + _USUAL_EXCESS * (1.0 - fraction) ** 2) * math.erf(math.sqrt(2.0) * load)
    steep = max(math.log(usual / fraction), 0.0)
    spread = max(math.log(float(np.mean(pressures**2)) / (_USUAL_SPREAD * float(pressures.mean()) ** 2)), 0.0)
    chance = _find_chance(place, window, waves, square)
    slopes *= upper
    mean = float(slopes.sum()) / np.count_nonzero(upper)

    def vary(per_side: int) -> float:
        counts = _count_tiles(window, per_side)
        if counts == (1, 1):
            return 0.0
        known = _sum_tiles(upper.astype(np.float64), counts)
        loads = _share(place, window, per_side, place.fractions)
        return _find_excess(loads, _sum_tiles(slopes, counts), mean * known, _CHANCE * chance)

    tiles = vary(_TILES)
    long = max(factor * (vary(per_side) - tiles) for per_side, factor in _PART_FACTORS.items())
    # Slopes of the map tell little of summits that are much blunter.
    relevance = min(1.0, _BLUNT_AREA * usual / fraction)
    across = _vary_across_lay(place, window, waves, slopes, upper, chance)
    changes = 0.5 * math.sqrt(max(relevance**2 * tiles + max(long, 0.0), across))
    return math.hypot(changes, _SPREAD_FACTOR * spread, _STEEP_FACTOR * steep)


def _find_excess(loads: Array, slopes: Array, usual: Array, chance: float) -> float:
    """Return the variance of the mean square slope in contact, by parts and their loads, beyond that by chance.

    `slopes` are the sums of the squares in each part, `usual` those that are expected; without any it does not count.
    """
    known = usual > 0.0
    if np.count_nonzero(known) < 2:
        return 0.0
    part = slopes[known] / usual[known]
    return float(np.sum(loads**2)) * max(float(np.var(part, ddof=1)) - part.size * chance, 0.0)


def _vary_across_lay(place: Place, window: _Window, waves: Waves, slopes: Array, upper: Mask, chance: float) -> float:
    """Return the variance of the mean square slope in contact by strips along the lay, beyond that by chance.

    `slopes` are those of the `upper` cells, of every so many of the window; without a lay there is none.
    """
    across, direction = find_lay(waves)
    unit = (math.cos(direction), math.sin(direction))
    start = sum(min(part, 0.0) * side for part, side in zip(unit, window.size, strict=True))
    width = sum(abs(part) * side for part, side in zip(unit, window.size, strict=True))

    def measure(i: IntArray, j: IntArray) -> Array:
        """Return how far across the lay cells of the window lie, from 0 to 1."""
        x, y = ((k + 0.5) / n * side for k, n, side in zip((i, j), window.shape, window.size, strict=True))
        return np.asarray((unit[0] * x + unit[1] * y - start) / width)

    def number(part: Array, count: int) -> IntArray:
        return np.minimum((part * count).astype(np.intp), count - 1)

    rows, columns = (np.arange(0, n, math.ceil(n / _SAMPLED_CELLS)) for n in window.shape)
    i, j = place.cells
    mean = float(slopes.sum()) / np.count_nonzero(upper)
    sampled = measure(rows[:, np.newaxis], columns).ravel()
    touching = measure(i - window.first[0], j - window.first[1])
    counted = upper.ravel().astype(np.float64)
    found = []
    for count in _STRIPS:
        strip = number(sampled, count)
        known = np.bincount(strip, weights=counted, minlength=count)
        sums = np.asarray(np.bincount(strip, weights=slopes.ravel(), minlength=count), dtype=np.float64)
        loads = np.bincount(number(touching, count), weights=place.fractions, minlength=count)
        found.append(_find_excess(np.asarray(loads, dtype=np.float64), sums, mean * known, chance))
    return (1.0 - across**-2) * max(found)


def _sample_slopes(place: Place, window: _Window, measured: Mask) -> tuple[Array, Array, Mask]:
    """Return gaps within a window and their squared slopes, of every so many cells, and which of them are measured.

    On a free boundary they are less their plane, or a form.
    """
    gap = place.initial_gap[window.slices]
    degree = 0 if not place.boundary.has_free_axis else 2 if place.has_form else 1
    steps = [math.ceil(cells / _SAMPLED_CELLS) for cells in window.shape]
    each = np.s_[:: steps[0], :: steps[1]]
    heights = gap[each]
    compared = measured[each].copy()
    squares = np.zeros(heights.shape)
    for axis, side in enumerate(place.grid.spacing):
        # Towards the next cell, and of the last one from the one before.
        last = window.shape[axis] - 1
        starts = np.minimum(np.arange(0, last + 1, steps[axis]), max(last - 1, 0))
        ends = np.minimum(starts + 1, last)
        lines, known = (field[:, :: steps[1]] if axis == 0 else field[:: steps[0]] for field in (gap, measured))
        slopes = (lines.take(ends, axis) - lines.take(starts, axis)) / side
        both = known.take(ends, axis) & known.take(starts, axis)
        compared &= both
        squares += (slopes - polynomial(slopes, degree - 1, _invert(both)) if degree else slopes) ** 2
    heights = heights - polynomial(heights, degree, _invert(compared)) if degree else heights
    return np.asarray(heights), np.where(compared, squares, 0.0), compared


def _invert(measured: Mask) -> Mask | None:
    """Return which points are not measured; None without any."""
    return None if measured.all() else ~measured


def _find_chance(place: Place, window: _Window, waves: Waves, square: float) -> float:
    """Return the relative variance of the mean square slope between places of a Gaussian surface of this spectrum.

    Of large windows the middle is taken, and the longest waves.
    """
    shape = tuple(min(cells, _SAMPLED_CELLS) for cells in window.shape)
    first = (at + (cells - n) // 2 for at, cells, n in zip(window.first, window.shape, shape, strict=True))
    part = place.initial_gap[tuple(slice(at, at + n) for at, n in zip(first, shape, strict=True))]
    whole = shape == window.shape
    repeats = whole and not place.boundary.has_free_axis
    if not repeats and min(shape) >= _MIN_PLANE_CELLS:
        part = part - polynomial(part, 2 if place.has_form else 1, None)
    chance = 0.0
    if not whole:
        long = waves.spread(waves.square) * (waves.height / waves.cell) ** 2 / square
        chance = long**2 / waves.dependent
    if float(np.ptp(part)) > _FLATNESS * float(np.ptp(place.initial_gap)):
        sides = (n * step for n, step in zip(shape, place.grid.spacing, strict=True))
        fine = transform_waves(part, Grid(shape, tuple(sides)), repeats)
        fraction = part.size / (window.shape[0] * window.shape[1])
        chance += fraction * (fine.spread(fine.square) / fine.sum(fine.square)) ** 2 / fine.dependent
    return chance


def _sum_tiles(values: Array, counts: tuple[int, int]) -> Array:
    """Return the sums of the values of each tile, shape `counts`."""
    rows, columns = (_find_edges(count, cells)[:-1] for count, cells in zip(counts, values.shape, strict=True))
    return np.asarray(np.add.reduceat(np.add.reduceat(values, columns, axis=1), rows, axis=0))


def _find_elasticity(fraction: float) -> float:
    """Return by how much per cent the area falls if the slopes grow by one, after Persson; 0 in full contact."""
    if fraction >= 1.0:
        return 0.0
    ratio = float(scipy.special.erfinv(fraction))
    return 2.0 / math.sqrt(math.pi) * ratio * math.exp(-(ratio**2)) / fraction


def _find_long_waves(place: Place, window: _Window) -> Waves | None:
    """Return the waves of coarse heights, on a free boundary less their plane or form; None for flat surfaces."""
    cells = window.shape
    shape = (min(cells[0], _COARSE_CELLS), min(cells[1], _COARSE_CELLS))
    gap = place.initial_gap[window.slices]
    counts = np.outer(*(np.diff(_find_edges(n, full)) for n, full in zip(shape, cells, strict=True)))
    coarse = _sum_tiles(gap, shape) / counts
    repeats = not place.boundary.has_free_axis
    if not repeats:
        if min(shape) < _MIN_PLANE_CELLS:
            return None
        coarse = coarse - polynomial(coarse, 2 if place.has_form else 1, None)
    if not float(np.ptp(coarse)) > _FLATNESS * float(np.ptp(gap)):
        return None
    return transform_waves(coarse, Grid(shape, window.size), repeats)
