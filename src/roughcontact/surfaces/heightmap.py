"""Height maps: measured or computed heights on a grid of their own."""

from __future__ import annotations

from collections.abc import Sequence

import attrs
import numpy as np

from roughcontact.checks import Array, Pair, choice, frozen_array, heights_array, integer, pair
from roughcontact.errors import InputError
from roughcontact.grid import Grid
from roughcontact.surfaces.base import Surface
from roughcontact.surfaces.resampling import bilinear, block_mean, fourier


def _size(value: float | Sequence[float]) -> Pair:
    return pair(value, "The size of the height map", "m", above=0.0)


@attrs.frozen(eq=False)
class HeightMap(Surface):
    """Heights given as an array, one value for each cell.

    Parameters
    ----------
    heights
        Heights, shape (nx, ny), indexed [x, y], m, positive outward, finite; a copy is kept.
    size
        Sides of the measured domain (x, y) or of both, m.
    periodic
        Whether the map goes on with its own copy beyond the border.

    Raises
    ------
    InputError
        If the heights are not a two-dimensional array of at least two finite numbers.
    """

    _heights: Array = attrs.field(converter=heights_array, alias="heights")
    size: Pair = attrs.field(converter=_size)
    periodic: bool = attrs.field(default=False, kw_only=True, validator=attrs.validators.instance_of(bool))

    @property
    def grid(self) -> Grid:
        """The grid on which the map is given."""
        return Grid(self._heights.shape, self.size)

    @property
    def values(self) -> Array:
        """The heights, shape (nx, ny), m, read-only."""
        return self._heights

    def heights(self, grid: Grid) -> Array:
        """Return the heights, shape `grid.shape`, m.

        Raises
        ------
        InputError
            If the grid is not the map's own: a map is resampled only when asked.
        """
        if not self.grid.matches(grid):
            raise InputError(
                f"The height map is given on {self.grid}, but was asked for on {grid}. "
                f"Call .resample({grid.shape}) first, or use the map's own grid."
            )
        return self._heights

    def resample(self, shape: Sequence[int], method: str = "bilinear") -> HeightMap:
        """Return the map on another number of cells over the same domain.

        Parameters
        ----------
        shape
            Number of cells (nx, ny) of the new map.
        method
            ``"bilinear"``: interpolation between cell centres, as image scaling does it and as the
            paper scaled its measured maps; it aliases when coarsening. ``"fourier"``: exact for
            band-limited periodic maps. ``"mean"``: mean over whole blocks of cells.

        Raises
        ------
        InputError
            If the method is unknown, is ``"fourier"`` on a map that is not periodic, or is
            ``"mean"`` and the new cell counts do not divide the old ones.
        """
        target = Grid(shape, self.size).shape
        choice(method, "The resampling method", ("bilinear", "fourier", "mean"))
        if method == "fourier" and not self.periodic:
            raise InputError("Fourier resampling needs a periodic map: use 'bilinear', or periodic=True if it is one.")
        if method == "mean" and any(old % new for old, new in zip(self._heights.shape, target, strict=True)):
            raise InputError(
                f"Block means need cell counts that divide {self._heights.shape}, but got {target}; use 'bilinear'."
            )
        if method == "bilinear":
            values = bilinear(self._heights, target, periodic=self.periodic)
        else:
            values = (fourier if method == "fourier" else block_mean)(self._heights, target)
        return attrs.evolve(self, heights=values)

    def detrend(self, degree: int = 1) -> HeightMap:
        """Return the map less its least-squares polynomial of total degree `degree`.

        Parameters
        ----------
        degree
            0 takes away the mean, 1 the tilt as well, 2 curvature and twist as well, ...

        Raises
        ------
        InputError
            If the degree is no whole number of at least 0, or the map has too few cells for it.
        """
        degree = integer(degree, "The degree of the trend", at_least=0)
        if min(self._heights.shape) <= degree:
            raise InputError(f"A trend of degree {degree} needs more than {degree} cells along each axis.")
        x, y = (np.linspace(-1.0, 1.0, n) for n in self._heights.shape)
        px, py = (np.polynomial.legendre.legvander(t, degree) for t in (x, y))
        terms = [(i, j) for i in range(degree + 1) for j in range(degree + 1 - i)]
        # The terms are products, so that all sums of the normal equations factor over the axes.
        gx, gy, moments = px.T @ px, py.T @ py, px.T @ self._heights @ py
        gram = np.array([[gx[i, k] * gy[j, m] for k, m in terms] for i, j in terms])
        solved = np.linalg.solve(gram, np.array([moments[term] for term in terms]))
        weights = np.zeros_like(moments)
        for term, weight in zip(terms, solved, strict=True):
            weights[term] = weight
        return attrs.evolve(self, heights=frozen_array(self._heights - px @ weights @ py.T))
