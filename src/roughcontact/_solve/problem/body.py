"""Bodies, and the gap between two of them before they deform."""

from __future__ import annotations

from typing import Any

import attrs
import numpy as np

from roughcontact._base.arrays import Array, Mask, frozen_array
from roughcontact._base.checks import MAX_MAGNITUDE, instance_of
from roughcontact._base.units import outlined
from roughcontact._parts.grid import Grid
from roughcontact._parts.materials import Material, Rigid, resolve_material
from roughcontact._parts.surfaces import FlatSurface, Surface
from roughcontact._solve.convolvers import Convolver, convolvers
from roughcontact.errors import InputError


@attrs.frozen
class Body:
    """One of the two bodies in contact.

    Parameters
    ----------
    surface
        Its heights, positive towards the other body.
    material
        Its elastic constants and hardness: a `Material`, its registered name, or the name of a typical one: bearing,
        structural or stainless steel, grey cast iron, aluminium alloy, copper, brass, titanium alloy, silicon nitride,
        alumina, glass, PTFE, PEEK, rubber.

    Examples
    --------
    >>> import roughcontact as rc
    >>> steel = rc.Elastic(young=210e9, poisson=0.3)
    >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), steel)
    >>> print(ball.material)
    Elastic(young=210000000000.0, poisson=0.3)
    >>> rc.Body(rc.FlatSurface(), "glass").material.pressure_limit
    5500000000.0
    """

    surface: Surface = attrs.field(validator=instance_of(Surface, "The surface of a body", "a Surface"))
    material: Material = attrs.field(converter=resolve_material)

    def heights(self, grid: Grid) -> Array:
        """Return the heights of the surface at the cell centres, shape `grid.shape`, m.

        Raises
        ------
        InputError
            If the surface does not give finite real heights of that shape.
        """
        return _check_heights(self.surface, grid, self.surface.heights(grid))

    def non_measured(self, grid: Grid) -> Mask | None:
        """Return which cells are non-measured points, shape `grid.shape`; None if all were measured."""
        mask = self._check_mask("non_measured_on", grid)
        return mask if mask is not None and mask.any() else None

    def uncertain(self, grid: Grid) -> Mask | None:
        """Return which cells the tip of a stylus has not surely touched, shape `grid.shape`; None without a tip."""
        return self._check_mask("uncertain_on", grid)

    def _check_mask(self, method: str, grid: Grid) -> Mask | None:
        """Return the mask that a method of the surface gives; `InputError` unless it is one of the grid's shape."""
        mask: Any = getattr(self.surface, method)(grid)
        if mask is not None and not (isinstance(mask, np.ndarray) and mask.dtype == bool and mask.shape == grid.shape):
            name = type(self.surface).__name__
            raise InputError.about(f"{name}.{method}(grid)", mask, f"None or booleans of shape {grid.shape}")
        return mask

    @property
    def own_grid(self) -> Grid | None:
        """The only grid on which the surface is known; None if any grid is possible."""
        grid = self.surface.own_grid
        if grid is not None and not isinstance(grid, Grid):
            raise InputError.about(f"{type(self.surface).__name__}.own_grid", grid, "a Grid or None")
        return grid

    @property
    def provenance(self) -> tuple[str, ...]:
        """Origin and processing of the heights, in words."""
        texts = self.surface.provenance
        if not isinstance(texts, tuple) or not all(isinstance(text, str) for text in texts):
            raise InputError.about(f"{type(self.surface).__name__}.provenance", texts, "a tuple of texts")
        return texts


RIGID_FLAT = Body(FlatSurface(), Rigid())


@attrs.frozen(eq=False)
class InitialGap:
    """The gap between two bodies whose summits just touch, before they deform.

    Attributes
    ----------
    values
        Gap, shape (nx, ny), m, at least zero; at non-measured points larger than anywhere else.
    summit
        Maximum of the sum of both heights, m.
    non_measured
        Points that were not measured on one of the bodies, shape (nx, ny); None if there are none.
    """

    values: Array = attrs.field(repr=outlined)
    summit: float
    non_measured: Mask | None = attrs.field(repr=outlined)

    def sum_non_measured(self, pressure: Array) -> float:
        """Return the sum of the pressure, shape (nx, ny), at non-measured points."""
        return 0.0 if self.non_measured is None else float(pressure[self.non_measured].sum())

    def change(self, offset: Array) -> tuple[InitialGap, float]:
        """Return the gap plus an offset, shape (nx, ny), m, from its first touch, and how much later that is, m."""
        values = self.values + offset
        datum = float(values.min() if self.non_measured is None else values[~self.non_measured].min())
        return attrs.evolve(self, values=frozen_array(values - datum)), datum

    def with_depth(self, depth: float) -> InitialGap:
        """Return the same gap with the non-measured points at `depth`, m."""
        return attrs.evolve(self, values=frozen_array(np.where(np.asarray(self.non_measured), depth, self.values)))


def _check_heights(surface: Surface, grid: Grid, values: Array) -> Array:
    """Return the heights that a surface gave; `InputError` unless they are finite and real, of the grid's shape."""
    heights = np.asarray(values)
    name = type(surface).__name__
    if heights.shape != grid.shape or heights.dtype.kind != "f":
        raise InputError(
            f"The surface {name} must give real heights of shape {grid.shape}, "
            f"but gave an array of shape {heights.shape} and type {heights.dtype}."
        )
    # This needs no temporary of the grid's size, and NaN fails both comparisons.
    if not (heights.min() >= -MAX_MAGNITUDE and heights.max() <= MAX_MAGNITUDE):
        raise InputError(f"The surface {name} gave heights that are not finite, or above {MAX_MAGNITUDE:g} m.")
    return heights


def find_initial_gap(
    body: Body,
    counterbody: Body,
    grid: Grid,
    convolver: str | Convolver = "auto",
    shift: tuple[int, int] = (0, 0),
) -> InitialGap:
    """Return the initial gap between two bodies on a grid, whose heights the convolver makes if it is given.

    The counterbody is displaced by cells (x, y), periodically. `InputError` if a surface does not give heights on the
    grid, or no point was measured on both.
    """
    maker = None if convolver == "auto" else convolvers.resolve(convolver)

    def make(surface: Surface) -> Array:
        heights = surface.heights(grid) if maker is None else maker.heights(surface, grid)
        return _check_heights(surface, grid, heights)

    def place(field: Any) -> Any:
        return field if field is None or shift == (0, 0) else np.roll(field, shift, axis=(0, 1))

    total = make(body.surface) + place(make(counterbody.surface))
    sides = (body.non_measured(grid), place(counterbody.non_measured(grid)))
    masks = [mask for mask in sides if mask is not None]
    if not masks:
        summit = float(total.max())
        return InitialGap(frozen_array(np.subtract(summit, total, out=total)), summit, None)
    non_measured = np.logical_or.reduce(masks)
    if non_measured.all():
        raise InputError("Nowhere do measured points of the two bodies face each other.")
    summit = float(total[~non_measured].max())
    gap = InitialGap(frozen_array(np.subtract(summit, total, out=total)), summit, non_measured)
    deepest = float(gap.values[~non_measured].max())
    return gap.with_depth(2.0 * deepest or min(grid.spacing))
