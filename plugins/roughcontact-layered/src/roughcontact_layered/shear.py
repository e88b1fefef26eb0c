"""Displacement along an axis by shear along it, of layers on a half-space."""

from __future__ import annotations

import attrs
import numpy as np
import roughcontact as rc
from roughcontact.typing import PairConstants

from roughcontact_layered.aliases import cell_waves
from roughcontact_layered.conduction import conduct
from roughcontact_layered.harmonics import integrate_cells
from roughcontact_layered.octaves import tabulate_rest
from roughcontact_layered.radial import tabulate
from roughcontact_layered.stack import Array, Layer, respond


@attrs.frozen
class _Harmonic:
    """What layers add to the response to shear: its mean over the directions, or half of what it changes with them.

    Attributes
    ----------
    layers, substrate
        The stack.
    order
        0 for the mean, 2 for the factor of the cosine of twice the angle between wave and shear.
    """

    layers: tuple[Layer, ...]
    substrate: rc.Elastic
    order: int

    @property
    def depth(self) -> float:
        """The thickness of all layers, m."""
        return sum(layer.thickness for layer in self.layers)

    def rest(self, q: Array) -> Array:
        """Return it for wave numbers, less that of a half-space of the topmost layer, shape of `q`, m/Pa."""
        return np.asarray(tabulate_rest(self)(q) / q)

    def find_rest(self, q: Array) -> Array:
        """Return q times `rest`, by the layers themselves, shape (n,); see `SmoothResponse`."""
        along = respond(self.layers, self.substrate, q, (0, 0))[1]
        across = respond_across(self.layers, self.substrate, q)[1]
        return np.asarray(0.5 * (along + across if self.order == 0 else along - across))


def respond_across(layers: tuple[Layer, ...], substrate: rc.Elastic, q: Array) -> tuple[Array, Array]:
    """Return q times the displacement by shear across waves, and the same less that of the topmost layer, 1/Pa."""
    moduli = [0.5 * layer.young / (1.0 + layer.poisson) for layer in layers]
    below = 0.5 * substrate.young / (1.0 + substrate.poisson)
    return conduct(moduli, below, [layer.thickness for layer in layers], q)


@attrs.frozen
class LayeredShear(rc.InfluenceKernel):
    r"""Displacement along an axis by shear along it, of layers on one of two half-spaces.

    A wave at the angle :math:`\theta` from the axis displaces by :math:`(a \cos^2\theta + b \sin^2\theta)/|q|`: shear
    along waves like pressure (`roughcontact_layered.stack.respond`), shear across them as flow through a conductor
    (`roughcontact_layered.conduction.conduct`). `LayeredKernel.shear_kernel` makes it.

    Parameters
    ----------
    layers, substrate
        As of `LayeredKernel`.
    axis
        0 for x, 1 for y.
    pair
        The constants of the two half-spaces under the layers.
    """

    layers: tuple[Layer, ...]
    substrate: rc.Elastic
    axis: int
    pair: PairConstants

    def coefficients(self, shape: tuple[int, int], spacing: tuple[float, float], compliance: float) -> Array:
        """Return the influence coefficients, shape (nx, ny), m/Pa: Love's for the topmost layer, and a smooth rest."""
        if self.axis == 1:
            turned = attrs.evolve(self, axis=0)
            return np.ascontiguousarray(turned.coefficients(shape[::-1], spacing[::-1], compliance).T)
        surface, pair = self._find_surface(compliance)
        reach = 2.0 * self.layers[0].thickness
        tables = []
        smallest, largest = 0.002 * min(*spacing, reach), 1.1 * float(np.hypot(*np.multiply(shape, spacing)))
        for order in (0, 2):
            tables.append(tabulate(_Harmonic(self.layers, self.substrate, order), smallest, largest, order))

        def displace(x: Array, y: Array) -> Array:
            square = np.square(x) + np.square(y)
            cosine = (np.square(x) - np.square(y)) / square
            return np.asarray((tables[0].displacement(x, y) + cosine * tables[1].displacement(x, y))[np.newaxis])

        rest = integrate_cells(displace, 1, shape, spacing, reach)[0]
        return np.asarray(rc.Love().shear_coefficients("xx", shape, spacing, surface, pair) + rest)

    def spectrum(self, qx: Array, qy: Array, spacing: tuple[float, float], compliance: float) -> Array:
        """Return the response at the cell centres to waves of cell shears, shape (m, n), m/Pa."""
        surface, pair = self._find_surface(compliance)
        love = rc.Love().shear_spectrum("xy"[self.axis] * 2, qx, qy, spacing, surface, pair)
        nearest = np.array([np.pi / max(spacing)])
        largest = max(abs(_Harmonic(self.layers, self.substrate, order).rest(nearest).item()) for order in (0, 2))
        is_aliased = largest * nearest.item() > np.finfo(np.float64).eps * surface
        return np.asarray(love + cell_waves(self, qx, qy, spacing, (self,) if is_aliased else ()))

    def wave_rest(self, qx: Array, qy: Array) -> Array:
        """Return the response less that of a half-space of the topmost layer, of wave vectors, m/Pa."""
        q = np.hypot(qx, qy)
        mean, change = (_Harmonic(self.layers, self.substrate, order).rest(q) for order in (0, 2))
        cosine = 2.0 * np.square((qx if self.axis == 0 else qy) / q) - 1.0
        return np.asarray(mean + change * cosine)

    def _find_surface(self, compliance: float) -> tuple[float, PairConstants]:
        """Return 1/E* and the constants of half-spaces of the topmost layer and of the other body."""
        top = self.layers[0]
        surface = compliance - self.substrate.compliance + top.compliance
        across = self.pair.gamma * compliance - _add_across(self.substrate) + _add_across(top)
        return surface, PairConstants(gamma=across / surface)


def _add_across(body: Layer | rc.Elastic) -> float:
    """Return by how much a half-space yields more to shear across waves than along them, times E, nu / (2 G), 1/Pa."""
    return body.compliance * body.poisson / (1.0 - body.poisson)
