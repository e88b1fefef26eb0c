"""Types of arrays, and arrays that cannot be written to."""

from __future__ import annotations

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


def as_shape(value: Sequence[int]) -> tuple[int, int]:
    """Return two numbers of cells as a pair of int."""
    nx, ny = value
    return int(nx), int(ny)


def sum_of_products(one: RealArray, other: RealArray) -> float:
    """Return the sum of the products of two fields over all cells, without the threads of a BLAS."""
    return float(np.einsum("ij,ij->", one, other))


def restore_state(self: Any, state: Any) -> None:
    """Restore a pickled or copied object with read-only arrays; a class uses it as its ``__setstate__``."""
    own, slots = state if isinstance(state, tuple) else (state, None)
    for name, value in {**(own or {}), **(slots or {})}.items():
        object.__setattr__(self, name, read_only(value) if isinstance(value, np.ndarray) else value)
