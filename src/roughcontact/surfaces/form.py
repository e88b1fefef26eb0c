"""Form of a height map, to be told apart from its roughness: polynomials and spheres by least squares."""

from __future__ import annotations

import numpy as np

from roughcontact.checks import Array, Mask, RealArray
from roughcontact.errors import InputError

# The fit of a sphere ends when a step moves no height by more than this share of their range.
_SETTLED = 1e-13
_STEPS = 50


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
    solved = np.linalg.lstsq(gram, np.array([moments[term] for term in terms]))[0]
    weights = np.zeros_like(moments)
    for term, weight in zip(terms, solved, strict=True):
        weights[term] = weight
    return np.asarray(px @ weights @ py.T, dtype=np.float64)


def sphere(values: Array, x: Array, y: Array, missing: Mask | None) -> tuple[Array, float]:
    r"""Return the least-squares sphere, shape (nx, ny), m, and its curvature 1/R, positive for a ball, 1/m.

    The sphere through (0, 0, c) with the unit normal n there is

    .. math:: z = c - \frac{2 C}{n_z + \sqrt{n_z^2 - 2 \kappa C}}, \quad
              C = \tfrac{\kappa}{2}(x^2 + y^2) + n_x x + n_y y

    and becomes a plane, without a singularity, as the curvature goes to zero. Gauss-Newton steps fit
    c, the two slopes and the curvature to the heights.

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
    length = float(max(np.abs(x).max(), np.abs(y).max()))
    x, y = x / length, y / length
    level = float(values.mean())
    heights = (values - level) / length
    use = slice(None) if missing is None else ~missing
    square = x**2 + y**2
    # Paraboloid first: constant, slopes and curvature enter linearly.
    basis = np.stack([np.broadcast_to(t, values.shape)[use].ravel() for t in (np.ones((1, 1)), x, y, -0.5 * square)])
    goal = heights[use].ravel()
    parameters = np.linalg.solve(basis @ basis.T, basis @ goal)
    scale = float(np.ptp(goal)) or 1.0
    for _ in range(_STEPS):
        step = np.linalg.solve(basis @ basis.T, basis @ (goal - _cap(parameters, x, y, square)[use].ravel()))
        parameters = parameters + step
        if np.abs(basis.T @ step).max() <= _SETTLED * scale:
            return _cap(parameters, x, y, square) * length + level, float(parameters[3]) / length
    raise InputError("No sphere fits the heights: the fit does not settle.")


def _cap(parameters: RealArray, x: Array, y: Array, square: Array) -> Array:
    """Return the sphere's heights."""
    c, slope_x, slope_y, curvature = parameters
    across = 1.0 / np.sqrt(1.0 + slope_x**2 + slope_y**2)
    lift = 0.5 * curvature * square - across * (slope_x * x + slope_y * y)
    root = across**2 - 2.0 * curvature * lift
    if not (root > 0.0).all():
        raise InputError("No sphere fits the heights: over this domain they are no cap of one.")
    return np.asarray(c - 2.0 * lift / (across + np.sqrt(root)), dtype=np.float64)
