"""The response of an anisotropic half-space to a wave of pressure, by the direction of its wave vector."""

from __future__ import annotations

from functools import lru_cache

import attrs
import numpy as np
import roughcontact as rc
from numpy.polynomial import chebyshev

from roughcontact_layered.stack import Array

# Points at the start, and at most, of the trapezoidal rule over half a turn of the pair of vectors, and directions; the
# integrands are periodic and analytic, so that the error falls geometrically.
_FIRST_POINTS = 32
_MAX_POINTS = 1024
# Relative error of the rule and of the series of directions, per compliance over the inverse of the largest stiffness:
# rounding grows with it.
_TOLERANCE = 1e-13
# Terms below this part of the mean are rounding; odd terms above the second part are not.
_NEGLIGIBLE = 1e-15
_EVEN_TOLERANCE = 1e-9


@attrs.frozen(eq=False)
class DirectionSeries:
    r"""Half of q u / p as a series of the angle from the x axis, 1/Pa.

    .. math:: c(\theta) = \bar c + \sum_k a_k \cos 2 k \theta + b_k \sin 2 k \theta

    Attributes
    ----------
    mean
        The mean over all directions, 1/Pa.
    even, odd
        The factors a_k and b_k from k = 1 on, 1/Pa.
    """

    mean: float
    even: Array
    odd: Array

    def at(self, angle: Array) -> Array:
        """Return the compliance of waves whose wave vector has these angles from the x axis, rad, in 1/Pa."""
        phases = 2.0 * np.multiply.outer(np.asarray(angle), np.arange(1, self.even.size + 1))
        return np.asarray(self.mean + np.cos(phases) @ self.even + np.sin(phases) @ self.odd)

    @property
    def is_even(self) -> bool:
        """Whether the response is even in x and in y."""
        return bool(np.abs(self.odd).max(initial=0.0) <= _EVEN_TOLERANCE * self.mean)

    @property
    def turn_to_even(self) -> float | None:
        """Smallest angle by which the x axis has to be turned until the response is even, rad; None without one."""
        size = np.hypot(self.even, self.odd)
        if not size.size:
            return 0.0
        order = int(np.argmax(size)) + 1
        first = np.arctan2(self.odd[order - 1], self.even[order - 1]) / (2.0 * order)
        angles = first + np.pi / (2.0 * order) * np.arange(2 * order)
        angles = (angles + 0.5 * np.pi) % np.pi - 0.5 * np.pi
        phases = 2.0 * np.multiply.outer(angles, np.arange(1, size.size + 1))
        odd = np.abs(np.cos(phases) * self.odd - np.sin(phases) * self.even).max(axis=1)
        fitting = angles[odd <= 10.0 * _EVEN_TOLERANCE * self.mean]
        return float(fitting[np.argmin(np.abs(fitting))]) if fitting.size else None

    def deviation(self, x: Array, y: Array) -> Array:
        """Return the compliance less its mean for wave vectors along (x, y), an even response, 1/Pa."""
        square_x, square_y = np.square(x), np.square(y)
        # cos 2 k theta is Chebyshev's polynomial of cos 2 theta.
        cosine = (square_x - square_y) / (square_x + square_y)
        return np.asarray(chebyshev.chebval(cosine, np.concatenate(([0.0], self.even))))


