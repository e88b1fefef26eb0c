"""Layers on a half-space or on a rigid base, under pressure that is constant on each cell."""

from __future__ import annotations

import math

import attrs
import numpy as np
import roughcontact as rc
from roughcontact.typing import HalfSpaceStress, PairConstants

from roughcontact_layered.aliases import cell_waves
from roughcontact_layered.below import find_excess
from roughcontact_layered.bodies import compliance_of_other, is_made_of
from roughcontact_layered.conduction import LayeredConduction, conductivity_of
from roughcontact_layered.harmonics import FindWaves, integrate_stress
from roughcontact_layered.shear import LayeredShear
from roughcontact_layered.stack import Array, Layer, Substrate, respond
from roughcontact_layered.stacked import StackedKernel
from roughcontact_layered.waves_below import sum_waves


def _layers(value: object) -> tuple[Layer, ...]:
    layers = tuple(value) if isinstance(value, (list, tuple)) else (value,)
    if not layers or not all(isinstance(layer, Layer) for layer in layers):
        raise rc.InputError.about("The layers", value, "one Layer or more, from the surface downwards")
    return layers


def _carrier(value: object) -> str | None:
    if value not in (None, "body", "counterbody"):
        raise rc.InputError.about("The carrier of the layers", value, "'body', 'counterbody' or None")
    return None if value is None else str(value)


def _substrate(value: object) -> Substrate:
    if not isinstance(value, (rc.Elastic, rc.Rigid)):
        allowed = "the Elastic material of the coated body, or Rigid() for a rigid base"
        raise rc.InputError.about("The substrate", value, allowed)
    return value


