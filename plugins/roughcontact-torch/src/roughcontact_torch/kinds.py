"""Types of numpy and torch for each other, and the type of a result by numpy's rules."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, ClassVar, TypeAlias

import numpy as np
import numpy.typing as npt
import torch
from roughcontact.slabs import SlabProcesses

_NUMPY: dict[torch.dtype, np.dtype[Any]] = {
    torch.bool: np.dtype(np.bool_),
    torch.int32: np.dtype(np.int32),
    torch.int64: np.dtype(np.int64),
    torch.float32: np.dtype(np.float32),
    torch.float64: np.dtype(np.float64),
}
_TORCH = {dtype: known for known, dtype in _NUMPY.items()}

# Parts in which the columns of a padded grid are transformed: more save little memory.
_PARTS = 4

Operand: TypeAlias = torch.Tensor | np.generic | bool | int | float


def numpy_dtype(dtype: torch.dtype) -> np.dtype[Any]:
    """Return numpy's name of a type."""
    return _NUMPY[dtype]


def torch_dtype(dtype: npt.DTypeLike) -> torch.dtype:
    """Return torch's name of a type."""
    return _TORCH[np.dtype(dtype)]


def promoted(operands: tuple[Operand, ...]) -> torch.dtype:
    """Return the type in which numpy computes: numbers of Python's do not raise it, those of numpy's do."""
    strong = set()
    weak = set()
    for one in operands:
        if isinstance(one, torch.Tensor):
            strong.add(one.dtype)
        elif isinstance(one, np.generic):
            strong.add(_TORCH[one.dtype])
        else:
            weak.add(type(one))
    dtype = strong.pop() if len(strong) == 1 else _TORCH[np.result_type(*(_NUMPY[one] for one in strong))]
    if float in weak and not dtype.is_floating_point:
        return torch.float64
    return torch.int64 if int in weak and dtype is torch.bool else dtype


def as_operand(value: Operand, dtype: torch.dtype, device: torch.device) -> torch.Tensor:
    """Return an operand as a tensor of a type."""
    if isinstance(value, torch.Tensor):
        return value if value.dtype is dtype else value.to(dtype)
    return torch.scalar_tensor(as_number(value), dtype=dtype, device=device)


def as_number(value: np.generic | float) -> float:
    """Return a number as one of Python's."""
    number: float = value.item() if isinstance(value, np.generic) else value
    return number


class Tensors(SlabProcesses):
    """A process whose slabs are tensors on a device.

    Parameters
    ----------
    device
        The device.
    """

    library: ClassVar[Any] = torch
    max_exchanges: ClassVar[int] = 1

    def __init__(self, device: torch.device) -> None:
        self.device = device

    @property
    def transforms(self) -> Any:
        """The Fourier transforms of tensors."""
        return torch.fft

    def place(self, values: np.ndarray) -> torch.Tensor:
        """Return an array of numpy as a tensor on the device."""
        return torch.tensor(values, device=self.device)

    def empty(self, shape: int | tuple[int, ...], like: torch.Tensor | None = None) -> torch.Tensor:
        """Return a new tensor of the type of another one; by default float64."""
        return torch.empty(shape, dtype=torch.float64 if like is None else like.dtype, device=self.device)

    def tiles(self, whole: slice, most: int) -> Iterator[slice]:
        """Yield a range at once: kernels on a GPU are few and large, or their start takes the time."""
        yield whole

    def tiles_of_columns(self, whole: slice, *, padded: bool) -> Iterator[slice]:
        """Yield a few parts of columns that are padded, which takes memory, or the whole."""
        yield from super().tiles(whole, -(-(whole.stop - whole.start) // _PARTS)) if padded else (whole,)
