"""Faces between the open cells of a gap: the film in each, by the slope of the film around it."""

from __future__ import annotations

import attrs
import numpy as np

from roughcontact._base.arrays import Array, Mask, Pair, RealArray

# The weight of the harmonic mean is this polynomial of the squared cosine of the angle between the slope of the film
# and the normal of the face. Of a light wave at an angle t the flow then errs in second order by
# cos^2 t (-24 - 12 w + 54 cos^2 t - 18 cos^4 t), in units of (amplitude / film)^2 (wave number x step)^2 / 12 / 2: not
# at all across the wave (w = 1 at t = 0), and by zero in the mean of all directions (w = 7/16).
_WEIGHTS = (-1.25, 2.25, 0.0)
# Along oblique grooves with creases, of 3 to 8 cells, the flow is then up to a quarter too small. In gaps with such
# grooves the film in the middle of a face is that of the four cells in line with it (9/16 and -1/16 of each), and these
# are the weights of the harmonic mean and of the trapezoidal rule of dragged films: of a light wave in any direction
# both err little. The first one is larger than -5/4 + 9/4 u - 3/2 u^2 by (u - u^2) / 2, by which the error of rough
# gaps in contact is smallest (draw 91 of benchmarks/edged_classes.py).
_CREASED_WEIGHTS = (-1.25, 2.75, -2.0)
_CREASED_DRAG_WEIGHTS = (-1.0, 1.5, -1.0)
# Where the film varies across the face alone, the harmonic mean and the trapezoidal rule are exact, and the middle is
# not used: the rule of creased gaps changes to that by u squared so many times, u^512.
_ALIGNED_SQUARINGS = 9
# Smallest film in the middle over the mean of both cells: beside throats four cells may give none.
_MIN_MIDDLE = 0.5
# Heights count as grooves with creases as far as three measures of the second differences of the gap along both axes
# say so, between these values (draws 503, 907 and 908). The mean square of their own second differences over theirs is
# 6 at a crease, 3 to 6 on grooves with creases, 10 at steps, and up to 1.6 on waves of four cells or more in all
# directions.
_ROUGHNESS = (1.8, 2.6, 7.0, 8.5)
_BY_ROUGHNESS = (0.0, 1.0, 1.0, 0.0)
# Their mean square over the square of their mean size is pi / 2 on Gaussian heights, 1.5 to 1.6 on rough ones of any
# resolution, and mostly above 2 where lines of cells are bent much more than others.
_CONCENTRATION = (1.62, 1.75)
# Their skewness is above -0.5 on grooves, at whose bottom the film has a crease and is widest, and below -1 on ridges
# with a crease and around flat lands and dimples, where the rule does not help.
_SKEWNESS = (-1.0, -0.5)


@attrs.frozen(eq=False)
class Faces:
    """The faces between neighbouring cells of a network; those that are crossed along axis 0 come first.

    Attributes
    ----------
    first, second
        The two cells of each face, as positions among the cells of the network.
    along
        Number of the faces that are crossed along axis 0.
    creased
        How far the heights have grooves with creases along both axes, from 0 to 1.
    first_film, second_film
        Films of the first and of the second cell.
    cosine
        Squared cosine of the angle between the slope of the film and the normal of each face.
    aligned
        How far the film varies across each face alone: 1 if it does, mostly 0 else. Of gaps without creases omitted.
    middle
        Film in the middle of each face over the mean of both; 1 in gaps without creases.
    """

    first: RealArray
    second: RealArray
    along: int
    creased: float
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
        return self._weigh(_CREASED_WEIGHTS)

    def find_cubes(self) -> Array:
        """Return the mean cube of the film in each face.

        Of a film that is linear between the cells it is 2 a^2 b^2 / (a + b), the inverse mean of 1/g^3; the harmonic
        mean of both cubes is that of the trapezoidal rule for it. Both are blended as powers, and the cube of the film
        in the middle is taken for that of their mean.
        """
        linear = 2.0 * (self.first_film * self.second_film) ** 2 / (self.first_film + self.second_film)
        return np.asarray(linear * self.ratio**self.weight * self.middle**3)

    def compare_cubes(self) -> Array:
        """Return the cubes by the rule of gaps without creases over these, less 1."""
        return np.asarray(self.ratio ** (self._weigh(_WEIGHTS) - self.weight) / self.middle**3 - 1.0)

    def find_films(self) -> Array:
        """Return the film that a wall drags through each face, over the speed and 1/2.

        Where faces follow each other it is the mean of 1/g^2 over that of 1/g^3, by the same two rules.
        """
        return np.asarray(self.middle * self._drag_linear() + self._weigh(_CREASED_DRAG_WEIGHTS) * self.compare_films())

    def compare_films(self) -> Array:
        """Return by how much these films differ between the trapezoidal rule and a film linear between the cells."""
        square = self.first_film**2 + self.second_film**2
        trapezoidal = 0.5 * square / (square - self.first_film * self.second_film)
        return np.asarray(self.middle * self._drag_linear() * (trapezoidal - 1.0))

    def _drag_linear(self) -> Array:
        return np.asarray(2.0 * self.first_film * self.second_film / (self.first_film + self.second_film))

    def _weigh(self, creased: tuple[float, float, float]) -> Array:
        """Return a weight of these coefficients, as far as the gap is creased; 1 where the film varies across alone."""
        pairs = zip(_WEIGHTS, creased, strict=True)
        constant, slope, bend = (plain + self.creased * (other - plain) for plain, other in pairs)
        rest = 1.0 - constant - slope - bend
        return np.asarray(constant + self.cosine * (slope + bend * self.cosine) + rest * self.aligned)


