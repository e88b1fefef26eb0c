"""Height maps: measured or computed heights on a grid of their own."""

from __future__ import annotations

import math
from collections.abc import Sequence

import attrs
import numpy as np
import numpy.typing as npt

from roughcontact.checks import Array, Mask, Pair, choice, heights_array, integer, pair
from roughcontact.errors import InputError
from roughcontact.grid import Grid
from roughcontact.surfaces import form as form_of
from roughcontact.surfaces.base import Surface
from roughcontact.surfaces.resampling import between, bilinear, block_mean, fourier
from roughcontact.units import si


def _told(_: object, __: object, value: object) -> None:
    if not isinstance(value, tuple) or not all(isinstance(text, str) for text in value):
        raise InputError.about("The history of a height map", value, "a tuple of texts")


# Beyond this a polynomial follows the roughness, and its normal equations lose their digits.
_HIGHEST_DEGREE = 30
_DEGREES = {"mean": 0, "plane": 1}


def _size(value: float | Sequence[float]) -> Pair:
    return pair(value, "The size of the height map", "m", above=0.0)


def _holes(value: npt.ArrayLike | None) -> Mask | None:
    if value is None:
        return None
    try:
        mask = np.array(value)
    except ValueError:
        raise InputError("The holes of a height map must be a rectangular array, but their rows differ.") from None
    if mask.dtype.kind != "b" or mask.ndim != 2:
        raise InputError.about("The holes of a height map", mask.dtype, "an array of booleans of the map's shape")
    if mask.all():
        raise InputError("The height map is all holes: at least one point must have been measured.")
    mask.flags.writeable = False
    return mask if mask.any() else None


def _resampled(values: Array, shape: tuple[int, int], method: str, periodic: bool) -> Array:
    if method == "fourier":
        return fourier(values, shape)
    if method == "mean":
        return block_mean(values, shape)
    if method == "bilinear":
        return bilinear(values, shape, periodic=periodic)
    i, j = ((np.arange(new) + 0.5) * (old / new) - 0.5 for new, old in zip(shape, values.shape, strict=True))
    return between(values, i[:, np.newaxis], j[np.newaxis, :], method, periodic=periodic)


