"""Layers on a half-space, under pressure that is constant on each cell."""

from __future__ import annotations

import attrs
import numpy as np
import roughcontact as rc
from roughcontact.typing import PairConstants

from roughcontact_layered.below import find_excess
from roughcontact_layered.bodies import compliance_of_other
from roughcontact_layered.conduction import LayeredConduction, conductivity_of
from roughcontact_layered.harmonics import FindWaves, integrate_stress
from roughcontact_layered.shear import LayeredShear
from roughcontact_layered.stack import Array, Layer, respond
from roughcontact_layered.stacked import StackedKernel
from roughcontact_layered.waves_below import sum_waves


def _layers(value: object) -> tuple[Layer, ...]:
    layers = tuple(value) if isinstance(value, (list, tuple)) else (value,)
    if not layers or not all(isinstance(layer, Layer) for layer in layers):
        raise rc.InputError.about("The layers", value, "one Layer or more, from the surface downwards")
    return layers


def _substrate(value: object) -> rc.Elastic:
    if not isinstance(value, rc.Elastic):
        raise rc.InputError.about("The substrate", value, "the Elastic material of the coated body")
    return value


@attrs.frozen
class LayeredKernel(StackedKernel):
    r"""Bonded elastic layers on one of the two bodies, frictionless, under cells of constant pressure.

    .. math:: \hat u(q) = \left[\frac{2}{E^*|q|} + \hat u_\mathrm{layers}(q) - \frac{2 c_s}{|q|}\right] \hat p(q)

    The half-spaces under the layers, of both bodies, come from the materials of the contact problem,
    through 1/E*. The layers on one of them come from here; `substrate` repeats that body's material,
    because the layers need its Poisson ratio and the part that is its own, c_s = (1 - nu^2)/E, of 1/E*.

    Parameters
    ----------
    layers
        From the surface downwards.
    substrate
        The material of the body that carries the layers: that of the `roughcontact.Body`.

    Raises
    ------
    roughcontact.InputError
        If a part is of another kind; and, when the kernel is used, if both bodies together are stiffer
        than the substrate alone, so that none of them can be made of it.

    Examples
    --------
    >>> import roughcontact as rc
    >>> steel = rc.Elastic(young=210e9, poisson=0.3)
    >>> coating = LayeredKernel(Layer(young=400e9, poisson=0.25, thickness=2e-6), substrate=steel)
    >>> coated = rc.Body(rc.SphereSurface(radius=1e-3), steel)
    >>> problem = rc.ContactProblem(coated, grid=rc.Grid((64, 64), (1e-4, 1e-4)), kernel=coating)
    """

    layers: tuple[Layer, ...] = attrs.field(converter=_layers)
    substrate: rc.Elastic = attrs.field(converter=_substrate)

    def respond(self, q: Array) -> tuple[Array, Array]:
        """Return q u / p of the coated body, and the same less that of a half-space of the topmost layer, 1/Pa."""
        return respond(self.layers, self.substrate, q)

    def top_compliance(self) -> float:
        """Return (1 - nu^2) / E of the topmost layer, 1/Pa."""
        return self.layers[0].compliance

    def other_compliance(self, compliance: float) -> float:
        """Return (1 - nu^2) / E of the body without layers, 1/Pa."""
        return compliance_of_other(f"The substrate {self.substrate!r}", self.substrate.compliance, compliance)

    def conduction_kernel(self, conductivity: float) -> LayeredConduction:
        """Return the response of temperature to heat, or of potential to current; see `roughcontact.typing`.

        Parameters
        ----------
        conductivity
            Of the body under the layers, W/(m K) or S/m.

        Raises
        ------
        roughcontact.InputError
            If the conductivity of a layer is not known.

        Examples
        --------
        A layer of 2 µm that conducts badly, on one of two bodies of steel:

        >>> import roughcontact as rc
        >>> steel = rc.Elastic(young=210e9, poisson=0.3)
        >>> ball = rc.Body(rc.ParaboloidSurface(radius=1e-3), steel)
        >>> flat = rc.Body(rc.FlatSurface(), steel)
        >>> for conductivity in (2.0, 45.0):
        ...     oxide = LayeredKernel(Layer(210e9, 0.3, 2e-6, conductivity), substrate=steel)
        ...     problem = rc.ContactProblem(ball, flat, grid=rc.Grid((64, 64), 80e-6), kernel=oxide)
        ...     print(f"{problem.solve(force=5.0).conductance(45.0).value:.5f} W/K")
        0.00152 W/K
        0.00287 W/K
        """
        for layer in self.layers:
            conductivity_of(layer)
        return LayeredConduction(self.layers, conductivity)

    def shear_kernel(self, axis: int, pair: PairConstants) -> LayeredShear:
        """Return the response of displacement along an axis to shear along it; see `roughcontact.typing`.

        Parameters
        ----------
        axis
            0 for x, 1 for y.
        pair
            The constants of the two half-spaces under the layers.
        """
        return LayeredShear(self.layers, self.substrate, axis, pair)

    def coupling(self, wavenumber: Array, compliance: float, pair: PairConstants) -> Array:
        """Return Dundurs' beta of each wave number, shape (n,), positive where the coated body is the softer one.

        Parameters
        ----------
        wavenumber
            Wave numbers, shape (n,), rad/m, above zero.
        compliance
            1/E* of the half-spaces under the layers, 1/Pa.
        pair
            Their constants, with the coated body as the body.
        """
        own = -respond(self.layers, self.substrate, wavenumber, (0, 1))[0]
        substrate = (1.0 - 2.0 * self.substrate.poisson) * (1.0 + self.substrate.poisson) / self.substrate.young
        change = own - substrate + 2.0 * pair.beta * compliance
        return np.asarray(change / (wavenumber * self.response(wavenumber, compliance)))

    @property
    def interfaces(self) -> Array:
        """Depths of the interfaces, shape (n,), m, ascending."""
        return np.cumsum([layer.thickness for layer in self.layers])

    def describes(self, material: rc.Material) -> bool:
        """Return whether the layers lie on a body of this material; a hardness does not count."""
        if not isinstance(material, (rc.Elastic, rc.ElasticPerfectlyPlastic)):
            return False
        return (material.young, material.poisson) == (self.substrate.young, self.substrate.poisson)

    def poisson_at(self, depth: float) -> float:
        """Return Poisson's ratio at a depth, m; at an interface the one above."""
        number = self._number_at(depth)
        return self.layers[number].poisson if number < len(self.layers) else self.substrate.poisson

    def stress_coefficients(
        self, load: str, shape: tuple[int, int], spacing: tuple[float, float], depth: float
    ) -> Array:
        """Return the stress at offsets from a cell with unit load, less that of a half-space.

        Parameters
        ----------
        load
            ``"z"``, a pressure, or ``"x"`` or ``"y"``, a traction along this axis.
        shape, spacing
            Offsets (nx, ny), and sides of a cell (dx, dy), m.
        depth
            Depth, m.

        Returns
        -------
        Array
            The components xx, yy, zz, yz, xz, xy, shape (6, nx, ny).
        """
        if load == "y":
            return _exchange_axes(self.stress_coefficients("x", shape[::-1], spacing[::-1], depth))
        return integrate_stress(self._find_waves(depth), load, shape, spacing, self._reach(depth))

    def stress_spectrum(self, load: str, qx: Array, qy: Array, spacing: tuple[float, float], depth: float) -> Array:
        """Return the stress at cell centres by waves of loads on cells, less that of a half-space, (6, m, n).

        Raises
        ------
        roughcontact.InputError
            If the layers are much thinner than a cell.
        """
        if load == "y":
            return _exchange_axes(self.stress_spectrum("x", qy.T, qx.T, spacing[::-1], depth))
        return sum_waves(self._find_waves(depth), load, qx, qy, spacing, self._reach(depth))

    def _find_waves(self, depth: float) -> FindWaves:
        number = self._number_at(depth)
        return lambda load, q: find_excess(self.layers, self.substrate, load, q, depth, number)

    def _reach(self, depth: float) -> float:
        return max(depth, 2.0 * self.layers[0].thickness - depth)

    def _number_at(self, depth: float) -> int:
        # A depth at an interface lies above it, also after rounding.
        return int(np.searchsorted(self.interfaces, (1.0 - 1e-12) * depth))


def _exchange_axes(stress: Array) -> Array:
    """Return the components xx, yy, zz, yz, xz, xy after an exchange of the axes x and y, shape (6, m, n)."""
    return np.ascontiguousarray(stress[[1, 0, 2, 4, 3, 5]].transpose(0, 2, 1))
