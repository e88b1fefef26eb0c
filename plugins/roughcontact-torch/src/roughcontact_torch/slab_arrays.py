"""Tensors of which each process has some rows, which follow numpy's protocols."""

from __future__ import annotations

from typing import Any, cast

import numpy as np
import roughcontact as rc
import torch

from roughcontact_torch.arrays import TensorArray
from roughcontact_torch.processes import Processes

# Functions that work on each entry alone, and those whose results of all processes are added.
_LOCAL = (np.zeros_like, np.ones_like, np.empty_like, np.where, np.clip, np.copyto)
_SUMS = (np.einsum, np.sum, np.count_nonzero)
_REDUCTIONS = {np.add: "sum", np.maximum: "highest", np.minimum: "lowest"}


class SlabTensor(TensorArray):
    """A field of which each process has some rows, or a list of which it has some entries, on its device.

    A reduction returns the same number on all processes, which must all ask for it. What is not listed raises
    `InputError`: nothing is gathered in silence.

    Attributes
    ----------
    tensor
        The part of this process.
    processes
        The processes.
    rows
        Rows of the field on all processes.
    """

    __slots__ = ("processes", "rows")

    def __init__(self, tensor: torch.Tensor, processes: Processes, rows: int) -> None:
        super().__init__(tensor)
        self.processes = processes
        self.rows = rows

    @classmethod
    def field(cls, part: Any, processes: Processes, count: int) -> SlabTensor:
        """Return a field of `count` rows on the devices from the rows of this process, an array of numpy or a tensor.

        Raises
        ------
        InputError
            If the rows are not those that `Processes.own_rows` names.
        """
        own = processes.own_rows(count)
        values = part if isinstance(part, torch.Tensor) else np.asarray(part)
        real = not values.is_complex() if isinstance(values, torch.Tensor) else values.dtype.kind in "fiu"
        if not real or values.ndim != 2 or values.shape[0] != own.stop - own.start:
            allowed = (
                f"an array of real numbers of {own.stop - own.start} rows, {own.start} to {own.stop - 1} of {count}"
            )
            raise rc.InputError.about(f"The part of process {processes.rank}", part, allowed)
        if isinstance(values, torch.Tensor):
            return cls(values.to(processes.device, torch.float64, copy=True), processes, count)
        return cls(torch.tensor(values, dtype=torch.float64, device=processes.device), processes, count)

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of entries along each axis: of a field on all processes, of a list on this one."""
        own = tuple(self.tensor.shape)
        return own if self.tensor.ndim < 2 else (self.rows, *own[1:])

    @property
    def size(self) -> int:
        """Number of entries; see `shape`."""
        return int(np.prod(self.shape, dtype=np.int64))

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, out: Any = (), **options: Any) -> Any:
        """Carry a ufunc out on the parts."""
        if method == "__call__":
            return super().__array_ufunc__(ufunc, method, *inputs, out=out, **options)
        if method != "reduce" or ufunc not in _REDUCTIONS or options.pop("axis", 0) is not None:
            raise _unknown(f"{ufunc.__name__}.{method}")
        return self._reduced(super().__array_ufunc__(ufunc, method, *inputs, axis=None, **options), _REDUCTIONS[ufunc])

    def __array_function__(self, function: Any, types: Any, args: Any, options: Any) -> Any:
        """Carry a function of numpy out on the parts."""
        if function not in (*_LOCAL, *_SUMS):
            raise _unknown(function.__name__)
        found = super().__array_function__(function, types, args, options)
        return self._reduced(found, "sum") if function in _SUMS else found

    def __getitem__(self, index: Any) -> TensorArray:
        whole = isinstance(index, slice) and index.indices(self.rows) == (0, self.rows, 1)
        if not whole and not isinstance(index, SlabTensor):
            raise _unknown("ndarray.__getitem__ but for masks")
        return super().__getitem__(index)

    def __len__(self) -> int:
        return self.shape[0]

    @property
    def T(self) -> TensorArray:  # noqa: N802 - as numpy names it
        """Refuse: rows would become columns."""
        raise _unknown("transpose")

    def sum(self) -> TensorArray:
        """Return the sum."""
        return self._reduced(super().sum(), "sum")

    def mean(self) -> TensorArray:
        """Return the mean of a field."""
        mean: Any = self.sum() / self.size
        return TensorArray(mean.tensor)

    def std(self) -> TensorArray:
        """Refuse: `ContactConditions` takes the sum of squares."""
        raise _unknown("std")

    def min(self, initial: Any = None) -> TensorArray:
        """Return the minimum."""
        return self._reduced(super().min(np.inf if initial is None else initial), "lowest")

    def max(self, initial: Any = None) -> TensorArray:
        """Return the maximum."""
        return self._reduced(super().max(-np.inf if initial is None else initial), "highest")

    def any(self, axis: int | None = None) -> TensorArray:
        """Return whether any entry is true."""
        if axis is not None:
            raise _unknown("any of an axis")
        count: Any = np.count_nonzero(cast(Any, self))
        return TensorArray(count.tensor > 0)

    def all(self) -> TensorArray:
        """Return whether all entries are true."""
        return TensorArray(~(~self).any().tensor)

    def _like(self, tensor: torch.Tensor) -> TensorArray:
        return SlabTensor(tensor, self.processes, self.rows) if tensor.ndim else TensorArray(tensor)

    def _reduced(self, own: Any, operation: str) -> TensorArray:
        """Return a number of all processes from those of each."""
        return TensorArray(self.processes.reduce(own.tensor.clone(), operation))


def _unknown(name: str) -> rc.InputError:
    return rc.InputError(
        f"Fields on slabs have no numpy.{name}: gather the solution, or take the `tensor` of a process."
    )
