"""Arrays of which each process has a part, and which follow numpy's protocols."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, ClassVar, NoReturn, Self

import numpy as np
import numpy.typing as npt
from numpy.lib.mixins import NDArrayOperatorsMixin

from roughcontact._base.arrays import RealArray
from roughcontact._solve.problem.slabs import functions
from roughcontact._solve.problem.slabs.processes import SlabProcesses
from roughcontact.errors import InputError

_REDUCTIONS = (np.add, np.minimum, np.maximum)


class Extent:
    """The shape of an array over all processes; the length of a list is asked for once."""

    __slots__ = ("_length", "_own", "_processes", "rest")

    def __init__(
        self, processes: SlabProcesses, own: int, length: int | None = None, rest: tuple[int, ...] = ()
    ) -> None:
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


class SlabArray(NDArrayOperatorsMixin):
    """An array of which each process has a part along the first axis, or which all have as a whole.

    The part is rows of a field, of a flat field, or a part of a list, as of cells: an array of numpy, or one that
    follows its protocols. A reduction returns the same number on all processes. Indices count within the part. What is
    not listed in `functions` raises `InputError`: nothing is gathered in silence.

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

    def __init__(self, part: Any, processes: Any, extent: Extent | None) -> None:
        self.part = part
        self.processes = processes
        self.extent = extent

    @classmethod
    def field(cls, part: Any, processes: Any, count: int) -> Self:
        """Return a field of `count` rows from the rows of this process."""
        return cls(part, processes, Extent(processes, part.shape[0], count, part.shape[1:]))

    @classmethod
    def list(cls, part: Any, processes: Any) -> Self:
        """Return a list from the entries of this process, of any number."""
        return cls(part, processes, Extent(processes, part.shape[0]))

    @property
    def is_divided(self) -> bool:
        """Whether each process has a part."""
        return self.extent is not None

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of entries along each axis, over all processes."""
        found: tuple[int, ...] = self.part.shape if self.extent is None else self.extent.shape
        return found

    @property
    def size(self) -> int:
        """Number of entries, over all processes."""
        return int(np.prod(self.shape, dtype=np.int64))

    @property
    def ndim(self) -> int:
        """Number of axes."""
        return len(self.part.shape)

    @property
    def dtype(self) -> np.dtype[Any]:
        """Type of the entries."""
        found: np.dtype[Any] = self.part.dtype
        return found

    @property
    def T(self) -> SimpleNamespace:  # noqa: N802 - as numpy names it
        """The transposed shape, without values."""
        return SimpleNamespace(shape=self.shape[::-1])

    def like(self, part: Any) -> Any:
        """Return an array of this extent from the part of this process."""
        part = np.asarray(part) if isinstance(part, (np.generic, bool, int, float)) else part
        return type(self)(part, self.processes, self.extent)

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, out: Any = (), **options: Any) -> Any:
        """Carry a ufunc out on the parts."""
        if method == "reduce" and ufunc in _REDUCTIONS:
            return functions.reduce(ufunc, *inputs, **options)
        if method != "__call__":
            raise functions.unknown(f"{ufunc.__name__}.{method}")
        leader = functions.leader(inputs)
        parts = tuple(functions.part_of(one, leader) for one in inputs)
        options = {name: functions.part_of(value, leader) for name, value in options.items()}
        if out:
            ufunc(*parts, out=tuple(functions.part_of(one, leader) for one in out), **options)
            return out[0]
        found = ufunc(*parts, **options)
        return tuple(map(leader.like, found)) if isinstance(found, tuple) else leader.like(found)

    def __array_function__(self, function: Any, types: Any, args: Any, options: Any) -> Any:
        """Carry a function of numpy out on the parts."""
        return functions.carry_out(function, self, args, options)

    def __array__(self, dtype: npt.DTypeLike | None = None, copy: bool | None = None) -> NoReturn:
        """Refuse: numpy would go on with a part as if it were the whole."""
        raise InputError("An array in slabs becomes one of numpy by its part or PreparedConvolution.to_numpy alone.")

    def __getitem__(self, index: Any) -> Any:
        return functions.get(self, index)

    def __setitem__(self, index: Any, values: Any) -> None:
        functions.put(self, index, values)

    def __len__(self) -> int:
        return self.shape[0]

    def __bool__(self) -> bool:
        return bool(self._whole())

    def __int__(self) -> int:
        return int(self._whole())

    def __float__(self) -> float:
        return float(self._whole())

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.part!r}, {'divided' if self.is_divided else 'whole'})"

    def _whole(self) -> Any:
        if self.is_divided:
            raise functions.unknown("asarray")
        return self.part

    def gather(self) -> RealArray | None:
        """Return all rows of a field as an array of numpy on the first process; None on the others."""
        found: RealArray | None = self.processes.gather_rows(self.part, self.shape[0], first=True)
        return found

    def ravel(self) -> Self:
        """Return the entries along one axis."""
        return self.reshape(-1)

    def reshape(self, *shape: Any) -> Self:
        """Return the entries along one axis, or those of a flat field as rows and columns."""
        wanted = shape[0] if isinstance(shape[0], tuple) else shape
        if self.extent is None:
            return type(self)(self.part.reshape(wanted), self.processes, None)
        if len(wanted) == 1:
            length = self.size if self.ndim > 1 else None
            flat = self.part.reshape(-1)
            extent = self.extent if length is None else Extent(self.processes, flat.shape[0], length)
            return type(self)(flat, self.processes, extent)
        return type(self).field(self.part.reshape(-1, wanted[1]), self.processes, wanted[0])

    def astype(self, dtype: npt.DTypeLike, copy: bool = True) -> Any:
        """Return the entries in another type."""
        return self.like(self.part.astype(dtype, copy=copy))

    def copy(self) -> Any:
        """Return a copy."""
        return self.like(self.part.copy())

    def take(self, places: SlabArray, mode: Any = "raise", out: SlabArray | None = None) -> Any:
        """Return the entries at places of the flat part."""
        found = self.part.take(places.part, mode=mode, out=None if out is None else out.part)
        return places.like(found) if out is None else out

    def sum(self) -> Any:
        """Return the sum."""
        return functions.reduce(np.add, self, None)

    def mean(self) -> Any:
        """Return the mean."""
        return self.sum() / self.size

    def std(self) -> Any:
        """Return the standard deviation of all entries."""
        rest = self - self.mean()
        return np.sqrt(functions.reduce(np.add, rest * rest, None) / self.size)

    def min(self, initial: Any = None) -> Any:
        """Return the minimum."""
        return functions.reduce(np.minimum, self, None, initial=initial)

    def max(self, initial: Any = None) -> Any:
        """Return the maximum."""
        return functions.reduce(np.maximum, self, None, initial=initial)

    def any(self, axis: int | None = None) -> Any:
        """Return whether any entry is true; along an axis an array of numpy, the same on all processes."""
        if not self.is_divided:
            return self.part.any(axis)
        if axis is None:
            return bool(self.processes.total(int(self.part.any())))
        if axis == 0:
            return self.processes.total_blocks(np.asarray(self.part.any(axis=0), dtype=np.int32)) > 0
        rows = np.asarray(self.part.any(axis=1))
        return functions.gather_slabs(type(self).field(rows, self.processes, self.shape[0]))

    def all(self) -> Any:
        """Return whether all entries are true."""
        return not (~self).any()
