"""Heights at non-measured points: the harmonic surface through their neighbours."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from roughcontact._base.arrays import Array, Mask
from roughcontact._base.machine import require_memory
from roughcontact.errors import InputError, argument

_TREATMENT_WORDS = {"fill": "filled from their neighbours", "keep": "kept so"}
# Treatments of non-measured points.
TREATMENTS = ("refuse", *_TREATMENT_WORDS)
# Maximum bandwidth of a system solved in bands, in time as its square; a hole of 30 x 30 points has it.
MAX_BANDWIDTH = 40
# Maximum points in wider holes for a direct solution, in less than a second: memory grows as n log n and time as n^1.5,
# but both as n for iterations.
_MAX_DIRECT_POINTS = 2**15
# Peak memory of the iterations, bytes per point; measured.
_BYTES_PER_POINT = 500
# Damping of Jacobi's iteration and of the smoothed aggregates: 2/3, because no eigenvalue of a row-scaled Laplacian
# exceeds 2 (Vanek, Mandel, Brezina, Computing 56 (1996) 179, https://doi.org/10.1007/BF02238511).
_JACOBI_DAMPING = 2.0 / 3.0
# Added to the sums of squared second differences, in case no known point is near.
_RIDGE_WEIGHT = 1e-12
# Cells along the side of an aggregate.
_AGGREGATE_SIDE = 3
# Relative residual at which conjugate gradients end, and maximum steps; 15 to 40 are needed.
_CG_TOLERANCE = 1e-13
_MAX_CG_STEPS = 300


def complete(heights: Array, where: str, treatment: str) -> tuple[Array, Mask | None, str]:
    """Return heights at all points, the mask of the non-measured points to be kept, and a note for the history.

    `InputError` if no point was measured, or non-measured points are refused.

    Parameters
    ----------
    heights
        Heights, NaN at non-measured points.
    where
        Their source, for messages: ``"the file x.npz"``.
    treatment
        One of `TREATMENTS`.
    """
    if heights.dtype.kind != "f" or heights.ndim != 2:
        return heights, None, ""
    mask = ~np.isfinite(heights)
    count = int(np.count_nonzero(mask))
    if count == 0:
        return heights, None, ""
    found = f"{count} of {heights.size} points"
    if count == heights.size:
        raise InputError(f"{where[0].upper()}{where[1:]} holds no valid point at all.")
    if treatment == "refuse":
        raise InputError(
            f"In {where} {found} were not measured: fill them from their neighbours with "
            f"{argument('non_measured', 'fill')}, or keep them with {argument('non_measured', 'keep')}."
        )
    done = f", {found} non-measured and {_TREATMENT_WORDS[treatment]}"
    return fill(heights), mask if treatment == "keep" else None, done


def fill(heights: Array) -> Array:
    """Return heights, shape (nx, ny), with non-measured points filled by the harmonic surface through their neighbours.

    The filled heights solve Laplace's equation on the non-measured cells: they never exceed their surroundings, so
    that no summit is added that could touch. At least one point must be measured.
    """
    from scipy.sparse.linalg import spsolve

    unknown = ~np.isfinite(heights)
    count = int(np.count_nonzero(unknown))
    if count == 0:
        return heights.copy()
    if count > _MAX_DIRECT_POINTS:
        require_memory(_BYTES_PER_POINT * count, f"Filling {count} non-measured points", "keep them, or cut the map")
    known = heights[~unknown]
    # Without the mean the heights keep more digits of the roughness.
    mean = float(known.mean())
    # The NaN of a damaged file may be a signalling one.
    with np.errstate(invalid="ignore"):
        centred = heights - mean
    matrix, right = _laplace(centred, unknown, count)
    found = solve_in_bands(matrix, right, MAX_BANDWIDTH)
    if found is None:
        if count <= _MAX_DIRECT_POINTS:
            found = spsolve(matrix.tocsc(), right)
        else:
            found = _solve(matrix.tocsr(), right, np.stack(np.nonzero(unknown)))
    result = heights.copy()
    result[unknown] = np.clip(mean + found, known.min(), known.max())
    return result


def solve_in_bands(matrix: Any, right: Array, widest: int) -> Array | None:
    """Return the solution of a sparse, symmetric, positive definite system; None if its bands are too wide.

    Small holes, numbered one after the other, have narrow bands: holes of similar width are solved together.
    """
    from scipy.linalg import solveh_banded
    from scipy.sparse.csgraph import connected_components, reverse_cuthill_mckee

    matrix = matrix.tocsr()
    alone = np.diff(matrix.indptr) == 1
    if alone.any():
        found: Array = np.empty(right.size)
        found[alone] = right[alone] / matrix.diagonal()[alone]
        if not alone.all():
            others = solve_in_bands(matrix[~alone][:, ~alone], right[~alone], widest)
            if others is None:
                return None
            found[~alone] = others
        return found
    order = reverse_cuthill_mckee(matrix, symmetric_mode=True)
    number = np.empty_like(order)
    number[order] = np.arange(order.size, dtype=order.dtype)
    entries = matrix.tocoo()
    below = number[entries.row] - number[entries.col]
    count, hole = connected_components(matrix, directed=False)
    widths = np.zeros(count, dtype=below.dtype)
    np.maximum.at(widths, hole[entries.row], below)
    if int(widths.max()) > widest:
        return None
    # The time grows as the square of the width.
    kind = np.ceil(np.log2(widths + 1.0)).astype(np.intp)[hole]
    lower = below >= 0
    found = np.empty(right.size)
    for one in np.unique(kind):
        members = order[kind[order] == one]
        number[members] = np.arange(members.size, dtype=order.dtype)
        chosen = lower & (kind[entries.row] == one)
        bands = np.zeros((int(below[chosen].max()) + 1, members.size))
        bands[below[chosen], number[entries.col[chosen]]] = entries.data[chosen]
        found[members] = solveh_banded(bands, right[members], overwrite_ab=True, lower=True, check_finite=False)
    return found


def describe_filling(filled: Mask) -> str:
    """Return a note for the history of a map on points that were filled."""
    return f"{int(filled.sum())} of {filled.size} points non-measured and {_TREATMENT_WORDS['fill']}"


def was_filled(history: Iterable[str]) -> bool:
    """Return whether the history of a map says that non-measured points were filled."""
    return any(_TREATMENT_WORDS["fill"] in text for text in history)


def smooth_over(heights: Array, holes: Mask) -> Array:
    """Return heights, shape (nx, ny), with the surface of minimum bending in holes, which has no kinks at their edges.

    The sum of its squared second differences along both axes is a minimum; it may exceed its surroundings.
    """
    from scipy.sparse import csr_array, eye_array, vstack
    from scipy.sparse.linalg import spsolve

    cells = np.arange(heights.size).reshape(heights.shape)
    differences = []
    for axis in (0, 1):
        left, middle, right = (
            np.take(cells, np.arange(k, heights.shape[axis] - 2 + k), axis).ravel() for k in range(3)
        )
        touching = holes.ravel()[left] | holes.ravel()[middle] | holes.ravel()[right]
        columns = np.stack([left, middle, right])[:, touching].T
        values = np.tile([1.0, -2.0, 1.0], len(columns))
        rows = np.repeat(np.arange(len(columns)), 3)
        differences.append(csr_array((values, (rows, columns.ravel())), shape=(len(columns), heights.size)))
    bending = vstack(differences).tocsc()
    known = np.where(holes, 0.0, heights)
    inside = bending[:, holes.ravel()]
    matrix = inside.T @ inside + _RIDGE_WEIGHT * eye_array(inside.shape[1])
    result = heights.copy()
    result[holes] = spsolve(matrix.tocsc(), -(inside.T @ (bending @ known.ravel())))
    return result


def _laplace(heights: Array, unknown: Any, count: int) -> tuple[Any, Array]:
    """Return the matrix of Laplace's equation on the unknown cells, and its right side."""
    from scipy.sparse import coo_array

    nx, ny = heights.shape
    i, j = np.nonzero(unknown)
    own = i * ny + j
    diagonal = np.arange(count, dtype=np.int32)
    number = np.full(heights.size, -1, dtype=np.int32)
    number[own] = diagonal
    neighbours = np.zeros(count)
    right = np.zeros(count)
    rows = [diagonal]
    columns = [diagonal]
    for step, inside in ((-ny, i > 0), (ny, i < nx - 1), (-1, j > 0), (1, j < ny - 1)):
        place = np.where(inside, own + step, own)
        column = number[place]
        neighbours += inside
        right += np.where(column < 0, heights.ravel()[place], 0.0)
        beside = inside & (column >= 0)
        rows.append(diagonal[beside])
        columns.append(column[beside])
    places = np.concatenate(rows), np.concatenate(columns)
    values = np.concatenate([neighbours, np.full(places[0].size - count, -1.0)])
    return coo_array((values, places), shape=(count, count)), right


