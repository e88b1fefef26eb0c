"""Waves of pressure on a stack of bonded layers."""

from __future__ import annotations

import math
from typing import TypeAlias

import attrs
import numpy as np
import numpy.typing as npt
import roughcontact as rc
from roughcontact.typing import Part, Quantity, si

Array: TypeAlias = npt.NDArray[np.float64]
Substrate: TypeAlias = rc.Elastic | rc.Rigid

# Layers of q h below this are crossed by the matrix exponential less one, thicker ones by reflection.
_THIN = 1.0
# Terms of the series of (x cosh x - sinh x) / 2 below _THIN: the next one is below 1e-17.
_SERIES = 9
# Waves at a time: their 2 x 2 matrices, 0.5 MiB each, stay in the cache.
_BLOCK = 1 << 14
_CONDUCTIVITY_UNIT = "W/(m K) or S/m"


def _thickness(value: Quantity) -> float:
    return _positive(value, "The thickness of a layer", "m")


def _conductivity(value: Quantity | None) -> float | None:
    return None if value is None else _positive(value, "The conductivity of a layer", _CONDUCTIVITY_UNIT)


def _yield_stress(value: Quantity | None) -> float | None:
    return None if value is None else _positive(value, "The yield stress of a layer", "Pa")


def _positive(value: Quantity, what: str, unit: str) -> float:
    try:
        result = float(value)
    except (TypeError, ValueError):
        result = math.nan
    if isinstance(value, (str, bool)) or not (math.isfinite(result) and result > 0.0):
        raise rc.InputError.about(what, value, f"a finite number, above 0 ({unit})")
    return result


def _young(value: Quantity) -> float:
    return rc.Elastic(value, 0.0).young


def _poisson(value: Quantity) -> float:
    return rc.Elastic(1.0, value).poisson


@attrs.frozen
class Layer(Part):
    """A homogeneous, isotropic, linear elastic layer, bonded to what is below it.

    Parameters
    ----------
    young
        Young's modulus, Pa, above zero.
    poisson
        Poisson's ratio, above -1 and at most 0.5.
    thickness
        Thickness, m, above zero.
    conductivity
        Conductivity, W/(m K) for heat or S/m for current, above zero, which only the contact conductance needs.
    yield_stress
        Yield stress in tension, Pa, above zero, for the first yield in this layer; None: that of the body under it.

    Raises
    ------
    roughcontact.InputError
        If a value is out of these bounds.
    """

    young: float = attrs.field(converter=_young, metadata={"unit": "Pa"})
    poisson: float = attrs.field(converter=_poisson)
    thickness: float = attrs.field(converter=_thickness, metadata={"unit": "m"})
    conductivity: float | None = attrs.field(
        default=None, converter=_conductivity, metadata={"plain_unit": _CONDUCTIVITY_UNIT}
    )
    yield_stress: float | None = attrs.field(default=None, converter=_yield_stress, metadata={"unit": "Pa"})

    def __str__(self) -> str:
        words = f"{si(self.thickness, 'm')} of {si(self.young, 'Pa')}, Poisson's ratio {self.poisson:g}"
        return words if self.yield_stress is None else f"{words}, yield stress {si(self.yield_stress, 'Pa')}"

    @property
    def compliance(self) -> float:
        """Plane-strain compliance (1 - nu^2) / E of a half-space of this material, 1/Pa."""
        return (1.0 - self.poisson**2) / self.young

    @property
    def uniform_compliance(self) -> float:
        r"""Compression by a uniform unit pressure, m/Pa: h (1 + nu) (1 - 2 nu) / (E (1 - nu)), its sides held."""
        lateral = (1.0 + self.poisson) * (1.0 - 2.0 * self.poisson) / (1.0 - self.poisson)
        return self.thickness * lateral / self.young


def respond(
    layers: tuple[Layer, ...], substrate: Substrate, q: Array, component: tuple[int, int] = (1, 1)
) -> tuple[Array, Array]:
    r"""Return q u / p, and the same less that of a half-space of the topmost layer.

    With u and t the amplitudes of displacement and traction (along x, along z), t over q, each
    interface has a compliance matrix, u = C t, which is computed from the substrate upwards. Across a
    layer of thickness h, x = q h, the amplitudes y = (u, t) obey dy/d(qz) = A y with
    (A^2 - 1)^2 = 0. A thin layer is crossed by D = exp(-A x) - 1, without cancellation,

    .. math:: C' = (C + D_{uu} C + D_{ut})\,(1 + D_{tu} C + D_{tt})^{-1}

    and a thick one by the reflection at its lower side, without growing exponentials: with the
    compliances H of waves that decay downwards and V of those that decay upwards

    .. math:: R = e^{-2x} P_V (C - V)^{-1} (H - C) P_H, \quad C' = H + (V - H)\,R\,(1 + R)^{-1}

    Parameters
    ----------
    layers
        From the top downwards.
    substrate
        The half-space under them, or a rigid base.
    q
        Wave numbers, shape (n,), rad/m, above zero.
    component
        Of displacement and traction, 0 along the wave and 1 along the normal.

    Returns
    -------
    tuple[Array, Array]
        Both of shape (n,), 1/Pa. The second falls as exp(-2 q h) with the thickness h of the topmost
        layer, and each is accurate to rounding where the other one is much larger.

    References
    ----------
    O'Sullivan, King, J. Tribol. 110 (1988) 235-240, give the closed form of one layer.
    """
    own = np.empty(q.size)
    rest = np.empty(q.size)
    for start in range(0, q.size, _BLOCK):
        block = slice(start, start + _BLOCK)
        own[block], rest[block] = _respond(layers, substrate, q[block], component)
    return own, rest


