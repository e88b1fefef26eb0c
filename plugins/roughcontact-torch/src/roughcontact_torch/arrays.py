"""Tensors that follow numpy's protocols, so that text written for numpy's arrays works on them."""

from __future__ import annotations

from typing import Any, NoReturn

import numpy as np
import numpy.typing as npt
import torch
from numpy.lib.mixins import NDArrayOperatorsMixin

from roughcontact_torch import functions, ufuncs
from roughcontact_torch.kinds import numpy_dtype, torch_dtype


class TensorArray(NDArrayOperatorsMixin):
    """A tensor behind the names of a numpy array.

    Views, types and promotion are numpy's; sums are rounded as torch rounds them. What is not listed in `functions`
    or `ufuncs` raises `TypeError`: nothing leaves the device until it is asked for as a number. A reduction
    therefore returns an array without axes.

    Attributes
    ----------
    tensor
        The tensor.
    """

    __slots__ = ("tensor",)

    def __init__(self, tensor: torch.Tensor) -> None:
        self.tensor = tensor

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of entries along each axis."""
        return tuple(self.tensor.shape)

    @property
    def size(self) -> int:
        """Number of entries."""
        return self.tensor.numel()

    @property
    def ndim(self) -> int:
        """Number of axes."""
        return self.tensor.ndim

    @property
    def dtype(self) -> np.dtype[Any]:
        """Type of the entries, as numpy names it."""
        return numpy_dtype(self.tensor.dtype)

    @property
    def T(self) -> TensorArray:  # noqa: N802 - as numpy names it
        """The transposed array, a view."""
        return TensorArray(self.tensor.mT)

    def __array_ufunc__(
        self, ufunc: np.ufunc, method: str, *inputs: Any, out: tuple[TensorArray, ...] = (), **options: Any
    ) -> Any:
        """Carry a ufunc out on tensors."""
        operands = tuple(self._tensor_of(one) for one in inputs)
        options = {name: self._tensor_of(value) for name, value in options.items()}
        if ufunc is np.divmod:
            return tuple(self.__array_ufunc__(part, method, *inputs) for part in (np.floor_divide, np.remainder))
        target = out[0] if out else None
        found = ufuncs.carry_out(
            ufunc, method, operands, self.tensor.device, None if target is None else target.tensor, **options
        )
        return self._like(found) if target is None else target

    def __array_function__(self, function: Any, types: Any, args: Any, options: Any) -> Any:
        """Carry a function of numpy out on tensors."""
        out = options.get("out")
        args = tuple(self._tensor_of(one) for one in args)
        options = {name: self._tensor_of(value) for name, value in options.items()}
        found = functions.carry_out(function, self.tensor.device, args, options)
        if out is not None:
            return out
        if isinstance(found, tuple):
            return tuple(self._like(part) for part in found)
        return self._like(found) if isinstance(found, torch.Tensor) else found

    def __array__(self, dtype: npt.DTypeLike | None = None, copy: bool | None = None) -> NoReturn:
        """Refuse: numpy would go on with a copy in silence."""
        raise TypeError("A tensor becomes an array of numpy by PreparedConvolution.to_numpy alone.")

    def __getitem__(self, index: Any) -> TensorArray:
        return self._like(self.tensor[self._tensor_of(index)])

    def __setitem__(self, index: Any, values: Any) -> None:
        values = self._tensor_of(values)
        if isinstance(index, slice) and isinstance(values, torch.Tensor):
            target = self.tensor[index]
            # What was changed in place need not be copied to itself.
            if target.data_ptr() != values.data_ptr() or target.stride() != values.stride():
                target.copy_(values)
        else:
            self.tensor[self._tensor_of(index)] = values

    def __len__(self) -> int:
        return len(self.tensor)

    def __bool__(self) -> bool:
        return bool(self.tensor)

    def __int__(self) -> int:
        return int(self.tensor)

    def __float__(self) -> float:
        return float(self.tensor)

    def __repr__(self) -> str:
        return f"TensorArray({self.tensor!r})"

    def ravel(self) -> TensorArray:
        """Return the entries along one axis, a view if possible."""
        return self._like(self.tensor.reshape(-1))

    def reshape(self, *shape: Any) -> TensorArray:
        """Return the entries in another shape, a view if possible."""
        return self._like(self.tensor.reshape(*shape))

    def astype(self, dtype: npt.DTypeLike, copy: bool = True) -> TensorArray:
        """Return the entries in another type."""
        return self._like(self.tensor.to(torch_dtype(dtype), copy=copy))

    def copy(self) -> TensorArray:
        """Return a contiguous copy."""
        return self._like(self.tensor.clone(memory_format=torch.contiguous_format))

    def take(self, places: Any, mode: str = "raise", out: TensorArray | None = None) -> TensorArray:
        """Return the entries at places of the flat array, all of them within it."""
        target = None if out is None else out.tensor
        found = torch.index_select(self.tensor.reshape(-1), 0, self._tensor_of(places), out=target)
        return self._like(found) if out is None else out

    def sum(self) -> TensorArray:
        """Return the sum."""
        return self._like(self.tensor.sum())

    def mean(self) -> TensorArray:
        """Return the mean."""
        return self._like(self.tensor.mean())

    def std(self) -> TensorArray:
        """Return the standard deviation of all entries."""
        return self._like(self.tensor.std(correction=0))

    def min(self, initial: Any = None) -> TensorArray:
        """Return the minimum."""
        return self._like(ufuncs.reduce(np.minimum, self.tensor, None, initial=self._tensor_of(initial)))

    def max(self, initial: Any = None) -> TensorArray:
        """Return the maximum."""
        return self._like(ufuncs.reduce(np.maximum, self.tensor, None, initial=self._tensor_of(initial)))

    def any(self, axis: int | None = None) -> TensorArray:
        """Return whether any entry is true."""
        return self._like(self.tensor.any() if axis is None else self.tensor.any(axis))

    def all(self) -> TensorArray:
        """Return whether all entries are true."""
        return self._like(self.tensor.all())

    def _like(self, tensor: torch.Tensor) -> TensorArray:
        """Return an array of this kind."""
        return TensorArray(tensor)

    def _tensor_of(self, value: Any) -> Any:
        """Return a value with each array inside as a tensor on this device."""
        if isinstance(value, TensorArray):
            return value.tensor
        if isinstance(value, np.ndarray):
            # Torch warns of arrays that are read-only.
            return torch.as_tensor(value if value.flags.writeable else value.copy(), device=self.tensor.device)
        if isinstance(value, (tuple, list)):
            return tuple(self._tensor_of(one) for one in value)
        return value
