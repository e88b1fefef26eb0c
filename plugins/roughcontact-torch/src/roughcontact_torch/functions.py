"""Numpy's functions on tensors."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import torch

from roughcontact_torch.kinds import Operand, as_operand, promoted, torch_dtype
from roughcontact_torch.ufuncs import carry_out as carry_out_ufunc
from roughcontact_torch.ufuncs import reduce

_DOTS = ("i,i->", "ij,ij->")


def carry_out(function: Any, device: torch.device, args: Sequence[Any], options: dict[str, Any]) -> Any:
    """Return the result of a function.

    Raises
    ------
    TypeError
        If tensors have no such function.
    """
    if function in _CREATORS:
        return _CREATORS[function](device, *args, **options)
    if function not in _FUNCTIONS:
        raise TypeError(f"Tensors have no numpy.{function.__name__}.")
    return _FUNCTIONS[function](*args, **options)


def _creator(make: Callable[..., torch.Tensor]) -> Callable[..., torch.Tensor]:
    def create(place: torch.device, shape: Any, dtype: Any = float, **_: Any) -> torch.Tensor:
        return make(shape, dtype=torch_dtype(dtype), device=place)

    return create


def _like(make: Callable[..., torch.Tensor]) -> Callable[..., torch.Tensor]:
    def create(values: torch.Tensor, dtype: Any = None) -> torch.Tensor:
        return make(values, dtype=None if dtype is None else torch_dtype(dtype))

    return create


def _asarray(place: torch.device, values: Any, dtype: Any = None) -> torch.Tensor:
    return torch.as_tensor(values, dtype=None if dtype is None else torch_dtype(dtype), device=place)


_CREATORS: dict[Any, Callable[..., torch.Tensor]] = {
    np.zeros: _creator(torch.zeros),
    np.ones: _creator(torch.ones),
    np.empty: _creator(torch.empty),
    np.full: lambda place, shape, value, **_: torch.full(shape, value, dtype=torch.float64, device=place),
    np.arange: lambda place, *limits: torch.arange(*limits, dtype=torch.int64, device=place),
    np.asarray: _asarray,
}
# Functions that torch has under another name, or with other names of their arguments.
_FUNCTIONS: dict[Any, Callable[..., Any]] = {
    np.zeros_like: _like(torch.zeros_like),
    np.ones_like: _like(torch.ones_like),
    np.empty_like: _like(torch.empty_like),
    np.roll: lambda values, shift, axis: torch.roll(values, shift, axis),
    np.sum: lambda values, where=True: reduce(np.add, values, None, where=where),
    np.count_nonzero: lambda values: torch.count_nonzero(values),
    np.flatnonzero: lambda values: torch.nonzero(values.reshape(-1)).reshape(-1),
    np.array_equal: torch.equal,
    np.concatenate: lambda parts: torch.cat(tuple(parts)),
    np.stack: lambda parts, axis=0: torch.stack(tuple(parts), dim=axis),
    np.split: lambda values, starts: torch.tensor_split(values, tuple(starts.tolist())),
    np.broadcast_to: lambda values, shape: values.expand(shape),
    np.moveaxis: torch.moveaxis,
    np.repeat: lambda values, repeats, axis=None: torch.repeat_interleave(values, repeats, dim=axis),
    np.searchsorted: torch.searchsorted,
    np.partition: lambda values, place: torch.sort(values).values,
}


def _listed(function: Any) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    def enter(ours: Callable[..., Any]) -> Callable[..., Any]:
        _FUNCTIONS[function] = ours
        return ours

    return enter


@_listed(np.where)
def _where(mask: torch.Tensor, one: Operand, other: Operand) -> torch.Tensor:
    dtype = promoted((one, other))
    return torch.where(mask, as_operand(one, dtype, mask.device), as_operand(other, dtype, mask.device))


@_listed(np.clip)
def _clip(values: torch.Tensor, low: Any, high: Any, out: torch.Tensor | None = None) -> torch.Tensor:
    bounded = carry_out_ufunc(np.maximum, "__call__", (values, low), values.device)
    return carry_out_ufunc(np.minimum, "__call__", (bounded, high), values.device, out)


@_listed(np.copyto)
def _copyto(target: torch.Tensor, values: Any, where: torch.Tensor | bool = True) -> None:
    values = as_operand(values, target.dtype, target.device)
    target.copy_(torch.where(where, values, target) if isinstance(where, torch.Tensor) else values)


@_listed(np.einsum)
def _einsum(sums: str, *factors: torch.Tensor, dtype: Any = None, casting: str = "safe") -> torch.Tensor:
    if sums not in _DOTS:
        raise TypeError(f"Tensors have numpy.einsum for {' and '.join(_DOTS)} alone.")
    common = promoted(factors) if dtype is None else torch_dtype(dtype)
    one, other = (values.to(common).reshape(-1) for values in factors)
    return torch.dot(one, other)


@_listed(np.diff)
def _diff(values: torch.Tensor, prepend: int | None = None) -> torch.Tensor:
    return torch.diff(values, prepend=None if prepend is None else values.new_tensor([prepend]))


@_listed(np.take)
def _take(values: torch.Tensor, places: torch.Tensor, axis: int | None = None) -> torch.Tensor:
    return torch.index_select(values.reshape(-1) if axis is None else values, axis or 0, places)


@_listed(np.bincount)
def _bincount(numbers: torch.Tensor, weights: torch.Tensor, minlength: int) -> torch.Tensor:
    """Return the sums of weights over equal numbers, all of them below `minlength`: their maximum is not asked for."""
    sums = torch.zeros(minlength, dtype=torch.float64, device=weights.device)
    return sums.index_add_(0, numbers, weights.to(torch.float64))
