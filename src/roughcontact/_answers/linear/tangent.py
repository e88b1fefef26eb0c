r"""The linear answer of a solved contact: one solve on its cells of contact.

A small change of the load, the heights or a potential changes the pressure on the cells A in contact by

.. math:: K_{AA}\, q = r, \qquad q = 0 \text{ elsewhere}

with the kernel K and a right side r. To first order the cells in contact remain the same.
"""

from __future__ import annotations

import abc
import math
from functools import cached_property
from typing import final

import attrs
import numpy as np

from roughcontact._base.arrays import Array, Mask, RealArray, read_only, sum_of_products
from roughcontact._base.units import WarningText
from roughcontact._parts.grid import Boundary
from roughcontact._parts.kernels import BoundKernel
from roughcontact._solve.convolvers import (
    InverseConvolution,
    PreparedConvolution,
    SoftenedConvolution,
)
from roughcontact._solve.problem import computing, linearise, problem_of
from roughcontact._solve.solution import ContactSolution
from roughcontact._solve.solvers import (
    ActiveCells,
    LinearisedGap,
    MaskedCells,
    Preconditioner,
    Work,
    active_cells,
    dot,
    total,
)
from roughcontact.errors import InputError, NotConverged
from roughcontact.errors.door import guarded

# Relative residual from which float32 is used: its rounding is 6e-8 of the right side for each product.
_FLOAT32_TOLERANCE = 1e-4
# Iterations after which a solve is given up, and iterations without a smaller residual that mean only rounding is left.
_MAX_ITERATIONS = 400
_MAX_IDLE_ITERATIONS = 15
# Relative residual that counts as solved where rounding prevents a smaller one.
_ROUNDING_RESIDUAL = 1e-8
# Smallest singular value of the products of two pressures, over the larger one, for which they count as independent;
# rounding in float32 gives 1e-7.
_MIN_SINGULAR_RATIO = 1e-6
# Stability margin below which a jump is near.
_NEAR_JUMP_MARGIN = 0.05


def _read_only(values: Array) -> Array:
    return read_only(values) if isinstance(values, np.ndarray) else values


@attrs.frozen(eq=False)
class LinearSolution:
    """The solution of a linear system on the cells in contact.

    Attributes
    ----------
    values
        The solution q, shape (nx, ny), zero outside the cells, in Pa for a right side in m.
    product
        Sum of the right side times q, m Pa, whose relative error is about the square of `error`.
    error
        Norm of the residual, the right side less K q, over the norm of the right side.
    iterations, products
        Iterations, and applications of the kernel and of its approximate inverse.
    margin
        Of surfaces that attract each other: the stability margin at a given approach, as far as it was met.
    """

    values: Array = attrs.field(converter=_read_only)
    product: float
    error: float
    iterations: int
    products: int
    margin: float = 1.0

    def require(self, tolerance: float, solution: ContactSolution) -> None:
        """Raise `NotConverged`, of the solution that was asked, if the error is above a tolerance and rounding."""
        if not self.error <= max(tolerance, _ROUNDING_RESIDUAL):
            raise NotConverged(
                f"The linear answer of the contact was not found: after {self.iterations} iterations the residual is "
                f"{self.error:.1e} of the right side.",
                solution,
            )


