"""Numpy's functions on tensors."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import torch

from roughcontact_torch.kinds import Operand, as_operand, promoted, torch_dtype
from roughcontact_torch.ufuncs import carry_out as carry_out_ufunc
from roughcontact_torch.ufuncs import reduce

_FUNCTIONS: dict[Any, Callable[..., Any]] = {}
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


def _listed(function: Any) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    def enter(ours: Callable[..., Any]) -> Callable[..., Any]:
        _FUNCTIONS[function] = ours
        return ours

    return enter


def _zeros(place: torch.device, shape: Any, dtype: Any = float) -> torch.Tensor:
    return torch.zeros(shape, dtype=torch_dtype(dtype), device=place)


def _ones(place: torch.device, shape: Any, dtype: Any = float, **_: Any) -> torch.Tensor:
    return torch.ones(shape, dtype=torch_dtype(dtype), device=place)


def _empty(place: torch.device, shape: Any, dtype: Any = float) -> torch.Tensor:
    return torch.empty(shape, dtype=torch_dtype(dtype), device=place)


def _full(place: torch.device, shape: Any, value: float, **_: Any) -> torch.Tensor:
    return torch.full(shape, value, dtype=torch.float64, device=place)


def _arange(place: torch.device, *limits: int) -> torch.Tensor:
    return torch.arange(*limits, dtype=torch.int64, device=place)


def _asarray(place: torch.device, values: Any, dtype: Any = None) -> torch.Tensor:
    return torch.as_tensor(values, dtype=None if dtype is None else torch_dtype(dtype), device=place)


_CREATORS: dict[Any, Callable[..., torch.Tensor]] = {
    np.zeros: _zeros,
    np.ones: _ones,
    np.empty: _empty,
    np.full: _full,
    np.arange: _arange,
    np.asarray: _asarray,
}


@_listed(np.zeros_like)
def _zeros_like(values: torch.Tensor, dtype: Any = None) -> torch.Tensor:
    return torch.zeros_like(values, dtype=None if dtype is None else torch_dtype(dtype))


@_listed(np.ones_like)
def _ones_like(values: torch.Tensor, dtype: Any = None) -> torch.Tensor:
    return torch.ones_like(values, dtype=None if dtype is None else torch_dtype(dtype))


@_listed(np.empty_like)
def _empty_like(values: torch.Tensor, dtype: Any = None) -> torch.Tensor:
    return torch.empty_like(values, dtype=None if dtype is None else torch_dtype(dtype))


@_listed(np.roll)
def _roll(values: torch.Tensor, shift: int, axis: int) -> torch.Tensor:
    return torch.roll(values, shift, axis)


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


@_listed(np.sum)
def _sum(values: torch.Tensor, where: torch.Tensor | bool = True) -> torch.Tensor:
    return reduce(np.add, values, None, where=where)


@_listed(np.count_nonzero)
def _count_nonzero(values: torch.Tensor) -> torch.Tensor:
    return torch.count_nonzero(values)


@_listed(np.flatnonzero)
def _flatnonzero(values: torch.Tensor) -> torch.Tensor:
    return torch.nonzero(values.reshape(-1)).reshape(-1)


@_listed(np.array_equal)
def _array_equal(one: torch.Tensor, other: torch.Tensor) -> bool:
    return torch.equal(one, other)


@_listed(np.concatenate)
def _concatenate(parts: Sequence[torch.Tensor]) -> torch.Tensor:
    return torch.cat(tuple(parts))


@_listed(np.stack)
def _stack(parts: Sequence[torch.Tensor], axis: int = 0) -> torch.Tensor:
    return torch.stack(tuple(parts), dim=axis)


@_listed(np.split)
def _split(values: torch.Tensor, starts: torch.Tensor) -> tuple[torch.Tensor, ...]:
    return torch.tensor_split(values, tuple(starts.tolist()))


@_listed(np.broadcast_to)
def _broadcast_to(values: torch.Tensor, shape: Any) -> torch.Tensor:
    return values.expand(shape)


@_listed(np.moveaxis)
def _moveaxis(values: torch.Tensor, source: int, target: int) -> torch.Tensor:
    return torch.moveaxis(values, source, target)


@_listed(np.repeat)
def _repeat(values: torch.Tensor, repeats: Any, axis: int | None = None) -> torch.Tensor:
    return torch.repeat_interleave(values, repeats, dim=axis)


@_listed(np.diff)
def _diff(values: torch.Tensor, prepend: int | None = None) -> torch.Tensor:
    return torch.diff(values, prepend=None if prepend is None else values.new_tensor([prepend]))


@_listed(np.searchsorted)
def _searchsorted(values: torch.Tensor, places: torch.Tensor) -> torch.Tensor:
    return torch.searchsorted(values, places)


@_listed(np.partition)
def _partition(values: torch.Tensor, place: int) -> torch.Tensor:
    return torch.sort(values).values


@_listed(np.take)
def _take(values: torch.Tensor, places: torch.Tensor, axis: int | None = None) -> torch.Tensor:
    return torch.index_select(values.reshape(-1) if axis is None else values, axis or 0, places)


@_listed(np.bincount)
def _bincount(numbers: torch.Tensor, weights: torch.Tensor, minlength: int) -> torch.Tensor:
    """Return the sums of weights over equal numbers, all of them below `minlength`: their maximum is not asked for."""
    sums = torch.zeros(minlength, dtype=torch.float64, device=weights.device)
    return sums.index_add_(0, numbers, weights.to(torch.float64))
