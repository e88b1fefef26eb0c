"""What the answers of a contact ask of all its parts: a contact whose fields are whole has one part, itself."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar, TypeVar

import numpy as np

from roughcontact._base.arrays import Array, IntArray, Mask, RealArray

T = TypeVar("T")


class Whole:
    """The only part of a contact.

    A contact whose fields are divided among processes has a class of this kind for each part (`roughcontact_mpi`):
    fields are then those of its own rows and of some rows beside them, lists are of its own cells, and numbers by patch
    are those of all patches, on each process. All processes must call the same methods in the same order.
    """

    # Whether the fields here are all there are.
    is_whole: ClassVar[bool] = True

    def ask(self, solution: Any, answer: Any, find: Callable[[Any], T]) -> T:
        """Return what a function finds of a solution for an answer: of what this part has of it."""
        return find(solution)

    def list_rows(self, solution: Any) -> dict[str, str]:
        """Return in words, by label, what this part has; nothing if it has all."""
        return {}

    def list_numbers(self, solution: Any) -> dict[str, Any]:
        """Return further numbers by name: estimates, or values with their units."""
        return {}

    def gather(self, solution: Any) -> Any:
        """Return the solution with all its fields as arrays of numpy; None on parts that do not get it."""
        return solution

    def patches(self, solution: Any) -> Any:
        """Return the patches of the contact; None if they are found from the fields here alone."""
        return None

    def sum(self, field: Array) -> float:
        """Return the sum of a field over all cells."""
        return float(np.add.reduce(field, axis=None))

    def total(self, values: T) -> T:
        """Return the sum over all parts of a number or an array of the same shape in each."""
        return values

    def highest(self, values: T) -> T:
        """Return the maximum over all parts, as `total` does the sum."""
        return values

    def lowest(self, values: T) -> T:
        """Return the minimum over all parts, as `total` does the sum."""
        return values

    def mean(self, values: Array) -> float:
        """Return the mean of a list of which each part has some."""
        return float(np.add.reduce(values)) / values.size

    def join(self, values: RealArray) -> RealArray:
        """Return the columns of all parts one after the other, of an array of shape (m, n)."""
        return values

    def own(self, field: RealArray) -> RealArray:
        """Return a field that is zero, or a mask that is false, at the cells that are another part's too."""
        return field

    def own_rows(self, rows: IntArray) -> slice | Mask:
        """Return which rows of the fields are not another part's too; the first row stands for negative ones."""
        return slice(None)

    def rows(self, rows: IntArray) -> IntArray:
        """Return the rows in the domain of rows of the fields."""
        return rows

    def evaluating(self, spline: T) -> T:
        """Return a spline through a field that all parts evaluate together, at points of the whole domain."""
        return spline

    def find(self, cells: IntArray) -> tuple[slice | Mask, IntArray]:
        """Return which cells of the domain, flat indices, are of this part alone, and their indices in the fields."""
        return slice(None), cells

    def tangent(self, solution: Any) -> Any:
        """Return what gives the linear answer of all parts of a solution; None if there is no other part."""
        return None

    def sample(self, cells: IntArray, count: int) -> IntArray:
        """Return every n-th of the cells, so that about `count` remain in all parts together."""
        return cells[:: max(1, cells.size // count)]

    def lines(self, field: RealArray, axis: int) -> RealArray:
        """Return the lines of a field along y (axis 0), or along x (axis 1), shape (lines, cells)."""
        return field if axis == 0 else np.ascontiguousarray(field.T)

    def count_equal(self, keys: Array) -> IntArray:
        """Return how many keys of a list are equal to each of them."""
        order = np.argsort(keys)
        ordered = keys[order]
        inner = np.flatnonzero(ordered[1:] - ordered[:-1]) + 1
        ends = np.concatenate(([0], inner, [keys.size]))
        counts = ends[1:] - ends[:-1]
        equal = np.empty(keys.size, dtype=np.intp)
        equal[order] = np.repeat(counts, counts)
        return equal

    def count_distinct(self, values: Array) -> int:
        """Return the number of different values in a list."""
        return int(np.unique(values).size)