@attrs.frozen(eq=False)
class HeightMap(Surface):
    """Heights given as an array, one value for each cell.

    Parameters
    ----------
    heights
        Heights, shape (nx, ny), indexed [x, y], m, positive outward, finite; a copy is kept.
    size
        Sides of the measured domain (x, y) or of both, m.
    periodic
        Whether the map goes on with its own copy beyond the border.
    holes
        Points that were not measured and are not to touch, shape (nx, ny), true there. The heights given
        for them only serve to interpolate in their neighbourhood: in contact they lie as deep as it takes.
    history
        What was done to the map so far, in words; ``explain()`` of a problem prints it.

    Raises
    ------
    InputError
        If the heights are not a two-dimensional array of at least two finite numbers, or the holes
        leave nothing or have another shape.
    """

    _heights: Array = attrs.field(converter=heights_array, alias="heights")
    size: Pair = attrs.field(converter=_size)
    periodic: bool = attrs.field(default=False, kw_only=True, validator=attrs.validators.instance_of(bool))
    holes: Mask | None = attrs.field(default=None, kw_only=True, converter=_holes)
    history: tuple[str, ...] = attrs.field(default=(), kw_only=True, validator=_told)

    def __attrs_post_init__(self) -> None:
        if self.holes is not None and self.holes.shape != self._heights.shape:
            raise InputError(f"The holes have shape {self.holes.shape}, but the heights {self._heights.shape}.")

    @property
    def grid(self) -> Grid:
        """The grid on which the map is given."""
        return Grid(self._heights.shape, self.size)

    @property
    def values(self) -> Array:
        """The heights as given, shape (nx, ny), m, read-only."""
        return self._heights

    def heights(self, grid: Grid) -> Array:
        """Return the heights, shape `grid.shape`, m.

        Raises
        ------
        InputError
            If the grid is not the map's own: a map is resampled only when asked.
        """
        if not self.grid.matches(grid):
            raise InputError(
                f"The height map is given on {self.grid}, but was asked for on {grid}. "
                f"Call .resample({grid.shape}) first, bring maps of two domains together with match(), or use the "
                "map's own grid."
            )
        return self._heights

    def holes_on(self, grid: Grid) -> Mask | None:
        """Return the holes on the map's own grid, shape (nx, ny); None if there are none."""
        return self.holes

    def resample(self, shape: Sequence[int], method: str = "bilinear") -> HeightMap:
        """Return the map on another number of cells over the same domain.

        Parameters
        ----------
        shape
            Number of cells (nx, ny) of the new map.
        method
            ``"bilinear"``: interpolation between cell centres, as image scaling does it and as the
            paper scaled its measured maps; it aliases when coarsening. ``"cubic"``: by cubic splines, as
            coarse but smooth. ``"fourier"``: exact for band-limited periodic maps. ``"mean"``: mean over
            whole blocks of cells.

        Raises
        ------
        InputError
            If the method is unknown, is ``"fourier"`` on a map that is not periodic, or is
            ``"mean"`` and the new cell counts do not divide the old ones.
        """
        target = Grid(shape, self.size).shape
        choice(method, "The resampling method", ("bilinear", "cubic", "fourier", "mean"))
        if method == "fourier" and not self.periodic:
            raise InputError("Fourier resampling needs a periodic map: use 'bilinear', or periodic=True if it is one.")
        if method == "mean" and any(old % new for old, new in zip(self._heights.shape, target, strict=True)):
            raise InputError(
                f"Block means need cell counts that divide {self._heights.shape}, but got {target}; use 'bilinear'."
            )
        values = _resampled(self._heights, target, method, self.periodic)
        holes = None
        if self.holes is not None:
            # A new point is missing where more than half of what it would be made of is.
            near = "mean" if method == "mean" else "bilinear"
            holes = _resampled(self.holes.astype(np.float64), target, near, self.periodic) > 0.5
        pitch = " x ".join(si(step, "m") for step in Grid(target, self.size).spacing)
        done = f"resampled ({method}) to {target[0]} x {target[1]} cells of {pitch}"
        return attrs.evolve(self, heights=values, holes=holes, history=(*self.history, done))

    def separate(self, form: str | int = "plane") -> Separated:
        """Tell the form of the map from its roughness by least squares; points in holes do not count.

        Parameters
        ----------
        form
            ``"mean"``, ``"plane"``, ``"sphere"``, or the total degree of a polynomial: 0 is the mean, 1
            the plane, 2 has curvature and twist as well, ...

        Raises
        ------
        InputError
            If there is no such form, or the map has too few points or no cap of a sphere for it.
        """
        degree = _DEGREES.get(form, form) if isinstance(form, str) else form
        curvature = 0.0
        if degree == "sphere":
            if min(self._heights.shape) < 3:
                raise InputError("A sphere needs at least three cells along each axis.")
            fitted, curvature = form_of.sphere(self._heights, self.grid.x, self.grid.y, self.holes)
            text = f"the best sphere taken away, of radius {si(1 / curvature if curvature else math.inf, 'm', 4)}"
        else:
            if isinstance(degree, str):
                raise InputError.about("The form", form, "'mean', 'plane', 'sphere' or the degree of a polynomial")
            degree = integer(degree, "The degree of the trend", at_least=0)
            if degree > _HIGHEST_DEGREE:
                raise InputError.about("The degree of the trend", degree, f"at most {_HIGHEST_DEGREE}")
            if min(self._heights.shape) <= degree:
                raise InputError(f"A trend of degree {degree} needs more than {degree} cells along each axis.")
            fitted = form_of.polynomial(self._heights, degree, self.holes)
            name = {0: "mean", 1: "plane"}.get(degree, f"polynomial of degree {degree}")
            text = f"the best {name} taken away"
        return Separated(
            form=attrs.evolve(
                self, heights=fitted, holes=None, periodic=False, history=(*self.history, "its form only")
            ),
            roughness=attrs.evolve(self, heights=self._heights - fitted, history=(*self.history, text)),
            radius=1.0 / curvature if curvature else math.inf,
        )

    def detrend(self, form: str | int = 1) -> HeightMap:
        """Return the map less its form; see `separate`."""
        return self.separate(form).roughness


@attrs.frozen(eq=False, kw_only=True)
class Separated:
    """A height map taken apart; both parts added give it back.

    Attributes
    ----------
    form
        The fitted form on the map's grid.
    roughness
        What is left, with the holes of the map.
    radius
        Radius of the sphere, m, negative for a bowl; infinite for other forms.
    """

    form: HeightMap
    roughness: HeightMap
    radius: float
