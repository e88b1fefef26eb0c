"""The masked descent: an iteration of fixed shapes in which the host reads no number.

The mathematics is that of the default solver: conjugate gradients, preconditioned by the inverse kernel on the active
cells with flat-punch weights and a correction on blocks; the step is guessed, its displacement computed once and its
length corrected. Lists of active cells are masks, branches are `torch.where`, searches have fixed numbers of rounds.
"""

from __future__ import annotations

from typing import NamedTuple

import attrs
import torch

from roughcontact_torch.masked_grid import Blocks, MaskedGrid, divide

# Lengths of steps in units of the direction, parts of steps that are taken, the minimum slope of a conjugate direction,
# the minimum weight and the minimum ratio of the singular values of rigid pressures, as in the default solver; with a
# limit more steps are taken in full, because cells that a shortened step leaves just below it shorten the next ones.
_FIRST_LENGTH = 0.65
_MAX_LENGTH = 1.5
_CAREFUL_LENGTH = 0.3
_FULL_STEP_PART = 0.75
_FULL_STEP_PART_WITH_LIMIT = 0.65
_SHORTENED_STEP_PART = 0.1
_MIN_CONJUGATE_SLOPE = 0.01
_MIN_WEIGHT = 1e-3
_MIN_DETERMINANT = 1e-6
# Rounds of the search for released cells that stay and of the shift that restores a load, without a limit, with one in
# a step, and to rounding; and steps on the blocks.
_HELD_ROUNDS = 3
_LOAD_ROUNDS = 6
_CAPPED_STEP_ROUNDS = 8
_CAPPED_LOAD_ROUNDS = 12
_BLOCK_STEPS = 4
# Part of the mean overlap of the contacts of a block that a step removes, as in the default solver.
_RELEASE_PART = 0.7
# Rounding of the gap over its largest term, and the range of the displacement over the maximum pressure below which the
# pressure is uniform, as in `ContactConditions`.
_GAP_ROUNDING = 16.0 * torch.finfo(torch.float64).eps
_UNIFORM_RANGE = 1e-12
# Relative error of a load by rounding.
_LOAD_ROUNDING = 5e-13
# Distance from the limit, over it, within which a cell that would rise is saturated: a step that ends just below would
# shorten all others. It falls with the error.
_NEAR_LIMIT = 1e-3
# Maximum of that distance over the one of the mean pressure.
_NEAR_LIMIT_OF_MEAN = 0.1


class State(NamedTuple):
    """The contacts on one grid: pressures in float64, gaps from any datum in float32, and the last step.

    Attributes
    ----------
    pressure, gap
        Shape (contacts, nx, ny).
    active
        The cells whose pressure may change.
    punch, weights
        The inverse kernel applied to the active cells; flat-punch weights: the same above zero, and zero elsewhere.
    changed
        Cells that have joined or left since `punch` was computed by a product.
    step, change, curvature
        The last step, the displacement by it and their product; curvature zero: there is none.
    length
        The next length of a step.
    near_limit
        Distance from the limit, over it, of saturated cells.
    rigid
        For a given approach the inverse of the stiffness of two rigid pressures, shape (contacts, 2, 2).
    """

    pressure: torch.Tensor
    gap: torch.Tensor
    active: torch.Tensor
    punch: torch.Tensor
    weights: torch.Tensor
    changed: torch.Tensor
    step: torch.Tensor
    change: torch.Tensor
    curvature: torch.Tensor
    length: torch.Tensor
    near_limit: torch.Tensor
    rigid: torch.Tensor


class Violations(NamedTuple):
    """The violations of the conditions of contact, see `Violation`: numbers of contacts, shape (contacts, 1, 1)."""

    error: torch.Tensor
    floor: torch.Tensor
    scale: torch.Tensor
    approach: torch.Tensor


