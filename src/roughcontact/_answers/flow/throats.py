"""The critical throat of a flow through a gap."""

from __future__ import annotations

import math

import attrs
import numpy as np

from roughcontact._answers.flow.flow_network import FlowNetwork
from roughcontact._base.checks import Array, Mask, Pair, RealArray
from roughcontact._base.units import si
from roughcontact._parts.grid import Grid

# Cells of large loss that are looked at.
_CANDIDATES = 50


@attrs.frozen
class Throat:
    """The place where the flow through a gap loses most power over a length, in a square of its own width.

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
    fraction
        Part of the power that is lost, and so of the pressure drop of this path, in a square of that width.
    """

    place: Pair
    gap: float
    width: float
    cells: float
    fraction: float

    def __str__(self) -> str:
        x, y = (si(value, "m", 3) for value in self.place)
        return (
            f"throat at ({x}, {y}), gap {si(self.gap, 'm', 3)}, {self.cells:.3g} cells across, "
            f"{100 * self.fraction:.2g} % of the loss"
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
    along, across = grid.spacing if axis == 0 else grid.spacing[::-1]
    field = np.zeros(network.shape)
    field.reshape(-1)[network.cells] = lost
    left = field.copy()
    total = float(lost.sum())
    best = (-1.0, 0.0, (0, 0), 0.0, 0.0)
    for _ in range(_CANDIDATES):
        i, j = divmod(int(np.argmax(left)), network.shape[1])
        width, cells = _measure_width(open_cells, (i, j), along, across, periodic=periodic)
        square = _square_around((i, j), math.ceil(0.5 * cells), network.shape, periodic=periodic)
        fraction = float(field[square].sum()) / total
        best = max(best, (fraction / width, fraction, (i, j), width, cells))
        left[square] = 0.0
    _, fraction, (i, j), width, cells = best
    place = (i, j) if axis == 0 else (j, i)
    position = int(np.searchsorted(network.cells, i * network.shape[1] + j))
    return Throat(
        place=(float(grid.x[place[0], 0]), float(grid.y[0, place[1]])),
        gap=float(network.film[position]) * network.widest,
        width=width,
        cells=cells,
        fraction=fraction,
    )


def _measure_width(
    open_cells: Mask, at: tuple[int, int], along: float, across: float, *, periodic: bool
) -> tuple[float, float]:
    """Return the shortest of four lines through a cell from contact to contact: its length, and the same in cells."""
    diagonal = math.hypot(along, across)
    widths = []
    for step, length, cells in (
        ((1, 0), along, 1.0),
        ((0, 1), across, 1.0),
        ((1, 1), diagonal, math.sqrt(2.0)),
        ((1, -1), diagonal, math.sqrt(2.0)),
    ):
        both = step, (-step[0], -step[1])
        count = 1 + sum(_count_open(open_cells, at, one, periodic=periodic) for one in both)
        # Around a periodic domain a cell is met from both sides.
        count = min(count, max(open_cells.shape))
        widths.append((count * length, count * cells))
    return min(widths)


def _square_around(
    at: tuple[int, int], reach: int, shape: tuple[int, int], *, periodic: bool
) -> tuple[RealArray, RealArray]:
    """Return the indices of the cells up to `reach` cells away."""
    rows = np.arange(max(at[0] - reach, 0), min(at[0] + reach + 1, shape[0]))
    columns = np.arange(at[1] - reach, at[1] + reach + 1)
    columns = np.unique(columns % shape[1]) if periodic else columns[(columns >= 0) & (columns < shape[1])]
    return rows[:, np.newaxis], columns


def _count_open(open_cells: Mask, start: tuple[int, int], step: tuple[int, int], *, periodic: bool) -> int:
    """Return the number of open cells from a cell, without it, along a direction."""
    nx, ny = open_cells.shape
    i, j = start
    count = 0
    while count < max(nx, ny):
        i = i + step[0]
        j = j + step[1]
        j = j % ny if periodic else j
        if not (0 <= i < nx and 0 <= j < ny and open_cells[i, j]):
            break
        count += 1
    return count
