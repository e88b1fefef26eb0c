"""The stress at the surface at an edge of a contact, behind which a sliding contact pulls its body."""

from __future__ import annotations

import math

import attrs
import numpy as np

from roughcontact._answers.subsurface.field import Measure, StressField, find_largest, locate, maximum_principal
from roughcontact._answers.subsurface.window import Window
from roughcontact._base.arrays import Pair, RealArray
from roughcontact._parts.grid import Boundary, Grid
from roughcontact._parts.kernels import STRESS_COMPONENTS, HalfSpaceStress
from roughcontact._solve.convolvers import StressConvolution

# Error of the stress at the peak behind a sliding contact over the difference that an average over 2 x 2 points makes:
# 1/(sqrt(2) - 1) where it falls with the root of the cell's side, less on balls.
_PEAK_FACTOR = 2.0
# Uncertainty over the difference that the extrapolation makes: of cells of the grid, and of finer ones. The latter err
# by the fit as well: over what it changes, and in maximum pressures. Set on balls and on rough surfaces, and judged on
# others by docs/studies/stress.py.
_GRID_UNCERTAINTY = 1.0
_FINE_UNCERTAINTY = 0.3
_FIT_UNCERTAINTY = 0.5
_FIT_ERROR = 0.004
# Around a place on the edge: cells that are made finer on each side, cells among these in which the stress is known,
# finer cells along a side, and the distance over which cells weigh in the fit.
_REACH = 6
_KNOWN = 2
_FINER = 16
_FIT_DISTANCE = 2.0
# Fewest cells within a patch for a fit of its six numbers.
_MIN_CELLS = 12
# Places that are tried, and the smallest stress there over the largest one: cells change it by up to a third.
_MAX_PLACES = 3
_WORTH = 0.7


@attrs.frozen(eq=False)
class EdgeStress:
    """The stress where the maximum principal stress at the surface is largest: at an edge, behind a sliding contact.

    There the stress has a peak, which cells of constant load smooth by an amount that falls with the root of their
    side. Averages over 2 x 2 points are the stress of cells of twice the side.

    Attributes
    ----------
    x, y
        The place, m.
    values
        The components at the nearest point, in the scale of the field, shape (6,).
    averages
        The averages over 2 x 2 points beside it with the largest maximum principal stress, shape (6,).
    coarse
        The stress as the cells of the grid have it; None if this is that stress.
    """

    x: float
    y: float
    values: RealArray
    averages: RealArray
    coarse: EdgeStress | None = None

    def extrapolate(self, measure: Measure) -> tuple[float, float]:
        """Return a measure of the stress for cells without size, and its uncertainty, in the scale of the field."""
        value = float(measure(self.values + _PEAK_FACTOR * (self.values - self.averages)))
        difference = abs(value - float(measure(self.values)))
        if self.coarse is None:
            return value, _GRID_UNCERTAINTY * difference
        change = value - self.coarse.extrapolate(measure)[0]
        return value, math.hypot(_FINE_UNCERTAINTY * difference, _FIT_UNCERTAINTY * change, _FIT_ERROR)

    @classmethod
    def at(cls, values: RealArray, point: tuple[int, int], place: Pair) -> EdgeStress:
        """Return the stress at a point of a plane, whose values have the shape (6, nx, ny), and its place, m."""
        i, j = point
        around = values.take(range(i - 1, i + 2), axis=1, mode="wrap").take(range(j - 1, j + 2), axis=2, mode="wrap")
        averages = 0.25 * (around[:, 1:, 1:] + around[:, 1:, :-1] + around[:, :-1, 1:] + around[:, :-1, :-1])
        averages = averages.reshape(len(STRESS_COMPONENTS), -1)
        largest = averages[:, int(np.argmax(maximum_principal(averages)))]
        return cls(*place, values[:, i, j], largest)


def find_edge_stress(
    field: StressField, pressure: RealArray, traction: RealArray | None, poisson: float, boundary: Boundary
) -> EdgeStress:
    """Return the stress at the edge where the maximum principal stress at the surface is largest.

    The square of the pressure is smooth up to the edge: a fit of it to the cells around gives the pressure in finer
    cells, with the place of the edge. Near it the stress is that of a half-space, under layers too. Where the patch has
    too few cells, or attracts, the stress is that of the grid.

    Parameters
    ----------
    field
        The stress at the surface.
    pressure, traction
        The load of each cell in the scale of the field, shapes (nx, ny) and (2, nx, ny); no traction is None.
    poisson
        Poisson's ratio of the body at its surface.
    boundary
        The boundary of the domain.
    """
    load = pressure[np.newaxis] if traction is None else np.concatenate((pressure[np.newaxis], traction))
    stress = maximum_principal(field.values)
    i, j = find_largest(stress)
    coarse = EdgeStress.at(field.values, (i, j), locate(field.grid, i, j))
    lowest = _WORTH * float(stress[i, j])
    found = []
    for _ in range(_MAX_PLACES):
        place = find_largest(stress)
        if stress[place] < lowest:
            break
        window = Window(place, field.grid.shape, boundary, (_REACH, _REACH))
        resolved = _resolve(field, load, poisson, window)
        if resolved is None:
            break
        found.append(resolved)
        stress[attrs.evolve(window, reach=(_KNOWN, _KNOWN)).select()] = -np.inf
    if not found:
        return coarse
    return attrs.evolve(max(found, key=lambda one: one.extrapolate(maximum_principal)[0]), coarse=coarse)