@attrs.frozen
class LayeredKernel(StackedKernel):
    r"""Bonded elastic layers on one of the two bodies, frictionless at the surface, under cells of constant pressure.

    .. math:: \hat u(q) = \left[\frac{2}{E^*|q|} + \hat u_\mathrm{layers}(q) - \frac{2 c_s}{|q|}\right] \hat p(q)

    The half-spaces under the layers, of both bodies, come from the materials of the contact problem,
    through 1/E*. The layers on one of them come from here; `substrate` repeats that body's material,
    because the layers need its Poisson ratio and the part that is its own, c_s = (1 - nu^2)/E, of 1/E*.

    Layers on a rigid base, to which they are bonded, have the material of the topmost layer as that of their
    `roughcontact.Body`: c_s is that layer's. A uniform pressure p then sinks the surface by p times
    `uniform_compliance`. A free boundary counts the approach from the base; on a periodic one it is counted from the
    mean of the displaced surface, as on half-spaces, so that the approach from the base is more by that amount.

    Parameters
    ----------
    layers
        From the surface downwards.
    substrate
        The material of the body that carries the layers, that of the `roughcontact.Body`; or ``rc.Rigid()``.
    carrier
        ``"body"`` or ``"counterbody"``, on which the layers lie; None: on the one of the substrate's material, on the
        body if both are. Only the stress below, the conductance and the tangential stiffness depend on it.

    Raises
    ------
    roughcontact.InputError
        If a part is of another kind; and, when the kernel is used, if both bodies together are stiffer
        than the substrate alone, or the topmost layer on a rigid base, so that none of them can be made of it.

    Examples
    --------
    >>> import roughcontact as rc
    >>> steel = rc.Elastic(young=210e9, poisson=0.3)
    >>> coating = LayeredKernel(Layer(young=400e9, poisson=0.25, thickness=2e-6), substrate=steel)
    >>> coated = rc.Body(rc.SphereSurface(radius=1e-3), steel)
    >>> problem = rc.ContactProblem(coated, grid=rc.Grid((64, 64), (1e-4, 1e-4)), kernel=coating)

    A rubber pad on a rigid base, under a rigid ball:

    >>> rubber = rc.Elastic(young=2e6, poisson=0.49)
    >>> pad = LayeredKernel(Layer(rubber.young, rubber.poisson, thickness=20e-6), substrate=rc.Rigid())
    >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Rigid())
    >>> pressed = rc.ContactProblem(ball, rc.Body(rc.FlatSurface(), rubber), grid=rc.Grid((64, 64), 200e-6), kernel=pad)
    """

    layers: tuple[Layer, ...] = attrs.field(converter=_layers)
    substrate: Substrate = attrs.field(converter=_substrate, metadata={"material": True})
    carrier: str | None = attrs.field(default=None, converter=_carrier)

    def __str__(self) -> str:
        where = "" if self.carrier is None else f" on the {self.carrier}"
        count = len(self.layers)
        return (
            f"{count} layer{'s' if count > 1 else ''}{where}: {'; '.join(map(str, self.layers))}; on {self.substrate}"
        )

    def part_of(self, body: str) -> rc.InfluenceKernel | None:
        """Return this kernel for the carrier, that of a half-space for the other body; None if none is stated."""
        if self.carrier is None:
            return None
        return self if body == self.carrier else rc.Love()

    @property
    def own_material(self) -> Layer | rc.Elastic:
        """The material of the coated `roughcontact.Body`: the substrate, or on a rigid base the topmost layer."""
        return self.layers[0] if isinstance(self.substrate, rc.Rigid) else self.substrate

    @property
    def uniform_compliance(self) -> float:
        r"""Displacement of the surface by a uniform unit pressure, m/Pa; infinite on a half-space.

        The layers are compressed one by one with their sides held,

        .. math:: \frac{u}{p} = \sum_k \frac{h_k (1 + \nu_k) (1 - 2 \nu_k)}{E_k (1 - \nu_k)}
        """
        is_rigid = isinstance(self.substrate, rc.Rigid)
        return sum(layer.uniform_compliance for layer in self.layers) if is_rigid else math.inf

    def respond(self, q: Array) -> tuple[Array, Array]:
        """Return q u / p of the coated body, and the same less that of a half-space of the topmost layer, 1/Pa."""
        return respond(self.layers, self.substrate, q)

    def top_compliance(self) -> float:
        """Return (1 - nu^2) / E of the topmost layer, 1/Pa."""
        return self.layers[0].compliance

    def other_compliance(self, compliance: float) -> float:
        """Return (1 - nu^2) / E of the body without layers, 1/Pa."""
        is_rigid = isinstance(self.substrate, rc.Rigid)
        name = f"The topmost layer {self.layers[0]!r}" if is_rigid else f"The substrate {self.substrate!r}"
        return compliance_of_other(name, self.own_material.compliance, compliance)

    def spectrum(self, qx: Array, qy: Array, spacing: tuple[float, float], compliance: float) -> Array:
        """Return the response at the cell centres to waves of cell pressures, shape (m, n), m/Pa."""
        if not isinstance(self.substrate, rc.Rigid):
            return super().spectrum(qx, qy, spacing, compliance)
        # Long waves of a half-space and of the rest cancel on a rigid base: their sum is known better.
        top = _HalfSpace(self.surface_compliance(compliance))
        aliased = self.find_aliased(spacing, top.compliance)
        return cell_waves(_BothBodies(self, compliance), qx, qy, spacing, (top, *aliased))

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
        return LayeredShear(self.layers, self._require_substrate(), axis, pair)

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
        substrate = self._require_substrate()
        own = -respond(self.layers, substrate, wavenumber, (0, 1))[0]
        change = own - (1.0 - 2.0 * substrate.poisson) * (1.0 + substrate.poisson) / substrate.young
        change += 2.0 * pair.beta * compliance
        return np.asarray(change / (wavenumber * self.response(wavenumber, compliance)))

    def _require_substrate(self) -> rc.Elastic:
        """Return the half-space under the layers, or raise `InputError` on a rigid base."""
        if isinstance(self.substrate, rc.Rigid):
            raise rc.InputError("The response to shear is known for layers on a half-space, not on a rigid base.")
        return self.substrate

    @property
    def interfaces(self) -> Array:
        """Depths of the interfaces between bodies that deform, shape (n,), m, ascending."""
        depths = np.cumsum([layer.thickness for layer in self.layers])
        return depths[:-1] if isinstance(self.substrate, rc.Rigid) else depths

    @property
    def yield_stresses(self) -> tuple[float | None, ...]:
        """Yield stress of each layer, Pa, from the surface downwards; None where it states none."""
        return tuple(layer.yield_stress for layer in self.layers)

    @property
    def base_depth(self) -> float:
        """Depth of the rigid base, m; infinite on a half-space."""
        return self.depth if isinstance(self.substrate, rc.Rigid) else math.inf

    def describes(self, material: rc.Material) -> bool:
        """Return whether the layers lie on a body of this material."""
        return is_made_of(material, self.own_material)

    def poisson_at(self, depth: float) -> float:
        """Return Poisson's ratio at a depth, m; at an interface the one above."""
        bodies = [*self.layers, self.own_material]
        return bodies[self._number_at(depth)].poisson

    def stress_coefficients(
        self, load: str, shape: tuple[int, int], spacing: tuple[float, float], depth: float
    ) -> Array:
        """Return the stress at offsets from a cell with unit load: Love's or Cerruti's, and what layers add.

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
        half_space = HalfSpaceStress(self.poisson_at(depth)).stress_coefficients(load, shape, spacing, depth)
        return half_space + integrate_stress(self._find_waves(depth), load, shape, spacing, self._reach(depth))

    def stress_spectrum(self, load: str, qx: Array, qy: Array, spacing: tuple[float, float], depth: float) -> Array:
        """Return the stress at cell centres by waves of loads on cells, shape (6, m, n).

        Raises
        ------
        roughcontact.InputError
            If the layers are much thinner than a cell.
        """
        if load == "y":
            return _exchange_axes(self.stress_spectrum("x", qy.T, qx.T, spacing[::-1], depth))
        half_space = HalfSpaceStress(self.poisson_at(depth)).stress_spectrum(load, qx, qy, spacing, depth)
        return half_space + sum_waves(self._find_waves(depth), load, qx, qy, spacing, self._reach(depth))

    def _find_waves(self, depth: float) -> FindWaves:
        number = self._number_at(depth)
        return lambda load, q: find_excess(self.layers, self.substrate, load, q, depth, number)

    def _reach(self, depth: float) -> float:
        return max(depth, 2.0 * self.layers[0].thickness - depth)

    def _number_at(self, depth: float) -> int:
        # A depth at an interface lies above it, also after rounding.
        return int(np.searchsorted(self.interfaces, (1.0 - 1e-12) * depth))


@attrs.frozen
class _BothBodies:
    """The response of both bodies to waves."""

    kernel: LayeredKernel
    compliance: float

    def wave_rest(self, qx: Array, qy: Array) -> Array:
        """Return the response to wave vectors, m/Pa."""
        return self.kernel.response(np.hypot(qx, qy), self.compliance)


@attrs.frozen
class _HalfSpace:
    """The response of half-spaces to waves."""

    compliance: float

    def wave_rest(self, qx: Array, qy: Array) -> Array:
        """Return the response to wave vectors, m/Pa."""
        return np.asarray(2.0 * self.compliance / np.hypot(qx, qy))


def _exchange_axes(stress: Array) -> Array:
    """Return the components xx, yy, zz, yz, xz, xy after an exchange of the axes x and y, shape (6, m, n)."""
    return np.ascontiguousarray(stress[[1, 0, 2, 4, 3, 5]].transpose(0, 2, 1))
