"""The maximum of a stress near the surface, on finer cells around the places where it is largest.

Less than two cells deep the stress is that of the steps in pressure, and ridges narrower than two cells lack a third of
it. The heights between the cells are known by a spline, and what the cells far away displace is smooth: around a place
the contact is solved again on finer cells, under the same approach, and the stress of the coarse ones is replaced.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Literal

import attrs
import numpy as np

from roughcontact._answers.areas.flags import find_flags
from roughcontact._answers.areas.initial_gap import Spline, combine_principal, curvature_resolution
from roughcontact._answers.areas.summits import unwrap
from roughcontact._answers.subsurface.field import (
    Measure,
    StressField,
    find_largest,
    locate,
    maximum_shear,
    von_mises,
)
from roughcontact._answers.subsurface.maximum import (
    PlanePeak,
    StressMaximum,
    drop_warnings_of_cells,
    find_maximum,
    find_shear,
    find_von_mises,
    warn_of_depth,
)
from roughcontact._answers.subsurface.window import Window
from roughcontact._base.arrays import Array, Pair, RealArray
from roughcontact._parts.grid import Boundary, Grid
from roughcontact._parts.kernels import HalfSpaceStress, Love
from roughcontact._parts.materials import Elastic
from roughcontact._parts.surfaces import HeightMap
from roughcontact._solve.convolvers import StressConvolution
from roughcontact._solve.problem import RIGID_FLAT, Body, ContactProblem, problem_of
from roughcontact._solve.solution import ContactSolution
from roughcontact.errors import RoughContactError

# Around a place, in long sides of a cell: what is made finer on each side, in which of it the stress is known, and in
# which the load is compared; finer cells along a long side, and cells along the shorter side of the domain, at least.
_REACH = 8
_KNOWN = 4
_COMPARED = 3
_FINER = 4
_MIN_CELLS = 9
# Depths in cells: of the maximum, and of the stress by the cells far away, between which it is a parabola.
_DEPTHS = np.geomspace(0.125, 3.0, 15)
_FAR_DEPTHS = np.array((0.5, 1.25, 3.0))
# Logarithm of the stress on finer cells over E* k h, k the larger curvature and h the side of a cell, as a parabola in
# that of the geometric mean of the stresses of the cells at the first two of these depths, up to the last number. Set
# on 335 places: within 8 %.
_EXPECTED = (0.142, 1.153, 0.127)
_HIGHEST = 0.5
# Smallest stress of the cells over the largest at a place that is looked at. Places that are tried, and the smallest
# stress that is expected there, over the largest that was found.
_SMALLEST = 0.3
_MAX_PLACES = 8
_WORTH = 0.75
# Fraction of the load around a place from which it is kept, not the approach.
_MOST_LOAD = 0.5
# Relative standard deviation: of all; by heights between the cells, over that power of `curvature_resolution`; over the
# logarithm of the load around the place on finer cells over that of the cells, and over its square: where all ridges
# lie alike on the grid, their load is known and the approach is not. Set on draws 41, 8101, 9117 and 12043 of
# benchmarks/edged_classes.py and on twelve rough surfaces of two and three cells a shortest wave, judged on draw 12044.
_STD = 0.0012
_HEIGHT_STD = 6e-4
_HEIGHT_POWER = 5
_LOAD_STD = (0.1, 8.0)


def replace_by_finer(found: StressMaximum, finer: StressMaximum, solution: ContactSolution) -> StressMaximum:
    """Return a maximum on finer cells in place of that of the cells, with the warnings that hold for both."""
    kept = drop_warnings_of_cells(found).warnings
    return warn_of_depth(attrs.evolve(finer, warnings=kept), solution)


def find_near_maxima(
    solution: ContactSolution, poisson: float, find_field: Callable[[float], StressField]
) -> dict[Measure, StressMaximum]:
    """Return the maximum von Mises stress and shear stress near the surface, by measure, on finer cells.

    There is none where the heights between the cells are not known, by the flags of the contact, or the kernel is not
    that of elastic half-spaces.

    Parameters
    ----------
    solution
        The contact, of elastic half-spaces.
    poisson
        Poisson's ratio of the half-space.
    find_field
        Returns the stress of the cells at a depth, m.
    """
    known = isinstance(problem_of(solution).plan.kernel, Love) and solution.non_measured is None
    if not known or min(solution.grid.shape) < _MIN_CELLS or find_flags(solution):
        return {}
    depths = max(solution.grid.spacing) * _FAR_DEPTHS
    spline = Spline.through_gap(solution)
    fields = [find_field(float(depth)) for depth in depths]
    expected = _expect(fields, solution, spline)
    # A domain may be narrower than what is made finer, and no cell counts twice.
    counts = zip(_count(_REACH, solution.grid), solution.grid.shape, strict=True)
    x, y = (min(cells, (n - 1) // 2 - 1) for cells, n in counts)
    found: dict[Measure, StressMaximum] = {}
    place = None
    for _ in range(_MAX_PLACES):
        if place is None or expected[place] == 0.0:
            place = find_largest(expected)
        if not expected[place] > _WORTH * (found[von_mises].value if found else 0.0):
            break
        window = Window(place, solution.grid.shape, solution.boundary, (x, y))
        stress = np.stack([window.cut(field.values) * field.scale for field in fields])
        near = _Finer(solution, poisson, spline, window, stress).find_maxima()
        within = attrs.evolve(window, reach=_limit(_KNOWN, window, solution.grid))
        expected[within.select()] = 0.0
        place = None
        if near:
            highest = not found or near[von_mises].value > found[von_mises].value
            place = _climb(near[von_mises], within, solution) if highest else None
            found = {measure: max(one, found.get(measure, one), key=_value) for measure, one in near.items()}
    return found


def _climb(found: StressMaximum, known: Window, solution: ContactSolution) -> tuple[int, int] | None:
    """Return the place as far again from the middle of the known cells, for a maximum at their border; None inside.

    Along a ridge the stress may rise further.
    """
    grid = solution.grid
    away = [at - middle for at, middle in zip((found.x, found.y), locate(grid, *known.place), strict=True)]
    place = []
    is_at_border = False
    for at, middle, reach, n, side, free in zip(
        away, known.place, known.reach, grid.shape, grid.spacing, solution.boundary.free_axes, strict=True
    ):
        cells = float(unwrap(at / side, n, free=free))
        is_at_border |= abs(cells) > reach - 0.5
        further = middle + round(2.0 * cells)
        place.append(min(max(further, 0), n - 1) if free else further % n)
    return (place[0], place[1]) if is_at_border else None


def _value(found: StressMaximum) -> float:
    return found.value


def _expect(fields: Sequence[StressField], solution: ContactSolution, spline: Spline) -> Array:
    """Return the largest stress that is expected on finer cells under each cell in contact, Pa; zero under others."""
    first, second = (von_mises(field.values) for field in fields[:2])
    inside = np.flatnonzero(solution.contact & (first > _SMALLEST * first.max()))
    i, j = np.divmod(inside, solution.grid.shape[1])
    mean, difference = combine_principal(*spline.derivatives(i.astype(float), j.astype(float), 2))
    middle = np.sqrt(first.flat[inside] * second.flat[inside]) * fields[0].scale
    bend = solution.modulus * max(solution.grid.spacing) * (mean + difference)
    bend = np.maximum(bend, middle * math.exp(-_HIGHEST))
    part = np.log(middle / bend)
    expected = np.zeros(first.shape)
    expected.flat[inside] = bend * np.exp(_EXPECTED[0] + _EXPECTED[1] * part + _EXPECTED[2] * part**2)
    return expected


def _count(sides: int, grid: Grid) -> tuple[int, int]:
    """Return the cells along x and y in so many long sides of a cell."""
    x, y = (round(sides * max(grid.spacing) / side) for side in grid.spacing)
    return x, y


def _limit(sides: int, window: Window, grid: Grid) -> tuple[int, int]:
    """Return the same in a window, away from its border, which changes the stress."""
    x, y = (max(min(cells, reach - 2), 1) for cells, reach in zip(_count(sides, grid), window.reach, strict=True))
    return x, y


@attrs.frozen(eq=False)
class _Finer:
    """The contact around a place, on finer cells.

    Attributes
    ----------
    solution, poisson, spline
        The contact, Poisson's ratio, and the initial gap between the cells.
    window
        The cells around the place.
    fields
        The stress of the cells of the domain there, shape (3, 6, n, m), Pa.
    """

    solution: ContactSolution
    poisson: float
    spline: Spline
    window: Window
    fields: RealArray

    def find_maxima(self) -> dict[Measure, StressMaximum]:
        """Return the maximum von Mises and shear stress by measure; none without a contact on finer cells."""
        state = self._solve()
        if state is None:
            return {}
        pressure = self.window.cut(self.solution.pressure)
        scale = float(state.pressure.max())
        cell = max(self.solution.grid.spacing)
        kernel = HalfSpaceStress(self.poisson)
        coarse = StressConvolution(kernel, Grid(pressure.shape, state.grid.size), Boundary.FREE)
        waves = coarse.transform(pressure[np.newaxis] / scale)
        depths = _FAR_DEPTHS * cell
        fields = zip(self.fields, depths, strict=True)
        far = np.stack([field / scale - coarse.apply(waves, float(depth)) for field, depth in fields])
        known = _limit(_KNOWN, self.window, self.solution.grid)
        part = self._select(known)
        x, y = self._places
        far = _interpolate(far, np.stack((x[part], y[part])), order=1)
        inside = ~self._repeat(self.window.outside)[part]
        grid = Grid(inside.shape, self._measure(known))
        finer = StressConvolution(kernel, state.grid, Boundary.FREE)
        waves = finer.transform(state.pressure[np.newaxis] / scale)
        peaks = []
        for depth in _DEPTHS:
            values = finer.apply(waves, float(depth * cell))[:, *part] + np.tensordot(_weigh(depth), far, 1)
            field = StressField(float(depth * cell), grid, values * inside, scale)
            peaks.append((find_von_mises(field, Boundary.FREE), find_shear(field, Boundary.FREE)))
        error = self._find_error(pressure, state)
        first, second = zip(*peaks, strict=True)
        return {von_mises: self._judge(first, scale, error), maximum_shear: self._judge(second, scale, error)}

    def _judge(self, peaks: Sequence[PlanePeak], scale: float, error: float) -> StressMaximum:
        """Return the maximum of all depths with its place in the domain."""
        cell = max(self.solution.grid.spacing)
        found = find_maximum(_DEPTHS * cell, peaks, scale, max(self._spacing))
        grid = self.solution.grid
        x, y = locate(grid, *self.window.place)
        axes = zip((x + found.x, y + found.y), grid.size, self.solution.boundary.free_axes, strict=True)
        x, y = (float(unwrap(at, side, free=free)) for at, side, free in axes)
        uncertainty = math.hypot(found.uncertainty, error * found.value)
        return StressMaximum(found.value, uncertainty, x, y, found.depth)

    def _find_error(self, pressure: RealArray, state: ContactSolution) -> float:
        """Return the relative error beside that of the finer cells."""
        near = _limit(_COMPARED, self.window, self.solution.grid)
        coarse, finer = (
            float(field[self._select(near, finer)].mean())
            for field, finer in ((pressure, (1, 1)), (state.pressure, self._finer))
        )
        change = abs(math.log(finer / coarse)) if finer > 0.0 and coarse > 0.0 else 1.0
        shared = _LOAD_STD[0] * change + _LOAD_STD[1] * change**2
        return math.hypot(_STD, min(shared, 1.0), _HEIGHT_STD * curvature_resolution(self.solution) ** _HEIGHT_POWER)

    def _solve(self) -> ContactSolution | None:
        """Return the contact on finer cells under the same approach or load, displaced by the pressure of other cells.

        None where nothing touches, or no solution is found.
        """
        solution = self.solution
        gap = self._find_gap()
        outside = self._repeat(self.window.outside)
        lowest = float(gap[~outside].min())
        approach = solution.approach - lowest
        if not approach > 0.0:
            return None
        # Beyond a free border nothing touches.
        gap[outside] = lowest + 2.0 * approach + float(np.ptp(gap[~outside]))
        heights = HeightMap(lowest - gap, size=self._measure(self.window.reach))
        body = Body(heights, Elastic(solution.modulus, 0.0))
        force = float(self.window.cut(solution.pressure).sum()) * solution.grid.cell_area
        # Alone it carries what is given; of many contacts the approach is known better than how they share a load.
        alone = force > _MOST_LOAD * solution.force
        try:
            problem = ContactProblem(body, RIGID_FLAT, threads=1)
            state = problem.solve(force=force) if alone else problem.solve(approach=approach)
        except RoughContactError:
            return None
        return state if state.status.success and state.pressure.any() else None

    def _find_gap(self) -> Array:
        """Return the gap on finer cells, with what the pressure of all other cells displaces, m."""
        from scipy import signal

        solution = self.solution
        # A cell more on each side, so that nothing is extrapolated.
        around = attrs.evolve(self.window, reach=(self.window.reach[0] + 1, self.window.reach[1] + 1))
        shape = tuple(2 * reach + 1 for reach in around.reach)
        love = Love().coefficients((shape[0], shape[1]), solution.grid.spacing, 1.0 / solution.modulus)
        love = love[np.ix_(*(np.abs(np.arange(1 - n, n)) for n in shape))]
        own = np.pad(self.window.cut(solution.pressure), 1)
        displaced = solution.displacement[around.select()] - signal.fftconvolve(own, love, mode="same")
        x, y = self._places
        others = _interpolate(around.extend(displaced), np.stack((x, y)) + 1.0, order=3)
        first = [float(along[0]) for along in self.window.along]
        return np.asarray(self.spline.derivatives(x + first[0], y + first[1], 0)[0] + others)

    @property
    def _finer(self) -> tuple[int, int]:
        """The finer cells along the sides of a cell: about square ones."""
        x, y = (math.ceil(_FINER * side / max(self.solution.grid.spacing)) for side in self.solution.grid.spacing)
        return x, y

    @property
    def _spacing(self) -> tuple[float, float]:
        """The sides of a finer cell, m."""
        x, y = (side / finer for side, finer in zip(self.solution.grid.spacing, self._finer, strict=True))
        return x, y

    @property
    def _places(self) -> tuple[Array, Array]:
        """The places of the finer cells, in cells from the first of the window, shape of the finer cells each."""
        x, y = np.meshgrid(
            *(
                (np.arange((2 * reach + 1) * finer) + 0.5) / finer - 0.5
                for reach, finer in zip(self.window.reach, self._finer, strict=True)
            ),
            indexing="ij",
        )
        return x, y

    def _select(self, reach: tuple[int, int], finer: tuple[int, int] | None = None) -> tuple[slice, slice]:
        """Return which finer cells, so many along the sides of a cell, lie in the cells within a reach."""
        x, y = (
            slice((own - near) * count, (own + near + 1) * count)
            for own, near, count in zip(self.window.reach, reach, finer or self._finer, strict=True)
        )
        return x, y

    def _measure(self, reach: tuple[int, int]) -> Pair:
        """Return the lengths of so many cells on each side of one, m."""
        x, y = ((2 * cells + 1) * side for cells, side in zip(reach, self.solution.grid.spacing, strict=True))
        return x, y

    def _repeat(self, values: RealArray) -> RealArray:
        """Return the values of cells in their finer cells."""
        return values.repeat(self._finer[0], axis=0).repeat(self._finer[1], axis=1)


def _interpolate(values: RealArray, places: Array, order: Literal[1, 3]) -> Array:
    """Return values of cells, shape (..., n, m), between their centres, in cells from the first."""
    from scipy import ndimage

    flat = values.reshape(-1, *values.shape[-2:]).astype(np.float64)
    found = np.stack([ndimage.map_coordinates(one, places, order=order, mode="nearest") for one in flat])
    return np.asarray(found.reshape(*values.shape[:-2], *places.shape[1:]))


def _weigh(depth: float) -> Array:
    """Return the weights of values at the depths of the far stress in the parabola through them."""
    others = [_FAR_DEPTHS[one != _FAR_DEPTHS] for one in _FAR_DEPTHS]
    pairs = zip(_FAR_DEPTHS, others, strict=True)
    return np.array([np.prod((depth - other) / (one - other)) for one, other in pairs])
