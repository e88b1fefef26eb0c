"""The descent of the energy of an adhesive contact over its gap: preconditioned conjugate gradients."""

from __future__ import annotations

import math
from collections.abc import Callable
from operator import itemgetter
from typing import Any, TypeAlias, TypeVar

import attrs
import numpy as np

from roughcontact._base.arrays import Array, Mask, RealArray, sum_of_products
from roughcontact._base.machine import map_tiles, tiles_of
from roughcontact._parts.interactions import BoundInteraction
from roughcontact._solve.solution import Status
from roughcontact._solve.solvers.adhesive.gap_problem import GapProblem
from roughcontact._solve.solvers.driver import Method

T = TypeVar("T")
Precision: TypeAlias = type[np.float32] | type[np.float64]

# Error of the gap, over the scale, below which no step leaps to another state.
_NEAR = 1e-2
# Iterations of a descent that may pass without the error being halved.
_IDLE = 400
# ... and of one in float32 whose error has fallen below the second number: rounding keeps it from falling further.
_IDLE_SINGLE = 15
_ROUNDED = 1e-3
# Fraction of the cells that may open or close before the support is computed again.
_CHANGED = 0.05
# Minimum weight of a cell of a held mean, over the mean of the weights.
_SMALLEST_WEIGHT = 1e-3
# Step lengths in units of the direction: the first, the maximum, and the one after a fall-back to the gradient.
_FIRST = 0.3
_LONGEST_STEP = 4.0
_CAREFUL = 0.3
# Maximum part of a step that is not clipped, and the part where the slope is taken to vanish that does not rise.
_LONGEST_PART = 1.5
_FARTHEST = 4.0
# Part of a clipped step above which it is taken in full, so that the cells that it closes do close.
_FULL = 0.7
# Slope at the end of a line search over that at its start, and trials at most.
_FLAT = 0.1
_TRIALS = 12
# Rise of the tension of a closing cell in one step, over that by the slope of the law, up to which it counts; with it
# and the first length above 1 of 480 rough contacts and 1 of 20 waves leap over a state, without the limit, and with a
# first of 1, 10 and 8 (benchmarks/adhesion_branches.py), for 2 to 4 % fewer products.
_MAX_RISE = 2.0
# Rounds of Newton's method for the shift that keeps the mean of a step, and the sum over that of magnitudes that is
# rounding in float32.
_ROUNDS = 30
_MISSED = 1e-6


@attrs.frozen(eq=False)
class _Tile:
    """Rows of the extended grid, those of them in the domain, and the law and the pressure limit there."""

    rows: slice
    inner: slice
    interaction: BoundInteraction | None
    limit: Array


