"""The passes of a descent on whole fields, compiled: one loop over the cells each."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from roughcontact.typing import Array, FieldPasses, Mask, RealArray

# Maximum rounds of Newton's method for the shift that keeps the load, and for the released cells that stay on a bound.
_MAX_ROUNDS = 60
_MAX_RELEASED_ROUNDS = 20
# Error of the load in a step, over the change of pressure, and over the load by rounding.
_STEP_LOAD_ERROR = 1e-5
_LOAD_EPSILON = 4e-16
_NO_LIMIT = np.array([math.inf])
_NO_FIELD = np.zeros(0, dtype=np.float32)
# Sums are in float64 and in the order of the cells, so that their bits do not depend on the machine's vectors.
_compiled = njit(cache=True, nogil=True, error_model="numpy")


@_compiled
def _measure(pressure, gap, limit, by_load):  # type: ignore[no-untyped-def]
    stride = 1 if limit.size > 1 else 0
    carried = 0.0
    weighted = 0.0
    total = 0.0
    for i in range(pressure.size):
        value = pressure[i]
        if value > 0.0:
            total += value
            if value < limit[i * stride]:
                carried += value
                weighted += value * gap[i]
    level = weighted / carried if by_load and carried > 0.0 else 0.0
    opened = 0.0
    overlap = -math.inf
    for i in range(pressure.size):
        rest = gap[i] - level
        value = pressure[i]
        if value > 0.0:
            if value >= limit[i * stride]:
                rest = max(rest, 0.0)
            opened += value * abs(rest)
        overlap = max(overlap, -rest)
    return level, max(opened / total if total > 0.0 else 0.0, overlap)


@_compiled
def _release(pressure, gap, limit, by_load):  # type: ignore[no-untyped-def]
    stride = 1 if limit.size > 1 else 0
    level = 0.0
    count = 0
    if by_load:
        for i in range(pressure.size):
            if 0.0 < pressure[i] < limit[i * stride]:
                level += gap[i]
                count += 1
        level = level / count if count else 0.0
    active = np.empty(pressure.size, dtype=np.bool_)
    residual = np.zeros(pressure.size, dtype=np.float32)
    count = 0
    mean = 0.0
    for i in range(pressure.size):
        if pressure[i] <= 0.0:
            found = gap[i] < level
        else:
            found = pressure[i] < limit[i * stride] or gap[i] > level
        active[i] = found
        if found:
            count += 1
            mean += gap[i]
    mean = mean / count if by_load and count else 0.0
    for i in range(pressure.size):
        if active[i]:
            residual[i] = mean - gap[i]
    return residual, active, count


@_compiled
def _conjugate(image, active, step, change, curvature):  # type: ignore[no-untyped-def]
    product = 0.0
    for i in range(image.size):
        if not active[i]:
            image[i] = 0.0
        elif step.size:
            product += np.float64(image[i]) * change[i]
    factor = -product / curvature
    direction = image.copy()
    if step.size and factor > 0.0:
        for i in range(image.size):
            if active[i]:
                direction[i] += np.float32(factor) * step[i]
    return direction


@_compiled
def _admit(direction, residual, active, pressure, limit, by_load):  # type: ignore[no-untyped-def]
    stride = 1 if limit.size > 1 else 0
    mean = 0.0
    if by_load:
        before = -1
        for _ in range(_MAX_RELEASED_ROUNDS):
            change = 0.0
            count = 0
            held = 0
            for i in range(direction.size):
                if not active[i]:
                    continue
                value = direction[i]
                down = pressure[i] <= 0.0 and value < mean
                up = pressure[i] >= limit[i * stride] and value > mean
                if before >= 0 and (down or up):
                    held += 1
                else:
                    change += value
                    count += 1
            if held == before or count == 0:
                break
            before = held
            mean = change / count
    admitted = np.zeros(direction.size, dtype=np.float32)
    slope = 0.0
    for i in range(direction.size):
        if active[i]:
            value = direction[i] - np.float32(mean)
            if pressure[i] <= 0.0:
                value = max(value, np.float32(0.0))
            if pressure[i] >= limit[i * stride]:
                value = min(value, np.float32(0.0))
            admitted[i] = value
            slope += np.float64(residual[i]) * value
    return admitted, slope


@_compiled
def _advance(pressure, direction, length, active, limit, by_load):  # type: ignore[no-untyped-def]
    stride = 1 if limit.size > 1 else 0
    trial = np.empty(pressure.size)
    step = np.zeros(pressure.size, dtype=np.float32)
    load = 0.0
    change = 0.0
    clipped = False
    for i in range(pressure.size):
        trial[i] = pressure[i] + length * direction[i]
        if active[i]:
            load += pressure[i]
            change += abs(direction[i])
            clipped |= not 0.0 <= trial[i] <= limit[i * stride]
    if clipped:
        shift = 0.0
        if by_load:
            shift = _find_shift(trial, active, limit, load, max(_STEP_LOAD_ERROR * length * change, _LOAD_EPSILON * load))
        for i in range(pressure.size):
            if active[i]:
                trial[i] = min(max(trial[i] - shift, 0.0), limit[i * stride])
    for i in range(pressure.size):
        if active[i]:
            step[i] = trial[i] - pressure[i]
    return trial, step, clipped


@_compiled
def _find_shift(values, active, limit, load, error):  # type: ignore[no-untyped-def]
    """Return the shift for which clip(values - shift, 0, limit) sums to the load over the active cells."""
    stride = 1 if limit.size > 1 else 0
    lower = -math.inf
    upper = math.inf
    reach = load / max(values.size, 1)
    shift = 0.0
    for _ in range(_MAX_ROUNDS):
        excess = -load
        slope = 0
        for i in range(values.size):
            if active[i]:
                carried = values[i] - shift
                if carried >= limit[i * stride]:
                    excess += limit[i * stride]
                elif carried > 0.0:
                    excess += carried
                    slope += 1
        if abs(excess) <= error:
            break
        if excess > 0.0:
            lower = shift
        else:
            upper = shift
        trial = shift + excess / slope if slope else math.nan
        if not lower < trial < upper:
            if math.isfinite(upper - lower):
                trial = 0.5 * (lower + upper)
            else:
                trial = lower + reach if math.isfinite(lower) else upper - reach
                reach *= 2.0
        if trial == lower or trial == upper:
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
    stride = 1 if limit.size > 1 else 0
    moved = np.empty(pressure.size)
    inside = True
    for i in range(pressure.size):
        value = pressure[i] + part * (trial[i] - pressure[i])
        moved[i] = min(max(value, 0.0), limit[i * stride])
        inside &= moved[i] == value
    return moved, inside


@_compiled
def _add(gap, change, part):  # type: ignore[no-untyped-def]
    for i in range(gap.size):
        change[i] *= np.float32(part)
        gap[i] += change[i]


class CompiledPasses(FieldPasses):
    """The passes compiled by numba; they let other threads run."""

    max_cells = 2**16

    def measure(self, pressure: Array, gap: RealArray, limit: Array | None, load: float | None) -> tuple[float, float]:
        """See `FieldPasses.measure`."""
        found: tuple[float, float] = _measure(pressure, gap, _bound(limit), load is not None)
        return found

    def release(
        self, pressure: Array, gap: RealArray, limit: Array | None, load: float | None
    ) -> tuple[RealArray, Mask, int]:
        """See `FieldPasses.release`."""
        found: tuple[RealArray, Mask, int] = _release(pressure, gap, _bound(limit), load is not None)
        return found

    def conjugate(
        self, image: RealArray, active: Mask, step: RealArray | None, change: RealArray | None, curvature: float
    ) -> RealArray:
        """See `FieldPasses.conjugate`."""
        former = _NO_FIELD if step is None else step
        found: RealArray = _conjugate(image, active, former, _NO_FIELD if change is None else change, curvature)
        return found

    def admit(
        self,
        direction: RealArray,
        residual: RealArray,
        active: Mask,
        pressure: Array,
        limit: Array | None,
        load: float | None,
    ) -> tuple[RealArray, float]:
        """See `FieldPasses.admit`."""
        found: tuple[RealArray, float] = _admit(
            direction, residual, active, pressure, _bound(limit), load is not None
        )
        return found

    def advance(
        self,
        pressure: Array,
        direction: RealArray,
        length: float,
        active: Mask,
        limit: Array | None,
        load: float | None,
    ) -> tuple[Array, RealArray, bool]:
        """See `FieldPasses.advance`."""
        found: tuple[Array, RealArray, bool] = _advance(
            pressure, direction, length, active, _bound(limit), load is not None
        )
        return found

    def slopes(self, residual: RealArray, step: RealArray, change: RealArray) -> tuple[float, float]:
        """See `FieldPasses.slopes`."""
        found: tuple[float, float] = _slopes(residual, step, change)
        return found

    def move(self, pressure: Array, trial: Array, part: float, limit: Array | None) -> tuple[Array, bool]:
        """See `FieldPasses.move`."""
        found: tuple[Array, bool] = _move(pressure, trial, part, _bound(limit))
        return found

    def add(self, gap: RealArray, change: RealArray, part: float) -> None:
        """See `FieldPasses.add`."""
        _add(gap, change, part)


def _bound(limit: Array | None) -> Array:
    return _NO_LIMIT if limit is None else limit
