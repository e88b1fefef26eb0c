"""The patches of a contact on slabs: labelled on each slab, and merged along its borders."""

from __future__ import annotations

from functools import cached_property

import attrs
import numpy as np
import roughcontact as rc
from roughcontact.results import ContactPatches
from roughcontact.slabs import SlabArray
from roughcontact.solving import find_patches
from roughcontact.typing import Array, IntArray, RealArray
from scipy import sparse

from roughcontact_mpi.parts import Part

# Cells of the largest patch that one process has as a whole: larger ones are not taken for single summits of Hertz.
WHOLE_PATCH_CELLS = 36


@attrs.frozen(eq=False)
class SlabPatches:
    """Patches of a contact on slabs: cells that share a side or a corner, also across slabs and a periodic border.

    All but the labels are the same on all processes.

    Attributes
    ----------
    count
        Number of patches.
    cells
        Number of cells of each patch, shape (count,).
    areas
        Counted area of each patch, shape (count,), m2.
    forces
        Normal force on each patch, shape (count,), N.
    labels
        Number of the patch at each cell, from 1, and zero at open cells, shape (nx, ny).
    """

    count: int
    cells: IntArray = attrs.field(repr=False)
    areas: Array = attrs.field(repr=False)
    forces: Array = attrs.field(repr=False)
    labels: SlabArray = attrs.field(repr=False)


@attrs.frozen(eq=False)
class WindowPatches(ContactPatches):
    """The patches as the estimators of one machine take them: labels of the window, members of this process."""

    part: Part
    public: SlabPatches

    @cached_property
    def cells(self) -> IntArray:
        """Number of cells of each patch, on all processes."""
        return self.part.total(np.bincount(self.member_labels, minlength=self.count + 1)[1:])

    def _sum(self, field: Array) -> Array:
        return self.part.total(super()._sum(field))


def label_slabs(
    part: Part, pressure: SlabArray, grid: rc.Grid, boundary: rc.Boundary
) -> tuple[SlabArray, IntArray, int]:
    """Return the labels of the patches, in the order of their first cells, the own cells in contact, and the number."""
    rows = np.ascontiguousarray(pressure.part)
    touching = np.zeros(0, dtype=np.intp)
    own = touching
    if (rows > 0.0).any():
        apart = rc.Boundary.FREE if boundary.free_axes[1] else rc.Boundary.FREE_PERIODIC
        found = find_patches(rows > 0.0, rows, grid, apart)
        touching = found.members
        own = found.member_labels
    counts = part.processes.collect(int(own.max(initial=0)))
    own = own + int(counts[: part.processes.rank].sum())
    count = int(counts.sum())
    labels = np.zeros(rows.shape, dtype=np.intp)
    labels.ravel()[touching] = own
    one, other = part.join(_list_pairs(part, labels, periodic=not boundary.free_axes[1])).astype(np.intp) - 1
    links = sparse.coo_matrix((np.ones(one.size), (one, other)), shape=(max(count, 1), max(count, 1)))
    pieces = sparse.csgraph.connected_components(links, directed=False)[1][:count]
    # In the order of their first parts, as those of one machine.
    _, first, inverse = np.unique(pieces, return_index=True, return_inverse=True)
    number = np.empty(first.size, dtype=np.intp)
    number[np.argsort(first)] = np.arange(1, first.size + 1)
    labels.ravel()[touching] = number[inverse][own - 1]
    return SlabArray.field(labels, part.processes, grid.shape[0]), touching, int(first.size)


def _list_pairs(part: Part, labels: IntArray, *, periodic: bool) -> IntArray:
    """Return the labels of cells of the last row beside those of the next process, shape (2, n)."""
    count = part.shape[0]
    wanted = []
    for rank in range(part.processes.count):
        start, stop = part.bounds[rank : rank + 2]
        last = start == stop or (part.free and stop == count)
        wanted.append([] if last else [stop % count])
    beyond = part.processes.fetch_rows(labels, part.bounds, wanted)
    if not len(beyond):
        return np.zeros((2, 0), dtype=np.intp)
    pairs = []
    for step in (-1, 0, 1):
        here = labels[-1]
        there = np.roll(beyond[0], step)
        touching = (here > 0) & (there > 0)
        if step and not periodic:
            touching[0 if step == 1 else -1] = False
        pairs.append(np.stack((here[touching], there[touching])))
    return np.unique(np.concatenate(pairs, axis=1), axis=1)


def window_patches(
    part: Part,
    labels: SlabArray,
    touching: IntArray,
    count: int,
    pressure: RealArray,
    grid: rc.Grid,
    boundary: rc.Boundary,
) -> WindowPatches:
    """Return the patches for the estimators; each cell is a member on one process, small patches as a whole."""
    ny = grid.shape[1]
    inside = part.inside
    window = part.read(labels)
    own = labels.part.ravel()[touching]
    first = np.full(count + 1, grid.cells, dtype=np.intp)
    np.minimum.at(first, own, touching + part.start * ny)
    first = part.lowest(first)
    cells = part.total(np.bincount(own, minlength=count + 1))
    loads = np.bincount(own, weights=pressure[inside].ravel()[touching], minlength=count + 1).astype(np.float64)
    forces = np.asarray(part.total(loads)[1:] * grid.cell_area)
    areas = np.asarray(cells[1:] * grid.cell_area, dtype=np.float64)
    public = SlabPatches(count, cells[1:], areas, forces, labels)
    beside = np.flatnonzero(window[: inside.start]), np.flatnonzero(window[inside.stop :]) + inside.stop * ny
    members = np.concatenate((beside[0], touching + inside.start * ny, beside[1]))
    label = window.ravel()[members]
    row = members // ny
    begin = first[label] // ny
    # Small patches are with the process of their first cell, each cell once, by the shorter way around.
    step = part.window[row] - begin
    if not part.free:
        step = step - part.shape[0] * np.round(step / part.shape[0]).astype(np.intp)
    whole = (begin >= part.start) & (begin < part.stop) & (row == inside.start + begin - part.start + step)
    mine = np.where(cells[label] <= WHOLE_PATCH_CELLS, whole, (row >= inside.start) & (row < inside.stop))
    return WindowPatches(grid, boundary, pressure, window, count, members[mine], part, public)
