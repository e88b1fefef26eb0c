"""Faces between the open cells of a gap: the film in each, by the slope of the film around it."""

from __future__ import annotations

import attrs
import numpy as np

from roughcontact._base.arrays import Array, Mask, Pair, RealArray

# Of a light wave, with u = cos^2 of its angle to the normal of a face, flow and dragged film err in second order, in
# any direction, by little if the film in the middle of the face is that of the four cells in line with it (9/16 and
# -1/16 of each) and the weights of harmonic mean and trapezoidal rule are -5/4 + 9/4 u - 3/2 u^2 and these. With the
# mean of two cells the flow along oblique grooves is up to a quarter too small. The first ones are larger by
# (u - u^2) / 2, by which the error of rough gaps in contact is smallest (draw 91 of benchmarks/edged_classes.py).
_CUBE_WEIGHTS = (-1.25, 2.75, -2.0)
_DRAG_WEIGHTS = (-1.0, 1.5, -1.0)
# Where the film varies across the face alone, the harmonic mean and the trapezoidal rule are exact, and the middle is
# not used: both change to that by u squared so many times, u^512, which is small on surfaces of many directions.
_ALIGNED_SQUARINGS = 9
# Smallest film in the middle over the mean of both cells: beside throats four cells may give none.
_MIN_MIDDLE = 0.5


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
    cosine
        Squared cosine of the angle between the slope of the film and the normal of each face.
    aligned
        How far the film varies across each face alone: 1 if it does, mostly 0 else.
    middle
        Film in the middle of each face over the mean of both.
    """

    first: RealArray
    second: RealArray
    along: int
    first_film: Array
    second_film: Array
    cosine: Array
    aligned: Array
    middle: Array

    @property
    def ratio(self) -> Array:
        """The harmonic mean of the cubes over the mean of a linear film, at most 1."""
        product = self.first_film * self.second_film
        return np.asarray(product / (self.first_film**2 - product + self.second_film**2))

    @property
    def weight(self) -> Array:
        """Weight of the harmonic mean of the cubes of both films; the rest is that of a film linear between them."""
        return self._weigh(_CUBE_WEIGHTS)

    def find_cubes(self) -> Array:
        """Return the mean cube of the film in each face.

        Of a film that is linear between the cells it is 2 a^2 b^2 / (a + b), the inverse mean of 1/g^3; the harmonic
        mean of both cubes is that of the trapezoidal rule for it. Both are blended as powers, and the cube of the film
        in the middle is taken for that of their mean.
        """
        linear = 2.0 * (self.first_film * self.second_film) ** 2 / (self.first_film + self.second_film)
        return np.asarray(linear * self.ratio**self.weight * self.middle**3)

    def find_films(self) -> Array:
        """Return the film that a wall drags through each face, over the speed and 1/2.

        Where faces follow each other it is the mean of 1/g^2 over that of 1/g^3, by the same two rules.
        """
        return np.asarray(self.middle * self._drag_linear() + self._weigh(_DRAG_WEIGHTS) * self.compare_films())

    def compare_films(self) -> Array:
        """Return by how much these films differ between the trapezoidal rule and a film linear between the cells."""
        square = self.first_film**2 + self.second_film**2
        trapezoidal = 0.5 * square / (square - self.first_film * self.second_film)
        return np.asarray(self.middle * self._drag_linear() * (trapezoidal - 1.0))

    def _drag_linear(self) -> Array:
        return np.asarray(2.0 * self.first_film * self.second_film / (self.first_film + self.second_film))

    def _weigh(self, weights: tuple[float, float, float]) -> Array:
        """Return a weight that is 1 where the film varies across the face alone."""
        constant, slope, bend = weights
        rest = 1.0 - constant - slope - bend
        return np.asarray(constant + self.cosine * (slope + bend * self.cosine) + rest * self.aligned)


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
    squares = [_slope(film, axis, steps[axis], wrapped=wraps[axis]) ** 2 for axis in (0, 1)]
    parts = [_pair(film, number, squares[1 - axis], axis, steps[axis], wrapped=wraps[axis]) for axis in (0, 1)]
    joined = (np.concatenate(columns) for columns in zip(*parts, strict=True))
    first, second, first_film, second_film, cosine, aligned, middle = joined
    return Faces(first, second, parts[0][0].size, first_film, second_film, cosine, aligned, middle)


def _slope(film: Array, axis: int, step: float, *, wrapped: bool) -> Array:
    """Return the slope of the film along an axis by central differences, at free borders by one-sided ones."""
    if film.shape[axis] == 1:
        return np.zeros(film.shape)
    if wrapped:
        return np.asarray((np.roll(film, -1, axis) - np.roll(film, 1, axis)) / (2.0 * step))
    return np.asarray(np.gradient(film, step, axis=axis))


def _pair(
    film: Array, number: RealArray, across: Array, axis: int, step: float, *, wrapped: bool
) -> tuple[RealArray, RealArray, Array, Array, Array, Array, Array]:
    """Return cells and films of the faces that are crossed along an axis, and what else `Faces` has of them, in order.

    `across` is the squared slope along the other axis. Faces over the border come last.
    """
    parts = [(_slice(axis, None, -1), _slice(axis, 1, None))]
    if wrapped:
        parts.append((_slice(axis, -1, None), _slice(axis, None, 1)))
    bend = _bend(film, axis, wrapped=wrapped)
    found = []
    for one, other in parts:
        both: Mask = (number[one] >= 0) & (number[other] >= 0)
        first_film = film[one][both]
        second_film = film[other][both]
        normal = ((second_film - first_film) / step) ** 2
        squared = normal + 0.5 * (across[one][both] + across[other][both])
        cosine = np.divide(normal, squared, out=np.ones_like(squared), where=squared > 0.0)
        # The mean of two cells less a sixteenth of both second differences is that of four.
        risen = -0.125 * (bend[one][both] + bend[other][both]) / (first_film + second_film)
        aligned = cosine.copy()
        for _ in range(_ALIGNED_SQUARINGS):
            aligned *= aligned
        middle = np.maximum(1.0 + (1.0 - aligned) * risen, _MIN_MIDDLE)
        found.append((number[one][both], number[other][both], first_film, second_film, cosine, aligned, middle))
    first, second, first_film, second_film, cosine, aligned, middle = (
        np.concatenate(columns) for columns in zip(*found, strict=True)
    )
    return first, second, first_film, second_film, cosine, aligned, middle


def _bend(film: Array, axis: int, *, wrapped: bool) -> Array:
    """Return the second differences of the film along an axis, zero at free borders."""
    bend = np.roll(film, -1, axis) - 2.0 * film + np.roll(film, 1, axis)
    if not wrapped:
        bend[_slice(axis, None, 1)] = 0.0
        bend[_slice(axis, -1, None)] = 0.0
    return np.asarray(bend)


def _slice(axis: int, start: int | None, stop: int | None) -> tuple[slice, ...]:
    """Return the index of a range of lines along an axis."""
    part = slice(start, stop)
    return (part, slice(None)) if axis == 0 else (slice(None), part)