def find_creases(gap: Array) -> float:
    """Return how far an initial gap has grooves with creases along both axes, from 0 to 1.

    Differences across the border are omitted: there a gap that does not repeat has a crease.
    """
    return min(_find_creases(gap, axis) for axis in (0, 1))


def _find_creases(gap: Array, axis: int) -> float:
    if gap.shape[axis] <= 4:
        return 0.0
    second = np.diff(gap, 2, axis=axis)
    fourth = np.diff(second, 2, axis=axis)
    second = second[_slice(axis, 1, -1)]
    square = float(np.mean(second**2))
    if square == 0.0:
        return 0.0
    roughness = float(np.mean(fourth**2)) / square
    concentration = square / float(np.mean(np.abs(second))) ** 2
    skewness = -float(np.mean(second**3)) / square**1.5
    return float(
        min(
            np.interp(roughness, _ROUGHNESS, _BY_ROUGHNESS),
            np.interp(concentration, _CONCENTRATION, (0.0, 1.0)),
            np.interp(skewness, _SKEWNESS, (0.0, 1.0)),
        )
    )


def make_faces(film: Array, number: RealArray, *, steps: Pair, wraps: tuple[bool, bool], creased: float = 0.0) -> Faces:
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
    creased
        How far the heights have grooves with creases, from 0 to 1 (`find_creases`).
    """
    slopes = tuple(_slope(film, axis, steps[axis], wrapped=wraps[axis]) for axis in (0, 1))
    parts = [_pair(film, number, slopes[1 - axis], axis, steps[axis], creased, wrapped=wraps[axis]) for axis in (0, 1)]
    joined = (np.concatenate(columns) for columns in zip(*parts, strict=True))
    first, second, first_film, second_film, cosine, aligned, middle = joined
    return Faces(first, second, parts[0][0].size, creased, first_film, second_film, cosine, aligned, middle)


def _slope(film: Array, axis: int, step: float, *, wrapped: bool) -> Array:
    """Return the slope of the film along an axis by central differences, at free borders by one-sided ones."""
    if film.shape[axis] == 1:
        return np.zeros(film.shape)
    if wrapped:
        return np.asarray((np.roll(film, -1, axis) - np.roll(film, 1, axis)) / (2.0 * step))
    return np.asarray(np.gradient(film, step, axis=axis))


def _bend(film: Array, axis: int, *, wrapped: bool) -> Array:
    """Return the second differences of the film along an axis, zero at free borders."""
    bend = np.roll(film, -1, axis) - 2.0 * film + np.roll(film, 1, axis)
    if not wrapped:
        bend[_slice(axis, None, 1)] = 0.0
        bend[_slice(axis, -1, None)] = 0.0
    return np.asarray(bend)


def _pair(
    film: Array, number: RealArray, across: Array, axis: int, step: float, creased: float, *, wrapped: bool
) -> tuple[RealArray, RealArray, Array, Array, Array, Array, Array]:
    """Return cells and films of the faces that are crossed along an axis, and what else `Faces` has of them, in order.

    Faces over the border come last.
    """
    parts = [(_slice(axis, None, -1), _slice(axis, 1, None))]
    if wrapped:
        parts.append((_slice(axis, -1, None), _slice(axis, None, 1)))
    bend = _bend(film, axis, wrapped=wrapped) if creased > 0.0 else film
    found = []
    for one, other in parts:
        both: Mask = (number[one] >= 0) & (number[other] >= 0)
        first_film = film[one][both]
        second_film = film[other][both]
        normal = (second_film - first_film) / step
        low = across[one][both]
        high = across[other][both]
        # Beside a crease both slopes may cancel.
        beside = (0.5 * (low + high)) ** 2 + creased * (0.5 * (high - low)) ** 2
        squared = normal**2 + beside
        cosine = np.divide(normal**2, squared, out=np.ones_like(squared), where=squared > 0.0)
        aligned = np.zeros_like(cosine)
        middle = np.ones_like(cosine)
        if creased > 0.0:
            aligned = cosine.copy()
            for _ in range(_ALIGNED_SQUARINGS):
                aligned *= aligned
            # The mean of two cells less a sixteenth of both second differences is that of four.
            risen = -0.125 * (bend[one][both] + bend[other][both]) / (first_film + second_film)
            middle = np.maximum(1.0 + creased * (1.0 - aligned) * risen, _MIN_MIDDLE)
        found.append((number[one][both], number[other][both], first_film, second_film, cosine, aligned, middle))
    first, second, first_film, second_film, cosine, aligned, middle = (
        np.concatenate(columns) for columns in zip(*found, strict=True)
    )
    return first, second, first_film, second_film, cosine, aligned, middle


def _slice(axis: int, start: int | None, stop: int | None) -> tuple[slice, ...]:
    """Return the index of a range of lines along an axis."""
    part = slice(start, stop)
    return (part, slice(None)) if axis == 0 else (slice(None), part)
