"""The tops of creased summits between the cells: where smooth faces meet, as of shot-peened and turned surfaces."""

from __future__ import annotations

import numpy as np

from roughcontact._base.arrays import Array, Mask

# Cells on each side of a summit in which faces are sought, and those around it that they must show.
_FACE_REACH = 4
_SHOWN_REACH = 2
# Cells on each side of a summit that are needed: the change of a curvature takes two more.
CREASE_REACH = _FACE_REACH + 2
# Largest second difference of a face, and its change to the next cell, over the largest at a summit: a face is smooth,
# and a round summit has no faces. With a change of 0.05 some cones have them; turned and shot-peened surfaces have no
# more and no fewer with 0.02.
_MAX_BEND = 0.5
_MAX_TURN = 0.01
# Misfit of the heights around a summit by its faces, over that second difference, at most.
_MAX_MISFIT = 0.2
# Places from a cell to the next ones along both axes where the faces are compared, in cells, and how many times finer
# they are compared around the highest.
_PLACES = np.stack(np.meshgrid(*2 * [np.linspace(-1.0, 1.0, 17)], indexing="ij")).reshape(2, -1)
_FINER = 8.0
# Cells in which faces are sought, and those that they must show, from the summit.
_FACES, _SHOWN = (
    np.mgrid[-reach : reach + 1, -reach : reach + 1].reshape(2, -1).astype(np.float64)
    for reach in (_FACE_REACH, _SHOWN_REACH)
)


def find_creased_tops(near: Array) -> tuple[Array, Mask]:
    r"""Return the gap at the top of creased summits, m, and which summits are creased, both of shape (count,).

    Heights that meet in creases are the lowest of smooth faces, which each goes on beyond its crease:

    .. math:: z(\mathbf{r}) = \min_k z_k(\mathbf{r}), \qquad z_\mathrm{top} = \max_\mathbf{r} \min_k z_k(\mathbf{r})

    with the quadratics :math:`z_k` of all cells beside the summit whose second differences hardly change to the next
    cells. The summit is creased if the same faces give the heights of the cells around it.

    Parameters
    ----------
    near
        Gap around summits, m, shape (count, 2 CREASE_REACH + 1, 2 CREASE_REACH + 1).
    """
    faces, sharpest = _find_faces(near)
    shown = _inside(near, _SHOWN_REACH).reshape(len(near), -1)
    misfit = np.abs(_follow(faces, np.broadcast_to(_SHOWN[:, np.newaxis], (2, *shown.shape))) - shown).max(axis=1)
    creased = misfit < _MAX_MISFIT * sharpest
    top = np.full(len(near), np.inf)
    top[creased] = _find_tops(faces[:, creased])
    return top, creased


def _find_tops(faces: Array) -> Array:
    """Return the smallest of the largest gaps of all faces within a cell from the summits, m."""
    place = np.zeros((2, faces.shape[1], 1))
    for step in (1.0, 1.0 / _FINER):
        places = place + step * _PLACES[:, np.newaxis]
        gap = _follow(faces, places)
        place = places[:, np.arange(len(gap)), gap.argmin(axis=1), np.newaxis]
    return np.asarray(gap.min(axis=1))


def _find_faces(near: Array) -> tuple[Array, Array]:
    """Return the quadratics of faces, shape (6, count, cells), and the largest second difference at each summit, m.

    They are the gap, its slopes along x and y, and its second derivatives xx, yy and xy, per cell; where there is no
    face the gap is minus infinity.
    """
    here = near[:, 1:-1, 1:-1]
    slope_x = 0.5 * (near[:, 2:, 1:-1] - near[:, :-2, 1:-1])
    slope_y = 0.5 * (near[:, 1:-1, 2:] - near[:, 1:-1, :-2])
    bend_x = near[:, 2:, 1:-1] - 2.0 * here + near[:, :-2, 1:-1]
    bend_y = near[:, 1:-1, 2:] - 2.0 * here + near[:, 1:-1, :-2]
    twist = 0.25 * (near[:, 2:, 2:] + near[:, :-2, :-2] - near[:, 2:, :-2] - near[:, :-2, 2:])
    sharpest = np.maximum(*(_inside(bend, 1).max(axis=(1, 2)) for bend in (bend_x, bend_y)))
    bends = np.stack((bend_x, bend_y, 2.0 * twist))
    turns = np.zeros(here.shape)
    for axis in (1, 2):
        change = np.moveaxis(np.abs(np.diff(bends, axis=axis + 1)).max(axis=0), axis, 0)
        along = np.moveaxis(turns, axis, 0)
        along[:-1] = np.maximum(along[:-1], change)
        along[1:] = np.maximum(along[1:], change)
    largest = sharpest[:, np.newaxis, np.newaxis]
    smooth = (np.abs(bends).max(axis=0) < _MAX_BEND * largest) & (turns < _MAX_TURN * largest)
    parts = (np.where(smooth, here, -np.inf), slope_x, slope_y, bend_x, bend_y, twist)
    return np.stack([_inside(part, _FACE_REACH).reshape(len(near), -1) for part in parts]), sharpest


def _inside(field: Array, reach: int) -> Array:
    """Return the cells up to so many from the middle of windows."""
    beyond = field.shape[1] // 2 - reach
    return field[:, beyond:-beyond, beyond:-beyond]


def _follow(faces: Array, places: Array) -> Array:
    """Return the largest gap of all faces at places, shape (2, count, places), in cells from the summit."""
    gap, slope_x, slope_y, bend_x, bend_y, twist = faces[..., np.newaxis]
    x, y = places[:, :, np.newaxis] - _FACES[:, np.newaxis, :, np.newaxis]
    face = gap + x * (slope_x + 0.5 * bend_x * x + twist * y) + y * (slope_y + 0.5 * bend_y * y)
    return np.asarray(face.max(axis=1))