@lru_cache(maxsize=64)
def expand_directions(stiffness: bytes) -> DirectionSeries:
    """Return the series of a stiffness tensor, shape (3, 3, 3, 3), Pa, its third axis along the normal.

    `InputError` if the directions differ too much for it.
    """
    tensor = np.frombuffer(stiffness).reshape(3, 3, 3, 3)
    scale = float(np.abs(tensor).max())
    count = _FIRST_POINTS
    while count <= _MAX_POINTS:
        # Waves q and -q have the same response: half a turn is a period.
        values = respond_to_directions(tensor / scale, np.linspace(0.0, np.pi, count, endpoint=False))
        terms = np.fft.rfft(values) / count
        mean = float(terms[0].real)
        kept = terms[1 : count // 4] / scale
        if np.abs(terms[count // 4 :]).max() <= _TOLERANCE * mean * max(mean, 1.0):
            size = int(np.flatnonzero(np.append(True, np.abs(kept) > _NEGLIGIBLE * mean / scale))[-1])
            return DirectionSeries(mean / scale, 2.0 * kept.real[:size], -2.0 * kept.imag[:size])
        count *= 2
    raise _too_anisotropic()


def respond_to_directions(stiffness: Array, angle: Array) -> Array:
    r"""Return half of q u / p of a half-space under waves of pressure.

    With m along the wave vector and n along the normal, both turned by the angle w in their plane, and
    (ab)_{ik} = C_{ijkl} a_j b_l, the displacement by a wave of pressure is the component along the normal of

    .. math:: q\,u = L^{-1} t, \quad L = \frac{1}{\pi} \int_0^\pi
              \left[(mm) - (mn)(nn)^{-1}(nm)\right] \mathrm{d}w

    The tensor L of Barnett and Lothe follows from this integral without the eigenvectors of Stroh's formalism, which
    coincide in isotropic bodies.

    Parameters
    ----------
    stiffness
        Tensor C, shape (3, 3, 3, 3), Pa, its third axis along the normal.
    angle
        Angles of the wave vectors from the first axis, shape (n,), rad.

    Returns
    -------
    Array
        Compliances, shape (n,), 1/Pa; (1 - nu^2) / E of an isotropic body.

    Raises
    ------
    roughcontact.InputError
        If the integral does not converge, because the stiffness differs too much between directions.

    References
    ----------
    Vlassak, Ciavarella, Barber, Wang, J. Mech. Phys. Solids 51 (2003) 1701-1721,
    https://doi.org/10.1016/S0022-5096(03)00066-8
    """
    along = np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=-1)
    normal = np.array([0.0, 0.0, 1.0])
    # (mm), (mn) and (nn) of the vectors that are not turned.
    parts = (
        np.einsum("ijkl,aj,al->aik", stiffness, along, along, optimize=True),
        np.einsum("ijkl,aj,l->aik", stiffness, along, normal, optimize=True),
        np.broadcast_to(stiffness[:, 2, :, 2], (angle.size, 3, 3)),
    )
    scale = float(np.abs(stiffness).max())
    count = _FIRST_POINTS
    mean = _average(parts, np.linspace(0.0, np.pi, count, endpoint=False))
    values = _find_compliance(mean)
    while count < _MAX_POINTS:
        # The points of the finer rule lie between those of the coarser one.
        between = np.linspace(0.0, np.pi, count, endpoint=False) + 0.5 * np.pi / count
        mean = np.asarray(0.5 * (mean + _average(parts, between)))
        count *= 2
        finer = _find_compliance(mean)
        largest = float(np.abs(finer).max())
        if np.abs(finer - values).max() <= _TOLERANCE * largest * max(largest * scale, 1.0):
            return finer
        values = finer
    raise _too_anisotropic()


def _too_anisotropic() -> rc.InputError:
    return rc.InputError(
        "The stiffness differs too much between its directions to be resolved: the largest of its eigenvalues may be "
        "some thousand times the smallest."
    )


def _average(parts: tuple[Array, Array, Array], turns: Array) -> Array:
    """Return the mean of the integrand over the angles of turn, shape (directions, 3, 3)."""
    first, mixed, last = parts
    both = mixed + mixed.swapaxes(1, 2)
    total = np.zeros_like(first)
    for cosine, sine in zip(np.cos(turns), np.sin(turns), strict=True):
        crossed = cosine * sine * both
        mm = cosine**2 * first + crossed + sine**2 * last
        nn = sine**2 * first - crossed + cosine**2 * last
        mn = cosine**2 * mixed - sine**2 * mixed.swapaxes(1, 2) + cosine * sine * (last - first)
        total += mm - mn @ np.linalg.solve(nn, mn.swapaxes(1, 2))
    return np.asarray(total / turns.size)


def _find_compliance(tensor: Array) -> Array:
    return np.asarray(0.5 * np.linalg.inv(tensor)[:, 2, 2])
