"""The homogeneous half-space: Love's and Cerruti's solutions for a rectangular cell, and their spectra."""

from __future__ import annotations

from typing import ClassVar

import attrs
import numpy as np

from roughcontact._base.arrays import Array, Pair
from roughcontact._base.checks import choice
from roughcontact._parts.kernels.base import InfluenceKernel, SupportsCoefficients, missing_form
from roughcontact._parts.kernels.cells import (
    alias_sum,
    cell_potential,
    edges_across,
    ends_of_lines,
    integrate_by_distance,
)
from roughcontact._parts.materials import PairConstants

# The name of each component after an exchange of the axes.
_EXCHANGED = {"xx": "yy", "yy": "xx", "xy": "xy", "zx": "zy", "zy": "zx"}


@attrs.frozen
class Love(InfluenceKernel):
    r"""Homogeneous half-space under pressure that is constant on each cell.

    .. math:: u = \frac{1}{\pi E^*} \iint_\mathrm{cell} \frac{\mathrm{d}\xi\,\mathrm{d}\eta}
              {\sqrt{(x-\xi)^2 + (y-\eta)^2}}

    Love's four logarithms are this integral, but they cancel: their error grows as the square of
    the distance in cells. Near the field point the integral is taken as a sum over the four edges,
    each term without cancellation; elsewhere exactly along the longer side and by Gauss points
    across the shorter, a sum of positive terms. The relative error stays below 1e-14 for cells of
    any aspect ratio up to 1e12 and offsets up to 16384 cells (test_kernels, against mpmath).

    References
    ----------
    Love, Phil. Trans. R. Soc. A 228 (1929) 377-420, https://doi.org/10.1098/rsta.1929.0009;
    Johnson, Contact Mechanics (1985), sec. 3.3, https://doi.org/10.1017/CBO9781139171731

    Examples
    --------
    At the centre of a square cell of side one the integral is 4 ln(1 + sqrt(2)):

    >>> import math
    >>> import roughcontact as rc
    >>> own = rc.Love().coefficients((1, 1), (1.0, 1.0), 1.0).item()
    >>> math.isclose(own, 4 / math.pi * math.log(1 + math.sqrt(2)), rel_tol=1e-15)
    True
    """

    def effective_modulus(self, wavenumber: Array, compliance: float) -> None:
        """Return None: all waves have the modulus 1/compliance."""
        return

    def coefficients(self, shape: tuple[int, int], spacing: Pair, compliance: float) -> Array:
        """Return the influence coefficients, shape (nx, ny), m/Pa; see `SupportsCoefficients`."""
        return self.coefficients_from(0, shape, spacing, compliance)

    def coefficients_from(self, first: int, shape: tuple[int, int], spacing: Pair, compliance: float) -> Array:
        """Return the influence coefficients of the rows from the first one on; see `SupportsRows`."""
        i = first + np.arange(shape[0], dtype=np.float64)
        j = np.arange(shape[1], dtype=np.float64)
        dx, dy = spacing
        if dx < dy:
            return np.ascontiguousarray(cell_potential(j, i, dy / dx).T) * (compliance * dx / np.pi)
        return cell_potential(i, j, dx / dy) * (compliance * dy / np.pi)

    def spectrum(self, qx: Array, qy: Array, spacing: Pair, compliance: float) -> Array:
        r"""Return the response at the cell centres to waves of cell pressures; see `SupportsSpectrum`.

        Pressure that is constant on cells contains all aliases q + Q of a wave q:

        .. math:: \hat K(q) = \sum_Q \frac{2}{E^* |q + Q|}
                  \operatorname{sinc}\frac{(q_x + Q_x)\Delta x}{2}
                  \operatorname{sinc}\frac{(q_y + Q_y)\Delta y}{2}
        """
        dx, dy = spacing
        # On square cells the work follows the second axis.
        if dx < dy or (dx == dy and qx.size < qy.size):
            return self.spectrum(qy.T, qx.T, (dy, dx), compliance).T
        # Rows that differ in sign only have the same values.
        rows, row_of = np.unique(np.abs(qx[:, 0] * dx), return_inverse=True)
        values = alias_sum(rows, np.abs(qy[0, :] * dy), dx / dy)
        return np.asarray((2.0 * compliance * dy * values)[row_of], dtype=np.float64)

    def shear_coefficients(
        self, component: str, shape: tuple[int, int], spacing: Pair, compliance: float, pair: PairConstants
    ) -> Array:
        """Return a component for shear that is constant on each cell; see `SupportsShear`."""
        _require_component(component)
        dx, dy = spacing
        if dx < dy:
            exchanged = Love.shear_coefficients(self, _EXCHANGED[component], shape[::-1], (dy, dx), compliance, pair)
            return np.ascontiguousarray(exchanged.T)
        i, j = (np.arange(n, dtype=np.float64) for n in shape)
        aspect = dx / dy
        if component == "xy":
            values = pair.gamma * _integrate_product(i, j, aspect)
        elif component == "zx":
            values = pair.beta * integrate_by_distance(i, j, aspect, _add_edges_along, _log_of_line)
        elif component == "zy":
            values = pair.beta * integrate_by_distance(i, j, aspect, _add_edges_across, _angle_of_line)
            values[:, j == 0.0] = 0.0
        else:
            potential = cell_potential(i, j, aspect)
            # Of 1/r, the part y^2/r^3; the rest is x^2/r^3.
            part = integrate_by_distance(i, j, aspect, _add_square_edges, _square_of_line)
            values = potential + pair.gamma * (part if component == "yy" else potential - part)
        return np.asarray(values * (compliance * dy / np.pi))

    def shear_spectrum(
        self, component: str, qx: Array, qy: Array, spacing: Pair, compliance: float, pair: PairConstants
    ) -> Array:
        """Return a component at the cell centres for waves of cell shears; see `SupportsShear`."""
        _require_component(component)
        dx, dy = spacing
        if dx < dy:
            return Love.shear_spectrum(self, _EXCHANGED[component], qy.T, qx.T, (dy, dx), compliance, pair).T
        # Rows that differ in sign only have the same values, but for the sign.
        rows, row_of = np.unique(np.abs(qx[:, 0] * dx), return_inverse=True)
        columns = np.abs(qy[0, :] * dy)

        def sum_aliases(term: str) -> Array:
            return alias_sum(rows, columns, dx / dy, term)[row_of]

        if component == "xy":
            values = -pair.gamma * sum_aliases("xy/k3") * np.sign(qx) * np.sign(qy)
        elif component == "zx":
            values = -pair.beta * sum_aliases("x/k2") * np.sign(qx)
        elif component == "zy":
            values = -pair.beta * sum_aliases("y/k2") * np.sign(qy)
        else:
            values = sum_aliases("1/k") + pair.gamma * sum_aliases("yy/k3" if component == "xx" else "xx/k3")
        return np.asarray(2.0 * compliance * dy * values)


