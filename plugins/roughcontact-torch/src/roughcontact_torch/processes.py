"""The processes of a solve on several devices, the rows of each, and what they send each other."""

from __future__ import annotations

import atexit
import contextlib
import math
import os
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import roughcontact as rc
import torch
import torch.distributed as distributed
from roughcontact.solving import available_memory

from roughcontact_torch.convolver import TorchFFT
from roughcontact_torch.kinds import Tensors

_OPERATIONS = {
    "sum": distributed.ReduceOp.SUM,
    "highest": distributed.ReduceOp.MAX,
    "lowest": distributed.ReduceOp.MIN,
}


class Processes(Tensors):
    """The processes that `torchrun` has started, each with a device, which solve one contact.

    Each calls the same functions in the same order, and gets the same numbers. A program without `torchrun` is one.

    Parameters
    ----------
    device
        ``"cpu"``, ``"cuda"``, or ``"auto"``: CUDA where torch finds it. Processes of one machine take its GPUs in turn.

    Raises
    ------
    InputError
        If there are fewer GPUs than processes on this machine, or none.

    Attributes
    ----------
    rank, count
        The number of this process, from zero on, and of all.
    device
        The device of this process.
    reductions, exchanges, sent
        Reductions and broadcasts, exchanges of parts of fields, and the bytes that these sent to other processes.
    """

    name = "roughcontact_torch"

    def __init__(self, device: str = "auto") -> None:
        super().__init__(_choose_device(device))
        started = int(os.environ.get("WORLD_SIZE", "1"))
        if started > 1 and not distributed.is_initialized():
            _connect(self.device)
        connected = distributed.is_initialized()
        self.rank = distributed.get_rank() if connected else 0
        self.count = distributed.get_world_size() if connected else 1
        self.exchanges = 0

    def require(self, shape: tuple[int, int]) -> None:
        """Raise `InputError` unless each process gets rows and columns of a grid."""
        most = min(self.coarsest_rows(shape[0]), shape[0] // 2 + 1, shape[1] // 2 + 1)
        if self.count > most:
            raise rc.InputError.about(f"The processes for {shape[0]} x {shape[1]} cells", self.count, f"at most {most}")

    def end(self, status: int) -> None:
        """End this process with an exit status, the others by `torchrun`, whose status is then 1."""
        if self.count == 1:
            super().end(status)
        # What other processes wait for would hold up the end of this one.
        os._exit(status)

    def memory_left(self) -> float:
        """Return the memory left for this process on its device, bytes; of processors that of the machine is shared."""
        if self.device.type == "cuda":
            return float(torch.cuda.mem_get_info(self.device)[0])
        left = available_memory()
        return math.inf if left is None else left / int(os.environ.get("LOCAL_WORLD_SIZE", "1"))

    def reduce(self, values: torch.Tensor, operation: str = "sum") -> torch.Tensor:
        """Return the sum of a tensor over all processes, or its ``"highest"`` or ``"lowest"`` values; it is changed."""
        self.reductions += 1
        if self.count > 1:
            with _talking():
                distributed.all_reduce(values, _OPERATIONS[operation])
        return values

    def collect(self, value: Any) -> np.ndarray:
        """Return a number or an array of numpy of each process, of one shape on all, shape (count, ...)."""
        own = self.place(np.asarray(value))
        found = own.new_zeros((self.count, *own.shape))
        found[self.rank] = own
        return self.reduce(found).numpy(force=True)

    def publish(self, values: torch.Tensor) -> torch.Tensor:
        """Return the tensor of the first process; all have one of this shape, which is changed."""
        self.reductions += 1
        if self.count > 1:
            values = values.contiguous()
            with _talking():
                distributed.broadcast(values, 0)
        return values

    def exchange(self, values: torch.Tensor, counts: Sequence[int], expected: Sequence[int]) -> torch.Tensor:
        """Return what all processes send to this one, flat, in their order; see `SlabProcesses.exchange`."""
        self.exchanges += 1
        if self.count == 1:
            return values
        self.sent += values.element_size() * (sum(counts) - counts[self.rank])
        found = values.new_empty(sum(expected))
        numbers = torch.view_as_real if values.is_complex() else torch.Tensor.contiguous
        with _talking():
            distributed.all_to_all_single(numbers(found), numbers(values), list(expected), list(counts))
        return found


def _choose_device(name: str) -> torch.device:
    """Return the device of this process."""
    place = TorchFFT(name).place
    if place.type == "cpu":
        return place
    number = int(os.environ.get("LOCAL_RANK", "0"))
    if number >= torch.cuda.device_count():
        raise rc.InputError(
            f"Each process needs a GPU of its own, and this machine has {torch.cuda.device_count()}: start as many "
            "processes here by --nproc-per-node, or choose the device 'cpu'."
        )
    torch.cuda.set_device(number)
    return torch.device("cuda", number)


def _connect(device: torch.device) -> None:
    """Let this process talk to the others: by NCCL from GPU to GPU, else by gloo."""
    with _talking():
        if device.type == "cuda":
            distributed.init_process_group("nccl", device_id=device)
        else:
            distributed.init_process_group("gloo")
    atexit.register(_disconnect)


def _disconnect() -> None:
    if distributed.is_initialized():
        distributed.destroy_process_group()


@contextlib.contextmanager
def _talking() -> Iterator[None]:
    """Say what an error of torch means while processes talk to each other."""
    try:
        yield
    except RuntimeError as error:
        raise rc.UnexpectedError(f"The other processes cannot be reached, or one has ended: {error}") from error
