"""A half-space whose modulus grows or falls exponentially with the depth, under constant pressure on each cell."""

from __future__ import annotations

import math

import attrs
import numpy as np
import roughcontact as rc

from roughcontact_layered.aliases import cell_waves
from roughcontact_layered.bodies import compliance_of_other
from roughcontact_layered.cells import cell_integrals
from roughcontact_layered.radial import tabulate
from roughcontact_layered.stack import Array


def _gradient(value: float) -> float:
    try:
        result = float(value)
    except (TypeError, ValueError):
        result = math.nan
    if isinstance(value, (str, bool)) or not math.isfinite(result):
        raise rc.InputError.about("The gradient", value, "a finite number (1/m)")
    return result


def _surface(value: object) -> rc.Elastic:
    if not isinstance(value, rc.Elastic):
        raise rc.InputError.about("The material at the surface", value, "the Elastic material of the graded body")
    return value


@attrs.frozen
class GradedKernel(rc.InfluenceKernel):
    r"""Half-space with Young's modulus that depends exponentially on the depth, frictionless.

    .. math:: E(z) = E_0 \exp(\alpha z)

    with the same Poisson's ratio at all depths. The other body comes from 1/E* of the contact problem, as for
    `LayeredKernel`.

    Parameters
    ----------
    gradient
        The rate alpha, 1/m: positive where the body stiffens with depth. A negative one needs the periodic boundary,
        because such a body carries no force without sinking infinitely.
    surface
        The material at the surface, E0 and Poisson's ratio: that of the `roughcontact.Body`.

    Raises
    ------
    roughcontact.InputError
        If a value is out of bounds; and, when the kernel is used, if both bodies together are stiffer than the surface
        alone, or the gradient is negative on a free or wrapped boundary.

    Examples
    --------
    A body that is twice as stiff at a depth of 69 µm carries more at the same approach:

    >>> import roughcontact as rc
    >>> soft = rc.Elastic(young=2e9, poisson=0.35)
    >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Rigid())
    >>> grid = rc.Grid((64, 64), 100e-6)
    >>> for gradient in (0.0, 1e4):
    ...     kernel = GradedKernel(gradient, surface=soft)
    ...     problem = rc.ContactProblem(ball, rc.Body(rc.FlatSurface(), soft), grid=grid, kernel=kernel)
    ...     print(f"{problem.solve(approach=0.5e-6).force:.4f} N")
    0.0340 N
    0.0538 N
    """

    gradient: float = attrs.field(converter=_gradient, metadata={"unit": "1/m"})
    surface: rc.Elastic = attrs.field(converter=_surface, metadata={"material": True})

    @property
    def own_material(self) -> rc.Elastic:
        """The material of the graded `roughcontact.Body`: that at the surface."""
        return self.surface

    @property
    def depth(self) -> float:
        """The depth over which the modulus changes by a factor of e, m; zero without a gradient."""
        return 1.0 / abs(self.gradient) if self.gradient else 0.0

    def response(self, q: Array, compliance: float) -> Array:
        """Return the displacement amplitude by a pressure wave of amplitude one; see `LayeredKernel.response`."""
        q = np.asarray(q, dtype=np.float64)
        own = self.surface.compliance * respond_graded(self.gradient / q, self.surface.poisson)
        return np.asarray((own + 2.0 * self._other(compliance)) / q)

    def effective_modulus(self, wavenumber: Array, compliance: float) -> Array:
        """Return 2 / (q u(q)), the contact modulus at each wave number, shape (n,), Pa."""
        return np.asarray(2.0 / (wavenumber * self.response(wavenumber, compliance)))

    def coefficients(self, shape: tuple[int, int], spacing: tuple[float, float], compliance: float) -> Array:
        """Return the influence coefficients, shape (nx, ny), m/Pa: Love's with E0, plus a smooth rest."""
        if self.gradient < 0.0:
            raise rc.InputError(
                f"A half-space that softens with depth (gradient {self.gradient:g} 1/m) sinks infinitely under a "
                "force: use boundary='periodic', or layers on a substrate."
            )
        values = rc.Love().coefficients(shape, spacing, self.surface.compliance + self._other(compliance))
        if self.gradient:
            largest = float(np.hypot(shape[0] * spacing[0], shape[1] * spacing[1]))
            values = values + cell_integrals(tabulate(self, 0.4 * min(spacing), largest), shape, spacing)
        return np.asarray(values)

    def spectrum(self, qx: Array, qy: Array, spacing: tuple[float, float], compliance: float) -> Array:
        """Return the response at the cell centres to waves of cell pressures, shape (m, n), m/Pa."""
        love = rc.Love().spectrum(qx, qy, spacing, self.surface.compliance + self._other(compliance))
        return np.asarray(love + cell_waves(self, qx, qy, spacing))

    def rest(self, q: Array) -> Array:
        """Return the response less that of a half-space of the surface's material, shape of `q` (rad/m), m/Pa."""
        change = respond_graded(self.gradient / q, self.surface.poisson) - 2.0
        return np.asarray(self.surface.compliance * change / q)

    def wave_rest(self, qx: Array, qy: Array) -> Array:
        """Return `rest` of wave vectors, m/Pa."""
        return self.rest(np.hypot(qx, qy))

    def _other(self, compliance: float) -> float:
        return compliance_of_other(f"The surface {self.surface!r}", self.surface.compliance, compliance)


