"""What kernels of bodies of layers may know beside the displacement by pressure."""

from __future__ import annotations

from typing import Any, Protocol, runtime_checkable

from roughcontact._base.arrays import Array
from roughcontact._parts.kernels.base import InfluenceKernel
from roughcontact._parts.kernels.half_space import Love
from roughcontact._parts.materials import Material, PairConstants


def has_layers(kernel: Any, body: str, material: Material) -> bool:
    """Return whether the layers of a kernel may lie on the ``"body"`` or the ``"counterbody"``, of this material."""
    part = kernel.part_of(body)
    return not isinstance(part, Love) and (kernel if part is None else part).describes(material)


@runtime_checkable
class SupportsConduction(Protocol):
    """A kernel of a body of layers that knows how they conduct heat or current: an optional ability."""

    def describes(self, material: Material) -> bool:
        """Return whether a body of this material is the one with the layers."""

    def conduction_kernel(self, conductivity: float) -> InfluenceKernel:
        """Return the kernel of temperature, or potential, by the flow through the surface.

        Parameters
        ----------
        conductivity
            Of the half-space under the layers, W/(m K) for heat or S/m for current.

        Returns
        -------
        InfluenceKernel
            A kernel whose `compliance` is (1/k1 + 1/k2) / 2 of the half-spaces under the layers, and whose values are
            temperatures by flows, K/(W/m2).

        Raises
        ------
        InputError
            If the conductivity of a layer is not known.
        """


@runtime_checkable
class SupportsTangential(Protocol):
    """A kernel of a body of layers that knows the displacement along an axis by shear along it: an optional ability.

    The tangential stiffness needs it. In both methods `pair` has the constants of the half-spaces under the layers.
    """

    def describes(self, material: Material) -> bool:
        """Return whether a body of this material is the one with the layers."""

    def shear_kernel(self, axis: int, pair: PairConstants) -> InfluenceKernel:
        """Return the kernel of the displacement along x, 0, or y, 1, by shear along it, of the same compliance."""

    def coupling(self, wavenumber: Array, compliance: float, pair: PairConstants) -> Array:
        """Return Dundurs' beta of waves.

        Parameters
        ----------
        wavenumber
            Wave numbers, shape (n,), rad/m, above zero.
        compliance
            1/E* of the half-spaces under the layers, 1/Pa.
        pair
            Their constants, with the body with the layers first.
        """
