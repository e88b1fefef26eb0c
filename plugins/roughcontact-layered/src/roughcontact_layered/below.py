"""Stress below the surface of a stack of bonded layers, for waves of pressure and of traction."""

from __future__ import annotations

import math
from functools import cached_property
from typing import TypeAlias

import attrs
import numpy as np
import roughcontact as rc

from roughcontact_layered.stack import (
    Array,
    Layer,
    Substrate,
    below_layers,
    cross,
    half_space,
    inverse,
    product,
    wave_generator,
)

Body: TypeAlias = Layer | rc.Elastic

# Waves at a time: their 2 x 2 matrices, 0.5 MiB each, stay in the cache.
_BLOCK = 1 << 14
# Wave number times distance from which a wave has decayed: exp(-45) = 3e-20, times the moduli of stiff layers.
_DECAYED = 45.0


def find_excess(layers: tuple[Layer, ...], substrate: Substrate, load: str, q: Array, depth: float, k: int) -> Array:
    """Return the stress by waves along x at a depth, less that of a half-space with the same Poisson's ratio.

    Parameters
    ----------
    layers, substrate
        The stack, from the top downwards.
    load
        ``"z"``, a pressure, or ``"x"`` or ``"y"``, a traction along this axis.
    q
        Wave numbers, shape (n,), rad/m, at least zero.
    depth
        Depth below the surface, m.
    k
        Number of the layer in which it lies; the number of layers for the substrate. A rigid base has no stress.

    Returns
    -------
    Array
        The components xx, yy, zz, yz, xz, xy by unit amplitude of the load, shape (6, n); those that are imaginary, xz
        by a pressure, xx, yy, zz by a traction along x and xy by one along y, lack the factor i.
    """
    result = np.zeros((6, q.size))
    reach = max(depth, 2.0 * layers[0].thickness - depth)
    kept = np.nonzero(q * reach < _DECAYED)[0]
    find = _find_across if load == "y" else _find_along
    for start in range(0, kept.size, _BLOCK):
        block = kept[start : start + _BLOCK]
        result[:, block] = find(layers, substrate, load, q[block], depth, k)
    return result


def _find_along(layers: tuple[Layer, ...], substrate: Substrate, load: str, q: Array, depth: float, k: int) -> Array:
    r"""Return the components by a pressure, or by a traction along the wave.

    Of the traction t at the top of a layer of thickness h, x = q h, the part :math:`t_a` belongs to waves that decay
    downwards; at its lower side :math:`t_b` belongs to waves that decay upwards. With the compliances H and V of both,
    C of what lies below, and R of `stack.respond`,

    .. math:: t_a = (1 + R)^{-1}\,t, \quad t_b = (C - V)^{-1} (H - C)\, e^{-x} P_H\, t_a

    so that no exponential grows.
    """
    scale = layers[0].young
    bodies = _list_bodies(layers, substrate)
    media = [_Medium(body.young / scale, body.poisson) for body in bodies]
    compliances = _list_compliances(layers, below_layers(substrate, scale), scale, q)
    surface = np.zeros((2, q.size))
    surface[1 if load == "z" else 0] = -1.0
    traction = surface
    top = 0.0
    for layer, medium, below in zip(layers[:k], media, compliances, strict=False):
        down, up = medium.split(below, q * layer.thickness, traction)
        traction = medium.decay(q * layer.thickness, down)[2:] + up
        top += layer.thickness
    medium = media[k]
    if k == len(layers):
        state = medium.decay(q * max(depth - top, 0.0), traction)
    else:
        thickness = layers[k].thickness
        inside = min(max(depth - top, 0.0), thickness)
        down, up = medium.split(compliances[k], q * thickness, traction)
        state = medium.decay(q * inside, down) + medium.grow(q * (thickness - inside), up)
    state -= medium.decay(q * depth, surface)
    along, shear, normal = medium.find_stress(state)
    poisson = bodies[k].poisson
    none = np.zeros(q.size)
    # Where the pressure is a cosine, the shear is a sine; where the traction is a sine, the normal stress is a cosine.
    return np.array([along, poisson * (along + normal), normal, none, -shear if load == "z" else shear, none])


def _list_bodies(layers: tuple[Layer, ...], substrate: Substrate) -> tuple[Body, ...]:
    """Return the bodies that deform, from the top downwards."""
    return layers if isinstance(substrate, rc.Rigid) else (*layers, substrate)


def _list_compliances(layers: tuple[Layer, ...], below: Array, scale: float, q: Array) -> list[Array]:
    """Return the compliance matrices of what lies below each layer, (2, 2, n) each; `below` is that under all."""
    matrix = below[:, :, np.newaxis] * np.ones(q.size)
    compliances = [matrix]
    for layer in layers[:0:-1]:
        matrix, _ = cross(layer, scale, half_space(layer.young / scale, layer.poisson), matrix, q * layer.thickness)
        compliances.append(matrix)
    return compliances[::-1]


