"""Numpy's functions on arrays in slabs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from roughcontact._base.arrays import RealArray
from roughcontact.errors import InputError
from roughcontact.errors.door import guarded

_FUNCTIONS: dict[Any, Callable[..., Any]] = {}
# What a reduction of no entries gives.
_IDENTITIES: dict[Any, float] = {np.add: 0.0, np.minimum: np.inf, np.maximum: -np.inf}


def unknown(name: str) -> InputError:
    """Return the error for a step that arrays in slabs do not have."""
    return InputError(
        f"Fields on slabs have no numpy.{name}, which contacts of thin stiff layers need: solve the contact in one "
        "process, by rc.ContactProblem, or gather its solution."
    )


def is_slab(value: Any) -> bool:
    """Return whether a value is an array in slabs."""
    return getattr(value, "is_slab", False)


def leader(values: Sequence[Any]) -> Any:
    """Return the array that says how a result is divided: of those in slabs a divided one with most axes."""
    slabs = [one for one in values if is_slab(one)]
    return max(slabs, key=lambda one: (one.is_divided, one.ndim))


def part_of(value: Any, lead: Any) -> Any:
    """Return the part of a value for a result that is divided as another array is."""
    if is_slab(value):
        if lead.is_divided and not value.is_divided and value.size > 1:
            raise unknown("broadcast")
        return value.part
    if isinstance(value, np.ndarray) and value.size > 1 and lead.is_divided:
        raise unknown("broadcast")
    return value


def carry_out(function: Any, caller: Any, args: Sequence[Any], options: dict[str, Any]) -> Any:
    """Return the result of a function; `InputError` if arrays in slabs have no such function."""
    if function in _LOCAL:
        return _carry_out_on_parts(function, args, options)
    if function in _CREATORS:
        return _create(function, caller, *args, **options)
    if function not in _FUNCTIONS:
        raise unknown(function.__name__)
    return _FUNCTIONS[function](*args, **options)


def reduce(
    ufunc: np.ufunc,
    values: Any,
    axis: int | None = 0,
    dtype: Any = None,
    *,
    where: Any = True,
    initial: Any = None,
) -> Any:
    """Return a sum, minimum or maximum over all processes."""
    if axis is not None and values.ndim > 1:
        raise unknown(f"{ufunc.__name__}.reduce")
    part = values.part
    options: dict[str, Any] = {} if dtype is None else {"dtype": dtype}
    if where is not True:
        options["where"] = part_of(where, values)
    if ufunc is not np.add or initial is not None:
        options["initial"] = _IDENTITIES[ufunc] if initial is None else initial
    if part.dtype.kind in "iub" and ufunc is not np.add:
        raise unknown(f"{ufunc.__name__}.reduce")
    own = ufunc.reduce(part, axis=None, **options)
    if not values.is_divided:
        return own
    found = ufunc.reduce(values.processes.collect(np.float64(float(own))))
    return own.dtype.type(found)


@guarded
def gather_slabs(values: Any) -> Any:
    """Return the whole of an array as one of numpy, on each process."""
    if not values.is_divided:
        return values.part
    return values.processes.gather(values.part.reshape(-1)).reshape(-1, *values.part.shape[1:])


def get(values: Any, index: Any) -> Any:
    """Return the entries at an index; see `put`."""
    cells = _local(values, index)
    if cells is None:
        return _get_window(values, index)
    found = values.part[cells]
    if not values.is_divided:
        return values.like(found)
    if is_slab(index):
        # A list of places has the length of what is found, a mask does not.
        return index.like(found) if index.dtype.kind in "iu" else _new_list(values, found)
    if isinstance(index, np.ndarray):
        return _new_list(values, found)
    return _divided(values, found, _length_after(values, index))


def put(values: Any, index: Any, given: Any) -> None:
    """Set the entries at an index: of places or a mask, of a slice along the first axis in full or of every second."""
    cells = _local(values, index)
    if cells is None:
        _put_window(values, index, given)
        return
    part = given.part if is_slab(given) else given
    if isinstance(part, np.ndarray) and isinstance(cells, slice):
        target = values.part[cells]
        # What was changed in place need not be copied to itself.
        if target.ctypes.data == part.ctypes.data and target.strides == part.strides and target.shape == part.shape:
            return
    values.part[cells] = part


def _local(values: Any, index: Any) -> Any:
    """Return an index in the part of this process; None for a window, whose rows have to move."""
    if is_slab(index):
        return index.part
    if isinstance(index, np.ndarray):
        if values.is_divided and index.size:
            raise unknown("take")
        return index
    if not values.is_divided:
        return index
    if isinstance(index, tuple) and len(index) == values.ndim:
        rows = index[0]
        return (_local(values, rows), *index[1:]) if _is_simple(values, rows) else None
    if not isinstance(index, slice):
        raise unknown("take")
    if not _is_simple(values, index):
        raise unknown("take")
    return slice(None) if index.step in (None, 1) else index


def _is_simple(values: Any, rows: Any) -> bool:
    """Return whether a slice takes all rows, or every second one."""
    if not isinstance(rows, slice):
        return False
    if rows.step == 2 and rows.stop is None:
        return rows.start in (None, 0, 1)
    return rows.step in (None, 1) and rows.start in (None, 0) and (rows.stop is None or rows.stop >= values.shape[0])


def _length_after(values: Any, index: Any) -> int:
    rows = index[0] if isinstance(index, tuple) else index
    return len(range(*rows.indices(values.shape[0])))


def _divided(values: Any, part: RealArray, length: int) -> Any:
    if part.shape[1:] == values.part.shape[1:] and length == values.shape[0]:
        return values.like(part)
    return type(values).field(part, values.processes, length)


def _new_list(values: Any, part: RealArray) -> Any:
    return type(values).list(part, values.processes)


def _window(values: Any, index: tuple[slice, slice]) -> tuple[tuple[int, ...], tuple[int, ...], int]:
    """Return the bounds of the rows of a field, and those of a window, in rows of the field, with its rows."""
    start, stop, step = index[0].indices(values.shape[0])
    if step != 1:
        raise unknown("take")
    processes = values.processes
    inside = tuple(start + bound for bound in processes.rows(stop - start))
    return processes.rows(values.shape[0]), inside, stop - start


def _get_window(values: Any, index: tuple[slice, slice]) -> Any:
    bounds, inside, count = _window(values, index)
    part = values.processes.move_rows(values.part[:, index[1]], bounds, inside)
    return type(values).field(part, values.processes, count)


def _put_window(values: Any, index: tuple[slice, slice], given: Any) -> None:
    bounds, inside, _ = _window(values, index)
    processes = values.processes
    rows = processes.move_rows(given.part, inside, bounds)
    first = max(bounds[processes.rank], inside[0]) - bounds[processes.rank]
    values.part[first : first + rows.shape[0], index[1]] = rows


def _create(function: Any, caller: Any, shape: Any, *args: Any, **options: Any) -> Any:
    """Return a new field, or an array of one entry that all have."""
    if function is np.asarray:
        return _as_slab(caller, shape, *args, **options)
    if not isinstance(shape, tuple) or len(shape) == 1:
        raise unknown(function.__name__)
    if not shape:
        return type(caller)(function(shape, *args, **options), caller.processes, None)
    own = caller.processes.own_rows(shape[0])
    part = function((own.stop - own.start, *shape[1:]), *args, **options)
    return type(caller).field(part, caller.processes, shape[0])


def _as_slab(caller: Any, values: Any, dtype: Any = None) -> Any:
    if is_slab(values):
        return values if dtype is None else values.astype(dtype, copy=False)
    return type(caller)(np.asarray(values, dtype=dtype), caller.processes, None)


_CREATORS = {np.zeros, np.ones, np.empty, np.full, np.asarray}
_LOCAL = {np.zeros_like, np.ones_like, np.empty_like, np.where, np.clip, np.copyto}


def _carry_out_on_parts(function: Any, args: Sequence[Any], options: dict[str, Any]) -> Any:
    """Return the result of a function of each entry alone."""
    lead = leader((*args, *options.values()))
    parts = [part_of(one, lead) for one in args]
    found = function(*parts, **{name: part_of(value, lead) for name, value in options.items()})
    if function is np.copyto:
        return None
    return lead.like(found) if options.get("out") is None else options["out"]


def _listed(function: Any) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    def enter(ours: Callable[..., Any]) -> Callable[..., Any]:
        _FUNCTIONS[function] = ours
        return ours

    return enter


@_listed(np.einsum)
def _einsum(sums: str, one: Any, other: Any, dtype: Any = None, casting: Any = "safe") -> Any:
    if sums not in ("i,i->", "ij,ij->"):
        raise unknown("einsum")
    options = {} if dtype is None else {"dtype": dtype, "casting": casting}
    own = np.einsum(sums, part_of(one, other), part_of(other, one), **options)
    return one.processes.total(np.float64(float(own))) if one.is_divided else own


@_listed(np.sum)
def _sum(values: Any, where: Any = True) -> Any:
    return reduce(np.add, values, None, where=where)


@_listed(np.count_nonzero)
def _count_nonzero(values: Any) -> int:
    own = int(np.count_nonzero(values.part))
    return int(values.processes.total(own) if values.is_divided else own)


@_listed(np.flatnonzero)
def _flatnonzero(values: Any) -> Any:
    return _new_list(values, np.flatnonzero(values.part))


@_listed(np.array_equal)
def _array_equal(one: Any, other: Any) -> bool:
    return not (one != other).any()


@_listed(np.concatenate)
def _concatenate(parts: Sequence[Any]) -> Any:
    lead = leader(parts)
    if len(parts) == 1:
        return lead
    return _new_list(lead, np.concatenate([part_of(one, lead) for one in parts]))


@_listed(np.broadcast_to)
def _broadcast_to(values: Any, shape: tuple[int, ...]) -> Any:
    if values.is_divided:
        return values
    own = values.processes.own_rows(shape[0])
    part = np.broadcast_to(values.part, (own.stop - own.start, *shape[1:]))
    return type(values).field(part, values.processes, shape[0])


@_listed(np.repeat)
def _repeat(values: Any, repeats: int, axis: int | None = None) -> Any:
    part = np.repeat(values.part, repeats, axis=axis)
    return type(values).field(part, values.processes, values.shape[0] * (1 if axis else repeats))


@_listed(np.roll)
def _roll(values: Any, shift: int, axis: int) -> Any:
    if axis == 1:
        return values.like(np.roll(values.part, shift, axis=1))
    if shift not in (-1, 1):
        raise unknown("roll")
    wide = values.processes.widen(values.part, values.shape[0], 1)
    return values.like(wide[:-2] if shift == 1 else wide[2:])