@guarded
def solve_on_cells(
    operator: PreparedConvolution,
    inverse: InverseConvolution,
    cells: Mask,
    right: Array,
    tolerance: float,
    *,
    unit: float,
    rigid: bool,
) -> LinearSolution:
    """Return the solution on some cells, as far as it was found; arrays are those of the operator's `to_numpy`.

    Parameters
    ----------
    operator, inverse
        The kernel, lengths in cells and E* = 1, and its approximate inverse in float32.
    cells, right, tolerance
        As in `Tangent.solve`.
    unit
        Displacement by a pressure of one Pa on all cells, if the kernel were one, m/Pa.
    rigid
        Whether the mean of the right side is omitted, and the solution has the mean zero.
    """
    right = np.where(cells, right, 0.0)
    if rigid:
        right -= right.mean()
    size = float(np.abs(right).max())
    if size == 0.0:
        return LinearSolution(np.zeros_like(right), 0.0, 0.0, 0, 0)
    dtype = np.float32 if tolerance >= _FLOAT32_TOLERANCE else np.float64
    flat = operator.from_numpy(right / size).astype(dtype).ravel()
    mask = operator.from_numpy(cells.astype(np.float64)).ravel() > 0.0
    active = active_cells(flat, lambda tile: mask[tile])
    system = _System(operator, active, Preconditioner(inverse, operator, Work(), rigid=False))
    vectors = system.solve(active.gather(flat), tolerance, rigid=rigid)
    found, left = (
        operator.to_numpy(active.scatter(vector).astype(np.float64).reshape(right.shape)) for vector in vectors[:2]
    )
    if rigid:
        found -= found.mean()
    error = math.sqrt(sum_of_products(left, left) / sum_of_products(right, right)) * size
    values = found * (size / unit)
    # The error of the product is the square of the residual.
    product = float(np.add.reduce(values * (right + left * size), axis=None))
    return LinearSolution(values, product, error, *vectors[2:])


class LinearAnswer(abc.ABC):
    """Small changes of the pressure of a contact, for heights at a given position of the bodies.

    Attributes
    ----------
    cells
        The cells in contact that answer, shape (nx, ny).
    """

    def __init__(self, solution: ContactSolution, cells: Mask) -> None:
        self._solution = solution
        self._problem = problem_of(solution)
        # Displacement in m by a pressure of one Pa on all cells, if the dimensionless kernel were one.
        self._unit = solution.grid.spacing[0] / solution.modulus
        self.cells = cells

    @property
    def is_rigid(self) -> bool:
        """Whether uniform pressure displaces nothing: all cells of a periodic domain touch."""
        return self._solution.boundary is Boundary.PERIODIC and bool(self.cells.all())

    @abc.abstractmethod
    def solve(self, right: Array, tolerance: float = 1e-12) -> LinearSolution:
        """Return the change of the pressure by heights, shape (nx, ny), m, to a relative residual."""


def _below_limit(solution: ContactSolution) -> Mask:
    return read_only(solution.contact & ~solution.saturated)


@final
class Tangent(LinearAnswer):
    """The kernel of a contact restricted to its cells in contact.

    Parameters
    ----------
    solution
        The contact.
    saturated
        Whether cells at the pressure limit belong to it: they do not under further load, and they do in unloading.
    compliance
        Displacement of each cell by its own pressure, in addition to the kernel, m/Pa, as by a film.
    kernel
        A kernel in place of that of the contact, such as that of temperature by heat; pressure and displacement are
        then those that it relates.

    Raises
    ------
    InputError
        If the solution does not say which problem it solves.
    """

    def __init__(
        self,
        solution: ContactSolution,
        *,
        saturated: bool = False,
        compliance: float = 0.0,
        kernel: BoundKernel | None = None,
    ) -> None:
        super().__init__(solution, solution.contact if saturated else _below_limit(solution))
        self._kernel = kernel
        if kernel is not None:
            self._unit = kernel.unit
        self._diagonal = compliance / self._unit

    @property
    def is_rigid(self) -> bool:
        """Whether uniform pressure displaces nothing: all cells of a periodic domain are in contact, without film.

        A right side then determines the solution up to a constant only, and no solution exists for its mean.
        """
        return self._diagonal == 0.0 and super().is_rigid

    def solve(self, right: Array, tolerance: float = 1e-12) -> LinearSolution:
        """Return the solution for a right side by conjugate gradients, preconditioned by the inverse kernel.

        Where `is_rigid`, the mean of the right side is omitted and the solution has the mean zero.

        Parameters
        ----------
        right
            Right side, shape (nx, ny), m; only its values on `cells` count.
        tolerance
            Norm of the residual over the norm of the right side at which it ends; from 1e-4 on in float32.

        Raises
        ------
        NotConverged
            If the residual cannot be made that small, nor 1e-8.
        """
        with computing(self._problem):
            answer = solve_on_cells(
                self._operator, self._inverse, self.cells, right, tolerance, unit=self._unit, rigid=self.is_rigid
            )
        answer.require(tolerance, self._solution)
        return answer

    @cached_property
    def _operator(self) -> PreparedConvolution:
        convolution = self._problem.convolution
        if self._kernel is not None:
            setup = convolution.setup
            convolution = setup.convolver.prepare(self._kernel, setup.grid, setup.boundary)
        return convolution if self._diagonal == 0.0 else SoftenedConvolution(convolution, self._diagonal)

    @cached_property
    def _inverse(self) -> InverseConvolution:
        return self._operator.inverse(np.float32)


