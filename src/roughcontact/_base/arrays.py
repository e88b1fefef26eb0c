"""Types of arrays, and arrays that cannot be written to."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

Array: TypeAlias = npt.NDArray[np.float64]
RealArray: TypeAlias = npt.NDArray[Any]
IntArray: TypeAlias = npt.NDArray[np.intp]
Mask: TypeAlias = npt.NDArray[np.bool_]
Waves: TypeAlias = npt.NDArray[np.complexfloating[Any, Any]]
Pair: TypeAlias = tuple[float, float]

# Rows of the first matrix of a part of a product, real or complex, its most columns, and numbers of the second matrix:
# OpenBLAS takes one thread for at most 2^18 products of real numbers or 2^16 of complex ones, with a vector for 2^12.
_PART_ROWS = {False: 64, True: 16}
_PART_INNER = 60
_PART_NUMBERS = 3840
# Values of a part of a product of vectors, for which OpenBLAS takes one thread up to 10000; see `sum_of_products`.
_PART_VALUES = 2**13


def unit_vector(direction: float) -> Pair:
    """Return the unit vector along a direction from x towards y, degrees: along an axis exactly."""
    angle = math.radians(direction)
    return round(math.cos(angle), 15), round(math.sin(angle), 15)


def frozen_array(values: Array) -> Array:
    """Return `values` as a C-ordered, read-only float64 array."""
    array = np.ascontiguousarray(values, dtype=np.float64)
    array.flags.writeable = False
    return array


def read_only(values: RealArray) -> RealArray:
    """Return a view of an array, or the array made from other values, that cannot be written to."""
    array = np.asarray(values).view()
    array.flags.writeable = False
    return array


def read_only_field(values: RealArray) -> RealArray:
    """Return `read_only` of an array of numpy, and one of slabs or tensors, which follow its protocols, as it is."""
    follows = hasattr(values, "__array_function__") and not isinstance(values, np.ndarray)
    return values if follows else read_only(values)


def as_shape(value: Sequence[int]) -> tuple[int, int]:
    """Return two numbers of cells as a pair of int."""
    nx, ny = value
    return int(nx), int(ny)


def sum_of_products(one: RealArray, other: RealArray) -> float:
    """Return the sum of the products of two arrays of one shape, in parts for which a BLAS takes one thread."""
    first = one.ravel()
    second = other.ravel()
    if not isinstance(first, np.ndarray):
        return float(np.einsum("i,i->", first, second))
    if first.size <= _PART_VALUES:
        return float(np.dot(first, second))
    starts = range(0, first.size, _PART_VALUES)
    return math.fsum([np.dot(first[i : i + _PART_VALUES], second[i : i + _PART_VALUES]) for i in starts])


def matrix_product(one: RealArray, other: RealArray) -> RealArray:
    """Return the product of two matrices, shapes (m, k) and (k, n), in parts for which a BLAS takes one thread.

    With several threads the sums are rounded differently, and the threads take the processors of those of a solve.
    """
    m, k = one.shape
    n = other.shape[1]
    total: RealArray = np.zeros((m, n), dtype=np.result_type(one, other))
    inner = max(1, min(k, _PART_INNER))
    rows = _PART_ROWS[np.iscomplexobj(total)]
    columns = _PART_NUMBERS // inner
    for i, j, start in itertools.product(range(0, m, rows), range(0, n, columns), range(0, k, inner)):
        part = one[i : i + rows, start : start + inner] @ other[start : start + inner, j : j + columns]
        total[i : i + rows, j : j + columns] += part
    return total


def restore_state(self: Any, state: Any) -> None:
    """Restore a pickled or copied object with read-only arrays; a class uses it as its ``__setstate__``."""
    own, slots = state if isinstance(state, tuple) else (state, None)
    for name, value in {**(own or {}), **(slots or {})}.items():
        object.__setattr__(self, name, read_only(value) if isinstance(value, np.ndarray) else value)
