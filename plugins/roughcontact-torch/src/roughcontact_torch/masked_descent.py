"""The masked descent: an iteration of fixed shapes in which the host reads no number.

The mathematics is that of the default solver: conjugate gradients, preconditioned by the inverse kernel on the active
cells with flat-punch weights and a correction on blocks; the step is guessed, its displacement computed once and its
length corrected. Lists of active cells are masks, branches are `torch.where`, and searches have a fixed number of rounds.
"""

from __future__ import annotations

import attrs
import torch

from roughcontact_torch.masked_grid import Blocks, MaskedGrid, divide, dot, highest, lowest, total

# Lengths of steps in units of the direction, parts of steps that are taken, and the minimum slope of a conjugate
# direction, as in the default solver.
_FIRST_LENGTH = 0.65
_MAX_LENGTH = 1.5
_CAREFUL_LENGTH = 0.3
_FULL_STEP_PART = 0.75
_SHORTENED_STEP_PART = 0.1
_MIN_CONJUGATE_SLOPE = 0.01
_MIN_WEIGHT = 1e-3
_MIN_DETERMINANT = 1e-6
# Rounds of the search for released cells that stay and of the shift that restores a load, and steps on the blocks.
_HELD_ROUNDS = 3
_LOAD_ROUNDS = 6
_BLOCK_STEPS = 4
# Rounding of the gap over its largest term, as in `ContactConditions`.
_GAP_ROUNDING = 16.0 * torch.finfo(torch.float64).eps
# Distance from the limit, over it, within which a cell that would rise is saturated: a step that ends just below would
# shorten all others. It falls with the error.
_NEAR_LIMIT = 1e-3


@attrs.define(eq=False)
class State:
    """The contacts on one grid: pressures in float64, gaps from any datum in float32, and the last step.

    Attributes
    ----------
    pressure, gap
        Shape (contacts, nx, ny).
    weights
        Flat-punch weights of the active cells, zero elsewhere; raw ones of all cells in `punch`.
    active
        The cells whose pressure may change.
    step, change, curvature
        The last step, the displacement by it and their product; curvature zero: there is none.
    length
        The next length of a step.
    near_limit
        Distance from the limit, over it, of saturated cells.
    rigid
        For a given approach the inverse of the stiffness of two rigid pressures, shape (contacts, 2, 2).
    met_limit
        Whether the limit has shortened a step.
    """

    pressure: torch.Tensor
    gap: torch.Tensor
    weights: torch.Tensor
    punch: torch.Tensor
    active: torch.Tensor
    step: torch.Tensor
    change: torch.Tensor
    curvature: torch.Tensor
    length: torch.Tensor
    near_limit: torch.Tensor
    rigid: torch.Tensor
    met_limit: torch.Tensor


