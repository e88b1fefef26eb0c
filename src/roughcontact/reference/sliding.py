"""The stress below a Hertzian contact that slides with friction: of a ball, and of a cylinder."""

from __future__ import annotations

import attrs
import numpy as np

from roughcontact._base.arrays import Array, Waves
from roughcontact._base.checks import number, numbers
from roughcontact.errors import InputError
from roughcontact.errors.door import guarded
from roughcontact.reference.closed_forms import read_length, read_pressure


def _poisson(value: float) -> float:
    return number(value, "Poisson's ratio", above=-1.0, at_most=0.5)


def _friction(value: float) -> float:
    return number(value, "The coefficient of friction")


def _places(*places: Array | float, scale: float) -> list[Array]:
    """Return places over a length, the depth last, of one shape."""
    allowed = "numbers (m) of shapes that broadcast"
    given = [numbers(place, "A place", allowed) for place in places]
    try:
        values = np.broadcast_arrays(*given)
    except ValueError:
        raise InputError.about("The places", [value.shape for value in given], allowed) from None
    if not all(np.isfinite(value).all() for value in values):
        raise InputError.about("A place", "not finite", allowed)
    if (values[-1] < 0.0).any():
        raise InputError.about("A depth", float(values[-1].min()), "at least 0, the surface (m)")
    # A depth of -0.0 would lie on the other side of the cut of the square root.
    return [value / scale + 0.0 for value in values]


@guarded
@attrs.frozen
class SlidingSphere:
    r"""Stress below a sphere that slides: Hertz's pressure p, and the traction q = friction p along x on the body.

    With :math:`Z = z + ia`, :math:`R^2 = x^2 + y^2 + Z^2` and :math:`W = R + Z`, the potential :math:`A` of the
    pressure, :math:`-\partial_z A = p` at the surface, its integrals :math:`C, B` over the depth, and all of their
    derivatives are real and imaginary parts of powers of :math:`W` and of :math:`\ln W`. By the pressure

    .. math:: \sigma_{xx} = 2\nu A_z + (1 - 2\nu)\, C_{xx} - z A_{xx}, \quad \sigma_{zz} = A_z - z A_{zz}, \quad
              \sigma_{xz} = -z A_{xz}, \ldots

    and by the traction, times the friction,

    .. math:: \sigma_{xx} = 2 A_x - 2\nu B_{xyy} + z\, C_{xxx}, \quad \sigma_{zz} = -z A_{xz}, \quad
              \sigma_{xz} = A_z - z A_{xx}, \ldots

    At the rear edge of the contact, x = -a, the tension at the surface is the largest,
    :math:`\sigma_{xx} = p_0\,[(1-2\nu)/3 + \pi(4+\nu)\mu/8]`.

    Parameters
    ----------
    contact_radius
        Radius a of the contact, m.
    p_max
        Maximum pressure p0, Pa.
    friction
        Coefficient of friction; a negative one turns the traction to -x.
    poisson
        Poisson's ratio of the body.

    References
    ----------
    Hamilton, Proc. Inst. Mech. Eng. 197 (1983) 53-59

    Examples
    --------
    >>> from roughcontact.reference import SlidingSphere
    >>> ball = SlidingSphere(contact_radius=1.0, p_max=1.0, friction=0.25, poisson=0.3)
    >>> print(ball.stress(-1.0, 0.0, 0.0)[0].round(3))
    0.555
    """

    contact_radius: float = attrs.field(converter=read_length)
    p_max: float = attrs.field(converter=read_pressure)
    friction: float = attrs.field(converter=_friction)
    poisson: float = attrs.field(converter=_poisson)

    def stress(self, x: Array | float, y: Array | float, z: Array | float) -> Array:
        """Return the stress at broadcastable places, m, z >= 0 into the body.

        Returns
        -------
        numpy.ndarray
            The components xx, yy, zz, yz, xz, xy, shape (6, ...), Pa; tension is positive.
        """
        x, y, z = _places(x, y, z, scale=self.contact_radius)
        nu = self.poisson
        d = _Derivatives(x * x + y * y, z)
        # The numbers count derivatives with respect to s.
        a_1, a_2 = (d.potential(0, order) for order in (1, 2))
        a_z, a_1z = (d.potential(-1, order) for order in (0, 1))
        a_xx = 2.0 * a_1 + 4.0 * x * x * a_2
        a_yy = 2.0 * a_1 + 4.0 * y * y * a_2
        a_xy = 4.0 * x * y * a_2
        c_1, c_2, c_3 = (-d.potential(1, order) for order in (1, 2, 3))
        b_2, b_3 = (d.potential(2, order) for order in (2, 3))
        lateral = 1.0 - 2.0 * nu
        pressure = np.array(
            [
                2.0 * nu * a_z + lateral * (2.0 * c_1 + 4.0 * x * x * c_2) - z * a_xx,
                2.0 * nu * a_z + lateral * (2.0 * c_1 + 4.0 * y * y * c_2) - z * a_yy,
                a_z + z * (a_xx + a_yy),
                -2.0 * z * y * a_1z,
                -2.0 * z * x * a_1z,
                4.0 * lateral * x * y * c_2 - z * a_xy,
            ]
        )

        def differentiate(second: Array, third: Array) -> tuple[Array, Array, Array]:
            """Return the derivatives xxx, xyy and xxy."""
            return (
                x * (12.0 * second + 8.0 * x * x * third),
                x * (4.0 * second + 8.0 * y * y * third),
                y * (4.0 * second + 8.0 * x * x * third),
            )

        c_xxx, c_xyy, c_xxy = differentiate(c_2, c_3)
        b_xxx, b_xyy, b_xxy = differentiate(b_2, b_3)
        shear = np.array(
            [
                4.0 * x * a_1 - 2.0 * nu * b_xyy + z * c_xxx,
                -2.0 * nu * b_xxx + z * c_xyy,
                -2.0 * z * x * a_1z,
                -z * a_xy,
                a_z - z * a_xx,
                2.0 * y * a_1 + 2.0 * nu * b_xxy + z * c_xxy,
            ]
        )
        return np.asarray(self.p_max * (pressure + self.friction * shear))