def respond_graded(gradient: Array, poisson: float) -> Array:
    r"""Return q u / p of a half-space with E = E0 exp(alpha z), over (1 - nu^2) / E0.

    In plane strain the stress function exp((alpha / 2 + s) z), with k = nu / (1 - nu), satisfies

    .. math:: s^2 = q^2 + \alpha^2 / 4 \pm i \sqrt{k}\, q \alpha

    Both roots s = -(a + i b), -(a - i b) that decay enter by sum and product alone, so that coincident roots, without a
    gradient or for nu = 0, are no exception. With P = a^2 + b^2 and the traction along the surface zero

    .. math:: \frac{u}{p} = \frac{1 - \nu^2}{E_0 q^4}
              \left[2 a (P + \alpha^2 / 4 - \alpha a) - \alpha k q^2\right], \quad
              P^2 = (q^2 + \alpha^2 / 4)^2 + k q^2 \alpha^2, \quad 2 a^2 = P + q^2 + \alpha^2 / 4

    which is 2 (1 - nu^2) / (E0 q) without a gradient. The terms are arranged such that long waves do not cancel.

    Parameters
    ----------
    gradient
        The gradient alpha over the wave number, any shape, no unit.
    poisson
        Poisson's ratio.

    Returns
    -------
    Array
        Shape of `gradient`, no unit: 2 without a gradient.
    """
    g = np.asarray(gradient, dtype=np.float64)
    k = poisson / (1.0 - poisson)
    quarter = 0.25 * g**2
    product = np.sqrt((1.0 + quarter) ** 2 + k * g**2)
    a = np.sqrt(0.5 * (product + 1.0 + quarter))
    middle = product + quarter
    # a + |g| / 2, and a - |g| / 2 without cancellation.
    larger = a + 0.5 * np.abs(g)
    smaller = 0.5 * ((1.0 + (2.0 + 4.0 * k) * quarter) / middle + 1.0) / larger
    below = np.where(g > 0.0, smaller, larger)
    above = np.where(g > 0.0, larger, smaller)
    # 1 - k = (1 - 2 nu) / (1 - nu) does not cancel near incompressibility.
    numerator = 2.0 * a**2 * (below**2 + (1.0 - 2.0 * poisson) / (1.0 - poisson) * g * a) + g * k * above
    return np.asarray(below * numerator / (a * middle * above))
