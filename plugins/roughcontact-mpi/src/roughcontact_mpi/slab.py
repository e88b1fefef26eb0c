"""What an array in slabs is: the part of a process, and the extent over all of them."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, ClassVar, TypeVar

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin
from roughcontact.typing import RealArray

from roughcontact_mpi.processes import Processes

S = TypeVar("S", bound="Slab")


class Extent:
    """The shape of an array over all processes; the length of a list is asked for once."""

    __slots__ = ("_length", "_own", "_processes", "rest")

    def __init__(self, processes: Processes, own: int, length: int | None = None, rest: tuple[int, ...] = ()) -> None:
        self._processes = processes
        self._own = own
        self._length = length
        self.rest = rest

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of entries along each axis, over all processes; all of them must ask."""
        if self._length is None:
            self._length = int(self._processes.total(self._own))
        return (self._length, *self.rest)


class Slab(NDArrayOperatorsMixin):
    """The part of an array, its processes and its extent.

    Attributes
    ----------
    part
        The part of this process.
    processes
        The processes.
    extent
        The shape over all processes; None if each has the whole array.
    """

    __slots__ = ("extent", "part", "processes")
    is_slab: ClassVar[bool] = True

    def __init__(self, part: RealArray, processes: Processes, extent: Extent | None) -> None:
        self.part = part
        self.processes = processes
        self.extent = extent

    @classmethod
    def field(cls: type[S], part: RealArray, processes: Processes, count: int) -> S:
        """Return a field of `count` rows from the rows of this process."""
        return cls(part, processes, Extent(processes, part.shape[0], count, part.shape[1:]))

    @classmethod
    def list(cls: type[S], part: RealArray, processes: Processes) -> S:
        """Return a list from the entries of this process, of any number."""
        return cls(part, processes, Extent(processes, part.shape[0]))

    @property
    def is_divided(self) -> bool:
        """Whether each process has a part."""
        return self.extent is not None

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of entries along each axis, over all processes."""
        return self.part.shape if self.extent is None else self.extent.shape

    @property
    def size(self) -> int:
        """Number of entries, over all processes."""
        return int(np.prod(self.shape, dtype=np.int64))

    @property
    def ndim(self) -> int:
        """Number of axes."""
        return self.part.ndim

    @property
    def dtype(self) -> np.dtype[Any]:
        """Type of the entries."""
        return self.part.dtype

    @property
    def T(self) -> SimpleNamespace:  # noqa: N802 - as numpy names it
        """The transposed shape, without values."""
        return SimpleNamespace(shape=self.shape[::-1])

    def like(self, part: Any) -> Any:
        """Return an array of this extent from the part of this process; a number as it is."""
        return type(self)(part, self.processes, self.extent) if isinstance(part, np.ndarray) else part

    def like_rows(self: S, part: RealArray) -> S:
        """Return an array with as many rows as this one, of another width."""
        return type(self).field(part, self.processes, self.shape[0])
