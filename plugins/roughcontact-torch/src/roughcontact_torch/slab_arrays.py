"""Tensors of which each process has some rows."""

from __future__ import annotations

from typing import Any, Self

import numpy as np
import roughcontact as rc
import torch
from roughcontact.slabs import SlabArray

from roughcontact_torch.arrays import TensorArray
from roughcontact_torch.processes import Processes


class SlabTensor(SlabArray):
    """A field of which each process has some rows on its device, as a `TensorArray`."""

    __slots__ = ()

    @classmethod
    def field(cls, part: Any, processes: Processes, count: int) -> Self:
        """Return a field of `count` rows on the devices from the rows of this process, an array of numpy or a tensor.

        Raises
        ------
        InputError
            If the rows are not those that `Processes.own_rows` names.
        """
        if isinstance(part, TensorArray):
            return super().field(part, processes, count)
        own = processes.own_rows(count)
        values = part if isinstance(part, torch.Tensor) else np.asarray(part)
        real = not values.is_complex() if isinstance(values, torch.Tensor) else values.dtype.kind in "fiu"
        if not real or values.ndim != 2 or values.shape[0] != own.stop - own.start:
            allowed = (
                f"an array of real numbers of {own.stop - own.start} rows, {own.start} to {own.stop - 1} of {count}"
            )
            raise rc.InputError.about(f"The part of process {processes.rank}", part, allowed)
        if isinstance(values, torch.Tensor):
            placed = values.to(processes.device, torch.float64, copy=True)
        else:
            placed = torch.tensor(values, dtype=torch.float64, device=processes.device)
        return super().field(TensorArray(placed), processes, count)

    def gather(self) -> np.ndarray | None:
        """Return all rows of a field as an array of numpy on the first process; None on the others."""
        rows = self.processes.gather_rows(self.tensor, self.shape[0], first=True)
        return None if rows is None else rows.numpy(force=True)

    @property
    def tensor(self) -> torch.Tensor:
        """The part of this process."""
        found: torch.Tensor = self.part.tensor
        return found
