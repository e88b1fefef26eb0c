"""The interface of solvers of shear: a dimensionless task with given limits in, a shear out."""

from __future__ import annotations

import abc
import math
from collections.abc import Callable
from functools import cached_property
from typing import TypeAlias

import attrs
import numpy as np

from roughcontact._base.arrays import Array, IntArray, Mask, Pair, RealArray, sum_of_products
from roughcontact._base.checks import Part
from roughcontact._base.registry import Registry
from roughcontact._parts.grid import Boundary
from roughcontact._solve.convolvers import ShearConvolution, WaveMatrix
from roughcontact._solve.solution import Status
from roughcontact._solve.solvers.base import DEFAULT_TOLERANCE
from roughcontact._solve.solvers.driver import Log
from roughcontact._solve.solvers.passes import ListedCells
from roughcontact._solve.solvers.shear.discs import ForceControl, magnitude, natural_residual
from roughcontact.errors import InputError

Given: TypeAlias = tuple[float | None, float | None]
# Force over the sum of the limits from which on the bodies slide, but for rounding.
_SLIDING = 1.0 - 1e-12
# Limit below which a cell counts as without one, over the maximum: squares of smaller ones would underflow.
_MIN_LIMIT = 1e-100
# Distance from the circle that is rounding, over the limit.
_ON_CIRCLE = 1e-12
# Values of vectors that are stored at once: one part of them needs no thread of its own.
_MAX_WHOLE_VALUES = 2**15
# Rounding of a displacement in float64, over its terms.
_ROUNDING = 32.0 * float(np.finfo(np.float64).eps)


@attrs.frozen(eq=False, kw_only=True)
class ShearTask:
    r"""A dimensionless problem of stick and slip with given limits of the shear.

    .. math:: \min_{|q| \le s} \tfrac12\, q \cdot K q - q \cdot (b + d)

    The slip :math:`w = b + d - K q` is zero where :math:`|q| < s`, and parallel to q elsewhere. Along each axis either
    the force or the displacement d of the bodies is given.

    Attributes
    ----------
    limit
        Maximum magnitude s of the shear, at least zero, shape (nx, ny).
    offset
        Displacement b of each cell, shape (2, nx, ny).
    shear_force
        Sum of the shear of all cells along x and y; None where the displacement is given.
    displacement
        Displacement of the bodies along x and y; None where the force is given.
    start
        Shear to start from, shape (2, nx, ny); None: zero.
    tolerance
        Residual to be reached (`natural_residual`).
    max_iterations
        Iterations after which the solve is given up.

    Raises
    ------
    InputError
        If along an axis both force and displacement are given or neither is, or the bodies slide under the force.
    """

    limit: Array
    offset: Array
    shear_force: Given = (None, None)
    displacement: Given = (None, None)
    start: Array | None = None
    tolerance: float = DEFAULT_TOLERANCE
    max_iterations: int = 1000

    def __attrs_post_init__(self) -> None:
        for axis, force, displacement in zip("xy", self.shear_force, self.displacement, strict=True):
            if (force is None) == (displacement is None):
                raise InputError(f"Along {axis} either the tangential force or the displacement must be given.")
        force = math.hypot(*(one or 0.0 for one in self.shear_force))
        sliding = float(self.limit.sum())
        if force > 0.0 and force >= _SLIDING * sliding:
            fraction = f"{force / sliding:.6g} times" if sliding > 0.0 else "above"
            raise InputError(
                f"The bodies slide: the tangential force is {fraction} the force of sliding. Give a smaller force or a "
                "displacement, or take `slide`."
            )


@attrs.frozen(eq=False, kw_only=True)
class ShearOutcome:
    """The result of a solver of shear.

    Attributes
    ----------
    shear
        Shear, shape (2, nx, ny), within the limits.
    displacement
        Displacement of the bodies along x and y.
    residual
        The larger one of `natural_residual` and the error of the force over the sum of the limits, in float64.
    iterations, products
        Iterations, and products of a field of two components with the kernel or its inverse.
    status
        How the solve ended.
    """

    shear: Array
    displacement: Pair
    residual: float
    iterations: int
    products: int
    status: Status


