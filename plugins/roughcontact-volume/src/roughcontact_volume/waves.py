r"""Waves of eigenstrain in layers of a half-space: one sweep up, a reflection at the surface, one sweep down.

Along a wave vector with the direction n and t across it, with :math:`u_n = i v`, :math:`u_t = i y`, :math:`u_z = w` and
shears :math:`e_{nz} = i g`, :math:`e_{tz} = i h`, the plane (n, z) and the direction t separate and everything is real.
In a layer of constant eigenstrain a constant is a solution of the equations of equilibrium,

.. math:: q v = -e_{nn} - \frac{\nu}{1-\nu} (e_{zz} + e_{tt}), \quad q w = 2 g, \quad
          \frac{\sigma_{zz}}{2\mu} = -\frac{e_{zz} + \nu e_{tt}}{1-\nu}, \quad
          \frac{\sigma_{tt}}{2\mu} = -\frac{e_{tt} + \nu e_{zz}}{1-\nu}, \quad
          q y = -2 e_{nt}, \quad \frac{\tau_t}{\mu} = -2 h,

and what jumps between two layers is balanced by waves that decay away from their interface,

.. math:: q v = (a + b \zeta) e^{-\zeta}, \quad q w = -(a + b (\zeta + 3 - 4\nu)) e^{-\zeta}, \quad
          q y = y_0 e^{-\zeta}, \quad \zeta = q z,

so that no exponential grows, layers may have any thickness, and the work is linear in their number.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property

import attrs
import numpy as np
from roughcontact.typing import Array, RealArray


@attrs.frozen(eq=False)
class WaveVectors:
    """The wave vectors of a tile, and the thicknesses of the layers they run through.

    Attributes
    ----------
    qx, qy
        Wave numbers, shapes (m,) and (n,), rad/m.
    thicknesses
        Thicknesses of the layers from the surface down, shape (nz,), m.
    dtype
        Precision of what is computed of them.
    """

    qx: Array
    qy: Array
    thicknesses: Array
    dtype: type[np.floating] = np.float64

    @cached_property
    def q(self) -> RealArray:
        """Wave numbers, shape (m, n), rad/m."""
        return np.asarray(np.hypot(self.qx[:, np.newaxis], self.qy))

    @cached_property
    def direction(self) -> tuple[RealArray, RealArray]:
        """Cosines of the directions along x and y; (1, 0) where the wave number is zero."""
        q = np.where(self.q == 0.0, 1.0, self.q)
        x = self.qx[:, np.newaxis] / q
        x[self.q == 0.0] = 1.0
        return x.astype(self.dtype), (self.qy / q).astype(self.dtype)

    @cached_property
    def double_angle(self) -> tuple[RealArray, RealArray]:
        """Cosine and sine of twice the angle between the waves and the x axis."""
        x, y = self.direction
        return x * x - y * y, 2.0 * x * y

    @cached_property
    def _decays(self) -> dict[float, tuple[RealArray, ...]]:
        return {}

    def decay(self, layer: int) -> tuple[RealArray, RealArray, RealArray, RealArray]:
        r"""Return :math:`\delta = q t`, :math:`e^{-\delta}` and the means of :math:`e^{-\zeta}` and of its moment."""
        thickness = float(self.thicknesses[layer])
        if thickness not in self._decays:
            delta = self.q * thickness
            self._decays[thickness] = tuple(one.astype(self.dtype) for one in (delta, *find_means(delta)))
        delta, decay, mean, moment = self._decays[thickness]
        return delta, decay, mean, moment


def find_means(delta: Array) -> tuple[Array, Array, Array]:
    r"""Return :math:`e^{-\delta}` and the means of :math:`e^{-\zeta}` and :math:`\zeta e^{-\zeta}` up to delta."""
    decay = np.exp(-delta)
    mean = np.divide(-np.expm1(-delta), delta, out=np.ones_like(delta), where=delta != 0.0)
    return decay, mean, mean - decay


def sweep(tile: RealArray, waves: WaveVectors, poisson: float) -> None:
    """Replace the eigenstrain of waves by the residual stress over twice the shear modulus, mean over each layer.

    Parameters
    ----------
    tile
        The waves, shape (6, nz, 2, m, n): components xx, yy, zz, yz, xz, xy, the shears with z divided by the imaginary
        unit; real and imaginary parts.
    waves
        The m x n wave vectors. The stress by the mean strain is that of a body with sides held.
    poisson
        Poisson's ratio.
    """
    mean = waves.q == 0.0
    mean_stress = _find_mean_stress(tile[..., mean], poisson)
    upward = _sweep_up(tile, waves, poisson)
    _sweep_down(tile, upward, waves, poisson)
    tile[..., mean] = mean_stress


def _find_mean_stress(strain: RealArray, poisson: float) -> RealArray:
    """Return the stress by a mean strain with sides held, over twice the shear modulus."""
    stress = np.zeros_like(strain)
    xx, yy = strain[:2]
    stress[0] = (xx + poisson * yy) / (poisson - 1.0)
    stress[1] = (yy + poisson * xx) / (poisson - 1.0)
    stress[5] = -strain[5]
    return stress


def _find_constants(strain: RealArray, waves: WaveVectors, poisson: float) -> tuple[RealArray, ...]:
    """Return the solution in a layer of constant eigenstrain as amplitudes of the waves that jumps of it emit.

    These are (q v / 2, q w / 4(1 - nu), (s_zz - q v) / 4(1 - nu), s_tt, q y / 2, tau_t / 2 mu).
    """
    xx, yy, zz, yz, xz, xy = strain
    x, y = waves.direction
    cosine, sine = waves.double_angle
    middle = 0.5 * (xx + yy)
    half = 0.5 * (xx - yy)
    turned = half * cosine + xy * sine
    across = middle - turned
    factor = -1.0 / (1.0 - poisson)
    along = -0.5 * (middle + turned) + (0.5 * poisson * factor) * (zz + across)
    normal = factor * (zz + poisson * across)
    return (
        along,
        (-0.5 * factor) * (x * xz + y * yz),
        (-0.25 * factor) * (normal - 2.0 * along),
        factor * (across + poisson * zz),
        half * sine - xy * cosine,
        y * xz - x * yz,
    )


def _emit_up(constants: RealArray, poisson: float) -> tuple[RealArray, ...]:
    """Return the amplitudes of the waves upwards from an interface for a jump of the constants."""
    along, lift, push, _, twist, shear = constants
    return along - (1.0 - 2.0 * poisson) * lift, lift + push, shear + twist


def _emit_down(constants: RealArray, poisson: float) -> tuple[RealArray, ...]:
    along, lift, push, _, twist, shear = constants
    return -along - (1.0 - 2.0 * poisson) * lift, lift - push, shear - twist


def _carry(amplitudes: Sequence[RealArray], delta: RealArray, decay: RealArray) -> Iterator[RealArray]:
    """Yield the amplitudes of waves after a layer."""
    first, second, across = amplitudes
    yield decay * (first + delta * second)
    yield decay * second
    yield decay * across


def _sweep_up(tile: RealArray, waves: WaveVectors, poisson: float) -> RealArray:
    """Replace the strains by constants; return the waves upwards at the bottom of each layer, and at the surface.

    The shape is (nz + 1, 3, 2, m, n); the first are those at the surface.
    """
    layers = tile.shape[1]
    upward = np.empty((layers + 1, 3, *tile.shape[2:]), dtype=tile.dtype)
    # What the waves at the top of the layer below are, and what the constants there emit.
    arriving: list[RealArray] = []
    for layer in range(layers - 1, -1, -1):
        for slot, constant in zip(tile[:, layer], _find_constants(tile[:, layer], waves, poisson), strict=True):
            slot[...] = constant
        emitted = _emit_up(tile[:, layer], poisson)
        below = upward[layer + 1]
        for one, own in zip(below, emitted, strict=True):
            np.negative(own, out=one)
        for one, other in zip(below, arriving, strict=False):
            one += other
        delta, decay, *_ = waves.decay(layer)
        arriving = list(_carry(below, delta, decay))
        if layer == 0:
            upward[0] = arriving
        for one, own in zip(arriving, emitted, strict=True):
            one += own
    return upward


def _reflect(surface: RealArray, constants: RealArray, poisson: float) -> tuple[RealArray, ...]:
    """Return the waves downwards from a surface without traction."""
    first, second, across = surface
    along, _, push, _, _, shear = constants
    tangential = first + (1.0 - 2.0 * poisson) * second
    normal = 4.0 * (1.0 - poisson) * push + 2.0 * along + first + 2.0 * (1.0 - poisson) * second
    bent = -normal - tangential
    return tangential - (1.0 - 2.0 * poisson) * bent, bent, across + 2.0 * shear


def _sweep_down(tile: RealArray, upward: RealArray, waves: WaveVectors, poisson: float) -> None:
    """Replace the constants by the stress, mean over each layer."""
    downward = list(_reflect(upward[0], tile[:, 0], poisson))
    layers = tile.shape[1]
    for layer in range(layers):
        delta, decay, mean, moment = waves.decay(layer)
        emitted = _emit_down(tile[:, layer], poisson)
        stress = _find_stress(tile[:, layer], downward, upward[layer + 1], mean, moment, waves, poisson)
        for slot, one in zip(tile[:, layer], stress, strict=True):
            slot[...] = one
        if layer + 1 < layers:
            downward = list(_carry(downward, delta, decay))
            below = _emit_down(tile[:, layer + 1], poisson)
            for one, new, old in zip(downward, below, emitted, strict=True):
                one += new
                one -= old


def _find_stress(
    constants: RealArray,
    downward: list[RealArray],
    upward: RealArray,
    mean: RealArray,
    moment: RealArray,
    waves: WaveVectors,
    poisson: float,
) -> tuple[RealArray, ...]:
    """Return the mean stress in a layer, over twice the shear modulus, in the order of the components."""
    along, _, push, across, _, shear = constants
    a, b, down = downward
    c, d, up = upward
    even = (a + c) * mean
    bent = b + d
    in_plane = bent * ((2.0 * poisson) * mean - moment) - even
    normal = 4.0 * (1.0 - poisson) * push + 2.0 * along + even + bent * (moment + (2.0 - 2.0 * poisson) * mean)
    lateral = across + (2.0 * poisson) * bent * mean
    tangential = (c - a) * mean + (d - b) * (moment + (1.0 - 2.0 * poisson) * mean)
    twist = -0.5 * (down + up) * mean
    turning = shear + 0.5 * (up - down) * mean
    x, y = waves.direction
    cosine, sine = waves.double_angle
    middle = 0.5 * (in_plane + lateral)
    half = 0.5 * (in_plane - lateral)
    turned = half * cosine - twist * sine
    return (
        middle + turned,
        middle - turned,
        normal,
        y * tangential + x * turning,
        x * tangential - y * turning,
        half * sine + twist * cosine,
    )
