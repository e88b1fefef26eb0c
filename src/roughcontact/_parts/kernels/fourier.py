"""The half-space in Fourier space."""

from __future__ import annotations

from typing import ClassVar

import attrs
import numpy as np

from roughcontact._base.checks import Array, Pair
from roughcontact._parts.kernels.base import InfluenceKernel


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
