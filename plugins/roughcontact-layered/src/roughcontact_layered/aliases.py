"""Waves of pressure that is constant on each cell, with all their aliases, whose sum is smooth and found once."""

from __future__ import annotations

import math
from collections.abc import Hashable
from functools import lru_cache
from typing import Protocol

import numpy as np

from roughcontact_layered.stack import Array

# Aliases on each side that are summed as they are, and those behind them with the weights of Cohen, Rodriguez Villegas,
# Zagier (Exp. Math. 9 (2000) 3-12) for alternating series, of which the error falls as 5.8^-n.
_PLAIN = 4
_WEIGHTED = 18
# Chebyshev nodes in the logarithm of the wave number of the aliases, between pi and 45 pi over the side of a cell. For
# the poles of layers that are nearest to real wave numbers, at 30 degrees, the error falls as 1.32^-n: 4e-16.
_NODES_OF_ALIASES = 128
# Chebyshev nodes in the square of the phase along the axis of the aliases: the nearest singularity is that of the first
# alias where it is the mean, so that the error falls as 13.9^-n, or about 6^-n if poles of layers are nearer.
_NODES_ALONG = 22
# Logarithm of the error of the interpolation across them, of which a third is a reserve for poles of layers.
_LOG_ERROR = -54.0


class WaveResponse(Hashable, Protocol):
    """A kernel, of which a part is known in Fourier space."""

    def wave_rest(self, qx: Array, qy: Array) -> Array:
        """Return the part for wave vectors of shapes that broadcast, rad/m, even in both, m/Pa."""


def cell_waves(
    kernel: WaveResponse,
    qx: Array,
    qy: Array,
    spacing: tuple[float, float],
    aliased: tuple[WaveResponse, ...] | None = None,
) -> Array:
    """Return the part of a kernel at the cell centres by waves of cell pressures, shape (m, n), m/Pa.

    Parameters
    ----------
    kernel
        The kernel.
    qx, qy
        Wave numbers, shapes (m, 1) and (1, n), rad/m, at most half the sampling wave number.
    spacing
        Sides of a cell (dx, dy), m.
    aliased
        The parts whose aliases count, too; by default the kernel itself.
    """
    x, rows = np.unique(np.abs(qx).ravel() * spacing[0], return_inverse=True)
    y, columns = np.unique(np.abs(qy).ravel() * spacing[1], return_inverse=True)
    values = kernel.wave_rest((x / spacing[0])[:, np.newaxis], (y / spacing[1])[np.newaxis, :])
    values = values * _sinc(x)[:, np.newaxis] * _sinc(y)[np.newaxis, :]
    parts = (kernel,) if aliased is None else aliased
    if parts:
        from_x = _interpolate(x, spacing[1] / spacing[0])
        from_y = _interpolate(y, spacing[0] / spacing[1])
        at_nodes = np.sum([sum_aliases(part, spacing) for part in parts], axis=0)
        values += from_x @ at_nodes @ from_y.T
    return np.asarray(values[np.ix_(rows, columns)])


@lru_cache(maxsize=256)
def sum_aliases(kernel: WaveResponse, spacing: tuple[float, float]) -> Array:
    r"""Return the sum over all aliases of a wave but itself, at the nodes of `_interpolate` along x and along y.

    .. math:: \sum_{(m,n) \ne 0} f(q + Q_{mn})\,\operatorname{sinc}(\theta_x / 2 + \pi m)\,
              \operatorname{sinc}(\theta_y / 2 + \pi n)

    It does not depend on the waves of a grid, so that all that are asked of the same cells share it.

    Parameters
    ----------
    kernel
        The kernel, of which f is the part.
    spacing
        Sides of a cell (dx, dy), m.
    """
    dx, dy = spacing
    sums, phases = _sum_along()
    x = phases[:, np.newaxis] / dx
    y = phases[np.newaxis, :] / dy
    own_x = _list_across(dy / dx)[:, np.newaxis] / dx
    own_y = _list_across(dx / dy)[np.newaxis, :] / dy
    both = sums @ kernel.wave_rest(x, y) @ sums.T
    along_x = sums @ kernel.wave_rest(x, own_y)
    along_y = kernel.wave_rest(own_x, y) @ sums.T
    return np.block([[both, along_x], [along_y, np.zeros((own_x.size, own_y.size))]])


