"""Numpy's ufuncs on tensors."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import torch

from roughcontact_torch.kinds import Operand, as_number, as_operand, promoted, torch_dtype

_ELEMENTWISE: dict[np.ufunc, Callable[..., torch.Tensor]] = {
    np.add: torch.add,
    np.subtract: torch.sub,
    np.multiply: torch.mul,
    np.divide: torch.true_divide,
    np.floor_divide: torch.floor_divide,
    np.remainder: torch.remainder,
    np.power: torch.pow,
    np.negative: torch.neg,
    np.absolute: torch.abs,
    np.sqrt: torch.sqrt,
    np.exp: torch.exp,
    np.isfinite: torch.isfinite,
    np.maximum: torch.maximum,
    np.minimum: torch.minimum,
    np.greater: torch.gt,
    np.greater_equal: torch.ge,
    np.less: torch.lt,
    np.less_equal: torch.le,
    np.equal: torch.eq,
    np.not_equal: torch.ne,
    np.bitwise_and: torch.bitwise_and,
    np.bitwise_or: torch.bitwise_or,
    np.bitwise_xor: torch.bitwise_xor,
    np.invert: torch.bitwise_not,
    np.matmul: torch.matmul,
}
# Those in which the operands may change places, and those that torch has under another name where one is a number.
_SYMMETRIC = {torch.add, torch.mul, torch.maximum, torch.minimum}
_WITH_NUMBER: dict[Callable[..., torch.Tensor], Callable[..., torch.Tensor]] = {
    torch.maximum: torch.clamp_min,
    torch.minimum: torch.clamp_max,
}
# Reductions: what an entry that does not count is replaced by, and the reduction, of all entries or along an axis.
_REDUCTIONS: dict[np.ufunc, tuple[float, Callable[..., torch.Tensor]]] = {
    np.add: (0.0, torch.sum),
    np.minimum: (np.inf, torch.amin),
    np.maximum: (-np.inf, torch.amax),
}


def carry_out(
    ufunc: np.ufunc,
    method: str,
    operands: tuple[Any, ...],
    device: torch.device,
    out: torch.Tensor | None = None,
    **options: Any,
) -> torch.Tensor:
    """Return the result of a ufunc, or of its method ``reduce`` or ``reduceat``; it is written to `out` if given.

    Raises
    ------
    TypeError
        If tensors have no such ufunc.
    """
    if method == "__call__" and ufunc in _ELEMENTWISE:
        return _apply(_ELEMENTWISE[ufunc], operands, device, out, **options)
    if method == "reduce" and ufunc in _REDUCTIONS:
        return _put(reduce(ufunc, *operands, **options), out)
    if method == "reduceat" and ufunc is np.add:
        return _put(_add_ranges(*operands, **options), out)
    raise TypeError(f"Tensors have no numpy.{ufunc.__name__}.{method}.")


def reduce(
    ufunc: np.ufunc,
    values: torch.Tensor,
    axis: int | None = 0,
    dtype: Any = None,
    *,
    where: torch.Tensor | bool = True,
    initial: Any = None,
) -> torch.Tensor:
    """Return a sum, minimum or maximum of the entries that count, from an initial value."""
    neutral, function = _REDUCTIONS[ufunc]
    if isinstance(where, torch.Tensor):
        values = torch.where(where, values, neutral)
    if axis is None or values.ndim == 1:
        axis = 0
        values = values.reshape(-1)
    if initial is not None and values.shape[axis] == 0:
        return values.new_full(values.shape[:axis] + values.shape[axis + 1 :], initial)
    found = function(values, axis) if dtype is None else function(values, axis, dtype=torch_dtype(dtype))
    return found if initial is None else _ELEMENTWISE[ufunc](found, as_operand(initial, found.dtype, found.device))


def _apply(
    function: Callable[..., torch.Tensor],
    operands: tuple[Operand, ...],
    device: torch.device,
    out: torch.Tensor | None = None,
    *,
    where: torch.Tensor | bool = True,
    dtype: Any = None,
    casting: str = "same_kind",
) -> torch.Tensor:
    """Return the result for each entry."""
    computed = promoted(operands) if dtype is None else torch_dtype(dtype)
    if function is torch.true_divide and not computed.is_floating_point:
        computed = torch.float64
    function, values = _prepare(function, operands, computed, device)
    if out is not None and where is True and out.dtype in (computed, torch.bool):
        return function(*values, out=out)
    found = function(*values)
    if out is not None and isinstance(where, torch.Tensor):
        found = torch.where(where, found, out)
    return _put(found if dtype is None else found.to(computed), out)


def _prepare(
    function: Callable[..., torch.Tensor], operands: tuple[Operand, ...], computed: torch.dtype, device: torch.device
) -> tuple[Callable[..., torch.Tensor], list[Any]]:
    """Return a function of torch and its arguments: tensors of one type, and at most one number, the second."""
    if len(operands) == 2 and function in _SYMMETRIC and not isinstance(operands[0], torch.Tensor):
        operands = operands[::-1]
    first = as_operand(operands[0], computed, device)
    if len(operands) == 1:
        return function, [first]
    second = operands[1]
    if not isinstance(second, torch.Tensor):
        return _WITH_NUMBER.get(function, function), [first, as_number(second)]
    # Torch multiplies by masks as they are.
    masked = second.dtype is torch.bool and function is torch.mul
    return function, [first, second if masked else as_operand(second, computed, device)]


def _add_ranges(values: torch.Tensor, starts: torch.Tensor, axis: int = 0) -> torch.Tensor:
    """Return the sums over ranges of an axis from each start, the first zero, to the next one."""
    ranges = values.movedim(axis, 0)
    lengths = torch.diff(starts, append=starts.new_tensor([ranges.shape[0]]))
    # Ranges are summed along the first axis only, and over memory in order.
    return torch.segment_reduce(ranges.contiguous(), "sum", lengths=lengths, axis=0).movedim(0, axis)


def _put(values: torch.Tensor, out: torch.Tensor | None) -> torch.Tensor:
    return values if out is None else out.copy_(values)
