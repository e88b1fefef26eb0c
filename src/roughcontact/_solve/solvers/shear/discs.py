"""Shear within the limit of each cell: projection on discs, with a given force, and the residual of stick and slip."""

from __future__ import annotations

import math
from functools import cached_property
from typing import TypeAlias

import attrs
import numpy as np

from roughcontact._base.arrays import Array, Mask, Pair, RealArray
from roughcontact.errors.door import guarded

# The entries xx, xy and yy of a symmetric matrix.
Symmetric: TypeAlias = tuple[float, float, float]
# Maximum rounds of Newton's method for the shift that gives a force, and halvings of one of its steps.
_MAX_ROUNDS = 60
_MAX_HALVINGS = 40
# Error of the force, over the sum of the limits, at which the search ends: the rounding of such sums.
FORCE_EPSILON = 2e-15
# Rounding of the energy whose gradient is the force, over its terms.
_ENERGY_EPSILON = 1e-14
# Smallest stiffness of the search, over that without limits.
_MIN_STIFFNESS = 1e-14
_MIN_TRACE = 1e-100
# Length below which a shear has no direction.
MIN_SIZE = 1e-200
# Values of two axes up to which their products are added by two calls.
_MAX_SHORT_VALUES = 2**12
# Part of the predicted decrease that a step must reach.
_MIN_DECREASE = 1e-4


def magnitude(vectors: RealArray) -> RealArray:
    """Return the lengths of vectors, shape (2, ...); `np.hypot` takes three times as long."""
    return np.sqrt(dot(vectors, vectors))


def dot(one: RealArray, other: RealArray) -> RealArray:
    """Return the products of vectors, shape (2, ...), of each cell."""
    if one.size <= _MAX_SHORT_VALUES:
        # Half of the time of the sum below.
        x, y = one * other
        return np.asarray(x + y)
    return np.asarray(np.einsum("a...,a...->...", one, other))


def project_to_discs(shear: Array, limit: Array) -> Array:
    """Return the nearest shear whose magnitude is at most the limit of each cell, shape (2, ...)."""
    size = magnitude(shear)
    beyond = size > limit
    return shear * np.divide(limit, size, out=np.ones_like(size), where=beyond)


@guarded
def natural_residual(shear: Array, slip: Array, limit: Array, own: float) -> float:
    r"""Return the violation of stick and slip, zero if and only if they hold in every cell; no unit.

    .. math:: \max \frac{|q - \Pi_s(q + \rho w)|}{\max s}, \quad \rho = \frac{1}{k}

    with the projection :math:`\Pi_s` on the disc of radius s. Where a cell sticks, it bounds the slip by
    :math:`|w| \le k \max s` times the residual.

    Parameters
    ----------
    shear
        Shear q, shape (2, ...).
    slip
        Slip w, shape (2, ...): zero where :math:`|q| < s`, else parallel to q.
    limit
        Limit s of the magnitude of the shear, not all zero, shape (...).
    own
        Displacement k of a cell by a unit shear on it.

    Examples
    --------
    One cell sticks, the other slips along its shear; slip against the shear is wrong.

    >>> import numpy as np
    >>> from roughcontact.typing import natural_residual
    >>> shear = np.array([[0.6, 0.0], [0.8, -2.0]])
    >>> slip = np.array([[0.0, 0.0], [0.0, -0.1]])
    >>> print(f"{natural_residual(shear, slip, np.array([3.0, 2.0]), 1.0):.3f}")
    0.000
    >>> print(f"{natural_residual(shear, -slip, np.array([3.0, 2.0]), 1.0):.3f}")
    0.033
    """
    return float(magnitude(shear - project_to_discs(shear + slip / own, limit)).max() / limit.max())