class ShearSolver(Part, abc.ABC):
    """A method to find the shear within given limits, from a convolution alone.

    Examples
    --------
    >>> import numpy as np
    >>> import roughcontact as rc
    >>> from roughcontact._solve.solvers import ProjectedShearCG
    >>> from roughcontact.typing import ShearTask
    >>> rubber = rc.Elastic(young=2e6, poisson=0.5)
    >>> problem = rc.ContactProblem(rc.Body(rc.SphereSurface(1e-2), rubber), rc.Body(rc.FlatSurface(), rubber),
    ...                             grid=rc.Grid((16, 16), 1e-3))
    >>> task = ShearTask(limit=np.ones((16, 16)), offset=np.zeros((2, 16, 16)), shear_force=(128.0, 0.0))
    >>> found = ProjectedShearCG().solve(problem.convolution.shear(), task)
    >>> print(f"{found.shear[0].sum():g}, {found.status}")
    128, converged: the conditions of contact hold within the tolerance
    """

    @abc.abstractmethod
    def solve(self, convolution: ShearConvolution, task: ShearTask) -> ShearOutcome:
        """Return the shear."""


shear_solvers = Registry(ShearSolver, "shear solver", "roughcontact.shear_solvers")


def _power_of_two(value: float) -> float:
    return math.ldexp(1.0, math.frexp(value)[1])


class Verified:
    """A shear and what follows from it in float64.

    Attributes
    ----------
    shear
        The shear on the cells with a limit, shape (2, n).
    slip
        The slip on these cells, shape (2, n).
    displacement
        Displacement of the bodies, shape (2,).
    energy
        The energy that is to be minimised.
    residual, floor
        Its residual, and the residual by rounding.
    """

    def __init__(self, system: ShearSystem, shear: Array) -> None:
        control = system.control
        self.shear = control.project(shear, system.limit)[0]
        response = system.multiply(self.shear)
        moved = system.offset + system.displacement[:, np.newaxis]
        self.energy = 0.5 * sum_of_products(self.shear, response) - sum_of_products(self.shear, moved)
        slip = moved - response
        own = system.own
        projected, shift = control.project(self.shear + slip / own, system.limit, gain=1.0 / own)
        self.slip = slip + shift[:, np.newaxis]
        self.displacement = system.displacement + shift
        natural = natural_residual(self.shear, self.slip, system.limit, own)
        # The force must be that of the projected shear, too: else the displacement is not the one that belongs to it.
        forces = max(control.find_error(one, system.limit) for one in (self.shear, projected))
        self.residual = max(natural, forces)
        terms = float(np.abs(response).max() + np.abs(system.offset).max() + np.abs(self.displacement).max())
        self.floor = _ROUNDING * terms / own / float(system.limit.max())


@attrs.frozen(eq=False)
class Estimated:
    """A shear whose residual is estimated in float32; see `Verified`."""

    shear: Array
    displacement: Array
    residual: float


