"""The surface interface."""

from __future__ import annotations

import abc
from collections.abc import Sequence
from typing import TYPE_CHECKING, Protocol, runtime_checkable

from roughcontact.checks import Array, Mask, Pair, pair
from roughcontact.grid import Grid

if TYPE_CHECKING:
    from roughcontact.surfaces.sum import SurfaceSum


class Surface(abc.ABC):
    """A rough surface. Subclass it and say the heights on a grid."""

    @abc.abstractmethod
    def heights(self, grid: Grid) -> Array:
        """Return the heights at the cell centres, shape `grid.shape`, m, positive outward.

        Raises
        ------
        InputError
            If the surface is not known on this grid.
        """

    def __add__(self, other: Surface) -> SurfaceSum:
        """Return the surface whose heights are the sum of both."""
        from roughcontact.surfaces.sum import SurfaceSum

        if not isinstance(other, Surface):
            return NotImplemented
        return SurfaceSum((self, other))


@runtime_checkable
class Gridded(Protocol):
    """A surface that carries a grid of its own, or may do so."""

    @property
    def grid(self) -> Grid | None:
        """The grid on which the heights are known; None for any grid."""


@runtime_checkable
class Told(Protocol):
    """A surface that tells what was done to it."""

    @property
    def history(self) -> tuple[str, ...]:
        """What was done, in words, first things first."""


@runtime_checkable
class Holed(Protocol):
    """A surface that knows where it was not measured."""

    def holes_on(self, grid: Grid) -> Mask | None:
        """Return which cells are holes, shape `grid.shape`; None if none is."""


def holes_of(surface: Surface, grid: Grid) -> Mask | None:
    """Return which cells of a surface are holes, shape `grid.shape`; None if it knows of none."""
    return surface.holes_on(grid) if isinstance(surface, Holed) else None


def history_of(surface: Surface) -> tuple[str, ...]:
    """Return what was done to a surface, in words; empty if it does not tell."""
    return surface.history if isinstance(surface, Told) else ()


def own_grid(surface: Surface) -> Grid | None:
    """Return the grid that a surface carries, if it does."""
    return surface.grid if isinstance(surface, Gridded) else None


def centre_point(value: float | Sequence[float]) -> Pair:
    """Check the position of a summit, m."""
    return pair(value, "The centre", "m")
