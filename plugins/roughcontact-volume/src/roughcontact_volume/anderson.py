"""Fixed points by Anderson's mixing of the last iterates, on the cells of a volume that take part."""

from __future__ import annotations

import attrs
import numpy as np
from roughcontact.typing import Array, IntArray

from roughcontact_volume.radial_return import WEIGHTS

# Differences that are mixed, and what is added to the equations for their weights over the sum of their diagonal.
_DEPTH = 6
_RIDGE = 1e-12


@attrs.define(eq=False)
class AndersonMixing:
    r"""The next iterate towards :math:`x = \Phi(x)` from the last ones, by least squares on differences of residuals.

    References
    ----------
    Walker, Ni, SIAM Journal on Numerical Analysis 49 (2011) 1715-1735, https://doi.org/10.1137/10078356X
    """

    cells: IntArray = attrs.field(factory=lambda: np.empty(0, dtype=np.intp))
    iterates: list[Array] = attrs.field(factory=list)
    residuals: list[Array] = attrs.field(factory=list)

    def add_cells(self, cells: IntArray) -> None:
        """Take part of these cells too, sorted positions; the iterates before were zero there."""
        union = np.union1d(self.cells, cells)
        if union.size > self.cells.size:
            places = np.searchsorted(union, self.cells)
            for kept in (self.iterates, self.residuals):
                kept[:] = [_spread(values, places, union.size) for values in kept]
            self.cells = union

    def find_next(self, iterate: Array, residual: Array) -> Array:
        r"""Return the next iterate after one and its residual :math:`\Phi(x) - x`, all of shape (6, cells)."""
        self.iterates.append(iterate)
        self.residuals.append(residual)
        del self.iterates[: -_DEPTH - 1], self.residuals[: -_DEPTH - 1]
        following = iterate + residual
        changes = [after - before for before, after in zip(self.residuals, self.residuals[1:], strict=False)]
        if not changes:
            return following
        products = np.array([[_multiply(one, other) for other in changes] for one in changes])
        products += _RIDGE * np.trace(products) * np.eye(len(changes))
        wanted = np.array([_multiply(one, residual) for one in changes])
        for weight, change, before, after in zip(
            np.linalg.solve(products, wanted), changes, self.iterates, self.iterates[1:], strict=False
        ):
            following -= weight * (after - before + change)
        return following


def _spread(values: Array, places: IntArray, count: int) -> Array:
    spread = np.zeros((len(values), count))
    spread[:, places] = values
    return spread


def _multiply(one: Array, other: Array) -> float:
    # Without the library of linear algebra, whose sums depend on the number of threads.
    return float(np.einsum("c,cn,cn->", WEIGHTS, one, other))