@attrs.frozen(eq=False)
class MaskedDescent:
    """Lowers the energy of contacts on one grid within the bounds of the pressure.

    Attributes
    ----------
    grid
        The grid and its convolution.
    initial_gap
        Gap before deformation, shape (contacts, nx, ny).
    limit
        Maximum pressure, shape (contacts, 1, 1); infinite without one.
    rms
        The standard deviation of the initial gap, shape (contacts, 1, 1).
    load
        Sum of the pressure over the cells, shape (contacts, 1, 1); None: the approach is given.
    approach
        The given approach, shape (contacts, 1, 1).
    capped
        Whether any limit is finite.
    """

    grid: MaskedGrid
    initial_gap: torch.Tensor
    limit: torch.Tensor
    rms: torch.Tensor
    load: torch.Tensor | None
    approach: torch.Tensor
    capped: bool

    def start(self, pressure: torch.Tensor, displacement: torch.Tensor) -> tuple[State, Violations]:
        """Return the state of pressures, float64, with their displacement in either precision, and its violations."""
        gap, violations = self._measure(pressure, displacement)
        nothing = torch.zeros_like(pressure, dtype=torch.float32)
        one = torch.ones_like(self.limit)
        active = self._is_inside(pressure, self._near_limit(one))
        if self.load is None:
            # Nothing may be in contact yet.
            active = active | (gap < 0.0)
        state = State(
            pressure=pressure,
            gap=gap,
            active=active,
            punch=nothing,
            weights=nothing,
            changed=0.0 * one,
            step=nothing,
            change=nothing,
            curvature=0.0 * one,
            length=_FIRST_LENGTH * one,
            near_limit=self._near_limit(violations.error),
            rigid=torch.zeros((*one.shape[:1], 2, 2), dtype=torch.float64, device=one.device),
        )
        return self.renew(state), violations

    def renew(self, state: State) -> State:
        """Return the state with weights that are computed anew by a product."""
        punch = self.grid.invert(state.active.to(torch.float32))
        state = self._weigh(state._replace(punch=punch, changed=torch.zeros_like(state.changed)))
        return state if self.load is not None else state._replace(rigid=self._invert_rigid(state))

    def iterate(self, state: State, blocks: Blocks) -> State:
        """Return the state after one step."""
        state = self._activate(state, blocks)
        residual = torch.where(state.active, self._level(state.gap, state.weights).to(torch.float32) - state.gap, 0.0)
        image = self._precondition(state, blocks, residual)
        return self._move(state, residual, self._find_direction(state, residual, image))

    def restore(self, state: State) -> torch.Tensor:
        """Return the pressure with the load, and with cells near the limit that would rise at the limit."""
        pressure = state.pressure
        if self.capped:
            inside = self._is_inside(pressure, torch.zeros_like(self.limit))
            near = inside & ~self._is_inside(pressure, state.near_limit)
            level = self._level(state.gap, state.weights).to(torch.float32)
            pressure = torch.where(near & (state.gap < level), self.limit, pressure)
        return pressure if self.load is None else self.rescale(pressure)

    def verify(self, state: State) -> tuple[State, Violations]:
        """Return the state with its load and its gap in float64, which is rounded, and its violations."""
        pressure = self.restore(state)
        gap, violations = self._measure(pressure, self.grid.displace(pressure))
        return state._replace(pressure=pressure, gap=gap, near_limit=self._near_limit(violations.error)), violations

    def estimate(self, state: State, scale: torch.Tensor) -> torch.Tensor:
        """Return the error of a state by its gap in float32, over a scale."""
        level = self._level(state.gap, self._split(state.pressure)[0])
        return self._error(state.pressure, state.gap - level.to(torch.float32)) / scale

    def close(self) -> torch.Tensor | None:
        """Return the pressures that close every gap, without regard to their bounds; None if there are none."""
        return None if self.load is None else self.grid.close(self.initial_gap, self.load / self.grid.cells)

    def from_level(self, state: State) -> torch.Tensor:
        """Return the gap from its level, float32."""
        return state.gap - self._level(state.gap, self._split(state.pressure)[0]).to(torch.float32)

    def rescale(self, pressure: torch.Tensor) -> torch.Tensor:
        """Return pressures with the load: the elastic part is scaled, or cells are shifted, as by `rescale_to_load`."""
        assert self.load is not None
        total = self.grid.total
        elastic, _ = self._split(pressure)
        carried = total(pressure) - total(elastic)
        room = total(torch.where(elastic > 0.0, self.limit, 0.0))
        scaled = (self.load >= carried) & (self.load < carried + room)
        contact = pressure > 0.0
        lowered = self.load < total(torch.where(contact, self.limit, 0.0))
        ones = torch.where(lowered, contact.to(torch.float64), 1.0)
        shifted = self._shift_to_load(pressure, torch.where(scaled, elastic, ones), _CAPPED_LOAD_ROUNDS)
        full = self.load >= (1.0 - _LOAD_ROUNDING) * self.grid.cells * self.limit
        return torch.where(full, self.limit, shifted)

    def _measure(self, pressure: torch.Tensor, displacement: torch.Tensor) -> tuple[torch.Tensor, Violations]:
        """Return the gap in float32, and the violations as by `ContactConditions.measure`."""
        grid = self.grid
        gap = displacement.to(torch.float64) + self.initial_gap
        level = self._separating_level(pressure, gap)
        gap = gap - level
        high = grid.highest(displacement).to(torch.float64)
        low = grid.lowest(displacement).to(torch.float64)
        peak = grid.highest(pressure)
        extent = torch.where(high - low > _UNIFORM_RANGE * peak, high - low, 0.0)
        small = torch.minimum(self.rms, extent)
        scale = torch.where(small > 0.0, small, torch.maximum(self.rms, extent))
        scale = torch.where(scale > 0.0, scale, 1.0)
        violation = self._error(pressure, gap)
        # Even an approach that is small beside the heights needs pressure.
        unloaded = (peak == 0.0) & (violation > 0.0)
        scale = torch.where(unloaded, torch.minimum(scale, violation), scale)
        floor = _GAP_ROUNDING * (torch.maximum(torch.maximum(high, -low), peak) + level.abs()) / scale
        error = torch.maximum(violation / scale, floor)
        if self.load is not None:
            # A pressure without its load does not solve the contact.
            missing = (grid.total(pressure) / self.load - 1.0).abs()
            error = torch.where(missing <= _LOAD_ROUNDING, error, torch.clamp(error, min=1.0))
        return gap.to(torch.float32), Violations(error, floor, scale, level)

    def _separating_level(self, pressure: torch.Tensor, gap: torch.Tensor) -> torch.Tensor:
        """Return the approach: given, or the mean of the elastic cells, or between saturated and open ones."""
        if self.load is None:
            return self.approach
        grid = self.grid
        elastic, saturated = self._split(pressure)
        opened = grid.lowest(torch.where(saturated, torch.inf, gap))
        pressed = grid.highest(torch.where(saturated, gap, -torch.inf))
        between = torch.where(torch.isfinite(opened), 0.5 * (opened + pressed), pressed)
        weight = grid.total(elastic)
        return torch.where(weight > 0.0, divide(grid.dot(elastic, gap), weight), between)

    def _error(self, pressure: torch.Tensor, gap: torch.Tensor) -> torch.Tensor:
        """Return the pressure-weighted open gap or, if it is larger, the overlap of cells that are not saturated."""
        if self.capped:
            gap = torch.where(self._split(pressure)[1], torch.clamp(gap, min=0.0), gap)
        grid = self.grid
        opened = grid.mean(gap.abs(), pressure)
        return torch.maximum(opened, -grid.lowest(gap).to(torch.float64))

    def _level(self, gap: torch.Tensor, weights: torch.Tensor) -> torch.Tensor:
        """Return the level of the gap: its weighted mean, or zero if the approach is given."""
        if self.load is None:
            return torch.zeros_like(self.limit)
        return self.grid.mean(gap, weights)

    def _split(self, pressure: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """Return the pressure of the cells that are not saturated, zero elsewhere, and which are."""
        saturated = pressure >= self.limit
        return torch.where(saturated, 0.0, pressure), saturated

    def _near_limit(self, error: torch.Tensor) -> torch.Tensor:
        """Return the distance from the limit, over it, of cells that count as saturated at an error."""
        near = _NEAR_LIMIT * torch.clamp(error, max=1.0)
        if self.load is None:
            return near
        mean = self.load / self.grid.cells
        return torch.minimum(near, _NEAR_LIMIT_OF_MEAN * (1.0 - mean / self.limit))

    def _is_inside(self, pressure: torch.Tensor, near: torch.Tensor) -> torch.Tensor:
        inside = pressure > 0.0
        return inside & (pressure < self.limit * (1.0 - near)) if self.capped else inside

    def _activate(self, state: State, blocks: Blocks) -> State:
        """Return the state with its active cells: those inside the bounds, and those released by their gap."""
        inside = self._is_inside(state.pressure, state.near_limit)
        weights = state.weights * inside
        contact = state.pressure > 0.0
        if self.load is not None:
            # Without an elastic cell the level is that of the saturated ones.
            weights = torch.where(self.grid.total(weights) > 0.0, weights, contact.to(torch.float32))
        level = self._level(state.gap, weights).to(torch.float32)
        low = state.gap < (level if self.capped else self._release_level(state.gap, weights, level, blocks))
        active = torch.where(contact, inside | (state.gap > level), low) if self.capped else inside | low
        joined = active.to(torch.float32) - state.active.to(torch.float32)
        grid = self.grid
        if grid.takes_stencil:
            punch = state.punch + grid.invert_near(joined) + blocks.invert_far(joined)
        else:
            punch = grid.invert(active.to(torch.float32))
        changed = state.changed + grid.total(joined.abs())
        return self._weigh(state._replace(active=active, punch=punch, changed=changed))

    def _release_level(
        self, gap: torch.Tensor, weights: torch.Tensor, level: torch.Tensor, blocks: Blocks
    ) -> torch.Tensor:
        """Return the gap below which open cells join: lower where the contacts of a block overlap on the mean."""
        loads, excess = blocks.sums(torch.stack((weights, weights * (gap - level))))
        return level + blocks.spread(_RELEASE_PART * torch.clamp(divide(excess, loads), max=0.0))

    def _weigh(self, state: State) -> State:
        """Return the state with the weights of its active cells, above zero."""
        ones = state.active.to(torch.float32)
        weights = state.punch * ones
        mean = self.grid.ratio(weights, ones).to(torch.float32)
        weights = torch.where(mean > 0.0, torch.maximum(weights, _MIN_WEIGHT * mean), 1.0)
        return state._replace(weights=weights * ones)

    def _invert_rigid(self, state: State) -> torch.Tensor:
        """Return the inverse of the stiffness of the flat-punch weights and a uniform pressure."""
        vectors = state.weights, state.active.to(torch.float32)
        images = [self.grid.displace(vector) for vector in vectors]
        a, b, c = self.grid.dots(*((vectors[i], images[j]) for i, j in ((0, 0), (0, 1), (1, 1))))
        determinant = a * c - b * b
        distinct = determinant > _MIN_DETERMINANT * a * c
        safe = torch.where(distinct, determinant, 1.0)
        first = torch.where(distinct, c / safe, divide(torch.ones_like(a), a))
        mixed = torch.where(distinct, -b / safe, 0.0)
        second = torch.where(distinct, a / safe, 0.0)
        return torch.cat((torch.cat((first, mixed), -1), torch.cat((mixed, second), -1)), -2)

    def _precondition(self, state: State, blocks: Blocks, residual: torch.Tensor) -> torch.Tensor:
        """Return the inverse kernel applied to a residual between masks, with both corrections."""
        grid = self.grid
        image = torch.where(state.active, grid.invert(residual), 0.0)
        mean = grid.mean_weight(state.weights).to(torch.float32)
        solution = _solve_on_blocks(blocks, blocks.sums(state.weights), mean, blocks.sums(state.weights * residual))
        corrected = image - state.weights * blocks.spread(solution)
        # Where weights ring, the correction may turn the direction uphill.
        image = torch.where(grid.dot(residual, corrected) > 0.0, corrected, image)
        if self.load is not None:
            return image
        ones = state.active.to(torch.float32)
        sums = torch.cat(grid.dots((state.weights, residual), (ones, residual)), -2)
        parts = (state.rigid @ sums).to(torch.float32)
        first = parts[..., :1, :]
        second = parts[..., 1:, :]
        fraction = grid.ratio(image, state.weights).to(torch.float32)
        return image + (first - fraction) * state.weights + second * ones

    def _find_direction(self, state: State, residual: torch.Tensor, image: torch.Tensor) -> torch.Tensor:
        """Return the conjugate, the preconditioned or the plain gradient, made admissible."""
        grid = self.grid
        factor = divide(-grid.dot(image, torch.where(state.active, state.change, 0.0)), state.curvature)
        factor = torch.clamp(factor, min=0.0).to(torch.float32)
        conjugate = image + factor * torch.where(state.active, state.step, 0.0)
        slope, conjugate_slope = grid.dots((residual, image), (residual, conjugate))
        steep = conjugate_slope > _MIN_CONJUGATE_SLOPE * slope
        plain = torch.where(slope > 0.0, image, state.weights * residual)
        return self._admit(state, torch.where(steep & (slope > 0.0), conjugate, plain))

    def _admit(self, state: State, direction: torch.Tensor) -> torch.Tensor:
        """Return the nearest direction, of sum zero for a given load, in which no released cell crosses its bound."""
        low = state.active & (state.pressure <= 0.0)
        high = state.active & (state.pressure >= self.limit)
        if self.load is not None:
            shift = self.grid.ratio(direction, state.weights)
            for _ in range(_HELD_ROUNDS):
                moved = direction - shift.to(torch.float32) * state.weights
                held = (low & (moved < 0.0)) | (high & (moved > 0.0))
                free = torch.where(held, 0.0, state.weights)
                shift = self.grid.ratio(torch.where(held, 0.0, direction), free)
            direction = direction - shift.to(torch.float32) * state.weights
        direction = torch.where(low, torch.clamp(direction, min=0.0), direction)
        return torch.where(high, torch.clamp(direction, max=0.0), direction)

    def _move(self, state: State, residual: torch.Tensor, direction: torch.Tensor) -> State:
        """Return the state after a part of a step along a direction; none of it costs the iteration."""
        grid = self.grid
        before = state.pressure
        trial = before + state.length * direction
        clipped = self._leaves(trial)
        whole_step = torch.where(clipped, self._clip(trial, state), trial) - before
        del trial
        step = whole_step.to(torch.float32)
        change = grid.displace(step)
        curvature, slope = grid.dots((step, change), (residual, step))
        part = divide(slope, curvature)
        usable = (slope > 0.0) & (curvature > 0.0) & torch.isfinite(curvature)
        leaves = self._leaves(before + part * whole_step)
        shortened = torch.where(part > _SHORTENED_STEP_PART, part, 0.0)
        whole = part > (_FULL_STEP_PART_WITH_LIMIT if self.capped else _FULL_STEP_PART)
        inner = torch.where(leaves, torch.clamp(part, max=1.0), part)
        taken = torch.where(clipped, torch.where(whole, 1.0, shortened), inner)
        taken = torch.where(usable, taken, 0.0)
        accepted = taken > 0.0
        after_clip = torch.where(whole, torch.clamp(part, 0.8, 4.0).sqrt(), torch.clamp(part, 0.5, 1.0))
        grown = torch.where(clipped, after_clip, torch.clamp(part, 0.25, 4.0))
        length = torch.clamp(state.length * torch.where(accepted, grown, _CAREFUL_LENGTH), max=_MAX_LENGTH)
        change = taken.to(torch.float32) * change
        return state._replace(
            pressure=self._bound(before + taken * whole_step),
            gap=state.gap + change,
            step=torch.where(accepted, step, state.step),
            change=torch.where(accepted, change, state.change),
            curvature=torch.where(accepted, taken * curvature, torch.where(usable, state.curvature, 0.0)),
            length=length,
        )

    def _leaves(self, pressure: torch.Tensor) -> torch.Tensor:
        """Return whether pressures leave their bounds."""
        below = self.grid.lowest(pressure) < 0.0
        return below | (self.grid.highest(pressure) > self.limit) if self.capped else below

    def _clip(self, trial: torch.Tensor, state: State) -> torch.Tensor:
        """Return pressures near a trial within the bounds and, if it is given, with the load."""
        if self.load is None:
            return self._bound(trial)
        return self._shift_to_load(trial, state.weights, _CAPPED_STEP_ROUNDS)

    def _bound(self, pressure: torch.Tensor) -> torch.Tensor:
        """Return pressures cut off at their bounds."""
        above = torch.clamp(pressure, min=0.0)
        return torch.minimum(above, self.limit) if self.capped else above

    def _shift_to_load(self, values: torch.Tensor, weights: torch.Tensor, capped_rounds: int) -> torch.Tensor:
        """Return clip(values - shift * weights, 0, limit) with a shift for which the sum is about the load.

        With a limit Newton's method needs a bracket, in which it is replaced by bisection where it leaves it.
        """
        load = self.load
        assert load is not None
        grid = self.grid
        shift = torch.zeros_like(load)
        low = torch.full_like(load, -torch.inf)
        high = torch.full_like(load, torch.inf)
        weight = grid.total(weights)
        for k in range(capped_rounds if self.capped else _LOAD_ROUNDS):
            moved = values - shift * weights
            moving = self._is_inside(moved, torch.zeros_like(load))
            carried, slope = grid.totals((self._bound(moved), torch.where(moving, weights, 0.0)))
            excess = carried - load
            trial = shift + divide(excess, slope)
            if self.capped:
                low = torch.where(excess > 0.0, shift, low)
                high = torch.where(excess < 0.0, shift, high)
                half = torch.where(
                    torch.isfinite(high - low), 0.5 * (low + high), shift + 2.0**k * divide(excess, weight)
                )
                trial = torch.where((slope > 0.0) & (trial > low) & (trial < high), trial, half)
            shift = torch.where(excess == 0.0, shift, trial)
        return self._bound(values - shift * weights)


def _solve_on_blocks(blocks: Blocks, diagonal: torch.Tensor, mean: torch.Tensor, right: torch.Tensor) -> torch.Tensor:
    """Solve the system of the correction to a few per cent, by conjugate gradients of a fixed number of steps."""
    size = right.abs().amax((-2, -1), keepdim=True)
    size = torch.where(size > 0.0, size, 1.0)
    uniform = blocks.size * torch.where(mean > 0.0, mean, 1.0)
    approximate = 1.0 / (blocks.far_symbol(torch.where(mean > 0.0, mean, 1.0)) + uniform)
    rest = diagonal - uniform
    residual = right / size
    solution = direction = response = torch.zeros_like(right)
    previous = torch.full_like(size, torch.inf)
    going = torch.ones_like(size, dtype=torch.bool)
    for _ in range(_BLOCK_STEPS):
        image = blocks.multiply(residual, approximate)
        product = _sum(residual * image)
        factor = product / previous
        direction = image + factor * direction
        response = residual + rest * image + factor * response
        curvature = _sum(direction * response)
        going = going & (curvature > 0.0) & (product > 0.0)
        part = torch.where(going, divide(product, curvature), 0.0)
        solution = solution + part * direction
        residual = residual - part * response
        previous = torch.where(going, product, torch.inf)
    return solution * size


def _sum(values: torch.Tensor) -> torch.Tensor:
    """Return the sum over the blocks of each contact."""
    return values.sum((-2, -1), keepdim=True)
