"""The surface interface, sums of surfaces, and a surface as it is drawn."""

from __future__ import annotations

import abc
import dataclasses
from collections.abc import Callable, Iterable, Sequence
from typing import Any, ClassVar

import attrs
import numpy as np

from roughcontact._base.arrays import Array, Mask
from roughcontact._base.checks import Part, flag
from roughcontact._base.registry import Registry, arguments_of, find_view
from roughcontact._base.units import outlined
from roughcontact._parts.grid import Grid
from roughcontact._parts.surfaces.resampling import check_interpolation, shift_by_half_cell
from roughcontact.errors import InputError

# Difference of two evaluations of the same heights, over their range: rounding.
_HEIGHT_TOLERANCE = 1e-9


@attrs.frozen(eq=False)
class SampledSurface:
    """Heights of a surface on a grid, as a `Panel` of surfaces gets them.

    Attributes
    ----------
    heights
        Shape `grid.shape`, m, positive outward; NaN at non-measured points.
    grid
        The cells.
    periodic
        Whether the surface repeats beyond its border.
    """

    heights: Array = attrs.field(repr=outlined)
    grid: Grid
    periodic: bool

    @property
    def rms_height(self) -> float:
        """Root mean square of the measured heights about their mean, m."""
        return float(np.nanstd(self.heights))