class _Derivatives:
    """Derivatives with respect to s = x^2 + y^2 of the potentials of sqrt(1 - s) on the unit disc.

    The potential of a traction (1 - t^2) spread over the imaginary depths z + it, |t| < 1, is found by two partial
    integrations, so that only the end Z = z + i counts. With F_0 = 1/R and F_n the integral of F_(n-1) over Z, all
    derivatives of F_n follow from W = R + Z: dW/ds = 1/2R, dW/dZ = W/R and 2Z = W - s/W.
    """

    def __init__(self, s: Array, z: Array) -> None:
        depth = z + 1j
        root = np.sqrt(s + depth * depth)
        # At the edge of the contact only quotients z/R diverge, which are zero at the surface.
        self._root = np.where(root == 0.0, 1.0, root)
        w = root + depth
        log = np.log(w)
        self._f: dict[tuple[int, int], Waves] = {
            (0, 1): log,
            (0, 2): depth * log - root,
            (1, 1): 0.5 / (self._root * w),
            (1, 2): -0.5 / w,
            (1, 3): -0.25 * (log - s / (2.0 * w**2)),
            (1, 4): -0.25 * (0.5 * w * (log - 1.0) - s * (2.0 * log + 1.0) / (4.0 * w) + s**2 / (12.0 * w**3)),
            (2, 2): 0.25 / (self._root * w**2),
            (2, 3): -0.125 / w**2,
            (2, 4): (1.0 / w + s / (3.0 * w**3)) / 16.0,
            (2, 5): (0.5 * log - s / (3.0 * w**2) - s**2 / (24.0 * w**4)) / 16.0,
            (3, 3): 0.125 / (self._root * w**3),
            (3, 4): -1.0 / (24.0 * w**3),
            (3, 5): (1.0 / (2.0 * w**2) + s / (4.0 * w**4)) / 48.0,
        }

    def potential(self, integrals: int, order: int) -> Array:
        """Return a derivative with respect to s of the potential, integrated so many times over the depth."""
        return np.asarray(self._f[order, integrals + 3].imag - self._f[order, integrals + 2].real)


@guarded
@attrs.frozen
class SlidingCylinder:
    r"""Stress below a cylinder along y that slides: Hertz's pressure p, and the traction q = friction p along x.

    In plane strain, with :math:`\zeta = x + iz` and
    :math:`P - iH = -i\,(p_0/a)\,(\sqrt{\zeta^2 - a^2} - \zeta)`, the pressure gives

    .. math:: \sigma_{xx} = -P - zP_z, \quad \sigma_{zz} = -P + zP_z, \quad \sigma_{xz} = zP_x

    and the traction, times the friction,

    .. math:: \sigma_{xx} = 2H - zP_x, \quad \sigma_{zz} = zP_x, \quad \sigma_{xz} = -P - zP_z.

    At the rear edge of the contact, x = -a, the tension at the surface is the largest,
    :math:`\sigma_{xx} = 2\mu p_0`.

    Parameters
    ----------
    half_width
        Half the width a of the contact, m.
    p_max, friction, poisson
        As for `SlidingSphere`.

    References
    ----------
    Smith, Liu, J. Appl. Mech. 20 (1953) 157-168; Johnson, Contact Mechanics (1985), sec. 7.1,
    https://doi.org/10.1017/CBO9781139171731

    Examples
    --------
    >>> from roughcontact.reference import SlidingCylinder
    >>> cylinder = SlidingCylinder(half_width=1.0, p_max=1.0, friction=0.25, poisson=0.3)
    >>> print(cylinder.stress(-1.0, 0.0)[0].round(3))
    0.5
    """

    half_width: float = attrs.field(converter=read_length)
    p_max: float = attrs.field(converter=read_pressure)
    friction: float = attrs.field(converter=_friction)
    poisson: float = attrs.field(converter=_poisson)

    def stress(self, x: Array | float, z: Array | float) -> Array:
        """Return the stress at broadcastable places; see `SlidingSphere.stress`."""
        x, z = _places(x, z, scale=self.half_width)
        place = x + 1j * z
        root = np.sqrt(place - 1.0) * np.sqrt(place + 1.0)
        potential = -1j * (root - place)
        # At the edges of the contact the slope diverges, but not its product with the depth, zero at the surface.
        slope = -1j * z * (place / np.where(root == 0.0, 1.0, root) - 1.0)
        p = potential.real
        h = -potential.imag
        p_x = slope.real
        p_z = -slope.imag
        mu = self.friction
        xx = -p - p_z + mu * (2.0 * h - p_x)
        zz = -p + p_z + mu * p_x
        xz = p_x + mu * (-p - p_z)
        none = np.zeros_like(p)
        return np.asarray(self.p_max * np.array([xx, self.poisson * (xx + zz), zz, none, xz, none]))
