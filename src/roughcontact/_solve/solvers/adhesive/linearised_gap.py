"""The linear problem of small changes of an adhesive contact: the stiffness of the surface less that of the law."""

from __future__ import annotations

import math

import attrs
import numpy as np

from roughcontact._base.arrays import Array, Mask, RealArray, sum_of_products
from roughcontact._parts.interactions import BoundInteraction
from roughcontact._solve.solvers.adhesive.stiffness import SurfaceStiffness

# Iterations after which a solve is given up, and iterations without a smaller residual that mean only rounding is left.
_MAX_ITERATIONS = 2000
_MAX_IDLE_ITERATIONS = 30
# Steps of Lanczos' method: of a ball at half of its pull-off force 30 and 60 differ by 1 %.
_STEPS = 30
# Random part of its first vector, over its largest value, so that no mode is missing in it.
_RANDOM = 0.1
# Norm of a further vector over the operator at which the space of its vectors is complete.
_COMPLETE = 1e-12


@attrs.frozen(eq=False)
class GapResponse:
    """The answer of an adhesive contact to small heights.

    Attributes
    ----------
    pressure
        Change of the pressure, shape (nx, ny).
    product
        Sum of the heights times the pressure, whose error is about the square of `error`.
    error
        Norm of the residual over that of the answer, both in terms of the energy.
    margin
        Lowest eigenvalue of the preconditioned operator that the iterations have met: the state is unstable, and has
        no answer, unless it is above zero.
    iterations, products
        Iterations, and products with the stiffness or its approximate inverse.
    """

    pressure: Array
    product: float
    error: float
    margin: float
    iterations: int
    products: int