def _solve(matrix: Any, right: Array, places: Array) -> Array:
    """Return the solution by conjugate gradients with a multigrid cycle of smoothed aggregates."""
    from scipy.sparse.linalg import LinearOperator, cg

    cycle = _prepare(matrix, places)
    preconditioner = LinearOperator(matrix.shape, matvec=cycle, dtype=np.float64)
    found, failed = cg(matrix, right, rtol=_CG_TOLERANCE, maxiter=_MAX_CG_STEPS, M=preconditioner)
    if failed:
        raise InputError(
            f"The non-measured points cannot be filled: keep them, with {argument('non_measured', 'keep')}."
        )
    return np.asarray(found)


def _prepare(matrix: Any, places: Array) -> Any:
    """Return the multigrid cycle of a matrix whose unknowns lie at `places`, shape (2, n)."""
    from scipy.sparse import csr_array, diags_array
    from scipy.sparse.linalg import splu

    count = matrix.shape[0]
    if count <= _MAX_DIRECT_POINTS // 4:
        return splu(matrix.tocsc()).solve
    blocks = places // _AGGREGATE_SIDE
    keys, block = np.unique(blocks[0] * (int(blocks[1].max()) + 1) + blocks[1], return_inverse=True)
    aggregates = csr_array((np.ones(count), (np.arange(count), block)), shape=(count, keys.size))
    damped = diags_array(_JACOBI_DAMPING / matrix.diagonal())
    step = (damped @ matrix).tocsr()
    up = (aggregates - step @ aggregates).tocsr()
    down = up.T.tocsr()
    weight = damped.diagonal()
    coarse_places = np.stack(np.divmod(keys, int(blocks[1].max()) + 1))
    del step, aggregates, blocks, block
    coarse = _prepare((down @ matrix @ up).tocsr(), coarse_places)

    def cycle(residual: Array) -> Array:
        found = weight * residual
        found += up @ coarse(down @ (residual - matrix @ found))
        return np.asarray(found + weight * (residual - matrix @ found))

    return cycle
