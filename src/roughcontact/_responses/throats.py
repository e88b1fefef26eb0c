"""The critical throat of a flow through a gap."""

from __future__ import annotations

import math

import attrs
import numpy as np

from roughcontact._responses.flow_network import FlowNetwork
from roughcontact.checks import Array, Mask, Pair
from roughcontact.grid import Grid
from roughcontact.units import si


@attrs.frozen
class Throat:
    """The place where the flow through a gap loses most power.

    Attributes
    ----------
    place
        Centre (x, y) of its cell, m; the origin is the centre of the domain.
    gap
        Gap there, m.
    width
        Width between the contacts on both sides, m: the shortest of four directions through the cell.
    cells
        The same in cells.
    share
        Part of the power that is lost, and so of the pressure drop of this path, in a square of that width.
    """

    place: Pair
    gap: float
    width: float
    cells: float
    share: float

    def __str__(self) -> str:
        x, y = (si(value, "m", 3) for value in self.place)
        return (
            f"throat at ({x}, {y}), gap {si(self.gap, 'm', 3)}, {self.cells:.3g} cells across, "
            f"{100 * self.share:.2g} % of the loss"
        )


def find_throat(
    network: FlowNetwork, lost: Array, open_cells: Mask, grid: Grid, axis: int, *, periodic: bool
) -> Throat:
    """Return the critical throat.

    Parameters
    ----------
    network, lost
        The network, and the power lost in each of its cells.
    open_cells
        Cells that are not in contact, shape (along, across) the flow.
    grid, axis
        The grid, and the axis of the flow.
    periodic
        Whether the gap repeats across the flow.
    """
    tightest = int(np.argmax(lost))
    i, j = divmod(int(network.cells[tightest]), network.shape[1])
    along, across = grid.spacing if axis == 0 else grid.spacing[::-1]
    diagonal, per_step = math.hypot(along, across), math.sqrt(2.0)
    widths = []
    for step, length, cells in (
        ((1, 0), along, 1.0),
        ((0, 1), across, 1.0),
        ((1, 1), diagonal, per_step),
        ((1, -1), diagonal, per_step),
    ):
        count = 1 + sum(
            _count_open(open_cells, (i, j), (sign * step[0], sign * step[1]), periodic=periodic) for sign in (1, -1)
        )
        # Around a periodic domain a cell is met from both sides.
        count = min(count, max(network.shape))
        widths.append((count * length, count * cells))
    width, cells = min(widths)
    place = (i, j) if axis == 0 else (j, i)
    return Throat(
        place=(float(grid.x[place[0], 0]), float(grid.y[0, place[1]])),
        gap=float(network.film[tightest]) * network.widest,
        width=width,
        cells=cells,
        share=_share(network, lost, (i, j), math.ceil(0.5 * cells), periodic=periodic),
    )


def _count_open(open_cells: Mask, start: tuple[int, int], step: tuple[int, int], *, periodic: bool) -> int:
    """Return the number of open cells from a cell, without it, along a direction."""
    (nx, ny), (i, j), count = open_cells.shape, start, 0
    while count < max(nx, ny):
        i, j = i + step[0], j + step[1]
        j = j % ny if periodic else j
        if not (0 <= i < nx and 0 <= j < ny and open_cells[i, j]):
            break
        count += 1
    return count


def _share(network: FlowNetwork, lost: Array, at: tuple[int, int], reach: int, *, periodic: bool) -> float:
    """Return the part of the loss in the square of cells up to `reach` cells away."""
    i, j = np.divmod(network.cells, network.shape[1])
    beside = np.abs(j - at[1])
    if periodic:
        beside = np.minimum(beside, network.shape[1] - beside)
    near = (np.abs(i - at[0]) <= reach) & (beside <= reach)
    return float(np.sum(lost, where=near) / np.sum(lost))
