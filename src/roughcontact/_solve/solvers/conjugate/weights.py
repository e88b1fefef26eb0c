"""Flat-punch weights of the active cells, exact while cells join and leave."""

from __future__ import annotations

import itertools

import numpy as np

from roughcontact._base.checks import IntArray, Mask, RealArray
from roughcontact._solve.convolvers import InverseConvolution
from roughcontact._solve.solvers.conjugate.active import ActiveCells
from roughcontact._solve.solvers.projection import total

# Weights are computed again when so many cells have changed since, over the active ones, or over the passive ones and
# so much of the grid if that is less: the stencil omits how far cells act.
_CHANGED = 0.5
_PASSIVE = 0.02
# Fraction of all cells that change at once above which a product is faster than the stencil.
_MANY = 0.03
# Cells to each side over which a cell that joins or leaves acts: the inverse kernel falls as the third power of
# the distance.
_REACH = 3
# Minimum weight over the mean: smaller ones are ringing of the inverse.
_SMALLEST_WEIGHT = 1e-3


class PunchWeights:
    """The pressure M 1 of the active cells under a flat punch, M the inverse kernel.

    A cell that joins or leaves changes the weights nearby by the inverse kernel: a stencil adds that, and only
    after many cells have changed the product is computed again.
    """

    def __init__(self, inverse: InverseConvolution, shape: tuple[int, int]) -> None:
        self._inverse = inverse
        self._shape = shape
        self._mask: Mask = np.zeros(0, dtype=bool)
        # M 1 on all cells, flat.
        self._field: RealArray = np.zeros(0, dtype=np.float32)
        self._stencil: RealArray | None = None
        self._changed = 0
        self.products = 0
        # Whether so many cells have changed that the weights were computed again.
        self.renewed = False

    def update(self, active: ActiveCells) -> RealArray | None:
        """Return the vector of the weights, above zero; None where ringing of the inverse leaves none."""
        mask = active.mask
        changed = np.flatnonzero(mask ^ self._mask) if self._mask.size else None
        self._changed += 0 if changed is None else changed.size
        self.renewed = (
            changed is None or changed.size > _MANY * mask.size or self._changed > _CHANGED * _smaller(active)
        )
        if self.renewed:
            self._changed = 0
        if changed is None or self.renewed or (changed.size and not self._inverse.local):
            self.products += 1
            self._field = self._inverse.apply(active.scatter(active.ones).reshape(self._shape)).ravel()
        elif changed.size:
            self._add(changed, np.where(mask[changed], np.float32(1.0), np.float32(-1.0)))
        self._mask = mask
        weights = active.gather(self._field)
        mean = total(weights) / active.count
        if not mean > 0.0:
            return None
        return np.maximum(weights, np.float32(_SMALLEST_WEIGHT * mean) * active.ones)

    def _add(self, cells: IntArray, amounts: RealArray) -> None:
        """Add amounts times the inverse kernel around cells."""
        if self._stencil is None:
            self._stencil = self._inverse.coefficients(_REACH)
        nx, ny = self._shape
        padded = self._inverse.padded
        # On a small periodic grid a cell is reached once.
        x, y = (np.arange(-reach, reach + 1) for reach in (min(_REACH, (m - 1) // 2) for m in padded))
        rows, columns = np.divmod(cells, ny)
        far = (np.minimum(rows, nx - 1 - rows) >= _REACH) & (np.minimum(columns, ny - 1 - columns) >= _REACH)
        inner = cells[far]
        inner_amounts = amounts[far]
        near = ~far
        rows = rows[near]
        columns = columns[near]
        near_amounts = amounts[near]
        for i, j in itertools.product(x.tolist(), y.tolist()):
            value = self._stencil[abs(i), abs(j)]
            self._field[inner + (i * ny + j)] += value * inner_amounts
            if near_amounts.size:
                row = (rows + i) % padded[0]
                column = (columns + j) % padded[1]
                inside = (row < nx) & (column < ny)
                self._field[row[inside] * ny + column[inside]] += value * near_amounts[inside]


def _smaller(active: ActiveCells) -> float:
    """Return the number of the active cells, or of the passive ones and a little more, if that is less."""
    cells = active.mask.size
    return min(active.count, cells - active.count + _PASSIVE * cells)