@attrs.frozen(eq=False)
class _System:
    """The restricted kernel with its preconditioner, on vectors of the active cells in one precision."""

    operator: PreparedConvolution
    active: ActiveCells
    preconditioner: Preconditioner

    def solve(self, right: RealArray, tolerance: float, *, rigid: bool) -> tuple[RealArray, RealArray, int, int]:
        """Return the solution, its residual, the iterations and the products."""
        weights = self.preconditioner.weights(self.active)
        space = _Space([], []) if rigid else self._find_space(weights.astype(right.dtype))
        values, residual = space.start(right)
        direction = response = right
        curvature = 0.0
        best = math.inf
        idle = 0
        iterations = 0
        goal = tolerance**2 * _square(right)
        while iterations < _MAX_ITERATIONS and (square := _square(residual)) > goal and idle < _MAX_IDLE_ITERATIONS:
            idle = 0 if square < best else idle + 1
            best = min(best, square)
            image = self._precondition(weights, residual, math.sqrt(square / right.size))
            image = space.correct(image, residual)
            # The preconditioner changes a little from step to step: the next direction is made conjugate to the last.
            factor = -_dot(image, response) / curvature if iterations else 0.0
            direction = image + factor * direction if factor > 0.0 else image
            response = self._apply(direction)
            curvature = _dot(direction, response)
            if not curvature > 0.0:
                break
            step = _dot(direction, residual) / curvature
            values += step * direction
            residual -= step * response
            iterations += 1
        products = iterations + len(space.vectors) + math.ceil(self.preconditioner.work.inverse)
        if right.dtype == np.float64:
            residual = right - self._apply(values)
            products += 1
        return values, residual, iterations, products

    def _find_space(self, weights: RealArray) -> _Space:
        """Return the pressures that move the surface as a whole: of a flat punch and, if most cells touch, uniform."""
        vectors = [weights]
        if isinstance(self.active, MaskedCells):
            vectors.append(self.active.ones.astype(weights.dtype))
        return _Space(vectors, [self._apply(vector) for vector in vectors])

    def _apply(self, vector: RealArray) -> RealArray:
        shape = self.operator.setup.grid.shape
        return self.active.gather(self.operator.apply(self.active.scatter(vector).reshape(shape)).ravel())

    def _precondition(self, weights: RealArray, residual: RealArray, size: float) -> RealArray:
        """Return the preconditioned residual; float32 holds it whatever its size."""
        image = self.preconditioner.apply(self.active, weights, (residual / size).astype(np.float32))
        return size * image.astype(residual.dtype)


