"""Iterations as a CUDA graph: the host launches all kernels of an iteration at once."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any, cast

import torch

from roughcontact_torch.masked_descent import State

Work = Callable[[], None]


class GraphedIteration:
    """An iteration on buffers of its own, recorded at the first call and replayed from then on.

    A recorded iteration reads and writes the memory that it had when it was recorded. The state that a call returns
    lies in the buffers until the next call.

    Parameters
    ----------
    iterate
        Return the state after an iteration; fixed shapes, and no number is read.
    record
        Return a function that repeats the work given; it may also do the work.
    """

    def __init__(self, iterate: Callable[[State], State], record: Callable[[Work], Work]) -> None:
        self._iterate = iterate
        self._record = record
        self._buffers: State | None = None
        self._replay: Work | None = None

    def __call__(self, state: State) -> State:
        """Return the state after an iteration."""
        if self._buffers is None or self._replay is None:
            # Some fields of a state are one tensor.
            self._buffers = State(*(value.clone() for value in state))
            self._replay = self._record(self._step)
        self._fill(state)
        self._replay()
        return self._buffers

    def _step(self) -> None:
        assert self._buffers is not None
        self._fill(self._iterate(self._buffers))

    def _fill(self, state: State) -> None:
        assert self._buffers is not None
        for buffer, value in zip(self._buffers, state, strict=True):
            if value is not buffer:
                buffer.copy_(value)


def record_graph(work: Work) -> Work:
    """Return the replay of work on a GPU, recorded on a stream of its own after the work was done once there."""
    stream = _stream(torch.cuda.current_device())
    stream.wait_stream(torch.cuda.current_stream())
    graph = torch.cuda.CUDAGraph()
    with torch.cuda.stream(stream):
        # Libraries choose their plans and take their memory, which cannot be recorded.
        work()
        graph.capture_begin(capture_error_mode="thread_local")
        try:
            work()
        finally:
            graph.capture_end()
    torch.cuda.current_stream().wait_stream(stream)
    return graph.replay


@cache
def _stream(device: int) -> torch.cuda.Stream:
    """Return the stream of all records on a device: they share the memory that torch keeps for it."""
    # Torch gives its constructor no types.
    make: Any = torch.cuda.Stream
    return cast(torch.cuda.Stream, make(device))