class MaskedDescent:
    """Lowers the energy of contacts on one grid within the bounds of the pressure.

    Parameters
    ----------
    grid
        The grid and its convolution.
    limit
        Maximum pressure, shape (contacts, 1, 1); infinite without one.
    load
        Sum of the pressure over the cells, shape (contacts, 1, 1); None: the gap is given from the approach.
    capped
        Whether any limit is finite.
    """

    def __init__(self, grid: MaskedGrid, limit: torch.Tensor, load: torch.Tensor | None, *, capped: bool) -> None:
        self.grid = grid
        self.limit = limit
        self.load = load
        self.capped = capped

    def start(self, pressure: torch.Tensor, gap: torch.Tensor) -> State:
        """Return the state of pressures, float64, and their gaps, float32."""
        one = torch.ones_like(self.limit)
        inside = self._is_inside(pressure, one * _NEAR_LIMIT)
        state = State(
            pressure=pressure,
            gap=gap,
            weights=inside.to(torch.float32),
            punch=torch.zeros_like(gap),
            active=torch.zeros_like(inside),
            step=torch.zeros_like(gap),
            change=torch.zeros_like(gap),
            curvature=torch.zeros_like(one),
            length=_FIRST_LENGTH * one,
            near_limit=_NEAR_LIMIT * one,
            rigid=torch.zeros((*one.shape[:1], 2, 2), dtype=torch.float64, device=one.device),
            met_limit=torch.zeros_like(one, dtype=torch.bool),
        )
        self._weigh(state, inside, renew=True)
        return state

    def mean_weight(self, state: State) -> torch.Tensor:
        """Return the mean weight over the padded grid, by which blocks are chosen."""
        mx, my = self.grid.inverse.padded
        return total(state.weights) / (mx * my)

    def iterate(self, state: State, blocks: Blocks, *, renew: bool) -> State:
        """Return the state after one step; `renew`: compute weights by a product instead of by a stencil."""
        state = attrs.evolve(state)
        self._weigh(state, self._find_active(state), renew=renew)
        level = self._level(state.gap, state.weights)
        residual = torch.where(state.active, level.to(torch.float32) - state.gap, 0.0)
        image = self._precondition(state, blocks, residual)
        direction = self._find_direction(state, residual, image)
        self._move(state, residual, direction)
        return state

    def measure(self, state: State, initial_gap: torch.Tensor, approach: torch.Tensor, rms: torch.Tensor) -> Verified:
        """Return pressures that carry their load and their errors in float64; see `ContactConditions`."""
        self._restore(state)
        displacement = self.grid.displace(state.pressure)
        gap = displacement + initial_gap
        elastic, saturated = self._split(state)
        level = approach
        if self.load is not None:
            weight = total(elastic)
            between = 0.5 * (
                lowest(torch.where(saturated, torch.inf, gap)) + highest(torch.where(saturated, gap, -torch.inf))
            )
            mean = dot(elastic, gap) / torch.where(weight > 0.0, weight, 1.0)
            level = torch.where(weight > 0.0, mean, torch.where(torch.isfinite(between), between, highest(gap)))
        gap = gap - level
        error = torch.where(saturated, torch.clamp(gap, min=0.0), gap)
        extent = highest(displacement) - lowest(displacement)
        extent = torch.where(extent > 1e-12 * highest(state.pressure), extent, 0.0)
        small = torch.minimum(rms, extent)
        scale = torch.where(small > 0.0, small, torch.maximum(rms, extent))
        scale = torch.where(scale > 0.0, scale, 1.0)
        open_gap = divide(dot(state.pressure, error.abs()), total(state.pressure))
        found = torch.maximum(open_gap, -lowest(error)) / scale
        size = torch.maximum(torch.maximum(highest(displacement), -lowest(displacement)), highest(state.pressure))
        floor = _GAP_ROUNDING * (size + level.abs()) / scale
        state.gap = gap.to(torch.float32)
        state.near_limit = torch.clamp(_NEAR_LIMIT * found, max=_NEAR_LIMIT)
        return Verified(torch.maximum(found, floor), floor)

    def from_level(self, state: State) -> torch.Tensor:
        """Return the gap from its level, float32."""
        return state.gap - self._level(state.gap, self._split(state)[0]).to(torch.float32)

    def project_to_load(self, pressure: torch.Tensor, load: torch.Tensor) -> torch.Tensor:
        """Return pressures of which the elastic part is scaled to the load, as in `rescale_to_load`."""
        elastic = torch.where(pressure < self.limit, pressure, 0.0)
        weights = torch.where(total(elastic) > 0.0, elastic, 1.0)
        return self._shift_to_load(pressure, weights, load, _LOAD_ROUNDS)

    def _level(self, gap: torch.Tensor, weights: torch.Tensor) -> torch.Tensor:
        """Return the level of the gap: its weighted mean, or zero if the approach is given."""
        if self.load is None:
            return torch.zeros_like(self.limit)
        return divide(dot(weights, gap), total(weights))

    def _split(self, state: State) -> tuple[torch.Tensor, torch.Tensor]:
        """Return the pressure of the cells that are not saturated, zero elsewhere, and which are."""
        saturated = state.pressure >= self.limit
        return torch.where(saturated, 0.0, state.pressure), saturated

    def _is_inside(self, pressure: torch.Tensor, near: torch.Tensor) -> torch.Tensor:
        inside = pressure > 0.0
        return inside & (pressure < self.limit * (1.0 - near)) if self.capped else inside

    def _find_active(self, state: State) -> torch.Tensor:
        """Return the cells inside the bounds, and the cells released from a bound by the sign of their gap."""
        inside = self._is_inside(state.pressure, state.near_limit)
        weights = state.weights * inside
        if self.load is not None:
            # Without an elastic cell the level separates saturated from open ones.
            weights = torch.where(total(weights) > 0.0, weights, (state.pressure > 0.0).to(torch.float32))
        level = self._level(state.gap, weights).to(torch.float32)
        low = state.gap < level
        if not self.capped:
            return inside | low
        contact = state.pressure > 0.0
        return torch.where(contact, inside | (state.gap > level), low)

    def _weigh(self, state: State, active: torch.Tensor, *, renew: bool) -> None:
        """Set the active cells and their weights, M 1 with the inverse kernel M on the active cells."""
        if renew or not self.grid.takes_stencil:
            state.punch = self.grid.invert(active.to(torch.float32))
        else:
            joined = active.to(torch.float32) - state.active.to(torch.float32)
            state.punch = state.punch + self.grid.invert_near(joined)
        ones = active.to(torch.float32)
        weights = torch.where(active, state.punch, 0.0)
        mean = divide(total(weights), total(ones)).to(torch.float32)
        weights = torch.where(mean > 0.0, torch.maximum(weights, _MIN_WEIGHT * mean), 1.0)
        state.active = active
        state.weights = weights * ones
        if renew and self.load is None:
            state.rigid = self._invert_rigid(state)

    def _invert_rigid(self, state: State) -> torch.Tensor:
        """Return the inverse of the stiffness of the flat-punch weights and a uniform pressure."""
        vectors = state.weights, state.active.to(torch.float32)
        images = [self.grid.displace(vector) for vector in vectors]
        a, b, c = (dot(vectors[i], images[j]) for i, j in ((0, 0), (0, 1), (1, 1)))
        determinant = a * c - b * b
        distinct = determinant > _MIN_DETERMINANT * a * c
        safe = torch.where(distinct, determinant, 1.0)
        entries = (
            torch.where(distinct, c / safe, divide(torch.ones_like(a), a)),
            torch.where(distinct, -b / safe, 0.0),
            torch.where(distinct, a / safe, 0.0),
        )
        first, mixed, second = (entry[..., 0] for entry in entries)
        return torch.stack((torch.cat((first, mixed), -1), torch.cat((mixed, second), -1)), -2)

    def _precondition(self, state: State, blocks: Blocks, residual: torch.Tensor) -> torch.Tensor:
        image = torch.where(state.active, self.grid.invert(residual), 0.0)
        right = blocks.sums(state.weights * residual)
        spread = blocks.spread(_solve_on_blocks(blocks, blocks.sums(state.weights), right))
        corrected = image - state.weights * spread
        # Where weights ring, the correction may turn the direction uphill.
        image = torch.where(dot(residual, corrected) > 0.0, corrected, image)
        if self.load is not None:
            return image
        ones = state.active.to(torch.float32)
        sums = torch.cat((dot(state.weights, residual), dot(ones, residual)), -2)
        first, second = (state.rigid @ sums).to(torch.float32).split(1, -2)
        fraction = divide(total(image), total(state.weights)).to(torch.float32)
        return image + (first - fraction) * state.weights + second * ones

    def _find_direction(self, state: State, residual: torch.Tensor, image: torch.Tensor) -> torch.Tensor:
        """Return the conjugate, the preconditioned or the plain gradient, made admissible."""
        factor = divide(-dot(image, torch.where(state.active, state.change, 0.0)), state.curvature)
        factor = torch.clamp(factor, min=0.0).to(torch.float32)
        conjugate = image + factor * torch.where(state.active, state.step, 0.0)
        slope = dot(residual, image)
        steep = dot(residual, conjugate) > _MIN_CONJUGATE_SLOPE * slope
        plain = torch.where(slope > 0.0, image, state.weights * residual)
        return self._admit(state, torch.where(steep & (slope > 0.0), conjugate, plain))

    def _admit(self, state: State, direction: torch.Tensor) -> torch.Tensor:
        """Return the nearest direction of sum zero in which no released cell crosses its bound."""
        low = state.active & (state.pressure <= 0.0)
        high = state.active & (state.pressure >= self.limit)
        if self.load is not None:
            weight = total(state.weights)
            change = total(direction)
            shift = divide(change, weight)
            for _ in range(_HELD_ROUNDS):
                moved = direction - shift.to(torch.float32) * state.weights
                held = (low & (moved < 0.0)) | (high & (moved > 0.0))
                free = torch.where(held, 0.0, state.weights)
                shift = divide(total(torch.where(held, 0.0, direction)), total(free))
            direction = direction - shift.to(torch.float32) * state.weights
        direction = torch.where(low, torch.clamp(direction, min=0.0), direction)
        return torch.where(high, torch.clamp(direction, max=0.0), direction)

    def _move(self, state: State, residual: torch.Tensor, direction: torch.Tensor) -> None:
        """Take a part of a step along a direction."""
        before = state.pressure
        trial = before + state.length * direction
        above = highest(trial - self.limit) > 0.0
        clipped = above | (lowest(trial) < 0.0)
        state.met_limit = state.met_limit | above
        feasible = trial
        if self.load is None:
            feasible = torch.minimum(torch.clamp(trial, min=0.0), self.limit)
        else:
            feasible = self._shift_to_load(trial, state.weights.to(torch.float64), total(before), _LOAD_ROUNDS)
        trial = torch.where(clipped, feasible, trial)
        step = (trial - before).to(torch.float32)
        change = self.grid.displace(step)
        curvature = dot(step, change)
        slope = dot(residual, step)
        part = divide(slope, curvature)
        full = before + part * (trial - before)
        leaves = (lowest(full) < 0.0) | (highest(full - self.limit) > 0.0)
        state.met_limit = state.met_limit | (~clipped & (highest(full - self.limit) > 0.0))
        usable = (slope > 0.0) & (curvature > 0.0) & torch.isfinite(curvature)
        taken = torch.where(
            clipped,
            torch.where(part > _FULL_STEP_PART, 1.0, torch.where(part > _SHORTENED_STEP_PART, part, 0.0)),
            torch.where(leaves, torch.clamp(part, max=1.0), part),
        )
        taken = torch.where(usable, taken, 0.0)
        accepted = taken > 0.0
        grown = torch.where(
            clipped,
            torch.where(part > _FULL_STEP_PART, torch.clamp(part, 0.8, 4.0).sqrt(), torch.clamp(part, 0.5, 1.0)),
            torch.clamp(part, 0.25, 4.0),
        )
        state.length = torch.clamp(state.length * torch.where(accepted, grown, _CAREFUL_LENGTH), max=_MAX_LENGTH)
        moved = before + taken * (trial - before)
        state.pressure = torch.minimum(torch.clamp(moved, min=0.0), self.limit)
        change = taken.to(torch.float32) * change
        state.gap = state.gap + change
        state.step = torch.where(accepted, step, state.step)
        state.change = torch.where(accepted, change, state.change)
        state.curvature = torch.where(accepted, taken * curvature, torch.where(usable, state.curvature, 0.0))

    def _shift_to_load(
        self, values: torch.Tensor, weights: torch.Tensor, load: torch.Tensor, rounds: int
    ) -> torch.Tensor:
        """Return clip(values - shift * weights, 0, limit) with a shift for which the sum is about the load."""
        shift = torch.zeros_like(load)
        for _ in range(rounds):
            moved = values - shift * weights
            excess = total(torch.minimum(torch.clamp(moved, min=0.0), self.limit)) - load
            moving = (moved > 0.0) & (moved < self.limit)
            shift = shift + divide(excess, total(torch.where(moving, weights, 0.0)))
        return torch.minimum(torch.clamp(values - shift * weights, min=0.0), self.limit)

    def _restore(self, state: State) -> None:
        """Set cells near the limit to it if they would rise, and restore the load."""
        pressure = state.pressure
        if self.capped:
            inside = self._is_inside(pressure, torch.zeros_like(self.limit))
            near = inside & ~self._is_inside(pressure, state.near_limit)
            level = self._level(state.gap, state.weights).to(torch.float32)
            pressure = torch.where(near & (state.gap < level), self.limit, pressure)
        if self.load is not None:
            pressure = self.project_to_load(pressure, self.load)
        state.pressure = pressure


