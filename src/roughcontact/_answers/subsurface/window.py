"""The cells around a place of the domain."""

from __future__ import annotations

import attrs
import numpy as np

from roughcontact._base.arrays import Array, IntArray, Mask, RealArray
from roughcontact._parts.grid import Boundary


@attrs.frozen
class Window:
    """The cells around a place, as many on each side; those beyond a free border are none of the domain.

    Attributes
    ----------
    place
        The cell in the middle.
    shape, boundary
        The cells of the domain along x and y, and its boundary.
    reach
        The cells on each side of the middle along x, and along y.
    """

    place: tuple[int, int]
    shape: tuple[int, int]
    boundary: Boundary
    reach: tuple[int, int]

    @property
    def along(self) -> tuple[IntArray, IntArray]:
        """The numbers of its cells along x and y, beyond a border too."""
        x, y = (np.arange(at - reach, at + reach + 1) for at, reach in zip(self.place, self.reach, strict=True))
        return x, y

    @property
    def outside(self) -> Mask:
        """Whether a cell lies beyond a free border."""
        ends = zip(self.along, self.shape, self.boundary.repeats, strict=True)
        return np.logical_or.outer(*((not repeats) & ((at < 0) | (at >= count)) for at, count, repeats in ends))

    def select(self) -> tuple[IntArray, ...]:
        """Return the indices of its cells in an array of the domain; the last ones stand for those beyond a border."""
        ends = zip(self._inside, self.shape, strict=True)
        return np.ix_(*(at % count for at, count in ends))

    def cut(self, values: RealArray) -> RealArray:
        """Return the values of its cells, zero beyond a free border."""
        rows, columns = self.select()
        inside = values[..., rows, columns]
        return np.where(self.outside, 0.0, inside)

    def extend(self, values: Array) -> Array:
        """Return values of its cells, beyond a free border those of the last ones before it."""
        nearest = (at - along[0] for at, along in zip(self._inside, self.along, strict=True))
        return values[np.ix_(*nearest)]

    @property
    def _inside(self) -> tuple[IntArray, IntArray]:
        """The numbers of its cells, those beyond a free border moved to the last ones before it."""
        ends = zip(self.along, self.shape, self.boundary.repeats, strict=True)
        x, y = (at if repeats else np.clip(at, 0, count - 1) for at, count, repeats in ends)
        return x, y
