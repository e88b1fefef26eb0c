"""Faces between the open cells of a gap: the film in each, by the slope of the film around it."""

from __future__ import annotations

import attrs
import numpy as np

from roughcontact._base.arrays import Array, Mask, Pair, RealArray

# The weight of the harmonic mean is this constant and slope times the squared cosine of the angle between the slope of
# the film and the normal of the face. Of a light wave at an angle t the flow then errs in second order by
# cos^2 t (-24 - 12 w + 54 cos^2 t - 18 cos^4 t), in units of (amplitude / film)^2 (wave number x step)^2 / 12 / 2: not
# at all across the wave (w = 1 at t = 0), and by zero in the mean of all directions (w = 7/16).
_WEIGHT_CONSTANT = -1.25
_WEIGHT_SLOPE = 2.25


@attrs.frozen(eq=False)
class Faces:
    """The faces between neighbouring cells of a network; those that are crossed along axis 0 come first.

    Attributes
    ----------
    first, second
        The two cells of each face, as positions among the cells of the network.
    along
        Number of the faces that are crossed along axis 0.
    first_film, second_film
        Films of the first and of the second cell.
    weight
        Weight of the harmonic mean of the cubes of both films; the rest is that of a film linear between them.
    """

    first: RealArray
    second: RealArray
    along: int
    first_film: Array
    second_film: Array
    weight: Array

    @property
    def ratio(self) -> Array:
        """The harmonic mean of the cubes over the mean of a linear film, at most 1."""
        product = self.first_film * self.second_film
        return np.asarray(product / (self.first_film**2 - product + self.second_film**2))

    def find_cubes(self) -> Array:
        """Return the mean cube of the film in each face.

        Of a film that is linear between the cells it is 2 a^2 b^2 / (a + b), the inverse mean of 1/g^3; the harmonic
        mean of both cubes is that of the trapezoidal rule for it. Both are blended as powers.
        """
        linear = 2.0 * (self.first_film * self.second_film) ** 2 / (self.first_film + self.second_film)
        return np.asarray(linear * self.ratio**self.weight)

    def find_films(self) -> Array:
        """Return the film that a wall drags through each face, over the speed and 1/2.

        Where faces follow each other it is the mean of 1/g^2 over that of 1/g^3, by the same two rules.
        """
        return np.asarray(self._drag_linear() + self.weight * self.compare_films())

    def compare_films(self) -> Array:
        """Return by how much these films differ between the trapezoidal rule and a film linear between the cells."""
        square = self.first_film**2 + self.second_film**2
        trapezoidal = 0.5 * square / (square - self.first_film * self.second_film)
        return np.asarray(self._drag_linear() * (trapezoidal - 1.0))

    def _drag_linear(self) -> Array:
        return np.asarray(2.0 * self.first_film * self.second_film / (self.first_film + self.second_film))


def make_faces(film: Array, number: RealArray, *, steps: Pair, wraps: tuple[bool, bool]) -> Faces:
    """Return the faces between the cells of a network.

    Parameters
    ----------
    film
        Gap in any unit, zero in closed cells, shape (nx, ny).
    number
        Position of each cell in the network, -1 for cells outside it, shape (nx, ny).
    steps
        Lengths of a cell along both axes.
    wraps
        Whether the gap repeats beyond its borders, along each axis.
    """
    slopes = tuple(_slope(film, axis, steps[axis], wrapped=wraps[axis]) for axis in (0, 1))
    parts = [_pair(film, number, slopes[1 - axis], axis, steps[axis], wrapped=wraps[axis]) for axis in (0, 1)]
    joined = (np.concatenate(columns) for columns in zip(*parts, strict=True))
    first, second, first_film, second_film, weight = joined
    return Faces(first, second, parts[0][0].size, first_film, second_film, weight)


def _slope(film: Array, axis: int, step: float, *, wrapped: bool) -> Array:
    """Return the slope of the film along an axis by central differences, at free borders by one-sided ones."""
    if film.shape[axis] == 1:
        return np.zeros(film.shape)
    if wrapped:
        return np.asarray((np.roll(film, -1, axis) - np.roll(film, 1, axis)) / (2.0 * step))
    return np.asarray(np.gradient(film, step, axis=axis))


def _pair(
    film: Array, number: RealArray, across: Array, axis: int, step: float, *, wrapped: bool
) -> tuple[RealArray, RealArray, Array, Array, Array]:
    """Return cells, films and weights of the faces that are crossed along an axis, those over the border last."""
    parts = [(_slice(axis, None, -1), _slice(axis, 1, None))]
    if wrapped:
        parts.append((_slice(axis, -1, None), _slice(axis, None, 1)))
    found = []
    for one, other in parts:
        both: Mask = (number[one] >= 0) & (number[other] >= 0)
        first_film = film[one][both]
        second_film = film[other][both]
        normal = (second_film - first_film) / step
        beside = 0.5 * (across[one][both] + across[other][both])
        squared = normal**2 + beside**2
        cosine = np.divide(normal**2, squared, out=np.ones_like(squared), where=squared > 0.0)
        weight = _WEIGHT_CONSTANT + _WEIGHT_SLOPE * cosine
        found.append((number[one][both], number[other][both], first_film, second_film, weight))
    first, second, first_film, second_film, weight = (np.concatenate(columns) for columns in zip(*found, strict=True))
    return first, second, first_film, second_film, weight


def _slice(axis: int, start: int | None, stop: int | None) -> tuple[slice, ...]:
    """Return the index of a range of lines along an axis."""
    part = slice(start, stop)
    return (part, slice(None)) if axis == 0 else (slice(None), part)