@lru_cache(maxsize=1)
def _sum_along() -> tuple[Array, Array]:
    """Return the matrix that sums a function over the aliases of each node along an axis, and the phases it takes."""
    weights = _weigh_alternating()
    orders = np.arange(1.0, weights.size + 1.0)
    nodes = np.pi * np.sqrt(_list_nodes(_NODES_ALONG))
    aliases = nodes[:, np.newaxis] + 2.0 * np.pi * np.concatenate((-orders[::-1], orders))
    factors = np.concatenate((weights[::-1], weights)) * _sinc(aliases)
    end = math.log(2.0 * weights.size + 1.0)
    places = np.log(np.abs(aliases) / np.pi) / end
    matrix = _interpolate_between(places.ravel(), _NODES_OF_ALIASES).reshape(*aliases.shape, _NODES_OF_ALIASES)
    return np.einsum("im,imk->ik", factors, matrix), np.pi * np.exp(end * _list_nodes(_NODES_OF_ALIASES))


def _weigh_alternating() -> Array:
    """Return the weights of the first terms of an alternating series, whose signs the terms have."""
    weights = np.ones(_PLAIN + _WEIGHTED)
    largest = 3.0 + math.sqrt(8.0)
    scale = 0.5 * (largest**_WEIGHTED + largest**-_WEIGHTED)
    term = -1.0
    rest = -scale
    for k in range(_WEIGHTED):
        rest = term - rest
        weights[_PLAIN + k] = (-1.0) ** k * rest / scale
        term *= (k + _WEIGHTED) * (k - _WEIGHTED) / ((k + 0.5) * (k + 1.0))
    return weights


def _interpolate(phases: Array, ratio: float) -> Array:
    """Return the matrix that takes sums at the nodes to phases, shape (phases, nodes).

    The nodes are those along the axis of the aliases, and then those across the aliases of the other axis, of which the
    phases have the factor of their own cell.

    Parameters
    ----------
    phases
        Phases per cell along an axis, 0 .. pi, shape (n,).
    ratio
        Side of a cell along the other axis over that along this one.
    """
    along = _interpolate_between((phases / np.pi) ** 2, _NODES_ALONG)
    places = (np.arcsinh(phases * (ratio / np.pi)) / math.asinh(ratio)) ** 2
    across = _interpolate_between(places, _count_across(ratio))
    return np.hstack((along, across * _sinc(phases)[:, np.newaxis]))


def _list_across(ratio: float) -> Array:
    r"""Return the phases of the nodes across the aliases of the other axis.

    With :math:`q = \pi / d\,\sinh u`, d the side along the other axis, the distance from its first alias is
    :math:`\pi / d\,\cosh u`, of which the singularities lie at :math:`\pm i \pi / 2` whatever the ratio of the sides.
    """
    end = math.asinh(ratio)
    return np.asarray(np.pi / ratio * np.sinh(end * np.sqrt(_list_nodes(_count_across(ratio)))))


def _count_across(ratio: float) -> int:
    nearest = 0.5 * np.pi / math.asinh(ratio)
    # Of an even function every second coefficient is zero.
    return math.ceil(0.5 * _LOG_ERROR / -math.asinh(nearest))


def _list_nodes(count: int) -> Array:
    """Return Chebyshev's nodes on 0 .. 1."""
    return np.asarray(0.5 * (1.0 + np.cos(_list_angles(count))))


def _list_angles(count: int) -> Array:
    return np.asarray(np.pi * (np.arange(count) + 0.5) / count)


def _interpolate_between(places: Array, count: int) -> Array:
    """Return the matrix that interpolates from the nodes to places, 0 .. 1, shape (places, count): barycentric."""
    weights = np.sin(_list_angles(count))
    weights[1::2] *= -1.0
    distances = places[:, np.newaxis] - _list_nodes(count)
    is_node = distances == 0.0
    distances[is_node] = 1.0
    matrix = weights / distances
    matrix /= matrix.sum(axis=1, keepdims=True)
    return np.where(is_node.any(axis=1, keepdims=True), is_node, matrix)


def _sinc(phases: Array) -> Array:
    """Return the amplitude of waves in unit pressure on one cell."""
    return np.asarray(np.sinc(phases / (2.0 * np.pi)))
