"""A kernel of layers on a half-space, of which the response to waves is known: on cells, in real and Fourier space."""

from __future__ import annotations

import abc

import numpy as np
import roughcontact as rc

from roughcontact_layered.aliases import cell_waves
from roughcontact_layered.cells import cell_integrals
from roughcontact_layered.octaves import tabulate_rest
from roughcontact_layered.radial import tabulate
from roughcontact_layered.stack import Array, Layer


class StackedKernel(rc.InfluenceKernel):
    """Layers on one of two half-spaces, under cells of constant load.

    The response is that of a half-space like the topmost layer, singular where the load is, plus a smooth rest. The
    compliance of both half-spaces under the layers comes from the problem.

    Attributes
    ----------
    layers
        From the surface downwards.
    """

    layers: tuple[Layer, ...]

    @abc.abstractmethod
    def respond(self, q: Array) -> tuple[Array, Array]:
        """Return q times the response of the body with the layers, and its rest beside that of its topmost layer.

        Parameters
        ----------
        q
            Wave numbers, shape (n,), rad/m, above zero.
        """

    @abc.abstractmethod
    def top_compliance(self) -> float:
        """Return the compliance of a half-space like the topmost layer."""

    @abc.abstractmethod
    def other_compliance(self, compliance: float) -> float:
        """Return the compliance of both bodies less that of the substrate, at least zero, or raise `InputError`."""

    @property
    def depth(self) -> float:
        """The thickness of all layers, m."""
        return sum(layer.thickness for layer in self.layers)

    def response(self, q: Array, compliance: float) -> Array:
        """Return the amplitude of the response to a wave of amplitude one.

        Parameters
        ----------
        q
            Wave numbers, any shape, rad/m, above zero.
        compliance
            That of the half-spaces under the layers: 1/E* for displacement by pressure, 1/Pa.

        Returns
        -------
        Array
            Amplitudes, of the shape of `q`: m/Pa for displacement by pressure.

        Raises
        ------
        roughcontact.InputError
            If the substrate alone is more compliant than both bodies together.
        """
        q = np.asarray(q, dtype=np.float64)
        own, _ = self.respond(q.ravel())
        return np.asarray((own.reshape(q.shape) + 2.0 * self.other_compliance(compliance)) / q)

    def effective_modulus(self, wavenumber: Array, compliance: float) -> Array:
        """Return 2 / (q u(q)), the inverse compliance at each wave number, shape (n,): the contact modulus, Pa."""
        return np.asarray(2.0 / (wavenumber * self.response(wavenumber, compliance)))

    def coefficients(self, shape: tuple[int, int], spacing: tuple[float, float], compliance: float) -> Array:
        """Return the influence coefficients, shape (nx, ny), m/Pa.

        Love's, for half-spaces of the topmost layer and of the other body, plus a smooth rest.
        """
        largest = float(np.hypot(shape[0] * spacing[0], shape[1] * spacing[1]))
        table = tabulate(self, 0.4 * min(spacing), largest)
        singular = rc.Love().coefficients(shape, spacing, self.surface_compliance(compliance))
        return np.asarray(singular + cell_integrals(table, shape, spacing))

    def spectrum(self, qx: Array, qy: Array, spacing: tuple[float, float], compliance: float) -> Array:
        """Return the response at the cell centres to waves of cell loads, shape (m, n), m/Pa.

        Love's, for half-spaces of the topmost layer and of the other body, plus the rest with its aliases.
        """
        surface = self.surface_compliance(compliance)
        love = rc.Love().spectrum(qx, qy, spacing, surface)
        return np.asarray(love + cell_waves(self, qx, qy, spacing, self.find_aliased(spacing, surface)))

    def find_aliased(self, spacing: tuple[float, float], surface: float) -> tuple[StackedKernel, ...]:
        """Return this kernel if waves shorter than two cells count in its rest, beside a compliance; else nothing."""
        nearest = np.array([np.pi / max(spacing)])
        is_aliased = abs((self.rest(nearest) * nearest).item()) > np.finfo(np.float64).eps * surface
        return (self,) if is_aliased else ()

    def wave_rest(self, qx: Array, qy: Array) -> Array:
        """Return `rest` of wave vectors, m/Pa."""
        return self.rest(np.hypot(qx, qy))

    def rest(self, q: Array) -> Array:
        """Return the response less that of a half-space of the topmost layer, shape of `q` (rad/m, above 0), m/Pa."""
        return np.asarray(tabulate_rest(self)(q) / q)

    def find_rest(self, q: Array) -> Array:
        """Return q times `rest`, by the layers themselves, shape (n,); see `SmoothResponse`."""
        return self.respond(q)[1]

    def surface_compliance(self, compliance: float) -> float:
        """Return the compliance of half-spaces of the topmost layer and of the other body."""
        return self.top_compliance() + self.other_compliance(compliance)
