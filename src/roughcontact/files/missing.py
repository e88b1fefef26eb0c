"""Missing points of measured height maps."""

from __future__ import annotations

import numpy as np

from roughcontact.checks import Array


def filled(heights: Array) -> Array:
    """Fill missing points with the harmonic surface through their neighbours.

    The filled heights solve Laplace's equation on the missing cells: they never exceed their
    surroundings, so that filling makes no summit that could touch.

    Parameters
    ----------
    heights
        Heights, shape (nx, ny), with NaN where a point is missing, but not everywhere.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.linalg import spsolve

    missing = ~np.isfinite(heights)
    count = int(np.count_nonzero(missing))
    number = np.full(heights.shape, -1)
    number[missing] = np.arange(count)
    neighbours, right = np.zeros(count), np.zeros(count)
    rows: list[np.ndarray] = []
    columns: list[np.ndarray] = []
    for here, there in _pairs():
        for one, other in ((here, there), (there, here)):
            known = missing[one] & ~missing[other]
            unknown = missing[one] & missing[other]
            np.add.at(right, number[one][known], heights[other][known])
            np.add.at(neighbours, number[one][known | unknown], 1.0)
            rows.append(number[one][unknown])
            columns.append(number[other][unknown])
    diagonal = np.arange(count)
    i, j = np.concatenate([diagonal, *rows]), np.concatenate([diagonal, *columns])
    values = np.concatenate([neighbours, np.full(i.size - count, -1.0)])
    result = heights.copy()
    result[missing] = spsolve(coo_array((values, (i, j)), shape=(count, count)).tocsc(), right)
    return result


def _pairs() -> tuple[tuple[tuple[slice, slice], tuple[slice, slice]], ...]:
    """Return the slices that put each cell beside its next neighbour along x and along y."""
    every, first, last = slice(None), slice(None, -1), slice(1, None)
    return ((first, every), (last, every)), ((every, first), (every, last))
