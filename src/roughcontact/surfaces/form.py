"""Form of a height map, to be told apart from its roughness: polynomials and spheres by least squares."""

from __future__ import annotations

import numpy as np

from roughcontact.checks import Array, Mask, RealArray
from roughcontact.errors import InputError

# The fit of a sphere goes on to rounding.
_TOLERANCE = 1e-15
_ROUNDING = 1e-13


def polynomial(values: Array, degree: int, missing: Mask | None) -> Array:
    """Return the least-squares polynomial of total degree `degree`, shape (nx, ny), m.

    Parameters
    ----------
    values
        Heights, shape (nx, ny), m.
    degree
        Total degree, less than either cell count.
    missing
        Points that do not count, shape (nx, ny); None if all do.

    Raises
    ------
    InputError
        If the points that count do not determine it.
    """
    x, y = (np.linspace(-1.0, 1.0, n) for n in values.shape)
    px, py = (np.polynomial.legendre.legvander(t, degree) for t in (x, y))
    terms = [(i, j) for i in range(degree + 1) for j in range(degree + 1 - i)]
    # The terms are products, so that all sums of the normal equations factor over the axes.
    n = degree + 1
    qx, qy = ((p[:, :, np.newaxis] * p[:, np.newaxis, :]).reshape(len(p), n * n) for p in (px, py))
    if missing is None:
        sums, moments = np.outer(qx.sum(axis=0), qy.sum(axis=0)), px.T @ values @ py
    else:
        counts = (~missing).astype(np.float64)
        sums, moments = qx.T @ counts @ qy, px.T @ (values * counts) @ py
    sums = sums.reshape(n, n, n, n)
    gram = np.array([[sums[i, k, j, m] for k, m in terms] for i, j in terms])
    solved, _, rank, _ = np.linalg.lstsq(gram, np.array([moments[term] for term in terms]))
    if rank < len(terms):
        raise InputError(f"Too few points were measured, or they lie too much in line, for a form of degree {degree}.")
    weights = np.zeros_like(moments)
    for term, weight in zip(terms, solved, strict=True):
        weights[term] = weight
    return np.asarray(px @ weights @ py.T, dtype=np.float64)


def sphere(values: Array, x: Array, y: Array, missing: Mask | None) -> tuple[Array, float]:
    r"""Return the least-squares sphere, shape (nx, ny), m, and its curvature 1/R, positive for a ball, 1/m.

    The sphere through (0, 0, c) with the unit normal n there is

    .. math:: z = c - \frac{2 C}{n_z + \sqrt{n_z^2 - 2 \kappa C}}, \quad
              C = \tfrac{\kappa}{2}(x^2 + y^2) + n_x x + n_y y

    and becomes a plane, without a singularity, as the curvature goes to zero; c, the two slopes and the
    curvature are fitted to the heights, from the least-squares paraboloid on.

    Parameters
    ----------
    values
        Heights, shape (nx, ny), m.
    x, y
        Positions of the points, shape (nx, 1) and (1, ny), m.
    missing
        Points that do not count, shape (nx, ny); None if all do.

    Raises
    ------
    InputError
        If the heights do not look like a cap of a sphere.
    """
    from scipy.optimize import least_squares

    length = float(max(np.abs(x).max(), np.abs(y).max()))
    x, y = x / length, y / length
    level = float(values.mean())
    heights = (values - level) / length
    use = slice(None) if missing is None else ~missing
    square = x**2 + y**2
    # Paraboloid first: constant, slopes and curvature enter linearly.
    basis = np.stack([np.broadcast_to(t, values.shape)[use].ravel() for t in (np.ones((1, 1)), x, y, -0.5 * square)])
    goal = heights[use].ravel()
    gram = basis @ basis.T
    if goal.size <= len(gram) or np.linalg.matrix_rank(gram) < len(gram):
        raise InputError("Too few points were measured, or they lie too much in line, for a sphere.")
    scale = float(np.ptp(goal)) or 1.0

    def misfit(parameters: Array) -> Array:
        return np.asarray((_cap(parameters, x, y, square)[0][use].ravel() - goal) / scale, dtype=np.float64)

    paraboloid = np.asarray(np.linalg.solve(gram, basis @ goal), dtype=np.float64)
    found = least_squares(misfit, paraboloid, "3-point", method="lm", ftol=_TOLERANCE, xtol=_TOLERANCE, gtol=_TOLERANCE)
    fitted, inside = _cap(found.x, x, y, square)
    if not inside:
        raise InputError("No sphere fits the heights: over this domain they are no cap of one.")
    # What bends less than rounding is no sphere.
    curvature = float(found.x[3])
    flat = abs(curvature) <= _ROUNDING * (1.0 + float(np.abs(values).max()) / length)
    return fitted * length + level, 0.0 if flat else curvature / length


def _cap(parameters: RealArray, x: Array, y: Array, square: Array) -> tuple[Array, bool]:
    """Return the sphere's heights, those of its equator beyond it, and whether all are inside."""
    c, slope_x, slope_y, curvature = parameters
    across = 1.0 / np.sqrt(1.0 + slope_x**2 + slope_y**2)
    lift = 0.5 * curvature * square - across * (slope_x * x + slope_y * y)
    root = across**2 - 2.0 * curvature * lift
    inside = bool((root > 0.0).all())
    heights = c - 2.0 * lift / (across + np.sqrt(np.maximum(root, 0.0)))
    return np.asarray(heights, dtype=np.float64), inside