class LinearisedGap:
    r"""Small changes of the gap around a state of surfaces that attract each other.

    Touching cells T stay closed and saturated cells keep their pressure; on open cells the pressure p = -s(g) follows
    the law. With the stiffness M, heights dz change the displacement by v and the pressure by dp,

    .. math:: v = \mathrm{d}z \text{ on } T, \qquad (M + s')\, v = s'\, \mathrm{d}z \text{ elsewhere}, \qquad
              \mathrm{d}p = M v

    with the slope s' of the law on open cells, and zero on saturated ones and outside the domain of a free boundary.
    The operator on the cells that are not in T is symmetric, and positive definite where the state is stable.

    Parameters
    ----------
    stiffness
        The stiffness of the surface.
    interaction
        The law.
    gap
        Gap of the state, shape (nx, ny), zero or below where the surfaces touch.
    saturated
        Cells at the pressure limit, shape (nx, ny).
    holds_approach
        Whether the approach is held; otherwise the load is.
    """

    def __init__(
        self,
        stiffness: SurfaceStiffness,
        interaction: BoundInteraction,
        gap: Array,
        saturated: Mask,
        *,
        holds_approach: bool,
    ) -> None:
        self._stiffness = stiffness
        self._saturated = saturated
        opened = (gap > 0.0) & ~saturated
        cells = np.ones(stiffness.extended)
        stiffness.inner(cells)[:] = opened | saturated
        count = float(cells.sum())
        self._cells: RealArray = cells
        self._slope = stiffness.embed(np.where(opened, interaction.slope(np.maximum(gap, 0.0)), 0.0))
        self._symbol = stiffness.symbol(stiffness.mean_stiffness if holds_approach else 0.0, np.float64)
        self._products = 0
        punch = sum_of_products(self._multiply(cells, self._symbol), cells) / max(count, 1.0)
        self._inverse = stiffness.precondition(self._symbol, punch)
        # On a periodic boundary the mean displacement by pressure is zero.
        self._holds_mean = holds_approach and stiffness.mean_compliance == 0.0 and count > 0.0
        self._weights = cells * self._multiply(cells, self._inverse) if self._holds_mean else cells
        self._total = float(self._weights.sum())

    def find_margin(self, steps: int = _STEPS) -> float:
        """Return the lowest eigenvalue of the preconditioned operator, by Lanczos' method; 1 where all cells touch.

        Parameters
        ----------
        steps
            Steps of the method, each of two products.
        """
        random = np.random.default_rng(0).standard_normal(self._cells.shape)
        largest = float(np.abs(self._slope).max())
        residual = self._cells * (np.abs(self._slope) + _RANDOM * (largest or 1.0) * random)
        dual = np.zeros_like(residual)
        diagonal: list[float] = []
        beside: list[float] = []
        for _ in range(steps):
            image, shift = self._precondition(residual)
            residual -= shift * self._cells
            norm = math.sqrt(max(sum_of_products(residual, image), 0.0))
            if not norm > _COMPLETE * max(map(abs, diagonal), default=0.0):
                break
            beside.append(norm)
            before = norm * dual
            dual = residual / norm
            vector = image / norm
            residual = self._cells * (self._multiply(vector, self._symbol) + self._slope * vector) - before
            diagonal.append(sum_of_products(vector, residual))
            residual -= diagonal[-1] * dual
        return _lowest_eigenvalue(np.array(diagonal), np.array(beside[1:]))

    def solve(self, heights: Array, tolerance: float) -> GapResponse:
        """Return the answer to small heights, by conjugate gradients.

        Parameters
        ----------
        heights
            Change dz of the sum of the heights of both bodies, shape (nx, ny). One everywhere is a unit approach. If
            all cells of a periodic boundary touch, its mean must be zero.
        tolerance
            Error at which it ends; see `GapResponse`.
        """
        self._products = 0
        heights = self._stiffness.embed(heights)
        moved = (1.0 - self._cells) * heights
        if self._holds_mean:
            moved -= float(moved.sum()) / self._total * self._weights
        pressure = self._multiply(moved, self._symbol)
        residual = self._cells * (self._slope * (heights - moved) - pressure)
        uniform = 0.0
        direction = np.zeros_like(residual)
        squares: list[float] = []
        curvatures: list[float] = []
        while True:
            image, shift = self._precondition(residual)
            residual -= shift * self._cells
            uniform += shift
            squares.append(max(sum_of_products(residual, image), 0.0))
            elastic = sum_of_products(moved, pressure)
            if squares[-1] <= tolerance**2 * elastic or _is_idle(squares):
                break
            direction = image + squares[-1] / squares[-2] * direction if curvatures else image
            change = self._multiply(direction, self._symbol)
            image = self._cells * (change + self._slope * direction)
            curvatures.append(sum_of_products(direction, image))
            if not curvatures[-1] > 0.0:
                break
            step = squares[-1] / curvatures[-1]
            moved += step * direction
            pressure += step * change
            residual -= step * image
        opening = self._cells * (moved - heights)
        found = self._stiffness.inner(pressure) + uniform
        return GapResponse(
            pressure=np.where(self._saturated, 0.0, found),
            product=elastic + sum_of_products(opening, self._slope * opening),
            error=math.sqrt(squares[-1] / elastic) if elastic > 0.0 else 0.0,
            margin=_find_ritz_value(squares, curvatures),
            iterations=len(curvatures),
            products=self._products,
        )

    def _multiply(self, field: RealArray, symbol: RealArray) -> RealArray:
        self._products += 1
        return self._stiffness.inverse.multiply(field, symbol, self._stiffness.extended)

    def _precondition(self, residual: RealArray) -> tuple[RealArray, float]:
        """Return the preconditioned residual, of the mean zero where that is held, and the mean of the residual."""
        image = self._cells * self._multiply(residual, self._inverse)
        if not self._holds_mean:
            return image, 0.0
        mean = float(image.sum()) / self._total
        return image - mean * self._weights, mean


def _is_idle(squares: list[float]) -> bool:
    """Return whether the residual, whose squares are given, does not fall further."""
    recent = squares[-_MAX_IDLE_ITERATIONS:]
    return len(squares) > _MAX_ITERATIONS or (
        len(squares) > len(recent) and min(recent) >= min(squares[: -len(recent)])
    )


def _find_ritz_value(squares: list[float], curvatures: list[float]) -> float:
    """Return the lowest eigenvalue that conjugate gradients have met; 1 without iterations."""
    if curvatures and not curvatures[-1] > 0.0:
        return min(curvatures[-1] / squares[-1], 0.0)
    square = np.array(squares)
    ratios = square[1:] / square[:-1]
    inverse_steps = np.array(curvatures) / square[:-1]
    parts = ratios * inverse_steps
    return _lowest_eigenvalue(inverse_steps + np.append(0.0, parts)[:-1], np.sqrt(ratios) * inverse_steps)


def _lowest_eigenvalue(diagonal: Array, beside: Array) -> float:
    """Return the lowest eigenvalue of a symmetric tridiagonal matrix, by its entries; 1 without any."""
    count = len(diagonal)
    if count == 0:
        return 1.0
    sides = beside[: count - 1]
    return float(np.linalg.eigvalsh(np.diag(diagonal) + np.diag(sides, 1) + np.diag(sides, -1))[0])