def _resolve(field: StressField, load: RealArray, poisson: float, window: Window) -> EdgeStress | None:
    """Return the stress at the edge near the middle of a window, None where its pressure has no fit."""
    coarse = _keep_patch(window.cut(load))
    fine = _refine(coarse)
    if fine is None:
        return None
    sides = (1.0, field.grid.spacing[1] / field.grid.spacing[0])
    rest = window.cut(field.values) - _at_surface(coarse, sides, poisson)
    known = slice((_REACH - _KNOWN) * _FINER, (_REACH + _KNOWN + 1) * _FINER)
    values = _at_surface(fine, sides, poisson)[:, known, known]
    # The loads of the other cells are far from here: their stress is smooth.
    values = values + _interpolate(_extend(rest, ~window.outside))[:, known, known]
    # A point beside the largest one is needed.
    i, j = (index + 1 for index in find_largest(maximum_principal(values)[1:-1, 1:-1]))
    offset = [(index + 0.5) / _FINER - _KNOWN - 0.5 for index in (i, j)]
    x, y = locate(field.grid, *window.place)
    place = (x + offset[0] * field.grid.spacing[0], y + offset[1] * field.grid.spacing[1])
    return EdgeStress.at(values, (i, j), place)


def _keep_patch(load: RealArray) -> RealArray:
    """Return the loads of the patch nearest to the middle."""
    from scipy import ndimage

    labels = ndimage.label(load[0] != 0.0)[0]
    if not labels.any():
        return load
    nearest = ndimage.distance_transform_edt(labels == 0, return_distances=False, return_indices=True)
    label = labels[tuple(index[_REACH, _REACH] for index in nearest)]
    return np.where(labels == label, load, 0.0)


def _refine(load: RealArray) -> RealArray | None:
    """Return the loads in finer cells, None where too few cells show how the pressure falls towards the edge."""
    from scipy import ndimage

    pressure = load[0]
    contact = pressure != 0.0
    within = ndimage.binary_erosion(contact, border_value=True)
    if np.count_nonzero(within) < _MIN_CELLS or (pressure < 0.0).any():
        return None
    cells = np.arange(-_REACH, _REACH + 1.0)
    terms = _list_terms(cells)
    weights = np.exp(-0.5 * (cells[:, np.newaxis] ** 2 + cells**2) / _FIT_DISTANCE**2)[within]
    square = pressure * pressure
    fit = np.linalg.lstsq(terms[within] * weights[:, np.newaxis], square[within] * weights, rcond=None)[0]
    residual = np.where(within, square - terms @ fit, 0.0)
    fine_cells = _list_fine_cells()
    fine_square = _list_terms(fine_cells) @ fit + _interpolate(_extend(residual, within))
    # Towards the edge the pressure falls.
    highest = np.where(_repeat(within), np.inf, _repeat(_extend(square, within)))
    fine = np.sqrt(np.clip(fine_square, 0.0, highest))
    fine *= _repeat(ndimage.binary_dilation(contact, np.ones((3, 3), dtype=bool)))
    # The traction keeps its ratio to the pressure, outside the cells in contact that of the nearest one.
    ratio = np.where(contact, load[1:] / np.where(contact, pressure, 1.0), 0.0)
    return np.concatenate((fine[np.newaxis], fine * _repeat(_extend(ratio, contact))))


def _list_terms(cells: RealArray) -> RealArray:
    """Return 1, x, y, x^2, xy, y^2 at the cells of a square, shape (n, n, 6)."""
    x, y = np.meshgrid(cells, cells, indexing="ij")
    return np.stack((np.ones_like(x), x, y, x * x, x * y, y * y), axis=-1)


def _list_fine_cells() -> RealArray:
    return (np.arange((2 * _REACH + 1) * _FINER) + 0.5) / _FINER - _REACH - 0.5


def _extend(values: RealArray, known: RealArray) -> RealArray:
    """Return values, shape (..., n, n), with those of the nearest known cell where they are not known."""
    from scipy import ndimage

    nearest = ndimage.distance_transform_edt(~known, return_distances=False, return_indices=True)
    return np.asarray(values[..., nearest[0], nearest[1]])


def _repeat(values: RealArray) -> RealArray:
    """Return the values of cells in their finer cells, shape (..., n, n)."""
    return values.repeat(_FINER, axis=-2).repeat(_FINER, axis=-1)


def _interpolate(values: RealArray) -> RealArray:
    """Return values of cells, shape (..., n, n), between their centres, linearly, in their finer cells."""
    places = _list_fine_cells() + _REACH
    low = np.clip(np.floor(places).astype(int), 0, 2 * _REACH - 1)
    part = np.clip(places - low, 0.0, 1.0)
    rows = values[..., low, :] * (1.0 - part)[:, np.newaxis] + values[..., low + 1, :] * part[:, np.newaxis]
    return np.asarray(rows[..., low] * (1.0 - part) + rows[..., low + 1] * part)


def _at_surface(load: RealArray, sides: Pair, poisson: float) -> RealArray:
    """Return the stress at the surface by loads alone, shape (6, n, n)."""
    rows, columns = load.shape[1:]
    grid = Grid((rows, columns), (rows * sides[0], columns * sides[1]))
    convolution = StressConvolution(HalfSpaceStress(poisson), grid, Boundary.FREE)
    of = "zxy"[: load.shape[0]]
    return convolution.apply(convolution.transform(load, of), 0.0, of)