def _respond(
    layers: tuple[Layer, ...], substrate: Substrate, q: Array, component: tuple[int, int]
) -> tuple[Array, Array]:
    scale = layers[0].young
    matrix = below_layers(substrate, scale)[:, :, np.newaxis] * np.ones(q.size)
    difference = matrix
    for layer in reversed(layers):
        own = half_space(layer.young / scale, layer.poisson)
        matrix, difference = cross(layer, scale, own, matrix, q * layer.thickness)
    return np.asarray(-matrix[component] / scale), np.asarray(-difference[component] / scale)


def below_layers(substrate: Substrate, scale: float) -> Array:
    """Return the compliance matrix under the layers, for 1/scale: zero on a rigid base, which holds them."""
    if isinstance(substrate, rc.Rigid):
        return np.zeros((2, 2))
    return half_space(substrate.young / scale, substrate.poisson)


def half_space(young: float, poisson: float) -> Array:
    """Return the compliance matrix of waves that decay downwards, for 1/young."""
    along = -2.0 * (1.0 - poisson**2)
    coupling = (1.0 - 2.0 * poisson) * (1.0 + poisson)
    return np.array([[along, coupling], [coupling, along]]) / young


def cross(layer: Layer, scale: float, own: Array, matrix: Array, x: Array) -> tuple[Array, Array]:
    """Return the compliance matrix above a layer, and the same less that of its half-space."""
    generator = wave_generator(layer.young / scale, layer.poisson)
    thin = x < _THIN
    result = np.empty_like(matrix)
    difference = np.empty_like(matrix)
    result[..., thin] = _cross_thin(generator, matrix[..., thin], x[thin])
    difference[..., thin] = result[..., thin] - own[:, :, np.newaxis]
    difference[..., ~thin] = _cross_thick(generator, own, matrix[..., ~thin], x[~thin])
    result[..., ~thin] = difference[..., ~thin] + own[:, :, np.newaxis]
    return result, difference


def wave_generator(young: float, poisson: float) -> Array:
    """Return A of dy/d(qz) = A y for y = (u_x, u_z, s_xz / q, s_zz / q), z downwards."""
    shear = young / (2.0 * (1.0 + poisson))
    lateral = poisson / (1.0 - poisson)
    return np.array(
        [
            [0.0, 1.0, 1.0 / shear, 0.0],
            [-lateral, 0.0, 0.0, (1.0 - 2.0 * poisson) / (2.0 * shear * (1.0 - poisson))],
            [2.0 * shear / (1.0 - poisson), 0.0, 0.0, lateral],
            [0.0, 0.0, -1.0, 0.0],
        ]
    )


def _cross_thin(generator: Array, matrix: Array, x: Array) -> Array:
    half = 0.5 * x
    second = half * np.sinh(x)
    third = _third(x)
    # cosh x - 1 = 2 sinh^2(x/2); going up, the odd powers change their sign.
    factors = (2.0 * np.sinh(half) ** 2 - second, third - np.sinh(x), second, -third)
    square = generator @ generator
    powers = np.array([np.eye(4), generator, square, square @ generator])
    step = np.einsum("kij,kn->ijn", powers, np.array(factors))
    displacement = matrix + product(step[:2, :2], matrix) + step[:2, 2:]
    traction = np.eye(2)[:, :, np.newaxis] + product(step[2:, :2], matrix) + step[2:, 2:]
    return product(displacement, inverse(traction))


def _third(x: Array) -> Array:
    """Return (x cosh x - sinh x) / 2 by its series."""
    orders = range(1, _SERIES + 1)
    terms = [k / math.factorial(2 * k + 1) for k in orders]
    return np.asarray(x**3 * np.polynomial.polynomial.polyval(x * x, terms))


def _cross_thick(generator: Array, own: Array, matrix: Array, x: Array) -> Array:
    mirror = own * np.array([[-1.0, 1.0], [1.0, -1.0]])
    one = np.eye(2)
    down = generator[2:, :2] @ own + generator[2:, 2:] + one
    up = one - generator[2:, :2] @ mirror - generator[2:, 2:]
    one3 = one[:, :, np.newaxis]
    own3 = own[:, :, np.newaxis]
    mirror3 = mirror[:, :, np.newaxis]
    reflected = product(inverse(matrix - mirror3), own3 - matrix)
    reflected = product(one3 + up[:, :, np.newaxis] * x, product(reflected, one3 + down[:, :, np.newaxis] * x))
    reflected = reflected * np.exp(-2.0 * x)
    return product(mirror3 - own3, product(reflected, inverse(one3 + reflected)))


def product(a: Array, b: Array) -> Array:
    """Multiply matrices of shape (2, 2, n)."""
    return np.array([[a[i, 0] * b[0, j] + a[i, 1] * b[1, j] for j in (0, 1)] for i in (0, 1)])


def inverse(a: Array) -> Array:
    """Invert matrices of shape (2, 2, n)."""
    adjugate = np.array([[a[1, 1], -a[0, 1]], [-a[1, 0], a[0, 0]]])
    return np.asarray(adjugate / (a[0, 0] * a[1, 1] - a[0, 1] * a[1, 0]))