@attrs.frozen(eq=False)
class _Medium:
    """Waves in a body, in terms of tractions; states are (u_x q, u_z q, s_xz, s_zz), shape (4, n).

    Attributes
    ----------
    young, poisson
        Its constants; Young's modulus in the unit of the displacements.
    """

    young: float
    poisson: float

    @cached_property
    def own(self) -> Array:
        """Compliance matrix of waves that decay downwards."""
        return half_space(self.young, self.poisson)

    @cached_property
    def mirror(self) -> Array:
        """Compliance matrix of waves that decay upwards."""
        return np.asarray(self.own * np.array([[-1.0, 1.0], [1.0, -1.0]]))

    @cached_property
    def slopes(self) -> tuple[Array, Array]:
        """By which the tractions of both waves change beside their exponentials, over q times the distance."""
        lower = wave_generator(self.young, self.poisson)[2:]
        one = np.eye(2)
        return lower[:, :2] @ self.own + lower[:, 2:] + one, one - lower[:, :2] @ self.mirror - lower[:, 2:]

    def decay(self, x: Array, traction: Array) -> Array:
        """Return the state by waves that decay downwards, at q times the distance x below a traction, (2, n)."""
        return self._carry(self.own, self.slopes[0], x, traction)

    def grow(self, x: Array, traction: Array) -> Array:
        """Return the state by waves that decay upwards, at q times the distance x above a traction."""
        return self._carry(self.mirror, self.slopes[1], x, traction)

    @staticmethod
    def _carry(compliance: Array, slope: Array, x: Array, traction: Array) -> Array:
        carried = np.exp(-x) * (traction + x * (slope @ traction))
        return np.concatenate((compliance @ carried, carried))

    def split(self, below: Array, x: Array, traction: Array) -> tuple[Array, Array]:
        """Return the tractions of both waves in a layer, of the first at its top and of the second at its bottom.

        Parameters
        ----------
        below
            Compliance matrix of what lies below, shape (2, 2, n).
        x
            Wave number times thickness, shape (n,).
        traction
            Traction at the top, shape (2, n).
        """
        one = np.eye(2)[:, :, np.newaxis]
        down, up = (one + slope[:, :, np.newaxis] * x for slope in self.slopes)
        own, mirror = (matrix[:, :, np.newaxis] for matrix in (self.own, self.mirror))
        decay = np.exp(-x)
        reflected = product(product(inverse(below - mirror), own - below), down) * decay
        decaying = _multiply(inverse(one + product(up, reflected) * decay), traction)
        return decaying, _multiply(reflected, decaying)

    def find_stress(self, state: Array) -> tuple[Array, Array, Array]:
        """Return the stress along the wave, the shear and the normal stress of a state."""
        lateral = self.poisson / (1.0 - self.poisson)
        along = self.young / (1.0 - self.poisson**2) * state[0] + lateral * state[3]
        return along, state[2], state[3]


def _multiply(matrix: Array, vector: Array) -> Array:
    return np.array([row[0] * vector[0] + row[1] * vector[1] for row in matrix])


def _find_across(layers: tuple[Layer, ...], substrate: Substrate, load: str, q: Array, depth: float, k: int) -> Array:
    r"""Return the components by a traction across the wave.

    With shear moduli G and t the displacement over the traction at the bottom of a layer of thickness h, times -G q,
    at the distance s above it

    .. math:: \sigma_{yz} = c\,(\cosh qs + t \sinh qs), \quad \sigma_{xy} = -c\,(\sinh qs + t \cosh qs).
    """
    moduli = [body.young / (2.0 * (1.0 + body.poisson)) for body in _list_bodies(layers, substrate)]
    if isinstance(substrate, rc.Rigid):
        moduli.append(math.inf)
    # Displacement over traction below each layer, times -q and the shear modulus below.
    ratios = [np.ones(q.size)]
    for n in range(len(layers) - 1, 0, -1):
        t = ratios[0] * (moduli[n] / moduli[n + 1])
        rise = np.tanh(q * layers[n].thickness)
        ratios.insert(0, (t + rise) / (1.0 + t * rise))
    traction = np.full(q.size, -1.0)
    top = 0.0
    for n, layer in enumerate(layers[:k]):
        x = q * layer.thickness
        traction = traction * 2.0 * np.exp(-x) / _add_waves(ratios[n] * (moduli[n] / moduli[n + 1]), x)[0]
        top += layer.thickness
    if k == len(layers):
        shear = traction * np.exp(-q * max(depth - top, 0.0))
        across = -shear
    else:
        thickness = layers[k].thickness
        inside = min(max(depth - top, 0.0), thickness)
        t = ratios[k] * (moduli[k] / moduli[k + 1])
        whole = _add_waves(t, q * thickness)[0]
        sums = _add_waves(t, q * (thickness - inside))
        shear, across = (
            sign * traction * np.exp(-q * inside) * one / whole for sign, one in zip((1.0, -1.0), sums, strict=True)
        )
    alone = np.exp(-q * depth)
    none = np.zeros(q.size)
    return np.array([none, none, none, shear + alone, none, across - alone])


def _add_waves(t: Array, x: Array) -> tuple[Array, Array]:
    """Return 2 exp(-x) (cosh x + t sinh x) and 2 exp(-x) (sinh x + t cosh x)."""
    decay = np.exp(-2.0 * x)
    return (1.0 + decay) + t * (1.0 - decay), (1.0 - decay) + t * (1.0 + decay)