@attrs.frozen
class FourierHalfSpace(InfluenceKernel):
    r"""Homogeneous half-space whose pressure is the trigonometric polynomial through the cell centres.

    .. math:: \hat u(q) = \frac{2}{E^*\,|q|}\,\hat p(q)

    References
    ----------
    Stanley, Kato, J. Tribol. 119 (1997) 481-485, https://doi.org/10.1115/1.2833523

    Examples
    --------
    >>> import roughcontact as rc
    >>> wave = rc.WavySurface(amplitude=1e-6, wavelength=50e-6)
    >>> body = rc.Body(wave, rc.Elastic(young=210e9, poisson=0.3))
    >>> problem = rc.ContactProblem(body, grid=rc.Grid((32, 32), 100e-6), boundary="periodic", kernel="fourier")
    >>> print(problem.solve(pressure=100e6).status)
    converged: the conditions of contact hold within the tolerance
    """

    edge_shift: ClassVar[float] = 0.0

    def effective_modulus(self, wavenumber: Array, compliance: float) -> None:
        """Return None: all waves have the modulus 1/compliance."""
        return

    def spectrum(self, qx: Array, qy: Array, spacing: Pair, compliance: float) -> Array:
        """Return ``2 / (E* |q|)``, shape (m, n), m/Pa; see `SupportsSpectrum`."""
        return np.asarray(2.0 * compliance / np.hypot(qx, qy), dtype=np.float64)

    def shear_coefficients(
        self, component: str, shape: tuple[int, int], spacing: Pair, compliance: float, pair: PairConstants
    ) -> Array:
        """Raise `InputError`: it has no coefficients."""
        raise missing_form(self, SupportsCoefficients)

    def shear_spectrum(
        self, component: str, qx: Array, qy: Array, spacing: Pair, compliance: float, pair: PairConstants
    ) -> Array:
        """Return a component for waves of shear; see `SupportsShear`."""
        _require_component(component)
        length = np.hypot(qx, qy)
        normal = {"x": qx / length, "y": qy / length}
        first = component[0]
        second = component[1]
        if first == "z":
            factor = -pair.beta * normal[second]
        else:
            factor = (first == second) * (1.0 + pair.gamma) - pair.gamma * normal[first] * normal[second]
        return np.asarray(2.0 * compliance * factor / length)


