"""The residual stress in a domain that is free: that of a period, less the field of its images, which is smooth."""

from __future__ import annotations

import math
from functools import cached_property

import attrs
import numpy as np
from roughcontact.typing import Array, Pair, RealArray

from roughcontact_volume.spectra import Period, cut_layers

# Cells between a domain and its images, at least: nearer ones are not smooth.
_GAP = 12
# Points of the coarse plane along the shorter side of a period, about.
_POINTS = 11
# Points along an axis, at least: those of cubic interpolation, and one.
_MIN_POINTS = 5
# Ratio of the period that stands for no images to that of which they are removed.
_RATIO = 3
# The waves of the coarse planes that are damped, in radians from point to point.
_DAMPING = 0.8


def odd_length(minimum: float) -> int:
    """Return the smallest odd number of the form 3^a 5^b 7^c 11^d that is not below a number."""
    length = 2 * (max(1, math.ceil(minimum)) // 2) + 1
    while not _is_fast(length):
        length += 2
    return length


def _is_fast(length: int) -> bool:
    for prime in (3, 5, 7, 11):
        while length % prime == 0:
            length //= prime
    return length == 1


@attrs.frozen(eq=False)
class FreePlane:
    """The residual stress of eigenstrains in a domain that is free beyond its border, along one axis or both.

    Attributes
    ----------
    shape, spacing
        Cells of the domain, and their sides, m.
    thicknesses
        Thicknesses of the layers, shape (nz,), m.
    poisson
        Poisson's ratio.
    dtype
        Precision inside.
    repeats
        Whether the domain repeats along x, and along y: not along both.
    """

    shape: tuple[int, int]
    spacing: Pair
    thicknesses: Array
    poisson: float
    dtype: type[np.floating] = np.float64
    repeats: tuple[bool, bool] = (False, False)

    @cached_property
    def period(self) -> Period:
        """The period: along a free axis about twice the domain, of odd length, so that all its waves have a sign."""
        mx, my = (
            n if repeats else odd_length(max(2 * n - 1, n + _GAP))
            for n, repeats in zip(self.shape, self.repeats, strict=True)
        )
        return Period((mx, my), self.spacing, self.thicknesses, self.poisson, self.dtype)

    @cached_property
    def images(self) -> list[SmoothImages]:
        """What is subtracted: the fields of nearer and of farther images."""
        lengths = [m * side for m, side in zip(self.period.shape, self.spacing, strict=True)]
        farthest = _RATIO**2 * max(lengths)
        free = [axis for axis in (0, 1) if not self.repeats[axis]]
        found = []
        while (shortest := min(lengths[axis] for axis in free)) < 0.5 * farthest:
            side = shortest / _POINTS
            points = [odd_length(max(length / side - 0.5, _MIN_POINTS)) for length in lengths]
            ratios = [1, 1]
            for axis in free:
                ratios[axis] = _RATIO if shortest * _RATIO > lengths[axis] else 1
            found.append(SmoothImages(self, (lengths[0], lengths[1]), (points[0], points[1]), (ratios[0], ratios[1])))
            lengths = [length * ratio for length, ratio in zip(lengths, ratios, strict=True)]
        return found

    def find_stress(self, strain: Array) -> Array:
        """Return the residual stress over twice the shear modulus, mean over each layer, shape (6, nz, nx, ny)."""
        stress = self.period.find_stress(strain)
        for one in self.images:
            one.subtract(strain, stress)
        return stress


@attrs.frozen(eq=False)
class SmoothImages:
    r"""The stress by images of a domain in a period but those in a longer one, :math:`W (T_P - T_{rP}) W^T`.

    The points of the coarse plane have W, cubic interpolation to the cells, and its transpose, which keeps the moments
    of the strain up to the third: the map is symmetric as the stress itself is.

    Attributes
    ----------
    plane
        The domain and its layers.
    lengths
        Sides of the period, m.
    points
        Points of the coarse plane along them, odd.
    ratios
        How many times longer the other period is, odd.
    """

    plane: FreePlane
    lengths: Pair
    points: tuple[int, int]
    ratios: tuple[int, int]

    @cached_property
    def sides(self) -> Pair:
        """Distances of the points, m."""
        return self.lengths[0] / self.points[0], self.lengths[1] / self.points[1]

    @cached_property
    def _matrices(self) -> tuple[RealArray, RealArray]:
        along_x, along_y = (
            _interpolate(n, spacing / side, points)
            for n, spacing, side, points in zip(
                self.plane.shape, self.plane.spacing, self.sides, self.points, strict=True
            )
        )
        return along_x, along_y

    @cached_property
    def _longer(self) -> Period:
        """The longer period, with waves weighed so that its field is that of the shorter one less its own.

        Of its waves the shorter period has those whose numbers are multiples of the ratios.
        """
        sizes = [length * ratio for length, ratio in zip(self.lengths, self.ratios, strict=True)]
        points = self.points[0] * self.ratios[0], self.points[1] * self.ratios[1]

        def weigh(qx: Array, qy: Array) -> Array:
            damping = np.exp(-0.5 * _DAMPING**2 * ((qx * self.sides[0]) ** 2 + (qy * self.sides[1]) ** 2))
            in_x, in_y = (
                np.rint(q * size / (2.0 * np.pi)) % ratio == 0.0
                for q, size, ratio in zip((qx, qy), sizes, self.ratios, strict=True)
            )
            return np.asarray(damping * (np.where(in_x & in_y, math.prod(self.ratios), 0) - 1))

        plane = self.plane
        return Period(points, self.sides, plane.thicknesses, plane.poisson, plane.dtype, weigh)

    def subtract(self, strain: Array, stress: Array) -> None:
        """Subtract the field of the images from the stress."""
        along_x, along_y = self._matrices
        dx, dy = self.plane.spacing
        weight = dx * dy / (self.sides[0] * self.sides[1])
        field = self._longer.find_stress((weight * along_x.T) @ strain @ along_y)
        _, layers, *cells = stress.shape
        for block in cut_layers(layers, math.prod(cells)):
            stress[:, block] -= along_x @ field[:, block] @ along_y.T


def _interpolate(cells: int, step: float, period: int) -> Array:
    """Return the matrix of cubic interpolation from points to cells, shape (cells, points), points <= period.

    The step from cell to cell is in distances of points; a point lies in the middle of the cells, so that the map is
    the same in a mirror.
    """
    middle = 0.5 * (cells - 1)
    place = math.ceil(step * middle) + step * (np.arange(cells) - middle)
    first = np.floor(place).astype(np.intp)
    x = place - first
    weights = np.stack(
        (
            -x * (x - 1.0) * (x - 2.0) / 6.0,
            (x + 1.0) * (x - 1.0) * (x - 2.0) / 2.0,
            -(x + 1.0) * x * (x - 2.0) / 2.0,
            (x + 1.0) * x * (x - 1.0) / 6.0,
        ),
        axis=1,
    )
    matrix = np.zeros((cells, min(int(first[-1]) + 4, period)))
    np.put_along_axis(matrix, (first[:, np.newaxis] + np.arange(4)) % period, weights, axis=1)
    return matrix
