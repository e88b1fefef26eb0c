"""The passes of a descent on whole fields, compiled: one loop over the cells each."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from roughcontact.typing import Array, FieldPasses, LastStep, Mask, RealArray

# Maximum rounds of Newton's method for the shift that keeps the load, and for the released cells that stay on a bound.
_MAX_ROUNDS = 60
_MAX_RELEASED_ROUNDS = 20
# Error of the load in a step, over the change of pressure, and over the load by rounding.
_STEP_LOAD_ERROR = 1e-5
_LOAD_EPSILON = 4e-16
_NO_LIMIT = np.array([math.inf])
_NO_FIELD = np.zeros(0, dtype=np.float32)
# Sums, in float64, may be taken in any order, so that vectors of the processor serve; threads do not change it.
_compiled = njit(cache=True, nogil=True, error_model="numpy", fastmath={"reassoc", "contract", "nsz"})


@njit(inline="always")
def _at(limit, i):  # type: ignore[no-untyped-def]
    """Return the limit of a cell, from one entry for each or for all."""
    return limit[i] if limit.size > 1 else limit[0]


@_compiled
def _list(cells):  # type: ignore[no-untyped-def]
    """Return the indices of the cells of a mask."""
    found = np.empty(cells.size, dtype=np.int32)
    count = 0
    words = cells[: cells.size // 8 * 8].view(np.uint64)
    for k in range(words.size + 1):
        # Eight cells at a time, most of which are none.
        if k == words.size or words[k] != 0:
            for i in range(8 * k, min(8 * k + 8, cells.size)):
                # Without a branch: the next cell takes the place of one that is not of the mask.
                found[count] = i
                count += cells[i]
    return found[:count]


@_compiled
def _measure(pressure, gap, limit, by_load):  # type: ignore[no-untyped-def]
    total = 0.0
    carried = 0.0
    weighted = 0.0
    for i in range(pressure.size):
        value = pressure[i]
        elastic = value if value < _at(limit, i) else 0.0
        total += value
        carried += elastic
        weighted += elastic * gap[i]
    level = weighted / carried if by_load and carried > 0.0 else 0.0
    opened = 0.0
    overlaps = np.empty(pressure.size, dtype=np.float32)
    for i in range(pressure.size):
        rest = gap[i] - np.float32(level)
        rest = rest if pressure[i] < _at(limit, i) else max(rest, np.float32(0.0))
        opened += pressure[i] * abs(rest)
        overlaps[i] = -rest if rest < np.float32(0.0) else np.float32(0.0)
    # Numbers that are not negative are in the order of their bits, whose maximum vectors of the processor can find.
    bits = overlaps.view(np.int32)
    largest = np.zeros(1, dtype=np.int32)
    for i in range(bits.size):
        largest[0] = max(largest[0], bits[i])
    return level, max(opened / total if total > 0.0 else 0.0, np.float64(largest.view(np.float32)[0]))


@_compiled
def _release(pressure, gap, limit, by_load):  # type: ignore[no-untyped-def]
    cells = pressure.size
    level = np.float32(0.0)
    if by_load:
        total = 0.0
        count = 0
        for i in range(cells):
            inside = (pressure[i] > 0.0) & (pressure[i] < _at(limit, i))
            total += gap[i] if inside else 0.0
            count += inside
        level = np.float32(total / count if count else 0.0)
    active = np.empty(cells, dtype=np.bool_)
    residual = np.empty(cells, dtype=np.float32)
    total = 0.0
    count = 0
    for i in range(cells):
        loaded = pressure[i] > 0.0
        found = (loaded & ((pressure[i] < _at(limit, i)) | (gap[i] > level))) | (~loaded & (gap[i] < level))
        active[i] = found
        total += gap[i] if found else 0.0
        count += found
    mean = np.float32(total / count if by_load and count else 0.0)
    for i in range(cells):
        residual[i] = mean - gap[i] if active[i] else np.float32(0.0)
    return residual, active, count


@_compiled
def _conjugate(image, residual, active, step, change, curvature):  # type: ignore[no-untyped-def]
    product = 0.0
    slope = 0.0
    for i in range(image.size):
        image[i] = image[i] if active[i] else np.float32(0.0)
    for i in range(image.size):
        slope += np.float64(residual[i]) * image[i]
    if step.size:
        for i in range(image.size):
            product += np.float64(image[i]) * change[i]
    direction = image.copy()
    if product < 0.0:
        factor = np.float32(-product / curvature)
        for i in range(image.size):
            direction[i] += factor * step[i] if active[i] else np.float32(0.0)
    return direction, slope


@_compiled
def _admit(direction, residual, active, pressure, limit, by_load):  # type: ignore[no-untyped-def]
    cells = direction.size
    at_bound = np.empty(cells, dtype=np.bool_)
    total = 0.0
    count = 0
    for i in range(cells):
        total += direction[i]
        count += active[i]
        at_bound[i] = active[i] & ((pressure[i] <= 0.0) | (pressure[i] >= _at(limit, i)))
    released = _list(at_bound)
    mean = total / count if by_load else 0.0
    below = -math.inf
    above = math.inf
    for _ in range(_MAX_RELEASED_ROUNDS if by_load else 0):
        moving = count
        change = 0.0
        for i in released:
            if (direction[i] < mean) == (pressure[i] <= 0.0):
                moving -= 1
                change += direction[i]
        trial = (total - change) / moving if moving else mean
        if trial == mean:
            break
        if trial > mean:
            below = mean
        else:
            above = mean
        # Cells at zero and at the limit that change places would repeat for ever.
        mean = trial if below < trial < above else 0.5 * (below + above)
    shift = np.float32(mean)
    admitted = np.empty(cells, dtype=np.float32)
    slope = 0.0
    for i in range(cells):
        admitted[i] = direction[i] - shift if active[i] else np.float32(0.0)
        slope += np.float64(residual[i]) * admitted[i]
    for i in released:
        if (admitted[i] < 0.0) == (pressure[i] <= 0.0):
            slope -= np.float64(residual[i]) * admitted[i]
            admitted[i] = 0.0
    return admitted, slope


@_compiled
def _advance(pressure, direction, length, active, limit, by_load):  # type: ignore[no-untyped-def]
    cells = pressure.size
    trial = np.empty(cells)
    load = 0.0
    change = 0.0
    outside = 0
    for i in range(cells):
        moved = pressure[i] + length * direction[i]
        trial[i] = moved
        load += pressure[i] if active[i] else 0.0
        change += abs(direction[i])
        outside += (moved < 0.0) | (moved > _at(limit, i))
    if outside:
        shift = 0.0
        if by_load:
            moving = _list(active)
            error = max(_STEP_LOAD_ERROR * length * change, _LOAD_EPSILON * load)
            shift = _find_shift(trial[moving], limit[moving] if limit.size > 1 else limit, load, error)
        for i in range(cells):
            kept = min(max(trial[i] - shift, 0.0), _at(limit, i))
            trial[i] = kept if active[i] else trial[i]
    step = np.empty(cells, dtype=np.float32)
    for i in range(cells):
        step[i] = trial[i] - pressure[i]
    return trial, step, outside > 0


@_compiled
def _find_shift(values, limit, load, error):  # type: ignore[no-untyped-def]
    """Return the shift for which clip(values - shift, 0, limit) sums to the load."""
    lower = -math.inf
    upper = math.inf
    reach = load / max(values.size, 1)
    shift = 0.0
    for _ in range(_MAX_ROUNDS):
        carried = 0.0
        slope = 0.0
        for i in range(values.size):
            value = values[i] - shift
            carried += min(max(value, 0.0), _at(limit, i))
            slope += 1.0 if (value > 0.0) & (value < _at(limit, i)) else 0.0
        excess = carried - load
        if abs(excess) <= error:
            break
        if excess > 0.0:
            lower = shift
        else:
            upper = shift
        trial = shift + excess / slope if slope else math.nan
        if not lower < trial < upper:
            # Sums in any order make a check of infinite values unsafe; comparisons are safe.
            if lower > -math.inf and upper < math.inf:
                trial = 0.5 * (lower + upper)
            else:
                trial = lower + reach if lower > -math.inf else upper - reach
                reach *= 2.0
        if trial in (lower, upper):
            break
        shift = trial
    return shift


@_compiled
def _slopes(residual, step, change):  # type: ignore[no-untyped-def]
    slope = 0.0
    curvature = 0.0
    for i in range(step.size):
        slope += np.float64(residual[i]) * step[i]
        curvature += np.float64(step[i]) * change[i]
    return slope, curvature


@_compiled
def _move(pressure, trial, part, limit):  # type: ignore[no-untyped-def]
    moved = np.empty(pressure.size)
    outside = 0
    for i in range(pressure.size):
        value = pressure[i] + part * (trial[i] - pressure[i])
        outside += (value < 0.0) | (value > _at(limit, i))
        moved[i] = min(max(value, 0.0), _at(limit, i))
    return moved, outside == 0


@_compiled
def _add(gap, change, part):  # type: ignore[no-untyped-def]
    factor = np.float32(part)
    for i in range(gap.size):
        change[i] *= factor
        gap[i] += change[i]


class CompiledPasses(FieldPasses):
    """The passes compiled by numba; they let other threads run."""

    def __init__(self, limit: Array | None, load: float | None) -> None:
        super().__init__(limit, load)
        self._given = _NO_LIMIT if limit is None else limit, load is not None

    def measure(self, pressure: Array, gap: RealArray) -> tuple[float, float]:
        """See `FieldPasses.measure`."""
        return _measure(pressure, gap, *self._given)

    def release(self, pressure: Array, gap: RealArray) -> tuple[RealArray, Mask, int]:
        """See `FieldPasses.release`."""
        return _release(pressure, gap, *self._given)

    def conjugate(
        self, image: RealArray, residual: RealArray, active: Mask, last: LastStep | None
    ) -> tuple[RealArray, float]:
        """See `FieldPasses.conjugate`."""
        if last is None:
            return _conjugate(image, residual, active, _NO_FIELD, _NO_FIELD, 1.0)
        return _conjugate(image, residual, active, last.step, last.change, last.curvature)

    def admit(
        self, direction: RealArray, residual: RealArray, active: Mask, pressure: Array
    ) -> tuple[RealArray, float]:
        """See `FieldPasses.admit`."""
        return _admit(direction, residual, active, pressure, *self._given)

    def advance(
        self, pressure: Array, direction: RealArray, length: float, active: Mask
    ) -> tuple[Array, RealArray, bool]:
        """See `FieldPasses.advance`."""
        return _advance(pressure, direction, length, active, *self._given)

    def slopes(self, residual: RealArray, step: RealArray, change: RealArray) -> tuple[float, float]:
        """See `FieldPasses.slopes`."""
        return _slopes(residual, step, change)

    def move(self, pressure: Array, trial: Array, part: float) -> tuple[Array, bool]:
        """See `FieldPasses.move`."""
        return _move(pressure, trial, part, self._given[0])

    def add(self, gap: RealArray, change: RealArray, part: float) -> None:
        """See `FieldPasses.add`."""
        _add(gap, change, part)