class Surface(Part, abc.ABC):
    """A rough surface; a class of your own needs only `heights`.

    A surface may be made of others, its `parts`: by default the fields of an attrs class or a dataclass, or the
    attributes of a plain class, that hold a surface or a tuple of surfaces. It then has the grid, provenance,
    non-measured points and random seeds of its parts. This is right if its heights at a point follow from the heights
    of the parts there; a surface that moves or stretches others returns no `parts` and overrides what it needs.

    Attributes
    ----------
    is_random
        Whether the heights are those of one place of a rough surface, so that others differ: see `Estimate.sampling`.

    Examples
    --------
    >>> import roughcontact as rc
    >>> class Step(rc.Surface):
    ...     def heights(self, grid):
    ...         return 1e-6 * (grid.x > 0.0) + 0.0 * grid.y
    >>> print(Step().heights(rc.Grid((2, 2), 1e-6)).tolist())
    [[0.0, 0.0], [1e-06, 1e-06]]
    """

    is_random: ClassVar[bool] = False

    @abc.abstractmethod
    def heights(self, grid: Grid) -> Array:
        """Return the heights at the cell centres, shape `grid.shape`, m, positive outward.

        Raises
        ------
        InputError
            If the surface is not known on this grid.
        """

    @property
    def parts(self) -> tuple[Surface, ...]:
        """The surfaces that this one is made of."""
        return tuple(part for value in _fields(self).values() for part in _surfaces_in(value))

    def with_parts(self, parts: Sequence[Surface]) -> Surface:
        """Return the same surface made of other parts, in the order of `parts`.

        Raises
        ------
        InputError
            If the class is neither an attrs class nor a dataclass, and does not override this method.
        """
        what = f"What {type(self).__name__} is made of"
        count = len(self.parts)
        if not isinstance(parts, (tuple, list)):
            raise InputError.about(what, parts, f"a list of {count} surfaces")
        if len(parts) != count:
            raise InputError(f"{what} must be a list of {count} surfaces, but got {len(parts)}.")
        if not parts:
            return self
        new = iter(parts)
        changes: dict[str, Any] = {}
        for name, value in _fields(self).items():
            if isinstance(value, Surface):
                changes[name] = next(new)
            elif _surfaces_in(value):
                changes[name] = type(value)([next(new) for _ in value])
        return _evolve(self, changes)

    @property
    def own_grid(self) -> Grid | None:
        """The only grid on which the heights are known; None if any grid is possible."""
        return next((grid for part in _checked_parts(self) if (grid := part.own_grid) is not None), None)

    @property
    def provenance(self) -> tuple[str, ...]:
        """Origin and processing of the heights, in words; `ContactProblem.explain` prints them."""
        return tuple(text for part in _checked_parts(self) for text in part.provenance)

    @property
    def is_smooth(self) -> bool:
        """Whether the heights have no ridges between points, as bilinear interpolation leaves."""
        return all(part.is_smooth for part in _checked_parts(self))

    def non_measured_on(self, grid: Grid) -> Mask | None:
        """Return which cells are non-measured points, shape `grid.shape`; None if all were measured."""
        return _join(part.non_measured_on(grid) for part in _checked_parts(self))

    def uncertain_on(self, grid: Grid) -> Mask | None:
        """Return which cells the tip of a stylus has not surely touched, shape `grid.shape`; None without a tip."""
        return _join(part.uncertain_on(grid) for part in _checked_parts(self))

    def resample_to(self, grid: Grid, interpolation: str | None = None) -> Surface:
        """Return the surface in a form that is known on another grid over the same domain.

        Height maps are interpolated as by `HeightMap.resample`; by default periodic maps are assumed to be
        band-limited. `InputError` if the surface is not known between the points of its grid.
        """
        check_interpolation(interpolation)
        parts = _checked_parts(self)
        resampled = [part.resample_to(grid, interpolation) for part in parts]
        changed = any(one is not other for one, other in zip(parts, resampled, strict=True))
        result = self.with_parts(resampled) if changed else self
        if result.own_grid is not None and not result.own_grid.matches(grid):
            raise InputError(f"The surface {type(self).__name__} is not known between the points of its grid.")
        return result

    def shift_half_cell(self, grid: Grid, *, periodic: bool) -> Surface:
        """Return the surface moved by half a cell along both axes, in a form that is known on the grid.

        On a periodic domain heights that depend on its size are interpolated. `InputError` if the surface is not known
        between the points of the grid.
        """
        parts = _checked_parts(self)
        name = type(self).__name__
        if parts:
            return self.with_parts([part.shift_half_cell(grid, periodic=periodic) for part in parts])
        if self.own_grid is not None:
            raise InputError(f"The surface {name} is not known between its points, as a periodic height map would be.")
        heights = self.heights(grid)
        inner = _enlarge(self, grid, 2)[1:-1, 1:-1]
        if np.abs(inner - heights).max() <= _HEIGHT_TOLERANCE * max(float(np.ptp(heights)), float(np.ptp(inner))):
            # The heights depend on the position alone: a grid with one more cell along each axis samples them shifted.
            return _Samples(grid, _enlarge(self, grid, 1)[:-1, :-1])
        if not periodic:
            raise InputError(f"The heights of {name} depend on the size of the domain, so it cannot be shifted.")
        return _Samples(grid, shift_by_half_cell(heights, grid))

    def plot(self, grid: Any = None, panel: Any = None, *, axes: Any = None, dark: bool = False) -> Any:
        """Draw the surface (extra ``plot``).

        Parameters
        ----------
        grid
            The cells; None: the surface's own grid. A surface with its own grid also takes the panel first.
        panel
            Registered name or instance of one panel of surfaces; None: the standard ones, side by side.
        axes
            Matplotlib's axes to draw one panel on; None: new ones.
        dark
            Whether the background is dark.

        Returns
        -------
        matplotlib.axes.Axes or matplotlib.figure.Figure
            The axes of one panel, or the figure of several.
        """
        if panel is None and grid is not None and not isinstance(grid, Grid):
            grid, panel = None, grid
        return find_view("panels")("surface", self._sample(grid), panel, axes, flag(dark, "dark="))

    def plot_3d(self, grid: Grid | None = None, *, exaggeration: float | None = None, dark: bool = False) -> Any:
        """Return the heights in three dimensions (extra ``vtk``): a `pyvista.Plotter`, to show or to save.

        Parameters
        ----------
        grid
            The cells; None: the surface's own grid.
        exaggeration
            Factor on the heights; None: 0.12 domains from peak to valley, at most.
        dark
            Whether the background is dark.
        """
        return find_view("surface-3d")(self._sample(grid), exaggeration, dark)

    def _sample(self, grid: Any) -> SampledSurface:
        """Return the heights on a grid, or on its own, with NaN at non-measured points."""
        chosen = self.own_grid if grid is None else grid
        if chosen is None:
            raise InputError("The surface has no grid of its own: give one, rc.Grid(shape, size), first.")
        if not isinstance(chosen, Grid):
            raise InputError.about("The grid", grid, "rc.Grid(shape, size)")
        heights = np.asarray(self.heights(chosen))
        missing = self.non_measured_on(chosen)
        if missing is not None:
            heights = np.where(missing, np.nan, heights)
        return SampledSurface(heights, chosen, bool(getattr(self, "periodic", False)))

    def reseed(self, increment: int) -> Surface | None:
        """Return the surface with `increment` added to each of its random seeds; None if it has none.

        The seed of a surface of your own is its integer field `seed`.
        """
        if isinstance(increment, bool) or not isinstance(increment, (int, np.integer)):
            raise InputError.about("The increment of the seeds", increment, "a whole number")
        parts = _checked_parts(self)
        result = self
        seed: Any = _fields(self).get("seed")
        is_random = isinstance(seed, (int, np.integer)) and not isinstance(seed, bool)
        if is_random:
            result = _evolve(self, {"seed": seed + increment})
        reseeded = [part.reseed(increment) for part in parts]
        if any(part is not None for part in reseeded):
            is_random = True
            result = result.with_parts(
                [part if new is None else new for new, part in zip(reseeded, parts, strict=True)]
            )
        return result if is_random else None

    def __add__(self, other: Surface) -> SurfaceSum:
        """Return the surface whose heights are the sum of both."""
        # A sum and a part make one sum: files hold a limited number of levels.
        parts = self.parts if isinstance(self, SurfaceSum) else (self,)
        return SurfaceSum((*parts, other)) if isinstance(other, Surface) else NotImplemented


