"""Anisotropic half-spaces under pressure that is constant on each cell."""

from __future__ import annotations

import math

import attrs
import numpy as np
import roughcontact as rc

from roughcontact_layered.aliases import cell_waves
from roughcontact_layered.bodies import compliance_of_other
from roughcontact_layered.cells import cell_integrals
from roughcontact_layered.crystal import Anisotropic
from roughcontact_layered.stack import Array


def _crystals(value: object) -> tuple[Anisotropic, ...]:
    crystals = tuple(value) if isinstance(value, (list, tuple)) else (value,)
    if len(crystals) not in (1, 2) or not all(isinstance(crystal, Anisotropic) for crystal in crystals):
        raise rc.InputError.about("The crystals", value, "one Anisotropic material, or one for each body")
    for crystal in crystals:
        if not crystal.directions.is_even:
            raise _uneven(crystal)
    return crystals


def _uneven(crystal: Anisotropic) -> rc.InputError:
    turn = crystal.directions.turn_to_even
    remedy = (
        f"turn the crystal and its grid about the normal, so that x lies {math.degrees(turn):.4g} degrees from here "
        "towards y"
        if turn is not None
        else "no direction of x makes it even, because no plane of symmetry stands on this surface"
    )
    return rc.InputError(
        f"The response of the crystal with normal {crystal.normal} and x axis {crystal.x_axis} is not even in x and in "
        f"y, as that of a kernel must be: {remedy}."
    )


@attrs.frozen
class AnisotropicKernel(rc.InfluenceKernel):
    r"""Anisotropic half-spaces, frictionless, under cells of constant pressure.

    .. math:: \hat u(q) = \frac{2\,c(\theta)}{|q|}\,\hat p(q), \quad
              u(r, \theta) = \frac{c(\theta + \pi/2)}{\pi r}\,F

    with c half of the component of L^-1 along the normal (`respond_to_directions`), for a wave that runs along the
    angle theta and for a point force F. Love's solution with the mean of c over the directions is the singular part.

    Parameters
    ----------
    crystals
        The material of the body, or of both bodies, that is anisotropic: that of the `roughcontact.Body`. What is left
        of 1/E* is an isotropic half-space. Of two crystals each has its own normal, outwards, and both the x axis of
        the grid.

    Raises
    ------
    roughcontact.InputError
        If a response is not even in x and in y; the sentence tells by which angle to turn the crystal. When the kernel
        is used, if both bodies together are stiffer than the crystals.

    Examples
    --------
    >>> import roughcontact as rc
    >>> silicon = Anisotropic.cubic(165.7e9, 63.9e9, 79.6e9, normal=(1, 1, 0), x_axis=(0, 0, 1))
    >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Rigid())
    >>> wafer = rc.Body(rc.FlatSurface(), silicon)
    >>> grid = rc.Grid((64, 64), 50e-6)
    >>> problem = rc.ContactProblem(ball, wafer, grid=grid, kernel=AnisotropicKernel(silicon))
    >>> print(f"{problem.solve(force=1.0).approach * 1e9:.1f} nm")
    265.9 nm
    """

    crystals: tuple[Anisotropic, ...] = attrs.field(converter=_crystals, metadata={"material": True})

    def effective_modulus(self, wavenumber: Array, compliance: float) -> Array:
        """Return the inverse of the mean of 1/E* over the directions, the same for all waves, shape (n,), Pa."""
        return np.full(wavenumber.shape, 1.0 / compliance)

    def directional_modulus(self, angle: Array, compliance: float) -> Array:
        """Return the modulus of waves along an angle from the x axis, shape of `angle` (rad), Pa."""
        self._require(compliance)
        return np.asarray(1.0 / (compliance + self._deviation(np.cos(angle), np.sin(angle))))

    def coefficients(self, shape: tuple[int, int], spacing: tuple[float, float], compliance: float) -> Array:
        """Return the influence coefficients, shape (nx, ny), m/Pa."""
        self._require(compliance)
        mean = rc.Love().coefficients(shape, spacing, compliance)
        return np.asarray(mean + cell_integrals(_Deviation(self), shape, spacing))

    def spectrum(self, qx: Array, qy: Array, spacing: tuple[float, float], compliance: float) -> Array:
        """Return the response at the cell centres to waves of cell pressures, shape (m, n), m/Pa."""
        self._require(compliance)
        return np.asarray(rc.Love().spectrum(qx, qy, spacing, compliance) + cell_waves(self, qx, qy, spacing))

    def wave_rest(self, qx: Array, qy: Array) -> Array:
        """Return the response less its mean over the directions, for wave vectors, m/Pa."""
        return np.asarray(2.0 * self._deviation(qx, qy) / np.hypot(qx, qy))

    def _deviation(self, x: Array, y: Array) -> Array:
        return np.asarray(sum(crystal.directions.deviation(x, y) for crystal in self.crystals))

    def _require(self, compliance: float) -> None:
        compliance_of_other("The crystal", sum(crystal.compliance for crystal in self.crystals), compliance)


@attrs.frozen
class _Deviation:
    """The displacement around a point force less its mean over the directions."""

    kernel: AnisotropicKernel

    def displacement(self, x: Array, y: Array) -> Array:
        """Return the displacement by a unit force, m/N: of the wave at right angles."""
        return np.asarray(self.kernel._deviation(y, x) / (np.pi * np.hypot(x, y)))

    def along_ray(self, x: Array, y: Array) -> Array:
        """Return its integral along a ray, m/N: it falls as 1/r."""
        return self.displacement(x, y)
