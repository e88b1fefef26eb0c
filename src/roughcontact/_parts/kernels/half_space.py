"""The homogeneous half-space: Love's solution for a rectangular cell, and its spectrum."""

from __future__ import annotations

from typing import ClassVar

import attrs
import numpy as np

from roughcontact._base.arrays import Array, Pair
from roughcontact._parts.kernels.base import InfluenceKernel, SupportsCoefficients, missing_form
from roughcontact._parts.kernels.cells import alias_sum, cell_potential
from roughcontact._parts.kernels.shear import respond_to_shear, respond_to_shear_waves, shear_amplitude
from roughcontact._parts.materials import PairConstants


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
        return respond_to_shear(component, shape, spacing, compliance, pair)

    def shear_spectrum(
        self, component: str, qx: Array, qy: Array, spacing: Pair, compliance: float, pair: PairConstants
    ) -> Array:
        """Return a component at the cell centres for waves of cell shears; see `SupportsShear`."""
        return respond_to_shear_waves(component, qx, qy, spacing, compliance, pair)


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
        return shear_amplitude(component, qx, qy, compliance, pair)