class ShearSystem:
    """A task on the cells that have a limit, in units in which limits and displacements are near one.

    Vectors have shape (2, n). The units are powers of two, so that the results do not depend on them.

    Attributes
    ----------
    cells
        The cells that have a limit.
    limit, offset
        Limits, shape (n,), and offset, shape (2, n).
    control
        The given force.
    displacement
        Given displacement, zero along an axis with a given force; shape (2,).
    own
        Displacement of a cell by a unit shear on it: the mean of both axes.
    iterations, products
        Iterations, and products with the kernel or its inverse, so far.
    """

    def __init__(self, convolution: ShearConvolution, task: ShearTask) -> None:
        self._convolution = convolution
        self.shape = task.limit.shape
        mask = task.limit.ravel() > _MIN_LIMIT * task.limit.max()
        self.cells = ListedCells(mask, np.flatnonzero(mask))
        limit = task.limit.ravel()[mask]
        self._stress = _power_of_two(float(limit.max()))
        own = 0.5 * sum(convolution.own)
        self._compliance = _power_of_two(own)
        self._length = self._stress * self._compliance
        self.own = own / self._compliance
        self.limit = limit / self._stress
        self.offset = self.gather(task.offset) / self._length
        force = np.array([0.0 if one is None else one for one in task.shear_force])
        axes = np.array([0.0 if one is None else 1.0 for one in task.shear_force])
        self.control = ForceControl(force / self._stress, axes)
        given = np.array([0.0 if one is None else one for one in task.displacement])
        self.displacement = given / self._length
        self.iterations = self.products = 0

    @cached_property
    def inverse(self) -> WaveMatrix:
        """The approximate inverse of the kernel."""
        return self._convolution.inverse(np.float32)

    def scaled_inverse(self, component: str) -> RealArray:
        """Return the shear of waves by displacements, both in the units of vectors, of a component of the inverse."""
        return self.inverse.symbols[component] * np.float32(self._compliance)

    @cached_property
    def _mean_inverse(self) -> WaveMatrix:
        mean = 0.5 * (self.inverse.symbols["xx"] + self.inverse.symbols["yy"])
        return WaveMatrix({"xx": mean, "yy": mean}, self.inverse.padded)

    @property
    def mean_stiffness(self) -> RealArray:
        """The mean of that over the directions of the displacement."""
        return self._mean_inverse.symbols["xx"] * np.float32(self._compliance)

    @cached_property
    def _both(self) -> IntArray:
        """The places of vectors in both fields together, flat."""
        return np.concatenate([self.cells.cells, self.cells.cells + math.prod(self.shape)])

    def gather(self, fields: RealArray) -> RealArray:
        """Return the vectors of fields, shape (2, nx, ny)."""
        # All cells lie within the field; this mode of numpy is the fastest.
        return fields.reshape(2, -1).take(self.cells.cells, axis=1, mode="wrap")

    def scatter(self, vectors: RealArray) -> RealArray:
        """Return the fields that are the vectors on the cells with a limit, and zero elsewhere."""
        fields = np.zeros((2, math.prod(self.shape)), dtype=vectors.dtype)
        if vectors.size <= _MAX_WHOLE_VALUES:
            fields.ravel()[self._both] = vectors.ravel()
            return fields.reshape(2, *self.shape)
        # One field at a time takes half the time of both.
        for field, vector in zip(fields, vectors, strict=True):
            self.cells.store(field, vector)
        return fields.reshape(2, *self.shape)

    def multiply(self, shear: RealArray) -> RealArray:
        """Return the displacement by a shear, in its precision."""
        self.products += 1
        scale = shear.dtype.type(1.0 / self._compliance)
        return np.asarray(self.gather(self._convolution.apply(self.scatter(shear))) * scale)

    def multiply_inverse(self, displacement: RealArray) -> RealArray:
        """Return the product of a displacement in float32 with the approximate inverse of the kernel.

        On a periodic domain the mean, to which the kernel does not respond, gets the shear of a single cell.
        """
        shear = self._multiply_waves(self.inverse, displacement)
        if self._convolution.setup.boundary is Boundary.PERIODIC:
            mean = displacement.sum(axis=1, dtype=np.float64, keepdims=True) / math.prod(self.shape)
            shear += (mean / self.own).astype(np.float32)
        return shear

    def multiply_mean_inverse(self, displacement: RealArray) -> RealArray:
        """Return that product with the mean of the inverse over directions, and without a shear of the mean."""
        return self._multiply_waves(self._mean_inverse, displacement)

    def _multiply_waves(self, matrix: WaveMatrix, displacement: RealArray) -> RealArray:
        self.products += 1
        return self.gather(matrix.apply(self.scatter(displacement))) * np.float32(self._compliance)

    def find_on_circle(self, shear: Array) -> Mask:
        """Return the cells whose shear has the magnitude of the limit, but for rounding."""
        return np.asarray(magnitude(shear) >= self.limit * (1.0 - _ON_CIRCLE))

    def start(self, task: ShearTask) -> Array:
        """Return the shear to start from."""
        return np.zeros((2, self.limit.size)) if task.start is None else self.gather(task.start) / self._stress

    def outcome(self, found: Verified | Estimated, status: Status) -> ShearOutcome:
        """Return the outcome of a solve."""
        x, y = (float(one) for one in found.displacement * self._length)
        return ShearOutcome(
            shear=self.scatter(found.shear) * self._stress,
            displacement=(x, y),
            residual=found.residual,
            iterations=self.iterations,
            products=self.products,
            status=status,
        )


def solve_shear(
    convolution: ShearConvolution,
    task: ShearTask,
    descend: Callable[[ShearSystem, Verified, Log, float], tuple[Verified | Estimated, Status]],
) -> ShearOutcome:
    """Return the outcome of a descent to a tolerance on the cells with a limit."""
    if not task.limit.any():
        x, y = (one or 0.0 for one in task.displacement)
        return ShearOutcome(
            shear=np.zeros_like(task.offset, dtype=np.float64),
            displacement=(x, y),
            residual=0.0,
            iterations=0,
            products=0,
            status=Status.CONVERGED,
        )
    system = ShearSystem(convolution, task)
    log = Log(task.limit.shape, task.max_iterations)
    return system.outcome(*descend(system, Verified(system, system.start(task)), log, task.tolerance))
