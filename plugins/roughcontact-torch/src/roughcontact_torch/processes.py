"""The processes of a solve on several devices, the rows of each, and what they send each other."""

from __future__ import annotations

import atexit
import contextlib
import itertools
import math
import os
from collections.abc import Iterator, Sequence

import numpy as np
import roughcontact as rc
import torch
import torch.distributed as distributed
from roughcontact.solving import SlabProcesses, available_memory

from roughcontact_torch.convolver import TorchFFT

_OPERATIONS = {
    "sum": distributed.ReduceOp.SUM,
    "highest": distributed.ReduceOp.MAX,
    "lowest": distributed.ReduceOp.MIN,
}
_NAMES: dict[np.ufunc, str] = {np.add: "sum", np.maximum: "highest", np.minimum: "lowest"}


class Processes(SlabProcesses):
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
        self.device = _choose_device(device)
        started = int(os.environ.get("WORLD_SIZE", "1"))
        if started > 1 and not distributed.is_initialized():
            _connect(self.device)
        connected = distributed.is_initialized()
        self.rank = distributed.get_rank() if connected else 0
        self.count = distributed.get_world_size() if connected else 1
        self.reductions = 0
        self.exchanges = 0
        self.sent = 0

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

    def total(self, values: np.ndarray | float) -> np.ndarray:
        """Return the sum of a number or an array of numpy over all processes."""
        return self.reduce(torch.tensor(values, device=self.device)).numpy(force=True)

    def across(self, ufunc: np.ufunc, value: float) -> float:
        """Return the sum, the minimum or the maximum of a number over all processes."""
        own = torch.tensor(value, dtype=torch.float64, device=self.device)
        return float(self.reduce(own, _NAMES[ufunc]))

    def publish(self, values: torch.Tensor) -> torch.Tensor:
        """Return the tensor of the first process; all have one of this shape, which is changed."""
        self.reductions += 1
        if self.count > 1:
            values = values.contiguous()
            with _talking():
                distributed.broadcast(values, 0)
        return values

    def exchange(self, values: torch.Tensor, counts: Sequence[int], expected: Sequence[int]) -> torch.Tensor:
        """Return what all processes send to this one, flat, in their order.

        Parameters
        ----------
        values
            What this process sends, flat, in the order of the receivers.
        counts, expected
            Entries to and from each process.
        """
        self.exchanges += 1
        if self.count == 1:
            return values
        self.sent += values.element_size() * (sum(counts) - counts[self.rank])
        found = values.new_empty(sum(expected))
        numbers = torch.view_as_real if values.is_complex() else torch.Tensor.contiguous
        with _talking():
            distributed.all_to_all_single(numbers(found), numbers(values), list(expected), list(counts))
        return found

    def gather_rows(self, values: torch.Tensor, count: int, *, first: bool = False) -> torch.Tensor | None:
        """Return all rows of fields, shape (..., count, ny), on each process, or on the first one alone.

        Parameters
        ----------
        values
            The rows of this process.
        count
            Rows of the domain.
        first
            Whether the others get None.
        """
        heights = [stop - start for start, stop in itertools.pairwise(self.rows(count))]
        width = values.numel() // values.shape[-2]
        readers = 1 if first else self.count
        reads = self.rank < readers
        sent = values.reshape(-1).repeat(readers)
        counts = [values.numel() if rank < readers else 0 for rank in range(self.count)]
        found = self.exchange(sent, counts, [height * width if reads else 0 for height in heights])
        if not reads:
            return None
        parts = torch.split(found, [height * width for height in heights])
        shape = values.shape
        rows = [part.view(*shape[:-2], height, shape[-1]) for part, height in zip(parts, heights, strict=True)]
        return torch.cat(rows, -2)

    def widen(self, values: torch.Tensor, reach: int, *, periodic: bool) -> torch.Tensor:
        """Return fields with rows of the neighbours before and behind those of this process.

        Parameters
        ----------
        values
            Shape (..., n, ny).
        reach
            Rows on either side, at most those of any process.
        periodic
            Whether the rows of the last process lie before those of the first one, or zeros.
        """
        neighbours = {"before": (self.rank - 1) % self.count, "behind": (self.rank + 1) % self.count}
        first = values[..., :reach, :]
        last = values[..., -reach:, :]
        # Of two processes each is before and behind the other: their last rows, which lie before, go first.
        sent = sorted(((neighbours["behind"], last), (neighbours["before"], first)), key=lambda pair: pair[0])
        size = first.numel()
        counts = [size * list(neighbours.values()).count(rank) for rank in range(self.count)]
        found = torch.split(self.exchange(torch.cat([part.reshape(-1) for _, part in sent]), counts, counts), size)
        sides = sorted(neighbours, key=lambda side: neighbours[side])
        rows = {side: part.view(first.shape) for side, part in zip(sides, found, strict=True)}
        if not periodic and self.rank == 0:
            rows["before"] = torch.zeros_like(first)
        if not periodic and self.rank == self.count - 1:
            rows["behind"] = torch.zeros_like(first)
        return torch.cat((rows["before"], values, rows["behind"]), -2)


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