@attrs.frozen(eq=False)
class Verified:
    """Errors in float64 and their parts by rounding, shape (contacts, 1, 1)."""

    error: torch.Tensor
    floor: torch.Tensor


def _solve_on_blocks(blocks: Blocks, diagonal: torch.Tensor, right: torch.Tensor) -> torch.Tensor:
    """Solve the system of the correction to a few per cent, by conjugate gradients of a fixed number of steps."""
    size = highest(right.abs())
    size = torch.where(size > 0.0, size, 1.0)
    residual = right / size
    rest = diagonal - blocks.mean
    solution = torch.zeros_like(right)
    direction = torch.zeros_like(right)
    response = torch.zeros_like(right)
    previous = torch.full_like(size, torch.inf, dtype=torch.float64)
    going = torch.ones_like(size, dtype=torch.bool)
    for _ in range(_BLOCK_STEPS):
        image = blocks.approximate(residual)
        product = dot(residual, image)
        factor = (product / previous).to(right.dtype)
        direction = image + factor * direction
        response = residual + rest * image + factor * response
        curvature = dot(direction, response)
        going = going & (curvature > 0.0) & (product > 0.0)
        part = torch.where(going, divide(product, curvature), 0.0).to(right.dtype)
        solution = solution + part * direction
        residual = residual - part * response
        previous = torch.where(going, product, torch.inf)
    return solution * size