class _Space:
    r"""A few pressures V in whose space a system is solved exactly, so that iterations need not find them.

    .. math:: q_0 = V G V^T r, \quad z \leftarrow z + V G (V^T r - (K V)^T z), \quad G = (V^T K V)^{-1}
    """

    def __init__(self, vectors: list[RealArray], images: list[RealArray]) -> None:
        self.vectors = vectors
        self._images = images
        products = [[_dot(one, other) for other in images] for one in vectors]
        self._inverse = np.linalg.pinv(products, rcond=_MIN_SINGULAR_RATIO) if vectors else np.zeros((0, 0))

    def start(self, right: RealArray) -> tuple[RealArray, RealArray]:
        """Return the solution in the space, and its residual."""
        values = np.zeros_like(right)
        residual = right.copy()
        for vector, image, part in zip(self.vectors, self._images, self._find_parts(right), strict=True):
            values += float(part) * vector
            residual -= float(part) * image
        return values, residual

    def correct(self, image: RealArray, residual: RealArray) -> RealArray:
        """Return the preconditioned residual, changed in place, with its part in the space made exact."""
        if self.vectors:
            wrong = self._inverse @ [_dot(other, image) for other in self._images]
            for vector, part in zip(self.vectors, self._find_parts(residual) - wrong, strict=True):
                image += float(part) * vector
        return image

    def _find_parts(self, right: RealArray) -> Array:
        return np.asarray(self._inverse @ [_dot(vector, right) for vector in self.vectors])


def _square(vector: RealArray) -> float:
    return _dot(vector, vector)


def _dot(one: RealArray, other: RealArray) -> float:
    return total(one * other) if one.dtype == np.float32 else dot(one, other)


@final
class AdhesiveTangent(LinearAnswer):
    r"""Small changes of the pressure of surfaces that attract each other, for heights dz at a given position.

    In place of :math:`q = K_{AA}^{-1}\,\mathrm{d}z` of a `Tangent`, open cells answer too, by the slope s' of the law
    (see `LinearisedGap`); q is again linear and symmetric in dz.

    Parameters
    ----------
    solution
        The contact.

    Raises
    ------
    InputError
        If the solution does not say which problem it solves, or the surfaces have come apart.
    """

    def __init__(self, solution: ContactSolution) -> None:
        super().__init__(solution, _below_limit(solution))

    def solve(self, right: Array, tolerance: float = 1e-12) -> LinearSolution:
        """Return the change of the pressure by heights; see `Tangent.solve`.

        Parameters
        ----------
        right
            The heights, shape (nx, ny), m.
        tolerance
            Norm of the residual over that of the answer at which it ends, both in terms of the energy.

        Raises
        ------
        InputError
            If the state is unstable.
        NotConverged
            If the residual cannot be made that small, nor 1e-8.
        """
        if self.is_rigid:
            right = right - right.mean()
        size = float(np.abs(right).max())
        if size == 0.0:
            return LinearSolution(np.zeros_like(right), 0.0, 0.0, 0, 0)
        with computing(self._problem):
            found = self._linearised.solve(right / size, tolerance)
        if found.margin <= 0.0:
            raise InputError(
                "The state is not stable at a given approach, so that it answers no small change: follow the approach "
                "to a stable one by problem.sweep(approach=[...])."
            )
        scale = size / self._unit
        answer = LinearSolution(
            found.pressure * scale,
            found.product * size * scale,
            found.error,
            found.iterations,
            found.products,
            found.margin,
        )
        answer.require(tolerance, self._solution)
        return answer

    @cached_property
    def _linearised(self) -> LinearisedGap:
        return linearise(self._problem, self._solution, holds_approach=True)


def tangent_of(solution: ContactSolution) -> LinearAnswer:
    """Return the linear answer of a contact under further load, whether its surfaces attract each other or not."""
    shared: LinearAnswer | None = solution.parts.tangent(solution)
    if shared is not None:
        return shared
    return Tangent(solution) if solution.tension is None else AdhesiveTangent(solution)


def describe_jump(margin: float) -> WarningText | None:
    """Return a warning if a stability margin is that of a state near a jump."""
    if margin >= _NEAR_JUMP_MARGIN:
        return None
    text = "the state is close to a jump: a slightly other load may separate or join the surfaces"
    return WarningText(text, "near a jump", margin)