@attrs.frozen(eq=False)
class ForceControl:
    """The axes along which a force is given, and the force: the sum of the shear of all cells.

    Attributes
    ----------
    force
        Force along x and y; zero along an axis where the displacement is given.
    axes
        One along an axis where the force is given, else zero.
    """

    force: Array
    axes: Array

    def project(
        self, values: Array, limit: Array, *, circle: Mask | None = None, gain: float | Array = 1.0, error: float = 0.0
    ) -> tuple[Array, Array]:
        r"""Return the nearest shear within the limits that has the force, and the shift that leads to it.

        It is the projection of `values + gain * shift`; the shift, the same for all cells, is zero along axes without
        a given force. Its sum over the shift is the gradient of a convex function: Newton's method with Armijo's rule
        finds it.

        Parameters
        ----------
        values
            Shear, shape (2, n).
        limit
            Limits, above zero, shape (n,).
        circle
            Cells whose shear stays on the circle; None: none.
        gain
            Shear per shift, above zero, a number or shape (n,).
        error
            Admissible error of the force, over the sum of the limits.
        """
        search = _ShiftSearch(self, values, limit, circle, gain)
        found = search.evaluate((0.0, 0.0))
        smallest = found.error
        admissible = max(error, FORCE_EPSILON) * float(np.add.reduce(limit))
        for _ in range(_MAX_ROUNDS):
            if not found.error > admissible:
                break
            x, y = search.find_step(found)
            slope = found.excess[0] * x + found.excess[1] * y
            for _ in range(_MAX_HALVINGS):
                trial = search.evaluate((found.shift[0] + x, found.shift[1] + y))
                if (
                    trial.error <= 0.5 * smallest
                    or trial.energy <= found.energy + _MIN_DECREASE * slope + found.rounding
                ):
                    break
                x *= 0.5
                y *= 0.5
                slope *= 0.5
            else:
                break
            found = trial
            smallest = min(smallest, found.error)
        return found.shear, np.array(found.shift)

    def solve_on_axes(self, matrix: Symmetric, values: Pair) -> Pair:
        """Return the solution of a symmetric system of x and y on the axes with a given force; zero along the others.

        A small part of its trace is added to the diagonal, so that the matrix may be singular.
        """
        held_x, held_y = self._held
        xx, xy, yy = matrix
        # Rounding may leave less than nothing.
        xx = held_x * max(xx, 0.0)
        yy = held_y * max(yy, 0.0)
        xy *= held_x * held_y
        regular = max(_MIN_STIFFNESS * (xx + yy), _MIN_TRACE)
        xx += regular + 1.0 - held_x
        yy += regular + 1.0 - held_y
        x, y = held_x * values[0], held_y * values[1]
        # One step of elimination: a determinant would lose the digits of two unlike axes.
        if xx >= yy:
            ratio = xy / xx
            second = (y - ratio * x) / max(yy - ratio * xy, regular)
            return (x - xy * second) / xx, second
        ratio = xy / yy
        first = (x - ratio * y) / max(xx - ratio * xy, regular)
        return first, (y - xy * first) / yy

    @cached_property
    def _held(self) -> Pair:
        """The axes, as numbers."""
        x, y = self.axes.tolist()
        return x, y

    @property
    def holds(self) -> bool:
        """Whether a force is given."""
        return self._held != (0.0, 0.0)

    @cached_property
    def _wanted(self) -> Pair:
        """The force, as numbers."""
        x, y = self.force.tolist()
        return x, y

    def find_excess(self, shear: Array) -> Pair:
        """Return the sums of the shear less the force, zero along an axis without one."""
        x, y = np.add.reduce(shear, axis=1).tolist()
        return self._held[0] * (x - self._wanted[0]), self._held[1] * (y - self._wanted[1])

    def find_error(self, shear: Array, limit: Array) -> float:
        """Return the error of the force, over the sum of the limits."""
        return math.hypot(*self.find_excess(shear)) / float(np.add.reduce(limit))


@attrs.frozen(eq=False)
class _ShiftSearch:
    """The function of the shift whose minimum has the force."""

    control: ForceControl
    values: Array
    limit: Array
    circle: Mask | None
    gain: float | Array

    def evaluate(self, shift: Pair) -> _Shifted:
        values = self.values
        if shift != (0.0, 0.0):
            values = values + self.gain * np.array(shift)[:, np.newaxis]
        size = magnitude(values)
        # No cell is chosen by a mask: where masks are not smooth that takes ten times as long as a division.
        reach = np.maximum(size, self.limit)
        if self.circle is not None:
            np.copyto(reach, np.maximum(size, MIN_SIZE), where=self.circle)
        factor = self.limit / reach
        shear = values * factor
        return _Shifted(self, shift, values, size, factor, reach, shear, self.control.find_excess(shear))

    def find_step(self, found: _Shifted) -> Pair:
        """Return Newton's step, not longer than what moves a cell across its circle."""
        factor = self.gain * found.factor
        both = float(np.add.reduce(factor))
        normal = found.values * (found.beyond / found.reach)
        (xx, xy), (_, yy) = np.einsum("an,bn->ab", factor * normal, normal).tolist()
        x, y = self.control.solve_on_axes((both - xx, -xy, both - yy), found.excess)
        length = math.hypot(x, y)
        limit, gain = self._largest
        if length * gain <= 2.0 * limit:
            return -x, -y
        longest = 2.0 * (float(found.size.max()) + limit) / gain
        part = longest / length if length > longest else 1.0
        return -part * x, -part * y

    @cached_property
    def _largest(self) -> Pair:
        """The largest limit and gain."""
        return float(self.limit.max()), float(np.max(self.gain))


@attrs.frozen(eq=False)
class _Shifted:
    """Shear after a shift: what was projected, its size, factor, shear, force in excess.

    The factor is the limit over `reach`.
    """

    search: _ShiftSearch
    shift: Pair
    values: Array
    size: Array
    factor: Array
    reach: Array
    shear: Array
    excess: Pair

    @cached_property
    def beyond(self) -> Mask:
        """Cells whose shear is on their circle."""
        beyond = self.size > self.search.limit
        return beyond if self.search.circle is None else beyond | self.search.circle

    @property
    def error(self) -> float:
        return max(abs(self.excess[0]), abs(self.excess[1]))

    @cached_property
    def _terms(self) -> Pair:
        """The terms of the energy."""
        limit = self.search.limit
        stored = np.where(self.beyond, limit * (self.size - 0.5 * limit), 0.5 * self.size * self.size)
        x, y = self.search.control.force.tolist()
        return float((stored / self.search.gain).sum()), -(x * self.shift[0] + y * self.shift[1])

    @property
    def energy(self) -> float:
        """The energy whose gradient is the force in excess."""
        return sum(self._terms)

    @property
    def rounding(self) -> float:
        return _ENERGY_EPSILON * sum(map(abs, self._terms))
