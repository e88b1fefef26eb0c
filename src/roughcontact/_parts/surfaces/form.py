"""Form of a height map, to be separated from its roughness: polynomials and spheres by least squares."""

from __future__ import annotations

import numpy as np

from roughcontact._base.checks import Array, Mask, RealArray
from roughcontact.errors import InputError

# Relative change of misfit, parameters and gradient at which the fit of a sphere stops, a few times the rounding of
# float64 (2.2e-16): the fit has four parameters, so that full accuracy costs nothing.
_TOLERANCE = 1e-15
# A curvature that bends the map by less than this fraction of its height and length is rounding: the map is flat.
_ROUNDING = 1e-13
_TOO_FEW = "Too few points were measured, or they are too nearly in line, for"


def polynomial(values: Array, degree: int, non_measured: Mask | None, shape: tuple[int, int] | None = None) -> Array:
    """Return the least-squares polynomial of total degree `degree` through heights, shape (nx, ny), m.

    It is evaluated on the same cells, or on `shape` cells of the domain. Non-measured points do not count;
    `InputError` if the others do not determine the polynomial.
    """
    x, y = (np.linspace(-1.0, 1.0, n) for n in values.shape)
    px, py = (np.polynomial.legendre.legvander(t, degree) for t in (x, y))
    terms = [(i, j) for i in range(degree + 1) for j in range(degree + 1 - i)]
    # The terms are products, so that all sums of the normal equations factor over the axes.
    n = degree + 1
    qx, qy = ((p[:, :, np.newaxis] * p[:, np.newaxis, :]).reshape(len(p), n * n) for p in (px, py))
    if non_measured is None:
        sums = np.outer(qx.sum(axis=0), qy.sum(axis=0))
        moments = px.T @ values @ py
    else:
        counts = (~non_measured).astype(np.float64)
        sums = qx.T @ counts @ qy
        moments = px.T @ (values * counts) @ py
    sums = sums.reshape(n, n, n, n)
    gram = np.array([[sums[i, k, j, m] for k, m in terms] for i, j in terms])
    solved, _, rank, _ = np.linalg.lstsq(gram, np.array([moments[term] for term in terms]))
    if rank < len(terms):
        raise InputError(f"{_TOO_FEW} a form of degree {degree}.")
    weights = np.zeros_like(moments)
    for term, weight in zip(terms, solved, strict=True):
        weights[term] = weight
    if shape is not None:
        x, y = (
            ((np.arange(m) + 0.5) * n / m - 0.5) * 2 / (n - 1) - 1 for m, n in zip(shape, values.shape, strict=True)
        )
        px, py = (np.polynomial.legendre.legvander(t, degree) for t in (x, y))
    return np.asarray(px @ weights @ py.T, dtype=np.float64)


def sphere(values: Array, x: Array, y: Array, non_measured: Mask | None) -> tuple[Array, float]:
    r"""Return the least-squares sphere, shape (nx, ny), m, and its curvature 1/R, positive for a ball, 1/m.

    The sphere through (0, 0, c) with the unit normal n there is

    .. math:: z = c - \frac{2 C}{n_z + \sqrt{n_z^2 - 2 \kappa C}}, \quad
              C = \tfrac{\kappa}{2}(x^2 + y^2) + n_x x + n_y y

    and becomes a plane, without a singularity, as the curvature goes to zero; c, the two slopes and the
    curvature are fitted to the heights, starting from the least-squares paraboloid.

    Heights have shape (nx, ny), positions shape (nx, 1) and (1, ny), m. Non-measured points do not count; `InputError`
    if the others do not determine a sphere, or the best one does not cover the map.
    """
    from scipy.optimize import least_squares

    length = float(max(np.abs(x).max(), np.abs(y).max()))
    x = x / length
    y = y / length
    mean = float(values.mean())
    heights = (values - mean) / length
    use = slice(None) if non_measured is None else ~non_measured
    square = x**2 + y**2
    # Constant, slopes and curvature enter the paraboloid linearly.
    basis = np.stack([np.broadcast_to(t, values.shape)[use].ravel() for t in (np.ones((1, 1)), x, y, -0.5 * square)])
    goal = heights[use].ravel()
    gram = basis @ basis.T
    if goal.size <= len(gram) or np.linalg.matrix_rank(gram) < len(gram):
        raise InputError(f"{_TOO_FEW} a sphere.")
    scale = float(np.ptp(goal)) or 1.0

    def misfit(parameters: Array) -> Array:
        return np.asarray((_cap(parameters, x, y, square)[0][use].ravel() - goal) / scale, dtype=np.float64)

    paraboloid = np.asarray(np.linalg.solve(gram, basis @ goal), dtype=np.float64)
    found = least_squares(misfit, paraboloid, "3-point", method="lm", ftol=_TOLERANCE, xtol=_TOLERANCE, gtol=_TOLERANCE)
    fitted, inside = _cap(found.x, x, y, square)
    if not inside:
        raise InputError("No sphere fits the heights: the domain is wider than the best sphere.")
    curvature = float(found.x[3])
    flat = abs(curvature) <= _ROUNDING * (1.0 + float(np.abs(values).max()) / length)
    return fitted * length + mean, 0.0 if flat else curvature / length


def _cap(parameters: RealArray, x: Array, y: Array, square: Array) -> tuple[Array, bool]:
    """Return the heights of the sphere, those of its equator beyond it, and whether all points are inside."""
    c, slope_x, slope_y, curvature = parameters
    normal_z = 1.0 / np.sqrt(1.0 + slope_x**2 + slope_y**2)
    lift = 0.5 * curvature * square - normal_z * (slope_x * x + slope_y * y)
    root = normal_z**2 - 2.0 * curvature * lift
    inside = bool((root > 0.0).all())
    heights = c - 2.0 * lift / (normal_z + np.sqrt(np.maximum(root, 0.0)))
    return np.asarray(heights, dtype=np.float64), inside
