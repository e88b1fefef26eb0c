"""Heat or current in layers on a half-space, from cells of constant flow."""

from __future__ import annotations

import attrs
import numpy as np
import roughcontact as rc

from roughcontact_layered.stack import Array, Layer
from roughcontact_layered.stacked import StackedKernel


@attrs.frozen
class LayeredConduction(StackedKernel):
    r"""Temperature, or potential, by the flow into layers on one of two half-spaces.

    .. math:: \hat T(q) = \left[\frac{1/k_1 + 1/k_2}{|q|} + \hat T_\mathrm{layers}(q) - \frac{1}{k_s |q|}\right]
              \hat f(q)

    The compliance of a half-space of conductivity k is here 1/(2 k), so that :math:`2 c / |q|` is its response, as that
    of displacement by pressure. `LayeredKernel.conduction_kernel` makes it.

    Parameters
    ----------
    layers
        From the surface downwards, each with its conductivity, W/(m K) or S/m.
    conductivity
        Of the half-space under them, W/(m K) or S/m.
    """

    layers: tuple[Layer, ...]
    conductivity: float

    def respond(self, q: Array) -> tuple[Array, Array]:
        """Return q T / f, and the same less that of a half-space of the topmost layer; see `conduct`."""
        values = [conductivity_of(layer) for layer in self.layers]
        return conduct(values, self.conductivity, [layer.thickness for layer in self.layers], q)

    def top_compliance(self) -> float:
        """Return 1/(2 k) of the topmost layer, m K/W."""
        return 0.5 / conductivity_of(self.layers[0])

    def other_compliance(self, compliance: float) -> float:
        """Return 1/(2 k) of the body without layers, m K/W."""
        return max(compliance - 0.5 / self.conductivity, 0.0)


def conduct(
    conductivities: list[float], conductivity: float, thicknesses: list[float], q: Array
) -> tuple[Array, Array]:
    r"""Return q T / f, and the same less that of a half-space of the topmost layer.

    With r the resistance :math:`k q T / f` over that of a half-space of the layer, x = q h, and :math:`e = e^{-2x}`, a
    layer on a body with r is

    .. math:: r' = \frac{r (1 + e) + (1 - e)}{(1 + e) + r (1 - e)}, \qquad
              r' - 1 = \frac{2 e\,(r - 1)}{(1 + e) + r (1 - e)}

    in which nothing cancels. Shear across waves obeys the same equations, with shear moduli as conductivities.

    Parameters
    ----------
    conductivities
        Of the layers from the surface downwards, W/(m K) or S/m.
    conductivity
        Of the half-space under them, W/(m K) or S/m.
    thicknesses
        Of the layers, m.
    q
        Wave numbers, shape (n,), rad/m, above zero.

    Returns
    -------
    tuple[Array, Array]
        Both of shape (n,), m K/W. The second falls as exp(-2 q h) with the thickness h of the topmost layer.
    """
    resistivity = np.full(q.size, 1.0 / conductivity)
    rest = np.zeros(q.size)
    for own, thickness in zip(conductivities[::-1], thicknesses[::-1], strict=True):
        ratio = own * resistivity
        decay = np.exp(-2.0 * q * thickness)
        denominator = (1.0 + decay) + ratio * (1.0 - decay)
        # A body of the same conductivity leaves no rest, not even rounding.
        rest = 2.0 * decay * (ratio - 1.0) / denominator / own
        resistivity = (ratio * (1.0 + decay) + (1.0 - decay)) / denominator / own
    return resistivity, rest


def conductivity_of(layer: Layer) -> float:
    """Return the conductivity of a layer, W/(m K) or S/m, or raise `InputError` if it is not known."""
    if layer.conductivity is None:
        raise rc.InputError(
            f"The conductance needs the conductivity of each layer, but {layer!r} has none: Layer(..., conductivity=)."
        )
    return layer.conductivity