surfaces = Registry(Surface, "surface", "roughcontact.surfaces")


@attrs.frozen
class SurfaceSum(Surface):
    """The sum of the heights of several surfaces; ``one + other`` makes it."""

    parts: tuple[Surface, ...]

    def __attrs_post_init__(self) -> None:
        _checked_parts(self)

    @property
    def provenance(self) -> tuple[str, ...]:
        """The provenance of each part, or what the part is."""
        return tuple(text for part in self.parts for text in part.provenance or (_label(part),))

    def heights(self, grid: Grid) -> Array:
        """Return the sum of the heights, shape `grid.shape`, m."""
        total = np.zeros(grid.shape)
        for part in self.parts:
            total += part.heights(grid)
        return total


def _label(part: Surface) -> str:
    return "a height map" if part.own_grid is not None else f"plus {part!r}"


@attrs.frozen(eq=False)
class _Samples(Surface):
    """Heights sampled on a grid, known there alone, shape `own_grid.shape`, m."""

    own_grid: Grid
    values: Array

    def heights(self, grid: Grid) -> Array:
        """Return the samples."""
        if not self.own_grid.matches(grid):
            raise InputError(
                f"Heights known on {self.own_grid} were asked for on {grid}: a surface that moves or stretches its "
                "parts must override `parts` and `shift_half_cell`."
            )
        return self.values


def _fields(surface: Surface) -> dict[str, Any]:
    """Return the arguments of the constructor of a surface by name."""
    if attrs.has(type(surface)):
        return {name: getattr(surface, field.name) for name, field in arguments_of(type(surface)).items()}
    if dataclasses.is_dataclass(surface):
        return {field.name: getattr(surface, field.name) for field in dataclasses.fields(surface) if field.init}
    return dict(getattr(surface, "__dict__", {}))


def _evolve(surface: Surface, changes: dict[str, Any]) -> Surface:
    name = type(surface).__name__
    evolve: Callable[..., Surface]
    if attrs.has(type(surface)):
        evolve = attrs.evolve
    elif dataclasses.is_dataclass(surface):
        evolve = dataclasses.replace
    else:
        raise InputError(
            f"The class {name} is neither an attrs class nor a dataclass, so its {' and '.join(changes)} cannot be "
            f"replaced: make it one, or define {name}.with_parts and {name}.reseed."
        )
    try:
        return evolve(surface, **changes)
    except TypeError as error:
        raise InputError(f"The class {name} does not accept another {' and '.join(changes)}: {error}.") from error


def _surfaces_in(value: object) -> tuple[Surface, ...]:
    if isinstance(value, Surface):
        return (value,)
    if isinstance(value, (tuple, list)) and all(isinstance(item, Surface) for item in value):
        return tuple(value)
    return ()


def _checked_parts(surface: Surface) -> tuple[Surface, ...]:
    parts = surface.parts
    if not isinstance(parts, (tuple, list)) or len(_surfaces_in(parts)) != len(parts):
        raise InputError.about(f"The parts of {type(surface).__name__}", parts, "a tuple of surfaces")
    return tuple(parts)


def _join(masks: Iterable[Mask | None]) -> Mask | None:
    known = [mask for mask in masks if mask is not None]
    return np.logical_or.reduce(known) if known else None


def _enlarge(surface: Surface, grid: Grid, more: int) -> Array:
    """Return the heights on a grid with `more` cells of the same size along each axis."""
    nx, ny = grid.shape
    dx, dy = grid.spacing
    return surface.heights(Grid((nx + more, ny + more), ((nx + more) * dx, (ny + more) * dy)))
