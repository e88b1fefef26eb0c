"""Arrays of which each process has a part, and which follow numpy's protocols."""

from __future__ import annotations

from typing import Any, NoReturn

import numpy as np
import numpy.typing as npt
import roughcontact as rc
from roughcontact.typing import RealArray

from roughcontact_mpi import functions
from roughcontact_mpi.slab import Extent, Slab

_REDUCTIONS = (np.add, np.minimum, np.maximum)


class SlabArray(Slab):
    """An array of which each process has a part along the first axis, or which all have as a whole.

    The part is rows of a field, of a flat field, or a part of a list, as of cells. A reduction returns the same number
    on all processes. Indices count within the part. What is not listed in `functions` raises `InputError`: nothing is
    gathered in silence.
    """

    __slots__ = ()

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
        if isinstance(found, tuple):
            return tuple(leader.like(np.asarray(one)) for one in found)
        return leader.like(np.asarray(found))

    def __array_function__(self, function: Any, types: Any, args: Any, options: Any) -> Any:
        """Carry a function of numpy out on the parts."""
        return functions.carry_out(function, self, args, options)

    def __array__(self, dtype: npt.DTypeLike | None = None, copy: bool | None = None) -> NoReturn:
        """Refuse: numpy would go on with a part as if it were the whole."""
        raise rc.InputError("An array in slabs becomes one of numpy by its part or PreparedConvolution.to_numpy alone.")

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
        return f"SlabArray({self.part!r}, {'divided' if self.is_divided else 'whole'})"

    def _whole(self) -> RealArray:
        if self.is_divided:
            raise functions.unknown("asarray")
        return self.part

    def ravel(self) -> SlabArray:
        """Return the entries along one axis."""
        return self.reshape(-1)

    def reshape(self, *shape: Any) -> SlabArray:
        """Return the entries along one axis, or those of a flat field as rows and columns."""
        wanted = shape[0] if isinstance(shape[0], tuple) else shape
        if self.extent is None:
            return SlabArray(self.part.reshape(wanted), self.processes, None)
        if len(wanted) == 1:
            length = self.size if self.ndim > 1 else None
            extent = self.extent if length is None else Extent(self.processes, self.part.size, length)
            return SlabArray(self.part.reshape(-1), self.processes, extent)
        return SlabArray.field(self.part.reshape(-1, wanted[1]), self.processes, wanted[0])

    def astype(self, dtype: npt.DTypeLike, copy: bool = True) -> SlabArray:
        """Return the entries in another type."""
        return self.like(self.part.astype(dtype, copy=copy))

    def copy(self) -> SlabArray:
        """Return a copy."""
        return self.like(self.part.copy())

    def take(self, places: SlabArray, mode: Any = "raise", out: SlabArray | None = None) -> SlabArray:
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
        return functions.gather(self.like_rows(np.asarray(self.part.any(axis=1))))

    def all(self) -> Any:
        """Return whether all entries are true."""
        return not (~self).any()
