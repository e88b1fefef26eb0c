"""Shear within the limit of each cell: projection on discs, with a given force, and the residual of stick and slip."""

from __future__ import annotations

import math
from functools import cached_property

import attrs
import numpy as np

from roughcontact._base.arrays import Array, Mask, RealArray
from roughcontact.errors.door import guarded

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
# Part of the predicted decrease that a step must reach.
_MIN_DECREASE = 1e-4


def magnitude(vectors: RealArray) -> RealArray:
    """Return the lengths of vectors, shape (2, ...); `np.hypot` takes three times as long."""
    return np.sqrt(dot(vectors, vectors))


def dot(one: RealArray, other: RealArray) -> RealArray:
    """Return the products of vectors, shape (2, ...), of each cell."""
    # Products of two axes take a fifth longer.
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
        shift = np.zeros(2)
        found = search.evaluate(shift)
        smallest = found.error
        admissible = max(error, FORCE_EPSILON) * float(limit.sum())
        for _ in range(_MAX_ROUNDS):
            if not found.error > admissible:
                break
            step = search.find_step(found)
            slope = float(found.excess @ step)
            for _ in range(_MAX_HALVINGS):
                trial = search.evaluate(shift + step)
                if (
                    trial.error <= 0.5 * smallest
                    or trial.energy <= found.energy + _MIN_DECREASE * slope + found.rounding
                ):
                    break
                step = 0.5 * step
                slope *= 0.5
            else:
                break
            shift = shift + step
            found = trial
            smallest = min(smallest, found.error)
        return found.shear, shift

    def solve_on_axes(self, matrix: Array, values: Array) -> Array:
        """Return the solution of a symmetric system of x and y on the axes with a given force; zero along the others.

        A small part of its trace is added to the diagonal, so that the matrix may be singular.
        """
        held = np.outer(self.axes, self.axes) * matrix
        regular = max(_MIN_STIFFNESS * float(np.trace(held)), _MIN_TRACE)
        return np.asarray(np.linalg.solve(held + np.diag(1.0 - self.axes + regular), self.axes * values))

    def find_error(self, shear: Array, limit: Array) -> float:
        """Return the error of the force, over the sum of the limits."""
        missing = self.axes * (shear.sum(axis=1) - self.force)
        return math.hypot(*missing) / float(limit.sum())


@attrs.frozen(eq=False)
class _ShiftSearch:
    """The function of the shift whose minimum has the force."""

    control: ForceControl
    values: Array
    limit: Array
    circle: Mask | None
    gain: float | Array

    def evaluate(self, shift: Array) -> _Shifted:
        values = self.values + self.gain * shift[:, np.newaxis]
        size = magnitude(values)
        # No cell is chosen by a mask: where masks are not smooth that takes ten times as long as a division.
        reach = np.maximum(size, self.limit)
        beyond = size > self.limit
        if self.circle is not None:
            np.copyto(reach, np.maximum(size, MIN_SIZE), where=self.circle)
            beyond |= self.circle
        factor = self.limit / reach
        shear = values * factor
        excess = self.control.axes * (shear.sum(axis=1) - self.control.force)
        return _Shifted(self, shift, values, size, beyond, factor, reach, shear, excess)

    def find_step(self, found: _Shifted) -> Array:
        """Return Newton's step, not longer than what moves a cell across its circle."""
        factor = self.gain * found.factor
        both = float(factor.sum())
        x, y = found.values * (found.beyond / found.reach)
        xx, xy, yy = (float(np.einsum("n,n,n->", factor, one, other)) for one, other in ((x, x), (x, y), (y, y)))
        step = -self.control.solve_on_axes(np.array([[both - xx, -xy], [-xy, both - yy]]), found.excess)
        length = float(np.hypot(*step))
        longest = 2.0 * float(found.size.max() + self.limit.max()) / float(np.max(self.gain))
        return step * (longest / length) if length > longest else step


@attrs.frozen(eq=False)
class _Shifted:
    """Shear after a shift: what was projected, its size, whether that is beyond the limit, factor, force in excess.

    The factor is the limit over `reach`.
    """

    search: _ShiftSearch
    shift: Array
    values: Array
    size: Array
    beyond: Mask
    factor: Array
    reach: Array
    shear: Array
    excess: Array

    @property
    def error(self) -> float:
        return float(np.abs(self.excess).max())

    @cached_property
    def _terms(self) -> Array:
        """The terms of the energy."""
        limit = self.search.limit
        stored = np.where(self.beyond, limit * (self.size - 0.5 * limit), 0.5 * self.size * self.size)
        total = float((stored / self.search.gain).sum())
        return np.array([total, -float(self.search.control.force @ self.shift)])

    @property
    def energy(self) -> float:
        """The energy whose gradient is the force in excess."""
        return float(self._terms.sum())

    @property
    def rounding(self) -> float:
        return _ENERGY_EPSILON * float(np.abs(self._terms).sum())