def _require_component(component: str) -> None:
    """Raise `InputError` unless a kernel knows the component."""
    choice(component, "The component of the response to shear", tuple(_EXCHANGED))


def _integrate_product(i: Array, j: Array, aspect: float) -> Array:
    """Return the integral of x y/r^3 over cells: the sum of the distances of the corners, without cancellation."""
    left, right = ends_of_lines(i, aspect)
    x = (i * aspect)[:, np.newaxis]
    y = j[np.newaxis, :]
    near, far = ([np.hypot(end, y + side) for end in (left, right)] for side in (-0.5, 0.5))
    along = 4.0 * aspect * x * y / ((near[0] + near[1]) * (far[0] + far[1]))
    return np.asarray(along * (1.0 / (near[0] + far[0]) + 1.0 / (near[1] + far[1])))


def _add_square_edges(x: Array, y: Array, aspect: float) -> Array:
    """Add the edges of the integral of y^2/r^3."""
    one, other = edges_across(x, y, aspect)
    return np.asarray(one + other)


def _square_of_line(i: Array, y: Array, aspect: float) -> Array:
    """Integrate y^2/r^3 exactly along x: x2/r2 - x1/r1, both over r where these are on one side of the origin."""
    left, right = ends_of_lines(i, aspect)
    r1 = np.hypot(left, y)
    r2 = np.hypot(right, y)
    # Negative only on a cell on both sides of the origin, where the difference is a sum.
    with np.errstate(invalid="ignore", divide="ignore"):
        line = 2.0 * aspect * (i * aspect)[:, np.newaxis] * y**2 / (r1 * r2 * (right * r1 + left * r2))
    return np.asarray(np.where(left < 0.0, right / r2 - left / r1, line))


def _add_edges_along(x: Array, y: Array, aspect: float) -> Array:
    """Add the edges of the integral of x/r^2."""
    return _add_odd_edges(x, y, aspect, 1.0)


def _add_edges_across(x: Array, y: Array, aspect: float) -> Array:
    """Add the edges of the integral of y/r^2."""
    return _add_odd_edges(y, x, 1.0, aspect)


def _add_odd_edges(u: Array, v: Array, length: float, width: float) -> Array:
    """Add the edges of the integral of u/r^2 over a cell with a length along u and a width along v.

    The edges along u bring their distances times the logarithm of the ratio of the distances of their ends, those
    along v their distances times the angle at which they are seen.
    """
    u1, u2 = (u + side * length for side in (-0.5, 0.5))
    v1, v2 = (v + side * width for side in (-0.5, 0.5))
    logs = [side * end * 0.5 * np.log1p(2.0 * length * u / (u1**2 + end**2)) for side, end in ((-1, v1), (1, v2))]
    angles = [side * end * np.arctan2(width * end, end**2 + v1 * v2) for side, end in ((-1, u1), (1, u2))]
    return np.asarray(logs[0] + logs[1] + angles[0] + angles[1])


def _log_of_line(i: Array, y: Array, aspect: float) -> Array:
    """Integrate x/r^2 exactly along x: the logarithm of the ratio of the distances of both ends."""
    left, _ = ends_of_lines(i, aspect)
    return np.asarray(0.5 * np.log1p(2.0 * aspect * (i * aspect)[:, np.newaxis] / (left**2 + y**2)))


def _angle_of_line(i: Array, y: Array, aspect: float) -> Array:
    """Integrate y/r^2 exactly along x: the angle at which the line is seen."""
    left, right = ends_of_lines(i, aspect)
    return np.asarray(np.arctan2(aspect * y, y**2 + left * right))