class AdhesiveDescent(Method):
    r"""Lowers the energy of a gap g, which is not negative, with one product for the gradient and one for its image.

    .. math:: \tfrac12\, (g - h) \cdot M (g - h) + \bar p \cdot g + \sum W(g)

    Its gradient is p + s(g), with the pressure :math:`p = \bar p + M (g - h)` and the tension s = W'. Cells that the
    pressure limit flattens have a negative gap. The direction is preconditioned by the stiffness between masks with a
    support for long waves, the step is clipped at the bounds, and the slope along it is exact without a product.

    Far from the end, where it matters, steps are cautious: they are made as if the tension of closing cells rose no
    faster than by its slope, so that they do not leap over a state of equilibrium.

    Parameters
    ----------
    problem
        What is minimised.
    dtype
        The precision of the iterations.

    Attributes
    ----------
    scale
        Scale of the error.
    """

    patience = _IDLE + 1

    def __init__(self, problem: GapProblem, dtype: Precision) -> None:
        self.problem = problem
        self.dtype = dtype
        self.scale = 1.0
        stiffness = problem.stiffness
        self._inverse = stiffness.of_precision(dtype)
        self._symbol = stiffness.symbol(problem.mean_stiffness, dtype)
        self._shape = stiffness.shape
        self._tiles = self._split()
        self._preconditioner: RealArray = np.zeros(0, dtype=dtype)
        self._weights: RealArray | None = None
        self._renewed: Mask = np.zeros(0, dtype=bool)
        self._step: RealArray | None = None
        self._change: RealArray | None = None
        self._curvature = 1.0
        self._length = _FIRST
        self.products = 0
        self.multiplier = 0.0

    def _split(self) -> list[_Tile]:
        nx = self._shape[0]
        interaction = self.problem.interaction
        limit = self.problem.limit
        rows = tiles_of(np.empty(self.problem.stiffness.extended, dtype=np.float32))
        tiles = []
        for one in rows:
            inner = slice(min(one.start, nx), min(one.stop, nx))
            law = None if interaction is None else interaction.convert(itemgetter(inner))
            tiles.append(_Tile(one, inner, law, limit if limit.size == 1 else limit[inner].astype(self.dtype)))
        return tiles

    def start(self, gap: Array) -> None:
        """Continue from a gap of the extended grid, in float64; its pressure is computed."""
        displacement: RealArray = (gap - self.problem.closing).astype(self.dtype)
        pressure = self._multiply(displacement, self._symbol)
        pressure += self.dtype(self.problem.base)
        self._mask = np.ones(gap.shape, dtype=bool)
        self._residual: RealArray = np.empty(gap.shape, dtype=self.dtype)
        self.tension: RealArray = np.zeros(self._shape, dtype=self.dtype)
        self._trial: RealArray = np.zeros(self._shape, dtype=self.dtype)
        self.set_state(gap, pressure)

    def set_state(self, gap: Array, pressure: RealArray) -> None:
        """Continue from a gap of the extended grid, in float64, and its pressure, which may be changed in place."""
        self.gap: RealArray = gap.astype(self.dtype)
        self.pressure: RealArray = pressure.astype(self.dtype, copy=False)
        self._map(lambda tile: self._attract(self._inside(self.gap, tile), self.tension, tile))

    def is_apart(self) -> bool:
        """Return whether no cell touches and the load pulls more than the tension holds."""
        load = self.problem.base * self.gap.size
        if self.problem.mean_stiffness or self.problem.holds_mean or load >= 0.0:
            return False
        if any(self._map(lambda tile: bool((self._inside(self.gap, tile) <= 0.0).any()))):
            return False
        return load + float(self.tension.sum(dtype=np.float64)) < 0.0

    def measure(self) -> tuple[float, float]:
        """Return the maximum of the preconditioned residual, about the error of the gap, and no rounding."""
        if self.problem.holds_mean and self._weights is not None:
            self._balance(self._weights)
        changed = sum(self._map(self._find_residual))
        if self._renewed.size == 0 or changed > _CHANGED * self.gap.size:
            self._renew()
        self._image = self._precondition()
        error = max(self._map(lambda tile: _magnitude(self._image[tile.rows]))) / self.scale
        if self.dtype is np.float32 and error < _ROUNDED:
            self.patience = _IDLE_SINGLE + 1
        return error, 0.0

    def step(self) -> Status | None:
        """Make one step from the last measurement, if the energy falls along one."""
        self._conjugate()
        slope, clipped = self._clip(self._weights)
        if not slope < 0.0:
            slope, clipped = self._fall_back()
        return None if slope < 0.0 and self._move(slope, clipped) else Status.STALLED

    def _fall_back(self) -> tuple[float, bool]:
        """Clip the preconditioned residual or, where that is uphill too, the residual alone, which never is."""
        self._length = _CAREFUL
        self._image = self._precondition()
        slope, clipped = self._clip(self._weights)
        if slope < 0.0:
            return slope, clipped
        self._image = self._residual / self.dtype(self.problem.stiffness.shortest)
        return self._clip(None if self._weights is None else np.ones_like(self._weights))

    def _map(self, work: Callable[[_Tile], T]) -> list[T]:
        # A small grid is one tile.
        return [work(self._tiles[0])] if len(self._tiles) == 1 else map_tiles(work, self._tiles)

    def _multiply(self, field: RealArray, symbol: RealArray) -> RealArray:
        self.products += 1
        return self._inverse.multiply(field, symbol, self._inverse.padded)

    def _dot(self, one: RealArray, other: RealArray) -> float:
        return math.fsum(self._map(lambda tile: sum_of_products(one[tile.rows], other[tile.rows])))

    def _inside(self, field: RealArray, tile: _Tile) -> RealArray:
        """Return the part of an extended field in the domain, of one tile."""
        return field[tile.inner, : self._shape[1]]

    def _attract(self, gap: RealArray, tension: RealArray, tile: _Tile) -> None:
        """Store the tension of a tile at a gap."""
        if tile.interaction is not None and gap.size:
            tension[tile.inner] = tile.interaction.tension(np.maximum(gap, 0.0) if self.problem.capped else gap)

    def _find_residual(self, tile: _Tile) -> int:
        """Set the residual of a tile, zero where a cell stays on its bound; return how many cells opened or closed."""
        residual = self._residual[tile.rows]
        np.negative(self.pressure[tile.rows], out=residual)
        if self.multiplier:
            residual += self.dtype(self.multiplier)
        inside = self._inside(self._residual, tile)
        gap = self._inside(self.gap, tile)
        mask = self._inside(self._mask, tile)
        inside -= self.tension[tile.inner]
        flattened = self._flatten(inside, gap, tile) if self.problem.capped else None
        np.greater(inside, 0.0, out=mask)
        mask |= gap > 0.0
        if flattened is not None:
            mask |= flattened
        inside *= mask
        if self._renewed.size == 0:
            return 0
        return int(np.count_nonzero(mask ^ self._inside(self._renewed, tile)))

    def _flatten(self, residual: RealArray, gap: RealArray, tile: _Tile) -> Mask:
        """Return which cells of a tile the pressure limit flattens, or is about to; correct their residual for it."""
        excess = residual + self.tension[tile.inner]
        excess += tile.limit
        flattened = gap < 0.0
        flattened |= (gap == 0.0) & (excess < 0.0)
        np.copyto(residual, excess, where=flattened)
        return flattened

    def _renew(self) -> None:
        """Compute the preconditioner, and the weights of a held mean, for the cells that are open now."""
        self._renewed = self._mask.copy()
        cells: RealArray = self._mask.astype(self.dtype)
        stiff = self._multiply(cells, self._symbol)
        count = max(int(np.count_nonzero(self._mask)), 1)
        punch = self._dot(stiff, cells) / count
        self._preconditioner = self.problem.stiffness.precondition(self._symbol, punch)
        if self.problem.holds_mean:
            weights = self._multiply(cells, self._preconditioner)
            floor = _SMALLEST_WEIGHT * sum_of_products(weights, cells) / count
            self._weights = np.maximum(weights, self.dtype(floor))
            self._balance(self._weights)
            self._map(self._find_residual)

    def _balance(self, weights: RealArray) -> None:
        """Find the mean pressure that holds the mean gap: the weighted mean of the gradient over the open cells."""
        free = self.gap != 0.0 if self.problem.capped else self.gap > 0.0
        if not free.any():
            free = self._mask
        gradient = self.pressure + self.tension
        if self.problem.capped:
            np.copyto(gradient, self.pressure - self.problem.limit.astype(self.dtype), where=self.gap < 0.0)
        chosen = weights * free
        self.multiplier = sum_of_products(chosen, gradient) / float(chosen.sum(dtype=np.float64))

    def _precondition(self) -> RealArray:
        """Return the preconditioned residual, zero where a cell stays on its bound."""
        image = self._multiply(self._residual, self._preconditioner)
        self._map(lambda tile: _multiply(image[tile.rows], self._mask[tile.rows]))
        if self._weights is not None:
            weights = self._weights * self._mask
            image -= self.dtype(float(image.sum(dtype=np.float64)) / float(weights.sum(dtype=np.float64))) * weights
        return image

    def _conjugate(self) -> None:
        """Add the part of the last step that makes the direction conjugate to it."""
        step = self._step
        change = self._change
        if step is None or change is None or not self._curvature > 0.0:
            return
        image = self._image
        factor = -self._dot(image, change) / self._curvature
        if not factor > 0.0:
            return

        def add(tile: _Tile) -> None:
            part = step[tile.rows]
            part *= self.dtype(factor)
            part *= self._mask[tile.rows]
            image[tile.rows] += part

        self._map(add)

    def _clip(self, weights: RealArray | None) -> tuple[float, bool]:
        """Scale the direction to a step within the bounds, in place; return the slope along it, and if it is clipped.

        With weights the step keeps the mean gap: it is shifted in proportion to them.
        """
        image = self._image
        length = self.dtype(self._length)
        self._map(lambda tile: _multiply(image[tile.rows], length))
        shifted = weights is not None and self._keep_mean(image, weights * self._mask)

        def clip(tile: _Tile) -> tuple[float, bool]:
            inside = self._inside(image, tile)
            clipped = bool(inside.size) and self._bound(inside, tile)
            return sum_of_products(image[tile.rows], self._residual[tile.rows]), clipped

        found = self._map(clip)
        return -math.fsum(slope for slope, _ in found), shifted or any(clipped for _, clipped in found)

    def _bound(self, step: RealArray, tile: _Tile) -> bool:
        """Clip a step of a tile at a gap of zero, in place; return whether it was longer than that."""
        gap = self._inside(self.gap, tile)
        limit = -gap
        bounded = np.maximum(step, limit)
        if self.problem.capped:
            flattened = (gap < 0.0) | ((gap == 0.0) & (self._inside(self._residual, tile) < 0.0))
            np.minimum(step, limit, out=bounded, where=flattened)
        clipped = not np.array_equal(bounded, step)
        step[:] = bounded
        return clipped

    def _keep_mean(self, step: RealArray, weights: RealArray) -> bool:
        """Shift and clip a step, in place, so that it keeps the mean gap; return whether it is clipped.

        Newton's method finds the shift.
        """
        shift = 0.0
        size = float(np.abs(step).sum(dtype=np.float64))
        for _ in range(_ROUNDS):
            before = step - self.dtype(shift) * weights
            trial = before.copy()
            clipped = any(self._map(lambda tile, trial=trial: self._bound(self._inside(trial, tile), tile)))  # type: ignore[misc]
            excess = float(trial.sum(dtype=np.float64))
            moved = float(weights[trial == before].sum(dtype=np.float64))
            if abs(excess) <= _MISSED * size or not moved > 0.0:
                break
            shift += excess / moved
        step[:] = trial
        return clipped

    def _move(self, slope: float, clipped: bool) -> bool:
        """Take the part of the step after which the energy does not fall further."""
        step = self._image
        change = self._multiply(step, self._symbol)
        curvature = self._dot(step, change)
        if not math.isfinite(curvature):
            return False
        # A longer step would leave the bounds where it is clipped.
        longest = 1.0 if clipped or not self._has_room(step) else _LONGEST_PART
        part, end, wanted = self._search(step, slope, curvature, longest, clipped=clipped)
        self._length = min(_LONGEST_STEP, self._length * math.sqrt(min(max(wanted, 0.25), 4.0)))
        fraction = self.dtype(part)

        def update(tile: _Tile) -> None:
            step[tile.rows] *= fraction
            change[tile.rows] *= fraction
            self.gap[tile.rows] += step[tile.rows]
            self.pressure[tile.rows] += change[tile.rows]
            self._inside(change, tile)[:] += self._trial[tile.inner] - self.tension[tile.inner]

        self._map(update)
        self.tension, self._trial = self._trial, self.tension
        if self.error > _NEAR:
            self._map(lambda tile: self._attract(self._inside(self.gap, tile), self.tension, tile))
        self._step = step
        self._change = change
        self._curvature = part * (end - slope)
        return True

    def _has_room(self, step: RealArray) -> bool:
        """Return whether the longest step leaves every gap on its side of zero."""
        if self.problem.capped:
            return False

        def has_room(tile: _Tile) -> bool:
            reached = self._inside(self.gap, tile) + self._inside(step, tile) * self.dtype(_LONGEST_PART)
            return not reached.size or bool(reached.min() >= 0.0)

        return all(self._map(has_room))

    def _search(
        self, step: RealArray, slope: float, curvature: float, longest: float, *, clipped: bool
    ) -> tuple[float, float, float]:
        """Return the part of the step to take, the slope of the energy there, and the part at which it vanishes.

        The tension after the part is left in the trial field. The first trial is the step itself: its length is that at
        which the slopes along the last ones vanished.
        """
        low = 0.0
        slope_low = slope
        high = math.inf
        slope_high = math.nan
        part = 1.0
        for _ in range(_TRIALS):
            end = self._slope_at(part, step, slope, curvature)
            if end < 0.0:
                low = part
                slope_low = end
            else:
                high = part
                slope_high = end
            if math.isfinite(high):
                wanted = low - slope_low * (high - low) / (slope_high - slope_low)
            else:
                wanted = part * slope / (slope - end) if end > slope else _FARTHEST
            # Cells that a full step closes do close, so that it is taken if the energy falls along most of it.
            full = clipped and part == 1.0 and wanted > _FULL
            if full or abs(end) <= -_FLAT * slope or (end < 0.0 and part >= longest):
                break
            if math.isfinite(high):
                margin = 0.1 * (high - low)
                part = min(max(wanted, low + margin), high - margin)
            else:
                part = min(wanted, longest)
        return part, end, wanted

    def _slope_at(self, part: float, step: RealArray, slope: float, curvature: float) -> float:
        """Return the slope of the energy after a part of the step; the tension there is left in the trial field."""
        added = math.fsum(self._map(lambda tile: self._add_slope(tile, step, part)))
        return slope + part * curvature + added

    def _add_slope(self, tile: _Tile, step: RealArray, part: float) -> float:
        """Return what the change of the tension adds to the slope, and store the tension after a part of the step."""
        inside = self._inside(step, tile)
        if tile.interaction is None or not inside.size:
            return 0.0
        gap = inside * self.dtype(part)
        gap += self._inside(self.gap, tile)
        if self.problem.capped:
            np.maximum(gap, 0.0, out=gap)
        trial = self._trial[tile.inner]
        trial[:] = tile.interaction.tension(gap)
        if self.error > _NEAR:
            np.minimum(trial, self._limit_tension(tile, inside, part), out=trial)
        np.subtract(trial, self.tension[tile.inner], out=gap)
        return sum_of_products(gap, inside)

    def _limit_tension(self, tile: _Tile, step: RealArray, part: float) -> RealArray:
        """Return the largest tension after a part of a cautious step, of a tile."""
        assert tile.interaction is not None
        limit: RealArray = tile.interaction.slope(np.maximum(self._inside(self.gap, tile), 0.0))
        limit *= np.minimum(step, 0.0)
        limit *= self.dtype(_MAX_RISE * part)
        limit += self.tension[tile.inner]
        return limit


def _magnitude(values: RealArray) -> float:
    return float(max(values.max(), -values.min()))


def _multiply(values: RealArray, factor: RealArray | np.floating[Any]) -> None:
    np.multiply(values, factor, out=values)
